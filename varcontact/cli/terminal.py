"""Standard output, progress, files to be written, clusters, and exit statuses."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, NoReturn

from varcontact.errors import Interrupted, OutputError, SceneError, WorkersLost
from varcontact.system.progress import shown_progress

BAD_INPUT = 2
NOT_SOLVED = 3
INTERRUPTED = 130


def show(text: str) -> None:
    """Print on standard output; a closed pipe is no error."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        raise OutputError("standard output", "", f"cannot be written ({error.strerror})") from None


@contextlib.contextmanager
def progress_line() -> Iterator[Callable[[object], None]]:
    """A function that shows the stage on standard error, if that is a terminal.

    What solvers print goes to standard error, too.
    """
    with contextlib.redirect_stdout(sys.stderr), shown_progress() as show:
        show("reading")
        yield show


def study(
    work: Callable[..., Any],
    written: Callable[[Any], str],
    store: Path | None,
    option: str,
    what: str,
) -> Any:
    """Run a study with its progress and print its result; after Ctrl-C print the finished part, and
    how to resume.
    """
    try:
        with progress_line() as progress:
            result = work(progress=progress)
    except Interrupted as stopped:
        if len(getattr(stopped.partial, "runs", stopped.partial)):
            show(written(stopped.partial))
        stop(stopped, store, option, what)
    show(written(result))
    return result


def draw(path: Path | None, picture: Callable[..., Any], *drawn: Any, **options: Any) -> None:
    """Write a picture, if one was requested."""
    if path is not None:
        from varcontact.plotting.style import write_picture

        write_picture(picture(*drawn, **options), path)


@contextlib.contextmanager
def cluster(address: str | None, workers: int) -> Iterator[Any]:
    """The executor of a dask cluster by the address of its scheduler; None without an address."""
    if address is None:
        yield None
        return
    if workers != 1:
        raise SceneError("--workers", workers, "left out: the cluster of --dask has its own")
    try:
        from distributed import Client
    except ModuleNotFoundError:
        message = '--dask needs a package that is not installed: pip install "varcontact[dask]"'
        raise SceneError("--dask", address, "left out", message=message) from None
    try:
        client = Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError) as error:
        words = str(error).splitlines()[0]
        raise SceneError(
            "--dask", address, f"the address of a running scheduler ({words})"
        ) from None
    with client:
        yield client.get_executor()


def check_outputs(
    out: Path | None,
    plot: Path | None,
    inputs: list[Path],
    force: bool,
    endings: Iterable[str] = (".csv",),
    name_of_out: str = "--out",
) -> None:
    """Refuse files that cannot, or must not, be written; `endings` are the suffixes that `out` may
    have.
    """
    from varcontact.system.files import check_writable

    if out is not None:
        check_writable(name_of_out, out, endings, inputs)
    if plot is not None:
        from varcontact.plotting.style import check_picture

        check_picture(plot, inputs if out is None else [*inputs, out], force)


def stop(
    stopped: Interrupted | WorkersLost, store: Path | None, option: str, what: str
) -> NoReturn:
    """After Ctrl-C, or a loss of workers: say what is kept, or which option keeps it, and exit."""
    if store is None:
        kept = (
            f"nothing is kept; with {option}, finished {what} are kept "
            "and the same command resumes from there"
        )
    elif store.exists():
        kept = f"finished {what} are kept in {store}, and the same command resumes from there"
    else:
        kept = (
            f"nothing is kept in {store} yet, and the same command starts again from the beginning"
        )
    fail(f"{stopped}; {kept}", NOT_SOLVED if isinstance(stopped, WorkersLost) else INTERRUPTED)


def fail(error: object, status: int) -> NoReturn:
    """Print an error on standard error and exit with a `status`."""
    print(f"varcontact: {error}", file=sys.stderr)
    raise SystemExit(status)
