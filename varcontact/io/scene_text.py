"""Scenes written as TOML."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.outputs import check_ending, check_replaceable, check_writable, write_whole
from varcontact.io.scene_file import NO_NUMBER, scene_to
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.system.reading import SCENE_BYTES

WRITTEN = "# Written by varcontact\n"
"""The first line of scene files that are not written by hand."""


def scene_text(scene: Scene) -> str:
    """A scene as the text of a TOML file, see `Scene.to_toml`."""
    if isinstance(scene.motion, Transient) and scene.motion.start is not None:
        raise SceneError(
            "motion.start",
            "a solution",
            "left out",
            message="motion.start is a solution, which a scene file cannot hold: save it, leave it out of the scene, "
            'and add start = "FILE.nc" to the table [motion]',
        )
    text = WRITTEN + toml_text(scene_to(scene), NO_NUMBER)
    if len(text.encode()) > SCENE_BYTES:
        raise SceneError(
            "scene",
            f"{len(text) / 2**20:.1f} MiB of text",
            f"at most {SCENE_BYTES / 2**20:.0f} MiB",
            message=f"scene: as text it has {len(text) / 2**20:.1f} MiB, and a scene file may have "
            f"{SCENE_BYTES / 2**20:.0f} MiB; write large fields to files of their own, and name them by {{file = ...}}",
        )
    return text


def save_scene(scene: Scene, path: str | Path, overwrite: bool = False) -> None:
    """Write a scene file, whole or not at all, see `Scene.save`."""
    path = checks.file_name("path", path)
    check_ending("path", path, ".toml")
    check_writable("path", path)
    check_replaceable("path", path, "scene", _is_written, overwrite)
    write_whole("path", path, scene_text(scene).encode())


def _is_written(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(len(WRITTEN)) == WRITTEN.encode()


def toml_text(table: Mapping[str, Any], none: str) -> str:
    """A table as TOML: its own entries, then a section for each table in it."""
    own = [_entry(key, value, none) for key, value in table.items() if not isinstance(value, Mapping)]
    sections = [
        "\n".join([f"[{key}]", *(_entry(inner, each, none) for inner, each in value.items())])
        for key, value in table.items()
        if isinstance(value, Mapping)
    ]
    return "\n\n".join(part for part in ("\n".join(own), *sections) if part) + "\n"


def _entry(key: str, value: Any, none: str) -> str:
    return f"{key} = {_value(value, none)}"


def _value(value: Any, none: str) -> str:
    if value is None:
        return json.dumps(none)
    if isinstance(value, str):
        return json.dumps(value).replace("\x7f", "\\u007f")
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, int | np.integer):
        return str(int(value))
    if isinstance(value, float | np.floating):
        return repr(float(value)) if math.isfinite(value) else str(float(value))
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_entry(key, each, none) for key, each in value.items()) + " }"
    return "[" + ", ".join(_value(each, none) for each in value) + "]"
