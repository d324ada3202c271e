"""Sensitivity against central differences of whole solutions."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc

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
    with pytest.raises(vc.SceneError) as failure:
        sol.sensitivity()
    assert failure.value.field == field
