"""What the fuzzer found, each with its campaign, seed and number; as small as it could be made."""

import json

from tests.command import run


def test_a_solver_that_prints_leaves_json_alone(tmp_path):
    """Scenes, seed 1, case 215: without active constraints OSQP says so on standard output, asked to be silent."""
    (tmp_path / "bump.toml").write_text("""
approach = 0.01
[bodies]
G = 1.0
nu = 0.3
[surface]
kind = "sampled-distance"
h = [[1, 1, 1], [1, 0, 1], [1, 1, 1]]
[grid]
nx = 3
ny = 3
dx = 1.0
dy = 1.0
x0 = -1.5
y0 = -1.5
""")
    done = run("solve", "bump.toml", "--normal", "osqp", "--json", folder=tmp_path)
    assert "Polishing not needed" in done.stderr
    assert json.loads(done.stdout)["elements"]["contact"] == 1
