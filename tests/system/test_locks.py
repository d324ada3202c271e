"""Locks of files, between threads and between processes that may be killed."""

import math
import os
import resource
import signal
import subprocess
import sys
import threading

import psutil
import pytest

from varcontact.errors import OutputError, TooLarge
from varcontact.system.files import only_writer
from varcontact.system.process import available, left_by_control_groups, need

HOLDER = """
import sys, time
from pathlib import Path
from varcontact.system.files import only_writer
with only_writer("store", Path("run.nc")):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the lock of ``run.nc``."""
    process = subprocess.Popen(
        [sys.executable, "-c", HOLDER], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.communicate()


def test_another_process_is_named_and_not_waited_for(holder, tmp_path):
    with (
        pytest.raises(OutputError, match=f"is being written by process {holder.pid} on "),
        only_writer("store", tmp_path / "run.nc"),
    ):
        pass


def test_the_lock_of_a_killed_process_is_free(holder, tmp_path):
    """Its file is still there, and is removed by the next who had it."""
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert os.listdir(tmp_path) == [".run.nc.lock"]
    with only_writer("store", tmp_path / "run.nc"):
        pass
    assert os.listdir(tmp_path) == []


def test_one_thread_at_a_time(tmp_path):
    """Four threads count in a file, reading and writing in two steps: without a lock they lose
    some.
    """
    path = tmp_path / "count"
    path.write_text("0")

    def count():
        for _ in range(10):
            with only_writer("store", path, patience=60):
                value = int(path.read_text())
                threading.Event().wait(1e-4)
                path.write_text(str(value + 1))

    threads = [threading.Thread(target=count) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert path.read_text() == "40"
    assert os.listdir(tmp_path) == ["count"]


def test_a_lock_within_itself_is_refused(tmp_path):
    with (
        only_writer("store", tmp_path / "run.nc"),
        pytest.raises(OutputError, match="by this process"),
        only_writer("store", tmp_path / "run.nc"),
    ):
        pass


def test_an_exception_frees_the_lock(tmp_path):
    with pytest.raises(KeyboardInterrupt), only_writer("store", tmp_path / "run.nc"):
        raise KeyboardInterrupt
    with only_writer("store", tmp_path / "run.nc"):
        assert os.listdir(tmp_path) == [".run.nc.lock"]


# -------------------------------------------------------------------------- The memory that is left


def tree(root, files):
    """Files below a folder that stands for the root of the file system."""
    for name, text in files.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    return root


LIMITED = {
    "proc/self/cgroup": "0::/user.slice/job\n",
    "sys/fs/cgroup/user.slice/job/memory.max": "max\n",
    "sys/fs/cgroup/user.slice/job/memory.current": "500\n",
    "sys/fs/cgroup/user.slice/memory.max": "3000\n",
    "sys/fs/cgroup/user.slice/memory.current": "1200\n",
    "sys/fs/cgroup/user.slice/memory.stat": "anon 900\ninactive_file 300\n",
}


@pytest.mark.parametrize(("files", "left"), [
    (LIMITED, 2100),  # of the group above: its own has no limit
    (LIMITED | {"sys/fs/cgroup/user.slice/job/memory.max": "1500\n"}, 1000),
    ({"proc/self/cgroup": "0::/\n"}, math.inf),
    ({}, math.inf),
])  # fmt: skip
def test_control_groups(tmp_path, files, left):
    assert left_by_control_groups(tree(tmp_path, files)) == left


def test_no_more_than_the_machine_has():
    assert 0 < available() <= psutil.virtual_memory().total


def test_limited_address_space_counts():
    """As after ``ulimit -v``: matrices beyond it are refused, though the machine had room."""
    before, hard = resource.getrlimit(resource.RLIMIT_AS)
    taken = psutil.Process().memory_info().vms
    resource.setrlimit(resource.RLIMIT_AS, (taken + 200 * 2**20, hard))
    try:
        assert available() <= 200 * 2**20
        with pytest.raises(TooLarge, match="the problem"):
            need("the problem", 201.0 * 2**20, "a smaller one would fit")
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, hard))
    assert available() < math.inf
