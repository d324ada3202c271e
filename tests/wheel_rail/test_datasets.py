"""Results of wheels as datasets, tables and files; solved and estimated patches alike."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from tests.scenes import refused
from tests.wheel_rail.conditions import TRACK, WHEELSET
from varcontact.errors import OutputError
from varcontact.wheel_rail import Archard, Position, WheelOnRail, WheelSetOnTrack, wear
from varcontact.wheel_rail.conicity import equivalent_conicity, rolling_radius_difference
from varcontact.wheel_rail.geometry_table import geometry_table
from varcontact.wheel_rail.quantities import quantities_of

LOAD = 50e3
LAW = Archard(k=3e-4, hardness=3000.0)
SHARED = (
    "frame",
    "location",
    "angle",
    "on_rail",
    "on_wheel",
    "rolling_radius",
    "creepage",
    "approach",
    "force",
    "force_on_track",
    "normal_force",
    "moment",
    "tilting",
    "peak_pressure",
    "half_width",
    "area",
    "t_gamma",
    "friction_power",
)


def on_rail(y=3.0, yaw=0.003, **more):
    more = {"track": TRACK, "wheelset": WHEELSET, "vertical_force": LOAD, **more}
    return WheelOnRail(position=Position(y=y, yaw=yaw), **more)


@pytest.fixture(scope="module")
def solved():
    return on_rail(dx=1.0, dy=1.0).solve()


@pytest.fixture(scope="module")
def table():
    nodes = np.linspace(-4.0, 4.0, 5)
    return geometry_table(TRACK, WHEELSET, y=nodes, yaw=[-0.005, 0.0, 0.005], vertical_force=LOAD)


def test_patches_solved_and_estimated_have_the_same_attributes(solved):
    (exact,) = solved.patches
    (fast,) = on_rail().estimate().patches
    for name in SHARED:
        both = [getattr(patch, name) for patch in (exact, fast)]
        assert np.shape(both[0]) == np.shape(both[1]), name
    assert fast.rolling_radius == pytest.approx(exact.rolling_radius, abs=0.2)
    assert fast.on_rail == pytest.approx(exact.on_rail, abs=1.0)
    assert fast.on_wheel == pytest.approx(exact.on_wheel, abs=1.0)
    assert fast.area == pytest.approx(exact.area, rel=0.1)
    assert fast.t_gamma == pytest.approx(exact.t_gamma, rel=0.1)


@pytest.mark.long
def test_a_wheel_is_a_dataset_of_its_quantities(solved):
    data = solved.to_xarray(LAW)
    (row,) = solved.quantities(LAW)
    for quantity in quantities_of("patch", of_sets=False):
        value = data[quantity.name]
        assert value.dims == ("patch",) and value.units == (quantity.unit or "1")
        assert value.item() == pytest.approx(row[quantity.name], nan_ok=True)
    assert data["z"].item() == solved.z and data["side"].item() == "right"
    (of_table,) = solved.to_dataframe().to_dict("records")
    assert of_table["FN"] == row["FN"] and of_table["side"] == "right"
    assert solved.to_dataframe().attrs["units"]["FN"] == "N"
    assert solved._repr_html_().startswith("<pre>")


@pytest.mark.long
def test_a_wheel_set_is_over_side_and_patch():
    found = WheelSetOnTrack(track=TRACK, wheelset=WHEELSET, vertical_force=2 * LOAD).estimate()
    data = found.to_xarray()
    assert data["FN"].dims == ("side", "patch") and data["Y_over_Q"].dims == ("side",)
    left, right = (wheel.patches[0].force[2] for wheel in found.wheels)
    assert data["FN"].sel(patch=1).values == pytest.approx([left, right])
    assert len(found.to_dataframe()) == sum(len(wheel.patches) for wheel in found.wheels)
    assert found._repr_html_().startswith("<pre>")


@pytest.mark.long
def test_files_are_read_by_others_and_only_their_own_kind_is_replaced(solved, tmp_path):
    solved.save(tmp_path / "wheel.nc")
    solved.save(tmp_path / "wheel.nc")
    with xr.open_dataset(tmp_path / "wheel.nc") as again:
        assert again["FN"].values == pytest.approx(solved.to_xarray()["FN"].values, rel=0, abs=0)
        assert again["FN"].units == "N"
    solved.save(tmp_path / "wheel.csv")
    solved.save(tmp_path / "wheel.csv")
    read = pd.read_csv(tmp_path / "wheel.csv")
    assert read["FN"].tolist() == solved.to_dataframe()["FN"].tolist()
    worn = wear(solved, LAW)
    for name in ("wheel.nc", "wheel.csv"):
        with pytest.raises(OutputError, match="no Wear of varcontact's"):
            worn.save(tmp_path / name)
        worn.save(tmp_path / name, overwrite=True)
    with pytest.raises(OutputError, match=r"\.nc"):
        worn.save(tmp_path / "wheel.doc")


def test_wear_over_patches_and_rows_adds_up(solved):
    worn = wear(solved, LAW)
    data = worn.to_xarray()
    grid = worn.patches[0].solved.solution.grid
    assert (data["power_by_width"] * grid.sides[1]).sum() == pytest.approx(worn.power)
    assert (data["depth"] * grid.sides[1]).sum() == pytest.approx(worn.volume)
    middle = float((data["y"] * data["depth"]).sum() / data["depth"].sum())
    assert middle == pytest.approx(worn.patches[0].solved.location[1], abs=3.0)
    assert "depth" not in wear(solved).to_xarray()


@pytest.mark.long
def test_a_table_has_names_units_and_the_geometry_of_the_estimates(table):
    data = table.to_xarray()
    at = data.sel(y=2.0, yaw=0.005, patch=1)
    case = on_rail(2.0, yaw=0.005, with_friction=False)
    (patch,) = case.estimate().patches
    assert at["rolling_radius"].item() == pytest.approx(patch.rolling_radius, abs=1e-9)
    assert at["on_rail"].item() == pytest.approx(patch.on_rail[0], abs=1e-9)
    assert at["on_wheel"].item() == pytest.approx(patch.on_wheel[0], abs=1e-9)
    assert at["angle"].item() == pytest.approx(patch.angle, abs=1e-12)
    curved = WHEELSET.profile.curvature_at(patch.on_wheel[0])
    assert at["curvature_wheel"].item() == pytest.approx(float(curved))
    assert data["rolling_radius"].units == "mm" and data["angle"].units == "rad"
    assert data["rolling_radius"].sel(patch=3).isnull().all()
    difference = rolling_radius_difference(TRACK, WHEELSET, table.y)
    assert data["radius_difference"].values == pytest.approx(difference)
    assert data["conicity"].sel(y=-4.0).item() == pytest.approx(
        equivalent_conicity(TRACK, WHEELSET, 4.0), rel=1e-3
    )
    assert data["conicity"].sel(y=0.0).isnull()


@pytest.mark.long
def test_columns_for_vehicle_codes_are_those_of_both_wheels(table, tmp_path):
    """The left wheel is a mirror image in the table: here it is one by itself."""
    path = tmp_path / "columns.csv"
    table.save_columns(path, yaw=0.005)
    columns = pd.read_csv(path).set_index("y [mm]")
    for side in ("right", "left"):
        case = on_rail(2.0, yaw=0.005, side=side, with_friction=False)
        (patch,) = case.estimate().patches
        s = side[0]
        sign = {"right": -1.0, "left": 1.0}[side]
        row = columns.loc[2.0]
        assert row[f"r_{s} [mm]"] == pytest.approx(patch.rolling_radius, abs=1e-6)
        assert row[f"gamma_{s} [rad]"] == pytest.approx(sign * patch.angle, abs=1e-6)
        assert row[f"y_rail_{s} [mm]"] == pytest.approx(patch.on_rail[0], abs=1e-5)
        assert row[f"y_wheel_{s} [mm]"] == pytest.approx(patch.on_wheel[0], abs=1e-5)
        assert row[f"a_{s} [mm]"] == pytest.approx(patch.ellipse.a, rel=1e-6)
    assert (columns["delta_r [mm]"] == columns["r_r [mm]"] - columns["r_l [mm]"]).all()
    table.save_columns(path, yaw=0.0)
    refused(lambda: table.save_columns(path, yaw=0.001), "yaw", "a node of the table")


@pytest.mark.long
def test_a_table_draws_itself(table):
    figure = table.plot()
    labels = [ax.get_ylabel() for ax in figure.axes]
    assert labels[:2] == ["rolling radius difference [mm]", "contact angle [mrad]"]
    lines = figure.axes[0].get_lines()[0].get_ydata()
    assert lines == pytest.approx(table.to_xarray()["radius_difference"].values)
