"""The scenes at the extremes, each with what its answer is held against: bodies, units, friction, shapes.

All are dimensionless but those in units. What moves at the extremes is in `motions`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from tests.extremes import checks
from varcontact.reference.line_contact import line_contact
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Motion, Shift, Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance
from varcontact.solving.solve import solve

EXACT = ("default", "polished", "conic", "active set", "tang", "newton", "scs", "osqp", "joint")
APPROXIMATE = ("johnson", "fastsim", "linear")


@dataclass(frozen=True)
class Reference:
    """What an answer is held against: `error` is relative, and `cap` the largest that may be (0: the usual one)."""

    what: str
    error: Callable[[Solution], float]
    cap: float = 0.0


@dataclass(frozen=True)
class Case:
    """A scene at an extreme; `limits` says by family why it is known to find no answer here."""

    group: str
    name: str
    scene: Callable[[], Scene]
    reference: Reference | None = None
    answer: bool = True
    limits: dict[str, str] = field(default_factory=dict)
    families: tuple[str, ...] = (*EXACT, *APPROXIMATE)
    work: Callable[..., Solution | History] = solve
    seconds: float = 120.0
    short: bool = False


LIKE, UNLIKE = Bodies(G=1.0, nu=0.28), Bodies(G=(1.0, math.inf), nu=0.0)
SPHERES = Paraboloids(Rx=1.0, Ry=0.7)
ROLLING: Scene = Scene(
    bodies=LIKE,
    surface=Ellipse(a=1.0, b=0.8),
    normal_force=1.0,
    friction=0.3,
    motion=Steady(vx=0.1, vy=0.05, spin=0.15),
    grid=Grid(nx=10, ny=10),
)
ROLLING_UNLIKE = replace(ROLLING, bodies=UNLIKE)
SHIFT: Scene = replace(ROLLING, motion=Shift(ux=0.08, uy=0.04, rotation=0.05))
PRESSING = replace(ROLLING, surface=SPHERES, motion=None, friction=None)
LINE: Scene = Scene(
    bodies=LIKE,
    surface=Cylinders(R=1.0, reference_depth=10.0),
    normal_force=1e-3,
    friction=0.3,
    motion=Steady(vx=4e-3),
    grid=Grid(nx=40),
)
HISTORY = replace(ROLLING, surface=SPHERES, motion=Transient(steps=3, dq=[0, 0.1, 0.1], vx=0.1, ux=[0.05, 0.0, 0.0]))
MIRROR = Reference("its mirror image", checks.mirrored)
HERTZ = Reference("Hertz", checks.hertz_contact, 0.05)
CARTER = Reference("Carter", checks.carter_line, 0.1)
MINDLIN = Reference("Cattaneo and Mindlin", checks.cattaneo, 0.05)


def but(base: Scene, **changes: Any) -> Callable[[], Scene]:
    """Makes the same scene but for some entries, when it is asked for."""
    return partial(replace, base, **changes)


def same(what: str, scene: Scene, cap: float = 0.0, length: float = 1.0, modulus: float = 1.0) -> Reference:
    """Another scene has to give the same, in other units."""
    return Reference(what, partial(checks.same_as, scene=scene, length=length, modulus=modulus), cap)


def proportional(what: str, scene: Scene, part: float) -> Reference:
    """Another scene has to give the same tractions, times a number."""
    return Reference(what, partial(checks.proportional_to, scene=scene, part=part))


def units() -> Iterator[Case]:
    """Moduli from 1e-12 to 1e15, lengths from 1e-9 to 1e6."""
    bases = {"steady": ROLLING, "shift": SHIFT, "unlike": ROLLING_UNLIKE, "line": LINE, "pressing": PRESSING}
    bases |= {"two patches": bumps(2), "history": HISTORY}
    for name, base in bases.items():
        for length, modulus in ((1e-9, 1e-12), (1e-9, 1e15), (1e6, 1e-12), (1e6, 1e15)):
            text, short = f"{name}, lengths {length:g}, moduli {modulus:g}", (length, modulus) == (1e-9, 1e15)
            known = same("the same, dimensionless", base, length=length, modulus=modulus)
            short = short and name in ("steady", "line", "pressing")
            yield Case("units", text, partial(checks.in_units, base, length, modulus), known, short=short)


def friction() -> Iterator[Case]:
    """Friction from 1e-9 to 1e6, and nine decades of it in one contact."""
    for f in (1e-9, 1e-6, 1e-3, 1e3, 1e6):
        for name, base in (("steady", ROLLING), ("shift", SHIFT), ("line", LINE)):
            assert isinstance(base.motion, (Steady, Shift))
            known, motion = proportional("f = 0.3, times f/0.3", base, f / 0.3), scaled(base.motion, f / 0.3)
            short = name == "steady" and f in (1e-9, 1e6)
            text = f"{name}, f = {f:g}, creepages with it"
            yield Case("friction", text, but(base, friction=f, motion=motion), known, short=short)
    sliding = Reference("full sliding", checks.sliding, 1e-6)
    yield Case("friction", "steady, f = 1e-9", but(ROLLING, friction=1e-9, motion=Steady(vx=0.1, vy=0.05)), sliding)
    yield Case("friction", "steady, spin, f = 1e-9", but(ROLLING, friction=1e-9), MIRROR, short=True)
    yield Case("friction", "unlike, f = 1e-9", but(ROLLING_UNLIKE, friction=1e-9), MIRROR)
    sticks = replace(ROLLING, friction=math.inf)
    yield Case("friction", "steady, f = 1e6", but(ROLLING, friction=1e6), same("infinite friction", sticks))
    limits = dict.fromkeys(EXACT, "friction far above 2 with unlike bodies: no coupling loop converges as a rule")
    for f in (1e6, math.inf):
        yield Case("friction", f"unlike, f = {f:g}", but(ROLLING_UNLIKE, friction=f), limits=limits)
    elements = {"friction": 10 ** np.random.default_rng(3).uniform(-6, 3, (12, 12)), "surface": Ellipse(1.0, 1.0)}
    elements["grid"] = Grid(nx=12, ny=12, dx=0.2, dy=0.2, x0=-1.2, y0=-1.2)
    for name, base in (("steady", ROLLING), ("shift", SHIFT), ("unlike", ROLLING_UNLIKE)):
        text = f"{name}, nine decades over the elements"
        yield Case("friction", text, but(base, **elements), MIRROR, short=name == "shift")


def scaled(motion: Motion, part: float) -> Motion:
    """The motion with all creepages, or shifts, times a number."""
    names = ("vx", "vy", "spin") if isinstance(motion, Steady) else ("ux", "uy", "rotation")
    return replace(motion, **{name: part * getattr(motion, name) for name in names})


def materials() -> Iterator[Case]:
    """Poisson's ratios 0, 0.5, -0.9 and nearly -1; K = 0.5, the largest; moduli with ratios from 1e-6 to 1e6."""
    for nu in (0.0, 0.5, -0.9, -0.999999):
        bodies = Bodies(G=1.0, nu=nu)
        yield Case("materials", f"pressing, nu = {nu:g}", but(PRESSING, bodies=bodies), HERTZ, short=nu == -0.9)
        yield Case("materials", f"steady, nu = {nu:g}", but(ROLLING, bodies=bodies), MIRROR)
        yield Case("materials", f"line, nu = {nu:g}", partial(half_sliding_line, bodies=bodies), CARTER)
    for nu in (0.0, 0.5):
        slow, bodies = Steady(vx=1e-3, vy=5e-4, spin=5e-4), Bodies(G=1.0, nu=nu)
        table = Reference("Kalker's table", checks.linear_theory, 0.1)
        slowly = but(ROLLING, bodies=bodies, motion=slow, friction=1e3)
        yield Case("materials", f"slow rolling, nu = {nu:g}", slowly, table)
    shift = but(SHIFT, bodies=Bodies(G=1.0, nu=0.0), surface=Ellipse(1.0, 1.0), motion=Shift(Fx=-0.2))
    yield Case("materials", "shift by a force, nu = 0", shift, MINDLIN, short=True)
    for f in (0.3, 1.0):
        for name, base in (("steady", ROLLING), ("shift", SHIFT), ("line", LINE)):
            scene, known = but(base, bodies=UNLIKE, friction=f), None if name == "line" else MIRROR
            yield Case("materials", f"{name}, K = 0.5, f = {f:g}", scene, known)
    pressed = but(SHIFT, bodies=UNLIKE, motion=Shift(), friction=0.1)
    yield Case("materials", "pressing with friction, K = 0.5", pressed, MIRROR)
    free = but(LINE, bodies=Bodies(G=(1.0, math.inf), nu=0.4), friction=math.inf, motion=Steady(Fx=0.0))
    yield Case("materials", "line, rolling freely, no slip", free, Reference("Bufler", checks.free_rolling, 0.1))
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        rigid = Bodies(G=(1.0, math.inf) if ratio > 1 else (math.inf, 1.0), nu=0.28)
        bodies = Bodies(G=(1 + 1 / ratio, 1 + ratio), nu=0.28)  # the combined modulus of both is 2
        for name, base in (("steady", ROLLING), ("shift", SHIFT)):
            known = same("one body rigid", replace(base, bodies=rigid), cap=10 * min(ratio, 1 / ratio))
            yield Case("materials", f"{name}, G ratio {ratio:g}", but(base, bodies=bodies), known)


def half_sliding_line(part: float = 0.5, bodies: Bodies = LIKE, dq: float | None = None, cells: int = 40) -> Scene:
    """Rolling cylinders at a part of the creepage of full sliding; dq in elements."""
    contact = line_contact(1.0, bodies, force=LINE.normal_force)
    step = None if dq is None else dq * 2 * contact.a / cells
    return replace(LINE, bodies=bodies, motion=Steady(vx=part * 0.3 * contact.a, dq=step), grid=Grid(nx=cells))


def shapes() -> Iterator[Case]:
    """Ellipses with a/b from 1e-3 to 1e3, elements with dx/dy from 1e-3 to 1e3."""
    for ratio in (1e-3, 1e-2, 1e2, 1e3):
        a, b = math.sqrt(ratio), 1 / math.sqrt(ratio)
        text, base = f"a/b = {ratio:g}", replace(ROLLING, surface=Ellipse(a, b))
        creep = 0.1 / a if ratio < 1 else 0.1 / ratio
        motion = Steady(vx=creep, vy=creep / 2, spin=creep / max(a, b))
        pressing = but(base, motion=None, friction=None)
        yield Case("shapes", f"pressing, {text}", pressing, HERTZ, short=ratio in (1e-3, 1e3))
        yield Case("shapes", f"steady, {text}", but(base, motion=motion), MIRROR, short=ratio == 1e3)
        yield Case("shapes", f"shift, {text}", but(base, motion=Shift(ux=0.1, uy=0.02)), MIRROR)
        yield Case("shapes", f"unlike, {text}", but(base, bodies=UNLIKE, motion=motion), MIRROR)
        if ratio < 1:
            strips = Reference("Carter in strips", checks.carter_strips, 0.1)
            yield Case("shapes", f"steady, {text}, vx alone", partial(half_sliding, base), strips, short=ratio == 1e-3)
    for nx, ny, a, b in ((20, 2, 0.1, 10.0), (2, 20, 10.0, 0.1), (100, 2, 1.0, 20.0), (2, 100, 20.0, 1.0)):
        base = replace(ROLLING, surface=Ellipse(a, b), grid=Grid(nx=nx, ny=ny))
        text = f"dx/dy = {a / nx * ny / b:g}, {nx} x {ny}"
        yield Case("shapes", f"steady, {text}", but(base, motion=Steady(vx=0.1 * a, vy=0.05 * a)), MIRROR)
        known = replace(HERTZ, cap=0.25)  # two rows or columns
        yield Case("shapes", f"pressing, {text}", but(base, motion=None, friction=None), known)


def half_sliding(base: Scene) -> Scene:
    """At half of the creepage at which the middle strip of a narrow ellipse slides."""
    assert base.hertz is not None
    stiffness = base.bodies.combined_G / (1 - base.bodies.combined_nu)
    return replace(base, motion=Steady(vx=0.3 * base.hertz.peak_pressure / stiffness))


PLACES = {2: [(0.0, -0.3), (0.0, 0.3)], 9: [(0.3 * i, 0.3 * j) for i in (-1, 0, 1) for j in (-1, 0, 1)]}
"""Middles of two and of nine bumps."""


def bumps(count: int) -> Scene:
    """Round bumps of radius 1, far from each other by their contacts, five elements across each."""
    a, side = 0.05, 0.02
    nx, ny = (7 if count == 2 else 37), 37
    grid = Grid(nx=nx, ny=ny, dx=side, dy=side, x0=-nx * side / 2, y0=-ny * side / 2)
    x, y = np.meshgrid(grid.x, grid.y)
    h = np.min([(x - i) ** 2 / 2 + (y - j) ** 2 / 2 for i, j in PLACES[count]], axis=0)
    force = count * 8 * a**3 / (3 * (1 - LIKE.combined_nu))
    return Scene(bodies=LIKE, surface=SampledDistance(h), normal_force=force, grid=grid)
