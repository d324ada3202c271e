"""The scenes at the extremes, continued: creepages, spin, forces, few elements, touching bodies, steps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tests.extremes import checks
from tests.extremes.scenes import (
    CARTER,
    HERTZ,
    HISTORY,
    LIKE,
    LINE,
    MINDLIN,
    MIRROR,
    PLACES,
    PRESSING,
    ROLLING,
    ROLLING_UNLIKE,
    SHIFT,
    SPHERES,
    UNLIKE,
    Case,
    Reference,
    bumps,
    but,
    half_sliding_line,
    proportional,
    same,
)
from varcontact.results.solution import Solution
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, Ellipse, SampledDistance
from varcontact.solving.solve import solve

LIMIT = 0.3
"""What friction carries in these scenes; in line contact a thousandth."""


def creepages() -> Iterator[Case]:
    """Creepages from 1e-12 to 1 and above."""
    sticks = replace(ROLLING, motion=Steady(vx=1.0, vy=0.5, spin=0.5), friction=math.inf)
    stuck = replace(SHIFT, motion=Shift(ux=1.0, uy=0.5), friction=math.inf)
    rough = dict.fromkeys(("conic", "scs"), "a solver's own answer, where tractions are 1e-12 of their bound or less")
    for v in (1e-12, 1e-9, 1e-6):
        rolling, shift = Steady(vx=v, vy=v / 2, spin=v / 2), Shift(ux=v, uy=v / 2)
        yield Case("creepage", f"steady, vx = {v:g}", but(ROLLING, motion=rolling), MIRROR, short=v == 1e-12)
        for base, motion, stick in ((ROLLING, rolling, sticks), (SHIFT, shift, stuck)):
            text = f"{'steady' if base is ROLLING else 'shift'}, {v:g}, f = 1e3"
            scene = but(base, motion=motion, friction=1e3)
            yield Case("creepage", text, scene, proportional("no slip", stick, v), limits=rough if v < 1e-9 else {})
        yield Case("creepage", f"line, vx = {v:g}", but(LINE, motion=Steady(vx=v)))
    for v in (1.0, 1e3):
        known = Reference("full sliding", checks.sliding, 0.01 / v)
        scene = but(ROLLING, motion=Steady(vx=v, vy=v / 2))
        yield Case("creepage", f"steady, vx = {v:g}", scene, known, short=v == 1)
        yield Case(
            "creepage", f"shift, ux = {v:g}", but(SHIFT, motion=Shift(ux=v, uy=v / 2)), replace(known, cap=1 / v)
        )
        yield Case("creepage", f"line, vx = {v:g}", but(LINE, motion=Steady(vx=v)), known)
        yield Case("creepage", f"unlike, vx = {v:g}", but(ROLLING_UNLIKE, motion=Steady(vx=v)), MIRROR)


def spins() -> Iterator[Case]:
    """The pole of spin in the contact, at its edge, and far outside."""
    for spin in (1e-12, 0.3, 1.0, 1e3):
        text = f"pole in the middle, spin = {spin:g}"
        yield Case("spin", text, but(ROLLING, motion=Steady(spin=spin)), MIRROR, short=spin == 1)
    for name, motion in {
        "at the leading edge": Steady(vy=-0.3, spin=0.3),
        "at the trailing edge": Steady(vy=0.3, spin=0.3),
        "at the side": Steady(vx=0.24, spin=0.3),
        "in a node of the grid": Steady(spin=0.3, spin_offset=0.5),
        "at an element's centre": Steady(vx=0.3 * 0.08, vy=-0.3 * 0.1, spin=0.3, spin_offset=0.0),
    }.items():
        yield Case("spin", f"pole {name}", but(ROLLING, motion=motion), MIRROR, short="centre" in name)
    centre = Shift(ux=0.3 * 0.08, uy=-0.3 * 0.1, rotation=0.3)
    yield Case("spin", "shift, pole at an element's centre", but(SHIFT, motion=centre), MIRROR)
    for far in (1e3, 1e9):
        straight = replace(ROLLING, motion=Steady(vx=0.1))
        known = same("no spin", straight, cap=10 / far)
        yield Case("spin", f"pole at {far:g} radii", but(ROLLING, motion=Steady(vx=0.1, spin=0.1 / far)), known)


def forces() -> Iterator[Case]:
    """Prescribed forces: nothing, next to nothing, next to all, all and more."""
    circle = replace(SHIFT, bodies=Bodies(1.0, 0.0), surface=Ellipse(1.0, 1.0))
    rough = dict.fromkeys(
        ("scs", "osqp"), "operator splitting, where tractions are 1e-9 of their bound, or all but that"
    )
    for name, base, limit, motion, known in (
        ("steady", ROLLING, LIMIT, Steady, MIRROR),
        ("shift", circle, LIMIT, Shift, MINDLIN),
        ("line", LINE, LIMIT * 1e-3, Steady, CARTER),
    ):
        nothing, text = Reference("no traction", checks.no_traction), "of the limit"
        yield Case("force", f"{name}, no force", but(base, motion=motion(Fx=0.0)), nothing, short=name == "steady")
        for part in (1e-9, 0.5, 1 - 1e-6):
            scene, short = but(base, motion=motion(Fx=-part * limit)), part > 0.9
            limits = {} if part == 0.5 else rough
            yield Case("force", f"{name}, {part:.7g} {text}", scene, known, limits=limits, short=short)
        for part in (1.0, 1 + 1e-9, 1e6):
            scene, short = but(base, motion=motion(Fx=-part * limit)), name == "steady" and part == 1
            yield Case("force", f"{name}, {part:.10g} {text}", scene, answer=False, short=short)
    nearly = LIMIT * (1 - 1e-6)
    both = Steady(Fx=-0.6 * nearly, Fy=0.8 * nearly)
    yield Case("force", "steady, Fx and Fy, 0.999999 of the limit", but(ROLLING, motion=both), MIRROR, limits=rough)
    yield Case("force", "steady, Fx with spin", but(ROLLING, motion=Steady(Fx=-0.2, spin=0.3)), MIRROR)
    yield Case("force", "steady, Fx with large spin", but(ROLLING, motion=Steady(Fx=-0.29, spin=30.0)), MIRROR)
    unlike = but(ROLLING_UNLIKE, motion=Steady(Fx=-nearly))
    yield Case("force", "unlike, 0.999999 of the limit", unlike, MIRROR, limits=rough)
    yield Case("force", "unlike, no force", but(ROLLING_UNLIKE, motion=Steady(Fx=0.0, Fy=0.0)), MIRROR)


def contacts() -> Iterator[Case]:
    """Few elements, one row, a corner of the grid, separate patches."""
    few = {"one element": (1, 1), "two elements": (2, 1), "two rows": (1, 2), "three elements": (3, 1), "2 x 2": (2, 2)}
    few |= {"one row": (20, 1), "one column": (1, 20)}
    bases = {"steady": ROLLING, "shift": SHIFT, "unlike": ROLLING_UNLIKE, "pressing": PRESSING, "history": HISTORY}
    for name, (nx, ny) in few.items():
        for kind, base in bases.items():
            known = None if kind in ("pressing", "history") else MIRROR
            scene, short = but(base, grid=Grid(nx=nx, ny=ny, margin=0)), name == "three elements"
            families = ("polished", "conic", "active set", "scs", "osqp") if kind == "pressing" else Case.families
            yield Case("elements", f"{name}, {kind}", scene, known, families=families, short=short)
    for cells in (1, 2, 3):
        yield Case("elements", f"line, {cells} elements", but(LINE, grid=Grid(nx=cells, margin=0)))
    for count, name in ((2, "two"), (9, "nine")):
        base = bumps(count)
        error = partial(checks.hertz_patches, places=PLACES[count], radius=1.0)
        loads = Reference("Hertz's contacts under point loads", error, 0.03)
        yield Case("patches", f"pressing, {name} patches", but(base), loads, short=count == 2)
        for kind, motion in (("steady", Steady(vx=0.003, spin=0.005)), ("shift", Shift(ux=0.003, rotation=1e-3))):
            yield Case("patches", f"{kind}, {name} patches", but(base, friction=0.3, motion=motion), MIRROR)
        unlike = but(base, friction=0.3, motion=Steady(vx=0.003), bodies=UNLIKE)
        families = Case.families if count == 2 else ("default", "active set")
        yield Case("patches", f"steady, {name} patches, unlike", unlike, MIRROR, families=families)
    beyond, within = partial(_at_corner, 0.0), partial(_at_corner, 2.5)
    yield Case("patches", "at a corner of the grid and beyond", beyond, answer=False, short=True)
    yield Case("patches", "at a corner of the grid", within, MIRROR, short=True)
    yield Case("patches", "at a corner, where the body ends", _body_end, MIRROR)


def _at_corner(elements: float) -> Scene:
    """A round contact, four elements across, whose middle is some elements from the lower left corner of the grid."""
    grid, place = Grid(nx=12, ny=12, dx=0.02, dy=0.02, x0=0.0, y0=0.0), elements * 0.02
    x, y = np.meshgrid(grid.x, grid.y)
    surface = SampledDistance((x - place) ** 2 / 2 + (y - place) ** 2 / 2)
    force = 8 * 0.04**3 / (3 * (1 - LIKE.combined_nu))
    return replace(ROLLING, surface=surface, normal_force=force, grid=grid, motion=Steady(vx=3e-3, spin=0.01))


def _body_end() -> Scene:
    """A contact at a corner of a body, beyond which the distance is large."""
    scene = _at_corner(3.0)
    assert isinstance(scene.surface, SampledDistance)
    h = scene.surface.h.copy()
    h[:3], h[:, :3] = 1.0, 1.0
    return replace(scene, surface=SampledDistance(h))


def touches() -> Iterator[Case]:
    """Approaches and forces that just touch, and those that do not."""
    force = Reference("Hertz", checks.hertz_force, 0.05)
    bare: dict[str, Any] = {"motion": None, "friction": None}
    pressing, line = replace(PRESSING, normal_force=1.0), replace(LINE, surface=Cylinders(1.0, 1.0), **bare)
    for approach in (1e-12, 1e-6, 1e-60):
        changes = {"normal_force": None, "approach": approach}
        yield Case(
            "touch", f"pressing, approach {approach:g}", but(pressing, **changes), force, short=approach == 1e-12
        )
        yield Case("touch", f"line, approach {approach:g}", but(line, **changes), force)
    for approach in (0.0, -1.0, 1e-300):
        scene = but(pressing, normal_force=None, approach=approach)
        yield Case("touch", f"approach {approach:g}", scene, answer=False, short=True)
    for more in (1e-3, 1e-9, 1e-12, 1e-15, 0.0):
        known = Reference("Hertz", checks.sphere_on_samples, 0.15)
        scene = partial(_sampled, 1 + more)
        yield Case("touch", f"samples from 1, approach 1 + {more:g}", scene, known, answer=more > 1e-14)
    for load in (1e-90, 1e90):
        yield Case("touch", f"force {load:g}", but(PRESSING, normal_force=load), HERTZ)
    yield Case("touch", "force 1e-300", but(PRESSING, normal_force=1e-300), answer=False)


def _sampled(approach: float) -> Scene:
    x = np.linspace(-1.0, 1.0, 81)
    surface = SampledDistance(1 + x**2 / 2 + x[:, None] ** 2 / 2, x=x, y=x)
    return replace(PRESSING, surface=surface, normal_force=None, approach=approach)


def steps() -> Iterator[Case]:
    """Steps dq from a thousandth of an element to ten, and ten thousand steps."""
    short_steps = {"tang": "TANG with inexact Newton steps, in steps of a tenth of an element or less"}
    unlike, incompressible = replace(ROLLING, bodies=UNLIKE), replace(ROLLING, bodies=Bodies(G=1.0, nu=0.5))
    for dq in (1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0):
        limits, text = short_steps if dq <= 0.1 else {}, f"dq = {dq:g} elements"
        known = replace(CARTER, cap=0.06 + 0.03 * dq)
        rolling = partial(half_sliding_line, dq=dq)
        yield Case("steps", f"line, {text}", rolling, known, limits=limits, short=dq in (0.5, 10.0))
        for name, base in (("steady", ROLLING), ("unlike", unlike), ("incompressible", incompressible)):
            motion = Steady(vx=0.1, vy=0.05, spin=0.15, dq=0.2 * dq)
            yield Case("steps", f"{name}, {text}", but(base, motion=motion), MIRROR, limits=limits)
    for dq in (1e-3, 0.5, 10.0):
        history = but(HISTORY, motion=Transient(steps=5, dq=0.2 * dq, vx=0.1, spin=0.1))
        yield Case("steps", f"history, dq = {dq:g} elements", history)
    steady, tiny = Reference("steady rolling", checks.steady_state), Grid(nx=4, ny=4)
    spheres = replace(ROLLING, surface=SPHERES, grid=tiny, motion=Transient(steps=100, vx=0.05, spin=0.1))
    both, one = ("default", "active set"), ("active set",)
    yield Case("steps", "spheres, 100 steps", but(spheres), steady, families=both, work=marched, short=True)
    long, line = Transient(steps=10_000, vx=0.05, spin=0.1), partial(_long_line, 10_000)
    many, text = but(spheres, motion=long), "10000 steps"
    yield Case("steps", f"spheres, {text}", many, steady, families=one, work=marched, seconds=900.0)
    yield Case("steps", f"line, {text}", line, steady, families=("default",), work=marched, seconds=900.0)


def _long_line(count: int) -> Scene:
    scene = half_sliding_line(cells=10)
    assert isinstance(scene.motion, Steady)
    return replace(scene, motion=Transient(steps=count, vx=scene.motion.vx))


def marched(scene: Scene, **options: Any) -> Solution:
    """The last step of a long history that is kept in a file: memory must not grow with its steps."""
    import resource
    import tempfile
    from pathlib import Path

    sizes: list[int] = []
    with tempfile.TemporaryDirectory() as folder:

        def watch(_: str) -> None:
            sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

        history = solve(scene, **options, store=Path(folder) / "history.nc", progress=watch)
        assert not isinstance(history, Solution)
        if sizes[-1] > 1.2 * sizes[len(sizes) // 4]:
            raise MemoryError(
                f"memory grew from {sizes[len(sizes) // 4]} to {sizes[-1]} during the last three quarters"
            )
        return history[-1]
