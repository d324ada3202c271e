"""What must not change, or only its sign, and Kalker's conditions on random scenes."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.conditions import violations
from varcontact.reference import line_contact

LIKE, UNLIKE = vc.Bodies(G=1.0, nu=0.28), vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.4))
DEPTH = 30.0
MOTIONS = {
    "creepage": vc.Steady(vx=0.02, vy=-0.01),
    "force": vc.Steady(Fx=-0.06, vy=0.005),
    "forces": vc.Steady(Fx=0.05, Fy=0.05),
    "shift": vc.Shift(ux=0.05, uy=-0.02),
    "shift by force": vc.Shift(Fx=-0.05, uy=0.01),
}


def scene(**changes):
    base = {
        "bodies": LIKE,
        "surface": vc.Cylinders(R=5.0, reference_depth=DEPTH),
        "normal_force": 0.5,
        "friction": 0.25,
        "motion": MOTIONS["creepage"],
        "grid": vc.Grid(nx=40),
    }
    return vc.Scene(**(base | changes))


def same(first, second, signs=(1, 1), tol=1e-10):
    """Pressures, tractions, slip, forces and creepages agree but for the signs of the tangential components."""
    signs, peak = np.array(signs)[:, None, None], first.pressure.max()
    np.testing.assert_allclose(second.pressure, first.pressure, atol=tol * peak)
    np.testing.assert_allclose(second.traction, signs * first.traction, atol=tol * peak)
    np.testing.assert_allclose(second.slip, signs * first.slip, atol=tol * np.abs(first.slip).max())
    np.testing.assert_array_equal(second.state, first.state)
    assert second.approach == pytest.approx(first.approach, rel=tol, nan_ok=True)
    expected = np.append(signs.ravel(), 1) * first.creepage
    np.testing.assert_allclose(second.creepage, expected, atol=tol * np.abs(first.slip).max())


def changed(motion, along_x=1, along_y=1):
    """A motion with other signs."""
    factors = {"vx": along_x, "ux": along_x, "Fx": along_x, "vy": along_y, "uy": along_y, "Fy": along_y}
    given = {name: getattr(motion, name, None) for name in factors}
    return dataclasses.replace(motion, **{k: v * factors[k] for k, v in given.items() if v is not None})


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("bodies", [LIKE, UNLIKE], ids=["like", "unlike"])
def test_units(motion, bodies):
    """Steel in SI, quantities at an extreme, and the dimensionless scene are one."""
    plain = vc.solve(scene(bodies=bodies, motion=motion))
    for G, length in ((8e10, 1e-3), (1e-6, 1e5)):
        force = G * length  # per unit length
        factors = {"vx": 1, "vy": 1, "ux": length, "uy": length, "Fx": force, "Fy": force}
        values = {name: getattr(motion, name, None) for name in factors}
        scaled = scene(
            bodies=vc.Bodies(G=tuple(G * modulus for modulus in bodies.pairs[0]), nu=bodies.nu),
            surface=vc.Cylinders(R=5.0 * length, reference_depth=DEPTH * length),
            normal_force=0.5 * force,
            motion=dataclasses.replace(motion, **{k: v * factors[k] for k, v in values.items() if v is not None}),
        )
        sol = vc.solve(scaled)
        np.testing.assert_allclose(sol.pressure / G, plain.pressure, atol=1e-9 * plain.pressure.max())
        np.testing.assert_allclose(sol.traction / G, plain.traction, atol=1e-9 * plain.pressure.max())
        np.testing.assert_array_equal(sol.state, plain.state)
        assert sol.approach / length == pytest.approx(plain.approach, rel=1e-9)
        unit = length if isinstance(motion, vc.Shift) else 1.0
        np.testing.assert_allclose(np.array(sol.creepage) / unit, plain.creepage, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_signs(motion):
    """Motion and forces reversed in either direction: so are the tractions. Like bodies both ways, unlike ones in y."""
    for bodies, x, y in ((LIKE, -1, 1), (LIKE, -1, -1), (LIKE, 1, -1), (UNLIKE, 1, -1)):
        one, other = (vc.solve(scene(bodies=bodies, motion=m)) for m in (motion, changed(motion, x, y)))
        same(one, other, (x, y))


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_exchange_of_unlike_bodies(motion):
    """The constants exchanged and the motion along x reversed: only traction and slip along x change, their sign."""
    swapped = vc.Bodies(G=UNLIKE.G[::-1], nu=UNLIKE.nu[::-1])
    assert swapped.K == pytest.approx(-UNLIKE.K, rel=1e-14)
    one = vc.solve(scene(bodies=UNLIKE, motion=motion))
    assert one.plan.coupling == "panagiotopoulos"
    same(one, vc.solve(scene(bodies=swapped, motion=changed(motion, -1))), (-1, 1), tol=1e-8)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE], ids=["like", "unlike"])
def test_mirror_of_a_shift(bodies):
    """x to -x, in a contact without symmetry of its own: pressures are mirrored, tractions along x change sign, too."""
    x = np.linspace(-3.0, 3.0, 301)
    h = x**2 / 3 + 0.01 * np.sin(3 * x) + 0.02 * x**3
    grid = vc.Grid(nx=48, dx=0.0625, x0=-1.625)
    mirrored = vc.Grid(nx=48, dx=0.0625, x0=-1.375)
    for motion in (vc.Shift(ux=0.04, uy=-0.02), vc.Shift(Fx=-0.05, Fy=0.03)):
        one = vc.solve(scene(bodies=bodies, motion=motion, grid=grid, surface=vc.SampledDistance(h, x, None, DEPTH)))
        surface = vc.SampledDistance(h[::-1], x, None, DEPTH)
        other = vc.solve(scene(bodies=bodies, motion=changed(motion, -1), grid=mirrored, surface=surface))
        back = {name: getattr(other, name)[..., ::-1] for name in ("pressure", "traction", "slip", "state")}
        same(one, dataclasses.replace(other, **back), (-1, 1), tol=1e-8)


def test_rotated_creepage_without_poissons_ratio():
    """For nu = 0 both directions are equally stiff: any direction of creepage gives the turned answer."""
    bodies, v = vc.Bodies(G=1.0, nu=0.0), 0.02
    along = vc.solve(scene(bodies=bodies, motion=vc.Steady(vx=v)))
    for angle in (0.3, 1.2, np.pi / 2, 2.5):
        c, s = np.cos(angle), np.sin(angle)
        turned = vc.solve(scene(bodies=bodies, motion=vc.Steady(vx=v * c, vy=v * s)))
        expected = along.traction[0] * np.array([c, s])[:, None, None]
        np.testing.assert_allclose(turned.traction, expected, atol=1e-10 * along.pressure.max())
        np.testing.assert_array_equal(turned.state, along.state)


def test_nothing_depends_on_the_depth_that_must_not():
    """Forces prescribed, or rolling: all but approach and rigid shift, which differ by the logarithm of the depths."""
    per_force = 2 / np.pi  # by ln(depth), times (1 - nu) in plane strain
    for name in ("creepage", "forces", "force"):
        sols = [vc.solve(scene(motion=MOTIONS[name], surface=vc.Cylinders(5.0, d))) for d in (None, 3.5, 350.0, 3e8)]
        for sol in sols[1:]:
            same(dataclasses.replace(sols[0], approach=sol.approach), sol, tol=1e-9)
        assert np.isnan(sols[0].approach)
    shift = vc.Shift(Fx=-0.05, Fy=0.03)
    sols = [vc.solve(scene(motion=shift, surface=vc.Cylinders(5.0, d)), normal="clarabel") for d in (None, 3.5, 3.5e5)]
    assert np.isnan([sols[0].approach, *sols[0].creepage[:2]]).all()
    for sol in sols[1:]:
        np.testing.assert_allclose(sol.traction, sols[0].traction, atol=1e-10 * sol.pressure.max())
    differ = np.log(1e5) * per_force * np.array([0.72 * 0.5, 0.72 * 0.05, -0.03])
    found = [
        sols[2].approach - sols[1].approach,
        sols[2].creepage[0] - sols[1].creepage[0],
        sols[2].creepage[1] - sols[1].creepage[1],
    ]
    np.testing.assert_allclose(found, differ, rtol=1e-10)


def test_two_strips():
    """Two bumps far apart share the force; each is a Hertzian contact, but for the slope by the other's pressure."""
    x = np.linspace(-6.0, 6.0, 2401)
    surface = vc.SampledDistance((np.abs(x) - 4.0) ** 2 / 10, x)
    grid = vc.Grid(nx=448, dx=0.025, x0=-5.6)
    sol = vc.solve(scene(surface=surface, normal_force=0.5, motion=vc.Steady(Fx=-0.06), grid=grid))
    left, right = sol.pressure[0, :224], sol.pressure[0, 224:]
    np.testing.assert_allclose(left, right[::-1], atol=1e-10 * left.max())
    assert left.sum() * 0.025 == pytest.approx(0.25, rel=1e-9)
    alone = line_contact(5.0, LIKE, force=0.25)
    assert left.max() == pytest.approx(alone.peak_pressure, rel=0.01)
    state = sol.state[0]
    assert np.flatnonzero(np.diff(state > 0)).size == 4
    assert sol.traction[0, 0, :224].sum() != pytest.approx(sol.traction[0, 0, 224:].sum(), rel=1e-3)
    assert not violations(sol, 1e-8)


def test_tractions_of_unlike_bodies_are_seen_outside_the_contact():
    """Without them, samples beside the contact would seem to overlap: in plane strain they count at any distance."""
    x = np.linspace(-3.0, 3.0, 401)
    bodies = vc.Bodies(G=0.5, nu=(0.0, 0.47))
    wide = vc.Grid(nx=48, dx=0.1, x0=-2.4)
    motion = vc.Steady(vx=0.0)
    samples = vc.SampledDistance(x**2 / 2, x)
    free = vc.solve(scene(bodies=bodies, surface=samples, friction=0.17, motion=motion, grid=wide))
    cylinders = scene(bodies=bodies, surface=vc.Cylinders(1.0), friction=0.17, motion=motion, grid=wide)
    same(vc.solve(cylinders), free, tol=1e-8)


def test_friction_by_element():
    """No friction in the middle: no traction there, and two stick or slip areas beside it."""
    grid = vc.Grid(nx=60, dx=0.06, x0=-1.8)
    friction = np.where(np.abs(grid.x) < 0.3, 0.0, 0.25)
    sol = vc.solve(scene(friction=friction, grid=grid, motion=vc.Steady(vx=0.01)), normal="clarabel")
    assert not sol.traction[:, 0, friction == 0].any()
    assert sol.traction[0, 0, friction > 0].min() < 0
    assert not violations(sol, 1e-8)
    uniform = vc.solve(scene(friction=np.full(60, 0.25), grid=grid), normal="clarabel")
    same(uniform, vc.solve(scene(grid=grid), normal="clarabel"))
