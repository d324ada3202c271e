"""The no-slip limit against Kalker's Table 3."""

import numpy as np
import pytest

import varcontact as vc


@pytest.mark.parametrize("nu", [0.0, 0.5])
def test_whole_road_on_a_circle(rolling, paper_table, nu):
    """`solve` with infinite friction, elements by their centres, default sampling of spin, at 24
    cells.
    """
    row = next(
        row for row in paper_table("table3_creepage_coefficients.csv") if row["a_over_b"] == 1
    )
    scene = {"bodies": vc.Bodies(G=1.0, nu=nu), "surface": vc.Ellipse(1.0, 1.0), "friction": np.inf}
    scene["grid"] = vc.Grid(nx=24, ny=24)
    scenes = [rolling(motion=vc.Steady(**{name: 1.0}), **scene) for name in ("vx", "vy", "spin")]
    vx, vy, spin = (vc.solve(scene, method="active-set") for scene in scenes)
    computed = [-vx.force[0], -vy.force[1], -spin.force[1], -spin.moment]
    printed = [row[f"{name}_nu{'0' if nu == 0 else '05'}"] for name in ("C11", "C22", "C23", "C33")]
    np.testing.assert_allclose(computed, printed, rtol=0.02)
    assert vx.plan.tangential == "no-slip"
    free = vc.solve(scenes[2])
    assert free.plan.tangential == "newton"
    np.testing.assert_allclose(
        free.traction, spin.traction, rtol=0, atol=1e-9 * np.abs(spin.traction).max()
    )
    assert vx.certificate.residual < 1e-12
    assert vx.elements["slip"] == 0
    assert vx.force[1] == pytest.approx(0, abs=1e-12)
