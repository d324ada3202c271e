"""Solvers of users: called by name or as functions everywhere, and judged; never believed."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.own_solvers import (
    BAD,
    NONSENSE,
    active_sets,
    admm,
    endless,
    pressures,
    raising,
    returning,
)
from tests.scenes import refused
from varcontact.errors import NotConverged, SceneError, SolverUnavailable
from varcontact.solvers.interface import Settings
from varcontact.solvers.registry import SOLVERS, normal_methods, solver
from varcontact.solving import own_solvers
from varcontact.solving.methods import METHODS

ROOT = Path(__file__).parents[2]
GRID = vc.Grid(nx=8, ny=8)
SHIFT = vc.Shift(ux=0.1, uy=-0.06)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=0.28)


@pytest.fixture(autouse=True)
def own():
    """What a test registers is gone after it."""
    before = dict(SOLVERS)
    for key in [key for key, spec in SOLVERS.items() if spec.own]:  # of other tests
        del SOLVERS[key]
    yield
    SOLVERS.clear()
    SOLVERS.update(before)


@pytest.fixture
def small(rolling):
    return lambda **changes: rolling(**{"grid": GRID, **changes})


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"motion": SHIFT},
        {"motion": vc.Steady(Fx=-0.1, vy=0.01)},
        {"bodies": UNLIKE},
        {"friction": vc.StaticKinetic(0.3, 0.2)},
        {"motion": vc.Transient(steps=3, vx=0.01)},
        {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=20), "motion": vc.Steady(vx=0.02)},
        {"motion": None, "friction": None},
    ],
)
def test_an_own_solver_takes_every_scene(small, changes):
    """The package's own active sets as a user's function: the same answer, by its name."""
    scene = small(**changes)
    sol = vc.solve(scene, normal=active_sets, tangential=active_sets)
    exact = vc.solve(scene, normal="norm")
    if isinstance(sol, vc.History):
        sol, exact = sol[-1], exact[-1]
    np.testing.assert_allclose(sol.traction, exact.traction, atol=1e-8)
    np.testing.assert_allclose(sol.pressure, exact.pressure, atol=1e-8)
    assert sol.converged
    assert sol.solved_by["normal"] == "active_sets"
    assert sol.calls["normal"]["active_sets"].count >= 1


def test_without_an_approach_it_is_the_mean(small):
    scene = small(motion=None, friction=None)
    sol = vc.solve(scene, normal=pressures)
    assert sol.approach == pytest.approx(vc.solve(scene, normal="norm").approach, rel=1e-10)


@pytest.mark.parametrize("motion", [SHIFT, vc.Steady(vx=0.04, spin=0.05)])
def test_studies_take_registered_names(small, motion):
    vc.register_solver("admm", admm)
    scene = small(motion=motion)
    table = vc.compare(scene, ["admm", "tang"])
    assert table["outcome"].tolist() == ["solved"] * 2
    assert table["force_distance"].max() < 1e-5
    assert vc.compare(scene, ["norm|admm"])["outcome"].tolist() == ["solved"]
    assert vc.compare(scene, [vc.Methods(tangential=admm)])["outcome"].tolist() == ["solved"]
    curve = vc.scan(scene, [(0.01, 0.0, 0.0), (0.05, 0.0, 0.0)], tangential="admm")
    exact = vc.scan(scene, [(0.01, 0.0, 0.0), (0.05, 0.0, 0.0)])
    for sol, other in zip(curve, exact, strict=True):
        np.testing.assert_allclose(sol.force, other.force, atol=1e-7)
        assert sol.solved_by["tangential"] == "admm"
    name = "line, creepage 0.3"
    study = vc.tradeoff({name: vc.continuum_values()[name]}, ["admm"], cells=[8])
    assert study.runs["outcome"].tolist() == ["answered"]


def test_other_processes_are_given_own_solvers(small):
    vc.register_solver("admm", admm)
    vc.register_solver(
        "local", lambda problem, settings, start: None
    )  # goes nowhere, and hurts nobody
    triples = [(0.01 * k, 0.0, 0.0) for k in range(1, 10)]
    by_name = vc.scan(small(), triples, tangential="admm", workers=2)
    by_function = vc.scan(small(), triples, tangential=admm, workers=2)
    exact = vc.scan(small(), triples)
    for sol, again, other in zip(by_name, by_function, exact, strict=True):
        np.testing.assert_allclose(sol.force, other.force, atol=1e-7)
        np.testing.assert_array_equal(sol.traction, again.traction)


def test_files_load_and_certify_where_the_solver_is_not_registered(small, tmp_path):
    for motion in (SHIFT, vc.Transient(steps=2, vx=0.01)):
        vc.register_solver("mine", active_sets)
        path = tmp_path / f"{type(motion).__name__}.nc"
        vc.solve(small(motion=motion), tangential="mine").save(path)
        del SOLVERS["tangential", "mine"]
        found = vc.load(path)
        sol = found[-1] if isinstance(found, vc.History) else found
        assert sol.note == ""
        assert sol.converged
        assert sol.solved_by["tangential"] == sol.plan.tangential == "mine"
        assert "mine" in sol.report()


def test_entry_points_and_scene_files(tmp_path, monkeypatch):
    """A package's solver by its name in a scene file; one that fails is unavailable."""
    (tmp_path / "plugin_of_mine.py").write_text(
        "import varcontact as vc\n"
        "from tests.own_solvers import active_sets\n"
        "def register():\n    vc.register_solver('plugged', active_sets)\n"
        "def broken():\n    raise ImportError('no library')\n"
    )
    info = tmp_path / "plugin_of_mine-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: plugin-of-mine\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[varcontact.solvers]\nplugged = plugin_of_mine:register\nbroken = plugin_of_mine:broken\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    own_solvers._entry_points.cache_clear()
    path = tmp_path / "scene.toml"
    path.write_text(
        "normal_force = 1.0\nfriction = 0.3\nbodies = {G = 1.0, nu = 0.28}\n"
        'surface = {kind = "ellipse", a = 1.0, b = 1.0}\nmotion = {kind = "steady", vx = 0.05}\n'
        'grid = {nx = 6, ny = 6}\n[solve]\ntangential = "plugged"\n'
    )
    scene, options = vc.read_scene(path)
    try:
        assert vc.solve(scene, **options).solved_by["tangential"] == "plugged"
        assert vc.compare(scene, ["plugged"])["outcome"].tolist() == ["solved"]
        with pytest.raises(SolverUnavailable, match="no library"):
            vc.solve(scene, tangential="broken")
    finally:
        own_solvers._entry_points.cache_clear()


@pytest.mark.parametrize("kind", ["normal", "tangential"])
@pytest.mark.parametrize("name", BAD)
def test_failures_are_told_of_that_solver(small, kind, name):
    solve, words = BAD[name]
    vc.register_solver("bad", solve, kind)
    scene = small(motion=SHIFT)
    before = vc.solve(scene, normal="norm")
    with pytest.raises(NotConverged) as failure:
        vc.solve(scene, **{kind: "bad"})
    assert failure.value.solution is None
    assert "bad gave no" in str(failure.value)
    assert words in str(failure.value)
    np.testing.assert_array_equal(vc.solve(scene, normal="norm").traction, before.traction)
    table = vc.compare(scene, ["bad|tang" if kind == "normal" else "norm|bad", "norm|tang"])
    assert table["outcome"].tolist() == ["not converged", "solved"]
    assert "bad gave no" in table["reason"][0]


@pytest.mark.parametrize("kind", ["normal", "tangential"])
@pytest.mark.parametrize("name", NONSENSE)
@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), UNLIKE])
def test_nonsense_is_no_answer(small, kind, name, bodies):
    scene = small(motion=SHIFT, bodies=bodies)
    before = vc.solve(scene, normal="norm")
    with pytest.raises(NotConverged) as failure:
        vc.solve(scene, **{"normal": "norm", kind: NONSENSE[name]})
    if kind == "tangential":
        best = failure.value.solution
        assert not best.converged
        assert best.certificate.residual > 1e-3
    else:
        assert "pressure" in str(failure.value)
    np.testing.assert_array_equal(vc.solve(scene, normal="norm").traction, before.traction)


def test_forces_need_the_rigid_shift(small):
    with pytest.raises(NotConverged, match="rigid shift"):
        vc.solve(small(motion=vc.Shift(Fx=-0.1)), tangential=returning(np.zeros))


@pytest.mark.parametrize("kind", ["normal", "tangential"])
def test_what_never_ends_is_left_alone(small, kind):
    vc.register_solver("endless", endless, kind, time_limit=0.2)
    with pytest.raises(NotConverged, match=r"endless gave no .* it did not end within its time"):
        vc.solve(small(), **{kind: "endless"})
    vc.register_solver("endless", endless, kind)  # replaced; now the budget of the solve ends it
    settings = Settings(deadline=time.perf_counter() + 0.2)
    problem = vc.program(small(motion=None, friction=None), "normal")._contact.problem
    raw = solver(kind, "endless").solve(problem, settings, None)
    assert not raw.solved
    assert "within its time" in raw.status


def test_time_budget_ends_it(small):
    with pytest.raises(NotConverged, match="endless gave no tractions"):
        vc.solve(small(grid="auto"), tangential=endless, time_budget=0.1)


SWALLOWING = """
import os, signal, threading, time
signal.signal(signal.SIGINT, signal.default_int_handler)
import varcontact as vc
def deaf(problem, settings, start):
    while True:
        try:
            time.sleep(0.01)
        except BaseException:
            pass
scene = vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    friction=0.3, motion=vc.Shift(ux=0.1), grid=vc.Grid(nx=6, ny=6))
threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()
try:
    vc.solve(scene, tangential=deaf)
except KeyboardInterrupt:
    print("interrupted", flush=True)
    os._exit(0)
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to a process itself")
def test_ctrl_c_does_not_reach_it():
    ended = subprocess.run(
        [sys.executable, "-c", SWALLOWING], capture_output=True, text=True, timeout=60,
        env=os.environ | {"PYTHONPATH": str(ROOT)}, check=False,
    )  # fmt: skip
    assert ended.stdout == "interrupted\n", ended.stderr


@pytest.mark.parametrize("name", [*METHODS, *normal_methods()])
def test_names_that_mean_something_else_are_taken(name):
    with pytest.raises(SceneError, match="name"):
        vc.register_solver(name, raising(ValueError("never called")), "normal")


def test_functions_of_one_name(small):
    """Two functions of a name are two solvers, one function always the same."""
    first = raising(ValueError("first"))
    second = raising(ValueError("second"))
    for function, words in ((first, "first"), (second, "second"), (first, "first")):
        with pytest.raises(NotConverged, match=words):
            vc.solve(small(), tangential=function)
    names = {spec.name for spec in SOLVERS.values() if spec.own}
    assert names == {"solve", "solve-2"}
    with pytest.raises(NotConverged, match="lambda gave no"):
        vc.solve(small(), tangential=lambda problem, settings, start: None)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        (("norm", admm, "normal"), "name"),
        (("tang", admm), "name"),
        (("fastsim", admm), "name"),
        (("auto", admm), "name"),
        (("a|b", admm), "name"),
        (("a+polish", admm), "name"),
        (("", admm), "name"),
        ((3, admm), "name"),
        (("mine", "admm"), "solve"),
        (("mine", dict), "solve"),
        (("mine", admm, "both"), "kind"),
    ],
)
def test_refused(arguments, field):
    refused(lambda: vc.register_solver(*arguments), field)
    refused(lambda: vc.register_solver("mine", admm, time_limit=0.0), "time_limit")


def test_functions_where_a_name_is_needed(small):
    refused(lambda: vc.compare(small(), [admm]), "methods", match="register_solver")
    refused(lambda: vc.solve(small(), tangential=dict), "tangential")
    refused(lambda: vc.solve(small(), tangential=3), "tangential")
