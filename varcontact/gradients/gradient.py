"""Gradients of outputs of a solution by inputs of its scene, as a dataset."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.gradients.adjoint import Adjoint, LinearisedSolution
from varcontact.gradients.contact_fields import CREEPAGES, SHIFTS, creepages_of
from varcontact.gradients.following import Following, along_with_ellipse
from varcontact.gradients.inputs import derivative_unit, number_of, path_of, quantity_of
from varcontact.gradients.larger_elements import (
    difference,
    on_half_the_elements,
    output_on_half_the_elements,
)
from varcontact.gradients.linearised_contact import Edge
from varcontact.gradients.outputs import Creepage, Output, output_of
from varcontact.results.solution import Solution
from varcontact.scene import consistency
from varcontact.scene.motion import Shift, Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.units import IN_WORDS
from varcontact.system.process import one_blas_thread

if TYPE_CHECKING:
    import xarray as xr

FORCES = "Fx", "Fy"
LOADS = "normal_force", "approach"
SAMPLES = "surface.h", "surface.x", "surface.y"
SIDE = 1e-4
"""Least distance between the end of a step and a side of an element, in elements, at which
derivatives exist."""
NOT_ESTIMATED = {"error": "not estimated: error=True estimates it"}
"""Attribute of a dataset without errors."""
EdgeName = Literal["auto", "held", "moving", "following"]
"""Treatment of the contact edge as an input changes, see `Solution.gradient`."""


@one_blas_thread()
def gradient(
    solution: Solution, output: Any, by: Any, edge: EdgeName = "auto", error: bool | None = None
) -> xr.Dataset:
    """See `Solution.gradient`."""
    checks.choice("edge", edge, get_args(EdgeName))
    if error is not None:
        checks.flag("error", error)
    check_differentiable(solution)
    outputs = _listed(output)
    inputs = _listed(by)
    _check_different(outputs)
    request = _Request(
        outputs=dict(output_of(each) for each in outputs),
        inputs={name: path_of(name) for name in inputs},
        edge=edge,
    )
    request.check(solution)
    found = request.about(solution)
    derivatives = request.values(found)
    errors: dict[str, np.ndarray] = {}
    attributes = NOT_ESTIMATED
    if error or (error is None and request.moves(found)):
        try:
            errors = _errors(solution, request, derivatives)
        except SceneError as refused:
            if error:
                raise
            attributes = {"error": f"not estimated: {refused}"}
    dataset = _dataset(solution, request, derivatives, errors, several=outputs is output)
    if not errors:
        dataset.attrs = attributes
    return dataset


def sensitivity(solution: Solution) -> np.ndarray:
    """See `Solution.sensitivity`."""
    motion = solution.scene.motion
    if motion is None:
        raise SceneError("motion", None, "given: without it there is no creepage")
    _check_displacement(solution.scene)
    names = creepages_of(motion)
    found = gradient(_with_creepages(solution), list(FORCES), names, edge="held")
    return np.array([found[name] for name in names]).T


def _with_creepages(solution: Solution) -> Solution:
    """Solution of the scene that prescribes the creepages found for the forces."""
    motion: Any = solution.scene.motion
    if motion.Fx is None and motion.Fy is None:
        return solution
    rigid = dict(zip(creepages_of(motion), map(float, solution.creepage), strict=True))
    if isinstance(motion, TimeStep):  # creepages of a step include its shifts
        rigid = dict.fromkeys(SHIFTS, 0.0) | rigid
    prescribed = replace(motion, Fx=None, Fy=None, **rigid)
    return replace(solution, scene=replace(solution.scene, motion=prescribed))


def _listed(named: Any) -> Any:
    """Names as a list: a list or tuple unchanged, a single name as a list of one."""
    if isinstance(named, list | tuple):
        return named
    return [named]


def _check_different(outputs: Any) -> None:
    """Refuse several outputs with the same name."""
    names = [output_of(each)[0] for each in outputs]
    for name in names:
        if names.count(name) > 1:
            raise SceneError("output", name, "given once; a Weighted takes a name of its own")


@dataclass(frozen=True)
class _Request:
    """Requested outputs and paths of inputs by name, and the treatment of the contact edge."""

    outputs: dict[str, Output]
    inputs: dict[str, str]
    edge: EdgeName

    def check(self, solution: Solution) -> None:
        """Refuse outputs and inputs that the scene does not have."""
        for argument, names in (("output", self.outputs), ("by", self.inputs)):
            if not names:
                raise SceneError(argument, [], "at least one")
        for name, output in self.outputs.items():
            check_output(solution, name, output)
        for path in self.inputs.values():
            _check_input(solution, path)

    def about(self, solution: Solution) -> list[_Derivatives]:
        """Derivatives of each output."""
        linearised = _Linearisations(solution)
        return [_Derivatives(linearised, output, self.edge) for output in self.outputs.values()]

    def values(self, found: list[_Derivatives]) -> dict[str, np.ndarray]:
        """Values of the outputs and their derivatives by input, (outputs, ...)."""
        derivatives = {
            name: np.array([each.by(path) for each in found]) for name, path in self.inputs.items()
        }
        return {**derivatives, "value": np.array([each.value for each in found])}

    def moves(self, found: list[_Derivatives]) -> bool:
        """True where an edge of the contact moves through the grid."""
        paths = self.inputs.values()
        return any(each.edge_of(path) == "moving" for each in found for path in paths)

    def on_half_the_elements(self, solution: Solution) -> dict[str, np.ndarray]:
        """Values of the gradient on elements twice as large."""
        grid = solution.grid
        outputs = {
            name: output_on_half_the_elements(output, grid) for name, output in self.outputs.items()
        }
        request = replace(self, outputs=outputs)
        return request.values(request.about(on_half_the_elements(solution)))


def _errors(
    solution: Solution, request: _Request, derivatives: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Differences to elements twice as large, by name."""
    coarse = request.on_half_the_elements(solution)
    return {
        name: difference(fine, coarse[name], solution.grid) for name, fine in derivatives.items()
    }


@dataclass(frozen=True, eq=False)
class _Linearisations:
    """A solution linearised with each kind of edge, shared by all outputs."""

    solution: Solution
    made: dict[Edge, LinearisedSolution] = field(default_factory=dict)

    def __call__(self, edge: Edge) -> LinearisedSolution:
        if edge not in self.made:
            self.made[edge] = LinearisedSolution.of(self.solution, edge)
        return self.made[edge]


class _Derivatives:
    """Derivatives of one output; adjoints are made when an input first needs them."""

    def __init__(self, about: _Linearisations, output: Output, edge: EdgeName) -> None:
        self._about = about
        self._solution = about.solution
        self._output = output
        self._edge = edge
        self._adjoints: dict[str, Adjoint] = {}
        self._following: Following | None = None

    @property
    def value(self) -> float:
        return self._output.value(self._about("held").fields)

    def by(self, path: str) -> float | np.ndarray:
        """Derivative of the output with respect to an input."""
        edge = self.edge_of(path)
        if edge == "following":
            scene_of, value = number_of(self._solution.scene, path)
            if _closed_form(self._solution):
                return along_with_ellipse(self._adjoint("held"), scene_of, value)
            return self._on_following_grid().along(scene_of, value)
        return _by(self._adjoint(edge), path)

    def edge_of(self, path: str) -> EdgeName:
        """The edge by default: following for load, surface and bodies, moving for distances, else
        held.

        Tractions of rolling and Hertz's pressure in closed form require it. A pressure that solves
        the grid's equations does not: elements enter it with zero pressure, and its derivative with
        held areas is that of the continuum, also of rough surfaces, whose peaks a stretched grid
        samples elsewhere.
        """
        solution = self._solution
        if self._edge != "auto":
            _check_edge(solution, self._edge, path)
            return self._edge
        if isinstance(solution.scene.motion, TimeStep):
            return "held"
        tractions = self._about("held").contact.moves and self._output.needs_motion
        if path == "distance" and tractions:
            _check_edge(solution, "moving", path)
            return "moving"
        moved = path in LOADS or path.startswith(("surface.", "bodies."))
        by_following = tractions or _closed_form(solution)
        if moved and by_following and not solution.grid.periodic:
            return "following"
        return "held"

    def _adjoint(self, edge: Any) -> Adjoint:
        if edge not in self._adjoints:
            self._adjoints[edge] = self._about(edge).adjoint(self._output)
        return self._adjoints[edge]

    def _on_following_grid(self) -> Following:
        if self._following is None:
            self._following = Following.of(self._about("held"), self._output)
        return self._following


def _closed_form(solution: Solution) -> bool:
    """True where the pressure is Hertz's."""
    return solution.plan.normal == "hertz"


def _by(adjoint: Adjoint, path: str) -> float | np.ndarray:
    """Derivative with respect to an input: by a formula if there is one, else by a difference of
    the Lagrangian.
    """
    scene = adjoint.about.solution.scene
    part, _, entry = path.partition(".")
    creepages = adjoint.about.fields.names
    if part == "motion" and entry in creepages:
        return adjoint.by_creepage(creepages.index(entry))
    if part == "motion" and entry in FORCES:
        return adjoint.by_force(FORCES.index(entry))
    if path == "distance":
        return adjoint.by_distance
    if path == "friction":
        if isinstance(scene.friction, np.ndarray):
            return adjoint.by_friction
        return float(adjoint.by_friction.sum())
    if path in LOADS and not adjoint.about.hertz:
        return adjoint.by_load
    return adjoint.along(*number_of(scene, path))


# --------------------------------------------------------------------------- checks


def check_differentiable(solution: Solution) -> None:
    """Refuse solutions without a gradient, by name."""
    scene = solution.scene
    if not solution.converged:
        raise SceneError("solution", "not converged", "converged: derivatives are about a solution")
    plan = solution.plan
    if plan.theory is not None or plan.coupling == "johnson":
        approximate = plan.coupling
        if plan.theory is not None:
            approximate = plan.tangential
        raise SceneError("solution", approximate, "by an exact method: this one is approximate")
    consistency.check_differentiable(scene)
    _check_stick(solution)


def _check_stick(solution: Solution) -> None:
    """Refuse full slip under a prescribed force: no creepage is unique."""
    scene = solution.scene
    motion = scene.motion
    if motion is None or scene.frictionless:
        return
    prescribed = [name for name in FORCES if getattr(motion, name) is not None]
    if prescribed and solution.elements["stick"] == 0:
        field = f"motion.{prescribed[0]}"
        allowed = "below the friction limit: in full slip no derivative is defined"
        raise SceneError(field, getattr(motion, prescribed[0]), allowed)


def check_output(solution: Solution, name: str, output: Output) -> None:
    """Refuse outputs that the scene does not have."""
    motion = solution.scene.motion
    if motion is None and output.needs_motion:
        raise SceneError("output", name, "one of normal contact: the scene has no motion")
    if isinstance(output, Creepage):
        force = FORCES[output.component]
        if getattr(motion, force) is None:
            raise SceneError("output", name, f"another one: it is prescribed, and {force} is not")


def _check_input(solution: Solution, path: str) -> None:
    """Refuse inputs that the scene does not have, or that follow from others."""
    scene = solution.scene
    part, _, entry = path.partition(".")
    _check_changes(solution, path)
    if path == "distance":
        return
    if path == "friction" and isinstance(scene.friction, np.ndarray):
        return
    if part == "surface" and isinstance(scene.surface, SampledDistance):
        _check_samples(path)
    if part == "motion":
        _check_motion(solution, entry)
    number_of(scene, path)


def _check_samples(path: str) -> None:
    """Refuse samples by their own name."""
    if path in ("surface", *SAMPLES):
        raise SceneError("by", path, '"distance": the undeformed distance of each element')


def _check_motion(solution: Solution, entry: str) -> None:
    """Refuse entries of the motion that follow from others, or without a derivative."""
    scene = solution.scene
    path = f"motion.{entry}"
    if entry in (*CREEPAGES, *SHIFTS):
        _check_displacement(scene)
    if entry == "dq":
        number_of(scene, path)
        _check_step(scene, solution)
    forced = {"vx": "Fx", "vy": "Fy", "ux": "Fx", "uy": "Fy"}
    if getattr(scene.motion, forced.get(entry, ""), None) is not None:
        raise SceneError("by", path, f"another input: it follows from {forced[entry]}")


def _check_step(scene: Scene, solution: Solution) -> None:
    """Refuse steps that end on a side of an element, where displacements have a vertical
    tangent.
    """
    steps = 1
    if getattr(scene.motion, "slip_difference", None) == "second-order":
        steps = 2
    for count in range(1, steps + 1):
        sides = count * scene.motion.dq / solution.grid.sides[0]
        if abs(sides % 1.0 - 0.5) < SIDE:
            allowed = "a step that ends on no side of an element: there is no derivative there"
            raise SceneError("motion.dq", scene.motion.dq, allowed)


def _check_changes(solution: Solution, path: str) -> None:
    """Refuse inputs that change pressures on parts of elements, or earlier steps."""
    part, _, entry = path.partition(".")
    tangential = part in ("motion", "friction") and entry != "dq"
    if solution.pressure_on_parts is not None and not tangential:
        allowed = '"centres": pressures on parts of elements have no gradient'
        raise SceneError("grid.edge", solution.grid.edge, allowed)
    if isinstance(solution.scene.motion, TimeStep) and not (tangential or path in LOADS):
        allowed = "the creepages, friction or load of the step: the steps before do not change"
        raise SceneError("by", path, allowed)


def _check_displacement(scene: Scene) -> None:
    """Refuse shifts in line contact whose displacements have no reference point."""
    if not scene.shift_undetermined or isinstance(scene.motion, Steady):
        return
    stiffness = "the stiffness of a step needs it"
    if scene.bodies.slides:
        raise SceneError("bodies.base", "smooth", f'"rigid" or a half-space: {stiffness}')
    raise SceneError("surface.reference_depth", None, f"given: in line contact {stiffness}")


def _check_edge(solution: Solution, edge: EdgeName, path: str) -> None:
    """Refuse a derivative that does not exist for the grid, the slip difference or the input."""
    motion = solution.scene.motion
    if edge != "held" and isinstance(motion, TimeStep):
        raise SceneError("edge", edge, '"held" in a step of a history')
    if edge == "moving" and isinstance(motion, Steady) and motion.slip_difference != "first-order":
        allowed = '"held", or slip_difference "first-order": the other reaches over two elements'
        raise SceneError("edge", edge, allowed)
    if edge == "following" and solution.grid.periodic:
        allowed = '"held" on a periodic grid: a grid that follows the contact changes the period'
        raise SceneError("edge", edge, allowed)
    given_by_elements = path == "friction" and isinstance(solution.scene.friction, np.ndarray)
    if edge == "following" and (path == "distance" or given_by_elements):
        raise SceneError(
            "edge", edge, f'"moving" or "held" by {path}, which moves no whole contact'
        )


# --------------------------------------------------------------------------- dataset


def _dataset(
    solution: Solution,
    request: _Request,
    derivatives: dict[str, np.ndarray],
    errors: dict[str, np.ndarray],
    several: bool,
) -> xr.Dataset:
    """Values of the outputs and derivatives by input, with units and errors; over outputs where
    there may be `several`.
    """
    import xarray as xr

    def variable(found: np.ndarray, attributes: dict[str, str]) -> Any:
        dims = ("output", "y", "x")[: found.ndim]
        if several:
            return dims, found, attributes
        return dims[1:], found[0], attributes

    grid = solution.grid
    units = solution.scene.units or IN_WORDS
    shift = isinstance(solution.scene.motion, Shift)
    own = [units.of(each.unit, grid.line, shift) for each in request.outputs.values()]
    variables: dict[str, Any] = {}
    for name, found in derivatives.items():
        below = "1"
        if name != "value":
            below = units.of(quantity_of(request.inputs[name]), grid.line, shift)
        quotients = [derivative_unit(each, below) for each in own]
        attributes = {"units": "; ".join(quotients)}
        variables[name] = variable(found, attributes)
        if errors:
            variables[f"{name}_error"] = variable(errors[name], attributes)
    coordinates: dict[str, Any] = {"output": list(request.outputs)}
    if not several:
        coordinates = {"output": next(iter(request.outputs))}
    if any(found.ndim == 3 for found in derivatives.values()):
        coordinates |= {"x": grid.x, "y": grid.y}
    return xr.Dataset(variables, coordinates)
