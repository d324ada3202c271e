"""Methods of `solve` for the control digits by which CONTACT chooses its own."""

from __future__ import annotations

from typing import Any

from varcontact.io.contact_cases import CaseInput
from varcontact.io.contact_geometry import Geometry
from varcontact.io.contact_material import flexibility_of, kept_law
from varcontact.io.contact_motion import NO_MOTION, STEADY
from varcontact.scene.surfaces import Ellipse, Paraboloids

CONVEX_GS = 2
"""The control digit G of the one solver of CONTACT that takes any DQ in steady rolling."""
INITIAL_SLIP = {2: ("relaxation", 2), 3: ("relaxation", 2), 4: ("initial slip", 0)}
"""Entry and position of INISLP, by the digit G."""
SLIP_LAWS = (2, 3, 4)
"""Laws by slip velocity, values of the digit L."""
SIMPLIFIED = (2, 3)
FASTRIP = 5
"""Values of the digit M of which bodies are half-spaces here."""
THEORIES = {2: "fastsim-elliptic", 3: "fastsim"}
"""Theories of M = 2 and 3 by the digit B."""
BOUNDS = {2: (0, 2, 3, 4), 3: (0, 2, 3, 4), 5: (2, 3)}
"""Digits B of simplified theories by the digit M."""


def steps_by_elements(case: CaseInput) -> bool:
    """True in steady rolling, in which CONTACT steps by DX whatever DQ is, except with one
    solver.
    """
    solver = _solver(case)
    steady = case.controls["TANG"] == STEADY and case.calculated
    return steady and (solver is None or solver.controls["GAUSEI"] != CONVEX_GS)


def check_methods(case: CaseInput, geometry: Geometry) -> None:
    """Refuse prescribed pressures and simplified theories that are not supported here."""
    bound = case.controls["BOUND"]
    if bound >= 2 and geometry.bodies.coupled:
        why = "with unlike bodies is not supported: here their tractions change the pressure"
        case.controls.complain("BOUND", why)
    if bound == 4 and geometry.approach is None:
        case.controls.complain("BOUND", "needs two half-ellipses, IPOTCN = -6")
    wanted = BOUNDS.get(case.controls["MATER"])
    if wanted is None:
        return
    steady = case.controls["TANG"] == STEADY and case.controls["FORCE"] == 0
    if bound not in wanted or not steady:
        why = (
            f"is not supported: simplified theory here has B = {', '.join(map(str, wanted))} "
            "in steady rolling (T = 3) by creepages (F = 0)"
        )
        case.controls.complain("MATER", why)
    flexibility_of(case)


def methods_of(case: CaseInput, surface: Any) -> dict[str, Any]:
    """Arguments of `solve` by which CONTACT solves a case."""
    bound = case.controls["BOUND"]
    material = case.controls["MATER"]
    methods: dict[str, Any] = {}
    if isinstance(surface, Ellipse | Paraboloids) and bound == 0:
        methods["normal"] = "newton"
    if kept_law(case) in SLIP_LAWS and _slips_at_first(case):
        methods["start"] = "slip"
    if material == FASTRIP:
        methods["tangential"] = "fastrip"
    if material in SIMPLIFIED and bound in THEORIES:
        methods["tangential"] = THEORIES[bound]
    return methods


def simplified_theory_of(case: CaseInput) -> dict[str, Any] | None:
    """Entries of `SimplifiedTheory`, if M = 2 or 3 requests it; else None."""
    if case.controls["MATER"] not in SIMPLIFIED:
        return None
    flexibility, slope = flexibility_of(case)
    return {
        "elliptic": {2: True, 3: False}.get(case.controls["BOUND"]),
        "flexibility": flexibility,
        "slope": slope,
    }


def _slips_at_first(case: CaseInput) -> bool:
    """True where solvers start with slip everywhere: INISLP < 0 for G = 2, 3 or 4."""
    solver = _solver(case)
    if solver is None or case.controls["TANG"] == NO_MOTION:
        return False
    key, place = INITIAL_SLIP.get(solver.controls["GAUSEI"], ("", 0))
    return key != "" and solver.entries[key].number(place) < 0


def _solver(case: CaseInput) -> CaseInput | None:
    """Case that gives the solver: this one, or the one from which it is kept, if there is one."""
    found: CaseInput | None = case
    while found is not None and found.controls["GAUSEI"] == 1:
        found = found.before
    return found
