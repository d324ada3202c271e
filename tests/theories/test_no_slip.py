"""Computed creepage coefficients: against Kalker's table inside it, against the linear method, and by symmetry."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.reference.creepage_coefficients import creepage_coefficients
from varcontact.theories.no_slip import no_slip_coefficients


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (2.0, 1.0), (1.0, 2.0)])
def test_near_the_table(a, b):
    found, table = no_slip_coefficients(a, b, 0.25), creepage_coefficients(a, b, 0.25)
    for name in ("C11", "C22", "C23"):
        assert getattr(found, name) == pytest.approx(getattr(table, name), rel=0.03)
    scaled = no_slip_coefficients(1e-3 * a, 1e-3 * b, 0.25)
    assert scaled.C11 == pytest.approx(found.C11, rel=1e-10), "only the ratio matters"


def test_linear_method_has_these_coefficients(rolling):
    """Force by unit creepage of the method "linear", to the error of its grid."""
    scene = rolling(motion=vc.Steady(vx=1.0, vy=1.0), grid=vc.Grid(nx=24, ny=24))
    found = no_slip_coefficients(1.2, 0.9, 0.28)
    force = vc.solve(scene, tangential="linear").force
    np.testing.assert_allclose(-force / (1.2 * 0.9), [found.C11, found.C22], rtol=0.05)
