"""Random methods for a scene: any that its plan allows and that is installed."""

from __future__ import annotations

from typing import Any

import numpy as np

import varcontact as vc
from varcontact.errors import SceneError, SolverUnavailable
from varcontact.solvers.registry import normal_methods, states_programs, tangential_methods
from varcontact.theories.on_grid import THEORIES

SLOW = ("cvxpy:",)
"""Rarely taken: a solve is more than ten times as long."""


def options(rng: np.random.Generator, scene: vc.Scene) -> dict[str, Any]:
    """Keywords of `solve`: in two cases of five those it has by itself, otherwise drawn until the plan takes them."""
    chosen: dict[str, Any] = {}
    if rng.random() < 0.6:
        for _ in range(10):
            drawn = _drawn(rng, scene)
            try:
                vc.plan(scene, **drawn)
            except (SceneError, SolverUnavailable):
                continue
            chosen = drawn
            break
    own = [name for name in ("normal", "tangential") if states_programs(chosen.get(name, ""))]
    if own and chosen.get("method") != "convex" and rng.random() < 0.4:
        chosen |= {"polish": False, "tol": 1e-5}
    if scene.under_law and not isinstance(scene.motion, vc.Transient) and rng.random() < 0.5:
        chosen["start"] = str(rng.choice(["stick", "slip"]))
    return chosen


def _drawn(rng: np.random.Generator, scene: vc.Scene) -> dict[str, Any]:
    """One road, or methods one by one."""
    drawn: dict[str, Any] = {}
    if rng.random() < 0.4:
        drawn["method"] = str(rng.choice(["convex", "active-set", "kalker"]))
        return drawn
    if scene.bodies.coupled and rng.random() < 0.5:
        drawn["coupling"] = str(rng.choice(["johnson", "panagiotopoulos", "joint"]))
    if rng.random() < 0.6:
        drawn["normal"] = _name(rng, normal_methods())
    if rng.random() < 0.8:
        theories = rng.random() < 0.25
        drawn["tangential"] = _name(rng, list(THEORIES) if theories else tangential_methods())
    if rng.random() < 0.3:
        drawn["formulation"] = str(rng.choice(["complementary", "potential", "gap", "marching"]))
    return drawn


def _name(rng: np.random.Generator, names: list[str]) -> str:
    """A method; a slow one rarely."""
    name = str(rng.choice(names))
    return str(rng.choice(names)) if name.startswith(SLOW) else name
