"""Solvers of programs: what they say of themselves, and forces that are all but the largest there
are.
"""

import numpy as np
import pytest
from scipy.sparse import csc_matrix

import varcontact as vc
from varcontact.solvers.conic.backends import PROGRAM_SOLVERS
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.solvers.interface import Settings

GRID = vc.Grid(nx=8, ny=8)


@pytest.mark.parametrize("name", PROGRAM_SOLVERS)
def test_every_solver_tells_whether_it_solved(name):
    """``min x^2/2 + x`` has an answer with -1/2 <= x <= 1, and none with 2 <= x <= 1, whatever
    words say so.
    """
    one = csc_matrix([[1.0]])
    for lowest, possible in ((-0.5, True), (2.0, False)):
        program = ConicProgram(
            one, np.array([1.0]), csc_matrix([[1.0], [-1.0]]), np.array([1.0, -lowest]), [("nonnegative", 2)],
            lambda x, z: (x, np.zeros(1)),
        )  # fmt: skip
        raw = PROGRAM_SOLVERS[name].solve(program, Settings())
        assert raw.solved is possible, raw.status
        assert not possible or raw.traction[0] == pytest.approx(-0.5, abs=1e-6)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0), (-0.6, 0.8)])
@pytest.mark.parametrize("kind", ["steady", "shift"])
@pytest.mark.parametrize("tangential", ["clarabel", "scs", "tang-safeguarded"])
def test_near_saturation_and_beyond(rolling, tangential, kind, direction, check_kkt):
    """0.999 of f Fz: creepages that give it back; all of it and more: the limit is told."""
    motion = vc.Steady if kind == "steady" else vc.Shift
    Fx, Fy = 0.999 * 0.3 * np.array(direction)
    scene = rolling(motion=motion(Fx=float(Fx), Fy=float(Fy)), grid=GRID)
    strong = vc.solve(scene, tangential=tangential)
    check_kkt(strong, 1e-8)
    names = ("vx", "vy") if kind == "steady" else ("ux", "uy")
    again = vc.solve(
        rolling(motion=motion(**dict(zip(names, strong.creepage, strict=False))), grid=GRID)
    )
    np.testing.assert_allclose(again.force, [Fx, Fy], atol=1e-9)
    np.testing.assert_allclose(again.traction, strong.traction, atol=1e-8)
    for part in (1.0, 1.2):
        Fx, Fy = part * 0.3 * (1 + 1e-12) * np.array(direction)
        with pytest.raises(vc.Saturated) as failure:
            vc.solve(
                rolling(motion=motion(Fx=float(Fx), Fy=float(Fy)), grid=GRID), tangential=tangential
            )
        assert failure.value.limit == pytest.approx(0.3, rel=1e-12)
        assert failure.value.force == pytest.approx(part * 0.3, rel=1e-11)
