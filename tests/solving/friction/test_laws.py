"""Laws of friction: their limits, their solutions judged from outside, and what tells the solutions
apart.
"""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import varcontact as vc
from tests.scenes import refused
from varcontact.scene.friction_laws import LAWS

FALLING = [vc.LinearFalling, vc.RationalFalling, vc.ExponentialFalling]
EVERY = [vc.StaticKinetic(0.3, 0.2), *(law(0.3, 0.2, half_velocity=4e-3) for law in FALLING)]


def part(sol):
    return -sol.force[0] / sol.normal_force


@pytest.mark.parametrize("law", EVERY, ids=lambda law: type(law).__name__)
def test_the_laws_themselves(law):
    slip = np.array([0.0, 1e-4, 2e-3, 4e-3, 1e-2, 1.0])
    values = law(slip)
    assert values[0] == law.static
    assert np.all(np.diff(values) <= 0)
    assert values[-1] == pytest.approx(law.kinetic, abs=1e-3)
    if law.continuous:
        assert law(law.half_velocity) == pytest.approx(0.25)
        step = 1e-8
        slope = (law(slip[1:] + step) - law(slip[1:] - step)) / (2 * step)
        np.testing.assert_allclose(law.slope(slip[1:]), slope, atol=1e-5)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda line, ball: vc.StaticKinetic(0.2, 0.3), "friction.kinetic"),
        (lambda line, ball: vc.StaticKinetic(0.0, 0.0), "friction.static"),
        (lambda line, ball: vc.StaticKinetic(np.inf, 0.3), "friction.static"),
        (lambda line, ball: vc.LinearFalling(0.3, -0.1, 1.0), "friction.kinetic"),
        (lambda line, ball: vc.RationalFalling(0.3, 0.2, 0.0), "friction.half_velocity"),
        (
            lambda line, ball: vc.ExponentialFalling(0.3, 0.2, 1.0, velocity=np.nan),
            "friction.velocity",
        ),
        (lambda line, ball: vc.solve(line(0.3), start="stick"), "start"),
        (lambda line, ball: vc.solve(line(EVERY[0]), start="rest"), "start"),
        (lambda line, ball: vc.solve(line(EVERY[0]), start=np.zeros((1, 26))), "start"),
        (lambda line, ball: vc.solve(line(EVERY[0]), start=vc.solve(line(0.3, cells=30))), "start"),
        (lambda line, ball: line([EVERY[0]]), "friction"),
        (lambda line, ball: line(vc.StaticKinetic), "friction"),
        (
            lambda line, ball: vc.solve(
                ball(EVERY[0], motion=vc.Steady(vx=1e-3)), tangential="vermeulen-johnson"
            ),
            "tangential",
        ),
        (
            lambda line, ball: vc.solve(
                ball(EVERY[0], motion=vc.Steady(Fx=1e-6)), tangential="fastsim"
            ),
            "tangential",
        ),
        (lambda line, ball: vc.solve(line(EVERY[1])).frequency_response(0.0), "friction"),
    ],
)
def test_bad_input(make, field, line, ball):
    refused(lambda: make(line, ball), field)


@pytest.mark.parametrize("law", FALLING)
def test_slow_fall_is_static(law, line):
    """The difference from the static coefficient goes with one by the velocity at which half is
    lost.
    """
    static = part(vc.solve(line(0.3)))
    far, near = (static - part(vc.solve(line(law(0.3, 0.2, half)))) for half in (2.0, 1.0))
    assert 0 < far < near < 1e-4
    assert near / far == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize("law", FALLING)
def test_between_static_and_kinetic(law, line):
    """The sooner it falls, the less force, between those of both coefficients alone."""
    forces = [part(vc.solve(line(law(0.3, 0.2, half), vx=6e-3))) for half in (0.1, 0.01, 0.003)]
    assert np.all(
        np.diff([part(vc.solve(line(0.3, vx=6e-3))), *forces, part(vc.solve(line(0.2, vx=6e-3)))])
        < 0
    )


def test_kinetic_alone_is_carter(line):
    """From slip all over, the solution is that of the kinetic coefficient: Carter's, as the grid is
    refined.
    """
    law, errors = vc.StaticKinetic(0.3, 0.2), []
    for cells in (20, 80):
        sol = vc.solve(line(law, cells=cells), start="slip")
        np.testing.assert_allclose(
            sol.traction, vc.solve(line(0.2, cells=cells)).traction, atol=1e-13
        )
        contact = vc.reference.line_contact(1.0, sol.scene.bodies, force=1e-3)
        exact = vc.reference.carter(contact, 0.2, force=sol.force[0])
        errors.append(abs(sol.creepage[0] / exact.creepage - 1))
    assert errors[1] < errors[0] / 3 < 0.02


def test_two_solutions(line, holds):
    """Both certified; from stick there is more stick, and more force."""
    stick, slip = (
        vc.solve(line(vc.StaticKinetic(0.3, 0.15), cells=60), start=start)
        for start in ("stick", "slip")
    )
    for sol in (stick, slip):
        holds(sol)
    assert (stick.branch, slip.branch) == ("stick", "slip")
    assert stick.elements["stick"] > slip.elements["stick"] + 2
    assert part(stick) > part(slip) + 1e-4
    assert np.hypot(*stick.traction).max() > 0.15 * stick.pressure.max() * (1 + 1e-3)
    again = vc.solve(stick.scene, start=stick)
    np.testing.assert_allclose(again.traction, stick.traction, atol=1e-12)
    assert (again.branch, len(again.passes)) == ("solution", 1)


@pytest.mark.parametrize("law", EVERY, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"bodies": vc.Bodies(G=(1.0, 0.4), nu=(0.28, 0.2))},
        {"motion": vc.Steady(Fx=-1.2e-5, vy=1e-3)},
    ],
    ids=["creepage", "unlike bodies", "force"],
)
def test_equations(law, changes, check_kkt, ball, holds):
    """The scene's equations hold with the coefficients that the law has at the slip, by a program
    of their own.
    """
    sol = vc.solve(ball(law, **changes))
    holds(sol)
    check_kkt(sol, 1e-7)
    assert np.all(np.isinf(sol.certificate.force_bound))
    assert 0 < sol.elements["stick"]
    assert 0 < sol.elements["slip"]


@pytest.mark.parametrize(
    "law", [vc.StaticKinetic(0.3, 0.2), vc.LinearFalling(0.3, 0.2, half_velocity=4e-4)]
)
def test_shift(law, ball, holds):
    """In a shift the law takes lengths, or by its velocity lengths by a duration."""
    sol = vc.solve(ball(law, motion=vc.Shift(ux=2e-4)))
    holds(sol)
    assert sol.elements["stick"] > 0
    assert sol.elements["slip"] > 0
    scaled = (
        law if not law.continuous else dataclasses.replace(law, half_velocity=0.2, velocity=500.0)
    )
    again = vc.solve(dataclasses.replace(sol.scene, friction=scaled))
    np.testing.assert_allclose(again.traction, sol.traction, atol=1e-9 * sol.traction_bound.max())


@pytest.mark.parametrize("tangential", ["tang-safeguarded", "clarabel", "scs"])
def test_methods_agree(tangential, line):
    law = vc.ExponentialFalling(0.3, 0.2, 4e-3)
    best, sol = vc.solve(line(law), tangential="tang"), vc.solve(line(law), tangential=tangential)
    np.testing.assert_allclose(sol.traction, best.traction, atol=1e-8 * best.traction_bound.max())
    assert "exponential, solution found from stick everywhere: coefficient 0.2" in sol.report()


@pytest.mark.long
@settings(max_examples=12, deadline=None)
@given(
    kind=st.sampled_from([kind for kind in LAWS if not LAWS[kind].local]),
    kinetic=st.floats(0.05, 0.3),
    half=st.floats(1e-3, 0.1),
    velocity=st.floats(0.1, 100.0),
    vx=st.floats(1e-4, 2e-2),
    vy=st.floats(-5e-3, 5e-3),
    start=st.sampled_from(["stick", "slip"]),
)
def test_any_law(kind, kinetic, half, velocity, vx, vy, start, line, holds):
    """Consistent with itself, and the same in other units of length, force and time."""
    speeds = (
        {} if kind == "static-kinetic" else {"half_velocity": half * velocity, "velocity": velocity}
    )
    sol = vc.solve(line(LAWS[kind](0.3, kinetic, **speeds), cells=16, vx=vx, vy=vy), start=start)
    holds(sol)
    faster = {name: 60.0 * value for name, value in speeds.items()}
    scene = line(LAWS[kind](0.3, kinetic, **faster), cells=16, vx=vx, vy=vy)
    bodies, surface = vc.Bodies(G=7e3, nu=0.28), vc.Cylinders(R=50.0)
    scene = dataclasses.replace(scene, bodies=bodies, surface=surface, normal_force=350.0)
    other = vc.solve(scene, start=start)
    np.testing.assert_allclose(
        other.traction / 7e3, sol.traction, atol=1e-7 * sol.traction_bound.max()
    )


@pytest.mark.long
@pytest.mark.parametrize("law", EVERY, ids=lambda law: type(law).__name__)
def test_forces_up_to_the_largest(law, line, holds):
    """The creep force has a maximum: just below it the force is met before it, and beyond it none
    is.
    """
    creepages = np.linspace(5.4e-3, 7.6e-3, 8)
    forces = [part(vc.solve(line(law, vx=vx))) for vx in creepages]
    largest, at = max(forces), creepages[np.argmax(forces)]
    sol = vc.solve(line(law, Fx=-0.99e-3 * largest))
    holds(sol)
    assert part(sol) == pytest.approx(0.99 * largest, rel=1e-9)
    assert 0.7 * at < sol.creepage[0] < at
    assert part(vc.solve(line(law, vx=sol.creepage[0]))) == pytest.approx(part(sol), abs=1e-3)
    with pytest.raises(vc.Saturated, match="under its law"):
        vc.solve(line(law, Fx=-1.01e-3 * largest))


def test_forces_beyond_friction(line):
    with pytest.raises(vc.Saturated):
        vc.solve(line(EVERY[0], Fx=-0.31e-3))
    # with the kinetic coefficient alone
    with pytest.raises(vc.Saturated, match="slip everywhere") as error:
        vc.solve(line(EVERY[0], Fx=-0.201e-3), start="slip")
    assert error.value.limit == pytest.approx(0.2e-3)


@pytest.mark.parametrize("law", EVERY, ids=lambda law: type(law).__name__)
def test_certificate_of_any_tractions(law, line):
    """It judges by the law: what slips at the static coefficient is wrong by what it has too
    much.
    """
    sol = vc.solve(line(law))
    scene = dataclasses.replace(sol.scene, grid=sol.grid)
    assert vc.certify(scene, sol.traction).residual < 1e-8
    static = vc.solve(line(0.3))
    slip = np.hypot(*static.slip)[static.state == 2]
    too_much = (
        np.max((0.3 - law(slip)) * static.pressure[static.state == 2])
        / np.hypot(*static.traction).max()
    )
    assert vc.certify(scene, static.traction).residual == pytest.approx(too_much, rel=1e-6)
    moved = vc.certify(scene, vc.solve(line(law, vx=3.001e-3)).traction)
    assert 1e-6 < moved.residual < 1e-2


@pytest.mark.parametrize("law", EVERY, ids=lambda law: type(law).__name__)
def test_johnson(law, ball, holds):
    """One pass of the coupling, in which the law holds for the pressure without tractions."""
    sol = vc.solve(ball(law, bodies=vc.Bodies(G=(1.0, 0.4), nu=(0.28, 0.2))), coupling="johnson")
    holds(sol)
    assert sol.certificate.normal_residual > 1e-3
    assert len(sol.passes) < 40


def test_sensitivity_with_two_coefficients(line):
    """Along either branch, by differences."""
    law = vc.StaticKinetic(0.3, 0.2)
    for start in ("stick", "slip"):
        sol = vc.solve(line(law), start=start)
        step = 1e-8
        ends = [vc.solve(line(law, vx=3e-3 + each), start=sol).force[0] for each in (-step, step)]
        assert sol.sensitivity()[0, 0] == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-5)


def test_following_a_branch(line, holds):
    """From a solution under another load the search stays on its branch, and so on."""
    law = vc.StaticKinetic(0.3, 0.15)
    sol = vc.solve(line(law, cells=60))
    for load in (1.02e-3, 1.04e-3):
        scene = dataclasses.replace(sol.scene, normal_force=load)
        after = vc.solve(scene, start=sol)
        holds(after)
        assert part(after) > part(vc.solve(scene, start="slip")) + 1e-5
        sol = after
