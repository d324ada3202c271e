"""The certificate: computed from our own data, positive, and never wrong."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.scenes import refused
from varcontact.discrete.certificate import certificate_of, force_bound
from varcontact.discrete.contact_grid import PotentialContact
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.residuals import gap, normal_gap, normal_residual, tangential_residual
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import ContactResponse
from varcontact.interfaces.potential import project
from varcontact.solvers.active_set.norm import norm

MOTIONS = {
    "rolling": vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
    "spin": vc.Steady(spin=0.3),
    "shift": vc.Shift(ux=0.1, uy=0.05, rotation=0.1),
}
STILL = np.zeros(2)


@pytest.fixture(scope="module", params=MOTIONS)
def solved(request, rolling):
    """A solution, its dimensionless tangential problem, and its tractions there."""
    scene = rolling(motion=MOTIONS[request.param])
    sol = vc.solve(scene)
    disc = discretise(scene, sol.grid)
    problem = disc.tangential_problem(sol.pressure / disc.scales.pressure)
    traction = sol.traction.reshape(2, -1)[:, problem.operator.elements] / disc.scales.pressure
    return sol, problem, traction


def test_solution_closes_the_gap(solved):
    sol, problem, traction = solved
    absolute, relative = gap(problem, traction, STILL)
    assert 0 <= relative < 1e-12
    assert tangential_residual(problem, traction, STILL) < 1e-12
    assert sol.certificate.relative_gap == pytest.approx(relative, abs=1e-15)
    assert absolute >= 0


def test_gap_by_its_definition(solved):
    """p'(M p + W) + sum g |M p + W|, with the dense matrix instead of the FFT."""
    _, problem, traction = solved
    p = 0.7 * traction
    shift = (problem.operator.matrix @ p.ravel()).reshape(2, -1) + problem.rigid_shift
    expected = problem.area * (np.sum(p * shift) + problem.bound @ np.hypot(*shift))
    assert gap(problem, p, STILL)[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.long
@settings(max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), size=st.floats(-8, 0.5))
def test_gap_is_positive_and_bounds_the_error(solved, seed, size):
    """For any admissible tractions: gap > 0, (p - p*)'S(p - p*) <= gap, and the force within its
    bound.
    """
    sol, problem, exact = solved
    noise = np.random.default_rng(seed).normal(size=exact.shape)
    traction = project(exact + 10**size * problem.bound * noise, problem.bound)
    absolute, _ = gap(problem, traction, STILL)
    error = traction - exact
    energy = problem.area * np.sum(error * problem.operator.apply(error))
    assert absolute > 0
    assert energy <= absolute * (1 + 1e-9) + 1e-18
    field = np.zeros((2, sol.grid.nx * sol.grid.ny))
    field[:, problem.operator.elements] = traction * sol.scene.hertz.peak_pressure
    field = field.reshape(sol.traction.shape)
    certificate = vc.certify(sol.scene, field)
    x, y = sol.grid.x[None, :], sol.grid.y[:, None]
    change = field - sol.traction
    errors = [change[0].sum(), change[1].sum(), (x * change[1] - y * change[0]).sum()]
    assert np.all(np.abs(errors) * sol.grid.area <= certificate.force_bound * (1 + 1e-9) + 1e-15)


def test_bound_holds_for_inadmissible_tractions(solved):
    sol, _, _ = solved
    field = 1.1 * sol.traction
    certificate = vc.certify(sol.scene, field)
    assert np.all(
        np.abs((field - sol.traction).sum(axis=(1, 2))) * sol.grid.area
        <= certificate.force_bound[:2]
    )
    assert certificate.residual > 0.01


def test_force_bound_dense_and_by_fft_agree(rolling, monkeypatch):
    sol = vc.solve(rolling())
    dense = vc.certify(sol.scene, 0.9 * sol.traction)
    monkeypatch.setattr("varcontact.discrete.positive_definite.DENSE_LIMIT", 0)
    by_fft = vc.certify(sol.scene, 0.9 * sol.traction)
    np.testing.assert_allclose(by_fft.force_bound, dense.force_bound, rtol=1e-3)
    assert np.all(by_fft.force_bound >= dense.force_bound), "never less than the exact bound"


@pytest.mark.long
def test_large_grid_needs_no_dense_matrix(rolling, monkeypatch):
    """The certificate of given tractions, and normal contact with Hertz's pressure, on many
    elements.
    """

    def refuse(*_):
        raise AssertionError("a dense matrix was assembled")

    monkeypatch.setattr("varcontact.elasticity.operators.GridOperator.dense", refuse)
    grid = vc.Grid(nx=96, ny=96)
    sol = vc.solve(rolling(motion=None, friction=None, grid=grid))
    assert sol.certificate.normal_relative_gap < 1e-3
    scene = rolling(grid=grid)
    bound = 0.3 * sol.pressure
    certificate = vc.certify(scene, np.array([-0.5 * bound, 0.1 * bound]))
    assert 0 < certificate.relative_gap < 1
    assert np.all(np.isfinite(certificate.force_bound))


def test_a_missing_normal_force_is_residual(rolling):
    """Pressures that close the gap at half of the approach: all conditions hold, but for the
    prescribed force.
    """
    scene = rolling(motion=None, friction=None)
    sol = vc.solve(scene, normal="clarabel")
    disc = discretise(scene, sol.grid)
    problem, level = (
        disc.normal_problem(),
        (sol.approach - disc.base) / disc.scales.displacement / 2,
    )
    half = norm(dataclasses.replace(problem, force=None, approach=level))
    lacking = 1 - half.traction.sum() * problem.area / problem.force
    assert lacking > 0.3
    assert normal_residual(problem, half.traction, half.rigid) == pytest.approx(lacking, rel=1e-9)


@pytest.mark.parametrize("load", ["force", "approach"])
def test_normal_gap(rolling, load):
    """Zero at the solution, positive beside it, and a bound on the energy of the error."""
    scene = rolling(motion=None, friction=None)
    if load == "approach":
        scene = dataclasses.replace(scene, normal_force=None, approach=0.3)
    sol = vc.solve(scene, normal="clarabel")
    disc = discretise(scene, sol.grid)
    problem = disc.normal_problem()
    exact = sol.pressure.ravel() / disc.scales.pressure
    level = np.array([(sol.approach - disc.base) / disc.scales.displacement])
    assert normal_residual(problem, exact, level) < 1e-12
    assert normal_gap(problem, exact, level)[1] < 1e-12
    random = np.random.default_rng(3)
    for size in (1e-6, 1e-2, 0.5):
        pressure = np.maximum(exact + size * random.normal(size=exact.size) * (exact > 0), 0)
        if load == "force":
            pressure *= exact.sum() / pressure.sum()
        error = pressure - exact
        energy = problem.area * error @ problem.operator.apply(error[None])[0]
        assert 0 < energy <= normal_gap(problem, pressure, level)[0]
        assert normal_residual(problem, pressure, level) > 1e-2 * size


def test_normal_gap_counts_overlap_without_pressure(rolling):
    """Of no pressure at a given approach: bodies overlap, and the error is the whole pressure."""
    scene = rolling(motion=None, friction=None, normal_force=None, approach=0.3)
    sol = vc.solve(scene)
    disc = discretise(scene, sol.grid)
    problem = disc.normal_problem()
    exact = sol.pressure.ravel() / disc.scales.pressure
    level = np.array([problem.approach])
    energy = problem.area * exact @ problem.operator.apply(exact[None])[0]
    assert 0 < energy <= normal_gap(problem, 0 * exact, level)[0]


def test_no_slip_certificate(rolling):
    """With infinite friction the gap is E'S^-1 E; it bounds the error as well."""
    sol = vc.solve(rolling(friction=np.inf))
    assert sol.certificate.relative_gap < 1e-20
    assert sol.certificate.residual < 1e-12
    field = sol.traction * (1 + 0.01 * np.random.default_rng(5).normal(size=sol.traction.shape))
    certificate = vc.certify(sol.scene, field)
    assert certificate.relative_gap > 1e-8
    assert np.all(
        np.abs((field - sol.traction).sum(axis=(1, 2))) * sol.grid.area
        <= certificate.force_bound[:2]
    )


@pytest.mark.parametrize(("changes", "traction", "field"), [
    ({"motion": None}, np.zeros((2, 14, 14)), "motion"),
    ({"motion": vc.Steady(Fx=0.1)}, np.zeros((2, 14, 14)), "motion"),
    ({}, np.zeros((2, 3, 3)), "traction"),
    ({}, np.full((2, 14, 14), np.nan), "traction[0, 0, 0]"),
])  # fmt: skip
def test_certify_refuses(rolling, changes, traction, field):
    refused(lambda: vc.certify(rolling(**changes), traction), field)


def test_certify_given_pressure(rolling):
    """Pressures and tractions from outside: the solver's own pass, others do not."""
    scene = rolling(grid=vc.Grid(nx=12, ny=12, dx=0.2, dy=0.15, x0=-1.2, y0=-0.9))
    sol = vc.solve(scene, normal="clarabel")
    certificate = vc.certify(scene, sol.traction, sol.pressure)
    assert certificate.residual < 1e-10
    assert vc.certify(scene, sol.traction, 1.01 * sol.pressure).normal_residual > 1e-3
    with pytest.raises(vc.SceneError, match="pressure"):
        vc.certify(scene, sol.traction, sol.pressure[:3])


# -------------------------------------------------------------------- what must never pass as exact

LATTICE = vc.Grid(nx=12, ny=12, dx=0.2, dy=0.15, x0=-1.2, y0=-0.9)


def test_traction_outside_the_contact_counts_as_error(rolling):
    """A traction where no pressure can carry it: all of it is error, of the residual and of force
    and moment.
    """
    sol = vc.solve(rolling())
    field = sol.traction.copy()
    field[0, 0, 0] = 0.5 * np.abs(sol.traction).max()
    assert sol.pressure[0, 0] == 0
    certificate = vc.certify(sol.scene, field)
    added = field[0, 0, 0] * sol.grid.area
    assert certificate.residual >= 0.4
    assert certificate.tangential_residual >= 0.4
    assert certificate.force_bound[0] >= added
    assert certificate.force_bound[2] >= added * abs(sol.grid.y[0])
    assert certificate.force_bound[1] < 1e-3 * added, "nothing was added along y"


@pytest.mark.parametrize("part", ["all", "half"])
def test_traction_on_elements_without_friction_counts_as_error(rolling, part):
    """The tractions of a solution with friction, judged where all or half of the contact has
    none.
    """
    sol = vc.solve(rolling(grid=LATTICE), normal="clarabel")
    friction = np.zeros((12, 12))
    if part == "half":
        friction[:, 6:] = 0.3
    scene = rolling(grid=LATTICE, friction=friction)
    certificate = vc.certify(scene, sol.traction, sol.pressure)
    assert certificate.residual > 0.9
    right = vc.solve(scene, normal="clarabel")
    errors = np.abs((sol.traction - right.traction).sum(axis=(1, 2))) * sol.grid.area
    assert np.all(errors <= certificate.force_bound[:2] * (1 + 1e-9))
    assert np.all(errors > 0)


@pytest.mark.parametrize(
    "change", [lambda p: -p, lambda p: 0 * p, lambda p: np.where(p == p.max(), -1e-3, p)]
)
def test_pressures_that_pull_or_vanish_are_refused(rolling, change):
    sol = vc.solve(rolling(grid=LATTICE), normal="clarabel")
    refused(
        lambda: vc.certify(sol.scene, sol.traction, change(sol.pressure)),
        "pressure",
        match="positive somewhere",
    )


@pytest.mark.parametrize("dense_limit", [10_000, 0])
def test_no_force_bound_where_the_symmetric_part_is_not_positive_definite(
    rolling, monkeypatch, dense_limit
):
    """By Cholesky factor and by conjugate gradients: infinite, neither a number made up nor a
    crash.
    """
    monkeypatch.setattr("varcontact.discrete.positive_definite.DENSE_LIMIT", dense_limit)
    a, b = np.sqrt(5), 1 / np.sqrt(5)
    motion = vc.Steady(vx=0.04, vy=-0.02, spin=0.05, dq=0.2 * a / 5)
    scene = rolling(surface=vc.Ellipse(a=a, b=b), motion=motion, grid=vc.Grid(nx=10, ny=10))
    grid = PotentialContact.of(scene).known
    pressure = scene.hertz.pressure(grid.x[None, :], grid.y[:, None])
    for field in (-0.2 * np.array([pressure, 0 * pressure]), np.zeros((2, *grid.shape))):
        certificate = vc.certify(scene, field)
        assert np.all(np.isposinf(certificate.force_bound))
        assert np.isfinite(certificate.residual)


def test_no_force_bound_even_where_the_gap_is_zero(rolling):
    """Full slip, the gap as good as zero: it says nothing where S is not positive definite, and
    must read infinite.
    """
    motion = vc.Steady(vx=1e6, dq=0.1 * np.sqrt(5) / 5)
    scene = rolling(
        surface=vc.Ellipse(a=np.sqrt(5), b=1 / np.sqrt(5)),
        motion=motion,
        grid=vc.Grid(nx=10, ny=10),
    )
    grid = PotentialContact.of(scene).known
    disc = discretise(scene, grid)
    problem = disc.tangential_problem(
        scene.hertz.pressure(grid.x[None, :], grid.y[:, None]) / disc.scales.pressure
    )
    opposed = np.array([-problem.bound, 0 * problem.bound])
    rigid_only = dataclasses.replace(problem, rigid_shift=1e30 * np.sign(problem.rigid_shift))
    assert gap(rigid_only, opposed, STILL)[0] < 1e-30
    assert np.all(np.isposinf(force_bound(rigid_only, opposed, STILL)))


def test_no_number_is_no_small_residual(rolling):
    """NaN in tractions or pressures stays NaN in every residual: compared with a tolerance it never
    passes.
    """
    scene = rolling()
    sol = vc.solve(scene)
    disc = discretise(scene, sol.grid)
    pressure = sol.pressure / disc.scales.pressure
    tangential, normal = disc.tangential_problem(pressure), disc.normal_problem()
    for traction in (
        np.full((2, tangential.size), np.nan),
        np.where(np.arange(tangential.size) == 3, np.nan, 0.01),
    ):
        assert np.isnan(
            tangential_residual(tangential, np.broadcast_to(traction, (2, tangential.size)), STILL)
        )
    assert np.isnan(normal_residual(normal, np.full(normal.distance.size, np.nan), np.zeros(1)))
    for bad in (
        np.full_like(sol.traction, np.nan),
        np.where(np.isclose(sol.pressure, sol.pressure.max()), np.nan, 0),
    ):
        bad = np.broadcast_to(bad, sol.traction.shape)
        certificate = certificate_of(
            ContactResponse(disc, ContactState(pressure, 0.0, bad, STILL)), True
        )
        assert not certificate.residual <= 1.0
        assert not certificate.tangential_residual <= 1.0
