"""Checks of single numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from varcontact.errors import SceneError

SMALL, LARGE = 1e-100, 1e100
"""Lengths, moduli and forces between these keep their products within the range of floating point."""

_NO_NUMBERS = (bool, str, bytes, bytearray, complex)
"""What `float` would take for a number, or drop a part of."""
_FLOAT = np.dtype(float)


def number(field: str, value: Any, allowed: str = "a finite number") -> float:
    """A finite real number."""
    result = real(field, value, allowed)
    if not math.isfinite(result):
        raise SceneError(field, value, allowed)
    return result


def real(field: str, value: Any, allowed: str = "a number") -> float:
    """A real number, which may be infinite but not NaN."""
    if value is None or isinstance(value, _NO_NUMBERS) or getattr(value, "dtype", _FLOAT).kind not in "iuf":
        raise SceneError(field, value, allowed)
    try:
        result = float(value)
    except Exception:  # an object's own code runs here, and may raise anything
        raise SceneError(field, value, allowed) from None
    if math.isnan(result):
        raise SceneError(field, value, allowed)
    return result


def positive(field: str, value: Any, allowed: str = "a positive, finite number") -> float:
    """A finite number above zero, of a size that can be computed with."""
    if type(value) is float and SMALL <= value <= LARGE:  # nearly always; single calls of fast theories wait for it
        return value
    result = number(field, value, allowed)
    if result <= 0:
        raise SceneError(field, value, allowed)
    return computable(field, result)


def computable(field: str, value: float) -> float:
    """A number whose products with others do not leave floating point."""
    if not SMALL <= value <= LARGE:
        raise SceneError(field, value, f"between {SMALL:g} and {LARGE:g}, the sizes that can be computed with")
    return value


def moderate(field: str, value: Any, allowed: str = "a finite number", most: float = LARGE) -> float:
    """A finite number of any sign, and of a size that can be computed with."""
    result = number(field, value, allowed)
    if abs(result) > most:
        raise SceneError(field, result, f"at most {most:g} in size")
    return result


def whole(field: str, value: Any, least: int = 1, most: int | None = None, why: str = "") -> int:
    """A whole number of at least `least`, and at most `most`."""
    allowed = f"a whole number, {least} or more"
    result = number(field, value, allowed)
    if result != int(result) or result < least:
        raise SceneError(field, value, allowed)
    if most is not None and result > most:
        raise SceneError(field, value, f"a whole number from {least} to {most}{why}")
    return int(result)


def wholes(field: str, value: Any, least: int = 1, most: int | None = None) -> list[int]:
    """Several whole numbers of at least `least`, and at most `most`."""
    allowed = "a list of whole numbers"
    if isinstance(value, str | bytes | bytearray):
        raise SceneError(field, value, allowed)
    try:
        given = list(value)
    except TypeError:
        raise SceneError(field, value, allowed) from None
    return [whole(f"{field}[{i}]", n, least, most) for i, n in enumerate(given)]
