"""Profiles as text: two columns, and the files of SIMPACK and MiniProf."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from varcontact.wheel_rail.profile_files import Kind

SIMPACK = """! SIMPACK rail-wheel profile, written by varcontact
header.begin
  version       = 1
  type          = {type}  ! 0 = rail profile, 1 = wheel profile
header.end
spline.begin
  approx.smooth = 0.0
  comment       = '{name}'
  units.len.f   = 1000.0  ! units of length in a metre
  mirror.y      = 0
  mirror.z      = 0
  point.begin
{points}
  point.end
spline.end
"""

MINIPROF = """Filename={name}
ProgramName=varcontact
Comment={comment}
XYPoints={count}
ColumnDef=X,Y

{points}
"""
"""Template of a MiniProf file: rails with z up, wheels with z down, as MiniProf measures them."""


def endings_of(kind: Kind) -> tuple[str, ...]:
    """Endings of the files of a rail's or a wheel's profile."""
    if kind == "rail":
        return (".csv", ".txt", ".prr", ".ban")
    return (".csv", ".txt", ".prw", ".whl")


def written(points: np.ndarray, kind: Kind, name: str, ending: str) -> str:
    """The text of a file of points, shape (n, 2), z down [mm]."""
    return WRITERS[ending](points, kind, name or kind)


def _csv(points: np.ndarray, kind: Kind, name: str) -> str:
    return f"# {name}: y to the outside, z down [mm]\n" + _rows(points, ",") + "\n"


def _contact(points: np.ndarray, kind: Kind, name: str) -> str:
    return f"% {name}: y to the outside, z down [mm]\n" + _rows(points, "  ") + "\n"


def _simpack(points: np.ndarray, kind: Kind, name: str) -> str:
    number = {"rail": 0, "wheel": 1}[kind]
    return SIMPACK.format(type=number, name=name.replace("'", " "), points=_rows(points, "  "))


def _miniprof(points: np.ndarray, kind: Kind, name: str) -> str:
    comment = "z down [mm]"
    if kind == "rail":
        comment = "z up [mm]"
        points = points * [1.0, -1.0]
    text = _rows(points, "\t")
    return MINIPROF.format(name=name, comment=comment, count=len(points), points=text)


def _rows(points: np.ndarray, between: str) -> str:
    return "\n".join(f"{y:.10g}{between}{z:.10g}" for y, z in points.tolist())


WRITERS: dict[str, Callable[[np.ndarray, Kind, str], str]] = {
    ".csv": _csv,
    ".txt": _contact,
    ".prr": _simpack,
    ".prw": _simpack,
    ".ban": _miniprof,
    ".whl": _miniprof,
}
