"""Friction whose traction bound needs no passes: a shear strength at any pressure, and a field that
rolls along.
"""

import dataclasses

import numpy as np
import pytest

import varcontact as vc

GRID = vc.Grid(nx=16, ny=14)
STEADY = vc.Steady(vx=4e-3, vy=2e-3, spin=3e-3)


def scene(friction, motion=STEADY, **more):
    given = {
        "bodies": vc.Bodies(G=1.0, nu=0.28),
        "surface": vc.Paraboloids(Rx=1.0, Ry=1.3),
        "normal_force": 1e-3,
    }
    return vc.Scene(**given | {"friction": friction, "motion": motion, "grid": GRID} | more)


# ----------------------------------------------------------------------------- a shear strength


def test_without_strength_it_is_coulombs_friction():
    own, coulomb = (vc.solve(scene(each)) for each in (vc.ShearStrength(0.3, 0.0), 0.3))
    np.testing.assert_allclose(
        own.traction, coulomb.traction, atol=1e-14 * np.abs(coulomb.traction).max()
    )
    assert np.isfinite(own.certificate.force_bound).all()


def test_a_large_strength_is_no_slip():
    own, no_slip = (vc.solve(scene(each)) for each in (vc.ShearStrength(0.3, 1e3), np.inf))
    np.testing.assert_allclose(
        own.traction, no_slip.traction, atol=1e-10 * np.abs(no_slip.traction).max()
    )
    assert own.elements["slip"] == 0


@pytest.mark.parametrize("tangential", ["newton", "tang", "clarabel"])
def test_it_is_a_law_by_pressure_without_its_passes(tangential):
    """The same bound as a law's coefficient by pressure; only without a law there is a bound on
    forces.
    """
    peak = scene(0.3).hertz.peak_pressure
    strength = 0.1 * peak

    def adhesive(pressure):
        return np.clip(np.maximum(0.3, strength / np.maximum(pressure, 1e-9 * peak)), 0.0, 100.0)

    law = vc.FrictionLaw(static=100.0, kinetic=0.3, factors=[adhesive])
    known = vc.solve(scene(law), start="slip", tol=1e-11)
    own = vc.solve(scene(vc.ShearStrength(0.3, strength)), tangential=tangential)
    np.testing.assert_allclose(
        own.traction, known.traction, atol=1e-7 * np.abs(known.traction).max()
    )
    assert (
        np.isfinite(own.certificate.force_bound).all()
        and not np.isfinite(known.certificate.force_bound).any()
    )
    assert np.all(
        np.abs(own.force - known.force) <= own.certificate.force_bound[:2] + 1e-7 * own.normal_force
    )


def test_trescas_law_carries_its_strength_times_the_area():
    line = scene(
        vc.ShearStrength(0.0, 1e-3),
        vc.Steady(vx=1.0),
        surface=vc.Cylinders(R=1.0),
        grid=vc.Grid(nx=40),
    )
    found = vc.solve(line)
    area = np.count_nonzero(found.pressure) * found.grid.sides[0]
    assert found.Fx == pytest.approx(-1e-3 * area, rel=1e-12)
    assert found.traction_bound.sum() * found.grid.area == pytest.approx(1e-3 * area, rel=1e-12)


def test_units_do_not_matter():
    peak = scene(0.3).hertz.peak_pressure
    own = vc.solve(scene(vc.ShearStrength(0.2, 0.1 * peak)))
    G = 82e9
    other = vc.solve(
        scene(
            vc.ShearStrength(0.2, 0.1 * peak * G),
            bodies=vc.Bodies(G=G, nu=0.28),
            normal_force=1e-3 * G,
        )
    )
    np.testing.assert_allclose(
        other.traction / G, own.traction, atol=1e-9 * np.abs(own.traction).max()
    )


def test_unlike_bodies_take_it_in_passes():
    unlike = vc.Bodies(G=(1.0, 0.4), nu=(0.28, 0.4))
    own, coulomb = (
        vc.solve(scene(each, bodies=unlike)) for each in (vc.ShearStrength(0.3, 0.0), 0.3)
    )
    np.testing.assert_allclose(
        own.traction, coulomb.traction, atol=1e-6 * np.abs(coulomb.traction).max()
    )


# ------------------------------------------------------------------------- a field that rolls along


ROLLING = vc.Grid(nx=20, ny=10, dx=0.02, dy=0.03, x0=-0.2, y0=-0.15)


def rolling(friction, steps=5, **more):
    return scene(friction, vc.Transient(vx=0.02, dq=0.05, steps=steps, **more), grid=ROLLING)


def patch():
    return vc.CarriedFriction(
        [[0.1, 0.15, 0.1], [0.2, 0.25, 0.2]], [0.0, 0.1, 0.2], y=[-0.2, 0.2], elsewhere=0.4
    )


def test_every_step_is_that_of_the_field_where_it_is_then():
    history = vc.solve(rolling(patch()), certify="full")
    before = None
    for k, step in enumerate(history):
        friction = patch().at_step(ROLLING, 0.05 * (k + 1))
        alone = vc.solve(rolling(friction, steps=1, start=before))
        before = alone[0]
        np.testing.assert_allclose(
            step.traction, before.traction, atol=1e-12 * np.abs(before.traction).max()
        )
        assert np.isfinite(step.certificate.force_bound).all()


def test_a_uniform_field_is_a_number():
    uniform = vc.CarriedFriction([0.3, 0.3], [0.0, 0.1], elsewhere=0.3)
    for own, number in zip(vc.solve(rolling(uniform)), vc.solve(rolling(0.3)), strict=True):
        np.testing.assert_allclose(
            own.traction, number.traction, atol=1e-12 * np.abs(number.traction).max()
        )


def test_less_friction_under_the_contact_carries_less():
    history = vc.solve(rolling(patch(), steps=12))
    full = vc.solve(rolling(0.4, steps=12))
    carried = [abs(own.Fx / other.Fx) for own, other in zip(history, full, strict=True)]
    assert min(carried) < 0.8 and carried[-1] > carried[int(np.argmin(carried))]


# ----------------------------------------------------------------------- files, and what is refused


@pytest.mark.parametrize(
    "made", [scene(vc.ShearStrength(0.3, 1e-4)), rolling(patch())], ids=["strength", "carried"]
)
def test_files_keep_them(made, tmp_path):
    made.save(tmp_path / "scene.toml")
    read, _ = vc.read_scene(tmp_path / "scene.toml")
    for field in dataclasses.fields(made.friction):
        np.testing.assert_array_equal(
            getattr(read.friction, field.name), getattr(made.friction, field.name)
        )
    found = vc.solve(made)
    found.save(tmp_path / "found.nc")
    again = vc.load(tmp_path / "found.nc")
    last, known = (each[-1] if isinstance(each, vc.History) else each for each in (again, found))
    np.testing.assert_allclose(last.traction, known.traction, rtol=1e-14)
    assert last.certificate.residual <= 1e-8


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: vc.ShearStrength(-0.1, 1.0), "friction.coefficient"),
        (lambda: vc.ShearStrength(0.1, np.nan), "friction.strength"),
        (lambda: vc.ShearStrength(0.0, 0.0), "friction.strength"),
        (lambda: vc.CarriedFriction([0.1, -0.1], [0.0, 1.0]), "friction.coefficient[1]"),
        (lambda: vc.CarriedFriction([0.1, 0.1], [0.0, 1.0], elsewhere=-1.0), "friction.elsewhere"),
        (lambda: vc.CarriedFriction([0.1, 0.1], [1.0, 0.0]), "carried.x"),
        (lambda: scene(patch()), "friction"),
    ],
)
def test_what_is_none_is_refused(make, field):
    with pytest.raises(vc.SceneError) as error:
        make()
    assert error.value.field == field
