"""The standard bank: scenes on which methods are compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

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
    circle, long = Ellipse(a=1.0, b=1.0), float(np.sqrt(5))
    along, across = Ellipse(a=long, b=1 / long), Ellipse(a=1 / long, b=long)
    base = Scene(
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


def _two_arcs() -> SampledDistance:
    """A profile across the rolling direction of two arcs with a common tangent, round along it."""
    x, y = np.linspace(-2.5, 2.5, 101), np.linspace(-2.5, 2.5, 101)
    profile = np.where(y < 0, y**2 / 2.4, y**2 / 0.8)
    return SampledDistance(x[None, :] ** 2 / 1.2 + profile[:, None], x=x, y=y)
