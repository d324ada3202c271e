"""Defect correction: the continuum's forces from coarse grids, against closed forms and references."""

import dataclasses
import json

import numpy as np
import pytest

import varcontact as vc
from tests.benchmarks.refinement import VALUES, cases, loads, read_references, scene
from tests.command import run
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.subgrid import means
from varcontact.elasticity.ellipsoidal import ellipsoidal_gradients, rooted_gradients, sloped_gradients
from varcontact.reference import carter, line_contact
from varcontact.reference.no_slip_ellipse import no_slip_ellipse
from varcontact.solving.defect_correction.field import Shape, held_behind, interpolated, reconstructed
from varcontact.solving.defect_correction.parts import Parts
from varcontact.solving.defect_correction.passes import Corrected, extrapolated
from varcontact.solving.defect_correction.rooted import root_means

STEEL = vc.Bodies(G=1.0, nu=0.25)


def corrected(case, cells):
    """A reference case, corrected."""
    return vc.solve(scene(case, cells), refine="continuum", certify=None)


@pytest.fixture(scope="module")
def sol(rolling):
    """One corrected solution."""
    return vc.solve(rolling(), refine="continuum")


def test_carter():
    """Steady rolling of cylinders in closed form: a hundredth of the error of plain strips, and above first order."""
    contact = line_contact(2.0, STEEL, a=0.01)
    limit, cells = 0.3 * contact.force, (16, 32, 64, 128, 256)
    for part in (0.2, 0.5, 0.8):
        creepage = carter(contact, 0.3, force=-part * limit).creepage
        errors = []
        for count in cells:
            posed = vc.Scene(
                bodies=STEEL,
                surface=vc.Cylinders(R=2.0),
                normal_force=contact.force,
                friction=0.3,
                motion=vc.Steady(vx=creepage),
                grid=vc.Grid(nx=count),
            )
            plain, found = vc.solve(posed, certify=None), vc.solve(posed, refine="continuum", certify=None)
            errors.append([abs(one.force[0] / limit + part) for one in (plain, found)])
            assert errors[-1][1] < found.refinement.estimate[0] / limit
        plain, best = np.array(errors).T
        assert np.all(best < plain / 15)
        assert best[-1] < 1e-5
        assert best[-1] < best[0]
        assert -1.1 < np.polyfit(np.log(cells), np.log(plain), 1)[0] < -0.9


@pytest.mark.parametrize(("case", "row"), read_references()[1:12:3], ids=lambda value: f"{value['ratio']:.2f}")
def test_against_references(case, row):
    """From 8 to 64 cells: the error of a plain grid with many times the elements, of nearly second order."""
    truth, cells = np.array([row[name] for name in VALUES]), (8, 16, 32, 64)
    found = [corrected(case, count) for count in cells]
    errors = np.array([np.abs(loads(one) - truth).max() for one in found])
    estimates = np.array([one.refinement.estimate.max() for one in found]) / 0.3
    assert np.all(errors < [1e-2, 2e-3, 6e-4, 1e-4])
    assert np.all(errors[1:] < estimates[1:])
    assert np.polyfit(np.log(cells), np.log(errors), 1)[0] < -1.4
    plain = np.abs(loads(vc.solve(scene(case, 64), certify=None)) - truth).max()
    assert errors[1] < plain < 1e-2  # a sixteenth of the elements


@pytest.mark.parametrize("index", [0, 2, 3, 5, 6, 8, 9, 11])
def test_on_64_cells(index):
    """The other references: below a ten-thousandth of the friction limit, and in the estimate."""
    case, row = read_references()[index]
    found = corrected(case, 64)
    errors = np.abs(loads(found) - [row[name] for name in VALUES])
    assert errors.max() < 1e-4
    assert errors.max() < found.refinement.estimate.max() / 0.3


def test_references_agree_with_plain_grids():
    """Two ways to the continuum, within the uncertainty of the worse; and the cases are those of the command."""
    rows = read_references()
    assert [case for case, _ in rows] == cases()
    for _, row in rows:
        distance = max(abs(row[name] - row[f"plain_{name}"]) for name in VALUES)
        assert distance < 2 * row["plain_error"] + 5e-5
        assert row["error"] < 3e-5


@pytest.mark.parametrize("index", [3, 11])
def test_forces_given(index, tmp_path):
    """The creepages of a reference are found from its forces, and a file keeps them with the problem as corrected."""
    case, row = read_references()[index]
    wanted, unit = scene(case, 16).motion, 0.3 / 3.7
    motion = vc.Steady(Fx=0.3 * row["Fx"], Fy=0.3 * row["Fy"], spin=wanted.spin)
    posed = dataclasses.replace(scene(case, 16), motion=motion)
    plain, found = vc.solve(posed), vc.solve(posed, refine="continuum")
    errors = [np.abs(np.subtract(one.creepage[:2], wanted.rigid[:2])).max() / unit for one in (plain, found)]
    assert errors[1] < 1e-3
    assert errors[1] < 0.06 * errors[0]
    assert np.all(np.abs(np.subtract(found.creepage[:2], wanted.rigid[:2])) < found.refinement.creepage_estimate)
    assert found.creepage[:2] == pytest.approx(tuple(found.refinement.creepages[-1]), rel=1e-12)
    np.testing.assert_allclose(found.force, [motion.Fx, motion.Fy], atol=1.5e-4 * 0.3)
    assert abs(found.moment / 0.3 - row["Mz"]) < 4e-4
    assert set(found.error_estimate.errors) == {"vx", "vy", "Mz"}
    assert found.certificate.residual < 1e-8
    found.save(tmp_path / "forces.nc")
    again = vc.load(tmp_path / "forces.nc")
    assert again.note == ""
    assert again.creepage == found.creepage


def test_one_force_given(rolling):
    """A force along x and a creepage along y: the creepage given stays as it is."""
    found = vc.solve(rolling(motion=vc.Steady(Fx=-0.1, vy=-0.02, spin=0.05)), refine="continuum")
    assert found.creepage[1:] == (-0.02, 0.05)
    assert found.refinement.creepage_estimate[1] == 0
    back = vc.solve(rolling(motion=vc.Steady(vx=found.creepage[0], vy=-0.02, spin=0.05)), refine="continuum")
    np.testing.assert_allclose(back.force, found.force, atol=1e-3 * 0.3)


def test_force_near_saturation_is_refused():
    """A corrected problem may have to carry a little more than the one that is posed."""
    with pytest.raises(vc.SceneError, match="so near to what friction carries that the corrected problem cannot"):
        vc.solve(dataclasses.replace(scene(cases()[8], 16), motion=vc.Steady(Fx=-0.99999 * 0.3)), refine="continuum")


def slopes(ratio, cells, friction, nu=0.28):
    """C11, C22, C23, C32 and C33 by corrected forces of creepages that are nothing beside friction."""
    forces = []
    for motion in (vc.Steady(vx=1e-6), vc.Steady(vy=1e-6), vc.Steady(spin=1e-6)):
        posed = vc.Scene(
            bodies=vc.Bodies(G=1.0, nu=nu),
            surface=vc.Ellipse(a=ratio**0.5, b=ratio**-0.5),
            normal_force=1.0,
            friction=friction,
            motion=motion,
            grid=vc.Grid(nx=cells, ny=cells),
        )
        one = vc.solve(posed, refine="continuum", certify=None)
        forces.append(-np.array([*one.force, one.moment]) / 1e-6)
    return np.array([forces[0][0], forces[1][1], forces[2][1], forces[1][2], forces[2][2]])


def no_slip(ratio, nu=0.28):
    """The same in closed form."""
    known = no_slip_ellipse(ratio, nu)
    return np.array([known[0, 0], known[1, 1], known[1, 2], known[2, 1], known[2, 2]])


@pytest.mark.parametrize(
    ("ratio", "largest", "allowed"),
    [
        (0.2, [6e-3, 1.4e-3], [0.4e-4, 0.4e-4, 3.5e-4, 3.5e-4, 1.2e-4]),
        (1.0, [6e-4, 2e-4], [0.3e-4, 0.3e-4, 0.6e-4, 0.3e-4, 1.2e-4]),
        (5.0, [1.3e-2, 2e-3], [0.2e-4, 0.2e-4, 0.2e-4, 0.2e-4, 1.5e-4]),
    ],
)
def test_nothing_slips(ratio, largest, allowed):
    """No-slip coefficients: the largest error on 8 and 16 cells, and each of them on 32."""
    wanted = no_slip(ratio)
    errors = np.array([np.abs(slopes(ratio, count, np.inf) / wanted - 1) for count in (8, 16, 32)])
    assert np.all(errors[:2].max(axis=1) < largest)
    assert np.all(errors[2] < allowed)


@pytest.mark.parametrize("ratio", [0.2, 5.0])
def test_four_digits_by_spin(ratio):
    """C23 and C33 of slender contacts on 64 cells: the tractions in the outermost rows matter most for them."""
    motion = vc.Steady(spin=1e-3)
    posed = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=ratio**0.5, b=ratio**-0.5),
        normal_force=1.0,
        friction=np.inf,
        motion=motion,
        grid=vc.Grid(nx=64, ny=64),
    )
    found = vc.solve(posed, refine="continuum", certify=None)
    wanted = no_slip(ratio)
    np.testing.assert_allclose([-found.force[1] / 1e-3, -found.moment / 1e-3], wanted[[2, 4]], rtol=1e-4)


@pytest.mark.parametrize("nu", [0.0, 0.5])
def test_nothing_slips_at_any_poisson_ratio(nu):
    """Four digits of all five coefficients on 48 cells, and friction that is enough does as well as infinite one."""
    np.testing.assert_allclose(slopes(1.0, 48, np.inf, nu), no_slip(1.0, nu), rtol=0.8e-4)
    np.testing.assert_allclose(slopes(2.0, 24, 0.3, nu), no_slip(2.0, nu), rtol=3e-4)


def test_carter_without_slip():
    """The slope of Carter's curve at its start, pi G a/(2 (1 - nu)): the parts have its traction, on 8 strips, too."""
    contact = line_contact(2.0, STEEL, a=0.01)
    for count in (8, 16, 33, 64):
        posed = vc.Scene(
            bodies=STEEL,
            surface=vc.Cylinders(R=2.0),
            normal_force=contact.force,
            friction=np.inf,
            motion=vc.Steady(vx=1e-3),
            grid=vc.Grid(nx=count),
        )
        found = vc.solve(posed, refine="continuum", certify=None)
        assert -found.force[0] / 1e-3 == pytest.approx(np.pi * 0.01 / (2 * 0.75), rel=3e-5)


@pytest.mark.parametrize("part", [0.003, 0.01, 0.02, 0.04, 0.07])
def test_slip_narrower_than_an_element(part):
    """Between no slip and a slip area of a few strips, Carter's force is met as well as elsewhere."""
    contact = line_contact(2.0, STEEL, a=0.01)
    limit, errors = 0.3 * contact.force, []
    posed = vc.Scene(
        bodies=STEEL,
        surface=vc.Cylinders(R=2.0),
        normal_force=contact.force,
        friction=0.3,
        motion=vc.Steady(vx=carter(contact, 0.3, force=-part * limit).creepage),
    )
    for count in (16, 32, 64):
        one = dataclasses.replace(posed, grid=vc.Grid(nx=count))
        errors.append(abs(vc.solve(one, refine="continuum", certify=None).force[0] / limit + part))
    assert np.all(np.array(errors) < [3e-4, 1.3e-4, 6e-5])


def test_infinite_friction(tmp_path):
    """The estimate counts by the force, nothing is lost by friction, and the file keeps it."""
    posed = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.2, b=0.9),
        normal_force=1.0,
        friction=np.inf,
        motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
        grid=vc.Grid(nx=16, ny=16),
    )
    found = vc.solve(posed, refine="continuum")
    exact = -no_slip_ellipse(1.2 / 0.9, 0.28) @ [0.04, -0.02, 0.05 * np.sqrt(1.08)] * 1.08
    size = np.hypot(*exact[:2])
    errors = np.abs(np.array([*found.force, found.moment / np.sqrt(1.08)]) - exact) / size
    assert errors.max() < 3e-4
    assert errors.max() < max(found.error_estimate.errors.values())
    assert found.error_estimate.errors["Fx"] == pytest.approx(found.refinement.estimate[0] / np.hypot(*found.force))
    assert found.refinement.passes < 20
    assert abs(found.friction_work) < 0.02 * found.power
    assert "of the tangential force" in found.report()
    found.save(tmp_path / "stuck.nc")
    again = vc.load(tmp_path / "stuck.nc")
    assert again.note == ""
    assert again.report() == found.report()


@pytest.mark.parametrize("factor", [1e-3, 1e6])
def test_units(sol, rolling, factor):
    """Lengths and moduli in other units: the same numbers in these."""
    length, modulus = factor, 3.0 / factor
    force = modulus * length**2
    posed = rolling(
        bodies=vc.Bodies(G=modulus, nu=0.28),
        surface=vc.Ellipse(a=1.2 * length, b=0.9 * length),
        normal_force=force,
        motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05 / length),
    )
    other = vc.solve(posed, refine="continuum")
    np.testing.assert_allclose(other.force / force, sol.force, rtol=1e-9)
    assert other.moment / force / length == pytest.approx(sol.moment, rel=1e-9)
    np.testing.assert_allclose(other.refinement.estimate[:2] / force, sol.refinement.estimate[:2], rtol=1e-5)
    np.testing.assert_allclose(other.refinement.slip, sol.refinement.slip, atol=1e-9)


@pytest.mark.parametrize(("vx", "vy", "spin"), [(1, -1, -1), (-1, -1, -1), (-1, 1, 1)])
def test_mirror_and_direction(sol, rolling, vx, vy, spin):
    """The mirror image at y = 0, all creepages turned round, and both: forces follow by their signs."""
    other = vc.solve(rolling(motion=vc.Steady(vx=0.04 * vx, vy=-0.02 * vy, spin=0.05 * spin)), refine="continuum")
    np.testing.assert_allclose(other.force, sol.force * [vx, vy], rtol=1e-8)
    assert other.moment == pytest.approx(spin * sol.moment, rel=1e-8)
    mirrored = slice(None, None, -1 if vx != vy else 1)
    signs = np.array([vx, vy])[:, None, None]
    np.testing.assert_allclose(other.refinement.traction[:, mirrored] * signs, sol.refinement.traction, atol=1e-8)


def test_record(sol, rolling):
    """Forces are those of the field, the field is within its bound, and what the last pass changed stands there."""
    found = sol.refinement
    assert found.cells == (2, 2)
    assert found.grid.shape == found.traction.shape[1:] == (28, 28)
    assert found.passes == len(found.seconds) == 4
    x, y = found.grid.x[None, :], found.grid.y[:, None]
    np.testing.assert_allclose(sol.force, found.traction.sum(axis=(1, 2)) * found.grid.area, rtol=1e-13)
    moment = np.sum(x * found.traction[1] - y * found.traction[0]) * found.grid.area
    assert sol.moment == found.moment == pytest.approx(moment, rel=1e-12)
    bound = 0.3 * sol.scene.hertz.mean_pressure(*found.grid.lines)
    assert np.all(np.hypot(*found.traction) <= bound * (1 + 1e-12))
    np.testing.assert_array_equal(found.change, np.abs(found.forces[4] - found.forces[3]))
    assert np.all(found.estimate >= found.change / 0.7 * (1 - 1e-12))
    assert found.estimate[0] == found.estimate[1]  # of a vector
    plain = vc.solve(rolling(), tol=1e-5)
    np.testing.assert_allclose(found.forces[0], [*plain.force, plain.moment], atol=1e-6)
    assert plain.refinement is None
    assert np.abs(sol.force - plain.force).max() > 0.005 * 0.3


def test_work(rolling, sol):
    """What rolling puts in is what friction loses: to a twentieth of what plain elements lack by their slip."""
    plain = vc.solve(rolling())
    by_slip = -np.sum(plain.traction * plain.slip) * plain.grid.area
    assert abs(sol.power / sol.friction_work - 1) < 0.05 * abs(plain.power / by_slip - 1)
    np.testing.assert_allclose(sol.power_density.sum() * sol.grid.area, sol.friction_work, rtol=1e-12)


def test_slip_of_the_continuum(sol):
    """Nothing slips where the elements stick; where they slip, slip opposes the traction."""
    parts = np.repeat(np.repeat(sol.state, 2, axis=0), 2, axis=1)
    found, size = sol.refinement, np.hypot(*sol.refinement.slip)
    assert np.sqrt(np.mean(size[parts == 1] ** 2)) < 0.1 * np.sqrt(np.mean(size[parts == 2] ** 2))
    slips = (parts == 2) & (size > 0.2 * size.max())
    cosine = np.sum(found.slip * found.traction, axis=0)[slips] / (size * np.hypot(*found.traction))[slips]
    assert np.all(cosine < -0.95)


def test_certificate_is_of_the_corrected_problem(sol, rolling):
    """Exact for the problem as corrected; the plain problem's certificate refuses the same tractions."""
    assert sol.converged
    assert sol.certificate.residual < 1e-8
    assert sol.certificate.relative_gap < 1e-9
    assert vc.certify(rolling(grid=sol.grid), sol.traction).residual > 1e-3
    assert "of the corrected problem on the elements" in sol.report()


def test_stages_add_up(sol):
    """Coarse solves within the refinement count once: no stage has the time of another."""
    stages = {name: seconds for name, seconds in sol.timing.items() if name != "total"}
    assert {"tangential", "refinement", "error estimate"} <= set(stages)
    assert sum(stages.values()) <= sol.timing["total"]


def test_report_and_summary(sol):
    text = sol.report()
    assert "forces and moment are those of a field on 2 x 2 parts of each element, after 4 passes" in text
    assert "against the continuum, about: Fx to" in text
    assert "no bound: the difference from half as many elements across the contact" in text
    assert "guaranteed on this grid, for Hertz's pressure, for the sums over the elements: Fx to" in text
    summary = json.loads(json.dumps(sol.summary(), allow_nan=False))
    assert summary["refinement"]["kind"] == "continuum"
    assert summary["refinement"]["parts"] == [2, 2]
    assert summary["refinement"]["forces"][-1] == [*summary["force"], summary["moment"]]
    errors = np.array(summary["refinement"]["error_estimate"]) / 0.3 / [1, 1, np.sqrt(1.2 * 0.9)]
    np.testing.assert_allclose(list(summary["error_estimate"]["errors"].values()), errors, rtol=1e-12)
    assert [each["nx"] for each in summary["error_estimate"]["solves"]] == [12]


def test_file(sol, tmp_path):
    """All of it comes back, and the certificate is found to be deserved: the corrected problem can be posed again."""
    path = tmp_path / "corrected.nc"
    sol.save(path)
    again = vc.load(path)
    assert again.note == ""
    assert again.converged
    assert again.refinement.summary() == sol.refinement.summary()
    for name in ("traction", "slip", "correction"):
        np.testing.assert_array_equal(getattr(again.refinement, name), getattr(sol.refinement, name))
    np.testing.assert_array_equal(again.force, sol.force)
    assert again.report() == sol.report()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"traction": 1.01}, "forces that are not those of the tractions on parts"),
        ({"forces": 1.01}, "forces that are not those of the last pass"),
        ({"estimate": -1.0}, "a refinement with an estimate that is negative"),
        ({"creepages": np.zeros((5, 1))}, "without forces by pass and an estimate"),
        ({"slip": np.nan}, "not of finite numbers"),
        ({"share": -1.0}, "tractions beyond what friction can bear"),
    ],
)
def test_tampered_file(sol, tmp_path, changes, message):
    changed = {
        name: (getattr(sol.refinement, name) * factor if np.ndim(factor) == 0 else factor)
        for name, factor in changes.items()
    }
    spoilt = dataclasses.replace(sol, refinement=dataclasses.replace(sol.refinement, **changed))
    spoilt.save(tmp_path / "spoilt.nc")
    with pytest.raises(vc.OutputError, match=message):
        vc.load(tmp_path / "spoilt.nc")


def test_slip_difference_of_second_order():
    """The coarse problem may be another one: what is left is that of the field."""
    case, row = read_references()[4]
    truth, posed = np.array([row[name] for name in VALUES]), scene(case, 16)
    other = dataclasses.replace(posed.motion, slip_difference="second-order", spin_offset=0.0)
    found = vc.solve(dataclasses.replace(posed, motion=other), refine="continuum", certify=None)
    assert np.abs(loads(found) - truth).max() < 2e-3
    assert np.abs(loads(found) - loads(corrected(case, 16))).max() < 2e-3


def test_any_exact_method(sol, rolling):
    """Newton's method and a convex program correct to the same forces."""
    for name in ("newton", "clarabel"):
        other = vc.solve(rolling(), tangential=name, refine="continuum")
        np.testing.assert_allclose(other.force, sol.force, rtol=1e-6)
        assert other.solved_by["tangential"] in (name, "tang-safeguarded")


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({}, {"refine": "continum"}, "refine = 'continum' is not allowed: must be one of continuum"),
        ({}, {"refine": 2}, "refine = 2 is not allowed"),
        ({"motion": None, "friction": None}, {}, "it is for tractions, and without a motion there are none: leave"),
        ({"motion": vc.Shift(ux=1e-3), "friction": np.inf}, {}, "with infinite friction it is for steady rolling; so"),
        ({"friction": 0.0}, {}, "without friction there is nothing to correct"),
        ({"bodies": vc.Bodies(G=(1.0, 2.0), nu=(0.2, 0.3))}, {}, "it is for quasi-identical bodies, and here K ="),
        ({"friction": np.inf}, {"normal": "newton"}, "with infinite friction it is for Hertz's pressure in closed"),
        ({}, {"tangential": "fastsim"}, "it corrects exact methods, not the theory 'fastsim'"),
        ({"grid": vc.Grid(nx=12, ny=12, edge="touched")}, {}, 'with grid.edge = "touched" it gains less, or loses'),
        ({"grid": vc.Grid(nx=12, ny=12, edge="softened")}, {}, 'with grid.edge = "softened" it gains less, or loses'),
        ({"grid": vc.Grid(nx=12, ny=7)}, {}, "at least 8 elements across the contact each way; here it has 12 by 7"),
    ],
)
def test_refused_before_any_work(rolling, monkeypatch, changes, options, message):
    """With the reason and what to do instead."""
    monkeypatch.setattr("varcontact.solving.on_grid.on_a_grid_that_holds_it", None)
    with pytest.raises(vc.SceneError) as refused:
        vc.solve(rolling(**changes), **{"refine": "continuum", **options})
    assert message in str(refused.value)


def test_refused_with_an_accuracy(rolling):
    """The grid of a correction is the scene's; an accuracy chooses its own."""
    with pytest.raises(vc.SceneError, match="it corrects on the scene's own grid; leave it out, or accuracy"):
        vc.solve(rolling(grid="auto"), refine="continuum", accuracy=0.01)


def test_command_line_and_scene_file(tmp_path):
    text = (
        "normal_force = 1.0\nfriction = 0.3\nbodies = {G = 1.0, nu = 0.28}\n"
        'surface = {kind = "ellipse", a = 1.0, b = 1.0}\nmotion = {kind = "steady", vx = 0.05}\n'
        "grid = {nx = 8, ny = 8}\n"
    )
    (tmp_path / "plain.toml").write_text(text)
    (tmp_path / "corrected.toml").write_text(text + '[solve]\nrefine = "continuum"\n')
    named = run("solve", "plain.toml", "--refine", "continuum", "--json", folder=tmp_path)
    written = run("solve", "corrected.toml", "--json", folder=tmp_path)
    forces = [json.loads(done.stdout)["force"] for done in (named, written)]
    assert forces[0] == forces[1]
    wrong = run("solve", "plain.toml", "--refine", "fine", folder=tmp_path)
    assert wrong.returncode == 2
    assert "refine = 'fine' is not allowed: must be one of continuum" in wrong.stderr


def test_interpolation_is_exact_for_linear_fields():
    """Inside; and means of the parts give the elements back."""
    x, y = np.meshgrid(np.arange(5) + 0.5, np.arange(4) + 0.5)
    fine_x, fine_y = np.meshgrid((np.arange(15) + 0.5) / 3, (np.arange(8) + 0.5) / 2)
    found = interpolated(2 * x - 3 * y, np.ones((4, 5), dtype=bool), (2, 3))
    inner = (slice(1, -1), slice(2, -2))
    np.testing.assert_allclose(found[inner], (2 * fine_x - 3 * fine_y)[inner], atol=1e-13)
    np.testing.assert_allclose(means(2 * fine_x - 3 * fine_y, (2, 3)), 2 * x - 3 * y, atol=1e-13)


def over(count, a=1.0):
    """A bound that is never reached, and the weight, of a line contact on so many strips."""
    grid = vc.Grid(nx=count, dx=2 * a / count, x0=-a)
    return Shape(np.full(grid.shape, 1e6), root_means(grid, a, np.inf).weight)


def test_reconstruction_is_exact_without_slip():
    """Tractions like sqrt((1 - x)/(1 + x)), those of rolling without slip: their means over the parts, at both ends."""
    coarse, fine = over(16), over(48)
    rolled = np.array([-2 * coarse.weight, 3 * coarse.weight])
    found = reconstructed(rolled, coarse, fine, (1, 3))
    np.testing.assert_allclose(found, [-2 * fine.weight, 3 * fine.weight], rtol=1e-12)
    x = np.linspace(-1, 1, 49)
    np.testing.assert_allclose(fine.weight[0], np.diff(np.arcsin(x) + np.sqrt(1 - x**2)) * 24, rtol=1e-12)


@pytest.mark.parametrize(("a", "b"), [(1.3, 0.6), (0.5, 1.0)])
def test_means_over_the_root(a, b):
    """They add up to those over the ellipse, in closed form; within it each is that of its points."""
    grid = vc.Grid(nx=22, ny=18, margin=1).spread((-a, a, -b, b))
    known, whole = root_means(grid, a, b), np.pi * a * b
    found = np.array([*known.over, *known.times, known.weight])
    sums = [2 * whole, 0, 0, 2 / 3 * whole, 0, 0, np.pi / 2 * whole]
    np.testing.assert_allclose(found.sum(axis=(1, 2)) * grid.area, sums, rtol=1e-6, atol=1e-12)
    inner = (slice(None), 9, 9)
    x, y = (np.linspace(lines[9], lines[10], 201) for lines in grid.lines)
    x, y = np.meshgrid((x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2)
    root, half = np.sqrt(1 - (x / a) ** 2 - (y / b) ** 2), a * np.sqrt(1 - (y / b) ** 2)
    wanted = [1 / root, x / root, y / root, root, x * root, y * root, np.sqrt((half - x) / (half + x))]
    np.testing.assert_allclose(found[inner], np.mean(wanted, axis=(1, 2)), rtol=1e-5)


@pytest.mark.parametrize("line", [False, True])
def test_what_parts_miss(line):
    """Of 3 over the root all that the derivative has, in strips of 3 + 2 x; inside an ellipse nearly of 3 + 2 x - y."""
    if line:
        motion = vc.Steady(vx=1e-3)
        posed = vc.Scene(bodies=STEEL, surface=vc.Cylinders(R=2.0), normal_force=1e-3, friction=0.3, motion=motion)
        a = posed.hertz.a
        grid = vc.Grid(nx=16, dx=a / 8, x0=-a)
    else:
        posed, a = scene(cases()[0], 16), 1.0
        grid = vc.Grid(nx=16, ny=16, margin=1).spread((-a, a, -a, a))
    disc = discretise(dataclasses.replace(posed, grid=grid), grid)
    fine = Parts(disc, (1 if line else 2, 2), posed.hertz.on_elements(grid) / disc.scales.pressure)
    (root, x, y), unit = fine.rooted.means, a / disc.scales.length
    inside, step = root > 0, fine.lattice.sides[0]

    def derivative(traction):
        field = np.array([traction, 0 * traction])
        return (fine.derivative.apply(field) + fine.rooted.lacking(field))[:, inside]

    np.testing.assert_allclose(derivative(3 * root), 0, atol=1e-12)
    gradients = -step * rooted_gradients(unit, np.inf if line else unit, nu=disc.operators.nu)[:, :, :1] / unit
    linear = 3 * root + (2 * x - (0 if line else y)) / unit
    exact = 2 * gradients[1] - (0 if line else gradients[2])
    off = np.abs(derivative(linear) - exact).max(axis=0)
    deep = np.hypot(x[inside], y[inside]) < 0.8 * unit * root[inside]
    assert off[deep].max() < (1e-12 if line else 5e-3 * np.abs(exact).max())


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (2.0, 0.7)])
def test_what_parts_miss_of_sloped_pressure(a, b):
    """With it the derivative by 3 - 2 x + y times Hertz's pressure is that of second degree in closed form."""
    posed = dataclasses.replace(scene(cases()[0], 16), surface=vc.Ellipse(a=a, b=b))
    grid = vc.Grid(nx=24, ny=24, margin=1).spread((-a, a, -b, b))
    disc = discretise(dataclasses.replace(posed, grid=grid), grid)
    fine = Parts(disc, (2, 2), posed.hertz.on_elements(grid) / disc.scales.pressure)
    root, x, y = fine.sloped.means
    inside, (a, b), step = root > 0, fine.axes, fine.lattice.sides[0]
    traction = np.array([0 * root, 3 * root - 2 * x / a + y / b])
    found = fine.derivative.apply(traction) + fine.sloped.lacking(traction)
    px, py = np.meshgrid(fine.lattice.x, fine.lattice.y)
    known = ellipsoidal_gradients(px, py, a, b, nu=disc.operators.nu)[:, 1]
    sloped = sloped_gradients(px, py, a, b, nu=disc.operators.nu)[:, :, 1]
    exact = -step * (3 * known - 2 * sloped[0] / a + sloped[1] / b)
    off = np.abs(found - exact)[:, inside & (np.hypot(px / a, py / b) < 0.95)]
    assert off.max() < 2e-3 * np.abs(exact[:, inside]).max()
    plain = np.abs(fine.derivative.apply(traction) - exact)[:, inside]
    assert plain.max() > 0.02 * np.abs(exact[:, inside]).max()


def test_what_late_passes_would_have_changed_counts():
    """Of the last pass; and of those before it that took a part only what they left out, too."""
    forces = np.array([[0.0], [8.0], [10.0], [10.7], [10.77]])
    found = dict.fromkeys(Corrected.__dataclass_fields__)
    assert Corrected(**found | {"taken": (1.0, 1.0, 0.7, 0.7)}).unsettled(forces) == pytest.approx([1.0])
    assert Corrected(**found | {"taken": (1.0, 1.0, 1.0, 1.0)}).unsettled(forces) == pytest.approx([0.07])


def test_extrapolated_passes_solve_linear_problems():
    """Of n unknowns in n + 1 passes, even where passes by themselves would run away."""
    rng = np.random.default_rng(3)
    matrix, right = 2 * rng.normal(size=(4, 4)), rng.normal(size=4)
    used, found = [np.zeros(4)], []
    for _ in range(6):
        found.append(matrix @ used[-1] + right)
        used.append(extrapolated(used, found, np.ones(4)))
    np.testing.assert_allclose(used[-1], np.linalg.solve(np.eye(4) - matrix, right), rtol=1e-8)


def test_the_rearmost_element_is_held():
    """Where it sticks it takes the correction of the element ahead, where it slips its own."""
    bound = np.array([[0.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0]])
    traction = np.array([[[0.0, 0.5, 0.5, 0.0, 1.0, 0.5, 0.5]], np.zeros((1, 7))])
    correction = np.array([np.arange(7.0)[None], -np.arange(7.0)[None]])
    found = held_behind(correction, traction, bound)
    np.testing.assert_array_equal(found[0, 0], [0, 2, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(found[1], -found[0])
