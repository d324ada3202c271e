"""Newton's method for pressure and tractions of unlike bodies together, on their areas, by dense
matrices: as of `solvers.newton.coupled`, for few elements.

On given areas the deformed distance is zero in contact, the local shift where it sticks, and along
the traction where it slips; tractions that slip are ``f p`` in their direction. Unknowns: the
pressures in contact, the components of the traction where it sticks, its direction where it slips,
the approach and the rigid shifts whose forces are prescribed. In line contact the equations are
linear, and one step on the right areas is exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.interfaces.potential import dot, magnitude, project
from varcontact.solvers.interface import Settings, check_time
from varcontact.solvers.newton.coupled import CoupledProblem
from varcontact.system.process import changed, interruptible, lazy_property

MAX_STEPS = 25
"""Largest number of Newton steps; harder problems are left to alternating solves. Most random
scenes take 2 to 8."""
STEP_PARTS = (1.0, 0.5, 0.25, 0.1)
"""Parts of a Newton step that the line search tries in turn."""
MAX_IDLE_STEPS = 5
"""Newton steps without a smaller residual after which the search ends."""
JUDGED_BELOW = 1e-6
"""Residual below which an iterate is evaluated as an answer, which costs a third of a step."""


def active_set_coupled(
    problem: CoupledProblem,
    settings: Settings,
    start: RawSolution,
    residual: Callable[[RawSolution], float],
) -> RawSolution:
    """Solve for pressure and tractions together by Newton steps with the areas renewed after each.

    Start, answer and `residual` are those of `newton_coupled`.
    """
    fields = start.traction.reshape(len(start.traction), -1)
    weights = _weights(problem, fields[0].nonzero()[0])
    iterate = _Iterate.of(problem, weights, fields, start.rigid)
    best = iterate
    # first on the contact area of the start, to which the tractions belong
    iterate = changed(iterate, trial=np.concatenate([fields[:1], iterate.trial[1:]]))
    count = 0
    idle = 0
    while count < MAX_STEPS and idle < MAX_IDLE_STEPS:
        check_time(settings.deadline)
        count += 1
        after = _line_search(iterate)
        if after is None:
            break
        iterate = after
        idle += 1
        if iterate.merit < best.merit:
            best = iterate
            idle = 0
        if iterate.merit <= JUDGED_BELOW:
            answer = iterate.answer(count, "Solved", True)
            measured = residual(answer)
            if measured <= settings.tol:
                return changed(answer, residual=measured)
    return best.answer(count, "MaxIterations", False)


def _weights(problem: CoupledProblem, contact: np.ndarray) -> np.ndarray:
    """Weights of the natural map (1 + c, 1): as TANG's, the sizes of rows between elements in
    contact.
    """
    normal, tangential = (block.on(contact).row_size for block in problem.blocks)
    return np.array([[normal], *(len(problem.rigid_shift) * [[tangential]])])


@dataclass(frozen=True, eq=False)
class _Iterate:
    """Pressure and tractions (1 + c, n), the trial fields ``p - E/rho`` of the natural map, and its
    residual relative to the largest pressure and the largest bound, as a Euclidean norm.
    """

    problem: CoupledProblem
    weights: np.ndarray
    fields: np.ndarray
    rigid: np.ndarray
    trial: np.ndarray
    merit: float

    @classmethod
    def of(
        cls, problem: CoupledProblem, weights: np.ndarray, fields: np.ndarray, rigid: np.ndarray
    ) -> _Iterate:
        on_grid = problem.shift(fields.reshape(-1, *problem.distance.shape))
        shift = on_grid.reshape(fields.shape) + rigid[:, None]
        trial = fields - shift / weights
        pressure = np.maximum(trial[0], 0.0)
        bound = problem.friction.ravel() * pressure
        of_pressure = (fields[0] - pressure) / (pressure.max() or 1.0)
        of_traction = (fields[1:] - project(trial[1:], bound)) / (bound.max() or 1.0)
        merit = math.sqrt(np.vdot(of_pressure, of_pressure) + np.vdot(of_traction, of_traction))
        return cls(problem, weights, fields, rigid, trial, merit)

    def answer(self, count: int, status: str, solved: bool) -> RawSolution:
        pressure = np.maximum(self.fields[0], 0.0)
        traction = project(self.fields[1:], self.problem.friction.ravel() * pressure)
        fields = np.concatenate([pressure[None], traction])
        shape = self.problem.distance.shape
        return RawSolution(fields.reshape(-1, *shape), self.rigid, count, status, solved)


@dataclass(frozen=True, eq=False)
class _Areas:
    """The fields (1 + c, n) of an iterate on its areas: places of m elements in contact, those of
    them that stick, and those that slip, with unit vectors along their tractions (c, s).

    `turning`: those that slip, where there are two components; else none.
    """

    iterate: _Iterate
    fields: np.ndarray
    contact: np.ndarray
    stick: np.ndarray
    slip: np.ndarray
    turning: np.ndarray
    along: np.ndarray

    @classmethod
    def of(cls, iterate: _Iterate) -> _Areas:
        problem = iterate.problem
        trial = iterate.trial
        (contact,) = (trial[0] > 0).nonzero()
        friction = problem.friction.ravel()[contact]
        size = magnitude(trial[1:, contact])
        slips = size > friction * trial[0, contact]
        (slip,) = slips.nonzero()
        (stick,) = (~slips).nonzero()
        along = trial[1:, contact[slip]] / size[slip]
        fields = np.zeros_like(iterate.fields)
        fields[:, contact] = iterate.fields[:, contact]
        fields[1:, contact[slip]] = friction[slip] * fields[0, contact[slip]] * along
        turning = slip
        if len(along) == 1:
            turning = slip[:0]
        return cls(iterate, fields, contact, stick, slip, turning, along)

    @property
    def problem(self) -> CoupledProblem:
        return self.iterate.problem

    @lazy_property
    def friction(self) -> np.ndarray:
        """Coefficients of friction of the slipping elements (s,)."""
        return np.asarray(self.problem.friction.ravel()[self.contact[self.slip]])

    @lazy_property
    def ratio(self) -> np.ndarray:
        """Tractions that slip, relative to their pressures (c, m); zero where it sticks."""
        ratio = np.zeros((len(self.along), self.contact.size))
        ratio[:, self.slip] = self.friction * self.along
        return ratio

    @lazy_property
    def across(self) -> np.ndarray:
        """Unit vectors across the tractions that turn (c, t)."""
        across = self.along[::-1, : self.turning.size].copy()
        across[0] *= -1
        return across

    @lazy_property
    def bound(self) -> np.ndarray:
        """The traction bound where tractions turn (t,)."""
        pressure = self.fields[0, self.contact[self.turning]]
        return np.asarray(self.friction[: self.turning.size] * pressure)

    def moved(self, step: np.ndarray, part: float) -> _Iterate:
        """A part of a step, turning the tractions that slip on the bound of their pressures."""
        c = len(self.along)
        m = self.contact.size
        turned = m + c * self.stick.size
        end = turned + self.turning.size
        step = part * step
        own = self.fields[:, self.contact]
        own[0] += step[:m]
        own[1:, self.stick] += step[m:turned].reshape(c, -1)
        angles = step[turned:end]
        direction = self.along
        if angles.size:
            direction = np.cos(angles) * direction + np.sin(angles) * self.across
        own[1:, self.slip] = self.friction * own[0, self.slip] * direction
        fields = np.zeros_like(self.fields)
        fields[:, self.contact] = own
        rigid = self.iterate.rigid.copy()
        rigid[_free(self.problem)] += step[end:]
        return _Iterate.of(self.problem, self.iterate.weights, fields, rigid)

    def step(self) -> np.ndarray | None:
        """Newton's step: changes of the pressures, of the tractions that stick, of the directions
        of those that turn, of the rigid shifts; None where the equations are singular, or nothing
        is in contact.
        """
        from scipy.linalg.lapack import dgesv

        if not self.contact.size:
            return None
        matrix, error = self._equations()
        bordered, lacking = self._with_forces(matrix)
        right = np.concatenate([-error, lacking])
        *_, step, singular = interruptible(
            lambda: dgesv(bordered, right, overwrite_a=True), len(right)
        )
        if singular or not np.isfinite(step).all():
            return None
        return np.asarray(step)

    def _equations(self) -> tuple[np.ndarray, np.ndarray]:
        """Matrix and errors of the distance in contact, of the shift that sticks, and of that
        across the tractions that turn.
        """
        c = len(self.along)
        h = self.stick.size
        T = self.turning
        moving = self.contact[np.concatenate([self.stick, T])]
        distances = self._displacements((0,), self.contact)[0]
        shifts = self._displacements(tuple(range(1, 1 + c)), moving)
        # errors, by the present unknowns
        own = self.fields[:, self.contact]
        unknowns = np.concatenate([own[0], own[1:, self.stick].ravel(), np.zeros(T.size)])
        known = self.problem.known.reshape(self.fields.shape) + self.iterate.rigid[:, None]
        distance = known[0, self.contact] + distances @ unknowns
        shift = known[1:, moving] + shifts @ unknowns
        matrix = [distances, *shifts[:, :h]]
        error = [distance, *shift[:, :h]]
        if T.size:
            # across the tractions, which turn themselves
            across = dot(self.across[:, :, None], shifts[:, h:])
            angles = unknowns.size - T.size + np.arange(T.size)
            across[np.arange(T.size), angles] += magnitude(shift[:, h:])
            matrix.append(across)
            error.append(dot(self.across, shift[:, h:]))
        return np.concatenate(matrix), np.concatenate(error)

    def _displacements(self, directions: tuple[int, ...], elements: np.ndarray) -> np.ndarray:
        """Displacements along some directions in n elements by each unknown (directions, n,
        unknowns).
        """
        c = len(self.along)
        operator = self.problem.operator.between(directions, tuple(range(1 + c)))
        blocks = operator.dense(elements, self.contact)
        blocks = blocks.reshape(len(directions), elements.size, 1 + c, self.contact.size)
        # by pressures, with the tractions on their bound
        by_pressure = blocks[:, :, 0]
        by_stick = []
        by_angle = np.zeros((*by_pressure.shape[:2], self.turning.size))
        for i in range(c):
            by_traction = blocks[:, :, 1 + i]
            by_pressure += by_traction * self.ratio[i]
            by_stick.append(by_traction.take(self.stick, axis=2))
            if self.turning.size:
                change = self.bound * self.across[i]
                by_angle += by_traction.take(self.turning, axis=2) * change
        return np.concatenate([by_pressure, *by_stick, by_angle], axis=2)

    def _with_forces(self, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The matrix with columns of the unknown rigid shifts and rows of the prescribed forces, as
        sums of fields; what these lack.
        """
        free = _free(self.problem)
        m = self.contact.size
        h = self.stick.size
        k = len(matrix)
        angles = slice(k - self.turning.size, k)
        bordered = np.zeros((k + len(free), k + len(free)), order="F")  # as LAPACK takes it
        bordered[:k, :k] = matrix
        lacking = np.zeros(len(free))
        for place, field in enumerate(free):
            force = self.problem.force[field]
            assert force is not None
            lacking[place] = force / self.problem.area - self.fields[field].sum()
            if field == 0:
                bordered[:m, k] = 1.0
                bordered[k, :m] = 1.0
                continue
            component = field - 1
            sticking = slice(m + component * h, m + field * h)
            bordered[sticking, k + place] = 1.0
            bordered[k + place, sticking] = 1.0
            bordered[k + place, :m] = self.ratio[component]
            bordered[angles, k + place] = self.across[component]
            bordered[k + place, angles] = self.bound * self.across[component]
        return bordered, lacking


def _free(problem: CoupledProblem) -> list[int]:
    """The fields whose force is prescribed."""
    return [i for i, force in enumerate(problem.force) if force is not None]


def _line_search(iterate: _Iterate) -> _Iterate | None:
    """The first part of a Newton step that lowers the residual enough, or the best of all; None
    where there is no step.
    """
    areas = _Areas.of(iterate)
    step = areas.step()
    if step is None:
        return None
    best: _Iterate | None = None
    for part in STEP_PARTS:
        candidate = areas.moved(step, part)
        if best is None or candidate.merit < best.merit:
            best = candidate
        if best.merit < (1 - 0.1 * part) * iterate.merit:
            break
    return best
