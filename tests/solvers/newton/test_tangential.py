"""Newton's method without a matrix for the tangential problem: the dense answers, on any problem, from anywhere."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.problems import RawSolution
from varcontact.discrete.residuals import gap, tangential_residual
from varcontact.elasticity.operators import GridOperator
from varcontact.errors import NotConverged, SceneError
from varcontact.solvers.active_set.tang import tang_safeguarded
from varcontact.solvers.interface import Settings
from varcontact.solvers.newton import driver
from varcontact.solvers.newton.gcr import Step
from varcontact.solvers.newton.kernel import Kernel
from varcontact.solvers.newton.tangential import newton_tangential

SETTINGS = Settings(1e-8)


def check_exact(problem, raw, agree=1e-7):
    """Solved to the tolerance by residual and gap, and equal to the dense answer."""
    dense = tang_safeguarded(problem)
    scale = problem.bound.max() if np.isfinite(problem.bound).all() else np.abs(dense.traction).max()
    assert raw.solved, raw.status
    assert tangential_residual(problem, raw.traction, raw.rigid) <= SETTINGS.tol
    if np.isfinite(problem.bound).all():
        assert gap(problem, raw.traction, raw.rigid)[1] <= SETTINGS.tol
        assert np.all(np.linalg.norm(raw.traction, axis=0) <= problem.bound * (1 + 1e-12)), "admissible"
    np.testing.assert_allclose(raw.traction, dense.traction, rtol=0, atol=agree * scale)


@pytest.mark.parametrize("seeds", [range(first, first + 9) for first in range(0, 63, 9)])
def test_equals_the_dense_answer(tangential_problem, seeds):
    """On random problems, each batch with every shape; none of them needs the dense fallback."""
    for seed in seeds:
        problem = tangential_problem(seed)
        raw = newton_tangential(problem, SETTINGS)
        assert (raw.solver, raw.status) == ("", "Solved"), seed
        check_exact(problem, raw)


EXTREMES = {
    "short steps": {"shape": "ellipse", "step": 0.2, "rolling": True, "nu": 0.28},
    "long steps": {"shape": "ellipse", "step": 50.0, "rolling": True},
    "nearly incompressible": {"shape": "needle", "nu": 0.5, "rolling": True, "step": 1.0},
    "low friction": {"shape": "wavy", "friction": 1e-5},
    "low friction, forces": {"shape": "levels", "friction": 1e-4, "carried": 0.9, "rolling": True, "step": 1.0},
    "much friction": {"shape": "holes", "friction": 1e4},
    "nearly saturated": {"shape": "ellipse", "carried": 1 - 1e-6, "rolling": False},
    "nearly saturated, rolling": {"shape": "ellipse", "carried": 1 - 1e-6, "rolling": True, "step": 1.0},
    "no slip": {"shape": "levels", "no_slip": True},
    "no slip, forces": {"shape": "holes", "no_slip": True, "carried": 0.5},
    "tiny creepage": {"shape": "ellipse", "creepage": (1e-12, 0.0, 1e-12), "carried": 0.0},
}


@pytest.mark.parametrize("name", EXTREMES)
def test_extremes(tangential_problem, name):
    """Equal to the dense answer, by whatever road: the status tells which."""
    for seed in range(3):
        problem = tangential_problem(seed, **EXTREMES[name])
        check_exact(problem, newton_tangential(problem, SETTINGS))


def test_units_do_not_matter(tangential_problem):
    """Tractions and shifts by powers of two: the same numbers, far below and beyond single precision."""
    problem = tangential_problem(3, shape="levels", carried=0.3)
    raw = newton_tangential(problem, SETTINGS)
    for power in (-200, -50, 50, 200):
        unit = 2.0**power
        other = dataclasses.replace(
            problem,
            rigid_shift=problem.rigid_shift * unit,
            bound=problem.bound * unit,
            force=tuple(None if F is None else F * unit for F in problem.force),
        )
        scaled = newton_tangential(other, SETTINGS)
        np.testing.assert_array_equal(scaled.traction / unit, raw.traction)
        assert (scaled.status, scaled.iterations) == (raw.status, raw.iterations)


@pytest.mark.parametrize(("axis", "signs"), [(2, (1, -1)), (3, (-1, 1))])
def test_mirror_and_direction(tangential_problem, axis, signs):
    """The mirror image of a problem has the mirror image of its solution; along x, it then rolls the other way."""
    problem = tangential_problem(5, shape="wavy", rolling=True, carried=0.0, step=1.0)
    whole, signs = problem.operator.grid_operator, np.array(signs, dtype=float)
    ny, nx = whole.shape
    table = np.flip(whole.table, axis) * signs[:, None, None, None] * signs[None, :, None, None]
    row, column = np.divmod(problem.operator.elements, nx)
    images = (ny - 1 - row) * nx + column if axis == 2 else row * nx + nx - 1 - column
    order = np.argsort(images)
    mirrored = dataclasses.replace(
        problem,
        operator=GridOperator(whole.shape, np.ascontiguousarray(table)).on(images[order]),
        rigid_shift=problem.rigid_shift[:, order] * signs[:, None],
        bound=problem.bound[order],
    )
    raw, image = newton_tangential(problem, SETTINGS), newton_tangential(mirrored, SETTINGS)
    assert image.status == "Solved"
    expected = raw.traction[:, order] * signs[:, None]
    np.testing.assert_allclose(image.traction, expected, rtol=0, atol=1e-7 * problem.bound.max())


def test_from_any_start(tangential_problem):
    """A start that is the answer costs one step; one that is noise, or no number at all, leads there, too."""
    problem = tangential_problem(17, shape="levels", carried=0.0)
    raw = newton_tangential(problem, SETTINGS)
    assert newton_tangential(problem, SETTINGS, raw).iterations <= 1
    rng = np.random.default_rng(1)
    for traction in (rng.normal(size=raw.traction.shape), np.full(raw.traction.shape, np.nan), -raw.traction):
        again = newton_tangential(problem, SETTINGS, dataclasses.replace(raw, traction=traction))
        assert again.solved
        np.testing.assert_allclose(again.traction, raw.traction, rtol=0, atol=1e-7 * problem.bound.max())


def test_start_of_another_grid_is_refused(tangential_problem):
    problem, other = tangential_problem(0), tangential_problem(4)
    start = RawSolution(np.zeros_like(other.rigid_shift), np.zeros(2), 0, "")
    size = problem.size
    with pytest.raises(SceneError, match=rf"start\.traction has shape .*; it must be of shape \(2, {size}\)"):
        newton_tangential(problem, SETTINGS, start)
    with pytest.raises(SceneError, match=r"start\.rigid has shape .*; it must be of shape \(2,\), as the problem has"):
        newton_tangential(problem, SETTINGS, RawSolution(np.zeros_like(problem.rigid_shift), np.zeros(1), 0, ""))


@pytest.mark.parametrize("carried", [0.0, 0.5])
def test_wrong_linear_solves_do_not_lead_astray(tangential_problem, monkeypatch, carried):
    """Four steps of five are noise: the line search and Tseng's steps bring it to the tolerance all the same."""
    problem, exact, calls = tangential_problem(0, carried=carried, rolling=True, step=1.0), driver.gcr, []
    rng = np.random.default_rng(0)

    def wrong(system, forces, lacking, enough):
        step = exact(system, forces, lacking, enough)
        calls.append(len(calls) % 5 == 4)
        if calls[-1]:
            return step
        noise = 10.0 * rng.normal(size=system.right.shape) * system.conditions.contact
        return dataclasses.replace(step, traction=noise, shift=system.product(noise.astype(np.float32)).astype(float))

    monkeypatch.setattr(driver, "gcr", wrong)
    raw = newton_tangential(problem, SETTINGS)
    assert (raw.solver, raw.status) == ("", "Solved")
    assert calls.count(False) > 4
    monkeypatch.undo()
    check_exact(problem, raw)


def lost(system, forces, lacking, enough):
    """A linear solve that is nothing but noise."""
    step = 1e3 * np.random.default_rng(0).normal(size=system.right.shape) * system.conditions.contact
    return Step(step, system.product(step.astype(np.float32)), np.zeros((2, 1, 1)), 1)


def test_without_a_right_linear_solve(tangential_problem, monkeypatch):
    """Tseng's steps alone come to the tolerance on a small problem; without them active sets are asked, if few enough.

    Where they are not asked what there is comes back as what it is.
    """
    problem = tangential_problem(0, carried=0.0, rolling=True, step=1.0)
    monkeypatch.setattr(driver, "gcr", lost)
    settings = Settings(1e-8)
    raw = newton_tangential(problem, settings)
    assert (raw.solver, raw.status) == ("", "Solved")
    assert settings.stats.calls[""]["tseng"].count > 1 and set(settings.stats.calls[""]) == {"tseng"}
    check_exact(problem, raw)

    monkeypatch.setattr(driver, "forward_backward_forward", lambda at, *_: at)
    raw = newton_tangential(problem, SETTINGS)
    assert (raw.solver, raw.status) == ("tang-safeguarded", "Solved")
    assert raw.reason == "newton missed the tolerance, tang-safeguarded was used"
    check_exact(problem, raw)

    monkeypatch.setattr(driver, "DENSE", 0)
    raw = newton_tangential(problem, SETTINGS)
    assert raw.status == "MaxIterations" and not raw.solved
    assert tangential_residual(problem, raw.traction, raw.rigid) > SETTINGS.tol


def test_no_number_is_an_answer(tangential_problem, rolling, monkeypatch):
    """NaN in the data, in one linear solve, and in all products: named, or overcome, never returned."""
    problem = tangential_problem(0, carried=0.0, rolling=True, step=1.0)
    shift = problem.rigid_shift.copy()
    shift[0, 3] = np.nan
    raw = newton_tangential(dataclasses.replace(problem, rigid_shift=shift), SETTINGS)
    assert raw.status == "NotANumber" and not raw.solved
    assert np.isfinite(raw.traction).all()

    exact, calls = driver.gcr, []

    def once(*arguments):
        calls.append(1)
        step = exact(*arguments)
        return dataclasses.replace(step, traction=step.traction * np.nan) if len(calls) == 3 else step

    monkeypatch.setattr(driver, "gcr", once)
    raw = newton_tangential(problem, SETTINGS)
    assert raw.status == "Solved" and len(calls) > 3
    monkeypatch.undo()
    check_exact(problem, raw)

    monkeypatch.setattr(GridOperator, "apply", lambda self, tractions: np.full(tractions.shape, np.nan))
    monkeypatch.setattr(driver, "DENSE", 0)
    with pytest.raises(NotConverged, match="newton says 'NotANumber'"):
        vc.solve(rolling(), tangential="newton")


NO_MATRIX = {
    "steady": {},
    "steady, force": {"motion": vc.Steady(Fx=-0.15, vy=0.02, spin=0.05)},
    "mirrored": {"motion": vc.Steady(vx=0.05)},
    "shift": {"motion": vc.Shift(ux=0.1, uy=-0.06, rotation=0.05)},
    "no slip": {"friction": np.inf},
    "history": {"motion": vc.Transient(steps=2, vx=0.05)},
}


@pytest.mark.parametrize("name", NO_MATRIX)
def test_forms_no_matrix(rolling, monkeypatch, name):
    """Neither for normal nor tangential problem, nor for their certificate."""

    def refuse(*_):
        raise AssertionError("a dense matrix was assembled")

    monkeypatch.setattr(GridOperator, "dense", refuse)
    monkeypatch.setattr("varcontact.discrete.positive_definite.DENSE_LIMIT", 0)
    scene = rolling(grid=vc.Grid(nx=26, ny=25), **NO_MATRIX[name])
    found = vc.solve(scene, normal="newton", tangential="newton")
    for sol in found if name == "history" else [found]:
        assert sol.status == {"normal": "Solved", "tangential": "Solved"}
        assert sol.certificate.residual <= 1e-8
        assert sol.certificate.relative_gap <= 1e-8


@pytest.mark.parametrize(("motion", "products"), [(vc.Steady(vx=0.08, vy=0.08, spin=0.1), 35), (vc.Shift(ux=0.2), 35)])
def test_products_on_the_finest_grid(rolling, monkeypatch, motion, products):
    """They are what the solution costs, and hardly grow with the elements: 3228 of them here."""
    counted, product = [], Kernel.__call__

    def count(self, traction):
        counted.append(self.shape)
        return product(self, traction)

    monkeypatch.setattr(Kernel, "__call__", count)
    sol = vc.solve(rolling(motion=motion, grid=vc.Grid(nx=64, ny=64)), tangential="newton")
    assert sol.elements["contact"] == 3228
    assert counted.count((64, 64)) <= products
    assert set(counted) == {(64, 64), (32, 32), (16, 16)}


@pytest.mark.parametrize("strips", [300, 1024, 4096])
def test_many_strips_need_no_active_sets(strips):
    """A shift by a force in line contact, from coarse lattices: Cattaneo's stick area."""
    limit = 0.3 * 0.01
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Cylinders(R=1.0),
        normal_force=0.01,
        friction=0.3,
        motion=vc.Shift(Fx=-0.5 * limit),
        grid=vc.Grid(nx=strips),
    )
    sol = vc.solve(scene, tangential="newton", certify="none")
    calls = sol.calls["tangential"]
    assert set(calls) <= {"newton", "tseng"} and calls["newton"].iterations <= 40
    assert sol.areas["stick"] / sol.areas["contact"] == pytest.approx(np.sqrt(0.5), abs=2.5 / strips)
