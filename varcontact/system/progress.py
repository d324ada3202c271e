"""Progress of long work, shown in terminals and notebooks."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Progress = Callable[[str], None] | bool | None
"""Progress as users give it: a function of one string, or True for a line on the screen."""

ASK_FOR_TERMINAL = "FORCE_COLOR", "TTY_COMPATIBLE"
"""Variables of the environment by which rich takes a stream for a terminal."""


@contextmanager
def shown_progress() -> Iterator[Callable[[Any], None]]:
    """A function that shows the stage on standard error of a terminal, or below the cell of a
    notebook; elsewhere, and beside another one, it shows nothing.
    """
    in_terminal = sys.stderr is not None and sys.stderr.isatty()
    asked_for = any(os.environ.get(name) for name in ASK_FOR_TERMINAL)
    if not (in_terminal or asked_for or "IPython" in sys.modules):
        yield lambda stage: None  # without loading rich
        return
    from rich.console import Console
    from rich.errors import LiveError
    from rich.text import Text

    console = Console(stderr=True)
    if console.is_jupyter:
        yield _in_notebook()
        return
    status = console.status("")
    shows = console.is_terminal
    try:
        if shows:
            status.start()
    except LiveError:
        shows = False
    if not shows:
        yield lambda stage: None
        return
    try:
        yield lambda stage: status.update(Text(str(stage)))
    finally:
        status.stop()


def _in_notebook() -> Callable[[Any], None]:
    """A function that replaces one output of a cell."""
    from IPython.display import display

    output = display({"text/plain": ""}, raw=True, display_id=True)
    return lambda stage: output.update({"text/plain": str(stage)}, raw=True)
