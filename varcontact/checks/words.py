"""Checks of names, choices and other things that are no numbers."""

from __future__ import annotations

import dataclasses
import difflib
import inspect
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from varcontact.errors import SceneError

MOST_SHOWN = 12
"""Numbers of an array or a list that are shown one by one."""


def flag(field: str, value: Any) -> bool:
    """True or False; 0, 1 and words are refused."""
    if not isinstance(value, (bool, np.bool_)):
        raise SceneError(field, value, "true or false")
    return bool(value)


def progress(value: Any) -> Callable[[str], None] | None:
    """The function that is called with the name of each stage, or None."""
    if value is None or (callable(value) and _takes_a_word(value)):
        return value
    raise SceneError("progress", value, "None, or a function of one string")


def _takes_a_word(function: Callable[..., Any]) -> bool:
    """Whether it is a function that can be called with one string, as far as it is known what it takes."""
    if isinstance(function, type):
        return False
    try:
        inspect.signature(function).bind("")
    except ValueError:  # built in, and its signature is not known
        return True
    except TypeError:
        return False
    return True


def file_name(field: str, value: Any) -> Path:
    """The name of a file, as a path."""
    name = os.fspath(value) if isinstance(value, os.PathLike) else value
    if not isinstance(name, str):
        raise SceneError(field, value, "the name of a file")
    return Path(name)


def elastic(value: Any) -> None:
    """Refuse what does not have the combined constants of two bodies."""
    if not (hasattr(value, "combined_G") and hasattr(value, "combined_nu")):
        raise SceneError("bodies", value, "Bodies")


def exactly_one(**arguments: Any) -> None:
    """Refuse two arguments, by name, of which not exactly one is given: both are None, or neither is."""
    names = list(arguments)
    given = [name for name, value in arguments.items() if value is not None]
    if len(given) == 1:
        return
    if given:
        message = f"{' and '.join(names)} are both given: give one of them"
    else:
        message = f"neither {' nor '.join(names)} is given: give one of them"
    raise SceneError(", ".join(names), tuple(arguments.values()), "exactly one of the two", message=message)


def choice(field: str, value: Any, options: Iterable[str]) -> str:
    """One of the named options; the error suggests the nearest."""
    names = list(options)
    if isinstance(value, str) and value in names:
        return value
    raise SceneError(field, value, f"one of {', '.join(names)}{nearest(value, names)}")


def nearest(value: Any, names: Iterable[str]) -> str:
    """`` (did you mean ...?)``, or nothing where no name is near."""
    known = list(names)
    if not isinstance(value, str):
        return ""
    other_case = [name for name in known if name.lower() == value.lower()]
    close = other_case or difflib.get_close_matches(value, known, n=1, cutoff=0.5)
    return f" (did you mean {close[0]}?)" if close else ""


def short(value: Any) -> str:
    """A value as text, without the numbers of large arrays and long lists."""
    if isinstance(value, np.ndarray) and value.size > MOST_SHOWN:
        sides = " x ".join(map(str, value.shape))
        return f"array of {sides} numbers from {value.min():.6g} to {value.max():.6g}"
    if isinstance(value, tuple) and len(value) > MOST_SHOWN:
        return f"({value[0]!r}, {value[1]!r}, ..., {value[-1]!r}: {len(value)} values)"
    return repr(value)


def short_entries(value: Any) -> str:
    """A dataclass as text, its entries without the numbers of large arrays and long lists."""
    entries = (f"{field.name}={short(getattr(value, field.name))}" for field in dataclasses.fields(value))
    return f"{type(value).__name__}({', '.join(entries)})"
