"""``python -m tests.extremes``: what it prints, its table file, its exit statuses."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.extremes import __main__ as command
from tests.extremes.harness import extremes

ROOT = Path(__file__).parents[2]


def test_table_is_printed_and_gone_on_with(tmp_path, capsys):
    """The first run as a process, the second from the table that the first has written."""
    only = ["--only", "approach 1e-12", "--out", str(tmp_path / "table.csv")]
    arguments = [sys.executable, "-m", "tests.extremes", *only]
    done = subprocess.run(arguments, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "pressing, approach 1e-12" in done.stdout and "0 FAILED" in done.stdout
    assert command.main([*only, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    assert {row["verdict"] for row in rows} == {"passed"}
    assert {row["family"] for row in rows} >= {"default", "conic", "active set"}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--only", "nonsense"], "only = 'nonsense' is not allowed"),
        (["--only", "approach 1e-12", "--out", "none/table.csv"], "--out"),
    ],
)
def test_bad_input(arguments, words, capsys):
    assert command.main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and words in printed.err


def test_failures_have_an_exit_status_of_their_own(tmp_path, capsys):
    """Of a table in which one answer is called FAILED."""
    store = tmp_path / "table.csv"
    extremes(only="approach 1e-12", store=store)
    store.write_text(store.read_text().replace("default,passed", "default,FAILED", 1))
    assert command.main(["--only", "approach 1e-12", "--out", str(store)]) == 3
    printed = capsys.readouterr()
    assert "1 FAILED" in printed.out and printed.err.startswith("extremes: 1 of ")
