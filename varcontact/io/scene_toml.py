"""Scenes as TOML files, and as plain dictionaries."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.toml_tables import check_keys, file_named, make, needed, number_range, read_toml, table_of
from varcontact.results.solution import Solution
from varcontact.scene.bodies import Bodies, BodyPair, Layer, Layered, Viscoelastic
from varcontact.scene.carried import Carried
from varcontact.scene.friction_laws import LAWS, FrictionLaw
from varcontact.scene.grid import Grid
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.motion import Harmonic, Shift, Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance, is_line
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units
from varcontact.system.files import SCENE_BYTES, begins_with, check_replaceable, first_line, text_of, write_whole

SURFACES = {
    "paraboloids": Paraboloids,
    "ellipse": Ellipse,
    "cylinders": Cylinders,
    "sampled-distance": SampledDistance,
}
BODIES = {"layered": Layered, "viscoelastic": Viscoelastic}
MOTIONS = {"steady": Steady, "shift": Shift, "transient": Transient, "harmonic": Harmonic, "time-step": TimeStep}
KINDS = {cls: kind for kinds in (SURFACES, MOTIONS, LAWS, BODIES) for kind, cls in kinds.items()}
"""The kind of each class."""
NO_NUMBER = "none"
"""Stands for None in a TOML file, which has no null: the entry is not given in this step."""
SOLVE_KEYS = (
    "method", "normal", "tangential", "coupling", "formulation", "tol", "polish", "start", "certify", "refine",
    "accuracy", "time_budget"
)  # fmt: skip


def read_scene(path: str | Path) -> tuple[Scene, dict[str, Any]]:
    """Read a scene from a TOML file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    scene : Scene
    options : dict
        The file's ``[solve]`` table: keywords of `solve`.

    Raises
    ------
    SceneError
        If the file cannot be read, is no TOML, or says something a scene cannot be; unknown keys come with the
        nearest right one.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "ball.toml"
    >>> _ = path.write_text('''
    ... normal_force = 1000.0
    ... [bodies]
    ... G = 82e9
    ... nu = 0.28
    ... [surface]
    ... kind = "paraboloids"
    ... Rx = 0.1
    ... Ry = 0.1
    ... ''')
    >>> scene, options = read_scene(path)
    >>> scene.surface
    Paraboloids(Rx=0.1, Ry=0.1)
    >>> folder.cleanup()
    """
    table, folder = read_toml(path, "scene file")
    options = solve_table(table)
    return scene_from(table, folder), options


def read_sweep_scene(path: str | Path, varies: bool = True) -> tuple[Scene, dict[str, list[Any]], dict[str, Any]]:
    """Read a scene file with a table ``[over]``, of entries that take several values."""
    table, folder = read_toml(path, "scene file")
    options = solve_table(table)
    if varies and "over" not in table:
        raise SceneError("over", None, "given: add a table [over] of the entries that vary")
    over = dict(_varied(table_of("over", table.pop("over", {}))))
    return scene_from(table, folder), over, options


def _varied(table: Mapping[str, Any], within: str = "") -> Iterator[tuple[str, list[Any]]]:
    """The entries that vary, whether a table names them in quotes or in tables of their own."""
    for key, value in table.items():
        name = within + key
        if not isinstance(value, Mapping):
            yield name, value
        elif "from" in value:
            yield name, number_range(f"over.{name}", value)
        else:
            yield from _varied(value, f"{name}.")


def solve_table(table: dict[str, Any]) -> dict[str, Any]:
    """Take the table ``[solve]`` out of a file."""
    options = table.pop("solve", {})
    check_keys("solve", table_of("solve", options), SOLVE_KEYS)
    return options


def scene_from(table: Mapping[str, Any], folder: Path | None = None) -> Scene:
    """A scene from nested dictionaries as a TOML file gives them."""
    entries = dict(table)
    check_keys("", entries, [f.name for f in dataclasses.fields(Scene)])
    for name in ("bodies", "surface"):
        if name not in entries:
            raise SceneError(name, None, f"given: add a table [{name}]")
    entries["bodies"] = _pair("bodies", table_of("bodies", entries["bodies"]), _body)
    rows = isinstance(entries.get("grid"), Mapping) and "ny" in entries["grid"]
    entries["surface"] = _kind("surface", entries["surface"], SURFACES, folder, rows)
    if "motion" in entries:
        entries["motion"] = _kind("motion", entries["motion"], MOTIONS, folder)
    for name, made in (("grid", Grid), ("third_body", ThirdBody), ("units", Units)):
        if entries.get(name, "auto") != "auto":
            entries[name] = make(name, made, table_of(name, entries[name]))
    if isinstance(entries.get("thermal"), Mapping):
        entries["thermal"] = _pair("thermal", entries["thermal"], lambda name, each: make(name, Thermal, each))
    if "friction" in entries:
        entries["friction"] = _friction(
            "friction", entries["friction"], folder, 1 if is_line(entries["surface"]) else 2
        )
    return Scene(**entries)


def scene_to(scene: Scene) -> dict[str, Any]:
    """A scene as nested dictionaries of plain numbers and lists; `scene_from` takes them back.

    The start of a history, which is a whole solution, is left out.
    """
    if isinstance(scene.motion, Transient) and scene.motion.control is not None:
        allowed = "left out: no file can hold it, and the scene of a solved history has its numbers"
        raise SceneError("motion.control", "a function", allowed)
    table: dict[str, Any] = {}
    for field in dataclasses.fields(scene):
        value = getattr(scene, field.name)
        if value is not None:
            plain = dict(zip(("upper", "lower"), value, strict=True)) if field.name == "thermal" else value
            table[field.name] = _plain(plain)
    return table


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if not dataclasses.is_dataclass(value) or isinstance(value, type):
        if callable(value):
            allowed = "laws and numbers: no file can hold a function; for the friction of a solution, sol.friction"
            raise SceneError("friction.factors", getattr(value, "__name__", "a function"), allowed)
        return value
    entries = {f.name: getattr(value, f.name) for f in dataclasses.fields(value) if f.name != "start"}
    if isinstance(value, BodyPair) and not value.coupled:
        return _plain(value.upper)
    table = next(({"kind": KINDS[cls]} for cls in type(value).__mro__ if cls in KINDS), {})
    return table | {name: _plain(entry) for name, entry in entries.items() if entry is not None}


def bodies_from(table: Mapping[str, Any]) -> Bodies:
    """Half-spaces from a table of G and nu, or of E and nu."""
    made = _body("bodies", table)
    if not isinstance(made, Bodies):
        raise SceneError("bodies", table, "half-spaces, by G or E and nu")
    return made


def _pair(name: str, table: Mapping[str, Any], made: Callable[[str, Mapping[str, Any]], Any]) -> Any:
    """What is made of a table, or of two of them, ``[name.upper]`` and ``[name.lower]``, which may be words."""
    if "upper" not in table and "lower" not in table:
        return made(name, table)
    check_keys(name, table, ("upper", "lower"))
    sides = {f"{name}.{side}": needed(name, table, side) for side in ("upper", "lower")}
    return tuple(side if isinstance(side, str) else made(field, table_of(field, side)) for field, side in sides.items())


def _body(name: str, table: Mapping[str, Any]) -> Any:
    if "kind" in table:
        entries = dict(table)
        kind = BODIES[checks.choice(f"{name}.kind", entries.pop("kind"), BODIES)]
        if kind is Layered and isinstance(entries.get("layers"), list):
            entries["layers"] = [
                make(f"{name}.layers[{k}]", Layer, table_of(f"{name}.layers[{k}]", each))
                for k, each in enumerate(entries["layers"])
            ]
        return make(name, kind, entries)
    if "E" in table:
        check_keys(name, table, ("E", "nu"))
        return Bodies.from_young(*(needed(name, table, key) for key in ("E", "nu")))
    check_keys(name, table, ("G", "nu", "E"))
    return Bodies(*(needed(name, table, key) for key in ("G", "nu")))


def _kind(name: str, table: Any, kinds: Mapping[str, type[Any]], folder: Path | None, rows: bool = False) -> Any:
    entries = dict(table_of(name, table))
    if "kind" not in entries:
        known = {field.name for cls in kinds.values() for field in dataclasses.fields(cls)}
        unknown = [f"; there is no key {name}.{key}" for key in entries if key not in known]
        allowed = f"one of {', '.join(kinds)}"
        message = f"{name}.kind is missing: give {allowed}{''.join(unknown[:1])}"
        raise SceneError(f"{name}.kind", None, allowed, message=message)
    kind = entries.pop("kind")
    if isinstance(kind, str):
        kind = kind.lower().replace("_", "-")
    made = kinds[checks.choice(f"{name}.kind", kind, kinds)]
    if made is Transient:
        entries = _history(entries, folder)
    elif made is Steady:
        entries = _with_files(name, entries, folder, {"rigid_slip": 2})
    elif made is FrictionLaw and isinstance(entries.get("factors"), list):
        entries["factors"] = [_friction(f"{name}.factors", each, folder, 2) for each in entries["factors"]]
    elif made is SampledDistance:
        several = 2 if rows or "y" in entries else 1  # else one row or column is line contact
        entries = _with_files(name, entries, folder, {"h": several, "x": 1, "y": 1, "inclination": 1})
        if "smoothing" in entries:
            wavelength = checks.positive(f"{name}.smoothing", entries.pop("smoothing"))
            return make(name, made, entries).smoothed(wavelength)
    return make(name, made, entries)


def _history(entries: Mapping[str, Any], folder: Path | None) -> dict[str, Any]:
    """The entries of a history: files read, surfaces and the start made, words for what is not given replaced."""
    from varcontact.io.solution import read

    made = dict(entries)
    for field, value in entries.items():
        name = f"motion.{field}"
        if field == "start":  # a solution, or the last step of a history
            loaded = read(file_named(name, value, folder))
            made[field] = loaded if isinstance(loaded, Solution) else loaded[-1]
        elif field == "surface" and isinstance(value, list):
            made[field] = [_kind(f"{name}[{k}]", each, SURFACES, folder) for k, each in enumerate(value)]
        elif field == "carried":
            several = value if isinstance(value, list) else [value]
            made[field] = [_carried(f"{name}[{k}]", each, folder) for k, each in enumerate(several)]
        elif isinstance(value, list):
            given = [None if each == NO_NUMBER else each for each in value]
            laws = field == "friction"
            made[field] = [_friction(f"{name}[{k}]", x, folder, 1) for k, x in enumerate(given)] if laws else given
        elif field == "friction":
            made[field] = _friction(name, value, folder, 1)
    return _with_files("motion", made, folder, dict.fromkeys(made, 1))


def _carried(name: str, table: Any, folder: Path | None) -> Carried:
    entries = table_of(name, table)
    rows = 2 if "y" in entries else 1
    return make(name, Carried, _with_files(name, entries, folder, {"height": rows, "x": 1, "y": 1}))


def _friction(name: str, value: Any, folder: Path | None, dimensions: int) -> Any:
    """Numbers as they are, those of a file, or a law."""
    if not isinstance(value, Mapping):
        return value
    return _from_file(name, value, folder, dimensions) if "file" in value else _kind(name, value, LAWS, folder)


def _with_files(
    name: str, entries: Mapping[str, Any], folder: Path | None, dimensions: Mapping[str, int]
) -> dict[str, Any]:
    """Entries with the numbers of the files that some of them name, in so many dimensions."""
    read = {
        field: _from_file(f"{name}.{field}", entries[field], folder, number)
        for field, number in dimensions.items()
        if isinstance(entries.get(field), Mapping)
    }
    return {**entries, **read}


def _from_file(field: str, table: Mapping[str, Any], folder: Path | None, dimensions: int) -> np.ndarray:
    """Numbers from ``{file = "..."}``: a text file (blanks or commas) or ``.npy``, with at least `dimensions`."""
    check_keys(field, table, ("file",))
    path = file_named(f"{field}.file", needed(field, table, "file"), folder)
    try:
        if path.suffix == ".npy":
            return np.asarray(np.load(path, allow_pickle=False))
        lines = text_of(f"{field}.file", path).splitlines()
        ndmin: Any = dimensions  # 1 or 2
        return np.loadtxt(lines, delimiter="," if any("," in line for line in lines) else None, ndmin=ndmin)
    except SceneError:
        raise
    except (OSError, ValueError, EOFError, MemoryError) as error:
        raise SceneError(f"{field}.file", str(path), f"a readable file of numbers ({first_line(error)})") from None


WRITTEN = "# Written by varcontact\n"
"""The first line of scene files that are not written by hand."""


def scene_text(scene: Scene) -> str:
    """A scene as the text of a TOML file, see `Scene.to_toml`."""
    if isinstance(scene.motion, Transient) and scene.motion.start is not None:
        allowed = 'left out: save it, and add start = "FILE.nc" to the table [motion] of the scene file'
        raise SceneError("motion.start", "a solution", allowed)
    table = scene_to(scene)  # its own entries, then a section for each table in it
    own = [f"{key} = {_value(value)}" for key, value in table.items() if not isinstance(value, Mapping)]
    sections = [
        "\n".join([f"[{key}]", *(f"{inner} = {_value(each)}" for inner, each in value.items())])
        for key, value in table.items()
        if isinstance(value, Mapping)
    ]
    text = WRITTEN + "\n\n".join(part for part in ("\n".join(own), *sections) if part) + "\n"
    if len(text.encode()) > SCENE_BYTES:
        allowed = f"at most {SCENE_BYTES / 2**20:.0f} MiB: write large fields to files, named by {{file = ...}}"
        raise SceneError("scene", f"{len(text) / 2**20:.1f} MiB of text", allowed)
    return text


def save_scene(scene: Scene, path: str | Path, overwrite: bool = False) -> None:
    """Write a scene file, whole or not at all, see `Scene.save`."""
    path = checks.file_name("path", path)
    check_replaceable("path", path, (".toml",), "scene", lambda each: begins_with(each, WRITTEN.encode()), overwrite)
    write_whole("path", path, scene_text(scene).encode())


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        return repr(float(value))
    return json.dumps(NO_NUMBER if value is None else value).replace("\x7f", "\\u007f")
