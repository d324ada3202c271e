"""Newton's method without a matrix within loops: unlike bodies, laws of friction, histories. The dense answers."""

import dataclasses
import math

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.operators import GridOperator
from varcontact.solvers import registry
from varcontact.solvers.newton import kernel
from varcontact.solving import contact_solver

DENSE, NEWTON = ({"normal": pair[0], "tangential": pair[1]} for pair in (("norm", "tang-safeguarded"), ("newton",) * 2))
FORCE = 1e-3
MIXED = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
EXPLICIT = vc.Grid(nx=11, ny=10, dx=0.02, dy=0.02, x0=-0.11, y0=-0.1)
LAWS = [
    vc.StaticKinetic(static=0.3, kinetic=0.2),
    vc.ExponentialFalling(static=0.3, kinetic=0.2, half_velocity=4e-3),
    vc.RationalFalling(static=0.3, kinetic=0.1, half_velocity=4e-3),
]
HISTORY = vc.Transient(
    steps=4,
    dq=[0.01, 0.02, 0.02, 0.01],
    vx=[4e-3, -3e-3, 0, 2e-3],
    spin=0.02,
    Fx=[None, None, -1e-4, None],
    normal_force=[FORCE, 1.2 * FORCE, FORCE, 0.8 * FORCE],
)


def ball(**changes):
    """A ball that rolls on a plane."""
    base = {"bodies": MIXED, "surface": vc.Paraboloids(1.0, 1.0), "normal_force": FORCE, "friction": 0.3}
    motion = vc.Steady(vx=4e-3, vy=-2e-3, spin=0.05)
    return vc.Scene(**{**base, "motion": motion, "grid": vc.Grid(nx=9, ny=8), **changes})


def unlike(seed):
    """Any unlike bodies, in point or line contact, on odd grids, with creepages, shifts or forces, in any motion."""
    rng = np.random.default_rng(seed)
    stiff, nu = float(rng.choice([2.0, 5.0, math.inf])), (float(rng.uniform(0, 0.3)), float(rng.uniform(0, 0.49)))
    line, friction = seed % 4 == 3, float(rng.choice([0.03, 0.1, 0.3, 0.6, 1.0]))
    surface = vc.Cylinders(R=1.0) if line else vc.Paraboloids(Rx=1.0, Ry=float(np.exp(0.5 * rng.normal())))
    nx, ny = (int(number) for number in rng.integers(4, 16, 2))
    slip = 0.05 * friction * rng.normal(size=3) * rng.choice([0.05, 0.3, 1.0])
    carried, angle = float(rng.choice([0.2, 0.6, 0.95])) * friction * FORCE, rng.uniform(0, 2 * np.pi)
    Fx, Fy = float(carried * np.cos(angle)), float(carried * np.sin(angle))
    turn = 0.0 if line else float(slip[2])
    motions = [
        vc.Steady(vx=slip[0], vy=slip[1], spin=5 * turn),
        vc.Steady(Fx=Fx, vy=slip[1], spin=turn),
        vc.Shift(Fx=Fx) if line else vc.Shift(ux=0.1 * slip[0], uy=0.1 * slip[1], rotation=turn),
        vc.Shift(Fx=Fx, Fy=Fy),
    ]
    return vc.Scene(
        bodies=vc.Bodies(G=(1.0, stiff) if rng.random() < 0.5 else (stiff, 1.0), nu=nu),
        surface=surface,
        normal_force=FORCE,
        friction=friction,
        motion=motions[int(rng.integers(4))],
        grid=vc.Grid(nx=3 * nx) if line else vc.Grid(nx=nx, ny=ny),
    )


def check_same(one, other):
    """Tractions and pressures, to 1e-7 of the largest bound and pressure."""
    bound = float(np.max(other.traction_bound))
    np.testing.assert_allclose(one.traction, other.traction, rtol=0, atol=1e-7 * bound)
    np.testing.assert_allclose(one.pressure, other.pressure, rtol=0, atol=1e-7 * other.pressure.max())
    assert one.certificate.residual <= 1e-8


def check_by_newton(sol):
    """Nobody else was asked, but for its own steps that converge by themselves."""
    assert {name for calls in sol.calls.values() for name in calls} <= {"newton", "tseng", "hertz"}
    assert sol.solved_by["tangential"] == "newton"


@pytest.mark.parametrize("seed", range(12))
def test_unlike_bodies(seed):
    scene = unlike(seed)
    coupling = ("panagiotopoulos", "joint", "newton")[seed % 3]
    dense, found = vc.solve(scene, **DENSE), vc.solve(scene, **NEWTON, coupling=coupling)
    check_same(found, dense)
    check_by_newton(found)
    assert found.certificate.relative_gap <= 1e-8
    assert len(found.passes) <= len(dense.passes) + 2, "rough answers within passes take no more of them"


@pytest.mark.parametrize("seed", range(12, 24))
def test_both_together(seed):
    """No passes, and few Newton steps, whatever K and friction are."""
    scene = unlike(seed)
    dense, found = vc.solve(scene, **DENSE), vc.solve(scene, coupling="newton")
    check_same(found, dense)
    check_by_newton(found)
    assert found.certificate.relative_gap <= 1e-8
    assert len(found.passes) == 1
    assert 0 < found.iterations["both"] <= 20


def test_both_together_where_passes_converge_slowly():
    """K = 0.5, f = 2, half of what friction can carry: 40 passes, and those only with acceleration."""
    bodies, grid = vc.Bodies(G=(1.0, math.inf), nu=(0.0, 0.3)), vc.Grid(nx=30)
    scene = ball(bodies=bodies, surface=vc.Cylinders(R=1.0), grid=grid, friction=2.0, motion=vc.Steady(Fx=-1e-3))
    found, dense = vc.solve(scene, coupling="newton"), vc.solve(scene, **DENSE)
    check_same(found, dense)
    assert (len(found.passes), len(dense.passes) > 20) == (1, True)


@pytest.mark.parametrize("failing", ["nothing", "no number", "far away"])
def test_where_both_together_fail_passes_go_on(monkeypatch, failing):
    """From where they were."""
    wrong = {"nothing": 0.0, "no number": np.nan, "far away": 3.0}[failing]

    def failed(problem, settings, start, residual):
        return dataclasses.replace(start, traction=wrong * start.traction, solved=False, status="MaxIterations")

    monkeypatch.setattr("varcontact.solving.coupling.newton_coupled", failed)
    sol = vc.solve(ball(), coupling="newton")
    check_same(sol, vc.solve(ball(), **DENSE))
    assert len(sol.passes) > 3


@pytest.mark.parametrize(
    "scene",
    [
        ball(grid=vc.Grid(nx=15, ny=1)),
        ball(grid=vc.Grid(nx=15, ny=1), motion=vc.Shift(Fx=0.2 * FORCE, Fy=-0.1 * FORCE)),
        ball(grid=vc.Grid(nx=1, ny=9)),
        ball(normal_force=None, approach=0.01, motion=vc.Steady(Fx=1e-4, spin=0.03)),
        ball(friction=math.inf, motion=vc.Shift(ux=1e-4)),
        ball(friction=np.where(np.arange(11) < 5, 0.3, 0.0) * np.ones((10, 1)), grid=EXPLICIT),
    ],
)
@pytest.mark.parametrize("coupling", ["panagiotopoulos", "joint", "newton"])
def test_unlike_bodies_at_the_edge(scene, coupling):
    if scene.no_slip and coupling != "newton":
        dense = vc.solve(scene, normal="norm", coupling=coupling)
        found = vc.solve(scene, **NEWTON, coupling=coupling)
        np.testing.assert_allclose(found.traction, dense.traction, rtol=0, atol=1e-7 * np.abs(dense.traction).max())
    elif not scene.no_slip:
        check_same(vc.solve(scene, **NEWTON, coupling=coupling), vc.solve(scene, **DENSE))


@pytest.mark.parametrize("changes", [{}, {"bodies": vc.Bodies(G=1.0, nu=0.28), "friction": LAWS[1]}])
def test_no_pass_asks_for_more_than_the_next_one_sees(monkeypatch, changes):
    """Within passes accuracy grows with theirs; from one to the next nothing begins anew."""
    asked, solve = [], registry.TANGENTIAL["newton"]

    def asking(problem, settings, start):
        asked.append((settings.tol, start is None))
        return solve(problem, settings, start)

    monkeypatch.setitem(registry.TANGENTIAL, "newton", asking)
    methods = {} if changes else {"normal": "newton", "coupling": "panagiotopoulos"}
    sol = vc.solve(ball(**changes), tangential="newton", **methods)
    residuals = [residual for _, residual in sol.passes]
    assert asked[0] == (contact_solver.FIRST, True)
    assert not any(anew for _, anew in asked[1:])
    for (tol, _), residual in zip(asked[1:], residuals, strict=False):
        assert tol == pytest.approx(max(0.01 * residual, 1e-10), rel=1e-12)
    assert sol.certificate.residual == pytest.approx(residuals[-1], rel=1e-3)


@pytest.mark.parametrize("coupling", ["panagiotopoulos", "joint", "newton"])
def test_passes_form_no_matrix(built, monkeypatch, coupling):
    """Tables by offset are made once, kernels once for each box of elements."""
    kernels, make = [], kernel.Kernel

    def refuse(*_):
        raise AssertionError("a dense matrix was assembled")

    def made(numbers):
        kernels.append(numbers.shape)
        return make(numbers)

    monkeypatch.setattr(GridOperator, "dense", refuse)
    monkeypatch.setattr(kernel, "Kernel", made)
    sol = vc.solve(ball(grid=vc.Grid(nx=27, ny=26)), **NEWTON, coupling=coupling)
    assert sorted(name for name, _ in built) == ["A_tt - C_tt", "A_tz - C_tz", "A_zt", "A_zz"]
    assert len(kernels) == len(set(kernels))
    assert len(sol.passes) > 3 or coupling == "newton"


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), MIXED], ids=["like", "unlike"])
@pytest.mark.parametrize("motion", [vc.Steady(vx=4e-3, spin=0.05), vc.Shift(ux=1e-4, uy=5e-5)], ids=["steady", "shift"])
def test_laws(law, bodies, motion):
    scene = ball(bodies=bodies, friction=law, motion=motion)
    normals = {} if bodies is MIXED else {"normal": "auto"}
    dense, found = (vc.solve(scene, **{**methods, **normals}) for methods in (DENSE, NEWTON))
    check_same(found, dense)
    check_by_newton(found)
    np.testing.assert_array_equal(found.state, dense.state)


@pytest.mark.parametrize("bodies", [vc.Bodies(G=1.0, nu=0.28), MIXED], ids=["like", "unlike"])
@pytest.mark.parametrize("friction", [0.3, LAWS[1]], ids=["number", "law"])
def test_histories(bodies, friction):
    scene = ball(bodies=bodies, friction=friction, motion=HISTORY, normal_force=None)
    normals = {} if bodies is MIXED else {"normal": "auto"}
    dense, found = (vc.solve(scene, **{**methods, **normals}) for methods in (DENSE, NEWTON))
    for one, other in zip(found, dense, strict=True):
        check_same(one, other)
        check_by_newton(one)


def test_steps_of_a_history_share_kernels_and_begin_where_the_last_ended(built, monkeypatch):
    kernels, make = [], kernel.Kernel
    starts, solve = [], registry.TANGENTIAL["newton"]

    def made(numbers):
        kernels.append(numbers.shape)
        return make(numbers)

    def starting(problem, settings, start):
        starts.append(start is not None)
        return solve(problem, settings, start)

    monkeypatch.setattr(kernel, "Kernel", made)
    monkeypatch.setitem(registry.TANGENTIAL, "newton", starting)
    motion = vc.Transient(steps=5, dq=0.01, vx=4e-3)
    vc.solve(ball(bodies=vc.Bodies(G=1.0, nu=0.28), motion=motion), tangential="newton")
    assert starts == [False, True, True, True, True]
    assert len(kernels) == 1
    assert sorted(name for name, _ in built) == ["A_tt", "A_zz", "C_tt"]


def test_pressures_are_as_exact_as_tractions_need_them(monkeypatch):
    """The less friction, the more wrong pressures do to the tractions: by K times pressures over tractions."""
    asked = {}
    for problem, solvers in (("normal", registry.NORMAL), ("tangential", registry.TANGENTIAL)):

        def asking(posed, settings, start, problem=problem, solve=solvers["newton"]):
            asked.setdefault(problem, []).append(settings.tol)
            return solve(posed, settings, start)

        monkeypatch.setitem(solvers, "newton", asking)
    scene = ball(friction=1e-3)
    sol = vc.solve(scene, **NEWTON, coupling="panagiotopoulos")
    part = 1e-3 / scene.bodies.K
    assert sol.certificate.residual <= 1e-8
    assert len(sol.passes) > 2
    for pressures, tractions in zip(asked["normal"][1:], asked["tangential"][1:], strict=True):
        assert pressures == pytest.approx(part * tractions, rel=0.3)


def test_changed_pressures_are_new_to_every_pass():
    """A pass under the pressures of the one before would end at Johnson's answer."""
    whole, johnson = (vc.solve(ball(), **NEWTON, coupling=coupling) for coupling in ("panagiotopoulos", "johnson"))
    assert np.abs(whole.pressure - johnson.pressure).max() > 1e-3 * whole.pressure.max()
    assert whole.certificate.residual < 1e-8 < johnson.certificate.residual
