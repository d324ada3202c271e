"""Wheels on rails from the input files of CONTACT, module 1.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech
CMCC report 20-01) and of the open-source release (the module ``m_wr_input`` of
its source). Lengths are in mm, forces in N, velocities in mm/s.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_input import read_bodies, read_friction
from varcontact.io.contact_words import SUPPORTED as BASIC
from varcontact.io.contact_words import (
    Group,
    Lines,
    Supported,
    control_digits,
    located,
    modules,
    number_of,
    skip_stresses,
)
from varcontact.wheel_rail.position import Position, Velocity
from varcontact.wheel_rail.profile import Profile
from varcontact.wheel_rail.profile_files import Kind
from varcontact.wheel_rail.slices import SLICES, ProfileSlices
from varcontact.wheel_rail.track import SIGN, Side, Track, WheelSet
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

SIDES: dict[int, Side] = {0: "left", 1: "right"}
SUPPORTED: Supported = BASIC | {
    "C": ("CONFIG", {0: "left wheel on a track", 1: "right wheel on a track"}),
    "P": ("PVTIME", {0: "continue", 1: "begin", 2: "no sequence"}),
    "B": ("BOUND", {0: "half-space"}),
    "T": ("TANG", {0: "no tangential problem", 3: "steady rolling"}),
    "N": ("NORM", {0: "height of the wheel set given", 1: "vertical force given"}),
    "F": ("FORCE", {0: "pitch rate given"}),
    "D": (
        "DISCNS",
        {0: "as before", 1: "as before", 2: "planar contact", 5: "planar contact, another search"},
    ),
    "Z": ("ZTRACK", {0: "as before", 1: "new dimensions", 2: "new deviations", 3: "all new"}),
    "E": (
        "EWHEEL",
        {0: "as before", 1: "new position", 2: "new position and velocity", 3: "all new"},
    ),
}
"""Control digits that are read, but for INFLCF: see `BASIC`."""

Case = dict[str, Any]
"""Entries of a case, which the next may keep: those of `WheelOnRail`, "rail", "grid", "height",
"has_friction", and "dimensions", which are GAUGHT, GAUGSQ or RAILY0, GAUGWD or RAILZ0, and CANT."""


@checks.named_options()
def read_contact_input(path: str | Path) -> list[WheelOnRail]:
    """The cases of an input file of CONTACT, module 1, as wheels on rails.

    Parameters
    ----------
    path : str or Path
        A file ``<experiment>.inp``. Profiles that it names are looked for from
        its folder.

    Returns
    -------
    list of WheelOnRail
        In the order of the file. Given forces are all forces on the rail, those
        of friction included, as FZ is.

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
    lines = Lines(file)
    case = Case()
    wheels: list[WheelOnRail] = []
    scene = "is a basic contact: vc.read_contact_input reads it, `varcontact solve` solves it"
    for group in modules(lines, 1, "wheel on rail", {3: scene}):
        calculated = _read_case(lines, case, file.parent, group)
        if calculated:
            wheels.append(_wheel(case, group))
    if not wheels:
        raise SceneError(
            "path", str(path), message=f"{path} holds no case that is to be calculated"
        )
    return wheels


def _read_case(lines: Lines, case: Case, folder: Path, group: Group) -> bool:
    """Change the entries of the case before to those of the next one; True if that is to be
    calculated.
    """
    _, problem, digits, last = control_digits(
        lines, "CPBTNFS", SUPPORTED, SUPPORTED | {"C": BASIC["C"]}
    )
    L, C, D, Z, E = (digits[letter] for letter in "LCDZE")
    # parts that are new; others are those of the case before
    entries = {"L": "friction", "C": "bodies", "D": "grid", "Z": "rail", "E": "wheelset"}
    new = {"L": L != 1, "C": C == 2, "D": D >= 2, "Z": Z == 3, "E": E == 3}
    for letter, name in entries.items():
        if not new[letter] and name not in case:
            group.refuse(
                letter, digits[letter], "keeps what the case before has, and there is none"
            )
    case.update(side=SIDES[problem["C"]], has_friction=problem["T"] != 0)
    if new["L"]:
        case["friction"] = read_friction(lines, L)
    if new["C"]:
        case["bodies"] = read_bodies(lines)
    if new["D"]:
        case["grid"] = _read_grid(lines)
    _read_track(lines, case, Z, folder)
    _read_wheelset(lines, case, E, problem["N"], folder)
    skip_stresses(lines, problem["S"])
    if _height(problem["N"]) not in case["height"]:
        reason = "is another than the case before has, which is kept: use E >= 1"
        group.refuse("N (NORM)", problem["N"], reason)
    return last["R"] == 1


def _height(norm: int) -> str:
    """The entry that has the height of the wheel set, by the digit N."""
    return "vertical_force" if norm else "z"


def _read_grid(lines: Lines) -> dict[str, float]:
    """Elements, and distances of patches."""
    elements = lines.group("DX", "DS", "DQREL", "A_SEP", "D_SEP", "D_COMB")
    if elements.number(2) != 1:
        reason = "is not supported: the step of rolling here is an element; supported: 1"
        elements.refuse("DQREL", elements.number(2), reason)
    if elements.angle(3) < math.pi / 2 - 1e-6:
        reason = "is not supported: patches here are separated by distance; supported: 90d"
        elements.refuse("A_SEP", elements.values[3], reason)
    options = [value for value in map(number_of, elements.rest[:2]) if value is not None]
    if len(options) == 2:
        elements.refuse("GAP_MISS", options[1], "is not supported; leave it out")
    places = {"dx": 0, "dy": 1, "separate": 4, "join": 5}
    grid = {name: elements.number(k) for name, k in places.items()}
    if options:
        grid["turn"] = options[0]
    return grid


def _read_track(lines: Lines, case: Case, digit: int, folder: Path) -> None:
    """Track dimensions, the rail's profile, and its deviations, which must be none."""
    if digit in (1, 3):
        first = lines.group("GAUGHT", "GAUGSQ or RAILY0", "GAUGWD or RAILZ0", "CANT")
        height, second, third = (first.number(k) for k in range(3))
        if height > 0 and second not in (0, 1):
            reason = "is not supported: the gauge is that of the innermost face; supported: 0, 1"
            first.refuse("GAUGSQ", second, reason)
        if first.rest and number_of(first.rest[0]) not in (None, 0.0):
            reason = "is not supported: the track here is straight; supported: 0"
            first.refuse("CURV", first.rest[0], reason)
        case["dimensions"] = height, second, third, first.angle(3)
    if digit == 3:
        case["rail"] = _profile(lines, "rail", folder)
    if digit >= 2:
        deviations = lines.group("DY", "DZ", "ROLL", "VY", "VZ", "VROLL")
        for k, name in enumerate(deviations.names):
            if deviations.angle(k) != 0:
                reason = "is not supported: rails have no deviation; supported: 0"
                deviations.refuse(name, deviations.values[k], reason)


def _profile(lines: Lines, kind: Kind, folder: Path) -> Any:  # a Profile, or slices
    group = lines.group(f"{kind[0].upper()}FNAME", "MIRRORY", "SCALE", "SMOOTH")
    name = group.values[0].strip("'\"").replace("\\", "/")
    smooth = group.number(3)
    options = [value for value in map(number_of, group.rest[:2]) if value is not None]
    mirror_z, option = (int(value) for value in [*options, 0, 0][:2])
    method = 0
    if option >= 1:
        more = lines.group("ISMOOTH", "ZIGTHRS", "KINKHIGH", "KINKLOW", "KINKWID")
        method = int(more.number(0))
        if method not in (0, 1):
            more.refuse("ISMOOTH", method, "is not supported; supported: 0, 1")
    if option >= 2:
        lines.group("ERRHND", "MAXOMIT")
    reader: Any = Profile.read
    if name.lower().endswith(SLICES):
        reader = ProfileSlices.read
        if method == 0 and smooth > 0:
            reason = "is not supported for slices with ISMOOTH = 0; supported: 0, or ISMOOTH = 1"
            group.refuse("SMOOTH", smooth, reason)
    mirrors = {1: True, -1: False}
    with located(group):
        profile = reader(
            folder / name,
            kind,
            scale=group.number(2),
            smoothing=smooth if method == 1 else 0.0,
            mirror_y=mirrors.get(int(group.number(1)), "auto"),
            mirror_z=mirrors.get(mirror_z),
        )
        if method == 0 and smooth > 0:
            profile = _smoothed(profile, smooth)
        return profile


def _smoothed(profile: Profile, weight: float) -> Profile:
    """The profile with ISMOOTH = 0, by a weight of the integral of the squared second derivative.

    The squared distances are summed over points, which is an integral, divided by their spacing.
    """
    spacing = float(np.median(np.hypot(np.diff(profile.y), np.diff(profile.z))))
    length = 2 * math.pi * (weight * spacing) ** 0.25
    if length < spacing:
        return profile
    return profile.smoothed(length)


def _read_wheelset(lines: Lines, case: Case, digit: int, norm: int, folder: Path) -> None:
    """Wheel set, its position and its velocity."""
    if digit == 3:
        group = lines.group("FBDIST", "FBPOS", "NOMRAD")
        distance, back, radius = group.numbers()
        wheel = _profile(lines, "wheel", folder)
        with located(group):
            case["wheelset"] = WheelSet(
                wheel=wheel, radius=radius, inside_distance=distance, flange_back=back
            )
    if digit >= 1:
        group = lines.group("S", "Y", "FZ" if norm else "Z", "ROLL", "YAW", "PITCH")
        case["height"] = {_height(norm): group.number(2)}
        with located(group):
            places = {"roll": group.angle(3), "yaw": group.angle(4), "pitch": group.angle(5)}
            case["position"] = Position(s=group.number(0), y=group.number(1), **places)
    if digit >= 2:
        group = lines.group("VS", "VY", "VZ", "VROLL", "VYAW", "VPITCH")
        speed, lateral, vertical = (group.number(k) for k in range(3))
        roll_rate, yaw_rate, pitch_rate = (group.angle(k) for k in range(3, 6))
        with located(group):
            case["velocity"] = Velocity(
                speed=speed,
                lateral=lateral,
                vertical=vertical,
                roll_rate=roll_rate,
                yaw_rate=yaw_rate,
                pitch_rate=pitch_rate,
            )


def _wheel(case: Case, group: Group) -> WheelOnRail:
    """The case as a wheel on a rail."""
    gauge_height, second, third, cant = case["dimensions"]
    height = dict(case["height"])
    with located(group):
        if gauge_height > 0:
            track = Track(rail=case["rail"], gauge=third, gauge_height=gauge_height, cant=cant)
        else:
            # the rail's origin is given; its top has the height 0 here, and the gauge may be
            # measured anywhere
            track = Track(rail=case["rail"], gauge_height=0.0, cant=cant)
            beside = SIGN[case["side"]] * second - float(track.origin[0])
            track = replace(track, gauge=track.gauge + 2 * beside)
            drop = third - float(track.origin[1])
            if "z" in height:
                height["z"] -= drop
        friction = 0.0
        if case["has_friction"]:
            friction = case["friction"](case["velocity"].speed)
        return WheelOnRail(
            track=track,
            wheelset=case["wheelset"],
            side=case["side"],
            position=case["position"],
            velocity=case["velocity"],
            bodies=case["bodies"],
            friction=friction,
            **case["grid"],
            **height,
        )
