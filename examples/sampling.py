"""What forces depend on: where spin is sampled, how long the step is, which elements are in
contact, the margin.

Run: python examples/sampling.py [picture.png]
"""

from __future__ import annotations

import sys
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

import varcontact as vc
from varcontact.reference import creepage_coefficients

BODIES = vc.Bodies(G=1.0, nu=0.25)
OFFSETS = tuple(Fraction(part) for part in ("0", "1/6", "1/4", "1/3", "1/2"))
USUAL = 1  # CONTACT's 1/6
STEPS = (0.25, 0.5, 1.0, 2.0)
# of the lattice, in parts of an element
PLACES = ((0.0, 0.0), (0.25, 0.5), (0.5, 0.25), (0.75, 0.75))
FRICTION = 0.3
CREEPAGES = {
    "vx": {"vx": 0.06},
    "vy": {"vy": 0.06},
    "spin": {"spin": 0.1},
    "vx, spin": {"vx": 0.05, "spin": 0.05},
    "vy, spin": {"vy": -0.06, "spin": 0.1},
}
EDGES = ("centres", "touched")
COMPONENTS = ("Fx", "Fy", "Mz")


def scene(ratio: float = 1.0, **rest: Any) -> vc.Scene:
    """An ellipse with ab = 1 and a/b = ratio under a force of 1; the limit of friction is 0.3."""
    a = ratio**0.5
    return vc.Scene(
        bodies=BODIES, surface=vc.Ellipse(a=a, b=1 / a), normal_force=1.0, friction=FRICTION, **rest
    )


def row(name: str, figures: Any) -> None:
    """A line of a table."""
    print(
        f"{name:22}"
        + "".join(f"{each if isinstance(each, str) else f'{each:.2f}':>13}" for each in figures),
        flush=True,
    )


def no_slip_forces(scene: vc.Scene) -> np.ndarray:
    """Fx, Fy and Mz (rows) of unit creepages vx, vy and spin (columns) where nothing slips."""
    units = [replace(scene.motion, vx=vx, vy=vy, spin=spin) for vx, vy, spin in np.eye(3)]
    found = [
        vc.solve(replace(scene, friction=np.inf, motion=unit), certify="none") for unit in units
    ]
    return np.transpose([[*each.force, each.moment] for each in found])


def coefficients(
    ratio: float, cells: int, edge: str, step: float, place: tuple[float, float]
) -> np.ndarray:
    """C11, C22, C23, C33 without slip, by sampling point: shape (5, 4)."""
    a, n = ratio**0.5, cells + any(place)
    dx, dy = 2 * a / cells, 2 / a / cells
    grid = vc.Grid(
        nx=n, ny=n, dx=dx, dy=dy, x0=-a - place[0] * dx, y0=-1 / a - place[1] * dy, edge=edge
    )
    motion = vc.Steady(dq=step * dx, spin_offset=0.0)
    (C11, _, _), (_, C22, C23), (_, C32, C33) = -no_slip_forces(
        scene(ratio, motion=motion, grid=grid)
    )
    # spin sampled at x + theta dq is spin sampled at x with a lateral creepage of theta dq spin
    return np.array(
        [
            [C11, C22, C23 + t * step * dx * C22, C33 + t * step * dx * C32]
            for t in map(float, OFFSETS)
        ]
    )


def errors(
    ratio: float, cells: int, edge: str = "centres", step: float = 1.0
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation over the places of the lattice, in per cent of the computed
    coefficients, (5, 4).
    """
    table = creepage_coefficients(ratio**0.5, ratio**-0.5, BODIES.combined_nu)
    exact = np.array([table.C11, table.C22, table.C23, table.C33])
    found = np.array([coefficients(ratio, cells, edge, step, place) for place in PLACES])
    return 100 * (found.mean(axis=0) / exact - 1), 100 * (found / exact).std(axis=0)


def without_slip(
    ratios: tuple[float, ...], cells: tuple[int, ...]
) -> dict[tuple[float, int], np.ndarray]:
    """Errors of the creepage coefficients by sampling point, step and edge."""
    print(
        "No slip: mean errors over four places of the lattice in % of the limit, "
        "(noise) of a single place"
    )
    row(
        "a/b, cells",
        ["C11", "C22", *(f"C23, {t}" for t in OFFSETS), *(f"C33, {t}" for t in OFFSETS)],
    )
    found = {}
    for ratio, n in product(ratios, cells):
        mean, noise = errors(ratio, n)
        figures = [(mean[0, i], noise[0, i]) for i in (0, 1)] + list(
            zip(mean[:, 2], noise[:, 2], strict=True)
        )
        figures += list(zip(mean[:, 3], noise[:, 3], strict=True))
        row(f"{ratio:g}, {n}", [f"{mean:.1f} ({noise:.1f})" for mean, noise in figures])
        found[ratio, n] = mean
    n = max(cells) // 2
    print(f"\nThe same with {n} cells, spin at 1/6, by step dq/dx and edge")
    row("a/b, edge, dq/dx", ["C11", "C22", "C23", "C33"])
    for ratio, (edge, step) in product(
        ratios, [*(("centres", s) for s in STEPS), ("touched", 1.0)]
    ):
        mean, noise = (each[USUAL] for each in errors(ratio, n, edge, step))
        row(
            f"{ratio:g}, {edge}, {step:g}",
            [f"{m:.1f} ({s:.1f})" for m, s in zip(mean, noise, strict=True)],
        )
    return found


def studies(ratio: float, cells: tuple[int, ...]) -> dict[tuple[str, str], vc.Convergence]:
    """Forces with slip on all grids, for each creepage and edge."""
    return {
        (name, edge): vc.converge(
            scene(ratio, motion=vc.Steady(**given), grid=vc.Grid(nx=2, ny=2, edge=edge)),
            cells,
            offsets=1,
            tol=1e-8,
        )
        for name, given in CREEPAGES.items()
        for edge in EDGES
    }


def quantities(name: str) -> list[str]:
    """The components of force and moment that symmetry does not make zero."""
    return [each for each in COMPONENTS if (each == "Fx") == ("vx" == name) or name == "vx, spin"]


def limits(found: dict[tuple[str, str], vc.Convergence]) -> dict[tuple[str, str], float]:
    """What forces and moment tend to, by creepage and component, in parts of f Fz: the mean by both
    edges.
    """
    print(
        "\nWith slip: extrapolated from all grids, with error bars; "
        "% of f Fz (Mz: times (ab)^(1/2)). Then their mean"
    )
    row("", ["touched", "", "order", "centres", ""])
    exact = {}
    for name in CREEPAGES:
        for each in quantities(name):
            touched, centres = (found[name, edge].limit(each) for edge in reversed(EDGES))
            exact[name, each] = (touched["value"] + centres["value"]) / 2 / FRICTION
            figures = [touched["value"], touched["error"], centres["value"], centres["error"]]
            shown = [100 * figure / FRICTION for figure in figures]
            row(f"{name}: {each}", [*shown[:2], touched["order"], *shown[2:]])
    return exact


def by_edge(
    found: dict[tuple[str, str], vc.Convergence], exact: dict[tuple[str, str], float]
) -> dict[str, Any]:
    """Errors by edge, on each grid and extrapolated by two grids as of order 1: root mean squares,
    in % of f Fz.
    """
    left = {}
    for edge in EDGES:
        runs = {name: found[name, edge].runs.set_index("cells") for name in CREEPAGES}
        values = {key: runs[key[0]][key[1]] / FRICTION - limit for key, limit in exact.items()}
        cells = list(runs["vx"].index)
        for n in cells:
            left[edge, (n,)] = _rms([value[n] for value in values.values()])
            if 2 * n in cells:
                left[edge, (n, 2 * n)] = _rms(
                    [2 * value[2 * n] - value[n] for value in values.values()]
                )
    print(
        "\nWith slip, by edge: root mean square of the errors of all in % of f Fz; "
        "(n, 2 n): extrapolated as of order 1"
    )
    grids = [grid for edge, grid in left if edge == "touched"]
    grids.sort(key=lambda grid: (len(grid), grid))
    row("", [", ".join(map(str, grid)) for grid in grids])
    for edge in EDGES:
        row(edge, [left[edge, grid] for grid in grids])
    return left


def by_step(exact: dict[tuple[str, str], float], cells: tuple[int, ...]) -> None:
    """Errors by sampling point and by length of the step, in % of f Fz."""
    print(
        "\nWith slip, by sampling point (dq = dx), and by step dq/dx (at 1/6): "
        "errors in % of f Fz, elements by centres"
    )
    row("cells", [*(str(t) for t in OFFSETS), *(f"dq/dx = {s:g}" for s in STEPS)])
    for n in cells:
        choices = [
            *((float(t), 1.0) for t in OFFSETS),
            *((float(OFFSETS[USUAL]), step) for step in STEPS),
        ]
        kept = {
            (name, each): 100 * (value / FRICTION - exact[name, each])
            for name in CREEPAGES
            for each, value in _sampled(name, n, choices).items()
            if (name, each) in exact
        }
        for (name, each), errors in kept.items():
            row(f"{n}, {name}: {each}", errors)
        row(f"{n}, root mean square", np.sqrt(np.mean(np.square(list(kept.values())), axis=0)))


def _sampled(name: str, cells: int, choices: list[tuple[float, float]]) -> dict[str, np.ndarray]:
    """Fx, Fy and Mz by sampling point and step; where there is no spin, the point is all the
    same.
    """
    given, grid, known = CREEPAGES[name], vc.Grid(nx=cells, ny=cells), {}
    keys = [(offset if "spin" in given else 0.0, step) for offset, step in choices]
    for offset, step in dict.fromkeys(keys):
        motion = vc.Steady(**given, dq=2 * step / cells, spin_offset=offset)
        sol = vc.solve(scene(motion=motion, grid=grid), tangential="tang-safeguarded")
        known[offset, step] = [*sol.force, sol.moment]
    return dict(zip(COMPONENTS, np.transpose([known[key] for key in keys]), strict=True))


def _rms(values: list[float]) -> float:
    return 100 * float(np.sqrt(np.mean(np.square(values))))


def by_margin(cells: int) -> dict[str, list[float]]:
    """How far forces and approach are from those with a margin of 1, in parts of f Fz and of the
    approach.
    """
    x, hertz = np.linspace(-2.5, 2.5, 101), scene().hertz
    sampled = vc.SampledDistance(x**2 / (2 * hertz.Rx) + x[:, None] ** 2 / (2 * hertz.Ry), x=x, y=x)
    like = scene(motion=vc.Steady(vx=0.05, spin=0.05))
    unlike = replace(like, bodies=vc.Bodies(G=(0.5, float("inf")), nu=0.0))
    scenes = {
        "Hertz, K = 0": like,
        "sampled, K = 0": replace(like, surface=sampled),
        "K = 0.5, f = 0.3": unlike,
        "K = 0.5, f = 1": replace(unlike, friction=1.0, motion=vc.Steady(vx=0.6)),
        "K = 0.5, f = 3": replace(unlike, friction=3.0, motion=vc.Shift(ux=2.0)),
    }
    print(
        "\nMargin: largest change of a force by f Fz, or of the approach, "
        "against a margin of 1; elements of the grid"
    )
    margins = (0, 1, 2, 4)
    row("", [f"margin {m}" for m in margins])
    found = {}
    for name, each in scenes.items():
        normal = "hertz" if name == "Hertz, K = 0" else "norm"
        grids = [vc.Grid(nx=cells, ny=cells, margin=m) for m in margins]
        sols = [vc.solve(replace(each, grid=grid), normal, "tang-safeguarded") for grid in grids]
        values = [
            [*sol.force / each.friction, sol.moment / each.friction, sol.approach / hertz.approach]
            for sol in sols
        ]
        found[name] = np.abs(np.array(values) - values[1]).max(axis=1).tolist()
        row(
            name,
            [
                f"{change:.0e} {sol.grid.nx}x{sol.grid.ny}"
                for change, sol in zip(found[name], sols, strict=True)
            ],
        )
    return found


def draw(picture: str, spin: dict[tuple[float, int], np.ndarray], left: dict[Any, float]) -> None:
    """C23 of a circle by sampling point; errors with slip by edge."""
    import matplotlib.pyplot as plt

    figure, (first, second) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    cells = [n for ratio, n in spin if ratio == 1]
    for i, theta in enumerate(OFFSETS):
        first.plot(
            cells,
            [spin[1.0, n][i, 2] for n in cells],
            "o-",
            label=f"x + {theta} dq" if theta else "x",
        )
    first.axhline(0, color="black", linewidth=0.8)
    first.set(
        xlabel="cells across",
        ylabel="mean error of $C_{23}$ [%]",
        title="circle, no slip: spin sampled at",
    )
    first.legend()
    for edge, colour in zip(EDGES, ("C0", "C3"), strict=True):
        single = {
            grid[0]: value
            for (name, grid), value in left.items()
            if name == edge and len(grid) == 1
        }
        pairs = {
            grid[1]: value
            for (name, grid), value in left.items()
            if name == edge and len(grid) == 2
        }
        second.loglog(list(single), list(single.values()), "o-", color=colour, label=edge)
        second.loglog(
            list(pairs),
            list(pairs.values()),
            "s--",
            color=colour,
            label=f"{edge}, extrapolated by n/2 and n",
        )
    second.set(
        xlabel="cells across, n",
        ylabel="rms error [% of f Fz]",
        title="circle, five creepages with slip",
    )
    ticks = sorted({n for _, grid in left for n in grid})
    second.set_xticks(ticks, labels=[str(n) for n in ticks])
    parts = (0.2, 0.5, 1.0, 2.0, 4.0)
    second.set_yticks(parts, labels=[f"{part:g}" for part in parts])
    second.minorticks_off()
    second.legend()
    figure.savefig(picture, dpi=150)


def main(
    picture: str | None = None,
    ratios: tuple[float, ...] = (0.5, 1.0, 2.0, 5.0),
    cells: tuple[int, ...] = (12, 16, 24, 32, 48),
    with_slip: dict[float, tuple[int, ...]] | None = None,
    stepped: tuple[int, ...] = (12, 24),
    margined: int = 8,
) -> tuple[dict[tuple[float, int], np.ndarray], dict[Any, float], dict[str, list[float]]]:
    """Print all tables, draw two of them, and return them; with slip by a/b, the last of which is
    drawn.
    """
    spin = without_slip(ratios, cells)
    with_slip = with_slip or {2.0: (8, 12, 16, 20, 24, 32), 1.0: (8, 12, 16, 20, 24, 32, 40)}
    for ratio, numbers in with_slip.items():
        print(f"\nWith slip, a/b = {ratio:g}")
        found = studies(ratio, numbers)
        exact = limits(found)
        left = by_edge(found, exact)
    by_step(exact, stepped)
    margins = by_margin(margined) if margined else {}
    if picture is not None:
        draw(picture, spin, left)
    return spin, left, margins


if __name__ == "__main__":
    main(*(sys.argv[1:2] or ["sampling.png"]))
