"""Deliberate breaks of the package, and the tests that have to catch them: ``python -m tests.breaks
[NAME ...]``.

Each break is made in a copy of the repository, where its tests run until the first failure. What
was found is kept in tests/data/breaks.json beside their list, and makes the table of
docs/robustness.md.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "tests" / "data" / "breaks.json"
PAGE = ROOT / "docs" / "robustness.md"
MARKED = re.compile(r"(<!-- breaks -->\n).*(<!-- end of breaks -->)", re.DOTALL)
FAILED = 1
"""What pytest returns where tests fail; any other number but 0 says that they did not run."""


@dataclass(frozen=True)
class Break:
    """What is wrong, the file of the package, its text with what stands there instead, and the
    tests.
    """

    name: str
    file: str
    old: str
    new: str
    tests: list[str]


BREAKS = tuple(
    Break(**each) for each in tomllib.loads(RESULTS.with_suffix(".toml").read_text())["breaks"]
)


def broken(each: Break, tree: Path) -> None:
    """Make a break in a copy; the old text has to occur once."""
    path = tree / "varcontact" / each.file
    text = path.read_text()
    assert text.count(each.old) == 1, each.name
    path.write_text(text.replace(each.old, each.new))


def caught_by(each: Break) -> str:
    """The first test that fails with a break; empty where none does."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(
            ROOT, tree, ignore=shutil.ignore_patterns(".git", "__pycache__", "made", "_build")
        )
        broken(each, tree)
        call = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-rfE",
            "-n",
            "0",
            "-p",
            "no:cacheprovider",
            "-m",
            "not long",
        ]
        environment = {**os.environ, "PYTHONPATH": str(tree), "MPLBACKEND": "Agg"}
        tests = [f"tests/{test}" for test in each.tests]
        ended = subprocess.run(
            [*call, *tests], cwd=tree, env=environment, capture_output=True, text=True
        )
    if ended.returncode not in (0, FAILED):
        raise RuntimeError(f"{each.name}: the tests did not run\n{ended.stdout[-2000:]}")
    if ended.returncode == 0:
        return ""
    first = re.search(r"^(?:FAILED|ERROR) tests/([^\s\[]+)", ended.stdout, re.MULTILINE)
    return first.group(1) if first else "?"


def table(found: list[dict[str, str]]) -> str:
    rows = [
        f"| {row['break']} | `{row['file']}` | {row['caught by'] or 'not caught'} |"
        for row in found
    ]
    return "\n".join(["| break | file | first test that fails |", "|---|---|---|", *rows])


def main(names: list[str]) -> int:
    """Try the breaks whose names hold one of the words, or all, and keep the results."""
    known = json.loads(RESULTS.read_text())["breaks"] if RESULTS.exists() else []
    rows = {row["break"]: row for row in known}
    for each in BREAKS:
        if not names or any(word in each.name for word in names):
            test = caught_by(each)
            rows[each.name] = {"break": each.name, "file": each.file, "caught by": test}
            print(f"{'caught' if test else 'NOT CAUGHT':10}  {each.name}: {test}", flush=True)
    found = [rows[each.name] for each in BREAKS if each.name in rows]
    RESULTS.write_text(
        json.dumps({"date": date.today().isoformat(), "breaks": found}, indent=1) + "\n"
    )
    PAGE.write_text(
        MARKED.sub(lambda marks: f"{marks[1]}{table(found)}\n{marks[2]}", PAGE.read_text())
    )
    return sum(not row["caught by"] for row in found)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
