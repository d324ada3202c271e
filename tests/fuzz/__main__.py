"""``python -m tests.fuzz scenes --seed 1 --cases 1000``: random cases, each from the seed and its
number, and a judge.

``python -m tests.fuzz extremes``: all scenes at the extremes, by every family of solvers.

Exit status: 0 nothing failed, 2 bad input, 3 something FAILED.
"""

import argparse
import signal
import sys
from collections import Counter
from importlib import import_module

from tests.fuzz.extremes import extremes
from tests.fuzz.outcome import FAILED, attempt


def too_long(*_):
    raise TimeoutError


parser = argparse.ArgumentParser(prog="python -m tests.fuzz")
parser.add_argument(
    "campaign", choices=("scenes", "certificates", "files", "flips", "arguments", "extremes")
)
parser.add_argument("--seed", type=int, default=0, help="which cases (default 0)")
parser.add_argument("--cases", type=int, help="how many (default 100; all extremes)")
parser.add_argument("--first", type=int, default=0, help="number of the first case (default 0)")
parser.add_argument(
    "--seconds-per-case", type=float, default=60.0, help="of processor time (default 60)"
)
parser.add_argument("--verbose", action="store_true", help="all but what passed, and cases in full")
given = parser.parse_args()
if given.campaign == "extremes":
    draws = [lambda _, case=case: case for extreme in extremes() for case in extreme.cases()]
    draws = draws[given.first :][: given.cases]
else:
    draws = [getattr(import_module("tests.fuzz.campaigns"), given.campaign)] * (given.cases or 100)
counts: Counter[str] = Counter()
signal.signal(signal.SIGPROF, too_long)
for number, draw in enumerate(draws, given.first):
    signal.setitimer(signal.ITIMER_PROF, given.seconds_per_case)
    verdict, reason, words = attempt(draw, given.seed, number)
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    counts[verdict] += 1
    if verdict == FAILED or (given.verbose and reason):
        print(f"seed {given.seed}, case {number}: {verdict}: {reason}", flush=True)
        print(f"    {words}" * given.verbose, end="\n" * given.verbose, flush=True)
print(
    f"{given.campaign}: {len(draws)} cases: {', '.join(f'{n} {verdict}' for verdict, n in counts.items())}"
)
sys.exit(3 if counts[FAILED] else 0)
