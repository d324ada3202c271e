"""Mutants are made where they are meant, caught by a test that sees them, and restored after."""

import json

import pytest

from tests import mutants
from tests.mutants import ROOT, Ledger, Limits, Mutant, caught_by, mutants_of, verdict

TOY = '''\
def largest(a, b):
    """The larger of two numbers."""
    return a if a > b else b


def opposite(a):
    return -a
'''
TEST = """\
from varcontact.toys.toy import largest, opposite


def test_largest():
    assert largest(1, 2) == largest(2, 1) == 2


def test_opposite():
    assert opposite(3) == -3
"""
OPERATIONS = '''\
"""Words 1 + 1."""
area: float = 2 * 3


def f(a, b):
    if not a and a <= b < 1:
        raise ValueError("n" * (a + 1))
    a -= min(2 * b, 0.5)
    return f"{a + 1}" + (a) / (b) ** 2
'''


@pytest.fixture
def toys(tmp_path):
    """A package of two functions with its tests."""
    files = {
        "varcontact/__init__.py": "",
        "varcontact/toys/toy.py": TOY,
        "tests/toys/test_toy.py": TEST,
    }
    for file, text in files.items():
        path = tmp_path / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return tmp_path


def test_every_kind_of_mutant_is_made_and_texts_are_left(tmp_path):
    (tmp_path / "m.py").write_text(OPERATIONS)
    found = {(each.line, each.after) for each in mutants_of(tmp_path, "m.py")}
    assert found == {
        (6, "if a and a <= b < 1:"),
        (6, "if not a or a <= b < 1:"),
        (6, "if not a and a < b < 1:"),
        (6, "if not a and a <= b <= 1:"),
        (8, "a += min(2 * b, 0.5)"),
        (8, "a -= max(2 * b, 0.5)"),
        (8, "a -= min(3 * b, 0.5)"),
        (8, "a -= min(2 / b, 0.5)"),
        (9, 'return f"{a + 1}" - (a) / (b) ** 2'),
        (9, 'return f"{a + 1}" + (a) * (b) ** 2'),
        (9, 'return f"{a + 1}" + (a) / (b) ** 3'),
    }


@pytest.mark.long
def test_a_mutant_without_end_is_caught_by_its_time(toys):
    (toys / "varcontact/toys/toy.py").write_text("n = 3\nwhile n > 0:\n    n -= 1\n")
    (toys / "tests/toys/test_toy.py").write_text("import varcontact.toys.toy\n\ndef test(): pass\n")
    endless = mutants_of(toys, "varcontact/toys/toy.py")[1]
    assert endless.after == "n += 1"
    known = Limits(toys)
    known.known[("tests/toys",)] = 2
    assert caught_by(endless, toys, [["tests/toys"]], known) == "time limit"


def test_mutants_of_the_package_are_where_they_are_meant():
    """An influence number with a wrong sign: its line alone changes."""
    file = "varcontact/elasticity/halfspace.py"
    source = (ROOT / file).read_bytes()
    sign = next(
        each for each in mutants_of(ROOT, file) if each.after == each.before.replace("-K", "K")
    )
    number = sign.line - 1
    assert source.decode().splitlines()[number].strip() == sign.before
    assert sign.written(source).decode().splitlines()[number].strip() == sign.after


def test_results_are_kept_where_lines_move(tmp_path):
    mutant = Mutant("varcontact/toys/toy.py", "f", 3, "a < b", "a <= b", 0, 1, b"")
    moved = Mutant("varcontact/toys/toy.py", "f", 9, "a < b", "a <= b", 7, 8, b"")
    ledger = Ledger(tmp_path / "mutants.json")
    ledger.keep(mutant, "")
    ledger.of(mutant)["equivalent"] = "equal values are the same"
    ledger.keep(moved, "")
    (record,) = Ledger(tmp_path / "mutants.json").records
    assert record["line"] == 9
    assert verdict(record) == "equivalent"


@pytest.mark.long
def test_a_wrong_sign_is_caught_and_an_equivalent_comparison_survives(toys, monkeypatch, capsys):
    """By the command, which continues where it was and counts what is judged equivalent."""
    monkeypatch.setattr(mutants, "ROOT", toys)
    results = toys / "mutants.json"
    command = ["--rooms", "toys", "--quick", "--results", str(results)]
    assert mutants.main(command) == 1
    shown = capsys.readouterr().out
    assert "caught      varcontact/toys/toy.py:7  tests/toys/test_toy.py::test_opposite" in shown
    survivors = shown[shown.index("survivors\n") :]
    assert "- return a if a > b else b\n    + return a if a >= b else b" in survivors
    assert survivors.splitlines()[-1].split() == ["toys", "2", "1", "0", "1"]
    assert (toys / "varcontact/toys/toy.py").read_text() == TOY

    records = json.loads(results.read_text())
    records[0]["equivalent"] = "equal numbers are the same"
    results.write_text(json.dumps(records))
    monkeypatch.setattr(mutants, "failure", None)  # nothing is run again
    assert mutants.main(command) == 0
    assert capsys.readouterr().out.splitlines()[-1].split() == ["toys", "2", "1", "1", "0"]
