"""Points below the surface in CONTACT's input files, and extremes of the stresses there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from varcontact.io.contact_words import Group
from varcontact.results.stress import SubsurfaceStress
from varcontact.scene.grid import Grid


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
    """All columns and rows of the elements, some of them, or places of their own."""
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
    """That farthest from zero."""
    flat = values.ravel()
    return float(flat[np.abs(flat).argmax()])
