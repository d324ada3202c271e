"""Creep-force curves: formulas and exact methods in one dataset, its picture, the command, refusals."""

import json

import numpy as np
import pytest
import xarray as xr

import varcontact as vc
from tests.command import run, scene_file

VX = np.linspace(0.0, 0.2, 5)


def test_each_row_is_its_methods(rolling):
    """A theory's row is `creep_forces`, an exact method's is `scan`; what is not given is the scene's."""
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
    np.testing.assert_allclose(curve.Fy.sel(theory="newton"), [sol.force[1] for sol in solved], atol=1e-9)
    assert np.isnan(curve.Mz.sel(theory="polach")).all()


def test_no_negative_zeros(rolling):
    """Nothing is printed as -0 where there is no creepage."""
    curve = vc.creep_curve(rolling(motion=vc.Steady()), ["linear", "table", "newton"], vx=[0.0, 0.1])
    at_rest = np.array([curve.Fx[:, 0], curve.Fy[:, 0], curve.Mz[:, 0]])
    assert not at_rest.any()
    assert not np.signbit(at_rest).any()


def test_unlike_bodies_by_exact_methods_only(rolling):
    scene = rolling(bodies=vc.Bodies(G=(2.0, 0.7), nu=(0.25, 0.4)))
    curve = vc.creep_curve(scene, ["active-set"], vx=[0.0, 0.05])
    assert curve.Fx[0, 1] < curve.Fx[0, 0]
    with pytest.raises(vc.SceneError, match="quasi-identical"):
        vc.creep_curve(scene, ["active-set", "fastrip"], vx=[0.0, 0.05])


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


def test_the_command(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(scene_file("", axes=(1.2, 0.9), cells=10))
    out, picture = tmp_path / "curve.nc", tmp_path / "curve.png"
    command = ["curve", str(path), "--vx", "0:0.2:3", "--methods", "newton,polach", "--out", str(out), "--plot"]
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
        ({"vx": 0.1}, "give a range"),
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
    with pytest.raises(vc.SceneError, match=words):
        vc.creep_curve(rolling(motion=vc.Steady()), **arguments)
    with pytest.raises(vc.SceneError, match="no prescribed force"):
        vc.creep_curve(rolling(motion=vc.Steady(Fx=-0.1)), vx=VX)
