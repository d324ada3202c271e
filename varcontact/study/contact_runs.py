"""Cases of CONTACT's input files solved one after the other, and compared with what CONTACT
printed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from varcontact.elasticity.own import Elasticity
from varcontact.errors import SceneError, VarcontactError
from varcontact.io.contact_elements import ringed
from varcontact.io.contact_scenes import ContactCase
from varcontact.io.contact_stresses import extremes_below
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solving.solve import solve
from varcontact.theories.fastsim_contact import SimplifiedTheory, contact_fastsim

RINGED_ROW = 3
"""Elements across one row and the rows without contact beside it."""


@dataclass(frozen=True, eq=False)
class CaseRun:
    """A case that was solved, or the reason why it was not.

    `patches` has forces, creepages, approach and largest pressure of the contact by CONTACT's
    names, in its coordinates.
    """

    case: ContactCase
    solution: Solution | None = None
    reason: str = ""
    patches: list[dict[str, float]] = field(default_factory=list)
    note: str = ""
    stresses: tuple[dict[str, float], ...] = ()

    @property
    def solutions(self) -> dict[str, Solution]:
        """The solution by the ending of its file's name."""
        if self.solution is None:
            return {}
        return {"": self.solution}


def run_cases(cases: Iterable[ContactCase]) -> Iterator[CaseRun]:
    """Solve cases in order; a case that continues another starts from its tractions."""
    solved: dict[int, CaseRun] = {}
    for case in cases:
        run = _run(case, solved)
        solved[case.number] = run
        yield run


def _run(case: ContactCase, solved: dict[int, CaseRun]) -> CaseRun:
    if case.scene is None:
        return CaseRun(case, reason=case.reason)
    scene = case.scene
    try:
        if case.before is not None:
            start = solved[case.before.number].solution
            if start is None:
                return CaseRun(case, reason=f"goes on from case {case.before.number}, not solved")
            scene = _continued(scene, start)
        if case.simplified is not None:
            return _simplified(case, scene)
        scene = _with_forces(case, scene)
        solution, note = _solved_within(scene, case.methods)
    except VarcontactError as error:
        return CaseRun(case, reason=str(error))
    if case.methods.get("tangential") == "fastrip":
        note = "FaStrip is that of its paper here"
    values = values_of(case, solution)
    return CaseRun(case, solution, "", [values], note, stresses_of(case, solution))


def refined(case: ContactCase) -> ContactCase | None:
    """Case on elements of half the sides; None for one that continues another, or has values by
    element.
    """
    scene = case.scene
    if scene is None or case.before is not None or isinstance(scene.motion, Transient):
        return None
    surface = scene.surface
    grid = scene.grid
    assert isinstance(grid, Grid)
    by_element = isinstance(scene.friction, np.ndarray) or (
        isinstance(scene.motion, Steady) and scene.motion.rigid_slip is not None
    )
    if by_element or isinstance(scene.bodies, Elasticity):
        return None
    finer = grid.divided((2, 2))
    if isinstance(surface, SampledDistance):
        if min(grid.nx, grid.rows) <= RINGED_ROW or surface.inclination is not None:
            return None
        # samples are interpolated between the centres of elements
        finer = finer.window(1, 2 * grid.nx - 1, 1, 2 * grid.rows - 1)
        surface = SampledDistance(surface.h, grid.x, grid.y)
    return replace(case, scene=replace(scene, grid=finer, surface=surface), stress_points=())


def stresses_of(case: ContactCase, solution: Solution) -> tuple[dict[str, float], ...]:
    """Extremes of stresses at the points that the case asks for, by block."""
    return extremes_below(solution, case.stress_points, _sign(case))


def _simplified(case: ContactCase, scene: Scene) -> CaseRun:
    """Forces of CONTACT's simplified theory, as it marches over the elements."""
    assert case.simplified is not None
    theory = SimplifiedTheory(**case.simplified)
    pressure = None
    approach = {}
    if theory.elliptic is None:
        normal = {name: value for name, value in case.methods.items() if name == "normal"}
        solved, _ = _solved_within(scene.without_friction, normal)
        scene = replace(scene, grid=solved.scene.grid, surface=solved.scene.surface)
        pressure = solved.pressure
        normal_force = solved.normal_force
        approach = {"APPROACH": solved.approach}
    else:
        assert scene.hertz is not None
        normal_force = scene.hertz.force
    tractions = contact_fastsim(scene, theory, pressure)
    sign = _sign(case)
    Fx, Fy = tractions.force
    values = {
        "FN": normal_force,
        "FX": sign * float(Fx),
        "FY": float(Fy),
        "MZ": sign * tractions.moment,
        "PMAX": float(tractions.pressure.max()),
        **approach,
    }
    return CaseRun(case, None, "", [values], "simplified theory as CONTACT marches it")


def _solved_within(scene: Scene, methods: dict[str, Any]) -> tuple[Solution, str]:
    """The solution on the elements, and a note where the contact ends at their end."""
    try:
        return _solved(scene, methods), ""
    except SceneError as error:
        if error.field != "grid":
            raise
    note = "the contact reaches the end of the elements, and ends there"
    return _solved(ringed(scene), methods), note


def _solved(scene: Scene, methods: dict[str, Any]) -> Solution:
    solution = solve(scene, certify="none", **methods)
    if isinstance(solution, History):
        return solution[-1]
    assert isinstance(solution, Solution)
    return solution


def _continued(scene: Scene, start: Solution) -> Scene:
    """Step that continues a solution, also on other elements of the same sides."""
    motion = scene.motion
    assert isinstance(motion, Transient)
    return replace(scene, motion=replace(motion, start=start, interpolate=True))


def _with_forces(case: ContactCase, scene: Scene) -> Scene:
    """The scene with forces that are parts of the normal force, which is solved for."""
    if case.force_parts is None:
        return scene
    normal = _normal_force(scene, case.methods)
    along_x, along_y = case.force_parts
    assert along_x is not None
    forces: dict[str, Any] = {"Fx": _sign(case) * along_x * normal}
    if along_y is not None:
        forces["Fy"] = along_y * normal
    motion = scene.motion
    if isinstance(motion, Transient):
        steps: dict[str, Any] = {name: [force] for name, force in forces.items()}
        return replace(scene, motion=replace(motion, **steps))
    assert isinstance(motion, Steady | Shift)
    return replace(scene, motion=replace(motion, **forces))


def _sign(case: ContactCase) -> float:
    """Sign of quantities that change sign with x: -1 in a mirrored case."""
    if case.mirrored:
        return -1.0
    return 1.0


def _normal_force(scene: Scene, methods: dict[str, Any]) -> float:
    """The force at an approach, without tractions."""
    approach = scene.approach
    if isinstance(scene.motion, Transient):
        approach = scene.motion.of("approach", 0)
    bare = replace(scene.without_layer, motion=None, friction=None, thermal=None, approach=approach)
    normal = {name: value for name, value in methods.items() if name == "normal"}
    return _solved(bare, normal).normal_force


def values_of(case: ContactCase, solution: Solution) -> dict[str, float]:
    """Forces, creepages or shifts, approach and largest pressure by CONTACT's names."""
    sign = _sign(case)
    Fx, Fy = solution.force
    values = {
        "FN": solution.normal_force,
        "FX": sign * float(Fx),
        "FY": float(Fy),
        "MZ": sign * solution.moment,
        "APPROACH": solution.approach,
        "PMAX": float(solution.pressure.max()),
    }
    motion = solution.motion
    if motion is not None:
        along_x, along_y = solution.creepage[:2]
        names = ("SHIFT X", "SHIFT Y")
        if motion.rolls != 0:
            names = ("CREEP X", "CREEP Y")
        values |= dict(zip(names, (sign * along_x, along_y), strict=True))
    if solution.scene.thermal is not None and solution.temperature is not None:
        values["MAX(T1,T2)"] = float(solution.temperature[:, solution.pressure > 0].max())
    return values
