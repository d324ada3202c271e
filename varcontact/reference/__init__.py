"""Closed forms to test against: public, documented, tested by quadrature or limits."""

from varcontact.reference.cattaneo_mindlin import CattaneoMindlin, cattaneo_mindlin
from varcontact.reference.hertz import HertzContact, elliptic_integrals, hertz, hertz_ellipse

__all__ = ["CattaneoMindlin", "HertzContact", "cattaneo_mindlin", "elliptic_integrals", "hertz", "hertz_ellipse"]
