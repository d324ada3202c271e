"""How far the size of a stress can exceed its linear interpolation between samples."""

from __future__ import annotations

import numpy as np

from varcontact.plasticity.passage import Passage

SMALLEST = 1e-9
"""Size of a stress, by the yield stress, below which it has no direction."""


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
    """The same along one axis: ``|t|'' = (t . t'' + |t' across t|^2)/|t|``."""
    step = np.diff(places)
    column = (-1, *[1] * (stress.ndim - 1))
    stress = np.moveaxis(stress, axis, 0)
    bent = np.moveaxis(bent, axis, 0)
    # curvature, against the direction of the stress
    slope = np.diff(bent, axis=0) / step.reshape(column)
    curvature = np.diff(slope, axis=0) * (2 / (step[1:] + step[:-1])).reshape(column)
    size = np.maximum(np.linalg.norm(stress[1:-1], axis=-1), SMALLEST)
    inward = -np.einsum("...q,...q->...", curvature, stress[1:-1]) / size
    # turning makes a norm convex: of both sides the one that counts less
    slope = np.diff(stress, axis=0) / step.reshape(column)
    turning = np.minimum(
        _across(slope[1:], stress[1:-1], size), _across(slope[:-1], stress[1:-1], size)
    )
    inward = np.maximum(inward - turning / size, 0.0)
    weight = np.maximum(step[1:], step[:-1]) ** 2 / 8
    amount = inward * weight.reshape(-1, *[1] * (inward.ndim - 1))
    amount = np.concatenate([amount[:1], amount, amount[-1:]])
    return np.moveaxis(amount, 0, axis)


def _across(slope: np.ndarray, stress: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Square of the part of a slope that is across the stress."""
    along = np.einsum("...q,...q->...", slope, stress) / size
    return np.einsum("...q,...q->...", slope, slope) - along**2
