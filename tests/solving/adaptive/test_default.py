"""Where neither a grid nor an accuracy is given, answers have an error bar of 1 % of the friction
limit at most.
"""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.random_scenes import scenes
from tests.scenes import wheel_on_rail
from varcontact.results.quantities_of_interest import error, units, values

ROLLING = wheel_on_rail(vc.Steady(vx=1e-3, spin=0.3))
HISTORY = vc.Transient(steps=2, dq=1e-3, vx=1e-3)


@pytest.mark.long
def test_the_report_begins_with_values_and_error_bars():
    sol = vc.solve(ROLLING)
    bars, report = sol.error_estimate.bars, sol.report()
    assert sol.force.tolist() == vc.solve(ROLLING, accuracy=0.01).force.tolist()
    assert sol.error_estimate.accuracy == 0.01 and sol.error_estimate.largest <= 0.01
    fine = vc.solve(ROLLING, accuracy=0.001)
    for name, value, true in zip(("Fx", "Fy"), sol.force, fine.force, strict=True):
        assert abs(value - true) <= bars[name]
        line = next(line for line in report.splitlines() if f"{name} = " in line)
        shown, bar = line.split(f"{name} = ")[1].split(",")[0].split("%")[0].split(" +- ")
        assert float(shown) == pytest.approx(value, abs=0.06 * bars[name])
        assert float(bar.split()[0]) == pytest.approx(bars[name], rel=0.05)
    assert report.index(" +- ") < report.index("certificate")


def test_a_grid_is_that_grid_with_contacts_discretisation():
    sol = vc.solve(replace(ROLLING, grid=vc.Grid(24, 24)))
    assert sol.error_estimate is None and sol.grid.shape == (26, 26)
    assert sol.motion.slip_difference == "first-order" and sol.scene.edge == "centres"
    assert "no error bar: the certificate holds for this grid" in sol.report()


@pytest.mark.parametrize(
    ("changes", "options", "why"),
    [
        ({"friction": np.inf}, {}, "errors are relative to the friction limit"),
        ({}, {"tangential": "fastsim"}, "fastsim is an approximate theory"),
        ({"motion": vc.Steady(vx=1e-3, dq=5e-4)}, {}, ""),
        ({"motion": vc.Steady(vx=1e-3, slip_difference="second-order")}, {}, ""),
        ({"motion": vc.Steady(vx=1e-3, spin_offset=0.0)}, {}, ""),
    ],
)
def test_what_has_no_error_bar_keeps_the_usual_grid(changes, options, why):
    sol = vc.solve(replace(ROLLING, **changes), **options)
    assert sol.error_estimate is None and sol.grid.shape == (26, 26)
    assert f"no error bar: {why}" in sol.report()


def test_histories(tmp_path):
    history = vc.solve(replace(ROLLING, motion=HISTORY))
    assert history.error_estimate.largest <= 0.01
    stored = vc.solve(replace(ROLLING, motion=HISTORY), store=tmp_path / "steps.nc")
    assert stored.error_estimate is None and stored.grid.shape == (26, 26)
    without = vc.solve(replace(ROLLING, motion=replace(HISTORY, dq=None)))
    assert without.error_estimate is None


@pytest.mark.long
@pytest.mark.parametrize(
    "kind",
    [
        "steady",
        "forces",
        "shift",
        "unlike",
        "line",
        "line unlike",
        "sampled",
        "law",
        "slender",
        "patches",
    ],
)
def test_the_error_bar_holds(kind):
    """Of a random scene of a kind, against a finer grid; `tests.benchmarks accuracy` takes
    hundreds.
    """
    (scene,) = scenes(kind, 1, seed=3101)
    sol, fine = vc.solve(scene), vc.solve(scene, certify=None, accuracy=0.004)
    missed = error(values(sol), values(fine), units(fine)) - fine.error_estimate.largest
    assert missed <= sol.error_estimate.largest
