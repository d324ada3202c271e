"""A history of steps as a motion, which checks itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.checks import Checked, number
from varcontact.errors import SceneError
from varcontact.scene.carried import Carried
from varcontact.scene.friction import Law, coefficient
from varcontact.scene.motion import SPIN_OFFSET, TimeStep, force_or_rigid, offset
from varcontact.scene.surfaces import Cylinders, Paraboloids, SampledDistance, Surface
from varcontact.system.process import lazy_property

STEPS_MAX = 1_000_000
"""Largest number of steps of a history: all are checked several times before the first is
solved."""
LONGER = "; a longer history goes on from the last step of another, its start"

Numbers = float | Sequence[float]
Choices = float | Sequence[float | None] | None
Control = Callable[[int, Any], Mapping[str, Any]]


@dataclass(frozen=True, eq=False, kw_only=True)
class Transient(
    Checked,
    path="motion",
    steps=partial(checks.whole, most=STEPS_MAX, why=LONGER),
    rolled=number,
    interpolate=checks.flag,
    spin_offset=offset,
):
    """Rolling in time: a history of steps, each of which begins with the
    tractions of the step before.

    Entries from `dq` to `friction` are one number for all steps or a sequence
    of one for each; None in a sequence of forces leaves the step its creepage,
    None in one of the load or of friction leaves it the scene's.

    Parameters
    ----------
    steps : int
    dq : float or sequence, optional
        Distance rolled in each step [length]; 0: a shift in place; the
        element's dx if not given.
    dt : float or sequence, optional
        Time that each step takes [time], with viscoelastic bodies, and with
        these only; 0: a step at once.
    direction : int or sequence
        1: rolling towards positive x; -1: towards negative x.
    vx, vy, spin, ux, uy, rotation : float or sequence
        Creepages, as of `Steady`, per distance rolled, whatever its
        direction; and a rigid shift in place in each step, as of `Shift`, added
        to theirs.
    Fx, Fy : float or sequence, optional
        Tangential force on body 1 in place of creepage and shift of the same
        direction.
    normal_force, approach : float or sequence, optional
        The load in place of the scene's, at most one of the two in a step. A
        force of 0, or an approach at which the bodies are apart, is no contact:
        all tractions vanish.
    friction : float, law or sequence, optional
        Coefficient of friction, or law of it, in place of the scene's.
    surface : sequence, optional
        Undeformed distance of each step in place of the scene's: a contact that
        moves over the grid.
    carried : Carried or sequence, optional
        Heights that the bodies carry through the contact: roughness, flats,
        corrugation.
    rolled : float, optional
        Where the contact is before the first step on the way X of the `carried`
        heights [length]; 0 if not given.
    control : callable, optional
        ``control(k, before)`` gives creepages, shifts, forces or the load of
        step k as a mapping, in place of those given here; `before` is the
        Solution of the step before, or None. So wheel, track or drive move with
        the contact. The history that is returned has its numbers; a `store`
        cannot have a function.
    start : Solution, optional
        Solution that the first step continues from; by default bodies without tractions.
    interpolate : bool
        Whether a start on another grid is interpolated; otherwise it is
        refused.
    spin_offset : float
        The rigid slip of spin is sampled at
        ``x + spin_offset * direction * dq``, as of `Steady`: then a long
        history tends to the steady solution.

    Raises
    ------
    SceneError
        Naming the entry (``motion.vx[7]``), its value and what is allowed.

    Examples
    --------
    A shift by a force, then rolling under it:

    >>> motion = Transient(steps=4, dq=[0, 0.1, 0.1, 0.1], Fx=-0.1)
    >>> step = motion.step(1, dx=0.2)
    >>> step.dq, step.Fx, step.Fy
    (0.1, -0.1, None)
    """

    steps: int
    dq: Numbers | None = None
    dt: Numbers | None = None
    direction: int | Sequence[int] = 1
    vx: Numbers = 0.0
    vy: Numbers = 0.0
    spin: Numbers = 0.0
    ux: Numbers = 0.0
    uy: Numbers = 0.0
    rotation: Numbers = 0.0
    Fx: Choices = None
    Fy: Choices = None
    normal_force: Choices = None
    approach: Choices = None
    friction: float | Law | Sequence[float | Law | None] | None = None
    surface: Sequence[Surface] | None = None
    carried: Carried | Sequence[Carried] | None = None
    rolled: float | None = None
    control: Control | None = None
    start: Any = None
    interpolate: bool = False
    spin_offset: float = SPIN_OFFSET

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, check in _ENTRIES.items():
            object.__setattr__(self, name, self._checked(name, check))
        if self.Fx is not None or self.Fy is not None:
            for k in range(self.steps):
                force_or_rigid(partial(self.of, k=k), "vx", "ux", "vy", "uy", at=f"[{k}]")
        if self.surface is not None:
            self._check_surfaces(self.surface)
            object.__setattr__(self, "surface", tuple(self.surface))
        self._check_objects()

    def _checked(self, name: str, check: Callable[[str, Any], Any]) -> Any:
        """An entry of the steps, checked: one value, or a tuple of one for each step."""
        field = f"motion.{name}"
        value = getattr(self, name)
        optional = name in _OPTIONAL
        if value is None and (optional or name in ("dq", "dt")):
            return None
        if not checks.is_array(value):
            return check(field, value)
        if not isinstance(value, (list, tuple)):
            value = np.asarray(value)  # a table of pandas goes over its columns
        if len(value) != self.steps:
            allowed = f"one number, or one for each of the {self.steps} steps"
            raise SceneError(field, f"{len(value)} values", allowed)
        values = []
        for k, each in enumerate(value):
            if each is not None or not optional:
                each = check(f"{field}[{k}]", each)
            values.append(each)
        return tuple(values)

    def _check_surfaces(self, surfaces: Any) -> None:
        if not isinstance(surfaces, (list, tuple)) or len(surfaces) != self.steps:
            allowed = f"one surface for each of the {self.steps} steps"
            raise SceneError("motion.surface", surfaces, allowed)
        for k, surface in enumerate(surfaces):
            checks.kind(f"motion.surface[{k}]", surface, Paraboloids, Cylinders, SampledDistance)

    def _check_objects(self) -> None:
        """Carried heights, control and start are of their classes."""
        sequence = isinstance(self.carried, Carried | Sequence | None)
        if not sequence or not all(isinstance(each, Carried) for each in self.heights):
            raise SceneError("motion.carried", self.carried, "Carried, or several")
        if self.control is not None and not callable(self.control):
            raise SceneError(
                "motion.control", self.control, "a function of the step and the solution before it"
            )
        fields = ("grid", "pressure", "traction", "state")
        if self.start is not None and not all(hasattr(self.start, name) for name in fields):
            raise SceneError("motion.start", self.start, "a Solution")

    __repr__ = checks.short_entries

    def of(self, name: str, k: int) -> Any:
        """Value of the entry `name` in step `k`, from 0, in the entry's unit."""
        value = getattr(self, name)
        if isinstance(value, tuple):
            return value[k]
        return value

    def every(self, name: str) -> list[Any]:
        """Values of the entry `name`, one a step, in the entry's unit."""
        return [self.of(name, k) for k in range(self.steps)]

    @property
    def repeats(self) -> bool:
        """True where every step is described by the same numbers."""
        return self.surface is None and not any(
            isinstance(getattr(self, name), tuple) for name in _ENTRIES
        )

    def step(self, k: int, dx: float) -> TimeStep:
        """Step `k`, from 0; where no distance is given, it rolls over one element of length `dx`
        [length].
        """
        entries = {name: self.of(name, k) for name in ("dt", "direction", *_RIGID, "Fx", "Fy")}
        dq = self.of("dq", k)
        if dq is None:
            dq = dx
        return TimeStep(dq=dq, spin_offset=self.spin_offset, **entries)

    def position(self, k: int, dx: float) -> float:
        """Place X at the end of step `k`, from 0, with elements of length `dx` [length]; of -1
        before the first.
        """
        distance = float(self._distances[k + 1])
        if self.dq is None:
            distance *= dx
        return (self.rolled or 0.0) + distance

    @lazy_property
    def _distances(self) -> np.ndarray:
        """Distance rolled before each step and at the end [length; elements without `dq`]."""
        steps = np.asarray(self.direction, dtype=float)
        if self.dq is not None:
            steps = steps * self.dq
        rolled = np.broadcast_to(steps, self.steps)
        return np.concatenate([[0.0], np.cumsum(rolled)])

    @property
    def height_range(self) -> float:
        """Largest possible difference in height of what the bodies carry [length]."""
        return sum(
            float(each.height.max(initial=0.0) - each.height.min(initial=0.0))
            for each in self.heights
        )

    @property
    def heights(self) -> tuple[Carried, ...]:
        """The heights that the bodies carry, one after the other."""
        if isinstance(self.carried, Carried):
            return (self.carried,)
        return tuple(self.carried or ())

    def alone(self, k: int, dx: float, given: Any) -> Transient:
        """Step `k`, from 0, as a history of one step, on elements of length `dx`, with the entries
        `given` by its control.
        """
        if not isinstance(given, Mapping):
            raise SceneError(
                "motion.control", given, f"a mapping with some of {', '.join(CONTROLLED)}"
            )
        entries = {name: self.of(name, k) for name in _ENTRIES}
        for name, value in given.items():
            entries |= dict.fromkeys(CONTROLLED[checks.choice("motion.control", name, CONTROLLED)])
            entries[name] = value
        entries |= {name: 0.0 for name in _RIGID if entries[name] is None}
        surface = None
        if self.surface is not None:
            surface = [self.surface[k]]
        return replace(
            self, steps=1, surface=surface, rolled=self.position(k - 1, dx), control=None, **entries
        )


_RIGID = ("vx", "vy", "spin", "ux", "uy", "rotation")
CONTROLLED = {
    **dict.fromkeys(("spin", "rotation"), ()),
    **{name: (f"F{name[1]}",) for name in ("vx", "vy", "ux", "uy")},
    **{name: (f"v{name[1]}", f"u{name[1]}") for name in ("Fx", "Fy")},
    "normal_force": ("approach",),
    "approach": ("normal_force",),
}
"""Entries that a control may give, each with those that it replaces."""
_OPTIONAL = ("Fx", "Fy", "normal_force", "approach", "friction")


def _direction(field: str, value: Any) -> int:
    if abs(number(field, value, "1 or -1")) != 1:
        raise SceneError(field, value, "1 or -1")
    return int(value)


_ENTRIES: dict[str, Callable[[str, Any], Any]] = {
    "dq": checks.at_least_zero,
    "dt": checks.at_least_zero,
    "direction": _direction,
    **dict.fromkeys((*_RIGID, "Fx", "Fy", "approach"), checks.number),
    "normal_force": checks.at_least_zero,
    "friction": coefficient,
}
