"""Wheels on rails from the input files of CONTACT, module 1.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech
CMCC report 20-01) and of the open-source release (the module ``m_wr_input`` of
its source), see `varcontact.io.contact_grammar`. Lengths are in mm, forces in
N, velocities in mm/s.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_cases import CaseInput, read_cases
from varcontact.io.contact_grammar import Controls
from varcontact.io.contact_material import (
    VISCOELASTIC,
    bodies_of,
    flexibility_of,
    friction_law,
    kept_law,
    laws_of,
    layer_of,
    thermal_of,
)
from varcontact.io.contact_words import Group, located
from varcontact.theories.fastsim_contact import SimplifiedTheory
from varcontact.wheel_rail.contact_cases import NO_NEAR_MISS, WheelCase, WheelInput
from varcontact.wheel_rail.contact_motion import (
    SHIFT,
    check_forces,
    forces_of,
    moved_to_wheel,
    velocity_of,
)
from varcontact.wheel_rail.contact_profiles import first_slice, profile_of, radius_above_tape
from varcontact.wheel_rail.contact_track import check_roller, track_of
from varcontact.wheel_rail.position import Position
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.regions import FrictionByAngle
from varcontact.wheel_rail.track import (
    WIDEST_FLANGE,
    Side,
    Track,
    WheelSet,
    flange_tip,
)
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

SIDES: dict[int, Side] = {0: "left", 1: "right", 4: "left", 5: "right"}
CONVEX_GS = 2
"""The control digit G of the one solver of CONTACT that takes any DQREL in steady rolling."""
TRANSIENT = 2
STEADY = 3
"""Values of the digit T for rolling in time and for steady rolling."""
BY_TEMPERATURE = 6
"""Value of the digit L for friction by temperature."""
SIMPLIFIED = (2, 3)
FASTRIP = 5
"""Values of the digit M for simplified theories and for FaStrip."""
CONFORMAL = 4
BY_ELEMENT = (3, 6)
"""Values of the digit D for curved patches, and for planar patches with a rigid slip by element."""


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
        forces on the rail, those of friction included, as FZ is. Cases of steps
        in time, by forces (F = 1 to 3) or by simplified theory are not in it,
        but in its `cases`; ``print`` tells which.

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
    if strict and unreadable:  # errors in earlier cases come first
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
    """Reader of cases as wheels; builds each profile, track and wheel set once."""

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
                **forces_of(given),
                **self._step(given),
            )
        except SceneError as error:
            if strict:
                raise
            case = WheelCase(given.number, line, given.element, reason=str(error))
        self._cases[given.number] = case
        return case

    def _step(self, given: CaseInput) -> dict[str, Any]:
        """Distance of a step in time, and the case that it continues."""
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
        velocity = velocity_of(case)
        if controls["EWHEEL"] >= 4:
            position, velocity, lower = moved_to_wheel(case, position, velocity, wheelset, side)
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
                key, lambda: track_of(dimensions, deviations, rail, side, rate)
            )
        return track

    def _wheelset(self, case: CaseInput) -> WheelSet:
        group: Group = case.needs("wheel set", "EWHEEL", "a wheel set", "E = 3")
        wheel = self._profile(case.needs("wheel", "EWHEEL", "a wheel", "E = 3"), "wheel")
        distance, back, radius = group.numbers()
        radius += radius_above_tape(group, wheel)

        def make() -> WheelSet:
            # CONTACT places wheels by FBDIST/2 - FBPOS alone, wherever their flanges are
            places = {"inside_distance": distance, "flange_back": back}
            tip = flange_tip(first_slice(wheel))
            if tip is not None and not 0 <= tip - back <= WIDEST_FLANGE:
                places = {"inside_distance": distance + 2 * (tip - back), "flange_back": tip}
            return WheelSet(wheel=wheel, radius=radius, **places)

        with located(group):
            wheelset: WheelSet = self._once((group, id(wheel)), make)
        return wheelset

    def _profile(self, groups: tuple[Group, ...], kind: Kind) -> Any:  # a Profile, or slices
        return self._once(groups, lambda: profile_of(groups, kind, self._folder))


def _check_supported(case: CaseInput) -> None:
    """Refuse values of digits that a wheel on a rail does not support here."""
    controls = case.controls
    if case.damped:
        controls.refuse_damping()
    if controls["CONFIG"] >= 4:
        check_roller(case)
    if controls["TANG"] in (SHIFT, TRANSIENT) and controls["DISCNS"] in (CONFORMAL, *BY_ELEMENT):
        controls.complain("DISCNS", "needs steady rolling, T = 3")
    if controls["FORCE"] != 0:
        check_forces(controls)
    _check_material(controls)
    if controls["INFLCF"] == 4 and case.entries["conformal"].integers()[1] != 4:
        group = case.entries["conformal"]
        why = "is not reciprocal, and not supported; supported: 4"
        group.refuse("VARIANT", group.integers()[1], why)


def _check_material(controls: Controls) -> None:
    """Refuse viscoelastic bodies and simplified theory outside steady rolling, and FaStrip."""
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
    """Option `simplified` for M = 2 or 3 (see `SimplifiedTheory`), else none."""
    if case.controls["MATER"] not in SIMPLIFIED:
        return {}
    flexibility, slope = flexibility_of(case)
    return {"simplified": SimplifiedTheory(elliptic=None, flexibility=flexibility, slope=slope)}


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
