"""Whether noise of a profile rules the pressure of a contact patch, from the distance between wheel and rail alone."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from varcontact.scene.grid import Grid
from varcontact.scene.surfaces import SampledDistance

if TYPE_CHECKING:
    from varcontact.wheel_rail.wheel_on_rail import ContactPatch

WAVES = 6
"""Changes of sign of the curvature across the middle of a patch from which a profile may be called rough."""
STRONG = 0.5
"""Pressure that presses the waves flat, by the patch's, from which it is: with less the peak was 1.25 times too high at
most (noise of 2 um on the benchmark's rail, as it was and smoothed)."""


class RoughProfile(UserWarning):
    """The distance between the profiles waves within a patch: noise, which makes stripes of pressure."""


def check_smooth(patch: ContactPatch, stacklevel: int) -> None:
    """Warn where the distance across the middle of a patch waves, strongly enough to count in the pressure.

    A wave of length L and amplitude d takes the pressure ``pi G d / ((1 - nu) L)`` to be pressed flat; that of the
    patch is about ``2 G delta / (pi (1 - nu) b)``, with its approach and half width.

    Parameters
    ----------
    patch : ContactPatch
    stacklevel : int
        Of the warning.
    """
    assert isinstance(patch.scene.surface, SampledDistance)
    distance, grid = patch.scene.surface.h, patch.scene.grid
    if isinstance(grid, Grid):
        side = grid.sides[1]
    else:
        below, above = patch.scene.surface.coordinates[1][:2]
        side = float(above - below)
    across = distance[:, np.unravel_index(distance.argmin(), distance.shape)[1]]
    near = across[across < 2 * patch.approach]
    bend = np.diff(near, 2)
    waves = int(np.sum(bend[1:] * bend[:-1] < 0))
    if waves < WAVES:
        return
    length, half_width = 2 * near.size * side / waves, side * np.count_nonzero(across < patch.approach) / 2
    whole = max(2, round(length / side))
    slow = np.convolve(bend, np.full(whole, 1 / whole), "valid")  # without waves
    rest = bend[(whole - 1) // 2 :][: slow.size] - slow
    amplitude = np.sqrt(2) * float(np.std(rest)) / (2 * np.sin(np.pi * min(side / length, 0.5))) ** 2
    if np.pi * amplitude / length > STRONG * 2 / np.pi * patch.approach / half_width:
        warnings.warn(
            f"the distance between wheel and rail waves {waves} times across the patch at y = "
            f"{patch.location[1]:.4g} mm: a profile is rough there, and the pressure will be in stripes; "
            "smooth it, Profile(..., smoothing=...)",
            RoughProfile,
            stacklevel=stacklevel,
        )
