"""Problems in progress, their natural maps and linear systems: arrays whose last axis is the
problem.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.solvers.batched.problem import Batch


@dataclass(frozen=True, eq=False)
class Pool(Batch):
    """Problems in progress, each in its own units: tractions by the largest bound, shifts by an
    element's influence on itself.
    """

    ids: np.ndarray
    load: np.ndarray  # traction and shift that count as one
    unit: np.ndarray
    symbol: np.ndarray  # of the influence numbers, (3, Ky, Kx, n)
    symbol32: np.ndarray
    own: np.ndarray  # influence of elements on themselves, (2, n)
    windowed: np.ndarray  # symbol of the preconditioner
    stick_inverse: np.ndarray
    stick_inverse_turned: np.ndarray
    row_size: np.ndarray
    rigid_shift: np.ndarray
    bound: np.ndarray
    force: np.ndarray
    free: np.ndarray  # 1 where a force is prescribed, (2, n)
    per_element: np.ndarray  # 1/sqrt(elements in contact)
    traction: np.ndarray
    shift: np.ndarray
    rigid: np.ndarray
    rounding: np.ndarray
    steps: np.ndarray

    @property
    def size(self) -> int:
        return len(self.ids)


@dataclass(frozen=True, eq=False)
class NaturalMap(Batch):
    """Trial tractions ``p - E``, their lengths, forces lacking; of each problem the residual, its
    norm, the scale.
    """

    trial: np.ndarray
    length: np.ndarray
    lacking: np.ndarray
    residual: np.ndarray
    merit: np.ndarray
    size: np.ndarray


@dataclass(frozen=True, eq=False)
class NewtonEquations:
    """Newton's equations of all problems, in single precision: symmetric 2 x 2 matrices (xx, xy,
    yy) by element.
    """

    free: np.ndarray  # projection on what is not along slipping tractions
    along: np.ndarray
    own: np.ndarray
    weights: tuple[np.ndarray, np.ndarray]
    inverse: tuple[np.ndarray, np.ndarray]
    right: np.ndarray


def inner(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("nb,nb->b", a.reshape(-1, a.shape[-1]), b.reshape(-1, b.shape[-1]))


def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Symmetric 2 x 2 matrices (xx, xy, yy) times vectors, by element."""
    product = matrix[::2] * vector
    product += matrix[1] * vector[::-1]
    return product


def inverse_of(symbol: np.ndarray, shift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inverse (xx, yy, xy) of a symmetric symbol plus a shift: its real part, its imaginary part
    with both signs.
    """
    xx = symbol[0] + shift
    xy = symbol[1]
    yy = symbol[2] + shift
    reciprocal = 1 / (xx * yy + xy * xy)  # the symbol of xy has a factor i
    inverse = np.stack([yy * reciprocal, xx * reciprocal, 1j * xy * reciprocal])[:, :, None]
    imaginary = np.concatenate([-inverse.imag, inverse.imag], 2)
    return inverse.real.astype(np.float32), imaginary.astype(np.float32)
