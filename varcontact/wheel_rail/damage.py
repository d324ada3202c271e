"""Damage of wheels and rails: the shakedown diagram, and profiles worn step by step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.plausibility import warn_plausibility
from varcontact.system.progress import Progress
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.plausibility import of_yield_stress
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.result import WheelRailSolution, wear
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack

SAMPLE = 0.1
"""Step along a profile in which wear is accumulated [mm]."""


@dataclass(frozen=True)
class JohnsonDiagram:
    """Place of a patch in Johnson's shakedown diagram, with estimated errors of forces and peak
    pressure (NaN where these have none).

    The diagram is that of a line contact in full slip: it takes Hertz's pressure, traction in one
    direction all over, and a material that yields by Tresca. Where tractions cancel in the force
    (spin, partial slip) it is not safe: `varcontact.shakedown` bounds the limit of the tractions
    themselves, and ``yield_in_shear / (local * peak pressure)`` is an upper bound on it.

    Attributes
    ----------
    utilised : float
        Tangential force, relative to the normal force [-].
    load_factor : float
        Peak pressure, relative to the yield stress in shear [-].
    index : float
        Surface fatigue index, ``utilised - 1/load_factor``: positive where the
        surface flows with each passage. A. Ekberg, E. Kabo, H. Andersson,
        Fatigue Fract. Eng. Mater. Struct. 25 (2002) 899-909.
    utilised_error, index_error : float
        [-]
    local : float
        Largest traction, divided by the largest pressure [-]: at least `utilised`, and equal to it
        in full slip along one direction.
    """

    utilised: float
    load_factor: float
    index: float
    utilised_error: float
    index_error: float
    local: float


@checks.named_options()
def johnson_diagram(solved: PatchSolution, yield_in_shear: float) -> JohnsonDiagram:
    """A patch in Johnson's shakedown diagram.

    Parameters
    ----------
    solved : PatchSolution
    yield_in_shear : float
        k of the hardened steel [N/mm^2].

    Examples
    --------
    >>> from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
    >>> case = WheelOnRail(
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
    ...     wheelset=WheelSet(wheel=Profile.s1002()),
    ...     position=Position(y=3.0, yaw=0.003), vertical_force=80e3, dx=1.0, dy=1.0)
    >>> found = johnson_diagram(case.solve().patches[0], yield_in_shear=300.0)
    >>> print(f"{found.utilised:.2f}, {found.load_factor:.1f}, {found.index:.2f}")
    0.30, 4.8, 0.09
    """
    checks.kind("solved", solved, PatchSolution)
    k = checks.positive("yield_in_shear", yield_in_shear)
    warn_plausibility(of_yield_stress(k))
    # the tangential force
    force = solved.force
    error = solved.error
    tangential = float(np.hypot(*force[:2]))
    if tangential > 0:
        tangential_error = float(np.abs(force[:2]) @ error[:2]) / tangential
    else:
        tangential_error = float(np.hypot(*error[:2]))
    utilised = tangential / force[2]
    utilised_error = (tangential_error + utilised * error[2]) / force[2]
    # the peak pressure
    factor = solved.peak_pressure / k
    index_error = utilised_error + solved.peak_pressure_error / solved.peak_pressure / factor
    traction = solved.solution.traction
    local = float(np.hypot(*traction).max() / solved.solution.pressure.max())
    return JohnsonDiagram(
        utilised=utilised,
        load_factor=factor,
        index=utilised - 1 / factor,
        utilised_error=float(utilised_error),
        index_error=float(index_error),
        local=local,
    )


@checks.named_options()
def worn_profile(
    found: Sequence[WheelRailSolution],
    archard: Archard | ArchardMap,
    kind: Kind,
    *,
    passages: float = 1.0,
    smoothing: float = 2.0,
) -> Profile:
    """The profile of rail or wheel after the wear of solved wheels.

    Parameters
    ----------
    found : sequence of WheelRailSolution
        Wheels on one profile; left ones count as mirror images.
    archard : Archard or ArchardMap
    kind : {"rail", "wheel"}
        Which body wears.
    passages : float
        Passages of each wheel over the rail; of a wheel, its revolutions.
    smoothing : float
        Length over which the depth is averaged along the profile, as wheels
        pass beside each other [mm]; 0: none.

    Returns
    -------
    Profile
        The same points, moved into the material by the depth.

    Raises
    ------
    SceneError
        For no wheels, or wheels on different profiles.
    """
    checks.choice("kind", kind, ("rail", "wheel"))
    times = checks.positive("passages", passages)
    length = checks.at_least_zero("smoothing", smoothing)
    _check_list("found", found, WheelRailSolution)
    profile = _profile_of(found, kind)
    # depth along the curve that can be touched
    curve = profile.running
    at = curve.sampled(SAMPLE)
    depth = np.zeros(at.size)
    for wheel in found:
        for worn in wear(wheel, archard).patches:
            s = curve.at(_lateral_places(wheel, worn.solved, kind))
            # rows of the left side run the other way; those beyond the profile last
            order = np.argsort(s)
            depth += times * np.interp(at, s[order], worn.depth[order], left=0.0, right=0.0)
    if length > 0:  # a mean over the length: the area is kept
        count = 2 * round(length / float(at[1] - at[0]) / 2) + 1
        depth = np.convolve(depth, np.full(count, 1 / count), mode="same")
    # its points, moved into the material; not those beyond the curve, nor the back of a flange
    along = curve.directions(at)
    normal = np.stack([-along[:, 1], along[:, 0]])
    moved = normal * (depth if kind == "rail" else -depth)
    s = curve.at(profile.y)
    touched = np.abs(curve.points(s)[:, 1] - profile.z) < SAMPLE
    y, z = (np.where(touched, np.interp(s, at, each), 0.0) for each in moved)
    try:
        return replace(profile, y=profile.y + y, z=profile.z + z)
    except SceneError as error:
        message = (
            f"passages = {times:g}: wear of up to {depth.max():.3g} mm is more than the profile "
            f"bears ({error}); give fewer passages, and solve the wheels again on what they leave"
        )
        raise SceneError("passages", times, message=message) from error


def _profile_of(wheels: Sequence[WheelRailSolution], kind: Kind) -> Profile:
    """The profile that all wheels have in common."""
    if kind == "rail":
        profiles: list[Any] = [each.case.track.rail for each in wheels]
    else:
        profiles = [each.case.wheelset.wheel for each in wheels]
    if len({id(each) for each in profiles}) != 1 or not isinstance(profiles[0], Profile):
        raise SceneError(
            "found", len(profiles), "wheels on one profile, one or more, which does not vary"
        )
    return profiles[0]


def _lateral_places(wheel: WheelRailSolution, solved: PatchSolution, kind: Kind) -> np.ndarray:
    """y of rows of elements in the coordinates of the profile of rail or wheel [mm]."""
    lateral, down = solved.rows
    points = solved.frame.globally(np.stack([0.0 * lateral, lateral, down], axis=1))
    if kind == "rail":
        return wheel.case.track.on_rail(points[:, 1:], wheel.case.side)[:, 0]
    return wheel.case.on_wheel(points, wheel.case.body(wheel.z))[0]


@checks.named_options(lambda given: checks.options_of(WheelOnRail.solve))
def wear_down(
    cases: Sequence[WheelOnRail | WheelSetOnTrack],
    archard: Archard | ArchardMap,
    kind: Kind,
    *,
    passages: float,
    steps: int = 5,
    smoothing: float = 2.0,
    progress: Progress = None,
    **methods: Any,
) -> list[Profile]:
    """Profiles worn step by step: after each, contacts are those of the new profile.

    Parameters
    ----------
    cases : sequence of WheelOnRail or WheelSetOnTrack
        On one profile: positions that come equally often.
    archard, kind, smoothing
        See `worn_profile`.
    passages : float
        Passages of each case, in total.
    steps : int
        In which these are divided.
    progress : callable or true, optional
        Called with the progress.
    **methods
        Arguments of `solve`.

    Returns
    -------
    list of Profile
        After each step.

    Raises
    ------
    SceneError, NotConverged
        See `worn_profile` and `WheelOnRail.solve`; where a step takes off so
        much that profiles cross themselves.
    """
    count = checks.whole("steps", steps)
    report = checks.progress(progress)
    checks.positive("passages", passages)
    _check_list("cases", cases, WheelOnRail, WheelSetOnTrack)
    profiles = []
    for number in range(count):
        wheels: list[Any] = []
        for case in cases:
            report(f"step {number + 1} of {count}, y = {case.position.y:.4g} mm")
            solution = case.solve(**methods)
            if isinstance(solution, WheelRailSolution):
                wheels.append(solution)
            else:
                wheels += solution.wheels
        profile = worn_profile(
            wheels, archard, kind, passages=passages / count, smoothing=smoothing
        )
        profiles.append(profile)
        cases = [_with_profile(case, kind, profile) for case in cases]
    return profiles


def _with_profile(
    case: WheelOnRail | WheelSetOnTrack, kind: Kind, profile: Profile
) -> WheelOnRail | WheelSetOnTrack:
    """The case with a profile of its rails or wheels."""
    if kind == "rail":
        return replace(case, track=replace(case.track, rail=profile))
    return replace(case, wheelset=replace(case.wheelset, wheel=profile))


def _check_list(field: str, given: Any, *kinds: type[Any]) -> None:
    if not isinstance(given, Sequence):
        raise SceneError(field, given, "a list")
    for number, each in enumerate(given):
        checks.kind(f"{field}[{number}]", each, *kinds)
