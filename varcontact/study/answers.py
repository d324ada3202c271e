"""The answers of one scene by several methods: how far each is from the best, and their file until all are there."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from varcontact.results.solution import Solution
from varcontact.system.files import beside, clear, replacing

FIELDS = ("pressure", "traction", "state", "traction_bound", "force")


@dataclass(frozen=True, eq=False)
class Answer:
    """What a method found, as far as it is compared with what others found.

    Attributes
    ----------
    lattice : str
        The grid, in words that are the same for the same grid.
    area : float
        Of an element [length^2].
    residual : float
        Of the natural map.
    pressure, state, traction_bound : ndarray, shape (ny, nx)
    traction : ndarray, shape (2, ny, nx)
    force : ndarray, shape (2,)
    """

    lattice: str
    area: float
    residual: float
    pressure: np.ndarray
    traction: np.ndarray
    state: np.ndarray
    traction_bound: np.ndarray
    force: np.ndarray

    @classmethod
    def of(cls, sol: Solution) -> Answer:
        """From a solution `sol`."""
        fields = {name: np.asarray(getattr(sol, name)) for name in FIELDS}
        return cls(json.dumps(vars(sol.grid)), float(sol.grid.area), float(sol.certificate.residual), **fields)


def distances(rows: Sequence[dict[str, Any]], answers: Sequence[Answer | None]) -> list[dict[str, Any]]:
    """The rows of a scene, with how far each answer is from the solved one of the smallest residual.

    Parameters
    ----------
    rows : sequence of dict
        With their `outcome`.
    answers : sequence of Answer or None
        To each row, if it has one.
    """
    solved = [
        answer for row, answer in zip(rows, answers, strict=True) if answer is not None and row["outcome"] == "solved"
    ]
    if not solved:
        return list(rows)
    best = min(solved, key=lambda answer: answer.residual)
    return [
        row | (_away(answer, best) if answer is not None and answer.lattice == best.lattice else {})
        for row, answer in zip(rows, answers, strict=True)
    ]


def _away(answer: Answer, best: Answer) -> dict[str, Any]:
    """How far one answer is from another."""
    bound = best.traction_bound
    carried = float(bound.sum() * best.area)
    if not 0 < carried < np.inf:  # no friction or no slip: by the pressures
        away = float(np.abs(answer.pressure - best.pressure).max() / best.pressure.max())
        return {"traction_distance": away, "misclassified": int(np.sum(answer.state != best.state))}
    return {
        "force_distance": float(np.hypot(*(answer.force - best.force)) / carried),
        "traction_distance": float(np.hypot(*(answer.traction - best.traction)).max() / bound.max()),
        "misclassified": int(np.sum(answer.state != best.state)),
    }


def keep_answers(store: Path, identity: str, answers: Sequence[Answer | None]) -> None:
    """Keep the answers of the scene that is being compared in a hidden file beside the table.

    Parameters
    ----------
    store : Path
        The table.
    identity : str
        Of the scene.
    answers : sequence of Answer or None

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    arrays: dict[str, Any] = {"identity": identity, "count": len(answers)}
    for i, answer in enumerate(answers):
        if answer is not None:
            arrays |= {f"{name} {i}": value for name, value in vars(answer).items()}
    with replacing("store", _file(store)) as file:
        np.savez(file, **arrays)


def kept_answers(store: Path, identity: str) -> list[Answer | None]:
    """The answers of an interrupted comparison of one scene; none where there are none of this scene.

    Parameters
    ----------
    store : Path
        The table.
    identity : str
        Of the scene.
    """
    try:
        with np.load(_file(store), allow_pickle=False) as file:
            if str(file["identity"]) != identity:
                return []
            return [_answer(file, i) if f"lattice {i}" in file else None for i in range(int(file["count"]))]
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return []


def forget_answers(store: Path) -> None:
    """Remove the answers beside the table at `store`, and what killed writers left of them."""
    clear(_file(store))
    _file(store).unlink(missing_ok=True)


def _answer(file: Any, i: int) -> Answer:
    fields = {name: file[f"{name} {i}"] for name in FIELDS}
    return Answer(str(file[f"lattice {i}"]), float(file[f"area {i}"]), float(file[f"residual {i}"]), **fields)


def _file(store: Path) -> Path:
    return beside(store.resolve(), "answers")
