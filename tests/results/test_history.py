"""Histories: kept in memory and in files, interrupted and gone on with, and what is refused."""

import dataclasses
import gc
import json
import tracemalloc

import numpy as np
import pytest
from typer.testing import CliRunner

import varcontact as vc
from tests.scenes import refused
from varcontact.cli import app
from varcontact.io import records
from varcontact.io.scene_toml import scene_to

FIELDS = ("pressure", "traction", "slip", "distance", "state", "force", "approach", "creepage")
BALL = vc.Paraboloids(10.0, 10.0)
MOTION = vc.Transient(
    steps=5,
    dq=[0, 0.05, 0.05, 0, 0.1],
    direction=[1, 1, -1, 1, 1],
    vx=[0, 2e-3, 0, 0, 3e-3],
    spin=2e-3,
    rotation=[1e-4, 0, 0, 0, 0],
    Fx=[-1e-3, None, -2e-3, 1e-3, None],
    normal_force=[None, 0.02, 0.03, None, None],
    approach=[None, None, None, None, 0.02],
    friction=[0.3, None, 0.2, None, 0.3],
)


def scene(**changes):
    base = {
        "bodies": vc.Bodies(G=1.0, nu=0.28),
        "surface": BALL,
        "normal_force": 0.02,
        "friction": 0.3,
    }
    return vc.Scene(**{**base, "motion": MOTION, "grid": vc.Grid(nx=8, ny=8), **changes})


def cylinder(motion, cells=12, **changes):
    base = {
        "bodies": vc.Bodies(G=1.0, nu=0.28),
        "surface": vc.Cylinders(R=100.0),
        "normal_force": 1.0,
    }
    return vc.Scene(
        **{**base, "friction": 0.3, "motion": motion, "grid": vc.Grid(nx=cells), **changes}
    )


def same(one, other):
    assert len(one) == len(other)
    for first, second in zip(one, other, strict=True):
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(first, name), getattr(second, name), err_msg=name)


def test_scene_is_written_to_a_file_once(tmp_path, monkeypatch):
    """The scene has the motion of all steps: written with each, its cost would grow with their
    number.
    """
    written = []

    def counting(scene):
        written.append(scene)
        return scene_to(scene)

    monkeypatch.setattr(records, "scene_to", counting)
    history = vc.solve(cylinder(vc.Transient(steps=6, dq=0.5, Fx=-0.2)), store=tmp_path / "a.nc")
    assert len(history) == 6
    assert len(written) == 1


def stopping(after):
    """A progress that presses Ctrl-C when so many steps are done."""

    def progress(word):
        if word.startswith(f"{after} of"):
            raise KeyboardInterrupt

    return progress


@pytest.fixture(
    scope="module", params=[(1.0, 0.28), ((1.0, 3.0), (0.1, 0.35))], ids=["like", "unlike"]
)
def history(request):
    return vc.solve(scene(bodies=vc.Bodies(*request.param)))


def test_a_normal_problem_that_stays_is_solved_once():
    """A step has the pressure of the step before to the bit, until its load changes."""
    x = np.linspace(-0.6, 0.6, 25)
    wavy = vc.SampledDistance(h=(x**2 + x[:, None] ** 2) / 20 + 1e-3 * np.cos(9 * x), x=x, y=x)
    grid = vc.Grid(nx=16, ny=16, dx=0.075, dy=0.075, x0=-0.6, y0=-0.6)
    motion = vc.Transient(
        steps=4, dq=[0.0, 0.075, 0.075, 0.075], Fx=-2e-3, normal_force=[0.02, 0.02, 0.03, 0.03]
    )
    steps = vc.solve(scene(surface=wavy, motion=motion, grid=grid))
    assert ["normal" in step.calls for step in steps] == [True, False, True, False]
    for before, after in ((0, 1), (2, 3)):
        np.testing.assert_array_equal(steps[before].pressure, steps[after].pressure)
        assert steps[after].certificate.normal_residual < 1e-8
    assert not np.array_equal(steps[1].pressure, steps[2].pressure)


def test_bounds_on_the_forces_of_steps_are_computed_on_demand():
    motion = vc.Transient(steps=2, dq=[0.0, 0.05], Fx=-2e-3)
    for certify, level in (("auto", "gap"), ("full", "full")):
        step = vc.solve(scene(motion=motion), certify=certify)[-1]
        assert step.certificate.level == level
        assert np.isfinite(step.certificate.gap)
        assert np.isfinite(step.certificate.force_bound).all() == (certify == "full")
    step = vc.solve(scene(motion=motion))[-1]
    assert 'certify = "gap"; "full" computes everything' in step.report()


def test_series_are_those_of_the_steps(history):
    assert len(history) == 5
    assert history[-1] is history[4]
    assert [sol.force[0] for sol in history[1:3]] == list(history.force[1:3, 0])
    assert history.rolled == pytest.approx([0, 0.05, 0.1, 0.1, 0.2])
    assert history.position == pytest.approx([0, 0.05, 0.0, 0.0, 0.1])
    assert history.force[[0, 2, 3], 0] == pytest.approx([-1e-3, -2e-3, 1e-3], rel=1e-8)
    assert history.normal_force[:4] == pytest.approx([0.02, 0.02, 0.03, 0.02])
    assert history.approach[4] == pytest.approx(0.02)
    work = [sol.power_density.sum() * sol.grid.area for sol in history]
    assert history.dissipation == pytest.approx(np.array(work) * [1, 0.05, 0.05, 1, 0.1])
    for sol in (history[0], history[3]):
        assert sol.power_density == pytest.approx(-np.sum(sol.traction * sol.slip, axis=0))
    assert history[2].scene.motion == vc.TimeStep(dq=0.05, direction=-1, spin=2e-3, Fx=-2e-3)
    assert history[2].scene.friction == 0.2
    with pytest.raises(IndexError):
        history[5]


def test_a_dataset_stacks_the_steps(history, tmp_path):
    history.save(tmp_path / "history.nc")
    for data in (history.to_xarray(), vc.load(tmp_path / "history.nc").to_xarray()):
        assert data["traction"].dims == ("step", "component", "y", "x")
        np.testing.assert_array_equal(data["traction"].values[2], history[2].traction)
        assert float(data["force"].sel(step=3, component="x")) == history[3].force[0]
        np.testing.assert_array_equal(data["rolled"], history.rolled)
        np.testing.assert_array_equal(data["x"], history.grid.x)
        data.close()


@pytest.mark.long
def test_interrupted_and_gone_on_with_is_the_same(history, tmp_path):
    path, whole = tmp_path / "history.nc", history.scene
    with pytest.raises(vc.Interrupted, match="after 3 of 5 steps") as stop:
        vc.solve(whole, store=path, progress=stopping(3))
    assert len(stop.value.partial) == 3
    same(stop.value.partial, vc.load(path))
    with pytest.raises(KeyboardInterrupt) as stop:
        vc.solve(whole, progress=stopping(2))
    same(stop.value.partial, history[:2])
    told = []
    same(vc.solve(whole, store=path, progress=told.append), history)
    assert told == ["3 of 5 steps", "4 of 5 steps"]
    told.clear()
    same(vc.solve(whole, store=path, progress=told.append), history)
    assert told == []


@pytest.mark.parametrize("name", ["history.h5", "history"])
def test_a_history_is_netcdf(history, tmp_path, name):
    """Another ending is refused before a step is solved."""
    with pytest.raises(vc.OutputError, match=r"store = .*the name must end in \.nc"):
        vc.solve(history.scene, store=tmp_path / name, progress=pytest.fail)
    with pytest.raises(vc.OutputError, match=r"path = .*must end in \.nc"):
        history.save(tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.long
def test_a_history_begins_with_a_saved_step(history, tmp_path):
    history[1].save(tmp_path / "step.nc")
    names = ("dq", "direction", "vx", "Fx", "normal_force", "approach", "friction", "rotation")
    rest = {name: getattr(MOTION, name)[2:] for name in names}
    motion = dataclasses.replace(MOTION, steps=3, start=vc.load(tmp_path / "step.nc"), **rest)
    posed = dataclasses.replace(history.scene, motion=motion, grid=history.grid)
    later = vc.solve(posed, method="active-set")  # as "auto" chose before
    same(later, history[2:])
    later.save(tmp_path / "later.nc")
    same(vc.solve(later.scene, method="active-set", store=tmp_path / "later.nc"), later)
    assert vc.load(tmp_path / "later.nc").scene.motion.start.force[0] == history[1].force[0]


def test_a_start_on_another_grid_is_interpolated_on_request():
    coarse = vc.solve(scene(motion=vc.Shift(Fx=-2e-3), grid=vc.Grid(nx=16, ny=16)))
    fine = scene(grid=vc.Grid(nx=20, ny=20), motion=vc.Transient(steps=1, Fx=-2e-3, start=coarse))
    refused(lambda: vc.solve(fine), match=r"motion.start = .*18 x 18 elements.*interpolate")
    went_on = vc.solve(
        dataclasses.replace(fine, motion=dataclasses.replace(fine.motion, interpolate=True))
    )
    exact = vc.solve(
        dataclasses.replace(fine, motion=vc.Transient(steps=2, dq=[0, 2 * 0.4407 / 20], Fx=-2e-3))
    )
    difference = (
        np.abs(went_on[0].traction - exact[1].traction).sum() / np.abs(exact[1].traction).sum()
    )
    assert difference < 0.1


def test_the_pressure_of_a_start_on_another_grid_is_found_anew():
    """The first steps have the same load as the start, whose pressure carries it on its own grid."""
    coarse = scene(grid=vc.Grid(nx=8, ny=8), motion=vc.Transient(steps=1, dq=0.05, Fx=-2e-3))
    motion = vc.Transient(steps=2, dq=0.05, Fx=-2e-3, start=vc.solve(coarse)[0], interpolate=True)
    went_on = vc.solve(dataclasses.replace(coarse, grid=vc.Grid(nx=14, ny=14), motion=motion))
    np.testing.assert_allclose([step.normal_force for step in went_on], 0.02, rtol=1e-12)


def test_steps_under_one_load_have_one_pressure_in_line_contact():
    """Its approach is not determined without a depth; each step has the certificate of the first."""
    history = vc.solve(cylinder(vc.Transient(steps=3, dq=0.5, Fx=-0.2)))
    first, *others = history
    for step in others:
        np.testing.assert_array_equal(step.pressure, first.pressure)
        assert step.solved_by["normal"] == "hertz"
        assert np.isnan(step.approach)
        expected = pytest.approx(first.certificate.normal_residual, rel=1e-12)
        assert step.certificate.normal_residual == expected


@pytest.mark.long
def test_memory_does_not_grow_with_the_steps(tmp_path):
    kept = []
    vc.solve(cylinder(vc.Transient(steps=2, dq=0.5, Fx=-0.2), 200), store=tmp_path / "imports.nc")
    for steps in (10, 30):
        tracemalloc.start()
        before, _ = tracemalloc.get_traced_memory()
        history = vc.solve(
            cylinder(vc.Transient(steps=steps, dq=0.5, Fx=-0.2), 200),
            store=tmp_path / f"{steps}.nc",
        )
        gc.collect()
        after, _ = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert len(history) == steps
        kept.append(after - before)
    step = sum(
        getattr(history[0], name).nbytes for name in ("pressure", "traction", "slip", "distance")
    )
    assert kept[1] < kept[0] + 5 * step


@pytest.mark.long
def test_saving_does_not_take_the_whole_into_memory(tmp_path):
    one = vc.solve(cylinder(vc.Transient(steps=1, dq=0.5, Fx=-0.2), 200))
    whole = cylinder(vc.Transient(steps=150, dq=0.5, Fx=-0.2), 200, grid=one.grid)
    in_memory = dataclasses.replace(one, scene=whole, solutions=[one[0]] * 150)
    in_memory.save(tmp_path / "first.nc")
    for history in (in_memory, vc.load(tmp_path / "first.nc")):
        tracemalloc.start()
        history.save(tmp_path / "again.nc")
        _, peak = tracemalloc.get_traced_memory()
        tracemalloc.stop()
        assert peak < (tmp_path / "again.nc").stat().st_size / 4
        assert (tmp_path / "again.nc").read_bytes() == (tmp_path / "first.nc").read_bytes()


def test_a_file_of_something_else_is_left_alone(history, tmp_path):
    path, whole = tmp_path / "history.nc", history.scene
    history.save(path)
    other = dataclasses.replace(whole, motion=dataclasses.replace(whole.motion, spin=3e-3))
    for given, keywords in ((other, {}), (whole, {"tol": 1e-9}), (whole, {"tangential": "tang"})):
        with pytest.raises(vc.OutputError, match="history of another scene, or by other methods"):
            vc.solve(given, store=path, **keywords)
    with pytest.raises(
        vc.OutputError,
        match=r"exists already and is no solution of varcontact's; .* overwrite=True",
    ):
        history[0].save(path)
    same(vc.load(path), history)
    history[0].save(path, overwrite=True)
    with pytest.raises(vc.OutputError, match="holds no history"):
        vc.solve(whole, store=path)
    with pytest.raises(vc.OutputError, match="is no history of varcontact's"):
        history.save(path)
    with pytest.raises(vc.SceneError, match="only a history of steps"):
        vc.solve(dataclasses.replace(whole, motion=vc.Shift()), store=tmp_path / "other.nc")
    history.save(path, overwrite=True)
    content = path.read_bytes()
    path.write_bytes(content[:300])
    with pytest.raises(vc.OutputError, match=r"^path = [^:]*: cannot be read as netCDF \("):
        vc.load(path)


def test_a_force_beyond_saturation_says_where_and_keeps_what_was_before(tmp_path):
    motion = vc.Transient(steps=5, Fx=[-2e-3, -4e-3, -5e-3, -6.5e-3, 0])
    with pytest.raises(
        vc.Saturated, match=r"step 3 of the history: .* 0.0065 .* less than 0.006 "
    ) as failure:
        vc.solve(scene(motion=motion), store=tmp_path / "history.nc")
    error = failure.value
    assert (error.step, error.force, error.limit) == pytest.approx((3, 6.5e-3, 6e-3))
    assert error.history.force[:, 0] == pytest.approx([-2e-3, -4e-3, -5e-3], rel=1e-8)
    assert len(vc.load(tmp_path / "history.nc")) == 3
    with pytest.raises(vc.Saturated, match="step 1"):
        vc.solve(scene(motion=vc.Transient(steps=2, Fx=[-1e-3, -1e-3], normal_force=[0.02, 0.0])))


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({"steps": 0}, r"motion.steps = 0 .* a whole number, 1 or more"),
        ({"steps": 2.5}, r"motion.steps"),
        ({"vx": [1e-3, 2e-3]}, r"motion.vx = '2 values' .* each of the 3 steps"),
        ({"vx": [[1e-3], [0], [0]]}, r"motion.vx"),
        ({"vx": [0, float("nan"), 0]}, r"motion.vx\[1\] = nan"),
        ({"spin": [0, None, 0]}, r"motion.spin\[1\] = None"),
        ({"Fy": float("inf")}, r"motion.Fy = inf"),
        ({"dq": [0.1, 0.1, -0.1]}, r"motion.dq\[2\] = -0.1 .* zero or positive"),
        ({"direction": [1, 0, 1]}, r"motion.direction\[1\] = 0 .* 1 or -1"),
        ({"normal_force": [1, -1, 1]}, r"motion.normal_force\[1\] = -1"),
        ({"friction": [0.3, -0.1, 0.3]}, r"motion.friction\[1\] = -0.1"),
        (
            {"Fx": [0.1, None, 0.1], "vx": [0, 1e-3, 1e-3]},
            r"motion\.Fx\[2\], motion\.vx\[2\] = \(0\.1, 0\.001\)",
        ),
        ({"Fy": 0.1, "uy": [0, 0, 1e-3]}, r"motion\.Fy\[2\], motion\.uy\[2\] = \(0\.1, 0\.001\)"),
        ({"surface": [BALL]}, r"one surface for each of the 3 steps"),
        ({"start": "last.nc"}, r"motion.start = 'last.nc' .* a Solution"),
        ({"interpolate": 1}, r"motion.interpolate"),
        ({"spin_offset": 2}, r"motion.spin_offset"),
    ],
)
def test_entries_that_cannot_be_are_named(entries, message):
    refused(lambda: vc.Transient(**{"steps": 3, **entries}), match=message)


def test_scenes_that_cannot_be_are_refused():
    with pytest.raises(
        vc.SceneError, match=r"motion.normal_force\[1\] and motion.approach\[1\] are both given"
    ):
        scene(motion=vc.Transient(steps=2, normal_force=0.02, approach=[None, 0.01]))
    with pytest.raises(
        vc.SceneError, match=r"neither motion.normal_force\[1\] nor motion.approach\[1\] is given"
    ):
        scene(normal_force=None, motion=vc.Transient(steps=2, normal_force=[0.02, None]))
    with pytest.raises(vc.SceneError, match="an Ellipse with the scene's own normal_force"):
        scene(
            normal_force=None,
            surface=vc.Ellipse(1.0, 1.0),
            motion=vc.Transient(steps=2, normal_force=0.02),
        )
    with pytest.raises(vc.SceneError, match="friction is missing"):
        scene(friction=None, motion=vc.Transient(steps=2, friction=[0.3, None]))
    with pytest.raises(vc.SceneError, match="line contact with the same reference_depth"):
        scene(motion=vc.Transient(steps=2, surface=[BALL, vc.Cylinders(R=1.0)]))
    with pytest.raises(vc.SceneError, match=r"motion.spin = 0.1 .* line contact"):
        cylinder(vc.Transient(steps=2, spin=[0, 0.1]))
    for motion in (vc.Transient(steps=2, vx=1e-3), vc.Transient(steps=2, Fx=[-0.1, None])):
        with pytest.raises(
            vc.SceneError,
            match=r"without motion.Fx, needs surface.reference_depth: .* motion.Fx in every step$",
        ):
            cylinder(motion)
    with pytest.raises(
        vc.SceneError, match=r"approach of step 1 needs surface.reference_depth: .* a normal force$"
    ):
        cylinder(vc.Transient(steps=2, Fx=0, approach=[None, 0.1], normal_force=[1.0, None]))
    with pytest.raises(vc.NoContact, match="touch once at least"):
        vc.solve(scene(motion=vc.Transient(steps=2, normal_force=0.0)))
    with pytest.raises(vc.SceneError, match="a TimeStep continues from the step before it"):
        vc.solve(scene(motion=vc.TimeStep(dq=0.1)))
    refused(lambda: vc.scan(scene(), [(0, 0, 0)]), match="Steady or Shift")
    refused(lambda: vc.certify(scene(), np.zeros((2, 10, 10))), match="motion")
    with pytest.raises(vc.SceneError, match="is Transient: it must be Steady"):
        vc.compare(scene(), ["clarabel"])


def test_a_contact_that_leaves_the_grid_says_in_which_step():
    grid = vc.Grid(nx=12, ny=12, dx=0.1, dy=0.1, x0=-0.6, y0=-0.6)
    hills = [
        vc.SampledDistance((grid.x - at) ** 2 / 20 + grid.y[:, None] ** 2 / 20)
        for at in (0.0, 0.1, 0.4)
    ]
    with pytest.raises(vc.SceneError, match="step 2 of the history: grid") as failure:
        vc.solve(
            scene(surface=hills[0], grid=grid, motion=vc.Transient(steps=3, dq=0, surface=hills))
        )
    assert len(failure.value.history) == 2


TOML = """
friction = 0.3
[bodies]
G = 1.0
nu = 0.28
[surface]
kind = "paraboloids"
Rx = 10.0
Ry = 10.0
[motion]
kind = "transient"
steps = 3
dq = [0, 0.05, 0.05]
Fx = [-1e-3, "none", -2e-3]
vx = {{file = "vx.txt"}}
normal_force = [0.02, 0.02, {last}]
{more}
[grid]
nx = 8
ny = 8
"""


def write(folder, last="0.02", more=""):
    (folder / "vx.txt").write_text("0\n2e-3\n0\n")
    (folder / "scene.toml").write_text(TOML.format(last=last, more=more))
    return str(folder / "scene.toml")


@pytest.mark.long
def test_from_the_command_line(tmp_path, pictures):
    """A TOML scene, its file and its JSON; another call has nothing to do; a start from the
    file.
    """
    out = tmp_path / "history.nc"
    call = [
        "solve",
        write(tmp_path),
        "--json",
        "--out",
        str(out),
        "--plot",
        str(tmp_path / "history.png"),
    ]
    first = CliRunner().invoke(app, call)
    assert first.exit_code == 0, first.output
    result, history = json.loads(first.stdout), vc.load(out)
    assert result["steps"] == result["finished"] == 3
    assert result["force"] == history.force.tolist()
    assert result["rolled"] == pytest.approx([0, 0.05, 0.1])
    assert result["creepage"][1][0] == 2e-3
    assert result["last"] == history[-1].summary()
    assert (tmp_path / "history.png").read_bytes()[:4] == b"\x89PNG"
    forces = next(line for line in pictures[0].axes[0].get_lines() if line.get_label() == "$F_x$")
    np.testing.assert_allclose(forces.get_data(), [history.rolled, 1e3 * history.force[:, 0]])
    assert pictures[0].axes[0].get_ylabel() == "tangential force [$10^{-3}$]"
    assert json.loads(CliRunner().invoke(app, call).stdout) == result
    later, _ = vc.read_scene(write(tmp_path, more='start = "history.nc"'))
    np.testing.assert_array_equal(later.motion.start.traction, history[-1].traction)
