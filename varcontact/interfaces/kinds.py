"""Kinds of interfaces, in the order in which they read each other's fields: add a new kind as a
line here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from varcontact.interfaces.coulomb import BoundByPressure, Coulomb
from varcontact.interfaces.heat import FrictionalHeat
from varcontact.interfaces.interface import BetweenBodies, Interface, together
from varcontact.interfaces.laws import FrictionByLaw
from varcontact.interfaces.third_body import YieldingLayer
from varcontact.scene.friction import FrictionBound, Law

KINDS: tuple[tuple[Callable[[BetweenBodies], bool], type[Any]], ...] = (
    (lambda given: given.scene.thermal is not None, FrictionalHeat),
    (lambda given: not isinstance(given.friction, Law | FrictionBound), Coulomb),
    (lambda given: isinstance(given.friction, Law), FrictionByLaw),
    (lambda given: isinstance(given.friction, FrictionBound), BoundByPressure),
    (lambda given: given.scene.flows, YieldingLayer),
)
"""Condition for a scene to have an interface of a kind, and its class."""


def interface_of(bodies: BetweenBodies) -> Interface:
    """The interfaces between the bodies of a scene as one."""
    found = (kind.between(bodies) for has_one, kind in KINDS if has_one(bodies))
    whole = together(tuple(each for each in found if each is not None))
    assert whole is not None
    return whole
