"""The table book as a method of `solve`: tractions that carry its forces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.errors import Saturated
from varcontact.reference.creepage_coefficients import no_slip_coefficients
from varcontact.scene.motion import Steady
from varcontact.theories.prescribed import creepages_meeting
from varcontact.theories.table import NEAR, table_forces
from varcontact.theories.table_book import shipped

PASSES, ENOUGH = 100, 1e-12
"""Corrections of the tractions at most, and what of f Fz they may miss."""


def why_not_in_book(ratio: float, nu: float) -> str:
    """Why the book of the package does not serve a contact, or nothing where it does.

    Parameters
    ----------
    ratio : float
        a/b.
    nu : float
        Combined Poisson's ratio.
    """
    book = shipped()
    least, greatest = book.range
    if abs(nu - book.nu) > NEAR:
        return f"its book is for nu = {book.nu:g}, and nu is {nu:.4g}; theories.table_forces takes books for others"
    if not least * (1 - 1e-12) <= ratio <= greatest * (1 + 1e-12):
        return f"its book has a/b from {least:.4g} to {greatest:.4g}, and a/b is {ratio:.4g}"
    return ""


def table_tractions(
    disc: Discretisation, state: ContactState, simplified: Callable[[Discretisation, ContactState], ContactState]
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions that carry forces and moment of the book, within the traction bound, and the creepages.

    A book has no tractions. Those of another theory are the beginning: to them fields in proportion to the traction
    bound are added until all three resultants are met, or the bound is reached everywhere.

    Parameters
    ----------
    disc : Discretisation
        Of a contact that is in the book.
    state : ContactState
        With Hertz's pressure.
    simplified : callable
        The other theory, for given creepages.

    Returns
    -------
    traction : ndarray, shape (2, ny, nx)
        Dimensionless.
    creepage : ndarray, shape (3,)
        vx, vy, spin; those found where forces are prescribed.
    """
    hertz, motion = disc.hertz, disc.loading.motion
    assert hertz is not None
    assert isinstance(motion, Steady)
    assert isinstance(disc.loading.coefficient, float)
    G, limit = disc.bodies.combined_G, disc.loading.coefficient * hertz.force
    creepage = np.array(motion.rigid)
    if motion.Fx is not None or motion.Fy is not None:
        size = float(np.hypot(motion.Fx or 0.0, motion.Fy or 0.0))
        if size >= limit:
            raise Saturated(size, limit)

        def force(vx: float, vy: float) -> np.ndarray:
            return table_forces(hertz.a, hertz.b, G, limit, (vx, vy, motion.spin)).force

        unit = 3 * limit / (G * hertz.a * hertz.b * no_slip_coefficients(hertz.a / hertz.b, shipped().nu).C11)
        creepage[:2] = creepages_meeting(force, (motion.vx, motion.vy), (motion.Fx, motion.Fy), unit, limit)
    found = table_forces(hertz.a, hertz.b, G, limit, creepage)
    vx, vy, spin = map(float, creepage)
    begun = simplified(disc.with_loading(motion=replace(motion, vx=vx, vy=vy, spin=spin, Fx=None, Fy=None)), state)
    size = float(np.sqrt(hertz.a * hertz.b))
    wanted = np.array([*found.force, float(found.moment) / size]) / limit
    bound = disc.loading.coefficient * state.pressure
    x, y = np.meshgrid(disc.grid.x / size, disc.grid.y / size)
    return _carrying(begun.traction, bound, np.stack([x, y]), wanted), creepage


def _carrying(traction: np.ndarray, bound: np.ndarray, points: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Tractions within the bound that carry Fx, Fy and Mz, in parts of all friction, as nearly as they can."""
    x, y = points
    zero, weight = np.zeros_like(x), bound / bound.sum()
    fields = np.stack([[weight, zero], [zero, weight], [-y * weight, x * weight]])
    moments = np.stack([[np.ones_like(x), zero], [zero, np.ones_like(x)], [-y, x]]) / bound.sum()
    matrix = np.einsum("icyx,jcyx->ij", moments, fields) * bound.sum()
    for _ in range(PASSES):
        missing = wanted - np.einsum("icyx,cyx->i", moments, traction)
        if np.abs(missing).max() < ENOUGH:
            break
        traction = traction + bound.sum() * np.tensordot(np.linalg.solve(matrix, missing), fields, 1)
        traction = traction * np.minimum(1.0, bound / np.maximum(np.hypot(*traction), np.finfo(float).tiny))
    return traction
