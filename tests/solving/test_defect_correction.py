"""Defect correction: the continuum's forces from coarse grids, against closed forms and references."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

import varcontact as vc
from tests.command import run, scene_file
from tests.refined_references import VALUES, corrected, loads, read_references, scene
from tests.scenes import in_units, make_scene, refused
from varcontact.reference.no_slip_ellipse import no_slip_ellipse

DATA = Path(__file__).parents[1] / "data"
X = np.linspace(-1.5, 1.5, 31)
BOWL = vc.SampledDistance(X**2 + X[:, None] ** 2, X, X)
LINE = {"surface": vc.Cylinders(1.0), "grid": vc.Grid(nx=16), "motion": vc.Steady(vx=1e-3)}


@pytest.fixture(scope="module")
def sol(rolling):
    return vc.solve(rolling(), refine="continuum")


@pytest.mark.parametrize(("case", "row"), read_references()[1:8:3], ids=lambda value: f"{value['ratio']:.2f}")
def test_against_references(case, row):
    """From 8 to 64 cells: the error of a plain grid with many times the elements, of nearly second order."""
    truth, cells = np.array([row[name] for name in VALUES]), (8, 16, 32, 64)
    found = [corrected(scene(case, count)) for count in cells]
    errors = np.array([np.abs(loads(one) - truth).max() for one in found])
    estimates = np.array([one.refinement.estimate.max() for one in found]) / 0.3
    assert np.all(errors < [1e-2, 2e-3, 6e-4, 1e-4])
    assert np.all(errors[1:] < estimates[1:])
    assert np.polyfit(np.log(cells), np.log(errors), 1)[0] < -1.4
    plain = np.abs(loads(vc.solve(scene(case, 64), certify=None)) - truth).max()
    assert errors[1] < plain < 1e-2  # a sixteenth of the elements


@pytest.mark.parametrize("index", [3, 11])
def test_forces_given(index, tmp_path):
    """The creepages of a reference are found from its forces, and a file keeps them with the problem as corrected."""
    case, row = read_references()[index]
    wanted, unit = scene(case, 16).motion, 0.3 / 3.7
    motion = vc.Steady(Fx=0.3 * row["Fx"], Fy=0.3 * row["Fy"], spin=wanted.spin)
    posed = dataclasses.replace(scene(case, 16), motion=motion)
    plain, found = vc.solve(posed, certify=None), vc.solve(posed, refine="continuum")
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


def test_force_near_saturation_is_refused():
    """A corrected problem may have to carry a little more than the one that is posed."""
    posed = dataclasses.replace(scene(read_references()[8][0], 16), motion=vc.Steady(Fx=-0.99999 * 0.3))
    with pytest.raises(vc.SceneError, match="so near to saturation the corrected problem cannot carry"):
        corrected(posed)


@pytest.mark.parametrize("ratio", [0.3, 3.0])
@pytest.mark.parametrize("direction", [(1, 0, 0), (0, 0, 1), (0.5, -0.4, 0.6)])
def test_next_to_no_slip(ratio, direction):
    """Creepages that are nothing beside friction: a tenth of the plain error, within the estimate."""
    creepages = 1e-6 * np.array(direction)
    case, exact = dict(zip(("vx", "vy", "spin"), creepages, strict=True)), -no_slip_ellipse(ratio, 0.28) @ creepages
    for cells in (16, 32):
        posed = scene({"ratio": ratio, "nu": 0.28, **dict.fromkeys(case, 0.0)}, cells)
        posed = dataclasses.replace(posed, motion=vc.Steady(**{name: float(each) for name, each in case.items()}))
        plain, found = vc.solve(posed, certify=None), corrected(posed)
        before, error = (np.abs([*one.force, one.moment] - exact).max() for one in (plain, found))
        assert error < before / 10
        assert error < found.refinement.estimate.max()


@pytest.mark.parametrize("factor", [1e-3, 1e6])
def test_units(sol, rolling, factor):
    length, stress = factor, 3.0 / factor
    force = stress * length**2
    other = vc.solve(in_units(rolling(), length, stress), refine="continuum")
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


def test_slip_of_the_continuum(sol):
    """Nothing slips where the elements stick; where they slip, slip opposes the traction."""
    parts = np.repeat(np.repeat(sol.state, 2, axis=0), 2, axis=1)
    found, size = sol.refinement, np.hypot(*sol.refinement.slip)
    assert np.sqrt(np.mean(size[parts == 1] ** 2)) < 0.1 * np.sqrt(np.mean(size[parts == 2] ** 2))
    slips = (parts == 2) & (size > 0.2 * size.max())
    cosine = np.sum(found.slip * found.traction, axis=0)[slips] / (size * np.hypot(*found.traction))[slips]
    assert np.all(cosine < -0.95)


def test_certificate_is_of_the_corrected_problem(sol, rolling):
    assert sol.converged
    assert sol.certificate.residual < 1e-8
    assert sol.certificate.relative_gap < 1e-9
    assert vc.certify(rolling(grid=sol.grid), sol.traction).residual > 1e-3
    assert "of the corrected problem on the elements" in sol.report()


def test_file(sol, tmp_path):
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
    [({"creepages": np.zeros((5, 1))}, "cannot reshape"), ({"slip": np.array(np.nan)}, "or not finite")],
)
def test_spoilt_file(sol, tmp_path, changes, message):
    changed = {name: each if each.ndim else each * getattr(sol.refinement, name) for name, each in changes.items()}
    spoilt = dataclasses.replace(sol, refinement=dataclasses.replace(sol.refinement, **changed))
    spoilt.save(tmp_path / "spoilt.nc")
    refused(lambda: vc.load(tmp_path / "spoilt.nc"), match=message, error=vc.OutputError)


def test_a_corrected_problem_that_is_another_one_is_certified_anew(sol, tmp_path):
    changed = dataclasses.replace(sol.refinement, correction=1.01 * sol.refinement.correction)
    dataclasses.replace(sol, refinement=changed).save(tmp_path / "spoilt.nc")
    assert not vc.load(tmp_path / "spoilt.nc").converged


@pytest.mark.parametrize(
    ("changes", "options", "field", "word"),
    [
        ({}, {"refine": "continum"}, "refine", "must be one of continuum"),
        ({}, {"refine": 2}, "refine", "not allowed"),
        ({"motion": None, "friction": None}, {}, "refine", "without a motion"),
        ({"motion": vc.Shift(ux=1e-3)}, {}, "refine", "accuracy"),
        ({"motion": vc.Transient(steps=2, dq=0.1, vx=1e-3)}, {}, "refine", "accuracy"),
        (LINE, {}, "refine", "accuracy"),
        ({"surface": BOWL}, {}, "refine", "accuracy"),
        ({"grid": "auto"}, {"accuracy": 0.01}, "refine", "it corrects on the scene's own grid, and accuracy"),
        ({"bodies": vc.Bodies(G=(1.0, 2.0), nu=(0.2, 0.3))}, {}, "refine", "accuracy"),
        ({}, {"normal": "newton"}, "refine", "accuracy"),
        ({"friction": np.inf}, {}, "refine", "no_slip_ellipse"),
        ({"friction": 0.0}, {}, "refine", "without friction"),
        ({}, {"tangential": "fastsim"}, "refine", "fastsim"),
        ({"grid": vc.Grid(nx=12, ny=12, edge="touched")}, {}, "refine", "grid.edge"),
        ({"grid": vc.Grid(nx=12, ny=12, edge="softened")}, {}, "refine", "grid.edge"),
        ({"grid": vc.Grid(nx=12, ny=7)}, {}, "grid", "not 12 by 7"),
    ],
)
def test_refused_before_any_work(rolling, monkeypatch, changes, options, field, word):
    monkeypatch.setattr("varcontact.solving.on_grid.solve_contact", None)
    refused(lambda: vc.solve(rolling(**changes), **{"refine": "continuum", **options}), field, match=word)


def test_command_line_and_scene_file(tmp_path):
    (tmp_path / "plain.toml").write_text(scene_file())
    (tmp_path / "corrected.toml").write_text(scene_file() + '[solve]\nrefine = "continuum"\n')
    named = run("solve", "plain.toml", "--refine", "continuum", "--json", folder=tmp_path)
    written = run("solve", "corrected.toml", "--json", folder=tmp_path)
    forces = [json.loads(done.stdout)["force"] for done in (named, written)]
    assert forces[0] == forces[1]
    wrong = run("solve", "plain.toml", "--refine", "fine", folder=tmp_path)
    assert wrong.returncode == 2
    assert "refine = 'fine' is not allowed: must be one of continuum" in wrong.stderr


def by_element(cells, motion):
    """A Hertzian contact whose sides rub differently: 0.35 left of the rolling direction, 0.2 right of it."""
    grid = vc.Grid(nx=cells, ny=cells, margin=0).spread((-1.2, 1.2, -0.8, 0.8))
    friction = np.where(grid.y[:, None] > 0, 0.35, 0.2) * np.ones(cells)
    return make_scene(vc.Ellipse(a=1.2, b=0.8), 1.0, motion, grid, friction)


def test_elements_without_friction(rolling):
    """Rounding where elements of two grids meet gave the coarser one a friction of 1e-31, which is refused."""
    grid = vc.Grid(nx=24, ny=24, dx=0.1, dy=0.1, x0=-1.2, y0=-1.2)
    x, y = np.meshgrid(grid.x, grid.y)
    friction = np.where(x**2 + y**2 < 0.1, 0.0, 0.3)
    posed = rolling(surface=vc.Ellipse(a=1.0, b=1.0), friction=friction, motion=vc.Steady(vx=0.1), grid=grid)
    sol = corrected(posed)
    fine = corrected(dataclasses.replace(posed, friction=0.3))
    assert abs(sol.force[0]) < 0.95 * abs(fine.force[0])
    assert sol.refinement.estimate[0] < 0.02 * abs(sol.force[0])


def test_friction_by_element():
    """An eighth of the plain error and less; in a mirror the same; with one coefficient that of a number."""
    motion = vc.Steady(vx=0.03, vy=-0.03, spin=0.06)
    truth = three(corrected(by_element(64, motion)))
    plain = vc.solve(by_element(16, motion), certify=None)
    found = corrected(by_element(16, motion))
    error = np.abs(three(found) - truth).max()
    assert error < np.abs(three(plain) - truth).max() / 7
    assert error < found.refinement.estimate.max() / 0.3
    posed = by_element(16, vc.Steady(vx=0.03, vy=0.03, spin=-0.06))
    turned = corrected(dataclasses.replace(posed, friction=posed.friction[::-1].copy()))
    np.testing.assert_allclose(three(turned), three(found) * [1, -1, -1], atol=1e-6)
    even = dataclasses.replace(posed, friction=np.full(posed.grid.shape, 0.3))
    number = dataclasses.replace(posed, friction=0.3)
    forces = [three(corrected(each)) for each in (even, number)]
    np.testing.assert_allclose(*forces, rtol=1e-10)


def three(one):
    """Fx, Fy and Mz by the static limit."""
    return np.array([*one.force, one.moment]) / 0.3


@pytest.mark.parametrize(
    "law", [vc.LinearFalling(static=0.3, kinetic=0.2, half_velocity=0.08), vc.StaticKinetic(0.3, 0.25)]
)
def test_laws_of_friction(law, rolling, tmp_path):
    """A tenth of the plain error, within the estimate; the truth is extrapolated from plain grids."""
    posed = rolling(friction=law, motion=vc.Steady(vx=0.05, vy=-0.02, spin=0.05), grid=vc.Grid(nx=16, ny=16))
    grids = [vc.Grid(nx=n, ny=n, edge="touched") for n in (32, 64)]
    coarse, fine = (three(vc.solve(dataclasses.replace(posed, grid=grid), certify=None)) for grid in grids)
    plain, found = vc.solve(posed, certify=None), vc.solve(posed, refine="continuum")
    error = np.abs(three(found) - (2 * fine - coarse)).max()
    assert error < np.abs(three(plain) - (2 * fine - coarse)).max() / 8
    assert error < max(found.error_estimate.errors.values())
    assert found.certificate.residual < 1e-8
    found.save(tmp_path / "law.nc")
    again = vc.load(tmp_path / "law.nc")
    assert again.note == ""
    np.testing.assert_array_equal(again.force, found.force)


@pytest.mark.parametrize(("name", "parts", "passes"), [("refined_shift", [1, 2], 3), ("refined_history", [1, 2], 2)])
def test_files_of_what_is_no_longer_corrected(name, parts, passes, tmp_path):
    """Of a shift under a sampled pressure, and of steps: read, found to be right, drawn and written again."""
    found = vc.load(DATA / f"{name}.nc")
    found.save(tmp_path / "again.nc")
    for each in (found, vc.load(tmp_path / "again.nc")):
        sol = each[-1] if isinstance(each, vc.History) else each
        assert sol.note == ""
        assert sol.refinement.summary()["parts"] == parts
        assert sol.refinement.passes == passes
        np.testing.assert_allclose(sol.force, sol.refinement.forces[-1, :2], rtol=1e-12, atol=1e-15)
        assert "estimated errors against the continuum: F" in each.report()
        assert sol.plot().axes[0].get_title().endswith("(corrected, on 2 parts)")
