"""Locks on files: one writer at a time, in whatever process, thread or container it runs.

The kernel holds a lock for as long as the process lives, however that ends: none is left behind that has to be cleared.
"""

from __future__ import annotations

import errno
import os
import socket
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

PAUSE = 0.02
"""Seconds between two looks at a lock that somebody else holds."""
LONGEST = 200
"""Bytes of a file's name up to which it is part of the names beside it; file systems take 255."""
FAR = 1 << 30
"""The byte of a lock file that is locked on Windows, where nobody can read what is locked."""


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
    """Hold the lock that goes with a file while a block runs.

    The lock is on a file of its own, `beside` the other one, which may itself be replaced meanwhile. Where the file
    system knows no locks, everybody gets one.
    """
    lock, until = beside(path, "lock"), time.monotonic() + patience
    while (descriptor := _taken(lock)) is None:
        if time.monotonic() >= until:
            raise Held(_holder(lock))
        time.sleep(PAUSE)
    try:
        yield
    finally:
        if sys.platform == "win32":  # open files cannot be removed there
            os.close(descriptor)
            with suppress(OSError):
                lock.unlink()
        else:  # removed while it is held: whoever opened it before finds that it is no longer the file of that name
            lock.unlink(missing_ok=True)
            fcntl.flock(descriptor, fcntl.LOCK_UN)  # processes forked meanwhile have it open as well
            os.close(descriptor)


def _taken(lock: Path) -> int | None:
    """The lock file, open, locked and still the one of that name; None where somebody else holds it."""
    descriptor = os.open(lock, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        if _granted(descriptor) and _is_still(descriptor, lock):
            os.ftruncate(descriptor, 0)
            os.lseek(descriptor, 0, os.SEEK_SET)
            os.write(descriptor, _name().encode())
            return descriptor
    except BaseException:
        os.close(descriptor)
        raise
    os.close(descriptor)
    return None


def _granted(descriptor: int) -> bool:
    """Whether the kernel grants the lock of an open file, or knows no locks there."""
    try:
        if sys.platform == "win32":
            os.lseek(descriptor, FAR, os.SEEK_SET)
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        return error.errno not in (errno.EAGAIN, errno.EACCES, errno.EDEADLK)
    return True


def _is_still(descriptor: int, lock: Path) -> bool:
    """Whether an open file is that of a name: the holder before may have removed it since it was opened."""
    try:
        return os.path.samestat(os.fstat(descriptor), lock.stat())
    except FileNotFoundError:
        return False


def _name() -> str:
    return f"{os.getpid()} on {socket.gethostname()}"


def _holder(lock: Path) -> str:
    """Who holds a lock, as far as the lock file says."""
    try:
        name = lock.read_text(encoding="utf-8", errors="replace")[:100]
    except OSError:
        name = ""
    if name == _name():
        return "this process"
    return f"process {name}" if name else "another process"
