"""Almost like bodies: what their coupling changes at most, where it is left out, and that it is said."""

import dataclasses
import math

import numpy as np
import pytest

import varcontact as vc
from varcontact.scene.consistency import NEGLIGIBLE, coupling_effect, left_out

STEEL = vc.Bodies(G=82e9, nu=(0.28, 0.280009))
"""Two steels: K = 4.5e-6."""
BALL = {"surface": vc.Ellipse(a=1.2, b=0.9), "normal_force": 1.0, "grid": vc.Grid(nx=10, ny=10)}
LONG = {"surface": vc.Ellipse(a=0.4, b=2.5), "normal_force": 1.0, "grid": vc.Grid(nx=10, ny=10)}
LINE = {"surface": vc.Cylinders(R=1.0, reference_depth=4.0), "normal_force": 1e-2, "grid": vc.Grid(nx=30)}
X = np.linspace(-1.2, 1.2, 12)
PUNCH = {
    "surface": vc.SampledDistance((X**8 + X[:, None] ** 8) / 8 + 0.02 * X),
    "normal_force": 0.3,
    "grid": vc.Grid(
        nx=12, ny=12, dx=X[1] - X[0], dy=X[1] - X[0], x0=1.5 * X[0] - 0.5 * X[1], y0=1.5 * X[0] - 0.5 * X[1]
    ),
}


def bodies(K, nu=0.28):
    """Bodies with G = 1 and so much difference."""
    return vc.Bodies(G=1.0, nu=(nu - K, nu + K))


def scene(kind=BALL, **changes):
    return vc.Scene(**{"bodies": bodies(1e-6), "friction": 0.3, "motion": vc.Steady(vx=0.01), **kind, **changes})


def steels(**changes):
    wheel = {"surface": vc.Paraboloids(Rx=0.46, Ry=0.30), "normal_force": 106.7e3, "grid": vc.Grid(nx=12, ny=12)}
    return scene(wheel, **{"bodies": STEEL, "motion": vc.Steady(vx=1e-3), **changes})


def motions(f):
    """Creepages and shifts from hardly any slip to much, in the proportion of friction."""
    return {
        "creeping": (BALL, vc.Steady(vx=1e-3 * f)),
        "rolling": (BALL, vc.Steady(vx=0.1 * f, vy=-0.05 * f, spin=0.1 * f)),
        "short steps": (BALL, vc.Steady(vx=0.02 * f, spin=0.1 * f, dq=0.06)),
        "long": (LONG, vc.Steady(vy=0.1 * f, spin=0.05 * f)),
        "shift": (BALL, vc.Shift(ux=0.2 * f, rotation=0.2 * f)),
        "cylinder": (LINE, vc.Steady(vx=1e-3 * f, vy=0.02 * f)),
        "shifted cylinder": (LINE, vc.Shift(ux=2e-3 * f, uy=1e-3 * f)),
        "punch": (PUNCH, vc.Steady(vx=0.01 * f)),
    }


@pytest.mark.parametrize("f", [0.03, 0.3, 2.0])
@pytest.mark.parametrize("name", motions(1.0))
@pytest.mark.parametrize("part", [0.1, 0.99])
def test_the_effect_bounds_what_the_coupling_changes(f, name, part):
    """With and without the coupling, by the same methods: forces differ by less than the plan says, at any size."""
    kind, motion = motions(f)[name]
    K = part * NEGLIGIBLE / coupling_effect(bodies(1.0e-3), f) * 1e-3
    described = scene(kind, bodies=bodies(-K), friction=f, motion=motion)
    methods = {"normal": "norm", "tangential": "tang-safeguarded", "tol": 1e-9}
    alike, unlike = vc.solve(described, **methods), vc.solve(described, coupling="panagiotopoulos", **methods)
    assert alike.plan.left_out == pytest.approx(part * NEGLIGIBLE, rel=1e-4)
    assert (alike.plan.coupling, unlike.plan.coupling) == ("none", "panagiotopoulos")
    change = np.hypot(*(alike.force - unlike.force)) / (f * unlike.normal_force)
    assert change < alike.plan.left_out
    if name == "creeping":
        assert change > 0.02 * alike.plan.left_out  # and it is there


def test_in_a_history_the_changes_do_not_add_up():
    """Twenty steps of alternating creepage and load."""
    k = np.arange(20)
    motion = vc.Transient(steps=20, dq=0.2, vx=0.02 * np.cos(k), spin=0.01, normal_force=1 + 0.4 * np.sin(0.7 * k))
    described = scene(
        {"surface": vc.Paraboloids(1.0, 1.5), "grid": vc.Grid(nx=8, ny=8)}, bodies=bodies(5e-6), motion=motion
    )
    alike, unlike = (vc.solve(described, normal="norm", coupling=coupling) for coupling in ("auto", "panagiotopoulos"))
    assert alike.grid == unlike.grid
    change = np.hypot(*(alike.force - unlike.force).T) / (0.3 * alike.normal_force)
    assert 0 < change.max() < alike[0].plan.left_out <= NEGLIGIBLE
    assert alike[0].traction.any()


def test_a_cylinder_without_slip_has_the_closed_form():
    """A pressure p rolled without slip leaves ``beta p sqrt((a - x)/(a + x))``: 4/pi beta Fz, beta = |K|/(1 - nu)."""
    K, f = 1e-4, 1.0
    rolling = scene(LINE, bodies=bodies(K), friction=f, motion=vc.Steady(vx=1e-9), normal_force=1e-2)
    found = [
        vc.solve(dataclasses.replace(rolling, grid=vc.Grid(nx=n)), coupling="panagiotopoulos") for n in (50, 100, 200)
    ]
    parts = [abs(sol.force[0]) / sol.normal_force * (1 - 0.28) / K for sol in found]
    errors = np.abs(np.array(parts) - 4 / math.pi)
    assert errors[2] < 0.02
    assert np.all(errors[1:] < 0.7 * errors[:-1])


def test_the_effect_is_a_formula():
    """Largest where friction is least; elements without friction carry nothing."""
    K, nu = 1e-5, 0.25
    pair = bodies(K, nu)
    assert coupling_effect(pair, 0.5) == pytest.approx(4 * K / 0.75 * 2.5, rel=1e-9)
    assert coupling_effect(pair, 0.5) == coupling_effect(bodies(-K, nu), 0.5)
    assert coupling_effect(pair, np.array([[0.5, 0.0], [0.1, 0.5]])) == coupling_effect(pair, 0.1)
    assert coupling_effect(pair, math.inf) == math.inf
    assert coupling_effect(vc.Bodies(G=1.0, nu=0.3), 0.1) == 0.0
    assert coupling_effect(pair, 0.0) == 0.0


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"bodies": bodies(1e-4)}, "K is larger"),
        ({"friction": 0.01}, "the same K shifts the surfaces more than so little friction bears"),
        ({"friction": math.inf}, "nothing limits the tractions"),
        ({"friction": vc.StaticKinetic(0.3, 0.2)}, "the least change may lead to another solution"),
        ({"motion": vc.Steady(Fx=0.0)}, "the pressure is all that moves the surfaces"),
        ({"motion": vc.Shift()}, "the pressure is all that moves the surfaces"),
        ({"motion": vc.Transient(steps=2)}, "the pressure is all that moves the surfaces"),
        ({"motion": vc.Transient(steps=2, vx=0.01, friction=[0.3, 0.01])}, "one step has little friction"),
    ],
)
def test_where_the_coupling_is_kept(changes, why):
    described = scene(**{"bodies": bodies(2e-6), **changes})
    assert left_out(described) == 0.0, why
    plan = vc.plan(described)
    assert (plan.coupling, plan.bodies, plan.left_out) == ("panagiotopoulos", "unlike", 0.0)


@pytest.mark.parametrize("changes", [{"friction": 0.0}, {"motion": None, "friction": None}])
def test_where_there_is_no_coupling_nothing_is_left_out(changes):
    assert vc.plan(scene(**changes)).left_out == 0.0


def test_two_steels_have_their_bound_and_their_closed_form_again(tmp_path):
    """And everywhere it is said: plan, report, JSON, file."""
    sol = vc.solve(steels())
    assert (sol.plan.normal, sol.plan.coupling, sol.plan.bodies) == ("hertz", "none", "almost like")
    assert sol.passes == ()
    assert np.all(np.isfinite(sol.certificate.force_bound))
    effect = coupling_effect(STEEL, 0.3)
    assert sol.summary()["left_out"] == sol.plan.left_out == sol.plan.summary()["left_out"] == effect
    said = f"by less than {effect:.1e} of f Fz"
    assert said in sol.plan.reasons["coupling"]
    assert 'coupling="panagiotopoulos" includes it' in str(vc.plan(steels()))
    assert "almost like: K = 4.5e-06" in str(vc.plan(steels()))
    assert "rolling of almost like bodies (K = 4.5e-06)" in sol.report()
    assert said in sol.report().split("certificate")[1].split("normal  ")[0]
    sol.save(tmp_path / "steels.nc")
    assert vc.load(tmp_path / "steels.nc").plan == sol.plan
    like = vc.solve(steels(bodies=vc.Bodies(STEEL.combined_G, STEEL.combined_nu)))
    np.testing.assert_allclose(sol.traction, like.traction, rtol=0, atol=1e-9 * like.traction_bound.max())
    np.testing.assert_allclose(
        sol.sensitivity(), like.sensitivity(), rtol=1e-6, atol=1e-6 * np.abs(like.sensitivity()).max()
    )
    assert like.plan.left_out == 0.0
    assert "almost like" not in like.report()


def test_theories_and_scans_take_almost_like_bodies():
    rolling = vc.solve(steels(), tangential="fastsim")
    assert rolling.plan.left_out > 0
    first, second = vc.scan(steels(motion=vc.Steady()), [(5e-4, 0, 0), (1e-3, 0, 0)])
    assert first.plan.left_out == second.plan.left_out > 0
    assert second.force[0] == pytest.approx(vc.solve(steels()).force[0], rel=1e-8)
    with pytest.raises(vc.SceneError, match="quasi-identical bodies"):
        vc.solve(steels(bodies=vc.Bodies(82e9, (0.28, 0.3))), tangential="fastsim")


def test_the_coupling_can_be_asked_for():
    forced = vc.solve(steels(), coupling="panagiotopoulos")
    assert (forced.plan.normal, forced.plan.bodies, forced.plan.left_out) == ("norm", "unlike", 0.0)
    assert len(forced.passes) >= 1
    assert "left out" not in forced.report()
    assert np.isinf(forced.certificate.force_bound[0])
