"""Points below the surface in CONTACT's input files, extremes of the stresses there, and files of
such stresses.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.io.contact_words import MOST_BYTES, Group, numbers_of_line, wrong_line
from varcontact.results.solution import Solution
from varcontact.results.stress import SubsurfaceStress, stress
from varcontact.scene.grid import Grid
from varcontact.system.files import text_of

COUNTS = ["NX", "NY", "NZ"]


def points_of(groups: Sequence[Group], grid: Grid) -> tuple[np.ndarray, ...]:
    """The points of all blocks, (3, points) each: x, y and z."""
    blocks: list[list[Group]] = []
    for group in groups:
        if group.names == ("ISUBS",):
            blocks.append([])
        if blocks:
            blocks[-1].append(group)
    return tuple(_block(block[0].integers()[0], block[1:], grid) for block in blocks)


def _block(isubs: int, groups: Sequence[Group], grid: Grid) -> np.ndarray:
    """Columns and rows of a block: all of the elements, some of them, or separate places."""
    if isubs == 9:
        x, y, z = (np.sort(group.numbers()) for group in groups)
    else:
        columns = np.arange(grid.nx)
        rows = np.arange(grid.rows)
        if isubs in (2, 6):
            columns, rows = (
                _regular(group, count)
                for group, count in zip(groups, (grid.nx, grid.rows), strict=False)
            )
        if isubs in (3, 7):
            columns, rows = (
                _listed(group, count)
                for group, count in zip(groups, (grid.nx, grid.rows), strict=False)
            )
        x = grid.x[columns]
        y = grid.y[rows]
        z = _depths(groups[-1])
    places = np.meshgrid(z, y, x, indexing="ij")
    return np.stack([each.ravel() for each in reversed(places)])


def _regular(group: Group, count: int) -> np.ndarray:
    """Columns or rows from one to another, by steps; counted from 1."""
    first, step, last = group.integers()
    if not 1 <= first <= last:
        group.refuse(group.names[0], first, f"is not in the range 1 to {last}")
    return np.arange(first - 1, min(last, count), max(step, 1))


def _listed(group: Group, count: int) -> np.ndarray:
    numbers = np.unique(np.array(group.numbers(), dtype=int))
    return numbers[(numbers >= 1) & (numbers <= count)] - 1


def _depths(group: Group) -> np.ndarray:
    if group.names[0] == "NZ":
        return group.number(1) + group.number(2) * np.arange(group.count(0))
    return np.sort(group.numbers())


def extremes_below(
    solution: Solution, blocks: Sequence[np.ndarray], sign: float = 1.0
) -> tuple[dict[str, float], ...]:
    """Extremes of stresses at the points of blocks, whose x has a sign; above the contact in the
    other body.
    """
    found = []
    for points in blocks:
        x, y, z = points
        parts: list[dict[str, float]] = []
        for body, inside in ((1, z >= 0), (2, z < 0)):
            if inside.any():
                at = np.stack([sign * x, y, z])[:, inside]
                parts.append(extremes(stress(solution, at, body=body)))
        found.append(_widest(parts))
    return tuple(found)


def _widest(parts: list[dict[str, float]]) -> dict[str, float]:
    """Extremes of both bodies together."""
    together = parts[0]
    for other in parts[1:]:
        together = {name: max(value, other[name], key=abs) for name, value in together.items()}
    return together


def extremes(field: SubsurfaceStress) -> dict[str, float]:
    """The extremes of stresses by CONTACT's names."""
    mean = field.first_invariant / 3
    largest, _, least = field.principal
    found: dict[str, Any] = {
        "SIGHYD": _farthest(mean),
        "SIGVM": field.von_mises.max(),
        "SIGTR": field.tresca.max(),
        "SIGMA1": largest.max(),
        "SIGMA3": least.min(),
    }
    found |= {f"SIG{axis * 2}": _farthest(field.stress[k, k]) for k, axis in enumerate("XYZ")}
    return {name: float(value) for name, value in found.items()}


def _farthest(values: np.ndarray) -> float:
    """Value farthest from zero, with its sign."""
    flat = values.ravel()
    return float(flat[np.abs(flat).argmax()])


@checks.named_options()
def read_contact_stresses(path: str | Path) -> list[dict[str, np.ndarray]]:
    """Displacements and stresses below the surface that CONTACT computed, from its file
    ``<experiment>.<case>.subs``.

    Parameters
    ----------
    path : str or Path
        A table in text, written with S = 1 to 3 and MATFIL = 1 or 2.

    Returns
    -------
    list of dict of str to ndarray, shape (nz, ny, nx)
        A block of points each: X, Y, Z [mm], UX, UY, UZ [mm], SIGHYD, SIGVM and, with MATFIL = 2,
        SIGXX to SIGZZ [N/mm^2], by CONTACT's names.

    Raises
    ------
    SceneError
        If the file cannot be read, or is not of this layout: with the line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "ball.0001.subs"
    >>> _ = path.write_text('''% NX NY NZ - -
    ... 1 1 2 0.0 0.0
    ... % X Y Z UZ SIGVM
    ... 0.0 0.0 0.0 0.404 1.744
    ... 0.0 0.0 0.1 0.380 1.349
    ... ''')
    >>> (block,) = vc.read_contact_stresses(path)
    >>> block["SIGVM"].ravel()
    array([1.744, 1.349])
    >>> folder.cleanup()
    """
    file = checks.file_name("path", path)
    text = text_of("path", file, MOST_BYTES, "a file of CONTACT's subsurface stresses")
    lines = text.splitlines()
    blocks = []
    k = 0
    while k < len(lines):
        if not lines[k].strip():
            k += 1
            continue
        block, k = _read_block(file, lines, k)
        blocks.append(block)
    if not blocks:
        raise wrong_line(file, 1, "has no stresses")
    return blocks


def _read_block(file: Path, lines: Sequence[str], k: int) -> tuple[dict[str, np.ndarray], int]:
    """The block of points that begins with line k, and the line behind it."""
    if lines[k].strip("% ").upper().split()[:3] != COUNTS:
        raise wrong_line(file, k + 1, "should name NX, NY and NZ")
    counts = numbers_of_line(file, k + 2, "".join(lines[k + 1 : k + 2]), 3)[:3]
    if any(count != int(count) or count < 1 for count in counts):
        raise wrong_line(file, k + 2, f"has {counts} for NX, NY and NZ")
    nx, ny, nz = map(int, counts)
    names = "".join(lines[k + 2 : k + 3]).strip("% ").upper().split()
    if names[:3] != ["X", "Y", "Z"]:
        raise wrong_line(file, k + 3, "should name the columns X, Y, Z and more")
    first = k + 3
    last = first + nx * ny * nz
    if last > len(lines):
        raise wrong_line(file, len(lines), f"ends before {nx * ny * nz} points")
    rows = [numbers_of_line(file, row + 1, lines[row], len(names)) for row in range(first, last)]
    table = np.array([row[: len(names)] for row in rows])
    fields = table.T.reshape(len(names), nz, ny, nx)
    return dict(zip(names, fields, strict=True)), last
