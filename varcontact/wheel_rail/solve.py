"""All patches of a wheel on a rail, and the height of its axle that bears the load."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from varcontact import checks
from varcontact.discrete.operators import Operators
from varcontact.errors import NotConverged, SceneError, VarcontactError
from varcontact.kinematics import Frame
from varcontact.results.quantities_of_interest import units
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse
from varcontact.solving.on_grid import ContactOnGrid, Near
from varcontact.solving.options import BY_DEFAULT, CertifyName, SolveOptions
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

Solved = tuple[WheelRailSolution, list[Operators]]
"""With the operators on the grids of its patches."""
Kind = TypeVar("Kind")
Steps = Generator[list[ContactOnGrid], list[ContactOnGrid], Kind]
"""What gives contacts with their pressures, and is given them, some with tractions, until it has its result."""


@dataclass(frozen=True, eq=False)
class _Start:
    """Where the search for a height begins: at that of a solution, so much deeper, with its operators if known."""

    solution: WheelRailSolution
    deeper: float = 0.0
    operators: Sequence[Operators] = ()


def solve_wheel_on_rail(
    case: WheelOnRail, tol: float, certify: CertifyName | None, methods: dict[str, Any]
) -> WheelRailSolution:
    """See `WheelOnRail.solve`; `methods` has the arguments of `varcontact.solve`."""
    ((_, found),) = solve_wheels_on_rails([case], tol, certify, **methods)
    if isinstance(found, VarcontactError):
        raise found
    warn(found, stacklevel=6)
    return found


def solve_wheels_on_rails(
    cases: Sequence[WheelOnRail], tol: float = 1e-6, certify: CertifyName | None = None, **methods: Any
) -> Iterator[tuple[int, WheelRailSolution | VarcontactError]]:
    """The numbers of cases, and their solutions or what refuses them, as they are found, without `warn`.

    Parts of them are solved side by side, with all tractions at a time; within a part each begins from the one before,
    and as much deeper as that was than the one before it.
    """
    found: dict[int, WheelRailSolution | VarcontactError] = {}
    methods["certify"] = certify

    def part(numbers: list[int]) -> Steps[None]:
        start, depth = None, 0.0
        for k in numbers:
            try:
                last, operators = yield from _wheel(cases[k], tol, methods, start)
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
    waiting: list[tuple[Steps[None], list[ContactOnGrid]]] = [(part(each.tolist()), []) for each in parts]
    while waiting:
        flat, going = [contact for _, contacts in waiting for contact in contacts], []
        settled = settled_together(flat) if together else flat
        for steps, contacts in waiting:
            with one_blas_thread(), suppress(StopIteration):
                own = [settled.pop(0) for _ in contacts]
                going.append((steps, steps.send(own) if own else next(steps)))
            yield from found.items()
            found.clear()
        waiting = going


def _wheel(case: WheelOnRail, tol: float, methods: dict[str, Any], start: _Start | None = None) -> Steps[Solved]:
    tol, theory = checks.positive("tol", tol), methods.get("tangential") in THEORIES
    target = _target(case, methods, theory)
    methods = {name: value for name, value in methods.items() if name not in TARGETS}
    if isinstance(methods.get("start"), WheelRailSolution):
        start = _Start(methods.pop("start"))
    # by default grids are chosen where no argument determines them, and the answer of a grid has an error
    exact = not theory and methods.get("formulation") != "marching" and case.conformal is not True
    has_friction = not isinstance(case.friction, float) or 0 < case.friction < np.inf
    free = all(each is None for each in (case.dx, case.dy, start, methods.get("start")))
    by_default = exact and has_friction and free and not target
    try:
        found = yield from _solved(case, tol, methods, {"accuracy": BY_DEFAULT} if by_default else target, start)
    except (NotConverged, SceneError) as error:  # with the usual elements there is an answer without an error bar
        if not by_default or (isinstance(error, SceneError) and str(error) != VARIES):
            raise
        found = yield from _solved(case, tol, methods, {})
    if case.conformal == "auto" and not theory and any(too_wide(case, each) for each in found[0].patches):
        with suppress(NotConverged, SceneError):  # a profile that turns too fast or is too rough: the warning tells
            found = yield from _solved(replace(case, conformal=True), tol, methods, target)
    return found


def _target(case: WheelOnRail, methods: dict[str, Any], theory: bool) -> dict[str, Any]:
    """The accuracy or time budget that grids are chosen for, if one is given; what a wheel has not is refused."""
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
                reason = f"{side}: the grids are chosen for the {name}; leave dx and dy out, or {name}"
                raise SceneError(side, getattr(case, side), message=reason)
        if theory:
            reason = f"tangential: a theory has an error that no grid removes; leave it out, or {name}"
            raise SceneError("tangential", methods["tangential"], message=reason)
    return target


def _on_elements(case: WheelOnRail, tol: float, methods: dict[str, Any], start: _Start | None = None) -> Steps[Solved]:
    """On elements of dx and dy; each height begins with what was found at the one before, or at the start."""
    search, by_theory = BearingHeight(case, tol), methods.get("tangential") in THEORIES
    before: list[Solution | Near] = []
    known: Sequence[Operators] = ()
    if start is not None:
        last, known = start.solution, start.operators
        before, frames = [each.solution for each in last.patches], [each.frame for each in last.patches]
        forces = [each.force for each in last.patches]
        normal, borne = _vertical(frames, forces, False), _vertical(frames, forces, case.with_friction)
        z = case.touching + (last.z - last.case.touching + start.deeper)
        search = BearingHeight(case, tol, z, (normal, borne))
    frictionless: list[ContactOnGrid] = []
    found: list[ContactOnGrid] = []
    for z in search:
        patches = _patches(case, z)
        scenes, frames = [patch.scene for patch in patches], [patch.frame for patch in patches]
        if case.z is None:
            bare = [replace(scene, motion=None, friction=None) for scene in scenes]
            near = [each.near for each in frictionless] or before
            frictionless = _contacts(bare, _for_pressure(methods), near, known)
            known = [each.disc.operators for each in frictionless]
            if not search.normal_forces_bear(_vertical(frames, [each.force for each in frictionless], False)):
                continue
        if by_theory:
            solutions = [_by_theory(scene, methods) for scene in scenes]
            forces = [np.array([*each.force, each.normal_force]) for each in solutions]
        else:
            near = [each.near for each in found] or before or [each.near for each in frictionless]
            loaded = _contacts(scenes, methods, near, (), frictionless)
            if loaded:
                settled = yield loaded
                found = [each.settled() if each is one else each for each, one in zip(settled, loaded, strict=True)]
            else:
                found = _contacts(scenes, methods, near, known)
            forces = [each.force for each in found]
        search.borne(_vertical(frames, forces, case.with_friction))
    if found:
        solutions = [each.solution() for each in found]
    solved = WheelRailSolution(case, search.z, tuple(map(PatchSolution, patches, solutions)), search.rounds)
    return solved, [each.disc.operators for each in found]


def _patches(case: WheelOnRail, z: float, with_grid: bool = True) -> tuple[ContactPatch, ...]:
    """The patches at a height, where those in parts have what each feels of the others."""
    patches = case.patches(z, with_grid=with_grid)
    return tuple(replace(each, scene=weakened(each.scene, each.seams)) if each.seams else each for each in patches)


def _contacts(
    scenes: list[Scene],
    methods: dict[str, Any],
    near: Sequence[Solution | Near],
    known: Sequence[Operators],
    frictionless: Sequence[ContactOnGrid] = (),
) -> list[ContactOnGrid]:
    """The contacts of patches, from others of theirs and with their influence numbers, if there are as many.

    Of `frictionless` ones with their pressures, and tractions to begin with; none where these change a pressure.
    """
    contacts: list[ContactOnGrid] = []
    for k, scene in enumerate(scenes):
        options = SolveOptions.checked(scene, **methods)
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


def _solved(
    case: WheelOnRail, tol: float, methods: dict[str, Any], target: dict[str, Any], start: _Start | None = None
) -> Steps[Solved]:
    """On elements, or on grids chosen for an accuracy: half of it for normal forces, half for tangential ones.

    Distances and frames are those of a height near that which bears the load. From there the normal forces grow by
    the power 3/2 of the depth; grids stay, so that forces do not jump.
    """
    if not target:
        return (yield from _on_elements(case, tol, methods, start))
    near = case.z
    if near is None:
        rough = replace(case, dx=START[0], dy=START[1])
        first, _ = yield from _on_elements(rough, max(tol, START_TOL), methods | {"certify": None})
        near = first.z
    if "accuracy" in target:
        accuracy = target["accuracy"] / 2
    else:  # the one that the time for each patch and height gives
        patches = _patches(case, near, with_grid=False)
        share = {"certify": None, "time_budget": target["time_budget"] / (TRIED * len(patches))}
        estimates = [solve(patch.scene, **(methods | share)).error_estimate for patch in patches]
        accuracy = max(each.largest for each in estimates if each is not None)
    while True:
        found = _near(case, near, tol, methods | {"accuracy": accuracy})
        if abs(found.z - near) <= MOVED * min(each.patch.approach for each in found.patches):
            return found, []
        near = found.z


def _near(case: WheelOnRail, near: float, tol: float, methods: dict[str, Any]) -> WheelRailSolution:
    """To an accuracy, with the distances and frames of a height."""
    patches = _patches(case, near, with_grid=False)
    forces, force_errors = [], []  # at the approach of each patch
    for patch in patches:
        coupled = patch.scene.coupled  # tractions change the pressure
        if coupled:
            held = solve(patch.scene, **(methods | {"certify": None}))
        else:
            held = solve(replace(patch.scene, motion=None, friction=None), **_for_pressure(methods))
        assert held.error_estimate is not None
        force_errors.append(held.error_estimate.largest if coupled else held.error_estimate.errors["normal_force"])
        forces.append(held.normal_force)

    search = BearingHeight(case, tol, near)
    for z in search:
        deeper = [max(1 + (z - near) * np.cos(patch.angle) / patch.approach, 0.0) ** 1.5 for patch in patches]
        loads = [force * more for force, more in zip(forces, deeper, strict=True)]
        if case.z is None and not search.normal_forces_bear(float(np.cos([each.angle for each in patches]) @ loads)):
            continue
        scenes = [replace(p.scene, approach=None, normal_force=load) for p, load in zip(patches, loads, strict=True)]
        solutions = [solve(scene, **methods) for scene in scenes]
        errors, estimate = force_errors, solutions[0].error_estimate
        if case.z is None and len(patches) == 1:  # the normal force is determined by the load and the tangential force
            errors, (patch,), (solution,) = [0.0], patches, solutions
            if estimate is not None and case.with_friction and "Fy" in estimate.errors:
                lifting = abs(np.sin(patch.angle)) * estimate.errors["Fy"] * units(solution)["Fy"]
                errors = [float(lifting / abs(patch.frame.axes[2] @ [*solution.force, solution.normal_force]))]
        solved = tuple(map(PatchSolution, patches, solutions, errors))
        search.borne(_vertical([each.frame for each in patches], [each.force for each in solved], case.with_friction))
    return WheelRailSolution(case, search.z, solved, search.rounds)


def _vertical(frames: Sequence[Frame], forces: Sequence[np.ndarray], with_friction: bool) -> float:
    """The vertical force on the rail; without friction that of the normal forces."""
    counts = np.array([with_friction, with_friction, True])
    return float(sum(frame.axes[2] @ (counts * force) for frame, force in zip(frames, forces, strict=True)))


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
    f = float(np.sum(weights * f)) if isinstance(f, np.ndarray) else f  # a theory has one: the mean by the pressure
    hertz: dict[str, Any] = {"surface": Ellipse(*sides), "approach": None, "normal_force": normal.normal_force}
    scene = replace(scene, **hertz, friction=f, grid=Grid(nx=ON_ELLIPSE, ny=ON_ELLIPSE))
    return solve(scene, **{name: value for name, value in methods.items() if name != "normal"})
