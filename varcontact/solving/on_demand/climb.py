"""From grid to grid until an answer's own estimate meets what is asked for, or the time is up."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

from varcontact.errors import NotConverged, SceneError, TooCoarse, TooLarge
from varcontact.machine import memory
from varcontact.planning.costs import seconds_of
from varcontact.planning.memory import peak
from varcontact.planning.plan import Plan
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.settings import OutOfTime
from varcontact.solving.error_norm import semi_axes, units, values
from varcontact.solving.on_demand.asked import Asked
from varcontact.solving.on_demand.estimated import Answer, peaks_by_hertz, with_values
from varcontact.solving.on_demand.ladder import Ladder, ladder_of
from varcontact.solving.on_demand.severity import severity_of
from varcontact.solving.transient import bytes_of_steps

Progress = Callable[[str], None]
Solver = Callable[[Scene, Progress | None, bool, Solution | None, float], Answer]
"""Solves a scene as `solve` does, on its own grid; with the certificate asked for, or without one; from a solution on
another grid, if there is one; until a deadline."""

SHOWN = 25
"""Elements across a contact in closed form: an odd number has one at the largest pressure."""
COARSER = 0.35
"""Elements across the contact on the first of two grids, by those on the second."""
BESIDE = 0.5
"""The same for the best grid to extrapolate with, of all that were solved before the finest."""
LEAST_STEP, GREATEST_STEP = 1.2, 3.0
"""Elements across the contact on the next grid by those on the last one, at least and at most."""
LIKELY = 2.0
"""By how much the first step may exceed the usual one: a finer grid costs less than another one."""
SPARE = 1.05
"""How much finer it is than the order of the error asks for."""
WORTHWHILE = 1.5
"""The same where there is time left: a smaller gain is not worth another solve."""
USED = 0.7
"""Part of the time that two further grids may be expected to take: what is expected is true within a factor of 1.3."""
LATE = 1.3
"""A solve is given up when it has gone on for this many time budgets, and the answer before it is taken."""


@dataclass(frozen=True)
class Rung:
    """An answer on one grid of a ladder.

    Attributes
    ----------
    n : int
        Elements across the contact.
    answer : Solution or History
    values : dict of str to float
        As of `varcontact.solving.error_norm`.
    seconds : float
    """

    n: int
    answer: Answer
    values: dict[str, float]
    seconds: float


@dataclass(frozen=True)
class Climb:
    """A scene, what is asked for, and how its grids are solved.

    Attributes
    ----------
    scene : Scene
    plan : Plan
    asked : Asked
    ladder : Ladder
    solve : callable
        Solves a scene on a given grid.
    progress : callable, optional
        Told the grid, and the stages of its solution.
    rungs : list of Rung
        What has been solved, in this order.
    """

    scene: Scene
    plan: Plan
    asked: Asked
    ladder: Ladder
    solve: Solver
    progress: Progress | None
    rungs: list[Rung]

    def to_accuracy(self) -> Answer:
        """The answer on the first grid whose estimate is below the accuracy.

        Raises
        ------
        TooLarge
            If the accuracy is out of reach, before anything is solved.
        NotConverged
            If the answer's own estimate asks for more than fits into memory, or for a grid on which a solver misses its
            tolerance; it has the best answer.
        """
        accuracy = self.asked.accuracy
        assert accuracy is not None
        n = self.ladder.first(accuracy, self.severity(1 / COARSER), LIKELY)
        if not self._fits(n):
            raise self._out_of_reach(accuracy)
        self.on(self.ladder.coarser(n, COARSER), certified=False)
        before = n
        n = self.ladder.first(accuracy, self.severity(1 / COARSER), LIKELY)  # how severe it is may be known only now
        n = max(n if n == before or self._fits(n) else self.most(), math.ceil(WORTHWHILE * self.rungs[-1].n))
        while True:
            try:
                self.on(n)
            except NotConverged as error:
                if len(self.rungs) == 1:
                    raise
                raise self._not_reached(accuracy, f"the next grid, of {n} elements across, fails: {error}") from error
            answer = self.answer()
            estimated = _estimated(answer)
            if estimated <= accuracy:
                return answer
            step = (estimated / accuracy) ** (1 / self.ladder.law.order)
            n, before = math.ceil(n * min(max(SPARE * step, LEAST_STEP), GREATEST_STEP)), n
            if not self._fits(n):
                n = self.most()
                if before >= n / LEAST_STEP:
                    raise self._not_reached(accuracy, "a finer grid does not fit")

    def in_time(self) -> Answer:
        """The answer on the finest grid that is expected to be solved in time.

        Raises
        ------
        SceneError
            If not even the coarsest grid is: of a history with many steps.
        """
        assert self.asked.time_budget is not None
        begun, budget, most = time.perf_counter(), self.asked.time_budget, self.most()
        coarsest = self.ladder.coarsest
        self._begin(coarsest, begun, budget)
        n = math.ceil(self.rungs[-1].n * WORTHWHILE)
        try:
            while n <= most:
                self.on(n, until=begun + LATE * budget)
                n = self._finest(budget - (time.perf_counter() - begun))
                between = self.ladder.coarser(n, COARSER)
                if between >= WORTHWHILE * self.rungs[-1].n:
                    self.on(between, until=begun + LATE * budget)
                    n = min(n, self._finest(budget - (time.perf_counter() - begun)))  # expected from nearer there
                if n < WORTHWHILE * self.rungs[-1].n:
                    break
        except (OutOfTime, NotConverged):  # what there is counts
            pass
        return self.answer()

    def _begin(self, coarsest: int, begun: float, budget: float) -> None:
        """The first answer within a time: of a history only if its steps are done by then."""
        motion = self.scene.motion
        try:
            self.on(coarsest, until=begun + LATE * budget if isinstance(motion, Transient) else math.inf)
        except OutOfTime:
            message = (
                f"time_budget = {budget:g}: the steps of this history take longer even on the coarsest grid; "
                "give more time, or an accuracy, which has no limit of time"
            )
            raise SceneError("time_budget", budget, "more seconds", message=message) from None

    def closed_form(self) -> Answer:
        """Hertz's contact, which needs no grid."""
        self.on(SHOWN)
        fine = self.rungs[-1]
        best = fine.values | peaks_by_hertz(fine.answer)
        solves = (Solve(*_cells(fine.answer), fine.seconds),)
        how = "Hertz's pressure and approach are exact in the continuum"
        exact = dict.fromkeys(best, 0.0)
        return with_values(fine.answer, ErrorEstimate(best, exact, how, solves, *self._asked))

    def severity(self, finer: float = 1.0) -> float:
        """By how much its errors are larger than others', as far as that is known: before the first answer by Hertz.

        Parameters
        ----------
        finer : float
            By how many times the elements of the grid in question are shorter than those of the last one.
        """
        hertz, near = self.scene.hertz, _largest(self.rungs[-1].answer) if self.rungs else None
        if hertz is not None:
            axes: tuple[float, float] | None = (hertz.a, hertz.b)
        else:
            axes = None if near is None else semi_axes(near)
        return severity_of(self.scene, self.plan, axes, near, finer)

    @property
    def _asked(self) -> tuple[float | None, float | None]:
        return self.asked.accuracy, self.asked.time_budget

    def on(self, n: int, until: float = math.inf, certified: bool = True) -> None:
        """Add the answer on the grid with `n` elements across the contact, unless it is not there `until` then.

        Where it cannot be the last one, it need not be `certified`. Where a contact is too small for the
        grid, as in a step of a history with little load, it is a finer one.
        """
        if self.progress is not None:
            self.progress(f"{n} elements across the contact")

        def told(stage: str) -> None:
            if self.progress is not None:
                self.progress(f"{n} elements across the contact: {stage}")

        begun = time.perf_counter()
        heard = None if self.progress is None else told
        before = self.rungs[-1].answer if self.rungs else None
        near = before if isinstance(before, Solution) else None
        found, others = None, 1
        while found is None:
            try:
                found = self.solve(self.ladder.posed(self.scene, n), heard, certified, near, until)
            except NotConverged:  # where a lattice does not, another usually does
                if others == 0:
                    raise
                n, others = n + math.ceil(n / 20), others - 1
            except TooCoarse:
                if WORTHWHILE * n > self.most():
                    raise
                n = math.ceil(WORTHWHILE * n)
        taken = time.perf_counter() - begun
        self.rungs.append(Rung(n, found, values(found), taken))

    def answer(self) -> Answer:
        """The answer on the finest grid so far, its values extrapolated, with the estimate of their errors."""
        fine, law, severity = self.rungs[-1], self.ladder.law, self.severity()
        solves = tuple(Solve(*_cells(rung.answer), rung.seconds) for rung in self.rungs)
        if len(self.rungs) == 1:
            errors = {name: law.alone(fine.n, severity) for name in fine.values}
            how = f"by the usual error on {fine.n} elements across the contact: there was no time for a second grid"
            best = fine.values
        else:
            coarse = min(self.rungs[:-1], key=lambda rung: abs(math.log(rung.n / (BESIDE * fine.n))))
            part = 1 / ((fine.n / coarse.n) ** law.order - 1)
            steps = {name: (value - coarse.values[name]) * part for name, value in fine.values.items()}
            per = units(fine.answer)
            errors = {name: law.error(step / per[name], fine.n, severity) for name, step in steps.items()}
            best = {name: value + law.taken * steps[name] for name, value in fine.values.items()}
            how = (
                f"{law.share:g} times the step to the extrapolated value, and {law.remainder(fine.n, severity):.1e} "
                f"(measured on {self.ladder.name}); extrapolated with order {law.order:g} "
                f"from {coarse.n} and {fine.n} elements across the contact"
            )
            if law.taken < 1:
                how += f", and {law.taken:.0%} of that step taken"
        return with_values(fine.answer, ErrorEstimate(best, errors, how, solves, *self._asked, fine.values))

    def _fits(self, n: int) -> bool:
        """Whether so many elements across the contact fit into memory: into half of it."""
        return memory.fits(2 * self._bytes(n))

    def most(self) -> int:
        """Most elements across the contact that fit into memory."""
        left, n = memory.available() / 2, 2**20
        while n > self.ladder.coarsest and self._bytes(n) > left:
            n = int(n / 1.1)
        return n

    def _bytes(self, n: int) -> float:
        elements = self.ladder.elements(n)
        needed = 0.0 if self.plan.closed_form else peak(self.plan.normal, "", elements)
        tangential = peak(self.plan.tangential, self.plan.formulation, 2 * elements) if self.plan.rubs else 0.0
        motion = self.scene.motion
        kept = bytes_of_steps(motion, elements) if isinstance(motion, Transient) else 0.0
        return max(needed, tangential) + 2 * kept

    def _finest(self, left: float) -> int:
        """Elements across the contact on the finest of two more grids that are expected to be solved in time."""
        last = self.rungs[-1]
        n, most = last.n, self.most()
        by_law = last.seconds / self._law(last.n)
        while n < most and by_law * (self._law(n) + self._law(n * COARSER)) < USED * left:
            n = math.ceil(1.1 * n)
        return n

    def _law(self, n: float) -> float:
        """Seconds on a grid with `n` elements across the contact, by the measured law, for their ratios."""
        method = self.plan.tangential if self.plan.rubs else self.plan.normal
        known = seconds_of(method, self.plan.formulation, self.ladder.elements(n))
        return 0.01 + 1e-5 * self.ladder.elements(n) ** 1.1 if known is None else known

    def _out_of_reach(self, accuracy: float) -> TooLarge:
        severity = self.severity(1 / COARSER)
        n, reached = self.ladder.first(accuracy, severity), self.ladder.law.expected(self.most(), severity)
        fits = f"accuracy = {reached:.2g} fits"
        return TooLarge(f"accuracy = {accuracy:g}", self._bytes(n), memory.available() / 2, fits)

    def _not_reached(self, accuracy: float, why: str) -> NotConverged:
        answer = self.answer()
        reached = _estimated(answer)
        return NotConverged(
            f"accuracy = {accuracy:g} is not reached: the estimate is {reached:.2g}, and {why}", reached, answer
        )


def _estimated(answer: Answer) -> float:
    """The largest error that is estimated."""
    estimate = answer.error_estimate
    assert estimate is not None
    return estimate.largest


def _largest(answer: Answer) -> Solution:
    """The solution, or that step of a history which has the largest contact."""
    return max(answer, key=lambda sol: sol.areas["contact"]) if isinstance(answer, History) else answer


def _cells(answer: Answer) -> tuple[int, int]:
    return answer.grid.nx, answer.grid.rows


def on_demand(scene: Scene, plan: Plan, asked: Asked, solve: Solver, progress: Progress | None = None) -> Answer:
    """Solve a scene to an accuracy, or within a time.

    Parameters
    ----------
    scene : Scene
        Without a grid of its own.
    plan : Plan
    asked : Asked
    solve : callable
        Solves the scene on a given grid.
    progress : callable, optional

    Returns
    -------
    Solution or History
        On the finest grid that was solved, with its `error_estimate`.

    Raises
    ------
    TooLarge
        If the accuracy is out of reach, before anything is solved.
    NotConverged
        If it turns out to be, or a solver misses its tolerance.
    """
    climb = Climb(scene, plan, asked, ladder_of(scene, plan), solve, progress, [])
    if plan.closed_form and not plan.rubs:
        return climb.closed_form()
    return climb.in_time() if asked.accuracy is None else climb.to_accuracy()
