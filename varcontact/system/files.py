"""Files written safely: atomically, by one process at a time, and never over files of others.

- Only regular files are written. A symbolic link stays, and the file that it names is written.
- A file that is there already is replaced only if it holds what varcontact wrote, of the same kind:
  a solution by a solution, a history by a history, a picture by a picture. Stores, to which a study
  adds, are never replaced.
- The new content is written under another name, forced to the disk, and renamed. Killed in between,
  the program leaves the old file as it was, and the next to write that file takes away the rest.
"""

from __future__ import annotations

import os
import re
import stat
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any, BinaryIO

from varcontact import checks
from varcontact.errors import OutputError, SceneError, shortened

PATIENCE = 10.0
"""Seconds for which a file that is written at once waits for another that is just being written in
its place."""


def check_ending(field: str, path: Path, *endings: str) -> None:
    """Refuse a file name that has none of these endings."""
    if path.suffix.lower() not in endings:
        raise OutputError(field, path, f"the name must end in {', '.join(endings)}")


@contextmanager
def reading(
    path: str | Path,
    wrong: str = "is damaged",
    field: str = "path",
    errors: type[Exception] | tuple[Any, ...] = Exception,
) -> Iterator[None]:
    """Context in which errors of code that reads a file become an `OutputError` that names it."""
    try:
        yield
    except (OutputError, MemoryError):
        raise
    except errors as error:  # HDF5, netCDF and JSON may raise anything for damaged bytes
        raise OutputError(field, path, f"{wrong} ({first_line(error)})") from error


def writing(field: str, path: Path) -> AbstractContextManager[None]:
    """Context in which failures to write a file (circular links, a null character in its name)
    become an `OutputError` that names it.
    """
    return reading(path, "cannot be written", field, (OSError, RuntimeError, ValueError))


def check_writable(
    field: str, path: Path, endings: Iterable[str], inputs: Iterable[Path] = ()
) -> None:
    """Refuse what could not, or must not, be written, before any work is done for it."""
    check_ending(field, path, *endings)
    with writing(field, path):
        target = path.resolve()
        if not target.parent.is_dir():
            folder = target.parent if path.is_symlink() else path.parent
            raise OutputError(field, path, f"there is no folder {str(folder)!r}")
        there = _is_there(field, path)
        for other in inputs:
            if there and other.exists() and target.samefile(other):
                reason = (
                    f"is the same file as {str(other)!r}, which would be lost; name another file"
                )
                raise OutputError(field, path, reason)
        if there and not os.access(target, os.W_OK):
            raise OutputError(field, path, "may not be written")
        tempfile.NamedTemporaryFile(dir=target.parent, prefix=beside(target, "part").name).close()


def check_replaceable(
    field: str,
    path: Path,
    endings: Iterable[str],
    kind: str,
    ours: bytes,
    overwrite: bool,
    inputs: Iterable[Path] = (),
) -> None:
    """Check that a file may be written, and refuse one that does not begin as `ours`, a regular
    expression, unless it may be overwritten.
    """
    check_writable(field, path, endings, inputs)
    overwrite = checks.flag("overwrite", overwrite)
    with writing(field, path):
        if overwrite or not path.exists() or path.stat().st_size == 0:
            return
        with path.open("rb") as file, mmap(file.fileno(), 0, access=ACCESS_READ) as content:
            if re.match(ours, content, re.DOTALL):
                return
    how = "add --force" if field.startswith("-") else "give overwrite=True"
    raise OutputError(
        field, path, f"exists already and is no {kind} of varcontact's; name another file, or {how}"
    )


def begins_with(path: Path, head: bytes) -> bool:
    """True for a file with this beginning."""
    with path.open("rb") as file:
        return file.read(len(head)) == head


@contextmanager
def only_writer(field: str, path: Path, patience: float = 0.0) -> Iterator[None]:
    """Context in which this process is the only one to write a file; waits some seconds for
    another.

    The lock is on a file of its own, `beside` the other one, which may itself be replaced
    meanwhile.
    """
    import socket

    from filelock import FileLock, Timeout

    lock = beside(path.resolve(), "lock")
    name = f"process {os.getpid()} on {socket.gethostname()}"
    kernel = FileLock(lock, timeout=patience, poll_interval=0.02, thread_local=False)
    with writing(field, path):
        try:
            kernel.acquire()
        except (Timeout, RuntimeError):  # RuntimeError: held by this thread
            holder = ""
            with suppress(OSError):
                holder = lock.read_text(encoding="utf-8", errors="replace")[:100]
            who = holder or "another process"
            if holder == name:
                who = "this process"
            reason = f"is being written by {who}; wait until that is done, or name another file"
            raise OutputError(field, path, reason) from None
    try:
        with suppress(OSError):  # a full disk
            lock.write_text(name, encoding="utf-8")
        yield
    finally:
        # removed while locked: a process that opened it before finds that it has no name
        if sys.platform != "win32":
            lock.unlink(missing_ok=True)
        kernel.release()


@contextmanager
def replacing(field: str, path: Path) -> Iterator[BinaryIO]:
    """A new file, open for writing, that takes the place of another when the block ends well.

    Whatever ends it in between, the old file stays as it was. The block is within one of
    `only_writer`.
    """
    target = path.resolve()
    part = beside(target, "part")
    try:
        with writing(field, path):
            there = _is_there(field, path)
            part.unlink(missing_ok=True)  # of a writer that was killed
            with part.open("xb") as file:  # not by tempfile, whose files nobody else may read
                if there:
                    part.chmod(stat.S_IMODE(target.stat().st_mode))
                yield file
                file.flush()
                os.fsync(file.fileno())
            os.replace(part, target)
    finally:
        part.unlink(missing_ok=True)


def write_whole(field: str, path: Path, content: bytes) -> None:
    """Write a file atomically."""
    with only_writer(field, path, PATIENCE), replacing(field, path) as file:
        file.write(content)


def _is_there(field: str, path: Path) -> bool:
    """True if a file exists; OutputError for a folder, a device or a pipe."""
    if path.is_dir():
        raise OutputError(field, path, "is a folder")
    if not regular(path):
        raise OutputError(field, path, "is a device or a pipe, not a file")
    return path.exists()


def beside(path: Path, ending: str) -> Path:
    """The hidden file of an `ending` that goes with that at `path`: ``.run.nc.lock`` with
    ``run.nc``.
    """
    return path.with_name(f".{path.name}.{ending}")


SCENE_BYTES = 2**24
"""Bytes of a scene file at most. Larger fields belong into files of their own, which it names."""


def first_line(error: Exception) -> str:
    """Message of an error: the system's text, else the first line of its own, else its class
    name.
    """
    return getattr(error, "strerror", None) or str(error).split("\n")[0] or type(error).__name__


def regular(path: Path) -> bool:
    """False for a device or a pipe at `path`: reading may never end, or never begin."""
    return not path.exists() or path.is_file() or path.is_dir()


def check_regular(field: str, path: Path) -> None:
    """Refuse a device or a pipe, see `regular`."""
    if not regular(path):
        raise OutputError(field, path, "is not a regular file")


def text_of(field: str, path: Path, most: int | None = None, kind: str = "a text file") -> str:
    """The text in a regular file, in UTF-8 with or without its mark."""
    try:
        size = path.stat().st_size
        if not regular(path):
            reason = "is not a regular file"
        elif most is not None and size > most:
            reason = f"has {size / 2**20:.1f} MiB, and may have {most / 2**20:.0f} MiB at most"
            reason += "; name large fields by {file = ...}"
        else:
            return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        reason = f"is not {kind} (it is not UTF-8 text)"
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = f"cannot be read ({first_line(error)})"
    raise SceneError(
        field, str(path), "a readable file", message=f"{field} {shortened(str(path), 200)} {reason}"
    )
