"""Gradients: their price beside that of the solution, and their distance from differences of
solutions and from finer grids.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

import varcontact as vc
from tests.benchmarks.table import Table, least

INPUTS = ("vx", "vy", "spin", "friction", "normal_force", "distance")
RADII = ("surface.Rx", "surface.Ry")
LIKE = vc.Bodies(G=1.0, nu=0.28)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.3))
MOTION = vc.Steady(vx=5e-4, vy=1.5e-4, spin=3e-4)
STEP = 1e-6
CALLS = 16
"""Calls of which the fastest is taken, where other programs run beside."""


def scene(cells: int, bodies: vc.Bodies = LIKE, corner: float = 0.3) -> vc.Scene:
    """A contact of nearly 2 by 2 on a fixed grid, its corner a part of an element further on."""
    side = 2.4 / cells
    grid = vc.Grid(
        nx=cells, ny=cells, dx=side, dy=side, x0=-1.2 - corner * side, y0=-1.2 + corner * side
    )
    return vc.Scene(
        bodies=bodies,
        surface=vc.Paraboloids(100.0, 90.0),
        normal_force=0.02,
        friction=0.3,
        motion=MOTION,
        grid=grid,
    )


def price(quick: bool) -> Table:
    """Processor seconds of a solution to 1e-7, and beside it gradients by six inputs, one of them a
    field, and by ten.
    """
    rows = []
    kinds = (
        (LIKE, "like", ("bodies.G", "bodies.nu")),
        (UNLIKE, "unlike", ("bodies.G.lower", "bodies.nu.lower")),
    )
    for bodies, name, constants in kinds:
        ten = (*INPUTS, *RADII, *constants)
        for cells in (16, 32) if quick else (16, 32, 64, 128):
            given = scene(cells, bodies)
            sol = vc.solve(given, tol=1e-7, certify="none")
            works = [
                lambda s=given: vc.solve(s, tol=1e-7, certify="none"),
                lambda s=sol: s.gradient("Fx", INPUTS, edge="held"),
                lambda s=sol: s.gradient("peak_pressure", INPUTS, edge="held"),
                lambda s=sol, by=ten: s.gradient("Fx", by, edge="held"),
            ]
            # in turns, as the machine is not always as fast
            rounds = [[least(work, 1) for work in works] for _ in range(CALLS)]
            of_solution, *seconds = np.min(rounds, axis=0)
            parts = [each / of_solution for each in seconds]
            rows.append([name, sol.elements["contact"], of_solution, *parts])
    head = ("bodies", "elements", "solution [s]", "of Fx", "of peak pressure", "of Fx by ten")
    return Table(head, ("", "", ".3f", ".2f", ".2f", ".2f"), rows)


def changed(given: vc.Scene, name: str, factor: float) -> vc.Scene:
    """The scene with one number times a factor."""
    if name in ("vx", "vy", "spin"):
        motion = replace(given.motion, **{name: getattr(given.motion, name) * factor})
        return replace(given, motion=motion)
    if name == "surface.Rx":
        return replace(given, surface=vc.Paraboloids(100.0 * factor, 90.0))
    if name == "bodies.G.lower":
        G, nu = given.bodies.pairs
        return replace(given, bodies=vc.Bodies(G=(G[0], G[1] * factor), nu=nu))
    return replace(given, **{name: getattr(given, name) * factor})


def number(given: vc.Scene, name: str) -> float:
    """The value of an input."""
    places: dict[str, Callable[[], float]] = {
        "surface.Rx": lambda: 100.0,
        "bodies.G.lower": lambda: given.bodies.pairs[0][1],
    }
    if name in places:
        return places[name]()
    return float(getattr(given.motion, name, None) or getattr(given, name))


def pairs(quick: bool) -> Table:
    """Relative distances of held gradients from central differences of solutions, by bodies."""
    inputs = ("vx", "vy", "spin", "friction", "normal_force", "surface.Rx", "bodies.G.lower")
    outputs = ["Fx", "Fy", "Mz", "approach", "contact_area", "friction_work"]
    rows = []
    for bodies, name in ((LIKE, "like"), (UNLIKE, "unlike")):
        distances = []
        for corner in (0.3,) if quick else (0.1, 0.3, 0.45):
            given = scene(14, bodies, corner)
            normal = "auto" if given.coupled else "norm"
            options = {"normal": normal, "tol": 1e-12, "certify": None}
            found = vc.solve(given, **options).gradient(outputs, inputs, edge="held")
            for entry in inputs:
                above, below = (
                    vc.solve(changed(given, entry, 1 + sign * STEP), **options)
                    .gradient(outputs, "vx", edge="held")
                    .value.to_numpy()
                    for sign in (1, -1)
                )
                differences = (above - below) / (2 * STEP * number(given, entry))
                scale = np.abs(differences) + 1e-3 * np.abs(found.value / number(given, entry))
                distances.extend(np.abs(found[entry].to_numpy() - differences) / scale)
        distances = np.array(distances, float)
        rows.append(
            [
                name,
                distances.size,
                int((distances <= 1e-6).sum()),
                float(np.median(distances)),
                float(distances.max()),
            ]
        )
    head = ("bodies", "pairs", "within 1e-6", "median", "largest")
    return Table(head, ("", "", "", ".0e", ".0e"), rows)


def continuum(quick: bool) -> Table:
    """Relative distance, in per cent, of dFx/dN from that on 96 elements across, by kind of edge,
    and the spread over four grids.
    """

    def second_order(cells: int, corner: float) -> vc.Scene:
        given = scene(cells, corner=corner)
        return replace(given, motion=given.motion.second_order())

    follow = replace(second_order(16, 0.3), grid=vc.Grid(nx=96, ny=96))
    forces = [
        vc.solve(replace(follow, normal_force=0.02 * part), certify="none").Fx
        for part in (0.98, 1.02)
    ]
    expected = (forces[1] - forces[0]) / (0.04 * 0.02)
    rows = []
    for edge, made in (("held", second_order), ("following", second_order), ("moving", scene_of)):
        figures = []
        for cells in (16, 32) if quick else (16, 32, 64):
            found = [
                float(
                    vc.solve(made(cells, corner), certify="none")
                    .gradient("Fx", "normal_force", edge=edge)
                    .normal_force
                )
                for corner in (0.0, 0.15, 0.3, 0.45)
            ]
            off = 100 * (np.array(found) / expected - 1)
            figures.append([float(off.mean()), float(off.std())])
        rows.append([edge, *figures])
    across = [f"{n * 2 / 2.4:.0f} across" for n in ((16, 32) if quick else (16, 32, 64))]
    return Table(["edge", *across], ["", *(len(across) * ["{:.1f} ± {:.1f}"])], rows)


def scene_of(cells: int, corner: float) -> vc.Scene:
    """With the slip difference of the first order, as moving edges need."""
    return scene(cells, corner=corner)


TABLES = {"price": price, "pairs": pairs, "continuum": continuum}
