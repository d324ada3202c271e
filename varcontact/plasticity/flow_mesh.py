"""Meshes of velocities in a section: rectangles of four triangles, and cells in rectangles.

Rectangles of a block have the same cells: equal ones along y, and layers, which are thinner towards
the surface in the first row. Fields are sampled at three places along each axis of a cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from varcontact.plasticity.passage import Passage

DEPTH_POWER = 1.6
"""Exponent of the depth of rectangles as a function of their number."""
WIDTH_POWER = 1.4
"""Exponent of the distance of rectangles from the contact as a function of their number."""
EXTENT = 0.9
"""Part of the passage's section that the mesh covers."""
CELLS_MAX = 4
"""Largest number of cells along y of rectangles below the contact, except in the first row."""
SURFACE_CELLS = 4
"""Cells in an element at the surface, where no cell may have a node inside."""
DEPTHS = (0.7, 1.5)
"""Depths in half-widths from which cells are twice and four times as large."""
SURFACE_LAYERS = 12
"""Layers of the first row."""
GROWTH = 1.35
"""Ratio of the lower to the upper depth of these layers."""
LAYER = 0.2
"""Thickness of other layers, divided by the upper depth of their row."""
QUADRATURE_WEIGHTS = np.repeat([0.225, 0.132394152788506, 0.125939180544827], [1, 3, 3])
QUADRATURE_POINTS = (0.470142064105115, 0.101286507323456)
"""Radon's rule of degree 5 on a triangle: barycentric coordinates of two of its points."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with quadratic velocities in a section.

    Attributes
    ----------
    nodes : ndarray, shape (triangles, 6)
        Corners, then middles of the edges opposite them. Triangles are ordered by the side of their
        rectangle, rectangles by y and then depth.
    places : ndarray, shape (n, 2)
        y and depth of the nodes, divided by the half-width.
    area : ndarray, shape (triangles,)
    gradients : ndarray, shape (triangles, 3, 6, 2)
        Of the shape functions at the corners.
    held : ndarray, shape (3, n)
        Where velocities along x, y, z are zero.
    y, depth : ndarray
        Edges of the rectangles.
    blocks : tuple of Block
        All rectangles, by their cells.
    """

    nodes: np.ndarray
    places: np.ndarray
    area: np.ndarray
    gradients: np.ndarray
    held: np.ndarray
    y: np.ndarray
    depth: np.ndarray
    blocks: tuple[Block, ...]

    @property
    def corners(self) -> np.ndarray:
        """The first three nodes of each triangle."""
        return self.nodes[:, :3]

    def samples(self, block: Block) -> tuple[np.ndarray, np.ndarray]:
        """Places y (rectangles, 2 cells + 1) and depths (2 layers + 1) of a block's samples."""
        share = np.linspace(0, 1, 2 * block.cells + 1)
        ends = self.y[block.first : block.last + 1]
        y = ends[:-1, None] + np.diff(ends)[:, None] * share
        depth = self.layer_ends(block)
        middles = (depth[1:] + depth[:-1]) / 2
        return y, np.sort(np.concatenate([depth, middles]))

    def layer_ends(self, block: Block) -> np.ndarray:
        """Depths (layers + 1) of a block's layers."""
        top, end = self.depth[block.row : block.row + 2]
        return np.asarray(top + (end - top) * np.array(block.layers))


@dataclass(frozen=True)
class Block:
    """Rectangles of a row, from a first to before a last one, with the same cells.

    Attributes
    ----------
    row, first, last : int
    cells : int
        Along y.
    parts : int
        Of an element, on whose lattice the samples are; even, as it has the middle of the contact.
    layers : tuple of float
        Ends of layers, from 0 to 1.
    """

    row: int
    first: int
    last: int
    cells: int
    parts: int
    layers: tuple[float, ...]


def flow_mesh(passage: Passage, inside: int, outside: int, down: int) -> Mesh:
    """Mesh with about these numbers of rectangles across the contact, beside it on either side, and
    in depth, each of four triangles; one half of it if the passage is symmetric.

    Rectangles are 1, 2, 4 ... elements wide in the contact and multiples of that beside it.
    """
    left, right = passage.loaded[2:]
    element = passage.parts * float(np.diff(passage.y).min())
    wide = 2 ** max(0, round(np.log2((right - left) / element / inside)))
    side = wide * element
    # whole rectangles, from the middle of a symmetric section or the node before the first, to the
    # node beyond the last: tractions have a kink there
    start = left
    if passage.symmetric:
        start = 0.0
    elif passage.field is not None:
        start = float(passage.field.grid.y[0])
    node = right + element / passage.parts / 2
    last = int(np.ceil((node - start) / side - 1e-9))
    beyond = int(EXTENT * (passage.y[-1] - start) / side) - last
    steps = (np.arange(1, outside + 1) / outside) ** WIDTH_POWER
    added = np.unique(np.maximum(np.rint(beyond * steps), np.arange(1, outside + 1)))
    number = np.concatenate([np.arange(last + 1), last + added])
    if not passage.symmetric:
        number = np.concatenate([-added[::-1], number])
    depth = EXTENT * passage.depth[-1] * np.linspace(0, 1, down + 1) ** DEPTH_POWER
    y = start + side * number
    blocks = _blocks(depth, np.diff(number) == 1, wide)
    return _triangulated(y, depth, blocks, passage.symmetric)


def _blocks(depth: np.ndarray, inner: np.ndarray, wide: int) -> tuple[Block, ...]:
    """Blocks of rows with the ends `depth`: cells are smaller in the `inner` columns, whose
    rectangles are `wide` elements wide.
    """
    columns = np.flatnonzero(inner)
    first = int(columns[0])
    last = int(columns[-1]) + 1
    blocks = []
    for row, (top, end) in enumerate(pairwise(depth)):
        cells = SURFACE_CELLS * wide
        layers = [0.0, *(GROWTH ** np.arange(1 - SURFACE_LAYERS, 1.0)).tolist()]
        if row > 0:
            coarser = int(np.searchsorted(DEPTHS, (top + end) / 2))
            cells = max(min(2 * wide, CELLS_MAX) // 2**coarser, 1)
            count = max(2, round((end - top) / top / LAYER))
            layers = np.linspace(0, 1, count + 1).tolist()
        parts = max(2, 2 * cells // wide)
        blocks.append(Block(row, first, last, cells, parts, tuple(layers)))
        for left, right in ((0, first), (last, len(inner))):
            if right > left:
                blocks.append(Block(row, left, right, 2 * wide, 4, tuple(layers)))
    return tuple(blocks)


def _triangulated(
    y: np.ndarray,
    depth: np.ndarray,
    blocks: tuple[Block, ...],
    symmetric: bool,
) -> Mesh:
    # corners of rectangles, and their middles
    lattice = np.stack(np.meshgrid(y, depth, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(lattice)).reshape(len(y), len(depth))
    around = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    ring = [each.ravel() for each in around]
    centre = len(lattice) + np.arange(ring[0].size)
    points = np.concatenate([lattice, (lattice[ring[0]] + lattice[ring[2]]) / 2])
    triangles = [np.stack([ring[side], ring[(side + 1) % 4], centre], axis=-1) for side in range(4)]
    corners = np.concatenate(triangles)
    # middles of the edges
    edges = np.concatenate([corners[:, [1, 2]], corners[:, [2, 0]], corners[:, [0, 1]]])
    unique, inverse = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    nodes = np.concatenate([corners, len(points) + inverse.reshape(3, -1).T], axis=1)
    places = np.concatenate([points, points[unique].mean(axis=1)])
    # areas, and gradients of the shape functions at the corners
    at = points[corners]
    jacobian = np.stack([at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]], axis=1)
    inverse_jacobian = np.linalg.inv(jacobian)
    second = inverse_jacobian[:, :, 0]
    third = inverse_jacobian[:, :, 1]
    barycentric = np.stack([-second - third, second, third], axis=1)
    edge = np.isclose(places[:, 0], y[-1]) | np.isclose(places[:, 1], depth[-1])
    left = np.isclose(places[:, 0], y[0])
    held = np.array([edge, edge, edge])
    if symmetric:
        held[1] |= left
    else:
        held |= left
    return Mesh(
        nodes=nodes,
        places=places,
        area=np.abs(np.linalg.det(jacobian)) / 2,
        gradients=_gradients(barycentric),
        held=held,
        y=y,
        depth=depth,
        blocks=blocks,
    )


def _gradients(barycentric: np.ndarray) -> np.ndarray:
    """Gradients (triangles, 3 corners, 6 nodes, 2) of quadratic shape functions."""
    gradients = np.zeros((len(barycentric), 3, 6, 2))
    for corner in range(3):
        for node in range(3):
            gradients[:, corner, node] = (4 * (corner == node) - 1) * barycentric[:, node]
        for opposite in range(3):
            first = (opposite + 1) % 3
            second = (opposite + 2) % 3
            if corner == first:
                gradients[:, corner, 3 + opposite] = 4 * barycentric[:, second]
            elif corner == second:
                gradients[:, corner, 3 + opposite] = 4 * barycentric[:, first]
    return gradients


@lru_cache(maxsize=16)
def mean_weights(cells: int, layers: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Means over the four triangles of a rectangle with the weights 3 N/area of their corners,
    of a field that is quadratic along both axes of each cell: by samples (4, 3, 2 layers + 1, 2
    cells + 1), and the shares of the cells in them (4, 3, layers, cells).
    """
    by_sample = np.zeros((4, 3, 2 * len(layers) - 1, 2 * cells + 1))
    by_cell = np.zeros((4, 3, len(layers) - 1, cells))
    ring = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    for side in range(4):
        triangle = np.array([ring[side], ring[(side + 1) % 4], [0.5, 0.5]])
        for row in range(len(layers) - 1):
            for column in range(cells):
                low = np.array([column / cells, layers[row]])
                high = np.array([(column + 1) / cells, layers[row + 1]])
                places, areas = _quadrature(_clipped(triangle, low, high))
                weights = 12 * areas[:, None] * _barycentric(places, triangle)
                across, down = ((places - low) / (high - low)).T
                sampled = np.einsum("qv,qz,qy->vzy", weights, _three(down), _three(across))
                rows = slice(2 * row, 2 * row + 3)
                columns = slice(2 * column, 2 * column + 3)
                by_sample[side, :, rows, columns] += sampled
                by_cell[side, :, row, column] = weights.sum(axis=0)
    return by_sample, by_cell


def _clipped(polygon: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """The part of a convex polygon (n, 2) in a rectangle (Sutherland and Hodgman)."""
    for axis in range(2):
        for bound, sign in ((low[axis], 1.0), (high[axis], -1.0)):
            inside = sign * (polygon[:, axis] - bound)
            kept = []
            for number, depth in enumerate(inside):
                before = inside[number - 1]
                if before * depth < 0:
                    share = before / (before - depth)
                    kept.append((1 - share) * polygon[number - 1] + share * polygon[number])
                if depth >= 0:
                    kept.append(polygon[number])
            polygon = np.array(kept).reshape(-1, 2)
    return polygon


def _quadrature(polygon: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 2) and areas (n,) of Radon's rule in triangles of a polygon."""
    corners = [polygon[[0, number, number + 1]] for number in range(1, len(polygon) - 1)]
    triangles = np.array(corners).reshape(-1, 3, 2)
    edges = triangles[:, 1:] - triangles[:, :1]
    areas = np.abs(np.linalg.det(edges)) / 2
    places = np.einsum("qc,tcd->tqd", _rule(), triangles)
    return places.reshape(-1, 2), (areas[:, None] * QUADRATURE_WEIGHTS).ravel()


def _rule() -> np.ndarray:
    """Barycentric coordinates (7, 3) of the quadrature's points."""
    first, second = (
        np.full((3, 3), other) + (1 - 3 * other) * np.eye(3) for other in QUADRATURE_POINTS
    )
    return np.concatenate([np.full((1, 3), 1 / 3), first, second])


def _barycentric(places: np.ndarray, corners: np.ndarray) -> np.ndarray:
    ones = np.ones((len(places), 1))
    matrix = np.concatenate([corners, np.ones((3, 1))], axis=1)
    return np.concatenate([places, ones], axis=1) @ np.linalg.inv(matrix)


def _three(share: np.ndarray) -> np.ndarray:
    """Weights (n, 3) of quadratic interpolation between 0, 1/2 and 1."""
    return np.stack(
        [(1 - share) * (1 - 2 * share), 4 * share * (1 - share), share * (2 * share - 1)], axis=-1
    )
