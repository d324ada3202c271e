"""How far kinds are known: the numbers of `python -m tests.smear` may only fall."""

import json
from pathlib import Path

import pytest

from tests.smear import KINDS, OTHER_MEANINGS, ROOT, found

DATA = Path(__file__).parent / "data"


@pytest.mark.parametrize("kind", KINDS)
def test_no_kind_is_known_in_more_files(kind):
    """`tests/data/smear.json` has the numbers of files by kind."""
    known = json.loads((DATA / "smear.json").read_text())
    files = found(kind)
    assert len(files) <= known[kind], files


def test_homes_and_exceptions_are_there():
    assert all((ROOT / name).exists() for _, name in OTHER_MEANINGS)


def test_the_command_finds_what_it_is_for():
    assert "results/report.py" in found("third body")
    assert not any(name.startswith("scene/") for kind in KINDS for name in found(kind))
