"""Influence numbers of line contact: displacement difference by uniform
tractions on an infinite strip.

Plane strain (44) for pressure and longitudinal traction, anti-plane shear for
lateral traction. Displacements count from the points of the surface at the
distance `depth` of a line load, ``-ln(|x|/depth)``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from varcontact.elasticity.halfspace import influence_numbers


def strip_influence_numbers(
    x: np.ndarray,
    dx: float,
    *,
    nu: float,
    K: float = 0.0,
    G: float = 1.0,
    depth: float = 1.0,
    components: Iterable[str] = ("xx", "yy", "zz"),
) -> dict[str, np.ndarray]:
    """Influence numbers B_ij of a strip of width dx.

    Parameters
    ----------
    x : array_like
        Field point minus the strip's centre line [length].
    dx : float
        Width of the strip [length].
    nu, K, G : float
        Combined constants (58)-(60).
    depth : float
        Distance at which displacements along the traction are zero [length].
    components : iterable of str
        Which of the nine: "xz" is the displacement difference along x by a unit
        pressure.

    Returns
    -------
    dict
        Component to array of the shape of x [length/(force/area)].

    Notes
    -----
    With ``L = -[[s ln(|s|/d) - s]]`` (the integral of ``-ln(|x - x'|/d)`` over the strip, s from
    ``x - dx/2`` to ``x + dx/2``) and ``J = [[|s|]]`` (the integral of ``sgn(x - x')``): ``pi G B``
    is ``2 (1 - nu) L`` (xx and zz), ``2 L`` (yy), ``-pi K J`` (xz), ``pi K J`` (zx); all others are
    zero. They are the limits of the rectangle's as its length along y grows, but for constants.

    Examples
    --------
    >>> B = strip_influence_numbers(np.array([0.0, 3.0]), 1.0, nu=0.25, components=["zz"])["zz"]
    >>> print((B * np.pi / 1.5).round(6))
    [ 1.693147 -1.093944]
    """
    return influence_numbers(
        x, 0.0, dx, math.inf, nu=nu, K=K, G=G, depth=depth, components=components
    )
