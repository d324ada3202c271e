"""A radius within which all stresses of a point contact stay, between the samples, too: proved.

The section is cut into cells of two intervals of samples along each axis, those at the surface into
smaller ones. In a box the stress differs from its quadratic interpolation by what `Remainders`
bounds; the interpolation stays in the convex hull of its control points (Bernstein's form). Boxes
whose bound is above what is aimed at are halved, with stresses of the closed form at new places. A
yield stress that depends on the depth is taken as its lower value at both ends of a box.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np

from varcontact.plasticity.derivatives import Remainders, cubic_remainder
from varcontact.plasticity.half_space import HalfSpace
from varcontact.plasticity.passage import (
    Passage,
    Strength,
    bilinear_layer,
    divided,
    layer_at,
)
from varcontact.plasticity.residual_stress import CellResidual, cells
from varcontact.system.process import lazy_property

TOLERANCE = 3e-3
"""Relative excess over the largest stress at samples at which the proof ends."""
HALVINGS_MAX = 6000
"""Largest number of boxes that are halved."""
WIDE = 0.4
"""Ratio of width to depth above which cells are divided."""
PARTS_MAX = 4
"""Largest number of parts of a cell along x and y."""
FEW = 50
"""Number of cells in a layer up to which they are halved instead of divided, which needs stresses
on a whole lattice."""
SHARE = 0.4
"""Part of the interpolation error at the surface that is kept free for the proof, which halves
boxes there."""
BATCH = 200
"""Boxes halved at once."""
SURFACE_PARTS = 4
"""Parts of an interval along x and y in the cells at the surface."""
SURFACE_LAYERS = 5
"""Layers of cells at the surface, each as thick as all above it together."""
BLOCK = 4
"""Cells along x and y that are bounded together where stresses are small."""
SMALL = 0.6
"""Size of stresses that count as small, divided by the aim of the proof."""
AHEAD = (1.3, 1.7, 2.2, 3.0, 4.0, 5.5, 7.5, 10.0, 15.0, 25.0, 50.0, 100.0)
"""Ends of the boxes before and behind the passage, divided by the distance of its ends from the
middle; beyond the last box the stress itself is bounded."""
HALVED = 0.8
"""Depth in half-widths above which cells have stresses at closer depths."""
LEBESGUE = 1.25
"""Largest value of quadratic interpolation between values of at most 1, the third in the middle."""
INFINITE = 1e6
CHUNK = 4000
"""Boxes computed at once."""


@dataclass(frozen=True, eq=False)
class Boxes:
    """Boxes with the stress at three places along each axis.

    Attributes
    ----------
    low, middle, high : ndarray, shape (n, 3)
        Places x, y, z; those of x and y have equal distances.
    stress : ndarray, shape (n, 3, 3, 3, 5)
        Elastic stress by places along x, y and z.
    cell : ndarray, shape (n, 2)
        First sample of the cell along y and z.
    bound, peak : ndarray, shape (n,)
        Bound on all stresses, and the largest at the places.
    axis : ndarray, shape (n,)
        Along which interpolation misses most.
    """

    low: np.ndarray
    middle: np.ndarray
    high: np.ndarray
    stress: np.ndarray
    cell: np.ndarray
    bound: np.ndarray
    peak: np.ndarray
    axis: np.ndarray

    @classmethod
    def of(
        cls,
        places: tuple[np.ndarray, np.ndarray, np.ndarray],
        stress: np.ndarray,
        cell: np.ndarray,
    ) -> Boxes:
        """Boxes that are not bounded yet."""
        unknown = np.full(len(stress), np.inf)
        return cls(*places, stress, cell, unknown, 0 * cell[:, 0], 0 * cell[:, 0])

    def __len__(self) -> int:
        return len(self.low)

    def __getitem__(self, chosen: np.ndarray | slice) -> Boxes:
        return Boxes(*(getattr(self, each.name)[chosen] for each in fields(self)))

    @classmethod
    def joined(cls, parts: list[Boxes]) -> Boxes:
        """All boxes of several."""
        names = [each.name for each in fields(cls)]
        return cls(*(np.concatenate([getattr(each, name) for each in parts]) for name in names))

    def along(self, axis: int) -> np.ndarray:
        """The three places (n, 3) along an axis."""
        ends = (self.low[:, axis], self.middle[:, axis], self.high[:, axis])
        return np.stack(ends, axis=1)


@dataclass(frozen=True, eq=False)
class PointProof:
    """A residual stress, and the elastic field at the factor that is proved, by the least yield
    stress; lengths by the half-width.

    Attributes
    ----------
    field : HalfSpace
    residual : CellResidual
    strength : callable
        Yield stress by depth, by the least.
    x : ndarray
        Samples of the passage.
    curves : ndarray, shape (nz, ny, nx, 5)
        Elastic stress at the samples.
    parts : int
        Intervals of the passage to an element.
    """

    field: HalfSpace
    residual: CellResidual
    strength: Strength
    x: np.ndarray
    curves: np.ndarray
    parts: int

    @classmethod
    def of(
        cls, passage: Passage, residual: CellResidual, strength: Strength, factor: float
    ) -> PointProof:
        """The proof at a load factor, of a passage that has its field in closed form."""
        assert passage.field is not None
        return cls(
            field=replace(passage.field, load=factor * passage.field.load),
            residual=residual,
            strength=strength,
            x=passage.x,
            curves=factor * passage.curves * passage.strength[:, None, None, None],
            parts=passage.parts,
        )

    def radius(self, enough: float) -> float:
        """Bound on all stresses, divided by the yield stress; boxes are halved until it is
        `enough`.
        """
        aim = max(enough, (1 + TOLERANCE) * self._largest_sample())
        ahead, found, added = self._ahead(aim)
        found = max(found, self._outside())
        waiting = []
        for boxes in (*self._below_surface(), *self._at_surface(), ahead):
            bounded = self._bounded(boxes, aim)
            over = bounded.bound > aim
            found = max(found, float(np.max(bounded.bound[~over], initial=0.0)))
            waiting += self._smaller(bounded[over], aim)
        for boxes in waiting:
            found = max(found, float(np.max(boxes.bound[boxes.bound <= aim], initial=0.0)))
        return max(found, self._halved_until(aim, Boxes.joined(waiting)) + added)

    def _smaller(self, boxes: Boxes, aim: float) -> list[Boxes]:
        """Boxes of one layer, and in place of cells that are wide for their depth their parts."""
        inner = self._single(boxes)
        most = PARTS_MAX
        if not inner.any():
            # the smaller cells at the surface
            inner = self._single(boxes, SURFACE_PARTS)
            most = PARTS_MAX // 2
        own = boxes[inner]
        if len(own) <= FEW or own.low[:, 2].min() < own.low[:, 2].max():
            return [boxes]
        depth = max(float(own.low[0, 2]), float(own.high[0, 2] - own.low[0, 2]))
        wide = float((own.high - own.low)[:, :2].max() / depth)
        parts = min(2 ** max(0, math.ceil(math.log2(wide / WIDE))), most)
        if parts == 1:
            return [boxes]
        return [boxes[~inner], self._bounded(self._parted(own, parts), aim)]

    def _halved_until(self, aim: float, boxes: Boxes) -> float:
        """Bound on all stresses in boxes, halved until they are below the aim or too many."""
        found = 0.0
        for _ in range(HALVINGS_MAX // BATCH):
            # no bound is below a stress
            aim = max(aim, (1 + TOLERANCE) * float(np.max(boxes.peak, initial=0.0)))
            over = boxes.bound > aim
            found = max(found, float(np.max(boxes.bound[~over], initial=0.0)))
            boxes = boxes[over]
            if not len(boxes):
                return found
            worst = np.argsort(-boxes.bound)
            halves = self._bounded(self._halved(boxes[worst[:BATCH]]), aim)
            boxes = Boxes.joined([boxes[worst[BATCH:]], halves])
        return max(found, float(np.max(boxes.bound)))

    def surface_margins(self) -> np.ndarray:
        """Margins (ny, nx) about samples at the surface, relative to the yield stress: the part
        `SHARE` of the error bounds of quadratic interpolation.
        """
        k = float(self.strength(np.zeros(1))[0])
        margins = np.zeros((len(self.residual.y), len(self.x)))
        boxes = next(self._at_surface())
        missed = self._remainders.quadratic(boxes.low, boxes.middle, boxes.high).sum(axis=1)
        size = SHARE * np.linalg.norm(missed, axis=1) / k
        for x, y in ((0, 0), (0, 2), (2, 0), (2, 2)):
            places = (boxes.along(0)[:, x], boxes.along(1)[:, y])
            column = np.abs(self.x[:, None] - places[0]).argmin(axis=0)
            row = np.abs(self.residual.y[:, None] - places[1]).argmin(axis=0)
            np.maximum.at(margins, (row, column), size)
        return margins

    # ------------------------------------------------------------------------- first boxes

    def _largest_sample(self) -> float:
        residual = self.residual.at_samples()
        size = np.linalg.norm(self.curves + residual[:, :, None], axis=-1).max(axis=(1, 2))
        return float((size / self.strength(self.residual.depth)).max())

    def _below_surface(self) -> Iterator[Boxes]:
        """Cells of the passage, but those at the surface near the contact; upper ones in halves."""
        x = cells(self.x)
        y, z = self.residual.starts
        depth = self.residual.depth
        deep = z[depth[z] >= HALVED]
        yield self._of_lattice(self.curves, x, y, deep)
        # other cells by intervals, with stresses at their middles
        count = int(deep[0])
        middle = (depth[:count] + depth[1 : count + 1]) / 2
        closer = np.concatenate([depth[: count + 1], middle])
        order = np.argsort(closer)
        layers = np.array([self._layer(each) for each in middle])
        values = np.concatenate([self.curves[: count + 1], layers])[order]
        samples = (self.x, self.residual.y, closer[order])
        for top in range(count):
            first = np.stack(np.meshgrid(2 * top, y, x, indexing="ij"), axis=-1).reshape(-1, 3)
            cell = first[:, 1::-1].copy()
            cell[:, 1] = 2 * (top // 2)
            boxes = _boxes_at(samples, values, first, cell)
            if top < 2:
                boxes = boxes[~self._near(boxes, depth[2])]
            yield boxes

    def _parted(self, boxes: Boxes, parts: int) -> Boxes:
        """Boxes of one layer and size, divided into `parts` along x and y, and halved in depth."""
        share = np.linspace(0, 1, 2 * parts + 1)
        sides = boxes.high - boxes.low
        along, across = (
            (boxes.low[:, axis, None] + sides[:, axis, None] * share).round(9) for axis in (0, 1)
        )
        top, middle, end = (each[0, 2] for each in (boxes.low, boxes.middle, boxes.high))
        x = np.unique(along)
        y = np.unique(across)
        depth = np.array([top, (top + middle) / 2, middle, (middle + end) / 2, end])
        element = self.field.grid.sides[0]
        closer = round(2 * parts * element / float(sides[0, 0]))
        lattice = (closer, closer)
        values = np.array([layer_at(self.field, lattice, x, y, each) for each in depth])
        # first samples of the parts
        first = np.empty((len(boxes), 2, parts, parts, 3), dtype=int)
        first[..., 0] = np.array([0, 2])[:, None, None]
        first[..., 1] = np.searchsorted(y, across[:, :-2:2])[:, None, :, None]
        first[..., 2] = np.searchsorted(x, along[:, :-2:2])[:, None, None, :]
        cell = np.repeat(boxes.cell, 2 * parts**2, axis=0)
        return _boxes_at((x, y, depth), values, first.reshape(-1, 3), cell)

    def _layer(self, depth: float) -> np.ndarray:
        """Stresses (ny, nx, 5) at a depth, at the samples of the passage."""
        return layer_at(self.field, (self.parts, self.parts), self.x, self.residual.y, depth)

    def _near(self, boxes: Boxes, depth: float) -> np.ndarray:
        """True for cells above a depth that are below the loads."""
        x = self.field.grid.x
        y = self.field.grid.y
        beside_x = (boxes.high[:, 0] < x[0]) | (boxes.low[:, 0] > x[-1])
        beside_y = (boxes.high[:, 1] < y[0]) | (boxes.low[:, 1] > y[-1])
        return (boxes.low[:, 2] < depth) & ~beside_x & ~beside_y & self._single(boxes)

    def _single(self, boxes: Boxes, parts: int = 1) -> np.ndarray:
        """True for cells of two intervals, or such parts of them: farther ones have samples at
        every second element.
        """
        dx, dy = (side / self.parts / parts for side in self.field.grid.sides)
        sides = boxes.high - boxes.low
        return np.isclose(sides[:, 0], 2 * dx) & np.isclose(sides[:, 1], 2 * dy)

    def _of_lattice(self, curves: np.ndarray, x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Boxes:
        """Cells that begin at samples x, y, z of the passage."""
        first = np.stack(np.meshgrid(z, y, x, indexing="ij"), axis=-1).reshape(-1, 3)
        samples = (self.x, self.residual.y, self.residual.depth)
        return _boxes_at(samples, curves, first, first[:, 1::-1])

    def _at_surface(self) -> Iterator[Boxes]:
        """Smaller cells at the surface near the contact, by their depth."""
        y, z = self.residual.starts
        coarse = self._of_lattice(self.curves, cells(self.x), y, z[:1])
        coarse = coarse[self._near(coarse, coarse.high[0, 2])]
        # a closer lattice in the cells' places
        load, grid = divided(self.field.load, self.field.grid, self.parts * SURFACE_PARTS)
        beyond = 3 * SURFACE_PARTS
        closer = HalfSpace(load, grid, self.field.nu)
        ends = coarse.high[0, 2] * np.array([0.0, *0.5 ** np.arange(SURFACE_LAYERS)[::-1]])
        depth = np.interp(np.arange(2 * SURFACE_LAYERS + 1) / 2, np.arange(len(ends)), ends)
        dx, dy = grid.sides
        x = grid.x[0] + dx * np.arange(-beyond, grid.nx + beyond)
        y = grid.y[0] + dy * np.arange(-beyond, grid.rows + beyond)
        # first samples of the small cells
        small = np.arange(0, 2 * SURFACE_PARTS, 2)
        across, along = (each.ravel() for each in np.meshgrid(small, small, indexing="ij"))
        columns = (np.rint((coarse.low[:, 0] - x[0]) / dx).astype(int)[:, None] + along).ravel()
        rows = (np.rint((coarse.low[:, 1] - y[0]) / dy).astype(int)[:, None] + across).ravel()
        cell = np.repeat(coarse.cell, len(across), axis=0)
        first = np.stack([0 * rows, rows, columns], axis=1)
        layers = [bilinear_layer(closer, 0.0, (beyond, beyond))]
        for top in range(0, len(depth) - 1, 2):
            three = depth[top : top + 3]
            below = [bilinear_layer(closer, each, (beyond, beyond)) for each in three[1:]]
            layers = [layers[-1], *below]
            yield _boxes_at((x, y, three), np.moveaxis(np.array(layers), 1, -1), first, cell)

    def _ahead(self, aim: float) -> tuple[Boxes, float, float]:
        """Boxes before and behind the passage where the size of the stress is not enough, a bound
        on all others, and what may be added to that of the last boxes beyond them.
        """
        starts_y, starts_z = self.residual.starts
        cell = np.stack(np.meshgrid(starts_y, starts_z), axis=-1).reshape(-1, 2)
        three = np.arange(3)
        y = self.residual.y[cell[:, :1] + three]
        z = self.residual.depth[cell[:, 1:] + three]
        alone = self.residual.at(y, z, cell)
        missed = self.residual.third_derivatives(y, z) * _cubic(y, z)
        size = np.abs(_controls(alone, z)) + LEBESGUE * missed.sum(axis=1)[:, None, None]
        k = self._least_strength(z[:, [0, 2]])
        size = np.linalg.norm(size, axis=-1).max(axis=(1, 2)) / k
        middle = (self.x[0] + self.x[-1]) / 2
        reach = (self.x[-1] - self.x[0]) / 2
        found = 0.0
        added = 0.0
        kept = []
        for side in (-1.0, 1.0):
            ends = middle + side * reach * np.array([1.0, *AHEAD])
            low = np.stack([np.full(len(cell), ends[-1]), y[:, 0], z[:, 0]], axis=1)
            high = np.stack([np.full(len(cell), side * INFINITE), y[:, 2], z[:, 2]], axis=1)
            far = np.linalg.norm(self._size(low, high), axis=1) / k
            beyond = size + far > aim
            found = max(found, float(np.max((size + far)[~beyond], initial=0.0)))
            for first, last in pairwise(ends):
                low[:, 0] = min(first, last)
                high[:, 0] = max(first, last)
                loaded = np.linalg.norm(self._size(low, high), axis=1) / k
                over = size + loaded > aim
                if last == ends[-1]:
                    over |= beyond
                    added = max(added, float(np.max((far + loaded)[beyond], initial=0.0)))
                found = max(found, float(np.max((size + loaded)[~over], initial=0.0)))
                x = np.linspace(low[over, 0], high[over, 0], 3).T
                kept.append(self._new((x, y[over], z[over]), cell[over]))
        return Boxes.joined(kept), found, added

    def _size(self, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        return self._remainders.stress(np.minimum(low, high), np.maximum(low, high))

    def _outside(self) -> float:
        """Bound on the stress beside and below the section, where the residual stress is zero."""
        last = self.residual.y[-1]
        below = [-INFINITE, -INFINITE, self.residual.depth[-1]]
        beside = [-INFINITE, last, 0.0]
        low = [below, beside]
        high = [[INFINITE] * 3] * 2
        if self.residual.y[0] < -last / 2:  # not one half of a symmetric section
            low.append([-INFINITE, -INFINITE, 0.0])
            high.append([INFINITE, float(self.residual.y[0]), INFINITE])
        return float(np.linalg.norm(self._size(np.array(low), np.array(high)), axis=1).max())

    # ------------------------------------------------------------------------- bounds

    @lazy_property
    def _remainders(self) -> Remainders:
        return Remainders(self.field)

    def _bounded(self, boxes: Boxes, aim: float) -> Boxes:
        """The boxes with their bounds."""
        chunks = [boxes[first : first + CHUNK] for first in range(0, len(boxes), CHUNK)]
        if not chunks:
            return boxes
        return Boxes.joined([self._bounded_chunk(each, aim) for each in chunks])

    def _bounded_chunk(self, boxes: Boxes, aim: float) -> Boxes:
        y = boxes.along(1)
        z = boxes.along(2)
        # consecutive boxes along x have the same residual stress
        section, first, number = np.unique(
            np.concatenate([y, z], axis=1), axis=0, return_index=True, return_inverse=True
        )
        number = number.ravel()
        own_y, own_z = np.split(section, 2, axis=1)
        residual = self.residual.at(own_y, own_z, boxes.cell[first])[number]
        bent = self.residual.third_derivatives(own_y, own_z) * _cubic(own_y, own_z)
        total = boxes.stress + residual[:, None]
        k = self._least_strength(z[:, [0, 2]])
        total = total / k[:, None, None, None, None]
        points = _controls(np.moveaxis(total, 1, 3), z)
        points = _along_first(np.moveaxis(points, 3, 1))
        size = np.linalg.norm(points, axis=-1).max(axis=(1, 2, 3))
        missed, axis = self._missed(boxes, k, size < SMALL * aim, bent[number])
        largest = np.abs(points) + missed[:, None, None, None]
        bound = np.linalg.norm(largest, axis=-1).max(axis=(1, 2, 3))
        # closer control points where these are too far away
        over = np.isfinite(bound) & (bound > aim) & (size > aim / (1 + TOLERANCE))
        bound[over] = _bounds_by_halves(points[over], missed[over])
        peak = np.linalg.norm(total, axis=-1).max(axis=(1, 2, 3))
        return replace(boxes, bound=bound, axis=axis, peak=peak)

    def _missed(
        self, boxes: Boxes, k: np.ndarray, small: np.ndarray, bent: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Interpolation error bounds (n, 5), relative to the yield stress, and the axis that adds
        most; in blocks where stresses are `small`. `bent` (n, 3, 5): those of the residual stress.
        """
        missed = np.zeros((len(boxes), 3, 5))
        missed[small] = self._missed_in_blocks(boxes[small])
        failed = small & ~(np.linalg.norm(missed.sum(axis=1), axis=-1) < (1 - SMALL) * k)
        exact = ~small | failed
        own = boxes[exact]
        missed[exact] = self._remainders.quadratic(own.low, own.middle, own.high)
        missed += bent
        missed *= np.array([1.0, LEBESGUE, LEBESGUE**2])[:, None] / k[:, None, None]
        return missed.sum(axis=1), np.linalg.norm(missed, axis=2).argmax(axis=1)

    def _missed_in_blocks(self, boxes: Boxes) -> np.ndarray:
        """Bounds (n, 3 axes, 5) on the interpolation error, from distances of blocks of boxes of
        one depth.
        """
        if not len(boxes):
            return np.empty((0, 3, 5))
        side = boxes.high - boxes.low
        block = np.floor(boxes.middle / (BLOCK * side.max(axis=0))).astype(int)
        block[:, 2] = np.unique(boxes.low[:, 2], return_inverse=True)[1]
        _, first, number = np.unique(block, axis=0, return_index=True, return_inverse=True)
        number = number.ravel()
        low = np.full((len(first), 3), np.inf)
        high = np.full((len(first), 3), -np.inf)
        np.minimum.at(low, number, boxes.low)
        np.maximum.at(high, number, boxes.high)
        largest = np.zeros((len(first), 3))
        np.maximum.at(largest, number, side)
        middle = (boxes.middle - boxes.low)[first] / side[first] * largest
        box = (0 * largest, middle, largest)
        return self._remainders.in_blocks(low, high, box)[number]

    def _least_strength(self, depth: np.ndarray) -> np.ndarray:
        """Least yield stress over the depths (n, ends) of boxes."""
        return np.asarray(self.strength(depth)).min(axis=1)

    # ------------------------------------------------------------------------- halves

    def _halved(self, boxes: Boxes) -> Boxes:
        """Both halves of each box, along its axis."""
        return Boxes.joined(
            [self._halved_along(boxes[boxes.axis == axis], axis) for axis in range(3)]
        )

    def _halved_along(self, boxes: Boxes, axis: int) -> Boxes:
        places = [boxes.along(each) for each in range(3)]
        old = places[axis]
        quarter = (old[:, 0] + old[:, 1]) / 2
        later = (old[:, 1] + old[:, 2]) / 2
        places[axis] = np.stack([quarter, later], axis=1)
        new = np.moveaxis(self._stress_at(places), 1 + axis, 1)
        known = np.moveaxis(boxes.stress, 1 + axis, 1)
        halves = []
        for number, between in enumerate((quarter, later)):
            ends = old[:, number : number + 2]
            places[axis] = np.stack([ends[:, 0], between, ends[:, 1]], axis=1)
            stress = np.stack([known[:, number], new[:, number], known[:, number + 1]], axis=1)
            corners = tuple(
                np.stack([each[:, part] for each in places], axis=1) for part in range(3)
            )
            halves.append(
                Boxes.of(
                    (corners[0], corners[1], corners[2]),
                    np.moveaxis(stress, 1, 1 + axis),
                    boxes.cell,
                )
            )
        return Boxes.joined(halves)

    def _new(self, places: tuple[np.ndarray, np.ndarray, np.ndarray], cell: np.ndarray) -> Boxes:
        """Boxes with three places (n, 3) along each axis."""
        corners = [np.stack([each[:, part] for each in places], axis=1) for part in range(3)]
        return Boxes.of((corners[0], corners[1], corners[2]), self._stress_at([*places]), cell)

    def _stress_at(self, places: list[np.ndarray]) -> np.ndarray:
        """Stress (n, x, y, z, 5) at all combinations of places (n, number) along the axes."""
        x, y, z = places
        shape = (len(x), x.shape[1], y.shape[1], z.shape[1])
        points = np.empty((3, *shape))
        points[0] = x[:, :, None, None]
        points[1] = y[:, None, :, None]
        points[2] = z[:, None, None, :]
        return self.field.stress(points.reshape(3, -1)).reshape(*shape, 5)


def _boxes_at(
    samples: tuple[np.ndarray, np.ndarray, np.ndarray],
    values: np.ndarray,
    first: np.ndarray,
    cell: np.ndarray,
) -> Boxes:
    """Boxes that begin at the samples `first` (n, 3), along z, y and x, of values (z, y, x, 5) at
    the places x, y, z.
    """
    three = np.arange(3)
    layers = first[:, 0, None, None, None] + three
    rows = first[:, 1, None, None, None] + three[:, None]
    columns = first[:, 2, None, None, None] + three[:, None, None]
    places = [
        np.stack([samples[axis][first[:, 2 - axis] + part] for axis in range(3)], axis=1)
        for part in range(3)
    ]
    return Boxes.of((places[0], places[1], places[2]), values[layers, rows, columns], cell)


def _cubic(y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Errors (n, 3 axes, 1) of quadratic interpolation of cubic functions, per unit of their third
    derivative; zero along x.
    """
    found = np.zeros((len(y), 3, 1))
    for axis, places in ((1, y), (2, z)):
        found[:, axis] = cubic_remainder(*places.T)[:, None]
    return found


def _controls(values: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Control points along y and z of values (n, 3 y, 3 z, ...)."""
    points = _along_first(values)
    share = ((z[:, 1] - z[:, 0]) / (z[:, 2] - z[:, 0])).reshape(-1, *[1] * (values.ndim - 2))
    first, middle, last = np.moveaxis(points, 2, 0)
    own = middle - (1 - share) ** 2 * first - share**2 * last
    return np.stack([first, own / (2 * share * (1 - share)), last], axis=2)


def _along_first(values: np.ndarray) -> np.ndarray:
    """Control points along the second axis, whose places have equal distances."""
    first, middle, last = np.moveaxis(values, 1, 0)
    return np.stack([first, 2 * middle - (first + last) / 2, last], axis=1)


def _bounds_by_halves(points: np.ndarray, missed: np.ndarray) -> np.ndarray:
    """Bounds (n,) by control points of halves and quarters of the boxes."""
    for _ in range(2):
        for axis in (1, 2, 3):
            points = _of_halves(points, axis)
    largest = np.abs(points) + missed[:, None, None, None]
    return np.asarray(np.linalg.norm(largest, axis=-1).max(axis=(1, 2, 3)))


def _of_halves(points: np.ndarray, axis: int) -> np.ndarray:
    """Control points of the halves along an axis, by De Casteljau."""
    points = np.moveaxis(points, axis, 0)
    first = points[0:-1:2]
    middle = points[1::2]
    last = points[2::2]
    parts = np.empty((2 * len(points) - 1, *points.shape[1:]))
    parts[0::4] = points[0::2]
    parts[1::4] = (first + middle) / 2
    parts[3::4] = (middle + last) / 2
    parts[2::4] = (parts[1::4] + parts[3::4]) / 2
    return np.moveaxis(parts, 0, axis)
