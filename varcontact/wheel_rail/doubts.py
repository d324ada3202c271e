"""What may be wrong with the patches of a wheel on a rail: warnings."""

from __future__ import annotations

import warnings
from functools import partial

import numpy as np

from varcontact.scene.plausibility import warn as warn_of_doubts
from varcontact.wheel_rail.profile import check_sides
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution
from varcontact.wheel_rail.wheel_geometry import WheelGeometry

CONFORMAL = 3.0
"""Half widths that the radius of curvature of each profile should have at least, for
half-spaces."""
STEEP = 2.0
"""Ratio of normal forces to the load above which a wheel on its flange is warned of: that of an
angle of 60 degrees."""
FEWEST = 4
"""Elements of a patch either way below which its pressures are rough."""


class CoarseElements(UserWarning):
    """A patch of so few elements that its pressures are rough; its forces hardly are."""


class ConformalContact(UserWarning):
    """A patch so wide, by the curvature of a profile, that half-spaces and a tangent plane do not
    describe it well.
    """


class RoughProfile(UserWarning):
    """A patch whose pressure is dominated by noise of the profiles."""


def warn(found: WheelRailSolution, stacklevel: int) -> None:
    """Warn of exchanged sides, steep flanges, few elements, and contacts too wide for
    half-spaces.
    """
    case, warn = found.case, partial(warnings.warn, stacklevel=stacklevel)
    check_sides(case.track.profile, stacklevel=stacklevel + 1)
    warn_of_doubts(found.patch_doubts, stacklevel=stacklevel)
    normal = sum(each.normal_force for each in found.patches)
    if case.vertical_force is not None and normal > STEEP * case.vertical_force:
        steepest = np.degrees(max(abs(each.patch.angle) for each in found.patches))
        warn(
            f"normal forces of {normal:.4g} N bear the load of {case.vertical_force:.4g} N, on a flange as steep as "
            f"{steepest:.3g} degrees: a wheel with this load hardly comes to this position"
        )
    for each in found.patches:
        patch, solution, half = each.patch, each.solution, each.half_width
        where = f"the patch at y = {patch.location[1]:.4g} mm"
        counts = _elements_across(each)
        for count, side, name, size in zip(
            counts, solution.grid.sides, ("dx", "dy"), ("long", "wide"), strict=True
        ):
            if 0 < count < FEWEST:
                reason = f"too few for its pressures; give a smaller {name}, for {FEWEST} elements or more"
                elements = f"{count} element{'s' * (count > 1)} {size}"
                warn(f"with {name} = {side:g} mm {where} is {elements}: {reason}", CoarseElements)
        for kind, radius in too_wide(case, each).items():
            wide = f"{where} is {half:.3g} mm wide to either side"
            bent = f"the {kind}'s radius of curvature {radius:.3g} mm, less than {CONFORMAL:g} times as much"
            why = "half-spaces are too soft for that, and the tangent plane too flat"
            warn(
                f"conformal contact: {wide}, {bent}; {why}; conformal = True has a curved surface",
                ConformalContact,
            )


def noisy_patches(found: WheelRailSolution) -> list[str]:
    """Where the patches are whose pressure is dominated by noise; waves on few elements are
    none.
    """
    return [
        f"the patch at y = {each.patch.location[1]:.4g} mm"
        for each in found.patches
        if any(text.lower().startswith("noise") for text in each.solution.warnings)
        and min(_elements_across(each)) >= FEWEST
    ]


def warn_of_noise(patches: list[str], stacklevel: int) -> None:
    for where in patches:
        reason = "a profile is rough there, and the pressure in stripes; smooth it, Profile(..., smoothing=...)"
        warnings.warn(f"noise dominates {where}: {reason}", RoughProfile, stacklevel=stacklevel)


def _elements_across(solved: PatchSolution) -> list[int]:
    """Columns and rows of elements in contact."""
    return [int(np.count_nonzero((solved.solution.pressure > 0).any(axis=axis))) for axis in (0, 1)]


def too_wide(case: WheelGeometry, solved: PatchSolution) -> dict[str, float]:
    """Radii of curvature [mm], by profile, that are small beside a patch in a plane."""
    patch, half = solved.patch, solved.half_width
    found: dict[str, float] = {}
    if patch.scene.conformal or half == 0:
        return {}
    across = half * np.cos(patch.angle) * np.array([-1.0, 1.0])
    for kind, (curve, y) in case.sections(patch.location, patch.on_wheel).items():
        # on average over the patch: noise does not count
        turned = curve.angles(curve.at(y + across))
        curvature = abs(np.sin(float(turned[1] - turned[0]) / 2)) / half
        if curvature * half * CONFORMAL > 1:
            found[kind] = float(1 / curvature)
    return found
