"""Laws of wear and fatigue: Archard's with a coefficient or a map, and functions of T-gamma.

The numbers of the map and the functions are from secondary sources: those that
reviews quote of the papers named. They were not compared with the papers
themselves; each takes other numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError

Pieces = Sequence[tuple[float, float, float]]
BRITISH_RAIL = ((0.0, 0.25, 0.0), (100.0, 0.0, 25.0), (200.0, 1.19, -154.0))
"""Pieces (T-gamma [N] from which it holds, slope, constant) of British Rail's function: worn area
per distance, times the diameter [mm^2/km mm]."""
SHEFFIELD = ((0.0, 5.3, 0.0), (10.4, 0.0, 55.0), (77.2, 61.9, 55.0 - 61.9 * 77.2))
"""Pieces (T-gamma per area [N/mm^2] from which it holds, slope, constant) of Sheffield's function:
worn mass per distance and area [ug/(m mm^2)]."""
WHOLE_LIFE = (0.0, 15.0, 65.0, 175.0), (0.0, 0.0, 10.0, 0.0)
"""T-gamma [N], and the damage by fatigue of one passage [1e-6] at these, linear in between."""


@dataclass(frozen=True)
class Archard(checks.Checked, path="wear", k=checks.positive, hardness=checks.positive):
    """Archard's law: the volume worn off is ``k N s / H`` for a normal force N
    over a sliding distance s.

    Parameters
    ----------
    k : float
        Coefficient of wear [-]. It depends on pressure, slip velocity,
        lubrication and the steels; there is no value to assume. Jendel
        (2002, Wear 253, 215-223) maps it from 1e-4 (mild) to 4e-2
        (catastrophic).
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

    @property
    def by_work(self) -> float:
        """k/H [mm^2/N]."""
        return self.k / self.hardness


@dataclass(frozen=True)
class ArchardMap(
    checks.Checked,
    path="wear",
    **dict.fromkeys(("hardness", "k_seizure", "seizure"), checks.positive),
):
    """Archard's law with a coefficient by pressure and slip velocity, as mapped by tests at KTH.

    Without arguments it has the middle of the ranges of T. Jendel, Wear 253
    (2002) 215-223, for dry contact, as reviews quote them: wide ones, and
    coefficients of lubricated or wet contact are far smaller.

    Parameters
    ----------
    hardness : float
        H of the softer body [N/mm^2].
    velocities : sequence of float
        Slip velocities at which the coefficient changes [mm/s], ascending.
    k : sequence of float
        Coefficients between these, one more than them [-].
    k_seizure : float
        Where the pressure is above `seizure` times the hardness [-].
    seizure : float
        [-]

    Raises
    ------
    SceneError
        If a number is not positive, or velocities do not ascend.

    Examples
    --------
    >>> law = ArchardMap()
    >>> print(law.coefficient(pressure=1000.0, slip_velocity=[100.0, 400.0, 900.0]))
    [0.00055 0.0035  0.00055]
    """

    hardness: float = 2600.0
    velocities: Sequence[float] = (200.0, 700.0)
    k: Sequence[float] = (5.5e-4, 35e-4, 5.5e-4)
    k_seizure: float = 350e-4
    seizure: float = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        velocities = checks.positives("wear.velocities", self.velocities)
        k = checks.positives("wear.k", self.k)
        if (
            velocities.ndim != 1
            or k.shape != (velocities.size + 1,)
            or (np.diff(velocities) <= 0).any()
        ):
            raise SceneError(
                "wear.velocities", self.velocities, "ascending, and one fewer than coefficients k"
            )
        object.__setattr__(self, "velocities", tuple(velocities.tolist()))
        object.__setattr__(self, "k", tuple(k.tolist()))

    def coefficient(self, pressure: Any, slip_velocity: Any) -> np.ndarray:
        """Coefficients k at a `pressure` [N/mm^2] and a `slip_velocity` [mm/s]."""
        pressed = checks.numbers("pressure", pressure)
        slip = checks.numbers("slip_velocity", slip_velocity)
        if slip.size and slip.min() < 0:
            raise SceneError("slip_velocity", float(slip.min()), "zero or positive")
        mild = np.asarray(self.k)[np.searchsorted(self.velocities, slip, side="right")]
        return np.asarray(np.where(pressed > self.seizure * self.hardness, self.k_seizure, mild))


@checks.named_options()
def british_rail_wear(t_gamma: Any, diameter: float, pieces: Pieces = BRITISH_RAIL) -> np.ndarray:
    """Area worn off a wheel's profile by distance, by the function of British Rail.

    Parameters
    ----------
    t_gamma : float or array_like
        [N]
    diameter : float
        Wheel diameter [mm].
    pieces : sequence of (start, slope, constant)
        Other numbers, see `BRITISH_RAIL`.

    Returns
    -------
    ndarray
        [mm^2/km]: 0.25 T-gamma/D in mild wear, 25/D from 100 N on, and (1.19
        T-gamma - 154)/D from 200 N on, by T. G. Pearce, N. D. Sherratt, Wear
        144 (1991) 343-351, as reviews quote it.

    Examples
    --------
    >>> print(british_rail_wear([40.0, 150.0, 300.0], diameter=920.0).round(4))
    [0.0109 0.0272 0.2207]
    """
    return _by_pieces("t_gamma", t_gamma, pieces) / checks.positive("diameter", diameter)


@checks.named_options()
def sheffield_wear(t_gamma_by_area: Any, pieces: Pieces = SHEFFIELD) -> np.ndarray:
    """Mass worn off R8T wheel steel by distance and area of contact, by the
    function of the University of Sheffield.

    Parameters
    ----------
    t_gamma_by_area : float or array_like
        `PatchWear.t_gamma_by_area` [N/mm^2].
    pieces : sequence of (start, slope, constant)
        Other numbers, as of other steels; see `SHEFFIELD`.

    Returns
    -------
    ndarray
        [ug/(m mm^2)]: 5.3 T-gamma/A in mild wear, 55 in severe wear from 10.4
        N/mm^2 on, and 55 + 61.9 (T-gamma/A - 77.2) in catastrophic wear from
        77.2 N/mm^2 on, by F. Braghin, R. Lewis, R. S. Dwyer-Joyce, S. Bruni,
        Wear 261 (2006) 1253-1264, as reviews quote it.

    Examples
    --------
    >>> print(sheffield_wear([2.0, 20.0, 80.0]).round(1))
    [ 10.6  55.  228.3]
    """
    return _by_pieces("t_gamma_by_area", t_gamma_by_area, pieces)


@checks.named_options()
def fatigue_damage(
    t_gamma: Any, course: tuple[Sequence[float], Sequence[float]] = WHOLE_LIFE
) -> np.ndarray:
    """Damage of a rail by rolling contact fatigue by one passage, by the whole life rail model.

    Parameters
    ----------
    t_gamma : float or array_like
        [N]
    course : pair of sequences
        Other values of T-gamma and damages there, two or more; beyond them the
        last line goes on.

    Returns
    -------
    ndarray
        [1e-6]: cracks begin where the sum reaches 1. Up to 15 N there is none,
        at 65 N it is largest, and from 175 N on negative: wear removes cracks.
        By M. Burstow, Whole life rail model application, RSSB T115 (2004), as
        reviews quote it.

    Examples
    --------
    >>> print(fatigue_damage([10.0, 40.0, 65.0, 120.0, 230.0]))
    [ 0.  5. 10.  5. -5.]
    """
    work = checks.numbers("t_gamma", t_gamma)
    points = checks.array("course", course, 2)
    if points.shape[0] != 2 or points.shape[1] < 2 or (np.diff(points[0]) <= 0).any():
        raise SceneError(
            "course", course, "two or more values of T-gamma, ascending, and as many damages"
        )
    (*_, peak, last), (*_, most, end) = points
    beyond = end + (most - end) / (peak - last) * (work - last)
    return np.asarray(np.where(work > last, beyond, np.interp(work, *points)))


def _by_pieces(field: str, value: Any, pieces: Pieces) -> np.ndarray:
    work = checks.numbers(field, value)
    if (work < 0).any():
        raise SceneError(field, float(work.min()), "zero or positive")
    rows = checks.array("pieces", pieces, 2)
    if rows.shape[1] != 3 or rows[0, 0] != 0 or (np.diff(rows[:, 0]) <= 0).any():
        raise SceneError(
            "pieces", pieces, "rows of start, slope and constant; starts ascend from 0"
        )
    starts, slopes, constants = rows.T
    piece = np.searchsorted(starts, work, side="right") - 1
    return np.asarray(constants[piece] + slopes[piece] * work)
