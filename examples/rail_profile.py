"""A rail's head is ground by gradients: thirty numbers of its profile, for less pressure and wear
at twenty positions of the wheels, with bounds on the conicity.

S1002 wheels run on a 60E1 rail, inclined 1:40. What is ground off is a sum of B-splines across the
head. L-BFGS-B lowers the means, over the positions, of the 8-norm of the pressure and of T-gamma,
the work of friction by distance rolled. The conicity at a displacement y is the difference of the
rolling radii at y and -y, means weighted by the pressure, divided by 2y; a penalty keeps it within
its bounds. Derivatives by all numbers are from that by the undeformed distance of the elements,
three transposed solves a contact. A design is solved in the planes of contact of the new rail. The
last one then is a profile, on which the wheels find their contacts anew, solved to an accuracy.

Lengths in mm, forces in N. Run: python examples/rail_profile.py [picture.png]
"""

import sys
from dataclasses import dataclass, field, replace

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import minimize

import varcontact as vc
from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet

RAIL = Profile.rail_60e1()
WHEELSET = WheelSet(wheel=Profile.s1002())
CANT = 1 / 40
LOAD = 80e3
HEAD = (-34.0, 24.0)  # the part of the rail that is ground
MOST = 0.4  # that is ground off
DEPTH = 0.35  # elements cover what is nearer to the wheel than this
LENGTH = 9.0  # of the elements' area along the rail, either way
CONICITY = (0.05, 0.15)
PENALTY = 100.0
PEAK = vc.PeakPressure(power=8)


def wheel(y: float, rail: Profile = RAIL, **more: object) -> WheelOnRail:
    """The right wheel of a set that is displaced by y."""
    track = Track(rail=rail, cant=CANT)
    return WheelOnRail(track=track, wheelset=WHEELSET, position=Position(y=y), **more)


def splines(y: np.ndarray, numbers: int) -> np.ndarray:
    """Cubic B-splines across the head, at places (n,): (n, numbers)."""
    knots = np.linspace(*HEAD, numbers + 4)
    found = BSpline(knots, np.eye(numbers), 3, extrapolate=False)(y)
    return np.nan_to_num(found)


@dataclass(frozen=True)
class Contact:
    """A wheel on the rail, in the plane of their contact, and what an element's row is worth."""

    scene: vc.Scene
    splines: np.ndarray  # distance by the numbers, (ny, numbers)
    radius: np.ndarray  # of the wheel, less the nominal one, (ny, 1)

    @classmethod
    def at(cls, y: float, numbers: int, dx: float, dy: float) -> "Contact":
        """The contact at a displacement, on all elements that may come into contact."""
        whole = {"join": 99.0, "separate": 99.0, "slip_by_element": True}
        case = wheel(y, z=0.0, dx=dx, dy=dy, **whole)
        (patch,) = case.patches(case.touching + DEPTH)
        grid = patch.scene.grid
        columns = np.flatnonzero(np.abs(grid.x) < LENGTH)
        scene = replace(
            patch.scene,
            surface=vc.SampledDistance(patch.scene.surface.samples[:, columns]),
            motion=vc.Steady(rigid_slip=patch.scene.motion.rigid_slip[..., columns]),
            grid=replace(grid, nx=columns.size, x0=grid.x0 + columns[0] * dx),
            approach=None,
            normal_force=LOAD,
        )
        # rows of elements on the rail, and what a vertical change of it is along their normals
        across = patch.frame.axes[1:, 1]
        ends = [case.track.on_rail(patch.location[1:] + s * across, "right") for s in (0.0, 1.0)]
        angle = np.arctan2(*(ends[1] - ends[0])[::-1])
        points = np.stack([RAIL.y, RAIL.z], axis=1) - patch.on_rail
        place = np.interp(grid.y, points @ (ends[1] - ends[0]), RAIL.y)
        inclined = RAIL.angle_at(place)
        by_height = np.cos(inclined) / np.cos(inclined - angle)
        # rolling radii
        on_wheel = patch.on_wheel[0] + grid.y * np.cos(angle)
        radius = WHEELSET.profile.z_at(on_wheel)[:, None]
        return cls(scene, by_height[:, None] * splines(place, numbers), radius)

    def solve(self, ground: np.ndarray) -> vc.Solution:
        """The contact of a rail that is ground by numbers."""
        distance = self.scene.surface.samples + (self.splines @ ground)[:, None]
        surface = vc.SampledDistance(distance - distance.min())
        return vc.solve(replace(self.scene, surface=surface), certify="none")

    def figures(self, ground: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Peak pressure, T-gamma and rolling radius (3,), and their derivatives (3, numbers)."""
        mean_radius = vc.Weighted(pressure=self.radius / LOAD, name="radius")
        outputs = [PEAK, "friction_work", mean_radius]
        found = self.solve(ground).gradient(outputs, by="distance")
        by_rows = found.distance.sum("x").to_numpy()
        return found.value.to_numpy(), by_rows @ self.splines


@dataclass
class Design:
    """Contacts at positions that are symmetric about the middle."""

    y: np.ndarray
    contacts: list[Contact]
    first: np.ndarray | None = None
    solves: int = 0
    courses: list[np.ndarray] = field(default_factory=list)

    def __call__(self, ground: np.ndarray) -> tuple[float, np.ndarray]:
        """What is minimised, and its derivatives."""
        figures = [each.figures(ground) for each in self.contacts]
        self.solves += len(figures)
        peak, wear, radius = np.array([values for values, _ in figures]).T
        by_peak, by_wear, by_radius = np.moveaxis([slopes for _, slopes in figures], 1, 0)
        if self.first is None:
            self.first = np.array([peak.mean(), wear.mean()])
        half = self.y.size // 2
        opposite = slice(None, half - 1, -1)  # the displacements y > 0, the largest first
        distance = -2 * self.y[:half]
        conicity = (radius[opposite] - radius[:half]) / distance
        by_conicity = (by_radius[opposite] - by_radius[:half]) / distance[:, None]
        beyond = conicity - np.clip(conicity, *CONICITY)
        value = peak.mean() / self.first[0] + wear.mean() / self.first[1]
        slopes = by_peak.mean(0) / self.first[0] + by_wear.mean(0) / self.first[1]
        self.courses.append(np.array([peak.max(), wear.mean(), conicity.min(), conicity.max()]))
        value += PENALTY * (beyond**2).mean()
        slopes += 2 * PENALTY * (beyond @ by_conicity) / half
        return float(value), slopes
