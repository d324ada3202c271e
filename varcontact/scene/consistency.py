"""Cross-checks between the entries of a scene.

A history is expanded into its steps, and each step has to meet the rules of one problem.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import NoContact, SceneError
from varcontact.scene.bodies import Bodies, BodyPair
from varcontact.scene.friction import LEAST, MOST, Law, StaticKinetic
from varcontact.scene.friction_laws import FrictionLaw, PressureFalling, TemperatureFalling
from varcontact.scene.grid import Grid
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.motion import Harmonic, Shift, Steady, TimeStep
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance, Surface, is_line
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene


@dataclass(frozen=True)
class _Problem:
    """One problem that a scene poses: the scene's own, or that of a step of its history."""

    step: int | None  # of a history
    surface: Surface
    load: tuple[float | None, float | None]  # normal force, approach
    friction: float | np.ndarray | Law | None
    motion: Steady | Shift | TimeStep | None


def check_parts(scene: Scene) -> None:
    """Each entry is of a class that it may have."""
    _instance("bodies", scene.bodies, (Bodies, BodyPair), " or a pair of bodies")
    _instance("surface", scene.surface, (Paraboloids, Ellipse, Cylinders, SampledDistance))
    if isinstance(scene.surface, Ellipse) and isinstance(scene.bodies, BodyPair):
        raise SceneError("surface", scene.surface, "Paraboloids: an Ellipse is Hertz's contact of half-spaces")
    thermal = scene.thermal
    if thermal is not None and not (len(thermal) == 2 and all(isinstance(each, Thermal) for each in thermal)):
        raise SceneError("thermal", thermal, "a Thermal of both bodies, or a pair of them (upper, lower)")
    if scene.motion is not None:
        _instance("motion", scene.motion, (Steady, Shift, TimeStep, Transient, Harmonic))
    if scene.units is not None:
        _instance("units", scene.units, (Units,))
    if not (isinstance(scene.grid, str) and scene.grid == "auto"):
        _instance("grid", scene.grid, (Grid,), ' or "auto"')


def check_load(scene: Scene) -> None:
    """Exactly one of normal force and approach, in each problem; an approach at which the bodies touch."""
    given = sum(each is not None for each in (scene.normal_force, scene.approach))
    history = isinstance(scene.motion, Transient)
    if given == 2 or (given == 0 and not history):
        checks.exactly_one(normal_force=scene.normal_force, approach=scene.approach)
    for problem in _problems(scene):
        if sum(each is not None for each in problem.load) != 1:
            k = problem.step
            name = f"motion.normal_force[{k}], motion.approach[{k}]"
            message = f"motion.normal_force[{k}] and motion.approach[{k}] are both given: give one of them"
            if problem.load == (None, None):
                message = f"step {k} has no load: give motion.normal_force[{k}] or motion.approach[{k}]"
            raise SceneError(name, problem.load, "one of the two", message=message)
    if isinstance(scene.surface, Ellipse) and given == 0:
        raise SceneError("surface", scene.surface, "Paraboloids, or an Ellipse with the scene's own normal_force")
    least = float(scene.surface.h.min()) if isinstance(scene.surface, SampledDistance) else 0.0
    apart = scene.approach is not None and scene.approach <= least
    if apart and not isinstance(scene.motion, TimeStep | Transient):
        raise bodies_apart(scene.approach, least)


def check_speed(scene: Scene) -> None:
    """Viscoelastic bodies roll steadily at a speed, or step by step in time; no other contact depends on either."""
    motion = scene.motion
    name, what = ("dt", "the time of a step") if isinstance(motion, TimeStep | Transient) else ("speed", "the speed")
    given = getattr(motion, name, None)
    if scene.bodies.relaxes and not isinstance(motion, Steady | TimeStep | Transient):
        allowed = "Steady(speed=...) or Transient(dt=...)"
        raise SceneError("motion", motion, f"{allowed}, with friction = 0 if need be: viscoelastic bodies move in time")
    several = isinstance(scene.bodies, BodyPair) and scene.bodies.of_several_solids
    if several and not (scene.line and isinstance(motion, Steady)):
        allowed = "of one solid (relaxations of the whole body), or in steady rolling in line contact"
        raise SceneError("bodies.layers", scene.bodies, allowed)
    if scene.bodies.relaxes and given is None:
        raise SceneError(f"motion.{name}", None, f"given: viscoelastic bodies depend on {what}")
    if scene.thermal is not None and isinstance(motion, Shift):
        raise SceneError("motion", motion, "Steady(speed=...) or Transient(dt=...): temperatures need time")
    if scene.thermal is not None and motion is not None and given is None:
        raise SceneError(f"motion.{name}", None, f"given: temperatures depend on {what}")
    if scene.thermal is not None and motion is not None and not np.all(np.asarray(given) > 0):
        raise SceneError(f"motion.{name}", given, "positive: heat takes time")
    if given is not None and not scene.bodies.relaxes and scene.thermal is None:
        allowed = f"left out: nothing depends on {what} unless bodies are Viscoelastic, or thermal is given"
        raise SceneError(f"motion.{name}", given, allowed)


def check_harmonic(scene: Scene) -> None:
    """Creepages swing where elastic bodies stick, and displacements have a place to count from."""
    if not isinstance(scene.motion, Harmonic):
        return
    if scene.friction is not None and not scene.no_slip:
        allowed = "inf: with slip, Solution.frequency_response is what swings about a steady solution"
        raise SceneError("friction", scene.friction, allowed)
    if scene.third_body is not None and scene.third_body.yields:
        raise SceneError(
            "third_body.tau_c0", scene.third_body.tau_c0, "inf: creepages swing on layers that do not yield"
        )
    if scene.thermal is not None:
        raise SceneError("thermal", scene.thermal, "left out where creepages swing")
    if scene.conformal:
        raise SceneError("surface.inclination", "given", "left out where creepages swing")
    if scene.shift_undetermined:
        raise SceneError("surface.reference_depth", None, "given: in line contact what swings depends on it")


def bodies_apart(approach: float | None, least: float) -> NoContact:
    """The error for an approach that leaves the bodies apart."""
    message = f"approach = {approach:.6g} gives no contact: it must exceed the least undeformed distance, {least:.6g}"
    return NoContact("approach", approach, f"above the least undeformed distance, {least:.6g}", message=message)


def check_line(scene: Scene) -> None:
    """Line contact, and nothing else, has no rows; it has no spin; and all surfaces of a history are of one kind."""
    grid, motion = scene.grid, scene.motion
    if isinstance(grid, Grid) and grid.line and not scene.line:
        raise SceneError("grid.ny", None, "given: only line contact has no rows")
    for name in ("spin", "rotation"):
        turns = np.atleast_1d(getattr(motion, name, 0.0))
        if scene.line and np.any(turns != 0):
            given = float(turns[turns != 0][0])
            raise SceneError(f"motion.{name}", given, "0 in line contact, where nothing depends on y")
    for surface in scene.surfaces:
        if is_line(surface) != scene.line or getattr(surface, "reference_depth", None) != scene.reference_depth:
            allowed = "as the scene's surface: line contact with the same reference_depth, or none"
            raise SceneError("motion.surface", surface, allowed)


def why_centres(scene: Scene) -> str:
    """Why elements at the contact's edge cannot count in part: what must be known of it; empty where they can."""
    if scene.coupled and not scene.frictionless:
        how = "conformal" if scene.conformal else f"unlike ({scene.difference})"
        return f"is for a pressure that tractions do not change, and the bodies are {how}"
    if scene.carries or any(isinstance(each, SampledDistance) and not each.placed for each in scene.surfaces):
        return "needs distances on parts of the elements, and samples without coordinates have none"
    return ""


def check_edge(scene: Scene) -> None:
    """Elements at the edge are not softened in a history, nor divided while bodies relax.

    What they give way is no displacement that particles could carry along to the next step.
    """
    allowed = '"centres"' if scene.bodies.relaxes else '"centres" or "touched"'
    if isinstance(scene.motion, Transient | TimeStep) and f'"{scene.edge}"' not in allowed:
        kind = "of viscoelastic bodies" if scene.bodies.relaxes else "of steps"
        raise SceneError("grid.edge", scene.edge, f"{allowed} in a history {kind}")


def without_rows(grid: Grid) -> Grid:
    """A grid of one row as line contact has it, without rows."""
    if grid.ny != 1:
        raise SceneError("grid.ny", grid.ny, "left out in line contact")
    if grid.dy is not None:
        raise SceneError("grid.dy", grid.dy, "left out in line contact, where forces are per unit length")
    return Grid(nx=grid.nx, margin=grid.margin, edge=grid.edge)


def check_depth(scene: Scene) -> None:
    """In line contact displacements count from a depth: it is needed where they are prescribed or carried along.

    No depth is needed along a direction in which nothing moves, in which a force is prescribed all the time, or in
    steady rolling, where only differences of displacements count.
    """
    if scene.bodies.grounded and scene.reference_depth is not None:
        raise SceneError(
            "surface.reference_depth",
            scene.reference_depth,
            "left out: the bodies rest on bases that do not move, and displacements count from there",
        )
    if not scene.shift_undetermined or isinstance(scene.motion, TimeStep):
        return
    problems = list(_problems(scene))
    for problem in problems:
        if problem.load[1] is not None and scene.approach_undetermined:
            where = f" of step {problem.step}" if problem.step is not None else ""
            raise _depth_for(scene, f"the approach{where}", "a normal force")
    if scene.motion is None or isinstance(scene.motion, Steady | Harmonic):
        return
    for i, (force, shift) in enumerate({"Fx": "ux", "Fy": "uy"}.items()):
        by_pressure = i == 0 and scene.coupled and not scene.frictionless
        if not by_pressure and not _moves(scene, (i,)):
            continue
        for problem in problems:
            if getattr(problem.motion, force) is None and problem.step is None:
                raise _depth_for(scene, f"motion.{shift}", f"motion.{force}")
            if getattr(problem.motion, force) is None:
                what = f"step {problem.step}, without motion.{force},"
                raise _depth_for(scene, what, f"motion.{force} in every step")


def _depth_for(scene: Scene, what: str, instead: str) -> SceneError:
    if scene.bodies.slides:
        message = f"{what} has no meaning where a body slides on a smooth base. Prescribe {instead}"
        return SceneError("bodies.base", "smooth", message=message)
    return SceneError(
        "surface.reference_depth",
        None,
        message=f"{what} needs surface.reference_depth: in line contact displacements are measured from a depth. "
        f"Give the depth, or prescribe {instead}",
    )


def _moves(scene: Scene, directions: tuple[int, ...]) -> bool:
    """Whether a motion or a force is prescribed in these of x, y and about z, or tractions are there at the start."""
    start = scene.motion.start if isinstance(scene.motion, Transient) else None
    for i in directions:
        if start is not None and i < 2 and np.any(np.abs(start.traction[i]) > 1e-9 * start.pressure.max()):
            return True
        motions = (problem.motion for problem in _problems(scene))
        if any(motion is not None and (motion.rigid[i] or (motion.Fx, motion.Fy, None)[i]) for motion in motions):
            return True
    return False


def check_friction(scene: Scene) -> None:
    """Friction is given where there is a motion; a law that falls with slip velocity needs a step that rolls."""
    for problem in _problems(scene):
        if scene.motion is not None and problem.friction is None:
            raise SceneError("friction", None, "given: a motion needs a number, inf, a law, or an array")
        law = problem.friction if isinstance(problem.friction, Law) else None
        if law is not None and law.warm and scene.thermal is None:
            raise SceneError("friction", law, "a law by slip: temperatures need thermal data")
        for factor in law.factors if isinstance(law, FrictionLaw) else ():
            if isinstance(factor, np.ndarray):
                _check_on_grid(scene, "friction.factors", factor)
        falls = law is not None and not isinstance(law, StaticKinetic | TemperatureFalling | PressureFalling)
        if falls and isinstance(problem.motion, TimeStep) and problem.step is not None and problem.motion.rolls == 0:
            field = "friction" if problem.friction is scene.friction else "motion.friction"
            allowed = (
                f"a law without slip velocity, as StaticKinetic: step {problem.step} does not roll (motion.dq = 0)"
            )
            raise SceneError(field, problem.friction, allowed)
    start = scene.motion.start if isinstance(scene.motion, Transient) else None
    if scene.warm and start is not None and start.scene.speed is None and start.traction.any():
        allowed = "in steady rolling with a speed, or left out: friction depends on all that heated the bodies before"
        raise SceneError("motion.start", type(start.motion).__name__, allowed)
    if isinstance(scene.friction, np.ndarray):
        _check_on_grid(scene, "friction", scene.friction)
        if np.any(scene.friction < 0):
            raise SceneError("friction", float(np.min(scene.friction)), "zero or positive everywhere")
        bounded = scene.friction[scene.friction > 0]
        if np.any((bounded < LEAST) | (bounded > MOST)):
            given = float(bounded.max() if bounded.max() > MOST else bounded.min())
            raise SceneError("friction", given, f"0, or between {LEAST:g} and {MOST:g}, everywhere")


def check_samples(scene: Scene) -> None:
    """Distances without coordinates lie on the scene's own grid."""
    for surface in scene.surfaces:
        if isinstance(surface, SampledDistance) and surface.x is None:
            _check_on_grid(scene, "surface.h", surface.samples)
        elif isinstance(surface, SampledDistance) and scene.bodies.relaxes and isinstance(scene.motion, Transient):
            allowed = "left out: in a history of viscoelastic bodies samples lie on the grid"
            raise SceneError("surface.x", "given", allowed)


def check_carried(scene: Scene) -> None:
    """Heights are carried through a contact whose distance is known, on elements that resolve them."""
    for each in scene.motion.heights if isinstance(scene.motion, Transient) else ():
        if isinstance(scene.surface, Ellipse):
            raise SceneError("surface", scene.surface, "Paraboloids, where motion.carried has heights")
        if scene.line and each.y is not None:
            raise SceneError("carried.y", each.y, "left out in line contact, where nothing depends on y")
        step = scene.grid.sides[0] if isinstance(scene.grid, Grid) and scene.grid.explicit else 0.0
        if each.period is not None and each.period < 2 * step:
            allowed = f"at least two elements, {2 * step:.6g}, or shorter elements"
            raise SceneError("carried.period", each.period, allowed)


def check_conformal(scene: Scene) -> None:
    """What is given element by element has samples to lie on; a curved surface stays, and bears no lateral force."""
    surface, motion = scene.surface, scene.motion
    slip = motion.rigid_slip if isinstance(motion, Steady) else None
    if slip is not None:
        if not isinstance(surface, SampledDistance):
            raise SceneError(
                "motion.rigid_slip", slip.shape, "left out: it is given at the samples of a SampledDistance"
            )
        if slip.shape != (2, *surface.samples.shape):
            raise checks.wrong_shape("motion.rigid_slip", slip.shape, f"(2, ny, nx) = {(2, *surface.samples.shape)}")
    if not any(
        isinstance(each, SampledDistance) and each.inclination is not None for each in (surface, *scene.surfaces)
    ):
        return
    if isinstance(motion, TimeStep | Transient):
        raise SceneError("motion", motion, "Steady or Shift: conformal contact (surface.inclination) has no history")
    if motion is not None and motion.Fy is not None:
        allowed = "left out: in conformal contact the pressure bears a part of it; prescribe vy or uy"
        raise SceneError("motion.Fy", motion.Fy, allowed)


def check_third_body(scene: Scene) -> None:
    """One that softens has a history, one that yields friction to slip at last."""
    layer, motion = scene.third_body, scene.motion
    if layer is None:
        return
    _instance("third_body", layer, (ThirdBody,))
    if layer.k_tau < 0 and isinstance(motion, Steady):
        allowed = "zero or positive in steady rolling: a layer that softens has a history (Transient)"
        raise SceneError("third_body.k_tau", layer.k_tau, allowed)
    if layer.yields and scene.no_slip:
        raise SceneError("friction", math.inf, "finite with a third_body that yields")
    second_order = scene.edge == "softened" or getattr(motion, "slip_difference", "first-order") != "first-order"
    if second_order and layer.k_tau != 0:
        raise SceneError("third_body.k_tau", layer.k_tau, '0, or grid.edge "centres" and slip_difference "first-order"')


def _problems(scene: Scene) -> Iterator[_Problem]:
    """The problems that a scene poses, one after the other; one for all steps that are the same."""
    motion = scene.motion
    if not isinstance(motion, Transient):
        motion = motion.free_rolling if isinstance(motion, Harmonic) else motion
        yield _Problem(None, scene.surface, (scene.normal_force, scene.approach), scene.friction, motion)
        return
    surfaces, frictions = scene.surfaces, scene.frictions
    for k in range(1 if motion.repeats else motion.steps):
        load = motion.of("normal_force", k), motion.of("approach", k)
        load = (scene.normal_force, scene.approach) if load == (None, None) else load
        # Without dq a step is as long as an element, which no rule depends on.
        yield _Problem(k, surfaces[k % len(surfaces)], load, frictions[k], motion.step(k, dx=1.0))


def _check_on_grid(scene: Scene, field: str, values: Any) -> None:
    entries = "nx, dx, x0" if scene.line else "nx, ny, dx, dy, x0, y0"
    grid = scene.grid
    if not (isinstance(grid, Grid) and grid.explicit):
        raise SceneError("grid", grid, f"explicit ({entries}), as {field} is given on it")
    if values.shape != grid.shape:
        allowed = f"(nx,) = ({grid.nx},)" if scene.line else f"(ny, nx) = {grid.shape}"
        given = values.shape[1:] if scene.line and values.shape[0] == 1 else values.shape
        raise checks.wrong_shape(field, given, f"of the grid's shape {allowed}")


def _instance(field: str, value: Any, classes: tuple[type, ...], more: str = "") -> None:
    if not isinstance(value, classes):
        raise SceneError(field, value, " or ".join(c.__name__ for c in classes) + more)
