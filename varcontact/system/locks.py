"""Locks on files: one writer at a time, in whatever process, thread or container it runs.

The kernel holds a lock for as long as the process lives, however that ends: none is left behind that has to be cleared.
"""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path

from filelock import FileLock, Timeout

LONGEST = 200
"""Bytes of a file's name up to which it is part of the names beside it; file systems take 255."""


class Held(Exception):
    """Somebody else holds the lock."""

    def __init__(self, holder: str) -> None:
        self.holder = holder
        super().__init__(holder)


def beside(path: Path, ending: str) -> Path:
    """The hidden file of an `ending` that goes with that at `path`: ``.run.nc.lock`` with ``run.nc``.

    A long name is replaced by its digest, so that the hidden one is not too long for the file system.
    """
    name = path.name if len(os.fsencode(path.name)) <= LONGEST else sha256(os.fsencode(path.name)).hexdigest()
    return path.with_name(f".{name}.{ending}")


@contextmanager
def locked(path: Path, patience: float = 0.0) -> Iterator[None]:
    """Hold the lock that goes with a file, named without symbolic links, while a block runs.

    The lock is on a file of its own, `beside` the other one, which may itself be replaced meanwhile.
    """
    lock, name = beside(path, "lock"), f"{os.getpid()} on {socket.gethostname()}"
    kernel = FileLock(lock, timeout=patience, poll_interval=0.02, thread_local=False)
    try:
        kernel.acquire()
    except (Timeout, RuntimeError):  # RuntimeError: held by this thread
        holder = ""
        with suppress(OSError):
            holder = lock.read_text(encoding="utf-8", errors="replace")[:100]
        raise Held("this process" if holder == name else f"process {holder}" if holder else "another process") from None
    try:
        lock.write_text(name, encoding="utf-8")
        yield
    finally:
        if sys.platform != "win32":  # removed while it is held: who opened it before finds it to be of no name
            lock.unlink(missing_ok=True)
        kernel.release()
