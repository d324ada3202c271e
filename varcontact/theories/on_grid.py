"""The theories as methods of `solve`: tractions on the elements of a scene, to be judged like any
others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.problems import RawSolution, TangentialProblem
from varcontact.discrete.state import ContactState
from varcontact.discrete.stick_slip import unit_slip
from varcontact.interfaces.potential import Potential
from varcontact.reference.creepage_coefficients import no_slip_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.motion import Shift, Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.transient import Transient
from varcontact.solvers.active_set.tang import no_slip
from varcontact.solvers.interface import SHORT_STEP, Settings
from varcontact.system.process import changed
from varcontact.theories.fastsim import marched_on_grid, stepped_on_grid
from varcontact.theories.force_inversion import creepage_carrying
from varcontact.theories.linear import Contact, Forces
from varcontact.theories.polach import polach_forces
from varcontact.theories.simplified import PEAK, flexibilities_of, simplified_traction
from varcontact.theories.strip_theory import SMALLEST, slip_depth, strip_creepages
from varcontact.theories.table import table_resultants, why_not_in_book
from varcontact.theories.vermeulen_johnson import (
    vermeulen_johnson_forces,
    vermeulen_johnson_traction,
)

Theory = Callable[[Discretisation, ContactState], ContactState]
"""Function from the state with a pressure, dimensionless as in the discretisation, to the state
with tractions and slip area."""
MAX_CORRECTIONS = 100
"""Most corrections of the tractions by which they carry the table book's forces."""
RESULTANT_TOL = 1e-12
"""Tolerance on the difference from the table book's forces, relative to f Fz."""
IN_TIME = ("fastsim", "fastsim-elliptic")
"""Theories that also treat shifts and histories, whose flexibilities do not depend on creepages."""
DIRECT_ELEMENTS = 200
"""Elements up to which tractions that stick everywhere are found by the dense matrix: beyond, it
takes longer than products (`python -m tests.benchmarks speed small_work`)."""
GRADIENT_MAX = 1e9
"""Gradient of Polach's formula that counts as full slip."""


def why_not(name: str, scene: Scene) -> str:
    """Reason why a theory of `THEORIES` cannot treat a scene, as the end of a sentence about it;
    empty where it can.
    """
    return (
        _why_not_contact(scene)
        or _why_not_motion(name, scene)
        or _why_not_friction(name, scene)
        or _why_not_theory(name, scene)
    )


def _why_not_contact(scene: Scene) -> str:
    """Reason for all theories: bodies and surface."""
    if not isinstance(scene.bodies, Bodies):
        return "it is for half-spaces, and the bodies are none"
    if not scene.bare:
        return "it is for bodies that touch, and there is a third body"
    if scene.loaded:
        return "it is for bodies without loads beside the contact"
    if scene.bodies.coupled:
        return f"it is for quasi-identical bodies (K = 0), and K is {scene.bodies.K:.3g}"
    sampled = any(isinstance(surface, SampledDistance) for surface in scene.surfaces)
    rough = isinstance(scene.motion, Transient) and bool(scene.motion.heights)
    if scene.line or sampled or rough:
        return "it is for elliptic contacts"
    return ""


def _why_not_motion(name: str, scene: Scene) -> str:
    motion = scene.motion
    if isinstance(motion, Steady):
        return ""
    if not isinstance(motion, Shift | Transient):
        return "it is for rolling and shifts"
    if name not in IN_TIME:
        return f"it is for steady rolling; in time and in shifts there are {' and '.join(IN_TIME)}"
    if scene.under_law:
        return "under a law of friction it is for steady rolling"
    return ""


def _why_not_friction(name: str, scene: Scene) -> str:
    if isinstance(scene.friction, Law):
        return _why_not_law(name, scene.friction, scene.motion)
    finite = [isinstance(each, float) and 0 < each < np.inf for each in scene.frictions]
    if name == "linear" or all(finite):
        return ""
    return "it is for one finite coefficient of friction"


def _why_not_law(name: str, law: Law, motion: Any) -> str:
    if law.local:
        return "it is for friction by slip alone, not by temperature, pressure or place"
    if name in ("vermeulen-johnson", "strip", "fastrip", "polach", "table"):
        return "it is for one finite coefficient of friction, not for a law"
    if law.memory_distance > 0:
        return "it is for friction without memory"
    if name != "linear" and (motion.Fx is not None or motion.Fy is not None):
        return (
            "under a law of friction the force may fall with creepage, "
            "so that creepages are needed, not forces"
        )
    return ""


def _why_not_theory(name: str, scene: Scene) -> str:
    """Reason by the grid's edge, the table book's range, and spin."""
    if name != "linear" and scene.edge != "centres":
        return (
            f'its tractions are those at the centres of elements, and grid.edge is "{scene.edge}"'
        )
    bodies, hertz, motion = scene.bodies, scene.hertz, scene.motion
    if name == "table" and hertz is not None and isinstance(bodies, Bodies):
        return why_not_in_book(hertz.a / hertz.b, bodies.combined_nu)
    if name == "vermeulen-johnson" and isinstance(motion, Steady) and motion.spin != 0:
        return f"it is for rolling without spin, and spin is {motion.spin:.3g}"
    return ""


class _Contact:
    """A Hertzian contact on the elements, in the scene's units but for `disc` and `state`."""

    def __init__(self, disc: Discretisation, state: ContactState) -> None:
        hertz = disc.hertz
        motion = disc.loading.motion
        friction = disc.coefficient
        assert hertz is not None
        assert isinstance(motion, Steady | Shift | TimeStep)
        assert isinstance(friction, float)
        self.disc = disc
        self.state = state
        self.grid = disc.grid
        self.motion = motion
        self.a = hertz.a
        self.b = hertz.b
        self.limit = friction * hertz.force
        self.G = disc.bodies.combined_G
        self.nu = disc.bodies.combined_nu
        self.table = no_slip_coefficients(hertz.a / hertz.b, self.nu)
        self.x, self.y = disc.grid.centres
        # friction times Hertz's pressure, and times a parabolic one with the same total
        elliptic = friction * disc.scales.pressure * state.pressure
        height = np.maximum(1 - (self.x / self.a) ** 2 - (self.y / self.b) ** 2, 0.0)
        height = height * (elliptic > 0)
        self.bounds = {"elliptic": elliptic, "parabolic": elliptic.sum() * height / height.sum()}

    def at(self, creepage: Sequence[float] | np.ndarray) -> Contact:
        """The arguments of a theory."""
        vx, vy, spin = map(float, creepage)
        return Contact(self.a, self.b, self.G, self.nu, self.limit, vx, vy, spin, 1.0, self.table)

    def total(self, traction: np.ndarray) -> np.ndarray:
        """The force of tractions."""
        return np.asarray(traction.sum(axis=(1, 2)) * self.grid.area)

    def marched(
        self, creepage: np.ndarray, bound: str, flexibility: str = "separate"
    ) -> tuple[np.ndarray, np.ndarray]:
        """Tractions and slip by FASTSIM at the element centres."""
        L = flexibilities_of(self.at(creepage), flexibility)
        law = self.disc.loading.scene.friction
        limits = self.bounds[bound]
        if isinstance(law, Law):
            limits = limits / law.static
        else:
            law = None
        axes = (self.a, self.b)
        return marched_on_grid(self.grid, axes, L, limits, creepage, law, self.state.branch)

    @property
    def dq(self) -> float:
        """Distance rolled in a step; 0 in place."""
        if self.disc.step is None:
            return 0.0
        return self.disc.step * self.disc.scales.length

    def stepped(self, creepage: np.ndarray, bound: str) -> Tractions:
        """Tractions and slip area after a step of FASTSIM in time."""
        before = np.zeros((2, *self.grid.shape))
        previous = self.disc.loading.previous_step
        if previous is not None:
            before = self.disc.scales.pressure * previous.traction
        gradient = creepage / flexibilities_of(self.at(creepage), "separate")
        axes = (self.a, self.b)
        travel = (self.motion.rolls, self.dq)
        return stepped_on_grid(self.grid, axes, gradient, self.bounds[bound], before, travel)


Tractions = tuple[np.ndarray, np.ndarray]
"""Tractions (2, ny, nx), and True for elements that slip (ny, nx)."""


def _closed_form(
    state: ContactState, traction: np.ndarray, rigid: np.ndarray, slips: np.ndarray
) -> ContactState:
    status = {**state.status, "tangential": "closed form"}
    return changed(state, traction=traction, rigid=rigid, slips=slips, status=status)


def _linear(disc: Discretisation, state: ContactState) -> ContactState:
    """Tractions that stick everywhere, however large: Kalker's linear theory on these elements."""
    problem = disc.tangential_problem(state.pressure)
    assert disc.step is not None
    short = disc.step < SHORT_STEP * disc.lattice.sides[0]
    raw = _sticking(problem, directly=short or problem.size <= DIRECT_ELEMENTS)
    return _closed_form(
        state, *problem.on_grid(raw.traction, raw.rigid), np.zeros(disc.grid.shape, dtype=bool)
    )


def _sticking(problem: TangentialProblem, directly: bool) -> RawSolution:
    """Tractions in full stick, by the dense matrix or without it."""
    if not directly:
        from varcontact.solvers.newton.tangential import newton_tangential

        unbounded = Potential(np.full(problem.size, np.inf))
        raw = newton_tangential(replace(problem, potential=unbounded), Settings())
        if raw.solved:
            return raw
    return no_slip(problem)


def _of(
    tractions: Callable[..., Tractions],
    formula: Callable[[Contact], Forces] | None = None,
    **options: Any,
) -> Theory:
    """Theory of tractions by creepages, after a search for the creepages that give prescribed
    forces.

    Forces are those of a formula, or of the tractions, up to all that the elements can carry.
    """

    def theory(disc: Discretisation, state: ContactState) -> ContactState:
        contact = _Contact(disc, state)

        def force(creepage: np.ndarray) -> np.ndarray:
            if formula is None:
                return contact.total(tractions(contact, creepage, **options)[0])
            return np.array(formula(contact.at(creepage))[:2])

        motion = contact.motion
        limit = contact.limit
        if formula is None:
            limit = float(contact.bounds["elliptic"].sum()) * contact.grid.area
        unit = 3 * limit / (contact.G * contact.a * contact.b * contact.table.C11)
        if not isinstance(motion, Steady):  # all of the contact is left in 2a/dq steps
            unit *= contact.a / (contact.dq or 1.0)
        prescribed = np.array(motion.rigid)
        creepage = creepage_carrying(force, prescribed, (motion.Fx, motion.Fy), unit, limit)
        traction, slips = tractions(contact, creepage, **options)
        change = (creepage - prescribed)[:2]
        rigid = np.asarray(change * unit_slip(disc))
        traction = traction / disc.scales.pressure
        return _closed_form(state, traction, rigid, slips & (state.pressure > 0))

    return theory


def _fastsim(
    contact: _Contact, creepage: np.ndarray, bound: str = "parabolic", flexibility: str = "separate"
) -> Tractions:
    """FASTSIM at the element centres, in a step from the tractions of the step before."""
    if not isinstance(contact.motion, Steady):
        return contact.stepped(creepage, bound)
    traction, slip = contact.marched(creepage, bound, flexibility)
    return traction, np.any(slip, axis=0)


def _strip(contact: _Contact, creepage: np.ndarray, kalker: bool) -> Tractions:
    """Strip theory; with Kalker's slopes FaStrip, whose tractions in the slip area point as those
    of FASTSIM.
    """
    bound = contact.bounds["elliptic"]
    peak = PEAK["elliptic"] * contact.limit / (contact.a * contact.b)
    across = contact.grid.y[:, None] / contact.b
    place = contact.grid.x[None, :] / contact.a
    edge = np.sqrt(np.maximum(1 - across**2, 0.0))
    X, Y, x_by_place, turn = strip_creepages(contact.at(creepage), kalker)
    x = X - across * x_by_place
    y = np.full_like(x, Y)
    d = slip_depth(x, y, turn, edge)
    # the stick area: two circles
    outer = np.sqrt(np.maximum(edge**2 - place**2, 0.0))
    inner = np.sqrt(np.maximum((edge - d) ** 2 - (place - d) ** 2, 0.0))
    # the difference of the circles' heights by that of the squares
    less = 2 * (edge - place) / np.maximum(outer + inner, SMALLEST)
    sticking = -peak * np.stack([less * x, less * (y + turn * d) + turn * inner])
    # the slip area: the bound in the direction of the rigid slip, or of FASTSIM
    toward = np.stack(np.broadcast_arrays(x, y + turn * place))
    if kalker:
        toward = -contact.marched(creepage, "parabolic")[0]
    size = np.hypot(*toward)
    slips = (place <= 2 * d - edge) & (bound > 0)
    slipping = -bound * toward / np.where(size > 0, size, 1.0)
    traction = np.where(slips, slipping, np.where(bound > 0, sticking, 0.0))
    size = np.hypot(*traction)
    return traction * np.minimum(1.0, bound / np.where(size > 0, size, 1.0)), slips


def _vermeulen_johnson(contact: _Contact, creepage: np.ndarray) -> Tractions:
    """Tractions of the form that Vermeulen and Johnson assume, scaled to carry the force of
    Kalker's line exactly.
    """
    a, b = contact.a, contact.b
    x, y = contact.x, contact.y
    limit = contact.limit
    force = np.hypot(*vermeulen_johnson_forces(contact.at(creepage))[:2])
    traction = vermeulen_johnson_traction(x, y, a, b, contact.G, limit, creepage, contact.table)
    traction *= contact.state.pressure > 0
    carried = np.hypot(*contact.total(traction))
    r = max(1 - force / limit, 0.0) ** (1 / 3)
    stick = (x / a - (1 - r)) ** 2 + (y / b) ** 2 < r**2
    scale = force / carried if carried > 0 else 0.0
    return traction * scale, ~stick


def _polach(contact: _Contact, creepage: np.ndarray) -> Tractions:
    """The force of Polach's formula, by the tractions he assumes: linear in x up to Hertz's bound.

    They have the direction of the force, are sampled at the element centres and scaled to carry
    exactly that force.
    """
    from scipy.optimize import brentq

    a, b = contact.a, contact.b
    limit = contact.limit
    carried = np.array(polach_forces(contact.at(creepage))[:2])
    part = float(np.hypot(*carried)) / limit

    def excess(e: float) -> Any:
        return 2 / np.pi * (e / (1 + e * e) + np.arctan(e)) - part

    # e of the formula that carries this part of f Fz without spin
    gradient = GRADIENT_MAX
    if part < 1 - 1e-9:
        gradient = brentq(excess, 0.0, GRADIENT_MAX, xtol=1e-14)
    slope = gradient * PEAK["elliptic"] * limit / (a**2 * b)
    shape = -simplified_traction(contact.x, contact.y, a, b, 1.0, limit, slope, 0.0, "elliptic")[0]
    shape *= contact.state.pressure > 0
    total = shape.sum() * contact.grid.area
    per_shape = carried / total if total > 0 else np.zeros(2)
    traction = np.multiply.outer(per_shape, shape)
    return traction, shape >= contact.bounds["elliptic"] * (1 - 1e-3)


def _table(contact: _Contact, creepage: np.ndarray) -> Tractions:
    """Tractions that carry forces and moment of the table book, within the traction bound.

    A book has no tractions. To those of FASTSIM fields in proportion to the traction bound are
    added until all three resultants are met, or the bound is reached everywhere.
    """
    limit = contact.limit
    bound = contact.bounds["elliptic"]
    traction = contact.marched(creepage, "elliptic")[0]
    length = float(np.sqrt(contact.a * contact.b))
    wanted = np.array(table_resultants(contact.at(creepage))) / (1.0, 1.0, length)
    x, y = contact.x / length, contact.y / length
    zero = np.zeros_like(x)
    one = np.ones_like(x)
    moments = np.stack([[one, zero], [zero, one], [-y, x]]) * contact.grid.area
    fields = moments * bound
    matrix = np.einsum("icyx,jcyx->ij", moments, fields)
    for _ in range(MAX_CORRECTIONS):
        missing = wanted - np.einsum("icyx,cyx->i", moments, traction)
        if np.abs(missing).max() < RESULTANT_TOL * limit:
            break
        traction = traction + np.tensordot(np.linalg.solve(matrix, missing), fields, 1)
        size = np.maximum(np.hypot(*traction), np.finfo(float).tiny)
        traction = traction * np.minimum(1.0, bound / size)
    return traction, np.hypot(*traction) >= bound * (1 - 1e-9)


THEORIES: dict[str, Theory] = {
    "fastsim": _of(_fastsim),
    "fastsim-elliptic": _of(_fastsim, bound="elliptic"),
    "fastsim-weighted": _of(_fastsim, flexibility="weighted"),
    "fastsim-weighted-elliptic": _of(_fastsim, bound="elliptic", flexibility="weighted"),
    "fastrip": _of(_strip, kalker=True),
    "strip": _of(_strip, kalker=False),
    "polach": _of(_polach, polach_forces),
    "linear": _linear,
    "table": _of(_table, table_resultants),
    "vermeulen-johnson": _of(_vermeulen_johnson, vermeulen_johnson_forces),
}
