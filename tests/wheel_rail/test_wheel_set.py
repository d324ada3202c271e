"""Balance of loads on a wheel set: symmetry, power, free rolling, starting guesses, curves, and
what is refused.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.benchmarks.balance import wheel_set as random_wheel_set
from tests.scenes import refusals, refused
from tests.wheel_rail.conditions import (
    TRACK,
    WHEELSET,
    cone,
    flat_track,
    published,
    round_rail,
    round_wheel,
)
from varcontact.errors import NoContact, NotConverged, SceneError
from varcontact.kinematics import rotation
from varcontact.wheel_rail import (
    FrictionByAngle,
    Irregularity,
    Position,
    Profile,
    Track,
    Velocity,
    WheelSet,
    WheelSetOnTrack,
    flange_clearance,
    rolling_radius_difference,
)
from varcontact.wheel_rail.equilibrium import BroydenIterate
from varcontact.wheel_rail.wheel_set_balance import _HeldSideways, _moved_sideways

pytestmark = pytest.mark.filterwarnings("ignore")  # elements are few to be fast
ROLLING = Velocity(speed=20e3)


def wheel_set(y=0.0, yaw=0.0, **more):
    """The benchmark's profiles with 160 kN."""
    common = {
        "track": TRACK,
        "wheelset": WHEELSET,
        "velocity": ROLLING,
        "vertical_force": 160e3,
        "dx": 1.0,
        "dy": 1.0,
    }
    return WheelSetOnTrack(**common | {"position": Position(y=y, yaw=yaw)} | more)


@pytest.mark.long
def test_mirror_images():
    """Displaced and yawed to the other side in a curve to the other side, left and right are
    exchanged.
    """
    curve = replace(
        TRACK,
        curve_radius=400e3,
        right=Irregularity(y=1.0, z=0.3, roll=0.01, lateral=20.0, roll_rate=0.01),
    )
    mirrored = replace(curve, curve_radius=-400e3, right=Irregularity(), left=Irregularity(
        y=-1.0, z=0.3, roll=-0.01, lateral=-20.0, roll_rate=-0.01
    ))  # fmt: skip
    found = wheel_set(3.0, 0.002, track=curve, torque=-2e6).solve()
    other = wheel_set(-3.0, -0.002, track=mirrored, torque=-2e6).solve()
    for one, two in ((found.left, other.right), (found.right, other.left)):
        assert two.force == pytest.approx(one.force * [1, -1, 1], rel=1e-5, abs=1.0)
    assert other.position.roll == pytest.approx(-found.position.roll, rel=1e-5)
    assert other.velocity.pitch_rate == pytest.approx(found.velocity.pitch_rate, rel=1e-9)
    assert other.moment_on_wheelset == pytest.approx(
        found.moment_on_wheelset * [-1, 1, -1], abs=500.0
    )


def test_a_small_lateral_force_on_treads():
    """Treads bear it at a place that derivatives do not tell: the lateral force grows by 50 N on
    0.1 mm. Held there the wheel set bears it, and to the other side it goes as far.
    """
    track = Track(rail=Profile.rail_60e1(), cant=1 / 40, gauge=1435.0)
    wheelset = WheelSet(wheel=Profile.s1002(), radius=460.0, inside_distance=1360.0)
    given = {"track": track, "wheelset": wheelset, "friction": 0.3, "dx": 1.5, "dy": 1.5}
    free = ("y", "roll", "pitch_rate")
    found = [wheel_set(free=free, lateral_force=force, **given).solve() for force in (1e3, -1e3)]
    right, left = (each.position.y for each in found)
    assert left == pytest.approx(-right, rel=1e-4)
    held = wheel_set(right, free=free[1:], **given).solve()
    assert held.force[1] == pytest.approx(1e3, abs=1.0)


@pytest.mark.long
@pytest.mark.parametrize(
    ("yaw", "load"), [(0.0, 75.5e3), (-0.02, -80e3), (0.05, 40e3), (0.01, -149.4e3)]
)
def test_where_the_tread_hands_over_to_the_flange_loads_are_balanced(yaw, load):
    """There forces of the fast way jump by as much as the load, as its patches join, so that it has
    no balance. Held where it is found, the wheel set bears the load, and further out more of it;
    yawed to the flange and away from it.
    """
    free = ("y", "roll", "pitch_rate")
    track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    entries = {"yaw": yaw, "track": track, "wheelset": WheelSet(wheel=Profile.s1002())}
    found = wheel_set(free=free, lateral_force=load, **entries).solve()
    assert found.force[1] == pytest.approx(load, rel=1e-3)
    y = found.position.y
    held = wheel_set(y=y, **entries).solve()
    assert held.force[1] == pytest.approx(load, rel=0.01)
    beyond = wheel_set(y=y + float(np.copysign(0.01, load)), **entries).solve()
    assert beyond.force[1] / load > 1.02


@pytest.mark.long
def test_a_load_that_lifts_a_wheel_is_refused_so():
    """Its moment about the rail is larger than that of the axle's load."""
    with pytest.raises(SceneError, match="the loads lift the left wheel off its rail"):
        wheel_set(free=("y", "roll", "pitch_rate"), lateral_force=260e3).solve()


@pytest.mark.parametrize("balanced_at", [-20.0, -1.0, 0.0, 0.3, 7.0])
def test_a_displacement_is_bracketed(balanced_at):
    """Where it begins, beside it, at a bracket's end, and far away; the lateral force hardly
    changes.
    """
    tol = 1e-8

    def imbalance(x):
        others = x[1:] - np.tanh(x[0] / 5)
        lateral = 1e-4 * (balanced_at - x[0]) + 0.1 * others[0]
        return np.array([lateral, *others])

    start = np.array([0.0, 0.5, -0.5])
    held = _HeldSideways(imbalance, 0, BroydenIterate(start, imbalance(start), np.eye(3)), tol)
    found = _moved_sideways(held)
    assert found.largest <= tol
    assert found.x[0] == pytest.approx(balanced_at, abs=2e-4)


@pytest.mark.long
@pytest.mark.parametrize("torque", [0.0, -3e6])
def test_power_of_the_forces_is_friction_power_and_torques_are_balanced(torque):
    """The rails' forces take from the moving wheel set what slip dissipates, of creepages by the
    moving contact.
    """
    found = wheel_set(3.0, 0.003, torque=torque, dx=0.5, dy=0.5).solve()
    assert abs(found.moment_on_wheelset[1] + torque) < 1e-6 * 160e3 * 460
    assert abs(found.moment_on_wheelset[0]) < 1e-6 * 160e3 * 750
    assert found.force[2] == pytest.approx(160e3, rel=1e-6)
    deeper = 0.0
    body = found.left.case.body(found.z)
    velocity, turning = (body.rotation.T @ each for each in (body.velocity, body.angular_velocity))
    taken = -(found.force_on_wheelset @ velocity + found.moment_on_wheelset @ turning) / 1e3
    for wheel in found.wheels:
        for each in wheel.patches:
            # creepages are those of the wheel's particle in the rail
            arm = each.patch.approach * each.frame.normal
            deeper += (
                each.force_on_track @ np.cross(wheel.case.body(found.z).angular_velocity, arm) / 1e3
            )
    assert taken + deeper == pytest.approx(found.power, rel=2e-3)
    assert abs(deeper) < 0.1 * found.power
    assert found.force[0] * torque >= 0  # driving wheels push the rails backwards


@pytest.mark.long
@pytest.mark.parametrize("solver", ["estimate", "solve"])
def test_friction_power_of_a_wheel_set_that_slides_sideways(solver):
    """In full slip f N times the sliding velocity of the rigid bodies, without the work of N."""
    sliding = Velocity(speed=20e3, pitch_rate=-20e3 / 460.0, lateral=1000.0)
    found = getattr(wheel_set(5.0, velocity=sliding, friction=0.05, free=("roll",)), solver)()
    expected = normal = 0.0
    for wheel in found.wheels:
        for each in wheel.patches:
            moving = wheel.case.body(found.z).velocity_at(each.frame.origin) @ each.frame.axes
            expected += 0.05 * each.force[2] * np.hypot(*moving[:2]) / 1e3
            normal += each.force[2] * moving[2] / 1e3
    assert abs(normal) > 0.05 * expected
    assert found.power == pytest.approx(expected, rel=0.01)


@pytest.mark.long
def test_nadals_limit_is_that_of_the_face_of_the_flange():
    """70 degrees by EN 13715, on both sides, though the back of the flange is vertical and noise
    can turn it.
    """
    angle, f = np.radians(70.0), 0.3
    limit = (np.tan(angle) - f) / (1 + f * np.tan(angle))
    wheel = Profile.s1002()
    found = wheel_set(3.0, wheelset=replace(WHEELSET, wheel=wheel)).estimate()
    for side in ("left", "right"):
        assert found.y_over_q(side) / found.nadal(side) == pytest.approx(limit, rel=5e-3)
    coned = WheelSetOnTrack(
        track=flat_track(round_rail()), wheelset=WheelSet(wheel=cone()), vertical_force=160e3
    )
    assert np.isnan(coned.estimate().nadal("left"))


@pytest.mark.parametrize("shift", [-30.0, 5.0, 70.0])
def test_the_origin_of_a_wheels_profile_does_not_matter(shift):
    """With the place of the flange's back, such as of y that is counted from there."""
    moved = replace(WHEELSET, wheel=WHEELSET.profile.shifted(y=shift), flange_back=-70.0 + shift)
    found, like = (wheel_set(3.0, wheelset=each).estimate() for each in (moved, WHEELSET))
    for side in ("left", "right"):
        assert found.nadal(side) == pytest.approx(like.nadal(side), rel=1e-6)
    play, same = (flange_clearance(wheel_set().track, each) for each in (moved, WHEELSET))
    assert play.clearance == pytest.approx(same.clearance, abs=1e-6)


@pytest.mark.long
def test_loads_that_forces_jump_over_are_balanced_nearly():
    """Refused with the lateral force short by 6e-4 of the load, before."""
    case = replace(
        random_wheel_set(448225567),
        dx=1.5,
        dy=1.5,
        free=("y", "roll"),
        lateral_force=75695.24932405198,
        position=Position(y=-4.95558595644158, yaw=-0.003678196678606935),
    )
    with pytest.warns(UserWarning, match=r"balanced to 0.00064 only: forces jump there"):
        found = case.solve()
    assert 1e-5 < found.imbalance < 1e-3


def test_rails_beside_their_places_change_the_play():
    track = wheel_set().track
    wider = replace(track, left=Irregularity(y=-3.0), right=Irregularity(y=1.0))
    play = flange_clearance(track, WHEELSET)
    assert flange_clearance(wider, WHEELSET).clearance == pytest.approx(play.clearance + 2.0)
    rolled = replace(track, left=Irregularity(roll=0.01))
    refused(lambda: flange_clearance(rolled, WHEELSET), "track.left.roll")


@pytest.mark.long
def test_wheels_that_are_cones_roll_as_their_radii_tell():
    """Without slip both wheels together: the pitch rate is that of the mean of the radii, and
    forces are opposite.
    """
    case = wheel_set(0.0)
    found = case.solve()
    radii = [each.patches[0].patch.rolling_radius for each in found.wheels]
    assert radii[0] == pytest.approx(radii[1], abs=1e-9)
    assert -ROLLING.speed / found.velocity.pitch_rate == pytest.approx(radii[0], rel=2e-4)
    assert found.left.force == pytest.approx(found.right.force * [1, -1, 1], abs=1e-3)
    assert found.y_over_q("left") == pytest.approx(found.y_over_q("right"), abs=1e-8)


@pytest.mark.long
def test_a_free_wheel_set_in_a_curve_rolls_where_the_radii_make_up_for_it():
    """Redtenbacher: r_left - r_right = 2 s r/R with pure rolling, so that no yaw moment is left
    (straight, centred).
    """
    free = ("y", "yaw", "roll", "pitch_rate")
    track = replace(TRACK, curve_radius=800e3)
    found = wheel_set(track=track, free=free).estimate()
    places = [wheel.patches[0].frame.origin[1] for wheel in found.wheels]
    needed = (places[1] - places[0]) * 460.0 / 800e3
    assert -rolling_radius_difference(TRACK, WHEELSET, found.position.y) == pytest.approx(
        needed, rel=0.05
    )
    assert found.moment_on_wheelset == pytest.approx(np.zeros(3), abs=1.0)
    start = wheel_set(-6.0, 0.004, track=track, free=free).estimate()
    assert start.position.y == pytest.approx(found.position.y, abs=1e-6)
    assert start.position.yaw == pytest.approx(found.position.yaw, abs=1e-8)


STANDARD = {
    "track": Track(rail=Profile.rail_60e1(), cant=1 / 40), "wheelset": WheelSet(wheel=Profile.s1002())
}  # fmt: skip
STEERED = ("y", "yaw", "roll", "pitch_rate")


def in_curve(radius, **more):
    track = replace(STANDARD["track"], curve_radius=radius)
    return wheel_set(**STANDARD | {"track": track, "free": STEERED} | more)


@pytest.mark.long
def test_a_free_wheel_set_under_little_friction_in_a_sharp_curve():
    """At the flange root, within a hundredth of a millimetre; to the other side in the other
    curve.
    """
    found, other = (in_curve(radius, friction=0.15).estimate() for radius in (300e3, -300e3))
    assert found.imbalance < 1e-8
    assert found.position.y == pytest.approx(-5.0768, abs=1e-3)
    assert found.position.yaw == pytest.approx(-6.667e-4, abs=1e-6)
    assert other.position.y == pytest.approx(-found.position.y, abs=1e-7)
    assert other.position.yaw == pytest.approx(-found.position.yaw, abs=1e-9)


@pytest.mark.long
def test_a_refusal_names_the_moment_and_by_how_much_it_is_short():
    """Held in the middle of a curve, no yaw makes up for the radii; nothing that was not given is
    named.
    """
    case = in_curve(600e3, free=STEERED[1:])
    with pytest.raises(
        SceneError, match=r"yaw = .* the yaw_moment is short by -?\d.* N mm"
    ) as caught:
        case.estimate()
    assert caught.value.field == "yaw_moment"
    assert " y = " not in str(caught.value)


@pytest.mark.long
@pytest.mark.parametrize("load", [20.0, 2000.0])
def test_small_loads_at_the_flange(load):
    """Both wheels slip against each other: the pitch rate is between those of their radii."""
    found = wheel_set(8.0, **STANDARD, vertical_force=load).estimate()
    assert found.imbalance < 1e-6
    rates = []
    for wheel in found.wheels:
        radii = wheel.case.locus.radii[wheel.case.locus.gap.argmin()]
        rates.append(-ROLLING.speed / radii)
    assert min(rates) < found.velocity.pitch_rate < max(rates)


@pytest.mark.long
def test_the_balance_does_not_depend_on_where_the_search_begins():
    case = wheel_set(0.0, free=("y", "roll", "pitch_rate"), lateral_force=5e3, dx=1.6, dy=1.6)
    one = case.solve()
    other = replace(
        case, position=Position(y=-4.0, roll=0.01), velocity=Velocity(speed=20e3, pitch_rate=-40.0)
    ).solve()
    assert one.force[1] == pytest.approx(5e3, abs=1.0)
    assert other.position.y == pytest.approx(one.position.y, abs=1e-4)
    assert other.velocity.pitch_rate == pytest.approx(one.velocity.pitch_rate, rel=1e-7)


@pytest.mark.long
@pytest.mark.parametrize("y", [2.0, 8.0])
def test_wheel_set_of_the_benchmark(y):
    """Its 10 kN on each wheel need a roll moment against the lateral forces: with it, the published
    wheel set.
    """
    rows = [published(side, y) for side in ("left", "right")]
    moment, z = 0.0, np.mean([each["z_ws"] for each in rows])
    for each in rows:
        force = rotation(roll=each["angle"]) @ [each["fx"], each["fs"], each["fn"]]
        arm = [each["x"], each["y"] - y, each["z"] + 460.0 - z]
        moment += float(np.cross(arm, force)[0])
    case = wheel_set(
        position=Position(y=y, yaw=rows[0]["yaw"]), vertical_force=20e3, roll_moment=moment, free=("roll",),
        velocity=Velocity(speed=2000.0, pitch_rate=rows[0]["pitch_rate"]), dx=0.2, dy=0.2,
    )  # fmt: skip
    found = case.solve()
    assert found.position.roll == pytest.approx(rows[0]["roll"], abs=5e-6)
    for wheel, wanted in zip(found.wheels, rows, strict=True):
        (each,) = wheel.patches
        assert each.patch.location[1] == pytest.approx(wanted["y"], abs=0.05)
        assert each.normal_force == pytest.approx(wanted["fn"], rel=0.01)
        assert each.force[:2] == pytest.approx(
            [wanted["fx"], wanted["fs"]], abs=0.01 * 0.3 * wanted["fn"]
        )


@pytest.mark.long
def test_rails_that_yield():
    """Each is moved by its force over its stiffness, and the axle sinks with them."""
    stiff, found = (
        wheel_set(3.0, track=replace(TRACK, stiffness=each)).solve()
        for each in (None, (40e3, 80e3))
    )
    for wheel in found.wheels:
        moved = getattr(found.track, wheel.case.side)
        assert [40e3 * moved.y, 80e3 * moved.z] == pytest.approx(wheel.force[1:], abs=0.5)
    assert found.z - stiff.z == pytest.approx(1.0, abs=0.01)


@pytest.mark.long
def test_friction_by_region_and_by_side():
    """As everywhere where all coefficients are one; on a lubricated gauge face, tractions within
    its cone alone.
    """
    plain = wheel_set(8.0, 0.004).solve()
    alike = wheel_set(8.0, 0.004, friction=(0.3, FrictionByAngle((-0.1, 0.5), (0.3, 0.3)))).solve()
    assert alike.right.force == pytest.approx(plain.right.force, rel=1e-9)
    face = FrictionByAngle.regions(tread=0.3, gauge_corner=0.2, gauge_face=0.1)
    found = wheel_set(8.0, 0.004, friction=(0.3, face)).solve()
    (each,) = found.right.patches
    pressure = each.solution.pressure
    bound = np.asarray(each.solution.scene.friction) * pressure
    assert (np.hypot(*each.solution.traction) <= bound * (1 + 1e-9) + 1e-9 * pressure.max()).all()
    used = float(np.hypot(*each.force[:2]) / each.normal_force)
    assert (
        used
        < 0.6 * np.hypot(*plain.right.patches[0].force[:2]) / plain.right.patches[0].normal_force
    )
    # the track side is the steeper one
    assert np.all(np.diff(np.asarray(each.solution.scene.friction)[:, 0]) >= 0)


@pytest.mark.long
def test_gravitational_stiffness_of_circles():
    """Round wheels in round rails: a pendulum of the radii's difference, W/(2...) by the geometry
    of two arcs.
    """
    radius, wheel = 600.0, 500.0  # both convex: the wheel set is pushed off the middle
    track = flat_track(round_rail(radius))
    case = WheelSetOnTrack(
        track=track, wheelset=WheelSet(wheel=round_wheel(wheel)), vertical_force=160e3
    )
    found = case.estimate()
    # a displacement y turns the contact plane by y/(R_rail + R_wheel), and rolling of the axle is
    # of second order
    assert found.gravitational_stiffness() == pytest.approx(-160e3 / (radius + wheel), rel=0.02)


@pytest.mark.long
def test_wheel_sets_without_friction():
    """Normal forces alone; with friction on one rail, its wheel rolls, and the other one slips
    along.
    """
    found = wheel_set(3.0, friction=0.0).estimate()
    for each in found.patches:
        assert each.force[:2].tolist() == [0.0, 0.0]
    assert found.power == 0
    one_sided = wheel_set(3.0, friction=(0.0, 0.3)).estimate()
    (patch,) = one_sided.right.patches
    assert abs(patch.force[0]) < 1e-3 * 0.3 * 80e3
    assert -ROLLING.speed / one_sided.velocity.pitch_rate == pytest.approx(
        one_sided.right.case.locus.radii[one_sided.right.case.locus.gap.argmin()], rel=1e-3
    )


@pytest.mark.long
def test_wheel_sets_have_the_default_accuracy_and_its_error_bars():
    """As wheels, though each exact solution of the balance follows another one."""
    found = wheel_set(0.0, dx=None, dy=None, free=()).solve()
    for wheel in found.wheels:
        assert np.all(wheel.error[:2] > 0)
        assert np.all(wheel.error[:2] < 0.02 * 0.3 * 80e3)
    assert found.errors["z"] > 0


@pytest.mark.long
def test_error_bars_come_with_the_grids_that_are_chosen():
    found = wheel_set(3.0, dx=None, dy=None).solve(accuracy=0.05)
    exact = wheel_set(3.0, dx=0.4, dy=0.4).solve()
    assert np.all(found.error[:2] > 0)
    assert found.error[2] == 0
    for name, value in (
        ("z", exact.z - found.z),
        ("roll", exact.position.roll - found.position.roll),
    ):
        assert abs(value) < 2 * found.errors[name] + 1e-6
    assert "+-" in found.report()


@pytest.mark.long
@pytest.mark.parametrize(("more", "error", "words"), [
    ({"y": 25.0, "lateral_force": 500e3, "free": ("y", "roll", "pitch_rate")}, SceneError, "no position balances"),
    ({"torque": 30e6}, NotConverged, "torque = 3e.07 exceeds the friction limit, about 2.2"),
    ({"position": Position(y=3.0, roll=0.01), "free": ()}, SceneError, "left wheel is above .* add roll to free"),
    ({"roll_moment": 150e6}, SceneError, "lift the (left|right) wheel off"),
    ({"y": 100.0}, NoContact, "beside the rail"),
    ({"y": 7.0, "vertical_force": 20e3, "yaw": -0.03, "friction": 1.0}, NotConverged, "stands on its rail"),
    ({"track": replace(TRACK, gauge=1560.0)}, SceneError, "wheel is on its outer end, .* falls between the rails"),
    ({"y": -60.0}, SceneError, "right wheel is on its outer end, at y = 740"),
    ({"wheelset": replace(WHEELSET, inside_distance=1100.0)}, NoContact, "beside the rail"),
])  # fmt: skip
def test_loads_that_no_position_balances(more, error, words):
    with pytest.raises(error, match=words):
        wheel_set(**more).estimate()


@pytest.mark.long
def test_a_torque_a_little_beyond_the_friction_limit():
    """The fast way comes near the balance there, and forces no longer depend on the pitch rate."""
    with pytest.raises(NotConverged, match="exceeds the friction limit, about") as caught:
        wheel_set(torque=-1.005 * 0.3 * 160e3 * 460.0).solve()
    assert 0 < caught.value.residual < 0.02


@pytest.mark.long
def test_wheel_sets_run_on_the_tips_of_their_flanges():
    """Freely, with the radius there; on one of them, both wheels slip against each other."""
    wide = replace(WHEELSET, inside_distance=1420.0)
    found = wheel_set(wheelset=wide).estimate()
    for wheel in found.wheels:
        radius = wide.radius + wheel.case.wheelset.profile.z.max()
        assert -20e3 / found.velocity.pitch_rate == pytest.approx(radius, abs=0.5)
    displaced = wheel_set(30.0, wheelset=wide).estimate()  # the right flange alone
    assert displaced.imbalance < 1e-6
    assert displaced.left.force[0] == pytest.approx(-displaced.right.force[0], rel=0.1)


def test_wheel_that_friction_wedges_on_its_flange():
    """With friction 1 and a yaw that turns the flange off the rail, deeper means a lesser vertical
    force.
    """

    def level(roll):
        at = wheel_set(
            position=Position(y=7.5, yaw=-0.02, roll=roll),
            friction=1.0,
            free=(),
            z=0.0,
            vertical_force=None,
        )
        return at, [at.wheel(side, 0.0).touching for side in ("left", "right")]

    roll = brentq(lambda roll: float(np.diff(level(roll)[1]).item()), -0.015, 0.0, xtol=1e-9)
    case, (_, touching) = level(roll)
    right = replace(case, z=touching + 0.05).wheel("right", touching + 0.05)
    deeper = replace(right, z=touching + 0.1)
    assert deeper.estimate().force[2] < right.estimate().force[2] < 0
    for solver in ("estimate", "solve"):
        with pytest.raises(SceneError, match=r"right wheel is wedged: friction lifts it"):
            getattr(replace(case, z=touching + 0.05), solver)()
    borne = replace(case, friction=0.05, z=touching + 0.05).solve()
    assert borne.right.force[2] > 0
    assert borne.imbalance == 0


def test_a_mirrored_rail_is_warned_of_in_a_wheel_set():
    leaning = replace(TRACK.rail, y=-TRACK.rail.y)
    with pytest.warns(UserWarning, match="leans to the field side"):
        wheel_set(track=replace(TRACK, rail=leaning), free=()).estimate()


test_what_is_refused = refusals(
    ({"free": ("y", "lateral")}, "one quantity for each load"),
    ({"free": "y"}, "tuple of names"),
    ({"free": ("pitch_rate", "speed")}, "only their ratio"),
    ({"torque": 1e6, "free": ("roll",)}, "torque: nothing is free to balance it"),
    ({"z": 0.1}, "vertical_force"),
    ({"friction": (0.3, -1.0)}, "friction"),
    ({"friction": 0.0, "free": ("yaw",)}, "nothing else is determined where friction = 0"),
    ({"friction": 0.0, "torque": 1e6}, "torque .* 0 where friction = 0"),
    of=wheel_set,
)


test_tracks_that_are_refused = refusals(
    ({"curve_radius": 500.0}, "larger than the gauge"),
    ({"stiffness": 3e4}, "stiffness"),
    of=partial(replace, TRACK),
)
