"""Contact problems as convex programs: plain data that any conic solver can take.

``minimise 1/2 x'P x + q'x  subject to  A x + s = b, s in K``, K a product of cones. Every program is scaled:
tractions by the bound of their own element, so that friction disks are unit disks, and shifts by the largest
rigid shift. Tractions and shifts have c components, one or two; of one, a disk is an interval.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from varcontact.discrete.problems import NormalProblem, TangentialProblem

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


@dataclass(frozen=True, eq=False)
class ConicProgram:
    """A convex program as plain data; P is the upper triangle.

    Cones are ``("zero", m)``, ``("nonnegative", m)`` and ``("second_order", 1 + c)``, in the order of the rows; a
    second-order cone is ``s[0] >= |s[1:]|``. `recover` takes variables and multipliers (x, z), ``P x + q + A'z = 0``,
    to the problem's (traction, rigid).
    """

    P: csc_matrix
    q: np.ndarray
    A: csc_matrix
    b: np.ndarray
    cones: list[tuple[str, int]]
    recover: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]

    @property
    def kinds(self) -> np.ndarray:
        return np.repeat([kind for kind, _ in self.cones], [size for _, size in self.cones])

    def polyhedral(self) -> ConicProgram:
        """The same program with ``r - s >= 0, r + s >= 0`` for second-order cones (r, s) of one component.

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
        return ConicProgram(self.P, self.q, A, turn @ self.b, cones, lambda x, z: self.recover(x, turn.T @ z))


def normal_program(problem: NormalProblem) -> ConicProgram:
    """The normal problem as a QP: ``min 1/2 p'A p + (h - d)'p, p >= 0``, (215) with its sign changed.

    With the force prescribed d is dropped, ``sum(p)`` is an equality, and its multiplier the approach.
    """
    from scipy.sparse import csc_matrix

    n, force = problem.distance.size, problem.force
    level, displacement = normal_scales(problem)
    distance, pressure = problem.distance - level, displacement / problem.operator.diagonal
    P = _upper(problem.operator.matrix * (pressure / displacement))
    ones = -np.ones(n)
    if force is None:
        A, b, cones = csc_matrix((ones, np.arange(n), np.arange(n + 1))), np.zeros(n), [("nonnegative", n)]
    else:
        data = np.stack([np.full(n, 1 / n), ones], axis=1).ravel()
        rows = np.stack([np.zeros(n, dtype=int), 1 + np.arange(n)], axis=1).ravel()
        A = csc_matrix((data, rows, 2 * np.arange(n + 1)))
        b = np.concatenate([[force / (problem.area * pressure * n)], np.zeros(n)])
        cones = [("zero", 1), ("nonnegative", n)]

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        approach = level if force is None else level - z[0] * displacement / n
        return np.maximum(x, 0.0) * pressure, np.array([approach], dtype=float)

    return ConicProgram(P, distance / displacement, A, b, cones, recover)


def monotone_program(problem: NormalProblem) -> ConicProgram:
    """The normal problem where A is not symmetric: ``min p'(h + A p - d), p >= 0, h + A p - d >= 0``, 0 at its end.

    With the force prescribed d is a variable, and ``sum(p)`` an equality.
    """
    from scipy.sparse import csc_matrix, vstack

    n, force = problem.distance.size, problem.force
    level, displacement = normal_scales(problem)
    distance, pressure = (problem.distance - level) / displacement, displacement / problem.operator.diagonal
    matrix = problem.operator.matrix * (pressure / displacement)
    free = 0 if force is None else 1
    P = _upper(matrix + matrix.T, empty=free)
    load = np.zeros(0) if force is None else np.array([force / (problem.area * pressure)])
    apart = csc_matrix(np.concatenate([-matrix, np.ones((n, free))], axis=1))
    pushes = csc_matrix((-np.ones(n), (np.arange(n), np.arange(n))), shape=(n, n + free))
    whole = csc_matrix(np.concatenate([np.full((free, n), 1 / n), np.zeros((free, free))], axis=1))

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        approach = level if force is None else level + x[n] * displacement
        return np.maximum(x[:n], 0.0) * pressure, np.array([approach], dtype=float)

    return ConicProgram(
        P=P,
        q=np.concatenate([distance, -load]),
        A=vstack([whole, apart, pushes], format="csc"),
        b=np.concatenate([load / n, distance, np.zeros(n)]),
        cones=[("zero", free)] * free + [("nonnegative", 2 * n)],
        recover=recover,
    )


def normal_potential(problem: NormalProblem) -> ConicProgram:
    """The normal problem by its potential energy (214): ``min 1/2 w'A^-1 w, h - d + w >= 0`` over displacements w.

    They are written ``w = A p``; the pressures are the multipliers. A prescribed force works against the approach d.
    """
    from scipy.sparse import csc_matrix

    n, force = problem.distance.size, problem.force
    level, displacement = normal_scales(problem)
    pressure = displacement / problem.operator.diagonal
    matrix = problem.operator.matrix / problem.operator.diagonal
    if force is None:
        P, q, A = _upper(matrix), np.zeros(n), csc_matrix(-matrix)
    else:
        P, q = _upper(matrix, empty=1), np.append(np.zeros(n), -force / (problem.area * pressure))
        A = csc_matrix(np.concatenate([-matrix, np.ones((n, 1))], axis=1))

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        approach = level if force is None else level + x[n] * displacement
        return np.maximum(z, 0.0) * pressure, np.array([approach], dtype=float)

    return ConicProgram(P, q, A, (problem.distance - level) / displacement, [("nonnegative", n)], recover)


def normal_scales(problem: NormalProblem) -> tuple[float, float]:
    """The level from which distances count (the approach where it is known), and the scale of displacements."""
    least = float(problem.distance.min())
    if problem.force is None:
        assert problem.approach is not None
        return problem.approach, problem.approach - least
    mean = problem.force / (problem.area * problem.distance.size)
    return least, float(np.abs(problem.operator.matrix).sum(axis=0).max()) * mean


def shift_program(problem: TangentialProblem) -> ConicProgram:
    """A shift as a second-order-cone program: ``min 1/2 p'A p + W'p, |p_i| <= g_i``, (215) with its sign changed.

    A prescribed force is an equality, its multiplier the unknown part of the shift.
    """
    from scipy.sparse import csc_matrix

    n, c, free = problem.size, problem.components, problem.free
    bound, height = np.tile(problem.bound, c), (1 + c) * n
    scale, weight = shift_scale(problem), bound / bound.max()
    P = _upper(weight[:, None] * (problem.operator.matrix * (bound / scale)))
    rows, entries = _columns(_cone_rows(n, c), -np.ones(c * n), height, problem)
    starts = np.arange(c * n + 1) * entries.shape[1]
    A = csc_matrix((entries.ravel(), rows.ravel(), starts), (height + len(free), c * n))
    b = np.concatenate([_unit_disks(n, c), _force_level(problem)])

    unit = scale * bound.max() / problem.bound.sum()
    recover = _recovery(problem, unit, lambda x, z: z[height : height + len(free)])
    cones = [("second_order", 1 + c)] * n + [("zero", len(free))] * bool(free)
    program = ConicProgram(P, problem.rigid_shift.ravel() / scale * weight, A, b, cones, recover)
    return _with_flow(program, problem, of_traction=True)


def gap_program(problem: TangentialProblem) -> ConicProgram:
    """Steady rolling as one convex program: minimise the duality gap.

    ``gap(p) = p'E + sum(g_i |E_i|)`` with ``E = W + M p`` is never negative for admissible p and zero exactly
    at the solution; with ``t_i >= |E_i|`` it is ``p'S p + W'p + g't``, S the symmetric part of M, which is
    positive definite. A prescribed force makes the rigid shift in its direction a variable.
    """
    from scipy.sparse import csc_matrix, hstack

    n, c, free = problem.size, problem.components, problem.free
    bound, height = np.tile(problem.bound, c), (1 + c) * n
    scale, weight, spare = shift_scale(problem), bound / bound.max(), _spare_variables(n, c)
    shift_rows, disk_rows = _cone_rows(n, c), height + _cone_rows(n, c)

    matrix = problem.operator.matrix * (bound / scale)
    quadratic = weight[:, None] * matrix
    quadratic += quadratic.T
    P = _upper(quadratic, empty=n + len(free), squares=spare)
    del quadratic

    rows, entries = _columns(disk_rows, -np.ones(c * n), 2 * height, problem)
    A = hstack(
        [_shift_cones(problem, matrix, rows, entries), csc_matrix((2 * height + len(free), spare))], format="csc"
    )
    del matrix, rows, entries

    b = np.concatenate([np.zeros(height), _unit_disks(n, c), _force_level(problem)])
    b[shift_rows] = problem.rigid_shift.ravel() / scale
    force_work = _force_level(problem) * problem.bound.sum() / bound.max()
    q = np.concatenate([b[shift_rows] * weight, weight[:n], force_work, np.zeros(spare)])

    cones = [("second_order", 1 + c)] * (2 * n) + [("zero", len(free))] * bool(free)
    recover = _recovery(problem, scale, lambda x, z: x[height : height + len(free)])
    return _with_flow(ConicProgram(P, q, A, b, cones, recover), problem, of_traction=True, of_shift=True)


def shift_potential(problem: TangentialProblem) -> ConicProgram:
    """A shift by its potential energy (214): ``min 1/2 u'A^-1 u + sum(g_i |W + u|_i)`` over displacements u.

    They are written ``u = A p``, and p, which nothing bounds, turns out to be the tractions. A prescribed force
    works against the unknown part of the shift.
    """
    n, c, free = problem.size, problem.components, problem.free
    bound, height = np.tile(problem.bound, c), (1 + c) * n
    scale, weight = shift_scale(problem), bound / bound.max()
    matrix = problem.operator.matrix * (bound / scale)
    P = _upper(weight[:, None] * matrix, empty=n + len(free))
    A = _shift_cones(problem, matrix, np.zeros((c * n, 0), dtype=np.int32), np.zeros((c * n, 0)))
    b = np.zeros(height)
    b[_cone_rows(n, c)] = problem.rigid_shift.ravel() / scale
    force_work = _force_level(problem) * problem.bound.sum() / bound.max()
    q = np.concatenate([np.zeros(c * n), weight[:n], force_work])

    recover = _recovery(problem, scale, lambda x, z: x[height : height + len(free)])
    return _with_flow(ConicProgram(P, q, A, b, [("second_order", 1 + c)] * n, recover), problem, of_shift=True)


def _recovery(
    problem: TangentialProblem, unit: float, rigid: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]:
    """`ConicProgram.recover` of tractions that come first, by their bound, and of rigid shifts in a unit."""

    def recover(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        shifts = np.zeros(problem.components)
        shifts[problem.free] = rigid(x, z) * unit
        return x[: problem.rigid_shift.size].reshape(problem.components, -1) * problem.bound, shifts

    return recover


def _with_flow(
    program: ConicProgram, problem: TangentialProblem, of_traction: bool = False, of_shift: bool = False
) -> ConicProgram:
    """The program of a layer that hardens, whose tractions are the first columns, and shifts E in the first cones.

    Of the traction ``s^2/(2 k)``, with ``s + stress >= |p|``. Of the shift a plastic part e comes off, which costs
    ``stress t + k t^2/2`` with ``t >= |e|``: the least of that and ``g |E - e|`` is the conjugate.
    """
    from scipy.sparse import block_diag, bmat, csc_matrix

    if problem.yielding is None:
        return program
    n, c, k = problem.size, problem.components, problem.yielding.hardening
    y = np.flatnonzero(problem.yielding.stress < problem.bound)
    m, scale, most = y.size, shift_scale(problem), float(problem.bound.max())
    bound, stress = problem.bound[y], problem.yielding.stress[y]
    each, vectors = np.arange(m), _cone_rows(m, c)
    size = m * of_traction + (1 + c) * m * of_shift
    wide, height = program.A.shape[1], program.b.size
    below = (1 + c) * m * (of_traction + of_shift)
    own_rows, own_columns, rows, columns = [], [], [], []
    squares, costs, level = [], [], []
    if of_traction:
        own_rows, own_columns = [(1 + c) * each], [each]
        rows, columns = [vectors], [(n * np.arange(c)[:, None] + y).ravel()]
        squares, costs = [bound**2 / (k * scale * most)], [np.zeros(m)]
        level = [np.stack([stress / bound, *np.zeros((c, m))], axis=1).ravel()]
    upper = csc_matrix((height, size))
    if of_shift:
        first, start = m * of_traction, (1 + c) * m * of_traction
        own_rows += [start + (1 + c) * each, start + vectors]
        own_columns += [first + each, first + m + np.arange(c * m)]
        squares += [np.full(m, k * scale / most), np.zeros(c * m)]
        costs += [stress / most, np.zeros(c * m)]
        level += [np.zeros((1 + c) * m)]
        shifted = np.concatenate([(1 + c) * y + 1 + i for i in range(c)])
        upper = csc_matrix((np.ones(c * m), (shifted, first + m + np.arange(c * m))), (height, size))
    left = csc_matrix(_ones_at(rows, columns), (below, wide))
    return ConicProgram(
        P=block_diag([program.P, csc_matrix((np.concatenate(squares), 2 * (np.arange(size),)), (size, size))], "csc"),
        q=np.concatenate([program.q, *costs]),
        A=bmat([[program.A, upper], [left, csc_matrix(_ones_at(own_rows, own_columns), (below, size))]], "csc"),
        b=np.concatenate([program.b, *level]),
        cones=program.cones + [("second_order", 1 + c)] * (m * (of_traction + of_shift)),
        recover=program.recover,
    )


def _ones_at(rows: list[np.ndarray], columns: list[np.ndarray]) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Entries of -1: a variable that is itself in a cone."""
    places = (np.concatenate([[], *each]).astype(np.int32) for each in (rows, columns))
    row, column = places
    return -np.ones(row.size), (row, column)


def _shift_cones(problem: TangentialProblem, matrix: np.ndarray, rows: np.ndarray, entries: np.ndarray) -> csc_matrix:
    """Columns for cones ``t_i >= |E_i|`` in the first rows: of the tractions, of t, of the unknown shifts.

    `rows` and `entries`, (c n, k), are what else the columns of the tractions have, further down.
    """
    from scipy.sparse import csc_matrix, hstack

    n, c, free = problem.size, problem.components, problem.free
    shift_rows = _cone_rows(n, c)
    height = int(rows.max(initial=(1 + c) * n - 1)) + 1
    order = np.argsort(shift_rows)
    rows = np.concatenate([np.broadcast_to(shift_rows[order].astype(np.int32), (c * n, c * n)), rows], axis=1)
    entries = np.concatenate([-matrix.T[:, order], entries], axis=1)
    starts = np.arange(c * n + 1) * entries.shape[1]
    tractions = csc_matrix((entries.ravel(), rows.ravel(), starts), (height, c * n))
    bounds_of_shift = csc_matrix((-np.ones(n), (1 + c) * np.arange(n), np.arange(n + 1)), (height, n))
    unknown = np.array([shift_rows[i * n : (i + 1) * n] for i in free], dtype=int).ravel()
    rigid_shifts = csc_matrix((-np.ones(unknown.size), unknown, np.arange(len(free) + 1) * n), (height, len(free)))
    return hstack([tractions, bounds_of_shift, rigid_shifts], format="csc")


def shift_scale(problem: TangentialProblem) -> float:
    """The largest rigid shift; where part of it is unknown, no less than the elastic shift by full tractions.

    Rounded to a power of four.
    """
    scale = float(np.abs(problem.rigid_shift).max())
    if problem.free or scale == 0:
        scale = max(scale, float(np.abs(problem.operator.matrix @ np.tile(problem.bound, problem.components)).max()))
    return float(4.0 ** np.round(np.log(scale) / np.log(4)))


def _upper(matrix: np.ndarray, empty: int = 0, squares: int = 0) -> csc_matrix:
    """Upper triangle of a symmetric dense matrix, with empty columns behind, then a unit diagonal."""
    from scipy.sparse import csc_matrix

    n = matrix.shape[0]
    lower = np.tri(n, dtype=bool)  # row by row below the diagonal = column by column above it
    values = np.concatenate([matrix[lower], np.ones(squares)])
    rows = np.concatenate([np.nonzero(lower)[1].astype(np.int32), n + empty + np.arange(squares, dtype=np.int32)])
    full = n * (n + 1) // 2
    ends = np.concatenate([np.cumsum(np.arange(n + 1)), np.full(empty, full), full + np.arange(1, squares + 1)])
    return csc_matrix((values, rows, ends), (n + empty + squares, n + empty + squares))


def _cone_rows(n: int, c: int) -> np.ndarray:
    """Rows of the c n components (all x, then all y) of vectors in n cones (radius, x, y)."""
    return np.concatenate([(1 + c) * np.arange(n) + 1 + i for i in range(c)])


def _unit_disks(n: int, c: int) -> np.ndarray:
    return np.tile([1.0] + [0.0] * c, n)


def _columns(
    rows: np.ndarray, entries: np.ndarray, first: int, problem: TangentialProblem
) -> tuple[np.ndarray, np.ndarray]:
    """One entry a column, and the mean over the disks of each direction whose force is prescribed, from row `first`."""
    share, components = problem.bound / problem.bound.sum(), range(problem.components)
    rows = np.stack([rows, *(np.full(rows.size, first + k) for k in range(len(problem.free)))], axis=1)
    forces = [np.concatenate([share * (i == k) for k in components]) for i in problem.free]
    return rows.astype(np.int32), np.stack([entries, *forces], axis=1)


def _force_level(problem: TangentialProblem) -> np.ndarray:
    """Prescribed forces as parts of what the bound can carry."""
    limit = problem.area * problem.bound.sum()
    return np.array([F / limit for F in problem.force if F is not None])


def _spare_variables(n: int, c: int) -> int:
    """How many spare variables make the gap program's factorisation fast.

    Clarabel orders its linear systems by minimum degree, and leaves to the last, as dense, the rows with more
    than ``15 sqrt(size)`` entries. Up to 500 elements that holds for the tractions (2 c n entries) but not for the
    shifts (c n), and the order it then finds takes two to four times as long as with no row called dense. Spare
    variables, alone in the objective as x^2, enlarge the size and cost nothing.
    """
    size = 3 * (1 + c) * n
    if c * n + 2 >= 15 * np.sqrt(size):
        return 0
    return max(int(((2 * c * n + 16) / 15) ** 2) - size, 0)
