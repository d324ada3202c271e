"""Some cases of each campaign, by a fixed seed; the command runs as many as wanted."""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.conditions import Held
from tests.fuzz import campaigns
from tests.fuzz.campaigns import bounded, outputs, within_gap
from tests.fuzz.judge import faults
from tests.fuzz.outcome import FAILED, PASSED, attempt
from varcontact.discrete.certificate import ForceBounds

SEED = 20
CASES = {"scenes": 100, "certificates": 60, "newton": 40, "files": 20, "arguments": 40}
TWENTIES = [(campaign, first) for campaign, cases in CASES.items() for first in range(0, cases, 20)]


@pytest.mark.parametrize(("campaign", "first"), TWENTIES)
def test_random_cases(campaign, first):
    found = {number: attempt(getattr(campaigns, campaign), SEED, number) for number in range(first, first + 20)}
    assert not {number: reason for number, (verdict, reason, _) in found.items() if verdict == FAILED}
    if campaign not in ("files", "arguments"):
        assert sum(verdict == PASSED for verdict, _, _ in found.values()) >= 10


LINE = {
    "surface": vc.Cylinders(R=3.0, reference_depth=30.0), "motion": vc.Steady(vx=2e-3, vy=1e-3), "grid": vc.Grid(nx=100)
}  # fmt: skip
CHANGES = {
    "line": LINE,
    "law": LINE | {"friction": vc.LinearFalling(0.3, 0.2, 4e-3)},
    "hertz": {"motion": vc.Shift(ux=3e-4)},
    "touched": {"motion": vc.Steady(Fx=-5e-4, spin=1e-2), "grid": vc.Grid(nx=7, ny=7, edge="touched")},
    "parts": {"motion": vc.Steady(vx=2e-3, spin=1e-2), "grid": vc.Grid(nx=7, ny=7, edge="touched")},
    "strips in parts": LINE | {"grid": vc.Grid(nx=9, edge="touched")},
    "johnson": {"bodies": vc.Bodies(G=(1.0, 0.4), nu=0.25), "motion": vc.Steady(vx=3e-3), "grid": vc.Grid(12, 12)},
}
OPTIONS = {"johnson": {"coupling": "johnson"}, "parts": {"normal": "norm"}, "strips in parts": {"normal": "norm"}}


@pytest.mark.parametrize("kind", CHANGES)
def test_the_judge_notices(kind):
    """Changes of a thousandth, or of the certificate by a half, do not pass; and the solution does."""
    base = {"bodies": vc.Bodies(G=1.0, nu=0.3), "surface": vc.Paraboloids(3.0, 2.0), "normal_force": 4e-3}
    scene = vc.Scene(**(base | {"friction": 0.3} | CHANGES[kind]))
    sol = vc.solve(scene, **OPTIONS.get(kind, {}))
    assert faults(sol, 1e-8) == []
    slips, certificate = sol.state == 2, sol.certificate
    wrong = {
        "pressure": sol.pressure * np.where(sol.grid.x > 0, 1.001, 1.0),
        "traction": sol.traction * np.where(slips, 0.999, 1.0),
        "slip": sol.slip * 1.001,
        "distance": sol.distance + 1e-3 * sol.distance.max(),
        "certificate": dataclasses.replace(certificate, tangential_residual=certificate.tangential_residual + 1e-9),
    }
    if "parts" in kind:
        assert sol.pressure_on_parts is not None
        wrong["pressure_on_parts"] = 0.999 * sol.pressure_on_parts
    for name, value in wrong.items():
        assert faults(dataclasses.replace(sol, **{name: value}), 1e-6), name


def test_the_judge_of_certificates_notices():
    """Bounds and gaps that are too small for the tractions beside a solution."""
    base = {"bodies": vc.Bodies(G=1.0, nu=0.3), "surface": vc.Paraboloids(3.0, 2.0), "normal_force": 4e-3}
    exact = vc.solve(vc.Scene(**base, friction=0.3, motion=vc.Steady(vx=3e-3), grid=vc.Grid(nx=8, ny=8)))
    scene, traction = dataclasses.replace(exact.scene, grid=exact.grid), 0.9 * exact.traction
    certificate, away = vc.certify(scene, traction), outputs(exact.grid, traction)
    moved = Held(dataclasses.replace(exact, traction=traction), None)
    assert bounded(certificate, exact, away) == within_gap(Held(exact, None), moved, certificate) == []
    part = np.abs(away - outputs(exact.grid, exact.traction))[0] / certificate.force_bound[0]
    bounds = ForceBounds(0.99 * part * certificate.force_bound, certificate.pressure_part)
    small = dataclasses.replace(certificate, bounds=bounds, gap=0.0)
    assert bounded(small, exact, away)
    assert within_gap(Held(exact, None), moved, small)
