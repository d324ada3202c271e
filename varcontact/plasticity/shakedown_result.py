"""The result of `shakedown`: factors of the load, mechanisms and a report."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from varcontact.html import Reported
from varcontact.plasticity.koiter import FlowField

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Hardening = Literal["none", "kinematic"]
Mode = Literal["surface flow", "subsurface ratchetting", "alternating plasticity"]


@dataclass(frozen=True, eq=False)
class Section:
    """Residual stress that makes the contact shake down, in the cross-section x = const.

    Attributes
    ----------
    y, depth : ndarray
        Places [length].
    stress : ndarray, shape (3, 3, nz, ny)
        At the load factor `Shakedown.lower`, tension positive, z into the body [force/area]; with
        kinematic hardening the back stress.
    utilised : ndarray, shape (nz, ny), or None
        Largest stress of a passage, by the yield stress, where a program was solved.
    """

    y: np.ndarray
    depth: np.ndarray
    stress: np.ndarray
    utilised: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class Shakedown(Reported):
    """Bounds on the factor by which all tractions can grow until plastic strain no longer stops.

    Attributes
    ----------
    lower, upper : float
        Bounds on the load factor, by Melan's and Koiter's theorems: at a factor below `lower` the
        body shakes down, above `upper` it does not.
    sampled : float
        The lower bound at the samples of the passage.
    proved : bool
        True where `lower` is a theorem for the field of the grid's tractions, between the samples,
        too: half-spaces with a `gap`. Elsewhere what may lie between samples is estimated by second
        differences, as it is in the lower one of `kinematic` in point contact without hardening.
    elastic : float
        Load factor at first yield.
    kinematic : tuple of float
        Bounds on the load factor with unlimited kinematic hardening.
    mode : {"surface flow", "subsurface ratchetting", "alternating plasticity"}
        Mechanism of the upper bound.
    place : float
        Its y, from the scene's origin [length].
    depth : float
        Its depth [length].
    flow : ndarray, shape (2,)
        Net plastic shear of a passage along x and y, by all plastic strain: 0 for alternating
        plasticity, 1 where all strain stays.
    field_error : float
        Relative change of the upper bound by tractions of half the elements either way; NaN for a
        field of the user's.
    peak_pressure : float
        Largest pressure on the grid [force/area].
    strength : float
        Least yield stress in shear [force/area].
    hardening : {"none", "kinematic"}
    section : Section
        Residual stress at the places `y` and `depth`: `stress`, shape (3, 3, nz, ny), and
        `utilised`, shape (nz, ny), the largest stress of a passage by the yield stress.
    mechanism : FlowField or None
        Velocities, where a program found the upper bound.
    critical : ndarray, shape (n, 5)
        Elastic stresses that pass the critical point, by the yield stress, in five coordinates, see
        docs/shakedown.md.
    centre : ndarray, shape (5,)
        Centre of the smallest ball about them: at `upper` its radius is the yield stress.
    local : float
        Largest traction by the largest pressure: ``upper <= strength / (local * peak_pressure)`` is
        a theorem.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e3, nu=0.28), surface=vc.Ellipse(a=6.0, b=6.0),
    ...     normal_force=80e3, friction=0.4, motion=vc.Steady(vx=-0.1), grid=vc.Grid(16, 16))
    >>> limit = vc.shakedown(vc.solve(scene), k=300.0, body="lower", gap=None)
    >>> print(f"{limit.upper:.2f}, {limit.mode}; yields at {limit.elastic:.2f}")
    0.71, surface flow; yields at 0.65
    """

    lower: float
    upper: float
    sampled: float
    proved: bool
    elastic: float
    kinematic: tuple[float, float]
    mode: Mode
    place: float
    depth: float
    flow: np.ndarray
    field_error: float
    peak_pressure: float
    strength: float
    local: float
    hardening: Hardening
    section: Section = field(repr=False)
    mechanism: FlowField | None = field(repr=False)
    critical: np.ndarray = field(repr=False)
    centre: np.ndarray = field(repr=False)

    @property
    def gap(self) -> float:
        """Distance of the bounds, relative to the upper one."""
        return 1 - self.lower / self.upper

    @property
    def outcome(self) -> str:
        """Outcome under the tractions as they are: "elastic", "shakes down", "undecided" between
        the bounds, or the mode.
        """
        if self.upper < 1:
            return self.mode
        if self.elastic >= 1:
            return "elastic"
        if self.lower >= 1:
            return "shakes down"
        return "undecided"

    def report(self) -> str:
        """Report of the limit and its bounds."""
        pressure = self.peak_pressure / self.strength
        between = "estimated"
        if self.proved:
            between = "proved"
        lines = [
            f"shakedown: {self.outcome} (peak pressure {pressure:.4g} k, largest traction "
            f"{self.local:.3f} of it)",
            f"load factor {self.lower:.4g} to {self.upper:.4g} (gap {100 * self.gap:.1f} %; "
            f"{self.sampled:.4g} at samples, {between} between them), "
            f"first yield at {self.elastic:.4g}",
            f"{self.mode} at y = {self.place:.4g}, depth {self.depth:.4g}",
            f"with kinematic hardening {self.kinematic[0]:.4g} to {self.kinematic[1]:.4g}",
        ]
        if not math.isnan(self.field_error):
            lines.append(f"error of the elastic field: {100 * self.field_error:.1f} %")
        return "\n".join(lines)

    def plot(self) -> Figure:
        """The section with the residual stress and the net flow, and the critical curve."""
        from varcontact.plasticity.plots import plot_limit

        return plot_limit(self)
