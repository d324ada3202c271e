"""Solutions to an accuracy, or within a time: finer and finer grids until the
estimated error is small enough.

One rule for every scene. Grids have 4, 6, 9, 14, 21, ... elements across the
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
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from varcontact.errors import NotConverged, SceneError, TooCoarse, TooLarge
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import (
    creepage_names,
    static_friction_limit,
    units,
    values,
)
from varcontact.results.solution import Solution
from varcontact.scene.bodies import BodyPair
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import OutOfTime
from varcontact.solving.grid_sequence import (
    FLOOR,
    FLOOR_PART,
    GRIDS,
    ORDER,
    RATIO,
    GridSequence,
    coarsest,
    gridded,
    order_of,
    richardson,
)
from varcontact.solving.history import bytes_of_steps, solve_transient
from varcontact.solving.on_grid import solve_on_grid
from varcontact.solving.options import DEFAULT_ACCURACY, SolveOptions, Target
from varcontact.solving.pipeline import peak
from varcontact.system import process
from varcontact.system.process import one_blas_thread

FLOOR_UNLIKE = 1.0
"""Factor of the additional error floor of unlike bodies, ``FLOOR_UNLIKE |K|/n``, with n elements
across; the floor of the largest pressure is without it."""
NARROWEST = 4.0
"""Elements across the narrowest patch that carries load, on the coarsest grid used in an error
estimate."""
TIME_ORDER = 2.4
"""Power of n with which the time of a solve grows."""
TIME_BUDGETS_MAX = 1.3
"""Multiple of the time budget after which a solve is abandoned."""
COARSEST_SECONDS = 2.0
"""Additional time for the coarsest grids [s]."""
STALLED = 0.9
"""Factor on an error estimate; if both later ones exceed the product, the error does not fall with
the grid."""
PEAK_DOUBTED = 4.0
"""Error of the largest pressure, relative to it and to the accuracy, above which a warning is
given."""
LEAST_DOUBT = 0.1
"""Least error of the largest pressure, relative to it, of which a warning is given."""
DOES_NOT_FALL = "it does not fall with the grid"
DEFAULT_ELEMENTS_MAX = 40_000
"""Largest number of elements by default: an answer that would need more gets a larger error bar."""
SHOWN = 25
"""Elements across a contact in closed form: with an odd number one is at the largest pressure."""

Answer = Solution | History


@dataclass(frozen=True)
class ContactPart:
    """Connected part of the contact: elements across it, and its part of the load."""

    across: float
    share: float
    peak: bool  # whether it has the largest pressure


@dataclass(frozen=True)
class GridLevel:
    """Answer on a grid with `n` elements across the contact, and the values that errors are
    measured in.

    `unjudged`: values that have an error bar, but do not count for the accuracy.
    """

    n: int
    answer: Answer
    values: dict[str, float]
    seconds: float
    patches: tuple[ContactPart, ...]
    unjudged: dict[str, float] = field(default_factory=dict)

    @classmethod
    def of(cls, n: int, answer: Answer, seconds: float, target: Target) -> GridLevel:
        """Level with the patches of the answer, of a history those of its largest contact."""
        judged = values(answer)
        unjudged = {}
        if isinstance(answer, History):
            largest = max(answer, key=lambda sol: sol.areas["contact"])
        else:
            largest = answer
            if not answer.plan.closed_form and answer.pressure.any():
                unjudged = {"peak_pressure": answer.max_pressure}
        if target.of_pressure:
            unjudged = {name: value for name, value in unjudged.items() if name not in judged}
        judged = {name: value for name, value in judged.items() if name not in unjudged}
        return cls(n, answer, judged, seconds, _patches(largest), unjudged)

    def unresolved(self, accuracy: float | None) -> list[ContactPart]:
        """Patches with few elements across that carry more of the load than the `accuracy`, or have
        the largest pressure where its error counts.
        """
        share_min = accuracy or DEFAULT_ACCURACY
        narrow = (patch for patch in self.patches if patch.across < NARROWEST)
        return [
            patch
            for patch in narrow
            if patch.share > share_min or (patch.peak and "peak_pressure" in self.values)
        ]


@one_blas_thread()
def solve(scene: Scene, options: SolveOptions) -> Answer:
    """A scene without a grid of its own, solved to an accuracy or within a time, on the finest grid
    that it took.

    `NotConverged`, with the best answer, if the accuracy is not reached: a finer grid does not fit
    into memory, or a solver misses its tolerance there. A `SceneError` if a history is not solved
    in time on the coarsest grids.
    """
    answer, _ = solve_near(scene, options, ())
    return answer


@one_blas_thread()
def solve_near(
    scene: Scene, options: SolveOptions, near: Sequence[GridLevel]
) -> tuple[Answer, list[GridLevel]]:
    """The answer as of `solve`, and those on its grids; from those `near`, of another load, on
    their grids.
    """
    assert options.target is not None
    if options.plan.closed_form and not options.plan.has_friction:
        return _closed_form(scene, options), []
    grids = GridSequence[GridLevel](_first(scene, options, options.target))
    return _refined(scene, options, grids, near), grids.levels


def _refined(
    scene: Scene,
    options: SolveOptions,
    sequence: GridSequence[GridLevel],
    near: Sequence[GridLevel],
) -> Answer:
    """The answer to a target, on the last grid of a sequence that begins here."""
    target = options.target
    started = time.perf_counter()
    assert target is not None
    budget = target.seconds
    levels = sequence.levels
    estimates: list[ErrorEstimate] = []
    while True:
        # the answer on the next grid
        deadline = started + TIME_BUDGETS_MAX * budget
        if sequence.few:
            deadline += COARSEST_SECONDS
        n = int(sequence.n)
        try:
            last = _level(scene, options, n, levels, near, deadline)
        except (OutOfTime, NotConverged) as error:
            return _after_failure(n, levels, options, error)
        sequence.learn(last, last.n)
        few = sequence.few

        # its error, and whether that is small enough or cannot fall
        if not few:
            estimates.append(estimated(levels, target))
            if target.accuracy is not None and estimates[-1].largest <= target.accuracy:
                return with_values(last.answer, estimates[-1])
            if stalled(estimates):
                return _not_reached(levels, target, DOES_NOT_FALL)
            if len(estimates) == 1:
                _report_warnings(last.answer, options)

        # the next grid, as far as memory and time allow
        n = sequence.n = _next(scene, options, sequence)
        fits = _fits(scene, options, n)
        if few and (fits or not target.by_default or len(levels) == 1):
            continue
        late = last.seconds * (n / last.n) ** TIME_ORDER > budget - (time.perf_counter() - started)
        if late or not fits:
            return _not_reached(
                levels, target, f"a grid of {n} elements across does not fit into memory"
            )


def _after_failure(
    n: int, levels: list[GridLevel], options: SolveOptions, error: OutOfTime | NotConverged
) -> Answer:
    """Best answer after a failure on the grid with n elements across, if there is an error
    estimate.
    """
    target = options.target
    assert target is not None
    if len(levels) >= GRIDS:
        why = f"the next grid, of {n} elements across, fails: {error}"
        return _not_reached(levels, target, why, error)
    if isinstance(error, NotConverged):
        raise error
    allowed = (
        "more seconds, or an accuracy: even the coarsest grids, which tell the error, take longer"
    )
    raise SceneError("time_budget", target.seconds, allowed) from None


def _report_warnings(answer: Answer, options: SolveOptions) -> None:
    """Report the warnings, such as on noise, as progress before time is spent on finer grids."""
    if isinstance(answer, Solution):
        for words in answer.warnings:
            options.progress(words)


def stalled(estimates: Sequence[ErrorEstimate]) -> bool:
    """True if neither of the last two errors is below the one before them."""
    if len(estimates) < GRIDS:
        return False
    before, *last = (each.largest for each in estimates[-GRIDS:])
    return min(last) > STALLED * before


def estimated(levels: list[GridLevel], target: Target) -> ErrorEstimate:
    """The values of the last grids, extrapolated, with their errors.

    A patch that is too narrow on the coarsest of them adds its part of the load, or of the peak, by
    its elements.
    """
    last_levels = levels[-GRIDS:]
    fine = last_levels[-1]
    unit = units(fine.answer) | fine.unjudged
    order = order_of(fine.answer.scene)
    narrow = last_levels[0].unresolved(target.accuracy)
    by_level = [(level.n, level.values | level.unjudged) for level in last_levels]
    on_grid = by_level[-1][1]
    best = dict(on_grid)
    errors = {}
    for name in (name for name in on_grid if name in by_level[-2][1]):
        # Richardson's steps between the grids that have the value
        tried = [(n, level_values[name]) for n, level_values in by_level if name in level_values]
        value, error = richardson(
            [level_value for _, level_value in tried], [n for n, _ in tried], order
        )
        # plus the error that no grid shows, and that of patches too narrow on the first grid
        best[name] = float(value)
        errors[name] = float(error) / unit[name] + _floor(fine, name) + _missed(narrow, name)
    return ErrorEstimate(
        best,
        {name: error for name, error in errors.items() if name in fine.values},
        _how_estimated(last_levels, narrow, order),
        tuple(
            Solve(level.answer.grid.nx, level.answer.grid.rows, level.seconds) for level in levels
        ),
        target.accuracy,
        target.time_budget,
        on_grid,
        {name: error * unit[name] for name, error in errors.items()},
    )


def _floor(fine: GridLevel, name: str) -> float:
    """Error of a value that no grid shows, with `fine` as the finest of them."""
    if name == "peak_pressure":
        across = next((patch.across for patch in fine.patches if patch.peak), fine.n)
        return FLOOR * min(across, fine.n) ** -ORDER
    floor = FLOOR * fine.n**-ORDER
    return floor + FLOOR_UNLIKE * _unlikeness(fine.answer.scene) / fine.n


def _missed(narrow: list[ContactPart], name: str) -> float:
    """Error of a value due to patches with too few elements across."""
    missed = 0.0
    for patch in narrow:
        share = patch.share
        if name == "peak_pressure" and patch.peak:
            share = 1.0
        missed += share / patch.across
    return missed


def _how_estimated(last_levels: list[GridLevel], narrow: list[ContactPart], order: float) -> str:
    *coarser, finest = (f"{level.n:.0f}" for level in last_levels)
    grids = f"{', '.join(coarser)} and {finest} elements across the contact"
    how = f"by Richardson's steps of order {order:g} between grids of {grids}"
    if narrow:
        across = min(patch.across for patch in narrow)
        how += f"; the narrowest patch has {across:.2g} elements on the first of them"
    return how


def _unlikeness(scene: Scene) -> float:
    """|K| of the materials at the surfaces, where pressures shift what tractions hold."""
    if not scene.coupled or scene.frictionless:
        return 0.0
    bodies = scene.bodies
    if isinstance(bodies, BodyPair):
        bodies = bodies.surfaces
    return abs(bodies.K)


def _first(scene: Scene, options: SolveOptions, target: Target) -> int:
    """Elements across on the first grid: on the last of three the floor is half of the accuracy, or
    it is refused.
    """
    n = coarsest(scene.line, target.accuracy)
    last = most = n * RATIO ** (GRIDS - 1)
    if _fits(scene, options, last):
        return n
    if target.accuracy is None:
        what = f"time_budget = {target.time_budget}"
    else:
        what = f"accuracy = {target.accuracy:g}"
    while most > 1 and not process.fits(2 * _size(scene, options, most)[1]):
        most /= 1.1
    fits = f"accuracy = {FLOOR / FLOOR_PART * most**-ORDER:.2g} fits"
    raise TooLarge(what, _size(scene, options, last)[1], process.available() / 2, fits)


def _next(scene: Scene, options: SolveOptions, sequence: GridSequence[GridLevel]) -> int:
    """Elements across on the next grid: as many as the narrowest patch needs, if these fit."""
    assert options.target is not None
    narrowest = min(
        (each.across for each in sequence.levels[-1].unresolved(options.target.accuracy)),
        default=NARROWEST,
    )
    usual = int(sequence.finer())
    n = int(sequence.finer(max(RATIO, NARROWEST / narrowest)))
    if sequence.few and n > usual and not _fits(scene, options, n):
        return usual
    return n


def _level(
    scene: Scene,
    options: SolveOptions,
    n: int,
    before: Sequence[GridLevel],
    near: Sequence[GridLevel],
    deadline: float,
) -> GridLevel:
    """The answer on the next grid; where a contact is too small for it, as in a step with little
    load, on a finer one.

    Coarse grids have no certificate. A grid begins from the answer `near` it, of another load, or
    from that on the grid before.
    """
    started = time.perf_counter()
    final = len(before) + 1 >= GRIDS

    def tell(stage: str) -> None:
        options.progress(f"{n} elements across the contact: {stage}")

    on_level = replace(options, progress=tell, final=final, deadline=deadline)
    while True:
        try:
            on_grid = gridded(scene, options.plan.closed_form, n)
            same_grid = [level for level in near if level.n == n]
            answer = _solved_from(on_grid, on_level, before, same_grid)
            break
        except TooCoarse:
            n = math.ceil(RATIO * n)
            if not _fits(scene, options, n):
                raise
    assert options.target is not None
    return GridLevel.of(n, answer, time.perf_counter() - started, options.target)


def _solved_from(
    scene: Scene,
    options: SolveOptions,
    before: Sequence[GridLevel],
    same_grid: Sequence[GridLevel],
) -> Answer:
    """Answer started from that of another load on the same grid, if it holds the contact, else from
    the coarser grid.
    """
    for level in same_grid:
        guess = level.answer
        if isinstance(guess, Solution):
            with suppress(SceneError):  # a contact that continues outside the grid
                on_grid = replace(scene, grid=guess.grid)
                return replace(_solved(on_grid, options, guess), scene=scene)
    if before and isinstance(before[-1].answer, Solution):
        return _solved(scene, options, before[-1].answer)
    return _solved(scene, options)


def _solved(scene: Scene, options: SolveOptions, initial_guess: Solution | None = None) -> Answer:
    if isinstance(scene.motion, Transient):
        return solve_transient(scene, options)
    return solve_on_grid(scene, options, initial_guess)


def _patches(sol: Solution) -> tuple[ContactPart, ...]:
    """Patches of a contact, each four standard deviations of its elements wide across its narrow
    direction; empty where Hertz gives the shape.
    """
    if sol.scene.hertz is not None or not sol.pressure.any():
        return ()
    from scipy.ndimage import label

    labels, count = label(sol.pressure > 0, np.ones((3, 3)))
    patches = []
    for number in range(1, count + 1):
        patch = labels == number
        places = np.argwhere(patch)
        if sol.grid.line:
            places = places[:, 1:]
        variances = np.linalg.eigvalsh(np.atleast_2d(np.cov(places, rowvar=False, bias=True)))
        share = sol.pressure[patch].sum() / sol.pressure.sum()
        peak = sol.pressure[patch].max() == sol.pressure.max()
        patches.append(ContactPart(4 * math.sqrt(variances[0] + 1 / 12), float(share), bool(peak)))
    return tuple(patches)


def _fits(scene: Scene, options: SolveOptions, n: float) -> bool:
    """True if n elements across the contact fit into half of the memory, and by default are not
    too many.
    """
    assert options.target is not None
    elements, size = _size(scene, options, n)
    return not (options.target.by_default and elements > DEFAULT_ELEMENTS_MAX) and process.fits(
        2 * size
    )


def _size(scene: Scene, options: SolveOptions, n: float) -> tuple[int, float]:
    """Elements of the grid with n across the contact, and bytes of a solve with them and of the
    steps of two histories.
    """
    on_grid = gridded(scene, options.plan.closed_form, math.ceil(n))
    elements = on_grid.own_grid.size
    plan = options.plan_for(on_grid)
    solving = 0.0
    if not plan.closed_form:
        solving = peak(plan.solver_of("normal"), "", elements)
    if plan.has_friction:
        by_tangential = peak(plan.solver_of("tangential"), plan.formulation, 2 * elements)
        solving = max(solving, by_tangential)
    steps = 0.0
    if isinstance(scene.motion, Transient):
        steps = bytes_of_steps(scene.motion, elements)
    return elements, solving + 2 * steps


def _not_reached(
    levels: list[GridLevel], target: Target, why: str, cause: Exception | None = None
) -> Answer:
    """Best answer so far, for a time budget or by default; for an accuracy as part of the error
    raised.
    """
    estimate = estimated(levels, target)
    if why == DOES_NOT_FALL:
        estimate = replace(estimate, how=f"{estimate.how}; {why}")
    answer = with_values(levels[-1].answer, estimate)
    if target.by_default and isinstance(answer, Solution):
        return _with_missed_default(answer)
    if target.accuracy is None or target.by_default:
        return answer
    reached = answer.error_estimate.largest
    message = (
        f"accuracy = {target.accuracy:g} is not reached: the estimate is {reached:.2g}, and {why}"
    )
    raise NotConverged(message, reached, answer) from cause


def _with_missed_default(answer: Solution) -> Solution:
    """Answer with a warning if its error exceeds the accuracy by default."""
    estimate = answer.error_estimate
    if estimate is None or estimate.largest <= DEFAULT_ACCURACY:
        return answer
    warning = (
        f"the error is estimated at {100 * estimate.largest:.2g} %, not at most "
        f"{100 * DEFAULT_ACCURACY:g} % as usual: give accuracy={DEFAULT_ACCURACY:g} for "
        "finer grids, or a grid"
    )
    return replace(answer, warnings=(*answer.warnings, warning))


def _closed_form(scene: Scene, options: SolveOptions) -> Answer:
    started = time.perf_counter()
    grid = Grid(nx=4 * SHOWN + 1) if scene.line else Grid(nx=SHOWN, ny=SHOWN)
    answer = _solved(replace(scene, grid=grid), options)
    if isinstance(answer, History):
        steps = {f"[{k}]": sol for k, sol in enumerate(answer)}
    else:
        steps = {"": answer}
    best = values(answer)
    for name, sol in steps.items():
        if sol.pressure.any() and sol.scene.hertz is not None:
            best[f"peak_pressure{name}"] = sol.scene.hertz.peak_pressure
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
    best = estimate.values
    # in conformal contact the pressure carries a part of Fy
    if {"Fx", "Fy"} <= set(best) and not answer.scene.conformal:
        size = math.hypot(best["Fx"], best["Fy"])
        limit = static_friction_limit(answer)
        # an extrapolated force may exceed the friction limit
        if size > limit:
            part = limit / size
            best = best | {name: part * best[name] for name in ("Fx", "Fy")}
            estimate = replace(estimate, values=best)
    names = creepage_names(answer)
    first, second, third = (
        best.get(name, own) for name, own in zip(names, answer.creepage, strict=True)
    )
    approach = best.get("approach", answer.approach)
    doubt = _doubt_of_peak(answer, estimate)
    return replace(
        answer,
        creepage=(first, second, third),
        approach=approach,
        error_estimate=estimate,
        warnings=(*answer.warnings, *doubt),
    )


def _doubt_of_peak(answer: Solution, estimate: ErrorEstimate) -> tuple[str, ...]:
    """Warning on a largest pressure with an error far above the accuracy, such as of a body that
    ends within the contact; else empty.
    """
    bar = estimate.bars.get("peak_pressure", 0.0)
    if estimate.accuracy is None or bar == 0:
        return ()
    error = bar / answer.max_pressure
    if error <= max(PEAK_DOUBTED * estimate.accuracy, LEAST_DOUBT):
        return ()
    return (
        f"the largest pressure is known to {100 * error:.0f} % only; "
        "if a body ends within the contact, it has no limit and grows with finer grids",
    )
