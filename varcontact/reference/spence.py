"""Stick in the compression of unlike bodies with friction: Spence's ratio (paper, section 6.2.4).

Sources: D. A. Spence, J. Elasticity 5 (1975); K. L. Johnson, Contact Mechanics,
Cambridge University Press 1985.
"""

from __future__ import annotations

import math

from varcontact.checks import choice, elastic, positive
from varcontact.reference.hertz import CombinedConstants


def spence_ratio(bodies: CombinedConstants, friction: float, shape: str = "circle") -> float:
    """Ratio of the stick area's radius to the contact's when unlike bodies are pressed together.

    Parameters
    ----------
    bodies : Bodies
        Elastic constants; like bodies stick everywhere.
    friction : float
        Coefficient of friction.
    shape : str
        ``"circle"`` (axisymmetric: radii), or ``"line"`` (plane strain:
        half-widths).

    Returns
    -------
    float
        c/a, which depends on ``beta/f`` alone, ``beta = |K| / (1 - nu)``; 0 or
        1 where it is so to rounding.

    Raises
    ------
    SceneError
        If the friction is not positive and finite, or the shape unknown.

    Notes
    -----
    The effect of the tractions on the pressure is neglected. Then with the complete elliptic
    integral K of the modulus k = c/a, and K' of the complementary modulus::

        line:    K'(k) / K(k) = beta / f
        circle:  (1 / (2 k)) ln((1 + k)/(1 - k)) = (f / beta) K'(k)

    Both follow for a flat punch from traction that is bounded at the edge of
    the stick area. As the force grows, a convex indenter is a sequence of
    growing flat punches, in which slip always was outside the present stick
    area. So the ratio is the same for all of them, Hertz's contact included
    (Spence 1975; Johnson 1985).

    Examples
    --------
    The paper's cylinders (6.2.4), of which one is rigid:

    >>> from varcontact import Bodies
    >>> bodies = Bodies(G=(1.0, float("inf")), nu=(0.286, 0.0))
    >>> print(f"{spence_ratio(bodies, 0.15, 'line'):.4f} {spence_ratio(bodies, 0.15):.4f}")
    0.1721 0.4859
    """
    from scipy.optimize import brentq
    from scipy.special import ellipk, ellipkm1

    elastic(bodies)
    friction = positive("friction", friction)
    choice("shape", shape, ("circle", "line"))
    beta = abs(bodies.K) / (1 - bodies.combined_nu)
    if beta == 0:
        return 1.0

    def excess(log_odds: float) -> float:
        """Logarithm of (f by the equation) / f, in t = ln(k^2 / (1 - k^2)): sound at both ends."""
        k2 = 1 / (1 + math.exp(-log_odds))
        rest = 1 / (1 + math.exp(log_odds))
        complementary = float(ellipkm1(k2))  # K' has the parameter 1 - k^2
        if shape == "line":
            needed = float(ellipkm1(rest)) if log_odds > 0 else float(ellipk(k2))
        else:
            k = math.sqrt(k2)
            needed = (math.log1p(k) + 0.5 * math.log1p(math.exp(log_odds))) / k
        return math.log(beta * needed / (friction * complementary))

    low = -700.0
    high = 700.0
    if excess(low) >= 0:
        # K' = ln(4/k)
        return 4 * math.exp(-beta / friction * (math.pi / 2 if shape == "line" else 1.0))
    if excess(high) <= 0:
        return 1.0
    log_odds = float(brentq(excess, low, high, xtol=1e-14, rtol=1e-15))
    return 1 / math.sqrt(1 + math.exp(-log_odds))
