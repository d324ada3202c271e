"""Contacts cut into strips along the rolling direction: the marching of
FASTSIM, strip theory, and FaStrip.

Strips are those of an ellipse on the unit disk: lengths are in units of a along
x, and of b across it.

Sources: D. J. Haines and E. Ollerton, Contact stress distributions on
elliptical contact surfaces subjected to radial and tangential forces, Proc.
Instn Mech. Engrs 177 (1963) 95-114; J. J. Kalker, A strip theory for rolling
with slip and spin, Proc. Kon. Ned. Akad. Wet. B70 (1967) 10-62; M. Sh. Sichani,
R. Enblom and M. Berg, An alternative to FASTSIM for tangential solution of the
wheel-rail contact, Veh. Syst. Dyn. 54 (2016) 748-764.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from varcontact.checks import choice, poisson, whole
from varcontact.reference.creepage_coefficients import CreepageCoefficients
from varcontact.theories.linear import Contact, Forces, Resultants, as_resultants, checked_contact
from varcontact.theories.simplified import PEAK, flexibilities_of

CHUNK_POINTS = 7000
"""Strips times triples marched at once: the arrays of a chunk (56 kB each) then stay in a core's
cache."""
MAX_DIVISIONS = 100_000
"""Largest number of intervals along a strip, and of strips."""
LARGEST_STEP = 1e100
"""Largest step, in units of the bound; larger ones are cut to this size, in their direction, as
squares must not overflow."""
SMALLEST = 1e-150
"""Size below which a vector has no direction."""


def strip(
    a: Any,
    b: Any,
    G: Any,
    nu: Any,
    friction_force: Any,
    creepages: Any,
    *,
    m: int = 10,
    n: int = 10,
) -> Resultants:
    """Forces and moments by strip theory.

    Parameters
    ----------
    a, b, G, friction_force, creepages
        As of `fastsim`.
    nu : float or array_like
        Combined Poisson's ratio, in (-1, 0.5].
    m, n : int
        Intervals along x in each strip, for the slip area with spin, and
        strips.

    Returns
    -------
    Resultants
        Force (..., 2) and moment (...) on body 1.

    Raises
    ------
    SceneError
        If a number is not finite or out of its range.

    Notes
    -----
    Each strip, of half-length ``a(y)``, is a line contact with Hertz's bound: plane strain along x,
    where it is Carter's (Haines and Ollerton), antiplane strain along y. With ``k = G a/(2 f p0)``,
    ``X = k (vx - spin y)/(1 - nu)``, ``Y = k vy``
    and ``P = spin G a/(2 f p0)``, in units of a, the stick area is ``2 d - a(y) < x < a(y)`` with

        (1 - P^2) d^2 - 2 P Y d = X^2 + Y^2,

    and the traction in it, in units of the bound's peak, is the difference of
    two circles (Kalker 1967)

        p = -(n S - n' s),    S^2 = a(y)^2 - x^2,    s^2 = (a(y) - d)^2 - (x - d)^2,
        d n = (X, Y + P d),    n' = n - (0, P).

    With spin the slip is then opposite to the traction n S only nearly. In the
    slip area the traction is given the direction of ``(X, Y + P x)``, the rigid
    slip in these units, point by point; without spin that is n. A strip slips
    as a whole if ``d >= a(y)`` or ``|P| >= 1``.

    The theory holds for a contact that is wide against its length, ``a << b``:
    its slopes are those of `a/b` to 0, ``C11 = pi^2/(4 (1 - nu))``,
    ``C22 = pi^2/4``, ``C23 = pi/3 (a/b)^(1/2)``. For others see `fastrip`.

    Examples
    --------
    >>> for vx in (0.5, 1.0, 1.5):
    ...     print(f"{strip(1.0, 50.0, 1.0, 0.25, 50.0, (vx, 0.0, 0.0)).force[0] / 50.0:.4f}")
    -0.9454
    -1.0000
    -1.0000
    """
    contact = checked_contact(a, b, G, friction_force, creepages, nu=poisson(nu))
    return as_resultants(strip_forces(contact, m, n))


def fastrip(
    a: Any,
    b: Any,
    G: Any,
    friction_force: Any,
    creepages: Any,
    coefficients: CreepageCoefficients,
    *,
    m: int = 10,
    n: int = 10,
) -> Resultants:
    """Forces and moments by FaStrip: strip theory with Kalker's slopes, and
    with FASTSIM's directions of slip.

    Parameters
    ----------
    a, b, G, friction_force, creepages, m, n
        As of `strip`.
    coefficients : CreepageCoefficients
        From `creepage_coefficients`.

    Returns
    -------
    Resultants
        Force (..., 2) and moment (...) on body 1.

    Raises
    ------
    SceneError
        As `strip`, and where there is spin with a C23 that is not positive.

    Notes
    -----
    The equations of `strip`, with creepages that are multiplied by ``4 (1 - nu)/pi^2 C11``,
    ``4/pi^2 C22`` and ``3/pi (b/a)^(1/2) C23``: the ratio of Kalker's slopes to those of strip
    theory, so that the forces by small creepages are those of the linear theory for any ellipse. In
    the slip area the traction has the size of Hertz's bound and the direction that FASTSIM has
    there, with three flexibilities and the parabolic bound. The slip area is integrated with the
    exact share of the bound on each interval, and the stick area in closed form.

    Examples
    --------
    >>> from varcontact.reference import creepage_coefficients
    >>> table = creepage_coefficients(1.0, 1.0, 0.25)
    >>> result = fastrip(1.0, 1.0, 1.0, 1.0, [(1e-6, 0, 0), (0.2, 0.1, 0.3)], table)
    >>> print((result.force[0] / 1e-6 / table.C11).round(5), result.force[1].round(3))
    [-1.  0.] [-0.483 -0.611]
    """
    contact = checked_contact(a, b, G, friction_force, creepages, coefficients)
    return as_resultants(fastrip_forces(contact, m, n))


def strip_forces(c: Contact, m: int = 10, n: int = 10) -> Forces:
    """Fx, Fy and Mz of `strip`."""
    return _forces(divided(m, n, "elliptic"), c, strip_creepages(c))


def fastrip_forces(c: Contact, m: int = 10, n: int = 10) -> Forces:
    """Fx, Fy and Mz of `fastrip`."""
    toward = divided(m, n, "parabolic")
    steps = fastsim_steps(toward, c, flexibilities_of(c, "separate")) * toward.by_bound
    return _forces(divided(m, n, "elliptic"), c, strip_creepages(c, kalker=True), (toward, steps))


def strip_creepages(c: Contact, kalker: bool = False) -> tuple[Any, Any, Any, Any]:
    """X and Y of `strip` in the middle, the difference of X by spin at y = b, and P; of `fastrip`
    with Kalker's slopes.
    """
    by_x: Any
    by_y: Any = 1.0
    by_turn: Any = 1.0
    if kalker:
        by_x = 4 / np.pi**2 * c.table.C11  # with the 1/(1 - nu) of strip theory
        by_y = 4 / np.pi**2 * c.table.C22
        by_turn = 3 / np.pi * np.sqrt(c.b / c.a) * c.table.C23
    else:
        by_x = 1 / (1 - np.asarray(c.nu))
    k = c.G * np.pi * c.a * c.b / (3 * c.limit)  # G/(2 f p0)
    return by_x * k * c.vx, by_y * k * c.vy, by_x * k * c.b * c.spin, by_turn * k * c.a * c.spin


def slip_depth(x: np.ndarray, y: np.ndarray, turn: np.ndarray, edge: np.ndarray) -> np.ndarray:
    """d of `strip`, half the length of the slip area, from X, Y, P and a(y)/a; a(y)/a if all
    slips.
    """
    rest = (1 - turn) * (1 + turn)
    sticks = rest > 0  # somewhere
    rest = np.where(sticks, rest, 1.0)
    x2 = x * x
    y2 = y * y
    mixed = y * turn
    root = np.sqrt(x2 * rest + y2) + np.abs(mixed)
    # the one root that is positive, in the form in which nothing cancels
    depth = np.where(mixed > 0, root / rest, (x2 + y2) / np.maximum(root, SMALLEST))
    return np.where(sticks, np.minimum(depth, edge), edge)


def fastsim_steps(strips: Strips, c: Contact, L: np.ndarray) -> np.ndarray:
    """Steps of `march` (4, ...) in units of the bound's peak and of a and b, by flexibilities (...,
    3).
    """
    step = strips.step * c.a * c.a * c.b / (PEAK[strips.bound] * strips.by_bound * c.limit)
    turn = step / L[..., 2] * c.spin
    by_vx = step / L[..., 0] * c.vx
    by_vy = step / L[..., 1] * c.vy
    return np.stack(np.broadcast_arrays(by_vx, by_vy, turn * c.b, turn * c.a))


def _forces(
    strips: Strips,
    c: Contact,
    scaled: tuple[Any, ...],
    fastsim: tuple[Strips, np.ndarray] | None = None,
) -> Forces:
    """The sums over strips, chunk by chunk.

    The strips' factor on the bound makes the sums exact in full slip. It goes with the slopes by
    the spin, whose integrand is that of the bound; the slopes by vx and vy are exact, and are kept.
    """
    directions, steps = fastsim or (None, ())
    fields = np.stack(np.broadcast_arrays(*scaled, c.a, c.b, c.limit, *steps))
    shape = fields.shape[1:]
    fields = fields.reshape(len(fields), -1)
    fields[:7] = np.clip(fields[:7], -LARGEST_STEP, LARGEST_STEP)
    fields[:3] /= strips.by_bound
    columns = np.concatenate([fields[:4], fields[7:]])
    sums = by_chunks(strips, columns, lambda chunk: _integrals(strips, chunk, directions))
    along_x, along_y, by_x, by_y = sums * (PEAK["elliptic"] * strips.by_bound * fields[6])
    return (
        along_x.reshape(shape),
        along_y.reshape(shape),
        (fields[4] * by_y - fields[5] * by_x).reshape(shape),
    )


def by_chunks(
    strips: Strips, columns: np.ndarray, integrals: Callable[[np.ndarray], np.ndarray]
) -> np.ndarray:
    """Integrals (4, k), a few columns at once; one alone twice: a sum over axis 0 of it would be in
    another order.
    """
    sums = np.empty((4, columns.shape[1]))
    size = max(CHUNK_POINTS // strips.width.size, 2)
    for start in range(0, columns.shape[1], size):
        chunk = columns[:, start : start + size]
        count = chunk.shape[1]
        if count == 1:
            chunk = np.repeat(chunk, 2, axis=1)
        sums[:, start : start + count] = integrals(chunk)[:, :count]
    return sums


def _integrals(strips: Strips, columns: np.ndarray, directions: Strips | None) -> np.ndarray:
    """Integrals over the unit disk of px, py, y px and x py, (4, k), in units of the bound's peak.

    Columns are creepages, as `strip_creepages` scales them, and below these steps of `march` over
    `directions`.
    """
    across = strips.across[:, None]
    edge = strips.edge[:, None]
    width = strips.width[:, None]
    x, y, by_place, turn = columns[:4]
    x = x - across * by_place
    y = np.broadcast_to(y, (edge.size, y.size))
    d = slip_depth(x, y, turn, edge)
    stick = edge - d
    # the two circles, each in closed form, as if the whole strip had the direction n
    half = np.pi / 2 * (2 * edge - d)
    whole = d >= edge
    both = ~whole & (d > 0)
    length = np.where(both, d, 1.0)
    # n; 0 where the strip slips, or sticks, as a whole
    direction_x = np.where(both, x / length, 0.0)
    direction_y = np.where(both, (y + turn * d) / length, 0.0)
    inner = np.pi / 2 * stick * stick
    sum_x = np.where(whole, 0.0, half * x)
    sum_y = np.where(whole, 0.0, half * (y + turn * d) + inner * turn)
    moment = np.where(whole, 0.0, -inner * y)
    if directions is not None or np.any(turn) or np.any(whole):
        toward: Iterator[tuple[np.ndarray, np.ndarray]]
        if directions is None:
            turned = edge * turn
            toward = ((x, y + place * turned) for place in strips.along)
            sign = 1.0
        else:
            toward = march(directions, columns[4:])
            sign = -1.0
        # up to where the slip area reaches: (2 d - a)/a
        share = half_circle_area(1 - 2 * stick / edge)
        slip_x, slip_y, slip_moment, lever = _slip_area(strips.along, share, toward)
        area = edge * edge
        part = share + np.pi / 4
        sum_x += area * (sign * slip_x - part * direction_x)
        sum_y += area * (sign * slip_y - part * direction_y)
        moment += area * edge * (sign * slip_moment - lever * direction_y)
    return np.asarray((-width * np.stack([sum_x, sum_y, across * sum_x, moment])).sum(axis=1))


def _slip_area(
    along: np.ndarray, share: np.ndarray, toward: Iterator[tuple[np.ndarray, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Integrals over the slip area of the bound: times a direction, times that and x, and times x
    alone; `toward` are vectors of this direction, `share` areas under a half circle, to its end.
    """
    sum_x, sum_y, moment, lever = np.zeros((4, *share.shape))
    ends = half_circle_area(np.linspace(1.0, -1.0, along.size + 1))
    for i, (place, (px, py)) in enumerate(zip(along, toward, strict=True)):
        weight = np.minimum(np.maximum(share - ends[i + 1], 0.0), ends[i] - ends[i + 1])
        size = weight / np.maximum(np.sqrt(px * px + py * py), SMALLEST)
        along_y = size * py
        lever += place * weight
        sum_x += size * px
        sum_y += along_y
        moment += place * along_y
    return sum_x, sum_y, moment, lever


@dataclass(frozen=True, eq=False)
class Strips:
    """A division of the ellipse, and factors that make the sums over its points exact."""

    across: np.ndarray  # the strips' places y/b (n,)
    width: np.ndarray  # weights of an integral over y/b (n,)
    along: np.ndarray  # points of each strip by its half-length, from the leading edge down
    bounds: np.ndarray  # the traction bound at these points, by its peak in the strip
    step: float  # distance of points by the strip's half-length
    first: float  # distance of the first point from the leading edge, in steps
    bound: str
    by_bound: float = 1.0
    by_creepage: float = 1.0
    by_spin: float = 1.0

    @property
    def edge(self) -> np.ndarray:
        """Half-lengths a(y)/a."""
        return np.sqrt((1 - self.across) * (1 + self.across))

    @property
    def peak(self) -> np.ndarray:
        """The bound's peak in the strips by that in the middle."""
        return self.edge if self.bound == "elliptic" else self.edge**2


def divided(m: int, n: int, bound: str, division: str = "calibrated") -> Strips:
    """The strips of a division, see `fastsim`; its arguments are checked."""
    choice("division", division, ("printed", "calibrated"))
    choice("bound", bound, PEAK)
    return _strips(
        whole("m", m, least=2, most=MAX_DIVISIONS),
        whole("n", n, most=MAX_DIVISIONS),
        bound,
        division,
    )


@lru_cache(maxsize=64)
def _strips(m: int, n: int, bound: str, division: str) -> Strips:
    """Kalker's: equal strips, points at the ends of intervals but the last, where the bound is 0.

    Or one whose sums have the slopes of the linear theory, and ``f Fz`` in full slip, to rounding:
    strips at Chebyshev's points, points in the middles of intervals, and the bound its mean over an
    interval.
    """
    if division == "printed":
        along = 1 - 2 * np.arange(1, m) / m
        inside = (1 - along) * (1 + along)
        across = 1 - (2 * np.arange(n) + 1) / n
        bounds = inside if bound == "parabolic" else np.sqrt(inside)
        return Strips(across, np.full(n, 2 / n), along, bounds, 2 / m, 1.0, bound)
    angle = np.pi * np.arange(1, n + 1) / (n + 1)
    across = np.cos(angle)
    edge = np.sin(angle)
    width = np.pi / (n + 1) * edge
    along = 1 - (2 * np.arange(m) + 1) / m
    ends = np.linspace(1.0, -1.0, m + 1)
    whole_strip = ends - ends**3 / 3 if bound == "parabolic" else half_circle_area(ends)
    bounds = -np.diff(whole_strip) * m / 2
    square = 4 / 3 / np.sum(width * edge**2)
    cube = 3 * np.pi / 8 / np.sum(width * edge**3)
    return Strips(
        across=across,
        width=width,
        along=along,
        bounds=bounds,
        step=2 / m,
        first=0.5,
        bound=bound,
        by_bound=cube if bound == "parabolic" else square,
        by_creepage=square,
        by_spin=cube / (1 + 0.5 / m**2),
    )


def half_circle_area(x: np.ndarray) -> np.ndarray:
    """Area under half a circle of radius 1 from its middle to x in [-1, 1]."""
    return 0.5 * (x * np.sqrt((1 - x) * (1 + x)) + np.arcsin(x))


def march(strips: Strips, steps: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """px and py (n, k) of FASTSIM at one point of all strips after the other, by the strip's own
    peak.

    `steps` (4, k) are what a step in the middle strip adds: by vx, by vy, by spin at y = b, and by
    spin at x = a. The same two arrays every time: fresh ones would cost as much as the arithmetic.
    """
    edge = strips.edge[:, None]
    peak = strips.peak[:, None]
    # squares must not overflow
    largest = np.abs(steps).max(axis=0, initial=1.0)
    vx, vy, spin_y, spin_x = steps * np.minimum(1.0, LARGEST_STEP / largest)
    step_x = -(edge / peak) * (vx - strips.across[:, None] * spin_y)
    by_place = -(edge / peak) * edge * spin_x
    middle = 1 - strips.first * strips.step / 2  # of the interval ahead of the first point
    plain_y = -(edge / peak) * vy
    px = strips.first * step_x
    py = strips.first * (plain_y + middle * by_place)
    step_y = plain_y + (strips.along[0] - strips.step / 2) * by_place
    by_place *= strips.step
    for i, limit in enumerate(strips.bounds):
        if i > 0:
            px += step_x
            py += step_y
            step_y -= by_place
        cut = limit / np.sqrt(np.maximum(px * px + py * py, limit * limit))  # 1 in the stick area
        px *= cut
        py *= cut
        yield px, py


def march_sums(strips: Strips, steps: np.ndarray) -> np.ndarray:
    """Integrals over the unit disk of px, py, y px and x py (4, k), by steps of `march` in units of
    the peak.
    """
    factors = [strips.by_creepage, strips.by_creepage, strips.by_spin, strips.by_spin]
    steps = steps * np.array(factors)[:, None]
    across = strips.across[:, None]
    edge = strips.edge[:, None]
    weight = strips.width[:, None] * strips.step * edge * strips.peak[:, None] * strips.by_bound

    def integrals(chunk: np.ndarray) -> np.ndarray:
        """All strips of a few triples, through the contact at once."""
        sum_x, sum_y, moment = np.zeros((3, edge.size, chunk.shape[1]))
        for place, (px, py) in zip(strips.along, march(strips, chunk), strict=True):
            sum_x += px
            sum_y += py
            moment += place * py
        sums = np.stack([sum_x, sum_y, across * sum_x, edge * moment])
        return np.asarray((weight * sums).sum(axis=1))

    return by_chunks(strips, steps, integrals)
