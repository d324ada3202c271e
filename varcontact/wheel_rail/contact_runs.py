"""Wheels of CONTACT's input files, module 1, solved one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from varcontact.errors import SceneError, VarcontactError
from varcontact.wheel_rail.contact_input import WheelCase
from varcontact.wheel_rail.patches import joined, tangent_of
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

CREEP_MAX = 0.03
"""Creepages between which a longitudinal force is sought."""
CREEP_TOL = 1e-8


@dataclass(frozen=True, eq=False)
class WheelRun:
    """A wheel that was solved, or the reason why it was not; `patches` by CONTACT's names."""

    case: WheelCase
    solution: WheelRailSolution | None = None
    reason: str = ""
    patches: list[dict[str, float]] = field(default_factory=list)


def run_wheels(cases: Iterable[WheelCase]) -> Iterator[WheelRun]:
    """Solve the wheels of cases in their order."""
    for case in cases:
        if case.wheel is None:
            yield WheelRun(case, reason=case.reason)
            continue
        try:
            solution = _solved(case.wheel, case.longitudinal_force)
            _check_angles(case, solution)
        except VarcontactError as error:
            yield WheelRun(case, reason=str(error))
            continue
        yield WheelRun(case, solution, "", [values_of(patch) for patch in solution.patches])


def _solved(wheel: WheelOnRail, force: float | None) -> WheelRailSolution:
    """A wheel, with the pitch rate that gives a force on the rail along the wheel set."""
    if force is None:
        return wheel.solve(certify="none")
    from scipy.optimize import brentq

    rolling = -wheel.velocity.speed / wheel.wheelset.radius
    found: dict[float, WheelRailSolution] = {}

    def excess(creep: float) -> float:
        velocity = replace(wheel.velocity, pitch_rate=rolling * (1 + creep))
        found[creep] = replace(wheel, velocity=velocity).solve(certify="none")
        along = wheel.position.rotation[:, 0]
        return float(along @ found[creep].force) - force

    if excess(-CREEP_MAX) * excess(CREEP_MAX) > 0:
        raise SceneError("FX", force, "at most what friction can carry")
    creep = brentq(excess, -CREEP_MAX, CREEP_MAX, xtol=CREEP_TOL)
    excess(creep)
    return found[creep]


def _check_angles(case: WheelCase, solution: WheelRailSolution) -> None:
    """Refuse a patch whose parts CONTACT parts by their angles."""
    wheel = solution.case
    for group in joined(wheel.locus.overlaps(solution.z), wheel.separate):
        angles = [tangent_of([overlap], wheel.rail).angle for overlap in group]
        if max(angles) - min(angles) > case.separating_angle:
            allowed = "at least the angle between parts of a patch: patches are parted by distance"
            raise SceneError("A_SEP", case.separating_angle, allowed)


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
