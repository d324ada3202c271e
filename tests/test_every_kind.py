"""Scenes of every kind have the same solution in other units, and from files."""

import json
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import in_units, make_scene
from tests.solving.test_along_rolling import groove
from tests.solving.test_conformal import coarse, in_groove, uneven
from tests.solving.test_edge_of_computed_pressures import posed
from tests.solving.test_layered_bodies import COAT, PAD, ROLLING, SPHERES
from tests.solving.test_temperature import STEEL, rolling
from tests.solving.test_third_body import ball
from tests.solving.test_viscoelastic import SOLID, roller
from varcontact.io.scene_toml import scene_from, scene_to

BODIES, UNLIKE = vc.Bodies(G=1.0, nu=0.28), vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
MIXED = vc.Steady(vx=0.04, vy=-0.02, spin=0.05)
PLAIN = make_scene(vc.Ellipse(a=1.2, b=0.9), 1.0, MIXED, vc.Grid(nx=10, ny=10))
GRID = vc.Grid(nx=14, ny=14, dx=0.2, dy=0.2, x0=-1.4, y0=-1.4)
SAMPLES = vc.SampledDistance((GRID.x**2 + 0.7 * GRID.y[:, None] ** 2) / 4 + 3.0)
LINE = make_scene(vc.Cylinders(R=1.0), 1e-2, vc.Steady(vx=3e-3), vc.Grid(nx=20))
STEPS = vc.Transient(
    steps=4, dq=[0, 0.05, 0.1, 0.1], vx=[0, 4e-3, 4e-3, 0], normal_force=[None, 0.03, 0.0, None]
)
DEEP = vc.Cylinders(R=1.0, reference_depth=20.0)
KINDS = {
    "like": PLAIN,
    "unlike": replace(PLAIN, bodies=UNLIKE),
    "sampled": replace(PLAIN, surface=SAMPLES, normal_force=0.5, grid=GRID),
    "force": replace(PLAIN, motion=vc.Steady(Fx=-0.1, Fy=0.05, spin=0.1)),
    "shift": replace(PLAIN, motion=vc.Shift(ux=0.05, rotation=0.1), friction=1e-3, bodies=UNLIKE),
    "touched": replace(PLAIN, grid=vc.Grid(nx=10, ny=10, edge="touched")),
    "second order": PLAIN.second_order(),
    "parts of elements": replace(
        posed().second_order(), grid=vc.Grid(nx=12, ny=12, edge="softened")
    ),
    "no slip": replace(PLAIN, friction=np.inf),
    "no friction": replace(PLAIN, friction=0.0, motion=vc.Steady(Fx=0.0, vy=0.1)),
    "friction by element": replace(
        PLAIN, grid=GRID, friction=np.where(GRID.x > 0, 0.3, 0.2) * np.ones((14, 1))
    ),
    "normal": replace(PLAIN, motion=None, friction=None),
    "approach": replace(PLAIN, surface=vc.Paraboloids(1.0, 1.5), normal_force=None, approach=0.1),
    "line": replace(LINE, motion=vc.Steady(Fx=-1e-3)),
    "open shift": replace(LINE, motion=vc.Shift(Fx=1e-3, Fy=1e-3), bodies=UNLIKE),
    "line of samples": replace(
        LINE, surface=vc.SampledDistance(SAMPLES.h[7] - 3.0, GRID.x, reference_depth=20.0)
    ),
    "line, friction by element": replace(
        LINE, friction=np.full(40, 0.3), grid=vc.Grid(nx=40, dx=0.02, x0=-0.4)
    ),
    "two coefficients": replace(LINE, friction=vc.StaticKinetic(0.3, 0.2)),
    "linear": replace(LINE, friction=vc.LinearFalling(0.3, 0.2, 4e-3)),
    "rational": replace(LINE, friction=vc.RationalFalling(0.3, 0.2, 8e-3, velocity=2.0)),
    "exponential": replace(PLAIN, friction=vc.ExponentialFalling(0.3, 0.2, 0.04)),
    "memory": replace(PLAIN, friction=vc.StaticKinetic(0.3, 0.2, memory_distance=0.05)),
    "laws together": replace(
        PLAIN,
        friction=vc.FrictionLaw(
            0.4,
            0.05,
            [vc.ExponentialFalling(0.4, 0.2, 0.05), vc.PressureFalling(1.0, 0.5, strength=0.2)],
        ),
    ),
    "temperature": rolling(
        (STEEL, vc.Thermal(30.0, 7.2e-9, 5e8, temperature=20.0)),
        friction=vc.TemperatureFalling(0.3, 0.12, over=400.0),
        grid=vc.Grid(nx=14, ny=5, dx=1.6, dy=4.4, x0=-14.0, y0=-11.0),
    ),
    "layers": make_scene(SPHERES["surface"], grid=SPHERES["grid"], bodies=(COAT, PAD), **ROLLING),
    "coat": make_scene(SPHERES["surface"], grid=SPHERES["grid"], bodies=COAT, **ROLLING),
    "rigid": make_scene(SPHERES["surface"], grid=SPHERES["grid"], bodies=("rigid", PAD), **ROLLING),
    "viscoelastic": roller((SOLID, vc.Bodies(2.0, 0.25)), cells=10, line=False, vx=0.01, spin=0.02),
    "third body": ball(vc.Steady(vx=3e-3, spin=1e-4)),
    "groove": coarse(in_groove),
    "uneven groove": coarse(uneven),
    "groove along x": groove(None, 12.0, vc.Steady(vx=2e-3, spin=1e-4), waves=0.1),
    "groove both ways": groove(10.1, 12.0, vc.Steady(vx=2e-3, spin=1e-4)),
    "pin": make_scene(
        vc.PinInHole(R=1.0, clearance=1e-3),
        1e-3,
        vc.Steady(vx=1e-3),
        vc.Grid(nx=40, dx=0.05, x0=-1.0),
    ),
    "history": replace(PLAIN, surface=vc.Paraboloids(10.0, 10.0), normal_force=0.02, motion=STEPS),
    "open history": replace(
        LINE, motion=vc.Transient(steps=3, dq=[0, 0.02, 0.02], Fx=-1e-3), bodies=UNLIKE
    ),
    "history under a law": replace(
        LINE, motion=vc.Transient(steps=3, dq=0.02, Fx=-1e-3), friction=vc.StaticKinetic(0.4, 0.3)
    ),
    "history of a third body": ball(vc.Transient(steps=4, vx=4e-3, dq=1.3)),
}
FIELDS = (
    "pressure",
    "traction",
    "slip",
    "state",
    "distance",
    "friction",
    "temperature",
    "plastic",
    "memory",
)


@pytest.fixture(scope="module", params=KINDS)
def kind(request):
    scene = KINDS[request.param]
    return scene, vc.solve(scene)


def test_units_do_not_matter(kind):
    scene, one = kind
    length, stress, time = 1024.0, 2.0**-30, 64.0
    other = vc.solve(in_units(scene, length, stress, time))
    for here, there in zip(steps_of(one), steps_of(other), strict=True):
        force = stress * length ** (1 if scene.line else 2)
        limit = (here.max_pressure or 1.0) * stress
        np.testing.assert_allclose(
            there.pressure, here.pressure * stress, rtol=0, atol=1e-9 * limit
        )
        np.testing.assert_allclose(
            there.traction, here.traction * stress, rtol=0, atol=1e-9 * limit
        )
        np.testing.assert_allclose(
            there.force, here.force * force, rtol=1e-9, atol=1e-9 * here.normal_force * force
        )
        if isinstance(scene.motion, vc.Steady):
            np.testing.assert_allclose(there.creepage[:2], here.creepage[:2], rtol=1e-7, atol=1e-10)


def steps_of(answer):
    return [answer] if isinstance(answer, vc.Solution) else list(answer)


def test_files_give_it_back(kind, tmp_path):
    """What was saved is found to be what it says, and the scene's file describes the same scene."""
    scene, answer = kind
    answer.save(tmp_path / "answer.nc")
    again = vc.load(tmp_path / "answer.nc")
    for old, new in zip(steps_of(answer), steps_of(again), strict=True):
        assert (new.note, new.converged) == ("", True)
        for name in FIELDS:
            np.testing.assert_array_equal(getattr(new, name), getattr(old, name), err_msg=name)
        assert (new.scene.bodies, new.grid, new.motion) == (old.scene.bodies, old.grid, old.motion)
        assert (new.plan, new.iterations, new.passes) == (old.plan, old.iterations, old.passes)
        np.testing.assert_array_equal(new.creepage, old.creepage)
    assert json.dumps(again.summary(), allow_nan=False) == json.dumps(
        answer.summary(), allow_nan=False
    )
    assert again.report() == answer.report()
    scene.save(tmp_path / "scene.toml")
    table = scene_to(scene)
    for read in (
        vc.read_scene(tmp_path / "scene.toml")[0],
        scene_from(json.loads(json.dumps(table))),
    ):
        assert repr(read) == repr(scene) and scene_to(read) == table
