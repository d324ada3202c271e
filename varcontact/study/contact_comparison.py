"""Numbers of solved cases beside those that CONTACT printed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from varcontact.io.contact_output import ContactOutput

if TYPE_CHECKING:
    import pandas as pd

DIGITS = 4
"""Significant digits that CONTACT prints."""
ROUNDED = 1.01
"""Largest difference in units of the last digit: its rounding, and its solvers' tolerance."""
SMALLEST_FORCE = 2e-5
"""Forces, divided by the normal force, below which they count as zero."""
SMALLEST_CREEPAGE = 1e-8
STRESS_UNIT = 1.01e-3
"""Largest difference of extremes of stresses, by rounding of the last decimal [N/mm^2]."""
WHEEL_TOL = 1e-3
"""Largest difference of forces of a wheel on a rail, relative to the normal force."""
EQUAL = "equal"
DIFFERENT = "differs"
NOT_RUN = "not run"
LEFT_OUT = "not printed"
COLUMNS = (
    "case",
    "patch",
    "quantity",
    "theirs",
    "ours",
    "difference",
    "verdict",
    "note",
    "refined",
)

KNOWN = {
    "MAX(T1,T2)": "CONTACT counts the heat of an element twice in its own temperature",
}
"""Published numbers that are known to be wrong, with the reason."""


@dataclass(frozen=True)
class Compared:
    """Comparison of one quantity of a case, or the reason why the case has none."""

    case: int
    patch: int
    quantity: str
    theirs: float
    ours: float
    verdict: str
    note: str = ""
    refined: float = math.nan
    """Value here on elements of half the sides, for quantities that differ from CONTACT's."""

    @property
    def difference(self) -> float:
        """Value here minus CONTACT's."""
        return self.ours - self.theirs

    def row(self) -> dict[str, Any]:
        """Row of the table."""
        return {name: getattr(self, name) for name in COLUMNS}


def unit_of_last_digit(value: float) -> float:
    """Unit of the last digit of a printed number; 0 for zero."""
    if value == 0 or not math.isfinite(value):
        return 0.0
    return float(10.0 ** (math.floor(math.log10(abs(value))) - DIGITS + 1))


def tolerance(name: str, theirs: Mapping[str, float]) -> float:
    """The difference up to which a quantity is equal."""
    tol = ROUNDED * unit_of_last_digit(theirs[name])
    load = abs(theirs.get("FN", 0.0))
    if name in ("FX", "FY"):
        return max(tol, SMALLEST_FORCE * load)
    if name == "MZ":  # by the radius of the contact, from its largest pressure
        radius = math.sqrt(load / max(theirs.get("PMAX", 1.0), 1e-10))
        return max(tol, SMALLEST_FORCE * load * radius)
    if name.startswith(("CREEP", "SHIFT")):
        return max(tol, SMALLEST_CREEPAGE)
    return tol


def compared(
    case: int,
    patches: Sequence[Mapping[str, float]],
    output: ContactOutput | None,
    note: str = "",
) -> list[Compared]:
    """Quantities of a case that both programs have: of a basic contact, or of the patches of a
    wheel.
    """
    if output is not None and output.side is not None:
        return _compared_wheel(case, patches, output)
    if output is None or not output.patches:
        return [Compared(case, 1, "", math.nan, math.nan, LEFT_OUT, "CONTACT printed no result")]
    theirs = output.patches[0]
    found = []
    for name, ours in patches[0].items():
        if name not in theirs:
            continue
        verdict = DIFFERENT
        if abs(ours - theirs[name]) <= tolerance(name, theirs):
            verdict = EQUAL
        words = note
        if verdict == DIFFERENT and name in KNOWN:
            words = KNOWN[name]
        found.append(Compared(case, 1, name, theirs[name], ours, verdict, words))
    return found


def compared_stresses(
    case: int,
    ours: Sequence[Mapping[str, float]],
    output: ContactOutput | None,
    patches: Sequence[Mapping[str, float]] = (),
) -> list[Compared]:
    """Extremes of stresses by block of points, to the three decimals that CONTACT prints; of
    `patches` one after the other.
    """
    if output is None:
        return []
    if 1 < len(patches) == len(output.patches):
        blocks = len(ours) // len(patches)
        order = _nearest_of(patches, output.patches)
        ours = [ours[blocks * k + block] for k in order for block in range(blocks)]
    found = []
    for k, (own, theirs) in enumerate(zip(ours, output.stresses, strict=False), 1):
        for name, value in theirs.items():
            verdict = DIFFERENT
            tol = max(STRESS_UNIT, ROUNDED * unit_of_last_digit(value))
            if abs(own[name] - value) <= tol:
                verdict = EQUAL
            found.append(Compared(case, k, name, value, own[name], verdict, f"block {k}"))
    return found


def _compared_wheel(
    case: int, patches: Sequence[Mapping[str, float]], output: ContactOutput
) -> list[Compared]:
    """Forces of the patches of a wheel, to a part of its normal force; the rest for information."""
    count = len(output.patches)
    if count != len(patches):
        words = "patches that are joined or parted otherwise"
        return [Compared(case, 1, "PATCHES", float(count), float(len(patches)), DIFFERENT, words)]
    load = sum(abs(theirs["FN"]) for theirs in output.patches)
    found = []
    order = _nearest_of(patches, output.patches)
    for k, theirs in enumerate(output.patches, 1):
        ours = patches[order[k - 1]]
        for name in ("FN", "FX", "FS"):
            verdict = DIFFERENT
            if abs(ours[name] - theirs[name]) <= WHEEL_TOL * load:
                verdict = EQUAL
            found.append(Compared(case, k, name, theirs[name], ours[name], verdict))
    return found


def _nearest_of(
    patches: Sequence[Mapping[str, float]], printed: Sequence[Mapping[str, float]]
) -> list[int]:
    """The number of the patch that is nearest on the rail to each that is printed."""
    left = list(range(len(patches)))
    order = []
    for theirs in printed:
        place = theirs.get("YCP(R)", 0.0)
        distances = {k: abs(patches[k]["YCP(R)"] - place) for k in left}
        nearest = min(left, key=distances.__getitem__)
        left.remove(nearest)
        order.append(nearest)
    return order


def with_refined(
    rows: Sequence[Compared], refined: Sequence[Mapping[str, float]], output: ContactOutput | None
) -> list[Compared]:
    """Rows that differ, each with our value on elements of half the sides."""
    if output is not None and 1 < len(refined) == len(output.patches):
        refined = [refined[k] for k in _nearest_of(refined, output.patches)]
    found = []
    for row in rows:
        values: Mapping[str, float] = {}
        if row.verdict == DIFFERENT and row.patch <= len(refined):
            values = refined[row.patch - 1]
        found.append(replace(row, refined=values.get(row.quantity, math.nan)))
    return found


def table_of(rows: Sequence[Compared]) -> pd.DataFrame:
    """Table of all rows."""
    import pandas as pd

    return pd.DataFrame([each.row() for each in rows], columns=list(COLUMNS))


def by_case(rows: Sequence[Compared]) -> Iterator[tuple[int, str, str]]:
    """Number, verdict and reason of each case: equal if all its compared quantities are."""
    cases: dict[int, list[Compared]] = {}
    for row in rows:
        cases.setdefault(row.case, []).append(row)
    for case, its in cases.items():
        worst = [row for row in its if row.verdict != EQUAL]
        if not worst:
            yield case, EQUAL, ""
            continue
        yield case, worst[0].verdict, worst[0].note or f"{worst[0].quantity} differs"


def summary_of(rows: Sequence[Compared]) -> dict[str, int]:
    """Number of cases by verdict."""
    counts = dict.fromkeys((EQUAL, DIFFERENT, NOT_RUN, LEFT_OUT), 0)
    for _, verdict, _ in by_case(rows):
        counts[verdict] += 1
    return counts


def report(rows: Sequence[Compared]) -> str:
    """Report: every quantity that is compared, and the number of cases by verdict."""
    head = f"{'case':>5} {'patch':>5} {'quantity':<12}"
    lines = [f"{head} {'theirs':>12} {'ours':>12} {'difference':>11}"]
    for row in rows:
        if row.verdict in (NOT_RUN, LEFT_OUT):
            lines.append(f"{row.case:>5} {row.verdict}: {row.note}")
            continue
        numbers = f"{row.theirs:>12.4g} {row.ours:>12.6g} {row.difference:>11.2e}"
        line = f"{row.case:>5} {row.patch:>5} {row.quantity:<12} {numbers}  {row.verdict}"
        if not math.isnan(row.refined):
            line = f"{line}, {row.refined:.6g} on elements of half the sides"
        if row.note and row.verdict == DIFFERENT:
            line = f"{line} ({row.note})"
        lines.append(line)
    counts = summary_of(rows)
    words = ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count)
    return "\n".join([*lines, f"cases: {words}"])
