"""Fields on a zero-padded box and their spectra: the parts of products by FFT."""

from __future__ import annotations

import numpy as np


def spectrum_of(fields: np.ndarray, box: tuple[int, int]) -> np.ndarray:
    """Transform of fields (..., ny, nx) on a zero-padded box of (rows, columns)."""
    from scipy import fft

    return np.asarray(fft.fft(fft.rfft(fields, box[1], axis=-1), box[0], axis=-2, overwrite_x=True))


def fields_of(spectrum: np.ndarray, box: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """The first (ny, nx) of the fields on a box that have a spectrum, which is overwritten."""
    from scipy import fft

    # along x only those that are asked for
    rows = fft.ifft(spectrum, axis=-2, overwrite_x=True)[..., : shape[0], :]
    return np.asarray(fft.irfft(rows, box[1], axis=-1)[..., : shape[1]])


def repeated(
    box: tuple[int, int], shape: tuple[int, int], period: tuple[bool, bool]
) -> tuple[int, int]:
    """Lengths of transforms: those of a box, and of the shape along axes that repeat."""
    rows, columns = np.where(period, shape, box).tolist()
    return rows, columns


def wrapped(
    numbers: np.ndarray, box: tuple[int, int], period: tuple[bool, bool] = (False, False)
) -> np.ndarray:
    """Numbers by offset (..., 2 ny - 1, 2 nx - 1) on a periodic box, offset zero first; what meets
    there is added, but along axes that the numbers repeat along.
    """
    periodic = np.zeros((*numbers.shape[:-2], *box), dtype=numbers.dtype)
    for rows, to_rows in _halves((numbers.shape[-2] + 1) // 2, box[0], period[0]):
        for columns, to_columns in _halves((numbers.shape[-1] + 1) // 2, box[1], period[1]):
            periodic[..., to_rows, to_columns] += numbers[..., rows, columns]
    return periodic


def _halves(n: int, period: int, repeats: bool) -> list[tuple[slice, slice]]:
    """Negative offsets and the others, from -(n - 1) to n - 1, with their places in a period; the
    others alone where they repeat.
    """
    negative = slice(0, n - 1), slice(period - n + 1, None)
    others = slice(n - 1, None), slice(0, n)
    if repeats:
        return [others]
    return [negative, others]


def fft_box(ny: int, nx: int) -> tuple[int, int]:
    """Lengths of the transforms on a grid: products wrap around below index n - 1, where they are
    not read.
    """
    from scipy.fft import next_fast_len

    return next_fast_len(2 * ny - 1, real=True), next_fast_len(2 * nx - 1, real=True)


def table_bytes(ny: int, nx: int, blocks: int) -> int:
    """Memory in bytes for a table of influence numbers and its transform, by its pairs of
    components.
    """
    rows, columns = fft_box(ny, nx)
    return 8 * blocks * ((2 * ny - 1) * (2 * nx - 1) + 2 * rows * (columns // 2 + 1))
