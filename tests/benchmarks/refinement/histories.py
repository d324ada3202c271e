"""Histories, plain and corrected step by step: errors from infinitely many elements with the same steps."""

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

import varcontact as vc
from tests.benchmarks.random_scenes import scenes as random_scenes
from tests.benchmarks.refinement import FRICTION
from varcontact.results.quantities_of_interest import error, units, values

FULL = FRICTION / 3.7
"""About the creepage of saturation of a circle."""
CELLS = {
    "history": ((16, 20, 24, 32), 96),
    "line history": ((16, 32, 64, 128), 512),
    "sampled history": ((16, 24, 32), 64),
}
"""Kinds of random histories, the elements across their contacts, and those of the references."""


def history(ratio: float, **motion: object) -> vc.Scene:
    """An ellipse of area pi under a unit load."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=ratio**0.5, b=ratio**-0.5),
        normal_force=1.0,
        friction=FRICTION,
        motion=vc.Transient(**motion),
    )


def scenes(part: int) -> dict[str, vc.Scene]:
    """Histories with steps of a by `part`: two contact lengths from rest, and changes on the way."""
    n, dq, slender = min(2 * part + 2, 14), 1.0 / part, 3.0**0.5 / part
    waves = np.sin(2 * math.pi * np.arange(n) / n)
    shifted = {"dq": [0.0, *[dq] * (n - 1)], "ux": [0.5 * FULL, *[0.0] * (n - 1)]}
    swinging = [float(1 - 0.3 * abs(wave)) for wave in waves]
    return {
        "from rest": history(1.0, steps=n, dq=dq, vx=0.6 * FULL),
        "creepage swings": history(1.0, steps=n, dq=dq, vx=[float(0.7 * FULL * wave) for wave in waves]),
        "Cattaneo to Carter": history(1.0, steps=n, vx=[0.0, *[0.4 * FULL] * (n - 1)], **shifted),
        "spin": history(1.0, steps=n, dq=dq, spin=1.2 * FULL),
        "all three, a/b = 3": history(3.0, steps=n, dq=slender, vx=0.4 * FULL, vy=0.3 * FULL, spin=0.3 * FULL),
        "load swings": history(0.6, steps=n, dq=0.6**0.5 / part, vx=0.5 * FULL, normal_force=swinging),
        "force given": history(1.5, steps=n, dq=1.5**0.5 / part, Fx=[-0.2 * (k + 1) / n for k in range(n)]),
    }


def on(scene: vc.Scene, cells: int, edge: str = "centres") -> vc.Scene:
    """So many elements across the contact."""
    return replace(scene, grid=vc.Grid(nx=cells, ny=None if scene.line else cells, edge=edge))


def plain(scene: vc.Scene) -> vc.History:
    """The history on the scene's grid."""
    return vc.solve(scene, certify=None)


def corrected(scene: vc.Scene) -> vc.History:
    """The same, corrected."""
    return vc.solve(scene, refine="continuum", certify=None)


def off(found: vc.History, truth: vc.History) -> np.ndarray:
    """Errors of all steps, (steps,)."""
    return np.array([error(values(one), values(best), units(best)) for one, best in zip(found, truth, strict=True)])


def agreement(scene: vc.Scene, truth: vc.History) -> float:
    """How far corrected histories are from what plain grids of touched elements tend to."""
    fine, coarse = (plain(on(scene, cells, "touched")) for cells in (96, 48))
    found = [
        {name: 2 * value - values(before)[name] for name, value in values(one).items()}
        for one, before in zip(fine, coarse, strict=True)
    ]
    return max(error(one, values(best), units(best)) for one, best in zip(found, truth, strict=True))


def table() -> None:
    """Plain, corrected and estimate on 16 and 32 cells, largest of all steps, from corrected histories on 96.

    Before them stands how far these are from extrapolated plain grids.
    """
    for part in (4, 8, 16):
        for name, posed in scenes(part).items():
            truth = corrected(on(posed, 96))
            row = [agreement(posed, truth)]
            for cells in (16, 32):
                found = corrected(on(posed, cells))
                estimate = max(step.error_estimate.largest for step in found)
                row += [off(plain(on(posed, cells)), truth).max(), off(found, truth).max(), estimate]
            print(f"a/{part:<3d} {name:20s} " + " ".join(f"{value:.1e}" for value in row), flush=True)


def quantiles(numbers: Iterable[float]) -> str:
    """Median, nine in ten, largest."""
    return " / ".join(f"{value:.1e}" for value in np.quantile(np.array(list(numbers)), [0.5, 0.9, 1.0]))


def random_table(kind: str, count: int, seed: int = 11) -> None:
    """Random histories of a kind, step by step: plain and corrected errors, estimates and how often they hold."""
    grids, fine = CELLS[kind]
    posed = random_scenes(kind, count, seed)
    truth = [corrected(on(scene, fine)) for scene in posed]
    for cells in grids:
        found = [corrected(on(scene, cells)) for scene in posed]
        before, after = (
            np.concatenate([off(one, best) for one, best in zip(answers, truth, strict=True)])
            for answers in ([plain(on(scene, cells)) for scene in posed], found)
        )
        estimates = np.array([step.error_estimate.largest for one in found for step in one])
        above = after > estimates
        print(f"{kind}, {cells} cells, {len(after)} steps: plain {quantiles(before)}; corrected {quantiles(after)}")
        print(f"    estimate {quantiles(estimates)}; {np.count_nonzero(above)} errors above it ", end="")
        clear = above & (after > 1e-4)
        most = (after[clear] / estimates[clear]).max(initial=1.0)
        print(f"({np.count_nonzero(clear)} of them above 1e-4, by up to {most:.1f} times)", flush=True)


def random_histories() -> None:
    """Sixty of Hertz's contacts, forty line contacts, twelve sampled surfaces."""
    for kind, count in zip(CELLS, (60, 40, 12), strict=True):
        random_table(kind, count)
