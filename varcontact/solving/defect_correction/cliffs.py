"""Cliffs of sampled surfaces: where a body ends, or has a step, the pressure is not what the passes take it for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.scene.interpolation import how_to_smooth
from varcontact.scene.surfaces import SampledDistance
from varcontact.solving.defect_correction.check import KINDS

TELLS, TELLS_LINE = 0.3, 0.15
"""Pressure by a step alone, by the mean pressure, from which on estimates are missed; and in line contact."""
ALONE = 8.0
"""A cliff is so many times as high as half of the steps around: noise steps everywhere, and is warned of."""
WIDEST = 0.5
"""Elements over which a cliff rises, at most, where samples are closer: what is wider, elements resolve."""


@dataclass(frozen=True)
class Cliff:
    """A step of the samples. In the scene's units.

    Attributes
    ----------
    height, over : float
        Its height, and the length between the samples that it is seen by.
    slope : float
        The height by that length, or by an element's, if that is longer.
    x, y : float
        Its middle.
    """

    height: float
    over: float
    slope: float
    x: float
    y: float


def check_cliffs(disc: Discretisation, state: ContactState) -> None:
    """Refuse a contact with a cliff of the samples in it, or within an element of it.

    Parameters
    ----------
    disc : Discretisation
    state : ContactState
        With its pressure.

    Raises
    ------
    SceneError
        Naming the cliff, and what to do instead.

    Notes
    -----
    A step d of the distance takes the pressure ``G d / (pi (1 - nu) r)`` at the distance r to be pressed flat. What it
    is at the distance of an element, or at that over which the samples step, is compared with the mean pressure.
    """
    surface, contact = disc.surface, state.pressure > 0
    if not isinstance(surface, SampledDistance) or not surface.placed or not contact.any():
        return
    cliff = steepest_cliff(surface, disc.grid, contact)
    if cliff is None:
        return
    pressure = cliff.slope * disc.scales.length / disc.scales.displacement / (math.pi * (1 - disc.bodies.combined_nu))
    if pressure < (TELLS_LINE if disc.line else TELLS) * float(state.pressure[contact].mean()):
        return
    place = f"x = {cliff.x:.3g}" + ("" if disc.line else f", y = {cliff.y:.3g}")
    raise SceneError(
        "refine",
        KINDS[0],
        "left out",
        message=f'refine = "{KINDS[0]}": surface.h has a cliff in the contact or next to it, where estimates of the '
        f"error fail: a step of {cliff.height:.3g} over {cliff.over:.3g} at {place}. Leave refine out and solve on a "
        f"fine grid; or, where the step is no part of the body, {how_to_smooth('...')}",
    )


def steepest_cliff(surface: SampledDistance, grid: Grid, elements: np.ndarray) -> Cliff | None:
    """The steepest step of the samples in some elements, or within one element of them.

    Parameters
    ----------
    surface : SampledDistance
        With coordinates.
    grid : Grid
        Explicit.
    elements : ndarray of bool, shape (ny, nx)

    Returns
    -------
    Cliff or None
        None where the slope of the samples has no jump to and fro.
    """
    (x, y), h, (dx, dy) = surface.coordinates, surface.samples, grid.sides
    columns = _touched(x, grid.lines[0], dx)
    if surface.line:
        found = [_steepest(h, x, elements @ columns.T > 0, dx)]
        return None if found[0] is None else Cliff(*found[0][:4], 0.0)
    rows = _touched(y, grid.lines[1], dy)
    along_x = _steepest(h, x, _beside(rows) @ elements @ columns.T > 0, dx)
    along_y = _steepest(h.T, y, (rows @ elements @ _beside(columns).T > 0).T, dy)
    cliffs = [] if along_x is None else [Cliff(*along_x[:4], float(y[along_x[4]]))]
    if along_y is not None:
        cliffs.append(Cliff(*along_y[:3], float(x[along_y[4]]), along_y[3]))
    return max(cliffs, key=lambda cliff: cliff.slope, default=None)


def _touched(points: np.ndarray, lines: np.ndarray, side: float) -> np.ndarray:
    """Which intervals between points reach to within one element of an element, (intervals, elements)."""
    return ((points[:-1, None] < lines[None, 1:] + side) & (points[1:, None] > lines[None, :-1] - side)).astype(float)


def _beside(intervals: np.ndarray) -> np.ndarray:
    """The same of the points: those at an end of such an interval."""
    return np.maximum(np.pad(intervals, ((0, 1), (0, 0))), np.pad(intervals, ((1, 0), (0, 0))))


def _steepest(
    h: np.ndarray, x: np.ndarray, near: np.ndarray, side: float
) -> tuple[float, float, float, float, int] | None:
    """Height, length, slope, middle and row of the steepest cliff along the rows of samples; None where there is none.

    A step is where the slope between two samples is beyond those on both sides of it. In a kink it is not.

    Parameters
    ----------
    h : ndarray, shape (n, m)
        Rows of samples.
    x : ndarray, shape (m,)
    near : ndarray of bool, shape (n, m - 1)
        The intervals between samples that are looked at.
    side : float
        Of an element.
    """
    rows = np.flatnonzero(near.any(axis=1))
    h, near, found, wide = h[rows], near[rows], [], 1
    spacing = float(np.median(np.diff(x)))
    while 3 * wide < x.size and (wide == 1 or wide * spacing <= WIDEST * side):
        lengths = x[wide:] - x[:-wide]
        slopes, inner = (h[:, wide:] - h[:, :-wide]) / lengths, lengths[wide:-wide]
        before, slope, after = slopes[:, : -2 * wide], slopes[:, wide:-wide], slopes[:, 2 * wide :]
        step = np.maximum(slope - np.maximum(before, after), np.minimum(before, after) - slope) * inner
        first = wide + (wide - 1) // 2  # the interval in the middle
        looked = near[:, first : first + inner.size]
        if looked.any():
            usual = float(np.median((np.abs(slope - (before + after) / 2) * inner)[looked]))
            steep = np.where(looked & (step > ALONE * usual), step / np.maximum(inner, side), 0.0)
            row, i = np.unravel_index(np.argmax(steep), steep.shape)
            if steep[row, i] > 0:
                middle = float(x[i + wide] + x[i + 2 * wide]) / 2
                found.append((float(step[row, i]), float(inner[i]), float(steep[row, i]), middle, int(rows[row])))
        wide *= 2
    return max(found, key=lambda each: each[2], default=None)
