"""What came of a case, and what may come of one: an answer that holds, or an error of varcontact's own."""

from __future__ import annotations

import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

PASSED, REFUSED, UNSOLVED, FAILED = "passed", "refused", "not converged and said so", "FAILED"
VERDICTS = (PASSED, REFUSED, UNSOLVED, FAILED)


@dataclass(frozen=True)
class Outcome:
    """What came of a case.

    Attributes
    ----------
    verdict : str
        One of `VERDICTS`.
    reason : str
        Of a refusal, its text; of a failure, what is wrong.
    case : str
        What the case was, in words.
    """

    verdict: str
    reason: str = ""
    case: str = ""


def crashed(error: BaseException, case: str) -> Outcome:
    """The failure of a case that ended in an exception which is none of ours, with the place where it was raised."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    return Outcome(FAILED, f"{error!r} in {place.filename.split('/')[-1]}:{place.lineno} ({place.name})", case)


@contextmanager
def numbers_that_overflow_are_errors() -> Iterator[None]:
    """No warning of numpy's may reach a user: it becomes an exception that is none of ours."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", RuntimeWarning)
        yield
