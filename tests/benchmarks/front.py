"""Error against time: all methods on the reference scenes."""

from pathlib import Path

import pandas as pd

import varcontact as vc
from tests.benchmarks.table import DOCS, Table
from varcontact.solving.discretisation_variants import Way
from varcontact.study.tradeoff import SECOND_ORDER, TARGETS, Tradeoff
from varcontact.theories.on_grid import THEORIES

STORE = Path("tradeoff.csv")
"""What is measured already, in the working directory: a run of hours goes on from it."""
PERCENT = tuple(f"{100 * target:g} %" for target in TARGETS)


def measured(quick: bool) -> Tradeoff:
    """All ways on all reference scenes; quickly, some on those of line contact."""
    if not quick:
        return vc.tradeoff(store=STORE, progress=print)
    return vc.tradeoff(
        of_lines(), [Way(cells=8), Way(cells=24), *(Way(accuracy=each) for each in TARGETS)]
    )


def of_lines() -> dict[str, vc.ContinuumValues]:
    """The reference scenes of line contact."""
    return {
        name: each for name, each in vc.continuum_values().items() if each.kind == "line contact"
    }


def milliseconds(value: float) -> str:
    return "" if value != value else f"{float(f'{1e3 * value:.3g}'):g}"


def advice(quick: bool) -> Table:
    """The fastest way for each class and error; also the data and the picture of the page."""
    found, rows = measured(quick), []
    table = found.advice()
    for kind in dict.fromkeys(table["kind"]):
        part = table[table["kind"] == kind]
        cells = [f"{way}, {milliseconds(seconds)} ms" if isinstance(way, str) else "none of these"
                 for way, seconds in zip(part["way"], part["processor_seconds"], strict=True)]  # fmt: skip
        rows.append([kind, *cells])
    if not quick:
        found.classes.to_csv(DOCS / "tradeoff.csv", index=False, float_format="%.4g")
        found.plot().savefig(DOCS / "pictures" / "tradeoff.png", dpi=130)
    return Table(["scenes", *PERCENT], [""] * (1 + len(TARGETS)), rows)


def accuracy(quick: bool) -> Table:
    """What `accuracy=` takes: median time, and by that of ways with a grid, fixed for the class or
    best for a scene.
    """
    runs = measured(quick).runs
    runs = runs[runs["outcome"] == "answered"]
    exact, rows = runs[(runs["family"] != "accuracy") & ~runs["family"].isin(THEORIES)], []
    for kind in dict.fromkeys(runs["kind"]):
        scenes, cells = exact[exact["kind"] == kind], []
        asked = runs[runs["kind"] == kind].set_index(["way", "scene"])["processor_seconds"]
        for target in TARGETS:
            taken = asked[f"accuracy {target:g}"]
            best = scenes[scenes["error"] <= target].groupby("scene")["processor_seconds"].min()
            ratios = [(taken / seconds).median() for seconds in (fixed(scenes, target), best)]
            words = ", ".join("-" if ratio != ratio else f"{ratio:.1f}" for ratio in ratios)
            cells.append(f"{milliseconds(taken.median())} ms ({words})")
        rows.append([kind, *cells])
    return Table(["scenes", *PERCENT], [""] * (1 + len(TARGETS)), rows)


def fixed(runs: pd.DataFrame, target: float) -> pd.Series:
    """Seconds by scene of the fastest way that is accurate enough in all scenes of a class; NaN
    where there is none.
    """
    count = runs["scene"].nunique()
    enough = runs.groupby("way").filter(
        lambda part: len(part) == count and part["error"].max() <= target
    )
    seconds = enough.groupby("way")["processor_seconds"].median()
    chosen = enough[enough["way"] == seconds.idxmin()] if len(seconds) else enough
    return chosen.set_index("scene")["processor_seconds"]


def theories(quick: bool) -> Table:
    """Errors of the theories by class: median, largest, and the scenes that a theory can treat."""
    classes = measured(quick).classes
    names = [family for family in dict.fromkeys(classes["family"]) if family in THEORIES]
    table = classes[classes["family"].isin(names) & (classes["cells"] == 10)]
    kinds, rows = list(dict.fromkeys(table["kind"])), []
    for name in names:
        part = table[table["family"] == name].set_index("kind")
        rows.append([name, *(
            f"{100 * row.median_error:.2g} ({100 * row.largest_error:.2g}), {row.answers} of {row.scenes}"
            if (row := part.loc[kind] if kind in part.index else None) is not None else "" for kind in kinds
        )])  # fmt: skip
    return Table(["theory", *kinds], [""] * (1 + len(kinds)), rows)


def linear(quick: bool) -> Table:
    """Constant beside linear tractions in line contact: errors by family and elements across."""
    cells = (8, 16) if quick else (4, 8, 12, 16, 24, 48)
    ways = [
        Way(cells=n, tractions=tractions, motion=motion)
        for n in cells
        for tractions in ("constant", "linear")
        for motion in ((), SECOND_ORDER)
    ]
    runs = vc.tradeoff(of_lines(), ways).runs
    runs = runs[runs["outcome"] == "answered"]
    rows = []
    for family, part in runs.groupby("family", sort=False):
        errors = part.groupby("cells")["error"]
        rows.append([family, *zip(100 * errors.median(), 100 * errors.max(), strict=True)])
    head = ["tractions and difference", *(str(4 * n) for n in cells)]
    return Table(head, ["", *["{:.2g} ({:.2g})"] * len(cells)], rows)


TABLES = {"advice": advice, "accuracy": accuracy, "theories": theories, "linear": linear}
