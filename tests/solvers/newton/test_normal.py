"""Newton's method without a matrix for the normal problem: NORM's answers, and Hertz's."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.residuals import normal_gap, normal_residual
from varcontact.errors import SceneError
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton import driver
from varcontact.solvers.newton.normal import newton_normal

SETTINGS = Settings(1e-8)


def check_exact(problem, raw):
    """Solved to the tolerance by residual and gap, and equal to the dense answer."""
    dense = norm(problem)
    if not dense.solved:
        dense = norm(problem, exchange="one")
    assert raw.solved, raw.status
    assert normal_residual(problem, raw.traction, raw.rigid) <= SETTINGS.tol
    assert normal_gap(problem, raw.traction, raw.rigid)[1] <= SETTINGS.tol
    assert raw.traction.min() >= 0
    np.testing.assert_allclose(raw.traction, dense.traction, rtol=0, atol=1e-7 * dense.traction.max())
    np.testing.assert_allclose(raw.rigid, dense.rigid, rtol=1e-7)


@pytest.mark.parametrize("line", [False, True])
def test_equals_norm(normal_problem, line):
    """On random surfaces, smooth and rough, by force and by approach; none of them needs the dense fallback."""
    for seed in range(20):
        problem = normal_problem(seed, line)
        raw = newton_normal(problem, SETTINGS)
        assert (raw.solver, raw.status) == ("", "Solved"), seed
        check_exact(problem, raw)


def test_units_do_not_matter(normal_problem):
    """Pressures and distances by powers of two: the same numbers, far below and beyond single precision."""
    problem = normal_problem(7)
    raw = newton_normal(problem, SETTINGS)
    for unit in (2.0**-300, 2.0**300):
        given = {
            name: None if (value := getattr(problem, name)) is None else value * unit for name in ("force", "approach")
        }
        other = newton_normal(dataclasses.replace(problem, distance=problem.distance * unit, **given), SETTINGS)
        np.testing.assert_array_equal(other.traction / unit, raw.traction)
        assert other.iterations == raw.iterations


def test_approach_and_force_belong_together(normal_problem):
    """The force that an approach needs, prescribed, leads to that approach."""
    for seed in range(6):
        problem = normal_problem(seed)
        raw = newton_normal(problem, SETTINGS)
        given = {"approach": None, "force": float(raw.traction.sum() * problem.area)}
        if problem.approach is None:
            given = {"approach": float(raw.rigid[0]), "force": None}
        other = newton_normal(dataclasses.replace(problem, **given), SETTINGS)
        np.testing.assert_allclose(other.traction, raw.traction, rtol=0, atol=1e-7 * raw.traction.max())
        np.testing.assert_allclose(other.rigid, raw.rigid, rtol=1e-7)


def test_hertz(rolling):
    """On many elements the pressure is Hertz's to the grid's error; the certificate says that it is exact on it."""
    scene = rolling(motion=None, friction=None, grid=vc.Grid(nx=64, ny=64))
    sol = vc.solve(scene, normal="newton")
    assert sol.certificate.normal_residual <= 1e-8 and sol.certificate.normal_relative_gap <= 1e-8
    exact = vc.solve(scene, normal="hertz")
    inner = exact.pressure > 0.5 * exact.pressure.max()
    np.testing.assert_allclose(sol.pressure[inner], exact.pressure[inner], rtol=2e-3)
    assert sol.approach == pytest.approx(exact.approach, rel=1e-3)


def test_from_any_start(normal_problem):
    problem = normal_problem(1)
    raw = newton_normal(problem, SETTINGS)
    assert newton_normal(problem, SETTINGS, raw).iterations <= 1
    noise = np.random.default_rng(0).normal(size=raw.traction.shape)
    for traction in (noise, np.zeros_like(noise), noise * np.nan):
        again = newton_normal(problem, SETTINGS, dataclasses.replace(raw, traction=traction))
        assert again.solved
        np.testing.assert_allclose(again.traction, raw.traction, rtol=0, atol=1e-7 * raw.traction.max())


def test_bad_input(normal_problem):
    """A start of another grid is refused; what is no number is no answer; nothing touches without an approach."""
    problem = normal_problem(1)
    with pytest.raises(SceneError, match=r"start\.traction has shape .*; it must be of shape"):
        newton_normal(problem, SETTINGS, RawSolution(np.zeros(3), np.zeros(1), 0, ""))
    distance = problem.distance.copy()
    distance[2] = np.nan
    raw = newton_normal(dataclasses.replace(problem, distance=distance), SETTINGS)
    assert raw.status == "NotANumber" and not raw.solved and np.isfinite(raw.traction).all()
    apart = dataclasses.replace(problem, force=None, approach=float(problem.distance.min()))
    raw = newton_normal(apart, SETTINGS)
    assert raw.solved and not raw.traction.any() and raw.rigid[0] == apart.approach


def test_wrong_linear_solves_do_not_lead_astray(normal_problem, monkeypatch):
    """Every other step is noise; and where all are, NORM is asked."""
    problem, exact, calls = normal_problem(1), driver.gcr, []
    rng = np.random.default_rng(0)

    def wrong(system, forces, lacking, enough):
        calls.append(len(calls) % 2 == 1)
        step = exact(system, forces, lacking, enough)
        noise = 10 * rng.normal(size=system.right.shape) * system.conditions.within
        shift = system.product(noise.astype(np.float32)).astype(float)
        return step if calls[-1] else dataclasses.replace(step, traction=noise, shift=shift)

    monkeypatch.setattr(driver, "gcr", wrong)
    raw = newton_normal(problem, SETTINGS)
    assert (raw.solver, raw.status) == ("", "Solved") and calls.count(False) > 4
    monkeypatch.setattr(
        driver, "gcr", lambda *a: dataclasses.replace(exact(*a), traction=np.full(a[0].right.shape, np.nan))
    )
    monkeypatch.setattr(driver, "forward_backward_forward", lambda at, *_: at)
    densely = newton_normal(problem, SETTINGS)
    assert (densely.solver, densely.status) == ("norm", "Solved")
    assert densely.reason == "newton missed the tolerance, norm was used"
    monkeypatch.undo()
    check_exact(problem, raw)
    check_exact(problem, densely)
