"""The text of CONTACT's input files: groups of values, control digits, and what
of them has a counterpart here.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech
CMCC report 20-01, appendix A).
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import NoReturn

import numpy as np

from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.scene.surfaces import SampledDistance
from varcontact.system.files import text_of

Supported = dict[str, tuple[str, dict[int, str]]]
"""By the letter of a control digit its name, and the values that are read."""

SUPPORTED: Supported = {
    "P": ("PVTIME", {0: "continue the previous case", 2: "a new sequence"}),
    "B": ("BOUND", {0: "half-space", 2: "elliptic bound of a Hertzian contact"}),
    "T": (
        "TANG",
        {0: "no tangential problem", 1: "shift", 2: "transient rolling", 3: "steady rolling"},
    ),
    "N": ("NORM", {0: "approach given", 1: "normal force given"}),
    "F": ("FORCE", {0: "creepages given", 1: "FX given", 2: "FX and FY given"}),
    "S": (
        "STRESS",
        {
            0: "no stresses",
            1: "stresses, not read",
            2: "stresses, not read",
            3: "stresses, not read",
        },
    ),
    "V": ("VARFRC", {0: "one friction law"}),
    "L": ("FRCLAW", {0: "Coulomb", 1: "as before", 2: "linear", 3: "rational", 4: "exponential"}),
    "D": ("DISCNS", {0: "grid as before", 1: "grid anew", 2: "grid read"}),
    "C": ("INFLCF", {0: "material as before", 1: "material as before", 2: "half-space"}),
    "M": ("MATER", {0: "elastic"}),
    "Z": ("RZNORM", {0: "distance as before", 1: "distance anew", 2: "distance read"}),
    "E": ("EXRHS", {0: "no extra term"}),
    "X": ("XFLOW", {0: "no debug output", 1: "debug output, passed over"}),
    "H": ("HEAT", {0: "no temperatures"}),
    "G": (
        "GAUSEI",
        {
            0: "default solver",
            1: "as before",
            2: "ConvexGS",
            3: "SteadyGS",
            4: "default solver",
            5: "GDsteady",
        },
    ),
    "R": ("RETURN", {1: "calculate", 3: "skip"}),
}
"""Control digits of module 3. I, A, O and W do not change the problem, and may have any value."""

INTEGER = re.compile(r"[+-]?\d{1,15}$")
WORD = re.compile(r"'[^']*'|[%!].*|[^,\s%]+")
"""Of a line: names in quotes may have blanks, a per cent sign or an exclamation mark begins a
comment."""
FORTRAN_EXPONENT = re.compile(r"(?<=[\d.])(?=[+-]\d{3}$)")
"""Where Fortran leaves out the E of an exponent of three digits."""


@dataclass(frozen=True)
class Group:
    """Values that belong together, as text."""

    path: str
    line: int  # where they begin
    names: tuple[str, ...]
    values: tuple[str, ...]  # as many as there are names
    rest: tuple[str, ...]  # what else is on the last line: optional values, or words

    def refuse(self, name: str, value: object, why: str) -> NoReturn:
        """Say where which entry is, and what is wrong with it."""
        raise SceneError(
            name, value, message=f"{self.path}, line {self.line}: {name} = {value} {why}"
        )

    def integers(self) -> list[int]:
        """All values, as whole numbers."""
        for name, value in zip(self.names, self.values, strict=True):
            if not INTEGER.match(value):
                self.refuse(name, repr(value), "is not a whole number")
        return [int(value) for value in self.values]

    def numbers(self) -> list[float]:
        """All values, as numbers."""
        return [self.number(k) for k in range(len(self.values))]

    def number(self, k: int) -> float:
        """The k-th value as a number."""
        found = number_of(self.values[k])
        if found is None:
            self.refuse(self.names[k], repr(self.values[k]), "is not a number")
        return found

    def angle(self, k: int) -> float:
        """The k-th value as an angle in radians: 180d is in degrees, 3.14r and 3.14 are in
        radians.
        """
        text = self.values[k].lower()
        found = number_of(text.removesuffix("d").removesuffix("r"))
        if found is None:
            self.refuse(self.names[k], repr(self.values[k]), "is not an angle")
        return math.radians(found) if text.endswith("d") else found


def number_of(text: str) -> float | None:
    """A finite number, or None."""
    try:
        found = float(FORTRAN_EXPONENT.sub("E", text))
    except ValueError:
        return None
    return found if math.isfinite(found) and "_" not in text else None


@contextmanager
def located(group: Group) -> Iterator[None]:
    """Errors within get the line of the group."""
    try:
        yield
    except SceneError as error:
        message = f"{group.path}, line {group.line}: {error}"
        raise SceneError(error.field, error.value, message=message) from None


def wrong_line(path: Path, line: int, what: str) -> SceneError:
    """The error of a line of an output file."""
    return SceneError("path", str(path), message=f"{path}, line {line} {what}")


class Lines:
    """An input file, read group by group: each begins on a line of its own, and may go on over
    several.
    """

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        text = text_of("path", path, MOST_BYTES, "an input file of CONTACT")
        lines = [
            list(takewhile(lambda word: word[0] not in "%!", WORD.findall(line)))
            for line in text.splitlines()
        ]
        self.left = deque((number, words) for number, words in enumerate(lines, 1) if words)

    def group(self, *names: str) -> Group:
        """The next values, one for each name."""
        line = self.left[0][0] if self.left else -1
        found: list[str] = []
        while len(found) < len(names):
            if not self.left:
                wanted = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
                raise SceneError(
                    "path", self.name, message=f"{self.name} ends where {wanted} should be given"
                )
            found += self.left.popleft()[1]
        return Group(self.name, line, names, tuple(found[: len(names)]), tuple(found[len(names) :]))

    def many(self, name: str, count: int) -> Group:
        """The next values of an array, of which a damaged file may promise more than there are."""
        if count > sum(len(words) for _, words in self.left):
            raise SceneError(
                "path", self.name, message=f"{self.name} ends before {count} values of {name}"
            )
        return self.group(*[name] * count)

    def digits(self, word: str, supported: Supported) -> tuple[dict[str, int], Group]:
        """The next control word as its digits by letter, each of which has a value that is
        supported.
        """
        group = self.group(word)
        (text,) = group.values
        if not re.fullmatch(r"\d+", text) or len(text) > len(word):
            group.refuse(word, repr(text), f"is not a control word of at most {len(word)} digits")
        digits = dict(zip(word, map(int, text.zfill(len(word))), strict=True))
        for letter, digit in digits.items():
            name, allowed = supported.get(letter, ("", {digit: "any"}))
            if digit not in allowed:
                choices = ", ".join(f"{value} ({meaning})" for value, meaning in allowed.items())
                group.refuse(f"{letter} ({name})", digit, f"is not supported; supported: {choices}")
        return digits, group


def control_digits(
    lines: Lines, problem: str, supported: Supported, geometry: Supported
) -> tuple[Group, dict[str, int], dict[str, int], dict[str, int]]:
    """Where the control words begin, and their digits: of the `problem`, of geometry and material,
    of the solution.
    """
    digits, group = lines.digits(problem, supported)
    more, material = lines.digits("VLDCMZE", geometry)
    if material.rest and number_of(material.rest[0]) not in (None, 0.0):
        material.refuse(
            "M2 (MATER2)", material.rest[0], "is not supported; supported: 0 (no damping)"
        )
    last, _ = lines.digits("XHGIAOWR", supported)
    if last["X"] == 1:
        lines.digits("PSFLRIN", {})
    if last["G"] != 1:  # parameters of iterations
        lines.group("MAXGS", "MAXIN", "MAXNR", "MAXOUT", "EPS").numbers()
    if last["G"] in SOLVER_PARAMETERS:
        lines.group(*SOLVER_PARAMETERS[last["G"]]).numbers()
    return group, digits, more, last


SOLVER_PARAMETERS = {
    2: ("OMEGAH", "OMEGAS", "INISLP", "OMGSLP"),
    3: ("OMEGAH", "OMEGAS", "INISLP", "OMGSLP"),
    4: ("INISLP", "OMGSLP"),
    5: ("FDECAY", "BETATH", "KDOWFB", "D_IFC", "D_LIN", "D_CNS", "D_SLP", "POW_S"),
}
"""Parameters of a solver on a line of their own, by the control digit G."""
MOST_BYTES = 2**28
"""Of an input file, whose distances may be given element by element."""


def modules(lines: Lines, module: int, meaning: str, others: Mapping[int, str]) -> Iterator[Group]:
    """The MODULE line of each case, up to the stop; `others` has why other modules are refused."""
    while lines.left:
        group = lines.group("MODULE")
        (found,) = group.integers()
        if found == 0:
            return
        if found != module:
            why = others.get(found, f"is not supported; supported: {module} ({meaning}), 0 (stop)")
            group.refuse("MODULE", found, why)
        if group.rest and number_of(group.rest[0]) is not None:
            group.refuse(
                "MODULE", found, f"with result element {group.rest[0]} is not supported; use one"
            )
        yield group


def skip_stresses(lines: Lines, digit: int) -> None:
    """Pass over the points at which stresses below the surface are wanted."""
    if digit >= 2:
        lines.group("MATFIL", "OUTPUT").integers()
    while digit == 3:
        group = lines.group("ISUBS")
        (kind,) = group.integers()
        if kind == 0:
            return
        if kind not in (1, 2, 3, 5, 6, 7, 9):
            group.refuse("ISUBS", kind, "is not supported; supported: 0, 1, 2, 3, 5, 6, 7, 9")
        if kind in (2, 6):  # each begins on a line of its own, and words may stand behind it
            lines.group("IXL", "IXINC", "IXH").integers()
            lines.group("IYL", "IYINC", "IYH").integers()
        if kind in (3, 7):
            for count in lines.group("NX", "NY").integers():
                lines.many("IX or IY", count).numbers()
        if kind in (1, 2, 3):
            lines.group("NZ", "ZL", "DZ").numbers()
        if kind in (5, 6, 7, 9):
            for count in lines.group(*(("NX", "NY", "NZ") if kind == 9 else ("NZ",))).integers():
                lines.many("X, Y or Z", count).numbers()


Given = tuple[Group, int, list[float]]
"""Where something is given, which form it has, and its numbers."""
Row = tuple[float, float]
"""Of the one row of a line contact: where it lies along y, and how long it is."""

POTENTIAL = {
    -1: ("MX", "MY", "A1", "B1", "SCALE"),
    -2: ("MX", "MY", "A1", "AOB", "SCALE"),
    -3: ("MX", "MY", "AA", "BB", "SCALE"),
    1: ("MX", "MY", "XL", "YL", "DX", "DY"),
    2: ("MX", "MY", "XL", "YL", "XH", "YH"),
    3: ("MX", "MY", "XC1", "YC1", "DX", "DY"),
    4: ("MX", "MY", "XC1", "YC1", "XCM", "YCM"),
}
"""Entries of the potential contact by IPOTCN."""


def elements(potential: Given) -> tuple[Grid, Row | None]:
    """The elements of IPOTCN = 1 to 4, see `lattice`."""
    group, ipotcn, (mx, my, x, y, dx, dy) = potential
    nx, ny = counts(group, mx, my)
    if ipotcn in (2, 4):  # the other end is given, that of the elements or of their centres
        along_x, along_y = (nx, ny) if ipotcn == 2 else (nx - 1, ny - 1)
        if along_x == 0 or along_y == 0:
            group.refuse("IPOTCN", 4, "needs MX and MY of 2 at least")
        dx = (dx - x) / along_x
        dy = (dy - y) / along_y
    if ipotcn in (3, 4):  # from centre to centre
        x = x - dx / 2
        y = y - dy / 2
    return lattice(group, nx, ny, dx, dy, x, y)


def read_distance(lines: Lines, grid: Grid) -> Given:
    """IBASE and its numbers."""
    kinds = lines.group("IBASE", "IPLAN")
    ibase, iplan = kinds.integers()
    if iplan != 1:
        kinds.refuse("IPLAN", iplan, "is not supported; supported: 1 (unrestricted)")
    if ibase == 1:
        group = lines.group("B1", "B2", "B3", "B4", "B5", "B6")
    elif ibase == 2:
        head = lines.group("NN", "XM", "RM", "Y1", "DY1")
        count = head.number(0)
        if count != int(count) or count < 2 or head.number(2) == 0 or head.number(4) <= 0:
            head.refuse(
                "NN, XM, RM, Y1, DY1",
                head.values,
                "must have two points or more, a radius and a positive DY1",
            )
        group = lines.many("B", int(count))
        return group, ibase, [*head.numbers()[1:], *group.numbers()]
    elif ibase == 9:
        group = lines.many("H", grid.size)
    else:
        kinds.refuse(
            "IBASE",
            ibase,
            "is not supported; supported: 1 (quadratic), 2 (profile), 9 (by element)",
        )
    return group, ibase, group.numbers()


def sampled(distance: Given, grid: Grid, row: Row | None) -> SampledDistance:
    """The undeformed distance at the centres of the elements."""
    _, ibase, values = distance
    x = grid.x[None, :]
    if row is None:
        y = grid.y[:, None]
    else:
        y = np.full((1, 1), row[0])
    if ibase == 9:
        h = np.reshape(values, grid.shape)
    elif ibase == 1:
        b1, b2, b3, b4, b5, b6 = values
        with np.errstate(all="ignore"):  # distances that are not finite are refused below
            h = b1 * x**2 + b2 * x * y + b3 * y**2 + b4 * x + b5 * y + b6
    else:
        axle, radius, first, step, *heights = values
        at = (y - first) / step
        profile = np.array(heights)
        # the outermost pieces go on beyond the profile
        k = np.clip(np.floor(at).astype(int), 0, len(heights) - 2)
        h = profile[k] + (at - k) * (profile[k + 1] - profile[k]) + (x - axle) ** 2 / (2 * radius)
    return SampledDistance(h if row is None else h[0])


def counts(group: Group, mx: float, my: float) -> tuple[int, int]:
    """MX and MY as whole numbers."""
    for name, count in (("MX", mx), ("MY", my)):
        if count != int(count) or count < 1:
            group.refuse(name, count, "is not a number of elements")
    if mx * my > MOST_ELEMENTS:
        group.refuse(
            "MX MY",
            f"{mx * my:.10g}",
            f"is more than the {MOST_ELEMENTS} elements that can be computed with",
        )
    return int(mx), int(my)


MOST_ELEMENTS = 10_000_000

LONG_ROW = 50
"""Length of a row by its width from which it is as good as endless: the difference is of the order
of its square."""


def lattice(
    group: Group, nx: int, ny: int, dx: float, dy: float, x0: float, y0: float
) -> tuple[Grid, Row | None]:
    """The elements; one long row, which stands for plane strain, as a line contact."""
    if ny > 1:
        with located(group):
            return Grid(nx=nx, ny=ny, dx=dx, dy=dy, x0=x0, y0=y0), None
    if dy < LONG_ROW * nx * dx:
        group.refuse(
            "MY",
            1,
            f"stands for plane strain, and needs DY of {LONG_ROW} MX DX at least; DY is {dy:g}",
        )
    with located(group):
        return Grid(nx=nx, dx=dx, x0=x0), (y0 + dy / 2, dy)
