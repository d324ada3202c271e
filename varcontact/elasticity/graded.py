"""Graded half-spaces: a modulus of rigidity that changes with the depth, as a power or
exponentially.

Their compliance by wave number is that of homogeneous slices, extrapolated to
none of them thick. Source of the extrapolation: L. F. Richardson, Phil. Trans.
R. Soc. A 226 (1927) 299-361; slices of a constant modulus have an error of
second order in their thickness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.checks import Checked, number, poisson_ratio, positive
from varcontact.elasticity.layered import CUT, Stack, half_space
from varcontact.errors import SceneError
from varcontact.scene.bodies import Relaxations, Stratified
from varcontact.system.process import lazy_property

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

SLICES = 160
"""Slices of the coarser of two stacks: the error of the extrapolated compliance is 1e-4
(tests/elasticity/test_graded.py)."""
NODES_BY_DECADE = 24
"""Wave numbers per decade at which the compliance is computed; a cubic spline over their logarithm
connects them."""
EXPONENTIAL_REACH = 10.0
"""Depth, divided by the decay length, below which the deep modulus is used: exp(-10) = 5e-5 is
left."""
POWER_REACH = 1e4
"""Depth, divided by the scale of the power law, below which the modulus is constant: contacts are
much smaller."""


@dataclass(frozen=True)
class Graded(Checked, Stratified, path="bodies", G=positive, nu=poisson_ratio, depth=positive):
    """A half-space whose modulus of rigidity changes with the depth z.

    Exponentially, ``G_deep + (G - G_deep) exp(-z/depth)``, or as a power,
    ``G (1 + z/depth)^exponent``: graded coatings, carburised steel, soil.

    Parameters
    ----------
    G : float
        Modulus of rigidity at the surface, positive [stress].
    nu : float
        Poisson's ratio in (-1, 0.5], the same at all depths.
    depth : float
        Length over which the modulus changes, positive [length].
    G_deep : float, optional
        Modulus far below, positive [stress]: an exponential change.
    exponent : float, optional
        In [0, 2]: a change as a power.

    Raises
    ------
    SceneError
        For entries out of range, and unless exactly one of `G_deep` and
        `exponent` is given.

    Examples
    --------
    >>> Graded(G=1.0, nu=0.3, depth=2.0, exponent=0.5).modulus([0.0, 6.0])
    array([1., 2.])
    """

    G: float
    nu: float
    depth: float
    G_deep: float | None = None
    exponent: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.G_deep is None) == (self.exponent is None):
            given = (self.G_deep, self.exponent)
            raise SceneError("bodies.G_deep, bodies.exponent", given, "exactly one of the two")
        if self.G_deep is not None:
            object.__setattr__(self, "G_deep", positive("bodies.G_deep", self.G_deep))
        if self.exponent is not None:
            exponent = number("bodies.exponent", self.exponent)
            if not 0 <= exponent <= 2:
                raise SceneError("bodies.exponent", exponent, "in [0, 2]")
            object.__setattr__(self, "exponent", exponent)

    def modulus(self, depth: np.ndarray) -> np.ndarray:
        """Modulus of rigidity at a `depth`, zero or positive [length]."""
        ratio = np.asarray(depth, dtype=float) / self.depth
        if self.exponent is not None:
            return np.asarray(self.G * (1 + ratio) ** self.exponent)
        assert self.G_deep is not None
        return np.asarray(self.G_deep + (self.G - self.G_deep) * np.exp(-ratio))

    @property
    def materials(self) -> list[tuple[float, float, Relaxations]]:
        """G, nu and relaxations at the surface and far below."""
        deepest = float(self.modulus(np.array(self.depth * self._reach)))
        return [(self.G, self.nu, ()), (deepest, self.nu, ())]

    def stack(self, G: float, length: float) -> GradedStack:
        """Compliance of the body by wave number, in units of a modulus `G` and a `length`."""
        coarse = self._sliced(SLICES, G, length)
        fine = self._sliced(2 * SLICES, G, length)
        return GradedStack(fine.layers, fine.base, coarse)

    @property
    def _reach(self) -> float:
        return POWER_REACH if self.exponent is not None else EXPONENTIAL_REACH

    def _sliced(self, slices: int, G: float, length: float) -> Stack:
        """Homogeneous slices, thicker downwards, with the moduli of their middles; the first has
        that of the surface.
        """
        places = np.linspace(0.0, 1.0, slices + 1) ** 2
        if self.exponent is None:
            edges = self._reach * places
            middles = (edges[1:] + edges[:-1]) / 2
        else:
            # far below, the moduli of consecutive slices have a nearly constant ratio
            edges = np.expm1(places * np.log1p(self._reach))
            middles = np.expm1((places[1:] + places[:-1]) / 2 * np.log1p(self._reach))
        moduli = self.modulus(self.depth * middles) / G
        thicknesses = np.diff(edges) * self.depth / length
        layers = tuple(
            (h, modulus, self.nu)
            for h, modulus in zip(thicknesses.tolist(), moduli.tolist(), strict=True)
        )
        deepest = float(self.modulus(np.array(self.depth * self._reach))) / G
        return Stack(((layers[0][0], self.G / G, self.nu), *layers[1:]), (deepest, self.nu))


@dataclass(frozen=True)
class GradedStack(Stack):
    """Graded body as slices, and as half as many: the compliance is extrapolated to slices of zero
    thickness.
    """

    coarse: Stack

    @property
    def surface(self) -> np.ndarray:
        return half_space(*self.layers[0][1:])

    def compliance(self, k: np.ndarray) -> np.ndarray:
        """F11, F12, F22 and f at wave numbers (n,), shape (4, n)."""
        least, largest, spline = self._by_logarithm
        inside = np.clip(k, least, largest)
        # short waves depend on the surface, and on deeper parts in proportion to their length
        short = np.minimum(largest / np.maximum(k, largest), 1.0)
        surface = self.surface[:, None]
        return np.asarray(surface + (spline(np.log(inside)) - surface) * short)

    @lazy_property
    def _by_logarithm(self) -> tuple[float, float, CubicSpline]:
        """Compliance over the logarithm of wave numbers, and the range of these."""
        from scipy.interpolate import CubicSpline

        deepest = sum(h for h, _, _ in self.layers)
        least = 1e-3 / deepest
        largest = CUT / self.thickness
        count = math.ceil(NODES_BY_DECADE * np.log10(largest / least))
        nodes = np.linspace(np.log(least), np.log(largest), count)
        fine = super().compliance(np.exp(nodes))
        coarse = self.coarse.compliance(np.exp(nodes))
        return least, largest, CubicSpline(nodes, fine + (fine - coarse) / 3, axis=1)
