"""Choice of methods for "auto", with reasons, and refusals of unsuitable ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from varcontact.checks import kind
from varcontact.discrete.contact_grid import PotentialContact, check_loads
from varcontact.discrete.state import cells_of
from varcontact.errors import SceneError
from varcontact.results.plan import ACTIVE_SETS, AT_ONCE, Plan
from varcontact.scene.bodies import Bodies
from varcontact.scene.consistency import why_centres
from varcontact.scene.friction import FrictionBound
from varcontact.scene.motion import Harmonic, Shift, Steady, TimeStep
from varcontact.scene.pin import PinInHole
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solvers import registry
from varcontact.solvers.interface import SHORT_STEP
from varcontact.solvers.registry import Kind, SolverSpec, matrix_free, solver_spec, states_program
from varcontact.solving.methods import AUTO, Methods
from varcontact.solving.pipeline import elements_in_contact, one_direction, own_image
from varcontact.system.process import changed
from varcontact.theories.on_grid import THEORIES, why_not


@dataclass(frozen=True)
class Preset:
    """Reason for the value of `method`, and its default solvers."""

    why: str
    normal: str
    tangential: str


PRESETS: dict[str, Preset] = {
    "auto": Preset("the fastest method measured, or the solvers named", "norm", "tang-safeguarded"),
    "convex": Preset(
        "requested: the convex problems by splitting, proved to converge wherever the symmetric "
        "part is positive definite",
        "splitting",
        "splitting",
    ),
    "conic": Preset(
        "requested: QP and SOCP by conic solvers, refined by splitting", "clarabel", "clarabel"
    ),
    "active-set": Preset(
        "requested: NORM and the safeguarded TANG, without programs", "norm", "tang-safeguarded"
    ),
    "kalker": Preset("requested: NORM and TANG as printed, without programs", "norm", "tang-exact"),
}
"""Solvers and reasons by method. With "auto" any solver may be named; its entry is for few
elements, and `NEWTON` takes its place above the numbers below."""

CONIC = {"normal": ("clarabel", "osqp"), "tangential": ("clarabel",)}
"""Solvers of the method "conic": of the QP and of the second-order-cone program."""

NEWTON_ABOVE = 140
"""Elements in contact above which "auto" solves the tangential problem by Newton's method without a
matrix, below by TANG (docs/speed.md)."""
NEWTON_ABOVE_NORMAL = 400
"""Elements in contact above which "auto" solves the normal problem by Newton's method, below by
NORM."""
NEWTON_ABOVE_UNLIKE = 120
"""Elements in contact above which "auto" finds pressure and tractions of unlike bodies together by
Newton's method."""
MOST_BY_ACTIVE_SETS = 2000
"""Elements beyond which active sets take hours."""

NEWTON = replace(PRESETS["auto"], normal="newton", tangential="newton")
NEWTON_TRACTIONS = replace(NEWTON, normal="norm")
"""Presets in place of "auto" for many elements: Newton's method for both problems, or for tractions
alone where the pressure has few elements."""


def select(scene: Scene, methods: Methods = AUTO) -> Plan:
    """The methods for a scene; a `SceneError` says which of those named cannot treat it, and what
    can.

    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(0.46, 0.3), normal_force=1e5,
    ...     friction=0.3, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=12, ny=12))
    >>> plan = select(scene)
    >>> plan.normal, plan.tangential, plan.coupling
    ('hertz', 'tang-safeguarded', 'none')
    """
    kind("scene", scene, Scene)
    if isinstance(scene.motion, TimeStep):
        raise SceneError(
            "motion", scene.motion, "a Transient: a TimeStep continues from the step before it"
        )
    if isinstance(scene.motion, Harmonic):
        allowed = "Steady, Shift or Transient: complex amplitudes are given by solve(scene) alone"
        raise SceneError("motion", scene.motion, allowed)
    _check_solvers(scene, methods)
    grid = PotentialContact.of(scene)
    if grid.form.explicit:
        everywhere = np.broadcast_to(True, grid.form.shape)
        check_loads(scene, grid.form, everywhere, "potential contact")

    # the methods, each with its reason
    preset = _preset(scene, methods)
    reasons = {"method": PRESETS[methods.method].why}
    normal, reasons["normal"] = _normal(scene, methods, preset)
    tangential, reasons["tangential"] = _tangential(scene, methods.tangential, preset)
    plan = Plan(normal, tangential, "none", method=methods.method, bodies=scene.kind_of_bodies)
    loop, reasons["coupling"] = _coupling(scene, methods, plan)
    programs, reasons["formulation"] = _formulations(scene, plan)
    plan = changed(plan, coupling=loop, formulation=programs[0])
    _check_methods(scene, methods, plan)
    _check_formulation(methods.formulation, programs, reasons["formulation"])
    if methods.formulation != "auto":
        plan = replace(plan, formulation=methods.formulation)
        reasons["formulation"] = "requested"
    # the kind of the scene, in words
    special = []
    if scene.motion is not None and scene.frictionless:
        special.append("frictionless")
    if scene.motion is not None and scene.no_slip:
        special.append("no slip")
    return changed(
        plan,
        reasons=reasons,
        dimension="line contact" if scene.line else "three-dimensional",
        surface=_kind_of_surface(scene),
        motion=_kind_of_motion(scene, plan),
        friction=_kind_of_friction(scene, plan),
        special=tuple(special),
        grid=grid,
    )


def _kind_of_surface(scene: Scene) -> str:
    if isinstance(scene.surface, SampledDistance):
        return "sampled"
    return "Hertzian" if isinstance(scene.bodies, Bodies) else "analytic"


def _kind_of_motion(scene: Scene, plan: Plan) -> str:
    match scene.motion:
        case None:
            return "none"
        case Transient():
            return "transient"
        case Shift():
            return "shift"
    return "marching" if plan.formulation == "marching" else "steady"


def _kind_of_friction(scene: Scene, plan: Plan) -> str:
    if not plan.has_friction:
        return "none"
    return scene.kind_of_friction


def _check_formulation(formulation: str, programs: tuple[str, ...], reason: str) -> None:
    """Refuse a formulation that the plan's solvers have not."""
    if formulation in ("auto", *programs):
        return
    *others, allowed = [f'"{name}"'.replace("none", "auto") for name in programs]
    if others:
        allowed = f"{', '.join(others)} or {allowed}"
    message = f'formulation = "{formulation}": {reason}; use {allowed}'
    raise SceneError("formulation", formulation, allowed, message=message)


def check_existing(methods: Methods) -> None:
    """Refuse names that no solver and no theory has, whatever the scene."""
    if methods.normal not in ("auto", "hertz"):
        _normal_spec(methods.normal)
    if methods.tangential not in ("auto", *THEORIES):
        names = ("auto", *registry.tangential_methods(), *THEORIES)
        registry.solver("tangential", methods.tangential, names)


def _check_solvers(scene: Scene, methods: Methods) -> None:
    """Refuse solvers that do not exist, are not installed, or are for the other problem."""
    if methods.normal not in ("auto", "hertz"):
        registry.check_installed(_normal_spec(methods.normal))
    if methods.tangential not in ("auto", *THEORIES):
        registry.check_installed(_tangential_spec(scene, methods.tangential))


def _normal_spec(name: str) -> SolverSpec:
    """The solver of the normal problem with a name."""
    return registry.solver("normal", name, ("auto", *registry.normal_methods()))


def _tangential_spec(scene: Scene, name: str) -> SolverSpec:
    """The solver of a name, if it is one for the scene's tangential problem."""
    spec = solver_spec("tangential", name)
    methods = registry.tangential_methods()
    if one_direction(scene):  # Coulomb's disks then are intervals, and all programs quadratic
        every = [each.name for each in registry.solvers("tangential")]
        methods += [each for each in every if each not in methods]
    elif spec is not None and spec.intervals_only:
        why = "it solves QPs, and Coulomb's disks are second-order cones"
        raise _not_for_tractions(name, methods, why)
    if spec is None and name in registry.normal_methods():
        raise _not_for_tractions(name, methods, "it is for normal problems")
    return registry.solver("tangential", name, ("auto", *methods, *THEORIES))


def _not_for_tractions(name: str, methods: list[str], why: str) -> SceneError:
    allowed = f"one of {', '.join(methods)}, or a theory: {why}"
    return SceneError("tangential", name, allowed)


def _preset(scene: Scene, requested: Methods) -> Preset:
    """Solvers for a method; for "auto" by the other names given and the number of elements in
    contact.
    """
    if requested.method != "auto":
        return PRESETS[requested.method]
    if requested.formulation == "marching" and isinstance(scene.motion, Steady):
        return PRESETS["auto"]
    if requested.formulation != "auto":
        return PRESETS["conic"]  # only programs have one
    if requested.coupling == "newton":
        return NEWTON
    if requested.coupling == "splitting":
        return PRESETS["convex"]
    if requested.coupling == "active-set":
        return PRESETS["active-set"]
    if scene.hardens and not scene.coupled:
        return NEWTON_TRACTIONS  # other methods take many passes over the yield stress
    return _preset_by_size(scene, requested)


def _preset_by_size(scene: Scene, requested: Methods) -> Preset:
    """Newton's method for many elements, where its products are faster than the dense matrices of
    active sets.
    """
    motion = scene.motion
    elements, dx = elements_in_contact(scene)
    count = elements
    # active sets have half the unknowns, and along a line products by FFT gain less
    if own_image(scene):
        count /= 2
    elif one_direction(scene) or (scene.line and isinstance(motion, Transient)):
        count /= 2.5
    if _has_short_steps(motion, dx):
        return NEWTON if count > MOST_BY_ACTIVE_SETS else PRESETS["auto"]
    # unlike bodies
    if scene.coupled and not scene.frictionless:
        solvers = {requested.normal, requested.tangential}
        together = requested.coupling == "auto" and solvers <= {"auto", "newton"}
        limit = NEWTON_ABOVE_UNLIKE if together else NEWTON_ABOVE
        return NEWTON if count > limit else PRESETS["auto"]
    # like bodies
    if elements > NEWTON_ABOVE_NORMAL:
        return NEWTON
    if count > NEWTON_ABOVE and not scene.frictionless:
        return NEWTON_TRACTIONS
    return PRESETS["auto"]


def _has_short_steps(motion: object, dx: float) -> bool:
    return isinstance(motion, Steady) and motion.dq is not None and motion.dq < SHORT_STEP * dx


def why_not_hertz(scene: Scene) -> str:
    """Reason why the pressure is not Hertz's; empty where it is."""
    rough = isinstance(scene.motion, Transient) and bool(scene.motion.heights)
    if rough or any(isinstance(each, SampledDistance | PinInHole) for each in scene.surfaces):
        return "is for paraboloids, ellipses and cylinders"
    if not isinstance(scene.bodies, Bodies):
        return "is for half-spaces, Bodies(G, nu)"
    if scene.coupled and not scene.frictionless:
        return f"ignores tangential tractions, and here there is friction and {scene.difference}"
    if scene.raised:
        return "is for surfaces without loads beside the contact"
    return ""


def _normal(scene: Scene, requested: Methods, preset: Preset) -> tuple[str, str]:
    if requested.normal == "hertz":
        return "hertz", "requested; closed form"
    if requested.normal != "auto":
        return requested.normal, "requested"
    why = why_not_hertz(scene)
    if not why:
        closed_form = (
            "closed form: the surface is Hertzian, and tractions do not change the pressure"
        )
        return "hertz", closed_form
    if scene.edge != "centres" and requested.method == "auto":  # on parts of the elements
        unknowns = elements_in_contact(scene)[0] * math.prod(cells_of(scene.edge, scene.line))
        if unknowns > NEWTON_ABOVE_NORMAL:
            preset = NEWTON
    return preset.normal, f"{_how('normal', preset.normal)}; Hertz's pressure {why}"


def _how(kind: Kind, solver: str) -> str:
    if states_program(kind, solver):
        return "a convex program"
    if solver == "splitting":
        return "projection and contraction, without a matrix"
    if matrix_free(kind, solver):
        return "matrix-free Newton, the fastest at this size"
    if solver == "tang-exact":
        return "active sets, as printed"
    return "active sets, the fastest at this size"


def _tangential(scene: Scene, requested: str, preset: Preset) -> tuple[str, str]:
    if scene.motion is None:
        return "none", "no motion"
    if scene.frictionless:
        return "none", "no friction, no traction"
    if requested in THEORIES:
        return requested, "requested: an approximate theory; the certificate measures its error"
    solver = requested
    if requested == "auto":
        solver = preset.tangential
    if scene.no_slip and not matrix_free("tangential", solver):
        return "no-slip", "friction is infinite: nothing slips, one linear system"
    if requested != "auto":
        return requested, "requested"
    how = _how("tangential", solver)
    spec = solver_spec("tangential", solver)
    if spec is None or not spec.falls_back:
        return solver, how
    return solver, f"{how}; falls back to splitting"


def _coupling(scene: Scene, requested: Methods, plan: Plan) -> tuple[str, str]:
    if scene.frictionless:
        return "none", "no tangential traction"
    if not scene.coupled:
        return "none", "like bodies (K = 0): normal problem first, then the tangential problem"
    coupling = requested.coupling
    unlike = f"{plan.bodies} bodies ({scene.difference})"
    if coupling == "johnson":
        return coupling, "requested: one pass, with the pressure of frictionless contact"
    if coupling == "joint":
        together = "pressure and tractions together, with only the traction bound fixed in a pass"
        return coupling, f"requested: {together}"
    if coupling == "auto":
        fitting = [name for name in AT_ONCE if not _why_not_at_once(name, scene, requested, plan)]
        coupling = next(iter(fitting), coupling)
    if coupling in AT_ONCE:
        together = "pressure and tractions together; falls back to alternating passes"
        return coupling, f"{unlike}: {together}"
    return "panagiotopoulos", f"{unlike}: alternating normal and tangential problems"


def _why_not_at_once(coupling: str, scene: Scene, requested: Methods, plan: Plan) -> str:
    """Reason why "newton", "splitting" or "active-set" cannot solve pressure and tractions
    together; empty where it can.
    """
    if scene.no_slip:
        return "infinite friction has no traction bound that follows the pressure"
    if any(isinstance(friction, FrictionBound) for friction in scene.frictions):
        return "the traction bound is no coefficient times the pressure"
    if scene.flows:
        return "the yield stress of a third body does not follow the pressure"
    if requested.formulation == "marching" and isinstance(scene.motion, Steady):
        return "a march solves its steps in turn"
    needed = {"normal": coupling, "tangential": coupling}
    if coupling == "active-set":
        needed = {problem: ACTIVE_SETS[problem] for problem in ("normal", "tangential")}
    solvers = {"normal": plan.normal, "tangential": plan.tangential}
    others = [
        f'{problem} = "{name}"' for problem, name in solvers.items() if name != needed[problem]
    ]
    if others:
        names = " and ".join(f'"{name}"' for name in dict.fromkeys(needed.values()))
        return f"it needs {names} for both problems, not {' and '.join(others)}"
    return ""


def _formulations(scene: Scene, plan: Plan) -> tuple[tuple[str, ...], str]:
    """Formulations that a plan may have, the default first, and the reason."""
    steady = isinstance(scene.motion, Steady)
    tangential = plan.tangential
    if states_program("tangential", tangential):
        if steady:
            return ("gap", "marching"), "steady rolling has no energy formulation"
        reason = "the fewest unknowns; marching is for steady rolling"
        return ("complementary", "potential", "gap"), reason
    if tangential in ("none", "no-slip") and plan.states_program("normal"):
        reason = "the fewest unknowns, and only the normal problem is a program"
        return ("complementary", "potential"), reason
    if plan.solver_of("tangential") is not None and steady:
        return ("none", "marching"), f"{tangential} does not solve a program"
    return ("none",), "no program is solved"


def _check_methods(scene: Scene, requested: Methods, plan: Plan) -> None:
    """Refuse methods that cannot treat the scene."""
    if requested.normal == "hertz" and (why := why_not_hertz(scene)):
        allowed = f'"norm" or "clarabel": Hertz\'s pressure {why}'
        raise SceneError("normal", "hertz", allowed)
    _check_edge(scene, plan)
    if requested.tangential in THEORIES and plan.has_friction:
        why = why_not(requested.tangential, scene)
        if why:
            raise SceneError("tangential", requested.tangential, f"another method: {why}")
    if plan.method != "auto":
        _check_belongs("normal", requested.normal, plan.method)
        _check_belongs("tangential", requested.tangential, plan.method)
    _check_at_once(scene, requested, plan)
    if requested.formulation == "marching" and isinstance(scene.motion, Steady):
        difference = scene.motion.slip_difference
        if difference != "first-order":
            allowed = f'"auto" or "gap" with motion.slip_difference = "{difference}"'
            raise SceneError("formulation", "marching", allowed)


def _check_at_once(scene: Scene, requested: Methods, plan: Plan) -> None:
    """Refuse a solver for pressure and tractions together that cannot treat the scene."""
    if not plan.at_once or requested.coupling != plan.coupling:
        return
    why = _why_not_at_once(plan.coupling, scene, requested, plan)
    if why:
        raise SceneError("coupling", plan.coupling, f'"panagiotopoulos": {why}')


def _check_edge(scene: Scene, plan: Plan) -> None:
    """Refuse edge elements that count in part where this part cannot be found before the tractions,
    from distances all over the elements.
    """
    if scene.edge == "centres" or plan.closed_form:
        return
    why = why_centres(scene)
    if not why:
        return
    remedy = "give surface.x and surface.y, or use"
    if scene.coupled and not scene.frictionless:
        remedy = "use"
    message = f'grid.edge = "{scene.edge}" {why}; {remedy} "centres"'
    raise SceneError("grid.edge", scene.edge, message=message)


def _check_belongs(field: Kind, name: str, method: str) -> None:
    """Refuse a solver that a method other than "auto" has not."""
    if method == "active-set":
        names = [
            each.name
            for each in registry.solvers(field)
            if not each.matrix_free and not each.states_program
        ]
    elif method == "conic":
        names = list(CONIC[field])
    else:
        names = [getattr(PRESETS[method], field)]
    if name not in (*names, "auto", "hertz"):
        remedy = f'{" or ".join(names)} with method = "{method}"'
        raise SceneError(field, name, f'{remedy}; with method = "auto" any solver may be named')
