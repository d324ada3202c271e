"""Checks of single inputs: each returns the clean value or raises a SceneError that names the field."""

from __future__ import annotations

import difflib
import math
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from varcontact.errors import SceneError

SMALL, LARGE = 1e-100, 1e100
"""Lengths, moduli and forces between these keep their products within the range of floating point."""

TOO_LARGE = f"at most {LARGE:g} in size"
"""What is allowed of numbers of any sign, in words that complete "must be"."""

_NO_NUMBERS = (bool, str, bytes, bytearray, complex)
"""What `float` would take for a number, or drop a part of."""
_FLOAT = np.dtype(float)


def number(field: str, value: Any, allowed: str = "a finite number") -> float:
    """A finite real number.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object
    allowed : str
        What is allowed, in words that complete "must be".

    Raises
    ------
    SceneError
        If it is not one, NaN or infinite.
    """
    result = real(field, value, allowed)
    if not math.isfinite(result):
        raise SceneError(field, value, allowed)
    return result


def real(field: str, value: Any, allowed: str = "a number") -> float:
    """A real number, which may be infinite but not NaN.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object
    allowed : str
        What is allowed, in words that complete "must be".

    Raises
    ------
    SceneError
        If it is not one, or NaN.
    """
    if value is None or isinstance(value, _NO_NUMBERS) or getattr(value, "dtype", _FLOAT).kind not in "iuf":
        raise SceneError(field, value, allowed)
    try:
        result = float(value)
    except Exception:  # whatever an object makes of it
        raise SceneError(field, value, allowed) from None
    if math.isnan(result):
        raise SceneError(field, value, allowed)
    return result


def positive(field: str, value: Any, allowed: str = "a positive, finite number") -> float:
    """A finite number above zero, of a size that can be computed with.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object
    allowed : str
        What is allowed, in words that complete "must be".

    Raises
    ------
    SceneError
        If it is not one, or not `computable`.
    """
    result = number(field, value, allowed)
    if result <= 0:
        raise SceneError(field, value, allowed)
    return computable(field, result)


def computable(field: str, value: float) -> float:
    """A number whose products with others do not leave floating point.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : float

    Raises
    ------
    SceneError
        If it is below `SMALL` or above `LARGE`.
    """
    if not SMALL <= value <= LARGE:
        raise SceneError(field, value, f"between {SMALL:g} and {LARGE:g}, the sizes that can be computed with")
    return value


def moderate(field: str, value: Any, allowed: str = "a finite number") -> float:
    """A finite number of any sign, and of a size that can be computed with.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object
    allowed : str
        What is allowed, in words that complete "must be".

    Raises
    ------
    SceneError
        If it is not one, or beyond `LARGE` in size.
    """
    result = number(field, value, allowed)
    if abs(result) > LARGE:
        raise SceneError(field, result, TOO_LARGE)
    return result


def whole(field: str, value: Any, least: int = 1, most: int | None = None, why: str = "") -> int:
    """A whole number of at least `least`, and at most `most`.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object
    least, most : int
        None: there is no upper limit.
    why : str
        What goes on the message where there is an upper limit.

    Raises
    ------
    SceneError
        If it is not a whole number, too small or too large.
    """
    allowed = f"a whole number, {least} or more"
    result = number(field, value, allowed)
    if result != int(result) or result < least:
        raise SceneError(field, value, allowed)
    if most is not None and result > most:
        raise SceneError(field, value, f"a whole number from {least} to {most}{why}")
    return int(result)


def flag(field: str, value: Any) -> bool:
    """True or False; 0, 1 and words are refused.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object

    Raises
    ------
    SceneError
        If it is neither.
    """
    if not isinstance(value, (bool, np.bool_)):
        raise SceneError(field, value, "true or false")
    return bool(value)


def progress(value: Any) -> Callable[[str], None] | None:
    """The function that is called with the name of each stage, or None.

    Parameters
    ----------
    value : object

    Raises
    ------
    SceneError
        If it is neither.
    """
    if not (value is None or callable(value)):
        raise SceneError("progress", value, "None, or a function of one string")
    return value


def is_array(value: Any) -> bool:
    """Whether a value is meant as several numbers.

    Parameters
    ----------
    value : object
    """
    return isinstance(value, (list, tuple)) or (isinstance(value, np.ndarray) and value.ndim > 0)


def dimensions(value: Any) -> int | None:
    """How many dimensions an array has, or a list of numbers, or of lists; None where these are of several lengths.

    Parameters
    ----------
    value : object
    """
    try:
        return np.ndim(value)
    except ValueError:
        return None


def array(field: str, value: Any, ndim: int) -> np.ndarray:
    """A read-only copy of a finite array of floats with `ndim` dimensions.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : array_like
    ndim : int

    Returns
    -------
    ndarray
        Of floats, read-only.

    Raises
    ------
    SceneError
        If it is no array of numbers, has another number of dimensions, is empty, or has NaN, infinity or numbers
        beyond `LARGE`.
    """
    allowed = f"a {ndim}-dimensional array of finite numbers"
    if is_array(value) and dimensions(value) is None:
        raise SceneError(field, value, f"{allowed}, with rows of equal length")
    try:
        given = np.asarray(value)
        if given.dtype.kind not in "iuf" or np.ma.is_masked(value):
            raise SceneError(field, value, allowed)
        result = np.array(given, dtype=float)
    except SceneError:
        raise
    except MemoryError:
        raise SceneError(field, value, "small enough for the memory") from None
    except Exception:  # whatever an object makes of it
        raise SceneError(field, value, allowed) from None
    if result.ndim != ndim or result.size == 0:
        raise wrong_shape(field, result.shape, allowed)
    bad = ~np.isfinite(result)
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        raise SceneError(f"{field}{list(where)}", float(result[where]), "finite (no NaN, no inf)")
    bad = np.abs(result) > LARGE
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        raise SceneError(f"{field}{list(where)}", float(result[where]), TOO_LARGE)
    result.flags.writeable = False
    return result


def numbers(field: str, value: Any, allowed: str = "finite numbers") -> np.ndarray:
    """Finite real numbers of any shape (also a single one), as an array of floats.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : array_like
    allowed : str
        What is allowed, in words that complete "must be".

    Returns
    -------
    ndarray
        Of floats, in the shape given.

    Raises
    ------
    SceneError
        If it is no array of numbers, or has NaN, infinity or numbers beyond `LARGE`.
    """
    try:
        given = np.asarray(value)
    except Exception:  # whatever an object makes of it
        raise SceneError(field, value, allowed) from None
    if given.dtype.kind not in "iuf" or np.ma.is_masked(value):
        raise SceneError(field, value, allowed)
    try:
        result = given.astype(float)
    except MemoryError:
        raise SceneError(field, value, "small enough for the memory") from None
    bad = ~np.isfinite(result)
    if bad.any():
        raise SceneError(field, float(result[bad][0]), allowed)
    bad = np.abs(result) > LARGE
    if bad.any():
        raise SceneError(field, float(result[bad][0]), TOO_LARGE)
    return result


def numbers_within(field: str, value: Any, least: float, greatest: float) -> np.ndarray:
    """Finite numbers of any shape in [least, greatest].

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : array_like
    least, greatest : float
        In the unit of the values.

    Returns
    -------
    ndarray
        Of floats, in the shape given.

    Raises
    ------
    SceneError
        If one is not finite or lies outside.
    """
    allowed = f"in [{least:g}, {greatest:g}]"
    result = numbers(field, value, allowed)
    outside = (result < least) | (result > greatest)
    if outside.any():
        raise SceneError(field, float(result[outside][0]), allowed)
    return result


def positives(field: str, value: Any, allowed: str = "positive, finite numbers") -> np.ndarray:
    """Finite numbers above zero, of any shape.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : array_like
    allowed : str
        What is allowed, in words that complete "must be".

    Returns
    -------
    ndarray
        Of floats, in the shape given.

    Raises
    ------
    SceneError
        If one is not finite, not above zero, or of a size that cannot be computed with.
    """
    result = numbers(field, value, allowed)
    if (result <= 0).any():
        raise SceneError(field, float(result[result <= 0][0]), allowed)
    if (result < SMALL).any():
        computable(field, float(result[result < SMALL][0]))
    return result


def file_name(field: str, value: Any) -> Path:
    """The name of a file, as a path.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object

    Raises
    ------
    SceneError
        If it is neither a string nor a path.
    """
    name = os.fspath(value) if isinstance(value, os.PathLike) else value
    if not isinstance(name, str):
        raise SceneError(field, value, "the name of a file")
    return Path(name)


def elastic(value: Any) -> None:
    """Refuse what does not have the combined constants of two bodies.

    Parameters
    ----------
    value : object

    Raises
    ------
    SceneError
        If it does not.
    """
    if not (hasattr(value, "combined_G") and hasattr(value, "combined_nu")):
        raise SceneError("bodies", value, "Bodies")


def exactly_one(**arguments: Any) -> None:
    """Refuse two arguments, by name, of which not exactly one is given: both are None, or neither is.

    Parameters
    ----------
    **arguments
        Two arguments by name; None stands for one that is not given.

    Raises
    ------
    SceneError
        If both are given, or neither is.
    """
    names = list(arguments)
    given = [name for name, value in arguments.items() if value is not None]
    if len(given) == 1:
        return
    if given:
        message = f"{' and '.join(names)} are both given: give one of them"
    else:
        message = f"neither {' nor '.join(names)} is given: give one of them"
    raise SceneError(", ".join(names), tuple(arguments.values()), "exactly one of the two", message=message)


def wrong_shape(field: str, shape: tuple[int, ...], allowed: str) -> SceneError:
    """The error for an array of another shape than is allowed.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    shape : tuple of int
        That of the array given.
    allowed : str
        What is allowed, in words that complete "must be".

    Returns
    -------
    SceneError
        To be raised.
    """
    message = f"{field} has shape {shape}; it must be {allowed}"
    return SceneError(field, f"array of shape {shape}", allowed, message=message)


def choice(field: str, value: Any, options: Iterable[str]) -> str:
    """One of the named options; the error suggests the nearest.

    Parameters
    ----------
    field : str
        Name of the entry, for the message.
    value : object
    options : iterable of str

    Raises
    ------
    SceneError
        If the value is not one of the options.
    """
    names = list(options)
    if isinstance(value, str) and value in names:
        return value
    raise SceneError(field, value, f"one of {', '.join(names)}{nearest(value, names)}")


def nearest(value: Any, names: Iterable[str]) -> str:
    """`` (did you mean ...?)``, or nothing where no name is near.

    Parameters
    ----------
    value : object
        The name that was given.
    names : iterable of str
        Those that exist.

    Returns
    -------
    str
        To be added to a message.
    """
    known = list(names)
    if not isinstance(value, str):
        return ""
    other_case = [name for name in known if name.lower() == value.lower()]
    close = other_case or difflib.get_close_matches(value, known, n=1, cutoff=0.5)
    return f" (did you mean {close[0]}?)" if close else ""
