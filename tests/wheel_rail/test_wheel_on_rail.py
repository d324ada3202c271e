"""Patches solved: Hertz's closed form, the benchmark's forces, the load, velocities of particles,
and warnings.
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from tests.scenes import refusals
from tests.wheel_rail.conditions import (
    RAIL,
    TRACK,
    WHEEL,
    benchmark,
    circles,
    manchester,
    published,
    wheel,
)
from varcontact import reference
from varcontact.errors import NotConverged, SceneError
from varcontact.kinematics import rotation
from varcontact.scene.bodies import Bodies
from varcontact.wheel_rail import (
    CoarseElements,
    ConformalContact,
    Position,
    Profile,
    Track,
    Velocity,
    WheelSet,
)

# elements are few to be fast
pytestmark = pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.CoarseElements")


def test_two_circles_are_hertz_contact():
    """The load at an angle: area, peak pressure and approach of the combined curvatures."""
    case = circles(y=-12.0, dx=0.4, dy=0.4)
    found = case.solve()
    (each,) = found.patches
    angle = each.patch.angle
    assert found.force[2] == pytest.approx(80e3, rel=1e-6)
    rolling = each.patch.rolling_radius / np.cos(angle)
    hertz = reference.hertz(rolling, 1 / (1 / 300 + 1 / 500), case.bodies, force=each.normal_force)
    assert each.peak_pressure == pytest.approx(hertz.peak_pressure, rel=0.01)
    assert each.patch.approach == pytest.approx(hertz.approach, rel=0.01)
    assert each.half_width == pytest.approx(hertz.b, abs=0.4)


@pytest.mark.parametrize(("side", "y"), [("left", 4.5), ("right", 2.0), ("right", 8.0)])
def test_the_benchmarks_forces(side, y):
    """CONTACT's on the same grid of 0.2 mm: normal 0.1 %, tangential 0.1 % of f Fn, peak pressure
    0.5 %.
    """
    wanted = published(side, y)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConformalContact)
        found = benchmark(wanted).solve()
    (each,) = found.patches
    assert found.z == pytest.approx(wanted["z_ws"], abs=5e-4)
    assert each.normal_force == pytest.approx(wanted["fn"], rel=1e-3)
    assert each.force[:2] == pytest.approx(
        [wanted["fx"], wanted["fs"]], abs=1e-3 * 0.3 * wanted["fn"]
    )
    assert each.peak_pressure == pytest.approx(wanted["pmax"], rel=5e-3)
    assert found.force[2] == pytest.approx(10e3, rel=1e-6)


def test_the_benchmarks_position_between_tread_and_flange():
    """Two overlaps 6 mm apart, which feel each other in part: on coarser elements, CONTACT's place
    and forces.
    """
    wanted = published("right", 5.0)
    found = benchmark(wanted, dx=0.5, dy=0.5).solve()
    (each,) = found.patches
    assert len(each.patch.interactions) == 1
    assert each.patch.location == pytest.approx([wanted["x"], wanted["y"], wanted["z"]], abs=0.03)
    assert each.normal_force == pytest.approx(wanted["fn"], rel=1e-3)
    assert each.force[:2] == pytest.approx(
        [wanted["fx"], wanted["fs"]], abs=5e-3 * 0.3 * wanted["fn"]
    )


@pytest.mark.long
def test_normal_forces_alone_bear_the_load_where_that_is_asked_for():
    case = wheel(2.0, yaw=0.005, dx=0.5, dy=0.5)
    plain, all_of_it = replace(case, with_friction=False).solve(), case.solve()
    assert plain.patches[0].normal_force * np.cos(plain.patches[0].patch.angle) == pytest.approx(
        80e3, rel=1e-6
    )
    assert all_of_it.force[2] == pytest.approx(80e3, rel=1e-6)
    assert plain.force[2] != pytest.approx(80e3, rel=1e-3)
    again = replace(case, vertical_force=None, z=plain.z).solve()
    assert again.rounds == 0
    assert again.force == pytest.approx(plain.force, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("more", [{}, {"z": 0.25, "vertical_force": None}], ids=["load", "height"])
def test_the_solution_of_another_position_changes_nothing_as_a_start(more):
    common = {"yaw": 0.003, "dx": 1.0, "dy": 1.0, **more}
    case = wheel(3.0, **common)
    alone = case.solve(tol=1e-9)
    for y in (-1.0, 2.99):
        found = case.solve(tol=1e-9, start=wheel(y, **common).solve())
        assert found.z == pytest.approx(alone.z, abs=1e-9)
        assert found.force == pytest.approx(alone.force, rel=1e-7)
    assert found.rounds <= alone.rounds
    # of the last height, to which the one before may have been nearer
    counts = [each.patches[0].solution.iterations["tangential"] for each in (found, alone)]
    assert counts[0] <= counts[1] + 1


@pytest.mark.filterwarnings("ignore::varcontact.wheel_rail.CoarseElements")
def test_the_benchmark_takes_three_heights():
    """One far from the load, one near it, which tells what tractions bear, and the last."""
    rows = [row for row in manchester() if row["side"] == "left" and row["y_ws"] % 2 == 1]
    assert [benchmark(row, dx=1.0, dy=1.0).solve().rounds for row in rows] == [3] * 5


@pytest.mark.long
def test_a_flange_contact_takes_few_heights():
    """At 69 degrees the lateral creepage bears most of the load, and the force is far from a power
    of the depth.
    """
    case = wheel(-7.0, -6e-4, 0.026, side="left", vertical_force=65e3, dx=1.0, dy=1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConformalContact)
        warnings.filterwarnings("ignore", "normal forces of")
        found = case.solve()
    assert found.force[2] == pytest.approx(65e3, rel=1e-6)
    assert found.rounds <= 12


@pytest.mark.parametrize("seed", range(6))
def test_any_position_bears_its_load(seed):
    """Random places, sides and loads: the load is met, nothing pulls, and the tractions obey
    Coulomb's law.
    """
    rng = np.random.default_rng(seed)
    y, roll, yaw = rng.uniform(-10, 10), rng.normal() * 3e-3, rng.uniform(-0.02, 0.02)
    force = 10 ** rng.uniform(3.5, 5.0)
    case = wheel(
        y, roll, yaw, side=("left", "right")[seed % 2], vertical_force=force, dx=1.0, dy=1.0
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConformalContact)
        warnings.filterwarnings("ignore", "normal forces of")
        found = case.solve()
    assert found.force[2] == pytest.approx(case.vertical_force, rel=1e-6)
    for each in found.patches:
        assert each.solution.pressure.min() >= 0
        tangential = np.hypot(*each.solution.traction)
        assert np.all(tangential <= 0.3 * each.solution.pressure * (1 + 1e-7))
        assert not each.solution.pressure[[0, -1]].any()
        assert not each.solution.pressure[:, [0, -1]].any()


@pytest.fixture(scope="module")
def two_patches():
    """Tread and flange root, apart."""
    return wheel(
        5.0, -3e-4, 0.012, vertical_force=10e3, join=3.0, separate=3.0, dx=0.5, dy=0.5
    ).solve()


def test_forces_in_the_frames_belong_together(two_patches):
    found = two_patches
    assert len(found.patches) == 2
    assert found.patches[0].patch.location[1] < found.patches[1].patch.location[1]
    total = np.zeros(3)
    for each in found.patches:
        local = each.patch.frame.axes.T @ each.force_on_track
        assert local == pytest.approx([*each.solution.force, each.solution.normal_force])
        total += each.force_on_track
    assert found.force == pytest.approx(total)
    axes = found.case.position.rotation
    assert found.force_on_wheelset == pytest.approx(-axes.T @ total)
    # the moment, from every element's traction on its own
    centre = np.array([0.0, 5.0, found.z - 460.0])
    moment = np.zeros(3)
    for each in found.patches:
        sol, frame = each.solution, each.patch.frame
        x, y = np.meshgrid(sol.grid.x, sol.grid.y)
        points = frame.globally(np.stack([x, y, 0 * x], axis=-1))
        tractions = np.stack([*sol.traction, sol.pressure], axis=-1) @ frame.axes.T * sol.grid.area
        moment -= np.cross(points - centre, tractions).sum(axis=(0, 1))
    assert found.moment_on_wheelset == pytest.approx(axes.T @ moment, rel=1e-9)


@pytest.mark.long
def test_solutions_of_left_and_right_are_mirror_images():
    """Forces, moments and fields, with a seam between tread and flange root."""
    right, left = (
        wheel(
            5.0 * sign, -3e-4 * sign, 0.012 * sign, side=side, vertical_force=10e3,
            velocity=Velocity(speed=2e3, lateral=3.0 * sign, yaw_rate=1e-3 * sign), dx=0.6, dy=0.6,
        ).solve()
        for side, sign in (("right", 1), ("left", -1))
    )  # fmt: skip
    assert len(right.patches[0].patch.interactions) == len(left.patches[0].patch.interactions) == 1
    assert left.force == pytest.approx(right.force * [1, -1, 1], rel=1e-6)
    assert left.moment_on_wheelset == pytest.approx(
        right.moment_on_wheelset * [-1, 1, -1], rel=1e-6
    )
    one, other = right.patches[0].solution, left.patches[0].solution
    assert other.pressure == pytest.approx(one.pressure[::-1], abs=1e-6 * one.pressure.max())
    mirrored = one.traction[:, ::-1] * np.array([1, -1])[:, None, None]
    assert other.traction == pytest.approx(mirrored, abs=1e-5 * one.traction_bound.max())


def test_patches_nearer_than_the_distance_are_one():
    case = wheel(5.0, roll=-3e-4, yaw=0.012)
    z = case.touching + 0.03
    apart, together = (
        replace(case, join=1.0, separate=1.0).patches(z),
        replace(case, separate=20.0).patches(z),
    )
    assert (len(apart), len(together)) == (2, 1)
    assert apart[0].location[1] < together[0].location[1] < apart[1].location[1]


def test_creepages_are_the_velocities_of_particles_followed_in_time():
    """The wheel set's place by its angles as functions of time, without its rigid body."""
    velocity = Velocity(
        speed=2000.0, pitch_rate=-4.3, lateral=15.0, vertical=-4.0, roll_rate=0.02, yaw_rate=0.03
    )
    position = Position(y=3.0, roll=2e-3, yaw=0.01)
    case = wheel(position=position, velocity=velocity)
    z = case.touching + 0.05
    (patch,) = case.patches(z)

    def place(time, pitching):
        axes = rotation(
            roll=position.roll + velocity.roll_rate * time,
            yaw=position.yaw + velocity.yaw_rate * time,
        )
        centre = np.array(
            [
                velocity.speed * time,
                position.y + velocity.lateral * time,
                z - 460.0 + velocity.vertical * time,
            ]
        )
        return axes @ rotation(pitch=velocity.pitch_rate * time * pitching), centre

    def followed(particle, pitching=1.0, step=1e-5):
        axes, centre = place(0.0, pitching)
        own = axes.T @ (particle - centre)
        ends = []
        for time in (-step, step):
            axes, centre = place(time, pitching)
            ends.append(axes @ own + centre)
        return (ends[1] - ends[0]) / (2 * step)

    axes = patch.frame.axes
    particle = patch.frame.globally([0.0, 0.0, patch.approach])
    wheel_velocity, carried = axes.T @ followed(particle), axes.T @ followed(particle, pitching=0.0)
    speed = (carried[0] - (wheel_velocity - carried)[0]) / 2
    found = patch.creepage
    assert found.speed == pytest.approx(speed, rel=1e-8)
    assert found.vx == pytest.approx(-wheel_velocity[0] / speed, abs=1e-8)
    assert found.vy == pytest.approx(-wheel_velocity[1] / speed, abs=1e-8)
    beside = patch.frame.globally([0.0, 1.0, patch.approach])
    # minus the rate of rotation about the normal
    turn = (axes.T @ (followed(beside) - followed(particle)))[0]
    assert found.spin == pytest.approx(turn / speed, abs=1e-9)


@pytest.mark.parametrize(
    ("sides", "said"),
    [
        (
            {"dx": 0.5, "dy": 0.5},
            ["with dy = 0.5 mm the patch at y = 719 mm is 1 element wide: too few"],
        ),
        (
            {"dx": 6.0, "dy": 0.2},
            ["with dx = 6 mm the patch at y = 719 mm is 3 elements long: too few"],
        ),
        ({"dx": 0.4, "dy": 0.2}, []),
    ],
)
def test_few_elements_are_said_and_their_forces_hold(sides, said):
    """A flange, some 1 mm wide: against CONTACT's forces on elements of 0.2 mm."""
    wanted = published("right", 7.0)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = benchmark(wanted, **sides).solve()
    told = [str(each.message) for each in caught if each.category is CoarseElements]
    assert [text[: len(start)] for text, start in zip(told, said, strict=True)] == said
    assert all(text.endswith("for 4 elements or more") for text in told)
    (each,) = found.patches
    assert each.force[:2] == pytest.approx(
        [wanted["fx"], wanted["fs"]], abs=0.02 * 0.3 * wanted["fn"]
    )


test_a_wrong_name_is_told_the_right_one = refusals(
    (lambda: wheel(load=1e4), "WheelOnRail has no load: write vertical_force"),
    (lambda: Track(rail=RAIL, inclination=0.05), "Track has no inclination: write cant"),
    (
        lambda: WheelSet(wheel=WHEEL, nominal_radius=1.0),
        "WheelSet has no nominal_radius: write radius",
    ),
    (lambda: Position(z=0.1), "Position has no z: write z, or vertical_force, of WheelOnRail"),
    (lambda: Velocity(sped=1.0), r"Velocity has no sped \(did you mean speed\?\)"),
)


def test_a_profile_may_end_beside_the_contact():
    """Here 2 and 4 mm from it, which the undeformed bodies overlap; nearer ends are refused."""
    case = wheel(3.0, dx=0.5, dy=0.5)
    whole = case.solve()
    (patch,) = whole.patches
    contact = (patch.solution.pressure > 0).any(axis=1)
    edge = patch.patch.on_wheel[0] + patch.solution.grid.y[contact].max()
    for beyond in (2.0, 4.0):
        shorter = case.wheelset.profile.trimmed(y=(-80.0, edge + beyond))
        found = replace(case, wheelset=replace(case.wheelset, wheel=shorter)).solve()
        assert found.force == pytest.approx(whole.force, rel=1e-3)
    shortest = case.wheelset.profile.trimmed(y=(-80.0, edge - 1.0))
    with pytest.raises(SceneError, match="reaches the end of a profile"):
        replace(case, wheelset=replace(case.wheelset, wheel=shortest)).solve()


def test_a_load_that_cannot_be_met_exactly_says_so():
    with pytest.raises(NotConverged, match="no height of the axle was found that balances 80000 N"):
        wheel(2.0, dx=2.0, dy=2.0).solve(tol=1e-90)
    with pytest.raises(NotConverged, match="heights are rounded: give a larger vertical_force"):
        wheel(2.0, vertical_force=1e-5).solve()


def test_a_wheel_that_friction_lifts_is_refused():
    """Beyond Nadal's limit, tan(angle) < f for a wheel that slides up: no height bears the load."""
    climbing = wheel(7.0, yaw=-0.02, friction=0.6, vertical_force=10e3, dx=1.0, dy=0.5)
    said = r"no height of the axle balances vertical_force = 10000 N: friction lifts the rail .* \(together -\S+ N\)"
    for do in (climbing.solve, climbing.estimate):
        with pytest.raises(SceneError, match=said):
            do()


@pytest.mark.long
def test_normal_forces_far_larger_than_the_load_are_said():
    """80 kN on a flange at 69 degrees, borne by more than twice as much; on the tread nothing is
    said.
    """
    flange = wheel(7.0, dx=1.0, dy=0.5)
    with pytest.warns(
        UserWarning, match=r"normal forces of \S+ N carry the load of 8e\+04 N, .* 6\d\.\d degrees"
    ):
        found = flange.solve()
    assert found.patches[0].normal_force > 2 * 80e3
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wheel(3.0).solve()


@pytest.mark.parametrize("G", [82e9, (82e9, 80e9), (82e9, 82e3), (82e3, 82e9)])
def test_moduli_in_pascal_are_refused(G):
    with pytest.raises(
        SceneError, match=r"bodies\.G: \d.*e\+\d+ N/mm\^2 is stiffer than any material"
    ):
        wheel(bodies=Bodies(G=G, nu=0.28))
    assert wheel(bodies=Bodies(G=535e3, nu=0.07)).bodies.G == 535e3  # diamond
    assert wheel(bodies=Bodies(G=(np.inf, 82e3), nu=(0.5, 0.28))).bodies.G == (np.inf, 82e3)


test_bad_dimensions_and_velocities_are_refused = refusals(
    (
        lambda: WheelSet(wheel=WHEEL, radius=0.46),
        r"wheelset\.radius.* in millimetres: .* leaves -2\.\d+ mm",
    ),
    (
        lambda: WheelSet(wheel=replace(WHEEL, y=WHEEL.y + 70.0)),
        r"wheelset\.flange_back.* its tip is at y = 1",
    ),
    (lambda: WheelSet(wheel=WHEEL, flange_back=70.0), "its tip is at"),
    (
        lambda: Velocity(speed=20e3, pitch_rate=43.0),
        r"velocity\.pitch_rate.* negative in rolling forward",
    ),
    (
        lambda: wheel(velocity=Velocity(yaw_rate=10.0)).solve(),
        r"velocity.* does not roll forwards, .* -\d",
    ),
)


@pytest.mark.long
def test_the_picture_has_both_profiles_and_each_patch(two_patches):
    figure = two_patches.plot()
    profiles, *panels = figure.axes
    labels = {line.get_label() for line in profiles.get_lines()}
    assert {"rail", "wheel", "contact patch"} <= labels
    numbers = {text.get_text() for text in profiles.texts if text.get_text()}
    assert numbers == {"1", "2"}
    assert sum(ax.get_title().startswith("Patch") for ax in panels) == 2
    assert "yaw = 12 mrad" in profiles.get_title()


def test_a_rail_measured_on_its_gauge_side_alone_tells_which_side_it_is():
    """Mirrored it goes down on the field side alone, and has no gauge face to measure at."""
    upright = Profile.rail_60e1()
    measured = upright.trimmed(y=(-40.0, 25.0))
    assert measured.exchanged_sides == ""
    mirrored = Profile(y=-measured.y, z=measured.z, kind="rail")
    words = "goes down by 36 mm on the field side, 2.02 on the other, so its gauge side is probably"
    assert words in mirrored.exchanged_sides
    with pytest.raises(SceneError, match=f"gauge_height = 14.0 .* at most 2.02 mm.*{words}"):
        _ = Track(rail=mirrored).origin
    with pytest.warns(UserWarning, match=words):
        wheel(track=Track(rail=mirrored, gauge_height=0.0), dx=2.0, dy=1.0).estimate()


def test_a_rail_with_its_sides_exchanged_is_told():
    """The benchmark's leans inwards by 1:40; upright ones say nothing, nor worn gauge corners."""
    mirrored = wheel(track=Track(rail=Profile(y=-RAIL.y, z=RAIL.z, kind="rail")), dx=2.0, dy=1.0)
    for do in (mirrored.solve, mirrored.estimate):
        with pytest.warns(
            UserWarning,
            match=r"leans to the field side by 1:4\d, so its gauge side is probably on the",
        ):
            do()
    upright = Profile.rail_60e1()
    worn = Profile(y=upright.y, z=upright.z + 0.1 * np.maximum(-10.0 - upright.y, 0.0), kind="rail")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for rail in (RAIL, upright, worn):
            wheel(track=Track(rail=rail)).estimate()


@pytest.mark.long
def test_profiles_too_rough_to_follow_are_told():
    """Noise of half a millimetre: every wheel has an answer that bears its load, or is told what to
    do.
    """
    said = []
    for seed in range(12):
        noise = 0.5 * np.random.default_rng(seed).normal(size=RAIL.z.size)
        case = wheel(
            2.0, track=replace(TRACK, rail=Profile(y=RAIL.y, z=RAIL.z + noise, kind="rail")), dy=1.0
        )
        for do in (case.solve, case.estimate):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", UserWarning)
                    found = do()
            except SceneError as error:
                said.append(str(error))
            else:
                assert np.isfinite(found.force).all()
    known = "a profile is too rough", "give smaller ones", "end of a profile"
    assert all(any(words in each for words in known) for each in said)
    assert all(any(words in each for each in said) for words in known[:2])
