"""Estimated excess of the size of a stress over its linear interpolation between samples."""

from __future__ import annotations

import numpy as np

from varcontact.plasticity.passage import Passage

SMALLEST = 1e-9
"""Size of a stress, divided by the yield stress, below which its direction is undefined."""


def between_samples(passage: Passage, stress: np.ndarray, bent: np.ndarray) -> np.ndarray:
    """Estimated excess (nz, ny, nx) of |stress| next to each sample (nz, ny, nx, 5).

    Along each axis ``h^2/8`` times ``-|t|''``, by second differences. `bent` is the stress without
    the parts that are linear between samples of y and depth by their definition.
    """
    along = excess(stress, stress, passage.x, 2)
    across = excess(stress, bent, passage.y, 1)
    down = excess(stress, bent, passage.depth, 0)
    return along + across + down


def excess(stress: np.ndarray, bent: np.ndarray, places: np.ndarray, axis: int) -> np.ndarray:
    """Estimated excess of |stress| along one axis: ``|t|'' = (t . t'' + |t' across t|^2)/|t|``, by
    products of neighbouring stresses.
    """
    stress = np.moveaxis(stress, axis, 0)
    bent = np.moveaxis(bent, axis, 0)
    step = np.diff(places).reshape(-1, *[1] * (stress.ndim - 2))
    before = step[:-1]
    after = step[1:]
    square = np.maximum(_dot(stress, stress), SMALLEST**2)
    middle = square[1:-1]
    beside = _dot(stress[1:], stress[:-1])
    # curvature, against the direction of the stress
    own = _dot(bent, stress)[1:-1]
    rise = (_dot(bent[2:], stress[1:-1]) - own) / after
    rise_before = (own - _dot(bent[:-2], stress[1:-1])) / before
    inward = 2 * (rise_before - rise) / (before + after)
    # rotation makes the norm convex: the side with the smaller effect counts
    across = (square[2:] - beside[1:] ** 2 / middle) / after**2
    across_before = (square[:-2] - beside[:-1] ** 2 / middle) / before**2
    inward = np.maximum(inward - np.minimum(across, across_before), 0.0) / np.sqrt(middle)
    amount = inward * np.maximum(after, before) ** 2 / 8
    amount = np.concatenate([amount[:1], amount, amount[-1:]])
    return np.moveaxis(amount, 0, axis)


def _dot(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return np.einsum("...q,...q->...", first, second)
