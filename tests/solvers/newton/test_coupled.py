"""The parts of Newton's method for pressure and tractions together."""

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import RawSolution
from varcontact.solvers.newton.coupled import CoupledProblem, ScaledCoupled

BODIES = vc.Bodies(G=(1.0, 4.0), nu=(0.1, 0.3))


@pytest.fixture(
    params=[vc.Steady(vx=4e-3, spin=0.05), vc.Shift(Fx=1e-4, uy=5e-5)], ids=["steady", "shift"]
)
def scaled(request):
    """A small problem in its own units, with what it was made of."""
    scene = make_scene(
        vc.Paraboloids(1.0, 0.8),
        1e-3,
        request.param,
        vc.Grid(nx=7, ny=6, dx=0.03, dy=0.04, x0=-0.1, y0=-0.12),
        bodies=BODIES,
    )
    disc = discretise(scene, scene.grid)
    blocks = disc.operators.normal, disc.tangential_operator
    problem = CoupledProblem(
        operator=type(blocks[0]).in_blocks(
            [[blocks[0], disc.operators.traction_to_distance], [disc.pressure_to_shift, blocks[1]]]
        ),
        blocks=blocks,
        distance=(disc.distance - disc.base) / disc.scales.displacement,
        rigid_shift=disc.known_shift,
        friction=np.full(disc.grid.shape, 0.3),
        area=disc.lattice.area,
        approach=None,
        force=(1.0, 0.1 if isinstance(request.param, vc.Shift) else None, None),
    )
    start = RawSolution(np.random.default_rng(0).uniform(0, 1, (3, *disc.grid.shape)), np.zeros(3))
    return ScaledCoupled.of(problem, start, lambda raw: 0.0)


def test_products_are_those_of_all_blocks(scaled):
    """In their own units, to single precision."""
    fields = np.random.default_rng(1).normal(size=(3, 6, 7))
    still = np.zeros((3, 1, 1))
    exact = scaled.shift(fields, still) - scaled.shift(0 * fields, still)
    np.testing.assert_allclose(
        scaled.conditions.kernel(fields.astype(np.float32)), exact, atol=3e-6 * abs(exact).max()
    )


def test_newtons_equations_are_the_derivative_of_the_natural_map(scaled):
    """By differences, and with their right-hand sides Newton's step: the bound follows the
    pressure.
    """
    conditions, rng = scaled.conditions, np.random.default_rng(2)
    traction = conditions.projected(rng.normal(size=(3, 6, 7)))
    step = rng.normal(size=traction.shape)
    # a half in contact
    there = -np.median(scaled.shift(traction, np.zeros((3, 1, 1))), axis=(1, 2))[:, None, None]

    def natural(traction):
        shift = scaled.shift(traction, there)
        return traction - conditions.projected(traction - shift), shift

    error, shift = natural(traction)
    system = conditions.linearised(traction, shift, traction - shift)
    change = (natural(traction + 1e-7 * step)[0] - natural(traction - 1e-7 * step)[0]) / 2e-7
    image = scaled.shift(traction + step, there) - shift
    slip = ~system.tangential.stick & system.tangential.conditions.contact
    assert np.count_nonzero(slip) >= 5
    assert np.any(system.tangential.stick)
    assert not np.all(system.normal.stick)
    # Where it slips the step is to reach the bound of the pressure that is found, not that of the
    # natural map's.
    pressed = change[0] - system.normal.rows(image[:1], step[:1])[0]
    np.testing.assert_allclose(pressed, 0, atol=1e-4 * np.abs(change).max())
    rows = system.rows(image, step)
    rows[1:] += (conditions.friction * change[0] * slip) * system.tangential.along
    np.testing.assert_allclose(rows, change, atol=1e-4 * np.abs(change).max())
    right = system.right + error
    right[1:] -= (conditions.friction * error[0] * slip) * system.tangential.along
    np.testing.assert_allclose(right, 0, atol=1e-10)
