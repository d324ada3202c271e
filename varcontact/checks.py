"""Checks of inputs: each returns the clean value or raises a SceneError that names the field."""

from __future__ import annotations

import contextlib
import dataclasses
import difflib
import functools
import inspect
import math
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar, ParamSpec, Self, TypeVar

import numpy as np

from varcontact.errors import SceneError, shortened
from varcontact.system.progress import shown_progress

SMALL = 1e-100
LARGE = 1e100
"""Range `SMALL` to `LARGE` of lengths, moduli and forces: their products stay in the range of
floating point."""

_NO_NUMBERS = (bool, str, bytes, bytearray, complex)
"""Types that are refused as numbers although `float` converts them, complex numbers of NumPy
without their imaginary part."""
_FLOAT = np.dtype(float)
P = ParamSpec("P")
R = TypeVar("R")
ForwardedNames = Callable[[Mapping[str, Any]], Iterable[str]]
"""Names of the options that a function forwards, as a function of all options given."""
POISSON = "a Poisson's ratio in (-1, 0.5]"
REFINE_BECAME = "accuracy, without a grid"
"""Replacement for ``refine``, an argument of `solve` up to November 2026."""


def gone(field: str, value: Any, instead: str) -> None:
    """Refuse an argument of an earlier version, if it is given."""
    if value is not None:
        raise SceneError(field, value, f"left out: this version has {instead} in its place")


def real(field: str, value: Any, allowed: str = "a number") -> float:
    """Real number, which may be infinite but not NaN."""
    result = math.nan
    if not isinstance(value, _NO_NUMBERS) and getattr(value, "dtype", _FLOAT).kind in "iuf":
        # an object's own code runs here, and may raise anything
        with contextlib.suppress(Exception):
            result = float(value)
    if math.isnan(result):
        raise SceneError(field, value, allowed)
    return result


def number(field: str, value: Any, allowed: str = "a finite number", most: float = LARGE) -> float:
    """Finite number of any sign, with a size that is safe to compute with."""
    if type(value) is float and -most <= value <= most:  # the usual case
        return value
    result = real(field, value, allowed)
    if math.isinf(result):
        raise SceneError(field, value, allowed)
    if abs(result) > most:
        raise SceneError(field, result, f"at most {most:g} in size")
    return result


def positive(field: str, value: Any) -> float:
    """Finite number above zero, with a size that is safe to compute with."""
    # the usual case; single calls of fast theories depend on it
    if type(value) is float and SMALL <= value <= LARGE:
        return value
    allowed = "a positive, finite number"
    result = number(field, value, allowed)
    if result <= 0:
        raise SceneError(field, value, allowed)
    if result < SMALL:
        raise SceneError(field, value, f"at least {SMALL:g}")
    return result


def positive_or_infinite(field: str, value: Any) -> float:
    """A number above zero, which may be infinite."""
    result = real(field, value, "a positive number, or inf")
    if result == math.inf:
        return result
    return positive(field, result)


def at_least_zero(
    field: str, value: Any, allowed: str = "a finite number, zero or positive"
) -> float:
    """Finite number that is not negative, with a size that is safe to compute with."""
    result = number(field, value, allowed)
    if result < 0:
        raise SceneError(field, value, allowed)
    if result == 0:
        return result
    return positive(field, result)


def poisson_ratio(field: str, value: Any) -> float:
    """One Poisson's ratio, in (-1, 0.5]."""
    return float(poisson(number(field, value, POISSON), field))


def whole(field: str, value: Any, least: int = 1, most: int | None = None, why: str = "") -> int:
    """A whole number of at least `least`, and at most `most`."""
    if type(value) is int and most is None and least <= value <= LARGE:  # the usual case
        return value
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
    if isinstance(value, str | bytes | bytearray) or not np.iterable(value):
        raise SceneError(field, value, allowed)
    return [whole(f"{field}[{i}]", n, least, most) for i, n in enumerate(value)]


def is_array(value: Any) -> bool:
    """True for a value that is meant as several numbers: a list, an array, a table of pandas."""
    if isinstance(value, (list, tuple)):
        return True
    ndim = getattr(value, "ndim", 0)
    return isinstance(ndim, int) and ndim > 0


def array(
    field: str, value: Any, *ndim: int, shape: tuple[int, ...] | None = None, meant: str = ""
) -> np.ndarray:
    """A read-only copy of a finite array of floats with one of the numbers `ndim` of dimensions, or
    of a `shape`.
    """
    ndim = (len(shape),) if shape else ndim
    allowed = f"a {' or '.join(map(str, ndim))}-dimensional array of finite numbers"
    result = numbers(field, value, allowed)
    if result.ndim not in ndim or result.size == 0 or (shape and result.shape != shape):
        if shape:
            allowed = f"of shape {shape}"
        raise wrong_shape(field, result.shape, meant or allowed)
    result.flags.writeable = False
    return result


def coordinates(field: str, value: Any, size: int, of: str) -> np.ndarray:
    """Ascending coordinates, shape (size,), of the rows or columns `of` something."""
    points = array(field, value, 1)
    if points.size != size or size < 2 or np.any(np.diff(points) <= 0):
        raise SceneError(
            field, points, f"{size} ascending coordinates, one for each {of} (at least 2)"
        )
    return points


def numbers(
    field: str, value: Any, allowed: str = "finite numbers", most: float = LARGE
) -> np.ndarray:
    """A copy as floats, of finite real numbers of any shape (also a single one)."""
    try:
        values = np.asarray(value)
        if values.dtype.kind not in "iuf" or np.ma.is_masked(value):
            raise TypeError
        result = values.astype(float)
    except MemoryError:
        raise SceneError(field, value, "small enough for the memory") from None
    except Exception as error:  # an object's own code runs here, and may raise anything
        if isinstance(error, ValueError):
            allowed = f"{allowed}, with rows of equal length"
        raise SceneError(field, value, allowed) from None
    sizes = np.abs(result)
    if not (sizes <= most).all():  # False also for NaN
        require_all(field, result, np.isfinite(result), allowed)
        require_all(field, result, sizes <= most, f"at most {most:g} in size")
    return result


def require_all(field: str, values: np.ndarray, good: np.ndarray, allowed: str) -> None:
    """Refuse the first invalid value, by its index where there are several."""
    if not good.all():
        where = tuple(int(i) for i in np.argwhere(~good)[0])
        if where:
            field = f"{field}{list(where)}"
        raise SceneError(field, float(values[where]), allowed)


def poisson(value: Any, field: str = "nu") -> np.ndarray:
    """Poisson's ratios, in (-1, 0.5], of any shape."""
    result = numbers(field, value, POISSON)
    require_all(field, result, (result > -1) & (result <= 0.5), POISSON)
    return result


def positives(field: str, value: Any, allowed: str = "positive, finite numbers") -> np.ndarray:
    """Finite numbers above zero, of any shape."""
    if type(value) is float and SMALL <= value <= LARGE:
        return np.array(value)
    result = numbers(field, value, allowed)
    if not np.all(result >= SMALL):
        require_all(field, result, result > 0, allowed)
        require_all(field, result, result >= SMALL, f"at least {SMALL:g}")
    return result


def broadcasting(arguments: dict[str, Any]) -> None:
    """Refuse arrays whose shapes do not broadcast."""
    shapes = {
        name: np.shape(value) for name, value in arguments.items() if not isinstance(value, float)
    }
    try:
        if shapes:
            np.broadcast_shapes(*shapes.values())
    except ValueError:
        words = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise SceneError(
            "shapes", words, message=f"the shapes of the arguments do not broadcast: {words}"
        ) from None


def wrong_shape(field: str, shape: tuple[int, ...], allowed: str) -> SceneError:
    """The error for an array of another shape than is allowed."""
    message = f"{field} has shape {shape}; it must be {allowed}"
    return SceneError(field, f"array of shape {shape}", allowed, message=message)


def kind(field: str, value: Any, *kinds: type[Any], more: str = "") -> Any:
    """A value of one of some classes."""
    if not isinstance(value, kinds):
        names = [each.__name__ for each in kinds if each is not type(None)]
        allowed = " or ".join(f"{'an' if name[0] in 'AEIOU' else 'a'} {name}" for name in names)
        raise SceneError(field, value, allowed + more)
    return value


def flag(field: str, value: Any) -> bool:
    """True or False; 0, 1 and words are refused."""
    if not isinstance(value, (bool, np.bool_)):
        raise SceneError(field, value, "true or false")
    return bool(value)


def progress(value: Any) -> Callable[[Any], None]:
    """The function that is called with the name of each stage; for None and false one that does
    nothing.
    """
    if value is None or value is False:
        return lambda stage: None
    refusal = SceneError("progress", value, "true, false, or a function of one string")
    if not callable(value) or isinstance(value, type):
        raise refusal
    # of a function that is built in the signature may not be known
    with contextlib.suppress(ValueError):
        try:
            inspect.signature(value).bind("")
        except TypeError:
            raise refusal from None
    return value


def file_name(field: str, value: Any) -> Path:
    """The name of a file, as a path."""
    name = value
    if isinstance(value, os.PathLike):
        name = os.fspath(value)
    if not isinstance(name, str) or not name:
        raise SceneError(field, value, "the name of a file")
    return Path(name)


def elastic(value: Any) -> None:
    """Refuse what does not have the combined constants of two half-spaces."""
    if not (hasattr(value, "combined_G") and hasattr(value, "combined_nu")) or hasattr(
        value, "surfaces"
    ):
        raise SceneError("bodies", value, "half-spaces, Bodies(G, nu)")


def exactly_one(**arguments: Any) -> None:
    """Refuse arguments, by name, unless exactly one of them is given."""
    given = [name for name, value in arguments.items() if value is not None]
    if len(given) != 1:
        message = f"neither {' nor '.join(arguments)} is given: give one of them"
        if given:
            message = f"{' and '.join(given)} are both given: give one of them"
        raise SceneError(
            ", ".join(arguments), tuple(arguments.values()), "exactly one of them", message=message
        )


def choice(field: str, value: Any, options: Iterable[str]) -> str:
    """One of the named options; the error suggests the nearest."""
    names = list(options)
    if not isinstance(value, str) or value not in names:
        raise SceneError(field, value, f"one of {', '.join(names)}{nearest(value, names)}")
    return value


def nearest(value: Any, names: Iterable[str]) -> str:
    """`` (did you mean ...?)``, or nothing where no name is near."""
    if not isinstance(value, str):
        return ""
    names = list(names)
    other_case = [name for name in names if name.lower() == value.lower()]
    close = other_case or difflib.get_close_matches(value, names, n=1, cutoff=0.5)
    if not close:
        return ""
    return f" (did you mean {close[0]}?)"


def options_of(function: Callable[..., Any], **given: Any) -> tuple[str, ...]:
    """Names of all options of a public function: its own, and those that it forwards, by what else
    is given.
    """
    code = inspect.unwrap(function).__code__
    forwarded: ForwardedNames = getattr(function, "forwarded", _nothing)
    return *code.co_varnames[: code.co_argcount + code.co_kwonlyargcount], *forwarded(given)


def _nothing(given: Mapping[str, Any]) -> Iterable[str]:
    return ()


def named_options(
    forwarded: ForwardedNames = _nothing,
) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """A public function that refuses misspelt options before any work; `forwarded` has names of
    ``**options``.
    """

    def checking(function: Callable[P, R]) -> Callable[P, R]:
        own = frozenset(options_of(function))
        call: Callable[..., R] = function

        @functools.wraps(function)
        def checked(*args: P.args, **options: P.kwargs) -> R:
            if not own.issuperset(options):
                names = options_of(checked, **options)
                _refuse_others(function.__qualname__, names, options)
            if options.get("progress") is not True:
                return function(*args, **options)
            with shown_progress() as show:
                return call(*args, **{**options, "progress": show})

        checked.forwarded = forwarded  # type: ignore[attr-defined]
        return checked

    return checking


def _refuse_others(function: str, names: Iterable[str], options: Mapping[str, Any]) -> None:
    """Refuse the first option that a function does not have."""
    names = [name for name in names if name not in ("self", "cls")]
    for name, value in options.items():
        if name not in names:
            instead = nearest(name, names) or f"; it has {', '.join(dict.fromkeys(names))}"
            message = f"{function} has no option {name}{instead}"
            raise SceneError(name, value, message=message)


def short_entries(value: Any) -> str:
    """Dataclass as text, with long entries cut short."""
    entries = (
        f"{field.name}={shortened(getattr(value, field.name), 200)}"
        for field in dataclasses.fields(value)
    )
    return f"{type(value).__name__}({', '.join(entries)})"


@functools.cache
def _names_of(cls: Any) -> frozenset[str]:
    """Names of the fields of a dataclass."""
    return frozenset(each.name for each in dataclasses.fields(cls))


class Checked:
    """A dataclass that checks entries as it is made, each by a check; entries that are None by
    default may be.

    Where an argument has another name, `_words` say which is right.
    """

    __dataclass_fields__: ClassVar[dict[str, dataclasses.Field[Any]]]
    __match_args__: ClassVar[tuple[str, ...]]  # fields that may be given by position
    _path: ClassVar[str] = ""
    _words: ClassVar[dict[str, str]] = {}
    _checks: ClassVar[dict[str, Callable[[str, Any], Any]]] = {}

    def __init_subclass__(
        cls, path: str | None = None, **by_name: Callable[[str, Any], Any]
    ) -> None:
        cls._path = cls._path if path is None else f"{path}."
        cls._checks = cls._checks | by_name

    def __new__(cls, *args: Any, **kwargs: Any) -> Self:
        if len(args) > len(cls.__match_args__):
            names = [each.name for each in dataclasses.fields(cls)]
            by_name = ", ".join(f"{name}=..." for name in names[: len(args)])
            message = f"{cls.__name__} takes its entries by name: write {cls.__name__}({by_name})"
            raise SceneError(cls.__name__, len(args), message=message)
        for name in kwargs:
            if name not in _names_of(cls) or name[:1] == "_":  # type: ignore[arg-type]
                names = [each.name for each in dataclasses.fields(cls)]
                instead = nearest(name, names) or f"; it has {', '.join(names)}"
                if name in cls._words:
                    instead = f": write {cls._words[name]}"
                message = f"{cls.__name__} has no {name}{instead}"
                raise SceneError(f"{cls.__name__}.{name}", name, message=message)
        return super().__new__(cls)

    def __post_init__(self) -> None:
        for name, check in self._checks.items():
            value = getattr(self, name)
            if value is not None or getattr(type(self), name, ...) is not None:
                object.__setattr__(self, name, check(f"{self._path}{name}", value))
