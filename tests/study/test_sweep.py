"""Sweeps: nothing but single solves, wherever they run, and a store that nothing spoils."""

import dataclasses
import functools
import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import psutil
import pytest
import xarray as xr

import varcontact as vc
from varcontact.io.records import INDEX_MARK, record_type

ROOT = Path(__file__).parents[2]
GRID = vc.Grid(nx=6, ny=6)
RECORD = record_type({})
OVER = {"friction": [0.2, 0.3], "motion.vx": [0.0, 0.02, 0.05, 0.1, 0.3]}


@pytest.fixture(scope="module")
def scene(rolling):
    return rolling(grid=GRID)


@pytest.fixture(scope="module")
def alone(scene, tmp_path_factory):
    """The store of the sweep in this process, and what it returns."""
    store = tmp_path_factory.mktemp("alone") / "sweep.nc"
    return store, vc.sweep(scene, OVER, chunk=4, store=store)


@pytest.mark.long
def test_a_sweep_is_its_single_solves(scene, alone):
    _, swept = alone
    assert dict(swept.sizes) == {"friction": 2, "motion.vx": 5}
    assert (swept["outcome"] == "solved").all()
    assert "Fx_error" not in swept and "accuracy" not in swept.attrs
    for f in OVER["friction"]:
        for vx in OVER["motion.vx"]:
            motion = dataclasses.replace(scene.motion, vx=vx)
            sol = vc.solve(dataclasses.replace(scene, friction=f, motion=motion))
            found = swept.sel({"friction": f, "motion.vx": vx})
            np.testing.assert_allclose([found["Fx"], found["Fy"]], sol.force, rtol=0, atol=1e-8)
            np.testing.assert_allclose(found["Mz"], sol.moment, rtol=0, atol=1e-8)
            assert {name: int(found[name]) for name in ("contact", "stick", "slip")} == sol.elements
            assert (float(found["vx"]), float(found["spin"])) == (vx, 0.05)
            assert float(found["residual"]) < 1e-8
            assert np.isnan(found["Fx_bound"])
            check_areas_and_work(found, sol)


def check_areas_and_work(found, sol):
    for name, area in sol.areas.items():
        assert float(found[f"{name}_area"]) == pytest.approx(area, rel=1e-12, abs=0), name
    assert float(found["max_pressure"]) == pytest.approx(sol.max_pressure, rel=1e-12)
    limit = sol.scene.friction * sol.normal_force * np.abs(sol.creepage).max()
    assert float(found["friction_work"]) == pytest.approx(sol.friction_work, abs=1e-8 * limit)


@pytest.mark.parametrize("by", ["batches", "single solves"])
def test_areas_pressure_and_work_in_shifts(rolling, by):
    """Of a shift by force the work is no product of force and shift."""
    scene = rolling(
        grid=GRID,
        motion=vc.Shift(Fx=-0.1, uy=0.02, rotation=0.05),
        units=vc.Units(length="mm", force="N"),
    )
    swept = vc.sweep(
        scene, {"motion.Fx": [-0.1, 0.2]}, tangential="auto" if by == "batches" else "newton"
    )
    for Fx in (-0.1, 0.2):
        sol = vc.solve(dataclasses.replace(scene, motion=dataclasses.replace(scene.motion, Fx=Fx)))
        check_areas_and_work(swept.sel({"motion.Fx": Fx}), sol)
        assert 0 < sol.friction_work < 0.99 * sol.power
    units = {
        name: swept[name].units
        for name in ("slip_area", "max_pressure", "friction_work", "vx", "motion.Fx")
    }
    expected = {
        "slip_area": "mm^2",
        "max_pressure": "N/mm^2",
        "friction_work": "N mm",
        "vx": "mm",
        "motion.Fx": "N",
    }
    assert units == expected


def test_bounds_where_they_are_asked_for(scene, alone):
    over = {"motion.vx": OVER["motion.vx"]}
    plain, full = vc.sweep(scene, over), vc.sweep(scene, over, certify="full")
    assert (
        plain["Fx_bound"].isnull().all()
        and (full["Fx_bound"] < 1e-6).all()
        and (full["Mz_bound"] > 0).all()
    )
    np.testing.assert_allclose(full["Fx"], plain["Fx"], rtol=0, atol=1e-8 * scene.friction)
    creepages = [[0.04, -0.02, 0.05]]
    (quick,), (exact,) = vc.scan(scene, creepages), vc.scan(scene, creepages, certify="full")
    assert quick.certificate.level == "gap" and quick.certificate.relative_gap < 1e-8
    assert np.isinf(quick.certificate.force_bound).all(), "none is known"
    assert (exact.certificate.force_bound < 1e-8).all()
    np.testing.assert_array_equal(exact.force, quick.force)


ENTRIES = {
    "normal_force": 2.0,
    "friction": 0.2,
    "bodies.nu": 0.4,
    "surface.a": 1.5,
    "grid.nx": 7,
    "grid.edge": "touched",
}


@pytest.mark.parametrize("name", ENTRIES)
def test_any_entry_can_vary(scene, name):
    """In batches, and one by one behind a scene that keeps what only another motion may use
    again.
    """
    value, (part, _, entry) = ENTRIES[name], name.rpartition(".")
    changed = dataclasses.replace(getattr(scene, part), **{entry: value}) if part else value
    sol = vc.solve(dataclasses.replace(scene, **{part or entry: changed}))
    before = functools.reduce(getattr, name.split("."), scene)
    for swept in (
        vc.sweep(scene, {name: [value]}),
        vc.sweep(scene, {name: [before, value]}, tangential="newton"),
    ):
        np.testing.assert_allclose(
            [swept["Fx"][-1], swept["Fy"][-1]], sol.force, rtol=1e-7, atol=1e-9
        )


def test_entries_of_one_part_change_together(scene):
    """None of the scenes in between is ever made: an ellipse so thin would be refused."""
    swept = vc.sweep(scene, {"surface.a": [1e-3], "surface.b": [1e-3]})
    assert swept["outcome"].item() == "solved"


def test_scenes_by_name_and_by_number(scene):
    other = dataclasses.replace(scene, bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3)))
    named = vc.sweep({"like": scene, "unlike": other}, {"friction": [0.3, 0.4]})
    assert named["Fx"].dims == ("scene", "friction")
    assert named["scene"].values.tolist() == ["like", "unlike"]
    single = vc.solve(other).force[0]
    np.testing.assert_allclose(
        named["Fx"].sel(scene="unlike", friction=0.3), single, rtol=0, atol=1e-8
    )
    numbered = vc.sweep([scene, other])
    np.testing.assert_allclose(numbered["Fx"], named["Fx"].sel(friction=0.3), rtol=0, atol=1e-8)


def test_a_single_scene_of_normal_contact_and_theories(scene):
    assert vc.sweep(dataclasses.replace(scene, motion=None))["approach"].shape == ()
    assert (vc.sweep(scene, OVER, tangential="fastsim")["outcome"] == "approximate").all()


@pytest.mark.long
def test_threads_and_processes_give_the_same_bytes(scene, alone, tmp_path):
    expected, swept = alone[0].read_bytes(), alone[1]
    assert vc.sweep(scene, OVER, chunk=4, workers=2, store=tmp_path / "processes.nc").identical(
        swept
    )
    with ThreadPoolExecutor(2) as pool:
        vc.sweep(scene, OVER, chunk=4, executor=pool, store=tmp_path / "threads.nc")
        assert pool.submit(int).result() == 0, "it stays open"
    same = {file.stem: file.read_bytes() == expected for file in tmp_path.iterdir()}
    assert same == {"processes": True, "threads": True}


@pytest.mark.long
def test_what_ran_before_changes_no_digit(scene, alone, tmp_path):
    vc.sweep(dataclasses.replace(scene, friction=0.7), {"motion.vx": [0.01, 0.2]})
    vc.sweep(scene, OVER, chunk=4, store=tmp_path / "again.nc")
    assert (tmp_path / "again.nc").read_bytes() == alone[0].read_bytes()


def test_influence_numbers_are_made_once_in_a_chunk(rolling, built):
    scene = rolling(grid=GRID, bodies=vc.Bodies(G=1.0, nu=0.123))
    vc.sweep(scene, OVER, chunk=10, certify="full")
    assert [name for name, _ in built].count("A_tt - C_tt") == 1


def test_neighbours_begin_from_each_other(rolling):
    scene = rolling(grid=vc.Grid(nx=14, ny=14))
    over = {"friction": [0.3, 0.300001, 0.300002, 0.300003]}
    near, alone = (
        vc.sweep(scene, over, tangential="newton", chunk=chunk)["iterations"] for chunk in (4, 1)
    )
    assert int(near[1:].sum()) < 0.7 * int(alone[1:].sum())


@pytest.mark.long
def test_failures_are_recorded_and_the_rest_goes_on(scene, rolling):
    scenes = {
        "good": scene,
        "saturated": dataclasses.replace(scene, motion=vc.Steady(Fx=-0.5)),
        "broken": dataclasses.replace(scene, surface=Broken(Rx=1.0, Ry=1.0)),
        "again": scene,
    }
    swept = vc.sweep(scenes)
    assert swept["outcome"].values.tolist() == ["solved", "refused", "failed", "solved"]
    reasons = swept["reason"].values.tolist()
    assert "a tangential force of 0.5 cannot be carried" in reasons[1]
    assert reasons[2] == "ValueError: no such distance"
    assert np.isnan(swept["Fx"].values[[1, 2]]).all()
    np.testing.assert_allclose(swept["Fx"][3], swept["Fx"][0], rtol=0, atol=1e-8)


class Broken(vc.Paraboloids):
    """A surface with an error of its own."""

    def distance(self, grid):
        raise ValueError("no such distance")


def test_what_does_not_converge_is_no_figure(scene):
    swept = vc.sweep(scene, {"motion.vx": [0.01, 0.02]}, tangential="scs", polish=False, tol=1e-18)
    assert (swept["outcome"] == "not converged").all()
    assert "the residual is not below tol" in swept["reason"].values[0]
    assert np.isnan(swept["Fx"]).all()


@pytest.mark.long
def test_ctrl_c_keeps_what_is_finished_and_the_sweep_goes_on(scene, alone, tmp_path):
    store, told = tmp_path / "sweep.nc", []

    def stop(standing):
        told.append(standing)
        if standing.done == 4:
            raise KeyboardInterrupt

    with pytest.raises(vc.Interrupted, match=r"^interrupted after 4 of 10 scenes$") as stopped:
        vc.sweep(scene, OVER, chunk=4, store=store, progress=stop)
    partial = stopped.value.partial
    assert (partial["outcome"].values.ravel() == "solved").tolist() == 4 * [True] + 6 * [False]
    assert vc.read_sweep(store).identical(partial)
    with xr.open_dataset(store) as plain:
        assert plain["friction_work"].isnull().values.ravel().tolist() == 4 * [False] + 6 * [True]
    again = []
    assert vc.sweep(scene, OVER, chunk=4, store=store, progress=again.append).identical(alone[1])
    assert [standing.done for standing in again] == [4, 8, 10], (
        "the first chunk is not solved again"
    )
    assert store.read_bytes() == alone[0].read_bytes()
    vc.sweep(scene, OVER, chunk=4, store=store, workers=3, progress=again.append)
    assert again[-1].done == 10 and len(again) == 4, "nothing is left to do"


PROGRAM = """
import os, sys
import psutil
import varcontact as vc

def main():
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.2, b=0.9), normal_force=1.0, friction=0.3,
        motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05), grid=vc.Grid(nx=6, ny=6))
    over = {"friction": [0.2, 0.3], "motion.vx": [0.0, 0.02, 0.05, 0.1, 0.3]}

    def told(standing):
        if standing.done >= 4:
            print(*(child.pid for child in psutil.Process().children(recursive=True)), flush=True)
            sys.stdin.readline()

    vc.sweep(scene, over, chunk=4, workers=2, store="sweep.nc", progress=told)

if __name__ == "__main__":
    main()
"""


@pytest.mark.long
def test_killed_it_goes_on_and_leaves_no_process(scene, alone, tmp_path):
    (tmp_path / "program.py").write_text(PROGRAM)
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    program = subprocess.Popen([sys.executable, "program.py"], cwd=tmp_path, **pipes)
    children = [int(word) for word in program.stdout.readline().split()]
    assert len(children) >= 2
    with pytest.raises(vc.OutputError, match=rf"is being written by process {program.pid} on"):
        vc.sweep(scene, OVER, chunk=4, store=tmp_path / "sweep.nc")
    program.kill()
    program.communicate()
    kept = vc.read_sweep(tmp_path / "sweep.nc")
    assert int((kept["outcome"] == "solved").sum()) >= 4
    vc.sweep(scene, OVER, chunk=4, store=tmp_path / "sweep.nc")
    assert (tmp_path / "sweep.nc").read_bytes() == alone[0].read_bytes()
    assert sorted(os.listdir(tmp_path)) == ["program.py", "sweep.nc"]
    until = time.monotonic() + 60
    while any(psutil.pid_exists(child) for child in children) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(psutil.pid_exists(child) for child in children)


@pytest.mark.long
def test_an_executor_that_dies(scene, alone, tmp_path):
    store = tmp_path / "sweep.nc"
    with ProcessPoolExecutor(1) as pool:

        def kill(standing):
            if standing.done == 4:
                os.kill(next(iter(pool._processes)), signal.SIGKILL)

        words = r"^the executor gives no result \(BrokenProcessPool: .*\) after \d+ of 10 scenes$"
        with pytest.raises(vc.WorkersLost, match=words) as lost:
            vc.sweep(scene, OVER, chunk=1, executor=pool, store=store, progress=kill)
    assert int((lost.value.partial["outcome"] == "solved").sum()) >= 4
    assert vc.read_sweep(store).identical(lost.value.partial)


def test_an_executor_that_is_shut_down(scene):
    pool = ThreadPoolExecutor(1)
    pool.shutdown()
    with pytest.raises(vc.WorkersLost, match=r"\(RuntimeError: cannot schedule .*\) after 0 of"):
        vc.sweep(scene, OVER, executor=pool)


def test_a_store_of_another_sweep_is_refused_and_stays(scene, alone, tmp_path):
    store = tmp_path / "sweep.nc"
    store.write_bytes(alone[0].read_bytes())
    others = [
        ({"over": {**OVER, "friction": [0.2, 0.31]}}, ""),
        ({"scenes": dataclasses.replace(scene, normal_force=1.1)}, ""),
        ({"chunk": 5}, r" \(chunk = 4, not 5\)"),
        (
            {"tol": 1e-7, "certify": "full"},
            r" \(tol = 1e-08, not 1e-07, certify = 'gap', not 'full'\)",
        ),
    ]
    for changes, difference in others:
        with pytest.raises(
            vc.OutputError, match=f"holds another sweep{difference}; name a new file"
        ):
            vc.sweep(**{"scenes": scene, "over": OVER, "chunk": 4, "store": store, **changes})
    assert store.read_bytes() == alone[0].read_bytes()


def test_another_file_is_refused_and_stays(scene, alone, tmp_path):
    netcdf = alone[0].read_bytes().partition(INDEX_MARK)[0]
    store, no_sweep = tmp_path / "run.nc", "is not a 'varcontact sweep 3' file"
    vc.solve(dataclasses.replace(scene, motion=vc.Transient(steps=1, dq=0.2, vx=0.01)), store=store)
    vc.solve(scene).save(tmp_path / "solution.nc")
    for content, words in (
        (store.read_bytes(), no_sweep),
        ((tmp_path / "solution.nc").read_bytes(), no_sweep),
        (b"words", no_sweep),
        (b"\x89HDF\r\n\x1a\n" + bytes(40), no_sweep),
        (netcdf, r"is damaged \(its index is missing\)"),
        (netcdf.replace(b"sweep 3", b"sweep 2"), "is a sweep of an earlier version: .*"),
        (
            (ROOT / "tests" / "data" / "sweep_format_1.nc").read_bytes(),
            "is a sweep of an earlier version: .*",
        ),
    ):
        store.write_bytes(content)
        with pytest.raises(vc.OutputError, match=rf"path = .*run\.nc.*: {words}$"):
            vc.read_sweep(store)
        with pytest.raises(vc.OutputError, match=rf"exists already and {words}; name a new file"):
            vc.sweep(scene, OVER, store=store)
        assert store.read_bytes() == content


def test_a_store_of_an_earlier_version_is_read_as_its_message_says(scene):
    with xr.open_dataset(ROOT / "tests" / "data" / "sweep_format_1.nc") as flat:
        np.testing.assert_allclose(flat["vx"], [0.02, 0.1])
        motion = vc.Steady(vx=0.02)
        np.testing.assert_allclose(
            flat["Fx"][0], vc.solve(dataclasses.replace(scene, motion=motion)).Fx, rtol=1e-7
        )


@pytest.mark.parametrize("name", ["Mz", "iterations", "reason", "check"])
def test_a_damaged_record_is_solved_again(scene, alone, name, tmp_path):
    store, content = tmp_path / "sweep.nc", bytearray(alone[0].read_bytes())
    with h5py.File(alone[0]) as file:
        content[file[name].id.get_offset() + 5 * RECORD[name].itemsize] ^= 64
    store.write_bytes(content)
    found = vc.read_sweep(store)
    assert (found["outcome"].values.ravel() == "solved").tolist() == 5 * [True] + [False] + 4 * [
        True
    ]
    assert np.isnan(found["Fx"].values.ravel()[5])
    told = []
    vc.sweep(scene, OVER, chunk=4, store=store, progress=told.append)
    assert [standing.done for standing in told] == [6, 10], "its chunk, and no other"
    assert store.read_bytes() == alone[0].read_bytes()


@pytest.mark.long
def test_a_store_that_is_replaced_meanwhile_is_not_written_over(scene, alone, tmp_path):
    store, other = tmp_path / "sweep.nc", tmp_path / "other.nc"
    other.write_bytes(b"somebody else's")

    def meddle(standing):
        if standing.done == 4:
            os.replace(other, store)

    with pytest.raises(vc.OutputError, match="has been replaced by something else"):
        vc.sweep(scene, OVER, chunk=4, store=store, progress=meddle)
    assert store.read_bytes() == b"somebody else's"


@pytest.mark.long
def test_a_full_disk_is_found_before_any_work(tmp_path):
    code = (
        "import resource, signal, sys; import varcontact as vc; signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "sys.dont_write_bytecode = True\n"
        "scene = vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.2, b=0.9), normal_force=1.0,\n"
        "    friction=0.3, motion=vc.Steady(vx=0.04), grid=vc.Grid(nx=6, ny=6))\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (4000, 4000))\n"
        "vc.sweep(scene, {'friction': [0.01 * k for k in range(1, 30)]}, store='sweep.nc', progress=print)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert "OutputError: store = 'sweep.nc': cannot be written (File too large)" in done.stderr
    assert done.stdout == ""
    assert os.listdir(tmp_path) == []


def test_plain_xarray_opens_the_store(alone):
    store, swept = alone
    with xr.open_dataset(store) as found:
        assert found.drop_vars("check").equals(swept)
        assert list(found.indexes) == list(OVER)
        assert found["Fx"].sel({"friction": 0.3, "motion.vx": 0.1}) == swept["Fx"][1, 3]
        assert {name: found.attrs[name] for name in swept.attrs} == swept.attrs


@pytest.mark.long
@pytest.mark.parametrize(
    "over", [{}, {"grid.edge": ["centres", "touched"]}, {"normal_force": [1.0, 2.0]}]
)
def test_stores_over_words_loads_and_nothing(scene, over, tmp_path):
    swept = vc.sweep({"one": scene, "\u00e9": scene}, over, store=tmp_path / "sweep.nc")
    assert vc.read_sweep(tmp_path / "sweep.nc").identical(swept)
    with xr.open_dataset(tmp_path / "sweep.nc") as found:
        assert found.drop_vars("check").equals(swept)
    single = vc.sweep(scene, store=tmp_path / "single.nc")
    assert (
        vc.sweep(scene, store=tmp_path / "single.nc").identical(single) and single["Fx"].shape == ()
    )


@pytest.mark.parametrize(
    "error",
    [
        vc.SceneError("bodies.nu", 0.7, "a number in (-1, 0.5]"),
        vc.NoContact("approach", -1.0, "positive"),
        vc.OutputError("store", "a.nc", "is a folder"),
        vc.Saturated(2.0, 1.0),
        vc.NotConverged("no", 1e-3),
        vc.SolverUnavailable("scs", "pip install scs"),
        vc.TooLarge("it", 2e9, 1e9, "less"),
        vc.WorkersLost("gone"),
        vc.Saturated(2.0, 1.0).in_step(3, None),
    ],
)
def test_errors_come_whole_out_of_other_processes(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert (str(again), vars(again)) == (str(error), vars(error))


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (
            lambda s: vc.sweep(3),
            "scenes = 3 .* must be a Scene, a list of them, or a dict of them by name",
        ),
        (lambda s: vc.sweep([]), "scenes = .* at least one"),
        (lambda s: vc.sweep([s, 3]), r"scenes\[1\] = 3 is not allowed: must be a Scene"),
        (lambda s: vc.sweep({1: s}), "scenes = 1 is not allowed: must be named by strings"),
        (
            lambda s: vc.sweep(dataclasses.replace(s, motion=vc.Transient(steps=1))),
            "scenes.motion is Transient",
        ),
        (lambda s: vc.sweep(s, [1.0]), "over = .* must be a dict of values by entry"),
        (
            lambda s: vc.sweep(s, {"motion.spni": [1.0]}),
            r'the scene has no "motion.spni" \(did you mean spin\?\)',
        ),
        (lambda s: vc.sweep(s, {"mu": [1.0]}), 'over: the scene has no "mu"'),
        (
            lambda s: vc.sweep(s, {"vx": [1.0]}),
            r'over: the scene has no "vx" \(did you mean motion.vx\?\)',
        ),
        (
            lambda s: vc.sweep(s, {"friction.static": [1.0]}),
            'no "friction.static": friction is float',
        ),
        (
            lambda s: vc.sweep(s, {"motion": [1.0]}),
            r'over: "motion" is no number \(as "motion.vx"\)',
        ),
        (
            lambda s: vc.sweep(dataclasses.replace(s, motion=None), {"motion.vx": [1.0]}),
            "motion is missing",
        ),
        (lambda s: vc.sweep(s, {"motion.vx": []}), r"over\['motion.vx'\] = .* at least one value"),
        (
            lambda s: vc.sweep(s, {"motion.vx": 0.1}),
            r"over\['motion.vx'\] = 0.1 is not allowed: must be a list of",
        ),
        (
            lambda s: vc.sweep(s, {"motion.vx": [0.1, None]}),
            r"over\['motion.vx'\] = None .* a list of numbers",
        ),
        (
            lambda s: vc.sweep(s, {"motion.vx": [0.1, 0.1]}),
            r"over\['motion.vx'\] = .* different values",
        ),
        (lambda s: vc.sweep(s, {"motion.vx": [0.1, np.nan]}), r"motion\.vx = nan is not allowed"),
        (lambda s: vc.sweep(s, {"friction": [0.1, -0.1]}), r"friction = -0\.1 is not allowed"),
        (lambda s: vc.sweep(s, tangential="tangg"), "tangential = 'tangg' .*did you mean"),
        (
            lambda s: vc.sweep(s, chunk=0),
            "chunk = 0 is not allowed: must be a whole number, 1 or more",
        ),
        (lambda s: vc.sweep(s, workers=0), "workers = 0 is not allowed"),
        (
            lambda s: vc.sweep(s, executor=3),
            r"executor = 3 .* None or a concurrent\.futures\.Executor$",
        ),
        (lambda s: vc.sweep(s, tol=0.0), "tol = 0.0 is not allowed"),
        (lambda s: vc.sweep(s, progress=3), "progress = 3 is not allowed"),
        (lambda s: vc.sweep(s, store=3), "store = 3 is not allowed"),
    ],
)
def test_bad_input_is_refused_by_name(scene, call, words):
    with pytest.raises(vc.SceneError, match=words):
        call(scene)


def test_a_dask_client_is_no_executor_and_the_message_says_what_is(scene):
    with pytest.raises(vc.SceneError, match=r"of a dask client: client\.get_executor\(\)"):
        vc.sweep(scene, executor=SimpleNamespace(get_executor=None))
    with (
        ThreadPoolExecutor(1) as pool,
        pytest.raises(vc.SceneError, match="workers = 2 must be left out"),
    ):
        vc.sweep(scene, executor=pool, workers=2)


def test_a_store_has_to_be_netcdf(scene, tmp_path):
    with pytest.raises(vc.OutputError, match=r"the name must end in \.nc"):
        vc.sweep(scene, OVER, store=tmp_path / "sweep.csv")
    with pytest.raises(vc.OutputError, match="No such file"):
        vc.read_sweep(tmp_path / "sweep.nc")


@pytest.mark.long
@pytest.mark.parametrize("options", [{}, {"accuracy": 0.03}])
def test_without_a_grid_each_has_error_bars(rolling, options, tmp_path):
    over, store = {"motion.vx": [0.05, 0.2]}, tmp_path / "sweep.nc"
    swept = vc.sweep(rolling(grid="auto"), over, store=store, **options)
    for vx in over["motion.vx"]:
        motion = dataclasses.replace(rolling().motion, vx=vx)
        sol = vc.solve(rolling(grid="auto", motion=motion), **options)
        estimate = sol.error_estimate
        found = swept.sel({"motion.vx": vx})
        assert float(found["Fx"]) == pytest.approx(
            estimate.values["Fx"], abs=1e-5 * rolling().friction
        )
        assert float(found["Fx_error"]) == pytest.approx(estimate.bars["Fx"], rel=1e-3)
        assert float(found["friction_work"]) == pytest.approx(sol.friction_work, rel=1e-4)
        assert float(found["slip_area"]) == pytest.approx(sol.areas["slip"], rel=1e-12)
        assert np.isnan(found["vx_error"])
    assert swept.attrs["accuracy"] == options.get("accuracy", 0.01)
    assert vc.read_sweep(store).identical(swept)
    assert vc.sweep(rolling(grid="auto"), over, store=store, **options).identical(swept)
    with pytest.raises(vc.OutputError, match=r"holds another sweep \(accuracy"):
        vc.sweep(rolling(grid="auto"), over, store=store, accuracy=0.05)


def test_standing():
    assert str(vc.Standing(3, 10, 0)) == "3 of 10 scenes"
    assert str(vc.Standing(3, 10, 1, 3725.0)) == "3 of 10 scenes, 1 not solved, 1:02:05 left"
