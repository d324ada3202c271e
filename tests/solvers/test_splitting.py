"""Projection and contraction: its theorem, and the answers of active sets from any start."""

import dataclasses
import tracemalloc

import numpy as np
import pytest

import varcontact as vc
from tests.benchmarks.splitting import problems
from tests.scenes import make_scene
from tests.solving.test_conformal import uneven
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import NormalProblem, RawSolution, mirror_of
from varcontact.discrete.residuals import gap, normal_gap
from varcontact.interfaces.potential import Flow, Potential
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import tang_safeguarded
from varcontact.solvers.interface import Settings, natural_residual
from varcontact.solvers.newton.gcr import Forces
from varcontact.solvers.newton.normal import ScaledNormal
from varcontact.solvers.newton.tangential import ScaledTangential
from varcontact.solvers.registry import BYTES_SPLITTING
from varcontact.solvers.splitting import method
from varcontact.solvers.splitting.inequality import Inequality
from varcontact.solvers.splitting.method import splitting_normal, splitting_tangential
from varcontact.solvers.splitting.projection import PrescribedSums

TOL = 1e-9
SETTINGS = Settings(TOL)


def split(problem, start=None, settings=SETTINGS):
    by_kind = splitting_normal if isinstance(problem, NormalProblem) else splitting_tangential
    return by_kind(problem, settings, start)


def exact(problem):
    """The answer of active sets."""
    if not isinstance(problem, NormalProblem):
        return tang_safeguarded(problem)
    by_sets = norm(problem)
    return by_sets if by_sets.solved else norm(problem, exchange="one")


def check(problem, raw, atol=1e-7):
    """Solved by our own residual and gap, and equal to active sets."""
    assert (raw.status, raw.solved) == ("Solved", True)
    assert natural_residual(problem, raw) <= TOL
    of_gap = normal_gap if isinstance(problem, NormalProblem) else gap
    if np.isfinite(getattr(problem, "bound", 0.0)).all():
        assert of_gap(problem, raw.traction, raw.rigid)[1] <= TOL
    other = exact(problem)
    scale = np.abs(other.traction).max()
    np.testing.assert_allclose(raw.traction, other.traction, rtol=0, atol=atol * scale)


def ellipse(problem, **changes):
    return problem(5, shape="ellipse", friction=0.3, carried=0.0, **changes)


# ------------------------------------------------------------------------------------- the theorem


@pytest.fixture(scope="module")
def rolling_problem(tangential_problem):
    """Tractions of rolling, whose matrix is not symmetric, with a prescribed force."""
    return tangential_problem(5, shape="ellipse", friction=0.3, carried=0.3, rolling=True, step=1.0)


@pytest.fixture(scope="module")
def inequality(rolling_problem):
    """The inequality, its matrix of fields, and its solution."""
    scaled = ScaledTangential.of(rolling_problem)
    posed = Inequality.of(scaled, symmetric=False)
    at = scaled.initial_guess(tang_safeguarded(rolling_problem))
    posed.choose_gamma(at)
    return posed, posed.in_double_precision(posed.start(at))


def test_every_point_has_a_direction_to_the_solution(inequality):
    """(u - u*)'q is |e|^2 or more, at points near and far: no symmetry is needed."""
    posed, solution = inequality
    rng = np.random.default_rng(0)
    for size in np.geomspace(1e-4, 1e2, 60):
        distance = size * rng.normal(size=solution.u.shape) * posed.conditions.contact
        u = solution.u + distance
        at = posed.iterate(u, posed.product.apply(u), solution.multipliers)
        q = at.error + posed.gamma * posed.product.transposed(at.error)
        assert np.vdot(distance, q) >= (1 - 1e-6) * at.size**2


def test_sums_rise_by_the_slopes_of_the_projection(rolling_problem, normal_problem):
    """Against differences of the sums, of pressures and of tractions: Newton's matrix."""
    pressed = normal_problem(4)
    pressed = dataclasses.replace(pressed, approach=None, force=1.0)
    for scaled in (ScaledNormal.of(pressed), ScaledTangential.of(rolling_problem)):
        conditions = scaled.conditions
        components = len(conditions.known)
        forces = Forces(tuple(range(components)), np.zeros(components), 1.0)
        conditions = dataclasses.replace(conditions, forces=forces)
        trial = np.random.default_rng(2).normal(size=conditions.known.shape)
        trial *= 2 * np.abs(conditions.bound) * conditions.contact
        sums = PrescribedSums(conditions, 0.7, trial)
        slopes = sums._slopes(sums.at(np.zeros(components))) * sums.gamma
        for i, column in enumerate(1e-7 * np.eye(components)):
            change = sums.at(-column).excess - sums.at(column).excess
            np.testing.assert_allclose(slopes[:, i], change / 2e-7, rtol=1e-5, atol=1e-5)


def metric_of(posed):
    """H^-1 as a matrix between the components of elements in contact."""
    contact = np.flatnonzero(
        np.broadcast_to(posed.conditions.contact, posed.conditions.known.shape)
    )
    columns = []
    for place in contact:
        field = np.zeros(posed.conditions.known.size)
        field[place] = 1.0
        image = posed.metric(field.reshape(posed.conditions.known.shape))
        columns.append(image.ravel()[contact])
    return np.array(columns).T, contact


def test_contractions_lead_nearer_in_the_metric(inequality):
    """The metric is symmetric and positive definite; in its norm each contraction is nearer."""
    posed, solution = inequality
    inverse, contact = metric_of(posed)
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-6)
    assert np.linalg.eigvalsh((inverse + inverse.T) / 2).min() > 1e-3
    H = np.linalg.inv(inverse)
    u = solution.u + 10 * np.random.default_rng(1).normal(size=solution.u.shape)
    u *= posed.conditions.contact
    at = posed.iterate(u, posed.product.apply(u), solution.multipliers)
    distances = []
    for _ in range(40):
        difference = (at.u - solution.u).ravel()[contact]
        distances.append(difference @ H @ difference)
        at = method.contraction(posed, at)
    assert np.all(np.diff(distances) < 0)
    assert distances[-1] < 1e-4 * distances[0]


def test_contractions_alone_reach_the_tolerance(rolling_problem, monkeypatch):
    """Without a single accepted candidate: they are the proof."""
    monkeypatch.setattr(method, "ASTRAY", 0.0)
    monkeypatch.setattr(method, "RECORD", 0.0)
    check(rolling_problem, split(rolling_problem))


def test_candidates_that_lead_astray_are_given_up(rolling_problem, monkeypatch):
    """Ten times too long, and turned round: the record rule ends each attempt, contractions do
    the rest.
    """
    calls = []

    def astray(self, point, step):
        calls.append(1)
        return point - 10 * step

    monkeypatch.setattr(method.Extrapolation, "next_point", astray)
    check(rolling_problem, split(rolling_problem))
    assert calls


# -------------------------------------------------------------------------------------- the answers


def test_one_element_in_closed_form(normal_problem, tangential_problem):
    """``p = (d - h)/A``; ``p = -W/M``, no longer than the bound."""
    pressed = normal_problem(1)
    one = pressed.operator.grid_operator.on(pressed.operator.elements[:1])
    pressed = dataclasses.replace(
        pressed, operator=one, distance=np.zeros(1), force=None, approach=0.3
    )
    raw = split(pressed)
    np.testing.assert_allclose(raw.traction, 0.3 / one.diagonal, rtol=1e-9)
    for friction in (0.1, 1e3):
        problem = ellipse(tangential_problem, rolling=False, nu=0.0)
        one = problem.operator.grid_operator.on(problem.operator.elements[:1])
        problem = dataclasses.replace(
            problem,
            operator=one,
            rigid_shift=np.array([[0.3], [-0.4]]),
            potential=Potential(np.array([friction])),
            points=problem.points[:, :1],
        )
        size = min(0.5 / one.diagonal, friction)
        raw = split(problem)
        np.testing.assert_allclose(raw.traction[:, 0], [-0.6 * size, 0.8 * size], rtol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("seeds", [range(9), range(28, 35), range(54, 63)])
def test_tractions_of_random_problems(tangential_problem, seeds):
    """Also those that Newton's method leaves unsolved, 34 and 60."""
    for seed in seeds:
        problem = tangential_problem(seed)
        check(problem, split(problem))


@pytest.mark.long
@pytest.mark.parametrize("line", [False, True])
def test_pressures_of_random_problems(normal_problem, line):
    """Also of elements so few that a candidate is right to single precision by chance: two that
    were taken for records, and then for the best.
    """
    for seed in [*range(20), 3124, 4669]:
        problem = normal_problem(seed, line)
        check(problem, split(problem))


def test_no_slip(tangential_problem):
    for seed in (2, 11):
        problem = tangential_problem(seed, no_slip=True)
        check(problem, split(problem))


@pytest.mark.parametrize("carried", [0.0, 0.5])
def test_a_layer_that_yields(tangential_problem, carried):
    """The proximal map of a flow, free and under a force: the answer of TANG."""
    problem = tangential_problem(5, shape="ellipse", friction=0.6, carried=carried, rolling=True)
    threshold = 0.3 * problem.bound.max()
    flow = Flow(np.full(problem.size, threshold), hardening=0.2)
    problem = dataclasses.replace(problem, potential=Potential(problem.bound, flow))
    raw = split(problem)
    check(problem, raw)
    assert np.linalg.norm(raw.traction, axis=0).max() > 1.01 * threshold


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3, 1e6, 1e60])
def test_from_any_start(rolling_problem, normal_problem, size):
    rng = np.random.default_rng(3)
    for problem in (rolling_problem, normal_problem(4)):
        right = exact(problem)
        off = size * np.abs(right.traction).max() * rng.normal(size=right.traction.shape)
        start = RawSolution(right.traction + off, right.rigid + size * rng.normal(), 0, "start")
        check(problem, split(problem, start))


def test_memory_is_what_a_plan_says():
    problem = dict(problems(48))["shift"]
    unknowns = 2 * problem.operator.elements.size
    split(problem)
    tracemalloc.start()
    split(problem)
    taken = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert 0.5 * BYTES_SPLITTING * unknowns <= taken <= BYTES_SPLITTING * unknowns


@pytest.mark.long
@pytest.mark.parametrize("step", [0.02, 0.01])
def test_steps_far_shorter_than_an_element(tangential_problem, step):
    """Where Newton's method crawls: the symmetric part is nearly singular, yet definite."""
    problem = tangential_problem(
        8, shape="levels", friction=0.3, carried=0.0, rolling=True, step=step, nu=0.28
    )
    assert problem.symmetric_part is not None
    check(problem, split(problem), atol=1e-4)


def test_half_of_a_symmetric_contact(rolling):
    """TANG's half is solved from a start by its folded operator, with its transpose."""
    scene = rolling(motion=vc.Steady(vx=0.05), grid=vc.Grid(nx=10, ny=10))
    sol = vc.solve(scene)
    disc = discretise(scene, sol.grid)
    problem = disc.tangential_problem(sol.pressure / disc.scales.pressure)
    half = mirror_of(problem).fold(problem)
    nothing = RawSolution(np.zeros_like(half.rigid_shift), np.zeros(2), 0, "start")
    check(half, split(half, nothing))


@pytest.mark.parametrize("curved", [False, True])
def test_products_with_the_transpose(curved):
    """Against dense matrices; on a surface whose curvature varies, by harmonics mirrored."""
    scene = make_scene(vc.Ellipse(1.2, 0.9), 1.0, vc.Steady(vx=0.04), vc.Grid(nx=9, ny=8))
    if curved:
        scene = uneven()
    sol = vc.solve(scene)
    operator = discretise(scene, sol.grid).tangential_operator
    elements = np.arange(operator.shape[0] * operator.shape[1])
    if curved:
        elements = elements[::7]
    assert operator.toeplitz != curved
    np.testing.assert_allclose(
        operator.transposed.dense(elements), operator.dense(elements).T, atol=1e-14
    )


def test_the_finest_grid_begins_in_double_precision(monkeypatch):
    """Else errors of single precision are part of a record that nothing can beat."""
    problem = vc.benchmark_problems()["shift, 24 across"].program().contact_problem
    starts = []
    rounds = method.rounds

    def spy(inequality, start, *args):
        starts.append((inequality, start))
        return rounds(inequality, start, *args)

    monkeypatch.setattr(method, "rounds", spy)
    assert split(problem).solved
    inequality, start = starts[-1]
    assert len(starts) > 1, "no coarse grid"
    image = inequality.product.apply(start.u)
    np.testing.assert_allclose(start.image, image, rtol=0, atol=1e-14 * np.abs(image).max())


@pytest.mark.long
@pytest.mark.slow
def test_fifty_thousand_elements(rolling):
    """Sticking nearly all over, where rounds are most: hundreds, not thousands."""
    scene = rolling(motion=vc.Steady(vx=0.02, spin=0.02), grid=vc.Grid(nx=256, ny=256))
    sol = vc.solve(scene, method="convex", certify="none")
    assert sol.certificate.residual <= 1e-8
    assert sol.calls["tangential"]["splitting"].iterations < 800


# ------------------------------------------------------------------------------------- honest ends


def test_the_best_iterate_where_rounds_end(rolling_problem, monkeypatch):
    monkeypatch.setattr(method, "ROUNDS_MAX", 8)
    raw = split(rolling_problem)
    assert (raw.status, raw.solved) == ("MaxRounds", False)
    assert TOL < natural_residual(rolling_problem, raw) < 0.1


def test_no_proof_without_a_definite_symmetric_part(rolling, monkeypatch):
    """Elements ten times as long as wide, steps of a fiftieth, nu = 0.5: it ends, and says so."""
    monkeypatch.setattr(method, "ROUNDS_MAX", 300)
    motion = vc.Steady(vx=0.02, vy=-0.01, spin=0.02, dq=0.02 * 2 / 8)
    scene = rolling(bodies=vc.Bodies(G=1.0, nu=0.5), motion=motion, grid=vc.Grid(nx=8, ny=80))
    with pytest.raises(vc.NotConverged, match="no proof, as the symmetric part is not definite"):
        vc.solve(scene, method="convex")


def test_nothing_is_proved_of_an_answer_without_a_definite_symmetric_part(rolling):
    """It is solved to the residual that is asked for, and report and certificate say what that
    proves.
    """
    motion = vc.Steady(vx=0.1, dq=0.1)
    long = rolling(bodies=vc.Bodies(G=1.0, nu=0.5), motion=motion, grid=vc.Grid(nx=6, ny=60))
    short = rolling(motion=vc.Steady(vx=0.1), grid=vc.Grid(nx=8, ny=8))
    found = [vc.solve(scene, method="convex") for scene in (long, short)]
    assert [each.converged for each in found] == [True, True]
    assert [each.certificate.proved for each in found] == [False, True]
    assert ["nothing is proved" in each.report() for each in found] == [True, False]
    assert "proved to converge wherever the symmetric part is positive definite" in str(found[0])


def test_no_number_is_an_answer(normal_problem, tangential_problem):
    for problem, field in ((normal_problem(1), "distance"), (tangential_problem(5), "rigid_shift")):
        values = getattr(problem, field).copy()
        values[..., 1] = np.nan
        raw = split(dataclasses.replace(problem, **{field: values}))
        assert (raw.status, raw.solved) == ("NotANumber", False)
        assert raw.finite
