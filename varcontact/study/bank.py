"""The standard bank: scenes on which methods are compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact import checks
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, SampledDistance

FRICTION, FORCE = 0.3, 1.0


def standard_bank(cells: int = 12) -> dict[str, Scene]:
    """Fourteen scenes by name, dimensionless (G = 1, Fz = 1), from easy to hard.

    Parameters
    ----------
    cells : int
        Elements across the contact either way.

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
        normal_force=FORCE,
        friction=FRICTION,
        motion=Steady(vx=0.1),
        grid=Grid(nx=cells, ny=cells),
    )
    limit = FRICTION * FORCE
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
        "Fx prescribed": (circle, Steady(Fx=-0.6 * limit, vy=0.03, spin=0.1)),
        "Fx and Fy near saturation": (circle, Steady(Fx=-0.7 * limit, Fy=0.7 * limit)),
    }
    bank = {name: replace(base, surface=surface, motion=motion) for name, (surface, motion) in steady.items()}
    bank["shift with rotation"] = replace(base, motion=Shift(ux=0.05, uy=0.02, rotation=0.08))
    bank["two arcs"] = replace(base, surface=_two_arcs(), motion=Steady(vx=0.06, vy=0.02, spin=0.1))
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
        Elements across the contact either way.

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
        for k, motion in enumerate(("free rolling", "creepage and spin", "spin", "force", "shift")):
            f = frictions[(i + k) % len(frictions)]
            bank[f"{pair}, {motion}"] = Scene(
                bodies=bodies,
                surface=shapes[(i + 2 * k) % len(shapes)],
                normal_force=FORCE,
                friction=f,
                motion=_moved(motion, f * FORCE, f * FORCE / bodies.combined_G),
                grid=Grid(nx=cells, ny=cells),
            )
    return bank


def _moved(motion: str, limit: float, unit: float) -> Steady | Shift:
    """Motions with stick and slip; a creepage (or shift) of about one unit is full slip."""
    motions: dict[str, Steady | Shift] = {
        "free rolling": Steady(),
        "creepage and spin": Steady(vx=0.3 * unit, vy=-0.1 * unit, spin=0.3 * unit),
        "spin": Steady(spin=0.6 * unit),
        "force": Steady(Fx=-0.6 * limit, vy=0.1 * unit),
        "shift": Shift(ux=0.2 * unit, uy=0.1 * unit, rotation=0.2 * unit),
    }
    return motions[motion]


def _two_arcs() -> SampledDistance:
    """A profile across the rolling direction of two arcs with a common tangent, round along it."""
    x, y = np.linspace(-2.5, 2.5, 101), np.linspace(-2.5, 2.5, 101)
    profile = np.where(y < 0, y**2 / 2.4, y**2 / 0.8)
    return SampledDistance(x[None, :] ** 2 / 1.2 + profile[:, None], x=x, y=y)
