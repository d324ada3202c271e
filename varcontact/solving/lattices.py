"""The lattices of many Hertzian contacts at once, and the pressures on their elements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from varcontact.elasticity.operators import edge_compliance
from varcontact.reference.hertz import HertzContact
from varcontact.scene.grid import Grid


@dataclass(frozen=True, eq=False)
class Lattices:
    """The elements of n scenes, x (nx, n) and y (ny, n) of their centres, and the parts of the load that they carry."""

    sides: np.ndarray  # (2, n)
    x: np.ndarray
    y: np.ndarray
    share: np.ndarray
    compliance: np.ndarray | None = None


def side_by_side(some: Sequence[Lattices]) -> Lattices:
    """Those of several shapes in one: behind the rows and columns of the smaller ones nothing is carried."""
    if len(some) == 1:
        return some[0]
    ny, nx = np.max([each.share.shape[:2] for each in some], axis=0)
    shapes = {"sides": (2,), "x": (nx,), "y": (ny,), "share": (ny, nx)}
    return Lattices(
        *(np.concatenate([padded(getattr(each, name), to) for each in some], -1) for name, to in shapes.items())
    )


def padded(field: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """A field (..., *own shape, n) with zeros behind it, up to the `shape`."""
    own = field.shape[-len(shape) - 1 : -1]
    behind = [(0, to - size) for to, size in zip(shape, own, strict=True)]
    return np.pad(field, [(0, 0)] * (field.ndim - len(shape) - 1) + behind + [(0, 0)])


def of_scenes(grid: Grid | None, grids: list[Grid], contacts: list[HertzContact]) -> Lattices:
    """A grid across each contact: the unit circle's, stretched; or `grids` that have their own place."""
    if grid is None:
        return _in_place(grids, contacts)
    a, b = np.array([[contact.a, 0.0 if grid.line else contact.b] for contact in contacts]).T
    circle = HertzContact(1.0, math.inf if grid.line else 1.0, 0.0, 1.0, 1.0, 1.0, 1.0)
    half = 0.5 if grid.line else 1.0
    lattice = grid.spread((-1.0, 1.0, -half, half))
    sides, x, y = np.multiply.outer(lattice.sides, a), np.multiply.outer(lattice.x, a), np.multiply.outer(lattice.y, b)
    sides[1] = 1.0 if grid.line else lattice.sides[1] * b
    pressure = circle.on_elements(lattice)
    share = np.repeat((pressure / pressure.sum())[..., None], len(a), axis=-1)
    soft = grid.edge == "softened"
    return Lattices(sides, x, y, share, edge_compliance(circle.covered(*lattice.lines)) if soft else None)


def _in_place(grids: list[Grid], contacts: list[HertzContact]) -> Lattices:
    """Grids that have their own place; where the contact goes on outside nothing is carried."""
    shares = [contact.on_elements(grid) for grid, contact in zip(grids, contacts, strict=True)]
    for share, grid, contact in zip(shares, grids, contacts, strict=True):
        left, right, bottom, top = grid.box
        along_y = grid.line or (bottom <= -contact.b and contact.b <= top)
        share /= share.sum() if share.any() and left <= -contact.a and contact.a <= right and along_y else math.inf
    x, y, sides = (np.array([getattr(grid, name) for grid in grids]).T for name in ("x", "y", "sides"))
    return Lattices(sides, x, y, np.stack(shares, axis=-1))
