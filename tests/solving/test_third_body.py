"""Third-body layers: one element by hand, CONTACT's results, Carter's problem, limits, and two
solvers.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import lqmn

import varcontact as vc
from tests.scenes import make_scene, refused

CASES = json.loads((Path(__file__).parents[1] / "data" / "third_body.json").read_text())["cases"]
BODIES = vc.Bodies(G=82e3, nu=0.28)
LAYER = vc.ThirdBody(h=0.02, G=820.0, tau_c0=100.0, k_tau=2000.0)
GRID = vc.Grid(nx=14, ny=14, dx=1.1, dy=1.1, x0=-7.7, y0=-7.7)


def ball(motion, layer=LAYER, grid=GRID):
    return make_scene(
        vc.Paraboloids(625.0, 625.0), 1e5, motion, grid, bodies=BODIES, third_body=layer
    )


def one_element(shifts, layer):
    distance = np.ones((3, 3))
    distance[1, 1] = 0.0
    motion = vc.Transient(steps=len(shifts), dq=0.0, ux=[-shift for shift in shifts])
    grid = vc.Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=-1.5, y0=-1.5)
    return vc.solve(
        make_scene(
            vc.SampledDistance(h=distance), 900.0, motion, grid, 0.7, BODIES, third_body=layer
        )
    )


def test_element_of_clay_hardens_as_by_hand():
    steps = one_element([0.04] * 4 + [0.036], clay := vc.ThirdBody(0.02, 106.25, 200.0, 435.0))
    # Alone an element gives way by 0.001 mm for 84.966015 MPa; with the layer at yield by 1/k more.
    elastic = 0.001 / 84.96601523936 + clay.compliance
    expected = [0.04 / elastic]
    shifts = np.cumsum([0.04, 0.04, 0.04, 0.04, 0.036])[1:]
    expected += [(shift + 200.0 / 435.0) / (elastic + 1 / 435.0) for shift in shifts]
    assert np.allclose(steps.force[:, 0], expected, rtol=1e-11)
    assert [int(step.state[1, 1]) for step in steps] == [1, 3, 3, 3, 3]
    last = steps[-1].plastic[:, 1, 1]
    assert np.allclose(last, [(expected[-1] - 200.0) / 435.0, 0.0, expected[-1]], rtol=1e-11)
    # unloading is elastic, and the next yield begins where the last ended
    there = one_element([0.08, -0.03, 0.03, 0.01], clay)
    assert there[1].Fx == pytest.approx(there[0].Fx - 0.03 / elastic, rel=1e-11)
    assert there[2].Fx == pytest.approx(there[0].Fx, rel=1e-11)
    assert there[3].Fx == pytest.approx(there[0].Fx + 0.01 / (elastic + 1 / 435.0), rel=1e-11)


def test_softening_is_a_history_with_a_warning():
    steps = one_element([0.04, 0.04, 0.04], soft := vc.ThirdBody(0.02, 106.25, 200.0, -435.0))
    elastic = 0.001 / 84.96601523936 + soft.compliance
    expected = [(shift - 200.0 / 435.0) / (elastic - 1 / 435.0) for shift in (0.08, 0.12)]
    assert np.allclose(steps.force[1:, 0], expected, rtol=1e-8)
    assert "need not be the only one" in steps.report()
    refused(lambda: ball(vc.Steady(vx=1e-3), soft), match="history")


@pytest.mark.parametrize("case", CASES)
def test_steady_rolling_is_that_of_contact(case):
    layer = vc.ThirdBody(case["h"], case["G"], case["tau_c0"] or np.inf, case["k_tau"])
    n, dx, x0 = case["n"], case["dx"], case["x0"]
    scene = ball(
        vc.Steady(vx=case["vx"]), layer, grid=vc.Grid(nx=n, ny=n, dx=dx, dy=dx, x0=x0, y0=x0)
    )
    sol = vc.solve(scene, normal="norm")
    assert abs(sol.Fx - case["Fx"]) < 1e-9 * 0.3e5
    assert "".join(".*SP"[k] for k in sol.state.ravel()) == case["elements"]
    assert sol.friction_work == pytest.approx(sol.power, rel=1e-9)
    assert sol.elements.get("plastic", 0) == np.sum(sol.state == 3)
    if layer.yields:
        assert "plastic" in sol.report() and "flow of the third body" in sol.report()
        assert "omit the grid" not in sol.report()  # `accuracy` refuses layers


@pytest.mark.parametrize("layer", [vc.ThirdBody(0.02, 820.0), replace(LAYER, k_tau=0.0), LAYER])
def test_heat_is_work_of_friction_and_of_flow(layer):
    """Elastic shear of the layer gives back all it took: what is left is ``|p| (|slip| + |flow|)``,
    to first order.
    """
    sums, fields = [], []
    for n in (14, 28):
        side = 15.4 / n
        sol = vc.solve(
            ball(
                vc.Steady(vx=3e-3),
                layer,
                grid=vc.Grid(nx=n, ny=n, dx=side, dy=side, x0=-7.7, y0=-7.7),
            )
        )
        size, heat = np.hypot(*sol.traction), np.hypot(*sol.slip) * np.hypot(*sol.traction)
        if layer.yields:  # along the rows, from the leading edge
            flow = sol.plastic[:2] - np.pad(sol.plastic[:2, :, 1:], ((0, 0), (0, 0), (0, 1)))
            heat += size * np.hypot(*flow) / side
        assert sol.friction_work == pytest.approx(sol.power, rel=1e-9)
        assert sol.power_density.min() > -1e-9 * sol.power_density.max()
        inside = np.abs(sol.grid.x) < 5.5  # away from the edges, where tractions are steep
        fields.append(
            np.abs((sol.power_density - heat)[:, inside]).sum() * sol.grid.area / sol.power
        )
        sums.append(1 - heat.sum() * sol.grid.area / sol.power)
    for off in (sums, fields):
        assert 1.4 * off[1] < off[0] < 0.14


@pytest.mark.parametrize(("k_tau", "part"), [(4018e3, 0.6562), (123e3, 0.6420), (0.0, 0.5959)])
def test_carter_with_plasticity(k_tau, part):
    grid, layer = vc.Grid(nx=30, dx=0.08, x0=-1.2), vc.ThirdBody(0.0, 82e3, 35.0, k_tau)
    scene = make_scene(
        vc.Cylinders(500.0), 178.9, vc.Steady(vx=-4e-4), grid, 0.5, BODIES, third_body=layer
    )
    assert vc.solve(scene, normal="norm").Fx / (0.5 * 178.9) == pytest.approx(part, abs=1e-4)


def carter(compliance, a, peak, vx, terms=40):
    """Force, and where stick ends, of a strip on an elastic layer, by quadrature; friction bears
    ``peak`` at most.

    In stick ``L p' - 2 (1 - nu)/(pi G) PV int p/(x - xi) = vx`` and p = 0 in front: Legendre's
    polynomials, whose Cauchy integrals are twice the functions of the second kind. Where it ends p
    is continuous.
    """
    factor = 2 * (1 - BODIES.combined_nu) / (np.pi * BODIES.combined_G)
    t, _ = np.polynomial.legendre.leggauss(terms)
    basis = [np.polynomial.legendre.Legendre.basis(n) for n in range(terms + 1)]
    second = np.array([lqmn(0, terms, each)[0][0] for each in t])

    def stick(c):
        half = (a - c) / 2
        slips = [
            quad(
                lambda u, x=x: a * np.cos(u) ** 2 / (x - a * np.sin(u)),
                -np.pi / 2,
                np.arcsin(c / a),
                limit=200,
            )[0]
            for x in (a + c) / 2 + half * t
        ]
        slopes = np.array([each.deriv()(t) for each in basis]).T / half
        system = np.vstack([compliance * slopes - 2 * factor * second, np.ones(terms + 1)])
        return np.linalg.solve(system, np.append(vx - factor * peak * np.array(slips), 0.0))

    def jump(c):
        return np.polynomial.legendre.legval(-1.0, stick(c)) + peak * np.sqrt(1 - (c / a) ** 2)

    c = brentq(jump, -0.99 * a, 0.9 * a)
    return (a - c) * stick(c)[0] - peak / a * quad(lambda x: np.sqrt(a * a - x * x), -a, c)[0], c


@pytest.mark.parametrize("ratio", [0.3, 3.0])
def test_carter_with_an_elastic_layer_converges_to_quadrature(ratio):
    a, vx, compliance = 1.0, 3e-4, ratio / BODIES.combined_G
    hertz = vc.reference.line_contact(500.0, BODIES, a=a)
    exact, end = carter(compliance, a, 0.3 * hertz.peak_pressure, vx)
    errors, second = [], []
    for n in (40, 80):
        grid, layer = vc.Grid(nx=n, dx=2 * a / n, x0=-a), vc.ThirdBody(compliance * 100.0, 100.0)
        motion = vc.Steady(vx=vx)
        scene = make_scene(
            vc.Cylinders(500.0), hertz.force, motion, grid, bodies=BODIES, third_body=layer
        )
        sol = vc.solve(scene)
        errors.append(sol.Fx / exact - 1)
        second.append(vc.solve(scene.second_order()).Fx / exact - 1)
        assert abs(sol.elements["slip"] * 2 / n - 1 - end) < 1.01 / n
    assert 0 < errors[1] < 0.012 and 0.9 < np.log2(errors[0] / errors[1]) < 1.15
    assert 0 < second[1] < 0.36 * errors[1]


@pytest.mark.parametrize(
    ("layer", "motion"),
    [
        (vc.ThirdBody(0.02, 820.0), vc.Steady(vx=5e-4, vy=3e-4, spin=2e-4)),
        (vc.ThirdBody(0.2, 820.0), vc.Steady(Fx=-1.5e4)),
        (replace(LAYER, k_tau=0.0), vc.Steady(vx=1.5e-3)),
        (vc.ThirdBody(0.0, 820.0, 100.0), vc.Steady(vx=1.5e-3)),
        (LAYER, vc.Shift(ux=0.02, uy=0.004)),
    ],
)
def test_an_accuracy_is_kept_with_layers(layer, motion):
    scene, rolls = ball(motion, layer, grid="auto"), isinstance(motion, vc.Steady)
    grid = vc.Grid(nx=72 if rolls else 48, ny=48, edge="softened" if rolls else "touched")
    fine = vc.solve(replace(scene, grid=grid, motion=motion.second_order() if rolls else motion))
    for accuracy in (0.03, 0.01):
        estimate = vc.solve(scene, accuracy=accuracy).error_estimate
        assert estimate.largest <= accuracy
        for name, bar in estimate.bars.items():
            assert abs(estimate.values[name] - getattr(fine, name)) < bar


@pytest.mark.long
def test_an_accuracy_is_kept_with_hardening():
    layer = vc.ThirdBody(0.0, 82e3, 35.0, 4018e3)
    motion = vc.Steady(vx=-4e-4)
    scene = make_scene(
        vc.Cylinders(500.0), 178.9, motion, friction=0.5, bodies=BODIES, third_body=layer
    )
    coarse, fine = (vc.solve(replace(scene, grid=vc.Grid(nx=n))).Fx for n in (120, 240))
    sol = vc.solve(scene, accuracy=0.01)
    assert sol.error_estimate.largest < 0.01
    assert abs(sol.Fx - (2 * fine - coarse)) < sol.error_estimate.bars["Fx"]
    assert vc.solve(scene).error_estimate is None  # unless it is asked for: it takes long
    turning, limits = (
        ball(vc.Steady(vx=1e-3, spin=3e-4), grid="auto"),
        {"Fx": -7738.3, "Fy": -7606.1},
    )
    # limits from 80 and 160 elements across, between which errors fall as these grow
    for accuracy in (0.05, 0.03):
        estimate = vc.solve(turning, accuracy=accuracy).error_estimate
        assert estimate.largest < accuracy
        assert all(
            abs(estimate.values[name] - limit) < estimate.bars[name]
            for name, limit in limits.items()
        )


def test_limits_of_a_layer():
    rolling = vc.Steady(vx=2e-3, vy=5e-4)
    bare = vc.solve(ball(rolling, None)).force
    off = [
        np.abs(vc.solve(ball(rolling, vc.ThirdBody(h, 820.0))).force - bare).max()
        for h in (2e-5, 1e-5)
    ]
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.02) and off[1] < 1e-3 * np.hypot(*bare)
    elastic = vc.solve(ball(rolling, vc.ThirdBody(0.02, 820.0))).force
    strong = vc.solve(ball(rolling, vc.ThirdBody(0.02, 820.0, 1e4, 100.0))).force
    assert np.allclose(strong, elastic, rtol=1e-9)
    shift = vc.Shift(ux=0.02, uy=0.004)
    cap = vc.solve(ball(shift, vc.ThirdBody(0.02, 820.0, 100.0))).force
    off = [
        np.abs(vc.solve(ball(shift, vc.ThirdBody(0.02, 820.0, 100.0, k))).force - cap).max()
        for k in (2.0, 1.0)
    ]
    assert off[0] / off[1] == pytest.approx(2.0, rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize("motion", [vc.Shift(ux=0.02, uy=0.004), vc.Shift(Fx=-1.5e4, uy=0.003)])
@pytest.mark.parametrize("k_tau", [1e5, 500.0])
def test_programs_newton_and_active_sets_agree(motion, k_tau):
    scene = ball(motion, replace(LAYER, k_tau=k_tau))
    found = [
        vc.solve(scene, tangential=name) for name in ("newton", "tang-safeguarded", "clarabel")
    ]
    found += [
        vc.solve(scene, tangential="clarabel", polish=False, formulation="complementary", tol=1e-7)
    ]
    found += [
        vc.solve(scene, tangential="clarabel", polish=False, formulation="potential", tol=1e-6)
    ]
    found += [vc.solve(scene, tangential="clarabel", polish=False, formulation="gap", tol=1e-7)]
    for sol in found:
        assert sol.certificate.relative_gap < 1e-8
        assert np.all(np.abs(sol.force - found[0].force) < 1e-8 * 0.3e5)
        assert np.all(np.abs(sol.traction - found[0].traction) < 1e-5 * 0.3 * sol.max_pressure)
    assert {2, 3} <= set(found[0].state.ravel())


@pytest.mark.long
@pytest.mark.parametrize("dq", [0.7, 1.0, 1.6])
@pytest.mark.parametrize("motion", [vc.Steady(vx=2e-3, vy=1e-3, spin=1e-4), vc.Steady(Fx=-1.7e4)])
def test_newton_finds_hardening_in_steady_rolling_at_once(dq, motion):
    """That active sets find in passes over the yield stress; Newton's method knows how it follows
    from tractions.
    """
    scene = ball(
        replace(motion, dq=1.54 * dq),
        grid=vc.Grid(nx=10, ny=10, dx=1.54, dy=1.54, x0=-7.7, y0=-7.7),
    )
    newton, passes = (vc.solve(scene, tangential=name) for name in ("newton", "tang-safeguarded"))
    assert np.all(np.abs(newton.force - passes.force) < 1e-9 * 0.3e5)
    assert np.all(np.abs(newton.plastic - passes.plastic) < 1e-7 * np.abs(passes.plastic).max())
    assert newton.certificate.relative_gap < 1e-9
    assert newton.iterations["tangential"] < 30 < 0.5 * passes.iterations["tangential"]


def test_gap_bounds_the_distance_of_any_tractions():
    from varcontact.discrete.discretisation import discretise
    from varcontact.discrete.residuals import gap

    scene = ball(vc.Shift(ux=0.02, uy=0.004))
    exact = vc.solve(scene, normal="norm")
    disc = discretise(scene, exact.grid)
    problem = disc.tangential_problem(exact.pressure / disc.scales.pressure)
    best = problem.of_grid(exact.traction / disc.scales.pressure, np.zeros(2))[0]
    rng = np.random.default_rng(1)
    for size in (1e-8, 1e-4, 1e-1):
        tried = problem.potential.projected(best + size * rng.normal(size=best.shape), np.inf)
        apart = (tried - best).ravel()
        energy = problem.area * float(apart @ problem.operator.matrix @ apart)
        assert 0 < energy <= gap(problem, tried, np.zeros(2))[0]


@pytest.mark.long
def test_history_goes_over_into_steady_rolling():
    grid = vc.Grid(nx=8, ny=8, dx=1.95, dy=1.95, x0=-7.8, y0=-7.8)
    steady = vc.solve(ball(vc.Steady(vx=3e-3, vy=1e-3, dq=1.4), grid=grid))
    steps = vc.solve(ball(vc.Transient(steps=60, vx=3e-3, vy=1e-3, dq=1.4), grid=grid))
    assert np.allclose(steps[-1].force, steady.force, rtol=1e-6)
    assert np.allclose(
        steps[-1].plastic, steady.plastic, rtol=1e-5, atol=1e-5 * np.abs(steady.plastic[:2]).max()
    )
    back = vc.solve(
        ball(vc.Transient(steps=9, vx=-3e-3, vy=-1e-3, dq=1.4, direction=-1), grid=grid)
    )
    assert np.allclose(back[-1].force, -steps[8].force, rtol=1e-9)


@pytest.mark.long
def test_unlike_bodies_by_two_couplings():
    wide = vc.Grid(nx=14, ny=14, dx=1.3, dy=1.3, x0=-9.1, y0=-9.1)
    scene = replace(
        ball(vc.Shift(ux=0.02), grid=wide), bodies=vc.Bodies((82e3, 30e3), (0.28, 0.35))
    )
    turns = vc.solve(scene, coupling="panagiotopoulos")
    joint = vc.solve(scene, coupling="joint", tangential="clarabel")
    assert np.all(np.abs(turns.force - joint.force) < 1e-7 * 0.3e5)


@pytest.mark.parametrize(
    ("entries", "name"),
    [
        ({"h": -1.0, "G": 1.0}, "h"),
        ({"h": 1.0, "G": 0.0}, "G"),
        ({"h": 1.0, "G": 1.0, "tau_c0": -5.0}, "tau_c0"),
        ({"h": 1.0, "G": 1.0, "tau_c0": np.ones(2)}, "tau_c0"),
        ({"h": 1.0, "G": 1.0, "k_tau": 5.0}, "k_tau"),
    ],
)
def test_layers_that_cannot_be(entries, name):
    refused(lambda: vc.ThirdBody(**entries), match=f"third_body.{name}")


def test_layers_where_they_do_not_belong():
    refused(lambda: replace(ball(vc.Shift(ux=0.1)), friction=np.inf), match="friction")
    with pytest.raises(vc.SceneError, match="third body"):
        vc.solve(ball(vc.Steady(vx=1e-3)), tangential="vermeulen-johnson")
    unlike = replace(
        ball(vc.Steady(vx=1e-3), grid="auto"), bodies=vc.Bodies((82e3, 30e3), (0.28, 0.35))
    )
    refused(lambda: vc.solve(unlike, accuracy=0.01), match=r"third_body.k_tau.*Hertzian")
    refused(ball(vc.Steady(vx=1e-3)).second_order, match=r"third_body.k_tau.*first-order")


def test_batches_leave_layers_to_single_solutions():
    scene = ball(vc.Steady(vx=3e-3))
    many = vc.solve_many([scene, replace(scene, third_body=None)])
    assert [str(by) for by in many["by"].values] == ["solve", "batched"]
    assert float(many["Fx"][0]) == pytest.approx(vc.solve(scene).Fx, rel=1e-8)
