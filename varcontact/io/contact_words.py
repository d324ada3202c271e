"""The words of CONTACT's files: numbers as Fortran reads them, groups of values, and lattices of
elements.

The format of input files is that of the user guide (Vollebregt, User guide for
CONTACT, Vtech CMCC report 20-01, appendix A).
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Callable, Container, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from itertools import takewhile
from pathlib import Path
from typing import NoReturn

from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.system.files import text_of

INTEGER = re.compile(r"[+-]?[0-9]{1,15}$")
WORD = re.compile(r"'[^']*'|[%!].*|[^,\s%]+")
"""Pattern of the words of a line: names in quotes may contain blanks; a per cent sign or an
exclamation mark begins a comment."""
NUMBER = re.compile(r"([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[edq]?([+-][0-9]+)|[edq]([0-9]+))?$")
"""Pattern of a Fortran number: the exponent may begin with E, D or Q, or with its sign alone."""
REPEATED = re.compile(r"([0-9]{1,9})\*([^*]+)$")
"""Pattern of a value that stands for several."""


@dataclass(frozen=True)
class Group:
    """Values read together, as text."""

    path: str
    line: int  # where they begin
    names: tuple[str, ...]
    values: tuple[str, ...]  # as many as there are names
    optional: tuple[str, ...] = ()  # values that may follow on the last line, and do

    def refuse(self, name: str, value: object, why: str) -> NoReturn:
        """Raise an error that names the place, the entry and what is wrong."""
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

    def count(self, k: int, least: int = 1) -> int:
        """The k-th value as a number of things."""
        count = int(self.number(k))
        if not least <= count <= MOST_ELEMENTS:
            self.refuse(self.names[k], count, f"is not in the range {least} to {MOST_ELEMENTS}")
        return count

    def angle(self, k: int) -> float:
        """The k-th value as an angle in radians: 180d is in degrees, 3.14r and 3.14 are in
        radians.
        """
        found = angle_of(self.values[k])
        if found is None:
            self.refuse(self.names[k], repr(self.values[k]), "is not an angle")
        return found

    def text(self, k: int) -> str:
        """The k-th value without its quotes, a path with slashes."""
        return self.values[k].strip("'\"").replace("\\", "/")

    def option(self, k: int, default: float) -> float:
        """The k-th optional value as a number, or a default."""
        if k >= len(self.optional):
            return default
        return number_of(self.optional[k]) or 0.0

    def check_value(self, k: int, allowed: Container[int]) -> None:
        """Refuse a value that the format does not have."""
        value = self.integers()[k]
        if value not in allowed:
            choices = ", ".join(map(str, allowed))  # type: ignore[call-overload]
            self.refuse(self.names[k], value, f"is not supported; supported: {choices}")


def number_of(text: str) -> float | None:
    """A finite number, or None."""
    match = NUMBER.match(text.lower())
    if match is None:
        return None
    found = float(f"{match[1]}e{match[2] or match[3] or 0}")
    if math.isinf(found):
        return None
    return found


def angle_of(text: str) -> float | None:
    """An angle in radians, or None."""
    text = text.lower()
    found = number_of(text.removesuffix("d").removesuffix("r"))
    if found is not None and text.endswith("d"):
        return math.radians(found)
    return found


@contextmanager
def located(group: Group) -> Iterator[None]:
    """Add the line of the group to errors raised within."""
    try:
        yield
    except SceneError as error:
        if str(error).startswith(f"{group.path}, line "):  # of another group
            raise
        message = f"{group.path}, line {group.line}: {error}"
        raise SceneError(error.field, error.value, message=message) from None


def wrong_line(path: Path, line: int, what: str) -> SceneError:
    """The error of a line of an output file."""
    return SceneError("path", str(path), message=f"{path}, line {line} {what}")


def numbers_of_line(path: Path, line: int, text: str, least: int) -> list[float]:
    """The numbers of a line; what CONTACT leaves out of a table is no number, and refused."""
    found = [number_of(word) for word in text.split()]
    numbers = [value for value in found if value is not None]
    if len(numbers) < least or len(numbers) < len(found):
        raise wrong_line(path, line, f"should have {least} numbers or more")
    return numbers


FORMS: dict[str, tuple[str, Callable[[str], bool]]] = {
    "d": ("is not a number", lambda word: number_of(word) is not None),
    "a": ("is not an angle", lambda word: angle_of(word) is not None),
    "i": ("is not a whole number", lambda word: INTEGER.match(word) is not None),
    "w": ("", lambda word: True),
    "s": ("is not a name in quotes", lambda word: word[0] == word[-1] == "'" and len(word) > 1),
}
"""Error in words and test of a word, by type of entry: number, angle, whole number, any word, name
in quotes."""


@cache
def _entries(specification: str) -> tuple[tuple[str, ...], str, int]:
    """Names, types, and how many entries are not optional, of ``"CHI:a, DQ, [FACPHI]"``."""
    words = specification.replace("[", "").replace("]", "").split(",")
    entries = [word.strip().partition(":") for word in words]
    names = tuple(name for name, _, _ in entries)
    types = "".join(kind or "d" for _, _, kind in entries)
    required = specification.partition("[")[0]
    return names, types, len([word for word in required.split(",") if word.strip()])


class Lines:
    """Text file, read group by group: each begins on a line of its own and may continue over
    several lines.
    """

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        text = text_of("path", path, MOST_BYTES, "an input file of CONTACT")
        lines = [
            list(takewhile(lambda word: word[0] not in "%!", WORD.findall(line)))
            for line in text.splitlines()
        ]
        self.left = deque((number, words) for number, words in enumerate(lines, 1) if words)

    def read(self, specification: str) -> Group:
        """The next values, by names and types: ``:a`` an angle, ``:i`` a whole number, ``:s`` a
        name, else a number; those in brackets may follow on the last line.
        """
        names, types, required = _entries(specification)
        group = self.group(*names[:required])
        self._check(group, types[:required])
        found: list[str] = []
        for kind, word in zip(types[required:], group.optional, strict=False):
            if not FORMS[kind][1](word):
                break
            found.append(word)
        self._check_rest(group, group.optional[len(found) :])
        return replace(group, optional=tuple(found))

    def array(self, name: str, count: int, kind: str = "d") -> Group:
        """The next values of an array, of one type."""
        self.check_left(name, count)
        group = self.group(*[name] * count)
        self._check(group, kind * count)
        self._check_rest(group, group.optional)
        return replace(group, optional=())

    def group(self, *names: str) -> Group:
        """The next values, one for each name; what follows on the last line is optional."""
        line = self.left[0][0] if self.left else -1
        found: list[str] = []
        while len(found) < len(names):
            if not self.left:
                wanted = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
                raise SceneError(
                    "path", self.name, message=f"{self.name} ends where {wanted} should be given"
                )
            for word in self.left.popleft()[1]:
                repeated = REPEATED.match(word)
                if repeated is None:
                    found.append(word)
                    continue
                times = min(int(repeated[1]), max(len(names) - len(found), 1))
                found += [repeated[2]] * times
        return Group(self.name, line, names, tuple(found[: len(names)]), tuple(found[len(names) :]))

    def skip_to(self, word: str) -> None:
        """Pass over lines up to one that begins with a whole number and has a word."""
        while self.left:
            first, *others = self.left[0][1]
            if INTEGER.match(first) and word in map(str.upper, others):
                return
            self.left.popleft()

    def check_left(self, name: str, count: int) -> None:
        """Refuse an array longer than the rest of the file, which a damaged size may announce."""
        left = 0
        for _, words in self.left:
            left += len(words)
            repeated = filter(None, map(REPEATED.match, words))
            left += sum(int(each[1]) - 1 for each in repeated)
            if left >= count:
                return
        if count > left:
            raise SceneError(
                "path", self.name, message=f"{self.name} ends before {count} values of {name}"
            )

    def _check_rest(self, group: Group, rest: Sequence[str]) -> None:
        """Refuse a number after the last value, which would be ignored: the line has lost one
        before it, or has one too many.
        """
        if rest and NUMBER.match(rest[0].lower()):
            names = ", ".join(group.names[:6])
            why = f"is a number too many behind {names}; remarks begin with %"
            group.refuse("line", rest[0], why)

    def _check(self, group: Group, types: str) -> None:
        """Refuse the first word that is not of its type."""
        for name, kind, word in zip(group.names, types, group.values, strict=True):
            why, holds = FORMS[kind]
            if not holds(word):
                group.refuse(name, repr(word), why)


MOST_BYTES = 2**28
"""Largest size of an input file [bytes]; its distances may be given element by element."""


MOST_ELEMENTS = 10_000_000


def lattice(
    group: Group, nx: int, ny: int, sides: tuple[float, float], corner: tuple[float, float]
) -> Grid:
    """Elements by their number, sides, and lower left corner."""
    if nx * ny > MOST_ELEMENTS:
        why = f"is more than the {MOST_ELEMENTS} elements that can be computed with"
        group.refuse("MX MY", nx * ny, why)
    with located(group):
        return Grid(nx=nx, ny=ny, dx=sides[0], dy=sides[1], x0=corner[0], y0=corner[1])
