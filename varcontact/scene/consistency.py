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
from varcontact.scene.carried import Carried
from varcontact.scene.friction import FrictionBound, Law, StaticKinetic, coefficient
from varcontact.scene.friction_laws import FrictionLaw, PressureFalling, TemperatureFalling
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Grid
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.load_checks import check_loads
from varcontact.scene.motion import Harmonic, Shift, Steady, TimeStep
from varcontact.scene.periodic_checks import check_periodic
from varcontact.scene.pin import CLEARANCE_MAX, PinInHole
from varcontact.scene.surfaces import (
    STEP_TURN_MAX,
    Cylinders,
    Ellipse,
    Paraboloids,
    SampledDistance,
    depth_of,
    is_curved,
    is_curved_along_x,
    is_curved_along_y,
)
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene


_Problem = tuple[
    int | None, tuple[float | None, float | None], Any, Steady | Shift | TimeStep | None
]
"""A problem of a scene, or of a step of its history: step, normal force and approach, friction,
motion."""


def check_classes(scene: Scene) -> None:
    """Check that each entry is an instance of an allowed class."""
    optional = (type(None),)
    for name, classes, more in (
        ("bodies", (Bodies, BodyPair, GivenBodies), " or a pair of bodies"),
        ("surface", (Paraboloids, Ellipse, Cylinders, PinInHole, SampledDistance), ""),
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
    """Check that the entries are consistent with each other."""
    problems = list(_problems(scene))
    _check_load(scene, problems)
    _check_given_bodies(scene)
    check_loads(scene)
    _check_harmonic(scene)
    _check_speed(scene)
    _check_surfaces(scene)
    _check_pin(scene)
    _check_friction(scene, problems)
    _check_by_element(scene)
    _check_depth(scene, problems)
    _check_third_body(scene)
    check_periodic(scene)


def _problems(scene: Scene) -> Iterator[_Problem]:
    """Problems that a scene poses, one after the other; a single one for steps that are all
    alike.
    """
    motion = scene.motion
    own = scene.normal_force, scene.approach
    if not isinstance(motion, Transient):
        if isinstance(motion, Harmonic):
            motion = motion.free_rolling
        yield None, own, scene.friction, motion
        return
    different_steps = motion.steps
    if motion.repeats:
        different_steps = 1
    for k in range(different_steps):
        load = motion.of("normal_force", k), motion.of("approach", k)
        if load == (None, None):
            load = own
        friction = motion.of("friction", k)
        if friction is None:
            friction = scene.friction
        # Without dq a step is as long as an element, which no rule depends on.
        yield k, load, friction, motion.step(k, dx=1.0)


def _check_load(scene: Scene, problems: list[_Problem]) -> None:
    """Check that each problem has either a normal force or an approach, and that at this approach
    the bodies touch.
    """
    unloaded = scene.normal_force is None and scene.approach is None
    if not unloaded or not isinstance(scene.motion, Transient):
        checks.exactly_one(normal_force=scene.normal_force, approach=scene.approach)
    for k, (force, approach), _, _ in problems:
        checks.exactly_one(
            **{f"motion.normal_force[{k}]": force, f"motion.approach[{k}]": approach}
        )
    if isinstance(scene.surface, Ellipse) and not isinstance(scene.bodies, Bodies):
        raise SceneError(
            "surface", scene.surface, "Paraboloids: an Ellipse is Hertz's contact of half-spaces"
        )
    if isinstance(scene.surface, Ellipse) and unloaded:
        raise SceneError(
            "surface", scene.surface, "Paraboloids, or an Ellipse with the scene's own normal_force"
        )
    # a step of a history may be without contact
    if scene.approach is not None and not isinstance(scene.motion, TimeStep | Transient):
        _check_approach(scene, scene.approach)


def _check_given_bodies(scene: Scene) -> None:
    """Check that bodies given by numbers have them for the grid."""
    if isinstance(scene.bodies, GivenBodies):
        scene.bodies.check(scene)


def _check_approach(scene: Scene, approach: float) -> None:
    """Check that an approach brings the bodies into contact."""
    least = 0.0
    if isinstance(scene.surface, SampledDistance):
        least = float(scene.surface.h.min())
    if approach <= least:
        raise bodies_apart(approach, least)


def bodies_apart(approach: float | None, least: float) -> NoContact:
    """The error for an approach that leaves the bodies apart."""
    message = (
        f"approach = {approach:.6g} gives no contact: "
        f"it must exceed the least undeformed distance, {least:.6g}"
    )
    return NoContact("approach", approach, message=message)


def _check_harmonic(scene: Scene) -> None:
    """Check that oscillating creepages are of elastic bodies that stick, with a reference for
    displacements.
    """
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
    """Refuse a problem that cannot be linearised."""
    if isinstance(scene.friction, Law) and scene.friction.continuous:
        allowed = "a number or StaticKinetic: it must not fall with slip velocity"
        raise SceneError("friction", scene.friction, allowed)
    if scene.flows:
        raise flow_refused(scene, "inf: linearised are layers that do not yield")
    if scene.conformal:
        raise SceneError(
            "surface.inclination", "given", "left out: linearised are bodies that meet on a plane"
        )
    if isinstance(scene.bodies, GivenBodies) and scene.bodies.by_place:
        allowed = "given by a symbol or a kernel by offset: linearised are bodies alike everywhere"
        raise SceneError("bodies", type(scene.bodies).__name__, allowed)
    if scene.displacements:
        allowed = "left out: the response of held parts is not known"
        raise SceneError("displacements", scene.displacements, allowed)


def check_differentiable(scene: Scene) -> None:
    """Refuse a problem that has no gradient by its inputs."""
    if isinstance(scene.motion, TimeStep) and scene.bodies.relaxes:
        bodies = type(scene.bodies).__name__
        raise SceneError("bodies", bodies, "elastic: steps of others have no gradient")
    if isinstance(scene.friction, Law):
        _check_law_differentiable(scene.friction)
    if scene.flows:
        raise flow_refused(scene, "inf: a layer that yields has no gradient")
    if scene.conformal:
        surface = type(scene.surface).__name__
        raise SceneError("surface", surface, "plane: a curved contact has no gradient")
    if scene.displacements is not None:
        displaced = type(scene.displacements).__name__
        allowed = "left out: a contact beside held parts has no gradient"
        raise SceneError("displacements", displaced, allowed)


def _check_law_differentiable(law: Law) -> None:
    """Refuse laws whose coefficient depends on more than the slip, pressure and place of an
    element.
    """
    if law.memory_distance > 0:
        allowed = "0: a law with a memory has no gradient"
        raise SceneError("friction.memory_distance", law.memory_distance, allowed)
    if law.warm:
        allowed = "a law that does not depend on temperature: that one has no gradient"
        raise SceneError("friction", type(law).__name__, allowed)


def _check_speed(scene: Scene) -> None:
    """Check the speed: viscoelastic bodies roll steadily at a speed, or step by step in time; other
    contacts need neither.
    """
    motion = scene.motion
    relaxes = scene.bodies.relaxes
    thermal = scene.thermal is not None
    needs_time = relaxes or (thermal and motion is not None)
    if needs_time and not isinstance(motion, Steady | TimeStep | Transient):
        allowed = "Steady(speed=...) or Transient(dt=...), with friction = 0 if need be"
        raise SceneError(
            "motion", motion, f"{allowed}: viscoelastic bodies and temperatures need time"
        )
    several_solids = isinstance(scene.bodies, BodyPair) and scene.bodies.of_several_solids
    if several_solids and not (scene.line and isinstance(motion, Steady)):
        allowed = (
            "of one solid (relaxations of the whole body), or in steady rolling in line contact"
        )
        raise SceneError("bodies.layers", scene.bodies, allowed)
    if isinstance(motion, Steady):
        _check_time(scene, "motion.speed", "the speed", motion.speed)
    if isinstance(motion, TimeStep | Transient):
        _check_time(scene, "motion.dt", "the time of a step", motion.dt)


def _check_time(scene: Scene, field: str, meaning: str, value: Any) -> None:
    """Check that speed or step times are given where bodies relax or heat up, and only there."""
    thermal = scene.thermal is not None
    if not scene.bodies.relaxes and not thermal:
        if value is not None:
            allowed = (
                f"left out: nothing depends on {meaning} "
                "unless bodies are Viscoelastic, or thermal is given"
            )
            raise SceneError(field, value, allowed)
        return
    if value is None:
        raise SceneError(
            field, None, f"given: viscoelastic bodies and temperatures depend on {meaning}"
        )
    if thermal and not np.all(np.asarray(value) > 0):
        raise SceneError(field, value, "positive: heat takes time")


def _check_surfaces(scene: Scene) -> None:
    """Check that only line contact has no rows, that nothing spins in it, and that surfaces of a
    history are alike and on a plane.
    """
    grid = scene.grid
    _check_tractions(scene)
    if isinstance(grid, Grid) and grid.line and not scene.line:
        raise SceneError("grid.ny", None, "given: only line contact has no rows")
    if scene.line:
        _check_turning(scene)
    for surface in scene.surfaces:
        if surface.line != scene.line or depth_of(surface) != scene.reference_depth:
            allowed = "as the scene's surface: line contact with the same reference_depth, or none"
            raise SceneError("motion.surface", surface, allowed)
    if scene.conformal or any(is_curved(surface) for surface in scene.surfaces):
        _check_conformal(scene)


def _check_turning(scene: Scene) -> None:
    """Refuse spin and rotation in line contact."""
    for name in ("spin", "rotation"):
        turns = np.atleast_1d(getattr(scene.motion, name, 0.0))
        if np.any(turns != 0):
            first = float(turns[turns != 0][0])
            raise SceneError(
                f"motion.{name}", first, "0 in line contact, where nothing depends on y"
            )


def _check_pin(scene: Scene) -> None:
    """Check that a pin and its hole are elastic, pressed by a force, on a grid of at most one
    turn.
    """
    pin = scene.surface
    if not isinstance(pin, PinInHole):
        return
    if not isinstance(scene.bodies, Bodies):
        allowed = "Bodies: influence numbers of a pin and of a hole are those of elastic bodies"
        raise SceneError("bodies", scene.bodies, allowed)
    if scene.approach is not None:
        allowed = "left out: give the normal_force, which presses the centre of the pin along z"
        raise SceneError("approach", scene.approach, allowed)
    if pin.clearance > CLEARANCE_MAX * pin.R:
        allowed = (
            f"at most {CLEARANCE_MAX:g} R, {CLEARANCE_MAX * pin.R:.6g}: "
            "surfaces that fit less are Cylinders(R=R * (R + clearance) / clearance)"
        )
        raise SceneError("surface.clearance", pin.clearance, allowed)
    if isinstance(scene.grid, Grid) and scene.grid.explicit:
        left, right, _, _ = scene.grid.box
        if max(-left, right) > math.pi * pin.R:
            allowed = f"within half a circle either way, {math.pi * pin.R:.6g}"
            raise SceneError("grid", (left, right), allowed)


def _check_tractions(scene: Scene) -> None:
    """Check that tractions linear between element centres belong to half-spaces in direct contact,
    without heat.
    """
    if not scene.own_grid.linear:
        return
    others: dict[str, Any] = {
        "bodies": scene.bodies,
        "third_body": scene.third_body,
        "thermal": scene.thermal,
    }
    if isinstance(scene.bodies, Bodies):
        del others["bodies"]
    if scene.conformal:
        others["a curved surface"] = scene.surface
    for name, value in others.items():
        if value is not None:
            allowed = '"constant": linear ones are for half-spaces that touch, without heat'
            raise SceneError("grid.tractions", f'"linear" with {name}', allowed)


def check_force_is_sum(scene: Scene) -> None:
    """Refuse a force that is not the sum of the pressures: programs do not find its approach."""
    if scene.force_is_sum:
        return
    if isinstance(scene.surface, PinInHole):
        allowed = "another than a pin in a hole, whose approach follows from its force"
        raise SceneError("surface", scene.surface, allowed)
    why = "the sum of conformal pressures is not the force"
    raise SceneError("normal_force", scene.normal_force, f"left out, with an approach: {why}")


def _check_turns(scene: Scene) -> None:
    """Refuse a curved surface that turns between elements by more than influence numbers allow."""
    surface = scene.surface
    grid = scene.grid
    if not isinstance(surface, SampledDistance) or not isinstance(grid, Grid) or not grid.explicit:
        return
    for name, angles in (
        ("inclination", surface.inclination_at(grid)),
        ("inclination_x", surface.inclination_x_at(grid)),
    ):
        turn = float(np.max(np.abs(np.diff(angles)), initial=0.0))
        if turn > STEP_TURN_MAX:
            value = f"a turn by {turn:.3g} rad from element to element"
            allowed = f"at most {STEP_TURN_MAX:g} rad: give smaller elements, or a larger radius"
            raise SceneError(f"surface.{name}", value, allowed)


def _check_conformal(scene: Scene) -> None:
    """Refuse a history in conformal contact, and a prescribed force along a curved axis."""
    _check_turns(scene)
    motion = scene.motion
    if isinstance(motion, TimeStep | Transient):
        raise SceneError(
            "motion",
            motion,
            "Steady or Shift: conformal contact (surface.inclination) has no history",
        )
    if motion is None:
        return
    for axis, curved in (
        ("x", is_curved_along_x(scene.surface)),
        ("y", is_curved_along_y(scene.surface)),
    ):
        force = getattr(motion, f"F{axis}")
        if curved and force is not None:
            allowed = (
                "left out: in conformal contact the pressure carries a part of it; "
                f"prescribe v{axis} or u{axis}"
            )
            raise SceneError(f"motion.F{axis}", force, allowed)


def why_centres(scene: Scene) -> str:
    """Reason why elements at the contact edge cannot count in part; empty where they can."""
    if scene.own_grid.linear:
        return "is for tractions that are constant in elements"
    if scene.coupled and not scene.frictionless:
        kind = f"unlike ({scene.difference})"
        if scene.conformal:
            kind = "conformal"
        return f"is for a pressure that tractions do not change, and the bodies are {kind}"
    heights = isinstance(scene.motion, Transient) and scene.motion.heights
    samples = [each for each in scene.surfaces if isinstance(each, SampledDistance)]
    if heights or any(each.x is None for each in samples):
        return "needs distances on parts of the elements, and samples without coordinates have none"
    return ""


def _check_friction(scene: Scene, problems: list[_Problem]) -> None:
    """Check that friction is given where there is a motion, and that a law by slip velocity has a
    rolling step.
    """
    for k, _, friction, motion in problems:
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
        if isinstance(friction, Law):
            rolls = k is None or motion is None or motion.rolls != 0
            _check_law(scene, friction, k, rolls)
    _check_start_of_warm(scene)


def _check_law(scene: Scene, law: Law, k: int | None, rolls: bool) -> None:
    """Check that a law has the thermal data, the factors on the grid, and the rolling step (of the
    number k) that it needs.
    """
    if law.warm and scene.thermal is None:
        raise SceneError("friction", law, "a law by slip: temperatures need thermal data")
    if isinstance(law, FrictionLaw):
        for factor in law.factors:
            if isinstance(factor, np.ndarray):
                _check_on_grid(scene, "friction.factors", factor)
    if rolls or isinstance(law, StaticKinetic | TemperatureFalling | PressureFalling):
        return
    field = "motion.friction"
    if law is scene.friction:
        field = "friction"
    allowed = (
        f"a law without slip velocity, as StaticKinetic: step {k} does not roll (motion.dq = 0)"
    )
    raise SceneError(field, law, allowed)


def _check_start_of_warm(scene: Scene) -> None:
    """Check that a history with friction by temperature starts from bodies without tractions, or
    from steady rolling at a speed.
    """
    if not scene.warm or not isinstance(scene.motion, Transient):
        return
    start = scene.motion.start
    if start is not None and start.scene.speed is None and start.traction.any():
        allowed = (
            "in steady rolling with a speed, or left out: "
            "friction depends on all that heated the bodies before"
        )
        raise SceneError("motion.start", type(start.motion).__name__, allowed)


def _check_by_element(scene: Scene) -> None:
    """Check that values by element fit the scene's own grid, and that its edge suits a history."""
    motion = scene.motion
    if isinstance(motion, Transient | TimeStep):
        _check_edge_of_history(scene)
    if isinstance(scene.friction, np.ndarray):
        friction = scene.friction
        _check_on_grid(scene, "friction", friction)
        for each in (friction.min(), friction.max(), *friction[friction > 0][:1]):
            coefficient("friction", float(each))
    for surface in scene.surfaces:
        if isinstance(surface, SampledDistance):
            _check_samples(scene, surface)
    if isinstance(motion, Steady) and motion.rigid_slip is not None:
        _check_rigid_slip(scene, motion.rigid_slip.shape)
    if isinstance(motion, Transient):
        for heights in motion.heights:
            _check_heights(scene, heights)


def _check_edge_of_history(scene: Scene) -> None:
    """Refuse softened edge elements in a history: particles cannot carry their edge compliance to
    the next step.
    """
    edges = ['"centres"']
    kind = "of viscoelastic bodies"
    if not scene.bodies.relaxes:
        edges.append('"touched"')
        kind = "of steps"
    if f'"{scene.edge}"' not in edges:
        raise SceneError("grid.edge", scene.edge, f"{' or '.join(edges)} in a history {kind}")


def _check_samples(scene: Scene, surface: SampledDistance) -> None:
    """Check that samples without coordinates lie on the grid; refuse others in a history of
    viscoelastic bodies.
    """
    if surface.x is None:
        _check_on_grid(scene, "surface.h", surface.samples)
    elif scene.bodies.relaxes and isinstance(scene.motion, Transient):
        allowed = "left out: in a history of viscoelastic bodies samples lie on the grid"
        raise SceneError("surface.x", "given", allowed)


def _check_rigid_slip(scene: Scene, shape: tuple[int, ...]) -> None:
    """Check that the rigid slip has a value at each sample of a `SampledDistance`."""
    name = "motion.rigid_slip"
    if not isinstance(scene.surface, SampledDistance):
        raise SceneError(name, shape, "left out: it is given at the samples of a SampledDistance")
    expected = (2, *scene.surface.samples.shape)
    if shape != expected:
        raise checks.wrong_shape(name, shape, f"(2, ny, nx) = {expected}")


def _check_heights(scene: Scene, heights: Carried) -> None:
    """Check that carried heights match surface, dimension and elements of the scene."""
    if isinstance(scene.surface, Ellipse):
        raise SceneError("surface", scene.surface, "Paraboloids, where motion.carried has heights")
    if scene.line and heights.y is not None:
        raise SceneError(
            "carried.y", heights.y, "left out in line contact, where nothing depends on y"
        )
    dx = 0.0
    if isinstance(scene.grid, Grid) and scene.grid.explicit:
        dx = scene.grid.sides[0]
    if heights.period is not None and heights.period < 2 * dx:
        allowed = f"at least two elements, {2 * dx:.6g}, or shorter elements"
        raise SceneError("carried.period", heights.period, allowed)


def _check_on_grid(scene: Scene, field: str, values: np.ndarray) -> None:
    """Check that an array by element has the shape of an explicit grid."""
    grid = scene.grid
    if not (isinstance(grid, Grid) and grid.explicit):
        entries = "nx, dx, x0"
        if not scene.line:
            entries = "nx, ny, dx, dy, x0, y0"
        raise SceneError("grid", grid, f"explicit ({entries}), as {field} is given on it")
    if values.shape == grid.shape:
        return
    shape = values.shape
    allowed = f"(ny, nx) = {grid.shape}"
    if scene.line:
        allowed = f"(nx,) = ({grid.nx},)"
        if shape[0] == 1:
            shape = shape[1:]
    raise checks.wrong_shape(field, shape, f"of the grid's shape {allowed}")


def _check_depth(scene: Scene, problems: list[_Problem]) -> None:
    """Check that line contact has a reference depth where displacements are prescribed or carried
    along.

    No depth is needed along a direction in which nothing moves, in which a force is prescribed all
    the time, or in steady rolling, where only differences of displacements count.
    """
    motion = scene.motion
    if scene.bodies.grounded and scene.reference_depth is not None:
        allowed = (
            "left out: the bodies rest on bases that do not move, "
            "and displacements count from there"
        )
        raise SceneError("surface.reference_depth", scene.reference_depth, allowed)
    if not scene.shift_undetermined or isinstance(motion, TimeStep):
        return
    for k, (_, approach), _, _ in problems:
        if approach is not None and scene.approach_undetermined:
            entry = "the approach"
            if k is not None:
                entry += f" of step {k}"
            raise _depth_for(scene, entry, "a normal force")
    if isinstance(motion, Shift | Transient):
        for i in (0, 1):
            if _moves(scene, problems, i):
                _check_depth_along(scene, problems, i)


def _moves(scene: Scene, problems: list[_Problem], i: int) -> bool:
    """True where anything moves along the direction i (0: x, 1: y) in a shift or history."""
    if i == 0 and scene.coupled and not scene.frictionless:
        return True
    if isinstance(scene.motion, Transient) and scene.motion.start is not None:
        start = scene.motion.start
        if np.any(np.abs(start.traction[i]) > 1e-9 * start.pressure.max()):
            return True
    if _is_moved_by_loads(scene, i):
        return True
    motions = [motion for _, _, _, motion in problems if motion is not None]
    return any((motion.Fx, motion.Fy)[i] or motion.rigid[i] for motion in motions)


def _is_moved_by_loads(scene: Scene, i: int) -> bool:
    """True where loads beside the contact shift it along the direction i."""
    return any(load.acts(i) or (i == 0 and load.acts_alone) for load in scene.loads or ())


def _check_depth_along(scene: Scene, problems: list[_Problem], i: int) -> None:
    """Check that, without a depth, the force along the direction i is prescribed in each
    problem.
    """
    force = ("Fx", "Fy")[i]
    for k, _, _, motion in problems:
        if motion is None or (motion.Fx, motion.Fy)[i] is not None:
            continue
        if k is None:
            raise _depth_for(scene, f"motion.{('ux', 'uy')[i]}", f"motion.{force}")
        raise _depth_for(
            scene, f"step {k}, without motion.{force},", f"motion.{force} in every step"
        )


def _depth_for(scene: Scene, entry: str, instead: str) -> SceneError:
    """Error for an entry that needs a reference depth for displacements."""
    if scene.bodies.slides:
        message = (
            f"{entry} has no meaning where a body slides on a smooth base. Prescribe {instead}"
        )
        return SceneError("bodies.base", "smooth", message=message)
    message = (
        f"{entry} needs surface.reference_depth: in line contact displacements are measured "
        f"from a depth. Give the depth, or prescribe {instead}"
    )
    return SceneError("surface.reference_depth", None, message=message)


def _check_third_body(scene: Scene) -> None:
    """Check that a softening layer has a history, and that friction on a yielding layer lets it
    slip eventually.
    """
    layer = scene.third_body
    motion = scene.motion
    if layer is None:
        return
    if layer.k_tau < 0 and isinstance(motion, Steady):
        allowed = (
            "zero or positive in steady rolling: a layer that softens has a history (Transient)"
        )
        raise hardening_refused(scene, allowed)
    if layer.yields and scene.no_slip:
        raise SceneError("friction", math.inf, "finite with a third_body that yields")
    second_order = scene.edge == "softened"
    if isinstance(motion, Steady | Harmonic) and motion.slip_difference != "first-order":
        second_order = True
    if second_order and layer.k_tau != 0:
        allowed = '0, or grid.edge "centres" and slip_difference "first-order"'
        raise hardening_refused(scene, allowed)


def flow_refused(scene: Scene, allowed: str) -> SceneError:
    """The error of a scene whose layer between the bodies flows."""
    assert scene.third_body is not None
    return SceneError("third_body.tau_c0", scene.third_body.tau_c0, allowed)


def hardening_refused(scene: Scene, allowed: str) -> SceneError:
    """The error of a scene whose layer between the bodies hardens or softens."""
    assert scene.third_body is not None
    return SceneError("third_body.k_tau", scene.third_body.k_tau, allowed)
