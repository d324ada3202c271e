"""The wheel S1002 and the rail 60E1, from the arcs, lines and polynomials that define them.

S1002: the eight sections of UIC 510-2 and EN 13715 (flange height 28 mm, flange thickness 32.5 mm). 60E1: the head of
EN 13674-1 (UIC 60), arcs of radius 300, 80 and 13 mm that meet at widths of 20.456 and 52.053 mm, and flanks of slope
1:20 where the head is 72 mm wide.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial.polynomial import polyval

# S1002, by y towards the outside [mm]; flange back at -70, running circle at 0
FLANGE_BACK = (-70.0, -62.764705882, (-49.5, 9.519259302), 20.5)
FLANGE_TOP = (-62.764705882, -49.662510381, (-55.0, 16.0), 12.0)
FLANGE_SIDE = (-49.662510381, -39.764473993, (-58.558326413, 8.834924130), 20.0)
FLANGE_FLAT = (-39.764473993, -38.426669071, (-93.576667419, -2.747477419))
THROAT = (-38.426669071, -35.0, (-26.210665, 16.446), -13.0)
INNER = (-35.0, -26.0)
INNER_COEFFICIENTS = (
    -4.320221063e3,
    -1.038384026e3,
    -1.065501873e2,
    -6.051367875,
    -2.054332446e-1,
    -4.169739389e-3,
    -4.687195829e-5,
    -2.252755540e-7,
)
TREAD = (-26.0, 32.15796)
TREAD_COEFFICIENTS = (
    0.0,
    -3.358537058e-2,
    1.565681624e-3,
    -2.810427944e-5,
    5.844240864e-8,
    -1.562379023e-8,
    5.309217349e-15,
    -5.957839843e-12,
    2.646656573e-13,
)
OUTER = (32.15796, 60.0)
OUTER_COEFFICIENTS = (1.364323640, -0.066666667)

# 60E1, by y from its middle [mm]
RADII = (300.0, 80.0, 13.0)
HALF_WIDTHS = (20.456 / 2, 52.053 / 2, 72.0 / 2)
FLANK_SLOPE = 20.0
FLANK_DEPTH = 36.0
"""Below the top, where the flanks end here; the real ones go on to 37.5 mm and turn inwards."""


def s1002(step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the wheel profile S1002.

    Parameters
    ----------
    step : float
        Distance of the points along the profile, nearly [mm].

    Returns
    -------
    y, z : ndarray, shape (n,)
        From the flange's back to the outside; z down, 0 on the running circle [mm].

    Examples
    --------
    >>> y, z = s1002(0.25)
    >>> print(f"{z.max():.2f} {np.interp(10.0, y, z):.4f}")
    28.00 -0.2084
    """
    sections = [_arc(*each, step) for each in (FLANGE_BACK, FLANGE_TOP, FLANGE_SIDE)]
    sections.append(_polynomial(*FLANGE_FLAT, step))
    sections.append(_arc(*THROAT, step))
    for ends, coefficients in ((INNER, INNER_COEFFICIENTS), (TREAD, TREAD_COEFFICIENTS), (OUTER, OUTER_COEFFICIENTS)):
        sections.append(_polynomial(*ends, coefficients, step))
    return _joined(sections)


def rail_60e1(step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the head of the rail profile 60E1, upright (not inclined).

    Parameters
    ----------
    step : float
        Distance of the points along the profile, nearly [mm].

    Returns
    -------
    y, z : ndarray, shape (n,)
        From one flank to the other; z down from the top [mm].

    Examples
    --------
    >>> y, z = rail_60e1(0.25)
    >>> print(f"{z.min():.1f} {np.interp(14.3, z[y > 0], y[y > 0]):.2f}")
    0.0 36.00
    """
    centre, start, half = np.array([0.0, RADII[0]]), 0.0, []
    for radius, width, smaller in zip(RADII, HALF_WIDTHS, (*RADII[1:], 0.0), strict=True):
        half.append(_arc(start, width, (float(centre[0]), float(centre[1])), -radius, step))
        turned = np.arcsin((width - centre[0]) / radius)
        # the next arc's centre lies on the same radius: tangents meet
        centre = centre + (radius - smaller) * np.array([np.sin(turned), -np.cos(turned)])
        start = width
    y0, z0 = half[-1][0][-1], half[-1][1][-1]
    z = np.linspace(z0, FLANK_DEPTH, max(2, round((FLANK_DEPTH - z0) / step)))
    half.append((y0 + (z - z0) / FLANK_SLOPE, z))
    y, z = _joined(half)
    return np.concatenate([-y[:0:-1], y]), np.concatenate([z[:0:-1], z])


def _arc(
    first: float, last: float, centre: tuple[float, float], radius: float, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Points of an arc between two y, below its centre (larger z) for a positive radius, above it for a negative."""
    ends = np.arcsin((np.array([first, last]) - centre[0]) / abs(radius))
    angles = np.linspace(ends[0], ends[1], max(2, int(np.ceil(abs(radius * (ends[1] - ends[0])) / step)) + 1))
    return centre[0] + abs(radius) * np.sin(angles), centre[1] + radius * np.cos(angles)


def _polynomial(
    first: float, last: float, coefficients: tuple[float, ...], step: float
) -> tuple[np.ndarray, np.ndarray]:
    """Points of a polynomial, lowest power first, between two y."""
    y = np.linspace(first, last, max(2, int(np.ceil((last - first) / step)) + 1))
    return y, polyval(y, coefficients)


def _joined(sections: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Sections one after the other; where two meet, the point of the second."""
    y = np.concatenate([*(section[0][:-1] for section in sections[:-1]), sections[-1][0]])
    z = np.concatenate([*(section[1][:-1] for section in sections[:-1]), sections[-1][1]])
    return y, z
