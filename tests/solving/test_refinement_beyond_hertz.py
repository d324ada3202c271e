"""Defect correction where the pressure is solved for, where friction is no number, and of shifts."""

import dataclasses
import json

import numpy as np
import pytest

import varcontact as vc
from tests.benchmarks.refinement import VALUES, loads, read_references, scene
from varcontact.reference import cattaneo_mindlin
from varcontact.solving.defect_correction.road import _shares


def sampled(scene, cells):
    """A reference scene of sampled gaps on a grid with as many elements across the contact."""
    return dataclasses.replace(scene, grid=vc.Grid(nx=cells, ny=None if scene.line else cells))


def test_too_few_elements_under_samples(rolling):
    """How many lie across the contact is known once the pressure is solved for."""
    sphere = vc.SampledDistance(np.add.outer(np.arange(-8, 9) ** 2, np.arange(-8, 9) ** 2) / 100.0)
    grid = vc.Grid(nx=17, ny=17, dx=1.0, dy=1.0, x0=-8.5, y0=-8.5)
    with pytest.raises(vc.SceneError, match="at least 8 elements across the contact each way; here it has 7 by 7"):
        vc.solve(rolling(surface=sphere, grid=grid), refine="continuum")
    gap = vc.references()["line, two bumps, creepage"].scene
    with pytest.raises(vc.SceneError, match="at least 8 elements across the contact each way; here it has 6"):
        vc.solve(sampled(gap, 6), refine="continuum")


@pytest.mark.parametrize("index", [2, 4, 9])
def test_pressure_solved_for(index):
    """Hertz's contact with its pressure solved for: a fraction of the plain error, within its estimate."""
    case, row = read_references()[index]
    truth = np.array([row[name] for name in VALUES])
    for cells, gain in ((16, 2), (32, 4)):
        plain = np.abs(loads(vc.solve(scene(case, cells), certify=None)) - truth).max()
        found = vc.solve(scene(case, cells), normal="newton", refine="continuum", certify=None)
        error = np.abs(loads(found) - truth).max()
        assert error < plain / gain
        assert error < found.refinement.estimate.max() / 0.3


@pytest.mark.parametrize(
    "name", ["two arcs, spin", "two patches, spin", "egg, near full slip", "line, two bumps, creepage"]
)
def test_sampled_surfaces(name, tmp_path):
    """Pressures that are not Hertz's, on one patch and on two: a twentieth of the plain error and less."""
    known = vc.references()[name]
    posed = sampled(known.scene, 32)
    plain, found = vc.solve(posed, certify=None), vc.solve(posed, refine="continuum")
    errors = {}
    for one, forces in (("plain", [*plain.force, plain.moment]), ("corrected", [*found.force, found.moment])):
        values = zip(VALUES, forces, strict=True)
        errors[one] = max(abs(v - known.values[n]) / known.units[n] for n, v in values if n in known.units)
    assert errors["corrected"] < min(errors["plain"] / 20, 6e-4)
    bar = max(known.bars[name] / unit for name, unit in known.units.items())
    assert errors["corrected"] < max(found.error_estimate.errors.values()) + bar
    assert found.certificate.residual < 1e-8
    found.save(tmp_path / "sampled.nc")
    again = vc.load(tmp_path / "sampled.nc")
    assert again.note == ""
    np.testing.assert_array_equal(again.refinement.share, found.refinement.share)
    assert (found.refinement.share * found.pressure).sum() == pytest.approx(found.pressure.sum(), rel=1e-12)
    np.testing.assert_array_equal(again.force, found.force)


def by_element(a, b, cells, motion):
    """A Hertzian contact whose sides rub differently: 0.35 left of the rolling direction, 0.2 right of it."""
    grid = vc.Grid(nx=cells, ny=cells, margin=0).spread((-a, a, -b, b))
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=a, b=b),
        normal_force=1.0,
        friction=np.where(grid.y[:, None] > 0, 0.35, 0.2) * np.ones(cells),
        motion=motion,
        grid=grid,
    )


def test_friction_by_element_in_full_slip():
    """Each side carries its own coefficient of half the load, with its centre at 3 b / 8."""
    a, b = 1.2, 0.8
    found = vc.solve(by_element(a, b, 10, vc.Steady(vx=1.0)), refine="continuum", certify=None)
    assert found.force[0] == pytest.approx(-(0.35 + 0.2) / 2, rel=1e-4)
    assert found.moment == pytest.approx((0.35 - 0.2) / 2 * 3 * b / 8, rel=1e-2)


def test_elements_without_friction(rolling):
    """Rounding where elements of two grids meet gave the coarser one a friction of 1e-31, which is refused."""
    grid = vc.Grid(nx=24, ny=24, dx=0.1, dy=0.1, x0=-1.2, y0=-1.2)
    x, y = np.meshgrid(grid.x, grid.y)
    posed = rolling(
        surface=vc.Ellipse(a=1.0, b=1.0),
        friction=np.where(x**2 + y**2 < 0.1, 0.0, 0.3),
        motion=vc.Steady(vx=0.1),
        grid=grid,
    )
    sol = vc.solve(posed, refine="continuum", certify=None)
    fine = vc.solve(dataclasses.replace(posed, friction=0.3), refine="continuum", certify=None)
    assert abs(sol.force[0]) < 0.95 * abs(fine.force[0])
    assert sol.refinement.estimate[0] < 0.02 * abs(sol.force[0])


def test_friction_by_element():
    """An eighth of the plain error and less; in a mirror the same; with one coefficient that of a number."""
    motion = vc.Steady(vx=0.03, vy=-0.03, spin=0.06)

    def three(one):
        return np.array([*one.force, one.moment]) / 0.275

    truth = three(vc.solve(by_element(1.2, 0.8, 64, motion), refine="continuum", certify=None))
    plain = vc.solve(by_element(1.2, 0.8, 16, motion), certify=None)
    found = vc.solve(by_element(1.2, 0.8, 16, motion), refine="continuum", certify=None)
    error = np.abs(three(found) - truth).max()
    assert error < np.abs(three(plain) - truth).max() / 7
    assert error < found.refinement.estimate.max() / 0.275
    posed = by_element(1.2, 0.8, 16, vc.Steady(vx=0.03, vy=0.03, spin=-0.06))
    turned = vc.solve(
        dataclasses.replace(posed, friction=posed.friction[::-1].copy()), refine="continuum", certify=None
    )
    np.testing.assert_allclose(three(turned), three(found) * [1, -1, -1], atol=1e-6)
    even = dataclasses.replace(posed, friction=np.full(posed.grid.shape, 0.3))
    number = dataclasses.replace(posed, friction=0.3)
    forces = [three(vc.solve(each, refine="continuum", certify=None)) for each in (even, number)]
    np.testing.assert_allclose(*forces, rtol=1e-10)


def three(one):
    """Fx, Fy and Mz by the static limit."""
    return np.array([*one.force, one.moment]) / 0.3


@pytest.mark.parametrize(
    "law",
    [
        vc.LinearFalling(static=0.3, kinetic=0.2, half_velocity=0.08),
        vc.ExponentialFalling(static=0.3, kinetic=0.22, half_velocity=0.05),
        vc.StaticKinetic(0.3, 0.25),
    ],
)
def test_laws_of_friction(law, rolling, tmp_path):
    """A tenth of the plain error, within the estimate; the truth is extrapolated from plain grids."""
    posed = rolling(friction=law, motion=vc.Steady(vx=0.05, vy=-0.02, spin=0.05), grid=vc.Grid(nx=16, ny=16))
    coarse, fine = (
        three(vc.solve(dataclasses.replace(posed, grid=vc.Grid(nx=n, ny=n, edge="touched")), certify=None))
        for n in (48, 96)
    )
    plain, found = vc.solve(posed, certify=None), vc.solve(posed, refine="continuum")
    error = np.abs(three(found) - (2 * fine - coarse)).max()
    assert error < np.abs(three(plain) - (2 * fine - coarse)).max() / 8
    assert error < max(found.error_estimate.errors.values())
    assert found.certificate.residual < 1e-8
    found.save(tmp_path / "law.nc")
    again = vc.load(tmp_path / "law.nc")
    assert again.note == ""
    np.testing.assert_array_equal(again.force, found.force)


def test_kinetic_friction_in_full_slip(rolling):
    """All parts have the kinetic coefficient, those of elements beyond the contact, too."""
    posed = rolling(friction=vc.StaticKinetic(0.3, 0.24), motion=vc.Steady(vx=50.0))
    found = vc.solve(posed, refine="continuum", certify=None)
    np.testing.assert_allclose(found.force, [-0.24, 0], atol=1e-8)


def test_start_under_a_law(rolling):
    """Of two solutions the one that is asked for; a start on one grid is refused, for the estimate takes another."""
    posed = rolling(friction=vc.StaticKinetic(0.3, 0.1), motion=vc.Steady(vx=0.05))
    stick, slip = (vc.solve(posed, refine="continuum", certify=None, start=start) for start in ("stick", "slip"))
    assert abs(slip.force[0]) < 0.99 * abs(stick.force[0])
    with pytest.raises(vc.SceneError, match='takes half as many elements, on which no start is known; give start = "'):
        vc.solve(posed, refine="continuum", start=stick)


def test_cattaneo_and_mindlin(rolling):
    """Spheres with nu = 0 in closed form: a third of the plain error and less, of second order."""
    bodies = vc.Bodies(G=1.0, nu=0.0)
    posed = rolling(bodies=bodies, surface=vc.Ellipse(a=1.0, b=1.0))
    for part in (0.4, 0.8):
        known = cattaneo_mindlin(posed.hertz, bodies, friction=0.3, force=-0.3 * part)
        shifted = dataclasses.replace(posed, motion=vc.Shift(ux=known.shift))
        errors = []
        for cells in (16, 32, 64):
            one = dataclasses.replace(shifted, grid=vc.Grid(nx=cells, ny=cells))
            plain, found = (vc.solve(one, refine=refine, certify=None) for refine in (None, "continuum"))
            errors.append([abs(sol.force[0] / 0.3 + part) for sol in (plain, found)])
        before, after = np.array(errors).T
        assert np.all(after[:2] < before[:2] / 3)
        assert np.all(after < [5e-4, 1.5e-4, 6e-5])


@pytest.mark.parametrize("count", [12, 16, 32])
def test_shifts_of_cylinders(count):
    """Nearer than plain strips; the truth is on two thousand."""
    posed = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.25),
        surface=vc.Cylinders(1.0, reference_depth=5.0),
        normal_force=0.01,
        friction=0.3,
        motion=vc.Shift(ux=0.002),
        grid=vc.Grid(nx=count),
    )
    truth = vc.solve(dataclasses.replace(posed, grid=vc.Grid(nx=2048)), certify=None).force[0]
    plain, found = vc.solve(posed, certify=None), vc.solve(posed, refine="continuum", certify=None)
    assert abs(found.force[0] - truth) < 0.6 * abs(plain.force[0] - truth)
    assert abs(found.force[0] - truth) < found.refinement.estimate[0]


def test_shift_with_a_force_given(rolling, tmp_path):
    """The shift is found as well as the force was; slip is a length; the file has all of it."""
    given = vc.Shift(ux=0.05, uy=-0.03, rotation=0.04)
    grids = [vc.Grid(nx=cells, ny=cells, edge="touched") for cells in (96, 48)]
    fine, coarse = (three(vc.solve(rolling(motion=given, grid=grid), certify=None)) for grid in grids)
    truth = 2 * fine - coarse
    motion = vc.Shift(Fx=0.3 * truth[0], uy=-0.03, rotation=0.04)
    posed = rolling(motion=motion, grid=vc.Grid(nx=16, ny=16))
    plain, found = vc.solve(posed), vc.solve(posed, refine="continuum")
    assert abs(found.creepage[0] - 0.05) < abs(plain.creepage[0] - 0.05) / 3
    assert np.abs(three(found) - truth).max() < np.abs(three(plain) - truth).max() / 3
    assert set(found.error_estimate.errors) == {"ux", "Fy", "Mz"}
    assert found.certificate.residual < 1e-8
    assert found.friction_work == pytest.approx(plain.friction_work, rel=0.02)
    stick = np.repeat(np.repeat(found.state == 1, 2, axis=0), 2, axis=1)
    assert np.abs(found.refinement.slip[:, stick]).max() < 0.1 * np.abs(found.refinement.slip).max()
    found.save(tmp_path / "shift.nc")
    again = vc.load(tmp_path / "shift.nc")
    assert again.note == ""
    assert again.report() == found.report()
    assert again.to_xarray()["slip_on_parts"].attrs["units"] == again.to_xarray()["slip"].attrs["units"] == "length"


def test_shares_keep_means():
    """Coefficients of coarser elements are means by overlap; beyond the given ones the nearest hold."""
    shares = _shares(np.array([-0.5, 1.0, 2.5, 4.5]), np.array([0.0, 1.0, 2.0, 3.0, 4.0]))
    np.testing.assert_allclose(shares, [[1, 0, 0, 0], [0, 2 / 3, 1 / 3, 0], [0, 0, 0.25, 0.75]], atol=1e-15)


X = np.linspace(-1.0, 1.0, 161)


def cylinders(depth, motion, cells=32, sampled=False):
    """Line contact, with displacements that count from a depth or are known but for a constant."""
    surface = vc.SampledDistance(X**2 / 2, X, reference_depth=depth) if sampled else vc.Cylinders(1.0, depth)
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.25),
        surface=surface,
        normal_force=0.05,
        friction=0.3,
        motion=motion,
        grid=vc.Grid(nx=cells),
    )


@pytest.mark.parametrize("sampled", [False, True])
@pytest.mark.parametrize("motion", [vc.Shift(Fx=0.01), vc.Shift(Fx=0.004, Fy=-0.006), vc.Shift(Fy=0.01, ux=0.0)])
def test_shifts_that_are_known_but_for_a_constant(motion, sampled, tmp_path):
    """Without a reference depth they have no value, but the same error as with one; nothing is claimed to be exact."""
    free, deep = (
        vc.solve(cylinders(depth, motion, sampled=sampled), refine="continuum", certify=None) for depth in (None, 5.0)
    )
    given = [name for name, force in (("ux", motion.Fx), ("uy", motion.Fy)) if force is not None]
    found, known = free.error_estimate, deep.error_estimate
    for name in given:
        assert name not in found.values
        assert name in known.values
        assert found.errors[name] == pytest.approx(known.errors[name], rel=1e-3, abs=1e-9)
        assert found.errors[name] > 1e-7
    assert f"without surface.reference_depth {' and '.join(given)} counts from a depth" in found.how
    assert "reference_depth" not in known.how
    assert all(f"{name} to {found.errors[name]:.1e}" in free.report() for name in given)
    free.save(tmp_path / "free.nc")
    again = vc.load(tmp_path / "free.nc")
    assert again.note == ""
    assert again.error_estimate == found
    json.dumps(free.summary(), allow_nan=False)


def test_the_error_of_such_a_shift():
    """Below its estimate: measured from a depth, which changes all shifts under a force by the same."""
    fine, coarse = (vc.solve(cylinders(5.0, vc.Shift(Fx=0.01), n), refine="continuum", certify=None) for n in (512, 16))
    free = vc.solve(cylinders(None, vc.Shift(Fx=0.01), 16), refine="continuum", certify=None)
    saturation = 4 * 0.75 * 0.015 / np.pi  # times a by a
    error = abs(coarse.creepage[0] - fine.creepage[0]) / saturation
    assert error < free.error_estimate.errors["ux"] < 100 * error


def test_steps_whose_shifts_are_known_but_for_a_constant():
    """In a history, too: steps that change the force."""
    motion = vc.Transient(steps=3, dq=[0.0, 0.05, 0.05], Fx=[0.005, 0.008, 0.008])
    free, deep = (vc.solve(cylinders(depth, motion), refine="continuum", certify=None) for depth in (None, 5.0))
    for one, other in zip(free, deep, strict=True):
        assert set(one.error_estimate.errors) == set(other.error_estimate.errors)
        for name, error in other.error_estimate.errors.items():
            assert one.error_estimate.errors[name] == pytest.approx(error, rel=1e-2, abs=1e-8)
    assert all(np.isnan(one.creepage[0]) and "reference_depth" in one.error_estimate.how for one in free[:2])
