"""Histories to an accuracy: against references and Cattaneo, in any units; estimates, files, words,
refusals.
"""

from dataclasses import replace

import pytest

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.reference import cattaneo_mindlin
from varcontact.results.quantities_of_interest import units, values

REFERENCES = {
    name: each for name, each in vc.continuum_values().items() if each.kind == "transient"
}
ROLLING = make_scene(
    vc.Ellipse(a=1.0, b=0.7), 1.0, vc.Transient(steps=3, dq=[0.0, 0.3, 0.3], Fx=-0.15, vy=0.05)
)


@pytest.mark.long
@pytest.mark.parametrize("name", REFERENCES)
def test_the_error_is_below_the_accuracy(name):
    reference = REFERENCES[name]
    history = vc.solve(reference.scene, accuracy=0.02)
    assert reference.error(values(history)) <= 0.02 + reference.bar
    assert history.error_estimate.largest <= 0.02


@pytest.mark.parametrize("accuracy", [0.03, 0.005])
def test_cattaneos_shift_to_and_fro(accuracy):
    """A force in place, then half of it: unloading is Cattaneo's problem with twice the
    friction.
    """
    scene = replace(ROLLING, surface=vc.Ellipse(a=1.0, b=1.0), bodies=vc.Bodies(G=1.0, nu=0.0))
    history = vc.solve(
        replace(scene, motion=vc.Transient(steps=2, dq=0.0, Fx=[0.2, 0.1])), accuracy=accuracy
    )
    loading = cattaneo_mindlin(scene.hertz, scene.bodies, 0.3, force=0.2).shift
    back = -cattaneo_mindlin(scene.hertz, scene.bodies, 0.6, force=0.1).shift
    allowed = accuracy * units(history)["ux[0]"]
    assert history[0].creepage[0] == pytest.approx(loading, abs=allowed)
    assert history[1].creepage[0] == pytest.approx(back, abs=allowed)


def test_the_estimate_is_told_and_kept(tmp_path):
    history = vc.solve(ROLLING, accuracy=0.03)
    estimate = history.error_estimate
    assert set(estimate.values) == {"ux[0]", "Fy[0]", "Mz[0]"} | {
        f"{name}[{k}]" for name in ("vx", "Fy", "Mz") for k in (1, 2)
    }
    assert history[1].creepage[0] == estimate.values["vx[1]"] != estimate.on_grid["vx[1]"]
    assert "Estimated errors against the continuum, with steps of this length" in history.report()
    assert history.summary()["error_estimate"]["errors"] == estimate.errors
    history.save(tmp_path / "history.nc")
    again = vc.load(tmp_path / "history.nc")
    assert again.error_estimate == estimate and [step.note for step in again] == [""] * 3
    assert again.force.tolist() == history.force.tolist()


@pytest.mark.long
def test_time_is_used(clock):
    history = vc.solve(ROLLING, time_budget=0.4)
    assert len(history.error_estimate.solves) > 3 and history.error_estimate.largest < 0.02
    assert 0.1 < clock.now <= 0.4


def test_without_friction_every_step_is_hertzs():
    motion = vc.Transient(steps=3, dq=0.1, normal_force=[1.0, 0.0, 2.0])
    scene = replace(
        ROLLING,
        surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
        normal_force=1.0,
        friction=0.0,
        motion=motion,
    )
    history = vc.solve(scene, accuracy=0.01)
    peaks = [history.error_estimate.values[f"peak_pressure[{k}]"] for k in range(3)]
    exact = [replace(scene, normal_force=F, motion=None).hertz.peak_pressure for F in (1.0, 2.0)]
    assert peaks == pytest.approx([exact[0], 0.0, exact[1]], rel=1e-12)
    assert history.error_estimate.largest == 0


@pytest.mark.parametrize(
    ("changes", "options", "words"),
    [
        (
            {"dq": None},
            {"accuracy": 0.01},
            "with accuracy the length of the steps is not an element's",
        ),
        (
            {},
            {"accuracy": 0.01, "store": "steps.nc"},
            "left out: with accuracy a history is solved on several grids",
        ),
    ],
)
def test_refusals(changes, options, words):
    refused(
        lambda: vc.solve(replace(ROLLING, motion=replace(ROLLING.motion, **changes)), **options),
        words=words,
    )


def test_a_step_with_little_load_has_elements_enough():
    """A contact a thirtieth as wide as the largest: the coarsest grids have no element's centre in
    it.
    """
    motion = vc.Transient(steps=3, dq=0.01, vx=0.1, normal_force=[1e-3, 3e-8, 1e-3])
    scene = replace(
        ROLLING, surface=vc.Paraboloids(Rx=1.0, Ry=1.0), normal_force=1e-3, motion=motion
    )
    history = vc.solve(scene, accuracy=0.05)
    assert history.error_estimate.largest <= 0.05 and history[1].pressure.any()
    assert abs(history[1].force[0]) <= 0.3 * 3e-8 * (1 + 1e-9)


def test_more_steps_than_fit_are_refused_before_any_is_solved(monkeypatch):
    monkeypatch.setattr("varcontact.system.process.available", lambda: 1e8)
    motion = vc.Transient(steps=10_000, dq=0.3, vx=0.1)
    with pytest.raises(vc.TooLarge, match=r"accuracy = 0\.001.*accuracy = .* fits"):
        vc.solve(replace(ROLLING, motion=motion), accuracy=0.001)


def test_a_start_has_its_own_grid():
    start = vc.solve(replace(ROLLING, motion=vc.Steady(vx=0.1), grid=vc.Grid(nx=8, ny=8)))
    scene = replace(ROLLING, motion=replace(ROLLING.motion, start=start))
    words = "with time_budget a history is solved on several grids, and it belongs to its own"
    refused(lambda: vc.solve(scene, time_budget=1.0), words=words)


def test_only_the_steps_have_loads():
    motion = vc.Transient(steps=3, dq=0.3, vx=0.05, normal_force=[1.0, 0.0, 0.7])
    scene = replace(ROLLING, surface=vc.Paraboloids(Rx=1.0, Ry=0.7), motion=motion)
    shared, own = (
        vc.solve(replace(scene, normal_force=load), accuracy=0.05) for load in (1.0, None)
    )
    assert (own.force == shared.force).all()
    assert own.error_estimate.largest <= 0.05
