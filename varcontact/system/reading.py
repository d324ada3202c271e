"""Files read safely: whatever is wrong with one becomes an error that names it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from varcontact.errors import OutputError, SceneError, shortened

SCENE_BYTES = 2**24
"""Bytes of a scene file at most. Larger fields belong into files of their own, which it names."""


@contextmanager
def reading(path: str | Path, wrong: str = "is damaged") -> Iterator[None]:
    """Whatever the contents of a file make of the code that reads them becomes an error that names the file."""
    try:
        yield
    except OutputError:
        raise
    except Exception as error:  # HDF5, netCDF and JSON raise what they like where bytes were changed
        raise OutputError("path", path, f"{wrong} ({first_line(error)})") from None


def first_line(error: Exception) -> str:
    """The first line of what an error says; its name where it says nothing."""
    return str(error).split("\n")[0] or type(error).__name__


def regular(path: Path) -> bool:
    """Whether there is no device or pipe at `path`, which may never end, or never begin."""
    return not path.exists() or path.is_file() or path.is_dir()


def text_of(field: str, path: Path, most: int | None = None, kind: str = "a text file") -> str:
    """The text in a regular file, in UTF-8 with or without its mark."""
    try:
        if not regular(path):
            raise _unreadable(field, path, "is not a regular file")
        size = path.stat().st_size
        if most is not None and size > most:
            reason = f"has {size / 2**20:.1f} MiB, and may have {most / 2**20:.0f} MiB at most"
            raise _unreadable(field, path, f"{reason}; name large fields by {{file = ...}}")
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise _unreadable(field, path, f"is not {kind} (it is not UTF-8 text)") from None
    except OSError as error:
        raise _unreadable(field, path, f"cannot be read ({error.strerror})") from None
    except ValueError as error:  # a null character in the name
        raise _unreadable(field, path, f"cannot be read ({error})") from None


def _unreadable(field: str, path: Path, reason: str) -> SceneError:
    return SceneError(field, str(path), "a readable file", message=f"{field} {shortened(str(path), 200)} {reason}")
