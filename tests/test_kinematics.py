"""Rigid bodies against particles followed in time, and the linearised wheel set against the exact
one.
"""

import math

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact import kinematics as kin

rng = np.random.default_rng(1)


def random_body(rng, reach=1.0):
    return kin.RigidBody(
        position=rng.normal(size=3) * reach,
        rotation=kin.rotation(*rng.normal(size=3)),
        velocity=rng.normal(size=3),
        angular_velocity=rng.normal(size=3),
    )


def rolling_pair(rng):
    """A body that rolls along x over another, and the contact's frame, all of it a little askew."""
    frame = kin.Frame(rng.normal(size=3), kin.rotation(*(0.2 * rng.normal(size=3))))
    backwards = -frame.axes[:, 0] * 10
    bodies = [
        kin.RigidBody(
            position=frame.origin + rng.normal(size=3),
            velocity=backwards + 0.3 * rng.normal(size=3),
            angular_velocity=0.1 * rng.normal(size=3),
        )
        for _ in range(2)
    ]
    return bodies, frame


def test_velocities_are_the_change_of_the_particles_positions():
    step = 1e-5
    for _ in range(5):
        body, particles = random_body(rng), rng.normal(size=(4, 3))
        before, after = (body.after(t).globally(particles) for t in (-step, step))
        followed = (after - before) / (2 * step)
        assert np.abs(followed - body.velocity_at(body.globally(particles))).max() < 1e-9


def test_local_and_global_points_are_each_others_inverse():
    body, points = random_body(rng), rng.normal(size=(6, 3))
    assert np.abs(body.locally(body.globally(points)) - points).max() < 1e-14
    frame = kin.Frame(rng.normal(size=3), kin.rotation(0.3, 0.4, 0.5))
    assert np.abs(frame.locally(frame.globally(points)) - points).max() < 1e-14


def test_creepages_are_the_difference_of_the_particles_displacements():
    """Particles of both bodies near the contact, followed in time: vx - spin y, vy + spin x."""
    step = 1e-6
    for seed in range(5):
        (first, second), frame = rolling_pair(np.random.default_rng(seed))
        found = kin.creepages(first, second, frame)
        x, y = 0.3, -0.2
        point = frame.globally([x, y, 0.0])
        moved = [body.after(step).globally(body.locally(point)) - point for body in (first, second)]
        apart = frame.axes.T @ (moved[0] - moved[1]) / (step * found.speed)
        assert apart[0] == pytest.approx(found.vx - found.spin * y, abs=1e-5)
        assert apart[1] == pytest.approx(found.vy + found.spin * x, abs=1e-5)
        together = -(frame.axes.T @ (moved[0] + moved[1]))[0] / (2 * step)
        turning = (first.angular_velocity + second.angular_velocity) / 2
        x_slope = -np.cross(turning, point - frame.origin) @ frame.axes[:, 0]
        assert together - x_slope == pytest.approx(found.speed, rel=1e-5)


def test_a_moving_observer_sees_the_same_creepages():
    (first, second), frame = rolling_pair(np.random.default_rng(3))
    drift = np.array([3.0, -2.0, 1.0])
    moved = [
        kin.RigidBody(
            position=b.position, velocity=b.velocity + drift, angular_velocity=b.angular_velocity
        )
        for b in (first, second)
    ]
    before = kin.creepages(first, second, frame)
    after = kin.creepages(*moved, frame, frame_velocity=drift)
    assert (after.vx, after.vy, after.spin) == pytest.approx(
        (before.vx, before.vy, before.spin), rel=1e-12
    )


def exact_creepages(motion, side, roll=0.0):
    """Of a wheel set in the frame of section 2.2.3 (z up, y left), from the rigid bodies
    themselves.
    """
    sign = 1 if side == 0 else -1
    b, V = motion.half_gauge, motion.speed
    axle = kin.rotation(roll=roll, yaw=motion.yaw)
    spinning = axle @ [0.0, motion.angular_velocity, 0.0] + [0.0, 0.0, motion.yaw_rate]
    height = sum(motion.radii) / 2
    wheelset = kin.RigidBody(
        position=[0.0, 0.0, height],
        velocity=[V, motion.lateral_velocity, 0.0],
        angular_velocity=spinning,
    )
    rail = kin.RigidBody(position=[0.0, 0.0, 0.0])
    contact = np.array([0.0, sign * b, height - motion.radii[side]])
    frame = kin.Frame(contact, kin.rotation(roll=sign * motion.angles[side]))
    carried = wheelset.velocity + np.cross([0.0, 0.0, motion.yaw_rate], contact - wheelset.position)
    return kin.creepages(wheelset, rail, frame, frame_velocity=carried)


def test_the_linearised_wheel_set_is_the_limit_of_the_exact_one():
    """Errors fall with the square of the size of the motion: (135) to (139), with the factor 1/2
    put right.
    """
    V, R, b = 20.0, 0.5, 0.75
    errors = []
    for small in (1e-2, 1e-3):
        motion = kin.WheelSetMotion(
            speed=V,
            angular_velocity=V / R * (1 + 0.3 * small),
            radii=(R * (1 + small), R * (1 - 0.5 * small)),
            half_gauge=b,
            angles=(2 * small, small),
            yaw=0.7 * small,
            yaw_rate=0.4 * small * V,
            lateral_velocity=-0.2 * small * V,
        )
        worst = 0.0
        for side, linear in enumerate(motion.creepages):
            exact = exact_creepages(motion, side)
            for name in ("vx", "vy", "spin"):
                worst = max(worst, abs(getattr(linear, name) - getattr(exact, name)))
        errors.append(worst)
    assert errors[0] < 20 * 1e-2**2
    assert errors[1] < errors[0] / 50


def test_klingel_rolling_has_no_creep_and_the_papers_period():
    gamma, R, b = 1 / 40, 0.5, 0.715
    assert kin.klingel_wavelength(gamma, R, b) == pytest.approx(23.8, abs=0.05)
    assert (100 / 3.6) / kin.klingel_wavelength(gamma, R, b) == pytest.approx(1.17, abs=0.005)
    # y'' = -(omega^2 gamma R / b) y, one wavelength later it is where it was
    V, y, yaw = 1.0, 0.003, 0.0
    steps = 20000
    dt = kin.klingel_wavelength(gamma, R, b) / V / steps
    for _ in range(steps):
        yaw -= dt / 2 * V * gamma * y / (R * b)
        y += dt * V * yaw
        yaw -= dt / 2 * V * gamma * y / (R * b)
    assert y == pytest.approx(0.003, rel=1e-6)
    assert abs(yaw) < 1e-8


def test_the_ball_between_planes():
    """The components 2 N gamma less the force of spin gamma/R at both contacts: by Hertz and
    Kalker, and solved for.
    """
    N, gamma, nu, G, R = 2.0, 0.1, 0.25, 3e4, 1.5
    bodies, grid = vc.Bodies(G=G, nu=nu), vc.Grid(nx=16, ny=16)
    scene = make_scene(
        vc.Paraboloids(Rx=R, Ry=R), N, vc.Steady(spin=gamma / R), grid, np.inf, bodies
    )
    cubed = 3 * N * R * (1 - nu) / (4 * G)
    assert scene.hertz.a**3 == pytest.approx(cubed, rel=1e-12)
    by_spin = G * cubed * vc.no_slip_coefficients(1.0, nu).C23 * gamma / R
    found = kin.ball_between_planes(N, gamma, nu)
    assert found == pytest.approx(2 * (N * gamma - by_spin), rel=1e-3)
    solved = vc.solve(scene.second_order(), certify=None).Fy
    assert found == pytest.approx(2 * (N * gamma + solved), rel=0.015)


def test_at_the_spin_pole_nothing_slips():
    vx, vy, spin = 0.003, -0.001, 0.4
    x, y = kin.spin_pole(vx, vy, spin)
    assert vx - spin * y == pytest.approx(0, abs=1e-18)
    assert vy + spin * x == pytest.approx(0, abs=1e-18)


def test_distance_along_the_normal():
    normal = np.array([0.0, 0.6, 0.8])
    assert kin.distance(2 * normal, np.zeros(3), normal) == pytest.approx(2)
    assert kin.distance(np.zeros((4, 3)), np.ones((4, 3)), normal) == pytest.approx(
        -1.4 * np.ones(4)
    )


WHEEL_SET = {"speed": 20.0, "angular_velocity": 40.0, "radii": (0.5, 0.5), "half_gauge": 0.7}
ORIGIN = np.zeros(3)


@pytest.mark.parametrize(
    ("make", "field", "said"),
    [
        (
            lambda: kin.RigidBody(position=[0.0, 0.0]),
            "body.position",
            r"shape \(2,\).* three numbers",
        ),
        (lambda: kin.RigidBody(position=[0.0, 0.0, math.nan]), "body.position[2]", "nan .*finite"),
        (
            lambda: kin.RigidBody(position=ORIGIN, rotation=2 * np.eye(3)),
            "body.rotation",
            "orthonormal",
        ),
        (lambda: kin.Frame(ORIGIN, np.diag([1.0, 1.0, -1.0])), "frame.axes", "right-handed"),
        (
            lambda: kin.creepages(
                *2 * [kin.RigidBody(position=ORIGIN)], kin.Frame(ORIGIN, np.eye(3))
            ),
            "frame",
            "do not roll along x .*velocity is 0, .*turn the frame, or give .* frame_velocity",
        ),
        (lambda: kin.spin_pole(1.0, 1.0, 0.0), "spin", "0.0 .*not zero"),
        (lambda: kin.klingel_wavelength(0.0, 1.0, 1.0), "conicity", "0.0 .*positive"),
        (
            lambda: kin.WheelSetMotion(**WHEEL_SET | {"speed": 0.0}),
            "motion.speed",
            "0.0 .*positive",
        ),
        (
            lambda: kin.WheelSetMotion(**WHEEL_SET | {"radii": (0.5,) * 3}),
            "motion.radii",
            r"\(3,\).*two numbers, of the",
        ),
        (
            lambda: kin.WheelSetMotion(**WHEEL_SET | {"radii": 0.5}),
            "motion.radii",
            r"\(\).* two numbers",
        ),
        (
            lambda: kin.WheelSetMotion(**WHEEL_SET | {"angles": (0.1,)}),
            "motion.angles",
            r"\(1,\).* two numbers",
        ),
        (lambda: kin.ball_between_planes(2.0, 0.1, 0.6), "nu", "0.6 "),
    ],
)
def test_bad_input_is_refused(make, field, said):
    refused(make, field, match=said)


def test_twin_discs():
    """Slip and speed of discs by their surface speeds; a skew axis drags across."""
    motion = kin.twin_discs(0.0235, 0.0240, 41.9, 40.0)
    speeds = 41.9 * 0.0235, 40.0 * 0.0240
    assert motion.speed == pytest.approx(np.mean(speeds), rel=1e-14)
    assert motion.vx == pytest.approx((speeds[1] - speeds[0]) / np.mean(speeds), rel=1e-12)
    assert (motion.vy, motion.spin) == (0.0, 0.0)
    skew = kin.twin_discs(0.0235, 0.0235, 40.0, 40.0, skew=1e-3)
    assert skew.vy == pytest.approx(-1e-3, rel=1e-6)
    assert abs(skew.vx) < 1e-6
    for field, entries in (
        ("R1", (0.0, 1.0, 1.0, 1.0)),
        ("omega2", (1.0, 1.0, 1.0, np.nan)),
        ("frame", (1.0, 1.0, 1.0, -1.0)),
    ):
        with pytest.raises(vc.SceneError) as error:
            kin.twin_discs(*entries)
        assert error.value.field == field
