"""Fields on parts of the elements in a file: a pressure that was solved for there, and a refinement with its record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.discrete.state import means
from varcontact.results.refinement import Refinement
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid

PARTS, ELEMENTS = ("component", "y_parts", "x_parts"), ("component", "y", "x")
FIELDS = {
    "traction_on_parts": ("traction", PARTS, "pressure", "tangential traction on body 1, on parts of elements"),
    "slip_on_parts": ("slip", PARTS, "slip", "relative slip of the continuum, means over parts of elements"),
    "slip_correction": ("correction", ELEMENTS, "slip", "added to the rigid slip of the elements"),
    "bound_share": ("share", ("y", "x"), "1", "what the traction bound of the elements was multiplied by"),
}
"""Variables of a refinement, by name its entry; files written before pressures were solved for are without the last."""
SERIES = ("forces", "creepages", "estimate", "creepage_estimate")
PRESSURE = "pressure_on_parts"
ROUNDED = 1e-9
"""Relative difference between forces or means as stored and as summed that counts as rounding."""


def refinement_to(
    found: Refinement,
) -> tuple[dict[str, tuple[tuple[str, ...], np.ndarray, str, str]], dict[str, Any]]:
    """Fields of a refinement by name, with dimensions, quantity and description; and its record."""
    fields = {name: (dims, getattr(found, entry), *said) for name, (entry, dims, *said) in FIELDS.items()}
    series = {name: getattr(found, name).tolist() for name in SERIES}
    return fields, {"kind": found.kind, "grid": vars(found.grid), **series, "seconds": list(found.seconds)}


def with_pressure(sol: Solution, pressure: np.ndarray | None) -> Solution:
    """A solution with the pressure on parts of the elements that its file has."""
    wanted = sol.plan.cells(sol.scene) != (1, 1)
    if (pressure is not None) != wanted:
        raise ValueError("a pressure on parts of the elements that is missing, or should be")
    if pressure is None:
        return sol
    (ny, nx), shape = sol.grid.shape, pressure.shape
    if len(shape) != 2 or 0 in shape or shape[0] % ny or shape[1] % nx or not np.isfinite(pressure).all():
        raise ValueError("a pressure that is not on parts of the elements")
    if not np.allclose(
        means(pressure, (shape[0] // ny, shape[1] // nx)), sol.pressure, rtol=0, atol=ROUNDED * pressure.max()
    ):
        raise ValueError("a pressure on parts of the elements that these do not bear")
    return replace(sol, pressure_on_parts=pressure)


def refinement_from(data: Mapping[str, Any], record: dict[str, Any], sol: Solution) -> Refinement:
    """A refinement from its file."""
    fields = {entry: data[name] for name, (entry, *_) in FIELDS.items() if name in data}
    fields.setdefault("share", np.ones(sol.grid.shape))
    series = {name: np.array(record[name], dtype=float) for name in SERIES}
    grid, seconds = Grid(**record["grid"]), tuple(float(each) for each in record["seconds"])
    (ny, nx), (rows, columns), passes = grid.shape, sol.grid.shape, len(seconds)
    on_parts = [(2, ny, nx), (2, ny, nx), (2, rows, columns), (rows, columns)]
    arrays = [*fields.values(), *series.values()]
    shapes = [*on_parts, (passes + 1, 3), (passes + 1, 2), (3,), (2,)]
    if ny % rows or nx % columns or [each.shape for each in arrays] != shapes:
        raise ValueError("a refinement that is not on parts of the elements")
    if not all(np.isfinite(each).all() for each in arrays):
        raise ValueError("a refinement that is not of finite numbers")
    return Refinement(kind=str(record["kind"]), grid=grid, **fields, **series, seconds=seconds)
