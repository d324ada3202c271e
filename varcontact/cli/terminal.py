"""What commands share: standard output, progress, files to be written, the way out."""

from __future__ import annotations

import contextlib
import os
import sys
from pathlib import Path
from typing import Any, NoReturn

from varcontact.errors import Interrupted, OutputError

BAD_INPUT, NOT_SOLVED, INTERRUPTED = 2, 3, 130
FORCE = "Replace files that varcontact did not write; a table or a history is only ever added to."


def show(text: str) -> None:
    """Print on standard output, whatever letters the terminal has, and whether or not somebody still reads.

    Parameters
    ----------
    text : str

    Raises
    ------
    OutputError
        If standard output cannot be written.
    """
    try:
        try:
            print(text, flush=True)
        except UnicodeEncodeError:  # a terminal that does not have the letters of a unit
            encoding = sys.stdout.encoding
            print(text.encode(encoding, "backslashreplace").decode(encoding), flush=True)
    except BrokenPipeError:  # the reader has gone: nothing wrong, and nothing more to say
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        raise OutputError("standard output", "", f"cannot be written ({error.strerror})") from None


def with_progress(work: Any) -> Any:
    """Run with the name of the stage on standard error, where that is a terminal; solvers print there, too.

    Parameters
    ----------
    work : callable
        Takes a function that is told the stage, or None, and returns the result.
    """
    from rich.console import Console

    console = Console(stderr=True)
    with contextlib.redirect_stdout(sys.stderr):
        if not console.is_terminal:
            return work(None)
        with console.status("reading") as status:
            return work(status.update)


def check_outputs(
    out: Path | None,
    plot: Path | None,
    inputs: list[Path],
    force: bool,
    ending: str | tuple[str, ...] = ".csv",
    name_of_out: str = "--out",
) -> None:
    """Refuse files that could not, or must not, be written, before any work is done for them.

    Parameters
    ----------
    out, plot : Path, optional
        Results and picture.
    inputs : list of Path
        Files that are read, and must not be overwritten.
    force : bool
        Whether files of others may be replaced.
    ending : str or tuple of str, optional
        The suffix `out` has to have, or those of a solution.
    name_of_out : str, optional
        The option that names `out`.

    Raises
    ------
    OutputError
        If a file cannot, or must not, be written.
    """
    from varcontact.plotting.picture_file import check_picture
    from varcontact.system.files import check_ending, check_one_of_endings, check_writable

    if out is not None:
        if isinstance(ending, tuple):
            check_one_of_endings(name_of_out, out, "solutions", ending)
        else:
            check_ending(name_of_out, out, ending)
        check_writable(name_of_out, out, inputs)
    if plot is not None:
        check_picture(plot, inputs if out is None else [*inputs, out], force)


def stop(stopped: Interrupted, store: Path | None, option: str, what: str) -> NoReturn:
    """After Ctrl-C: say what is kept and how to go on, and leave.

    Parameters
    ----------
    stopped : Interrupted
    store : Path, optional
        The file that keeps what is finished.
    option : str
        The option that would have named such a file.
    what : str
        What is finished one by one, in the plural.
    """
    if store is None:
        kept = f"nothing is kept; with {option}, finished {what} are kept and the same command resumes from there"
    elif store.exists():
        kept = f"finished {what} are kept in {store}, and the same command resumes from there"
    else:
        kept = f"nothing is kept in {store} yet, and the same command starts again from the beginning"
    fail(f"{stopped}; {kept}", INTERRUPTED)


def fail(error: object, status: int) -> NoReturn:
    """Say what went wrong on standard error, and leave.

    Parameters
    ----------
    error : object
    status : int
        The exit status.
    """
    print(f"varcontact: {error}", file=sys.stderr)
    raise SystemExit(status)
