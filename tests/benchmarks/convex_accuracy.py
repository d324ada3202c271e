"""What conic solvers reach: the residuals of Clarabel's own answers by its settings, and of the method "convex".

Run: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 RAYON_NUM_THREADS=1 python tests/benchmarks/convex_accuracy.py [cells]

First Clarabel alone on the tangential problems of the standard bank and of the bank of unlike bodies, for several
settings; then the scenes themselves: the solvers as named, without any polish, and by method="convex", beside
method="active-set".
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator

import numpy as np

import varcontact as vc
from varcontact.data.benchmark_scenes import unlike_bank
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import RawSolution, TangentialProblem, mirror_of
from varcontact.discrete.residuals import tangential_residual
from varcontact.solvers.conic.programs import gap_program, shift_program
from varcontact.solvers.splitting import ROUNDS, Splitting

SETTINGS = [(0.99, 1e-11), (0.99, 1e-12), (0.9, 1e-12), (0.8, 1e-12), (0.75, 1e-12), (0.7, 1e-12), (0.75, 1e-13)]
"""Part of the way to the boundary that a step goes (`max_step_fraction`, by default 0.99), and tolerance asked for."""


def scenes(cells: int) -> dict[str, vc.Scene]:
    """Both banks."""
    return vc.standard_bank(cells) | unlike_bank(cells)


def problems(cells: int) -> Iterator[TangentialProblem]:
    """The tangential problems at the solutions, as solvers meet them."""
    for scene in scenes(cells).values():
        sol = vc.solve(scene)
        disc = discretise(scene, sol.grid)
        problem = disc.tangential_problem(
            sol.pressure / disc.scales.pressure, acting=sol.traction / disc.scales.pressure
        )
        mirror = mirror_of(problem)
        yield problem if mirror is None else mirror.fold(problem)


def by_clarabel(problem: TangentialProblem, **settings: object) -> RawSolution:
    """Clarabel's own answer with any settings."""
    import clarabel

    program = (shift_program if problem.symmetric else gap_program)(problem)
    options = clarabel.DefaultSettings()
    known = {"verbose": False, "presolve_enable": False, "direct_solve_method": "faer"}
    for name, value in (known | settings).items():
        setattr(options, name, value)
    kinds = {"zero": clarabel.ZeroConeT, "second_order": clarabel.SecondOrderConeT}
    cones = [kinds[kind](size) for kind, size in program.cones]
    result = clarabel.DefaultSolver(program.P, program.q, program.A, program.b, cones, options).solve()
    answer = program.recover(np.array(result.x), np.array(result.z))
    return RawSolution(*answer, result.iterations, str(result.status))


def rounds_from(problem: TangentialProblem, start: RawSolution, enough: float = 1e-10) -> int:
    """Rounds of splitting from an answer to a residual."""
    splitting, shape = Splitting.of_tangential(problem), problem.rigid_shift.shape
    at = (start.traction - problem.shift(start.traction, start.rigid) / splitting.weight).ravel()
    rigid = np.zeros(problem.components)
    for rounds in range(ROUNDS, 5000, ROUNDS):
        at, rigid[problem.free] = splitting.moved(at, ROUNDS)
        if tangential_residual(problem, splitting.project(at).reshape(shape), rigid) <= enough:
            return rounds
    return 5000


def by_settings(cells: int) -> None:
    """One line for each setting."""
    posed = list(problems(cells))
    print("| max_step_fraction, tolerance | rolling: median, largest residual | shift | iterations | 1e-8 reached |")
    print("|---|---|---|---|---|")
    for step, tol in SETTINGS:
        asked = {"max_step_fraction": step, "tol_gap_abs": tol, "tol_gap_rel": tol, "tol_feas": tol}
        answers = [by_clarabel(problem, **asked) for problem in posed]
        found = [tangential_residual(p, a.traction, a.rigid) for p, a in zip(posed, answers, strict=True)]
        kinds = [[r for p, r in zip(posed, found, strict=True) if p.symmetric == kind] for kind in (False, True)]
        spread = [f"{np.median(errors):.0e}, {max(errors):.0e}" for errors in kinds]
        steps, solved = np.mean([answer.iterations for answer in answers]), np.sum(np.array(found) <= 1e-8)
        print(f"| {step}, {tol:.0e} | {' | '.join(spread)} | {steps:.0f} | {solved} of {len(found)} |")
    for words, tol in (("Clarabel's answer for 1e-6 in the tractions", 1e-9), ("nothing", None)):
        starts = [
            RawSolution(np.zeros_like(p.rigid_shift), np.zeros(p.components), 0, "")
            if tol is None
            else by_clarabel(p, tol_gap_abs=tol, tol_gap_rel=tol, tol_feas=tol)
            for p in posed
        ]
        rounds = [rounds_from(p, start) for p, start in zip(posed, starts, strict=True)]
        print(f"Rounds of splitting to 1e-10 from {words}: median {np.median(rounds):.0f}, at most {max(rounds)}.")


def timed(scene: vc.Scene, method: str) -> tuple[vc.Solution, float]:
    """A solution, and its processor seconds: the less of two runs."""
    seconds = []
    for _ in range(2):
        begun = time.process_time()
        sol = vc.solve(scene, method=method)
        seconds.append(time.process_time() - begun)
    return sol, min(seconds)


def by_scene(cells: int) -> None:
    """One line for each scene."""
    print("| scene | elements | Clarabel alone | `convex` | passes | calls of Clarabel | rounds | forces | seconds |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name, scene in scenes(cells).items():
        exact, quick = timed(scene, "active-set")
        normal = "auto" if exact.plan.normal == "hertz" else "clarabel"
        try:
            raw = vc.solve(scene, normal, "clarabel", polish=False)
        except vc.NotConverged as failure:
            raw = failure.solution or exact
        sol, long = timed(scene, "convex")
        limit = float(exact.traction_bound.sum() * exact.grid.area)
        away = float(np.hypot(*(sol.force - exact.force))) / limit
        count = sum(each["clarabel"].count for each in sol.calls.values() if "clarabel" in each)
        rounds = sum(each["splitting"].iterations for each in sol.calls.values() if "splitting" in each)
        print(
            f"| {name} | {sol.elements['contact']} | {raw.certificate.residual:.0e} | {sol.certificate.residual:.0e} | "
            f"{len(sol.passes) or 1} | {count} | {rounds} | {away:.0e} | {long:.2g}, {quick:.2g} |",
            flush=True,
        )


def main(cells: int = 12) -> None:
    """Both tables."""
    by_settings(cells)
    by_scene(cells)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
