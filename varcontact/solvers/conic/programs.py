"""Contact problems as convex programs: plain data that any conic solver can take.

``minimise 1/2 x'P x + q'x  subject to  A x + s = b, s in K``, K a product of cones. Every program
is scaled: tractions by the bound of their own element, so that friction disks are unit disks, and
shifts by the largest rigid shift. Tractions and shifts have c components, one or two; of one, a
disk is an interval.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.elasticity.operators import RestrictedOperator
from varcontact.system.process import lazy_property


@dataclass(frozen=True, eq=False)
class ConicProgram:
    """A convex program as plain data; P, the upper triangle, and A are sparse, by columns.

    Cones are ``("zero", m)``, ``("nonnegative", m)`` and ``("second_order", 1 + c)``, in this
    order, which is that of the rows; a second-order cone is ``s[0] >= |s[1:]|``. `recover` takes
    variables and multipliers (x, z), ``P x + q + A'z = 0``, to the problem's (traction, rigid).
    `variables` and `rows` have the places of their blocks by name; `energy` is that of an objective
    of 1.
    """

    P: Any
    q: np.ndarray
    A: Any
    b: np.ndarray
    cones: list[tuple[str, int]]
    recover: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
    variables: dict[str, slice] = field(default_factory=dict)
    rows: dict[str, slice] = field(default_factory=dict)
    energy: float = 1.0

    @property
    def kinds(self) -> np.ndarray:
        return np.repeat([kind for kind, _ in self.cones], [size for _, size in self.cones])

    def polyhedral(self) -> ConicProgram:
        """Program with ``r - s >= 0, r + s >= 0`` in place of second-order cones (r, s) of one
        component.

        Those of two stay as they are: without them it is a quadratic program.
        """
        from scipy.sparse import diags

        paired = [cone == ("second_order", 2) for cone in self.cones]
        radii = (np.cumsum([size for _, size in self.cones]) - 2)[paired]
        if radii.size == 0:
            return self
        below = np.zeros(self.b.size - 1)
        below[radii] = 1.0
        turn = diags([below, np.ones(self.b.size), -below], [-1, 0, 1], format="csr")
        cones = [("nonnegative", 2) if cone == ("second_order", 2) else cone for cone in self.cones]
        return replace(
            self,
            A=(turn @ self.A).tocsc(),
            b=turn @ self.b,
            cones=cones,
            recover=lambda x, z: self.recover(x, turn.T @ z),
        )


@dataclass(eq=False)
class _Parts:
    """A program as it grows: rows with their limits and cones, diagonals and costs of variables."""

    costs: list[np.ndarray] = field(default_factory=list)
    squares: list[np.ndarray] = field(default_factory=list)
    rows: dict[str, dict[str, Any]] = field(default_factory=dict)
    limits: list[np.ndarray] = field(default_factory=list)
    cones: list[tuple[str, int]] = field(default_factory=list)

    COLUMNS = ("traction", "shift_size", "rigid", "excess", "flow_size", "flow")

    def add(
        self, name: str, cones: list[tuple[str, int]], limits: np.ndarray, **blocks: Any
    ) -> None:
        """Rows under a name, from their blocks by the names of `COLUMNS`."""
        self.rows[name] = blocks
        self.limits.append(limits)
        self.cones += cones

    @property
    def columns(self) -> list[str]:
        return [name for name in self.COLUMNS if any(name in row for row in self.rows.values())]

    def matrix(self) -> Any:
        from scipy.sparse import bmat

        blocks = [[row.get(name) for name in self.columns] for row in self.rows.values()]
        return bmat(blocks, format="csc")

    @property
    def places(self) -> tuple[dict[str, slice], dict[str, slice]]:
        """Places of the variables, and of the rows, by name."""
        widths = {name: block.shape[1] for row in self.rows.values() for name, block in row.items()}
        variables = _in_turn({name: widths[name] for name in self.columns})
        heights = {name: limits.size for name, limits in zip(self.rows, self.limits, strict=True)}
        return variables, _in_turn(heights)


def _in_turn(sizes: dict[str, int]) -> dict[str, slice]:
    """Places of blocks of some sizes that follow each other."""
    ends = np.cumsum(list(sizes.values())).tolist()
    return {
        name: slice(end - size, end) for (name, size), end in zip(sizes.items(), ends, strict=True)
    }


def normal_program(
    problem: NormalProblem, of_traction: bool = True, of_shift: bool = False
) -> ConicProgram:
    """The normal problem as a QP, by pressures, by distances or by both.

    Of tractions: ``min 1/2 p'A p + (h - d)'p, p >= 0``, (215) with its sign changed. With the force
    prescribed d is dropped, ``sum(p)`` is an equality, and its multiplier the approach. Of the
    shift, the potential energy (214): ``min 1/2 w'A^-1 w, h - d + w >= 0`` over displacements ``w =
    A p``; the pressures are the multipliers, and a prescribed force works against the approach d.
    Of both, also where A is not symmetric: ``min p'(h + A p - d)``, with both conditions, 0 at its
    end.
    """
    n = problem.distance.size
    level, displacement = _distance_units(problem)
    diagonal = problem.operator.diagonal
    pressure = displacement / diagonal
    matrix = problem.operator.matrix / diagonal
    distance = (problem.distance - level) / displacement
    load = np.array([])
    if problem.force is not None:
        load = np.array([problem.force / (problem.area * pressure)])
    parts = _normal_conditions(distance, matrix, load, of_traction, of_shift)
    unknown_approaches = load.size if of_shift else 0
    cost = distance * (1.0 if of_traction else 0.0)
    quadratic = matrix
    if of_traction and of_shift:
        quadratic = matrix + matrix.T

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        approach = level
        if unknown_approaches:
            approach += x[n] * displacement
        elif load.size:
            approach += -z[0] * displacement / n
        pressures = np.maximum(x[:n] if of_traction else z, 0.0) * pressure
        return pressures, np.array([approach], dtype=float)

    variables, rows = parts.places
    return ConicProgram(
        P=_quadratic(quadratic, np.zeros(unknown_approaches)),
        q=np.concatenate([cost, -load[:unknown_approaches]]),
        A=parts.matrix(),
        b=np.concatenate(parts.limits),
        cones=parts.cones,
        recover=recover,
        variables=variables,
        rows=rows,
        energy=problem.area * pressure * displacement,
    )


def _normal_conditions(
    distance: np.ndarray, matrix: np.ndarray, load: np.ndarray, of_traction: bool, of_shift: bool
) -> _Parts:
    """Rows of the normal program, by pressures and the unknown approach."""
    from scipy.sparse import csc_matrix, identity

    n = distance.size
    parts = _Parts()
    if of_traction and load.size:
        mean = csc_matrix(np.ones((1, n)) / n)
        parts.add("force", [("zero", 1)], load / n, traction=mean)
    if of_shift and load.size:
        approach = csc_matrix(np.ones((n, 1)))
        parts.add("distance", [], distance, traction=csc_matrix(-matrix), rigid=approach)
    elif of_shift:
        parts.add("distance", [], distance, traction=csc_matrix(-matrix))
    if of_traction:
        parts.add("pressure", [], np.zeros(n), traction=-identity(n))
    inequalities = sum(limits.size for limits in parts.limits) - len(parts.cones)
    parts.cones.append(("nonnegative", inequalities))
    return parts


def linear_operator(problem: NormalProblem | TangentialProblem) -> Any:
    """M in the units of the programs, shifts by tractions, as a SciPy `LinearOperator` without a
    matrix.
    """
    from scipy.sparse.linalg import LinearOperator

    operator = problem.operator
    symmetric = replace(operator, grid_operator=operator.grid_operator.symmetric_part())
    if isinstance(problem, NormalProblem):
        shape = (1, problem.distance.size)
        own = np.ones(shape)
        unit = operator.diagonal
    else:
        scaled = _ScaledTangential.of(problem)
        shape = problem.rigid_shift.shape
        own = np.broadcast_to(problem.bound, shape)
        unit = scaled.shift

    def product(x: np.ndarray) -> np.ndarray:
        return (operator.apply(own * x.reshape(shape)) / unit).ravel()

    def transposed(x: np.ndarray) -> np.ndarray:
        field = x.reshape(shape)
        return (own * _transposed(operator, symmetric, field) / unit).ravel()

    size = math.prod(shape)
    return LinearOperator((size, size), matvec=product, rmatvec=transposed, dtype=float)


def _transposed(
    operator: RestrictedOperator, symmetric: RestrictedOperator, field: np.ndarray
) -> np.ndarray:
    """Product with M', by M and its symmetric part."""
    return 2 * symmetric.apply(field) - operator.apply(field)


def _distance_units(problem: NormalProblem) -> tuple[float, float]:
    """Distance from which others are measured (the approach, if known), and the unit of
    distances.
    """
    lowest = float(problem.distance.min())
    if problem.force is None:
        assert problem.approach is not None
        return problem.approach, problem.approach - lowest
    largest_sum = float(np.abs(problem.operator.matrix).sum(axis=0).max())
    return lowest, largest_sum * problem.force / (problem.area * problem.distance.size)


def tangential_program(
    problem: TangentialProblem, of_traction: bool, of_shift: bool
) -> ConicProgram:
    """The tangential problem by tractions (complementary energy), by shifts (potential energy) or
    by both (the gap).

    Of the tractions of a shift: ``min 1/2 p'A p + W'p, |p_i| <= g_i``, (215) with its sign changed.
    A prescribed force is an equality, its multiplier the unknown part of the shift. Of shifts
    (214): ``min 1/2 u'A^-1 u + sum(g_i |W + u|_i)`` over displacements ``u = A p``; p, which
    nothing bounds, turns out to be the tractions, and a prescribed force works against the unknown
    part of the shift. Of both, also in steady rolling: ``gap(p) = p'E + sum(g_i |E_i|)`` with ``E =
    W + M p`` is never negative for admissible p and zero exactly at the solution; with ``t_i >=
    |E_i|`` it is ``p'S p + W'p + g't``, S the symmetric part of M, which is positive definite.

    A flow within the bound costs ``s^2/(2 k)`` of the traction, with ``s + threshold >= |p|``. Of
    the shift its part e comes off, which costs ``threshold t + k t^2/2`` with ``t >= |e|``: the
    least of that and ``g |E - e|`` is the conjugate.
    """
    scaled = _ScaledTangential.of(problem)
    n = problem.size
    flow = None if problem.potential.flow is None else _ScaledFlow.of(problem, scaled)
    # variables: tractions, sizes of shifts, unknown rigid shifts; of a flow see there
    parts = _Parts(costs=[scaled.known * scaled.weight * (1.0 if of_traction else 0.0)])
    if of_traction:
        _add_forces(parts, scaled)
    if of_shift:
        parts.squares.append(np.zeros(n + len(problem.free)))
        parts.costs.append(scaled.weight[:n])
        parts.costs.append(scaled.forces * (scaled.carried / scaled.most))
        _add_shift_cones(parts, scaled, flow)
    if of_traction:
        _add_friction_disks(parts, scaled)
    if flow is not None and of_traction:
        flow.add_to_traction(parts)
    if flow is not None and of_shift:
        flow.add_to_shift(parts)
    quadratic = scaled.weight[:, None] * scaled.matrix
    if of_traction and of_shift:
        quadratic += quadratic.T
    variables, rows = parts.places
    return ConicProgram(
        P=_quadratic(quadratic, *parts.squares),
        q=np.concatenate(parts.costs),
        A=parts.matrix(),
        b=np.concatenate(parts.limits),
        cones=parts.cones,
        recover=_tangential_answer(scaled, variables, rows),
        variables=variables,
        rows=rows,
        energy=problem.area * scaled.most * scaled.shift,
    )


@dataclass(frozen=True, eq=False)
class _ScaledTangential:
    """A tangential problem in the units of its program.

    Tractions are divided by their own bound: `weight` (c n,) is the bound by the largest; `known`
    is the rigid shift, `forces` the prescribed sums.
    """

    shape: tuple[int, int]  # elements and components, (n, c)
    free: list[int]
    share: np.ndarray  # of the force that friction can carry, by element
    most: float  # largest bound
    carried: float  # sum of the bounds
    shift: float  # unit of shifts
    weight: np.ndarray
    known: np.ndarray
    forces: np.ndarray
    problem: TangentialProblem

    @classmethod
    def of(cls, problem: TangentialProblem) -> _ScaledTangential:
        bound = np.tile(problem.bound, problem.components)
        carried = problem.bound.sum()
        shift = float(np.abs(problem.rigid_shift).max())
        # part of the shift is unknown: no less than the elastic one by full tractions
        if problem.free or shift == 0:
            elastic = problem.operator.apply(bound.reshape(problem.components, -1))
            shift = max(shift, float(np.abs(elastic).max()))
        shift = float(4.0 ** np.round(np.log(shift) / np.log(4)))
        forces = np.array([F for F in problem.force if F is not None])
        return cls(
            shape=(problem.size, problem.components),
            free=problem.free,
            share=problem.bound / carried,
            most=bound.max(),
            carried=carried,
            shift=shift,
            weight=bound / bound.max(),
            known=problem.rigid_shift.ravel() / shift,
            forces=forces / (problem.area * carried),
            problem=problem,
        )

    @lazy_property
    def matrix(self) -> np.ndarray:
        """Shifts by tractions."""
        bound = np.tile(self.problem.bound, self.problem.components)
        return self.problem.operator.matrix * (bound / self.shift)


def _tangential_answer(
    scaled: _ScaledTangential, variables: dict[str, slice], rows: dict[str, slice]
) -> Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """Function of variables and multipliers to tractions (c, n) and the unknown shift (c,)."""
    n, c = scaled.shape
    multiplier_unit = scaled.shift * scaled.most / scaled.carried

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        shifts = np.zeros(c)
        if "rigid" in variables:
            shifts[scaled.free] = x[variables["rigid"]] * scaled.shift
        elif "force" in rows:
            shifts[scaled.free] = z[rows["force"]] * multiplier_unit
        return x[: c * n].reshape(c, n) * scaled.problem.bound, shifts

    return recover


def _add_shift_cones(parts: _Parts, scaled: _ScaledTangential, flow: _ScaledFlow | None) -> None:
    """Add cones: the sizes of shifts are at least those of the shifts without flow."""
    from scipy.sparse import csc_matrix

    n, c = scaled.shape
    radii, vectors = _in_cones(n, c)
    blocks = {"traction": csc_matrix(-(vectors @ scaled.matrix)), "shift_size": -radii}
    if scaled.free:
        uniform = np.kron(np.eye(c)[:, scaled.free], -np.ones((n, 1)))
        blocks["rigid"] = csc_matrix(vectors @ uniform)
    if flow is not None:
        blocks["flow"] = vectors @ flow.flowing.T
    parts.add("shift", [("second_order", 1 + c)] * n, vectors @ scaled.known, **blocks)


def _add_forces(parts: _Parts, scaled: _ScaledTangential) -> None:
    """Add the prescribed sums of tractions, if there are any."""
    from scipy.sparse import csc_matrix

    _, c = scaled.shape
    if not scaled.free:
        return
    sums = csc_matrix(np.kron(np.eye(c)[scaled.free], scaled.share))
    parts.add("force", [("zero", len(scaled.free))], scaled.forces, traction=sums)


def _add_friction_disks(parts: _Parts, scaled: _ScaledTangential) -> None:
    """Add the friction disks: tractions are within their bound."""
    n, c = scaled.shape
    radii, vectors = _in_cones(n, c)
    cones = [("second_order", 1 + c)] * n
    parts.add("bound", cones, radii @ np.ones(n), traction=-vectors)


@dataclass(frozen=True, eq=False)
class _ScaledFlow:
    """A flow within the bound, in the units of a program, on the elements that it can reach."""

    components: int
    threshold: np.ndarray
    bound: np.ndarray
    hardening: float
    most: float  # units of tractions and of shifts
    shift: float
    flowing: Any  # matrix that picks the components of these elements, (c m, c n)

    @classmethod
    def of(cls, problem: TangentialProblem, scaled: _ScaledTangential) -> _ScaledFlow:
        from scipy.sparse import identity

        flow = problem.potential.flow
        assert flow is not None
        n, c = scaled.shape
        y = np.flatnonzero(flow.threshold < problem.bound)
        picked = (n * np.arange(c)[:, None] + y).ravel()
        return cls(
            components=c,
            threshold=flow.threshold[y],
            bound=problem.bound[y],
            hardening=flow.hardening,
            most=scaled.most,
            shift=scaled.shift,
            flowing=identity(c * n, format="csr")[picked],
        )

    def add_to_traction(self, parts: _Parts) -> None:
        """Add the cost of tractions beyond the threshold: the square of their excess."""
        m = self.bound.size
        radii, vectors = _in_cones(m, self.components)
        parts.squares.append(self.bound**2 / (self.hardening * self.shift * self.most))
        parts.costs.append(np.zeros(m))
        parts.add(
            "excess",
            [("second_order", 1 + self.components)] * m,
            radii @ (self.threshold / self.bound),
            traction=-(vectors @ self.flowing),
            excess=-radii,
        )

    def add_to_shift(self, parts: _Parts) -> None:
        """Add the cost of shifts that flow: the threshold and, with hardening, their square."""
        m = self.bound.size
        c = self.components
        radii, vectors = _in_cones(m, c)
        parts.squares.append(np.full(m, self.hardening * self.shift / self.most))
        parts.squares.append(np.zeros(c * m))
        parts.costs.append(self.threshold / self.most)
        parts.costs.append(np.zeros(c * m))
        parts.add(
            "flow",
            [("second_order", 1 + c)] * m,
            np.zeros((1 + c) * m),
            flow_size=-radii,
            flow=-vectors,
        )


def _quadratic(matrix: np.ndarray, *diagonals: np.ndarray) -> Any:
    """Upper triangle of a symmetric dense matrix, then diagonals."""
    from scipy.sparse import block_diag, diags

    return block_diag([np.triu(matrix), diags(np.concatenate(diagonals or [[]]))], format="csc")


def _in_cones(n: int, c: int) -> tuple[Any, Any]:
    """Matrices that place radii (n) and vectors (c n, all x first) in the rows of n cones (radius,
    x, y).
    """
    from scipy.sparse import hstack, identity, kron

    radii, *vectors = (kron(identity(n), part[:, None], format="csr") for part in np.eye(1 + c))
    return radii, hstack(vectors, format="csr")
