"""The code on the page about wheels and rails runs as it stands."""

import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "wheel_rail.md"


def test_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    exec(block, {})
    assert [path.name for path in tmp_path.iterdir()] == ["wheel.png"]
    assert re.match(r"\d+ N at y = 7[1234]\d\.\d mm, angle -0\.\d+, Creepages", capsys.readouterr().out)
