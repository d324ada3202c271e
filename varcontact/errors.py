"""Errors and warnings. Each kind has a class, and each message says what is wrong and what to
do.
"""

from __future__ import annotations

import sys
import warnings
from types import FrameType
from typing import Any, Self

INSIDE = "varcontact", "contextlib", "dataclasses", "scipy"
"""Packages with frames between a user's call and a warning: those of decorators, of `replace`, and
of the search for a root."""
COMMAND_LINE = "varcontact.cli"
"""A user of the package like any other."""


class VarcontactError(Exception):
    """Base of every error that varcontact raises on purpose.

    Attributes
    ----------
    step : int or None
        The step of a history in which it happened, counted from 0.
    history : History or None
        The steps before; None where the error came before any work.
    """

    step: int | None = None
    history: Any = None

    def in_step(self, step: int, history: Any) -> Self:
        """Error with the `step` of a history, from 0, in its message, and the `history` solved
        before it.
        """
        self.step = step
        self.history = history
        self.args = (f"step {step} of the history: {self.args[0]}",)
        return self

    def __reduce__(self) -> Any:
        """For `pickle`: an error of another process is the same here, with its message and
        attributes.
        """
        return type(self).__new__, (type(self),), {**vars(self), "args": self.args}


class SceneError(VarcontactError):
    """A scene (or an argument of a call) that cannot be treated.

    Parameters
    ----------
    field : str
        The name of the offending entry, as the user wrote it (``"bodies.G"``).
    value : object
        What was given.
    allowed : str
        What would have been allowed, in words that complete "must be". Words
        that begin with "given", for a value of None, or with "left out" make a
        sentence of their own, see the examples.
    message : str
        The whole message, where another sentence says it better.

    Examples
    --------
    >>> print(SceneError("bodies.nu", 0.7, "a number in (-1, 0.5]"))
    bodies.nu = 0.7 is not allowed: must be a number in (-1, 0.5]
    >>> print(SceneError("motion", None, "given: without it there is no creepage"))
    motion is missing: without it there is no creepage
    >>> print(SceneError("grid.ny", 3, "left out in line contact"))
    grid.ny = 3 must be left out in line contact
    >>> print(SceneError("coupling", "joint", message="coupling: the bodies are alike (K = 0)"))
    coupling: the bodies are alike (K = 0)
    """

    def __init__(self, field: str, value: Any, allowed: str = "", *, message: str = "") -> None:
        self.field = field
        self.value = value
        self.allowed = allowed
        if message:
            super().__init__(message)
        elif value is None and allowed.startswith("given"):
            super().__init__(f"{field} is missing{allowed.removeprefix('given')}")
        elif allowed.startswith("left out"):
            super().__init__(f"{field} = {shortened(value)} must be {allowed}")
        else:
            super().__init__(f"{field} = {shortened(value)} is not allowed: must be {allowed}")


class PlausibilityWarning(UserWarning):
    """An entry that is likely a mistake, with its figures; it is solved as it is.

    Examples
    --------
    >>> import warnings
    >>> warnings.simplefilter("error", PlausibilityWarning)  # to refuse such scenes
    >>> warnings.resetwarnings()
    """


class DoubtfulProfile(UserWarning):
    """Points that look like a profile of the other kind, upside down, or with exchanged sides; or a
    file that looks truncated.
    """


class NoContact(SceneError):
    """The bodies do not touch."""


class TooCoarse(SceneError):
    """A grid whose elements are too large for a contact."""


class OutputError(VarcontactError, OSError):
    """A file that cannot be written (or read back), with the reason.

    Parameters
    ----------
    field : str
        What the file was named by (``"path"``, ``"--plot"``), or what cannot be
        written.
    value : object
        The file's name, or "" where there is none.
    reason : str
        What is wrong.
    """

    def __init__(self, field: str, value: Any, reason: str) -> None:
        self.field = field
        self.value = value
        self.reason = reason
        if value:
            super().__init__(f"{field} = {shortened(str(value))}: {reason}")
        else:
            super().__init__(f"{field} {reason}")

    def __str__(self) -> str:
        return str(self.args[0])


class Saturated(VarcontactError):
    """A prescribed tangential force beyond what friction can carry.

    Parameters
    ----------
    force : float
        Prescribed; in line contact per unit length [force].
    limit : float
        What friction can carry [force].
    law : str
        More on the friction, for the message.
    """

    def __init__(self, force: float, limit: float, law: str = "") -> None:
        self.force = force
        self.limit = limit
        super().__init__(
            f"motion: a tangential force of {force:.10g} cannot be carried, "
            f"friction{law} allows less than {limit:.10g} (the traction bound over the contact)"
        )


class NotConverged(VarcontactError):
    """A solver did not reach the tolerance; the best iterate is kept.

    Parameters
    ----------
    message : str
        What did not converge.

    Attributes
    ----------
    solution : Solution or None
        The best iterate with its certificate.
    residual : float
        Its natural-map residual.
    """

    def __init__(self, message: str, residual: float, solution: Any = None) -> None:
        self.residual = residual
        self.solution = solution
        super().__init__(f"{message} (last residual {residual:.3g})")


class SolverUnavailable(VarcontactError):
    """A solver's package is not installed.

    Parameters
    ----------
    solver : str
        Its name.
    install : str
        What to do.
    """

    def __init__(self, solver: str, install: str) -> None:
        self.solver = solver
        self.install = install
        super().__init__(f"solver {solver!r} is not installed: {install}")


class TooLarge(VarcontactError):
    """A method would need more memory than the machine has.

    Parameters
    ----------
    what : str
        What takes the memory, for the message.
    needed, available : float
        Memory [bytes].
    fits : str
        What would fit, or what to do.
    """

    def __init__(self, what: str, needed: float, available: float, fits: str) -> None:
        self.needed = needed
        self.available = available
        self.fits = fits
        super().__init__(
            f"{what} needs about {needed / 2**30:.1f} GiB, "
            f"{available / 2**30:.1f} GiB are available; {fits}"
        )


class WorkersLost(VarcontactError):
    """The executor of a study ended, or lost its workers; what was finished is kept.

    Attributes
    ----------
    partial : Dataset or None
        What is finished, where the study gives a dataset.
    """

    partial: Any = None


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in a study of many solves, or in a history of steps; what was finished is kept.

    Parameters
    ----------
    finished : str
        What was finished, for the message.

    Attributes
    ----------
    partial : Convergence, DataFrame or History
        The study, the table or the history, as far as it got.
    """

    def __init__(self, partial: Any, finished: str = "") -> None:
        self.partial = partial
        super().__init__(f"interrupted{finished}")


def warn(message: str, category: type[Warning] = UserWarning) -> None:
    """Warn at the user's line: that of the first frame outside the package."""
    stacklevel = 1
    frame: FrameType | None = sys._getframe()
    while frame is not None and _is_inside(frame):
        stacklevel += 1
        frame = frame.f_back
    warnings.warn(message, category, stacklevel=stacklevel)


def _is_inside(frame: FrameType) -> bool:
    # by its module: the file of a dataclass's __init__ is "<string>", as that of python -c
    module = str(frame.f_globals.get("__name__"))
    return module.partition(".")[0] in INSIDE and not module.startswith(COMMAND_LINE)


def shortened(value: Any, longest: int = 80) -> str:
    """A value as Python writes it, cut where it has more than `longest` characters."""
    try:
        if hasattr(value, "dtype") and getattr(value, "shape", None) == ():
            value = value.item()
        text = " ".join(repr(value).split())  # arrays come in lines
    except RecursionError:
        text = f"a {type(value).__name__}, nested deep"
    except Exception:  # an int of thousands of digits, or an object that cannot describe itself
        text = f"a {type(value).__name__}"
        if isinstance(value, int):
            text = "a number of thousands of digits"
    if len(text) <= longest:
        return text
    return text[:60] + " ... " + text[-15:]
