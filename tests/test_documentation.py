"""The code on the pages runs as it stands, prints what they say, and draws the pictures that they
show.
"""

import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

import varcontact as vc

ROOT = Path(__file__).parents[1]
SCENE = """
normal_force = 1.0
friction = 0.3
bodies = {G = 1.0, nu = 0.28}
surface = {kind = "ellipse", a = 1.0, b = 1.0}
motion = {kind = "steady", vx = 0.05, spin = 0.1}
grid = {nx = 6, ny = 6}
"""


def extension(name):
    spec = importlib.util.spec_from_file_location(
        name, ROOT / "docs" / "_extensions" / f"{name}.py"
    )
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


pages = extension("pages")
MADE = {"_build", "made", "gallery"}
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md"] + [
    page
    for page in sorted((ROOT / "docs").rglob("*.md"))
    if not MADE & set(page.relative_to(ROOT).parts)
]
RUNNING = [
    page
    for page in PAGES
    if {block.language for block in pages.blocks(page)} & {"python", "sh", "toml"}
]


def name_of(page):
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", RUNNING, ids=name_of)
def test_a_page_does_what_it_says(page, tmp_path, monkeypatch):
    """From top to bottom in one session, in a folder with the examples and a small scene.toml."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples", "examples")
    if any("scene.toml" in block.code for block in pages.blocks(page) if block.language == "sh"):
        Path("scene.toml").write_text(SCENE)
    pages.run(page)
    plt.close("all")
    shown = re.findall(rf"made/pages/{page.stem}/([\w.]+)", page.read_text())
    assert set(shown) <= {path.name for path in tmp_path.iterdir()}
    if shown:  # the site need not run it again
        made = ROOT / "docs" / "made" / "pages" / page.stem
        shutil.copytree(
            tmp_path, made, ignore=shutil.ignore_patterns("examples"), dirs_exist_ok=True
        )
        (made / "output.txt").touch()
        (made / "stamp").write_text(pages.stamp(page.read_text()))


def test_a_page_that_says_something_else_is_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = tmp_path / "page.md"
    page.write_text("```python\nprint(1 + 1)\n```\n\n```text\n3\n```\n")
    with pytest.raises(pages.Wrong, match=r"page.md:2 prints\n2\n\nin place of\n3"):
        pages.run(page)
    page.write_text("```sh\nvarcontact solve nowhere.toml\n```\n")
    with pytest.raises(pages.Wrong, match="ends with 2"):
        pages.run(page)
    assert pages.same("residual 2.0e-13, 5 N, -0.00", "residual 3.1e-14, 5 N, 0.00")
    assert not pages.same("residual 2.0e-13, 5 N", "residual 2.0e-13, 6 N")
    assert not pages.same("1.5e-06", "1.4e-06")


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_what_the_shell_is_to_run_is_there(page):
    """Scripts, and modules of the tests."""
    for block in pages.blocks(page):
        lines = block.code.splitlines() if block.language == "sh" else []
        for script in re.findall(r"python (\S+\.py)", "\n".join(lines)):
            assert (ROOT / script).is_file()
        for module in re.findall(r"python -m (tests[\w.]+)", "\n".join(lines)):
            path = ROOT / module.replace(".", "/")
            assert path.with_suffix(".py").is_file() or (path / "__main__.py").is_file()


def test_ci_runs_what_the_readme_says():
    """It takes the two commands of the section Install from the page: main job and tests."""
    taken = re.search(r"mapfile .* < <\((sed .*) README\.md\)", (ROOT / ".ci" / "run").read_text())
    command = f"{taken.group(1)} {ROOT / 'README.md'}"
    found = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True)
    install, tests = found.stdout.splitlines()
    assert 'pip install -e ".[test]" && python examples/wheel_on_rail.py' in install
    assert tests == "python -m pytest"
    (block,) = [each for each in pages.blocks(ROOT / "README.md") if each.language == "sh"][:1]
    assert block.code.splitlines() == [install, tests]


def test_the_scene_file_on_the_page_is_the_scene(tmp_path):
    """The first two blocks of the page are one scene, in Python and in TOML."""
    found = {}
    for block in pages.blocks(ROOT / "docs" / "scenes.md"):
        found.setdefault(block.language, block.code)
    (tmp_path / "scene.toml").write_text(found["toml"])
    names = {}
    exec(found["python"], names)
    scene, options = vc.read_scene(tmp_path / "scene.toml")
    assert repr(scene) == repr(names["scene"])
    assert options == {}


def test_every_public_name_has_its_place():
    """Under one of the topics of the interface, by itself or with the whole of its module."""
    told = "".join(page.read_text() for page in (ROOT / "docs" / "api").glob("*.md"))
    told += " ".join(vc.theories.__all__)
    for name in set(vc.__all__) - {"reference"}:
        assert re.search(rf"\b{name}\b", told) or hasattr(vc.errors, name), name


def test_modules_documented_under_another_name_can_be_imported():
    for old, new in vc._RENAMED.items():
        assert not (ROOT / old.replace(".", "/")).with_suffix(".py").exists()
        module, renamed = importlib.import_module(old), importlib.import_module(new)
        own = [
            name for name, value in vars(renamed).items() if getattr(value, "__module__", "") == new
        ]
        assert own and all(getattr(module, name) is getattr(renamed, name) for name in own)


def test_the_page_on_versions_has_all_renamed_modules():
    page = (ROOT / "docs" / "versions.md").read_text()
    for former, now in vc._RENAMED.items():
        assert f"`{former}`" in page and f"`{now}`" in page
