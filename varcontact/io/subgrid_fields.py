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

ON_PARTS = ("traction_on_parts", "slip_on_parts", "slip_correction", "bound_share")
"""The variables of a refinement; files written before pressures were solved for are without the last."""
PRESSURE = "pressure_on_parts"
ROUNDED = 1e-9
"""Relative difference between forces or means as stored and as summed that counts as rounding."""


def refinement_to(
    found: Refinement,
) -> tuple[dict[str, tuple[tuple[str, ...], np.ndarray, str, str]], dict[str, Any]]:
    """Fields of a refinement by name, with dimensions, quantity and description; and its record."""
    parts, elements = ("component", "y_parts", "x_parts"), ("component", "y", "x")
    fields = {
        "traction_on_parts": (parts, found.traction, "pressure", "tangential traction on body 1, on parts of elements"),
        "slip_on_parts": (parts, found.slip, "slip", "relative slip of the continuum, means over parts of elements"),
        "slip_correction": (elements, found.correction, "slip", "added to the rigid slip of the elements"),
        "bound_share": (("y", "x"), found.share, "1", "what the traction bound of the elements was multiplied by"),
    }
    record = {
        "kind": found.kind,
        "grid": vars(found.grid),
        "forces": found.forces.tolist(),
        "creepages": found.creepages.tolist(),
        "estimate": found.estimate.tolist(),
        "creepage_estimate": found.creepage_estimate.tolist(),
        "seconds": list(found.seconds),
    }
    return fields, record


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
    fields = {name: data[name] for name in ON_PARTS if name in data}
    fields.setdefault("bound_share", np.ones(sol.grid.shape))
    names = ("forces", "creepages", "estimate", "creepage_estimate")
    forces, creepages, estimate, of_creepages = (np.array(record[name], dtype=float) for name in names)
    grid, seconds = Grid(**record["grid"]), tuple(float(each) for each in record["seconds"])
    (ny, nx), (rows, columns), passes = grid.shape, sol.grid.shape, len(seconds)
    found = [each.shape for each in (*fields.values(), forces, creepages, estimate, of_creepages)]
    on_parts = [(2, ny, nx), (2, ny, nx), (2, rows, columns), (rows, columns)]
    if ny % rows or nx % columns or found != [*on_parts, (passes + 1, 3), (passes + 1, 2), (3,), (2,)]:
        raise ValueError("a refinement that is not on parts of the elements")
    if not all(np.isfinite(each).all() for each in (*fields.values(), forces, creepages, estimate, of_creepages)):
        raise ValueError("a refinement that is not of finite numbers")
    return Refinement(
        kind=str(record["kind"]),
        grid=grid,
        traction=fields["traction_on_parts"],
        slip=fields["slip_on_parts"],
        correction=fields["slip_correction"],
        share=fields["bound_share"],
        forces=forces,
        creepages=creepages,
        estimate=estimate,
        creepage_estimate=of_creepages,
        seconds=seconds,
    )
