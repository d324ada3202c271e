"""A wheel on elements of given sides: heights of its axle until the patches balance the load."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from varcontact.discrete.operators import Operators
from varcontact.errors import NotConverged, SceneError
from varcontact.kinematics import Frame
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, SampledDistance
from varcontact.solvers.interface import check_time
from varcontact.solving.initial_guess import InitialGuess
from varcontact.solving.on_grid import ContactOnGrid
from varcontact.solving.options import SolveOptions
from varcontact.solving.solve import solve
from varcontact.system.process import changed
from varcontact.theories.on_grid import THEORIES
from varcontact.wheel_rail.bearing_height import BearingHeight
from varcontact.wheel_rail.patch_interaction import with_interaction
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.wheel_geometry import ELEMENT, ContactPatch, WheelGeometry

Item = TypeVar("Item")
ON_ELLIPSE = 32
"""Elements across the ellipse of a theory in either direction, the same at all heights so that
forces do not jump."""
LEAST_COSINE = 0.9
"""Cosine of the contact angle below which a patch moves too far with the height to give the next
one."""
ACROSS_FIRST = 8
"""Elements across the overlap of all patches in the search for the first height."""
COARSER = 16.0
"""Ratio of element areas above which a separate geometry on coarse elements pays off."""


@dataclass(frozen=True, eq=False)
class Start:
    """Start of the search for a height: the solution of a similar wheel, with its operators if
    known.
    """

    solution: WheelRailSolution
    operators: Sequence[Operators] = ()


@dataclass(frozen=True, eq=False)
class _Height:
    """Patches at a height of the axle, and their contacts: those with pressures, and those that are
    proposed.
    """

    patches: tuple[ContactPatch, ...] = ()
    pressed: Sequence[ContactOnGrid] = ()
    proposed: Sequence[ContactOnGrid] = ()

    @property
    def scenes(self) -> list[Scene]:
        return [each.scene for each in self.patches]

    @property
    def frames(self) -> list[Frame]:
        return [each.frame for each in self.patches]


class WheelOnElements:
    """A wheel at one height after the other.

    `propose` gives contacts with their pressures, and `learn` takes them back with their tractions,
    until `done`. Each height begins with what was found at the one before, or at the start.
    """

    def __init__(
        self,
        case: WheelGeometry,
        tol: float,
        methods: dict[str, Any],
        start: Start | None = None,
        *,
        deadline: float = math.inf,
        second_order: bool = False,
    ) -> None:
        self._case = case
        self._tol = tol
        self._methods = methods
        self._deadline = deadline
        self._second_order = second_order
        self.by_theory = methods.get("tangential") in THEORIES
        self._search = BearingHeight(case, tol)
        self._options: dict[int, SolveOptions] = {}
        self._height = _Height()
        # of the last height with tractions
        self._contacts: list[ContactOnGrid] = []
        self._solutions: list[Solution] = []
        # what the next height begins with, beside these contacts
        self._before: list[Solution] = []
        self._pressures: list[Solution | InitialGuess] = []
        self._operators: Sequence[Operators] = ()
        self._starts_near = False
        if start is not None:
            self._begin_at(start)

    def _begin_at(self, start: Start) -> None:
        last = start.solution
        self._before = [each.solution for each in last.patches]
        self._pressures = list(self._before)
        self._operators = start.operators
        self._starts_near = True
        known = vertical_forces(last)
        z = _height_near(self._case, last, known)
        self._search = BearingHeight(self._case, self._tol, z, known)

    @property
    def done(self) -> bool:
        """True if a height that carries the load is found."""
        return self._search.done

    def propose(self) -> list[ContactOnGrid]:
        """Contacts at the next height whose tractions come next; none when the search is done.

        Heights whose normal forces are far from the load, and contacts whose tractions change their
        pressures, are not proposed: they are learnt from here.
        """
        if self._search.rounds == 0 and not self._before:
            self._search.begin(self._first_height())
        while not self.done:
            self._expect_goal()
            self._move_to(self._search.propose())
            if not self._press_and_check():
                continue
            if self.patches_alone:
                self._solutions = [self._solve_patch(scene) for scene in self._height.scenes]
                self._learn_forces([_force(each) for each in self._solutions])
                continue
            proposed = self._with_pressures()
            if proposed:
                self._height = changed(self._height, proposed=proposed)
                return proposed
            self._contacts = self._solved()
            self._learn_forces([each.force for each in self._contacts])
        return []

    def learn(self, contacts: Sequence[ContactOnGrid]) -> None:
        """The contacts that were proposed, some with tractions; those of the others are solved for
        here.
        """
        if not contacts:
            return
        self._contacts = []
        for contact, proposed in zip(contacts, self._height.proposed, strict=True):
            if contact is proposed:
                contact = proposed.with_tractions()
            self._contacts.append(contact)
        self._learn_forces([each.force for each in self._contacts])

    def solution(self) -> WheelRailSolution:
        """The certified solution at the height that carries the load."""
        solutions = self._solutions or [each.solution() for each in self._contacts]
        # rolling radii, with which patches refer to no profile any more
        known = [replace(each, rolling_radius=each.rolling_radius) for each in self._height.patches]
        patches = tuple(map(PatchSolution, known, solutions))
        return WheelRailSolution(self._case, self._search.z, patches, self._search.rounds)

    def curved(self) -> WheelOnElements:
        """Wheel on the same elements, with contact on a curved surface."""
        return WheelOnElements(self._case.on_curved_surface(), self._tol, self._methods)

    @property
    def operators(self) -> list[Operators]:
        """Operators on the grids of the patches."""
        return [each.disc.operators for each in self._contacts]

    def _first_height(self) -> float:
        """Height at which the normal forces on coarse elements carry the load."""
        case = self._case
        if case.z is not None or case.curved:
            return self._search.z
        # elements on the overlap
        overlaps = case.locus.overlaps(self._search.z)
        along = np.ptp(np.concatenate([each.ends.ravel() for each in overlaps]))
        across = np.hypot(*np.ptp(np.concatenate([each.surface for each in overlaps]), axis=0))
        dx = case.dx or ELEMENT
        dy = case.dy or ELEMENT
        coarse_dx = max(dx, float(along) / ACROSS_FIRST)
        coarse_dy = max(dy, float(across) / ACROSS_FIRST)
        if coarse_dx * coarse_dy < COARSER * dx * dy:
            return self._search.z
        coarse = case.with_sides(coarse_dx, coarse_dy)
        wheel = WheelOnElements(coarse, self._tol, self._methods, deadline=self._deadline)
        # coarse elements may miss a contact that fine ones find
        with suppress(NotConverged, SceneError):
            z, self._pressures = wheel.height_by_pressures()
            self._starts_near = True
            return z
        return self._search.z

    def height_by_pressures(self) -> tuple[float, list[Solution | InitialGuess]]:
        """A height at which normal forces are near the load, and pressures to begin with there."""
        while not (self._search.near or self._search.expects):
            self._move_to(self._search.propose())
            if self._patch_tells:
                self._press_by_load()
            else:
                self._press()
        return self._search.propose(), self._pressures

    def _press_and_check(self) -> bool:
        """Press the contacts at a height; returns True if they nearly carry the load.

        At the first height, unless that is known to be near, the pressure itself is not needed: the
        solution under the load gives the next height.
        """
        if self._case.z is not None:
            return True
        if self._search.rounds == 1 and self._patch_tells and not self._starts_near:
            self._press_by_load()
            return False
        self._press()
        return self._search.near

    def _move_to(self, z: float) -> None:
        patches = patches_at(self._case, z)
        check_time(self._deadline)
        if self._second_order:
            patches = tuple(replace(each, scene=each.scene.second_order()) for each in patches)
        self._height = _Height(patches)

    @property
    def _patch_tells(self) -> bool:
        """True if the patch tells the height at which it bears a load: one alone, not too steep."""
        patches = self._height.patches
        if not self._case.patches_tell or len(patches) != 1:
            return False
        (patch,) = patches
        return not patch.interactions and float(patch.frame.axes[2, 2]) >= LEAST_COSINE

    def _press_by_load(self) -> None:
        """Solve the patch of a first height under the load alone; predicts the height that carries
        it, and estimates the force at the present height.
        """
        (patch,) = self._height.patches
        (contact,) = self._with_initial_guesses()
        loaded = self._under_goal(contact)
        self._operators = [loaded.disc.operators]
        about = self._search.goal * (patch.approach / loaded.approach) ** 1.5
        self._search.estimate_normal(about)
        self._expect(loaded)

    def _under_goal(self, contact: ContactOnGrid) -> ContactOnGrid:
        """The contact of the patch with the pressures that bear the goal of the search."""
        return contact.under(self._search.goal / float(self._height.patches[0].frame.axes[2, 2]))

    def _expect(self, loaded: ContactOnGrid) -> None:
        """The height at which the patch has the approach that it has under the goal."""
        (patch,) = self._height.patches
        deeper = (loaded.approach - patch.approach) / float(patch.frame.axes[2, 2])
        self._search.expect(self._search.z + deeper)
        self._pressures = [loaded.initial_guess]

    def _press(self) -> None:
        """The contacts with their pressures, and what these bear."""
        pressed = [each.with_pressure() for each in self._with_initial_guesses()]
        self._height = _Height(self._height.patches, pressed)
        self._pressures = [each.initial_guess for each in pressed]
        self._operators = [each.disc.operators for each in pressed]
        forces = [each.force for each in pressed]
        self._search.learn_normal(vertical(self._height.frames, forces, False))

    def _with_initial_guesses(self) -> list[ContactOnGrid]:
        """Contacts with the pressures from which their solution starts."""
        starts = self._pressures
        patches = self._height.patches
        if len(starts) != len(patches):
            starts = [_hertzian(each, self._case) for each in patches]
        scenes = self._height.scenes
        if self.patches_alone:
            scenes = [each.without_friction for each in scenes]
        contacts = []
        operators_of_each = _each_of(self._operators, scenes)
        for k, scene in enumerate(scenes):
            options = self._options_of(k, scene)
            contacts.append(
                ContactOnGrid.with_initial_guess(scene, options, starts[k], operators_of_each[k])
            )
        return contacts

    def _expect_goal(self) -> None:
        """The height at which the last patch, with its elements, bears the goal of the search."""
        pressed = self._height.pressed
        if pressed and self._patch_tells and not self._search.expects:
            self._expect(self._under_goal(pressed[0]))

    def _with_pressures(self) -> list[ContactOnGrid]:
        """Contacts with their pressures, and tractions to start from; empty where tractions change
        a pressure.
        """
        pressed = self._height.pressed
        if not pressed or not all(each.keeps_pressure for each in pressed):
            return []
        contacts = []
        starts = _each_of(self._traction_starts, self._height.scenes)
        for contact, start in zip(pressed, starts, strict=True):
            if start is not None:
                contact = contact.starting_from(start)
            contacts.append(contact)
        return contacts

    @property
    def patches_alone(self) -> bool:
        """True if patches are solved as separate scenes, as by a theory, and not proposed."""
        return self.by_theory

    def _solve_patch(self, scene: Scene) -> Solution:
        return _by_theory(scene, self._methods)

    def _solved(self) -> list[ContactOnGrid]:
        """Solved contacts of the patches, started from previous ones with their operators if there
        are as many.
        """
        scenes = self._height.scenes
        starts = _each_of(self._traction_starts or self._pressures, scenes)
        operators = _each_of(self._operators, scenes)
        contacts = []
        for k, scene in enumerate(scenes):
            options = self._options_of(k, scene)
            contacts.append(ContactOnGrid.of(scene, options, starts[k], operators[k]))
        return contacts

    def _options_of(self, k: int, scene: Scene) -> SolveOptions:
        """Options of patch k, checked at the first height, and again if its number of elements has
        changed much.
        """
        kept = self._options.get(k)
        if kept is None or not kept.suit(scene):
            methods = self._methods
            if self.patches_alone:
                methods = for_pressure(methods)
            kept = replace(SolveOptions.checked(scene, **methods), deadline=self._deadline)
            self._options[k] = kept
        return kept.like(scene)

    @property
    def _traction_starts(self) -> Sequence[Solution | InitialGuess]:
        if self._contacts:
            return [each.initial_guess for each in self._contacts]
        return self._before

    def _learn_forces(self, forces: list[np.ndarray]) -> None:
        self._search.learn(vertical(self._height.frames, forces, self._case.with_friction))


def solved_alone(wheel: WheelOnElements) -> WheelRailSolution:
    """The solution of a wheel whose tractions are solved for alone."""
    while not wheel.done:
        wheel.learn(wheel.propose())
    return wheel.solution()


def patches_at(case: WheelGeometry, z: float, with_grid: bool = True) -> tuple[ContactPatch, ...]:
    """Patches at a height; those of several parts with the interaction between these."""
    patches = []
    for each in case.patches(z, with_grid=with_grid):
        if each.interactions:
            each = replace(each, scene=with_interaction(each.scene, each.interactions))
        patches.append(each)
    return tuple(patches)


def _height_near(case: WheelGeometry, last: WheelRailSolution, known: tuple[float, float]) -> float:
    """Height at which the overlap presses as much as that of another wheel, scaled by the load over
    its known force.
    """
    before = last.case
    pressing = before.locus.pressing(last.z)
    _, borne = known
    if case.vertical_force is not None and borne > 0:
        pressing *= case.vertical_force / borne
    return case.locus.height_pressing(pressing, last.z - before.touching)


def _hertzian(patch: ContactPatch, case: WheelGeometry) -> InitialGuess:
    """Hertz-like pressures where the bodies overlap by half of the approach or more."""
    grid = patch.scene.own_grid
    surface = patch.scene.surface
    assert isinstance(surface, SampledDistance)
    overlap = np.maximum(1 - 2 * surface.distance(grid) / patch.approach, 0.0)
    radius = math.sqrt(np.count_nonzero(overlap) * grid.area / math.pi)
    modulus = case.bodies.combined_G / (1 - case.bodies.combined_nu)
    peak = 2 / math.pi * modulus * patch.approach / radius
    still = np.zeros((2, *grid.shape))
    return InitialGuess(grid, peak * np.sqrt(overlap), patch.approach, still, (0.0, 0.0))


def _each_of(known: Sequence[Item], scenes: Sequence[Scene]) -> list[Item | None]:
    """Known values by patch, if there are as many as patches; else None for each."""
    if len(known) == len(scenes):
        return list(known)
    return [None] * len(scenes)


def vertical(frames: Sequence[Frame], forces: Sequence[np.ndarray], with_friction: bool) -> float:
    """Vertical force on the rail; without friction that of the normal forces alone."""
    counts = np.array([with_friction, with_friction, True])
    return float(
        sum(frame.axes[2] @ (counts * force) for frame, force in zip(frames, forces, strict=True))
    )


def vertical_forces(solution: WheelRailSolution) -> tuple[float, float]:
    """Vertical forces of a solution: of the normal forces, and of all forces that count."""
    frames = [each.frame for each in solution.patches]
    forces = [each.force for each in solution.patches]
    all_forces = vertical(frames, forces, solution.case.with_friction)
    return vertical(frames, forces, False), all_forces


def for_pressure(methods: dict[str, Any]) -> dict[str, Any]:
    """Methods for the normal problem alone, without a certificate."""
    names = ("normal", "method", "accuracy")
    return {"certify": None} | {name: value for name, value in methods.items() if name in names}


def _by_theory(scene: Scene, methods: dict[str, Any]) -> Solution:
    """A patch by a theory, on an ellipse with its normal force."""
    normal = solve(scene.without_friction, **for_pressure(methods))
    # Hertz's contact with the same second moments, a^2/5 and b^2/5
    grid = normal.grid
    weights = normal.pressure / normal.pressure.sum()
    sides = []
    for axis, at, side in ((0, grid.x, grid.sides[0]), (1, grid.y, grid.sides[1])):
        along = weights.sum(axis=axis)
        sides.append(float(np.sqrt(5 * (along @ (at - along @ at) ** 2 + side**2 / 12))))
    # a theory has one coefficient: the mean, weighted by the pressure
    f: Any = scene.friction
    if isinstance(f, np.ndarray):
        f = float(np.sum(weights * f))
    hertz: dict[str, Any] = {
        "surface": Ellipse(*sides),
        "approach": None,
        "normal_force": normal.normal_force,
    }
    scene = replace(scene, **hertz, friction=f, grid=Grid(nx=ON_ELLIPSE, ny=ON_ELLIPSE))
    return solve(scene, **{name: value for name, value in methods.items() if name != "normal"})


def _force(solution: Solution) -> np.ndarray:
    return np.array([*solution.force, solution.normal_force])
