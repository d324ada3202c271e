"""Work by friction and work put in: they are the same in steady rolling, on any grid."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.elasticity.operators import influence_operator

UNLIKE = vc.Bodies(G=(1.0, np.inf), nu=0.286)
MOTIONS = {
    "vx": vc.Steady(vx=0.05),
    "mixed": vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
    "spin": vc.Steady(spin=0.3),
    "sliding": vc.Steady(vx=0.3),
    "force": vc.Steady(Fx=-0.15),
}


def ball(motion, cells):
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=0.3,
        motion=motion,
        grid=vc.Grid(nx=cells, ny=cells),
    )


@pytest.mark.parametrize("second_order", [False, True])
@pytest.mark.parametrize("part", [1.0, 0.5, 0.6, 1.7])
@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_the_density_sums_to_force_times_creepage(motion, part, second_order):
    scene = ball(replace(motion, dq=part * 2 / 12), 12)
    sol = vc.solve(scene.second_order() if second_order else scene)
    given = -(sol.Fx * sol.vx + sol.Fy * sol.vy + sol.Mz * sol.spin)
    assert sol.power_density.sum() * sol.grid.area == pytest.approx(given, rel=1e-12)
    assert sol.friction_work == pytest.approx(sol.power, rel=1e-12)


@pytest.mark.parametrize("method", ["linear", "fastsim", "fastrip"])
def test_that_of_theories_does_too(method):
    sol = vc.solve(ball(MOTIONS["mixed"], 12), tangential=method)
    assert sol.power > 0
    assert sol.friction_work == pytest.approx(sol.power, rel=1e-12)


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_what_the_slip_of_the_law_lacks(motion):
    """p'S p by the step, and Fy times the way from x to where spin is sampled: an identity, to rounding."""
    sol = vc.solve(ball(motion, 12))
    disc = discretise(sol.scene, sol.grid)
    step = sol.grid.sides[0]
    traction = sol.traction / disc.scales.pressure
    elastic = disc.tangential_operator.apply(traction) * disc.scales.displacement
    stored = float(np.sum(sol.traction * elastic)) * sol.grid.area / step
    sampled = -sol.motion.spin_offset * step * sol.creepage[2] * sol.force[1]
    by_law = -float(np.sum(sol.traction * sol.slip)) * sol.grid.area
    assert stored > 0
    assert by_law == pytest.approx(sol.friction_work + sampled - stored, rel=1e-12)


def test_a_step_loses_the_elastic_energy_of_what_it_changes():
    """p'S p is half the energy of the tractions less themselves a step ago, on a grid with room for both."""
    sol = vc.solve(ball(MOTIONS["mixed"], 12))
    disc, (dx, dy) = discretise(sol.scene, sol.grid), sol.grid.sides
    lost = np.sum(sol.traction * disc.tangential_operator.apply(sol.traction))
    left, _, bottom, _ = sol.grid.box
    wider = vc.Grid(nx=sol.grid.nx + 1, ny=sol.grid.ny, dx=dx, dy=dy, x0=left - dx, y0=bottom)
    change = np.diff(sol.traction, axis=2, prepend=0.0, append=0.0)
    instant = influence_operator(wider.scaled(disc.scales.length), "xy", "xy", nu=0.28)
    assert lost == pytest.approx(0.5 * np.sum(change * instant.apply(change)), rel=1e-12)


@pytest.mark.parametrize("second_order", [False, True])
def test_unlike_spheres(second_order):
    """The pressure's work by its own slip, and by the slope of the distance, to the grid's error."""
    apart = []
    for n in (8, 16, 32):
        scene = vc.Scene(
            bodies=UNLIKE,
            surface=vc.Paraboloids(Rx=1.0, Ry=0.7),
            normal_force=1e-2,
            friction=0.3,
            motion=vc.Steady(vx=0.02, vy=0.01, spin=0.03),
            grid=vc.Grid(nx=n, ny=n),
        )
        sol = vc.solve(scene.second_order() if second_order else scene)
        assert sol.friction_work == pytest.approx(sol.power, rel=1e-11)
        moment = float(np.sum(sol.pressure * sol.grid.x) * sol.grid.area)
        apart.append(abs(moment - sum(sol.force * sol.creepage[:2]) - sol.Mz * sol.spin - sol.power) / sol.power)
    assert apart[2] < 0.01
    assert apart[2] < 0.25 * apart[0]


def test_rolling_back_takes_as_much():
    """A step to the left is a step to the right in the mirror: the pressure resists it as much."""
    right, left = (
        vc.solve(
            vc.Scene(
                bodies=UNLIKE,
                surface=vc.Cylinders(R=1.0),
                normal_force=1e-3,
                friction=0.1,
                motion=vc.Transient(steps=20, dq=0.01, direction=direction, Fx=0.0),
                grid=vc.Grid(nx=40, dx=0.002, x0=-0.04),
            )
        )[-1]
        for direction in (1, -1)
    )
    assert right.power > 0
    assert np.isfinite(right.creepage).all(), "a force that stays zero leaves the creepage known without a depth"
    assert left.power == pytest.approx(right.power, rel=1e-6)
