"""JSON Schema of scene, sweep and case files, from the dataclasses, for editors that complete and
check TOML.
"""

from __future__ import annotations

import collections.abc
import dataclasses
import inspect
import types
import typing
from collections.abc import Iterable, Mapping
from typing import Any, Literal, Union

import numpy as np

from varcontact.io.scene_toml import PLACES, SOLVE_KEYS
from varcontact.scene.bodies import Viscoelastic
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solving.methods import Methods
from varcontact.solving.options import Options
from varcontact.wheel_rail.case_file import MOVING, SIDES, VARYING
from varcontact.wheel_rail.case_tables import BOTH, FRICTIONS, READ, WEAR
from varcontact.wheel_rail.slices import ProfileSlices
from varcontact.wheel_rail.track import Irregularity, Track, WheelSet
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack

DRAFT = "https://json-schema.org/draft/2020-12/schema"
Schema = dict[str, Any]
NUMBER: Schema = {"type": "number"}
ANY: Schema = {}
FILE: Schema = {
    "type": "object",
    "properties": {"file": {"type": "string", "description": "numbers, .npy or text"}},
    "required": ["file"],
    "additionalProperties": False,
}
RANGE: Schema = {
    "type": "object",
    "properties": {
        "from": NUMBER,
        "to": NUMBER,
        "count": {"type": "integer", "minimum": 2},
        "spacing": {"enum": ["linear", "log"]},
    },
    "required": ["from", "to", "count"],
    "additionalProperties": False,
}
BY_TYPE: dict[Any, Schema] = {
    bool: {"type": "boolean"},
    str: {"type": "string"},
    int: {"type": "integer"},
    float: NUMBER,
    np.ndarray: {"anyOf": [NUMBER, {"type": "array"}, FILE]},
}


def scene_schema() -> Schema:
    """Schema of scene files."""
    return _document("scene", "scene file of varcontact", _scene_entries())


def sweep_schema() -> Schema:
    """Schema of sweep files: scene files with a table of entries that vary."""
    varied = {"type": "object", "description": "values, ranges or tables of them, by entry"}
    entries = _scene_entries() | {"over": varied}
    return _document("sweep", "sweep file of varcontact", entries, ["over"])


def wheel_schema() -> Schema:
    """Schema of case files of wheels on rails."""
    entries = entries_of(WheelOnRail) | entries_of(WheelSetOnTrack)
    varies = {"anyOf": [NUMBER, {"type": "array", "items": NUMBER}, RANGE]}
    for name in VARYING:
        entries[name] = _as(varies, entries[name])
    for name, kind in MOVING.items():
        fields = {key: _as(varies, each) for key, each in entries_of(kind).items()}
        entries[name] = table(fields)
    entries["track"] = _track_table()
    entries["wheelset"] = _wheelset_table()
    frictions = [_of_kind(kind, each) for kind, each in FRICTIONS.items()]
    friction: Schema = {"anyOf": [NUMBER, *frictions]}
    of_each_rail = {"type": "array", "items": friction, "minItems": 2, "maxItems": 2}
    entries["friction"] = {"anyOf": [*friction["anyOf"], of_each_rail]}
    entries["bodies"] = _of_both([*half_spaces(), _of_kind("viscoelastic", Viscoelastic)])
    entries["third_body"] = _as(_table_of(ThirdBody), entries["third_body"])
    entries["thermal"] = _as(_of_both([_table_of(Thermal)]), entries["thermal"])
    entries["side"] = {"enum": list(SIDES)}
    archard = WEAR["archard"]
    laws = [_of_kind(kind, law) for kind, law in WEAR.items()]
    entries["wear"] = {"anyOf": [_table_of(archard), *laws]}
    entries["shakedown"] = table({"yield_in_shear": NUMBER}, ["yield_in_shear"])
    entries["solve"] = solve_schema(key for key in SOLVE_KEYS if key not in ("polish", "start"))
    content = table(entries, ["track", "wheelset"]) | {"$defs": definitions(["factors"])}
    return document("wheel", "case file of varcontact", content)


def _as(schema: Schema, described: Schema) -> Schema:
    """Schema with the description of another one."""
    words = {key: described[key] for key in ("description",) if key in described}
    return schema | words


def _table_of(kind: type[Any]) -> Schema:
    """The table of a dataclass."""
    return table(entries_of(kind), required_of(kind))


def _of_both(tables: list[Schema]) -> Schema:
    """One of some tables for both bodies, or one for each."""
    either: Schema = {"anyOf": tables}
    return {"anyOf": [*tables, table(dict.fromkeys(BOTH, either), BOTH)]}


def _track_table() -> Schema:
    """Table of a track, with rails and irregularities."""
    entries = entries_of(Track)
    one = _profile()
    several = {"type": "array", "items": one, "minItems": 1}
    for name in ("rail", "left_rail", "right_rail"):
        entries[name] = _as({"anyOf": [*one["anyOf"], several]}, entries[name])
    for side in ("left", "right"):
        entries[side] = _as(_table_of(Irregularity), entries[side])
    return table(entries, required_of(Track))


def _wheelset_table() -> Schema:
    """Table of a wheel set, with its profile."""
    entries = entries_of(WheelSet)
    entries["wheel"] = _as(_profile(), entries["wheel"])
    return table(entries, required_of(WheelSet))


def _profile() -> Schema:
    """A profile or slices: a name, or a table of a file or of slices."""
    return {"anyOf": [BY_TYPE[str], _profile_table(), _slices_table()]}


def _profile_table() -> Schema:
    """Table of a profile, or of slices, in a file."""
    entries: dict[str, Schema] = {
        "file": BY_TYPE[str],
        "mirror_y": {"anyOf": [BY_TYPE[bool], {"const": "auto"}]},
        "mirror_z": BY_TYPE[bool],
        "scale": NUMBER,
        "smoothing": NUMBER,
        "kinks": {"anyOf": [{"const": "auto"}, {"type": "array", "items": NUMBER}]},
    }
    return table({name: entries[name] for name in READ}, ["file"])


def _slices_table() -> Schema:
    """Table of slices by their profiles."""
    profile: Schema = {"anyOf": [BY_TYPE[str], _profile_table()]}
    numbers: Schema = {"type": "array", "items": NUMBER}
    entries = entries_of(ProfileSlices)
    schemas: dict[str, Schema] = {
        "profiles": {"anyOf": [*profile["anyOf"], {"type": "array", "items": profile}]},
        "positions": numbers,
        "z": {"anyOf": [NUMBER, numbers]},
        "features": {"type": "array", "items": numbers},
    }
    for name, schema in schemas.items():
        entries[name] = _as(schema, entries[name])
    return table(entries, required_of(ProfileSlices))


SCHEMAS = {"scene": scene_schema, "sweep": sweep_schema, "wheel": wheel_schema}
"""Functions that make the JSON schema, by kind of file."""


def _scene_entries() -> dict[str, Schema]:
    entries = entries_of(Scene)
    return entries | {"solve": solve_schema(SOLVE_KEYS)}


def _document(
    name: str, title: str, entries: dict[str, Schema], more: Iterable[str] = ()
) -> Schema:
    required = ["bodies", "surface", *more]
    return document(name, title, table(entries, required) | {"$defs": definitions(PLACES)})


def definitions(places: Iterable[str]) -> dict[str, Schema]:
    """The tables of the classes at some places, by place and kind."""
    tables = {}
    for name in places:
        place = PLACES[name]
        if isinstance(place, type):
            tables[name] = table(entries_of(place), required_of(place))
        else:
            tables |= {f"{name}.{kind}": _of_kind(kind, cls) for kind, cls in place.items()}
    return tables


def document(name: str, title: str, content: Schema) -> Schema:
    """A whole schema, with its name and title."""
    return {"$schema": DRAFT, "$id": f"varcontact-{name}.schema.json", "title": title, **content}


def table(entries: Mapping[str, Schema], required: Iterable[str] = ()) -> Schema:
    """A table of these entries and no others."""
    schema: Schema = {
        "type": "object",
        "properties": dict(entries),
        "additionalProperties": False,
    }
    if names := sorted(required):
        schema["required"] = names
    return schema


def solve_schema(keys: Iterable[str]) -> Schema:
    """Table of the options of `solve`: names of methods are suggestions, others may be registered
    by users.
    """
    hints = _hints(Methods) | _hints(Options)
    entries = {}
    for key in keys:
        schema = of_type(hints.get(key, Any))
        if "enum" in schema:
            schema = {"anyOf": [schema, BY_TYPE[str]]}
        entries[key] = schema
    return table(entries)


def entries_of(kind: type[Any]) -> dict[str, Schema]:
    """Schemas of the fields of a dataclass, with their descriptions."""
    hints = _hints(kind)
    words = descriptions(kind)
    entries = {}
    for field in dataclasses.fields(kind):
        schema = dict(of_field(field.name, hints.get(field.name, Any)))
        if field.name in words:
            schema["description"] = words[field.name]
        entries[field.name] = schema
    return entries


def _hints(kind: type[Any]) -> dict[str, Any]:
    """Types of the fields; without those that are known to type checkers alone."""
    try:
        return typing.get_type_hints(kind)
    except NameError:
        return {}


def required_of(kind: type[Any]) -> list[str]:
    """Fields without a default."""
    missing = dataclasses.MISSING
    return [
        field.name
        for field in dataclasses.fields(kind)
        if field.default is missing and field.default_factory is missing
    ]


def of_field(name: str, hint: Any) -> Schema:
    """Schema of an entry: a table or several where a class stands at its place, else by its
    type.
    """
    own = of_type(hint)
    if name == "start":
        return {"type": "string", "description": "file of a solution"}
    if name not in PLACES:
        return own
    place = PLACES[name]
    tables: list[Schema] = [{"$ref": f"#/$defs/{name}"}]
    if not isinstance(place, type):
        tables = [{"$ref": f"#/$defs/{name}.{kind}"} for kind in place]
    if name == "bodies":
        tables = [*half_spaces(), *tables]
    if name in ("bodies", "thermal"):
        either: Schema = {"anyOf": [*tables, {"const": "rigid"}]}
        tables.append(table({"upper": either, "lower": either}, ["upper", "lower"]))
    if name in ("layers", "loads", "carried", "factors"):
        tables.append({"type": "array", "items": {"anyOf": [*tables, BY_TYPE[str], NUMBER]}})
    return {"anyOf": [*_plain_alternatives(own), *tables]}


def _plain_alternatives(own: Schema) -> list[Schema]:
    """Alternatives of a type that are numbers, arrays, words or files."""
    return [each for each in own.get("anyOf", [own]) if each]


def _of_kind(name: str, kind: type[Any]) -> Schema:
    """The table of a class that stands at a place by its kind."""
    entries = {"kind": {"const": name}, **entries_of(kind)}
    if kind is SampledDistance:
        entries["smoothing"] = {"type": "number", "description": "wavelength"}
    return table(entries, ["kind", *required_of(kind)])


def half_spaces() -> list[Schema]:
    """Tables of G or E, and nu: numbers, or pairs of both bodies."""
    either: Schema = {"anyOf": [NUMBER, {"type": "array", "items": NUMBER}]}
    words = {"G": "shear modulus", "E": "Young's modulus", "nu": "Poisson's ratio"}
    entries = {name: {"description": text, **either} for name, text in words.items()}
    return [table({name: entries[name], "nu": entries["nu"]}, [name, "nu"]) for name in ("G", "E")]


def of_type(hint: Any) -> Schema:
    """Schema of a type: numbers may be arrays or files where arrays may be given."""
    if hint in BY_TYPE:
        return BY_TYPE[hint]
    origin = typing.get_origin(hint)
    if origin is Literal:
        return {"enum": list(typing.get_args(hint))}
    if origin in (Union, types.UnionType):
        alternatives = [of_type(each) for each in typing.get_args(hint) if each is not type(None)]
        if len(alternatives) == 1:
            return alternatives[0]
        return {"anyOf": _flat(alternatives)}
    if origin in (tuple, list, collections.abc.Sequence):
        return {"type": "array"}
    return ANY


def _flat(alternatives: Iterable[Schema]) -> list[Schema]:
    flat: list[Schema] = []
    for each in alternatives:
        flat += each.get("anyOf", [each])
    return [each for k, each in enumerate(flat) if each not in flat[:k]]


def descriptions(kind: type[Any]) -> dict[str, str]:
    """Descriptions of parameters from the docstring of a class, by parameter name."""
    lines = (inspect.getdoc(kind) or "").splitlines()
    words: dict[str, str] = {}
    names: list[str] = []
    for line in lines:
        if " : " in line and not line.startswith(" "):
            names = [each.strip() for each in line.split(" : ")[0].split(",")]
            words |= dict.fromkeys(names, "")
        elif line.startswith("    ") and names:
            for name in names:
                words[name] = f"{words[name]} {line.strip()}".strip()
        else:
            names = []
    return {name: text for name, text in words.items() if text}
