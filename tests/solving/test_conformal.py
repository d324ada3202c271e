"""Conformal contact: CONTACT's numbers for a wheel in a groove, two roads to one answer, and what
must not matter.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc

DATA = json.loads((Path(__file__).parents[1] / "data" / "conformal.json").read_text())
QUARTER = np.array(DATA["distance"])
HALF = np.concatenate([QUARTER[:0:-1], QUARTER])
DISTANCE = np.concatenate([HALF[:, :0:-1], HALF], axis=1)
GRID = vc.Grid(
    nx=DATA["grid"]["mx"],
    ny=DATA["grid"]["my"],
    dx=0.4,
    dy=0.4,
    x0=DATA["grid"]["xl"],
    y0=DATA["grid"]["yl"],
)
COARSE = vc.Grid(nx=26, ny=20, dx=0.8, dy=0.8, x0=GRID.x0 - 0.2, y0=GRID.y0 - 0.2)
"""Of every second element."""
RADIUS = 10.1
MOTION = vc.Steady(
    vx=DATA["motion"]["vx"], vy=DATA["motion"]["vy"], spin=DATA["motion"]["phi"], dq=0.4
)
CASES = {case["tag"]: case for case in DATA["cases"]}


def scene(inclination=None, friction=0.3, motion=MOTION, grid=GRID, h=DISTANCE, G=82000.0, **load):
    surface = vc.SampledDistance(h, inclination=inclination)
    bodies = vc.Bodies(G=G, nu=0.28)
    return vc.Scene(
        bodies=bodies,
        surface=surface,
        friction=friction,
        motion=motion,
        grid=grid,
        **load or {"approach": 0.0},
    )


def in_groove(turn=1.0, grid=GRID, **changes):
    return scene(turn * grid.y / RADIUS, grid=grid, **changes)


def uneven(grid=GRID, **changes):
    """A reference surface whose curvature varies."""
    return scene(grid.y / RADIUS + 0.1 * np.sin(grid.y / 3), grid=grid, **changes)


def coarse(pose, **changes):
    return pose(grid=COARSE, h=DISTANCE[::2, ::2], **changes)


@pytest.mark.parametrize("tag", CASES)
def test_fields_and_sums_are_those_of_contact(tag):
    case = CASES[tag]
    sol = vc.solve(in_groove(case["turn"], friction=case["friction"]) if case["turn"] else scene())
    x, y = GRID.x[None, :], GRID.y[:, None]
    # CONTACT adds up tractions in the frames of the elements
    area, (along_x, along_y) = GRID.area, sol.traction
    sums = {"Fn": sol.pressure.sum(), "Fx": along_x.sum(), "Fy": along_y.sum()}
    sums["Mz"] = (x * along_y - y * along_x).sum()
    for name, value in sums.items():
        assert value * area == pytest.approx(case[name], rel=1e-7)
    assert sol.max_pressure == pytest.approx(case["pmax"], rel=1e-7)
    assert sol.elements["contact"] == case["ncon"]
    for name, field in (("pn", sol.pressure), ("px", along_x), ("py", along_y)):
        np.testing.assert_allclose(field[:, GRID.nx // 2], case[f"col_{name}"], atol=2e-3)
    if tag == "halfspace":
        assert [sol.normal_force, sol.Fx, sol.Fy] == pytest.approx(
            [case["Fn"], case["Fx"], case["Fy"]], rel=1e-9
        )


def test_forces_are_those_along_the_axes_of_the_plane():
    sol, alpha = vc.solve(in_groove()), GRID.y[:, None] / RADIUS
    lateral = np.cos(alpha) * sol.traction[1] - np.sin(alpha) * sol.pressure
    normal = np.sin(alpha) * sol.traction[1] + np.cos(alpha) * sol.pressure
    assert sol.Fy == pytest.approx(lateral.sum() * GRID.area, rel=1e-12)
    assert sol.normal_force == pytest.approx(normal.sum() * GRID.area, rel=1e-12)


@pytest.mark.parametrize(("pose", "bodies"), [(in_groove, 82000.0), (uneven, (82000.0, 40000.0))])
def test_active_sets_agree_with_newtons_method(pose, bodies):
    one = coarse(pose, G=bodies, motion=vc.Steady(vx=5e-4, vy=-2e-4, spin=1e-4))
    newton, sets = vc.solve(one, method="auto"), vc.solve(one, method="active-set", certify="gap")
    assert "newton" in newton.plan.normal and "norm" in sets.plan.normal
    assert 0 < newton.elements["slip"] < newton.elements["contact"]
    np.testing.assert_allclose(
        [*newton.force, newton.normal_force], [*sets.force, sets.normal_force], rtol=1e-7
    )
    assert max(newton.certificate.relative_gap, sets.certificate.relative_gap) < 1e-9
    assert newton.power == pytest.approx(newton.friction_work, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(
    ("pose", "layer"),
    [(in_groove, vc.ThirdBody(0.02, 820.0)), (uneven, vc.ThirdBody(0.02, 820.0, tau_c0=80.0))],
)
def test_a_third_body_lies_on_the_curved_surface(pose, layer):
    one = replace(coarse(pose, motion=vc.Steady(vx=5e-4, vy=-2e-4, spin=1e-4)), third_body=layer)
    newton, sets = vc.solve(one), vc.solve(one, method="active-set", certify="gap")
    np.testing.assert_allclose(
        [*newton.force, newton.normal_force], [*sets.force, sets.normal_force], rtol=1e-7
    )
    assert max(newton.certificate.relative_gap, sets.certificate.relative_gap) < 1e-9
    assert newton.power == pytest.approx(newton.friction_work, rel=1e-9)
    flat = [
        vc.SampledDistance(DISTANCE[::2, ::2], inclination=turn) for turn in (0 * COARSE.y, None)
    ]
    turned, plane = (vc.solve(replace(one, surface=each)) for each in flat)
    np.testing.assert_allclose(turned.force, plane.force, rtol=1e-8)


@pytest.mark.long
@pytest.mark.parametrize("pose", [in_groove, uneven])
def test_a_prescribed_normal_force_is_along_the_normal_of_the_plane(pose):
    by_approach = vc.solve(pose())
    by_force = vc.solve(pose(normal_force=by_approach.normal_force))
    assert by_force.normal_force == pytest.approx(by_approach.normal_force, rel=1e-10)
    assert by_force.approach == pytest.approx(by_approach.approach, abs=1e-10)
    np.testing.assert_allclose(by_force.force, by_approach.force, rtol=1e-8)


@pytest.mark.long
def test_a_slip_by_element_replaces_the_creepages_that_have_it(tmp_path):
    x, y = np.meshgrid(GRID.x + 0.4 / 6, GRID.y)
    field = np.array([MOTION.vx - MOTION.spin * y, MOTION.vy + MOTION.spin * x])
    given = uneven(motion=vc.Steady(rigid_slip=field, dq=0.4))
    one, other = vc.solve(uneven()), vc.solve(given)
    np.testing.assert_allclose(other.traction, one.traction, atol=1e-7)
    assert other.power == pytest.approx(other.friction_work, rel=1e-9)
    given.save(tmp_path / "groove.toml")
    again = vc.solve(vc.read_scene(tmp_path / "groove.toml")[0])
    np.testing.assert_array_equal(again.traction, other.traction)


def test_a_surface_that_is_not_inclined_is_the_plane():
    flat, plane = vc.solve(scene(np.zeros(GRID.rows))), vc.solve(scene())
    np.testing.assert_allclose(
        [*flat.force, flat.normal_force], [*plane.force, plane.normal_force], rtol=1e-8
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("load", "waves"), [({"approach": 0.0}, 0.1), ({"normal_force": 95e3}, 0.0)]
)
def test_accuracy_is_kept(load, waves):
    inclination = GRID.y / RADIUS + waves * np.sin(GRID.y / 3)
    surface = vc.SampledDistance(DISTANCE, GRID.x, GRID.y, inclination=inclination)
    posed = scene(motion=replace(MOTION, dq=None), **load)
    posed = replace(posed, surface=surface, grid="auto")
    fine, elements = vc.solve(posed, accuracy=0.003), {}
    for accuracy in (0.1, 0.01):
        sol = vc.solve(posed, accuracy=accuracy)
        assert sol.error_estimate.largest <= accuracy
        assert sol.error_estimate.errors.keys() >= {"Fx", "Fy"}
        off = np.hypot(sol.Fx - fine.Fx, sol.Fy - fine.Fy) / (0.3 * fine.normal_force)
        assert off < sol.error_estimate.largest
        assert sol.normal_force == pytest.approx(fine.normal_force, rel=accuracy)
        elements[accuracy] = sol.grid.size
    assert elements[0.1] < elements[0.01] < fine.grid.size


BAD = {
    "surface.inclination": [
        lambda: vc.solve(scene(GRID.y / 4.0, approach=0.05)),
        lambda: vc.SampledDistance(DISTANCE, inclination=GRID.y),
        lambda: vc.SampledDistance(DISTANCE, inclination=[0.0, 0.1]),
        lambda: vc.SampledDistance(DISTANCE, inclination=np.full(GRID.rows, np.nan)),
        lambda: vc.SampledDistance(DISTANCE[0], inclination=[0.0]),
    ],
    "motion": [lambda: in_groove(motion=vc.Transient(steps=3, vx=1e-3))],
    "motion.Fy": [lambda: in_groove(motion=vc.Steady(Fy=10.0))],
    "motion.rigid_slip": [
        lambda: in_groove(motion=vc.Steady(rigid_slip=np.zeros((2, 3, 3)))),
        lambda: vc.Scene(bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Paraboloids(1.0, 1.0), normal_force=1.0,
                         friction=0.3, motion=vc.Steady(rigid_slip=np.zeros((2, 39, 51))), grid=GRID),
    ],
    "tangential": [lambda: vc.solve(in_groove(), tangential="fastsim")],
    "normal": [lambda: vc.solve(in_groove(), normal="hertz")],
}  # fmt: skip


@pytest.mark.parametrize(
    ("field", "call"), [(name, call) for name, calls in BAD.items() for call in calls]
)
def test_bad_input_is_refused(field, call):
    with pytest.raises(vc.SceneError) as error:
        call()
    assert field in str(error.value.field).split("[")[0]
