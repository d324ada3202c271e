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
from dataclasses import dataclass, replace

import numpy as np

from varcontact.plasticity.cone_program import Triplets, solve_cones, yield_cones
from varcontact.plasticity.passage import Passage

ROUNDS = 6
"""Programs at most."""
TOLERANCE = 3e-3
"""Excess over the yield surface at which all samples are in the program."""
DEPTH_POWER = 1.6
"""Rectangles grow with the depth as this power of their number."""
WIDTH_POWER = 1.4
"""The same beside the contact."""
EXTENT = 0.9
"""Part of the passage's section that the mesh covers."""
PEAKS_ADDED = 4
"""Samples of a corner that a round may add."""
EXTREMES = [0, 1, 3]
"""Coordinates whose extremes along x are samples from the beginning."""
QUADRATURE_POINTS = np.array([0.445948490915965, 0.091576213509771])
"""Dunavant's rule of degree 4: barycentric coordinates of two of its points."""
QUADRATURE_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles with quadratic velocities in a section.

    Attributes
    ----------
    nodes : ndarray, shape (triangles, 6)
        Corners, then middles of the edges opposite them.
    places : ndarray, shape (n, 2)
        y and depth of the nodes, divided by the half-width.
    area : ndarray, shape (triangles,)
    gradients : ndarray, shape (triangles, 3, 6, 2)
        Of the shape functions at the corners.
    held : ndarray, shape (3, n)
        Where velocities along x, y, z are zero.
    """

    nodes: np.ndarray
    places: np.ndarray
    area: np.ndarray
    gradients: np.ndarray
    held: np.ndarray

    @property
    def corners(self) -> np.ndarray:
        """The first three nodes of each triangle."""
        return self.nodes[:, :3]


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


def flow_mesh(passage: Passage, inside: int, outside: int, down: int) -> Mesh:
    """A mesh of so many rectangles across the contact, beside it on either side, and in depth, each
    of four triangles; half of it where left and right are alike.
    """
    left, right = passage.loaded[2:]
    beyond = EXTENT * (passage.y[-1] - right)
    steps = (np.arange(1, outside + 1) / outside) ** WIDTH_POWER
    middle = np.linspace(left, right, inside + 1)
    y = np.concatenate([(left - beyond * steps)[::-1], middle, right + beyond * steps])
    if passage.symmetric:
        y = y[len(y) // 2 :]
    depth = EXTENT * passage.depth[-1] * np.linspace(0, 1, down + 1) ** DEPTH_POWER
    return _triangulated(y, depth, passage.symmetric)


def _triangulated(y: np.ndarray, depth: np.ndarray, symmetric: bool) -> Mesh:
    # corners of rectangles, and their middles
    lattice = np.stack(np.meshgrid(y, depth, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(len(lattice)).reshape(len(y), len(depth))
    around = (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    ring = [each.ravel() for each in around]
    centre = len(lattice) + np.arange(ring[0].size)
    points = np.concatenate([lattice, (lattice[ring[0]] + lattice[ring[2]]) / 2])
    triangles = [np.stack([ring[side], ring[(side + 1) % 4], centre], axis=-1) for side in range(4)]
    corners = np.concatenate(triangles)
    # middles of the edges
    edges = np.concatenate([corners[:, [1, 2]], corners[:, [2, 0]], corners[:, [0, 1]]])
    unique, inverse = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    nodes = np.concatenate([corners, len(points) + inverse.reshape(3, -1).T], axis=1)
    places = np.concatenate([points, points[unique].mean(axis=1)])
    # areas, and gradients of the shape functions at the corners
    at = points[corners]
    jacobian = np.stack([at[:, 1] - at[:, 0], at[:, 2] - at[:, 0]], axis=1)
    inverse_jacobian = np.linalg.inv(jacobian)
    second = inverse_jacobian[:, :, 0]
    third = inverse_jacobian[:, :, 1]
    barycentric = np.stack([-second - third, second, third], axis=1)
    edge = np.isclose(places[:, 0], y[-1]) | np.isclose(places[:, 1], depth[-1])
    left = np.isclose(places[:, 0], y[0])
    held = np.array([edge, edge, edge])
    if symmetric:
        held[1] |= left
    else:
        held |= left
    return Mesh(
        nodes=nodes,
        places=places,
        area=np.abs(np.linalg.det(jacobian)) / 2,
        gradients=_gradients(barycentric),
        held=held,
    )


def _gradients(barycentric: np.ndarray) -> np.ndarray:
    """Gradients (triangles, 3 corners, 6 nodes, 2) of quadratic shape functions."""
    gradients = np.zeros((len(barycentric), 3, 6, 2))
    for corner in range(3):
        for node in range(3):
            gradients[:, corner, node] = (4 * (corner == node) - 1) * barycentric[:, node]
        for opposite in range(3):
            first = (opposite + 1) % 3
            second = (opposite + 2) % 3
            if corner == first:
                gradients[:, corner, 3 + opposite] = 4 * barycentric[:, second]
            elif corner == second:
                gradients[:, corner, 3 + opposite] = 4 * barycentric[:, first]
    return gradients


def upper_bound(passage: Passage, mesh: Mesh, report: Callable[[str], None]) -> FlowField | None:
    """The least load factor of all velocities on a mesh; None where the program finds none."""
    strength = passage.strength[:, None, None, None]
    field = passage.curves * strength
    means = _corner_means(passage, mesh, field, order=4)
    radius = _corner_means(passage, mesh, strength * np.ones_like(field[:, :, :1, :1]), order=4)
    curves = means.reshape(-1, *means.shape[2:])
    radius = radius.reshape(-1)
    chosen = _first_samples(curves)
    unit = passage.elastic_limit
    for number in range(1, ROUNDS + 1):
        factor, stress, multipliers, samples = _program(mesh, unit * curves, radius, chosen)
        size = np.linalg.norm(unit * factor * curves + stress[:, None], axis=-1) / radius[:, None]
        report(f"program {number} of the upper bound, {len(samples)} cones: {unit * factor:.4g}")
        if size.max() < 1 + TOLERANCE:
            break
        _add_peaks(chosen, size)
    linear = _corner_means(passage, mesh, field, order=2).reshape(curves.shape)
    found = _certified(mesh, multipliers, samples, curves, linear, radius)
    if found is None:
        return None
    return replace(found, unit=passage.unit)


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
    mesh: Mesh,
    multipliers: np.ndarray,
    samples: np.ndarray,
    curves: np.ndarray,
    linear: np.ndarray,
    radius: np.ndarray,
) -> FlowField | None:
    """The bound by velocities and strains of the multipliers, computed anew: what the strains lack
    to be those of the velocities is added as dissipation without work.
    """
    equations = int(np.count_nonzero(~mesh.held))
    velocity = np.zeros(mesh.held.shape)
    velocity[~mesh.held] = multipliers[:equations]
    strains = multipliers[equations:].reshape(-1, 6)[:, 1:]
    # net strain of each corner, and that of the velocities
    net = np.zeros((len(curves), 5))
    np.add.at(net, samples[:, 0], strains)
    compatible, volume = _strain(mesh, velocity)
    if np.sum(net * compatible) < 0:
        velocity = -velocity
        compatible = -compatible
    lacking = np.linalg.norm(compatible - net, axis=1)
    # work of the field, and what its two quadratures differ by
    loaded = samples[:, 1] < curves.shape[1]
    corner, along = samples[loaded].T
    work = -np.sum(strains[loaded] * curves[corner, along])
    other = -np.sum(strains[loaded] * linear[corner, along])
    size = np.linalg.norm(strains, axis=1)
    dissipated = np.sum(size * radius[samples[:, 0]]) + np.sum(lacking * radius)
    if work < 0:
        work = -work
        other = -other
    certain = work - abs(work - other) / 4
    if certain <= 0 or np.abs(volume).sum() > 1e-3 * size.sum():
        return None
    share = np.zeros(len(curves))
    np.add.at(share, samples[:, 0], size)
    total = share.sum()
    place = share @ mesh.places[mesh.corners].reshape(-1, 2) / total
    return FlowField(
        factor=float(dissipated / certain),
        mesh=mesh,
        velocity=velocity / max(float(np.abs(velocity).max()), 1e-300),
        net=net.sum(axis=0)[3:] / total,
        ratchet=float(np.linalg.norm(net, axis=1).sum() / total),
        place=(float(place[0]), float(place[1])),
        unit=1.0,
    )


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


def _corner_means(passage: Passage, mesh: Mesh, field: np.ndarray, order: int) -> np.ndarray:
    """Means of a field (nz, ny, ...) over triangles with the weights 3 N of their corners,
    (triangles, 3, ...), by interpolation through so many samples along each axis.
    """
    from scipy import sparse

    a, b = QUADRATURE_POINTS
    rule = np.concatenate([_permuted(a), _permuted(b)])
    points = np.einsum("qv,tvd->tqd", rule, mesh.places[mesh.corners]).reshape(-1, 2)
    first_y, weights_y = _lagrange(passage.y, points[:, 0], order)
    first_z, weights_z = _lagrange(passage.depth, points[:, 1], order)
    offsets = np.arange(order)
    rows = (first_z[:, None] + offsets) * len(passage.y)
    columns = (rows[:, :, None] + (first_y[:, None] + offsets)[:, None, :]).reshape(-1)
    weights = (weights_z[:, :, None] * weights_y[:, None, :]).reshape(-1)
    count = len(points)
    shape = (count, len(passage.y) * len(passage.depth))
    starts = np.repeat(np.arange(count), order**2)
    interpolated = sparse.csr_matrix((weights, (starts, columns)), shape=shape)
    values = interpolated @ field.reshape(shape[1], -1)
    by_triangle = values.reshape(len(mesh.area), 6, -1)
    means = np.einsum("qv,tqf->tvf", 3 * QUADRATURE_WEIGHTS[:, None] * rule, by_triangle)
    return means.reshape(len(mesh.area), 3, *field.shape[2:])


def _permuted(other: float) -> np.ndarray:
    """Barycentric coordinates of three points, two of which are `other`."""
    return np.full((3, 3), other) + (1 - 3 * other) * np.eye(3)


def _lagrange(places: np.ndarray, at: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray]:
    """First sample and weights (points, order) of Lagrange's interpolation."""
    first = np.clip(np.searchsorted(places, at) - order // 2, 0, len(places) - order)
    nodes = places[first[:, None] + np.arange(order)]
    weights = np.ones((len(at), order))
    for own in range(order):
        for other in range(order):
            if own != other:
                weights[:, own] *= (at - nodes[:, other]) / (nodes[:, own] - nodes[:, other])
    return first, weights
