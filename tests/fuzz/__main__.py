"""The command: ``python -m tests.fuzz scenes --seed 1 --cases 1000``, from the folder that holds ``tests``.

Exit status: 0 nothing failed, 2 bad input, 3 something FAILED, 130 interrupted.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence

from tests.fuzz.harness import CAMPAIGNS, report, run
from tests.fuzz.outcome import FAILED, UNSOLVED, Outcome


def main(arguments: Sequence[str] | None = None) -> int:
    """Draw and judge cases, print those that FAILED and the counts, and return the exit status."""
    chosen = _parser().parse_args(arguments)
    shown = {FAILED, UNSOLVED} if chosen.verbose else {FAILED}
    outcomes: list[Outcome] = []
    begun = time.perf_counter()
    status = 0
    try:
        for number, outcome in run(chosen.campaign, chosen.seed, chosen.first, chosen.cases, chosen.seconds_per_case):
            outcomes.append(outcome)
            if outcome.verdict in shown:
                print(f"seed {chosen.seed}, case {number}: {outcome.verdict}: {outcome.reason}", flush=True)
            if outcome.verdict == FAILED and chosen.verbose:
                print(f"    {outcome.case}", flush=True)
            if sys.stderr.isatty():
                print(f"\r\x1b[K{len(outcomes)} of {chosen.cases}", end="", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        status = 130
    print(f"{report(chosen.campaign, outcomes)}; {time.perf_counter() - begun:.0f} s")
    if status == 0 and any(outcome.verdict == FAILED for outcome in outcomes):
        status = 3
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.fuzz", description="Random cases, each from the seed and its number, and a judge."
    )
    parser.add_argument("campaign", choices=list(CAMPAIGNS))
    parser.add_argument("--seed", type=int, default=0, help="which cases (default 0)")
    parser.add_argument("--cases", type=int, default=100, help="how many (default 100)")
    parser.add_argument("--first", type=int, default=0, help="number of the first case (default 0)")
    parser.add_argument("--seconds-per-case", type=float, default=60.0, help="of processor time (default 60)")
    parser.add_argument("--verbose", action="store_true", help="also what did not converge, and failed cases in full")
    return parser


if __name__ == "__main__":  # the harness's worker process imports this module anew
    raise SystemExit(main())
