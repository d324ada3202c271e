"""All patches of a wheel on a rail, and the height of its axle that bears the load."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from varcontact import checks
from varcontact.discrete.operators import Operators
from varcontact.errors import NotConverged, SceneError, VarcontactError
from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.quantities_of_interest import units
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, SampledDistance
from varcontact.solving.on_grid import ContactOnGrid, Near
from varcontact.solving.options import BY_DEFAULT, CertifyName, SolveOptions
from varcontact.solving.selection import MANY_PRESSURES
from varcontact.solving.side_by_side import settled_together
from varcontact.solving.solve import solve
from varcontact.system.process import one_blas_thread
from varcontact.theories.on_grid import THEORIES
from varcontact.wheel_rail.bearing_height import BearingHeight
from varcontact.wheel_rail.doubts import too_wide, warn
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution
from varcontact.wheel_rail.seams import weakened
from varcontact.wheel_rail.wheel_on_rail import VARIES, ContactPatch, WheelOnRail

SIDE_BY_SIDE = 32
"""Parts of a sweep whose tractions are solved for at a time."""
LEAP = 0.1
"""Change of the depth between positions, relative, from which the next one is not expected to follow it."""
ON_ELLIPSE = 32
"""Elements either way across the ellipse of a theory: as many at all heights, so that forces do not jump."""
TRIED = 4
"""Heights among which a time budget is divided."""
TARGETS = ("accuracy", "time_budget")
START = 0.5, 0.125
"""Sides of elements [mm] for the first height, where grids are chosen for an accuracy."""
START_TOL = 1e-3
"""Relative error of the load at that height."""
MOVED = 0.02
"""Change of the height, relative to the least approach, from which contacts are determined again."""
KEPT = 20.0
"""Change of the depth, relative and by tol, up to which planes and distances stay: forces feel a twentieth of it."""


Solved = tuple[float, int, tuple[PatchSolution, ...], list[Operators]]
"""Height of the axle, number of heights tried, the patches, and the operators on their grids."""
Kind = TypeVar("Kind")
Steps = Generator[list[ContactOnGrid], list[ContactOnGrid], Kind]
"""What gives contacts with their pressures, and is given them, some with tractions, until it has its result."""


def solve_wheel_on_rail(
    case: WheelOnRail, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelRailSolution:
    """See `WheelOnRail.solve`; `methods` has the arguments of `varcontact.solve`."""
    steps = _wheel(case, tol, certify, methods)
    try:
        waiting = next(steps)
        while True:
            waiting = steps.send(waiting)
    except StopIteration as end:
        found: WheelRailSolution
        found, used = end.value
    for each in used:
        each.forget()
    warn(found, stacklevel=5)
    return found


def solve_wheels_on_rails(
    cases: Sequence[WheelOnRail], tol: float = 1e-6, certify: CertifyName | None = None, **methods: Any
) -> Iterator[tuple[int, WheelRailSolution | VarcontactError]]:
    """The numbers of cases, and their solutions or what refuses them, as they are found, without `warn`.

    Parts of them are solved side by side, with all tractions at a time; within a part each begins from the one before,
    and as much deeper as that was than the one before it.
    """
    found: dict[int, WheelRailSolution | VarcontactError] = {}

    def part(numbers: list[int]) -> Steps[None]:
        last: WheelRailSolution | None = None
        depth = deeper = 0.0
        known: list[Operators] = []
        for k in numbers:
            given = {"start": last, **methods}
            try:
                last, known = yield from _wheel(cases[k], tol, certify, given, deeper, known)
                found[k] = last
                before, depth = depth, last.z - last.case.touching
                deeper = depth - before if abs(depth - before) < LEAP * depth else 0.0
            except VarcontactError as error:
                found[k] = error
            yield []
        for each in known:
            each.forget()

    order = sorted(range(len(cases)), key=lambda k: cases[k].side)
    parts = np.array_split(order, min(SIDE_BY_SIDE, len(cases))) if cases else []
    together = methods.keys().isdisjoint(("tangential", "method", "formulation"))
    waiting: list[tuple[Steps[None], list[ContactOnGrid]]] = [(part(each.tolist()), []) for each in parts]
    while waiting:
        flat, going = [contact for _, contacts in waiting for contact in contacts], []
        settled = settled_together(flat) if together else flat
        for steps, contacts in waiting:
            then = _advanced(steps, [settled.pop(0) for _ in contacts])
            if then is not None:
                going.append((steps, then))
            yield from found.items()
            found.clear()
        waiting = going


@one_blas_thread()
def _advanced(steps: Steps[None], settled: list[ContactOnGrid]) -> list[ContactOnGrid] | None:
    """What the steps wait for next; None at their end."""
    with suppress(StopIteration):
        return steps.send(settled) if settled else next(steps)
    return None


def _wheel(
    case: WheelOnRail,
    tol: float,
    certify: CertifyName | None,
    methods: dict[str, Any],
    deeper: float = 0.0,
    known: Sequence[Operators] = (),
) -> Steps[tuple[WheelRailSolution, list[Operators]]]:
    tol = checks.positive("tol", tol)
    if methods.get("store") is not None:
        raise SceneError("store", methods["store"], message="store must be left out: it is for histories of steps")
    if methods.get("refine") is not None:
        reason = "refine: it is for Hertz's pressure, and here the pressure is solved for; give accuracy instead"
        raise SceneError("refine", methods["refine"], message=reason)
    target = _target(case, methods)
    if case.conformal is True and methods.get("tangential") in THEORIES:
        reason = "tangential: theories are for ellipses in a plane; leave it out, or give conformal = False"
        raise SceneError("tangential", methods["tangential"], message=reason)
    methods = {name: value for name, value in methods.items() if name not in TARGETS}
    near = methods.pop("start") if isinstance(methods.get("start"), WheelRailSolution) else None
    # by default grids are chosen where no argument determines them, and the answer of a grid has an error
    exact = methods.get("tangential") not in THEORIES and methods.get("formulation") != "marching"
    has_friction = not isinstance(case.friction, float) or 0 < case.friction < np.inf
    given = (case.dx, case.dy, methods.get("start"))
    by_default = exact and has_friction and all(each is None for each in given) and case.conformal is not True
    if target:
        found = yield from _to_accuracy(case, tol, certify, methods, target)
    elif by_default:
        try:
            found = yield from _to_accuracy(case, tol, certify, methods, {"accuracy": BY_DEFAULT})
        except (NotConverged, SceneError) as error:  # with the usual elements there is an answer without an error bar
            if isinstance(error, SceneError) and str(error) != VARIES:
                raise
            found = yield from _on_elements(case, tol, certify, methods, near, deeper, known)
    else:
        found = yield from _on_elements(case, tol, certify, methods, near, deeper, known)
    chosen = case.conformal == "auto" and methods.get("tangential") not in THEORIES
    if chosen and any(too_wide(case, each) for each in found[2]):
        case, found = yield from _curved(case, found, tol, certify, methods, target)
    z, rounds, patches, used = found
    return WheelRailSolution(case, z, patches, rounds), used


def _curved(
    case: WheelOnRail,
    planar: Solved,
    tol: float,
    certify: CertifyName | None,
    methods: dict[str, Any],
    target: dict[str, Any],
) -> Steps[tuple[WheelOnRail, Solved]]:
    """The case on curved reference surfaces, or, where there are none, as it was on planes."""
    curved = replace(case, conformal=True)
    try:
        if target:
            return curved, (yield from _to_accuracy(curved, tol, certify, methods, target))
        return curved, (yield from _on_elements(curved, tol, certify, methods))
    except (NotConverged, SceneError):  # a profile that turns too fast or is too rough: the warning tells
        return case, planar


def _target(case: WheelOnRail, methods: dict[str, Any]) -> dict[str, Any]:
    """The accuracy or time budget that grids are chosen for, if one is given."""
    target = {name: methods[name] for name in TARGETS if methods.get(name) is not None}
    for name, value in target.items():
        checks.positive(name, value)
        for other in set(target) - {name}:
            raise SceneError(other, methods[other], message=f"{name} and {other} are both given: leave one out")
        for side in ("dx", "dy"):
            if getattr(case, side) is not None:
                reason = f"{side}: the grids are chosen for the {name}; leave dx and dy out, or {name}"
                raise SceneError(side, getattr(case, side), message=reason)
        if methods.get("tangential") in THEORIES:
            reason = f"tangential: a theory has an error that no grid removes; leave it out, or {name}"
            raise SceneError("tangential", methods["tangential"], message=reason)
    return target


def _on_elements(
    case: WheelOnRail,
    tol: float,
    certify: CertifyName | None,
    methods: dict[str, Any],
    near: WheelRailSolution | None = None,
    deeper: float = 0.0,
    known: Sequence[Operators] = (),
) -> Steps[Solved]:
    """On elements of dx and dy; each height begins with what was found at the one before, or at a position `near`.

    The first one is as deep as that position, or so much `deeper`; operators that are `known` serve again.
    """
    search, by_theory = BearingHeight(case, tol), methods.get("tangential") in THEORIES
    before: list[Solution | Near] = []
    if near is not None:
        before, touched = [each.solution for each in near.patches], [each.patch for each in near.patches]
        both = (
            _vertical(touched, [each.force for each in near.patches], all_of_it)
            for all_of_it in (False, case.with_friction)
        )
        search.begin(near.z - near.case.touching + deeper, *both)
    frictionless: list[ContactOnGrid] = []
    found: list[ContactOnGrid] = []
    placed, there = math.inf, tuple[ContactPatch, ...]()
    for z in search:
        if abs(z - placed) > KEPT * tol * (z - case.touching) or case.conformal is True:
            placed, there = z, case.patches(z)
        patches = there if z == placed else tuple(_deeper(patch, z - placed) for patch in there)
        scenes = [_scene(patch) for patch in patches]
        if case.z is None:
            bare = [_frictionless(scene) for scene in scenes]
            frictionless = _contacts(
                bare, None, _for_pressure(methods), [each.near for each in frictionless] or before, known
            )
            known = [each.disc.operators for each in frictionless]
            slope = math.nan
            if search.rounds == 1:
                slope = sum(
                    _stiffness(each) * np.cos(patch.angle) ** 2
                    for patch, each in zip(patches, frictionless, strict=True)
                )
            if not search.normal_forces_bear(_vertical(patches, [each.force for each in frictionless], False), slope):
                continue
        if by_theory:
            solutions = [_by_theory(scene, certify, methods) for scene in scenes]
            forces = [np.array([*each.force, each.normal_force]) for each in solutions]
        else:
            beside = [each.near for each in found] or before or [each.near for each in frictionless]
            loaded = _loaded(scenes, certify, methods, beside, frictionless)
            if loaded:
                settled = yield loaded
                found = [each.settled() if each is one else each for each, one in zip(settled, loaded, strict=True)]
            else:
                found = _contacts(scenes, certify, methods, beside, known)
            forces = [each.force for each in found]
        search.borne(_vertical(patches, forces, case.with_friction))
    if found:
        solutions = [each.solution() for each in found]
    used = [each.disc.operators for each in found]
    return search.z, search.rounds, tuple(map(PatchSolution, patches, solutions)), used


def _deeper(patch: ContactPatch, down: float) -> ContactPatch:
    """A patch with the axle further `down`, in the same plane."""
    approach = patch.approach + down * math.cos(patch.angle)
    return replace(patch, approach=approach, scene=replace(patch.scene, approach=approach))


def _contacts(
    scenes: list[Scene],
    certify: CertifyName | None,
    methods: dict[str, Any],
    near: Sequence[Solution | Near],
    known: Sequence[Operators],
) -> list[ContactOnGrid]:
    """The contacts of patches, from others of theirs and with their influence numbers, if there are as many."""
    found, progress = [], methods.get("progress")
    for k, scene in enumerate(scenes):
        options = _options(scene, certify, methods)
        start = near[k] if len(near) == len(scenes) else None
        own = known[k] if len(known) == len(scenes) else None
        found.append(ContactOnGrid.of(scene, options, progress, near=start, known=own))
    kept = [each.disc.operators for each in found]
    for operators in known:
        if operators not in kept:
            operators.forget()
    return found


def _loaded(
    scenes: list[Scene],
    certify: CertifyName | None,
    methods: dict[str, Any],
    near: Sequence[Solution | Near],
    frictionless: list[ContactOnGrid],
) -> list[ContactOnGrid]:
    """The contacts with their pressures and the tractions to begin with; none where tractions change a pressure."""
    found, progress = [], methods.get("progress")
    for k, each in enumerate(frictionless):
        start = near[k] if len(near) == len(scenes) else None
        found.append(each.loaded(scenes[k], _options(scenes[k], certify, methods), progress, start))
    return [each for each in found if each is not None] if all(found) else []


def _options(scene: Scene, certify: CertifyName | None, methods: dict[str, Any]) -> SolveOptions:
    return SolveOptions.checked(
        scene, certify=certify, **{name: value for name, value in methods.items() if name != "progress"}
    )


def _stiffness(frictionless: ContactOnGrid) -> float:
    """Of a contact without tractions, along its normal [N/mm]; NaN where its matrix is none of a few elements."""
    from scipy.linalg import cho_solve

    disc, elements = frictionless.disc, np.flatnonzero(frictionless.state.pressure)
    if elements.size > MANY_PRESSURES or disc.conformal or not disc.normal_problem().symmetric:
        return math.nan
    added = cho_solve(disc.operators.normal.on(elements).cholesky, np.ones(elements.size)).sum()
    return float(added * disc.lattice.area * disc.scales.force / disc.scales.displacement)


def _to_accuracy(
    case: WheelOnRail, tol: float, certify: CertifyName | None, methods: dict[str, Any], target: dict[str, Any]
) -> Steps[Solved]:
    """On grids chosen for an accuracy: half of it for normal forces, half for tangential ones.

    Distances and frames are those of a height near that which bears the load. From there the normal forces grow by
    the power 3/2 of the depth; grids stay, so that forces do not jump.
    """
    if case.z is None:
        rough = replace(case, dx=START[0], dy=START[1])
        near, *_ = yield from _on_elements(rough, max(tol, START_TOL), None, methods)
    else:
        near = case.z
    if "accuracy" in target:
        accuracy = target["accuracy"] / 2
    else:  # the one that the time for each patch and height gives
        scenes = _sampled_scenes(case, near)
        methods = methods | {"time_budget": target["time_budget"] / (TRIED * len(scenes))}
        accuracy = max(_estimate(solve(scene, certify=None, **methods)).largest for _, scene in scenes)
    methods = methods | {"accuracy": accuracy, "time_budget": None}
    while True:
        z, rounds, found = _near(case, near, tol, certify, methods)
        if abs(z - near) <= MOVED * min(each.patch.approach for each in found):
            return z, rounds, found, []
        near = z


def _near(
    case: WheelOnRail, near: float, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> tuple[float, int, tuple[PatchSolution, ...]]:
    """To an accuracy, with the distances and frames of a height."""
    patches = [replace(patch, scene=scene) for patch, scene in _sampled_scenes(case, near)]
    forces, force_errors = [], []  # at the approach of each patch
    for scene in (patch.scene for patch in patches):
        if scene.coupled:  # tractions change the pressure
            frictionless = solve(scene, certify=None, **methods)
            force_errors.append(_estimate(frictionless).largest)
        else:
            frictionless = _solve_pressure(scene, methods)
            force_errors.append(_estimate(frictionless).errors["normal_force"])
        forces.append(frictionless.normal_force)

    search = BearingHeight(case, tol, near)
    for z in search:
        deeper = [max(1 + (z - near) * np.cos(patch.angle) / patch.approach, 0.0) ** 1.5 for patch in patches]
        loads = [force * more for force, more in zip(forces, deeper, strict=True)]
        if case.z is None and not search.normal_forces_bear(float(np.cos([each.angle for each in patches]) @ loads)):
            continue
        scenes = [replace(p.scene, approach=None, normal_force=load) for p, load in zip(patches, loads, strict=True)]
        found = [
            (patch, solve(scene, certify=certify, **methods)) for patch, scene in zip(patches, scenes, strict=True)
        ]
        known = _load_error(case, found)
        errors = [error if known is None else known for error in force_errors]
        solved = tuple(PatchSolution(*each, error) for each, error in zip(found, errors, strict=True))
        search.borne(_vertical(patches, [each.force for each in solved], case.with_friction))
    return search.z, search.rounds, solved


def _estimate(solution: Solution) -> ErrorEstimate:
    assert solution.error_estimate is not None
    return solution.error_estimate


def _load_error(case: WheelOnRail, found: list[tuple[ContactPatch, Solution]]) -> float | None:
    """Relative error of the normal force of a single patch, which the load and the tangential force determine."""
    (patch, solution), estimate = found[0], found[0][1].error_estimate
    if case.z is not None or len(found) > 1 or estimate is None:
        return None
    if not case.with_friction or "Fy" not in estimate.errors:
        return 0.0
    # tangential forces grow with the normal force: it changes until all of the load is borne again
    lifting = abs(np.sin(patch.angle)) * estimate.errors["Fy"] * units(solution)["Fy"]
    return float(lifting / abs(patch.frame.axes[2] @ [*solution.force, solution.normal_force]))


def _sampled_scenes(case: WheelOnRail, z: float) -> list[tuple[ContactPatch, Scene]]:
    """The patches, and their scenes without a grid; of those in parts with what each feels of the others."""
    found = []
    for patch in case.patches(z, with_grid=False):
        scene = patch.scene
        if patch.seams:
            assert isinstance(scene.surface, SampledDistance)
            x, y = scene.surface.coordinates
            dx, dy = x[1] - x[0], y[1] - y[0]
            grid = Grid(nx=x.size, ny=y.size, dx=dx, dy=dy, x0=x[0] - dx / 2, y0=y[0] - dy / 2)
            surface = replace(scene.surface, x=None, y=None)
            weak = weakened(replace(scene, surface=surface, grid=grid), patch.seams).surface
            assert isinstance(weak, SampledDistance)
            scene = replace(scene, surface=replace(scene.surface, h=weak.h))
        found.append((patch, scene))
    return found


def _vertical(patches: Sequence[ContactPatch], forces: Sequence[np.ndarray], with_friction: bool) -> float:
    """The vertical force on the rail; without friction that of the normal forces."""
    if with_friction:
        return float(sum((patch.frame.axes @ force)[2] for patch, force in zip(patches, forces, strict=True)))
    return float(sum(force[2] * np.cos(patch.angle) for patch, force in zip(patches, forces, strict=True)))


def _frictionless(scene: Scene) -> Scene:
    return replace(scene, motion=None, friction=None)


def _for_pressure(methods: dict[str, Any]) -> dict[str, Any]:
    """What concerns the normal problem alone."""
    return {name: value for name, value in methods.items() if name in ("normal", "method", "accuracy")}


def _solve_pressure(scene: Scene, methods: dict[str, Any]) -> Solution:
    return solve(_frictionless(scene), certify=None, **_for_pressure(methods))


def _scene(patch: ContactPatch) -> Scene:
    return weakened(patch.scene, patch.seams) if patch.seams else patch.scene


def _by_theory(scene: Scene, certify: CertifyName | None, methods: dict[str, Any]) -> Solution:
    """A patch by a theory, on an ellipse with its normal force."""
    normal = _solve_pressure(scene, methods)
    # Hertz's contact with the same second moments, a^2/5 and b^2/5
    grid, weights = normal.grid, normal.pressure / normal.pressure.sum()
    a, b = (
        float(np.sqrt(5 * (along @ (at - along @ at) ** 2 + side**2 / 12)))
        for along, at, side in (
            (weights.sum(axis=0), grid.x, grid.sides[0]),
            (weights.sum(axis=1), grid.y, grid.sides[1]),
        )
    )
    ellipse = Grid(nx=ON_ELLIPSE, ny=ON_ELLIPSE)
    f: Any = scene.friction
    f = float(np.sum(weights * f)) if isinstance(f, np.ndarray) else f  # a theory has one: the mean by the pressure
    hertz: dict[str, Any] = {"surface": Ellipse(a, b), "approach": None, "normal_force": normal.normal_force}
    scene = replace(scene, **hertz, friction=f, grid=ellipse)
    return solve(scene, certify=certify, **{name: value for name, value in methods.items() if name != "normal"})
