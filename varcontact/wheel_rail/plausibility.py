"""Plausibility warnings of wheels on rails: likely mistakes in entries that can be solved, each
with its figures.

`CHECKS` are one small function each, which returns its sentence, or nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.wheel_geometry import OnTrack, WheelGeometry

LEAST_LOAD = 1e3
"""Load on a wheel [N] below which it is probably in kN."""
LARGEST_LOAD = 500e3
"""Load on a wheel [N] above which it is probably in another unit."""
SOFT = 500.0
"""Modulus of rigidity [N/mm^2] below that of hard plastics; that of steel in GPa is 80."""
SHORT_CURVE = 15e3
"""Radius of the tightest curve that trams run through [mm]."""
LEAST_GAUGE = 300.0
"""Smallest gauge of tracks [mm]."""
LARGEST_GAUGE = 3000.0
"""Largest gauge of tracks [mm]."""
SMALL_WHEEL = 0.1
"""Radius of a wheel divided by the gauge, below which it is doubtful: in inches it is at most half
of this."""
NARROW_PROFILE = 10.0
"""Width of a profile [mm] below which it is doubtful: in inches a rail has 3, a wheel 5.5."""
AT_TIP = 2.0
"""Distance of a patch from the flange's tip, downwards [mm]."""
TALL_FLANGE = 10.0
"""Height of the tip of a flange above the running circle [mm]."""
YIELD_IN_SHEAR = 20.0, 5e3
"""Range of the yield stress in shear of metals [N/mm^2]."""
HARDNESS = 1e3, 2e4
"""Range of the hardness of steels [N/mm^2]; Brinell and Vickers numbers are a tenth of it."""


def warnings_of(case: OnTrack) -> tuple[str, ...]:
    """Likely mistakes in the entries of a wheel, or a wheel set, on its track."""
    return tuple(words for check in CHECKS if (words := check(case)))


def _load(case: OnTrack) -> str:
    """Warning for a load that is probably in kN, or above that of any wheel."""
    wheels = 1 if isinstance(case, WheelGeometry) else 2
    load = case.vertical_force
    if load is None or wheels * LEAST_LOAD <= load <= wheels * LARGEST_LOAD:
        return ""
    range_ = f"{LEAST_LOAD / 1e3:g} to {LARGEST_LOAD / 1e3:g} kN on each wheel"
    return f"vertical_force = {load:.4g} N: {range_} is usual; loads are in newtons"


def _modulus(case: OnTrack) -> str:
    """Warning for a modulus that is probably in gigapascals."""
    G = case.bodies.combined_G
    if G >= SOFT:
        return ""
    return (
        f"bodies: G = {G:.4g} N/mm^2 is below that of metals, some 3e4 to 8e4: moduli are in N/mm^2"
    )


def _cant(case: OnTrack) -> str:
    """Warning for rails that lean outwards."""
    cant = case.track.cant
    if cant >= 0:
        return ""
    return (
        f"track.cant = {cant:.4g}: the rails lean outwards; "
        "a positive cant leans them towards the middle of the track"
    )


def _gauge(case: OnTrack) -> str:
    gauge = case.track.gauge
    if LEAST_GAUGE <= gauge <= LARGEST_GAUGE:
        return ""
    return (
        f"track.gauge = {gauge:.4g} mm: tracks have {LEAST_GAUGE:g} to {LARGEST_GAUGE:g} mm; "
        "metres and inches are to be converted"
    )


def _curve(case: OnTrack) -> str:
    radius = case.track.curve_radius
    if abs(radius) >= SHORT_CURVE:
        return ""
    tightest = f"the tightest curves have {SHORT_CURVE / 1e3:g} m"
    return (
        f"track.curve_radius = {radius:.6g} mm: {tightest}; "
        f"a radius of {abs(radius):.6g} m is {abs(radius):.6g}e3 mm"
    )


def _wheel_radius(case: OnTrack) -> str:
    radius = case.wheelset.radius
    gauge = case.track.gauge
    if radius >= SMALL_WHEEL * gauge:
        return ""
    return (
        f"wheelset.radius = {radius:.4g} mm is {radius / gauge:.2g} of the gauge, "
        f"{gauge:.4g} mm: it looks like inches"
    )


def _width(case: OnTrack) -> str:
    """Warning for profiles in inches or metres."""
    profiles: dict[str, Profile] = {"rail": case.track.profile, "wheel": case.wheelset.profile}
    for kind, profile in profiles.items():
        width = float(np.ptp(profile.y))
        if width < NARROW_PROFILE:
            looks = "metres" if width < 1 else "inches"
            return (
                f"the {kind}'s profile is {width:.4g} mm wide: "
                f"it looks like {looks}; give Profile.read(..., scale=...)"
            )
    return ""


CHECKS: tuple[Callable[[OnTrack], str], ...] = (
    _load,
    _modulus,
    _cant,
    _gauge,
    _curve,
    _wheel_radius,
    _width,
)


def at_tip(y: float, on_wheel: np.ndarray, wheel: Profile) -> tuple[str, ...]:
    """Warning for a contact at the flange's tip, at y in the track and at (y, z) `on_wheel`."""
    tip = float(wheel.z.max())
    below = tip - float(on_wheel[1])
    if tip < TALL_FLANGE or below > AT_TIP:
        return ()
    where = f"the patch at y = {y:.4g} mm is {below:.2g} mm below the flange's tip"
    return (f"{where}: a wheel hardly runs on it; look at position.y and at the gauge",)


def of_yield_stress(yield_in_shear: float) -> tuple[str, ...]:
    """Warning for a yield stress that is probably in pascals or gigapascals."""
    least, most = YIELD_IN_SHEAR
    if least <= yield_in_shear <= most:
        return ()
    metals = f"metals have {least:g} to {most:g}, steels 100 to 1500"
    return (f"yield_in_shear = {yield_in_shear:.4g} N/mm^2: {metals}",)


def of_hardness(hardness: float) -> tuple[str, ...]:
    """Warning for a hardness that is probably a Brinell or Vickers number, or in pascals."""
    least, most = HARDNESS
    if least <= hardness <= most:
        return ()
    numbers = "numbers of Brinell and Vickers are in kgf/mm^2, 9.81 N/mm^2"
    return (f"wear.hardness = {hardness:.4g} N/mm^2: steels have {least:g} to {most:g}; {numbers}",)
