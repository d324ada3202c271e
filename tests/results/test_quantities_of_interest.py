"""The norm of errors: which values count, their units, and invariance to units of length and
force.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import LIKE, make_scene, refused
from varcontact.reference import carter, cattaneo_mindlin, line_contact
from varcontact.results.quantities_of_interest import error, semi_axes, units, values

SPHERES, ROLLS = vc.Paraboloids(Rx=1.0, Ry=1.0), vc.Steady(vx=1e-3, spin=1e-3)
SCENE = make_scene(SPHERES, 1e-3, ROLLS, vc.Grid(nx=10, ny=10), 0.4, vc.Bodies(G=1.0, nu=0.0))


def test_forces_by_f_fz_and_the_moment_by_f_fz_a():
    sol = vc.solve(SCENE)
    found, per = values(sol), units(sol)
    assert found == {"Fx": sol.force[0], "Fy": sol.force[1], "Mz": sol.moment}
    assert per == pytest.approx({"Fx": 4e-4, "Fy": 4e-4, "Mz": 4e-4 * SCENE.hertz.a}, rel=1e-12)


def test_the_error_is_the_largest_in_units():
    per, exact = {"Fx": 2.0, "Mz": 0.5}, {"Fx": 1.0, "Mz": 0.0}
    assert error({"Fx": 1.2, "Mz": 0.1, "more": 9.0}, exact, per) == pytest.approx(0.2)
    assert error({"Fx": 0.6, "Mz": 0.0}, exact, per) == pytest.approx(0.2)
    assert math.isnan(error({"Fx": 1.0}, exact, per)), (
        "a value that was not found is no small error"
    )
    assert math.isnan(error({"Fx": math.nan}, {"Fx": 1.0}, {"Fx": 1.0}))


def test_prescribed_forces_count_by_the_saturation_shift():
    """Just below the limit of friction Cattaneo's shift is the unit: all of the contact slips."""
    sol = vc.solve(replace(SCENE, motion=vc.Shift(Fx=-2e-4)))
    limit = cattaneo_mindlin(SCENE.hertz, SCENE.bodies, 0.4, -4e-4 * (1 - 1e-12)).shift
    assert list(values(sol)) == ["ux", "Fy", "Mz"]
    assert units(sol)["ux"] == pytest.approx(limit, rel=1e-6)


def test_prescribed_forces_in_line_contact_count_by_carters_creepage():
    bodies, motion = vc.Bodies(G=1.0, nu=0.25), vc.Steady(Fx=-2e-4)
    scene = make_scene(vc.Cylinders(R=2.0), 1e-3, motion, vc.Grid(nx=20), bodies=bodies)
    contact = line_contact(2.0, bodies, force=1e-3)
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
    given = vc.solve(
        replace(SCENE, motion=None, friction=None, normal_force=None, approach=1e-3), normal="norm"
    )
    assert list(values(given)) == ["normal_force", "peak_pressure"]
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
    with pytest.raises(
        vc.SceneError, match=r"friction = inf .* errors are measured by the friction limit f Fz"
    ):
        units(sol)


def test_friction_by_element_counts_as_it_is():
    grid = vc.Grid(nx=12, ny=12, dx=0.02, dy=0.02, x0=-0.12, y0=-0.12)
    friction = np.full((12, 12), 0.1)
    friction[:, 6:] = 0.3
    assert units(vc.solve(replace(SCENE, friction=friction, grid=grid)))["Fx"] == pytest.approx(
        0.2e-3, rel=1e-9
    )


GRID = vc.Grid(nx=8, ny=8)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
STEADY = vc.Steady(vx=0.05, vy=-0.02, spin=0.03)
SHIFT = vc.Shift(ux=0.1, uy=-0.06, rotation=0.05)
TOL = 1e-11


def differences(sol, step=1e-6):
    """Central differences about the creepages of a solution, on its own grid."""
    motion, columns = sol.scene.motion, []
    names = ("vx", "vy", "spin") if isinstance(motion, vc.Steady) else ("ux", "uy", "rotation")
    base = replace(motion, Fx=None, Fy=None, **dict(zip(names, sol.creepage, strict=True)))
    for name in names:
        moved = [replace(base, **{name: getattr(base, name) + sign * step}) for sign in (1, -1)]
        ahead, behind = (
            vc.solve(replace(sol.scene, motion=each, grid=sol.grid), tol=TOL).force
            for each in moved
        )
        columns.append((ahead - behind) / (2 * step))
    return np.array(columns).T


def agrees(sol):
    found, expected = sol.sensitivity(), differences(sol)
    assert found.shape == (2, 3)
    # Central differences: 1e-12 of curvature and 1e-11/1e-6 of the solutions' own tolerance.
    np.testing.assert_allclose(found, expected, atol=2e-5 * np.abs(expected).max())


HERTZ = make_scene(vc.Ellipse(a=1.2, b=0.9)).hertz
BY_APPROACH = {
    "normal_force": None,
    "approach": HERTZ.approach,
    "surface": vc.Paraboloids(HERTZ.Rx, HERTZ.Ry),
}
GIVEN = {
    "rolling": {"motion": STEADY},
    "shift": {"motion": SHIFT},
    "rolling without slip": {"motion": STEADY, "friction": np.inf},
    "shift without slip": {"motion": SHIFT, "friction": np.inf},
    "force": {"motion": vc.Steady(Fx=-0.15, vy=-0.02, spin=0.03)},
    "forces": {"motion": vc.Shift(Fx=-0.15, Fy=0.1)},
    "approach": {"motion": STEADY, **BY_APPROACH},
}


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
@pytest.mark.parametrize("given", GIVEN.values(), ids=GIVEN)
def test_sensitivity_is_that_of_differences(rolling, bodies, given):
    """Of unlike bodies at a given approach the normal force changes with the creepage, and that
    with it.
    """
    sol = vc.solve(rolling(bodies=bodies, grid=GRID, **given), tol=TOL)
    assert "friction" in given or min(sol.elements["slip"], sol.elements["stick"]) >= 5
    agrees(sol)


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
