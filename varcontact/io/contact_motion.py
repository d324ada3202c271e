"""Motions of CONTACT's basic contacts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.io.contact_cases import CaseInput
from varcontact.io.contact_elements import load_of
from varcontact.io.contact_geometry import Geometry
from varcontact.io.contact_words import Group
from varcontact.scene.motion import Steady
from varcontact.scene.transient import Transient

NO_MOTION, SHIFT, TRANSIENT, STEADY = range(4)
"""Values of the digit T."""


@dataclass(frozen=True)
class Rolling:
    """Direction (1 or -1), step and velocity; a shift lasts a second."""

    direction: int = 1
    step: float = 0.0
    velocity: float = 1.0
    spin_offset: float | None = None


def rolling_of(case: CaseInput, before: Rolling | None) -> Rolling:
    """Rolling as given, or as kept from the previous case."""
    if not case.controls.rolls:
        return Rolling()
    if "rolling" not in case.given:
        if before is None or case.before is None or not case.before.controls.rolls:
            why = "needs CHI, DQ and VELOC, which the case before does not give: use C = 2"
            case.controls.complain("TANG", why)
        return before
    group: Group = case.entries["rolling"]
    angle = group.angle(0)
    dq = group.number(1)
    velocity = group.number(2)
    directions = [each for each in (1, -1) if abs(np.cos(angle) - each) < 1e-3]
    moves = dq > 0 and velocity > 0
    if not directions or not moves:
        allowed = "must be 0 or 180d, and two positive numbers"
        group.refuse("CHI, DQ, VELOC", (angle, dq, velocity), allowed)
    spin_offset = None
    if group.optional:
        spin_offset = group.option(0, 0.0)
    return Rolling(directions[0], dq, velocity, spin_offset)


def rigid_of(
    case: CaseInput, friction: Any, bodies: Any
) -> tuple[dict[str, Any], tuple[float, float | None] | None]:
    """Creepages or shifts and forces, by the names of the motion; and forces as parts of the normal
    force, if that is known only with the pressure, else None.
    """
    first, second, spin = _about_origin(case)
    names = ("ux", "uy", "rotation")
    if case.controls.rolls:
        names = ("vx", "vy", "spin")
    count = case.controls["FORCE"]
    if count == 0:
        return dict(zip(names, (first, second, spin), strict=True)), None
    # the file has forces as parts of FSTAT FN
    static = 1.0
    if case.controls["VARFRC"] == 0:
        static = getattr(friction, "static", friction)
    given: dict[str, Any] = {names[2]: spin}
    forces: dict[str, float] = {"Fx": static * first}
    if count == 2:
        forces["Fy"] = static * second
    else:
        given[names[1]] = second
    normal = _normal_force(case, bodies)
    if normal is None:
        return given, (forces["Fx"], forces.get("Fy"))
    return given | {name: part * normal for name, part in forces.items()}, None


def _about_origin(case: CaseInput) -> tuple[float, float, float]:
    """CKSI or FX, CETA or FY, and CPHI, which may be given about another point."""
    group: Group = case.entries["kinematics"]
    _, first, second, spin = group.numbers()
    if len(group.optional) == 2:
        if case.controls["FORCE"] == 0:
            first += spin * group.option(1, 0.0)
        if case.controls["FORCE"] != 2:
            second -= spin * group.option(0, 0.0)
    return first, second, spin


def _normal_force(case: CaseInput, bodies: Any) -> float | None:
    """The normal force, where it is given or known by Hertz's formulas."""
    load = load_of(case)
    if "normal_force" in load:
        return float(load["normal_force"])
    if bodies.coupled:
        why = (
            "with N = 0 is not supported with unlike bodies: FX is a part of FSTAT FN, "
            "and FN is not known; use N = 1"
        )
        case.controls.complain("FORCE", why)
    return None


def steady_of(
    case: CaseInput, rolling: Rolling, rigid: dict[str, Any], geometry: Geometry
) -> Steady:
    """Steady rolling, with its speed where temperatures or relaxation need it."""
    more: dict[str, Any] = {"dq": rolling.step, "spin_offset": rolling.spin_offset}
    if geometry.bodies.relaxes or case.controls["HEAT"] != 0:
        more["speed"] = rolling.velocity
    if case.controls["EXRHS"] != 0:
        more["rigid_slip"] = _extra_slip(case, geometry)
    return Steady(**rigid, **more)


def _extra_slip(case: CaseInput, geometry: Geometry) -> np.ndarray:
    """The rigid slip of each element, x and y."""
    (group,) = case.needs("extra slip", "EXRHS", "an extra rigid slip", "E = 9")
    values = group.numbers()
    grid = geometry.grid
    if len(values) != 2 * grid.size:
        case.controls.complain("EXRHS", "keeps the rigid slip of other elements")
    if not hasattr(geometry.surface, "h"):
        case.controls.complain("EXRHS", "needs a contact by its distance, IPOTCN > 0")
    by_element = np.reshape(values, (*grid.shape, 2))
    return np.moveaxis(by_element, -1, 0)


def step_of(
    case: CaseInput, rolling: Rolling, given: dict[str, Any], friction: Any
) -> dict[str, Any]:
    """Motion and friction of one step in time, by the entries of its motion and load."""
    direction = rolling.direction
    dq = rolling.step
    if case.controls["TANG"] == SHIFT:
        direction = 1
        dq = 0.0
    step: dict[str, Any] = {name: [value] for name, value in given.items()}
    parts: dict[str, Any] = {}
    if isinstance(friction, np.ndarray):
        parts["friction"] = friction
    else:
        step["friction"] = [friction]
    if rolling.spin_offset is not None:
        step["spin_offset"] = rolling.spin_offset
    return parts | {"motion": Transient(steps=1, dq=[dq], direction=[direction], **step)}


def check_step(case: CaseInput, bodies: Any) -> None:
    """Refuse what only steady rolling has here."""
    if case.controls["EXRHS"] != 0:
        case.controls.complain("EXRHS", "is not supported but in steady rolling, T = 3")
    if bodies.relaxes or case.controls["HEAT"] != 0:
        case.controls.complain("TANG", "with viscoelastic bodies or heat needs T = 3")
