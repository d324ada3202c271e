"""Cases one after the other, each in a process that may hang or die; and the table of what came of them."""

from __future__ import annotations

import signal
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import import_module

from tests.extremes.worker import Worker
from tests.fuzz.outcome import FAILED, PASSED, VERDICTS, Outcome

PATIENCE = 10.0
"""How many times its processor time a case may take, on a machine that has other work too."""
LONGEST = 1.0
"""Seconds of processor time within which bad input has to be refused."""

CAMPAIGNS = {
    "scenes": "solving",
    "certificates": "certificates",
    "newton": "newton",
    "files": "files",
    "arguments": "arguments",
}
"""The campaigns by name, and the module whose `case` draws and judges one."""


def attempt(campaign: str, seed: int, number: int, seconds: float = 0.0) -> Outcome:
    """One case of a campaign, in this process, which ends after so many seconds of processor time where they are given.

    Processor time, because a busy machine is no fault.
    """
    judged: Callable[[int, int], Outcome] = import_module(f"tests.fuzz.{CAMPAIGNS[campaign]}").case
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        return judged(seed, number)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def run(campaign: str, seed: int, first: int, cases: int, seconds: float) -> Iterator[tuple[int, Outcome]]:
    """The cases of a campaign and what came of them, in their order.

    It is a failure to take more `seconds` of processor time, or to wait for ever.
    """
    with Worker(attempt) as worker:
        warm = False
        for number in range(first, first + cases):
            if not warm:  # what is imported at first is no part of a case
                worker.ask((campaign, seed, number, 60.0), PATIENCE * 60.0)
            outcome, words = worker.ask((campaign, seed, number, seconds), PATIENCE * seconds)
            warm = words == ""
            if words:
                outcome = Outcome(FAILED, words)
            elif outcome.seconds > LONGEST:
                outcome = replace(outcome, verdict=FAILED, reason=f"after {outcome.seconds:.1f} s: {outcome.reason}")
            yield number, outcome


def report(campaign: str, outcomes: list[Outcome]) -> str:
    """How many there were of each verdict."""
    counts = Counter(outcome.verdict for outcome in outcomes)
    parts = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict] or verdict == FAILED)
    ways = Counter(outcome.reason for outcome in outcomes if outcome.verdict == PASSED and outcome.reason)
    lines = [f"  {count} by {way}" for way, count in ways.most_common()]
    return "\n".join([f"{campaign}: {len(outcomes)} cases: {parts}", *lines])
