"""The height of the axle that bears a load: heights to try, by the forces at those before."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from varcontact.errors import NotConverged, SceneError
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

ROUNDS = 30
"""Heights that are tried."""
GROWTH = 10.0
"""Largest ratio of the next depth to the last."""
ROUNDING = 1e-15
"""Rounding of heights, relative to the radius of the wheel, from which they are computed."""
FAR, NEAR, LEFT = 0.05, 5e-4, 0.2
"""Parts of the load that may be missing where tractions are solved for: at first, and later on; or
of what was missing when they were solved for last."""
POWERS = 0.2, 5.0
"""Least and largest power of normal forces that the vertical force is taken for."""
LITTLE = 1e-4
"""Change of the depth, relative, below which the slope is that of a larger one: forces are rounded
by solvers."""


class BearingHeight:
    """The heights to try until one bears the load; of a case with a height, that alone.

    At each, `normal_forces_bear` takes the vertical part of the normal forces, and says whether it
    is worth solving for the rest; `borne` takes the vertical force. The secant method is for
    force^(2/3) of normal forces, which is nearly straight, between heights that bear less and more;
    the vertical force is nearly a power of what normal forces bear. From another position come the
    height to start at, and the forces `known`: those of the normal forces, and of all.
    """

    def __init__(
        self,
        case: WheelOnRail,
        tol: float,
        start: float | None = None,
        known: tuple[float, float] | None = None,
    ) -> None:
        self.rounds, self._case, self._tol, self._load = (
            0,
            case,
            tol,
            case.vertical_force or math.nan,
        )
        stiffness = (
            4
            / 3
            * case.bodies.combined_G
            / (1 - case.bodies.combined_nu)
            * np.sqrt(case.wheelset.radius)
        )
        given = start if case.z is None else case.z
        self.z: float = (
            case.touching + (self._load / stiffness) ** (2 / 3) if given is None else given
        )
        self._tried, self._slope = [(case.touching, 0.0)], math.nan
        # normal forces, and what they bear with the rest
        self._known, self._power = known or (1.0, 1.0), 1.0
        # tractions bear a part
        self._mixed = case.with_friction or case.bodies.K != 0 or case.conformal is True
        self._near, self._excess, self._borne = (
            (NEAR if known else FAR) if self._mixed else tol,
            math.inf,
            False,
        )

    def __iter__(self) -> Iterator[float]:
        if self._case.z is not None:
            yield self.z
            return
        for self.rounds in range(1, ROUNDS + 1):
            self._borne = False
            yield self.z
            if self._borne and abs(self._excess) <= self._tol:
                return
            before, self.z = self.z, self._next()
            if self.z == before:
                break
        missed = f"no height of the axle was found that bears {self._load:g} N"
        if self._tol * (self.z - self._case.touching) < ROUNDING * self._case.wheelset.radius:
            missed += f" to within tol = {self._tol:g}: heights are rounded more coarsely; give a larger load, or tol"
        raise NotConverged(missed, abs(self._excess))

    def normal_forces_bear(self, force: float) -> bool:
        self._tried.append((self.z, force))
        normal, known = self._known
        self._excess = known * (force / normal) ** self._power / self._load - 1
        return abs(self._excess) <= self._near

    def borne(self, force: float) -> None:
        if self._case.z is not None:
            return
        if force <= 0:
            lifted = (
                f"friction lifts it by more than its normal force bears (together {force:.4g} N)"
            )
            reason = f"vertical_force = {self._load:g} N: no height of the axle bears it: {lifted}"
            raise SceneError(
                "vertical_force",
                self._load,
                message=f"{reason}; give another position or friction, or z",
            )
        if self._tried[-1][0] != self.z:
            self._tried.append((self.z, force))
        normal, (before, known) = self._tried[-1][1], self._known
        if before != 1.0 and abs(normal / before - 1) > LITTLE:
            self._power = float(
                np.clip(math.log(force / known) / math.log(normal / before), *POWERS)
            )
        self._known, self._excess, self._borne = (normal, force), force / self._load - 1, True
        if self._mixed:
            self._near = max(NEAR, LEFT * abs(self._excess))

    def _next(self) -> float:
        heights, forces = np.array(self._tried).T
        normal, known = self._known
        goal = normal * (self._load / known) ** (1 / self._power)
        values, touching = forces ** (2 / 3) - goal ** (2 / 3), self._case.touching
        moved = self.z - heights[-2]
        if abs(moved) > LITTLE * (self.z - touching):
            self._slope = (values[-1] - values[-2]) / moved
        step = self.z - values[-1] / self._slope if self._slope > 0 else math.inf
        low, high = heights[values < 0].max(), heights[values >= 0].min(initial=math.inf)
        if np.isinf(high):
            return float(min(step, touching + GROWTH * (self.z - touching)))
        return float(step if low < step < high else (low + high) / 2)
