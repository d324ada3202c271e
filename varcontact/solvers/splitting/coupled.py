"""Rounds for pressure and tractions of unlike bodies together.

The bounds of the tractions follow the pressure, so that this is a
quasi-variational inequality: a fixed point of a projection, and no theorem. The
candidates are those of the method for one problem, with all blocks of A in
products and circulant. What they find is an answer where each of the two
convex problems is solved with the other's fields; where they gain nothing they
end, and Panagiotopoulos's passes go on from the best of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from varcontact.discrete.problems import RawSolution
from varcontact.elasticity.operators import GridOperator
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.coupled import CoupledConditions, CoupledProblem, ScaledCoupled
from varcontact.solvers.newton.driver import NOISE_DOUBLE
from varcontact.solvers.newton.globalisation import Point
from varcontact.solvers.splitting.inequality import GAMMA_SLIDING, FixedPoint, tangential_gamma
from varcontact.solvers.splitting.method import rounds_to_goal
from varcontact.solvers.splitting.products import Applied, Circulant, Influence
from varcontact.solvers.splitting.projection import projected
from varcontact.system.process import lazy_property

GAMMA_PART = 0.8
"""Factor on the steps gamma of the two separate problems (fitted on eight scenes with 12 to 60
elements across: rounds within 8 % of the minimum)."""


def splitting_coupled(
    problem: CoupledProblem,
    settings: Settings,
    start: RawSolution,
    residual: Callable[[RawSolution], float],
) -> RawSolution:
    """Solve for pressure and tractions together, or come as near as rounds do.

    Start, answer and `residual` are those of `newton_coupled`.
    """
    scaled = ScaledCoupled.of(problem, start, residual)
    traction = start.traction / scaled.load
    rigid = np.reshape(start.rigid, (-1, 1, 1)) / scaled.displacement
    at = Point(traction, scaled.shift(traction, rigid), rigid, NOISE_DOUBLE)
    inequality = QuasiInequality(scaled, at)
    return rounds_to_goal(scaled, inequality, inequality.start(at), settings)


@dataclass(frozen=True, eq=False)
class CoupledProduct:
    """The blocks of A in units (1 + c, 1, 1) of tractions and of displacements."""

    operator: GridOperator
    load: np.ndarray
    displacement: np.ndarray

    def apply(self, field: np.ndarray) -> np.ndarray:
        scaled = field * self.load.astype(field.dtype)
        return self.operator.apply(scaled) / self.displacement.astype(field.dtype)


class QuasiInequality(FixedPoint):
    """The fixed point of pressure and tractions, with a step gamma for each."""

    conditions: CoupledConditions
    gamma: np.ndarray
    groups = (slice(0, 1), slice(1, None))

    def __init__(self, problem: ScaledCoupled, start: Point) -> None:
        operator = problem.problem.operator
        load = problem.load
        displacement = problem.displacement
        influence = Influence(operator.table * load / displacement[..., None])
        product: Applied = influence
        if not operator.toeplitz:
            product = CoupledProduct(operator, load, displacement)
        super().__init__(problem.conditions, product)
        self._influence = influence
        self._everywhere = np.broadcast_to(True, start.traction.shape[1:])
        # steps gamma, of the tractions by the share of elements that stick at the start
        tangential = self.conditions.under(start.traction[0])
        sticks = tangential.sticks(start.traction[1:] - start.shift[1:], 1.0)
        share = np.count_nonzero(sticks) / np.count_nonzero(tangential.contact)
        symmetric = not tangential.of_step
        self.gamma = np.full(load.shape, GAMMA_SLIDING)
        self.gamma[1:] = tangential_gamma(share, start.traction.shape[2], symmetric)
        self.gamma *= GAMMA_PART

    def projected(
        self, trial: np.ndarray, multipliers: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The projection of pressures, then of tractions within the bounds of these."""
        normal = self.conditions.normal
        of_pressure = len(normal.forces.components)
        gamma = self.gamma.ravel()
        pressure, level = projected(normal, gamma[0], trial[:1], multipliers[:of_pressure])
        under = self.conditions.under(pressure[0])
        traction, rigid = projected(under, gamma[1], trial[1:], multipliers[of_pressure:])
        return np.concatenate([pressure, traction]), np.concatenate([level, rigid])

    def inverse(self, field: np.ndarray) -> np.ndarray:
        return self._circulant.inverse(field, self._everywhere)

    @lazy_property
    def _circulant(self) -> Circulant:
        return self._influence.circulant(tuple(self.gamma.ravel().tolist()))
