"""Scenes as TOML files, and as plain dictionaries."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.elasticity.fourier_symbol import FourierSymbol
from varcontact.elasticity.graded import Graded
from varcontact.elasticity.own import Elasticity
from varcontact.errors import SceneError
from varcontact.interfaces.carried_friction import CarriedFriction
from varcontact.interfaces.shear_strength import ShearStrength
from varcontact.io.toml_tables import (
    check_keys,
    file_named,
    kind_named,
    make,
    needed,
    number_range,
    read_toml,
    table_of,
)
from varcontact.results.solution import Solution
from varcontact.scene.bodies import Bodies, BodyPair, Layer, Layered, Viscoelastic, Winkler
from varcontact.scene.carried import Carried
from varcontact.scene.friction_laws import LAWS
from varcontact.scene.given_bodies import Numbers
from varcontact.scene.grid import Grid
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.motion import Harmonic, Shift, Steady, TimeStep
from varcontact.scene.pin import PinInHole
from varcontact.scene.scene import Scene
from varcontact.scene.surface_displacement import SurfaceDisplacement
from varcontact.scene.surface_load import SurfaceLoad
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units
from varcontact.system.files import SCENE_BYTES, check_replaceable, first_line, text_of, write_whole

SURFACES = {
    "paraboloids": Paraboloids,
    "ellipse": Ellipse,
    "cylinders": Cylinders,
    "pin-in-hole": PinInHole,
    "sampled-distance": SampledDistance,
}
BODIES: dict[str, type[Any]] = {
    "layered": Layered,
    "viscoelastic": Viscoelastic,
    "graded": Graded,
    "winkler": Winkler,
    "elasticity": Elasticity,
}
MOTIONS = {
    "steady": Steady,
    "shift": Shift,
    "transient": Transient,
    "harmonic": Harmonic,
    "time-step": TimeStep,
}
FRICTIONS: dict[str, type[Any]] = {
    **LAWS,
    "shear-strength": ShearStrength,
    "carried": CarriedFriction,
}
KINDS = {
    cls: kind for kinds in (SURFACES, MOTIONS, FRICTIONS, BODIES) for kind, cls in kinds.items()
}
"""The kind of each class."""
PLACES: dict[str, Mapping[str, type[Any]] | type[Any]] = {
    "surface": SURFACES,
    "motion": MOTIONS,
    "friction": FRICTIONS,
    "factors": LAWS,
    "bodies": BODIES,
    "layers": Layer,
    "symbol": FourierSymbol,
    "carried": Carried,
    "grid": Grid,
    "loads": SurfaceLoad,
    "displacements": SurfaceDisplacement,
    "thermal": Thermal,
    "third_body": ThirdBody,
    "units": Units,
}
"""Class of the tables of an entry, or classes by their kinds."""
NUMBERS = {"file", "sha256"}
"""Keys of a table that stands for numbers: a file name, or a checksum."""
NO_NUMBER = "none"
"""Word for None in a TOML file, which has no null: the entry is not given in this step."""
SOLVE_KEYS = (
    "method",
    "normal",
    "tangential",
    "coupling",
    "formulation",
    "tol",
    "polish",
    "start",
    "certify",
    "accuracy",
    "time_budget",
)


@checks.named_options()
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
        If the file cannot be read, is no TOML, or says something a scene cannot
        be; unknown keys come with the nearest right one.

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


def read_sweep_scene(
    path: str | Path, varies: bool = True
) -> tuple[Scene, dict[str, list[Any]], dict[str, Any]]:
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
    options = dict(table_of("solve", table.pop("solve", {})))
    checks.gone("solve.refine", options.get("refine"), checks.REFINE_BECAME)
    check_keys("solve", options, SOLVE_KEYS)
    return options


def scene_from(table: Mapping[str, Any], folder: Path | None = None) -> Scene:
    """A scene from nested dictionaries as a TOML file gives them."""
    check_keys("", table, [f.name for f in dataclasses.fields(Scene)], taken=["solve"])
    for name in ("bodies", "surface"):
        if name not in table:
            raise SceneError(name, None, f"given: add a table [{name}]")
    for name in ("bodies", "surface", "motion", "grid", "third_body", "units"):
        if table.get(name, "auto") != "auto":
            table_of(name, table[name])
    rows = isinstance(table.get("grid"), Mapping) and "ny" in table["grid"]
    # one row or column is line contact
    dims = {"rigid_slip": 2, "factors": 2, "h": 2 if rows else 1}
    entries = {
        name: _made(name, name, each, folder, dims)
        for name, each in table.items()
        if name != "friction"
    }
    if "friction" in table:
        dims["friction"] = 1 if entries["surface"].line else 2
        entries["friction"] = _made("friction", "friction", table["friction"], folder, dims)
    return Scene(**entries)


def _made(name: str, key: str, value: Any, folder: Path | None, dims: Mapping[str, int]) -> Any:
    """Value of an entry called `key`: the numbers of a file, the object of a table, or itself.
    Files have as many dimensions as `dims` says, or one.
    """
    if key == "start":
        return _start(name, value, folder)
    if isinstance(value, list) and any(isinstance(each, Mapping | str) for each in value):
        entries = [None if each == NO_NUMBER else each for each in value]
        return [_made(f"{name}[{k}]", key, each, folder, dims) for k, each in enumerate(entries)]
    if isinstance(value, Mapping):
        return _made_of_table(name, key, value, folder, dims)
    return value


def _start(name: str, value: Any, folder: Path | None) -> Solution:
    """A solution, or the last step of a history, from its file."""
    from varcontact.io.solution import read

    stored = read(file_named(name, value, folder))
    return stored if isinstance(stored, Solution) else stored[-1]


def _made_of_table(
    name: str, key: str, value: Mapping[str, Any], folder: Path | None, dims: Mapping[str, int]
) -> Any:
    """Value of a table, see `_made`."""
    if not NUMBERS.isdisjoint(value):
        return _numbers(name, value, folder, dims.get(key, 1))
    if key in ("bodies", "thermal") and ("upper" in value or "lower" in value):
        check_keys(name, value, ("upper", "lower"))
        sides = {f"{name}.{side}": needed(name, value, side) for side in ("upper", "lower")}
        return tuple(_made(field, key, side, folder, dims) for field, side in sides.items())
    if key not in PLACES:
        return value
    if "y" in value:
        dims = {**dims, "h": 2, "height": 2}
    entries = {
        inner: _made(f"{name}.{inner}", inner, each, folder, dims) for inner, each in value.items()
    }
    if key == "bodies" and "kind" not in entries:
        return _half_spaces(name, entries)
    return _object(name, key, entries)


def _numbers(name: str, value: Mapping[str, Any], folder: Path | None, ndmin: int) -> Any:
    """The numbers of a file, or those in the table itself with their checksum."""
    if "file" in value:
        return _from_file(name, value, folder, ndmin)
    return Numbers.of_table(name, value)


def _object(name: str, key: str, entries: dict[str, Any]) -> Any:
    """Object of the class, or of the kind, that stands at a place; a surface of samples may be
    smoothed.
    """
    place = PLACES[key]
    kind = place if isinstance(place, type) else _kind(name, entries, place)
    if kind is SampledDistance and "smoothing" in entries:
        wavelength = checks.positive(f"{name}.smoothing", entries.pop("smoothing"))
        return make(name, kind, entries).smoothed(wavelength)
    return make(name, kind, entries)


def _half_spaces(name: str, entries: dict[str, Any]) -> Bodies:
    """Half-spaces by E or G, and nu."""
    if "E" in entries:
        check_keys(name, entries, ("E", "nu"))
        return Bodies.from_young(needed(name, entries, "E"), needed(name, entries, "nu"))
    check_keys(name, entries, ("G", "nu", "E"))
    return Bodies(needed(name, entries, "G"), needed(name, entries, "nu"))


def _kind(name: str, entries: dict[str, Any], kinds: Mapping[str, type[Any]]) -> type[Any]:
    """The class that a table names, whose kind is taken out of it."""
    if "kind" not in entries:
        known = {field.name for cls in kinds.values() for field in dataclasses.fields(cls)}
        unknown = [f"; there is no key {name}.{key}" for key in entries if key not in known]
        raise SceneError(
            f"{name}.kind", None, f"given: give one of {', '.join(kinds)}{''.join(unknown[:1])}"
        )
    return kinds[kind_named(name, entries.pop("kind"), kinds)]


def bodies_from(field: str, table: Mapping[str, Any]) -> Bodies | Viscoelastic:
    """Elastic or viscoelastic half-spaces from a table, as a scene has it."""
    if "kind" in table:
        checks.choice(f"{field}.kind", table["kind"], ("viscoelastic",))
    made = _made(field, "bodies", table, None, {})
    if not isinstance(made, Bodies | Viscoelastic):
        raise SceneError(field, table, "half-spaces, by G or E and nu")
    return made


def friction_from(field: str, table: Mapping[str, Any], folder: Path | None) -> Any:
    """A law or a bound from a table, as a scene has it."""
    return _made(field, "friction", table, folder, {"factors": 2})


def scene_to(scene: Scene) -> dict[str, Any]:
    """A scene as nested dictionaries of plain numbers and lists; `scene_from` takes them back.

    The start of a history, which is a whole solution, is left out.
    """
    if isinstance(scene.motion, Transient) and scene.motion.control is not None:
        allowed = "left out: no file can hold it, and the scene of a solved history has its numbers"
        raise SceneError("motion.control", "a function", allowed)
    entries = {field.name: getattr(scene, field.name) for field in dataclasses.fields(scene)}
    if scene.thermal is not None:
        entries["thermal"] = dict(zip(("upper", "lower"), scene.thermal, strict=True))
    return {name: _plain(value) for name, value in entries.items() if value is not None}


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if isinstance(value, Numbers):
        return value.to_table()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return _table_of_object(value)
    if callable(value):
        allowed = (
            "laws and numbers: no file can hold a function; "
            "for the friction of a solution, sol.friction"
        )
        raise SceneError("friction.factors", getattr(value, "__name__", "a function"), allowed)
    return value


def _table_of_object(value: Any) -> Any:
    """Fields of a dataclass that are given, with its kind."""
    if isinstance(value, BodyPair) and value.upper == value.lower:
        return _plain(value.upper)
    table: dict[str, Any] = {}
    kinds = [KINDS[cls] for cls in type(value).__mro__ if cls in KINDS]
    if kinds:
        table["kind"] = kinds[0]
    entries = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    for name, entry in entries.items():
        if name != "start" and entry is not None:
            table[name] = _plain(entry)
    return table


def _from_file(field: str, table: Mapping[str, Any], folder: Path | None, ndmin: Any) -> np.ndarray:
    """Numbers from ``{file = "..."}``: a text file (blanks or commas) or ``.npy``, with at least
    `ndmin` dimensions.
    """
    check_keys(field, table, ("file",))
    path = file_named(f"{field}.file", needed(field, table, "file"), folder)
    try:
        if path.suffix == ".npy":
            return np.asarray(np.load(path, allow_pickle=False))
        text = text_of(f"{field}.file", path)
        separator = "," if "," in text else None
        return np.loadtxt(text.splitlines(), delimiter=separator, ndmin=ndmin)
    except (OSError, ValueError, EOFError, MemoryError) as error:
        raise SceneError(
            f"{field}.file", str(path), f"a readable file of numbers ({first_line(error)})"
        ) from None


WRITTEN = "# Written by varcontact\n"
"""The first line of scene files that are not written by hand."""


def scene_text(scene: Scene) -> str:
    """A scene as the text of a TOML file, see `Scene.to_toml`."""
    if isinstance(scene.motion, Transient) and scene.motion.start is not None:
        allowed = (
            'left out: save it, and add start = "FILE.nc" to the table [motion] of the scene file'
        )
        raise SceneError("motion.start", "a solution", allowed)
    table = scene_to(scene)  # its own entries, then a section for each table in it
    own = [
        f"{key} = {_value(value)}" for key, value in table.items() if not isinstance(value, Mapping)
    ]
    sections = [
        "\n".join([f"[{key}]", *(f"{inner} = {_value(each)}" for inner, each in value.items())])
        for key, value in table.items()
        if isinstance(value, Mapping)
    ]
    text = WRITTEN + "\n\n".join(part for part in ("\n".join(own), *sections) if part) + "\n"
    if len(text.encode()) > SCENE_BYTES:
        most = f"at most {SCENE_BYTES / 2**20:.0f} MiB"
        allowed = f"{most}: write large fields to files, named by {{file = ...}}"
        raise SceneError("scene", f"{len(text) / 2**20:.1f} MiB of text", allowed)
    return text


def save_scene(scene: Scene, path: str | Path, overwrite: bool = False) -> None:
    """Write a scene file atomically, see `Scene.save`."""
    path = checks.file_name("path", path)
    check_replaceable("path", path, (".toml",), "scene", WRITTEN.encode(), overwrite)
    write_whole("path", path, scene_text(scene).encode())


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_value(each)}" for key, each in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        return repr(float(value))
    return json.dumps(NO_NUMBER if value is None else value).replace("\x7f", "\\u007f")
