"""The passes: what a field lacks of the continuum's slip is added, and the coarse problem solved again."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation, PreviousStep
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import unit_slip
from varcontact.discrete.subgrid import means
from varcontact.scene.motion import Motion, Steady
from varcontact.solving.defect_correction.field import continued, held_behind
from varcontact.solving.defect_correction.parts import Brought, Parts
from varcontact.solving.defect_correction.sublattice import Sublattice, loads
from varcontact.solving.defect_correction.unslipping import Still, Unslipping
from varcontact.solving.friction_law import coefficient

PARTS = 2
"""Parts of an element along each side: with three the error is the same, and the time twice as long."""
PASSES, OF_HERTZ = 3, 4
"""Coarse solves after the first, and in rolling under Hertz's pressure: from then on the error stays, as measured
(docs/refinement.md).
"""
SETTLING = 0.7
"""Part of what a pass changes that is taken from the third one on, in rolling under Hertz's pressure: later ones move
to and fro.
"""
OF_A_STEP = 2
"""The same in a step of a history: a third one changes little."""
STUCK = 40
"""Most of them where nothing slips: what tractions do at the trailing edge is found more slowly."""
SETTLED = 1e-6
"""Change of forces and of creepages, by the largest, in two passes in a row, after which these end without slip."""

SMALL = 0.1
"""Part of the tractions found, with which coarse elements are asked what they have of the weight: none shall slip."""

UNBOUNDED = 1e9
"""Coefficient that stands for infinite friction: tractions are far below the bound, and it stays a number."""

Pass = Callable[[Discretisation, ContactState], ContactState]


@dataclass(frozen=True, eq=False)
class Corrected:
    """A coarse solution after the passes, and its field on parts of the elements. Dimensionless, but for `forces`.

    Attributes
    ----------
    disc : Discretisation
        The coarse problem as it was solved last, with the correction of its rigid shift in `carried`.
    state : ContactState
        Its solution.
    parts : Parts
    share : ndarray, shape (ny, nx)
        What the bound of the coarse problem was multiplied by.
    traction, shift : ndarray, shape (2, ny rows, nx columns)
        The reconstructed field, and the continuum's local shift under it.
    forces : ndarray, shape (passes + 1, 3)
        Fx, Fy, Mz, physical: of the coarse elements before any correction, then of the field after each pass.
    creepages : ndarray, shape (passes + 1, 2)
        vx and vy then, given or found for forces that are given.
    seconds : tuple of float
        Of each pass, its coarse solve included.
    taken : tuple of float
        Which part of what was lacking each pass has added.
    stuck : bool
        Whether nothing was near slip, so that the problem is linear.
    """

    disc: Discretisation
    state: ContactState
    parts: Parts
    share: np.ndarray
    traction: np.ndarray
    shift: np.ndarray
    forces: np.ndarray
    creepages: np.ndarray
    seconds: tuple[float, ...]
    taken: tuple[float, ...]
    stuck: bool

    def unsettled(self, of_passes: np.ndarray) -> np.ndarray:
        """How much the last pass would have changed, and those before it that took a part only, whichever is most.

        Parameters
        ----------
        of_passes : ndarray, shape (passes + 1, n)
            `forces` or `creepages`.

        Returns
        -------
        ndarray, shape (n,)
        """
        taken = np.array(self.taken)
        late = max(1, int(np.sum(taken < 1)))
        return np.asarray((np.abs(np.diff(of_passes, axis=0)) / taken[:, None])[-late:].max(axis=0))


def defect_corrected(
    disc: Discretisation,
    state: ContactState,
    rough: Pass,
    last: Pass,
    parts: int = PARTS,
    finer: np.ndarray | None = None,
    passes: int | None = None,
    brought: Brought | None = None,
) -> Corrected:
    """Correct a coarse solution of steady rolling, of a shift or of a step of a history towards the continuum.

    In each pass the field on parts of the elements is reconstructed from the coarse tractions, and the continuum's slip
    under it averaged over the elements, weighted by the traction bound. The coarse problem's rigid shift is changed by
    the difference to its own slip, and the problem solved again. Where nothing slips, the difference is
    extrapolated from all passes so far. Where forces are prescribed, those of the coarse problem are
    changed by what its elements carry more than the field. Under a law of friction each pass has the coefficients that
    the law has at the corrected slip of the elements. Where the pressure is solved for, the bound on the elements is of
    its means from the finer lattice; in a shift or a step also of those of Hertz's.

    Parameters
    ----------
    disc : Discretisation
        With quasi-identical bodies.
    state : ContactState
        Its solution; in a step of a history the pressure is enough.
    rough, last : callable
        From a discretisation and a state to the state with the tractions that go with its pressure: in all passes but
        the last, and in that. Where nothing slips, `last` is for all: the extrapolation would amplify what they leave.
    parts : int
        Of an element along each side.
    finer : ndarray, optional
        The pressure that was solved for, on parts of the parts, dimensionless. None: it is Hertz's.
    passes : int, optional
        `PASSES`, `OF_HERTZ` or `OF_A_STEP` if not given; where nothing slips, until forces settle, but no more than
        `STUCK`.
    brought : Brought, optional
        In a step of a history: what the step before left on the parts; `disc` has means of it over the elements.

    Returns
    -------
    Corrected
    """
    cells, share, given = (1 if disc.line else parts, parts), shares(disc, state, finer), disc.loading.coefficient
    if np.any(share != 1) or brought is not None:
        disc = disc.with_loading(coefficient=of_elements(disc) * share)
        state = rough(disc, state)
    divided = Parts(disc, cells, state.pressure * share, finer, brought)
    fine = _on_parts(divided, disc.with_loading(coefficient=given), state)
    posed, traction = disc, fine.field(state.traction)
    stuck = fine.sticks(traction)
    settles = not stuck and divided.sloped is not None
    if stuck:
        fine = _unslipping(fine, disc, state, rough)
        traction = fine.field(state.traction)
    left = passes or (STUCK if stuck else OF_HERTZ if settles else PASSES if brought is None else OF_A_STEP)
    forces, creepages = [loads(state.traction * disc.scales.pressure, disc.grid)], [_creepages(disc, state)]
    used, found = [np.zeros(state.traction.size + 2)], []  # corrections, and forces beside those given
    seconds, taken = [], []
    while left:
        begun, left = time.perf_counter(), left - 1
        found.append(_lacking(disc, fine, state, traction))
        taken.append(SETTLING if settles and len(found) > 2 else 1.0)
        wanted = extrapolated(used, found, _counting(disc)) if stuck else found[-1]
        used.append(used[-1] + taken[-1] * (wanted - used[-1]))
        posed = _with(disc, used[-1])
        state = (rough if left and not stuck else last)(posed, state)
        if not stuck:
            fine = _on_parts(divided, posed.with_loading(coefficient=given), state)
        traction = fine.field(state.traction)
        forces.append(fine.forces(traction))
        creepages.append(_creepages(disc, state))
        if (
            stuck
            and passes is None
            and _settled(np.array(forces) * [1, 1, 1 / disc.scales.length], np.array(creepages))
        ):
            left = 0
        seconds.append(time.perf_counter() - begun)
    shift = fine.shift(traction, state.rigid) * (fine.bound > 0)
    of_passes = np.array(forces), np.array(creepages), tuple(seconds), tuple(taken)
    return Corrected(posed, state, divided, share, traction, shift, *of_passes, stuck)


def _lacking(disc: Discretisation, fine: Sublattice, state: ContactState, traction: np.ndarray) -> np.ndarray:
    """What the elements' slip lacks of the continuum's under a field, and then what they carry more than it."""
    own = disc.known_shift + state.rigid[:, None, None] + disc.tangential_operator.apply(state.traction)
    lacking = fine.on_elements(fine.shift(traction, state.rigid)) - own
    bound = fine.coefficient * fine.parts.elements
    if isinstance(fine, Unslipping):
        lacking = lacking * fine.still.rows[:, None]  # elsewhere the field does not depend on the elements
    elif disc.loading.steady:
        lacking = held_behind(lacking, state.traction, bound)
    more = loads(state.traction * disc.scales.pressure, disc.grid) - fine.forces(traction)
    return np.array([*(lacking * (bound > 0)).ravel(), *more[:2] / disc.scales.force])


def _with(disc: Discretisation, correction: np.ndarray) -> Discretisation:
    """The coarse problem with a correction, as of `_lacking`."""
    shift, more = correction[:-2].reshape(2, *disc.grid.shape), correction[-2:] * disc.scales.force
    came = disc.loading.previous_step or PreviousStep(np.zeros_like(shift), np.zeros(2))
    prescribed = np.array([getattr(disc.loading.motion, name) or 0.0 for name in ("Fx", "Fy")])
    carried = PreviousStep(came.displacement - shift, came.force)
    return disc.with_loading(motion=with_forces(disc.loading.motion, prescribed + more), previous_step=carried)


def _on_parts(parts: Parts, disc: Discretisation, state: ContactState) -> Sublattice:
    """The parts with their bound; under a law from the coefficients found."""
    known = of_elements(disc) if disc.loading.law is None else continued(coefficient(disc, state), state.pressure > 0)
    return Sublattice(parts, known)


def _unslipping(fine: Sublattice, disc: Discretisation, state: ContactState, rough: Pass) -> Unslipping:
    """The parts of a contact in which nothing slips, with what coarse elements have where the factor is one.

    That differs most from the weight's mean at the edges: found from two coarse solves, passes settle sooner.
    """
    weight, found = fine.parts.weights[0], Still(fine.parts)
    size, elements = SMALL * np.hypot(*state.traction).max() / weight.max(), np.array([weight, weight])
    assert isinstance(disc.loading.motion, Steady)
    still = disc.with_loading(motion=replace(disc.loading.motion, vx=0.0, vy=0.0, spin=0.0, Fx=None, Fy=None))
    for i in (0, 1) if size > 0 else ():
        traction = np.zeros((2, *found.weight.mean.shape))
        traction[i] = size * found.weight.mean
        shift = found.on_elements(found.elastic_shift(traction)) * (weight > 0)
        posed = still.with_loading(previous_step=PreviousStep(shift, np.zeros(2)))
        elements[i] = rough(posed, state).traction[i] / size
    return Unslipping(fine.parts, fine.coefficient, found, np.clip(elements, weight / 2, 2 * weight))


def _counting(disc: Discretisation) -> np.ndarray:
    """How much what elements of Hertz's contact lack counts, and forces: by the distance from the trailing edge.

    What happens there hardly matters for what is ahead, particles leave; and it is found last.
    """
    hertz, (x, y) = disc.hertz, np.meshgrid(disc.grid.x, disc.grid.y)
    assert hertz is not None
    distances = np.maximum(np.sqrt(np.maximum(1 - (y / hertz.b) ** 2, 0.0)) + x / hertz.a, 0.0)
    return np.concatenate([distances.ravel(), distances.ravel(), np.ones(2)])


def _settled(*of_passes: np.ndarray) -> bool:
    """Whether the last two passes have hardly changed the forces and creepages of all passes, (passes + 1, n)."""
    return len(of_passes[0]) > 2 and all(
        np.abs(np.diff(each[-3:], axis=0)).max() <= SETTLED * np.abs(each[-1]).max() for each in of_passes
    )


def of_elements(disc: Discretisation) -> np.ndarray:
    """Coefficients of friction on the elements, finite.

    Parameters
    ----------
    disc : Discretisation

    Returns
    -------
    ndarray, shape (ny, nx)
        [-]
    """
    known, shape = np.asarray(UNBOUNDED if disc.loading.no_slip else disc.loading.coefficient), disc.grid.shape
    return known.reshape(shape) if known.ndim else np.full(shape, float(known))


def shares(disc: Discretisation, state: ContactState, finer: np.ndarray | None) -> np.ndarray:
    """Means over the elements of the continuum's pressure, by the elements' own pressure, with the same load.

    In steady rolling Hertz's is taken as it is at the centres. In a shift or a step tractions stick up to the edge, in
    proportion to the pressure: an element whose centre is just inside has next to none, where its parts have much, and
    what changes there would grow from pass to pass.

    Parameters
    ----------
    disc : Discretisation
    state : ContactState
    finer : ndarray or None
        As of `defect_corrected`.

    Returns
    -------
    ndarray, shape (ny, nx)
        One outside the contact; one all over for Hertz's pressure in steady rolling, and under a law of friction.
    """
    own, (ny, nx) = state.pressure, disc.grid.shape
    if disc.loading.law is not None or (finer is None and disc.loading.steady):
        return np.ones((ny, nx))
    if finer is None:
        assert disc.hertz is not None
        mean = disc.hertz.mean_pressure(*disc.grid.lines)
    else:
        mean = means(finer, (finer.shape[0] // ny, finer.shape[1] // nx))
    mean = mean * (own > 0)
    return np.where(own > 0, mean * (own.sum() / mean.sum()) / np.where(own > 0, own, 1.0), 1.0)


def extrapolated(used: list[np.ndarray], found: list[np.ndarray], counting: np.ndarray) -> np.ndarray:
    """What to use next of a fixed point: that which would be found, if it changed as linearly as it did before.

    Parameters
    ----------
    used, found : list of ndarray, shape (n,)
        Of all passes, what was used and what was found from it.
    counting : ndarray, shape (n,)
        How much each number counts.

    Returns
    -------
    ndarray, shape (n,)
        Anderson's mixing; what was found last, if it is the first.

    Examples
    --------
    Of a linear map of one number the fixed point, 2, from two passes.

    >>> extrapolated([np.array([0.0]), np.array([1.0])], [np.array([1.0]), np.array([1.5])], np.ones(1))
    array([2.])
    """
    if len(found) == 1:
        return found[0]
    came = np.array(found)
    residuals = (came - used) * counting
    weights = np.linalg.lstsq(np.diff(residuals, axis=0).T, residuals[-1], rcond=1e-10)[0]
    return np.asarray(came[-1] - weights @ np.diff(came, axis=0))


def with_forces(motion: Motion | None, forces: np.ndarray) -> Motion:
    """The motion with other forces where it prescribes some.

    Parameters
    ----------
    motion : Steady, Shift or TimeStep
    forces : ndarray, shape (2,)
        Fx and Fy.
    """
    assert motion is not None
    Fx, Fy = forces
    return replace(motion, Fx=None if motion.Fx is None else float(Fx), Fy=None if motion.Fy is None else float(Fy))


def _creepages(disc: Discretisation, state: ContactState) -> np.ndarray:
    """vx and vy, given or found."""
    assert disc.loading.motion is not None
    return np.asarray(disc.loading.motion.rigid[:2] + state.rigid / unit_slip(disc))
