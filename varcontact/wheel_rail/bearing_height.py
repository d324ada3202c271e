"""Search for the axle height that carries a load: next height from the forces at earlier ones."""

from __future__ import annotations

import math

import numpy as np

from varcontact.errors import NotConverged, SceneError
from varcontact.wheel_rail.wheel_geometry import WheelGeometry

ROUNDS = 30
"""Largest number of heights that are tried."""
GROWTH = 10.0
"""Largest ratio of the next depth to the last."""
ROUNDING = 1e-15
"""Rounding error of heights, relative to the wheel radius from which they are computed."""
FIRST_MISSING = 0.01
"""Relative load error below which tractions are solved for at first, where patches give the next
height."""
FIRST_MISSING_UNTOLD = 0.05
"""Relative load error below which tractions are solved for at first, where patches do not give the
next height and no other position gives the tractions' share of the load."""
MISSING = 5e-4
"""Relative load error below which tractions are solved for at first, where a neighbouring position
gives their share of the load; also the lower limit in later rounds."""
MISSING_OF_LAST = 0.2
"""Load error below which tractions are solved for again, relative to that at their last
solution."""
POWERS = 0.2, 5.0
"""Range of the exponent of the vertical force as a power of the normal forces."""
CHANGES = 0.8, 1.25
"""Range of the change of forces in a step, relative to the change for patches of constant shape."""
SLOW = 0.5
"""Ratio of successive load errors above which the height that patches tell is not followed."""
JUMP_MAX = 1e-3
"""Relative load error that is accepted where forces jump, as elements come into contact."""
LITTLE = 1e-4
"""Relative change of depth below which the slope of a larger change is used, as solvers round
forces."""


class BearingHeight:
    """Search for the height that carries the load; for a case with a height, only that height.

    `propose` gives the next height until `done`. There, `learn_normal` takes the vertical part of
    the normal forces alone, `near` is true if tractions are worth solving for, and `learn` takes
    the vertical force. The secant method is applied to force^(2/3) of normal forces, which is
    nearly linear, between heights that carry less and more than the load; the vertical force is
    taken as a power of the normal forces. Another position gives the first height and the `known`
    forces (of normal forces, and of all forces); on the `same_grids` also the power.
    """

    def __init__(
        self,
        case: WheelGeometry,
        tol: float,
        start: float | None = None,
        known: tuple[float, float] | None = None,
        same_grids: bool = False,
    ) -> None:
        self.rounds = 0
        self.done = False
        self._case = case
        self._tol = tol
        self._load = case.vertical_force or math.nan
        self.z = self._first(start)
        self._tried = [(case.touching, 0.0)]
        self._estimated_at = math.nan
        self._slope = math.nan
        # normal forces, and the vertical force including tractions
        self._known = known or (1.0, 1.0)
        self._tells_power = same_grids
        self._power = 1.0
        # if tractions carry a part of the load, they are solved only near the height
        self._mixed = case.tractions_bear_load
        self._enough = tol
        first = FIRST_MISSING
        self._least_missing = tol
        if not case.patches_tell:
            first = MISSING if known else FIRST_MISSING_UNTOLD
            self._least_missing = MISSING
        if self._mixed:
            self._enough = first
        self._excess = math.inf
        # height at which the last patches carry the goal, the previous goal, and the change of
        # forces by a step relative to the expected one
        self._expected = math.nan
        self._last_goal = math.nan
        self._change = 1.0

    def _first(self, start: float | None) -> float:
        """First height: the given one, that of another position, or that of a ball in Hertz's
        contact.
        """
        case = self._case
        if case.z is not None:
            return case.z
        if start is not None:
            return start
        G = case.bodies.combined_G
        stiffness = 4 / 3 * G / (1 - case.bodies.combined_nu) * np.sqrt(case.wheelset.radius)
        return float(case.touching + (self._load / stiffness) ** (2 / 3))

    def begin(self, z: float) -> None:
        """Begin the search at a height that is known to be near."""
        self.z = z

    @property
    def goal(self) -> float:
        """Vertical part of the normal forces at which the load is carried, from the last known
        forces.
        """
        normal, known = self._known
        return normal * (self._load / known) ** (1 / self._power)

    @property
    def expects(self) -> bool:
        """True if the patches have given the next height."""
        return math.isfinite(self._expected)

    def expect(self, z: float) -> None:
        """Learn the height at which the patches of the last height carry the goal.

        Patches change with the height: they are taken to make the same part of the change of forces
        as at the last step.
        """
        before, last = (force ** (2 / 3) for _, force in self._tried[-2:])
        goal = self._last_goal ** (2 / 3)
        if abs(goal - before) > LITTLE * before:
            change = self._change * (last - before) / (goal - before)
            self._change = float(np.clip(change, *CHANGES))
        self._expected = self.z + (z - self.z) / self._change
        self._last_goal = self.goal

    def propose(self) -> float:
        """Next height; `NotConverged` if there is none left."""
        if self._case.z is None:
            if self.rounds > 0:
                self._move()
            self.rounds += 1
        return self.z

    def _move(self) -> None:
        before = self.z
        self.z = self._next()
        if self.z == before or self.rounds == ROUNDS:
            raise NotConverged(self._missed(), abs(self._excess))

    def _missed(self) -> str:
        words = f"no height of the axle was found that balances {self._load:g} N"
        if self._tol * (self.z - self._case.touching) >= ROUNDING * self._case.wheelset.radius:
            if not self._at_jump:
                return words
            jump = f"forces jump by {abs(self._excess):.2g} of it at z = {self.z:.6g} mm"
            return f"{words}: {jump}, where elements come into contact; give smaller ones"
        reason = "heights are rounded more coarsely; give a larger load, or tol"
        return f"{words} to within tol = {self._tol:g}: {reason}"

    @property
    def near(self) -> bool:
        """True if enough of the load is carried to solve for tractions."""
        return abs(self._excess) <= self._enough or self._at_small_jump

    @property
    def _at_small_jump(self) -> bool:
        """True if no height carries the load, and this one misses it by little."""
        return abs(self._excess) <= JUMP_MAX and self._at_jump

    @property
    def _at_jump(self) -> bool:
        """True if forces jump here: heights that carry less and more than the load lie together."""
        low, high = self._bracket
        return high - low < self._tol * (self.z - self._case.touching)

    def learn_normal(self, force: float) -> None:
        """Learn the vertical part of the normal forces alone, at the height that was proposed."""
        if self._case.z is not None:
            self._excess = 0.0
            return
        self._tried.append((self.z, force))
        normal, known = self._known
        self._excess = known * (force / normal) ** self._power / self._load - 1

    def estimate_normal(self, force: float) -> None:
        """Learn an estimate of that force, as `learn_normal`; it does not bracket later heights."""
        self.learn_normal(force)
        self._estimated_at = self.z

    def learn(self, force: float) -> None:
        """Learn the vertical force at the height that was proposed."""
        if self._case.z is not None:
            self.done = True
            return
        if force <= 0:
            raise self._lifted(force)
        self._excess = force / self._load - 1
        self.done = abs(self._excess) <= self._tol or self._at_small_jump
        if self._tried[-1][0] != self.z:
            self._tried.append((self.z, force))
        normal = self._tried[-1][1]
        before, known = self._known
        if self._tells_power and abs(normal / before - 1) > LITTLE:
            power = math.log(force / known) / math.log(normal / before)
            self._power = float(np.clip(power, *POWERS))
        self._known = normal, force
        self._tells_power = True
        if self._mixed:
            self._enough = max(self._least_missing, MISSING_OF_LAST * abs(self._excess))

    def _lifted(self, force: float) -> SceneError:
        load = self._load
        reason = (
            f"no height of the axle balances vertical_force = {load:g} N: friction lifts the rail "
            f"more than the normal force presses it down (together {force:.4g} N)"
        )
        remedy = "give another position or friction, or z"
        return SceneError("vertical_force", load, message=f"{reason}; {remedy}")

    @property
    def _bracket(self) -> tuple[float, float]:
        """The greatest height that carries less than the load, and the least that carries more."""
        tried = [each for each in self._tried if each[0] != self._estimated_at]
        heights, forces = np.array(tried).T
        less = forces < self.goal
        return float(heights[less].max()), float(heights[~less].min(initial=math.inf))

    def _next(self) -> float:
        """Next height by the secant method, between those that carry less and more than the
        load.
        """
        heights, forces = np.array(self._tried).T
        values = forces ** (2 / 3) - self.goal ** (2 / 3)
        touching = self._case.touching
        # slope between the last two heights
        moved = self.z - heights[-2]
        if abs(moved) > LITTLE * (self.z - touching):
            self._slope = (values[-1] - values[-2]) / moved
        step = math.inf
        if self._slope > 0:
            step = self.z - values[-1] / self._slope
        # what patches tell, unless that hardly came nearer the last time
        if self.expects:
            if self.rounds == 1 or abs(values[-1]) <= SLOW * abs(values[-2]):
                step = self._expected
            self._expected = math.nan
        low, high = self._bracket
        if np.isinf(high):
            return float(min(step, touching + GROWTH * (self.z - touching)))
        if low < step < high:
            return float(step)
        return float((low + high) / 2)
