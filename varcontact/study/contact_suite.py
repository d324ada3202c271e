"""Input files of CONTACT beside its published results: how many cases are equal, in words and as
tables of a page.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from varcontact.study import contact_comparison as comparison
from varcontact.study.contact_comparison import Compared

COUNTED = (comparison.EQUAL, comparison.DIFFERENT, comparison.NOT_RUN, comparison.LEFT_OUT)


@dataclass(frozen=True)
class FileCompared:
    """Results for one file: rows of its cases, and times by its log and here [s]."""

    name: str
    rows: Sequence[Compared]
    theirs: float | None
    ours: float

    @property
    def counts(self) -> dict[str, int]:
        """Number of cases by verdict."""
        return comparison.summary_of(self.rows)

    def reasons(self, *verdicts: str) -> dict[str, int]:
        """Number of cases by the reason why they have a verdict; without lines of the file."""
        found: dict[str, int] = {}
        for _, verdict, reason in comparison.by_case(self.rows):
            if verdict in verdicts:
                words = re.sub(r".*, line \d+: ", "", reason)
                found[words] = found.get(words, 0) + 1
        return found

    def summary(self) -> dict[str, Any]:
        """Row of JSON."""
        reasons = self.reasons(comparison.DIFFERENT, comparison.NOT_RUN)
        different = [
            {name: value for name, value in row.row().items() if value == value}
            for row in self.rows
            if row.verdict == comparison.DIFFERENT
        ]
        times = {"theirs": self.theirs, "ours": self.ours}
        return {
            "file": self.name,
            **self.counts,
            "reasons": reasons,
            "different": different,
            **times,
        }


def report_of(files: Sequence[FileCompared]) -> str:
    """Report on the files."""
    head = f"{'file':<26} {'equal':>6} {'differ':>6} {'not run':>7}"
    lines = [f"{head} {'seconds: theirs':>15} {'ours':>7}"]
    for each in files:
        equal, different, not_run, _ = (each.counts[verdict] for verdict in COUNTED)
        line = f"{each.name:<26} {equal:>6} {different:>6} {not_run:>7}"
        lines.append(f"{line} {tenths(each.theirs):>15} {tenths(each.ours):>7}")
        reasons = each.reasons(comparison.DIFFERENT, comparison.NOT_RUN)
        lines += [f"    {count}: {reason}" for reason, count in reasons.items()]
    return "\n".join(lines)


def page_of(files: Sequence[FileCompared]) -> str:
    """The files, and the values of cases that differ, as tables in Markdown."""
    lines = [
        "| file | cases | equal | different | refused | theirs, ours [s] | reason |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    total = dict.fromkeys(COUNTED, 0)
    for each in files:
        counts = each.counts
        for verdict in COUNTED:
            total[verdict] += counts[verdict]
        times = f"{tenths(each.theirs)}, {tenths(each.ours)}"
        name = each.name.removesuffix(".inp")
        lines.append(f"| {name} | {_numbers(counts)} | {times} | {'; '.join(_why(each))} |")
    lines.append(f"| all | {_numbers(total)} | | |")
    lines += [
        "",
        "| file | case | quantity | theirs | ours | ours on half the sides | reason |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for each in files:
        for row in each.rows:
            if row.verdict == comparison.DIFFERENT:
                lines.append(_row_of(each.name.removesuffix(".inp"), row))
    return "\n".join(lines)


def tenths(seconds: float | None) -> str:
    """A time; nothing where none was printed."""
    if seconds is None:
        return "-"
    return f"{seconds:.1f}"


def _numbers(counts: dict[str, int]) -> str:
    """Numbers of all cases, and by verdict, as table cells; empty for zero."""
    cells = [str(sum(counts.values()))]
    cells += [str(counts[verdict] or "") for verdict in COUNTED[:3]]
    return " | ".join(cells)


def _why(file: FileCompared) -> Iterator[str]:
    """Reasons of cases that are not equal."""
    for verdict in COUNTED[1:]:
        for reason, count in file.reasons(verdict).items():
            short = reason.partition("; supported")[0]
            # names of files without their folders
            short = re.sub(r"'[^']*/([^'/]+)'", r"'\1'", short)
            yield f"{count} {verdict}: {short}"


def _row_of(name: str, row: Compared) -> str:
    """A value that differs, as a row of the table."""
    refined = ""
    if not math.isnan(row.refined):
        refined = f"{row.refined:.5g}"
    place = str(row.case)
    if row.patch > 1:
        place = f"{row.case}, patch {row.patch}"
    reason = row.note
    if reason.startswith("block"):  # of stresses, of which patches have one each
        place = f"{row.case}, {reason}"
        reason = ""
    return (
        f"| {name} | {place} | {row.quantity} | {row.theirs:.5g} | {row.ours:.5g} | {refined} "
        f"| {reason} |"
    )
