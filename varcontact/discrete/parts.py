"""Equal parts of elements."""

from __future__ import annotations

import numpy as np

from varcontact.scene.grid import Cells


def means(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Means over the parts of each element.

    Parameters
    ----------
    values : ndarray, shape (..., ny rows, nx columns)
    cells : tuple of int

    Returns
    -------
    ndarray, shape (..., ny, nx)
    """
    rows, columns = cells
    ny, nx = values.shape[-2] // rows, values.shape[-1] // columns
    return np.asarray(values.reshape(*values.shape[:-2], ny, rows, nx, columns).mean(axis=(-3, -1)))
