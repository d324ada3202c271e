"""Loads beside the contact: what they do to distance and slip, and where they are refused."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene
from varcontact.elasticity.beside import loads_beside

LIKE = vc.Bodies(G=1.0, nu=0.3)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.4))
COATED = vc.Layered([vc.Layer(h=0.02, G=2.0, nu=0.3)], base=(1.0, 0.3))
BALL = vc.Paraboloids(Rx=1.0, Ry=1.0)
a = 0.0808
GRID = vc.Grid(nx=16, ny=16)
MOTIONS = [None, vc.Shift(ux=1e-3), vc.Steady(vx=1e-3)]


def ball(motion=None, loads=None, bodies=LIKE, grid=GRID, **more):
    """A ball of radius 1 under a force that gives it a contact of the radius a."""
    return make_scene(BALL, 1e-3, motion, grid, bodies=bodies, loads=loads, **more)


def beside(x=2.0, y=0.0, side=1.0, **tractions):
    """A load on a square at a place, in radii of the contact."""
    square = {"x": (a * (x - side / 2), a * (x + side / 2))}
    square["y"] = (a * (y - side / 2), a * (y + side / 2))
    return vc.SurfaceLoad(**square, **tractions)


# ----------------------------------------------------------------------- their displacements


def test_far_away_it_is_boussinesqs_point_load():
    load = beside(x=1000.0, pressure=1.0)
    bare = vc.solve(ball(), normal="norm")
    raised = vc.solve(ball(loads=load)).approach - bare.approach
    exact = (1 - LIKE.combined_nu) * load.force[2] / (np.pi * LIKE.combined_G * 1000 * a)
    assert raised == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize("along", [0, 1])
def test_far_away_it_is_cerrutis_point_load(along):
    """Tractions without a resultant stay zero, and the body goes along."""
    load = beside(x=1000.0, traction=np.eye(2)[along])
    sol = vc.solve(ball(vc.Shift(Fx=0.0, Fy=0.0), load))
    compliance = (1.0, 1 - LIKE.combined_nu)[along]
    exact = compliance * load.force[along] / (np.pi * LIKE.combined_G * 1000 * a)
    assert -sol.creepage[along] == pytest.approx(exact, rel=1e-5)


def test_a_line_load_far_away():
    surface = vc.Cylinders(R=1.0, reference_depth=50.0)
    scene = make_scene(surface, 1e-2, None, vc.Grid(nx=40), bodies=LIKE)
    load = vc.SurfaceLoad(x=(19.9, 20.1), pressure=0.1)
    bare = vc.solve(scene, normal="norm")
    raised = vc.solve(replace(scene, loads=load)).approach - bare.approach
    exact = 2 * (1 - LIKE.combined_nu) / (np.pi * LIKE.combined_G) * 0.02 * np.log(50 / 20)
    assert raised == pytest.approx(exact, rel=1e-4)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE, COATED])
def test_bettis_reciprocity(bodies):
    """Tractions of the contact do the same work on what a load displaces as it does on theirs."""
    sol = vc.solve(ball(vc.Steady(vx=1e-3, vy=5e-4), bodies=bodies, grid=vc.Grid(nx=8, ny=8)))
    grid = sol.grid
    element = grid.window(15, 16, 3, 4)
    left, right, bottom, top = element.box
    load = vc.SurfaceLoad(x=(left, right), y=(bottom, top), pressure=2.0, traction=(1.0, -0.5))
    left, right, bottom, top = grid.box
    contact = vc.SurfaceLoad(
        x=(left, right), y=(bottom, top), pressure=sol.pressure, traction=sol.traction
    )

    def work(given, of):
        loads = loads_beside(replace(sol.scene, loads=given), length=0.1)
        displacement = [*loads.shift(of.grid, ((0.0, 1.0),)), loads.distance(of.grid)]
        return np.sum(of.parts * displacement)

    assert work(load, contact) == pytest.approx(work(contact, load), rel=1e-11)


@pytest.mark.long
@pytest.mark.parametrize("bodies", [LIKE, UNLIKE, COATED])
def test_a_load_on_both_is_one_on_each(bodies):
    given = {"pressure": np.full((2, 3), 0.01), "traction": (0.01, 0.005)}
    steady = vc.Steady(vx=1e-3)
    grid = vc.Grid(nx=8, ny=8)
    together = vc.solve(ball(steady, beside(**given), bodies, grid))
    each = [beside(**given, body=name) for name in ("upper", "lower")]
    apart = vc.solve(ball(steady, each, bodies, grid))
    assert apart.traction == pytest.approx(together.traction, abs=1e-9 * together.pressure.max())
    assert apart.pressure == pytest.approx(together.pressure, abs=1e-9 * together.pressure.max())


# ----------------------------------------------------------------------- contacts


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
@pytest.mark.parametrize("motion", [vc.Shift(ux=1e-3), vc.Steady(vx=2e-3, vy=1e-3)])
def test_each_of_two_contacts_is_the_load_of_the_other(bodies, motion):
    """Two balls side by side, solved as one contact; then the first one beside the tractions of the
    second.
    """
    grid = vc.Grid(nx=30, ny=12, dx=0.02, dy=0.02, x0=-0.12, y0=-0.12)
    x = grid.x[None, :]
    y = grid.y[:, None]
    h = np.minimum(x**2, (x - 0.3) ** 2 + 1e-3) / 2 + y**2 / 2
    surface = vc.SampledDistance(h)
    both = vc.solve(
        vc.Scene(
            bodies=bodies, surface=surface, approach=4e-3, friction=0.3, motion=motion, grid=grid
        )
    )
    assert both.pressure[:, 18:].any()
    right = grid.window(18, 30, 0, 12).box
    second = vc.SurfaceLoad(
        x=right[:2],
        y=right[2:],
        pressure=both.pressure[:, 18:],
        traction=both.traction[:, :, 18:],
    )
    first = vc.solve(
        replace(
            both.scene,
            surface=vc.SampledDistance(h[:, :12]),
            grid=grid.window(0, 12, 0, 12),
            loads=second,
        )
    )
    size = both.pressure.max()
    assert first.pressure == pytest.approx(both.pressure[:, :12], abs=1e-9 * size)
    assert first.traction == pytest.approx(both.traction[:, :, :12], abs=1e-8 * size)
    assert first.slip == pytest.approx(both.slip[:, :, :12], abs=1e-8 * np.abs(both.slip).max())
    assert first.distance == pytest.approx(both.distance[:, :12], abs=1e-11)


def test_the_stress_below_is_that_of_both():
    grid = vc.Grid(nx=8, ny=8, dx=0.02, dy=0.02, x0=-0.08, y0=-0.08)
    load = beside(pressure=0.1, traction=(0.05, 0.02))
    sol = vc.solve(ball(vc.Steady(vx=1e-3), load, UNLIKE, grid))
    points = np.array([[0.01, 2 * a], [0.02, 0.01], [-0.03, -0.02]])
    alone = vc.stress(replace(sol, scene=replace(sol.scene, loads=None)), points, "lower")
    at = vc.stress(sol, points, "lower")
    # below the load the pressure is nearly there
    assert at.stress[2, 2, 1] < 0.8 * -0.1 < 0.2 * alone.stress[2, 2, 1] < 0
    below = vc.stress_below(sol, [0.03], "lower")
    again = vc.stress(sol, below.points, "lower")
    assert below.stress == pytest.approx(again.stress, abs=1e-9)


@pytest.mark.parametrize("motion", MOTIONS)
def test_zero_loads_change_nothing(motion):
    bare = vc.solve(ball(motion))
    loaded = vc.solve(ball(motion, beside(pressure=np.zeros((2, 2)))))
    for name in ("pressure", "traction", "slip", "distance"):
        assert np.array_equal(getattr(bare, name), getattr(loaded, name))


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_normal_force_is_that_of_the_contact(motion):
    load = beside(pressure=0.02)
    sol = vc.solve(ball(motion, load))
    assert sol.normal_force == pytest.approx(1e-3, rel=1e-12)
    assert sol.certificate.normal_residual < 1e-9
    # the load's displacements fall off: the contact moves away from it
    assert (sol.pressure * sol.grid.x).sum() < -1e-3 * a * sol.pressure.sum()
    assert sol.approach > vc.solve(ball(motion)).approach


def test_a_symmetric_scene_stays_symmetric():
    pair = [beside(0.0, y, pressure=0.02, traction=(0.01, np.sign(y) * 0.005)) for y in (-2, 2)]
    sol = vc.solve(ball(vc.Steady(vx=1e-3), pair))
    assert sol.pressure == pytest.approx(sol.pressure[::-1], abs=1e-13)
    mirrored = sol.traction[:, ::-1] * np.array([1, -1])[:, None, None]
    assert sol.traction == pytest.approx(mirrored, abs=1e-11)


def test_superposition_without_slip():
    """Where nothing slips, tractions are a linear function of the loads."""
    loads = [beside(2.0, 0.5, traction=(0.02, 0.0)), beside(-1.0, -2.0, traction=(0.01, -0.03))]
    motion = vc.Steady()
    one, other, both = (
        vc.solve(ball(motion, given, friction=float("inf"))).traction
        for given in (loads[:1], loads[1:], loads)
    )
    assert both == pytest.approx(one + other, abs=1e-10 * np.abs(both).max())


def test_power_is_lost_by_friction():
    load = beside(pressure=0.02, traction=(0.02, 0.01))
    sol = vc.solve(ball(vc.Steady(vx=1e-3, vy=5e-4), load))
    assert sol.friction_work == pytest.approx(sol.power, rel=1e-9)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE])
def test_a_history_goes_on_from_steady_rolling(bodies):
    load = beside(pressure=0.01, traction=(0.01, 0.01))
    grid = vc.Grid(nx=12, ny=12, dx=0.018, dy=0.018, x0=-0.108, y0=-0.108)
    scene = ball(vc.Steady(vx=2e-3, vy=1e-3), load, bodies, grid)
    start = vc.solve(scene)
    # from the steady state nothing changes
    history = vc.solve(replace(scene, motion=vc.Transient(steps=2, vx=2e-3, vy=1e-3, start=start)))
    assert history[-1].traction == pytest.approx(start.traction, abs=1e-8 * start.pressure.max())


def test_a_history_in_place_feels_increments():
    """A load that is there from the first step on moves nothing afterwards."""
    load = beside(traction=(0.02, 0.0))
    bare = ball(vc.Transient(steps=2, dq=0.0, ux=[1e-4, 1e-3]))
    history = vc.solve(replace(bare, loads=load))
    first = vc.solve(replace(bare, motion=vc.Shift(ux=1e-4), loads=load))
    size = first.pressure.max()
    assert history[0].traction == pytest.approx(first.traction, abs=1e-8 * size)
    still = vc.solve(
        replace(bare, motion=vc.Transient(steps=2, dq=0.0, ux=[1e-4, 0.0]), loads=load)
    )
    assert still[1].traction == pytest.approx(still[0].traction, abs=1e-8 * size)


def test_grids_of_any_choice():
    """Chosen grids follow the contact; parts of elements, and samples, have the load, too."""
    load = beside(pressure=0.05)
    limit = vc.solve(ball(vc.Steady(vx=1e-3), load, grid="auto"), accuracy=0.02)
    touched = vc.solve(ball(vc.Steady(vx=1e-3), load, grid=vc.Grid(nx=24, ny=24, edge="touched")))
    x = np.linspace(-0.2, 0.2, 81)
    samples = vc.SampledDistance(x**2 / 2 + x[:, None] ** 2 / 2, x, x)
    searched = vc.solve(replace(limit.scene, surface=samples, grid=vc.Grid(nx=24, ny=24)))
    for sol in (touched, searched):
        assert sol.Fx == pytest.approx(limit.Fx, abs=0.02 * 3e-4)
        assert sol.approach == pytest.approx(limit.approach, rel=3e-3)


# ----------------------------------------------------------------------- files and refusals


@pytest.mark.long
def test_files(tmp_path):
    loads = [
        beside(pressure=np.array([[0.01, 0.02]]), body="upper"),
        beside(-2.0, traction=(0.01, 0.0)),
    ]
    scene = ball(vc.Steady(vx=1e-3), loads)
    scene.save(tmp_path / "scene.toml")
    assert vc.read_scene(tmp_path / "scene.toml")[0].to_toml() == scene.to_toml()
    sol = vc.solve(scene)
    sol.save(tmp_path / "sol.nc")
    again = vc.load(tmp_path / "sol.nc")
    assert np.array_equal(again.scene.loads[0].parts, loads[0].parts)
    judged = vc.certify(replace(again.scene, grid=again.grid), again.traction, again.pressure)
    assert judged.residual < 1e-9
    assert "loads beside" in sol.report()


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"loads": "load"}, "loads"),
        ({"loads": beside(0.5, pressure=0.01), "grid": GRID}, "loads[0]"),
        (
            {
                "loads": [beside(-9.0, pressure=1.0), beside(pressure=1.0)],
                "grid": vc.Grid(nx=9, ny=9, dx=0.05, dy=0.05, x0=-0.225, y0=-0.225),
            },
            "loads[1]",
        ),
        ({"surface": vc.Ellipse(a, a), "loads": beside(pressure=1.0)}, "surface"),
        ({"loads": vc.SurfaceLoad(x=(1.0, 2.0), pressure=1.0)}, "loads[0].y"),
        ({"bodies": vc.Bodies(G=(1.0, np.inf), nu=0.3), "loads": beside(body="lower")}, "loads[0]"),
        ({"bodies": vc.Winkler(h=0.1, E=1.0, G=1.0), "loads": beside()}, "loads"),
    ],
)
def test_refused_by_name(change, named):
    with pytest.raises(vc.SceneError) as refused:
        vc.solve(replace(ball(), **change))
    assert refused.value.field.startswith(named)


def test_an_overlap_with_the_potential_contact_is_known_before_any_work():
    grid = vc.Grid(nx=9, ny=9, dx=0.05, dy=0.05, x0=-0.225, y0=-0.225)
    with pytest.raises(vc.SceneError, match=r"loads\[0\] overlaps the potential contact"):
        vc.plan(ball(loads=beside(pressure=1.0), grid=grid))


@pytest.mark.parametrize(
    ("entries", "named"),
    [
        ({"x": (2.0, 1.0)}, "loads.x"),
        ({"pressure": np.nan}, "loads.pressure"),
        ({"traction": (1.0, 2.0, 3.0)}, "loads.traction"),
        ({"pressure": np.ones((2, 3)), "traction": np.ones((2, 3, 2))}, "loads"),
        ({"y": None, "pressure": np.ones((2, 3))}, "loads.pressure"),
        ({"body": "rail"}, "loads.body"),
    ],
)
def test_loads_check_themselves(entries, named):
    with pytest.raises(vc.SceneError) as refused:
        vc.SurfaceLoad(**{"x": (1.0, 2.0), "y": (0.0, 1.0), **entries})
    assert refused.value.field.startswith(named)
