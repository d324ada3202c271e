"""The convex programs: their solvers' raw answers, the multipliers, and what they are as data."""

import dataclasses
from functools import partial

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.residuals import gap, normal_residual, project, tangential_residual
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import no_slip, tang_safeguarded
from varcontact.solvers.conic import backends
from varcontact.solvers.conic.programs import gap_program, normal_program, shift_program
from varcontact.solvers.interface import Settings

solve_normal = partial(backends.solve_normal, "clarabel")
solve_tangential = partial(backends.solve_tangential, "clarabel")
TIGHT = Settings(tol=1e-7)
GRID = vc.Grid(nx=12, ny=12).spread((-1.2, 1.2, -0.9, 0.9))


def problems(scene):
    disc = discretise(scene, GRID)
    state = hertz_pressure(disc, unloaded(GRID))
    return disc.normal_problem(), disc.tangential_problem(state.pressure)


@pytest.fixture(params=["rolling", "shift"])
def scene(request, rolling):
    return rolling() if request.param == "rolling" else rolling(motion=vc.Shift(ux=0.1, uy=-0.1, rotation=0.05))


def test_raw_answers(scene):
    """Without any polish, by the gap and the residual of our own."""
    normal, tangential = problems(scene)
    raw = solve_normal(normal.reachable(), TIGHT)
    assert raw.status == "Solved"
    assert normal_residual(normal.reachable(), raw.traction, raw.rigid) < 1e-6
    raw = solve_tangential(tangential, TIGHT)
    assert raw.status == "Solved"
    traction = project(raw.traction, tangential.bound)
    assert gap(tangential, traction, raw.rigid)[1] < 1e-9
    assert tangential_residual(tangential, traction, raw.rigid) < 1e-4


def test_polish_reaches_rounding_from_a_rough_answer(scene):
    normal, tangential = problems(scene)
    raw = solve_normal(normal.reachable(), Settings(tol=1e-2))
    polished = norm(normal.reachable(), raw)
    assert normal_residual(normal.reachable(), raw.traction, raw.rigid) > 1e-8
    assert normal_residual(normal.reachable(), polished.traction, polished.rigid) < 1e-12
    raw = solve_tangential(tangential, Settings(tol=1e-2))
    polished = tang_safeguarded(tangential, raw)
    assert tangential_residual(tangential, raw.traction, raw.rigid) > 1e-8
    assert tangential_residual(tangential, polished.traction, polished.rigid) < 1e-13


def test_optimal_value_of_the_gap_program_is_zero(rolling):
    _, tangential = problems(rolling())
    program = gap_program(tangential)
    import clarabel

    options = clarabel.DefaultSettings()
    options.verbose = False
    cones = [clarabel.SecondOrderConeT(3) for _ in program.cones]
    result = clarabel.DefaultSolver(program.P, program.q, program.A, program.b, cones, options).solve()
    assert abs(result.obj_val) < 1e-7 * abs(program.q).sum()


@pytest.mark.parametrize("direction", [0, 1])
@pytest.mark.parametrize("kind", ["rolling", "shift"])
def test_multiplier_of_the_force_is_the_creepage(rolling, kind, direction):
    """Raw: the rigid shift that comes out of a prescribed force is the one that gives this force."""
    motion = vc.Steady(vx=0.04, vy=0.03, spin=0.05) if kind == "rolling" else vc.Shift(ux=0.1, uy=-0.1, rotation=0.05)
    _, given = problems(rolling(motion=motion))
    exact = tang_safeguarded(given, solve_tangential(given, TIGHT))
    uniform = np.zeros(2)
    uniform[direction] = 0.7 * np.abs(given.rigid_shift).max()
    forces = [None, None]
    forces[direction] = float(given.area * exact.traction[direction].sum())
    asked = dataclasses.replace(given, rigid_shift=given.rigid_shift - uniform[:, None], force=tuple(forces))
    raw = solve_tangential(asked, TIGHT)
    assert raw.rigid[direction] == pytest.approx(uniform[direction], rel=1e-5)
    polished = tang_safeguarded(asked, raw)
    assert polished.rigid[direction] == pytest.approx(uniform[direction], rel=1e-11)
    np.testing.assert_allclose(polished.traction, exact.traction, atol=1e-11)


def test_approach_is_the_multiplier_of_the_normal_force(rolling):
    normal, _ = problems(rolling())
    raw = solve_normal(normal.reachable(), TIGHT)
    by_approach = dataclasses.replace(normal, force=None, approach=float(raw.rigid[0])).reachable()
    again = solve_normal(by_approach, TIGHT)
    assert again.traction.sum() * normal.area == pytest.approx(normal.force, rel=1e-6)


def test_programs_are_scaled(scene):
    """Disks of radius one, and coefficients of order one, whatever the scene's units."""
    huge = dataclasses.replace(scene, bodies=vc.Bodies(G=1e12, nu=0.28), normal_force=1e12, friction=3e-7)
    for described in (scene, huge):
        normal, tangential = problems(described)
        for program in (
            normal_program(normal.reachable()),
            shift_program(tangential) if tangential.symmetric else gap_program(tangential),
        ):
            assert np.abs(program.P.data).max() < 1e9
            assert set(np.unique(program.b[program.b != 0])) <= {1.0} or np.abs(program.b).max() <= 1.0 + 1e-12


def test_no_slip_sticks(rolling):
    _, tangential = problems(rolling())
    raw = no_slip(tangential)
    assert np.abs(tangential.shift(raw.traction, raw.rigid)).max() < 1e-13


def test_reachable_elements_hold_the_contact(rolling):
    """What is left out as out of reach is out of contact in the whole problem, too."""
    wide = vc.Grid(nx=24, ny=24).spread((-4.0, 4.0, -4.0, 4.0))
    problem = discretise(rolling(normal_force=None, approach=0.5, motion=None), wide).normal_problem()
    fewer = problem.reachable()
    assert fewer.distance.size < problem.distance.size
    few, all_ = (norm(p, solve_normal(p, TIGHT)) for p in (fewer, problem))
    expected = np.zeros(problem.distance.size)
    expected[fewer.operator.elements] = few.traction
    np.testing.assert_allclose(all_.traction, expected, atol=1e-12)
