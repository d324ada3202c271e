"""Studies of convergence against closed forms, and what happens when they are stopped, resumed or
ill-posed.
"""

import dataclasses
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

import varcontact as vc
from tests.command import run
from tests.scenes import carters_cylinders, make_scene, refused
from varcontact.reference import cattaneo_mindlin
from varcontact.study import converge as module
from varcontact.study.extrapolate import extrapolate

SPHERES = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Paraboloids(Rx=1.0, Ry=0.5), normal_force=1e-3
)

SCENE_FILE = """
normal_force = 1e-3
bodies = {G = 1.0, nu = 0.3}
surface = {kind = "paraboloids", Rx = 1.0, Ry = 0.5}
"""


def shift(part, nu=0.0):
    """Cattaneo's shift by so much of the limit of friction; nu = 0: the closed form is exact."""
    return make_scene(
        vc.Paraboloids(Rx=1.0, Ry=1.0),
        1e-3,
        vc.Shift(Fx=-part * 0.3e-3),
        bodies=vc.Bodies(G=1.0, nu=nu),
    )


@pytest.mark.long
@pytest.mark.parametrize("method", ["norm", "clarabel"])
def test_normal_problem(method):
    """Order 3/2 to 2 of the approach, and on 16 elements across an error below 0.1 %."""
    cells = [6, 8, 10, 12, 16] if method == "clarabel" else [6, 8, 12, 16, 20, 24]
    row, exact = vc.converge(SPHERES, cells, method).limit("approach"), SPHERES.hertz.approach
    assert 1.3 < row["order"] < 2.3
    assert abs(row["value"] - exact) < row["error"] < 1.5e-3 * exact
    assert abs(row["finest"] - exact) < 1e-3 * exact


@pytest.mark.long
def test_carter():
    """Order 1 of the force, and on 64 elements across an error below 1 %."""
    exact, scene = carters_cylinders(0.6)
    row = vc.converge(scene, [8, 16, 24, 32, 48, 64], offsets=6).limit("Fx")
    assert row["order_low"] < 1 < row["order_high"]
    assert 0.8 < row["order"] < 1.3
    assert abs(row["value"] - exact.force) < row["error"] < 5e-3 * abs(exact.force)
    assert abs(row["finest"] - exact.force) < 1e-2 * abs(exact.force)


@pytest.mark.long
def test_closed_forms_are_within_the_error_bars():
    """In 11 of 12 random cases at least: Hertz's approach or force, Cattaneo's shift, Carter's
    force.
    """
    rng, inside, ratios = np.random.default_rng(6), [], []
    for case in range(12):
        cells = np.sort(rng.choice(np.arange(6, 17), size=4, replace=False))
        part = rng.uniform(0.5, 0.9)
        if case % 4 == 0:
            scene = dataclasses.replace(
                SPHERES, surface=vc.Paraboloids(Rx=1.0, Ry=rng.uniform(0.1, 1.0))
            )
            quantity, exact = "approach", scene.hertz.approach
        elif case % 4 == 1:
            scene = dataclasses.replace(
                SPHERES, normal_force=None, approach=rng.uniform(0.001, 0.01)
            )
            quantity, exact = "normal_force", scene.hertz.force
        elif case % 4 == 2:
            scene, quantity = shift(part), "vx"
            exact = cattaneo_mindlin(scene.hertz, scene.bodies, 0.3, scene.motion.Fx).shift
        else:
            closed, scene = carters_cylinders(part)
            quantity, exact, cells = "Fx", closed.force, 3 * cells
        method = "tang" if quantity == "vx" else "tang-safeguarded"
        row = vc.converge(scene, cells, method).limit(quantity)
        inside.append(abs(row["value"] - exact) <= row["error"])
        ratios.append(row["error"] / abs(exact))
    assert sum(inside) >= 11
    assert np.max(ratios) < 0.03, "bars wide enough for anything would hold everything"


def test_grids_and_offsets(rolling):
    scene = rolling()
    box = module.contact_of(scene)
    for cells in (5, 8, 13):
        for i in range(5):
            grid = module.lattice(scene, box, cells, module.offset(cells, i))
            dx, dy = grid.sides
            assert (dx, dy) == pytest.approx((2.4 / cells, 1.8 / cells))
            left, right, bottom, top = grid.box
            assert left <= box[0] - dx + 1e-12 and right >= box[1] + dx - 1e-12
            assert bottom <= box[2] - dy + 1e-12 and top >= box[3] + dy - 1e-12
    plain = vc.converge(scene, [6, 8], offsets=1).runs
    direct = vc.solve(rolling(grid=vc.Grid(nx=8, ny=8)), tangential="tang-safeguarded")
    assert plain["Fx"].iloc[-1] == pytest.approx(direct.force[0], rel=1e-12)


@pytest.mark.long
def test_staircase_has_mean_zero(rolling):
    """Over all positions of the lattice the elements whose centres an ellipse holds have its area
    and moments.
    """
    scene, box, steps = rolling(), (-1.2, 1.2, -0.9, 0.9), np.arange(40) / 40
    places = [(u, v) for u in steps for v in steps if (u, v) != (0, 0)]
    grids = [module.lattice(scene, box, 6, place) for place in places]
    found = [module._staircase(dataclasses.replace(scene, grid=grid)) for grid in grids]
    table = pd.DataFrame(found)
    assert (table.mean().abs() < 0.02 * table.std()).all()


@pytest.mark.long
def test_sampled_distance_converges_to_the_paraboloids(rolling):
    x, y = np.linspace(-0.3, 0.3, 201), np.linspace(-0.25, 0.25, 201)
    surface = vc.SampledDistance(x[None, :] ** 2 / 2 + y[:, None] ** 2, x=x, y=y)
    row = vc.converge(dataclasses.replace(SPHERES, surface=surface), [8, 10, 12, 16]).limit(
        "approach"
    )
    assert row["value"] == pytest.approx(SPHERES.hertz.approach, rel=2e-3)


def test_two_grids_have_a_table_and_no_order(rolling):
    study = vc.converge(rolling(), [6, 8])
    assert len(study.grids) == 2 and study.grids["Fx"].notna().all()
    assert study.limits["order"].isna().all()
    assert "at least three are needed" in study.report()
    refused(lambda: study.limit("Fz"), match="quantity")


def test_a_shift_has_limits_by_the_names_of_its_scene(rolling):
    study = vc.converge(rolling(motion=vc.Shift(Fx=-0.01)), [6, 8])
    assert study.limit("ux")["finest"] == study.limit("vx")["finest"] != 0
    refused(lambda: study.limit("u"), match=r"choose one of .*Fx, .*ux, .*with a method")
    steady = vc.converge(rolling(), [6, 8])
    refused(lambda: steady.limit("ux"), match="ux")


@pytest.mark.long
def test_a_method_that_cannot_is_recorded_and_the_rest_go_on(rolling):
    study = vc.converge(rolling(), [4, 5, 6, 7], ["osqp", "tang-safeguarded", "linear"])
    outcomes = study.runs.groupby("method")["outcome"].agg(set)
    assert outcomes["osqp"] == {"refused"} and outcomes["tang-safeguarded"] == {"solved"}
    assert "osqp|clarabel" in study.report()
    assert np.isfinite(study.limit("Fx", "tang-safeguarded")["value"])
    axes = [ax for ax in study.plot().axes if ax.axison]
    assert {"Fx", "Fy", "Mz"} <= {ax.get_title() for ax in axes}
    assert all(ax.get_xscale() == ax.get_yscale() == "log" for ax in axes)
    failed = json.loads(study.to_json())["failed"]
    assert {row["method"] for row in failed} == {"osqp"} and len(failed) == 16


@pytest.mark.long
def test_one_grid_that_fails_is_left_out(rolling):
    """A given step is too short for the long elements of the coarsest grid: refused there, the
    others count.
    """
    scene = rolling(surface=vc.Ellipse(a=5.0, b=1.0), motion=vc.Steady(vx=0.04, dq=0.6))
    study = vc.converge(scene, [4, 8, 9, 10], "clarabel/gap", offsets=2, tol=1e-5)
    outcomes = study.runs.groupby("cells")["outcome"].agg(set).to_dict()
    assert outcomes == {4: {"refused"}, 8: {"solved"}, 9: {"solved"}, 10: {"solved"}}
    assert study.runs["reason"][0].startswith("formulation")
    assert study.grids["answers"].tolist() == [0, 2, 2, 2]
    assert np.isfinite(study.limit("Fx")["error"])
    assert "4 (0 of 2)" in study.report()


@pytest.mark.long
def test_resumed_where_it_was_stopped(rolling, tmp_path):
    store, calls = tmp_path / "study.csv", []

    def stop_at_third(message):
        calls.append(message)
        if len(calls) == 3:
            raise KeyboardInterrupt

    with pytest.raises(vc.Interrupted) as stopped:
        vc.converge(rolling(), [6, 8, 10], offsets=2, store=store, progress=stop_at_third)
    assert len(stopped.value.partial.runs) == 2
    assert len(pd.read_csv(store)) == 2
    calls[:] = [""] * 3
    study = vc.converge(rolling(), [6, 8, 10], offsets=2, store=store, progress=calls.append)
    assert len(calls) == 3 + 4
    whole = vc.converge(rolling(), [6, 8, 10], offsets=2)
    assert study.limit("Fx")["value"] == pytest.approx(whole.limit("Fx")["value"], rel=1e-10)
    more = vc.converge(rolling(), [6, 8, 10, 12], offsets=3, store=store, progress=calls.append)
    assert len(calls) == 7 + 3 + 3 and len(more.runs) == 12
    assert [path.name for path in tmp_path.iterdir()] == ["study.csv"]


def test_store_of_another_study_is_refused(rolling, tmp_path):
    store = tmp_path / "study.csv"
    vc.converge(rolling(), [6, 8], offsets=1, store=store)
    before = store.read_bytes()
    for friction, tol in ((0.31, 1e-6), (0.3, 1e-7)):
        with pytest.raises(vc.SceneError, match="holds a study of another scene or tol"):
            vc.converge(rolling(friction=friction), [6, 8], offsets=1, tol=tol, store=store)
    assert store.read_bytes() == before
    (tmp_path / "other.csv").write_text("a,b\n1,2\n")
    with pytest.raises(vc.SceneError, match="study of convergence"):
        vc.converge(rolling(), [6, 8], store=tmp_path / "other.csv")


@pytest.mark.long
def test_a_full_disk(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE_FILE)
    code = (
        "import resource, sys, varcontact as vc; sys.dont_write_bytecode = True\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1500, 1500))\n"
        "vc.converge(vc.read_scene('scene.toml')[0], [6, 8, 10], store='study.csv')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert "OutputError: store = 'study.csv': cannot be written" in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"scene.toml", "study.csv"}
    kept = pd.read_csv(tmp_path / "study.csv")
    assert 0 < len(kept) < 12 and kept["approach"].notna().all()


@pytest.mark.long
def test_the_command_is_stopped_and_resumed(tmp_path, pictures):
    """The tables, JSON and picture; an interrupt at a terminal prints what there is, and says where
    it is kept.
    """
    (tmp_path / "scene.toml").write_text(SCENE_FILE)
    code = (
        "import signal, varcontact.cli as cli\n"
        # a shell's background jobs begin deaf to it
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from varcontact.study import converge\n"
        "solve, left = converge.attempted, [4]\n"
        "def counted(*arguments):\n"
        "    left[0] -= 1\n"
        "    if left[0] == 0: signal.raise_signal(signal.SIGINT)\n"
        "    return solve(*arguments)\n"
        "converge.attempted = counted\n"
        "import sys; sys.argv[1:] = ['converge', 'scene.toml', '--cells', '6,8,10', '--store', 'study.csv']\n"
        "cli.main()\n"
    )
    stopped = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert stopped.returncode == 130, stopped.stderr
    assert (
        "after 3 of 12 solves; finished solves are kept in study.csv, and the same command resumes"
        in stopped.stderr
    )
    assert "approach" in stopped.stdout
    rest = ("--store", "study.csv", "--json", "--plot", "order.png")
    done = run("converge", "scene.toml", "--cells", "6,8,10", *rest, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    tables = json.loads(done.stdout)
    assert [row["answers"] for row in tables["grids"]] == [4, 4, 4] and tables["failed"] == []
    assert (tmp_path / "order.png").read_bytes()[:4] == b"\x89PNG"
    assert {"approach"} <= {ax.get_title() for ax in pictures[0].axes}
    refused = run("converge", "scene.toml", "--cells", "8,6", folder=tmp_path)
    assert refused.returncode == 2 and "each finer than the one before" in refused.stderr


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"cells": [8, 8, 12]}, "cells"),
        ({"cells": []}, "cells"),
        ({"cells": "8,12"}, "cells"),
        ({"cells": 8}, "cells"),
        ({"cells": [8, 12.5]}, "cells"),
        ({"method": "clarable"}, "methods"),
        ({"method": []}, "method"),
        ({"offsets": 0}, "offsets"),
        ({"tol": 0}, "tol"),
        ({"store": 3}, "store"),
        ({"progress": 3}, "progress"),
        ({"scene": None}, "scene"),
    ],
)
def test_bad_arguments_are_refused_by_name(rolling, changes, field):
    arguments = {"scene": rolling(), "cells": [8, 12], **changes}
    with pytest.raises(vc.SceneError) as refused:
        vc.converge(**arguments)
    assert refused.value.field.startswith(field)


def test_scenes_tied_to_one_grid_are_refused(rolling):
    grid = vc.Grid(nx=4, ny=4, dx=1.0, dy=1.0, x0=-2.0, y0=-2.0)
    with pytest.raises(vc.SceneError, match="friction"):
        vc.converge(rolling(grid=grid, friction=np.full((4, 4), 0.3)), [8, 12])
    with pytest.raises(vc.SceneError, match=r"surface\.x"):
        vc.converge(
            dataclasses.replace(SPHERES, grid=grid, surface=vc.SampledDistance(np.eye(4))), [8, 12]
        )


def test_by_an_executor_it_is_the_same_study():
    here = vc.converge(SPHERES, [6, 8, 10], offsets=2)
    told = []
    with ThreadPoolExecutor(2) as pool:
        there = vc.converge(SPHERES, [6, 8, 10], offsets=2, executor=pool, progress=told.append)
    assert len(told) == 6 and all("6:" in words for words in told)
    # threads share a process, whose memory is not traced
    assert here.runs["memory"].notna().sum() == 3 and there.runs["memory"].isna().all()
    assert there.limit("approach")["value"] == pytest.approx(
        here.limit("approach")["value"], rel=1e-12
    )
    with pytest.raises(vc.SceneError, match="workers = 0 is not allowed"):
        vc.converge(SPHERES, [6, 8, 10], workers=0)


# -------------------- Order and limit from values whose law is known


CELLS = np.repeat([8.0, 12.0, 16.0, 24.0, 32.0], 4)


@given(
    st.floats(0.7, 2.4),
    st.floats(-5, 5),
    st.sampled_from([-3.0, -0.2, 0.5, 4.0]),
    st.floats(1e-6, 1e6),
)
def test_a_power_is_found(order, limit, coefficient, unit):
    """Whatever the unit of the values and of h."""
    h = 1 / np.unique(CELLS)
    found = extrapolate(h * 7, unit * (limit + coefficient * h**order))
    assert found.order == pytest.approx(order, abs=0.013)
    assert abs(found.value / unit - limit) < 1e-3 * abs(coefficient)


@pytest.mark.parametrize("order", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("steps", [False, True])
def test_error_bars_hold_what_they_promise(order, steps):
    """Of 200 noisy studies about 95 % hold the limit (190; fewer than 182 comes once in 500), order
    and bar alike.
    """
    rng = np.random.default_rng(1)
    h, holds, orders, errors = 1 / CELLS, 0, 0, []
    for _ in range(200):
        staircase = rng.normal(size=(h.size, 2)) * h[:, None] ** 1.5
        noise = 0.2 * rng.normal(size=h.size) * h**1.5 + (staircase @ [3.0, -1.0] if steps else 0)
        found = extrapolate(h, 1 + h**order + noise, staircase if steps else None)
        holds += abs(found.value - 1) <= found.error
        orders += found.order_low <= order <= found.order_high
        errors.append(found.error)
    assert holds >= 182
    assert orders >= 182
    assert np.median(errors) < 0.04, "smaller than the error of the finest grid by h^1"


@pytest.mark.parametrize(
    ("cells", "values", "words"),
    [
        ([8, 8, 16], [1.0, 1.1, 1.2], "no order: 2 grids"),
        ([8, 12, 16], [1.2, 1.1, 1.05], "no error"),
        ([8, 12, 16, 24], [2.0, 2.0, 2.0, 2.0], "the same on all grids"),
        ([8, 12, 16, 24], [1.0, 1.1, 0.9, 1.05], "hides the order"),
    ],
)
def test_what_cannot_be_said_is_not(cells, values, words):
    found = extrapolate(1 / np.array(cells, dtype=float), np.array(values))
    assert words in found.reason
    if words.startswith("no order"):
        assert np.isnan([found.value, found.order]).all()
    if words == "no error":
        assert np.isinf(found.error)


@pytest.mark.long
def test_solver_error_stands_beside(rolling):
    study = vc.converge(rolling(), [6, 8, 10])
    row = study.limit("Fx")
    assert row["solver_bound"] == study.grids["Fx_bound"].iloc[-1]
    assert 0 < row["solver_bound"] < 1e-4 * row["finest_error"]
    theory = vc.converge(rolling(), [6, 8, 10], "fastsim").limit("Fx")
    assert theory["solver_bound"] > 10 * theory["error"], "FASTSIM converges, to something else"
