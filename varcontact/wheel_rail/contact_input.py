"""Wheels on rails from the input files of CONTACT, module 1.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech
CMCC report 20-01) and of the open-source release (the module ``m_wr_input`` of
its source), see `varcontact.io.contact_grammar`. Lengths are in mm, forces in
N, velocities in mm/s.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_cases import CaseInput, read_cases
from varcontact.io.contact_grammar import Controls
from varcontact.io.contact_material import (
    VISCOELASTIC,
    bodies_of,
    friction_law,
    kept_law,
    laws_of,
    layer_of,
    thermal_of,
)
from varcontact.io.contact_words import Group, located
from varcontact.theories.fastsim_contact import SimplifiedTheory
from varcontact.wheel_rail.curve import smoothed_in_third_order
from varcontact.wheel_rail.position import Position, Velocity
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.regions import FrictionByAngle
from varcontact.wheel_rail.slices import SLICES, ProfileSlices
from varcontact.wheel_rail.track import (
    SIGN,
    WIDEST_FLANGE,
    Irregularity,
    Side,
    Track,
    WheelSet,
    flange_tip,
)
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

SIDES: dict[int, Side] = {0: "left", 1: "right", 4: "left", 5: "right"}
CONVEX_GS = 2
"""The control digit G of the one solver of CONTACT that takes any DQREL in steady rolling."""
SHIFT = 1
TRANSIENT = 2
STEADY = 3
"""Values of the digit T."""
BY_TEMPERATURE = 6
"""Value of the digit L."""
SIMPLIFIED = (2, 3)
FASTRIP = 5
"""Values of the digit M."""
NO_TAPE = 1000.0
"""YTAPE from which a wheel has no tape circle [mm]."""
NO_NEAR_MISS = -1.0
"""GAP_MISS with which nothing is near [mm]."""
CONFORMAL = 4
BY_ELEMENT = (3, 6)
"""Values of the digit D with which patches are curved, and have the rigid slip of each element."""


@dataclass(frozen=True)
class RailSprings:
    """Springs, to the side and downwards, on which a rail without mass rests.

    Attributes
    ----------
    stiffness : tuple of float
        KYRAIL and KZRAIL [N/mm].
    preload : tuple of float
        FYRAIL and FZRAIL: forces of the springs on the rail where it is not
        deflected [N].
    """

    stiffness: tuple[float, float]
    preload: tuple[float, float]


@dataclass(frozen=True, eq=False)
class WheelCase:
    """A case of module 1 of an input file of CONTACT.

    Attributes
    ----------
    number, line : int
        Of the case in the file, from 1, and of its first line.
    element : tuple of int
        The result element that it belongs to, where one is given.
    wheel : WheelOnRail or None
        None where it cannot be had here.
    reason : str
        Why not, with line and digit; empty where there is a wheel.
    longitudinal_force : float or None
        Force on the rail along the wheel set, FX of F = 1 [N]: the pitch rate
        of the wheel is then one that gives it, and not known before.
    axle_moment : float or None
        Moment about the axle of the forces on the rail, MY of F = 2 [N mm], in
        the same way.
    springs : RailSprings or None
        On which the rail rests, F = 3: its deflection is not known before.
    rolled : float or None
        Distance rolled in a step of transient rolling, T = 2 [mm]; 0 of a shift,
        T = 1; None of steady rolling.
    before : WheelCase or None
        The case whose tractions a step goes on from, P = 0.
    stresses : tuple of Group
        Blocks of points below the elements of each patch, where stresses are
        asked for.
    separating_angle : float
        A_SEP [rad], from which CONTACT parts patches whatever their distance;
        here patches are parted by distance, and a case in which it would count
        is not run.
    near_miss : float
        GAP_MISS [mm]: places where wheel and rail are nearer than this, but do
        not touch, move the ends of patches beside them in CONTACT, not here; a
        case that has one is not run.
    simplified : SimplifiedTheory or None
        Where tractions are those of CONTACT's simplified theory, M = 2 or 3.
    """

    number: int
    line: int
    element: tuple[int, ...] = ()
    wheel: WheelOnRail | None = None
    reason: str = ""
    longitudinal_force: float | None = None
    axle_moment: float | None = None
    springs: RailSprings | None = None
    rolled: float | None = None
    before: WheelCase | None = None
    stresses: tuple[Group, ...] = ()
    separating_angle: float = math.pi / 2
    near_miss: float = NO_NEAR_MISS
    simplified: SimplifiedTheory | None = None

    @property
    def alone(self) -> bool:
        """True of steady rolling by given velocities, on a rail in its place."""
        more = (
            self.longitudinal_force,
            self.axle_moment,
            self.springs,
            self.rolled,
            self.simplified,
        )
        return all(each is None for each in more)


class WheelInput(Sequence[WheelOnRail]):
    """The wheels of an input file of CONTACT, and all of its cases.

    Attributes
    ----------
    cases : tuple of WheelCase
        In the order of the file, but for those that it skips. The sequence has those that roll
        steadily by given velocities.
    path : str
    """

    def __init__(self, path: str, cases: Sequence[WheelCase]) -> None:
        self.path = path
        self.cases = tuple(cases)
        self._wheels = [case.wheel for case in cases if case.wheel is not None and case.alone]

    @overload
    def __getitem__(self, k: int) -> WheelOnRail: ...
    @overload
    def __getitem__(self, k: slice) -> list[WheelOnRail]: ...
    def __getitem__(self, k: int | slice) -> WheelOnRail | list[WheelOnRail]:
        return self._wheels[k]

    def __len__(self) -> int:
        return len(self._wheels)

    @property
    def left_out(self) -> tuple[WheelCase, ...]:
        """The cases that have no wheel, each with its reason."""
        return tuple(case for case in self.cases if case.reason)

    def __str__(self) -> str:
        """A report: how many cases there are, and why some have no wheel."""
        lines = [f"{self.path}: {len(self.cases)} cases, {len(self.left_out)} of them left out"]
        lines += [f"case {case.number}: {case.reason}" for case in self.left_out]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"WheelInput({self.path!r}, {len(self.cases)} cases)"


@checks.named_options()
def read_contact_input(path: str | Path, *, strict: bool = True) -> WheelInput:
    """The cases of an input file of CONTACT, module 1, as wheels on rails.

    Parameters
    ----------
    path : str or Path
        A file ``<experiment>.inp``. Profiles that it names are looked for from
        its folder.
    strict : bool
        Whether a case that has no counterpart here is an error. If False, it is
        left out; `WheelInput.left_out` and ``print`` tell which, and why.

    Returns
    -------
    WheelInput
        A sequence of wheels in the order of the file. Given forces are all
        forces on the rail, those of friction included, as FZ is.

    Raises
    ------
    SceneError
        If the file or a profile cannot be read, or the file has what has no
        counterpart here: with the line, the entry, its value, and those that
        are supported (docs/from_contact.md has all of them).

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import numpy as np
    >>> from varcontact.wheel_rail import Profile, read_contact_input
    >>> folder = tempfile.TemporaryDirectory()
    >>> for name, profile in ("rail.txt", Profile.rail_60e1()), ("wheel.txt", Profile.s1002()):
    ...     np.savetxt(pathlib.Path(folder.name) / name, np.stack([profile.y, profile.z], axis=1))
    >>> path = pathlib.Path(folder.name) / "wheel.inp"
    >>> _ = path.write_text('''
    ...   1 MODULE
    ...  1203100    C-P-B-T-N-F-S
    ...  0022033    V-L-D-C-M-Z-E
    ...  0001331    H-G-I-A-O-W-R
    ...  999  100   30   1  1e-5              MAXGS, MAXIN, MAXNR, MAXOUT, EPS
    ...  0.300   0.300                        FSTAT, FKIN
    ...  0.280   0.280   82000.  82000.       POISS 1,2,  GG 1,2
    ...  0.400   0.400   1.0  90d  8.0  4.0   DX, DS, DQREL, A_SEP, D_SEP, D_COMB
    ...  14.0    0       1435.   0.025        GAUGHT, GAUGSQ, GAUGWD, CANT
    ...  'rail.txt'  0  1.0  0.0              RFNAME, MIRRORY, SCALE, SMOOTH
    ...  0.0 0.0 0.0  0.0 0.0 0.0             DY, DZ, ROLL, VY, VZ, VROLL
    ...  1360.   -70.    460.                 FBDIST, FBPOS, NOMRAD
    ...  'wheel.txt' 0  1.0  0.0              WFNAME, MIRRORY, SCALE, SMOOTH
    ...  0.0  3.0  80000.  0.0 0.0 0.0        S, Y, FZ, ROLL, YAW, PITCH
    ...  2000. 0.0 0.0  0.0 0.0 -4.34811810   VS, VY, VZ, VROLL, VYAW, VPITCH
    ...   0 MODULE
    ... ''')
    >>> (wheel,) = read_contact_input(path)
    >>> wheel.side, wheel.position.y, wheel.vertical_force, wheel.track.cant
    ('right', 3.0, 80000.0, 0.025)
    >>> folder.cleanup()
    """
    file = checks.file_name("path", path)
    inputs, unreadable = read_cases(file)
    readable = inputs
    if strict and unreadable:  # what is wrong before comes first
        readable = [case for case in inputs if case.number < unreadable[0].number]
    reader = _Reader(file.parent)
    cases = [reader.case(given, strict) for given in readable if given.calculated]
    if unreadable and (strict or not inputs):
        raise unreadable[0].error
    cases += [WheelCase(each.number, each.line, reason=str(each.error)) for each in unreadable]
    cases.sort(key=lambda case: case.number)
    if not cases:
        raise SceneError(
            "path", str(path), message=f"{path} holds no case that is to be calculated"
        )
    return WheelInput(str(path), cases)


class _Reader:
    """Wheels of cases; each profile, track and wheel set is made once."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._made: dict[Any, Any] = {}
        self._cases: dict[int, WheelCase] = {}

    def case(self, given: CaseInput, strict: bool) -> WheelCase:
        """One case."""
        line = given.group.line
        try:
            case = WheelCase(
                number=given.number,
                line=line,
                element=given.element,
                wheel=self._wheel(given),
                separating_angle=given.entries["grid"].angle(3),
                near_miss=given.entries["grid"].option(1, NO_NEAR_MISS),
                stresses=given.stress_points,
                **_simplified(given),
                **_forces(given),
                **self._step(given),
            )
        except SceneError as error:
            if strict:
                raise
            case = WheelCase(given.number, line, given.element, reason=str(error))
        self._cases[given.number] = case
        return case

    def _step(self, given: CaseInput) -> dict[str, Any]:
        """The distance of a step in time, and the case that it goes on from."""
        controls = given.controls
        if controls["TANG"] not in (SHIFT, TRANSIENT):
            return {}
        if controls["HEAT"] != 0:
            controls.complain("HEAT", "needs steady rolling, T = 3")
        rolled = 0.0
        if controls["TANG"] == TRANSIENT:
            elements = given.entries["grid"]
            rolled = elements.number(2) * elements.number(0)
        before = given.before
        while before is not None and not before.calculated:
            before = before.before
        if controls["PVTIME"] in (1, 2) or before is None:
            return {"rolled": rolled}
        last: WheelCase | None = self._cases[before.number]
        if controls["PVTIME"] == 3:
            assert last is not None
            last = last.before
        return {"rolled": rolled, "before": last}

    def _wheel(self, case: CaseInput) -> WheelOnRail:
        if case.module != 1:
            why = "is a basic contact: vc.read_contact_input reads it, `varcontact solve` solves it"
            case.group.refuse("MODULE", case.module, why)
        controls = case.controls
        controls.check_supported()
        _check_supported(case)
        side = SIDES[controls["CONFIG"]]
        bodies = bodies_of(case)
        grid = _grid(case)
        track, drop = self._track(case, side)
        wheelset = self._wheelset(case)
        place: Group = case.needs("position", "EWHEEL", "a position", "E = 3")
        height: dict[str, Any] = {"vertical_force": place.number(2)}
        if controls["NORM"] == 0:
            above = wheelset.radius - case.entries["wheel set"].number(2)
            height = {"z": place.number(2) - drop + above}
        if place.names[2] != ("Z", "FZ")[controls["NORM"]]:
            controls.complain(
                "NORM", "is another than the case before has, which is kept: use E >= 1"
            )
        with located(place):
            angles = {"roll": place.angle(3), "yaw": place.angle(4), "pitch": place.angle(5)}
            position = Position(s=place.number(0), y=place.number(1), **angles)
        velocity = _velocity(case)
        if controls["EWHEEL"] >= 4:
            position, velocity, lower = _of_wheel(case, position, velocity, wheelset, side)
            if "z" in height:
                height["z"] += lower
        friction: Any = 0.0
        if controls["TANG"] != 0:
            friction = _friction(case, velocity.speed, position.s)
        with located(case.group):
            return WheelOnRail(
                track=track,
                wheelset=wheelset,
                side=side,
                position=position,
                velocity=velocity,
                bodies=bodies,
                friction=friction,
                third_body=layer_of(case),
                thermal=thermal_of(case),
                **grid,
                **height,
            )

    def _once(self, key: Any, make: Any) -> Any:
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]

    def _track(self, case: CaseInput, side: Side) -> tuple[Track, float]:
        """The track, and how far its rail's top is below CONTACT's height 0."""
        dimensions: Group = case.needs("track", "ZTRACK", "track dimensions", "Z = 3")
        deviations: Group = case.needs("deviations", "ZTRACK", "deviations", "Z = 3")
        rail = self._profile(case.needs("rail", "ZTRACK", "a rail", "Z = 3"), "rail")
        rate = 0.0
        if case.controls["CONFIG"] <= 1 and dimensions.names[3] == "NOMRAD":
            case.controls.complain("CONFIG", "keeps a roller as its track: use Z = 3")
        if case.controls["CONFIG"] >= 4:
            rate = case.needs("velocity", "EWHEEL", "a velocity", "E = 3").angle(0)
        key = (dimensions, deviations, id(rail), side, rate)
        with located(dimensions):
            track: tuple[Track, float] = self._once(
                key, lambda: _track(dimensions, deviations, rail, side, rate)
            )
        return track

    def _wheelset(self, case: CaseInput) -> WheelSet:
        group: Group = case.needs("wheel set", "EWHEEL", "a wheel set", "E = 3")
        wheel = self._profile(case.needs("wheel", "EWHEEL", "a wheel", "E = 3"), "wheel")
        distance, back, radius = group.numbers()
        radius += _tape(group, wheel)

        def make() -> WheelSet:
            # CONTACT places wheels by FBDIST/2 - FBPOS alone, wherever their flanges are
            places = {"inside_distance": distance, "flange_back": back}
            tip = flange_tip(_first(wheel))
            if tip is not None and not 0 <= tip - back <= WIDEST_FLANGE:
                places = {"inside_distance": distance + 2 * (tip - back), "flange_back": tip}
            return WheelSet(wheel=wheel, radius=radius, **places)

        with located(group):
            wheelset: WheelSet = self._once((group, id(wheel)), make)
        return wheelset

    def _profile(self, groups: tuple[Group, ...], kind: Kind) -> Any:  # a Profile, or slices
        return self._once(groups, lambda: _profile(groups, kind, self._folder))


def _tape(group: Group, wheel: Any) -> float:
    """What the radius at the profile's origin is more than that at its tape circle."""
    place = group.option(0, NO_TAPE)
    profile = _first(wheel)
    on_profile = profile.y.min() <= place <= profile.y.max()
    if abs(place) >= NO_TAPE or not on_profile:
        return 0.0
    return -float(profile.z_at(np.array([place]))[0])


def _first(wheel: Profile | ProfileSlices) -> Profile:
    """A wheel's profile, or its first slice."""
    if isinstance(wheel, Profile):
        return wheel
    return wheel.first


def _check_supported(case: CaseInput) -> None:
    """Refuse what digits ask for that a wheel on a rail has not here."""
    controls = case.controls
    if case.damped:
        controls.refuse_damping()
    if controls["CONFIG"] >= 4:
        _check_roller(case)
    if controls["TANG"] in (SHIFT, TRANSIENT) and controls["DISCNS"] in (CONFORMAL, *BY_ELEMENT):
        controls.complain("DISCNS", "needs steady rolling, T = 3")
    if controls["FORCE"] != 0:
        _check_forces(controls)
    _check_material(controls)
    if controls["INFLCF"] == 4 and case.entries["conformal"].integers()[1] != 4:
        group = case.entries["conformal"]
        why = "is not reciprocal, and not supported; supported: 4"
        group.refuse("VARIANT", group.integers()[1], why)


def _check_material(controls: Controls) -> None:
    """Refuse viscoelastic bodies and simplified theory but in steady rolling, and FaStrip."""
    material = controls["MATER"]
    if material == FASTRIP:
        controls.complain("MATER", "is not supported: FaStrip is for Hertz's contact, in module 3")
    if material == VISCOELASTIC and controls["TANG"] != STEADY:
        controls.complain("MATER", "needs steady rolling, T = 3")
    if material in SIMPLIFIED:
        plain = controls["TANG"] == STEADY and controls["FORCE"] == 0 and controls["HEAT"] == 0
        if not plain or controls["DISCNS"] in (CONFORMAL, *BY_ELEMENT):
            why = "needs steady rolling (T = 3) by creepages (F = 0), H = 0, and D = 2 or 5"
            controls.complain("MATER", why)


def _simplified(case: CaseInput) -> dict[str, Any]:
    """How simplified theory is asked for by M = 2 or 3, see `SimplifiedTheory`."""
    material = case.controls["MATER"]
    if material not in SIMPLIFIED:
        return {}
    flexibility = None
    if material == 2:
        group = case.needs("flexibility", "MATER", "a flexibility", "C = 2")
        flexibility, *slope = group.numbers()
    else:
        slope = case.needs("slope", "MATER", "slopes", "C = 2").numbers()
    theory = SimplifiedTheory(elliptic=None, flexibility=flexibility, slope=tuple(slope))
    return {"simplified": theory}


def _check_forces(controls: Controls) -> None:
    """Refuse forces that no motion gives."""
    if controls["TANG"] == 0:
        controls.complain("FORCE", "needs friction, T = 3")
    if controls["FORCE"] in (1, 2):
        if controls["NORM"] == 0:
            controls.complain("FORCE", "needs the vertical force, N = 1")
        if controls["TANG"] == SHIFT:
            controls.complain("FORCE", "needs rolling, T = 2 or 3")


def _forces(case: CaseInput) -> dict[str, Any]:
    """What is given of F = 1, 2 and 3 in place of the motion of the wheel, or the place of the
    rail.
    """
    force = case.controls["FORCE"]
    if force in (1, 2):
        given = {1: "longitudinal_force", 2: "axle_moment"}[force]
        return {given: case.entries["velocity"].number(5)}
    if force == 3:
        return {"springs": _springs(case)}
    return {}


def _springs(case: CaseInput) -> RailSprings:
    """The springs of F = 3."""
    group: Group = case.needs("springs", "FORCE", "the springs of a rail", "Z = 3")
    lateral, sideways, vertical, down = group.numbers()
    if lateral < 0 or vertical < 0:
        group.refuse("KYRAIL, KZRAIL", (lateral, vertical), "is negative")
    if vertical == 0 and case.controls["NORM"] == 0:
        group.refuse("KZRAIL", vertical, "is zero, and the height of the wheel set is given")
    return RailSprings((lateral, vertical), (sideways, down))


def _check_roller(case: CaseInput) -> None:
    """Refuse a roller of which the track or the velocity kept is none, or that is not below."""
    track: Group = case.needs("track", "ZTRACK", "roller dimensions", "Z = 3")
    velocity: Group = case.needs("velocity", "EWHEEL", "a velocity", "E = 3")
    if track.names[3] != "NOMRAD" or velocity.names[0] != "VPITCH_ROL":
        why = "needs NOMRAD and VPITCH_ROL, and a track is kept: use Z = 3 and E = 2"
        case.controls.complain("CONFIG", why)
    place: Group = case.needs("position", "EWHEEL", "a position", "E = 3")
    if place.number(0) != 0:
        why = "is not supported: wheels here are above the roller's axle"
        place.refuse("X", place.number(0), why)


def _of_wheel(
    case: CaseInput, position: Position, velocity: Velocity, wheelset: WheelSet, side: Side
) -> tuple[Position, Velocity, float]:
    """Place and motion of a rigid wheel set whose wheel is where that of the flexible one is, and
    how much lower it is; for small deviations.
    """
    place: Group = case.entries["wheel place"]
    rates: Group = case.entries["wheel rates"]
    arm = SIGN[side] * wheelset.middle
    roll, yaw, pitch = (place.angle(k) for k in range(3, 6))
    roll_rate, yaw_rate, pitch_rate = (rates.angle(k) for k in range(3, 6))
    with located(place):
        moved = replace(
            position,
            s=position.s + place.number(0) + arm * yaw,
            y=position.y + place.number(1),
            roll=position.roll + roll,
            yaw=position.yaw + yaw,
            pitch=position.pitch + pitch,
        )
    turning = velocity.pitch_rate
    if turning is not None:
        turning += pitch_rate
    with located(rates):
        moving = replace(
            velocity,
            speed=velocity.speed + rates.number(0) + arm * yaw_rate,
            lateral=velocity.lateral + rates.number(1),
            vertical=velocity.vertical + rates.number(2) - arm * roll_rate,
            roll_rate=velocity.roll_rate + roll_rate,
            yaw_rate=velocity.yaw_rate + yaw_rate,
            pitch_rate=turning,
        )
    return moved, moving, place.number(2) - arm * roll


def _friction(case: CaseInput, speed: float, s: float) -> Any:
    """A coefficient or law, by inclination, or at the place along the track."""
    groups = laws_of(case)
    law = kept_law(case)
    if law == BY_TEMPERATURE and case.controls["HEAT"] == 0:
        case.controls.complain("FRCLAW", "needs temperatures, H = 3")
    varies = case.controls["VARFRC"]
    if varies == 0:
        return friction_law(law, groups[0], groups, speed)
    if varies == 2:
        return friction_law(law, _at_place(groups, law, s), groups, speed)
    if law != 0:
        why = "of friction that varies by inclination is not supported; supported: 0"
        case.controls.complain("FRCLAW", why)
    coefficients: list[Any] = [friction_law(law, group, groups, speed) for group in groups]
    # to the track side angles are negative there, positive here
    angles = [-group.angle(0) for group in groups]
    with located(groups[0]):
        return FrictionByAngle(angles[::-1], coefficients[::-1], by_patch=True)


def _at_place(groups: tuple[Group, ...], law: int, s: float) -> Group:
    """The entries of a friction law at a place along the track, linear between those given."""
    rows = groups
    if law != 0:  # the last has the memory
        rows = groups[:-1]
    places = [group.number(0) for group in rows]
    if np.any(np.diff(places) <= 0):
        rows[0].refuse("SVF", places, "does not ascend")
    values = np.transpose([group.numbers() for group in rows])
    here = [float(np.interp(s, places, row)) for row in values]
    return replace(rows[0], values=tuple(map(repr, here)))


def _grid(case: CaseInput) -> dict[str, Any]:
    """Elements, and distances of patches."""
    elements: Group = case.needs("grid", "DISCNS", "a grid", "D = 2")
    if elements.number(2) != 1 and case.controls["GAUSEI"] == CONVEX_GS:
        reason = "with G = 2 is not supported: the step of rolling here is an element; supported: 1"
        elements.refuse("DQREL", elements.number(2), reason)
    places = {"dx": 0, "dy": 1, "separate": 4, "join": 5}
    grid: dict[str, Any] = {name: elements.number(k) for name, k in places.items()}
    if elements.optional:
        grid["turn"] = elements.option(0, 0.0)
    found: CaseInput | None = case
    while found is not None and found.controls["DISCNS"] <= 1:
        found = found.before
    assert found is not None
    grid["conformal"] = found.controls["DISCNS"] == CONFORMAL
    grid["slip_by_element"] = found.controls["DISCNS"] in BY_ELEMENT
    return grid


def _track(
    dimensions: Group, deviations: Group, rail: Any, side: Side, rate: float
) -> tuple[Track, float]:
    """The track with its rails, and how far the rail's top is below CONTACT's height 0."""
    height, second, third = (dimensions.number(k) for k in range(3))
    rails: dict[str, Any] = {"rail": rail, side: _irregularity(deviations)}
    if dimensions.names[3] == "NOMRAD":
        rails |= {"roller_radius": dimensions.number(3), "roller_rate": rate}
    else:
        rails["cant"] = dimensions.angle(3)
    curvature = dimensions.option(0, 0.0)
    if curvature != 0:
        rails["curve_radius"] = 1 / curvature
    if height > 0:  # GAUGSQ does nothing in CONTACT
        return Track(gauge=third, gauge_height=height, **rails), 0.0
    # the rail's origin is given; its top has the height 0 here, and the gauge may be measured
    # anywhere
    track = Track(gauge_height=0.0, **rails)
    beside = SIGN[side] * second - float(track.origin[0])
    track = replace(track, gauge=track.gauge + 2 * beside)
    return track, third - float(track.origin[1])


def _irregularity(deviations: Group) -> Irregularity:
    places = {"y": 0, "z": 1, "lateral": 3, "vertical": 4}
    numbers = {name: deviations.number(k) for name, k in places.items()}
    angles = {"roll": deviations.angle(2), "roll_rate": deviations.angle(5)}
    with located(deviations):
        return Irregularity(**numbers, **angles)


def _profile(groups: tuple[Group, ...], kind: Kind, folder: Path) -> Any:
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


def _velocity(case: CaseInput) -> Velocity:
    group: Group = case.needs("velocity", "EWHEEL", "a velocity", "E = 3")
    _, lateral, vertical = (group.number(k) for k in range(3))
    speed = group.angle(0)
    if case.controls["CONFIG"] >= 4:  # coordinates that move as the roller's top would
        speed *= case.entries["track"].number(3)
    roll_rate = group.angle(3)
    yaw_rate = group.angle(4)
    pitch_rate = None
    if group.names[5] == "VPITCH":
        pitch_rate = group.angle(5)
    given = {1: "FX", 2: "MY"}.get(case.controls["FORCE"], "VPITCH")
    if group.names[5] != given:
        case.controls.complain("FORCE", f"needs a velocity with {given}: use E = 2")
    with located(group):
        return Velocity(
            speed=speed,
            lateral=lateral,
            vertical=vertical,
            roll_rate=roll_rate,
            yaw_rate=yaw_rate,
            pitch_rate=pitch_rate,
        )
