"""Plausibility warnings of wheels on rails: one for each likely mistake, none of a usual wheel."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.wheel_rail import (
    Archard,
    Position,
    Profile,
    Track,
    WheelOnRail,
    WheelSet,
    WheelSetOnTrack,
    shakedown,
    wear,
)
from varcontact.wheel_rail.plausibility import at_tip, warnings_of

RAIL = Profile.rail_60e1()
IN_INCHES = Profile(y=RAIL.y / 25.4, z=RAIL.z / 25.4, kind="rail")
TRACK = Track(rail=RAIL, cant=1 / 40)
AXLE = WheelSet(wheel=Profile.s1002())
WHEEL = WheelOnRail(
    track=TRACK, wheelset=AXLE, position=Position(y=3.0), vertical_force=80e3, dx=1.0, dy=1.0
)
SET = WheelSetOnTrack(track=TRACK, wheelset=AXLE, vertical_force=160e3, dx=1.0, dy=1.0)


def on(**track):
    return replace(WHEEL, track=replace(TRACK, **track))


@pytest.mark.parametrize(
    ("case", "words"),
    [
        (
            replace(WHEEL, vertical_force=80.0),
            "vertical_force = 80 N: 1 to 500 kN on each wheel is usual",
        ),
        (replace(WHEEL, vertical_force=600e3), "vertical_force = 6e+05 N"),
        (replace(SET, vertical_force=160.0), "vertical_force = 160 N: 1 to 500 kN on each wheel"),
        (
            replace(WHEEL, bodies=vc.Bodies.from_young(210.0, 0.3)),
            "bodies: G = 80.77 N/mm^2 is below",
        ),
        (on(cant=-1 / 40), "track.cant = -0.025: the rails lean outwards; a positive cant"),
        (
            on(gauge=56.5),
            "track.gauge = 56.5 mm: tracks have 300 to 3000 mm; metres and inches are to be converted",
        ),
        (on(curve_radius=-3000.0), "track.curve_radius = -3000 mm: the tightest curves have 15 m"),
        (
            replace(WHEEL, wheelset=replace(AXLE, radius=40.0)),
            "wheelset.radius = 40 mm is 0.028 of the gauge",
        ),
        (on(rail=IN_INCHES, gauge_height=0.5), "mm wide: it looks like inches"),
    ],
)
def test_each_mistake_has_its_warning(case, words):
    (doubt,) = warnings_of(case)
    assert words in doubt


def test_usual_wheels_have_none():
    cases = [WHEEL, SET, replace(WHEEL, side="left"), replace(WHEEL, vertical_force=None, z=0.2)]
    cases += [
        on(curve_radius=20e3),
        on(gauge=1000.0),
        on(cant=0.0),
        replace(WHEEL, vertical_force=1e3),
    ]
    cases.append(replace(SET, vertical_force=1e6))
    assert [text for case in cases for text in warnings_of(case)] == []


def test_a_gauge_in_metres_is_named_before_it_is_refused():
    with (
        pytest.warns(vc.PlausibilityWarning, match=r"track.gauge = 1.435 mm"),
        pytest.raises(vc.SceneError),
    ):
        on(gauge=1.435).solve()


def test_it_reaches_scripts_once():
    """Of the wheel, and of the scenes of its patches: by warnings, by the solution and by the
    report.
    """
    case = replace(
        on(cant=-1 / 40), bodies=vc.Bodies(G=210e3, nu=0.28), friction=30.0, dx=0.25, dy=0.25
    )
    with pytest.warns(vc.PlausibilityWarning) as caught:
        sol = case.solve()
    texts = [str(each.message) for each in caught if each.category is vc.PlausibilityWarning]
    assert tuple(texts) == sol.warnings and len(texts) == 3
    for text, words in zip(
        texts, ("track.cant", "Young's modulus of steel", "friction = 30"), strict=True
    ):
        assert words in text and sol.report().count(text) == 1
    assert {each.filename for each in caught} == {__file__}


@pytest.mark.long
def test_a_wheel_set_has_each_once():
    case = replace(SET, track=replace(TRACK, cant=-1 / 40), friction=30.0, free=())
    with pytest.warns(vc.PlausibilityWarning) as caught:
        sol = case.solve()
    texts = [str(each.message) for each in caught if each.category is vc.PlausibilityWarning]
    assert texts == list(sol.warnings)[: len(texts)] and len(texts) == 2


def test_a_usual_wheel_is_quiet():
    with warnings.catch_warnings():
        warnings.simplefilter("error", vc.PlausibilityWarning)
        sol = replace(WHEEL, dx=0.5, dy=0.5).solve()
        wear(sol, Archard(k=3e-4, hardness=3000.0))
        shakedown(sol.patches[0], yield_in_shear=300.0)
    assert sol.warnings == ()
    for hardness in (300.0, 3e9):
        with pytest.warns(vc.PlausibilityWarning, match="wear.hardness = .* N/mm"):
            wear(sol, Archard(k=3e-4, hardness=hardness))
    for stress in (3e8, 0.3):
        with pytest.warns(
            vc.PlausibilityWarning, match="yield_in_shear = .*metals have 20 to 5000"
        ):
            shakedown(sol.patches[0], yield_in_shear=stress)


def test_a_contact_on_the_flange_tip():
    (patch,) = WHEEL.patches(z=0.05 + WHEEL.touching)
    profile = AXLE.profile
    tip = int(np.argmax(profile.z))
    assert at_tip(patch.location[1], patch.on_wheel, profile) == ()
    (doubt,) = at_tip(700.0, np.array([profile.y[tip], profile.z[tip]]), profile)
    assert doubt.startswith("the patch at y = 700 mm is 0 mm below the flange's tip")


@pytest.mark.parametrize("case", [WHEEL, SET])
def test_estimates_give_the_warnings_of_solutions(case):
    """As Python warnings and in `warnings`, each once; none of a usual case."""
    leaning = replace(case, track=replace(TRACK, cant=-1 / 40))
    with pytest.warns(vc.PlausibilityWarning) as caught:
        found = leaning.estimate()
    own = [str(each.message) for each in caught if each.category is vc.PlausibilityWarning]
    assert own == list(found.warnings)
    assert [text.partition(":")[0] for text in own] == ["track.cant = -0.025"]
    assert {each.filename for each in caught} == {__file__}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert case.estimate().warnings == ()
