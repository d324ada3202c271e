"""FASTSIM under laws of friction (paper, section 7, item 8).

Source: J. J. Kalker and J. Piotrowski, Some new results in rolling contact, Veh. Syst. Dyn. 18 (1989) 223-242.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.checks import choice, positive
from varcontact.errors import SceneError
from varcontact.scene.friction import Law
from varcontact.theories.fastsim import FastsimField, points_of
from varcontact.theories.inputs import triple
from varcontact.theories.simplified import PEAK, flexibilities_of, slip_flexibility
from varcontact.theories.strips import printed

if TYPE_CHECKING:
    from varcontact.reference.creepage_coefficients import CreepageCoefficients
    from varcontact.scene.grid import Grid

MAX_NEWTON = 100
"""Newton steps for the slip of a point; they come down to it from above, on a convex function."""


def fastsim_under_law(
    a: float,
    b: float,
    G: float,
    normal_force: float,
    friction: Law,
    creepage: Any,
    coefficients: CreepageCoefficients,
    *,
    m: int = 10,
    n: int = 10,
    bound: str = "parabolic",
    flexibility: str = "separate",
    start: str = "stick",
) -> FastsimField:
    """Tractions, slip, and areas of stick and slip by FASTSIM under a law of friction.

    Parameters
    ----------
    a, b : float
        Semi-axes along the rolling direction and across it [length].
    G : float
        Combined modulus of rigidity [force/area].
    normal_force : float
        Fz [force].
    friction : StaticKinetic, LinearFalling, RationalFalling or ExponentialFalling
    creepage : array_like, shape (3,)
        vx, vy [-] and spin [1/length].
    coefficients : CreepageCoefficients
        From `creepage_coefficients`.
    m, n : int
        Intervals along x in each strip (2 or more), and strips.
    bound : {"parabolic", "elliptic"}
        Form of the traction bound, (167) or (166).
    flexibility : {"separate", "weighted"}
        Each creepage by its own flexibility (161)-(163), or all by the single one of (164).
    start : {"stick", "slip"}
        Whether a particle that sticks does so up to the static coefficient, or slips wherever the law lets it.

    Returns
    -------
    FastsimField

    Raises
    ------
    SceneError
        If a number is not finite (or, where it must be, positive), m or n is no whole number in range, there is
        no such law, bound, flexibility or start, or there is spin where C23 is not positive.

    Notes
    -----
    A particle that sticks slips when its traction would exceed the static coefficient times the pressure. One that
    slips goes on slipping as long as there is a slip at which Coulomb's law holds; of two, the larger is taken (at
    the other one less slip would have more friction than it needs). Without this memory a particle would stick and
    slip in turn from point to point. With start "slip" and a static and a kinetic coefficient the result is
    FASTSIM's for the kinetic one. Separate flexibilities leave open how fast it slips; see `FastsimField.slip` for
    the mean that is taken.

    Examples
    --------
    The paper: the effect on the total force appears to be small, f = f_kin.

    >>> import varcontact as vc
    >>> table = vc.reference.creepage_coefficients(1.0, 1.0, 0.25)
    >>> law, creepage = vc.StaticKinetic(static=0.36, kinetic=0.3), (1.0, 0.0, 0.0)
    >>> for start in ("stick", "slip"):
    ...     field = fastsim_under_law(1.0, 1.0, 1.0, 10.0, law, creepage, table, m=50, n=50, start=start)
    ...     print(f"{field.force[0] / 3.0:.3f}")
    -0.840
    -0.829
    """
    strips = printed(m, n, bound)
    a, b, Fz = positive("a", a), positive("b", b), positive("normal_force", normal_force)
    if not isinstance(friction, Law):
        raise SceneError("friction", friction, "a law of friction")
    creepage = triple(creepage)
    L = flexibilities_of(a, b, positive("G", G), creepage, coefficients, flexibility)
    x, y, dx = points_of(strips, a, b)
    pressure = PEAK[bound] * Fz / (a * b) * strips.peak[::-1, None] * strips.bounds
    intervals, mean = np.broadcast_to(dx, x.shape), slip_flexibility(a, b, L, creepage)
    traction, slip = _travel(x, y, intervals, pressure, creepage / L, mean, friction, start)
    state = np.where(np.any(slip != 0, axis=0), 2, 1)
    return FastsimField(
        x[:, ::-1], y, dx[:, 0], b * float(strips.width[0]), traction[:, :, ::-1], slip[:, :, ::-1], state[:, ::-1]
    )


def on_grid(
    grid: Grid, a: float, b: float, L: np.ndarray, pressure: np.ndarray, creepage: np.ndarray, law: Law, start: str
) -> tuple[np.ndarray, np.ndarray]:
    """FASTSIM under a law of friction at the element centres of a grid, as `fastsim_on_grid`.

    Parameters
    ----------
    grid : Grid
        Explicit [length].
    a, b : float
        Semi-axes along the rolling direction and across it [length].
    L : ndarray, shape (3,)
        By what vx, vy and spin are divided [length^3/force].
    pressure : ndarray, shape (ny, nx)
        What the law's coefficient is multiplied by [force/area].
    creepage : ndarray, shape (3,)
        vx, vy [-] and spin [1/length].
    law : Law
    start : {"stick", "slip"}
        As of `fastsim_under_law`.

    Returns
    -------
    traction : ndarray, shape (2, ny, nx)
        On body 1 [force/area].
    slip : ndarray, shape (2, ny, nx)
        Relative [-].
    """
    edge = a * np.sqrt(np.maximum(1 - (grid.y / b) ** 2, 0.0))[:, None]
    x = np.broadcast_to(grid.x[::-1], grid.shape)
    inside = np.where(np.abs(x) < edge, pressure[:, ::-1], 0.0)
    interval = np.clip(edge - x, 0.0, grid.sides[0])
    mean = slip_flexibility(a, b, L, creepage)
    traction, slip = _travel(x, grid.y, interval, inside, creepage / L, mean, law, start)
    return traction[:, :, ::-1], slip[:, :, ::-1]


def _travel(
    x: np.ndarray,
    y: np.ndarray,
    interval: np.ndarray,
    pressure: np.ndarray,
    gradient: np.ndarray,
    L: float,
    law: Law,
    start: str,
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions and relative slip at points (ny, k) in order of travel, (2, ny, k) each.

    `gradient` (3,) has vx, vy and spin by their flexibilities; L is that by which tractions tell the slip.
    """
    eager = choice("start", start, ("stick", "slip")) == "slip"
    vx, vy, spin = gradient
    traction, slip = np.zeros((2, 2, *x.shape))
    present, slid = np.zeros((2, y.size)), np.zeros(y.size, dtype=bool)
    for i in range(x.shape[1]):
        step, pz = interval[:, i], pressure[:, i]
        middle = x[:, i] + step / 2
        free = present - step * np.array([vx - spin * y, vy + spin * middle])
        size = np.hypot(*free)
        may_slip = (size > law.static * pz) | slid | eager
        speed = np.where(may_slip, _largest_slip(size, step / L, pz, law), 0.0)
        slid = speed > 0
        part = np.where(slid, law(speed) * pz / np.where(slid, size, 1.0), 1.0)
        present = np.where(pz > 0, free * part, 0.0)  # nothing builds up ahead of the contact
        traction[:, :, i] = present
        slip[:, :, i] = np.where(slid, (part - 1) * free * L / np.where(slid, step, 1.0), 0.0)
    return traction, slip


def _largest_slip(size: np.ndarray, stiffness: np.ndarray, pressure: np.ndarray, law: Law) -> np.ndarray:
    """The largest slip s with ``stiffness s + law(s) pressure = size``; 0 where there is none.

    The laws are convex, and Newton's method from above comes down to it.
    """
    moves = (stiffness > 0) & (size > 0)
    slip = np.where(moves, size / np.where(moves, stiffness, 1.0), 0.0)
    for _ in range(MAX_NEWTON):
        height = stiffness * slip + law(slip) * pressure - size
        slope = stiffness + law.slope(slip) * pressure
        rises = (slip > 0) & (slope > 0)
        after = np.where(rises, np.maximum(slip - height / np.where(rises, slope, 1.0), 0.0), 0.0)
        still = np.abs(after - slip) <= 4 * np.finfo(float).eps * slip
        slip = after
        if still.all():
            break
    return slip
