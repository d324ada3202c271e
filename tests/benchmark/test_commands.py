"""`varcontact benchmark` and `varcontact problems`."""

import json

import pytest

from tests.command import assert_bad_input, run


@pytest.mark.long
def test_benchmark(tmp_path):
    """All twenty problems, in JSON, kept in a table; what is kept is not measured again."""
    arguments = ("benchmark", "--quick", "--solver", "norm", "--tols", "1e-3", "--json")
    done = run(*arguments, "--out", "runs.csv", "--plot", "runs.png", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    runs = json.loads(done.stdout)["runs"]
    outcomes = [each["outcome"] for each in runs]
    assert (outcomes.count("solved"), outcomes.count("does not apply")) == (8, 12)
    assert {each["solver"] for each in runs} == {"norm"}
    assert (tmp_path / "runs.png").stat().st_size > 1000
    content = (tmp_path / "runs.csv").read_bytes()
    again = run(*arguments, "--out", "runs.csv", folder=tmp_path)
    assert json.loads(again.stdout)["runs"] == runs
    assert (tmp_path / "runs.csv").read_bytes() == content


def test_a_module_of_the_folder_and_what_is_none(tmp_path):
    (tmp_path / "mine_of_benchmark.py").write_text(
        "def solve(problem, settings):\n    return 1 / 0\n"
    )
    for solver, words in (
        ("nobody", "solvers"),
        ("mine_of_benchmark:nothing", "AttributeError"),
        ("mine_of_nobody:solve", "ModuleNotFoundError"),
    ):
        assert_bad_input(run("benchmark", "--solver", solver, folder=tmp_path), words)
    for options in (("--tols", "x"), ("--limit", "0"), ("--out", "runs.txt")):
        assert run("benchmark", "--quick", *options, folder=tmp_path).returncode == 2


@pytest.mark.long
def test_problems(tmp_path):
    done = run("problems", "set", "--quick", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("20 problems in set")
    assert len(list((tmp_path / "set" / "data").glob("*.npz"))) == 20
    assert_bad_input(run("problems", ".", "--quick", folder=tmp_path), "other files")
