"""Where a body ends under load: the power does not depend on how far beyond it the other one is said to be."""

import numpy as np
import pytest

import varcontact as vc
from varcontact import energy

UNLIKE = vc.Bodies(G=(80e3, 26e3), nu=(0.28, 0.33))
LIKE = vc.Bodies(G=82e3, nu=0.28)


def solved(cells=32, ledge=0.0, cubic=0.0, friction=0.3, force=1e3):
    grid = vc.Grid(nx=cells, ny=cells, dx=3.2 / cells, dy=2.4 / cells, x0=-1.6, y0=-1.2)
    x, y = np.meshgrid(grid.x, grid.y)
    h = x**2 / 100 + y**2 / 50 + cubic * x**3 + ledge * (x > 0.4)
    scene = vc.Scene(
        bodies=UNLIKE,
        surface=vc.SampledDistance(h),
        normal_force=force,
        friction=friction,
        motion=vc.Steady(vx=1e-3),
        grid=grid,
    )
    return vc.solve(scene, certify=None)


def test_power_where_a_body_ends():
    """By differences across the end it was 2245, and nothing rubs without friction."""
    low, high = (solved(ledge=height, force=3e3) for height in (0.05, 1.0))
    assert high.power == pytest.approx(low.power, rel=1e-9)
    assert high.friction_work == pytest.approx(high.power, rel=1e-11)
    assert solved(ledge=1.0, friction=0.0, force=3e3).power == 0.0


def test_the_pressure_climbs_the_distance_where_the_surface_is_smooth():
    """sum(pz dh/dx), by hand, tends to what the power has beside force times creepage."""
    apart = []
    for cells in (16, 32, 64):
        sol = solved(cells, cubic=1e-3)
        slope = sol.grid.x / 50 + 3e-3 * sol.grid.x**2
        climbed = float(np.sum(sol.pressure * slope) * sol.grid.area)
        apart.append(abs(sol.power + sol.Fx * sol.vx - climbed))
    assert apart[2] < 0.25 * apart[1] < 0.25 * apart[0]


def test_a_corrected_solution_has_no_problem_of_its_own():
    scene = vc.Scene(
        bodies=LIKE,
        surface=vc.Paraboloids(100, 50),
        normal_force=5e3,
        friction=0.3,
        motion=vc.Steady(vx=1e-3),
        grid=vc.Grid(nx=16, ny=16),
    )
    with pytest.raises(vc.SceneError, match="solved without refine"):
        energy.posed(vc.solve(scene, refine="continuum"))


def test_the_force_of_an_approach_is_the_estimates():
    x = np.linspace(-2.0, 2.0, 81)
    surface = vc.SampledDistance(np.add.outer(x**4 / 20 + x**2 / 100, x**2 / 200), x=x, y=x)
    sol = vc.solve(vc.Scene(bodies=LIKE, surface=surface, approach=0.02), accuracy=0.02)
    assert sol.normal_force == sol.error_estimate.values["normal_force"]
    assert f"largest pressure {sol.max_pressure:.4g}" in sol.report()


def test_a_body_by_a_number_of_numpy():
    sol = solved()
    one, other = (vc.stress(sol, [0.0, 0.0, 0.3], body) for body in (1, np.int64(1)))
    np.testing.assert_array_equal(np.asarray(one.stress), np.asarray(other.stress))
