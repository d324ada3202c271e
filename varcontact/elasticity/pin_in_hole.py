"""A disc in a hole of an infinite plate, nearly of one radius, in plane strain: influence numbers
of arcs.

With tractions ``N + i T`` on the disc (outwards, and counter-clockwise) in
powers of ``s = exp(i theta)``, ``t_k s^k``, and ``c = 1/(2 G)``,
``kappa = 3 - 4 nu`` of the disc (1) and of the plate (2), Kolosov's potentials
give the difference of their displacements ``u_r + i u_theta``: R times
``(c1 kappa1 + c2) t_k s^k/(k + 1)`` for k > 0, ``(c1 + c2 kappa2) t_k s^k/(|k| - 1)``
for k < -1, ``(c1 (kappa1 - 1)/2 + c2) Re t_0``, and ``-c1 (conj(t_-1) s +
conj(t_1)/s)`` by the force at the disc's centre that balances the tractions.
The sums are ``-ln(1 - s)/s - 1`` and ``-ln(1 - 1/s)/s``: the numbers of two
half-planes, turned by theta, with the chord as the distance, and smooth terms.
Source: N. I. Muskhelishvili, Some basic problems of the mathematical theory of
elasticity (1953), chapter 15.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.elasticity.operators import GridOperator
from varcontact.scene.grid import Grid
from varcontact.transports import HERE, Stencil


@dataclass(frozen=True)
class PinInHoleMedium:
    """The disc, body 1, in the hole of body 2, dimensionless.

    Displacements are resolved in the frame of their element, also those ahead in a step of rolling.
    They count from the points at the distance `depth` from a line load.
    """

    radius: float
    G: tuple[float, float]
    nu: tuple[float, float]
    depth: float
    even = True
    reciprocal = True

    @property
    def K(self) -> float:
        """Size of the coupling: pressures rotated by an angle act as tractions, also for like
        bodies.
        """
        return 1.0

    @property
    def at_once(self) -> PinInHoleMedium:
        return self

    def at_end(self, time: float) -> PinInHoleMedium:
        return self

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""
        side = lattice.sides[0] / self.radius
        angles = np.arange(1 - lattice.nx, lattice.nx) * side
        table = np.zeros((len(rows), len(columns), 1, angles.size))
        for ahead, weight in stencil:
            numbers = self._influence(angles, side, ahead / self.radius)
            for i, row in enumerate(rows):
                for j, column in enumerate(columns):
                    if row + column in numbers:
                        table[i, j, 0] += weight * numbers[row + column]
        return GridOperator(lattice.shape, table)

    def _influence(self, angle: np.ndarray, side: float, ahead: float) -> dict[str, np.ndarray]:
        """Displacements `ahead` of points at an `angle` from the centre of an arc over a `side`, in
        the frames of the points [rad].
        """
        start = angle + ahead - side / 2
        end = angle + ahead + side / 2
        c1, c2 = 1 / (2 * np.array(self.G))
        kappa1, _ = 3 - 4 * np.array(self.nu)
        # of N + i T, of its conjugate, of N alone
        turned = self._turned(end) - self._turned(start)
        of_conjugate = -2 * c1 * (np.sin(end) - np.sin(start))
        of_radial = (c1 * (kappa1 - 1) / 2 + c2) * side
        into_frame = self.radius / (2 * np.pi) * np.exp(1j * ahead)
        by_radial = into_frame * (turned + of_conjugate + of_radial)
        by_tangential = 1j * into_frame * (turned - of_conjugate)
        return {
            "xx": by_tangential.imag,
            "zx": -by_tangential.real,
            "xz": -by_radial.imag,
            "zz": by_radial.real,
            "yy": self.radius / np.pi * (self._antiplane(end) - self._antiplane(start)),
        }

    def _turned(self, angle: np.ndarray) -> np.ndarray:
        """Integral from 0 to an angle of displacements that are linear in N + i T."""
        c1, c2 = 1 / (2 * np.array(self.G))
        kappa1, kappa2 = 3 - 4 * np.array(self.nu)
        inner = c1 * kappa1 + c2
        outer = c1 + c2 * kappa2
        back = np.exp(-1j * angle)
        # (1 - 1/s) ln(1 - s), and 0 where s = 1
        apart = np.where(back == 1, 1.0, 1 - back)
        log = (1 - back) * np.log(-apart / back)
        log_back = (1 - back) * np.log(apart)
        depth = np.log(self.depth / self.radius)
        return 1j * (inner * log + outer * (log_back + back) + (inner + outer) * depth * back)

    def _antiplane(self, angle: np.ndarray) -> np.ndarray:
        """Integral from 0 to an angle of ``-ln(2 sin(theta/2)) + ln(depth/radius)``, times 1/G1 +
        1/G2: Clausen's function.
        """
        from scipy.special import spence

        clausen = spence(1 - np.exp(1j * angle)).imag
        return (1 / np.array(self.G)).sum() * (clausen + angle * np.log(self.depth / self.radius))
