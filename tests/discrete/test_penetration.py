"""Samples outside the potential contact: which may overlap is told by blocks of elements first."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete import penetration
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.state import ContactState


def pressed(cells, line=False, bodies=None):
    """A discretisation of a contact that samples go on around, and its state with tractions."""
    x = np.linspace(-2.0, 2.0, 81)
    h = x**2 / 2 if line else x**2 / 2 + x[:, None] ** 2
    surface = vc.SampledDistance(h, x, reference_depth=5.0) if line else vc.SampledDistance(h, x, x)
    scene = vc.Scene(
        bodies=bodies or vc.Bodies(G=1.0, nu=0.28),
        surface=surface,
        normal_force=0.5,
        friction=0.3,
        motion=vc.Shift(ux=0.05),
        grid=vc.Grid(nx=cells, ny=None if line else cells),
    )
    sol = vc.solve(scene, certify=None)
    disc = discretise(scene, sol.grid, coupled=scene.bodies.K != 0)
    state = ContactState(
        sol.pressure / disc.scales.pressure,
        sol.approach / disc.scales.displacement,
        sol.traction / disc.scales.pressure,
        np.zeros(2),
    )
    return disc, state


@pytest.mark.parametrize("line", [False, True], ids=["plane", "line"])
@pytest.mark.parametrize("bodies", [None, vc.Bodies(G=(1.0, 4.0), nu=(0.1, 0.4))], ids=["like", "unlike"])
@pytest.mark.parametrize("cells", [8, 24, 40])
def test_displacements_by_blocks_are_as_good_as_they_are_taken_for(cells, bodies, line):
    """Point forces at the centres of blocks, against the exact displacements of all elements, away from the contact."""
    disc, state = pressed(cells, line, bodies)
    dx, dy = disc.lattice.sides
    (left, right, bottom, top) = penetration.contact_box(disc.lattice, state.pressure, around=1)
    x, y = np.meshgrid(np.linspace(left - 1, right + 1, 30), [0.0] if line else np.linspace(bottom - 1, top + 1, 30))
    away = (x < left - dx / 4) | (x > right + dx / 4) | ((y < bottom - dy / 4) | (y > top + dy / 4) & (not line))
    x, y = x[away], y[away]
    exact = penetration._raised(disc, state, x, y)
    elements = max(disc.grid.shape)
    for across in {min(penetration.BLOCKS, elements), elements}:
        about = penetration._raised_about(disc, *penetration._in_blocks(disc, state, across), x, y)
        assert np.abs(about - exact).max() < penetration.BLUR / across * state.approach
    if elements > 2 * penetration.BLOCKS:
        assert penetration._in_blocks(disc, state, penetration.BLOCKS)[1].shape[1] < (state.pressure > 0).sum() / 2


def test_blocks_carry_all_the_load():
    """Forces and their moments about both axes are those of the elements."""
    disc, state = pressed(40)
    centres, loads = penetration._in_blocks(disc, state, 16)
    x, y = disc.points.reshape(2, -1)
    fields = np.concatenate([state.traction, state.pressure[None]]).reshape(3, -1) * disc.lattice.area
    assert loads.sum(axis=1) == pytest.approx(fields.sum(axis=1), rel=1e-12)
    assert centres @ loads[2] == pytest.approx([x @ fields[2], y @ fields[2]], abs=1e-12 * fields[2].sum())
