"""Elements and undeformed distances as CONTACT's input files give them: IPOTCN and IBASE."""

from __future__ import annotations

import numpy as np

from varcontact.io.contact_words import Group, Lines
from varcontact.scene.grid import Grid
from varcontact.scene.surfaces import SampledDistance

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
    group, ipotcn, (mx, my, x, y, right, top) = potential
    nx, ny = counts(group, mx, my)
    if ipotcn == 2:
        dx, dy = (right - x) / nx, (top - y) / ny
    elif ipotcn == 4:
        if nx == 1 or ny == 1:
            group.refuse("IPOTCN", 4, "needs MX and MY of 2 at least")
        dx, dy = (right - x) / (nx - 1), (top - y) / (ny - 1)
    else:
        dx, dy = right, top
    if ipotcn in (3, 4):
        x, y = x - dx / 2, y - dy / 2
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
            head.refuse("NN, XM, RM, Y1, DY1", head.values, "must have two points or more, a radius and a positive DY1")
        group = lines.many("B", int(count))
        return group, ibase, [*head.numbers()[1:], *group.numbers()]
    elif ibase == 9:
        group = lines.many("H", grid.size)
    else:
        kinds.refuse("IBASE", ibase, "is not supported; supported: 1 (quadratic), 2 (profile), 9 (by element)")
    return group, ibase, group.numbers()


def sampled(distance: Given, grid: Grid, row: Row | None) -> SampledDistance:
    """The undeformed distance at the centres of the elements."""
    _, ibase, values = distance
    x, y = grid.x[None, :], grid.y[:, None] if row is None else np.full((1, 1), row[0])
    if ibase == 9:
        h = np.reshape(values, grid.shape)
    elif ibase == 1:
        b1, b2, b3, b4, b5, b6 = values
        with np.errstate(all="ignore"):  # distances that are not finite are refused below
            h = b1 * x**2 + b2 * x * y + b3 * y**2 + b4 * x + b5 * y + b6
    else:
        axle, radius, first, step, *heights = values
        at, profile = (y - first) / step, np.array(heights)
        k = np.clip(np.floor(at).astype(int), 0, len(heights) - 2)  # the outermost pieces go on beyond the profile
        h = profile[k] + (at - k) * (profile[k + 1] - profile[k]) + (x - axle) ** 2 / (2 * radius)
    return SampledDistance(h if row is None else h[0])


def counts(group: Group, mx: float, my: float) -> tuple[int, int]:
    """MX and MY as whole numbers."""
    for name, count in (("MX", mx), ("MY", my)):
        if count != int(count) or count < 1:
            group.refuse(name, count, "is not a number of elements")
    if mx * my > MOST_ELEMENTS:
        group.refuse("MX MY", int(mx * my), f"is more than the {MOST_ELEMENTS} elements that can be computed with")
    return int(mx), int(my)


MOST_ELEMENTS = 10_000_000


LONG_ROW = 50
"""Length of a row by its width from which it is as good as endless: the difference is of the order of its square."""


def lattice(group: Group, nx: int, ny: int, dx: float, dy: float, x0: float, y0: float) -> tuple[Grid, Row | None]:
    """The elements; one long row, which stands for plane strain, as a line contact."""
    if ny > 1:
        return Grid(nx=nx, ny=ny, dx=dx, dy=dy, x0=x0, y0=y0), None
    if dy < LONG_ROW * nx * dx:
        group.refuse("MY", 1, f"stands for plane strain, and needs DY of {LONG_ROW} MX DX at least; DY is {dy:g}")
    return Grid(nx=nx, dx=dx, x0=x0), (y0 + dy / 2, dy)
