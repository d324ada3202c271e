"""FASTSIM, Kalker's algorithm of the simplified theory (paper, section 3.2.6),
also under laws of friction.

Sources: J. J. Kalker, A fast algorithm for the simplified theory of rolling
contact, Veh. Syst. Dyn. 11 (1982) 1-13; J. J. Kalker and J. Piotrowski, Some
new results in rolling contact, Veh. Syst. Dyn. 18 (1989) 223-242.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.checks import (
    array,
    at_least_zero,
    choice,
    numbers,
    positive,
    positives,
    require_all,
    wrong_shape,
)
from varcontact.errors import SceneError
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.theories.linear import (
    Contact,
    Forces,
    Resultants,
    as_resultants,
    checked_contact,
    creepage_triple,
)
from varcontact.theories.simplified import PEAK, flexibilities_of, slip_flexibility
from varcontact.theories.strip_theory import divided, fastsim_steps, march_sums

MAX_NEWTON = 100
"""Newton steps for the slip of a point; they come down to it from above, on a convex function."""
TINY = float(np.finfo(float).tiny)


def fastsim(
    a: Any,
    b: Any,
    G: Any,
    friction_force: Any,
    creepages: Any,
    coefficients: CreepageCoefficients,
    *,
    m: int = 10,
    n: int = 10,
    bound: str = "parabolic",
    flexibility: str = "separate",
    division: str = "printed",
) -> Resultants:
    """Forces and moments by FASTSIM, for any number of creepage triples in one call.

    Parameters
    ----------
    a, b, G : float or array_like
        Semi-axes along the rolling direction and across it [length], and
        combined modulus of rigidity [force/area].
    friction_force : float or array_like
        ``f Fz``, the most that friction can carry [force].
    creepages : array_like, shape (..., 3)
        vx, vy [-] and spin [1/length]. The arguments before it, and the
        coefficients, broadcast with its leading shape, so that every triple may
        have a contact of its own.
    coefficients : CreepageCoefficients
        From `creepage_coefficients`.
    m, n : int
        Intervals along x in each strip (2 or more), and strips.
    bound : {"parabolic", "elliptic"}
        Form of the traction bound, (167) or (166). The paper advises the
        parabolic one.
    flexibility : {"separate", "weighted"}
        Each creepage by its own flexibility (161)-(163), or all by the single
        one of (164), as the paper prints it.
    division : {"printed", "calibrated"}
        The paper's division into strips; or one at other points, with factors
        that make the sums exact in the linear limit and in full slip, for any m
        and n.

    Returns
    -------
    Resultants
        Force (..., 2) and moment (...) on body 1.

    Raises
    ------
    SceneError
        If a number is not finite (or, where it must be, positive), m or n is no
        whole number in range, the bound has no such form or the flexibility no
        such name, or there is spin where C23 is not positive.

    Notes
    -----
    With separate flexibilities tractions build up as if the rigid slip were ``vx/L1 - spin y/L3``,
    ``vy/L2 + spin x/L3`` and the flexibility 1: for small creepages the force is that of the linear
    theory, however they are mixed. With the weighted one it is, where a creepage acts alone; else
    it is too small, by up to a factor of ``sqrt(3)``.

    With ``division="printed"`` it is the algorithm as printed: n equal strips,
    in each m intervals from the exact leading edge ``a(y)`` to the exact
    trailing edge, rigid slip taken at the middle of an interval, the last point
    (where the bound is 0) left out. The sum is thus the trapezoidal rule, and
    in full slip under the parabolic bound a part of about ``1/m^2`` is missing
    in ``f Fz``; for small vx and vy a part of ``1/m`` of the force is, as the
    last point carries nothing. The moment is that of the tractions; simplified
    theory is not fitted to C33, and has no moment by lateral creepage to fit
    (C32), so take it as an estimate.

    Only for quasi-identical bodies. Each triple is computed alone: a call with
    many gives to the last bit what single calls give.

    Examples
    --------
    The paper's Fig. 21, pure spin (N, mm). It prints Fy = -1.812e4 N and not the elastic constants:
    E = 2e5 N/mm2 and nu = 0.25 give just that with C23 = 1.5195, as interpolated in Kalker's table,
    and with either flexibility, as only spin is there. The computed C23 is 1.5171.

    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(6.8, 6.5, 0.25)
    >>> result = fastsim(6.8, 6.5, 8.0e4, 45000.0, (0.0, 0.0, 0.00054), table)
    >>> print(f"{abs(result.force[0]):.0f} {result.force[1]:.0f}")
    0 -18097
    """
    contact = checked_contact(a, b, G, friction_force, creepages, coefficients)
    return as_resultants(fastsim_forces(contact, m, n, 0.0, bound, flexibility, division))


def fastsim_forces(
    c: Contact,
    m: int = 10,
    n: int = 10,
    layer: float = 0.0,
    bound: str = "parabolic",
    flexibility: str = "separate",
    division: str = "calibrated",
) -> Forces:
    """Fx, Fy and Mz of `fastsim`, also with a `layer`, see `creep_forces`."""
    layer = at_least_zero("layer", layer, "zero or positive: a compliance")
    strips = divided(m, n, bound, division)
    steps = fastsim_steps(strips, c, flexibilities_of(c, flexibility) + layer)
    sums = march_sums(strips, steps.reshape(4, -1)).reshape(steps.shape)
    Fx, Fy, by_x, by_y = sums * (PEAK[bound] * c.limit)
    return Fx, Fy, c.a * by_y - c.b * by_x


@dataclass(frozen=True, eq=False)
class FastsimField:
    """The field behind one result of `fastsim`: n strips of m - 1 points, in
    order of rising x and y.

    Attributes
    ----------
    x : ndarray, shape (n, m - 1)
        Points along each strip [length].
    y : ndarray, shape (n,)
        The strips' middles [length].
    dx : ndarray, shape (n,)
        Distance of points in each strip, which is also the length of a point's
        cell [length].
    dy : float
        Width of a strip [length].
    traction : ndarray, shape (2, n, m - 1)
        On body 1 [force/area].
    slip : ndarray, shape (2, n, m - 1)
        Relative slip of body 1 over body 2 in the interval ahead of the point
        [-], opposite to the traction. Separate flexibilities give its size in
        units of a flexibility; a mean of them is taken for that, with which the
        rigid slip is right in the mean square over the contact.
    state : ndarray of int, shape (n, m - 1)
        1 stick, 2 slip.
    """

    x: np.ndarray
    y: np.ndarray
    dx: np.ndarray
    dy: float
    traction: np.ndarray
    slip: np.ndarray
    state: np.ndarray

    @property
    def force(self) -> np.ndarray:
        """Fx, Fy: the sum of tractions times cells, shape (2,)."""
        return np.sum(self.traction * self.dx[:, None], axis=(1, 2)) * self.dy

    @property
    def moment(self) -> float:
        """Mz of the tractions."""
        arm = self.x * self.traction[1] - self.y[:, None] * self.traction[0]
        return float(np.sum(arm * self.dx[:, None]) * self.dy)


def fastsim_field(
    a: float,
    b: float,
    G: float,
    friction_force: float,
    creepage: Any,
    coefficients: CreepageCoefficients,
    *,
    m: int = 10,
    n: int = 10,
    bound: str = "parabolic",
    flexibility: str = "separate",
) -> FastsimField:
    """Tractions, slip, and areas of stick and slip by FASTSIM, for one triple of creepages.

    Parameters
    ----------
    a, b, G, friction_force, coefficients, m, n, bound, flexibility
        As for `fastsim`, all single.
    creepage : array_like, shape (3,)
        vx, vy [-] and spin [1/length].

    Returns
    -------
    FastsimField

    Raises
    ------
    SceneError
        As `fastsim`.

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(6.8, 6.5, 0.25)
    >>> field = fastsim_field(6.8, 6.5, 8e4, 45000.0, (0, 0, 0.00054), table, n=3, m=6)
    >>> field.state
    array([[2, 2, 1, 1, 1],
           [1, 1, 1, 1, 1],
           [2, 2, 1, 1, 1]])
    """
    force = positive("friction_force", friction_force)
    contact = checked_contact(a, b, G, force, creepage_triple(creepage), coefficients)
    return _field(contact, m, n, bound, flexibility)


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
    a, b, G, creepage, coefficients, m, n, bound, flexibility
        As for `fastsim_field`.
    normal_force : float
        Fz [force].
    friction : StaticKinetic, LinearFalling, RationalFalling or ExponentialFalling
    start : {"stick", "slip"}
        Whether a particle that sticks does so up to the static coefficient, or
        slips wherever the law lets it.

    Returns
    -------
    FastsimField

    Raises
    ------
    SceneError
        As `fastsim`, or if there is no such law or start.

    Notes
    -----
    A particle that sticks slips when its traction would exceed the static coefficient times the
    pressure. One that slips goes on slipping as long as there is a slip at which Coulomb's law
    holds; of two, the larger is taken (at the other one less slip would have more friction than it
    needs). Without this memory a particle would stick and slip in turn from point to point. With
    start "slip" and a static and a kinetic coefficient the result is FASTSIM's for the kinetic one.
    Separate flexibilities leave open how fast it slips; see `FastsimField.slip` for the mean that
    is taken.

    Examples
    --------
    The paper: the effect on the total force appears to be small, f = f_kin.

    >>> import varcontact as vc
    >>> table = vc.reference.creepage_coefficients(1.0, 1.0, 0.25)
    >>> law = vc.StaticKinetic(static=0.36, kinetic=0.3)
    >>> creepage = (1.0, 0.0, 0.0)
    >>> for start in ("stick", "slip"):
    ...     field = fastsim_under_law(
    ...         1.0, 1.0, 1.0, 10.0, law, creepage, table, m=50, n=50, start=start)
    ...     print(f"{field.force[0] / 3.0:.3f}")
    -0.840
    -0.829
    """
    if not isinstance(friction, Law):
        raise SceneError("friction", friction, "a law of friction")
    choice("start", start, ("stick", "slip"))
    force = positive("normal_force", normal_force)
    contact = checked_contact(a, b, G, force, creepage_triple(creepage), coefficients)
    return _field(contact, m, n, bound, flexibility, friction, start)


def _field(
    c: Contact,
    m: int,
    n: int,
    bound: str,
    flexibility: str,
    law: Law | None = None,
    start: str = "stick",
) -> FastsimField:
    """The field under Coulomb's law, or under another, with the normal force in place of the
    limit.
    """
    strips = divided(m, n, bound, "printed")
    creepage = np.array([c.vx, c.vy, c.spin])
    L = flexibilities_of(c, flexibility)
    peak = PEAK[bound] * c.limit / (c.a * c.b)
    edges = c.a * strips.edge[::-1, None]
    x = edges * strips.along
    y = c.b * strips.across[::-1]
    dx = strips.step * edges
    bounds = peak * strips.peak[::-1, None] * strips.bounds
    points = _Points(x, y, np.broadcast_to(dx, x.shape), bounds)
    mean = slip_flexibility(c.a, c.b, L, creepage)
    traction, slip = _travel(points, creepage / L, mean, law, start)
    return FastsimField(
        x=x[:, ::-1],
        y=y,
        dx=dx[:, 0],
        dy=c.b * float(strips.width[0]),
        traction=traction,
        slip=slip,
        state=np.where(np.any(slip != 0, axis=0), 2, 1),
    )


def fastsim_on_grid(
    grid: Grid, a: float, b: float, flexibility: Any, bound: Any, creepage: Any
) -> np.ndarray:
    """FASTSIM with the element centres of a grid as its points, under any traction bound.

    Parameters
    ----------
    grid : Grid
        An explicit lattice.
    a, b : float
        Semi-axes of the contact ellipse about the origin [length].
    flexibility : float or array_like, shape (3,)
        L, from `varcontact.theories.flexibility`, or the three for vx, vy and
        spin, from `flexibilities` [length^3/force].
    bound : array_like, shape (ny, nx)
        Traction bound at the centres, 0 or more [force/area].
    creepage : array_like, shape (3,)
        vx, vy [-] and spin [1/length].

    Returns
    -------
    ndarray, shape (2, ny, nx)
        Tractions on body 1 at the centres; 0 outside the ellipse.

    Raises
    ------
    SceneError
        If a length or an L is not positive and finite (the third may be
        anything without spin), the bound has another shape or a negative entry,
        or the creepage is no three finite numbers.

    Notes
    -----
    Each row is marched from the exact leading edge to the first centre inside the ellipse, then
    from centre to centre.

    Examples
    --------
    >>> from varcontact import Grid
    >>> grid = Grid(nx=4, ny=1, dx=0.5, dy=0.5, x0=-1.0, y0=-0.25)
    >>> print(fastsim_on_grid(grid, 1.0, 1.0, 1.0, [[0.4, 0.9, 0.9, 0.4]], (1.0, 0.0, 0.0))[0])
    [[-0.4  -0.9  -0.75 -0.25]]
    """
    a = positive("a", a)
    b = positive("b", b)
    creepage = creepage_triple(creepage)
    L = numbers("flexibility", flexibility)
    if L.shape not in ((), (3,)):
        raise wrong_shape("flexibility", L.shape, "one number, or three for vx, vy and spin")
    without_spin = L.ndim == 1 and creepage[2] == 0
    positives("flexibility", L[:2] if without_spin else L)
    bound = array("bound", bound, shape=grid.shape)
    require_all("bound", bound, bound >= 0, "zero or positive")
    return marched_on_grid(grid, (a, b), L, bound, creepage)[0]


def marched_on_grid(
    grid: Grid,
    semi_axes: tuple[float, float],
    L: np.ndarray,
    bound: np.ndarray,
    creepage: np.ndarray,
    law: Law | None = None,
    start: str = "stick",
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions and relative slip, (2, ny, nx) each, as `fastsim_on_grid`; under a law `bound` is
    the pressure.
    """
    a, b = semi_axes
    edge = a * np.sqrt(np.maximum(1 - (grid.y / b) ** 2, 0.0))[:, None]
    x = grid.x[::-1]
    # ahead of the edge nothing builds up
    interval = np.minimum(np.maximum(edge - x, 0.0), grid.sides[0])
    inside = np.where(np.abs(x) < edge, bound[:, ::-1], 0.0)
    mean = slip_flexibility(a, b, L * np.ones(3), creepage)
    return _travel(_Points(x, grid.y, interval, inside), creepage / L, mean, law, start)


def stepped_on_grid(
    grid: Grid,
    semi_axes: tuple[float, float],
    gradient: np.ndarray,
    bound: np.ndarray,
    before: np.ndarray,
    travel: tuple[int, float],
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions (2, ny, nx) after a step of FASTSIM in time (3.2.6), and True where particles slip.

    `gradient`: vx, vy and spin, in place ux, uy and rotation, over their flexibilities; `before`:
    the tractions at the beginning of the step; `travel`: direction of rolling, 0 in place, and
    distance rolled. Of equal steps up to an element long, the fixed point is `marched_on_grid`.
    """
    a, b = semi_axes
    rolls, dq = travel
    dx = grid.sides[0]
    x, y = np.meshgrid(grid.x, grid.y)
    edge = a * np.sqrt(np.maximum(1 - (y / b) ** 2, 0.0))

    # the path of each particle in the contact, from the leading edge on, and its middle
    path = np.ones(grid.shape)
    middle = x
    arrived = before
    if rolls != 0:
        ahead = edge - rolls * x
        path = np.clip(ahead, 0.0, dq)
        middle = x + rolls * np.clip(ahead, 0.0, max(dq, dx)) / 2
        in_order = slice(None, None, -rolls)
        arrived = _arriving(before[..., in_order], ahead[:, in_order], dq, dx)[..., in_order]

    # the traction without slip, cut back to the bound where it slips
    vx, vy, spin = gradient
    free = arrived - path * np.array([vx - spin * y, vy + spin * middle])
    size = np.hypot(*free)
    inside = np.where(np.abs(x) < edge, bound, 0.0)
    slips = size > inside
    return free * np.where(slips, inside / np.where(slips, size, 1.0), 1.0), slips


def _arriving(before: np.ndarray, ahead: np.ndarray, dq: float, dx: float) -> np.ndarray:
    """Tractions (2, ny, nx) that particles bring along from a distance dq ahead: linear between
    centres, zero at the leading edge and beyond it; in order of travel, leading edge first.

    `ahead`: distance of the centres from the leading edge.
    """
    columns = ahead.shape[1]
    whole = min(int(dq / dx), columns)
    rest = dq - whole * dx
    # the centres next to where a particle was: behind it, and in front
    padded = np.pad(before, ((0, 0), (0, 0), (whole + 1, 0)))
    behind = padded[..., 1 : columns + 1]
    front = padded[..., :columns]
    # from the foremost centre it is less than an element to the edge
    distance = ahead - whole * dx
    interval = np.clip(distance, 0.0, dx)
    part = np.where(interval > rest, rest / np.where(interval > 0, interval, 1.0), 1.0)
    return (1 - part) * behind + part * np.where(distance > dx, front, 0.0)


@dataclass(frozen=True, eq=False)
class _Points:
    """Points in order of travel, and their bounds, which under a law are the pressures."""

    x: np.ndarray  # (ny, k), or (k,) if it is the same for all rows
    y: np.ndarray  # (ny,)
    interval: np.ndarray  # ahead of each point (ny, k)
    bound: np.ndarray  # (ny, k)


def _travel(
    points: _Points, gradient: np.ndarray, L: float, law: Law | None, start: str
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions and relative slip, (2, ny, k) each, in order of rising x.

    `gradient`: vx, vy and spin over their flexibilities; `L`: the ratio of slip to tractions.
    """
    vx, vy, spin = gradient
    step = points.interval
    # by point in order of travel: what builds up without slip in the interval ahead of it
    along = step * (vx - spin * points.y)[:, None]
    across = step * (vy + spin * (points.x + step / 2))
    build_up = _by_point(np.array([along, across]))
    bound = _by_point(points.bound)
    if law is None:
        free, traction = _march(build_up, bound)
    else:
        free, traction = _march_under_law(build_up, bound, _by_point(step / L), law, start)
    free = _along_rows(free)
    traction = _along_rows(traction)
    slip = (traction - free) * L / np.where(step > 0, step, 1.0)
    return traction[:, :, ::-1], slip[:, :, ::-1]


def _by_point(fields: np.ndarray) -> np.ndarray:
    """Fields (..., ny, k) as (k, ..., ny)."""
    return np.ascontiguousarray(fields.transpose(-1, *range(fields.ndim - 1)))


def _along_rows(fields: np.ndarray) -> np.ndarray:
    """The reverse of `_by_point`."""
    return np.ascontiguousarray(fields.transpose(*range(1, fields.ndim), 0))


def _march(build_up: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tractions (k, 2, ny) without slip in the last interval, and with it."""
    free = np.empty_like(build_up)
    traction = np.empty_like(build_up)
    present = np.zeros(build_up.shape[1:])
    least_divisor = np.maximum(bound, TINY)
    points = zip(build_up, bound, least_divisor, free, traction, strict=True)
    for change, most, least, without_slip, with_slip in points:
        np.subtract(present, change, out=without_slip)
        size = np.hypot(*without_slip)
        part = most / np.maximum(size, least)
        present = np.multiply(without_slip, part, out=with_slip)
    return free, traction + 0.0  # no negative zeros


def _march_under_law(
    build_up: np.ndarray, pressure: np.ndarray, stiffness: np.ndarray, law: Law, start: str
) -> tuple[np.ndarray, np.ndarray]:
    """Tractions (k, 2, ny) without slip in the last interval, and with it, under a friction law: a
    particle that slips goes on slipping where it can.
    """
    free = np.empty_like(build_up)
    traction = np.empty_like(build_up)
    present = np.zeros(build_up.shape[1:])
    slides = np.zeros(build_up.shape[2], dtype=bool)
    for i in range(len(pressure)):
        free[i] = present - build_up[i]
        size = np.hypot(*free[i])
        may_slip = (size > law.static * pressure[i]) | slides | (start == "slip")
        speed = np.where(may_slip, _largest_slip(size, stiffness[i], pressure[i], law), 0.0)
        slides = speed > 0
        part = np.where(slides, law(speed) * pressure[i] / np.where(slides, size, 1.0), 1.0)
        # nothing builds up ahead of the contact
        present = np.where(pressure[i] > 0, free[i] * part, 0.0)
        traction[i] = present
    return free, traction


def _largest_slip(
    size: np.ndarray, stiffness: np.ndarray, pressure: np.ndarray, law: Law
) -> np.ndarray:
    """The largest slip s with ``stiffness s + law(s) pressure = size``, by Newton's method from
    above; 0 if none.
    """
    moves = (stiffness > 0) & (size > 0)
    slip = np.where(moves, size / np.where(moves, stiffness, 1.0), 0.0)
    for _ in range(MAX_NEWTON):
        height = stiffness * slip + law(slip) * pressure - size
        slope = stiffness + law.slope(slip) * pressure
        rises = (slip > 0) & (slope > 0)
        after = np.where(rises, np.maximum(slip - height / np.where(rises, slope, 1.0), 0.0), 0.0)
        converged = np.abs(after - slip) <= 4 * np.finfo(float).eps * slip
        slip = after
        if converged.all():
            break
    return slip
