"""Solutions to an accuracy: against closed forms, in any units, mirrored; their estimate, files,
words and refusals.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.command import run, scene_file
from tests.scenes import in_units, make_scene, refused
from varcontact.errors import NotConverged
from varcontact.reference import carter, line_contact
from varcontact.results.quantities_of_interest import error, units, values
from varcontact.solvers.interface import check_time
from varcontact.solving import adaptive

BODIES = vc.Bodies(G=1.0, nu=0.28)
ROLLING = make_scene(
    vc.Ellipse(a=1.0, b=0.7), 1.0, vc.Steady(vx=0.15, vy=-0.1, spin=0.2), bodies=BODIES
)


def line(vx, **changes):
    scene = vc.Scene(
        bodies=BODIES,
        surface=vc.Cylinders(1.0),
        normal_force=0.01,
        friction=0.3,
        motion=vc.Steady(vx=vx),
    )
    return replace(scene, **changes)


@pytest.mark.parametrize("accuracy", [0.03, 0.001])
@pytest.mark.parametrize("part", [0.1, 0.5, 0.9])
def test_carters_force_is_met(accuracy, part):
    contact = line_contact(1.0, BODIES, force=0.01)
    scene = line(0.3 * contact.a * part)
    exact = carter(contact, 0.3, creepage=scene.motion.vx).force
    sol = vc.solve(scene, accuracy=accuracy)
    assert abs(sol.force[0] - exact) <= accuracy * 0.3 * 0.01
    assert sol.error_estimate.errors["Fx"] <= accuracy


@pytest.mark.parametrize("accuracy", [0.03, 0.003])
def test_the_creepage_of_a_prescribed_force_is_carters(accuracy):
    contact = line_contact(1.0, BODIES, force=0.01)
    exact = carter(contact, 0.3, creepage=0.2 * contact.a)
    sol = vc.solve(line(0.0, motion=vc.Steady(Fx=exact.force)), accuracy=accuracy)
    assert abs(sol.creepage[0] - 0.2 * contact.a) <= accuracy * units(sol)["vx"]
    assert sol.creepage[0] == sol.error_estimate.values["vx"]


@pytest.mark.parametrize("accuracy", [0.1, 0.01])
@pytest.mark.parametrize(("a", "b"), [(20.0, 1.0), (1.0, 20.0), (1.0, 200.0)])
def test_the_shift_of_a_slender_contact_is_cattaneos(a, b, accuracy):
    """With nu = 0 a traction moves as a pressure does: what lacks in full slip is Hertz's, of a
    lesser load.
    """
    scene = replace(ROLLING, surface=vc.Ellipse(a=a, b=b), bodies=vc.Bodies(G=1.0, nu=0.0))
    exact = -0.3 * scene.hertz.approach * (1 - (1 - 0.2 / 0.3) ** (2 / 3))
    sol = vc.solve(replace(scene, motion=vc.Shift(Fx=0.2)), accuracy=accuracy)
    assert abs(sol.creepage[0] - exact) <= accuracy * units(sol)["ux"]
    assert sol.error_estimate.largest <= accuracy


@pytest.mark.long
def test_the_estimate_is_that_of_richardsons_steps():
    """Solved again on its last three grids: the rule of the module, computed by hand."""
    scene = replace(ROLLING, surface=vc.Ellipse(a=1.0, b=0.2), motion=vc.Steady(vx=0.3, spin=0.3))
    estimate = vc.solve(scene, accuracy=0.003).error_estimate
    grids = [vc.Grid(nx=each.nx - 2, ny=each.ny - 2) for each in estimate.solves[-3:]]
    n = np.array([grid.ny for grid in grids])
    Fx = np.array([vc.solve(replace(scene, grid=grid).second_order()).force[0] for grid in grids])
    steps = np.diff(Fx) / ((n[1:] / n[:-1]) ** 1.5 - 1)
    assert [grid.nx for grid in grids] == [round(1.5 * each) for each in n]
    assert estimate.values["Fx"] == pytest.approx(Fx[2] + steps[1] / 2, abs=1e-6)
    largest = max(abs(steps[1]), abs(steps[0]) * (n[1] / n[2]) ** 1.5)
    assert estimate.errors["Fx"] == pytest.approx(
        1.25 * largest / 0.3 + 0.4 / n[2] ** 1.5, rel=1e-3
    )
    assert estimate.bars["Fx"] == pytest.approx(0.3 * estimate.errors["Fx"])


def test_full_slip_is_exact_on_the_coarsest_grids():
    sol = vc.solve(replace(ROLLING, motion=vc.Steady(vx=30.0)), accuracy=0.01)
    assert sol.force == pytest.approx([-0.3, 0.0], abs=1e-7)
    assert len(sol.error_estimate.solves) == 3


def test_hertz_needs_no_grid():
    sol = vc.solve(replace(ROLLING, motion=None, friction=None), accuracy=1e-9)
    assert sol.error_estimate.largest == 0 and len(sol.error_estimate.solves) == 1
    assert sol.error_estimate.values["peak_pressure"] == ROLLING.hertz.peak_pressure


def test_computed_pressure_converges_to_hertz():
    x = np.linspace(-1.5, 1.5, 61)
    surface = vc.SampledDistance(0.5 * (x[None, :] ** 2 + 1.4 * x[:, None] ** 2), x=x, y=x)
    scene = vc.Scene(bodies=BODIES, surface=surface, normal_force=1.0)
    exact = replace(scene, surface=vc.Paraboloids(Rx=1.0, Ry=1 / 1.4)).hertz
    for accuracy in (0.03, 0.01, 0.003):
        sol = vc.solve(scene, accuracy=accuracy)
        assert abs(sol.approach / exact.approach - 1) <= accuracy
        assert abs(sol.error_estimate.values["peak_pressure"] / exact.peak_pressure - 1) <= accuracy


@pytest.mark.parametrize(
    ("length", "stress", "motion"),
    [
        (1e-3, 1e12, ROLLING.motion),
        (1e3, 1e-6, vc.Steady(Fx=-0.1, spin=0.1)),
        (1e3, 1e-6, vc.Shift(Fx=-0.1)),
    ],
)
def test_units_do_not_matter(length, stress, motion):
    scene = replace(ROLLING, motion=motion)
    one, other = (
        vc.solve(each, accuracy=0.02) for each in (scene, in_units(scene, length, stress))
    )
    assert other.force / (stress * length**2) == pytest.approx(one.force, rel=1e-6, abs=1e-9)
    assert other.error_estimate.errors == pytest.approx(one.error_estimate.errors, rel=1e-4)
    assert [s.nx for s in other.error_estimate.solves] == [s.nx for s in one.error_estimate.solves]


@pytest.mark.long
def test_the_estimate_is_told_and_kept(tmp_path):
    sol = vc.solve(ROLLING, accuracy=0.01)
    estimate = sol.error_estimate
    assert "accuracy" in sol.report() and " ".join(estimate.how.split()[:4]) in sol.report()
    assert sol.summary()["error_estimate"]["errors"] == estimate.errors
    Fx, Fy, Mz = (f"{name} to {estimate.errors[name]:.1e}" for name in ("Fx", "Fy", "Mz"))
    assert f"the continuum: {Fx}, {Fy} of f Fz; {Mz} of f Fz sqrt(ab)\n" in sol.report()
    pulled = vc.solve(replace(ROLLING, motion=vc.Steady(Fx=-0.1)), accuracy=0.02)
    assert f"vx to {pulled.error_estimate.errors['vx']:.1e} of saturation" in pulled.report()
    sol.save(tmp_path / "rolling.nc")
    again = vc.load(tmp_path / "rolling.nc")
    assert again.error_estimate == estimate
    assert again.force.tolist() == sol.force.tolist() and again.moment == sol.moment
    assert vc.solve(replace(ROLLING, grid=vc.Grid(nx=8, ny=8))).error_estimate is None


@pytest.mark.long
@pytest.mark.parametrize(
    ("changes", "options"),
    [
        ({"motion": vc.Steady(Fx=-0.15, vy=0.1)}, {}),
        ({"motion": vc.Shift(Fx=-0.15)}, {}),
        (
            {"motion": None, "friction": None, "surface": vc.Paraboloids(Rx=1.0, Ry=1.0)},
            {"normal": "norm"},
        ),
    ],
)
def test_a_file_is_measured_by_the_values_of_its_grid(tmp_path, changes, options):
    sol = vc.solve(replace(ROLLING, **changes), accuracy=0.01, **options)
    sol.save(tmp_path / "answer.nc")
    again = vc.load(tmp_path / "answer.nc")
    assert again.note == "" and again.converged
    assert (again.creepage, again.approach) == (sol.creepage, sol.approach)
    assert again.error_estimate == sol.error_estimate != replace(sol.error_estimate, on_grid={})


@pytest.mark.long
def test_unlike_bodies_whose_error_falls_slowly():
    """Fx from 243 elements across and half of the step from 162, by the order 1: +-0.0006 f Fz."""
    scene = vc.Scene(
        bodies=vc.Bodies((1.0, 0.04087), (0.03696, 0.25885)),
        surface=vc.Paraboloids(0.27286, 1.23142),
        normal_force=0.002984,
        friction=0.39674,
        motion=vc.Steady(vx=0.030654, vy=-0.011728, spin=-0.27884),
    )
    limit = 0.39674 * 0.002984
    for accuracy in (0.03, 0.01):
        sol = vc.solve(scene, accuracy=accuracy)
        assert abs(sol.force[0] / limit - 0.1949) < sol.error_estimate.errors["Fx"] <= accuracy


@pytest.mark.long
@pytest.mark.parametrize("base", ["rigid", (0.2, 0.1)])
def test_layered_bodies_are_unlike_by_their_surfaces(base):
    layered = vc.Layered(layers=[vc.Layer(0.5, 0.3, 0.2)], base=base)
    scene = replace(
        ROLLING, bodies=(layered, vc.Bodies(G=1.0, nu=0.4)), surface=vc.Paraboloids(1.0, 1.0)
    )
    scene = replace(scene, normal_force=1e-2)
    coarse, fine = (vc.solve(scene, accuracy=accuracy) for accuracy in (0.1, 0.03))
    found, exact = values(coarse), values(fine)
    bars = coarse.error_estimate.bars
    assert all(abs(found[name] - exact[name]) <= bars[name] for name in found)
    assert adaptive._unlikeness(scene) == abs(scene.bodies.surfaces.K) > 0


def test_an_error_that_does_not_fall_is_seen():
    def known(*errors):
        return [vc.ErrorEstimate({}, {"Fx": error}, "", ()) for error in errors]

    assert adaptive.stalled(known(0.03, 0.1, 0.1, 0.095))
    assert not adaptive.stalled(known(0.1, 0.08, 0.11)) and not adaptive.stalled(known(0.1, 0.1))


@pytest.mark.long
def test_grids_end_where_the_error_does_not_fall(monkeypatch):
    """Of a given accuracy that is an error with the best answer; by default an answer with its
    bar.
    """
    monkeypatch.setattr(adaptive, "FLOOR", 0.0)
    monkeypatch.setattr(
        adaptive, "richardson", lambda values, across, order: (values[-1], 0.1 * abs(values[-1]))
    )
    with pytest.raises(NotConverged, match="and it does not fall with the grid") as failed:
        vc.solve(ROLLING, accuracy=0.003)
    assert len(failed.value.solution.error_estimate.solves) == 5
    known = vc.solve(ROLLING)
    assert known.error_estimate.how.endswith("it does not fall with the grid")
    assert "it does not fall with the grid" in " ".join(known.report().split())


def test_a_time_budget_that_coarse_grids_exceed_is_refused(monkeypatch, clock):
    """A second each, of which the third does not end: two seconds are allowed."""
    solve = adaptive._solved

    def slow(scene, options, *rest):
        clock.now += 2.0
        check_time(options.deadline)
        return solve(scene, options, *rest)

    monkeypatch.setattr(adaptive, "_solved", slow)
    refused(
        lambda: vc.solve(ROLLING, time_budget=0.5),
        words="even the coarsest grids, which tell the error, take longer",
    )
    assert clock.now < 1.5 * 0.5 + 2.0 + 2.0


def test_the_largest_pressure_has_a_bar_and_does_not_count():
    """Sampled paraboloids: Hertz's is within it."""
    x = np.linspace(-1.5, 1.5, 41)
    surface = vc.SampledDistance(h=(x**2 + x[:, None] ** 2) / 2, x=x, y=x)
    scene = replace(ROLLING, surface=surface, normal_force=0.5)
    sol = vc.solve(scene, accuracy=0.02)
    estimate = sol.error_estimate
    exact = replace(scene, surface=vc.Paraboloids(Rx=1.0, Ry=1.0), motion=None).hertz.peak_pressure
    assert "peak_pressure" not in estimate.errors
    assert abs(sol.max_pressure - exact) < estimate.bars["peak_pressure"] < 0.05 * exact


def test_a_largest_pressure_without_a_limit_is_doubted():
    """A roller whose end is a step: with elements half as large its pressure grows by sqrt(2), with
    a rounded end it stays.
    """
    x = np.linspace(-1.2, 1.2, 241)

    def solved(end, **grid):
        h = x**2 / 2 + np.where(np.abs(x[:, None]) < 0.4, x[:, None] ** 2 / 20, end(x[:, None]))
        surface = vc.SampledDistance(h=h, x=x, y=x)
        return vc.solve(replace(ROLLING, surface=surface, normal_force=0.3, **grid))

    def step(y):
        return 0.0 * y + 1.0

    coarse, fine = (solved(step, grid=vc.Grid(nx=n, ny=n)).max_pressure for n in (40, 80))
    assert fine / coarse == pytest.approx(2**0.5, rel=0.2)
    (words,) = (each for each in solved(step).warnings if "largest pressure" in each)
    assert "% only; if a body ends within the contact, it has no limit" in words
    rounded = solved(lambda y: y**2 / 20 + 5 * (np.abs(y) - 0.4) ** 2)
    assert not any("largest pressure" in each for each in rounded.warnings)


def test_a_little_time_gives_three_coarse_grids():
    sol = vc.solve(ROLLING, time_budget=1e-9)
    assert [solve.ny - 2 for solve in sol.error_estimate.solves] == [4, 6, 9]
    fine = vc.solve(ROLLING, accuracy=0.003)
    assert error(values(sol), values(fine), units(fine)) <= sol.error_estimate.largest


def test_time_is_used(clock):
    """More than a third of it, and no more than it: the next grid would take 2.6 times as long as
    the last.
    """
    sol = vc.solve(ROLLING, time_budget=0.3)
    assert len(sol.error_estimate.solves) > 3 and sol.error_estimate.largest < 0.01
    assert 0.1 < clock.now <= 0.3
    assert sol.error_estimate.time_budget == 0.3 and sol.error_estimate.accuracy is None


@pytest.mark.parametrize(
    ("changes", "options", "words"),
    [
        ({}, {"accuracy": 0.0}, "accuracy = 0.0 is not allowed: must be a positive, finite number"),
        ({}, {"accuracy": "fine"}, "accuracy = 'fine' is not allowed"),
        ({}, {"time_budget": -1.0}, "time_budget = -1.0 is not allowed: must be a positive"),
        ({}, {"accuracy": 0.01, "time_budget": 1.0}, "left out where accuracy is given"),
        (
            {"grid": vc.Grid(nx=8, ny=8)},
            {"accuracy": 0.01},
            "left out: it is chosen for the accuracy",
        ),
        ({"friction": np.inf}, {"accuracy": 0.01}, "errors are measured by the friction limit"),
        (
            {"motion": vc.Steady(vx=0.1, dq=0.1)},
            {"accuracy": 0.01},
            "left out: the step is chosen for the accuracy",
        ),
        (
            {},
            {"accuracy": 0.1, "tangential": "fastsim"},
            "a theory has an error that no grid removes",
        ),
        (
            {},
            {"accuracy": 0.1, "formulation": "marching"},
            "left out: with accuracy the slip is of second order",
        ),
        ({"motion": vc.Steady(Fx=0.31)}, {"accuracy": 0.01}, "cannot be carried"),
        (
            {"surface": vc.Cylinders(1.0), "motion": vc.Shift(ux=0.0, Fy=0.1)},
            {"accuracy": 0.01},
            "reference_depth is missing with accuracy: in line contact the shift for motion.Fy is known but for a",
        ),
    ],
)
def test_refusals(changes, options, words):
    refused(
        lambda: vc.solve(replace(ROLLING, **changes), **options),
        words=words,
        error=vc.VarcontactError,
    )


def test_all_of_the_friction_limit_is_no_accuracy():
    """Refused by all that take an accuracy, in the same words; 0.99 is none to boast of, but
    one.
    """
    accuracy, words = 1.0, "must be below 1"
    history = replace(ROLLING, motion=vc.Transient(steps=2, dq=0.1, vx=0.1))
    for asked in (
        lambda: vc.solve(ROLLING, accuracy=accuracy),
        lambda: vc.solve(history, accuracy=accuracy),
        lambda: vc.scan(ROLLING, [(0.1, 0.0, 0.0)], accuracy=accuracy),
        lambda: vc.compare(ROLLING, ["tang"], accuracy=accuracy),
    ):
        refused(asked, "accuracy", words)
    assert vc.solve(ROLLING, accuracy=0.99).error_estimate.largest <= 0.99


def test_what_does_not_fit_is_refused_with_what_does():
    with pytest.raises(vc.TooLarge) as refused:
        vc.solve(ROLLING, accuracy=1e-13)
    assert "accuracy = 1e-13 needs about" in str(refused.value) and "fits" in str(refused.value)


SCENE_FILE = scene_file("vx = 0.15", (1.0, 0.7)).split("[grid]")[0]


@pytest.mark.long
def test_the_command_and_the_table_of_a_file(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE_FILE)
    (tmp_path / "to.toml").write_text(SCENE_FILE + "[solve]\naccuracy = 0.01\n")
    by_option = run("solve", "scene.toml", "--accuracy", "0.01", "--json", folder=tmp_path)
    by_table = run("solve", "to.toml", "--json", folder=tmp_path)
    for done in (by_option, by_table):
        estimate = json.loads(done.stdout)["error_estimate"]
        assert estimate["accuracy"] == 0.01 and max(estimate["errors"].values()) <= 0.01
    refused = run("solve", "to.toml", "--time-budget", "1", folder=tmp_path)
    assert refused.returncode == 2 and "left out where accuracy" in " ".join(refused.stderr.split())


SLENDER = replace(ROLLING, surface=vc.Ellipse(a=1.0, b=0.03), motion=vc.Steady(vx=0.02, spin=0.3))
# whose estimate is above 1 % on 21 elements


@pytest.fixture
def failing(monkeypatch):
    """Solves fail with more than 30 elements across, as where equations have no solution."""
    solve = adaptive.solve_on_grid

    def solver(scene, *rest):
        if scene.grid.ny > 30:
            raise NotConverged("newton says 'MaxIterations'", 1e-3)
        return solve(scene, *rest)

    monkeypatch.setattr(adaptive, "solve_on_grid", solver)


def test_a_finer_grid_that_fails_leaves_the_answer_before_it(failing):
    with pytest.raises(
        NotConverged,
        match=r"accuracy = 0.01 is not reached: .*, of 32 elements across, fails: newton says",
    ) as failed:
        vc.solve(SLENDER, accuracy=0.01)
    known = failed.value.solution.error_estimate
    assert known.largest == failed.value.residual > 0.01
    assert [solve.ny - 2 for solve in known.solves] == [9, 14, 21]
    with pytest.raises(NotConverged, match=r"^newton says"):
        vc.solve(SLENDER, accuracy=0.001)


@pytest.mark.usefixtures("failing")
@pytest.mark.parametrize("options", [{"time_budget": 60.0}, {}], ids=["time_budget", "default"])
def test_in_a_time_and_by_default_too(options):
    known = vc.solve(SLENDER, **options).error_estimate
    assert [solve.ny - 2 for solve in known.solves][-3:] == [9, 14, 21] and known.largest > 0.01


# -------------------- Accuracy on demand against the reference scenes


CHOSEN = {
    name: each
    for k, (name, each) in enumerate(vc.continuum_values().items())
    if k % 5 == 0 and each.kind != "transient"
}


@pytest.mark.parametrize("name", CHOSEN)
def test_the_error_is_below_the_accuracy(name):
    reference = CHOSEN[name]
    sol = vc.solve(reference.scene, accuracy=0.01)
    assert reference.error(values(sol)) <= 0.01 + reference.bar
    assert sol.error_estimate.largest <= 0.01
