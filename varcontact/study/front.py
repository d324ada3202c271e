"""What a tradeoff found: errors and costs of ways, by class of scene; fronts, and what to take."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.solving.discretisation_variants import Way
from varcontact.study.store import plain_rows
from varcontact.study.tables import columns_of_text

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

COLUMNS = (
    "scene",
    "kind",
    "way",
    "family",
    "cells",
    "outcome",
    "reason",
    "error",
    "bar",
    "seconds",
    "processor_seconds",
    "setup_seconds",
    "repeat_seconds",
    "memory",
    "residual",
    "relative_gap",
    "identity",
)
"""What the table says of each scene and way."""
WORDS = ("scene", "kind", "way", "family", "outcome", "reason", "identity")
TARGETS = (0.1, 0.03, 0.01, 0.003, 0.001)
"""Errors for which the report says what to take."""
MOST_MISSED = 0.2
"""Part of the scenes of a class that a way may leave unanswered, to be considered for it."""


@dataclass(frozen=True, eq=False)
class Tradeoff:
    """Errors against the continuum, and costs.

    Attributes
    ----------
    runs : pandas.DataFrame
        A row per scene and way: outcome and reason; error in the norm of
        `varcontact.results.quantities_of_interest`, and the
        reference's own error bar; seconds, processor seconds, those of a repeat and of the set-up, memory [bytes];
        residual and relative gap, by which the answer is exact for its grid.
    classes : pandas.DataFrame
        A row per class and way: the accuracy it was asked for, if any; scenes and answers; median, 90 % quantile and
        largest error; medians of the seconds; memory; whether it is on the front: no other way is both faster and
        more accurate in the worst scene.
    """

    runs: pd.DataFrame
    classes: pd.DataFrame

    @classmethod
    def of(cls, rows: list[dict[str, Any]], scenes: Iterable[str], ways: Iterable[Way]) -> Tradeoff:
        """From the rows of measurements, of which only those asked for are taken.

        Parameters
        ----------
        rows : list of dict
            With `COLUMNS`.
        scenes : iterable of str
            Names.
        ways : iterable of Way
        """
        import pandas as pd

        names, kept = set(scenes), {str(way): way for way in ways}
        chosen = [row for row in rows if row["scene"] in names and row["way"] in kept]
        runs = pd.DataFrame(chosen, columns=list(COLUMNS))
        classes = [
            _class(str(kind), kept[str(way)], part)
            for (kind, way), part in runs.groupby(["kind", "way"], sort=False)
            if (part["outcome"] == "answered").any()
        ]
        table = pd.DataFrame(classes)
        if len(table):
            table["front"] = False
            for _, part in table.groupby("kind", sort=False):
                table.loc[part.index, "front"] = _on_front(part)
        return cls(runs, table)

    def front(self, kind: str) -> pd.DataFrame:
        """The ways on the front of a class, from fast to accurate.

        Parameters
        ----------
        kind : str
            Class of scenes.
        """
        if not len(self.classes):
            return self.classes
        part = self.classes[(self.classes["kind"] == kind) & self.classes["front"]]
        return part.sort_values("processor_seconds")

    def advice(self, targets: float | Sequence[float] = TARGETS) -> pd.DataFrame:
        """What to take for errors: the fastest way of each class that is below them in all its scenes.

        An accuracy is advised for no less than it was asked for, even if its errors happen to be smaller.

        Parameters
        ----------
        targets : float or sequence of float
            In the norm of `varcontact.results.quantities_of_interest`.

        Returns
        -------
        pandas.DataFrame
            A row per class and target; without a way where none is as accurate.

        Raises
        ------
        SceneError
            If a target is not positive.
        """
        import pandas as pd

        asked = np.atleast_1d(checks.positives("targets", targets)).tolist()
        rows = []
        for kind in dict.fromkeys(self.classes["kind"] if len(self.classes) else []):
            ways = self.classes[self.classes["kind"] == kind]
            ways = ways[_serves(ways)]
            for target in asked:
                good = ways[(ways["largest_error"] <= target) & ~(ways["accuracy"] > target)]
                best = good.sort_values("processor_seconds").iloc[0].to_dict() if len(good) else {}
                names = ("way", "largest_error", "median_error", "processor_seconds", "repeat_seconds", "memory")
                rows.append({"kind": kind, "target": target, **{name: best.get(name) for name in names}})
        return pd.DataFrame(rows)

    def plot(self) -> Figure:
        """Picture of errors over processor seconds, a panel for each class, with its front."""
        from varcontact.plotting.tradeoff import plot_tradeoff

        return plot_tradeoff(self)

    def to_json(self) -> str:
        """The tables of classes and of advice as one JSON object; null where nothing is known."""
        tables = {"classes": plain_rows(self.classes), "advice": plain_rows(self.advice())}
        return json.dumps(tables, indent=2, allow_nan=False, default=_plain)

    def report(self) -> str:
        """Fronts and advice in words and figures, for people."""
        blocks = []
        for kind in dict.fromkeys(self.classes["kind"] if len(self.classes) else []):
            lines = [["way", "scenes", "median", "90 %", "largest", "ms", "repeat", "MiB"]]
            lines += [_cells(row) for row in self.front(kind).to_dict("records")]
            blocks.append("\n".join([kind, *(f"  {line}" for line in columns_of_text(lines, left=1))]))
        return "\n\n".join(blocks)

    def __str__(self) -> str:
        return self.report()

    def __repr__(self) -> str:
        return f"Tradeoff({self.runs['scene'].nunique()} scenes, {self.runs['way'].nunique()} ways)"


def _class(kind: str, way: Way, part: pd.DataFrame) -> dict[str, Any]:
    answers = part[part["outcome"] == "answered"]
    errors = answers["error"].to_numpy(dtype=float)
    medians = {name: answers[name].median() for name in ("seconds", "processor_seconds", "repeat_seconds")}
    return {
        "kind": kind,
        "way": str(way),
        "family": way.family,
        "cells": way.cells,
        "accuracy": np.nan if way.accuracy is None else way.accuracy,
        "scenes": len(part),
        "answers": len(answers),
        "median_error": float(np.median(errors)),
        "usual_error": float(np.quantile(errors, 0.9)),
        "largest_error": float(errors.max()),
        **medians,
        "memory": answers["memory"].max(),
    }


def _on_front(part: pd.DataFrame) -> np.ndarray:
    """Whether no other way of the class is as fast and as accurate, among those that answer most scenes."""
    seconds, errors = part["processor_seconds"].to_numpy(), part["largest_error"].to_numpy()
    serves = _serves(part).to_numpy()
    faster, closer = seconds[None, :] < seconds[:, None], errors[None, :] < errors[:, None]
    no_worse = (seconds[None, :] <= seconds[:, None]) & (errors[None, :] <= errors[:, None])
    beaten = serves[None, :] & no_worse & (faster | closer)
    return serves & ~beaten.any(axis=1)


def _serves(part: pd.DataFrame) -> pd.Series:
    """Whether a way answers most scenes of its class."""
    return part["answers"] >= (1 - MOST_MISSED) * part["scenes"]


def _cells(row: dict[str, Any]) -> list[str]:
    errors = [f"{100 * row[name]:.2g} %" for name in ("median_error", "usual_error", "largest_error")]
    times = [
        "" if row[name] != row[name] else f"{1e3 * row[name]:.3g}" for name in ("processor_seconds", "repeat_seconds")
    ]
    memory = "" if row["memory"] != row["memory"] else f"{row['memory'] / 2**20:.3g}"
    return [row["way"], f"{row['answers']} of {row['scenes']}", *errors, *times, memory]


def _plain(value: Any) -> Any:
    """Numbers of numpy for JSON."""
    return value.item() if hasattr(value, "item") else str(value)
