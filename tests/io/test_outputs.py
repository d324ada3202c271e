"""Outputs never destroy: what is written over, what is refused, and what a killed program
leaves.
"""

import dataclasses
import os
import stat
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from matplotlib.figure import Figure

import varcontact as vc
from tests.command import ROLLING_SPHERES, assert_bad_input, run
from tests.scenes import make_scene
from varcontact.plotting.style import check_picture, write_picture
from varcontact.system.files import only_writer, replacing, write_whole

PRESSED = ROLLING_SPHERES.partition("motion")[0].replace("friction = 0.3\n", "")
HISTORY = ROLLING_SPHERES.replace(
    '"steady", vx = 0.05', '"transient", steps = 2, dq = 0.1, Fx = -0.1'
)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scene.toml").write_text(ROLLING_SPHERES)
    (tmp_path / "history.toml").write_text(HISTORY)
    (tmp_path / "pressed.toml").write_text(PRESSED)
    return tmp_path


@pytest.fixture(scope="module")
def solution():
    return vc.solve(
        make_scene(vc.Paraboloids(Rx=100.0, Ry=100.0), friction=None, grid=vc.Grid(nx=6, ny=6))
    )


COMMANDS = {
    "solution": ("a.nc", ("solve", "scene.toml", "--out", "a.nc")),
    "history": ("a.nc", ("solve", "history.toml", "--out", "a.nc")),
    "comparison": ("a.csv", ("compare", "scene.toml", "--methods", "tang", "--out", "a.csv")),
    "convergence": (
        "a.csv",
        ("converge", "scene.toml", "--cells", "4,5", "--offsets", "1", "--store", "a.csv"),
    ),
    "picture": ("a.svg", ("solve", "pressed.toml", "--plot", "a.svg")),
}


@pytest.fixture(params=COMMANDS)
def command(request):
    """The file that a command writes, and the command."""
    return COMMANDS[request.param]


def link_to_device(path):
    """A link to a device of the test's own: the superuser would lose the machine's where the check
    fails.
    """
    device = path.with_name("device")
    try:
        os.mknod(device, stat.S_IFCHR | 0o666, os.makedev(1, 3))
    except PermissionError:  # then nor can /dev/null be replaced
        device = os.devnull
    path.symlink_to(device)


@pytest.mark.parametrize("make", [link_to_device, os.mkfifo])
def test_devices_and_pipes_are_left_alone(folder, command, make):
    """Under a fitting name; a device by a symbolic link to it."""
    name, arguments = command
    make(folder / name)
    before = os.lstat(folder / name).st_mode, os.stat(folder / name).st_mode
    assert_bad_input(run(*arguments, folder=folder), "is a device or a pipe, not a file")
    assert (os.lstat(folder / name).st_mode, os.stat(folder / name).st_mode) == before


@pytest.mark.parametrize("link", [os.symlink, os.link])
def test_the_scene_is_not_written_over(folder, command, link):
    """Whatever name it has, and even by force."""
    name, arguments = command
    before = (folder / arguments[1]).read_bytes()
    link(folder / arguments[1], folder / name)
    assert_bad_input(
        run(*arguments, "--force", folder=folder),
        f"is the same file as '{arguments[1]}', which would be lost",
    )
    assert (folder / arguments[1]).read_bytes() == before


@pytest.mark.long
def test_a_link_stays_and_its_file_is_written(folder, command):
    """One to nothing as well: then the file is made."""
    name, arguments = command
    (folder / "elsewhere").mkdir()
    (folder / name).symlink_to(os.path.join("elsewhere", name))
    for _ in range(2):
        done = run(*arguments, folder=folder)
        assert done.returncode == 0, done.stderr
        assert os.readlink(folder / name) == os.path.join("elsewhere", name)
        assert (
            os.listdir(folder / "elsewhere") == [name]
            and (folder / "elsewhere" / name).stat().st_size > 100
        )


def test_a_file_of_somebody_else_is_left_alone(folder, command):
    """By force solutions and pictures are written over it; tables and histories never are."""
    name, arguments = command
    (folder / name).write_text("my,own\n1,2\n")
    assert_bad_input(run(*arguments, folder=folder), "")
    assert (folder / name).read_text() == "my,own\n1,2\n"
    forced = run(*arguments, "--force", folder=folder)
    if name == "a.csv" or "history.toml" in arguments:
        assert_bad_input(
            forced,
            "is not a table of" if name == "a.csv" else "exists already and holds no history",
        )
        assert (folder / name).read_text() == "my,own\n1,2\n"
    else:
        assert forced.returncode == 0, forced.stderr
        assert b"my,own" not in (folder / name).read_bytes()


@pytest.mark.long
def test_what_varcontact_wrote_is_written_again(folder, command):
    """No force is needed for it, nor for an empty file."""
    name, arguments = command
    (folder / name).touch()
    (folder / name).chmod(0o640)
    for _ in range(2):
        done = run(*arguments, folder=folder)
        assert done.returncode == 0, done.stderr
    assert stat.S_IMODE((folder / name).stat().st_mode) == 0o640, "its permissions are kept"
    assert sorted(os.listdir(folder)) == sorted(
        [name, "history.toml", "pressed.toml", "scene.toml"]
    ), "nothing else is left"


@pytest.mark.parametrize("ending", ["png", "pdf", "svg", "eps"])
def test_pictures_are_known_by_what_they_say(tmp_path, ending):
    """One that varcontact drew may be drawn again; one that matplotlib drew for somebody else needs
    force.
    """
    path = tmp_path / f"a.{ending}"
    write_picture(Figure(), path)
    check_picture(path, [], overwrite=False)
    Figure().savefig(path)
    with pytest.raises(vc.OutputError, match="exists already and is no picture of varcontact's"):
        check_picture(path, [], overwrite=False)


@pytest.mark.long
def test_a_history_is_not_written_over_by_a_solution(folder):
    """Nor the other way round: each may be days of work."""
    run("solve", "history.toml", "--out", "a.nc", folder=folder)
    before = (folder / "a.nc").read_bytes()
    assert_bad_input(
        run("solve", "scene.toml", "--out", "a.nc", folder=folder),
        "--out = 'a.nc': exists already and is no solution of varcontact's; name another file, or add --force",
    )
    assert (folder / "a.nc").read_bytes() == before
    assert run("solve", "scene.toml", "--out", "a.nc", "--force", folder=folder).returncode == 0
    assert_bad_input(
        run("solve", "history.toml", "--out", "a.nc", folder=folder),
        "exists already and holds no history",
    )


@pytest.mark.long
def test_threads_that_save_in_one_folder_do_not_mix(solution, tmp_path):
    """Each file holds its own solution; one that all write holds the whole of one of them."""
    solutions = [
        vc.solve(dataclasses.replace(solution.scene, normal_force=1.0 + i)) for i in range(4)
    ]

    def save(i):
        for _ in range(2):
            solutions[i].save(tmp_path / f"{i}.nc")
            solutions[i].save(tmp_path / "all.nc")

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(save, range(4)))  # raises what a thread raised
    assert [vc.load(tmp_path / f"{i}.nc").normal_force for i in range(4)] == [
        sol.normal_force for sol in solutions
    ]
    assert vc.load(tmp_path / "all.nc").normal_force in [sol.normal_force for sol in solutions]
    assert sorted(os.listdir(tmp_path)) == ["0.nc", "1.nc", "2.nc", "3.nc", "all.nc"]


KILLED = """
import os, signal
from pathlib import Path
from varcontact.system.files import only_writer, replacing
with only_writer("store", Path("run.nc")), replacing("store", Path("run.nc")) as file:
    file.write(b"half")
    file.flush()
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_program_left_is_cleared_by_the_next(tmp_path):
    """But not what somebody is writing whose file's name only begins the same."""
    path, other = tmp_path / "run.nc", tmp_path / "run.nc.nc"
    subprocess.run([sys.executable, "-c", KILLED], cwd=tmp_path, check=False)
    assert len(os.listdir(tmp_path)) == 2, "the lock file and the half-written one"
    with only_writer("store", other), replacing("store", other) as file:
        file.write(b"other")
        write_whole("store", path, b"whole")
    assert {name: (tmp_path / name).read_bytes() for name in os.listdir(tmp_path)} == {
        "run.nc": b"whole",
        "run.nc.nc": b"other",
    }
