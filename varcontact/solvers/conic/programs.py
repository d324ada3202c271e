"""Contact problems as convex programs: plain data that any conic solver can take.

``minimise 1/2 x'P x + q'x  subject to  A x + s = b, s in K``, K a product of cones. Every program
is scaled: tractions by the bound of their own element, so that friction disks are unit disks, and
shifts by the largest rigid shift. Tractions and shifts have c components, one or two; of one, a
disk is an interval.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.discrete.problems import NormalProblem, TangentialProblem


@dataclass(frozen=True, eq=False)
class ConicProgram:
    """A convex program as plain data; P, the upper triangle, and A are sparse, by columns.

    Cones are ``("zero", m)``, ``("nonnegative", m)`` and ``("second_order", 1 + c)``, in the order
    of the rows; a second-order cone is ``s[0] >= |s[1:]|``. `recover` takes variables and
    multipliers (x, z), ``P x + q + A'z = 0``, to the problem's (traction, rigid).
    """

    P: Any
    q: np.ndarray
    A: Any
    b: np.ndarray
    cones: list[tuple[str, int]]
    recover: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]

    @property
    def kinds(self) -> np.ndarray:
        return np.repeat([kind for kind, _ in self.cones], [size for _, size in self.cones])

    def polyhedral(self) -> ConicProgram:
        """The same program with ``r - s >= 0, r + s >= 0`` for second-order cones (r, s) of one
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
        A = (turn @ self.A).tocsc()
        return ConicProgram(
            self.P, self.q, A, turn @ self.b, cones, lambda x, z: self.recover(x, turn.T @ z)
        )


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
    from scipy.sparse import bmat, csc_matrix, identity

    n, force = problem.distance.size, problem.force
    level, diagonal = float(problem.distance.min()), problem.operator.diagonal
    if force is None:  # distances count from the approach where it is known
        assert problem.approach is not None
        level, displacement = problem.approach, problem.approach - level
    else:
        displacement = (
            float(np.abs(problem.operator.matrix).sum(axis=0).max()) * force / (problem.area * n)
        )
    pressure, matrix = displacement / diagonal, problem.operator.matrix / diagonal
    distance = (problem.distance - level) / displacement
    load = np.array([] if force is None else [force / (problem.area * pressure)])
    ones = np.ones((load.size, n))
    rows: list[list[Any]] = []
    limits: list[np.ndarray] = []
    cones = []
    if of_traction and load.size:
        rows, limits, cones = [[csc_matrix(ones / n), None]], [load / n], [("zero", 1)]
    if of_shift:
        rows, limits = [*rows, [csc_matrix(-matrix), csc_matrix(ones.T)]], [*limits, distance]
    if of_traction:
        rows, limits = [*rows, [-identity(n), None]], [*limits, np.zeros(n)]
    free = load.size * of_shift

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        approach = level
        if load.size:
            approach += x[n] * displacement if of_shift else -z[0] * displacement / n
        return np.maximum(x[:n] if of_traction else z, 0.0) * pressure, np.array(
            [approach], dtype=float
        )

    return ConicProgram(
        P=_quadratic(matrix + matrix.T if of_traction and of_shift else matrix, np.zeros(free)),
        q=np.concatenate([distance * of_traction, -load[:free]]),
        A=bmat([row[: 1 + free] for row in rows], format="csc"),
        b=np.concatenate(limits),
        cones=[*cones, ("nonnegative", n * (of_traction + of_shift))],
        recover=recover,
    )


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
    from scipy.sparse import bmat, csc_matrix, identity

    n, c, free = problem.size, problem.components, problem.free
    bound, height = np.tile(problem.bound, c), (1 + c) * n
    most, carried, scale = (
        bound.max(),
        problem.bound.sum(),
        float(np.abs(problem.rigid_shift).max()),
    )
    # part of the shift is unknown: no less than the elastic one by full tractions
    if free or scale == 0:
        scale = max(scale, float(np.abs(problem.operator.matrix @ bound).max()))
    scale = float(4.0 ** np.round(np.log(scale) / np.log(4)))
    weight, matrix = bound / most, problem.operator.matrix * (bound / scale)
    quadratic = weight[:, None] * matrix
    if of_traction and of_shift:
        quadratic += quadratic.T
    known = problem.rigid_shift.ravel() / scale
    forces = np.array([F for F in problem.force if F is not None]) / (problem.area * carried)
    radii, vectors = _in_cones(n, c)
    squares, costs = [], [known * weight * of_traction]
    rows: list[list[Any]] = []  # by tractions, t, rigid shifts, s, t and e
    limits: list[np.ndarray] = []
    cones = [("second_order", 1 + c)] * (n * (of_traction + of_shift))
    if of_shift:
        moved = (
            csc_matrix(vectors @ np.kron(np.eye(c)[:, free], -np.ones((n, 1)))) if free else None
        )
        rows, limits = (
            [[csc_matrix(-(vectors @ matrix)), -radii, moved, None, None, None]],
            [vectors @ known],
        )
        squares, costs = [np.zeros(n + len(free))], [*costs, weight[:n], forces * (carried / most)]
    if of_traction:
        rows, limits = [*rows, [-vectors] + [None] * 5], [*limits, radii @ np.ones(n)]
        if free:
            sums = csc_matrix(np.kron(np.eye(c)[free], problem.bound / carried))
            rows, limits, cones = (
                [*rows, [sums] + [None] * 5],
                [*limits, forces],
                [*cones, ("zero", len(free))],
            )
    flow = problem.potential.flow
    if flow is not None:
        k = flow.hardening
        y = np.flatnonzero(flow.threshold < problem.bound)
        m, threshold, own = y.size, flow.threshold[y], problem.bound[y]
        flowing = identity(c * n, format="csr")[(n * np.arange(c)[:, None] + y).ravel()]
        own_radii, own_vectors = _in_cones(m, c)
        cones += [("second_order", 1 + c)] * (m * (of_traction + of_shift))
        if of_traction:
            rows.append([-(own_vectors @ flowing), None, None, -own_radii, None, None])
            squares, costs = [*squares, own**2 / (k * scale * most)], [*costs, np.zeros(m)]
            limits.append(own_radii @ (threshold / own))
        if of_shift:
            rows[0][5] = vectors @ flowing.T
            rows.append([None, None, None, None, -own_radii, -own_vectors])
            squares, costs = (
                [*squares, np.full(m, k * scale / most), np.zeros(c * m)],
                [*costs, threshold / most],
            )
            costs, limits = [*costs, np.zeros(c * m)], [*limits, np.zeros((1 + c) * m)]
    A = bmat(
        [[row[j] for j in range(6) if any(r[j] is not None for r in rows)] for row in rows],
        format="csc",
    )
    # Clarabel orders its linear systems by minimum degree, and leaves to the last, as dense, the
    # rows with more than
    # 15 sqrt(size) entries. Up to 500 elements that holds for the tractions (2 c n entries) but not
    # for the shifts
    # (c n), and the order it then finds takes two to four times as long as with no row called
    # dense. Spare variables,
    # alone in the objective as x^2, enlarge the size and cost nothing.
    size, spare = 3 * (1 + c) * n, 0
    if of_traction and of_shift and c * n + 2 < 15 * np.sqrt(size):
        spare = max(int(((2 * c * n + 16) / 15) ** 2) - size, 0)
    A.resize(A.shape[0], A.shape[1] + spare)

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        shifts, places = np.zeros(c), slice(height, height + len(free))
        shifts[free] = x[places] * scale if of_shift else z[places] * (scale * most / carried)
        return x[: c * n].reshape(c, n) * problem.bound, shifts

    return ConicProgram(
        P=_quadratic(quadratic, *squares, np.ones(spare)),
        q=np.concatenate([*costs, np.zeros(spare)]),
        A=A,
        b=np.concatenate(limits),
        cones=cones,
        recover=recover,
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
