"""What came of a case, and what may come of one: an answer that holds, or an error of varcontact's own."""

from __future__ import annotations

import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import varcontact as vc

PASSED, REFUSED, UNSOLVED, FAILED = "passed", "refused", "not converged and said so", "FAILED"
VERDICTS = (PASSED, REFUSED, UNSOLVED, FAILED)


@dataclass(frozen=True)
class Outcome:
    """What came of a case."""

    verdict: str
    reason: str = ""
    case: str = ""
    seconds: float = 0.0


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


@contextmanager
def processor_seconds() -> Iterator[Callable[[], float]]:
    """A function: the processor time since the beginning, which does not depend on what else the machine does."""
    begun = time.process_time()
    yield lambda: time.process_time() - begun


def says_what(error: vc.VarcontactError) -> str:
    """What is wrong with an error of ours as to what it tells: nothing, where its message names the field."""
    message, field = str(error), getattr(error, "field", None)
    if not message or "Traceback" in message:
        return f"an error without a message: {error!r}"
    if len(message) > 2000:
        return f"a message of {len(message)} characters: {message[:200]}"
    if isinstance(field, str) and not any(part.strip() in message for part in field.split(",")):
        return f"the message does not name {field!r}: {message[:300]}"
    return ""
