"""Displacements that are prescribed beside the contact: what they do, against closed forms, second
contacts and loads; where they are refused.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import in_units, make_scene
from varcontact.discrete.discretisation import discretise
from varcontact.elasticity.held import holding_loads

LIKE = vc.Bodies(G=1.0, nu=0.3)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.4))
COATED = vc.Layered([vc.Layer(h=0.02, G=2.0, nu=0.3)], base=(1.0, 0.3))
BALL = vc.Paraboloids(Rx=1.0, Ry=1.0)
CYLINDER = vc.Cylinders(R=1.0, reference_depth=50.0)
a = 0.0808
GRID = vc.Grid(nx=10, ny=10)
SAME_SIDES = vc.Grid(10, 10, dx=a / 4, dy=a / 4, x0=-1.25 * a, y0=-1.25 * a)
"""Elements as large as the parts of `beside`."""
MOTIONS = [vc.Shift(ux=1e-3), vc.Steady(vx=1e-3, vy=5e-4)]


def ball(motion=None, held=None, bodies=LIKE, grid=GRID, **more):
    """A ball of radius 1 under a force that gives it a contact of the radius a."""
    return make_scene(BALL, 1e-3, motion, grid, bodies=bodies, displacements=held, **more)


def beside(x=2.0, y=0.0, side=1.0, n=4, **held):
    """A held square at a place, in radii of the contact."""
    square = {"x": (a * (x - side / 2), a * (x + side / 2)), "nx": n}
    square["y"] = (a * (y - side / 2), a * (y + side / 2))
    return vc.SurfaceDisplacement(**square, **held)


# ----------------------------------------------------------------------- closed forms


def test_a_pressed_strip_is_a_flat_punch():
    """Its force by displacement, and its pressure P/(pi sqrt(a^2 - x^2)); errors fall with n."""
    compliance = (1 - LIKE.combined_nu) / (np.pi * LIKE.combined_G)
    half = 0.5
    force = 1e-3 / (2 * compliance * np.log(2 * 50 / half))
    errors = []
    for n in (20, 40):
        punch = vc.SurfaceDisplacement(x=(4.5, 5.5), normal=1e-3, nx=n)
        scene = make_scene(CYLINDER, 1e-2, bodies=LIKE, displacements=punch)
        load = holding_loads(scene, 1.0)[0]
        errors.append(load.force[2] / force - 1)
    assert errors[1] == pytest.approx(errors[0] / 2, rel=0.01)
    assert abs(2 * errors[1] - errors[0]) < 1e-4
    inner = slice(n // 4, -n // 4)
    exact = load.force[2] / (np.pi * np.sqrt(half**2 - (load.grid.x - 5) ** 2))
    assert load.parts[2, 0, inner] == pytest.approx(exact[inner], rel=0.02)


def test_a_pressed_strip_raises_the_surface_beside_it():
    """Displacement u(x) = u0 - 2 (1 - nu) P/(pi G) arcosh(x/a) beside a flat punch; the contact
    has hardly any force of its own.
    """
    scene = make_scene(CYLINDER, 1e-7, grid=vc.Grid(nx=40), bodies=LIKE)
    bare = vc.solve(scene, normal="norm")
    punch = vc.SurfaceDisplacement(x=(2.5, 3.5), normal=1e-3, nx=80)
    near = vc.solve(replace(scene, displacements=punch))
    force = near.loads_beside[0].force[2]
    by_punch = 1e-3 - 2 * (1 - 0.3) / np.pi * force * np.arccosh(3 / 0.5)
    assert near.approach - bare.approach == pytest.approx(by_punch, rel=2e-3)


def test_a_pressed_square_is_a_square_punch():
    """Its stiffness from the capacity of a square plate, .3667892 of its side."""
    exact = np.pi * 0.3667892 * LIKE.combined_G / (1 - 0.3)
    forces = []
    for n in (8, 16):
        punch = vc.SurfaceDisplacement(x=(1.5, 2.5), y=(-0.5, 0.5), normal=1e-3, nx=n)
        load = holding_loads(make_scene(BALL, 1e-3, bodies=LIKE, displacements=punch), 1.0)[0]
        forces.append(load.force[2] / 1e-3)
    assert 2 * forces[1] - forces[0] == pytest.approx(exact, rel=2e-3)


# ----------------------------------------------------------------------- second contacts


def two_contacts(bodies, motion, friction):
    """A ball beside a block with a flat face, on one grid; the grid and the elements of each."""
    grid = vc.Grid(nx=24, ny=10, dx=0.025, dy=0.025, x0=-0.125, y0=-0.125)
    x = grid.x[None, :]
    y = grid.y[:, None]
    h = np.where(x < 0.2, (x**2 + y**2) / 2, 10.0)
    h[1:9, 15:23] = -2e-3
    coefficients = np.where(x < 0.2, 0.3, friction) + 0 * y
    both = vc.solve(
        vc.Scene(
            bodies=bodies,
            surface=vc.SampledDistance(h),
            approach=4e-3,
            friction=coefficients,
            motion=motion,
            grid=grid,
        )
    )
    assert (both.pressure[1:9, 15:23] > 0).all()
    alone = replace(
        both.scene,
        surface=vc.SampledDistance(h[:, :10]),
        friction=0.3,
        grid=grid.window(0, 10, 0, 10),
    )
    return both, alone, grid.window(15, 23, 1, 9)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_smooth_block_is_a_second_contact(bodies, motion):
    both, alone, block = two_contacts(bodies, motion, 0.0)
    left, right, bottom, top = block.box
    held = vc.SurfaceDisplacement(x=(left, right), y=(bottom, top), normal=6e-3, nx=8)
    first = vc.solve(replace(alone, displacements=held))
    size = both.pressure.max()
    assert first.pressure == pytest.approx(both.pressure[:, :10], abs=1e-9 * size)
    assert first.traction == pytest.approx(both.traction[:, :, :10], abs=1e-9 * size)
    assert first.distance == pytest.approx(both.distance[:, :10], abs=1e-11)
    holding = first.loads_beside[0].parts[2]
    assert holding == pytest.approx(both.pressure[1:9, 15:23], abs=1e-9 * size)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
def test_a_glued_block_is_a_second_contact_that_sticks(bodies):
    both, alone, block = two_contacts(bodies, vc.Shift(ux=1e-3, uy=5e-4), 50.0)
    assert (both.state[1:9, 15:23] == 1).all()
    left, right, bottom, top = block.box
    shifted = (-1e-3, -5e-4)
    held = vc.SurfaceDisplacement(
        x=(left, right), y=(bottom, top), normal=6e-3, tangential=shifted, nx=8
    )
    first = vc.solve(replace(alone, displacements=held))
    size = both.pressure.max()
    assert first.pressure == pytest.approx(both.pressure[:, :10], abs=1e-8 * size)
    assert first.traction == pytest.approx(both.traction[:, :, :10], abs=1e-8 * size)
    holding = first.loads_beside[0].parts
    assert holding[:2] == pytest.approx(both.traction[:, 1:9, 15:23], abs=1e-7 * size)


# ----------------------------------------------------------------------- loads, fields, energy


@pytest.mark.long
@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_loads_that_hold_it_do_the_same(bodies, motion):
    # parts as large as the elements: for others centres and means differ in the second order
    held = [
        beside(body="lower", normal=2e-4, tangential=(1e-4, 0.0)),
        beside(-2.0, 0.5, normal=0.0),
        beside(0.0, -2.5, body="upper", tangential=(0.0, 0.0)),
    ]
    sol = vc.solve(ball(motion, held, bodies, SAME_SIDES))
    loads = replace(sol.scene, displacements=None, loads=sol.loads_beside, grid=sol.grid)
    again = vc.solve(loads)
    size = sol.pressure.max()
    assert again.pressure == pytest.approx(sol.pressure, abs=1e-9 * size)
    assert again.traction == pytest.approx(sol.traction, abs=1e-8 * size)


def test_the_surface_has_the_prescribed_displacements():
    """Displacements of the elastic field below, at the centres of the parts."""
    held = beside(body="lower", normal=2e-4, tangential=(1e-4, -5e-5), n=3)
    sol = vc.solve(ball(vc.Shift(ux=1e-3), held, UNLIKE))
    x, y = np.meshgrid(held.grid.x, held.grid.y)
    points = np.stack([x, y, 0 * x])
    lower = vc.stress(sol, points, "lower").displacement
    for i, value in enumerate((-1e-4, 5e-5, -2e-4)):
        assert lower[i] == pytest.approx(value, abs=1e-6)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE, COATED])
def test_influence_numbers_meet_bettis_theorem_and_take_work(bodies):
    held = [beside(body="lower", normal=0.0, tangential=(0.0, 0.0)), beside(-2.0, normal=0.0)]
    grid = vc.Grid(5, 4, dx=0.04, dy=0.05, x0=-0.1, y0=-0.1)
    scene = ball(vc.Steady(vx=1e-3), held, bodies, grid)
    every = np.arange(grid.size)
    matrix = discretise(scene, grid).operators.every.dense(every)
    assert matrix == pytest.approx(matrix.T, abs=1e-13 * matrix.max())
    assert np.linalg.eigvalsh(matrix)[0] > 0
    # what is held gives way less
    free = discretise(replace(scene, displacements=None), grid)
    softer = free.operators.every.dense(every) - matrix
    assert np.linalg.eigvalsh(softer)[0] > -1e-12


def test_parts_held_alone_couple_both_directions():
    """nu = 0, where flat influence numbers do not: the same as the loads that hold them."""
    held = beside(2.0, 1.0, body="lower", normal=1e-4, tangential=(0.0, 0.0))
    sol = vc.solve(ball(vc.Steady(vx=1e-3), held, vc.Bodies(G=1.0, nu=0.0), SAME_SIDES))
    loads = replace(sol.scene, displacements=None, loads=sol.loads_beside)
    again = vc.solve(loads)
    assert np.abs(sol.traction[1]).max() > 1e-3 * sol.pressure.max()
    assert again.traction == pytest.approx(sol.traction, abs=1e-8 * sol.pressure.max())


def test_friction_dissipates_the_power():
    for body in ("both", "upper"):
        held = beside(normal=0.0, tangential=(1e-5, 0.0), body=body)
        sol = vc.solve(ball(vc.Steady(vx=1e-3, vy=5e-4), held))
        assert sol.friction_work == pytest.approx(sol.power, rel=1e-9)
    assert sol.certificate.residual < 1e-9


def test_a_part_far_away_changes_nothing():
    far = beside(x=1e5, normal=0.0, tangential=(0.0, 0.0), body="lower")
    bare = vc.solve(ball(vc.Steady(vx=1e-3)), normal="norm")
    sol = vc.solve(ball(vc.Steady(vx=1e-3), far, grid=bare.grid))
    assert sol.Fx == pytest.approx(bare.Fx, rel=1e-5)


def test_one_body_of_a_rigid_pair_is_both():
    bodies = vc.Bodies(G=(1.0, np.inf), nu=0.3)
    of = [
        vc.solve(ball(vc.Steady(vx=1e-3), beside(normal=1e-4, body=body), bodies))
        for body in ("both", "upper")
    ]
    assert of[0].traction == pytest.approx(of[1].traction, abs=1e-9 * of[0].pressure.max())


def test_the_same_in_other_units():
    held = beside(body="upper", normal=2e-4, tangential=(1e-4, 0.0))
    scene = ball(vc.Steady(vx=1e-3), held, grid=vc.Grid(8, 8, dx=0.02, dy=0.02, x0=-0.08, y0=-0.08))
    sol = vc.solve(scene)
    other = vc.solve(in_units(scene, 1e3, 1e-6))
    assert other.pressure * 1e6 == pytest.approx(sol.pressure, rel=1e-9, abs=1e-12)
    assert other.Fx == pytest.approx(sol.Fx, rel=1e-9)


def test_a_mirrored_scene_has_the_mirrored_answer():
    held = [beside(0.0, y, normal=1e-4, tangential=(5e-5, np.sign(y) * 1e-5)) for y in (-2, 2)]
    sol = vc.solve(ball(vc.Steady(vx=1e-3), held))
    assert sol.pressure == pytest.approx(sol.pressure[::-1], abs=1e-12)
    mirrored = sol.traction[:, ::-1] * np.array([1, -1])[:, None, None]
    assert sol.traction == pytest.approx(mirrored, abs=1e-10)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
def test_a_history_goes_on_from_steady_rolling(bodies):
    held = beside(normal=1e-4, tangential=(1e-4, 0.0), body="lower")
    grid = vc.Grid(nx=10, ny=10, dx=0.022, dy=0.022, x0=-0.11, y0=-0.11)
    scene = ball(vc.Steady(vx=2e-3, vy=1e-3), held, bodies, grid)
    start = vc.solve(scene)
    going_on = vc.Transient(steps=2, vx=2e-3, vy=1e-3, start=start)
    history = vc.solve(replace(scene, motion=going_on))
    assert history[-1].traction == pytest.approx(start.traction, abs=1e-8 * start.pressure.max())


# ----------------------------------------------------------------------- grids and files


@pytest.mark.long
def test_grids_of_any_choice():
    held = beside(normal=1e-4, tangential=(0.0, 0.0))
    motion = vc.Steady(vx=1e-3)
    fine = vc.solve(ball(motion, held, grid=vc.Grid(nx=30, ny=30)))
    chosen = vc.solve(ball(motion, held, grid="auto"), accuracy=0.05)
    assert chosen.Fx == pytest.approx(fine.Fx, rel=0.02)
    assert chosen.approach == pytest.approx(fine.approach, rel=2e-3)
    # on elements that the contact touches: the same as the loads that hold it
    touched = vc.solve(ball(motion, held, grid=vc.Grid(nx=14, ny=14, edge="touched")))
    scene = replace(touched.scene, displacements=None, loads=touched.loads_beside)
    again = vc.solve(replace(scene, grid=touched.grid))
    assert touched.Fx == pytest.approx(again.Fx, rel=2e-3)


@pytest.mark.long
def test_files(tmp_path):
    held = [
        beside(normal=np.full((3, 2), 1e-4), n=None, body="upper"),
        beside(-2.0, tangential=(0.0, 1e-5)),
    ]
    scene = ball(vc.Steady(vx=1e-3), held)
    scene.save(tmp_path / "scene.toml")
    again = vc.read_scene(tmp_path / "scene.toml")[0]
    assert again.to_toml() == scene.to_toml()
    assert again.displacements[0].grid.shape == (3, 2)
    sol = vc.solve(scene)
    sol.save(tmp_path / "sol.nc")
    loaded = vc.load(tmp_path / "sol.nc")
    judged = vc.certify(replace(loaded.scene, grid=loaded.grid), loaded.traction, loaded.pressure)
    assert judged.residual < 1e-9
    assert "loads beside" in sol.report()


# ----------------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"displacements": "clamp"}, "displacements"),
        ({"displacements": beside(0.5, normal=0.0)}, "displacements[0]"),
        ({"displacements": [beside(normal=0.0), beside(2.5, normal=0.0)]}, "displacements[1]"),
        ({"surface": vc.Ellipse(a, a), "displacements": beside(normal=0.0)}, "surface"),
        (
            {"displacements": vc.SurfaceDisplacement(x=(1.0, 2.0), normal=0.0)},
            "displacements[0].y",
        ),
        (
            {
                "bodies": vc.Bodies(G=(1.0, np.inf), nu=0.3),
                "displacements": beside(normal=0.0, body="lower"),
            },
            "displacements[0].body",
        ),
        (
            {"bodies": vc.Winkler(h=0.1, E=1.0, G=1.0), "displacements": beside(normal=0.0)},
            "displacements",
        ),
        (
            {
                "surface": vc.Cylinders(R=1.0),
                "grid": vc.Grid(nx=20),
                "displacements": vc.SurfaceDisplacement(x=(1.0, 2.0), normal=0.0),
            },
            "surface.reference_depth",
        ),
        (
            {
                "surface": CYLINDER,
                "grid": vc.Grid(nx=20, tractions="linear"),
                "displacements": vc.SurfaceDisplacement(x=(1.0, 2.0), normal=0.0),
            },
            "grid.tractions",
        ),
        (
            {"displacements": beside(normal=0.0), "grid": vc.Grid(nx=60, ny=60)},
            "grid",
        ),
    ],
)
def test_refused_by_name(change, named):
    with pytest.raises(vc.SceneError) as refused:
        vc.solve(replace(ball(), **change))
    assert refused.value.field.startswith(named)


@pytest.mark.parametrize(
    "asked",
    [
        lambda sol: sol.gradient("Fx", by=("vx",)),
        lambda sol: sol.frequency_response([1.0]),
        lambda sol: vc.shakedown(sol, 1.0, body="lower"),
    ],
)
def test_what_is_not_known_beside_held_parts(asked):
    grid = vc.Grid(8, 8, dx=0.022, dy=0.022, x0=-0.088, y0=-0.088)
    sol = vc.solve(ball(vc.Steady(vx=1e-3), beside(normal=0.0), grid=grid))
    with pytest.raises(vc.SceneError, match="displacements"):
        asked(sol)


def test_an_overlap_with_the_potential_contact_is_known_before_any_work():
    grid = vc.Grid(nx=9, ny=9, dx=0.05, dy=0.05, x0=-0.225, y0=-0.225)
    with pytest.raises(vc.SceneError, match=r"displacements\[0\] overlaps the potential contact"):
        vc.plan(ball(held=beside(normal=0.0), grid=grid))


@pytest.mark.parametrize(
    ("entries", "named"),
    [
        ({"x": (2.0, 1.0)}, "displacements.x"),
        ({"normal": np.nan}, "displacements.normal"),
        ({"normal": None}, "displacements.normal"),
        ({"tangential": (1.0, 2.0, 3.0)}, "displacements.tangential"),
        ({"normal": np.ones((2, 3)), "tangential": np.ones((2, 3, 2))}, "displacements"),
        ({"normal": np.ones((2, 3)), "nx": 4}, "displacements"),
        ({"y": None, "normal": np.ones((2, 3))}, "displacements"),
        ({"y": None, "ny": 3}, "displacements.ny"),
        ({"nx": 0}, "displacements.nx"),
        ({"body": "rail"}, "displacements.body"),
    ],
)
def test_displacements_check_themselves(entries, named):
    with pytest.raises(vc.SceneError) as refused:
        vc.SurfaceDisplacement(**{"x": (1.0, 2.0), "y": (0.0, 1.0), "normal": 0.0, **entries})
    assert refused.value.field.startswith(named)
