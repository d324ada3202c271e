"""The preconditioner: inverses of the kernel on a periodic box, one for the stick area and one for the slip area.

A circulant of the kernel would be exact for a contact that repeats itself. The box is only an eighth wider than the
contact; a Parzen window takes the kernel to zero at its ends, which keeps the symbol positive.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.elasticity.operators import GridOperator
from varcontact.solvers.newton.kernel import Kernel, kernel, weighted, wrapped_transform

WIDER = 1.125
"""Width of the periodic box by that of the contact."""
CAUSAL = 0.03
"""In rolling, particles bring displacements along: a weight that falls by this along x over one period."""
STICK_SHIFT = 0.05
"""Added to the symbol in the stick area."""
FLOOR = 1e-3
"""Least symbol of normal contact."""
SKEW = 0.3
"""Skewness of a kernel from which it is one of rolling."""
PAIRS = 2
"""Pairs of inverses that are remembered."""


@dataclass(frozen=True, eq=False)
class Circulant:
    """The windowed kernel on a periodic box.

    Attributes
    ----------
    kernel : Kernel
    """

    kernel: Kernel

    @cached_property
    def rolling(self) -> int:
        """1 or -1 where the bodies roll, by the direction; 0 in a shift."""
        skewness = self.kernel.skewness
        return 0 if abs(skewness) < SKEW else int(np.sign(skewness))

    @cached_property
    def _box(self) -> tuple[int, int]:
        from scipy.fft import next_fast_len

        ny, nx = self.kernel.shape
        return next_fast_len(int(WIDER * ny)), next_fast_len(int(WIDER * nx), real=True)

    @cached_property
    def growth(self) -> np.ndarray:
        """The causal weight along x, (nx,), all ones in a shift."""
        rate = self.rolling * np.log(CAUSAL) / self._box[1]
        return np.exp(-rate * np.arange(self.kernel.shape[1])).astype(np.float32)

    @cached_property
    def symbol(self) -> np.ndarray:
        """Of the windowed kernel, weighted."""
        (ny, nx), (rows, columns) = self.kernel.shape, self._box
        y, x = np.arange(-(ny - 1), ny), np.arange(-(nx - 1), nx)
        causal = np.exp(-self.rolling * np.log(CAUSAL) * x / columns)
        window = parzen(y / rows)[:, None] * (parzen(x / columns) * causal)
        return wrapped_transform(self.kernel.numbers * window.astype(np.float32), self._box)

    @cached_property
    def stick(self) -> np.ndarray:
        """The inverse for the stick area."""
        return self.inverse(STICK_SHIFT)

    @cached_property
    def floored(self) -> np.ndarray:
        """The inverse for normal contact."""
        return (1 / np.maximum(self.symbol.real, FLOOR)).astype(np.complex64)

    def pair(self, shift: float) -> np.ndarray:
        """Both inverses, (3, 2, ...) or (1, 2, ...): for the stick area, and with a shift for the slip area.

        Remembered for shifts that hardly differ.

        Parameters
        ----------
        shift : float
            Added to the diagonal for the slip area, in units of the kernel.
        """
        kept: dict[float, np.ndarray] = self.__dict__.setdefault("_pairs", {})
        if shift not in kept:
            kept[shift] = np.stack([self.stick, self.inverse(shift)], axis=1)
            for oldest in list(kept)[:-PAIRS]:
                del kept[oldest]
        return kept[shift]

    def inverse(self, shift: float) -> np.ndarray:
        """Symbol of the inverse of the kernel plus a number on its diagonal.

        Parameters
        ----------
        shift : float
            The number, in units of the kernel.

        Returns
        -------
        ndarray, shape (3, ...) or (1, ...)
            xx, xy and yy; or that of the one component.
        """
        if len(self.symbol) == 1:
            return 1 / (self.symbol + np.float32(shift))
        xx, xy, yy = self.symbol[0] + np.float32(shift), self.symbol[1], self.symbol[2] + np.float32(shift)
        determinant = xx * yy - xy * xy
        inverse = np.array([yy, -xy, xx])
        inverse /= determinant
        return inverse

    def apply(self, inverses: np.ndarray, fields: np.ndarray) -> np.ndarray:
        """Inverses times fields, both weighted: multiplied by `growth`.

        Parameters
        ----------
        inverses : ndarray, shape (m, k, ...)
            Symbols, m = 3 or 1.
        fields : ndarray, shape (c, k, ny, nx)

        Returns
        -------
        ndarray, shape (c, k, ny, nx)
        """
        from scipy import fft

        (ny, nx), (rows, columns) = self.kernel.shape, self._box
        spectrum = fft.fft(fft.rfft(fields, columns, axis=-1), rows, axis=-2, overwrite_x=True)
        image = fft.ifft(weighted(inverses, spectrum), axis=-2, overwrite_x=True)[:, :, :ny]
        return fft.irfft(image, columns, axis=-1)[..., :nx]


def circulant(operator: GridOperator, shape: tuple[int, int], halvings: int = 0) -> Circulant:
    """That of the kernel of a box; remembered with it.

    Parameters
    ----------
    operator : GridOperator
    shape : tuple of int
        (ny, nx) of the box.
    halvings : int
        As of `kernel`.
    """
    of_box = kernel(operator, shape, halvings)
    found: Circulant = of_box.__dict__.setdefault("_circulant", Circulant(of_box))
    return found


def parzen(t: np.ndarray) -> np.ndarray:
    """Parzen's window on [-1, 1]: its transform is positive.

    Parameters
    ----------
    t : ndarray
        Distance, by the length of the window [-].
    """
    t = np.abs(t)
    return np.where(t < 0.5, 1 - 6 * t**2 + 6 * t**3, 2 * np.maximum(1 - t, 0.0) ** 3)
