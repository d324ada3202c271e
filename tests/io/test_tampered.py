"""Files are not believed: what no solution can be is refused, what its certificate does not fit is
certified anew.
"""

import dataclasses
import json
import zlib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.io import netcdf_file

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.io.records import checked_layout
from varcontact.io.solution import AS_STORED, dataset, netcdf_to_bytes
from varcontact.solving.verify import ALONE, ANEW

DATA = Path(__file__).parents[1] / "data"
SPHERES = vc.Paraboloids(1.0, 1.5)
ROLLING = vc.Steady(vx=0.04, vy=-0.02, spin=0.05)
STEPS = vc.Transient(
    steps=4, dq=[0, 0.05, 0.1, 0.1], vx=[0, 4e-3, 4e-3, 0], normal_force=[None, 0.03, 0.0, None]
)
UNLIKE = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))


def scene(**changes):
    given = {
        "surface": vc.Ellipse(a=1.2, b=0.9),
        "normal_force": 1.0,
        "motion": ROLLING,
        "grid": vc.Grid(10, 10),
    }
    return make_scene(**given | changes)


HISTORY = scene(
    surface=vc.Paraboloids(10.0, 10.0), normal_force=0.02, grid=vc.Grid(nx=8, ny=8), motion=STEPS
)


@pytest.fixture(scope="module")
def sol():
    """Under a computed pressure, with stick and slip."""
    return vc.solve(scene(), normal="norm")


def altered(sol, path, **changes):
    """The file of a solution with other fields or entries of its record."""
    data = dataset(sol)
    for name, change in changes.items():
        if name == "record":
            record = json.loads(str(data["record"].values))
            change(record)
            data["record"] = ((), json.dumps(record))
        else:
            data[name] = (data[name].dims, np.asarray(change(data[name].values.copy())))
    path.write_bytes(netcdf_to_bytes(data))
    return path


def put(index, value):

    def change(values):
        values[index] = value
        return values

    return change


@pytest.mark.parametrize("methods", [
    {"tangential": "fastsim"},
    {"tangential": "linear"},
    {"tangential": "vermeulen-johnson", "motion": vc.Steady(vx=0.04)},
    {"coupling": "johnson", "bodies": UNLIKE},
    {"tangential": "clarabel", "normal": "clarabel", "polish": False, "tol": 1e-4},
    {"tangential": "scs", "normal": "scs", "polish": False, "tol": 1e-12},
])  # fmt: skip
def test_theories_and_answers_that_are_not_exact_are_what_they_say(methods, tmp_path):
    """Whatever certificate they have, it is theirs."""
    changes = {name: methods.pop(name) for name in ("motion", "bodies") if name in methods}
    try:
        sol = vc.solve(scene(**changes), **methods)
    except vc.NotConverged as failure:
        sol = failure.solution
    sol.save(tmp_path / "sol.nc")
    again = vc.load(tmp_path / "sol.nc")
    assert (again.note, again.converged) == ("", sol.converged)
    assert again.certificate.residual == sol.certificate.residual


def refused_or_certified_anew(path):
    """Whether a file is not believed: refused, or with a certificate of its own fields that does
    not call it solved.
    """
    try:
        again = vc.load(path)
    except vc.OutputError as error:
        return "is damaged" in str(error)
    return again.note == ANEW and not again.converged


@pytest.mark.parametrize("changes", [
    {"traction": lambda q: 1.5 * q},
    {"traction": put((0, 0, 0), 1e-3)},
    {"traction": lambda q: 0.5 * q},
    {"traction": lambda q: q[:, :, ::-1]},
    {"traction": put((0, 5, 5), np.nan)},
    {"pressure": put((5, 5), -0.1)},
    {"pressure": lambda p: -p},
    {"pressure": lambda p: 1.2 * p},
    {"pressure": lambda p: 0 * p, "traction": lambda q: 0 * q, "state": lambda s: 0 * s},
    {"state": put((5, 5), 7)},
    {"state": put((5, 5), 0)},
    {"state": put((0, 0), 1)},
    {"approach": lambda d: np.float64(np.nan)},
    {"approach": lambda d: 1.1 * d},
    {"approach": lambda d: np.float64(1e308)},
    {"creepage": put(0, 0.05)},
    {"creepage": put(0, np.nan)},
    {"record": lambda r: r["certificate"].update(gap=-1.0)},
    {"record": lambda r: r["certificate"].update(residual="small")},
    {"record": lambda r: r["certificate"].update(level="best")},
])  # fmt: skip
def test_altered_files_are_not_believed(sol, changes, tmp_path):
    assert refused_or_certified_anew(altered(sol, tmp_path / "sol.nc", **changes))


@pytest.mark.long
def test_what_can_be_told_without_measuring_is_refused_in_any_case(sol, tmp_path):
    for changes in (
        {"traction": put((0, 5, 5), np.nan)},
        {"state": put((5, 5), 7)},
        {"approach": lambda d: np.float64(np.nan)},
    ):
        with pytest.raises(vc.OutputError, match="is damaged"):
            vc.load(altered(sol, tmp_path / "sol.nc", **changes), certify=False)


FIXED = {"surface": vc.Paraboloids(1.0, 1.5), "normal_force": None, "approach": 0.1}


@pytest.mark.parametrize(("given", "changes"), [
    (FIXED, {"approach": lambda d: 1.01 * d}),
    ({"motion": vc.Steady(Fx=-0.1, Fy=0.05, spin=0.1)}, {"creepage": put(1, np.nan)}),
    ({"motion": vc.Steady(Fx=-0.1)}, {"creepage": lambda v: v + np.array([0.01, 0, 0])}),
])  # fmt: skip
def test_nor_are_those_that_the_scene_does_not_have(given, changes, tmp_path):
    assert refused_or_certified_anew(
        altered(vc.solve(scene(**given)), tmp_path / "sol.nc", **changes)
    )


def test_a_certificate_of_other_tractions_is_made_anew(tmp_path):
    """FASTSIM's tractions with the certificate of the exact ones: consistent fields, and a lie."""
    exact, fast = vc.solve(scene()), vc.solve(scene(), tangential="fastsim-elliptic")
    dataclasses.replace(fast, certificate=exact.certificate).save(tmp_path / "sol.nc")
    again = vc.load(tmp_path / "sol.nc")
    assert (again.note, again.converged) == (ANEW, False)
    assert again.certificate.residual == pytest.approx(fast.certificate.residual, rel=1e-9)
    assert again.certificate.relative_gap == pytest.approx(fast.certificate.relative_gap, rel=1e-9)
    assert again.certificate.force_bound == pytest.approx(fast.certificate.force_bound, rel=1e-6)
    assert ANEW in again.report()
    assert "NOT CONVERGED" in again.report()
    assert again.summary()["note"] == ANEW


@pytest.mark.parametrize("name", ["relative_gap", "residual", "tangential_residual"])
def test_no_part_of_a_certificate_is_believed(name, tmp_path):
    fast = vc.solve(scene(), tangential="fastsim-elliptic")
    path = altered(
        fast, tmp_path / "sol.nc", record=lambda r: r["certificate"].update({name: 1e-16})
    )
    again = vc.load(path)
    assert again.note == ANEW
    assert getattr(again.certificate, name) == pytest.approx(
        getattr(fast.certificate, name), rel=1e-9
    )


@pytest.mark.parametrize("certify", [True, False])
@pytest.mark.parametrize("name", ["refined_shift", "refined_history"])
def test_solutions_of_an_earlier_version_by_refine_are_refused(name, certify):
    """Their fields can still be read, and the message says how."""
    path = DATA / f"{name}.nc"
    words = r"is of an earlier version, .* solve its scene with accuracy .* xarray\.open_dataset"
    refused(lambda: vc.load(path, certify=certify), "path", match=words, error=vc.OutputError)
    with xr.open_dataset(path) as fields:
        assert fields["traction_on_parts"].any()


def test_nor_are_steps_added_to_such_a_history(tmp_path):
    store = tmp_path / "history.nc"
    store.write_bytes((DATA / "refined_history.nc").read_bytes())
    refused(
        lambda: vc.solve(HISTORY, store=store),
        match="is of an earlier version",
        error=vc.OutputError,
    )


def test_as_stored_is_said(sol, tmp_path):
    sol.save(tmp_path / "sol.nc")
    again = vc.load(tmp_path / "sol.nc", certify=False)
    assert again.note == again.summary()["note"] == AS_STORED
    assert AS_STORED in again.report()
    assert AS_STORED not in sol.report()
    with pytest.raises(vc.SceneError, match="certify"):
        vc.load(tmp_path / "sol.nc", certify="perhaps")


def with_other_tractions(path, step):
    """Half the tractions in a step, and the checksum that fits them."""
    layout = checked_layout(path)
    content, at = bytearray(path.read_bytes()), layout.begin + step * layout.size
    with netcdf_file(path, "r", mmap=False) as file:
        old = file.variables["traction"][step].tobytes()
    new = (np.frombuffer(old, ">f8") * 0.5).astype(">f8").tobytes()
    record = bytes(content[at : at + layout.size - 4]).replace(old, new)
    content[at : at + layout.size] = record + zlib.crc32(record).to_bytes(4, "big")
    path.write_bytes(content)


def test_a_history_is_measured_step_by_step(tmp_path):
    """Lazily: what is wrong with a step is found when it, or what goes on from it, is asked for."""
    path = tmp_path / "history.nc"
    rolling = vc.Transient(steps=4, dq=0.1, vx=4e-3)
    vc.solve(dataclasses.replace(HISTORY, motion=rolling)).save(path)
    with_other_tractions(path, step=1)
    again = vc.load(path)
    assert len(again) == 4
    assert again[0].note == again[3].note == ""
    assert again[1].note == again[2].note == ANEW
    assert vc.load(path, certify=False)[2].note == AS_STORED


def test_a_step_by_itself_cannot_be_measured(tmp_path):
    vc.solve(HISTORY)[1].save(tmp_path / "step.nc")
    assert vc.load(tmp_path / "step.nc").note == ALONE
