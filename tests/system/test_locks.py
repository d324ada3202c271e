"""Locks of files, between threads and between processes that may be killed."""

import os
import signal
import subprocess
import sys
import threading

import pytest

from varcontact.system.files import Held, locked

HOLDER = """
import sys, time
from pathlib import Path
from varcontact.system.files import locked
with locked(Path("run.nc")):
    print("held", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the lock of ``run.nc``."""
    process = subprocess.Popen([sys.executable, "-c", HOLDER], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "held\n"
    yield process
    process.kill()
    process.communicate()


def test_another_process_is_named_and_not_waited_for(holder, tmp_path):
    with pytest.raises(Held, match=rf"^process {holder.pid} on "), locked(tmp_path / "run.nc"):
        pass


def test_the_lock_of_a_killed_process_is_free(holder, tmp_path):
    """Its file is still there, and is removed by the next who had it."""
    holder.send_signal(signal.SIGKILL)
    holder.wait()
    assert os.listdir(tmp_path) == [".run.nc.lock"]
    with locked(tmp_path / "run.nc"):
        pass
    assert os.listdir(tmp_path) == []


def test_one_thread_at_a_time(tmp_path):
    """Four threads count in a file, reading and writing in two steps: without a lock they lose some."""
    path = tmp_path / "count"
    path.write_text("0")

    def count():
        for _ in range(10):
            with locked(path, patience=60):
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
    with locked(tmp_path / "run.nc"), pytest.raises(Held, match=r"^this process$"), locked(tmp_path / "run.nc"):
        pass


def test_an_exception_frees_the_lock(tmp_path):
    with pytest.raises(KeyboardInterrupt), locked(tmp_path / "run.nc"):
        raise KeyboardInterrupt
    with locked(tmp_path / "run.nc"):
        assert os.listdir(tmp_path) == [".run.nc.lock"]
