"""Files of influence numbers as the program CONTACT reads them (its digit C = 9)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from varcontact import checks
from varcontact.elasticity.own import Elasticity
from varcontact.errors import SceneError
from varcontact.system.files import text_of

COLUMNS = ("zz", "zx", "zy", "xz", "xx", "xy", "yz", "yx", "yy")
"""Displacement and traction of each column, after the offset along x and its length."""
LENGTH_TOL = 1e-6


@checks.named_options()
def read_influence_numbers(path: str | Path, G: float) -> Elasticity:
    r"""Read a file of influence numbers, as CONTACT has them with C = 9.

    Two numbers (matrices, convex body), two (quasi-identical 0, order 312), two
    (symmetry along x 1, y 0), and ``mx my dx dy``; then for each offset along y,
    from ``-(my - 1)``, two lines of text and mx lines: the offset along x, its
    length, and the displacements nn nx ny, xn xx xy, yn yx yy, n the normal, by
    unit tractions for a modulus of 1. ``%`` begins a comment.

    Parameters
    ----------
    path : str or Path
    G : float
        Combined modulus of rigidity, by which the numbers are divided [stress].

    Returns
    -------
    Elasticity
        By a kernel.

    Raises
    ------
    SceneError
        If the file cannot be read, is cut short, or has no single kernel; with
        the line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "numbers.txt"
    >>> rows = "0 0.0  3 0 0  0 4 0  0 0 4\n1 1.0  1 0 0  0 1 0  0 0 1\n"
    >>> _ = path.write_text("1 2\n0 312\n1 0\n2 1 1.0 1.0\n% iy = 0\n%\n" + rows)
    >>> read_influence_numbers(path, G=2.0).kernel.array[2, 2]
    array([[0.5, 1.5, 0.5]])
    >>> folder.cleanup()
    """
    modulus = checks.positive("G", G)
    file = checks.file_name("path", path)
    lines = _Lines(str(file), text_of("path", file).splitlines())
    matrices, _ = lines.whole_numbers(2)
    if matrices != 1:
        lines.refuse(f"{matrices} matrices; one is read, the same for all y")
    if lines.whole_numbers(2) != [0, 312]:
        lines.refuse("must be 0 312: all nine columns, in the order n, x, y")
    if lines.whole_numbers(2) != [1, 0]:
        lines.refuse("must be 1 0: offsets along x from 0, along y of both signs")
    nx, ny, dx, dy = lines.numbers(4)
    shape = checks.whole("mx", nx, least=2), checks.whole("my", ny)
    table = _table(lines, *shape, dx)
    return Elasticity(kernel=table / modulus, sides=(dx, dy))


def _table(lines: _Lines, nx: int, ny: int, dx: float) -> np.ndarray:
    """Numbers (3, 3, 2 ny - 1, 2 nx - 1), mirrored to negative offsets along x."""
    table = np.empty((3, 3, 2 * ny - 1, 2 * nx - 1))
    for row in range(2 * ny - 1):
        lines.skip(2)
        for column in range(nx):
            offset, length, *values = lines.numbers(2 + len(COLUMNS))
            if offset != column or abs(length - column * dx) > LENGTH_TOL * nx * dx:
                lines.refuse(f"begins with {offset:g} {length:g}, not {column} {column * dx:g}")
            for name, value in zip(COLUMNS, values, strict=True):
                i, j = ("xyz".index(each) for each in name)
                sign = -1.0 if name.count("x") == 1 else 1.0
                table[i, j, row, nx - 1 - column] = sign * value
                table[i, j, row, nx - 1 + column] = value
    return table


@dataclass
class _Lines:
    """The lines of a file, one after the other."""

    path: str
    lines: list[str]
    at: int = field(default=0, init=False)

    def refuse(self, what: str) -> NoReturn:
        """Raise an error that names the line and what is wrong."""
        message = f"{self.path}, line {self.at}: {what}"
        raise SceneError("path", self.path, message=message)

    def skip(self, count: int) -> None:
        """Pass over lines of text."""
        self.at += count

    def numbers(self, count: int) -> list[float]:
        """The numbers of the next line that is not empty."""
        words = next((words for words in self._rest() if words), None)
        if words is None:
            self.refuse("the file ends here, and is cut short")
        try:
            values = [float(word.lower().replace("d", "e")) for word in words[:count]]
        except ValueError:
            self.refuse(f"{words[:count]} are no numbers")
        if len(values) < count or not np.isfinite(values).all():
            self.refuse(f"must have {count} numbers")
        return values

    def whole_numbers(self, count: int) -> list[int]:
        """The whole numbers of the next line."""
        values = self.numbers(count)
        if any(value != int(value) for value in values):
            self.refuse("must have whole numbers")
        return [int(value) for value in values]

    def _rest(self) -> Iterator[list[str]]:
        """The words of each line that is left, without comments."""
        while self.at < len(self.lines):
            self.at += 1
            yield self.lines[self.at - 1].partition("%")[0].replace(",", " ").split()
