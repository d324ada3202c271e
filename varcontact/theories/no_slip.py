"""Linear theory on elements: the limit of infinite friction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import discretise
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene


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
    shifts = [
        disc.with_loading(motion=unit).rigid_shift.reshape(2, -1)[:, problem.operator.elements].ravel()
        for unit in units
    ]
    tractions = np.linalg.solve(problem.operator.matrix, -np.transpose(shifts)).reshape(2, -1, 3)
    x, y = problem.points
    moment = (x @ tractions[1] - y @ tractions[0]) * disc.scales.length
    return np.array([*tractions.sum(axis=1), moment]) * problem.area * disc.scales.force, problem.size
