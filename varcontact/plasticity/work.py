"""Means of elastic stress over triangles, by which a mechanism's work is counted, and bounds on
what they miss.

Stresses are sampled on the cells of a mesh, and quadratic along each axis of a cell. In closed form
they come with bounds on what this interpolation misses (`derivatives`). Other fields are
interpolated between the samples of their passage, and what is missed is estimated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.plasticity.derivatives import Remainders
from varcontact.plasticity.flow_mesh import Mesh, mean_weights
from varcontact.plasticity.passage import Passage, Strength, layer_at

LEBESGUE = 1.25
"""Largest value of quadratic interpolation between values of at most 1, the third in the middle."""
BLOCK = 0.2
"""Length in half-widths of samples along x whose errors are bounded together."""
SIDE = 1e-3
"""Of boxes along x, where nothing is interpolated."""


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
        """By the field in closed form, or by interpolation through so many samples of a passage."""
        rows = len(mesh.depth) - 1
        columns = len(mesh.y) - 1
        curves = np.empty((4, columns, rows, 3, len(passage.x), 5))
        radius = np.empty((4, columns, rows, 3))
        for row in range(rows):
            by_sample, by_cell = mean_weights(mesh.cells[row], mesh.layers[row])
            y, depth = mesh.samples(row)
            stress = _sampled(passage, y.ravel(), depth, order)
            stress = stress.reshape(len(depth), *y.shape, len(passage.x), 5)
            curves[:, :, row] = np.einsum("svzy,zkyxq->skvxq", by_sample, stress, optimize=True)
            at_ends = strength(depth[::2])
            larger = np.maximum(at_ends[1:], at_ends[:-1])
            radius[:, :, row] = (by_cell.sum(axis=3) @ larger)[:, None]
        return cls(passage, mesh, curves.reshape(-1, len(passage.x), 5), radius.ravel())

    def missed(self, corner: np.ndarray, along: np.ndarray, strains: np.ndarray) -> float:
        """Bound on the work that is missed for strains (n, 5) of corners at samples along x."""
        assert self.passage.field is not None
        rows = len(self.mesh.depth) - 1
        triangle, vertex = np.divmod(corner, 3)
        side, rectangle = np.divmod(triangle, rows * (len(self.mesh.y) - 1))
        column, row = np.divmod(rectangle, rows)
        x = self.passage.x
        block = np.floor((x[along] - x[0]) / BLOCK).astype(int)
        remainders = Remainders(self.passage.field)
        total = 0.0
        for number in np.unique(row):
            own = row == number
            pairs, pair = np.unique(
                np.stack([column[own], block[own]], axis=1), axis=0, return_inverse=True
            )
            errors = self._errors(remainders, number, pairs)
            each = errors[pair.ravel(), side[own], vertex[own]]
            total += float(np.sum(np.abs(strains[own]) * each))
        return total

    def _errors(self, remainders: Remainders, row: int, pairs: np.ndarray) -> np.ndarray:
        """Bounds (pairs, 4, 3, 5) for rectangles of a row, and blocks along x."""
        mesh = self.mesh
        cells = mesh.cells[row]
        _, shares = mean_weights(cells, mesh.layers[row])
        # at the surface, cells one by one; below it, those of one layer together
        parts = 1
        if row == 0:
            parts = cells
        y = np.linspace(mesh.y[:-1], mesh.y[1:], parts + 1, axis=1)[pairs[:, 0]]
        z = mesh.layer_ends(row)
        first = self.passage.x[0] + BLOCK * pairs[:, 1]
        low = np.empty((len(pairs), len(z) - 1, parts, 3))
        high = np.empty_like(low)
        low[..., 0] = first[:, None, None]
        high[..., 0] = first[:, None, None] + BLOCK
        low[..., 1] = y[:, None, :-1]
        high[..., 1] = y[:, None, 1:]
        low[..., 2] = z[:-1, None]
        high[..., 2] = z[1:, None]
        box = np.empty_like(low)
        box[..., 0] = SIDE
        box[..., 1] = (np.diff(mesh.y)[pairs[:, 0]] / cells)[:, None, None]
        box[..., 2] = np.diff(z)[:, None]
        low, high, box = (each.reshape(-1, 3) for each in (low, high, box))
        found = remainders.in_blocks(low, high, (0 * box, box / 2, box))
        missed = (found[:, 1] + LEBESGUE * found[:, 2]).reshape(len(pairs), len(z) - 1, parts, 5)
        shares = shares.reshape(*shares.shape[:3], parts, -1).sum(axis=-1)
        return np.einsum("svzy,pzyq->psvq", shares, missed)


def _sampled(passage: Passage, y: np.ndarray, depth: np.ndarray, order: int) -> np.ndarray:
    """Elastic stress (depths, y, x, 5) by the least yield stress."""
    field = passage.field
    if field is not None:
        places, number = np.unique(y.round(9), return_inverse=True)
        # the middle of a symmetric section is on a lattice of even parts
        parts = max(2, round(field.grid.sides[1] / float(np.diff(places).min())))
        lattice = (passage.parts, parts)
        layers = [layer_at(field, lattice, passage.x, places, each)[number] for each in depth]
        return np.array(layers)
    stress = passage.curves * passage.strength[:, None, None, None]
    first_y, weights_y = _lagrange(passage.y, y, order)
    first_z, weights_z = _lagrange(passage.depth, depth, order)
    nodes = first_y[:, None] + np.arange(order)
    found = np.empty((len(depth), len(y), *stress.shape[2:]))
    for number, (first, weights) in enumerate(zip(first_z, weights_z, strict=True)):
        layer = np.tensordot(weights, stress[first : first + order], axes=1)
        found[number] = np.einsum("yn,ynxq->yxq", weights_y, layer[nodes])
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
