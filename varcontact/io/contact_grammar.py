"""The grammar of CONTACT's input files, modules 1 and 3: control digits, and the parameter lines
that they bring.

Source: Vollebregt, User guide for CONTACT, Vtech CMCC report 20-01, chapters 2
to 4, whose sections are given as of 2025 (``doc/user-guide.tex`` of the
open-source release), and that release.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn

from varcontact.io.contact_words import Group, Lines

Known = Mapping[str, Any]
"""Entries of a case by key: a `Group`, or several."""


@dataclass(frozen=True)
class Digit:
    """Control digit: the meaning of each value here, or the reason why it is refused."""

    letter: str
    name: str
    section: str  # section of the user guide
    read: dict[int, str]
    refused: dict[int, str] = field(default_factory=dict)

    @property
    def supported(self) -> str:
        """Supported values, in words."""
        return ", ".join(f"{value} ({meaning})" for value, meaning in self.read.items())


def _passed_over(letter: str, name: str, section: str, most: int) -> Digit:
    """Digit that concerns only output, solvers or debugging, and is ignored."""
    return Digit(letter, name, section, dict.fromkeys(range(most + 1), "passed over"))


AS_BEFORE = "as before"
FINITE_ELEMENTS = "influence numbers of a file are for module 3"
RESERVED = "it is reserved in CONTACT"
BILINEAR = "tractions are constant on elements here"

PVTIME = Digit("P", "PVTIME", "2.3", {
    0: "continues the case before", 1: "keeps its pressures alone", 2: "begins anew",
    3: "as the case before, once more",
})  # fmt: skip
STRESS = Digit("S", "STRESS", "2.3", {
    0: "no stresses", 1: "stresses at the points before", 2: "their output anew", 3: "points anew",
})  # fmt: skip
FRCLAW = Digit("L", "FRCLAW", "2.3", {
    0: "Coulomb", 1: AS_BEFORE, 2: "linear", 3: "rational", 4: "exponential", 6: "by temperature",
}, {5: "Polach's parameters are not in the release of CONTACT; use L = 4"})  # fmt: skip
HEAT = Digit("H", "HEAT", "2.3", {0: "no temperatures", 1: "thermal data as before", 3: "anew"})
SOLUTION = (
    Digit("X", "XFLOW", "2.3", {0: "no debug output", 1: "debug output, passed over"}),
    HEAT,
    _passed_over("G", "GAUSEI", "2.3", 5),
    _passed_over("I", "IESTIM", "2.3", 3),
    _passed_over("A", "MATFIL", "2.3", 2),
    _passed_over("O", "OUTPUT", "2.3", 6),
    _passed_over("W", "FLOW", "2.3", 9),
    Digit("R", "RETURN", "2.3", {
        0: "calculate", 1: "calculate", 2: "check the input alone", 3: "skip",
    }),
)  # fmt: skip
"""Digits of the third control word, in both modules."""

BASIC = (
    (
        PVTIME,
        Digit("B", "BOUND", "2.3", {
            0: "half-space", 1: "a thin sheet that gives way", 2: "elliptic pressure",
            3: "parabolic pressure", 4: "SDEC's pressure",
        }, {
            5: "KPEC is a fast theory of CONTACT's own; solve with B = 0",
            6: "ANALYN is a fast theory of CONTACT's own; solve with B = 0",
        }),
        Digit("T", "TANG", "2.3", {
            0: "no tangential problem", 1: "shift", 2: "transient rolling", 3: "steady rolling",
        }),
        Digit("N", "NORM", "2.3", {0: "approach given", 1: "normal force given"}),
        Digit("F", "FORCE", "2.3", {0: "creepages given", 1: "FX given", 2: "FX and FY given"}),
        STRESS,
    ),
    (
        Digit("V", "VARFRC", "2.3", {0: "one friction law", 3: "a law for each row"}, {
            1: "by inclination, friction varies on rails (module 1) alone",
            2: "along the track, friction varies on rails (module 1) alone",
        }),
        FRCLAW,
        Digit("D", "DISCNS", "2.3", {0: AS_BEFORE, 1: "elements anew", 2: "elements read"}),
        Digit("C", "INFLCF", "2.3", {
            0: "material as before", 1: "material as before", 2: "half-space",
            4: "conformal, by inclinations", 9: "influence numbers of a file",
        }, {3: BILINEAR, 5: RESERVED}),
        Digit("M", "MATER", "2.3", {
            0: "elastic", 1: "viscoelastic", 2: "FASTSIM, one flexibility",
            3: "FASTSIM, three flexibilities", 4: "third body", 5: "FaStrip",
        }, {6: RESERVED, 7: RESERVED}),
        Digit("Z", "RZNORM", "2.3", {0: AS_BEFORE, 1: "distance anew", 2: "distance read"}),
        Digit("E", "EXRHS", "2.3", {
            0: "no extra rigid slip", 1: "extra rigid slip as before", 9: "extra rigid slip read",
        }, dict.fromkeys((2, 3), "a term of CONTACT's developers; use E = 9")),
    ),
    SOLUTION,
)  # fmt: skip
"""The control words of module 3."""

WHEEL = (
    (
        Digit("C", "CONFIG", "2.3", {
            0: "left wheel on a track", 1: "right wheel on a track",
            4: "left wheel on a roller", 5: "right wheel on a roller",
        }),
        PVTIME,
        Digit("B", "BOUND", "2.3", {0: "half-space"}, {
            1: "a thin sheet that gives way is not modelled",
            5: "KPEC is a fast theory of CONTACT's own; see WheelOnRail.estimate",
            6: "ANALYN is a fast theory of CONTACT's own; see WheelOnRail.estimate",
        }),
        Digit("T", "TANG", "2.3", {
            0: "no tangential problem", 1: "shift", 2: "transient rolling", 3: "steady rolling",
        }),
        Digit("N", "NORM", "2.3", {
            0: "height of the wheel set given", 1: "vertical force given",
        }),
        Digit("F", "FORCE", "2.3", {
            0: "pitch rate given", 1: "longitudinal force given", 2: "moment about the axle given",
            3: "rail on springs",
        }),
        STRESS,
    ),
    (
        Digit("V", "VARFRC", "2.3", {
            0: "one friction law", 1: "a law by inclination", 2: "a law along the track",
        }, {3: "rows of elements are not known before wheels on rails are placed"}),
        FRCLAW,
        Digit("D", "DISCNS", "2.3", {
            0: AS_BEFORE, 1: AS_BEFORE, 2: "planar contact", 3: "planar, slip by element",
            4: "conformal contact", 5: "planar contact, another search",
            6: "planar, slip by element, another search",
        }, dict.fromkeys((7, 8, 9), "a search of CONTACT's developers")),
        Digit("C", "INFLCF", "2.3", {
            0: "material as before", 1: "material as before", 2: "half-space", 4: "conformal",
        }, {3: BILINEAR, 5: RESERVED, 9: FINITE_ELEMENTS}),
        Digit("M", "MATER", "2.3", {
            0: "elastic", 1: "viscoelastic", 2: "FASTSIM, one flexibility",
            3: "FASTSIM, three flexibilities", 4: "third body", 5: "FaStrip",
        }, {6: RESERVED, 7: RESERVED}),
        Digit("Z", "ZTRACK", "2.3", {
            0: AS_BEFORE, 1: "new dimensions", 2: "new deviations", 3: "all new",
        }),
        Digit("E", "EWHEEL", "2.3", {
            0: AS_BEFORE, 1: "new position", 2: "new position and velocity", 3: "all new",
            4: "as 2, with deviations of the wheel", 5: "all new, with deviations of the wheel",
        }),
    ),
    SOLUTION,
)  # fmt: skip
"""The control words of module 1."""


class Controls:
    """The control digits of a case, by name, each with the line on which it stands."""

    def __init__(self, words: tuple[tuple[Digit, ...], ...], lines: Lines) -> None:
        self.group: Group | None = None
        self.damping = 0
        self._digits: dict[str, tuple[Digit, int, Group]] = {}
        for k, digits in enumerate(words):
            word = "".join(each.letter for each in digits)
            group = lines.read(f"{word}:w, [MATER2:i]")
            self.group = self.group or group
            if k == 1:
                self.damping = _damping(group)
            values = _values(word, group)
            for digit, value in zip(digits, values, strict=True):
                self._digits[digit.name] = (digit, value, group)
                if value not in digit.read and value not in digit.refused:
                    self.refuse(digit.name, "is not supported")

    def __getitem__(self, name: str) -> int:
        """The value of a digit."""
        return self._digits[name][1]

    @property
    def rolls(self) -> bool:
        """True for transient and steady rolling."""
        return self["TANG"] in (2, 3)

    def refuse(self, name: str, why: str) -> NoReturn:
        """Raise the error for an unsupported value of a digit, with the supported ones."""
        digit, value, group = self._digits[name]
        group.refuse(f"{digit.letter} ({name})", value, f"{why}; supported: {digit.supported}")

    def complain(self, name: str, why: str) -> NoReturn:
        """Raise the error for a value of a digit that is supported elsewhere, but not in this
        case.
        """
        digit, value, group = self._digits[name]
        group.refuse(f"{digit.letter} ({name})", value, why)

    def check_supported(self) -> None:
        """Refuse the first digit that has no counterpart here."""
        for name, (digit, value, _) in self._digits.items():
            if value in digit.refused:
                self.refuse(name, f"is not supported: {digit.refused[value]}")

    def refuse_damping(self) -> NoReturn:
        """Refuse M2 = 1 or 2, which stands behind the second control word."""
        _, _, group = self._digits["MATER"]
        group.refuse("M2 (MATER2)", self.damping, "is not supported: damping of the bodies")


def _values(word: str, group: Group) -> list[int]:
    """Digits of a control word; leading zeros may be missing or in excess."""
    digits = group.values[0].lstrip("0").zfill(len(word))
    if not group.values[0].isdecimal() or len(digits) > len(word):
        why = f"is not a control word of at most {len(word)} digits"
        group.refuse(word, repr(group.values[0]), why)
    return [int(digit) for digit in digits]


def _damping(group: Group) -> int:
    """MATER2 behind the second control word; 0 where it is left out."""
    damping = int(group.option(0, 0.0))
    if damping not in (0, 1, 2):
        group.refuse("M2 (MATER2)", damping, "is not 0, 1 or 2")
    return damping


@dataclass(frozen=True)
class ParameterLine:
    """Entries that a case has on lines of their own where `given`; see `Lines.read` for their
    names.
    """

    key: str
    section: str
    entries: str | Callable[[Controls], str]
    given: Callable[[Controls], bool] = lambda c: True

    def read(self, lines: Lines, controls: Controls, known: Known) -> Group:
        """The entries from the next lines."""
        entries = self.entries
        if not isinstance(entries, str):
            entries = entries(controls)
        return lines.read(entries)


@dataclass(frozen=True)
class Block:
    """Entries of which some give the number of others: groups, read by a function."""

    key: str
    section: str
    entries: Callable[[Lines, Controls, Known], tuple[Group, ...]]
    given: Callable[[Controls], bool]

    def read(self, lines: Lines, controls: Controls, known: Known) -> tuple[Group, ...]:
        """The groups from the next lines."""
        return self.entries(lines, controls, known)


def _new_material(c: Controls) -> bool:
    return c["INFLCF"] >= 2


def _kinematics(c: Controls) -> str:
    load = ("PEN", "FN")[c["NORM"]]
    rigid = ("CKSI, CETA", "FX, CETA", "FX, FY")[c["FORCE"]]
    return f"{load}, {rigid}, CPHI, [SPINXO, SPINYO]"


LAW_ENTRIES = {
    0: "FSTAT, FKIN",
    2: "FKIN, FLIN1, SABSH1, FLIN2, SABSH2",
    3: "FKIN, FRAT1, SABSH1, FRAT2, SABSH2",
    4: "FKIN, FEXP1, SABSH1, FEXP2, SABSH2",
    6: "FREF, TREF, DFHEAT, DTHEAT",
}
"""Entries of a friction law by the digit L."""


def _friction(lines: Lines, c: Controls, known: Known) -> tuple[Group, ...]:
    """The law, or those of all points of a variation; the friction memory last."""
    varies = c["VARFRC"]
    if c["FRCLAW"] not in LAW_ENTRIES:
        c.check_supported()
    count = 1
    if varies in (1, 2):
        (count,) = lines.read("NVF:i").integers()
    elif varies == 3:
        _check_elements(c, known)
        count = known["elements"][1].count(1)
    place = {1: "ALPHA:a, ", 2: "SVF, "}.get(varies, "")
    lines.check_left("NVF", count)
    groups = [lines.read(place + LAW_ENTRIES[c["FRCLAW"]]) for _ in range(count)]
    if c["FRCLAW"] != 0:
        groups.append(lines.read("MEMDST, MEM_S0"))
    return tuple(groups)


def _conformal(lines: Lines, c: Controls, known: Known) -> tuple[Group, ...]:
    """The correction of influence numbers, and inclinations (y, angle) of the surface."""
    head = lines.read("IF_METH:i, VARIANT:i, NN:i")
    return head, lines.array("SURFACE INCLINATION", 2 * head.count(2), "a")


POTENTIAL = {
    -1: "MX:i, MY:i, A1, B1, SCALE",
    -2: "MX:i, MY:i, A1, AOB, SCALE",
    -3: "MX:i, MY:i, AA, BB, SCALE",
    -4: "MX:i, MY:i, A1, BB, SCALE",
    -5: "MX:i, MY:i, AA, BB, SCALE",
    -6: "MX:i, MY:i, AA, BNEG, BPOS, SCALE",
    1: "MX:i, MY:i, XL, YL, DX, DY",
    2: "MX:i, MY:i, XL, YL, XH, YH",
    3: "MX:i, MY:i, XC1, YC1, DX, DY",
    4: "MX:i, MY:i, XC1, YC1, XCM, YCM",
}
"""Entries of the potential contact by IPOTCN."""


def _elements(lines: Lines, c: Controls, known: Known) -> tuple[Group, ...]:
    kind = lines.read("IPOTCN:i")
    kind.check_value(0, POTENTIAL)
    entries = lines.read(POTENTIAL[kind.integers()[0]])
    entries.count(0)
    entries.count(1)
    return kind, entries


DISTANCES = {
    1: "quadratic",
    2: "circular along x, points along y",
    3: "quadratic, less two sines",
    9: "by element",
}
PLANFORMS = {
    1: "unrestricted",
    2: "an ellipse",
    3: "two rectangles",
    4: "patches that feel each other in part",
}
PLANFORM_SIZES = {2: 6, 3: 8}
"""Number of values that describe an ellipse, and two rectangles."""


def _distance(lines: Lines, c: Controls, known: Known) -> tuple[Group, ...]:
    """IBASE and IPLAN, the distance, and the planform."""
    kind = lines.read("IBASE:i, IPLAN:i")
    kind.check_value(0, DISTANCES)
    kind.check_value(1, PLANFORMS)
    ibase, iplan = kind.integers()
    groups = [kind]
    if ibase == 1:
        groups.append(lines.array("B", 6))
    elif ibase == 2:
        head = lines.read("NN:i, XM, RM, Y1, DY1")
        groups += [head, lines.array("B", head.count(0, least=2))]
    elif ibase == 3:
        groups.append(lines.array("B", 8))
    else:
        groups.append(lines.array("H", _number_of_elements(c, known)))
    if iplan in PLANFORM_SIZES:
        groups.append(lines.array("P", PLANFORM_SIZES[iplan]))
    if iplan == 4:
        patches = lines.read("NPATCH:i")
        count = patches.count(0)
        groups += [patches, lines.array("YSEP", count - 1)]
        groups.append(lines.array("FAC", count * (count - 1) // 2))
    return tuple(groups)


def _number_of_elements(c: Controls, known: Known) -> int:
    _check_elements(c, known)
    entries = known["elements"][1]
    return int(entries.count(0) * entries.count(1))


def _check_elements(c: Controls, known: Known) -> None:
    """Refuse values by element before any case gave elements."""
    if "elements" not in known:
        c.complain("DISCNS", "keeps the elements of the case before, and there is none: use D = 2")


def _extra_slip(lines: Lines, c: Controls, known: Known) -> tuple[Group, ...]:
    return (lines.array("EXRHS", 2 * _number_of_elements(c, known)),)


def _stresses(lines: Lines, c: Controls, known: Known) -> tuple[Group, ...]:
    """Output, and blocks of points of stresses below the surface."""
    groups = [lines.read("MATFIL:i, OUTPUT:i")]
    while c["STRESS"] == 3:
        kind = lines.read("ISUBS:i")
        kind.check_value(0, (0, 1, 2, 3, 5, 6, 7, 9))
        (isubs,) = kind.integers()
        if isubs == 0:
            break
        groups.append(kind)
        groups += _horizontal(lines, isubs)
        groups += _vertical(lines, isubs)
    if c["STRESS"] == 2:
        groups += known.get("stresses", ())[1:]
    return tuple(groups)


def _horizontal(lines: Lines, isubs: int) -> list[Group]:
    """Columns and rows of one block of points, or x, y and z."""
    if isubs in (2, 6):
        return [lines.read("IXL:i, IXINC:i, IXH:i"), lines.read("IYL:i, IYINC:i, IYH:i")]
    if isubs in (3, 7):
        head = lines.read("NX:i, NY:i")
        return [lines.array(name, head.count(k)) for k, name in enumerate(("IX", "IY"))]
    if isubs == 9:
        head = lines.read("NX:i, NY:i, NZ:i")
        return [lines.array(name, head.count(k)) for k, name in enumerate("XYZ")]
    return []


def _vertical(lines: Lines, isubs: int) -> list[Group]:
    """Depths of one block of points."""
    if isubs in (1, 2, 3):
        return [lines.read("NZ:i, ZL, DZ")]
    if isubs in (5, 6, 7):
        return [lines.array("Z", lines.read("NZ:i").count(0))]
    return []


SOLVERS = (
    ParameterLine("debug", "2.3", "PSFLCIN:i, [X_READLN:i]", lambda c: c["XFLOW"] == 1),
    ParameterLine(
        "iterations",
        "4.6",
        "MAXGS:i, MAXIN:i, MAXNR:i, MAXOUT:i, EPS",
        lambda c: c["GAUSEI"] != 1,
    ),
    ParameterLine(
        "relaxation",
        "4.6",
        "OMEGAH, OMEGAS, INISLP:i, OMGSLP",
        lambda c: c["GAUSEI"] in (2, 3),
    ),
    ParameterLine("initial slip", "4.6", "INISLP:i, OMGSLP", lambda c: c["GAUSEI"] == 4),
    ParameterLine(
        "gdsteady",
        "4.6",
        "FDECAY, BETATH, KDOWFB:i, D_IFC, D_LIN, D_CNS, D_SLP, POW_S",
        lambda c: c["GAUSEI"] == 5,
    ),
)
"""Lines of debugging and solvers."""

MATERIAL = (
    ParameterLine("material", "4.1", "POISS 1, POISS 2, GG 1, GG 2", _new_material),
    ParameterLine("sheet", "4.1", "FLX_Z", lambda c: _new_material(c) and c["BOUND"] == 1),
    ParameterLine(
        "viscoelastic",
        "4.1",
        "FG 1, FG 2, TC 1, TC 2",
        lambda c: _new_material(c) and c["MATER"] == 1,
    ),
    ParameterLine(
        "flexibility",
        "4.1",
        "FLX, K0_MF, ALFAMF, BETAMF",
        lambda c: _new_material(c) and c["MATER"] == 2,
    ),
    ParameterLine(
        "slope",
        "4.1",
        "K0_MF, ALFAMF, BETAMF",
        lambda c: _new_material(c) and c["MATER"] in (3, 5),
    ),
    ParameterLine(
        "layer",
        "4.1",
        "GG3, LAYTHK, TAU_C0, K_TAU",
        lambda c: _new_material(c) and c["MATER"] == 4,
    ),
    ParameterLine("damping", "4.1", "CDAMPN, CDAMPT, DFNMAX, DFTMAX", lambda c: c.damping == 2),
    ParameterLine("heat 1", "4.1", "BKTEMP1, HEATCP1, LAMBDA1, DENS1", lambda c: c["HEAT"] == 3),
    ParameterLine("heat 2", "4.1", "BKTEMP2, HEATCP2, LAMBDA2, DENS2", lambda c: c["HEAT"] == 3),
    ParameterLine("plastic work", "4.1", "BETAPL", lambda c: c["HEAT"] == 3 and c["MATER"] == 4),
)
"""Lines of the material and its temperature."""

STRESSES = Block("stresses", "4.9", _stresses, lambda c: c["STRESS"] >= 2)

BASIC_LINES = (
    *SOLVERS,
    ParameterLine("kinematics", "4.5", _kinematics),
    Block("friction", "4.2", _friction, lambda c: c["FRCLAW"] != 1 and c["VARFRC"] != 3),
    ParameterLine(
        "rolling", "4.5", "CHI:a, DQ, VELOC, [FACPHI]", lambda c: _new_material(c) and c.rolls
    ),
    Block("conformal", "4.1", _conformal, lambda c: c["INFLCF"] == 4),
    ParameterLine("influence", "4.1", "CFNAME:s", lambda c: c["INFLCF"] == 9),
    *MATERIAL,
    Block("elements", "4.3", _elements, lambda c: c["DISCNS"] == 2),
    Block("distance", "4.4", _distance, lambda c: c["RZNORM"] == 2),
    Block("friction", "4.2", _friction, lambda c: c["FRCLAW"] != 1 and c["VARFRC"] == 3),
    Block("extra slip", "4.5", _extra_slip, lambda c: c["EXRHS"] == 9),
    STRESSES,
)
"""Parameter lines of module 3, in their order."""


def _profile(lines: Lines, c: Controls, known: Known) -> tuple[Group, ...]:
    """A profile's file, and how it is smoothed."""
    file = lines.read("FNAME:s, MIRRORY:i, SCALE, SMOOTH, [MIRRORZ:i, PRFOPT:i]")
    groups = [file]
    option = int(file.option(1, 0.0))
    if option >= 1:
        groups.append(lines.read("ISMOOTH:i, ZIGTHRS:a, KINKHIGH:a, KINKLOW:a, KINKWID"))
    if option >= 2:
        groups.append(lines.read("ERRHND:i, MAXOMIT"))
    return tuple(groups)


def _track(c: Controls) -> str:
    rail = "GAUGHT, GAUGSQ or RAILY0, GAUGWD or RAILZ0"
    if c["CONFIG"] <= 1:
        return f"{rail}, CANT:a, [CURV]"
    return f"{rail}, NOMRAD"


def _position(c: Controls) -> str:
    height = ("Z", "FZ")[c["NORM"]]
    if c["CONFIG"] <= 1:
        return f"S, Y, {height}, ROLL:a, YAW:a, PITCH:a"
    return f"X, Y, {height}, ROLL:a, YAW:a, PITCH:a"


def _velocity(c: Controls) -> str:
    last = {1: "FX", 2: "MY"}.get(c["FORCE"], "VPITCH:a")
    if c["CONFIG"] <= 1:
        return f"VS, VY, VZ, VROLL:a, VYAW:a, {last}"
    return f"VPITCH_ROL:a, VY, VZ, VROLL:a, VYAW:a, {last}"


def _new_wheel(c: Controls) -> bool:
    return c["EWHEEL"] in (3, 5)


WHEEL_LINES = (
    *SOLVERS,
    Block("friction", "4.2", _friction, lambda c: c["FRCLAW"] != 1),
    ParameterLine("conformal", "4.1", "IF_METH:i, VARIANT:i", lambda c: c["INFLCF"] == 4),
    *MATERIAL,
    ParameterLine(
        "grid",
        "3.6",
        "DX, DS, DQREL, A_SEP:a, D_SEP, D_COMB, [D_TURN, GAP_MISS]",
        lambda c: c["DISCNS"] >= 2,
    ),
    ParameterLine("track", "3.3", _track, lambda c: c["ZTRACK"] in (1, 3)),
    Block("rail", "3.2", _profile, lambda c: c["ZTRACK"] == 3),
    ParameterLine(
        "deviations", "3.3", "DY, DZ, ROLL:a, VY, VZ, VROLL:a", lambda c: c["ZTRACK"] >= 2
    ),
    ParameterLine(
        "springs",
        "3.3",
        "KYRAIL, FYRAIL, KZRAIL, FZRAIL, [DYSTEP0]",
        lambda c: c["ZTRACK"] >= 2 and c["FORCE"] == 3,
    ),
    ParameterLine("wheel set", "3.4", "FBDIST, FBPOS, NOMRAD, [YTAPE]", _new_wheel),
    Block("wheel", "3.2", _profile, _new_wheel),
    ParameterLine("position", "3.4", _position, lambda c: c["EWHEEL"] >= 1),
    ParameterLine("velocity", "3.4", _velocity, lambda c: c["EWHEEL"] >= 2),
    ParameterLine(
        "wheel place",
        "3.4",
        "DXWHL, DYWHL, DZWHL, DROLLW:a, DYAWW:a, DPITCHW:a",
        lambda c: c["EWHEEL"] >= 4,
    ),
    ParameterLine(
        "wheel rates",
        "3.4",
        "VXWHL, VYWHL, VZWHL, VROLLW:a, VYAWW:a, VPITCHW:a",
        lambda c: c["EWHEEL"] >= 4,
    ),
    STRESSES,
)
"""Parameter lines of module 1, in their order."""
