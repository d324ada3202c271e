"""Many small tangential problems at once: the inexact Newton method of
`solvers.newton`, one step for all of them.

Products with influence numbers are transforms by dense matrices. Steps are in
single precision; residuals are renewed in double where they are no longer exact
enough. Problems that are solved leave the pool, others take their places.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from varcontact.interfaces.potential import dot, magnitude, project
from varcontact.solvers.batched.pool import (
    NaturalMap,
    NewtonEquations,
    Pool,
    inner,
    inverse_of,
    times,
)
from varcontact.solvers.batched.problem import BatchedProblem, BatchedSolution, doubled, influence
from varcontact.solvers.batched.transforms import (
    Transforms,
    columns_then_rows,
    rows_then_columns,
    transforms,
)
from varcontact.solvers.newton.gcr import LENGTH_MIN
from varcontact.solvers.newton.globalisation import STEP_PARTS
from varcontact.solvers.newton.kernel import STICK_SHIFT
from varcontact.solvers.newton.tangential import LEAST_SHIFT, NEARLY_STICK
from varcontact.system.process import one_blas_thread

POOL = 32_768
"""Elements of all problems in progress: they fit into the cache."""
REFILL_PART = 0.3
"""Part of the pool that must be finished before new problems are added."""
MISSED_PART = 0.3
"""Part of the pool that may fail to reach the tolerance of GCR."""
GCR_TOL = 0.2
"""Relative residual of GCR."""
GCR_TOL_MIN = 3e-2
"""Least relative residual of GCR, near the solution."""
MAX_GCR_ITERATIONS = 25
MAX_NEWTON_STEPS = 60
COARSE_TOL = 1e-2
"""Tolerance of the problems with elements twice as large, which are solved first."""
COARSE_SIDE_MIN = 6
"""Fewest elements along a side of those problems."""
ROUNDING_SINGLE = 3e-7
"""Rounding of a residual in single precision, relative to the tractions that changed."""
ROUNDING_DOUBLE = 1e-15
"""Rounding of a residual in double precision, relative to the tractions that changed."""


@one_blas_thread()
@np.errstate(all="ignore")  # a problem beyond the range of numbers does not converge, and alone
def solve_batch(
    problem: BatchedProblem,
    tol: float = 1e-8,
    start: tuple[np.ndarray, np.ndarray] | None = None,
    certified: bool = True,
) -> BatchedSolution:
    """Solve all problems, from tractions and unknown rigid shifts, if given.

    One that misses the tolerance after `MAX_NEWTON_STEPS` is marked and disturbs no other.
    """
    whole = BatchedSolution.unsolved(problem)
    inside = problem.inside
    if not problem.bound.any():
        return whole
    problem = problem.within(*inside)
    out = whole.within(*inside)
    traction, rigid = _first_guess(problem, start, inside)
    ny, nx, n = problem.bound.shape
    method = BatchedNewton(problem, transforms(ny, nx, problem.steps_ahead))
    places = max(1, min(n, POOL // (ny * nx)))
    waiting = 0  # the first problem that has not entered the pool yet
    work: tuple[Pool, NaturalMap] | None = None
    while waiting < n or work is not None:
        # add new problems when many have left
        working = 0 if work is None else work[0].size
        if waiting < n and working <= (1 - REFILL_PART) * places:
            ids = np.arange(waiting, min(n, waiting + places - working))
            waiting = int(ids[-1]) + 1
            work = _joined(work, method.entered(ids, traction[..., ids], rigid[:, ids]))
        assert work is not None
        pool, at = work
        # recompute in double precision where rounding may exceed a tenth of the residual
        stale = np.flatnonzero(pool.rounding > 0.1 * np.maximum(at.residual, tol * at.size))
        if certified and stale.size:
            at.put(stale, method.renewed(pool, stale, pool.symbol))
        # record problems that are ready, and continue with the others
        ready = np.flatnonzero((at.residual <= tol * at.size) | (pool.steps >= MAX_NEWTON_STEPS))
        if ready.size:
            leaving = method.left(pool, at, ready, out, tol, certified)
            staying = ~np.isin(np.arange(pool.size), leaving)
            if not staying.any():
                work = None
                continue
            if leaving.size:
                pool = pool.where(staying)
                at = at.where(staying)
        work = pool, method.step(pool, at, tol)
    return whole


def _first_guess(
    problem: BatchedProblem,
    start: tuple[np.ndarray, np.ndarray] | None,
    inside: tuple[slice, slice],
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions and rigid shifts of the start (`inside` its elements), or from a solve on elements
    twice as large; zero for few elements.
    """
    if start is not None:
        traction, rigid = start
        return project(traction[:, *inside], problem.bound), rigid
    ny, nx, n = problem.bound.shape
    if nx < 2 * COARSE_SIDE_MIN or not (problem.line or ny >= 2 * COARSE_SIDE_MIN):
        return np.zeros(problem.rigid_shift.shape), np.zeros((2, n))
    coarse = problem.coarser()
    solution = solve_batch(coarse, COARSE_TOL, certified=False)
    rigid = solution.rigid / (1.0 if problem.difference is None else 2.0)
    part = solution.traction / np.where(coarse.bound > 0, coarse.bound, 1.0)
    fine = doubled(part, coarse.bound > 0, (ny, nx)) * problem.bound
    return project(fine, problem.bound), rigid


def _joined(
    work: tuple[Pool, NaturalMap] | None, entered: tuple[Pool, NaturalMap]
) -> tuple[Pool, NaturalMap]:
    if work is None:
        return entered
    return work[0].joined(entered[0]), work[1].joined(entered[1])


def shift_before(problem: BatchedProblem, traction: np.ndarray, ahead: int) -> np.ndarray:
    """Displacements (2, ny, nx, n) by tractions, of particles `ahead` elements ahead."""
    ny, nx, _ = problem.bound.shape
    transform = transforms(ny, nx, ((ahead, 1.0),))
    symbol = transform.symbol(influence(problem, transform.columns) * (problem.dx / np.pi))
    return BatchedNewton(problem, transform).product(traction, symbol, symbol[:2, 0, 0])


class BatchedNewton:
    """Newton's method for problems that share transforms and softened edges."""

    def __init__(self, problem: BatchedProblem, transforms: Transforms) -> None:
        self.problem = problem
        self.transforms = transforms
        # tractions of soft elements are divided by the scale, shifts multiplied
        self.scale: np.ndarray | None = None
        self.scale32: np.ndarray | None = None
        if problem.compliance is not None and problem.compliance.any():
            self.scale = 1 / np.sqrt(1 + problem.compliance)[..., None]
            self.scale32 = self.scale.astype(np.float32)
        self.by_force = bool(np.isfinite(problem.force).any())

    def entered(
        self, ids: np.ndarray, traction: np.ndarray, rigid: np.ndarray
    ) -> tuple[Pool, NaturalMap]:
        """Problems with their symbols, in their own units."""
        problem = self.problem.of(ids)
        n = len(ids)
        transforms = self.transforms
        # influence numbers by those of an element on itself, and their transforms
        numbers = influence(problem, transforms.columns)
        own = np.sum([w * numbers[::2, 0, abs(k)] for k, w in problem.steps_ahead], axis=0)
        diagonal = own.mean(axis=0)
        numbers /= diagonal
        load = problem.bound.max(axis=(0, 1))
        unit = diagonal * problem.dx * load / np.pi
        symbol = transforms.symbol(numbers)
        # the preconditioner
        windowed = transforms.windowed_symbol(numbers.astype(np.float32))
        scale = 1.0 if self.scale is None else self.scale
        bound = problem.bound / load / scale
        start = traction / load / scale
        stick, turned = inverse_of(windowed, np.full(n, STICK_SHIFT, np.float32))
        pool = Pool(
            ids=ids,
            load=load,
            unit=unit,
            symbol=symbol,
            symbol32=symbol.astype(np.float32),
            own=own / diagonal,
            windowed=windowed,
            stick_inverse=stick,
            stick_inverse_turned=turned,
            row_size=np.sqrt(
                (np.abs(windowed[0]) ** 2 + np.abs(windowed[2]) ** 2).mean((0, 1)) / 2
            ),
            rigid_shift=problem.rigid_shift / unit * scale,
            bound=bound,
            force=np.nan_to_num(problem.force) / load,
            free=np.isfinite(problem.force) * 1.0,
            per_element=1 / np.sqrt(np.maximum((bound > 0).sum((0, 1)), 1)),
            traction=start,
            shift=np.zeros_like(start),
            rigid=rigid / unit,
            rounding=np.zeros(n),
            steps=np.zeros(n, int),
        )
        return pool, self.renewed(pool, np.arange(n), pool.symbol32)

    def product(self, field: np.ndarray, symbol: np.ndarray, own: np.ndarray) -> np.ndarray:
        """Elastic shifts of tractions (2, ny, nx, n) over a step, in the precision of the field."""
        # in double precision by what the cache holds
        most = max(1, 4096 // (field.shape[1] * field.shape[2]))
        if field.dtype == np.float64 and field.shape[-1] > most:
            parts = (slice(j, j + most) for j in range(0, field.shape[-1], most))
            return np.concatenate(
                [self.product(field[..., j], symbol[..., j], own[:, j]) for j in parts], -1
            )
        single = field.dtype == np.float32
        scale = self.scale32 if single else self.scale
        precision = 0 if single else 1
        scaled = field if scale is None else field * scale
        transform = rows_then_columns(scaled, self.transforms.forward[precision])
        rows, columns = symbol.shape[1:3]
        transform = transform.reshape(2, 2, rows, 2, columns, -1)
        product = symbol[::2][:, None, :, None] * transform
        product += symbol[1][:, None] * transform[::-1, ::-1, :, ::-1]
        product = product.reshape(2, 2 * rows, 2 * columns, -1)
        shift = columns_then_rows(product, self.transforms.backward[precision])
        if scale is not None:
            shift *= scale
            shift += own.astype(field.dtype)[:, None, None] * (1 - scale**2) * field
        return shift

    def _rigid(self, rigid: np.ndarray) -> np.ndarray:
        """Rigid shifts (2, n) of the elements."""
        field = rigid[:, None, None]
        if self.scale is None:
            return field
        return field * self.scale

    def _sums(self, field: np.ndarray) -> np.ndarray:
        """Sums of tractions over the elements, (2, n)."""
        scale = self.scale32 if field.dtype == np.float32 else self.scale
        if scale is not None:
            field = field * scale
        return field.sum(axis=(1, 2))

    def renewed(self, pool: Pool, some: np.ndarray, symbol: np.ndarray) -> NaturalMap:
        """Natural map of some problems, with shifts recomputed in the precision of the symbol."""
        rigid = pool.rigid_shift[..., some] + self._rigid(pool.rigid[:, some])
        traction = pool.traction[..., some].astype(symbol.dtype)
        pool.shift[..., some] = rigid + self.product(traction, symbol[..., some], pool.own[:, some])
        single = symbol.dtype == np.float32
        pool.rounding[some] = ROUNDING_SINGLE if single else ROUNDING_DOUBLE
        return self.natural(pool, some, pool.traction[..., some], pool.shift[..., some])

    def natural(
        self, pool: Pool, some: np.ndarray | slice, traction: np.ndarray, shift: np.ndarray
    ) -> NaturalMap:
        bound = pool.bound[..., some]
        free = pool.free[:, some]
        trial = traction - shift
        length = magnitude(trial)
        off = traction - trial * np.minimum(1.0, bound / np.maximum(length, 1e-30))
        off *= bound > 0
        squares = dot(off, off)
        lacking = 0 * free
        if self.by_force:
            lacking = (pool.force[:, some] - self._sums(traction)) * pool.per_element[some] * free
        residual = np.maximum(np.sqrt(squares.max(axis=(0, 1))), np.abs(lacking).max(axis=0))
        merit = np.sqrt(squares.sum(axis=(0, 1)) + dot(lacking, lacking))
        size = np.maximum(np.sqrt(dot(traction, traction).max(axis=(0, 1))), residual)
        return NaturalMap(trial, length, lacking, residual, merit, size)

    def left(
        self,
        pool: Pool,
        at: NaturalMap,
        ready: np.ndarray,
        out: BatchedSolution,
        tol: float,
        certified: bool,
    ) -> np.ndarray:
        """Record the ready problems that have converged (if `certified` in double precision) or
        have no steps left; returns their places in the pool.
        """
        bound = pool.bound[..., ready]
        scale = 1.0 if self.scale is None else self.scale
        pool.traction[..., ready] = project(pool.traction[..., ready], bound)
        residual = at.residual[ready]
        gap = np.zeros(len(ready))
        good = at.residual[ready] <= tol * at.size[ready]
        if certified:
            renewed = self.renewed(pool, ready, pool.symbol)
            at.put(ready, renewed)
            residual, gap = self._certified(pool, renewed, ready, out)
            good = (residual <= tol) & (gap <= tol)
        leave = good | (pool.steps[ready] >= MAX_NEWTON_STEPS)
        places = ready[leave]
        ids = pool.ids[places]
        out.traction[..., ids] = pool.traction[..., places] * scale * pool.load[places]
        out.rigid[:, ids] = (pool.rigid * pool.unit)[:, places]
        out.residual[ids] = residual[leave]
        out.relative_gap[ids] = gap[leave]
        out.converged[ids] = good[leave]
        out.iterations[ids] = pool.steps[places]
        return places

    def _certified(
        self, pool: Pool, renewed: NaturalMap, ready: np.ndarray, out: BatchedSolution
    ) -> tuple[np.ndarray, np.ndarray]:
        """Residuals and relative gaps in double precision; slip and dissipation are recorded."""
        bound = pool.bound[..., ready]
        scale = 1.0 if self.scale is None else self.scale
        traction = pool.traction[..., ready]
        shift = pool.shift[..., ready]
        work = dot(traction, shift)
        excess = np.maximum(bound * magnitude(shift) + work, 0).sum((0, 1))
        dissipated = 0.0 - work.sum((0, 1)) * pool.load[ready] * pool.unit[ready]
        out.dissipated[pool.ids[ready]] = dissipated
        rigid = pool.rigid_shift[..., ready] + self._rigid(pool.rigid[:, ready])
        tiny = np.finfo(bound.dtype).tiny
        gap = excess / np.maximum((bound * magnitude(rigid)).sum((0, 1)), tiny)
        residual = renewed.residual / np.maximum(renewed.size, tiny)
        slips = (renewed.length > bound * (1 + 1e-8)) & (bound > 0)
        out.slip[..., pool.ids[ready]] = slips * magnitude(shift / scale) * pool.unit[ready]
        return residual, gap

    def linearised(self, pool: Pool, at: NaturalMap) -> NewtonEquations:
        bound = pool.bound
        trial = at.trial
        length = at.length
        n = pool.size
        # directions along and across the trial tractions where it slips
        contact = bound > 0
        slip = (length > bound) & contact
        normal = trial * (slip / np.maximum(length, 1e-30))
        across = np.stack([-normal[1], normal[0]])
        outward = length / np.where(contact, bound, np.inf)  # trial traction divided by the bound
        # symmetric matrices of each element: projections, and the slope of the slip law
        steep = ((outward - 1) * slip).astype(np.float32)
        stick = (contact & ~slip).astype(np.float32)
        n32 = normal.astype(np.float32)
        along = np.stack([n32[0] * n32[0], n32[0] * n32[1], n32[1] * n32[1]])
        turning = np.stack([along[2], -along[1], along[0]])
        own = steep * turning + along
        free = turning
        free[::2] += stick
        # the preconditioner: two inverses, blended by the slope
        slip_elements = np.maximum(slip.reshape(-1, n).sum(0), 1)
        logs = (np.log(np.maximum(steep, np.float32(1e-2))) * slip).reshape(-1, n).sum(0)
        logs = logs / slip_elements
        shift = np.maximum(np.exp(logs), LEAST_SHIFT).astype(np.float32)
        size = pool.row_size.astype(np.float32)
        least = np.float32(NEARLY_STICK)
        part = np.log1p(np.minimum(steep, shift) / least) / np.log1p(shift / least)
        level = np.sqrt((size + shift) / (size + np.maximum(steep, shift)))
        weights = np.sqrt(1 - part) * level, np.sqrt(part) * level
        # right-hand sides
        lacking = dot(normal, bound * normal - pool.traction)
        turn = -dot(across, pool.traction) * outward
        right = lacking * normal + turn * across - pool.shift * (contact & ~slip)
        return NewtonEquations(free, along, own, weights, inverse_of(pool.windowed, shift), right)

    def _precondition(
        self, pool: Pool, equations: NewtonEquations, right: np.ndarray
    ) -> np.ndarray:
        field = times(equations.free, right)
        stick, slip = equations.weights
        step = stick * self._circulant(stick * field, pool.stick_inverse, pool.stick_inverse_turned)
        step += slip * self._circulant(slip * field, *equations.inverse)
        step = times(equations.free, step)
        step += times(equations.along, right)
        return step

    def _circulant(self, field: np.ndarray, real: np.ndarray, turned: np.ndarray) -> np.ndarray:
        """The inverse (real and imaginary part: xx, yy, xy) of the windowed kernel, on a periodic
        box.
        """
        transform = rows_then_columns(field, self.transforms.periodic)
        _, rows, _, columns, n = real.shape
        transform = transform.reshape(2, 2, rows, 2, columns, n)
        product = real[:2, None] * transform
        product += turned[:2, None] * transform[:, :, :, ::-1]
        other = transform[::-1, ::-1]
        product += real[2] * other
        product += turned[2] * other[:, :, :, ::-1]
        product = product.reshape(2, 2 * rows, 2 * columns, n)
        return columns_then_rows(product, self.transforms.unperiodic)

    def _gcr(
        self, pool: Pool, equations: NewtonEquations, lacking: np.ndarray, tolerance: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Steps of tractions, shifts and rigid shifts by as many iterations for all, until few miss
        their tolerance.

        Generalised conjugate residuals (Eisenstat, Elman and Schultz 1983); prescribed forces
        border the equations.
        """
        squares = inner(equations.right, equations.right) + dot(lacking, lacking)
        scale = np.maximum(np.sqrt(squares), 1e-30).astype(equations.right.dtype)
        rest = (equations.right / scale).astype(np.float32)
        rest_of_forces = (lacking / scale).astype(np.float32)
        border = Border.of(self, pool, equations) if self.by_force else None
        steps: list[np.ndarray] = []
        images: list[np.ndarray] = []
        rigids: list[np.ndarray] = []
        directions: list[tuple[np.ndarray, np.ndarray]] = []
        triangle: list[list[np.ndarray]] = []
        parts: list[np.ndarray] = []
        for _ in range(MAX_GCR_ITERATIONS):
            # a direction, and its image by the equations
            step = self._precondition(pool, equations, rest)
            sums = 0 * rest_of_forces
            if border is not None:
                step, rigid = border.corrected(self, step, rest_of_forces)
                rigids.append(rigid)
            image = self.product(step, pool.symbol32, pool.own)
            rows = times(equations.free, image)
            rows += times(equations.own, step)
            if border is not None:
                rows += rigid[0] * border.columns[0] + rigid[1] * border.columns[1]
                sums = border.sums(self, step)
            rows, sums, column = _orthonormal(rows, sums, directions)
            # its projection is subtracted from the residual
            part = inner(rows, rest) + dot(sums, rest_of_forces)
            rest -= part * rows
            rest_of_forces = rest_of_forces - part * sums
            steps.append(step)
            images.append(image)
            directions.append((rows, sums))
            triangle.append(column)
            parts.append(part)
            missed = np.sqrt(inner(rest, rest) + dot(rest_of_forces, rest_of_forces)) > tolerance
            if missed.sum() <= MISSED_PART * pool.size:
                break
        parts = _back_substituted(triangle, parts)

        def combined(vectors: list[np.ndarray]) -> np.ndarray:
            return np.asarray(sum(map(np.multiply, parts, vectors)) * scale)

        rigid = combined(rigids) if rigids else np.zeros(lacking.shape)
        return combined(steps), combined(images), rigid

    def step(self, pool: Pool, at: NaturalMap, tol: float) -> NaturalMap:
        """Natural map after one Newton step of every problem, with a line search on the norm of its
        residual; the pool is changed in place.
        """
        equations = self.linearised(pool, at)
        near = at.residual <= 30 * tol * at.size
        wanted = 0.3 * tol * at.size / np.maximum(at.residual, 1e-30)
        tolerance = np.clip(wanted, np.where(near, GCR_TOL_MIN, GCR_TOL), GCR_TOL)
        step, image, rigid = self._gcr(pool, equations, at.lacking, tolerance)
        pool.rounding[...] += ROUNDING_SINGLE * np.abs(step).max(axis=(0, 1, 2))
        image += self._rigid(rigid)
        # the whole step, then shorter ones of the problems whose merit has not fallen enough
        length = np.ones(pool.size, step.dtype)
        todo = np.arange(pool.size)
        best = self.natural(pool, slice(None), pool.traction + step, pool.shift + image)
        candidate = best
        for part, shorter in pairwise(STEP_PARTS):
            todo = todo[~(candidate.merit < (1 - 0.1 * part) * at.merit[todo])]
            if todo.size == 0:
                break
            traction = pool.traction[..., todo] + shorter * step[..., todo]
            shift = pool.shift[..., todo] + shorter * image[..., todo]
            candidate = self.natural(pool, todo, traction, shift)
            less = candidate.merit < best.merit[todo]
            best.put(todo[less], candidate.where(less))
            length[todo[less]] = shorter
        pool.traction[...] += length * step
        pool.shift[...] += length * image
        pool.rigid[...] += length * rigid
        pool.steps[...] += 1
        return best


def _orthonormal(
    rows: np.ndarray, sums: np.ndarray, directions: list[tuple[np.ndarray, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """An image made orthogonal to those of earlier directions and of unit length, and its column of
    the triangle of products.
    """
    column: list[np.ndarray] = []
    for earlier_rows, earlier_sums in directions:
        along = inner(earlier_rows, rows) + dot(earlier_sums, sums)
        rows -= along * earlier_rows
        sums = sums - along * earlier_sums
        column.append(along)
    length = np.sqrt(inner(rows, rows) + dot(sums, sums))
    divisor = np.maximum(length, np.float32(LENGTH_MIN))
    inverse = (length > LENGTH_MIN) / divisor
    rows *= inverse
    return rows, sums * inverse, [*column, divisor]


def _back_substituted(
    triangle: list[list[np.ndarray]], right: list[np.ndarray]
) -> list[np.ndarray]:
    """Solution of the upper triangle that has these columns."""
    parts = list(right)
    for i in range(len(parts) - 1, -1, -1):
        for j in range(i + 1, len(parts)):
            parts[i] = parts[i] - triangle[j][i] * parts[j]
        parts[i] = parts[i] / triangle[i][i]
    return parts


@dataclass(frozen=True, eq=False)
class Border:
    """Prescribed forces in Newton's equations: columns of unknown rigid shifts, and the inverse of
    what they leave.
    """

    free: np.ndarray
    per_element: np.ndarray
    columns: list[np.ndarray]
    images: list[np.ndarray]
    inverse: np.ndarray

    @classmethod
    def of(cls, method: BatchedNewton, pool: Pool, equations: NewtonEquations) -> Border:
        free = pool.free.astype(np.float32)
        per_element = pool.per_element.astype(np.float32)
        columns = [equations.free[c : c + 2] * free[c] for c in (0, 1)]
        if method.scale32 is not None:
            columns = [column * method.scale32 for column in columns]
        images = [method._precondition(pool, equations, column) for column in columns]
        left = per_element * np.stack([method._sums(each) for each in images], 1) * free[:, None]
        left = left + (1 - free)[:, None] * np.eye(2, dtype=np.float32)[..., None]
        # 0 in full slip
        determinant = np.maximum(
            left[0, 0] * left[1, 1] - left[0, 1] * left[1, 0], np.float32(1e-6)
        )
        inverse = np.array([[left[1, 1], -left[0, 1]], [-left[1, 0], left[0, 0]]]) / determinant
        return cls(free, per_element, columns, images, inverse)

    def sums(self, method: BatchedNewton, step: np.ndarray) -> np.ndarray:
        return self.per_element * method._sums(step) * self.free

    def corrected(
        self, method: BatchedNewton, step: np.ndarray, lacking: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """A preconditioned step and the rigid shifts with which it has the forces that lack."""
        off = (self.sums(method, step) - lacking) * self.free
        rigid = self.inverse[:, 0] * off[0] + self.inverse[:, 1] * off[1]
        return step - rigid[0] * self.images[0] - rigid[1] * self.images[1], rigid
