"""Profiles from files: two columns, SIMPACK's .prr and .prw, MiniProf's .ban and .whl."""

from __future__ import annotations

import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
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
WITH_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eEdD][-+]?\d+)?$")
NO_NUMBER = re.compile(r"[-+]?(?:nan|inf|infinity)$", re.IGNORECASE)
SAID = (
    *("shift.y", "shift.z", "rotate", "mirror.y", "mirror.z", "units.len.f", "units.ang.f"),
    *("bound.y.min", "bound.y.max", "bound.z.min", "bound.z.max"),
)
"""Keywords of SIMPACK's header that change its points."""


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
    if content.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return content.decode("utf-16", errors="replace").splitlines()
    try:
        return content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace").splitlines()


def _words(line: str) -> list[str]:
    """The words of a line. Commas separate them, unless blanks or semicolons do and the commas are decimal."""
    line = line.replace("\N{MINUS SIGN}", "-")
    words = re.split(r"[;\s]+", line.strip().strip(";"))
    if len(words) > 1 and "." not in line and any(WITH_COMMA.match(word) for word in words):
        return [word.replace(",", ".") if WITH_COMMA.match(word) else word for word in words]
    return re.split(r"[,;\s]+", line.strip().strip(",;"))


def _numbers(line: str) -> list[float] | None:
    """The numbers of a line, or None where it has anything else."""
    words = _words(line)
    if not all(NUMBER.match(word) for word in words):
        return None
    return [float(word.translate(str.maketrans("dD", "ee"))) for word in words]


def _not_a_point(name: str, number: int, text: str) -> SceneError:
    return SceneError("path", name, message=f"{name}, line {number}: two numbers, y and z, are needed, not {text!r}")


def _columns(name: str, lines: list[str]) -> list[list[float]]:
    """Two columns below lines with words, which are headings; remarks begin with a mark of comments."""
    points = []
    for number, line in enumerate(lines, 1):
        text = re.split("[!#%]", line)[0].replace('"', " ").strip()
        values = _numbers(text)
        if values is not None and len(values) == 2:
            points.append(values)
        elif text and (points or all(NUMBER.match(word) or NO_NUMBER.match(word) for word in _words(text))):
            raise _not_a_point(name, number, line.strip())
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
                raise _not_a_point(name, number, text)
            points.append(values[:2])
        elif "=" in text:
            key, value = (part.strip().strip("'\"") for part in text.split("=", 1))
            if key in SAID:
                said[key] = _said(f"{name}, line {number}: {key}", value, positive=key.startswith("units"))
    return _as_simpack_says(np.array(points).reshape(-1, 2), said).tolist()


def _said(where: str, value: str, positive: bool) -> float:
    """The number of a keyword."""
    found = _numbers(value)
    if found is None or len(found) != 1 or (positive and found[0] <= 0):
        raise SceneError("path", value, message=f"{where} must be a{' positive' * positive} number, not {value!r}")
    return found[0]


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
    for number, line in enumerate(lines, 1):
        text = line.strip()
        if not text or text.startswith(('"', "!", "%", "#")):
            continue
        key, equals, value = text.partition("=")
        if equals and key.strip() == "ColumnDef":
            columns = [word.strip().upper() for word in value.split(",")]
        values = _numbers(text)
        if values is not None and len(values) >= 2:
            points.append(values)
        elif points and not equals:
            raise _not_a_point(name, number, text)
    for wanted in ("X", "Y"):
        if wanted not in columns:
            raise SceneError("path", name, message=f"{name}: ColumnDef = {','.join(columns)} has no column {wanted}")
    x, y = columns.index("X"), columns.index("Y")
    if any(len(values) <= max(x, y) for values in points):
        raise SceneError("path", name, message=f"{name}: lines have fewer columns than ColumnDef names")
    return [[values[x], values[y]] for values in points]
