"""TOML files as tables: reading and checking of entries; every error names the entry."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.system.files import SCENE_BYTES, first_line, regular, text_of

MOST_VALUES = 1_000_000
"""Largest number of values of an entry that varies."""


def read_toml(path: str | Path, kind: str) -> tuple[dict[str, Any], Path]:
    """A file as nested dictionaries, and its folder."""
    import tomllib

    path = checks.file_name("path", path)
    text = text_of(kind, path, SCENE_BYTES, "a TOML file")
    try:
        return tomllib.loads(text), path.parent
    except (RecursionError, ValueError) as error:  # also for a number of thousands of digits
        message = f"{kind} {str(path)!r} is not a TOML file ({first_line(error)})"
        raise SceneError(kind, str(path), "a TOML file", message=message) from None


def table_of(name: str, value: Any) -> Mapping[str, Any]:
    """Value of an entry that must be a table."""
    if not isinstance(value, Mapping):
        raise SceneError(name, value, f"a table, [{name}]")
    return value


def needed(name: str, table: Mapping[str, Any], key: str) -> Any:
    """Value of an entry that must be present."""
    if key not in table:
        raise SceneError(f"{name}.{key}", None, "given")
    return table[key]


def check_keys(
    name: str, table: Mapping[str, Any], known: Iterable[str], taken: Iterable[str] = ()
) -> None:
    """Refuse unknown keys; the error suggests the nearest key that may be given, or lists all of
    them if none is near. They include those already `taken` out of the table.
    """
    for key in table:
        if key not in known:
            field = f"{name}.{key}" if name else key
            there_are = (*known, *taken)
            hint = checks.nearest(key, there_are) or f"; there are {', '.join(there_are)}"
            raise SceneError(
                field, table[key], "left out", message=f"{field}: there is no such key{hint}"
            )


def make(name: str, kind: type[Any], entries: Mapping[str, Any]) -> Any:
    """A dataclass from a table of its fields."""
    fields = dataclasses.fields(kind)
    check_keys(name, entries, [f.name for f in fields])
    for f in fields:
        if f.default is dataclasses.MISSING:
            needed(name, entries, f.name)
    return kind(**entries)


def kind_named(name: str, given: Any, kinds: Iterable[str]) -> str:
    """Kind of a table by its name, in any case, with hyphens or underscores."""
    written = {kind.replace("_", "-"): kind for kind in kinds}
    if isinstance(given, str):
        given = written.get(given.lower().replace("_", "-"), given)
    return checks.choice(f"{name}.kind", given, list(written.values()))


@contextmanager
def named_as(field: str, own: str) -> Iterator[None]:
    """Errors of entries that name the `field` of their table, not the `own` name of its class."""
    try:
        yield
    except SceneError as error:
        if not error.field.startswith(f"{own}.") or error.field.startswith(field):
            raise
        written = field + error.field.removeprefix(own)
        message = str(error).replace(error.field, written, 1)
        raise SceneError(written, error.value, error.allowed, message=message) from None


def number_range(field: str, table: Mapping[str, Any]) -> list[float]:
    """Numbers ``{from = 0.0, to = 3e-3, count = 7}``; with ``spacing = "log"`` by equal ratios."""
    check_keys(field, table, ("from", "to", "count", "spacing"))
    first, last = (
        checks.number(f"{field}.{name}", needed(field, table, name)) for name in ("from", "to")
    )
    count = checks.whole(f"{field}.count", needed(field, table, "count"), least=2, most=MOST_VALUES)
    if (
        checks.choice(f"{field}.spacing", table.get("spacing", "linear"), ("linear", "log"))
        == "linear"
    ):
        return np.linspace(first, last, count).tolist()
    if first * last <= 0:
        raise SceneError(
            f"{field}.from",
            first,
            'of the same sign as "to", and neither zero, for spacing = "log"',
        )
    return np.geomspace(first, last, count).tolist()


def file_named(field: str, value: Any, folder: Path | None) -> Path:
    """File named in another file, relative to that file's folder; refused if it is not a regular
    file.
    """
    if folder is None:
        raise SceneError(
            field,
            value,
            "numbers",
            message=f"{field}: only scene files may name files, stored ones not",
        )
    if not isinstance(value, str):
        raise SceneError(field, value, "the name of a file")
    path = folder / value
    try:
        if not regular(path):
            raise SceneError(field, value, "the name of a regular file")
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise SceneError(field, value, f"the name of a file ({first_line(error)})") from None
    return path
