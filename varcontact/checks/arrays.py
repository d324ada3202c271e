"""Checks of several numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from varcontact.checks.single import LARGE, SMALL
from varcontact.errors import SceneError

MOST_DIMENSIONS = 32
"""Of an array that NumPy broadcasts."""


def is_array(value: Any) -> bool:
    """Whether a value is meant as several numbers."""
    return isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim > 0)


def dimensions(value: Any) -> int | None:
    """How many dimensions an array has, or a list of numbers, or of lists; None where these are of several lengths."""
    try:
        return np.ndim(value)
    except ValueError:
        return None


def array(field: str, value: Any, ndim: int) -> np.ndarray:
    """A read-only copy of a finite array of floats with `ndim` dimensions."""
    allowed = f"a {ndim}-dimensional array of finite numbers"
    if is_array(value) and dimensions(value) is None:
        raise SceneError(field, value, f"{allowed}, with rows of equal length")
    result = _floats(field, value, allowed)
    if result.ndim != ndim or result.size == 0:
        raise wrong_shape(field, result.shape, allowed)
    _require_all(field, result, np.isfinite(result), "finite (no NaN, no inf)")
    _require_all(field, result, np.abs(result) <= LARGE, f"at most {LARGE:g} in size")
    result.flags.writeable = False
    return result


def numbers(field: str, value: Any, allowed: str = "finite numbers", most: float = LARGE) -> np.ndarray:
    """Finite real numbers of any shape (also a single one), as an array of floats."""
    result = _floats(field, value, allowed)
    sizes = np.abs(result)
    if not (sizes <= most).all():  # nor where there is NaN
        _require_all(field, result, np.isfinite(result), allowed)
        _require_all(field, result, sizes <= most, f"at most {most:g} in size")
    return result


def _require_all(field: str, values: np.ndarray, good: np.ndarray, allowed: str) -> None:
    """Refuse the first value that is not good, by its index where there are several."""
    if not good.all():
        where = tuple(int(i) for i in np.argwhere(~good)[0])
        raise SceneError(f"{field}{list(where)}" if where else field, float(values[where]), allowed)


def _floats(field: str, value: Any, allowed: str) -> np.ndarray:
    """A copy as floats, of whatever NumPy takes for real numbers."""
    try:
        given = np.asarray(value)
        if given.dtype.kind in "iuf" and not np.ma.is_masked(value):
            if given.ndim <= MOST_DIMENSIONS:
                return given.astype(float)
            allowed += f", in at most {MOST_DIMENSIONS} dimensions"
    except MemoryError:
        raise SceneError(field, value, "small enough for the memory") from None
    except Exception:  # an object's own code runs here, and may raise anything
        pass
    raise SceneError(field, value, allowed)


def poisson(value: Any, field: str = "nu") -> np.ndarray:
    """Poisson's ratios, in (-1, 0.5], of any shape."""
    allowed = "a Poisson's ratio in (-1, 0.5]"
    result = numbers(field, value, allowed)
    _require_all(field, result, (result > -1) & (result <= 0.5), allowed)
    return result


def positives(field: str, value: Any, allowed: str = "positive, finite numbers") -> np.ndarray:
    """Finite numbers above zero, of any shape."""
    result = numbers(field, value, allowed)
    if not np.all(result >= SMALL):
        _require_all(field, result, result > 0, allowed)
        _require_all(
            field, result, result >= SMALL, f"between {SMALL:g} and {LARGE:g}, the sizes that can be computed with"
        )
    return result


def broadcasting(arguments: dict[str, Any]) -> None:
    """Refuse arrays whose shapes do not broadcast."""
    shapes = {name: np.shape(value) for name, value in arguments.items() if not isinstance(value, float)}
    try:
        if shapes:
            np.broadcast_shapes(*shapes.values())
    except ValueError:
        words = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise SceneError("shapes", words, message=f"the shapes of the arguments do not broadcast: {words}") from None


def wrong_shape(field: str, shape: tuple[int, ...], allowed: str) -> SceneError:
    """The error for an array of another shape than is allowed."""
    message = f"{field} has shape {shape}; it must be {allowed}"
    return SceneError(field, f"array of shape {shape}", allowed, message=message)
