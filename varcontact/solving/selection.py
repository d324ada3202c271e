"""The choice behind "auto": which methods a scene is solved by, and why; what they need in
memory.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from varcontact.checks import choice, kind
from varcontact.discrete.contact_grid import given_grid, wanted_grid
from varcontact.discrete.state import cells_of
from varcontact.errors import SceneError
from varcontact.results.plan import Plan
from varcontact.scene.bodies import Bodies
from varcontact.scene.consistency import why_centres
from varcontact.scene.friction import FrictionBound, Law
from varcontact.scene.friction_laws import kind_of
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Harmonic, Shift, Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solvers import registry
from varcontact.solvers.registry import MATRIX_FREE, TANGENTIAL, states_programs
from varcontact.solving.pipeline import check_memory
from varcontact.theories.on_grid import THEORIES, why_not

COUPLING_METHODS = ("johnson", "panagiotopoulos", "joint", "newton")
FORMULATIONS = ("complementary", "potential", "gap", "marching")


@dataclass(frozen=True)
class Preset:
    """A value of `method`, in words, and its solvers where none is named.

    `fallback`: the solver of programs where active sets miss the tolerance.
    """

    why: str
    normal: str
    tangential: str
    fallback: str = "none"


PRESETS: dict[str, Preset] = {
    "auto": Preset(
        "the fastest method measured, or the solvers named", "norm", "tang-safeguarded", "clarabel"
    ),
    "convex": Preset(
        "requested: QP and SOCP by conic solvers, never polished by active sets",
        "clarabel",
        "clarabel",
    ),
    "active-set": Preset(
        "requested: NORM and the safeguarded TANG, without programs", "norm", "tang-safeguarded"
    ),
    "kalker": Preset("requested: NORM and TANG as printed, without programs", "norm", "tang-exact"),
}
"""By method. With "auto" any solver may be named."""

MANY, MANY_PRESSURES = 180, 400
"""Elements in contact beyond which "auto" takes Newton's method without a matrix, for the tractions
and for the pressure (docs/speed.md)."""
MANY_IN_STEPS, MANY_UNLIKE = 250, 100
"""The same for the tractions of a history, whose steps begin from the step before; and of unlike
bodies, whose pressure and tractions it finds together."""
SHORT, TOO_MANY = 0.05, 2000
"""A step of steady rolling by the length of an element, below which Newton's method takes longer
than active sets, and the elements beyond which these take hours."""

NEWTON = replace(PRESETS["auto"], normal="newton", tangential="newton")
NEWTON_TRACTIONS = replace(NEWTON, normal="norm")
"""What "auto" stands for with so many elements; and where the pressure has too few of them."""


def select(
    scene: Scene,
    normal: str = "auto",
    tangential: str = "auto",
    coupling: str = "auto",
    formulation: str = "auto",
    method: str = "auto",
) -> Plan:
    """The methods for a scene; a `SceneError` says which of those named cannot treat it, and what
    can.

    >>> import varcontact as vc
    >>> scene = vc.Scene(bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(0.46, 0.3), normal_force=1e5,
    ...                  friction=0.3, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=12, ny=12))
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
    wanted = {
        "normal": normal,
        "tangential": tangential,
        "coupling": coupling,
        "formulation": formulation,
    }
    for field, name in wanted.items():
        if not isinstance(name, str):
            raise SceneError(field, name, "the name of a method")
    _check_method(method)
    _check_solvers(scene, normal, tangential)
    choice("coupling", coupling, ("auto", *COUPLING_METHODS))
    choice("formulation", formulation, ("auto", *FORMULATIONS))

    preset = _preset(scene, wanted, method)
    reasons = {"method": PRESETS[method].why}
    of_normal, reasons["normal"] = _normal(scene, normal, preset, method)
    of_tangential, reasons["tangential"] = _tangential(scene, tangential, preset)
    bodies = "conformal" if scene.conformal else "unlike" if scene.coupled else "quasi-identical"
    plan = Plan(of_normal, of_tangential, "none", method=method, bodies=bodies)
    loop, reasons["coupling"] = _coupling(scene, wanted, plan)
    programs, reasons["formulation"] = _formulations(scene, plan)
    plan = replace(plan, coupling=loop, formulation=programs[0])
    _check_methods(scene, wanted, plan)
    if formulation not in ("auto", *programs):
        names = [f'"{name}"'.replace("none", "auto") for name in programs]
        last = f"{', '.join(names[:-1])} or {names[-1]}" if names[1:] else names[0]
        message = f'formulation = "{formulation}": {reasons["formulation"]}; use {last}'
        raise SceneError("formulation", formulation, last, message=message)
    if formulation != "auto":
        plan = replace(plan, formulation=formulation)
        reasons["formulation"] = "requested"
    fallback = (
        preset.fallback if (tangential, plan.tangential) == ("auto", preset.tangential) else "none"
    )
    surface = "Hertzian" if isinstance(scene.bodies, Bodies) else "analytic"
    kinds = {
        Transient: "transient",
        Shift: "shift",
        Steady: "marching" if plan.formulation == "marching" else "steady",
    }
    laws = {
        kind_of(friction) if isinstance(friction, Law) else "given" for friction in scene.frictions
    }
    special = (
        ()
        if scene.motion is None
        else ("frictionless",) * scene.frictionless + ("no slip",) * scene.no_slip
    )
    return replace(
        plan,
        reasons=reasons,
        dimension="line contact" if scene.line else "three-dimensional",
        surface="sampled" if isinstance(scene.surface, SampledDistance) else surface,
        motion="none" if scene.motion is None else kinds[type(scene.motion)],
        friction="none" if not plan.has_friction else laws.pop() if len(laws) == 1 else "several",
        special=special,
        fallback=fallback,
    )


def _check_method(method: str) -> None:
    """Refuse a name that is no method; where it is one of something else, say of what."""
    arguments = {
        "tangential": [*registry.tangential_methods(), *THEORIES],
        "normal": registry.normal_methods(),
        "coupling": COUPLING_METHODS,
        "formulation": FORMULATIONS,
    }
    if isinstance(method, str) and method not in PRESETS:
        meant = [
            f'{argument}="{method}"' for argument, names in arguments.items() if method in names
        ]
        if meant:
            raise SceneError(
                "method", method, f"one of {', '.join(PRESETS)}; did you mean {' or '.join(meant)}?"
            )
    choice("method", method, PRESETS)


def _check_solvers(scene: Scene, normal: str, tangential: str) -> None:
    """Refuse names of solvers that there are not, that are not installed, or that are for the other
    problem.
    """
    if normal != "auto":
        registry.available("normal", normal, ("auto", *registry.normal_methods()))
    if tangential != "auto":
        methods = registry.tangential_methods()
        if one_direction(scene):  # Coulomb's disks then are intervals, and all programs quadratic
            methods += [
                name
                for name in registry.normal_methods()
                if states_programs(name) and name not in methods
            ]
        if tangential in registry.normal_methods() and tangential not in methods:
            why = "it is for normal problems"
            if states_programs(tangential):
                why = "it solves QPs, and Coulomb's disks are second-order cones"
            raise SceneError(
                "tangential", tangential, f"one of {', '.join(methods)}, or a theory: {why}"
            )
        registry.available("tangential", tangential, ("auto", *methods, *THEORIES))


def _preset(scene: Scene, wanted: dict[str, str], method: str) -> Preset:
    """What the `method` stands for; "auto" by what else is named and by the number of elements in
    contact.

    That is Newton's method where its products beat dense matrices, by one problem or by many in a
    row.
    """
    motion = scene.motion
    coupling = wanted["coupling"]
    formulation = wanted["formulation"]
    if method != "auto":
        return PRESETS[method]
    if formulation == "marching" and isinstance(motion, Steady):
        return PRESETS["auto"]
    if formulation != "auto":
        return PRESETS["convex"]  # only programs have one
    if coupling == "newton":
        return NEWTON
    if scene.hardens and not scene.coupled:
        return NEWTON_TRACTIONS  # others take many passes over the yield stress
    count, dx = elements_in_contact(scene)
    if own_image(scene) or one_direction(scene):
        count /= 2  # active sets have half the unknowns
    if isinstance(motion, Steady) and motion.dq is not None and motion.dq < SHORT * dx:
        return NEWTON if count > TOO_MANY else PRESETS["auto"]
    if scene.coupled and not scene.frictionless:
        together = coupling == "auto" and {wanted["normal"], wanted["tangential"]} <= {
            "auto",
            "newton",
        }
        return NEWTON if count > (MANY_UNLIKE if together else MANY) else PRESETS["auto"]
    if elements_in_contact(scene)[0] > MANY_PRESSURES:
        return NEWTON
    many = count > (MANY_IN_STEPS if isinstance(motion, Transient) else MANY)
    return NEWTON_TRACTIONS if many and not scene.frictionless else PRESETS["auto"]


def _why_not_hertz(scene: Scene) -> str:
    """Why the pressure is not Hertz's; nothing where it is."""
    if getattr(scene.motion, "heights", ()) or any(
        isinstance(surface, SampledDistance) for surface in scene.surfaces
    ):
        return "is for paraboloids, ellipses and cylinders"
    if not isinstance(scene.bodies, Bodies):
        return "is for half-spaces, Bodies(G, nu)"
    if scene.coupled and not scene.frictionless:
        return f"ignores tangential tractions, and here there is friction and {scene.difference}"
    return ""


def _normal(scene: Scene, wanted: str, preset: Preset, method: str) -> tuple[str, str]:
    if wanted != "auto":
        return wanted, "requested; closed form" if wanted == "hertz" else "requested"
    why = _why_not_hertz(scene)
    if not why:
        return (
            "hertz",
            "closed form: the surface is Hertzian, and tractions do not change the pressure",
        )
    if scene.edge != "centres" and method == "auto":  # on parts of the elements
        unknowns = elements_in_contact(scene)[0] * math.prod(cells_of(scene.edge, scene.line))
        preset = NEWTON if unknowns > MANY_PRESSURES else preset
    return preset.normal, f"{_how(preset.normal)}; Hertz's pressure {why}"


def _how(solver: str) -> str:
    if states_programs(solver):
        return "a convex program"
    if solver in MATRIX_FREE:
        return "matrix-free Newton, the fastest at this size"
    return (
        "active sets, as printed"
        if solver == "tang-exact"
        else "active sets, the fastest at this size"
    )


def _tangential(scene: Scene, wanted: str, preset: Preset) -> tuple[str, str]:
    if scene.motion is None:
        return "none", "no motion"
    if scene.frictionless:
        return "none", "no friction, no traction"
    if wanted in THEORIES:
        return wanted, "requested: an approximate theory; the certificate measures its error"
    solver = preset.tangential if wanted == "auto" else wanted
    if scene.no_slip and solver not in MATRIX_FREE:
        return "no-slip", "friction is infinite: nothing slips, one linear system"
    if wanted != "auto":
        return wanted, "requested"
    return solver, _how(solver) + "; falls back to the convex program" * (preset.fallback != "none")


def _coupling(scene: Scene, wanted: dict[str, str], plan: Plan) -> tuple[str, str]:
    if scene.frictionless:
        return "none", "no tangential traction"
    if not scene.coupled:
        return "none", "like bodies (K = 0): normal problem first, then the tangential problem"
    coupling = wanted["coupling"]
    unlike = f"{plan.bodies} bodies ({scene.difference})"
    if coupling == "johnson":
        return coupling, "requested: one pass, with the pressure of frictionless contact"
    if coupling == "joint":
        return (
            coupling,
            "requested: pressure and tractions together, with only the traction bound fixed in a pass",
        )
    if coupling == "newton" or (
        coupling == "auto" and not _not_coupled_newton(scene, wanted, plan)
    ):
        return (
            "newton",
            f"{unlike}: pressure and tractions together; falls back to alternating passes",
        )
    return "panagiotopoulos", f"{unlike}: alternating normal and tangential problems"


def _not_coupled_newton(scene: Scene, wanted: dict[str, str], plan: Plan) -> str:
    """Why Newton's method is not for pressure and tractions together; nothing where it is."""
    if scene.no_slip:
        return "infinite friction has no traction bound that follows the pressure"
    if any(isinstance(friction, FrictionBound) for friction in scene.frictions):
        return "the traction bound is no coefficient times the pressure"
    if scene.third_body is not None and scene.third_body.yields:
        return "the yield stress of a third body does not follow the pressure"
    if wanted["formulation"] == "marching" and isinstance(scene.motion, Steady):
        return "a march solves its steps in turn"
    solvers = {"normal": plan.normal, "tangential": plan.tangential}
    others = [
        f'{problem} = "{solver}"' for problem, solver in solvers.items() if solver != "newton"
    ]
    return f'it needs "newton" for both problems, not {" and ".join(others)}' if others else ""


def _formulations(scene: Scene, plan: Plan) -> tuple[tuple[str, ...], str]:
    """Formulations that a plan may have, the default first, and why these."""
    steady = isinstance(scene.motion, Steady)
    tangential = plan.tangential
    if states_programs(tangential):
        if steady:
            return ("gap", "marching"), "steady rolling has no energy formulation"
        return (
            "complementary",
            "potential",
            "gap",
        ), "the fewest unknowns; marching is for steady rolling"
    if tangential in ("none", "no-slip") and states_programs(plan.normal):
        return (
            "complementary",
            "potential",
        ), "the fewest unknowns, and only the normal problem is a program"
    if tangential in TANGENTIAL and steady:
        return ("none", "marching"), f"{tangential} does not solve a program"
    return ("none",), "no program is solved"


def _check_methods(scene: Scene, wanted: dict[str, str], plan: Plan) -> None:
    """Refuse what of the methods named cannot treat the scene."""
    normal = wanted["normal"]
    tangential = wanted["tangential"]
    why = _why_not_hertz(scene)
    if normal == "hertz" and why:
        raise SceneError("normal", normal, f'"norm" or "clarabel": Hertz\'s pressure {why}')
    why = why_centres(scene) if scene.edge != "centres" and not plan.closed_form else ""
    # what part of an element bears pressure is found before the tractions, from distances all over
    # it
    if why:
        remedy = (
            "use"
            if scene.coupled and not scene.frictionless
            else "give surface.x and surface.y, or use"
        )
        message = f'grid.edge = "{scene.edge}" {why}; {remedy} "centres"'
        raise SceneError("grid.edge", scene.edge, message=message)
    why = why_not(tangential, scene) if tangential in THEORIES and plan.has_friction else ""
    if why:
        raise SceneError("tangential", tangential, f"another method: {why}")
    preset = PRESETS[plan.method]
    for field, solvers in (("normal", registry.NORMAL), ("tangential", TANGENTIAL)):
        name = wanted[field]
        own = getattr(preset, field)
        convex = plan.method == "convex"
        known = (
            [own]
            if plan.method == "kalker"
            else [each for each in solvers if each not in MATRIX_FREE]
        )
        words = "a solver of programs, such as clarabel or scs" if convex else " or ".join(known)
        belongs = states_programs(name) if convex else name in known
        if plan.method != "auto" and not belongs and name not in ("auto", "hertz"):
            remedy = f'{words} with method = "{plan.method}"; with method = "auto" any solver may be named'
            raise SceneError(field, name, remedy)
    why = (
        _not_coupled_newton(scene, wanted, plan)
        if wanted["coupling"] == plan.coupling == "newton"
        else ""
    )
    if why:
        raise SceneError("coupling", "newton", f'"panagiotopoulos": {why}')
    difference = scene.motion.slip_difference if isinstance(scene.motion, Steady) else "first-order"
    if wanted["formulation"] == "marching" and difference != "first-order":
        allowed = f'"auto" or "gap" with motion.slip_difference = "{difference}"'
        raise SceneError("formulation", "marching", allowed)


def one_direction(scene: Scene) -> bool:
    """Whether tractions can arise along x only or along y only: in line contact, where nothing
    moves along y or x.
    """
    motion = scene.motion
    if not scene.line or not isinstance(motion, (Steady, Shift)):
        return False
    along_x = motion.rigid[0] != 0 or motion.Fx is not None or scene.coupled
    along_y = motion.rigid[1] != 0 or motion.Fy is not None
    return not (along_x and along_y)


def own_image(scene: Scene) -> bool:
    """Whether a Hertzian contact with an even number of rows is known to be its own mirror image
    about the x-axis.

    With x its tractions along x are even in y and those along y odd where nothing moves along y, or
    about z; and the other way round where nothing moves along x.
    """
    motion = scene.motion
    grid = scene.grid
    placed = isinstance(grid, Grid) and not grid.explicit and grid.rows % 2 == 0
    if not placed or scene.line or scene.hertz is None or not isinstance(motion, (Steady, Shift)):
        return False
    if scene.coupled or isinstance(scene.friction, np.ndarray | FrictionBound):
        return False
    along_x, along_y, about_z = motion.rigid
    straight = along_y == about_z == 0 and motion.Fy is None
    return straight or (along_x == 0 and motion.Fx is None)


def elements_in_contact(scene: Scene) -> tuple[float, float]:
    """The number of elements in contact, about, and their length along x; zero where that is not
    known.
    """
    grid = given_grid(scene)
    # each step of a history has its own
    hertz = None if isinstance(scene.motion, Transient) else scene.hertz
    if not grid.explicit:
        count = grid.nx * (1.0 if grid.line else np.pi / 4 * grid.rows)
        return count, 0.0 if hertz is None else 2 * hertz.a / grid.nx
    dx, dy = grid.sides
    if hertz is None:
        surface = scene.surface
        approach = scene.approach
        if (
            type(scene.bodies) is Bodies
            and isinstance(surface, SampledDistance)
            and isinstance(approach, float)
        ):
            # half of the elements that overlap are in contact in Hertz's, and fewer in line contact
            return float(np.count_nonzero(surface.distance(grid) < approach)) / 2, dx
        return grid.size, dx
    return (2 * hertz.a if grid.line else np.pi * hertz.a * hertz.b / dy) / dx, dx


def tangential_unknowns(scene: Scene, plan: Plan, elements: float) -> float:
    """Traction components on so many elements, on one side of a line of symmetry where the plan
    uses it.
    """
    halved = plan.solves and plan.tangential not in MATRIX_FREE and own_image(scene)
    return (1 if one_direction(scene) else 2) * elements / (2 if halved else 1)


def check_fits(scene: Scene, plan: Plan) -> None:
    """Refuse a contact that is known not to fit into memory before any work; of others each problem
    as it is posed.
    """
    wanted_grid(scene)
    if plan.closed_form and plan.solves and not isinstance(scene.motion, Transient):
        unknowns = tangential_unknowns(scene, plan, elements_in_contact(scene)[0])
        check_memory("tangential", plan.tangential, plan.formulation, unknowns)
