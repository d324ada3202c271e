"""Closed-form reference solutions: public, documented, and tested by quadrature or limits."""

from varcontact.reference.bufler import Bufler, bufler
from varcontact.reference.carter import Carter, carter
from varcontact.reference.cattaneo import (
    CattaneoLine,
    CattaneoMindlin,
    cattaneo_line,
    cattaneo_mindlin,
)
from varcontact.reference.creepage_coefficients import (
    CreepageCoefficients,
    creepage_coefficients,
    no_slip_coefficients,
)
from varcontact.reference.harmonic import harmonic_coefficients, harmonic_line
from varcontact.reference.hertz import HertzContact, elliptic_integrals, hertz, hertz_ellipse
from varcontact.reference.hunter import Hunter, hunter
from varcontact.reference.line_contact import LineContact, line_contact
from varcontact.reference.no_slip_ellipse import no_slip_ellipse
from varcontact.reference.pin_in_hole import PinContact, pin_in_hole
from varcontact.reference.spence import spence_ratio

__all__ = [
    "Bufler",
    "Carter",
    "CattaneoLine",
    "CattaneoMindlin",
    "CreepageCoefficients",
    "HertzContact",
    "Hunter",
    "LineContact",
    "PinContact",
    "bufler",
    "carter",
    "cattaneo_line",
    "cattaneo_mindlin",
    "creepage_coefficients",
    "elliptic_integrals",
    "harmonic_coefficients",
    "harmonic_line",
    "hertz",
    "hertz_ellipse",
    "hunter",
    "line_contact",
    "no_slip_coefficients",
    "no_slip_ellipse",
    "pin_in_hole",
    "spence_ratio",
]
