"""From a scene to its dimensionless problems: what the mesh and the step may be."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.state import hertz_pressure, unloaded


def tangential_problem(rolling, ratio, part, nu=0.28, motion=vc.Steady, cells=10):
    """The problem of an ellipse meshed with elements of dx/dy = ratio, in steps of `part` elements."""
    a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)
    given = {"vx": 0.04, "dq": part * 2 * a / cells} if motion is vc.Steady else {"ux": 0.04}
    scene = rolling(bodies=vc.Bodies(G=1.0, nu=nu), surface=vc.Ellipse(a=a, b=b), motion=motion(**given))
    grid = vc.Grid(nx=cells, ny=cells).spread((-a, a, -b, b))
    disc = discretise(scene, grid)
    return disc.tangential_problem(hertz_pressure(disc, unloaded(grid)).pressure)


@pytest.mark.parametrize(
    ("ratio", "part", "nu", "monotone"),
    [
        (1, 0.1, 0.28, True),
        (3, 0.3, 0.28, False),
        (3, 0.5, 0.28, True),
        (10, 0.1, 0.28, False),
        (10, 0.1, 0.0, True),
        (10, 0.5, 0.5, False),
        (10, 0.7, 0.5, True),
        (10, 1.0, 0.5, True),
    ],
)
def test_monotone_tells_the_sign_of_the_symmetric_part(rolling, ratio, part, nu, monotone):
    problem = tangential_problem(rolling, ratio, part, nu)
    matrix = problem.operator.matrix
    least = np.linalg.eigvalsh(matrix + matrix.T)[0]
    assert (least > 0) is np.bool_(monotone)
    assert problem.monotone is monotone


def test_a_shift_is_always_monotone(rolling):
    assert tangential_problem(rolling, 10, 1.0, nu=0.5, motion=vc.Shift).monotone


@pytest.mark.parametrize("part", [0.99e-6, 1e-9, 1e-30])
def test_steps_too_short_for_floating_point_are_refused(rolling, part):
    """A - C is a difference: of a step of 1e-9 elements nothing is left but rounding."""
    with pytest.raises(vc.SceneError, match=r"at least 1e-06 of the element's dx, 0\.2") as failure:
        vc.solve(rolling(motion=vc.Steady(vx=0.04, dq=part * 0.2)))
    assert failure.value.field == "motion.dq"


@pytest.mark.parametrize("normal", ["hertz", "clarabel"])
@pytest.mark.parametrize(
    "lattice",
    [
        {"nx": 3, "ny": 3, "dx": 10.0, "dy": 10.0, "x0": -15.0, "y0": -15.0},
        {"nx": 13, "ny": 1, "dx": 0.2, "dy": 10.0, "x0": -1.3, "y0": -5.0},
    ],
)
def test_elements_larger_than_the_contact_are_refused(rolling, lattice, normal):
    """One element's centre lies in the ellipse, but the ellipse is lost in it."""
    with pytest.raises(vc.SceneError, match=r"the contact is 2\.4 by 1\.8") as failure:
        vc.solve(rolling(grid=vc.Grid(**lattice)), normal=normal)
    assert failure.value.field == "grid"


def test_distances_count_from_the_lowest_point():
    """The same dimensionless problem, wherever the height is measured from."""
    grid = vc.Grid(nx=8, ny=8, dx=0.1, dy=0.1, x0=-0.4, y0=-0.4)
    bowl = (grid.x[None, :] ** 2 + grid.y[:, None] ** 2) / 2
    scenes = [
        vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.SampledDistance(bowl + c), approach=c + 0.05, grid=grid)
        for c in (0.0, 1024.0, -1024.0)
    ]
    first, *others = (discretise(scene, grid).normal_problem() for scene in scenes)
    assert first.distance.min() == 0
    for other in others:
        np.testing.assert_allclose(other.distance, first.distance, atol=1e-10)
        assert other.approach == pytest.approx(first.approach, rel=1e-10)
