"""A root between two places."""

from __future__ import annotations

from collections.abc import Callable


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function is zero, to rounding: false position with the steps of Anderson and Bjoerck (1973).

    It does what SciPy's `brentq` does, which comes with all of `scipy.optimize`: to import that takes longer than to
    solve many scenes, and every process that makes a Hertzian contact of two radii would.

    Parameters
    ----------
    function : callable
        Continuous, and of different signs at the two ends.
    low, high : float

    Examples
    --------
    >>> print(f"{root_between(lambda x: x * x - 2, 0.0, 2.0):.15f}")
    1.414213562373095
    """
    at_low, at_high, root = function(low), function(high), high
    for _ in range(200):
        root = high - at_high * (high - low) / (at_high - at_low)
        if not min(low, high) < root < max(low, high):
            break
        there = function(root)
        if there == 0:
            break
        if (there < 0) != (at_high < 0):
            low, at_low = high, at_high
        elif abs(there) < abs(at_high):
            at_low *= 1 - there / at_high
        else:
            at_low /= 2
        high, at_high = root, there
    return root
