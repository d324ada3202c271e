"""Sizing the potential contact, and refusing one that does not hold the contact."""

from dataclasses import asdict, replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.discrete.contact_grid import PotentialContact, within
from varcontact.solvers.interface import SolveStats
from varcontact.solving import on_grid
from varcontact.solving.contact_solver import ContactSolver
from varcontact.solving.selection import select

BODIES = vc.Bodies(G=1.0, nu=0.3)


def paraboloid(x, y, Rx=1.0, Ry=2.0):
    return (x**2 / (2 * Rx))[None, :] + (y**2 / (2 * Ry))[:, None]


def test_a_grid_is_so_many_elements_across_the_ellipse():
    scene = vc.Scene(
        bodies=BODIES, surface=vc.Paraboloids(1.0, 2.0), normal_force=0.1, grid=vc.Grid(24, 24)
    )
    sol = vc.solve(scene)
    hertz = scene.hertz
    assert sol.grid.shape == (26, 26)
    assert sol.grid.sides == pytest.approx((hertz.a / 12, hertz.b / 12))
    assert sol.grid.box[0] == pytest.approx(-hertz.a * 13 / 12)


def test_elements_at_the_ends_of_the_samples_are_within():
    """Three by three elements whose centres are the samples; a wider grid is cut to these."""
    places = np.array([-1.0, 0.0, 1.0])
    surface = vc.SampledDistance(paraboloid(places, places), places, places)
    grid = vc.Grid(nx=5, ny=5, dx=1.0, dy=1.0, x0=-2.5, y0=-2.5)
    assert within(grid, surface) == vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5)


@pytest.mark.parametrize("grid", [vc.Grid(nx=24, ny=24), vc.Grid(nx=20, ny=16)])
def test_samples_with_coordinates_find_their_contact(grid):
    """A paraboloid given by samples, off the middle of a wide field: the same contact as in closed
    form.
    """
    x, y = np.linspace(-3.0, 2.0, 61), np.linspace(-2.5, 2.5, 71)
    surface = vc.SampledDistance(paraboloid(x - 0.5, y + 0.2), x, y)
    scene = vc.Scene(bodies=BODIES, surface=surface, normal_force=0.1, grid=grid)
    sol = vc.solve(scene)
    hertz = vc.Scene(bodies=BODIES, surface=vc.Paraboloids(1.0, 2.0), normal_force=0.1).hertz
    centre = [
        np.sum(c * sol.pressure) / sol.pressure.sum() for c in np.meshgrid(sol.grid.x, sol.grid.y)
    ]
    assert centre == pytest.approx([0.5, -0.2], abs=1e-3)
    assert sol.approach == pytest.approx(hertz.approach, rel=2e-3)
    assert sol.pressure.max() == pytest.approx(hertz.peak_pressure, rel=0.02)
    across = np.flatnonzero((sol.pressure > 0).any(axis=0)).size
    assert across == pytest.approx(grid.nx, abs=1)


@pytest.mark.parametrize("centre", [(0.1, 0.33), (-0.26, 0.2), (0.41, -0.07)])
def test_a_mirrored_surface_has_the_mirrored_grid(centre):
    """Also where samples lie on the borders of the elements by which the contact is looked for."""
    x = np.linspace(-2.0, 2.0, 81)
    h = paraboloid(x - centre[0], x - centre[1], Ry=0.7) + 0.05 * np.outer(x, x)
    here, along, across = (
        vc.solve(
            vc.Scene(bodies=BODIES, surface=vc.SampledDistance(samples, x, x), normal_force=0.05)
        )
        for samples in (h, h[:, ::-1], h[::-1])
    )
    left, right, bottom, top = here.grid.box
    assert along.grid.box == pytest.approx((-right, -left, bottom, top), abs=1e-12)
    assert across.grid.box == pytest.approx((left, right, -top, -bottom), abs=1e-12)
    np.testing.assert_allclose(
        along.pressure[:, ::-1], here.pressure, atol=1e-9 * here.pressure.max()
    )
    np.testing.assert_allclose(
        across.pressure[::-1], here.pressure, atol=1e-9 * here.pressure.max()
    )


@pytest.mark.parametrize("creepage", [0.3, -0.9])
def test_grid_grows_where_tractions_move_the_contact(creepage):
    """A soft cylinder dragged over a rigid one has contact beyond the grid about Hertz's."""
    surface, bodies = vc.Cylinders(R=1.0, reference_depth=10.0), vc.Bodies(G=(1.0, np.inf), nu=0.0)
    soft = make_scene(surface, 1.0, vc.Steady(vx=creepage), vc.Grid(nx=30), 1.0, bodies)
    sol = vc.solve(soft)
    ahead = np.sign(creepage) * np.array(sol.grid.box[:2])
    assert ahead.max() > 1.2 * soft.hertz.a * 32 / 30, "beyond the grid about Hertz's contact"
    assert (sol.pressure > 0).sum() == pytest.approx(30, abs=1)
    dx = sol.grid.sides[0]
    wide = vc.Grid(nx=sol.grid.nx + 40, dx=dx, x0=sol.grid.box[0] - 20 * dx)
    known = vc.solve(replace(soft, grid=wide))
    np.testing.assert_allclose(
        sol.pressure, known.pressure[:, 20:-20], atol=1e-6 * known.pressure.max()
    )
    np.testing.assert_allclose(
        sol.traction, known.traction[:, :, 20:-20], atol=1e-6 * known.pressure.max()
    )


@pytest.mark.parametrize("normal", ["hertz", "clarabel"])
@pytest.mark.parametrize(
    "lattice",
    [
        {"nx": 8, "ny": 8, "dx": 0.05, "dy": 0.05, "x0": -0.2, "y0": -0.2},
        {"nx": 8, "ny": 16, "dx": 0.1, "dy": 0.1, "x0": 0.0, "y0": -0.8},
        {"nx": 8, "ny": 8, "dx": 0.1, "dy": 0.1, "x0": 5.0, "y0": 5.0},
    ],
)
def test_explicit_grid_that_does_not_hold_the_contact(lattice, normal):
    scene = vc.Scene(
        bodies=BODIES, surface=vc.Paraboloids(1.0, 2.0), normal_force=0.3, grid=vc.Grid(**lattice)
    )
    refused(lambda: vc.solve(scene, normal=normal), "grid", match="does not contain the contact")


def test_samples_on_the_grid_that_end_in_the_contact():
    grid = vc.Grid(nx=10, ny=10, dx=0.04, dy=0.04, x0=-0.2, y0=-0.2)
    scene = vc.Scene(
        bodies=BODIES,
        surface=vc.SampledDistance(paraboloid(grid.x, grid.y)),
        normal_force=0.3,
        grid=grid,
    )
    refused(lambda: vc.solve(scene), match="does not contain the contact")


def test_samples_that_end_in_the_contact():
    x = np.linspace(-0.2, 0.2, 21)
    for grid in ("auto", vc.Grid(nx=10, ny=10)):
        scene = vc.Scene(
            bodies=BODIES,
            surface=vc.SampledDistance(paraboloid(x, x), x, x),
            normal_force=0.3,
            grid=grid,
        )
        refused(lambda scene=scene: vc.solve(scene), "surface", match="samples")


def with_bump(at, R):
    """A wide paraboloid and a bump near the edge of the samples, which are 24 wide."""
    x = np.linspace(-12.0, 12.0, 121)
    bump = 0.01 + paraboloid(x - at[0], x - at[1], R, R)
    return vc.Scene(
        bodies=vc.Bodies(G=82e3, nu=0.28),
        surface=vc.SampledDistance(np.minimum(paraboloid(x, x, 300.0, 200.0), bump), x, x),
        normal_force=80e3,
    )


@pytest.mark.parametrize("cells", [8, 12, 24])
def test_two_patches_that_end_within_the_samples(cells):
    """Contacts over 85 to 93 % of the samples, and coarse grids with centres beyond these."""
    for at, R in (((10.0, 10.0), 2.0), ((9.5, 9.5), 5.0), ((9.0, 9.0), 20.0)):
        sol = vc.solve(replace(with_bump(at, R), grid=vc.Grid(nx=cells, ny=cells)))
        far = (sol.grid.x > 7) & (sol.grid.y > 7)[:, None]
        assert sol.pressure[far].any()


def test_two_patches_one_of_which_the_samples_cut():
    for centre, cells in ((11.0, 16), (11.0, 24), (11.5, 8), (11.5, 12)):
        scene = replace(with_bump((centre, 9.5), 20.0), grid=vc.Grid(nx=cells, ny=cells))
        with pytest.raises(vc.SceneError, match="the contact reaches the edge of the samples"):
            vc.solve(scene)


@pytest.mark.parametrize("cells", [6, 8, 16])
@pytest.mark.parametrize("edge", ["centres", "touched"])
def test_samples_that_end_near_the_contact(cells, edge):
    """Refused where they end an element before the contact does, solved where they hold it."""
    scene = vc.Scene(bodies=BODIES, surface=vc.Paraboloids(1.0, 2.0), normal_force=0.1)

    def cut(end):
        x = end * scene.hertz.a * np.linspace(-1.0, 1.0, 61)
        y = 2 * scene.hertz.b * np.linspace(-1.0, 1.0, 61)
        surface = vc.SampledDistance(paraboloid(x, y), x, y)
        return replace(scene, surface=surface, grid=vc.Grid(nx=cells, ny=cells, edge=edge))

    for end in (1.0, 1.02, 1.04, 1.1):
        assert vc.solve(cut(end)).converged
    refused(lambda: vc.solve(cut(1 - 2 / cells)), match="the edge of the samples")


def test_the_refusal_of_a_grid_states_the_extent_of_the_whole_contact():
    scene = vc.Scene(bodies=BODIES, surface=vc.Paraboloids(1.0, 2.0), normal_force=0.3)
    a, b = scene.hertz.a, scene.hertz.b
    for normal in ("hertz", "newton"):
        cut = replace(
            scene, grid=vc.Grid(nx=24, ny=30, dx=a / 12, dy=b / 12, x0=-1.5 * a, y0=-1.25 * b)
        )
        with pytest.raises(vc.SceneError, match="does not contain the contact") as caught:
            vc.solve(cut, normal=normal)
        extent = str(caught.value).split("extends to (")[1].split(")")[0]
        sides = [float(side) for side in extent.split(",")]
        assert sides == pytest.approx([-a, 7 / 12 * a, -b, b], rel=0.09), normal


def test_flat_punch_needs_its_edge():
    """A body that ends says so by a large distance around it."""
    grid = vc.Grid(nx=10, ny=10, dx=0.1, dy=0.1, x0=-0.5, y0=-0.5)
    h = np.full((10, 10), 100.0)
    h[1:-1, 1:-1] = 0.0
    sol = vc.solve(
        vc.Scene(bodies=BODIES, surface=vc.SampledDistance(h), normal_force=0.1, grid=grid)
    )
    assert sol.elements["contact"] == 64
    assert sol.pressure[1, 1] > sol.pressure[4, 4], "pressure peaks at the corners of a punch"


@pytest.mark.parametrize("normal", ["hertz", "clarabel"])
def test_grid_too_coarse(normal):
    coarse = vc.Grid(nx=2, ny=2, dx=2.0, dy=2.0, x0=-2.0, y0=-2.0)
    scene = vc.Scene(bodies=BODIES, surface=vc.Paraboloids(1.0, 2.0), approach=0.01, grid=coarse)
    refused(lambda: vc.solve(scene, normal=normal), "grid", match="too coarse")


def test_samples_beyond_reach_of_the_approach():
    x = np.linspace(-1.0, 1.0, 21)
    with pytest.raises(vc.NoContact):
        vc.Scene(
            bodies=BODIES, surface=vc.SampledDistance(paraboloid(x, x) + 0.5, x, x), approach=0.4
        )


def test_grid_outside_the_samples():
    x = np.linspace(-1.0, 1.0, 21)
    grid = vc.Grid(nx=4, ny=4, dx=1.0, dy=1.0, x0=-2.0, y0=-2.0)
    scene = vc.Scene(
        bodies=BODIES,
        surface=vc.SampledDistance(paraboloid(x, x), x, x),
        normal_force=0.1,
        grid=grid,
    )
    refused(lambda: vc.solve(scene), match="within the samples")


@pytest.mark.parametrize(
    ("centre", "force", "samples", "cells"),
    [
        ((0.01, 0.0), 1e-6, 201, (16, 16)),
        ((0.3, 0.0), 1e-6, 81, (15, 17)),
        ((0.37, 0.11), 1e-9, 41, (16, 16)),
    ],
)
def test_small_contact_is_found_and_spread_over_the_cells(centre, force, samples, cells):
    """A contact of 1/120 to 1/1250 of the samples' width, off the middle: so many elements across
    as were asked.
    """
    x = np.linspace(-1.0, 1.0, samples)
    surface = vc.SampledDistance(paraboloid(x - centre[0], x - centre[1], 1, 1), x, x)
    sol = vc.solve(
        vc.Scene(
            bodies=BODIES,
            surface=surface,
            normal_force=force,
            grid=vc.Grid(nx=cells[0], ny=cells[1]),
        )
    )
    hertz = vc.Scene(bodies=BODIES, surface=vc.Paraboloids(1, 1), normal_force=force).hertz
    contact = sol.pressure > 0
    assert contact.any(axis=0).sum() == pytest.approx(cells[0], abs=1)
    assert contact.any(axis=1).sum() == pytest.approx(cells[1], abs=1)
    assert sol.areas["contact"] == pytest.approx(np.pi * hertz.a**2, rel=0.1)
    assert sol.approach == pytest.approx(hertz.approach, rel=4e-3)


def test_sharp_summit_between_the_centres_of_the_first_look_is_found():
    """A spike of a few samples on a wide bowl: the first contact, though no centre of 24 x 24
    elements meets it.
    """
    x = np.linspace(-1.0, 1.0, 401)
    spike = 200.0 * (((x - 0.2) ** 2)[None, :] + ((x + 0.4) ** 2)[:, None]) - 0.02
    surface = vc.SampledDistance(np.minimum(paraboloid(x, x, 1, 1), spike), x, x)
    sol = vc.solve(
        vc.Scene(bodies=BODIES, surface=surface, normal_force=1e-7, grid=vc.Grid(nx=12, ny=12))
    )
    left, right, bottom, top = sol.grid.box
    assert left < 0.2 < right < 0.25
    assert bottom < -0.4 < top < -0.35
    assert sol.approach < 0


def test_body_with_a_cliff_around_it_touches_everywhere_and_nowhere_else():
    """A flat square of half side 0.5 that ends in a cliff: no contact beyond it, and all of it in
    contact.
    """
    x = np.linspace(-1.0, 1.0, 41)
    inside = (np.abs(x) < 0.51)[None, :] & (np.abs(x) < 0.51)[:, None]
    surface = vc.SampledDistance(np.where(inside, 0.0, 1.0), x, x)
    scene = vc.Scene(bodies=BODIES, surface=surface, normal_force=0.01, grid=vc.Grid(nx=16, ny=16))
    sol = vc.solve(scene)
    contact = sol.pressure > 0
    X, Y = np.meshgrid(sol.grid.x, sol.grid.y)
    beyond = (np.abs(X) > 0.55) | (np.abs(Y) > 0.55)
    assert not contact[beyond].any()
    assert contact[(np.abs(X) < 0.45) & (np.abs(Y) < 0.45)].all()
    assert sol.areas["contact"] == pytest.approx(1.0, abs=0.15)


def test_contact_between_the_centres_of_an_explicit_grid_is_refused():
    """A needle beside the contact, missed by all centres: the overlap there is no solution."""
    x = np.linspace(-1.0, 1.0, 401)
    bowl = paraboloid(x - 0.25, x - 0.05, 1, 1)
    needle = paraboloid(x + 0.3, x, 1e-3, 1e-3) - 0.004
    surface = vc.SampledDistance(np.minimum(bowl, needle), x, x)
    grid = vc.Grid(nx=10, ny=10, dx=0.1, dy=0.1, x0=-0.5, y0=-0.5)
    scene = vc.Scene(bodies=BODIES, surface=surface, normal_force=0.01, grid=grid)
    refused(lambda: vc.solve(scene), "grid", match=r"too coarse: the contact at \(-0.3,")


@pytest.mark.parametrize(
    "grid",
    [
        vc.Grid(nx=10**6, ny=10**6),
        vc.Grid(nx=10**6, ny=10**6, dx=1e-5, dy=1e-5, x0=-5.0, y0=-5.0),
        vc.Grid(nx=2, ny=2, margin=10**6),
    ],
)
def test_grids_beyond_memory_are_refused_before_anything_is_allocated(grid):
    scene = make_scene(vc.Ellipse(1, 1), 1.0, vc.Steady(vx=0.1), grid)
    refused(lambda: vc.solve(scene), match="a grid of this size", error=vc.TooLarge)
    with pytest.raises(vc.TooLarge, match="a grid of this size"):
        vc.certify(scene, np.zeros((2, 1, 1)))


@pytest.mark.parametrize(
    "motion", [vc.Steady(Fx=-0.15, vy=0.05, spin=0.1), vc.Shift(ux=0.1, Fy=0.1)]
)
def test_tractions_begun_from_those_on_another_grid_are_the_same_and_take_fewer_steps(motion):
    scene = make_scene(vc.Ellipse(1.0, 0.7), 1.0, motion, vc.Grid(32, 32), bodies=BODIES)
    coarse = vc.solve(replace(scene, grid=vc.Grid(16, 16)))
    steps = ContactSolver(select(scene), 1e-10, True, SolveStats())
    alone, near = (
        on_grid.solve_contact(scene, steps, initial_guess=each)[1] for each in (None, coarse)
    )
    assert near.traction == pytest.approx(alone.traction, abs=1e-8 * np.abs(alone.traction).max())
    assert near.rigid == pytest.approx(alone.rigid, rel=1e-8)
    assert near.iterations["tangential"] < alone.iterations["tangential"]


# ---------------------------------------------------------------------- Decided once, in the plan


@pytest.mark.parametrize(
    ("changes", "placed"),
    [
        ({}, True),
        ({"grid": vc.Grid(nx=8, ny=8, dx=0.4, dy=0.4, x0=-1.6, y0=-1.6)}, True),
        ({"bodies": vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))}, True),
        ({"motion": vc.Transient(steps=3, vx=1e-3)}, True),
    ],
)
def test_the_plan_has_the_grid_of_the_solution(rolling, changes, placed):
    """Where it is known before: the same lattice, to rounding, as a history has the radii of an
    ellipse.
    """
    scene = rolling(**{"grid": vc.Grid(nx=9, ny=7), **changes})
    potential = vc.plan(scene).grid
    assert (potential.placed is not None) == placed
    assert potential.form.nx == scene.grid.nx
    answer = vc.solve(scene)
    if not scene.coupled:
        placed_grid = asdict(potential.placed)
        for name, value in asdict(answer.grid).items():
            if isinstance(value, float):
                value = pytest.approx(value, rel=1e-15, abs=0)
            assert placed_grid[name] == value, name


def test_a_scene_is_asked_for_its_grid_once(rolling, monkeypatch):
    """By the plan; search, enlargement and solution take it from there."""
    asked, of = [], PotentialContact.of
    monkeypatch.setattr(PotentialContact, "of", lambda scene: asked.append(scene) or of(scene))
    places = np.linspace(-2, 2, 41)
    samples = (places**2 + places[:, None] ** 2) / 2
    surface = vc.SampledDistance(samples, x=places, y=places)
    scene = rolling(surface=surface, grid=vc.Grid(nx=8, ny=8))
    vc.solve(scene)
    assert len(asked) == 1 and asked[0] is scene


def test_files_have_plans_without_grids(rolling, tmp_path):
    """A solution has its grid; plans are the same before and after."""
    sol = vc.solve(rolling(grid=vc.Grid(nx=8, ny=8)))
    assert "grid" not in sol.plan.summary()
    sol.save(tmp_path / "sol.nc")
    loaded = vc.load(tmp_path / "sol.nc")
    assert loaded.plan == sol.plan and loaded.plan.grid is None


@pytest.mark.long
def test_a_default_accuracy_that_is_missed_is_a_warning():
    """A bump so narrow that grids by default are too coarse for it."""
    scene = replace(with_bump((10.0, 10.0), 2.0), friction=0.3, motion=vc.Steady(vx=1e-3))
    sol = vc.solve(scene)
    assert sol.error_estimate.largest > 0.01
    assert any("give accuracy=0.01" in words for words in sol.warnings)
    asked = vc.solve(scene, accuracy=0.01)
    assert asked.error_estimate.largest <= 0.01
    assert not any("give accuracy" in words for words in asked.warnings)
