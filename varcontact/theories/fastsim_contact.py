"""FASTSIM as CONTACT marches it, for comparisons with its results.

Beside `fastsim`, four things differ: the first element of a row takes a whole
step of rigid slip, also where the leading edge passes through it; flexibilities
are by Kalker's coefficients in the three digits in which he printed them
(1990, Table E.3), linear in the ratio of the semi-axes; they go over from three
to one mean flexibility as creepages grow; and slope and friction are reduced by
one number for the whole contact (Spiryagin, Polach and Cole, Veh. Syst. Dyn. 51,
2013). Source of the variants: the public sources of CONTACT up to 2023, under
the Apache licence; the passage from three flexibilities to one is fitted to the
results published with its example of FASTSIM.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene

WIDE = (
    ((2.51, 3.31, 4.85), (2.51, 2.52, 2.53), (0.334, 0.473, 0.731)),
    ((2.59, 3.37, 4.81), (2.59, 2.63, 2.66), (0.483, 0.603, 0.809)),
    ((2.68, 3.44, 4.80), (2.68, 2.75, 2.81), (0.607, 0.715, 0.889)),
    ((2.78, 3.53, 4.82), (2.78, 2.88, 2.98), (0.720, 0.823, 0.977)),
    ((2.88, 3.62, 4.83), (2.88, 3.01, 3.14), (0.827, 0.929, 1.07)),
    ((2.98, 3.72, 4.91), (2.98, 3.14, 3.31), (0.930, 1.03, 1.18)),
    ((3.09, 3.81, 4.97), (3.09, 3.28, 3.48), (1.03, 1.14, 1.29)),
    ((3.19, 3.91, 5.05), (3.19, 3.41, 3.65), (1.13, 1.25, 1.40)),
    ((3.29, 4.01, 5.12), (3.29, 3.54, 3.82), (1.23, 1.36, 1.51)),
    ((3.40, 4.12, 5.20), (3.40, 3.67, 3.98), (1.33, 1.47, 1.63)),
)
LONG = (
    ((10.7, 11.7, 12.9), (10.7, 12.8, 16.0), (12.2, 14.6, 18.0)),
    ((6.96, 7.78, 8.82), (6.96, 8.14, 9.79), (5.72, 6.63, 7.89)),
    ((5.57, 6.34, 7.34), (5.57, 6.40, 7.51), (3.79, 4.32, 5.01)),
    ((4.84, 5.57, 6.57), (4.84, 5.48, 6.31), (2.88, 3.24, 3.70)),
    ((4.37, 5.10, 6.11), (4.37, 4.90, 5.56), (2.35, 2.62, 2.96)),
    ((4.06, 4.78, 5.80), (4.06, 4.50, 5.04), (2.01, 2.23, 2.50)),
    ((3.82, 4.54, 5.58), (3.82, 4.21, 4.67), (1.76, 1.95, 2.18)),
    ((3.65, 4.36, 5.42), (3.65, 3.99, 4.39), (1.58, 1.75, 1.94)),
    ((3.51, 4.22, 5.30), (3.51, 3.81, 4.16), (1.44, 1.59, 1.77)),
    ((3.40, 4.12, 5.20), (3.40, 3.67, 3.98), (1.33, 1.47, 1.63)),
)
"""C11, C22 and C23 of Table E.3 at nu = 0, 1/4 and 1/2, for a/b of .1 to 1, and b/a of .1 to 1."""
SLENDER = 0.101
"""Ratio of semi-axes below which asymptotes replace the table."""
BLENDED = 3.0
"""Creepage, divided by the characteristic one, from which a single flexibility is used; below,
three blend into it."""


@dataclass(frozen=True)
class SimplifiedTheory:
    """Parameters of CONTACT's simplified theory, with its digits B and M."""

    elliptic: bool | None
    """Hertz's pressure, a parabolic one; None: that of half-spaces, which is solved for."""
    flexibility: float | None = None
    slope: tuple[float, float, float] = (1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class SimplifiedTractions:
    """Pressure (ny, nx) and tractions (2, ny, nx) on the elements [force/area]."""

    grid: Grid
    pressure: np.ndarray
    traction: np.ndarray

    @property
    def force(self) -> np.ndarray:
        """Fx and Fy."""
        return np.asarray(self.traction.sum(axis=(1, 2)) * self.grid.area)

    @property
    def moment(self) -> float:
        """Mz about the origin."""
        px, py = self.traction
        about_z = self.grid.x[None, :] * py - self.grid.y[:, None] * px
        return float(about_z.sum() * self.grid.area)


def printed_coefficients(ratio: float, nu: float) -> np.ndarray:
    """C11, C22 and C23 by the printed table, at a ratio a/b of the semi-axes."""
    g = min(ratio, 1 / ratio)
    if g < SLENDER:
        return np.array(_asymptotes(g, nu, ratio < 1))
    table = np.array(WIDE)
    if ratio > 1:
        table = np.array(LONG)
    k = int(10 * g - 0.005)
    part = 10 * g - k
    at_nu = part * table[k] + (1 - part) * table[k - 1]
    weights = np.array([8 * (nu - 0.25) * (nu - 0.5), -16 * nu * (nu - 0.5), 8 * nu * (nu - 0.25)])
    return np.asarray(1 / (weights / at_nu).sum(axis=1))


def _asymptotes(g: float, nu: float, wide: bool) -> tuple[float, float, float]:
    """Creepage coefficients C11, C22, C23 of slender contacts (asymptotes), g = a/b if wide, else
    b/a.
    """
    if wide:
        C23 = math.pi * math.sqrt(g) / (3 * (1 - nu)) * (1 + nu * (math.log(16 / g) - 5))
        return math.pi**2 / (4 * (1 - nu)), math.pi**2 / 4, C23
    log = math.log(16 / g**2)
    rest = 3 - math.log(4)
    along = log - 2 * nu
    across = (1 - nu) * log + 2 * nu
    C11 = 2 * math.pi / (along * g) * (1 + rest / along)
    C22 = 2 * math.pi / (across * g) * (1 + (1 - nu) * rest / across)
    C23 = 2 * math.pi / (3 * g**1.5 * ((1 - nu) * log - 2 + 4 * nu))
    return C11, C22, C23


def contact_fastsim(
    scene: Scene, theory: SimplifiedTheory, pressure: np.ndarray | None = None
) -> SimplifiedTractions:
    """Tractions of steady rolling of a contact on its explicit grid.

    Parameters
    ----------
    scene : Scene
        With an explicit grid, half-spaces, `Steady` without prescribed forces, and a coefficient of
        friction or a law by slip.
    theory : SimplifiedTheory
    pressure : ndarray, shape (ny, nx), optional
        Of a contact that is not Hertzian, or is solved for; without it the theory's under Hertz's
        load.
    """
    march = _March(scene, theory, pressure)
    return SimplifiedTractions(march.grid, march.pressure, march.fastsim())


class _March:
    def __init__(self, scene: Scene, theory: SimplifiedTheory, pressure: np.ndarray | None) -> None:
        hertz = scene.hertz
        grid = scene.grid
        motion = scene.motion
        bodies = scene.bodies
        assert isinstance(grid, Grid)
        assert isinstance(motion, Steady)
        assert isinstance(bodies, Bodies)
        self.grid = grid
        self.motion = motion
        self.G = bodies.combined_G
        self.nu = bodies.combined_nu
        self.x, self.y = np.meshgrid(grid.x, grid.y)
        # the pressure at the centres
        if pressure is None:
            assert hertz is not None
            self.normal_force = hertz.force
            height = np.maximum(1 - (self.x / hertz.a) ** 2 - (self.y / hertz.b) ** 2, 0.0)
            mean = hertz.force / (math.pi * hertz.a * hertz.b)
            pressure = 2 * mean * height
            if theory.elliptic:
                pressure = 1.5 * mean * np.sqrt(height)
        else:
            self.normal_force = float(pressure.sum() * grid.area)
        self.pressure = pressure
        # semi-axes, of another contact those of its equivalent ellipse
        self.a, self.b = self._equivalent_ellipse()
        if hertz is not None:
            self.a = hertz.a
            self.b = hertz.b
        # friction and slope by one number for all
        law = scene.friction
        if isinstance(law, Law):
            self.static = law.static
            self.friction = float(law(math.hypot(motion.vx, motion.vy)))
        else:
            assert isinstance(law, float)
            self.static = law
            self.friction = law
        self.flexibilities = self._flexibilities(theory)
        self.slope = self._slope(*theory.slope)

    def _flexibilities(self, theory: SimplifiedTheory) -> np.ndarray:
        """L1, L2 and L3, which become one as creepages grow."""
        if theory.flexibility is not None:
            return np.full(3, theory.flexibility)
        a = self.a
        coefficients = printed_coefficients(a / self.b, self.nu)
        shape = np.array([8 / 3, 8 / 3, math.pi / 4 * math.sqrt(a / self.b)])
        flexibilities = shape * a / (coefficients * self.G)
        creepages = np.array(self.motion.rigid)
        # one flexibility, weighted with the squared creepages
        arm = 3 * math.pi * a / 32
        squares = (creepages * [1, 1, arm]) ** 2
        if not squares.any():
            return np.asarray(flexibilities)
        one = squares.sum() / (squares / flexibilities).sum()
        # part of it, by the size of the creepages without spin
        limits = self.static * self.normal_force / (self.G * coefficients[:2] * a * self.b)
        size = np.linalg.norm(creepages[:2]) / np.linalg.norm(limits)
        part = min(1.0, float(size) / BLENDED)
        return np.asarray((1 - part) * flexibilities + part * one)

    def _slope(self, start: float, rest: float, decay: float) -> float:
        """The factor of slope reduction, by the equivalent ellipse of the elements in contact."""
        a, b = self._equivalent_ellipse()
        C11 = printed_coefficients(a / b, self.nu)[0]
        lateral = self.motion.vy + self.motion.spin * a
        if abs(lateral) < abs(self.motion.vy):
            lateral = self.motion.vy
        creepage = math.hypot(self.motion.vx, lateral)
        gradient = self.G * math.pi * a * b * start * C11 * creepage
        gradient = gradient / (4 * self.friction * self.normal_force)
        return start * (rest + (1 - rest) / (1 + decay * gradient))

    def _equivalent_ellipse(self) -> tuple[float, float]:
        """Semi-axes of the ellipse with the same area and the same ratio of length to width."""
        touching = self.pressure > 0
        dx, dy = self.grid.sides
        length = dx * (1 + np.ptp(np.flatnonzero(touching.any(axis=0))))
        width = dy * (1 + np.ptp(np.flatnonzero(touching.any(axis=1))))
        radius = math.sqrt(touching.sum() * self.grid.area / math.pi)
        return radius * math.sqrt(length / width), radius * math.sqrt(width / length)

    def fastsim(self) -> np.ndarray:
        """Tractions, row by row from the leading edge: each step is whole."""
        motion = self.motion
        L1, L2, L3 = self.flexibilities / self.slope
        dq = self.grid.sides[0]
        ahead = self.x + (motion.spin_offset or 0.0) * dq
        rise = np.stack(
            [motion.vx / L1 - motion.spin * self.y / L3, motion.vy / L2 + motion.spin * ahead / L3]
        )
        bound = self.friction * self.pressure
        traction = np.zeros((2, *self.grid.shape))
        before = np.zeros((2, self.grid.rows))
        for k in reversed(range(self.grid.nx)):
            free = before - dq * rise[:, :, k]
            size = np.hypot(*free)
            within = np.minimum(1.0, bound[:, k] / np.maximum(size, np.finfo(float).tiny))
            before = free * within
            traction[:, :, k] = before
        return traction
