"""The theories as methods of `solve`: tractions on the elements of a scene, to be judged like any others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.errors import Saturated
from varcontact.reference.creepage_coefficients import CreepageCoefficients, creepage_coefficients
from varcontact.scene.friction import Law
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.solvers.active_set.tang import no_slip
from varcontact.theories.fastsim import fastsim_on_grid
from varcontact.theories.fastsim_law import on_grid as fastsim_on_grid_under_law
from varcontact.theories.polach import polach
from varcontact.theories.prescribed import creepages_meeting
from varcontact.theories.simplified import PEAK, flexibilities_of, simplified_traction
from varcontact.theories.strip_grid import strip_on_grid
from varcontact.theories.strip_theory import kalker_factors
from varcontact.theories.table_method import table_tractions, why_not_in_book
from varcontact.theories.vermeulen_johnson import (
    vermeulen_johnson,
    vermeulen_johnson_creepage,
    vermeulen_johnson_traction,
)

Theory = Callable[[Discretisation, ContactState], ContactState]
"""From the state with a pressure, dimensionless as the discretisation has it, to that with tractions and slip area."""


def why_not(name: str, scene: Scene) -> str:
    """Why a theory cannot treat a scene, or nothing where it can.

    Parameters
    ----------
    name : str
        A key of `THEORIES`.
    scene : Scene

    Returns
    -------
    str
        The end of a sentence about the theory.
    """
    if scene.bodies.K != 0:
        return f"it is for quasi-identical bodies (K = 0), and K is {scene.bodies.K:.3g}"
    if scene.line or isinstance(scene.surface, SampledDistance):
        return "it is for elliptic contacts"
    if not isinstance(scene.motion, Steady):
        return "it is for steady rolling"
    if isinstance(scene.friction, Law):
        if name in ("vermeulen-johnson", "strip", "fastrip", "polach", "table"):
            return "it is for one finite coefficient of friction, not for a law"
        if name != "linear" and (scene.motion.Fx is not None or scene.motion.Fy is not None):
            return "under a law of friction the force may fall with creepage, so that creepages are needed, not forces"
    elif name != "linear" and not (isinstance(scene.friction, float) and 0 < scene.friction < np.inf):
        return "it is for one finite coefficient of friction"
    if name != "linear" and scene.touched:
        return f'its tractions are those at the centres of elements, and grid.edge is "{scene.edge}"'
    if name == "table" and scene.hertz is not None:
        return why_not_in_book(scene.hertz.a / scene.hertz.b, scene.bodies.combined_nu)
    if name == "vermeulen-johnson" and scene.motion.spin != 0:
        return f"it is for rolling without spin, and spin is {scene.motion.spin:.3g}"
    return ""


def _linear(disc: Discretisation, state: ContactState) -> ContactState:
    """The state with tractions that stick everywhere, however large: Kalker's linear theory on these elements."""
    problem = disc.tangential_problem(state.pressure)
    raw = no_slip(problem)
    traction, rigid = problem.on_grid(raw.traction, raw.rigid)
    return _state(disc, state, traction, rigid, np.zeros(disc.grid.shape, dtype=bool))


def _fastsim_parabolic(disc: Discretisation, state: ContactState, flexibility: str = "separate") -> ContactState:
    """The state with FASTSIM's tractions at the element centres, under the parabolic bound (167)."""
    return _fastsim(disc, state, _parabolic(disc, state), flexibility)


def _parabolic(disc: Discretisation, state: ContactState) -> np.ndarray:
    """A pressure of the form of (167) with the same total, in physical units."""
    assert disc.hertz is not None
    a, b = disc.hertz.a, disc.hertz.b
    height = np.maximum(1 - (disc.grid.x[None, :] / a) ** 2 - (disc.grid.y[:, None] / b) ** 2, 0.0) * (
        state.pressure > 0
    )
    return np.asarray(state.pressure.sum() * disc.scales.pressure * height / height.sum())


def _fastsim_elliptic(disc: Discretisation, state: ContactState, flexibility: str = "separate") -> ContactState:
    """The state with FASTSIM's tractions under friction times Hertz's pressure, (166)."""
    return _fastsim(disc, state, state.pressure * disc.scales.pressure, flexibility)


def _vermeulen_johnson_state(disc: Discretisation, state: ContactState) -> ContactState:
    """The state with tractions of the form that Vermeulen and Johnson assume, with the force of Kalker's line.

    They are sampled at the element centres and scaled to carry exactly that force.
    """
    hertz, motion = disc.hertz, disc.loading.motion
    assert hertz is not None
    assert isinstance(motion, Steady)
    limit = _friction(disc) * hertz.force
    contact = (hertz.a, hertz.b, disc.bodies.combined_G, limit)
    table = _coefficients(disc)
    creepage = np.array(motion.rigid)
    if motion.Fx is not None or motion.Fy is not None:
        vx, vy = _given(motion)
        creepage = vermeulen_johnson_creepage(*contact, table, vx=vx, vy=vy, Fx=motion.Fx, Fy=motion.Fy)
    force = vermeulen_johnson(*contact, creepage, table)
    x, y = np.meshgrid(disc.grid.x, disc.grid.y)
    traction = vermeulen_johnson_traction(x, y, *contact, creepage, table) * (state.pressure > 0)
    carried = np.hypot(*traction.sum(axis=(1, 2))) * disc.grid.area
    scale = np.hypot(*force) / carried if carried > 0 else 0.0
    rest = 1 - np.hypot(*force) / limit
    r = max(rest, 0.0) ** (1 / 3)
    stick = np.zeros(x.shape, dtype=bool)
    if r > 0:
        stick = ((x - hertz.a * (1 - r)) / hertz.a) ** 2 + (y / hertz.b) ** 2 < r**2
    rigid = _rigid(disc, creepage)
    return _state(disc, state, traction * scale / disc.scales.pressure, rigid, (state.pressure > 0) & ~stick)


def _table(disc: Discretisation, state: ContactState) -> ContactState:
    """The state with tractions that carry the forces of the table book: FASTSIM's, changed as little as that takes."""
    traction, creepage = table_tractions(disc, state, _fastsim_elliptic)
    bound = _friction(disc) * state.pressure
    slips = (np.hypot(*traction) >= bound * (1 - 1e-9)) & (state.pressure > 0)
    return _state(disc, state, traction, _rigid(disc, creepage), slips)


def _coefficients(disc: Discretisation) -> CreepageCoefficients:
    """Creepage coefficients of a Hertzian contact."""
    assert disc.hertz is not None
    return creepage_coefficients(disc.hertz.a, disc.hertz.b, disc.operators.nu)


def _friction(disc: Discretisation) -> float:
    assert isinstance(disc.loading.coefficient, float)
    return disc.loading.coefficient


def _fastsim(disc: Discretisation, state: ContactState, pressure: np.ndarray, flexibility: str) -> ContactState:
    """FASTSIM on the grid, where prescribed forces are met, up to the last of what its elements can carry."""
    hertz, motion, G = disc.hertz, disc.loading.motion, disc.bodies.combined_G
    assert hertz is not None
    assert isinstance(motion, Steady)
    table, creepage = _coefficients(disc), np.array(motion.rigid)

    def flexibilities(creepage: np.ndarray) -> np.ndarray:
        return flexibilities_of(hertz.a, hertz.b, G, creepage, table, flexibility)

    if disc.loading.law is not None:
        law, start, L = disc.loading.law, state.branch, flexibilities(creepage)
        traction, slip = fastsim_on_grid_under_law(disc.grid, hertz.a, hertz.b, L, pressure, creepage, law, start)
        return _state(
            disc, state, traction / disc.scales.pressure, np.zeros(2), slip.any(axis=0) & (state.pressure > 0)
        )
    bound = _friction(disc) * pressure

    def tractions(creepage: np.ndarray) -> np.ndarray:
        return fastsim_on_grid(disc.grid, hertz.a, hertz.b, flexibilities(creepage), bound, creepage)

    creepage = _meeting(disc, bound, tractions)
    traction = tractions(creepage)
    slips = (np.hypot(*traction) >= bound * (1 - 1e-9)) & (state.pressure > 0)
    return _state(disc, state, traction / disc.scales.pressure, _rigid(disc, creepage), slips)


def _strip_state(disc: Discretisation, state: ContactState, name: str) -> ContactState:
    """The state with the tractions of strip theory, or of FaStrip, at the element centres."""
    hertz, G, table = disc.hertz, disc.bodies.combined_G, _coefficients(disc)
    assert hertz is not None
    pressure = state.pressure * disc.scales.pressure
    bound = _friction(disc) * pressure
    limit = _friction(disc) * hertz.force
    factors = (1 / (1 - disc.operators.nu), 1.0, 1.0) if name == "strip" else kalker_factors(hertz.a, hertz.b, table)

    def found(creepage: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        against = None
        if name == "fastrip":
            L = flexibilities_of(hertz.a, hertz.b, G, creepage, table, "separate")
            parabolic = _parabolic(disc, state) * _friction(disc)
            against = -fastsim_on_grid(disc.grid, hertz.a, hertz.b, L, parabolic, creepage)
        return strip_on_grid(disc.grid, hertz.a, hertz.b, G, limit, bound, creepage, factors, against)

    creepage = _meeting(disc, bound, lambda creepage: found(creepage)[0])
    traction, slips = found(creepage)
    return _state(disc, state, traction / disc.scales.pressure, _rigid(disc, creepage), slips)


def _polach_state(disc: Discretisation, state: ContactState) -> ContactState:
    """The state with the force of Polach's formula, by the tractions he assumes: linear in x up to Hertz's bound.

    They have the direction of the force, are sampled at the element centres and scaled to carry exactly that force.
    """
    hertz, motion, G = disc.hertz, disc.loading.motion, disc.bodies.combined_G
    assert hertz is not None
    assert isinstance(motion, Steady)
    limit, table, creepage = _friction(disc) * hertz.force, _coefficients(disc), np.array(motion.rigid)

    def force(vx: float, vy: float) -> np.ndarray:
        return polach(hertz.a, hertz.b, G, limit, (vx, vy, motion.spin), table)

    if motion.Fx is not None or motion.Fy is not None:
        _check_carried(motion, limit)
        unit = 3 * limit / (G * hertz.a * hertz.b * table.C11)
        creepage[:2] = creepages_meeting(force, (motion.vx, motion.vy), (motion.Fx, motion.Fy), unit, limit)
    carried = force(creepage[0], creepage[1])
    size = float(np.hypot(*carried))
    if size == 0:
        nothing = np.zeros(disc.grid.shape, dtype=bool)
        return _state(disc, state, np.zeros((2, *disc.grid.shape)), _rigid(disc, creepage), nothing)
    L = 8 * hertz.a / (3 * G * table.C11)
    slope = _slope_carrying(size / limit) * PEAK["elliptic"] * limit * L / (hertz.a**2 * hertz.b)
    x, y = np.meshgrid(disc.grid.x, disc.grid.y)
    shape = -simplified_traction(x, y, hertz.a, hertz.b, L, limit, slope, 0.0, "elliptic")[0] * (state.pressure > 0)
    total = shape.sum() * disc.grid.area
    traction = np.multiply.outer(carried / total if total > 0 else np.zeros(2), shape)
    bound = _friction(disc) * state.pressure * disc.scales.pressure
    slips = (shape >= bound * (1 - 1e-3)) & (state.pressure > 0)
    return _state(disc, state, traction / disc.scales.pressure, _rigid(disc, creepage), slips)


def _slope_carrying(part: float) -> float:
    """The gradient e of Polach's formula that carries a part of f Fz without spin."""
    from scipy.optimize import brentq

    if part >= 1 - 1e-9:
        return 1e9
    return float(brentq(lambda e: 2 / np.pi * (e / (1 + e * e) + np.arctan(e)) - part, 0.0, 1e9, xtol=1e-14))


def _meeting(disc: Discretisation, bound: np.ndarray, tractions: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The creepage of a scene; where forces are prescribed, that at which tractions on the elements carry them."""
    hertz, motion = disc.hertz, disc.loading.motion
    assert hertz is not None
    assert isinstance(motion, Steady)
    creepage = np.array(motion.rigid)
    if motion.Fx is not None or motion.Fy is not None:
        limit = float(bound.sum()) * disc.grid.area
        _check_carried(motion, limit)
        unit = 3 * limit / (disc.bodies.combined_G * hertz.a * hertz.b * _coefficients(disc).C11)

        def force(vx: float, vy: float) -> np.ndarray:
            return np.asarray(tractions(np.array([vx, vy, motion.spin])).sum(axis=(1, 2)) * disc.grid.area)

        creepage[:2] = creepages_meeting(force, (motion.vx, motion.vy), (motion.Fx, motion.Fy), unit, limit)
    return creepage


def _check_carried(motion: Steady, limit: float) -> None:
    size = float(np.hypot(motion.Fx or 0.0, motion.Fy or 0.0))
    if size >= limit:
        raise Saturated(size, limit)


def _given(motion: Steady) -> tuple[float | None, float | None]:
    """vx and vy where no force is prescribed in their place."""
    return (None if motion.Fx is not None else motion.vx), (None if motion.Fy is not None else motion.vy)


def _rigid(disc: Discretisation, creepage: np.ndarray) -> np.ndarray:
    """The uniform rigid shift of creepages found in place of forces."""
    motion, step = disc.loading.motion, disc.step
    assert motion is not None
    assert step is not None
    return np.asarray(
        (creepage[:2] - np.array(motion.rigid[:2])) * step * disc.scales.length / disc.scales.displacement
    )


def _state(
    disc: Discretisation, state: ContactState, traction: np.ndarray, rigid: np.ndarray, slips: np.ndarray
) -> ContactState:
    return replace(
        state, traction=traction, rigid=rigid, slips=slips, status={**state.status, "tangential": "closed form"}
    )


THEORIES: dict[str, Theory] = {
    "fastsim": _fastsim_parabolic,
    "fastsim-elliptic": _fastsim_elliptic,
    "fastsim-weighted": partial(_fastsim_parabolic, flexibility="weighted"),
    "fastsim-weighted-elliptic": partial(_fastsim_elliptic, flexibility="weighted"),
    "fastrip": partial(_strip_state, name="fastrip"),
    "strip": partial(_strip_state, name="strip"),
    "polach": _polach_state,
    "linear": _linear,
    "table": _table,
    "vermeulen-johnson": _vermeulen_johnson_state,
}
