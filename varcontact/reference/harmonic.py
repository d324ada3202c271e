"""Creepages that swing, without slip: complex creepage coefficients of an
ellipse and of line contact.

After A. Gross-Thebing, Frequency-dependent creep coefficients for
three-dimensional rolling contact problems, Vehicle System Dynamics 18 (1989)
359-374. With creepages ``v exp(i omega t)`` and rolling velocity V all fields
swing with ``exp(i omega t)``; without slip ``v - du/dx + i kappa u = 0``, kappa
= omega/V.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.reference.no_slip_ellipse import EllipseKernel, check_ellipse, no_slip_ellipse
from varcontact.system.process import one_blas_thread

DEGREE = 80
"""Degree of the polynomials: six digits for a/b in [0.2, 10] and kappa a up to `KAPPA_MAX`."""
MODES = 20
"""Fourier's modes, for the same digits."""
PERIOD = 1.6
"""Period of Fourier's extension of k(y), divided by the width of the contact."""
KAPPA_MAX = 20.0
"""Largest kappa a: beyond it degree and modes resolve the waves no longer."""
KAPPA_LINEAR = 1e-4
"""Kappa a below which coefficients are linear in it: the formulas divide by its square."""
RATIO_MIN = 0.1
"""Ellipses more slender than this, either way, would need more degrees and modes."""


@one_blas_thread()
def harmonic_coefficients(a_over_b: float, nu: float, kappa_a: float) -> np.ndarray:
    """Complex creepage coefficients of an elliptic contact without slip, at a frequency.

    Parameters
    ----------
    a_over_b : float
        Semi-axis along the rolling direction by that across it, in [0.1, 10].
    nu : float
        Combined Poisson's ratio, in (-1, 0.5].
    kappa_a : float
        ``omega a/V``, angular frequency by the time in which half the contact
        is rolled, in [0, 20].

    Returns
    -------
    ndarray of complex, shape (3, 3)
        C, with ``(Fx, Fy, Mz) = -C @ (vx, vy, spin)`` where G = 1 and ab = 1,
        all times ``exp(i omega t)``: C11 at [0, 0], C22, C23, C32 and C33 in
        the lower block. ``Im C11 < 0``: the force lags behind the creepage. C32
        = -C23 at every frequency; that is not built in, so their difference
        tells the error.

    Raises
    ------
    SceneError
        If a number is out of its range.

    Notes
    -----
    As `no_slip_ellipse`, but ``u = (particular) + exp(i kappa x) k(y)`` with Fourier's series of
    k(y) on 1.6 times the width, and the Legendre series of plane waves. The traction vanishes at
    the leading edge by least squares.

    Examples
    --------
    >>> C = harmonic_coefficients(1.0, 0.28, 0.5)
    >>> print(f"{C[0, 0]:.4f} {C[1, 2]:.4f}")
    2.7667-2.1160j 0.8986-0.9205j
    """
    from scipy.special import spherical_jn

    ratio, nu = check_ellipse(a_over_b, nu, RATIO_MIN)
    allowed = f"in [0, {KAPPA_MAX:g}]"
    frequency = checks.number("kappa_a", kappa_a, allowed)
    if not 0 <= frequency <= KAPPA_MAX:
        raise SceneError("kappa_a", frequency, allowed)
    if frequency < KAPPA_LINEAR:
        steady = no_slip_ellipse(ratio, nu).astype(complex)
        slow = steady if frequency == 0 else harmonic_coefficients(ratio, nu, KAPPA_LINEAR)
        return steady + frequency / KAPPA_LINEAR * (slow - steady)
    # kernels on the edge, from the waves of Fourier's series
    a = math.sqrt(ratio)
    b = 1 / math.sqrt(ratio)
    kappa = frequency / a
    edge = np.pi * np.arange(1, 2 * MODES + 24) / (2 * MODES + 24) - np.pi / 2
    eta = np.pi * np.arange(-MODES, MODES + 1) / (PERIOD * b)
    radius = np.hypot(frequency, eta * b)
    angle = np.arctan2(eta * b, frequency)
    kernel = EllipseKernel(a, b, nu, DEGREE, np.array([*edge, 0.0, np.pi / 2, *angle]))
    points = np.arange(edge.size)
    n = np.arange(DEGREE + 1)
    weight = np.cos(edge)
    ALONG = edge.size
    ACROSS = edge.size + 1
    first = edge.size + 2
    # exp(i (kappa x + eta y)) = sum over n of (2n + 1) i^n j_n(radius) P_n(cos(t - angle))
    waves = (2 * n + 1) * 1j**n * spherical_jn(n, radius[:, None])
    along = (2 * n + 1) * 1j**n * spherical_jn(n, frequency)
    by_wave = []
    for m, wave in enumerate(waves):
        by_wave.append(np.einsum("tinj,n->tij", kernel.of_all_degrees(points, first + m), wave))
    matrix = np.stack(by_wave, axis=2)
    # u by vx is (i/kappa) (1 - exp(i kappa x)); by spin (-i y/kappa, i x/kappa + (1 - exp(i kappa
    # x))/kappa^2)
    wave_along = np.einsum("tinj,n->tij", kernel.of_all_degrees(points, ALONG), along)
    lift = kernel(0, points, ALONG) - wave_along
    moment_arm = a * kernel(1, points, ALONG)[:, :, 1] - b * kernel(1, points, ACROSS)[:, :, 0]
    turn = 1j / kappa * moment_arm
    by_spin = (turn + lift[:, :, 1] / kappa**2)[..., None]
    rigid = np.concatenate([1j / kappa * lift, by_spin], axis=-1)
    # no singular traction at the leading edge, by least squares
    equations = (matrix * weight[:, None, None, None]).reshape(2 * edge.size, -1)
    right = -(rigid * weight[:, None, None]).reshape(2 * edge.size, 3)
    k, *_ = np.linalg.lstsq(equations, right, rcond=1e-13)
    k = k.reshape(eta.size, 2, 3)
    # force and moment are the parts of degree 0 and 1; columns of `constant` are vx, vy and spin
    constant = np.array([[1j / kappa, 0, 0], [0, 1j / kappa, 1 / kappa**2]])
    mean = np.tensordot(waves[:, 0], k, 1) + (1 - along[0]) * constant
    force = 4 * np.pi * kernel(0, points[:1], ALONG)[0] @ mean
    ends = np.array([ALONG, ACROSS])
    by_edge = sum(wave * kernel(1, ends, first + m) @ k[m] for m, wave in enumerate(waves[:, 1]))
    by_edge = by_edge - along[1] * kernel(1, ends, ALONG) @ constant
    moment_arm = a * kernel(1, ends, ALONG)[:, :, 1] - b * kernel(1, ends, ACROSS)[:, :, 0]
    by_edge[:, :, 2] += 1j / kappa * moment_arm
    moment = 4 * np.pi / 3 * (a * by_edge[0, 1] - b * by_edge[1, 0])
    return -np.array([force[0], force[1], moment])


def harmonic_line(kappa_a: float, nu: float, depth_over_a: float) -> complex:
    """Complex creepage coefficient of line contact without slip, at a frequency.

    Parameters
    ----------
    kappa_a : float
        ``omega a/V``, at least 0.
    nu : float
        Combined Poisson's ratio, in (-1, 0.5].
    depth_over_a : float
        Depth from which displacements count, by the half length of the contact,
        at least 2.

    Returns
    -------
    complex
        c, with ``Fx = -c G a vx`` by length. At zero frequency it is
        ``pi/(2 (1 - nu))``, whatever the depth.

    Raises
    ------
    SceneError
        If a number is out of its range.

    Notes
    -----
    ``(pi/m) (J0 + i J1)/(J0 + i kappa a ln(2 d/a) (J0 + i J1))`` with Bessel's functions at kappa
    a, m = 2 (1 - nu): ``int q(x') ln|x - x'|`` over the strip is what ``v (1 - exp(i kappa x))/(i
    kappa)`` and a constant times ``exp(i kappa x)`` ask for, with no traction at the leading edge.

    Examples
    --------
    >>> print(f"{harmonic_line(0.5, 0.3, 4.0):.6f}")
    1.388397-1.181329j
    """
    from scipy.special import j0, j1

    kappa = checks.at_least_zero("kappa_a", kappa_a, "a frequency of 0 or more")
    nu = checks.poisson_ratio("nu", nu)
    depth = checks.positive("depth_over_a", depth_over_a)
    if depth < 2:
        allowed = "at least 2: the depth is beyond the length of the contact"
        raise SceneError("depth_over_a", depth, allowed)
    both = complex(j0(kappa), j1(kappa))
    return math.pi / (2 * (1 - nu)) * both / (j0(kappa) + 1j * kappa * math.log(2 * depth) * both)
