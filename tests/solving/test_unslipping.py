"""Fields of which nothing slips: moments of known tractions, what parts have of them, and their slip."""

import math
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.discretisation import discretise
from varcontact.elasticity.ellipsoidal import rooted_gradients, sloped_gradients
from varcontact.reference import line_contact
from varcontact.reference.no_slip_ellipse import no_slip_ellipse
from varcontact.solving.defect_correction.moments import Spread, over_ellipse
from varcontact.solving.defect_correction.parts import Parts
from varcontact.solving.defect_correction.slopes import Around, Slopes
from varcontact.solving.defect_correction.unslipping import Still, Unslipping

A, B = 1.3, 0.8
POSED = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28),
    surface=vc.Ellipse(a=A, b=B),
    normal_force=1.0,
    friction=math.inf,
    motion=vc.Steady(vx=1e-3),
)


def still(cells=16):
    """Parts of the elements of an ellipse, and the grid."""
    grid = vc.Grid(nx=cells, ny=cells).spread((-A, A, -B, B))
    disc = discretise(replace(POSED, grid=grid), grid)
    return Still(Parts(disc, (2, 2), POSED.hertz.on_elements(grid) / disc.scales.pressure))


@pytest.mark.parametrize(("a", "b"), [(1.3, 0.6), (0.5, 1.0)])
def test_moments(a, b):
    """Of the whole ellipse in closed form, and within elements those of their points."""
    grid = vc.Grid(nx=22, ny=18, margin=1).spread((-a, a, -b, b))
    weight, over, times = over_ellipse(grid, a, b)
    area, whole = grid.area, np.pi * a * b
    x, y = np.meshgrid(grid.x, grid.y)
    dx, dy = grid.sides

    def first(mean, along, across):
        return [np.sum(mean * x + dx * along) * area, np.sum(mean * y + dy * across) * area]

    forces = over.mean.sum(axis=(1, 2)) * area, times.mean.sum(axis=(1, 2)) * area
    np.testing.assert_allclose(forces, [[2 * whole, 0, 0], [2 * whole / 3, 0, 0]], rtol=1e-6, atol=1e-12)
    ratio = np.array([a**2, b**2]) * whole
    for found, part in ((over, 2 / 3), (times, 2 / 15)):
        moments = np.array([first(*each) for each in zip(found.mean, found.along, found.across, strict=True)])
        np.testing.assert_allclose(moments, np.vstack([np.zeros(2), np.diag(ratio * part)]), rtol=1e-5, atol=1e-12)
    assert np.sum(weight.mean * weight.x) * area == pytest.approx(-2 / 3 * a * whole, rel=1e-5)
    lines = [np.linspace(lines[9], lines[10], 401) for lines in grid.lines]
    px, py = np.meshgrid(*((each[1:] + each[:-1]) / 2 for each in lines))
    half = a * np.sqrt(1 - (py / b) ** 2)
    points = np.sqrt((half - px) / (half + px))
    centre = np.mean(points * px) / points.mean()
    assert weight.mean[9, 9] == pytest.approx(points.mean(), rel=1e-5)
    assert weight.x[9, 9] == pytest.approx(centre, rel=1e-5)
    assert weight.along[9, 9] == pytest.approx(np.mean(points * (px - centre) ** 2) / dx, rel=1e-4)


@pytest.mark.parametrize("cells", [16, 33])
def test_gradients_where_the_edge_cuts(cells):
    """Of a linear function, at places beside the lines of the others: along rows alone they are off by one and more."""
    found = still(cells)
    weight, known = found.weight, found.weight.mean > 0
    values = (2 * weight.x - 3 * weight.y)[None]
    along, across = (each[0] for each in Around.at(weight.x, weight.y, known).gradients(values * known))
    whole = found.parts.disc.hertz.covered(*found.parts.grid.lines) > 1 - 1e-9
    np.testing.assert_allclose([along[whole], across[whole]], [[2], [-3]] * np.ones(whole.sum()), atol=1e-6)
    np.testing.assert_allclose([along[known], across[known]], [[2], [-3]] * np.ones(known.sum()), atol=0.05)
    assert np.abs(Slopes.at(weight.x, known).of(values * known)[0] - 2)[known].max() > 1


def test_placed_tractions_keep_force_and_moments():
    rng, grid = np.random.default_rng(1), vc.Grid(nx=7, ny=6, dx=0.3, dy=0.2, x0=0.0, y0=0.0)
    mean, along, across = rng.normal(size=(3, 6, 7))
    found = Spread(mean, along, across).placed
    assert found.sum() == pytest.approx(mean.sum())
    assert np.sum(found * grid.x) == pytest.approx(np.sum(mean * grid.x + 0.3 * along))
    assert np.sum(found.T * grid.y) == pytest.approx(np.sum(mean.T * grid.y + 0.2 * across.T))


def test_known_tractions_have_their_derivative():
    """With what parts miss, x over the root has a uniform derivative, and y times the root one of second degree."""
    found = still()
    parts, (over, times), inside = found.parts, found.integrals[1:], found.weight.mean > 0
    (a, b), side, nothing = found.parts.axes, parts.lattice.sides[0], np.zeros(parts.lattice.shape)
    x, y = np.meshgrid(parts.lattice.x, parts.lattice.y)
    bent = sloped_gradients(x, y, a, b, nu=0.28)[1, :, 0]
    for known, tractions, k, gradient in (
        (found.known[0], over, 1, rooted_gradients(a, b, nu=0.28)[1, :, :1, None]),
        (found.known[1], times, 2, bent),
    ):
        traction = np.array([tractions.mean[k], nothing])
        made = parts.derivative.apply(np.array([tractions.placed[k], nothing])) + known.lacking(traction)
        off = np.abs(made / -side - gradient)[:, inside & (x**2 + y**2 * (a / b) ** 2 < 0.8 * a**2)].max()
        assert off < 0.01 * np.abs(gradient).max()


def test_a_cubic_factor_is_met():
    """Between the elements, beyond the outermost, and along rows in proportion to their length: it is reconstructed."""
    found = still()
    parts, weight = found.parts, found.weight
    grid, (a, b) = parts.disc.lattice, found.parts.axes
    x, y = np.meshgrid(grid.x, grid.y)
    bound = np.full(grid.shape, 1e9)

    def factor(x, y):
        along = x / (a * np.sqrt(np.maximum(1 - (y / b) ** 2, 1e-12)))
        return 2 - along * (1 + 0.5 * y / b) + 0.7 * y / b - 0.3 * along**3 + along**2 * (y / b) ** 3

    elements = np.where(parts.elements > 0, parts.weights[0], 1.0)
    field = Unslipping(parts, bound, found, np.array([elements, elements]))
    traction = factor(x, y) * elements * (parts.elements > 0)
    made = field.field(np.array([traction, -2 * traction]))
    wanted = factor(weight.x, weight.y) * weight.mean
    np.testing.assert_allclose(made, [wanted, -2 * wanted], atol=1e-9 * wanted.max())


def test_forces_given():
    """The creepages of forces that are given, by the inverse of the coefficients."""
    root, C = math.sqrt(A * B), no_slip_ellipse(A / B, 0.28) * A * B
    Fx, Fy, spin = 2e-3, -1e-3, 4e-4
    vx, vy = -Fx / C[0, 0], -(Fy + C[1, 2] * spin * root) / C[1, 1]
    motion = vc.Steady(Fx=Fx, Fy=Fy, spin=spin)
    sol = vc.solve(replace(POSED, motion=motion, grid=vc.Grid(nx=24, ny=24)), refine="continuum", certify=None)
    np.testing.assert_allclose(sol.creepage[:2], [vx, vy], atol=1e-4 * abs(vx))
    np.testing.assert_allclose(sol.force, [Fx, Fy], rtol=1e-5)
    assert sol.moment == pytest.approx(-(C[2, 1] * vy + C[2, 2] * spin * root) * root, rel=3e-4)
    assert [sol.error_estimate.values[name] for name in ("vx", "vy")] == list(sol.creepage[:2])
    error, size = math.dist(sol.creepage[:2], (vx, vy)), math.hypot(vx, vy)
    assert error / size < sol.error_estimate.errors["vx"] == sol.error_estimate.errors["vy"] < 1e-2
    assert f"vy to {sol.error_estimate.errors['vy']:.1e} of the creepage" in sol.report()


@pytest.mark.parametrize("dq", [0.5, 2.0])
def test_other_steps_have_the_same_continuum(dq):
    """Whatever the coarse slip is a difference over."""
    exact = no_slip_ellipse(A / B, 0.28)[0, 0] * A * B * 1e-3
    motion = vc.Steady(vx=1e-3, dq=dq * 2 * A / 16)
    sol = vc.solve(replace(POSED, motion=motion, grid=vc.Grid(nx=16, ny=16)), refine="continuum", certify=None)
    assert -sol.force[0] == pytest.approx(exact, rel=2e-4)


def test_mirror_and_units():
    """Mirrored in the x axis Fy and Mz turn over; in other units the numbers are the same."""
    motion, grid = vc.Steady(vx=1e-3, vy=-5e-4, spin=8e-4), vc.Grid(nx=12, ny=12)
    one, mirrored = (
        vc.solve(replace(POSED, motion=each, grid=grid), refine="continuum", certify=None)
        for each in (motion, vc.Steady(vx=1e-3, vy=5e-4, spin=-8e-4))
    )
    loads = [np.array([*each.force, each.moment]) for each in (one, mirrored)]
    np.testing.assert_allclose(loads[1], loads[0] * [1, -1, -1], rtol=1e-5)
    length, modulus = 1e3, 2e9
    scaled = replace(
        POSED,
        bodies=vc.Bodies(G=modulus, nu=0.28),
        surface=vc.Ellipse(a=A * length, b=B * length),
        normal_force=modulus * length**2,
        motion=replace(motion, spin=8e-4 / length),
        grid=grid,
    )
    other = vc.solve(scaled, refine="continuum", certify=None)
    found = np.array([*other.force, other.moment / length]) / (modulus * length**2)
    np.testing.assert_allclose(found, loads[0], rtol=1e-5)


def rolling_cylinders(motion, grid):
    """Line contact with a = 0.01 in which nothing slips."""
    bodies = vc.Bodies(G=1.0, nu=0.25)
    return vc.Scene(
        bodies=bodies,
        surface=vc.Cylinders(R=2.0),
        normal_force=line_contact(2.0, bodies, a=0.01).force,
        friction=math.inf,
        motion=motion,
        grid=grid,
    )


def test_force_given_in_line_contact():
    sol = vc.solve(rolling_cylinders(vc.Steady(Fx=-1e-6), vc.Grid(nx=16)), refine="continuum", certify=None)
    assert sol.creepage[0] == pytest.approx(1e-6 * 1.5 / (math.pi * 0.01), rel=3e-5)


@pytest.mark.parametrize("y0", [-1.26, -1.205, -1.2, -1.19])
def test_lattices_that_are_moved(y0):
    """Where the outermost row has two elements or one, their factor was continued: 13 per cent of the force."""
    exact = -no_slip_ellipse(1.0, 0.28) @ [0.01, -0.02, 0.02]
    posed = replace(POSED, surface=vc.Ellipse(a=1.0, b=1.0), motion=vc.Steady(vx=0.01, vy=-0.02, spin=0.02))
    for x0 in (-1.26, -1.29, -1.33):
        grid = vc.Grid(nx=20, ny=20, dx=0.14, dy=0.14, x0=x0, y0=y0)
        sol = vc.solve(replace(posed, grid=grid), refine="continuum", certify=None)
        errors = abs(np.array([*sol.force, sol.moment]) - exact)
        assert (errors < 3e-3 * np.hypot(*exact[:2])).all()
        assert (errors < sol.refinement.estimate).all()


def test_elements_beyond_the_contact_change_nothing():
    """With none, moments at the grid's border were lost: 1 per cent of the force, and all of the estimate."""
    exact = -1e-4 / 1.5 * math.pi * 0.01
    for margin in (0, 1, 3):
        posed = rolling_cylinders(vc.Steady(vx=1e-4), vc.Grid(nx=16, margin=margin))
        sol = vc.solve(posed, refine="continuum", certify=None)
        assert sol.force[0] == pytest.approx(exact, rel=5e-5)
        assert sol.refinement.estimate[0] < 1e-4 * abs(exact)


def test_nothing_moves():
    """Without creepage there is no traction, and no error."""
    sol = vc.solve(
        replace(POSED, motion=vc.Steady(vx=0.0), grid=vc.Grid(nx=10, ny=10)), refine="continuum", certify=None
    )
    np.testing.assert_array_equal(sol.force, 0)
    np.testing.assert_array_equal(sol.refinement.estimate, 0)
