"""Derivatives of creep curves and of many scenes, and fits by these."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.study import fit as fitting

VX = np.linspace(1e-3, 6e-3, 4)
WHEEL = vc.Scene(
    bodies=vc.Bodies(G=82e3, nu=0.28),
    surface=vc.Paraboloids(Rx=460.0, Ry=300.0),
    normal_force=80e3,
    friction=0.3,
    motion=vc.Steady(spin=1e-4),
    grid=vc.Grid(nx=8, ny=8),
    units=vc.MM_N,
)
LAYERED = replace(WHEEL, third_body=vc.ThirdBody(h=0.08, G=1e3))
INPUTS = ("vx", "third_body.h", "friction")


def test_a_creep_curve_has_the_gradients_of_its_points():
    curve = vc.creep_curve(LAYERED, ["newton"], vx=VX[:2], by=INPUTS)
    for k, vx in enumerate(VX[:2]):
        scene = replace(LAYERED, motion=replace(LAYERED.motion, vx=vx))
        found = vc.solve(scene, certify="none").gradient(["Fx", "Fy", "Mz"], INPUTS)
        for name in INPUTS:
            own = [float(curve[f"{output}_by_{name}"][0, k]) for output in ("Fx", "Fy", "Mz")]
            np.testing.assert_allclose(own, found[name], rtol=1e-4)
    assert curve["Fy_by_third_body.h"].units == "(N)/(mm)"
    assert curve["Mz_by_vx"].units == "N mm"


@pytest.mark.long
def test_many_scenes_have_their_gradients():
    """Unlike scenes with inputs in common, one under a prescribed force."""
    scenes = [
        replace(WHEEL, motion=vc.Steady(vx=1e-3)),
        replace(WHEEL, motion=vc.Steady(Fx=8e3), surface=vc.Paraboloids(400.0, 300.0)),
        replace(WHEEL, bodies=vc.Bodies(G=(82e3, 40e3), nu=0.28), grid=vc.Grid(nx=6, ny=6)),
    ]
    found = vc.solve_many(scenes, by=["normal_force", "surface.Ry"])
    for k, scene in enumerate(scenes):
        expected = vc.solve(scene).gradient(["Fx", "Fy", "Mz"], ["normal_force", "surface.Ry"])
        scale = float(abs(expected["normal_force"]).max())
        for row, output in enumerate(("Fx", "Fy", "Mz")):
            own = float(found[f"{output}_by_normal_force"][k])
            assert own == pytest.approx(float(expected["normal_force"][row]), abs=1e-6 * scale)
    assert float(found.Fx_by_normal_force[1]) == pytest.approx(0.0, abs=1e-9)  # prescribed
    assert (found.by == "solve").all()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: vc.creep_curve(WHEEL, ["fastsim"], vx=VX, by="vx"), "fastsim has none"),
        (lambda: vc.creep_curve(WHEEL, ["strip"], vx=VX, by="vx"), "strip has none"),
        (lambda: vc.creep_curve(WHEEL, ["auto"], vx=VX, by="G"), "by"),
        (lambda: vc.solve_many([WHEEL], by="surface.R"), "surface.R"),
        (lambda: vc.solve_many([replace(WHEEL, grid="auto")], by="vx"), "no grid of its own"),
        (lambda: vc.solve_many([replace(WHEEL, motion=None, friction=None)], by="vx"), "no motion"),
    ],
)
def test_what_has_no_derivatives(call, words):
    with pytest.raises(vc.SceneError, match=words):
        call()


@pytest.mark.long
def test_fits_by_gradients_take_one_curve_for_what_differences_take_several(monkeypatch):
    data = vc.creep_curve(LAYERED, ["auto"], vx=VX).Fx[0].to_numpy()
    start = replace(LAYERED, third_body=vc.ThirdBody(h=0.03, G=1e3))
    guesses = {"third_body.h": (0.03, 0.001, 1.0), "friction": (0.4, 0.05, 0.8)}
    curves = {}
    found = {}
    for way in ("gradients", "differences"):
        lines = []
        if way == "differences":
            monkeypatch.setattr(fitting, "_differentiable", lambda *given: False)
        found[way] = vc.fit_creep_curve(start, guesses, vx=VX, Fx=data, progress=lines.append)
        curves[way] = len(lines)
    for fit in found.values():
        assert fit.values["third_body.h"] == pytest.approx(0.08, rel=1e-4)
        assert fit.values["friction"] == pytest.approx(0.3, rel=1e-4)
    assert curves["gradients"] <= curves["differences"] // 2
