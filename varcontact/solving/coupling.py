"""Pressure and tractions that depend on each other, friction on slip: passes
until a field stays, or one solver for both.

A fixed point that is approached slowly, or not at all, is accelerated by
Anderson's method. Source: D. G. Anderson, J. ACM 12 (1965) 547-560.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.residuals import residuals
from varcontact.discrete.state import ContactState
from varcontact.errors import Saturated, SceneError, VarcontactError
from varcontact.solvers.interface import Settings
from varcontact.system.process import changed

if TYPE_CHECKING:
    from varcontact.solvers.newton.coupled import CoupledProblem

SLOW_PASS = 0.2
"""Ratio of residuals above which a pass is slow: passes are then accelerated."""
VAIN_PASSES_MAX = 15
"""Accelerated passes in a row without gain after which acceleration stops: where two solutions have
just vanished, it would keep the iterate there."""
MEMORY = 6
"""Passes that the acceleration combines."""
PASSES_MAX = 1000
"""Passes of all nested loops together: under a law, unlike bodies have a loop in each pass. Random
scenes that converge take at most 25 (tests/random_scenes.py)."""


@dataclass(frozen=True)
class Limits:
    """When passes end, and from when on they may be accelerated.

    They end at the residual `tol`, after so many `passes`, or so many in a row without gain
    (`patience`). The first `plain` ones are accelerated only below the residual `near`; a force
    that friction cannot carry is an error in them. Accelerated values are kept `within` the limits
    of their field.
    """

    tol: float
    passes: int = 100
    patience: int = 12
    plain: int = 0
    near: float = 0.0
    within: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def of(self, name: str) -> tuple[float, float]:
        """The least and the greatest value of a field."""
        return self.within.get(name, (-np.inf, np.inf))


OuterIteration = Callable[[ContactState], tuple[ContactState, float]]
"""A pass: the state after another one, and its residual."""


@dataclass
class _Acceleration:
    """Anderson's combination of the last passes, and whether it is in use.

    `starts` and `ends`: the values of the unknown that the last passes began with and gave. `vain`:
    accelerated passes in a row without gain.
    """

    limits: Limits
    starts: list[np.ndarray] = field(default_factory=list)
    ends: list[np.ndarray] = field(default_factory=list)
    active: bool = False
    vain: int = 0

    def add(self, start: np.ndarray, end: np.ndarray) -> None:
        self.starts = [*self.starts, start][-MEMORY:]
        self.ends = [*self.ends, end][-MEMORY:]

    @property
    def changes(self) -> list[np.ndarray]:
        return [end - start for start, end in zip(self.starts, self.ends, strict=True)]

    def decide(self, number: int, residual: float, before: float, gained: bool) -> None:
        """Start or stop the acceleration after a pass with this number, residual and previous
        residual.
        """
        changes = self.changes
        # a change opposite to the previous one, as with rising friction: no branch can be lost then
        turns = len(changes) > 1 and float(np.sum(changes[-2] * changes[-1])) < 0
        ready = number > self.limits.plain or residual < self.limits.near or turns
        if gained and self.vain < VAIN_PASSES_MAX:
            self.vain = 0
        elif self.active:
            self.vain += 1
        if ready and not residual < SLOW_PASS * before:
            self.active = True
        if self.vain >= VAIN_PASSES_MAX:
            self.active = False

    def next_start(self) -> np.ndarray:
        """Combination of values for which the same combination of changes is smallest
        (Anderson).
        """
        ends = self.ends
        if len(ends) == 1:
            mixed = ends[-1]
        else:
            columns = np.reshape(self.changes, (len(ends), -1))
            differences = np.diff(columns, axis=0).T
            weights, *_ = np.linalg.lstsq(differences, columns[-1], rcond=1e-10)
            mixed = ends[-1] - np.tensordot(weights, np.diff(ends, axis=0), axes=1)
        return mixed


@dataclass(frozen=True, eq=False)
class _Unknown:
    """Unknown of the passes: one field of the contact or of its interfaces, or several in one
    vector, each divided by its largest value.
    """

    names: tuple[str, ...]
    scales: tuple[float, ...]

    @classmethod
    def of(cls, state: ContactState, names: tuple[str, ...]) -> _Unknown:
        if len(names) == 1:
            return cls(names, (1.0,))
        largest = (float(np.abs(_field(state, name)).max()) for name in names)
        return cls(names, tuple(each or 1.0 for each in largest))

    def value(self, state: ContactState) -> np.ndarray:
        fields = [_field(state, name) for name in self.names]
        if len(fields) == 1:
            return fields[0]
        scaled = (each.ravel() / scale for each, scale in zip(fields, self.scales, strict=True))
        return np.concatenate(list(scaled))

    def put(self, state: ContactState, value: np.ndarray, limits: Limits) -> ContactState:
        """The state with a value of the unknown, within the limits of each field."""
        sizes = [_field(state, name).size for name in self.names]
        parts = np.split(value.ravel(), np.cumsum(sizes)[:-1])
        for name, scale, part in zip(self.names, self.scales, parts, strict=True):
            least, greatest = limits.of(name)
            shape = _field(state, name).shape
            values = np.clip(part.reshape(shape) * scale, least, greatest)
            if name in state.fields:
                state = state.under({name: values})
            else:
                update: dict[str, Any] = {name: values}
                state = replace(state, **update)
        return state


def _field(state: ContactState, name: str) -> np.ndarray:
    if name in state.fields:
        return np.asarray(state.fields[name])
    return np.asarray(getattr(state, name))


def fixed_point(
    outer_iteration: OuterIteration,
    first: ContactState,
    residual: float,
    names: tuple[str, ...],
    limits: Limits,
) -> ContactState:
    """The state of the least residual after passes until the fields of these names stay; its
    `passes` are the record of all.

    They also end where solvers give up twice in a row with nothing gained, after `PASSES_MAX` in
    all loops, and with an error, as of an iterate that is no contact any more.
    """
    state = best = changed(first, passes=((1.0, residual),))
    without_gain = 0
    failures = 0
    unknown = _Unknown.of(first, names)
    acceleration = _Acceleration(limits)
    while len(state.passes) < limits.passes and without_gain < limits.patience and failures < 2:
        before = state.passes
        least = best.passes[-1][1]
        if least <= limits.tol or np.isnan(least) or state.pass_count >= PASSES_MAX:
            break

        # a pass
        try:
            after, residual = outer_iteration(state)
        except VarcontactError as error:
            early = len(before) <= limits.plain and not acceleration.active
            if _stops_all(error, early):
                raise
            break
        start = unknown.value(state)
        end = unknown.value(after)
        passes = (*before, (distance(end, start), residual))
        after = changed(after, passes=passes, pass_count=after.pass_count + 1)

        # its gain
        gained = residual < least
        without_gain += 1
        failures += 1
        if gained:
            best = after
            without_gain = 0
        if gained or all(after.solved.values()):
            failures = 0

        # the start of the next
        state = after
        acceleration.add(start, end)
        acceleration.decide(len(before), residual, before[-1][1], gained)
        if acceleration.active:
            state = unknown.put(after, acceleration.next_start(), limits)
    return changed(best, passes=state.passes, pass_count=state.pass_count)


def _stops_all(error: VarcontactError, early: bool) -> bool:
    """True for errors of the friction law, and in early passes for a force that friction cannot
    carry.
    """
    of_friction = isinstance(error, SceneError) and error.field.startswith("friction")
    return of_friction or (early and isinstance(error, Saturated))


def distance(values: np.ndarray, other: np.ndarray) -> float:
    """Largest difference of two fields, relative to the largest value of the first."""
    size = float(np.abs(values).max())
    difference = float(np.abs(values - other).max())
    # of nothing, not beyond all numbers
    return difference / max(size, difference * np.finfo(float).eps, np.finfo(float).tiny)


def solve_at_once(
    disc: Discretisation, state: ContactState, solver: str, settings: Settings
) -> tuple[Discretisation, ContactState, float]:
    """Pressure and tractions by a solver for both at once (`AT_ONCE`), from tractions under a
    pressure; as they were where it fails. Their residual, or NaN where it was not measured.

    Where tractions carry a part of the normal force, Newton's method gives the approach; others let
    pressures alone carry it.
    """
    tangential = disc.tangential_problem(state.pressure)
    if tangential.size == 0 or not state.traction.any():
        return disc, state, math.nan
    directions = list(tangential.directions)
    force_prescribed = disc.loading.normal_force is not None
    in_normal_force = _in_normal_force(disc, solver)
    mixed = in_normal_force is not None

    def state_of(raw: RawSolution) -> ContactState:
        traction = np.zeros((2, *disc.grid.shape))
        traction[directions] = raw.traction[1:]
        rigid = np.zeros(2)
        rigid[directions] = raw.rigid[1:]
        approach = -float(raw.rigid[0]) if force_prescribed else state.approach
        return replace(
            state, pressure=raw.traction[0], approach=approach, traction=traction, rigid=rigid
        )

    def residual(raw: RawSolution) -> float:
        iterate = state_of(raw)
        if not mixed:
            return max(residuals(disc, iterate))
        excess = disc.excess_force(iterate.traction, iterate.pressure)
        return max(*residuals(disc.at_approach(iterate.approach), iterate), abs(excess))

    # pressure and tractions together, from those of the state
    problem = _coupled_problem(disc, tangential, state.approach, in_normal_force)
    level = -state.approach if force_prescribed else 0.0
    fields = np.concatenate([state.pressure[None], state.traction[directions]])
    start = RawSolution(fields, np.concatenate([[level], state.rigid[directions]]), 0, "start")
    with settings.stats.called(solver):
        raw = _solver_of_both(solver)(problem, settings, start, residual)
        settings.stats.iterated(solver, raw.iterations)

    # kept where they are better
    iterations = {**state.iterations, "both": state.iterations.get("both", 0) + raw.iterations}
    better = raw.finite and bool(raw.traction[0].any())
    if better and not raw.solved:
        better = not mixed and residual(raw) < max(residuals(disc, state))
    if not better:
        return disc, replace(state, iterations=iterations), math.nan
    state = replace(
        state_of(raw),
        iterations=iterations,
        status={**state.status, "tangential": raw.status},
        solved={**state.solved, "tangential": raw.solved},
        solved_by={**state.solved_by, "tangential": solver},
    )
    if mixed:
        disc = disc.at_approach(state.approach)
    return disc, state, raw.residual


def _in_normal_force(disc: Discretisation, solver: str) -> np.ndarray | None:
    """Parts of tractions and pressures in a prescribed normal force, (3, ny, nx); None where
    pressures alone carry it, as by splitting, or with fields that follow from slip.
    """
    if solver != "newton" or disc.loading.normal_force is None or disc.sought(by_slip=True):
        return None
    return disc.in_normal_force


def _solver_of_both(name: str) -> Callable[..., RawSolution]:
    """The solver of pressure and tractions together, imported when it is called for."""
    if name == "newton":
        from varcontact.solvers.newton.coupled import newton_coupled

        return newton_coupled
    if name == "active-set":
        from varcontact.solvers.active_set.coupled import active_set_coupled

        return active_set_coupled
    from varcontact.solvers.splitting.coupled import splitting_coupled

    return splitting_coupled


def _coupled_problem(
    disc: Discretisation,
    tangential: TangentialProblem,
    approach: float,
    in_normal_force: np.ndarray | None,
) -> CoupledProblem:
    """The problem of pressure and tractions in the directions of the tangential problem, at the
    approach where no force is prescribed.
    """
    from varcontact.solvers.newton.coupled import CoupledProblem

    directions = tangential.directions
    operators = disc.operators
    if in_normal_force is not None:
        in_normal_force = in_normal_force[[2, *directions]]
    normal_force = None
    if disc.loading.normal_force is not None:
        normal_force = disc.loading.normal_force / disc.scales.force
    blocks = operators.normal, disc.tangential_operator.between(directions, directions)
    across = (
        operators.traction_to_distance.between((0,), directions),
        disc.pressure_to_shift.between(directions, (0,)),
    )
    coefficient = np.asarray(disc.coefficient, dtype=float)
    return CoupledProblem(
        operator=type(blocks[0]).in_blocks([[blocks[0], across[0]], [across[1], blocks[1]]]),
        blocks=blocks,
        distance=(disc.distance - disc.base) / disc.scales.displacement,
        rigid_shift=disc.known_shift[list(directions)],
        friction=np.broadcast_to(coefficient, disc.grid.shape),
        area=disc.lattice.area,
        approach=approach if normal_force is None else None,
        force=(normal_force, *tangential.force),
        in_normal_force=in_normal_force,
    )
