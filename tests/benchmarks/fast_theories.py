"""Speed and error of the fast theories: ``python -m tests.benchmarks.fast_theories``.

Speed: triples a second in a call of 100 000, and the time of a single call, on one core. Error: against the continuum
values of `references`, of every steady scene of like bodies on an ellipse with given creepages.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

import varcontact as vc
from varcontact.scene.motion import Steady
from varcontact.scene.surfaces import Ellipse
from varcontact.theories.creep_forces import VECTORISED
from varcontact.theories.table import why_not_in_book

TRIPLES = 100_000
CONTACT = {"a": 6e-3, "b": 4e-3, "G": 82e9, "nu": 0.28, "normal_force": 1e5, "friction": 0.3}
UNIT = 1e-3 * np.array([[3.2], [3.5], [650.0]])
"""Of vx, vy and spin; about 3 f Fz/(G ab C11), by the contact's size."""


def best(call: Callable[[], object], repeats: int = 7) -> float:
    """The least of several times, as other work on the machine only adds to it."""
    seconds = []
    for _ in range(repeats):
        begun = time.perf_counter()
        call()
        seconds.append(time.perf_counter() - begun)
    return min(seconds)


def speeds() -> dict[str, tuple[float, float]]:
    """Triples a second in one call, and seconds of a single one, by theory."""
    vx, vy, spin = np.random.default_rng(0).normal(size=(3, TRIPLES)) * UNIT
    found = {}
    for name in VECTORISED:
        turns = name != "vermeulen-johnson"
        many = {"vx": vx, "vy": vy, "spin": spin if turns else 0.0}
        one = {"vx": 1e-3, "vy": 2e-4, "spin": 0.1 if turns else 0.0}
        in_one_call = best(lambda name=name, many=many: vc.creep_forces(name, **CONTACT, **many))
        single = best(lambda name=name, one=one: [vc.creep_forces(name, **CONTACT, **one) for _ in range(20)]) / 20
        found[name] = TRIPLES / in_one_call, single
    return found


def errors() -> dict[str, np.ndarray]:
    """By theory, rows of the largest error of Fx and Fy by f Fz, and that of Mz by f Fz (ab)^(1/2)."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in VECTORISED}
    for reference in vc.references().values():
        scene = reference.scene
        motion, surface = scene.motion, scene.surface
        if not (isinstance(motion, Steady) and isinstance(surface, Ellipse) and scene.bodies.K == 0):
            continue
        if motion.Fx is not None or motion.Fy is not None or not isinstance(scene.friction, float):
            continue
        limit = scene.friction * scene.normal_force
        for name in VECTORISED:
            if name == "vermeulen-johnson" and motion.spin != 0:
                continue
            if name == "table" and why_not_in_book(surface.a / surface.b, scene.bodies.combined_nu):
                continue
            forces = vc.creep_forces(
                name, a=surface.a, b=surface.b, bodies=scene.bodies, normal_force=scene.normal_force,
                friction=scene.friction, vx=motion.vx, vy=motion.vy, spin=motion.spin,
            )  # fmt: skip
            exact = reference.values
            away = max(abs(forces.Fx - exact["Fx"]), abs(forces.Fy - exact["Fy"])) / limit
            found[name].append((away, abs(forces.Mz - exact["Mz"]) / limit / (surface.a * surface.b) ** 0.5))
    return {name: np.array(rows) for name, rows in found.items()}


def main() -> None:
    """Print both tables."""
    print(f"{'theory':28}{'triples/s':>12}{'single, us':>12}")
    for name, (rate, single) in speeds().items():
        print(f"{name:28}{rate:12.2g}{1e6 * single:12.0f}")
    print(f"\n{'theory':28}{'scenes':>8}{'force, median':>15}{'90 %':>8}{'max':>8}{'moment, median':>16}{'max':>8}")
    for name, rows in errors().items():
        force, moment = 100 * rows.T
        figures = [np.median(force), np.quantile(force, 0.9), force.max()]
        words = "".join(f"{figure:{width}.1f}" for figure, width in zip(figures, (15, 8, 8), strict=True))
        print(f"{name:28}{len(rows):8}{words}{np.median(moment):16.1f}{moment.max():8.1f}")


if __name__ == "__main__":
    main()
