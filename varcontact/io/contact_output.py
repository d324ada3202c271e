"""Tables of forces from CONTACT's output files ``<experiment>.out``.

The layout is that of the open-source release of 2025 (the subroutines
``soutpt`` and ``wr_output`` of its source): a line of names, and below it a
line with as many numbers.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from varcontact import checks
from varcontact.io.contact_words import MOST_BYTES, number_of, wrong_line
from varcontact.system.files import text_of

CASE = re.compile(r"\s*Case\s+(\d{1,9})\b(?:.*\bresult element\s+(\d{1,9})\b)?")
WHEEL = re.compile(r"\s*WHEEL-\w+ CONTACT, (LEFT|RIGHT) WHEEL,\s*(\d{1,9}) CONTACT PATCH")
PATCH = re.compile(r"\s*-----\s*DATA FOR CONTACT PATCH\s+(\d{1,9})\b")
PROFILE = re.compile(r'\s*(?:RAIL|ROLLER|WHEEL) PROFILE "')
"""Heading of the tables of rail and wheel profiles, which are skipped."""
BLOCK = re.compile(r"\s*SUBSURFACE STRESSES BLOCK")
EXTREME = re.compile(r"\s*(?:ABSMAX|MAX|MIN)\s+(SIG\w+)\s*=\s*(\S+)\s+AT")
TOTAL_TIME = re.compile(r"^\|Total(?:\s*\|\s*[0-9.]+){3}\s*\|\s*([0-9.]+)", re.MULTILINE)
"""Number of runs, processor time with its share, and wall-clock time."""
NONE_FOUND = "NO CONTACT FOUND"
NAME = re.compile(r"(?:CREEP|SHIFT) [XY](?=\s|$)|\S+")
CAPITALS = re.compile(r"(?:CREEP |SHIFT )?[A-Z][A-Z0-9_./,()]*$")
FORCES = ("FN", "FX", "APPROACH")
STOPPED = re.compile(r"\s*(Input: ERROR|ERROR\b|Errors found)")
CURVED = "BAR_"
"""Prefix of FN, FX and FS of conformal patches: sums of components along the curved surface."""
OVERFLOW = re.compile(r"\*+$|NaN$|[+-]?Infinity$", re.IGNORECASE)
"""Words printed for a number that does not fit its field, for NaN and for infinity."""


@dataclass(frozen=True, eq=False)
class ContactOutput:
    """Results that CONTACT printed of one case, in mm, N, rad, s, J and W.

    Attributes
    ----------
    case : int
        Its number.
    result_element : int or None
        Number of the result element in CONTACT's library; None where none
        is printed.
    side : str or None
        "left" or "right" wheel of module 1; None of module 3.
    values : dict of str to float
        The numbers of the case by CONTACT's names: of module 1 FX(TR), FY(TR),
        FZ(TR), FX(WS), ..., S_WS, Y_WS, Z_WS, GG(R), ...; of module 3 all its
        tables. NaN where CONTACT printed asterisks.
    patches : tuple of dict of str to float
        The same by contact patch: XCP(TR), ..., CKSI, CETA, CPHI, FN, FX, FS,
        MN, ELAST.EN., FRIC.POWER, APPROACH, PMAX, NCON, ...; of module 3 one,
        which is `values`, with FY, MZ, and CREEP X or SHIFT X where FX was
        given. Conformal patches, for which CONTACT prints BAR_FN, BAR_FX and
        BAR_FS, have them as FN, FX and FS, too.
    stresses : tuple of dict of str to float
        Extremes of the stresses below the surface, by block of points: SIGHYD,
        SIGVM, SIGTR, SIGMA1, SIGMA3, SIGXX, SIGYY, SIGZZ.
    """

    case: int
    result_element: int | None
    side: str | None
    values: dict[str, float]
    patches: tuple[dict[str, float], ...]
    stresses: tuple[dict[str, float], ...] = ()


@checks.named_options()
def read_contact_output(path: str | Path) -> list[ContactOutput]:
    """The forces, moments, creepages and approaches that CONTACT printed, from
    its file ``<experiment>.out``.

    Parameters
    ----------
    path : str or Path
        Written with O = 1 or more.

    Returns
    -------
    list of ContactOutput
        In the order of the file.

    Raises
    ------
    SceneError
        If the file cannot be read, or is not of this layout: with the line. A
        case without its forces is refused, too: the program stopped there, or
        the file was cut short.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "cattaneo.out"
    >>> _ = path.write_text('''
    ...  Case     2
    ...  KINEMATIC CONSTANTS
    ...      DT          VELOC     FX/FSTAT/FN FY/FSTAT/FN   CPHI
    ...      1.000           1.000     -0.8750       0.000       0.000
    ...
    ...  TOTAL FORCES, TORSIONAL MOMENT, ELASTIC ENERGY, FRICTIONAL POWER
    ...      FN          FX          FY          MZ         ELAST.EN.   FRIC.WORK
    ...          9.195      -3.218       0.000       0.000   8.525E-05  -2.750E-06
    ...      FN/G       SHIFT X      SHIFT Y     APPROACH     PMAX
    ...      4.598E-02   8.155E-03       0.000   1.998E-02       4.393
    ... ''')
    >>> (case,) = vc.read_contact_output(path)
    >>> case.values["FX"], case.values["SHIFT X"]
    (-3.218, 0.008155)
    >>> folder.cleanup()
    """
    file = checks.file_name("path", path)
    text = text_of("path", file, MOST_BYTES, "an output file of CONTACT")
    lines = text.splitlines()
    headings = {k: found for k, line in enumerate(lines) if (found := CASE.match(line))}
    if not headings:
        raise wrong_line(
            file, max(len(lines), 1), "ends without a case: this is no output file of CONTACT"
        )
    if not text.endswith("\n"):
        raise wrong_line(
            file,
            len(lines),
            "has no end: the file was cut short, or its last line break taken away",
        )
    ends = [*list(headings)[1:], len(lines)]
    return [
        _case(file, lines, first, last, heading)
        for (first, heading), last in zip(headings.items(), ends, strict=True)
    ]


def published_seconds(path: Path) -> float | None:
    """Wall-clock time that CONTACT printed of all cases of its output file [s]; None without it."""
    text = text_of("path", path, MOST_BYTES, "an output file of CONTACT")
    total = TOTAL_TIME.search(text)
    if total is None:
        return None
    return float(total[1])


def _case(
    file: Path, lines: list[str], first: int, last: int, heading: re.Match[str]
) -> ContactOutput:
    """One case, from the line of its heading to the last."""
    case = int(heading[1])
    element = None
    if heading[2] is not None:
        element = int(heading[2])
    side = None
    announced = None
    values: dict[str, float] = {}
    patches: list[dict[str, float]] = []
    table = values
    of_profile = False
    for k in range(first + 1, last):
        line = lines[k]
        # headings of the wheel and of its contact patches
        if wheel := WHEEL.match(line):
            side = wheel[1].lower()
            announced = int(wheel[2])
        elif patch := PATCH.match(line):
            _check_number(file, k, int(patch[1]), len(patches) + 1)
            table = {}
            patches.append(table)
        # a line of names, and the numbers below it
        entries = _entries(file, k, line, "".join(lines[k + 1 : min(k + 2, last)]))
        if entries is None:
            numbers_only = None not in map(_value, line.split())
            of_profile = PROFILE.match(line) is not None or (of_profile and numbers_only)
        elif not of_profile:
            table |= entries
            table |= {name.removeprefix(CURVED): value for name, value in entries.items()}
    # O = 0, or its input stopped it, which the last one has to say
    unprinted = not values and (last < len(lines) or any(map(STOPPED.match, lines[first:last])))
    if side is None and not patches and not unprinted and not _without_contact(lines[first:last]):
        patches = [values]
    _check_patches(file, last, case, patches, announced)
    stresses = _stresses(lines[first:last])
    return ContactOutput(case, element, side, values, tuple(patches), stresses)


def _stresses(lines: list[str]) -> tuple[dict[str, float], ...]:
    """Extremes of stresses by block of points, of all patches in turn."""
    blocks: list[dict[str, float]] = []
    for line in lines:
        if BLOCK.match(line):
            blocks.append({})
        elif (extreme := EXTREME.match(line)) and blocks:
            blocks[-1][extreme[1]] = number_of(extreme[2]) or 0.0
    return tuple(blocks)


def _check_number(file: Path, k: int, number: int, expected: int) -> None:
    """Refuse contact patches that are not numbered through."""
    if number != expected:
        raise wrong_line(file, k + 1, f"begins contact patch {number}, not {expected}")


def _without_contact(lines: list[str]) -> bool:
    return any(NONE_FOUND in line for line in lines)


def _entries(file: Path, k: int, line: str, below: str) -> dict[str, float] | None:
    """Numbers of the line below by the names of line k; None where these are no names and
    numbers.
    """
    names = NAME.findall(line)
    if not names or not all(map(CAPITALS.match, names)):
        return None
    values = [_value(word) for word in below.split()]
    numbers = [value for value in values if value is not None]
    if not numbers or len(numbers) < len(values):
        return None
    if len(numbers) != len(names):
        words = f"has {len(numbers)} numbers for {len(names)} names: {', '.join(names)}"
        raise wrong_line(file, k + 2, words)
    return dict(zip(names, numbers, strict=True))


def _check_patches(
    file: Path,
    last: int,
    case: int,
    patches: list[dict[str, float]],
    announced: int | None,
) -> None:
    """Refuse a case without the forces of its patches, or with another number of patches."""
    for number, patch in enumerate(patches, 1):
        lacking = [name for name in FORCES if name not in patch]
        if lacking:
            ends = f"ends case {case}, whose contact patch {number} has no {', '.join(lacking)}"
            reasons = "the program stopped there, the file was cut short, or O = 0"
            raise wrong_line(file, last, f"{ends}: {reasons}")
    if announced not in (None, len(patches)):
        counts = f"{len(patches)} of {announced} contact patches"
        raise wrong_line(file, last, f"ends case {case}, which has {counts}")


def _value(word: str) -> float | None:
    if OVERFLOW.match(word):
        return float("nan")
    return number_of(word)
