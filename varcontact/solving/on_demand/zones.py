"""Zones of slip and of stick that are too thin for the elements of a grid."""

from __future__ import annotations

import numpy as np

from varcontact.problem.slip import EXTERIOR, SLIP, STICK
from varcontact.results.solution import Solution

WIDE = 3.5
"""Elements along a row above which they resolve a zone."""
NEARLY = 0.7
"""Part of its bound from which on a traction that sticks at the leading edge may hide a slip zone."""


def unresolved(solution: Solution, finer: float = 1.0) -> float:
    """Which part of the elements in contact is in rows with a zone of slip or stick that they do not resolve.

    Particles carry what happens in such a zone through all of the row behind it. The zone is of slip at the leading
    edge, or between others; thin ones behind all others do not count. It may be thinner than an element: where
    tractions that slip reverse from one element to the next, or are near the bound at the leading edge.

    Parameters
    ----------
    solution : Solution
        Of steady rolling, with friction.
    finer : float
        By how many times the elements of the grid in question are shorter than the solution's.

    Returns
    -------
    float
        In [0, 1].

    Examples
    --------
    Where all slips there is none; where it does not, rows near the sides have a short zone at their front.

    >>> import varcontact as vc
    >>> def rolling(vx):
    ...     return vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(1.0, 1.0), normal_force=1.0,
    ...                     friction=0.3, motion=vc.Steady(vx=vx), grid=vc.Grid(12, 12))
    >>> [round(unresolved(vc.solve(rolling(vx))), 2) for vx in (0.2, 0.1)]
    [0.0, 0.39]
    """
    state = _from_the_leading_edge(solution.state)
    traction = np.array([_from_the_leading_edge(part) for part in solution.traction])
    bound = _from_the_leading_edge(solution.traction_bound)
    width, flat = state.shape[1], state.ravel()

    borders = np.flatnonzero(np.diff(flat)) + 1
    first, lengths = borders[:-1], np.diff(borders)
    zone, ahead, behind = flat[first], flat[first - 1], flat[borders[1:]]
    counts = (zone != EXTERIOR) & (behind != EXTERIOR) & ((zone == SLIP) | (ahead != EXTERIOR))
    thin = first[counts & (lengths * finer < WIDE)]

    leading = (state[:, 1:] == STICK) & (state[:, :-1] == EXTERIOR)
    hidden = leading & (np.hypot(*traction) > NEARLY * bound)[:, 1:]
    both_slip = (state[:, 1:] == SLIP) & (state[:, :-1] == SLIP)
    reversed_ = both_slip & (np.sum(traction[..., 1:] * traction[..., :-1], axis=0) < 0)

    rows = (hidden | reversed_).any(axis=1)
    rows[thin // width] = True
    contact = (state != EXTERIOR).sum(axis=1)
    return float(contact[rows].sum() / max(contact.sum(), 1))


def _from_the_leading_edge(values: np.ndarray) -> np.ndarray:
    """Rows against the rolling direction, with nothing before and behind them."""
    return np.pad(values[:, ::-1], ((0, 0), (1, 1)))
