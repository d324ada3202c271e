"""Guaranteed bounds: true with the pressure's own error, with forces that are missed, and down to
rounding.
"""

import dataclasses
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.discrete import certificate
from varcontact.discrete.certificate import _rounding, force_bound, pressure_error
from varcontact.discrete.discretisation import discretise
from varcontact.interfaces.potential import project
from varcontact.solvers.active_set.tang import tang_safeguarded

CREEPAGE = {"vx": 0.02, "vy": -0.01, "spin": 0.03}
MOTIONS = {
    "rolling": vc.Steady(**CREEPAGE),
    "slipping": vc.Steady(vx=0.3, vy=0.1),
    "shift": vc.Shift(ux=0.02, uy=0.01),
}


def waves(n=16, **changes):
    """Rolling on a wavy surface: the pressure has to be solved for."""
    grid = vc.Grid(nx=n, ny=n, dx=3.0 / n, dy=2.6 / n, x0=-1.5, y0=-1.3)
    x, y = grid.x[None, :], grid.y[:, None]
    surface = vc.SampledDistance(h=x**2 / 2 + y**2 / 1.6 + 0.05 * np.cos(5 * x), x=grid.x, y=grid.y)
    scene = make_scene(surface, 1.0, MOTIONS["rolling"], grid)
    return dataclasses.replace(scene, **changes)


def off(sol, exact):
    return np.abs([*(sol.force - exact.force), sol.moment - exact.moment])


def best_iterate(scene, **methods):
    """The answer of solvers that are asked for little, converged or not."""
    try:
        return vc.solve(scene, polish=False, **methods)
    except vc.NotConverged as failure:
        return failure.solution


# ------------------------------------------------------------------------- the pressure's own error


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("solver", ["clarabel", "scs"])
def test_bound_holds_for_a_rough_pressure(motion, solver):
    """Tractions exact for a pressure that is not: all of the error is the pressure's, and the bound
    has it.
    """
    scene = waves(motion=motion)
    exact = vc.solve(scene)
    rough = best_iterate(scene, normal=solver, tangential="tang-safeguarded", tol=1e-2)
    bound, part = rough.certificate.force_bound, rough.certificate.pressure_part
    assert np.all(off(rough, exact) <= bound)
    assert np.any(off(rough, exact) > 10 * (bound - part)), "for this pressure alone it is no bound"
    assert np.all(bound < 0.01 * 0.3), "and it says something"
    assert (
        "guaranteed bounds on this grid with the error of the pressure included: Fx to"
        in rough.report()
    )
    assert rough.summary()["certificate"]["pressure_part"] == part.tolist()


def test_bound_of_a_default_solve_is_near_rounding():
    """Pressure and tractions by active sets: the guarantee is 1e-9 of what friction carries, or
    better.
    """
    certificate = vc.solve(waves()).certificate
    assert np.all(0 < certificate.pressure_part) and np.all(
        certificate.pressure_part < certificate.force_bound
    )
    assert np.all(certificate.force_bound < 1e-9 * 0.3)


@pytest.mark.long
@settings(max_examples=30)
@given(
    seed=st.integers(0, 2**32 - 1),
    size=st.floats(-7, -0.5),
    load=st.sampled_from(["force", "approach"]),
)
def test_bound_holds_for_any_pressure(seed, size, load):
    """Pressures that are wrong everywhere, also outside the contact, with the exact tractions for
    them.
    """
    scene = SCENES[load]
    exact = SOLVED[load]
    random = np.random.default_rng(seed)
    change = 10**size * exact.pressure.max() * random.normal(size=exact.pressure.shape)
    pressure = np.maximum(exact.pressure + change * (random.random(exact.pressure.shape) < 0.7), 0)
    disc = discretise(scene, exact.grid)
    problem = disc.tangential_problem(pressure / disc.scales.pressure)
    traction, _ = problem.on_grid(tang_safeguarded(problem).traction, np.zeros(2))
    wrong = dataclasses.replace(exact, traction=traction * disc.scales.pressure)
    found = vc.certify(scene, wrong.traction, pressure)
    assert np.all(off(wrong, exact) <= found.force_bound)
    assert found.tangential_residual < 1e-8


SCENES = {"force": waves(10), "approach": waves(10, normal_force=None, approach=0.3)}
SOLVED = {load: vc.solve(scene) for load, scene in SCENES.items()}


@pytest.mark.parametrize("load", ["force", "approach"])
@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.1])
def test_error_of_the_pressure_is_bounded(load, size):
    """Its Euclidean norm, and the elements where the exact pressure may be, against the exact
    pressure.
    """
    scene, exact = SCENES[load], SOLVED[load]
    disc = discretise(scene, exact.grid)
    problem, right = disc.normal_problem(), exact.pressure.ravel() / disc.scales.pressure
    noise = np.random.default_rng(4).normal(size=right.size)
    for pressure in (
        right + size * noise * (right > 0),
        right * (noise > -1),
        np.maximum(right + size * noise, 0),
    ):
        size, possible = pressure_error(
            problem, pressure, (exact.approach - disc.base) / disc.scales.displacement
        )
        assert np.linalg.norm(pressure - right) <= size
        assert np.all(possible[right > 0])
    size, possible = pressure_error(
        problem, right, (exact.approach - disc.base) / disc.scales.displacement
    )
    assert size < 1e-10 * right.max()
    np.testing.assert_array_equal(possible, right > 0, "nothing else can be in contact")


# --------------------------------------------------------------------------- forces that are missed


@pytest.mark.parametrize("part", [0.3, 0.98])
@pytest.mark.parametrize("factor", [0.9, 0.999, 1.001, 1.1])
def test_bound_holds_where_a_prescribed_force_is_missed(rolling, part, factor):
    """Tractions of another force than the one asked for, at the creepage of that: the bound counts
    it as well.
    """
    sol = vc.solve(rolling(motion=vc.Steady(Fx=-0.3 * part, Fy=0.01)))
    disc = discretise(sol.scene, sol.grid)
    problem = disc.tangential_problem(sol.pressure / disc.scales.pressure)
    exact, _ = problem.of_grid(sol.traction / disc.scales.pressure, np.zeros(2))
    rigid = np.array(sol.creepage[:2]) * disc.step * disc.scales.length / disc.scales.displacement
    x, y = problem.points
    for traction in (factor * exact, project(factor * exact, problem.bound)):
        change = problem.area * (traction - exact)
        errors = np.abs([*change.sum(axis=1), np.sum(x * change[1] - y * change[0])])
        assert errors[0] > 1e-6
        assert np.all(errors <= force_bound(problem, traction, rigid))
    assert np.all(force_bound(problem, exact, rigid) < 1e-9)


# ----------------------------------------------------------------------------- rounding


@pytest.mark.parametrize("angle", [1e-6, 1e-9, 1e-12, 1e-15, 0.0])
@pytest.mark.parametrize(
    "motion", [vc.Steady(vx=1.0, vy=0.3), vc.Shift(ux=1.0, uy=0.3)], ids=["rolling", "shift"]
)
def test_tractions_turned_near_full_slip(rolling, motion, angle):
    """The cosine of 1e-9 is one, and the gap by its definition zero: the bound still has what
    turning changes.
    """
    scene = rolling(motion=motion)
    sol = vc.solve(scene)
    assert sol.elements["stick"] == 0
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    turned = np.einsum("ij,j...->i...", turn, sol.traction)
    bound = vc.certify(scene, turned).force_bound
    errors = off(dataclasses.replace(sol, traction=turned), sol)
    assert np.all(errors <= bound)
    assert np.all(bound[:2] > 1e-16 * 0.3), "rounding is never nothing"
    assert np.all(bound[:2] < 0.3 * (10 * angle + 1e-11)), "and the bound no more than that"


@pytest.mark.parametrize(("across", "tight"), [(24, 1e-3), (8, 1e-4)])
def test_rounding_of_products_is_bounded(rolling, across, tight):
    """By FFT, and on few elements by the matrix, against extended precision: below the bound, and
    not by far.
    """
    scene = rolling(grid=vc.Grid(nx=across, ny=across))
    sol = vc.solve(scene)
    disc = discretise(scene, sol.grid)
    problem = disc.tangential_problem(sol.pressure / disc.scales.pressure)
    random = np.random.default_rng(0)
    for traction in (
        problem.of_grid(sol.traction / disc.scales.pressure, np.zeros(2))[0],
        random.normal(size=(2, problem.size)),
    ):
        exact = problem.operator.matrix.astype(np.longdouble) @ traction.ravel().astype(
            np.longdouble
        )
        shift = problem.shift(traction, np.zeros(2)).ravel()
        lost = float(
            np.linalg.norm(shift - exact - problem.rigid_shift.ravel().astype(np.longdouble))
        )
        bound = _rounding(problem.operator, traction, problem.rigid_shift)
        assert tight * bound < lost < bound
    assert (problem.operator.grid_operator.whole is None) == (across == 24)


# ----------------------------------------------------------------------------- how much of it


def test_what_is_left_out_is_not_computed_and_said(rolling, monkeypatch):
    """Without the bound nothing is factored; without the gap the residuals are the same; the report
    says both.
    """
    scene = rolling()
    full = vc.solve(scene)
    assert full.certificate.level == "full"

    def refuse(*_):
        raise AssertionError("a symmetric part was looked at")

    monkeypatch.setattr("varcontact.discrete.problems.positive_definite", refuse)
    gap, none = vc.solve(scene, certify="gap"), vc.solve(scene, certify=None)
    for sol in (gap, none):
        assert sol.certificate.residual == full.certificate.residual < 1e-8
        assert np.all(np.isposinf(sol.certificate.force_bound))
    assert gap.certificate.relative_gap == full.certificate.relative_gap
    assert (
        'no guaranteed bound: bound not computed: certify = "gap"; "full" computes everything'
        in gap.report()
    )
    assert np.isnan(none.certificate.gap) and none.summary()["certificate"]["gap"] is None
    assert none.summary()["certificate"]["level"] == "none"
    assert 'gap and bound not computed: certify = "none"' in none.report()
    assert "relative gap" not in none.report()


def test_residuals_are_judged_at_every_level(rolling):
    """What does not converge says so without a certificate, too, and does not blame what was left
    out.
    """
    with pytest.raises(vc.NotConverged, match="residual is not below tol") as failure:
        vc.solve(rolling(), tangential="scs", polish=False, tol=1e-14, certify=None)
    assert "left out" not in str(failure.value)
    assert failure.value.solution.certificate.residual > 1e-14


def test_full_up_to_a_stated_size(rolling, monkeypatch):
    scene = rolling()
    size = vc.solve(scene).elements["contact"]
    monkeypatch.setattr(certificate, "FULL_LIMIT", size)
    assert vc.solve(scene).certificate.level == "full"
    monkeypatch.setattr(certificate, "FULL_LIMIT", size - 1)
    assert vc.solve(scene).certificate.level == "gap"
    assert vc.solve(scene, certify="full").certificate.level == "full"
    assert vc.certify(scene, vc.solve(scene).traction).level == "full"


@pytest.mark.parametrize("method", ["newton", "fastsim", "polach"])
def test_bounds_are_computed_when_they_are_asked_for(rolling, monkeypatch, method):
    """By methods that take less time than the bounds: the same bounds, once; in full they are there
    at once; a solution can be pickled before and after.
    """
    asked, compute = [], certificate.force_bound
    monkeypatch.setattr(
        certificate, "force_bound", lambda *given: asked.append(1) or compute(*given)
    )
    lazy, full = (
        vc.solve(rolling(), tangential=method, certify=level).certificate
        for level in ("auto", "full")
    )
    assert len(asked) == 1
    assert lazy.level == "full"
    assert np.isnan(full.force_bound[2]) == (method == "polach")
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(lazy)).force_bound, full.force_bound)
    np.testing.assert_array_equal(lazy.force_bound, full.force_bound)
    np.testing.assert_array_equal(
        pickle.loads(pickle.dumps(lazy)).pressure_part, lazy.pressure_part
    )
    assert len(asked) == 3


def test_levels_in_scans_and_histories(rolling):
    [sol] = vc.scan(rolling(), [(0.01, 0.0, 0.0)], certify="gap")
    assert sol.certificate.level == "gap"
    assert (
        vc.solve(rolling(motion=vc.Transient(steps=2, vx=0.02)), certify=None)[-1].certificate.level
        == "none"
    )


@pytest.mark.parametrize("wrong", ["ful", True, 3])
def test_no_such_level(rolling, wrong):
    refused(
        lambda: vc.solve(rolling(), certify=wrong), "certify", match="one of auto, full, gap, none"
    )
