"""Kalker's linear law: the paper's formulas, their inverse, bad input."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.scenes import refusals
from varcontact.reference import creepage_coefficients
from varcontact.theories import linear_creepage, linear_forces

A, B, G = 6.0, 4.0, 8e4
TABLE = creepage_coefficients(A, B, 0.28)
small = st.floats(-1e-2, 1e-2)


def test_the_papers_formulas():
    """(118)-(119) with C32 = -C23, one creepage at a time."""
    found = linear_forces(A, B, G, np.eye(3), TABLE)
    ab = A * B
    np.testing.assert_allclose(found.force[0], [-G * ab * TABLE.C11, 0], rtol=1e-14)
    np.testing.assert_allclose(found.force[1], [0, -G * ab * TABLE.C22], rtol=1e-14)
    np.testing.assert_allclose(found.force[2], [0, -G * ab**1.5 * TABLE.C23], rtol=1e-14)
    np.testing.assert_allclose(
        found.moment, [0, G * ab**1.5 * TABLE.C23, -G * ab**2 * TABLE.C33], rtol=1e-14
    )


@pytest.mark.long
@given(small, small, small)
def test_inverse(vx, vy, spin):
    """Every mixture of creepages and forces leads back to the same creepages."""
    found = linear_forces(A, B, G, (vx, vy, spin), TABLE)
    (Fx, Fy), Mz = found.force, found.moment
    for mask in range(8):
        one = {"Fx": Fx} if mask & 1 else {"vx": vx}
        two = {"Fy": Fy} if mask & 2 else {"vy": vy}
        three = {"Mz": Mz} if mask & 4 else {"spin": spin}
        back = linear_creepage(A, B, G, TABLE, **one, **two, **three)
        np.testing.assert_allclose(back, [vx, vy, spin], rtol=1e-12, atol=1e-15)


test_bad_input = refusals(
    (lambda: linear_forces(0.0, B, G, (0, 0, 0), TABLE), "a = 0"),
    (lambda: linear_forces(A, B, np.nan, (0, 0, 0), TABLE), "G = nan"),
    (lambda: linear_forces(A, B, G, (0, 0), TABLE), r"creepages has shape \(2,\); it must be"),
    (lambda: linear_forces(A, B, G, (0, 0, np.inf), TABLE), r"creepages\[2\] = inf"),
    (lambda: linear_forces(A, B, G, "none", TABLE), "creepages = 'none'"),
    (lambda: linear_creepage(A, B, G, TABLE, vx=0.1, Fx=2.0), "vx and Fx are both given"),
    (lambda: linear_creepage(A, B, G, TABLE, spin=0.1, Mz=2.0), "spin and Mz are both given"),
    (lambda: linear_creepage(A, B, -G, TABLE, Fx=1.0), "G = -80000"),
    (lambda: linear_creepage(A, B, G, TABLE, Fy=np.nan), "Fy = nan"),
)
