"""What both problems share: Newton's method from a start or from coarse grids, then the fallback."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

import numpy as np

from varcontact.checks import wrong_shape
from varcontact.discrete.problems import RawSolution
from varcontact.solvers.newton.newton import MAX_STEPS
from varcontact.solvers.newton.safeguard import Point
from varcontact.solvers.settings import Settings

COARSE_TOL = 1e-2
"""Residual on all grids but the finest."""
ROUNDED = 0.9
"""Part of the tolerance to reach, as the certificate rounds differently."""
DENSE = 2000
"""Elements up to which a problem that Newton's method leaves unsolved is given to dense active sets."""
REFINED, LEAST, REFINING = 1e-3, 1e-12, 4
"""Part of the tolerance that a solved problem of so few elements is refined to, the least residual that is asked for,
and the steps that may take: a tenth of the time, which leaves hardly more than rounding."""


class Posed(Protocol):
    """A problem in its own units."""

    def begun(self, start: RawSolution) -> Point:
        """Where a start leads.

        Parameters
        ----------
        start : RawSolution
            Dimensionless, in double precision.

        Returns
        -------
        Point
            In units of the kernel, in single precision.
        """

    def approached(self) -> tuple[Point, int]:
        """Where coarser grids lead, and the Newton steps taken there."""

    def solved(self, at: Point, tol: float, most: int = MAX_STEPS) -> RawSolution:
        """By Newton's method from a point.

        Parameters
        ----------
        at : Point
            In units of the kernel, in single precision.
        tol : float
            Residual to be reached [-].
        most : int
            Newton steps.

        Returns
        -------
        RawSolution
            Dimensionless, in double precision.
        """


def driven(
    posed: Posed,
    start: RawSolution | None,
    settings: Settings,
    size: int,
    dense: Callable[[RawSolution], RawSolution],
    residual: Callable[[RawSolution], float],
    patience: int = MAX_STEPS,
) -> RawSolution:
    """Newton's method from a start; without one, or if that fails, from coarse grids; then active sets.

    Parameters
    ----------
    posed : Posed
    start : RawSolution or None
    settings : Settings
    size : int
        Number of elements.
    dense : callable
        Active sets, from what Newton's method has; the answer bears their name.
    patience : int
        Steps on the finest grid after which active sets take over, where they can.
    residual : callable
        Of an answer.
    """
    tol, spent, raw = ROUNDED * settings.tol, 0, None
    most = patience if size <= DENSE else MAX_STEPS
    if start is not None and _finite(start):
        raw = posed.solved(posed.begun(start), tol, most)
        spent = raw.iterations
    if raw is None or not raw.solved:
        at, steps = posed.approached()
        raw = posed.solved(at, tol, most)
        spent += steps + raw.iterations
    raw = replace(raw, iterations=spent)
    if size > DENSE or (raw.solved and settings.rough):
        return raw
    if raw.solved:
        fine = posed.solved(posed.begun(raw), max(REFINED * tol, LEAST), REFINING)
        if not residual(fine) < residual(raw):
            return raw
        return replace(fine, iterations=spent + fine.iterations, status=raw.status, solved=True)
    other = dense(raw)
    if not (_finite(other) and residual(other) < residual(raw)):
        return raw
    return replace(other, iterations=spent, reason=f"newton missed the tolerance, {other.solver} was used")


def not_a_number(traction: tuple[int, ...], rigid: int) -> RawSolution:
    """The answer for data that are not finite: zeros, not solved.

    Parameters
    ----------
    traction : tuple of int
        Shape of the tractions.
    rigid : int
        Number of rigid shifts.
    """
    return RawSolution(np.zeros(traction), np.zeros(rigid), 0, "NotANumber", False)


def check_start(start: RawSolution | None, traction: tuple[int, ...], rigid: tuple[int, ...]) -> None:
    """Refuse a start whose arrays do not have the shapes of the problem.

    Parameters
    ----------
    start : RawSolution or None
    traction, rigid : tuple of int
        The shapes of the problem.

    Raises
    ------
    SceneError
        If the start has others.
    """
    if start is None:
        return
    for name, found, wanted in (("traction", start.traction, traction), ("rigid", start.rigid, rigid)):
        if found.shape != wanted:
            raise wrong_shape(f"start.{name}", found.shape, f"of shape {wanted}, as the problem has")


def _finite(raw: RawSolution) -> bool:
    return bool(np.isfinite(raw.traction).all() and np.isfinite(raw.rigid).all())
