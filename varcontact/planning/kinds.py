"""The kind of a scene, and what makes it simpler than the general case."""

from __future__ import annotations

import math

import numpy as np

from varcontact.scene.friction import Law, kind_of
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.theories.methods import THEORIES
from varcontact.theories.vermeulen_johnson import vermeulen_johnson, vermeulen_johnson_coefficients


def kinds_of(scene: Scene, chosen: dict[str, str]) -> dict[str, tuple[str, str]]:
    """What kind of scene it is, in the order of the plan's entries, and what follows from it.

    Parameters
    ----------
    scene : Scene
    chosen : dict
        What the plan has chosen so far, by entry: its coupling, for one.

    Returns
    -------
    dict of (str, str)
        The kind and the reason, by entry.
    """
    K = scene.bodies.K
    if scene.line:
        dimension = "line contact", "nothing depends on y: one row of strips, forces per unit length"
    else:
        dimension = "three-dimensional", "the contact is bounded along x and y"
    if K == 0:
        bodies = "quasi-identical", "K = 0: tractions do not change the pressure"
    elif scene.frictionless:
        bodies = "unlike", f"K = {K:.3g}, but there are no tractions to change the pressure"
    else:
        bodies = "unlike", f"K = {K:.3g}, pressure and tractions depend on each other"
    if isinstance(scene.surface, SampledDistance):
        surface = "sampled", "the contact is found by solving the normal problem"
    else:
        averaged = ", averaged over every element that it touches" if scene.touched else ""
        surface = "Hertzian", f"contact and frictionless pressure in closed form{averaged}"
    if scene.motion is None:
        motion = "none", "normal contact only"
    elif isinstance(scene.motion, Transient):
        motion = "transient", f"{scene.motion.steps} steps, each from the state that the previous one left; symmetric"
    elif isinstance(scene.motion, Shift):
        motion = "shift", "one step from the unloaded state, symmetric"
    elif chosen["formulation"] == "marching":
        motion = "marching", "steady rolling, in steps until nothing changes"
    else:
        motion = "steady", "nothing depends on time: one problem, no steps"
    friction = _friction(scene, chosen["tangential"])
    return {"dimension": dimension, "bodies": bodies, "surface": surface, "motion": motion, "friction": friction}


def _friction(scene: Scene, tangential: str) -> tuple[str, str]:
    """How the coefficient of friction is known."""
    if tangential == "none":
        return "none", "no tangential traction"
    kinds = {kind_of(friction) for friction in scene.frictions if isinstance(friction, Law)}
    if not kinds:
        return "given", "the traction bound follows from the pressure"
    if tangential in THEORIES:
        reason = "the coefficient depends on the slip and is found particle by particle"
    else:
        reason = "the coefficient depends on the slip: an outer loop solves for known coefficients in each pass"
    one = len(kinds) == 1 and all(isinstance(friction, Law) for friction in scene.frictions)
    return (kinds.pop() if one else "several"), reason


def special_of(scene: Scene) -> dict[str, str]:
    """What is simpler than the general case, and how that is known.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    dict of str
        The reason, by the name of the special case.
    """
    if scene.motion is None:
        return {}
    if scene.frictionless:
        return {"frictionless": "friction is 0: no tangential problem"}
    if scene.no_slip:
        return {"no slip": "friction is infinite: no bound and no cones, one linear system"}
    if _slips_all_over(scene):
        return {"full slip": f"predicted by {'Carter' if scene.line else 'Vermeulen and Johnson'}: no element sticks"}
    return {}


def _slips_all_over(scene: Scene) -> bool:
    """Whether a closed form has full slip: steady rolling without spin of quasi-identical bodies, creepages given."""
    motion, f = scene.motion, scene.friction
    if not isinstance(motion, Steady) or not isinstance(f, float) or scene.bodies.K != 0:
        return False
    hertz = scene.hertz
    if hertz is None or motion.spin != 0 or motion.Fx is not None or motion.Fy is not None:
        return False
    if scene.line:
        return motion.vy == 0 and abs(motion.vx) >= f * hertz.a / hertz.Rx
    nu, limit = scene.bodies.combined_nu, f * hertz.force
    if not 0 <= nu <= 0.5:
        return False
    slope = vermeulen_johnson_coefficients(hertz.a, hertz.b, nu)
    force = vermeulen_johnson(hertz.a, hertz.b, scene.bodies.combined_G, limit, motion.rigid, slope)
    return bool(math.hypot(*force) >= limit * (1 - 1e-12))


def one_direction(scene: Scene) -> bool:
    """Whether tractions can arise along x only or along y only: in line contact, where nothing moves along the other.

    Coulomb's disks then are intervals, and all programs quadratic.

    Parameters
    ----------
    scene : Scene
    """
    motion = scene.motion
    if not scene.line or not isinstance(motion, (Steady, Shift)):
        return False
    along_x = motion.rigid[0] != 0 or motion.Fx is not None or scene.bodies.K != 0
    along_y = motion.rigid[1] != 0 or motion.Fy is not None
    return not (along_x and along_y)


def own_image(scene: Scene) -> bool:
    """Whether a Hertzian contact with an even number of rows is known to be its own mirror image about the x-axis.

    With x its tractions along x are even in y and those along y odd where nothing moves along y, or about z; and the
    other way round where nothing moves along x.

    Parameters
    ----------
    scene : Scene
    """
    motion, grid = scene.motion, scene.grid
    placed = isinstance(grid, Grid) and not grid.explicit and grid.rows % 2 == 0
    if not placed or scene.line or scene.hertz is None or not isinstance(motion, (Steady, Shift)):
        return False
    if scene.bodies.K != 0 or isinstance(scene.friction, np.ndarray):
        return False
    along_x, along_y, about_z = motion.rigid
    straight = along_y == about_z == 0 and motion.Fy is None
    return straight or (along_x == 0 and motion.Fx is None)
