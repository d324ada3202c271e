"""The cases of an input file of CONTACT, module 1: what was read, and what they ask for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import overload

from varcontact.io.contact_words import Group
from varcontact.theories.fastsim_contact import SimplifiedTheory
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

NO_NEAR_MISS = -1.0
"""Value of GAP_MISS for which no place counts as a near miss [mm]."""

BESIDE = (
    "not among the wheels, as it is a step in time, by a force, on springs or by simplified "
    "theory: varcontact wheelrail --table solves it"
)
"""What is said of a case that is not in the sequence."""


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
        """True for steady rolling at given velocities on a rail without springs, by exact
        theory.
        """
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
    def beside(self) -> tuple[WheelCase, ...]:
        """The cases with a wheel that is not in the sequence."""
        return tuple(case for case in self.cases if case.wheel is not None and not case.alone)

    @property
    def left_out(self) -> tuple[WheelCase, ...]:
        """The cases that have no wheel, each with its reason."""
        return tuple(case for case in self.cases if case.reason)

    def __str__(self) -> str:
        """A report: how many cases there are, why some have no wheel, and which are not among the
        wheels.
        """
        lines = [f"{self.path}: {len(self.cases)} cases, {len(self.left_out)} of them left out"]
        lines += [f"case {case.number}: {case.reason}" for case in self.left_out]
        lines += [f"case {case.number}: {BESIDE}" for case in self.beside]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"WheelInput({self.path!r}, {len(self.cases)} cases, {len(self)} wheels)"
