"""Rolling without slip on an ellipse, by polynomials: Kalker's linear theory to
as many digits as are wanted.

Source of the idea: J. J. Kalker, On the Rolling Contact of Two Elastic Bodies
in the Presence of Dry Friction, thesis, Delft 1967, after L. A. Galin: in an
ellipse, polynomials over a root carry polynomial displacements of the same
degree.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.checks import poisson_ratio, positive, whole
from varcontact.errors import SceneError
from varcontact.system.process import one_blas_thread

LEAST_RATIO = 1e-4
"""Ellipses more slender than this, either way, would need too fine a quadrature of the symbol."""


@one_blas_thread()
def no_slip_ellipse(a_over_b: float, nu: float, degree: int = 64) -> np.ndarray:
    """Forces and moment of an elliptic contact in steady rolling without slip, computed.

    Parameters
    ----------
    a_over_b : float
        Semi-axis along the rolling direction by that across it, in [1e-4, 1e4].
    nu : float
        Combined Poisson's ratio, in (-1, 0.5].
    degree : int
        Degree of the polynomials, 2 or more.

    Returns
    -------
    ndarray, shape (3, 3)
        C, with ``(Fx, Fy, Mz) = -C @ (vx, vy, spin)`` where G = 1 and ab = 1:
        ``C11`` at [0, 0], ``C22``, ``C23``, ``C32`` and ``C33`` in the lower
        block. Reciprocity demands ``C32 = -C23``; that is not built in, so
        their difference tells the error.

    Raises
    ------
    SceneError
        If a number is out of its range.

    Notes
    -----
    Let the ellipse be ``x = a cos t, y = b sin t`` within. Without slip ``u = (vx x - spin xy, vy x
    + spin x^2/2) + k(y)``, with a ``k`` that is free, and the traction vanishes at the leading
    edge, t in (-pi/2, pi/2). It may be singular at the trailing one.

    On the unit disk take ``Y_n^m / sqrt(1 - r^2)``, spherical harmonics with n
    - m even, seen from above. Their Fourier transform is a spherical Bessel
    function, and the elastic half-space multiplies it by
    ``h(s) (I - nu e e')/q``, with ``h = (cos^2 s/a^2 + sin^2 s/b^2)^(-1/2)``
    and ``e`` the direction of the physical wave. As ``int j_n j_k dq`` vanishes
    for n - k even, each degree n is by itself: a Hermitian block Toeplitz
    matrix with the Fourier coefficients of that symbol, of size 2 (n + 1). A
    displacement ``P_n(cos(t - c))``, Legendre's polynomial in the direction c,
    then has the traction with ``p sqrt(1 - r^2) = 2 G K_n(t, c)`` on the edge,
    where K_n is the Christoffel-Darboux kernel of the symbol. So the leading
    edge demands::

        sum_n K_n(t, pi/2) k_n = - the same of the rigid part (n = 1, 2)  for t in (-pi/2, pi/2),

    for the Legendre coefficients k_n of k(y); it is collocated at
    ``degree + 1`` points. One Cholesky factor has all the K_n. For a circle
    with nu = 0 they are ``sin((n + 1) t)/(2 pi sin t)``, and the equations
    those of a sine series. Forces and moment are the parts of degree 0 and 1.

    The error falls with the fourth power of the degree: 1e-6 at degree 64 for
    a/b in [0.1, 100], 2e-4 at a/b = 0.01.

    Examples
    --------
    A circle with nu = 0 has 32/(3 pi), 4/3 and 512/(135 pi).

    >>> C = no_slip_ellipse(1.0, 0.0)
    >>> print(f"{C[0, 0]:.5f} {C[1, 2]:.5f} {C[2, 2]:.5f}")
    3.39531 1.33333 1.20722
    """
    ratio, nu = check_ellipse(a_over_b, nu, LEAST_RATIO)
    return resultants(ratio, nu, whole("degree", degree, least=2))


def check_ellipse(a_over_b: float, nu: float, least: float) -> tuple[float, float]:
    """The ratio of semi-axes, between its least and the inverse of that, and Poisson's ratio."""
    ratio = positive("a_over_b", a_over_b)
    nu = poisson_ratio("nu", nu)
    if not least * (1 - 1e-12) <= ratio <= (1 + 1e-12) / least:
        raise SceneError("a_over_b", ratio, f"in [{least:g}, {1 / least:g}]")
    return ratio, nu


def resultants(ratio: float, nu: float, degree: int) -> np.ndarray:
    """The matrix of `no_slip_ellipse`, without checks of the numbers."""
    a = math.sqrt(ratio)
    b = 1 / math.sqrt(ratio)
    # kernels on the edge, from the directions of the axes and of the diagonals
    inside = np.pi * np.arange(1, degree + 2) / (degree + 2)
    edge = inside - np.pi / 2
    directions = [0.0, np.pi / 2, np.pi / 4, -np.pi / 4]
    kernel = EllipseKernel(a, b, nu, degree, np.array([*edge, *directions]))
    points = np.arange(edge.size)
    n = degree + 1
    ALONG, ACROSS, UP, DOWN = range(edge.size, edge.size + 4)
    # x = a P_1(along); x^2 = a^2 (1 + 2 P_2(along))/3, its constant goes to k; xy = ab (P_2(up) -
    # P_2(down))/3
    first = a * kernel(1, points, ALONG)
    second = a * a / 3 * kernel(2, points, ALONG)
    turned = a * b / 3 * (kernel(2, points, UP) - kernel(2, points, DOWN))
    rigid = np.stack([first[:, :, 0], first[:, :, 1], second[:, :, 1] - turned[:, :, 0]], axis=-1)
    # times sin t: the equations of a circle are then those of a sine series, and all are as well
    # conditioned
    weight = np.sin(inside)[:, None, None]
    matrix = kernel.of_all_degrees(points, ACROSS) * weight[..., None]
    right = -(rigid * weight).reshape(2 * n, 3)
    k = np.linalg.solve(matrix.reshape(2 * n, 2 * n), right).reshape(n, 2, 3)
    # force and moment are the parts of degree 0 and 1
    force = 4 * np.pi * kernel(0, points[:1], ACROSS)[0] @ k[0]
    ends = np.array([ALONG, ACROSS])
    by_edge = kernel(1, ends, ACROSS) @ k[1]
    by_edge[:, :, :2] += a * kernel(1, ends, ALONG)
    moment = 4 * np.pi / 3 * (a * by_edge[0, 1] - b * by_edge[1, 0])
    return -np.array([force[0], force[1], moment])


class EllipseKernel:
    """Christoffel-Darboux kernels K_n(t, c), 2 by 2, of the half-space's symbol, at some angles."""

    def __init__(self, a: float, b: float, nu: float, degree: int, angles: np.ndarray) -> None:
        from scipy.linalg import solve_triangular

        self.angles = angles
        n = degree + 1
        # Fourier coefficients (2, 2, d), int S(s) exp(2 i d s) ds of the symbol S over the circle,
        # d < 0 at the end, by the trapezoidal rule: exact to rounding, as the symbol is analytic as
        # far as min(a, b)/max(a, b)
        size = 2 ** math.ceil(math.log2(max(256, 4 * n, 40 * max(a / b, b / a))))
        s = np.pi * np.arange(size) / size
        h = 1 / np.hypot(np.cos(s) / a, np.sin(s) / b)
        ex = h * np.cos(s) / a
        ey = h * np.sin(s) / b
        symbol = h * np.array(
            [[1 - nu * ex * ex, -nu * ex * ey], [-nu * ex * ey, 1 - nu * ey * ey]]
        )
        moments = np.fft.ifft(symbol, axis=-1) * 2 * np.pi
        indices = np.arange(n)
        blocks = moments[:, :, indices[None, :] - indices[:, None]]
        toeplitz = blocks.transpose(2, 0, 3, 1).reshape(2 * n, 2 * n)
        waves = np.exp(-2j * np.outer(indices, angles))
        both = np.einsum("jt,pq->jptq", waves, np.eye(2)).reshape(2 * n, -1)
        factored = solve_triangular(np.linalg.cholesky(toeplitz), both, lower=True)
        # its sums of squares up to n are K_n
        self.factored = factored.reshape(n, 2, angles.size, 2)

    def __call__(self, n: int, points: np.ndarray, direction: int) -> np.ndarray:
        """K_n at points (t) from a direction, by their indices among the angles: shape (t, 2,
        2).
        """
        return self.of_all_degrees(points, direction, n + 1)[:, :, n]

    def of_all_degrees(
        self, points: np.ndarray, direction: int, degrees: int | None = None
    ) -> np.ndarray:
        """K_n for all n, shape (t, 2, n, 2)."""
        left = self.factored[:degrees, :, points]
        right = self.factored[:degrees, :, direction]
        sums = np.cumsum(np.einsum("jitp,jiq->jtpq", left.conj(), right), axis=0)
        apart = self.angles[points] - self.angles[direction]
        shifted = sums * np.exp(-1j * np.outer(np.arange(len(sums)), apart))[:, :, None, None]
        return shifted.real.transpose(1, 2, 0, 3)
