"""Wheels on rails in time: steady rolling is the limit of many steps, steps are those of basic
contacts, and patches carry their tractions over the lattice.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.wheel_rail import (
    CoarseElements,
    Position,
    Profile,
    Track,
    Velocity,
    WheelOnRail,
    WheelSet,
    wheel_on_rail_history,
)

ROLLING = WheelOnRail(
    track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
    wheelset=WheelSet(wheel=Profile.s1002(), radius=460.0),
    velocity=Velocity(speed=1000.0, pitch_rate=-1002.0 / 460.0),
    vertical_force=80e3,
    dx=2.0,
    dy=1.0,
    conformal=False,
)


def arc(radius, sign):
    """A circular profile."""
    y = np.linspace(-9.0, 9.0, 361)
    kind = "rail" if sign > 0 else "wheel"
    return Profile(y=y, z=sign * (radius - np.sqrt(radius**2 - y**2)), kind=kind)


def rig(**changes):
    """A round wheel in the middle of a flat rail, at a height."""
    y = np.linspace(-9.0, 9.0, 361)
    rail = Profile(y=y, z=1e-9 * y**2, kind="rail")  # its top is in the middle
    entries = {
        "track": Track(rail=rail, gauge=0.0, gauge_height=0.0),
        "wheelset": WheelSet(
            wheel=arc(50.0, -1), radius=100.0, inside_distance=0.0, flange_back=0.0
        ),
        "velocity": Velocity(speed=1000.0, pitch_rate=-10.02),
        "dx": 0.2,
        "dy": 0.2,
        "z": 0.02,
        "conformal": False,
    }
    return WheelOnRail(**(entries | changes))


@pytest.mark.long
def test_steady_rolling_is_the_limit_of_many_steps():
    """Steps of an element: from nothing the forces come nearer by the same part in each step, and
    what began in steady rolling stays there.
    """
    steady = ROLLING.solve()
    steps = wheel_on_rail_history([ROLLING] * 14)
    missing = np.array([step.force[0] for step in steps]) - steady.force[0]
    assert np.all(np.diff(missing) < 0)
    assert missing[-1] < 0.02 * abs(steady.force[0])
    assert missing[-1] / missing[-2] == pytest.approx(missing[-2] / missing[-3], abs=0.1)
    # elements of which one has its centre in the origin
    (patch,) = steady.patches
    across = float(ROLLING.rail.at(patch.location[1:2])[0])
    wheel = replace(ROLLING, dy=across / round(across))
    steady = wheel.solve()
    (step,) = wheel_on_rail_history([wheel], start=steady)
    assert step.force == pytest.approx(steady.force, abs=1e-4 * 80e3)
    assert step.z == pytest.approx(steady.z, abs=1e-6)


def test_steps_are_those_of_a_basic_contact():
    """At one height, on one lattice: a shift, then rolling."""
    wheel = replace(ROLLING, vertical_force=None, z=ROLLING.touching + 0.2)
    standing = replace(wheel, velocity=Velocity(speed=0.0, pitch_rate=-1e-4, lateral=2e-3))
    steps = wheel_on_rail_history([standing, wheel, wheel], rolled=[0.0, 2.0, 1.5])
    (patch,) = steps[0].patches
    scene = patch.patch.scene
    shift = steps[0].patches[0].creepage
    creep = steps[1].patches[0].creepage
    assert (shift.vx, shift.vy) == pytest.approx((1e-4 * 460.0, -2e-3), rel=0.05)
    motion = vc.Transient(
        steps=3,
        dq=[0.0, 2.0, 1.5],
        ux=[shift.vx, 0.0, 0.0],
        uy=[shift.vy, 0.0, 0.0],
        rotation=[shift.spin, 0.0, 0.0],
        vx=[0.0, creep.vx, creep.vx],
        vy=[0.0, creep.vy, creep.vy],
        spin=[0.0, creep.spin, creep.spin],
    )
    history = vc.solve(replace(scene, motion=motion))
    for step, expected in zip(steps, history, strict=True):
        (patch,) = step.patches
        assert patch.solution.force == pytest.approx(expected.force, rel=1e-5)


def test_a_patch_moves_over_the_rail():
    """To the side by an element in each step: as a distance that moves over the elements."""
    places = (0.0, 0.2, 0.4)
    steps = wheel_on_rail_history([rig(position=Position(y=y)) for y in places])
    (patch,) = steps[0].patches
    scene = patch.patch.scene
    h = np.pad(scene.surface.h, [(0, 2), (0, 0)], constant_values=scene.surface.h.max())
    surfaces = [vc.SampledDistance(np.roll(h, k, axis=0)) for k in range(3)]
    creepages = [step.patches[0].creepage for step in steps]
    spins = {name: [getattr(each, name) for each in creepages] for name in ("vx", "vy", "spin")}
    # the moment of the spin is about the patch, which moves
    spins["vx"] = [
        vx + spin * y for vx, spin, y in zip(spins["vx"], spins["spin"], places, strict=True)
    ]
    motion = vc.Transient(steps=3, surface=surfaces, **spins)
    grid = scene.grid.window(0, scene.grid.nx, 0, scene.grid.rows + 2)
    expected = vc.solve(replace(scene, surface=surfaces[0], grid=grid, motion=motion))[-1]
    assert steps[-1].patches[0].solution.force == pytest.approx(expected.force, rel=1e-6)
    assert abs(expected.force[0]) > 100.0


def two_lobes(separate, **changes):
    """A wheel that touches the rail at two places, which are one patch up to a distance."""
    y = np.linspace(-5.9, 5.9, 473)
    wheel = Profile(y=y, z=-0.05 * (1.0 + np.cos(np.pi * y / 3.0)), kind="wheel")
    wheelset = WheelSet(wheel=wheel, radius=100.0, inside_distance=0.0, flange_back=0.0)
    entries = {"wheelset": wheelset, "separate": separate, "join": separate, "z": 0.03}
    return rig(**(entries | changes))


def test_patches_merge_and_split():
    """What is left goes to the patch that takes its place: a shift by nothing leaves tractions, of
    one patch that two become, too.
    """
    standing = Velocity(speed=0.0)
    wheels = [
        two_lobes(1.0),
        two_lobes(1.0, velocity=standing),
        two_lobes(9.0, velocity=standing),
        two_lobes(1.0, velocity=standing),
    ]
    steps = wheel_on_rail_history(wheels, rolled=[0.2, 0.0, 0.0, 0.0])
    assert [len(step.patches) for step in steps] == [2, 2, 1, 2]
    rolled, kept, together, parted = steps
    for one, other in zip(rolled.patches, kept.patches, strict=True):
        assert other.force == pytest.approx(one.force, rel=1e-6)
    # as parts of one half-space they feel each other, and bear less
    assert together.force[0] == pytest.approx(rolled.force[0], rel=0.1)
    forces = [patch.solution.force for patch in parted.patches]
    assert forces[0][0] == pytest.approx(forces[1][0], rel=1e-3)
    assert sum(forces)[0] == pytest.approx(together.force[0], rel=0.1)


def test_a_patch_that_lifts_off_leaves_nothing():
    """The wheel rolls on the other lobe; where the first comes down again it begins anew."""
    down = two_lobes(1.0)
    tilted = two_lobes(1.0, position=Position(y=0.7, roll=0.007))
    tilted = replace(tilted, z=tilted.touching + 0.03)
    first, alone, again = wheel_on_rail_history([down, tilted, down], rolled=0.2)
    assert [len(step.patches) for step in (first, alone, again)] == [2, 1, 2]
    fresh, went_on = sorted(abs(patch.force[0]) for patch in again.patches)
    assert fresh == pytest.approx(abs(first.patches[0].force[0]), rel=1e-3)
    assert went_on > 1.5 * fresh


def test_a_history_refuses_what_it_has_not():
    wheel = rig()
    start = wheel.solve()
    for wheels, more, words in [
        ([], {}, "wheels = "),
        ([rig(conformal=True)], {}, r"wheels\[0\].conformal = True must be left out"),
        ([rig(slip_by_element=True)], {}, r"wheels\[0\].slip_by_element"),
        ([wheel, rig(dx=0.1)], {}, r"wheels\[1\].dx, dy"),
        ([wheel, rig(bodies=vc.Bodies(G=8e4, nu=0.3))], {}, r"wheels\[1\].bodies"),
        ([rig(dy=0.1)], {"start": start}, r"wheels\[0\].dx, dy"),
        ([wheel], {"rolled": [0.1, 0.1]}, "rolled = 2"),
        ([wheel], {"rolled": -0.1}, "rolled = -0.1"),
        ([wheel], {"tangential": "fastsim"}, "tangential = 'fastsim' must be left out"),
        ([wheel], {"accuracy": 0.01}, "accuracy = 0.01 must be left out"),
        ([wheel, rig(z=-0.1)], {}, "step 1 of the history: no contact"),
    ]:
        refused(partial(wheel_on_rail_history, wheels, **more), match=words)


def test_coarse_elements_are_told_once():
    coarse = rig(dx=0.5, dy=0.5, z=0.003)
    with pytest.warns(CoarseElements, match="1 element wide") as told:
        wheel_on_rail_history([coarse] * 3)
    assert len(told) == 2  # along and across, of the first of three steps
