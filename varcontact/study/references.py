"""Continuum values of many scenes, with error bars, against which the errors of answers are measured."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.data.benchmark_scenes import Posed, reference_scenes
from varcontact.errors import SceneError
from varcontact.results.quantities_of_interest import error
from varcontact.scene.scene import Scene

VERSION = 1
"""Version of the file of references."""
COMMAND = "python -m varcontact.data.make_references"
FILE = "references.json"
SAMPLED = 16
"""Every 16th sample of a surface is part of its signature."""


@dataclass(frozen=True, eq=False)
class ContinuumValues:
    """A scene, and the continuum values of its answers.

    Attributes
    ----------
    scene : Scene
        Without a grid of its own.
    values : dict of str to float
        Forces and moment; creepages where forces are prescribed; approach and largest pressure of normal contact;
        areas. Of a history by step, as ``Fx[5]``. In the scene's units.
    bars : dict of str to float
        Half the widths of their 95 % intervals.
    units : dict of str to float
        The size of an error of one, of the values that count (`varcontact.results.quantities_of_interest`); not of
        areas.
    kind : str
        Class of the scene.
    how : str
        Where the values are from.
    steps : tuple of int
        Of a history: the steps that count.
    """

    scene: Scene
    values: dict[str, float]
    bars: dict[str, float]
    units: dict[str, float]
    kind: str
    how: str
    steps: tuple[int, ...] = ()

    @property
    def bar(self) -> float:
        """The largest error bar of the values that count, in their units."""
        return max(self.bars[name] / unit for name, unit in self.units.items())

    def error(self, found: Mapping[str, float]) -> float:
        """The error of an answer: the largest of the errors of its values `found`, in their units; NaN if one lacks."""
        return error(found, {name: self.values[name] for name in self.units}, self.units)


def continuum_values(path: str | Path | None = None) -> dict[str, ContinuumValues]:
    """Scenes by name with their continuum values, from the package's own file.

    Parameters
    ----------
    path : str or Path, optional
        Another file, made by ``python -m varcontact.data.make_references``.

    Returns
    -------
    dict of str to ContinuumValues

    Raises
    ------
    SceneError
        If the file is none of references, or of another version of them.

    Examples
    --------
    >>> import varcontact as vc
    >>> bank = vc.continuum_values()
    >>> carter = bank["line, creepage 0.3"]
    >>> print(len(bank) >= 60, f"{carter.values['Fx'] / 0.3:.4f}", carter.bar < 1e-5)
    True -0.5100 True
    """
    if path is None:
        return dict(read(files("varcontact.data").joinpath(FILE).read_text(encoding="utf-8"), FILE))
    name = checks.file_name("path", path)
    try:
        text = name.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as reason:
        raise SceneError("path", str(name), "a file of references", message=f"{name}: {reason}") from None
    return dict(read(text, str(name)))


Reference, references = ContinuumValues, continuum_values
"""The names of earlier versions."""


@cache
def read(text: str, name: str) -> dict[str, ContinuumValues]:
    """References from the text of the file `name`."""
    try:
        content = json.loads(text)
        version, entries = content["version"], content["references"]
    except (ValueError, KeyError, TypeError):
        raise _refused(name, "is no file of references") from None
    if version != VERSION:
        raise _refused(name, f"is of version {version}, and version {VERSION} is read")
    scenes = reference_scenes()
    other = [each for each, entry in entries.items() if entry["scene"] != signature(scenes.get(each))]
    missing = [each for each in scenes if each not in entries]
    if other or missing:
        which = other[0] if other else missing[0]
        raise _refused(name, f"was made for other scenes than this version has, {which!r} for one")
    found = {}
    for each, entry in entries.items():
        named = {part: {k: float(value) for k, value in entry[part].items()} for part in ("values", "bars", "units")}
        scene = scenes[each]
        found[each] = ContinuumValues(scene.scene, **named, kind=scene.kind, how=entry["how"], steps=scene.steps)
    return found


def _refused(name: str, what: str) -> SceneError:
    message = f"{name} {what}; make it again: {COMMAND}"
    return SceneError("references", name, "a file of references of this version", message=message)


def signature(posed: Posed | None) -> str:
    """A digest of a scene of the bank, the same on all machines."""
    return hashlib.sha256(json.dumps(_plain(posed)).encode()).hexdigest()[:12]


def _plain(value: Any) -> Any:
    """Types and numbers of six digits: the last digits of roots and logarithms may differ between machines.

    Entries that have their default are left out, so that new ones may be added to a class.
    """
    if is_dataclass(value):
        entries = {each.name: (getattr(value, each.name), each.default) for each in fields(value)}
        said = {name: _plain(own) for name, (own, default) in entries.items() if _plain(own) != _plain(default)}
        return [type(value).__name__, said]
    if isinstance(value, np.ndarray):
        return _plain(value[(slice(None, None, SAMPLED),) * value.ndim].tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if value is MISSING:  # no default
        return "missing"
    return f"{value:.6g}" if isinstance(value, float) else value
