"""How much more an element gives way that the contact covers in part."""

from __future__ import annotations

import numpy as np

FACTOR = 1.6
"""Fitted to the forces on twenty ellipses, with 12 to 32 cells: with 1.3 or 2 they are nearly as good.

At a straight edge across the direction of rolling 2.0 to 2.3 is exact, see `softening`. Along the other edges tractions
do not rise in that direction, and less is enough.
"""

LEAST = 0.3
"""Part covered below which softening does not grow: such elements carry nearly nothing, and solvers are faster."""


def softening(covered: np.ndarray) -> np.ndarray:
    """What the diagonal of M has in addition, by that diagonal.

    Where particles enter the contact, tractions rise like the square root of the distance from the edge. The mean over
    an element that is covered by the part w then falls like ``w^(3/2)``. But its slip is taken at the centre, as if
    the traction were all over the element, and for the same slip a mean traction that hardly depends on w is found.
    On an element that gives way by ``w^(-3/2)`` times as much it falls as it should.

    Parameters
    ----------
    covered : ndarray
        Parts of elements that the contact covers, between 0 and 1.

    Returns
    -------
    ndarray
        Zero or positive [-].

    Examples
    --------
    >>> print(softening(np.array([0.0, 0.5, 1.0])).round(3))
    [8.137 2.925 0.   ]
    """
    return np.asarray(FACTOR * (np.clip(covered, LEAST, 1.0) ** -1.5 - 1))
