"""Newton's method for the tangential problem, without a matrix.

With ``y = p - E`` the solution is ``p = Proj(y)``, the projection on the disk
(or interval) of the traction bound g. Where ``|y| <= g`` the element sticks,
and Newton's equation is ``M d = -E``. Elsewhere it slips: with n along y, t
across it, and ``held = g/|y|``, the equations are ``n.d = g - n.p`` and
``held t.(M d) + (1 - held) t.d = -t.p``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.residuals import gap, tangential_residual
from varcontact.elasticity.operators import RestrictedOperator
from varcontact.interfaces.potential import Flow, FlowDerivative, Potential, dot, magnitude, project
from varcontact.solvers.full_slip import full_slip
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton.driver import GridConditions, GridProblem, point, solve
from varcontact.solvers.newton.gcr import Forces, System
from varcontact.solvers.newton.globalisation import Point
from varcontact.solvers.newton.hierarchy import Box
from varcontact.solvers.newton.kernel import SoftenedKernel, product_and_plain, unit
from varcontact.system.process import lazy_property

QUANTILE = 0.6
"""Quantile of slip divided by the traction bound, in the slip area: the shift of its inverse."""
LEAST_SHIFT = 0.1
"""Least such shift."""
SLOPE_MAX = 1e8
"""Slip divided by the traction bound above which larger values make no difference."""
NEARLY_STICK = 1e-3
"""Slip divided by the bound below which the preconditioner treats an element as one that sticks."""


def newton_tangential(
    problem: TangentialProblem, settings: Settings, start: RawSolution | None = None
) -> RawSolution:
    """Solve the tangential problem by an inexact Newton method with products by FFT only.

    Memory is linear in the number of elements, and so, but for a small power, is the time.
    """
    assert type(problem.operator) is RestrictedOperator, "a table by offset has no half problems"
    scaled = scaled_tangential(problem)
    if isinstance(scaled, RawSolution):
        return scaled
    return full_slip(problem, settings, start) or solve(scaled, start, settings)


def scaled_tangential(problem: TangentialProblem) -> ScaledTangential | RawSolution:
    """Problem divided by its units, or its answer where nothing moves or the input is not
    finite.
    """
    still = RawSolution(
        np.zeros(problem.rigid_shift.shape), np.zeros(problem.components), 0, "Solved"
    )
    if not np.isfinite(problem.rigid_shift).all() or np.isnan(problem.bound).any():
        return replace(still, status="NotANumber", solved=False)
    return ScaledTangential.of(problem) or still


@dataclass(frozen=True, eq=False)
class TangentialConditions(GridConditions):
    """The tangential problem on a box: `known` is W (c, ny, nx), `bound` the traction bound g."""

    flow: Flow | None = None

    @property
    def linear(self) -> bool:
        return bool(np.isinf(self.bound[self.contact]).all())

    @property
    def coarsens(self) -> bool:
        return super().coarsens and self.flow is None

    def potential(self, trial: np.ndarray) -> Potential:
        """The potential under trial tractions (c, ny, nx), which may raise the threshold of its
        flow.
        """
        flow = self.flow
        if flow is not None:
            flow = flow.under(trial, self.bound)
        return Potential(self.bound, flow)

    def projected(self, trial: np.ndarray) -> np.ndarray:
        return self.proximal(trial, 1.0)

    def proximal(self, trial: np.ndarray, weight: float) -> np.ndarray:
        return self.potential(trial).projected(trial, weight)

    def sticks(self, trial: np.ndarray, weight: float) -> np.ndarray:
        return self.contact & ~self.potential(trial).slips(trial, weight)

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        return project(traction, self.bound)

    def sliding(self) -> Point | None:
        """Tractions at the bound against the rigid shift, if the shift exceeds the bound everywhere
        (in the problem's units) and all elements slip against them; else None.
        """
        size = magnitude(self.known)
        if self.forces.components or not np.all(size[self.contact] > self.bound[self.contact]):
            return None
        traction = -self.known * (self.bound / np.where(self.contact, size, 1.0))
        at = point(self, traction, np.zeros((len(traction), 1, 1)))
        if (dot(traction, at.shift) > 0).any():
            return None
        return at

    def linearised(
        self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray
    ) -> TangentialSystem:
        # areas, and directions along and across the trial tractions where it slips
        size = magnitude(trial)
        potential = self.potential(trial)
        slip = self.contact & (potential.sizes(size, 1.0) > self.bound)
        stick = self.contact & ~slip
        length = np.where(slip, size, 1.0)
        along = np.where(slip, trial / length, 0.0)
        across = np.array([-along[1], along[0]]) if len(along) == 2 else np.zeros_like(along)
        held = np.where(slip, np.maximum(self.bound / length, 1 / SLOPE_MAX), 1.0)
        with np.errstate(invalid="ignore"):  # inf * 0
            outward = np.where(slip, self.bound, 0.0) - dot(along, traction)
        right = np.where(stick, -shift, outward * along - dot(across, traction) * across)
        flow = potential.flow
        if self.flow is None or flow is None:
            return TangentialSystem(right, self, stick, along, across, held)
        # what flows where it sticks, linearised at the image of the trial tractions
        image = potential.projected(trial, 1.0)
        direction = trial / np.where(size > 0, size, 1.0)
        flow_along, flow_across = flow.tangent(image)
        derivative = FlowDerivative(
            self.flow.columns,
            (stick * flow_along).astype(np.float32),
            (stick * flow_across).astype(np.float32),
            direction.astype(np.float32),
            (magnitude(image) > flow.threshold).astype(np.float32),
        )
        flowed = stick * flow.shift(image) + derivative(traction - image)
        return TangentialSystem(right - flowed, self, stick, along, across, held, derivative)


@dataclass(frozen=True, eq=False)
class TangentialSystem(System):
    """Newton's equations at given tractions.

    `along` and `across` are unit vectors (c, ny, nx) of the traction where it slips, else zero;
    `held` (ny, nx) is the bound divided by the trial traction where it slips, else one. Out of
    contact a row is the step itself.
    """

    conditions: GridConditions
    stick: np.ndarray
    along: np.ndarray
    across: np.ndarray
    held: np.ndarray
    flows: FlowDerivative | None = None

    @lazy_property
    def _single(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unit vectors across slip, those times `held`, and those divided by it."""
        across = self.across.astype(np.float32)
        held = self.held.astype(np.float32)
        return across, across * held, across / held

    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        across, held_across, _ = self._single
        stuck = image if self.flows is None else image + self.flows(step)
        rows = np.where(self.stick, stuck, step)
        rows += dot(across, image - step) * held_across
        return rows

    def border(self, component: int) -> np.ndarray:
        across, held_across, _ = self._single
        rows = across[component] * held_across
        rows[component] += self.stick
        return rows * self.conditions.forces.scale

    def precondition(self, right: np.ndarray) -> np.ndarray:
        """Step by the blended inverses; along slipping tractions it is the right-hand side."""
        across, _, by_held = self._single
        turned = dot(across, right)
        step = self.blended(np.where(self.stick, right, turned * by_held))
        return np.where(self.stick, step, right + (dot(across, step) - turned) * across)

    def blended(self, free: np.ndarray) -> np.ndarray:
        """The two inverses of the circulant, blended by the slope, of free parts (c, ny, nx)."""
        inverses, weights, unweights = self._blend
        parts = self.conditions.plain.circulant.apply(inverses, free[:, None] * weights)
        return dot(parts.swapaxes(0, 1), unweights[:, None])

    @lazy_property
    def _blend(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Inverses (m, k, ...), and the weights (k, ny, nx) of the fields they are applied to and
        of the results.
        """
        contact = self.conditions.contact
        circulant = self.conditions.plain.circulant
        slope = 1 / self.held - 1
        if self.flows is not None:
            slope = slope + np.minimum((self.flows.along + self.flows.across) / 2, SLOPE_MAX)
        slip = slope > 0
        if not slip.any():
            weights = contact.astype(np.float32)[None]
            return circulant.stick[:, None], weights * circulant.growth, weights / circulant.growth
        place = int(QUANTILE * (np.count_nonzero(slip) - 1))
        shift = max(float(np.partition(slope[slip], place)[place]), LEAST_SHIFT)
        inverses = np.stack([circulant.stick, circulant.inverse(shift)], axis=1)
        part = np.log1p(np.minimum(slope, shift) / NEARLY_STICK) / np.log1p(shift / NEARLY_STICK)
        size = circulant.kernel.row_size
        steep = np.sqrt((size + shift) / (size + np.maximum(slope, shift))) * contact
        level = steep if circulant.rolling else np.sqrt((size + shift) / (size + slope)) * contact
        weights = np.array([np.sqrt(1 - part) * steep, np.sqrt(part) * level]).astype(np.float32)
        return inverses, weights * circulant.growth, weights / circulant.growth


@dataclass(frozen=True, eq=False)
class ScaledTangential(GridProblem[TangentialConditions]):
    """A tangential problem in its own units."""

    problem: TangentialProblem

    @classmethod
    def of(cls, problem: TangentialProblem) -> ScaledTangential | None:
        """The problem divided by its units; None where nothing moves, and no traction arises."""
        if problem.size == 0:
            return None
        own = unit(problem.operator.grid_operator)
        forces = [F for F in problem.force if F is not None]
        means = [abs(F) / (problem.area * problem.size) for F in forces]
        moved = max(float(np.abs(problem.rigid_shift).max()) / own, *means, 0.0)
        if moved == 0:
            return None
        load = min(moved, float(problem.bound.max()))
        displacement = own * load
        box = Box.around(problem.operator)
        # the operator, with softened edges
        softening = problem.operator.softening
        product, plain = product_and_plain(problem.operator, box.shape)
        scale: np.ndarray | float = 1.0
        if softening is not None:
            product = SoftenedKernel(product, (box.field(softening) / own).astype(np.float32))
            scale = product.scale.astype(float)
        # a flow within the bound
        flow = problem.potential.flow
        if flow is not None:
            contact = box.field(problem.bound) > 0
            threshold = np.where(contact, box.field(flow.threshold) / load, np.inf)
            hardening = flow.hardening * displacement / load
            flow = replace(flow, threshold=threshold, hardening=hardening)
        conditions = TangentialConditions(
            kernel=product,
            known=box.field(problem.rigid_shift) / displacement * scale,
            forces=Forces(
                components=tuple(problem.free),
                sums=np.array(forces) / (problem.area * load),
                weight=1 / np.sqrt(problem.size),
                scale=scale,
            ),
            bound=box.field(problem.bound) / load / scale,
            plain=plain,
            flow=flow,
        )
        return cls(conditions, problem, box, load, displacement)

    def error(self, at: Point) -> float:
        traction, rigid = self.physical(at.traction, at.rigid)
        shift = self.box.values(at.shift / self.conditions.forces.scale) * self.displacement
        residual = tangential_residual(self.problem, traction, rigid, shift)
        if self.problem.no_slip:
            return residual
        return max(residual, gap(self.problem, traction, rigid, shift)[1])
