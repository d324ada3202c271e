"""Elements at the edge of the contact that it covers in part, and that give way more."""

from __future__ import annotations

import numpy as np

COMPLIANCE_FACTOR = 1.6
"""Fitted to the forces on twenty ellipses, with 12 to 32 cells: with 1.3 or 2 they are nearly as
good.

At a straight edge across the direction of rolling 2.0 to 2.3 is exact, see `edge_compliance`. Along
the other edges tractions do not rise in that direction, and less is enough.
"""

COVERED_MIN = 0.3
"""Part covered below which edge compliance does not grow: such elements carry hardly anything."""


def edge_compliance(covered: np.ndarray) -> np.ndarray:
    """Addition to the diagonal of M, relative to that diagonal, where the contact covers parts of
    elements.

    Where particles enter the contact, tractions rise like the square root of the distance from the
    edge. The mean over an element that is covered by the part w then falls like ``w^(3/2)``. But
    its slip is taken at the centre, as if the traction were all over the element, and for the same
    slip a mean traction that hardly depends on w is found. On an element that gives way by
    ``w^(-3/2)`` times as much it falls as it should.
    """
    return np.asarray(COMPLIANCE_FACTOR * (np.clip(covered, COVERED_MIN, 1.0) ** -1.5 - 1))
