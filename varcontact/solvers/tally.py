"""How often solvers are called, for how long, and how far they are: told by the solvers themselves."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class Calls:
    """What the calls of one solver came to.

    Attributes
    ----------
    count : int
        How often it was called.
    iterations : int
        Its iterations, as it counts them, in all calls.
    seconds : float
        Its time in all calls, without that of other solvers which it called.
    """

    count: int = 0
    iterations: int = 0
    seconds: float = 0.0


class Tally:
    """Adds up the calls of solvers by name: ``with tally.called("norm"): ...``.

    Parameters
    ----------
    progress : callable, optional
        Called with how far a solver is, in words.

    Examples
    --------
    >>> tally = Tally()
    >>> with tally.called("clarabel"):
    ...     tally.iterated("clarabel", 12)
    >>> tally.calls["clarabel"].count, tally.calls["clarabel"].iterations
    (1, 12)
    """

    def __init__(self, progress: Callable[[str], None] | None = None) -> None:
        self.calls: dict[str, Calls] = {}
        self._progress = progress
        self._inside: list[float] = []

    def tell(self, words: str) -> None:
        """Tell how far a solver is.

        Parameters
        ----------
        words : str
        """
        if self._progress is not None:
            self._progress(words)

    @contextmanager
    def called(self, name: str) -> Iterator[None]:
        """Count what runs inside as one call of the solver of that name; calls inside it count for themselves.

        Parameters
        ----------
        name : str
            Of the solver.
        """
        self._inside.append(0.0)
        begun = time.perf_counter()
        try:
            yield
        finally:
            lasted = time.perf_counter() - begun
            own = lasted - self._inside.pop()
            if self._inside:
                self._inside[-1] += lasted
            before = self.calls.get(name, Calls())
            self.calls[name] = replace(before, count=before.count + 1, seconds=before.seconds + own)

    def iterated(self, name: str, iterations: int) -> None:
        """Add iterations to what a solver has.

        Parameters
        ----------
        name : str
            Of the solver.
        iterations : int
        """
        before = self.calls.get(name, Calls())
        self.calls[name] = replace(before, iterations=before.iterations + iterations)
