"""Work of friction, by the fields that it is made of."""

import numpy as np
import pytest

import varcontact as vc


@pytest.mark.parametrize("friction", [0.3, 0.01])
def test_work_of_a_shift_is_tractions_times_local_shifts(rolling, friction):
    """With stick and slip, and in full slip."""
    sol = vc.solve(rolling(motion=vc.Shift(ux=0.1, uy=-0.06, rotation=0.05), friction=friction))
    work = -np.sum(sol.traction * sol.slip) * sol.grid.area
    assert work > 0
    assert sol.friction_work == pytest.approx(work, rel=1e-12)
