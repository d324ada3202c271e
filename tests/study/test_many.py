"""Thousands of contacts at once: every scene as `solve` has it, whatever stands beside it."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.discrete.edge_compliance import edge_compliance
from varcontact.elasticity.operators import influence_operator
from varcontact.solvers.batched.newton import solve_batch
from varcontact.solvers.batched.problem import BatchedProblem

KINDS = ("steady", "second-order", "forces", "force", "shift", "shift by force", "line", "explicit")


def scene(kind, rng, grid="auto", unit=1.0):
    """A Hertzian contact of any shape, stiffness and size, from nearly full adhesion to full
    slip.
    """
    G, length = np.exp(rng.uniform(0, 20)) * unit, np.exp(rng.uniform(-5, 5)) * unit
    ratio, friction = np.exp(rng.uniform(-1, 1)), rng.uniform(0.05, 0.6)
    load = rng.uniform(0.5e-3, 2e-3) * G * length**2
    limit, v = friction * load, rng.normal(size=3) * np.exp(rng.uniform(-3, 1)) * friction * 5e-4
    part = rng.uniform(-0.6, 0.6, size=2) * limit
    surface = vc.Paraboloids(ratio * length, length / ratio)
    if kind == "line":
        surface, load, v = vc.Cylinders(length), load / length, 20 * v
    elif rng.uniform() < 0.5:
        surface = vc.Ellipse(0.1 * ratio * length, 0.1 * length / ratio)
    motion = {
        "steady": vc.Steady(vx=v[0], vy=v[1], spin=v[2] / length),
        "second-order": vc.Steady(vx=v[0], vy=v[1], spin=v[2] / length).second_order(),
        "forces": vc.Steady(Fx=part[0], Fy=part[1], spin=0.1 * v[2] / length),
        "force": vc.Steady(vx=v[0], Fy=part[1], spin=v[2] / length),
        "shift": vc.Shift(ux=v[0] * length, uy=v[1] * length, rotation=v[2]),
        "shift by force": vc.Shift(Fx=part[0], uy=v[1] * length),
        "line": vc.Steady(vx=v[0], vy=v[1]),
        "explicit": vc.Steady(vx=v[0], vy=v[1], spin=v[2] / length),
    }[kind]
    if kind == "explicit" and grid != "auto":  # of no symmetry about the contact
        a, b = 0.1 * ratio * length, 0.1 * length / ratio
        surface, sides = vc.Ellipse(a, b), {"dx": 2.2 * a / grid.nx, "dy": 2.4 * b / grid.ny}
        grid = replace(grid, **sides, x0=-1.15 * a, y0=-1.1 * b)
    bodies = vc.Bodies(G, rng.uniform(0, 0.5))
    return vc.Scene(
        bodies=bodies,
        surface=surface,
        normal_force=load,
        friction=friction,
        motion=motion,
        grid=grid,
    )


def check_same(found, i, sol):
    """Forces and moment by f Fz, creepages by the largest of them."""
    limit, (dx, _) = sol.scene.friction * sol.normal_force, sol.grid.sides
    assert abs(float(found.Fx[i]) - sol.Fx) < 1e-8 * limit
    assert abs(float(found.Fy[i]) - sol.Fy) < 1e-8 * limit
    if not sol.grid.line:
        assert abs(float(found.Mz[i]) - sol.Mz) < 1e-8 * limit * dx * sol.grid.nx
    np.testing.assert_allclose(
        [found.vx[i], found.vy[i]],
        [sol.vx, sol.vy],
        rtol=0,
        atol=3e-8 * abs(sol.vx) + abs(sol.vy) * 3e-8,
    )
    assert float(found.normal_force[i]) == pytest.approx(sol.normal_force)
    for name, count in sol.elements.items():
        assert int(found[name][i]) == count, name
        assert float(found[f"{name}_area"][i]) == pytest.approx(sol.areas[name], rel=1e-12)
    assert float(found.max_pressure[i]) == pytest.approx(sol.max_pressure, rel=1e-12)
    rigid = np.abs(sol.creepage) * [1.0, 1.0, dx * sol.grid.nx]
    assert abs(float(found.friction_work[i]) - sol.friction_work) < 1e-7 * limit * rigid.max()


@pytest.mark.parametrize("edge", ["centres", "touched", "softened"])
@pytest.mark.parametrize("kind", KINDS)
def test_scenes_on_a_grid(kind, edge):
    if (edge == "softened" and "shift" in kind) or (edge != "centres" and kind == "explicit"):
        return
    rng = np.random.default_rng(KINDS.index(kind))
    nx, ny = (int(n) for n in rng.integers(5, 19, size=2))
    grid = vc.Grid(nx=nx, ny=None if kind == "line" else ny, edge=edge)
    scenes = [scene(kind, rng, grid) for _ in range(5)]
    found = vc.solve_many(scenes)
    assert set(found.by.values) == {"batched"}
    assert found.ok.all()
    assert found.residual.max() <= 1e-8
    assert found.gap.max() <= 1e-8
    for i, each in enumerate(scenes):
        check_same(found, i, vc.solve(each))


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "second-order"])
def test_scenes_to_an_accuracy_have_the_values_and_bars_of_solve(kind):
    rng = np.random.default_rng(20 + KINDS.index(kind))
    scenes = [scene(kind, rng) for _ in range(3)]
    found = vc.solve_many(scenes, accuracy=0.03)
    assert set(found.by.values) == {"batched"}
    for i, each in enumerate(scenes):
        sol = vc.solve(each, accuracy=0.03)
        limit = each.friction * sol.normal_force
        np.testing.assert_allclose([found.Fx[i], found.Fy[i]], sol.force, rtol=0, atol=1e-5 * limit)
        for name, bar in sol.error_estimate.bars.items():
            name = {"ux": "vx", "uy": "vy"}.get(name, name)
            assert float(found[f"{name}_error"][i]) == pytest.approx(bar, rel=3e-3)


@pytest.mark.long
def test_neighbours_order_and_units_change_nothing():
    """Nor do those on larger lattices, with which a batch shares its arrays."""
    rng, grid = np.random.default_rng(1), vc.Grid(nx=9, ny=12)
    grids = grid, vc.Grid(nx=10, ny=11, edge="touched"), vc.Grid(nx=12, ny=9)
    scenes = [scene(KINDS[i % 4], rng, grids[i % 3]) for i in range(60)]
    together = vc.solve_many(scenes, fields=True)
    limit = np.array([each.friction * each.normal_force for each in scenes])
    order = rng.permutation(60)
    shuffled = vc.solve_many([scenes[i] for i in order])
    np.testing.assert_allclose(
        shuffled.Fx / limit[order], (together.Fx / limit)[order], rtol=0, atol=2e-8
    )
    for i in (7, 8, 9):
        alone = vc.solve_many(scenes[i : i + 1], fields=True)
        assert float(alone.Mz[0]) == pytest.approx(float(together.Mz[i]), abs=2e-8 * limit[i])
        whole = together.isel(scene=i).dropna("y", how="all").dropna("x", how="all")
        own, most = alone.traction[0].values, float(whole.traction_bound.max())
        np.testing.assert_allclose(whole.traction, own, rtol=0, atol=1e-6 * most)
    one, other = (scene("forces", np.random.default_rng(2), grid, unit) for unit in (1.0, 1e3))
    found = vc.solve_many([one, other])
    np.testing.assert_allclose(found.vx[1], found.vx[0], rtol=1e-7)


def test_what_fits_no_batch_is_solved_by_itself():
    rng, grid = np.random.default_rng(3), vc.Grid(nx=8, ny=8)
    plain = scene("steady", rng, grid)
    x = np.linspace(-1, 1, 41) * 0.2
    sampled = vc.SampledDistance(x[None, :] ** 2 + x[:, None] ** 2, x=x, y=x)
    others = [
        replace(plain, friction=0.0),
        replace(plain, friction=np.inf),
        replace(plain, motion=None),
        replace(plain, motion=replace(plain.motion, dq=plain.hertz.a / 3)),
        replace(
            plain,
            bodies=vc.Bodies(G=(1.0, 2.0), nu=(0.0, 0.4)),
            surface=vc.Paraboloids(1.0, 1.0),
            normal_force=1e-3,
        ),
        replace(plain, friction=vc.StaticKinetic(0.4, 0.3, memory_distance=plain.hertz.a)),
        replace(plain, bodies=vc.Bodies(1.0, 0.3), surface=sampled, normal_force=1e-3),
    ]
    found = vc.solve_many([plain, *others])
    assert list(found.by.values) == ["batched", *["solve"] * len(others)]
    assert found.ok.all()
    for i, each in enumerate(others, 1):
        sol = vc.solve(each)
        assert float(found.Fx[i]) == pytest.approx(sol.Fx, rel=1e-9, abs=1e-12)
        assert float(found.normal_force[i]) == pytest.approx(sol.normal_force)


@pytest.mark.parametrize("kind", ["steady", "second-order", "force", "shift"])
def test_laws_of_friction(kind):
    """The ends of the passes of single solves, from stick; with edges that are soft in rolling."""
    rng, grid = (
        np.random.default_rng(7),
        vc.Grid(nx=9, ny=8, edge="centres" if kind == "shift" else "softened"),
    )
    plain = [scene(kind, rng, grid) for _ in range(4)]
    laws = [vc.StaticKinetic, vc.LinearFalling, vc.RationalFalling, vc.ExponentialFalling]
    scenes = []
    for each, law in zip(plain, laws, strict=True):
        rigid = each.motion.rigid
        fall = () if law is vc.StaticKinetic else (max(map(abs, rigid[:2])),)
        scenes.append(replace(each, friction=law(each.friction, 0.7 * each.friction, *fall)))
    found = vc.solve_many(scenes)
    assert set(found.by.values) == {"batched"}
    assert found.residual.max() <= 1e-8
    for i, each in enumerate(scenes):
        sol, limit = vc.solve(each), each.friction.static * float(found.normal_force[i])
        assert abs(float(found.Fx[i]) - sol.Fx) + abs(float(found.Fy[i]) - sol.Fy) < 3e-8 * limit
        assert float(found.friction_work[i]) == pytest.approx(
            sol.friction_work, rel=1e-6, abs=1e-7 * limit * np.abs(each.motion.rigid[:2]).max()
        )
        assert [int(found[name][i]) for name in sol.elements] == list(sol.elements.values())


def test_a_bad_scene_is_named_and_the_others_are_solved():
    rng, grid = np.random.default_rng(4), vc.Grid(nx=8, ny=8)
    scenes = [scene("steady", rng, grid) for _ in range(5)]
    limit = scenes[3].friction * scenes[3].normal_force
    scenes[3] = replace(scenes[3], motion=vc.Steady(Fx=1.2 * limit))
    refused(lambda: vc.solve_many(scenes), match=r"scenes\[3\]: motion", error=vc.Saturated)
    found = vc.solve_many(scenes, failures="keep")
    assert list(found.ok.values) == [True, True, True, False, True]
    assert np.isnan(found.Fx[3])
    assert "cannot be carried" in str(found.message[3].values)
    good = vc.solve_many([*scenes[:3], scenes[4]])
    np.testing.assert_array_equal(good.Fx, found.Fx[[0, 1, 2, 4]])


@pytest.mark.parametrize(
    ("scenes", "options", "field"),
    [
        ([], {}, "scenes"),
        (3, {}, "scenes"),
        (["scene"], {}, r"scenes\[0\]"),
        ("one", {"failures": "ignore"}, "failures"),
        ("one", {"accuracy": -1.0}, "accuracy"),
        ("one", {"tol": 0.0}, "tol"),
        ("auto", {"fields": True}, "fields"),
    ],
)
def test_bad_input(scenes, options, field):
    grid = "auto" if scenes == "auto" else vc.Grid(nx=8, ny=8)
    given = [scene("steady", np.random.default_rng(5), grid)] if isinstance(scenes, str) else scenes
    refused(lambda: vc.solve_many(given, **options), match=field)


def test_guaranteed_bounds_hold():
    kinds, grid = ("steady", "second-order", "shift", "forces", "explicit"), vc.Grid(nx=9, ny=8)
    scenes = [scene(kind, np.random.default_rng(3), grid) for kind in kinds for _ in range(3)]
    found = vc.solve_many(scenes, tol=1e-3, certify="full")
    for i, each in enumerate(scenes):
        exact, limit = vc.solve(each), each.friction * float(found.normal_force[i])
        bound = found[["Fx_bound", "Fy_bound", "Mz_bound"]].isel(scene=i).to_array().values
        errors = np.abs(
            found[["Fx", "Fy", "Mz"]].isel(scene=i).to_array().values - [*exact.force, exact.Mz]
        )
        assert (errors <= bound + 1e-10 * limit).all()
        assert bound[0] < 0.1 * limit
    assert (found.by.values == "batched").sum() == 12


def history(rng, grid, **motion):
    """Of a load that changes; with `dq` for an element or more of rolling, in place without."""
    v, ratio, part = (
        4e-4 * rng.normal(size=(3, 4)),
        np.exp(rng.uniform(-0.5, 0.5)),
        rng.uniform(-0.5, 0.5, size=4),
    )
    load = 1e-3 * rng.uniform(0.6, 1.2, size=4)
    given = [
        {"vx": v[0], "vy": v[1], "spin": 3 * v[2], "rotation": 1e-5, "ux": 1e-5},
        {"Fx": 0.3 * part * load, "vy": v[1], "spin": 3e-4},
    ][rng.integers(2)]
    bodies = vc.Bodies(1.0, rng.uniform(0, 0.5))
    motion = vc.Transient(
        steps=4, normal_force=load, friction=[None, 0.4, 0.3, None], **given, **motion
    )
    return make_scene(vc.Paraboloids(ratio, 1 / ratio), None, motion, grid, bodies=bodies)


@pytest.mark.long
@pytest.mark.parametrize("motion", [{}, {"direction": [1, -1, -1, 1]}, {"dq": 0.0}, {"dq": 0.01}])
def test_histories_side_by_side(motion):
    rng = np.random.default_rng(6)
    scenes = [history(rng, vc.Grid(nx=nx, ny=8, edge="centres"), **motion) for nx in (9, 11, 9, 9)]
    found = vc.solve_many(scenes)
    assert set(found.by.values) == {"solve" if motion == {"dq": 0.01} else "batched"}
    assert dict(found.sizes) == {"scene": 4, "step": 4}
    for i, each in enumerate(scenes):
        steps = vc.solve(each)
        limit = np.array([0.3, 0.4, 0.3, 0.3]) * [step.normal_force for step in steps]
        for name in ("Fx", "Fy", "Mz"):
            expected = np.array([getattr(step, name) for step in steps])
            np.testing.assert_allclose(found[name][i] / limit, expected / limit, rtol=0, atol=1e-8)
        np.testing.assert_allclose(
            found.vx[i], [step.creepage[0] for step in steps], rtol=1e-7, atol=1e-11
        )
        assert [int(n) for n in found.slip[i]] == [step.elements["slip"] for step in steps]


@pytest.mark.long
def test_histories_of_other_lengths_and_other_motions_are_refused_by_name():
    rng, grid = np.random.default_rng(6), vc.Grid(nx=8, ny=8)
    rolling = scene("steady", rng, grid)
    for others in ([rolling], [replace(rolling, motion=vc.Transient(steps=2, vx=1e-3))]):
        with pytest.raises(vc.SceneError, match=r"scenes\[1\].motion"):
            vc.solve_many([history(rng, grid), *others])
    with pytest.raises(vc.SceneError, match=r"scenes\[0\]"):
        vc.solve_many(
            [replace(rolling, friction=np.inf, motion=vc.Harmonic(wave_number=1.0, vx=1e-3))]
        )
    refused(lambda: vc.solve_many([history(rng, grid)], fields=True), match="fields")
    with pytest.raises(vc.Saturated, match=r"scenes\[0\]"):
        vc.solve_many(
            [replace(rolling, motion=vc.Transient(steps=2, Fx=[0.0, rolling.normal_force]))]
        )
    with pytest.raises(vc.NoContact, match=r"scenes\[0\]"):
        vc.solve_many([replace(rolling, motion=vc.Transient(steps=4, normal_force=0.0))])


def test_no_creepage_no_force():
    still = replace(
        scene("steady", np.random.default_rng(7), vc.Grid(nx=8, ny=8)), motion=vc.Steady()
    )
    found = vc.solve_many([still])
    assert found.ok.all()
    assert float(found.Fx[0]) == float(found.Fy[0]) == float(found.residual[0]) == 0.0


def test_a_warm_start_ends_at_the_same_tractions():
    rng, grid = np.random.default_rng(8), vc.Grid(nx=16, ny=16, edge="softened")
    scenes = [scene(kind, rng, grid) for kind in ("steady", "forces") for _ in range(3)]
    before = vc.solve_many(scenes, fields=True)
    later = [replace(each, normal_force=1.02 * each.normal_force) for each in scenes]
    cold, warm = vc.solve_many(later, fields=True), vc.solve_many(later, fields=True, start=before)
    assert warm.iterations.mean() < 0.85 * cold.iterations.mean()
    most = cold.traction_bound.max(("y", "x"))
    np.testing.assert_allclose(warm.traction / most, cold.traction / most, rtol=0, atol=1e-6)
    sol = vc.solve(later[0])
    np.testing.assert_allclose(cold.traction[0], sol.traction, rtol=0, atol=1e-7 * float(most[0]))
    np.testing.assert_allclose(
        cold.traction_bound[0], sol.traction_bound, rtol=1e-12, atol=1e-12 * float(most[0])
    )
    np.testing.assert_allclose(cold.x_centre[0], sol.grid.x, rtol=1e-12)


def test_starts_that_do_not_do_are_refused_in_words():
    coarse, fine = (scene("steady", np.random.default_rng(8), vc.Grid(nx=n, ny=n)) for n in (6, 10))
    before = vc.solve_many([coarse], fields=True)
    turned = vc.solve_many(
        [coarse], fields=True, start=before.transpose("y", "x", "component", "scene")
    )
    assert float(abs(turned.Fx[0] - before.Fx[0])) < 1e-8 * coarse.friction * coarse.normal_force
    without = (
        before.drop_vars("traction_bound"),
        before.rename(scene="other"),
        before.drop_vars("vx"),
    )
    for scenes, start in (
        ([fine], before),
        ([coarse] * 2, before),
        *(([coarse], each) for each in (5, {}, *without)),
    ):
        with pytest.raises(vc.SceneError, match="start"):
            vc.solve_many(scenes, start=start)
    with pytest.raises(vc.SceneError, match="start"):
        vc.solve_many([replace(coarse, grid="auto")], start=before)
    refused(lambda: vc.solve_many([coarse], fields="no"), match="fields")


@pytest.mark.parametrize("tol", [1e-4, 1e-8])
def test_spin_on_a_slender_ellipse_converges(tol):
    """Where steps damped too much would hardly get on; in single precision and in double."""
    ellipse, motion = vc.Ellipse(a=5**0.5, b=5**-0.5), vc.Steady(spin=1.1338e-4)
    spins = make_scene(ellipse, 1e-3, motion, vc.Grid(nx=48, ny=32), 1.0).second_order()
    found, sol = vc.solve_many([spins], tol=tol), vc.solve(spins, certify=None)
    assert found.by.values == ["batched"]
    assert found.iterations[0] < 30
    assert abs(float(found.Mz[0]) - sol.Mz) + abs(float(found.Fy[0]) - sol.Fy) < tol * 1e-3


@pytest.mark.long
@pytest.mark.parametrize("difference", ["first-order", "second-order", None])
def test_bounds_with_holes_and_noise_against_the_dense_matrix(difference):
    rng = np.random.default_rng(9)
    ny, nx, n = 11, 17, 4
    dx, dy, nu = rng.uniform(0.1, 0.3, n), rng.uniform(0.1, 0.3, n), rng.uniform(0, 0.5, n)
    bound = np.exp(0.5 * rng.normal(size=(ny, nx, n))) * (rng.uniform(size=(ny, nx, n)) < 0.6)
    shift, covered = (
        0.1 * rng.normal(size=(2, 1, 1, n)) + np.zeros((2, ny, nx, n)),
        rng.uniform(0.3, 1.0, (ny, nx)),
    )
    compliance = edge_compliance(covered)
    force = np.full((2, n), np.nan)
    force[0, 0] = 0.3 * bound[..., 0].sum()
    shift[0, ..., 0] = 0.0
    found = solve_batch(
        BatchedProblem(dx, dy, nu, shift, bound, force, difference, compliance=compliance), 1e-9
    )
    assert found.converged.all()
    for i in range(n):
        grid = vc.Grid(nx=nx, ny=ny, dx=dx[i], dy=dy[i], x0=0.0, y0=0.0)
        lag = {} if difference is None else {"lag": dx[i], "difference": difference}
        operator = influence_operator(grid, "xy", "xy", nu=nu[i], **lag)
        p = found.traction[..., i]
        own = np.array([operator.table[c, c, ny - 1, nx - 1] for c in (0, 1)])[:, None, None]
        E = shift[..., i] + found.rigid[:, i, None, None] + operator.apply(p) + own * compliance * p
        size, slip = np.hypot(*p), np.hypot(*E)
        assert (size <= bound[..., i] * (1 + 1e-12)).all()
        assert np.sum(bound[..., i] * slip + np.sum(p * E, axis=0)) < 1e-8 * np.sum(
            bound[..., i] * slip.max()
        )
    assert found.traction[0, ..., 0].sum() == pytest.approx(force[0, 0], rel=1e-8)
    broken = bound.copy()
    broken[5, 8, 1] = np.nan
    spoilt = solve_batch(
        BatchedProblem(dx, dy, nu, shift, broken, force, difference, compliance=compliance), 1e-9
    )
    assert spoilt.converged.tolist() == [True, False, True, True]
    others = [0, 2, 3]
    np.testing.assert_allclose(
        spoilt.traction[..., others], found.traction[..., others], rtol=0, atol=1e-7
    )


def test_grids_that_do_not_hold_the_contact():
    """One on which it goes on outside, and one whose elements are too large for it: refused in the
    words of `solve`.
    """
    ball = scene("steady", np.random.default_rng(5), vc.Grid(nx=16, ny=16))
    a, b = ball.hertz.a, ball.hertz.b
    beside = vc.Grid(nx=16, ny=16, dx=a / 8, dy=b / 6, x0=-0.5 * a, y0=-1.3 * b)
    coarse = vc.Grid(nx=8, ny=8, dx=4 * a, dy=4 * b, x0=-16 * a, y0=-16 * b)
    assert not ball.hertz.on_elements(coarse).any()
    for grid in (beside, coarse):
        alone = replace(ball, grid=grid)
        with pytest.raises(vc.SceneError) as expected:
            vc.solve(alone)
        with pytest.raises(vc.SceneError) as found:
            vc.solve_many([ball, alone])
        assert str(found.value) == f"scenes[1]: {expected.value}"
