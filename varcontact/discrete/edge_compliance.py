"""Edge compliance: softer elements at the contact edge, which the contact covers in part."""

from __future__ import annotations

import numpy as np

COMPLIANCE_FACTOR = 1.6
"""Fitted to the forces on twenty ellipses, with 12 to 32 cells: with 1.3 or 2 they are nearly as
good.

At a straight edge across the direction of rolling 2.0 to 2.3 is exact, see `edge_compliance`. Along
the other edges tractions do not rise in that direction, and less is enough.
"""

COVERED_MIN = 0.3
"""Covered part of an element below which edge compliance stays constant: such elements carry hardly
any load."""


def edge_compliance(covered: np.ndarray) -> np.ndarray:
    """Addition to the diagonal of M, relative to that diagonal, where the contact covers parts of
    elements.

    Where particles enter the contact, tractions rise like the square root of the distance from the
    edge. The mean over an element that is covered by the part w then falls like ``w^(3/2)``. But
    its slip is taken at the centre, as if the traction were on all of the element, and for the same
    slip the mean traction hardly depends on w. On an element whose compliance is larger by the
    factor ``w^(-3/2)`` it falls as it should.
    """
    return np.asarray(COMPLIANCE_FACTOR * (np.clip(covered, COVERED_MIN, 1.0) ** -1.5 - 1))
