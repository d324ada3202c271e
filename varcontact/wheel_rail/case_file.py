"""Wheels on rails as TOML files: one position, or a sequence of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.scene_toml import bodies_from, solve_table
from varcontact.io.toml_tables import check_keys, file_named, make, needed, number_range, read_toml, table_of
from varcontact.scene.friction import LAWS
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_points import Kind
from varcontact.wheel_rail.track import Position, Side, Track, Velocity, WheelSet
from varcontact.wheel_rail.wear import Archard
from varcontact.wheel_rail.wheel_on_rail import STEEL, WheelOnRail

PLAIN = ("side", "vertical_force", "z", "with_friction", "friction", "dx", "dy", "join", "separate", "turn")
TABLES = ("track", "wheelset", "position", "velocity", "bodies", "solve", "wear")
NAMED = {"rail": ("60e1", Profile.rail_60e1), "wheel": ("s1002", Profile.s1002)}
READ = ("file", "mirror_y", "mirror_z", "scale", "smoothing", "kinks")
SIDES: dict[str, tuple[Side, ...]] = {"left": ("left",), "right": ("right",), "both": ("left", "right")}
SOLVED = (
    *("method", "normal", "tangential", "coupling", "formulation", "tol", "certify", "refine"),
    *("accuracy", "time_budget"),
)


@dataclass(frozen=True, eq=False)
class CaseFile:
    """What a case file says.

    Attributes
    ----------
    cases : tuple of WheelOnRail
        Position by position; of both sides, the left wheel first.
    numbers : tuple of int
        The number of each case's position, from 1.
    options : dict
        Keywords of `WheelOnRail.solve`.
    archard : Archard or None
        From the table ``[wear]``.
    """

    cases: tuple[WheelOnRail, ...]
    numbers: tuple[int, ...]
    options: dict[str, Any]
    archard: Archard | None


def read_case(path: str | Path) -> CaseFile:
    """Read the case of a wheel on a rail, or a sequence of positions.

    Parameters
    ----------
    path : str or Path
        A TOML file with the entries of `WheelOnRail`, in mm, N, rad and mm/s. ``track.rail`` and ``wheelset.wheel`` are
        "60e1", "s1002", the name of a file beside this one, or a table with ``file`` and options of `Profile.read`.
        ``side`` may be "both". Numbers in ``[position]`` and ``[velocity]``, ``vertical_force`` and ``z`` may be lists
        of one length, or ranges ``{from, to, count}``: the sequence.

    Returns
    -------
    CaseFile

    Raises
    ------
    SceneError
        If the file cannot be read, or says something a case cannot be.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "case.toml"
    >>> _ = path.write_text('''
    ... vertical_force = 80e3
    ... track = { rail = "60e1", cant = 0.025 }
    ... wheelset = { wheel = "s1002" }
    ... position = { y = [0.0, 2.0, 4.0], yaw = { from = 0.0, to = 0.01, count = 3 } }
    ... ''')
    >>> [case.position.yaw for case in read_case(path).cases]
    [0.0, 0.005, 0.01]
    >>> folder.cleanup()
    """
    table, folder = read_toml(path, "case file")
    options = solve_table(table)
    check_keys("solve", options, SOLVED)
    check_keys("", table, (*PLAIN, *TABLES))
    for name in ("track", "wheelset"):
        if name not in table:
            raise SceneError(name, None, f"given: add a table [{name}]")
    sides = SIDES[checks.choice("side", table.pop("side", "right"), SIDES)]
    archard = make("wear", Archard, table_of("wear", table.pop("wear"))) if "wear" in table else None
    entries = _entries(table, folder)
    count, sequences = _sequences(entries)
    cases, numbers = [], []
    for k in range(count):
        here = {name: value[k] if name in sequences else value for name, value in entries.items()}
        position, velocity = (_group(kind, here) for kind in (Position, Velocity))
        plain = {name: value for name, value in here.items() if "." not in name}
        cases += [WheelOnRail(side=side, position=position, velocity=velocity, **plain) for side in sides]
        numbers += [k + 1] * len(sides)
    return CaseFile(tuple(cases), tuple(numbers), options, archard)


def _entries(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Track, wheel set, bodies and law of friction made; entries of position and velocity by dotted names."""
    found = {name: table[name] for name in PLAIN if name in table}
    found["track"] = _placed("track", Track, "rail", table["track"], folder)
    found["wheelset"] = _placed("wheelset", WheelSet, "wheel", table["wheelset"], folder)
    found["bodies"] = bodies_from(table_of("bodies", table["bodies"])) if "bodies" in table else STEEL
    if isinstance(table.get("friction"), Mapping):
        law = dict(table["friction"])
        found["friction"] = make("friction", LAWS[checks.choice("friction.kind", law.pop("kind", None), LAWS)], law)
    for kind in (Position, Velocity):
        name = kind.__name__.lower()
        given = table_of(name, table.get(name, {}))
        check_keys(name, given, [field.name for field in dataclasses.fields(kind)])
        found |= {f"{name}.{key}": value for key, value in given.items()}
    return found


def _placed(name: str, kind: type[Any], key: str, table: Any, folder: Path) -> Any:
    """Track or wheel set, with its profile read."""
    entries = dict(table_of(name, table))
    field = f"{name}.{key}"
    entries[key] = _profile(field, cast(Kind, key), needed(name, entries, key), folder)
    return make(name, kind, entries)


def _profile(field: str, kind: Kind, value: Any, folder: Path) -> Profile:
    """A profile by its name, by the name of its file, or by a table."""
    table = dict(value) if isinstance(value, Mapping) else {"file": value}
    check_keys(field, table, READ)
    name, (known, known_profile) = needed(field, table, "file"), NAMED[kind]
    if isinstance(name, str) and name.lower() == known:
        if len(table) > 1:
            raise SceneError(field, value, message=f"{field}: {name} has no options, give its name alone")
        return known_profile()
    allowed = f'the name of a file beside the case file, or "{known}"'
    path = file_named(f"{field}.file", table.pop("file"), folder) if isinstance(name, str) else None
    if path is None or not path.is_file():
        raise SceneError(field, name, allowed)
    return Profile.read(path, kind, **table)


def _sequences(entries: dict[str, Any]) -> tuple[int, list[str]]:
    """How many positions there are, and which entries vary; ranges are written out."""
    lengths = {}
    for name, value in entries.items():
        if "." in name or name in ("vertical_force", "z"):
            if isinstance(value, Mapping):
                entries[name] = number_range(name, value)
            if isinstance(entries[name], list):
                checks.numbers(name, entries[name])
                lengths[name] = len(entries[name])
    if not lengths:
        return 1, []
    if len(set(lengths.values())) > 1 or 0 in lengths.values():
        given = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        raise SceneError(
            "sequence", given, message=f"lists of a sequence must have the same length, one or more: {given}"
        )
    return next(iter(lengths.values())), list(lengths)


def _group(kind: type[Any], entries: Mapping[str, Any]) -> Any:
    """Position or velocity from entries by dotted names."""
    prefix = f"{kind.__name__.lower()}."
    return kind(**{name.removeprefix(prefix): value for name, value in entries.items() if name.startswith(prefix)})
