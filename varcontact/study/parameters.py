"""Grids of parameters: a scene with some of its numbers replaced, one for each point of the
grid.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from itertools import product
from typing import Any, TypeVar

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene

Owner = TypeVar("Owner")

SCENE = "scene"
"""The dimension of scenes that are given one by one."""


def scenes_over(scenes: Any, over: Any) -> tuple[dict[str, list[Any]], list[Scene]]:
    """Values by dimension, the last of which varies fastest, and scenes with these, as
    ``{"motion.vx": [0.0]}``.
    """
    named = named_scenes(scenes)
    varied = varied_values({} if over is None else over)
    every = [
        changed(scene, dict(zip(varied, point, strict=True)))
        for scene in named.values()
        for point in product(*varied.values())
    ]
    if not isinstance(scenes, Scene):
        varied = {SCENE: list(named)} | varied
    return varied, every


def named_scenes(scenes: Any) -> dict[Any, Scene]:
    """Scenes of one problem each by their names, or by their numbers in a list."""
    if isinstance(scenes, Scene):
        named: dict[Any, Any] = {SCENE: scenes}
    elif isinstance(scenes, Mapping):
        named = dict(scenes)
        for name in named:
            if not isinstance(name, str):
                raise SceneError("scenes", name, "named by strings")
    elif isinstance(scenes, Sequence) and not isinstance(scenes, str | bytes):
        named = dict(enumerate(scenes))
    else:
        raise SceneError("scenes", scenes, "a Scene, a list of them, or a dict of them by name")
    if not named:
        raise SceneError("scenes", scenes, "at least one")
    for name, scene in named.items():
        field = "scenes" if scene is scenes else f"scenes[{name!r}]"
        checks.kind(field, scene, Scene)
        if not isinstance(scene.motion, Steady | Shift | None):
            message = (
                f"{field}.motion is {type(scene.motion).__name__}: it must be Steady, Shift or none"
            )
            raise SceneError(
                f"{field}.motion", scene.motion, "Steady, Shift or none", message=message
            )
    return named


def varied_values(over: Any, *, numbers: bool = True) -> dict[str, list[Any]]:
    """Values by entry, all different; `numbers` or words, or whatever the entry takes."""
    if not isinstance(over, Mapping):
        raise SceneError("over", over, 'a dict of values by entry, as {"motion.vx": [0.0, 1e-3]}')
    varied: dict[str, list[Any]] = {}
    for name, values in over.items():
        if not isinstance(name, str):
            raise SceneError("over", name, "named by strings")
        varied[name] = _values(f"over[{name!r}]", values, numbers)
    return varied


def _values(field: str, given: Any, numbers: bool) -> list[Any]:
    """The values of one entry, all different; `numbers` or words, or whatever it takes."""
    allowed = "a list of numbers" if numbers else "a list of values"
    if isinstance(given, str | bytes | Mapping) or not isinstance(given, Iterable):
        raise SceneError(field, given, allowed)
    values = [value.item() if isinstance(value, np.generic) else value for value in given]
    if not values:
        raise SceneError(field, values, "at least one value")
    if numbers:
        for value in values:
            if isinstance(value, bool) or not isinstance(value, int | float | str):
                raise SceneError(field, value, allowed)
        different = set(values)
    else:
        different = set(map(str, values))
    if len(different) < len(values):
        raise SceneError(field, values, "different values")
    return values


def changed(
    owner: Owner, values: Mapping[str, Any], what: str = "scene", given_as: str = "over"
) -> Owner:
    """A scene, or a wheel set, with entries replaced, named as `scenes_over` names them."""
    old: Any = owner
    parts: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        message = _why_not_entry(old, name, value, what)
        if message:
            allowed = f"a number of the {what}"
            raise SceneError(given_as, name, allowed, message=f"{given_as}: {message}")
        part, _, entry = name.partition(".")
        parts.setdefault(part, {})[entry] = value
    if not parts:
        return owner
    changes = {
        part: entries[""] if "" in entries else replace(getattr(old, part), **entries)
        for part, entries in parts.items()
    }
    new: Owner = replace(old, **changes)
    return new


def _why_not_entry(owner: Any, name: str, value: Any, what: str) -> str:
    """Reason why a value cannot be that of an entry; empty where it can."""
    part, _, entry = name.partition(".")
    parts = [field.name for field in fields(owner)]
    if part not in parts:
        return f'the {what} has no "{name}"{_nearest_entry(owner, name)}'
    inside = getattr(owner, part)
    entries = [field.name for field in fields(inside)] if is_dataclass(inside) else []
    if entry and entry not in entries:
        why = ""
        if not entries:
            kind = "missing" if inside is None else type(inside).__name__
            why = f": {part} is {kind}"
        return f'the {what} has no "{name}"{why}{checks.nearest(entry, entries)}'
    if not entry and entries and not is_dataclass(value):
        return f'"{name}" is no number (as "{part}.{entries[0]}")'
    return ""


def _nearest_entry(owner: Any, name: str) -> str:
    """Suggestion of the entry of a part with this name, `motion.vx` for `vx`, or of a near part."""
    parts = [field.name for field in fields(owner)]
    for part in parts:
        inside = getattr(owner, part)
        if is_dataclass(inside) and name in [field.name for field in fields(inside)]:
            return f" (did you mean {part}.{name}?)"
    return checks.nearest(name.partition(".")[0], parts)
