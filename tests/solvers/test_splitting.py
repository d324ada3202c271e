"""Douglas and Rachford's splitting: to rounding from a rough answer, without active sets."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.residuals import tangential_residual
from varcontact.solvers.active_set.tang import tang_safeguarded
from varcontact.solvers.conic.backends import PROGRAM_SOLVERS
from varcontact.solvers.interface import Settings
from varcontact.solvers.splitting import refine

MOTIONS = [
    vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
    vc.Steady(Fx=-0.2, vy=0.02, spin=0.1),
    vc.Steady(Fx=-0.2, Fy=0.2),
    vc.Shift(ux=0.05, uy=0.02, rotation=0.08),
    vc.Shift(Fx=0.2),
]
CELLS = vc.Grid(nx=8, ny=8)


def posed(scene):
    """The scene on its grid, and its pressure without tractions."""
    sol = vc.solve(dataclasses.replace(scene, motion=None, friction=None))
    return discretise(scene, sol.grid), sol


@pytest.mark.parametrize("motion", MOTIONS)
def test_tractions_from_an_interior_point_answer(rolling, motion):
    """To rounding, where the solver's own answer is good to 1e-5; and the same as those of active
    sets.
    """
    disc, sol = posed(rolling(motion=motion, grid=CELLS))
    problem = disc.tangential_problem(sol.pressure / disc.scales.pressure)
    rough = PROGRAM_SOLVERS["clarabel"].tangential(problem, Settings(1e-4))
    assert tangential_residual(problem, rough.traction, rough.rigid) > 1e-7
    fine = refine(problem, Settings(1e-12), rough)
    assert fine.solved
    assert tangential_residual(problem, fine.traction, fine.rigid) <= 1e-12
    exact = tang_safeguarded(problem)
    np.testing.assert_allclose(fine.traction, exact.traction, atol=1e-10 * problem.bound.max())
    np.testing.assert_allclose(fine.rigid, exact.rigid, atol=1e-10)
