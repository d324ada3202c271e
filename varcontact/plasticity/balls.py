"""Smallest balls about curves of stress: the families of bounds with a closed form.

A point shakes down alone up to the load factor 1/R, with R the radius of the smallest ball about
its curve whose centre, the negative residual stress, has the components that equilibrium leaves
free there:

* all five: alternating plasticity (strains that cancel over a passage are compatible anywhere), an
  upper bound; with unlimited kinematic hardening the limit itself;
* the first three at the surface: a thin layer may slide, so that residual sxz and syz are zero, an
  upper bound; in line contact, at every depth, the limit itself;
* the second: rho_xx alone, any function of y and z, is in equilibrium: a lower bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.plasticity.passage import Passage
from varcontact.plasticity.remainder import between_samples

ANY = (0, 1, 2, 3, 4)
"""Components of a general residual stress."""
IN_PLANE = (0, 1, 2)
"""Components that are free where the tractions on planes of one depth are zero."""
AXIAL = (1,)
"""Component of a residual stress of rho_xx alone."""

SAMPLES = 64
"""Samples of each curve in the first search."""
SEARCH_STEPS = 60
"""Steps of the first search at all points."""
PRUNED_EVERY = 10
"""Search steps between two prunings, which drop points whose ball cannot be the largest, or is
known to `CLOSE_BOUNDS`."""
FINE_STEPS = 800
"""Steps at the points with the largest balls: radii to about 1e-4."""
CLOSE_BOUNDS = 1e-5
"""Relative difference of the bounds on a radius below which the search leaves its point."""
CANDIDATES = 80
"""Number of points with the largest balls that are refined."""


@dataclass(frozen=True, eq=False)
class Balls:
    """Smallest balls about curves, with bounds on their radii.

    Attributes
    ----------
    least, most : ndarray, shape (n,)
        Bounds on the radii: by duality, and of the balls found.
    centres : ndarray, shape (n, 5)
        Negative residual stresses.
    weights : ndarray, shape (n, samples)
        Of the samples that hold the ball.
    """

    least: np.ndarray
    most: np.ndarray
    centres: np.ndarray
    weights: np.ndarray


def smallest_balls(curves: np.ndarray, free: tuple[int, ...], steps: int) -> Balls:
    """Balls about curves (n, samples, 5) and the origin, the load far away, with centres in the
    `free` components.

    The dual problem, to maximise ``sum w |e|^2 - |sum w e_free|^2`` over weights w >= 0 of sum 1,
    by exact steps between pairs of samples, at all points at once.
    """
    count, samples, _ = curves.shape
    curves = np.concatenate([curves, np.zeros((count, 1, 5))], axis=1)
    free_part = curves[..., list(free)]
    square = np.sum(curves**2, axis=-1)
    weights = np.zeros((count, samples + 1))
    weights[np.arange(count), square.argmax(axis=1)] = 1.0
    alive = np.arange(count)
    for step in range(steps):
        if step % PRUNED_EVERY == 0 and step > 0:
            least, most, _ = _bounds(free_part, square, weights, alive)
            alive = alive[(most > least.max()) & (most > (1 + CLOSE_BOUNDS) * least)]
            if not alive.size:
                break
        _exchange(free_part, square, weights, alive)
    least, most, middle = _bounds(free_part, square, weights, np.arange(count))
    centres = np.zeros((count, 5))
    centres[:, list(free)] = middle
    return Balls(least, most, centres, weights[:, :-1])


def _exchange(
    free_part: np.ndarray, square: np.ndarray, weights: np.ndarray, alive: np.ndarray
) -> None:
    """Move weight from the nearest sample that has some to the farthest, as far as it helps."""
    own = weights[alive]
    middle = np.einsum("pn,pnf->pf", own, free_part[alive])
    distance = square[alive] - 2 * np.einsum("pnf,pf->pn", free_part[alive], middle)
    far = distance.argmax(axis=1)
    near = np.where(own > 0, distance, np.inf).argmin(axis=1)
    row = np.arange(len(alive))
    apart = np.sum((free_part[alive, far] - free_part[alive, near]) ** 2, axis=-1)
    gain = distance[row, far] - distance[row, near]
    best = np.divide(gain, 2 * apart, out=np.full_like(gain, np.inf), where=apart > 0)
    moved = np.minimum(best, own[row, near])
    weights[alive, far] += moved
    weights[alive, near] -= moved
    weights[alive, near] = np.where(weights[alive, near] < 1e-14, 0.0, weights[alive, near])


def _bounds(
    free_part: np.ndarray, square: np.ndarray, weights: np.ndarray, at: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lower and upper bounds on the radii of some balls, and their centres."""
    own = weights[at]
    middle = np.einsum("pn,pnf->pf", own, free_part[at])
    inside = np.sum(middle**2, axis=-1)
    dual = np.einsum("pn,pn->p", own, square[at]) - inside
    farthest = (square[at] - 2 * np.einsum("pnf,pf->pn", free_part[at], middle)).max(axis=1)
    return np.sqrt(np.maximum(dual, 0.0)), np.sqrt(farthest + inside), middle


def thinned(curves: np.ndarray, most: int = SAMPLES) -> np.ndarray:
    """About `most` samples of each curve: those with the largest stresses, and some of the rest."""
    count = curves.shape[1]
    if count <= most:
        return curves
    size = np.linalg.norm(curves, axis=-1).max(axis=0)
    large = np.argsort(-size)[: 3 * most // 4]
    rest = np.setdiff1d(np.arange(count), large)
    rest = rest[:: max(1, len(rest) // (most // 4))]
    return curves[:, np.sort(np.concatenate([large, rest]))]


@dataclass(frozen=True, eq=False)
class Mechanism:
    """An upper bound on the load factor, and the place and direction of the plastic flow.

    Attributes
    ----------
    factor : float
        The bound.
    place : tuple of float
        y and depth, divided by the half-width.
    net : ndarray, shape (2,)
        Net flow of a passage along x and y, by all plastic strain.
    critical : ndarray, shape (samples, 5)
        Curve of the place.
    centre : ndarray, shape (5,)
        Centre of the ball about it.
    """

    factor: float
    place: tuple[float, float]
    net: np.ndarray
    critical: np.ndarray
    centre: np.ndarray


@dataclass(frozen=True, eq=False)
class Families:
    """Bounds that need no program.

    Attributes
    ----------
    elastic : float
        Load factor at first yield.
    alternating, surface : Mechanism
        Upper bounds.
    kinematic, kinematic_sampled : float
        Lower bounds with kinematic hardening: with what may lie between samples, and at samples.
    axial, axial_sampled : float
        Lower bounds by rho_xx alone, likewise.
    back_stress : ndarray, shape (nz, ny, 5)
        Of kinematic hardening, at `kinematic`, by the yield stress.
    axial_stress : ndarray, shape (nz, ny, 5)
        Residual stress at `axial`, likewise.
    """

    elastic: float
    alternating: Mechanism
    surface: Mechanism
    kinematic: float
    kinematic_sampled: float
    axial: float
    axial_sampled: float
    back_stress: np.ndarray
    axial_stress: np.ndarray


def families(passage: Passage) -> Families:
    """Two upper bounds, the kinematic limit, and the lower bound with rho_xx alone."""
    nz, ny, nx, _ = passage.curves.shape
    alternating, surface, centres = mechanisms(passage)
    kinematic, kinematic_sampled = _lower(passage, centres)
    # rho_xx alone, and no residual stress
    few = thinned(passage.curves.reshape(nz * ny, nx, 5))
    axial_centres = smallest_balls(few, AXIAL, SEARCH_STEPS).centres.reshape(nz, ny, 5)
    axial, axial_sampled = _lower(passage, axial_centres)
    if passage.elastic_limit > axial:
        none, none_sampled = _lower(passage, 0 * centres)
        if none > axial:
            axial = none
            axial_sampled = none_sampled
            axial_centres = 0 * centres
    return Families(
        elastic=passage.elastic_limit,
        alternating=alternating,
        surface=surface,
        kinematic=kinematic,
        kinematic_sampled=kinematic_sampled,
        axial=axial,
        axial_sampled=axial_sampled,
        back_stress=-kinematic * centres,
        axial_stress=-axial * axial_centres,
    )


def mechanisms(passage: Passage) -> tuple[Mechanism, Mechanism, np.ndarray]:
    """Two upper bounds (alternating plasticity and surface sliding), and the centres (nz, ny, 5) of
    the smallest balls.
    """
    nz, ny, nx, _ = passage.curves.shape
    flat = passage.curves.reshape(nz * ny, nx, 5)
    # all points roughly, then those with the largest balls
    balls = smallest_balls(thinned(flat), ANY, SEARCH_STEPS)
    chosen = np.argsort(-balls.most)[:CANDIDATES]
    fine = smallest_balls(flat[chosen], ANY, FINE_STEPS)
    largest = int(fine.least.argmax())
    centres = balls.centres
    centres[chosen] = fine.centres
    alternating = _mechanism(passage, fine, largest, int(chosen[largest]))
    # sliding of the surface
    sliding = smallest_balls(passage.curves[0], IN_PLANE, FINE_STEPS)
    first = int(sliding.least.argmax())
    surface = _mechanism(passage, sliding, first, first)
    return alternating, surface, centres.reshape(nz, ny, 5)


def _mechanism(passage: Passage, balls: Balls, number: int, point: int) -> Mechanism:
    """The mechanism of one ball, at a point of the section."""
    depth, across = np.unravel_index(point, passage.curves.shape[:2])
    curve = passage.curves[depth, across]
    strain = balls.weights[number][:, None] * (curve - balls.centres[number])
    total = np.linalg.norm(strain, axis=1).sum()
    # the load far away touches the ball, too: its strain is that of the centre
    far = (1 - balls.weights[number].sum()) * np.linalg.norm(balls.centres[number])
    return Mechanism(
        factor=float(1 / balls.least[number]),
        place=(float(passage.y[across]), float(passage.depth[depth])),
        net=strain.sum(axis=0)[3:] / max(total + far, 1e-300),
        critical=curve,
        centre=balls.centres[number],
    )


def _lower(passage: Passage, centres: np.ndarray) -> tuple[float, float]:
    """Lower bounds by balls about given centres (nz, ny, 5): between samples, and at samples."""
    moved = passage.curves - centres[:, :, None]
    size = np.linalg.norm(moved, axis=-1)
    between = size + between_samples(passage, moved, passage.curves)
    far = float(np.linalg.norm(centres, axis=-1).max())
    return 1 / max(float(between.max()), far), 1 / max(float(size.max()), far)
