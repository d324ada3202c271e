"""The code on the pages runs as it stands, and its files say what its Python says."""

import re
from pathlib import Path

import matplotlib as mpl
import pytest

import varcontact as vc

mpl.use("Agg")
ROOT = Path(__file__).parents[1]


def blocks(page, language):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / page).read_text(), re.DOTALL)


MADE = {
    "docs/sweeps.md": {"contact.png", "contact.nc", "study.csv", "order.png", "sweep.nc"},
    "docs/scenes.md": {"history.nc"},
    "docs/fast_theories.md": set(),
    "docs/results.md": {
        *(f"{name}.png" for name in ("contact", "fields", "section", "stress", "below", "curve", "history")),
        *("history.gif", "contact.nc", "contact.csv", "contact.vtu", "contact.mat", "scene.toml"),
    },
}
"""Files by the last page of a session."""


@pytest.mark.parametrize(
    "pages",
    [
        ["README.md", "docs/convergence.md", "docs/sweeps.md"],
        ["docs/scenes.md"],
        ["docs/results.md"],
        ["docs/fast_theories.md"],
    ],
    ids=lambda pages: pages[-1],
)
def test_python_on_the_pages(pages, tmp_path, monkeypatch):
    """From top to bottom in one session; a page that begins with a scene of its own needs no other."""
    monkeypatch.chdir(tmp_path)
    names = {}
    for page in pages:
        found = blocks(page, "python")
        assert found
        for block in found:
            exec(block, names)
    assert {path.name for path in tmp_path.iterdir()} == MADE[pages[-1]]


def test_the_scene_file_on_the_page_is_the_scene(tmp_path):
    """The first two blocks of the page are one scene, in Python and in TOML."""
    (tmp_path / "scene.toml").write_text(blocks("docs/scenes.md", "toml")[0])
    names = {}
    exec(blocks("docs/scenes.md", "python")[0], names)
    scene, options = vc.read_scene(tmp_path / "scene.toml")
    assert repr(scene) == repr(names["scene"])
    assert options == {}
