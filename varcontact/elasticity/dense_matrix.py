"""Dense matrices between elements, from a table of influence numbers by offset."""

from __future__ import annotations

import numpy as np

ROWS_AT_ONCE = 64
"""Rows of elements of a dense matrix that are assembled at a time."""


def matrix_of_table(
    table: np.ndarray, shape: tuple[int, int], elements: np.ndarray, loaded: np.ndarray
) -> np.ndarray:
    """The matrix (rows * n, columns * m) from tractions on m loaded elements of a grid (ny, nx) to
    displacements in n, by their flat indices.
    """
    ny, nx = shape
    # places in a flat table are differences of those of the two elements
    width = 2 * nx - 1
    iy, ix = np.divmod(elements, nx)
    jy, jx = np.divmod(loaded, nx)
    place = iy * width + ix
    back = jy * width + jx - (ny - 1) * width - nx + 1
    rows, columns = table.shape[:2]
    n = elements.size
    m = loaded.size
    tables = table.reshape(rows, columns, -1)
    if _without_gaps(place) and _without_gaps(back):
        return _along_a_row(tables, place[0] - back[0], n, m)
    matrix = np.empty((rows, n, columns, m))
    # their offsets take as much memory as a block of the matrix
    for first in range(0, n, ROWS_AT_ONCE):
        part = slice(first, first + ROWS_AT_ONCE)
        offset = place[part, None] - back
        for i in range(rows):
            for j in range(columns):
                matrix[i, part, j] = tables[i, j].take(offset)
    return matrix.reshape(rows * n, columns * m)


def _without_gaps(places: np.ndarray) -> bool:
    """True for elements that follow each other in one row."""
    return places.size > 0 and bool((places[1:] - places[:-1] == 1).all())


def _along_a_row(tables: np.ndarray, first: int, n: int, m: int) -> np.ndarray:
    """The matrix between n elements and m loaded ones without gaps, whose first ones are at an
    offset: number ij is that of the offset ``first + i - j``.
    """
    rows, columns, _ = tables.shape
    backwards = np.ascontiguousarray(tables[..., first - m + 1 : first + n][..., ::-1])
    of_row, of_column, step = backwards.strides
    windows = np.ndarray(
        shape=(rows, n, columns, m),
        dtype=backwards.dtype,
        buffer=backwards,
        offset=(n - 1) * step,
        strides=(of_row, -step, of_column, step),
    )
    return windows.copy().reshape(rows * n, columns * m)
