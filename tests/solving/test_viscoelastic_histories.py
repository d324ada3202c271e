"""Viscoelastic bodies in time: closed forms of creep and relaxation, steady rolling, limits of
time, energy.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.elasticity.operators import influence_operator
from varcontact.io.records import checked_layout

PART, TAU, NU = 1.5, 0.4, 0.3
SOLID = vc.Viscoelastic(1.0, NU, [(PART, TAU)])
OTHER = vc.Viscoelastic(0.5, 0.1, [(0.8, 0.2), (0.5, 0.6)])
NUMBERS = ("approach", "rolling_resistance", "Fx", "Fy")
LINE, BALL = vc.Cylinders(R=1.0, reference_depth=8.0), vc.Paraboloids(1.0, 1.0)


def scene(
    bodies=SOLID,
    surface=BALL,
    cells=10,
    friction=0.3,
    grid=None,
    normal_force=0.1,
    approach=None,
    **motion,
):
    line = isinstance(surface, vc.Cylinders)
    grid = grid or (vc.Grid(nx=cells) if line else vc.Grid(nx=cells, ny=cells))
    load = None if approach else normal_force
    return make_scene(
        surface, load, vc.Transient(**motion), grid, friction, bodies, approach=approach
    )


def furthest(one, other):
    fields = [np.concatenate([sol.traction, sol.pressure[None]]) for sol in (one, other)]
    return np.abs(fields[0] - fields[1]).max() / other.max_pressure


@pytest.mark.parametrize("surface", [LINE, BALL])
def test_creep_under_a_step_of_load(surface):
    """The contact grows as the elastic one of compliance J(t) (Lee and Radok 1960), by long steps
    as by short ones.
    """
    time = np.array([0.0, *np.geomspace(0.05, 4.0, 9)])
    steps = np.diff(time, prepend=0.0)
    history = vc.solve(scene(surface=surface, cells=61, friction=0.0, steps=10, dq=0, dt=steps))
    for sol, t in zip(history, time, strict=True):
        soft = vc.Bodies(1 / (1 + PART * (1 - np.exp(-t / TAU))), NU)
        exact = vc.Scene(bodies=soft, surface=surface, normal_force=0.1).hertz
        across = np.sum(sol.pressure.any(axis=0)) * sol.grid.sides[0]
        assert across == pytest.approx(2 * exact.a, abs=2 * sol.grid.sides[0])
        assert sol.approach == pytest.approx(exact.approach, rel=2e-3)
        assert sol.certificate.residual < 1e-7


@pytest.mark.parametrize("surface", [LINE, BALL])
def test_relaxation_under_a_step_of_approach(surface):
    """The force falls by the relaxation modulus, to second order in the step; so does that of a
    shift without slip.
    """
    off = []
    for count in (8, 16):
        steps = [0.0] + [3 * TAU / count] * count
        given = {"steps": count + 1, "dq": 0, "dt": steps, "ux": [1e-3] + [0.0] * count}
        history = vc.solve(scene(surface=surface, approach=0.05, friction=np.inf, **given))
        modulus = (1 + PART * np.exp(-(1 + PART) * np.cumsum(steps) / TAU)) / (1 + PART)
        forces = np.array([(sol.normal_force, sol.Fx) for sol in history])
        off.append(np.abs(forces / forces[0] - modulus[:, None]).max())
    assert off[1] < 0.3 * off[0] < 0.3 * 0.015


@pytest.mark.long
@pytest.mark.parametrize(
    ("surface", "bodies"), [(LINE, (SOLID, OTHER)), (BALL, SOLID)], ids=["line", "ball"]
)
def test_a_long_history_tends_to_steady_rolling(bodies, surface):
    """To that by influence numbers that lag: resistance and approach to second order in the
    step.
    """
    off, rolled = [], 8 if surface is LINE else 4
    for cells in (8, 16):
        grid = vc.solve(scene(bodies, surface, cells, friction=0.0, steps=1, dt=1.0)).grid
        dx, given = grid.sides[0], {"vx": 0.02, "vy": 0.01}
        last = vc.solve(scene(bodies, surface, grid=grid, steps=int(rolled / dx), dt=dx, **given))[
            -1
        ]
        steady = vc.solve(replace(last.scene, motion=vc.Steady(speed=1.0, **given)))
        assert last.certificate.residual < 1e-7
        off.append([abs(getattr(last, name) / getattr(steady, name) - 1) for name in NUMBERS])
        assert furthest(last, steady) < 0.2 / cells
    assert off[0][0] < 2e-3 and off[0][1] < 2e-2
    for finer in off[1:]:
        assert finer[0] < 0.35 * off[0][0] and finer[1] < 0.45 * off[0][1]
        assert max(finer) < 0.011


@pytest.mark.parametrize("surface", [LINE, BALL], ids=["line", "ball"])
def test_steps_that_take_no_time_or_ages_are_elastic(surface):
    """Those of glassy bodies, and of relaxed ones; what takes no time knows nothing of the bodies'
    relaxations.
    """
    grid = vc.solve(scene(SOLID, surface, friction=0.0, steps=1, dt=1.0)).grid
    # whole elements: between them what is remembered is interpolated
    dq = [grid.sides[0]] * 3 + [0.0] * 3
    moves = {"steps": 6, "vx": 0.02, "vy": 0.01, "dq": dq, "ux": [0.0] * 3 + [1e-3] * 3}
    for dt, G, allowed in ((0.0, 1.0, 1e-9), (1e9 * TAU, 1 / (1 + PART), 1e-6)):
        slow = vc.solve(scene(SOLID, surface, grid=grid, dt=dt, **moves))
        elastic = vc.solve(scene(vc.Bodies(G, NU), surface, grid=grid, **moves), normal="norm")
        assert max(furthest(*steps) for steps in zip(slow, elastic, strict=True)) < allowed
        assert slow[-1].friction_work == pytest.approx(elastic[-1].friction_work, rel=1e-4)


@pytest.mark.long
def test_rolling_the_other_way_is_the_mirror_image():
    """By steps of any part of an element."""
    grid = vc.Grid(nx=14, ny=10, dx=0.09, dy=0.11, x0=-0.63, y0=-0.55)
    given = {"steps": 5, "dt": 0.05, "dq": [0.0, 0.04, 0.09, 0.3, 0.02], "vy": 0.01}
    one = vc.solve(scene((SOLID, OTHER), grid=grid, vx=0.02, spin=0.01, **given))
    two = vc.solve(scene((SOLID, OTHER), grid=grid, vx=-0.02, spin=-0.01, direction=-1, **given))
    for sol, image in zip(one, two, strict=True):
        np.testing.assert_allclose(
            image.pressure[:, ::-1], sol.pressure, atol=1e-7 * sol.max_pressure
        )
        mirrored = image.traction[..., ::-1] * [[[-1.0]], [[1.0]]]
        np.testing.assert_allclose(mirrored, sol.traction, atol=1e-7 * sol.max_pressure)
        assert image.friction_work == pytest.approx(sol.friction_work, rel=1e-6)


def energy(sol):
    """Stored by tangential tractions, and lost by their relaxation in a unit of time; of like
    bodies.
    """
    grid, ahead = sol.grid, (sol.memory.shape[-1] - sol.grid.nx) // 2
    operator = influence_operator(
        grid.window(-ahead, grid.nx + ahead, -1, grid.rows + 1), "xy", "xy", nu=NU
    )
    now, then = np.pad(sol.traction, ((0, 0), (1, 1), (ahead, ahead))), sol.memory[0, :2]
    work = [
        float(np.sum(field * operator.apply(field))) * grid.area
        for field in (now, then, now - then)
    ]
    return (work[0] + PART * work[1]) / 2, PART * work[2] / TAU


@pytest.mark.long
def test_what_is_put_in_is_lost_or_stored():
    """From rest to rolling with spin: by friction, by relaxation, which is never negative, and in
    both springs.
    """
    off = []
    for cells in (10, 20):
        dx = vc.solve(scene(cells=cells, friction=0.0, steps=1, dt=1.0)).grid.sides[0]
        given = {"vx": 0.02, "spin": 0.03, "dq": dx, "dt": dx}
        moving = {name: [0.0] + [value] * cells for name, value in given.items()}
        history = vc.solve(scene(cells=cells, steps=cells + 1, **moving))
        stored, rate = np.transpose([energy(sol) for sol in history])
        put = -np.array([0.02 * sol.Fx + 0.03 * sol.Mz for sol in history])
        put, relaxed = (dx * float(np.sum(values[1:] + values[:-1])) / 2 for values in (put, rate))
        lost = dx * sum(sol.friction_work for sol in history)
        assert rate.min() >= 0
        assert min(stored[-1], relaxed, lost) > 0.2 * put
        off.append(abs((stored[-1] + relaxed + lost) / put - 1))
    assert off[1] < 0.45 * off[0] < 0.45 * 0.04


COATED = vc.Layered([vc.Layer(0.3, 1.0, 0.4)], "rigid", [(1.0, 0.3)])


@pytest.mark.long
@pytest.mark.parametrize("bodies", [(SOLID, OTHER), ("rigid", COATED)])
def test_two_solvers_agree_while_loads_change(bodies):
    motion = {"steps": 5, "dt": [0.0, 0.1, 0.3, 0.1, 0.2], "vx": 0.02}
    grid = vc.Grid(nx=16, ny=14, dx=0.07, dy=0.08, x0=-0.56, y0=-0.56)
    loads = vc.Transient(**motion, normal_force=[0.02, 0.05, 0.05, 0.0, 0.03])
    posed = replace(scene(bodies, grid=grid, **motion), motion=loads)
    one = vc.solve(posed)
    two = vc.solve(posed, method="convex", coupling="panagiotopoulos", tol=1e-9)
    for sol, other in zip(one, two, strict=True):
        assert sol.pressure.any() == (sol.normal_force > 0)
        if sol.pressure.any():
            assert furthest(sol, other) < 1e-5


def test_a_dent_recovers():
    """Bodies that were pressed together are apart at a lesser approach, and touch again when the
    dent has risen.
    """
    loads = vc.Transient(
        steps=4, dq=0, dt=[0.0, 2 * TAU, 0.0, 4 * TAU], approach=[0.05, 0.05, 0.025, 0.025]
    )
    grid = vc.Grid(nx=14, ny=14, dx=0.08, dy=0.08, x0=-0.56, y0=-0.56)
    history = vc.solve(replace(scene(grid=grid, steps=1, dt=0.0), normal_force=None, motion=loads))
    assert [sol.normal_force > 0 for sol in history] == [True, True, False, True]
    assert history[2].distance.min() > 0
    fresh = vc.solve(replace(scene(grid=grid, steps=1, dt=0.0, approach=0.025)))
    assert history[3].normal_force < fresh[0].normal_force


@pytest.mark.long
def test_files_keep_what_bodies_remember(tmp_path):
    whole = scene((SOLID, OTHER), steps=6, dt=0.1, vx=0.02)
    history = vc.solve(whole)
    half = replace(whole, motion=replace(whole.motion, steps=3), grid=history.grid)
    vc.solve(half).save(tmp_path / "half.nc")
    loaded = vc.load(tmp_path / "half.nc")
    assert all(sol.note == "" and sol.converged for sol in loaded)
    on = vc.solve(replace(half, motion=replace(half.motion, start=loaded[-1])))
    assert furthest(on[-1], history[-1]) < 1e-7
    history.save(tmp_path / "cut.nc")
    layout = checked_layout(tmp_path / "cut.nc")
    content = bytearray((tmp_path / "cut.nc").read_bytes())[: layout.begin + 2 * layout.size]
    content[4:8] = (2).to_bytes(4, "big")
    (tmp_path / "cut.nc").write_bytes(content)
    again = vc.solve(whole, store=tmp_path / "cut.nc")
    np.testing.assert_array_equal(again[-1].memory, history[-1].memory)
    np.testing.assert_array_equal(again[-1].traction, history[-1].traction)
    history[-1].save(tmp_path / "last.nc")
    np.testing.assert_array_equal(vc.load(tmp_path / "last.nc").memory, history[-1].memory)
    whole.save(tmp_path / "scene.toml")
    assert vc.read_scene(tmp_path / "scene.toml")[0].motion.dt == 0.1


ROLLS = replace(scene(steps=1, dt=1.0, cells=6), motion=vc.Steady(speed=1.0))
SHALLOW, SAMPLES = (
    vc.Cylinders(1.0, 2.0),
    vc.SampledDistance(np.ones((2, 2)), [0.0, 1.0], [0.0, 1.0]),
)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: scene(steps=2), "motion.dt"),
        (lambda: scene(steps=2, dt=-1.0), "motion.dt"),
        (lambda: scene(steps=2, dt=[0.1]), "motion.dt"),
        (lambda: scene(vc.Bodies(1.0, NU), steps=2, dt=0.1), "motion.dt"),
        (lambda: scene(steps=2, dt=0.1, grid=vc.Grid(nx=9, ny=9, edge="touched")), "grid.edge"),
        (lambda: scene(steps=2, dt=0.1, grid=vc.Grid(nx=9, ny=9, edge="softened")), "grid.edge"),
        (
            lambda: vc.solve(replace(scene(steps=2, dq=0.1, dt=0.1), grid="auto"), accuracy=0.01),
            "bodies",
        ),
        (
            lambda: vc.solve(scene(surface=SHALLOW, steps=60, dt=1e-3, vx=0.01)),
            "surface.reference_depth",
        ),
        (lambda: vc.solve(scene(steps=2, dt=0.1, start=vc.solve(ROLLS))), "motion.start"),
        (lambda: scene(surface=SAMPLES, steps=2, dt=0.1), "surface.x"),
    ],
)
def test_bad_input(make, field):
    refused(make, field)
