"""The answer of a transient scene: one solution after the other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, overload

import numpy as np

from varcontact import checks
from varcontact.discrete.stick_slip import EXTERIOR
from varcontact.errors import SceneError
from varcontact.html import Reported
from varcontact.interfaces.heat import Heat, heating, temperatures_in_time
from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady, TimeStep
from varcontact.scene.scene import Scene

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def heat_of(step: Solution) -> Heat:
    """Frictional heat in a step of a history, or in as much of steady rolling."""
    motion = step.motion
    if isinstance(motion, Steady):
        dq = motion.dq or step.grid.sides[0]
        motion = replace(motion.step(dq), dt=dq / (motion.speed or np.nan))
    assert isinstance(motion, TimeStep)
    return Heat.of(heating(step.scene, step.power_density), step.state != EXTERIOR, motion)


def heat_before(start: Solution | None) -> list[Heat]:
    """Heat before the start of a history: steady rolling for ever, or one step; none if times are
    unknown.
    """
    if start is None:
        return []
    if isinstance(start.motion, TimeStep):
        return [] if start.motion.dt is None else [heat_of(start)]
    if not isinstance(start.motion, Steady) or start.motion.speed is None:
        return []
    heat = heat_of(start)
    return [heat] * math.ceil(2 + start.grid.nx * start.grid.sides[0] / heat.rolled)


def heat_matters(scene: Scene) -> bool:
    """True where friction depends on the heat of earlier steps."""
    return scene.warm


def heat_so_far(scene: Scene, start: Solution | None, steps: Iterable[Heat]) -> list[Heat]:
    """Heat of the start and of the first steps of a history; none if friction does not depend on
    it.
    """
    if not heat_matters(scene):
        return []
    return [*heat_before(start), *steps]


def series_of(history: History, name: str, shape: tuple[int, ...] = ()) -> np.ndarray:
    """Values of all steps under a name, (steps, *shape); of a file without the steps' fields."""
    from varcontact.io.history import Stored

    if isinstance(history.solutions, Stored):
        return history.solutions.series(name)
    return np.array([getattr(sol, name) for sol in history.solutions]).reshape(len(history), *shape)


def _series(name: str, words: str, *shape: int) -> np.ndarray:
    """A property, to type checkers the array that it has."""
    return cast("np.ndarray", property(lambda history: series_of(history, name, shape), doc=words))


@dataclass(frozen=True, eq=False)
class History(Reported, Sequence[Solution]):
    """The steps of a transient scene that are solved: ``history[k]`` is the
    Solution of step k, from 0.

    Attributes
    ----------
    scene : Scene
        The whole, with its `Transient`.
    grid : Grid
        The potential contact of all steps.
    solutions : sequence of Solution
        In memory, or read from a file one by one when asked for.
    settings : dict
        Tolerance and polish that it was solved with: who goes on with it has to
        ask for the same.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.25), surface=vc.Cylinders(R=1.0), normal_force=1e-3,
    ...     friction=0.3, motion=vc.Transient(steps=3, dq=[0, 0.01, 0.01], Fx=-2e-4),
    ...     grid=vc.Grid(nx=20))
    >>> history = vc.solve(scene)
    >>> print(len(history), history.rolled, history[-1].elements)
    3 [0.   0.01 0.02] {'contact': 20, 'stick': 14, 'slip': 6}
    """

    scene: Scene
    grid: Grid
    solutions: Sequence[Solution]
    settings: dict[str, Any] = field(default_factory=dict)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Plausibility warnings of the scene, see `Scene.doubts`."""
        return self.scene.doubts

    def __len__(self) -> int:
        return len(self.solutions)

    @overload
    def __getitem__(self, k: int) -> Solution: ...

    @overload
    def __getitem__(self, k: slice) -> list[Solution]: ...

    def __getitem__(self, k: int | slice) -> Solution | list[Solution]:
        if isinstance(k, slice):
            return [self.solutions[each] for each in range(*k.indices(len(self)))]
        return self.solutions[k]

    @property
    def dq(self) -> np.ndarray:
        """Distance rolled in each step [length], shape (steps,)."""
        return np.array(
            [self.scene.motion.step(k, self.grid.sides[0]).dq for k in range(len(self))]
        )

    @property
    def rolled(self) -> np.ndarray:
        """Distance rolled since the start, in either direction, at the end of each step [length];
        (steps,).
        """
        return np.cumsum(self.dq)

    @property
    def position(self) -> np.ndarray:
        """Position of the contact along x since the start [length]: rolling backward takes it
        back; (steps,).
        """
        return np.cumsum(self.dq * self.scene.motion.every("direction")[: len(self)])

    force = _series("force", "Tangential force (Fx, Fy) on body 1, shape (steps, 2).", 2)
    normal_force = _series("normal_force", "Total compressive force, shape (steps,).")
    moment = _series("moment", "Twisting moment Mz on body 1, shape (steps,).")
    approach = _series("approach", "Approach of the bodies [length], shape (steps,).")
    creepage = _series(
        "creepage",
        "(vx, vy, spin), in steps that do not roll (ux, uy, rotation); shape (steps, 3).",
        3,
    )

    @property
    def dissipation(self) -> np.ndarray:
        """Work lost by friction in each step [force length], shape (steps,)."""
        dq = self.dq
        return series_of(self, "friction_work") * np.where(dq > 0, dq, 1.0)

    @checks.named_options()
    def temperature(self, k: int = -1) -> np.ndarray:
        """Temperature of the surfaces of body 1 and body 2 at the end of a
        step, followed along the material.

        A start in steady rolling went on for ever; of another one only its own
        step has heated.

        Parameters
        ----------
        k : int
            The step, from 0; the last one by default.

        Returns
        -------
        ndarray, shape (2, ny, nx)

        Raises
        ------
        SceneError
            Without thermal data, or if there is no such step.
        """
        thermal = self.scene.thermal
        n = len(self)
        if thermal is None:
            raise SceneError("thermal", None, "given: the thermal data of both bodies")
        count = checks.whole("k", k, -n, n - 1) % n + 1
        path = [*heat_before(self.scene.motion.start), *map(heat_of, self[:count])]
        return temperatures_in_time(path, self.grid.sides[0], thermal)

    @checks.named_options()
    def work_along(self, period: float | None = None) -> xr.DataArray:
        """Work lost by friction at its place on the bodies: per area, along the
        distance X that they have rolled.

        The work of a step lies where its particles were in the middle of the
        step, on elements of the grid's length; the sum is that of
        `dissipation`, whatever the steps are. By a law of wear (a depth k/(f H)
        times the work by Archard's, for a coefficient of friction f) it is what
        `Carried.worn` takes off.

        Parameters
        ----------
        period : float, optional
            Length after which the way repeats [length], a whole number of
            elements, as a wheel's circumference.

        Returns
        -------
        xarray.DataArray, dims (y, X)
            [force/length]

        Raises
        ------
        SceneError
            If the period is no whole number of elements, or no step was solved.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=1.0, nu=0.25), surface=vc.Cylinders(R=1.0), normal_force=1e-3,
        ...     friction=0.3, motion=vc.Transient(steps=50, dq=0.007, Fx=-2e-4),
        ...     grid=vc.Grid(nx=20))
        >>> history = vc.solve(scene)
        >>> work = history.work_along()
        >>> print(f"{float(work.sum()) * history.grid.area / history.dissipation.sum():.12f}")
        1.000000000000
        """
        import xarray as xr

        grid = self.grid
        dx = grid.sides[0]
        repeat = self._elements_of_period(period)
        if len(self) == 0:
            raise SceneError("history", "no steps", "with one step at least")
        # places of the steps: whole elements passed, and the part of the next one
        dq = self.dq
        middle = self.position - self.scene.motion.every("direction")[: len(self)] * dq / 2
        passed = (middle - middle.min()) / dx
        whole = np.floor(np.round(passed, 9)).astype(int)
        part = np.maximum(passed - whole, 0.0)
        # work of each step, shared between both elements
        count = int(whole.max()) + grid.nx + 1
        work = np.zeros((grid.rows, count))
        for k, sol in enumerate(self):
            lost = sol.power_density * (dq[k] or 1.0)
            work[:, whole[k] : whole[k] + grid.nx] += lost * (1 - part[k])
            work[:, whole[k] + 1 : whole[k] + 1 + grid.nx] += lost * part[k]
        start = (self.scene.motion.rolled or 0.0) + float(middle.min()) + grid.x[0]
        # the sum over all periods
        if repeat is not None:
            padded = np.pad(work, ((0, 0), (0, -count % repeat)))
            work = padded.reshape(grid.rows, -1, repeat).sum(axis=1)
            count = repeat
        coordinates = {"y": grid.y, "X": start + dx * np.arange(count)}
        return xr.DataArray(work, coordinates, ("y", "X"), "work", {"units": "force/length"})

    def _elements_of_period(self, period: float | None) -> int | None:
        """Number of elements in a period, checked to be whole."""
        if period is None:
            return None
        dx = self.grid.sides[0]
        elements = checks.positive("period", period) / dx
        count = round(elements)
        if count < 1 or abs(elements - count) > 1e-6 * elements:
            raise SceneError("period", period, f"a whole number of elements of {dx:.6g}")
        return count

    @property
    def error_estimate(self) -> ErrorEstimate | None:
        """Distance of the steps from the continuum, named as ``Fx[3]``: to an accuracy, or within a
        time.
        """
        if len(self) == 0 or self[0].error_estimate is None:
            return None
        return ErrorEstimate.of_history(
            [sol.error_estimate for sol in self if sol.error_estimate is not None]
        )

    def report(self) -> str:
        """The history in words, for people: forces of some steps, and the last step."""
        from varcontact.results.report import report_history

        return report_history(self)

    def __repr__(self) -> str:
        return f"History({len(self)} of {self.scene.motion.steps} steps)"

    def summary(self) -> dict[str, Any]:
        """Series of all steps, and the last in full, as plain numbers: what ``varcontact solve
        --json`` prints.
        """
        from varcontact.results.report import plain

        series = (
            "rolled",
            "normal_force",
            "force",
            "moment",
            "approach",
            "creepage",
            "dissipation",
            "error_estimate",
        )
        last = None
        if len(self) > 0:
            last = self[-1].summary()
        return {
            "steps": self.scene.motion.steps,
            "finished": len(self),
            **{name: plain(getattr(self, name)) for name in series},
            "last": last,
        }

    def to_xarray(self) -> xr.Dataset:
        """All fields and forces stacked along ``step``, with coordinates and units; from a file
        read when used.
        """
        from varcontact.io.history import dataset

        return dataset(self)

    @checks.named_options()
    def save(self, path: str | Path, overwrite: bool = False) -> None:
        """Write a netCDF file; `varcontact.load` reads it back, and `solve` with it as `store` goes
        on from it.

        A history that is at `path`, which ends in ``.nc``, is replaced, unless a run is just adding
        to it; any other file only with `overwrite`. OutputError if the file cannot be written, or
        holds something else.
        """
        from varcontact.io.history import save

        save(self, path, overwrite)

    @checks.named_options()
    def plot(self, figsize: tuple[float, float] | None = None) -> Figure:
        """Picture of the forces, the creepages that prescribed forces gave, and the areas along the
        middle row.

        All over the distance rolled; over the steps where there are some in place after the first.
        `figsize` is in inches.
        """
        from varcontact.plotting.history import plot_history

        return plot_history(self, figsize)

    @checks.named_options()
    def animate(self, path: str | Path, fps: float = 10.0, overwrite: bool = False) -> None:
        """Write a moving picture: stick and slip with the tractions in each step, over the forces
        of all.

        The `path` ends in ``.gif``, or in ``.mp4`` where the program ffmpeg is installed; `fps` are
        steps a second, 100 at most; with `overwrite` a file is replaced that is no picture which
        varcontact drew. OutputError if the file cannot be written, holds something else, or has
        another ending; SceneError without steps, or for a rate that is none.
        """
        from varcontact.plotting.history import animate

        animate(self, path, fps, overwrite=overwrite)
