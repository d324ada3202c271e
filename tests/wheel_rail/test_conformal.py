"""Wheels on rails with curved reference surfaces: CONTACT's numbers, symmetry, the limit of planes,
refusals.
"""

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refusals
from tests.wheel_rail.conditions import DATA, RAIL, flat_track, round_rail, wheel
from varcontact.elasticity import conformal
from varcontact.kinematics import RigidBody
from varcontact.solving.on_grid import solve_on_grid
from varcontact.solving.options import SolveOptions, Target
from varcontact.wheel_rail import ConformalContact, Position, Profile, Track, Velocity, WheelSet
from varcontact.wheel_rail.curve import spline
from varcontact.wheel_rail.patches import contact_locus, reference_surface, tangent_of
from varcontact.wheel_rail.solve_to_target import _at_approaches, _chosen, _first, _near

CONTACT = json.loads((DATA / "conformal.json").read_text())
NO_KINKS = np.zeros(0, dtype=int)


def on_flange_root(**changes):
    """The wheel of the Manchester benchmark, 6 mm towards the rail: three parts, one of them at 25
    degrees.
    """
    usual = {"vertical_force": 50e3, "dx": 0.4, "dy": 0.4, "join": 6.0, "separate": 9.0}
    rolling = {
        "track": Track(rail=RAIL, cant=0.025),
        "velocity": Velocity(speed=2000.0, pitch_rate=-4.3481124),
    }
    return wheel(6.0, **usual | rolling | changes)


def hollow_wheel(radius, yaw=2e-3, **changes):
    """A wheel with a round hollow of a radius [mm] on a rail's head of radius 20 mm."""
    rail = round_rail(20.0, half=15.0)
    z = radius - np.sqrt(radius**2 - rail.y**2)
    hollow = Profile(y=rail.y, z=z, kind="wheel", kinks=[])
    usual = {
        "track": flat_track(rail),
        "wheelset": WheelSet(wheel=hollow),
        "vertical_force": 130e3,
    }
    return wheel(yaw=yaw, **usual | changes)


def groove(dx=0.2):
    """A wheel with a round tread of radius 10 mm in a groove of radius 10.1 mm: place, and scene,
    as of CONTACT.
    """
    angle, z = np.linspace(-1.2, 1.2, 241), CONTACT["groove"]["z"]
    arcs = [np.stack([R * np.sin(angle), -R * (1 - np.cos(angle))], axis=1) for R in (10.1, 10.0)]
    rail, tread = spline(arcs[0], NO_KINKS, 0.0), spline(arcs[1] + [0.0, 420.0], NO_KINKS, 0.0)
    overlaps = contact_locus(tread, rail, np.eye(3), np.array([0.0, 0.0, -420.0])).overlaps(z)
    axle = np.array([0.0, 0.0, z - 420.0])
    tangent = tangent_of(overlaps, rail)
    body = RigidBody(
        position=axle, velocity=[420.0, 0.0, 0.0], angular_velocity=[0.0, -1.0004, 0.0]
    )
    place = reference_surface(overlaps, tangent, tread, rail, body, (dx, dx), curved=True)
    scene = make_scene(
        vc.SampledDistance(place.distance, inclination=place.inclination),
        None,
        vc.Steady(
            rigid_slip=place.rigid_slip(tangent.frame, RigidBody(position=np.zeros(3)), body, 420.0)
        ),
        place.grid,
        bodies=vc.Bodies(G=82000.0, nu=0.28),
        approach=place.approach,
    )
    return place, scene


@pytest.mark.long
def test_reference_surface_and_distance_in_a_groove_are_those_of_contact():
    place, scene = groove()
    known, grid = CONTACT["groove"], place.grid
    rows = slice(round((known["y0"] - grid.y[0]) / known["dy"]), None)
    rows = slice(rows.start, rows.start + len(known["alpha"]))
    np.testing.assert_allclose(place.inclination[rows], known["alpha"], atol=1e-5)
    middle = int(np.abs(grid.x).argmin())
    # its profile's noise
    np.testing.assert_allclose(place.distance[rows, middle], known["distance"], atol=5e-5)
    assert place.approach == pytest.approx(known["pen"], rel=1e-9)
    solution = vc.solve(scene)
    assert solution.pressure.sum() * grid.area == pytest.approx(known["Fn"], rel=5e-4)
    assert solution.normal_force == pytest.approx(known["force"][2], rel=5e-4)
    assert solution.Fx == pytest.approx(known["force"][0], abs=1e-3 * 0.3 * known["Fn"])
    assert solution.max_pressure == pytest.approx(known["pmax"], rel=5e-4)
    assert solution.elements["contact"] == pytest.approx(known["ncon"], abs=4)
    assert solution.elements["stick"] == pytest.approx(known["nadh"], abs=4)


def test_a_wheel_in_a_groove_is_its_own_mirror_image():
    _, scene = groove(0.4)
    solution = vc.solve(scene)
    assert abs(solution.Fy) < 1e-6 * solution.normal_force
    np.testing.assert_allclose(
        solution.pressure, solution.pressure[::-1], atol=1e-5 * solution.max_pressure
    )
    # spin varies: the wheel rolls at many radii
    assert solution.scene.motion.rigid_slip[0].std() > 1e-4


@pytest.mark.long
def test_forces_on_the_flange_root_are_those_of_contact():
    found, known = on_flange_root(dx=0.2, dy=0.2, conformal=True).solve(), CONTACT["wheel_on_rail"]
    assert len(found.patches) == 1
    np.testing.assert_allclose(found.force, known["force"], atol=2e-3 * 15e3)
    assert found.z == pytest.approx(known["z"], rel=1e-3)
    assert found.patches[0].peak_pressure == pytest.approx(known["pmax"], rel=3e-3)
    assert found.patches[0].patch.angle == pytest.approx(known["angle"], abs=2e-4)


@pytest.mark.long
@pytest.mark.slow
def test_a_curved_surface_has_the_error_bars_of_a_plane():
    """By default: they hold against elements of two sizes, of which the errors are of the first
    order.
    """
    case = hollow_wheel(20.8)
    found = case.solve()
    coarse, fine = (replace(case, conformal=True, dx=dx, dy=0.2).solve().force for dx in (0.8, 0.4))
    assert found.patches[0].patch.scene.conformal
    assert np.all(found.error[:2] > 0) and np.all(found.error[:2] < 0.01 * 0.3 * 130e3)
    assert np.all(np.abs(found.force - (2 * fine - coarse)) <= found.error + 2e-3 * 0.3 * 130e3)


@pytest.mark.long
def test_auto_takes_curved_surfaces_where_a_plane_would_be_warned_of():
    case = hollow_wheel(20.5, yaw=0.0, vertical_force=100e3, dx=1.0, dy=1.0)
    with pytest.warns(ConformalContact) as caught:
        planar = replace(case, conformal=False).solve()
    told = [str(each.message) for each in caught]
    assert any(
        "the rail's radius of curvature 20 mm, less than 3 times as much" in text for text in told
    )
    assert any("the wheel's radius of curvature 20.5 mm" in text for text in told)
    assert all(text.startswith("conformal contact: the patch at y = 750 mm is ") for text in told)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        auto, curved = case.solve(), replace(case, conformal=True).solve()
        wheel(vertical_force=20e3).solve()
    np.testing.assert_array_equal(auto.force, curved.force)
    assert auto.force[2] == pytest.approx(100e3, rel=1e-6)
    # on a plane nothing slips; here the radius varies
    assert auto.force[0] < -1e3 < planar.force[0] < 1.0
    exact = replace(case, dx=None, dy=None).solve(accuracy=0.05)
    assert exact.patches[0].patch.scene.conformal
    assert exact.patches[0].solution.error_estimate.largest <= 0.025  # half is for the load
    fine = replace(case, dx=0.5, dy=0.5, conformal=True).solve()
    np.testing.assert_allclose(exact.force[:2], fine.force[:2], atol=0.05 * case.friction * 100e3)
    moment, lever = auto.moment_on_wheelset, auto.patches[0].patch.location[1] - case.position.y
    assert moment[0] == pytest.approx(
        -lever * auto.force[2] + auto.force[1] * case.wheelset.radius, rel=1e-3
    )


def test_the_choice_of_a_curved_surface_is_no_matter_of_the_elements():
    """Between two edges of the gauge corner the patch goes on to the rail's face, where the rail has
    no inclination: a curved surface all along, on coarse and on fine elements; the forces grow.
    """
    track = Track(rail=RAIL, cant=0.025)
    y = [6.4, 6.45, 6.55, 6.62, 6.7]
    along = []
    for side in (1.0, 0.5):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = [wheel(each, track=track, dx=side, dy=side).solve() for each in y]
        assert [each.case.conformal is True for each in found] == [False, True, True, True, False]
        along.append([each.force[1] for each in found])
    assert np.all(np.diff(along) > 0)
    np.testing.assert_allclose(along[0], along[1], rtol=0.02)


def test_a_row_more_of_elements_does_not_decide_on_a_curved_surface():
    """By its rows in contact the patch is 4 mm wide to either side on coarse elements, and 3.75 on
    fine ones: the rail's radius is between three times these.
    """
    track = Track(rail=Profile.rail_60e1(), cant=0.025)
    rolling = {"velocity": Velocity(speed=20e3), "friction": 0.3, "track": track}
    axle = WheelSet(wheel=Profile.s1002())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = [wheel(6.8, wheelset=axle, dx=d, dy=d, **rolling).solve() for d in (1.0, 0.5)]
    coarse, fine = (each.patches[0] for each in found)
    assert coarse.half_width > 1.05 * fine.half_width
    assert coarse.loaded_half_width == pytest.approx(fine.loaded_half_width, rel=0.02)
    assert {each.case.conformal for each in found} == {"auto"}


@pytest.mark.long
def test_other_loads_begin_from_the_contact_on_the_same_grids(monkeypatch):
    """With an accuracy: influence numbers are made for the first load, and the answer is that of
    the same wheel from the beginning.
    """
    made = []
    make = conformal.conformal_operator

    def counted(rows, columns, angles, flat):
        made.append((rows, columns, angles.size))
        return make(rows, columns, angles, flat)

    monkeypatch.setattr(conformal, "conformal_operator", counted)
    case = hollow_wheel(20.8, conformal=True)
    target = Target(0.05)
    first = _first(replace(case, dx=1.0, dy=1.0), 1e-6, {"certify": None}, target, 0.0)
    made.clear()
    found = _near(case, first, 1e-6, {"certify": None}, target)
    assert found.rounds > 1
    (patch,) = found.patches
    in_all = len(made)
    made.clear()
    _at_approaches([patch.patch], {"certify": None}, target, [{}])
    assert in_all == len(made) > 0
    cold, _ = _chosen(replace(patch.solution.scene, grid="auto"), {"certify": None}, target)
    bars = patch.solution.error_estimate.bars
    for name in ("Fx", "Fy"):
        assert abs(getattr(patch.solution, name) - getattr(cold, name)) < bars[name]
    assert patch.normal_force == pytest.approx(cold.normal_force, rel=1e-9)
    assert found.force[2] == pytest.approx(130e3, rel=2e-6)


@pytest.mark.long
def test_a_start_on_the_same_grid_has_the_approach_of_its_own_scene():
    """Pressure and tractions of another approach are a start, and no more."""
    _, scene = groove(0.4)
    deeper = replace(scene, approach=1.1 * scene.approach)
    known = vc.solve(deeper)
    options = SolveOptions.checked(deeper)
    found = solve_on_grid(deeper, options, vc.solve(scene))
    assert found.approach == known.approach
    assert found.normal_force == pytest.approx(known.normal_force, rel=1e-6)
    np.testing.assert_allclose(found.force, known.force, atol=1e-5 * known.normal_force)


def test_a_narrow_patch_is_the_same_on_a_plane_and_on_a_curved_surface():
    case = on_flange_root(position=Position(y=-2.0), vertical_force=10e3)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        planar = case.solve()
    curved = replace(case, conformal=True).solve()
    assert not planar.patches[0].patch.scene.conformal
    np.testing.assert_allclose(curved.force, planar.force, atol=2e-3 * 10e3)


test_what_does_not_go_with_it_is_refused = refusals(
    (lambda: on_flange_root(conformal="always"), "conformal"),
    (lambda: on_flange_root(conformal=True).solve(tangential="fastsim"), "tangential"),
    by="field",
)
