"""Profiles of rails and wheels that an input file of CONTACT names, with its ways of smoothing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact.io.contact_words import Group, located
from varcontact.wheel_rail.curve import smoothed_in_third_order
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.slices import SLICES, ProfileSlices

NO_TAPE = 1000.0
"""YTAPE from which on a wheel has no tape circle [mm]."""


def profile_of(groups: tuple[Group, ...], kind: Kind, folder: Path) -> Any:
    """The profile of a file, or its slices, as MIRRORY, SCALE, SMOOTH and their like make it."""
    group = groups[0]
    smooth = group.number(3)
    method = 0
    if len(groups) > 1:
        more = groups[1]
        method = int(more.number(0))
        if method not in (0, 1, 2):
            more.refuse("ISMOOTH", method, "is not supported; supported: 0, 1, 2")
    for word, value in (("MIRRORY", group.number(1)), ("MIRRORZ", group.option(0, 0.0))):
        if value not in (-1, 0, 1):
            group.refuse(word, value, "is not -1, 0 or 1")
    reader: Any = Profile.read
    name = group.text(0)
    if name.lower().endswith(SLICES):
        reader = ProfileSlices.read
    mirrors = {1: True, -1: False}
    with located(group):
        profile = reader(
            folder / name,
            kind,
            scale=group.number(2),
            smoothing=smooth if method == 1 else 0.0,
            mirror_y=mirrors.get(int(group.number(1)), "auto"),
            mirror_z=mirrors.get(int(group.option(0, 0.0))),
        )
        if smooth <= 0 or method == 1:
            return profile
        smoother = {0: _smoothed, 2: _smoothed_in_third_order}[method]
        return _each_smoothed(profile, smoother, smooth)


def _each_smoothed(
    profile: Any, smoother: Callable[[Profile, float], Profile], smooth: float
) -> Any:
    """A profile, or all of slices, with ISMOOTH = 0 or 2."""
    if isinstance(profile, tuple):
        return tuple(_each_smoothed(each, smoother, smooth) for each in profile)
    if isinstance(profile, Profile):
        return smoother(profile, smooth)
    once = {id(each): each for each in profile.profiles}
    smoothed = {key: smoother(each, smooth) for key, each in once.items()}
    return replace(profile, profiles=[smoothed[id(each)] for each in profile.profiles])


def _smoothed_in_third_order(profile: Profile, length: float) -> Profile:
    """The profile with ISMOOTH = 2, through points that are smoothed."""
    points = np.stack([profile.y, profile.z], axis=1)
    y, z = smoothed_in_third_order(points, profile.kink_points, length).T
    return replace(profile, y=y, z=z)


def _smoothed(profile: Profile, weight: float) -> Profile:
    """The profile with ISMOOTH = 0, by a weight of the integral of the squared second derivative.

    The squared distances are summed over points, which is an integral, divided by their spacing.
    """
    spacing = float(np.median(np.hypot(np.diff(profile.y), np.diff(profile.z))))
    length = 2 * math.pi * (weight * spacing) ** 0.25
    if length < spacing:
        return profile
    return profile.smoothed(length)


def first_slice(wheel: Profile | ProfileSlices) -> Profile:
    """A wheel's profile, or its first slice."""
    if isinstance(wheel, Profile):
        return wheel
    return wheel.first


def radius_above_tape(group: Group, wheel: Any) -> float:
    """Radius at the profile's origin less that at its tape circle [mm]."""
    place = group.option(0, NO_TAPE)
    profile = first_slice(wheel)
    on_profile = profile.y.min() <= place <= profile.y.max()
    if abs(place) >= NO_TAPE or not on_profile:
        return 0.0
    return -float(profile.z_at(np.array([place]))[0])
