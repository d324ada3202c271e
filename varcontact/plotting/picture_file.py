"""Pictures as files."""

from __future__ import annotations

import io
import mmap
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING

from varcontact.errors import OutputError
from varcontact.system.files import check_replaceable, check_writable, first_line, write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FIELD = "--plot"
MARK = "Drawn by varcontact"
"""What a picture says of itself, so that a later run may draw it again in the same file."""

_SIGNED = {"png": "Software", "pdf": "Creator", "svg": "Creator", "ps": "Creator", "eps": "Creator"}
"""Where pictures of each kind can say it; those of other kinds cannot."""


def check_picture(path: Path, inputs: list[Path], overwrite: bool) -> None:
    """Refuse a picture that could not, or must not, be written, before any work is done for it.

    Parameters
    ----------
    path : Path
    inputs : list of Path
        Files that have to stay: what is read, and what else is written.
    overwrite : bool
        Whether to replace a file that is no picture which varcontact wrote.

    Raises
    ------
    OutputError
        For an ending that matplotlib does not know, a place that cannot be written, or a file that is another's.
    """
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib.backend_bases import FigureCanvasBase

    check_writable(FIELD, path, inputs)
    kinds = set(FigureCanvasBase.get_supported_filetypes())
    if which(mpl.rcParams["pgf.texsystem"]) is None:
        kinds.discard("pgf")  # LaTeX draws it
    if _kind(path) not in kinds:
        raise OutputError(FIELD, path, f"its ending must be one of {', '.join('.' + kind for kind in sorted(kinds))}")
    check_replaceable(FIELD, path, "picture", is_ours, overwrite)


def write_picture(figure: Figure, path: Path) -> None:
    """Write a `figure` to the file at `path` in the format of its ending, whole or not at all.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    picture, kind = io.BytesIO(), _kind(path)
    try:
        figure.savefig(picture, format=kind, dpi=300, metadata={_SIGNED[kind]: MARK} if kind in _SIGNED else None)
    except (OSError, RuntimeError, ValueError) as error:  # pgf without LaTeX, for one
        raise OutputError(FIELD, path, f"cannot be drawn ({first_line(error)})") from None
    write_whole(FIELD, path, picture.getvalue())


def is_ours(path: Path) -> bool:
    """Whether the picture at `path` says that varcontact drew it."""
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        return content.find(MARK.encode()) >= 0


def _kind(path: Path) -> str:
    return path.suffix[1:].lower()
