"""What must not change, or only its sign, and Kalker's conditions on random scenes."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene

LIKE, UNLIKE = vc.Bodies(G=1.0, nu=0.28), vc.Bodies(G=(1.0, 3.0), nu=(0.2, 0.4))
DEPTH = 30.0
MOTIONS = {
    "creepage": vc.Steady(vx=0.02, vy=-0.01),
    "force": vc.Steady(Fx=-0.06, vy=0.005),
    "forces": vc.Steady(Fx=0.05, Fy=0.05),
    "shift": vc.Shift(ux=0.05, uy=-0.02),
    "shift by force": vc.Shift(Fx=-0.05, uy=0.01),
}

BASE = make_scene(
    vc.Cylinders(5.0, DEPTH), 0.5, MOTIONS["creepage"], vc.Grid(nx=40), friction=0.25, bodies=LIKE
)


def scene(**changes):
    return dataclasses.replace(BASE, **changes)


def same(first, second, signs=(1, 1), tol=1e-10):
    """Pressures, tractions, slip, forces and creepages agree but for the signs of the tangential
    components.
    """
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
    factors = {
        "vx": along_x,
        "ux": along_x,
        "Fx": along_x,
        "vy": along_y,
        "uy": along_y,
        "Fy": along_y,
    }
    given = {name: getattr(motion, name, None) for name in factors}
    return dataclasses.replace(
        motion, **{k: v * factors[k] for k, v in given.items() if v is not None}
    )


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_signs(motion):
    """Motion and forces reversed in either direction: so are the tractions. Like bodies both ways,
    unlike ones in y.
    """
    for bodies, x, y in ((LIKE, -1, 1), (LIKE, -1, -1), (LIKE, 1, -1), (UNLIKE, 1, -1)):
        one, other = (
            vc.solve(scene(bodies=bodies, motion=m)) for m in (motion, changed(motion, x, y))
        )
        same(one, other, (x, y))


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_exchange_of_unlike_bodies(motion):
    """The constants exchanged and the motion along x reversed: only traction and slip along x
    change, their sign.
    """
    swapped = vc.Bodies(G=UNLIKE.G[::-1], nu=UNLIKE.nu[::-1])
    assert swapped.K == pytest.approx(-UNLIKE.K, rel=1e-14)
    one = vc.solve(scene(bodies=UNLIKE, motion=motion))
    assert one.plan.coupling == "active-set"
    same(one, vc.solve(scene(bodies=swapped, motion=changed(motion, -1))), (-1, 1), tol=1e-8)


@pytest.mark.parametrize("bodies", [LIKE, UNLIKE], ids=["like", "unlike"])
def test_mirror_of_a_shift(bodies):
    """x to -x, in a contact without symmetry of its own: pressures are mirrored, tractions along x
    change sign, too.
    """
    x = np.linspace(-3.0, 3.0, 301)
    h = x**2 / 3 + 0.01 * np.sin(3 * x) + 0.02 * x**3
    grid = vc.Grid(nx=48, dx=0.0625, x0=-1.625)
    mirrored = vc.Grid(nx=48, dx=0.0625, x0=-1.375)
    for motion in (vc.Shift(ux=0.04, uy=-0.02), vc.Shift(Fx=-0.05, Fy=0.03)):
        one = vc.solve(
            scene(
                bodies=bodies,
                motion=motion,
                grid=grid,
                surface=vc.SampledDistance(h, x, None, DEPTH),
            )
        )
        surface = vc.SampledDistance(h[::-1], x, None, DEPTH)
        other = vc.solve(
            scene(bodies=bodies, motion=changed(motion, -1), grid=mirrored, surface=surface)
        )
        back = {
            name: getattr(other, name)[..., ::-1]
            for name in ("pressure", "traction", "slip", "state")
        }
        same(one, dataclasses.replace(other, **back), (-1, 1), tol=1e-8)


def test_rotated_creepage_without_poissons_ratio():
    """For nu = 0 both directions are equally stiff: any direction of creepage gives the turned
    answer.
    """
    bodies, v = vc.Bodies(G=1.0, nu=0.0), 0.02
    along = vc.solve(scene(bodies=bodies, motion=vc.Steady(vx=v)))
    for angle in (0.3, 1.2, np.pi / 2, 2.5):
        c, s = np.cos(angle), np.sin(angle)
        turned = vc.solve(scene(bodies=bodies, motion=vc.Steady(vx=v * c, vy=v * s)))
        expected = along.traction[0] * np.array([c, s])[:, None, None]
        np.testing.assert_allclose(turned.traction, expected, atol=1e-10 * along.pressure.max())
        np.testing.assert_array_equal(turned.state, along.state)


def test_nothing_depends_on_the_depth_that_must_not():
    """Forces prescribed, or rolling: all but approach and rigid shift, which differ by the
    logarithm of the depths.
    """
    per_force = 2 / np.pi  # by ln(depth), times (1 - nu) in plane strain
    for name in ("creepage", "forces", "force"):
        sols = [
            vc.solve(scene(motion=MOTIONS[name], surface=vc.Cylinders(5.0, d)))
            for d in (None, 3.5, 350.0, 3e8)
        ]
        for sol in sols[1:]:
            same(dataclasses.replace(sols[0], approach=sol.approach), sol, tol=1e-9)
        assert np.isnan(sols[0].approach)
    shift = vc.Shift(Fx=-0.05, Fy=0.03)
    sols = [
        vc.solve(scene(motion=shift, surface=vc.Cylinders(5.0, d)), normal="clarabel")
        for d in (None, 3.5, 3.5e5)
    ]
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


def test_tractions_of_unlike_bodies_are_seen_outside_the_contact():
    """Without them, samples beside the contact would seem to overlap: in plane strain they count at
    any distance.
    """
    x = np.linspace(-3.0, 3.0, 401)
    bodies = vc.Bodies(G=0.5, nu=(0.0, 0.47))
    wide = vc.Grid(nx=48, dx=0.1, x0=-2.4)
    motion = vc.Steady(vx=0.0)
    samples = vc.SampledDistance(x**2 / 2, x)
    free = vc.solve(scene(bodies=bodies, surface=samples, friction=0.17, motion=motion, grid=wide))
    cylinders = scene(
        bodies=bodies, surface=vc.Cylinders(1.0), friction=0.17, motion=motion, grid=wide
    )
    same(vc.solve(cylinders), free, tol=1e-8)
