"""Viscoelastic bodies that roll steadily: Hunter's closed form, CONTACT, limits of the speed, two
solvers.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.elasticity.operators import influence_operator
from varcontact.reference import hunter
from varcontact.solvers.registry import SOLVERS

DATA = Path(__file__).parents[1] / "data" / "contact_viscoelastic.json"
CASES = {case["tag"]: case for case in json.loads(DATA.read_text())["cases"]}
SOLID = vc.Viscoelastic(1.0, 0.3, [(1.0, 0.1), (0.5, 1.0)])


def roller(bodies=SOLID, speed=1.0, cells=30, line=True, friction=0.3, **motion):
    surface = vc.Cylinders(R=1.0) if line else vc.Paraboloids(1.0, 1.0)
    grid = vc.Grid(nx=cells) if line else vc.Grid(nx=cells, ny=cells)
    return make_scene(surface, 0.1, vc.Steady(speed=speed, **motion), grid, friction, bodies)


@pytest.mark.parametrize(
    ("length", "force", "moment"),
    [
        (0.1, 0.8250766609, 0.0463491206),
        (1.0, 1.1536781873, 0.2331290558),
        (30.0, 1.5672984851, 0.0626657685),
    ],
)
def test_hunter(length, force, moment):
    """Load and moment against integrated pressures of an independent computation; resistance on two
    grids.
    """
    exact = hunter(a=1.0, R=1.0, G=2.0, nu=0.0, part=1.0, relaxation_length=length)
    assert exact.force == pytest.approx(force, rel=1e-9)
    assert exact.moment / exact.force == pytest.approx(moment, rel=1e-8)
    body = vc.Viscoelastic(2.0, 0.0, [(1.0, length)])
    for cells, off in ((60, 2e-3), (240, 2e-4)):
        scene = replace(roller(body, cells=cells, friction=0.0), normal_force=exact.force)
        sol = vc.solve(scene)
        assert sol.rolling_resistance == pytest.approx(exact.moment, rel=off)
        assert sol.certificate.normal_relative_gap < 1e-12
    x, spread = sol.grid.x[sol.pressure[0] > 0], sol.grid.sides[0]
    assert x.min() == pytest.approx(exact.centre - 1, abs=spread)
    assert x.max() == pytest.approx(exact.centre + 1, abs=spread)


@pytest.mark.parametrize("tag", ["own_1", "own_3", "example_case_1", "example_case_3"])
def test_contact_of_cylinders(tag):
    """One row of long rectangles, ends free; by forces in CONTACT's example, by creepages in the
    others.
    """
    case = CASES[tag]
    tau = (
        case["inputs"]["tc1"]
        if "inputs" in case
        else {"example_case_1": 1e-12, "example_case_3": 0.045}[tag]
    )
    x = -7.92 + 0.16 * np.arange(99)
    apart = np.full(99, 1e4)
    motion = vc.Steady(Fx=-0.18 * case["Fn"], speed=1000.0)
    if "inputs" in case:
        motion = vc.Steady(vx=case["vx"], speed=case["veloc"])
    surface = vc.SampledDistance(np.array([apart, 0.01 * x**2, apart]))
    grid = vc.Grid(nx=99, ny=3, dx=0.16, dy=1000.0, x0=-8.0, y0=-1500.0)
    bodies = vc.Viscoelastic(1143.0, 0.4, [(1.0, tau)])
    sol = vc.solve(make_scene(surface, case["Fn"], motion, grid, bodies=bodies))
    np.testing.assert_allclose(sol.pressure[1], case["pressure"], atol=1e-6 * case["pmax"])
    np.testing.assert_allclose(sol.traction[0, 1], case["traction"], atol=1e-6 * 0.3 * case["pmax"])
    assert (sol.elements["stick"], sol.elements["slip"]) == (case["nadh"], case["nslip"])
    assert sol.approach == pytest.approx(case["pen"], rel=1e-9)
    assert sol.vx == pytest.approx(case["vx"], rel=1e-8)
    assert sol.Fx == pytest.approx(case["Fx"], abs=1e-7 * 0.3 * case["Fn"])
    assert sol.rolling_resistance == pytest.approx(
        -0.02 * case["My"], rel=1e-8, abs=1e-10 * case["Fn"]
    )


@pytest.mark.parametrize("options", [{}, {"coupling": "panagiotopoulos", "method": "active-set"}])
def test_contact_of_a_sphere_on_another_material(options):
    case = CASES["own_7"]
    given = case["inputs"]
    motion = vc.Steady(vx=case["vx"], vy=case["vy"], speed=case["veloc"])
    grid = vc.Grid(nx=36, ny=36, dx=0.5, dy=0.5, x0=-9.0, y0=-9.0)
    other = vc.Viscoelastic(given["G2"], given["nu2"], [(given["fg2"], given["tc2"])])
    bodies = (vc.Bodies(given["G1"], given["nu1"]), other)
    scene = make_scene(vc.Paraboloids(50.0, 50.0), case["Fn"], motion, grid, given["mu"], bodies)
    sol = vc.solve(scene, **options)
    limit = given["mu"] * case["Fn"]
    np.testing.assert_allclose(sol.force, [case["Fx"], case["Fy"]], atol=1e-8 * limit)
    assert sol.moment == pytest.approx(case["Mz"], abs=1e-7 * limit)
    assert sol.approach == pytest.approx(case["pen"], rel=1e-9)
    assert (sol.elements["stick"], sol.elements["slip"]) == (case["nadh"], case["nslip"])
    assert sol.certificate.residual < 1e-8


@pytest.mark.parametrize("line", [True, False])
def test_slow_and_fast_rolling_are_elastic(line):
    """Relaxed bodies, and glassy ones."""
    for speed, G in ((1e-7, 0.4), (1e7, 1.0)):
        sol = vc.solve(roller(speed=speed, cells=12, line=line, vx=0.01))
        scene = replace(
            sol.scene, bodies=vc.Bodies(G, 0.3), motion=vc.Steady(vx=0.01), grid=sol.grid
        )
        elastic = vc.solve(scene, normal="norm")
        np.testing.assert_allclose(sol.pressure, elastic.pressure, atol=1e-4 * elastic.max_pressure)
        assert sol.Fx == pytest.approx(elastic.Fx, rel=1e-4)
        assert abs(sol.rolling_resistance) < 1e-4 * sol.normal_force


@pytest.mark.parametrize("line", [True, False])
@pytest.mark.parametrize("load", ["force", "approach"])
def test_solvers_agree(line, load):
    """NORM by LU, Newton's method without a matrix, and the one convex program, whose optimal value
    is zero.
    """
    scene = roller(cells=14 if line else 10, line=line, friction=0.0)
    first = vc.solve(scene)
    if load == "approach":
        surface = vc.Cylinders(R=1.0, reference_depth=3.0) if line else scene.surface
        scene = replace(scene, surface=surface, normal_force=None, approach=0.06)
        first = vc.solve(scene)
    scene = replace(scene, grid=first.grid)
    assert first.certificate.normal_relative_gap < 1e-12
    for options in ({"normal": "newton"}, {"normal": "clarabel", "polish": False}):
        other = vc.solve(scene, tol=1e-9, **options)
        np.testing.assert_allclose(other.pressure, first.pressure, atol=1e-6 * first.max_pressure)
        assert abs(other.certificate.normal_relative_gap) < 1e-6


SOFTENS = vc.Scene(
    bodies=vc.Viscoelastic(1.0, 0.3517, [(96.39, 2.701)]),
    surface=vc.Paraboloids(0.6853, 0.6118),
    normal_force=0.00875,
    friction=0.3,
    motion=vc.Steady(vx=0.0222, vy=0.0084, spin=-0.0456, speed=1.0),
    grid=vc.Grid(nx=96, ny=96),
)
"""A solid that becomes a hundred times as soft: its kernel is as skew as that of a step of
rolling."""


@pytest.mark.long
def test_a_large_relaxation_on_many_elements():
    """Approach and largest pressure of NORM in dense matrices, vc.solve(SOFTENS, normal="norm"), in
    85 s.
    """
    sol = vc.solve(SOFTENS)
    assert sol.approach == pytest.approx(0.3020286012055, rel=1e-8)
    assert sol.max_pressure == pytest.approx(0.1155694040715, rel=1e-8)
    assert sol.force == pytest.approx([-4.46607774e-04, 4.67554302e-05], rel=1e-6)


def test_a_pressure_that_is_not_found_is_no_contact_area():
    """A solver that gives up leaves no pressure of a solid that relaxes."""

    def lost(problem, settings, start):
        raise ArithmeticError("no way down")

    with pytest.raises(vc.NotConverged, match=r"lost gave no pressure, it says: .*no way down"):
        vc.solve(SOFTENS, normal=lost)
    del SOLVERS["normal", "lost"]


@pytest.mark.long
@pytest.mark.parametrize("line", [True, False])
@pytest.mark.parametrize("other", [None, vc.Bodies(2.0, 0.25)])
def test_a_body_cut_into_layers(line, other):
    """Layers and a base of one solid are a homogeneous body of it."""
    relaxations = [(1.0, 0.1), (0.5, 1.0)]
    cut = vc.Layered(
        [vc.Layer(0.05, 1.0, 0.3), vc.Layer(0.2, 1.0, 0.3)],
        base=(1.0, 0.3),
        relaxations=relaxations,
    )
    pair, whole = (cut, SOLID) if other is None else ((cut, other), (SOLID, other))
    scene = roller(whole, cells=12 if line else 8, line=line, vx=0.01)
    expected = vc.solve(scene)
    sol = vc.solve(replace(scene, bodies=pair, grid=expected.grid))
    np.testing.assert_allclose(sol.pressure, expected.pressure, atol=1e-6 * expected.max_pressure)
    np.testing.assert_allclose(sol.traction, expected.traction, atol=1e-6 * expected.max_pressure)
    assert sol.rolling_resistance == pytest.approx(expected.rolling_resistance, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("line", [True, False])
def test_a_viscoelastic_layer_on_a_rigid_base(line):
    """Slow and fast it is the elastic one, relaxed and glassy; between it resists rolling."""
    layers, found = [vc.Layer(0.1, 1.0, 0.45)], []
    soft = vc.Layered(layers, base="rigid", relaxations=[(1.0, 0.1)])
    for speed, G in ((1e-6, 0.5), (1.0, None), (1e6, 1.0)):
        sol = vc.solve(
            roller(("rigid", soft), speed=speed, cells=12 if line else 8, line=line, vx=0.01)
        )
        assert sol.certificate.normal_relative_gap < 1e-9
        found.append(sol.rolling_resistance / sol.normal_force)
        if G is not None:
            stiff = vc.Layered([vc.Layer(0.1, G, 0.45)], base="rigid")
            elastic = vc.solve(
                replace(
                    sol.scene, bodies=("rigid", stiff), motion=vc.Steady(vx=0.01), grid=sol.grid
                )
            )
            np.testing.assert_allclose(
                sol.pressure, elastic.pressure, atol=1e-3 * elastic.max_pressure
            )
            assert sol.Fx == pytest.approx(elastic.Fx, rel=1e-3)
            by_tractions = (
                np.sum(elastic.pressure * elastic.grid.x) * elastic.grid.area / elastic.normal_force
            )
            assert found[-1] == pytest.approx(by_tractions, abs=1e-4)
    assert found[1] > 3 * max(abs(found[0]), abs(found[2]))


LINED = vc.Layered(
    [vc.Layer(0.05, 3.0, 0.3), vc.Layer(0.1, 1.0, 0.45, [(1.0, 0.1)])],
    base=(2.0, 0.3, [(0.5, 1.0)]),
)
"""A stiff elastic skin on a soft layer that relaxes fast, and a base that relaxes slowly."""


@pytest.mark.parametrize("line", [True, False])
def test_what_rolling_costs_is_what_relaxations_dissipate(line):
    """By tractions P that the particles remember, ``sum f (p - P) A (p - P)/(V tau)``, in line
    contact and beyond.
    """
    off = []
    for cells in (12, 24):
        sol, lost = vc.solve(roller(cells=cells, line=line, vx=0.02, vy=0.01)), 0.0
        dx, behind = sol.grid.sides[0], int(12 / sol.grid.sides[0])
        now = np.pad(
            np.concatenate([sol.traction, sol.pressure[None]]), ((0, 0), (0, 0), (behind, 0))
        )
        wide = sol.grid.window(-behind, sol.grid.nx, 0, sol.grid.rows)
        operator = influence_operator(wide, "xyz", "xyz", nu=0.3, depth=40.0)
        for part, tau in SOLID.relaxations:
            past = np.zeros_like(now)
            for i in range(now.shape[2] - 2, -1, -1):
                decay = np.exp(-dx / tau)
                middle = (now[..., i] + now[..., i + 1]) / 2
                past[..., i] = decay * past[..., i + 1] + (1 - decay) * middle
            lost += (
                part
                / tau
                * float(np.sum((now - past) * operator.apply(now - past)))
                * sol.grid.area
            )
        off.append(abs(lost / (sol.power - sol.friction_work) - 1))
    assert off[1] < 0.6 * off[0] < 0.6 * 0.06


@pytest.mark.parametrize("line", [True, False])
def test_a_grid_across_samples(line):
    """Contact is found from the samples; those behind, which are still down, do not count as
    contact.
    """
    paraboloid = vc.solve(roller(line=line, cells=16, vx=0.01))
    x = np.linspace(-0.8, 0.8, 161)
    if line:
        surface = vc.SampledDistance(h=x**2 / 2, x=x, reference_depth=8.0)
    else:
        surface = vc.SampledDistance(h=(x**2 + x[:, None] ** 2) / 2, x=x, y=x)
    sol = vc.solve(
        replace(paraboloid.scene, surface=surface, grid=vc.Grid(nx=16, ny=None if line else 16))
    )
    assert sol.grid.nx * sol.grid.sides[0] < 1.5 * np.ptp(sol.grid.x[sol.pressure.any(axis=0)])
    assert sol.Fx == pytest.approx(paraboloid.Fx, rel=0.03)
    assert sol.rolling_resistance == pytest.approx(paraboloid.rolling_resistance, rel=0.03)


@pytest.mark.long
def test_default_has_error_bars():
    sol = vc.solve(replace(roller(vx=0.02), grid="auto"))
    fine = vc.solve(replace(sol.scene, grid=vc.Grid(nx=600)))
    assert abs(sol.Fx - fine.Fx) < sol.error_estimate.bars["Fx"] * 1.05
    assert sol.error_estimate.largest < 0.01


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: vc.Viscoelastic(1.0, 0.3, []), "bodies.relaxations"),
        (lambda: vc.Viscoelastic(1.0, 0.3, [(1.0, 0.0)]), "bodies.relaxations[0][1]"),
        (lambda: vc.Viscoelastic(1.0, 0.3, [(-1.0, 1.0)]), "bodies.relaxations[0][0]"),
        (lambda: vc.Viscoelastic(float("inf"), 0.3, [(1.0, 1.0)]), "bodies.G"),
        (lambda: roller(LINED, line=False), "bodies.layers"),
        (lambda: replace(LINED, relaxations=[(1.0, 1.0)]), "bodies.relaxations"),
        (lambda: replace(LINED, base=(2.0, 0.3, [])), "bodies.relaxations"),
        (lambda: vc.Layer(0.1, 1.0, 0.3, [(1.0, -1.0)]), "layer.relaxations[0][1]"),
        (lambda: roller(speed=None), "motion.speed"),
        (lambda: roller(speed=0.0), "motion.speed"),
        (lambda: roller(bodies=vc.Bodies(1.0, 0.3)), "motion.speed"),
        (lambda: replace(roller(), motion=None), "motion"),
        (lambda: replace(roller(), motion=vc.Shift(ux=0.1)), "motion"),
        (lambda: vc.solve(roller(), tangential="fastsim"), "tangential"),
        (lambda: vc.solve(roller(), normal="hertz"), "normal"),
    ],
)
def test_bad_input(make, field):
    refused(make, field)
