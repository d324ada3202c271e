"""Sources of profiles: files, in two columns or of SIMPACK and MiniProf; the
wheel S1002 and the rail 60E1.

The dimensions of both are in `varcontact/data/profiles.toml`.
"""

from __future__ import annotations

import math
import re
import tomllib
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Callable
from importlib.resources import files
from itertools import pairwise, takewhile
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
from numpy.polynomial.polynomial import polyval

from varcontact import checks
from varcontact.errors import DoubtfulProfile, SceneError, shortened, warn
from varcontact.system.files import first_line, regular

Kind = Literal["rail", "wheel"]
KINDS = ("rail", "wheel")
FORMATS = (
    "two columns y and z (.txt, .csv, .dat), SIMPACK (.prr of rails, .prw of wheels), "
    "MiniProf (.ban of rails, .whl of wheels, .mpt)"
)
COLUMNS = (".txt", ".csv", ".dat")
Z_UP = (".ban", ".mpt")
"""Formats in which rails usually have z up."""
KIND_OF: dict[str, Kind] = {".prr": "rail", ".prw": "wheel", ".ban": "rail", ".whl": "wheel"}
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][-+]?\d+)?$")
WITH_COMMA = re.compile(r"[-+]?\d+,\d+(?:[eEdD][-+]?\d+)?$")
SECTION = re.compile(r"\[Profile\d+Points\]$", re.IGNORECASE)
MIRROR_Z = re.compile(r"^\s*mirror\.z\s*=", re.MULTILINE)
"""Keyword of SIMPACK's header that states the direction of z: `_changed` follows it."""
DIRECTION_OF_Z = re.compile(r"\bz (up|down)\b(?!\.?\w|[ \t]+\w)", re.IGNORECASE)
"""Statement of the direction of z, at the end of a phrase: "z up to 8 mm" is none."""
POINT_COUNT = re.compile(r"^[ \t]*XYPoints[ \t]*=[ \t]*(\d{1,9})\b", re.MULTILINE)
"""Pattern of the number of points in MiniProf's header."""
COUNTED = 0.95
"""Part of the announced points below which a file is probably truncated; files in use have 0.96 and
more."""
UNIT = re.compile(r"\[.*?\]|\(.*?\)|_mm\b")
"""Units behind the names of columns."""
QUOTED_COMMA = re.compile(r'"\s*([-+]?\d+),(\d+)\s*"')
"""A number with a decimal comma, in quotes because commas separate the columns."""
NO_SECOND = re.compile(r"[^;\s]+\s*;\s*;|[^,\s]+\s*,\s*,")
"""A line whose second column is empty."""
NO_NUMBER = re.compile(r"[-+]?(?:nan|inf|infinity)$", re.IGNORECASE)
CHANGES = {
    **dict.fromkeys(("shift.y", "shift.z", "rotate", "mirror.y", "mirror.z"), 0.0),
    **dict.fromkeys(("bound.y.min", "bound.y.max", "bound.z.min", "bound.z.max"), 0.0),
    "units.len.f": 1000.0,
    "units.ang.f": 1.0,
}
"""Keywords of SIMPACK's header that change its points, with their default values."""


def read_points(path: str | Path, kind: str | None) -> tuple[np.ndarray, Kind, bool | None]:
    """Points (y, z) of a profile, shape (n, 2), in mm by the file's header; its kind; True if it
    says that their z points up, False if down, None if it says neither.
    """
    file = checks.file_name("path", path)
    suffix = file.suffix.lower()
    if suffix not in (*COLUMNS, ".mpt", *KIND_OF):
        raise SceneError(
            "path", str(path), message=f"{file.name}: unknown format; known formats are {FORMATS}"
        )
    if kind is None and suffix not in KIND_OF:
        raise SceneError("kind", None, f'given: "rail" or "wheel"; {file.name} does not show it')
    kind = cast(Kind, checks.choice("kind", kind or KIND_OF[suffix], KINDS))
    if KIND_OF.get(suffix, kind) != kind:
        reason = f"kind = {kind!r}, but by its suffix {file.name} is a {KIND_OF[suffix]}'s"
        raise SceneError("kind", kind, message=reason)
    if not regular(file):
        raise SceneError(
            "path", str(file), message=f"path {shortened(str(file), 200)} is not a regular file"
        )
    text = _text_of(file)
    points = READERS[suffix](file.name, text.splitlines())
    if len(points) == 0:
        raise SceneError(
            "path", str(path), message=f"{file.name} has no points; known formats are {FORMATS}"
        )
    count = POINT_COUNT.search(text)
    if count and len(points) < COUNTED * int(count[1]):
        words = (
            f"{file.name}: XYPoints = {count[1]}, but there are {len(points)} points; "
            "the file is probably cut off"
        )
        warn(words, DoubtfulProfile)
    return np.array(points), kind, _z_up(text)


def _z_up(text: str) -> bool | None:
    """What a file says of z: the keyword of SIMPACK, or its last statement in words, which follows
    the profile's name in files of varcontact.
    """
    if MIRROR_Z.search(text):
        return False
    statements = DIRECTION_OF_Z.findall(text)
    if not statements:
        return None
    return bool(statements[-1].lower() == "up")


def _text_of(file: Path) -> str:
    try:
        content = file.read_bytes()
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = f"path {shortened(str(file), 200)} cannot be read ({first_line(error)})"
        raise SceneError("path", str(file), message=reason) from None
    encoding = "utf-8-sig"
    if content.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        encoding = "utf-16"
    try:
        return content.decode(encoding)
    except UnicodeDecodeError:  # a header in an old Windows encoding
        return content.decode("cp1252", errors="replace")


def _words(line: str) -> list[str]:
    """The words of a line. Commas separate them, unless blanks, semicolons or commas with blanks do
    and the others are decimal.
    """
    line = line.replace("\N{MINUS SIGN}", "-")
    spaced = re.split(r"\s*,\s+", line.strip().strip(";,"))
    if len(spaced) > 1 and all(WITH_COMMA.match(word) for word in spaced):
        return [word.replace(",", ".") for word in spaced]
    words = re.split(r"[;\s]+", line.strip().strip(";"))
    decimal = [WITH_COMMA.match(word) is not None for word in words]
    if len(words) > 1 and "." not in line and any(decimal):
        return [
            word.replace(",", ".") if with_comma else word
            for word, with_comma in zip(words, decimal, strict=True)
        ]
    return re.split(r"[,;\s]+", line.strip().strip(",;"))


def _numbers(line: str) -> list[float] | None:
    """The numbers of a line, or None where it has anything else."""
    words = _words(line)
    numbers = _leading_numbers(words)
    if len(numbers) < len(words):
        return None
    return numbers


def _leading_numbers(words: list[str]) -> list[float]:
    """The numbers before the first word that is none."""
    numbers = takewhile(NUMBER.match, words)
    return [float(word.translate(str.maketrans("dD", "ee"))) for word in numbers]


def _not_a_point(name: str, number: int, text: str) -> SceneError:
    return SceneError(
        "path",
        name,
        message=f"{name}, line {number}: two numbers, y and z, are needed, not {text!r}",
    )


def _columns(name: str, lines: list[str]) -> list[list[float]]:
    """Two columns below lines with words, which are headings, or three, the first of which counts
    the points. Headings may name z before y.

    Remarks are words behind the numbers, and all that follows a comment mark.
    """
    points: list[list[float]] = []
    headings: list[str] = []
    first = None  # the number of the first point, where points are counted
    for number, line in enumerate(lines, 1):
        text = QUOTED_COMMA.sub(r" \1.\2 ", re.split("[!#%]", line)[0]).replace('"', " ").strip()
        if not text.strip(";, \t"):
            continue
        values = _leading_numbers(_words(text)) or [math.nan]
        if len(values) == 3 and not points and values[0] in (0, 1):
            first = values[0]
        if first is not None and values[0] == first + len(points):
            values = values[1:]
        if len(values) == 2 and not NO_SECOND.match(text):
            points.append(values)
        elif points or not _is_heading(text):
            raise _not_a_point(name, number, line.strip())
        else:
            headings.append(text)
    if _z_first(headings):
        return [[y, z] for z, y in points]
    return points


def _z_first(headings: list[str]) -> bool:
    """True if the last heading that is a list of names of columns has z before y, each of them
    among the first three.
    """
    for text in reversed(headings):
        names = re.split(r"\s*[,;\t]\s*", UNIT.sub("", text).strip().lower())
        if len(names) == 1:
            names = names[0].split()
        for pair in pairwise(names[:3]):
            if sorted(pair) == ["y", "z"]:
                return pair == ("z", "y")
    return False


def _is_heading(text: str) -> bool:
    """True if a line contains words other than numbers, NaN and infinity."""
    return not all(NUMBER.match(word) or NO_NUMBER.match(word) for word in _words(text))


def _simpack(name: str, lines: list[str]) -> list[list[float]]:
    """Points between point.begin and point.end, changed by the keywords before them."""
    header = dict(CHANGES)
    points: list[list[float]] = []
    inside = False
    for number, line in enumerate(lines, 1):
        text = re.split("[!%]", line)[0].strip()
        if text in ("point.begin", "point.end"):
            inside = text == "point.begin"
        elif inside and text:
            values = _numbers(text)
            if values is None or len(values) < 2:
                raise _not_a_point(name, number, text)
            points.append(values[:2])
        elif "=" in text:
            key, value = (part.strip().strip("'\"") for part in text.split("=", 1))
            if key in header:
                header[key] = _keyword(f"{name}, line {number}: {key}", value, key)
    if inside:
        reason = f"{name} is cut off: point.end, after the last point, is missing"
        raise SceneError("path", name, message=reason)
    return _changed(np.array(points).reshape(-1, 2), header).tolist()


def _keyword(where: str, text: str, key: str) -> float:
    """The value of a keyword of SIMPACK's header, positive if it is a unit."""
    positive = key.startswith("units")
    numbers = _numbers(text.replace(",", "."))  # one number: a comma is decimal
    if numbers is None or len(numbers) != 1 or (positive and numbers[0] <= 0):
        allowed = "a positive number" if positive else "a number"
        raise SceneError("path", text, message=f"{where} must be {allowed}, not {text!r}")
    return numbers[0]


def _changed(points: np.ndarray, header: dict[str, float]) -> np.ndarray:
    """Points in mm after shifts, rotation, bounds and mirrors of a header; their unit of length is
    a metre divided by units.len.f.
    """
    points = points + np.array([header["shift.y"], header["shift.z"]])
    turn = header["rotate"] / header["units.ang.f"]
    points = points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    for column, axis in enumerate("yz"):
        low = header[f"bound.{axis}.min"]
        high = header[f"bound.{axis}.max"]
        if low < high:
            points = points[(points[:, column] >= low) & (points[:, column] <= high)]
    signs = [-1.0 if header[f"mirror.{axis}"] else 1.0 for axis in "yz"]
    return points * signs * (1000.0 / header["units.len.f"])


def _miniprof(name: str, lines: list[str]) -> list[list[float]]:
    """Columns X and Y, in the places that ColumnDef names, below a header; remarks begin with a
    comment mark.
    """
    texts = [re.split('["!%#]', line)[0].strip() for line in lines]
    columns = _column_names(texts)
    rows: list[list[float]] = []
    for number, text in list(enumerate(texts, 1))[_header_end(lines) :]:
        numbers = text
        if columns:  # words after the numbers of all columns are a remark
            numbers = " ".join(_words(text)[: len(columns)])
        values = _numbers(numbers) or []
        if len(values) >= 2:
            rows.append(values)
        elif text and rows and "=" not in text:
            raise _not_a_point(name, number, lines[number - 1].strip())
    return _x_and_y(name, rows, columns or ["X", "Y"])


def _column_names(texts: list[str]) -> list[str]:
    """Names of columns in MiniProf's last ColumnDef, if there is one."""
    definitions = [text.partition("=")[2] for text in texts if re.match(r"ColumnDef\s*=", text)]
    if not definitions:
        return []
    return [word.strip().upper() for word in definitions[-1].split(",")]


def _x_and_y(name: str, rows: list[list[float]], columns: list[str]) -> list[list[float]]:
    """The numbers in the columns X and Y."""
    places = [columns.index(each) for each in "XY" if each in columns]
    if len(places) < 2 or any(len(values) <= max(places) for values in rows):
        reason = f"{name}: X and Y are needed in each line, and ColumnDef = {','.join(columns)}"
        raise SceneError("path", name, message=reason)
    return [[values[k] for k in places] for values in rows]


def _header_end(lines: list[str]) -> int:
    """Number of lines of a header that ends with words and a blank line, and has numbers in one
    line at most.
    """
    blank = next((k for k, line in enumerate(lines) if not line.strip()), 0)
    numbers = [_numbers(line) is not None for line in lines[:blank]]
    if blank and not numbers[-1] and sum(numbers) <= 1:
        return blank
    return 0


def _miniprof_template(name: str, lines: list[str]) -> list[list[float]]:
    """The points of a file's only profile."""
    sections = [number for number, line in enumerate(lines) if SECTION.match(line.strip())]
    if len(sections) > 1:
        reason = (
            f"{name} has {len(sections)} profiles: "
            "copy the lines of each into a file .ban, or .whl, of its own"
        )
        raise SceneError("path", name, message=reason)
    return _miniprof(name, [line for line in lines if not line.strip().startswith("[")])


READERS: dict[str, Callable[[str, list[str]], list[list[float]]]] = {
    **dict.fromkeys(COLUMNS, _columns),
    **dict.fromkeys((".prr", ".prw"), _simpack),
    **dict.fromkeys((".ban", ".whl"), _miniprof),
    ".mpt": _miniprof_template,
}


def s1002(step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the wheel profile S1002.

    Parameters
    ----------
    step : float
        Distance of the points along the profile, nearly [mm].

    Returns
    -------
    y, z : ndarray, shape (n,)
        From the flange's back to the outside; z down, 0 on the running circle
        [mm].

    Examples
    --------
    >>> y, z = s1002(0.25)
    >>> print(f"{z.max():.2f} {np.interp(10.0, y, z):.4f}")
    28.00 -0.2084
    """
    dimensions = _standards()["s1002"]
    sections = [
        _arc(each["ends"], each["centre"], each["radius"], step) for each in dimensions["arcs"]
    ]
    for each in dimensions["polynomials"]:
        first, last = each["ends"]
        y = np.linspace(first, last, max(2, int(np.ceil((last - first) / step)) + 1))
        sections.append(np.array([y, polyval(y, each["coefficients"])]))
    y, z = _joined(sorted(sections, key=lambda section: float(section[0, 0])))
    return y, z


def rail_60e1(step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points of the head of the rail profile 60E1, upright (not inclined).

    Parameters
    ----------
    step : float
        As of `s1002`.

    Returns
    -------
    y, z : ndarray, shape (n,)
        From one flank to the other; z down from the top [mm].

    Examples
    --------
    >>> y, z = rail_60e1(0.25)
    >>> print(f"{z.min():.1f} {np.interp(14.3, z[y > 0], y[y > 0]):.2f}")
    0.0 36.00
    """
    dimensions = _standards()["60e1"]
    # arcs from the top to the flank
    radii = dimensions["radii"]
    centre = np.array([0.0, radii[0]])
    start = 0.0
    half = []
    for radius, full, smaller in zip(radii, dimensions["widths"], (*radii[1:], 0.0), strict=True):
        width = full / 2
        half.append(_arc([start, width], centre, -radius, step))
        turned = np.arcsin((width - centre[0]) / radius)
        # the next arc's centre lies on the same radius: tangents meet
        centre = centre + (radius - smaller) * np.array([np.sin(turned), -np.cos(turned)])
        start = width
    # the flank
    y0, z0 = half[-1][:, -1]
    deepest = dimensions["flank_depth"]
    z = np.linspace(z0, deepest, max(2, round((deepest - z0) / step)))
    half.append(np.array([y0 + (z - z0) / dimensions["flank_slope"], z]))
    y, z = _joined(half)
    return np.concatenate([-y[:0:-1], y]), np.concatenate([z[:0:-1], z])


def _standards() -> dict[str, Any]:
    """The dimensions of both profiles."""
    return tomllib.loads(
        files("varcontact.data").joinpath("profiles.toml").read_text(encoding="utf-8")
    )


def _arc(between: Any, centre: Any, radius: float, step: float) -> np.ndarray:
    """Points of an arc between two y, below its centre (larger z) for a positive radius, above it
    for a negative.
    """
    ends = np.arcsin((np.array(between) - centre[0]) / abs(radius))
    intervals = int(np.ceil(abs(radius * (ends[1] - ends[0])) / step))
    angles = np.linspace(ends[0], ends[1], max(2, intervals + 1))
    return np.array([centre[0] + abs(radius) * np.sin(angles), centre[1] + radius * np.cos(angles)])


def _joined(sections: list[np.ndarray]) -> np.ndarray:
    """Sections one after the other; where two meet, the point of the second."""
    return np.concatenate([*(each[:, :-1] for each in sections[:-1]), sections[-1]], axis=1)
