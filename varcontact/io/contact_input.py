"""Scenes from the input files of CONTACT, module 3: basic contacts, Hertzian or not.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech
CMCC report 20-01, chapters 2 and 4 and appendix A). Lengths are in mm, forces
in N.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
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
from varcontact.scene.surfaces import Ellipse, Paraboloids
from varcontact.scene.transient import Transient
from varcontact.scene.units import MM_N

NO_MOTION, SHIFT, TRANSIENT, STEADY = range(4)
CONVEX_GS = 2
"""The control digit G of the one solver of CONTACT that takes any DQ in steady rolling."""
LAWS: dict[int, tuple[str, type[Any]]] = {
    2: ("FLIN", LinearFalling),
    3: ("FRAT", RationalFalling),
    4: ("FEXP", ExponentialFalling),
}

Case = dict[str, Any]
"""What a case has, and the next may keep: "group", "digits", "solver" (G), "kinematics",
"friction", "rolling" (direction, dq and speed), "bodies", "potential" and "distance"
(`words.Given`), "grid", "row" (`words.Row` or None) and "surface"."""


@checks.named_options()
def read_contact_input(path: str | Path) -> list[Scene]:
    """The cases of an input file of CONTACT, module 3, as scenes on the same elements.

    A sequence of cases that continue each other (P = 0 after a shift or
    transient rolling) becomes one scene, whose motion is a `Transient` with a
    step for each case. Everything else becomes a scene of its own, in the order
    of the file.

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
        If the file cannot be read, or asks for what has no counterpart here:
        with the line, the digit, its value, and those that are supported
        (docs/from_contact.md has all of them).

    Notes
    -----
    Undeformed distances (IBASE) are sampled at the centres of the elements, as CONTACT does.
    Hertzian contacts (IPOTCN < 0) stay Hertzian: `solve` gives them Hertz's pressure, as B = 2
    does, unless ``normal`` is another method.

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
    >>> scene.motion  # doctest: +NORMALIZE_WHITESPACE
    Steady(vx=0.0, vy=-0.000625, spin=0.000625, Fx=None, Fy=None, dq=0.4,
    spin_offset=0.16666666666666666, \
slip_difference='first-order', speed=None)
    >>> f"Fy = {vc.solve(scene).force[1]:.0f} N"
    'Fy = -15000 N'
    >>> folder.cleanup()
    """
    lines = words.Lines(checks.file_name("path", path))
    wheel = (
        "is a wheel on a rail: vc.wheel_rail.read_contact_input reads it, "
        "and `varcontact wheelrail` solves it"
    )
    cases: list[Case] = []
    case = Case()
    for _ in words.modules(lines, 3, "basic contact", {1: wheel}):
        case = _case(lines, case)
        if case["digits"]["R"] == 1:
            cases.append(case)
    if not cases:
        raise SceneError(
            "path", str(path), message=f"{path} holds no case that is to be calculated"
        )
    scenes = []
    for sequence in _sequences(cases):
        with words.located(sequence[0]["group"]):
            scenes.append(_scene(sequence))
    return scenes


def _case(lines: words.Lines, before: Case) -> Case:
    group, problem, geometry, solution = words.control_digits(
        lines, "PBTNFS", words.SUPPORTED, words.SUPPORTED
    )
    digits = problem | geometry | solution
    case = {**before, "group": group, "digits": digits, "kinematics": _kinematics(lines, digits)}
    if digits["L"] != 1:
        case["friction"] = read_friction(lines, digits["L"])
    if digits["G"] != 1:
        case["solver"] = digits["G"]
    if digits["T"] < TRANSIENT:  # CONTACT forgets how the case before rolled
        case.pop("rolling", None)
    if digits["C"] == 2:
        if digits["T"] >= TRANSIENT:
            case["rolling"] = _rolling(lines)
        case["bodies"] = read_bodies(lines)
    for letter, kept in (("C", "bodies"), ("L", "friction")):
        if kept not in case:
            group.refuse(
                letter, digits[letter], "keeps what the case before has, and there is none"
            )
    if digits["T"] >= TRANSIENT and "rolling" not in case:
        group.refuse(
            "T (TANG)",
            digits["T"],
            "needs CHI, DQ and VELOC, which the case before does not give: use C = 2",
        )
    _place(lines, case, before)
    if _steps_by_elements(case):
        direction, _, velocity = case["rolling"]
        # kept by the next case
        case["rolling"] = (direction, case["grid"].dx, velocity)
    words.skip_stresses(lines, digits["S"])
    return case


def _steps_by_elements(case: Case) -> bool:
    """True where CONTACT steps by DX, whatever DQ says: in steady rolling, but for one solver."""
    digits = case["digits"]
    return digits["T"] == STEADY and digits["R"] == 1 and case.get("solver") != CONVEX_GS


def _load(case: Case) -> dict[str, Any]:
    """As `Scene` takes it; in a line contact by the length of the one row."""
    load = case["kinematics"][0]
    if case["digits"]["N"] == 0:
        return {"approach": load}
    return {"normal_force": load / (case["row"][1] if case["row"] else 1.0)}


def _kinematics(lines: words.Lines, digits: dict[str, int]) -> tuple[float, float, float, float]:
    names = ["PEN", "CKSI", "CETA", "CPHI"]
    if digits["N"]:
        names[0] = "FN"
    if digits["F"]:
        names[1] = "FX"
    if digits["F"] == 2:
        names[2] = "FY"
    group = lines.group(*names)
    load, first, second, spin = group.numbers()
    if digits["F"] and digits["N"] == 0 and digits["T"] != NO_MOTION:
        why = (
            "with N = 0 is not supported: FX is a part of FSTAT FN, and FN is not known; use N = 1"
        )
        group.refuse("F (FORCE)", digits["F"], why)
    centre = _spin_centre(group)
    if centre is not None:
        x, y = centre
        if digits["F"] == 0:
            first += spin * y
        if digits["F"] != 2:
            second -= spin * x
    return load, first, second, spin


def _spin_centre(group: words.Group) -> list[float] | None:
    """SPINXO and SPINYO behind the kinematics, if these are two numbers."""
    numbers = [words.number_of(word) for word in group.rest[:2]]
    centre = [number for number in numbers if number is not None]
    return centre if len(centre) == 2 else None


def read_friction(lines: words.Lines, law: int) -> Callable[[float], float | Law]:
    """The coefficient or law of the digit L, other than 1, at a rolling velocity."""
    if law == 0:
        group = lines.group("FSTAT", "FKIN")
        static, kinetic = group.numbers()
        if static != kinetic:
            group.refuse(
                "FKIN",
                kinetic,
                f"is not FSTAT = {static}; CONTACT supports one coefficient (its guide, 4.2)",
            )
        return lambda velocity: static
    name, kind = LAWS[law]
    group = lines.group("FKIN", f"{name}1", "SABSH1", f"{name}2", "SABSH2")
    kinetic, first, half, second, _ = group.numbers()
    if second != 0:
        group.refuse(f"{name}2", second, "is not supported: a law here has one term; supported: 0")
    distance, least = lines.group("MEMDST", "MEM_S0").numbers()
    memory = {"memory_distance": distance, "memory_velocity": least} if distance > 0 else {}
    return lambda velocity: kind(kinetic + first, kinetic, half, velocity, **memory)


def read_bodies(lines: words.Lines) -> Bodies:
    """The material of the digit C = 2."""
    group = lines.group("POISS 1", "POISS 2", "GG 1", "GG 2")
    nu1, nu2, G1, G2 = group.numbers()
    with words.located(group):
        return Bodies(G=(G1, G2), nu=(nu1, nu2))


def _rolling(lines: words.Lines) -> tuple[int, float, float]:
    group = lines.group("CHI", "DQ", "VELOC")
    angle = group.angle(0)
    dq = group.number(1)
    velocity = group.number(2)
    for direction in (1, -1):
        if abs(np.cos(angle) - direction) < 1e-8 and dq > 0 and velocity > 0:
            break
    else:
        group.refuse(
            "CHI, DQ, VELOC", (angle, dq, velocity), "must be 0 or 180d, and two positive numbers"
        )
    if group.rest and words.number_of(group.rest[0]) is not None:
        group.refuse(
            "FACPHI", group.rest[0], "is not supported: spin is sampled at x + DQ/6; leave it out"
        )
    return direction, dq, velocity


def _place(lines: words.Lines, case: Case, before: Case) -> None:
    """Put elements and undeformed distance into a case, as they are given or kept."""
    digits = case["digits"]
    group = case["group"]
    if digits["D"] == 2:
        case["potential"] = _read_potential(lines)
    if "potential" not in case:
        group.refuse(
            "D (DISCNS)", digits["D"], "keeps the elements of the case before, and there is none"
        )
    hertzian = case["potential"][1] < 0
    if digits["B"] == 2 and not hertzian:
        group.refuse("B (BOUND)", 2, "needs a Hertzian contact, IPOTCN < 0")
    if digits["B"] == 2 and case["bodies"].K != 0:
        group.refuse(
            "B (BOUND)",
            2,
            "with unlike bodies is not supported: here their tractions change the pressure",
        )
    if hertzian:
        _place_hertzian(case, before)
    else:
        _place_sampled(lines, case)


def _read_potential(lines: words.Lines) -> words.Given:
    """IPOTCN and its entries."""
    kind = lines.group("IPOTCN")
    (ipotcn,) = kind.integers()
    if ipotcn not in words.POTENTIAL:
        supported = ", ".join(map(str, words.POTENTIAL))
        kind.refuse("IPOTCN", ipotcn, f"is not supported; supported: {supported}")
    entries = lines.group(*words.POTENTIAL[ipotcn])
    return entries, ipotcn, entries.numbers()


def _place_sampled(lines: words.Lines, case: Case) -> None:
    """Elements, and the undeformed distance at their centres."""
    digits = case["digits"]
    group = case["group"]
    grid, row = words.elements(case["potential"])
    if row is not None and digits["N"] == 0:
        why = (
            "with one row (MY = 1) is not supported: in plane strain PEN is not defined; use N = 1"
        )
        group.refuse("N (NORM)", 0, why)
    same = grid == case.get("grid")
    if digits["Z"] == 2:
        case["distance"] = words.read_distance(lines, grid)
    elif "distance" not in case:
        group.refuse(
            "Z (RZNORM)",
            digits["Z"],
            "keeps an undeformed distance, and no case before gives one: use Z = 2",
        )
    elif not same and (digits["Z"] == 0 or case["distance"][1] == 9):
        group.refuse(
            "Z (RZNORM)", digits["Z"], "keeps the undeformed distance of other elements: use Z = 2"
        )
    if not same or digits["Z"] != 0:
        with words.located(case["distance"][0]):
            case.update(grid=grid, row=row, surface=words.sampled(case["distance"], grid, row))


def _hertzian_surface(
    ipotcn: int, first: float, second: float, bodies: Bodies
) -> Ellipse | Paraboloids:
    """By semi-axes, by two curvatures, or by one and the ratio of the semi-axes."""
    if ipotcn == -3:
        return Ellipse(a=first, b=second)
    A = checks.positive("A1", first)
    if ipotcn == -2:
        shape = hertz_ellipse(checks.positive("AOB", second), 1.0, bodies, force=1.0)
        second = first * shape.Rx / shape.Ry
    return Paraboloids(Rx=1 / (2 * A), Ry=1 / (2 * checks.positive("B1", second)))


def _place_hertzian(case: Case, before: Case) -> None:
    potential: words.Given = case["potential"]
    entries, ipotcn, (mx, my, first, second, scale) = potential
    bodies = case["bodies"]
    with words.located(entries):
        surface = _hertzian_surface(ipotcn, first, second, bodies)
    case.update(row=None, surface=surface)
    case.pop("distance", None)
    if case["digits"]["D"] == 0:
        if ipotcn == -3 and (before["bodies"], _load(before)) != (bodies, _load(case)):
            why = "keeps the semi-axes for another load or material, which is not clear: use D = 2"
            case["group"].refuse("D (DISCNS)", 0, why)
        return
    with words.located(entries):
        contact = Scene(bodies=bodies, surface=surface, **_load(case)).hertz
    if contact is None or scale <= 0:
        entries.refuse("SCALE", scale, "with this load gives no potential contact")
    nx, ny = words.counts(entries, mx, my)
    a = contact.a * scale
    b = contact.b * scale
    with words.located(entries):
        case["grid"] = Grid(nx=nx, ny=ny, dx=2 * a / nx, dy=2 * b / ny, x0=-a, y0=-b)


def _sequences(cases: Sequence[Case]) -> list[list[Case]]:
    """The cases, those together that continue each other."""
    sequences: list[list[Case]] = []
    for case in cases:
        if case["digits"]["T"] not in (SHIFT, TRANSIENT) or case["digits"]["P"] != 0:
            sequences.append([case])
            continue
        refuse = partial(case["group"].refuse, "P (PVTIME)", 0)
        if not sequences or sequences[-1][-1]["digits"]["T"] not in (SHIFT, TRANSIENT):
            why = "continues a case before, which must be a shift or transient rolling (T = 1 or 2)"
            refuse(f"{why}; begin with P = 2, or give its solution as Transient(start=)")
        first = sequences[-1][0]
        if (case["grid"], case["bodies"]) != (first["grid"], first["bodies"]):
            refuse("continues a case with other elements or material, which is not supported")
        sequences[-1].append(case)
    return sequences


def _surfaces(sequence: list[Case]) -> list[Any] | None:
    """Surfaces of all steps; None where they are one and the same."""
    surfaces = [case["surface"] for case in sequence]
    if all(surface is surfaces[0] for surface in surfaces):
        return None
    return surfaces


def _scene(sequence: list[Case]) -> Scene:
    case = sequence[0]
    T = case["digits"]["T"]
    load = _load(case)
    parts: dict[str, Any] = {name: case[name] for name in ("bodies", "surface", "grid")}
    parts["units"] = MM_N
    if len(sequence) > 1 or T == TRANSIENT:
        return Scene(**parts, motion=_history(sequence))
    if T == NO_MOTION:
        return Scene(**parts, **load)
    if T == SHIFT:
        # a shift lasts a second
        return Scene(**parts, **load, friction=case["friction"](1.0), motion=Shift(**_rigid(case)))
    direction, dq, velocity = case["rolling"]
    if direction == -1:
        why = (
            "with T = 3 is not supported: steady rolling here is towards positive x; "
            "mirror the case (x to -x)"
        )
        case["group"].refuse("CHI", "180d", why)
    return Scene(
        **parts, **load, friction=case["friction"](velocity), motion=Steady(dq=dq, **_rigid(case))
    )


def _rigid(case: Case) -> dict[str, Any]:
    """Creepages or shifts by the names of the motion, and FX and FY, which the file has as parts of
    FSTAT FN.
    """
    _, first, second, spin = case["kinematics"]
    friction = case["friction"](1.0)
    count = case["digits"]["F"]
    static = friction.static if isinstance(friction, Law) else friction
    limit = static * _load(case).get("normal_force", 0.0)
    rolls = case["digits"]["T"] >= TRANSIENT
    along_x, along_y, about_z = ("vx", "vy", "spin") if rolls else ("ux", "uy", "rotation")
    given = {"Fx": limit * first} if count >= 1 else {along_x: first}
    given |= {"Fy": limit * second} if count == 2 else {along_y: second}
    return given | {about_z: spin}


def _rolling_of(case: Case) -> tuple[int, float, float]:
    """Direction, step and velocity; a shift lasts a second."""
    if case["digits"]["T"] != TRANSIENT:
        return 1, 0.0, 1.0
    rolling: tuple[int, float, float] = case["rolling"]
    return rolling


def _history(sequence: list[Case]) -> Transient:
    """Motion of cases that continue each other, a step for each."""
    steps = [_rigid(case) | _load(case) for case in sequence]
    rolling = [_rolling_of(case) for case in sequence]
    friction = [
        case["friction"](velocity) for case, (_, _, velocity) in zip(sequence, rolling, strict=True)
    ]
    rigid: dict[str, Any] = {
        name: [step.get(name, 0.0) for step in steps]
        for name in ("vx", "vy", "spin", "ux", "uy", "rotation")
    }
    for name in ("Fx", "Fy", "normal_force", "approach"):
        values = [step.get(name) for step in steps]
        rigid[name] = None if set(values) == {None} else values
    return Transient(
        steps=len(sequence),
        dq=[dq for _, dq, _ in rolling],
        direction=[direction for direction, _, _ in rolling],
        friction=friction,
        surface=_surfaces(sequence),
        **rigid,
    )
