"""How far kinds are known: the numbers of `python -m tests.smear` may only fall."""

import json
from pathlib import Path

from tests.smear import KINDS, OTHER_MEANINGS, ROOT, found

DATA = Path(__file__).parent / "data"


def test_no_kind_is_known_in_more_files():
    """`tests/data/smear.json` has the numbers of files by kind; scenes are a home of all kinds."""
    known = json.loads((DATA / "smear.json").read_text())
    files = {kind: found(kind) for kind in KINDS}
    assert {kind: names for kind, names in files.items() if len(names) > known[kind]} == {}
    assert "results/solution.py" in files["third body"]
    assert not any(name.startswith("scene/") for names in files.values() for name in names)


def test_homes_and_exceptions_are_there():
    assert all((ROOT / name).exists() for _, name in OTHER_MEANINGS)
