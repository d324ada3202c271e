"""Studies with a store, killed at random moments; ``python -m tests.killed`` does it more often."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CODE = """
import sys
from pathlib import Path
from tests.killed import STUDIES, killed
outcome = killed(STUDIES[sys.argv[1]], Path(sys.argv[2]), moments=3, seed=1)
print(outcome, outcome.kept)
"""


@pytest.mark.parametrize("study", ["history", "compare", "converge"])
def test_nothing_finished_is_lost(study, tmp_path):
    """A process of its own forks those that are killed."""
    command = [sys.executable, "-c", CODE, study, str(tmp_path)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert "kills=3" in done.stdout and done.stdout.endswith("lost=0, same=True, left=[]) True\n"), done.stdout
