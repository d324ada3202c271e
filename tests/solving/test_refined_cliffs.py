"""Cliffs of samples: refused where estimates would fail, and nowhere else."""

import numpy as np
import pytest

import varcontact as vc
from tests.command import run
from varcontact.solving.defect_correction.cliffs import steepest_cliff

X = np.linspace(-1.0, 1.0, 81)
CLIFF = r"surface\.h has a cliff in the contact or next to it"


def bowl(x=X):
    """A sphere of radius 1, as samples: contacts below have a radius of 0.38."""
    return (x**2 + x[:, None] ** 2) / 2


def beyond(at, height=10.0, x=X):
    """The bowl with a step ahead of x = `at`."""
    return vc.SampledDistance(bowl(x) + np.where(x > at, height, 0.0), x, x)


def posed(surface, cells=16, **changes):
    """Rolling over samples."""
    entries = {
        "bodies": vc.Bodies(G=1.0, nu=0.28),
        "normal_force": 0.1,
        "friction": 0.3,
        "motion": vc.Steady(vx=0.03, vy=0.02, spin=0.05),
        "grid": vc.Grid(nx=cells, ny=cells),
    }
    return vc.Scene(surface=surface, **entries | changes)


def corrected(scene, **options):
    """Without bounds."""
    return vc.solve(scene, refine="continuum", certify=None, **options)


HOLE = np.where(np.hypot(X - 0.1, X[:, None]) < 0.1, 10.0, 0.0)
SLANTED = np.where(X + X[:, None] / 2 > 0.15, 1.0, 0.0)
STEP = np.where(X[:, None] > 0.13, 0.03, 0.0)


@pytest.mark.parametrize("added", [HOLE, SLANTED, STEP], ids=["hole", "slanted end", "step across"])
@pytest.mark.parametrize("motion", [vc.Steady(vx=0.03), vc.Shift(ux=0.01)])
@pytest.mark.parametrize("cells", [12, 24])
def test_cliffs_in_the_contact_are_refused(added, motion, cells):
    """The message says what was found and what to do."""
    surface = vc.SampledDistance(bowl() + added, X, X)
    with pytest.raises(vc.SceneError, match=CLIFF) as refusal:
        corrected(posed(surface, cells, motion=motion))
    assert refusal.value.field == "refine"
    assert "smooth the samples: smoothing = ... in the file, or .smoothed(...)" in str(refusal.value)


def test_where_it_is_and_how_high():
    """A flat with a step of 0.2 between 0.3 and 0.325, along x or along y; seen in an element beside it, too."""
    step, grid = np.where(X > 0.31, 0.2, 0.0), vc.Grid(nx=10, ny=10, dx=0.1, dy=0.1, x0=-0.5, y0=-0.5)
    flat = np.tile(step, (X.size, 1))
    along_x, along_y = (vc.SampledDistance(h, X, X) for h in (flat, flat.T))
    for surface, place in ((along_x, "x"), (along_y, "y")):
        found = steepest_cliff(surface, grid, np.ones((10, 10), dtype=bool))
        assert getattr(found, place) == pytest.approx(0.3125)
        np.testing.assert_allclose([found.height, found.over, found.slope], [0.2, 0.025, 2.0])
    for column, seen in ((5, False), (6, False), (7, True), (8, True), (9, True)):
        elements = np.zeros((10, 10), dtype=bool)
        elements[4, column] = True
        assert (steepest_cliff(along_x, grid, elements) is not None) == seen


@pytest.mark.parametrize("at", [-0.75, 0.75])
def test_cliffs_far_from_the_contact_change_nothing(at):
    """Beyond twelve samples the spline is that without them, but for what reaches through it."""
    far = vc.SampledDistance(bowl() + np.where(X * np.sign(at) > abs(at), 10.0, 0.0), X, X)
    with_it, without = (corrected(posed(surface)) for surface in (far, vc.SampledDistance(bowl(), X, X)))
    np.testing.assert_allclose(with_it.force, without.force, rtol=1e-7)
    np.testing.assert_allclose(with_it.refinement.estimate, without.refinement.estimate, rtol=1e-5)


def test_where_it_is_refused_the_estimate_fails(monkeypatch):
    """The end of a body: on some grid the error is beyond the estimate by far."""
    fine = [vc.solve(posed(beyond(0.3), cells), certify=None).force for cells in (104, 120)]
    monkeypatch.setattr("varcontact.solving.defect_correction.road.check_cliffs", lambda disc, state: None)
    ratios = []
    for cells in (16, 24, 32):
        sol = corrected(posed(beyond(0.3), cells))
        errors = np.abs(sol.force - fine).max(axis=1)
        ratios.append(errors.min() / sol.refinement.estimate[:2].max())
    assert max(ratios) > 1.5


@pytest.mark.parametrize("cells", [16, 24])
def test_small_steps_are_corrected(cells):
    """A step of a hundredth of the approach: the estimate holds."""
    truth, found = (corrected(posed(beyond(0.2, 1e-3), n)) for n in (72, cells))
    assert np.all(
        np.abs(found.force - truth.force) < found.refinement.estimate[:2].max() + truth.refinement.estimate[:2]
    )


def test_smoothed_samples_are_corrected():
    """What the message says helps: a step that is no part of the body, smoothed, has an estimate that holds."""
    x = np.linspace(-1.0, 1.0, 121)
    rough = beyond(0.2, 0.03, x)
    with pytest.raises(vc.SceneError, match=CLIFF):
        corrected(posed(rough))
    smooth = rough.smoothed(wavelength=0.2)
    found, truth = corrected(posed(smooth)), corrected(posed(smooth, 72))
    assert np.all(np.abs(found.force - truth.force) < found.refinement.estimate[:2].max())


def test_noise_is_warned_of_and_not_refused():
    """It steps everywhere."""
    rough = bowl() + 2e-3 * np.random.default_rng(1).normal(size=(X.size, X.size))
    found = corrected(posed(vc.SampledDistance(rough, X, X), 20))
    assert found.refinement is not None
    assert found.warnings[0].startswith("noise rules the pressure")


def test_kinks_and_waves_are_not_refused():
    """A roof, a change of curvature, waves of a few elements."""
    y = X[:, None]
    for added in (0.1 * np.abs(X), np.maximum(y, 0) ** 2, 1e-3 * np.sin(30 * X) * np.cos(20 * y)):
        corrected(posed(vc.SampledDistance(bowl() + added, X, X)))


def test_other_units_are_refused_alike():
    """Steps just below and just above the limit, G d / (pi (1 - nu) dx) of 0.3 times the mean pressure, in m and mm."""
    plain = vc.solve(posed(beyond(0.9), motion=None, friction=None))
    limit = 0.3 * plain.pressure[plain.pressure > 0].mean() * np.pi * 0.72 * plain.grid.sides[0]
    for factor, refused in ((0.8, False), (1.25, True)):
        for scale in (1.0, 1e3):
            surface = vc.SampledDistance(scale * beyond(0.1, factor * limit).h, scale * X, scale * X)
            scene = posed(surface, normal_force=0.1 * scale**2, motion=vc.Steady(vx=0.03))
            if refused:
                with pytest.raises(vc.SceneError, match=CLIFF):
                    corrected(scene)
            else:
                corrected(scene)


def line(height, cells=24, motion=None):
    """A cylinder with a step."""
    x = np.linspace(-1.0, 1.0, 161)
    surface = vc.SampledDistance(x**2 / 2 + np.where(x > 0.201, height, 0.0), x, reference_depth=5.0)
    return posed(surface, normal_force=0.25, motion=motion or vc.Steady(vx=0.03), grid=vc.Grid(nx=cells))


def test_line_contact():
    """Refused with its place along x; kept where it is small."""
    with pytest.raises(vc.SceneError, match=CLIFF + r".* over 0\.0125 at x = 0\.206\. Leave"):
        corrected(line(0.05))
    with pytest.raises(vc.SceneError, match=CLIFF):
        corrected(line(0.05, motion=vc.Shift(ux=0.01)))
    truth = vc.solve(line(1e-4, 1600), certify=None).force[0]
    found = corrected(line(1e-4, 32))
    assert abs(found.force[0] - truth) < found.refinement.estimate[0] + 1e-4 * 0.075


HISTORY = vc.Transient(steps=3, dq=0.05, vx=0.03, normal_force=[0.02, 0.05, 0.1])


@pytest.mark.parametrize(
    ("grid", "step"), [(vc.Grid(nx=20, ny=20), None), (vc.Grid(nx=24, ny=24, dx=0.04, dy=0.04, x0=-0.48, y0=-0.48), 1)]
)
def test_histories(grid, step):
    """Before any step, or, on a grid that is given, in the first one whose contact has the cliff."""
    with pytest.raises(vc.SceneError, match=CLIFF) as refusal:
        corrected(posed(beyond(0.31), grid=grid, motion=HISTORY, normal_force=None))
    assert refusal.value.step == step
    assert refusal.value.history is None or len(refusal.value.history) == step
    assert len(corrected(posed(beyond(0.6), grid=grid, motion=HISTORY, normal_force=None))) == 3


def test_command(tmp_path):
    """One line and no answer; without refine there is one."""
    posed(beyond(0.2)).save(tmp_path / "cliff.toml")
    refused = run("solve", tmp_path / "cliff.toml", "--refine", "continuum", folder=tmp_path)
    assert refused.returncode != 0
    assert "cliff in the contact" in refused.stderr
    assert "Traceback" not in refused.stderr
    assert run("solve", tmp_path / "cliff.toml", folder=tmp_path).returncode == 0


def test_samples_without_coordinates():
    """They are not known on parts of elements."""
    grid = vc.Grid(nx=40, ny=40, dx=0.05, dy=0.05, x0=-1.0, y0=-1.0)
    with pytest.raises(vc.SceneError, match=r"give surface\.x and surface\.y"):
        corrected(posed(vc.SampledDistance(bowl(grid.x)), grid=grid))
