"""Many scenes in batches, to an accuracy on ever finer grids, or on grids of their own."""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import itemgetter

import numpy as np

from varcontact.reference.hertz import HertzContact
from varcontact.results.quantities_of_interest import frictional_units
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.solving.batched_on_grids import (
    FIGURES,
    MOST_ELEMENTS,
    MOST_IN_LINE,
    Fields,
    Figures,
    InitialTractions,
    leaves_grid,
    on_grids,
    power_supplied,
)
from varcontact.solving.grid_sequence import (
    FLOOR,
    ORDER,
    RATIO,
    GridSequence,
    coarsest,
    gridded,
)
from varcontact.solving.options import DEFAULT_ACCURACY
from varcontact.system.process import one_blas_thread

VALUES = ("Fx", "Fy", "Mz", "vx", "vy")
"""Figures that have an error against the continuum."""
BARS = tuple(f"{name}_error" for name in VALUES)
"""Names of the errors."""


@one_blas_thread()
def solve_batches(
    scenes: Sequence[Scene],
    tol: float,
    accuracy: float | None = None,
    kept: Fields | None = None,
    near: InitialTractions | None = None,
    some: Sequence[int] | None = None,
) -> tuple[Figures, np.ndarray]:
    """The figures of the scenes that batches solve, NaN of the others; and a mask of the former.

    Scenes without a grid are solved to the accuracy, 0.01 if none is given, and have the error
    bars, too. `kept` gets the fields of the others. `some` are the numbers of those that are to be
    solved at all.
    """
    numbers = list(range(len(scenes)))
    if some is not None:
        numbers = list(some)
    gridded_ones = [k for k in numbers if isinstance(scenes[k].grid, Grid)]
    figures, solved = on_grids(scenes, gridded_ones, tol, kept, near)
    for line in (False, True):
        free = [k for k in numbers if scenes[k].line == line and leaves_grid(scenes[k])]
        if not free:
            continue
        of_free, free_solved = _to_accuracy(
            [scenes[k] for k in free], accuracy or DEFAULT_ACCURACY, tol
        )
        for name, values in of_free.items():
            figures.setdefault(name, np.full(len(scenes), math.nan))[free] = values
        solved[free] = free_solved
    return figures, solved


def _to_accuracy(
    scenes: Sequence[Scene], accuracy: float, tol: float
) -> tuple[Figures, np.ndarray]:
    """Figures of scenes on three grids or more until the error is small enough (the rule of
    `GridSequence`), with error bars as ``Fx_error``; and True for scenes that reach it.
    """
    figures = {name: np.full(len(scenes), math.nan) for name in (*FIGURES, *BARS)}
    solved = np.zeros(len(scenes), bool)
    left = np.arange(len(scenes))
    line = scenes[0].line
    sequence = GridSequence[Figures](coarsest(line, accuracy))
    while left.size and _small_enough(n := int(sequence.n), line):
        on_grid = [gridded(scenes[k], True, n) for k in left.tolist()]
        figures_on_grid, goes_on = on_grids(on_grid, range(len(on_grid)), tol)
        sequence.learn(figures_on_grid)
        if not sequence.few:
            best, error = _extrapolated(on_grid, sequence)
            accurate = goes_on & (error <= accuracy)
            for name, values in best.items():
                figures[name][left[accurate]] = values[accurate]
            solved[left[accurate]] = True
            goes_on &= ~accurate
        left = left[goes_on]
        sequence.levels = [
            {name: values[goes_on] for name, values in of_level.items()}
            for of_level in sequence.levels
        ]
    return figures, solved


def _small_enough(n: int, line: bool) -> bool:
    """True if lattices with n elements across the contact are small enough for batches."""
    if line:
        return n <= MOST_IN_LINE
    return n * round(RATIO * n) <= MOST_ELEMENTS


def _extrapolated(
    scenes: list[Scene], sequence: GridSequence[Figures]
) -> tuple[Figures, np.ndarray]:
    """Figures with their error bars, extrapolated from three grids; and the largest error of each
    scene, as a part of its unit.
    """
    finest = sequence.levels[-1]
    floor = FLOOR * sequence.across[-1] ** -ORDER
    limit, units = _units(scenes)
    best = dict(finest)
    errors = {}
    for name, unit in units.items():
        value, error = sequence.extrapolated(itemgetter(name))
        best[name] = np.where(np.isnan(unit), finest[name], value)
        errors[f"{name}_error"] = error + floor * unit
    # extrapolated forces may exceed the friction limit slightly
    beyond = np.maximum(np.hypot(best["Fx"], best["Fy"]) / limit, 1.0)
    best |= {name: best[name] / beyond for name in ("Fx", "Fy")}
    rolls = np.array([isinstance(scene.motion, Steady) for scene in scenes])
    best["friction_work"] = np.where(rolls, power_supplied(best), finest["friction_work"])
    largest = np.fmax.reduce([errors[f"{name}_error"] / unit for name, unit in units.items()])
    return best | errors, largest


def _units(scenes: Sequence[Scene]) -> tuple[np.ndarray, Figures]:
    """Friction limits, and the units of errors of the values that a scene does not prescribe; NaN
    for the others.
    """
    limits = np.zeros(len(scenes))
    all_units = {name: np.full(len(scenes), math.nan) for name in VALUES}
    for k, scene in enumerate(scenes):
        hertz = scene.hertz
        motion = scene.motion
        assert isinstance(hertz, HertzContact)
        assert isinstance(scene.friction, float)
        limits[k] = scene.friction * hertz.force
        width = 1.0 if scene.line else hertz.b
        units = frictional_units(limits[k], hertz.a, width, scene.bodies, scene.line)
        if not scene.line:
            all_units["Mz"][k] = units["Mz"]
        rigid = "v" if isinstance(motion, Steady) else "u"
        for axis in "xy":
            if getattr(motion, f"F{axis}") is None:
                all_units[f"F{axis}"][k] = units[f"F{axis}"]
            else:
                all_units[f"v{axis}"][k] = units[f"{rigid}{axis}"]
    return limits, all_units
