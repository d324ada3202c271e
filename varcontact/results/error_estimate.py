"""Estimated error against the continuum, which remains on every grid."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from varcontact.html import in_rows, preformatted

BY_NAME = ("values", "errors", "on_grid", "bars")
"""Entries that are dictionaries by the name of a value."""


@dataclass(frozen=True)
class Solve:
    """Grid and time of one of the solves behind an estimate."""

    nx: int  # elements across the contact along x and y
    ny: int  # elements across the contact along x and y
    seconds: float


@dataclass(frozen=True)
class ErrorEstimate:
    """Distance of an answer from the continuum, estimated from the answer itself.

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
        value itself. Of a history by the largest f Fz of its steps.
    how : str
        Method of the estimate, in words.
    solves : tuple of Solve
        Solves that it took, in order.
    accuracy, time_budget : float or None
        Accuracy or time that was requested.
    on_grid : dict of str to float
        Values on the finest grid, whose fields the solution has: the
        values before they were extrapolated. Empty where nothing was.
    bars : dict of str to float
        The errors in the units of the values: error bars. Also of a largest
        pressure that does not count for the accuracy, and has no entry in
        `errors`.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.1))
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
        rows = []
        for name, value in self.values.items():
            measured = with_bar(value, self.bars.get(name, 0.0))
            rows.append((name, f"{measured}, error {self.errors.get(name, 0.0):.1e}"))
        rows.append(("how", self.how))
        return preformatted(in_rows("Estimated error against the continuum", rows))

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
        parts: dict[str, Any] = {}
        for part in BY_NAME:
            parts[part] = {
                name.removesuffix(f"[{k}]"): value
                for name, value in getattr(self, part).items()
                if name.endswith(f"[{k}]")
            }
        return replace(self, **parts)

    @classmethod
    def of_history(cls, steps: Sequence[ErrorEstimate]) -> ErrorEstimate:
        """Estimate of a history from those of its steps: each name with its step, as ``Fx[3]``.

        Parameters
        ----------
        steps : sequence of ErrorEstimate
            One at least.
        """
        parts: dict[str, Any] = {}
        for part in BY_NAME:
            parts[part] = {
                f"{name}[{k}]": value
                for k, step in enumerate(steps)
                for name, value in getattr(step, part).items()
            }
        return replace(steps[0], **parts)

    def plain(self) -> dict[str, Any]:
        """Record of dictionaries, lists and numbers, for files and JSON output."""
        return asdict(self) | {"solves": [asdict(each) for each in self.solves]}

    @classmethod
    def from_plain(cls, record: dict[str, Any]) -> ErrorEstimate:
        """Error estimate from its record, as `plain` gives it; ValueError for any other record."""
        try:
            solves = tuple(Solve(**each) for each in record["solves"])
            named = {
                part: {name: float(value) for name, value in record.get(part, {}).items()}
                for part in BY_NAME
            }
            return cls(**{**record, **named, "solves": solves})
        except (TypeError, KeyError, AttributeError) as error:
            raise ValueError(f"an estimate of the error that is none ({error})") from None


def with_bar(value: float, bar: float) -> str:
    """A value with its error bar, both rounded to two digits of that: "-11710 +- 170"; without one
    six digits.
    """
    if not 0 < bar < math.inf:
        return f"{value:.6g}"
    digits = 1 - math.floor(math.log10(bar))
    if -4 <= digits <= 6:
        decimals = max(digits, 0)
        return f"{round(value, digits):.{decimals}f} +- {round(bar, digits):.{decimals}f}"
    power = 0
    if value != 0:
        power = math.floor(math.log10(abs(value)))
    significant = max(1, 1 + digits + power)
    return f"{value:.{significant}g} +- {bar:.2g}"
