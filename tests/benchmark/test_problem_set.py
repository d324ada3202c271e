"""The set of problems: size, kinds, always the same."""

import json
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from varcontact.benchmark import problem_set
from varcontact.benchmark.trials import group_of
from varcontact.discrete.problems import NormalProblem


def test_at_least_a_hundred_problems_of_all_families():
    problems = vc.benchmark_problems()
    quick = vc.benchmark_problems(quick=True)
    families = {each.family for each in problems.values()}
    assert len(problems) >= 100
    assert len(quick) == 20
    assert set(quick) < set(problems)
    asked = ["pressure", "rough", "slender", "layers", "shift", "line"]
    asked += ["near saturation", "near no slip", "short steps", "unlike bodies", "steady"]
    assert families == set(asked)
    assert {each.problem for each in problems.values()} == {"normal", "tangential"}


DATA = Path(__file__).parents[1] / "data" / "benchmark_problems.json"


def figures(problem):
    """Elements, and sizes of the known shifts and of the influence numbers: what tells a problem."""
    known = problem.distance if isinstance(problem, NormalProblem) else problem.rigid_shift
    table = problem.operator.grid_operator.table
    sizes = (np.linalg.norm(known), np.linalg.norm(table))
    return [problem.operator.elements.size, *map(float, sizes)]


def test_quick_problems_have_all_groups_and_sizes_and_are_those_measured():
    """Where one changes, set another `SET_VERSION`: earlier tables are then refused."""
    problems = vc.benchmark_problems(quick=True)
    posed = [each.program().contact_problem for each in problems.values()]
    kept = json.loads(DATA.read_text())
    assert kept["version"] == problem_set.SET_VERSION
    for name, each in zip(problems, posed, strict=True):
        assert figures(each) == pytest.approx(kept["problems"][name], rel=1e-7)
    groups = [group_of(each) for each in posed]
    sizes = sorted(each.operator.elements.size for each in posed)
    assert {groups.count(name) for name in ("pressures", "rolling")} == {7, 8}
    assert groups.count("shifts") == 3
    assert {"line rolling", "viscoelastic pressures"} <= set(groups)
    assert sizes[0] < 100
    assert 2500 < sizes[-1] <= 3000


@pytest.mark.parametrize(
    ("name", "elements"), [("line, normal, 20 across", 22), ("shift, 60 across", 2828)]
)
def test_smallest_and_largest(name, elements):
    problem = vc.benchmark_problems()[name].program().contact_problem
    assert problem.operator.elements.size == elements


def test_kinds_are_what_their_names_say():
    problems = vc.benchmark_problems()

    def posed(name):
        return problems[name].program().contact_problem

    saturated = posed("Fx = 0.999, 10 across")
    carried = saturated.bound.sum() * saturated.area
    assert abs(saturated.force[0]) == pytest.approx(0.999 * carried)
    matrix = posed("step of 0.01 elements, nu = 0.28, 16 across").operator.matrix
    assert np.linalg.norm(matrix - matrix.T) > 10 * np.linalg.norm(matrix + matrix.T)
    assert not posed("rubber, pressure, 14 across").symmetric
    unlike = posed("soft on rigid, force, 12 across")
    like = posed("vx = 1e-3, 8 across")
    assert np.ptp(unlike.rigid_shift[0]) > 1e-3
    assert np.ptp(like.rigid_shift[0]) < 1e-12


@pytest.mark.long
@pytest.mark.parametrize("name", ["rough, 16 across", "two arcs, steady, 20 across"])
def test_problems_are_always_the_same(name):
    first = vc.benchmark_problems()[name].program().contact_problem
    problem_set._all_problems.cache_clear()
    second = vc.benchmark_problems()[name].program().contact_problem
    field = "distance" if isinstance(first, NormalProblem) else "bound"
    assert np.array_equal(getattr(first, field), getattr(second, field))
    table = first.operator.grid_operator.table
    assert np.array_equal(table, second.operator.grid_operator.table)


def test_bad_input():
    with pytest.raises(vc.SceneError, match="quick"):
        vc.benchmark_problems(quick="yes")
    with pytest.raises(vc.SceneError, match="quick"):
        vc.benchmark_problems(fast=True)
