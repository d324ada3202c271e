"""Sweeps of wheel sets: the numbers of single solutions, resumed, pictures, and the same as a
command.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot as plt

from tests.command import run
from tests.scenes import refusals
from tests.wheel_rail.test_wheel_set import wheel_set
from varcontact.errors import SceneError
from varcontact.wheel_rail import Archard, WheelSetOnTrack, sweep_wheel_sets, wear
from varcontact.wheel_rail.case_file import read_case, solve_cases
from varcontact.wheel_rail.plots import plot_wheel_sets

pytestmark = pytest.mark.filterwarnings("ignore")  # elements are few to be fast
LAW = Archard(k=3e-4, hardness=3000.0)
OVER = {"position.y": [0.0, 4.0], "friction": [0.4]}


@pytest.mark.long
def test_a_sweep_has_the_numbers_of_the_solutions_and_is_resumed(tmp_path):
    case, store, told = wheel_set(yaw=0.003), tmp_path / "sweep.csv", []
    swept = sweep_wheel_sets(case, OVER, archard=LAW, store=store)
    single = replace(case, position=replace(case.position, y=4.0), friction=0.4).solve()
    at = swept.sel({"position.y": 4.0, "friction": 0.4})
    for wheel in single.wheels:
        part, worn = at.sel(side=wheel.case.side, patch=1), wear(wheel, LAW).patches[0]
        assert part["track_Fy"] == pytest.approx(wheel.force[1])
        assert part["T_gamma"] == pytest.approx(worn.t_gamma)
        assert part["wear_depth"] == pytest.approx(worn.depth.max())
        assert part["Y_over_Q"] == pytest.approx(single.y_over_q(wheel.case.side))
    assert at["roll"] == pytest.approx(single.position.roll)
    assert swept["T_gamma"].units == "N"
    rows = pd.read_csv(store)
    rows[rows["position"] != 1].to_csv(store, index=False)
    again = sweep_wheel_sets(case, OVER, archard=LAW, store=store, progress=told.append)
    assert len(told) == 1
    assert swept.equals(again)


@pytest.mark.long
def test_what_is_not_solved_has_its_reason_and_pairs_make_a_dimension():
    narrow = replace(wheel_set(), track=replace(wheel_set().track, cant=0.01))
    swept = sweep_wheel_sets(
        {"one": wheel_set(), "two": narrow}, {"position.y": [2.0, 90.0]}, fast=True
    )
    assert swept["outcome"].sel({"position.y": 90.0}, drop=True).values.tolist() == [
        "refused",
        "refused",
    ]
    assert "beside the rail" in str(swept["reason"].values[0, 1])
    found = swept["on_rail"].sel({"position.y": 2.0, "side": "right", "patch": 1}).values
    assert found[0] != found[1]
    assert np.isfinite(found).all()


CASE = """
side = "set"
vertical_force = 160e3
free = ["roll", "pitch_rate"]
friction = { kind = "by_angle", angles = [0.2, 0.6], coefficients = [0.3, 0.1] }
dx = 1.6
dy = 1.6
track = { rail = "60e1", cant = 0.025, curve_radius = 800e3 }
wheelset = { wheel = "s1002" }
position = { y = [-3.0, 1.0] }
torque = -1e6
"""


@pytest.mark.long
def test_the_command_is_the_case_in_python(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    file = read_case(path)
    assert all(isinstance(case, WheelSetOnTrack) and case.torque == -1e6 for case in file.cases)
    done = run(
        "wheelrail",
        path,
        "--out",
        tmp_path / "table.csv",
        "--plot",
        tmp_path / "sets.png",
        folder=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    table, known = pd.read_csv(tmp_path / "table.csv"), solve_cases(file)
    assert table["track_Fx"].to_numpy() == pytest.approx(known["track_Fx"].to_numpy())
    assert table["side"].tolist() == ["left", "right"] * 2
    assert known.groupby("position")["track_Fz"].sum().to_numpy() == pytest.approx([160e3, 160e3])
    path.write_text(CASE.replace('"set"', '"both"'))
    with pytest.raises(SceneError, match=r"torque|free"):
        read_case(path)


test_arguments_of_another_kind_are_named = refusals(
    ({"cases": None}, "cases"),
    ({"cases": {}}, "cases"),
    ({"over": 5}, "over"),
    ({"over": {"gauge": [1.0]}}, "has no"),
    ({"over": {"track.gage": [1.0]}}, "has no"),
    ({"over": {"axle.y": [1.0]}}, "has no"),
    ({"over": {"friction": [0.3, 0.3]}}, "different values"),
    ({"over": {"position.y": 3.0}}, "position.y"),
    ({"over": {3: [1.0, 2.0]}}, "over"),
    ({"archard": 5}, "archard"),
    ({"fast": "no"}, "fast"),
    of=partial(sweep_wheel_sets, cases=wheel_set(), over={"position.y": [0.0, 1.0]}),
)


@pytest.mark.long
def test_the_picture():
    case = wheel_set()
    swept = sweep_wheel_sets(case, {"position.y": [-4.0, 0.0, 4.0]}, fast=True)
    figure = plot_wheel_sets(swept, case)
    lateral = figure.axes[1].lines[0].get_ydata()
    assert lateral == pytest.approx(1e-3 * swept["track_Fy"].sel(side="left", patch=1).values)
    plt.close(figure)
    with pytest.raises(SceneError, match="one entry"):
        plot_wheel_sets(sweep_wheel_sets(case, {"position.y": [0.0], "friction": [0.1]}, fast=True))
