"""Speed against accuracy on all reference scenes: the tables, the picture and the data of docs/tradeoff.md.

``python -m tests.benchmarks.tradeoff STORE.csv`` measures what the store does not have yet, and writes the tables
docs/tradeoff_*.txt, the data docs/tradeoff.csv, and docs/pictures/tradeoff.png.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import pandas as pd

import varcontact as vc
from varcontact.study.tradeoff import TARGETS, Tradeoff
from varcontact.theories.on_grid import THEORIES

DOCS = Path(__file__).parents[2] / "docs"


def markdown(head: list[str], lines: list[list[str]]) -> str:
    """A table."""
    rows = [head, ["---"] * len(head), *lines]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def percent(value: float) -> str:
    return f"{100 * value:.2g}"


def milliseconds(value: float) -> str:
    return "" if value != value else f"{float(f'{1e3 * value:.3g}'):g}"


def advice(found: Tradeoff) -> str:
    """The fastest way for each class and error."""
    table = found.advice()
    lines = []
    for kind in dict.fromkeys(table["kind"]):
        part = table[table["kind"] == kind]
        cells = [f"{way}, {milliseconds(seconds)} ms" if isinstance(way, str) else "none of these"
                 for way, seconds in zip(part["way"], part["processor_seconds"], strict=True)]  # fmt: skip
        lines.append([kind, *cells])
    return markdown(["scenes", *(f"{100 * target:g} %" for target in TARGETS)], lines)


def accuracies(found: Tradeoff) -> str:
    """What `accuracy=` takes: median time, and by that of ways with a grid, fixed for the class or best for a scene."""
    runs = found.runs[found.runs["outcome"] == "answered"]
    exact = runs[(runs["family"] != "accuracy") & ~runs["family"].isin(THEORIES)]
    lines = []
    for kind in dict.fromkeys(runs["kind"]):
        scenes, cells = exact[exact["kind"] == kind], []
        asked = runs[runs["kind"] == kind].set_index(["way", "scene"])["processor_seconds"]
        for target in TARGETS:
            taken = asked[f"accuracy {target:g}"]
            best = scenes[scenes["error"] <= target].groupby("scene")["processor_seconds"].min()
            ratios = [(taken / seconds).median() for seconds in (fixed(scenes, target), best)]
            words = ", ".join("-" if ratio != ratio else f"{ratio:.1f}" for ratio in ratios)
            cells.append(f"{milliseconds(taken.median())} ms ({words})")
        lines.append([kind, *cells])
    return markdown(["scenes", *(f"{100 * target:g} %" for target in TARGETS)], lines)


def fixed(runs: pd.DataFrame, target: float) -> pd.Series:
    """Seconds by scene of the fastest way that is accurate enough in all scenes of a class; NaN where there is none."""
    count = runs["scene"].nunique()
    enough = runs.groupby("way").filter(lambda part: len(part) == count and part["error"].max() <= target)
    seconds = enough.groupby("way")["processor_seconds"].median()
    chosen = enough[enough["way"] == seconds.idxmin()] if len(seconds) else enough
    return chosen.set_index("scene")["processor_seconds"]


def theories(found: Tradeoff) -> str:
    """Errors of the theories by class."""
    names = [family for family in dict.fromkeys(found.classes["family"]) if "," not in family and family != "centres"]
    table = found.classes[found.classes["family"].isin(names) & (found.classes["cells"] == 10)]
    kinds = list(dict.fromkeys(table["kind"]))
    lines = []
    for name in names:
        part = table[table["family"] == name].set_index("kind")
        if len(part):
            cells = [f"{percent(part.loc[kind, 'median_error'])} ({percent(part.loc[kind, 'largest_error'])}), "
                     f"{part.loc[kind, 'answers']} of {part.loc[kind, 'scenes']}" if kind in part.index else ""
                     for kind in kinds]  # fmt: skip
            lines.append([name, *cells])
    return markdown(["theory", *kinds], lines)


def write(found: Tradeoff, folder: Path = DOCS) -> None:
    """The files of the page."""
    (folder / "tradeoff_advice.txt").write_text(advice(found) + "\n")
    (folder / "tradeoff_accuracy.txt").write_text(accuracies(found) + "\n")
    (folder / "tradeoff_theories.txt").write_text(theories(found) + "\n")
    found.classes.to_csv(folder / "tradeoff.csv", index=False, float_format="%.4g")
    found.plot().savefig(folder / "pictures" / "tradeoff.png", dpi=130)


if __name__ == "__main__":
    mpl.use("Agg")
    write(vc.tradeoff(store=sys.argv[1], progress=print))
