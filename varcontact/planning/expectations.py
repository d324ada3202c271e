"""The sizes of a plan before anything is solved."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from varcontact.discrete.contact_grid import enlarged, known_grid, no_element_in_contact, wanted_grid
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.mirror import mirror
from varcontact.discrete.penetration import outside
from varcontact.discrete.state import ContactState
from varcontact.planning.costs import instead
from varcontact.planning.plan import Plan
from varcontact.planning.sizes import Counted, Sizes, folds, sizes_of
from varcontact.scene.motion import Shift, Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.system import memory
from varcontact.system.memory import need


def expected_sizes(scene: Scene, plan: Plan) -> Sizes:
    """Sizes before anything is solved.

    A Hertzian contact of a plan with Hertz's pressure is known in closed form; otherwise upper bounds are given:
    the elements that can come into contact at all, or where tractions move the contact, all of the grid.

    Parameters
    ----------
    scene : Scene
    plan : Plan
        Without sizes.

    Returns
    -------
    Sizes
        Numbers of elements and unknowns, bytes.

    Raises
    ------
    SceneError
        If a grid does not hold the contact, as far as that can be told.
    TooLarge
        If not even the grid fits into memory.
    """
    history = isinstance(scene.motion, Transient)
    grid = wanted_grid(scene) if history else known_grid(scene)
    if history and grid.explicit:  # each step has its own contact
        return sizes_of(scene, plan, grid.shape, grid.sides, _at_most(scene, plan, grid.size))
    if not grid.explicit:  # the contact has to be looked for
        margin = 2 * grid.margin
        shape = (grid.rows + (0 if grid.line else margin), grid.nx + margin)
        return sizes_of(scene, plan, shape, None, _at_most(scene, plan, shape[0] * shape[1]))
    disc = discretise(scene, grid, coupled=not plan.left_out)
    if plan.closed_form:
        counted = _closed_form(scene, disc, plan)
    else:
        moves = plan.loops
        counted = _at_most(scene, plan, grid.size if moves else _reachable(disc))
    return sizes_of(scene, plan, grid.shape, grid.sides, counted)


def check_fits(scene: Scene, plan: Plan) -> None:
    """Refuse what is known not to fit into memory, before any work is done for it.

    Where the contact is not known before it is solved for, the solvers' own problems are held to what there is.

    Parameters
    ----------
    scene : Scene
    plan : Plan
        Without sizes.

    Raises
    ------
    TooLarge
        If the sizes are known, and need more memory than is available.
    """
    spec = wanted_grid(scene)
    more = 0 if spec.explicit else 2 * spec.margin
    shape = spec.rows + (0 if spec.line else more), spec.nx + more
    if memory.fits(sizes_of(scene, plan, shape, None, _at_most(scene, plan, shape[0] * shape[1])).peak):
        return
    check_sizes(plan, expected_sizes(scene, plan))


def check_sizes(plan: Plan, sizes: Sizes) -> None:
    """Refuse sizes that are known, and need more memory than there is.

    Parameters
    ----------
    plan : Plan
    sizes : Sizes

    Raises
    ------
    TooLarge
        Naming the stage that needs most, and what fits.
    """
    if not sizes.exact:
        return
    stage = sizes.hungriest
    method, problem = (plan.normal, "normal") if stage == "normal" else (plan.tangential, "tangential")
    what = f"the {stage} problem" if stage in sizes.elements else f"the {stage}"
    need(what, sizes.peak, instead(method, sizes.elements.get(problem, 0), 1 if stage == "normal" else 2))


def _closed_form(scene: Scene, disc: Discretisation, plan: Plan) -> Counted:
    """Under Hertz's pressure everything but the tractions is known."""
    grid = disc.grid
    assert disc.hertz is not None
    pressure = disc.hertz.on_elements(grid)
    if not pressure.any():
        raise no_element_in_contact(scene.surface, scene.approach, grid)
    untouched = ContactState(pressure, 0.0, np.zeros((2, *grid.shape)), np.zeros(2))
    overlap = outside(disc, untouched, closed_form=True)
    if overlap is not None:
        enlarged(scene, grid, pressure, overlap)  # tells that it does not hold the contact
    contact = int(np.sum(pressure > 0))
    if not plan.rubs:
        return Counted(contact, contact, 0)
    with np.errstate(invalid="ignore"):  # inf * 0 outside the contact
        bound = (np.broadcast_to(np.asarray(disc.loading.coefficient), grid.shape) * pressure).ravel()
    elements = np.flatnonzero(bound > 0)
    shift = disc.rigid_shift.reshape(2, -1)[:, elements]
    assert isinstance(scene.motion, Steady | Shift)
    force = (scene.motion.Fx, scene.motion.Fy)
    if scene.line or scene.bodies.combined_nu == 0:  # elasticity does not couple x and y: only what moves is unknown
        moving = sum(bool(shift[i].any()) or force[i] is not None for i in (0, 1))
        if moving < 2:
            return Counted(contact, contact, elements.size, components=1)
    folded = folds(plan) and mirror(elements, grid.nx, shift, bound[elements], force) is not None
    return Counted(contact, contact, elements.size, mirrored=folded)


def _at_most(scene: Scene, plan: Plan, elements: int) -> Counted:
    pressed = elements * math.prod(plan.cells(scene))
    if isinstance(scene.friction, np.ndarray):
        return Counted(pressed, elements, min(elements, int(np.sum(scene.friction > 0))), exact=False)
    return Counted(pressed, elements, elements, exact=False)


def _reachable(disc: Discretisation) -> int:
    """The number of elements of the normal problem, which takes one influence number: of an element on itself."""
    posed = replace(disc, operators=disc.operators.on(disc.lattice.window(0, 1, 0, 1)))
    reachable = posed.normal_problem().reachable().distance.size
    if reachable == 0:
        raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
    return reachable
