"""What commands that sweep share: where scenes are solved, and how far they are."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from typing import Any

from varcontact.errors import SceneError


@contextlib.contextmanager
def cluster(address: str | None, workers: int) -> Iterator[Any]:
    """The executor of a dask cluster, where one is named.

    Parameters
    ----------
    address : str or None
        Of its scheduler.
    workers : int
        Own processes that are asked for as well: they are not both had.

    Raises
    ------
    SceneError
        If there is no such scheduler, or nothing to ask it with.
    """
    if address is None:
        yield None
        return
    if workers != 1:
        raise SceneError("--workers", workers, "left out: the cluster of --dask has its own")
    try:
        from distributed import Client
    except ModuleNotFoundError:
        install = 'pip install "varcontact[dask]"'
        message = f"--dask needs a package that is not installed: {install}"
        raise SceneError("--dask", address, "left out", message=message) from None
    try:
        client = Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError) as error:
        words = str(error).splitlines()[0]
        raise SceneError("--dask", address, f"the address of a running scheduler ({words})") from None
    with client:
        yield client.get_executor()


@contextlib.contextmanager
def bar() -> Iterator[Any]:
    """A progress bar on standard error, where that is a terminal; solvers print there, too."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    console = Console(stderr=True)
    with contextlib.redirect_stdout(sys.stderr):
        if not console.is_terminal:
            yield None
            return
        with Progress(BarColumn(), TextColumn("{task.description}"), console=console, transient=True) as bar:
            task = bar.add_task("")
            yield lambda standing: bar.update(
                task, total=standing.of, completed=standing.done, description=str(standing)
            )
