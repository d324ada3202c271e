"""Scenes from the input files of CONTACT, module 3: basic contacts, Hertzian or not.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech CMCC report 20-01, chapters 2 and 4 and
appendix A). Lengths are in mm, forces in N.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io import contact_words as words
from varcontact.reference.hertz import hertz_ellipse
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import ExponentialFalling, Law, LinearFalling, RationalFalling
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Paraboloids, SampledDistance
from varcontact.scene.transient import Transient
from varcontact.scene.units import MM_N

NO_MOTION, SHIFT, TRANSIENT, STEADY = range(4)
LAWS: dict[int, type[Any]] = {2: LinearFalling, 3: RationalFalling, 4: ExponentialFalling}


def read_contact_input(path: str | Path) -> list[Scene]:
    """The cases of an input file of CONTACT, module 3, as scenes on the same elements.

    A sequence of cases that continue each other (P = 0 after a shift or transient rolling) becomes one scene, whose
    motion is a `Transient` with a step for each case. Everything else becomes a scene of its own, in the order of the
    file.

    Parameters
    ----------
    path : str or Path
        A file ``<experiment>.inp``.

    Returns
    -------
    list of Scene
        With explicit grids, in mm and N.

    Raises
    ------
    SceneError
        If the file cannot be read, or asks for what has no counterpart here: with the line, the digit, its value, and
        those that are supported (docs/from_contact.md has all of them).

    Notes
    -----
    Undeformed distances (IBASE) are sampled at the centres of the elements, as CONTACT does. Hertzian contacts
    (IPOTCN < 0) stay Hertzian: `solve` gives them Hertz's pressure, as B = 2 does, unless ``normal`` is another method.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "rolling.inp"
    >>> _ = path.write_text('''
    ...  3  MODULE
    ...   203100     P-B-T-N-F-S
    ...   022020     L-D-C-M-Z-E
    ...  0000541   H-G-I-A-O-W-R
    ...   999   100    30    1   1e-5           MAXGS, MAXIN, MAXNR, MAXOUT, EPS
    ...  82000.     0.000  -0.000625  0.000625  FN, CKSI, CETA, CPHI
    ...  0.300      0.300                       FSTAT, FKIN
    ...  0.000      0.400  30000.               CHI, DQ, VELOC
    ...  0.280      0.280  82000.  82000.       POISS 1,2, GG 1,2
    ...  -3                                     IPOTCN
    ...  44   44    8.000  4.000   1.100        MX, MY, AA, BB, SCALE
    ...  0  MODULE
    ... ''')
    >>> (scene,) = vc.read_contact_input(path)
    >>> scene.motion
    Steady(vx=0.0, vy=-0.000625, spin=0.000625, Fx=None, Fy=None, dq=0.4, spin_offset=0.16666666666666666, \
slip_difference='first-order', speed=None)
    >>> f"Fy = {vc.solve(scene).force[1]:.0f} N"
    'Fy = -15000 N'
    >>> folder.cleanup()
    """
    lines = words.Lines(checks.file_name("path", path))
    wheel = "is a wheel on a rail: vc.wheel_rail.read_contact_input reads it, and `varcontact wheelrail` solves it"
    cases: list[_Case] = []
    before: _Case | None = None
    for _ in words.modules(lines, 3, "basic contact", {1: wheel}):
        before = _case(lines, before)
        if before.digits["R"] == 1:
            cases.append(before)
    if not cases:
        raise SceneError("path", str(path), message=f"{path} holds no case that is to be calculated")
    return [_scene(sequence) for sequence in _sequences(cases)]


@dataclass(frozen=True)
class Friction:
    """A coefficient, or a law that still lacks the rolling velocity."""

    law: int
    values: tuple[float, ...]

    @property
    def static(self) -> float:
        """FSTAT."""
        return self.values[0] if self.law == 0 else self.values[0] + self.values[1]

    def at(self, velocity: float) -> float | Law:
        """As `Scene` takes it."""
        if self.law == 0:
            return self.values[0]
        kinetic, first, half, distance, least = self.values
        memory = {"memory_distance": distance, "memory_velocity": least} if distance > 0 else {}
        return LAWS[self.law](kinetic + first, kinetic, half, velocity, **memory)


@dataclass(frozen=True)
class _Case:
    """One case, and what the next may keep of it."""

    group: words.Group
    digits: dict[str, int] = field(default_factory=dict)
    kinematics: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    friction: Friction | None = None
    rolling: tuple[int, float, float] | None = None
    bodies: Bodies | None = None
    potential: words.Given | None = None
    grid: Grid | None = None
    row: words.Row | None = None
    """Of the one row of a line contact: where it lies along y, and how long it is."""
    distance: words.Given | None = None
    surface: Paraboloids | Ellipse | SampledDistance | None = None

    @property
    def width(self) -> float:
        """By what forces are divided: the length of the one row of a line contact."""
        return self.row[1] if self.row is not None else 1.0

    @property
    def load(self) -> dict[str, Any]:
        if self.digits["N"] == 1:
            return {"normal_force": self.kinematics[0] / self.width}
        return {"approach": self.kinematics[0]}


def _case(lines: words.Lines, before: _Case | None) -> _Case:
    digits, group = lines.digits("PBTNFS", words.WORDS["PBTNFS"], words.SUPPORTED)
    more, material = lines.digits("VLDCMZE", words.WORDS["VLDCMZE"], words.SUPPORTED)
    if material.rest and words.number_of(material.rest[0]) not in (None, 0.0):
        material.refuse("M2 (MATER2)", material.rest[0], "is not supported; supported: 0 (no damping)")
    digits |= more
    digits |= lines.digits("XHGIAOWR", words.WORDS["XHGIAOWR"], words.SUPPORTED)[0]
    case = _Case(group) if before is None else replace(before, group=group)
    case = replace(case, digits=digits)
    words.skip_iterations(lines, digits["G"])
    case = replace(case, kinematics=_kinematics(lines, digits))
    if digits["L"] != 1:
        case = replace(case, friction=read_friction(lines, digits["L"]))
    if digits["C"] == 2:
        if digits["T"] >= TRANSIENT:
            case = replace(case, rolling=_rolling(lines))
        nu1, nu2, G1, G2 = lines.group("POISS 1", "POISS 2", "GG 1", "GG 2").numbers()
        case = replace(case, bodies=Bodies(G=(G1, G2), nu=(nu1, nu2)))
    for letter, kept in (("C", case.bodies), ("L", case.friction)):
        if kept is None:
            group.refuse(letter, digits[letter], "keeps what the case before has, and there is none")
    if digits["T"] >= TRANSIENT and case.rolling is None:
        group.refuse("T (TANG)", digits["T"], "needs CHI, DQ and VELOC, which no case has given yet: use C = 2")
    case = _placed(lines, case, before)
    words.skip_stresses(lines, digits["S"])
    return case


def _kinematics(lines: words.Lines, digits: dict[str, int]) -> tuple[float, float, float, float]:
    names = ("FN" if digits["N"] else "PEN", "FX" if digits["F"] else "CKSI", "FY" if digits["F"] == 2 else "CETA")
    group = lines.group(*names, "CPHI")
    load, first, second, spin = group.numbers()
    if digits["F"] and digits["N"] == 0 and digits["T"] != NO_MOTION:
        why = "with N = 0 is not supported: FX is a part of FSTAT FN, and FN is not known; use N = 1"
        group.refuse("F (FORCE)", digits["F"], why)
    centre = [words.number_of(word) for word in group.rest[:2]]
    if len(centre) == 2 and centre[0] is not None and centre[1] is not None:
        first += 0.0 if digits["F"] else spin * centre[1]
        second -= 0.0 if digits["F"] == 2 else spin * centre[0]
    return load, first, second, spin


def read_friction(lines: words.Lines, law: int) -> Friction:
    """The coefficient or law of the digit L, other than 1."""
    if law == 0:
        group = lines.group("FSTAT", "FKIN")
        static, kinetic = group.numbers()
        if static != kinetic:
            group.refuse("FKIN", kinetic, f"is not FSTAT = {static}; CONTACT supports one coefficient (its guide, 4.2)")
        return Friction(law, (static,))
    kind = {2: "FLIN", 3: "FRAT", 4: "FEXP"}[law]
    group = lines.group("FKIN", f"{kind}1", "SABSH1", f"{kind}2", "SABSH2")
    values = group.numbers()
    if values[3] != 0:
        group.refuse(f"{kind}2", values[3], "is not supported: a law here has one term; supported: 0")
    memory = lines.group("MEMDST", "MEM_S0")
    return Friction(law, (*values[:3], *memory.numbers()))


def _rolling(lines: words.Lines) -> tuple[int, float, float]:
    group = lines.group("CHI", "DQ", "VELOC")
    angle, dq, velocity = group.angle(0), group.number(1), group.number(2)
    for direction in (1, -1):
        if abs(np.cos(angle) - direction) < 1e-8 and dq > 0 and velocity > 0:
            return direction, dq, velocity
    return group.refuse("CHI, DQ, VELOC", (angle, dq, velocity), "must be 0 or 180d, and two positive numbers")


def _placed(lines: words.Lines, case: _Case, before: _Case | None) -> _Case:
    digits, group = case.digits, case.group
    if digits["D"] == 2:
        kind = lines.group("IPOTCN")
        (ipotcn,) = kind.integers()
        if ipotcn not in words.POTENTIAL:
            kind.refuse("IPOTCN", ipotcn, f"is not supported; supported: {', '.join(map(str, words.POTENTIAL))}")
        entries = lines.group(*words.POTENTIAL[ipotcn])
        case = replace(case, potential=(entries, ipotcn, entries.numbers()))
    if case.potential is None:
        group.refuse("D (DISCNS)", digits["D"], "keeps the elements of the case before, and there is none")
    ipotcn = case.potential[1]
    if digits["B"] == 2 and ipotcn > 0:
        group.refuse("B (BOUND)", 2, "needs a Hertzian contact, IPOTCN < 0")
    assert case.bodies is not None
    if digits["B"] == 2 and case.bodies.K != 0:
        group.refuse("B (BOUND)", 2, "with unlike bodies is not supported: here their tractions change the pressure")
    if ipotcn < 0:
        return _hertzian(replace(case, row=None), before)
    grid, row = words.elements(case.potential) if digits["D"] or case.grid is None else (case.grid, case.row)
    if row is not None and digits["N"] == 0:
        group.refuse(
            "N (NORM)", 0, "with one row (MY = 1) is not supported: in plane strain PEN is not defined; use N = 1"
        )
    if digits["Z"] == 2:
        case = replace(case, distance=words.read_distance(lines, grid))
    elif case.distance is None or before is None or before.potential is None or before.potential[1] < 0:
        group.refuse("Z (RZNORM)", digits["Z"], "keeps an undeformed distance, and no case before gives one: use Z = 2")
    elif grid != case.grid and (digits["Z"] == 0 or case.distance[1] == 9):
        group.refuse("Z (RZNORM)", digits["Z"], "keeps the undeformed distance of other elements: use Z = 2")
    assert case.distance is not None
    if grid == case.grid and digits["Z"] == 0:
        return case
    return replace(case, grid=grid, row=row, surface=words.sampled(case.distance, grid, row))


def _hertzian(case: _Case, before: _Case | None) -> _Case:
    assert case.potential is not None
    assert case.bodies is not None
    entries, ipotcn, (mx, my, first, second, scale) = case.potential
    surface: Paraboloids | Ellipse
    if ipotcn == -3:
        surface = Ellipse(a=first, b=second)
    else:
        if ipotcn == -2:
            shape = hertz_ellipse(checks.positive("AOB", second), 1.0, case.bodies, force=1.0)
            second = first * shape.Rx / shape.Ry
        Rx, Ry = (
            1 / (2 * checks.positive(name, each)) for name, each in zip(("A1", "B1"), (first, second), strict=True)
        )
        surface = Paraboloids(Rx=Rx, Ry=Ry)
    if case.digits["D"] == 0 and case.grid is not None:
        same = before is not None and (before.bodies, before.load) == (case.bodies, case.load)
        if ipotcn == -3 and not same:
            why = "keeps the semi-axes for another load or material, which is not clear: use D = 2"
            case.group.refuse("D (DISCNS)", 0, why)
        return replace(case, surface=surface)
    contact = Scene(bodies=case.bodies, surface=surface, **case.load).hertz
    if contact is None or scale <= 0:
        entries.refuse("SCALE", scale, "with this load gives no potential contact")
    nx, ny = words.counts(entries, mx, my)
    a, b = contact.a * scale, contact.b * scale
    return replace(case, surface=surface, grid=Grid(nx=nx, ny=ny, dx=2 * a / nx, dy=2 * b / ny, x0=-a, y0=-b))


def _sequences(cases: Sequence[_Case]) -> list[list[_Case]]:
    """The cases, those together that continue each other."""
    sequences: list[list[_Case]] = []
    for case in cases:
        timed, past = case.digits["T"] in (SHIFT, TRANSIENT), case.digits["P"] == 0
        if not (timed and past):
            sequences.append([case])
            continue
        if not sequences or sequences[-1][-1].digits["T"] not in (SHIFT, TRANSIENT):
            why = "continues a case before, which must be a shift or transient rolling (T = 1 or 2)"
            case.group.refuse("P (PVTIME)", 0, f"{why}; begin with P = 2, or give its solution as Transient(start=)")
        first = sequences[-1][0]
        if (case.grid, case.bodies) != (first.grid, first.bodies):
            case.group.refuse(
                "P (PVTIME)", 0, "continues a case with other elements or material, which is not supported"
            )
        sequences[-1].append(case)
    return sequences


def _scene(sequence: list[_Case]) -> Scene:
    case = sequence[0]
    T = case.digits["T"]
    assert case.bodies is not None
    assert case.surface is not None
    assert case.friction is not None
    parts: dict[str, Any] = {"bodies": case.bodies, "surface": case.surface, "grid": case.grid, "units": MM_N}
    if len(sequence) > 1 or T == TRANSIENT:
        return Scene(**parts, motion=_history(sequence))
    if T == NO_MOTION:
        return Scene(**parts, **case.load)
    friction = case.friction.at(case.rolling[2] if T == STEADY and case.rolling else 1.0)  # a shift lasts a second
    if T == SHIFT:
        return Scene(**parts, **case.load, friction=friction, motion=Shift(**_rigid(case)))
    assert case.rolling is not None
    direction, dq, _ = case.rolling
    if direction == -1:
        why = "with T = 3 is not supported: steady rolling here is towards positive x; mirror the case (x to -x)"
        case.group.refuse("CHI", "180d", why)
    return Scene(**parts, **case.load, friction=friction, motion=Steady(dq=dq, **_rigid(case)))


def _rigid(case: _Case) -> dict[str, Any]:
    """Creepages or shifts by the names of the motion, and FX and FY, which the file has as parts of FSTAT FN."""
    assert case.friction is not None
    _, first, second, spin = case.kinematics
    limit, count = case.friction.static * case.load.get("normal_force", 0.0), case.digits["F"]
    along_x, along_y, about_z = ("vx", "vy", "spin") if case.digits["T"] >= TRANSIENT else ("ux", "uy", "rotation")
    given = {"Fx": limit * first} if count >= 1 else {along_x: first}
    given |= {"Fy": limit * second} if count == 2 else {along_y: second}
    return given | {about_z: spin}


def _history(sequence: list[_Case]) -> Transient:
    steps = [_rigid(case) for case in sequence]
    rolling = [case.rolling if case.digits["T"] == TRANSIENT and case.rolling else (1, 0.0, 1.0) for case in sequence]
    names = ("vx", "vy", "spin", "ux", "uy", "rotation")
    rigid: dict[str, Any] = {name: [step.get(name, 0.0) for step in steps] for name in names}
    surfaces = [case.surface for case in sequence if case.surface is not None]
    return Transient(
        steps=len(sequence),
        dq=[dq for _, dq, _ in rolling],
        direction=[direction for direction, _, _ in rolling],
        **rigid,
        Fx=_some([step.get("Fx") for step in steps]),
        Fy=_some([step.get("Fy") for step in steps]),
        normal_force=_some([case.load.get("normal_force") for case in sequence]),
        approach=_some([case.load.get("approach") for case in sequence]),
        friction=[
            case.friction.at(velocity)
            for case, (_, _, velocity) in zip(sequence, rolling, strict=True)
            if case.friction is not None
        ],
        surface=surfaces if any(each is not surfaces[0] for each in surfaces) else None,
    )


def _some(values: list[float | None]) -> list[float | None] | None:
    """The values, or None where there are none."""
    return None if all(value is None for value in values) else values
