"""The scenes at the extremes, each with what its answer is held against; all but those in units are dimensionless."""

import math
import resource
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

import varcontact as vc
from tests.extremes import checks
from varcontact.reference.line_contact import line_contact

EXACT = ("default", "polished", "conic", "active set", "tang", "newton", "scs", "osqp", "joint")
APPROXIMATE = ("johnson", "fastsim", "linear")


@dataclass(frozen=True)
class Reference:
    """What an answer is held against: `error` is relative, and `cap` the largest that may be (0: the usual one)."""

    what: str
    error: Callable[[vc.Solution], float]
    cap: float = 0.0


@dataclass(frozen=True)
class Case:
    """A scene at an extreme; `limits` says by family why it is known to find no answer here."""

    group: str
    name: str
    scene: Callable[[], vc.Scene]
    reference: Reference | None = None
    answer: bool = True
    limits: dict[str, str] = field(default_factory=dict)
    families: tuple[str, ...] = (*EXACT, *APPROXIMATE)
    work: Callable[..., vc.Solution | vc.History] = vc.solve
    seconds: float = 120.0
    short: bool = False


LIKE, UNLIKE = vc.Bodies(G=1.0, nu=0.28), vc.Bodies(G=(1.0, math.inf), nu=0.0)
SPHERES = vc.Paraboloids(Rx=1.0, Ry=0.7)
ROLLING: vc.Scene = vc.Scene(
    bodies=LIKE,
    surface=vc.Ellipse(a=1.0, b=0.8),
    normal_force=1.0,
    friction=0.3,
    motion=vc.Steady(vx=0.1, vy=0.05, spin=0.15),
    grid=vc.Grid(nx=10, ny=10),
)
ROLLING_UNLIKE = replace(ROLLING, bodies=UNLIKE)
SHIFT: vc.Scene = replace(ROLLING, motion=vc.Shift(ux=0.08, uy=0.04, rotation=0.05))
PRESSING = replace(ROLLING, surface=SPHERES, motion=None, friction=None)
LINE: vc.Scene = vc.Scene(
    bodies=LIKE,
    surface=vc.Cylinders(R=1.0, reference_depth=10.0),
    normal_force=1e-3,
    friction=0.3,
    motion=vc.Steady(vx=4e-3),
    grid=vc.Grid(nx=40),
)
HISTORY = replace(ROLLING, surface=SPHERES, motion=vc.Transient(steps=3, dq=[0, 0.1, 0.1], vx=0.1, ux=[0.05, 0.0, 0.0]))
MIRROR = Reference("its mirror image", checks.mirrored)
HERTZ = Reference("Hertz", checks.hertz_contact, 0.05)
CARTER = Reference("Carter", checks.carter_line, 0.1)
MINDLIN = Reference("Cattaneo and Mindlin", checks.cattaneo, 0.05)


def but(base: vc.Scene, **changes) -> Callable[[], vc.Scene]:
    """Makes the same scene but for some entries, when it is asked for."""
    return partial(replace, base, **changes)


def same(what: str, scene: vc.Scene, cap: float = 0.0, length: float = 1.0, modulus: float = 1.0) -> Reference:
    """Another scene has to give the same, in other units."""
    return Reference(what, partial(checks.same_as, scene=scene, length=length, modulus=modulus), cap)


def proportional(what: str, scene: vc.Scene, part: float) -> Reference:
    """Another scene has to give the same tractions, times a number."""
    return Reference(what, partial(checks.proportional_to, scene=scene, part=part))


def units():
    """Moduli from 1e-12 to 1e15, lengths from 1e-9 to 1e6."""
    bases = {"steady": ROLLING, "shift": SHIFT, "unlike": ROLLING_UNLIKE, "line": LINE, "pressing": PRESSING}
    bases |= {"two patches": bumps(2), "history": HISTORY}
    for name, base in bases.items():
        for length, modulus in ((1e-9, 1e-12), (1e-9, 1e15), (1e6, 1e-12), (1e6, 1e15)):
            text, short = f"{name}, lengths {length:g}, moduli {modulus:g}", (length, modulus) == (1e-9, 1e15)
            known = same("the same, dimensionless", base, length=length, modulus=modulus)
            short = short and name in ("steady", "line", "pressing")
            yield Case("units", text, partial(checks.in_units, base, length, modulus), known, short=short)


def friction():
    """Friction from 1e-9 to 1e6, and nine decades of it in one contact."""
    for f in (1e-9, 1e-6, 1e-3, 1e3, 1e6):
        for name, base in (("steady", ROLLING), ("shift", SHIFT), ("line", LINE)):
            assert isinstance(base.motion, (vc.Steady, vc.Shift))
            known, motion = proportional("f = 0.3, times f/0.3", base, f / 0.3), scaled(base.motion, f / 0.3)
            short = name == "steady" and f in (1e-9, 1e6)
            text = f"{name}, f = {f:g}, creepages with it"
            yield Case("friction", text, but(base, friction=f, motion=motion), known, short=short)
    sliding = Reference("full sliding", checks.sliding, 1e-6)
    yield Case("friction", "steady, f = 1e-9", but(ROLLING, friction=1e-9, motion=vc.Steady(vx=0.1, vy=0.05)), sliding)
    yield Case("friction", "steady, spin, f = 1e-9", but(ROLLING, friction=1e-9), MIRROR, short=True)
    yield Case("friction", "unlike, f = 1e-9", but(ROLLING_UNLIKE, friction=1e-9), MIRROR)
    sticks = replace(ROLLING, friction=math.inf)
    yield Case("friction", "steady, f = 1e6", but(ROLLING, friction=1e6), same("infinite friction", sticks))
    limits = dict.fromkeys(EXACT, "friction far above 2 with unlike bodies: no coupling loop converges as a rule")
    for f in (1e6, math.inf):
        yield Case("friction", f"unlike, f = {f:g}", but(ROLLING_UNLIKE, friction=f), limits=limits)
    elements = {"friction": 10 ** np.random.default_rng(3).uniform(-6, 3, (12, 12)), "surface": vc.Ellipse(1.0, 1.0)}
    elements["grid"] = vc.Grid(nx=12, ny=12, dx=0.2, dy=0.2, x0=-1.2, y0=-1.2)
    for name, base in (("steady", ROLLING), ("shift", SHIFT), ("unlike", ROLLING_UNLIKE)):
        text = f"{name}, nine decades over the elements"
        yield Case("friction", text, but(base, **elements), MIRROR, short=name == "shift")


def scaled(motion, part: float):
    """The motion with all creepages, or shifts, times a number."""
    names = ("vx", "vy", "spin") if isinstance(motion, vc.Steady) else ("ux", "uy", "rotation")
    return replace(motion, **{name: part * getattr(motion, name) for name in names})


def materials():
    """Poisson's ratios 0, 0.5, -0.9 and nearly -1; K = 0.5, the largest; moduli with ratios from 1e-6 to 1e6."""
    for nu in (0.0, 0.5, -0.9, -0.999999):
        bodies = vc.Bodies(G=1.0, nu=nu)
        yield Case("materials", f"pressing, nu = {nu:g}", but(PRESSING, bodies=bodies), HERTZ, short=nu == -0.9)
        yield Case("materials", f"steady, nu = {nu:g}", but(ROLLING, bodies=bodies), MIRROR)
        yield Case("materials", f"line, nu = {nu:g}", partial(half_sliding_line, bodies=bodies), CARTER)
    for nu in (0.0, 0.5):
        slow, bodies = vc.Steady(vx=1e-3, vy=5e-4, spin=5e-4), vc.Bodies(G=1.0, nu=nu)
        table = Reference("Kalker's table", checks.linear_theory, 0.1)
        slowly = but(ROLLING, bodies=bodies, motion=slow, friction=1e3)
        yield Case("materials", f"slow rolling, nu = {nu:g}", slowly, table)
    shift = but(SHIFT, bodies=vc.Bodies(G=1.0, nu=0.0), surface=vc.Ellipse(1.0, 1.0), motion=vc.Shift(Fx=-0.2))
    yield Case("materials", "shift by a force, nu = 0", shift, MINDLIN, short=True)
    for f in (0.3, 1.0):
        for name, base in (("steady", ROLLING), ("shift", SHIFT), ("line", LINE)):
            scene, known = but(base, bodies=UNLIKE, friction=f), None if name == "line" else MIRROR
            yield Case("materials", f"{name}, K = 0.5, f = {f:g}", scene, known)
    pressed = but(SHIFT, bodies=UNLIKE, motion=vc.Shift(), friction=0.1)
    yield Case("materials", "pressing with friction, K = 0.5", pressed, MIRROR)
    free = but(LINE, bodies=vc.Bodies(G=(1.0, math.inf), nu=0.4), friction=math.inf, motion=vc.Steady(Fx=0.0))
    yield Case("materials", "line, rolling freely, no slip", free, Reference("Bufler", checks.free_rolling, 0.1))
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        rigid = vc.Bodies(G=(1.0, math.inf) if ratio > 1 else (math.inf, 1.0), nu=0.28)
        bodies = vc.Bodies(G=(1 + 1 / ratio, 1 + ratio), nu=0.28)  # the combined modulus of both is 2
        for name, base in (("steady", ROLLING), ("shift", SHIFT)):
            known = same("one body rigid", replace(base, bodies=rigid), cap=10 * min(ratio, 1 / ratio))
            yield Case("materials", f"{name}, G ratio {ratio:g}", but(base, bodies=bodies), known)


def half_sliding_line(
    part: float = 0.5, bodies: vc.Bodies = LIKE, dq: float | None = None, cells: int = 40
) -> vc.Scene:
    """Rolling cylinders at a part of the creepage of full sliding; dq in elements."""
    contact = line_contact(1.0, bodies, force=LINE.normal_force)
    step = None if dq is None else dq * 2 * contact.a / cells
    return replace(LINE, bodies=bodies, motion=vc.Steady(vx=part * 0.3 * contact.a, dq=step), grid=vc.Grid(nx=cells))


def shapes():
    """Ellipses with a/b from 1e-3 to 1e3, elements with dx/dy from 1e-3 to 1e3."""
    for ratio in (1e-3, 1e-2, 1e2, 1e3):
        a, b = math.sqrt(ratio), 1 / math.sqrt(ratio)
        text, base = f"a/b = {ratio:g}", replace(ROLLING, surface=vc.Ellipse(a, b))
        creep = 0.1 / a if ratio < 1 else 0.1 / ratio
        motion = vc.Steady(vx=creep, vy=creep / 2, spin=creep / max(a, b))
        pressing = but(base, motion=None, friction=None)
        yield Case("shapes", f"pressing, {text}", pressing, HERTZ, short=ratio in (1e-3, 1e3))
        yield Case("shapes", f"steady, {text}", but(base, motion=motion), MIRROR, short=ratio == 1e3)
        yield Case("shapes", f"shift, {text}", but(base, motion=vc.Shift(ux=0.1, uy=0.02)), MIRROR)
        yield Case("shapes", f"unlike, {text}", but(base, bodies=UNLIKE, motion=motion), MIRROR)
        if ratio < 1:
            strips = Reference("Carter in strips", checks.carter_strips, 0.1)
            yield Case("shapes", f"steady, {text}, vx alone", partial(half_sliding, base), strips, short=ratio == 1e-3)
    for nx, ny, a, b in ((20, 2, 0.1, 10.0), (2, 20, 10.0, 0.1), (100, 2, 1.0, 20.0), (2, 100, 20.0, 1.0)):
        base = replace(ROLLING, surface=vc.Ellipse(a, b), grid=vc.Grid(nx=nx, ny=ny))
        text = f"dx/dy = {a / nx * ny / b:g}, {nx} x {ny}"
        yield Case("shapes", f"steady, {text}", but(base, motion=vc.Steady(vx=0.1 * a, vy=0.05 * a)), MIRROR)
        known = replace(HERTZ, cap=0.25)  # two rows or columns
        yield Case("shapes", f"pressing, {text}", but(base, motion=None, friction=None), known)


def half_sliding(base: vc.Scene) -> vc.Scene:
    """At half of the creepage at which the middle strip of a narrow ellipse slides."""
    assert base.hertz is not None
    stiffness = base.bodies.combined_G / (1 - base.bodies.combined_nu)
    return replace(base, motion=vc.Steady(vx=0.3 * base.hertz.peak_pressure / stiffness))


PLACES = {2: [(0.0, -0.3), (0.0, 0.3)], 9: [(0.3 * i, 0.3 * j) for i in (-1, 0, 1) for j in (-1, 0, 1)]}
"""Middles of two and of nine bumps."""


def bumps(count: int) -> vc.Scene:
    """Round bumps of radius 1, far from each other by their contacts, five elements across each."""
    a, side = 0.05, 0.02
    nx, ny = (7 if count == 2 else 37), 37
    grid = vc.Grid(nx=nx, ny=ny, dx=side, dy=side, x0=-nx * side / 2, y0=-ny * side / 2)
    x, y = np.meshgrid(grid.x, grid.y)
    h = np.min([(x - i) ** 2 / 2 + (y - j) ** 2 / 2 for i, j in PLACES[count]], axis=0)
    force = count * 8 * a**3 / (3 * (1 - LIKE.combined_nu))
    return vc.Scene(bodies=LIKE, surface=vc.SampledDistance(h), normal_force=force, grid=grid)


LIMIT = 0.3
"""What friction carries in these scenes; in line contact a thousandth."""


def creepages():
    """Creepages from 1e-12 to 1 and above."""
    sticks = replace(ROLLING, motion=vc.Steady(vx=1.0, vy=0.5, spin=0.5), friction=math.inf)
    stuck = replace(SHIFT, motion=vc.Shift(ux=1.0, uy=0.5), friction=math.inf)
    rough = dict.fromkeys(("conic", "scs"), "a solver's own answer, where tractions are 1e-12 of their bound or less")
    for v in (1e-12, 1e-9, 1e-6):
        rolling, shift = vc.Steady(vx=v, vy=v / 2, spin=v / 2), vc.Shift(ux=v, uy=v / 2)
        yield Case("creepage", f"steady, vx = {v:g}", but(ROLLING, motion=rolling), MIRROR, short=v == 1e-12)
        for base, motion, stick in ((ROLLING, rolling, sticks), (SHIFT, shift, stuck)):
            text = f"{'steady' if base is ROLLING else 'shift'}, {v:g}, f = 1e3"
            scene = but(base, motion=motion, friction=1e3)
            yield Case("creepage", text, scene, proportional("no slip", stick, v), limits=rough if v < 1e-9 else {})
        yield Case("creepage", f"line, vx = {v:g}", but(LINE, motion=vc.Steady(vx=v)))
    for v in (1.0, 1e3):
        known = Reference("full sliding", checks.sliding, 0.01 / v)
        scene = but(ROLLING, motion=vc.Steady(vx=v, vy=v / 2))
        yield Case("creepage", f"steady, vx = {v:g}", scene, known, short=v == 1)
        yield Case(
            "creepage", f"shift, ux = {v:g}", but(SHIFT, motion=vc.Shift(ux=v, uy=v / 2)), replace(known, cap=1 / v)
        )
        yield Case("creepage", f"line, vx = {v:g}", but(LINE, motion=vc.Steady(vx=v)), known)
        yield Case("creepage", f"unlike, vx = {v:g}", but(ROLLING_UNLIKE, motion=vc.Steady(vx=v)), MIRROR)


def spins():
    """The pole of spin in the contact, at its edge, and far outside."""
    for spin in (1e-12, 0.3, 1.0, 1e3):
        text = f"pole in the middle, spin = {spin:g}"
        yield Case("spin", text, but(ROLLING, motion=vc.Steady(spin=spin)), MIRROR, short=spin == 1)
    for name, motion in {
        "at the leading edge": vc.Steady(vy=-0.3, spin=0.3),
        "at the trailing edge": vc.Steady(vy=0.3, spin=0.3),
        "at the side": vc.Steady(vx=0.24, spin=0.3),
        "in a node of the grid": vc.Steady(spin=0.3, spin_offset=0.5),
        "at an element's centre": vc.Steady(vx=0.3 * 0.08, vy=-0.3 * 0.1, spin=0.3, spin_offset=0.0),
    }.items():
        yield Case("spin", f"pole {name}", but(ROLLING, motion=motion), MIRROR, short="centre" in name)
    centre = vc.Shift(ux=0.3 * 0.08, uy=-0.3 * 0.1, rotation=0.3)
    yield Case("spin", "shift, pole at an element's centre", but(SHIFT, motion=centre), MIRROR)
    for far in (1e3, 1e9):
        straight = replace(ROLLING, motion=vc.Steady(vx=0.1))
        known = same("no spin", straight, cap=10 / far)
        yield Case("spin", f"pole at {far:g} radii", but(ROLLING, motion=vc.Steady(vx=0.1, spin=0.1 / far)), known)


def forces():
    """Prescribed forces: nothing, next to nothing, next to all, all and more."""
    circle = replace(SHIFT, bodies=vc.Bodies(1.0, 0.0), surface=vc.Ellipse(1.0, 1.0))
    rough = dict.fromkeys(
        ("scs", "osqp"), "operator splitting, where tractions are 1e-9 of their bound, or all but that"
    )
    for name, base, limit, motion, known in (
        ("steady", ROLLING, LIMIT, vc.Steady, MIRROR),
        ("shift", circle, LIMIT, vc.Shift, MINDLIN),
        ("line", LINE, LIMIT * 1e-3, vc.Steady, CARTER),
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
    both = vc.Steady(Fx=-0.6 * nearly, Fy=0.8 * nearly)
    yield Case("force", "steady, Fx and Fy, 0.999999 of the limit", but(ROLLING, motion=both), MIRROR, limits=rough)
    yield Case("force", "steady, Fx with spin", but(ROLLING, motion=vc.Steady(Fx=-0.2, spin=0.3)), MIRROR)
    yield Case("force", "steady, Fx with large spin", but(ROLLING, motion=vc.Steady(Fx=-0.29, spin=30.0)), MIRROR)
    unlike = but(ROLLING_UNLIKE, motion=vc.Steady(Fx=-nearly))
    yield Case("force", "unlike, 0.999999 of the limit", unlike, MIRROR, limits=rough)
    yield Case("force", "unlike, no force", but(ROLLING_UNLIKE, motion=vc.Steady(Fx=0.0, Fy=0.0)), MIRROR)


def contacts():
    """Few elements, one row, a corner of the grid, separate patches."""
    few = {"one element": (1, 1), "two elements": (2, 1), "two rows": (1, 2), "three elements": (3, 1), "2 x 2": (2, 2)}
    few |= {"one row": (20, 1), "one column": (1, 20)}
    bases = {"steady": ROLLING, "shift": SHIFT, "unlike": ROLLING_UNLIKE, "pressing": PRESSING, "history": HISTORY}
    for name, (nx, ny) in few.items():
        for kind, base in bases.items():
            known = None if kind in ("pressing", "history") else MIRROR
            scene, short = but(base, grid=vc.Grid(nx=nx, ny=ny, margin=0)), name == "three elements"
            families = ("polished", "conic", "active set", "scs", "osqp") if kind == "pressing" else Case.families
            yield Case("elements", f"{name}, {kind}", scene, known, families=families, short=short)
    for cells in (1, 2, 3):
        yield Case("elements", f"line, {cells} elements", but(LINE, grid=vc.Grid(nx=cells, margin=0)))
    for count, name in ((2, "two"), (9, "nine")):
        base = bumps(count)
        error = partial(checks.hertz_patches, places=PLACES[count], radius=1.0)
        loads = Reference("Hertz's contacts under point loads", error, 0.03)
        yield Case("patches", f"pressing, {name} patches", but(base), loads, short=count == 2)
        for kind, motion in (("steady", vc.Steady(vx=0.003, spin=0.005)), ("shift", vc.Shift(ux=0.003, rotation=1e-3))):
            yield Case("patches", f"{kind}, {name} patches", but(base, friction=0.3, motion=motion), MIRROR)
        unlike = but(base, friction=0.3, motion=vc.Steady(vx=0.003), bodies=UNLIKE)
        families = Case.families if count == 2 else ("default", "active set")
        yield Case("patches", f"steady, {name} patches, unlike", unlike, MIRROR, families=families)
    beyond, within = partial(_at_corner, 0.0), partial(_at_corner, 2.5)
    yield Case("patches", "at a corner of the grid and beyond", beyond, answer=False, short=True)
    yield Case("patches", "at a corner of the grid", within, MIRROR, short=True)
    yield Case("patches", "at a corner, where the body ends", _body_end, MIRROR)


def _at_corner(elements: float) -> vc.Scene:
    """A round contact, four elements across, whose middle is some elements from the lower left corner of the grid."""
    grid, place = vc.Grid(nx=12, ny=12, dx=0.02, dy=0.02, x0=0.0, y0=0.0), elements * 0.02
    x, y = np.meshgrid(grid.x, grid.y)
    surface = vc.SampledDistance((x - place) ** 2 / 2 + (y - place) ** 2 / 2)
    force = 8 * 0.04**3 / (3 * (1 - LIKE.combined_nu))
    return replace(ROLLING, surface=surface, normal_force=force, grid=grid, motion=vc.Steady(vx=3e-3, spin=0.01))


def _body_end() -> vc.Scene:
    """A contact at a corner of a body, beyond which the distance is large."""
    scene = _at_corner(3.0)
    h = scene.surface.h.copy()
    h[:3], h[:, :3] = 1.0, 1.0
    return replace(scene, surface=vc.SampledDistance(h))


def touches():
    """Approaches and forces that just touch, and those that do not."""
    force = Reference("Hertz", checks.hertz_force, 0.05)
    bare: dict = {"motion": None, "friction": None}
    pressing, line = replace(PRESSING, normal_force=1.0), replace(LINE, surface=vc.Cylinders(1.0, 1.0), **bare)
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


def _sampled(approach: float) -> vc.Scene:
    x = np.linspace(-1.0, 1.0, 81)
    surface = vc.SampledDistance(1 + x**2 / 2 + x[:, None] ** 2 / 2, x=x, y=x)
    return replace(PRESSING, surface=surface, normal_force=None, approach=approach)


def steps():
    """Steps dq from a thousandth of an element to ten, and ten thousand steps."""
    short_steps = {"tang": "TANG with inexact Newton steps, in steps of a tenth of an element or less"}
    unlike, incompressible = replace(ROLLING, bodies=UNLIKE), replace(ROLLING, bodies=vc.Bodies(G=1.0, nu=0.5))
    for dq in (1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0):
        limits, text = short_steps if dq <= 0.1 else {}, f"dq = {dq:g} elements"
        known = replace(CARTER, cap=0.06 + 0.03 * dq)
        rolling = partial(half_sliding_line, dq=dq)
        yield Case("steps", f"line, {text}", rolling, known, limits=limits, short=dq in (0.5, 10.0))
        for name, base in (("steady", ROLLING), ("unlike", unlike), ("incompressible", incompressible)):
            motion = vc.Steady(vx=0.1, vy=0.05, spin=0.15, dq=0.2 * dq)
            yield Case("steps", f"{name}, {text}", but(base, motion=motion), MIRROR, limits=limits)
    for dq in (1e-3, 0.5, 10.0):
        history = but(HISTORY, motion=vc.Transient(steps=5, dq=0.2 * dq, vx=0.1, spin=0.1))
        yield Case("steps", f"history, dq = {dq:g} elements", history)
    steady, tiny = Reference("steady rolling", checks.steady_state), vc.Grid(nx=4, ny=4)
    spheres = replace(ROLLING, surface=SPHERES, grid=tiny, motion=vc.Transient(steps=100, vx=0.05, spin=0.1))
    both, one = ("default", "active set"), ("active set",)
    yield Case("steps", "spheres, 100 steps", but(spheres), steady, families=both, work=marched, short=True)
    long, line = vc.Transient(steps=10_000, vx=0.05, spin=0.1), partial(_long_line, 10_000)
    many, text = but(spheres, motion=long), "10000 steps"
    yield Case("steps", f"spheres, {text}", many, steady, families=one, work=marched, seconds=900.0)
    yield Case("steps", f"line, {text}", line, steady, families=("default",), work=marched, seconds=900.0)


def _long_line(count: int) -> vc.Scene:
    scene = half_sliding_line(cells=10)
    return replace(scene, motion=vc.Transient(steps=count, vx=scene.motion.vx))


def marched(scene: vc.Scene, **options) -> vc.Solution:
    """The last step of a long history that is kept in a file: memory must not grow with its steps."""
    sizes: list[int] = []
    with tempfile.TemporaryDirectory() as folder:

        def watch(_: str) -> None:
            sizes.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

        history = vc.solve(scene, **options, store=Path(folder) / "history.nc", progress=watch)
        assert not isinstance(history, vc.Solution)
        if sizes[-1] > 1.2 * sizes[len(sizes) // 4]:
            raise MemoryError(
                f"memory grew from {sizes[len(sizes) // 4]} to {sizes[-1]} during the last three quarters"
            )
        return history[-1]
