"""Solutions to an accuracy, or within a time: finer and finer grids until the
estimated error is small enough.

One rule for every scene. Grids have 6, 9, 14, 21, ... elements across the
contact (line contact begins with 48). The last three tell the error:
Richardson's steps ``s = (v_fine - v_coarse)/((n_fine/n_coarse)^1.5 - 1)`` of
the two pairs, as they stand on the finest grid, give
``1.25 max |s| + 0.4 n^-1.5``, and the value is that of the finest grid plus
half its step. With unlike bodies the error falls like ``|K|/n`` in the end, which
coarse grids do not show: it is added. Where the estimate does not fall over two
grids, finer ones are of no use. ``python -m tests.benchmarks accuracy random``
measures on random scenes what this keeps, ``bars`` on wheels.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from varcontact.discrete.contact_grid import given_grid
from varcontact.errors import NotConverged, SceneError, TooCoarse, TooLarge
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import creepage_names, friction_limit, units, values
from varcontact.results.solution import Solution
from varcontact.scene.bodies import BodyPair
from varcontact.scene.grid import Edge, Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import OutOfTime
from varcontact.solving.history import bytes_of_steps, solve_transient
from varcontact.solving.on_grid import solve_on_grid
from varcontact.solving.options import BY_DEFAULT, SolveOptions, Target
from varcontact.solving.pipeline import peak
from varcontact.system import process
from varcontact.system.process import one_blas_thread

FIRST, FIRST_IN_LINE = 6, 48
"""Elements across the contact on the coarsest grid."""
RATIO, GRIDS = 1.5, 3
"""Elements across on a grid by those on the one before; how many grids tell an error."""
ORDER, SAFETY, FLOOR, PART = 1.5, 1.25, 0.4, 0.5
"""The error is ``SAFETY max |s| + FLOOR n^-ORDER``, for the largest pressure with the n across the
patch that has it; of Richardson's step s of that order, where a layer hardens of the first, a
`PART` is taken."""
FLOOR_UNLIKE = 1.0
"""Of unlike bodies the floor of forces and moment has ``FLOOR_UNLIKE |K|/n`` on top."""
FLOOR_PART = 0.5
"""Part of the accuracy that the floor takes on the third grid."""
NARROWEST = 4.0
"""Elements across the narrowest patch that carries load, on the coarsest grid that tells an
error."""
GROWTH, LATE, COARSEST = 2.4, 1.3, 2.0
"""Power of n with which a solve takes longer; after so many time budgets a solve is given up, one
of the coarsest grids so many seconds later."""
STALLED = 0.9
"""Part of an estimate that both estimates after it exceed where the error does not fall with the
grid."""
DOES_NOT_FALL = "it does not fall with the grid"
MOST_BY_DEFAULT = 40_000
"""Elements, where no accuracy is given: an answer that needs more has a larger error bar."""
SHOWN = 25
"""Elements across a contact in closed form: an odd number has one at the largest pressure."""

Answer = Solution | History


@dataclass(frozen=True)
class Patch:
    """A part of the contact apart from the others: how narrow it is, in elements, and its part of
    the load.
    """

    across: float
    share: float
    peak: bool  # whether it has the largest pressure


@dataclass(frozen=True)
class GridLevel:
    """The answer on a grid with `n` elements across the contact, and the values that errors are
    measured in.

    `unjudged`: values that have an error bar, but do not count for the accuracy.
    """

    n: int
    answer: Answer
    values: dict[str, float]
    seconds: float
    patches: tuple[Patch, ...]
    unjudged: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, n: int, answer: Answer, seconds: float, target: Target) -> GridLevel:
        """Of a history the patches are those of the step with the largest contact."""
        judged = values(answer)
        unjudged = {}
        largest = (
            max(answer, key=lambda sol: sol.areas["contact"])
            if isinstance(answer, History)
            else answer
        )
        if isinstance(answer, Solution) and not answer.plan.closed_form and answer.pressure.any():
            unjudged = {"peak_pressure": answer.max_pressure}
        if target.of_pressure:
            unjudged = {name: value for name, value in unjudged.items() if name not in judged}
        judged = {name: value for name, value in judged.items() if name not in unjudged}
        return cls(n, answer, judged, seconds, _patches(largest), unjudged)

    def unresolved(self, accuracy: float | None) -> list[Patch]:
        """Patches with few elements across that carry a part of the load, the `accuracy`, or a peak
        that counts.
        """
        least = BY_DEFAULT if accuracy is None else accuracy
        narrow = (each for each in self.patches if each.across < NARROWEST)
        return [
            each
            for each in narrow
            if each.share > least or (each.peak and "peak_pressure" in self.values)
        ]


@one_blas_thread()
def solve(scene: Scene, options: SolveOptions) -> Answer:
    """A scene without a grid of its own, solved to an accuracy or within a time, on the finest grid
    that it took.

    `NotConverged`, with the best answer, if the accuracy is not reached: a finer grid does not fit
    into memory, or a solver misses its tolerance there. A `SceneError` if a history is not solved
    in time on the coarsest grids.
    """
    target = options.target
    started = time.perf_counter()
    assert target is not None
    if options.plan.closed_form and not options.plan.has_friction:
        return _closed_form(scene, options)
    budget = math.inf if target.time_budget is None else target.time_budget
    levels: list[GridLevel] = []
    estimates: list[ErrorEstimate] = []
    n = _first(scene, options, target)
    while True:
        deadline = started + LATE * budget + (COARSEST if len(levels) < GRIDS else 0.0)
        try:
            levels.append(_level(scene, options, n, levels, deadline))
        except (OutOfTime, NotConverged) as error:
            if estimates:
                return _not_reached(
                    levels, target, f"the next grid, of {n} elements across, fails: {error}", error
                )
            if isinstance(error, NotConverged):
                raise
            allowed = "more seconds, or an accuracy: even the coarsest grids, which tell the error, take longer"
            raise SceneError("time_budget", budget, allowed) from None
        last = levels[-1]
        few = len(levels) < GRIDS
        if not few:
            estimates.append(estimated(levels, target))
            if target.accuracy is not None and estimates[-1].largest <= target.accuracy:
                return with_values(last.answer, estimates[-1])
            if stalled(estimates):
                return _not_reached(levels, target, DOES_NOT_FALL)
            if len(estimates) == 1 and isinstance(last.answer, Solution):
                # as of noise: before time is spent on finer grids
                for words in last.answer.warnings:
                    options.progress(words)
        n = _next(scene, options, last, few)
        fits = _fits(scene, options, n)
        if few and (fits or not target.by_default or len(levels) == 1):
            continue
        late = last.seconds * (n / last.n) ** GROWTH > budget - (time.perf_counter() - started)
        if late or not fits:
            return _not_reached(
                levels, target, f"a grid of {n} elements across does not fit into memory"
            )


def stalled(estimates: Sequence[ErrorEstimate]) -> bool:
    """Whether neither of the last two errors is below the one before them."""
    if len(estimates) < GRIDS:
        return False
    before, *last = (each.largest for each in estimates[-GRIDS:])
    return min(last) > STALLED * before


def gridded(scene: Scene, closed_form: bool, n: int) -> Scene:
    """The scene on the grid with `n` elements across the contact, with the discretisation of its
    kind.

    Rolling takes differences of the second order, but of layers that harden, and more elements
    along x; under Hertz's pressure elements at the contact's edge count in part.
    """
    motion = scene.motion
    rolls = isinstance(scene.motion, Steady)
    edge: Edge = "centres"
    if closed_form and motion is not None and (rolls or not scene.line):
        edge = "softened" if rolls and not scene.hardens else "touched"
    grid = (
        Grid(nx=n, edge=edge)
        if scene.line
        else Grid(nx=round(RATIO * n) if rolls else n, ny=n, edge=edge)
    )
    second_order = isinstance(motion, Steady) and not scene.hardens
    return replace(scene, grid=grid, motion=motion.second_order() if second_order else motion)


def richardson(
    values: Sequence[Any], across: Sequence[int], order: float = ORDER
) -> tuple[Any, Any]:
    """The best value and its error, but for the floor, by Richardson's steps between the last
    grids, three or two.
    """
    parts = [1 / ((fine / coarse) ** order - 1) for coarse, fine in pairwise(across)]
    steps = [
        (fine - coarse) * part for (coarse, fine), part in zip(pairwise(values), parts, strict=True)
    ]
    before = (across[-2] / across[-1]) ** order * np.abs(steps[0])
    return values[-1] + PART * steps[-1], SAFETY * np.maximum(np.abs(steps[-1]), before)


def estimated(levels: list[GridLevel], target: Target) -> ErrorEstimate:
    """The values of the last grids, extrapolated, with their errors.

    A patch that is too narrow on the coarsest of them adds its part of the load, or of the peak, by
    its elements.
    """
    first, *_, fine = tried = levels[-GRIDS:]
    per = units(fine.answer) | fine.unjudged
    order = 1.0 if fine.answer.scene.hardens else ORDER
    narrow = first.unresolved(target.accuracy)
    across_peak = next((each.across for each in fine.patches if each.peak), fine.n)
    found = [level.values | level.unjudged for level in tried]
    best = dict(found[-1])
    errors = {}
    for name in (name for name in found[-1] if name in found[-2]):
        known = [k for k, level in enumerate(found) if name in level]
        value, error = richardson(
            [found[k][name] for k in known], [tried[k].n for k in known], order
        )
        of_peak = name == "peak_pressure"
        floor = FLOOR * (min(across_peak, fine.n) if of_peak else fine.n) ** -ORDER
        if not of_peak:
            floor += FLOOR_UNLIKE * _unlikeness(fine.answer.scene) / fine.n
        missed = sum(
            (1.0 if of_peak and each.peak else each.share) / each.across for each in narrow
        )
        best[name] = float(value)
        errors[name] = float(error) / per[name] + floor + missed
    bars = {name: error * per[name] for name, error in errors.items()}
    *coarser, finest = (f"{level.n:.0f}" for level in tried)
    grids = f"{', '.join(coarser)} and {finest} elements across the contact"
    how = f"by Richardson's steps of order {order:g} between grids of {grids}"
    if narrow:
        how += f"; the narrowest patch has {min(each.across for each in narrow):.2g} elements on the first of them"
    solves = tuple(
        Solve(level.answer.grid.nx, level.answer.grid.rows, level.seconds) for level in levels
    )
    judged = {name: error for name, error in errors.items() if name in fine.values}
    on_grid = fine.values | fine.unjudged
    return ErrorEstimate(
        best, judged, how, solves, target.accuracy, target.time_budget, on_grid, bars
    )


def _unlikeness(scene: Scene) -> float:
    """|K| of the materials at the surfaces, where pressures shift what tractions hold."""
    if not scene.coupled or scene.frictionless:
        return 0.0
    surfaces = scene.bodies.surfaces if isinstance(scene.bodies, BodyPair) else scene.bodies
    return abs(surfaces.K)


def coarsest(line: bool, accuracy: float | None) -> int:
    """Elements across on the first grid, with which the floor takes a part of the accuracy on the
    third one.
    """
    n = FIRST_IN_LINE if line else FIRST
    if accuracy is None:
        return n
    return max(
        n, math.ceil((FLOOR / (FLOOR_PART * accuracy)) ** (1 / ORDER) / RATIO ** (GRIDS - 1))
    )


def _first(scene: Scene, options: SolveOptions, target: Target) -> int:
    """Elements across on the first grid: on the last of three the floor is half of the accuracy, or
    it is refused.
    """
    n = coarsest(scene.line, target.accuracy)
    last = most = n * RATIO ** (GRIDS - 1)
    if _fits(scene, options, last):
        return n
    what = (
        f"time_budget = {target.time_budget}"
        if target.accuracy is None
        else f"accuracy = {target.accuracy:g}"
    )
    while most > 1 and not process.fits(2 * _size(scene, options, most)[1]):
        most /= 1.1
    fits = f"accuracy = {FLOOR / FLOOR_PART * most**-ORDER:.2g} fits"
    raise TooLarge(what, _size(scene, options, last)[1], process.available() / 2, fits)


def _next(scene: Scene, options: SolveOptions, last: GridLevel, few: bool) -> int:
    """Elements across on the next grid: as many as the narrowest patch asks for, if these fit."""
    assert options.target is not None
    narrowest = min(
        (each.across for each in last.unresolved(options.target.accuracy)), default=NARROWEST
    )
    usual = math.ceil(last.n * RATIO)
    n = math.ceil(last.n * max(RATIO, NARROWEST / narrowest))
    return usual if few and n > usual and not _fits(scene, options, n) else n


def _level(
    scene: Scene, options: SolveOptions, n: int, levels: list[GridLevel], deadline: float
) -> GridLevel:
    """The answer on the next grid; where a contact is too small for it, as in a step with little
    load, on a finer one.

    Coarse grids have no certificate; a grid begins from the one before.
    """
    started = time.perf_counter()
    before = levels[-1].answer if levels else None
    final = len(levels) + 1 >= GRIDS
    near = before if isinstance(before, Solution) else None

    def tell(stage: str) -> None:
        options.progress(f"{n} elements across the contact: {stage}")

    on_level = replace(options, progress=tell, final=final, deadline=deadline)
    while True:
        try:
            answer = _solved(gridded(scene, options.plan.closed_form, n), on_level, near)
            break
        except TooCoarse:
            n = math.ceil(RATIO * n)
            if not _fits(scene, options, n):
                raise
    assert options.target is not None
    return GridLevel.of(n, answer, time.perf_counter() - started, options.target)


def _solved(scene: Scene, options: SolveOptions, near: Solution | None = None) -> Answer:
    if isinstance(scene.motion, Transient):
        return solve_transient(scene, options)
    return solve_on_grid(scene, options, near)


def _patches(sol: Solution) -> tuple[Patch, ...]:
    """The patches of a contact, four standard deviations of its elements wide; none where Hertz
    tells its shape.
    """
    if sol.scene.hertz is not None or not sol.pressure.any():
        return ()
    from scipy.ndimage import label

    labels, count = label(sol.pressure > 0, np.ones((3, 3)))
    found = []
    for number in range(1, count + 1):
        patch = labels == number
        places = np.argwhere(patch)[:, 1:] if sol.grid.line else np.argwhere(patch)
        variances = np.linalg.eigvalsh(np.atleast_2d(np.cov(places, rowvar=False, bias=True)))
        share = sol.pressure[patch].sum() / sol.pressure.sum()
        peak = sol.pressure[patch].max() == sol.pressure.max()
        found.append(Patch(4 * math.sqrt(variances[0] + 1 / 12), float(share), bool(peak)))
    return tuple(found)


def _fits(scene: Scene, options: SolveOptions, n: float) -> bool:
    """Whether so many elements across the contact fit into half of the memory; by default they are
    not too many.
    """
    assert options.target is not None
    elements, size = _size(scene, options, n)
    return not (options.target.by_default and elements > MOST_BY_DEFAULT) and process.fits(2 * size)


def _size(scene: Scene, options: SolveOptions, n: float) -> tuple[int, float]:
    """The elements with so many across the contact, and bytes of a solve on them and of the steps
    of two histories.
    """
    on_grid = gridded(scene, options.plan.closed_form, math.ceil(n))
    elements = given_grid(on_grid).size
    plan = options.plan_for(on_grid)
    pressures = 0.0 if plan.closed_form else peak(plan.normal, "", elements)
    tractions = peak(plan.tangential, plan.formulation, 2 * elements) if plan.has_friction else 0.0
    kept = bytes_of_steps(scene.motion, elements) if isinstance(scene.motion, Transient) else 0.0
    return elements, max(pressures, tractions) + 2 * kept


def _not_reached(
    levels: list[GridLevel], target: Target, why: str, cause: Exception | None = None
) -> Answer:
    """The best answer: as it is within a time and by default; with an accuracy it is that of an
    error.
    """
    estimate = estimated(levels, target)
    if why == DOES_NOT_FALL:
        estimate = replace(estimate, how=f"{estimate.how}; {why}")
    answer = with_values(levels[-1].answer, estimate)
    if target.accuracy is None or target.by_default:
        return answer
    reached = answer.error_estimate.largest
    message = (
        f"accuracy = {target.accuracy:g} is not reached: the estimate is {reached:.2g}, and {why}"
    )
    raise NotConverged(message, reached, answer) from cause


def _closed_form(scene: Scene, options: SolveOptions) -> Answer:
    started = time.perf_counter()
    grid = Grid(nx=4 * SHOWN + 1) if scene.line else Grid(nx=SHOWN, ny=SHOWN)
    answer = _solved(replace(scene, grid=grid), options)
    steps = (
        {f"[{k}]": sol for k, sol in enumerate(answer)}
        if isinstance(answer, History)
        else {"": answer}
    )
    hertz = {name: sol.scene.hertz for name, sol in steps.items() if sol.pressure.any()}
    peaks = {
        f"peak_pressure{name}": each.peak_pressure
        for name, each in hertz.items()
        if each is not None
    }
    best = values(answer) | peaks
    solves = (Solve(answer.grid.nx, answer.grid.rows, time.perf_counter() - started),)
    how = "Hertz's pressure and approach are exact in the continuum"
    target = options.target
    assert target is not None
    exact = dict.fromkeys(best, 0.0)
    return with_values(
        answer,
        ErrorEstimate(best, exact, how, solves, target.accuracy, target.time_budget, bars=exact),
    )


def with_values(answer: Answer, estimate: ErrorEstimate) -> Any:
    """An answer with an estimate, whose values become its own; of a history each step with those of
    the step.
    """
    if isinstance(answer, History):
        return replace(
            answer,
            solutions=[with_values(sol, estimate.of_step(k)) for k, sol in enumerate(answer)],
        )
    known = estimate.values
    # where the pressure bears a part of Fy
    if {"Fx", "Fy"} <= set(known) and not answer.scene.conformal:
        size = math.hypot(known["Fx"], known["Fy"])
        limit = friction_limit(answer)
        # extrapolated, a force may be beyond what friction carries
        part = limit / size if size > limit else 1.0
        known = known | {name: part * known[name] for name in ("Fx", "Fy")}
        estimate = replace(estimate, values=known)
    names = creepage_names(answer)
    first, second, third = (
        known.get(name, own) for name, own in zip(names, answer.creepage, strict=True)
    )
    approach = known.get("approach", answer.approach)
    return replace(
        answer, creepage=(first, second, third), approach=approach, error_estimate=estimate
    )
