"""Parameters of friction, layers and theories from creep curves: recovered, with errors that
hold.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused

DATA = Path(__file__).parents[1] / "data"
VX = np.linspace(4e-4, 9e-3, 9)


def wheel(length=1.0, force=1.0, **entries):
    """A wheel on a rail, in other units of length and force."""
    given = {
        "bodies": vc.Bodies(G=82e9 * force / length**2, nu=0.28),
        "surface": vc.Paraboloids(Rx=0.46 * length, Ry=0.3 * length),
        "normal_force": 80e3 * force,
        "motion": vc.Steady(),
        "grid": vc.Grid(nx=8, ny=8),
    }
    return make_scene(**given | entries)


@pytest.mark.long
def test_layer_and_friction_are_recovered_from_the_exact_theory():
    layered = wheel(third_body=vc.ThirdBody(h=8e-5, G=1e9), friction=0.26)
    data = vc.creep_curve(layered, ["auto"], vx=VX).Fx[0].to_numpy()
    start = wheel(third_body=vc.ThirdBody(h=3e-5, G=1e9))
    guesses = {"third_body.h": (3e-5, 1e-6, 1e-3), "friction": (0.4, 0.05, 0.8)}
    fit = vc.fit_creep_curve(start, guesses, vx=VX, Fx=data)
    assert fit.values["third_body.h"] == pytest.approx(8e-5, rel=1e-4)
    assert fit.values["friction"] == pytest.approx(0.26, rel=1e-5)
    assert fit.scene.third_body.h == fit.values["third_body.h"]
    assert fit.rms < 1e-5 * 80e3


@pytest.mark.long
def test_measured_curve_of_a_roller_rig():
    """Dry steel with debris: an elastic layer explains it within its scatter, bodies without one do
    not.
    """
    vx, Fx = np.loadtxt(DATA / "roller_rig.csv", delimiter=",", skiprows=1).T
    bodies, scatter = vc.Bodies(G=205e9 / 2.58, nu=0.29), 219.1
    surface = vc.Paraboloids(Rx=1 / (1 / 0.1165 + 1 / 0.50623), Ry=0.29)
    assert wheel(bodies=bodies, surface=surface, normal_force=2500.0).hertz.b == pytest.approx(
        2e-3, rel=2e-3
    )
    rig = wheel(bodies=bodies, surface=surface, normal_force=9.3e3)
    guesses = {"friction": (0.5, 0.1, 1.0)}
    bare = vc.fit_creep_curve(rig, guesses, vx=vx, Fx=Fx)
    debris = replace(rig, third_body=vc.ThirdBody(h=1e-5, G=1e9))
    fit = vc.fit_creep_curve(debris, guesses | {"third_body.h": (1e-5, 1e-7, 1e-3)}, vx=vx, Fx=Fx)
    assert fit.rms < 0.7 * scatter and bare.rms > 3 * scatter
    assert np.abs(fit.curve.Fx[0] - Fx).max() < 2 * scatter
    assert (
        fit.values["friction"] == pytest.approx(0.52, abs=0.02)
        and 0 < fit.errors["friction"] < 0.02
    )
    assert 1.1e-5 < fit.values["third_body.h"] < 1.6e-5 and fit.errors["third_body.h"] < 2e-6
    factors = {"k_A": (0.6, 0.1, 1.0), "k_S": (0.3, 0.05, 1.0)}
    polach = vc.fit_creep_curve(rig, guesses | factors, vx=vx, Fx=Fx, method="polach")
    assert polach.rms < 0.7 * scatter and polach.values["k_S"] < polach.values["k_A"] < 1


@pytest.mark.long
def test_errors_hold_for_noise():
    """Of twenty curves with noise the parameter is within two standard errors nearly always; NaN is
    left out.
    """
    rng, scene = np.random.default_rng(0), wheel()
    exact = vc.creep_curve(scene, ["fastsim"], vx=VX).Fx[0].to_numpy()
    off = []
    for _ in range(20):
        noisy = exact + 400.0 * rng.normal(size=VX.size)
        noisy[rng.integers(9)] = np.nan
        fit = vc.fit_creep_curve(
            scene, {"friction": (0.4, 0.1, 0.6)}, vx=VX, Fx=noisy, method="fastsim"
        )
        off.append((fit.values["friction"] - 0.3) / fit.errors["friction"])
    assert np.mean(np.abs(off) < 2) > 0.8
    assert 0.5 < np.std(off) < 1.7
    known = vc.fit_creep_curve(
        scene, {"friction": (0.4, 0.1, 0.6)}, vx=VX, Fx=exact, method="fastsim", sigma=400.0
    )
    curve = vc.creep_curve(replace(scene, friction=0.301), ["fastsim"], vx=VX).Fx[0].to_numpy()
    assert known.errors["friction"] == pytest.approx(
        400.0 / np.linalg.norm((curve - exact) / 1e-3), rel=0.02
    )


def test_what_forces_do_not_determine_is_said():
    """Only h/G of an elastic layer counts: both together are known by nothing, friction beside them
    is.
    """
    scene = wheel(third_body=vc.ThirdBody(h=8e-5, G=1e9))
    noise = 100.0 * np.random.default_rng(2).normal(size=VX.size)
    noisy = vc.creep_curve(scene, ["fastsim"], vx=VX).Fx[0].to_numpy() + noise
    guesses = {
        "third_body.h": (5e-5, 1e-5, 1e-3),
        "third_body.G": (1e9, 1e8, 5e9),
        "friction": (0.4, 0.1, 0.6),
    }
    fit = vc.fit_creep_curve(scene, guesses, vx=VX, Fx=noisy, method="fastsim")
    assert (
        fit.errors["third_body.h"] == fit.errors["third_body.G"] == np.inf
        and fit.errors["friction"] < 0.01
    )
    assert fit.report().count("(not determined by these forces)") == 2
    assert fit.scene.third_body.compliance == pytest.approx(8e-14, rel=0.1)
    assert fit.values["friction"] == pytest.approx(0.3, abs=3 * fit.errors["friction"])


@pytest.mark.long
def test_a_parameter_on_a_bound_is_said_and_the_others_have_errors_with_it_fixed():
    """Polach's k_A, 0.5, in a range that ends below: friction has the error of a fit without k_A,
    given the bound.
    """
    noise = 100.0 * np.random.default_rng(3).normal(size=VX.size)
    noisy = (
        vc.creep_curve(wheel(), {"polach": {"k_A": 0.5, "k_S": 0.2}}, vx=VX).Fx[0].to_numpy()
        + noise
    )
    friction, k_S = (0.35, 0.1, 0.6), (0.15, 0.05, 0.3)
    given = {"vx": VX, "Fx": noisy, "method": "polach"}
    fit = vc.fit_creep_curve(
        wheel(), {"friction": friction, "k_A": (0.35, 0.3, 0.4), "k_S": k_S}, **given
    )
    assert fit.on_bounds == ("k_A",)
    assert fit.values["k_A"] == pytest.approx(0.4, rel=1e-3)
    assert np.isnan(fit.errors["k_A"])
    np.testing.assert_array_equal(
        np.isnan(fit.correlation), [[False, True, False], [True] * 3, [False, True, False]]
    )
    near = vc.fit_creep_curve(
        wheel(), {"friction": friction, "k_A": (0.4, 0.4, 0.4 + 1e-9), "k_S": k_S}, **given
    )
    assert near.on_bounds == ("k_A",)
    for name in ("friction", "k_S"):
        assert fit.values[name] == pytest.approx(near.values[name], rel=1e-3)
        assert fit.errors[name] == pytest.approx(near.errors[name], rel=0.01)
        assert 0 < fit.errors[name] < np.inf
    assert "k_A = 0.4 (on a bound of its range)" in fit.report()
    assert "errors are those with k_A fixed" in fit.report()
    wide = vc.fit_creep_curve(
        wheel(), {"friction": friction, "k_A": (0.4, 0.1, 1.0), "k_S": k_S}, **given
    )
    assert wide.on_bounds == ()
    assert wide.values["k_A"] == pytest.approx(0.5, abs=3 * wide.errors["k_A"])
    assert "bound" not in wide.report()


def test_one_parameter_alone_on_its_bound():
    exact = vc.creep_curve(wheel(), ["fastsim"], vx=VX).Fx[0].to_numpy()
    fit = vc.fit_creep_curve(
        wheel(), {"friction": (0.2, 0.1, 0.25)}, vx=VX, Fx=exact, method="fastsim"
    )
    assert fit.on_bounds == ("friction",)
    assert fit.values["friction"] == pytest.approx(0.25, rel=1e-3)
    assert "errors are those" not in fit.report()


def test_options_of_theories_and_any_units():
    data = vc.creep_curve(wheel(), {"polach": {"k_A": 0.5, "k_S": 0.2}}, vx=VX)
    guesses = {"k_A": (0.9, 0.1, 1.0), "k_S": (0.4, 0.05, 1.0)}
    fits = [
        vc.fit_creep_curve(
            wheel(length, force), guesses, vx=VX, Fx=data.Fx[0] * force, method="polach"
        )
        for length, force in ((1.0, 1.0), (1e3, 1e-3))
    ]
    for fit in fits:
        assert (fit.options["k_A"], fit.options["k_S"]) == (
            pytest.approx(0.5, rel=1e-3),
            pytest.approx(0.2, rel=1e-3),
        )
    assert fits[1].rms == pytest.approx(1e-3 * fits[0].rms, abs=1e-6)


def test_fastsim_with_a_layer_has_the_slope_of_flexibilities_in_series():
    """From the closed form of pure creepage: the flexibilities of body and layer add, and full slip
    stays.
    """
    layer = vc.ThirdBody(h=5e-5, G=1e9)
    bare, layered = (
        vc.creep_curve(wheel(third_body=body), ["fastsim"], vx=[1e-7, 0.1])
        for body in (None, layer)
    )
    a, b = wheel().hertz.a, wheel().hertz.b
    L = 8 * a / (3 * 82e9 * vc.no_slip_coefficients(a / b, 0.28).C11)
    ratio = float(layered.Fx[0, 0] / bare.Fx[0, 0])
    assert ratio == pytest.approx(L / (L + layer.compliance), rel=1e-3)
    assert float(layered.Fx[0, 1]) == pytest.approx(float(bare.Fx[0, 1]), rel=1e-9)


def test_fastsim_is_exact_where_the_layer_is_much_softer_than_the_bodies():
    """There each element has its own flexibility, as in the simplified theory; the bound is
    Hertz's.
    """
    off = []
    for n in (12, 24):
        soft = wheel(third_body=vc.ThirdBody(h=5e-3, G=1e9), grid=vc.Grid(nx=n, ny=n))
        curve = vc.creep_curve(
            soft, {"auto": {}, "fastsim-elliptic": {"m": 40, "n": 40}}, vx=30 * VX
        )
        off.append(float(np.abs(curve.Fx[0] - curve.Fx[1]).max() / curve.limit))
    assert off[1] < 0.03
    assert off[1] < 0.65 * off[0]  # first order in the elements of the exact theory
    assert 0.05 < float(-curve.Fx[0, 0]) / curve.limit < float(-curve.Fx[0, -1]) / curve.limit


@pytest.mark.parametrize(
    ("parameters", "entries", "field"),
    [
        ({}, {}, "parameters"),
        ({"friction": (0.9, 0.1, 0.5)}, {}, r"parameters\['friction'\]"),
        ({"friction": (0.3, 0.1)}, {}, r"parameters\['friction'\]"),
        ({"fricton": (0.3, 0.1, 0.5)}, {}, 'parameters: the scene has no "fricton"'),
        ({"Rx": (0.3, 0.1, 0.5)}, {}, r"did you mean surface\.Rx"),
        ({"k_A": (0.3, 0.1, 0.5)}, {}, "k_A"),
        ({"friction": (0.3, 0.1, 0.5)}, {"Fx": None}, "Fx, Fy"),
        ({"friction": (0.3, 0.1, 0.5)}, {"Fx": [1.0, 2.0]}, "Fx, Fy"),
        ({"friction": (0.3, 0.1, 0.5)}, {"Fx": np.full(9, np.nan)}, "Fx, Fy"),
        ({"friction": (0.3, 0.1, 0.5)}, {"sigma": -1.0}, "sigma"),
    ],
)
def test_bad_input(parameters, entries, field):
    given = {"vx": VX, "Fx": -VX, "method": "fastsim"} | entries
    refused(lambda: vc.fit_creep_curve(wheel(), parameters, **given), match=field)


def test_curves_carry_units():
    curve = vc.creep_curve(wheel(units=vc.SI), ["fastsim"], vx=VX)
    assert (curve.Fx.units, curve.Mz.units, curve.spin.units) == ("N", "N m", "1/m")
    with pytest.raises(vc.SceneError, match="without options"):
        vc.creep_curve(wheel(), {"auto": {"k_A": 0.3}}, vx=VX)
