"""Work done in a process of its own, which may take for ever or die without taking us along."""

from __future__ import annotations

import signal
from collections.abc import Callable
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, Self


class Worker:
    """A process that calls one function for one set of arguments after the other, each with a time limit.

    Functions and arguments are sent by pickle. A script that makes one needs the usual
    ``if __name__ == "__main__":``, for the process imports it anew.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function

    def __enter__(self) -> Self:
        self._begin()
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def ask(self, arguments: tuple[Any, ...], seconds: float) -> tuple[Any, str]:
        """What the function returns, and nothing; or None, and why there is nothing."""
        try:
            self._pipe.send(arguments)
            if self._pipe.poll(seconds):
                return self._pipe.recv(), ""
            reason = f"no end within {seconds:g} s"
        except (EOFError, BrokenPipeError):
            self._process.join()
            reason = f"the process died with exit status {self._process.exitcode}"
        self._end()
        self._begin()
        return None, reason

    def _begin(self) -> None:
        context = get_context("spawn")
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._function), daemon=True)
        self._process.start()
        theirs.close()
        self._pipe.recv()  # imports are no part of what is limited

    def _end(self) -> None:
        self._process.kill()
        self._process.join()
        self._pipe.close()


def _serve(pipe: Connection, function: Callable[..., Any]) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for whoever asks
    with suppress(EOFError, BrokenPipeError):  # whoever asked is gone
        pipe.send("ready")
        while True:
            pipe.send(function(*pipe.recv()))
