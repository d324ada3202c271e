"""Wheels on rails solved one after the other, into a table that goes on where it was left."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import Interrupted, NotConverged, SceneError, VarcontactError
from varcontact.study.csv_table import Table
from varcontact.wheel_rail.case_file import CaseFile
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.wear import Archard, PatchWear, wear
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail

if TYPE_CHECKING:
    import pandas as pd

Seen = Callable[[WheelRailSolution], None] | None

WORDS = ("side", "outcome", "reason", "warnings", "identity")
COLUMNS = (
    *("position", "side", "patch", "outcome", "reason", "warnings"),
    *("y", "roll", "yaw", "z"),
    *("location_x", "location_y", "location_z", "angle", "on_rail", "on_wheel", "rolling_radius"),
    *("vx", "vy", "spin"),
    *("FN", "Fx", "Fs", "Mz", "track_Fx", "track_Fy", "track_Fz"),
    *("peak_pressure", "area", "T_gamma", "power", "wear_depth", "wear_volume"),
    *("error_Fx", "error_Fs", "error_FN"),
    "identity",
)
"""What the table says of each patch, in mm, N, rad, N/mm^2 and W."""


def solve_cases(
    file: CaseFile,
    store: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
    solved: Callable[[WheelRailSolution], None] | None = None,
) -> pd.DataFrame:
    """Solve all positions of a case file.

    Parameters
    ----------
    file : CaseFile
    store : str or Path, optional
        A table (.csv), written after each wheel; wheels already in it are not solved again.
    progress : callable, optional
        Told how far it is before each wheel.
    solved : callable, optional
        Given each solution, but for wheels that the table has already.

    Returns
    -------
    DataFrame
        A row for each patch, with the columns `COLUMNS`: outcome is "solved"; where a wheel of several is not, it has
        one row without figures, "not converged" or "refused", and the reason.

    Raises
    ------
    SceneError
        If the table is of other cases; if there is one wheel alone and it cannot be solved.
    NotConverged
        If there is one wheel alone and it is not solved.
    OutputError
        If the table cannot be written.
    Interrupted
        By Ctrl-C. Its `partial` is the table of the finished wheels, and the store has it.
    """
    import pandas as pd

    report = checks.progress(progress)
    names = [_identity(case, file) for case in file.cases]
    total = len(names)
    with Table.opened(store, COLUMNS, WORDS, "a table of wheels on rails") as table:
        rows = _kept(table, names, file.numbers, store)
        try:
            for k, (case, name) in enumerate(zip(file.cases, names, strict=True)):
                if rows[k]:
                    continue
                if report is not None:
                    report(f"{k} of {total} wheels, y = {case.position.y:.4g} mm, {case.side}")
                found = _rows(case, file, solved) if total > 1 else _solved(case, file, solved)
                rows[k] = [{"position": file.numbers[k], **row, "identity": name} for row in found]
                table.write([row for each in rows for row in each])
        except KeyboardInterrupt:
            partial = pd.DataFrame([row for each in rows for row in each], columns=list(COLUMNS))
            raise Interrupted(partial, f" after {sum(map(bool, rows))} of {total} wheels") from None
    return pd.DataFrame([row for each in rows for row in each], columns=list(COLUMNS))


def _identity(case: WheelOnRail, file: CaseFile) -> str:
    """A few digits that tell one wheel, with its settings, from another."""
    settings = [type(case.friction).__name__, file.options, file.archard and dataclasses.asdict(file.archard)]
    described = json.dumps([dataclasses.asdict(case), settings], sort_keys=True, default=np.ndarray.tolist)
    return hashlib.sha256(described.encode()).hexdigest()[:12]


def _kept(table: Table, names: list[str], numbers: tuple[int, ...], store: Any) -> list[list[dict[str, Any]]]:
    """The rows that the table has already of each wheel, once where positions come again."""
    for row in table.rows:
        if row["identity"] not in names:
            what = f"position {row['position']}, y = {row['y']:g} mm, {row['side']}"
            raise SceneError(
                "store",
                str(store),
                message=f"{str(store)!r} has a wheel that is not in the case file as it is now ({what}); name a new "
                "file, or put back what was changed",
            )
    first = {row["identity"]: row["position"] for row in reversed(table.rows)}
    return [
        [
            {**row, "position": number}
            for row in table.rows
            if row["identity"] == name and row["position"] == first[name]
        ]
        for name, number in zip(names, numbers, strict=True)
    ]


def _rows(case: WheelOnRail, file: CaseFile, solved: Seen) -> list[dict[str, Any]]:
    """The rows of one of several wheels, also where it cannot be solved."""
    try:
        return _solved(case, file, solved)
    except VarcontactError as error:
        outcome = "not converged" if isinstance(error, NotConverged) else "refused"
        blank = dict.fromkeys(COLUMNS[6:-1], float("nan"))
        place = {"y": case.position.y, "roll": case.position.roll, "yaw": case.position.yaw}
        return [
            {"side": case.side, "patch": 0, "outcome": outcome, "reason": str(error), "warnings": ""} | blank | place
        ]


def _solved(case: WheelOnRail, file: CaseFile, solved: Seen) -> list[dict[str, Any]]:
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        found = case.solve(**file.options)
    if solved is not None:
        solved(found)
    told = [str(each.message) for each in said] + [text for each in found.patches for text in each.solution.warnings]
    words = "; ".join(dict.fromkeys(told))
    return [{**row, "warnings": words} for row in patch_rows(found, file.archard)]


def patch_rows(found: WheelRailSolution, archard: Archard | None = None) -> list[dict[str, Any]]:
    """What the table says of a solved wheel, patch by patch.

    Parameters
    ----------
    found : WheelRailSolution
    archard : Archard, optional

    Returns
    -------
    list of dict
    """
    at = found.case.position
    place = {"y": at.y, "roll": at.roll, "yaw": at.yaw, "z": found.z}
    return [
        {
            "side": found.case.side,
            "patch": k,
            "outcome": "solved",
            "reason": "",
            "warnings": "",
            **place,
            **_figures(each),
        }
        for k, each in enumerate(wear(found, archard).patches, 1)
    ]


def _figures(worn: PatchWear) -> dict[str, float]:
    solved, patch = worn.solved, worn.solved.patch
    named = {
        ("location_x", "location_y", "location_z"): patch.location,
        ("FN", "Fx", "Fs"): np.roll(solved.force, 1),
        ("track_Fx", "track_Fy", "track_Fz"): solved.force_on_track,
        ("error_FN", "error_Fx", "error_Fs"): np.roll(solved.error, 1),
    }
    law = worn.archard is not None
    return {
        name: float(value) for names, values in named.items() for name, value in zip(names, values, strict=True)
    } | {
        "angle": patch.angle,
        "on_rail": float(patch.on_rail[0]),
        "on_wheel": float(patch.on_wheel[0]),
        "rolling_radius": patch.rolling_radius,
        "vx": patch.creepage.vx,
        "vy": patch.creepage.vy,
        "spin": patch.creepage.spin,
        "Mz": solved.moment,
        "peak_pressure": solved.peak_pressure,
        "area": worn.area,
        "T_gamma": worn.t_gamma,
        "power": worn.power,
        "wear_depth": float(worn.depth.max()) if law else float("nan"),
        "wear_volume": worn.volume if law else float("nan"),
    }
