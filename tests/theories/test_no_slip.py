"""Computed creepage coefficients: against Kalker's table, the linear method, limits of wide contacts, by symmetry."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from varcontact.reference.creepage_coefficients import creepage_coefficients
from varcontact.theories import no_slip_coefficients


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


@pytest.mark.parametrize("nu", [0.0, 0.5])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
def test_table_where_nothing_couples_and_where_all_does(nu, ratio):
    """The table's own columns; C33 far off it at a/b = 10, as its docstring says."""
    found, table = no_slip_coefficients(ratio, 1.0, nu, cells=16), creepage_coefficients(ratio, 1.0, nu)
    for name in ("C11", "C22", "C23"):
        assert getattr(found, name) == pytest.approx(getattr(table, name), rel=0.03)
    assert found.C33 / table.C33 == pytest.approx(1.0, rel=0.05) if ratio < 10 else found.C33 > 1.1 * table.C33


def test_nothing_couples():
    """nu = 0: both directions are the same, and a nu that is nearly 0 has the same coefficients."""
    for a in (0.01, 1.0, 30.0):
        found, near = no_slip_coefficients(a, 1.0, 0.0, cells=16), no_slip_coefficients(a, 1.0, 1e-9, cells=16)
        assert found.C11 == pytest.approx(found.C22, rel=1e-9)
        np.testing.assert_allclose(dataclasses.astuple(found), dataclasses.astuple(near), rtol=1e-6)


@pytest.mark.parametrize("nu", [-0.9, -0.5, 0.0, 0.28, 0.5])
@pytest.mark.parametrize("b", [1e3, 1e30])
def test_wide_contacts_are_plane(b, nu):
    """A strip along y: C11 tends to pi^2 / (4 (1 - nu)), as Carter's, and C22, by antiplane strain, to pi^2 / 4."""
    found = no_slip_coefficients(1.0, b, nu, cells=24)
    assert found.C11 == pytest.approx(np.pi**2 / 4 / (1 - nu), rel=2e-3)
    assert found.C22 == pytest.approx(np.pi**2 / 4, rel=2e-3)
    if nu == 0:
        assert found.C23 == pytest.approx(np.pi * b**-0.5 / 3, rel=0.01)


@pytest.mark.parametrize("nu", [-0.9, 0.0, 0.5])
def test_long_contacts(nu):
    """a/b = 100: no limit to hold them to but themselves on finer grids."""
    found, fine = (no_slip_coefficients(100.0, 1.0, nu, cells=cells) for cells in (16, 32))
    for name in ("C11", "C22", "C23"):
        assert getattr(found, name) == pytest.approx(getattr(fine, name), rel=0.04)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: no_slip_coefficients(0.0, 1.0, 0.3), "a = 0"),
        (lambda: no_slip_coefficients(1.0, np.inf, 0.3), "b = inf"),
        (lambda: no_slip_coefficients(1.0, 1.0, -1.0), r"^nu = -1.* Poisson's ratio in \(-1, 0\.5\]"),
        (lambda: no_slip_coefficients(1.0, 1.0, 0.51), r"^nu = 0\.51 "),
        (lambda: no_slip_coefficients(1.0, 1.0, np.nan), "^nu = nan"),
        (lambda: no_slip_coefficients(1.0, 1.0, "steel"), "^nu = 'steel'"),
        (lambda: no_slip_coefficients(1.0, 1.0, 0.3, cells=8), "cells = 8 .*16 or more"),
    ],
)
def test_bad_input(call, words):
    with pytest.raises(vc.SceneError, match=words):
        call()
