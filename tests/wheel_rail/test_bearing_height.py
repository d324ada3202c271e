"""The search for the height that bears a load: an object that proposes, learns and is done."""

from dataclasses import replace

import numpy as np
import pytest

from tests.wheel_rail.conditions import TRACK, WHEELSET
from varcontact.errors import NotConverged, SceneError
from varcontact.solving.methods import Methods
from varcontact.solving.on_grid import ContactOnGrid
from varcontact.solving.selection import select
from varcontact.solving.side_by_side import with_tractions_batched
from varcontact.wheel_rail import Position, WheelOnRail
from varcontact.wheel_rail.bearing_height import ROUNDS, BearingHeight
from varcontact.wheel_rail.locus import Locus
from varcontact.wheel_rail.wheel_on_elements import WheelOnElements, patches_at

LOAD = 80e3
TOL = 1e-8


def wheel(y=0.0, **more):
    more = {"vertical_force": LOAD, "dx": 2.0, "dy": 1.0, **more}
    return WheelOnRail(track=TRACK, wheelset=WHEELSET, position=Position(y=y), **more)


def pressed(case, stiffness, power, z):
    return stiffness * max(z - case.touching, 0.0) ** power


@pytest.mark.parametrize("power", [1.5, 1.3, 2.0])
@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_the_height_of_a_power_law_in_closed_form(stiffness, power):
    case = wheel()
    search = BearingHeight(case, TOL)
    while not search.done:
        force = pressed(case, stiffness, power, search.propose())
        search.learn_normal(force)
        search.learn(force)
    depth = (LOAD / stiffness) ** (1 / power)
    assert search.z - case.touching == pytest.approx(depth, rel=1e-7)
    assert search.rounds <= 10


def test_a_height_that_is_given_is_the_only_one():
    case = wheel(vertical_force=None, z=0.1)
    search = BearingHeight(case, TOL)
    assert search.propose() == 0.1
    search.learn(5.0)
    assert search.done
    assert search.rounds == 0


def test_searches_that_take_turns_have_the_heights_of_each_alone():
    case = wheel()
    laws = [(1e6, 1.5), (1e7, 1.4), (1e8, 1.6)]

    def heights(groups):
        found = {}
        for group in groups:
            searches = {law: BearingHeight(case, TOL) for law in group}
            while not all(each.done for each in searches.values()):
                for law, search in searches.items():
                    if not search.done:
                        search.learn(pressed(case, *law, search.propose()))
            found |= {law: search.z for law, search in searches.items()}
        return found

    assert heights([laws]) == heights([[law] for law in laws])


def told_by_patches(case, part):
    """The search under a power law, where patches tell a part of the step."""
    search = BearingHeight(case, TOL)
    while not search.done:
        z = search.propose()
        force = pressed(case, 1e7, 1.5, z)
        search.learn_normal(force)
        search.learn(force)
        depth = (search.goal / 1e7) ** (2 / 3)
        search.expect(z + (case.touching + depth - z) * part)
    return search


@pytest.mark.parametrize("part", [1.0, 0.97, 1.04])
def test_patches_tell_the_next_height(part):
    """Forces change by a part of what patches that stay as they are tell: as soon as that is seen,
    it counts.
    """
    case = wheel(with_friction=False)
    search = told_by_patches(case, part)
    assert search.z - case.touching == pytest.approx((LOAD / 1e7) ** (2 / 3), rel=1e-7)
    assert search.rounds == (2 if part == 1.0 else 3)
    # known from the second height on, and not forgotten where it has been applied
    assert search._change == pytest.approx(part, rel=1e-6)


@pytest.mark.parametrize("part", [0.5, 2.0])
def test_patches_that_tell_little_are_not_followed_for_long(part):
    case = wheel(with_friction=False)
    search = told_by_patches(case, part)
    assert search.rounds <= 6


@pytest.mark.parametrize("jump", [3e-5, 3e-3])
def test_where_forces_jump_over_the_load_little_is_accepted(jump):
    """As an element comes into contact."""
    case = wheel(with_friction=False)
    depth = (LOAD / 1e7) ** (2 / 3)
    search = BearingHeight(case, TOL)

    def search_all():
        while not search.done:
            z = search.propose()
            sign = 1 if z > case.touching + depth else -1
            force = pressed(case, 1e7, 1.5, z) * (1 + sign * jump)
            search.learn_normal(force)
            search.learn(force)

    if jump > 1e-3:
        with pytest.raises(NotConverged, match=r"forces jump by 0\.003 of it at z = "):
            search_all()
        return
    search_all()
    assert search.z - case.touching == pytest.approx(depth, rel=2 * TOL)


@pytest.mark.parametrize("off", [-1e-3, 1e-3])
def test_an_estimate_bounds_no_heights(off):
    """The load is borne on the other side of the first height than an estimate tells."""
    case = wheel(with_friction=False)
    depth = (LOAD / 1e7) ** (2 / 3)
    search = BearingHeight(case, TOL, case.touching + depth * (1 + off / 10))
    search.propose()
    search.estimate_normal(LOAD * (1 - off))
    search.expect(case.touching + depth * (1 + 2 * off))
    while not search.done:
        force = pressed(case, 1e7, 1.5, search.propose())
        search.learn_normal(force)
        search.learn(force)
    assert search.z - case.touching == pytest.approx(depth, rel=1e-6)
    assert search.rounds <= 5


def test_methods_follow_the_number_of_elements():
    """As those of the first height are kept, but not for many more elements."""
    case = wheel(3.0, dx=0.4, dy=0.4)
    on_elements = WheelOnElements(case, TOL, {})
    for depth, normal in ((0.01, "norm"), (0.012, "norm"), (0.2, "newton"), (0.005, "norm")):
        (patch,) = patches_at(case, case.touching + depth)
        scene = patch.scene
        plan = on_elements._options_of(0, scene).plan
        assert plan.normal == select(scene, Methods()).normal == normal
        assert plan.grid.form.shape == scene.own_grid.shape


def test_fine_elements_begin_where_coarse_ones_bear_the_load():
    found = wheel(3.0, dx=0.25, dy=0.25).solve()
    assert found.rounds <= 3
    again = wheel(3.0, dx=0.25, dy=0.25, vertical_force=None, z=found.z).solve()
    assert again.force == pytest.approx(found.force, rel=1e-8)


def test_a_first_height_needs_the_load_alone(monkeypatch):
    """Its pressures are solved for once, those of the heights after it under the load, too."""
    calls = []

    def counted(name):
        method = getattr(ContactOnGrid, name)

        def call(contact, *rest):
            calls.append(name)
            return method(contact, *rest)

        monkeypatch.setattr(ContactOnGrid, name, call)

    for name in ("under", "with_pressure", "with_tractions"):
        counted(name)
    found = wheel(3.0, dx=1.0, dy=1.0).solve()
    assert calls[0] == "under"
    assert calls[-2:] == ["with_pressure", "with_tractions"]
    assert calls.count("under") == calls.count("with_pressure") == found.rounds - 1


@pytest.mark.parametrize("load", [LOAD, 1.2 * LOAD])
def test_a_wheel_beside_another_begins_near_its_height(load):
    """Its first height misses the load by little, and fewer are needed."""
    sides = {"dx": 1.0, "dy": 0.5}
    before = wheel(3.0, **sides).solve()
    case = wheel(3.1, vertical_force=load, **sides)
    pressing = before.case.locus.pressing(before.z) * load / LOAD
    z = case.locus.height_pressing(pressing, before.z - before.case.touching)
    at_first = wheel(3.1, vertical_force=None, z=z, **sides).solve()
    assert at_first.force[2] == pytest.approx(load, rel=0.01)
    found = case.solve()
    again = case.solve(start=before)
    assert again.rounds < found.rounds
    assert again.force == pytest.approx(found.force, rel=1e-6)


def test_an_overlap_of_a_paraboloid_presses_by_the_power_of_hertz():
    radii = np.full(401, 460.0)
    across = np.linspace(-10, 10, 401)
    points = np.stack([0.0 * across, across, 0.0 * across], axis=1)
    gap = across**2 / (2 * 300.0)
    locus = Locus(across, points, radii, radii, gap, 0.0 * across, 0.0)
    assert locus.pressing(0.08) == pytest.approx(8 * locus.pressing(0.02), rel=5e-3)
    assert locus.height_pressing(locus.pressing(0.05), 0.04) == pytest.approx(0.05, rel=1e-4)


def test_tractions_wait_until_normal_forces_are_near_the_load():
    search = BearingHeight(wheel(), TOL)
    search.propose()
    search.learn_normal(0.5 * LOAD)
    assert not search.near
    search.learn_normal(0.995 * LOAD)
    assert search.near
    assert not search.done


def test_what_bears_no_load():
    search = BearingHeight(wheel(), TOL)
    search.propose()
    with pytest.raises(SceneError, match="friction lifts the rail") as refused:
        search.learn(-1.0)
    assert refused.value.field == "vertical_force"
    search = BearingHeight(wheel(), TOL)
    for _ in range(ROUNDS):
        search.propose()
        search.learn(0.5 * LOAD)
    with pytest.raises(NotConverged, match="no height of the axle"):
        search.propose()


@pytest.mark.long
def test_wheels_in_one_loop_have_the_solutions_of_each_alone():
    cases = [wheel(y) for y in (0.0, 3.0)]
    wheels = [WheelOnElements(each, 1e-6, {}) for each in cases]
    while not all(each.done for each in wheels):
        proposed = [each.propose() for each in wheels]
        settled = iter(with_tractions_batched([contact for own in proposed for contact in own]))
        for each, own in zip(wheels, proposed, strict=True):
            each.learn([next(settled) for _ in own])
    for each, case in zip(wheels, cases, strict=True):
        together, alone = each.solution(), case.solve()
        assert together.z == pytest.approx(alone.z, abs=1e-8)
        np.testing.assert_allclose(together.force, alone.force, rtol=1e-5, atol=0.1)


def test_a_wheel_without_friction_proposes_contacts_that_bear_its_load():
    only = WheelOnElements(replace(wheel(), friction=0.0), 1e-6, {})
    while not only.done:
        only.learn(only.propose())
    assert only.propose() == []
    assert only.solution().force[2] == pytest.approx(LOAD, rel=1e-6)
