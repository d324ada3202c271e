"""Profiles that change along the rail, as of switches and crossings, or around the wheel, as with a flat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_words import Lines
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind

SLICES = (".slcs", ".slcw")
"""Endings of CONTACT's files."""
TOGETHER = 1e-3
"""Spacing below which CONTACT refuses slices [mm]."""


@checks.named(profile="profiles", angles="positions", s="positions", dr="z", radii="z")
@dataclass(frozen=True, eq=False, kw_only=True)
class ProfileSlices:
    """Cross sections of a rail at positions along the track, or of a wheel at angles around it.

    Between slices, points at the same part of the arc length, or of that between two features, lie on a cubic spline.
    Two slices at one position are a step, or, if they are equal, a kink. Before the first slice and behind the last
    one a rail goes on unchanged; the spline of a wheel is closed.

    Parameters
    ----------
    profiles : Profile, or sequence of Profile
        All in one coordinate system; one of them stands for all positions.
    positions : array_like, shape (n,)
        Ascending: along the track [mm], see `Position.s`, or around the wheel, as x = r sin(angle), z = r cos(angle)
        with the wheel at `Position.pitch` = 0 [rad].
    z : float or array_like, shape (n,)
        Added to the profiles' z: height of the rail, downwards, or change of the wheel's radius [mm].
    features : array_like, shape (n, m), optional
        Arc lengths from the first point of each profile at which they correspond [mm]; its ends if not given.

    Raises
    ------
    SceneError
        For slices out of order, naming the first, three at one position, profiles of both kinds, angles of more than a
        turn, and features that do not ascend.

    Examples
    --------
    >>> import numpy as np
    >>> flat = np.linspace(-0.05, 0.05, 41)  # a chord of a wheel with a radius of 460 mm
    >>> angles = [-0.05, *flat, 0.05]  # twice at its ends, where it has kinks
    >>> depth = 460 * (np.cos(0.05) / np.cos(angles) - 1)
    >>> wheel = ProfileSlices(profiles=Profile.s1002(), positions=angles, z=depth)
    >>> print(wheel)
    ProfileSlices(wheel, 43 slices, -0.05 to 0.05 rad)
    """

    profiles: Profile | Sequence[Profile]
    positions: Any
    z: Any = 0.0
    features: Any = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        positions = checks.array("slices.positions", self.positions, 1)
        given: Any = self.profiles
        profiles = (given,) * positions.size if isinstance(given, Profile) else tuple(given)
        if not profiles or any(not isinstance(each, Profile) for each in profiles):
            raise SceneError("slices.profiles", given, "a Profile, or one for each position")
        if len(profiles) != positions.size:
            raise SceneError("slices.profiles", len(profiles), f"as many as positions, {positions.size}")
        if len({each.kind for each in profiles}) > 1:
            other = next(i for i, each in enumerate(profiles, 1) if each.kind != profiles[0].kind)
            raise SceneError("slices.profiles", other, f"all of a {profiles[0].kind}: slice {other} is not")
        step = np.diff(positions)
        wrong = np.flatnonzero((step < 0) | np.concatenate([[False], (step[1:] == 0) & (step[:-1] == 0)])[: step.size])
        if wrong.size:
            i = int(wrong[0])
            reason = f"slices.positions: slice {i + 2} at {positions[i + 1]:g} is out of order"
            raise SceneError("slices.positions", float(positions[i + 1]), message=reason)
        if profiles[0].kind == "wheel" and np.ptp(positions) >= 2 * np.pi:
            raise SceneError("slices.positions", float(np.ptp(positions)), "angles in rad, within less than a turn")
        z = checks.numbers("slices.z", self.z)
        if z.ndim and z.shape != positions.shape:
            raise checks.wrong_shape("slices.z", z.shape, f"a number, or one for each position, {positions.size}")
        if self.features is not None:
            features = checks.array("slices.features", self.features, 2)
            if len(features) != len(profiles) or features.shape[1] < 2 or (np.diff(features, axis=1) <= 0).any():
                raise SceneError("slices.features", features.shape, "two or more that ascend, for each position")
            set_(self, "features", features)
        set_(self, "profiles", profiles)
        set_(self, "positions", positions)
        set_(self, "z", np.broadcast_to(z, positions.shape) + 0.0)

    def __repr__(self) -> str:
        first, last = self.positions[[0, -1]]
        unit = "mm" if self.kind == "rail" else "rad"
        return f"ProfileSlices({self.kind}, {self.positions.size} slices, {first:g} to {last:g} {unit})"

    @property
    def kind(self) -> Kind:
        """Of the profiles: "rail" or "wheel"."""
        return self.first.kind

    @property
    def first(self) -> Profile:
        """The first slice, from which gauge, rail tops and the flange's place are measured."""
        return self.profiles[0]  # type: ignore[index]

    @property
    def constant(self) -> bool:
        """Whether all slices are one profile."""
        return all(each is self.first for each in self.profiles) and not self.z.any()  # type: ignore[union-attr]

    @classmethod
    def read(cls, path: str | Path, kind: Kind, **options: Any) -> ProfileSlices | tuple[ProfileSlices, ...]:
        """Read slices from a file of CONTACT (`.slcs` of rails, `.slcw` of wheels).

        Parameters
        ----------
        path : str or Path
            Profiles that it names are looked for from its folder.
        kind : {"rail", "wheel"}
        **options
            See `Profile.read`.

        Returns
        -------
        ProfileSlices, or tuple of ProfileSlices
            Several where some slices lack features, as those before the nose of a crossing: rails beside each other.

        Raises
        ------
        SceneError
            If the file or a profile cannot be read, or slices are out of order, with the line.
        """
        file = checks.file_name("path", path)
        lines = Lines(file)
        offset, scale = lines.group("S_OFFSET", "S_SCALE").numbers()
        (count,) = lines.group("NSLC").integers()
        features, kinks, jumps = lines.group("NFEAT", "NKINK", "NACCEL").integers()
        lines.group("S_METHOD")
        positions, profiles, known = [], [], dict[str, Profile]()
        for _ in range(count):
            group = lines.group("S", "a profile")
            name = group.values[1].strip("'\"").replace("\\", "/")
            positions.append(scale * (offset + group.number(0)))
            known[name] = known.get(name) or Profile.read(file.parent / name, kind, **options)
            profiles.append(known[name])
            if len(positions) > 1 and positions[-1] - positions[-2] <= (TOGETHER if kind == "rail" else 0):
                group.refuse("S", positions[-1], f"of slice {len(positions)} is out of order")
        if features <= 1:
            return cls(profiles=profiles, positions=positions)
        if options.get("mirror_y") is True:
            reason = f"mirror_y: {file.name} has features by arc length from the first point; mirror the profiles"
            raise SceneError("mirror_y", True, message=reason)
        for more in filter(None, (kinks, jumps)):
            lines.many("kinks", more)
        table = np.array([lines.many("features", features + 1).numbers()[1:] for _ in positions])
        table = np.minimum(table, [[each.curve.s[-1]] for each in profiles])
        there = (table[:, :-1] >= 0) & (table[:, 1:] >= 0)  # what is between two features
        ends = np.flatnonzero((there[:, 1:] != there[:, :-1]).any(axis=0)) + 1
        found = []
        for a, b in pairwise([0, *ends.tolist(), features - 1]):
            has = np.flatnonzero(there[:, a])
            if has.size:
                used = table[has, a : b + 1]
                used = used[:, np.concatenate([[True], (np.diff(used, axis=1) > 0).all(axis=0)])]
                at = [positions[i] for i in has]
                found.append(cls(profiles=[profiles[i] for i in has], positions=at, features=used))
        return found[0] if len(found) == 1 else tuple(found)


def sliced(given: Profile | ProfileSlices) -> ProfileSlices:
    """Slices as they are, and a profile as the only one."""
    return given if isinstance(given, ProfileSlices) else ProfileSlices(profiles=given, positions=[0.0])
