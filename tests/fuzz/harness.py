"""Cases one after the other, each in a process that may hang or die; and the table of what came of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from importlib import import_module

from tests.extremes.worker import Worker
from tests.fuzz.outcome import FAILED, PASSED, VERDICTS, Outcome

CAMPAIGNS = {
    "scenes": "solving",
    "certificates": "certificates",
    "newton": "newton",
    "files": "files",
    "arguments": "arguments",
}
"""The campaigns by name, and the module whose `case` draws and judges one."""


def attempt(campaign: str, seed: int, number: int) -> Outcome:
    """One case of a campaign, in this process."""
    judged: Callable[[int, int], Outcome] = import_module(f"tests.fuzz.{CAMPAIGNS[campaign]}").case
    return judged(seed, number)


def run(campaign: str, seed: int, first: int, cases: int, seconds: float) -> Iterator[tuple[int, Outcome]]:
    """The cases of a campaign and what came of them, in their order; no end within the time limit is a failure."""
    with Worker(attempt) as worker:
        worker.ask((campaign, seed, first), max(seconds, 60.0))  # what is imported at first is no part of a case
        for number in range(first, first + cases):
            outcome, words = worker.ask((campaign, seed, number), seconds)
            yield number, outcome if words == "" else Outcome(FAILED, words)


def report(campaign: str, outcomes: list[Outcome]) -> str:
    """How many there were of each verdict."""
    counts = Counter(outcome.verdict for outcome in outcomes)
    parts = ", ".join(f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict] or verdict == FAILED)
    ways = Counter(outcome.reason for outcome in outcomes if outcome.verdict == PASSED and outcome.reason)
    lines = [f"  {count} by {way}" for way, count in ways.most_common()]
    return "\n".join([f"{campaign}: {len(outcomes)} cases: {parts}", *lines])
