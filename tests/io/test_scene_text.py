"""Scenes as TOML and back: the same scene, whatever is in it."""

import dataclasses
import os
import tomllib

import numpy as np
import pytest

import varcontact as vc
from varcontact.io.scene_toml import scene_to

BALL = vc.Scene(
    bodies=vc.Bodies(G=82e9, nu=0.28),
    surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    normal_force=106.7e3,
    friction=0.33,
    motion=vc.Steady(vx=1e-3, Fy=-1e3, spin=0.1),
    units=vc.Units(length='in "US"', force="lbf \\ é"),
)
GRID = vc.Grid(nx=4, ny=3, dx=1e-3, dy=2e-3, x0=-2e-3, y0=-3e-3)
FIELD = np.random.default_rng(1).uniform(0.1, 0.5, (3, 4))


def ball(**changes):
    return dataclasses.replace(BALL, **changes)


SCENES = {
    "steady": ball(),
    "ellipse": ball(surface=vc.Ellipse(a=1e-3, b=2e-3), grid=vc.Grid(nx=12, ny=10)),
    "pressure alone": ball(motion=None, friction=None, normal_force=None, approach=1e-5),
    "no slip": ball(friction=np.inf),
    "rigid": ball(bodies=vc.Bodies(G=(82e9, np.inf), nu=(0.28, 0.3))),
    "law": ball(friction=vc.LinearFalling(static=0.3, kinetic=0.2, half_velocity=0.01)),
    "by element": ball(friction=FIELD, grid=GRID, surface=vc.SampledDistance(1e-6 * FIELD)),
    "line": ball(surface=vc.Cylinders(R=0.5, reference_depth=1.0), motion=vc.Shift(ux=1e-6)),
    "history": ball(
        surface=vc.Paraboloids(Rx=0.4, Ry=0.4),
        motion=vc.Transient(
            steps=2,
            dq=[0.0, 1e-3],
            Fx=[-1e3, None],
            friction=[vc.StaticKinetic(0.3, 0.2), None],
            surface=[vc.Paraboloids(Rx=0.4, Ry=0.4), vc.Paraboloids(Rx=0.5, Ry=0.4)],
            interpolate=True,
        ),
        grid=GRID,
    ),
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


def test_a_saved_scene_has_the_same_solution(tmp_path):
    scene = SCENES["steady"]
    scene.save(tmp_path / "scene.toml")
    one, other = (vc.solve(each) for each in (scene, vc.read_scene(tmp_path / "scene.toml")[0]))
    np.testing.assert_array_equal(one.traction, other.traction)


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
    with pytest.raises(vc.SceneError, match=r"motion\.start = .a solution. must be left out: save it"):
        scene.save(tmp_path / "scene.toml")
    assert os.listdir(tmp_path) == []


def test_a_scene_too_large_for_a_file(tmp_path, monkeypatch):
    monkeypatch.setattr("varcontact.io.scene_toml.SCENE_BYTES", 300)
    with pytest.raises(vc.SceneError, match=r"write large fields to files"):
        SCENES["by element"].save(tmp_path / "scene.toml")
    assert os.listdir(tmp_path) == []
