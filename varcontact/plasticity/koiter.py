"""Upper bounds on the load factor by Koiter's theorem: dissipation, divided by work, of a mechanism
whose plastic strains add up, over a passage, to those of velocities u(y, z),

    lambda = sum k |g_j| / sum e(x_j) . g_j .

Velocities are quadratic on triangles and zero at the edges of the section. Strains are then linear
in a triangle, so that |g| is bounded by its corners, and e enters by means with the weights of the
corners, 3 N/area (Makrodimopoulos and Martin 2007, Int. J. Numer. Methods Eng. 69, 1). The program
is solved in terms of stresses. Velocities are the multipliers of equilibrium, and strains are made
compatible with them by hand.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from varcontact.plasticity.cone_program import Triplets, solve_cones, yield_cones
from varcontact.plasticity.flow_mesh import Mesh
from varcontact.plasticity.passage import Passage, Strength
from varcontact.plasticity.work import Means

ROUNDS = 6
"""Largest number of programs."""
TOLERANCE = 3e-3
"""Relative excess over the yield surface below which a round is the last."""
GAINED = 1e-3
"""Relative change of the load factor below which a round is the last."""
SMALL = 0.7
"""Stress, divided by the yield stress, below which a sample is left out of later rounds."""
PEAKS_ADDED = 4
"""Samples of a corner that a round may add."""
ROUNDING = 1e-9
"""Change of volume, divided by the plastic strain, that counts as zero."""
RIDGE = 1e-9
"""Number added to the diagonal of a matrix with dependent rows, divided by that diagonal."""
CORRECTIONS = 4
"""Number of solves with that matrix; each leaves about the part `RIDGE` of the error."""
EXTREMES = [3]
"""Coordinates whose extremes along x are among the first samples."""


@dataclass(frozen=True, eq=False)
class FlowField:
    """An upper bound on the load factor, and its velocities.

    Attributes
    ----------
    factor : float
        Dissipation by work, with what quadrature of the work may leave out.
    mesh : Mesh
    velocity : ndarray, shape (3, nodes)
        Net displacement of a passage along x, y, z, largest 1.
    net : ndarray, shape (2,)
        Net plastic shear on planes of one depth, along x and y, by all plastic strain.
    ratchet : float
        Size of the net plastic strain, by all plastic strain.
    place : tuple of float
        Centre of dissipation: y and depth, divided by the half-width.
    unit : float
        Half the width of the contact [length].
    """

    factor: float
    mesh: Mesh
    velocity: np.ndarray
    net: np.ndarray
    ratchet: float
    place: tuple[float, float]
    unit: float


def upper_bound(
    passage: Passage, mesh: Mesh, strength: Strength, report: Callable[[str], None]
) -> FlowField | None:
    """The least load factor of all velocities on a mesh; None where the program finds none."""
    means = Means.of(passage, mesh, strength)
    curves = means.curves
    radius = means.radius
    chosen = _first_samples(curves)
    unit = passage.elastic_limit
    before = np.inf
    for number in range(1, ROUNDS + 1):
        factor, stress, multipliers, samples = _program(mesh, unit * curves, radius, chosen)
        size = np.linalg.norm(unit * factor * curves + stress[:, None], axis=-1) / radius[:, None]
        report(f"program {number} of the upper bound, {len(samples)} cones: {unit * factor:.4g}")
        if size.max() < 1 + TOLERANCE or factor > (1 - GAINED) * before:
            break
        before = factor
        _drop_small(chosen, size)
        _add_peaks(chosen, size)
    other = None
    if passage.field is None:
        other = Means.of(passage, mesh, strength, order=2).curves
    return _certified(means, multipliers, samples, other)


def _first_samples(curves: np.ndarray) -> np.ndarray:
    """Samples (corners, nx + 1) to begin with: extremes, and the load far away."""
    count, nx, _ = curves.shape
    chosen = np.zeros((count, nx + 1), dtype=bool)
    corner = np.arange(count)
    chosen[corner, np.linalg.norm(curves, axis=-1).argmax(axis=1)] = True
    for component in EXTREMES:
        chosen[corner, curves[..., component].argmax(axis=1)] = True
        chosen[corner, curves[..., component].argmin(axis=1)] = True
    chosen[:, -1] = True
    return chosen


def _drop_small(chosen: np.ndarray, size: np.ndarray) -> None:
    """Leave samples out that are far from the yield surface; the load far away stays."""
    chosen[:, :-1] &= size > SMALL


def _add_peaks(chosen: np.ndarray, size: np.ndarray) -> None:
    """Add the highest maxima along x of all corners that exceed the yield surface."""
    before = np.pad(size, ((0, 0), (1, 0)))[:, :-1]
    after = np.pad(size, ((0, 0), (0, 1)))[:, 1:]
    peaks = (size >= before) & (size > after) & (size > 1 - TOLERANCE)
    for corner in np.flatnonzero(size.max(axis=1) > 1 + TOLERANCE / 4):
        found = np.flatnonzero(peaks[corner])
        chosen[corner, found[np.argsort(-size[corner, found])[:PEAKS_ADDED]]] = True


def _program(
    mesh: Mesh, curves: np.ndarray, radius: np.ndarray, chosen: np.ndarray
) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Load factor, residual stress (corners, 5), multipliers, and samples (cones, 2)."""
    corners = len(curves)
    free = np.full(mesh.held.shape, -1)
    equations = int(np.count_nonzero(~mesh.held))
    free[~mesh.held] = np.arange(equations)
    entries = Triplets.empty()
    _equilibrium(entries, mesh, free)
    samples = np.argwhere(chosen)
    at = np.zeros((len(samples), 5))
    loaded = samples[:, 1] < curves.shape[1]
    at[loaded] = curves[samples[loaded, 0], samples[loaded, 1]]
    yield_cones(entries, equations, at, 2 + 6 * samples[:, 0])
    right = np.zeros(equations + 6 * len(samples))
    right[equations::6] = radius[samples[:, 0]]
    cost = np.zeros(1 + 6 * corners)
    cost[0] = -1.0
    variables, multipliers = solve_cones(entries, right, equations, cost, np.zeros(len(cost)))
    stress = variables[1:].reshape(corners, 6)[:, 1:]
    return float(variables[0]), stress, multipliers, samples


EQUILIBRIUM = (
    (0, 3, 0, 1.0), (0, 4, 1, 1.0),
    (1, 0, 0, 1.0), (1, 1, 0, 1.0), (1, 5, 1, 1.0),
    (2, 0, 1, 1.0), (2, 1, 1, -1.0), (2, 5, 0, 1.0),
)  # fmt: skip
"""Velocity, stress, derivative (0: y, 1: z) and sign of the terms of virtual work; stresses are the
mean of syy and szz, and the five coordinates."""


def _equilibrium(entries: Triplets, mesh: Mesh, free: np.ndarray) -> None:
    """Rows of equilibrium, one for each free velocity; variables of a corner are the mean stress
    and the five coordinates.
    """
    triangles = len(mesh.area)
    weighted = mesh.gradients * (mesh.area / 3)[:, None, None, None]
    corner = np.arange(3 * triangles).reshape(triangles, 3, 1) * np.ones((1, 1, 6), dtype=int)
    for velocity, component, derivative, sign in EQUILIBRIUM:
        row = free[velocity][mesh.nodes][:, None, :] * np.ones((1, 3, 1), dtype=int)
        inner = row >= 0
        values = sign * weighted[..., derivative]
        entries.add(row[inner], 1 + 6 * corner[inner] + component, values[inner])


def _certified(
    means: Means, multipliers: np.ndarray, samples: np.ndarray, other: np.ndarray | None
) -> FlowField | None:
    """Upper bound from the velocities and strains of the multipliers, computed independently: the
    difference between the strains and those of the velocities is added as dissipation without work.

    Work is less by what its quadrature may miss: bounded, or estimated by `other` means.
    """
    mesh = means.mesh
    curves = means.curves
    equations = int(np.count_nonzero(~mesh.held))
    velocity = np.zeros(mesh.held.shape)
    velocity[~mesh.held] = multipliers[:equations]
    strains = multipliers[equations:].reshape(-1, 6)[:, 1:]
    # net strain of each corner, and that of velocities without change of volume
    net = np.zeros((len(curves), 5))
    np.add.at(net, samples[:, 0], strains)
    velocity = _isochoric(mesh, velocity)
    compatible, volume = _strain(mesh, velocity)
    if np.sum(net * compatible) < 0:
        velocity = -velocity
        compatible = -compatible
    lacking = np.linalg.norm(compatible - net, axis=1)
    size = np.linalg.norm(strains, axis=1)
    dissipated = np.sum(size * means.radius[samples[:, 0]]) + np.sum(lacking * means.radius)
    # work of the field, and what its quadrature may miss
    loaded = samples[:, 1] < curves.shape[1]
    corner, along = samples[loaded].T
    work = abs(float(np.sum(strains[loaded] * curves[corner, along])))
    if other is None:
        missed = means.missed(corner, along, strains[loaded])
    else:
        missed = abs(work - abs(float(np.sum(strains[loaded] * other[corner, along])))) / 4
    if work <= missed or np.abs(volume).sum() > ROUNDING * size.sum():
        return None
    share = np.zeros(len(curves))
    np.add.at(share, samples[:, 0], size)
    total = share.sum()
    place = share @ mesh.places[mesh.corners].reshape(-1, 2) / total
    return FlowField(
        factor=float(dissipated / (work - missed)),
        mesh=mesh,
        velocity=velocity / max(float(np.abs(velocity).max()), 1e-300),
        net=net.sum(axis=0)[3:] / total,
        ratchet=float(np.linalg.norm(net, axis=1).sum() / total),
        place=(float(place[0]), float(place[1])),
        unit=means.passage.unit,
    )


def _isochoric(mesh: Mesh, velocity: np.ndarray) -> np.ndarray:
    """The nearest velocities (3, nodes) that change no volume."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    free = ~mesh.held[1:]
    number = np.full(free.shape, -1)
    number[free] = np.arange(np.count_nonzero(free))
    slopes = mesh.gradients * (mesh.area / 3)[:, None, None, None]
    entries = Triplets.empty()
    row = np.arange(3 * len(mesh.area)).reshape(-1, 3, 1) * np.ones((1, 1, 6), dtype=int)
    for axis in range(2):
        column = number[axis][mesh.nodes][:, None, :] * np.ones((1, 3, 1), dtype=int)
        inner = column >= 0
        entries.add(row[inner], column[inner], slopes[..., axis][inner])
    change = entries.matrix((row.shape[0] * 3, int(np.count_nonzero(free))))
    across = velocity[1:][free]
    # conditions are dependent where four triangles meet: a small ridge is added, then corrected for
    normal = change @ change.T
    solved = splu((normal + RIDGE * sparse.diags(normal.diagonal())).tocsc())
    for _ in range(CORRECTIONS):
        across = across - change.T @ solved.solve(change @ across)
    found = velocity.copy()
    found[1:][free] = across
    return found


def _strain(mesh: Mesh, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Strain (corners, 5) of velocities and change of volume (corners,), times a third of the
    area.
    """
    local = velocity[:, mesh.nodes]
    slopes = np.einsum("tvnd,ktn->ktvd", mesh.gradients, local)
    ux, uy, uz = slopes
    strain = np.stack(
        [uy[..., 0] - uz[..., 1], 0 * ux[..., 0], ux[..., 0], ux[..., 1], uy[..., 1] + uz[..., 0]],
        axis=-1,
    )
    weight = np.repeat(mesh.area / 3, 3)
    volume = (uy[..., 0] + uz[..., 1]).reshape(-1) * weight
    return strain.reshape(-1, 5) * weight[:, None], volume
