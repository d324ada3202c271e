"""Unlike bodies: the loops between pressure and tractions."""

import dataclasses
import math

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.residuals import residuals as residuals_of
from varcontact.discrete.state import unloaded
from varcontact.solvers.interface import SolveStats
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.selection import select

RUBBER, MIXED = vc.Bodies(G=(1.0, math.inf), nu=(0.0, 0.3)), vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
LINE = {"surface": vc.Cylinders(R=1.0), "normal_force": 1e-3, "grid": vc.Grid(nx=30)}
BALL = {"surface": vc.Ellipse(a=1.2, b=0.9), "normal_force": 1.0, "grid": vc.Grid(nx=8, ny=8)}


def scene(**changes):
    return vc.Scene(**{"bodies": RUBBER, "friction": 0.3, **LINE, **changes})


@pytest.mark.parametrize("polish", [True, False])
def test_where_nothing_can_rub_the_joint_loop_is_the_normal_problem(polish):
    """Friction outside the contact only, and a step without friction between others that have
    some.
    """
    grid = vc.Grid(nx=8, ny=8, dx=0.4, dy=0.4, x0=-1.6, y0=-1.6)
    corner = np.zeros(grid.shape)
    corner[0, 0] = 0.3
    frictionless = vc.solve(scene(**{**BALL, "grid": grid}, friction=None), normal="norm")
    arguments = {"coupling": "joint", "tangential": "clarabel", "polish": polish, "tol": 1e-5}
    outside = vc.solve(
        scene(**{**BALL, "grid": grid}, motion=vc.Shift(ux=0.05), friction=corner), **arguments
    )
    steps = vc.Transient(steps=2, vx=0.05, friction=[0.3, 0.0])
    history = vc.solve(scene(**{**BALL, "grid": grid}, motion=steps, friction=None), **arguments)
    assert history[0].traction.any()
    for sol in (outside, history[1]):
        assert not sol.traction.any()
        np.testing.assert_allclose(sol.pressure, frictionless.pressure, rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("kind", "motion"),
    [
        (BALL, vc.Shift(ux=0.05)),
        ({**LINE, "surface": vc.Cylinders(R=1.0, reference_depth=1.0)}, vc.Shift(uy=2e-4)),
    ],
    ids=["ball", "line"],
)
def test_joint_passes_have_the_directions_in_which_pressure_alone_moves(kind, motion):
    """nu = 0, or a line: no traction causes displacements across it. Programs by themselves, and
    not their polish.
    """
    shift = scene(**kind, motion=motion)
    alone = vc.solve(shift, tangential="clarabel", coupling="joint", polish=False, tol=1e-5)
    reference = vc.solve(shift)
    assert reference.traction.any(axis=(1, 2)).all()
    np.testing.assert_allclose(
        alone.traction, reference.traction, rtol=0, atol=1e-4 * reference.traction_bound.max()
    )


@pytest.mark.long
@pytest.mark.parametrize("coupling", ["panagiotopoulos", "joint"])
def test_where_the_plain_loop_diverges_the_accelerated_one_does_not(coupling):
    """K = 0.5, f = 2, half of what friction can carry: without acceleration the residual is 0.1
    after 100 passes.
    """
    sol = vc.solve(scene(motion=vc.Steady(Fx=-1e-3), friction=2.0), coupling=coupling)
    assert sol.converged
    assert 20 < len(sol.passes) < 70


def test_a_loop_that_does_not_converge_keeps_its_history_and_its_best():
    """Full adhesion of a rigid body with nu = 0 on a fine grid: the contact's edge flips for
    ever.
    """
    with pytest.raises(vc.NotConverged, match=r"best of \d+ passes") as failure:
        vc.solve(scene(motion=vc.Shift(Fx=0.0), friction=math.inf, grid=vc.Grid(nx=60)))
    sol = failure.value.solution
    residuals = [residual for _, residual in sol.passes]
    assert not sol.converged
    assert sol.certificate.residual == pytest.approx(min(residuals), rel=1e-6)
    assert sol.certificate.residual == failure.value.residual
    assert len(residuals) < 100


def test_johnson_is_one_pass_and_its_certificate_says_what_lacks():
    """The pressure is that without tractions, his problems are solved, the whole is not."""
    rolling = scene(motion=vc.Steady(Fx=-1e-4))
    sol = vc.solve(rolling, coupling="johnson")
    alone = vc.solve(dataclasses.replace(rolling, motion=None, friction=None), normal="clarabel")
    np.testing.assert_allclose(
        sol.pressure, alone.pressure, rtol=0, atol=1e-9 * alone.pressure.max()
    )
    assert sol.passes == ()
    assert sol.certificate.tangential_residual < 1e-8
    assert sol.certificate.residual > 0.05


def test_the_residual_counts_what_wrong_pressures_do_to_the_tractions():
    """In a shift in which pressures move all elements but the middle one, which sticks or nearly
    does.
    """
    bodies, grid, residuals = vc.Bodies(G=1.0, nu=(0.05, 0.35)), vc.Grid(nx=9, ny=9), []
    for friction in (1e-2, 1e-4, 1e-5):
        motion = vc.Shift(ux=0.03 * friction, uy=0.01 * friction)
        shift = scene(**{**BALL, "grid": grid}, bodies=bodies, friction=friction, motion=motion)
        sol = vc.solve(shift)
        disc = discretise(shift, sol.grid)
        bumps = 1 + 1e-9 * np.cos(np.arange(sol.pressure.size)).reshape(sol.pressure.shape)
        pressure, approach = (
            sol.pressure / disc.scales.pressure,
            (sol.approach - disc.base) / disc.scales.displacement,
        )
        steps = ContactSolver(select(shift), 1e-14, True, SolveStats())
        state = dataclasses.replace(
            unloaded(sol.grid), pressure=pressure * bumps, approach=approach
        )
        state = steps.traction(disc, state)
        normal, tangential, whole = residuals_of(disc, state)
        assert normal < 2e-8
        assert tangential < 1e-12
        residuals.append(whole)
    assert residuals[1] > 10 * residuals[0]
    assert residuals[2] == pytest.approx(10 * residuals[1], rel=0.1)


@pytest.mark.parametrize(
    "motion", [vc.Steady(vx=0.01, spin=0.03), vc.Shift(ux=0.06)], ids=["rolling", "shift"]
)
def test_what_a_small_difference_changes_goes_with_it(motion):
    """And none of it is too small to converge; bodies without any are not coupled."""
    rolling = scene(**BALL, motion=motion)
    like = vc.solve(dataclasses.replace(rolling, bodies=vc.Bodies(1.0, 0.28)), normal="norm")
    assert like.plan.coupling == "none"
    changes = []
    for K in (1e-3, 1e-5, 1e-7, 1e-12):
        nearly = vc.solve(
            dataclasses.replace(rolling, bodies=vc.Bodies(1.0, (0.28 - K, 0.28 + K))), tol=1e-11
        )
        assert (nearly.plan.coupling, nearly.plan.bodies) == ("active-set", "unlike")
        changes.append(np.abs(nearly.traction - like.traction).max() / K)
    assert changes[0] > 0.01
    np.testing.assert_allclose(changes[1:3], changes[0], rtol=0.05)
    assert changes[3] < 100


def test_a_cylinder_without_slip_has_the_closed_form():
    """A pressure p rolled without slip leaves ``beta p sqrt((a - x)/(a + x))``: 4/pi beta Fz, beta
    = |K|/(1 - nu).
    """
    K, nu = 1e-4, 0.28
    rolling = scene(
        bodies=vc.Bodies(1.0, (nu - K, nu + K)),
        friction=1.0,
        motion=vc.Steady(vx=1e-9),
        normal_force=1e-2,
    )
    found = [vc.solve(dataclasses.replace(rolling, grid=vc.Grid(nx=n))) for n in (50, 100, 200)]
    parts = [abs(sol.force[0]) / sol.normal_force * (1 - nu) / K for sol in found]
    errors = np.abs(np.array(parts) - 4 / math.pi)
    assert errors[2] < 0.02
    assert np.all(errors[1:] < 0.7 * errors[:-1])


def test_the_certificate_of_given_fields_is_that_of_the_solution():
    """The approach is that under the tractions, by which it changes."""
    sol = vc.solve(scene(motion=vc.Steady(vx=1e-3)))
    judged = vc.certify(dataclasses.replace(sol.scene, grid=sol.grid), sol.traction, sol.pressure)
    assert judged.residual < max(2 * sol.certificate.residual, 1e-9)
