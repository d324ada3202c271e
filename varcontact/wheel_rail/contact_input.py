"""Wheels on rails from the input files of CONTACT, module 1.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech CMCC report 20-01) and of the
open-source release (the module ``m_wr_input`` of its source). Lengths are in mm, forces in N, velocities in mm/s.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_input import Friction, read_friction
from varcontact.io.contact_words import SUPPORTED as BASIC
from varcontact.io.contact_words import WORDS as BASIC_WORDS
from varcontact.io.contact_words import Group, Lines, number_of, skip_iterations, skip_stresses
from varcontact.scene.bodies import Bodies
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.track import SIGN, Position, Side, Track, Velocity, WheelSet
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

PROBLEM = ("CONFIG", "PVTIME", "BOUND", "TANG", "NORM", "FORCE", "STRESS")
GEOMETRY = ("VARFRC", "FRCLAW", "DISCNS", "INFLCF", "MATER", "ZTRACK", "EWHEEL")
SIDES: dict[int, Side] = {0: "left", 1: "right"}
SUPPORTED: dict[str, dict[int, str]] = BASIC | {
    "C": {0: "left wheel on a track", 1: "right wheel on a track"},
    "P": {0: "continue", 1: "begin", 2: "no sequence"},
    "B": {0: "half-space"},
    "T": {0: "no tangential problem", 3: "steady rolling"},
    "N": {0: "height of the wheel set given", 1: "vertical force given"},
    "F": {0: "pitch rate given"},
    "D": {0: "as before", 1: "as before", 2: "planar contact", 5: "planar contact, another search"},
    "Z": {0: "as before", 1: "new dimensions", 2: "new deviations", 3: "new dimensions, profile and deviations"},
    "E": {0: "as before", 1: "new position", 2: "new position and velocity", 3: "new wheel set, position and velocity"},
}
"""Values of the control digits that are read, but for INFLCF: see `BASIC`."""
SLICES = ".slcs"


def read_contact_input(path: str | Path) -> list[WheelOnRail]:
    """The cases of an input file of CONTACT, module 1, as wheels on rails.

    Parameters
    ----------
    path : str or Path
        A file ``<experiment>.inp``. Profiles that it names are looked for from its folder.

    Returns
    -------
    list of WheelOnRail
        In the order of the file. Given forces are all forces on the rail, those of friction included, as FZ is.

    Raises
    ------
    SceneError
        If the file or a profile cannot be read, or the file has what has no counterpart here: with the line, the entry,
        its value, and those that are supported (docs/from_contact.md has all of them).

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
    lines, before = Lines(file), _Case()
    wheels: list[WheelOnRail] = []
    while lines.more():
        group = lines.group("MODULE")
        (module,) = group.integers()
        if module == 0:
            break
        if module == 3:
            group.refuse(
                "MODULE", module, "is a basic contact: vc.read_contact_input reads it, `varcontact solve` solves it"
            )
        if module != 1:
            group.refuse("MODULE", module, "is not supported; supported: 1 (wheel on rail), 0 (stop)")
        if group.rest and number_of(group.rest[0]) is not None:
            group.refuse("MODULE", module, f"with result element {group.rest[0]} is not supported; use one")
        before, calculated = _case(lines, before, file.parent, group)
        if calculated:
            wheels.append(_wheel(before, group))
    if not wheels:
        raise SceneError("path", str(path), message=f"{path} holds no case that is to be calculated")
    return wheels


@dataclass(frozen=True)
class _Case:
    """What one case has, and the next may keep."""

    side: Side = "right"
    friction: Friction | None = None
    has_friction: bool = True
    bodies: Bodies | None = None
    grid: dict[str, float] = field(default_factory=dict)
    dimensions: tuple[float, ...] = ()
    """GAUGHT, GAUGSQ or RAILY0, GAUGWD or RAILZ0, CANT."""
    rail: Profile | None = None
    wheelset: WheelSet | None = None
    height: dict[str, float] = field(default_factory=dict)
    position: Position | None = None
    velocity: Velocity | None = None


def _case(lines: Lines, before: _Case, folder: Path, group: Group) -> tuple[_Case, bool]:
    """The next case, which keeps of the one before what it does not give, and whether it is to be calculated."""
    problem, _ = lines.digits("CPBTNFS", PROBLEM, SUPPORTED)
    digits, material = lines.digits("VLDCMZE", GEOMETRY, SUPPORTED | {"C": BASIC["C"]})
    if material.rest and number_of(material.rest[0]) not in (None, 0.0):
        material.refuse("M2 (MATER2)", material.rest[0], "is not supported; supported: 0 (no damping)")
    last, _ = lines.digits("XHGIAOWR", BASIC_WORDS["XHGIAOWR"], SUPPORTED)
    for letter, given, kept in (
        ("L", digits["L"] != 1, before.friction),
        ("C", digits["C"] == 2, before.bodies),
        ("D", digits["D"] >= 2, before.grid),
        ("Z", digits["Z"] == 3, before.rail),
        ("E", digits["E"] == 3, before.wheelset),
    ):
        if not given and not kept:
            group.refuse(letter, digits[letter], "keeps what the case before has, and there is none")
    skip_iterations(lines, last["G"])
    case = replace(before, side=SIDES[problem["C"]], has_friction=problem["T"] != 0)
    if digits["L"] != 1:
        case = replace(case, friction=read_friction(lines, digits["L"]))
    if digits["C"] == 2:
        elastic = lines.group("POISS 1", "POISS 2", "GG 1", "GG 2")
        nu1, nu2, G1, G2 = elastic.numbers()
        with _located(elastic):
            case = replace(case, bodies=Bodies(G=(G1, G2), nu=(nu1, nu2)))
    if digits["D"] >= 2:
        case = replace(case, grid=_grid(lines))
    case = _track(lines, case, digits["Z"], folder)
    case = _wheelset(lines, case, digits["E"], problem["N"], folder)
    skip_stresses(lines, problem["S"])
    wanted = "vertical_force" if problem["N"] else "z"
    if wanted not in case.height:
        group.refuse(
            "N (NORM)", problem["N"], "is another than the case before has, whose wheel set is kept: use E >= 1"
        )
    return case, last["R"] == 1


def _grid(lines: Lines) -> dict[str, float]:
    """Elements and distances of patches, as `WheelOnRail` takes them."""
    group = lines.group("DX", "DS", "DQREL", "A_SEP", "D_SEP", "D_COMB")
    dx, dy, dqrel = (group.number(k) for k in range(3))
    if dqrel != 1:
        group.refuse("DQREL", dqrel, "is not supported: the step of rolling here is an element; supported: 1")
    if group.angle(3) < math.pi / 2 - 1e-6:
        group.refuse(
            "A_SEP", group.values[3], "is not supported: patches here are separated by distance; supported: 90d"
        )
    grid = {"dx": dx, "dy": dy, "separate": group.number(4), "join": group.number(5)}
    more = [value for value in map(number_of, group.rest[:2]) if value is not None]
    if len(more) == 2:
        group.refuse("GAP_MISS", more[1], "is not supported; leave it out")
    return grid | dict(zip(("turn",), more, strict=False))


def _track(lines: Lines, case: _Case, digit: int, folder: Path) -> _Case:
    """Track dimensions, the rail's profile, and its deviations, which must be none."""
    if digit in (1, 3):
        first = lines.group("GAUGHT", "GAUGSQ or RAILY0", "GAUGWD or RAILZ0", "CANT")
        height, second, third = (first.number(k) for k in range(3))
        if height > 0 and second not in (0, 1):
            first.refuse(
                "GAUGSQ", second, "is not supported: the gauge is measured at the innermost face; supported: 0, 1"
            )
        if first.rest and number_of(first.rest[0]) not in (None, 0.0):
            first.refuse("CURV", first.rest[0], "is not supported: the track here is straight; supported: 0")
        case = replace(case, dimensions=(height, second, third, first.angle(3)))
    if digit == 3:
        case = replace(case, rail=_profile(lines, "rail", folder))
    if digit >= 2:
        deviations = lines.group("DY", "DZ", "ROLL", "VY", "VZ", "VROLL")
        for k, name in enumerate(deviations.names):
            if deviations.angle(k) != 0:
                deviations.refuse(
                    name, deviations.values[k], "is not supported: rails have no deviations; supported: 0"
                )
    return case


def _profile(lines: Lines, kind: Kind, folder: Path) -> Profile:
    """The profile that a file has."""
    group = lines.group(f"{kind[0].upper()}FNAME", "MIRRORY", "SCALE", "SMOOTH")
    name = group.values[0].strip("'\"").replace("\\", "/")
    if name.lower().endswith(SLICES):
        group.refuse(group.names[0], group.values[0], "is a variable profile (slices); supported: one cross section")
    options = [value for value in map(number_of, group.rest[:2]) if value is not None]
    mirror_y, mirror_z, option = group.number(1), *(int(value) for value in [*options, 0, 0][:2])
    method = 0
    if option >= 1:
        more = lines.group("ISMOOTH", "ZIGTHRS", "KINKHIGH", "KINKLOW", "KINKWID")
        method = int(more.number(0))
        if method not in (0, 1):
            more.refuse("ISMOOTH", method, "is not supported; supported: 0, 1")
    if option >= 2:
        lines.group("ERRHND", "MAXOMIT")
    smooth = group.number(3)
    read: dict[str, Any] = {"scale": group.number(2), "smoothing": smooth if method == 1 else 0.0}
    read["mirror_y"] = {1: True, -1: False}.get(int(mirror_y), "auto")
    with _located(group):
        try:
            profile = Profile.read(folder / name, kind, mirror_z=mirror_z == 1, **read)
        except SceneError as error:
            if error.field != "profile.z" or mirror_z != 0:
                raise
            profile = Profile.read(folder / name, kind, mirror_z=True, **read)
        return _smoothed(profile, smooth) if method == 0 and smooth > 0 else profile


def _smoothed(profile: Profile, weight: float) -> Profile:
    """The profile smoothed as by ISMOOTH = 0, whose weight multiplies the integral of the squared second derivative.

    The squared distances are summed over points: an integral by their spacing, for evenly spaced ones.
    """
    spacing = float(np.median(np.hypot(np.diff(profile.y), np.diff(profile.z))))
    length = 2 * math.pi * (weight * spacing) ** 0.25
    return profile.smoothed(length) if length >= spacing else profile


def _wheelset(lines: Lines, case: _Case, digit: int, norm: int, folder: Path) -> _Case:
    """Wheel set, its position and its velocity."""
    if digit == 3:
        group = lines.group("FBDIST", "FBPOS", "NOMRAD")
        distance, back, radius = group.numbers()
        wheel = _profile(lines, "wheel", folder)
        with _located(group):
            wheelset = WheelSet(wheel=wheel, radius=radius, inside_distance=distance, flange_back=back)
        case = replace(case, wheelset=wheelset)
    if digit >= 1:
        group = lines.group("S", "Y", "FZ" if norm else "Z", "ROLL", "YAW", "PITCH")
        height = {"vertical_force" if norm else "z": group.number(2)}
        with _located(group):
            position = Position(y=group.number(1), roll=group.angle(3), yaw=group.angle(4))
        case = replace(case, height=height, position=position)
    if digit >= 2:
        group = lines.group("VS", "VY", "VZ", "VROLL", "VYAW", "VPITCH")
        speed, lateral, vertical = (group.number(k) for k in range(3))
        roll, yaw, pitch = (group.angle(k) for k in range(3, 6))
        with _located(group):
            velocity = Velocity(
                speed=speed, lateral=lateral, vertical=vertical, roll_rate=roll, yaw_rate=yaw, pitch_rate=pitch
            )
        case = replace(case, velocity=velocity)
    return case


def _wheel(case: _Case, group: Group) -> WheelOnRail:
    """The case as a wheel on a rail."""
    assert case.friction is not None
    assert case.bodies is not None
    assert case.rail is not None
    assert case.wheelset is not None
    assert case.position is not None
    assert case.velocity is not None
    gauge_height, second, third, cant = case.dimensions
    height = dict(case.height)
    with _located(group):
        if gauge_height > 0:
            track = Track(rail=case.rail, gauge=third, gauge_height=gauge_height, cant=cant)
        else:
            track, drop = _by_origin(case.rail, SIGN[case.side] * second, third, cant)
            height |= {"z": height["z"] - drop} if "z" in height else {}
        return WheelOnRail(
            track=track,
            wheelset=case.wheelset,
            side=case.side,
            position=case.position,
            velocity=case.velocity,
            with_friction=True,
            bodies=case.bodies,
            friction=case.friction.at(case.velocity.speed) if case.has_friction else 0.0,
            **case.grid,
            **height,
        )


def _by_origin(rail: Profile, y: float, z: float, cant: float) -> tuple[Track, float]:
    """The track whose rail's origin is at y, with the rail's top at 0, and how far down it is in CONTACT's track.

    Where the gauge is measured does not matter then: any height that all rails reach.
    """
    some = Track(rail=rail, gauge_height=ANY_HEIGHT, cant=cant)
    track = replace(some, gauge=some.gauge + 2 * (y - float(some.origin[0])))
    return track, z - float(track.origin[1])


ANY_HEIGHT = 1.0


@contextmanager
def _located(group: Group) -> Iterator[None]:
    """Errors within get the line of the group."""
    try:
        yield
    except SceneError as error:
        message = f"{group.path}, line {group.line}: {error}"
        raise SceneError(error.field, error.value, message=message) from None
