"""Cross-checks between the entries of a scene.

A history is expanded into its steps, and each step has to meet the rules of one
problem.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import NoContact, SceneError
from varcontact.scene.bodies import Bodies, BodyPair
from varcontact.scene.friction import FrictionBound, Law, StaticKinetic, coefficient
from varcontact.scene.friction_laws import FrictionLaw, PressureFalling, TemperatureFalling
from varcontact.scene.grid import Grid
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.motion import Harmonic, Shift, Steady, TimeStep
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene


_Problem = tuple[
    int | None, tuple[float | None, float | None], Any, Steady | Shift | TimeStep | None
]
"""What a scene poses, itself or in a step of its history: step, normal force and approach,
friction, motion."""


def check_classes(scene: Scene) -> None:
    """Each entry is of a class that it may have."""
    optional = (type(None),)
    for name, classes, more in (
        ("bodies", (Bodies, BodyPair), " or a pair of bodies"),
        ("surface", (Paraboloids, Ellipse, Cylinders, SampledDistance), ""),
        ("motion", (Steady, Shift, TimeStep, Transient, Harmonic, *optional), ""),
        ("third_body", (ThirdBody, *optional), ""),
        ("units", (Units, *optional), ""),
        ("grid", (Grid,), ' or "auto"'),
    ):
        value = getattr(scene, name)
        if name != "grid" or not isinstance(value, str) or value != "auto":
            checks.kind(name, value, *classes, more=more)
    thermal = scene.thermal
    if thermal is not None and not (
        len(thermal) == 2 and all(isinstance(each, Thermal) for each in thermal)
    ):
        raise SceneError(
            "thermal", thermal, "a Thermal of both bodies, or a pair of them (upper, lower)"
        )


def check(scene: Scene) -> None:
    """Entries go together."""
    problems = list(_problems(scene))
    _check_load(scene, problems)
    _check_harmonic(scene)
    _check_speed(scene)
    _check_surfaces(scene)
    _check_friction(scene, problems)
    _check_by_element(scene)
    _check_depth(scene, problems)
    _check_third_body(scene)


def _problems(scene: Scene) -> Iterator[_Problem]:
    """The problems that a scene poses, one after the other; one for all steps that are the same."""
    motion = scene.motion
    own = scene.normal_force, scene.approach
    if not isinstance(motion, Transient):
        motion = motion.free_rolling if isinstance(motion, Harmonic) else motion
        yield None, own, scene.friction, motion
        return
    for k in range(1 if motion.repeats else motion.steps):
        load, friction = (
            (motion.of("normal_force", k), motion.of("approach", k)),
            motion.of("friction", k),
        )
        # Without dq a step is as long as an element, which no rule depends on.
        friction = scene.friction if friction is None else friction
        yield k, own if load == (None, None) else load, friction, motion.step(k, dx=1.0)


def _check_load(scene: Scene, problems: list[_Problem]) -> None:
    """Exactly one of normal force and approach, in each problem; an approach at which the bodies
    touch.
    """
    unloaded = scene.normal_force is None and scene.approach is None
    if not unloaded or not isinstance(scene.motion, Transient):
        checks.exactly_one(normal_force=scene.normal_force, approach=scene.approach)
    for k, (force, approach), _, _ in problems:
        checks.exactly_one(
            **{f"motion.normal_force[{k}]": force, f"motion.approach[{k}]": approach}
        )
    if isinstance(scene.surface, Ellipse) and isinstance(scene.bodies, BodyPair):
        raise SceneError(
            "surface", scene.surface, "Paraboloids: an Ellipse is Hertz's contact of half-spaces"
        )
    if isinstance(scene.surface, Ellipse) and unloaded:
        raise SceneError(
            "surface", scene.surface, "Paraboloids, or an Ellipse with the scene's own normal_force"
        )
    least = float(scene.surface.h.min()) if isinstance(scene.surface, SampledDistance) else 0.0
    apart = scene.approach is not None and scene.approach <= least
    if apart and not isinstance(scene.motion, TimeStep | Transient):
        raise bodies_apart(scene.approach, least)


def bodies_apart(approach: float | None, least: float) -> NoContact:
    """The error for an approach that leaves the bodies apart."""
    message = f"approach = {approach:.6g} gives no contact: it must exceed the least undeformed distance, {least:.6g}"
    return NoContact("approach", approach, message=message)


def _check_harmonic(scene: Scene) -> None:
    """Creepages swing where elastic bodies stick, and displacements have a place to count from."""
    if not isinstance(scene.motion, Harmonic):
        return
    if scene.friction is not None and not scene.no_slip:
        allowed = (
            "inf: with slip, Solution.frequency_response is what swings about a steady solution"
        )
        raise SceneError("friction", scene.friction, allowed)
    if scene.thermal is not None:
        raise SceneError("thermal", scene.thermal, "left out where creepages swing")
    check_linear(scene)
    if scene.shift_undetermined:
        raise SceneError(
            "surface.reference_depth", None, "given: in line contact what swings depends on it"
        )


def check_linear(scene: Scene) -> None:
    """What the problem cannot be linearised with."""
    if scene.third_body is not None and scene.third_body.yields:
        allowed = "inf: linearised are layers that do not yield"
        raise SceneError("third_body.tau_c0", scene.third_body.tau_c0, allowed)
    if scene.conformal:
        raise SceneError(
            "surface.inclination", "given", "left out: linearised are bodies that meet on a plane"
        )


def _check_speed(scene: Scene) -> None:
    """Viscoelastic bodies roll steadily at a speed, or step by step in time; no other contact
    depends on either.
    """
    motion, relaxes, thermal = scene.motion, scene.bodies.relaxes, scene.thermal is not None
    name, what = (
        ("dt", "the time of a step")
        if isinstance(motion, TimeStep | Transient)
        else ("speed", "the speed")
    )
    given = getattr(motion, name, None)
    if not isinstance(motion, Steady | TimeStep | Transient) and (
        relaxes or (thermal and motion is not None)
    ):
        allowed = "Steady(speed=...) or Transient(dt=...), with friction = 0 if need be"
        raise SceneError(
            "motion", motion, f"{allowed}: viscoelastic bodies and temperatures need time"
        )
    several = isinstance(scene.bodies, BodyPair) and scene.bodies.of_several_solids
    if several and not (scene.line and isinstance(motion, Steady)):
        allowed = (
            "of one solid (relaxations of the whole body), or in steady rolling in line contact"
        )
        raise SceneError("bodies.layers", scene.bodies, allowed)
    if motion is None:
        return
    if given is None and (relaxes or thermal):
        raise SceneError(
            f"motion.{name}", None, f"given: viscoelastic bodies and temperatures depend on {what}"
        )
    if thermal and not np.all(np.asarray(given) > 0):
        raise SceneError(f"motion.{name}", given, "positive: heat takes time")
    if given is not None and not (relaxes or thermal):
        allowed = f"left out: nothing depends on {what} unless bodies are Viscoelastic, or thermal is given"
        raise SceneError(f"motion.{name}", given, allowed)


def _check_surfaces(scene: Scene) -> None:
    """Line contact, and nothing else, has no rows, and no spin; surfaces of a history are alike,
    and on a plane.
    """
    grid, motion = scene.grid, scene.motion
    if isinstance(grid, Grid) and grid.line and not scene.line:
        raise SceneError("grid.ny", None, "given: only line contact has no rows")
    for name in ("spin", "rotation"):
        turns = np.atleast_1d(getattr(motion, name, 0.0))
        if scene.line and np.any(turns != 0):
            given = float(turns[turns != 0][0])
            raise SceneError(
                f"motion.{name}", given, "0 in line contact, where nothing depends on y"
            )
    for surface in scene.surfaces:
        if (
            surface.line != scene.line
            or getattr(surface, "reference_depth", None) != scene.reference_depth
        ):
            allowed = "as the scene's surface: line contact with the same reference_depth, or none"
            raise SceneError("motion.surface", surface, allowed)
    if not any(
        getattr(surface, "inclination", None) is not None
        for surface in (scene.surface, *scene.surfaces)
    ):
        return
    if isinstance(motion, TimeStep | Transient):
        raise SceneError(
            "motion",
            motion,
            "Steady or Shift: conformal contact (surface.inclination) has no history",
        )
    if motion is not None and motion.Fy is not None:
        allowed = (
            "left out: in conformal contact the pressure bears a part of it; prescribe vy or uy"
        )
        raise SceneError("motion.Fy", motion.Fy, allowed)


def why_centres(scene: Scene) -> str:
    """Why elements at the contact's edge cannot count in part: what must be known of it; empty
    where they can.
    """
    if scene.coupled and not scene.frictionless:
        how = "conformal" if scene.conformal else f"unlike ({scene.difference})"
        return f"is for a pressure that tractions do not change, and the bodies are {how}"
    samples = [each for each in scene.surfaces if isinstance(each, SampledDistance)]
    if getattr(scene.motion, "heights", ()) or any(each.x is None for each in samples):
        return "needs distances on parts of the elements, and samples without coordinates have none"
    return ""


def _check_friction(scene: Scene, problems: list[_Problem]) -> None:
    """Friction is given where there is a motion; a law that falls with slip velocity needs a step
    that rolls.
    """
    for k, _, friction, motion in problems:
        law = friction if isinstance(friction, Law) else None
        if motion is not None and friction is None:
            raise SceneError(
                "friction", None, "given: a motion needs a number, inf, a law, or an array"
            )
        if isinstance(friction, FrictionBound) and friction.rolls_along and k is None:
            raise SceneError(
                "friction",
                friction,
                "a number, a law or an array: what particles carry needs Transient",
            )
        if law is not None and law.warm and scene.thermal is None:
            raise SceneError("friction", law, "a law by slip: temperatures need thermal data")
        for factor in law.factors if isinstance(law, FrictionLaw) else ():
            if isinstance(factor, np.ndarray):
                _check_on_grid(scene, "friction.factors", factor)
        falls = law is not None and not isinstance(
            law, StaticKinetic | TemperatureFalling | PressureFalling
        )
        if falls and k is not None and motion is not None and motion.rolls == 0:
            field = "friction" if law is scene.friction else "motion.friction"
            allowed = f"a law without slip velocity, as StaticKinetic: step {k} does not roll (motion.dq = 0)"
            raise SceneError(field, law, allowed)
    start = scene.motion.start if isinstance(scene.motion, Transient) else None
    if scene.warm and start is not None and start.scene.speed is None and start.traction.any():
        allowed = "in steady rolling with a speed, or left out: friction depends on all that heated the bodies before"
        raise SceneError("motion.start", type(start.motion).__name__, allowed)


def _check_by_element(scene: Scene) -> None:
    """What is given element by element lies on the scene's own grid, and rules of that grid."""
    grid, motion, relaxes = scene.grid, scene.motion, scene.bodies.relaxes
    allowed = '"centres"' if relaxes else '"centres" or "touched"'
    if isinstance(motion, Transient | TimeStep) and f'"{scene.edge}"' not in allowed:
        # what elements at the edge give way is no displacement that particles could carry along to
        # the next step
        kind = "of viscoelastic bodies" if relaxes else "of steps"
        raise SceneError("grid.edge", scene.edge, f"{allowed} in a history {kind}")
    if isinstance(scene.friction, np.ndarray):
        _check_on_grid(scene, "friction", scene.friction)
        for each in (
            scene.friction.min(),
            scene.friction.max(),
            *scene.friction[scene.friction > 0][:1],
        ):
            coefficient("friction", float(each))
    for surface in scene.surfaces:
        if isinstance(surface, SampledDistance) and surface.x is None:
            _check_on_grid(scene, "surface.h", surface.samples)
        elif isinstance(surface, SampledDistance) and relaxes and isinstance(motion, Transient):
            allowed = "left out: in a history of viscoelastic bodies samples lie on the grid"
            raise SceneError("surface.x", "given", allowed)
    if isinstance(motion, Steady) and motion.rigid_slip is not None:
        name, given = "motion.rigid_slip", motion.rigid_slip.shape
        if not isinstance(scene.surface, SampledDistance):
            raise SceneError(
                name, given, "left out: it is given at the samples of a SampledDistance"
            )
        if given != (2, *scene.surface.samples.shape):
            raise checks.wrong_shape(
                name, given, f"(2, ny, nx) = {(2, *scene.surface.samples.shape)}"
            )
    for each in motion.heights if isinstance(motion, Transient) else ():
        if isinstance(scene.surface, Ellipse):
            raise SceneError(
                "surface", scene.surface, "Paraboloids, where motion.carried has heights"
            )
        if scene.line and each.y is not None:
            raise SceneError(
                "carried.y", each.y, "left out in line contact, where nothing depends on y"
            )
        step = grid.sides[0] if isinstance(grid, Grid) and grid.explicit else 0.0
        if each.period is not None and each.period < 2 * step:
            allowed = f"at least two elements, {2 * step:.6g}, or shorter elements"
            raise SceneError("carried.period", each.period, allowed)


def _check_on_grid(scene: Scene, field: str, values: Any) -> None:
    entries = "nx, dx, x0" if scene.line else "nx, ny, dx, dy, x0, y0"
    grid = scene.grid
    if not (isinstance(grid, Grid) and grid.explicit):
        raise SceneError("grid", grid, f"explicit ({entries}), as {field} is given on it")
    if values.shape != grid.shape:
        allowed = f"(nx,) = ({grid.nx},)" if scene.line else f"(ny, nx) = {grid.shape}"
        given = values.shape[1:] if scene.line and values.shape[0] == 1 else values.shape
        raise checks.wrong_shape(field, given, f"of the grid's shape {allowed}")


def _check_depth(scene: Scene, problems: list[_Problem]) -> None:
    """In line contact displacements count from a depth: it is needed where they are prescribed or
    carried along.

    No depth is needed along a direction in which nothing moves, in which a force is prescribed all
    the time, or in steady rolling, where only differences of displacements count.
    """
    motion = scene.motion
    if scene.bodies.grounded and scene.reference_depth is not None:
        allowed = "left out: the bodies rest on bases that do not move, and displacements count from there"
        raise SceneError("surface.reference_depth", scene.reference_depth, allowed)
    if not scene.shift_undetermined or isinstance(motion, TimeStep):
        return
    for k, (_, approach), _, _ in problems:
        if approach is not None and scene.approach_undetermined:
            where = f" of step {k}" if k is not None else ""
            raise _depth_for(scene, f"the approach{where}", "a normal force")
    if not isinstance(motion, Shift | Transient):
        return
    start = motion.start if isinstance(motion, Transient) else None
    for i, (force, shift) in enumerate({"Fx": "ux", "Fy": "uy"}.items()):
        moves = i == 0 and scene.coupled and not scene.frictionless
        moves |= start is not None and bool(
            np.any(np.abs(start.traction[i]) > 1e-9 * start.pressure.max())
        )
        moves |= any(
            getattr(step, force) or (step is not None and step.rigid[i])
            for _, _, _, step in problems
        )
        for k, _, _, step in problems:
            if moves and getattr(step, force) is None:
                what = f"motion.{shift}" if k is None else f"step {k}, without motion.{force},"
                raise _depth_for(
                    scene, what, f"motion.{force}" + " in every step" * (k is not None)
                )


def _depth_for(scene: Scene, what: str, instead: str) -> SceneError:
    if scene.bodies.slides:
        message = f"{what} has no meaning where a body slides on a smooth base. Prescribe {instead}"
        return SceneError("bodies.base", "smooth", message=message)
    needs = f"{what} needs surface.reference_depth: in line contact displacements are measured from a depth"
    return SceneError(
        "surface.reference_depth", None, message=f"{needs}. Give the depth, or prescribe {instead}"
    )


def _check_third_body(scene: Scene) -> None:
    """One that softens has a history, one that yields friction to slip at last."""
    layer, motion = scene.third_body, scene.motion
    if layer is None:
        return
    if layer.k_tau < 0 and isinstance(motion, Steady):
        allowed = (
            "zero or positive in steady rolling: a layer that softens has a history (Transient)"
        )
        raise SceneError("third_body.k_tau", layer.k_tau, allowed)
    if layer.yields and scene.no_slip:
        raise SceneError("friction", math.inf, "finite with a third_body that yields")
    second_order = (
        scene.edge == "softened"
        or getattr(motion, "slip_difference", "first-order") != "first-order"
    )
    if second_order and layer.k_tau != 0:
        raise SceneError(
            "third_body.k_tau",
            layer.k_tau,
            '0, or grid.edge "centres" and slip_difference "first-order"',
        )
