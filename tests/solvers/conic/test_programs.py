"""The convex programs: their solvers' raw answers, the multipliers, and what they are as data."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.conic.backends import PROGRAM_SOLVERS
from varcontact.solvers.conic.programs import normal_program, tangential_program
from varcontact.solvers.interface import Settings

TIGHT = Settings(tol=1e-7)
GRID = vc.Grid(nx=12, ny=12).spread((-1.2, 1.2, -0.9, 0.9))


def problems(scene):
    disc = discretise(scene, GRID)
    state = hertz_pressure(disc, unloaded(GRID))
    return disc.normal_problem(), disc.tangential_problem(state.pressure)


@pytest.fixture(params=["rolling", "shift"])
def scene(request, rolling):
    return (
        rolling()
        if request.param == "rolling"
        else rolling(motion=vc.Shift(ux=0.1, uy=-0.1, rotation=0.05))
    )


def test_optimal_value_of_the_gap_program_is_zero(rolling):
    _, tangential = problems(rolling())
    program = tangential_program(tangential, True, True)
    import clarabel

    options = clarabel.DefaultSettings()
    options.verbose = False
    cones = [clarabel.SecondOrderConeT(3) for _ in program.cones]
    result = clarabel.DefaultSolver(
        program.P, program.q, program.A, program.b, cones, options
    ).solve()
    assert abs(result.obj_val) < 1e-7 * abs(program.q).sum()


def test_programs_are_scaled(scene):
    """Disks of radius one, and coefficients of order one, whatever the scene's units."""
    huge = dataclasses.replace(
        scene, bodies=vc.Bodies(G=1e12, nu=0.28), normal_force=1e12, friction=3e-7
    )
    for described in (scene, huge):
        normal, tangential = problems(described)
        for program in (
            normal_program(normal.reachable()),
            tangential_program(tangential, True, not tangential.symmetric),
        ):
            assert np.abs(program.P.data).max() < 1e9
            assert (
                set(np.unique(program.b[program.b != 0])) <= {1.0}
                or np.abs(program.b).max() <= 1.0 + 1e-12
            )


@pytest.mark.long
def test_reachable_elements_hold_the_contact(rolling):
    """What is left out as out of reach is out of contact in the whole problem, too."""
    wide = vc.Grid(nx=24, ny=24).spread((-4.0, 4.0, -4.0, 4.0))
    problem = discretise(
        rolling(normal_force=None, approach=0.5, motion=None), wide
    ).normal_problem()
    fewer = problem.reachable()
    assert fewer.distance.size < problem.distance.size
    few, all_ = (norm(p, PROGRAM_SOLVERS["clarabel"].normal(p, TIGHT)) for p in (fewer, problem))
    expected = np.zeros(problem.distance.size)
    expected[fewer.operator.elements] = few.traction
    np.testing.assert_allclose(all_.traction, expected, atol=1e-12)
