"""Conjugate gradients with the symmetric part of the shift operator, preconditioned on the periodic box."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from varcontact.elasticity.operators import GridOperator, RestrictedOperator


def symmetric_part(operator: GridOperator) -> GridOperator:
    """``(M + M')/2`` of a square grid operator: the transpose of a Toeplitz operator mirrors its table."""
    transposed = operator.table[:, :, ::-1, ::-1].swapaxes(0, 1)
    return GridOperator(operator.shape, (operator.table + transposed) / 2)


def solve_symmetric(
    operator: RestrictedOperator, right: np.ndarray, tol: float = 1e-5, max_iterations: int = 5000
) -> np.ndarray | None:
    """Solve ``S x = right`` for the symmetric part S of an operator, positive definite, by FFT products only.

    Parameters
    ----------
    operator : RestrictedOperator
        M on n elements, with c components.
    right : ndarray, shape (k, c, n)
        Right-hand sides, one after the other.
    tol : float
        Relative residual.
    max_iterations : int

    Returns
    -------
    ndarray, shape (k, c, n), or None
        None if S turns out not to be positive definite, or conjugate gradients do not get there.

    Notes
    -----
    The inverse symbol of S on the periodic box, its smallest eigenvalues lifted to ``1/(20 n)`` of the largest,
    is the preconditioner: 51 468 elements take 70-90 iterations to 1e-8 where none takes 1100-1300. Energies
    ``right'S^-1 right`` converge with the square of the residual.
    """
    symmetric = symmetric_part(operator.grid_operator)
    apply, precondition = symmetric.on(operator.elements).apply, _inverse_symbol(symmetric, operator.elements)
    solutions = np.empty_like(right)
    for i, b in enumerate(right):
        solution = _conjugate_gradients(apply, precondition, b, tol, max_iterations)
        if solution is None:
            return None
        solutions[i] = solution
    return solutions


def _conjugate_gradients(
    apply: Callable[[np.ndarray], np.ndarray],
    precondition: Callable[[np.ndarray], np.ndarray],
    right: np.ndarray,
    tol: float,
    max_iterations: int,
) -> np.ndarray | None:
    goal = tol * np.linalg.norm(right)
    x, residual = np.zeros_like(right), right.copy()
    if np.linalg.norm(residual) <= goal:
        return x
    direction = precondition(residual)
    weight = np.sum(residual * direction)
    for _ in range(max_iterations):
        image = apply(direction)
        curvature = np.sum(direction * image)
        if not curvature > 0:
            return None
        step = weight / curvature
        x += step * direction
        residual -= step * image
        if np.linalg.norm(residual) <= goal:
            return x
        preconditioned = precondition(residual)
        weight, old = np.sum(residual * preconditioned), weight
        direction = preconditioned + weight / old * direction
    return None


def _inverse_symbol(symmetric: GridOperator, elements: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Multiply by the inverse of S's symbol on a periodic box of twice the grid."""
    from scipy import fft

    (ny, nx), components = symmetric.shape, np.arange(symmetric.table.shape[0])
    box = fft.next_fast_len(2 * ny, real=True), fft.next_fast_len(2 * nx, real=True)
    kernel = np.zeros((components.size, components.size, *box))
    wrapped = np.ix_(components, components, np.arange(1 - ny, ny) % box[0], np.arange(1 - nx, nx) % box[1])
    kernel[wrapped] = symmetric.table
    symbol = np.moveaxis(fft.rfft2(kernel), (0, 1), (-2, -1))
    values, vectors = np.linalg.eigh((symbol + np.conj(symbol.swapaxes(-1, -2))) / 2)
    lifted = np.maximum(values, values.max() / (20 * max(nx, ny)))
    inverse = np.moveaxis((vectors / lifted[..., None, :]) @ np.conj(vectors.swapaxes(-1, -2)), (-2, -1), (0, 1))

    def precondition(field: np.ndarray) -> np.ndarray:
        grid = np.zeros((components.size, ny * nx))
        grid[:, elements] = field
        spectrum = np.einsum("ij...,j...->i...", inverse, fft.rfft2(grid.reshape(-1, ny, nx), box))
        return fft.irfft2(spectrum, box)[:, :ny, :nx].reshape(components.size, -1)[:, elements]

    return precondition
