"""Errors of gradients: the difference to elements twice as large."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.errors import SceneError
from varcontact.gradients.outputs import Output, Weight, Weighted
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady, TimeStep
from varcontact.scene.surfaces import SampledDistance
from varcontact.solving.solve import solve


def on_half_the_elements(solution: Solution) -> Solution:
    """Scene solved on elements twice as large; fields given by element are averaged."""
    scene = solution.scene
    grid = solution.grid
    if isinstance(scene.motion, TimeStep):
        raise SceneError("error", True, "False: a step of a history is solved after those before")
    _check_period(grid)
    sides: dict[str, Any] = {"nx": (grid.nx + 1) // 2, "dx": 2 * grid.sides[0]}
    if not grid.line:
        sides |= {"ny": (grid.rows + 1) // 2, "dy": 2 * grid.sides[1]}
    changes: dict[str, Any] = {"grid": replace(grid, **sides)}
    if isinstance(scene.motion, Steady) and scene.motion.dq is not None:
        changes["motion"] = replace(scene.motion, dq=2 * scene.motion.dq)
    if isinstance(scene.friction, np.ndarray):
        changes["friction"] = means(scene.friction, grid)
    if isinstance(scene.surface, SampledDistance) and scene.surface.x is None:
        samples = means(scene.surface.samples, grid)
        if grid.line:
            samples = samples[0]
        changes["surface"] = replace(scene.surface, h=samples)
    return solve(replace(scene, **changes), normal=solution.plan.normal, certify="none")


def _check_period(grid: Grid) -> None:
    """Refuse a period of an odd number of elements: larger ones would change it."""
    odd_rows = grid.periodic is True and not grid.line and grid.rows % 2 == 1
    if odd_rows or (grid.periodic and grid.nx % 2 == 1):
        allowed = "False: the period is no whole number of elements twice as large"
        raise SceneError("error", True, allowed)


def output_on_half_the_elements(output: Output, grid: Grid) -> Output:
    """Output on elements twice as large; weights given by element are averaged."""
    if not isinstance(output, Weighted):
        return output

    along_x, along_y = output.traction
    return replace(
        output,
        pressure=_means_of_weight(output.pressure, grid),
        traction=(_means_of_weight(along_x, grid), _means_of_weight(along_y, grid)),
    )


def _means_of_weight(weight: Weight, grid: Grid) -> Weight:
    if callable(weight) or np.ndim(weight) == 0:
        return weight
    return means(np.broadcast_to(np.asarray(weight, float), grid.shape), grid)


def means(field: np.ndarray, grid: Grid) -> np.ndarray:
    """Means of a field (ny, nx) over elements twice as large; beyond an odd number of elements it
    is extrapolated linearly.
    """
    values = np.asarray(field, float).reshape(grid.shape)
    whole = np.pad(values, _beyond(grid), "reflect", reflect_type="odd")
    found: np.ndarray = _in_blocks(whole, grid).mean(axis=(1, 3))
    return found


def difference(fine: np.ndarray, coarse: np.ndarray, grid: Grid) -> np.ndarray:
    """Size of the difference of derivatives on two grids: of numbers, (outputs,), or of fields,
    (outputs, ny, nx). Those by the elements of a larger one are summed; the difference is shared
    among them.
    """
    if fine.ndim == 1:
        return np.abs(fine - coarse)
    rows, columns = grid.shape
    block = np.ones((_rows_of_block(grid), 2))
    found = []
    for own, larger in zip(fine, coarse, strict=True):
        whole = np.pad(own, _beyond(grid))
        sums = _in_blocks(whole, grid).sum(axis=(1, 3))
        shared = np.kron(np.abs(sums - larger) / block.size, block)
        found.append(shared[:rows, :columns])
    return np.array(found)


def _beyond(grid: Grid) -> tuple[tuple[int, int], tuple[int, int]]:
    """Rows and columns by which larger elements reach beyond the grid."""
    rows, columns = grid.shape
    return (0, -rows % _rows_of_block(grid)), (0, columns % 2)


def _rows_of_block(grid: Grid) -> int:
    """Rows of elements in one that is twice as large."""
    if grid.line:
        return 1
    return 2


def _in_blocks(field: np.ndarray, grid: Grid) -> np.ndarray:
    """A field by larger elements: (ny, rows of a block, nx, 2)."""
    high = _rows_of_block(grid)
    rows, columns = field.shape
    return field.reshape(rows // high, high, columns // 2, 2)
