"""A wheel on a rail to an accuracy or within a time, with error bars."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.discrete.operators import Operators
from varcontact.errors import NotConverged, SceneError
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.solvers.interface import OutOfTime
from varcontact.solving import adaptive
from varcontact.solving.adaptive import (
    COARSEST_SECONDS,
    TIME_BUDGETS_MAX,
    TIME_ORDER,
    GridLevel,
    estimated,
)
from varcontact.solving.grid_sequence import (
    COARSEST_ELEMENTS,
    FLOOR,
    ORDER,
    RATIO,
    GridSequence,
    richardson,
)
from varcontact.solving.options import SolveOptions, Target
from varcontact.wheel_rail.bearing_height import BearingHeight
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.patch_warnings import noisy_patches
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.wheel_geometry import VARIES, ContactPatch, WheelGeometry
from varcontact.wheel_rail.wheel_on_elements import (
    Start,
    WheelOnElements,
    for_pressure,
    patches_at,
    solved_alone,
    vertical,
    vertical_forces,
)

START = 0.5, 0.125
"""Sides of elements [mm] for the first height, where grids are chosen."""

ACROSS = 14
"""Elements across the smallest patch on the coarsest of the three sets of elements used for error
estimates by default."""

START_TOL = 1e-3
"""Relative error of the load at that height."""

MOVED = 0.02
"""Change of the height, relative to the least approach, above which contacts are determined
again."""


def to_target(
    case: WheelGeometry,
    tol: float,
    methods: dict[str, Any],
    target: Target,
    on_first: Callable[[WheelRailSolution], None],
) -> WheelRailSolution:
    """Solution to an accuracy or within a time, with error bars; on a curved surface if a contact
    is too wide for a plane.
    """
    started = time.perf_counter()
    rough = replace(case.in_planes(), dx=START[0], dy=START[1])
    try:
        first = _first(rough, tol, methods, target, started)
    except (NotConverged, SceneError):
        if not case.curved:
            raise
        first = _first(rough.on_curved_surface(), tol, methods, target, started)
    on_first(first)
    chosen = target.accuracy is not None and not (target.by_default and noisy_patches(first))

    def on_curved_surface() -> WheelRailSolution:
        curved = case.on_curved_surface()
        coarse = _with_elements_across(curved, first, ACROSS)
        first_curved = _first(coarse, tol, methods, target, started, Start(first))
        return _from_first(curved, tol, methods, target, first_curved, started, chosen)

    if case.curved:
        return on_curved_surface()
    if case.plane_or_curved and any(first.too_wide):
        # a profile that turns too fast or is too rough: the plane's warning remains
        with suppress(NotConverged, SceneError):
            return on_curved_surface()
    return _from_first(case, tol, methods, target, first, started, chosen)


def _first(
    case: WheelGeometry,
    tol: float,
    methods: dict[str, Any],
    target: Target,
    started: float,
    start: Start | None = None,
) -> WheelRailSolution:
    """First solution on coarse elements: it gives the height, the contacts, and whether noise
    dominates them.
    """
    methods = methods | {"certify": None}
    deadline = _deadline(target, started, few=True)
    try:
        tol = max(tol, START_TOL)
        return solved_alone(WheelOnElements(case, tol, methods, start, deadline=deadline))
    except OutOfTime:
        raise _too_short(target) from None


def _deadline(target: Target, started: float, few: bool) -> float:
    """Clock time at which solvers stop, for a time budget; a few coarse grids may take longer."""
    if target.time_budget is None:
        return math.inf
    return started + TIME_BUDGETS_MAX * target.time_budget + (COARSEST_SECONDS if few else 0.0)


def _too_short(target: Target) -> SceneError:
    allowed = "more seconds, or elements of dx and dy: even coarse ones take longer"
    return SceneError("time_budget", target.time_budget, allowed)


def _from_first(
    case: WheelGeometry,
    tol: float,
    methods: dict[str, Any],
    target: Target,
    first: WheelRailSolution,
    started: float,
    chosen: bool,
) -> WheelRailSolution:
    """Solution to an accuracy, from a first one, on grids that are `chosen` for it, else on finer
    and finer elements.

    By default the error is estimated from three sets of elements where grids cannot be chosen for
    an accuracy or do not reach it, and where noise dominates the pressure.
    """
    if chosen:
        try:
            return _to_accuracy(case, first, tol, methods, target)
        except (NotConverged, SceneError) as error:
            if not target.by_default or (isinstance(error, SceneError) and str(error) != VARIES):
                raise
            try:
                return _on_finer_elements(case, tol, methods, target, first, started)
            except SceneError:  # errors about elements that the user did not give
                raise error from None
    return _on_finer_elements(case, tol, methods, target, first, started)


def _to_accuracy(
    case: WheelGeometry,
    first: WheelRailSolution,
    tol: float,
    methods: dict[str, Any],
    target: Target,
) -> WheelRailSolution:
    """Solution on grids chosen for an accuracy: half of it for normal forces, half for tangential
    ones.

    Distances and frames are those of a height near that which carries the load. From there the
    normal forces grow by the power 3/2 of the depth; grids stay, so that forces do not jump.
    """
    assert target.accuracy is not None
    half = replace(target, accuracy=target.accuracy / 2)
    near = first
    while True:
        found = _near(case, near, tol, methods, half)
        if abs(found.z - near.z) <= MOVED * min(each.patch.approach for each in found.patches):
            return found
        near = found


def _on_finer_elements(
    case: WheelGeometry,
    tol: float,
    methods: dict[str, Any],
    target: Target,
    first: WheelRailSolution,
    started: float,
) -> WheelRailSolution:
    """Solution on elements finer by `RATIO` each time, three times or as often as the time allows.

    Forces are those on the finest elements, without extrapolation: they balance the load. Their
    errors are estimated from the last three sets.
    """
    ends = 0.0 if target.time_budget is None else started + target.time_budget
    n = float(ACROSS if target.time_budget is None else COARSEST_ELEMENTS)
    sequence = GridSequence[WheelRailSolution](n, whole=False)
    solved = sequence.levels
    seconds = 0.0
    while sequence.few or seconds * RATIO**TIME_ORDER < ends - time.perf_counter():
        begun = time.perf_counter()
        on_sides = _with_elements_across(case, first, sequence.n)
        start = Start(solved[-1] if solved else first)
        deadline = _deadline(target, started, sequence.few)
        try:
            wheel = WheelOnElements(
                on_sides, tol, methods, start, deadline=deadline, second_order=True
            )
            last = solved_alone(wheel)
        except OutOfTime:
            if not solved:
                raise _too_short(target) from None
            break
        except NotConverged:
            if not solved:
                raise
            break
        sequence.learn(replace(last, case=case))
        seconds = time.perf_counter() - begun
    return _with_errors(sequence.last, target)


def _with_elements_across(case: WheelGeometry, first: WheelRailSolution, n: float) -> WheelGeometry:
    """The case with n elements across the smallest patch of a solution, and more of them along x,
    as `gridded` has.
    """
    lengths = []
    for each in first.patches:
        contact = each.solution.pressure > 0
        counts = [np.count_nonzero(contact.any(axis=axis)) for axis in (0, 1)]
        lengths.append(np.multiply(counts, each.solution.grid.sides))
    long, wide = np.min(lengths, axis=0)
    return replace(case, dx=float(long / (RATIO * n)), dy=float(wide / n))


def _with_errors(solved: list[WheelRailSolution], target: Target) -> WheelRailSolution:
    """The last of solutions on finer and finer elements, with errors where all have as many
    patches.
    """
    last = solved[-1]
    if len(solved) == 1 or len({len(each.patches) for each in solved}) > 1:
        return last
    patches, force_errors = [], []
    for column in zip(*(each.patches for each in solved), strict=True):
        contact = column[-1].solution.pressure > 0
        finest = max(1.0, min(contact.any(axis=1).sum(), contact.any(axis=0).sum() / RATIO))
        across = [finest * RATIO ** (k - len(solved) + 1) for k in range(len(solved))]
        answers = [each.solution for each in column]
        levels = [
            GridLevel.of(n, answer, sum(answer.timing.values()), target)
            for n, answer in zip(across, answers, strict=True)
        ]
        estimate = estimated(levels, target)
        on_grid = levels[-1].values | levels[-1].unjudged
        estimate = replace(estimate, values=on_grid, on_grid=on_grid)
        _, error = richardson([each.normal_force for each in column], across)
        force_errors.append(float(error) / column[-1].normal_force + FLOOR * finest**-ORDER)
        patches.append(replace(column[-1], solution=replace(answers[-1], error_estimate=estimate)))
    errors = _normal_errors(last.case, patches, force_errors)
    return replace(last, patches=tuple(map(_with_normal_error, patches, errors)))


def _with_normal_error(patch: PatchSolution, error: float) -> PatchSolution:
    return replace(patch, normal_error=error)


def _normal_errors(
    case: WheelGeometry, patches: Sequence[PatchSolution], errors: list[float]
) -> list[float]:
    """Relative errors of normal forces: of a single patch the load and the tangential force
    determine it.
    """
    estimate = patches[0].solution.error_estimate
    if case.z is not None or len(patches) > 1:
        return errors
    if estimate is None or not case.with_friction or "Fy" not in estimate.errors:
        return [0.0]
    (patch,) = patches
    lifting = abs(np.sin(patch.patch.angle)) * estimate.bars["Fy"]
    return [float(lifting / abs(patch.frame.axes[2] @ patch.force))]


def _chosen(
    scene: Scene,
    methods: dict[str, Any],
    target: Target,
    near: Sequence[GridLevel] = (),
    operators: dict[Grid, Operators] | None = None,
) -> tuple[Solution, list[GridLevel]]:
    """The solution on a grid that is chosen for the accuracy, from those `near`; and on all grids
    before it.
    """
    options = SolveOptions.checked(scene, **(methods | {"accuracy": target.accuracy}))
    options = replace(options, target=target, operators=operators)
    found, levels = adaptive.solve_near(scene, options, near)
    assert isinstance(found, Solution)
    return found, levels


def _near(
    case: WheelGeometry,
    near: WheelRailSolution,
    tol: float,
    methods: dict[str, Any],
    target: Target,
) -> WheelRailSolution:
    """Solution to an accuracy, with the distances and frames at the height of a previous
    solution.
    """
    patches = patches_at(case, near.z, with_grid=False)
    frames = [each.frame for each in patches]
    cosines = np.cos([each.angle for each in patches])
    operators: list[dict[Grid, Operators]] = [{} for _ in patches]
    held, levels = _at_approaches(patches, methods, target, operators)
    forces = [each.normal_force for each in held]
    force_errors = [_largest_error(each) for each in held]
    coupled = patches[0].scene.coupled
    known = vertical_forces(near)
    if coupled:
        solved = tuple(map(PatchSolution, patches, held))
        known = vertical_forces(WheelRailSolution(case, near.z, solved, 0))
    search = BearingHeight(case, tol, near.z, known, same_grids=coupled)
    while not search.done:
        z = search.propose()
        loads = _loads(patches, forces, z - near.z)
        if case.z is None:
            search.learn_normal(float(cosines @ loads))
            if not search.near:
                continue
        loaded = []
        for k, (patch, load) in enumerate(zip(patches, loads, strict=True)):
            scene = replace(patch.scene, approach=None, normal_force=load)
            solution, levels[k] = _chosen(scene, methods, target, levels[k], operators[k])
            loaded.append(PatchSolution(patch, solution))
        errors = _normal_errors(case, loaded, force_errors)
        solved = tuple(map(_with_normal_error, loaded, errors))
        search.learn(vertical(frames, [each.force for each in solved], case.with_friction))
    return WheelRailSolution(case, search.z, solved, search.rounds)


def _at_approaches(
    patches: Sequence[ContactPatch],
    methods: dict[str, Any],
    target: Target,
    operators: Sequence[dict[Grid, Operators]],
) -> tuple[list[Solution], list[list[GridLevel]]]:
    """Solutions of the patches at their approaches, which give the normal forces; and the levels on
    all grids of those whose tractions change the pressure.
    """
    held = []
    levels: list[list[GridLevel]] = []
    for patch, kept in zip(patches, operators, strict=True):
        if patch.scene.coupled:
            not_certified = methods | {"certify": None}
            solution, on_grids = _chosen(patch.scene, not_certified, target, operators=kept)
            levels.append(on_grids)
        else:
            bare = patch.scene.without_friction
            no_pressure = replace(target, of_pressure=False)
            solution, _ = _chosen(bare, for_pressure(methods), no_pressure)
            levels.append([])
        held.append(solution)
    return held, levels


def _largest_error(solution: Solution) -> float:
    assert solution.error_estimate is not None
    return solution.error_estimate.largest


def _loads(patches: Sequence[ContactPatch], forces: Sequence[float], deeper: float) -> list[float]:
    """Normal forces of patches at a greater depth, by the power 3/2 of the approach."""
    found = []
    for patch, force in zip(patches, forces, strict=True):
        ratio = 1 + deeper * np.cos(patch.angle) / patch.approach
        found.append(force * max(ratio, 0.0) ** 1.5)
    return found
