"""Motions of the bodies over each other in one problem. Each motion checks itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar, Literal, Self

import numpy as np

from varcontact import checks
from varcontact.checks import Checked, at_least_zero, number, positive
from varcontact.errors import SceneError

SPIN_OFFSET = 1 / 6

SLIP_DIFFERENCES = {"first-order": SPIN_OFFSET, "second-order": 0.0}
"""Differences over a step that give the slip of steady rolling, and the spin offset that goes with
each."""


def offset(field: str, value: Any) -> float:
    """A spin offset."""
    checked = number(field, value, "a number in [0, 1]")
    if not 0 <= checked <= 1:
        raise SceneError(field, value, "a number in [0, 1]")
    return checked


@dataclass(frozen=True, kw_only=True)
class Steady(
    Checked,
    path="motion",
    **dict.fromkeys(("vx", "vy", "spin", "Fx", "Fy"), number),
    **dict.fromkeys(("dq", "speed"), positive),
    spin_offset=offset,
    slip_difference=partial(checks.choice, options=SLIP_DIFFERENCES),
    rigid_slip=lambda field, value: checks.array(field, value, 3),
):
    """Steady rolling in the direction of x.

    Parameters
    ----------
    vx, vy : float
        Longitudinal and lateral creepage [-]: rigid slip of body 1 over body 2
        divided by the rolling velocity (75).
    spin : float
        Spin creepage [1/length].
    Fx, Fy : float, optional
        Tangential force on body 1 in place of the creepage of the same
        direction [force].
    dq : float, optional
        Distance rolled in the step that discretises the slip [length]; the
        element's dx if not given.
    spin_offset : float, optional
        Where the rigid slip of spin is sampled: at ``x + spin_offset * dq``; in
        [0, 1]. If not given, 1/6, which is CONTACT's, or 0 with the difference
        of second order. With that of first order 0 keeps the discrete C23 =
        -C32 exact, and 1/2 is the path's middle.
    slip_difference : {"first-order", "second-order"}
        The elastic slip: between an element and a step ahead, as in CONTACT; or
        also with a step behind and two ahead, exact for displacements that are
        quadratic along x. The second: see `Scene.second_order`.
    rigid_slip : array_like, shape (2, ny, nx), optional
        Rigid slip at the samples of a `SampledDistance` [-], added to that of
        the creepages.
    speed : float, optional
        Rolling velocity [length/time], with viscoelastic bodies, and with these
        only: nothing else depends on time.
    """

    _words: ClassVar = {
        **dict.fromkeys(("cksi", "xi"), "vx, the longitudinal creepage"),
        **dict.fromkeys(("ceta", "eta"), "vy, the lateral creepage"),
        **dict.fromkeys(("cphi", "phi"), "spin"),
        **{f"u{i}": f"Shift for a shift, or v{i} for a creepage" for i in "xy"},
    }
    vx: float = 0.0
    vy: float = 0.0
    spin: float = 0.0
    Fx: float | None = None
    Fy: float | None = None
    dq: float | None = None
    spin_offset: float | None = None
    slip_difference: Literal["first-order", "second-order"] = "first-order"
    rigid_slip: np.ndarray | None = field(default=None, compare=False, repr=False)
    speed: float | None = None
    rolls: ClassVar[int] = 1  # towards positive x

    def __post_init__(self) -> None:
        super().__post_init__()
        force_or_rigid(partial(getattr, self), "vx", "vy")
        if self.spin_offset is None:
            object.__setattr__(self, "spin_offset", SLIP_DIFFERENCES[self.slip_difference])

    @property
    def rigid(self) -> tuple[float, float, float]:
        """(vx, vy, spin)."""
        return self.vx, self.vy, self.spin

    def second_order(self) -> Self:
        """Copy whose slip is a difference of second order, with the spin offset that goes with
        it.
        """
        return replace(self, slip_difference="second-order", spin_offset=None)

    def step(self, dq: float) -> TimeStep:
        """The step that is repeated, of a distance `dq` rolled [length]."""
        assert self.spin_offset is not None
        creepages: dict[str, Any] = {"vx": self.vx, "vy": self.vy, "spin": self.spin}
        return TimeStep(dq=dq, Fx=self.Fx, Fy=self.Fy, spin_offset=self.spin_offset, **creepages)


@dataclass(frozen=True, kw_only=True)
class Harmonic(
    Checked, path="motion", wave_number=at_least_zero, **dict.fromkeys(("vx", "vy", "spin"), number)
):
    """Rolling without slip (``friction=inf``) under creepages that swing:
    ``v exp(i k q)`` at the distance rolled q.

    `solve` gives a `HarmonicSolution`, of complex amplitudes.

    Parameters
    ----------
    wave_number : float
        k, circular frequency divided by the rolling velocity [1/length]; up to that of a
        wave of two elements.
    vx, vy, spin : float
        Amplitudes of the creepages, as of `Steady`.
    dq, spin_offset, slip_difference
        As in `Steady`.
    """

    _words: ClassVar = {
        "frequency": "wave_number, the circular frequency divided by the rolling velocity",
        **{
            f"F{i}": f"v{i}, an amplitude: without slip forces are in proportion to creepages"
            for i in "xy"
        },
    }
    wave_number: float
    vx: float = 0.0
    vy: float = 0.0
    spin: float = 0.0
    dq: float | None = None
    spin_offset: float | None = None
    slip_difference: Literal["first-order", "second-order"] = "first-order"
    rolls: ClassVar[int] = 1  # towards positive x

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.free_rolling  # which checks the rest

    @property
    def free_rolling(self) -> Steady:
        """Rolling with the same discretisation, without creepage."""
        return Steady(
            dq=self.dq, spin_offset=self.spin_offset, slip_difference=self.slip_difference
        )


@dataclass(frozen=True, kw_only=True)
class Shift(Checked, path="motion", **dict.fromkeys(("ux", "uy", "rotation", "Fx", "Fy"), number)):
    """A shift in place (Cattaneo's problem): body 1 moves over body 2 by a small rigid motion.

    Parameters
    ----------
    ux, uy : float
        Rigid shift of body 1 over body 2 [length].
    rotation : float
        Its rotation about the z-axis [rad].
    Fx, Fy : float, optional
        Tangential force on body 1 in place of the shift of the same direction
        [force].
    """

    _words: ClassVar = {
        "vx": "ux, or Steady for a creepage",
        "vy": "uy, or Steady for a creepage",
        "spin": "rotation",
    }
    ux: float = 0.0
    uy: float = 0.0
    rotation: float = 0.0
    Fx: float | None = None
    Fy: float | None = None
    rolls: ClassVar[int] = 0  # nothing rolls

    def __post_init__(self) -> None:
        super().__post_init__()
        force_or_rigid(partial(getattr, self), "ux", "uy")

    @property
    def rigid(self) -> tuple[float, float, float]:
        """(ux, uy, rotation)."""
        return self.ux, self.uy, self.rotation

    def step(self, dq: float = 0.0) -> TimeStep:
        """Step in place that equals this shift, whatever `dq`."""
        return TimeStep(
            dq=0.0, ux=self.ux, uy=self.uy, rotation=self.rotation, Fx=self.Fx, Fy=self.Fy
        )


@dataclass(frozen=True, kw_only=True)
class TimeStep:
    """One step of a history: the motion of ``history[k].scene``.

    Parameters
    ----------
    dq, direction, vx, vy, spin, ux, uy, rotation, Fx, Fy, spin_offset, dt
        Those of one step of `Transient`; with a `dq` of 0 it is shifted in
        place.
    """

    dq: float
    direction: int = 1
    vx: float = 0.0
    vy: float = 0.0
    spin: float = 0.0
    ux: float = 0.0
    uy: float = 0.0
    rotation: float = 0.0
    Fx: float | None = None
    Fy: float | None = None
    spin_offset: float = SPIN_OFFSET
    dt: float | None = None

    @property
    def rigid(self) -> tuple[float, float, float]:
        """Shift and creepage in one: (vx, vy, spin) per distance rolled, in a step in place (ux,
        uy, rotation).
        """
        if self.dq == 0:
            return self.ux, self.uy, self.rotation
        return (
            self.vx + self.ux / self.dq,
            self.vy + self.uy / self.dq,
            self.spin + self.rotation / self.dq,
        )

    @property
    def rolls(self) -> int:
        """1 towards positive x, -1 towards negative x, 0 in place."""
        if self.dq > 0:
            return self.direction
        return 0

    def step(self, dq: float = 0.0) -> TimeStep:
        """The step itself, whatever `dq`."""
        return self

    def shift(self, x: np.ndarray, y: np.ndarray, length: float = 1.0) -> np.ndarray:
        """Rigid shift of body 1 over body 2 in the step (75), at `x`, `y` in units of `length`, (2,
        ...) [length].
        """
        dq = self.dq
        turned = (self.spin * dq + self.rotation) * length
        # by spin along the step
        sideways = self.spin * dq * self.spin_offset * self.direction * dq
        along_x = self.vx * dq + self.ux - turned * y
        along_y = self.vy * dq + self.uy + sideways + turned * x
        return np.array([along_x, along_y])


Motion = Steady | Shift | TimeStep
"""The motion of one problem, as solutions have it."""


def force_or_rigid(of: Callable[[str], Any], *names: str, at: str = "") -> None:
    """Refuse a force beside a creepage or a shift along it; `of` has entries by name, `at` is a
    step.
    """
    for name in names:
        force = f"F{name[1]}"
        given = of(force), of(name)
        if given[0] is not None and given[1] != 0:
            raise SceneError(f"motion.{force}{at}, motion.{name}{at}", given, "one of the two only")
