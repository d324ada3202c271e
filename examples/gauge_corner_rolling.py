"""The error of half-spaces at the gauge corner of a rail in creep forces, by finite elements.

The wheel of the example `gauge_corner` rolls along the rail. Both bodies are the same all along it:
of fields that vary as exp(i k x) their sections are meshed in two dimensions, with all three
displacements, one factorisation per wave number k. The compliances, summed over wave numbers, are a
kernel by row, `vc.Elasticity(kernel=)`. Beside it half-spaces on the tangent plane, and half-spaces
along the arc (conformal), under the same force along the bisector of the corner. Left: pressures
across the contact. Right: creep forces along the rail. Finite elements are off at rest: pressures
shift convex and concave surfaces along x, and half-spaces know nothing of it.

Needs scikit-fem (the extra `docs`). Lengths in mm, forces in N. Run:
python examples/gauge_corner_rolling.py [picture.png]
"""

import sys
from collections.abc import Callable
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from gauge_corner import (
    HERTZ_PRESSURE,
    MODELS,
    NU,
    RADIUS,
    SIZE,
    STEEL,
    Where,
    block_mesh,
    distance_of_arcs,
    on_arc,
    rail_held,
    rail_mesh,
    wheel_held,
    wheel_mesh,
)
from scipy.interpolate import CubicSpline
from scipy.optimize import root_scalar
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementTriP2, ElementVector, FacetBasis, MeshTri

import varcontact as vc
from varcontact.plotting.style import legend_below

G = STEEL.combined_G
LAME = 2 * G * NU / (1 - 2 * NU)
ROLLING_RADIUS = 500.0
FRICTION = 0.3
REACH = 1.4  # of the grid, in semi-axes by Hertz
SMALL = 2e-4  # creepage along the rail
WITH_SPIN = 1e-3, 1.5e-3  # creepage along the rail, and spin about the bisector [1/mm]
LENGTH = 50.0  # wave numbers are dense below its inverse
WAVES_FINE = 3000  # wave numbers of the sums

Place = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Arc lengths of midpoints (2, n) across the rail, and angles of the rail's normals there, from z
towards y.
"""
Rolls = Callable[[float, float], vc.Solution]
"""A solution by creepage along the rail and spin."""

# ------------------------------------------------------------------------ sections by wave number

# Displacements (i w, v, u) exp(i k x) along x, y and z, with w, v, u real and in the section. The
# strains xx = -k w, xy = i (dw/dy + k v), xz = i (dw/dz + k u) and those of the section make an
# energy with real terms of the orders 1, k and k^2.


@BilinearForm
def of_order_0(u, v, _):
    one, other = u.grad, v.grad
    dilatations = (one[1, 0] + one[2, 1]) * (other[1, 0] + other[2, 1])
    normal = one[1, 0] * other[1, 0] + one[2, 1] * other[2, 1]
    shear = (one[1, 1] + one[2, 0]) * (other[1, 1] + other[2, 0])
    along = one[0, 0] * other[0, 0] + one[0, 1] * other[0, 1]
    return LAME * dilatations + G * (2 * normal + shear + along)


@BilinearForm
def of_order_1(u, v, _):
    one, other = u.grad, v.grad
    dilatations = u[0] * (other[1, 0] + other[2, 1]) + v[0] * (one[1, 0] + one[2, 1])
    along = u[1] * other[0, 0] + u[2] * other[0, 1] + v[1] * one[0, 0] + v[2] * one[0, 1]
    return G * along - LAME * dilatations


@BilinearForm
def of_order_2(u, v, _):
    return (LAME + 2 * G) * u[0] * v[0] + G * (u[1] * v[1] + u[2] * v[2])


@dataclass(frozen=True)
class Section:
    """The section of a body: clamped where it is held, and loaded on facets with their places."""

    mesh: MeshTri
    held: Where
    loaded: Where
    place: Place


def section_compliance(section: Section, wave_numbers: np.ndarray) -> np.ndarray:
    """Mean displacements (k, 3, n, 3, n) of each loaded facet by a unit force on each: along x,
    along the arc, and along the normal of the rail; those along x are a quarter of a wave ahead.
    """
    mesh = section.mesh
    basis = Basis(mesh, ElementVector(ElementTriP2(), 3))
    border = mesh.boundary_facets()
    middle = mesh.p[:, mesh.facets[:, border]].mean(axis=1)
    facets = border[section.loaded(middle)]
    arc_length, angle = section.place(middle[:, section.loaded(middle)])
    order = np.argsort(arc_length)
    force = unit_forces(FacetBasis(mesh, basis.elem, facets=facets[order]), angle[order])
    clamped = basis.get_dofs(border[section.held(middle)]).all()
    free = np.setdiff1d(np.arange(basis.N), clamped)
    force = force[free]
    orders = [
        form.assemble(basis).tocsc()[free][:, free] for form in (of_order_0, of_order_1, of_order_2)
    ]
    n = facets.size
    compliance = np.empty((wave_numbers.size, 3, n, 3, n))
    options = {"SymmetricMode": True}
    for place, k in enumerate(wave_numbers):
        stiffness = (orders[0] + k * orders[1] + k**2 * orders[2]).tocsc()
        factor = splu(stiffness, permc_spec="MMD_AT_PLUS_A", options=options)
        moved = force.T @ factor.solve(force.toarray())
        compliance[place] = ((moved + moved.T) / 2).reshape(3, n, 3, n)
    return compliance


def unit_forces(basis: FacetBasis, angle: np.ndarray) -> csc_matrix:
    """Nodal forces (N, 3 n) of a unit force, spread over each facet, along each direction."""
    n = basis.nelems
    directions = np.zeros((3, n, 3))
    directions[0, :, 0] = 1.0
    directions[1, :, 1:] = np.stack([np.cos(angle), -np.sin(angle)], axis=1)
    directions[2, :, 1:] = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    size = basis.dx.sum(axis=1)
    entries = []
    places = []
    for shape, dofs in zip(basis.basis, basis.element_dofs, strict=True):
        mean = (np.asarray(shape[0]) * basis.dx).sum(axis=2) / size
        for direction, along in enumerate(directions):
            entries.append(np.einsum("cn,nc->n", mean, along))
            places.append((dofs, direction * n + np.arange(n)))
    rows, columns = np.concatenate(places, axis=1)
    shape = basis.N, 3 * n
    return coo_matrix((np.concatenate(entries), (rows, columns)), shape=shape).tocsc()


def wave_numbers_to(largest: float, count: int) -> np.ndarray:
    """Wave numbers from 0, evenly spaced below 1/LENGTH and by their logarithms above."""
    return np.sinh(np.linspace(0.0, np.arcsinh(largest * LENGTH), count)) / LENGTH


def kernel_by_row(
    compliance: np.ndarray, wave_numbers: np.ndarray, dx: float, nx: int
) -> np.ndarray:
    """Influence numbers (3, 3, n, n, 2 nx - 1) of elements dx long, means of displacements along x,
    by forces per length across.
    """
    scale = np.arcsinh(wave_numbers * LENGTH)
    places, step = np.linspace(0.0, scale[-1], WAVES_FINE, retstep=True)
    k = np.sinh(places) / LENGTH
    weight = step * np.cosh(places) / LENGTH * dx * np.sinc(k * dx / (2 * np.pi)) ** 2 / np.pi
    weight[[0, -1]] /= 2
    # sums of the spline through the samples are sums of these, with weights of their own
    basis = CubicSpline(scale, np.eye(scale.size))(places) * weight[:, None]
    phase = np.multiply.outer(k, np.arange(1 - nx, nx) * dx)
    even = np.einsum("ks,kr->sr", basis, np.cos(phase))
    odd = np.einsum("ks,kr->sr", basis, np.sin(phase))
    kernel = np.einsum("kiajb,kr->ijabr", compliance, even)
    # a quarter of a wave between displacements along x and tractions across, and back
    for other in (1, 2):
        kernel[0, other] = -np.einsum("kab,kr->abr", compliance[:, 0, :, other], odd)
        kernel[other, 0] = np.einsum("kab,kr->abr", compliance[:, other, :, 0], odd)
    return kernel


# ------------------------------------------------------------------------ the three models


@dataclass(frozen=True)
class Problem:
    """A grid on the arc of the rail, the angles of its rows from the bisector, the radius of the
    wheel's root, the force along the bisector, and the approach by Hertz.
    """

    grid: vc.Grid
    angle: np.ndarray
    wheel: float
    force: float
    approach: float

    @property
    def distance(self) -> np.ndarray:
        """Distance (ny, nx) along the normals of the rail."""
        rolling = self.grid.x**2 / (2 * ROLLING_RADIUS)
        return distance_of_arcs(self.wheel, self.angle)[:, None] + rolling

    def motion(self, vx: float, spin: float) -> vc.Steady:
        """Creepage along the rail, and spin about the bisector, along the arc."""
        slip = np.empty((2, *self.grid.shape))
        slip[0] = vx - spin * RADIUS * np.sin(self.angle)[:, None]
        slip[1] = spin * np.cos(self.angle)[:, None] * self.grid.x
        return vc.Steady(rigid_slip=slip)


def problem(half_width: float, step: float, cells: int) -> Problem:
    """The contact whose half width across the rail is given by Hertz, as is its peak pressure."""

    def hertz(radius: float) -> tuple[float, float, float, float]:
        """Semi-axes, force and approach under the peak pressure."""
        surface = vc.Paraboloids(Rx=ROLLING_RADIUS, Ry=radius)
        unit = vc.Scene(bodies=STEEL, surface=surface, normal_force=1e4).hertz
        larger = HERTZ_PRESSURE / unit.peak_pressure
        return larger * unit.a, larger * unit.b, 1e4 * larger**3, larger**2 * unit.approach

    found = root_scalar(lambda radius: hertz(radius)[1] - half_width, bracket=(20.0, 2000.0))
    a, b, force, approach = hertz(found.root)
    rows = 2 * round(REACH * b / step)
    arc_step = RADIUS * np.pi / 2 / arc_elements(step)
    dx = 2 * REACH * a / cells
    grid = vc.Grid(nx=cells, ny=rows, dx=dx, dy=arc_step, x0=-REACH * a, y0=-rows * arc_step / 2)
    return Problem(grid, grid.y / RADIUS, 1 / (1 / RADIUS - 1 / found.root), force, approach)


def arc_elements(step: float) -> int:
    """An even number of elements on the arc, of about a length."""
    return 2 * round(np.pi / 4 * RADIUS / step)


def finite_elements(given: Problem, step: float, waves: int) -> vc.Elasticity:
    """Rail and wheel by their sections."""
    lines = np.linspace(0.0, np.pi / 2, arc_elements(step) + 1)
    grid = given.grid
    wave_numbers = wave_numbers_to(4 * np.pi / grid.dx, waves)
    reach = grid.rows * grid.dy / 2 / RADIUS
    wheel = given.wheel
    of_rail = rail_mesh(lines, step), rail_held, *arc_within(RADIUS, reach)
    of_wheel = wheel_mesh(wheel, lines, step), wheel_held, *arc_within(wheel, reach)
    sections = Section(*of_rail), Section(*of_wheel)
    compliance = sum(section_compliance(each, wave_numbers) for each in sections)
    kernel = kernel_by_row(compliance, wave_numbers, grid.dx, grid.nx + 1)
    return vc.Elasticity(kernel=kernel * grid.dy, sides=(grid.dx, grid.dy))


def arc_within(radius: float, reach: float) -> tuple[Where, Place]:
    """Marks the chords of an arc within angles from the bisector; and their places."""

    def place(p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        angle = np.arctan2(p[0] + radius, p[1] + radius)
        return radius * (angle - np.pi / 4), angle

    def loaded(p: np.ndarray) -> np.ndarray:
        return on_arc(radius)(p) & (np.abs(place(p)[0]) < radius * reach)

    return loaded, place


def on_the_arc(given: Problem, bodies: vc.Elasticity | vc.Bodies) -> Rolls:
    """Solutions under the force by creepage and spin: bodies that approach along the bisector,
    and by less along the normals beside it.
    """
    away = (1 - np.cos(given.angle))[:, None]
    inclination = None
    if isinstance(bodies, vc.Bodies):
        inclination = -given.angle

    def solved(approach: float, **motion: object) -> vc.Solution:
        distance = given.distance + approach * away
        surface = vc.SampledDistance(distance, inclination=inclination)
        scene = vc.Scene(
            bodies=bodies, surface=surface, approach=approach, grid=given.grid, **motion
        )
        return vc.solve(scene)

    def excess(approach: float) -> float:
        pressure = solved(approach).pressure
        along = np.cos(given.angle)[:, None] * pressure
        return float(along.sum()) * given.grid.area - given.force

    found = root_scalar(excess, x0=0.9 * given.approach, x1=given.approach, rtol=1e-6)

    def rolling(vx: float, spin: float) -> vc.Solution:
        return solved(found.root, friction=FRICTION, motion=given.motion(vx, spin))

    return rolling


def on_a_plane(given: Problem, bodies: vc.Elasticity | vc.Bodies, across: np.ndarray) -> Rolls:
    """The same of flat bodies at a distance by row."""
    grid = given.grid
    distance = across[:, None] + grid.x**2 / (2 * ROLLING_RADIUS)

    def solved(vx: float, spin: float) -> vc.Solution:
        scene = vc.Scene(
            bodies=bodies,
            surface=vc.SampledDistance(distance),
            normal_force=given.force,
            friction=FRICTION,
            motion=vc.Steady(vx=vx, spin=spin, spin_offset=0.0),
            grid=grid,
        )
        return vc.solve(scene)

    return solved


def on_the_tangent_plane(given: Problem) -> Rolls:
    """Half-spaces below the tangent plane, with the distance along the bisector."""
    y = given.grid.y
    of_rail = RADIUS - np.sqrt(RADIUS**2 - y**2)
    of_wheel = given.wheel - np.sqrt(given.wheel**2 - y**2)
    return on_a_plane(given, STEEL, of_rail - of_wheel)


@dataclass(frozen=True)
class Rolling:
    """Solutions of a model: at a small creepage backwards and forwards, and with spin."""

    backwards: vc.Solution
    forwards: vc.Solution
    with_spin: vc.Solution

    @classmethod
    def of(cls, solved: Rolls) -> "Rolling":
        """The solutions of a model."""
        return cls(solved(-SMALL, 0.0), solved(SMALL, 0.0), solved(*WITH_SPIN))

    @property
    def creep_force(self) -> float:
        """Force by the small creepage, less that at rest [N]."""
        return (self.backwards.Fx - self.forwards.Fx) / 2

    @property
    def free_creepage(self) -> float:
        """Creepage at which the wheel rolls without a force along the rail."""
        return SMALL * (self.backwards.Fx + self.forwards.Fx) / 2 / self.creep_force

    @property
    def measures(self) -> dict[str, float]:
        """What models are compared by."""
        contact = self.forwards
        return {
            "peak pressure": contact.pressure.max(),
            "area": np.count_nonzero(contact.pressure) * contact.grid.area,
            "Fx by creepage": self.creep_force,
            "Fy by spin": self.with_spin.Fy,
        }

    def errors(self, exact: "Rolling") -> dict[str, float]:
        """Errors in per cent of those of finite elements."""
        pairs = zip(self.measures.items(), exact.measures.values(), strict=True)
        return {name: 100 * (value / other - 1) for (name, value), other in pairs}


def rolling(
    half_width: float, step: float = 0.4, cells: int = 26, waves: int = 14
) -> dict[str, Rolling]:
    """The models at a half width across the rail by Hertz, with elements of about a length across,
    so many along, and so many wave numbers.
    """
    given = problem(half_width, step, cells)
    models = (
        on_the_arc(given, finite_elements(given, step, waves)),
        on_the_tangent_plane(given),
        on_the_arc(given, STEEL),
    )
    return {name: Rolling.of(solved) for name, solved in zip(MODELS, models, strict=True)}


def flat_block(grid: vc.Grid, waves: int) -> np.ndarray:
    """Influence numbers by row of a flat block below a grid."""
    reach = grid.rows * grid.dy / 2
    section = Section(
        mesh=block_mesh(np.linspace(reach, -reach, grid.rows + 1), grid.dy),
        held=lambda p: p[1] < 1e-6 - SIZE,
        loaded=lambda p: (p[1] > -1e-9) & (np.abs(p[0]) < reach),
        place=lambda p: (p[0], 0 * p[0]),
    )
    wave_numbers = wave_numbers_to(4 * np.pi / grid.dx, waves)
    compliance = section_compliance(section, wave_numbers)
    return kernel_by_row(compliance, wave_numbers, grid.dx, grid.nx + 1) * grid.dy


def flat_blocks(
    half_width: float, step: float = 0.4, cells: int = 26, waves: int = 14
) -> dict[str, float]:
    """Errors of the finite elements themselves: of two flat blocks in the contact of the same half
    width, in per cent of half-spaces.
    """
    given = problem(half_width, step, cells)
    grid = given.grid
    kernel = flat_block(grid, waves)
    # the upper block is the mirror image of the lower one
    flip = np.array([1.0, 1.0, -1.0])
    both = kernel * (1 + np.multiply.outer(flip, flip)[..., None, None, None])
    blocks = vc.Elasticity(kernel=both, sides=(grid.dx, grid.dy))
    across = grid.y**2 / 2 * (1 / RADIUS - 1 / given.wheel)
    exact = Rolling.of(on_a_plane(given, STEEL, across))
    return Rolling.of(on_a_plane(given, blocks, across)).errors(exact)


def main(
    picture: str | None = None, half_widths: tuple[float, ...] = (2.0, 3.0, 4.0), **sizes: float
) -> dict[float, dict[str, Rolling]]:
    """Errors of half-spaces for contacts of several widths."""
    found = {each: rolling(each, **sizes) for each in half_widths}
    for half_width, models in found.items():
        exact = models[MODELS[0]]
        print(f"half width {half_width:g} mm: free creepage {exact.free_creepage:.1e}")
        for model in MODELS[1:]:
            errors = models[model].errors(exact)
            words = [f"{name} {error:+.1f} %" for name, error in errors.items()]
            words.append(f"free creepage {models[model].free_creepage:.1e}")
            print(f"  {model}: " + ", ".join(words))
    draw(next(iter(found.values())), picture)
    return found


def draw(models: dict[str, Rolling], picture: str | None) -> None:
    """Pressures across the contact, and creep forces about rest."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 4.5), layout="constrained")
    for name, style in zip(MODELS, ("k-", "C1--", "C0:"), strict=True):
        model = models[name]
        contact = model.forwards
        axes[0].plot(contact.grid.y, contact.pressure.max(axis=1), style, label=name)
        forces = model.backwards.Fx, model.forwards.Fx
        axes[1].plot((-1e4 * SMALL, 1e4 * SMALL), np.array(forces) / 1e3, style)
    axes[0].set(xlabel="y [mm]", ylabel="largest pressure of a row [N/mm2]")
    axes[1].set(xlabel="creepage along the rail [1e-4]", ylabel="Fx [kN]")
    axes[1].axhline(0.0, color="0.7", linewidth=0.8)
    legend_below(axes[0])
    if picture:
        figure.savefig(picture)
    else:
        plt.show()
    plt.close(figure)


if __name__ == "__main__":
    main(*sys.argv[1:2])
