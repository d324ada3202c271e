"""Every control digit of CONTACT's input files, with every value: it is read with its lines, or
refused by name and line.
"""

import numpy as np
import pytest

import varcontact as vc
from varcontact.io.contact_grammar import BASIC, BASIC_LINES, WHEEL, WHEEL_LINES
from varcontact.wheel_rail import read_contact_input as read_wheels

LAWS = {0: "0.3 0.3", 2: "0.2 0.1 50. 0. 1.", 3: "0.2 0.1 50. 0. 1.", 4: "0.2 0.1 50. 0. 1."}
LAWS |= {6: "0.3 0. -.1 400."}
ENTRIES = {
    "debug": "0000000",
    "iterations": "100 100 30 1 1e-6",
    "relaxation": "1. 0.05 1 1.",
    "initial slip": "1 1.",
    "gdsteady": "1. 1. 1 1. 0. 1. 1. 0.9",
    "influence": "'numbers.txt'",
    "material": "0.28 0.28 82000. 82000.",
    "sheet": "1e-6",
    "viscoelastic": "1. 1. 0.01 0.01",
    "flexibility": "1e-6 1. 1. 1.",
    "slope": "1. 1. 1.",
    "layer": "8200. 0.01 50. 0.",
    "damping": "1. 1. 1e3 1e3",
    "heat 1": "0. 450. 0.05 7.85e-6",
    "heat 2": "0. 450. 0.05 7.85e-6",
    "plastic work": "1.",
    "stresses": "1 1\n 1\n 2 0. 0.5\n 0",
    "rolling": "0. 0.1 1000.",
    "elements": "1\n 9 7 -0.45 -0.35 0.1 0.1",
    "distance": "1 1\n 0.005 0. 0.005 0. 0. 0.",
    "extra slip": "126*0.0001",
    "grid": "1. 1. 1. 90d 8. 4.",
    "rail": "'rail.csv' 0 1. 0. -1",
    "wheel": "'wheel.csv' 0 1. 0. -1",
    "deviations": "6*0.",
    "springs": "1e4 0. 1e5 0.",
    "wheel set": "1360. -70. 460.",
    "wheel place": "6*0.",
    "wheel rates": "6*0.",
}
HERTZ = "-3\n 9 7 0.4 0.4 1.2"
PLAIN = {3: ("203100", "0022020", "00000001"), 1: ("1203100", "0022033", "00000001")}
WORDS = {3: (BASIC, BASIC_LINES), 1: (WHEEL, WHEEL_LINES)}


def values_of(digit):
    """All that are read or refused by name, and one that the format has not."""
    named = {*digit.read, *digit.refused}
    return [*sorted(named), *sorted(set(range(10)) - named)[:1]]


CHOICES = [
    (module, digit, value)
    for module, (words, _) in WORDS.items()
    for digits in words
    for digit in digits
    for value in values_of(digit)
]
NEEDING = {
    # Hertz's contact, a file of numbers, temperatures, and what the case before has
    3: {"M5", "C9", "L6", "H1", "E1", "S1", "S2"},
    1: {"M5", "L6", "H1", "S1", "S2"},
}


class Digits(dict):
    """Values by name, as `Controls` has them."""

    damping = 0

    @property
    def rolls(self):
        return self["TANG"] in (2, 3)


def entries_of(key, digits, module):
    """The entries of a line, of a contact that is small."""
    if key == "kinematics":
        load = {0: "0.0005", 1: "100."}[digits["NORM"]]
        rigid = {0: "0.0001 0.0002", 1: "0.1 0.0002", 2: "0.1 0.1"}[digits["FORCE"]]
        return f"{load} {rigid} 0."
    if key == "friction":
        return friction_of(digits)
    if key == "conformal":
        return {3: "1 4 2\n -2. -1d 2. 1d", 1: "1 4"}[module]
    if key == "elements" and digits["BOUND"] >= 2:
        return HERTZ if digits["BOUND"] != 4 else "-6\n 9 7 0.4 0.3 0.5 1.2"
    if key == "stresses" and digits["STRESS"] == 2:
        return "1 1"
    if key == "track":
        return "14. 0 1435. 500." if digits["CONFIG"] >= 4 else "14. 0 1435. 0."
    if key == "position":
        return {0: "0. 0. 0.3 3*0.", 1: "0. 0. 1e4 3*0."}[digits["NORM"]]
    if key == "velocity":
        last = {1: "10.", 2: "100."}.get(digits["FORCE"], "-4.348")
        speed = "4." if digits["CONFIG"] >= 4 else "2000."
        return f"{speed} 4*0. {last}"
    return ENTRIES[key]


def friction_of(digits):
    law = LAWS[digits["FRCLAW"]]
    varies = digits["VARFRC"]
    rows = {0: [law], 1: [f"-20d {law}"], 2: [f"0. {law}"], 3: [law] * 7}[varies]
    lines = ["1"] * (varies in (1, 2)) + rows + ["0. 1."] * (digits["FRCLAW"] != 0)
    return "\n ".join(lines)


def text_with(module, digit, value):
    """A case in which one digit has a value; the first, with which it is plain, is kept from."""
    words, lines = WORDS[module]
    values = Digits()
    for digits, plain in zip(words, PLAIN[module], strict=True):
        values |= {each.name: int(plain[k]) for k, each in enumerate(digits)}
    cases = [case_of(module, words, lines, values)]
    changed = Digits(values | {digit.name: value})
    try:
        cases.append(case_of(module, words, lines, changed))
    except KeyError:  # a value that the grammar has not
        cases.append(case_of(module, words, (), changed))
    return "\n".join([*cases, " 0 MODULE\n"])


def case_of(module, words, lines, values):
    control = ["".join(str(values[each.name]) for each in digits) for digits in words]
    rows = [f"{module} MODULE", *control]
    hertzian = values.get("BOUND", 0) >= 2
    given = [line.key for line in lines if line.given(values)]
    rows += [
        entries_of(key, values, module) for key in given if not (key == "distance" and hertzian)
    ]
    return "\n".join(f" {row}" for row in rows)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("digits")
    y = np.linspace(-36.0, 36.0, 73)
    side = np.array([[-36.5, 20.0], [-36.2, 8.0]])
    head = np.stack([y, y**2 / 600], axis=1)
    np.savetxt(made / "rail.csv", np.concatenate([side, head, side[::-1] * [-1.0, 1.0]]))
    flange = np.array([[-70.0, 10.0], [-60.0, 27.0], [-50.0, 27.0], [-42.0, 8.0]])
    tread = np.stack([np.linspace(-38.0, 60.0, 50), np.linspace(1.5, -2.5, 50)], axis=1)
    np.savetxt(made / "wheel.csv", np.concatenate([flange, tread]))
    return made


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("module", [3, 1])
def test_every_digit_is_read_or_refused_by_name_and_line(folder, module):
    path = folder / "case.inp"
    read = {3: vc.read_contact_input, 1: read_wheels}[module]
    needing = set()
    for own, digit, value in CHOICES:
        if own != module:
            continue
        path.write_text(text_with(module, digit, value))
        first, *others = read(path, strict=False).cases
        assert not first.reason, first.reason
        name = f"{digit.letter} ({digit.name}) = {value} "
        reason = others[0].reason if others else "skipped"
        if value in digit.refused:
            assert f"{name}is not supported: {digit.refused[value]}" in reason
        elif value not in digit.read:
            assert f"{name}is not supported; supported: " in reason
        elif reason != "skipped" and reason:
            assert "line " in reason
            needing.add(f"{digit.letter}{value}")
    assert needing == NEEDING[module]


WRITTEN = {
    "blanks are tabs": lambda text: text.replace(" ", "\t"),
    "lines of other systems": lambda text: text.replace("\n", "\r\n"),
    "lower case": str.lower,
    "exponents of Fortran": lambda text: text.replace("82000. 82000.", "8.2D4 8.2+4"),
    "repeat counts": lambda text: text.replace("0.28 0.28 82000. 82000.", "2*.28 2*82d3"),
    "commas": lambda text: text.replace("0.28 0.28 82000.", "0.28,0.28,82000."),
    "over lines": lambda text: text.replace("0.28 0.28 82000.", "0.28\n\n% G\n 0.28\n 82000."),
    "remarks": lambda text: text.replace("82000. 82000.", "82000. 82000. % POISS 1,2, GG 1,2"),
    "other remarks": lambda text: text.replace("82000. 82000.", "82000. 82000. ! POISS 2*0.28"),
    "names behind": lambda text: text.replace("82000. 82000.", "82000. 82000.  POISS 1,2, GG"),
    "leading zeros left out": lambda text: text.replace(" 0022020", " 22020"),
    "no stop": lambda text: text.replace(" 0 MODULE\n", ""),
    "bare stop": lambda text: text.replace(" 0 MODULE\n", " 0\n"),
    "text behind the stop": lambda text: text + "\n 3 more cases, not calculated\n 1 2 3\n",
    "an angle in degrees": lambda text: text.replace("0. 0.1 1000.", "0d 0.1 1000."),
    "an angle in radians": lambda text: text.replace("0. 0.1 1000.", "0r 0.1 1000."),
    "debug output": lambda text: text.replace("00000001", "10000001\n 0000000 4 PSFLCIN, X_READLN"),
    "a result element": lambda text: text.replace("3 MODULE", "3 1 2 MODULE"),
    "spin about its default": lambda text: text.replace("0.0002 0.", "0.0002 0. 0. 0."),
    "most output": lambda text: text.replace("00000001", "00022691"),
}  # fmt: skip


@pytest.mark.parametrize("written", WRITTEN.values(), ids=WRITTEN)
def test_a_case_may_be_written_in_many_ways(folder, written):
    words, lines = WORDS[3]
    values = Digits()
    for digits, plain in zip(words, PLAIN[3], strict=True):
        values |= {each.name: int(plain[k]) for k, each in enumerate(digits)}
    text = case_of(3, words, lines, values) + "\n 0 MODULE\n"
    path = folder / "case.inp"
    found = []
    for each in (text, written(text)):
        path.write_bytes(each.encode())
        (scene,) = vc.read_contact_input(path)
        found.append((scene.motion, scene.bodies, scene.grid, scene.normal_force, scene.friction))
        found[-1] += (scene.surface.h.tolist(),)
    assert written(text) != text
    assert found[0] == found[1]
