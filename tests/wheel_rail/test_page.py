"""The code on the page about wheels and rails runs as it stands."""

import re
from pathlib import Path

import numpy as np
import pytest

PAGE = Path(__file__).parents[2] / "docs" / "wheel_rail.md"


def test_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    exec("".join(blocks), {})
    assert [path.name for path in tmp_path.iterdir()] == ["wheel.png"]
    patch, fast, steering = capsys.readouterr().out.splitlines()
    assert re.match(r"\d+ N at y = 7[1234]\d\.\d mm, angle -0\.\d+, Creepages", patch)
    assert np.array(fast.strip("[]").split(), dtype=float)[2] == pytest.approx(
        80e3, rel=0.05
    )  # normal forces bear all of it
    assert f"```text\n{steering}\n```" in PAGE.read_text()
