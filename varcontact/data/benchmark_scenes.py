"""Scenes on which methods are compared, and scenes of all classes whose continuum values are kept as references.

All are dimensionless: Fz = 1, G = 1 (but for unlike bodies), and sqrt(ab) = 1 of the references' ellipses, whose
creepages are given in units of about the saturation creepage, spin in the same divided by sqrt(ab).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Motion, Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance
from varcontact.scene.transient import Transient

FRICTION = 0.3
LIMIT = FRICTION
"""f Fz, with Fz = 1."""
NU = 0.28

SATURATION = {
    (1.0, 0.0): 0.264705882353,
    (1.0, NU): 0.212955269516,
    (1.0, 0.5): 0.173076923077,
    (0.1, NU): 0.261525747584,
    (0.2, NU): 0.257442931437,
    (0.5, NU): 0.241060413164,
    (2.0, NU): 0.172953796893,
    (3.0, NU): 0.146574687242,
    (5.0, NU): 0.114044980815,
    (10.0, NU): 0.0760626352131,
    (0.3, 0.0): 0.335820895522,
    (3.0, 0.0): 0.170320587811,
    (0.3, 0.5): 0.1875,
    (3.0, 0.5): 0.127966400866,
}
"""Creepages at which the contact is about saturated, ``3 f Fz / (G a b C11)``, by a/b and nu: they stay as they are."""
UNIT = SATURATION[1.0, NU]

CLASSES = (
    "normal", "shift", "steady, circular", "steady, slender", "forces given", "non-Hertzian", "unlike bodies",
    "line contact", "transient"
)  # fmt: skip
"""The classes of scenes, in each of which ways are compared."""
STEPS = (0, 5, 11)
"""The steps of histories whose forces are kept."""


def standard_bank(cells: int = 12) -> dict[str, Scene]:
    """Fourteen scenes by name, dimensionless (G = 1, Fz = 1), from easy to hard.

    Parameters
    ----------
    cells : int
        Elements across the contact in both directions.

    Returns
    -------
    dict of str to Scene

    Examples
    --------
    >>> bank = standard_bank()
    >>> len(bank), bank["pure spin, large"].motion.spin
    (14, 1.2)
    """
    cells = checks.whole("cells", cells)
    circle, long = Ellipse(a=1.0, b=1.0), float(np.sqrt(5))
    along, across = Ellipse(a=long, b=1 / long), Ellipse(a=1 / long, b=long)
    base: Scene = Scene(
        bodies=Bodies(G=1.0, nu=0.28),
        surface=circle,
        normal_force=1.0,
        friction=FRICTION,
        motion=Steady(vx=0.1),
        grid=Grid(nx=cells, ny=cells),
    )
    steady = {
        "pure vx": (circle, Steady(vx=0.1)),
        "pure vy": (circle, Steady(vy=0.1)),
        "pure spin, small": (circle, Steady(spin=0.05)),
        "pure spin, large": (circle, Steady(spin=1.2)),
        "vx, vy and spin": (circle, Steady(vx=0.06, vy=-0.05, spin=0.15)),
        "vy against spin": (circle, Steady(vy=-0.1, spin=0.2)),
        "a/b = 5": (along, Steady(vx=0.05, vy=0.02, spin=0.05)),
        "a/b = 0.2": (across, Steady(vx=0.1, vy=0.05, spin=0.1)),
        "near full slip": (circle, Steady(vx=0.19, vy=0.12, spin=0.02)),
        "Fx prescribed": (circle, Steady(Fx=-0.6 * LIMIT, vy=0.03, spin=0.1)),
        "Fx and Fy near saturation": (circle, Steady(Fx=-0.7 * LIMIT, Fy=0.7 * LIMIT)),
    }
    bank = {name: replace(base, surface=surface, motion=motion) for name, (surface, motion) in steady.items()}
    bank["shift with rotation"] = replace(base, motion=Shift(ux=0.05, uy=0.02, rotation=0.08))
    x = y = np.linspace(-2.5, 2.5, 101)
    profile = np.where(y < 0, y**2 / 2.4, y**2 / 0.8)  # with a common tangent
    two_arcs = SampledDistance(x[None, :] ** 2 / 1.2 + profile[:, None], x=x, y=y)
    bank["two arcs"] = replace(base, surface=two_arcs, motion=Steady(vx=0.06, vy=0.02, spin=0.1))
    bank["unlike bodies"] = replace(
        base, bodies=Bodies(G=(2.0, 0.7), nu=(0.25, 0.4)), motion=Steady(vx=0.05, vy=0.02, spin=0.1)
    )
    return bank


def unlike_bank(cells: int = 12) -> dict[str, Scene]:
    """Twenty scenes of unlike bodies by name, dimensionless: four pairs of bodies in five motions each.

    Friction is 0.1 to 0.9, the contact (without tractions) an ellipse with axes 2 to 1, a circle, or one across.

    Parameters
    ----------
    cells : int
        Elements across the contact in both directions.

    Returns
    -------
    dict of str to Scene

    Examples
    --------
    >>> bank = unlike_bank()
    >>> len(bank), sorted({round(scene.bodies.K, 2) for scene in bank.values()})
    (20, [-0.25, 0.07, 0.2, 0.5])
    """
    cells = checks.whole("cells", cells)
    pairs = {
        "aluminium on steel": Bodies(G=(1.0, 3.1), nu=(0.33, 0.28)),
        "hard on soft": Bodies(G=(10.0, 1.0), nu=(0.28, 0.2)),
        "soft on rigid": Bodies(G=(1.0, np.inf), nu=(0.3, 0.3)),
        "cork on rigid": Bodies(G=(1.0, np.inf), nu=(0.0, 0.3)),
    }
    shapes = [Ellipse(a=1.0, b=1.0), Ellipse(a=1.4, b=0.7), Ellipse(a=0.7, b=1.4)]
    frictions = [0.1, 0.3, 0.6, 0.9]
    bank = {}
    for i, (pair, bodies) in enumerate(pairs.items()):
        for k in range(5):
            f = frictions[(i + k) % len(frictions)]
            unit = f / bodies.combined_G  # a creepage or shift of about one unit is full slip
            motions: dict[str, Steady | Shift] = {
                "free rolling": Steady(),
                "creepage and spin": Steady(vx=0.3 * unit, vy=-0.1 * unit, spin=0.3 * unit),
                "spin": Steady(spin=0.6 * unit),
                "force": Steady(Fx=-0.6 * f, vy=0.1 * unit),
                "shift": Shift(ux=0.2 * unit, uy=0.1 * unit, rotation=0.2 * unit),
            }
            name, motion = list(motions.items())[k]
            bank[f"{pair}, {name}"] = Scene(
                bodies=bodies,
                surface=shapes[(i + 2 * k) % len(shapes)],
                normal_force=1.0,
                friction=f,
                motion=motion,
                grid=Grid(nx=cells, ny=cells),
            )
    return bank


@dataclass(frozen=True, eq=False)
class Posed:
    """A scene without a grid, with its class, and of a history the steps whose forces are kept."""

    kind: str
    scene: Scene
    steps: tuple[int, ...] = ()


def reference_scenes() -> dict[str, Posed]:
    """The scenes of the references by name."""
    makers = (_normal, _shifts, _circular, _slender, _forces, _non_hertzian, _unlike, _line, _transient)
    return {
        name: Posed(kind, scene, STEPS if kind == "transient" else ())
        for kind, make in zip(CLASSES, makers, strict=True)
        for name, scene in make().items()
    }


def _base(ratio: float = 1.0, nu: float = NU, motion: Motion | Transient | None = None) -> Scene:
    """On an ellipse of area pi, with semi-axes in a ratio."""
    surface = Ellipse(a=math.sqrt(ratio), b=1 / math.sqrt(ratio))
    return Scene(bodies=Bodies(G=1.0, nu=nu), surface=surface, normal_force=1.0, friction=FRICTION, motion=motion)


def _rolling(x: float, y: float, turn: float, ratio: float = 1.0, nu: float = NU) -> Scene:
    unit = SATURATION[ratio, nu]
    return _base(ratio, nu, Steady(vx=x * unit, vy=y * unit, spin=turn * unit))


def _circular() -> dict[str, Scene]:
    creepages = {
        "linear": (0.02, 0.01, 0.02),
        "half, along": (0.5, 0.0, 0.0),
        "half, across": (0.0, 0.5, 0.0),
        "small spin": (0.0, 0.0, 0.25),
        "spin": (0.0, 0.0, 1.0),
        "large spin": (0.0, 0.0, 5.0),
        "along and across": (0.4, -0.4, 0.0),
        "along and spin": (0.5, 0.0, 0.5),
        "across and spin": (0.0, 0.4, 0.6),
        "across against spin": (0.0, -0.5, 0.8),
        "all three": (0.3, -0.2, 0.5),
        "near full slip": (0.8, 0.5, 0.1),
        "full slip": (3.0, -2.0, 0.2),
        "creepage and large spin": (1.0, 0.5, 4.0),
    }
    scenes = {f"circle, {name}": _rolling(*three) for name, three in creepages.items()}
    for nu in (0.0, 0.5):
        scenes[f"circle, nu = {nu:g}, along and spin"] = _rolling(0.4, 0.0, 0.4, nu=nu)
        scenes[f"circle, nu = {nu:g}, across against spin"] = _rolling(0.1, -0.4, 0.7, nu=nu)
    return scenes


def _slender() -> dict[str, Scene]:
    scenes = {}
    for ratio in (0.1, 0.2, 0.5, 2.0, 5.0, 10.0):
        scenes[f"a/b = {ratio:g}, creepage"] = _rolling(0.4, 0.2, 0.1, ratio)
        scenes[f"a/b = {ratio:g}, spin"] = _rolling(0.1, 0.0, 1.0, ratio)
    for ratio, nu in ((0.3, 0.0), (3.0, 0.0), (0.3, 0.5), (3.0, 0.5)):
        scenes[f"a/b = {ratio:g}, nu = {nu:g}"] = _rolling(0.3, -0.3, 0.5, ratio, nu)
    scenes["a/b = 0.2, near full slip"] = _rolling(0.9, 0.3, 0.3, 0.2)
    surface = Paraboloids(Rx=0.6, Ry=1.2)
    scenes["paraboloids, creepage"] = replace(_rolling(0.3, -0.2, 0.5), surface=surface)
    scenes["a/b = 5, linear"] = _rolling(0.01, 0.02, 0.02, 5.0)
    return scenes


def _forces() -> dict[str, Scene]:
    unit = UNIT
    return {
        "Fx = 0.3": _base(motion=Steady(Fx=-0.3 * LIMIT)),
        "Fx = 0.6 with spin": _base(motion=Steady(Fx=-0.6 * LIMIT, spin=0.4 * unit)),
        "Fy = 0.5 with spin": _base(motion=Steady(Fy=0.5 * LIMIT, spin=0.5 * unit)),
        "Fx and Fy near saturation": _base(motion=Steady(Fx=-0.7 * LIMIT, Fy=0.65 * LIMIT)),
        "no lateral force, spin": _base(motion=Steady(vx=0.2 * unit, Fy=0.0, spin=0.8 * unit)),
        "a/b = 0.2, Fx = 0.5": _base(0.2, motion=Steady(Fx=-0.5 * LIMIT, vy=0.1 * SATURATION[0.2, NU])),
        "a/b = 5, Fx and Fy": _base(
            5.0, motion=Steady(Fx=0.5 * LIMIT, Fy=-0.3 * LIMIT, spin=0.1 * SATURATION[5.0, NU])
        ),
        "nu = 0, Fx = 0.8": _base(nu=0.0, motion=Steady(Fx=-0.8 * LIMIT)),
    }


def _shifts() -> dict[str, Scene]:
    full = 3 * (2 - NU) * LIMIT / 8  # Cattaneo's
    return {
        "shift, nu = 0, Fx = 0.5": _base(nu=0.0, motion=Shift(Fx=-0.5 * LIMIT)),
        "shift, nu = 0, a/b = 0.3, Fx = 0.7": _base(0.3, 0.0, Shift(Fx=-0.7 * LIMIT)),
        "shift, nu = 0, a/b = 4, Fy = 0.4": _base(4.0, 0.0, Shift(Fy=0.4 * LIMIT)),
        "shift along": _base(motion=Shift(ux=0.5 * full)),
        "shift and rotation": _base(motion=Shift(ux=0.2 * full, uy=0.3 * full, rotation=0.3 * full)),
        "rotation": _base(motion=Shift(rotation=0.5 * full)),
        "rotation, full slip": _base(motion=Shift(rotation=50.0 * full)),
        "shift, a/b = 3": _base(3.0, motion=Shift(ux=0.4 * full, uy=-0.3 * full, rotation=0.2 * full)),
        "shift, nu = 0.5, forces": _base(nu=0.5, motion=Shift(Fx=-0.5 * LIMIT, Fy=0.6 * LIMIT, rotation=0.2 * full)),
    }


def _normal() -> dict[str, Scene]:
    bodies = Bodies(G=1.0, nu=NU)
    scenes = {
        f"normal, Rx/Ry = {ratio:g}": Scene(
            bodies=bodies, surface=Paraboloids(Rx=math.sqrt(ratio), Ry=1 / math.sqrt(ratio)), normal_force=1.0
        )
        for ratio in (0.05, 0.4, 1.0, 8.0, 30.0)
    }
    scenes["normal, approach given"] = Scene(bodies=bodies, surface=Paraboloids(Rx=2.0, Ry=1.0), approach=0.5)
    for name, surface in _surfaces().items():
        scenes[f"normal, {name}"] = Scene(bodies=bodies, surface=surface, normal_force=1.0)
    return scenes


def _surfaces() -> dict[str, SampledDistance]:
    """Surfaces that are no paraboloids: at this load their contacts are about two wide."""
    x = y = np.linspace(-3.0, 3.0, 241)
    along = x[None, :] ** 2 / 1.2
    arcs = np.where(y < 0, y**2 / 2.4, y**2 / 0.8)[:, None]
    two = np.minimum((y - 0.9) ** 2 / 0.5, (y + 0.8) ** 2 / 0.4 + 0.05)[:, None]
    return {
        "two arcs": SampledDistance(along + arcs, x, y),
        "two patches": SampledDistance(along + two, x, y),
        "flat": SampledDistance((x[None, :] ** 2 + (y**2)[:, None]) ** 2 / 2, x, y),
        "egg": SampledDistance(along + (y**2 / 1.6 * (1 + 0.25 * y))[:, None], x, y),
        "sampled paraboloid": SampledDistance(along + (y**2 / 2.4)[:, None], x, y),
    }


def _non_hertzian() -> dict[str, Scene]:
    unit, surfaces = UNIT, _surfaces()
    motions: dict[str, Motion] = {
        "two arcs, creepage": Steady(vx=0.4 * unit, vy=0.1 * unit, spin=0.3 * unit),
        "two arcs, spin": Steady(spin=1.0 * unit),
        "two patches, creepage": Steady(vx=0.3 * unit, vy=-0.2 * unit),
        "two patches, spin": Steady(vx=-0.1 * unit, spin=0.6 * unit),
        "two patches, Fx = 0.5": Steady(Fx=-0.5 * LIMIT, vy=0.1 * unit),
        "flat, creepage and spin": Steady(vx=0.5 * unit, spin=0.4 * unit),
        "egg, near full slip": Steady(vx=0.8 * unit, vy=0.4 * unit, spin=0.1 * unit),
        "two patches, shift": Shift(ux=0.15, uy=0.05, rotation=0.05),
        "sampled paraboloid, creepage": Steady(vx=0.3 * unit, vy=-0.2 * unit, spin=0.5 * unit),
    }
    return {
        name: replace(_base(motion=motion), surface=surfaces[name.split(",")[0]]) for name, motion in motions.items()
    }


def _unlike() -> dict[str, Scene]:
    aluminium, rubber = Bodies(G=(1.0, 3.1), nu=(0.33, 0.28)), Bodies(G=(1.0, 20.0), nu=(0.1, 0.3))
    scenes: dict[str, tuple[Bodies, float, Motion]] = {
        "aluminium on steel, creepage and spin": (aluminium, 1.0, Steady(vx=0.1, vy=-0.03, spin=0.1)),
        "aluminium on steel, forces": (aluminium, 2.0, Steady(Fx=-0.6 * LIMIT, Fy=0.2 * LIMIT)),
        "aluminium on steel, shift": (aluminium, 0.5, Shift(ux=0.06, uy=0.03)),
        "soft on hard, creepage": (rubber, 1.0, Steady(vx=-0.05, vy=0.02)),
        "soft on hard, spin": (rubber, 0.5, Steady(spin=0.12)),
        "soft on hard, free rolling": (rubber, 1.0, Steady(Fx=0.0)),
    }
    return {
        name: replace(_base(ratio, motion=motion), bodies=bodies) for name, (bodies, ratio, motion) in scenes.items()
    }


def _line() -> dict[str, Scene]:
    """Cylinders with a contact two wide; Carter's creepage of full sliding is f a/R."""
    bodies, unlike = Bodies(G=1.0, nu=NU), Bodies(G=(1.0, 20.0), nu=(0.1, 0.3))
    R = math.pi / (4 * (1 - NU))
    full = FRICTION / R
    x = np.linspace(-3.0, 3.0, 481)
    bumps = SampledDistance(np.minimum((x - 0.8) ** 2 / 1.2, (x + 0.9) ** 2 / 1.0 + 0.05), x)
    known: dict[str, Any] = {"normal_force": 1.0, "friction": FRICTION}
    return {
        "line, normal": Scene(bodies=bodies, surface=Cylinders(R, reference_depth=50.0), normal_force=1.0),
        "line, two bumps": Scene(bodies=bodies, surface=bumps, normal_force=1.0),
        "line, creepage 0.3": Scene(bodies=bodies, surface=Cylinders(R), motion=Steady(vx=0.3 * full), **known),
        "line, creepage 0.9": Scene(bodies=bodies, surface=Cylinders(R), motion=Steady(vx=0.9 * full), **known),
        "line, Fx = 0.5": Scene(bodies=bodies, surface=Cylinders(R), motion=Steady(Fx=-0.5 * LIMIT), **known),
        "line, along and across": Scene(
            bodies=bodies, surface=Cylinders(R), motion=Steady(vx=0.4 * full, vy=0.3 * full), **known
        ),
        "line, two bumps, creepage": Scene(bodies=bodies, surface=bumps, motion=Steady(vx=0.3 * full), **known),
        "line, soft on hard": Scene(bodies=unlike, surface=Cylinders(R), motion=Steady(vx=-0.3 * full), **known),
    }


def _transient() -> dict[str, Scene]:
    """Steps of a given length, so that there is a continuum in space; from bodies without tractions."""
    unit, step = UNIT, 0.25
    load = [1.0 + 0.3 * math.sin(k * math.pi / 6) for k in range(12)]
    first = [0.0] + [step] * 11
    return {
        "from rest by creepage": _base(motion=Transient(steps=12, dq=step, vx=0.5 * unit)),
        "from rest by spin": _base(motion=Transient(steps=12, dq=step, vy=0.1 * unit, spin=0.6 * unit)),
        "from Cattaneo to Carter": _base(motion=Transient(steps=12, dq=first, Fx=-0.6 * LIMIT)),
        "creepage that turns": _base(
            motion=Transient(steps=12, dq=step, vx=[0.6 * unit] * 6 + [-0.6 * unit] * 6, vy=0.1 * unit)
        ),
        "load that swings": _base(motion=Transient(steps=12, dq=step, vx=0.3 * unit, normal_force=load)),
        "a/b = 3, from rest": _base(
            3.0,
            motion=Transient(
                steps=12, dq=step * math.sqrt(3), vx=0.3 * SATURATION[3.0, NU], spin=0.2 * SATURATION[3.0, NU]
            ),
        ),
    }
