"""Sweeps and rows of problems of bodies by numbers of their own, in processes and on a cluster."""

from dataclasses import replace

import numpy as np

import varcontact as vc
from varcontact.elasticity.operators import influence_operator

SIDE = 0.05
OVER = {"motion.vx": [1e-3, 2e-3, 4e-3]}


def half_spaces(kx, ky):
    k = np.hypot(kx, ky)
    along = np.stack([kx, ky, 0 * k], -1) / k[:, None]
    f = np.eye(3) - 0.3 * (along[:, :, None] * along[:, None, :] + np.diag([0.0, 0.0, 1.0]))
    return 2 / k[:, None, None] * f


def kernel():
    lattice = vc.Grid(nx=11, ny=10, dx=SIDE, dy=SIDE, x0=0.0, y0=0.0)
    return influence_operator(lattice, "xyz", "xyz", nu=0.3).table


BODIES = {
    "half-spaces": vc.Bodies(G=1.0, nu=0.3),
    "symbol": vc.Elasticity(symbol=half_spaces),
    "kernel": vc.Elasticity(kernel=kernel(), sides=(SIDE, SIDE)),
}


def scene(bodies):
    grid = vc.Grid(nx=10, ny=10, dx=SIDE, dy=SIDE, x0=-5 * SIDE, y0=-5 * SIDE)
    h = (grid.x**2 + grid.y[:, None] ** 2) / 2
    return vc.Scene(
        bodies=bodies,
        surface=vc.SampledDistance(h),
        normal_force=5e-3,
        friction=0.3,
        motion=vc.Steady(vx=1e-3),
        grid=grid,
    )


def test_processes_carry_own_bodies():
    """A symbol and a kernel, in turn; the numbers are not fitted again."""
    expected = vc.sweep(scene(BODIES["half-spaces"]), OVER)
    for name in ("symbol", "kernel"):
        own = scene(BODIES[name])
        alone = vc.sweep(own, OVER, chunk=2)
        assert vc.sweep(own, OVER, chunk=2, workers=2).identical(alone)
        np.testing.assert_allclose(alone["Fx"], expected["Fx"], rtol=1e-7)


def test_problems_in_rows_of_several_bodies():
    scenes = [
        replace(scene(bodies), motion=vc.Steady(vx=vx))
        for bodies in BODIES.values()
        for vx in (1e-3, 3e-3)
    ]
    together = vc.solve_many(scenes)["Fx"].values
    np.testing.assert_allclose(together, [vc.solve(each).Fx for each in scenes], rtol=1e-7)
    np.testing.assert_allclose(together[2:4], together[:2], rtol=1e-7)
