"""The creep-force line: Kalker's and the original, their inverse, their tractions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

import varcontact as vc
from tests.scenes import make_scene, refusals
from varcontact.elasticity.operators import influence_operator
from varcontact.reference import creepage_coefficients
from varcontact.theories import (
    linear_forces,
    vermeulen_johnson,
    vermeulen_johnson_coefficients,
    vermeulen_johnson_creepage,
    vermeulen_johnson_traction,
)

A, B, G, LIMIT = 6.0, 4.0, 8e4, 3e4
TABLE = creepage_coefficients(A, B, 0.28)
UNIT = 3 * LIMIT / (A * B * G * TABLE.C11)


def test_the_line():
    """(131)-(134) along x, and saturation."""
    w = np.array([0.0, 0.1, 0.5, 0.9, 1.0, 3.0])
    creepages = np.zeros((6, 3))
    creepages[:, 0] = w * UNIT
    found = vermeulen_johnson(A, B, G, LIMIT, creepages, TABLE)
    np.testing.assert_allclose(found[:, 0], -LIMIT * (1 - (1 - np.minimum(w, 1)) ** 3), rtol=1e-12)
    assert np.all(found[:, 1] == 0)


def test_slope_is_the_linear_theory():
    creepage = (1e-9, -2e-9, 0.0)
    found = vermeulen_johnson(A, B, G, LIMIT, creepage, TABLE)
    np.testing.assert_allclose(found, linear_forces(A, B, G, creepage, TABLE).force, rtol=1e-4)


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.5])
def test_original_coefficients_of_a_circle(nu):
    found = vermeulen_johnson_coefficients(2.0, 2.0, nu)
    assert found.C11 == pytest.approx(16 / (4 - 3 * nu), rel=1e-13)
    assert found.C22 == pytest.approx(16 / (4 - nu), rel=1e-13)


@pytest.mark.parametrize("ratio", [0.1, 0.5, 2.0, 10.0])
def test_original_coefficients_by_quadrature(ratio):
    """The integrals of the ellipsoid's potential in their usual form, over s from 0 to infinity."""
    a, b, nu = ratio, 1.0, 0.3

    def moment(i: int, j: int) -> float:  # s = tan(t)^2 takes the root at 0 away
        def integrand(t: float) -> float:
            s = np.tan(t) ** 2
            return 2 / np.cos(t) ** 2 / ((a * a + s) ** (i + 0.5) * (b * b + s) ** (j + 0.5))

        return quad(integrand, 0, np.pi / 2, epsabs=0, epsrel=1e-11, limit=500)[0]

    along = (1 - 3 * nu) * moment(1, 0) + 3 * nu * a**2 * moment(2, 0)
    across = (1 - nu) * moment(1, 0) + nu * b**2 * moment(1, 1)
    found = vermeulen_johnson_coefficients(a, b, nu)
    assert found.C11 == pytest.approx(2 * np.pi / (a**2 * b * along), rel=1e-9)
    assert found.C22 == pytest.approx(2 * np.pi / (a**2 * b * across), rel=1e-9)


def test_stick_of_the_original_tractions():
    """The displacements of their tractions follow the creepage in the ellipse of stick: du/dx = vx,
    by our own A.
    """
    nu, a, b = 0.3, 1.0, 1.0
    table = vermeulen_johnson_coefficients(a, b, nu)
    vx = 0.4 * 3 * LIMIT / (a * b * G * table.C11)
    grid = vc.Grid(nx=80, ny=80, dx=0.025, dy=0.025, x0=-1.0, y0=-1.0)
    x, y = np.meshgrid(grid.x, grid.y)
    traction = vermeulen_johnson_traction(x, y, a, b, G, LIMIT, (vx, 0.0, 0.0), table)
    u = influence_operator(grid, "xy", "xy", nu=nu).apply(traction / G)[0]
    # y near 0; the ellipse of stick has its middle at x = 0.4, and the radius 0.6
    middle = u[40, 48:62]
    slope = np.diff(middle) / 0.025
    np.testing.assert_allclose(slope, vx, rtol=0.02)


@pytest.mark.parametrize(
    "creepage", [(0.3, 0.0, 0.0), (-0.2, 0.5, 0.0), (2.0, 1.0, 0.0), (0.0, 0.0, 0.0)]
)
def test_total_of_the_tractions(creepage):
    creepage = UNIT * np.array(creepage)
    grid = vc.Grid(nx=400, ny=400, dx=2 * A / 400, dy=2 * B / 400, x0=-A, y0=-B)
    traction = vermeulen_johnson_traction(
        *np.meshgrid(grid.x, grid.y), A, B, G, LIMIT, creepage, TABLE
    )
    total = traction.sum(axis=(1, 2)) * grid.area
    np.testing.assert_allclose(
        total, vermeulen_johnson(A, B, G, LIMIT, creepage, TABLE), atol=2e-4 * LIMIT
    )


@pytest.mark.long
@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_inverse(xi, eta):
    """Every mixture: the creepages found give the prescribed forces, and the given creepage
    stays.
    """
    vx, vy = UNIT * xi, UNIT * eta
    Fx, Fy = vermeulen_johnson(A, B, G, LIMIT, (vx, vy, 0.0), TABLE)
    mixtures = [{"Fx": Fx, "vy": vy}, {"vx": vx, "Fy": Fy}, {"vx": vx, "vy": vy}]
    if np.hypot(Fx, Fy) < LIMIT * (1 - 1e-9):
        mixtures.append({"Fx": Fx, "Fy": Fy})
    for given_ in mixtures:
        if max(abs(given_.get("Fx", 0)), abs(given_.get("Fy", 0))) > LIMIT * (1 - 1e-9):
            continue
        back = vermeulen_johnson_creepage(A, B, G, LIMIT, TABLE, **given_)
        force = vermeulen_johnson(A, B, G, LIMIT, back, TABLE)
        np.testing.assert_allclose(force, (Fx, Fy), atol=1e-9 * LIMIT)
        for i, name in enumerate(("vx", "vy")):
            if name in given_:
                assert back[i] == pytest.approx(given_[name], rel=1e-13)


def test_near_saturation():
    back = vermeulen_johnson_creepage(
        A, B, G, LIMIT, TABLE, Fx=0.6 * 0.999 * LIMIT, Fy=-0.8 * 0.999 * LIMIT
    )
    force = vermeulen_johnson(A, B, G, LIMIT, back, TABLE)
    np.testing.assert_allclose(force, [0.5994 * LIMIT, -0.7992 * LIMIT], rtol=1e-12)
    with pytest.raises(vc.Saturated):
        vermeulen_johnson_creepage(A, B, G, LIMIT, TABLE, Fx=0.6 * LIMIT, Fy=0.8 * LIMIT)


test_bad_input = refusals(
    (lambda: vermeulen_johnson(A, B, G, LIMIT, (0, 0, 1e-9), TABLE), "spin = 1e-09"),
    (lambda: vermeulen_johnson(A, B, G, 0.0, (0, 0, 0), TABLE), "friction_force = 0"),
    (lambda: vermeulen_johnson(A, B, G, LIMIT, 1.0, TABLE), "creepages"),
    (
        lambda: vermeulen_johnson_creepage(A, B, G, LIMIT, TABLE, vy=1.0, Fy=0.0),
        "vy and Fy are both given",
    ),
    (lambda: vermeulen_johnson_creepage(A, B, G, -1.0, TABLE, Fy=0.0), "friction_force = -1"),
    (lambda: vermeulen_johnson_coefficients(A, 0.0, 0.3), "b = 0"),
    (lambda: vermeulen_johnson_coefficients(A, B, 0.6), "nu = 0.6"),
    (lambda: vermeulen_johnson_traction(np.nan, 0, A, B, G, LIMIT, (0, 0, 0), TABLE), "x = nan"),
    (lambda: vermeulen_johnson_traction(0, 0, A, B, G, LIMIT, (0, 0, 1), TABLE), "spin = 1"),
    (
        lambda: vermeulen_johnson_traction(0, 0, A, B, G, LIMIT, np.zeros((2, 3)), TABLE),
        "creepage has shape",
    ),
)


def test_friction_ahead_of_the_ellipse_of_stick_does_negative_work():
    """There the theory's tractions have the direction of the slip: on finer grids the part stays,
    and it is told so.
    """
    parts = []
    for cells in (24, 48):
        scene = make_scene(
            vc.Ellipse(1.0, 1.0), motion=vc.Steady(vx=0.03), grid=vc.Grid(nx=cells, ny=cells)
        )
        sol = vc.solve(scene, tangential="vermeulen-johnson")
        assert vc.solve(scene).negative_work == 0.0
        assert "do not oppose slip" in sol.report()
        parts.append(sol.negative_work)
    assert parts[1] == pytest.approx(parts[0], rel=0.3)
    assert -0.03 < parts[1] < -0.005
