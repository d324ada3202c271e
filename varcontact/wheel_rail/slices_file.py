"""CONTACT's files of profiles that change along a rail or around a wheel (`.slcs`, `.slcw`).

Source: Vollebregt, User guide for CONTACT, Vtech CMCC report 20-01, section 3.2
and appendix A, and the module ``m_varprof`` of the open-source release.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from varcontact.io.contact_words import Group, Lines, located
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind

TOGETHER = 1e-3
"""Spacing below which CONTACT refuses slices of rails, and the positions of their features differ
[mm].
"""
TURN_TOL = 1e-4
"""Angle by which slices may end short of a whole turn [rad]."""


@dataclass(frozen=True, eq=False)
class SlicesFile:
    """The content of a file: positions along a rail [mm] or around a wheel [rad]."""

    header: Group
    positions: np.ndarray
    profiles: tuple[Profile, ...]
    approximating: bool
    features: np.ndarray | None = None
    """Arc lengths by slice [mm]; negative where a slice lacks a feature."""
    kinks: tuple[int, ...] = ()
    """Features, from 0, at which sections have a kink."""


def read_slices_file(file: Path, kind: Kind, profile_of: Callable[[Path], Profile]) -> SlicesFile:
    """Slices from a file; the files of its profiles are searched relative to its folder."""
    lines = Lines(file)
    # the header
    offset, by_unit = lines.group("S_OFFSET", "S_SCALE").numbers()
    count = lines.read("NSLC:i").count(0)
    counts = lines.read("NFEAT:i, NKINK:i, NACCEL:i")
    approximating = _read_method(lines)
    # positions, and the profiles there
    closest = {"rail": TOGETHER, "wheel": 0.0}[kind]
    positions: list[float] = []
    profiles: list[Profile] = []
    by_name: dict[str, Profile] = {}
    for _ in range(count):
        group = lines.group("S", "a profile")
        name = group.text(1)
        positions.append(by_unit * (offset + group.number(0)))
        if len(positions) > 1 and positions[-1] - positions[-2] <= closest:
            group.refuse("S", positions[-1], f"of slice {len(positions)} is out of order")
        if name not in by_name:
            with located(group):
                by_name[name] = profile_of(file.parent / name)
        profiles.append(by_name[name])
    found = SlicesFile(counts, np.array(positions), tuple(profiles), approximating)
    number, kinks, accelerations = counts.integers()
    if number <= 1:
        return {"rail": found, "wheel": _around_wheel(found)}[kind]
    # their features
    at = _read_parts(lines, "KINK", kinks, number)
    # where the curvature jumps, splines through points .25 mm apart follow by themselves
    _read_parts(lines, "ACCEL", accelerations, number)
    rows = [_read_features(lines, number, each, by_unit, offset) for each in found.positions]
    lengths = np.array([[each.curve.s[-1]] for each in profiles])
    features = np.minimum(np.array(rows), lengths)
    if kind == "rail":
        return replace(found, features=features, kinks=at)
    # of wheels from the field side, where a profile ends here
    turned = np.where(features < 0, features, lengths - features)[:, ::-1]
    behind = tuple(number - 1 - k for k in reversed(at))
    return _around_wheel(replace(found, features=turned, kinks=behind))


def _read_method(lines: Lines) -> bool:
    """True for the approximating spline."""
    method = lines.read("S_METHOD:i, [PERTURB:i]")
    (number,) = method.integers()
    if number not in (1, 2):
        method.refuse("S_METHOD", number, "is neither 1 (interpolating) nor 2 (approximating)")
    if method.option(0, 0.0) != 0:
        why = "is not supported: waves of the surface are slices here"
        method.refuse("PERTURB", method.optional[0], why)
    return number == 2


def _read_parts(lines: Lines, name: str, count: int, features: int) -> tuple[int, ...]:
    """The features, from 0, behind parts that a line names from 1."""
    if count == 0:
        return ()
    group: Group = lines.array(name, count, "i")
    for part in group.integers():
        if not 1 <= part <= features - 2:
            group.refuse(name, part, f"is not in the range 1 to NFEAT - 2 = {features - 2}")
    return tuple(group.integers())


def _read_features(
    lines: Lines, count: int, position: float, by_unit: float, offset: float
) -> list[float]:
    """The arc lengths of a slice, behind its position."""
    group = lines.array("features", count + 1)
    own, *features = group.numbers()
    place = by_unit * (offset + own)
    if abs(place - position) >= TOGETHER:
        group.refuse("S", own, f"is not the position of the slice, {position / by_unit - offset:g}")
    return features


def _around_wheel(slices: SlicesFile) -> SlicesFile:
    """Slices of a wheel as a closed surface: within a turn, and unchanged behind the last one."""
    positions = slices.positions
    if positions[0] <= -np.pi + TURN_TOL and positions[-1] >= np.pi - TURN_TOL:
        rows = np.flatnonzero(positions < positions[0] + 2 * np.pi - TURN_TOL)
    elif positions.size == 1 or np.ptp(positions) >= 2 * np.pi - TURN_TOL:
        return slices
    else:  # the ends twice: kinks, as the wheel is round between them
        rows = np.concatenate([[0], np.arange(positions.size), [positions.size - 1]])
    return _chosen(slices, rows)


def _chosen(slices: SlicesFile, rows: Sequence[int] | np.ndarray) -> SlicesFile:
    """Some of the slices, by number."""
    features = slices.features
    if features is not None:
        features = features[rows]
    profiles = tuple(slices.profiles[k] for k in rows)
    return replace(slices, positions=slices.positions[rows], profiles=profiles, features=features)
