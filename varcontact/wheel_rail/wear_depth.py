"""Wear of the contacts of a wheel on a rail: T-gamma, friction power and Archard's depth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.errors import SceneError
from varcontact.io.labelled import Labelled
from varcontact.plasticity.limits import shakedown
from varcontact.plasticity.shakedown_result import Shakedown
from varcontact.results.quantities_of_interest import units
from varcontact.system.process import lazy_property
from varcontact.wheel_rail.patch_solution import PatchSolution
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class PatchWear:
    """Indices of wear of one patch.

    Attributes
    ----------
    solved : PatchSolution
    archard : Archard, ArchardMap or None
        Needed for depth and volume alone.
    t_gamma : float
        Energy per distance rolled, ``-(Fx vx + Fs vy + Mz spin)`` [N]. It is
        also what friction dissipates, the sum of `power_by_area`.
    t_gamma_without_spin : float
        ``-(Fx vx + Fs vy)`` [N], as in vehicle codes that know no moment.
    area : float
        Contact area [mm^2].
    t_gamma_by_area : float
        T-gamma per area of contact [N/mm^2]; Lewis and Olofsson (2004, Wear 257)
        classify regimes of wear by it.
    power : float
        Friction power at the speed of the case [W].
    power_by_area : ndarray, shape (ny, nx)
        Friction power per area [W/mm^2].
    sliding : ndarray, shape (ny, nx)
        Pressure times slip per distance rolled [N/mm^2]: `power_density` by the
        coefficient f. For constant f its integral is T-gamma / f. Where f is
        zero, it is that of the slip of the elements.
    yield_in_shear : float or None
        Needed for the shakedown limit alone [N/mm^2].
    """

    solved: PatchSolution
    archard: Archard | ArchardMap | None
    t_gamma: float
    t_gamma_without_spin: float
    area: float
    t_gamma_by_area: float
    power: float
    power_by_area: np.ndarray
    sliding: np.ndarray
    yield_in_shear: float | None = None

    @lazy_property
    def shakedown(self) -> Shakedown | None:
        """Shakedown limit of the rail by closed forms; None without a yield stress."""
        if self.yield_in_shear is None:
            return None
        return shakedown(self.solved, self.yield_in_shear, "rail", gap=None)

    @property
    def depth(self) -> np.ndarray:
        """Archard's depth of wear by one passage of the patch, at the rows of its grid, shape (ny,)
        [mm].

        A particle stays over an element for the time dx/V, and slides ``|s| dx`` meanwhile, see
        `sliding`. One body has all of it: the rail at each passing wheel, or the wheel at each
        revolution.
        """
        return (self._by_work * self.sliding).sum(axis=1) * self.solved.solution.grid.sides[0]

    @property
    def volume(self) -> float:
        """Archard's volume of wear per distance rolled [mm^3/mm]."""
        return float((self._by_work * self.sliding).sum() * self.solved.solution.grid.area)

    @property
    def t_gamma_error(self) -> float:
        """Estimated error of T-gamma, and so of the friction work, from those of the forces [N];
        NaN without them.
        """
        rolled = self.solved.patch.creepage
        error = self.solved.error
        estimate = self.solved.solution.error_estimate
        if estimate is None:
            return np.nan
        turned = estimate.errors.get("Mz", 0.0) * units(self.solved.solution).get("Mz", 0.0)
        return float(
            abs(rolled.vx) * error[0] + abs(rolled.vy) * error[1] + abs(rolled.spin) * turned
        )

    @property
    def _by_work(self) -> float | np.ndarray:
        if self.archard is None:
            raise SceneError(
                "archard",
                None,
                "given for depth and volume: wear(found, Archard(k=..., hardness=...))",
            )
        if isinstance(self.archard, Archard):
            return self.archard.by_work
        slip_velocity = np.hypot(*self.solved.solution.slip) * self.solved.patch.creepage.speed
        return (
            self.archard.coefficient(self.solved.solution.pressure, slip_velocity)
            / self.archard.hardness
        )


@dataclass(frozen=True, eq=False)
class Wear(Labelled):
    """Indices of wear of all patches of a wheel.

    Attributes
    ----------
    patches : tuple of PatchWear
        From left to right.
    """

    patches: tuple[PatchWear, ...]

    @property
    def t_gamma(self) -> float:
        """T-gamma of all patches [N]."""
        return sum(each.t_gamma for each in self.patches)

    @property
    def power(self) -> float:
        """Friction power of all patches [W]."""
        return sum(each.power for each in self.patches)

    @property
    def volume(self) -> float:
        """Volume of wear of all patches, divided by the distance rolled [mm^3/mm]."""
        return sum(each.volume for each in self.patches)

    def to_xarray(self) -> xr.Dataset:
        """Indices over the patches, power and depth over their rows of elements, with units."""
        from varcontact.wheel_rail.datasets import wear_dataset

        return wear_dataset(self)

    def plot(self) -> Figure:
        """Friction power per area of each patch, and the depth of wear across it where there is a
        law.
        """
        from varcontact.wheel_rail.plots import plot_wear

        return plot_wear(self)
