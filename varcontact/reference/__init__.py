"""Closed forms to test against: public, documented, tested by quadrature or limits."""

from varcontact.reference.cattaneo_mindlin import CattaneoMindlin, cattaneo_mindlin
from varcontact.reference.creepage_coefficients import CreepageCoefficients, creepage_coefficients
from varcontact.reference.hertz import HertzContact, elliptic_integrals, hertz, hertz_ellipse

__all__ = [
    "CattaneoMindlin",
    "CreepageCoefficients",
    "HertzContact",
    "cattaneo_mindlin",
    "creepage_coefficients",
    "elliptic_integrals",
    "hertz",
    "hertz_ellipse",
]
