"""Fields on a zero-padded box and their spectra: the parts of products by FFT.

On small boxes the transforms are products with matrices of cosines and sines, which take a half to
a quarter of the time of an FFT.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

MATRIX_SIZE = 4096
"""Elements of a box up to which transforms are computed by matrix products."""
MATRIX_LENGTH = 256
"""Longest side of a box whose transforms are computed by matrix products."""


def spectrum_of(fields: np.ndarray, box: tuple[int, int]) -> np.ndarray:
    """Transform of fields (..., ny, nx) on a zero-padded box of (rows, columns)."""
    if _by_matrices(box):
        return _spectrum_by_matrices(fields, box)
    from scipy import fft

    return np.asarray(fft.fft(fft.rfft(fields, box[1], axis=-1), box[0], axis=-2, overwrite_x=True))


def fields_of(spectrum: np.ndarray, box: tuple[int, int], shape: tuple[int, int]) -> np.ndarray:
    """The first (ny, nx) of the fields on a box that have a spectrum, which is overwritten."""
    if _by_matrices(box):
        return _fields_by_matrices(spectrum, box, shape)
    from scipy import fft

    # along x only those that are asked for
    rows = fft.ifft(spectrum, axis=-2, overwrite_x=True)[..., : shape[0], :]
    return np.asarray(fft.irfft(rows, box[1], axis=-1)[..., : shape[1]])


def by_symbol(
    symbol: np.ndarray, field: np.ndarray, box: tuple[int, int], shape: tuple[int, int]
) -> np.ndarray:
    """The periodic operator of a symbol (c, c, ...) times a field, on the elements."""
    spectrum = spectrum_of(field, box)
    image = symbol[:, 0] * spectrum[0]
    for column in range(1, len(spectrum)):
        image += symbol[:, column] * spectrum[column]
    return fields_of(image, box, shape)


def _by_matrices(box: tuple[int, int]) -> bool:
    return box[0] * box[1] <= MATRIX_SIZE and max(box) <= MATRIX_LENGTH


def _spectrum_by_matrices(fields: np.ndarray, box: tuple[int, int]) -> np.ndarray:
    ny, nx = fields.shape[-2:]
    kind = np.result_type(fields, np.complex64)
    waves = fields @ _to_waves(nx, box[1], kind)
    spectrum: np.ndarray = waves.view(kind)
    if box[0] == 1:
        return spectrum
    return np.asarray(_to_complex_waves(ny, box[0], kind) @ spectrum)


def _fields_by_matrices(
    spectrum: np.ndarray, box: tuple[int, int], shape: tuple[int, int]
) -> np.ndarray:
    kind = spectrum.dtype
    rows = spectrum
    if box[0] > 1:
        rows = _from_complex_waves(shape[0], box[0], kind) @ spectrum
    waves = np.ascontiguousarray(rows).view(spectrum.real.dtype)
    return np.asarray(waves @ _from_waves(shape[1], box[1], kind))


def _waves(n: int, length: int) -> np.ndarray:
    """The waves of a box at its first n places, (length, n)."""
    turns = np.outer(np.arange(length), np.arange(n)) % length / length
    return np.exp(-2j * np.pi * turns)


@lru_cache(maxsize=64)
def _to_waves(n: int, length: int, kind: np.dtype) -> np.ndarray:
    """Matrix (n, 2 waves) from real values to the real and imaginary parts of waves."""
    waves = np.ascontiguousarray(_waves(n, length)[: length // 2 + 1].T).astype(kind)
    return waves.view(waves.real.dtype)


@lru_cache(maxsize=64)
def _from_waves(n: int, length: int, kind: np.dtype) -> np.ndarray:
    """Matrix (2 waves, n) from the real and imaginary parts of waves to real values."""
    waves = _waves(n, length)[: length // 2 + 1].astype(kind) / length
    # all but the first, and the last of an even number, stand for two
    waves[1 : (length + 1) // 2] *= 2
    parts = np.stack([waves.real, waves.imag], axis=1)
    return parts.reshape(-1, n)


@lru_cache(maxsize=64)
def _to_complex_waves(n: int, length: int, kind: np.dtype) -> np.ndarray:
    """Matrix (length, n) from complex values to waves."""
    return _waves(n, length).astype(kind)


@lru_cache(maxsize=64)
def _from_complex_waves(n: int, length: int, kind: np.dtype) -> np.ndarray:
    """Matrix (n, length) from waves to complex values."""
    waves = np.conj(_waves(n, length)).T / length
    return np.ascontiguousarray(waves.astype(kind))


def repeated(
    box: tuple[int, int], shape: tuple[int, int], period: tuple[bool, bool]
) -> tuple[int, int]:
    """Lengths of transforms: those of a box, and of the shape along axes that repeat."""
    rows, columns = box
    if period[0]:
        rows = shape[0]
    if period[1]:
        columns = shape[1]
    return rows, columns


def wrapped(
    numbers: np.ndarray, box: tuple[int, int], period: tuple[bool, bool] = (False, False)
) -> np.ndarray:
    """Numbers by offset (..., 2 ny - 1, 2 nx - 1) on a periodic box, offset zero first; coinciding
    ones are added, except along axes in which the numbers are periodic.
    """
    periodic = np.zeros((*numbers.shape[:-2], *box), dtype=numbers.dtype)
    for rows, to_rows in _halves((numbers.shape[-2] + 1) // 2, box[0], period[0]):
        for columns, to_columns in _halves((numbers.shape[-1] + 1) // 2, box[1], period[1]):
            periodic[..., to_rows, to_columns] += numbers[..., rows, columns]
    return periodic


def _halves(n: int, period: int, repeats: bool) -> list[tuple[slice, slice]]:
    """Places of the negative and the other offsets, from -(n - 1) to n - 1, in a period; the latter
    alone along periodic axes.
    """
    negative = slice(0, n - 1), slice(period - n + 1, None)
    others = slice(n - 1, None), slice(0, n)
    if repeats:
        return [others]
    return [negative, others]


def fft_box(ny: int, nx: int) -> tuple[int, int]:
    """Lengths of the transforms on a grid: products wrap around below index n - 1 only, where they
    are not read.
    """
    from scipy.fft import next_fast_len

    return next_fast_len(2 * ny - 1, real=True), next_fast_len(2 * nx - 1, real=True)


def table_bytes(ny: int, nx: int, blocks: int) -> int:
    """Memory of a table of influence numbers and its transform [bytes], with `blocks` pairs of
    components.
    """
    rows, columns = fft_box(ny, nx)
    return 8 * blocks * ((2 * ny - 1) * (2 * nx - 1) + 2 * rows * (columns // 2 + 1))
