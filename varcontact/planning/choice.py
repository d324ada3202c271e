"""The choice behind a plan: which methods a scene is solved by, and why. It is made once, here."""

from __future__ import annotations

from dataclasses import replace

from varcontact.checks import choice
from varcontact.errors import SceneError
from varcontact.planning.kinds import kinds_of, one_direction, special_of
from varcontact.planning.plan import Plan
from varcontact.planning.roads import MANY_ELEMENTS, Road, check_on_road, for_many_elements, many_on_parts, road
from varcontact.scene.consistency import why_centres
from varcontact.scene.likeness import almost_like, left_out
from varcontact.scene.motion import Steady, TimeStep, Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solvers.registry import (
    MATRIX_FREE,
    TANGENTIAL,
    available,
    normal_methods,
    states_programs,
    tangential_methods,
)
from varcontact.theories.methods import THEORIES, why_not

COUPLING_METHODS = ("johnson", "panagiotopoulos", "joint", "newton")
FORMULATIONS = ("complementary", "potential", "gap", "marching")


def make_plan(
    scene: Scene,
    normal: str = "auto",
    tangential: str = "auto",
    coupling: str = "auto",
    formulation: str = "auto",
    method: str = "auto",
) -> Plan:
    """Choose the methods for a scene: a plan without sizes.

    Parameters
    ----------
    scene : Scene
    normal, tangential, coupling, formulation, method : str
        By name, or "auto".

    Raises
    ------
    SceneError
        For a method that does not exist or cannot treat the scene; the error lists what can.
    SolverUnavailable
        For a method whose package is not installed.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(0.46, 0.3), normal_force=1e5,
    ...                  friction=0.3, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=12, ny=12))
    >>> plan = make_plan(scene)
    >>> plan.normal, plan.tangential, plan.coupling
    ('hertz', 'tang-safeguarded', 'none')
    """
    if isinstance(scene.motion, TimeStep):
        raise SceneError(
            "motion",
            scene.motion,
            "a Transient",
            message="motion: a TimeStep continues from the step before it; give the history as a Transient",
        )
    names = {"normal": normal, "tangential": tangential, "coupling": coupling, "formulation": formulation}
    for field, name in names.items():
        if not isinstance(name, str):
            raise SceneError(field, name, "the name of a method")
    way = road(method)
    chosen, reasons = {"method": method}, {"method": "requested: " * (method != "auto") + way.why}
    K, effect = scene.bodies.K, left_out(scene) if coupling == "auto" else 0.0
    if effect:
        scene = replace(scene, bodies=scene.bodies.alike)
    steps = formulation == "marching" and isinstance(scene.motion, Steady)
    together = coupling == "auto" and {normal, tangential} <= {"auto", "newton"}
    if method == "auto" and not (formulation == "auto" or steps):
        way = road("convex")  # what is asked for, only programs have
    elif method == "auto" and not steps and coupling == "newton":
        way = MANY_ELEMENTS
    elif method == "auto" and not steps and (many := for_many_elements(scene, together)):
        way = many
    elif method == "auto" and coupling == "joint":
        way = road("convex")
    chosen["normal"], reasons["normal"] = _normal(scene, normal, way, method)
    check_on_road(method, "normal", normal)
    _check_edge(scene, chosen["normal"])
    chosen["tangential"], reasons["tangential"] = _tangential(scene, tangential, way)
    check_on_road(method, "tangential", tangential)
    chosen["coupling"], reasons["coupling"] = _coupling(scene, coupling, chosen, steps)
    chosen["formulation"], reasons["formulation"] = _formulation(scene, chosen, formulation)
    kinds, special = kinds_of(scene, chosen), special_of(scene)
    if effect:
        kinds["bodies"], reasons["coupling"] = almost_like(K, effect)
    reasons |= {name: reason for name, (_, reason) in kinds.items()} | special
    dimension, bodies, surface, motion, friction = (kind for kind, _ in kinds.values())
    return Plan(
        chosen["normal"],
        chosen["tangential"],
        chosen["coupling"],
        chosen["formulation"],
        reasons,
        dimension,
        bodies,
        surface,
        motion,
        friction,
        tuple(special),
        fallback=way.fallback if (tangential, chosen["tangential"]) == ("auto", way.tangential) else "none",
        method=method,
        left_out=effect,
    )


def _check_edge(scene: Scene, normal: str) -> None:
    """What part of an element bears pressure is found before the tractions, from distances all over the element."""
    why = why_centres(scene) if scene.touched and normal != "hertz" else ""
    if why:
        remedy = "give surface.x and surface.y, or use" if scene.bodies.K == 0 or scene.frictionless else "use"
        message = f'grid.edge = "{scene.edge}" {why}; {remedy} "centres"'
        raise SceneError("grid.edge", scene.edge, '"centres"', message=message)


def _normal(scene: Scene, wanted: str, way: Road, method: str) -> tuple[str, str]:
    if wanted in [*tangential_methods(), *THEORIES] and wanted not in normal_methods():
        raise SceneError(
            "normal",
            wanted,
            "a method of the normal problem",
            message=f'normal = "{wanted}": it solves the tangential problem; use "norm" or "clarabel"',
        )
    available("normal", wanted, ("auto", *normal_methods()))
    coupled = scene.bodies.K != 0 and not scene.frictionless
    hertzian = not any(isinstance(surface, SampledDistance) for surface in scene.surfaces)
    if wanted == "hertz":
        if not hertzian:
            raise SceneError(
                "normal",
                wanted,
                "norm or clarabel",
                message="Hertz's pressure is for paraboloids, ellipses and cylinders; with "
                'sampled distances use "norm" or "clarabel"',
            )
        if coupled:
            raise SceneError(
                "normal",
                wanted,
                "norm or clarabel",
                message="Hertz's pressure ignores tangential tractions; with K = "
                f'{scene.bodies.K:.3g} and friction use "norm" or "clarabel"',
            )
        return wanted, "requested; closed form"
    if wanted != "auto":
        return wanted, "requested"
    if hertzian and not coupled:
        return "hertz", "the surface is Hertzian and tractions do not change the pressure: closed form"
    reason = "tractions change the pressure (K != 0)" if hertzian else "the surface is not Hertzian"
    if scene.touched and method == "auto" and many_on_parts(scene):
        way = MANY_ELEMENTS
    parts = ", on parts of the elements" if scene.touched else ""
    return way.normal, f"{reason}: {_how(way.normal)}{parts}"


def _how(name: str) -> str:
    """What kind of method it is that a road takes."""
    if states_programs(name):
        return "a QP"
    if name in MATRIX_FREE:
        return "Newton's method without a matrix, the fastest for so many elements"
    return "active sets, as printed" if name == "tang-exact" else "active sets, exact and the fastest"


def _tangential(scene: Scene, wanted: str, way: Road) -> tuple[str, str]:
    methods = tangential_methods()
    if one_direction(scene):
        methods += [name for name in normal_methods() if states_programs(name) and name not in methods]
    if wanted in normal_methods() and wanted not in methods:
        why = (
            "it solves QPs, and Coulomb's disks are second-order cones"
            if states_programs(wanted)
            else "it is for normal problems"
        )
        raise SceneError(
            "tangential",
            wanted,
            f"one of {', '.join(methods)} or a theory",
            message=f'tangential = "{wanted}": {why}; use one of {", ".join(methods)}, or a theory',
        )
    available("tangential", wanted, ("auto", *methods, *THEORIES))
    if scene.motion is None:
        return "none", "no motion"
    if scene.frictionless:
        return "none", "without friction there is no traction"
    if wanted in THEORIES:
        reason = why_not(wanted, scene)
        if reason:
            raise SceneError(
                "tangential", wanted, "another method", message=f'tangential = "{wanted}": {reason}; use another method'
            )
        return wanted, "requested: an approximate theory; the certificate measures its error"
    if scene.no_slip and (way.tangential if wanted == "auto" else wanted) not in MATRIX_FREE:
        return "no-slip", "friction is infinite: nothing slips, one linear system"
    if wanted != "auto":
        return wanted, "requested"
    if states_programs(way.tangential):
        of_motion = {Steady: "the gap SOCP of steady rolling", Transient: "the SOCP of a step"}
        return way.tangential, of_motion.get(type(scene.motion), "the SOCP of a shift")
    fails = "; where that fails, the program is solved" if way.fallback != "none" else ""
    whole = "; a symmetric contact as a whole" if way.tangential in MATRIX_FREE else ""
    return way.tangential, f"{_how(way.tangential)}{whole}{fails}"


def _formulation(scene: Scene, chosen: dict[str, str], wanted: str) -> tuple[str, str]:
    choice("formulation", wanted, ("auto", *FORMULATIONS))
    steady, tangential = isinstance(scene.motion, Steady), chosen["tangential"]
    if wanted == "marching" and isinstance(scene.motion, Steady) and scene.motion.slip_difference != "first-order":
        raise SceneError(
            "formulation",
            wanted,
            '"auto" or "gap"',
            message=f'formulation = "marching" is for motion.slip_difference = "first-order", '
            f'and it is "{scene.motion.slip_difference}": a march goes from one step to the next; use "auto"',
        )
    allowed: tuple[str, ...]
    if states_programs(tangential):
        allowed = ("gap", "marching") if steady else ("complementary", "potential", "gap")
        default = "the only convex program of steady rolling" if steady else "the fewest unknowns"
        refusal = "steady rolling has no energy formulation" if steady else '"marching" is for steady rolling only'
    elif tangential in ("none", "no-slip") and states_programs(chosen["normal"]):
        allowed, default = ("complementary", "potential"), "the fewest unknowns"
        refusal = f'formulation = "{wanted}": only the normal problem is a program here'
    elif tangential in TANGENTIAL and steady:
        allowed, default = ("none", "marching"), f"{tangential} does not solve a program"
        refusal = f'formulation = "{wanted}": {default}'
    else:
        allowed, default = ("none",), "no program"
        refusal = f'formulation = "{wanted}": no program is solved here'
    if wanted == "auto":
        return allowed[0], default
    if wanted not in allowed:
        choices = [f'"{name}"'.replace("none", "auto") for name in allowed]
        last = f"{', '.join(choices[:-1])} or {choices[-1]}" if choices[1:] else choices[0]
        raise SceneError("formulation", wanted, last, message=f"{refusal}; use {last}")
    return wanted, "requested"


def _coupling(scene: Scene, wanted: str, chosen: dict[str, str], steps: bool) -> tuple[str, str]:
    choice("coupling", wanted, ("auto", *COUPLING_METHODS))
    if scene.frictionless:
        return "none", "no tangential traction"
    if scene.bodies.K == 0:
        return "none", "quasi-identical bodies (K = 0): first the normal, then the tangential problem"
    if wanted == "johnson":
        return wanted, "requested: one pass, with the pressure of frictionless contact"
    if wanted == "joint":
        return wanted, "requested: pressure and tractions together, with only the traction bound fixed in a pass"
    why = _not_by_newton(scene, chosen, steps)
    if wanted == "newton" and why:
        raise SceneError(
            "coupling", wanted, '"panagiotopoulos"', message=f'coupling = "newton": {why}; use "panagiotopoulos"'
        )
    unlike = f"unlike bodies (K = {scene.bodies.K:.3g})"
    if wanted == "newton" or (wanted == "auto" and not why):
        return "newton", f"{unlike}: pressure and tractions together, and in turn where that fails"
    return "panagiotopoulos", f"{unlike}: normal and tangential problem in turn"


def _not_by_newton(scene: Scene, chosen: dict[str, str], steps: bool) -> str:
    """Why Newton's method is not for pressure and tractions together; nothing where it is."""
    if scene.no_slip:
        return "infinite friction has no traction bound that follows the pressure"
    if steps:
        return "a march solves its steps in turn"
    others = [f'{problem} = "{chosen[problem]}"' for problem in ("normal", "tangential") if chosen[problem] != "newton"]
    return f'it needs "newton" for both problems, not {" and ".join(others)}' if others else ""
