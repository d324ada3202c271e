"""Seconds by stage, and word of each stage to whoever wants to show progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Clock:
    """Adds up the time of named stages: ``with clock("normal"): ...``."""

    def __init__(self, progress: Callable[[str], None] | None = None) -> None:
        self._begun = time.perf_counter()
        self._progress = progress
        self._stages: dict[str, float] = {}

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Count what runs inside as part of `stage`."""
        if self._progress is not None:
            self._progress(stage)
        begun = time.perf_counter()
        try:
            yield
        finally:
            self._stages[stage] = self._stages.get(stage, 0.0) + time.perf_counter() - begun

    def timing(self) -> dict[str, float]:
        """Seconds by stage so far, and in total."""
        return {**self._stages, "total": time.perf_counter() - self._begun}
