"""What a scene requires, and why; the choice behind "auto". `solve` follows exactly this plan."""

from __future__ import annotations

from dataclasses import dataclass, field

from varcontact.checks import choice
from varcontact.errors import SceneError
from varcontact.methods import TANGENTIAL, available, normal_methods, states_programs, tangential_methods
from varcontact.motion import Shift, Steady, TimeStep, Transient
from varcontact.scene import Scene
from varcontact.surfaces import SampledDistance
from varcontact.theories.methods import THEORIES, why_not

COUPLING_METHODS = ("johnson", "panagiotopoulos", "joint")
FORMULATIONS = ("complementary", "potential", "gap", "marching")


@dataclass(frozen=True)
class Plan:
    """The methods chosen for a scene.

    Attributes
    ----------
    normal : str
        "hertz", or the solver of the normal problem.
    tangential : str
        The solver of the tangential problem; "none" where there is none, "no-slip" where it is linear.
    coupling : str
        "none" for quasi-identical bodies and without friction, else "johnson", "panagiotopoulos" or "joint".
    formulation : str
        The programs that are solved: "complementary", "potential", "gap" or "marching"; "none" without any.
    reasons : dict
        For each of them, in one line, why.
    """

    normal: str
    tangential: str
    coupling: str
    formulation: str = "none"
    reasons: dict[str, str] = field(default_factory=dict)


def make_plan(
    scene: Scene, normal: str = "auto", tangential: str = "auto", coupling: str = "auto", formulation: str = "auto"
) -> Plan:
    """Choose the methods for a scene.

    Parameters
    ----------
    scene : Scene
    normal, tangential, coupling, formulation : str
        A method by name, or "auto".

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
    ...                  friction=0.3, motion=vc.Steady(vx=1e-3))
    >>> plan = make_plan(scene)
    >>> plan.normal, plan.tangential, plan.coupling
    ('hertz', 'clarabel', 'none')
    """
    if isinstance(scene.motion, TimeStep):
        raise SceneError("motion", scene.motion, "another: a step goes on from the one before, in a Transient")
    chosen, reasons = {}, {}
    chosen["normal"], reasons["normal"] = _normal(scene, normal)
    chosen["tangential"], reasons["tangential"] = _tangential(scene, tangential)
    chosen["coupling"], reasons["coupling"] = _coupling(scene, coupling)
    chosen["formulation"], reasons["formulation"] = _formulation(scene, chosen, formulation)
    return Plan(**chosen, reasons=reasons)


def _normal(scene: Scene, wanted: str) -> tuple[str, str]:
    if wanted in [*tangential_methods(), *THEORIES] and wanted not in normal_methods():
        raise SceneError("normal", wanted, "another method: it is for the tangential problem")
    available("normal", wanted, ("auto", *normal_methods()))
    coupled = scene.bodies.K != 0 and not scene.frictionless
    hertzian = not any(isinstance(surface, SampledDistance) for surface in scene.surfaces)
    if wanted == "hertz":
        if not hertzian:
            raise SceneError(
                "normal", wanted, "another method: Hertz's pressure is for paraboloids, ellipses and cylinders"
            )
        if coupled:
            raise SceneError(
                "normal",
                wanted,
                f"another method: with friction Hertz's pressure is for K = 0, K is {scene.bodies.K:.3g}",
            )
        return wanted, "asked for; closed form"
    if wanted != "auto":
        return wanted, "asked for"
    if hertzian and not coupled:
        return "hertz", "the surface is Hertzian and tractions do not change the pressure: closed form"
    reason = "tractions change the pressure (K != 0)" if hertzian else "the surface is not Hertzian"
    return "clarabel", f"{reason}: a QP"


def _one_direction(scene: Scene) -> bool:
    """Whether tractions can arise along x only or along y only: in line contact, where nothing moves along the other.

    Coulomb's disks then are intervals, and all programs quadratic.
    """
    motion = scene.motion
    if not scene.line or not isinstance(motion, (Steady, Shift)):
        return False
    along_x = motion.rigid[0] != 0 or motion.Fx is not None or scene.bodies.K != 0
    along_y = motion.rigid[1] != 0 or motion.Fy is not None
    return not (along_x and along_y)


def _tangential(scene: Scene, wanted: str) -> tuple[str, str]:
    methods = tangential_methods()
    if _one_direction(scene):
        methods += [name for name in normal_methods() if states_programs(name) and name not in methods]
    if wanted in normal_methods() and wanted not in methods:
        why = (
            "Coulomb's disks are second-order cones, no QP" if states_programs(wanted) else "it is for normal problems"
        )
        raise SceneError("tangential", wanted, f"one of {', '.join(methods)} or a theory: {why}")
    available("tangential", wanted, ("auto", *methods, *THEORIES))
    if scene.motion is None:
        return "none", "no motion"
    if scene.frictionless:
        return "none", "no friction, no traction"
    if wanted in THEORIES:
        reason = why_not(wanted, scene)
        if reason:
            raise SceneError("tangential", wanted, f"another method: {reason}")
        return wanted, "asked for: an approximate theory, how wrong is in the certificate"
    if scene.no_slip:
        return "no-slip", "friction is infinite: nothing slips, one linear system"
    if wanted != "auto":
        return wanted, "asked for"
    programs = {Steady: "the gap SOCP of steady rolling", Transient: "the SOCP of a step"}
    return "clarabel", programs.get(type(scene.motion), "the SOCP of a shift")


def _formulation(scene: Scene, chosen: dict[str, str], wanted: str) -> tuple[str, str]:
    choice("formulation", wanted, ("auto", *FORMULATIONS))
    steady, tangential = isinstance(scene.motion, Steady), chosen["tangential"]
    allowed: tuple[str, ...]
    if states_programs(tangential):
        allowed = ("gap", "marching") if steady else ("complementary", "potential", "gap")
        default = "the only convex program of steady rolling" if steady else "the fewest unknowns"
        refusal = "steady rolling is no minimum of an energy" if steady else "a shift has no steps"
    elif tangential in ("none", "no-slip") and states_programs(chosen["normal"]):
        allowed, default = ("complementary", "potential"), "the fewest unknowns"
        refusal = "there is a normal program only"
    elif tangential in TANGENTIAL and steady:
        allowed, default = ("none", "marching"), f"{tangential} states no program"
        refusal = default
    else:
        allowed, default, refusal = ("none",), "no program", "no program is stated"
    if wanted == "auto":
        return allowed[0], default
    if wanted not in allowed:
        raise SceneError("formulation", wanted, f"{' or '.join(allowed)} here: {refusal}".replace("none", "auto"))
    return wanted, "asked for"


def _coupling(scene: Scene, wanted: str) -> tuple[str, str]:
    choice("coupling", wanted, ("auto", *COUPLING_METHODS))
    if scene.frictionless:
        return "none", "no tangential traction"
    if scene.bodies.K == 0:
        return "none", "quasi-identical bodies (K = 0): first the normal, then the tangential problem"
    if wanted == "johnson":
        return wanted, "asked for: one pass, the pressure as without friction"
    if wanted == "joint":
        return wanted, "asked for: pressure and tractions together, with only the traction bound fixed in a pass"
    return "panagiotopoulos", f"unlike bodies (K = {scene.bodies.K:.3g}): normal and tangential problem in turn"
