"""Scans over creepages: nothing but single solves, quicker."""

import dataclasses
import gc
import json
import tracemalloc
from concurrent.futures import ThreadPoolExecutor
from itertools import islice

import numpy as np
import pytest
import xarray as xr

import varcontact as vc
from tests.command import run, scene_file
from tests.scenes import refused
from varcontact.solvers.newton.kernel import Kernel
from varcontact.study.scan import scanned

GRID = vc.Grid(nx=8, ny=8)
CREEPAGES = [
    (0.01, 0.0, 0.0),
    (0.05, -0.02, 0.03),
    (0.2, 0.1, 0.0),
    (0.0, 0.0, 0.0),
    (-0.03, 0.01, 0.1),
]
METHODS = [
    ({"tangential": "clarabel"}, 1e-11),
    ({"tangential": "scs", "polish": False, "tol": 1e-4}, 1e-4),
    ({"tangential": "tang-safeguarded"}, 1e-11),
    ({"tangential": "newton"}, 1e-8),
]


@pytest.mark.parametrize("kind", ["steady", "shift"])
@pytest.mark.parametrize(("arguments", "tol"), METHODS)
def test_a_scan_is_its_single_solves(rolling, kind, arguments, tol):
    motion = vc.Steady() if kind == "steady" else vc.Shift()
    scene = rolling(motion=motion, grid=GRID)
    names = ("vx", "vy", "spin") if kind == "steady" else ("ux", "uy", "rotation")
    scanned = vc.scan(scene, CREEPAGES, **arguments)
    assert len(scanned) == len(CREEPAGES)
    for triple, sol in zip(CREEPAGES, scanned, strict=True):
        moved = dataclasses.replace(motion, **dict(zip(names, triple, strict=True)))
        single = vc.solve(dataclasses.replace(scene, motion=moved), **arguments)
        assert sol.creepage == triple
        assert sol.scene.motion == moved
        assert sol.converged
        # Both are within the tolerance asked for of the same solution; polished, both at rounding.
        np.testing.assert_allclose(
            sol.traction, single.traction, atol=10 * tol * sol.traction_bound.max()
        )
        np.testing.assert_array_equal(sol.pressure, single.pressure)


@pytest.mark.long
@pytest.mark.parametrize("tangential", ["clarabel", "tang-safeguarded", "newton"])
def test_unlike_bodies(rolling, tangential, check_kkt):
    scene = rolling(bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3)), grid=GRID)
    triples = CREEPAGES[:3]
    for triple, sol in zip(triples, vc.scan(scene, triples, tangential=tangential), strict=True):
        motion = vc.Steady(vx=triple[0], vy=triple[1], spin=triple[2])
        single = vc.solve(dataclasses.replace(scene, motion=motion), tangential=tangential)
        check_kkt(sol, 1e-8)
        np.testing.assert_allclose(sol.traction, single.traction, atol=1e-8)
        np.testing.assert_allclose(sol.pressure, single.pressure, atol=1e-8)


def test_each_begins_from_the_one_before(rolling):
    scene = rolling(grid=vc.Grid(nx=14, ny=14))
    creepages = [(0.02, 0.0, 0.0), (0.02, 1e-7, 0.0), (-0.1, 0.1, 0.0), (-0.1, 0.1000001, 0.0)]
    scanned = vc.scan(scene, creepages, tangential="newton")
    first, again, other, next_ = (sol.iterations["tangential"] for sol in scanned)
    assert again < first / 2
    assert next_ <= other / 2


def test_a_scan_by_newton_makes_kernels_once(rolling, monkeypatch):
    made = []

    def counted(numbers, *period):
        made.append(numbers.shape)
        return Kernel(numbers, *period)

    monkeypatch.setattr("varcontact.solvers.newton.kernel.Kernel", counted)
    vc.scan(rolling(grid=vc.Grid(nx=25, ny=25)), CREEPAGES, tangential="newton")
    assert len(made) == 2  # of both levels


def test_a_scan_by_others_is_the_scan_here(rolling):
    scene, creepages = rolling(grid=GRID), [(0.01 * k, 0.02, 0.0) for k in range(11)]
    told = []
    with ThreadPoolExecutor(2) as pool:
        threads = vc.scan(scene, creepages, executor=pool, progress=told.append)
    processes = vc.scan(scene, creepages, workers=2)
    assert sorted(told) in (
        ["11 of 11 creepages", "8 of 11 creepages"],
        ["11 of 11 creepages", "3 of 11 creepages"],
    )
    for one, other, here in zip(threads, processes, vc.scan(scene, creepages), strict=True):
        np.testing.assert_array_equal(one.traction, other.traction)
        np.testing.assert_allclose(one.traction, here.traction, rtol=0, atol=1e-10)
        assert other.creepage == here.creepage
        assert other.report().splitlines()[0] == here.report().splitlines()[0]


def test_a_failure_elsewhere_is_that_failure(rolling):
    with (
        ThreadPoolExecutor(1) as pool,
        pytest.raises(vc.NotConverged, match="the residual is not below tol"),
    ):
        vc.scan(
            rolling(grid=GRID), CREEPAGES, tangential="scs", polish=False, tol=1e-15, executor=pool
        )


@pytest.mark.long
@pytest.mark.parametrize("options", [{}, {"accuracy": 0.03}])
def test_without_a_grid_each_has_an_error_bar_here_and_in_processes(rolling, options):
    scene = rolling(grid="auto")
    here, elsewhere = (
        vc.scan(scene, CREEPAGES, **options),
        vc.scan(scene, CREEPAGES, workers=2, **options),
    )
    for (vx, vy, spin), one, other in zip(CREEPAGES, here, elsewhere, strict=True):
        alone = vc.solve(
            dataclasses.replace(scene, motion=vc.Steady(vx=vx, vy=vy, spin=spin)), **options
        )
        assert one.force.tolist() == other.force.tolist() == alone.force.tolist()
        assert one.error_estimate.largest <= options.get("accuracy", 0.01)
    with pytest.raises(vc.SceneError, match="left out: it is chosen for the accuracy"):
        vc.scan(rolling(grid=GRID), CREEPAGES, accuracy=0.1, workers=2)


@pytest.mark.parametrize(
    ("motion", "creepages", "words"),
    [
        (
            vc.Steady(),
            [0.1, 0.0, 0.0],
            r"has shape \(3,\).*a row of vx, vy, spin.*\[\[vx, vy, spin\]\]",
        ),
        (
            vc.Shift(),
            [0.1, 0.0, 0.0],
            r"a row of ux, uy, rotation for each.*\[\[ux, uy, rotation\]\]",
        ),
        (
            vc.Steady(),
            [0.1, 0.2],
            r"has shape \(2,\); it must be .*a row of vx, vy, spin for each solution$",
        ),
        (vc.Steady(), [[0.1, 0.2]], r"creepages has shape \(1, 2\)"),
        (vc.Steady(), np.zeros((0, 3)), r"creepages has shape \(0, 3\)"),
        (vc.Steady(), 0.1, r"creepages has shape \(\)"),
        (vc.Steady(), [["a", "b", "c"]], "finite numbers"),
        (vc.Steady(), [(0.1, np.nan, 0.0)], r"creepages.* = nan"),
        (None, CREEPAGES, "a scan sets the creepages"),
        (vc.Steady(Fx=-0.1), CREEPAGES, "motion.*no prescribed force"),
        (vc.Shift(Fy=-0.1), CREEPAGES, "motion.*no prescribed force"),
    ],
)
def test_creepages_are_rows_of_three_of_a_motion_without_forces(rolling, motion, creepages, words):
    refused(lambda: vc.scan(rolling(grid=GRID, motion=motion), creepages), match=words)


def test_a_method_that_cannot_treat_one_of_them_is_refused_at_once(rolling):
    stages = []
    with pytest.raises(vc.SceneError, match="without spin"):
        vc.scan(
            rolling(grid=GRID), CREEPAGES, tangential="vermeulen-johnson", progress=stages.append
        )
    assert not stages
    with pytest.raises(vc.SceneError, match="progress = 3 is not allowed"):
        vc.scan(rolling(grid=GRID), CREEPAGES, progress=3)


@pytest.mark.parametrize("motion", [vc.Steady(), vc.Shift()])
def test_tang_as_printed_where_the_creepage_before_leads_nowhere(rolling, motion):
    """Its Newton steps may fail from areas that are far off, and succeed from stick everywhere."""
    random = np.random.default_rng(0)
    creepages = random.normal(size=(8, 3)) * [0.1, 0.1, 0.2]
    creepages[5] *= 1e3
    scene = rolling(motion=motion, grid=vc.Grid(nx=6, ny=6))
    exact = vc.scan(scene, creepages)
    for sol, other in zip(vc.scan(scene, creepages, tangential="tang"), exact, strict=True):
        np.testing.assert_allclose(sol.force, other.force, atol=1e-8)


@pytest.mark.long
def test_a_long_scan_takes_no_more_memory_than_a_short_one(rolling):
    creepages = np.random.default_rng(0).normal(size=(130, 3)) * 0.1

    def traced(numbers):
        for _ in islice(solutions, numbers):
            pass
        gc.collect()
        return tracemalloc.get_traced_memory()[0]

    solutions = scanned(rolling(grid=GRID), creepages, tangential="tang-safeguarded")
    size = next(solutions).traction.nbytes
    tracemalloc.start()
    try:
        short = traced(40)
        assert traced(80) - short < 20 * size
    finally:
        tracemalloc.stop()


# ----------------------------------------------------------------------------- Creep-force curves


VX = np.linspace(0.0, 0.2, 5)


def test_each_row_is_its_methods(rolling):
    scene = rolling(motion=vc.Steady(spin=0.05))
    curve = vc.creep_curve(scene, ["fastsim", "newton", "polach"], vx=VX, vy=-0.02)
    assert dict(curve.sizes) == {"theory": 3, "point": 5}
    assert curve.limit == pytest.approx(0.3)
    np.testing.assert_array_equal(curve.vy, -0.02)
    np.testing.assert_array_equal(curve.spin, 0.05)
    contact = {"a": 1.2, "b": 0.9, "bodies": scene.bodies, "normal_force": 1.0, "friction": 0.3}
    exact = vc.creep_forces("fastsim", **contact, vx=VX, vy=-0.02, spin=0.05)
    np.testing.assert_allclose(curve.Fx.sel(theory="fastsim"), exact.Fx, rtol=1e-12)
    np.testing.assert_allclose(curve.Mz.sel(theory="fastsim"), exact.Mz, rtol=1e-12)
    solved = vc.scan(scene, [(vx, -0.02, 0.05) for vx in VX], tangential="newton")
    np.testing.assert_allclose(
        curve.Fy.sel(theory="newton"), [sol.force[1] for sol in solved], atol=1e-9
    )
    assert np.isnan(curve.Mz.sel(theory="polach")).all()


def test_unlike_bodies_by_exact_methods_only(rolling):
    scene = rolling(bodies=vc.Bodies(G=(2.0, 0.7), nu=(0.25, 0.4)))
    curve = vc.creep_curve(scene, ["active-set"], vx=[0.0, 0.05])
    assert curve.Fx[0, 1] < curve.Fx[0, 0]
    with pytest.raises(vc.SceneError, match="quasi-identical"):
        vc.creep_curve(scene, ["active-set", "fastrip"], vx=[0.0, 0.05])


@pytest.mark.long
def test_picture(rolling):
    curve = vc.creep_curve(rolling(motion=vc.Steady()), ["fastsim", "fastrip"], vx=VX)
    (axes,) = vc.plot_curve(curve).axes
    labels = [line.get_label() for line in axes.get_lines() if not line.get_label().startswith("_")]
    assert labels == ["FASTSIM", "FaStrip"]
    assert axes.get_ylabel() == "$-F_x$ / friction limit"
    np.testing.assert_allclose(axes.get_lines()[0].get_ydata(), -curve.Fx[0] / 0.3)
    spun = vc.creep_curve(rolling(motion=vc.Steady()), ["fastsim"], spin=np.linspace(0.0, 0.002, 4))
    (axes,) = vc.plot_curve(spun, normalised=False).axes
    assert axes.get_xlabel() == "spin [$10^{-3}$]"
    with pytest.raises(vc.SceneError, match="not a dataset of creep_curve"):
        vc.plot_curve(xr.Dataset({"Fx": ("x", [1.0])}))


@pytest.mark.long
def test_the_command(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(scene_file("", axes=(1.2, 0.9), cells=10))
    out, picture = tmp_path / "curve.nc", tmp_path / "curve.png"
    command = [
        "curve",
        str(path),
        "--vx",
        "0:0.2:3",
        "--methods",
        "newton,polach",
        "--out",
        str(out),
        "--plot",
    ]
    done = run(*command, str(picture), "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = json.loads(done.stdout)
    assert [row["theory"] for row in rows] == ["newton"] * 3 + ["polach"] * 3
    assert rows[-1]["Mz"] is None
    with xr.open_dataset(out) as stored:
        np.testing.assert_allclose(stored.Fx.values.ravel(), [row["Fx"] for row in rows])
    assert picture.stat().st_size > 5_000
    refused = run("curve", str(path), "--vx", "0:0.2", folder=tmp_path)
    assert refused.returncode == 2
    assert "--vx = '0:0.2' is not allowed: must be FROM:TO:N" in refused.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({}, "give a range .* given: none"),
        ({"vx": [[0.1, 0.2]]}, "give a range"),
        ({"vx": [0.0, 0.1], "vy": [0.0, 0.1, 0.2]}, r"given: vx \(2,\), vy \(3,\)"),
        ({"vx": [0.0, np.nan]}, r"vx\[1\] = nan"),
        ({"vx": VX, "methods": ["fastsim", "fastsim"]}, "none of them twice"),
        ({"vx": VX, "methods": "fastsym"}, "fastsym"),
        ({"vx": VX, "methods": None}, "at least one name"),
        ({"vx": VX, "methods": {"polach": 0.3}}, "methods.*a dict of options"),
        ({"vx": VX, "spin": 0.1, "methods": "vermeulen-johnson"}, "without spin|must be 0"),
    ],
)
def test_bad_input(rolling, arguments, words):
    refused(lambda: vc.creep_curve(rolling(motion=vc.Steady()), **arguments), match=words)
    with pytest.raises(vc.SceneError, match="no prescribed force"):
        vc.creep_curve(rolling(motion=vc.Steady(Fx=-0.1)), vx=VX)
