"""The certificate: how exact given pressures and tractions are, judged by the problem's own data."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.force_bounds import force_bound, outputs_of, pressure_error, pressure_part, unknown
from varcontact.discrete.problems import TangentialProblem
from varcontact.discrete.residuals import (
    coupling_residual,
    gap,
    normal_gap,
    normal_residual,
    project,
    relative,
    residual_on_grid,
    worst,
)
from varcontact.discrete.state import ContactState
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
    bounds : ForceBounds or callable
        The bounds on the forces, or what computes them. Newton's method without a matrix is faster than that: by
        default they are computed after it when they are first asked for.
    """

    gap: float
    relative_gap: float
    residual: float
    normal_relative_gap: float
    normal_residual: float
    tangential_residual: float
    level: str
    bounds: ForceBounds | Callable[[], ForceBounds] = field(repr=False)

    @classmethod
    def none(cls) -> Certificate:
        """An empty certificate: all measures are NaN."""
        return cls(np.nan, np.nan, np.nan, np.nan, np.nan, np.nan, "none", _no_bounds())

    @property
    def _known_bounds(self) -> ForceBounds:
        if not isinstance(self.bounds, ForceBounds):
            object.__setattr__(self, "bounds", self.bounds())  # and frees what they take
        assert isinstance(self.bounds, ForceBounds)
        return self.bounds

    @property
    def force_bound(self) -> np.ndarray:
        """Guaranteed bounds on the errors of Fx, Fy and Mz, shape (3,), with what rounding can do.

        Against the exact solution of the discrete problem. Infinite where no such bound is known: for unlike bodies,
        whose pressure depends on the tractions, under a law of friction, whose coefficient depends on the slip, where
        S is not found to be positive definite, with elements softened as far as a pressure covers them that is not
        exact enough to tell, and where it is left out.
        """
        return self._known_bounds.whole

    def without_moment(self) -> Certificate:
        """That of tractions by a theory without a moment: NaN bounds it."""
        return replace(self, bounds=ForceBounds(self.force_bound * [1.0, 1.0, np.nan], self.pressure_part))

    @property
    def pressure_part(self) -> np.ndarray:
        """What of `force_bound` is for the pressure's own distance from the exact one, shape (3,).

        Zero where the pressure is Hertz's closed form, which is what is asked for. NaN where it is not known: then
        `force_bound` is for the pressure as it is given, as with forces prescribed or infinite friction. In histories
        both are those of one step, for what the steps before left.
        """
        return self._known_bounds.pressure_part

    def plain(self) -> dict[str, float | str | list[float]]:
        """Numbers, the level, and the bounds as two lists of three, by name: what a file keeps."""
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


def certificate_of(
    disc: Discretisation, state: ContactState, closed_form: bool, level: str = "full", lazily: bool = False
) -> Certificate:
    """The certificate of a contact state; with a `closed_form`, Hertz's pressure is taken as given.

    Both problems are judged with the other's final tractions: the residual is that of the whole, without the normal one
    where the pressure is a closed form that is asked for. The `level` is one of `LEVELS`, or "auto"; `lazily` bounds
    on forces are left to when they are asked for.
    """
    normal, pressure, approach = normal_as_solved(disc, state.pressure, state.approach, state.traction)
    normal_error = normal_residual(normal, pressure, approach)
    tangential = None if disc.loading.frictionless else disc.tangential_problem(state.pressure, acting=state.traction)
    if level == "auto":
        level = "full" if tangential is None or tangential.size <= FULL_LIMIT else "gap"
    absolute = relative_gap = normal_relative = np.nan
    if level != "none":
        absolute, normal_relative = normal_gap(normal, pressure, approach)
        relative_gap = normal_relative
    whole, has_friction = normal_error, tangential is not None and tangential.size > 0
    if tangential is None:
        stray = float(np.hypot(*state.traction).max())  # where no friction can carry it, all is error
        residual = relative(stray, stray)
    else:
        residual = residual_on_grid(tangential, state)
    if tangential is not None and has_friction:
        whole = worst(whole, coupling_residual(disc, normal, tangential, state, approach))
        tractions, shifts = tangential.of_grid(state.traction, state.rigid)
        if level != "none":
            absolute, relative_gap = gap(tangential, project(tractions, tangential.bound), shifts)
    certificate = Certificate(
        gap=absolute * disc.scales.force * disc.scales.displacement,
        relative_gap=relative_gap,
        residual=residual if closed_form and has_friction else worst(residual, whole),
        normal_relative_gap=normal_relative,
        normal_residual=normal_error,
        tangential_residual=residual,
        level=level,
        bounds=partial(_force_bounds, disc, state, closed_form) if level == "full" else _no_bounds(),
    )
    return certificate if lazily else replace(certificate, bounds=certificate._known_bounds)


def _no_bounds() -> ForceBounds:
    return ForceBounds(np.full(3, np.inf), np.full(3, np.nan))


@one_blas_thread()
def _force_bounds(disc: Discretisation, state: ContactState, closed_form: bool) -> ForceBounds:
    """Bounds on the errors of Fx, Fy, Mz, in the scene's units."""
    scales = disc.scales.force * np.array([1.0, 1.0, disc.scales.length])
    tangential = None if disc.loading.frictionless else disc.tangential_problem(state.pressure, acting=state.traction)
    bearing = np.zeros(0, dtype=int) if tangential is None else tangential.operator.elements
    stray_x, stray_y = np.delete(state.traction.reshape(2, -1), bearing, axis=1)  # all error
    x, y = np.delete(disc.points.reshape(2, -1), bearing, axis=1)
    totals = [stray_x.sum(), stray_y.sum(), (x * stray_y - y * stray_x).sum()]
    bound, part = disc.lattice.area * np.abs(totals), np.zeros(3)
    if tangential is not None and tangential.size > 0:
        own, part = _of_tractions(disc, tangential, state, closed_form)
        bound = bound + own
    return ForceBounds(bound * scales, part * scales)


def _of_tractions(
    disc: Discretisation, tangential: TangentialProblem, state: ContactState, closed_form: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds on the errors of Fx, Fy, Mz where friction can act, and what of them is for the pressure, (3,) each."""
    not_known = np.full(3, np.nan)
    if disc.K != 0 or disc.loading.law is not None:
        return unknown(outputs_of(tangential)), not_known
    tractions, shifts = tangential.of_grid(state.traction, state.rigid)
    if closed_form:
        return force_bound(tangential, tractions, shifts), np.zeros(3)
    error = None
    if not (tangential.no_slip or tangential.free):
        normal, pressure, approach = normal_as_solved(disc, state.pressure, state.approach)
        error = pressure_error(normal, pressure, float(approach[0]))
    if error is None:
        return force_bound(tangential, tractions, shifts), not_known
    if disc.edge_compliance is not None and np.any(error.possible & (pressure <= error.size)):
        return unknown(outputs_of(tangential)), not_known  # how far elements give way is open
    of_parts = error.possible.reshape(disc.grid.divided(disc.cells).shape)
    possible = means(of_parts.astype(float), disc.cells) > 0
    wider = disc.tangential_problem(state.pressure, acting=state.traction, possible=possible)
    of_means = error.size / math.sqrt(math.prod(disc.cells))
    part = pressure_part(wider, of_means * float(np.max(np.asarray(disc.loading.coefficient))))
    return force_bound(wider, *wider.of_grid(state.traction, state.rigid)) + part, part
