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
from dataclasses import dataclass, replace

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
WIDEST = 5.0  # displacement
HEAD = (-36.0, 24.0)  # the part of the rail that is ground
UNIT = 0.05  # of the numbers
MOST = 0.3  # that is ground off
DEPTH = 0.8  # elements cover what is nearer to the wheel than this
LENGTH = 9.0  # of the elements' area along the rail, either way
CONICITY = (0.05, 0.15)
PENALTY = 100.0
PEAK = vc.PeakPressure(power=8)


def wheel(y: float, rail: Profile = RAIL, **more: object) -> WheelOnRail:
    """The right wheel of a set that is displaced by y."""
    track = Track(rail=rail, cant=CANT)
    return WheelOnRail(track=track, wheelset=WHEELSET, position=Position(y=y), **more)


def splines(y: np.ndarray, numbers: int) -> np.ndarray:
    """Cubic B-splines across the head, zero at its ends, at places (n,): (n, numbers)."""
    spacing = (HEAD[1] - HEAD[0]) / (numbers + 3)
    knots = np.linspace(HEAD[0] - 3 * spacing, HEAD[1] + 3 * spacing, numbers + 10)
    return BSpline.design_matrix(np.clip(y, *HEAD), knots, 3).toarray()[:, 3:-3]


@dataclass(frozen=True)
class Figures:
    """Peak pressure, T-gamma and rolling radius of contacts (n, 3), and their derivatives by the
    numbers (n, 3, numbers).
    """

    values: np.ndarray
    slopes: np.ndarray


@dataclass(frozen=True)
class Result:
    """Figures and conicities before and after over the displacements y, and what exact solutions
    have at some: (peak pressure, T-gamma).
    """

    y: np.ndarray
    numbers: np.ndarray
    figures: dict[str, Figures]
    conicity: dict[str, np.ndarray]
    checked_at: np.ndarray
    checked: dict[str, np.ndarray]


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
        return cls(scene, UNIT * by_height[:, None] * splines(place, numbers), radius)

    def solve(self, ground: np.ndarray) -> vc.Solution:
        """The contact of a rail that is ground by numbers."""
        distance = self.scene.surface.samples + (self.splines @ ground)[:, None]
        surface = vc.SampledDistance(distance - distance.min())
        return vc.solve(replace(self.scene, surface=surface), certify="none")

    def figures(self, ground: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Peak pressure, T-gamma and rolling radius (3,), and their derivatives (3, numbers)."""
        mean_radius = vc.Weighted(pressure=self.radius / LOAD, name="radius")
        outputs = [PEAK, "friction_work", mean_radius]
        found = self.solve(ground).gradient(outputs, by="distance", error=False)
        by_rows = found.distance.sum("x").to_numpy()
        return found.value.to_numpy(), by_rows @ self.splines


@dataclass
class Design:
    """Contacts at displacements that are symmetric about the middle, ascending."""

    y: np.ndarray
    contacts: list[Contact]
    solves: int = 0
    first: Figures | None = None

    def figures(self, ground: np.ndarray) -> Figures:
        """Figures of all contacts, and their derivatives."""
        self.solves += len(self.contacts)
        values, slopes = zip(*(each.figures(ground) for each in self.contacts), strict=True)
        return Figures(np.array(values), np.array(slopes))

    def conicity(self, figures: Figures) -> tuple[np.ndarray, np.ndarray]:
        """At the displacements y < 0, and its derivatives."""
        half = self.y.size // 2
        radius = figures.values[:, 2]
        slopes = figures.slopes[:, 2]
        distance = -2 * self.y[:half]
        values = (radius[::-1][:half] - radius[:half]) / distance
        return values, (slopes[::-1][:half] - slopes[:half]) / distance[:, None]

    def __call__(self, ground: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective and its derivatives by the numbers."""
        figures = self.figures(ground)
        if self.first is None:
            self.first = figures
        # means of peak pressure and T-gamma, by those of the rail as it is
        scale = self.first.values[:, :2].mean(axis=0)
        value = (figures.values[:, :2].mean(axis=0) / scale).sum()
        slopes = (figures.slopes[:, :2].mean(axis=0) / scale[:, None]).sum(axis=0)
        # conicity beyond its bounds
        conicity, by_numbers = self.conicity(figures)
        beyond = conicity - np.clip(conicity, *CONICITY)
        value += PENALTY * (beyond**2).mean()
        slopes += 2 * PENALTY * beyond @ by_numbers / beyond.size
        return float(value), slopes


def ground_rail(numbers: np.ndarray) -> Profile:
    """The rail that is ground by numbers."""
    return replace(RAIL, z=RAIL.z + UNIT * splines(RAIL.y, numbers.size) @ numbers, name="ground")


def main(
    picture: str = "rail_profile.png",
    positions: int = 20,
    numbers: int = 30,
    steps: int = 25,
    dx: float = 1.5,
    checked_at: tuple[float, ...] = (-4.0, -2.0, 0.0, 2.0, 4.0),
) -> Result:
    """Design the rail, and check it by exact solutions of wheels at some displacements."""
    y = np.linspace(-WIDEST, WIDEST, positions)
    design = Design(y, [Contact.at(each, numbers, dx, 0.8) for each in y])
    best = minimize(
        design,
        np.zeros(numbers),
        jac=True,
        method="L-BFGS-B",
        bounds=[(0.0, MOST / UNIT)] * numbers,
        options={"maxiter": steps},
    )
    assert design.first is not None
    rails = {"60E1": RAIL, "ground": ground_rail(best.x)}
    figures = {"60E1": design.first, "ground": design.figures(best.x)}
    checked = {
        name: np.array([exact(each, rail) for each in checked_at]) for name, rail in rails.items()
    }
    conicity = {name: design.conicity(each)[0] for name, each in figures.items()}
    for name in rails:
        peak, wear = checked[name].T
        print(
            f"{name}: peak pressure {peak.min():.0f} to {peak.max():.0f} N/mm2, "
            f"T-gamma {wear.mean():.2f} N, "
            f"conicity {conicity[name].min():.3f} to {conicity[name].max():.3f}"
        )
    print(f"{design.solves} solves of contacts")
    result = Result(y, best.x, figures, conicity, np.array(checked_at), checked)
    draw(result).savefig(picture, dpi=150)
    return result


def exact(y: float, rail: Profile) -> list[float]:
    """Peak pressure and T-gamma of a wheel by the default solution."""
    patches = wheel(y, rail, vertical_force=LOAD).solve().patches
    peak = max(each.solution.max_pressure for each in patches)
    return [peak, sum(each.solution.friction_work for each in patches)]


def draw(result: Result) -> plt.Figure:
    """What is ground off, and pressure, T-gamma and conicity before and after."""
    figure, axes = plt.subplots(2, 2, figsize=(9.0, 6.4), layout="constrained")
    (off, peak), (wear, cone) = axes
    across = np.linspace(*HEAD, 400)
    off.plot(across, UNIT * splines(across, result.numbers.size) @ result.numbers)
    off.set(xlabel="across the rail [mm]", ylabel="ground off [mm]")
    off.invert_yaxis()
    for colour, (name, figures) in zip(("C0", "C1"), result.figures.items(), strict=True):
        values = figures.values
        dots = {"color": colour, "marker": "o", "linestyle": "none"}
        peak.plot(result.y, values[:, 0], colour, label=f"{name}, 8-norm")
        peak.plot(result.checked_at, result.checked[name][:, 0], **dots, label=f"{name}, peak")
        wear.plot(result.y, values[:, 1], colour, label=name)
        wear.plot(result.checked_at, result.checked[name][:, 1], **dots)
        cone.plot(-result.y[: result.y.size // 2], result.conicity[name], colour, label=name)
    for each in CONICITY:
        cone.axhline(each, color="0.5", linestyle="--")
    peak.set(xlabel="displacement [mm]", ylabel="pressure [N/mm$^2$]", ylim=(0, None))
    wear.set(xlabel="displacement [mm]", ylabel="T-gamma [N]", yscale="log")
    cone.set(xlabel="displacement [mm]", ylabel="conicity", ylim=(0, None))
    peak.legend()
    cone.legend()
    return figure


if __name__ == "__main__":
    main(*sys.argv[1:])
