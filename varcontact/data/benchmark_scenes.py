"""Scenes on which methods are compared, and scenes of all classes whose continuum values are kept
as references.
"""

from __future__ import annotations

import tomllib
from dataclasses import replace
from importlib.resources import files
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.io.scene_toml import scene_from
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene


@checks.named_options()
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
    return _on_grids("standard", cells)


@checks.named_options()
def unlike_bank(cells: int = 12) -> dict[str, Scene]:
    """Twenty scenes of unlike bodies by name, dimensionless: four pairs of
    bodies in five motions each.

    Friction is 0.1 to 0.9, the contact (without tractions) an ellipse with axes
    2 to 1, a circle, or one across.

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
    return _on_grids("unlike", cells)


def _on_grids(bank: str, cells: int) -> dict[str, Scene]:
    cells = checks.whole("cells", cells)
    scenes = _scenes("bank_scenes.toml")[bank]
    return {name: replace(scene, grid=Grid(nx=cells, ny=cells)) for name, scene in scenes.items()}


def reference_scenes() -> dict[str, tuple[str, Scene]]:
    """The scenes of the references, without grids: class and scene by name."""
    classes = _scenes("reference_scenes.toml")
    return {
        name: (kind, scene) for kind, scenes in classes.items() for name, scene in scenes.items()
    }


def _scenes(file: str) -> dict[str, dict[str, Scene]]:
    """Scenes of a file of this package by class and name; surfaces may also be sampled ones."""
    found = tomllib.loads(files("varcontact.data").joinpath(file).read_text(encoding="utf-8"))
    # surfaces other than paraboloids: under a unit load their contacts are about 2 wide
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
    sampled: dict[str, dict[str, Any]] = {
        name: {"h": h, "x": x, "y": y} for name, h in areas.items()
    }
    near = np.linspace(-2.5, 2.5, 101)
    arcs = np.where(near < 0, near**2 / 2.4, near**2 / 0.8)
    sampled["two arcs, near"] = {"h": near**2 / 1.2 + arcs[:, None], "x": near, "y": near}
    x = np.linspace(-3.0, 3.0, 481)
    sampled["two bumps"] = {
        "h": np.minimum((x - 0.8) ** 2 / 1.2, (x + 0.9) ** 2 / 1.0 + 0.05),
        "x": x,
    }
    for tables in found.values():
        for name, table in tables.items():
            surface = table["surface"]
            if surface["kind"] in sampled:
                surface = {"kind": "sampled-distance", **sampled[surface["kind"]]}
            tables[name] = scene_from(table | {"surface": surface})
    return found
