"""Search for the height of the axle that carries a load: heights to try, by the forces at those
before.
"""

from __future__ import annotations

import math

import numpy as np

from varcontact.errors import NotConverged, SceneError
from varcontact.wheel_rail.wheel_geometry import WheelGeometry

ROUNDS = 30
"""Heights that are tried."""
GROWTH = 10.0
"""Largest ratio of the next depth to the last."""
ROUNDING = 1e-15
"""Rounding of heights, relative to the radius of the wheel, from which they are computed."""
FIRST_MISSING = 0.03
"""Part of the load that may be missing where tractions are solved for at first, and patches tell
the next height."""
FIRST_MISSING_UNTOLD = 0.05
"""The same where they do not."""
MISSING = 5e-4
"""The same where they do not, and it is known what tractions carry in another position; and later
on at least."""
MISSING_OF_LAST = 0.2
"""The same, relative to the part that was missing when they were solved for last."""
POWERS = 0.2, 5.0
"""Least and largest power of normal forces that the vertical force is taken for."""
RATES = 0.3, 3.0
"""Least and largest change of the height that is told by a step, relative to that of patches which
stay as they are."""
LITTLE = 1e-4
"""Change of the depth, relative, below which the slope is that of a larger one: forces are rounded
by solvers."""
SAME_PATCHES = 100.0
"""Change of the depth, relative and divided by the tolerance, by which patches stay as they are. At
the same vertical force it changes the others of 150 random wheels by less than the tolerance, of
six by more, 6.5 times it at most."""
PRESSING = 1.2
"""Normal force, divided by the modulus and `Locus.pressing`: of a ball 1.19 exactly, of the wheels
of the Manchester benchmark 1.19 to 1.23, on a flange 1.3."""


class BearingHeight:
    """Search for the height that carries the load; of a case with a height, that alone.

    `propose` gives the next height until `done`. There, `learn_normal` takes the vertical part of
    the normal forces alone, and `near` says whether the rest is worth solving for; `learn` takes
    the vertical force. A patch that tells its height needs `tell` instead of `learn_normal`: `z` is
    then the height that it told, and it serves there if that is near enough. Of other patches the
    secant method is for force^(2/3) of normal forces, which is nearly straight, between heights
    that carry less and more; the vertical force is nearly a power of what normal forces bear. From
    another position come the height to start at, and the forces `known`:
    those of the normal forces, and of all. On the `same_grids` they tell the power, too.
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
        self._slope = math.nan
        # normal forces, and what they carry with the rest
        self._known = known or (1.0, 1.0)
        self._tells_power = same_grids
        self._power = 1.0
        # where tractions carry a part, they are solved for near the height
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
        # a patch that told the height: that at which it is, how much deeper it is to be, these of
        # the patch before, and the change of what is told by the change of the height
        self.expects = False
        self._same_patches = True
        self._height = math.nan
        self._deeper = 0.0
        self._before = math.nan, 0.0
        self._rate = 1.0
        self._normal = math.nan

    def _first(self, start: float | None) -> float:
        """The height to begin with: given, of another position, or that of a contact like a
        ball's.
        """
        case = self._case
        if case.z is not None:
            return case.z
        if start is not None:
            return start
        modulus = case.bodies.combined_G / (1 - case.bodies.combined_nu)
        ball = self._load / (4 / 3 * modulus * math.sqrt(case.wheelset.radius))
        return case.locus.height_pressing(self._load / (PRESSING * modulus), ball ** (2 / 3))

    def begin(self, z: float) -> None:
        """A height that is known to be near."""
        self.z = z

    @property
    def goal(self) -> float:
        """The vertical part of normal forces with which the load is carried, by those known."""
        normal, known = self._known
        return normal * (self._load / known) ** (1 / self._power)

    @property
    def keeps_patches(self) -> bool:
        """True if the patches of the last height serve at the next one, which they told."""
        return self.expects and self._same_patches

    def tell(self, deeper: float) -> None:
        """The patch bears the goal where it is `deeper` than at the height where it was found [mm].

        Patches change with the height: the secant method has that at which one bears the goal as it
        is.
        """
        depth = self._height - self._case.touching
        height, told = self._before
        moved = self._height - height
        if abs(moved) > LITTLE * depth:
            self._rate = float(np.clip((told - deeper) / moved, *RATES))
        self._before = math.nan, 0.0
        self._move_deeper(deeper)
        self._normal = self.goal
        self._excess = -1.5 * deeper / depth

    def _move_deeper(self, deeper: float) -> None:
        depth = self._height - self._case.touching
        new_depth = depth + deeper / self._rate
        self.z = self._case.touching + float(np.clip(new_depth, depth / GROWTH, depth * GROWTH))
        self._deeper = deeper
        self.expects = True
        little = min(SAME_PATCHES * self._tol, FIRST_MISSING)
        self._same_patches = abs(deeper) <= little * depth

    def propose(self) -> float:
        """The next height; `NotConverged` where there is none left."""
        if self._case.z is not None:
            return self.z
        if self.rounds == ROUNDS:
            raise NotConverged(self._missed(), abs(self._excess))
        if self.rounds > 0 and not self.expects:
            self._move()
        if not self.keeps_patches:
            self._before = self._height, self._deeper
            self._height = self.z
            self._deeper = 0.0
        self.expects = False
        self.rounds += 1
        return self.z

    def _move(self) -> None:
        before = self.z
        self.z = self._next()
        if self.z == before:
            raise NotConverged(self._missed(), abs(self._excess))

    def _missed(self) -> str:
        words = f"no height of the axle was found that balances {self._load:g} N"
        if self._tol * (self.z - self._case.touching) >= ROUNDING * self._case.wheelset.radius:
            return words
        reason = "heights are rounded more coarsely; give a larger load, or tol"
        return f"{words} to within tol = {self._tol:g}: {reason}"

    @property
    def near(self) -> bool:
        """True if so much of the load is carried that tractions are worth solving for."""
        return abs(self._excess) <= self._enough or self.keeps_patches

    def learn_normal(self, force: float) -> None:
        """The vertical part of the normal forces alone, at the height that was proposed."""
        if self._case.z is not None:
            self._excess = 0.0
            return
        self._tried.append((self.z, force))
        self._normal = force
        self._same_patches = True
        self._height = math.nan
        normal, known = self._known
        self._excess = known * (force / normal) ** self._power / self._load - 1

    def learn(self, force: float) -> None:
        """The vertical force at the height that was proposed."""
        if self._case.z is not None:
            self.done = True
            return
        if force <= 0:
            raise self._lifted(force)
        if math.isnan(self._normal):
            self.learn_normal(force)
        normal = self._normal
        self._normal = math.nan
        self.expects = False
        before, known = self._known
        if self._tells_power and abs(normal / before - 1) > LITTLE:
            power = math.log(force / known) / math.log(normal / before)
            self._power = float(np.clip(power, *POWERS))
        self._known = normal, force
        self._tells_power = True
        self._excess = force / self._load - 1
        self.done = abs(self._excess) <= self._tol and self._same_patches
        if self._mixed:
            self._enough = max(self._least_missing, MISSING_OF_LAST * abs(self._excess))
        if math.isfinite(self._height) and not self.done:
            # normal forces grow by the power 3/2 of the depth
            ratio = (self.goal / normal) ** (2 / 3)
            self._move_deeper(self._deeper + (self.z - self._case.touching) * (ratio - 1))

    def _lifted(self, force: float) -> SceneError:
        load = self._load
        reason = (
            f"no height of the axle balances vertical_force = {load:g} N: friction lifts the rail "
            f"more than the normal force presses it down (together {force:.4g} N)"
        )
        remedy = "give another position or friction, or z"
        return SceneError("vertical_force", load, message=f"{reason}; {remedy}")

    def _next(self) -> float:
        """The height by the secant method, between those that carry less and more."""
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
        # bracket
        low = heights[values < 0].max()
        high = heights[values >= 0].min(initial=math.inf)
        if np.isinf(high):
            return float(min(step, touching + GROWTH * (self.z - touching)))
        if low < step < high:
            return float(step)
        return float((low + high) / 2)
