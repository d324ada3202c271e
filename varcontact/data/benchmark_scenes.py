"""Scenes on which methods are compared, and scenes of all classes whose continuum values are kept as references."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from importlib.resources import files
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.io.scene_toml import scene_from
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, SampledDistance

FRICTION = 0.3
LIMIT = FRICTION
"""f Fz, with Fz = 1."""


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
            motions: list[tuple[str, Steady | Shift]] = [
                ("free rolling", Steady()),
                ("creepage and spin", Steady(vx=0.3 * unit, vy=-0.1 * unit, spin=0.3 * unit)),
                ("spin", Steady(spin=0.6 * unit)),
                ("force", Steady(Fx=-0.6 * f, vy=0.1 * unit)),
                ("shift", Shift(ux=0.2 * unit, uy=0.1 * unit, rotation=0.2 * unit)),
            ]
            name, motion = motions[k]
            bank[f"{pair}, {name}"] = Scene(
                bodies=bodies,
                surface=shapes[(i + 2 * k) % len(shapes)],
                normal_force=1.0,
                friction=f,
                motion=motion,
                grid=Grid(nx=cells, ny=cells),
            )
    return bank


def reference_scenes() -> dict[str, tuple[str, Scene]]:
    """The scenes of the references, without grids: class and scene by name."""
    text = files("varcontact.data").joinpath("reference_scenes.toml").read_text(encoding="utf-8")
    sampled, found = _sampled_surfaces(), {}
    for kind, tables in tomllib.loads(text).items():
        for name, table in tables.items():
            surface = table["surface"]
            made = scene_from(table | {"surface": sampled.get(surface["kind"], surface)})
            found[name] = kind, made
    return found


def _sampled_surfaces() -> dict[str, dict[str, Any]]:
    """Surfaces that are no paraboloids, as in scene files: at unit load their contacts are about two wide."""
    x = y = np.linspace(-3.0, 3.0, 241)
    along, across = x[None, :] ** 2 / 1.2, y[:, None]
    arcs = np.where(across < 0, across**2 / 2.4, across**2 / 0.8)
    two = np.minimum((across - 0.9) ** 2 / 0.5, (across + 0.8) ** 2 / 0.4 + 0.05)
    areas = {
        "two arcs": along + arcs,
        "two patches": along + two,
        "flat": (x[None, :] ** 2 + across**2) ** 2 / 2,
        "egg": along + across**2 / 1.6 * (1 + 0.25 * across),
        "sampled paraboloid": along + across**2 / 2.4,
    }
    places: dict[str, Any] = {"kind": "sampled-distance", "x": x}
    surfaces = {name: places | {"h": h, "y": y} for name, h in areas.items()}
    x = np.linspace(-3.0, 3.0, 481)
    bumps = np.minimum((x - 0.8) ** 2 / 1.2, (x + 0.9) ** 2 / 1.0 + 0.05)
    return surfaces | {"two bumps": places | {"h": bumps, "x": x}}
