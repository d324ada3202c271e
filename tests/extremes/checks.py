"""How wrong an answer at an extreme is: distances from closed forms, and from scenes that have to give the same.

Each check takes a solution and returns one relative error; nothing here believes the solution's own certificate.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import varcontact as vc
from varcontact.reference import bufler, carter, cattaneo_mindlin, creepage_coefficients, line_contact
from varcontact.reference.hertz import hertz


def _half_spaces(scene: vc.Scene) -> vc.Bodies:
    return scene.bodies


def in_units(scene: vc.Scene, length: float, modulus: float) -> vc.Scene:
    """The same scene in other units: so many of them are one old unit of length, and of force by area."""
    force = modulus * (length if scene.line else length**2)
    surface, motion, grid, bodies = scene.surface, scene.motion, scene.grid, _half_spaces(scene)
    sizes = {"a": length, "b": length, "R": length, "Rx": length, "Ry": length, "reference_depth": length}
    sizes |= {"h": length, "x": length, "y": length, "dx": length, "dy": length, "x0": length, "y0": length}
    sizes |= {"ux": length, "uy": length, "dq": length, "spin": 1 / length, "Fx": force, "Fy": force}
    return replace(
        scene,
        bodies=vc.Bodies(G=(modulus * bodies.pairs[0][0], modulus * bodies.pairs[0][1]), nu=bodies.nu),
        surface=_resized(surface, sizes),
        normal_force=None if scene.normal_force is None else scene.normal_force * force,
        approach=None if scene.approach is None else scene.approach * length,
        motion=None if motion is None else _resized(motion, sizes),
        grid=_resized(grid, sizes) if isinstance(grid, vc.Grid) else grid,
    )


def _resized(thing, sizes: dict[str, float]):
    """The same dataclass with its lengths and forces in other units."""
    changed = {}
    for name in sizes:
        value = getattr(thing, name) if name in thing.__dataclass_fields__ else None
        if value is None:
            continue
        changed[name] = [each * sizes[name] for each in value] if isinstance(value, tuple) else value * sizes[name]
    return replace(thing, **changed)


def distance(one: vc.Solution, other: vc.Solution, length: float = 1.0, modulus: float = 1.0) -> float:
    """The largest difference of pressures and tractions by the largest there are; `one` has those units of `other`."""
    if one.grid.shape != other.grid.shape:
        return math.inf
    pressure, traction = one.pressure / modulus, one.traction / modulus
    away = np.abs(pressure - other.pressure).max() / other.pressure.max()
    size = max(float(np.abs(other.traction).max()), float(np.abs(traction).max()))
    if size > 0:
        away = max(away, np.abs(traction - other.traction).max() / size)
    level = one.approach / length
    if not (math.isnan(level) and math.isnan(other.approach)):
        away = max(away, abs(level / other.approach - 1))
    return float(away)


def same_as(sol: vc.Solution, scene: vc.Scene, length: float = 1.0, modulus: float = 1.0) -> float:
    """Distance from another scene, solved by active sets, of which `sol` has to be the answer in other units."""
    return distance(sol, _by_active_sets(sol, scene), length, modulus)


def _by_active_sets(sol: vc.Solution, scene: vc.Scene) -> vc.Solution:
    """Another scene with the same kind of pressure; of a history the last step."""
    answer = vc.solve(scene, "hertz" if sol.plan.normal == "hertz" else "norm", "tang-safeguarded")
    return answer if isinstance(answer, vc.Solution) else answer[-1]


def proportional_to(sol: vc.Solution, scene: vc.Scene, part: float) -> float:
    """Distance of the tractions from those of another scene, times a number."""
    other = _by_active_sets(sol, scene)
    return float(np.abs(sol.traction / part - other.traction).max() / np.abs(other.traction).max())


def hertz_contact(sol: vc.Solution) -> float:
    """Errors of approach and largest pressure against Hertz."""
    contact = sol.scene.hertz
    return max(abs(sol.approach / contact.approach - 1), abs(sol.pressure.max() / contact.peak_pressure - 1))


def hertz_force(sol: vc.Solution) -> float:
    """Error of the normal force, of a prescribed approach, against Hertz."""
    contact = sol.scene.hertz
    return abs(sol.normal_force / contact.force - 1)


def hertz_patches(sol: vc.Solution, places: Sequence[tuple[float, float]], radius: float) -> float:
    """Largest error of the forces of distant round patches, each Hertz's, under the point loads of the others."""
    from scipy.ndimage import label
    from scipy.optimize import fsolve

    patches, found = label(sol.pressure > 0)
    if found != len(places):
        return math.inf
    points, bodies, total = np.array(places), _half_spaces(sol.scene), sol.normal_force
    columns = [int(np.argmin(np.abs(sol.grid.x - x))) for x, _ in places]
    rows = [int(np.argmin(np.abs(sol.grid.y - y))) for _, y in places]
    forces = np.array([sol.pressure[patches == patches[at]].sum() for at in zip(rows, columns, strict=True)])
    apart = np.hypot(*(points[:, None] - points).transpose(2, 0, 1)) + np.diag(np.full(len(points), np.inf))
    compliance = (1 - bodies.combined_nu) / (np.pi * bodies.combined_G) / apart
    unit = hertz(radius, radius, bodies, force=1.0).approach

    def levels(shares: np.ndarray) -> np.ndarray:
        level = unit * np.abs(shares) ** (2 / 3) + compliance @ shares
        return np.append(np.diff(level) / unit, shares.sum() / total - 1)

    exact = fsolve(levels, np.full(len(points), total / len(points)))
    return float(np.abs(forces * sol.grid.area / exact - 1).max())


def carter_line(sol: vc.Solution) -> float:
    """Error of the tangential force, or of the creepage that gives it, against Carter."""
    scene, motion, friction = sol.scene, sol.scene.motion, _friction(sol)
    contact = line_contact(scene.surface.R, _half_spaces(scene), force=scene.normal_force)
    if motion.Fx is None:
        return float(abs(sol.force[0] / carter(contact, friction, creepage=motion.vx).force - 1))
    return abs(sol.creepage[0] / carter(contact, friction, force=motion.Fx).creepage - 1)


def _friction(sol: vc.Solution) -> float:
    return sol.scene.friction


def carter_strips(sol: vc.Solution) -> float:
    """Error of Fx against Carter's theory in each strip of an ellipse that is long across the rolling direction."""
    contact, motion, bodies, friction = sol.scene.hertz, sol.scene.motion, _half_spaces(sol.scene), _friction(sol)
    stiffness = bodies.combined_G / (1 - bodies.combined_nu)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    total = 0.0
    for t, weight in zip(np.sin(nodes * np.pi / 2), weights * np.cos(nodes * np.pi / 2) * np.pi / 2, strict=True):
        half, peak = contact.a * math.sqrt(1 - t * t), contact.peak_pressure * math.sqrt(1 - t * t)
        strip = line_contact(stiffness * half / (2 * peak), bodies, a=half)
        total += weight * contact.b * carter(strip, friction, creepage=motion.vx).force
    return float(abs(sol.force[0] / total - 1))


def cattaneo(sol: vc.Solution) -> float:
    """Error of the shift that a force gives against Cattaneo and Mindlin."""
    contact, motion = sol.scene.hertz, sol.scene.motion
    exact = cattaneo_mindlin(contact, _half_spaces(sol.scene), _friction(sol), motion.Fx)
    return abs(sol.creepage[0] / exact.shift - 1)


def free_rolling(sol: vc.Solution) -> float:
    """Error of the creepage of unlike cylinders that roll freely without slip against Bufler."""
    exact = bufler(sol.scene.surface.R, _half_spaces(sol.scene), force=sol.scene.normal_force)
    return abs(sol.creepage[0] / exact.creepage - 1)


def sliding(sol: vc.Solution) -> float:
    """Error of the force against the whole friction force against the rigid slip."""
    assert sol.motion is not None
    rigid = np.array(sol.motion.rigid[:2])
    limit = sol.traction_bound.sum() * sol.grid.area
    return float(np.abs(sol.force / limit + rigid / np.hypot(*rigid)).max())


def linear_theory(sol: vc.Solution) -> float:
    """Error of Fx, Fy against Kalker's coefficients, by the larger."""
    scene, contact = sol.scene, sol.scene.hertz
    table = creepage_coefficients(contact.a, contact.b, scene.bodies.combined_nu)
    vx, vy, spin = sol.creepage
    c, size = math.sqrt(contact.a * contact.b), scene.bodies.combined_G * contact.a * contact.b
    exact = -size * np.array([table.C11 * vx, table.C22 * vy + c * table.C23 * spin])
    return float(np.abs(sol.force - exact).max() / np.abs(exact).max())


def no_traction(sol: vc.Solution) -> float:
    """What tractions there are, by the traction bound, where there must be none."""
    return float(np.abs(sol.traction).max() / sol.traction_bound.max())


def steady_state(sol: vc.Solution) -> float:
    """Distance of a history's last step from steady rolling with its creepages."""
    motion = sol.scene.motion
    steady = vc.Steady(vx=motion.vx, vy=motion.vy, spin=motion.spin, dq=motion.dq)
    return same_as(sol, replace(sol.scene, motion=steady))


def mirrored(sol: vc.Solution) -> float:
    """Distance from the answer to the scene's mirror image about y = 0, by active sets, mirrored back."""
    scene = sol.scene
    names = ("vy", "spin", "Fy") if isinstance(scene.motion, vc.Steady) else ("uy", "rotation", "Fy")
    values = {name: getattr(scene.motion, name) for name in names}
    changes = {"motion": replace(scene.motion, **{name: v if v is None else -v for name, v in values.items()})}
    if isinstance(scene.surface, vc.SampledDistance):
        changes["surface"] = vc.SampledDistance(scene.surface.h[::-1])
        changes["grid"] = replace(scene.grid, y0=-scene.grid.box[3])
    if isinstance(scene.friction, np.ndarray):
        changes["friction"] = scene.friction[::-1]
    image = _by_active_sets(sol, replace(scene, **changes))
    back = replace(image, pressure=image.pressure[::-1], traction=image.traction[:, ::-1] * np.array([[[1]], [[-1]]]))
    return distance(sol, back)


def sphere_on_samples(sol: vc.Solution) -> float:
    """Error of the force of a sphere of radius 1 whose lowest sample is at 1, against Hertz."""
    assert sol.scene.approach is not None
    contact = hertz(1.0, 1.0, _half_spaces(sol.scene), approach=sol.scene.approach - 1)
    return abs(sol.normal_force / contact.force - 1)
