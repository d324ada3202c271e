"""Where nothing moves along x, or nothing along y, tractions have one component: the same answer,
for less.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.discrete.certificate import force_bound
from varcontact.discrete.contact_grid import PotentialContact
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.residuals import gap, tangential_residual
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.interfaces.potential import project
from varcontact.solvers.active_set.tang import no_slip, tang, tang_safeguarded
from varcontact.solvers.conic.programs import tangential_program
from varcontact.solvers.registry import normal_methods, states_program, tangential_methods

UNLIKE = vc.Bodies(G=(1.0, np.inf), nu=(0.286, 0.0))
QUADRATIC = [
    name
    for name in normal_methods()
    if states_program("normal", name) and name not in tangential_methods()
]
MOTIONS = {
    "creepage along x": (vc.Steady(vx=0.02), "Fy"),
    "creepage along y": (vc.Steady(vy=0.02), "Fx"),
    "force along x": (vc.Steady(Fx=-0.06), "Fy"),
    "force along y": (vc.Steady(Fy=0.06), "Fx"),
    "shift along x": (vc.Shift(ux=0.06), "Fy"),
    "shift along y": (vc.Shift(uy=-0.06), "Fx"),
    "shift by a force": (vc.Shift(Fx=-0.06), "Fy"),
    "force that sticks": (vc.Steady(Fx=1e-5, dq=0.05), "Fy"),
    "nearly all that friction carries": (vc.Steady(Fx=-0.1249), "Fy"),
    "full slip": (vc.Steady(vx=10.0), "Fy"),
}

BASE = make_scene(
    vc.Cylinders(5.0, reference_depth=50.0), 0.5, vc.Steady(Fx=-0.06), vc.Grid(nx=24), friction=0.25
)


def scene(**changes):
    return dataclasses.replace(BASE, **changes)


def in_full(motion, other):
    return dataclasses.replace(motion, **{other: 0.0})


def posed(motion, marching=False, **changes):
    described = scene(motion=motion, **changes)
    disc = discretise(described, PotentialContact.of(described).known)
    return disc.tangential_problem(
        hertz_pressure(disc, unloaded(disc.grid)).pressure, marching=marching
    )


def same(one, full, tol=1e-12):
    """To rounding: fields, areas, creepages; both certified."""
    moved = max(np.abs(full.slip).max(), np.abs(full.creepage).max())
    np.testing.assert_allclose(one.pressure, full.pressure, atol=tol * full.pressure.max())
    np.testing.assert_allclose(one.traction, full.traction, atol=tol * full.pressure.max())
    np.testing.assert_allclose(one.slip, full.slip, atol=tol * moved)
    np.testing.assert_allclose(one.creepage, full.creepage, atol=tol * moved)
    np.testing.assert_allclose(one.distance, full.distance, atol=tol * np.abs(full.distance).max())
    np.testing.assert_array_equal(one.state, full.state)
    assert max(one.certificate.relative_gap, full.certificate.relative_gap) < tol


@pytest.mark.parametrize("case", MOTIONS)
def test_the_answer_is_that_of_the_full_problem(case):
    motion, other = MOTIONS[case]
    assert (posed(motion).components, posed(in_full(motion, other)).components) == (1, 2)
    one, full = vc.solve(scene(motion=motion)), vc.solve(scene(motion=in_full(motion, other)))
    same(one, full)
    missing = {"Fx": 0, "Fy": 1}[other]
    assert not one.traction[missing].any() and not one.slip[missing].any()
    assert one.certificate.force_bound[missing] == 0
    np.testing.assert_allclose(
        one.sensitivity(), full.sensitivity(), atol=1e-9 * np.abs(full.sensitivity()).max()
    )


@pytest.mark.parametrize("motion", ["force along x", "creepage along y", "shift by a force"])
@pytest.mark.parametrize("name", [*tangential_methods(), *QUADRATIC])
def test_every_solver(name, motion):
    described = scene(motion=MOTIONS[motion][0])
    best = vc.solve(described)
    formulations = (
        ["gap"]
        if isinstance(described.motion, vc.Steady)
        else ["complementary", "potential", "gap"]
    )
    for formulation in formulations if states_program("tangential", name) else ["auto"]:
        if name == "qpsolvers:quadprog" and formulation != "complementary":
            with pytest.raises(vc.NotConverged, match="not positive definite"):
                vc.solve(described, tangential=name, formulation=formulation)
            continue
        sol = vc.solve(described, tangential=name, formulation=formulation, tol=1e-7)
        np.testing.assert_allclose(sol.traction, best.traction, atol=1e-6 * best.pressure.max())


@pytest.mark.parametrize(
    "motion",
    [vc.Steady(Fx=0.0), vc.Steady(vx=0.02), vc.Shift(Fx=0.05), vc.Shift(ux=-0.05)],
    ids=repr,
)
@pytest.mark.parametrize(
    ("methods", "coupling"),
    [
        (("osqp", "osqp"), "johnson"),
        (("norm", "tang-safeguarded"), "panagiotopoulos"),
        (("norm", "tang-safeguarded"), "active-set"),
        (("clarabel", "clarabel"), "panagiotopoulos"),
        (("clarabel", "clarabel"), "joint"),
    ],
)
def test_unlike_bodies(methods, motion, coupling):
    """The pressure alone shifts particles along x, and nothing along y."""
    solved = [
        vc.solve(scene(bodies=UNLIKE, motion=described), *names, coupling, tol=1e-10)
        for described, names in (
            (motion, methods),
            (in_full(motion, "Fy"), ("norm", "tang-safeguarded")),
        )
    ]
    same(*solved, tol=1e-8)
    assert not solved[0].traction[1].any()
    np.testing.assert_array_equal(solved[0].certificate.force_bound, [np.inf, 0.0, 0.0])


def test_unlike_bodies_that_move_along_y_need_both():
    assert vc.solve(scene(bodies=UNLIKE, motion=vc.Steady(vy=0.01))).traction.any(axis=(1, 2)).all()


def test_programs_have_half_the_size():
    for of_traction, motion, fields in (
        (True, vc.Steady(Fx=-0.06), 1),
        (True, vc.Shift(Fx=-0.06), 0),
        (False, vc.Shift(Fx=-0.06), 1),
    ):
        kinds = motion, in_full(motion, "Fy")
        one, full = (tangential_program(posed(each), of_traction, bool(fields)) for each in kinds)
        n = posed(motion).size
        unknown = fields  # the shift of a prescribed force is a variable where t is one
        assert one.q.size == (1 + fields) * n + unknown
        assert full.q.size >= (2 + fields) * n + 2 * unknown
        assert {cone for cone in one.cones if cone[0] == "second_order"} == {("second_order", 2)}
        pairs = one.polyhedral()
        assert not (pairs.kinds == "second_order").any()
        assert pairs.b.size == one.b.size
        assert full.polyhedral() is full


@pytest.mark.parametrize("name", QUADRATIC)
def test_solvers_of_quadratic_programs_are_refused_where_both_move(name):
    for described in (
        scene(motion=vc.Steady(vx=0.01, vy=0.01)),
        scene(motion=in_full(vc.Steady(vx=0.01), "Fy")),
        scene(motion=vc.Steady(vy=0.01), bodies=UNLIKE),
        scene(surface=vc.Ellipse(1.0, 1.0), grid=vc.Grid(nx=8, ny=8)),
    ):
        refused(
            lambda scene=described: vc.solve(scene, tangential=name),
            "tangential",
            match="second-order cones",
        )
    refused(lambda: vc.solve(scene(), tangential="norm"), match="normal problems")


def test_what_was_asked_fits_where_the_full_problem_does_not(monkeypatch):
    """Memory for n^2 numbers, not (2 n)^2."""
    monkeypatch.setattr("varcontact.system.process.LITTLE", 0.0)
    monkeypatch.setattr("varcontact.system.process.available", lambda: 2 * 240.0 * 24**2)
    assert vc.solve(scene(), tangential="clarabel").converged
    with pytest.raises(vc.TooLarge):
        vc.solve(scene(motion=in_full(vc.Steady(Fx=-0.06), "Fy")), tangential="clarabel")


@pytest.mark.parametrize("case", MOTIONS)
def test_active_sets(case):
    """TANG as printed and safeguarded: no tractions turn, so that each step is exact for its
    areas.
    """
    problem = posed(MOTIONS[case][0])
    printed, safe = tang(problem), tang_safeguarded(problem)
    assert printed.status == safe.status == "Solved"
    np.testing.assert_allclose(printed.traction, safe.traction, atol=1e-11 * problem.bound.max())
    assert tangential_residual(problem, safe.traction, safe.rigid) < 1e-12
    full = tang_safeguarded(posed(in_full(*MOTIONS[case])))
    direction = problem.directions[0]
    np.testing.assert_allclose(
        safe.traction[0], full.traction[direction], atol=1e-11 * problem.bound.max()
    )


def test_without_slip():
    for motion, other in ((vc.Steady(Fx=-0.2), "Fy"), (vc.Steady(vy=0.01), "Fx")):
        problem = posed(motion, friction=np.inf)
        raw = no_slip(problem)
        assert raw.traction.shape == (1, problem.size)
        assert np.abs(problem.shift(raw.traction, raw.rigid)).max() < 1e-13
        same(
            *(
                vc.solve(scene(motion=each, friction=np.inf))
                for each in (motion, in_full(motion, other))
            )
        )


def test_tractions_in_the_other_direction_are_judged_as_well():
    """They can be given; the gap then is that of the full problem, and the error within its
    bounds.
    """
    described = scene(motion=vc.Steady(vx=0.02))
    sol = vc.solve(described, normal="clarabel")
    lateral = np.array([0 * sol.pressure, 0.01 * sol.pressure])
    certificate = vc.certify(
        dataclasses.replace(described, grid=sol.grid), sol.traction + lateral, sol.pressure
    )
    assert certificate.relative_gap > 1e3 * max(sol.certificate.relative_gap, 1e-16)
    assert certificate.residual > 0.01
    error = lateral.sum(axis=(1, 2)) * sol.grid.area
    assert np.all(np.abs(error) <= certificate.force_bound[:2])
    assert error[1] > 0
    exact = vc.certify(dataclasses.replace(described, grid=sol.grid), sol.traction, sol.pressure)
    assert exact.residual < 1e-10 and exact.force_bound[1] == exact.force_bound[2] == 0


@given(seed=st.integers(0, 10**6), size=st.floats(-8, 0.5), along=st.sampled_from(["vx", "vy"]))
@settings(max_examples=30)
def test_gap_and_force_bound(seed, size, along):
    """For any admissible tractions: gap > 0, the energy of the error below it, the forces within
    their bounds.
    """
    problem = posed(vc.Steady(**{along: 0.02}))
    exact = tang_safeguarded(problem).traction
    noise = np.random.default_rng(seed).normal(size=exact.shape)
    traction, still = project(exact + 10**size * problem.bound * noise, problem.bound), np.zeros(1)
    error = traction - exact
    absolute, _ = gap(problem, traction, still)
    assert absolute > 0
    energy = problem.area * np.sum(error * problem.operator.apply(error))
    assert energy <= absolute * (1 + 1e-9) + 1e-18
    bound = force_bound(problem, traction, still)
    x, direction = problem.points[0], problem.directions[0]
    errors = np.zeros(3)
    errors[direction] = error.sum()
    errors[2] = (x * error[0]).sum() * direction
    assert np.all(np.abs(errors) * problem.area <= bound * (1 + 1e-9) + 1e-15)
    assert bound[1 - direction] == 0
