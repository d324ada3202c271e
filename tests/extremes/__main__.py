"""The command: ``python -m tests.extremes``, from the folder that holds ``tests``.

Exit status: 0 nothing failed, 2 bad input, 3 something FAILED, 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.extremes.harness import FAILED, as_json, extremes, report
from varcontact.errors import Interrupted, VarcontactError
from varcontact.system.files import check_writable


def main(arguments: Sequence[str] | None = None) -> int:
    """Solve the scenes, print the table, and return the exit status."""
    chosen = _parser().parse_args(arguments)
    show = as_json if chosen.json else report
    try:
        if chosen.out is not None:
            check_writable("--out", chosen.out, (".csv",))
        table = extremes(short=chosen.short, only=chosen.only, store=chosen.out, progress=_tell)
    except Interrupted as stopped:
        if len(stopped.partial):
            print(show(stopped.partial))
        kept = "" if chosen.out is None else f"; what is finished is kept in {chosen.out}"
        print(f"extremes: interrupted{kept}", file=sys.stderr)
        return 130
    except VarcontactError as error:
        print(f"extremes: {error}", file=sys.stderr)
        return 2
    print(show(table))
    failed = int((table["verdict"] == FAILED).sum())
    if failed:
        print(f"extremes: {failed} of {len(table)} FAILED", file=sys.stderr)
    return 3 if failed else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.extremes", description="Solve scenes at the extremes by every family of solvers."
    )
    parser.add_argument("--short", action="store_true", help="some scenes of each group only")
    parser.add_argument("--only", default="", metavar="WORDS", help="only scenes with this in their name or group")
    parser.add_argument(
        "--out", type=Path, metavar="CSV", help="table; scenes that it has already are not solved again"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON array instead of the tables")
    return parser


def _tell(stage: str) -> None:
    """The scene being solved, on one line of standard error, where that is a terminal."""
    if sys.stderr.isatty():
        print(f"\r\x1b[K{stage}", end="", file=sys.stderr, flush=True)


if __name__ == "__main__":  # the harness's worker processes import this module anew
    raise SystemExit(main())
