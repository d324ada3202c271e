"""Pressure and tractions that depend on each other, friction on slip: passes
until a field stays, or Newton's method.

A fixed point that is approached slowly, or not at all, is accelerated by
Anderson's method. Source: D. G. Anderson, J. ACM 12 (1965) 547-560.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.residuals import residuals
from varcontact.discrete.state import ContactState
from varcontact.errors import Saturated, VarcontactError
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.coupled import CoupledProblem, newton_coupled

SLOW = 0.2
"""A pass that leaves more than this part of the residual is slow: from then on passes are
accelerated."""
HELD = 15
"""Accelerated passes in a row without gain after which passes stay plain: where two solutions have
just vanished, acceleration would hold them there."""
MEMORY = 6
"""Passes that the acceleration combines."""
PASSES_MAX = 1000
"""Passes of all loops together, those within others too: under a law unlike bodies have a loop in
each pass. Random scenes that converge take 25 at most (tests/random_scenes.py)."""


@dataclass(frozen=True)
class Limits:
    """When passes end, and from when on they may be accelerated.

    They end at the residual `tol`, after so many `passes`, or so many in a row without gain
    (`patience`). The first `plain` ones are accelerated only below the residual `near`; a force
    that friction cannot carry is an error in them. Accelerated values are kept from `least` to
    `greatest`.
    """

    tol: float
    passes: int = 100
    patience: int = 12
    plain: int = 0
    near: float = 0.0
    least: float = -np.inf
    greatest: float = np.inf


def settled(
    one: Callable[[ContactState], tuple[ContactState, float]],
    first: ContactState,
    residual: float,
    unknown: str,
    limits: Limits,
) -> ContactState:
    """The state of the least residual after passes `one` until the field `unknown` stays; its
    `passes` tell of all.

    They also end where solvers give up twice in a row with nothing gained, after `PASSES_MAX` in all
    loops, and with an error, as of an iterate that is no contact any more.
    """
    state = best = replace(first, passes=((1.0, residual),))
    lost = failures = held = 0
    accelerated = False
    given: list[np.ndarray] = []
    found: list[np.ndarray] = []
    while len(state.passes) < limits.passes and lost < limits.patience and failures < 2:
        before, least = state.passes, best.passes[-1][1]
        if least <= limits.tol or np.isnan(least) or state.pass_count >= PASSES_MAX:
            break
        try:
            after, residual = one(state)
        except VarcontactError as error:
            early = len(before) <= limits.plain and not accelerated
            of_law = getattr(error, "field", "").startswith("friction")
            if of_law or (early and isinstance(error, Saturated)):
                raise
            break
        given = [*given, state.unknown(unknown)][-MEMORY:]
        found = [*found, after.unknown(unknown)][-MEMORY:]
        passes = (*before, (distance(found[-1], given[-1]), residual))
        state = after = replace(after, passes=passes, pass_count=after.pass_count + 1)
        gained = residual < least
        best, lost = (after, 0) if gained else (best, lost + 1)
        failures = 0 if gained or all(after.solved.values()) else failures + 1
        changes = [after - before for after, before in zip(found, given, strict=True)]
        # a change against the one before, as under rising friction: no branch is lost then
        turns = len(changes) > 1 and float(np.sum(changes[-2] * changes[-1])) < 0
        ready = len(before) > limits.plain or residual < limits.near or turns
        held = 0 if gained and held < HELD else held + accelerated
        accelerated = held < HELD and (
            accelerated or (ready and not residual < SLOW * before[-1][1])
        )
        if accelerated:
            state = after.with_unknown(
                unknown, np.clip(_mixed(found, changes), limits.least, limits.greatest)
            )
    return replace(best, passes=state.passes, pass_count=state.pass_count)


def _mixed(found: list[np.ndarray], changes: list[np.ndarray]) -> np.ndarray:
    """The combination of found values for which the same combination of changes is smallest."""
    if len(found) == 1:
        return found[-1]
    columns = np.reshape(changes, (len(changes), -1))
    weights, *_ = np.linalg.lstsq(np.diff(columns, axis=0).T, columns[-1], rcond=1e-10)
    return np.asarray(found[-1] - np.tensordot(weights, np.diff(found, axis=0), axes=1))


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference of two fields by the largest of the first."""
    size, apart = float(np.abs(one).max()), float(np.abs(one - other).max())
    # of nothing, not beyond all numbers
    return apart / max(size, apart * np.finfo(float).eps, np.finfo(float).tiny)


def coupled_newton(
    disc: Discretisation, state: ContactState, settings: Settings
) -> tuple[Discretisation, ContactState]:
    """Pressure and tractions by one Newton's method, from tractions under a pressure; as they were
    where it fails.

    In conformal contact they bear the normal force along the normal of the plane, and the approach
    is then given.
    """
    tangential, loading = disc.tangential_problem(state.pressure), disc.loading
    if tangential.size == 0 or not np.any(state.traction):
        return disc, state
    chosen, operators = tangential.directions, disc.operators
    free = loading.normal_force is not None
    turned = free and disc.conformal and loading.law is None
    blocks = operators.normal, disc.tangential_operator.between(chosen, chosen)
    across = (
        operators.traction_to_distance.between((0,), chosen),
        disc.pressure_to_shift.between(chosen, (0,)),
    )
    problem = CoupledProblem(
        operator=type(blocks[0]).in_blocks([[blocks[0], across[0]], [across[1], blocks[1]]]),
        blocks=blocks,
        distance=(disc.distance - disc.base) / disc.scales.displacement,
        rigid_shift=disc.known_shift[list(chosen)],
        friction=np.broadcast_to(np.asarray(loading.coefficient, dtype=float), disc.grid.shape),
        area=disc.lattice.area,
        approach=None if free else state.approach,
        force=(
            None if loading.normal_force is None else loading.normal_force / disc.scales.force,
            *tangential.force,
        ),
        along_normal=disc.along_normal[[2, *chosen]] if turned else None,
    )

    def found(raw: RawSolution) -> ContactState:
        traction, rigid = np.zeros((2, *disc.grid.shape)), np.zeros(2)
        traction[list(chosen)], rigid[list(chosen)] = raw.traction[1:], raw.rigid[1:]
        approach = -float(raw.rigid[0]) if free else state.approach
        return replace(
            state, pressure=raw.traction[0], approach=approach, traction=traction, rigid=rigid
        )

    def residual(raw: RawSolution) -> float:
        there = found(raw)
        if not turned:
            return max(residuals(disc, there))
        excess = disc.excess_force(there.traction, there.pressure)
        return max(*residuals(disc.at_approach(there.approach), there), abs(excess))

    level = np.concatenate([[-state.approach if free else 0.0], state.rigid[list(chosen)]])
    fields = np.concatenate([state.pressure[None], state.traction[list(chosen)]])
    with settings.stats.called("newton"):
        raw = newton_coupled(problem, settings, RawSolution(fields, level, 0, "start"), residual)
        settings.stats.iterated("newton", raw.iterations)
    finite = raw.finite and np.any(raw.traction[0])
    better = finite and (raw.solved or (not turned and residual(raw) < max(residuals(disc, state))))
    iterations = {**state.iterations, "both": state.iterations.get("both", 0) + raw.iterations}
    state = replace(found(raw) if better else state, iterations=iterations)
    return (disc.at_approach(state.approach) if turned and better else disc), state
