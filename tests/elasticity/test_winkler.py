"""Winkler beddings: closed forms of springs, the simplified theory, thin layers, and what is
refused.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc

BED = vc.Winkler(h=0.1, E=3.0, G=1.0)
RX, RY, APPROACH = 1.0, 2.0, 0.01
COMPLIANCE = 2 * BED.h / BED.E
FLEXIBILITY = 2 * BED.h / BED.G
A, B = math.sqrt(2 * RX * APPROACH), math.sqrt(2 * RY * APPROACH)
LOAD = math.pi * A * B * APPROACH / COMPLIANCE / 2
FRICTION = 0.3


def scene(cells=20, **changes):
    found = vc.Scene(
        bodies=BED,
        surface=vc.Paraboloids(RX, RY),
        normal_force=LOAD,
        grid=vc.Grid(nx=cells, ny=cells),
    )
    return replace(found, **changes)


def rolling(cells=20, **creepages):
    return scene(cells, friction=FRICTION, motion=vc.Steady(**creepages))


def test_pressures_are_overlaps():
    """``p = (d - h)/(k1 + k2)`` in every element, zero and ``e = h - d`` elsewhere (1.2)."""
    grid = vc.Grid(nx=30, dx=0.1, x0=-1.5)
    distance = 0.1 * grid.x**2 + 0.05 * np.sin(7 * grid.x)
    sol = vc.solve(
        scene(
            bodies=(BED, "rigid"),
            surface=vc.SampledDistance(distance),
            normal_force=None,
            approach=0.02,
            grid=grid,
        )
    )
    overlap = 0.02 - distance
    expected = np.maximum(overlap, 0.0) * BED.E / BED.h
    np.testing.assert_allclose(sol.pressure[0], expected, atol=1e-9 * expected.max())
    np.testing.assert_allclose(sol.distance[0], np.maximum(-overlap, 0.0), atol=1e-9)
    assert sol.certificate.normal_residual < 1e-12


def test_paraboloids_have_a_parabolic_pressure():
    """Semi-axes ``sqrt(2 R d)``, the largest pressure d/k, the force half of it over the ellipse."""
    found = vc.solve(scene(40))
    assert found.approach == pytest.approx(APPROACH, rel=2e-3)
    x, y = np.meshgrid(found.grid.x, found.grid.y)
    height = 1 - (x / A) ** 2 - (y / B) ** 2
    expected = APPROACH / COMPLIANCE * np.maximum(height, 0.0)
    np.testing.assert_allclose(found.pressure, expected, atol=3e-3 * expected.max())


@pytest.mark.parametrize("creepage", [(0.004, 0.0), (0.02, 0.01), (0.2, 0.0)])
def test_steady_rolling_is_the_simplified_theory(creepage):
    """Extrapolated from two grids: the closed force (168)-(169) with the flexibility h/G."""
    vx, vy = creepage
    limit = FRICTION * LOAD
    coarse, fine = (vc.solve(rolling(n, vx=vx, vy=vy)).force / limit for n in (20, 40))
    exact = vc.theories.simplified_force(A, B, FLEXIBILITY, limit, vx, vy) / limit
    np.testing.assert_allclose(fine, exact, atol=0.02)
    np.testing.assert_allclose(2 * fine - coarse, exact, atol=4e-3)


@pytest.mark.parametrize(
    "motion",
    [vc.Steady(vx=0.01, spin=0.1), vc.Shift(ux=5e-3, rotation=0.02), vc.Steady(Fx=-0.5 * LOAD / 4)],
)
def test_solvers_agree_and_forces_are_bounded(motion):
    held = scene(12, friction=FRICTION, motion=motion)
    solutions = [
        vc.solve(held, tangential=name) for name in ("tang-safeguarded", "newton", "clarabel")
    ]
    first = solutions[0]
    largest = np.abs(first.traction).max()
    for other in solutions:
        np.testing.assert_allclose(other.traction, first.traction, atol=1e-7 * largest)
        assert other.certificate.residual < 1e-8
        assert np.all(np.isfinite(other.certificate.force_bound))


def test_a_shift_is_springs_that_slide():
    found = vc.solve(scene(16, friction=FRICTION, motion=vc.Shift(ux=4e-3)), normal="norm")
    bound = FRICTION * found.pressure
    expected = -np.minimum(4e-3 / FLEXIBILITY, bound)
    np.testing.assert_allclose(found.traction[0], expected, atol=1e-9 * bound.max())


def test_a_history_ends_in_steady_rolling():
    steady = vc.solve(rolling(14, vx=0.02, spin=0.05))
    motion = vc.Transient(steps=18, vx=0.02, spin=0.05)
    history = vc.solve(replace(steady.scene, motion=motion, grid=steady.grid))
    np.testing.assert_allclose(
        history[-1].traction, steady.traction, atol=1e-7 * steady.traction_bound.max()
    )


@pytest.mark.parametrize(("thinness", "off", "off_rolling"), [(5, 5e-3, 0.25), (80, 1e-4, 0.01)])
def test_a_thin_layer_is_a_bedding(thinness, off, off_rolling):
    """The force at an approach, and that of rolling: the nearer, the wider the contact is."""
    layer = vc.Layer(h=1 / thinness, G=1.0, nu=0.3)
    bodies = {
        "layer": vc.Layered([layer], base="rigid"),
        "bedding": vc.Winkler.of_layer(h=1 / thinness, G=1.0, nu=0.3),
    }
    line = {"surface": vc.Cylinders(R=100.0), "grid": vc.Grid(nx=50), "approach": 0.005}
    forces = {
        name: vc.solve(
            vc.Scene(bodies=body, friction=0.3, motion=vc.Steady(vx=2e-4), **line),
        )
        for name, body in bodies.items()
    }
    one, other = forces.values()
    assert one.normal_force == pytest.approx(other.normal_force, rel=off)
    assert one.Fx == pytest.approx(other.Fx, rel=off_rolling)


def test_units_do_not_matter():
    one = vc.solve(rolling(12, vx=0.02, spin=0.05))
    bed = vc.Winkler(h=100.0, E=3.0, G=1.0)
    surface = vc.Paraboloids(1e3 * RX, 1e3 * RY)
    motion = vc.Steady(vx=0.02, spin=0.05e-3)
    other = vc.solve(
        replace(one.scene, bodies=bed, surface=surface, normal_force=1e6 * LOAD, motion=motion)
    )
    np.testing.assert_allclose(other.traction, one.traction, atol=1e-9)


def test_accuracy_on_demand_meets_the_closed_form():
    limit = FRICTION * LOAD
    found = vc.solve(replace(rolling(vx=0.02), grid="auto"), accuracy=0.01)
    exact = vc.theories.simplified_force(A, B, FLEXIBILITY, limit, 0.02, 0.0)[0]
    assert found.Fx == pytest.approx(exact, abs=0.01 * limit)


def test_files_keep_beddings(tmp_path):
    for bodies in (BED, (BED, "rigid"), ("rigid", BED), (BED, vc.Winkler(h=0.2, E=1.0, G=2.0))):
        made = replace(rolling(10, vx=0.01), bodies=bodies)
        made.save(tmp_path / "bedding.toml", overwrite=True)
        read, _ = vc.read_scene(tmp_path / "bedding.toml")
        assert read.bodies == made.bodies
    sol = vc.solve(made)
    sol.save(tmp_path / "bedding.nc")
    assert vc.load(tmp_path / "bedding.nc").note == ""
    (tmp_path / "by_hand.toml").write_text(
        "normal_force = 1.0\nbodies = {kind = 'winkler', h = 0.1, E = 3.0, G = 1.0}\n"
        "surface = {kind = 'paraboloids', Rx = 1.0, Ry = 2.0}\n"
    )
    assert vc.read_scene(tmp_path / "by_hand.toml")[0].bodies.upper == BED


@pytest.mark.parametrize(
    ("make", "field", "words"),
    [
        (lambda: vc.Winkler(h=0.0, E=1.0, G=1.0), "bodies.h", "positive"),
        (lambda: vc.Winkler(h=1.0, E=-1.0, G=1.0), "bodies.E", "positive"),
        (lambda: vc.Winkler(h=1.0, E=1.0, G=math.inf), "bodies.G", "finite"),
        (lambda: vc.Winkler.of_layer(h=1.0, G=1.0, nu=0.5), "nu", "below 0.5"),
        (lambda: scene(bodies=(BED, vc.Bodies(1.0, 0.3))), "bodies", "on another one or on"),
        (lambda: scene(surface=vc.Ellipse(1.0, 1.0)), "surface", "Hertz|half-spaces"),
        (lambda: vc.stress_below(vc.solve(scene(8)), depths=[0.1]), "body", "not known"),
        (lambda: vc.solve(rolling(vx=0.01), tangential="fastsim"), "tangential", "half-spaces"),
        (lambda: vc.solve(scene(), normal="hertz"), "normal", "half-spaces"),
    ],
)
def test_what_is_refused(make, field, words):
    with pytest.raises(vc.SceneError, match=words) as error:
        make()
    assert error.value.field == field
