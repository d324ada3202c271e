"""Every method of the package on line contact: one answer."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.solvers.registry import normal_methods, tangential_methods

UNLIKE = vc.Bodies(G=(1.0, np.inf), nu=(0.286, 0.0))


def scene(**changes):
    base = {
        "bodies": vc.Bodies(G=1.0, nu=0.28),
        "surface": vc.Cylinders(R=5.0),
        "normal_force": 0.5,
        "friction": 0.25,
        "motion": vc.Steady(Fx=-0.06, Fy=0.03),
        "grid": vc.Grid(nx=30),
    }
    return vc.Scene(**(base | changes))


def close(sol, best, tol):
    peak = best.pressure.max()
    np.testing.assert_allclose(sol.pressure, best.pressure, atol=tol * peak)
    np.testing.assert_allclose(sol.traction, best.traction, atol=tol * peak)
    np.testing.assert_allclose(sol.creepage, best.creepage, atol=tol * np.abs(best.slip).max())


@pytest.fixture(scope="module")
def normal():
    return vc.solve(scene(), normal="clarabel")


@pytest.mark.parametrize("name", [name for name in normal_methods() if name != "hertz"])
def test_normal(name, normal):
    sol = vc.solve(scene(motion=None), normal=name)
    np.testing.assert_allclose(sol.pressure, normal.pressure, atol=1e-8 * normal.pressure.max())
    assert sol.certificate.normal_residual < 1e-9


@pytest.mark.parametrize("name", [*tangential_methods(), "clarabel/marching", "scs/marching", "tang/marching"])
def test_steady_rolling(name, normal):
    tangential, _, formulation = name.partition("/")
    sol = vc.solve(scene(), "clarabel", tangential, formulation=formulation or "auto", tol=1e-7)
    assert sol.plan.tangential == tangential
    close(sol, normal, 1e-6)


@pytest.mark.parametrize("name", [*tangential_methods(), "clarabel/potential", "clarabel/gap", "scs/potential"])
def test_shift(name):
    motion = vc.Shift(Fx=-0.06, Fy=0.03)
    best = vc.solve(scene(motion=motion), "clarabel")
    tangential, _, formulation = name.partition("/")
    sol = vc.solve(scene(motion=motion), "clarabel", tangential, formulation=formulation or "auto", tol=1e-7)
    np.testing.assert_allclose(sol.traction, best.traction, atol=1e-6 * best.pressure.max())
    np.testing.assert_allclose(sol.slip, best.slip, atol=1e-5 * np.abs(best.slip).max())


@pytest.mark.parametrize("methods", [("norm", "tang-safeguarded"), ("norm-single", "clarabel"), ("osqp", "scs")])
def test_unlike_bodies(methods):
    """The paper's Fig. 27, free rolling of unlike cylinders."""
    described = scene(bodies=UNLIKE, friction=0.1, motion=vc.Steady(Fx=0.0))
    best = vc.solve(described)
    assert best.elements["stick"] > 0 < best.elements["slip"]
    close(vc.solve(described, *methods), best, 1e-7)


def test_an_unpolished_answer_is_guaranteed():
    """The certificate bounds the force's error, from the answer's own data."""
    described = scene(motion=vc.Steady(vx=0.02, vy=0.01))
    best = vc.solve(described)
    rough = vc.solve(described, tangential="clarabel", polish=False, tol=1e-3)
    error = np.abs(rough.force - best.force)
    assert np.all(error > 0)
    assert np.all(error <= rough.certificate.force_bound[:2])
    again = vc.certify(rough.scene, rough.traction, rough.pressure)
    assert again.gap == pytest.approx(rough.certificate.gap, rel=1e-6)


@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), UNLIKE], ids=["like", "unlike"])
@pytest.mark.parametrize(
    "motion", [vc.Steady(vx=0.02, vy=0.008), vc.Shift(ux=0.06, uy=-0.03)], ids=["rolling", "shift"]
)
def test_sensitivity(bodies, motion):
    """Against central differences."""
    grid = vc.Grid(nx=40, dx=0.1, x0=-2.0)
    surface = vc.Cylinders(5.0, reference_depth=40.0)

    def force(**changes):
        values = {"Fx": None, "Fy": None, **{n: getattr(motion, n) for n in names}, **changes}
        return vc.solve(
            scene(bodies=bodies, surface=surface, motion=type(motion)(**values), grid=grid), normal="clarabel", tol=1e-9
        ).force

    names = ("vx", "vy") if isinstance(motion, vc.Steady) else ("ux", "uy")
    sol = vc.solve(scene(bodies=bodies, surface=surface, motion=motion, grid=grid), normal="clarabel")
    assert not sol.sensitivity()[:, 2].any()
    step = 1e-6
    for column, name in enumerate(names):
        ahead, behind = (force(**{name: getattr(motion, name) + sign * step}) for sign in (1, -1))
        slopes = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(sol.sensitivity()[:, column], slopes, atol=2e-4 * np.abs(slopes).max())
