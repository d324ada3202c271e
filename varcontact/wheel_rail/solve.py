"""All patches of a wheel on a rail, and the height of its axle that bears the load."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar
from warnings import catch_warnings, simplefilter

import numpy as np

from varcontact import checks
from varcontact.discrete.operators import Operators
from varcontact.errors import NotConverged, PlausibilityWarning, SceneError, VarcontactError
from varcontact.kinematics import Frame
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.plausibility import warn as warn_of_doubts
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse
from varcontact.solvers.interface import OutOfTime
from varcontact.solving import adaptive
from varcontact.solving.adaptive import (
    COARSEST,
    FIRST,
    FLOOR,
    GRIDS,
    GROWTH,
    LATE,
    ORDER,
    RATIO,
    GridLevel,
    estimated,
    richardson,
)
from varcontact.solving.on_grid import ContactOnGrid, Near
from varcontact.solving.options import BY_DEFAULT, CertifyName, SolveOptions, Target
from varcontact.solving.side_by_side import settled_together
from varcontact.solving.solve import solve
from varcontact.system.process import one_blas_thread
from varcontact.theories.on_grid import THEORIES
from varcontact.wheel_rail.bearing_height import BearingHeight
from varcontact.wheel_rail.doubts import noisy_patches, too_wide, warn, warn_of_noise
from varcontact.wheel_rail.plausibility import doubts
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution
from varcontact.wheel_rail.seams import weakened
from varcontact.wheel_rail.wheel_on_rail import VARIES, ContactPatch, WheelOnRail

SIDE_BY_SIDE = 32
"""Parts of a sweep whose tractions are solved for at a time."""
LEAP = 0.1
"""Change of the depth between positions, relative, from which the next one is not expected to
follow it."""
ON_ELLIPSE = 32
"""Elements either way across the ellipse of a theory: as many at all heights, so that forces do not
jump."""
TARGETS = ("accuracy", "time_budget")
START = 0.5, 0.125
"""Sides of elements [mm] for the first height, where grids are chosen."""
ACROSS = 14
"""Elements across the smallest patch on the coarsest of three sets of elements, which tell the
error by default."""
START_TOL = 1e-3
"""Relative error of the load at that height."""
MOVED = 0.02
"""Change of the height, relative to the least approach, from which contacts are determined
again."""

Solved = tuple[WheelRailSolution, list[Operators]]
"""With the operators on the grids of its patches."""
Kind = TypeVar("Kind")
Steps = Generator[list[ContactOnGrid], list[ContactOnGrid], Kind]
"""What gives contacts with their pressures, and is given them, some with tractions, until it has
its result."""


@dataclass(frozen=True, eq=False)
class _Start:
    """Where the search for a height begins: at that of a solution, so much deeper, with its
    operators if known.
    """

    solution: WheelRailSolution
    deeper: float = 0.0
    operators: Sequence[Operators] = ()


def solve_wheel_on_rail(
    case: WheelOnRail, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelRailSolution:
    """See `WheelOnRail.solve`; `methods` has the arguments of `varcontact.solve`."""
    warn_of_doubts(doubts(case), stacklevel=5)
    rough: list[str] = []

    def on_first(first: WheelRailSolution) -> None:
        if not rough:
            rough.extend(noisy_patches(first))
            warn_of_noise(rough, stacklevel=11)

    ((_, found),) = solve_wheels_on_rails([case], tol, certify, on_first, **methods)
    if isinstance(found, VarcontactError):
        raise found
    if not rough:
        warn_of_noise(noisy_patches(found), stacklevel=6)
    warn(found, stacklevel=6)
    return found


def solve_wheels_on_rails(
    cases: Sequence[WheelOnRail],
    tol: float = 1e-6,
    certify: CertifyName | None = None,
    on_first: Callable[[WheelRailSolution], None] = lambda first: None,
    **methods: Any,
) -> Iterator[tuple[int, WheelRailSolution | VarcontactError]]:
    """The numbers of cases, and their solutions or what refuses them, as they are found, without
    `warn`.

    `on_first` is given the first, rough solution of each where grids are chosen: before time is
    spent on finer ones. Parts of them are solved side by side, with all tractions at a time; within
    a part each begins from the one before, and as much deeper as that was than the one before it.
    """
    found: dict[int, WheelRailSolution | VarcontactError] = {}
    methods["certify"] = certify

    def part(numbers: list[int]) -> Steps[None]:
        start, depth = None, 0.0
        for k in numbers:
            try:
                last, operators = yield from _wheel(cases[k], tol, methods, start, on_first)
                before, depth = depth, last.z - last.case.touching
                leaps = abs(depth - before) >= LEAP * depth
                start = _Start(last, 0.0 if leaps else depth - before, operators)
                found[k] = last
            except VarcontactError as error:
                found[k] = error
            yield []
        for each in start.operators if start else ():
            each.forget()

    order = sorted(range(len(cases)), key=lambda k: cases[k].side)
    parts = np.array_split(order, min(SIDE_BY_SIDE, len(cases))) if cases else []
    together = len(cases) > 1 and methods.keys().isdisjoint(("tangential", "method", "formulation"))
    waiting: list[tuple[Steps[None], list[ContactOnGrid]]] = [
        (part(each.tolist()), []) for each in parts
    ]
    while waiting:
        flat, going = [contact for _, contacts in waiting for contact in contacts], []
        settled = settled_together(flat) if together else flat
        for steps, contacts in waiting:
            with one_blas_thread(), suppress(StopIteration), catch_warnings():
                # of scenes of patches: `warn` has them, each once
                simplefilter("ignore", PlausibilityWarning)
                own = [settled.pop(0) for _ in contacts]
                going.append((steps, steps.send(own) if own else next(steps)))
            yield from found.items()
            found.clear()
        waiting = going


def _wheel(
    case: WheelOnRail,
    tol: float,
    methods: dict[str, Any],
    start: _Start | None = None,
    on_first: Callable[[WheelRailSolution], None] = lambda first: None,
) -> Steps[Solved]:
    tol, theory = checks.positive("tol", tol), methods.get("tangential") in THEORIES
    target = _target(case, methods, theory)
    methods = {name: value for name, value in methods.items() if name not in TARGETS}
    if isinstance(methods.get("start"), WheelRailSolution):
        start = _Start(methods.pop("start"))
    # by default grids are chosen where no argument determines them
    exact = not theory and methods.get("formulation") != "marching"
    has_friction = not isinstance(case.friction, float) or 0 < case.friction < np.inf
    free = all(each is None for each in (case.dx, case.dy, start, methods.get("start")))
    if target is None and exact and has_friction and free:
        target = Target(BY_DEFAULT, by_default=True)
    if target is not None:
        return (yield from _to_target(case, tol, methods, target, on_first))
    found = yield from _on_elements(case, tol, methods, start)
    if (
        case.conformal == "auto"
        and not theory
        and any(too_wide(case, each) for each in found[0].patches)
    ):
        # a profile that turns too fast or is too rough: the warning tells
        with suppress(NotConverged, SceneError):
            found = yield from _on_elements(replace(case, conformal=True), tol, methods)
    return found


def _target(case: WheelOnRail, methods: dict[str, Any], theory: bool) -> Target | None:
    """The accuracy or time budget that grids are chosen for, if one is given; what a wheel has not
    is refused.
    """
    checks.gone("refine", methods.get("refine"), checks.REFINE_BECAME)
    if methods.get("store") is not None:
        raise SceneError("store", methods["store"], "left out: it is for histories of steps")
    if case.conformal is True and theory:
        reason = "tangential: theories are for ellipses in a plane; leave it out, or give conformal = False"
        raise SceneError("tangential", methods["tangential"], message=reason)
    target = {name: methods[name] for name in TARGETS if methods.get(name) is not None}
    if target:
        checks.exactly_one(**target)
    for name, value in target.items():
        checks.positive(name, value)
        for side in ("dx", "dy"):
            if getattr(case, side) is not None:
                reason = (
                    f"{side}: the grids are chosen for the {name}; leave dx and dy out, or {name}"
                )
                raise SceneError(side, getattr(case, side), message=reason)
        if theory:
            reason = (
                f"tangential: a theory has an error that no grid removes; leave it out, or {name}"
            )
            raise SceneError("tangential", methods["tangential"], message=reason)
    return Target(**target) if target else None


def _on_elements(
    case: WheelOnRail,
    tol: float,
    methods: dict[str, Any],
    start: _Start | None = None,
    deadline: float = math.inf,
    second_order: bool = False,
) -> Steps[Solved]:
    """On elements of dx and dy; each height begins with what was found at the one before, or at the
    start.
    """
    search, by_theory = BearingHeight(case, tol), methods.get("tangential") in THEORIES
    before: list[Solution | Near] = []
    known: Sequence[Operators] = ()
    if start is not None:
        last, known = start.solution, start.operators
        before, frames = (
            [each.solution for each in last.patches],
            [each.frame for each in last.patches],
        )
        forces = [each.force for each in last.patches]
        normal, borne = (
            _vertical(frames, forces, False),
            _vertical(frames, forces, case.with_friction),
        )
        z = case.touching + (last.z - last.case.touching + start.deeper)
        search = BearingHeight(case, tol, z, (normal, borne))
    frictionless: list[ContactOnGrid] = []
    found: list[ContactOnGrid] = []
    for z in search:
        patches = _patches(case, z)
        if second_order:
            patches = tuple(replace(each, scene=each.scene.second_order()) for each in patches)
        scenes, frames = [patch.scene for patch in patches], [patch.frame for patch in patches]
        if case.z is None:
            bare = [replace(scene, motion=None, friction=None) for scene in scenes]
            near = [each.near for each in frictionless] or before
            frictionless = _contacts(bare, _for_pressure(methods), near, known, deadline=deadline)
            known = [each.disc.operators for each in frictionless]
            if not search.normal_forces_bear(
                _vertical(frames, [each.force for each in frictionless], False)
            ):
                continue
        if by_theory:
            solutions = [_by_theory(scene, methods) for scene in scenes]
            forces = [np.array([*each.force, each.normal_force]) for each in solutions]
        else:
            near = [each.near for each in found] or before or [each.near for each in frictionless]
            loaded = _contacts(scenes, methods, near, (), frictionless, deadline)
            if loaded:
                settled = yield loaded
                found = [
                    each.settled() if each is one else each
                    for each, one in zip(settled, loaded, strict=True)
                ]
            else:
                found = _contacts(scenes, methods, near, known, deadline=deadline)
            forces = [each.force for each in found]
        search.borne(_vertical(frames, forces, case.with_friction))
    if found:
        solutions = [each.solution() for each in found]
    solved = WheelRailSolution(
        case, search.z, tuple(map(PatchSolution, patches, solutions)), search.rounds
    )
    return solved, [each.disc.operators for each in found]


def _patches(case: WheelOnRail, z: float, with_grid: bool = True) -> tuple[ContactPatch, ...]:
    """The patches at a height, where those in parts have what each feels of the others."""
    patches = case.patches(z, with_grid=with_grid)
    return tuple(
        replace(each, scene=weakened(each.scene, each.seams)) if each.seams else each
        for each in patches
    )


def _contacts(
    scenes: list[Scene],
    methods: dict[str, Any],
    near: Sequence[Solution | Near],
    known: Sequence[Operators],
    frictionless: Sequence[ContactOnGrid] = (),
    deadline: float = math.inf,
) -> list[ContactOnGrid]:
    """The contacts of patches, from others of theirs and with their influence numbers, if there are
    as many.

    Of `frictionless` ones with their pressures, and tractions to begin with; none where these
    change a pressure.
    """
    contacts: list[ContactOnGrid] = []
    for k, scene in enumerate(scenes):
        options = replace(SolveOptions.checked(scene, **methods), deadline=deadline)
        start = near[k] if len(near) == len(scenes) else None
        own = known[k] if len(known) == len(scenes) else None
        loaded = frictionless[k].loaded(scene, options, start) if frictionless else None
        if frictionless and loaded is None:
            return []
        contacts.append(loaded or ContactOnGrid.of(scene, options, start, own))
    kept = [each.disc.operators for each in contacts]
    for each in known:
        if each not in kept:
            each.forget()
    return contacts


def _to_target(
    case: WheelOnRail,
    tol: float,
    methods: dict[str, Any],
    target: Target,
    on_first: Callable[[WheelRailSolution], None],
) -> Steps[Solved]:
    """To an accuracy or within a time, with error bars; on a curved surface where a plane is too
    flat.
    """
    started = time.perf_counter()
    first = yield from _first(case, tol, methods, target, started)
    on_first(first)
    if case.conformal == "auto" and any(too_wide(case, each) for each in first.patches):
        curved = replace(case, conformal=True)
        # a profile that turns too fast or is too rough: the warning tells
        with suppress(NotConverged, SceneError):
            first_curved = yield from _first(curved, tol, methods, target, started)
            return (yield from _from_first(curved, tol, methods, target, first_curved, started))
    return (yield from _from_first(case, tol, methods, target, first, started))


def _first(
    case: WheelOnRail, tol: float, methods: dict[str, Any], target: Target, started: float
) -> Steps[WheelRailSolution]:
    """A first solution: the height, where the contacts are, and whether noise dominates them."""
    rough, methods = replace(case, dx=START[0], dy=START[1]), methods | {"certify": None}
    deadline = _deadline(target, started, few=True)
    try:
        first, _ = yield from _on_elements(rough, max(tol, START_TOL), methods, deadline=deadline)
    except OutOfTime:
        raise _too_short(target) from None
    return first


def _deadline(target: Target, started: float, few: bool) -> float:
    """When solvers end within a time; a few coarse grids may take longer."""
    if target.time_budget is None:
        return math.inf
    return started + LATE * target.time_budget + (COARSEST if few else 0.0)


def _too_short(target: Target) -> SceneError:
    allowed = "more seconds, or elements of dx and dy: even coarse ones take longer"
    return SceneError("time_budget", target.time_budget, allowed)


def _from_first(
    case: WheelOnRail,
    tol: float,
    methods: dict[str, Any],
    target: Target,
    first: WheelRailSolution,
    started: float,
) -> Steps[Solved]:
    """From a first solution to an accuracy; within a time on finer and finer elements.

    By default three sets of elements tell the error where grids cannot be chosen for an accuracy or
    do not reach it, and where noise dominates the pressure.
    """
    if target.accuracy is not None and not (target.by_default and noisy_patches(first)):
        try:
            return _to_accuracy(case, first.z, tol, methods, target), []
        except (NotConverged, SceneError) as error:
            if not target.by_default or (isinstance(error, SceneError) and str(error) != VARIES):
                raise
    return (yield from _on_finer_elements(case, tol, methods, target, first, started))


def _to_accuracy(
    case: WheelOnRail, near: float, tol: float, methods: dict[str, Any], target: Target
) -> WheelRailSolution:
    """On grids chosen for an accuracy: half of it for normal forces, half for tangential ones.

    Distances and frames are those of a height near that which bears the load. From there the normal
    forces grow by the power 3/2 of the depth; grids stay, so that forces do not jump.
    """
    assert target.accuracy is not None
    half = replace(target, accuracy=target.accuracy / 2)
    while True:
        found = _near(case, near, tol, methods, half)
        if abs(found.z - near) <= MOVED * min(each.patch.approach for each in found.patches):
            return found
        near = found.z


def _on_finer_elements(
    case: WheelOnRail,
    tol: float,
    methods: dict[str, Any],
    target: Target,
    first: WheelRailSolution,
    started: float,
) -> Steps[Solved]:
    """On elements that are finer by `RATIO` each time, three times or as often as the time allows.

    Forces are those of the last, without extrapolation: they bear the load. The last three tell the
    errors.
    """
    ends = 0.0 if target.time_budget is None else started + target.time_budget
    n = float(ACROSS if target.time_budget is None else FIRST)
    solved: list[WheelRailSolution] = []
    operators: list[Operators] = []
    seconds = 0.0
    while len(solved) < GRIDS or seconds * RATIO**GROWTH < ends - time.perf_counter():
        begun = time.perf_counter()
        on_sides = _with_elements_across(case, first, n)
        start = _Start(solved[-1] if solved else first)
        deadline = _deadline(target, started, len(solved) < GRIDS)
        try:
            last, operators = yield from _on_elements(
                on_sides, tol, methods, start, deadline, second_order=True
            )
        except OutOfTime:
            if not solved:
                raise _too_short(target) from None
            break
        except NotConverged:
            if not solved:
                raise
            break
        solved.append(replace(last, case=case))
        seconds = time.perf_counter() - begun
        n *= RATIO
    return _with_errors(solved[-GRIDS:], target), operators


def _with_elements_across(case: WheelOnRail, first: WheelRailSolution, n: float) -> WheelOnRail:
    """The case with n elements across the smallest patch of a solution, and more of them along x,
    as `gridded` has.
    """
    contacts = [each.solution.pressure > 0 for each in first.patches]
    dx = START[0] * min(contact.any(axis=0).sum() for contact in contacts) / (RATIO * n)
    dy = START[1] * min(contact.any(axis=1).sum() for contact in contacts) / n
    return replace(case, dx=float(dx), dy=float(dy))


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
    case: WheelOnRail, patches: Sequence[PatchSolution], errors: list[float]
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


def _chosen(scene: Scene, methods: dict[str, Any], target: Target) -> Solution:
    """The solution on a grid that is chosen for the accuracy."""
    options = SolveOptions.checked(scene, **(methods | {"accuracy": target.accuracy}))
    found = adaptive.solve(scene, replace(options, target=target))
    assert isinstance(found, Solution)
    return found


def _near(
    case: WheelOnRail, near: float, tol: float, methods: dict[str, Any], target: Target
) -> WheelRailSolution:
    """To an accuracy, with the distances and frames of a height."""
    patches = _patches(case, near, with_grid=False)
    forces, force_errors = [], []  # at the approach of each patch
    for patch in patches:
        if patch.scene.coupled:  # tractions change the pressure
            held = _chosen(patch.scene, methods | {"certify": None}, target)
        else:
            bare = replace(patch.scene, motion=None, friction=None)
            held = _chosen(bare, _for_pressure(methods), replace(target, of_pressure=False))
        assert held.error_estimate is not None
        force_errors.append(held.error_estimate.largest)
        forces.append(held.normal_force)

    search = BearingHeight(case, tol, near)
    for z in search:
        deeper = [
            max(1 + (z - near) * np.cos(patch.angle) / patch.approach, 0.0) ** 1.5
            for patch in patches
        ]
        loads = [force * more for force, more in zip(forces, deeper, strict=True)]
        if case.z is None and not search.normal_forces_bear(
            float(np.cos([each.angle for each in patches]) @ loads)
        ):
            continue
        scenes = [
            replace(p.scene, approach=None, normal_force=load)
            for p, load in zip(patches, loads, strict=True)
        ]
        loaded = [
            PatchSolution(patch, _chosen(scene, methods, target))
            for patch, scene in zip(patches, scenes, strict=True)
        ]
        solved = tuple(map(_with_normal_error, loaded, _normal_errors(case, loaded, force_errors)))
        search.borne(
            _vertical(
                [each.frame for each in patches],
                [each.force for each in solved],
                case.with_friction,
            )
        )
    return WheelRailSolution(case, search.z, solved, search.rounds)


def _vertical(frames: Sequence[Frame], forces: Sequence[np.ndarray], with_friction: bool) -> float:
    """The vertical force on the rail; without friction that of the normal forces."""
    counts = np.array([with_friction, with_friction, True])
    return float(
        sum(frame.axes[2] @ (counts * force) for frame, force in zip(frames, forces, strict=True))
    )


def _for_pressure(methods: dict[str, Any]) -> dict[str, Any]:
    """What concerns the normal problem alone."""
    names = ("normal", "method", "accuracy")
    return {"certify": None} | {name: value for name, value in methods.items() if name in names}


def _by_theory(scene: Scene, methods: dict[str, Any]) -> Solution:
    """A patch by a theory, on an ellipse with its normal force."""
    normal = solve(replace(scene, motion=None, friction=None), **_for_pressure(methods))
    # Hertz's contact with the same second moments, a^2/5 and b^2/5
    grid, weights = normal.grid, normal.pressure / normal.pressure.sum()
    sides = []
    for axis, at, side in ((0, grid.x, grid.sides[0]), (1, grid.y, grid.sides[1])):
        along = weights.sum(axis=axis)
        sides.append(float(np.sqrt(5 * (along @ (at - along @ at) ** 2 + side**2 / 12))))
    f: Any = scene.friction
    # a theory has one: the mean by the pressure
    f = float(np.sum(weights * f)) if isinstance(f, np.ndarray) else f
    hertz: dict[str, Any] = {
        "surface": Ellipse(*sides),
        "approach": None,
        "normal_force": normal.normal_force,
    }
    scene = replace(scene, **hertz, friction=f, grid=Grid(nx=ON_ELLIPSE, ny=ON_ELLIPSE))
    return solve(scene, **{name: value for name, value in methods.items() if name != "normal"})
