"""Newton's method without a matrix: the dense answers, on any problem, from anywhere."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.residuals import gap, normal_gap, normal_residual, tangential_residual
from varcontact.elasticity.operators import GridOperator
from varcontact.errors import NotConverged
from varcontact.interfaces.potential import Potential
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import tang_safeguarded
from varcontact.solvers.interface import Settings, natural_residual
from varcontact.solvers.newton import driver
from varcontact.solvers.newton.gcr import Forces, System, gcr, room_for
from varcontact.solvers.newton.kernel import Kernel
from varcontact.solvers.newton.normal import newton_normal
from varcontact.solvers.newton.tangential import newton_tangential

SETTINGS = Settings(1e-8)


def newton(problem, start=None, settings=SETTINGS):
    method = newton_normal if isinstance(problem, NormalProblem) else newton_tangential
    return method(problem, settings, start)


def check_exact(problem, raw):
    """Solved to the tolerance by residual and gap, admissible, and equal to the dense answer."""
    assert raw.solved, raw.status
    if isinstance(problem, NormalProblem):
        dense = norm(problem)
        dense = dense if dense.solved else norm(problem, exchange="one")
        residual, off, scale = (
            normal_residual,
            normal_gap(problem, raw.traction, raw.rigid)[1],
            dense.traction.max(),
        )
        assert raw.traction.min() >= 0
        np.testing.assert_allclose(raw.rigid, dense.rigid, rtol=1e-7)
    else:
        dense, finite = tang_safeguarded(problem), np.isfinite(problem.bound).all()
        scale = problem.bound.max() if finite else np.abs(dense.traction).max()
        residual, off = (
            tangential_residual,
            gap(problem, raw.traction, raw.rigid)[1] if finite else 0.0,
        )
        assert np.all(np.linalg.norm(raw.traction, axis=0) <= problem.bound * (1 + 1e-12))
    assert residual(problem, raw.traction, raw.rigid) <= SETTINGS.tol and off <= SETTINGS.tol
    np.testing.assert_allclose(raw.traction, dense.traction, rtol=0, atol=1e-7 * scale)


@pytest.fixture(params=["normal", "tangential"])
def problem(request, normal_problem, tangential_problem):
    """One of each kind, which Newton's method solves from coarse grids."""
    if request.param == "normal":
        return normal_problem(1)
    return tangential_problem(17, shape="levels", carried=0.0)


@pytest.mark.long
@pytest.mark.parametrize("seeds", [range(first, first + 9) for first in range(0, 63, 9)])
def test_equals_the_dense_answer(tangential_problem, seeds):
    """On random problems, each batch with every shape; the 34th and the 60th alone stay unsolved,
    and splitting solves them (tests/solvers/test_splitting.py).
    """
    for seed in seeds:
        problem = tangential_problem(seed)
        raw = newton(problem)
        assert raw.status == ("MaxIterations" if seed in (34, 60) else "Solved"), seed
        if raw.solved:
            check_exact(problem, raw)


@pytest.mark.long
@pytest.mark.parametrize("line", [False, True])
def test_equals_norm(normal_problem, line):
    """On random surfaces, smooth and rough, by force and by approach."""
    for seed in range(20):
        problem = normal_problem(seed, line)
        raw = newton(problem)
        assert (raw.solver, raw.status) == ("", "Solved"), seed
        check_exact(problem, raw)


@pytest.mark.parametrize("seed", [3, 5])
def test_softened_elements_under_a_force(tangential_problem, seed):
    """Elements give way beside what the bodies do, each its own, as some at the edge of contacts."""
    problem = tangential_problem(seed, shape="ellipse", carried=0.5, friction=0.3)
    own = problem.operator.matrix[0, 0]
    factors = np.random.default_rng(seed).uniform(0.0, 3.0, problem.size)
    softening = np.tile(own * factors, (problem.components, 1))
    soft = dataclasses.replace(
        problem, operator=dataclasses.replace(problem.operator, softening=softening)
    )
    raw = newton(soft)
    assert (raw.solver, raw.status) == ("", "Solved")
    check_exact(soft, raw)
    np.testing.assert_allclose(
        [raw.traction[i].sum() * soft.area for i in soft.free],
        [F for F in soft.force if F is not None],
        rtol=1e-7,
    )


@pytest.mark.parametrize("power", [-200, -50, 50, 200])
def test_units_do_not_matter(normal_problem, tangential_problem, power):
    """By powers of two: the same numbers, far below and beyond single precision."""
    for problem in (normal_problem(7), tangential_problem(3, shape="levels", carried=0.3)):
        raw, unit, given = newton(problem), 2.0**power, {}
        for name in ("distance", "force", "approach", "rigid_shift"):
            value = getattr(problem, name, None)
            if isinstance(value, tuple):
                given[name] = tuple(None if F is None else F * unit for F in value)
            elif value is not None:
                given[name] = value * unit
        if isinstance(problem, TangentialProblem):
            given["potential"] = Potential(problem.bound * unit)
        scaled = newton(dataclasses.replace(problem, **given))
        np.testing.assert_array_equal(scaled.traction / unit, raw.traction)
        assert (scaled.status, scaled.iterations) == (raw.status, raw.iterations)


def test_small_problems_are_solved_beyond_the_tolerance(problem):
    """To rounding, by a last step that is more exact or by further ones."""
    loose = newton(problem, settings=dataclasses.replace(SETTINGS, loose_tolerance=True))
    refined = newton(problem)
    assert natural_residual(problem, refined) < 0.1 * natural_residual(problem, loose)
    assert refined.iterations >= loose.iterations


@pytest.mark.parametrize(
    ("motion", "steps"),
    [(vc.Steady(vx=4e-3, vy=1e-3, spin=2e-3), 9), (vc.Shift(ux=5e-3, uy=2e-3), 11)],
)
def test_no_step_is_spent_on_rounding(motion, steps):
    """With E in single precision where a step is to leave less than its error two more are taken:
    Kalker's spheres of figure 36, 812 elements.
    """
    surface = vc.Paraboloids(Rx=168.75, Ry=168.75)
    scene = make_scene(surface, 0.4705, motion, vc.Grid(nx=32, ny=32), friction=0.4013)
    assert vc.solve(scene).iterations["tangential"] <= steps


def test_from_any_start(problem):
    """A start that is the answer costs one step; one that is noise, or no number at all, leads
    there, too.
    """
    raw = newton(problem)
    assert newton(problem, raw).iterations <= 1
    noise = np.random.default_rng(0).normal(size=raw.traction.shape)
    for traction in (noise, 0 * noise, noise * np.nan, -raw.traction):
        again = newton(problem, dataclasses.replace(raw, traction=traction))
        assert again.solved
        np.testing.assert_allclose(
            again.traction, raw.traction, rtol=0, atol=1e-7 * np.abs(raw.traction).max()
        )


def test_where_nothing_touches(normal_problem):
    problem = normal_problem(1)
    apart = dataclasses.replace(problem, force=None, approach=float(problem.distance.min()))
    raw = newton(apart)
    assert raw.solved and not raw.traction.any() and raw.rigid[0] == apart.approach


def astray(monkeypatch, good, size):
    """All linear solves but every `good`th give noise of that size; which were right is
    returned.
    """
    exact, right, rng = driver.gcr, [], np.random.default_rng(0)

    def gcr(system, *rest):
        step = exact(system, *rest)
        right.append(len(right) % good == good - 1)
        if right[-1]:
            return step
        noise = size * rng.normal(size=system.right.shape)
        noise *= system.conditions.contact
        return dataclasses.replace(
            step,
            traction=noise,
            shift=system.conditions.kernel(noise.astype(np.float32)).astype(float),
        )

    monkeypatch.setattr(driver, "gcr", gcr)
    return right


@pytest.mark.parametrize(
    ("kind", "good", "carried"), [("normal", 2, 0), ("tangential", 2, 0), ("tangential", 2, 0.5)]
)
def test_wrong_linear_solves_do_not_lead_astray(
    normal_problem, tangential_problem, monkeypatch, kind, good, carried
):
    """The line search brings it to the tolerance all the same."""
    rolling = {"carried": float(carried), "rolling": True, "step": 1.0}
    problem = normal_problem(1) if kind == "normal" else tangential_problem(0, **rolling)
    right = astray(monkeypatch, good, 10.0)
    raw = newton(problem)
    assert (raw.solver, raw.status) == ("", "Solved")
    assert right.count(False) > 4
    monkeypatch.undo()
    check_exact(problem, raw)


def test_without_a_right_linear_solve(normal_problem, tangential_problem, monkeypatch):
    """What there is comes back as what it is."""
    problem = tangential_problem(0, carried=0.0, rolling=True, step=1.0)
    astray(monkeypatch, 10**9, 1e3)
    for posed in (problem, normal_problem(1)):
        raw = newton(posed)
        assert raw.status == "MaxIterations" and not raw.solved
        assert natural_residual(posed, raw) > SETTINGS.tol


def test_no_number_is_an_answer(problem, rolling, monkeypatch):
    """NaN in the data, in one linear solve, and in all products: named, or overcome, never
    returned.
    """
    field = "distance" if isinstance(problem, NormalProblem) else "rigid_shift"
    values = getattr(problem, field).copy()
    values[..., 2] = np.nan
    raw = newton(dataclasses.replace(problem, **{field: values}))
    assert raw.status == "NotANumber" and not raw.solved
    assert np.isfinite(raw.traction).all()

    exact, calls = driver.gcr, []

    def once(*arguments):
        calls.append(1)
        step = exact(*arguments)
        return (
            dataclasses.replace(step, traction=step.traction * np.nan) if len(calls) == 3 else step
        )

    monkeypatch.setattr(driver, "gcr", once)
    raw = newton(problem)
    assert raw.status == "Solved" and len(calls) > 3
    monkeypatch.undo()
    check_exact(problem, raw)

    monkeypatch.setattr(
        GridOperator, "apply", lambda self, tractions: np.full(tractions.shape, np.nan)
    )
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


@pytest.mark.parametrize(
    ("motion", "products", "coarser"),
    [
        (vc.Steady(vx=0.08, vy=0.08, spin=0.1), 35, {(32, 32), (16, 16)}),
        (vc.Shift(ux=0.2), 20, set()),
    ],
)
def test_products_on_the_finest_grid(rolling, monkeypatch, motion, products, coarser):
    """They are what the solution costs, and hardly grow with the elements: 3228 of them here. What
    slides all over needs no coarser grids.
    """
    counted, product = [], Kernel.__call__

    def count(self, traction):
        counted.append(self.shape)
        return product(self, traction)

    monkeypatch.setattr(Kernel, "__call__", count)
    sol = vc.solve(rolling(motion=motion, grid=vc.Grid(nx=64, ny=64)), tangential="newton")
    assert sol.elements["contact"] == 3228
    assert counted.count((64, 64)) <= products
    assert set(counted) == {(64, 64), *coarser}


class _WithoutResistance(System):
    """Equations of which a uniform shift hardly changes any force, as where all slips."""

    def rows(self, image, step):
        return step

    def border(self, component):
        return np.ones(self.right.shape, np.float32)

    def precondition(self, right):
        return 1e-30 * right if np.ptp(right) == 0 else right


@pytest.mark.filterwarnings("error")
def test_a_shift_beyond_single_precision_is_no_step():
    """The forces that lack need one of 1e30: there is no direction, and no overflow."""
    right = np.linspace(1.0, 2.0, 12, dtype=np.float32).reshape(1, 3, 4)
    forces = Forces((0,), np.array([1.0]), 1.0)
    room = room_for(right.size, forces)
    lacking = np.array([1e10])
    step = gcr(_WithoutResistance(right), lambda x: x, forces, lacking, 1e-3, room)
    assert step.finite
    assert not step.traction.any()


def test_a_shift_that_sticks_in_part_does_not_begin_with_sliding():
    """Of 51 468 elements: rigid shifts exceed what elements give way by themselves, and from
    tractions that slide Newton's method did not converge.
    """
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Paraboloids(Rx=168.75, Ry=168.75),
        normal_force=0.4705,
        friction=0.4013,
        motion=vc.Shift(ux=5e-3, uy=2e-3),
        grid=vc.Grid(nx=256, ny=256),
    )
    sol = vc.solve(scene)
    assert sol.calls["tangential"].keys() == {"newton"}
    assert sol.iterations["tangential"] < 40
    assert min(sol.elements["stick"], sol.elements["slip"]) > 0.1 * sol.elements["contact"]
