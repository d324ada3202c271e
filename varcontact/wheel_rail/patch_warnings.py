"""Warnings of the patches of a wheel on a rail."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from varcontact.errors import warn
from varcontact.scene.plausibility import warn_plausibility
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.profile_shape import check_sides
from varcontact.wheel_rail.result import CONFORMAL, WheelRailSolution

STEEP = 2.0
"""Ratio of normal forces to the load above which a warning is given of a wheel on its flange: that
of an angle of 60 degrees."""
FEWEST = 4
"""Elements along and across a patch below which its pressures are rough."""


class CoarseElements(UserWarning):
    """A patch of so few elements that its pressures are rough; its forces hardly are."""


class ConformalContact(UserWarning):
    """Patch so wide, compared with the radius of curvature of a profile, that half-spaces and a
    tangent plane are a poor model.
    """


class RoughProfile(UserWarning):
    """A patch whose pressure is dominated by noise of the profiles."""


def warn_of_patches(found: WheelRailSolution) -> None:
    """Warn of exchanged sides, steep flanges, few elements, and contacts too wide for
    half-spaces.
    """
    case = found.case
    check_sides(case.track.profile)
    warn_plausibility(found.patch_warnings)
    normal = sum(each.normal_force for each in found.patches)
    if case.vertical_force is not None and normal > STEEP * case.vertical_force:
        steepest = np.degrees(max(abs(each.patch.angle) for each in found.patches))
        words = (
            f"normal forces of {normal:.4g} N carry the load of {case.vertical_force:.4g} N, "
            f"on a flange as steep as {steepest:.3g} degrees: "
            "a wheel with this load hardly comes to this position"
        )
        warn(words)
    for each, radii in zip(found.patches, found.too_wide, strict=True):
        for words in _coarse_elements(each):
            warn(words, CoarseElements)
        for words in _conformal_contact(each, radii):
            warn(words, ConformalContact)


def _place(solved: PatchSolution) -> str:
    y = round(solved.patch.location[1], 3)
    return f"the patch at y = {y:.4g} mm"


def _coarse_elements(solved: PatchSolution) -> Iterator[str]:
    """Sentences on a patch of few elements along or across it."""
    dx, dy = solved.solution.grid.sides
    columns, rows = _elements_across(solved)
    for name, side, count, size in (("dx", dx, columns, "long"), ("dy", dy, rows, "wide")):
        if 0 < count < FEWEST:
            elements = "1 element" if count == 1 else f"{count} elements"
            yield (
                f"with {name} = {side:g} mm {_place(solved)} is {elements} {size}: "
                f"too few for its pressures; give a smaller {name}, for {FEWEST} elements or more"
            )


def _conformal_contact(solved: PatchSolution, radii: dict[str, float]) -> Iterator[str]:
    """Sentences on profiles whose radii of curvature are small beside a patch."""
    for kind, radius in radii.items():
        yield (
            f"conformal contact: {_place(solved)} is {solved.loaded_half_width:.3g} mm wide "
            f"to either side, the {kind}'s radius of curvature {radius:.3g} mm, "
            f"less than {CONFORMAL:g} times as much; "
            "half-spaces are too soft for that, and the tangent plane too flat; "
            "conformal = True has a curved surface"
        )


def noisy_patches(found: WheelRailSolution) -> list[str]:
    """Positions of the patches whose pressure is dominated by noise; waves on few elements do not
    count.
    """
    places = []
    for each in found.patches:
        noisy = any(text.lower().startswith("noise") for text in each.solution.warnings)
        if noisy and min(_elements_across(each)) >= FEWEST:
            places.append(_place(each))
    return places


def warn_of_noise(patches: list[str]) -> None:
    for place in patches:
        words = (
            f"noise dominates {place}: a profile is rough there, and the pressure in stripes; "
            "smooth it, Profile(..., smoothing=...)"
        )
        warn(words, RoughProfile)


def _elements_across(solved: PatchSolution) -> list[int]:
    """Columns and rows of elements in contact."""
    inside = solved.solution.pressure > 0
    return [int(np.count_nonzero(inside.any(axis=axis))) for axis in (0, 1)]
