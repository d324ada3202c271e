"""Wheels of CONTACT's input files, module 1, solved one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from varcontact.errors import VarcontactError
from varcontact.wheel_rail.contact_input import WheelCase
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution


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
            solution = case.wheel.solve(certify="none")
        except VarcontactError as error:
            yield WheelRun(case, reason=str(error))
            continue
        yield WheelRun(case, solution, "", [values_of(patch) for patch in solution.patches])


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
