"""Frames of the elements of a curved reference surface: rotations from the axes of an element to
those of the plane.
"""

from __future__ import annotations

import numpy as np


def frames_of_elements(by_row: np.ndarray, by_column: np.ndarray) -> np.ndarray:
    """Rotations (3, 3, ny, nx) by the inclinations of rows (ny,) and of columns (nx,) [rad].

    Columns are the axes x, y, z of an element: turned about x by the inclination of its row, then
    about y by that of its column. Positive inclinations rise towards positive y and x.
    """
    sin_y = np.sin(by_row)[:, None]
    cos_y = np.cos(by_row)[:, None]
    sin_x = np.sin(by_column)
    cos_x = np.cos(by_column)
    frames = np.zeros((3, 3, by_row.size, by_column.size))
    frames[0] = np.broadcast_arrays(cos_x, -sin_x * sin_y, -sin_x * cos_y)
    frames[1, 1] = cos_y
    frames[1, 2] = -sin_y
    frames[2] = np.broadcast_arrays(sin_x, cos_x * sin_y, cos_x * cos_y)
    return frames


def along_axes_of_plane(frames: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (3, ny, nx) along the axes of elements, turned to those of the plane."""
    return np.einsum("ij...,j...->i...", frames, vectors)


def half_turns(field: np.ndarray, loaded: np.ndarray) -> np.ndarray:
    """Half of the rotations from frames (3, 3, m) of loaded elements to those (3, 3, n) of a field,
    (3, 3, n, m), of less than half a turn each.
    """
    turns = np.einsum("kin,kjm->ijnm", field, loaded)
    # quaternions of the turns, of half their angle
    scalar = np.sqrt(np.maximum(1 + np.trace(turns), 0.0)) / 2
    axis = np.array([turns[j, i] - turns[i, j] for i, j in ((1, 2), (2, 0), (0, 1))]) / (4 * scalar)
    size = np.sqrt(2 * (1 + scalar))
    scalar = (1 + scalar) / size
    x, y, z = axis / size
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - scalar * z), 2 * (x * z + scalar * y)],
            [2 * (x * y + scalar * z), 1 - 2 * (x * x + z * z), 2 * (y * z - scalar * x)],
            [2 * (x * z - scalar * y), 2 * (y * z + scalar * x), 1 - 2 * (x * x + y * y)],
        ]
    )
