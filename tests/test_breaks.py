"""The list of deliberate breaks fits the package, all were caught; the tables of the pages are the
kept results.
"""

import json

import pytest

from tests.benchmarks.table import DOCS, filled, pages
from tests.breaks import BREAKS, PAGE, RESULTS, ROOT, table


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


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(DOCS).as_posix())
def test_the_tables_of_a_page_are_those_of_the_results(page):
    assert filled(page.read_text()) == page.read_text()
    assert page != PAGE or table(json.loads(RESULTS.read_text())["breaks"]) in page.read_text()
