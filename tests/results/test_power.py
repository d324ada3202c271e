"""Work by friction and work put in: two measures of one loss, and what stands between them on a grid."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.operators import influence_operator
from varcontact.problem.discretise import discretise
from varcontact.reference import line_contact
from varcontact.reference.carter import carter

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


def cylinder(bodies, motion, cells):
    return vc.Scene(
        bodies=bodies,
        surface=vc.Cylinders(R=1.0),
        normal_force=1e-3,
        friction=0.1,
        motion=motion,
        grid=vc.Grid(nx=cells),
    )


def order(cells, errors):
    """Slope of the errors against the element size, both by their logarithms."""
    return -np.polyfit(np.log(cells), np.log(errors), 1)[0]


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_power_is_minus_force_times_creepage(motion):
    sol = vc.solve(ball(motion, 12))
    (Fx, Fy), (vx, vy, spin) = sol.force, sol.creepage
    assert sol.power == pytest.approx(-(Fx * vx + Fy * vy + sol.moment * spin), rel=1e-14)
    assert sol.summary()["power"] == sol.power
    assert sol.summary()["friction_work"] == sol.friction_work


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_what_stands_between_power_and_friction(motion):
    """p'S p by the step, and Fy times the way from x to where spin is sampled: an identity, to rounding."""
    sol = vc.solve(ball(motion, 12))
    disc = discretise(sol.scene, sol.grid)
    step = sol.grid.sides[0]
    traction = sol.traction / disc.pressure
    elastic = disc.tangential_operator.apply(traction) * disc.displacement
    stored = float(np.sum(sol.traction * elastic)) * sol.grid.area / step
    sampled = -sol.motion.spin_offset * step * sol.creepage[2] * sol.force[1]
    assert stored > 0
    assert sol.friction_work == pytest.approx(sol.power + sampled - stored, rel=1e-12)


def test_a_step_loses_the_elastic_energy_of_what_it_changes():
    """p'S p is half the energy of the tractions less themselves a step ago, on a grid with room for both."""
    sol = vc.solve(ball(MOTIONS["mixed"], 12))
    disc, (dx, dy) = discretise(sol.scene, sol.grid), sol.grid.sides
    lost = np.sum(sol.traction * disc.tangential_operator.apply(sol.traction))
    left, _, bottom, _ = sol.grid.box
    wider = vc.Grid(nx=sol.grid.nx + 1, ny=sol.grid.ny, dx=dx, dy=dy, x0=left - dx, y0=bottom)
    change = np.diff(sol.traction, axis=2, prepend=0.0, append=0.0)
    instant = influence_operator(wider.scaled(disc.length), "xy", "xy", nu=0.28)
    assert lost == pytest.approx(0.5 * np.sum(change * instant.apply(change)), rel=1e-12)


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_power_and_friction_meet_as_the_grid_is_refined(motion):
    """First order: friction takes 0.66, 0.81 and 0.90 of the power at 8, 16 and 32 cells in the first case."""
    cells = [8, 16, 32]
    lost = [1 - sol.friction_work / sol.power for sol in (vc.solve(ball(motion, n)) for n in cells)]
    assert lost[0] < 0.5
    assert 0.75 < order(cells, lost) < 1.05
    assert abs(2 * lost[2] - lost[1]) < 0.02, "nothing is left of the first order"


def test_both_converge_to_carter_and_power_is_nearer():
    """Carter's force under a given creepage: friction_work lacks five times as much as power does."""
    bodies, cells = vc.Bodies(G=1.0, nu=0.28), [20, 40, 80, 160]
    contact = line_contact(1.0, bodies, force=1e-3)
    exact = carter(contact, 0.1, force=-6e-5)
    scenes = [cylinder(bodies, vc.Steady(vx=exact.creepage), n) for n in cells]
    solutions = [vc.solve(scene) for scene in scenes]
    power, friction = (
        np.array([abs(getattr(sol, name) / (6e-5 * exact.creepage) - 1) for sol in solutions])
        for name in ("power", "friction_work")
    )
    assert 0.9 < order(cells, friction) < 1.1
    assert np.all(power < 0.25 * friction)


def test_unlike_bodies_are_also_resisted_by_their_pressure():
    """Free rolling: no force, no spin, and friction all the same; sum(pz x)/R by hand is what drives it."""
    cells = [24, 48, 96]
    apart = []
    for n in cells:
        sol = vc.solve(cylinder(UNLIKE, vc.Steady(Fx=0.0), n))
        moment = float(np.sum(sol.pressure * sol.grid.x) * sol.grid.area)
        assert sol.power == pytest.approx(moment / 1.0, rel=1e-9)
        assert moment > 1e-6 * sol.normal_force * sol.scene.hertz.a
        apart.append(sol.friction_work / sol.power - 1)
    assert abs(apart[2]) < 0.02 < abs(apart[0])


def test_unlike_spheres_meet_too():
    cells = [8, 16, 32]
    lost = []
    for n in cells:
        scene = vc.Scene(
            bodies=UNLIKE,
            surface=vc.Paraboloids(Rx=1.0, Ry=0.7),
            normal_force=1e-2,
            friction=0.3,
            motion=vc.Steady(vx=0.02, vy=0.01, spin=0.03),
            grid=vc.Grid(nx=n, ny=n),
        )
        sol = vc.solve(scene)
        lost.append(1 - sol.friction_work / sol.power)
    assert 0.8 < order(cells, lost) < 1.1
    assert lost[-1] < 0.05


def test_power_where_nothing_is_carried(rolling):
    """Without friction the creepage under a force of zero could be any, and costs nothing."""
    free = vc.solve(rolling(friction=0.0, motion=vc.Steady(Fx=0.0, vy=0.01, spin=0.1)))
    assert (free.power, free.friction_work) == (0.0, 0.0)
    assert vc.solve(rolling(motion=None, friction=None)).power == 0.0


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
