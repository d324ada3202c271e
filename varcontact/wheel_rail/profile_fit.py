"""Points of a profile against a curve: normal distances, the rigid motion that fits, outliers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from varcontact.errors import SceneError
from varcontact.wheel_rail.curve import Curve

STEP = 0.05
"""Spacing of the samples of the curve on which points are projected [mm]."""
FAR = 20.0
"""Distance beyond which a point is not opposite the curve [mm]."""
FEWEST = 10
"""Least number of points opposite the curve."""
MOTIONS = 200
"""Largest number of steps of the fit."""
MOTION_TOL = 1e-10
"""Change of shift [mm] and rotation [rad] at which the fit ends."""

BESIDE = 5
"""Points on either side through which the parabola at a point is fitted."""
DEVIATIONS = 6.0
"""Least distance of an outlier, in robust standard deviations of all distances."""
DISTANCE_MIN = 0.02
"""Least distance of an outlier [mm]."""
CURVATURE_JUMP = 0.1
"""Jump of curvature between arcs of designed profiles [1/mm]; 1/10 of it times the square of the
half width does not count as an outlier."""
MAD = 1.4826
"""Standard deviation of normal noise, divided by its median absolute deviation."""
BISQUARE = 4.685
"""Robust standard deviations at which Tukey's weights end."""
REWEIGHTED = 10


def normal_distances(points: np.ndarray, curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distances of points, shape (n, 2), along normals of a curve, positive below it (larger z);
    NaN where no point of the curve is opposite. Also the normals and the points on the curve.
    """
    from scipy.spatial import cKDTree

    s = curve.sampled(STEP)
    samples = curve.points(s)
    away, nearest = cKDTree(samples).query(points)
    # on the curve, by one step of Newton's method from the nearest sample
    along = curve.directions(s[nearest])
    offset = ((points - samples[nearest]) * along).sum(axis=1)
    places = np.clip(s[nearest] + np.clip(offset, -STEP, STEP), s[0], s[-1])
    feet = curve.points(places)
    along = curve.directions(places)
    along /= np.hypot(*along.T)[:, None]
    normals = np.stack([-along[:, 1], along[:, 0]], axis=1)
    distances = ((points - feet) * normals).sum(axis=1)
    beyond = ((nearest == 0) & (offset < 0)) | ((nearest == s.size - 1) & (offset > 0))
    distances[beyond | (away > FAR)] = np.nan
    return distances, normals, feet


def turning(angle: float) -> np.ndarray:
    """Matrix that turns (y, z) from y towards z."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def fitted(
    points: np.ndarray, curve: Curve, over: tuple[float, float], rotate: bool
) -> tuple[float, np.ndarray]:
    """Rotation [rad] and shift [mm], ``turning(angle) @ point + shift``, with the least squares of
    the normal distances from a curve, of the points whose y on the curve is within `over`.

    Gauss and Newton's method, with the points opposite found anew in each step.
    """
    angle = 0.0
    shift = np.zeros(2)
    for _ in range(MOTIONS):
        moved = points @ turning(angle).T + shift
        distances, normals, feet = normal_distances(moved, curve)
        opposite = np.isfinite(distances) & (feet[:, 0] >= over[0]) & (feet[:, 0] <= over[1])
        if opposite.sum() < FEWEST:
            near = int(np.isfinite(distances).sum())
            if near >= FEWEST:
                allowed = (
                    f"opposite at least {FEWEST} of the {near} points near the other profile; "
                    f"{opposite.sum()} are"
                )
                raise SceneError("over", over, allowed)
            raise SceneError("to", near, message=_apart(points))
        # small rotations are about the centre of the opposite points
        middle = moved[opposite].mean(axis=0)
        arms = moved[opposite] - middle
        normal = normals[opposite]
        columns = [normal[:, 0], normal[:, 1]]
        if rotate:
            columns.append(normal[:, 1] * arms[:, 0] - normal[:, 0] * arms[:, 1])
        step = np.linalg.lstsq(np.stack(columns, axis=1), -distances[opposite], rcond=1e-8)[0]
        turn = 0.0
        if rotate:
            turn = float(step[2])
        shift = turning(turn) @ (shift - middle) + middle + step[:2]
        angle += turn
        if np.abs(step).max() < MOTION_TOL:
            break
    return angle, shift


def _apart(points: np.ndarray) -> str:
    return (
        f"to: the profiles do not overlap: fewer than {FEWEST} points of y = "
        f"{points[:, 0].min():.4g} to {points[:, 0].max():.4g} mm are within {FAR:g} mm of the "
        f"profile to align to; move the profile near it first, with shifted()"
    )


def outlying(points: np.ndarray, kinks: np.ndarray, distance: float | None) -> np.ndarray:
    """Indices of points farther than a distance from the curve through their neighbours [mm]."""
    distances = np.zeros(len(points))
    least = np.full(len(points), np.inf)
    for first, last in pairwise([0, *kinks.tolist(), len(points) - 1]):
        section = slice(first, last + 1)
        if last - first < 2 * BESIDE:
            continue
        residuals, width = _off_parabola(points[section])
        distances[section] = residuals
        least[section] = np.maximum(DISTANCE_MIN, CURVATURE_JUMP * width**2 / 10)
    known = np.isfinite(least)
    if distance is not None:
        least[known] = distance
    elif known.any():
        deviation = MAD * float(np.median(np.abs(distances[known])))
        least = np.maximum(least, DEVIATIONS * deviation)
    return np.flatnonzero(np.abs(distances) > least)


def _off_parabola(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Normal distance of each point from a robust parabola through the points beside it, and the
    half width of these.

    Tukey's weights: of eleven points four may be wrong, beside each other too.
    """
    count = len(points)
    windows = np.clip(np.arange(count) - BESIDE, 0, count - 2 * BESIDE - 1)
    windows = windows[:, None] + np.arange(2 * BESIDE + 1)
    near = points[windows]
    # in axes along the median direction, from the point itself
    steps = np.diff(near, axis=1)
    along = np.median(steps / np.hypot(steps[..., :1], steps[..., 1:]), axis=1)
    along /= np.hypot(*along.T)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    from_point = near - points[:, None]
    t = np.einsum("nki,ni->nk", from_point, along)
    h = np.einsum("nki,ni->nk", from_point, across)
    width = np.ptp(t, axis=1) / 2
    powers = np.stack([np.ones_like(t), t / width[:, None], (t / width[:, None]) ** 2], axis=-1)
    # the median first, then Tukey's weights of the residuals
    residuals = h - np.median(h, axis=1, keepdims=True)
    for _ in range(REWEIGHTED):
        scale = MAD * np.median(np.abs(residuals), axis=1, keepdims=True)
        scale = np.maximum(scale, DISTANCE_MIN / BISQUARE)
        weights = np.maximum(1 - (residuals / (BISQUARE * scale)) ** 2, 0.0) ** 2
        normal = np.einsum("nk,nki,nkj->nij", weights, powers, powers)
        right_side = np.einsum("nk,nki,nk->ni", weights, powers, h)
        coefficients = (np.linalg.pinv(normal) @ right_side[..., None])[..., 0]
        residuals = h - np.einsum("nki,ni->nk", powers, coefficients)
    return -coefficients[:, 0], width
