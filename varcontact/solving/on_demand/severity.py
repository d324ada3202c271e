"""By how much the errors of a scene are larger than those of others of its class."""

from __future__ import annotations

import math

import numpy as np

from varcontact.planning.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.friction import Law
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.on_demand.zones import unresolved

STRAIGHT, SPUN, TURNED = 0.4, 0.28, 0.0065
"""Under Hertz's pressure: errors without spin or rotation by those with it, and the `turning` of rolling and of shifts
from which they are as large."""
WORST, LARGER, FALLS = 0.7, 2.5, 1.2
"""K/f at which unlike bodies that roll have their largest errors; the square of how much these exceed others', and how
it falls with the logarithm of K/f on both sides."""
THIN = 2.6
"""By how much more they are larger where zones of slip or stick are too thin for the elements, in all rows."""
USUALLY = 0.3
"""Part of the rows for which that is assumed before there is an answer."""
COUPLED = 0.5, 2.0
"""Between these the errors of histories are taken to grow with K/f."""
FREE, FORCED = 0.5, 0.75
"""The power of half the contact's length by that of a step with which they grow: with creepages, and under forces."""
SHORTEST = 0.03
"""Length of a step by half that of the contact, below which they do not grow any more."""


def severity_of(
    scene: Scene, plan: Plan, axes: tuple[float, float] | None, near: Solution | None = None, finer: float = 1.0
) -> float:
    """How slender a contact is, and how much it turns; of a history how short a step is; of unlike bodies how coupled.

    Where unlike bodies roll, zones of slip or stick count that are too thin for the elements.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    axes : tuple of float, optional
        Semi-axes of the contact along x and y, if they are known [length].
    near : Solution, optional
        An answer of the scene, if there is one.
    finer : float
        By how many times the elements of the grid in question are shorter than those of that answer.
    """
    if scene.line or axes is None:
        return 1.0
    slender, motion = slenderness(*axes), scene.motion
    if not plan.rubs:
        return slender
    coupled = plan.coupling != "none"
    if coupled and isinstance(motion, Steady):
        strong = max(1.0, LARGER - FALLS * abs(math.log(coupling_strength(scene) / WORST)))
        return math.sqrt(strong) * (1 + THIN * (USUALLY if near is None else unresolved(near, finer)))
    if plan.closed_form and isinstance(motion, Steady | Shift):
        full = SPUN if motion.rolls else TURNED
        return min(max(turning(scene) / full, STRAIGHT), 1.0) * math.sqrt(slender)
    if not isinstance(motion, Transient):
        return slender
    short = shortness(motion, axes[0])
    if not coupled:
        return short * slender
    strong = min(max(coupling_strength(scene), COUPLED[0]), COUPLED[1])
    return strong * short * math.sqrt(slender)


def turning(scene: Scene) -> float:
    """Spin by what friction can follow, ``spin max(a, b) G/(f p0)``; the rotation of a shift, ``rotation G/(f p0)``.

    Parameters
    ----------
    scene : Scene
        Hertzian, with friction, rolling or shifted.

    Returns
    -------
    float
        [-].
    """
    hertz, motion = scene.hertz, scene.motion
    assert hertz is not None and isinstance(motion, Steady | Shift)
    arm = max(hertz.a, hertz.b) if motion.rolls else 1.0
    return abs(motion.rigid[2]) * arm * scene.bodies.combined_G / (_least_friction(scene) * hertz.peak_pressure)


def slenderness(a: float, b: float) -> float:
    """The longer semi-axis of a contact by the mean of both: by so much the arms of moments are longer.

    Parameters
    ----------
    a, b : float
        [length]
    """
    return math.sqrt(max(a / b, b / a))


def coupling_strength(scene: Scene) -> float:
    """K/f: the tractions that pressures alone call for, by those that friction carries.

    Parameters
    ----------
    scene : Scene
        With friction, in one step at least.

    Returns
    -------
    float
        With the least coefficient that is not zero.
    """
    return abs(scene.bodies.K) / _least_friction(scene)


def _least_friction(scene: Scene) -> float:
    """The least coefficient that is not zero."""
    laws = [f for f in scene.frictions if isinstance(f, Law)]
    numbers = [np.ravel(f) for f in scene.frictions if f is not None and not isinstance(f, Law)]
    coefficients = np.concatenate([*numbers, [law.kinetic or law.static for law in laws]])
    return float(coefficients[coefficients > 0].min())


def shortness(motion: Transient, a: float) -> float:
    """By how much errors of a history are larger where it rolls in short steps.

    Under a force they are those of a shift by the length of the step, the creepage.

    Parameters
    ----------
    motion : Transient
        With lengths of its steps.
    a : float
        Half the contact's length [length].
    """
    steps = zip(motion.every("dq"), motion.every("Fx"), motion.every("Fy"), strict=True)
    rolled = [(min(max(dq / a, SHORTEST), 1.0), force) for dq, *force in steps if dq > 0]
    return max((part ** -(FREE if force == [None, None] else FORCED) for part, force in rolled), default=1.0)
