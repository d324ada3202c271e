"""The kinds of interface, in the order in which they read each other's fields: a new one is a line
here.
"""

from __future__ import annotations

from varcontact.interfaces.coulomb import BoundByPressure, Coulomb
from varcontact.interfaces.heat import FrictionalHeat
from varcontact.interfaces.interface import BetweenBodies, Interface, together
from varcontact.interfaces.laws import FrictionLaw
from varcontact.interfaces.third_body import YieldingLayer

KINDS = (FrictionalHeat, Coulomb, FrictionLaw, BoundByPressure, YieldingLayer)


def interface_of(bodies: BetweenBodies) -> Interface:
    """The interfaces between the bodies of a scene as one."""
    found = (kind.between(bodies) for kind in KINDS)
    return together(tuple(each for each in found if each is not None))
