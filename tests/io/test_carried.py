"""Quantities that particles carry, from a step to the next, to files and back."""

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

import varcontact as vc
from varcontact.io.quantities import CARRIED

DATA = Path(__file__).parents[1] / "data"
LAYER = vc.ThirdBody(h=1e-3, G=1.0, tau_c0=0.01, k_tau=0.5)
SCENE = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28),
    surface=vc.Paraboloids(Rx=1.0, Ry=1.0),
    normal_force=1e-3,
    friction=vc.StaticKinetic(0.4, 0.2, memory_distance=0.05),
    third_body=LAYER,
    motion=vc.Transient(steps=2, dq=0.03, vx=2e-2),
    grid=vc.Grid(nx=6, ny=4, dx=0.05, dy=0.07, x0=-0.15, y0=-0.14, edge="centres"),
)
NAMES = {"weakening", "plastic_displacement", "yield_stress"}


@pytest.fixture(scope="module")
def history():
    return vc.solve(SCENE)


def test_what_particles_carry_is_one_dictionary(history):
    last = history[-1]
    assert set(last.carried) == NAMES
    assert last.carried["yield_stress"].max() > LAYER.tau_c0 == last.carried["yield_stress"].min()
    np.testing.assert_array_equal(last.weakening, last.carried["weakening"])
    np.testing.assert_array_equal(last.plastic[2], last.carried["yield_stress"])
    assert vc.solve(replace(SCENE, motion=vc.Steady(vx=1e-2), friction=0.3)).weakening is None


def test_files_have_each_quantity_by_its_name_with_its_unit(history, tmp_path):
    history.save(tmp_path / "history.nc")
    history[-1].save(tmp_path / "last.nc")
    for data in (vc.load(tmp_path / "history.nc").to_xarray(), history[-1].to_xarray()):
        assert set(data) & set(CARRIED) == NAMES
        assert data["yield_stress"].units == "force/length^2"
        assert data["plastic_displacement"].units == "length"
    for again in (vc.load(tmp_path / "history.nc")[-1], vc.load(tmp_path / "last.nc")):
        for name, values in history[-1].carried.items():
            np.testing.assert_array_equal(again.carried[name], values)


def test_a_history_goes_on_from_its_file(history, tmp_path):
    replace(history, solutions=history[:1]).save(tmp_path / "begun.nc")
    again = vc.solve(SCENE, store=tmp_path / "begun.nc")
    for name, values in history[-1].carried.items():
        np.testing.assert_array_equal(again[-1].carried[name], values)


def test_files_of_the_version_before_are_read(history):
    """`carried_history_2.nc` and `carried_solution_1.nc` have `SCENE`, by the version that kept
    plastic displacement and yield stress in one field.
    """
    earlier = (vc.load(DATA / "carried_history_2.nc")[-1], vc.load(DATA / "carried_solution_1.nc"))
    for sol in earlier:
        assert set(sol.carried) == NAMES
        for name, values in history[-1].carried.items():
            scale = np.abs(values).max()
            np.testing.assert_allclose(sol.carried[name], values, atol=1e-9 * scale)


def test_histories_of_the_version_before_are_not_continued(tmp_path):
    path = tmp_path / "earlier.nc"
    path.write_bytes((DATA / "carried_history_2.nc").read_bytes())
    longer = replace(SCENE, motion=replace(SCENE.motion, steps=3))
    with pytest.raises(vc.OutputError, match="earlier version, and can only be read; name a new"):
        vc.solve(longer, store=path)


def test_a_version_to_come_is_refused(history, tmp_path):
    history[-1].save(tmp_path / "last.nc")
    path = tmp_path / "next.nc"
    path.write_bytes((tmp_path / "last.nc").read_bytes().rpartition(b"\nvarcontact sha256 ")[0])
    with h5py.File(path, "r+") as file:
        file.attrs["format"] = "varcontact solution 3"
    with pytest.raises(vc.OutputError, match="is not a 'varcontact solution 2' file"):
        vc.load(path)
