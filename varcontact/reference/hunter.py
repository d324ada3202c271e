"""Rolling resistance of a viscoelastic cylinder without friction (Hunter 1961).

Source: S. C. Hunter, The rolling contact of a rigid cylinder with a
viscoelastic half space, Journal of Applied Mechanics 28 (1961) 611-617; the
formulas are derived anew, for a standard linear solid with one relaxation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from varcontact import checks


@dataclass(frozen=True)
class Hunter:
    """A viscoelastic line contact that rolls without friction, see `hunter`.

    Attributes
    ----------
    a : float
        Half length of the contact [length].
    centre : float
        Where its middle is, in the rolling direction from the lowest point
        [length].
    force : float
        Normal force [force/length].
    moment : float
        Moment of the pressure about the lowest point; positive: the pressure acts
        ahead of it [force].
    """

    a: float
    centre: float
    force: float
    moment: float


def hunter(
    a: float, R: float, G: float, nu: float, part: float, relaxation_length: float
) -> Hunter:
    """Load and moment of a cylinder in viscoelastic line contact without friction.

    Parameters
    ----------
    a : float
        Half length of the contact [length].
    R : float
        Combined radius [length].
    G, nu : float
        Combined constants at once (glassy) [force/area] and [-], of two bodies
        that are alike.
    part, relaxation_length : float
        The compliance is ``(1 + part (1 - exp(-t/tau)))/G``; relaxation length
        ``V tau`` [length].

    Returns
    -------
    Hunter
        The rolling resistance is ``moment/R`` [force/length].

    Raises
    ------
    SceneError
        For a number that is out of its range.

    Notes
    -----
    With ``c = 2 (1 - nu)/G``, ``g = (1 + f) p - l p'`` is what an elastic contact has under the
    distance less l times its slope: ``(sqrt(a^2 - xi^2) - (x_m - l) xi/sqrt(a^2 - xi^2) +
    C/sqrt(a^2 - xi^2))/(c R)``, xi from the middle ``x_m = l f/(1 + f) I1/(I1 + I0 K1/K0)``, ``C =
    x_m a K1/K0``, with Bessel's functions I at ``(1 + f) a/l``, K at ``a/l``, such that p vanishes
    at both ends.

    Examples
    --------
    >>> found = hunter(a=1.0, R=1.0, G=2.0, nu=0.0, part=1.0, relaxation_length=1.0)
    >>> print(f"{found.force:.6f} {found.moment / found.force:.6f}")
    1.153678 0.233129
    """
    from scipy.special import ive, kve

    a = checks.positive("a", a)
    R = checks.positive("R", R)
    G = checks.positive("G", G)
    nu = checks.poisson_ratio("nu", nu)
    f = checks.positive("part", part)
    length = checks.positive("relaxation_length", relaxation_length)
    half_width = (1 + f) * a / length
    ratio = float(kve(1, a / length) / kve(0, a / length))
    bessel = float(ive(1, half_width) / (ive(1, half_width) + ive(0, half_width) * ratio))
    centre = length * f / (1 + f) * bessel
    compliance = 2 * (1 - nu) / G * R
    force = math.pi * (a * a / 2 + centre * a * ratio) / (compliance * (1 + f))
    elastic = (centre - length) * math.pi * a * a / (2 * compliance)
    moment = centre * force - (elastic + length * force) / (1 + f)
    return Hunter(a, centre, force, moment)
