"""The theories as methods of `solve`: tractions on the elements of a scene, to be judged like any
others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.reference.creepage_coefficients import creepage_coefficients
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solvers.active_set.tang import no_slip
from varcontact.theories.fastsim import marched_on_grid
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
"""From the state with a pressure, dimensionless as the discretisation has it, to that with
tractions and slip area."""
MAX_CORRECTIONS, MISSED = 100, 1e-12
"""Corrections of the tractions at most, and what of f Fz they may miss of the table book's
forces."""


def why_not(name: str, scene: Scene) -> str:
    """Why a theory of `THEORIES` cannot treat a scene, as the end of a sentence about it; empty
    where it can.
    """
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
    elif name != "linear" and not (
        isinstance(scene.friction, float) and 0 < scene.friction < np.inf
    ):
        return "it is for one finite coefficient of friction"
    if name != "linear" and scene.edge != "centres":
        return (
            f'its tractions are those at the centres of elements, and grid.edge is "{scene.edge}"'
        )
    if name == "table" and scene.hertz is not None:
        return why_not_in_book(scene.hertz.a / scene.hertz.b, scene.bodies.combined_nu)
    if name == "vermeulen-johnson" and scene.motion.spin != 0:
        return f"it is for rolling without spin, and spin is {scene.motion.spin:.3g}"
    return ""


class _Contact:
    """A Hertzian contact in steady rolling on the elements; what is not `disc` and `state` is in
    the scene's units.
    """

    def __init__(self, disc: Discretisation, state: ContactState) -> None:
        hertz, motion, law = disc.hertz, disc.loading.motion, disc.loading.law
        friction = disc.loading.coefficient if law is None else law.static
        assert hertz is not None
        assert isinstance(motion, Steady)
        assert isinstance(friction, float)
        self.disc, self.state, self.grid, self.motion = disc, state, disc.grid, motion
        self.a, self.b, self.limit = hertz.a, hertz.b, friction * hertz.force
        self.G, self.nu = disc.bodies.combined_G, disc.bodies.combined_nu
        self.table = creepage_coefficients(hertz.a, hertz.b, self.nu)
        # friction times Hertz's pressure, and times a parabolic one with the same total
        self.x, self.y = np.meshgrid(disc.grid.x, disc.grid.y)
        elliptic = friction * disc.scales.pressure * state.pressure
        height = np.maximum(1 - (self.x / self.a) ** 2 - (self.y / self.b) ** 2, 0.0) * (
            elliptic > 0
        )
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
        L, law = flexibilities_of(self.at(creepage), flexibility), self.disc.loading.law
        limits = self.bounds[bound] / (1.0 if law is None else law.static)
        return marched_on_grid(
            self.grid, self.a, self.b, L, limits, creepage, law, self.state.branch
        )


Found = tuple[np.ndarray, np.ndarray]
"""Tractions (2, ny, nx), and where it slips."""


def _closed_form(
    state: ContactState, traction: np.ndarray, rigid: np.ndarray, slips: np.ndarray
) -> ContactState:
    status = {**state.status, "tangential": "closed form"}
    return replace(state, traction=traction, rigid=rigid, slips=slips, status=status)


def _linear(disc: Discretisation, state: ContactState) -> ContactState:
    """Tractions that stick everywhere, however large: Kalker's linear theory on these elements."""
    problem = disc.tangential_problem(state.pressure)
    raw = no_slip(problem)
    return _closed_form(
        state, *problem.on_grid(raw.traction, raw.rigid), np.zeros(disc.grid.shape, dtype=bool)
    )


def _of(
    tractions: Callable[..., Found],
    formula: Callable[[Contact], Forces] | None = None,
    **options: Any,
) -> Theory:
    """The theory of tractions by creepages, of which those are sought that give prescribed forces.

    Forces are those of a formula, or of the tractions, up to all that the elements can carry.
    """

    def theory(disc: Discretisation, state: ContactState) -> ContactState:
        contact, scales, step = _Contact(disc, state), disc.scales, disc.step
        assert step is not None

        def force(creepage: np.ndarray) -> np.ndarray:
            if formula is None:
                return contact.total(tractions(contact, creepage, **options)[0])
            return np.array(formula(contact.at(creepage))[:2])

        motion = contact.motion
        limit = (
            float(contact.bounds["elliptic"].sum()) * contact.grid.area
            if formula is None
            else contact.limit
        )
        unit = 3 * limit / (contact.G * contact.a * contact.b * contact.table.C11)
        given, prescribed = np.array(motion.rigid), (motion.Fx, motion.Fy)
        creepage = creepage_carrying(force, given, prescribed, unit, limit)
        traction, slips = tractions(contact, creepage, **options)
        rigid = np.asarray((creepage - given)[:2] * step * scales.length / scales.displacement)
        return _closed_form(state, traction / scales.pressure, rigid, slips & (state.pressure > 0))

    return theory


def _fastsim(
    contact: _Contact, creepage: np.ndarray, bound: str = "parabolic", flexibility: str = "separate"
) -> Found:
    """FASTSIM at the element centres."""
    traction, slip = contact.marched(creepage, bound, flexibility)
    return traction, np.any(slip, axis=0)


def _strip(contact: _Contact, creepage: np.ndarray, kalker: bool) -> Found:
    """Strip theory; with Kalker's slopes FaStrip, whose tractions in the slip area point as those
    of FASTSIM.
    """
    bound, peak = (
        contact.bounds["elliptic"],
        PEAK["elliptic"] * contact.limit / (contact.a * contact.b),
    )
    across, place = contact.grid.y[:, None] / contact.b, contact.grid.x[None, :] / contact.a
    edge = np.sqrt(np.maximum(1 - across**2, 0.0))
    X, Y, x_by_place, turn = strip_creepages(contact.at(creepage), kalker)
    x = X - across * x_by_place
    y = np.full_like(x, Y)
    d = slip_depth(x, y, turn, edge)
    outer = np.sqrt(np.maximum(edge**2 - place**2, 0.0))
    inner = np.sqrt(np.maximum((edge - d) ** 2 - (place - d) ** 2, 0.0))
    # the difference of the circles' heights by that of the squares
    less = 2 * (edge - place) / np.maximum(outer + inner, SMALLEST)
    sticking = -peak * np.stack([less * x, less * (y + turn * d) + turn * inner])
    toward = np.stack(np.broadcast_arrays(x, y + turn * place))
    if kalker:
        toward = -contact.marched(creepage, "parabolic")[0]
    size = np.hypot(*toward)
    slips = (place <= 2 * d - edge) & (bound > 0)
    traction = np.where(
        slips, -bound * toward / np.where(size > 0, size, 1.0), np.where(bound > 0, sticking, 0.0)
    )
    size = np.hypot(*traction)
    return traction * np.minimum(1.0, bound / np.where(size > 0, size, 1.0)), slips


def _vermeulen_johnson(contact: _Contact, creepage: np.ndarray) -> Found:
    """Tractions of the form that Vermeulen and Johnson assume, scaled to carry the force of
    Kalker's line exactly.
    """
    a, b, limit, x, y = contact.a, contact.b, contact.limit, contact.x, contact.y
    force = np.hypot(*vermeulen_johnson_forces(contact.at(creepage))[:2])
    traction = vermeulen_johnson_traction(x, y, a, b, contact.G, limit, creepage, contact.table)
    traction *= contact.state.pressure > 0
    carried = np.hypot(*contact.total(traction))
    r = max(1 - force / limit, 0.0) ** (1 / 3)
    stick = (x / a - (1 - r)) ** 2 + (y / b) ** 2 < r**2
    return traction * (force / carried if carried > 0 else 0.0), ~stick


def _polach(contact: _Contact, creepage: np.ndarray) -> Found:
    """The force of Polach's formula, by the tractions he assumes: linear in x up to Hertz's bound.

    They have the direction of the force, are sampled at the element centres and scaled to carry
    exactly that force.
    """
    from scipy.optimize import brentq

    a, b, limit = contact.a, contact.b, contact.limit
    carried = np.array(polach_forces(contact.at(creepage))[:2])
    part = float(np.hypot(*carried)) / limit
    gradient = 1e9  # e of the formula that carries this part of f Fz without spin
    if part < 1 - 1e-9:
        gradient = brentq(
            lambda e: 2 / np.pi * (e / (1 + e * e) + np.arctan(e)) - part, 0.0, 1e9, xtol=1e-14
        )
    slope = gradient * PEAK["elliptic"] * limit / (a**2 * b)
    shape = -simplified_traction(contact.x, contact.y, a, b, 1.0, limit, slope, 0.0, "elliptic")[0]
    shape *= contact.state.pressure > 0
    total = shape.sum() * contact.grid.area
    traction = np.multiply.outer(carried / total if total > 0 else np.zeros(2), shape)
    return traction, shape >= contact.bounds["elliptic"] * (1 - 1e-3)


def _table(contact: _Contact, creepage: np.ndarray) -> Found:
    """Tractions that carry forces and moment of the table book, within the traction bound.

    A book has no tractions. To those of FASTSIM fields in proportion to the traction bound are
    added until all three resultants are met, or the bound is reached everywhere.
    """
    limit, bound = contact.limit, contact.bounds["elliptic"]
    traction = contact.marched(creepage, "elliptic")[0]
    size = float(np.sqrt(contact.a * contact.b))
    wanted = np.array(table_resultants(contact.at(creepage))) / (1.0, 1.0, size)
    x, y = contact.x / size, contact.y / size
    zero, one = np.zeros_like(x), np.ones_like(x)
    moments = np.stack([[one, zero], [zero, one], [-y, x]]) * contact.grid.area
    fields = moments * bound
    matrix = np.einsum("icyx,jcyx->ij", moments, fields)
    for _ in range(MAX_CORRECTIONS):
        missing = wanted - np.einsum("icyx,cyx->i", moments, traction)
        if np.abs(missing).max() < MISSED * limit:
            break
        traction = traction + np.tensordot(np.linalg.solve(matrix, missing), fields, 1)
        traction = traction * np.minimum(
            1.0, bound / np.maximum(np.hypot(*traction), np.finfo(float).tiny)
        )
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
