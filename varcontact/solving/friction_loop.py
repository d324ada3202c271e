"""Friction laws: an outer loop of problems with a given coefficient of friction in each element (paper, 1.7).

A pass solves the contact with the coefficients as they are, then gives each element that slips the coefficient that
the law has at its slip. An element that sticks keeps its own: where ``|p| <= f pz`` and nothing slips, any larger
coefficient has the same tractions, the static one too.

The less friction, the more slip, and the less friction: solutions may be several. From stick all over (the static
coefficient) the passes come down to one with much friction, from slip all over (the kinetic one) they rise to one with
little. With a static and a kinetic coefficient an element changes from static to kinetic once and for all, so that the
passes are no more than there are elements; and the solution for the kinetic one alone is always one of the solutions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.residuals import magnitude, project
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import SLIP, STICK, own_influence, shift_and_areas, unit_slip
from varcontact.errors import Saturated, SceneError
from varcontact.results.solution import Solution
from varcontact.scene.friction import BRANCHES, Law
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Transient
from varcontact.scene.scene import Scene
from varcontact.solving.fixed_point import Limits, Unknown, fixed_point

Contact = Callable[[Discretisation, ContactState, float], ContactState]
Judge = Callable[[Discretisation, ContactState], float]

PLAIN, NEAR, MAX_PASSES = 100, 1e-4, 500
"""Passes without acceleration before the residual is so small, and all passes, under a law that is continuous.

Where two solutions have just vanished, passes linger for a while, then go on; acceleration would hold them there.
"""


def under_law(
    disc: Discretisation, solve: Contact, judge: Judge, state: ContactState, start: str | Solution | None, tol: float
) -> ContactState:
    """The contact under the law of friction of its scene.

    Parameters
    ----------
    disc : Discretisation
    solve : callable
        Of the contact with given coefficients, `Discretisation.rubbing`, from a state that is near, to a residual.
    judge : callable
        The residual of a state with given coefficients.
    state : ContactState
        With the pressure without tractions, and in a history the coefficients to begin with.
    start : "stick", "slip", Solution or None
        Where to begin otherwise: see `solve`.
    tol : float
        Residual of the whole to stop at.

    Returns
    -------
    ContactState
        That of the least residual; `passes` tells how it went.

    Raises
    ------
    Saturated
        If a prescribed force is beyond what the coefficients of a pass can carry.
    """
    law = _law(disc)

    def one_pass(state: ContactState) -> ContactState:
        assert state.friction is not None
        trial = disc.with_loading(coefficient=state.friction)
        enough = max(tol, 0.01 * state.passes[-1][1] if state.passes else 1e-3)  # the next pass sees no more
        after = solve(trial, state, enough)
        shift, areas = shift_and_areas(trial, after)
        return replace(after, friction=np.where(areas == SLIP, _at_slip(trial, shift), state.friction))

    def residual(state: ContactState) -> float:
        return judge(disc.with_loading(coefficient=coefficient(disc, state)), state)

    coefficients = Unknown("friction", law.kinetic, law.static)
    elements = int(np.count_nonzero(state.pressure)) + 2
    limits = Limits(tol, elements, patience=elements, plain=elements)
    if law.continuous:
        limits = Limits(tol, MAX_PASSES, patience=MAX_PASSES, plain=PLAIN, near=NEAR)
    if state.friction is None:
        state = replace(state, friction=_start(law, disc.grid, start), branch=branch_of(start))
    try:
        return fixed_point(one_pass(replace(state, passes=())), one_pass, coefficients, residual, limits)
    except Saturated as error:
        raise Saturated(error.force, error.limit, f" under its law (sought from {BRANCHES[state.branch]})") from None


def coefficient(disc: Discretisation, state: ContactState) -> np.ndarray:
    """The law's own coefficient at the slip of a state from any source; the static one where it sticks.

    An element slips where its traction is nearer to the law's at its shift than its shift is to none; and where it
    would slip even under the static coefficient: then that is not what it should have.

    Parameters
    ----------
    disc : Discretisation
        Under a law of friction.
    state : ContactState
        Dimensionless.

    Returns
    -------
    ndarray, shape (ny, nx)
        [-]
    """
    law = _law(disc)
    shift, _ = shift_and_areas(disc, replace(state, slips=None))
    moved = shift / own_influence(disc)
    own = _at_slip(disc, shift)
    trial, size = (state.traction - moved).reshape(2, -1), magnitude(moved.reshape(2, -1))
    beyond = magnitude(trial) > law.static * state.pressure.ravel() * (1 + 1e-8) + 1e-12 * magnitude(trial).max()
    image = project(trial, (own * state.pressure).ravel())
    nearer = magnitude(state.traction.reshape(2, -1) - image) < size
    return np.where((beyond | nearer).reshape(own.shape), own, law.static)


def check_start(scene: Scene, start: str | Solution | None, theory: bool) -> None:
    """Refuse a start that is not valid, or that the scene has no use for.

    Parameters
    ----------
    scene : Scene
    start : str, Solution or None
        "stick", "slip", or a solution to begin from.
    theory : bool
        Whether a theory gives the tractions.

    Raises
    ------
    SceneError
        If it is refused.
    """
    if start is None:
        return
    if not scene.under_law:
        raise SceneError("start", start, "left out: it chooses between the solutions under a law of friction")
    if isinstance(scene.motion, Transient):
        raise SceneError("start", start, "left out: in a history each particle goes on as it did in the step before")
    if isinstance(start, Solution) and not theory:
        return
    if not (isinstance(start, str) and start in ("stick", "slip")):
        raise SceneError("start", start, '"stick" or "slip"' + ("" if theory else ", or a Solution"))


def branch_of(start: str | Solution | None) -> str:
    """The name of the branch that a start leads to.

    Parameters
    ----------
    start : str, Solution or None
        "stick", "slip", or a solution to begin from.

    Returns
    -------
    str
        A key of `BRANCHES`.
    """
    return "solution" if isinstance(start, Solution) else start or "stick"


def _law(disc: Discretisation) -> Law:
    assert disc.loading.law is not None
    return disc.loading.law


def _at_slip(disc: Discretisation, shift: np.ndarray) -> np.ndarray:
    """The law's coefficient at a local shift (2, ny, nx)."""
    return _law(disc)(np.hypot(*shift) / unit_slip(disc))


def _start(law: Law, grid: Grid, start: str | Solution | None) -> np.ndarray:
    """The coefficients to begin with."""
    if not isinstance(start, Solution):
        return np.full(grid.shape, law.kinetic if start == "slip" else law.static)
    if start.grid.shape != grid.shape:
        raise SceneError(
            "start",
            f"Solution of shape {start.grid.shape}",
            f"on a grid of shape {grid.shape}",
            message=f"start is a solution on a grid of shape {start.grid.shape}; the scene's grid "
            f"has shape {grid.shape}",
        )
    return known_from(law, start)


def known_from(law: Law, solution: Solution) -> np.ndarray:
    """The coefficients of a solution where it slips, the static one where it sticks.

    Parameters
    ----------
    law : Law
    solution : Solution

    Returns
    -------
    ndarray, shape (ny, nx)
        [-]
    """
    known = np.hypot(*solution.traction) / np.where(solution.pressure > 0, solution.pressure, np.inf)
    known = np.clip(known, law.kinetic, law.static) if law.continuous else law.kinetic
    return np.where(solution.state == SLIP, known, law.static)


def remembered(disc: Discretisation, before: Solution) -> np.ndarray | None:
    """The coefficients that particles bring along into a step of a history: slipping ones keep that of their slip.

    Particles from between two centres have the coefficients there, weighted as displacements are.

    Parameters
    ----------
    disc : Discretisation
        Of the step.
    before : Solution
        The step before, on the same grid.

    Returns
    -------
    ndarray, shape (ny, nx), or None
        [-]; None without a law.
    """
    law = disc.loading.law
    if law is None:
        return None
    known, own = _coefficients(law, before)
    whole, part = _way(disc)
    assert disc.loading.motion is not None
    along = disc.loading.motion.rolls
    near = _from(own if whole == 0 else known, along * whole, law.static)
    return near if part == 0 else (1 - part) * near + part * _from(known, along * (whole + 1), law.static)


def weakening(disc: Discretisation, before: Solution | None, solution: Solution) -> np.ndarray:
    """The part of ``static - kinetic`` that the particles have lost after a step of a history.

    Those that slip have lost that of their slip. An element that sticks forgets as other particles fill it, and at
    once where nothing rolls.

    Parameters
    ----------
    disc : Discretisation
        Of the step.
    before, solution : Solution
        The step before, None: bodies without tractions; and the step.

    Returns
    -------
    ndarray, shape (ny, nx)
        [-], in [0, 1].
    """
    law = disc.loading.law
    if law is None or law.static == law.kinetic:
        return np.zeros(disc.grid.shape)
    left, _ = _coefficients(law, solution)
    whole, part = _way(disc)
    if before is not None and whole == 0 and part > 0:
        _, own = _coefficients(law, before)
        left = np.where(solution.state == STICK, (1 - part) * own + part * law.static, left)
    return np.clip((law.static - left) / (law.static - law.kinetic), 0.0, 1.0)


def _coefficients(law: Law, solution: Solution) -> tuple[np.ndarray, np.ndarray]:
    """Those of the particles that slip, static elsewhere; and with what elements that stick remember."""
    known = known_from(law, solution)
    if solution.weakening is None:
        return known, known
    own = law.static - solution.weakening * (law.static - law.kinetic)
    return known, np.where(solution.state == STICK, own, known)


def _way(disc: Discretisation) -> tuple[int, float]:
    """Elements that particles pass in a step, and the weight of the next one at the point from where they come.

    A displacement at a point between two centres is the sum of those at the centres, with weights that are exact for
    tractions on these two elements.
    """
    if disc.step is None:
        return 0, 0.0
    dx = disc.lattice.sides[0]
    whole, rest = divmod(round(disc.step / dx, 9), 1.0)
    if rest == 0:
        return int(whole), 0.0
    pair = disc.operators.on(replace(disc.lattice, nx=2, ny=None if disc.line else 1))
    at_centres, between = (
        np.mean([table.table[i, i, 0] for i in (0, 1)], axis=0)
        for table in (pair.tangential(), pair.carrying(rest * dx))
    )
    (_, own, other), (beyond, near, _) = at_centres, between
    return int(whole), float((beyond * own - near * other) / ((near + beyond) * (own - other)))


def _from(field: np.ndarray, way: int, outside: float) -> np.ndarray:
    """The values of a field so many elements further along x."""
    nx = field.shape[1]
    first = nx + max(-nx, min(nx, way))
    return np.pad(field, ((0, 0), (nx, nx)), constant_values=outside)[:, first : first + nx]
