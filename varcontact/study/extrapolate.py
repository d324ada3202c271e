"""Extrapolation to zero element size: observed order and limit, each with its uncertainty, from
noisy values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

ORDERS = np.linspace(0.5, 3.0, 101)
"""The orders considered; piecewise-constant tractions give 1, and 2 for smooth fields."""
PRIOR = np.exp(-(((ORDERS - 1.5) / 0.4) ** 2) / 2)
"""Their weights before anything is measured."""
USUAL_NOISE = 1.5
"""Order of the noise of a staircase edge where it cannot be measured: half an order more than the
error's 1."""
CONFIDENCE = 0.95
HIDDEN = "the noise hides the order"
SAME_BUT_STAIRCASE = "the same on all grids, apart from the staircase edge"
SAME = "the same on all grids"


TERMS: tuple[tuple[float, ...], ...] = (
    *((1.0,), (1.5,), (2.0,)),
    *((1.0, 1.5), (1.0, 2.0), (1.0, 3.0), (1.5, 2.0), (1.5, 2.5), (2.0, 3.0)),
    *((1.0, 1.5, 2.0), (1.0, 2.0, 3.0)),
)
"""Orders of the terms of long series."""
LEAST_FREEDOM = 4
"""Least degrees of freedom left for a fit of known parts of the noise."""


@dataclass(frozen=True)
class Limit:
    """Limit of values on a sequence of grids.

    Attributes
    ----------
    value, error : float
        Extrapolated value, and half the width of its 95 % interval; infinite
        where nothing tells how wrong it is.
    order, order_low, order_high : float
        Best order, and the ends of its 95 % interval, within [1/2, 3].
    reason : str
        Why there is no order or no error; empty where there are both.
    """

    value: float = np.nan
    error: float = np.nan
    order: float = np.nan
    order_low: float = np.nan
    order_high: float = np.nan
    reason: str = ""


def extrapolate(
    h: np.ndarray, values: np.ndarray, staircase: np.ndarray | None = None, scale: float = 0.0
) -> Limit:
    """Fit ``Q + C h^p + noise`` to values, several of which may belong to one
    h, and average over the order p.

    Parameters
    ----------
    h : ndarray, shape (n,)
        Sizes of the elements, in any unit.
    values : ndarray, shape (n,)
    staircase : ndarray, shape (n, m), optional
        Known quantities of mean zero that the noise may be proportional to.
        Left out where fewer than four degrees of freedom would remain.
    scale : float
        Size of values of this kind: differences below 1e-12 of it are rounding.

    Returns
    -------
    Limit

    Notes
    -----
    The noise is ``staircase @ b`` with unknown b, and a random part of the standard deviation ``s
    h^q``. Its order q is the slope of the spreads of values with the same h (1.5 where there are
    none). For each p in [1/2, 3] weighted least squares give Q(p), its variance v(p) s^2 and a sum
    of squares R(p). With s^2 the mean square about the best fit, or that of the lack of fit of the
    means where it is larger, p has the weight ``exp(-((p - 1.5)/0.4)^2/2) (1 + (R(p) - R_min)/(d
    s^2))^(-(d+1)/2)``, with d degrees of freedom. The value is the mean of Q(p) by these weights,
    its variance the mean of v s^2 and, on top, of the spread of Q(p). The error is Student's t for
    d degrees of freedom times the standard deviation. The interval of p holds those with ``R(p) -
    R_min <= s^2 t^2``.

    Examples
    --------
    >>> h = np.array([1/8, 1/12, 1/16, 1/24])
    >>> limit = extrapolate(h, 2 + 3 * h**1.5)
    >>> print(f"{limit.value:.6f} {limit.order:.3f}")
    2.000000 1.500
    """
    from scipy.special import stdtrit

    sizes, group = np.unique(h / h.max(), return_inverse=True)
    if sizes.size < 3:
        return Limit(reason=f"no order: {sizes.size} grids, at least three are needed")
    if np.ptp(values) <= 1e-12 * max(float(np.abs(values).max()), scale):
        return Limit(float(values.mean()), float(np.ptp(values)), reason=SAME)
    if staircase is None or h.size - 3 - staircase.shape[1] < LEAST_FREEDOM:
        staircase = np.empty((h.size, 0))
    freedom = h.size - 3 - staircase.shape[1]
    h = sizes[group]
    weights = h ** -_noise_order(sizes, group, values, staircase)
    columns = np.column_stack([np.ones_like(h), staircase])
    limits, variances, left = _fitted(weights, columns, h, values)
    squares = np.sum(left**2, axis=0)
    best = int(np.argmin(squares))
    if freedom < 1:
        reason = "no error: no more values than unknowns; use more grids or offsets"
        return Limit(float(limits[best]), np.inf, float(ORDERS[best]), reason=reason)
    if np.abs(left[:, best] / weights).max() <= 1e-12 * max(float(np.abs(values).max()), scale):
        return _without_noise(float(limits[best]), float(ORDERS[best]), values, staircase)
    lack_of_fit = _lack_of_fit(group, left[:, best])
    square = max(squares[best] / freedom, lack_of_fit, np.finfo(float).tiny)
    # weights of the orders
    excess = (squares - squares[best]) / square
    likelihood = PRIOR * (1 + excess / freedom) ** (-(freedom + 1) / 2)
    likelihood /= likelihood.sum()
    value = float(likelihood @ limits)
    variance = float(likelihood @ (variances * square + (limits - value) ** 2))
    factor = float(stdtrit(freedom, (1 + CONFIDENCE) / 2))
    possible = ORDERS[excess <= factor**2]
    return Limit(
        value=value,
        error=factor * variance**0.5,
        order=float(ORDERS[best]),
        order_low=float(possible.min()),
        order_high=float(possible.max()),
        reason=HIDDEN if possible.size == ORDERS.size else "",
    )


def _without_noise(value: float, order: float, values: np.ndarray, staircase: np.ndarray) -> Limit:
    """The limit of values that one order, or the staircase edge alone, explains to rounding."""
    rounding = 1e-12 * float(np.abs(values).max())
    if staircase.shape[1]:
        explained = staircase @ np.linalg.lstsq(staircase, values - value)[0]
        if np.abs(values - value - explained).max() <= rounding:
            return Limit(value, rounding, reason=SAME_BUT_STAIRCASE)
    return Limit(value, rounding, order, order, order)


def _lack_of_fit(group: np.ndarray, left: np.ndarray) -> float:
    """Mean square of the remainders' means of each h: noise alone gives its own size."""
    count = np.bincount(group)
    if count.size <= 3:
        return 0.0
    return float(np.sum(np.bincount(group, left) ** 2 / count) / (count.size - 3))


def extrapolate_series(h: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Fit several terms in h to the values of a long series of grids, and
    average over which terms these are.

    Where many fine grids are known, one power of h is too few: what the others
    leave is larger than the noise.

    Parameters
    ----------
    h : ndarray, shape (n,)
        Sizes of the elements, in any unit; at least ten, some of them the same.
    values : ndarray, shape (n,)

    Returns
    -------
    value, error : float
        Extrapolated value, and half the width of its 95 % interval.

    Notes
    -----
    Each choice of powers in `TERMS` is a weighted least-squares fit with the noise ``s h^1.5``,
    which has a limit and its standard error. Choices are weighted by Schwarz's criterion,
    ``exp(-BIC/2)``; the value is the mean of the limits, its variance the mean of the squared
    standard errors and, on top, of the spread of the limits.

    Examples
    --------
    >>> h = 1 / np.array([16, 24, 32, 40, 48, 56, 64, 80, 96, 128])
    >>> noise = 0.01 * h**1.5 * np.cos(9 / h)
    >>> value, error = extrapolate_series(h, 2 - 0.3 * h + 0.5 * h**2 + noise)
    >>> bool(abs(value - 2) < error < 1e-3)
    True
    """
    from scipy.special import stdtrit

    if np.ptp(values) <= 1e-12 * np.abs(values).max():
        return float(values.mean()), float(np.ptp(values))
    h = h / h.max()
    count = h.size
    weights = h**-USUAL_NOISE
    # the limit by each choice of terms
    fits = []
    for terms in TERMS:
        if count - len(terms) < 3:
            continue
        columns = np.column_stack([np.ones_like(h), *(h**power for power in terms)])
        columns = columns * weights[:, None]
        solution, *_ = np.linalg.lstsq(columns, values * weights, rcond=None)
        square = float(np.sum((columns @ solution - values * weights) ** 2))
        size = columns.shape[1]
        variance = square / (count - size) * np.linalg.inv(columns.T @ columns)[0, 0]
        fits.append((solution[0], variance**0.5, square, size))
    limits, errors, squares, unknowns = np.array(fits).T
    # their mean by Schwarz's criterion
    criterion = count * np.log(np.maximum(squares, np.finfo(float).tiny)) + unknowns * np.log(count)
    likelihood = np.exp(-(criterion - criterion.min()) / 2)
    likelihood /= likelihood.sum()
    value = float(likelihood @ limits)
    variance = float(likelihood @ (errors**2 + (limits - value) ** 2))
    freedom = count - unknowns[int(np.argmax(likelihood))]
    return value, float(stdtrit(freedom, (1 + CONFIDENCE) / 2)) * variance**0.5


def _noise_order(
    sizes: np.ndarray, group: np.ndarray, values: np.ndarray, staircase: np.ndarray
) -> float:
    """Slope of the spread of values with the same h, without what the staircase explains."""
    columns = np.column_stack([values, staircase])
    count = np.bincount(group)
    means = np.array([np.bincount(group, column) / count for column in columns.T]).T
    columns = (columns - means[group]) / sizes[group, None] ** USUAL_NOISE
    edge = columns[:, 1:]
    left = columns[:, 0] - edge @ np.linalg.lstsq(edge, columns[:, 0], rcond=None)[0]
    spreads = np.sqrt(np.bincount(group, left**2) / count) * sizes**USUAL_NOISE
    noisy = spreads > 1e-13 * np.abs(values).max()
    if noisy.sum() < 3:
        return USUAL_NOISE
    slope = np.polyfit(np.log(sizes[noisy]), np.log(spreads[noisy]), 1)[0]
    return float(np.clip(slope, 1.0, 3.0))


def _fitted(
    weights: np.ndarray, columns: np.ndarray, h: np.ndarray, values: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Straight fits by the columns and h^p for all p: limits, their variances by the noise's,
    weighted remainders.

    What h^p has that the columns (the first is one, for the limit) have not gives its coefficient;
    they take the rest.
    """
    common = weights[:, None] * columns
    target = weights * values
    inverse = np.linalg.pinv(common)  # columns may be zero, as by symmetry
    powers = weights[:, None] * h[:, None] ** ORDERS
    own = powers - common @ (inverse @ powers)
    size = np.sum(own**2, axis=0)
    slopes = own.T @ target / size
    limits = inverse[0] @ (target[:, None] - powers * slopes)
    variances = inverse[0] @ inverse[0] + (inverse[0] @ powers) ** 2 / size
    return limits, variances, (target - common @ (inverse @ target))[:, None] - own * slopes
