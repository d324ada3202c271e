"""Sampled surfaces with cliffs: errors and estimates of what is refused, and of what is not."""

from unittest import mock

import numpy as np

import varcontact as vc
from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.solving.defect_correction import road
from varcontact.solving.defect_correction.cliffs import check_cliffs

FRICTION, HEIGHTS = 0.3, (1e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 1.0)
CELLS, FINE = (12, 16, 20, 24, 32), (72, 80, 90)
LINE_CELLS, LINE_FINE = (16, 24, 32, 64), (1600, 1777, 2000)
SHAPES = {"ahead": 0.2, "behind": 0.13, "beside": 0.2, "aslant": 0.15, "hole": 0.1, "far ahead": -0.1}
LINE_SHAPES = {"ahead": 0.2, "behind": 0.1, "hole": 0.06, "far ahead": -0.1}

BOWL = vc.Steady(vx=0.03, vy=0.02, spin=0.05)
ALONG, ASIDE = vc.Steady(vx=0.03), vc.Steady(vx=0.01, vy=0.02)


def stepped(shape: str, at: float, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Where a bowl has its step."""
    places: dict[str, np.ndarray] = {
        "ahead": x > at,
        "far ahead": x > at,
        "behind": x < -at,
        "beside": y > at,
        "aslant": x + y / 2 > at,
        "hole": np.hypot(x - 0.1, y) < at,
    }
    return np.broadcast_to(places[shape], np.broadcast_shapes(x.shape, y.shape))


def posed(surface: vc.SampledDistance, cells: int, motion: vc.Steady) -> vc.Scene:
    """Rolling over a bowl of radius one."""
    line = surface.line
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=surface,
        normal_force=0.25 if line else 0.1,
        friction=FRICTION,
        motion=motion,
        grid=vc.Grid(nx=cells, ny=None if line else cells),
    )


def three(sol: vc.Solution) -> np.ndarray:
    """Fx, Fy and Mz by f Fz, the moment times a length of 0.38."""
    return np.array([*sol.force, sol.moment / 0.38]) / (FRICTION * sol.normal_force)


def looked_at(scene: vc.Scene) -> tuple[vc.Solution, bool]:
    """The corrected solution, and whether it would have been refused."""
    refused = False

    def look(disc: Discretisation, state: ContactState) -> None:
        nonlocal refused
        try:
            check_cliffs(disc, state)
        except vc.SceneError:
            refused = True

    with mock.patch.object(road, "check_cliffs", look):
        return vc.solve(scene, refine="continuum", certify=None), refused


def measured(surface: vc.SampledDistance, motion: vc.Steady) -> list[tuple[bool, float, float, float]]:
    """Of each grid whether it is refused, and the errors, corrected and plain, and the estimate, beside fine grids."""
    cells, fine = (LINE_CELLS, LINE_FINE) if surface.line else (CELLS, FINE)
    if surface.line:
        known = [three(vc.solve(posed(surface, n, motion), certify=None)) for n in fine]
    else:
        known = [three(looked_at(posed(surface, n, motion))[0]) for n in fine]
    truth, spread, rows = np.median(known, axis=0), np.ptp(known, axis=0).max(), []
    for n in cells:
        try:
            sol, refused = looked_at(posed(surface, n, motion))
        except vc.SceneError:  # noise or too coarse: there is nothing to correct
            continue
        plain = vc.solve(posed(surface, n, motion), certify=None)
        scale = np.array([1, 1, 1 / 0.38]) / (FRICTION * sol.normal_force)
        errors = [float(np.abs(three(each) - truth).max()) for each in (sol, plain)]
        rows.append((refused, *errors, float((sol.refinement.estimate * scale).max() + spread)))
    return rows


def table() -> None:
    """Counts of both, in rolling over bowls and in line contact."""
    for line in (False, True):
        rows = []
        for count in (41, 121, 401) if line else (41, 121):
            x = np.linspace(-1.0, 1.0, count)
            y = np.zeros((1, 1)) if line else x[:, None]
            for height in (*HEIGHTS[:-1], 10.0) if line else HEIGHTS:
                for shape, at in (LINE_SHAPES if line else SHAPES).items():
                    h = (x**2 + y**2) / 2 + height * stepped(shape, at, x, y)
                    surface = vc.SampledDistance(h[0], x, reference_depth=5.0) if line else vc.SampledDistance(h, x, x)
                    motions = (ALONG, ASIDE) if line else (BOWL,)
                    for motion in motions:
                        try:
                            rows += measured(surface, motion)
                        except vc.SceneError as refusal:
                            print(f"{count} samples, {shape}, {height}: {refusal}")
        for refused in (False, True):
            found = np.array([row[1:] for row in rows if row[0] == refused])
            corrected, plain, estimate = found.T
            print(
                f"{'line' if line else 'bowl'}, {'refused' if refused else 'taken'}: {len(found)}, above the estimate "
                f"{np.sum(corrected > estimate)}, by 2e-4 {np.sum(corrected > estimate + 2e-4)}, at most "
                f"{(corrected / estimate).max():.2f} times, errors up to {corrected.max():.1e}, larger than the plain "
                f"grid's {np.sum(corrected > plain)}",
                flush=True,
            )
