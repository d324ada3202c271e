"""The table of quantities: one entry is in results, reports, tables, sweeps, the command line and
pictures.
"""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot as plt

from tests.wheel_rail.test_wheel_set import wheel_set
from varcontact.study.csv_table import rows_of_text
from varcontact.wheel_rail import (
    Position,
    Profile,
    Track,
    WheelOnRail,
    WheelSet,
    quantities,
    sweep_wheel_sets,
)
from varcontact.wheel_rail.case_file import CaseFile, solve_cases
from varcontact.wheel_rail.plots import plot_positions, plot_wheel_sets
from varcontact.wheel_rail.quantities import QUANTITIES, InReport, Panel, Quantity

pytestmark = pytest.mark.filterwarnings("ignore")  # elements are few to be fast

HALF_WIDTH = Quantity(
    name="half_width",
    unit="mm",
    patch=lambda patch: patch.half_width,
    report=InReport(3, "half width {} mm", ".4g"),
    printed=12,
    panel=Panel("Half width [um]", 1e3, positions=13, sweep=7),
)


@pytest.fixture
def new_quantity(monkeypatch):
    """An entry more, which nothing else in the package knows."""
    monkeypatch.setattr(quantities, "QUANTITIES", (*QUANTITIES, HALF_WIDTH))


def wheel(y):
    return WheelOnRail(
        track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
        wheelset=WheelSet(wheel=Profile.s1002()),
        position=Position(y=y),
        vertical_force=80e3,
        dx=2.0,
        dy=1.0,
    )


def labels(figure):
    return [ax.get_ylabel() for ax in figure.axes if ax.get_visible()]


@pytest.mark.long
def test_a_new_quantity_of_wheels_is_one_entry(new_quantity, tmp_path):
    file = CaseFile((wheel(2.0), wheel(3.0)), (1, 2), {}, None)
    found = []
    table = solve_cases(file, tmp_path / "wheels.csv", solved=found.append)
    widths = [each.patches[0].half_width for each in found]
    assert table["half_width"].tolist() == widths
    assert pd.read_csv(tmp_path / "wheels.csv")["half_width"].tolist() == widths
    assert [each.quantities()[0]["half_width"] for each in found] == widths
    assert f"  half width {widths[0]:.4g} mm" in found[0].report().splitlines()
    heading, *rows = rows_of_text(table.to_dict("records"), quantities.printed_columns())
    assert heading.split()[-1] == "half_width"
    assert [float(row.split()[-1]) for row in rows] == widths
    figure = plot_positions(table)
    assert labels(figure)[12:] == ["Half width [um]"]
    shown = figure.axes[12].lines[0].get_ydata()
    assert shown == pytest.approx(1e3 * np.array(widths))
    plt.close(figure)


@pytest.mark.long
def test_a_new_quantity_of_wheel_sets_is_one_entry(new_quantity, tmp_path):
    case, over, store = wheel_set(), {"position.y": [0.0, 2.0]}, tmp_path / "sweep.csv"
    swept = sweep_wheel_sets(case, over, fast=True, store=store)
    assert swept["half_width"].units == "mm"
    estimate = replace(case, position=replace(case.position, y=2.0)).estimate()
    widths = swept["half_width"].sel({"position.y": 2.0, "patch": 1}).values
    assert widths.tolist() == [each.ellipse.b for each in estimate.patches]
    assert pd.read_csv(store)["half_width"].tolist() == swept["half_width"].values.ravel().tolist()
    figure = plot_wheel_sets(swept, case)
    assert labels(figure)[6] == "Half width [um]"
    plt.close(figure)


def test_names_are_unique_and_errors_are_in_the_unit_of_their_quantity():
    named = {each.name: each for each in QUANTITIES}
    assert len(named) == len(QUANTITIES)
    for each in QUANTITIES:
        if each.error_column in named:
            assert named[each.error_column].unit == each.unit


def test_exact_and_fast_quantities_are_of_the_same_patch():
    case = wheel(3.0)
    (exact,), (fast,) = case.solve().quantities(), case.estimate().quantities()
    assert exact.keys() == fast.keys()
    assert exact["FN"] == pytest.approx(fast["FN"], rel=0.01)
    for name in ("on_rail", "on_wheel", "location_y", "vy"):
        assert exact[name] == pytest.approx(fast[name], rel=0.05, abs=1e-5)
    assert np.isnan([fast["error_FN"], fast["wear_depth"]]).all()


def test_quantities_of_a_wheel_set_are_those_of_its_wheels():
    estimate = wheel_set().estimate()
    both = [*estimate.left.quantities(), *estimate.right.quantities()]
    assert [each["FN"] for each in estimate.quantities()] == [each["FN"] for each in both]
    assert [each["T_gamma"] for each in both] == [each.t_gamma for each in estimate.patches]
