"""Wheels of CONTACT's input files, module 1, solved one after the other."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from varcontact.errors import NoContact, NotConverged, SceneError, VarcontactError
from varcontact.io.contact_stresses import extremes_below, points_of
from varcontact.results.solution import Solution
from varcontact.theories.fastsim_contact import SimplifiedTheory, contact_fastsim
from varcontact.wheel_rail.contact_cases import RailSprings, WheelCase
from varcontact.wheel_rail.history import wheel_on_rail_history
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.patches import joined, tangent_of
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.wheel_on_elements import vertical
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

WheelSolver = Callable[[WheelOnRail, WheelRailSolution | None], WheelRailSolution]
"""Function that solves a wheel, starting from a nearby solution."""
CREEP_MAX = 0.03
"""Largest creepage, of either sign, in the search for a longitudinal force or axle moment."""
CREEP_TOL = 1e-8
DEFLECTION_FIRST = 0.1
DEFLECTION_MAX = 12.8
"""First and largest lateral deflection of a rail that is tried, `DEFLECTION_FIRST` and this
[mm]."""
DEFLECTION_TOL = 1e-5
LOAD_TOL = 1e-5
"""Relative tolerance of the vertical force under simplified theory."""
LOAD_ROUNDS = 20


@dataclass(frozen=True, eq=False)
class WheelRun:
    """A wheel that was solved, or the reason why it was not; `patches`, and extremes of `stresses`
    by patch and block of points, by CONTACT's names.
    """

    case: WheelCase
    solution: WheelRailSolution | None = None
    reason: str = ""
    patches: list[dict[str, float]] = field(default_factory=list)
    stresses: tuple[dict[str, float], ...] = ()
    note: str = ""

    @property
    def solutions(self) -> dict[str, Solution]:
        """The solutions of the patches by the endings of their files' names."""
        if self.solution is None:
            return {}
        return {f"_{k}": each.solution for k, each in enumerate(self.solution.patches, 1)}


def refined(case: WheelCase) -> WheelCase | None:
    """The case on elements of half the sides; None of a step in time."""
    wheel = case.wheel
    if wheel is None or case.rolled is not None or wheel.dx is None or wheel.dy is None:
        return None
    finer = replace(wheel, dx=wheel.dx / 2, dy=wheel.dy / 2)
    return replace(case, wheel=finer, stresses=())


def run_wheels(cases: Iterable[WheelCase]) -> Iterator[WheelRun]:
    """Solve the wheels of cases in their order; a step in time begins with the tractions of the
    case before.
    """
    solved: dict[int, WheelRailSolution] = {}
    for case in cases:
        if case.wheel is None:
            yield WheelRun(case, reason=case.reason)
            continue
        if case.before is not None and case.before.number not in solved:
            yield WheelRun(case, reason=f"goes on from case {case.before.number}, not solved")
            continue
        try:
            if case.simplified is not None:
                yield _run_simplified(case, case.simplified)
                continue
            solution = _solved(case, _wheel_solver(case, solved))
            _check_angles(case, solution)
            _check_near_misses(case, solution)
            stresses = _stresses_below(case, solution)
        except VarcontactError as error:
            yield WheelRun(case, reason=str(error))
            continue
        solved[case.number] = solution
        patches = [values_of(patch) for patch in solution.patches]
        yield WheelRun(case, solution, "", patches, stresses)


def _run_simplified(case: WheelCase, theory: SimplifiedTheory) -> WheelRun:
    """A wheel under pressures of half-spaces, with tractions of simplified theory."""
    wheel = case.wheel
    assert wheel is not None
    bare = replace(wheel, friction=0.0)
    load = wheel.vertical_force
    solution = bare.solve(certify="none")
    patches, vertical_force = _marched(wheel, solution, theory)
    # the height at which all forces carry the load; that for normal forces alone is near
    rounds = 0
    while load is not None and abs(vertical_force - load) > LOAD_TOL * load:
        if rounds == LOAD_ROUNDS:
            residual = abs(vertical_force - load) / load
            raise NotConverged("the load under simplified theory was not met", residual)
        rounds += 1
        assert bare.vertical_force is not None
        bare = replace(bare, vertical_force=bare.vertical_force * load / vertical_force)
        solution = bare.solve(certify="none", start=solution)
        patches, vertical_force = _marched(wheel, solution, theory)
    _check_angles(case, solution)
    _check_near_misses(case, solution)
    return WheelRun(case, solution, "", patches, note="simplified theory as CONTACT marches it")


def _marched(
    wheel: WheelOnRail, solution: WheelRailSolution, theory: SimplifiedTheory
) -> tuple[list[dict[str, float]], float]:
    """Patches by CONTACT's names with tractions of simplified theory, and the vertical force."""
    found = []
    forces = []
    for patch, posed in zip(solution.patches, wheel.patches(solution.z), strict=True):
        grid = patch.solution.grid
        scene = replace(patch.solution.scene, grid=grid, friction=posed.scene.friction)
        scene = replace(scene, motion=posed.scene.motion)
        tractions = contact_fastsim(scene, theory, patch.solution.pressure)
        Fx, Fs = map(float, tractions.force)
        values = values_of(patch)
        found.append(values | {"FX": Fx, "FS": Fs, "MN": tractions.moment})
        forces.append(np.array([Fx, Fs, values["FN"]]))
    frames = [patch.patch.frame for patch in solution.patches]
    return found, vertical(frames, forces, with_friction=True)


def _stresses_below(case: WheelCase, solution: WheelRailSolution) -> tuple[dict[str, float], ...]:
    """Extremes of stresses below the patches, one patch after the other."""
    found: list[dict[str, float]] = []
    for patch in solution.patches:
        blocks = points_of(case.stresses, patch.solution.grid)
        found += extremes_below(patch.solution, blocks)
    return tuple(found)


def _wheel_solver(case: WheelCase, solved: Mapping[int, WheelRailSolution]) -> WheelSolver:
    """The solver of the wheels of a case: in steady rolling, or of a step in time."""
    rolled = case.rolled
    if rolled is None:
        return lambda wheel, near: wheel.solve(certify="none", start=near)
    before = None
    if case.before is not None:
        before = solved[case.before.number]

    def in_time(wheel: WheelOnRail, near: WheelRailSolution | None) -> WheelRailSolution:
        (step,) = wheel_on_rail_history([wheel], rolled=rolled, start=before, certify="none")
        return step

    return in_time


def _solved(case: WheelCase, solver: WheelSolver) -> WheelRailSolution:
    """Solved wheel of a case, with the motion or the rail position that gives its forces."""
    wheel = case.wheel
    assert wheel is not None
    if case.longitudinal_force is not None:
        return _with_pitch_rate(wheel, solver, _along_wheel_set, "FX", case.longitudinal_force)
    if case.axle_moment is not None:
        return _with_pitch_rate(wheel, solver, _about_axle, "MY", case.axle_moment)
    if case.springs is not None:
        return _on_springs(wheel, solver, case.springs)
    return solver(wheel, None)


def _along_wheel_set(solution: WheelRailSolution) -> float:
    """Force on the rail along the wheel set."""
    return -float(solution.force_on_wheelset[0])


def _about_axle(solution: WheelRailSolution) -> float:
    """Moment about the axle of the forces on the rail."""
    return -float(solution.moment_on_wheelset[1])


def _with_pitch_rate(
    wheel: WheelOnRail,
    solver: WheelSolver,
    quantity: Callable[[WheelRailSolution], float],
    name: str,
    goal: float,
) -> WheelRailSolution:
    """Solved wheel, with the pitch rate at which a quantity has its prescribed value."""
    rolling = -wheel.velocity.speed / wheel.wheelset.radius

    def solved(creep: float, near: WheelRailSolution | None) -> WheelRailSolution:
        velocity = replace(wheel.velocity, pitch_rate=rolling * (1 + creep))
        return solver(replace(wheel, velocity=velocity), near)

    def excess(creep: float, solution: WheelRailSolution) -> float:
        return quantity(solution) - goal

    search = _Search(solved, excess)
    if search(-CREEP_MAX) * search(CREEP_MAX) > 0:
        raise SceneError(name, goal, "at most what friction can carry")
    return search.root(-CREEP_MAX, CREEP_MAX, CREEP_TOL)


def _on_springs(wheel: WheelOnRail, solver: WheelSolver, springs: RailSprings) -> WheelRailSolution:
    """A wheel, with the deflection at which the springs carry the forces on the rail.

    The force of the springs is the preload less stiffness times deflection.
    """
    stiffness, _ = springs.stiffness
    preload, _ = springs.preload

    def solved(deflection: float, near: WheelRailSolution | None) -> WheelRailSolution:
        moved = _with_rail_moved(wheel, deflection, 0.0)
        return _on_vertical_spring(moved, solver, springs, near)

    def excess(deflection: float, solution: WheelRailSolution) -> float:
        return float(solution.force[1]) + preload - stiffness * deflection

    # to the side to which the rail is pushed, until the springs hold it
    search = _Search(solved, excess)
    pushed = search(0.0)
    reach = math.copysign(DEFLECTION_FIRST, pushed)
    while search(reach) * pushed > 0:
        if abs(reach) >= DEFLECTION_MAX:
            allowed = f"so large that a deflection of {DEFLECTION_MAX:g} mm is enough"
            raise SceneError("KYRAIL", stiffness, allowed)
        reach *= 2.0
    return search.root(0.0, reach, DEFLECTION_TOL)


def _on_vertical_spring(
    wheel: WheelOnRail, solver: WheelSolver, springs: RailSprings, near: WheelRailSolution | None
) -> WheelRailSolution:
    """A wheel with the vertical deflection of its rail."""
    _, stiffness = springs.stiffness
    _, preload = springs.preload
    if wheel.vertical_force is not None:
        lowered = 0.0
        if stiffness > 0:
            lowered = (wheel.vertical_force + preload) / stiffness
        return solver(_with_rail_moved(wheel, 0.0, lowered), near)
    assert wheel.z is not None
    highest = preload / stiffness
    touching = wheel.z - wheel.touching
    if highest >= touching:
        raise NoContact("z", wheel.z, f"more than {wheel.touching + highest:.6g} mm")

    def solved(deflection: float, near: WheelRailSolution | None) -> WheelRailSolution:
        return solver(_with_rail_moved(wheel, 0.0, deflection), near)

    def excess(deflection: float, solution: WheelRailSolution) -> float:
        return float(solution.force[2]) + preload - stiffness * deflection

    # where the wheel just touches there is no force
    search = _Search(solved, excess, {touching: preload - stiffness * touching})
    return search.root(highest, touching, DEFLECTION_TOL)


def _with_rail_moved(wheel: WheelOnRail, lateral: float, down: float) -> WheelOnRail:
    """The wheel on a rail that is deflected [mm]."""
    place = {"left": wheel.track.left, "right": wheel.track.right}[wheel.side]
    moved = replace(place, y=place.y + lateral, z=place.z + down)
    track: dict[str, Any] = {wheel.side: moved}
    return replace(wheel, track=replace(wheel.track, **track))


class _Search:
    """Search for the value at which a quantity of a wheel has no excess; each wheel is solved from
    the previous one.
    """

    def __init__(
        self,
        solved: Callable[[float, WheelRailSolution | None], WheelRailSolution],
        excess: Callable[[float, WheelRailSolution], float],
        known: Mapping[float, float] = MappingProxyType({}),
    ) -> None:
        self._solved = solved
        self._excess = excess
        self._known = dict(known)
        self._solutions: dict[float, WheelRailSolution] = {}
        self._near: WheelRailSolution | None = None

    def __call__(self, value: float) -> float:
        """The excess at a value."""
        if value not in self._known:
            self._near = self._solved(value, self._near)
            self._solutions[value] = self._near
            self._known[value] = self._excess(value, self._near)
        return self._known[value]

    def root(self, one: float, other: float, tol: float) -> WheelRailSolution:
        """The solution between two values whose excess has opposite signs."""
        from scipy.optimize import brentq

        value = brentq(self, one, other, xtol=tol)
        self(value)
        return self._solutions[value]


def _check_angles(case: WheelCase, solution: WheelRailSolution) -> None:
    """Refuse a patch that CONTACT would split by the angles of its parts."""
    wheel = solution.case
    for group in joined(wheel.locus.overlaps(solution.z), wheel.separate):
        angles = [tangent_of([overlap], wheel.rail).angle for overlap in group]
        if max(angles) - min(angles) > case.separating_angle:
            allowed = "at least the angle between parts of a patch: patches are parted by distance"
            raise SceneError("A_SEP", case.separating_angle, allowed)


def _check_near_misses(case: WheelCase, solution: WheelRailSolution) -> None:
    """Refuse a place where wheel and rail nearly touch, which moves CONTACT's patches."""
    gap = solution.case.locus.gap - solution.z
    inner = gap[1:-1]
    least = (inner <= gap[:-2]) & (inner <= gap[2:])
    near = inner[least & (inner > 0) & (inner < case.near_miss)]
    if near.size:
        allowed = f"at most {near.min():.3g} mm, a gap beside the patches, which counts there alone"
        raise SceneError("GAP_MISS", case.near_miss, allowed)


def values_of(patch: PatchSolution) -> dict[str, float]:
    """Forces, creepages, approach and largest pressure of a patch by CONTACT's names."""
    Fx, Fs, FN = map(float, patch.force)
    creepage = patch.patch.creepage
    return {
        "FN": FN,
        "FX": Fx,
        "FS": Fs,
        "MN": float(patch.moment),
        "CKSI": float(creepage.vx),
        "CETA": float(creepage.vy),
        "CPHI": float(creepage.spin),
        "APPROACH": float(patch.patch.approach),
        "PMAX": float(patch.solution.pressure.max()),
        "YCP(R)": float(patch.patch.on_rail[0]),
        "ZCP(R)": float(patch.patch.on_rail[1]),
    }
