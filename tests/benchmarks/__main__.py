"""Benchmarks, and the tables that the pages make of them.

    python -m tests.benchmarks GROUP [TABLE ...] [--quick]
    python -m tests.benchmarks --list
    python -m tests.benchmarks tables

A run prints its tables and keeps their figures in tests/benchmarks/results/GROUP.json; `tables`
writes what is kept into the pages, between their markers. With `--quick`, small sizes and few
scenes: printed, and not kept.
"""

import argparse
import importlib
import sys
import warnings

from tests.benchmarks.table import filled, keep, pages

GROUPS = (
    "accuracy",
    "bars",
    "speed",
    "front",
    "fit",
    "interop",
    "balance",
    "claims",
    "shakedown",
    "splitting",
    "solvers",
    "gradients",
    "bodies",
)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("group", nargs="?", choices=(*GROUPS, "tables"))
    parser.add_argument("names", nargs="*", metavar="TABLE")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--quick", action="store_true")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    if given.list:
        for group in GROUPS:
            for name, measure in importlib.import_module(
                f"tests.benchmarks.{group}"
            ).TABLES.items():
                print(f"{group} {name}: {(measure.__doc__ or '').splitlines()[0]}")
    elif given.group == "tables":
        for page in pages():
            page.write_text(filled(page.read_text()))
    elif given.group:
        known = importlib.import_module(f"tests.benchmarks.{given.group}").TABLES
        if set(given.names) - set(known):
            sys.exit(f"tables of {given.group}: {', '.join(known)}")
        for name in given.names or known:
            table = known[name](given.quick)
            print(f"{name}\n{table.markdown}\n", flush=True)
            if not given.quick:
                keep(given.group, name, table)
    else:
        parser.print_help()


if __name__ == "__main__":
    main()
