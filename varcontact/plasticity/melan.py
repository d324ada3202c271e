"""Lower bounds on the load factor by Melan's theorem: the largest one for which some residual
stress keeps the whole passage within the yield surface,

    max lambda:   |lambda e(x; y, z) + r(y, z)| <= k   for all x, y, z.

A cone program of few samples; after each solve all samples are checked, and the worst added.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from varcontact.plasticity.cone_program import Triplets, solve_cones, yield_cones
from varcontact.plasticity.passage import Passage
from varcontact.plasticity.remainder import between_samples
from varcontact.plasticity.residual_stress import FREE, CellResidual, ResidualSpace

ROUNDS = 12
"""Largest number of programs."""
TOLERANCE = 4e-3
"""Relative excess over the yield surface that is removed by scaling."""
MARGIN_MAX = 0.3
"""Largest margin kept free for stresses between samples."""
SMALL = 0.7
"""Stress, divided by the yield stress, below which a sample is left out of later programs."""
POINTS_ADDED = 80
"""Points that a round may add."""
PEAKS_ADDED = 4
"""Samples of a point that a round may add."""
STALLED = 1.002
"""Factor by which the bound must grow in a round; the third round below it is the last."""
SMALL_STRESS = 0.1
"""Weight of the square of the residual stress: the smallest of nearly equal ones is chosen. With a
lower weight the stress between samples exceeds that at samples by 1.5 %."""
EXTREMES = [0, 1, 3]
"""Coordinates whose extremes along x are among the first samples."""


@dataclass(frozen=True, eq=False)
class LowerBound:
    """A load factor that shakes down, and the residual stress that proves it.

    Attributes
    ----------
    factor : float
        With what may lie between samples.
    sampled : float
        At the samples alone.
    residual : ndarray, shape (3, 3, nz, ny)
        Residual stress at `factor`, by the least yield stress.
    by_cell : CellResidual
        The same between samples, too.
    largest : ndarray, shape (nz, ny)
        Largest stress of each point's passage, by the yield stress.
    at_surface : float
        Part of the dissipation that the last program has at the surface.
    rounds : int
        Programs that were solved.
    """

    factor: float
    sampled: float
    residual: np.ndarray
    by_cell: CellResidual
    largest: np.ndarray
    at_surface: float
    rounds: int


def lower_bound(
    passage: Passage,
    space: ResidualSpace,
    enough: float,
    report: Callable[[str], None],
    margins: np.ndarray | None = None,
) -> LowerBound:
    """The largest load factor, or one that is `enough`, with margins (ny, nx) at the surface, at
    the load factor 1, for what lies between samples there.
    """
    shape = passage.curves.shape[:3]
    margin = np.zeros((*shape[:2], shape[2] + 1))
    if margins is not None:
        margin[0, :, :-1] = np.minimum(enough * margins, MARGIN_MAX)
    chosen = _first_samples(passage, space)
    best: LowerBound | None = None
    sampled = 0.0
    closing = False
    stalled = 0
    for number in range(1, ROUNDS + 1):
        # a program of the samples chosen, and the stress at all samples
        factor, coefficients, dissipated = _program(passage, space, chosen, margin)
        stress, bent, size = _stresses(passage, space, factor, coefficients, margin)
        excess = between_samples(passage, stress, bent)
        if margins is not None:
            excess[0] = np.maximum(excess[0], np.minimum(factor * margins, MARGIN_MAX))
        between = size.copy()
        between[..., :-1] += excess
        sampled = max(sampled, factor / float(size.max()))
        scale = float(between.max())
        axial = (stress - bent)[:, :, 0, 1]
        found = LowerBound(
            factor=factor / scale,
            sampled=sampled,
            residual=space.tensor(coefficients, axial, passage) / scale,
            by_cell=space.by_cell(coefficients / scale, axial / scale, passage),
            largest=between.max(axis=-1) / scale,
            at_surface=float(dissipated[np.nonzero(chosen)[0] == 0].sum() / dissipated.sum()),
            rounds=number,
        )
        gained = best is None or found.factor > STALLED * best.factor
        stalled += closing and not gained
        best = _better(best, found)
        report(f"program {number} of the lower bound, {chosen.sum()} cones: {best.factor:.4g}")
        if between.max() < 1 + TOLERANCE or best.factor >= enough or stalled > 2:
            break
        # at samples first, then with margins for stresses between them
        closing = closing or number > 1 or size.max() < 1 + 2 * TOLERANCE
        _drop_small(chosen, between)
        if closing:
            kept = np.minimum(excess, MARGIN_MAX)
            margin[..., :-1] = np.maximum(kept, 0.4 * margin[..., :-1])
            _add_worst(chosen, between)
        else:
            _add_worst(chosen, size)
    assert best is not None
    return replace(best, sampled=sampled, rounds=number)


def _better(best: LowerBound | None, found: LowerBound) -> LowerBound:
    if best is None or found.factor > best.factor:
        return found
    return best


def _first_samples(passage: Passage, space: ResidualSpace) -> np.ndarray:
    """Samples (nz, ny, nx + 1) to begin with: the extremes of points near the middles and ends of
    the splines' intervals, and the load far away.
    """
    nz, ny, nx, _ = passage.curves.shape
    y = np.sort(np.concatenate([space.y, (space.y[1:] + space.y[:-1]) / 2]))[1:-1]
    depth = np.sort(np.concatenate([space.depth, (space.depth[1:] + space.depth[:-1]) / 2]))[:-1]
    columns = np.unique(np.abs(passage.y[:, None] - y[y >= passage.y[0]]).argmin(axis=0))
    rows = np.unique(np.abs(passage.depth[:, None] - depth).argmin(axis=0))
    chosen = np.zeros((nz, ny, nx + 1), dtype=bool)
    for row in rows:
        for column in columns:
            _choose_extremes(chosen[row, column], passage.curves[row, column])
    return chosen


def _choose_extremes(chosen: np.ndarray, curve: np.ndarray) -> None:
    chosen[np.linalg.norm(curve, axis=-1).argmax()] = True
    chosen[curve[:, EXTREMES].argmax(axis=0)] = True
    chosen[curve[:, EXTREMES].argmin(axis=0)] = True
    chosen[-1] = True


def _program(
    passage: Passage, space: ResidualSpace, chosen: np.ndarray, margin: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray]:
    """Load factor, coefficients, and dissipation at the samples chosen; the program's own factor
    counts in elastic limits.
    """
    row, column = np.nonzero(chosen.any(axis=-1))
    points = len(row)
    splines = space.rows(passage.y[column], passage.depth[row])
    splines = splines / passage.strength[row][:, None, None]
    scale = np.abs(splines).max(axis=(0, 1))
    scale[scale == 0] = 1.0
    splines = splines / scale
    coefficients = splines.shape[2]
    entries = Triplets.empty()
    # equations: the four components of r at each point by the splines
    at, component, spline = np.nonzero(np.abs(splines) > 1e-13)
    entries.add(4 * at + component, 1 + spline, splines[at, component, spline])
    point = np.repeat(np.arange(points), 4)
    own = 1 + coefficients + 5 * point + np.tile(FREE, points)
    entries.add(np.arange(4 * points), own, -np.ones(4 * points))
    # cones: the yield surface at each sample
    number = np.full(chosen.shape[:2], -1)
    number[row, column] = np.arange(points)
    depth, across, along = np.nonzero(chosen)
    curves = np.zeros((len(along), 5))
    loaded = along < passage.origin
    curves[loaded] = passage.curves[depth[loaded], across[loaded], along[loaded]]
    first = 1 + coefficients + 5 * number[depth, across]
    unit = passage.elastic_limit
    yield_cones(entries, 4 * points, unit * curves, first)
    right = np.zeros(4 * points + 6 * len(along))
    right[4 * points :: 6] = 1.0 - margin[depth, across, along]
    cost = np.zeros(1 + coefficients + 5 * points)
    cost[0] = -1.0
    square = np.zeros(len(cost))
    square[1 + coefficients :] = SMALL_STRESS / points
    variables, multipliers = solve_cones(entries, right, 4 * points, cost, square)
    factor = unit * float(variables[0])
    return factor, variables[1 : 1 + coefficients] / scale, multipliers[4 * points :: 6]


def _stresses(
    passage: Passage,
    space: ResidualSpace,
    factor: float,
    coefficients: np.ndarray,
    margin: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Stress (nz, ny, nx, 5) with the best rho_xx of each point, the same without rho_xx, and sizes
    (nz, ny, nx + 1), the last without load.
    """
    residual = space.field(coefficients, passage)
    bent = factor * passage.curves + residual[:, :, None]
    axial = np.concatenate([bent[..., 1], residual[:, :, None, 1]], axis=-1)
    others = np.sum(bent**2, axis=-1) - bent[..., 1] ** 2
    far = np.sum(residual**2, axis=-1)[..., None]
    rest = np.concatenate([np.maximum(others, 0.0), far], axis=-1)
    shift = _best_shift(axial, rest, margin)
    stress = bent.copy()
    stress[..., 1] += shift[..., None]
    return stress, bent, np.sqrt((axial + shift[..., None]) ** 2 + rest)


def _best_shift(axial: np.ndarray, rest: np.ndarray, margin: np.ndarray) -> np.ndarray:
    """rho_xx of each point for which the largest ``sqrt((axial + rho)^2 + rest) + margin`` is
    least, by the golden section.
    """
    low = -axial.max(axis=-1)
    high = -axial.min(axis=-1)
    for _ in range(30):
        first = low + 0.382 * (high - low)
        second = low + 0.618 * (high - low)
        left = _largest(axial, rest, margin, first) < _largest(axial, rest, margin, second)
        high = np.where(left, second, high)
        low = np.where(left, low, first)
    return (low + high) / 2


def _largest(
    axial: np.ndarray, rest: np.ndarray, margin: np.ndarray, shift: np.ndarray
) -> np.ndarray:
    return (np.sqrt((axial + shift[..., None]) ** 2 + rest) + margin).max(axis=-1)


def _drop_small(chosen: np.ndarray, size: np.ndarray) -> None:
    """Leave samples out that are far from the yield surface; loads far away stay."""
    chosen[..., :-1] &= size[..., :-1] > SMALL


def _add_worst(chosen: np.ndarray, size: np.ndarray) -> None:
    """Add the worst points, no two of them neighbours, and the peaks along x of all that exceed the
    yield surface.
    """
    worst = size.max(axis=-1)
    known = np.asarray(chosen.any(axis=-1))
    taken = np.zeros_like(known)
    over = np.argwhere(worst > 1 + TOLERANCE / 4)
    for row, column in over[np.argsort(-worst[tuple(over.T)])]:
        if not known[row, column]:
            beside = taken[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
            if taken.sum() >= POINTS_ADDED or beside.any():
                continue
            taken[row, column] = True
            chosen[row, column, -1] = True
        for peak in _peaks(size[row, column]):
            chosen[row, column, peak] = True


def _peaks(size: np.ndarray) -> np.ndarray:
    """The highest local maxima along x that reach the yield surface."""
    rises = np.concatenate([[True], size[1:] >= size[:-1]])
    falls = np.concatenate([size[:-1] > size[1:], [True]])
    found = np.flatnonzero(rises & falls & (size > 1 - TOLERANCE))
    return found[np.argsort(-size[found])[:PEAKS_ADDED]]
