"""Measures of errors against the continuum: the values of an answer that count, and their units.

Forces count by the friction limit f Fz, the moment by f Fz sqrt(ab), creepages
that follow from prescribed forces by the saturation creepage; of normal contact
the approach and the largest pressure count, relative to themselves. The error
of an answer is the largest of these.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import creepage_coefficients
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.bodies import Bodies, BodyPair
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.scene import Scene
from varcontact.theories.table import equivalent_ellipse

NORMAL = ("approach", "normal_force", "peak_pressure")
"""The quantities of normal contact."""


def not_measurable(scene: Scene) -> SceneError | None:
    """Error for scenes whose errors have no unit, as infinite friction has no friction limit; else
    None.
    """
    infinite = [f for f in scene.frictions if isinstance(f, float) and math.isinf(f)]
    if scene.motion is None or not infinite:
        return None
    allowed = (
        "finite, or a grid given in place of an accuracy: "
        "errors are measured by the friction limit f Fz"
    )
    return SceneError("friction", math.inf, allowed)


def values(answer: Solution | History, steps: Sequence[int] | None = None) -> dict[str, float]:
    """The values of an answer that errors are measured in.

    Parameters
    ----------
    answer : Solution or History
    steps : sequence of int, optional
        Steps of a history that count, from 0; by default all.

    Returns
    -------
    dict of str to float
        In the scene's units. With friction: ``Fx`` and ``Fy``, or the creepages
        ``vx`` and ``vy`` (of a shift the shifts ``ux`` and ``uy``) where the
        force is prescribed, and ``Mz``, except in line contact. Without:
        ``approach`` (``normal_force`` where the approach is prescribed) and
        ``peak_pressure``. Of a history each with its step, as ``Fx[3]``. What
        has no value, as the approach of a line contact without reference depth,
        is left out.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(Fx=-0.1), grid=vc.Grid(nx=8, ny=8))
    >>> list(values(vc.solve(scene)))
    ['vx', 'Fy', 'Mz']
    """
    if isinstance(answer, History):
        chosen = steps_that_count(len(answer), steps)
        return {f"{name}[{k}]": value for k in chosen for name, value in values(answer[k]).items()}
    measured = _normal(answer) if answer.scene.frictionless else _frictional(answer)
    return {name: value for name, value in measured.items() if not math.isnan(value)}


def _normal(sol: Solution) -> dict[str, float]:
    """The approach, or the load where the approach is prescribed, and the largest pressure."""
    if sol.scene.approach is None:
        load = {"approach": sol.approach}
    else:
        load = {"normal_force": sol.normal_force}
    return load | {"peak_pressure": sol.max_pressure}


def _frictional(sol: Solution) -> dict[str, float]:
    """Forces, or creepages where the force is prescribed, and the moment."""
    forces = dict(zip(("Fx", "Fy"), sol.force, strict=True))
    along_x, along_y, _ = creepage_names(sol)
    creepages = {"Fx": (along_x, sol.creepage[0]), "Fy": (along_y, sol.creepage[1])}
    measured = {}
    for name, force in forces.items():
        if getattr(sol.motion, name) is None:
            measured[name] = float(force)
        else:
            creepage, value = creepages[name]
            measured[creepage] = float(value)
    if not sol.scene.line:
        measured["Mz"] = sol.moment
    return measured


def units(answer: Solution | History, steps: Sequence[int] | None = None) -> dict[str, float]:
    """Units of the errors of each of an answer's `values`: what an error of one is.

    Parameters
    ----------
    answer : Solution or History
        Any answer of the scene: of Hertzian scenes the units do not depend on
        it, of others on its area of contact.
    steps : sequence of int, optional
        As for `values`.

    Returns
    -------
    dict of str to float
        With the names of `values`, in the scene's units, all positive. In a
        history the largest f Fz of its steps.

    Raises
    ------
    SceneError
        If friction is infinite.

    Notes
    -----
    The saturation creepage is that at which the simplified theory of pure creepage slips all over,
    ``3 f Fz / (G a b C11)``; that of a shift is Cattaneo's, ``3 (2 - nu) f Fz / (8 G sqrt(ab))``.
    In line contact they are Carter's ``4 (1 - nu) f Fz / (pi G a)``, and a times that. Where the
    contact is not Hertzian, a and b are the semi-axes of the ellipse with its area and ratio of
    second moments.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=2.0, b=0.5), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.1), grid=vc.Grid(nx=8, ny=8))
    >>> print({name: round(unit, 6) for name, unit in units(vc.solve(scene)).items()})
    {'Fx': 0.3, 'Fy': 0.3, 'Mz': 0.3}
    """
    refusal = not_measurable(answer.scene)
    if refusal is not None:
        raise refusal
    if isinstance(answer, History):
        return _units_of_history(answer, steps)
    scene = answer.scene
    sizes = _normal(answer)
    # without contact those of forces are zero
    if not scene.frictionless and answer.pressure.any():
        a, b = semi_axes(answer)
        sizes |= frictional_units(static_friction_limit(answer), a, b, scene.bodies, scene.line)
    return {name: abs(sizes.get(name, 0.0)) for name in values(answer)}


def _units_of_history(history: History, steps: Sequence[int] | None) -> dict[str, float]:
    """Largest unit of each value over all steps, by the value's name with the step."""
    of_steps = {k: units(history[k]) for k in steps_that_count(len(history), steps)}
    largest: dict[str, float] = {}
    for of_step in of_steps.values():
        for name, unit in of_step.items():
            largest[name] = max(largest.get(name, 0.0), unit)
    return {f"{name}[{k}]": largest[name] for k, of_step in of_steps.items() for name in of_step}


def steps_that_count(number: int, steps: Sequence[int] | None) -> Sequence[int]:
    """Steps of a history in which errors are measured: the requested ones, or all; SceneError if
    one is missing.
    """
    if steps is None:
        return range(number)
    return checks.wholes("steps", steps, least=0, most=number - 1)


def error(
    found: Mapping[str, float], exact: Mapping[str, float], units: Mapping[str, float]
) -> float:
    """The error of an answer: the largest of its values' errors, in their units.

    Parameters
    ----------
    found, exact : mapping of str to float
        Values of the answer, and those it should have; every exact value must
        have been found.
    units : mapping of str to float
        Unit of the error of each quantity, see `units`.

    Returns
    -------
    float
        NaN where a value was not found or is no number: unknown is not small.

    Examples
    --------
    >>> round(error({"Fx": -0.21, "Mz": 0.05}, {"Fx": -0.2, "Mz": 0.05}, {"Fx": 0.3, "Mz": 0.3}), 4)
    0.0333
    """
    errors = [abs(found.get(name, math.nan) - value) / units[name] for name, value in exact.items()]
    return float(np.max(errors))


def creepage_names(sol: Solution) -> tuple[str, str, str]:
    """Names of the entries of a solution's `creepage`."""
    if sol.motion is not None and sol.motion.rolls:
        return ("vx", "vy", "spin")
    return ("ux", "uy", "rotation")


def frictional_units(
    limit: float, a: float, b: float, bodies: Bodies | BodyPair | GivenBodies, line: bool
) -> dict[str, float]:
    """Units of the errors of forces, moment, creepages and shifts, from the friction limit and the
    semi-axes.
    """
    G, nu = bodies.combined_G, bodies.combined_nu
    if line:
        rolling = 4 * (1 - nu) * limit / (math.pi * G * a)
        shift = a * rolling
    else:
        rolling = 3 * limit / (G * a * b * creepage_coefficients(a, b, nu).C11)
        shift = 3 * (2 - nu) * limit / (8 * G * math.sqrt(a * b))
    return {
        "Fx": limit,
        "Fy": limit,
        "Mz": limit * math.sqrt(a * b),
        "vx": rolling,
        "vy": rolling,
        "ux": shift,
        "uy": shift,
    }


def friction_limit(sol: Solution) -> float:
    """Largest tangential force that friction can carry, from the traction bound of the solution."""
    return float(sol.traction_bound.sum() * sol.grid.area)


def static_friction_limit(sol: Solution) -> float:
    """Friction force f Fz with the largest coefficient; `friction_limit` if that is no number; NaN
    without friction.
    """
    if sol.scene.friction is None:
        return math.nan
    largest = sol.scene.largest_coefficient
    if isinstance(largest, float):
        return largest * sol.normal_force
    return friction_limit(sol)


def semi_axes(sol: Solution) -> tuple[float, float]:
    """Semi-axes along x and y [length] of Hertz's ellipse, or of one with the area and ratio of
    second moments.

    In line contact b is 1, as forces are per unit length.
    """
    hertz = sol.scene.hertz
    if hertz is not None:
        return hertz.a, 1.0 if sol.scene.line else hertz.b
    lattice, contact = sol.contact
    if sol.scene.line:
        return np.sum(contact) * lattice.area / 2, 1.0
    return equivalent_ellipse(lattice, contact.astype(float))
