"""Indices of wear and damage from solved patches: T-gamma, friction power by area, and Archard's depth of wear."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.wheel_rail.result import PatchSolution, WheelRailSolution

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Archard:
    """Archard's law: the volume worn off is ``k N s / H`` for a normal force N over a sliding distance s.

    Parameters
    ----------
    k : float
        Coefficient of wear [-]. It depends on pressure, slip velocity, lubrication and the steels; there is no value
        to assume. Jendel (2002, Wear 253, 215-223) maps it from 1e-4 (mild) to 4e-2 (catastrophic).
    hardness : float
        H of the softer body [N/mm^2].

    Raises
    ------
    SceneError
        If a number is not positive.

    Examples
    --------
    >>> print(Archard(k=3e-4, hardness=3000.0).by_work)
    1e-07
    """

    k: float
    hardness: float

    def __post_init__(self) -> None:
        for name in ("k", "hardness"):
            object.__setattr__(self, name, checks.positive(f"wear.{name}", getattr(self, name)))

    @property
    def by_work(self) -> float:
        """k/H [mm^2/N]."""
        return self.k / self.hardness


@dataclass(frozen=True, eq=False)
class PatchWear:
    """Indices of wear of one patch.

    Parameters
    ----------
    solved : PatchSolution
    archard : Archard, optional
        Needed for depth and volume alone.
    """

    solved: PatchSolution
    archard: Archard | None = None

    @property
    def t_gamma(self) -> float:
        """Energy by distance rolled, ``-(Fx vx + Fs vy + Mz spin)`` [N].

        It is also what friction loses, which `power_by_area` sums up to exactly.
        """
        return self.solved.solution.power

    @property
    def t_gamma_without_spin(self) -> float:
        """``-(Fx vx + Fs vy)`` [N], as vehicle codes have it that know no moment."""
        force, rolled = self.solved.solution.force, self.solved.patch.creepage
        return float(0.0 - force[0] * rolled.vx - force[1] * rolled.vy)

    @property
    def area(self) -> float:
        """Of the contact [mm^2]."""
        solution = self.solved.solution
        return float(np.count_nonzero(solution.pressure > 0) * solution.grid.area)

    @property
    def t_gamma_by_area(self) -> float:
        """T-gamma by area of contact [N/mm^2], by which Lewis and Olofsson (2004, Wear 257) tell regimes of wear."""
        return self.t_gamma / self.area

    @property
    def power(self) -> float:
        """Friction power at the speed of the case [W]."""
        return self.t_gamma * self.solved.patch.creepage.speed / 1e3

    @property
    def power_by_area(self) -> np.ndarray:
        """Friction power by area, shape (ny, nx) [W/mm^2]."""
        return self.solved.solution.power_density * self.solved.patch.creepage.speed / 1e3

    @property
    def sliding(self) -> np.ndarray:
        """Pressure times slip by distance rolled, shape (ny, nx) [N/mm^2]: `power_density` by the coefficient f.

        For constant f its integral is T-gamma / f. Where f is zero, it is that of the slip of the elements.
        """
        solution = self.solved.solution
        f = np.asarray(solution.scene.friction if solution.friction is None else solution.friction, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(f > 0, solution.power_density / f, solution.pressure * np.hypot(*solution.slip))

    @property
    def depth(self) -> np.ndarray:
        """Archard's depth of wear by one passage of the patch, at the rows of its grid, shape (ny,) [mm].

        A particle stays over an element for the time dx/V, and slides ``|s| dx`` meanwhile, see `sliding`. One body
        has all of it: the rail at each passing wheel, or the wheel at each revolution.
        """
        return self._by_work * self.sliding.sum(axis=1) * self.solved.solution.grid.sides[0]

    @property
    def volume(self) -> float:
        """Archard's volume of wear by distance rolled [mm^3/mm]."""
        return float(self._by_work * self.sliding.sum() * self.solved.solution.grid.area)

    @property
    def _by_work(self) -> float:
        if self.archard is None:
            raise SceneError("archard", None, "given for depth and volume: wear(found, Archard(k=..., hardness=...))")
        return self.archard.by_work


@dataclass(frozen=True, eq=False)
class Wear:
    """Indices of wear of all patches of a wheel.

    Attributes
    ----------
    patches : tuple of PatchWear
        From left to right.
    """

    patches: tuple[PatchWear, ...]

    @property
    def t_gamma(self) -> float:
        """Of all patches [N]."""
        return sum(each.t_gamma for each in self.patches)

    @property
    def power(self) -> float:
        """Of all patches [W]."""
        return sum(each.power for each in self.patches)

    @property
    def volume(self) -> float:
        """Of all patches, by distance rolled [mm^3/mm]."""
        return sum(each.volume for each in self.patches)

    def plot(self) -> Figure:
        """Friction power by area of each patch, and the depth of wear across it where there is a law.

        Returns
        -------
        Figure
        """
        from varcontact.wheel_rail.pictures import plot_wear

        return plot_wear(self)


def wear(found: WheelRailSolution, archard: Archard | None = None) -> Wear:
    """Indices of wear of a solved wheel on a rail.

    Parameters
    ----------
    found : WheelRailSolution
    archard : Archard, optional
        For depths and volumes.

    Returns
    -------
    Wear

    Raises
    ------
    SceneError
        If these are something else.

    Examples
    --------
    >>> from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet
    >>> case = WheelOnRail(
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40), wheelset=WheelSet(wheel=Profile.s1002()),
    ...     position=Position(y=3.0, yaw=0.003), vertical_force=80e3, dx=1.0, dy=1.0)
    >>> worn = wear(case.solve(), Archard(k=3e-4, hardness=3000.0))
    >>> print(f"T-gamma = {worn.t_gamma:.1f} N, {1e6 * worn.patches[0].depth.max():.2f} nm by a passage")
    T-gamma = 79.0 N, 5.53 nm by a passage
    """
    if not isinstance(found, WheelRailSolution):
        raise SceneError("found", found, "a WheelRailSolution, from WheelOnRail.solve")
    if archard is not None and not isinstance(archard, Archard):
        raise SceneError("archard", archard, "an Archard(k=..., hardness=...)")
    return Wear(tuple(PatchWear(each, archard) for each in found.patches))
