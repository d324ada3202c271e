"""Work by friction on ten scenes, and its values in the continuum: ``python -m
tests.friction_work`` makes them.

A scene takes a number of elements across its contact, or across the smaller of its two. References
are extrapolated from two grids with order 1; that of the cylinder is Carter's closed form. Those of
Hertzian contacts in three dimensions stay as they are: force times creepage on 48 elements, by the
defect correction (``refine="continuum"``) that version 0.1.0 had up to commit 9299d83f.
"""

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.scenes import STEEL, make_scene
from varcontact.reference import line_contact
from varcontact.reference.carter import carter
from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet

REFERENCES = Path(__file__).parent / "data" / "friction_work.csv"
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.35))


def rail(cells: int, Ry: float = 0.30, Rx: float = 0.46, **motion: float) -> vc.Scene:
    """A wheel on a rail by its radii."""
    grid = vc.Grid(nx=cells, ny=cells)
    return make_scene(vc.Paraboloids(Rx=Rx, Ry=Ry), 106.7e3, vc.Steady(**motion), grid, 0.33, STEEL)


def two_patches(cells: int) -> vc.Scene:
    """Two bumps of different height and radii, 8 mm apart."""
    side = 7.6e-3 / cells
    nx, ny = round(9.12e-3 / side), round(18.24e-3 / side)
    grid = vc.Grid(nx=nx, ny=ny, dx=side, dy=side, x0=-nx * side / 2, y0=-ny * side / 2)
    x, y = np.meshgrid(grid.x, grid.y)
    left, right = x**2 / 0.9 + (y + 4.5e-3) ** 2 / 0.7, x**2 / 0.6 + (y - 4.5e-3) ** 2 / 0.6 + 2e-6
    surface = vc.SampledDistance(np.minimum(left, right))
    return make_scene(surface, 40e3, vc.Steady(vx=1e-3, spin=0.1), grid, bodies=STEEL)


def profiles(cells: int) -> vc.Scene:
    """The patch of S1002 on 60E1, in millimetres."""
    side = 12.0 / cells
    case = WheelOnRail(
        track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
        wheelset=WheelSet(wheel=Profile.s1002()),
        position=Position(y=3.0, yaw=0.003),
        vertical_force=80e3,
        with_friction=False,
        dx=side,
        dy=side,
    )
    (patch,) = case.solve(certify=None).patches
    return patch.solution.scene


def unlike(cells: int) -> vc.Scene:
    """Spheres of unlike bodies, whose pressure resists rolling too."""
    motion, grid = vc.Steady(vx=8e-3, vy=4e-3), vc.Grid(nx=cells, ny=cells)
    return make_scene(vc.Paraboloids(Rx=1.0, Ry=0.7), 1e-2, motion, grid, bodies=UNLIKE)


CYLINDER = line_contact(1.0, vc.Bodies(G=1.0, nu=0.28), force=1e-3)
CARTER = carter(CYLINDER, 0.1, force=-6e-5)


def cylinder(cells: int) -> vc.Scene:
    """Carter's problem at the creepage of 0.6 of the friction limit."""
    return make_scene(
        vc.Cylinders(R=1.0), 1e-3, vc.Steady(vx=CARTER.creepage), vc.Grid(nx=cells), friction=0.1
    )


def history(cells: int) -> vc.Scene:
    """A ball that rolls from rest by its radius of contact, its creepage growing."""
    steps = cells // 2
    middle = (np.arange(steps) + 0.5) / steps
    motion = vc.Transient(steps=steps, vx=0.03 * middle, vy=0.01)
    return make_scene(vc.Paraboloids(Rx=1.0, Ry=1.0), 1e-2, motion, vc.Grid(nx=cells, ny=cells))


SCENES: dict[str, Callable[[int], vc.Scene]] = {
    "vx and spin": lambda cells: rail(cells, vx=1e-3, spin=0.1),
    "slender along y": lambda cells: rail(cells, Rx=0.02, Ry=0.46, vx=1e-3, vy=5e-4),
    "slender along x": lambda cells: rail(cells, Ry=0.03, vx=1.5e-3),
    "spin": lambda cells: rail(cells, spin=0.8),
    "force": lambda cells: rail(cells, Fx=-25e3, vy=2e-4),
    "cylinder": cylinder,
    "two patches": two_patches,
    "profiles": profiles,
    "unlike bodies": unlike,
    "history": history,
}


def work(scene: vc.Scene) -> float:
    """Lost by friction; in a history of all steps."""
    found = vc.solve(scene, certify=None)
    return float(found.dissipation.sum()) if isinstance(found, vc.History) else found.friction_work


def reference(name: str) -> float:
    if name == "cylinder":
        return 6e-5 * CARTER.creepage
    if name in ("two patches", "profiles", "unlike bodies", "history"):
        coarse, fine = (work(SCENES[name](cells)) for cells in (64, 128))
        return 2 * fine - coarse
    return references()[name]


def references() -> dict[str, float]:
    """Work in the continuum by scene."""
    with REFERENCES.open() as file:
        return {row["scene"]: float(row["work"]) for row in csv.DictReader(file)}


if __name__ == "__main__":
    rows = [[name, f"{reference(name):.6g}"] for name in SCENES]
    with REFERENCES.open("w", newline="") as csv_file:
        table = csv.writer(csv_file, lineterminator="\n")
        table.writerow(["scene", "work"])
        table.writerows(rows)
