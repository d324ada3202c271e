"""Solvers side by side: the judge, the limit of time, resumed tables, and the figures by hand."""

import signal

import numpy as np
import pandas as pd
import pytest

import varcontact as vc
from tests.benchmark.solvers_of_users import good
from varcontact.benchmark import comparison
from varcontact.benchmark.comparison import COLUMNS, SHIFT
from varcontact.benchmark.solvers import DEFAULT_SOLVERS, entry_named, without_made
from varcontact.benchmark.trials import Process, Trial, verdict
from varcontact.solvers.registry import SOLVERS

USERS = "tests.benchmark.solvers_of_users"


def posed(name):
    return vc.benchmark_problems()[name].program().contact_problem


def chosen(*names):
    problems = vc.benchmark_problems()
    return {name: problems[name] for name in names}


def judged(solver, name="shift, 6 across", tol=1e-6):
    """The verdict on a solver, in this process."""
    problem = posed(name)
    entry = entry_named(solver)
    return verdict(problem, entry, entry.spec_for(problem), tol)


@pytest.mark.parametrize(
    ("solver", "tol"),
    [("norm|tang-safeguarded", 1e-9), ("newton", 1e-9), ("splitting", 1e-9), ("clarabel", 1e-3)],
)
def test_our_solvers_are_judged_solved(solver, tol):
    for name in ("circle, 6 across", "shift, 6 across", "pure vx, 6 across"):
        found = judged(solver, name, tol)
        assert found.outcome == "solved"
        assert found.residual <= tol
        assert found.relative_gap <= tol
        assert 0 < found.seconds < 10


@pytest.mark.parametrize(
    ("function", "outcome", "reason"),
    [
        ("good", "solved", ""),
        ("nothing", "inaccurate", ""),
        ("slightly_wrong", "inaccurate", ""),
        ("raising", "failed", "RuntimeError: no licence"),
        ("misshapen", "failed", "(3,)"),
        ("not_a_number", "failed", "not finite"),
    ],
)
def test_answers_of_users_are_judged_by_our_measures(function, outcome, reason):
    found = judged(f"{USERS}:{function}")
    assert found.outcome == outcome
    assert reason.lower() in found.reason.lower()


def test_a_small_gap_with_a_large_residual_is_not_solved():
    problem = posed("shift, 6 across")
    entry = entry_named(f"{USERS}:slightly_wrong")
    found = verdict(problem, entry, entry.spec_for(problem), 1.0)
    between = (found.residual * found.relative_gap) ** 0.5
    assert found.outcome == "solved"
    assert found.relative_gap < 0.2 * found.residual
    assert verdict(problem, entry, entry.spec_for(problem), between).outcome == "inaccurate"


def test_formulations_are_those_that_are_named():
    """Programs of pressures: of tractions n variables, of the gap as many and twice the rows."""
    problem = posed("circle, 6 across")
    rows = {}
    for name in ("complementary", "potential", "gap"):
        program = vc.benchmark_problems()["circle, 6 across"].program(name)
        rows[name] = program.b.size
        entry = entry_named(f"clarabel/{name}")
        assert verdict(problem, entry, entry.spec_for(problem), 1e-6).outcome == "solved"
    n = problem.distance.size
    assert rows == {"complementary": n + 1, "potential": n, "gap": 2 * n + 1}


def test_solvers_apply_to_what_they_can():
    rolling = posed("pure vx, 6 across")
    line = posed("line, creepage 0.3, 20 across")
    assert entry_named("osqp").spec_for(rolling) is None
    assert entry_named("osqp").spec_for(line).name == "osqp"
    assert entry_named("clarabel/potential").spec_for(rolling) is None
    assert entry_named("clarabel/gap").spec_for(rolling).name == "clarabel"
    assert entry_named("norm").spec_for(rolling) is None


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nobody", "solvers"),
        ("norm|nobody", "solvers"),
        ("newton/gap", "no solver of programs"),
        ("clarabel/energy", "complementary"),
        ("no_such_module:solve", "ModuleNotFoundError"),
        (f"{USERS}:no_such_function", "AttributeError"),
        (f"{USERS}:np", "a function"),
        ("", "solvers"),
        (3, "solvers"),
    ],
)
def test_what_is_no_solver(name, words):
    with pytest.raises(vc.SceneError, match=words):
        vc.benchmark_solvers([name])


def test_each_solver_begins_from_the_data():
    problem = posed("pure vx, 6 across")
    matrix = problem.operator.matrix
    fresh = without_made(problem)
    assert np.array_equal(fresh.operator.matrix, matrix)
    assert fresh.operator.matrix is not matrix


@pytest.mark.long
def test_solvers_that_do_not_end_or_crash_are_stopped_and_others_go_on():
    """By processor time; tighter tolerances are not tried."""
    names = [f"{USERS}:endless", f"{USERS}:crashing", f"{USERS}:good"]
    compared = vc.benchmark_solvers(names, chosen("shift, 6 across"), tols=(1e-6, 1e-3), limit=0.3)
    runs = compared.runs
    assert runs["tol"].tolist() == [1e-3, 1e-6] * 3
    assert runs["outcome"].tolist() == ["out of time"] * 2 + ["crashed"] * 2 + ["solved"] * 2
    assert runs["reason"].tolist()[:2] == ["0.3 s", "not tried: out of time at 0.001"]
    assert "7" in runs["reason"].tolist()[2]


def test_a_process_that_ends_with_trials_unread_has_crashed():
    """Its end of the connection is then reset, not closed."""
    problem = vc.benchmark_problems()["shift, 6 across"]
    with Process(10.0) as process:
        process._connection().send(Trial(problem, "newton", (1e-6,)))
        process._process.kill()
        assert process._received(10.0).outcome == "crashed"


@pytest.mark.long
def test_solvers_that_only_wait_are_stopped_by_the_clock():
    compared = vc.benchmark_solvers(
        [f"{USERS}:sleeping"], chosen("shift, 6 across"), tols=[1e-3], limit=0.1
    )
    assert compared.runs["outcome"].tolist() == ["out of time"]


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="no signal that stops a process")
def test_time_without_a_processor_does_not_count():
    limit = 0.15  # seconds of processor time; the clock allows no more than ten of them to sleep
    compared = vc.benchmark_solvers(
        [f"{USERS}:held_up"], chosen("shift, 6 across"), tols=[1e-3], limit=limit
    )
    assert compared.runs["outcome"].tolist() == ["solved"]


def stop_at(word):
    """Progress that is Ctrl-C where it hears of a solver."""

    def progress(words):
        if word in words:
            raise KeyboardInterrupt

    return progress


@pytest.mark.long
def test_an_interrupted_comparison_is_resumed(tmp_path):
    """A registered solver takes part; a table with another problem of a name is refused."""
    vc.register_solver("admm-of-mine", good)
    store = tmp_path / "runs.csv"
    said = []
    solvers = ["splitting", "osqp", "admm-of-mine"]
    problems = chosen("circle, 6 across", "shift, 6 across")
    options = {"tols": [1e-3], "store": store}
    try:
        with pytest.raises(vc.Interrupted) as stopped:
            vc.benchmark_solvers(solvers, problems, **options, progress=stop_at("osqp"))
        both = vc.benchmark_solvers(solvers, problems, **options, progress=said.append)
        content = store.read_bytes()
        again = vc.benchmark_solvers(solvers, problems, **options)
    finally:
        del SOLVERS["tangential", "admm-of-mine"]
    first = stopped.value.partial.runs
    assert first["solver"].tolist() == ["splitting"]
    assert said[0] == "circle, 6 across: osqp"
    assert len(said) == 5
    assert both.runs["seconds"][0] == first["seconds"][0]
    assert store.read_bytes() == content
    pd.testing.assert_frame_equal(again.runs, both.runs, check_dtype=False)
    # disks are none of OSQP's, pressures none of mine: their rows say so, and count nowhere
    outcomes = both.runs.set_index(["problem", "solver"])["outcome"]
    assert outcomes["shift, 6 across", "admm-of-mine"] == "solved"
    assert outcomes["shift, 6 across", "osqp"] == "does not apply"
    assert outcomes["circle, 6 across", "admm-of-mine"] == "does not apply"
    assert both.summary()["solver"].value_counts().to_dict() == {
        "splitting": 2,
        "osqp": 1,
        "admm-of-mine": 1,
    }
    other = {"circle, 6 across": vc.benchmark_problems()["circle, 8 across"]}
    with pytest.raises(vc.SceneError, match=r"one of benchmark_problems\(\)"):
        vc.benchmark_solvers(["splitting"], other, **options)
    with pytest.raises(vc.SceneError, match="a limit of 10 s"):
        vc.benchmark_solvers(["splitting"], problems, **options, limit=5.0)
    rows = pd.read_csv(store)
    rows.assign(set_version=0).to_csv(store, index=False)
    with pytest.raises(vc.SceneError, match="another version of the problems"):
        vc.benchmark_solvers(["splitting"], problems, **options)


def by_hand(seconds):
    """A comparison of two solvers on three problems; None where one fails."""
    rows = []
    for solver, times in seconds.items():
        for number, each in enumerate(times):
            row = dict.fromkeys(COLUMNS)
            row |= {"problem": str(number), "group": "shifts", "elements": 100 * number + 50}
            row |= {"solver": solver, "tol": 1e-6, "limit": 10.0, "iterations": 1}
            outcome, residual = ("inaccurate", 2e-6) if each is None else ("solved", 1e-7)
            row |= {"outcome": outcome, "residual": residual, "relative_gap": residual}
            rows.append(row | {"seconds": each or 1.0})
    return vc.SolverComparison(pd.DataFrame(rows, columns=list(COLUMNS)))


def test_means_and_profiles_by_hand():
    compared = by_hand({"a": [0.1, 0.2, 0.4], "b": [0.2, 0.1, None]})
    summary = compared.summary().set_index("solver")
    means = {
        "a": np.prod([0.1 + SHIFT, 0.2 + SHIFT, 0.4 + SHIFT]) ** (1 / 3) - SHIFT,
        "b": np.prod([0.2 + SHIFT, 0.1 + SHIFT, 10 + SHIFT]) ** (1 / 3) - SHIFT,
    }
    assert summary["mean"].to_dict() == pytest.approx(means)
    assert summary["solved"].to_dict() == {"a": 3, "b": 2}
    assert summary.loc["b", "ratio"] == pytest.approx(means["b"] / means["a"])
    profile = compared.profile("shifts", 1e-6, factors=[1.0, 2.0, 100.0])
    assert profile["a"].tolist() == pytest.approx([2 / 3, 1, 1])
    assert profile["b"].tolist() == pytest.approx([1 / 3, 2 / 3, 2 / 3])
    assert compared.failures().loc["b", ["solved", "inaccurate"]].tolist() == [2, 1]
    sizes = compared.sizes(1e-6).set_index("size")
    assert sizes.loc["1-150", ["a", "b"]].tolist() == pytest.approx([0.15, 0.15])
    assert sizes.loc["151-500", "b"] == np.inf


def test_a_run_to_a_tighter_tolerance_counts_where_a_looser_one_misses():
    """And where it is faster; one that was asked for less never does."""
    rows = []
    for tol, residual, seconds in ((1e-3, 5e-3, 1.0), (1e-6, 5e-6, 2.0), (1e-9, 1e-9, 3.0)):
        row = dict.fromkeys(COLUMNS) | {"problem": "a", "group": "shifts", "solver": "s"}
        row |= {"tol": tol, "residual": residual, "relative_gap": 0.0, "seconds": seconds}
        rows.append(row | {"outcome": "inaccurate", "limit": 10.0})
    compared = vc.SolverComparison(pd.DataFrame(rows, columns=list(COLUMNS)))
    assert compared.tried["cost"].tolist() == [2.0, 3.0, 3.0]
    rows[2]["residual"] = 2e-9
    compared = vc.SolverComparison(pd.DataFrame(rows, columns=list(COLUMNS)))
    assert compared.tried["cost"].tolist() == [2.0, 3.0, np.inf]


def test_report_json_and_picture():
    compared = by_hand({"a": [0.1, 0.2, 0.4], "b": [0.2, 0.1, None]})
    assert "2 of 3" in compared.report()
    assert '"inaccurate": 1' in compared.to_json()
    assert len(compared.plot().axes) == 1
    with pytest.raises(vc.SceneError, match="tol"):
        compared.plot(1e-5)
    with pytest.raises(vc.SceneError, match="group"):
        compared.profile("pressures", 1e-6)


def test_default_solvers_are_all_kinds():
    assert len(comparison._names(None)) >= 12
    assert len(DEFAULT_SOLVERS) == len(set(DEFAULT_SOLVERS))
