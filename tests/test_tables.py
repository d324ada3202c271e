"""The tables of the pages are those of the kept results."""

import json

import pytest

from tests.benchmarks.table import DOCS, filled, pages
from tests.breaks import PAGE, RESULTS, table


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(DOCS).as_posix())
def test_the_tables_of_a_page_are_those_of_the_results(page):
    assert filled(page.read_text()) == page.read_text()


def test_the_table_of_breaks_is_that_of_the_results():
    assert table(json.loads(RESULTS.read_text())["breaks"]) in PAGE.read_text()
