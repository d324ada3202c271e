"""A radius within which all stresses of a line contact stay, between the samples, too: proved.

In a layer from the depth z to z + d the residual stress is constant. There ``A + z' B`` is a mean,
by Poisson's kernel, of ``A + z B + (z' - z) B`` at the depth z: A and B are harmonic. So its size
is at most that of ``A + z B`` or of ``A + z B + d B`` at the depth z, whichever is larger
somewhere along x; between samples along x it is bounded by linear interpolation and
`HalfPlane.between`. A yield stress that depends on the depth is taken as its least value at both
ends of a layer.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from varcontact.plasticity.half_plane import HalfPlane
from varcontact.plasticity.passage import Strength

THINNEST = 1e-6
"""Depth of the first layer, in half-widths."""
GROWTH = 2.0
"""Ratio of the depths of the next layers."""
TOLERANCE = 2e-3
"""Relative excess over the largest stress at samples at which the proof ends."""
LAYERS_MAX = 500
"""Largest number of layers that are examined."""
PARTS_MAX = 256
"""Number of intervals between two nodes beyond which they are not halved again."""


@dataclass(frozen=True)
class DepthLayer:
    """Depths from `top` to `end`, a bound on all stresses in it, and the largest one at its top."""

    top: float
    end: float
    radius: float
    peak: float

    def __lt__(self, other: DepthLayer) -> bool:
        return self.radius > other.radius


@dataclass(frozen=True, eq=False)
class Proof:
    """Residual stress of a line contact at the load factor 1: minus the centres (n, 5) at depths
    (n,), by the yield stress, linear between.
    """

    field: HalfPlane
    strength: Strength
    depths: np.ndarray
    centres: np.ndarray
    unit: float

    def radius(self, enough: float) -> float:
        """Bound on all stresses, divided by the yield stress; refined until it is `enough`."""
        last = float(self.depths[-1])
        below = self.field.below(last) / float(self.strength(np.array([last]))[0])
        below += float(np.linalg.norm(self.centre(last)))
        return float(max(below, self.layers(enough)[0].radius))

    def layers(self, enough: float) -> list[DepthLayer]:
        """Layers from the surface to the last depth, of which the first has the largest radius."""
        layers = [self._layer(*ends, enough) for ends in pairwise(self._first_tops())]
        heapq.heapify(layers)
        looked_at = len(layers)
        while layers[0].radius > enough and looked_at < LAYERS_MAX:
            worst = heapq.heappop(layers)
            # no bound is below a stress
            enough = max(enough, (1 + TOLERANCE) * worst.peak)
            middle = (worst.top + worst.end) / 2
            if worst.top == 0:
                middle = worst.end / 16
            heapq.heappush(layers, self._layer(worst.top, middle, enough))
            heapq.heappush(layers, self._layer(middle, worst.end, enough))
            looked_at += 2
        return layers

    def centre(self, depth: float) -> np.ndarray:
        """Minus the residual stress (5,) at a depth; layers take that in their middle."""
        return np.array([np.interp(depth, self.depths, each) for each in self.centres.T])

    def _first_tops(self) -> list[float]:
        """The surface, thin layers below it, and the depths whose residual stress is known."""
        positive = self.depths[self.depths > 0]
        first = THINNEST * self.unit
        count = int(np.ceil(np.log(positive[0] / first) / np.log(GROWTH)))
        thin = first * GROWTH ** np.arange(max(count, 0))
        return [0.0, *thin.tolist(), *positive.tolist()]

    def _layer(self, top: float, end: float, enough: float) -> DepthLayer:
        """Layer with a bound on all its stresses, refined along x until the bound is `enough`."""
        k = float(np.min(self.strength(np.array([top, end]))))
        ends = _LayerEnds(self.field, top, end - top, k, self.centre((top + end) / 2))
        upper, lower = ends.sizes(*self.field.stress(top))
        between = self.field.between(top, ends.ahead) / k
        radius, peak = ends.largest(upper, lower, between, enough)
        far = self.field.beside(top, ends.ahead) / k + float(np.linalg.norm(ends.centre))
        return DepthLayer(top, end, max(radius + ends.added, far), peak)


@dataclass(frozen=True, eq=False)
class _LayerEnds:
    """Sizes of ``A + z B`` and of ``A + z B + d B`` minus the centre at the top z of a layer,
    divided by the yield stress k.
    """

    field: HalfPlane
    top: float
    thickness: float
    k: float
    centre: np.ndarray

    @property
    def ahead(self) -> float:
        """Depth over which B is followed; zero at the surface, where B is infinite at kinks and
        `added` is its bound.
        """
        if self.top > 0:
            return self.thickness
        return 0.0

    @property
    def added(self) -> float:
        if self.top > 0:
            return 0.0
        return self.field.near_surface(self.thickness) / self.k

    def sizes(self, mean: np.ndarray, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sizes (n,) of both."""
        moved = mean / self.k - self.centre
        if self.top > 0:
            moved = moved + self.top / self.k * slope
        size = np.linalg.norm(moved, axis=1)
        if self.top == 0:
            return size, size
        return size, np.linalg.norm(moved + self.thickness / self.k * slope, axis=1)

    def largest(
        self, upper: np.ndarray, lower: np.ndarray, between: np.ndarray, enough: float
    ) -> tuple[float, float]:
        """Bound on all sizes from those at the samples, with more samples until it is small enough;
        and the largest size at the samples of the layer's top.
        """
        size = np.maximum(upper, lower)
        peak = float(upper.max())
        left = self.field.x[:-1]
        first = size[:-1]
        last = size[1:]
        bound = np.maximum(first, last) + between[:-1]
        step = self.field.spacing
        kept = 0.0
        while True:
            over = bound > max(enough, (1 + TOLERANCE / 2) * float(np.max(first, initial=peak)))
            kept = max(kept, float(np.max(bound[~over], initial=0.0)))
            if not over.any() or step < self.field.spacing / PARTS_MAX:
                return max(kept, float(np.max(bound[over], initial=0.0))), peak
            # halves of these intervals
            step = step / 2
            left = left[over]
            upper, lower = self.sizes(*self.field.stress_at(left + step, self.top))
            peak = max(peak, float(upper.max()))
            middle = np.maximum(upper, lower)
            first = np.concatenate([first[over], middle])
            last = np.concatenate([middle, last[over]])
            left = np.concatenate([left, left + step])
            missed = self.field.between_at(left, step, self.top, self.ahead) / self.k
            bound = np.maximum(first, last) + missed
