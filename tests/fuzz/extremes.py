"""Scenes at the edge of what can be described, by every family of solvers; all but those in units
are dimensionless.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import varcontact as vc
from tests.fuzz.judge import faults
from tests.fuzz.outcome import Case
from tests.scenes import make_scene
from varcontact.reference.line_contact import line_contact
from varcontact.solving.selection import select
from varcontact.theories.on_grid import THEORIES, why_not

OWN = {"polish": False, "tol": 1e-5}
FAMILIES = {
    "default": {},
    "polished": {"normal": "clarabel", "tangential": "clarabel"},
    "conic": {"normal": "clarabel", "tangential": "clarabel", **OWN},
    "active set": {"normal": "norm", "tangential": "tang-safeguarded"},
    "tang": {"normal": "norm", "tangential": "tang"},
    "newton": {"normal": "newton", "tangential": "newton"},
    "scs": {"normal": "scs", "tangential": "scs", **OWN},
    "osqp": {"normal": "osqp", "tangential": "osqp", **OWN},
    "joint": {"coupling": "joint"},
    "johnson": {"coupling": "johnson"},
    "fastsim": {"tangential": "fastsim"},
    "linear": {"tangential": "linear"},
}
"""The default is what "auto" takes; conic, scs and osqp are a solver's own answer, polished is
Clarabel's, polished."""


@dataclass(frozen=True)
class Extreme:
    """A scene, made when it is asked for; whether it has an answer, whether that is owed by
    default, and soon found.
    """

    name: str
    scene: Callable[[], vc.Scene]
    answer: bool = True
    owed: bool = True
    short: bool = False

    def cases(self) -> Iterator[Case]:
        """By each family that is for such a scene at all; what cannot be made is refused once."""
        try:
            families = [family for family in FAMILIES if applies(family, self.scene())]
        except vc.VarcontactError:
            families = ["default"]
        for family in families:
            unjust = self.answer and self.owed and family == "default"
            call = partial(self.judged, family, unjust)
            yield Case(f"{self.name}, by {family}", call, str if unjust else lambda error: "")

    def judged(self, family: str, unjust: bool) -> list[str]:
        """What is wrong with the answer of a family, which may be that there is none."""
        scene, options = self.scene(), dict(FAMILIES[family])
        if scene.motion is None:
            options.pop("tangential", None)
        elif select(scene).normal == "hertz":
            options.pop("normal", None)
        try:
            answer = vc.solve(scene, **options)
        except vc.NotConverged as error:
            if unjust:
                return [str(error)]
            raise
        steps = [answer] if isinstance(answer, vc.Solution) else list(answer)
        found = [] if self.answer else ["an answer where there is none"]
        for before, sol in zip([None, *steps], steps, strict=False):
            found += faults(sol, options.get("tol", 1e-8), before)
        return found


def applies(family: str, scene: vc.Scene) -> bool:
    if family in ("joint", "johnson"):
        return scene.bodies.coupled and not scene.frictionless
    if family in THEORIES:
        return not why_not(family, scene)
    if family == "osqp":
        return scene.motion is None or (scene.line and not isinstance(scene.motion, vc.Transient))
    return family != "tang" or scene.motion is not None


LIKE, UNLIKE = vc.Bodies(G=1.0, nu=0.28), vc.Bodies(G=(1.0, math.inf), nu=0.0)


def bases(length: float = 1.0, modulus: float = 1.0) -> dict[str, vc.Scene]:
    """Ordinary scenes, with so large a unit of length, and of force by area."""
    force, bodies = modulus * length**2, vc.Bodies(G=modulus, nu=0.28)
    motion = vc.Steady(vx=0.1, vy=0.05, spin=0.15 / length)
    ellipse = vc.Ellipse(a=length, b=0.8 * length)
    rolling = make_scene(ellipse, force, motion, vc.Grid(nx=8, ny=8), bodies=bodies)
    shift = vc.Shift(ux=0.08 * length, uy=0.04 * length, rotation=0.05)
    steps = vc.Transient(
        steps=3, dq=[0, 0.1 * length, 0.1 * length], vx=0.1, ux=[0.05 * length, 0.0, 0.0]
    )
    spheres = vc.Paraboloids(Rx=length, Ry=0.7 * length)
    cylinders, straight = vc.Cylinders(R=length, reference_depth=10.0 * length), vc.Steady(vx=4e-3)
    line = replace(rolling, surface=cylinders, grid=vc.Grid(nx=40), motion=straight)
    return {
        "steady": rolling,
        "shift": replace(rolling, motion=shift),
        "unlike": replace(rolling, bodies=vc.Bodies(G=(modulus, math.inf), nu=0.0)),
        "line": replace(line, normal_force=1e-3 * modulus * length),
        "pressing": replace(rolling, surface=spheres, motion=None, friction=None),
        "history": replace(rolling, surface=spheres, motion=steps),
    }


BASES = bases()


def but(name: str, **changes) -> Callable[[], vc.Scene]:
    """Makes an ordinary scene but for some entries, when it is asked for."""
    return partial(replace, BASES[name], **changes)


def extremes() -> list[Extreme]:
    groups = (
        units,
        friction,
        materials,
        shapes,
        creepages,
        spins,
        forces,
        contacts,
        touches,
        steps,
    )
    return [each for group in groups for each in group()]


def units() -> Iterator[Extreme]:
    """Moduli from 1e-12 to 1e15, lengths from 1e-9 to 1e6."""
    for name in BASES:
        for length, modulus in ((1e-9, 1e-12), (1e-9, 1e15), (1e6, 1e-12), (1e6, 1e15)):
            short = (length, modulus) == (1e-9, 1e15) and name in ("steady", "line", "pressing")
            scene = partial(lambda name, *units: bases(*units)[name], name, length, modulus)
            yield Extreme(
                f"units: {name}, lengths {length:g}, moduli {modulus:g}", scene, short=short
            )


def friction() -> Iterator[Extreme]:
    """Friction from 1e-9 to 1e6, and nine decades of it in one contact."""
    for f in (1e-9, 1e-6, 1e-3, 1e3, 1e6):
        for name in ("steady", "shift", "line"):
            motion, short = (
                scaled(BASES[name].motion, f / 0.3),
                name == "steady" and f in (1e-9, 1e6),
            )
            scene = but(name, friction=f, motion=motion)
            yield Extreme(f"friction: {name}, f = {f:g}, creepages with it", scene, short=short)
    yield Extreme(
        "friction: no spin, f = 1e-9",
        but("steady", friction=1e-9, motion=vc.Steady(vx=0.1, vy=0.05)),
    )
    for f in (1e-9, 1e6):
        yield Extreme(f"friction: steady, f = {f:g}", but("steady", friction=f), short=f < 1)
    yield Extreme("friction: unlike, f = 1e-9", but("unlike", friction=1e-9))
    for f in (1e6, math.inf):  # no coupling loop converges as a rule
        yield Extreme(f"friction: unlike, f = {f:g}", but("unlike", friction=f), owed=False)
    decades = {
        "friction": 10 ** np.random.default_rng(3).uniform(-6, 3, (12, 12)),
        "surface": vc.Ellipse(1.0, 1.0),
    }
    decades["grid"] = vc.Grid(nx=12, ny=12, dx=0.2, dy=0.2, x0=-1.2, y0=-1.2)
    for name in ("steady", "shift", "unlike"):
        yield Extreme(
            f"friction: {name}, nine decades", but(name, **decades), short=name == "shift"
        )


def scaled(motion: vc.Steady | vc.Shift, part: float) -> vc.Steady | vc.Shift:
    """The motion with all creepages, or shifts, times a number."""
    names = ("vx", "vy", "spin") if isinstance(motion, vc.Steady) else ("ux", "uy", "rotation")
    return replace(motion, **{name: part * getattr(motion, name) for name in names})


def materials() -> Iterator[Extreme]:
    """Poisson's ratios 0, 0.5, -0.9 and nearly -1; K = 0.5, the largest; moduli with ratios from
    1e-6 to 1e6.
    """
    for nu in (0.0, 0.5, -0.9, -0.999999):
        bodies = vc.Bodies(G=1.0, nu=nu)
        yield Extreme(
            f"materials: pressing, nu = {nu:g}", but("pressing", bodies=bodies), short=nu == -0.9
        )
        yield Extreme(f"materials: steady, nu = {nu:g}", but("steady", bodies=bodies))
        yield Extreme(f"materials: line, nu = {nu:g}", partial(half_sliding_line, bodies=bodies))
        slow = {"motion": vc.Steady(vx=1e-3, vy=5e-4, spin=5e-4), "friction": 1e3}
        yield Extreme(f"materials: slow rolling, nu = {nu:g}", but("steady", bodies=bodies, **slow))
    incompressible = {"bodies": vc.Bodies(G=1.0, nu=0.0), "surface": vc.Ellipse(1.0, 1.0)}
    shift = but("shift", **incompressible, motion=vc.Shift(Fx=-0.2))
    yield Extreme("materials: shift by a force, nu = 0", shift, short=True)
    for f in (0.3, 1.0):
        for name in ("steady", "shift", "line"):
            yield Extreme(
                f"materials: {name}, K = 0.5, f = {f:g}", but(name, bodies=UNLIKE, friction=f)
            )
    pressed = but("shift", bodies=UNLIKE, motion=vc.Shift(), friction=0.1)
    yield Extreme("materials: pressing with friction, K = 0.5", pressed)
    stiff = vc.Bodies(G=(1.0, math.inf), nu=0.4)
    free = but("line", bodies=stiff, friction=math.inf, motion=vc.Steady(Fx=0.0))
    yield Extreme("materials: line, rolling freely, no slip", free)
    for ratio in (1e-6, 1e-3, 1e3, 1e6):
        bodies = vc.Bodies(G=(1 + 1 / ratio, 1 + ratio), nu=0.28)  # the combined modulus is 2
        for name in ("steady", "shift"):
            yield Extreme(f"materials: {name}, G ratio {ratio:g}", but(name, bodies=bodies))


def half_sliding_line(bodies: vc.Bodies = LIKE, dq: float | None = None) -> vc.Scene:
    """Rolling cylinders at half of the creepage of full sliding; dq in elements."""
    line = BASES["line"]
    a = line_contact(1.0, bodies, force=line.normal_force).a
    step = None if dq is None else dq * 2 * a / line.grid.nx
    return replace(line, bodies=bodies, motion=vc.Steady(vx=0.15 * a, dq=step))


def shapes() -> Iterator[Extreme]:
    """Ellipses with a/b from 1e-3 to 1e3, elements with dx/dy from 1e-3 to 1e3."""
    for ratio in (1e-3, 1e-2, 1e2, 1e3):
        a, b = math.sqrt(ratio), 1 / math.sqrt(ratio)
        text, surface = f"a/b = {ratio:g}", vc.Ellipse(a, b)
        creep = 0.1 / a if ratio < 1 else 0.1 / ratio
        motion = vc.Steady(vx=creep, vy=creep / 2, spin=creep / max(a, b))
        pressing = but("pressing", surface=surface)
        yield Extreme(f"shapes: pressing, {text}", pressing, short=ratio in (1e-3, 1e3))
        yield Extreme(
            f"shapes: steady, {text}",
            but("steady", surface=surface, motion=motion),
            short=ratio == 1e3,
        )
        straight = but("steady", surface=surface, motion=vc.Steady(vx=creep))
        yield Extreme(f"shapes: steady, {text}, vx alone", straight, short=ratio == 1e-3)
        yield Extreme(
            f"shapes: shift, {text}",
            but("shift", surface=surface, motion=vc.Shift(ux=0.1, uy=0.02)),
        )
        yield Extreme(f"shapes: unlike, {text}", but("unlike", surface=surface, motion=motion))
    for nx, ny, a, b in (
        (20, 2, 0.1, 10.0),
        (2, 20, 10.0, 0.1),
        (100, 2, 1.0, 20.0),
        (2, 100, 20.0, 1.0),
    ):
        flat = {"surface": vc.Ellipse(a, b), "grid": vc.Grid(nx=nx, ny=ny)}
        text = f"dx/dy = {a / nx * ny / b:g}, {nx} x {ny}"
        yield Extreme(
            f"shapes: steady, {text}",
            but("steady", **flat, motion=vc.Steady(vx=0.1 * a, vy=0.05 * a)),
        )
        yield Extreme(f"shapes: pressing, {text}", but("pressing", **flat))


def creepages() -> Iterator[Extreme]:
    """Creepages from 1e-12 to 1 and above."""
    for v in (1e-12, 1e-9, 1e-6, 1.0, 1e3):
        rolling, shift = (
            vc.Steady(vx=v, vy=v / 2, spin=v / 2 if v < 1 else 0.0),
            vc.Shift(ux=v, uy=v / 2),
        )
        yield Extreme(
            f"creepage: steady, vx = {v:g}", but("steady", motion=rolling), short=v in (1e-12, 1.0)
        )
        yield Extreme(f"creepage: shift, ux = {v:g}", but("shift", motion=shift))
        yield Extreme(f"creepage: line, vx = {v:g}", but("line", motion=vc.Steady(vx=v)))
        yield Extreme(f"creepage: unlike, vx = {v:g}", but("unlike", motion=vc.Steady(vx=v)))
        for name, motion in (("steady", rolling), ("shift", shift)) if v < 1 else ():
            yield Extreme(
                f"creepage: {name}, {v:g}, f = 1e3", but(name, motion=motion, friction=1e3)
            )


def spins() -> Iterator[Extreme]:
    """The pole of spin in the contact, at its edge, and far outside."""
    for spin in (1e-12, 0.3, 1.0, 1e3):
        scene = but("steady", motion=vc.Steady(spin=spin))
        yield Extreme(f"spin: pole in the middle, spin = {spin:g}", scene, short=spin == 1)
    for name, motion in {
        "at the leading edge": vc.Steady(vy=-0.3, spin=0.3),
        "at the trailing edge": vc.Steady(vy=0.3, spin=0.3),
        "at the side": vc.Steady(vx=0.24, spin=0.3),
        "in a node of the grid": vc.Steady(spin=0.3, spin_offset=0.5),
        "at an element's centre": vc.Steady(
            vx=0.3 * 0.1, vy=-0.3 * 0.125, spin=0.3, spin_offset=0.0
        ),
        "at 1e3 radii": vc.Steady(vx=0.1, spin=1e-4),
        "at 1e9 radii": vc.Steady(vx=0.1, spin=1e-10),
    }.items():
        yield Extreme(f"spin: pole {name}", but("steady", motion=motion), short="centre" in name)
    centre = vc.Shift(ux=0.3 * 0.1, uy=-0.3 * 0.125, rotation=0.3)
    yield Extreme("spin: shift, pole at an element's centre", but("shift", motion=centre))


def forces() -> Iterator[Extreme]:
    """Prescribed forces: nothing, next to nothing, next to all, all and more."""
    circle = {"bodies": vc.Bodies(1.0, 0.0), "surface": vc.Ellipse(1.0, 1.0)}
    for name, changes, limit, kind in (
        ("steady", {}, 0.3, vc.Steady),
        ("shift", circle, 0.3, vc.Shift),
        ("line", {}, 0.3e-3, vc.Steady),
    ):
        for part in (0.0, 1e-9, 0.5, 1 - 1e-6, 1.0, 1 + 1e-9, 1e6):
            short = part == 1 - 1e-6 or (name == "steady" and part in (0.0, 1.0))
            scene = but(name, **changes, motion=kind(Fx=-part * limit))
            yield Extreme(
                f"force: {name}, {part:.10g} of the limit", scene, answer=part < 1, short=short
            )
    for name, motion in {
        "Fx and Fy, 0.999999 of the limit": vc.Steady(Fx=-0.18 * (1 - 1e-6), Fy=0.24 * (1 - 1e-6)),
        "Fx with spin": vc.Steady(Fx=-0.2, spin=0.3),
        "Fx with large spin": vc.Steady(Fx=-0.29, spin=30.0),
    }.items():
        yield Extreme(f"force: {name}", but("steady", motion=motion))
    for force in (0.0, -0.3 * (1 - 1e-6)):
        yield Extreme(
            f"force: unlike, {force:.7g}", but("unlike", motion=vc.Steady(Fx=force, Fy=0.0))
        )


def contacts() -> Iterator[Extreme]:
    """Few elements, one row, a corner of the grid, separate patches."""
    for nx, ny in ((1, 1), (2, 1), (1, 2), (3, 1), (2, 2), (20, 1), (1, 20)):
        for name in BASES:
            grid = vc.Grid(nx=nx, margin=0) if name == "line" else vc.Grid(nx=nx, ny=ny, margin=0)
            yield Extreme(f"elements: {nx} x {ny}, {name}", but(name, grid=grid), short=nx == 3)
    for count in (2, 9):
        for kind, motion in {
            "pressing": None,
            "steady": vc.Steady(vx=0.003, spin=0.005),
            "shift": vc.Shift(ux=0.003, rotation=1e-3),
            "unlike": vc.Steady(vx=0.003),
        }.items():
            changes = {"motion": motion, "bodies": UNLIKE if kind == "unlike" else LIKE}
            scene = partial(bumps, count, **changes)
            yield Extreme(
                f"patches: {kind}, {count} patches", scene, short=count == 2 and motion is None
            )
    yield Extreme(
        "patches: at a corner of the grid and beyond",
        partial(at_corner, 0.0),
        answer=False,
        short=True,
    )
    yield Extreme("patches: at a corner of the grid", partial(at_corner, 2.5), short=True)
    yield Extreme("patches: at a corner, where the body ends", partial(at_corner, 3.0, ends=True))


def bumps(count: int, **changes) -> vc.Scene:
    """Two or nine round bumps of radius 1, far from each other by their contacts, five elements
    across each.
    """
    places = (
        [(0.0, -0.3), (0.0, 0.3)]
        if count == 2
        else [(0.3 * i, 0.3 * j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    )
    nx, ny, side = (7 if count == 2 else 37), 37, 0.02
    grid = vc.Grid(nx=nx, ny=ny, dx=side, dy=side, x0=-nx * side / 2, y0=-ny * side / 2)
    x, y = np.meshgrid(grid.x, grid.y)
    h = np.min([(x - i) ** 2 / 2 + (y - j) ** 2 / 2 for i, j in places], axis=0)
    force = count * 8 * 0.05**3 / (3 * (1 - LIKE.combined_nu))
    return replace(
        BASES["steady"], surface=vc.SampledDistance(h), normal_force=force, grid=grid, **changes
    )


def at_corner(elements: float, ends: bool = False) -> vc.Scene:
    """A round contact, four elements across, whose middle is some elements from the lower left
    corner of the grid.
    """
    grid, place = vc.Grid(nx=12, ny=12, dx=0.02, dy=0.02, x0=0.0, y0=0.0), elements * 0.02
    x, y = np.meshgrid(grid.x, grid.y)
    h = (x - place) ** 2 / 2 + (y - place) ** 2 / 2
    if ends:
        h[:3], h[:, :3] = 1.0, 1.0
    force, motion = 8 * 0.04**3 / (3 * (1 - LIKE.combined_nu)), vc.Steady(vx=3e-3, spin=0.01)
    return replace(
        BASES["steady"], surface=vc.SampledDistance(h), normal_force=force, grid=grid, motion=motion
    )


def touches() -> Iterator[Extreme]:
    """Approaches and forces that just touch, and those that do not."""
    still = {"normal_force": None, "motion": None, "friction": None}
    for approach in (1e-6, 1e-12, 1e-60, 1e-300, 0.0, -1.0):
        for name in ("pressing", "line"):
            answer, short = approach > 1e-100, name == "pressing" and approach in (1e-12, 0.0)
            scene = but(name, **still, approach=approach)
            yield Extreme(
                f"touch: {name}, approach {approach:g}", scene, answer=answer, short=short
            )
    x = np.linspace(-1.0, 1.0, 81)
    surface = vc.SampledDistance(1 + x**2 / 2 + x[:, None] ** 2 / 2, x=x, y=x)
    for more in (1e-3, 1e-9, 1e-12, 1e-15, 0.0):
        scene = but("pressing", **still, surface=surface, approach=1 + more)
        yield Extreme(f"touch: samples from 1, approach 1 + {more:g}", scene, answer=more > 1e-14)
    for load in (1e-300, 1e-90, 1e90):
        yield Extreme(
            f"touch: force {load:g}", but("pressing", normal_force=load), answer=load > 1e-100
        )


def steps() -> Iterator[Extreme]:
    """Steps dq from a thousandth of an element to ten, and a hundred steps."""
    incompressible = vc.Bodies(G=1.0, nu=0.5)
    for dq in (1e-3, 1e-2, 0.1, 0.5, 1.0, 2.0, 5.0, 10.0):
        text = f"dq = {dq:g} elements"
        yield Extreme(
            f"steps: line, {text}", partial(half_sliding_line, dq=dq), short=dq in (0.5, 10.0)
        )
        motion = vc.Steady(vx=0.1, vy=0.05, spin=0.15, dq=0.25 * dq)
        for name, bodies in (
            ("steady", LIKE),
            ("unlike", UNLIKE),
            ("incompressible", incompressible),
        ):
            yield Extreme(f"steps: {name}, {text}", but("steady", bodies=bodies, motion=motion))
        history = but("history", motion=vc.Transient(steps=5, dq=0.25 * dq, vx=0.1, spin=0.1))
        yield Extreme(f"steps: history, {text}", history)
    many = vc.Transient(steps=100, vx=0.05, spin=0.1)
    yield Extreme("steps: 100", but("history", grid=vc.Grid(nx=4, ny=4), motion=many))
