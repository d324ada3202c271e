"""Traces: the iterates of every solver by one measure, and nothing changed by keeping them."""

import numpy as np
import pytest

import varcontact as vc
from tests.own_solvers import admm
from tests.scenes import refused
from varcontact import energy
from varcontact.discrete.problems import NormalProblem
from varcontact.elasticity.operators import GridOperator
from varcontact.solvers.registry import SOLVERS
from varcontact.solvers.trace import Trace

SHIFT = vc.Shift(ux=0.1, uy=-0.06)
GRID = vc.Grid(nx=10, ny=10)
NORMAL = ["norm", "norm-single", "newton", "splitting"]
TANGENTIAL = ["tang", "tang-exact", "tang-safeguarded", "newton", "splitting"]


def of(trace, problem):
    return trace.isel(iterate=np.flatnonzero(trace["problem"].values == problem))


@pytest.mark.parametrize("motion", [SHIFT, vc.Steady(vx=0.04, spin=0.05), vc.Shift(Fx=-0.1)])
@pytest.mark.parametrize("name", TANGENTIAL)
def test_tractions(rolling, name, motion):
    """It falls to the residual and the gap of the certificate; without a trace all is the same."""
    scene = rolling(motion=motion, grid=GRID)
    sol = vc.solve(scene, tangential=name, trace=True)
    plain = vc.solve(scene, tangential=name)
    assert plain.trace is None
    np.testing.assert_array_equal(sol.traction, plain.traction)
    trace = of(sol.trace, "tangential")
    assert set(trace.solver.values) == {name}
    assert trace.sizes["iterate"] >= 2
    assert trace.residual[0] > 1e-2
    assert trace.residual.min() == pytest.approx(sol.certificate.tangential_residual, abs=1e-9)
    assert trace.gap.min() == pytest.approx(sol.certificate.gap, abs=1e-10)
    assert (np.diff(trace.second) >= 0).all()
    assert (trace.iteration.values[trace.call.values == trace.call.values[0]] == np.arange(
        np.count_nonzero(trace.call.values == trace.call.values[0]))).all()  # fmt: skip
    assert trace.changes.max() > 0
    # the objective falls to that of the program
    expected = 0.0
    if isinstance(motion, vc.Shift):
        posed = energy.posed(sol)
        expected = -energy.complementary_energy(posed.tangential, posed.traction) * posed.unit
    assert trace.objective[-1] == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("load", [{}, {"normal_force": None, "approach": 0.5}])
@pytest.mark.parametrize("name", NORMAL)
def test_pressures(rolling, name, load):
    scene = rolling(motion=None, friction=None, grid=GRID, **load)
    sol = vc.solve(scene, normal=name, trace=True)
    np.testing.assert_array_equal(sol.pressure, vc.solve(scene, normal=name).pressure)
    trace = of(sol.trace, "normal")
    assert trace.residual[0] > 1e-2
    assert trace.residual.min() == pytest.approx(sol.certificate.normal_residual, abs=1e-9)
    assert trace.gap.min() == pytest.approx(sol.certificate.gap, abs=1e-9)
    posed = energy.posed(sol)
    expected = -energy.complementary_energy(posed.normal, posed.pressure) * posed.unit
    assert trace.objective[-1] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("own", [0.1, 10.0])
@pytest.mark.parametrize("approach", [0.2, -0.2])
def test_the_state_of_one_element_is_known_from_any_pressure(own, approach):
    """By its own influence number: contact where the bodies overlap without a pressure."""
    operator = GridOperator((1, 1), np.full((1, 1, 1, 1), own)).on(np.array([0]))
    problem = NormalProblem(operator, np.zeros(1), 1.0, None, approach)
    trace = Trace()
    with trace.called("normal", "one"):
        follow = trace.follower(problem)
        for pressure in (1.0, max(approach, 0.0) / own):
            follow(np.array([pressure]))
    assert [record.get("changes") for record in trace.records] == [None, 0]


@pytest.mark.parametrize(
    ("name", "reports"), [("clarabel", True), ("scs", False), ("cvxpy:CLARABEL", False)]
)
def test_conic_solvers(rolling, name, reports):
    """Clarabel tells objective and gap of its iterates; the answer of each is measured."""
    scene = rolling(motion=SHIFT, grid=GRID)
    sol = vc.solve(scene, tangential=name, polish=False, tol=1e-6, trace=True)
    trace = of(sol.trace, "tangential")
    own = trace.isel(iterate=np.flatnonzero(trace.solver.values == name))
    assert (own.sizes["iterate"] > 5) is reports
    assert own.residual[-1] < 1e-6
    if reports:
        told = own.isel(iterate=slice(None, -1))
        assert np.isnan(told.residual).all()
        assert told.gap[-1] < 1e-9 < told.gap[0]
        assert told.objective[-1] == pytest.approx(float(own.objective[-1]), abs=1e-8)


@pytest.mark.parametrize("coupling", ["newton", "splitting"])
def test_both_at_once_and_passes(rolling, coupling):
    unlike = rolling(bodies=vc.Bodies(G=(1.0, 3.0), nu=0.28), grid=GRID)
    trace = vc.solve(unlike, coupling=coupling, trace=True).trace
    both = of(trace, "both")
    assert both.residual[0] > 1e-6 > both.residual[-1]
    passes = vc.solve(unlike, normal="norm", tangential="tang", trace=True).trace
    assert np.unique(of(passes, "tangential").call).size > 3


def test_comparisons(rolling):
    before = dict(SOLVERS)
    try:
        vc.register_solver("admm", admm)
        scenes = {"a": rolling(grid=GRID), "b": rolling(motion=SHIFT, grid=GRID)}
        table = vc.compare(scenes, ["admm", "newton", "linear"], trace=True)
        assert set(table.traces) >= {"a, admm", "a, newton", "b, newton"}
        assert table.traces["a, admm"].residual[-1] < 1e-6  # the answer alone
        assert table.traces["b, newton"].sizes["iterate"] > 3
        assert table[table["outcome"] == "solved"].traces is not None
        assert vc.compare(scenes["a"], ["newton"]).traces is None
        elsewhere = vc.compare(scenes, ["newton"], trace=True, workers=2)
        assert set(elsewhere.traces) == {"a, newton", "b, newton"}
    finally:
        SOLVERS.clear()
        SOLVERS.update(before)


def test_own_solvers_follow(rolling):
    def steps(problem, settings, start):
        follow = settings.stats.follow(problem)
        weight = np.linalg.norm(problem.operator.matrix, 2)
        p = np.zeros_like(problem.rigid_shift)
        while energy.tangential_residual(problem, p, np.zeros(2)) > settings.tol:
            p = problem.potential.projected(p - problem.shift(p, np.zeros(2)) / weight, weight)
            follow(p)
        return p

    before = dict(SOLVERS)
    try:
        trace = vc.solve(rolling(motion=SHIFT, grid=GRID), tangential=steps, trace=True).trace
        assert of(trace, "tangential").sizes["iterate"] > 20
    finally:
        SOLVERS.clear()
        SOLVERS.update(before)


@pytest.mark.long
def test_pictures(rolling):
    scene = rolling(motion=SHIFT, grid=GRID)
    sol = vc.solve(scene, normal="norm", trace=True)
    for what in ("residual", "gap", "objective", "changes"):
        by_iteration, by_second = vc.plot_traces(sol, what).axes
        assert len(by_iteration.lines) == len(by_second.lines) >= 1
    assert vc.plot_traces(sol, problem="normal").axes[0].get_yscale() == "log"
    table = vc.compare(scene, ["newton", "splitting", "clarabel"], trace=True)
    labels = {line.get_label() for line in vc.plot_traces(table).axes[0].lines}
    assert labels == {"newton", "splitting", "clarabel"}
    vc.plot_traces(sol.trace)
    vc.plot_traces({"one": sol.trace, "two": sol.trace})
    refused(lambda: vc.plot_traces(vc.solve(scene)), "trace")
    refused(lambda: vc.plot_traces(3), "trace")
    refused(lambda: vc.plot_traces(sol, "error"), "what")
    refused(lambda: vc.plot_traces(sol, problem="both"), "problem")


def test_refused(rolling, tmp_path):
    history = rolling(motion=vc.Transient(steps=2, vx=0.01), grid=GRID)
    refused(lambda: vc.solve(history, trace=True), "trace")
    refused(lambda: vc.solve(rolling(), trace=1), "trace")
    sol = vc.solve(rolling(grid=GRID), trace=True)
    sol.save(tmp_path / "x.nc")
    assert vc.load(tmp_path / "x.nc").trace is None
