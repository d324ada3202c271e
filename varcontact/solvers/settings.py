"""What every solver is given besides its problem."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field

from varcontact.solvers.conic.setups import Setups
from varcontact.solvers.statistics import SolveStats

LONGEST = 1e9
"""Seconds that a solver of programs has where there is no deadline."""


class OutOfTime(Exception):
    """A solver has not finished by its deadline."""


def check_time(deadline: float) -> None:
    """Look at the time, in every iteration that takes long.

    Parameters
    ----------
    deadline : float
        By `time.perf_counter` [s].

    Raises
    ------
    OutOfTime
        Past it.
    """
    if time.perf_counter() > deadline:
        raise OutOfTime


@dataclass(frozen=True)
class Settings:
    """What every solver is told.

    Attributes
    ----------
    tol : float
        Accuracy wanted of the tractions, relative; `varcontact.solvers.conic.accuracy` says what that means to each.
    formulation : str
        The program to be solved: "complementary", "potential" or "gap"; "auto" for the one that suits.
    setups : Setups, optional
        Where solvers keep their set-ups for the next problem of the same structure.
    stats : SolveStats
        Where their calls are counted.
    rough : bool
        Whether the answer is one of many passes or of a scan, and nothing beyond `tol` is of use.
    deadline : float
        When solvers raise `OutOfTime`, by `time.perf_counter` [s].
    """

    tol: float = 1e-8
    formulation: str = "auto"
    setups: Setups | None = None
    stats: SolveStats = field(default_factory=SolveStats)
    rough: bool = False
    deadline: float = math.inf

    @property
    def seconds_left(self) -> float:
        """Until the deadline, more than zero."""
        return min(max(self.deadline - time.perf_counter(), 1e-3), LONGEST)
