"""Constants that were chosen from measurements, and how: each table shows what the choice is between."""

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np

import varcontact as vc
from tests import steady_forces
from tests.benchmarks.accuracy import SEED, exact, spread
from tests.benchmarks.speed import with_friction
from tests.benchmarks.table import Table, least
from tests.random_scenes import KINDS, scenes
from varcontact.results.quantities_of_interest import values

MIXED = {"vx": 0.05, "vy": -0.03, "spin": 0.05}
CELLS = (6, 8, 10, 12, 14, 16, 20, 24, 28)


def unlike(scene: vc.Scene) -> vc.Scene:
    """The same pressed shape, of bodies of which one is three times as stiff."""
    surface = vc.Paraboloids(scene.hertz.Rx, scene.hertz.Ry)
    return replace(scene, surface=surface, bodies=vc.Bodies(G=(1.0, 3.0), nu=0.28))


SWITCHES: dict[str, Callable[[int], vc.Scene]] = {
    "steady, a/b = 1": lambda n: with_friction(n, 1.0, vc.Steady(**MIXED)),
    "steady, a/b = 5": lambda n: with_friction(n, 5.0, vc.Steady(**MIXED)),
    "shift, a/b = 1": lambda n: with_friction(n, 1.0, vc.Shift(ux=0.05, uy=0.02)),
    "steady, unlike bodies": lambda n: unlike(with_friction(n, 1.0, vc.Steady(**MIXED))),
}


def crossover(quick: bool) -> Table:
    """Elements from which `newton` is faster than active sets: where `method="auto"` switches."""
    rows = []
    for name, posed in SWITCHES.items():
        found = []
        for n in CELLS[:: 4 if quick else 1]:
            scene = posed(n)
            pressures = ("hertz", "hertz") if scene.bodies.K == 0 else ("norm", "newton")
            pairs = zip(pressures, ("tang-safeguarded", "newton"), strict=True)
            seconds = [least(lambda p=p, t=t, s=scene: vc.solve(s, p, t, certify="gap")) for p, t in pairs]
            found.append((vc.solve(scene, certify="none").elements["contact"], *seconds))
        slower = [elements for elements, dense, free in found if free > dense]
        rows.append([name, f"{max(slower, default=found[0][0])}"])
    return Table(["scenes", "elements at which `newton` is last slower"], ["", ""], rows)


def error_bars(quick: bool) -> Table:
    """Largest error by its own bar, by kind of scene: SAFETY and FLOOR of the bar keep all below one."""
    rows = []
    for kind in KINDS[:3] if quick else KINDS:
        ratios = []
        for scene in scenes(kind, 1 if quick else 4, SEED + 1):
            truth, answer = exact(scene), vc.solve(scene, accuracy=0.03)
            found, estimate = values(answer), answer.error_estimate
            ratios += [
                max(abs(found[name] - best) / truth.units[name] - truth.known, 0.0) / estimate.errors[name]
                for name, best in truth.values.items()
                if name in estimate.errors
            ]
        rows.append([kind, max(ratios)])
    return Table(["scenes", "largest error by its bar"], ["", ".2g"], rows)


def edge(quick: bool) -> Table:
    """Errors of steady forces in per cent by slip difference and elements at the edge, n = 12, 24, 32."""
    known, rows = steady_forces.read()[:: 20 if quick else 2], []
    truth = np.array([forces for _, forces in known])
    for difference, side in product(("first-order", "second-order"), ("centres", "touched", "softened")):
        cells: list[list[float]] = []
        for n in (12, 24, 32):
            posed = [steady_forces.scene(numbers, n, edge=side) for numbers, _ in known]
            motions = [replace(one.motion, slip_difference=difference, spin_offset=None) for one in posed]
            found = [steady_forces.forces(replace(p, motion=m), 1e-4) for p, m in zip(posed, motions, strict=True)]
            cells.append(spread(100 * np.abs(np.array(found) - truth).max(axis=1)))
        rows.append([f"{difference}, {side}", *cells])
    return Table(["discretisation", "12", "24", "32"], ["", *(3 * ["{:.2f}/{:.2f}/{:.2f}"])], rows)


TABLES = {"crossover": crossover, "error_bars": error_bars, "edge": edge}
