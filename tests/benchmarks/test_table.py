"""Pages show the tables of the kept results."""

import pytest

from tests.benchmarks.table import DOCS, filled, pages


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.relative_to(DOCS).as_posix())
def test_the_tables_of_a_page_are_those_of_the_results(page):
    assert filled(page.read_text()) == page.read_text()
