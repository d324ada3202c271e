"""Work by friction against the continuum on ten scenes, and its balance in histories."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.friction_work import SCENES, references, work
from varcontact.elasticity.operators import influence_operator
from varcontact.io import records
from varcontact.io.solution import with_checksum

KNOWN = references()
BODIES = {"like": vc.Bodies(G=1.0, nu=0.28), "unlike": vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.35))}


@pytest.mark.parametrize("name", SCENES)
def test_work_converges_to_the_continuum(name):
    """With the order of the forces, one; by the slip of Coulomb's law alone it lacked 8 to 30 % on 24 elements."""
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
    grid = vc.Grid(nx=12) if line else vc.Grid(nx=12, ny=12)
    scene = vc.Scene(
        bodies=BODIES[bodies],
        surface=vc.Cylinders(R=1.0, reference_depth=1.0) if line else vc.Paraboloids(Rx=1.0, Ry=0.7),
        normal_force=1e-3 if line else 1e-2,
        friction=0.3,
        motion=vc.Transient(steps=steps),
        grid=grid,
    )
    dx = vc.solve(replace(scene, motion=None)).grid.sides[0]
    return replace(scene, motion=vc.Transient(steps=steps, dq=part * dx, **changes))


@pytest.mark.parametrize(("part", "direction"), [(1.0, 1), (0.6, -1), (1.7, 1)])
@pytest.mark.parametrize("bodies", BODIES)
def test_the_balance_of_a_step(bodies, part, direction):
    """Friction loses what the motion puts in, and what pressures do, less the change of the elastic energy.

    All by hand: the tractions of both ends of the step, each with half of the way of its particles, three components.
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
        assert history.dissipation[k] == pytest.approx((put_in - stored + pressed) * grid.area, rel=1e-10)
        before = p


@pytest.mark.parametrize("line", [False, True])
@pytest.mark.parametrize("bodies", BODIES)
def test_a_history_in_the_steady_state_loses_as_much(bodies, line):
    """Which is `power` there."""
    motion = {"vx": 2e-3} if line else {"vx": 0.02, "vy": 0.01, "spin": 0.05}
    scene = rolled(bodies, line=line)
    steady = vc.solve(replace(scene, motion=vc.Steady(**motion)), tol=1e-10)
    scene = replace(scene, grid=steady.grid, motion=vc.Transient(steps=2, start=steady, **motion))
    assert steady.friction_work == pytest.approx(steady.power, rel=1e-11)
    for sol in vc.solve(scene, tol=1e-10):
        assert sol.power_density == pytest.approx(steady.power_density, rel=1e-6, abs=1e-6 * sol.power_density.max())
        assert sol.power == pytest.approx(steady.power, rel=1e-6)


def test_only_second_order_has_negative_densities():
    """Where nothing slips there are none, but for rounding: the first step from rest."""
    history = vc.solve(SCENES["history"](24))
    assert history[0].elements["slip"] == 0 and np.abs(history.dissipation[0]) < 1e-12 * history.dissipation[1]
    assert [sol.negative_work for sol in history] == 12 * [0.0]
    scene = SCENES["slender along y"](24)
    assert vc.solve(scene).negative_work == 0.0
    assert (
        -0.1
        < vc.solve(scene.second_order()).negative_work
        < 2 * vc.solve(SCENES["slender along y"](64).second_order()).negative_work
        < 0
    )


def test_work_by_an_accuracy_is_that_of_its_forces():
    sol = vc.solve(replace(SCENES["vx and spin"](24), grid="auto"), accuracy=0.01)
    assert sol.friction_work == sol.power == pytest.approx(KNOWN["vx and spin"], rel=0.01)


@pytest.mark.parametrize("motion", [vc.Steady(vx=1e-3, spin=0.1), vc.Shift(ux=1e-6)], ids=["rolling", "shift"])
def test_a_file_of_an_earlier_version(motion, tmp_path):
    """It has no power density: that is made as the file is measured, and unknown where it is not."""
    sol = vc.solve(replace(SCENES["vx and spin"](12), motion=motion))
    path = tmp_path / "old.nc"
    path.write_bytes(with_checksum(bytes(sol.to_xarray().drop_vars("power_density").to_netcdf(engine="h5netcdf"))))
    assert vc.load(path).power_density == pytest.approx(sol.power_density, rel=1e-9, abs=1e-9)
    assert np.isnan(vc.load(path, certify=False).friction_work)


def test_a_power_density_that_is_not_that_of_the_tractions(tmp_path):
    data = vc.solve(SCENES["vx and spin"](12)).to_xarray()
    data["power_density"][6, 6] *= 1.01
    (tmp_path / "wrong.nc").write_bytes(with_checksum(bytes(data.to_netcdf(engine="h5netcdf"))))
    with pytest.raises(vc.OutputError, match="power density"):
        vc.load(tmp_path / "wrong.nc")


def test_a_history_of_an_earlier_version(tmp_path, monkeypatch):
    """Its dissipation is made anew; it is read, and not continued."""
    scene, path = rolled("like", steps=4, vx=0.02), tmp_path / "old.nc"
    history = vc.solve(scene)
    with monkeypatch.context() as before:
        series = {name: each for name, each in records.SERIES.items() if name != "power_density"}
        before.setattr(records, "SERIES", series)
        history.save(path)
    again = vc.load(path)
    assert again.dissipation == pytest.approx(history.dissipation, rel=1e-9)
    assert again[2].power_density == pytest.approx(history[2].power_density, rel=1e-9, abs=1e-12)
    with pytest.raises(vc.OutputError, match="earlier version"):
        vc.solve(scene, store=path)
