"""The error of half-spaces at the gauge corner of a rail, by finite elements.

A wheel with a concave root of its flange presses on the gauge corner of a rail, radius 13 mm, in
plane strain and without friction; the force acts along the bisector of the corner. Both bodies are
meshed, and their compliance, from pressures to displacements of the arc, stands in the scene by
`vc.Elasticity.from_compliance`. Beside it the two models that need no mesh: half-spaces on the
tangent plane, and half-spaces along the arc (conformal). Left: a coarse mesh of the rail. Right:
pressures along the arc.

Needs scikit-fem (the extra `docs`). Lengths in mm, forces in N per mm along the rail. Run:
python examples/gauge_corner.py [picture.png]
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import root_scalar
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import splu
from skfem import (
    Basis,
    BilinearForm,
    Element,
    ElementTriP2,
    ElementVector,
    FacetBasis,
    Mesh,
    MeshTri,
)
from skfem.helpers import ddot, eye, sym_grad, trace

import varcontact as vc
from varcontact.plotting.style import legend_below

E = 210e3  # N/mm2
NU = 0.28
STEEL = vc.Bodies.from_young(E=E, nu=NU)
RADIUS = 13.0
HERTZ_PRESSURE = 1500.0
SIZE = 70.0  # of the rail head
WHEEL_SIZE = 90.0
DEPTH = 100.0  # from which displacements of half-spaces along the arc count
GROWTH = 1.3  # of elements from the contact into the bodies

Where = Callable[[np.ndarray], np.ndarray]
"""Marks facets by their midpoints, (2, n) or (3, n)."""

# ------------------------------------------------------------------------ finite elements


@dataclass(frozen=True)
class Facets:
    """Midpoints (n, dim) and sizes (n,) of loaded facets, and their compliance (n, n): the mean
    inward displacement of each by a unit pressure on each.
    """

    midpoints: np.ndarray
    sizes: np.ndarray
    compliance: np.ndarray


def loaded_facets(mesh: Mesh, element: Element, held: Where, loaded: Where) -> Facets:
    """Facets of an elastic body that pressures may act on; it is clamped where it is held."""
    basis = Basis(mesh, ElementVector(element))
    border = mesh.boundary_facets()
    middle = mesh.p[:, mesh.facets[:, border]].mean(axis=1)
    facets = border[loaded(middle)]
    force, sizes = unit_pressures(FacetBasis(mesh, basis.elem, facets=facets))
    clamped = basis.get_dofs(border[held(middle)]).all()
    free = np.setdiff1d(np.arange(basis.N), clamped)
    stiffness = hooke.assemble(basis).tocsc()[free][:, free]
    options = {"SymmetricMode": True}
    factor = splu(stiffness, permc_spec="MMD_AT_PLUS_A", options=options)
    force = force[free]
    moved = factor.solve(force.toarray())
    work = force.T @ moved
    compliance = (work + work.T) / 2 / sizes[:, None]
    return Facets(middle[:, loaded(middle)].T, sizes, compliance)


@BilinearForm
def hooke(u, v, _):
    """Strain energy of plane strain, or of three dimensions."""
    strain = sym_grad(u)
    G = E / (2 * (1 + NU))
    lame = 2 * G * NU / (1 - 2 * NU)
    stress = lame * eye(trace(strain), len(strain)) + 2 * G * strain
    return ddot(stress, sym_grad(v))


def unit_pressures(basis: FacetBasis) -> tuple[coo_matrix, np.ndarray]:
    """Nodal forces of a unit pressure on each facet, by column, and the sizes of the facets."""
    facets = np.arange(basis.nelems)
    inward = -np.asarray(basis.normals)
    entries = [
        ((np.asarray(shape[0]) * inward).sum(axis=0) * basis.dx).sum(axis=1)
        for shape in basis.basis
    ]
    places = np.concatenate(basis.element_dofs), np.tile(facets, len(entries))
    shape = basis.N, facets.size
    force = coo_matrix((np.concatenate(entries), places), shape=shape).tocsr()
    return force, basis.dx.sum(axis=1)


def star_mesh(outline: np.ndarray, centre: tuple[float, float], first: float) -> MeshTri:
    """Triangles between rings of the same shape as an outline (n, 2), all of which is seen from a
    centre; the outermost ring is as thick as `first`.
    """
    reach = np.hypot(*(outline - centre).T).max()
    depths = [0.0, first]
    while depths[-1] < 0.8 * reach:
        depths.append(GROWTH * depths[-1] + first)
    scales = 1 - np.array(depths[:-1]) / reach
    rings = centre + scales[:, None, None] * (outline - centre)
    points = np.concatenate([rings.reshape(-1, 2), [centre]])
    n = len(outline)
    here = np.arange(n)
    after = (here + 1) % n
    triangles = []
    for ring in range(len(scales) - 1):
        outer = ring * n
        inner = outer + n
        triangles.append([outer + here, outer + after, inner + here])
        triangles.append([outer + after, inner + after, inner + here])
    last = (len(scales) - 1) * n
    triangles.append([last + here, last + after, np.full(n, len(points) - 1)])
    return MeshTri(np.ascontiguousarray(points.T), np.concatenate(triangles, axis=1))


# ------------------------------------------------------------------------ rail and wheel


def graded(start: tuple[float, float], end: tuple[float, float], first: float) -> np.ndarray:
    """Points of a straight side from its start, where elements are small, to before its end."""
    steps = [0.0, first]
    length = np.hypot(*np.subtract(end, start))
    while steps[-1] < length:
        steps.append(GROWTH * steps[-1] + first)
    share = np.array(steps[:-1]) / steps[-1]
    return np.asarray(start) + share[:, None] * np.subtract(end, start)


def arc(radius: float, angles: np.ndarray) -> np.ndarray:
    """Points of the arc about (-radius, -radius)."""
    return radius * np.stack([np.cos(angles) - 1, np.sin(angles) - 1], axis=1)


def block_mesh(lines: np.ndarray, first: float) -> MeshTri:
    """A flat block, 140 x 70, with nodes at `lines` about the middle of its top, right to left."""
    right = graded((lines[0], 0.0), (SIZE, 0.0), first)[:0:-1]
    left = graded((lines[-1], 0.0), (-SIZE, 0.0), first)[1:]
    top = np.concatenate([right[:, 0], lines, left[:, 0]])
    far = SIZE * np.array([[-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]])
    outline = np.concatenate([np.stack([top, 0 * top], axis=1), far])
    return star_mesh(outline, (0.0, -SIZE / 2), first)


def rail_mesh(angles: np.ndarray, first: float) -> MeshTri:
    """A quarter of a rail head with a rounded corner, 70 x 70."""
    side = graded((0.0, -RADIUS), (0.0, -SIZE), first)
    top = graded((-RADIUS, 0.0), (-SIZE, 0.0), first)
    far = -SIZE * np.array([[1.0, 0.0], [1.0, 0.5], [1.0, 1.0], [0.5, 1.0], [0.0, 1.0]])
    outline = np.concatenate([side[:0:-1], arc(RADIUS, angles), top[1:], far])
    return star_mesh(outline, (-SIZE / 2, -SIZE / 2), first)


def rail_held(p: np.ndarray) -> np.ndarray:
    """Marks the sides of the rail head that are far away."""
    return p.min(axis=0) < 1e-6 - SIZE


def wheel_mesh(radius: float, angles: np.ndarray, first: float) -> MeshTri:
    """Two legs that meet in a fillet, as tread and flange do."""
    side = graded((0.0, -radius), (0.0, -WHEEL_SIZE), first)
    top = graded((-radius, 0.0), (-WHEEL_SIZE, 0.0), first)
    far = np.array([[-1.0, 0.0], [-1.0, 1.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [1.0, -1.0]])
    bottom = np.array([[0.0, -WHEEL_SIZE]])
    outline = np.concatenate([side[:0:-1], arc(radius, angles), top[1:], WHEEL_SIZE * far, bottom])
    return star_mesh(outline[::-1], (WHEEL_SIZE / 2, WHEEL_SIZE / 2), first)


def wheel_held(p: np.ndarray) -> np.ndarray:
    """Marks the sides of the legs that are far away."""
    return p.max(axis=0) > WHEEL_SIZE - 1e-6


def on_arc(radius: float) -> Where:
    """Marks the chords of the arc."""

    def loaded(p: np.ndarray) -> np.ndarray:
        off = np.abs(np.hypot(p[0] + radius, p[1] + radius) - radius)
        return (off < 0.01) & (p[0] > -radius) & (p[1] > -radius)

    return loaded


def by_angle(facets: Facets, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Angles from the bisector, in order, and the compliance by forces per facet."""
    x, y = facets.midpoints.T + radius
    angle = np.arctan2(y, x) - np.pi / 4
    order = np.argsort(angle)
    return angle[order], (facets.compliance / facets.sizes)[np.ix_(order, order)]


# ------------------------------------------------------------------------ the three models

MODELS = ("finite elements", "plane", "conformal")


@dataclass(frozen=True)
class Corner:
    """Pressures of the rail's arc by each of the models."""

    s: np.ndarray
    pressures: dict[str, np.ndarray]

    def errors(self, model: str) -> tuple[float, float]:
        """Errors of a model in peak pressure and in the width of the contact, in per cent of finite
        elements.
        """
        peaks = [self.pressures[name].max() for name in (model, MODELS[0])]
        widths = [self.width(name) for name in (model, MODELS[0])]
        return 100 * (peaks[0] / peaks[1] - 1), 100 * (widths[0] / widths[1] - 1)

    def width(self, model: str) -> float:
        """Width of the contact: squares of the pressures, linear near the edges, come to zero."""
        squares = self.pressures[model] ** 2
        inside = np.flatnonzero(squares)
        edges = []
        for near in (inside[1:4], inside[-2:-5:-1]):
            slope, value = np.polyfit(self.s[near], squares[near], 1)
            edges.append(-value / slope)
        return float(edges[1] - edges[0])


def corner(half_width: float, step: float = 0.2) -> Corner:
    """The contact of the half width by Hertz, with elements of a length on the arc."""
    modulus = STEEL.combined_G / (1 - STEEL.combined_nu)
    curvature = 2 * HERTZ_PRESSURE / (modulus * half_width)
    wheel = 1 / (1 / RADIUS - curvature)
    force = np.pi / 2 * half_width * HERTZ_PRESSURE
    n = round(np.pi / 2 * RADIUS / step)
    lines = np.linspace(0.0, np.pi / 2, n + 1)
    element = ElementTriP2()
    on_rail = loaded_facets(rail_mesh(lines, step), element, rail_held, on_arc(RADIUS))
    on_wheel = loaded_facets(wheel_mesh(wheel, lines, step), element, wheel_held, on_arc(wheel))
    angle, rail = by_angle(on_rail, RADIUS)
    _, flange = by_angle(on_wheel, wheel)
    radial = distance_of_arcs(wheel, angle)
    grid = vc.Grid(nx=n, dx=RADIUS * np.pi / 2 / n, x0=-RADIUS * np.pi / 4)
    pressures = {
        "finite elements": by_elements(grid, angle, (rail + flange) * grid.dx, radial, force),
        "conformal": along_the_arc(grid, angle, radial, force),
        "plane": on_the_plane(grid, angle, wheel, force),
    }
    return Corner(grid.x, pressures)


def distance_of_arcs(wheel: float, angle: np.ndarray) -> np.ndarray:
    """Distance of the root of the wheel from the rail, along the normals of the rail."""
    offset = wheel - RADIUS
    return np.sqrt(wheel**2 - (offset * np.sin(angle)) ** 2) - offset * np.cos(angle) - RADIUS


def by_elements(
    grid: vc.Grid, angle: np.ndarray, compliance: np.ndarray, radial: np.ndarray, force: float
) -> np.ndarray:
    """The bodies approach along the bisector: what acts along it, q = p cos, does work on radial
    displacements divided by the cosine.
    """
    cosine = np.cos(angle)
    along = compliance / np.multiply.outer(cosine, cosine)
    scene = vc.Scene(
        bodies=vc.Elasticity.from_compliance(grid.x, (along + along.T) / 2),
        surface=vc.SampledDistance(radial / cosine),
        normal_force=force,
        grid=grid,
    )
    return vc.solve(scene).pressure[0] / cosine


def along_the_arc(grid: vc.Grid, angle: np.ndarray, radial: np.ndarray, force: float) -> np.ndarray:
    """Half-spaces on the arc, which falls away to both sides; they approach along the bisector, and
    by less along the normals beside it.
    """

    def solved(approach: float) -> vc.Solution:
        distance = radial + approach * (1 - np.cos(angle))
        surface = vc.SampledDistance(distance, reference_depth=DEPTH, inclination_x=-angle)
        scene = vc.Scene(bodies=STEEL, surface=surface, approach=approach, grid=grid)
        return vc.solve(scene)

    def excess(approach: float) -> float:
        return solved(approach).normal_force - force

    found = root_scalar(excess, x0=0.1, x1=0.15, rtol=1e-8)
    return solved(found.root).pressure[0]


def on_the_plane(grid: vc.Grid, angle: np.ndarray, wheel: float, force: float) -> np.ndarray:
    """Half-spaces below the tangent plane, with the distance along the bisector."""
    reach = 0.7 * RADIUS
    plane = vc.Grid(nx=grid.nx, dx=2 * reach / grid.nx, x0=-reach)
    x = plane.x
    distance = wheel - RADIUS + np.sqrt(RADIUS**2 - x**2) - np.sqrt(wheel**2 - x**2)
    scene = vc.Scene(
        bodies=STEEL,
        surface=vc.SampledDistance(-distance + wheel - RADIUS),
        normal_force=force,
        grid=plane,
    )
    pressure = vc.solve(scene).pressure[0]
    return np.interp(RADIUS * np.sin(angle), x, pressure)


def main(
    picture: str | None = None, half_widths: tuple[float, ...] = (2.0, 4.0, 6.0)
) -> dict[float, Corner]:
    """Errors of half-spaces for contacts of several widths."""
    corners = {each: corner(each) for each in half_widths}
    for half_width, found in corners.items():
        peak = found.pressures[MODELS[0]].max()
        words = [f"half width {half_width:g} mm: finite elements {peak:.0f} N/mm2"]
        for model in MODELS[1:]:
            pressure, width = found.errors(model)
            words.append(f"{model} {pressure:+.1f} % (width {width:+.0f} %)")
        print("; ".join(words))
    draw(corners, picture)
    return corners


def draw(corners: dict[float, Corner], picture: str | None) -> None:
    """The mesh of the rail about its corner, and pressures along the arc."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    mesh = rail_mesh(np.linspace(0.0, np.pi / 2, 52), 0.4)
    axes[0].triplot(*mesh.p, mesh.t.T, linewidth=0.4)
    axes[0].set(xlim=(-30, 3), ylim=(-30, 3), xlabel="y [mm]", ylabel="z [mm]", aspect="equal")
    for found in corners.values():
        for model, style in zip(MODELS, ("k-", "C1--", "C0:"), strict=True):
            (line,) = axes[1].plot(found.s, found.pressures[model], style)
            if found is next(iter(corners.values())):
                line.set_label(model)
    axes[1].set(xlabel="arc length from the bisector [mm]", ylabel="pressure [N/mm2]")
    legend_below(axes[1])
    if picture:
        figure.savefig(picture)
    else:
        plt.show()
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])
