"""No silent change of meaning: each number of a file of CONTACT is refused, changes what is read, or
is named as passed over.
"""

import dataclasses
import re

import numpy as np
import pytest

import varcontact as vc
from tests.io.test_contact_mutations import FILES
from tests.wheel_rail.test_contact_input import with_profiles
from varcontact.io.contact_cases import read_cases
from varcontact.io.contact_words import WORD, number_of

SLIPS = np.linspace(0.0, 3e3, 61).reshape(1, -1)


def meaning(value):
    """All that a case says, as nested tuples: laws by their values, arrays by their numbers."""
    if isinstance(value, np.ndarray):
        return value.shape, value.tobytes()
    if dataclasses.is_dataclass(value):
        fields = [field.name for field in dataclasses.fields(value)]
        own = tuple((name, meaning(getattr(value, name))) for name in fields)
        law = meaning(value(SLIPS)) if isinstance(value, vc.FrictionLaw) else ()
        return type(value).__name__, own, law
    if isinstance(value, dict):
        return tuple((key, meaning(each)) for key, each in value.items())
    if isinstance(value, list | tuple):
        return tuple(map(meaning, value))
    if callable(value):
        return ""
    return repr(value)


def read_meaning(read, path):
    """What a file says; None where it is refused."""
    try:
        found = read(path)
    except vc.SceneError:
        return None
    return meaning([dataclasses.replace(case, line=0) for case in found.cases])


SOLVERS = "MAXGS MAXIN MAXNR MAXOUT EPS OMEGAH OMEGAS INISLP OMGSLP PSFLRIN MATFIL OUTPUT"
STEADY = "FDECAY BETATH KDOWFB D_IFC D_LIN D_CNS D_SLP POW_S"
HERE = "DQ DQREL VELOC SABSH2 BETAPL A_SEP IF_METH IXH IYH MIRRORY MEM_S0"
PASSED_OVER = {*SOLVERS.split(), *STEADY.split(), *HERE.split(), "GAUGSQ or RAILY0"}
"""Entries of solvers and output; and those on which nothing depends in these cases: steps and
velocities of steady rolling by Coulomb's law, a term of friction that is zero, columns and rows
beyond the elements, the innermost gauge face as 0 or 1, a symmetric
rail mirrored (docs/from_contact.md).
"""


def significant(text):
    """The words of a file that are no remarks, by line: numbers and names in quotes, up to the first
    other word.
    """
    lines = []
    for line in text.splitlines():
        words = []
        for word in WORD.findall(line):
            if word[0] != "'" and not re.match(r"[-+.\d]", word):
                break
            words.append(word)
        lines.append(words)
    return lines


def entries_of(path):
    """Names of entries by line and place in the line, of all groups that one line holds."""
    cases, _ = read_cases(path)
    names = {}
    for case in cases:
        for key in case.given:
            groups = case.entries[key]
            for group in groups if isinstance(groups, tuple) else (groups,):
                names |= {(group.line, k): name for k, name in enumerate(group.names)}
    return names


def changed(word):
    """Another number, angle or name."""
    if re.fullmatch(r"[+-]?\d+", word):
        return str(int(word) + 1)
    unit = re.search(r"[dr]$", word)
    if unit:
        return f"{number_of(word[:-1]) * 1.25 + 0.1}{unit[0]}"
    return repr(number_of(word) * 1.25 + 0.1)


@pytest.mark.parametrize("name", ["case.inp", "wheel.inp"])
def test_every_number_counts(tmp_path, name):
    """One after the other changed: what is read changes, or is refused."""
    read, texts = FILES[name]
    path = with_profiles(tmp_path) / name
    for text in texts:
        path.write_text(text)
        before = read_meaning(read, path)
        assert before is not None
        entries = entries_of(path)
        lines = text.splitlines()
        for k, words in enumerate(significant(text)):
            for place, word in enumerate(words):
                entry = entries.get((k + 1, place))
                if (entry, word) == ("B", "0"):  # factors of y, which is 0 in one row of elements
                    continue
                if entry is None or entry in PASSED_OVER or number_of(word.rstrip("dr")) is None:
                    continue
                other = [*words[:place], changed(word), *words[place + 1 :]]
                line = " ".join([*other, " "])
                path.write_text("\n".join([*lines[:k], line, *lines[k + 1 :]]) + "\n")
                assert read_meaning(read, path) != before, (entry, word, text)
