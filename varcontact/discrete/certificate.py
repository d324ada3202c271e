"""The certificate: how exact given pressures and tractions are, judged by the problem's own data."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.force_bounds import force_bound, outputs_of, pressure_error, pressure_part, unknown
from varcontact.discrete.problems import TangentialProblem
from varcontact.discrete.residuals import (
    gap,
    handed_on,
    magnitude,
    normal_gap,
    normal_residual,
    project,
    relative,
    tangential_residual,
    worst,
)
from varcontact.discrete.subgrid import means, normal_as_solved
from varcontact.system.threads import one_blas_thread

LEVELS = ("full", "gap", "none")
"""Levels of a certificate: everything; without bounds on the forces; the residuals alone."""

FULL_LIMIT = 10_000
"""Elements with friction up to which "auto" is "full"; beyond it is "gap"."""


@dataclass(frozen=True, eq=False)
class ForceBounds:
    """Bounds on the errors of Fx, Fy and Mz, and the part of them that is for the pressure's own error, (3,) each."""

    whole: np.ndarray
    pressure_part: np.ndarray

    @classmethod
    def known(cls, whole: np.ndarray, pressure_part: np.ndarray) -> Callable[[], ForceBounds]:
        """As a certificate takes them, where there is nothing to compute.

        Parameters
        ----------
        whole, pressure_part : ndarray, shape (3,)
            [force] and, of the moment, [force length].
        """
        return partial(cls, whole, pressure_part)


@dataclass(frozen=True, eq=False)
class Certificate:
    """How exact a solution of the discrete problem is.

    Attributes
    ----------
    gap : float
        Duality gap of the tangential problem, ``sum((g_i |E_i| + p_i'E_i) dx dy)`` [force length]: zero
        exactly at the solution, positive elsewhere. In normal contact without friction, that of the normal
        problem. NaN where it is left out.
    relative_gap : float
        The gap by ``sum(g_i |W_i| dx dy)``, the work of the full bound against the rigid shift.
    residual : float
        Natural-map residual, the largest ``|p - Proj(p - E/rho)|`` by the largest traction; the larger of the
        tangential and the normal one. For unlike bodies also what the normal one does to the tractions, which grows
        like K by friction: the tangential residual under the pressures that the natural map has in place of these.
        With Hertz's closed form as the pressure of a tangential problem the
        normal one is left out: it is the grid's error, and found in `normal_residual`.
    normal_relative_gap, normal_residual, tangential_residual : float
        The same measures of the two problems.
    level : {"full", "gap", "none"}
        What was asked for: everything; no bound on the forces; the residuals alone.
    bounds : callable
        Gives the bounds on the forces. Newton's method without a matrix is faster than they are: by default they are
        computed after it when they are first asked for.
    """

    gap: float
    relative_gap: float
    residual: float
    normal_relative_gap: float
    normal_residual: float
    tangential_residual: float
    level: str
    bounds: Callable[[], ForceBounds] = field(repr=False)

    @classmethod
    def none(cls) -> Certificate:
        """That of an answer of which nothing is found out."""
        nothing = ForceBounds.known(np.full(3, np.inf), np.full(3, np.nan))
        return cls(np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, "none", nothing)

    @cached_property
    @one_blas_thread()
    def _bounds(self) -> ForceBounds:
        found = self.bounds()
        object.__setattr__(self, "bounds", ForceBounds.known(found.whole, found.pressure_part))  # free what they took
        return found

    @property
    def force_bound(self) -> np.ndarray:
        """Guaranteed bounds on the errors of Fx, Fy and Mz, shape (3,), with what rounding can do.

        Against the exact solution of the discrete problem. Infinite where no such bound is known: for unlike bodies,
        whose pressure depends on the tractions, under a law of friction, whose coefficient depends on the slip, where
        S is not found to be positive definite, with elements softened as far as a pressure covers them that is not
        exact enough to tell, and where it is left out.
        """
        return self._bounds.whole

    def without_moment(self) -> Certificate:
        """That of tractions by a theory without a moment: NaN bounds it."""
        return replace(self, bounds=ForceBounds.known(self.force_bound * [1.0, 1.0, np.nan], self.pressure_part))

    @property
    def pressure_part(self) -> np.ndarray:
        """What of `force_bound` is for the pressure's own distance from the exact one, shape (3,).

        Zero where the pressure is Hertz's closed form, which is what is asked for. NaN where it is not known: then
        `force_bound` is for the pressure as it is given, as with forces prescribed or infinite friction. In histories
        both are those of one step, for what the steps before left.
        """
        return self._bounds.pressure_part

    def plain(self) -> dict[str, float | str | list[float]]:
        """All of it as plain data, the bounds among it; what a file keeps.

        Returns
        -------
        dict
            By name: numbers, the level, and two lists of three.
        """
        return {
            "gap": self.gap,
            "relative_gap": self.relative_gap,
            "level": self.level,
            "force_bound": self.force_bound.tolist(),
            "pressure_part": self.pressure_part.tolist(),
            "residual": self.residual,
            "normal_relative_gap": self.normal_relative_gap,
            "normal_residual": self.normal_residual,
            "tangential_residual": self.tangential_residual,
        }


def certify_problems(
    disc: Discretisation,
    pressure: np.ndarray,
    approach: float,
    traction: np.ndarray,
    rigid: np.ndarray,
    closed_form: bool,
    level: str = "full",
    lazily: bool = False,
) -> Certificate:
    """The certificate of pressures (ny, nx) and tractions (2, ny, nx), given dimensionless.

    Both problems are judged with the other's final tractions: the residual is that of the whole, without the normal one
    where the pressure is a `closed_form` that is asked for. The `level` is one of `LEVELS`, or "auto".

    Parameters
    ----------
    disc : Discretisation
    pressure : ndarray, shape (ny, nx)
        Dimensionless, as all that follow.
    approach : float
    traction : ndarray, shape (2, ny, nx)
    rigid : ndarray, shape (2,)
        Unknown part of the rigid shift.
    closed_form : bool
        Whether the pressure is Hertz's, taken as given.
    level : str
        One of `LEVELS`, or "auto".
    lazily : bool
        Whether the bounds on forces are left to when they are asked for.

    Returns
    -------
    Certificate
    """
    normal, pressed, level_of_contact = normal_as_solved(disc, pressure, approach, traction)
    normal_error = normal_residual(normal, pressed, level_of_contact)
    tangential = None if disc.loading.frictionless else disc.tangential_problem(pressure, acting=traction)
    if level == "auto":
        level = "full" if tangential is None or tangential.size <= FULL_LIMIT else "gap"
    absolute = normal_relative = np.nan
    if level != "none":
        absolute, normal_relative = normal_gap(normal, pressed, level_of_contact)
    bearing = np.zeros(0, dtype=int) if tangential is None else tangential.operator.elements
    flat = traction.reshape(2, -1)
    stray = np.delete(flat, bearing, axis=1)  # what acts where no friction can carry it is all error
    residual = relative(float(magnitude(stray).max(initial=0.0)), float(magnitude(flat).max()))
    relative_gap, whole = normal_relative, normal_error
    if tangential is not None and tangential.size > 0:
        whole = worst(whole, handed_on(disc, normal, pressure, level_of_contact, traction, rigid))
        tractions, shifts = tangential.of_grid(traction, rigid)
        residual = worst(residual, tangential_residual(tangential, tractions, shifts))
        if level != "none":
            absolute, relative_gap = gap(tangential, project(tractions, tangential.bound), shifts)
    asked_for = closed_form and tangential is not None and tangential.size > 0
    certificate = Certificate(
        gap=absolute * disc.scales.force * disc.scales.displacement,
        relative_gap=relative_gap,
        residual=residual if asked_for else worst(residual, whole),
        normal_relative_gap=normal_relative,
        normal_residual=normal_error,
        tangential_residual=residual,
        level=level,
        bounds=partial(_force_bounds, disc, pressure, approach, traction, rigid, closed_form)
        if level == "full"
        else ForceBounds.known(np.full(3, np.inf), np.full(3, np.nan)),
    )
    if not lazily:
        certificate = replace(certificate, bounds=ForceBounds.known(certificate.force_bound, certificate.pressure_part))
    return certificate


def _force_bounds(
    disc: Discretisation,
    pressure: np.ndarray,
    approach: float,
    traction: np.ndarray,
    rigid: np.ndarray,
    closed_form: bool,
) -> ForceBounds:
    """Bounds on the errors of Fx, Fy, Mz, in the scene's units."""
    scales = disc.scales.force * np.array([1.0, 1.0, disc.scales.length])
    tangential = None if disc.loading.frictionless else disc.tangential_problem(pressure, acting=traction)
    bearing = np.zeros(0, dtype=int) if tangential is None else tangential.operator.elements
    stray = np.delete(traction.reshape(2, -1), bearing, axis=1)  # all error
    bound = disc.lattice.area * np.abs(_totals(np.delete(disc.points.reshape(2, -1), bearing, axis=1), stray))
    part = np.zeros(3)
    if tangential is not None and tangential.size > 0:
        own, part = _of_tractions(disc, tangential, pressure, approach, traction, rigid, closed_form)
        bound = bound + own
    return ForceBounds(bound * scales, part * scales)


def _of_tractions(
    disc: Discretisation,
    tangential: TangentialProblem,
    pressure: np.ndarray,
    approach: float,
    traction: np.ndarray,
    rigid: np.ndarray,
    closed_form: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds on the errors of Fx, Fy, Mz where friction can act, and what of them is for the pressure, (3,) each."""
    if disc.K != 0 or disc.loading.law is not None:
        return unknown(outputs_of(tangential)), np.full(3, np.nan)
    if closed_form:
        return force_bound(tangential, *tangential.of_grid(traction, rigid)), np.zeros(3)
    error = None
    if not (tangential.no_slip or tangential.free):
        normal, pressed, level = normal_as_solved(disc, pressure, approach)
        error = pressure_error(normal, pressed, float(level[0]))
    if error is None:
        return force_bound(tangential, *tangential.of_grid(traction, rigid)), np.full(3, np.nan)
    if disc.edge_compliance is not None and np.any(error.possible & (pressed <= error.size)):
        return unknown(outputs_of(tangential)), np.full(3, np.nan)  # how far elements give way is open
    of_parts = error.possible.reshape(disc.grid.divided(disc.cells).shape)
    possible = means(of_parts.astype(float), disc.cells) > 0
    wider = disc.tangential_problem(pressure, acting=traction, possible=possible)
    of_means = error.size / math.sqrt(math.prod(disc.cells))
    part = pressure_part(wider, of_means * float(np.max(np.asarray(disc.loading.coefficient))))
    return force_bound(wider, *wider.of_grid(traction, rigid)) + part, part


def _totals(points: np.ndarray, traction: np.ndarray) -> np.ndarray:
    """Sums of tractions (2, n) along x, along y, and of their moments, shape (3,)."""
    moment = points[0] * traction[1] - points[1] * traction[0]
    return np.array([traction[0].sum(), traction[1].sum(), moment.sum()])
