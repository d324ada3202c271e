"""Inputs of a scene by name: numbers anywhere in it, and fields."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, shortened
from varcontact.gradients.adjoint import SceneOf
from varcontact.gradients.contact_fields import CREEPAGES, SHIFTS
from varcontact.scene.bodies import BodyPair
from varcontact.scene.scene import Scene

OF_MOTION = (*CREEPAGES, *SHIFTS, "Fx", "Fy", "dq")
"""Inputs of the motion that may be named without ``motion.``."""
SIDES = {"upper": 0, "lower": 1}
"""Names of the entries of a pair."""
QUANTITIES = {
    "normal_force": "force",
    "approach": "length",
    "distance": "length",
    "motion.vx": "creepage",
    "motion.vy": "creepage",
    "motion.spin": "spin creepage",
    "motion.ux": "creepage",
    "motion.uy": "creepage",
    "motion.rotation": "spin creepage",
    "motion.Fx": "force",
    "motion.Fy": "force",
    "motion.dq": "length",
    "surface.Rx": "length",
    "surface.Ry": "length",
    "surface.R": "length",
    "surface.a": "length",
    "surface.b": "length",
    "bodies.G": "pressure",
    "bodies.E": "pressure",
    "bodies.h": "length",
    "bodies.layers.G": "pressure",
    "bodies.layers.h": "length",
    "bodies.base.0": "pressure",
    "third_body.G": "pressure",
    "third_body.h": "length",
    "friction.strength": "pressure",
}
"""Quantity of each input, which gives its unit: entries of bodies without the side, of layers
without the place; others are pure numbers."""


def path_of(name: Any) -> str:
    """The path of an input in its scene: ``motion.vx`` of vx."""
    if not isinstance(name, str):
        raise SceneError("by", name, 'names, as "vx" or "bodies.G"')
    if name in OF_MOTION:
        return f"motion.{name}"
    return name


def quantity_of(path: str) -> str:
    """Quantity whose unit an input has."""
    whole = ".".join(part for part in path.split(".") if part not in SIDES)
    return QUANTITIES.get(re.sub(r"layers\.\d+", "layers", whole), "1")


def derivative_unit(above: str, below: str) -> str:
    """Unit of a derivative, from the units of the output and the input."""
    if below == "1":
        return above
    return f"({above})/({below})"


def number_of(scene: Scene, path: str) -> tuple[SceneOf, float]:
    """A function from the value of a number to the scene with it, and the value."""
    parts = path.split(".")
    value = _entry(scene, path, parts)
    if not _is_number(value) or not np.isfinite(value):
        raise SceneError("by", path, f"a number of the scene; {_instead(path, value)}")
    return partial(_with_entry, scene, parts), float(value)


def _instead(path: str, value: Any) -> str:
    """Paths of the numbers in an entry, or what the entry is."""
    names: list[str] = []
    if is_dataclass(value):
        names = [each.name for each in fields(value) if _is_number(getattr(value, each.name))]
    elif isinstance(value, tuple) and len(value) == 2 and all(map(_is_number, value)):
        names = list(SIDES)
    if names:
        return f"name {' or '.join(f'{path}.{name}' for name in names)}"
    return f"it is {shortened(value)}"


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _entry(scene: Scene, path: str, parts: list[str]) -> Any:
    """Value in the scene at a dotted path; SceneError if there is none."""
    owner: Any = scene
    for part in parts:
        if _stands_for_two(owner, part):
            owner = owner.upper
        if is_dataclass(owner):
            names = [each.name for each in fields(owner)]
            if part not in names:
                elsewhere = [f" (did you mean {each}?)" for each in _paths_to(part, scene)]
                meant = [*elsewhere, checks.nearest(part, names)][0]
                raise SceneError("by", path, f"an input of the scene{meant}")
            owner = getattr(owner, part)
            continue
        place = _place(part)
        if isinstance(owner, tuple | list) and place is not None and place < len(owner):
            owner = owner[place]
        elif not (part in SIDES and isinstance(owner, int | float)):
            raise SceneError("by", path, "an input of the scene")
    return owner


def _paths_to(name: str, owner: Any, path: tuple[str, ...] = ()) -> Iterator[str]:
    """Paths of the numbers, or pairs of numbers, called `name` in an owner."""
    if _stands_for_two(owner, name):
        owner = owner.upper
    entries: dict[str, Any] = {}
    if is_dataclass(owner):
        entries = {each.name: getattr(owner, each.name) for each in fields(owner)}
    elif isinstance(owner, tuple):
        entries = {str(place): each for place, each in enumerate(owner)}
    for part, entry in entries.items():
        if part == name and isinstance(entry, int | float | tuple):
            yield ".".join((*path, part))
        yield from _paths_to(name, entry, (*path, part))


def _stands_for_two(owner: Any, part: str) -> bool:
    """True for an entry that both bodies share, as they are alike."""
    return isinstance(owner, BodyPair) and part not in SIDES and owner.upper == owner.lower


def _place(part: str) -> int | None:
    """Place in a pair or a list."""
    if part in SIDES:
        return SIDES[part]
    if part.isdigit():
        return int(part)
    return None


def _with_entry(owner: Any, parts: list[str], value: float) -> Any:
    """An owner with a number at a path in it."""
    if not parts:
        return value
    first, *rest = parts
    if _stands_for_two(owner, first):
        body = _with_entry(owner.upper, parts, value)
        return BodyPair(body, body)
    if is_dataclass(owner):
        inner = _with_entry(getattr(owner, first), rest, value)
        return replace(owner, **{first: inner})  # type: ignore[type-var]
    # a pair, or a number that stands for one
    entries = [owner, owner]
    if isinstance(owner, tuple | list):
        entries = list(owner)
    place = _place(first)
    assert place is not None
    entries[place] = _with_entry(entries[place], rest, value)
    return tuple(entries)
