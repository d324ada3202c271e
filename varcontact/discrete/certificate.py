"""The certificate: how exact given pressures and tractions are, judged by the problem's own data.

Bounds on the errors of forces and moment are guaranteed, by convex duality
(docs/theory.md, "The certificate"). For the exact solution p* of a problem and
any tractions p, ``|c'(p - p*)| <= (c'S^-1 c)^(1/2) |p - p*|_S``. The distance
in the norm of S follows from the gap, and from what the problem would have to
be for p to be its solution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import partial
from typing import Self

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.positive_definite import PositiveDefinite, norm, positive_definite
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.residuals import (
    coupling_residual,
    gap,
    normal_gap,
    normal_residual,
    outside_friction,
    tangential_residual,
    worst,
)
from varcontact.discrete.state import ContactState, means, normal_as_solved
from varcontact.discrete.stick_slip import ContactResponse
from varcontact.elasticity.operators import RestrictedOperator
from varcontact.html import in_rows, preformatted
from varcontact.interfaces.potential import ROUNDING, magnitude, project
from varcontact.scene.motion import TimeStep
from varcontact.system.process import on_demand, one_blas_thread

LEVELS = ("full", "gap", "none")
"""Levels of a certificate: "full" with all measures, "gap" without bounds on the forces, "none"
with residuals alone."""

FULL_LIMIT = 10_000
"""Elements with friction up to which "auto" means "full", and above which it means "gap"."""
EPS = float(np.finfo(float).eps)

FFT_ROUNDING = 10.0
"""Relative rounding error of a product by FFT (three transforms), in machine epsilons per doubling
of its length."""

PUT_ON_BOUND_TOL = 1e-12
"""Relative distance from the traction bound at which a traction is put on it."""


@dataclass(frozen=True, eq=False)
class ForceBounds:
    """Bounds on the errors of Fx, Fy and Mz, and the part of these that comes from the pressure's
    own error, (3,) each.
    """

    whole: np.ndarray
    pressure_part: np.ndarray


NO_BOUNDS = ForceBounds(np.full(3, np.inf), np.full(3, np.nan))


@dataclass(frozen=True, eq=False)
class Certificate:
    """Certificate of a solution of the discrete problem: residuals, gaps and bounds.

    Attributes
    ----------
    gap : float
        Duality gap of the tangential problem,
        ``sum((g_i |E_i| + p_i'E_i) dx dy)`` [force length]: zero exactly at the
        solution, positive elsewhere. In normal contact without friction, that
        of the normal problem. NaN where it is left out.
    relative_gap : float
        The gap relative to ``sum(g_i |W_i| dx dy)``, the work of the full bound against
        the rigid shift.
    residual : float
        Natural-map residual, the largest ``|p - Proj(p - E/rho)|`` by the
        largest traction; the larger of the tangential and the normal one. For
        unlike bodies also what the normal one does to the tractions, which
        grows like K by friction: the tangential residual under the pressures
        that the natural map has in place of these. With Hertz's closed form as
        the pressure of a tangential problem the normal one is left out: it is
        the grid's error, and found in `normal_residual`.
    normal_relative_gap, normal_residual, tangential_residual : float
        The same measures of the two problems.
    level : {"full", "gap", "none"}
        Level that was requested: everything; no bound on the forces; the residuals
        alone.
    bounds : ForceBounds
        The bounds on the forces: by default they are computed when they are
        first asked for.
    """

    gap: float
    relative_gap: float
    residual: float
    normal_relative_gap: float
    normal_residual: float
    tangential_residual: float
    level: str
    bounds: on_demand[ForceBounds] = field(default=on_demand(), repr=False)

    @property
    def force_bound(self) -> np.ndarray:
        """Guaranteed bounds on the errors of Fx, Fy and Mz, shape (3,), with what rounding can do.

        Against the exact solution of the discrete problem. Infinite where no such bound is known:
        for unlike bodies, whose pressure depends on the tractions, under a law of friction, whose
        coefficient depends on the solution, with a layer that hardens in steady rolling or softens,
        where S is not found to be positive definite, with elements
        softened as far as a pressure covers them that is not exact enough to tell, and where it is
        left out.
        """
        return self.bounds.whole

    @property
    def proved(self) -> bool:
        """True where bounds on the errors of the tangential forces are known; without, the answer
        may be one of several, or near none.
        """
        return bool(np.all(np.isfinite(self.force_bound[:2])))

    def _repr_html_(self) -> str:
        measures = ("gap", "relative_gap", "residual", "normal_residual", "tangential_residual")
        rows = [(name.replace("_", " "), f"{getattr(self, name):.2e}") for name in measures]
        bound = ", ".join(
            f"{name} {size:.2e}"
            for name, size in zip(("Fx", "Fy", "Mz"), self.force_bound, strict=True)
        )
        if self.level == "full" and not self.proved:
            bound = "none: nothing is proved but the residual"
        return preformatted(in_rows("Certificate", [*rows, ("guaranteed bounds", bound)]))

    def without_moment(self) -> Certificate:
        """The certificate of tractions by a theory without a moment: NaN bounds it."""
        return replace(self, bounds=self._bounds_of_forces)

    def _bounds_of_forces(self) -> ForceBounds:
        """The bounds with NaN for the moment."""
        return ForceBounds(self.force_bound * [1.0, 1.0, np.nan], self.pressure_part)

    @property
    def pressure_part(self) -> np.ndarray:
        """Part of `force_bound` for the distance of the pressure from the exact one, shape (3,).

        Zero where the pressure is Hertz's closed form, which is what is asked for. NaN where it is
        not known: then `force_bound` is for the pressure as it is given, as with forces prescribed
        or infinite friction. In histories both are those of one step, for what the steps before
        left.
        """
        return self.bounds.pressure_part

    def plain(self) -> dict[str, float | str | list[float]]:
        """Record for files: numbers, the level, and the bounds as two lists of three, by name."""
        bounds = {
            "force_bound": self.force_bound.tolist(),
            "pressure_part": self.pressure_part.tolist(),
        }
        names = [each.name for each in fields(self) if each.name != "bounds"]
        return {name: getattr(self, name) for name in names} | bounds


def certificate_of(
    response: ContactResponse,
    closed_form: bool,
    level: str = "full",
    lazily: bool = False,
) -> Certificate:
    """The certificate of a contact state by its response; with a `closed_form`, Hertz's pressure is
    taken as given.

    Both problems are judged with the other's final tractions: the residual is that of the whole,
    without the normal one where the pressure is a closed form that is asked for. The `level` is one
    of `LEVELS`, or "auto"; `lazily` bounds on forces are left to when they are asked for.
    """
    state = response.state
    disc = response.under_implied_fields
    normal, pressure, approach = normal_as_solved(
        disc, state.pressure, state.approach, state.traction
    )
    tangential = None
    if not disc.frictionless:
        tangential = disc.tangential_problem(state.pressure, acting=state.traction)
    if level == "auto":
        level = _default_level(disc, tangential)
    # normal problem, under the final tractions
    if disc.subgrid is None:
        elastic = response.distance.ravel()
    else:
        elastic = normal.operator.apply(pressure[None])[0]
    normal_error = normal_residual(normal, pressure, approach, elastic)
    absolute = relative_gap = normal_relative = np.nan
    if level != "none":
        absolute, normal_relative = normal_gap(normal, pressure, approach, elastic)
        relative_gap = normal_relative
    # tangential problem, under the final pressure
    if tangential is None:
        tangential_error = float(np.any(state.traction))  # no friction can carry it: error in full
    else:
        found = _Judged.of(tangential, response)
        tangential_error = found.residual
    residual = worst(tangential_error, normal_error)
    if tangential is not None and tangential.size > 0:
        coupling_error = coupling_residual(
            disc, normal, tangential, state, approach, elastic, found.shift
        )
        residual = worst(residual, coupling_error)
        if closed_form:
            residual = tangential_error
        if level != "none":
            absolute, relative_gap = found.gap
    # bounds on the forces
    bounds: ForceBounds | Callable[[], ForceBounds] = NO_BOUNDS
    if level == "full":
        if lazily:
            bounds = partial(_force_bounds, disc.without_matrices(), state, closed_form)
        else:
            bounds = _force_bounds(disc, state, closed_form)
    return Certificate(
        gap=absolute * disc.scales.force * disc.scales.displacement,
        relative_gap=relative_gap,
        residual=residual,
        normal_relative_gap=normal_relative,
        normal_residual=normal_error,
        tangential_residual=tangential_error,
        level=level,
        bounds=bounds,
    )


@dataclass(frozen=True, eq=False)
class _Judged:
    """Tractions (c, n) of a tangential problem and the rigid shift (c,) that was found with them.

    `outside` is the largest traction where no friction can carry one; without any, the shift E (c,
    n) is that of the response.
    """

    problem: TangentialProblem
    traction: np.ndarray
    rigid: np.ndarray
    outside: float
    shift: np.ndarray | None

    @classmethod
    def of(cls, problem: TangentialProblem, response: ContactResponse) -> Self:
        """The tractions of a contact state."""
        state = response.state
        outside = outside_friction(problem, state)
        shift = None
        if outside == 0:
            shift, _ = problem.of_grid(response.shift, state.rigid)
        return cls(problem, *problem.of_grid(state.traction, state.rigid), outside, shift)

    @property
    def residual(self) -> float:
        """Residual of the tractions; those where no friction can carry them count in full."""
        if self.problem.size == 0:
            return self.outside
        inside = tangential_residual(self.problem, self.traction, self.rigid, self.shift)
        return worst(self.outside, inside)

    @property
    def gap(self) -> tuple[float, float]:
        """The duality gap of the tractions within the bound."""
        problem = self.problem
        if (magnitude(self.traction) <= (1 + ROUNDING) * problem.bound).all():
            return gap(problem, self.traction, self.rigid, self.shift)
        return gap(problem, project(self.traction, problem.bound), self.rigid)


def _default_level(disc: Discretisation, tangential: TangentialProblem | None) -> str:
    """Level that "auto" means: no bounds on forces for steps of a history and for very many
    elements.
    """
    if isinstance(disc.loading.motion, TimeStep):
        return "gap"
    if tangential is None or tangential.size <= FULL_LIMIT:
        return "full"
    return "gap"


@one_blas_thread()
def _force_bounds(disc: Discretisation, state: ContactState, closed_form: bool) -> ForceBounds:
    scales = disc.scales.force * np.array([1.0, 1.0, disc.scales.length])
    tangential = None
    elements = np.zeros(0, dtype=int)
    if not disc.frictionless:
        tangential = disc.tangential_problem(state.pressure, acting=state.traction)
        elements = tangential.operator.elements
    # tractions where no friction can carry them count as error in full
    px, py = np.delete(state.traction.reshape(2, -1), elements, axis=1)
    x, y = np.delete(disc.points.reshape(2, -1), elements, axis=1)
    totals = [px.sum(), py.sum(), (x * py - y * px).sum()]
    whole = disc.lattice.area * np.abs(totals)
    # tractions where friction can carry them
    for_pressure = np.zeros(3)
    if tangential is not None and tangential.size > 0:
        with_friction, for_pressure = _tangential_bounds(disc, tangential, state, closed_form)
        whole = whole + with_friction
    return ForceBounds(whole * scales, for_pressure * scales)


def _tangential_bounds(
    disc: Discretisation, tangential: TangentialProblem, state: ContactState, closed_form: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds on the errors of Fx, Fy and Mz where friction acts, and their part from the pressure,
    (3,) each.
    """
    undetermined = np.full(3, np.nan)
    # none where the pressure follows from the tractions, or fields of the interface from both
    if disc.K != 0 or disc.implicit:
        return _infinite(tangential), undetermined
    tractions, shifts = tangential.of_grid(state.traction, state.rigid)
    if closed_form:
        return force_bound(tangential, tractions, shifts), np.zeros(3)
    error = None
    if disc.coefficient is not None and not (tangential.no_slip or tangential.free):
        normal, pressure, approach = normal_as_solved(disc, state.pressure, state.approach)
        error = pressure_error(normal, pressure, float(approach[0]))
    if error is None:
        return force_bound(tangential, tractions, shifts), undetermined
    # error of the pressure, on all elements that may be in contact
    size, possible = error
    if disc.edge_compliance is not None and np.any(possible & (pressure <= size)):
        return _infinite(tangential), undetermined  # the compliance of elements is undetermined
    elements = means(1.0 * possible.reshape(disc.grid.divided(disc.cells).shape), disc.cells) > 0
    wider = disc.tangential_problem(state.pressure, acting=state.traction, possible=elements)
    of_means = size / math.sqrt(math.prod(disc.cells))
    part = pressure_part(wider, of_means * float(np.max(np.asarray(disc.coefficient))))
    return force_bound(wider, *wider.of_grid(state.traction, state.rigid)) + part, part


# ----------------------------------------------------------------------------- tractions


def force_bound(problem: TangentialProblem, traction: np.ndarray, rigid: np.ndarray) -> np.ndarray:
    """Guaranteed bounds on the errors of Fx, Fy, Mz for the problem's traction bound, shape (3,),
    dimensionless.

    Infinite where the symmetric part is not found to be positive definite. Tractions that are not
    admissible are first made so; what that changes is added.
    """
    outputs = outputs_of(problem)
    definite = problem.symmetric_part
    if definite is None:
        return _infinite(problem)
    # change of the forces where tractions are made admissible
    admissible = _admissible(problem, traction)
    error = np.abs(np.sum(outputs * (traction - admissible), axis=(1, 2)))
    error += ROUNDING * np.sum(np.abs(outputs) * magnitude(admissible), axis=(1, 2))
    # distance of the admissible tractions from the exact ones
    error += np.sqrt(definite.energies(outputs)) * _distance(problem, definite, admissible, rigid)
    return np.asarray(problem.area * error)


def outputs_of(problem: TangentialProblem) -> np.ndarray:
    """Weights of the traction components in Fx, Fy and Mz, (3, c, n), without the area of an
    element.
    """
    x, y = problem.points
    ones = np.ones(problem.size)
    zeros = np.zeros(problem.size)
    weights = np.array([[ones, zeros], [zeros, ones], [-y, x]])
    return weights[:, list(problem.directions)]


def _infinite(problem: TangentialProblem) -> np.ndarray:
    """Bounds (3,) that are infinite, except zero for outputs to which no traction contributes."""
    return np.where(outputs_of(problem).any(axis=(1, 2)), np.inf, 0.0)


def _admissible(problem: TangentialProblem, traction: np.ndarray) -> np.ndarray:
    """Tractions within the bound, on it where they nearly are, with the prescribed forces.

    The missing force goes to the elements below their bound, in proportion to the traction that
    they can still carry. Where that is not enough all tractions are reduced first: without any
    there is room for every force that friction can carry.
    """
    # onto the bound
    admissible = project(traction, problem.bound)
    if not problem.no_slip:
        size = magnitude(admissible)
        at_bound = (size > (1 - PUT_ON_BOUND_TOL) * problem.bound) & (size > 0)
        factor = problem.bound / np.where(at_bound, size, 1.0)
        admissible = admissible * np.where(at_bound, factor, 1.0)
    # missing force, as a sum of tractions
    force = np.array([F or 0.0 for F in problem.force]) / problem.area
    prescribed = np.isin(np.arange(problem.components), problem.free)
    missing = np.where(prescribed, force - admissible.sum(axis=1), 0.0)
    if np.linalg.norm(missing) <= ROUNDING * magnitude(admissible).sum():
        return admissible
    if problem.no_slip:
        return admissible + missing[:, None] / problem.size
    # room below the bound
    room = problem.bound - magnitude(admissible)
    excess = np.linalg.norm(missing) - room.sum()
    # room less missing force is a concave function of the part by which tractions are reduced
    if excess > 0:
        reduced = excess / (excess + problem.bound.sum() - np.linalg.norm(force))
        admissible = admissible * (1 - reduced)
        missing = np.where(prescribed, force - admissible.sum(axis=1), 0.0)
        room = problem.bound - magnitude(admissible)
    return admissible + missing[:, None] * room / room.sum()


def _distance(
    problem: TangentialProblem, definite: PositiveDefinite, traction: np.ndarray, rigid: np.ndarray
) -> float:
    """A bound on ``|p - p*|_S`` for admissible tractions.

    Where the shift is small beside an element's share of the gap, it is taken for a change of the
    rigid shift, of which the tractions then are the solution; what that changes is ``|E|`` in the
    norm of S^-1.
    """
    shift = problem.shift(traction, rigid)
    length = magnitude(shift)
    rounding = _rounding(problem.operator, traction, problem.rigid_shift + rigid[:, None])
    error = rounding / np.sqrt(definite.least)
    if problem.no_slip:
        return float(np.sqrt(definite.energies(shift[None])[0])) + error
    # share of each element in the gap, or its shift as a change of the rigid one
    shares = np.maximum(problem.potential.shares(traction, shift), 0.0)
    error += ROUNDING * np.sqrt(problem.bound @ length)
    small = length**2 < problem.operator.diagonal * shares
    if problem.potential.flow is not None:
        small &= magnitude(traction) <= problem.potential.flow.threshold
    changed = definite.energies(np.where(small, shift, 0.0)[None])[0]
    by_gap = np.sqrt(shares.sum())
    by_change = np.sqrt(shares[~small].sum()) + np.sqrt(changed)
    return float(min(by_gap, by_change) + error)


def _rounding(operator: RestrictedOperator, field: np.ndarray, constant: np.ndarray) -> float:
    """A bound on the 2-norm of the rounding in ``constant + M field``, by FFT or by the matrix
    (Higham 2002).
    """
    unrestricted = operator.grid_operator
    softening = 0.0
    if operator.softening is not None:
        softening = float(operator.softening.max())
    if unrestricted.whole is None:
        doublings = np.log2(unrestricted.table[0, 0].size)
        product = FFT_ROUNDING * doublings * (norm(unrestricted) + softening)
    else:  # sums of so many products, in any order
        size = float(np.linalg.norm(unrestricted.whole)) + softening
        product = unrestricted.whole.shape[1] * size
    return float(EPS * (product * np.linalg.norm(field) + 3 * np.linalg.norm(constant)))


# ------------------------------------------------------------------------- the pressure's own error


def pressure_error(
    problem: NormalProblem, pressure: np.ndarray, approach: float
) -> tuple[float, np.ndarray] | None:
    """A bound on ``|p - p*|`` (2-norm) of a pressure (n,), and the elements where it or the exact
    one may be positive.

    None where A is not symmetric, or rounding hides that it is definite.
    Where the pressure is small beside the distance, ``p e`` is that element's share of the gap;
    elsewhere the distance is taken for a change of the undeformed one, of which the pressure then
    is the solution.
    """
    if not problem.symmetric:
        return None
    definite = positive_definite(problem.operator, dense_limit=0)
    if definite is None:
        return None
    apply = problem.operator.apply
    # an admissible pressure
    admissible = np.maximum(pressure, 0.0)
    if problem.force is not None:
        admissible = admissible * (problem.force / problem.area / admissible.sum())
    else:
        assert problem.approach is not None
        approach = problem.approach
    elastic = apply(admissible[None])[0]
    distance = problem.distance - approach + elastic
    # its distance from the exact one in the norm of A: gap, changed distance, rounding
    apart = admissible * problem.operator.diagonal <= distance
    energy = float(admissible[apart] @ distance[apart])
    changed = float(definite.energies(np.where(apart, 0.0, distance)[None, None])[0])
    rounding = _rounding(problem.operator, admissible[None], problem.distance - approach)
    error = rounding / np.sqrt(definite.least)
    inner = float(np.sqrt(energy) + np.sqrt(changed) + error)
    # elements that may be in contact
    reach = inner * np.sqrt(problem.operator.grid_operator.largest)
    if problem.force is not None:  # the exact approach may be larger, and more elements in contact
        stored = np.sqrt(max(float(admissible @ elastic), 0.0))
        reach += max(float(admissible @ distance) + stored * inner, 0.0) / admissible.sum()
    possible = (pressure > 0) | (distance <= reach)
    # with the change to an admissible pressure
    change = pressure - admissible
    outer = inner + np.sqrt(max(float(change @ apply(change[None])[0]), 0.0))
    return float(outer / np.sqrt(definite.least)), possible


def pressure_part(problem: TangentialProblem, spread: float) -> np.ndarray:
    """Largest changes of Fx, Fy, Mz under a change of the traction bound by `spread` (2-norm),
    (3,), dimensionless.

    The creepages are given, and the problem has all elements that may come into contact.
    """
    outputs = outputs_of(problem)
    definite = problem.symmetric_part
    if definite is None:
        return _infinite(problem)
    table = problem.operator.grid_operator
    asymmetric = norm(table.symmetric_part(-1.0)) / np.sqrt(definite.least)
    stretch = np.sqrt(norm(table.symmetric_part())) + asymmetric
    lengths = np.sqrt(np.sum(outputs**2, axis=(1, 2)))
    factors = lengths + np.sqrt(definite.energies(outputs)) * stretch
    return np.asarray(problem.area * spread * factors)
