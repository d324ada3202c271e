"""A case of a campaign, and what may come of one: an answer that holds, or an error of varcontact's
own.
"""

import time
import traceback
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import varcontact as vc

PASSED, REFUSED, UNSOLVED, FAILED = "passed", "refused", "not converged and said so", "FAILED"
LONGEST = 1.0
"""Seconds of processor time within which bad input has to be refused."""


def says_what(error: vc.VarcontactError) -> str:
    """What is wrong with an error of ours as to what it tells: nothing, where its message names the
    field.
    """
    message, field = str(error), getattr(error, "field", None)
    if not message or "Traceback" in message:
        return f"an error without a message: {error!r}"
    if len(message) > 2000:
        return f"a message of {len(message)} characters: {message[:200]}"
    if isinstance(field, str) and not any(part.strip() in message for part in field.split(",")):
        return f"the message does not name {field!r}: {message[:300]}"
    return ""


@dataclass(frozen=True)
class Case:
    """Words, a call that returns what is wrong with its answer, and what is wrong with a
    refusal.
    """

    words: str
    call: Callable[[], list[str]]
    silent: Callable[[vc.VarcontactError], str] = lambda error: ""
    bad_input: bool = False


def attempt(
    draw: Callable[[np.random.Generator], Case], seed: int, number: int
) -> tuple[str, str, str]:
    """The verdict of a case, the reason, and the case in words; a warning of numpy's is a
    failure.
    """
    words, silent, bad_input, begun = "", Case.silent, False, time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", RuntimeWarning)
        try:
            case = draw(np.random.default_rng([seed, number]))
            words, silent, bad_input, begun = (
                case.words,
                case.silent,
                case.bad_input,
                time.process_time(),
            )
            found = case.call()
            return (FAILED if found else PASSED), "; ".join(found), words
        except vc.NotConverged as error:
            return UNSOLVED, str(error), words
        except vc.VarcontactError as error:
            found, spent = silent(error), time.process_time() - begun
            if bad_input and spent > LONGEST:
                found = f"after {spent:.1f} s: {error}"
            return (FAILED if found else REFUSED), found or str(error), words
        except Exception as error:  # whatever it is, it is no refusal of ours
            place = traceback.extract_tb(error.__traceback__)[-1]
            return (
                FAILED,
                f"{error!r} in {place.filename.split('/')[-1]}:{place.lineno} ({place.name})",
                words,
            )
