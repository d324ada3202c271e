"""The norm of errors: which values count, their units, and invariance to units of length and force."""

import dataclasses
import math
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.reference import carter, cattaneo_mindlin, line_contact
from varcontact.results.quantities_of_interest import error, semi_axes, units, values

SCENE = make_scene(
    vc.Paraboloids(Rx=1.0, Ry=1.0),
    1e-3,
    vc.Steady(vx=1e-3, spin=1e-3),
    vc.Grid(nx=10, ny=10),
    friction=0.4,
    bodies=vc.Bodies(G=1.0, nu=0.0),
)


def test_forces_by_f_fz_and_the_moment_by_f_fz_a():
    sol = vc.solve(SCENE)
    found, per = values(sol), units(sol)
    assert found == {"Fx": sol.force[0], "Fy": sol.force[1], "Mz": sol.moment}
    assert per == pytest.approx({"Fx": 4e-4, "Fy": 4e-4, "Mz": 4e-4 * SCENE.hertz.a}, rel=1e-12)


def test_the_error_is_the_largest_in_units():
    per, exact = {"Fx": 2.0, "Mz": 0.5}, {"Fx": 1.0, "Mz": 0.0}
    assert error({"Fx": 1.2, "Mz": 0.1, "more": 9.0}, exact, per) == pytest.approx(0.2)
    assert error({"Fx": 0.6, "Mz": 0.0}, exact, per) == pytest.approx(0.2)


def test_a_value_that_was_not_found_is_no_small_error():
    assert math.isnan(error({"Fx": 1.0}, {"Fx": 1.0, "Mz": 0.0}, {"Fx": 1.0, "Mz": 1.0}))
    assert math.isnan(error({"Fx": math.nan}, {"Fx": 1.0}, {"Fx": 1.0}))


def test_prescribed_forces_count_by_the_saturation_shift():
    """Just below the limit of friction Cattaneo's shift is the unit: all of the contact slips."""
    sol = vc.solve(replace(SCENE, motion=vc.Shift(Fx=-2e-4)))
    limit = cattaneo_mindlin(SCENE.hertz, SCENE.bodies, 0.4, -4e-4 * (1 - 1e-12)).shift
    assert list(values(sol)) == ["ux", "Fy", "Mz"]
    assert units(sol)["ux"] == pytest.approx(limit, rel=1e-6)


def test_prescribed_forces_in_line_contact_count_by_carters_creepage():
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.25), surface=vc.Cylinders(R=2.0), normal_force=1e-3, friction=0.3,
        motion=vc.Steady(Fx=-2e-4), grid=vc.Grid(nx=20),
    )  # fmt: skip
    contact = line_contact(2.0, scene.bodies, force=1e-3)
    sol = vc.solve(scene)
    assert list(values(sol)) == ["vx", "Fy"]
    full = carter(contact, 0.3, creepage=1e-6).full_sliding_creepage
    assert units(sol)["vx"] == pytest.approx(full, rel=1e-12)
    exact = carter(contact, 0.3, force=-2e-4).creepage
    assert error({"vx": sol.creepage[0]}, {"vx": exact}, units(sol)) < 0.05


def test_normal_contact_counts_relative_to_itself():
    sol = vc.solve(replace(SCENE, motion=None, friction=None), normal="norm")
    assert values(sol) == {"approach": sol.approach, "peak_pressure": sol.pressure.max()}
    assert units(sol) == values(sol)
    given = vc.solve(replace(SCENE, motion=None, friction=None, normal_force=None, approach=1e-3), normal="norm")
    assert list(values(given)) == ["normal_force", "peak_pressure"]


def test_a_motion_without_friction_is_normal_contact():
    assert list(values(vc.solve(replace(SCENE, friction=0.0)))) == ["approach", "peak_pressure"]


def test_the_semi_axes_of_samples_are_those_of_hertz():
    x, y = np.linspace(-0.2, 0.2, 61), np.linspace(-0.4, 0.4, 61)
    sampled = vc.SampledDistance(x**2 + (y**2 / 6)[:, None], x=x, y=y)
    surface = vc.Paraboloids(Rx=0.5, Ry=3.0)
    exact = replace(SCENE, surface=surface).hertz
    sol = vc.solve(replace(SCENE, surface=sampled, grid=vc.Grid(nx=24, ny=24)))
    assert semi_axes(sol) == pytest.approx((exact.a, exact.b), rel=0.02)
    assert units(sol)["Mz"] == pytest.approx(4e-4 * math.sqrt(exact.a * exact.b), rel=0.02)


def test_infinite_friction_has_no_unit():
    sol = vc.solve(replace(SCENE, friction=np.inf))
    with pytest.raises(vc.SceneError, match=r"friction = inf .* errors are measured by the friction limit f Fz"):
        units(sol)


def test_friction_by_element_counts_as_it_is():
    grid = vc.Grid(nx=12, ny=12, dx=0.02, dy=0.02, x0=-0.12, y0=-0.12)
    friction = np.full((12, 12), 0.1)
    friction[:, 6:] = 0.3
    assert units(vc.solve(replace(SCENE, friction=friction, grid=grid)))["Fx"] == pytest.approx(0.2e-3, rel=1e-9)


# -------------------- Sensitivity against central differences of whole solutions


GRID = vc.Grid(nx=8, ny=8)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
STEADY = vc.Steady(vx=0.05, vy=-0.02, spin=0.03)
SHIFT = vc.Shift(ux=0.1, uy=-0.06, rotation=0.05)
TOL = 1e-11


def names_of(motion):
    return ("vx", "vy", "spin") if isinstance(motion, vc.Steady) else ("ux", "uy", "rotation")


def differences(sol, step=1e-6):
    """Central differences about the creepages of a solution, on its own grid."""
    names, columns = names_of(sol.scene.motion), []
    base = dataclasses.replace(
        sol.scene.motion, Fx=None, Fy=None, **dict(zip(names, sol.creepage, strict=True))
    )  # fmt: skip
    for name in names:
        ends = []
        for sign in (1, -1):
            motion = dataclasses.replace(base, **{name: getattr(base, name) + sign * step})
            ends.append(vc.solve(dataclasses.replace(sol.scene, motion=motion, grid=sol.grid), tol=TOL).force)
        columns.append((ends[0] - ends[1]) / (2 * step))
    return np.array(columns).T


def agrees(sol):
    found, expected = sol.sensitivity(), differences(sol)
    assert found.shape == (2, 3)
    # Central differences: 1e-12 of curvature and 1e-11/1e-6 of the solutions' own tolerance.
    np.testing.assert_allclose(found, expected, atol=2e-5 * np.abs(expected).max())


@pytest.mark.parametrize("friction", [0.3, np.inf])
@pytest.mark.parametrize("motion", [STEADY, SHIFT])
@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), UNLIKE])
def test_creepages(rolling, bodies, motion, friction):
    sol = vc.solve(rolling(bodies=bodies, motion=motion, friction=friction, grid=GRID), tol=TOL)
    assert friction == np.inf or min(sol.elements["slip"], sol.elements["stick"]) >= 5
    agrees(sol)


@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), UNLIKE])
def test_approach_prescribed(rolling, bodies):
    """Unlike bodies: the normal force then changes with the creepage, and that with it."""
    hertz = rolling().hertz
    scene = rolling(
        bodies=bodies, surface=vc.Paraboloids(hertz.Rx, hertz.Ry), normal_force=None, approach=hertz.approach,
        motion=STEADY, grid=GRID,
    )  # fmt: skip
    agrees(vc.solve(scene, tol=TOL))


@pytest.mark.parametrize("motion", [vc.Steady(Fx=-0.15, vy=-0.02, spin=0.03), vc.Shift(Fx=-0.15, Fy=0.1)])
@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), UNLIKE])
def test_prescribed_forces(rolling, bodies, motion):
    """By the creepages that the forces gave."""
    agrees(vc.solve(rolling(bodies=bodies, motion=motion, grid=GRID), tol=TOL))


def test_full_slip_and_frictionless(rolling):
    agrees(vc.solve(rolling(motion=vc.Steady(vx=2.0, vy=1.0, spin=0.5), grid=GRID), tol=TOL))
    assert not vc.solve(rolling(friction=0.0, grid=GRID)).sensitivity().any()


@pytest.mark.parametrize(
    ("changes", "arguments", "field"),
    [
        ({"motion": None}, {}, "motion"),
        ({}, {"tangential": "fastsim"}, "solution"),
        ({}, {"tangential": "linear"}, "solution"),
        ({"bodies": UNLIKE}, {"coupling": "johnson"}, "solution"),
    ],
)
def test_refused(rolling, changes, arguments, field):
    sol = vc.solve(rolling(grid=GRID, **changes), **arguments)
    refused(sol.sensitivity, field)
