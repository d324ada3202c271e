"""Histories corrected towards the continuum: closed forms, references, symmetries, files, words, refusals."""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.benchmarks.refinement.histories import FULL, history, off, on
from tests.command import run
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.reference import cattaneo_mindlin
from varcontact.results.error_estimate import ErrorEstimate, Solve
from varcontact.solving.defect_correction.field import Shape, reconstructed
from varcontact.solving.defect_correction.passes import shares

ROLLING = on(history(1.2, steps=3, dq=[0.0, 0.3, 0.4], Fx=[-0.1, -0.15, -0.15], vy=0.3 * FULL, spin=0.3 * FULL), 16)
WILD = vc.Transient(
    steps=5,
    dq=[0.0, 0.1, 0.2, 0.0, 0.1],
    direction=[1, 1, -1, 1, 1],
    vx=[0.0, 0.0, 0.05, 0.0, 0.04],
    vy=[0.0, 0.02, 0.0, 0.0, -0.03],
    ux=[0.01, 0.0, 0.0, 0.0, 0.0],
    rotation=[0.0, 0.0, 0.0, 0.01, 0.0],
    spin=[0.0, 0.05, 0.05, 0.0, 0.05],
    Fx=[None, -0.1, None, 0.05, None],
    normal_force=[1.0, 1.0, 1.2, None, 0.6],
    approach=[None, None, None, 0.4, None],
    friction=[0.3, 0.3, 0.2, 0.2, 0.3],
)


def corrected(scene, **options):
    """A corrected history, without bounds."""
    return vc.solve(scene, refine="continuum", certify=None, **options)


@pytest.fixture(scope="module")
def rolled():
    """A shift by a force, then rolling under it."""
    return vc.solve(ROLLING, refine="continuum")


@pytest.fixture(scope="module")
def wild():
    """Everything that may change does."""
    return corrected(on(history(1.3, **vars(WILD)), 16))


@pytest.mark.parametrize(("cells", "gain"), [(16, 10), (32, 4)])
def test_cattaneos_shift_to_and_fro(cells, gain):
    """A force in place, then one the other way: unloading is Cattaneo's problem with twice the friction."""
    scene = replace(history(1.0, steps=2, dq=0.0, Fx=[0.2, -0.1]), bodies=vc.Bodies(G=1.0, nu=0.0))
    first, second = (cattaneo_mindlin(scene.hertz, scene.bodies, f, force=F).shift for f, F in ((0.3, 0.2), (0.6, 0.3)))
    plain, found = vc.solve(on(scene, cells), certify=None), corrected(on(scene, cells))
    errors = np.array([np.abs(one.creepage[:, 0] - [first, -second]) for one in (plain, found)])
    assert errors[1].max() < errors[0].max() / gain
    assert errors[1].max() < 2e-3 * abs(first)
    assert errors[1, 1] < found[1].refinement.creepage_estimate[0]
    np.testing.assert_allclose(found.force[:, 0], [0.2, -0.1], atol=5e-4 * 0.3)
    assert np.all(np.abs(found.force[:, 0] - [0.2, -0.1]) <= [step.refinement.estimate[0] for step in found])


def test_one_step_in_place_is_the_shift():
    """Pass by pass; the shift has one pass more."""
    moved = {"ux": 0.3 * FULL, "uy": -0.5 * FULL, "rotation": 0.4 * FULL}
    scene = history(0.7, steps=1, dq=0.0, **moved)
    step, shift = corrected(on(scene, 16))[0], corrected(on(replace(scene, motion=vc.Shift(**moved)), 16))
    passes = len(step.refinement.forces)
    np.testing.assert_allclose(step.refinement.forces, shift.refinement.forces[:passes], atol=2e-5)
    assert np.all(np.abs(step.force - shift.force) <= step.refinement.estimate[:2])


def test_a_long_history_tends_to_steady_rolling():
    """Of first order in the length of the steps: two lengths, extrapolated, meet the steady field's force."""
    steady = corrected(on(replace(history(1.0, steps=1), motion=vc.Steady(vx=0.5 * FULL)), 32)).force[0]
    ends = []
    for solve in (corrected, lambda scene: vc.solve(scene, certify=None)):
        forces = [
            solve(on(history(1.0, steps=steps, dq=dq, vx=0.5 * FULL), 16)).force[-1, 0]
            for steps, dq in ((6, 1.0), (12, 0.5))
        ]
        ends.append(np.abs([forces[1] - steady, 2 * forces[1] - forces[0] - steady]) / 0.3)
    assert ends[0][0] > 0.05
    assert ends[0][1] < 3e-3
    assert ends[0][1] < ends[1][1] / 2


def test_full_slip():
    """Whatever was before, and under any load, all that friction carries: nothing turns slip where nu = 0."""
    scene = history(2.0, steps=3, dq=0.3, vx=[FULL, 20 * FULL, -40 * FULL], normal_force=[1.0, 0.5, 1.3])
    found = corrected(on(replace(scene, bodies=vc.Bodies(G=1.0, nu=0.0)), 16))
    np.testing.assert_allclose(found.force[1:, 0], [-0.3 * 0.5, 0.3 * 1.3], rtol=1e-9)
    assert np.all(found[2].refinement.change < 1e-9)


@pytest.mark.parametrize(
    ("posed", "gain"),
    [
        (history(1.0, steps=3, dq=0.4, vx=0.5 * FULL, spin=[0.6 * FULL, 0.6 * FULL, -0.6 * FULL]), 3),
        (history(0.5, steps=4, dq=0.0, ux=[0.4 * FULL, -0.6 * FULL, 0.5 * FULL, 0.2 * FULL], rotation=0.2 * FULL), 2),
        (history(2.5, steps=3, dq=0.3, vx=0.3 * FULL, vy=0.4 * FULL, normal_force=[1.0, 0.7, 0.9]), 1.5),
    ],
    ids=["spin turns", "to and fro", "load swings"],
)
def test_against_fine_histories(posed, gain):
    """Nearer than a plain grid, and within the estimate in every step."""
    truth, found = corrected(on(posed, 64)), corrected(on(posed, 16))
    errors, plain = off(found, truth), off(vc.solve(on(posed, 16), certify=None), truth)
    assert errors.max() < plain.max() / gain
    assert np.all(errors < [step.error_estimate.largest for step in found])


def test_what_hardly_moves_settles():
    """Tractions that stick up to the edge, at which elements are cut: passes do not run away."""
    posed = history(1.0, steps=3, dq=0.07, vx=0.01 * FULL, spin=-0.05 * FULL, normal_force=[1.0, 1.3, 1.2])
    found, plain = corrected(on(posed, 16)), vc.solve(on(posed, 16), certify=None)
    limit = 0.02 * np.abs(found.force[:, 0])
    assert np.all(np.array([step.refinement.change[0] for step in found]) < limit)
    assert np.all(np.abs(found.force[:, 0] - plain.force[:, 0]) < 3 * limit)


@pytest.mark.parametrize("factor", [1e-3, 1e5])
def test_units(rolled, factor):
    """Lengths and moduli in other units: the same numbers in these."""
    length, modulus = factor, 3.0 / factor
    force, motion = modulus * length**2, ROLLING.motion
    motion = replace(
        motion,
        dq=[dq * length for dq in motion.dq],
        Fx=[F * force for F in motion.Fx],
        spin=motion.spin / length,
    )
    axes = ROLLING.hertz.a * length, ROLLING.hertz.b * length
    bodies, surface = vc.Bodies(G=modulus, nu=0.28), vc.Ellipse(*axes)
    other = corrected(replace(ROLLING, bodies=bodies, surface=surface, normal_force=force, motion=motion))
    np.testing.assert_allclose(other.force / force, rolled.force, atol=1e-8)
    np.testing.assert_allclose(other.creepage[1:, 0], rolled.creepage[1:, 0], rtol=1e-6)
    for one, step in zip(other, rolled, strict=True):
        assert one.error_estimate.errors == pytest.approx(step.error_estimate.errors, rel=1e-3, abs=1e-7)


@pytest.mark.parametrize("along_x", [False, True])
def test_mirror_images(wild, along_x):
    """At y = 0; and at x = 0, where all roll the other way."""
    signs = {"vy": -1, "spin": -1, "rotation": -1}
    if along_x:
        signs = {"vx": -1, "ux": -1, "Fx": -1, "spin": -1, "rotation": -1, "direction": -1}
    turned = {name: [None if v is None else sign * v for v in getattr(WILD, name)] for name, sign in signs.items()}
    other = corrected(replace(wild.scene, motion=replace(WILD, **turned)))
    np.testing.assert_allclose(other.force, wild.force * ([-1, 1] if along_x else [1, -1]), atol=1e-8)
    np.testing.assert_allclose(other.moment, -wild.moment, atol=1e-8)
    estimates = ([step.refinement.estimate for step in each] for each in (other, wild))
    np.testing.assert_allclose(*estimates, atol=1e-6)


def test_each_step_has_its_field(wild):
    """Forces are the field's, the field is within its bound, and the certificate that of the corrected problem."""
    for step in wild:
        found, friction = step.refinement, step.scene.friction
        assert found.passes == 2
        np.testing.assert_allclose(step.force, found.traction.sum(axis=(1, 2)) * found.grid.area, rtol=1e-12)
        bound = friction * step.scene.hertz.mean_pressure(*found.grid.lines)
        assert np.all(np.hypot(*found.traction) <= bound * (1 + 1e-12))
        assert step.certificate.residual < 1e-8
        assert np.all(found.estimate >= found.change)


def test_an_estimate_lasts_as_long_as_its_particles(wild):
    """What is left of that of the step before is the part of the contact that has not been rolled over."""
    for before, step in itertools.pairwise(wild):
        length = (step.pressure > 0).any(axis=0).sum() * step.grid.sides[0]
        still = max(1 - step.scene.motion.dq / length, 0.0)
        assert np.all(step.refinement.estimate >= still * before.refinement.estimate * (1 - 1e-12))


def test_after_a_step_without_contact_all_begins_anew():
    scene = history(1.0, steps=3, dq=0.2, vx=0.5 * FULL, normal_force=[1.0, 0.0, 1.0])
    whole, alone = corrected(on(scene, 16)), corrected(on(history(1.0, steps=1, dq=0.2, vx=0.5 * FULL), 16))
    assert not whole[1].force.any() and not whole[1].refinement.traction.any()
    assert whole[1].error_estimate.errors == {}
    np.testing.assert_allclose(whole.force[2], alone.force[0], rtol=1e-12)
    assert "those of a field" not in whole[1].report()


def test_pressures_that_are_solved_for(tmp_path):
    """Hertz's contact with its pressure solved for: the same history, and files keep its bound."""
    posed = on(history(1.0, steps=2, dq=0.4, vx=0.4 * FULL, vy=0.2 * FULL, normal_force=[1.0, 1.2]), 16)
    closed, solved = corrected(posed), corrected(posed, normal="newton")
    np.testing.assert_allclose(solved.force, closed.force, atol=2e-3 * 0.3)
    solved.save(tmp_path / "solved.nc")
    again = vc.load(tmp_path / "solved.nc")
    assert [step.note for step in again] == ["", ""]
    np.testing.assert_array_equal(again[1].refinement.share, solved[1].refinement.share)


def test_friction_by_element(rolled):
    """The same coefficient in all elements is the same as a number, on half as many elements, too."""
    grid = rolled.grid
    found = vc.solve(replace(ROLLING, friction=np.full(grid.shape, 0.3), grid=grid), refine="continuum")
    np.testing.assert_allclose(found.force, rolled.force, atol=1e-10)
    for one, step in zip(found, rolled, strict=True):
        np.testing.assert_allclose(one.refinement.estimate, step.refinement.estimate, atol=1e-8)


def test_line_contact():
    """Nearer than plain strips, and within the estimate."""
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Cylinders(R=1.0, reference_depth=5.0),
        normal_force=0.01,
        friction=0.3,
        motion=vc.Transient(steps=3, dq=0.02, vx=[0.02, 0.02, -0.01], vy=0.01, normal_force=[0.01, 0.012, 0.01]),
    )
    truth, plain, found = corrected(on(scene, 256)), vc.solve(on(scene, 32), certify=None), corrected(on(scene, 32))
    assert found[0].refinement.cells == (1, 2)
    errors = off(found, truth)
    assert errors.max() < off(plain, truth).max()
    assert np.all(errors < [step.error_estimate.largest for step in found])


def test_a_file_keeps_all_of_it(rolled, tmp_path):
    """Fields, passes and estimates; steps are measured again as corrected problems, alone or in their history."""
    rolled.save(tmp_path / "rolled.nc")
    again = vc.load(tmp_path / "rolled.nc")
    assert again.error_estimate == rolled.error_estimate
    for step, was in zip(again, rolled, strict=True):
        assert step.note == ""
        np.testing.assert_array_equal(step.refinement.traction, was.refinement.traction)
        np.testing.assert_array_equal(step.refinement.estimate, was.refinement.estimate)
        assert step.report() == was.report()
    assert again.to_xarray()["traction_on_parts"].shape == (3, *rolled[0].refinement.traction.shape)
    rolled[2].save(tmp_path / "step.nc")
    assert vc.load(tmp_path / "step.nc").note == ""
    assert vc.load(tmp_path / "rolled.nc", certify=False)[1].note.startswith("the certificate is as stored")


def test_a_file_that_was_changed_is_noticed(rolled, tmp_path):
    """Slips and tractions of a step that do not go together."""
    steps = [*rolled[:2], replace(rolled[2], slip=2 * rolled[2].slip)]
    replace(rolled, solutions=steps).save(tmp_path / "changed.nc")
    again = vc.load(tmp_path / "changed.nc")
    assert again[1].note == ""
    with pytest.raises(vc.OutputError, match="slips that are not those under its tractions"):
        len(again[2].force)  # it is measured as it is read


def test_interrupted_and_gone_on_with(rolled, tmp_path):
    """The same, bit for bit, though the march on half as many elements begins anew."""

    def stop(words):
        if words.startswith("2 of"):
            raise KeyboardInterrupt

    path = tmp_path / "store.nc"
    with pytest.raises(vc.Interrupted) as stopped:
        vc.solve(ROLLING, refine="continuum", store=path, progress=stop)
    assert len(stopped.value.partial) == 2
    with pytest.raises(vc.OutputError, match="holds the history of another scene, or by other methods"):
        vc.solve(ROLLING, store=path)
    whole = vc.solve(ROLLING, refine="continuum", store=path)
    np.testing.assert_array_equal(whole.force, rolled.force)
    for step, was in zip(whole, rolled, strict=True):
        np.testing.assert_array_equal(step.refinement.traction, was.refinement.traction)
        np.testing.assert_array_equal(step.refinement.estimate, was.refinement.estimate)


def test_steps_of_an_element():
    """Without a length a step is an element of the grid, on half as many elements, too."""
    own = corrected(on(history(1.0, steps=2, vx=0.5 * FULL), 16))
    given = corrected(replace(own.scene, motion=replace(own.scene.motion, dq=own.grid.sides[0])))
    for one, other in zip(own, given, strict=True):
        np.testing.assert_array_equal(one.refinement.forces, other.refinement.forces)
        np.testing.assert_array_equal(one.refinement.estimate, other.refinement.estimate)


def test_words(rolled):
    """Reports and summaries say whose forces these are, and how sure."""
    text, last = rolled.report(), rolled[-1].report()
    assert "Against the continuum, with steps of this length, about: Fy to" in text
    assert "forces and moment are those of a field on 2 x 2 parts of each element, after 2 passes" in last
    assert "or that of the step before, as far as" in " ".join(last.split())
    summary = json.loads(json.dumps(rolled.summary(), allow_nan=False))
    assert set(summary["error_estimate"]["errors"]) == {"ux[0]", "Fy[0]", "Mz[0]"} | {
        f"{name}[{k}]" for name in ("vx", "Fy", "Mz") for k in (1, 2)
    }
    assert summary["last"]["refinement"]["error_estimate"] == rolled[-1].refinement.estimate.tolist()
    seconds = sum(step.refinement.seconds[k] for step in rolled for k in range(2))
    assert rolled.error_estimate.solves == (Solve(16, 16, pytest.approx(seconds)),)


def test_a_history_solved_as_a_whole_counts_its_solves_once():
    """Those of an accuracy are of all steps."""
    solves = (Solve(8, 8, 1.0), Solve(16, 16, 2.0))
    steps = [ErrorEstimate({"Fx": 1.0}, {"Fx": 0.1}, "so", solves) for _ in range(3)]
    assert ErrorEstimate.of_history(steps).solves == solves


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"friction": vc.StaticKinetic(0.3, 0.2)}, "for friction that is a number, not for laws of friction; leave"),
        ({"friction": np.inf}, "with infinite friction it is for steady rolling; solve on several grids"),
        ({"friction": 0.0, "motion": vc.Transient(steps=2, vx=0.1)}, "without friction there is nothing to correct"),
        ({"bodies": vc.Bodies(G=(1.0, 2.0), nu=(0.2, 0.3))}, "it is for quasi-identical bodies, and here K ="),
        ({"grid": vc.Grid(nx=16, ny=15)}, "at least 16 elements across the contact each way; here it has 16 by 15"),
        ({"grid": vc.Grid(nx=16, ny=16, edge="touched")}, 'with grid.edge = "touched" it gains less, or loses'),
    ],
)
def test_refused_before_any_work(monkeypatch, changes, words):
    monkeypatch.setattr("varcontact.solving.defect_correction.march.PartsMarch.problem", None)
    with pytest.raises(vc.SceneError) as refused:
        vc.solve(replace(ROLLING, **changes), refine="continuum")
    assert words in str(refused.value)


def test_a_start_is_refused():
    """It has no tractions on the parts; the steps that led to it do."""
    start = vc.solve(replace(ROLLING, motion=vc.Steady(vx=0.1)), certify=None)
    scene = replace(ROLLING, motion=replace(ROLLING.motion, start=start))
    with pytest.raises(vc.SceneError, match=r"motion.start has no tractions on parts .* leave motion.start out"):
        vc.solve(scene, refine="continuum")


def test_a_force_beyond_friction_is_named_with_its_step():
    scene = on(history(1.0, steps=2, dq=0.1, Fx=[0.1, 0.31], normal_force=[1.0, 0.9]), 16)
    with pytest.raises(vc.Saturated, match="cannot be carried"):
        vc.solve(scene, refine="continuum")


def test_the_command(tmp_path):
    (tmp_path / "history.toml").write_text(
        "normal_force = 1.0\nfriction = 0.3\n[bodies]\nG = 1.0\nnu = 0.28\n"
        '[surface]\nkind = "ellipse"\na = 1.0\nb = 0.7\n[grid]\nnx = 16\nny = 16\n'
        '[motion]\nkind = "transient"\nsteps = 2\ndq = 0.3\nvx = 0.1\n[solve]\nrefine = "continuum"\n'
    )
    done = run("solve", "history.toml", "--json", "--out", "history.nc", folder=tmp_path)
    told = json.loads(done.stdout)
    assert told["last"]["refinement"]["passes"] == 2
    assert vc.load(tmp_path / "history.nc").force.tolist() == told["force"]
    (tmp_path / "plain.toml").write_text((tmp_path / "history.toml").read_text().partition("[solve]")[0])
    done = run("solve", "plain.toml", "--json", "--refine", "continuum", folder=tmp_path)
    assert json.loads(done.stdout)["force"] == told["force"]


def test_tractions_that_reverse_pass_through_zero():
    """Between slip and stick: a vector that turns keeps its size, one that reverses does not."""
    ones, parts = np.ones((1, 2)), np.ones((1, 4))
    shapes = Shape(ones, ones), Shape(parts, parts)
    reversed_ = reconstructed(np.array([[[1.0, -0.5]], [[0.0, 0.0]]]), *shapes, (1, 2))
    np.testing.assert_allclose(reversed_[0, 0], [1.0, 0.625, -0.125, -0.5])
    turned = reconstructed(np.array([[[1.0, 0.8]], [[0.0, 0.2]]]), *shapes, (1, 2))
    size = np.hypot(*np.array([0.8, 0.2]))
    np.testing.assert_allclose(np.hypot(*turned)[0], [1.0, 0.75 + 0.25 * size, 0.25 + 0.75 * size, size])


def test_bounds_by_the_mean_pressure_in_steps():
    """An element whose centre is just inside bears what its parts do, and all together the same load."""
    posed = on(history(1.0, steps=1, dq=0.0, ux=0.1), 9)
    grid = vc.Grid(nx=9, ny=9).spread((-1.0, 1.0, -1.0, 1.0))
    for motion, same in ((vc.Shift(ux=0.1), False), (vc.Steady(vx=0.1), True)):
        disc = discretise(replace(posed, motion=motion, grid=grid), grid)
        state = hertz_pressure(disc, unloaded(grid))
        share = shares(disc, state, None)
        assert np.all(share == 1) == same
        assert (share * state.pressure).sum() == pytest.approx(state.pressure.sum(), rel=1e-12)
        if not same:
            mean = posed.step(0, grid).hertz.mean_pressure(*grid.lines) * (state.pressure > 0)
            np.testing.assert_allclose(share * state.pressure / state.pressure.sum(), mean / mean.sum(), atol=1e-15)


def test_only_the_steps_have_loads():
    """A history whose scene has no load of its own is that with the load of a step, corrected and to an accuracy."""
    steps = vc.Transient(steps=3, dq=0.3, vx=0.05, normal_force=[1.0, 0.0, 0.7])
    shared = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Paraboloids(Rx=1.0, Ry=0.7),
        normal_force=1.0,
        friction=0.3,
        motion=steps,
        grid=vc.Grid(nx=16, ny=16),
    )
    own = replace(shared, normal_force=None)
    assert own.hertz is None
    assert np.array_equal(corrected(own).force, corrected(shared).force)
    to_accuracy = [vc.solve(replace(scene, grid="auto"), accuracy=0.05) for scene in (own, shared)]
    assert np.array_equal(to_accuracy[0].force, to_accuracy[1].force)
    assert to_accuracy[0].error_estimate.largest <= 0.05
