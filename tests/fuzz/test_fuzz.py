"""Some cases of each campaign, by a fixed seed; the command runs as many as wanted."""

import dataclasses
import json
import warnings

import numpy as np
import pytest

import varcontact as vc
from tests.command import run
from tests.conditions import Held
from tests.fuzz import campaigns
from tests.fuzz.arguments import scene
from tests.fuzz.campaigns import bounded, outputs, within_gap
from tests.fuzz.extremes import Extreme, but, extremes
from tests.fuzz.judge import faults
from tests.fuzz.junk import Hostile
from tests.fuzz.outcome import FAILED, PASSED, attempt
from tests.scenes import make_scene, refusals, refused
from varcontact.discrete.certificate import ForceBounds
from varcontact.solving.coupling import distance

SEED = 20
CASES = {"scenes": 40, "certificates": 20, "files": 20, "flips": 20, "arguments": 20}
TWENTIES = [(campaign, first) for campaign, cases in CASES.items() for first in range(0, cases, 20)]


@pytest.fixture(autouse=True, scope="module")
def imports(sol, tmp_path_factory):
    """What a first refusal imports takes time that is not its own."""
    path = tmp_path_factory.mktemp("imports") / "saved.nc"
    sol.save(path)
    vc.load(path)


@pytest.mark.long
@pytest.mark.parametrize(("campaign", "first"), TWENTIES)
def test_random_cases(campaign, first):
    found = {
        number: attempt(getattr(campaigns, campaign), SEED, number)
        for number in range(first, first + 20)
    }
    assert not {
        number: reason for number, (verdict, reason, _) in found.items() if verdict == FAILED
    }
    if campaign not in ("files", "flips", "arguments"):
        assert sum(verdict == PASSED for verdict, _, _ in found.values()) >= 10


@pytest.mark.long
@pytest.mark.parametrize(
    "extreme", [each for each in extremes() if each.short], ids=lambda each: each.name
)
def test_nothing_fails_at_the_extremes(extreme):
    found = {case.words: attempt(lambda _, case=case: case, 0, 0)[:2] for case in extreme.cases()}
    assert not {words: reason for words, (verdict, reason) in found.items() if verdict == FAILED}


@pytest.mark.parametrize(("extreme", "reason"), [
    (Extreme("", but("steady"), answer=False), "an answer where there is none"),
    (Extreme("", but("steady", motion=vc.Steady(Fx=-0.31))), "force"),
    (Extreme("", lambda: int("x")), "ValueError"),
    (Extreme("", but("line", surface=vc.Cylinders(1.0), motion=vc.Shift(ux=1.0))), "reference_depth"),
])  # fmt: skip
def test_what_goes_wrong_at_an_extreme_is_found_out(extreme, reason):
    verdict, found, _ = attempt(lambda _: next(extreme.cases()), 0, 0)
    assert verdict == FAILED and reason in found


LINE = {
    "surface": vc.Cylinders(R=3.0, reference_depth=30.0), "motion": vc.Steady(vx=2e-3, vy=1e-3), "grid": vc.Grid(nx=100)
}  # fmt: skip
CHANGES = {
    "line": LINE,
    "law": LINE | {"friction": vc.LinearFalling(0.3, 0.2, 4e-3)},
    "hertz": {"motion": vc.Shift(ux=3e-4), "grid": "auto"},
    "touched": {
        "motion": vc.Steady(Fx=-5e-4, spin=1e-2),
        "grid": vc.Grid(nx=7, ny=7, edge="touched"),
    },
    "parts": {"motion": vc.Steady(vx=2e-3, spin=1e-2), "grid": vc.Grid(nx=7, ny=7, edge="touched")},
    "strips in parts": LINE | {"grid": vc.Grid(nx=9, edge="touched")},
    "strips in parts without a depth": LINE
    | {"surface": vc.Cylinders(R=3.0), "grid": vc.Grid(nx=9, edge="touched")},
    "johnson": {
        "bodies": vc.Bodies(G=(1.0, 0.4), nu=0.25),
        "motion": vc.Steady(vx=3e-3),
        "grid": vc.Grid(12, 12),
    },
}
OPTIONS = {kind: {"normal": "norm"} for kind in CHANGES if "parts" in kind} | {
    "johnson": {"coupling": "johnson"}
}


@pytest.mark.long
@pytest.mark.parametrize("kind", CHANGES)
def test_the_judge_notices(kind):
    """Changes of a thousandth, or of the certificate by a half, do not pass; and the solution
    does.
    """
    sol = vc.solve(dataclasses.replace(scene(), **CHANGES[kind]), **OPTIONS.get(kind, {}))
    assert faults(sol, 1e-8) == []
    slips, certificate = sol.state == 2, sol.certificate
    wrong = {
        "pressure": sol.pressure * np.where(sol.grid.x > 0, 1.001, 1.0),
        "traction": sol.traction * np.where(slips, 0.999, 1.0),
        "slip": sol.slip * 1.001,
        "creepage": (sol.creepage[0] + 1e-5, *sol.creepage[1:]),
        "certificate": dataclasses.replace(
            certificate, tangential_residual=certificate.tangential_residual + 1e-9
        ),
    }
    if np.isfinite(sol.approach):  # else distances are known but for a constant
        wrong["distance"] = sol.distance + 1e-3 * sol.distance.max()
    if "parts" in kind:
        assert sol.pressure_on_parts is not None
        wrong["pressure_on_parts"] = 0.999 * sol.pressure_on_parts
    for name, value in wrong.items():
        assert faults(dataclasses.replace(sol, **{name: value}), 1e-6), name


def test_the_judge_of_certificates_notices():
    """Bounds and gaps that are too small for the tractions beside a solution."""
    exact = vc.solve(
        dataclasses.replace(scene(), motion=vc.Steady(vx=3e-3), grid=vc.Grid(nx=8, ny=8))
    )
    posed, traction = dataclasses.replace(exact.scene, grid=exact.grid), 0.9 * exact.traction
    certificate, away = vc.certify(posed, traction), outputs(exact.grid, traction)
    moved = Held(dataclasses.replace(exact, traction=traction), None)
    assert (
        bounded(certificate, exact, away) == within_gap(Held(exact, None), moved, certificate) == []
    )
    part = np.abs(away - outputs(exact.grid, exact.traction))[0] / certificate.force_bound[0]
    bounds = ForceBounds(0.99 * part * certificate.force_bound, certificate.pressure_part)
    small = dataclasses.replace(certificate, bounds=bounds, gap=0.0)
    assert bounded(small, exact, away)
    assert within_gap(Held(exact, None), moved, small)


# -------------------- What the fuzzer found


@pytest.fixture(scope="module")
def sol():
    return vc.solve(
        make_scene(vc.Paraboloids(10.0, 8.0), 0.02, vc.Steady(vx=0.04), vc.Grid(nx=5, ny=5))
    )


def test_a_solver_that_prints_leaves_json_alone(tmp_path):
    """Scenes, seed 1, case 215: without active constraints OSQP says so on standard output, asked
    to be silent.
    """
    (tmp_path / "bump.toml").write_text("""
approach = 0.01
[bodies]
G = 1.0
nu = 0.3
[surface]
kind = "sampled-distance"
h = [[1, 1, 1], [1, 0, 1], [1, 1, 1]]
[grid]
nx = 3
ny = 3
dx = 1.0
dy = 1.0
x0 = -1.5
y0 = -1.5
""")
    done = run("solve", "bump.toml", "--normal", "osqp", "--json", folder=tmp_path)
    assert "Polishing not needed" in done.stderr
    assert json.loads(done.stdout)["elements"]["contact"] == 1


HUGE = np.broadcast_to(1.0, (10**8, 10**8))
BODIES, UNLIKE = vc.Bodies(1.0, 0.3), vc.Bodies((1.0, 2.0), 0.3)
SCENE = vc.Scene(
    bodies=BODIES, surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, grid=vc.Grid(nx=3, ny=3)
)
# arguments: exceptions of others, or messages that named something else
test_bad_arguments_are_named = refusals(
    (lambda: vc.standard_bank(cells=False), "cells = False"),
    (lambda: vc.reference.carter(1, 0.3, creepage=1e-3), "contact = 1 is not allowed"),
    (lambda: vc.reference.bufler(1.0, 2j, force=1.0), "bodies = 2j is not allowed"),
    (lambda: vc.reference.cattaneo_mindlin(None, BODIES, 0.3, 0.1), "contact"),
    (lambda: vc.solve(SCENE, formulation=np.ones(3)), "formulation"),
    (lambda: vc.plan(SCENE, normal=np.ones(0)), "normal"),
    (lambda: vc.SampledDistance(HUGE), "surface.h .* memory"),
    (lambda: vc.StaticKinetic(0.3, Hostile()), "friction.kinetic = a Hostile"),
    (lambda: vc.reference.spence_ratio(UNLIKE, 0.3, 10**5000), "shape = a number of thousands"),
    (lambda: vc.reference.creepage_coefficients(1.0, 5e-324, 0.3), "b = 5e-324 .* 1e-100"),
    (lambda: vc.Bodies.from_young(E=np.inf, nu=0.3), r"bodies\.E = inf"),
    (lambda: vc.compare({}, ["fastsim"], progress=int), "progress"),
    (
        lambda: vc.Transient(steps=3, dq=0.1, vx=HUGE),
        r"motion.vx = .100000000 values. .* each of the 3 steps",
    ),
)


def test_a_word_for_overwrite(sol, tmp_path):
    """Arguments, seed 1, case 1054: what is neither true nor false was taken for true."""
    with pytest.raises(vc.SceneError, match="overwrite = 'no'"):
        sol.save(tmp_path / "saved.nc", overwrite="no")


def test_points_and_names_of_any_size(sol, tmp_path):
    """Arguments, seed 3, cases 1447, 2651 and 4600, seed 72, case 4189: overflow, and a message of
    100 000 letters.
    """
    told = r"(depths?|points|y)(\[0, 0\])? = 1e\+\d+ .* at most 1e\+60 in size"
    refused(lambda: vc.stress_below(sol, 1e99), match=told)
    refused(lambda: vc.stress(sol, [[1e308]] * 3), match=told)
    refused(lambda: vc.plot_stress(sol, y=1e101), match=told)
    refused(lambda: vc.plot_stress(sol, depth=1e99), match=told)
    with pytest.raises(vc.SceneError, match="scene file") as failure:
        vc.read_scene("x" * 100_000)
    assert len(str(failure.value)) < 300


def test_an_iterate_that_diverges_warns_nobody(check_kkt):
    """Scenes, seed 1, case 1332: all but saturated, a step of TANG overflowed with NumPy's
    RuntimeWarning.
    """
    ellipse = vc.Ellipse(a=0.016222049333629904, b=0.0015411123148400582)
    motion = vc.Shift(
        uy=3.018342072463735e-10, rotation=2.2516178038473344e-07, Fx=22916.20847435266
    )
    steel = {"bodies": vc.Bodies(G=80e9, nu=0.28), "approach": 0.00010919506575814483}
    posed = make_scene(
        ellipse, None, motion, vc.Grid(nx=12, ny=9), friction=0.22364725334250185, **steel
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sol = vc.solve(posed, method="active-set")
    check_kkt(sol, 1e-8)


def test_distance_of_passes_that_diverge():
    """Scenes, seed 5, case 5283: from nothing to 1e300, a division that overflowed."""
    with np.errstate(all="raise"):
        assert distance(np.zeros(2), np.full(2, 1e300)) > 1e10
        assert distance(np.array([2.0, -4.0]), np.array([2.0, -3.0])) == 0.25
        assert distance(np.zeros(2), np.zeros(2)) == 0.0


@pytest.mark.parametrize("cells", [b"x", "8", 8, [8, 12.5]])
def test_cells_that_are_no_list_of_whole_numbers(cells):
    """Arguments, seed 72, case 12511: bytes are numbers to Python, and were grids of as many
    elements.
    """
    for call in (lambda: vc.converge(SCENE, cells), lambda: vc.tradeoff({}, ["auto"], cells=cells)):
        with pytest.raises(
            vc.SceneError, match=r"cells(\[1\])? = .* must be a (list of )?whole number"
        ):
            call()
