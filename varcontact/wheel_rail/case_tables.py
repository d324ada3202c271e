"""Objects from the tables of a case file: track, wheel set, bodies, friction and wear."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from varcontact.errors import SceneError
from varcontact.interfaces.shear_strength import ShearStrength
from varcontact.io.scene_toml import bodies_from, friction_from
from varcontact.io.toml_tables import (
    check_keys,
    file_named,
    kind_named,
    make,
    named_as,
    needed,
    table_of,
)
from varcontact.scene.friction_laws import LAWS
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.regions import FrictionByAngle
from varcontact.wheel_rail.slices import SLICES, ProfileSlices
from varcontact.wheel_rail.track import Irregularity, Track, WheelSet
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap

NAMED = {"rail": ("60e1", Profile.rail_60e1), "wheel": ("s1002", Profile.s1002)}
READ = ("file", "mirror_y", "mirror_z", "scale", "smoothing", "kinks")
BOTH = ("rail", "wheel")
"""Tables of bodies or thermal data that differ: body 1 is the rail."""
FRICTIONS: dict[str, type[Any]] = {
    **LAWS,
    "shear-strength": ShearStrength,
    "by_angle": FrictionByAngle,
}
WEAR: dict[str, type[Any]] = {"archard": Archard, "archard-map": ArchardMap}


def make_parts(table: dict[str, Any], folder: Path) -> None:
    """Replace the tables of a case by objects, but for those that may vary by position."""
    for name in ("track", "wheelset"):
        if name not in table:
            raise SceneError(name, None, f"given: add a table [{name}]")
    table["track"] = _track(table_of("track", table["track"]), folder)
    table["wheelset"] = _wheelset(table_of("wheelset", table["wheelset"]), folder)
    if "bodies" in table:
        table["bodies"] = _of_both("bodies", table["bodies"], bodies_from)
    if "friction" in table:
        table["friction"] = _frictions(table["friction"], folder)
    if "third_body" in table:
        entries = table_of("third_body", table["third_body"])
        table["third_body"] = make("third_body", ThirdBody, entries)
    if "thermal" in table:
        table["thermal"] = _of_both("thermal", table["thermal"], _thermal)


def wear_from(table: Any) -> Archard | ArchardMap:
    """Archard's law from the table ``[wear]``: with a coefficient, unless its kind is the map."""
    entries = dict(table_of("wear", table))
    kind = kind_named("wear", entries.pop("kind", "archard"), WEAR)
    law: Archard | ArchardMap = make("wear", WEAR[kind], entries)
    return law


def _track(table: Mapping[str, Any], folder: Path) -> Any:
    """A track with its rails and their irregularities."""
    entries = dict(table)
    for name in ("rail", "left_rail", "right_rail"):
        if name in entries:
            entries[name] = _rails(f"track.{name}", entries[name], folder)
    for side in ("left", "right"):
        if side in entries:
            field = f"track.{side}"
            with named_as(field, "irregularity"):
                entries[side] = make(field, Irregularity, table_of(field, entries[side]))
    return make("track", Track, entries)


def _wheelset(table: Mapping[str, Any], folder: Path) -> Any:
    """A wheel set with its profile."""
    entries = dict(table)
    if "wheel" in entries:
        entries["wheel"] = _profile("wheelset.wheel", "wheel", entries["wheel"], folder)
    return make("wheelset", WheelSet, entries)


def _rails(field: str, value: Any, folder: Path) -> Any:
    """A rail, or several from a list, which lie under one wheel."""
    if not isinstance(value, list):
        return _profile(field, "rail", value, folder)
    if not value:
        raise SceneError(field, value, "one rail at least")
    rails: list[Any] = []
    for k, each in enumerate(value):
        rail = _profile(f"{field}[{k}]", "rail", each, folder)
        if isinstance(rail, tuple):
            rails += rail
        else:
            rails.append(rail)
    return tuple(rails)


def _profile(field: str, kind: Kind, value: Any, folder: Path) -> Any:
    """A profile or slices, by a name or a table."""
    if isinstance(value, Mapping) and "profiles" in value:
        return _slices(field, kind, value, folder)
    entries = {"file": value}
    if isinstance(value, Mapping):
        entries = dict(value)
    check_keys(field, entries, READ)
    file = needed(field, entries, "file")
    standard, standard_profile = NAMED[kind]
    allowed = f'the name of a file beside the case file, "{standard}", or a table'
    if not isinstance(file, str):
        raise SceneError(field, file, allowed)
    if file.lower() == standard:
        if len(entries) > 1:
            raise SceneError(
                field, value, message=f"{field}: {file} has no options, give its name alone"
            )
        return standard_profile()
    path = file_named(f"{field}.file", entries.pop("file"), folder)
    if not path.is_file():
        raise SceneError(field, file, allowed)
    reader: Any = Profile.read
    if path.suffix.lower() in SLICES:
        reader = ProfileSlices.read
    return reader(path, kind, **entries)


def _slices(field: str, kind: Kind, table: Mapping[str, Any], folder: Path) -> ProfileSlices:
    """Slices by a table of their profiles and positions."""
    profiles = table["profiles"]
    within = f"{field}.profiles"
    if isinstance(profiles, list):
        profiles = [
            _profile(f"{within}[{k}]", kind, each, folder) for k, each in enumerate(profiles)
        ]
    else:
        profiles = _profile(within, kind, profiles, folder)
    with named_as(field, "slices"):
        slices: ProfileSlices = make(field, ProfileSlices, {**table, "profiles": profiles})
    return slices


def _of_both(name: str, value: Any, made: Callable[[str, Mapping[str, Any]], Any]) -> Any:
    """Bodies or thermal data of both bodies in one table, or a pair by tables of rail and wheel."""
    table = table_of(name, value)
    if table.keys().isdisjoint((*BOTH, "upper", "lower")):
        return made(name, table)
    check_keys(name, table, BOTH)
    pair = []
    for body in BOTH:
        field = f"{name}.{body}"
        entries = table_of(field, needed(name, table, body))
        with named_as(field, name):
            pair.append(made(field, entries))
    return tuple(pair)


def _thermal(field: str, table: Mapping[str, Any]) -> Thermal:
    thermal: Thermal = make(field, Thermal, table)
    return thermal


def _frictions(value: Any, folder: Path) -> Any:
    """Friction of all rails, or of the left and the right one."""
    if not isinstance(value, list):
        return _friction("friction", value, folder)
    return tuple(_friction(f"friction[{k}]", each, folder) for k, each in enumerate(value))


def _friction(field: str, value: Any, folder: Path) -> Any:
    """A number, or the object of a table with its kind."""
    if not isinstance(value, Mapping):
        return value
    kind = kind_named(field, needed(field, value, "kind"), FRICTIONS)
    with named_as(field, "friction"):
        if FRICTIONS[kind] is not FrictionByAngle:
            return friction_from(field, value, folder)
        entries = {key: each for key, each in value.items() if key != "kind"}
        return make(field, FrictionByAngle, entries)
