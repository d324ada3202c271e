"""Errors: what `accuracy=` keeps on random scenes, what discretisations leave, what solvers
reach.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

import varcontact as vc
from tests import steady_forces
from tests.benchmarks.table import Table, least
from tests.random_scenes import KINDS, scenes
from varcontact.data.benchmark_scenes import unlike_bank
from varcontact.results.quantities_of_interest import units, values

ACCURACIES = (0.1, 0.03, 0.01, 0.003)
CELLS, IN_LINE = (72, 108, 162), (454, 681, 1022)
"""Elements across on the grids that tell the continuum's values; of a history two thirds of
them."""
KNOWN = 1 / 3
"""A scene counts for an accuracy if its continuum's values are known to this part of it."""
SEED = 501


@dataclass(frozen=True)
class Exact:
    """Values of a scene in the continuum, what an error of one is, and the largest error of the
    values.
    """

    values: dict[str, float]
    units: dict[str, float]
    known: float


def exact(scene: vc.Scene) -> Exact:
    """From three grids by their order, second-order differences where it rolls."""
    moves = isinstance(scene.motion, vc.Transient)
    start = "slip" if scene.under_law and not moves else None
    cells = (
        np.array(IN_LINE if scene.line else CELLS) * 2 // 3
        if moves
        else np.array(IN_LINE if scene.line else CELLS)
    )
    answers = [vc.solve(on(scene, int(n)), certify="none", start=start) for n in cells]
    per = units(answers[-1])
    found = np.array([[values(each)[name] for name in per] for each in answers])
    steps = np.diff(found, axis=0) / ((cells[1:] / cells[:-1]) ** 1.5 - 1)[:, None]
    best = found[-1] + steps[-1] / 2
    known = np.max(np.abs(steps[-1]) / 2 / np.array(list(per.values())), initial=0.0)
    return Exact(dict(zip(per, best, strict=True)), per, float(known))


def on(scene: vc.Scene, n: int) -> vc.Scene:
    """A scene on a grid with so many elements across the contact."""
    hertz, rolls = (
        scene.hertz is not None and scene.bodies.K == 0,
        isinstance(scene.motion, vc.Steady),
    )
    edge = "touched" if hertz and not scene.frictionless and not scene.line else "centres"
    grid = (
        vc.Grid(nx=n) if scene.line else vc.Grid(nx=round(1.5 * n) if rolls else n, ny=n, edge=edge)
    )
    gridded = replace(scene, grid=grid)
    return gridded.second_order() if rolls else gridded


def tried(scene: vc.Scene) -> list[dict[str, float]]:
    """Error and estimate for each accuracy, in which the continuum's values are known."""
    truth, rows = exact(scene), []
    for accuracy in ACCURACIES:
        answer = vc.solve(scene, accuracy=accuracy)
        found = values(answer)
        error = (
            max(
                abs(found[name] - value) / truth.units[name] for name, value in truth.values.items()
            )
            - truth.known
        )
        estimate = answer.error_estimate.largest
        rows.append(
            {
                "accuracy": accuracy,
                "known": truth.known,
                "estimate": estimate,
                "error": max(error, 0.0),
            }
        )
    return rows


def kept_accuracies(rows: list[dict[str, float]]) -> Table:
    """Of all errors, how many are above the accuracy or their own error bar, and the largest, by
    accuracy.
    """
    chosen = [
        [row for row in rows if row["accuracy"] == A and row["known"] < KNOWN * A]
        for A in ACCURACIES
    ]
    ratios = [[row["error"] / row["accuracy"] for row in each] for each in chosen]
    lines = [
        ["scenes", *map(len, chosen)],
        ["errors above the accuracy", *(sum(ratio > 1 for ratio in each) for each in ratios)],
        [
            "errors above their error bar",
            *(sum(r["error"] > r["estimate"] for r in each) for each in chosen),
        ],
        ["median error, relative to the accuracy", *(float(np.median(each)) for each in ratios)],
        ["largest error, relative to the accuracy", *map(max, ratios)],
    ]
    return Table(["accuracy", *(f"{A:g}" for A in ACCURACIES)], ["", *(4 * [".2g"])], lines)


def random(quick: bool) -> Table:
    """What `accuracy=` keeps on random scenes of each kind, whose continuum values come from finer
    grids.
    """
    count, rows = 1 if quick else 8, []
    for kind in KINDS:
        for i, scene in enumerate(scenes(kind, count, SEED)):
            try:
                rows += tried(scene)
            except vc.VarcontactError as error:
                print(f"{kind} {i}: {type(error).__name__}: {error}", flush=True)
    table = kept_accuracies(rows)
    return replace(table, measured={"seed": SEED, "scenes of each kind": count})


def spread(errors: object, unit: float = 1.0) -> list[float]:
    """Median, nine in ten, largest."""
    return [float(each) / unit for each in np.quantile(np.asarray(errors), [0.5, 0.9, 1.0])]


def second_order(quick: bool) -> Table:
    """Errors of steady forces on coarse grids, by discretisation, alone and extrapolated, in per
    cent.
    """
    known = steady_forces.read()[:: 8 if quick else 1]
    truth, cells, rows = np.array([forces for _, forces in known]), (12, 16, 24, 32, 48), []
    for name, second, order in (("by default", False, 1), ("second order, n x n", True, 2)):
        found = {}
        for n in sorted({*cells, *(each // 2 for each in cells)}):
            posed = [steady_forces.scene(numbers, n) for numbers, _ in known]
            found[n] = np.array(
                [steady_forces.forces(p.second_order() if second else p, tol=1e-4) for p in posed]
            )
        limits = {n: found[n] + (found[n] - found[n // 2]) / (2**order - 1) for n in cells}
        for words, answers in ((name, found), (f"the same, from n/2 and n, order {order}", limits)):
            rows.append(
                [words, *(spread(100 * np.abs(answers[n] - truth).max(axis=1)) for n in cells)]
            )
    return Table(["cells", *map(str, cells)], ["", *(5 * ["{:.2f}/{:.2f}/{:.2f}"])], rows)


FOUR = ("pure vx", "vx, vy and spin", "unlike bodies", "soft on rigid, creepage and spin")
"""Scenes of the two banks, like bodies and unlike ones."""


def conic(quick: bool) -> Table:
    """Residuals of Clarabel alone and of `conic`, and processor seconds of `conic` and of
    `active-set`.
    """
    bank = vc.standard_bank(12) | unlike_bank(12)
    rows = []
    for name in FOUR[:2] if quick else FOUR:
        scene = bank[name]
        exact_one = vc.solve(scene, method="active-set")
        try:
            raw = vc.solve(
                scene,
                "auto" if exact_one.plan.normal == "hertz" else "clarabel",
                "clarabel",
                polish=False,
            )
        except vc.NotConverged as failure:
            raw = failure.solution or exact_one
        seconds = [
            least(partial(vc.solve, scene, method=each), 2) for each in ("conic", "active-set")
        ]
        residuals = raw.certificate.residual, vc.solve(scene, method="conic").certificate.residual
        rows.append([name, *residuals, seconds])
    head = ["scene", "Clarabel alone", "`conic`", "seconds: `conic`, `active-set`"]
    return Table(head, ["", ".0e", ".0e", "{:.2g}, {:.2g}"], rows)


def steps(quick: bool) -> Table:
    """Residuals of Clarabel's own tractions of the scenes of both banks, to 1e-12, by the part of
    the way to the boundary of the cones that a step may go.
    """
    import clarabel

    bank = vc.standard_bank(12) | unlike_bank(12)
    programs = [_tangential(bank[name]) for name in (FOUR if quick else bank)]
    rows = []
    for fraction in (0.99, 0.75):
        options = clarabel.DefaultSettings()
        options.verbose = False
        options.max_threads = 1
        options.max_step_fraction = fraction
        options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = 1e-12
        residuals = []
        for each in programs:
            answer = clarabel.DefaultSolver(*each.to("clarabel"), options).solve()
            residuals.append(each.solution(answer.x, answer.z).certificate.tangential_residual)
        below = sum(residual <= 1e-8 for residual in residuals)
        median = float(np.median(residuals))
        rows.append([str(fraction), f"{below} of {len(programs)}", median, max(residuals)])
    head = ["`max_step_fraction`", "below 1e-8", "median residual", "largest"]
    return Table(head, ["", "", ".0e", ".0e"], rows)


def _tangential(scene: vc.Scene) -> vc.Program:
    """The program of the tractions under the pressure without them."""
    pressed = vc.solve(scene.without_friction, certify="none", tol=1e-12)
    return vc.program(replace(scene, grid=pressed.grid), "tangential", pressure=pressed.pressure)


TABLES = {"random": random, "second_order": second_order, "conic": conic, "steps": steps}
