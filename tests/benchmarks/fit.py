"""Constants that were chosen from measurements, and how: each table shows what the choice is
between.
"""

from collections.abc import Callable
from dataclasses import replace

import varcontact as vc
from tests.benchmarks.speed import with_friction
from tests.benchmarks.table import Table, least

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
            seconds = [
                least(lambda p=p, t=t, s=scene: vc.solve(s, p, t, certify="gap")) for p, t in pairs
            ]
            found.append((vc.solve(scene, certify="none").elements["contact"], *seconds))
        slower = [elements for elements, dense, free in found if free > dense]
        rows.append([name, f"{max(slower, default=found[0][0])}"])
    return Table(["scenes", "elements at which `newton` is last slower"], ["", ""], rows)


TABLES = {"crossover": crossover}
