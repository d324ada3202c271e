"""The list of deliberate breaks fits the package, and all of them were caught."""

import json

import pytest

from tests.breaks import BREAKS, RESULTS, ROOT


@pytest.mark.parametrize("each", BREAKS, ids=lambda each: each.name)
def test_a_break_can_be_made(each):
    """Its old text stands once in its file, and its tests are there."""
    assert (ROOT / "varcontact" / each.file).read_text().count(each.old) == 1
    assert each.new != each.old
    assert all((ROOT / "tests" / test).is_file() for test in each.tests)


def test_every_break_was_caught():
    found = {row["break"]: row["caught by"] for row in json.loads(RESULTS.read_text())["breaks"]}
    assert list(found) == [each.name for each in BREAKS]
    assert all(found.values())
