"""The tangential problem on a box of elements: its natural map, and Newton's equations for that.

With ``y = p - E`` the solution is ``p = Proj(y)``, the projection on the disk (or interval) of the traction bound g.
Where ``|y| <= g`` the element sticks, and Newton's equation is ``M d = -E``. Elsewhere it slips: with n along y, t
across it, and ``held = g/|y|``, the equations are ``n.d = g - n.p`` and ``held t.(M d) + (1 - held) t.d = -t.p``.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.solvers.newton.kernel import Kernel, SoftenedKernel
from varcontact.solvers.newton.krylov import Forces, Step
from varcontact.solvers.newton.preconditioner import Circulant

QUANTILE = 0.6
"""Of slip by the traction bound in the slip area: the shift of its inverse."""
LEAST_SHIFT, APART = 0.1, 0.4
"""Least such shift, and how far apart in logarithms those are for which there are inverses."""
STEEP = 1e8
"""Slip by the traction bound that no larger one differs from."""
NEARLY_STICK = 1e-3
"""Slip by the bound below which the preconditioner takes an element for one that sticks."""
FAR, FARTHEST = 0.3, 1.2
"""Angles of slip tractions: from the first they are turned on their bound, by the second at most."""


@dataclass(frozen=True, eq=False)
class TangentialConditions:
    """The tangential problem on a box, dimensionless.

    Attributes
    ----------
    kernel : Kernel or SoftenedKernel
    circulant : Circulant
    known : ndarray, shape (c, ny, nx)
        W, the known part of the shift.
    bound : ndarray, shape (ny, nx)
        g, zero outside the contact; or infinite in it.
    forces : Forces
    """

    kernel: Kernel | SoftenedKernel
    circulant: Circulant
    known: np.ndarray
    bound: np.ndarray
    forces: Forces

    @cached_property
    def contact(self) -> np.ndarray:
        """Where tractions can act."""
        return self.bound > 0

    @property
    def scale(self) -> np.ndarray | float:
        """Traction and displacement of each element that count as one, (ny, nx); or one."""
        return 1.0 if self.forces.scale is None else self.forces.scale

    @property
    def linear(self) -> bool:
        """Whether the bound is infinite."""
        return bool(np.isinf(self.bound[self.contact]).all())

    def projected(self, trial: np.ndarray) -> np.ndarray:
        """The tractions of the natural map: trial tractions, cut off at the bound."""
        size = _lengths(trial)
        beyond = size > self.bound
        return trial * np.where(beyond, self.bound / np.where(beyond, size, 1.0), 1.0)

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Tractions within the bound near given ones."""
        return self.projected(traction)

    def work(self, trial: np.ndarray, change: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The work of the natural map's tractions after a change of the rigid shifts (k,), with slope and curvature."""
        free = list(self.forces.components)
        trial = trial - self.forces.moved(self.forces.spread(change, len(trial)))
        size = _lengths(trial)
        beyond = size > self.bound
        held = np.where(beyond, self.bound, size) * self.contact
        part = np.where(beyond, self.bound / np.where(beyond, size, 1.0), 1.0) * self.contact
        across = np.array([-trial[1], trial[0]]) / np.where(size > 0, size, 1.0) if len(trial) == 2 else None
        work = float(np.sum(held * (size - held / 2))) + float(self.forces.sums @ change)
        lacking = self.forces.sums - self.forces.of(part * trial)
        stuck = np.where(beyond, 0.0, part)
        square = 1.0 if self.forces.scale is None else self.forces.scale**2
        curvature = np.eye(len(free)) * np.sum(stuck * square)
        if across is not None:
            slipping = (part - stuck) * square * across[free]
            curvature += np.einsum("iyx,jyx->ij", slipping, across[free])
        return work, lacking, curvature

    def linearised(
        self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray, damping: float
    ) -> TangentialSystem:
        """Newton's equations, and their right-hand sides."""
        size = _lengths(trial)
        slip = self.contact & (size > self.bound)
        stick = self.contact & ~slip
        along = np.where(slip, trial / np.where(slip, size, 1.0), 0.0)
        across = np.array([-along[1], along[0]]) if len(along) == 2 else np.zeros_like(along)
        held = np.where(slip, np.maximum(self.bound / np.where(slip, size, 1.0), 1 / STEEP), 1.0)
        with np.errstate(invalid="ignore"):  # inf * 0
            outward = np.where(slip, self.bound, 0.0) - dot(along, traction)
        right = np.where(stick, -shift, outward * along - dot(across, traction) * across)
        return TangentialSystem(self, right, stick, along, across, held, damping)


@dataclass(frozen=True, eq=False)
class TangentialSystem:
    """Newton's equations at given tractions.

    Attributes
    ----------
    conditions : TangentialConditions
    right : ndarray, shape (c, ny, nx)
    stick : bool ndarray, shape (ny, nx)
    along, across : ndarray, shape (c, ny, nx)
        Unit vectors along the traction and across it where it slips, else zero.
    held : ndarray, shape (ny, nx)
        The traction bound by the size of the trial traction where it slips, else one.
    damping : float
        Added to M.
    """

    conditions: TangentialConditions
    right: np.ndarray
    stick: np.ndarray
    along: np.ndarray
    across: np.ndarray
    held: np.ndarray
    damping: float

    @cached_property
    def _single(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """In single precision; the last are the factors of ``t.d`` in its rows."""
        own = 1 - self.held + self.damping * self.held
        stick, along, across = (field.astype(np.float32) for field in (self.stick, self.along, self.across))
        return stick, along, across, self.held.astype(np.float32), own.astype(np.float32)

    def product(self, step: np.ndarray) -> np.ndarray:
        """M times a step."""
        return self.conditions.kernel(step)

    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Left-hand sides for a step and M times the step."""
        stick, along, across, held, own = self._single
        turned = held * dot(across, image) + own * dot(across, step)
        stuck: np.ndarray = image + np.float32(self.damping) * step if self.damping else image
        rows: np.ndarray = stick * stuck + turned * across + dot(along, step) * along
        return rows

    def border(self, component: int) -> np.ndarray:
        """Left-hand sides for a uniform shift along one component."""
        stick, _, across, held, _ = self._single
        rows = across * (across[component] * held)
        rows[component] += stick
        scale = self.conditions.forces.scale
        return rows if scale is None else rows * scale

    def precondition(self, right: np.ndarray) -> np.ndarray:
        """The two inverses of the circulant, blended by the slope, on what is not along slipping tractions."""
        stick, along, across, held, _ = self._single
        inverses, weights, unweights = self._blend
        free = stick * right + (dot(across, right) / held) * across
        found = self.conditions.circulant.apply(inverses, free[:, None] * weights)
        step = dot(found.swapaxes(0, 1), unweights[:, None])
        return stick * step + dot(across, step) * across + dot(along, right) * along

    @cached_property
    def _blend(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Inverses (m, k, ...), and the weights (k, ny, nx) of the fields they are applied to and of the results."""
        contact, circulant = self.conditions.contact, self.conditions.circulant
        slip = contact & ~self.stick
        if not slip.any():
            weights = contact.astype(np.float32)[None]
            return circulant.stick[:, None], weights * circulant.growth, weights / circulant.growth
        slope = np.where(slip, 1 / self.held - 1, 0.0)
        shift = _rounded(max(_quantile(slope[slip]), LEAST_SHIFT))
        inverses = circulant.pair(shift)
        part = np.log1p(np.minimum(slope, shift) / NEARLY_STICK) / np.log1p(shift / NEARLY_STICK)
        size = self.conditions.kernel.row_size
        steep = np.sqrt((size + shift) / (size + np.maximum(slope, shift))) * contact
        level = steep if circulant.rolling else np.sqrt((size + shift) / (size + slope)) * contact
        weights = np.array([np.sqrt(1 - part) * steep, np.sqrt(part) * level]).astype(np.float32)
        return inverses, weights * circulant.growth, weights / circulant.growth

    def bent(self, traction: np.ndarray, step: Step) -> Step:
        """The step with slipping tractions turned on their bound, where they turn far; else the step itself."""
        slip = self.conditions.contact & ~self.stick
        bound = np.where(slip, self.conditions.bound, 1.0)
        angle = dot(self.across, traction + step.traction) / bound
        if not np.abs(angle).max(initial=0.0) > FAR:
            return step
        angle = np.clip(angle, -FARTHEST, FARTHEST)
        turned = bound * (np.cos(angle) * self.along + np.sin(angle) * self.across) - traction
        extra = np.where(self.stick | ~slip, 0.0, turned - step.traction)
        shift = step.shift + self.conditions.kernel(extra.astype(np.float32))
        return Step(step.traction + extra, shift, step.rigid, step.iterations)


def _quantile(values: np.ndarray) -> float:
    """The value below which a part `QUANTILE` of them is: not interpolated, which takes longer."""
    place = int(QUANTILE * (values.size - 1))
    return float(np.partition(values, place)[place])


def _rounded(shift: float) -> float:
    """One of the shifts for which there are inverses."""
    return float(np.exp(APART * np.round(np.log(shift) / APART)))


def _lengths(vectors: np.ndarray) -> np.ndarray:
    """Lengths (ny, nx) of vectors (c, ny, nx) of order one: without the care that very large or small ones need."""
    return np.abs(vectors[0]) if len(vectors) == 1 else np.sqrt(vectors[0] ** 2 + vectors[1] ** 2)


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Scalar products of vectors.

    Parameters
    ----------
    one, other : ndarray, shape (c, ny, nx)

    Returns
    -------
    ndarray, shape (ny, nx)
    """
    product: np.ndarray = one[0] * other[0]
    for first, second in zip(one[1:], other[1:], strict=True):
        product += first * second
    return product
