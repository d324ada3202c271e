"""Files that are damaged, of another kind, or meant to be harmful: an error that names the file,
and nothing else.
"""

import contextlib
import json
import os
import random
import shutil
import struct
import subprocess
import sys
from functools import partial
from pathlib import Path

import h5py
import pytest

import varcontact as vc
from tests.command import ROLLING_SPHERES, assert_bad_input, run, scene_file
from tests.scenes import refused
from varcontact.io.records import checked_layout
from varcontact.io.solution import without_checksum
from varcontact.system.files import SCENE_BYTES
from varcontact.theories.table_book import TableBook

SCENE = scene_file(cells=6)
DATA = Path(__file__).parents[1] / "data"


@pytest.fixture(scope="module")
def files(tmp_path_factory, rolling):
    """A solution, a history and a sweep, by name, as bytes."""
    folder = tmp_path_factory.mktemp("whole")
    grid = vc.Grid(nx=6, ny=6)
    vc.solve(rolling(grid=grid)).save(folder / "solution.nc")
    motion, surface = vc.Transient(steps=2, vx=0.01), vc.Paraboloids(1.0, 0.8)
    vc.solve(
        rolling(grid=grid, surface=surface, normal_force=1e-3, motion=motion),
        store=folder / "history.nc",
    )
    vc.sweep(rolling(grid=grid), {"motion.vx": [0.01, 0.02]}, store=folder / "sweep.nc")
    return {name: (folder / f"{name}.nc").read_bytes() for name in ("solution", "history", "sweep")}


def read_all(path):
    """Everything that a file can be asked for."""
    if b"varcontact sweep index" in path.read_bytes():
        return [vc.read_sweep(path)]
    found = vc.load(path)
    if isinstance(found, vc.History):
        return [found.rolled, *(sol.report() for sol in found)]
    return [found.report()]


@pytest.mark.parametrize("name", ["solution", "sweep"])
def test_damage_that_keeps_hdf5_busy_for_ever(files, tmp_path, name):
    """Beyond Ctrl-C: the checksum is compared before HDF5 opens the file."""
    content, path = bytearray(files[name]), tmp_path / "damaged.nc"
    content[1873:2073] = bytes(200)
    path.write_bytes(content)
    read = vc.load if name == "solution" else vc.read_sweep
    refused(lambda: read(path), match=r"is damaged \(its bytes are not those", error=vc.OutputError)


def test_a_history_goes_on_from_steps_that_are_whole(rolling, tmp_path):
    """One flipped bit in a step, or an earlier version, whose steps have no checksum."""
    motion, grid = vc.Transient(steps=4, dq=0.2, vx=0.01), vc.Grid(nx=6, ny=6)
    scene, store = rolling(grid=grid, motion=motion), tmp_path / "run.nc"

    def stop(word):
        if word.startswith("3 of"):
            raise KeyboardInterrupt

    with pytest.raises(vc.Interrupted):
        vc.solve(scene, store=store, progress=stop)
    whole = store.read_bytes()
    content, layout = bytearray(whole), checked_layout(store)
    content[layout.begin + layout.size // 2] ^= 1
    store.write_bytes(content)
    for call in (
        lambda: vc.solve(scene, store=store),
        lambda: vc.load(store).normal_force,
        vc.load(store).to_xarray,
    ):
        refused(call, match=r"is damaged in step 0 \(its bytes are not those", error=vc.OutputError)
    assert store.read_bytes() == content
    shutil.copy(DATA / "history_format_1.nc", store)
    words = "was written by an earlier version, and can only be read; name a new file"
    earlier = vc.load(store)
    assert len(earlier) == 2
    refused(lambda: vc.solve(earlier.scene, store=store), match=words, error=vc.OutputError)


@pytest.mark.parametrize("seed", range(40))
def test_random_damage(files, tmp_path, seed):
    """Whatever bytes are changed: the file is refused, or what it says is measured."""
    chance, path = random.Random(seed), tmp_path / "damaged.nc"
    content = bytearray(files[chance.choice(["solution", "history", "history", "sweep"])])
    for _ in range(chance.choice([1, 3, 30])):
        content[chance.randrange(min(len(content), chance.choice([200, 4000, 10**9])))] = (
            chance.randrange(256)
        )
    if seed % 4 == 0:
        del content[chance.randrange(len(content)) :]
    if seed % 4 == 1:  # HDF5 once read on for ever
        content[1873:2073] = bytes(200)
    path.write_bytes(content)
    with contextlib.suppress(vc.OutputError):  # anything else fails
        assert read_all(path)


def rewritten(files, tmp_path, change):
    """The solution's file with its record changed."""
    path = tmp_path / "changed.nc"
    # whoever changes it on purpose leaves no checksum of before
    path.write_bytes(without_checksum(files["solution"]))
    with h5py.File(path, "r+") as file:
        text = file["record"][()].decode()
        del file["record"]
        file["record"] = change(text)
    return path


def with_entry(*keys, value):
    """A change of one entry of a record."""

    def change(text):
        record = json.loads(text)
        entry = record
        for key in keys[:-1]:
            entry = entry[key]
        entry[keys[-1]] = value
        return json.dumps(record)

    return change


@pytest.mark.parametrize("change", [
    lambda text: "null",
    lambda text: "[]",
    lambda text: "{",
    lambda text: "[" * 100_000,
    lambda text: "1" * 10_000,
    lambda text: text.replace("0.28", "1e308"),
    *(with_entry(*keys, value=value) for value in (None, "x", [[1, [2]], 3]) for keys in (
        ["scene"], ["scene", "bodies"], ["scene", "bodies", "G"], ["scene", "surface"], ["scene", "motion"],
        ["grid"], ["grid", "nx"], ["plan"], ["plan", "reasons"], ["plan", "sizes"], ["certificate"],
        ["certificate", "gap"], ["passes"], ["calls"], ["solved_by"], ["timing"],
        ["timing", "total"], ["iterations", "tangential"], ["branch"])),
    with_entry("branch", value="\x7f"),
    with_entry("timing", "tangential", value="héhé"),
    with_entry("timing", value={}),
    with_entry("status", "normal", value=3),
    with_entry("calls", "normal", value=[[]]),
])  # fmt: skip
def test_records_that_cannot_be(files, tmp_path, change):
    path = rewritten(files, tmp_path, change)
    # without sizes or calls, it is a record of an earlier version
    with contextlib.suppress(vc.OutputError):
        assert read_all(path)


@pytest.mark.parametrize(("keys", "value", "reason"), [
    (["timing"], {}, "no total time"),
    (["converged"], 1, "converged that is neither true nor false"),
    (["branch"], "\x7f", "a branch that there is not"),
])  # fmt: skip
def test_a_damaged_record_says_what_is_wrong(files, tmp_path, keys, value, reason):
    path = rewritten(files, tmp_path, with_entry(*keys, value=value))
    refused(lambda: vc.load(path), match=rf"is damaged \(.*{reason}\)", error=vc.OutputError)


def test_stored_records_name_no_files(files, tmp_path):
    """Else a file from somebody else would open any path, and tell its first line."""
    secret = tmp_path / "secret.txt"
    secret.write_text("a word of mine\n")
    named = {"file": str(secret)}
    sampled = {"kind": "sampled-distance", "h": named}
    started = {"kind": "transient", "steps": 2, "start": str(secret)}
    for keys, value in (
        (("scene", "friction"), named),
        (("scene", "surface"), sampled),
        (("scene", "motion"), started),
        (("scene", "motion"), {"kind": "transient", "steps": 2, "vx": named}),
    ):
        path = rewritten(files, tmp_path, with_entry(*keys, value=value))
        told = r"is damaged \(.*: only scene files may name files, stored ones not\)"
        refused(lambda path=path: vc.load(path), match=told, error=vc.OutputError)


def test_a_file_that_declares_more_than_there_is(tmp_path):
    """200000 by 200000 numbers in a few kilobytes."""
    path = tmp_path / "declares.nc"
    with h5py.File(path, "w") as file:
        file.attrs["format"] = "varcontact solution 1"
        file.create_dataset("pressure", shape=(2_000_000, 2_000_000), dtype="f8", chunks=(100, 100))
    with pytest.raises(vc.OutputError, match="cannot be read as netCDF"):
        vc.load(path)
    content = bytearray(b"CDF\x02" + struct.pack(">i", 2**31 - 1) + b"\0" * 64)
    path.write_bytes(content)
    with pytest.raises(vc.OutputError, match=r"declares\.nc"):
        read_all(path)


@pytest.mark.long
def test_no_traceback_of_another_library(tmp_path):
    """h5netcdf prints one of its own where a file is no HDF5."""
    (tmp_path / "text.nc").write_bytes(b"\x89HDF\r\n\x1a\n" + b"no such thing" * 100)
    code = "import varcontact as vc\ntry:\n    vc.load('text.nc')\nexcept vc.OutputError as error:\n    print(error)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("path = 'text.nc': cannot be read as netCDF")
    assert done.stderr == ""


# -------------------------------------------------------------------------------------- scene files


def test_a_byte_order_mark_is_accepted(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8-sig")
    assert vc.read_scene(tmp_path / "scene.toml")[0].friction == 0.3
    (tmp_path / "h.txt").write_text("1, 0, 1\n", encoding="utf-8-sig")
    line = SCENE.replace(
        'kind = "ellipse"\na = 1.0\nb = 1.0', 'kind = "sampled-distance"\nh = {file = "h.txt"}'
    )
    (tmp_path / "line.toml").write_text(
        line.replace("nx = 6\nny = 6", "nx = 3\nny = 1\ndx = 1.0\ndy = 1.0\nx0 = 0.0")
    )
    with pytest.raises(vc.SceneError, match=r"grid\.y0"):  # the file was read
        vc.read_scene(tmp_path / "line.toml")


@pytest.mark.parametrize("make", [os.mkfifo, partial(os.symlink, "/dev/zero")])
def test_sweeps_and_table_books_are_no_pipes_and_devices(make, tmp_path):
    path = tmp_path / "results.nc"
    make(path)
    for read in (vc.load, vc.read_sweep, TableBook.read):
        refused(lambda read=read: read(path), match="is not a regular file", error=vc.OutputError)


@pytest.mark.parametrize("make", [os.mkfifo, partial(os.symlink, "/dev/zero")])
def test_creepages_are_no_pipe_and_no_device(make, tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    make(tmp_path / "creepages.csv")
    done = run("scan", "scene.toml", "--creepages", "creepages.csv", folder=tmp_path)
    assert_bad_input(done, "is not a regular file")


@pytest.mark.parametrize("name", ["scene.toml", "friction.txt", "friction.npy", "start.nc"])
def test_pipes_are_refused(tmp_path, name):
    """Reading one would never end, or never begin."""
    os.mkfifo(tmp_path / name)
    if name != "scene.toml":
        entry = f'friction = {{file = "{name}"}}'
        text = SCENE.replace("friction = 0.3", entry)
        if name == "start.nc":
            text = SCENE.replace(
                'kind = "steady"', f'kind = "transient"\nsteps = 2\nstart = "{name}"'
            )
        (tmp_path / "scene.toml").write_text(text)
    done = run("solve", "scene.toml", folder=tmp_path)
    assert_bad_input(done, "regular file")
    assert name in done.stderr


def test_scene_files_have_a_size(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE + "#" * SCENE_BYTES)
    with pytest.raises(
        vc.SceneError,
        match=r"has 16\.0 MiB, and may have 16 MiB at most; name large fields by {file",
    ):
        vc.read_scene(path)


@pytest.mark.parametrize(("text", "words"), [
    (SCENE.replace("G = 1.0", f"G = {'9' * 5000}"), ["scene.toml", "is not a TOML file"]),
    (SCENE.replace("nx = 6", "nx = 0x" + "f" * 5000), ["grid.nx", "a number of thousands of digits"]),
    (SCENE.replace("vx = 0.05", "vx = 1e308"), ["motion.vx = 1e+308", "at most 1e+100 in size"]),
    (SCENE.replace("\na = 1.0", "\na = 1e-90").replace("\nb = 1.0", "\nb = 1e90"), ["a, b = (1e-90, 1e+90)"]),
    (SCENE + '[units]\nlength = "m\\u0000"\nforce = "N"\n', ["units.length", "printable"]),
    (SCENE.replace("friction = 0.3", "friction = [[0.3, 0.2], [0.1]]"), ["friction", "rows of equal length"]),
])  # fmt: skip
def test_entries_that_nothing_can_be_made_of(tmp_path, text, words):
    (tmp_path / "scene.toml").write_text(text)
    done = run("solve", "scene.toml", folder=tmp_path)
    for each in words:
        assert_bad_input(done, each)


def test_numbers_from_a_file_that_declares_too_many(tmp_path):
    header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (4000000, 4000000), }"
    header = header.ljust(117) + b"\n"
    (tmp_path / "f.npy").write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
    (tmp_path / "scene.toml").write_text(
        SCENE.replace("friction = 0.3", 'friction = {file = "f.npy"}')
    )
    assert_bad_input(
        run("plan", "scene.toml", folder=tmp_path), "must be a readable file of numbers"
    )


# -------------------------------------------------------------------------------- tables, terminals


def test_a_word_where_a_table_has_a_figure(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    arguments = ("compare", "scene.toml", "--methods", "tang", "--out", "t.csv")
    assert run(*arguments, folder=tmp_path).returncode == 0
    lines = (tmp_path / "t.csv").read_text().splitlines()
    cells = lines[1].split(",")
    cells[lines[0].split(",").index("Fx")] = "much"
    (tmp_path / "t.csv").write_text("\n".join([lines[0], ",".join(cells)]) + "\n")
    assert_bad_input(run(*arguments, folder=tmp_path), "column Fx has words where figures belong")


def test_cells_that_are_no_numbers(tmp_path):
    (tmp_path / "scene.toml").write_text(ROLLING_SPHERES)
    done = run("converge", "scene.toml", "--cells", "6²,8", folder=tmp_path)
    assert_bad_input(done, "cells[0] = '6²' is not allowed")


@pytest.mark.long
def test_units_that_a_terminal_or_a_formula_cannot_have(tmp_path, pictures):
    """A dollar sign is one; letters that the terminal lacks are escaped."""
    units = '[units]\nlength = "µm"\nforce = "$\\\\frac{N$"\n'
    (tmp_path / "scene.toml").write_text(SCENE + units, encoding="utf-8")
    command = [sys.executable, "-m", "varcontact", "solve", "scene.toml"]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, env=environment, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "\\xb5m" in done.stdout
    assert run("solve", "scene.toml", "--plot", "p.png", folder=tmp_path).returncode == 0
    assert (tmp_path / "p.png").read_bytes()[:4] == b"\x89PNG"


def test_pictures_that_need_latex(tmp_path):
    (tmp_path / "scene.toml").write_text(SCENE)
    done = run("solve", "scene.toml", "--plot", "p.pgf", folder=tmp_path)
    assert_bad_input(done, "the name must end in")
    assert ".pgf," not in done.stderr
