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
    made = [
        changed(scene, dict(zip(varied, point, strict=True)))
        for scene in named.values()
        for point in product(*varied.values())
    ]
    return varied if isinstance(scenes, Scene) else {SCENE: list(named)} | varied, made


def named_scenes(given: Any) -> dict[Any, Scene]:
    """Scenes of one problem each by their names, or by their numbers in a list."""
    if isinstance(given, Scene):
        named: dict[Any, Any] = {SCENE: given}
    elif isinstance(given, Mapping):
        named = dict(given)
        for name in named:
            if not isinstance(name, str):
                raise SceneError("scenes", name, "named by strings")
    elif isinstance(given, Sequence) and not isinstance(given, str | bytes):
        named = dict(enumerate(given))
    else:
        raise SceneError("scenes", given, "a Scene, a list of them, or a dict of them by name")
    if not named:
        raise SceneError("scenes", given, "at least one")
    for name, scene in named.items():
        field = "scenes" if scene is given else f"scenes[{name!r}]"
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
    for name, given in over.items():
        field, allowed = f"over[{name!r}]", "a list of numbers" if numbers else "a list of values"
        if not isinstance(name, str):
            raise SceneError("over", name, "named by strings")
        if isinstance(given, str | bytes | Mapping) or not isinstance(given, Iterable):
            raise SceneError(field, given, allowed)
        values = [value.item() if isinstance(value, np.generic) else value for value in given]
        if not values:
            raise SceneError(field, values, "at least one value")
        for value in values if numbers else ():
            if isinstance(value, bool) or not isinstance(value, int | float | str):
                raise SceneError(field, value, allowed)
        if len(set(values if numbers else map(str, values))) < len(values):
            raise SceneError(field, values, "different values")
        varied[name] = values
    return varied


def changed(owner: Owner, values: Mapping[str, Any], what: str = "scene") -> Owner:
    """A scene, or a wheel set, with entries replaced, named as `scenes_over` names them."""
    given: Any = owner
    parts: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        part, _, entry = name.partition(".")
        whole, message = [f.name for f in fields(given)], ""
        inside = getattr(given, part) if part in whole else None
        known = [f.name for f in fields(inside)] if is_dataclass(inside) else []
        if part not in whole:
            message = f'the {what} has no "{name}"{checks.nearest(part, whole)}'
        elif entry and entry not in known:
            kind = "missing" if inside is None else type(inside).__name__
            why = "" if known else f": {part} is {kind}"
            message = f'the {what} has no "{name}"{why}{checks.nearest(entry, known)}'
        elif not entry and known and not is_dataclass(value):
            message = f'"{name}" is no number (as "{part}.{known[0]}")'
        if message:
            raise SceneError("over", name, f"a number of the {what}", message=f"over: {message}")
        parts.setdefault(part, {})[entry] = value
    changes = {
        part: entries[""] if "" in entries else replace(getattr(given, part), **entries)
        for part, entries in parts.items()
    }
    made: Owner = replace(given, **changes) if changes else given
    return made
