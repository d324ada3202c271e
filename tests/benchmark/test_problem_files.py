"""The problems as files: read without the package, solved by others' solvers."""

import csv
import importlib
import sys

import numpy as np
import pytest
import qpsolvers

import varcontact as vc

CHOSEN = {
    "circle, 6 across": "circle_6_across",
    "approach given, 14 across": "approach_given_14_across",
    "rubber, pressure, 14 across": "rubber_pressure_14_across",
    "shift, 6 across": "shift_6_across",
    "shift, Fx = 0.01, 12 across": "shift_Fx=0.01_12_across",
    "Fx prescribed, 8 across": "Fx_prescribed_8_across",
    "line, creepage 0.3, 20 across": "line_creepage_0.3_20_across",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("set")
    problems = vc.benchmark_problems()
    vc.save_problems(folder, {name: problems[name] for name in CHOSEN})
    return folder


@pytest.fixture(scope="module")
def shipped(folder):
    """The module beside the files."""
    sys.path.insert(0, str(folder))
    try:
        yield importlib.import_module("contact_problems")
    finally:
        sys.path.remove(str(folder))
        del sys.modules["contact_problems"]


def test_the_module_needs_numpy_alone(folder):
    text = (folder / "contact_problems.py").read_text()
    assert "varcontact" not in text


def test_files_and_table(folder, shipped):
    assert shipped.names() == sorted(CHOSEN.values())
    assert len(shipped.names("normal")) == 3
    with (folder / "problems.csv").open() as file:
        rows = {row["name"]: row for row in csv.DictReader(file)}
    assert set(rows) == set(CHOSEN.values())
    assert rows["shift_6_across"]["unknowns"] == "64"
    assert all(float(row["residual"]) <= 1e-10 for row in rows.values())
    readme = (folder / "README.md").read_text()
    assert "7 problems" in readme
    assert "{" not in readme


@pytest.mark.parametrize(("name", "stem"), CHOSEN.items())
def test_matrices_are_ours_and_solutions_are_exact(shipped, name, stem):
    problem = shipped.load(stem)
    operator = vc.benchmark_problems()[name].program().contact_problem.operator
    matrix = shipped.matrix(problem)
    assert matrix == pytest.approx(operator.matrix / operator.diagonal, abs=1e-14)
    assert shipped.residual(problem, problem["p"], problem["rigid"]) <= 1e-10
    assert shipped.residual(problem, 1.001 * problem["p"], problem["rigid"]) > 1e-5


@pytest.mark.parametrize("stem", ["circle_6_across", "approach_given_14_across"])
def test_quadratic_programs(shipped, stem):
    problem = shipped.load(stem)
    data = qpsolvers.Problem(*shipped.quadratic_program(problem))
    found = qpsolvers.solve_problem(data, "quadprog")
    rigid = problem["rigid"] if np.isnan(problem["force"][0]) else found.y
    assert found.x == pytest.approx(problem["p"][0], abs=1e-9)
    assert shipped.residual(problem, found.x[None], rigid) < 1e-9


@pytest.mark.parametrize("stem", [each for each in CHOSEN.values() if "approach" not in each])
def test_conic_programs(shipped, stem):
    """Energies or gaps: the gap is zero at its end."""
    problem = shipped.load(stem)
    program = shipped.conic_program(problem)
    program.solve(solver="CLARABEL")
    assert program.var_dict["p"].value == pytest.approx(problem["p"], abs=2e-4)
    if not problem["symmetric"]:
        assert abs(program.value) < 1e-7
    if not problem["symmetric"] and not np.isnan(problem["force"][0]):
        assert program.var_dict["rigid"].value[0] == pytest.approx(problem["rigid"][0], rel=1e-4)


def test_the_folder_runs_in_qpbenchmark(folder, shipped):
    qpbenchmark = pytest.importorskip("qpbenchmark")
    module = importlib.import_module("rolling_contact")
    problems = list(module.RollingContact())
    assert [each.name for each in problems] == ["approach_given_14_across", "circle_6_across"]
    assert isinstance(problems[0], qpbenchmark.Problem)


def test_written_again_and_other_folders_refused(folder, tmp_path):
    problems = {"circle, 6 across": vc.benchmark_problems()["circle, 6 across"]}
    other = tmp_path / "other"
    vc.save_problems(other, problems)
    vc.save_problems(other, problems)
    (tmp_path / "mine.txt").write_text("mine")
    with pytest.raises(vc.OutputError, match="other files"):
        vc.save_problems(tmp_path, problems)
    with pytest.raises(vc.OutputError, match="cannot be written"):
        vc.save_problems(tmp_path / "mine.txt", problems)
    with pytest.raises(vc.SceneError, match="problems"):
        vc.save_problems(other, {"a": 1})
