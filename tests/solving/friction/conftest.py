"""Scenes under laws of friction, and the judge of their solutions."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene


@pytest.fixture(scope="session")
def line():
    """A cylinder on a plane, of one law."""

    def made(friction, vx=3e-3, cells=24, **motion):
        return make_scene(
            vc.Cylinders(R=1.0),
            1e-3,
            vc.Steady(**motion or {"vx": vx}),
            vc.Grid(nx=cells),
            friction,
        )

    return made


@pytest.fixture(scope="session")
def ball():
    """A ball on a plane, of one law."""

    def made(friction, cells=8, **changes):
        motion, grid = vc.Steady(vx=3e-3, spin=0.05), vc.Grid(nx=cells, ny=cells)
        return replace(
            make_scene(vc.Paraboloids(1.0, 1.0), 1e-4, motion, grid, friction), **changes
        )

    return made


@pytest.fixture(scope="session")
def holds():
    """Coulomb's law with the coefficient that belongs to the slip."""

    def made(sol, tol=1e-7):
        law, contact, slips = sol.scene.friction, sol.pressure > 0, sol.state == 2
        own = np.where(slips, law(np.hypot(*sol.slip)), law.static)
        np.testing.assert_allclose(sol.friction, own, rtol=1e-12)
        size, bound = np.hypot(*sol.traction), own * sol.pressure
        largest = bound.max()
        assert np.all((size - bound)[contact] <= tol * largest)
        np.testing.assert_allclose(size[slips], bound[slips], atol=tol * largest)
        against = np.sum(sol.traction * sol.slip, axis=0) + size * np.hypot(*sol.slip)
        assert np.all(against[slips] <= tol * largest * (np.hypot(*sol.slip)[slips] + largest))
        assert sol.certificate.tangential_residual < 1e-8

    return made
