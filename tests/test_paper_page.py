"""The page on the paper is true: its names exist, its tests exist, its examples are run by tests."""

import dataclasses
import importlib
import re
from pathlib import Path

import pytest

import varcontact as vc

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "paper.md").read_text()
THEORY = (ROOT / "docs" / "theory.md").read_text()
NAMES = sorted(set(re.findall(r"`((?:vc|varcontact)\.[\w.]+)`", PAGE + THEORY)))
TESTS = sorted(set(re.findall(r"`(tests/[\w/]+\.py)(?:::(\w+))?`", PAGE)))
EXAMPLES = sorted(set(re.findall(r"\[`(\w+)`\]\(gallery/(\w+)\.md\)", PAGE)))
ROWS = [line for line in PAGE.splitlines() if line.startswith("| ")]


def numbers(text):
    """Figures of a row's first cell: "22, 23" and "30 to 33"."""
    first, *rest = re.findall(r"\d+", text)
    if " to " in text:
        return range(int(first), int(rest[0]) + 1)
    return [int(each) for each in (first, *rest)]


@pytest.mark.parametrize("name", NAMES)
def test_a_name_on_the_page_exists(name):
    """As an attribute of a module or a class, or as a field of a dataclass."""
    parts = name.split(".")[1:]
    found = vc
    path = "varcontact"
    for part in parts:
        path += f".{part}"
        if dataclasses.is_dataclass(found) and part in {
            each.name for each in dataclasses.fields(found)
        }:
            break
        if not hasattr(found, part):
            importlib.import_module(path)
        found = getattr(found, part)


@pytest.mark.parametrize(("file", "test"), TESTS)
def test_a_test_on_the_page_exists(file, test):
    text = (ROOT / file).read_text()
    assert not test or f"def {test}(" in text


def test_every_example_on_the_page_is_run():
    """By tests/test_examples.py, which runs each and holds it to a number."""
    told = (ROOT / "tests" / "test_examples.py").read_text()
    run = set(re.findall(r"\b(?:script|ran|solved)\(\s*\"(\w+)\"", told))
    assert EXAMPLES
    for shown, page in EXAMPLES:
        assert shown == page
        assert page in run


def test_every_figure_and_table_has_a_row():
    figures = PAGE.split("## Figures")[1].split("\n## ")[0]
    cells = re.findall(r"^\| (\d[\d, to]*) \|", figures, re.MULTILINE)
    assert sorted(number for cell in cells for number in numbers(cell)) == list(range(1, 38))
    for table in range(1, 5):
        assert any(row.startswith(f"| Table {table},") for row in ROWS)


def test_every_section_has_a_table():
    for section in range(1, 8):
        assert f"\n## Section {section}:" in PAGE


def test_every_method_has_a_link():
    """To its place in the interface, to a page or to an example."""
    sections = PAGE.split("## Figures")[0]
    for row in re.findall(r"^\| (?!paper|---)(.*)\|$", sections, re.MULTILINE):
        here = row.split(" | ")[1].strip(" |")
        assert "](" in here or here == "not offered", row
