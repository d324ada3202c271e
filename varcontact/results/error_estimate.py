"""What a grid leaves open: an estimate of how far an answer is from the
continuum, and what defect correction found.

Files of earlier versions have corrections of shifts, too (slips and corrections
are lengths then), and of steps of histories (corrections then have what the
particles bring along).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from varcontact.html import in_rows, preformatted
from varcontact.scene.grid import Grid

BY_NAME = ("values", "errors", "on_grid", "bars")
"""Entries that are by the name of a value."""


@dataclass(frozen=True)
class Solve:
    """One of the solves behind an estimate."""

    nx: int  # elements across the contact along x and y
    ny: int  # elements across the contact along x and y
    seconds: float


@dataclass(frozen=True)
class ErrorEstimate:
    """How far an answer is from the continuum, as far as can be told from the answer itself.

    It is no bound, and says nothing of how exactly the grid's own equations are
    solved: that is the certificate's.

    Attributes
    ----------
    values : dict of str to float
        Values of the answer that the estimate is for, in the scene's units:
        forces and moment; creepages (of a shift the shifts) where forces are
        prescribed; of normal contact the approach (or the normal force) and the
        largest pressure.
    errors : dict of str to float
        Estimated error of each [-]: of a force by f Fz, of the moment by f Fz
        sqrt(ab), of a creepage by the saturation creepage, of the rest by the
        value itself. Of a history by the largest f Fz of its steps, corrected
        by that of the step. With infinite friction the tangential force takes
        the place of f Fz. A corrected solution has those of shifts that are
        known but for a constant, and have no value, too.
    how : str
        How it was estimated, in words.
    solves : tuple of Solve
        What was solved for it, in this order.
    accuracy, time_budget : float or None
        What was asked for.
    on_grid : dict of str to float
        Of the finest grid's own answer, whose fields the solution has: the
        values before they were extrapolated. Empty where nothing was.
    bars : dict of str to float
        The errors in the units of the values: error bars.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, friction=0.3,
    ...     motion=vc.Steady(vx=0.1))
    >>> estimate = vc.solve(scene, accuracy=0.01).error_estimate
    >>> estimate.largest < 0.01
    True
    """

    values: dict[str, float]
    errors: dict[str, float]
    how: str
    solves: tuple[Solve, ...]
    accuracy: float | None = None
    time_budget: float | None = None
    on_grid: dict[str, float] = field(default_factory=dict)
    bars: dict[str, float] = field(default_factory=dict)

    def _repr_html_(self) -> str:
        rows = [
            (name, f"{with_bar(value, self.bars.get(name, 0.0))}, error {self.errors.get(name, 0.0):.1e}")
            for name, value in self.values.items()
        ]
        return preformatted(in_rows("Estimated error against the continuum", [*rows, ("how", self.how)]))

    @property
    def largest(self) -> float:
        """The largest of the errors; 0 where nothing is open."""
        return max(self.errors.values(), default=0.0)

    def of_step(self, k: int) -> ErrorEstimate:
        """The part of a history's estimate that is for a step, under the names of one solution.

        Parameters
        ----------
        k : int
            Number of the step, from 0.
        """
        parts: dict[str, Any] = {
            part: {name.removesuffix(f"[{k}]"): value for name, value in named.items() if name.endswith(f"[{k}]")}
            for part, named in ((part, getattr(self, part)) for part in BY_NAME)
        }
        return replace(self, **parts)

    @classmethod
    def of_history(cls, steps: Sequence[ErrorEstimate]) -> ErrorEstimate:
        """That of a history, from those of its steps: each name with its step, as ``Fx[3]``.

        Parameters
        ----------
        steps : sequence of ErrorEstimate
            One at least.
        """
        parts: dict[str, Any] = {
            part: {f"{name}[{k}]": value for k, step in enumerate(steps) for name, value in getattr(step, part).items()}
            for part in BY_NAME
        }
        solves = steps[0].solves
        if any(step.solves != solves for step in steps):  # each step had its own: their time adds up
            seconds = sum(each.seconds for step in steps for each in step.solves)
            nx, ny = (max(getattr(each, name) for step in steps for each in step.solves) for name in ("nx", "ny"))
            solves = (Solve(nx, ny, seconds),)
        return replace(steps[0], solves=solves, **parts)

    def plain(self) -> dict[str, Any]:
        """As dictionaries, lists and numbers: the record of a file, and what is printed as JSON."""
        return asdict(self) | {"solves": [asdict(each) for each in self.solves]}

    @classmethod
    def from_plain(cls, record: dict[str, Any]) -> ErrorEstimate:
        """From its `record`, as `plain` gives it; ValueError if it is something else."""
        try:
            solves = tuple(Solve(**each) for each in record["solves"])
            named = {part: {name: float(value) for name, value in record.get(part, {}).items()} for part in BY_NAME}
            return cls(**{**record, **named, "solves": solves})
        except (TypeError, KeyError, AttributeError) as error:
            raise ValueError(f"an estimate of the error that is none ({error})") from None


def with_bar(value: float, bar: float) -> str:
    """A value with its error bar, both rounded to two digits of that: "-11710 +- 170"; without one six digits."""
    if not 0 < bar < math.inf:
        return f"{value:.6g}"
    digits = 1 - math.floor(math.log10(bar))
    if -4 <= digits <= 6:
        return f"{round(value, digits):.{max(digits, 0)}f} +- {round(bar, digits):.{max(digits, 0)}f}"
    size = max(1, 1 + digits + (math.floor(math.log10(abs(value))) if value else 0))
    return f"{value:.{size}g} +- {bar:.2g}"


@dataclass(frozen=True, eq=False)
class Refinement:
    """A field on parts of the elements, near the continuum's
    (docs/refinement.md). In the scene's units.

    Attributes
    ----------
    kind : str
        What was asked for: "continuum".
    grid : Grid
        The parts of the elements, explicit.
    traction : ndarray, shape (2, ny, nx)
        On body 1, on the parts [force/area].
    slip : ndarray, shape (2, ny, nx)
        The continuum's slip under it by rolling velocity [-], means over the
        parts; zero outside the contact.
    correction : ndarray
        What was added to the rigid slip of the coarse elements, (2, ny, nx) of
        the coarse grid, in the unit of slip. The solution's fields and its
        certificate are those of the coarse problem with this correction.
    share : ndarray, shape (ny, nx)
        What the traction bound of the coarse elements was multiplied by [-];
        one, but in files of earlier versions.
    forces : ndarray, shape (passes + 1, 3)
        Fx, Fy and Mz: of the coarse elements without correction, then of the
        field after each pass.
    creepages : ndarray, shape (passes + 1, 2)
        vx and vy then: as given, or found for the forces that are given.
    estimate : ndarray, shape (3,)
        Estimated error of the last Fx, Fy and Mz: how much they differ from
        those on half as many elements each way, what late passes changed or
        left out, or how far they are from those prescribed, whichever is most.
        Fx and Fy have the same, of the vector. No bound.
    creepage_estimate : ndarray, shape (2,)
        The same of vx and vy [-]; zero where they are given.
    seconds : tuple of float
        Of each pass.
    """

    kind: str
    grid: Grid
    traction: np.ndarray
    slip: np.ndarray
    correction: np.ndarray
    share: np.ndarray
    forces: np.ndarray
    creepages: np.ndarray
    estimate: np.ndarray
    creepage_estimate: np.ndarray
    seconds: tuple[float, ...]

    @property
    def passes(self) -> int:
        """Number of passes."""
        return len(self.forces) - 1

    @property
    def cells(self) -> tuple[int, int]:
        """Parts of an element along y and x."""
        (ny, nx), (rows, columns) = self.grid.shape, self.correction.shape[1:]
        return ny // rows, nx // columns

    @property
    def force(self) -> np.ndarray:
        """Total tangential force (Fx, Fy) of the field."""
        return self.forces[-1, :2].copy()

    @property
    def moment(self) -> float:
        """Twisting moment Mz of the field about the origin."""
        return float(self.forces[-1, 2])

    @property
    def change(self) -> np.ndarray:
        """Change of Fx, Fy and Mz by the last pass, absolute, (3,)."""
        return np.abs(self.forces[-1] - self.forces[-2])

    @property
    def power_density(self) -> np.ndarray:
        """Work lost by friction by area, ``-p.s``: by distance rolled [force/area]."""
        return np.asarray(0.0 - np.sum(self.traction * self.slip, axis=0))

    @property
    def friction_work(self) -> float:
        """Work lost by friction in the field, by distance rolled [force]."""
        return float(np.sum(self.power_density) * self.grid.area)

    def summary(self) -> dict[str, Any]:
        """Forces by pass, change and estimate as plain numbers."""
        return {
            "kind": self.kind,
            "parts": list(self.cells),
            "passes": self.passes,
            "forces": self.forces.tolist(),
            "creepages": self.creepages.tolist(),
            "change": self.change.tolist(),
            "error_estimate": self.estimate.tolist(),
            "creepage_estimate": self.creepage_estimate.tolist(),
            "seconds": list(self.seconds),
        }
