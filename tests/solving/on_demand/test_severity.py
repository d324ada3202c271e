"""How severe scenes are for their grids: slender contacts, histories in short steps, and unlike bodies."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.planning.choice import make_plan
from varcontact.solving.error_norm import units, values
from varcontact.solving.on_demand.severity import coupling_strength, severity_of, turning
from varcontact.solving.on_demand.zones import unresolved

UNLIKE = vc.Scene(
    bodies=vc.Bodies(G=(1.0, 8.0), nu=(0.1, 0.3)),
    surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
    normal_force=1e-4,
    friction=0.3,
    motion=vc.Transient(steps=3, dq=8.0, vx=1e-3),
)
HERTZ = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28),
    surface=vc.Ellipse(a=1.0, b=1.0),
    normal_force=1.0,
    friction=0.3,
    motion=vc.Steady(vx=0.05),
)
ROUND, LONG = (1.0, 1.0), (8.0, 0.125)


def severity(scene, axes=(1.0, 1.0), **known):
    return severity_of(scene, make_plan(scene), axes, **known)


@pytest.mark.parametrize(
    ("axes", "motion", "turned", "least", "most"),
    [
        (ROUND, vc.Steady(vx=0.05), "spin", 0.4, 1.0),
        (LONG, vc.Steady(vx=0.05), "spin", 0.4 * 8**0.5, 8**0.5),
        (ROUND, vc.Shift(ux=0.05), "rotation", 0.4, 1.0),
        (LONG, vc.Shift(ux=0.05), "rotation", 0.4 * 8**0.5, 8**0.5),
    ],
)
def test_contacts_that_turn_are_severe(axes, motion, turned, least, most):
    """Between bounds in proportion to the turning, whichever way it goes."""
    scene = replace(HERTZ, surface=vc.Ellipse(*axes))

    def of(turn):
        return severity(replace(scene, motion=replace(motion, **{turned: turn})), axes)

    assert of(0.0) == of(1e-5) == pytest.approx(least)
    assert of(10.0) == pytest.approx(most)
    turns = np.geomspace(1e-4, 1.0, 200)
    found = np.array([of(turn) for turn in turns])
    between = (found > 1.01 * least) & (found < 0.99 * most)
    assert between.sum() > 3
    np.testing.assert_allclose(np.diff(np.log(found[between])), np.log(turns[1] / turns[0]))
    assert of(-0.004) == of(0.004)


@pytest.mark.parametrize("motion", [vc.Steady(spin=0.05), vc.Shift(rotation=0.05)])
def test_turning_has_no_unit(motion):
    """Lengths in millimetres and forces in newtons in place of ones."""
    length, stress = 1e3, 8e10
    scaled = replace(motion, spin=motion.spin / length) if isinstance(motion, vc.Steady) else motion
    large = replace(
        HERTZ,
        bodies=vc.Bodies(G=stress, nu=0.28),
        surface=vc.Ellipse(length, length),
        normal_force=stress * length**2,
        motion=scaled,
    )
    assert turning(large) == pytest.approx(turning(replace(HERTZ, motion=motion)), rel=1e-12)


@pytest.mark.parametrize("accuracy", [0.1, 0.03, 0.01, 0.003])
@pytest.mark.parametrize(
    ("changes", "exact", "units"),
    [
        (
            {
                "bodies": vc.Bodies(G=1.0, nu=0.4),
                "surface": vc.Ellipse(a=2.487730591102745, b=0.40197278739766046),
                "motion": vc.Steady(spin=0.03146218997349652, Fx=0.09433547517404062),
            },
            {"vx": -0.13155, "Fy": -0.87158, "Mz": -0.18770},
            {"vx": 0.09563},
        ),
        (
            {
                "surface": vc.Ellipse(a=0.5542608911180408, b=1.8042045109530023),
                "friction": vc.LinearFalling(static=0.6, kinetic=0.48, half_velocity=1.9076306098464666),
                "motion": vc.Steady(vx=-0.9222494161984626, vy=0.031063685355992098, spin=0.6059170357195357),
            },
            {"Fx": 0.87052, "Fy": -0.18386, "Mz": -0.11066},
            {"Fx": 0.6, "Fy": 0.6, "Mz": 0.6},
        ),
        (
            {
                "bodies": vc.Bodies(G=1.0, nu=0.5),
                "surface": vc.Ellipse(a=0.24932335868307862, b=4.010855642575897),
                "friction": 0.05,
                "motion": vc.Shift(
                    ux=0.00031998306549399394, uy=0.0023205568366709934, rotation=-0.0003579095249677367
                ),
            },
            {"Fx": -0.02949, "Fy": -0.15378, "Mz": 0.20591},
            {"Fx": 0.05, "Fy": 0.05, "Mz": 0.05},
        ),
    ],
    ids=["force and spin", "law of friction", "slender shift"],
)
def test_scenes_that_turn_keep_their_accuracy(changes, exact, units, accuracy):
    """Those of a thousand with the largest errors; exact are 144 elements across, extrapolated, known to 4e-4."""
    sol = vc.solve(replace(HERTZ, **changes), accuracy=accuracy)
    found = values(sol)
    for name, value in exact.items():
        assert found[name] / units.get(name, 0.3) == pytest.approx(value, abs=accuracy), name


def test_slender_contacts_are_severe():
    like = replace(UNLIKE, bodies=vc.Bodies(G=1.0, nu=0.3))
    assert severity(like) == 1
    assert severity(like, (4.0, 1.0)) == severity(like, (1.0, 4.0)) == 2
    assert severity(UNLIKE, (4.0, 1.0)) == pytest.approx(2**0.5 * severity(UNLIKE))


def test_strong_coupling_is_severe_within_bounds():
    strong = [severity(replace(UNLIKE, friction=f)) for f in (0.01, 0.3, 0.31, 10.0)]
    assert strong[0] == 2 and strong[-1] == 0.5
    assert strong[1] / strong[2] == pytest.approx(0.31 / 0.3)
    assert strong[1] == pytest.approx(UNLIKE.bodies.K / 0.3)


def test_short_steps_are_severe_and_more_so_under_a_force():
    def of(**motion):
        return severity(replace(UNLIKE, motion=vc.Transient(steps=3, **motion))) / severity(UNLIKE)

    assert of(dq=2.0, vx=1e-3) == of(dq=0.0, ux=1e-3) == 1
    assert of(dq=0.04, vx=1e-3) == of(dq=[0.0, 1.0, 0.04], vx=1e-3) == pytest.approx(5)
    assert of(dq=0.0625, Fx=1e-5) == of(dq=0.0625, Fy=[None, None, 1e-5]) == pytest.approx(8)
    assert of(dq=1e-4, vx=1e-3) == of(dq=0.03, vx=1e-3)


def test_rolling_is_most_severe_where_coupling_and_friction_are_about_equal():
    bodies, rolling = UNLIKE.bodies, replace(UNLIKE, motion=vc.Steady(vx=1e-3))
    found = [severity(replace(rolling, friction=abs(bodies.K) / part)) for part in (0.05, 0.35, 0.7, 1.4, 10.0)]
    assert found[0] == found[-1] and found[2] / found[0] == pytest.approx(2.5**0.5)
    assert found[1] == pytest.approx(found[3]) and found[0] < found[1] < found[2]


def test_rolling_is_more_severe_with_zones_too_thin_for_the_elements():
    """Before there is an answer three in ten rows are taken to have them; finer elements resolve more."""
    rolling = replace(UNLIKE, friction=0.6, motion=vc.Steady(vx=1e-3, spin=0.05), grid=vc.Grid(nx=18, ny=12))
    near = vc.solve(rolling)
    assert 0.0 < unresolved(near, 4.0) < unresolved(near) < 1.0
    none = severity(rolling) / (1 + 2.6 * 0.3)
    for finer in (1.0, 4.0):
        assert severity(rolling, near=near, finer=finer) == pytest.approx(none * (1 + 2.6 * unresolved(near, finer)))
    like = replace(rolling, bodies=vc.Bodies(G=1.0, nu=0.3))
    assert severity(like, near=vc.solve(like)) == severity(like)


def test_histories_of_like_bodies_are_severe_in_short_steps_too():
    like = replace(UNLIKE, bodies=vc.Bodies(G=1.0, nu=0.3), motion=vc.Transient(steps=3, dq=0.25, vx=1e-3))
    assert severity(like) == 2
    assert severity(like, (1.0, 4.0)) == 4


def test_the_least_friction_counts():
    law = vc.StaticKinetic(static=0.4, kinetic=0.2)
    fields = [replace(UNLIKE, friction=law), replace(UNLIKE, motion=replace(UNLIKE.motion, friction=[0.3, 0.0, 0.2]))]
    assert [coupling_strength(scene) * 0.2 for scene in fields] == pytest.approx([UNLIKE.bodies.K] * 2)
    assert coupling_strength(replace(UNLIKE, friction=vc.StaticKinetic(0.4, 0.0))) == pytest.approx(
        UNLIKE.bodies.K / 0.4
    )


def test_before_the_contact_is_known_and_in_line_contact_it_is_one():
    line = replace(UNLIKE, surface=vc.Cylinders(1.0, reference_depth=5.0))
    assert severity(UNLIKE, None) == severity(line, (1.0, np.inf)) == 1


def test_a_severe_history_keeps_its_accuracy():
    """Short steps under a force, K/f = 2: the creepages are those of up to 288 elements across, known to 2e-4."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=(1.0, 10.853075849633985), nu=(0.35421862426565753, 0.0698624148389621)),
        surface=vc.Paraboloids(Rx=0.2981625399680077, Ry=1.0),
        normal_force=1e-4,
        friction=0.05,
        motion=vc.Transient(
            steps=7, dq=[0.0] + 6 * [0.0008312139649174575], Fx=-5.14006684557164e-07, spin=-0.012709693450591869
        ),
    )
    history = vc.solve(scene, accuracy=0.03)
    found, unit = values(history), units(history)
    creepages = [found[f"vx[{k}]"] / unit[f"vx[{k}]"] for k in range(1, 7)]
    assert creepages == pytest.approx([-0.8508, -0.8878, -0.9086, -0.9231, -0.9347, -0.9445], abs=0.03)
    assert history.error_estimate.largest <= 0.03
