"""The theories as methods of `solve`: against their own functions, and as solutions like any
others.
"""

import dataclasses
import pickle

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.elasticity.operators import GridOperator
from varcontact.reference.creepage_coefficients import creepage_coefficients
from varcontact.theories import (
    fastsim,
    fastsim_on_grid,
    flexibilities,
    flexibility,
    vermeulen_johnson,
)
from varcontact.theories.on_grid import DIRECT_ELEMENTS, IN_TIME, why_not
from varcontact.theories.on_grid import THEORIES as EVERY

STEADY = vc.Steady(vx=0.04, vy=-0.02, spin=0.05)
FASTSIM = ["fastsim", "fastsim-elliptic", "fastsim-weighted", "fastsim-weighted-elliptic"]
WITHOUT_FLEXIBILITY = ["vermeulen-johnson", "strip", "fastrip", "polach"]
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
FOUR = vc.Grid(nx=4, ny=4, dx=0.5, dy=0.5, x0=-1.0, y0=-1.0)


def contact(scene):
    """What the functions of the theories want, from a scene."""
    hertz = scene.hertz
    table = creepage_coefficients(hertz.a, hertz.b, scene.bodies.combined_nu)
    return (hertz.a, hertz.b, scene.bodies.combined_G, scene.friction * hertz.force), table


def options_of(name):
    """What the function `fastsim` is told for a method by its name."""
    return {
        "bound": "elliptic" if "elliptic" in name else "parabolic",
        "flexibility": "weighted" if "weighted" in name else "separate",
    }


@pytest.mark.parametrize(
    ("name", "motion"),
    [
        *((name, STEADY) for name in FASTSIM),
        (FASTSIM[0], vc.Steady(vx=0.1)),
        (FASTSIM[2], vc.Steady(spin=0.2)),
    ],
)
def test_fastsim_on_the_grid_tends_to_fastsim(rolling, name, motion):
    (a, b, G, limit), table = contact(rolling())
    exact = fastsim(a, b, G, limit, motion.rigid, table, m=400, n=400, **options_of(name)).force
    errors = []
    for cells in (10, 20, 40, 80):
        sol = vc.solve(rolling(motion=motion, grid=vc.Grid(nx=cells, ny=cells)), tangential=name)
        assert sol.plan.tangential == name
        errors.append(np.hypot(*(sol.force - exact)) / limit)
    assert errors[0] < 0.08
    assert errors[-1] < 0.01
    assert errors[-1] < 0.5 * errors[0], errors


# beyond Kalker's table
SLENDER = {"bodies": vc.Bodies(G=1.0, nu=0.0), "surface": vc.Ellipse(12.0, 1.0)}


@pytest.mark.parametrize("changes", [
    {"motion": vc.Steady(vx=0.02, vy=-0.05)},
    {"motion": vc.Steady(vx=-0.4)},
    {"motion": vc.Steady(vx=3.0, vy=4.0)},
    {"motion": vc.Steady(vx=0.01), **SLENDER},
])  # fmt: skip
def test_vermeulen_johnson_gives_exactly_its_force(rolling, changes):
    scene = rolling(**changes)
    args, table = contact(scene)
    sol = vc.solve(scene, tangential="vermeulen-johnson")
    expected = vermeulen_johnson(*args, scene.motion.rigid, table)
    np.testing.assert_allclose(sol.force, expected, rtol=1e-12, atol=1e-14)


def test_what_is_read_multiplies_by_each_matrix_once(rolling, monkeypatch):
    """Pressure and tractions of a theory need no product. Slip and work share theirs: of the
    tractions, and of their mirror image; the distance has that of the pressure.
    """
    scene = rolling(grid=vc.Grid(nx=14, ny=14))
    first = vc.solve(scene, tangential="fastsim")
    read = "force", "slip", "power_density", "distance", "slip"
    known = [getattr(first, name) for name in read]
    products = []
    product = GridOperator._product
    monkeypatch.setattr(
        GridOperator, "_product", lambda *given: products.append(1) or product(*given)
    )
    second = vc.solve(scene, tangential="fastsim")
    numbers = [len(products)]
    for name, expected in zip(read, known, strict=True):
        np.testing.assert_array_equal(getattr(second, name), expected)
        numbers.append(len(products))
    assert numbers == [0, 0, 1, 2, 3, 3]
    assert second.certificate.gap == first.certificate.gap


def test_certificates_of_theories_are_computed_when_they_are_read(rolling, tmp_path):
    """Copies, files and reports have what `certify="full"` computes at once; Polach's no moment."""
    for name in ("fastsim", "polach"):
        lazily = vc.solve(rolling(), tangential=name)
        at_once = vc.solve(rolling(), tangential=name, certify="full")
        assert callable(vars(lazily)["certificate"])
        assert not callable(vars(at_once)["certificate"])
        pickled = pickle.loads(pickle.dumps(lazily))
        lazily.save(tmp_path / f"{name}.nc")
        loaded = vc.load(tmp_path / f"{name}.nc", certify=False)
        for each in (dataclasses.replace(lazily, note="a copy"), pickled, loaded, lazily):
            np.testing.assert_equal(each.certificate.plain(), at_once.certificate.plain())
        assert not callable(vars(lazily)["certificate"])
        assert repr(lazily.certificate) == repr(at_once.certificate)
        assert f"residual {at_once.certificate.residual:.1e}" in lazily.report()


def test_linear_is_infinite_friction(rolling):
    for motion in (STEADY, vc.Steady(Fx=-0.1, vy=0.02)):
        linear = vc.solve(rolling(motion=motion), tangential="linear")
        sticking = vc.solve(rolling(motion=motion, friction=np.inf))
        np.testing.assert_allclose(linear.force, sticking.force, rtol=1e-12)
        np.testing.assert_allclose(linear.traction, sticking.traction, rtol=1e-11, atol=1e-13)
        assert linear.creepage == pytest.approx(sticking.creepage, rel=1e-12)
        assert linear.elements["slip"] == 0
        assert linear.certificate.tangential_residual > 1e-2, (
            "beyond the bound, and the certificate says so"
        )


@pytest.mark.parametrize("motion", [
    vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
    vc.Steady(Fx=-0.1, vy=0.01, spin=0.05),
    vc.Steady(vx=0.02, vy=0.01, dq=1e-3),
])  # fmt: skip
@pytest.mark.parametrize("edge", ["centres", "softened"])
def test_the_linear_theory_of_many_elements_is_that_of_the_dense_matrix(rolling, motion, edge):
    """Without a matrix, but in steps of rolling that are short: there by it, to the bit."""
    scene = rolling(motion=motion, grid=vc.Grid(nx=18, ny=17, edge=edge))
    linear = vc.solve(scene, tangential="linear")
    assert linear.elements["contact"] > DIRECT_ELEMENTS
    without_slip = dataclasses.replace(scene, friction=np.inf)
    exact = vc.solve(without_slip, tangential="tang-safeguarded")
    assert exact.plan.tangential == "no-slip"
    largest = np.abs(exact.traction).max()
    assert np.abs(linear.traction - exact.traction).max() < 1e-10 * largest
    assert linear.creepage == pytest.approx(exact.creepage, abs=1e-12)


@pytest.mark.parametrize("name", [*FASTSIM, "linear", *WITHOUT_FLEXIBILITY])
@pytest.mark.parametrize(
    "motion",
    [
        vc.Steady(Fx=-0.1),
        vc.Steady(Fy=0.15),
        vc.Steady(Fx=-0.2, Fy=0.1),
        vc.Steady(Fx=-0.1, vy=0.01),
    ],
)
def test_prescribed_forces_are_met(rolling, name, motion):
    sol = vc.solve(rolling(motion=motion), tangential=name)
    for force, asked in zip(sol.force, (motion.Fx, motion.Fy), strict=True):
        if asked is not None:
            assert force == pytest.approx(asked, rel=1e-9)
    vx, vy, spin = sol.creepage
    again = vc.solve(rolling(motion=vc.Steady(vx=vx, vy=vy, spin=spin)), tangential=name)
    np.testing.assert_allclose(again.force, sol.force, atol=1e-9)


@pytest.mark.parametrize("name", [*FASTSIM, *WITHOUT_FLEXIBILITY])
def test_more_than_friction_carries_is_refused(rolling, name):
    with pytest.raises(vc.Saturated):
        vc.solve(rolling(motion=vc.Steady(Fx=-0.3001)), tangential=name)


@pytest.mark.parametrize("name", [*FASTSIM, "vermeulen-johnson"])
def test_full_slip(rolling, name):
    """Only one flexibility turns the force against the creepage; else it has the direction of the
    linear theory's.
    """
    sol = vc.solve(rolling(motion=vc.Steady(vx=300.0, vy=-400.0)), tangential=name)
    against = np.array([-0.18, 0.24])
    if "weighted" not in name:
        table = contact(rolling())[1]
        against *= (table.C11, table.C22)
        against *= 0.3 / np.hypot(*against)
    np.testing.assert_allclose(sol.force, against, rtol=1e-9)
    assert sol.elements["stick"] == 0


@pytest.mark.parametrize("name", ["fastsim-elliptic", "vermeulen-johnson"])
def test_tractions_are_admissible_and_the_certificate_tells_the_rest(rolling, name):
    scene = rolling(motion=vc.Steady(vx=0.04, vy=-0.02))
    sol, exact = vc.solve(scene, tangential=name), vc.solve(scene)
    assert sol.converged, "as posed: a theory has no tolerance"
    assert sol.certificate.residual > 1e-3
    assert sol.certificate.relative_gap > 100 * exact.certificate.relative_gap
    assert np.all(np.abs(sol.force - exact.force) <= sol.certificate.force_bound[:2]), (
        "the bound holds"
    )
    if name == "fastsim-elliptic":
        assert np.all(np.hypot(*sol.traction) <= sol.traction_bound * (1 + 1e-12))


@pytest.mark.parametrize("name", EVERY)
@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"bodies": UNLIKE}, "quasi-identical bodies"),
        ({"surface": vc.SampledDistance(np.zeros((4, 4))), "grid": FOUR}, "elliptic contacts"),
    ],
)
def test_scenes_that_they_cannot_treat(rolling, name, changes, words):
    refused(lambda: vc.solve(rolling(**changes), tangential=name), "tangential", match=words)


@pytest.mark.parametrize("name", sorted(set(EVERY) - set(IN_TIME)))
def test_shifts_are_for_fastsim_alone(rolling, name):
    scene = rolling(motion=vc.Shift(ux=0.1))
    refused(lambda: vc.solve(scene, tangential=name), "tangential", match="steady rolling")


def test_more_that_they_cannot_treat(rolling):
    with pytest.raises(vc.SceneError, match=r"without spin, and spin is 0\.05"):
        vc.solve(rolling(), tangential="vermeulen-johnson")
    for name in FASTSIM:
        with pytest.raises(vc.SceneError, match="creepages are needed, not forces"):
            vc.solve(
                rolling(friction=vc.StaticKinetic(0.3, 0.2), motion=vc.Steady(Fx=-0.1)),
                tangential=name,
            )
    for name in (*FASTSIM, "vermeulen-johnson"):
        with pytest.raises(vc.SceneError, match="one finite coefficient of friction"):
            vc.solve(rolling(friction=np.inf, motion=vc.Steady(vx=0.1)), tangential=name)


@pytest.mark.parametrize("name", FASTSIM)
@pytest.mark.parametrize("nu", [0.0, -0.9])
def test_fastsim_of_slender_contacts(rolling, name, nu):
    """Beyond the ratios of Kalker's table, also where nu = 0 and nothing couples: as on the grid by
    hand.
    """
    bodies, motion, grid = (
        vc.Bodies(G=1.0, nu=nu),
        vc.Steady(vx=1.2e-3, vy=6e-4, spin=2e-4),
        vc.Grid(nx=24, ny=8),
    )
    sol = vc.solve(
        rolling(bodies=bodies, surface=vc.Ellipse(12.0, 1.0), motion=motion, grid=grid),
        tangential=name,
    )
    table = vc.no_slip_coefficients(12.0, nu)
    L = flexibilities(12.0, 1.0, 1.0, table)
    if "weighted" in name:
        L = float(flexibility(12.0, 1.0, 1.0, motion.rigid, table))
    x, y = np.meshgrid(sol.grid.x, sol.grid.y)
    bound = np.maximum(1 - (x / 12) ** 2 - y**2, 0.0)
    bound *= 0.3 / (bound.sum() * sol.grid.area)
    if "elliptic" in name:
        bound = sol.traction_bound
    traction = fastsim_on_grid(sol.grid, 12.0, 1.0, L, bound, motion.rigid)
    np.testing.assert_allclose(sol.traction, traction, atol=1e-12 * bound.max())
    assert sol.elements["stick"] > 5 and sol.elements["slip"] > 5


@pytest.mark.parametrize("name", FASTSIM)
def test_fastsim_cannot_be_fitted_to_a_negative_coefficient(rolling, name):
    """In a wide contact with nu = -0.9, C23 < 0: no flexibility is right for spin; without spin
    nothing is amiss.
    """
    wide = {"bodies": vc.Bodies(G=1.0, nu=-0.9), "surface": vc.Ellipse(0.1, 10.0)}
    with pytest.raises(
        vc.SceneError, match=r"C23 = -0\.063.* not allowed: must be positive.*take an exact method"
    ):
        vc.solve(rolling(**wide, motion=vc.Steady(vx=0.04, spin=0.01)), tangential=name)
    sol = vc.solve(rolling(**wide, motion=vc.Steady(vx=300.0)), tangential=name)
    np.testing.assert_allclose(sol.force, [-0.3, 0.0], atol=1e-9)


@pytest.mark.parametrize("name", FASTSIM)
def test_fastsim_beyond_saturation_with_the_approach_given(rolling, name):
    hertz = rolling().hertz
    scene = rolling(
        surface=vc.Paraboloids(hertz.Rx, hertz.Ry), normal_force=None, approach=hertz.approach,
        motion=vc.Steady(Fx=-1.001 * rolling().friction * hertz.force),
    )  # fmt: skip
    with pytest.raises(vc.Saturated, match="cannot be carried"):
        vc.solve(scene, tangential=name)


def quantities(found):
    """Fx, Fy and Mz, of a solution or of `creep_forces`, in parts of f Fz and of f Fz sqrt(ab)."""
    return np.array([found.Fx, found.Fy, found.Mz])


@pytest.mark.parametrize("name", EVERY)
def test_signs_over_the_bank_are_those_of_the_exact_theory(name):
    """Of all that the theory has; what it does not have is NaN by `solve` and by `creep_forces`
    alike.
    """
    seen = 0
    for label, scene in vc.standard_bank().items():
        if why_not(name, scene):
            continue
        exact = vc.solve(
            dataclasses.replace(scene, friction=np.inf) if name == "linear" else scene, certify=None
        )
        sol = vc.solve(scene, tangential=name, certify=None)
        a, b, limit = scene.hertz.a, scene.hertz.b, scene.friction * scene.normal_force
        vx, vy, spin = sol.creepage
        contact = {
            "a": a,
            "b": b,
            "bodies": scene.bodies,
            "normal_force": scene.normal_force,
            "friction": 0.3,
        }
        by_formula = vc.creep_forces(name, **contact, vx=vx, vy=vy, spin=spin)
        expected = quantities(exact) / (limit * np.array([1.0, 1.0, np.sqrt(a * b)]))
        counts = np.abs(expected) > (1e-3 if label.startswith("pure") else 0.2)
        for found in (sol, by_formula):
            has = ~np.isnan(quantities(found))
            np.testing.assert_array_equal(has, [True, True, name != "polach"])
            along = quantities(found)[has & counts] * np.sign(expected[has & counts])
            # strips in pure spin: no force at all
            assert np.all(along > -1e-9), (label, quantities(found), expected)
            seen += np.count_nonzero(has & counts)
    assert seen >= (10 if name == "vermeulen-johnson" else 25)


def test_what_a_theory_without_a_moment_has(rolling, tmp_path):
    """Neither a moment nor what follows from it, in no table, file, report or picture; all else is
    finite.
    """
    sol = vc.solve(rolling(), tangential="polach")
    sol.save(tmp_path / "polach.nc")
    again = vc.load(tmp_path / "polach.nc")
    assert again.note == ""
    for each in (
        sol,
        again,
        vc.scan(rolling(), [STEADY.rigid], tangential="polach", certify="full")[0],
    ):
        assert np.isnan([each.moment, each.normalised.Mz, each.power, each.friction_work]).all()
        np.testing.assert_array_equal(np.isnan(each.certificate.force_bound), [False, False, True])
        assert np.isfinite(each.traction).all()
        summary = each.summary()
        assert [summary[name] for name in ("moment", "power", "friction_work")] == [None] * 3
        assert "twisting moment   none by polach\n" in each.report()
        assert "guaranteed bounds on this grid" in each.report() and "Mz" not in each.report()
    row = vc.compare(rolling(), ["newton", "polach"]).iloc[1]
    assert np.isnan(row["Mz"]) and np.isfinite(row["force_distance"])
    swept = vc.sweep(rolling(), {"motion.vx": [0.04]}, tangential="polach", certify="full")
    assert np.isnan([swept.Mz.item(), swept.Mz_bound.item()]).all()
    with pytest.raises(vc.SceneError, match=r"what = 'power_density' .*polach has no moment"):
        sol.plot("power_density")
