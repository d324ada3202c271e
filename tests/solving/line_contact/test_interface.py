"""Line contact in files, reports, pictures and on the command line; and what is refused, by
name.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused

LIKE, UNLIKE = vc.Bodies(G=1.0, nu=0.3), vc.Bodies(G=(1.0, np.inf), nu=(0.286, 0.0))
SAMPLES = np.linspace(-2.0, 2.0, 41)

BASE = make_scene(vc.Cylinders(R=1.0), 1.0, vc.Steady(Fx=-0.1), vc.Grid(nx=20), bodies=LIKE)


def scene(**changes):
    return replace(BASE, **changes)


@pytest.mark.parametrize("layout", ["row", "column", "npy"])
def test_samples_and_friction_from_files(tmp_path, layout):
    x, friction = np.linspace(-2.0, 2.0, 81), np.full(40, 0.3)
    for name, values in (("h", x**2 / 2), ("x", x), ("f", friction)):
        if layout == "npy":
            np.save(tmp_path / f"{name}.npy", values)
        else:
            np.savetxt(tmp_path / f"{name}.txt", values[None] if layout == "row" else values)
    ending = "npy" if layout == "npy" else "txt"
    (tmp_path / "scene.toml").write_text(f"""
    normal_force = 1.0
    friction = {{file = "f.{ending}"}}
    [bodies]
    G = 1.0
    nu = 0.3
    [surface]
    kind = "sampled-distance"
    h = {{file = "h.{ending}"}}
    x = {{file = "x.{ending}"}}
    [motion]
    kind = "steady"
    vx = 0.1
    [grid]
    nx = 40
    dx = 0.05
    x0 = -1.0
    """)
    described, _ = vc.read_scene(tmp_path / "scene.toml")
    assert described.line
    expected = vc.solve(
        scene(motion=vc.Steady(vx=0.1), grid=vc.Grid(nx=40, dx=0.05, x0=-1.0)), normal="clarabel"
    )
    np.testing.assert_allclose(vc.solve(described).traction, expected.traction, atol=1e-9)


DEPTH = "surface.reference_depth"
FAR, NEAR = vc.Cylinders(1.0, reference_depth=10.0), vc.Cylinders(1.0, reference_depth=1.0)
BY_APPROACH = {"normal_force": None, "approach": 0.5}


@pytest.mark.parametrize(
    ("changes", "field", "words"),
    [
        (BY_APPROACH, DEPTH, "approach needs surface.reference_depth"),
        ({"motion": vc.Shift(ux=0.1)}, DEPTH, "motion.ux needs surface.reference_depth"),
        ({"motion": vc.Shift(Fx=0.1, uy=0.1)}, DEPTH, "motion.uy needs surface.reference_depth"),
        (
            {"motion": vc.Shift(), "bodies": UNLIKE},
            DEPTH,
            "motion.ux needs surface.reference_depth",
        ),
        (
            {"motion": vc.Shift(Fy=0.1), "bodies": UNLIKE},
            DEPTH,
            "motion.ux needs surface.reference_depth",
        ),
        ({"surface": NEAR}, DEPTH, "at least the length of the potential contact"),
        ({"motion": vc.Steady(spin=0.1)}, "motion.spin", "0 in line contact"),
        ({"motion": vc.Shift(rotation=0.1)}, "motion.rotation", "0 in line contact"),
        ({"grid": vc.Grid(nx=10, ny=10)}, "grid.ny", "must be left out in line contact"),
        (
            {"grid": vc.Grid(nx=10, ny=1, dx=0.1, dy=2.0, x0=-0.5, y0=0.0)},
            "grid.dy",
            "per unit length",
        ),
        (
            {"surface": vc.Paraboloids(1.0, 1.0)},
            "grid.ny",
            "is missing: only line contact has no rows",
        ),
        ({"friction": np.full(20, 0.3)}, "grid", "explicit (nx, dx, x0)"),
        (
            {"friction": np.full(19, 0.3), "grid": vc.Grid(nx=20, dx=0.2, x0=-2.0)},
            "friction",
            "(nx,) = (20,)",
        ),
        (
            {"friction": np.full((3, 20), 0.3), "grid": vc.Grid(nx=20, dx=0.2, x0=-2.0)},
            "friction",
            "(nx,) = (20,)",
        ),
        (
            {"grid": vc.Grid(nx=20, dx=0.01, x0=-0.1)},
            "grid",
            "grid (left, right) = (-0.1, 0.1) does not contain the contact",
        ),
        ({"grid": vc.Grid(nx=3, dx=3.0, x0=-4.5)}, "grid", "the contact is 1.88"),
        ({"grid": vc.Grid(nx=20, dx=0.1, x0=10.0)}, "grid", "contact, which is at x = 0"),
        (
            {"surface": FAR, "normal_force": None, "approach": 150.0},
            "approach",
            "far below depth^2/R",
        ),
        ({"surface": FAR, "normal_force": None, "approach": -1.0}, "approach", "no contact"),
        (
            {"surface": vc.SampledDistance(np.ones(19)), "grid": vc.Grid(nx=20, dx=0.1, x0=-1.0)},
            "surface.h",
            "(20,)",
        ),
    ],
)
def test_refused_scenes(changes, field, words):
    refused(lambda: vc.solve(scene(**changes)), field, words)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: vc.Cylinders(R=0.0), "surface.R"),
        (lambda: vc.Cylinders(R=np.inf), "surface.R"),
        (lambda: vc.Cylinders(R=1.0, reference_depth=-1.0), "surface.reference_depth"),
        (lambda: vc.SampledDistance(SAMPLES**2, SAMPLES, SAMPLES), "surface.y"),
        (
            lambda: vc.SampledDistance(np.ones((3, 3)), reference_depth=3.0),
            "surface.reference_depth",
        ),
        (lambda: vc.SampledDistance(np.array([0.0, np.nan, 1.0])), "surface.h[1]"),
        (lambda: vc.SampledDistance(SAMPLES**2, SAMPLES[::-1]), "surface.x"),
        (lambda: vc.Grid(nx=3, dy=1.0), "grid.dy"),
        (lambda: vc.Grid(nx=3, dx=1.0), "grid.x0"),
    ],
)
def test_refused_entries(make, field):
    refused(make, field)


@pytest.mark.parametrize(
    ("changes", "methods", "field", "words"),
    [
        ({}, {"tangential": "fastsim"}, "tangential", "elliptic contacts"),
        ({}, {"tangential": "linear"}, "tangential", "elliptic contacts"),
        ({}, {"tangential": "vermeulen-johnson"}, "tangential", "elliptic contacts"),
        ({"bodies": UNLIKE}, {"normal": "hertz"}, "normal", "friction and K = 0.214"),
        (
            {"surface": vc.SampledDistance(SAMPLES**2 / 2, SAMPLES)},
            {"normal": "hertz"},
            "normal",
            "cylinders",
        ),
    ],
)
def test_refused_methods(changes, methods, field, words):
    refused(lambda: vc.solve(scene(**changes), **methods), field, words)


def test_saturation():
    with pytest.raises(vc.Saturated) as error:
        vc.solve(scene(motion=vc.Steady(Fx=0.2, Fy=-0.25)))
    assert error.value.limit == pytest.approx(0.3)
    with pytest.raises(vc.Saturated) as error:
        vc.solve(scene(surface=FAR, normal_force=None, approach=0.5, motion=vc.Steady(Fx=0.9)))
    assert error.value.limit < 0.2


def test_what_needs_the_depth_says_so_and_nothing_else_does():
    for changes in (
        {"motion": vc.Steady(vx=0.1, vy=0.1)},
        {"motion": vc.Shift(Fx=0.1)},
        {"motion": vc.Shift(Fy=0.1)},
    ):
        assert vc.solve(scene(**changes)).converged
    assert vc.solve(scene(bodies=UNLIKE, motion=vc.Shift(Fx=0.1))).converged
    wide = vc.SampledDistance(SAMPLES**2 / 2, SAMPLES, reference_depth=3.5)
    assert vc.solve(scene(surface=wide)).approach == pytest.approx(
        vc.solve(scene(surface=vc.Cylinders(1.0, 3.5)), normal="clarabel").approach, rel=1e-3
    )
    refused(vc.solve(scene(motion=vc.Shift(Fx=0.1))).sensitivity, "surface.reference_depth")
