"""Every method of the package on line contact: one answer."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene

UNLIKE = vc.Bodies(G=(1.0, np.inf), nu=(0.286, 0.0))

BASE = make_scene(
    vc.Cylinders(R=5.0), 0.5, vc.Steady(Fx=-0.06, Fy=0.03), vc.Grid(nx=30), friction=0.25
)


def scene(**changes):
    return replace(BASE, **changes)


def test_an_unpolished_answer_is_guaranteed():
    """The certificate bounds the force's error, from the answer's own data."""
    described = scene(motion=vc.Steady(vx=0.02, vy=0.01))
    best = vc.solve(described)
    rough = vc.solve(described, tangential="clarabel", polish=False, tol=1e-3)
    error = np.abs(rough.force - best.force)
    assert np.all(error > 0)
    assert np.all(error <= rough.certificate.force_bound[:2])
    again = vc.certify(rough.scene, rough.traction, rough.pressure)
    assert again.gap == pytest.approx(rough.certificate.gap, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), UNLIKE], ids=["like", "unlike"])
@pytest.mark.parametrize(
    "motion", [vc.Steady(vx=0.02, vy=0.008), vc.Shift(ux=0.06, uy=-0.03)], ids=["rolling", "shift"]
)
def test_sensitivity(bodies, motion):
    grid = vc.Grid(nx=40, dx=0.1, x0=-2.0)
    surface = vc.Cylinders(5.0, reference_depth=40.0)

    def force(**changes):
        values = {"Fx": None, "Fy": None, **{n: getattr(motion, n) for n in names}, **changes}
        moved = scene(bodies=bodies, surface=surface, motion=type(motion)(**values), grid=grid)
        return vc.solve(moved, normal="clarabel", tol=1e-9).force

    names = ("vx", "vy") if isinstance(motion, vc.Steady) else ("ux", "uy")
    sol = vc.solve(
        scene(bodies=bodies, surface=surface, motion=motion, grid=grid), normal="clarabel"
    )
    assert not sol.sensitivity()[:, 2].any()
    step = 1e-6
    for column, name in enumerate(names):
        ahead, behind = (force(**{name: getattr(motion, name) + sign * step}) for sign in (1, -1))
        slopes = (ahead - behind) / (2 * step)
        np.testing.assert_allclose(
            sol.sensitivity()[:, column], slopes, atol=2e-4 * np.abs(slopes).max()
        )
