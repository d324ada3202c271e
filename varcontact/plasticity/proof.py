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
"""Excess over the largest stress at samples at which the proof ends."""
LAYERS_MAX = 500
"""Layers at most that are looked at."""
PARTS_MAX = 128
"""Samples from node to node at most."""


@dataclass(frozen=True)
class Layer:
    """Depths from `top` to `end`, looked at with so many samples from node to node.

    `radius` bounds all stresses in it; of that `along` is for what lies between samples along x,
    `down` for the thickness.
    """

    top: float
    end: float
    parts: int
    radius: float
    along: float
    down: float

    @property
    def can_be_refined(self) -> bool:
        return self.parts < PARTS_MAX or self.down >= self.along

    def __lt__(self, other: Layer) -> bool:
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
        """Bound on all stresses, by the yield stress; refined until it is `enough`."""
        last = float(self.depths[-1])
        below = self.field.below(last) / float(self.strength(np.array([last]))[0])
        below += float(np.linalg.norm(self.centre(last)))
        return max(below, self.layers(enough)[0].radius)

    def layers(self, enough: float) -> list[Layer]:
        """Layers from the surface to the last depth, of which the first has the largest radius."""
        fields = {1: self.field}
        layers = [self._layer(fields, *ends, 1) for ends in pairwise(self._first_tops())]
        heapq.heapify(layers)
        looked_at = len(layers)
        while layers[0].radius > enough and looked_at < LAYERS_MAX and layers[0].can_be_refined:
            worst = heapq.heappop(layers)
            for layer in self._refined(fields, worst):
                heapq.heappush(layers, layer)
                looked_at += 1
        return layers

    def centre(self, depth: float) -> np.ndarray:
        """Minus the residual stress at a depth, and of a layer that in its middle."""
        return np.array([np.interp(depth, self.depths, each) for each in self.centres.T])

    def _first_tops(self) -> list[float]:
        """The surface, thin layers below it, and the depths whose residual stress is known."""
        positive = self.depths[self.depths > 0]
        first = THINNEST * self.unit
        count = int(np.ceil(np.log(positive[0] / first) / np.log(GROWTH)))
        thin = first * GROWTH ** np.arange(max(count, 0))
        return [0.0, *thin.tolist(), *positive.tolist()]

    def _refined(self, fields: dict[int, HalfPlane], layer: Layer) -> list[Layer]:
        """A layer with samples twice as close, or its halves."""
        if layer.along > layer.down and layer.parts < PARTS_MAX:
            return [self._layer(fields, layer.top, layer.end, 2 * layer.parts)]
        middle = (layer.top + layer.end) / 2
        if layer.top == 0:
            middle = layer.end / 16
        return [
            self._layer(fields, layer.top, middle, layer.parts),
            self._layer(fields, middle, layer.end, layer.parts),
        ]

    def _layer(self, fields: dict[int, HalfPlane], top: float, end: float, parts: int) -> Layer:
        """The bound on all stresses in a layer."""
        if parts not in fields:
            fields[parts] = fields[parts // 2].finer()
        field = fields[parts]
        k = float(np.min(self.strength(np.array([top, end]))))
        thickness = end - top
        centre = self.centre((top + end) / 2)
        mean, slope = field.stress(top)
        # at the samples, and between them
        moved = mean / k - centre
        if top == 0:
            down = field.near_surface(end) / k
            largest, along = _largest(np.linalg.norm(moved, axis=1), field.between(0.0, 0.0) / k)
            largest += down
        else:
            moved = moved + top / k * slope
            size = np.linalg.norm(moved, axis=1)
            lower = np.linalg.norm(moved + thickness / k * slope, axis=1)
            between = field.between(top, thickness) / k
            largest, along = _largest(np.maximum(size, lower), between)
            down = largest - _largest(size, between)[0]
        far = field.beside(top, thickness) / k + float(np.linalg.norm(centre))
        return Layer(top, end, parts, max(largest, far), along, down)


def _largest(size: np.ndarray, between: np.ndarray) -> tuple[float, float]:
    """Bound on a size between samples, too, and what of it is for these."""
    total = size + between
    total[:-1] = np.maximum(total[:-1], size[1:] + between[:-1])
    number = int(total.argmax())
    return float(total[number]), float(between[number])
