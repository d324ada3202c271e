"""How severe scenes are for their grids: slender contacts, histories in short steps, and unlike bodies."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.planning.choice import make_plan
from varcontact.solving.error_norm import units, values
from varcontact.solving.on_demand.severity import coupling_strength, severity_of

UNLIKE = vc.Scene(
    bodies=vc.Bodies(G=(1.0, 8.0), nu=(0.1, 0.3)),
    surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
    normal_force=1e-4,
    friction=0.3,
    motion=vc.Transient(steps=3, dq=8.0, vx=1e-3),
)


def severity(scene, axes=(1.0, 1.0)):
    return severity_of(scene, make_plan(scene), axes)


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
    assert found[0] == found[-1] == 1 and found[2] == 2.5
    assert found[1] == pytest.approx(found[3]) and 1 < found[1] < 2.5


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


@pytest.mark.parametrize("accuracy", [0.03, 0.01])
def test_rolling_near_the_most_severe_coupling_keeps_its_accuracy(accuracy):
    """K/f = 0.8: on 24 to 48 elements across, errors fall more slowly than elsewhere; Fx is that of up to 192."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=(1.0, 4.514893126034589), nu=(0.11135882560004867, 0.05391654645106203)),
        surface=vc.Paraboloids(Rx=0.29764103625617017, Ry=1.0),
        normal_force=1e-4,
        friction=0.3,
        motion=vc.Steady(vx=-0.004944866017265924),
    )
    sol = vc.solve(scene, accuracy=accuracy)
    assert sol.force[0] / (0.3 * 1e-4) == pytest.approx(-0.1829, abs=accuracy)
    assert sol.error_estimate.largest <= accuracy
