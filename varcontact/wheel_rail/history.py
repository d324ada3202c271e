"""Wheel that rolls in time or is shifted in place, step by step, each with the tractions of the
previous step.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, cast

import numpy as np

from varcontact import checks
from varcontact.discrete.contact_grid import Box, contact_box, interpolated
from varcontact.errors import SceneError, VarcontactError
from varcontact.kinematics import Creepages, Frame
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solving.methods import by_name
from varcontact.solving.options import CertifyName
from varcontact.solving.solve import solve
from varcontact.system.process import one_blas_thread
from varcontact.theories.on_grid import THEORIES
from varcontact.wheel_rail.curve import Curve
from varcontact.wheel_rail.locus import Overlap
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.patch_warnings import warn_of_patches
from varcontact.wheel_rail.patches import NOWHERE, Sides, Tangent
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.solve import without_plausibility_warnings
from varcontact.wheel_rail.wheel_geometry import ELEMENT, ContactPatch, WheelGeometry
from varcontact.wheel_rail.wheel_on_elements import Start, WheelOnElements, solved_alone
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

ROUNDED = 1e-9
"""Difference of sides of elements, divided by the sides, that counts as rounding."""


def _of_solve(given: Mapping[str, Any]) -> tuple[str, ...]:
    return checks.options_of(solve)


@checks.named_options(_of_solve)
@one_blas_thread()
def wheel_on_rail_history(
    wheels: Sequence[WheelOnRail],
    *,
    rolled: float | Sequence[float] | None = None,
    start: WheelRailSolution | None = None,
    tol: float = 1e-6,
    certify: CertifyName | None = None,
    **methods: Any,
) -> list[WheelRailSolution]:
    """A wheel on a rail in time: steps of transient rolling and shifts, one after the other.

    Elements lie on one lattice along the rail's surface, which moves forward with the wheel set in
    rolling and stays on the rail in a shift. The tractions of all patches of a step are where the
    next one begins: patches appear without tractions, move over the lattice, merge with what each
    of them has, and share it row by row where they split; one that lifts off leaves nothing.
    Warnings are those of the first step.

    Parameters
    ----------
    wheels : sequence of WheelOnRail
        The wheel at the end of each step: position, velocity, load, friction. Side, bodies and
        elements (`dx`, `dy`) are the same in all of them, patches are in planes.
    rolled : float or sequence, optional
        Distance rolled in each step [mm], one element if not given. 0 is a shift in place, by what
        the wheel moves over the rail in a second at its velocities.
    start : WheelRailSolution, optional
        Solution that the first step continues: steady rolling, or a step of a history; by default
        bodies without tractions.
    tol : float
        See `WheelOnRail.solve`.
    certify : str, optional
        See `varcontact.solve`.
    **methods
        Other arguments of `varcontact.solve`, but theories and targets.

    Returns
    -------
    list of WheelRailSolution
        One for each step. The creepages of shifts are lengths [mm], and an angle.

    Raises
    ------
    SceneError, NoContact, NotConverged
        See `WheelOnRail.solve`; and for what histories do not have: conformal patches, rigid slip
        by element, temperatures, rails whose profile varies. Errors name the step.

    Examples
    --------
    A wheel that is set down, and rolls on with a creepage: its force builds up.

    >>> from varcontact.wheel_rail import (
    ...     Profile, Track, Velocity, WheelOnRail, WheelSet, wheel_on_rail_history)
    >>> wheel = WheelOnRail(
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
    ...     wheelset=WheelSet(wheel=Profile.s1002(), radius=460.0),
    ...     velocity=Velocity(speed=1000.0, pitch_rate=-1002.0 / 460.0),
    ...     vertical_force=80e3, dx=1.0, dy=1.0)
    >>> steps = wheel_on_rail_history([wheel] * 3, rolled=1.0)
    >>> [f"{step.force[0] / 1e3:.1f} kN" for step in steps]
    ['-2.9 kN', '-5.6 kN', '-8.1 kN']
    """
    wheels = _checked(wheels, start)
    distances = _distances(rolled, wheels)
    named = by_name(methods)
    _check_methods(named)
    found: list[WheelRailSolution] = []
    before = start
    for k, (wheel, distance) in enumerate(zip(wheels, distances, strict=True)):
        try:
            with without_plausibility_warnings():
                before = _step(wheel, distance, before, tol, named | {"certify": certify})
        except VarcontactError as error:
            raise error.in_step(k, found) from error.__cause__
        if k == 0:
            warn_of_patches(before)
        found.append(before)
    return found


def _checked(
    wheels: Sequence[WheelOnRail], start: WheelRailSolution | None
) -> tuple[WheelOnRail, ...]:
    """Wheels of a history, checked to be consistent."""
    if not checks.is_array(wheels) or not len(wheels):
        raise SceneError("wheels", wheels, "a sequence of WheelOnRail, one for each step")
    before = None
    if start is not None:
        checks.kind("start", start, WheelRailSolution)
        _check_start(start)
        before = start.case
    for k, wheel in enumerate(wheels):
        checks.kind(f"wheels[{k}]", wheel, WheelOnRail)
        wheel.check_in_steps(f"wheels[{k}]")
        if before is not None:
            _check_same(f"wheels[{k}]", wheel, before)
        before = wheel
    return tuple(wheels)


def _check_same(field: str, wheel: WheelOnRail, before: WheelGeometry) -> None:
    """Refuse a step that continues another wheel, material or lattice."""
    for name in ("side", "bodies"):
        if getattr(wheel, name) != getattr(before, name):
            allowed = f"that of the step before, {getattr(before, name)!r}"
            raise SceneError(f"{field}.{name}", getattr(wheel, name), allowed)
    _check_sides(f"{field}.dx, dy", _sides(wheel), _sides(before))


def _check_start(start: WheelRailSolution) -> None:
    """Refuse a start on elements of other sides, or on a curved surface."""
    for each in start.patches:
        if not each.patch.in_plane:
            raise SceneError("start.case.conformal", True, "False: a history has planes")
        _check_sides("start", each.solution.grid.sides, _sides(start.case))


def _check_sides(field: str, sides: tuple[float, float], others: tuple[float, float]) -> None:
    if not np.allclose(sides, others, rtol=ROUNDED, atol=0):
        raise SceneError(field, sides, f"elements as those of the step before, {others}")


def _sides(wheel: WheelGeometry) -> tuple[float, float]:
    return wheel.dx or ELEMENT, wheel.dy or ELEMENT


def _distances(
    rolled: float | Sequence[float] | None, wheels: Sequence[WheelOnRail]
) -> list[float]:
    """The distance rolled in each step."""
    if rolled is None:
        return [_sides(wheel)[0] for wheel in wheels]
    if not checks.is_array(rolled):
        return [checks.at_least_zero("rolled", rolled)] * len(wheels)
    each = cast("Sequence[float]", rolled)
    if len(each) != len(wheels):
        raise SceneError("rolled", len(each), f"one number, or one for each of {len(wheels)} steps")
    return [checks.at_least_zero(f"rolled[{k}]", value) for k, value in enumerate(each)]


def _check_methods(methods: dict[str, Any]) -> None:
    """Refuse theories, and grids chosen for an accuracy."""
    if methods.get("tangential") in THEORIES:
        allowed = "left out: theories have no steps"
        raise SceneError("tangential", methods["tangential"], allowed)
    for name in ("accuracy", "time_budget", "store", "start"):
        if methods.get(name) is not None:
            allowed = "left out: the elements of a history are given"
            raise SceneError(name, methods[name], allowed)


def _step(
    wheel: WheelOnRail,
    rolled: float,
    before: WheelRailSolution | None,
    tol: float,
    methods: dict[str, Any],
) -> WheelRailSolution:
    """The wheel at the end of a step."""
    entries = {each.name: getattr(wheel, each.name) for each in fields(WheelGeometry)}
    case = _WheelInTime(**entries, rolled=rolled, before=before)
    nearby = None
    if before is not None:
        nearby = Start(before)

    found = solved_alone(_StepOnElements(case, tol, methods, nearby))
    return replace(found, case=wheel)


class _StepOnElements(WheelOnElements):
    """Wheel at one height after the other, with patches that are histories of one step."""

    patches_alone = True

    def _solve_patch(self, scene: Scene) -> Solution:
        return cast("Solution", solve(scene, **self._methods)[-1])


@dataclass(frozen=True, eq=False, kw_only=True)
class _WheelInTime(WheelGeometry):
    """Wheel at the end of a step, with patches that are scenes of that step."""

    rolled: float
    before: WheelRailSolution | None

    def patches(self, z: float, *, with_grid: bool = True) -> tuple[ContactPatch, ...]:
        """Patches at a height, each with the tractions of the previous step at its place."""
        found = super().patches(z)
        lattices = [self._placed(self, each.frame, _grid(each)) for each in found]
        left: list[list[_Left]] = [[] for _ in found]
        for last, wheel in self._last_patches:
            grid = self._placed(wheel, last.frame, last.solution.grid)
            for k, rows in _shares(grid, last.solution.pressure, lattices):
                left[k].append(_Left(grid, last.solution, rows))
        return tuple(map(self._in_time, found, lattices, left))

    @property
    def _last_patches(self) -> list[tuple[PatchSolution, WheelGeometry]]:
        """Patches of the previous step, each with its wheel."""
        if self.before is None:
            return []
        return [(patch, self.before.case) for patch in self.before.patches]

    def _patch(
        self, overlaps: list[Overlap], tangent: Tangent, z: float, sides: Sides
    ) -> ContactPatch:
        """Patch whose frame has its origin in the middle of an element of the lattice."""
        assert sides is not None
        frame = tangent.frame
        place = self._on_lattice(self, frame)
        moved = np.round(place / sides) * sides - place
        origin = frame.origin + frame.axes[:, :2] @ moved
        on_lattice = replace(tangent, frame=Frame(origin, frame.axes))
        return super()._patch(overlaps, on_lattice, z, sides)

    def creepage(self, frame: Frame, approach: float, z: float) -> Creepages:
        """Creepages, or the shift in a second."""
        if self.rolled > 0:
            return super().creepage(frame, approach, z)
        wheel = self.body(z)
        rail = self.track.rail_body(self.side)
        particle = frame.globally(np.array([0.0, 0.0, approach]))
        moved = rail.velocity_at(frame.origin) - wheel.velocity_at(particle)
        turned = rail.angular_velocity - wheel.angular_velocity
        ux, uy, _ = (frame.axes.T @ moved).tolist()
        return Creepages(ux, uy, float(frame.normal @ turned), 1.0)

    def _on_lattice(self, wheel: WheelGeometry, frame: Frame) -> np.ndarray:
        """Place of a frame along and across the rail's surface: in rolling the lattice moves with
        the wheel set.
        """
        x, y, _ = frame.origin.tolist()
        rail = wheel.rail
        if not isinstance(rail, Curve):
            rail = rail.section(x, y)
        if self.rolled == 0:
            x += wheel.position.s
        return np.array([x, float(rail.at(np.array([y]))[0])])

    def _placed(self, wheel: WheelGeometry, frame: Frame, grid: Grid) -> Grid:
        """A grid in a frame, by its place on the lattice."""
        sides = grid.sides
        x, y = (np.round(self._on_lattice(wheel, frame) / sides) * sides).tolist()
        left, _, bottom, _ = grid.box
        return replace(grid, x0=left + x, y0=bottom + y)

    def _in_time(self, patch: ContactPatch, lattice: Grid, left: Sequence[_Left]) -> ContactPatch:
        """Patch with the step as its motion, on elements that also contain the contacts `left` by
        the previous step.
        """
        scene = patch.scene
        padding = _padding(lattice, left)
        wider = _widened(scene, padding)
        (below, above), (before, behind) = padding
        on_lattice = lattice.window(-before, lattice.nx + behind, -below, lattice.rows + above)
        start = _start(left, on_lattice, wider["grid"], scene)
        creepage = patch.creepage
        names = ("vx", "vy", "spin")
        if self.rolled == 0:
            names = ("ux", "uy", "rotation")
        rigid: dict[str, Any] = dict(
            zip(names, (creepage.vx, creepage.vy, creepage.spin), strict=True)
        )
        motion = Transient(steps=1, dq=[self.rolled], start=start, **rigid)
        return replace(patch, scene=replace(scene, motion=motion, **wider))


@dataclass(frozen=True, eq=False)
class _Left:
    """Patch of the step before: rows of its solution, by their place on the lattice."""

    grid: Grid
    solution: Solution
    rows: np.ndarray

    @property
    def box(self) -> Box:
        """Bounding box of the contact."""
        return contact_box(self.grid, self.solution.pressure * self.rows[:, None])

    def on(self, grid: Grid, field: np.ndarray, fresh: float = 0.0) -> np.ndarray:
        """Field (..., ny, nx) on other elements of the lattice: its excess over the value of fresh
        particles, interpolated.
        """
        excess = (field - fresh) * self.rows[:, None]
        flat = excess.reshape(-1, *self.grid.shape)
        return interpolated(self.grid, flat, grid).reshape(*field.shape[:-2], *grid.shape)


def _grid(patch: ContactPatch) -> Grid:
    grid = patch.scene.grid
    assert isinstance(grid, Grid)
    return grid


def _shares(
    grid: Grid, pressure: np.ndarray, lattices: Sequence[Grid]
) -> Iterator[tuple[int, np.ndarray]]:
    """Numbers of the patches whose elements overlap a contact, and the rows that are nearest to
    each.
    """
    contact = contact_box(grid, pressure)
    met = [k for k, each in enumerate(lattices) if _meet(contact, each.box)]
    if not met:
        return
    boxes = np.array([lattices[k].box for k in met])
    beside = np.maximum(boxes[:, 2, None] - grid.y, grid.y - boxes[:, 3, None])
    nearest = beside.argmin(axis=0)
    for i, k in enumerate(met):
        rows = nearest == i
        if (pressure[rows] > 0).any():
            yield k, rows


def _meet(one: Box, other: Box) -> bool:
    """True if two boxes overlap."""
    along_x = one[0] < other[1] and other[0] < one[1]
    along_y = one[2] < other[3] and other[2] < one[3]
    return along_x and along_y


def _padding(lattice: Grid, left: Sequence[_Left]) -> tuple[tuple[int, int], tuple[int, int]]:
    """Additional elements below and above, before and behind, that contain the previous contacts,
    and a ring.
    """
    boxes = np.array([lattice.box, *(each.box for each in left)])
    x0, x1, y0, y1 = lattice.box
    dx, dy = lattice.sides
    more = [
        (y0 - boxes[:, 2].min()) / dy,
        (boxes[:, 3].max() - y1) / dy,
        (x0 - boxes[:, 0].min()) / dx,
        (boxes[:, 1].max() - x1) / dx,
    ]
    below, above, before, behind = (1 + round(each) for each in more)
    return (below, above), (before, behind)


def _widened(scene: Scene, padding: tuple[tuple[int, int], tuple[int, int]]) -> dict[str, Any]:
    """Grid, distance and friction of a scene on additional elements, where the bodies are far
    apart.
    """
    (below, above), (before, behind) = padding
    grid = scene.grid
    surface = scene.surface
    assert isinstance(grid, Grid)
    assert isinstance(surface, SampledDistance)
    wider = grid.window(-before, grid.nx + behind, -below, grid.rows + above)
    distance = np.pad(surface.h, padding, constant_values=NOWHERE * float(surface.h.max()))
    parts: dict[str, Any] = {"grid": wider, "surface": SampledDistance(distance)}
    if isinstance(scene.friction, np.ndarray):
        parts["friction"] = np.pad(scene.friction, padding, mode="edge")
    return parts


def _start(left: Sequence[_Left], lattice: Grid, grid: Grid, scene: Scene) -> Solution | None:
    """Fields of all previous contacts on the elements of a patch, as one solution; None if there
    are none.
    """
    if not left:
        return None
    fresh = scene.fresh

    def together(fields: Sequence[np.ndarray], fresh_value: float = 0.0) -> np.ndarray:
        parts = [
            each.on(lattice, field, fresh_value) for each, field in zip(left, fields, strict=True)
        ]
        return np.asarray(fresh_value + np.sum(parts, axis=0))

    names = ("traction", "pressure", "slip", "power_density", "state")
    on_elements: dict[str, Any] = {
        name: together([getattr(each.solution, name) for each in left]) for name in names
    }
    on_elements["state"] = on_elements["state"].round().astype(int)
    carried = {
        name: together([each.solution.carried[name] for each in left], fresh.get(name, 0.0))
        for name in left[0].solution.carried
    }
    return replace(
        left[0].solution, grid=grid, carried=carried, pressure_on_parts=None, **on_elements
    )
