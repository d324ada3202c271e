"""Gradients of outputs of the patches of a wheel, through the geometry of wheel and rail.

A change of profile, position or load changes distance, approach and creepages of each patch, in
its own frame. The derivative of an output J at a height z of the axle is that of its Lagrangian, on
a grid that follows the contact, between the scenes that the geometry then gives, without a solve.
Under a prescribed load the height follows: ``dJ = J_theta - J_z V_theta / V_z``, with the vertical
force V of all patches.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.gradients.adjoint import LinearisedSolution
from varcontact.gradients.following import Following
from varcontact.gradients.gradient import NOT_ESTIMATED, check_differentiable, check_output
from varcontact.gradients.inputs import derivative_unit, number_of, quantity_of
from varcontact.gradients.outputs import Output, Weighted, output_of
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.units import MM_N
from varcontact.system.process import lazy_property, one_blas_thread
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.wheel_geometry import ContactPatch, WheelGeometry
from varcontact.wheel_rail.wheel_on_elements import patches_at

if TYPE_CHECKING:
    import xarray as xr

LENGTH_STEP = 1e-4
"""Step of the central difference of the geometry by a length [mm]: contact loci are smooth to
1e-9."""
ANGLE_STEP = 1e-6
"""Step of the central difference of the geometry by an angle [rad]."""
RELATIVE_STEP = 1e-5
"""Step of the central difference of the geometry by another number, relative to it."""
BESIDE = 6
"""Points of a profile on either side of a patch that still affect it through the spline."""

ANGLES = "roll", "yaw", "pitch"
POSITIONS = "y", *ANGLES
PROFILES = "rail", "wheel"
OF_LENGTH = (
    *("y", "z", *PROFILES, "gauge", "gauge_height", "radius"),
    *("inside_distance", "flange_back", "curve_radius"),
)
"""Entries of a case, and points of profiles, that are lengths."""

CaseOf = Callable[[float], WheelGeometry]


@one_blas_thread()
def gradient(solution: WheelRailSolution, output: Any, by: Any, error: bool = False) -> xr.Dataset:
    """See `WheelRailSolution.gradient`."""
    import xarray as xr

    checks.flag("error", error)
    case = solution.case
    if case.curved or not (case.track.constant and case.wheelset.constant):
        allowed = "planes, and profiles that do not vary: others have no gradient"
        raise case.not_in_planes(allowed)
    outputs = dict(output_of(each) for each in _listed(output))
    inputs = _listed(by)
    derivatives = _derivatives(solution, list(outputs.values()), inputs)
    coarse: dict[str, np.ndarray] = {}
    if error:
        coarse = _derivatives(_on_half_the_elements(solution), list(outputs.values()), inputs)
    own = [MM_N.of(each.unit) for each in outputs.values()]
    variables: dict[str, Any] = {}
    for name, found in derivatives.items():
        dims = ("output", "patch", f"{name}_point")[: found.ndim]
        below = "1"
        if name != "value":
            below = _unit_of(name)
        attributes = {"units": "; ".join(derivative_unit(each, below) for each in own)}
        variables[name] = dims, found, attributes
        if error:
            variables[f"{name}_error"] = dims, np.abs(found - coarse[name]), attributes
    dataset = xr.Dataset(variables, {"output": list(outputs)})
    if not error:
        dataset.attrs = NOT_ESTIMATED
    return dataset


def _derivatives(
    solution: WheelRailSolution, outputs: list[Output], inputs: Sequence[str]
) -> dict[str, np.ndarray]:
    """Values of the outputs (outputs, patches), and their derivatives by input."""
    wheel = _DifferentiableWheel.of(solution, outputs)
    derivatives = {"value": wheel.values}
    for name in inputs:
        if name == "vertical_force":
            derivatives[name] = wheel.by_load()
        elif name in PROFILES:
            derivatives[name] = wheel.by_profile(name)
        else:
            derivatives[name] = wheel.by_number(name)
    return derivatives


def _on_half_the_elements(solution: WheelRailSolution) -> WheelRailSolution:
    """The wheel solved on elements twice as large."""
    dx, dy = solution.patches[0].solution.grid.sides
    case: Any = replace(solution.case, dx=2 * dx, dy=2 * dy)
    coarse: WheelRailSolution = case.solve()
    if len(coarse.patches) != len(solution.patches):
        allowed = "False: on elements twice as large there are other patches"
        raise SceneError("error", True, allowed)
    return coarse


def _unit_of(name: str) -> str:
    """Unit of an input, in mm, N and rad."""
    entry = name.rpartition(".")[2]
    if entry in ANGLES:
        return "rad"
    if entry in OF_LENGTH:
        return MM_N.of("length")
    if name == "vertical_force":
        return MM_N.of("force")
    return MM_N.of(quantity_of(name))


def _listed(named: Any) -> Any:
    if isinstance(named, list | tuple):
        return named
    return [named]


@dataclass(frozen=True, eq=False)
class _DifferentiableWheel:
    """A solved wheel with the derivatives of outputs of its patches, and of their vertical
    forces.
    """

    solution: WheelRailSolution
    outputs: list[list[Following]]  # by output and patch
    vertical: list[Following]

    @classmethod
    def of(cls, solution: WheelRailSolution, outputs: list[Output]) -> _DifferentiableWheel:
        counts = float(solution.case.with_friction)
        linearised = []
        vertical = []
        for patch in solution.patches:
            check_differentiable(patch.solution)
            if patch.solution.pressure_on_parts is not None:
                allowed = "given with dx and dy: pressures on parts of elements have no gradient"
                raise SceneError("case.dx, case.dy", None, allowed)
            about = LinearisedSolution.of(patch.solution, "held")
            along_x, along_y, along_z = patch.frame.axes[2]
            force = Weighted(along_z, (counts * along_x, counts * along_y))
            linearised.append(about)
            vertical.append(Following.of(about, force))
        derivatives = []
        for output in outputs:
            for patch in solution.patches:
                check_output(patch.solution, type(output).__name__, output)
            derivatives.append([Following.of(about, output) for about in linearised])
        return cls(solution, derivatives, vertical)

    @property
    def values(self) -> np.ndarray:
        """Values (outputs, patches)."""
        return np.array([[each.held.value for each in row] for row in self.outputs])

    def by_load(self) -> np.ndarray:
        """Derivatives with respect to the vertical force."""
        if self.solution.case.vertical_force is None:
            raise SceneError("by", "vertical_force", "prescribed by the case; its z is")
        outputs, vertical = self._by_height
        return outputs / vertical

    def by_number(self, name: Any) -> np.ndarray:
        """Derivatives with respect to a number of the case: y, roll and yaw of the wheel set,
        friction, a length.
        """
        path = name
        if name in POSITIONS:
            path = f"position.{name}"
        case: Any = self.solution.case
        case_of, value = number_of(case, path)
        step = RELATIVE_STEP * (abs(value) or 1.0)
        if path.startswith("position."):
            step = LENGTH_STEP
        if path.rpartition(".")[2] in ANGLES:
            step = ANGLE_STEP

        def moved(change: float) -> WheelGeometry:
            moved_case: Any = case_of(value + change)
            return moved_case

        return self._bearing_load(moved, step)

    def by_profile(self, name: str) -> np.ndarray:
        """Derivatives with respect to the z of each point of a profile, (outputs, patches, points);
        zero for points that are far from all patches.
        """
        case = self.solution.case
        profile = case.wheelset.profile
        if name == "rail":
            profile = case.track.profile
        found = np.zeros((*self.values.shape, profile.y.size))
        for k in np.flatnonzero(self._near_patches(profile, name)).tolist():
            found[..., k] = self._bearing_load(partial(_with_point, case, name, k), LENGTH_STEP)
        return found

    def _near_patches(self, profile: Profile, name: str) -> np.ndarray:
        """Mask of the points of a profile at the patches, with some beside."""
        near = np.zeros(profile.y.size, bool)
        for patch in self.solution.patches:
            middle = patch.patch.on_rail[0]
            if name == "wheel":
                middle = patch.patch.on_wheel[0]
            half = max(abs(np.array(patch.solution.grid.box[2:])))
            near |= np.abs(profile.y - middle) <= half
        found = np.flatnonzero(near)
        if found.size:
            near[max(found[0] - BESIDE, 0) : found[-1] + BESIDE + 1] = True
        return near

    def _bearing_load(self, case_of: CaseOf, step: float) -> np.ndarray:
        """Derivatives (outputs, patches) by a change of the case, under its load or at its
        height.
        """
        z = self.solution.z
        outputs, vertical = self._differences(
            patches_at(case_of(step), z), patches_at(case_of(-step), z), 2 * step
        )
        if self.solution.case.vertical_force is None:
            return outputs
        by_height, vertical_by_height = self._by_height
        found: np.ndarray = outputs - by_height * (vertical / vertical_by_height)
        return found

    @lazy_property
    def _by_height(self) -> tuple[np.ndarray, float]:
        """Derivatives of the outputs (outputs, patches) and of the vertical force by the height."""
        case = self.solution.case
        z = self.solution.z
        above = patches_at(case, z + LENGTH_STEP)
        below = patches_at(case, z - LENGTH_STEP)
        return self._differences(above, below, 2 * LENGTH_STEP)

    def _differences(
        self, above: tuple[ContactPatch, ...], below: tuple[ContactPatch, ...], distance: float
    ) -> tuple[np.ndarray, float]:
        """Derivatives of the outputs (outputs, patches) and of the vertical force, between patches
        on either side.
        """
        solved = self.solution.patches
        if not len(above) == len(below) == len(solved):
            raise SceneError("by", "position", "one at which no patches join or part")
        outputs = np.zeros((len(self.outputs), len(solved)))
        vertical = 0.0
        counts = np.array([self.solution.case.with_friction] * 2 + [True])
        for k, (own, *beside) in enumerate(zip(solved, above, below, strict=True)):
            scenes = [_scene_near(own, each) for each in beside]
            for row, derivatives in enumerate(self.outputs):
                outputs[row, k] = derivatives[k].between(*scenes) / distance
            turned = beside[0].frame.axes[2] - beside[1].frame.axes[2]
            vertical += self.vertical[k].between(*scenes) / distance
            vertical += float(turned @ (counts * own.force)) / distance
        return outputs, vertical


def _with_point(case: WheelGeometry, name: str, k: int, change: float) -> WheelGeometry:
    """The case with one point of a profile moved along z."""
    profile = case.wheelset.profile
    if name == "rail":
        profile = case.track.profile
    z = profile.z.copy()
    z[k] += change
    moved = replace(profile, z=z)
    if name == "rail":
        return replace(case, track=replace(case.track, rail=moved))
    return replace(case, wheelset=replace(case.wheelset, wheel=moved))


def _scene_near(own: PatchSolution, patch: ContactPatch) -> Scene:
    """The scene of a patch nearby, on the elements of a solved one."""
    scene = own.solution.scene
    grid = own.solution.grid
    surface: Any = patch.scene.surface
    theirs: Any = patch.scene.grid
    motion: Any = patch.scene.motion
    distance = _on_elements(surface.samples, theirs, grid)
    entries: dict[str, Any] = {
        "surface": SampledDistance(distance),
        "approach": patch.approach,
        "bodies": patch.scene.bodies,
        "friction": patch.scene.friction,
    }
    if isinstance(patch.scene.friction, np.ndarray):
        entries["friction"] = _on_elements(patch.scene.friction, theirs, grid)
    if scene.motion is not None:
        slip = motion.rigid_slip
        if slip is not None:
            slip = np.array([_on_elements(each, theirs, grid) for each in slip])
        entries["motion"] = replace(
            scene.motion, vx=motion.vx, vy=motion.vy, spin=motion.spin, rigid_slip=slip
        )
    return replace(scene, **entries)


def _on_elements(field: np.ndarray, theirs: Grid, grid: Grid) -> np.ndarray:
    """A field (ny, nx) on the same lattice's elements of another grid; beyond, that of the edge."""
    places = []
    for own, other, side in zip(grid.lines, theirs.lines, grid.sides, strict=True):
        first = round((own[0] - other[0]) / side)
        places.append(first + np.arange(own.size - 1))
    along_x, along_y = places
    rows = np.clip(along_y, 0, field.shape[0] - 1)
    columns = np.clip(along_x, 0, field.shape[1] - 1)
    return np.asarray(field[np.ix_(rows, columns)])
