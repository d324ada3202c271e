"""Work by friction and work put in: they are the same in steady rolling, on any grid."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.friction_work import SCENES, references, work
from tests.scenes import make_scene
from varcontact.discrete.discretisation import discretise
from varcontact.elasticity.operators import influence_operator
from varcontact.io import records
from varcontact.io.solution import with_checksum

UNLIKE = vc.Bodies(G=(1.0, np.inf), nu=0.286)
MOTIONS = {
    "vx": vc.Steady(vx=0.05),
    "mixed": vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
    "spin": vc.Steady(spin=0.3),
    "sliding": vc.Steady(vx=0.3),
    "force": vc.Steady(Fx=-0.15),
}


def ball(motion, cells):
    return make_scene(vc.Ellipse(a=1.0, b=1.0), 1.0, motion, vc.Grid(nx=cells, ny=cells))


@pytest.mark.parametrize("second_order", [False, True])
@pytest.mark.parametrize("part", [1.0, 0.5, 0.6, 1.7])
@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_the_density_sums_to_force_times_creepage(motion, part, second_order):
    scene = ball(replace(motion, dq=part * 2 / 12), 12)
    sol = vc.solve(scene.second_order() if second_order else scene)
    given = -(sol.Fx * sol.vx + sol.Fy * sol.vy + sol.Mz * sol.spin)
    assert sol.power_density.sum() * sol.grid.area == pytest.approx(given, rel=1e-12)
    assert sol.friction_work == pytest.approx(sol.power, rel=1e-12)


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_what_the_slip_of_the_law_lacks(motion):
    """p'S p by the step, and Fy times the way from x to where spin is sampled: an identity, to
    rounding.
    """
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
    """p'S p is half the energy of the tractions less themselves a step ago, on a grid with room for
    both.
    """
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
    """The pressure's work by its own slip, and by the slope of the distance, to the grid's
    error.
    """
    apart = []
    for n in (8, 16, 32):
        motion, grid = vc.Steady(vx=0.02, vy=0.01, spin=0.03), vc.Grid(nx=n, ny=n)
        scene = make_scene(vc.Paraboloids(Rx=1.0, Ry=0.7), 1e-2, motion, grid, bodies=UNLIKE)
        sol = vc.solve(scene.second_order() if second_order else scene)
        assert sol.friction_work == pytest.approx(sol.power, rel=1e-11)
        moment = float(np.sum(sol.pressure * sol.grid.x) * sol.grid.area)
        apart.append(
            abs(moment - sum(sol.force * sol.creepage[:2]) - sol.Mz * sol.spin - sol.power)
            / sol.power
        )
    assert apart[2] < 0.01
    assert apart[2] < 0.25 * apart[0]


@pytest.mark.long
def test_rolling_back_takes_as_much():
    motions = [
        vc.Transient(steps=20, dq=0.01, direction=direction, Fx=0.0) for direction in (1, -1)
    ]
    surface, grid = vc.Cylinders(R=1.0), vc.Grid(nx=40, dx=0.002, x0=-0.04)
    scenes = [
        make_scene(surface, 1e-3, motion, grid, friction=0.1, bodies=UNLIKE) for motion in motions
    ]
    right, left = (vc.solve(scene)[-1] for scene in scenes)
    assert right.power > 0
    assert np.isfinite(right.creepage).all(), (
        "a force that stays zero leaves the creepage known without a depth"
    )
    assert left.power == pytest.approx(right.power, rel=1e-6)


# -------------------- Work by friction against the continuum on ten scenes


KNOWN = references()
BODIES = {"like": vc.Bodies(G=1.0, nu=0.28), "unlike": vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.35))}


@pytest.mark.parametrize("name", SCENES)
def test_work_converges_to_the_continuum(name):
    """With the order of the forces, one; by the slip of Coulomb's law alone it lacked 8 to 30 % on
    24 elements.
    """
    cells = np.array([12, 24, 48])
    errors = np.abs([work(SCENES[name](n)) / KNOWN[name] - 1 for n in cells])
    assert errors[1] < 0.03
    assert errors[2] < 0.015
    assert -np.polyfit(np.log(cells), np.log(errors), 1)[0] > 0.7


@pytest.mark.parametrize("name", [name for name in SCENES if name != "history"])
def test_work_of_second_order(name):
    assert work(SCENES[name](24).second_order()) == pytest.approx(KNOWN[name], rel=0.01)
    assert work(SCENES[name](48).second_order()) == pytest.approx(KNOWN[name], rel=0.005)


def rolled(bodies, part=1.0, steps=8, line=False, **changes):
    ball, cylinder = vc.Paraboloids(Rx=1.0, Ry=0.7), vc.Cylinders(R=1.0, reference_depth=1.0)
    surface, force, grid = (
        (cylinder, 1e-3, vc.Grid(nx=12)) if line else (ball, 1e-2, vc.Grid(nx=12, ny=12))
    )
    scene = make_scene(surface, force, None, grid, bodies=BODIES[bodies])
    dx = vc.solve(scene).grid.sides[0]
    return replace(scene, motion=vc.Transient(steps=steps, dq=part * dx, **changes))


@pytest.mark.parametrize(("part", "direction"), [(1.0, 1), (0.6, -1), (1.7, 1)])
@pytest.mark.parametrize("bodies", BODIES)
def test_the_balance_of_a_step(bodies, part, direction):
    """Friction loses what the motion puts in, and what pressures do, less the change of the elastic
    energy.
    """
    spins, creepages = 0.3 * np.cos(np.arange(8)), 0.02 * np.cos(np.arange(8) / 2)
    history = vc.solve(rolled(bodies, part, direction=direction, vx=creepages, vy=0.01, spin=spins))
    grid, own = history.grid, BODIES[bodies]
    dq, (x, y) = direction * history.dq[0], np.meshgrid(grid.x, grid.y)

    def by(offset):
        nu, K = own.combined_nu, own.K
        return influence_operator(grid, "xyz", "xyz", nu=nu, K=K, offset=offset).apply

    before = np.zeros((3, *grid.shape))
    for k, sol in enumerate(history):
        p = np.concatenate([sol.traction, sol.pressure[None]])
        G = own.combined_G
        now, then = (by(0.0)(p) - by(dq)(before)) / G, (by(-dq)(p) - by(0.0)(before)) / G
        stored = 0.5 * (np.sum(p * by(0.0)(p)) - np.sum(before * by(0.0)(before))) / G
        pressed = 0.5 * (np.sum(p[2] * now[2]) + np.sum(before[2] * then[2]))
        put_in = 0.0
        for field, middle in ((p, x + dq / 2), (before, x - dq / 2)):
            arms = creepages[k] - spins[k] * y, 0.01 + spins[k] * middle
            put_in -= 0.5 * abs(dq) * (np.sum(field[0] * arms[0]) + np.sum(field[1] * arms[1]))
        assert history.dissipation[k] == pytest.approx(
            (put_in - stored + pressed) * grid.area, rel=1e-10
        )
        before = p


@pytest.mark.parametrize("line", [False, True])
@pytest.mark.parametrize("bodies", BODIES)
def test_a_history_in_the_steady_state_loses_as_much(bodies, line):
    motion = {"vx": 2e-3} if line else {"vx": 0.02, "vy": 0.01, "spin": 0.05}
    scene = rolled(bodies, line=line)
    steady = vc.solve(replace(scene, motion=vc.Steady(**motion)), tol=1e-10)
    scene = replace(scene, grid=steady.grid, motion=vc.Transient(steps=2, start=steady, **motion))
    assert steady.friction_work == pytest.approx(steady.power, rel=1e-11)
    for sol in vc.solve(scene, tol=1e-10):
        assert sol.power_density == pytest.approx(
            steady.power_density, rel=1e-6, abs=1e-6 * sol.power_density.max()
        )
        assert sol.power == pytest.approx(steady.power, rel=1e-6)


@pytest.mark.long
def test_only_second_order_has_negative_densities():
    """Where nothing slips there are none, but for rounding: the first step from rest."""
    history = vc.solve(SCENES["history"](24))
    assert (
        history[0].elements["slip"] == 0
        and np.abs(history.dissipation[0]) < 1e-12 * history.dissipation[1]
    )
    assert [sol.negative_work for sol in history] == 12 * [0.0]
    scene = SCENES["slender along y"](24)
    assert vc.solve(scene).negative_work == 0.0
    coarse, fine = (SCENES["slender along y"](cells).second_order() for cells in (24, 64))
    assert -0.1 < vc.solve(coarse).negative_work < 2 * vc.solve(fine).negative_work < 0


def test_work_by_an_accuracy_is_that_of_its_forces():
    sol = vc.solve(replace(SCENES["vx and spin"](24), grid="auto"), accuracy=0.01)
    assert sol.friction_work == sol.power == pytest.approx(KNOWN["vx and spin"], rel=0.01)


@pytest.mark.parametrize(
    "motion", [vc.Steady(vx=1e-3, spin=0.1), vc.Shift(ux=1e-6)], ids=["rolling", "shift"]
)
def test_a_file_of_an_earlier_version(motion, tmp_path):
    """It has no power density: that is made as the file is measured, and unknown where it is
    not.
    """
    sol = vc.solve(replace(SCENES["vx and spin"](12), motion=motion))
    path = tmp_path / "old.nc"
    path.write_bytes(
        with_checksum(
            bytes(sol.to_xarray().drop_vars("power_density").to_netcdf(engine="h5netcdf"))
        )
    )
    assert vc.load(path).power_density == pytest.approx(sol.power_density, rel=1e-9, abs=1e-9)
    assert np.isnan(vc.load(path, certify=False).friction_work)


def test_a_history_of_an_earlier_version(tmp_path, monkeypatch):
    """Its dissipation is made anew."""
    scene, path = rolled("like", steps=4, vx=0.02), tmp_path / "old.nc"
    history = vc.solve(scene)
    with monkeypatch.context() as before:
        series = {name: each for name, each in records.SERIES.items() if name != "power_density"}
        before.setattr(records, "SERIES", series)
        history.save(path)
    again = vc.load(path)
    assert again.dissipation == pytest.approx(history.dissipation, rel=1e-9)
    assert again[2].power_density == pytest.approx(history[2].power_density, rel=1e-9, abs=1e-12)


COUPLED = vc.Bodies(G=(80e3, 26e3), nu=(0.28, 0.33))
LIKE = vc.Bodies(G=82e3, nu=0.28)


def solved(cells=32, ledge=0.0, cubic=0.0, friction=0.3, force=1e3):
    grid = vc.Grid(nx=cells, ny=cells, dx=3.2 / cells, dy=2.4 / cells, x0=-1.6, y0=-1.2)
    x, y = np.meshgrid(grid.x, grid.y)
    h = x**2 / 100 + y**2 / 50 + cubic * x**3 + ledge * (x > 0.4)
    scene = make_scene(
        vc.SampledDistance(h), force, vc.Steady(vx=1e-3), grid, friction=friction, bodies=COUPLED
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


def test_the_force_of_an_approach_is_the_estimates():
    x = np.linspace(-2.0, 2.0, 81)
    surface = vc.SampledDistance(np.add.outer(x**4 / 20 + x**2 / 100, x**2 / 200), x=x, y=x)
    sol = vc.solve(vc.Scene(bodies=LIKE, surface=surface, approach=0.02), accuracy=0.02)
    assert sol.normal_force == sol.error_estimate.values["normal_force"]
    assert f"largest pressure {sol.max_pressure:.4g}" in sol.report()
