"""Plausibility warnings of scenes: one for each likely mistake, none of the scenes that are
right.
"""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from varcontact.data.benchmark_scenes import reference_scenes

EXAMPLES = Path(__file__).parents[2] / "examples"
STEEL = vc.Scene(
    bodies=vc.Bodies(G=82e9, nu=0.28),
    surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    normal_force=80e3,
    friction=0.3,
    motion=vc.Steady(vx=1e-3),
    grid=vc.Grid(nx=8, ny=8),
    units=vc.SI,
)
IN_MM = replace(
    STEEL,
    bodies=vc.Bodies(G=82e3, nu=0.28),
    surface=vc.Paraboloids(Rx=460.0, Ry=300.0),
    units=vc.MM_N,
)
X = np.linspace(-1.0, 1.0, 9)
BOWL = X[:, None] ** 2 + X**2


def sampled(h):
    """Steel on 9 x 9 samples."""
    surface = vc.SampledDistance(h, x=X * 6.0, y=X * 6.0)
    return replace(IN_MM, surface=surface, grid="auto")


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (
            replace(STEEL, bodies=vc.Bodies(G=210e9, nu=0.3)),
            "G = 2.1e+11 is Young's modulus of steel",
        ),
        (replace(STEEL, bodies=vc.Bodies(G=210e9, nu=0.3), units=None), "whose G is about 8e+10"),
        (replace(IN_MM, bodies=vc.Bodies(G=206e3, nu=0.3), units=None), "whose G is about 8e+04"),
        (
            replace(STEEL, bodies=vc.Bodies(G=(80e9, 70e9), nu=(0.3, 0.34))),
            "Young's modulus of aluminium",
        ),
        (
            replace(STEEL, surface=vc.Paraboloids(Rx=460.0, Ry=300.0)),
            "is 300 m: it looks like millimetres",
        ),
        (replace(IN_MM, bodies=vc.Bodies(G=1.19e7, nu=0.28), units=None), "pounds by square inch"),
        (
            replace(IN_MM, friction=vc.ExponentialFalling(0.4, 0.2, half_velocity=50.0)),
            "friction.half_velocity = 50 is a slip relative to the rolling velocity",
        ),
        (
            replace(STEEL, friction=30.0),
            "friction = 30: coefficients are below 2, and are no per cents",
        ),
        (replace(STEEL, friction=vc.StaticKinetic(30.0, 20.0)), "friction = 30"),
        (
            replace(
                STEEL,
                friction=np.full((8, 8), 35.0),
                grid=vc.Grid(8, 8, dx=2e-3, dy=2e-3, x0=-8e-3, y0=-8e-3),
            ),
            "35",
        ),
        (
            replace(STEEL, motion=vc.Steady(vx=0.2)),
            "vx = 0.2: creepages are mostly below 0.1, and are no per cents",
        ),
        (
            replace(IN_MM, motion=vc.Steady(spin=0.5)),
            "spin = 0.5: the rigid slip at the edge of the contact",
        ),
        (sampled(-BOWL), "surface.h is up to 0 inside, and at most -2 at its corners"),
        (
            replace(
                STEEL, surface=vc.SampledDistance(1 - X**2, x=X), normal_force=1e5, grid="auto"
            ),
            "surface.h is up to 1 inside, and at most 0 at its corners",
        ),
    ],
)
def test_each_mistake_has_its_warning(scene, words):
    (doubt,) = scene.doubts
    assert words in doubt


@pytest.mark.parametrize(
    "scene",
    [
        STEEL,
        IN_MM,
        replace(IN_MM, units=None),
        replace(STEEL, friction=np.inf),
        replace(STEEL, bodies=vc.Bodies(G=80e9, nu=0.31)),
        replace(STEEL, bodies=vc.Bodies(G=210e9, nu=0.16)),  # as stiff as silicon carbide
        sampled(BOWL),
        sampled(np.cos(3 * X[:, None]) ** 2 + np.cos(3 * X) ** 2 + BOWL),  # waves on a bowl
    ],
)
def test_right_scenes_have_none(scene):
    assert scene.doubts == ()


def test_the_banks_and_examples_have_none():
    banks = {**vc.standard_bank(), **vc.unlike_bank()}
    scenes = [(name, getattr(each, "scene", each)) for name, each in banks.items()]
    scenes += [(name, scene) for name, (_, scene) in reference_scenes().items()]
    for path in EXAMPLES.glob("*.toml"):
        found = vc.read_scene(path)
        scenes.append((path.name, found[0] if isinstance(found, tuple) else found))
    assert {name: scene.doubts for name, scene in scenes if scene.doubts} == {}


def test_it_reaches_scripts_once():
    """By a warning that points at the caller, and by the solution and its file."""
    scene = replace(STEEL, motion=vc.Steady(vx=0.2))
    with pytest.warns(vc.PlausibilityWarning, match=r"vx = 0.2") as caught:
        sol = vc.solve(scene)
    assert len(caught) == 1 and caught[0].filename == __file__
    assert sol.warnings == scene.doubts and sol.report().count(scene.doubts[0]) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error", vc.PlausibilityWarning)
        assert vc.solve(STEEL).warnings == ()
        with pytest.raises(vc.PlausibilityWarning):
            vc.solve(scene)


def test_it_comes_before_any_work():
    """Also of a scene that is refused."""
    beside = vc.Grid(nx=4, ny=4, dx=0.1, dy=0.1, x0=0.5, y0=0.5)
    scene = replace(sampled(BOWL), friction=30.0, normal_force=None, approach=0.1, grid=beside)
    with pytest.warns(vc.PlausibilityWarning, match="friction = 30"), pytest.raises(vc.SceneError):
        vc.solve(scene)


def test_a_history_has_one():
    scene = replace(STEEL, motion=vc.Transient(steps=2, vx=[0.0, 0.2]))
    with pytest.warns(vc.PlausibilityWarning) as caught:
        history = vc.solve(scene)
    assert len(caught) == 1 and history.warnings == scene.doubts
