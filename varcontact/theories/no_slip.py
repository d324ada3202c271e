"""Creepage coefficients computed: the limit of infinite friction on our own elements."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.problem.discretisation import discretise
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse


def no_slip_coefficients(a: float, b: float, nu: float, *, cells: int = 32) -> CreepageCoefficients:
    """Creepage coefficients of an ellipse, for any axes and Poisson's ratio.

    Parameters
    ----------
    a, b : float
        Semi-axes along the rolling direction and across it [length].
    nu : float
        Poisson's ratio in (-1, 0.5].
    cells : int
        Elements across the ellipse either way of the finest of nine grids, 16 or more.

    Returns
    -------
    CreepageCoefficients

    Raises
    ------
    SceneError
        For lengths that are not positive, `nu` out of range, or fewer `cells`.

    Notes
    -----
    Grids of `cells`/2 to `cells` elements across, each with all elements that the ellipse touches, as an ellipse of
    their total area: the coefficients of single grids then change smoothly, and a straight line in the elements'
    size is extrapolated to zero. Against Kalker's table at nu = 0, 0.28 and 0.5, C11, C22 and C23 come within
    1.2 % for a/b from 0.1 to 3 and 1.5 % at a/b = 10; C33 within 2.2 %, but wrong by 13 to 74 % at a/b = 10, where
    it needs far more elements. Beyond the table C11 and C22 stay as good: at a/b = 1e-6 they are within 0.06 % of
    pi^2/(4 - 4 nu) and pi^2/4, and at a/b = 1e6 doubled `cells` change them, and C23, by 1.5 % or less. C23 is good
    to 2.2 % down to a/b = 0.01. In contacts that are wider still it is good for nu = 0 only: else it has a part
    that grows like log(b/a), and the same elements make it too small by 13 % at a/b = 0.001 and nu = 0.5. C33 is no
    more than an order of magnitude beyond a/b = 10. Where nu is negative C23 may be so, too, in wide contacts.

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> computed, table = no_slip_coefficients(1.0, 1.0, 0.5), creepage_coefficients(1.0, 1.0, 0.5)
    >>> abs(computed.C11 / table.C11 - 1) < 0.01
    True
    """
    a, b, cells = checks.positive("a", a), checks.positive("b", b), checks.whole("cells", cells, least=16)
    nu = checks.number("nu", nu, "a Poisson's ratio in (-1, 0.5]")
    if not -1 < nu <= 0.5:
        raise SceneError("nu", nu, "a Poisson's ratio in (-1, 0.5]")
    return _extrapolated(a / b, nu, cells)


@lru_cache(maxsize=64)
def _extrapolated(ratio: float, nu: float, cells: int) -> CreepageCoefficients:
    """From nine grids; remembered, as the points of a scan have them in common."""
    numbers = np.unique(np.linspace(cells / 2, cells, 9).astype(int))
    values = np.array([_on_cells(ratio, nu, int(number)) for number in numbers])
    fitted = np.linalg.lstsq(np.vander(1 / numbers, 2), values, rcond=None)[0]
    return CreepageCoefficients(*(float(value) for value in fitted[-1]))


def _on_cells(ratio: float, nu: float, cells: int) -> np.ndarray:
    """C11, C22, C23, C33 on a grid of `cells`, from the forces by unit creepages."""
    a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)  # a b = 1
    # with the elements whose centres the ellipse holds the coefficients jump from grid to grid
    grid = Grid(nx=cells, ny=cells, edge="touched").spread((-a, a, -b, b))
    scene = Scene(
        bodies=Bodies(G=1.0, nu=nu),
        surface=Ellipse(a=a, b=b),
        normal_force=1.0,
        friction=float("inf"),
        motion=Steady(),
        grid=grid,
    )
    forces, elements = no_slip_forces(scene)
    product = elements * grid.area / np.pi  # a b of the ellipse with the elements' area
    diagonal = np.array([forces[0, 0], forces[1, 1], forces[1, 2], forces[2, 2]])
    return -diagonal / product ** np.array([1.0, 1.0, 1.5, 2.0])


def no_slip_forces(scene: Scene) -> tuple[np.ndarray, int]:
    """What unit creepages do where nothing slips, from one factor of the matrix.

    Parameters
    ----------
    scene : Scene
        Hertzian, of quasi-identical bodies, in steady rolling, on an explicit grid.

    Returns
    -------
    forces : ndarray, shape (3, 3)
        Rows Fx, Fy, Mz; columns by vx, vy and spin of one: -G ab C11 at [0, 0], and so on (118)-(119).
    elements : int
        Number of elements in contact.
    """
    assert isinstance(scene.grid, Grid)
    assert isinstance(scene.motion, Steady)
    disc = discretise(replace(scene, friction=float("inf")), scene.grid)
    assert disc.hertz is not None
    # both directions, also where nu = 0 and each has a problem of its own
    both = np.ones((2, *scene.grid.shape))
    problem = disc.tangential_problem(disc.hertz.on_elements(scene.grid), acting=both)
    units = [replace(scene.motion, vx=vx, vy=vy, spin=spin) for vx, vy, spin in np.eye(3)]
    shifts = [disc.moved(unit).rigid_shift().reshape(2, -1)[:, problem.operator.elements].ravel() for unit in units]
    tractions = np.linalg.solve(problem.operator.matrix, -np.transpose(shifts)).reshape(2, -1, 3)
    x, y = problem.points
    moment = (x @ tractions[1] - y @ tractions[0]) * disc.length
    return np.array([*tractions.sum(axis=1), moment]) * problem.area * disc.force, problem.size
