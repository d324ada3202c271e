"""Bodies by numbers of their own: cost of a solution beside the package's half-spaces, and the
errors of half-spaces at a gauge corner by finite elements, in plane strain and in rolling.
"""

import importlib
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

import varcontact as vc
from tests.benchmarks.table import Table, least
from varcontact.discrete.discretisation import discretise
from varcontact.elasticity.operators import _kept_table, influence_operator

NU = 0.3
SIZE = 0.28
EXAMPLES = Path(__file__).parents[2] / "examples"


def half_spaces(kx: np.ndarray, ky: np.ndarray) -> np.ndarray:
    """Compliance of like half-spaces, G = 1."""
    k = np.hypot(kx, ky)
    along = np.stack([kx, ky, 0 * k], -1) / k[:, None]
    both = along[:, :, None] * along[:, None, :] + np.diag([0.0, 0.0, 1.0])
    return 2 / k[:, None, None] * (np.eye(3) - NU * both)


def rolling(bodies: Any, cells: int) -> vc.Scene:
    """A sphere in steady rolling, its distance by samples."""
    side = SIZE / cells
    grid = vc.Grid(nx=cells, ny=cells, dx=side, dy=side, x0=-SIZE / 2, y0=-SIZE / 2)
    return vc.Scene(
        bodies=bodies,
        surface=vc.SampledDistance((grid.x**2 + grid.y[:, None] ** 2) / 2),
        normal_force=1e-3,
        friction=0.3,
        motion=vc.Steady(vx=5e-3),
        grid=grid,
    )


def kernel(cells: int) -> vc.Elasticity:
    """Influence numbers of half-spaces, with a column more for steps of rolling."""
    side = SIZE / cells
    lattice = vc.Grid(nx=cells + 1, ny=cells, dx=side, dy=side, x0=0.0, y0=0.0)
    table = influence_operator(lattice, "xyz", "xyz", nu=NU).table
    return vc.Elasticity(kernel=table, sides=(side, side))


def cost(quick: bool) -> Table:
    """Processor time of steady rolling: of the tables, and of a solution with tables at hand."""
    rows = []
    for cells in (24,) if quick else (24, 48, 96):
        bodies = {
            "half-spaces": vc.Bodies(G=1.0, nu=NU),
            "symbol": vc.Elasticity(symbol=half_spaces),
            "kernel": kernel(cells),
        }
        times = {name: solved(rolling(each, cells)) for name, each in bodies.items()}
        base = times["half-spaces"][1]
        for name, (table, solution) in times.items():
            rows.append([f"{cells} x {cells}", name, 1e3 * table, 1e3 * solution, solution / base])
    head = ("elements", "bodies", "tables, ms", "solution, ms", "by half-spaces")
    return Table(head, ("{}", "{}", ".0f", ".1f", ".2f"), rows)


def solved(scene: vc.Scene) -> tuple[float, float]:
    """Processor seconds of the tables, and of a solution without them."""
    tables = least(partial(tables_of, scene))
    return tables, least(partial(anew, scene), 5) - tables


def anew(scene: vc.Scene) -> None:
    """A solution with tables of its own."""
    _kept_table.cache_clear()
    vc.solve(scene)


def tables_of(scene: vc.Scene) -> None:
    """The numbers that steady rolling of like bodies takes."""
    _kept_table.cache_clear()
    disc = discretise(scene, scene.grid)
    step = scene.grid.dx / disc.scales.length
    disc.operators.tangential(((0.0, 1.0), (step, -1.0)))
    assert disc.operators.normal is not None


def corner(quick: bool) -> Table:
    """Errors of half-spaces at a gauge corner, by half width and size of elements."""
    example = example_of("gauge_corner")
    solve: Callable[..., Any] = example.corner
    rows = []
    for half_width in (4.0,) if quick else (2.0, 3.0, 4.0, 5.0, 6.0):
        for step in (0.4,) if quick else (0.2, 0.1):
            found = solve(half_width, step)
            errors = [each for model in example.MODELS[1:] for each in found.errors(model)]
            peak = found.pressures[example.MODELS[0]].max()
            rows.append([half_width, step, peak, *errors])
    head = (
        "half width, mm", "elements, mm", "peak, N/mm2",
        "plane: peak, %", "width, %", "along the arc: peak, %", "width, %",
    )  # fmt: skip
    return Table(head, ("g", "g", ".0f", "+.2f", "+.1f", "+.2f", "+.1f"), rows)


def rolling_corner(quick: bool) -> Table:
    """Errors of half-spaces at a gauge corner in rolling, and of the elements on flat blocks."""
    example = example_of("gauge_corner_rolling")
    rows = []
    for step in (0.8,) if quick else (0.4, 0.27):
        for half_width in (3.0,) if quick else (2.0, 3.0, 4.0):
            flat = example.flat_blocks(half_width, step)
            rows.append([half_width, step, "flat blocks", *flat.values(), None])
            models = example.rolling(half_width, step)
            exact = models[example.MODELS[0]]
            for name in example.MODELS[1:]:
                errors = models[name].errors(exact).values()
                rows.append([half_width, step, name, *errors, 1e4 * models[name].free_creepage])
            rows[-2][2] = "plane half-spaces"
            rows[-1][2] = "half-spaces along the arc"
            rows.append(
                [half_width, step, "finite elements", *[0.0] * 4, 1e4 * exact.free_creepage]
            )
    head = (
        "half width, mm", "elements, mm", "model", "peak, %", "area, %",
        "Fx by creepage, %", "Fy by spin, %", "free creepage, 1e-4",
    )  # fmt: skip
    return Table(head, ("g", "g", "{}", "+.1f", "+.1f", "+.1f", "+.1f", ".2f"), rows)


def example_of(name: str) -> Any:
    """An example as a module; one imports another."""
    if str(EXAMPLES) not in sys.path:
        sys.path.insert(0, str(EXAMPLES))
    return importlib.import_module(name)


TABLES = {"cost": cost, "corner": corner, "rolling": rolling_corner}
