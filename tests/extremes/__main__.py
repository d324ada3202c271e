"""``python -m tests.extremes [WORDS]``: scenes with these words by every family; exit 3 where any FAILED."""

import sys
from collections import Counter

from tests.extremes.judge import FAILED, PASSED, cases, rows_of

chosen = [case for case in cases() if " ".join(sys.argv[1:]) in f"{case.group} {case.name}"]
counts: Counter[str] = Counter()
for case in chosen:
    for row in rows_of(case):
        counts[row["verdict"]] += 1
        if row["verdict"] != PASSED:
            print(*(row[name] for name in ("verdict", "group", "case", "family", "reason")), sep=", ", flush=True)
print(f"{len(chosen)} scenes: {', '.join(f'{count} {verdict}' for verdict, count in counts.items())}")
sys.exit(3 if counts[FAILED] else 0)
