"""Grids of parameters: a scene with some of its numbers replaced, one for each point of the grid."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene

SCENE = "scene"
"""The dimension of scenes that are given one by one."""


@dataclass(frozen=True)
class Swept:
    """Scenes on a grid of parameters: values by dimension, the last of which varies fastest."""

    coordinates: dict[str, list[Any]]
    scenes: tuple[Scene, ...]

    @classmethod
    def of(cls, scenes: Any, over: Any) -> Swept:
        """The scenes, with numbers replaced by values by name, as ``{"motion.vx": [0.0, 1e-3]}``."""
        coordinates, base = _given(scenes)
        varied = _values({} if over is None else over)
        made = [
            changed(scene, dict(zip(varied, point, strict=True)))
            for scene in base
            for point in product(*varied.values())
        ]
        return cls(coordinates | varied, tuple(made))


def _given(scenes: Any) -> tuple[dict[str, list[Any]], list[Scene]]:
    if isinstance(scenes, Scene):
        _check_one_problem("scenes", scenes)
        return {}, [scenes]
    if isinstance(scenes, Mapping):
        names, base = list(scenes), list(scenes.values())
        for name in names:
            if not isinstance(name, str):
                raise SceneError("scenes", name, "named by strings")
    elif isinstance(scenes, Sequence) and not isinstance(scenes, str | bytes):
        base = list(scenes)
        names = list(range(len(base)))
    else:
        raise SceneError("scenes", scenes, "a Scene, a list of them, or a dict of them by name")
    if not base:
        raise SceneError("scenes", base, "at least one")
    for name, scene in zip(names, base, strict=True):
        _check_one_problem(f"scenes[{name!r}]", scene)
    return {SCENE: names}, base


def _check_one_problem(field: str, scene: Any) -> None:
    if not isinstance(scene, Scene):
        raise SceneError(field, scene, "a Scene")
    if not isinstance(scene.motion, Steady | Shift | None):
        allowed = "Steady, Shift or none"
        kind = type(scene.motion).__name__
        raise SceneError(f"{field}.motion", kind, allowed, message=f"{field}.motion is {kind}: a sweep takes {allowed}")


def _values(over: Any) -> dict[str, list[Any]]:
    if not isinstance(over, Mapping):
        raise SceneError("over", over, 'a dict of values by entry, as {"motion.vx": [0.0, 1e-3]}')
    varied: dict[str, list[Any]] = {}
    for name, given in over.items():
        field = f"over[{name!r}]"
        if not isinstance(name, str):
            raise SceneError("over", name, "named by strings")
        if isinstance(given, str | bytes | Mapping) or not isinstance(given, Iterable):
            raise SceneError(field, given, "a list of numbers")
        values = [value.item() if isinstance(value, np.generic) else value for value in given]
        if not values:
            raise SceneError(field, values, "at least one value")
        for value in values:
            if isinstance(value, bool) or not isinstance(value, int | float | str):
                raise SceneError(field, value, "a list of numbers")
        if len(set(values)) < len(values):
            raise SceneError(field, values, "different values")
        varied[name] = values
    return varied


def changed(scene: Scene, values: Mapping[str, Any]) -> Scene:
    """The scene with entries replaced, named as `Swept.of` names them."""
    parts: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        part, _, entry = name.partition(".")
        whole, message = [f.name for f in fields(Scene)], ""
        inside = getattr(scene, part) if part in whole else None
        known = [f.name for f in fields(inside)] if is_dataclass(inside) else []
        if part not in whole:
            message = f'the scene has no "{name}"{checks.nearest(part, whole)}'
        elif entry and entry not in known:
            kind = "missing" if inside is None else type(inside).__name__
            why = "" if known else f": {part} is {kind}"
            message = f'the scene has no "{name}"{why}{checks.nearest(entry, known)}'
        elif not entry and (known or part in ("motion", "units")):
            example = f' (as "{part}.{known[0]}")' if known else ""
            message = f'"{name}" is no number{example}'
        if message:
            raise SceneError("over", name, "a number of the scene", message=f"over: {message}")
        parts.setdefault(part, {})[entry] = value
    changes = {
        part: entries[""] if "" in entries else replace(getattr(scene, part), **entries)
        for part, entries in parts.items()
    }
    return replace(scene, **changes)
