"""Files of CONTACT in which lines and digits are lost, doubled or changed: read, or refused in our
words.
"""

import contextlib
import random

import pytest

import varcontact as vc
from tests.conftest import DATA
from tests.io.test_contact_input import CASE, FORMULA, SURFACE
from tests.wheel_rail.test_contact_input import CASE as WHEEL
from tests.wheel_rail.test_contact_input import FEATURES, SLICES, with_profiles
from varcontact.wheel_rail import ProfileSlices
from varcontact.wheel_rail import read_contact_input as read_wheels

BASIC, WHEELS = ((DATA / f"contact_{name}.out").read_text() for name in ("basic", "wheel"))
STRESSES = " 1 0  MATFIL, OUTPUT\n 2  ISUBS\n 1 1 4  COLUMNS\n 1 1 3  ROWS\n 2 0.1 0.1  NZ\n 9\n 1 1 2\n 0\n 0\n 1 2\n 0\n"
RESULT = """% Tim Sws Xw Yw
0 0 0 0
% Xcp Ycp Zcp Deltcp
0 0 0 0
% Mx My Xl Yl Dx Dy Chi Dq
3 2 -0.3 -0.2 0.2 0.2 0.0 0.2
% T M Gg1 Gg2 Poiss1 Poiss2
3 0 200 200 0.42 0.42
% L dum Veloc Fstat Fkin
0 0 1000 0.4 0.4
% i Igs H Mu Pn Px Py Un Ux Uy SRel
2 1 0.0 0.4 4.0 -0.5 0.0 0.02 0.0 0.0 0.0
5 2 0.0 0.4 2.0 -0.8 0.0 0.02 0.0 0.0 0.001
"""


@pytest.fixture
def profiles(tmp_path):
    return with_profiles(tmp_path)


def read_result(path):
    """The result, and the problem that it is of."""
    result = vc.read_contact_result(path)
    return result.on(result.scene(vc.Steady(vx=0.001)))


def read_slices(path):
    """Slices of a rail with parts between features."""
    return ProfileSlices.read(path, "rail", mirror_z=False)


FILES = {
    "case.inp": (vc.read_contact_input, [
        CASE,
        CASE.replace(" 203100 ", " 202103 ").replace(" 0  MODULE", STRESSES + " 0  MODULE"),
        CASE.replace(FORMULA, " 9 1\n 0 1 2 3\n4 5 6 7\n8 9 10 11  H"),
        CASE.replace(FORMULA, " 2 1\n 3 0.25 500. -0.2 0.2\n 0.3 0.1 0.2"),
        CASE.replace(SURFACE, " -2\n 10 8  0.01 2.0 1.25\n")
        .replace("30 1 1e-6            MAX", "30 1 1e-6\n 1.0 0.05 1 1.0 0.0 1.0 1.0 0.9  MAX")
        .replace(" 0000001 ", " 0500001 "),
        CASE.replace(" 022020 ", " 322020 ").replace(" 0.3  0.3 ", " 0.2 0.1 50. 0 1.\n 0 1 "),
        CASE.replace(" 022020 ", " 3022029 ")
        .replace(" 0.3  0.3                     FSTAT, FKIN\n", "")
        .replace(" 0  MODULE", " 2*0.2\n 0.1 0.1\n 0.1 0.1\n 24*0.01\n 0  MODULE"),
        CASE.replace(" 022020 ", " 024420 ")
        .replace(" 0.28  0.28  82000. 82000. ", " 1 4 2\n -2. -1d 2. 1d\n 2*.28 2*8d4\n 9. .02 50. 0. "),
        CASE.replace(" 022020 ", " 622120 ")
        .replace(" 0000001 ", " 3000001 ")
        .replace(" 0.3  0.3  ", " 0.3 0. -.1 400.\n 0 1\n%")
        .replace(" 0.28  0.28  82000. 82000. ", " 2*.28 2*8d4\n 2*1. 2*.01\n 0 450 .05 1e-6\n 0 450 .05 1e-6\n%"),
        (DATA / "contact" / "onset_of_rolling.inp").read_text(),
        (DATA / "contact" / "carter.inp").read_text(),
    ]),
    "wheel.inp": (read_wheels, [
        WHEEL,
        WHEEL.replace(" 0022033 ", " 1022033 ")
        .replace("  0.300   0.300 ", " 2\n -20d 0.2 0.2\n -10d 0.3 0.3\n %"),
    ]),
    "rail.slcs": (read_slices, [SLICES.format(features="4  1  1") + " 2\n 1\n" + FEATURES]),
    "case.out": (vc.read_contact_output, [BASIC, WHEELS]),
    "case.mat": (read_result, [RESULT]),
}  # fmt: skip
"""By its name what reads a file, and texts that are whole."""
WORDS = (
    "",
    "0",
    "-1",
    "1e999",
    "nan",
    "1e308",
    "9" * 5000,
    "1.5",
    "-3",
    "'",
    '"',
    "%",
    "*****",
    "\0",
    "\x0c",
    "é",
    "٣",
)


def mutated(random, text):
    """A text with one to three faults: in lines, words or digits."""
    for _ in range(random.randint(1, 3)):
        lines = text.splitlines()
        k = random.randrange(len(lines))
        words = lines[k].split() or [""]
        place = random.randrange(len(words))
        match random.randrange(7):
            case 0:
                del lines[k]
            case 1:
                lines.insert(k, lines[k])
            case 2:
                other = random.randrange(len(lines))
                lines[k], lines[other] = lines[other], lines[k]
            case 3:
                digits = [at for at, character in enumerate(lines[k]) if character.isdigit()]
                if digits:
                    at = random.choice(digits)
                    lines[k] = lines[k][:at] + random.choice("0123456789.-") + lines[k][at + 1 :]
            case 4:
                lines[k] = " ".join([*words[:place], random.choice(WORDS), *words[place + 1 :]])
            case 5:
                lines[k] = " ".join([*words[:place], *words[place + 1 :]])
            case 6:
                lines = lines[: k + 1]
        text = "\n".join(lines) + "\n"
    return text


def refusal(read, path, changed):
    """The message of our own error, "" without one."""
    try:
        read(path)
    except vc.SceneError as error:
        return str(error)
    except Exception as error:
        raise AssertionError(changed) from error
    return ""


@pytest.mark.parametrize(
    ("name", "count"),
    {"case.inp": 30, "wheel.inp": 15, "rail.slcs": 15, "case.out": 80, "case.mat": 200}.items(),
    ids=str,
)
def test_no_text_gives_a_foreign_error(profiles, name, count):
    """Tried once with 4 000 changed files of each name; these are some of them."""
    generator = random.Random(name)
    read, texts = FILES[name]
    path = profiles / name
    for text in texts:
        path.write_text(text)
        read(path)
        for _ in range(count):
            changed = mutated(generator, text)
            path.write_text(changed)
            message = refusal(read, path, changed)
            assert not message or read is read_result or str(profiles) in message, (
                changed,
                message,
            )


@pytest.mark.parametrize(("read", "name", "text"), [
    (vc.read_contact_output, "case.out", BASIC.replace("Case     1", "Case     " + "9" * 5000)),
    (vc.read_contact_output, "case.out", BASIC.replace("Case     1", "Case     1,")),
    (vc.read_contact_output, "case.out", WHEELS.replace("PATCH  1", "PATCH  " + "9" * 5000)),
    (vc.read_contact_input, "case.inp", CASE.replace(" 1 1    ", " " + "9" * 5000 + " 1    ")),
    (vc.read_contact_input, "case.inp", CASE.replace(" 4 3   -1.0", " 4 1e308   -1.0")),
    (vc.read_contact_input, "case.inp", CASE.replace(" 022020 ", " 522020 ")),
    (read_result, "case.mat", RESULT.replace("\n3 2 ", "\n3 1e308 ")),
    (read_wheels, "wheel.inp", WHEEL.replace("'rail.csv'", "'ra\0il.csv'")),
])  # fmt: skip
def test_single_faults(profiles, read, name, text):
    """Found by the test above, or by people."""
    path = profiles / name
    path.write_text(text)
    with contextlib.suppress(vc.SceneError):
        read(path)
