"""Heights that bodies carry, loads by a control, work along the way: lists of surfaces,
conservation, corrugation.
"""

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.ndimage import label

import varcontact as vc
from tests.scenes import make_scene, refused

DATA = Path(__file__).parents[1] / "data"
R, FRICTION, NU = 100.0, 0.3, 0.3
LOAD = np.pi / (4 * R * (1 - NU))  # half length 1 under G = 1


def roller(cells=24, room=1.6, surface=None, **motion):
    dx, nx = 2 / cells, 2 * round(room * cells / 2)
    surface, grid = (
        surface or vc.Cylinders(R=R, reference_depth=50.0),
        vc.Grid(nx=nx, dx=dx, x0=-nx * dx / 2),
    )
    motion = vc.Transient(**{"Fx": -0.5 * FRICTION * LOAD, "dq": dx} | motion)
    return make_scene(surface, LOAD, motion, grid, FRICTION, vc.Bodies(G=1.0, nu=NU))


def waves(length, part, cells, **more):
    """Of an amplitude that changes the curvature by a part."""
    x = np.arange(round(length * cells / 2)) * 2 / cells
    return vc.Carried(
        part / R * (length / (2 * np.pi)) ** 2 * np.cos(2 * np.pi * x / length),
        x,
        period=length,
        **more,
    )


def test_carried_heights_are_a_list_of_surfaces():
    """In line contact and beyond, on steps of any length, there and back, on both bodies at
    once.
    """
    moves = {"dq": [0.1, 0.03, 0.2, 0.1], "direction": [1, 1, 1, -1], "rolled": 0.7}
    grid = vc.Grid(nx=24, ny=14, dx=0.12, dy=0.12, x0=-1.44, y0=-0.84)
    x, y = np.linspace(-3, 3, 121), np.linspace(-1, 1, 41)
    rough = vc.Carried(1e-3 * np.cos(3 * x + 2 * y[:, None]), x, y)
    ridge = vc.Carried(1e-3 * np.exp(-((x - 0.5) ** 2)), x)
    base = vc.Paraboloids(R, R)
    motion = vc.Transient(steps=4, Fx=-5e-4, carried=[rough, ridge], **moves)
    one = replace(roller(steps=1), surface=base, normal_force=5e-3, grid=grid, motion=motion)
    at = 0.7 + np.array([0.1, 0.13, 0.33, 0.23])
    heights = [
        np.cos(3 * (grid.x + X) + 2 * grid.y[:, None]) + np.exp(-((grid.x + X - 0.5) ** 2))
        for X in at
    ]
    listed = [vc.SampledDistance(base.distance(grid) - 1e-3 * each) for each in heights]
    other = replace(one, motion=replace(one.motion, carried=None, rolled=None, surface=listed))
    for carried, given in zip(vc.solve(one), vc.solve(other), strict=True):
        np.testing.assert_allclose(carried.scene.surface.h, given.scene.surface.h, atol=5e-9)
        np.testing.assert_allclose(carried.pressure, given.pressure, atol=2e-4 * given.max_pressure)
        assert carried.Fx == pytest.approx(given.Fx, rel=1e-4)


def test_a_history_goes_on_where_it_was(tmp_path):
    scene = roller(steps=9, carried=waves(2.5, 0.3, 24))
    whole = vc.solve(scene)
    first = vc.solve(
        replace(scene, motion=replace(scene.motion, steps=5)), store=tmp_path / "first.nc"
    )
    start = vc.load(tmp_path / "first.nc")[-1]
    motion = replace(scene.motion, steps=4, rolled=first.position[-1], start=start)
    np.testing.assert_allclose(
        vc.solve(replace(scene, motion=motion))[-1].traction, whole[-1].traction, rtol=1e-9
    )
    scene.save(tmp_path / "scene.toml")
    read = vc.read_scene(tmp_path / "scene.toml")[0]
    np.testing.assert_array_equal(vc.solve(read)[-1].traction, whole[-1].traction)


@pytest.mark.parametrize(
    "dq", [1.0, 0.37, [0.0, *[0.9, 1.7] * 12]], ids=["elements", "parts", "shift"]
)
@pytest.mark.parametrize("direction", [1, -1])
def test_work_is_conserved_along_the_way(dq, direction):
    steps = 25
    history = vc.solve(
        roller(steps=steps, dq=np.multiply(dq, 2 / 24).tolist(), direction=direction)
    )
    work, area = history.work_along(), history.grid.area
    assert float(work.sum()) * area == pytest.approx(history.dissipation.sum(), rel=1e-13)
    around = history.work_along(period=12 * history.grid.dx)
    assert around.shape == (1, 12)
    assert float(around.sum()) * area == pytest.approx(history.dissipation.sum(), rel=1e-13)
    centre = float((work * work.X).sum() / work.sum())
    weights = history.dissipation, history.position - direction * history.dq / 2
    loss = [
        float(np.sum(each.power_density * each.grid.x)) / max(each.power_density.sum(), 1e-300)
        for each in history
    ]
    assert centre == pytest.approx(
        np.average(weights[1] + np.array(loss), weights=weights[0]), abs=1e-9
    )


@pytest.mark.long
def test_crests_of_a_corrugation_wear_most():
    """First harmonic of the work by the mean, a^2/2R and amplitude, as on finer elements, at half
    of f Fz.
    """
    length, known = 4.0, 0.508 - 0.093j
    cells = 60
    scene = roller(cells, carried=waves(length, 0.2, cells), steps=1)
    lead, period = 3 * scene.grid.nx, round(length * cells / 2)
    motion = replace(scene.motion, steps=lead + period + scene.grid.nx)
    work = vc.solve(replace(scene, motion=motion), certify="none").work_along()[
        0, lead : lead + period
    ]
    wave = np.exp(-2j * np.pi * work.X.values / length)
    first = 2 * np.mean(work.values * wave) / float(work.mean())
    amplitude = 0.2 / R * (length / (2 * np.pi)) ** 2
    assert abs(first / amplitude / (2 * R) - known) < 0.025 * abs(known)


@pytest.mark.long
def test_a_flat_passes_once_a_turn():
    """By approach the force falls over the flat, by the depth of its chord, and comes back after a
    turn.
    """
    turn, flat = 8.0, vc.Carried.flat(length=1.0, radius=R, at=3.0)
    assert -flat.height.min() == pytest.approx(1.0 / (8 * R), rel=1e-12)
    around = vc.Carried(flat.height, flat.x, period=turn)
    grid = vc.Grid(nx=30, ny=20, dx=0.1, dy=0.1, x0=-1.5, y0=-1.0)
    motion = vc.Transient(steps=170, dq=0.1, carried=around)
    case = {
        "surface": vc.Paraboloids(R, R),
        "normal_force": None,
        "approach": 5e-3,
        "motion": motion,
        "grid": grid,
    }
    force = vc.solve(replace(roller(steps=1), friction=0.0, **case), certify="none").normal_force
    np.testing.assert_allclose(force[80:160], force[:80], rtol=1e-9)
    assert force[:80].argmin() in (28, 29, 30)
    assert force[0] == pytest.approx(force.max(), rel=1e-12)
    worn = flat.worn(0.5 * flat.height)
    np.testing.assert_allclose(worn.height, 0.5 * flat.height)


@pytest.mark.parametrize("turned", [-0.4, 0.0, 0.55])
def test_a_flat_at_rest(turned):
    """Fresh, or by measured slices: the chord of a wheel at rest at an angle, as its distance says
    by itself.
    """
    half, at = 1.0, 3.0
    flat = vc.Carried.flat(length=2 * half, radius=R, at=at, samples=401)
    slices = vc.Carried(np.tile(flat.height, (5, 1)), flat.x, np.linspace(-1.5, 1.5, 5))
    grid = vc.Grid(nx=40, ny=24, dx=0.1, dy=0.1, x0=-2.0, y0=-1.2)
    base = vc.Paraboloids(R, R)
    still = replace(roller(steps=1), surface=base, normal_force=0.6 / R, friction=0.0, grid=grid)
    s = grid.x + turned
    distance = base.distance(grid) + np.maximum(half**2 - s**2, 0.0) / (2 * R)
    alone = vc.solve(replace(still, surface=vc.SampledDistance(distance), motion=vc.Shift()))
    for carried in (flat, slices):
        motion = vc.Transient(steps=1, dq=0.0, carried=carried, rolled=at + turned)
        (found,) = vc.solve(replace(still, motion=motion))
        assert found.approach == pytest.approx(alone.approach, rel=1e-4)
        np.testing.assert_allclose(found.pressure, alone.pressure, atol=2e-3 * alone.max_pressure)


@pytest.mark.long
def test_a_flat_at_rest_and_in_steady_rolling_is_contacts():
    """A rounded flat at seven angles: its height to the printed digits, its force to 1 % of the
    friction limit.
    """
    with open(DATA / "rounded_flat.csv", newline="") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    radius, slices, y = 450.0, 0.0044525 * np.arange(-28, 29), 0.464758 * np.arange(-65, 66)
    deep = np.where(
        np.abs(slices) < 0.1113125, 0.45 * (1 + np.cos(np.pi * slices / 0.1113125)), 0.0
    )
    knots = np.concatenate(
        [
            slices[0] - 0.0044525 * np.array([2, 1]),
            slices,
            slices[-1] + 0.0044525 * np.array([1, 2]),
        ]
    )
    around = np.linspace(slices[1], slices[-2], 433)[:-1]
    depth = BSpline(knots, np.maximum(0, deep[:, None] - y**2 / 600), 3)(around)
    flat = vc.Carried(-depth.T, radius * around, y)
    still = vc.Transient(steps=1, dq=0.0, carried=flat)
    for row in rows:
        grid = vc.Grid(nx=46, ny=208, dx=0.2, dy=0.2, x0=row["x"] - 4.6, y0=-20.8)
        surface, motion = (
            vc.Paraboloids(radius, 300.0),
            replace(still, rolled=-radius * np.deg2rad(row["pitch"])),
        )
        scene = make_scene(surface, 1e4, motion, grid, bodies=vc.Bodies(G=82e3, nu=0.28))
        (found,) = vc.solve(scene)
        assert found.approach == pytest.approx(row["z_ws"], abs=1.5e-4)
        rolling = replace(scene, surface=found.scene.surface, motion=vc.Steady(vx=row["cksi"]))
        assert vc.solve(rolling).Fx == pytest.approx(row["fx"], abs=30.0)


@pytest.mark.long
def test_grids_make_room_for_heights_and_keep_an_accuracy():
    """A flat that moves the contact by its own half: forces within the stated errors of a finer
    answer.
    """
    flat = vc.Carried.flat(length=1.6, radius=R, at=1.5, worn=True)
    motion = vc.Transient(steps=12, dq=0.2, vx=1e-3, carried=flat)
    load, ball = 1.0 / R, vc.Paraboloids(R, R)
    scene = replace(roller(steps=1), surface=ball, normal_force=load, motion=motion, grid="auto")
    coarse, fine = vc.solve(scene, accuracy=0.1), vc.solve(scene, accuracy=0.015)
    assert coarse.grid.size < fine.grid.size
    off = np.abs(coarse.force[:, 0] - fine.force[:, 0]).max() / (FRICTION * load)
    assert off < coarse.error_estimate.largest < 0.1


def test_a_control_gives_what_a_list_gives(tmp_path):
    forces = [LOAD, 1.2 * LOAD, 0.8 * LOAD, 0.0, LOAD]
    creepages = [1e-3, 2e-3, 1e-3, 0.0, 1e-3]
    seen = []

    def control(k, before):
        seen.append(None if before is None else before.normal_force)
        return {"normal_force": forces[k], "vx": creepages[k]}

    scene = roller(steps=5)
    history = vc.solve(replace(scene, motion=replace(scene.motion, control=control)))
    listed = vc.solve(
        replace(scene, motion=replace(scene.motion, Fx=None, normal_force=forces, vx=creepages))
    )
    assert seen[0] is None
    assert seen[1:] == pytest.approx(forces[:4], rel=1e-9)
    for one, other in zip(history, listed, strict=True):
        np.testing.assert_array_equal(one.traction, other.traction)
    history.save(tmp_path / "history.nc")
    back = vc.load(tmp_path / "history.nc")
    assert back.scene.motion.normal_force == tuple(forces)
    np.testing.assert_array_equal(back.force, listed.force)


def gives(value):
    return lambda k, before: value if k == 2 else {}


BAD = {
    "motion.control": [{"control": 3}, {"control": gives(None)}, {"control": gives({"dq": 1.0})},
                       {"control": lambda k, before: {} if k < 2 else 1 / 0}],
    "motion.vx": [{"control": gives({"vx": np.nan})}],
    "motion.carried": [{"carried": 3.0}, {"carried": [None]}],
    "motion.rolled": [{"rolled": np.nan}],
    "carried.period": [{"carried": vc.Carried([0.0, 0.0], [0.0, 0.1], period=0.11)}],
    "carried.y": [{"carried": vc.Carried([[0.0, 0.0]] * 2, [0.0, 1.0], [0.0, 1.0])}],
}  # fmt: skip


@pytest.mark.parametrize(
    ("field", "entries"), [(field, each) for field, several in BAD.items() for each in several]
)
def test_bad_input_is_refused(field, entries):
    with pytest.raises(vc.SceneError) as error:
        vc.solve(roller(steps=4, **entries))
    assert error.value.field == field
    if callable(entries.get("control")):  # what was solved before is kept
        assert (error.value.step, len(error.value.history)) == (2, 2)


@pytest.mark.parametrize(
    ("field", "given"),
    [
        ("height", {"height": [0.0, np.nan], "x": [0.0, 1.0]}),
        ("x", {"height": [0.0, 1.0], "x": None}),
        ("x", {"height": [0.0, 1.0], "x": [1.0, 0.0]}),
        ("x", {"height": [0.0, 1.0], "x": [0.0, 1.0, 2.0]}),
        ("y", {"height": [[0.0, 1.0]] * 2, "x": [0.0, 1.0], "y": [0.0]}),
        ("period", {"height": [0.0, 1.0], "x": [0.0, 1.0], "period": 1.0}),
    ],
)
def test_bad_heights_are_refused(field, given):
    with pytest.raises(vc.SceneError) as error:
        vc.Carried(**given)
    assert error.value.field.startswith(f"carried.{field}")
    refused(lambda: vc.Carried.flat(length=2 * R, radius=R, at=1.0), match="chord")
    refused(lambda: vc.Carried.flat(length=1.0, radius=R, at=1.0, worn="no"), match="worn")


@pytest.mark.long
def test_passages_wear_a_corrugation_away_as_linear_theory_says():
    """Each takes work times a factor off the rail; its amplitude then falls by growth times the
    mean depth.
    """
    cells, length = 30, 4.0
    rail, scene = waves(length, 0.2, cells), roller(cells, steps=1)
    growth = vc.corrugation_growth(
        vc.solve(replace(scene, motion=vc.Steady(Fx=scene.motion.Fx))), length
    )
    lead, period = 3 * scene.grid.nx, rail.x.size
    first, expected = abs(np.fft.rfft(rail.height)[1]), 1.0
    for _ in range(2):
        motion = replace(scene.motion, carried=rail, steps=lead + period + scene.grid.nx)
        work = vc.solve(replace(scene, motion=motion), certify="none").work_along()[
            0, lead : lead + period
        ]
        depth = 0.15 / abs(float(growth.growth[0])) * work / work.mean()
        again = (work.X.values - rail.x[0]) % length
        order = np.argsort(again)
        rail = rail.worn(np.interp(rail.x, again[order], depth.values[order], period=length))
        expected *= 1 - 0.15
        assert abs(np.fft.rfft(rail.height)[1]) / first == pytest.approx(expected, rel=0.03)


def test_a_flat_deeper_than_the_approach_is_doubted():
    x = np.linspace(-1.0, 1.0, 41)
    for deep in (True, False):
        depth = (2.0 if deep else 0.5) * 0.5**2 / R
        flat = vc.Carried(np.where(np.abs(x) < 0.9, -depth, 0.0), x, period=20.0)
        motion = vc.Transient(steps=1, dq=0.1, vx=0.0, carried=flat)
        given = {"surface": vc.Paraboloids(R, R), "normal_force": None, "approach": 0.25 / R}
        scene = replace(roller(steps=1), **given, grid=vc.Grid(nx=12, ny=12), motion=motion)
        assert any("exceed the approach" in doubt for doubt in scene.doubts) == deep
        force = vc.solve(scene)[-1].normal_force
        assert (force == 0.0) == deep


@pytest.mark.long
def test_a_field_of_asperities():
    """Tens of contacts at once, which are there again after each wavelength; under friction they
    bear the force.
    """
    x, y, wave = np.arange(160) * 0.04, np.arange(-64, 65) * 0.04, 2 * np.pi / 1.28
    bumps = vc.Carried(1.6e-2 * np.cos(wave * x) * np.cos(5 * y)[:, None], x, y, period=6.4)
    grid = vc.Grid(nx=64, ny=64, dx=0.08, dy=0.08, x0=-2.56, y0=-2.56)
    field = replace(roller(steps=1), surface=vc.Paraboloids(R, R), normal_force=6e-2, grid=grid)
    motion = vc.Transient(steps=18, dq=0.08, Fx=-2e-3, carried=bumps)
    history = vc.solve(replace(field, motion=motion))
    assert min(label(sol.pressure > 0)[1] for sol in history) >= 10
    np.testing.assert_allclose(
        history[17].pressure, history[1].pressure, atol=1e-6 * history[1].max_pressure
    )
    assert max(sol.certificate.residual for sol in history) < 1e-8
    np.testing.assert_allclose(history.force[:, 0], -2e-3, rtol=1e-7)


def test_positions_are_the_sums_of_the_distances_rolled() -> None:
    back_and_forth = vc.Transient(
        steps=5, dq=[0.1, 0.2, 0.3, 0.0, 0.4], direction=[1, -1, 1, 1, -1], rolled=0.5
    )
    at = [back_and_forth.position(k, dx=0.7) for k in range(-1, 5)]
    np.testing.assert_allclose(at, [0.5, 0.6, 0.4, 0.7, 0.7, 0.3], rtol=1e-15)

    by_elements = vc.Transient(steps=3, direction=-1)
    at = [by_elements.position(k, dx=0.7) for k in range(-1, 3)]
    np.testing.assert_allclose(at, [0.0, -0.7, -1.4, -2.1], rtol=1e-15)
