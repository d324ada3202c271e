"""The theories as methods of `solve`: tractions on the elements of a scene, to be judged like any others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.reference.creepage_coefficients import CreepageCoefficients, creepage_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solvers.active_set.tang import no_slip
from varcontact.theories.fastsim import fastsim_on_grid, marched_on_grid
from varcontact.theories.force_inversion import creepage_carrying
from varcontact.theories.linear import Contact
from varcontact.theories.polach import polach
from varcontact.theories.simplified import PEAK, flexibilities_of, simplified_traction
from varcontact.theories.strip_theory import SMALLEST, slip_depth, strip_creepages
from varcontact.theories.table import table_forces, why_not_in_book
from varcontact.theories.vermeulen_johnson import (
    vermeulen_johnson,
    vermeulen_johnson_creepage,
    vermeulen_johnson_traction,
)

Theory = Callable[[Discretisation, ContactState], ContactState]
"""From the state with a pressure, dimensionless as the discretisation has it, to that with tractions and slip area."""
MAX_CORRECTIONS, MISSED = 100, 1e-12
"""Corrections of the tractions at most, and what of f Fz they may miss of the table book's forces."""


def why_not(name: str, scene: Scene) -> str:
    """Why a theory of `THEORIES` cannot treat a scene, as the end of a sentence about it; empty where it can."""
    if not isinstance(scene.bodies, Bodies):
        return "it is for half-spaces, and the bodies are none"
    if scene.third_body is not None:
        return "it is for bodies that touch, and there is a third body"
    if scene.bodies.coupled:
        return f"it is for quasi-identical bodies (K = 0), and K is {scene.bodies.K:.3g}"
    if scene.line or isinstance(scene.surface, SampledDistance):
        return "it is for elliptic contacts"
    if not isinstance(scene.motion, Steady):
        return "it is for steady rolling"
    if isinstance(scene.friction, Law):
        if scene.friction.local:
            return "it is for friction by slip alone, not by temperature, pressure or place"
        if name in ("vermeulen-johnson", "strip", "fastrip", "polach", "table"):
            return "it is for one finite coefficient of friction, not for a law"
        if scene.friction.memory_distance > 0:
            return "it is for friction without memory"
        if name != "linear" and (scene.motion.Fx is not None or scene.motion.Fy is not None):
            return "under a law of friction the force may fall with creepage, so that creepages are needed, not forces"
    elif name != "linear" and not (isinstance(scene.friction, float) and 0 < scene.friction < np.inf):
        return "it is for one finite coefficient of friction"
    if name != "linear" and scene.edge != "centres":
        return f'its tractions are those at the centres of elements, and grid.edge is "{scene.edge}"'
    if name == "table" and scene.hertz is not None:
        return why_not_in_book(scene.hertz.a / scene.hertz.b, scene.bodies.combined_nu)
    if name == "vermeulen-johnson" and scene.motion.spin != 0:
        return f"it is for rolling without spin, and spin is {scene.motion.spin:.3g}"
    return ""


@dataclass(frozen=True, eq=False)
class _Contact:
    """A Hertzian contact in steady rolling on the elements; what is not `disc` and `state` is in the scene's units."""

    disc: Discretisation
    state: ContactState
    motion: Steady
    a: float
    b: float
    G: float
    friction: float
    limit: float
    coefficients: CreepageCoefficients

    @classmethod
    def of(cls, disc: Discretisation, state: ContactState) -> _Contact:
        hertz, motion, law = disc.hertz, disc.loading.motion, disc.loading.law
        friction = disc.loading.coefficient if law is None else law.static
        assert hertz is not None
        assert isinstance(motion, Steady)
        assert isinstance(friction, float)
        coefficients = creepage_coefficients(hertz.a, hertz.b, disc.bodies.combined_nu)
        G, limit = disc.bodies.combined_G, friction * hertz.force
        return cls(disc, state, motion, hertz.a, hertz.b, G, friction, limit, coefficients)

    def pressure(self, form: str) -> np.ndarray:
        """Hertz's pressure, or a parabolic one with the same total."""
        inside = self.state.pressure
        if form == "elliptic":
            return np.asarray(inside * self.disc.scales.pressure)
        x, y = self.disc.grid.x[None, :] / self.a, self.disc.grid.y[:, None] / self.b
        height = np.maximum(1 - x**2 - y**2, 0.0) * (inside > 0)
        return np.asarray(inside.sum() * self.disc.scales.pressure * height / height.sum())

    def total(self, traction: np.ndarray) -> np.ndarray:
        """The force of tractions."""
        return np.asarray(traction.sum(axis=(1, 2)) * self.disc.grid.area)

    def creepage(self, force: Callable[[np.ndarray], np.ndarray], limit: float) -> np.ndarray:
        """The creepage; where forces below a limit are prescribed, that for which a theory gives them."""
        motion = self.motion
        if motion.Fx is None and motion.Fy is None:
            return np.array(motion.rigid)
        unit = 3 * limit / (self.G * self.a * self.b * self.coefficients.C11)
        given = np.array([motion.vx, motion.vy, motion.spin])
        return creepage_carrying(force, given, (motion.Fx, motion.Fy), unit, limit, limit)

    def result(self, traction: np.ndarray, creepage: np.ndarray, slips: np.ndarray) -> ContactState:
        """The state with dimensionless tractions, and with the rigid shift of creepages found in place of forces."""
        disc, step = self.disc, self.disc.step
        assert step is not None
        rigid = np.asarray(
            (creepage[:2] - np.array(self.motion.rigid[:2])) * step * disc.scales.length / disc.scales.displacement
        )
        return _closed_form(self.state, traction, rigid, slips & (self.state.pressure > 0))


def _closed_form(state: ContactState, traction: np.ndarray, rigid: np.ndarray, slips: np.ndarray) -> ContactState:
    status = {**state.status, "tangential": "closed form"}
    return replace(state, traction=traction, rigid=rigid, slips=slips, status=status)


def _linear(disc: Discretisation, state: ContactState) -> ContactState:
    """Tractions that stick everywhere, however large: Kalker's linear theory on these elements."""
    problem = disc.tangential_problem(state.pressure)
    raw = no_slip(problem)
    return _closed_form(state, *problem.on_grid(raw.traction, raw.rigid), np.zeros(disc.grid.shape, dtype=bool))


def _fastsim(
    disc: Discretisation, state: ContactState, bound: str = "parabolic", flexibility: str = "separate"
) -> ContactState:
    """FASTSIM at the element centres, which meets prescribed forces up to all that its elements can carry."""
    contact = _Contact.of(disc, state)
    a, b, G = contact.a, contact.b, contact.G
    grid, pressure = disc.grid, contact.pressure(bound)

    def flexibilities(creepage: np.ndarray) -> np.ndarray:
        return flexibilities_of(a, b, G, creepage, contact.coefficients, flexibility)

    if disc.loading.law is not None:
        creepage = np.array(contact.motion.rigid)
        L, law, start = flexibilities(creepage), disc.loading.law, state.branch
        traction, slip = marched_on_grid(grid, a, b, L, pressure, creepage, law, start)
        return contact.result(traction / disc.scales.pressure, creepage, np.any(slip, axis=0))
    limits = contact.friction * pressure

    def tractions(creepage: np.ndarray) -> np.ndarray:
        return fastsim_on_grid(grid, a, b, flexibilities(creepage), limits, creepage)

    carried = float(limits.sum()) * grid.area
    creepage = contact.creepage(lambda creepage: contact.total(tractions(creepage)), carried)
    traction = tractions(creepage)
    slips = np.hypot(*traction) >= limits * (1 - 1e-9)
    return contact.result(traction / disc.scales.pressure, creepage, slips)


def _strip(disc: Discretisation, state: ContactState, name: str) -> ContactState:
    contact = _Contact.of(disc, state)
    a, b, G, nu, table = contact.a, contact.b, contact.G, disc.bodies.combined_nu, contact.coefficients
    bound = contact.friction * contact.pressure("elliptic")

    def found(creepage: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        against = None
        if name == "fastrip":
            L = flexibilities_of(a, b, G, creepage, table, "separate")
            parabolic = contact.pressure("parabolic") * contact.friction
            against = -fastsim_on_grid(disc.grid, a, b, L, parabolic, creepage)
        vx, vy, spin = creepage
        at = Contact(a, b, G, nu, contact.limit, vx, vy, spin, 1.0, table)
        return _strip_tractions(contact, bound, strip_creepages(at, kalker=name == "fastrip"), against)

    carried = float(bound.sum()) * disc.grid.area
    creepage = contact.creepage(lambda creepage: contact.total(found(creepage)[0]), carried)
    traction, slips = found(creepage)
    return contact.result(traction / disc.scales.pressure, creepage, slips)


def _strip_tractions(
    contact: _Contact, bound: np.ndarray, scaled: tuple[Any, Any, Any, Any], against: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions by creepages as `strip_creepages` scales them, and where they slip.

    In the slip area they point against the rigid slip, or against the vectors `against` (2, ny, nx).
    """
    a, b, grid = contact.a, contact.b, contact.disc.grid
    X, Y, x_by_place, turn = scaled
    across, place = grid.y[:, None] / b, grid.x[None, :] / a
    edge = np.sqrt(np.maximum(1 - across**2, 0.0))
    x = X - across * x_by_place
    y = np.full_like(x, Y)
    d = slip_depth(x, y, turn, edge)
    outer = np.sqrt(np.maximum(edge**2 - place**2, 0.0))
    inner = np.sqrt(np.maximum((edge - d) ** 2 - (place - d) ** 2, 0.0))
    slips = (place <= 2 * d - edge) & (bound > 0)
    # S - s by the difference of the squares
    less = 2 * (edge - place) / np.maximum(outer + inner, SMALLEST)
    sticking = -np.stack([less * x, less * (y + turn * d) + turn * inner]) * PEAK["elliptic"] * contact.limit / (a * b)
    toward = np.stack(np.broadcast_arrays(x, y + turn * place)) if against is None else against
    size = np.hypot(*toward)
    sliding = -bound * toward / np.where(size > 0, size, 1.0)
    traction = np.where(slips, sliding, np.where(bound > 0, sticking, 0.0))
    size = np.hypot(*traction)
    return traction * np.minimum(1.0, bound / np.where(size > 0, size, 1.0)), slips


def _vermeulen_johnson(disc: Discretisation, state: ContactState) -> ContactState:
    """Tractions of the form that Vermeulen and Johnson assume, scaled to carry the force of Kalker's line exactly."""
    contact = _Contact.of(disc, state)
    a, b, G, motion = contact.a, contact.b, contact.G, contact.motion
    limit, table = contact.limit, contact.coefficients
    creepage = np.array(motion.rigid)
    if motion.Fx is not None or motion.Fy is not None:
        vx, vy = None if motion.Fx is not None else motion.vx, None if motion.Fy is not None else motion.vy
        creepage = vermeulen_johnson_creepage(a, b, G, limit, table, vx=vx, vy=vy, Fx=motion.Fx, Fy=motion.Fy)
    force = vermeulen_johnson(a, b, G, limit, creepage, table)
    x, y = np.meshgrid(disc.grid.x, disc.grid.y)
    traction = vermeulen_johnson_traction(x, y, a, b, G, limit, creepage, table) * (state.pressure > 0)
    carried = np.hypot(*contact.total(traction))
    scale = np.hypot(*force) / carried if carried > 0 else 0.0
    r = max(1 - np.hypot(*force) / limit, 0.0) ** (1 / 3)
    stick = np.zeros(x.shape, dtype=bool)
    if r > 0:
        stick = ((x - a * (1 - r)) / a) ** 2 + (y / b) ** 2 < r**2
    return contact.result(traction * scale / disc.scales.pressure, creepage, ~stick)


def _polach(disc: Discretisation, state: ContactState) -> ContactState:
    """The force of Polach's formula, by the tractions he assumes: linear in x up to Hertz's bound.

    They have the direction of the force, are sampled at the element centres and scaled to carry exactly that force.
    """
    from scipy.optimize import brentq

    contact = _Contact.of(disc, state)
    a, b, G, limit, table = contact.a, contact.b, contact.G, contact.limit, contact.coefficients

    def force(creepage: np.ndarray) -> np.ndarray:
        return polach(a, b, G, limit, creepage, table)

    creepage = contact.creepage(force, limit)
    carried = force(creepage)
    part = float(np.hypot(*carried)) / limit
    if part == 0:
        return contact.result(np.zeros((2, *disc.grid.shape)), creepage, np.zeros(disc.grid.shape, dtype=bool))
    gradient = 1e9  # e of the formula that carries this part of f Fz without spin
    if part < 1 - 1e-9:
        gradient = brentq(lambda e: 2 / np.pi * (e / (1 + e * e) + np.arctan(e)) - part, 0.0, 1e9, xtol=1e-14)
    L = 8 * a / (3 * G * table.C11)
    slope = gradient * PEAK["elliptic"] * limit * L / (a**2 * b)
    x, y = np.meshgrid(disc.grid.x, disc.grid.y)
    shape = -simplified_traction(x, y, a, b, L, limit, slope, 0.0, "elliptic")[0] * (state.pressure > 0)
    total = shape.sum() * disc.grid.area
    traction = np.multiply.outer(carried / total if total > 0 else np.zeros(2), shape)
    bound = contact.friction * contact.pressure("elliptic")
    return contact.result(traction / disc.scales.pressure, creepage, shape >= bound * (1 - 1e-3))


def _table(disc: Discretisation, state: ContactState) -> ContactState:
    """Tractions that carry forces and moment of the table book, within the traction bound.

    A book has no tractions. To those of FASTSIM fields in proportion to the traction bound are added until all three
    resultants are met, or the bound is reached everywhere.
    """
    contact = _Contact.of(disc, state)
    a, b, G, limit = contact.a, contact.b, contact.G, contact.limit
    creepage = contact.creepage(lambda creepage: table_forces(a, b, G, limit, creepage).force, limit)
    found = table_forces(a, b, G, limit, creepage)
    vx, vy, spin = map(float, creepage)
    free = disc.with_loading(motion=replace(contact.motion, vx=vx, vy=vy, spin=spin, Fx=None, Fy=None))
    traction = _fastsim(free, state, "elliptic").traction
    size = float(np.sqrt(a * b))
    wanted = np.array([*found.force, float(found.moment) / size]) / limit
    bound = contact.friction * state.pressure
    x, y = np.meshgrid(disc.grid.x / size, disc.grid.y / size)
    zero, one, weight = np.zeros_like(x), np.ones_like(x), bound / bound.sum()
    fields = np.stack([[weight, zero], [zero, weight], [-y * weight, x * weight]])
    moments = np.stack([[one, zero], [zero, one], [-y, x]]) / bound.sum()
    matrix = np.einsum("icyx,jcyx->ij", moments, fields) * bound.sum()
    for _ in range(MAX_CORRECTIONS):
        missing = wanted - np.einsum("icyx,cyx->i", moments, traction)
        if np.abs(missing).max() < MISSED:
            break
        traction = traction + bound.sum() * np.tensordot(np.linalg.solve(matrix, missing), fields, 1)
        traction = traction * np.minimum(1.0, bound / np.maximum(np.hypot(*traction), np.finfo(float).tiny))
    return contact.result(traction, creepage, np.hypot(*traction) >= bound * (1 - 1e-9))


THEORIES: dict[str, Theory] = {
    "fastsim": _fastsim,
    "fastsim-elliptic": partial(_fastsim, bound="elliptic"),
    "fastsim-weighted": partial(_fastsim, flexibility="weighted"),
    "fastsim-weighted-elliptic": partial(_fastsim, bound="elliptic", flexibility="weighted"),
    "fastrip": partial(_strip, name="fastrip"),
    "strip": partial(_strip, name="strip"),
    "polach": _polach,
    "linear": _linear,
    "table": _table,
    "vermeulen-johnson": _vermeulen_johnson,
}
