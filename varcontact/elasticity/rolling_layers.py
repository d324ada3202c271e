"""Influence numbers of line contact of layers that are viscoelastic solids of
their own and roll steadily.

At a wave number k along x everything swings with the frequency k V, so that
layers have complex moduli ``G/(1 + sum f/(1 - i k l))``, ``l = V tau``, and
compliances are those of elastic layers. Source: G. F. M. Braat, J. J. Kalker
(1993), rolling contact of two cylinders coated with multilayered viscoelastic
rubber (paper, [4]).

Half-spaces of the surfaces' solids are taken in closed form, and to these is
added what relaxed, elastic layers add. The rest of the symbols vanishes for
long waves and for short ones; it is integrated as it stands.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.elasticity.layered import LayeredPair, Stack, added_numbers, wave_numbers
from varcontact.elasticity.operators import Homogeneous
from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property

WAVES_AT_ONCE = 2_000_000
"""Wave numbers times points of one matrix product."""


@dataclass(frozen=True)
class Solids:
    """Instantaneous stack, and the relaxations (f, l) of its layers, from the surface, and of its
    base.
    """

    stack: Stack
    relaxations: tuple[tuple[tuple[float, float], ...], ...]

    def at(self, k: np.ndarray | None = None) -> Stack:
        """The stack with complex moduli at wave numbers (n,), or relaxed."""
        if k is None:
            compliances: list[Any] = [1 + sum(f for f, _ in each) for each in self.relaxations]
        else:
            compliances = [
                1 + 0 * k + sum(f / (1 - 1j * k * far) for f, far in each)
                for each in self.relaxations
            ]
        layers = tuple(
            (h, G / J, nu) for (h, G, nu), J in zip(self.stack.layers, compliances, strict=False)
        )
        base = self.stack.base
        if not isinstance(base, str):
            G, nu = base
            base = (G / compliances[-1], nu)
        return Stack(layers, base)


@dataclass(frozen=True)
class RollingLayers(Homogeneous):
    """Two stacks of viscoelastic layers that roll steadily, and half-spaces of the surfaces'
    solids: a `Medium`.
    """

    surfaces: Homogeneous
    upper: Solids
    lower: Solids
    depth: float

    @property
    def even(self) -> bool:
        """False: the history of a particle lies ahead of it along x."""
        return False

    @property
    def glassy(self) -> LayeredPair:
        return LayeredPair(self.upper.stack, self.lower.stack, self.depth)

    @lazy_property
    def relaxed(self) -> LayeredPair:
        return LayeredPair(self.upper.at(), self.lower.at(), self.depth)

    @lazy_property
    def K(self) -> float:
        """Largest size of the coupling over all wave numbers."""
        if self.upper == self.lower:
            return 0.0
        k = np.geomspace(1e-6, 1e3, 400) / self.relaxed.thickness
        return max(
            float(np.abs(self._rolling(k).symbols(k)[1]).max()) / 2,
            self.relaxed.K,
            abs(self.surfaces.K),
        )

    def _rolling(self, k: np.ndarray) -> LayeredPair:
        return LayeredPair(self.upper.at(k), self.lower.at(k))

    def influence(
        self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        """Influence numbers of strips: xz by ``Re int i kappa S exp(ikx)/k``, S the transform of a
        strip.
        """
        x = np.asarray(x, dtype=float)
        dx, _ = grid.sides
        names = list(components)
        half_spaces = self.surfaces.influence(grid, x, y, names)
        added = added_numbers(self.relaxed, grid, x, y, names)
        # the rest of the symbols
        k, weights = wave_numbers(self.relaxed.thickness, 0.0, float(np.abs(x).max()) + dx)
        rolling = self._rolling(k)
        alpha, kappa, gamma, beta = (rolling.symbols(k) - rolling.symbols()) - (
            self.relaxed.symbols(k) - self.relaxed.symbols()[:, None]
        )
        rest = {"xx": alpha, "yy": beta, "zz": gamma, "xz": 1j * kappa, "zx": -1j * kappa}
        rest = {name: rest[name] for name in names if name in rest}
        # its integral over wave numbers
        strip = weights * np.sinc(k * dx / (2 * np.pi)) * dx / (np.pi * k)
        symbols = np.array([symbol * strip for symbol in rest.values()])
        waves = np.zeros((len(symbols), x.size))
        places = x.ravel()
        for part in np.array_split(np.arange(k.size), 1 + k.size * x.size // WAVES_AT_ONCE):
            waves += (symbols[:, part] @ np.exp(1j * k[part, None] * places)).real
        numbers = dict(half_spaces)
        for i, name in enumerate(rest):
            numbers[name] = half_spaces[name] + added[name] + waves[i].reshape(x.shape)
        return numbers
