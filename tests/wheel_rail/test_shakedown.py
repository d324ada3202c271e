"""Shakedown of wheels on rails: patches, tables, sweeps, case files, and Johnson's diagram."""

from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from tests.wheel_rail.conditions import wheel
from varcontact import wheel_rail
from varcontact.wheel_rail import WheelSetOnTrack, johnson_diagram, sweep_wheel_sets
from varcontact.wheel_rail.case_file import CaseFile, read_case, solve_cases
from varcontact.wheel_rail.quantities import MODES

pytestmark = pytest.mark.filterwarnings("ignore")  # elements are few to be fast
K = 300.0


@pytest.fixture(scope="module")
def rolling():
    return wheel(3.0, yaw=0.003, dx=1.5, dy=1.5).solve()


@pytest.fixture(scope="module")
def limit(rolling):
    return vc.shakedown(rolling.patches[0], K, body="rail", gap=None)


@pytest.mark.long
def test_bounds_of_a_patch(rolling, limit):
    (patch,) = rolling.patches
    place = johnson_diagram(patch, K)
    assert place.local == pytest.approx(limit.local, rel=1e-12)
    assert place.utilised < place.local
    # k by the largest traction is a theorem, and here nearly the limit
    by_traction = K / (limit.local * limit.peak_pressure)
    assert 0.9 * by_traction < limit.upper <= by_traction * (1 + 1e-9)
    assert limit.outcome == "surface flow"
    # the body that tractions of patches act on, and the other one
    assert vc.shakedown(patch, K, gap=None).upper == limit.upper
    other = vc.shakedown(patch, K, body="wheel", gap=None)
    assert other.upper == pytest.approx(limit.upper, rel=0.1)


def test_the_diagram_has_its_former_names(rolling):
    assert wheel_rail.shakedown is johnson_diagram
    assert wheel_rail.Shakedown is wheel_rail.JohnsonDiagram
    place = wheel_rail.shakedown(rolling.patches[0], yield_in_shear=K)
    assert place.index == pytest.approx(place.utilised - 1 / place.load_factor, rel=1e-12)


@pytest.mark.long
def test_quantities_and_report(rolling, limit):
    (values,) = rolling.quantities(yield_in_shear=K)
    assert values["shakedown_lower"] == limit.lower
    assert values["shakedown_upper"] == limit.upper
    assert MODES[int(values["shakedown_mode"]) - 1] == limit.mode
    assert values["local_traction"] == pytest.approx(limit.local, rel=1e-12)
    assert np.isnan(rolling.quantities()[0]["shakedown_upper"])
    assert f"traction up to {limit.local:.3g} of the largest pressure" in rolling.report()


@pytest.mark.long
@pytest.mark.slow
def test_tables_and_sweeps(rolling, limit, tmp_path):
    file = CaseFile((rolling.case,), (1,), {}, None, yield_in_shear=K)
    store = tmp_path / "wheels.csv"
    table = solve_cases(file, store)
    assert table["shakedown_upper"].tolist() == [limit.upper]
    # another yield stress is another table
    with pytest.raises(vc.SceneError):
        solve_cases(replace(file, yield_in_shear=2 * K), store)
    axle = WheelSetOnTrack(
        track=rolling.case.track,
        wheelset=rolling.case.wheelset,
        vertical_force=160e3,
        dx=1.5,
        dy=1.5,
    )
    found = sweep_wheel_sets(axle, {"position.y": [0.0]}, yield_in_shear=K)
    upper = found["shakedown_upper"].sel(patch=1).values
    assert upper.shape == (1, 2)
    assert upper[0, 0] == pytest.approx(upper[0, 1], rel=1e-6)
    assert found["shakedown_mode"].sel(patch=1).values.min() >= 1


def test_a_case_file(tmp_path):
    path = tmp_path / "case.toml"
    text = """
vertical_force = 80e3
track = { rail = "60e1", cant = 0.025 }
wheelset = { wheel = "s1002" }
position = { y = 0.0 }
[shakedown]
"""
    path.write_text(text + "yield_in_shear = 300.0\n")
    assert read_case(path).yield_in_shear == K
    for entry in ("yield_in_shear = -1.0", "k = 300.0", ""):
        path.write_text(text + entry)
        with pytest.raises(vc.SceneError, match="shakedown"):
            read_case(path)
