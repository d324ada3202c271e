"""Gradients of solutions: against differences of solutions, closed forms and the continuum."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.gradients.differences import (
    COARSE,
    COATED,
    EXACT,
    GRID,
    LIKE,
    ROLLING,
    STEP,
    UNLIKE,
    check_gradients,
    contact,
    difference,
    fields,
    solved,
)
from varcontact.errors import SceneError
from varcontact.gradients.adjoint import LinearisedSolution
from varcontact.gradients.outputs import OUTPUTS, output_of

SCENES = {
    "creepage": contact(),
    "force": contact(motion=vc.Steady(Fx=0.003, vy=3e-4, spin=6e-4)),
    "second order": contact(motion=ROLLING.second_order()),
    "unlike": contact(UNLIKE),
    "unlike, force": contact(UNLIKE, vc.Steady(Fx=0.003, vy=3e-4)),
    "shift": contact(motion=vc.Shift(ux=2e-3, uy=1e-3)),
    "unlike shift": contact(UNLIKE, vc.Shift(ux=2e-3, uy=1e-3)),
    "coated": contact(COATED),
    "beside a load": contact(
        loads=vc.SurfaceLoad(x=(3.0, 4.0), y=(-0.5, 0.5), pressure=0.01, traction=(0.01, 0.0))
    ),
    "approach": contact(normal_force=None, approach=0.008),
}


@pytest.mark.long
@pytest.mark.parametrize("kind", SCENES)
def test_gradients_are_differences_of_solutions_within_a_pattern(kind):
    """Derivatives with held areas, exact while no element changes its state."""
    scene = SCENES[kind]
    load = "normal_force" if scene.approach is None else "approach"
    inputs = {
        load: lambda v: replace(scene, **{load: v}),
        "friction": lambda v: replace(scene, friction=v),
        "surface.Ry": lambda v: replace(scene, surface=vc.Paraboloids(100.0, v)),
    }
    at = {load: getattr(scene, load), "friction": 0.3, "surface.Ry": 90.0}
    outputs = ["Fx" if scene.motion.Fx is None else "vx", "Mz", "friction_work"]
    around = {
        name: [fields(scene_of(at[name] * (1 + step))) for step in (STEP, -STEP)]
        for name, scene_of in inputs.items()
    }
    solution = solved(scene)
    for output in outputs:
        found = solution.gradient(output, tuple(inputs), edge="held")
        value_of = output_of(output)[1].value
        for name, (above, below) in around.items():
            expected = (value_of(above) - value_of(below)) / (2 * STEP * at[name])
            scale = abs(float(found.value) / at[name])
            assert float(found[name]) == pytest.approx(expected, rel=2e-6, abs=2e-7 * scale)


def test_what_nothing_changes_has_no_derivative():
    nothing = vc.Weighted(pressure=0.0, name="nothing")
    found = solved(SCENES["unlike"]).gradient(nothing, ("vx", "surface.Rx"), edge="held")
    assert float(found.vx) == float(found["surface.Rx"]) == 0


def test_a_modulus_beside_a_load():
    """The shift by loads beside the contact changes with the elasticity, if creepages do not."""
    check_gradients(SCENES["beside a load"], ("bodies.G", "bodies.nu"))


@pytest.mark.parametrize("kind", ["creepage", "unlike", "shift"])
def test_gradients_by_fields(kind):
    """A random change of the distance and of the friction of each element."""
    rng = np.random.default_rng(3)
    plain = SCENES[kind]
    x, y = np.meshgrid(GRID.x, GRID.y)
    distance = x**2 / 200 + y**2 / 180
    friction = np.full(GRID.shape, 0.3) + 0.02 * rng.random(GRID.shape)
    scene = replace(plain, surface=vc.SampledDistance(distance), friction=friction)
    found = solved(scene).gradient("Fx", ("distance", "friction"), edge="held")
    way = rng.standard_normal(GRID.shape)
    of_distance = difference(
        lambda s: replace(scene, surface=vc.SampledDistance(distance + (s - 1) * 1e-3 * way)),
        1.0,
        "Fx",
    )
    of_friction = difference(
        lambda s: replace(scene, friction=friction + (s - 1) * 100 * way), 1.0, "Fx"
    )
    assert float((found.distance * way).sum()) * 1e-3 == pytest.approx(of_distance, rel=1e-5)
    assert float((found.friction * way).sum()) * 100 == pytest.approx(of_friction, rel=1e-5)
    assert found.distance.dims == ("y", "x")


LINED = vc.Layered([vc.Layer(0.4, 2.0, 0.3)], base=(1.0, 0.28))
LINED_PAIR = vc.BodyPair(LINED, vc.Bodies(G=1.5, nu=0.25))
FORCED = vc.Steady(Fx=0.003, Fy=-0.002, spin=6e-4)


@pytest.mark.long
@pytest.mark.parametrize(
    ("bodies", "paths"),
    [
        (LIKE, ("bodies.G", "bodies.nu", "bodies.nu.upper")),
        (UNLIKE, ("bodies.G.lower", "bodies.nu.upper", "bodies.nu.lower")),
        (LINED, ("bodies.layers.0.G", "bodies.layers.0.nu")),
        (
            LINED_PAIR,
            ("bodies.upper.layers.0.h", "bodies.upper.base.0", "bodies.lower.nu"),
        ),
    ],
    ids=["like", "unlike", "lined", "lined pair"],
)
def test_gradients_by_each_body_and_its_layers(bodies, paths):
    """Numbers of both bodies, of one, and of a layer, by their paths."""
    check_gradients(contact(bodies, grid=COARSE), paths, step=1e-5)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE, LINED], ids=["like", "unlike", "lined"])
def test_gradients_by_prescribed_forces(bodies):
    """Creepages, moment and friction work by the forces themselves, and what else they take."""
    scene = contact(bodies, FORCED, grid=COARSE)
    check_gradients(scene, ("Fx", "Fy", "spin"), ("vx", "vy", "Mz", "friction_work"))


@pytest.mark.parametrize("motion", [ROLLING, ROLLING.second_order()], ids=["first", "second"])
def test_gradients_by_the_distance_of_a_step(motion):
    check_gradients(contact(motion=replace(motion, dq=0.7 * COARSE.dx), grid=COARSE), ("dq",))


@pytest.mark.parametrize("parts", [0.5, 1.5])
def test_a_step_to_the_side_of_an_element_has_no_derivative(parts):
    """Displacements by a uniform traction have a vertical tangent at its side."""
    scene = contact(motion=replace(ROLLING, dq=parts * COARSE.dx), grid=COARSE)
    with pytest.raises(SceneError, match="side of an element"):
        solved(scene).gradient("Fx", "dq")


def test_gradients_in_line_contact():
    """Cylinders with creepage: Fx by creepage, friction and load."""
    scene = vc.Scene(
        bodies=LIKE,
        surface=vc.Cylinders(100.0),
        normal_force=0.02,
        friction=0.3,
        motion=vc.Steady(vx=1e-3),
        grid=vc.Grid(nx=40, dx=0.1, x0=-2.03),
    )
    found = solved(scene).gradient("Fx", ("vx", "friction", "normal_force"), edge="held")
    changed = {
        "vx": (lambda v: replace(scene, motion=vc.Steady(vx=v)), 1e-3),
        "friction": (lambda v: replace(scene, friction=v), 0.3),
        "normal_force": (lambda v: replace(scene, normal_force=v), 0.02),
    }
    for name, (scene_of, at) in changed.items():
        assert float(found[name]) == pytest.approx(difference(scene_of, at, "Fx"), rel=1e-5)


def test_normal_contact_has_hertz_derivatives():
    """approach ~ N^(2/3) and p_0 ~ N^(1/3)."""
    scene = replace(SCENES["creepage"], motion=None, friction=None, grid=vc.Grid(nx=30, ny=30))
    sol = vc.solve(scene, normal="norm")
    found = sol.gradient(["approach", "peak_pressure", "contact_area"], "normal_force")
    power = found.normal_force * 0.02 / found.value
    assert np.allclose(power, [2 / 3, 1 / 3, 2 / 3], atol=0.02)


def test_in_full_slip_force_is_friction_times_load():
    scene = contact(motion=vc.Steady(vx=0.5))
    found = solved(scene).gradient("Fx", ("friction", "normal_force", "vx"), edge="held")
    assert float(found.friction) == pytest.approx(-0.02, rel=1e-6)
    assert float(found.normal_force) == pytest.approx(-0.3, rel=1e-6)
    assert abs(float(found.vx)) < 1e-6


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE], ids=["like", "unlike"])
def test_friction_work_is_that_of_the_solution(bodies):
    sol = solved(contact(bodies, grid=COARSE))
    value = sol.gradient("friction_work", "vx").value
    assert float(value) == pytest.approx(sol.friction_work, rel=1e-9)


def test_friction_work_of_like_bodies_is_t_gamma():
    """-(Fx vx + Fy vy + Mz spin) in steady rolling, and its derivatives by any input."""
    by = ("friction", "surface.Rx", "vx")
    outputs = ["Fx", "Fy", "Mz", "friction_work"]
    found = solved(contact(grid=COARSE)).gradient(outputs, by, edge="held")
    own = np.array([ROLLING.vx, ROLLING.vy, ROLLING.spin])
    for name in ("value", *by):
        *forces, work = found[name].to_numpy()
        expected = -float(own @ forces)
        if name == "vx":
            expected -= float(found.value[0])
        assert work == pytest.approx(expected, rel=1e-6)


def test_in_full_slip_forces_turn_with_the_creepage():
    """Fx = -f N vx/v: none along the creepage, -f N/v across it; work f N v."""
    vx, vy = 0.5, 0.2
    size = np.hypot(vx, vy)
    scene = contact(motion=vc.Steady(vx=vx, vy=vy), grid=COARSE)
    found = solved(scene).gradient(["Fx", "Fy", "friction_work"], ("vx", "vy"), edge="held")
    along = (vx * found.vx + vy * found.vy) / size
    across = (vx * found.vy - vy * found.vx) / size
    limit = 0.3 * 0.02
    turned = limit / size**2 * np.array([vy, -vx])
    assert np.allclose(along, [0.0, 0.0, limit], atol=1e-3 * limit)
    assert np.allclose(across[:2], turned, rtol=1e-3)


def test_a_step_of_a_history():
    """With the steps before as they are: by creepage, friction and load of the last step."""
    steps = {"vx": [2e-3, 2e-3], "vy": [1e-3, 1e-3], "friction": [0.3, 0.3], "load": [0.02, 0.02]}

    def last(name="vx", change=0.0):
        own = {each: list(values) for each, values in steps.items()}
        own[name][-1] *= 1 + change
        load = own.pop("load")
        motion = vc.Transient(steps=2, dq=0.2, normal_force=load, **own)
        scene = contact(motion=motion, normal_force=None, friction=None)
        return vc.solve(scene, normal="norm", **EXACT)[-1]

    names = {"vx": "motion.vx", "friction": "friction", "load": "normal_force"}
    found = last().gradient("Fx", tuple(names.values()))
    for name, path in names.items():
        difference = last(name, STEP).Fx - last(name, -STEP).Fx
        expected = difference / (2 * STEP * steps[name][-1])
        assert float(found[path]) == pytest.approx(expected, rel=1e-6)
    with pytest.raises(SceneError, match="steps before do not change"):
        last().gradient("Fx", "bodies.G")


def test_a_grid_that_follows_has_the_derivative_of_the_continuum_by_load():
    """Without slip Fx by creepage grows as N^(2/3); with held areas it would not change at all."""
    grid = vc.Grid(nx=26, ny=26, dx=0.1, dy=0.1, x0=-1.3, y0=-1.27)
    sol = solved(contact(friction=np.inf, motion=vc.Steady(vx=4e-4), grid=grid))
    following = float(sol.gradient("Fx", "normal_force").normal_force)
    held = float(sol.gradient("Fx", "normal_force", edge="held").normal_force)
    assert following * 0.02 / sol.Fx == pytest.approx(2 / 3, abs=0.02)
    assert abs(held * 0.02 / sol.Fx) < 1e-6


def test_following_is_near_differences_of_grids_that_follow():
    """Partial slip: differences over 10 % of the load on grids that move with the contact."""
    fine = contact(motion=ROLLING.second_order(), grid=vc.Grid(nx=40, ny=40))
    forces = [vc.solve(replace(fine, normal_force=N), certify="none").Fx for N in (0.019, 0.021)]
    expected = (forces[1] - forces[0]) / 0.002
    coarse = solved(replace(fine, grid=GRID))
    found = coarse.gradient("Fx", "normal_force", error=True)
    assert float(found.normal_force) == pytest.approx(expected, rel=0.04)
    assert abs(float(found.normal_force) - expected) < float(found.normal_force_error)


def test_a_moving_edge_sums_to_the_load_of_a_following_grid():
    """A uniform distance less an approach is a load: both derivatives are the continuum's."""
    scene = contact(
        normal_force=None,
        approach=0.0085,
        grid=vc.Grid(nx=40, ny=40, dx=0.07, dy=0.07, x0=-1.4, y0=-1.38),
    )
    sol = solved(scene)
    moving = -float(sol.gradient("Fx", "distance").distance.sum())
    held = -float(sol.gradient("Fx", "distance", edge="held").distance.sum())
    following = float(sol.gradient("Fx", "approach").approach)
    assert moving == pytest.approx(following, rel=0.08)
    assert abs(moving - following) < abs(held - following)


ROLLED_ON = vc.Grid(nx=20, ny=20, dx=0.14, dy=0.14, x0=-1.4, y0=-1.38)
WAVES = [lambda x, y: 1 + 0 * x, lambda x, y: x * y, lambda x, y: np.cos(3 * x + y)]
"""Undulations of the distance."""


PAIR = vc.Paraboloids(100.0, 90.0)


def rolled_over(grid, surface):
    return contact(normal_force=None, approach=0.0085, surface=surface, grid=grid)


@pytest.mark.parametrize("undulation", WAVES)
def test_errors_of_a_moving_edge_come_by_default_and_hold(undulation):
    """Against elements of a third, by undulations that all grids resolve: the bars of elements sum
    to more than what is left.
    """
    found = solved(rolled_over(ROLLED_ON, PAIR)).gradient("Fx", "distance")
    fine = vc.Grid(nx=60, ny=60, dx=0.14 / 3, dy=0.14 / 3, x0=-1.4, y0=-1.38)
    better = vc.solve(rolled_over(fine, PAIR)).gradient("Fx", "distance", error=False)
    along = [
        float((each.distance * undulation(*np.meshgrid(each.x, each.y))).sum())
        for each in (found, better)
    ]
    bar = float((found.distance_error * np.abs(undulation(*np.meshgrid(found.x, found.y)))).sum())
    assert abs(along[0] - along[1]) < bar
    assert "distance_error" not in better


@pytest.mark.parametrize("nx", [20, 21])
def test_errors_by_distances_that_are_given_by_elements(nx):
    """Near those of the same surface by its radii."""
    grid = replace(ROLLED_ON, nx=nx)
    samples = grid.x**2 / 200 + grid.y[:, None] ** 2 / 180
    by_samples, by_radii = (
        solved(rolled_over(grid, surface)).gradient("Fx", "distance")
        for surface in (vc.SampledDistance(samples), PAIR)
    )
    assert by_samples.distance_error.shape == grid.shape
    bars = [float(each.distance_error.sum()) for each in (by_samples, by_radii)]
    assert bars[0] == pytest.approx(bars[1], rel=0.2)


def test_rows_of_four_elements_have_no_slope_at_the_edge():
    """Their inner pressures are equal but for rounding: a ratio of slopes would be any number."""
    sol = solved(rolled_over(vc.Grid(nx=10, ny=10, dx=0.28, dy=0.28, x0=-1.4, y0=-1.38), PAIR))
    assert 4 in (sol.pressure > 0).sum(axis=1)
    found = sol.gradient("Fx", "distance", error=False).distance
    held = sol.gradient("Fx", "distance", edge="held").distance
    assert float(np.abs(found).max()) < 10 * float(np.abs(held).max())


def test_errors_by_friction_of_each_element_sum_to_that_of_one_number():
    """The bars of elements are shares of the difference of larger ones."""
    scene = contact(grid=ROLLED_ON)
    one = solved(scene).gradient("Fx", "friction", error=True)
    field = replace(scene, friction=np.full(ROLLED_ON.shape, 0.3))
    each = solved(field).gradient("Fx", "friction", error=True)
    assert float(each.friction.sum()) == pytest.approx(float(one.friction), rel=1e-9)
    assert float(each.friction_error.sum()) >= 0.999 * float(one.friction_error)


def test_errors_of_an_output_with_weights_by_elements():
    """Twice the weight has twice the error."""
    sol = solved(contact(grid=ROLLED_ON))
    weights = np.cos(ROLLED_ON.x) + 0 * ROLLED_ON.y[:, None]
    outputs = [vc.Weighted(factor * weights, name=f"{factor}") for factor in (1.0, 2.0)]
    found = sol.gradient(outputs, "normal_force", error=True).normal_force_error
    assert 0 < float(found[0]) == pytest.approx(float(found[1]) / 2, rel=1e-9)


@pytest.mark.parametrize("edge", ["centres", "softened"])
def test_with_hertz_pressure_the_grid_follows_his_ellipse(edge):
    """Differences of solutions on grids that are relative to the contact, to their noise."""
    scene = contact(grid=vc.Grid(nx=16, ny=16, edge=edge))
    found = vc.solve(scene, **EXACT).gradient("Fx", ("normal_force", "surface.Ry", "bodies.G"))

    def differ(name, make, at):
        above, below = (vc.solve(make(at * (1 + s)), **EXACT).Fx for s in (STEP, -STEP))
        assert float(found[name]) == pytest.approx((above - below) / (2 * STEP * at), rel=1e-5)

    differ("normal_force", lambda v: replace(scene, normal_force=v), 0.02)
    differ("surface.Ry", lambda v: replace(scene, surface=vc.Paraboloids(100.0, v)), 90.0)
    differ("bodies.G", lambda v: replace(scene, bodies=vc.Bodies(G=v, nu=0.28)), 1.0)


def test_units_change_nothing():
    """Lengths in thousandths, forces in hundreds."""
    own = solved(SCENES["creepage"]).gradient("Mz", ("normal_force", "surface.Rx"))
    grid = vc.Grid(nx=14, ny=14, dx=200.0, dy=200.0, x0=-1400.0, y0=-1370.0)
    scene = contact(
        vc.Bodies(G=1e-8, nu=0.28),
        replace(ROLLING, spin=6e-7),
        surface=vc.Paraboloids(1e5, 9e4),
        normal_force=2e-4,
        grid=grid,
    )
    other = solved(scene).gradient("Mz", ("normal_force", "surface.Rx"))
    assert float(other.normal_force) == pytest.approx(1e3 * float(own.normal_force), rel=1e-6)
    assert float(other["surface.Rx"]) == pytest.approx(1e-2 * float(own["surface.Rx"]), rel=1e-6)


def test_a_weighted_output_is_any_linear_functional():
    scene = SCENES["force"]
    left = vc.Weighted(pressure=lambda x, y: x < 0, traction=(1.0, 0.5), name="left")
    sol = solved(scene)
    found = sol.gradient([left, "vx"], "normal_force", edge="held")

    def scene_of(v):
        return replace(scene, normal_force=v)

    assert list(found.output.values) == ["left", "vx"]
    expected = [difference(scene_of, 0.02, left), difference(scene_of, 0.02, "vx")]
    assert np.allclose(found.normal_force, expected, rtol=2e-6)


@pytest.mark.parametrize("output", [vc.PeakPressure(power=12), "peak_pressure"])
def test_the_peak_pressure_is_that_of_differences(output):
    """Held areas, by load and radius; of the largest pressure itself while one element has it."""
    scene = contact(LIKE, grid=vc.Grid(nx=14, ny=14, dx=0.2, dy=0.2, x0=-1.43, y0=-1.33))
    found = solved(scene).gradient(output, ("normal_force", "surface.Ry"), edge="held")

    def loaded(v):
        return replace(scene, normal_force=v)

    def curved(v):
        return replace(scene, surface=vc.Paraboloids(100.0, v))

    assert float(found.normal_force) == pytest.approx(difference(loaded, 0.02, output), rel=2e-6)
    assert float(found["surface.Ry"]) == pytest.approx(difference(curved, 90.0, output), rel=2e-6)


def test_a_dataset_has_units():
    scene = replace(SCENES["creepage"], units=vc.MM_N)
    found = solved(scene).gradient("Fx", ("vx", "normal_force", "bodies.G", "distance"))
    assert found.vx.units == "N"
    assert found.normal_force.units == "(N)/(N)"
    assert found["bodies.G"].units == "(N)/(N/mm^2)"
    assert found.distance.units == found.distance_error.units == "(N)/(mm)"
    assert np.allclose(found.x, GRID.x)
    assert "error=True" in solved(scene).gradient("Fx", "vx").error


@pytest.mark.long
def test_inputs_of_layers_have_units():
    inputs = ("bodies.layers.0.G", "bodies.layers.0.h", "bodies.base.0", "third_body.h")
    scene = contact(LINED, units=vc.MM_N, third_body=vc.ThirdBody(h=0.05, G=0.1), grid=COARSE)
    found = solved(scene).gradient("Fx", inputs, edge="held")
    units = [found[name].units for name in inputs]
    assert units == ["(N)/(N/mm^2)", "(N)/(mm)", "(N)/(N/mm^2)", "(N)/(mm)"]


@pytest.mark.parametrize(
    ("scene", "output", "by", "words"),
    [
        ("creepage", "Fz", "vx", "output"),
        ("creepage", "vx", "normal_force", "prescribed"),
        ("creepage", [vc.Weighted(1.0), vc.Weighted(2.0)], "vx", "given once"),
        ("force", "vx", "vx", "follows from Fx"),
        ("creepage", "Fx", "surface.Rz", "did you mean Ry"),
        ("creepage", "Fx", "approach", "number"),
        ("creepage", "Fx", "motion.Fx", "number"),
        ("creepage", "Fx", (), "by"),
        ("creepage", "Fx", 3, "by"),
        ("creepage", "Fx", "bodies.G.middle", "by"),
        ("creepage", "Fx", "dq", "number"),
        ("creepage", "Fx", "G", "did you mean bodies.G"),
        ("creepage", "Fx", "Ry", "did you mean surface.Ry"),
        ("creepage", "Fx", "bodies", "name bodies.G or bodies.nu$"),
        ("unlike", "Fx", "bodies.G", "name bodies.G.upper or bodies.G.lower$"),
        ("coated", "Fx", "h", "did you mean bodies.upper.layers.0.h"),
    ],
)
def test_what_the_scene_has_not(scene, output, by, words):
    with pytest.raises(SceneError, match=words):
        solved(SCENES[scene]).gradient(output, by)


def test_solutions_without_a_gradient():
    with pytest.raises(SceneError, match="exact method"):
        vc.solve(SCENES["creepage"], tangential="fastsim").gradient("Fx", "vx")
    sticking = solved(SCENES["creepage"])
    slipping = replace(
        sticking,
        state=np.where(sticking.state == 1, 2, sticking.state),
        scene=replace(sticking.scene, motion=vc.Steady(Fx=0.003)),
    )
    with pytest.raises(SceneError, match="full slip no derivative"):
        slipping.gradient("Fy", "friction")
    with pytest.raises(SceneError, match="first-order"):
        solved(SCENES["second order"]).gradient("Fx", "distance")
    with pytest.raises(SceneError, match="moves no whole contact"):
        solved(SCENES["creepage"]).gradient("Fx", "distance", edge="following")
    at_rest = vc.solve(contact(motion=None, friction=None))
    with pytest.raises(SceneError, match="no motion"):
        at_rest.gradient("Fx", "normal_force")
    with pytest.raises(SceneError, match="input of the scene"):
        at_rest.gradient("approach", "dq")


def _conformal():
    distance = COARSE.y[:, None] ** 2 / 200 + COARSE.x**2 / 200
    surface = vc.SampledDistance(distance, inclination=0.05 * COARSE.y)
    return contact(surface=surface, normal_force=None, approach=0.008, grid=COARSE)


def _beside_held_parts():
    held = vc.SurfaceDisplacement(x=(3.0, 4.0), y=(-0.5, 0.5), normal=1e-3, nx=2, ny=2)
    return contact(displacements=held, grid=COARSE)


@pytest.mark.parametrize(
    ("scene", "field"),
    [(_conformal, "surface"), (_beside_held_parts, "displacements")],
)
def test_contacts_without_a_gradient(scene, field):
    with pytest.raises(SceneError, match="no gradient") as caught:
        vc.solve(scene(), certify="none").gradient("Fx", "vx")
    assert caught.value.field == field


def _relaxing_step():
    motion = vc.Transient(steps=1, vx=1e-3, dq=0.24, dt=0.2, normal_force=0.02)
    bodies = vc.Viscoelastic(1.0, 0.28, [(1.0, 0.5)])
    return vc.solve(contact(bodies, motion, normal_force=None, grid=COARSE), certify="none")[0]


def _parts_of_elements():
    """The edge is softened by the covered parts of elements, of a pressure that is solved for."""
    scene = contact(grid=replace(COARSE, edge="softened"))
    return vc.solve(scene, normal="norm", certify="none")


def _softened_under_hertz():
    """On elements whose edge is softened, under Hertz's pressure."""
    return vc.solve(contact(grid=vc.Grid(nx=12, ny=12, edge="softened")), certify="none")


def _coupled_by_johnson():
    return vc.solve(contact(UNLIKE, grid=COARSE), coupling="johnson", certify="none")


@pytest.mark.parametrize(
    ("solve", "by", "words"),
    [
        (_relaxing_step, "vx", "steps of others have no gradient"),
        (_parts_of_elements, "normal_force", "pressures on parts of elements have no gradient"),
        (_softened_under_hertz, "distance", 'whose edge is "centres"'),
        (_coupled_by_johnson, "vx", "this one is approximate"),
    ],
)
def test_solutions_of_other_problems_have_no_gradient(solve, by, words):
    with pytest.raises(SceneError, match=words):
        solve().gradient("Fx", by)


def test_a_step_of_a_history_has_no_error_bars():
    """The steps before would have to be solved on larger elements as well."""
    motion = vc.Transient(steps=1, vx=1e-3, dq=0.24, normal_force=0.02)
    (step,) = vc.solve(contact(motion=motion, normal_force=None, grid=COARSE), certify="none")
    with pytest.raises(SceneError, match="solved after those before"):
        step.gradient("Fx", "vx", error=True)


def test_a_solution_that_is_not_converged_has_no_gradient():
    with pytest.raises(vc.NotConverged) as failure:
        vc.solve(contact(grid=vc.Grid(nx=6, ny=6)), tol=1e-30)
    with pytest.raises(SceneError, match="not converged"):
        failure.value.solution.gradient("Fx", "vx")


def test_every_output_has_a_value_and_derivatives_by_its_fields():
    """Partial derivatives against differences of the output itself."""
    about = LinearisedSolution.of(solved(SCENES["unlike, force"]), "held")
    fields = about.fields
    rng = np.random.default_rng(0)
    for name, output in OUTPUTS.items():
        partial = output.partial(fields)
        way = rng.standard_normal(GRID.shape) * fields.pressure
        turned = rng.standard_normal((2, *GRID.shape)) * np.abs(fields.traction)
        step = 1e-6
        above, below = (
            output.value(
                replace(
                    fields,
                    pressure=fields.pressure + sign * step * way,
                    traction=fields.traction + sign * step * turned,
                )
            )
            for sign in (1, -1)
        )
        expected = np.sum(partial.pressure * way) + np.sum(partial.traction * turned)
        if name == "peak_pressure":
            continue  # the largest of several is no smooth function
        assert (above - below) / (2 * step) == pytest.approx(float(expected), rel=1e-6, abs=1e-12)
