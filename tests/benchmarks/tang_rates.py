"""How often the kinds of TANG solve a problem, and in how many Newton steps: random scenes, the same for all.

Run: python tests/benchmarks/tang_rates.py [cells] [scenes]

Rolling and shifts, by creepages or by one or both forces (a tenth to 95 % of what friction carries), under Hertz's
pressure with axes a/b from 0.37 to 2.7. All start from nothing; solved means a residual below 1e-9.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator

import numpy as np

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import TangentialProblem
from varcontact.discrete.residuals import tangential_residual
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.interface import Settings
from varcontact.solvers.registry import tangential_solver

METHODS = ("tang-exact", "tang", "tang-safeguarded")
FRICTION = 0.3


def random_motion(random: np.random.Generator) -> vc.Steady | vc.Shift:
    """One of the four kinds, from no slip to nearly full slip."""
    kind = random.integers(4)
    x, y, turn = random.normal(size=3) * [0.1, 0.1, 0.3]
    angle, part = random.uniform(0, 2 * np.pi), random.uniform(0.1, 0.95)
    Fx, Fy = part * FRICTION * np.cos(angle), part * FRICTION * np.sin(angle)
    if kind == 0:
        return vc.Steady(vx=x, vy=y, spin=turn)
    if kind == 1:
        return vc.Shift(ux=x, uy=y, rotation=turn)
    if kind == 2:
        return vc.Steady(Fx=Fx, vy=y, spin=turn)
    return vc.Steady(Fx=Fx, Fy=Fy, spin=turn / 3)


def problems(count: int, cells: int) -> Iterator[TangentialProblem]:
    """Tangential problems on the elements of an ellipse of area pi."""
    random = np.random.default_rng(0)
    for _ in range(count):
        a = float(np.exp(random.uniform(-0.5, 0.5)))
        scene = vc.Scene(
            bodies=vc.Bodies(G=1.0, nu=0.28),
            surface=vc.Ellipse(a=a, b=1 / a),
            normal_force=1.0,
            friction=FRICTION,
            motion=random_motion(random),
        )
        grid = vc.Grid(nx=cells, ny=cells).spread((-a, a, -1 / a, 1 / a))
        disc = discretise(scene, grid)
        yield disc.tangential_problem(hertz_pressure(disc, unloaded(grid)).pressure)


def main(cells: int = 12, count: int = 150) -> None:
    """One line for each kind."""
    posed = list(problems(count, cells))
    unknowns = [len(problem.operator.matrix) for problem in posed]  # assembled before the clock starts
    print(f"{count} scenes, {cells} elements across, {posed[0].size} in contact, {unknowns[0]} unknowns")
    for name in METHODS:
        begun = time.perf_counter()
        answers = [tangential_solver(name)(problem, Settings(), None) for problem in posed]
        seconds = time.perf_counter() - begun
        residuals = [tangential_residual(p, a.traction, a.rigid) for p, a in zip(posed, answers, strict=True)]
        steps = np.array([answer.iterations for answer in answers])
        print(
            f"{name:<18}{sum(residual < 1e-9 for residual in residuals):4d} solved, Newton steps: median "
            f"{np.median(steps):.0f}, 90 % below {np.quantile(steps, 0.9):.0f}, all {steps.sum()}; {seconds:.1f} s"
        )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
