"""Profiles from files: two columns, SIMPACK's .prr and .prw, MiniProf's .ban and .whl."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, shortened

KNOWN = (
    "two columns y and z (.txt, .csv, .dat), SIMPACK (.prr of rails, .prw of wheels), MiniProf (.ban of rails, "
    ".whl of wheels)"
)
COLUMNS = (".txt", ".csv", ".dat")
KIND_OF = {".prr": "rail", ".prw": "wheel", ".ban": "rail", ".whl": "wheel"}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?$")


@dataclass(frozen=True, eq=False)
class Found:
    """What a file says.

    Attributes
    ----------
    points : ndarray, shape (n, 2)
        y and z in millimetres, by the file's header.
    kind : str
        "rail" or "wheel".
    """

    points: np.ndarray
    kind: Literal["rail", "wheel"]


def read_points(path: str | Path, kind: str | None) -> Found:
    """Points of a profile.

    Parameters
    ----------
    path : str or Path
    kind : str or None
        What the caller says it is.

    Returns
    -------
    Found

    Raises
    ------
    SceneError
        If the file cannot be read, its format is not known or it has no points; if the kind is missing, or is not
        what the file says.
    """
    file = checks.file_name("path", path)
    suffix = file.suffix.lower()
    if suffix not in COLUMNS and suffix not in KIND_OF:
        raise SceneError("path", str(path), message=f"{file.name} is of a format that is not known; known are {KNOWN}")
    if kind is None and suffix not in KIND_OF:
        raise SceneError("kind", None, f'given: "rail" or "wheel"; {file.name} does not tell')
    kind = checks.choice("kind", kind or KIND_OF[suffix], ("rail", "wheel"))
    if suffix in KIND_OF and kind != KIND_OF[suffix]:
        raise SceneError(
            "kind", kind, message=f"kind = {kind!r}, but {file.name} is a {KIND_OF[suffix]}'s by its suffix"
        )
    lines = _lines(file)
    reader = {".prr": _simpack, ".prw": _simpack, ".ban": _miniprof, ".whl": _miniprof}.get(suffix, _columns)
    points = reader(file.name, lines)
    if len(points) == 0:
        raise SceneError("path", str(path), message=f"{file.name} has no points; known formats are {KNOWN}")
    return Found(np.array(points), cast(Literal["rail", "wheel"], kind))


def _lines(file: Path) -> list[str]:
    """The lines of a text file; names in its header may be written in the letters of old Windows."""
    try:
        content = file.read_bytes()
    except OSError as error:
        reason = f"cannot be read ({error.strerror})"
        raise SceneError("path", str(file), message=f"path {shortened(str(file), 200)} {reason}") from None
    try:
        return content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace").splitlines()


def _numbers(line: str) -> list[float] | None:
    """The numbers of a line, or None where it has anything else."""
    words = re.split(r"[,;\s]+", line.strip().strip(",;"))
    if not words or not all(NUMBER.match(word) for word in words):
        return None
    return [float(word.translate(str.maketrans("dD", "ee"))) for word in words]


def _columns(name: str, lines: list[str]) -> list[list[float]]:
    """Two columns; lines that begin with a letter or a mark of comments are headings."""
    points = []
    for number, line in enumerate(lines, 1):
        values = _numbers(line)
        if values is not None and len(values) >= 2:
            points.append(values[:2])
        elif values is not None or (points and line.strip() and line.strip()[0] not in "#!%\"'"):
            raise SceneError(
                "path", name, message=f"{name}, line {number}: two numbers, y and z, are needed, not {line.strip()!r}"
            )
    return points


def _simpack(name: str, lines: list[str]) -> list[list[float]]:
    """Points between point.begin and point.end, changed as the keywords before them say."""
    said: dict[str, float] = {}
    points: list[list[float]] = []
    inside = False
    for number, line in enumerate(lines, 1):
        text = line.split("!")[0].strip()
        if text in ("point.begin", "point.end"):
            inside = text == "point.begin"
        elif inside and text:
            values = _numbers(text)
            if values is None or len(values) < 2:
                raise SceneError(
                    "path", name, message=f"{name}, line {number}: two numbers, y and z, are needed, not {text!r}"
                )
            points.append(values[:2])
        elif "=" in text:
            key, value = (part.strip().strip("'\"") for part in text.split("=", 1))
            found = _numbers(value)
            if found:
                said[key] = found[0]
    return _as_simpack_says(np.array(points).reshape(-1, 2), said).tolist()


def _as_simpack_says(points: np.ndarray, said: dict[str, float]) -> np.ndarray:
    """Shifts, rotation, bounds, mirrors and the unit of length: metres times units.len.f."""
    points = points + np.array([said.get("shift.y", 0.0), said.get("shift.z", 0.0)])
    turn = said.get("rotate", 0.0) / said.get("units.ang.f", 1.0)
    points = points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    for column, axis in enumerate("yz"):
        low, high = said.get(f"bound.{axis}.min", 0.0), said.get(f"bound.{axis}.max", 0.0)
        if low < high:
            points = points[(points[:, column] >= low) & (points[:, column] <= high)]
    signs = [-1.0 if said.get(f"mirror.{axis}", 0.0) else 1.0 for axis in "yz"]
    return points * signs * (1000.0 / said.get("units.len.f", 1000.0))


def _miniprof(name: str, lines: list[str]) -> list[list[float]]:
    """Columns X and Y, in the places that ColumnDef names; the header has key=value or words, and ends anywhere."""
    columns = ["X", "Y"]
    points = []
    for line in lines:
        text = line.strip()
        if text.startswith(('"', "!", "%", "#")):
            continue
        key, equals, value = text.partition("=")
        if equals and key.strip() == "ColumnDef":
            columns = [word.strip().upper() for word in value.split(",")]
        values = _numbers(text)
        if values is not None and len(values) >= 2:
            points.append(values)
    for wanted in ("X", "Y"):
        if wanted not in columns:
            raise SceneError("path", name, message=f"{name}: ColumnDef = {','.join(columns)} has no column {wanted}")
    x, y = columns.index("X"), columns.index("Y")
    if any(len(values) <= max(x, y) for values in points):
        raise SceneError("path", name, message=f"{name}: lines have fewer columns than ColumnDef names")
    return [[values[x], values[y]] for values in points]
