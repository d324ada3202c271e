"""The symmetric part S of an operator, where it is positive definite: its least
eigenvalue, and energies ``b'S^-1 b``.

Up to `DENSE_LIMIT` elements Cholesky's factor shows that S is positive
definite. Beyond, the symbol on the periodic box shows it where it is positive
itself (shifts, steps in time, pressures). Else, in steady rolling, conjugate
gradients with products by FFT tell it, but for a chance below `MISSED`: see
docs/theory.md. All as far as floating point can.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from varcontact.elasticity.operators import GridOperator, RestrictedOperator
from varcontact.system.process import lazy_property

DENSE_LIMIT = 400
"""Elements up to which S is factored: with more, conjugate gradients by FFT are faster, ten times
so at 1000."""

MISSED = 1e-10
"""Probability, over the random start, that conjugate gradients take an S for positive definite that
is not."""

MISSED_SHARE = 1e-2
"""Factor on this probability in the residual at which conjugate gradients stop: it leaves room for
a lower bound on the least eigenvalue."""

SLACK = 1e-3
"""Relative error of an energy at which conjugate gradients stop; the bound includes it."""

ITERATIONS = 1000, 6000
"""Least and largest number of steps of conjugate gradients before they are given up."""
ELEMENT_STEPS = 4e7
"""Elements times steps between these numbers: some 6 s. The second-order difference takes 0.6 steps
an element, the first-order one 90 to 230 in all."""
SEED = 0
EPS = float(np.finfo(float).eps)


def positive_definite(
    operator: RestrictedOperator, dense_limit: int | None = None
) -> PositiveDefinite | None:
    """Symmetric part ``S = (M + M')/2`` of an operator, or None if it is not found to be positive
    definite.
    """
    if dense_limit is None:
        dense_limit = DENSE_LIMIT
    if operator.elements.size > dense_limit:
        symmetric = operator.grid_operator.symmetric_part()
        return _iterated(replace(operator, grid_operator=symmetric))
    return _factored(operator.matrix)


def norm(operator: GridOperator) -> float:
    """An upper bound on the 2-norm of a grid operator, on any of its elements."""
    return operator.norm


# ----------------------------------------------------------------------------- by Cholesky's factor


@dataclass(frozen=True, eq=False)
class _Factored:
    """S = L L' by the inverse of its Cholesky factor, and the sum of its eigenvalues."""

    inverse: np.ndarray
    trace: float

    @lazy_property
    def least(self) -> float:
        """Lower bound on the smallest eigenvalue of S, by ``|S^-1| <= |L^-1|_1 |L^-1|_inf``: on
        contacts 2 to 4 times too small.
        """
        sizes = np.abs(self.inverse)
        return float(1 / (sizes.sum(axis=0).max() * sizes.sum(axis=1).max()))

    @property
    def rounding(self) -> float:
        """Relative error of an energy (Higham 2002, 10.1): the factor is that of ``S + D``, with
        ``|D| <= (n + 1) eps |L||L'|``, in norm no more than the trace of S; its inverse adds less.
        """
        size = len(self.inverse) + 1
        return 2 * size * EPS * self.trace / self.least

    def energies(self, right: np.ndarray) -> np.ndarray:
        """Energies ``b'S^-1 b`` of several b (k, c, n), increased by the possible rounding
        error.
        """
        halves = self.inverse @ right.reshape(len(right), -1).T
        return np.asarray(np.sum(halves**2, axis=0) * (1 + self.rounding))


def _factored(matrix: np.ndarray) -> _Factored | None:
    """S of a dense matrix, or None where Cholesky's factor does not exist."""
    from scipy.linalg import LinAlgError, cholesky
    from scipy.linalg.lapack import dtrtri

    symmetric = (matrix + matrix.T) / 2
    trace = float(np.trace(symmetric))
    try:
        factor = cholesky(symmetric, lower=True, overwrite_a=True, check_finite=False)
    except LinAlgError:
        return None
    return _Factored(dtrtri(factor, lower=1, overwrite_c=1)[0], trace)


# --------------------------------------------------------------------------- by conjugate gradients


def _preconditioned(
    inverse: RestrictedOperator, weight: np.ndarray, field: np.ndarray
) -> np.ndarray:
    """Product with the inverse symbol on the periodic box, weighted: less where softened."""
    return np.asarray(weight * inverse.apply(weight * field))


@dataclass(frozen=True, eq=False)
class _Iterated:
    """S by FFT, with a preconditioner Q: ``S >= relative Q^-1`` and ``S >= least``."""

    symmetric: RestrictedOperator
    inverse: Callable[[np.ndarray], np.ndarray]
    relative: float
    least: float

    def energies(self, right: np.ndarray) -> np.ndarray:
        """Upper bounds on ``b'S^-1 b`` of several b (k, c, n)."""
        bounds = np.zeros(len(right))
        slack = SLACK * self.relative
        for i in np.flatnonzero(right.any(axis=(1, 2))):
            run = _conjugate_gradients(
                self.symmetric, self.inverse, right[i], lambda weight, xb: weight <= slack * xb
            )
            if run is None:
                bounds[i] = np.inf
                continue
            solution, _ = run
            # x'b + x'r + r'S^-1 r with the residual r, and r'Q r for the last
            residual = right[i] - self.symmetric.apply(solution)
            remainder = np.sum(residual * self.inverse(residual)) / self.relative
            bounds[i] = np.sum(solution * (right[i] + residual)) + remainder
        return bounds


PositiveDefinite = _Factored | _Iterated
"""A symmetric part: `least` is a lower bound on its least eigenvalue, `energies` are upper bounds
on ``b'S^-1 b``."""


def _iterated(symmetric: RestrictedOperator) -> _Iterated | None:
    """S, where its symbol is positive, or conjugate gradients find no direction that is not of
    positive energy.

    Between some elements a periodic operator C becomes S, and C^-1 becomes Q. Where C is positive
    definite, so is S, and ``S >= Q^-1``. Else conjugate gradients begin with a random right-hand
    side b. With P(x) the polynomial of their residual r, P(0) = 1, and u a direction with ``Q S u =
    lambda u``, ``u'Q^-1 u = 1``: the weight ``r'Q r`` is ``(P(lambda) u'b)^2`` or more, and
    P(lambda) is 1 or more where lambda is not positive. So where the weight falls below t^2,
    ``|u'b| < t``; for a normally distributed b the chance of that is ``t (2 / (pi |u|^2))^(1/2)``
    at most, and ``|u|^-2`` is at most the largest value of the symbol, by the square of the least
    weight. The same holds with ``t / P(relative)`` for all lambda up to `relative`, below the least
    root of P.
    """
    # preconditioner Q, weighted where elements are softened
    inverse, least, largest, is_positive = _inverse_symbol(symmetric.grid_operator)
    ny, nx = inverse.shape
    own = float(np.mean(np.diagonal(inverse.table[:, :, ny - 1, nx - 1])))
    softening: np.ndarray | float = 0.0
    if symmetric.softening is not None:
        softening = symmetric.softening
    weight = np.asarray(1 / np.sqrt(1 + own * softening))
    between_elements = replace(symmetric, grid_operator=inverse, softening=None)
    preconditioner = partial(_preconditioned, between_elements, weight)
    largest /= float(weight.min() ** 2)
    if is_positive and type(symmetric.grid_operator) is GridOperator:
        return _Iterated(symmetric, preconditioner, 1.0, least)
    # conjugate gradients from a random right-hand side
    size = (inverse.table.shape[1], symmetric.elements.size)
    right = np.random.default_rng(SEED).normal(size=size)
    tol = MISSED_SHARE * MISSED * np.sqrt(np.pi / (2 * largest))
    run = _conjugate_gradients(
        symmetric, preconditioner, right, lambda weight, energy: weight <= tol**2
    )
    if run is None:
        return None
    # least eigenvalue of Q S: P falls to the share there, below its least root
    _, steps = run
    relative = 0.0
    high = 2.0
    for _ in range(50):
        middle = (relative + high) / 2
        if _residual(steps, middle) >= MISSED_SHARE:
            relative = middle
        else:
            high = middle
    return _Iterated(symmetric, preconditioner, relative, relative * least)


def _residual(steps: list[tuple[float, float]], x: float) -> float:
    """The polynomial P of the residual at x; zero from its least root on, where one before it
    changes its sign.
    """
    residual = direction = 1.0
    for alpha, beta in steps:
        residual -= alpha * x * direction
        if residual <= 0:
            return 0.0
        direction = residual + beta * direction
    return residual


def _conjugate_gradients(
    symmetric: RestrictedOperator,
    inverse: Callable[[np.ndarray], np.ndarray],
    right: np.ndarray,
    converged: Callable[[float, float], bool],
) -> tuple[np.ndarray, list[tuple[float, float]]] | None:
    """Solve ``S x = b`` until `converged` accepts the weight ``r'Q r`` of the residual and the
    energy ``x'b``.

    Also the steps (alpha, beta). None where a direction has no positive curvature, or there are too
    many steps.
    """
    most = int(np.clip(ELEMENT_STEPS / symmetric.elements.size, *ITERATIONS))
    x = np.zeros_like(right)
    residual = right.copy()
    energy = 0.0
    direction = inverse(residual)
    weight = float(np.sum(residual * direction))
    steps: list[tuple[float, float]] = []
    while not converged(weight, energy):
        image = symmetric.apply(direction)
        curvature = float(np.sum(direction * image))
        if not curvature > 0 or len(steps) == most:
            return None
        alpha = weight / curvature
        x += alpha * direction
        residual -= alpha * image
        energy += alpha * weight
        preconditioned = inverse(residual)
        last_weight = weight
        weight = float(np.sum(residual * preconditioned))
        steps.append((alpha, weight / last_weight))
        direction = preconditioned + weight / last_weight * direction
    return x, steps


def _inverse_symbol(symmetric: GridOperator) -> tuple[GridOperator, float, float, bool]:
    """The inverse of S's symbol on a periodic box of twice the grid; the least and the largest
    value of the symbol; true where no value was lifted.

    Values below ``1/(20 n)`` of the largest are lifted to it: 51 468 elements take 70-90 iterations
    to 1e-8, without lifting 1100-1300.
    """
    from scipy import fft

    ny, nx = symmetric.shape
    box = fft.next_fast_len(2 * ny, real=True), fft.next_fast_len(2 * nx, real=True)
    # symbol, and its eigenvalues at each wave number
    kernel = _periodic(_periodic(symmetric.table, 2, box[0]), 3, box[1])
    symbol = np.moveaxis(fft.rfft2(kernel), (0, 1), (-2, -1))
    values, vectors = np.linalg.eigh((symbol + np.conj(symbol.swapaxes(-1, -2))) / 2)
    largest = float(values.max())
    lifted = np.maximum(values, largest / (20 * max(nx, ny)))
    least = float(lifted.min())
    # inverse, as a table of the grid
    inverse = (vectors / lifted[..., None, :]) @ np.conj(vectors.swapaxes(-1, -2))
    inverse = np.moveaxis(inverse, (-2, -1), (0, 1))
    components = np.arange(symmetric.table.shape[0])
    rows = np.arange(1 - ny, ny) % box[0]
    columns = np.arange(1 - nx, nx) % box[1]
    table = fft.irfft2(inverse, box)[np.ix_(components, components, rows, columns)]
    return GridOperator(symmetric.shape, table), least, largest, least == float(values.min())


def _periodic(table: np.ndarray, axis: int, size: int) -> np.ndarray:
    """A table of influence numbers on a periodic box along an axis.

    Offsets beyond the table have the mean of its ends: no two elements are so far apart, and zeros
    would make the symbol negative.
    """
    n = (table.shape[axis] + 1) // 2
    offset = np.where(np.arange(size) < size / 2, np.arange(size), np.arange(size) - size)
    inside = np.abs(offset) < n
    end = np.where(offset < 0, 1 - n, n - 1)
    near = np.take(table, np.where(inside, offset, end) + n - 1, axis)
    far = np.take(table, np.where(inside, offset, -end) + n - 1, axis)
    return (near + far) / 2
