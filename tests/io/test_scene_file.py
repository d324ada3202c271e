"""TOML scenes: the same as in Python, and told apart where they are wrong."""

import dataclasses
import json
import os
import tomllib

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused, wheel_on_rail
from varcontact.io.scene_toml import scene_to

FULL = """
normal_force = 80e3
friction = 0.3
grid = "auto"
[units]
length = "mm"
force = "N"
[bodies]
G = [82e3, inf]
nu = [0.28, 0.5]
[surface]
kind = "paraboloids"
Rx = 460
Ry = 300.0
[motion]
kind = "steady"
vx = 1e-3
spin = 5e-5
dq = 0.25
spin_offset = 0.5
[solve]
normal = "clarabel"
tol = 1e-7
"""


def write(tmp_path, text, name="scene.toml"):
    path = tmp_path / name
    path.write_text(text)
    return path


def test_same_as_python(tmp_path):
    scene, options = vc.read_scene(write(tmp_path, FULL))
    assert options == {"normal": "clarabel", "tol": 1e-7}
    assert scene.bodies == vc.Bodies(G=(82e3, np.inf), nu=(0.28, 0.5))
    assert scene.surface == vc.Paraboloids(Rx=460.0, Ry=300.0)
    assert scene.motion == vc.Steady(vx=1e-3, spin=5e-5, dq=0.25, spin_offset=0.5)
    assert (scene.normal_force, scene.friction, scene.grid) == (80e3, 0.3, "auto")
    assert scene.units == vc.Units(length="mm", force="N")


def test_all_kinds(tmp_path):
    text = """
    approach = 1e-2
    friction = inf
    [bodies]
    E = 210e3
    nu = 0.25
    [surface]
    kind = "Ellipse"
    a = 3
    b = 2
    [motion]
    kind = "shift"
    ux = 1e-3
    [grid]
    nx = 5
    ny = 4
    """
    scene, _ = vc.read_scene(write(tmp_path, text))
    assert scene.bodies.G == pytest.approx(84e3)
    assert scene.surface == vc.Ellipse(a=3.0, b=2.0)
    assert scene.motion == vc.Shift(ux=1e-3)
    assert scene.no_slip
    assert scene.grid == vc.Grid(nx=5, ny=4)


def test_samples_from_files(tmp_path):
    h = np.arange(12.0).reshape(3, 4)
    np.savetxt(tmp_path / "h.csv", h, delimiter=",")
    np.save(tmp_path / "f.npy", np.full((3, 4), 0.2))
    text = """
    normal_force = 1.0
    friction = {file = "f.npy"}
    bodies = {G = 1, nu = 0.3}
    surface = {kind = "sampled_distance", h = {file = "h.csv"}}
    grid = {nx = 4, ny = 3, dx = 1, dy = 1, x0 = 0, y0 = 0}
    """
    scene, _ = vc.read_scene(write(tmp_path, text))
    np.testing.assert_array_equal(scene.surface.h, h)
    np.testing.assert_array_equal(scene.friction, np.full((3, 4), 0.2))
    inline = text.replace('{file = "h.csv"}', json.dumps(h.tolist()))
    np.testing.assert_array_equal(vc.read_scene(write(tmp_path, inline))[0].surface.h, h)


@pytest.mark.parametrize(("old", "new", "field", "hint"), [
    ("normal_force = 80e3", "normal_forse = 80e3", "normal_forse", "normal_force"),
    ("vx = 1e-3", "Vx = 1e-3", "motion.Vx", "vx"),
    ("Rx = 460", "Rxx = 460", "surface.Rxx", "Rx"),
    ('kind = "paraboloids"', 'kind = "paraboloid"', "surface.kind", "did you mean paraboloids"),
    ('kind = "paraboloids"', "", "surface.kind", "is missing: give one of paraboloids, ellipse"),
    ('kind = "paraboloids"', 'type = "paraboloids"', "surface.kind", "there is no key surface.type"),
    ('kind = "steady"', 'kind = "rolling"', "motion.kind", "steady, shift"),
    ("G = [82e3, inf]", "", "bodies.G", "is missing"),
    ("Ry = 300.0", "", "surface.Ry", "is missing"),
    ("nu = [0.28, 0.5]", "nu = 0.7", "bodies.nu", "0.7"),
    ("friction = 0.3", "friction = nan", "friction", "nan"),
    ("friction = 0.3", 'friction = {file = "none.csv"}', "friction.file", "none.csv"),
    ('grid = "auto"', "grid = {nx = 3}", "grid.ny", "is missing"),
    ('grid = "auto"', 'grid = {nx = 3, ny = 3, size = "big"}', "grid.size", "no such key"),
    ("[bodies]", "[body]", "body", "bodies"),
    ('normal = "clarabel"', 'norml = "clarabel"', "solve.norml", "normal"),
    ('normal = "clarabel"', 'refine = "continuum"', "solve.refine", "this version has accuracy"),
    ('length = "mm"', "length = 1e-3", "units.length", "a name, in quotes"),
    ('length = "mm"', 'lenght = "mm"', "units.lenght", "length"),
    ("[solve]", "[solve.more]", "solve.more", "no such key"),
    ("[solve]", "[slove]", "slove", "did you mean solve"),
    ("[solve]", "[zzz]", "zzz", "units, solve"),
])  # fmt: skip
def test_wrong_entries(tmp_path, old, new, field, hint):
    assert old in FULL
    refused(lambda: vc.read_scene(write(tmp_path, FULL.replace(old, new))), field, hint)


@pytest.mark.parametrize("content", [b"normal_force = = 3", b"\xff\xfe\x00", b"[bodies\nG = 1"])
def test_no_toml(tmp_path, content):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(vc.SceneError, match=r"is not a TOML file|is not UTF-8 text"):
        vc.read_scene(path)


SAMPLED = """
normal_force = 1.0
bodies = {G = 1, nu = 0.3}
surface = {kind = "sampled_distance", h = {file = "%s"}}
grid = {nx = 3, ny = 2, dx = 1, dy = 1, x0 = 0, y0 = 0}
"""


@pytest.mark.parametrize("kept", [0, 3, 20, -5])
def test_truncated_npy(tmp_path, kept):
    """A copy that broke off anywhere is an error of the scene, with the file's name."""
    np.save(tmp_path / "whole.npy", np.ones((2, 3)))
    (tmp_path / "h.npy").write_bytes((tmp_path / "whole.npy").read_bytes()[:kept])
    refused(
        lambda: vc.read_scene(write(tmp_path, SAMPLED % "h.npy")), "surface.h.file", match=r"h\.npy"
    )


@pytest.mark.parametrize("text", ["1,2,3\n4,5,6\n", "1, 2, 3\n4, 5, 6", "1 2 3\n4  5\t6\n"])
def test_numbers_between_commas_or_blanks(tmp_path, text):
    (tmp_path / "h.csv").write_text(text)
    scene, _ = vc.read_scene(write(tmp_path, SAMPLED % "h.csv"))
    np.testing.assert_array_equal(scene.surface.h, [[1, 2, 3], [4, 5, 6]])


@pytest.mark.parametrize(
    "text", ["1,,2,3\n4,5,,6\n", "1,2,3,\n4,5,6,\n", "1 2,3\n4 5,6\n", "1;2;3\n4;5;6\n"]
)
def test_missing_numbers_do_not_close_up(tmp_path, text):
    """An empty place between commas is a missing number, not a blank: the row must not move
    together.
    """
    (tmp_path / "h.csv").write_text(text)
    refused(lambda: vc.read_scene(write(tmp_path, SAMPLED % "h.csv")), "surface.h.file")


@pytest.mark.parametrize(
    "text", ["bodies = " + "[" * 5000 + "]" * 5000, "[" + ".".join(["a"] * 5000) + "]"]
)
def test_toml_nested_too_deep(tmp_path, text):
    with pytest.raises(vc.SceneError, match=r"nested|a: there is no such key; there are bodies, "):
        vc.read_scene(write(tmp_path, text))


@pytest.mark.parametrize(
    "name", ["a" * 300, "a\0b", "none.toml", ""], ids=["long", "nul", "none", "folder"]
)
def test_names_that_no_file_has(tmp_path, name):
    refused(lambda: vc.read_scene(tmp_path / name), words="cannot be read")


# -------------------------------------------------------------------------- Scenes as TOML and back


BALL = wheel_on_rail(
    vc.Steady(vx=1e-3, Fy=-1e3, spin=0.1), units=vc.Units(length='in "US"', force="lbf \\ é")
)
GRID = vc.Grid(nx=4, ny=3, dx=1e-3, dy=2e-3, x0=-2e-3, y0=-3e-3)
FIELD = np.random.default_rng(1).uniform(0.1, 0.5, (3, 4))


def ball(**changes):
    return dataclasses.replace(BALL, **changes)


SURFACES, LAWS = (
    [vc.Paraboloids(Rx=R, Ry=0.4) for R in (0.4, 0.5)],
    [vc.StaticKinetic(0.3, 0.2), None],
)
VARIED = vc.Transient(
    steps=2, dq=[0.0, 1e-3], Fx=[-1e3, None], friction=LAWS, surface=SURFACES, interpolate=True
)
SCENES = {
    "by element": ball(friction=FIELD, grid=GRID, surface=vc.SampledDistance(1e-6 * FIELD)),
    "history": ball(surface=SURFACES[0], motion=VARIED, grid=GRID),
}


@pytest.mark.parametrize("name", SCENES)
def test_round_trip(name, tmp_path):
    """To the last digit, entry by entry."""
    scene, path = SCENES[name], tmp_path / "scene.toml"
    scene.save(path)
    assert path.read_text(encoding="utf-8") == scene.to_toml()
    again, options = vc.read_scene(path)
    assert options == {} and scene_to(again) == scene_to(scene)
    assert again.units == scene.units
    assert tomllib.loads(again.to_toml()) == tomllib.loads(scene.to_toml())


def test_only_our_files_are_replaced(tmp_path):
    path = tmp_path / "scene.toml"
    for _ in range(2):
        BALL.save(path)
    path.write_text("# by hand\nnormal_force = 1.0\n")
    with pytest.raises(vc.OutputError, match="no scene of varcontact's"):
        BALL.save(path)
    assert path.read_text().startswith("# by hand")
    BALL.save(path, overwrite=True)
    with pytest.raises(vc.OutputError, match=r"the name must end in \.toml"):
        BALL.save(tmp_path / "scene.json")
    assert os.listdir(tmp_path) == ["scene.toml"]


def test_a_start_is_not_left_out_in_silence(tmp_path):
    wide = vc.Grid(nx=16, ny=16, dx=1.5e-3, dy=1.5e-3, x0=-12e-3, y0=-12e-3)
    start = vc.solve(ball(grid=wide))
    scene = ball(grid=wide, motion=vc.Transient(steps=1, vx=1e-3, start=start))
    with pytest.raises(
        vc.SceneError, match=r"motion\.start = .a solution. must be left out: save it"
    ):
        scene.save(tmp_path / "scene.toml")
    assert os.listdir(tmp_path) == []


def test_a_scene_too_large_for_a_file(tmp_path, monkeypatch):
    monkeypatch.setattr("varcontact.io.scene_toml.SCENE_BYTES", 300)
    with pytest.raises(vc.SceneError, match=r"write large fields to files"):
        SCENES["by element"].save(tmp_path / "scene.toml")
    assert os.listdir(tmp_path) == []
