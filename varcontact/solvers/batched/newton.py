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

from varcontact.interfaces.potential import magnitude, project
from varcontact.solvers.batched.pool import NaturalMap, Pool, System, inner, inverse_of, times
from varcontact.solvers.batched.problem import BatchedProblem, BatchedSolution, doubled, influence
from varcontact.solvers.batched.transforms import (
    Transforms,
    columns_then_rows,
    rows_then_columns,
    transforms,
)
from varcontact.solvers.newton.globalisation import PARTS, dot
from varcontact.solvers.newton.kernel import STICK_SHIFT
from varcontact.solvers.newton.tangential import LEAST_SHIFT, NEARLY_STICK
from varcontact.system.process import one_blas_thread

POOL = 32_768
"""Elements of all problems in work: they fit into the cache."""
REFILL, ABOVE = 0.3, 0.3
"""Part of the pool that has left when others are let in; part of it that may miss the inner
tolerance."""
INNER, LATE_INNER = 0.2, 3e-2
"""Inner tolerance, and its least value near the solution."""
MOST_INNER, MOST_STEPS = 25, 60
"""Inner iterations, and Newton steps."""
COARSE_TOLERANCE, COARSEST = 1e-2, 6
"""Of the problems with elements twice as large, which are solved first from twice so many elements
on."""
SINGLE, DOUBLE = 3e-7, 1e-15
"""Rounding of a residual in single and in double precision, by the tractions that changed."""


@one_blas_thread()
@np.errstate(all="ignore")  # a problem beyond the range of numbers does not converge, and alone
def solve_batch(
    problem: BatchedProblem,
    tol: float = 1e-8,
    start: tuple[np.ndarray, np.ndarray] | None = None,
    certified: bool = True,
) -> BatchedSolution:
    """Solve all problems, from tractions and unknown rigid shifts, if given.

    One that misses the tolerance after `MOST_STEPS` is marked and disturbs no other.
    """
    whole, inside = BatchedSolution.unsolved(problem), problem.inside
    if not problem.bound.any():
        return whole
    problem, out = problem.within(*inside), whole.within(*inside)
    (ny, nx, n), rigid = problem.bound.shape, np.zeros((2, problem.dx.size))
    if start is not None:
        traction, rigid = project(start[0][:, *inside], problem.bound), start[1]
    elif nx >= 2 * COARSEST and (problem.line or ny >= 2 * COARSEST):
        coarse = problem.coarser()
        found = solve_batch(coarse, COARSE_TOLERANCE, certified=False)
        rigid = found.rigid / (1.0 if problem.difference is None else 2.0)
        part = found.traction / np.where(coarse.bound > 0, coarse.bound, 1.0)
        traction = project(doubled(part, coarse.bound > 0, (ny, nx)) * problem.bound, problem.bound)
    else:
        traction = np.zeros(problem.rigid_shift.shape)
    method = Method(problem, transforms(ny, nx, problem.steps_ahead))
    places, waiting = max(1, min(n, POOL // (ny * nx))), 0
    work: tuple[Pool, NaturalMap] | None = None
    while waiting < n or work is not None:
        working = 0 if work is None else work[0].size
        if waiting < n and working <= (1 - REFILL) * places:
            ids = np.arange(waiting, min(n, waiting + places - working))
            waiting = int(ids[-1]) + 1
            entered = method.entered(ids, traction[..., ids], rigid[:, ids])
            work = (
                entered
                if work is None
                else (work[0].joined(entered[0]), work[1].joined(entered[1]))
            )
        assert work is not None
        pool, at = work
        stale = np.flatnonzero(pool.rounding > 0.1 * np.maximum(at.residual, tol * at.size))
        if certified and stale.size:
            at.put(stale, method.renewed(pool, stale, pool.symbol))
        ready = np.flatnonzero((at.residual <= tol * at.size) | (pool.steps >= MOST_STEPS))
        if ready.size:
            leaving = method.left(pool, at, ready, out, tol, certified)
            staying = ~np.isin(np.arange(pool.size), leaving)
            if not staying.any():
                work = None
                continue
            if leaving.size:
                pool, at = pool.where(staying), at.where(staying)
        work = pool, method.step(pool, at, tol)
    return whole


def shift_before(problem: BatchedProblem, traction: np.ndarray, ahead: int) -> np.ndarray:
    """Displacements (2, ny, nx, n) by tractions, of particles so many elements ahead."""
    ny, nx, _ = problem.bound.shape
    ways = transforms(ny, nx, ((ahead, 1.0),))
    symbol = ways.symbol(influence(problem, ways.columns) * (problem.dx / np.pi))
    return Method(problem, ways).product(traction, symbol, symbol[:2, 0, 0])


class Method:
    """What the problems have in common: transforms and softened edges."""

    def __init__(self, problem: BatchedProblem, transforms: Transforms) -> None:
        self.problem, self.transforms = problem, transforms
        compliance = problem.compliance
        scale = (
            None
            if compliance is None or not compliance.any()
            else 1 / np.sqrt(1 + compliance)[..., None]
        )
        self.scale = scale  # tractions of soft elements are divided by it, shifts multiplied
        self.scale32 = None if scale is None else scale.astype(np.float32)
        self.given = bool(np.isfinite(problem.force).any())

    def entered(
        self, ids: np.ndarray, traction: np.ndarray, rigid: np.ndarray
    ) -> tuple[Pool, NaturalMap]:
        """Problems with their symbols, in their own units."""
        problem, n = self.problem.of(ids), len(ids)
        transforms = self.transforms
        numbers = influence(problem, transforms.columns)
        own = np.sum([w * numbers[::2, 0, abs(k)] for k, w in problem.steps_ahead], axis=0)
        diagonal = own.mean(axis=0)
        numbers /= diagonal
        load = problem.bound.max(axis=(0, 1))
        unit = diagonal * problem.dx * load / np.pi
        symbol = transforms.symbol(numbers)
        ways = (transforms.windowed_even, transforms.windowed_odd, transforms.windowed_even)
        single = numbers.astype(np.float32)
        windowed = np.stack(
            [rows_then_columns(each, way) for each, way in zip(single, ways, strict=True)]
        )
        half = windowed.shape[2] // 2
        windowed = windowed[:, :, :half] + 1j * windowed[:, :, half:]
        scale = 1.0 if self.scale is None else self.scale
        bound, free = problem.bound / load / scale, np.isfinite(problem.force) * 1.0
        start, shift = traction / load / scale, problem.rigid_shift / unit * scale
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
            rigid_shift=shift,
            bound=bound,
            force=np.nan_to_num(problem.force) / load,
            free=free,
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
        ways = self.transforms.forward[not single], self.transforms.backward[not single]
        of_field = rows_then_columns(field if scale is None else field * scale, ways[0])
        rows, columns = symbol.shape[1:3]
        of_field = of_field.reshape(2, 2, rows, 2, columns, -1)
        found = symbol[::2][:, None, :, None] * of_field
        found += symbol[1][:, None] * of_field[::-1, ::-1, :, ::-1]
        shift = columns_then_rows(found.reshape(2, 2 * rows, 2 * columns, -1), ways[1])
        if scale is not None:
            shift *= scale
            shift += own.astype(field.dtype)[:, None, None] * (1 - scale**2) * field
        return shift

    def _rigid(self, rigid: np.ndarray) -> np.ndarray:
        """Rigid shifts (2, n) of the elements."""
        field = rigid[:, None, None]
        return field if self.scale is None else field * self.scale

    def _sums(self, field: np.ndarray) -> np.ndarray:
        """Sums of tractions over the elements, (2, n)."""
        scale = self.scale32 if field.dtype == np.float32 else self.scale
        return (field if scale is None else field * scale).sum(axis=(1, 2))

    def renewed(self, pool: Pool, some: np.ndarray, symbol: np.ndarray) -> NaturalMap:
        """The natural map of some problems, their shifts anew in the precision of the symbol."""
        known = pool.rigid_shift[..., some] + self._rigid(pool.rigid[:, some])
        traction = pool.traction[..., some].astype(symbol.dtype)
        pool.shift[..., some] = known + self.product(traction, symbol[..., some], pool.own[:, some])
        pool.rounding[some] = SINGLE if symbol.dtype == np.float32 else DOUBLE
        return self.natural(pool, some, pool.traction[..., some], pool.shift[..., some])

    def natural(
        self, pool: Pool, some: np.ndarray | slice, traction: np.ndarray, shift: np.ndarray
    ) -> NaturalMap:
        bound, free = pool.bound[..., some], pool.free[:, some]
        trial = traction - shift
        length = magnitude(trial)
        off = traction - trial * np.minimum(1.0, bound / np.maximum(length, 1e-30))
        off *= bound > 0
        squares = dot(off, off)
        lacking = 0 * free
        if self.given:
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
        """Write down the problems that are ready, as far as double precision agrees; which of the
        pool these are.
        """
        bound, scale = pool.bound[..., ready], 1.0 if self.scale is None else self.scale
        pool.traction[..., ready] = project(pool.traction[..., ready], bound)
        good, gap, residual = (
            at.residual[ready] <= tol * at.size[ready],
            np.zeros(len(ready)),
            at.residual[ready],
        )
        if certified:
            again = self.renewed(pool, ready, pool.symbol)
            at.put(ready, again)
            traction, shift = pool.traction[..., ready], pool.shift[..., ready]
            lost = dot(traction, shift)
            work = np.maximum(bound * magnitude(shift) + lost, 0).sum((0, 1))
            out.dissipated[pool.ids[ready]] = (
                0.0 - lost.sum((0, 1)) * pool.load[ready] * pool.unit[ready]
            )
            rigid = pool.rigid_shift[..., ready] + self._rigid(pool.rigid[:, ready])
            least = np.finfo(bound.dtype).tiny
            gap = work / np.maximum((bound * magnitude(rigid)).sum((0, 1)), least)
            residual = again.residual / np.maximum(again.size, least)
            good = (residual <= tol) & (gap <= tol)
            slips = (again.length > bound * (1 + 1e-8)) & (bound > 0)
            out.slip[..., pool.ids[ready]] = slips * magnitude(shift / scale) * pool.unit[ready]
        leave = good | (pool.steps[ready] >= MOST_STEPS)
        places = ready[leave]
        ids = pool.ids[places]
        out.traction[..., ids] = pool.traction[..., places] * scale * pool.load[places]
        out.rigid[:, ids] = (pool.rigid * pool.unit)[:, places]
        out.residual[ids], out.relative_gap[ids] = residual[leave], gap[leave]
        out.converged[ids], out.iterations[ids] = good[leave], pool.steps[places]
        return places

    def linearised(self, pool: Pool, at: NaturalMap) -> System:
        bound, trial, length, n = pool.bound, at.trial, at.length, pool.size
        contact = bound > 0
        slip = (length > bound) & contact
        normal = trial * (slip / np.maximum(length, 1e-30))
        across = np.stack([-normal[1], normal[0]])
        outward = length / np.where(contact, bound, np.inf)  # trial traction by the bound
        steep = ((outward - 1) * slip).astype(np.float32)
        stick = (contact & ~slip).astype(np.float32)
        n32 = normal.astype(np.float32)
        along = np.stack([n32[0] * n32[0], n32[0] * n32[1], n32[1] * n32[1]])
        turning = np.stack([along[2], -along[1], along[0]])
        own = steep * turning + along
        free = turning
        free[::2] += stick
        many = np.maximum(slip.reshape(-1, n).sum(0), 1)
        logs = (np.log(np.maximum(steep, np.float32(1e-2))) * slip).reshape(-1, n).sum(0) / many
        shift = np.maximum(np.exp(logs), LEAST_SHIFT).astype(np.float32)
        size, least = pool.row_size.astype(np.float32), np.float32(NEARLY_STICK)
        part = np.log1p(np.minimum(steep, shift) / least) / np.log1p(shift / least)
        level = np.sqrt((size + shift) / (size + np.maximum(steep, shift)))
        weights = np.sqrt(1 - part) * level, np.sqrt(part) * level
        lacking = dot(normal, bound * normal - pool.traction)
        turn = -dot(across, pool.traction) * outward
        right = lacking * normal + turn * across - pool.shift * (contact & ~slip)
        return System(free, along, own, weights, inverse_of(pool.windowed, shift), right)

    def _precondition(self, pool: Pool, system: System, right: np.ndarray) -> np.ndarray:
        field = times(system.free, right)
        near, far = system.weights
        found = near * self._circulant(near * field, pool.stick_inverse, pool.stick_inverse_turned)
        found += far * self._circulant(far * field, *system.inverse)
        found = times(system.free, found)
        found += times(system.along, right)
        return found

    def _circulant(self, field: np.ndarray, real: np.ndarray, turned: np.ndarray) -> np.ndarray:
        """The inverse (real and imaginary part: xx, yy, xy) of the windowed kernel, on a periodic
        box.
        """
        of_field = rows_then_columns(field, self.transforms.periodic)
        _, rows, _, columns, n = real.shape
        of_field = of_field.reshape(2, 2, rows, 2, columns, n)
        found = real[:2, None] * of_field
        found += turned[:2, None] * of_field[:, :, :, ::-1]
        other = of_field[::-1, ::-1]
        found += real[2] * other
        found += turned[2] * other[:, :, :, ::-1]
        return columns_then_rows(
            found.reshape(2, 2 * rows, 2 * columns, n), self.transforms.unperiodic
        )

    def _gcr(
        self, pool: Pool, system: System, lacking: np.ndarray, tolerance: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Steps of tractions, shifts and rigid shifts by as many iterations for all, until few miss
        their tolerance.

        Generalised conjugate residuals (Eisenstat, Elman and Schultz 1983); prescribed forces
        border the equations.
        """
        scale = np.maximum(
            np.sqrt(inner(system.right, system.right) + dot(lacking, lacking)), 1e-30
        )
        scale = scale.astype(system.right.dtype)
        rest, rest_of_forces = (
            (system.right / scale).astype(np.float32),
            (lacking / scale).astype(np.float32),
        )
        border = Border.of(self, pool, system) if self.given else None
        steps: list[np.ndarray] = []
        images: list[np.ndarray] = []
        rigids: list[np.ndarray] = []
        directions: list[tuple[np.ndarray, np.ndarray]] = []
        triangle: list[list[np.ndarray]] = []
        parts: list[np.ndarray] = []
        for _ in range(MOST_INNER):
            step = self._precondition(pool, system, rest)
            sums = 0 * rest_of_forces
            if border is not None:
                step, rigid = border.corrected(self, step, rest_of_forces)
                rigids.append(rigid)
            image = self.product(step, pool.symbol32, pool.own)
            rows = times(system.free, image)
            rows += times(system.own, step)
            if border is not None:
                rows += rigid[0] * border.columns[0] + rigid[1] * border.columns[1]
                sums = border.sums(self, step)
            row: list[np.ndarray] = []
            for one, of_forces in directions:
                along = inner(one, rows) + dot(of_forces, sums)
                rows -= along * one
                sums = sums - along * of_forces
                row.append(along)
            length = np.sqrt(inner(rows, rows) + dot(sums, sums))
            inverse = (length > 1e-7) / np.maximum(length, np.float32(1e-7))
            rows *= inverse
            sums = sums * inverse
            part = inner(rows, rest) + dot(sums, rest_of_forces)
            rest -= part * rows
            rest_of_forces = rest_of_forces - part * sums
            steps.append(step)
            images.append(image)
            directions.append((rows, sums))
            triangle.append([*row, np.maximum(length, np.float32(1e-7))])
            parts.append(part)
            missed = np.sqrt(inner(rest, rest) + dot(rest_of_forces, rest_of_forces)) > tolerance
            if missed.sum() <= ABOVE * pool.size:
                break
        for i in range(len(parts) - 1, -1, -1):
            for j in range(i + 1, len(parts)):
                parts[i] = parts[i] - triangle[j][i] * parts[j]
            parts[i] = parts[i] / triangle[i][i]

        def combined(vectors: list[np.ndarray]) -> np.ndarray:
            return np.asarray(sum(map(np.multiply, parts, vectors)) * scale)

        return (
            combined(steps),
            combined(images),
            combined(rigids) if rigids else np.zeros(lacking.shape),
        )

    def step(self, pool: Pool, at: NaturalMap, tol: float) -> NaturalMap:
        """After one Newton step of every problem, with a line search on the norm of the natural
        map's residual.
        """
        system = self.linearised(pool, at)
        near = at.residual <= 30 * tol * at.size
        wanted = 0.3 * tol * at.size / np.maximum(at.residual, 1e-30)
        tolerance = np.clip(wanted, np.where(near, LATE_INNER, INNER), INNER)
        step, image, rigid = self._gcr(pool, system, at.lacking, tolerance)
        pool.rounding[...] += SINGLE * np.abs(step).max(axis=(0, 1, 2))
        image += self._rigid(rigid)
        length, todo = np.ones(pool.size, step.dtype), np.arange(pool.size)
        then = tried = self.natural(pool, slice(None), pool.traction + step, pool.shift + image)
        for part, shorter in pairwise(PARTS):
            todo = todo[~(tried.merit < (1 - 0.1 * part) * at.merit[todo])]
            if todo.size == 0:
                break
            traction, shift = pool.traction[..., todo], pool.shift[..., todo]
            tried = self.natural(
                pool, todo, traction + shorter * step[..., todo], shift + shorter * image[..., todo]
            )
            less = tried.merit < then.merit[todo]
            then.put(todo[less], tried.where(less))
            length[todo[less]] = shorter
        pool.traction[...] += length * step
        pool.shift[...] += length * image
        pool.rigid[...] += length * rigid
        pool.steps[...] += 1
        return then


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
    def of(cls, method: Method, pool: Pool, system: System) -> Border:
        free, per_element = pool.free.astype(np.float32), pool.per_element.astype(np.float32)
        fields = [system.free[c : c + 2] * free[c] for c in (0, 1)]
        columns = [each if method.scale32 is None else each * method.scale32 for each in fields]
        images = [method._precondition(pool, system, column) for column in columns]
        left = per_element * np.stack([method._sums(each) for each in images], 1) * free[:, None]
        left = left + (1 - free)[:, None] * np.eye(2, dtype=np.float32)[..., None]
        # 0 in full slip
        determinant = np.maximum(
            left[0, 0] * left[1, 1] - left[0, 1] * left[1, 0], np.float32(1e-6)
        )
        inverse = np.array([[left[1, 1], -left[0, 1]], [-left[1, 0], left[0, 0]]]) / determinant
        return cls(free, per_element, columns, images, inverse)

    def sums(self, method: Method, step: np.ndarray) -> np.ndarray:
        return self.per_element * method._sums(step) * self.free

    def corrected(
        self, method: Method, step: np.ndarray, lacking: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """A preconditioned step and the rigid shifts with which it has the forces that lack."""
        off = (self.sums(method, step) - lacking) * self.free
        rigid = self.inverse[:, 0] * off[0] + self.inverse[:, 1] * off[1]
        return step - rigid[0] * self.images[0] - rigid[1] * self.images[1], rigid
