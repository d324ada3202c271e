"""Means of elastic stress over triangles, for the work of a mechanism, and bounds on their errors.

Stresses are sampled on the cells of a mesh, and quadratic along each axis of a cell. In closed form
they come with bounds on what this interpolation misses (`derivatives`). Other fields are
interpolated between the samples of their passage, and what is missed is estimated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.plasticity.derivatives import Remainders
from varcontact.plasticity.flow_mesh import Block, Mesh, mean_weights
from varcontact.plasticity.half_space import HalfSpace
from varcontact.plasticity.passage import Passage, Strength, layer_at

LEBESGUE = 1.25
"""Largest value of quadratic interpolation between values of at most 1, the third in the middle."""
TOGETHER = 0.2
"""Length in half-widths of samples along x whose errors are bounded together."""
SIDE = 1e-3
"""Side of boxes along x, along which nothing is interpolated."""


@dataclass(frozen=True, eq=False)
class Means:
    """Means over triangles with the weights 3 N/area of their corners, by the least yield stress.

    Attributes
    ----------
    passage : Passage
    mesh : Mesh
    curves : ndarray, shape (corners, nx, 5)
        Elastic stress.
    radius : ndarray, shape (corners,)
        Yield stress, the larger one at the upper and lower end of each cell.
    """

    passage: Passage
    mesh: Mesh
    curves: np.ndarray
    radius: np.ndarray

    @classmethod
    def of(cls, passage: Passage, mesh: Mesh, strength: Strength, order: int = 4) -> Means:
        """Means from the field in closed form, or from interpolation through `order` samples of a
        passage along y and depth.
        """
        rows = len(mesh.depth) - 1
        columns = len(mesh.y) - 1
        curves = np.empty((4, columns, rows, 3, len(passage.x), 5))
        radius = np.empty((4, columns, rows, 3))
        for block in mesh.blocks:
            by_sample, by_cell = mean_weights(block.cells, block.layers)
            y, depth = mesh.samples(block)
            if passage.field is None:
                stress = _interpolated(passage, y, depth, order)
            else:
                stress = _in_closed_form(passage.field, passage, y, depth, block.parts)
            own = (slice(None), slice(block.first, block.last), block.row)
            curves[own] = np.einsum("svzy,zkyxq->skvxq", by_sample, stress, optimize=True)
            at_ends = strength(depth[::2])
            larger = np.maximum(at_ends[1:], at_ends[:-1])
            radius[own] = (by_cell.sum(axis=3) @ larger)[:, None]
        return cls(passage, mesh, curves.reshape(-1, len(passage.x), 5), radius.ravel())

    def missed(self, corner: np.ndarray, along: np.ndarray, strains: np.ndarray) -> float:
        """Bound on the work error for strains (n, 5) of corners at samples along x."""
        assert self.passage.field is not None
        rows = len(self.mesh.depth) - 1
        triangle, vertex = np.divmod(corner, 3)
        side, rectangle = np.divmod(triangle, rows * (len(self.mesh.y) - 1))
        column, row = np.divmod(rectangle, rows)
        x = self.passage.x
        length = np.floor((x[along] - x[0]) / TOGETHER).astype(int)
        remainders = Remainders(self.passage.field)
        total = 0.0
        for each in self.mesh.blocks:
            own = (row == each.row) & (column >= each.first) & (column < each.last)
            if not own.any():
                continue
            pairs, pair = np.unique(
                np.stack([column[own], length[own]], axis=1), axis=0, return_inverse=True
            )
            errors = self._errors(remainders, each, pairs)[pair.ravel(), side[own], vertex[own]]
            total += float(np.sum(np.abs(strains[own]) * errors))
        return total

    def _errors(self, remainders: Remainders, block: Block, pairs: np.ndarray) -> np.ndarray:
        """Bounds (pairs, 4, 3, 5) for rectangles of a block, and numbers of lengths along x."""
        mesh = self.mesh
        cells = block.cells
        _, shares = mean_weights(cells, block.layers)
        # at the surface, cells one by one; below it, those of one layer together
        parts = 1
        if block.row == 0:
            parts = cells
        y = np.linspace(mesh.y[:-1], mesh.y[1:], parts + 1, axis=1)[pairs[:, 0]]
        z = mesh.layer_ends(block)
        first = self.passage.x[0] + TOGETHER * pairs[:, 1]
        low = np.empty((len(pairs), len(z) - 1, parts, 3))
        high = np.empty_like(low)
        low[..., 0] = first[:, None, None]
        high[..., 0] = first[:, None, None] + TOGETHER
        low[..., 1] = y[:, None, :-1]
        high[..., 1] = y[:, None, 1:]
        low[..., 2] = z[:-1, None]
        high[..., 2] = z[1:, None]
        box = np.empty_like(low)
        box[..., 0] = SIDE
        box[..., 1] = (np.diff(mesh.y)[pairs[:, 0]] / cells)[:, None, None]
        box[..., 2] = np.diff(z)[:, None]
        sides = box.reshape(-1, 3)
        found = remainders.in_blocks(
            low.reshape(-1, 3), high.reshape(-1, 3), (0 * sides, sides / 2, sides)
        )
        missed = (found[:, 1] + LEBESGUE * found[:, 2]).reshape(len(pairs), len(z) - 1, parts, 5)
        shares = shares.reshape(*shares.shape[:3], parts, -1).sum(axis=-1)
        return np.einsum("svzy,pzyq->psvq", shares, missed)


def _in_closed_form(
    field: HalfSpace, passage: Passage, y: np.ndarray, depth: np.ndarray, parts: int
) -> np.ndarray:
    """Elastic stress (depths, *y.shape, x, 5), divided by the least yield stress."""
    found = np.empty((len(depth), *y.shape, len(passage.x), 5))
    places, number = np.unique(y.round(9), return_inverse=True)
    for place, each in enumerate(depth):
        layer = layer_at(field, (passage.parts, parts), passage.x, places, each)
        found[place] = layer[number.reshape(y.shape)]
    return found


def _interpolated(passage: Passage, y: np.ndarray, depth: np.ndarray, order: int) -> np.ndarray:
    """Elastic stress (depths, *y.shape, x, 5), divided by the least yield stress, interpolated
    through `order` samples of the passage along y and depth.
    """
    found = np.empty((len(depth), *y.shape, len(passage.x), 5))
    stress = passage.curves * passage.strength[:, None, None, None]
    first_y, weights_y = _lagrange(passage.y, y.ravel(), order)
    first_z, weights_z = _lagrange(passage.depth, depth, order)
    nodes = first_y[:, None] + np.arange(order)
    for place, (first, weights) in enumerate(zip(first_z, weights_z, strict=True)):
        layer = np.tensordot(weights, stress[first : first + order], axes=1)
        found[place] = np.einsum("yn,ynxq->yxq", weights_y, layer[nodes]).reshape(found.shape[1:])
    return found


def _lagrange(places: np.ndarray, at: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """First sample and weights (points, order) of Lagrange's interpolation."""
    first = np.clip(np.searchsorted(places, at) - order // 2, 0, len(places) - order)
    nodes = places[first[:, None] + np.arange(order)]
    weights = np.ones((len(at), order))
    for own in range(order):
        for other in range(order):
            if own != other:
                weights[:, own] *= (at - nodes[:, other]) / (nodes[:, own] - nodes[:, other])
    return first, weights
