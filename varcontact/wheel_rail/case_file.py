"""Case files: wheels on rails as TOML files, one position or a sequence, and the table of their
solutions.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import LEVELS
from varcontact.errors import Interrupted, NotConverged, SceneError, VarcontactError, warn
from varcontact.io.scene_toml import SOLVE_KEYS, solve_table
from varcontact.io.toml_tables import check_keys, number_range, read_toml, table_of
from varcontact.scene.friction import Law
from varcontact.scene.plausibility import warn_plausibility
from varcontact.solving.methods import taken_apart
from varcontact.solving.selection import check_existing
from varcontact.study.csv_table import Table, completed, of_another
from varcontact.study.parallel import Execution, opened, results
from varcontact.system.process import imported
from varcontact.system.progress import Progress
from varcontact.wheel_rail.case_tables import make_parts, wear_from
from varcontact.wheel_rail.patch_warnings import warn_of_patches
from varcontact.wheel_rail.plausibility import warnings_of
from varcontact.wheel_rail.position import Position, Velocity
from varcontact.wheel_rail.quantities import WORDS, axle_values, columns, wheel_values
from varcontact.wheel_rail.result import WheelRailSolution
from varcontact.wheel_rail.solve import SIDE_BY_SIDE, check_methods, solve_wheels_on_rails
from varcontact.wheel_rail.track import Side
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_on_rail import WheelOnRail
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack
from varcontact.wheel_rail.wheel_set_loads import LOADS
from varcontact.wheel_rail.wheel_set_solution import WheelSetSolution

if TYPE_CHECKING:
    import pandas as pd

VARYING = ("vertical_force", "z", *LOADS)
MOVING: dict[str, type[Any]] = {"position": Position, "velocity": Velocity}
SIDES: dict[str, tuple[Side, ...]] = {
    "left": ("left",),
    "right": ("right",),
    "both": ("left", "right"),
    "set": (),
}
GROUP = 4 * SIDE_BY_SIDE
"""Wheels of a table at most that are solved side by side: 256 take 13 % longer than all at once.

An interruption loses those that were begun.
"""


@dataclass(frozen=True, eq=False)
class CaseFile:
    """The contents of a case file."""

    # position by position; of both sides, the left wheel first
    cases: tuple[WheelOnRail | WheelSetOnTrack, ...]
    numbers: tuple[int, ...]  # the number of each case's position, from 1
    options: dict[str, Any]  # keywords of `WheelOnRail.solve`
    archard: Archard | ArchardMap | None  # from the table ``[wear]``
    fast: bool = False  # whether cases are estimated, with the options of that
    yield_in_shear: float | None = None  # of the rail, from the table ``[shakedown]``


def read_case(path: str | Path) -> CaseFile:
    """Read the case of a wheel on a rail, or a sequence of positions.

    Parameters
    ----------
    path : str or Path
        A TOML file with the entries of `WheelOnRail`, in mm, N, rad and mm/s;
        objects are tables of their entries. ``track.rail`` and
        ``wheelset.wheel`` are "60e1", "s1002", the name of a file beside this
        one, or a table: ``file`` and options of `Profile.read`, or the entries
        of `ProfileSlices`. Rails may be lists of these. ``side`` may be "both",
        or "set": a `WheelSetOnTrack`, with its loads and ``free``. Numbers in
        ``[position]`` and ``[velocity]``, and loads may be lists of one length,
        or ranges ``{from, to, count}``: the sequence.

    Returns
    -------
    CaseFile

    Raises
    ------
    SceneError
        If the file cannot be read, or says something a case cannot be.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "case.toml"
    >>> _ = path.write_text('''
    ... vertical_force = 80e3
    ... track = { rail = "60e1", cant = 0.025 }
    ... wheelset = { wheel = "s1002" }
    ... position = { y = [0.0, 2.0, 4.0], yaw = { from = 0.0, to = 0.01, count = 3 } }
    ... ''')
    >>> [case.position.yaw for case in read_case(path).cases]
    [0.0, 0.005, 0.01]
    >>> folder.cleanup()
    """
    table, folder = read_toml(path, "case file")
    options = solve_table(table)
    check_keys("solve", options, [key for key in SOLVE_KEYS if key not in ("polish", "start")])
    sides = SIDES[checks.choice("side", table.pop("side", "right"), SIDES)]
    archard = None
    if "wear" in table:
        archard = wear_from(table.pop("wear"))
    case_type = WheelOnRail if sides else WheelSetOnTrack
    strength = None
    if "shakedown" in table:
        entries = table_of("shakedown", table.pop("shakedown"))
        check_keys("shakedown", entries, ("yield_in_shear",))
        strength = checks.positive("shakedown.yield_in_shear", entries.get("yield_in_shear"))
    taken = ["solve", "side", "wear", "shakedown"]
    check_keys("", table, _names_of(case_type), taken)
    # parts that all positions have in common, and entries that may vary
    make_parts(table, folder)
    varying = _varying_entries(table)
    # the cases of each position
    cases: list[WheelOnRail | WheelSetOnTrack] = []
    numbers: list[int] = []
    for number, at in enumerate(_sequence(varying), 1):
        entries = table | _at_position(at)
        if sides:
            cases += [WheelOnRail(side=side, **entries) for side in sides]
        else:
            cases.append(WheelSetOnTrack(**entries))
        numbers += [number] * max(1, len(sides))
    return CaseFile(tuple(cases), tuple(numbers), options, archard, yield_in_shear=strength)


def _names_of(kind: type[Any]) -> list[str]:
    return [field.name for field in dataclasses.fields(kind)]


def _varying_entries(table: dict[str, Any]) -> dict[str, Any]:
    """Entries of a table that may be lists, taken out of it: loads, and "position.y" and others."""
    varying = {name: table.pop(name) for name in VARYING if name in table}
    for name, kind in MOVING.items():
        entries = dict(table_of(name, table.pop(name, {})))
        check_keys(name, entries, _names_of(kind))
        varying |= {f"{name}.{key}": value for key, value in entries.items()}
    return varying


def _at_position(entries: dict[str, Any]) -> dict[str, Any]:
    """Loads, position and velocity, by entries of the one and the others."""
    loads: dict[str, Any] = {}
    moving: dict[str, dict[str, Any]] = {name: {} for name in MOVING}
    for name, value in entries.items():
        group, _, entry = name.rpartition(".")
        if group:
            moving[group][entry] = value
        else:
            loads[entry] = value
    return loads | {name: kind(**moving[name]) for name, kind in MOVING.items()}


def _sequence(entries: dict[str, Any]) -> list[dict[str, Any]]:
    """The entries of each position, with one value in place of a list or range."""
    for name, value in entries.items():
        if isinstance(value, Mapping):
            entries[name] = number_range(name, value)
        elif isinstance(value, list):
            checks.numbers(name, value)
    lengths = {name: len(value) for name, value in entries.items() if isinstance(value, list)}
    if len(set(lengths.values())) > 1 or 0 in lengths.values():
        given = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        reason = f"lists of a sequence must have the same length, one or more: {given}"
        raise SceneError("sequence", given, message=reason)
    return [
        {name: value[k] if isinstance(value, list) else value for name, value in entries.items()}
        for k in range(max(lengths.values(), default=1))
    ]


def solve_cases(
    file: CaseFile,
    store: str | Path | None = None,
    progress: Progress = None,
    solved: Callable[[WheelRailSolution | WheelSetSolution], None] | None = None,
    *,
    workers: int = 1,
    executor: Executor | None = None,
) -> pd.DataFrame:
    """Solve all positions of a case file.

    Parameters
    ----------
    file : CaseFile
    store : str or Path, optional
        A table (.csv), written after each wheel; wheels already in it are not
        solved again. Of many with `dx` or `dy`, groups of up to 128 are solved
        side by side, and one that was begun is solved again as a whole: the
        table has the same bytes as without an interruption.
    progress : callable or true, optional
        Called with the progress before each wheel; of many with `dx` or `dy`,
        which are solved side by side, after it.
    solved : callable, optional
        Called with each solution, but for wheels that the table has already;
        not with processes.
    workers, executor
        As for `varcontact.sweep`.

    Returns
    -------
    DataFrame
        A row for each patch, with the quantities of
        `varcontact.wheel_rail.quantities.QUANTITIES`: outcome is "solved"; where a wheel of several
        is not, it has one row without figures, "not converged" or "refused", and the reason.

    Raises
    ------
    SceneError
        If the table is of other cases; if there is one wheel alone and it
        cannot be solved.
    NotConverged
        If there is one wheel alone and it is not solved.
    OutputError
        If the table cannot be written.
    Interrupted
        By Ctrl-C. Its `partial` is the table of the finished wheels, and the
        store has it.
    """
    pd = imported("pandas")  # imported now: after Ctrl-C the import would have to be waited for
    table_of_rows = partial(pd.DataFrame, columns=list(_columns_of(file)))
    execution = Execution(executor, workers, checks.progress(progress))
    try:
        return table_of_rows(solve_rows(file, store, execution, solved))
    except Interrupted as stopped:
        stopped.partial = table_of_rows(stopped.partial)
        raise


def solve_rows(
    file: CaseFile,
    store: str | Path | None,
    execution: Execution,
    solved: Callable[[WheelRailSolution | WheelSetSolution], None] | None = None,
) -> list[dict[str, Any]]:
    """The rows of `solve_cases`, each with all columns."""
    _check_options(file)
    report = execution.progress
    names = _identities(file)
    total = len(names)
    names_of_columns = _columns_of(file)
    what = "a table of wheels on rails"

    with (
        opened(execution.executor, execution.workers) as pool,
        Table.opened(store, names_of_columns, WORDS, what) as table,
    ):
        rows = _kept(table, names, file.numbers)
        left = [k for k in range(total) if not rows[k]]
        work = partial(
            _rows,
            file=dataclasses.replace(file, cases=()),
            alone=total == 1,
            solved=solved if pool is None else None,
        )
        together = _on_grids(file) and pool is None and total > SIDE_BY_SIDE

        def report_case(k: int, before: int) -> None:
            case = file.cases[k]
            place = f"y = {case.position.y:.4g} mm, {_side_of(case)}"
            report(f"{before} of {total} wheels, {place}")

        answers: Iterator[tuple[int, list[dict[str, Any]]]]
        if together:
            answers = (
                (k, work(file.cases[k], known=known)) for k, known in _in_groups(file, set(left))
            )
        else:
            tasks = {k: (file.cases[k],) for k in left}
            answers = results(work, tasks, pool, lambda k: report_case(k, k))
        try:
            for k, new in answers:
                if together:
                    report_case(k, _count_finished(rows))
                rows[k] = [
                    {"position": file.numbers[k], **row, "identity": names[k]} for row in new
                ]
                table.write(list(chain(*rows)))
        except KeyboardInterrupt:
            words = f" after {_count_finished(rows)} of {total} wheels"
            raise Interrupted(completed(chain(*rows), names_of_columns), words) from None
    return completed(chain(*rows), names_of_columns)


def _check_options(file: CaseFile) -> None:
    """Refuse methods that do not exist, and options that wheels do not have; all have the same
    elements.
    """
    if file.fast:
        return
    methods, others = taken_apart(file.options)
    check_existing(methods)
    checks.positive("tol", others.get("tol", 1.0))
    checks.choice("certify", others.get("certify", "auto"), ("auto", *LEVELS))
    first = file.cases[0]
    if isinstance(first, WheelOnRail):
        check_methods(first, file.options)


def _columns_of(file: CaseFile) -> tuple[str, ...]:
    """Column names of the table of solutions."""
    return columns(of_sets=isinstance(file.cases[0], WheelSetOnTrack))


def _count_finished(rows: list[list[dict[str, Any]]]) -> int:
    """Number of wheels that have rows."""
    return len(rows) - rows.count([])


def _on_grids(file: CaseFile) -> bool:
    """True if all cases are wheels that are solved on elements with `dx` or `dy`."""
    return not file.fast and all(
        isinstance(case, WheelOnRail) and (case.dx is not None or case.dy is not None)
        for case in file.cases
    )


def _side_of(case: WheelOnRail | WheelSetOnTrack) -> str:
    if isinstance(case, WheelOnRail):
        return case.side
    return "both"


def _in_groups(
    file: CaseFile, left: set[int]
) -> Iterator[tuple[int, WheelRailSolution | VarcontactError]]:
    """The numbers and solutions of wheels on grids, of which groups of the whole file are solved
    side by side.

    A group with a wheel left is solved as a whole: wheels begin from each other, and have the same
    digits again.
    """
    total = len(file.cases)
    for group in np.array_split(np.arange(total), math.ceil(total / GROUP)):
        if left.isdisjoint(group.tolist()):
            continue
        cases: list[Any] = [file.cases[k] for k in group]
        for number, known in solve_wheels_on_rails(cases, **file.options):
            yield int(group[number]), known


def _identities(file: CaseFile) -> list[str]:
    """Short digest of each wheel and its settings."""
    # by the place in memory, as wheels share tracks and wheel sets
    described: dict[int, str] = {}

    def description(entry: Any) -> str:
        if id(entry) not in described:
            described[id(entry)] = _as_json(entry)
        return described[id(entry)]

    names = sorted(each.name for each in dataclasses.fields(file.cases[0]))
    settings: list[Any] = [file.options, file.archard]
    if file.fast:
        settings.append("fast")
    if file.yield_in_shear is not None:
        settings.append(file.yield_in_shear)
    of_all = _as_json(settings).removeprefix("[")
    identities = []
    for case in file.cases:
        entries = ", ".join(f'"{name}": {description(getattr(case, name))}' for name in names)
        text = f'[{{{entries}}}, ["{type(case.friction).__name__}", {of_all}]'
        identities.append(hashlib.sha256(text.encode()).hexdigest()[:12])
    return identities


def _as_json(entry: Any) -> str:
    """An entry in JSON, with the entries of dataclasses by their names."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return value.tolist()
        entries = {each.name: getattr(value, each.name) for each in dataclasses.fields(value)}
        # within pairs and products laws of other classes have the same entries
        if isinstance(value, Law) and value is not entry:
            entries["kind"] = type(value).__name__
        return entries

    return json.dumps(entry, sort_keys=True, default=plain)


def _kept(table: Table, names: list[str], numbers: tuple[int, ...]) -> list[list[dict[str, Any]]]:
    """Rows that the table already has, by wheel; only once where positions are repeated."""
    kept: dict[str, list[dict[str, Any]]] = {name: [] for name in names}
    for row in table.rows:
        if row["identity"] not in kept:
            what = f"position {row['position']}, y = {row['y']:g} mm, {row['side']}"
            raise of_another(
                table.path, f"has a wheel that is not in the case file as it is now ({what})"
            )
        own = kept[row["identity"]]
        if not own or own[0]["position"] == row["position"]:
            own.append(row)
    return [
        [{**row, "position": n} for row in kept[name]]
        for name, n in zip(names, numbers, strict=True)
    ]


def _rows(
    case: WheelOnRail | WheelSetOnTrack,
    file: CaseFile,
    alone: bool,
    solved: Callable[[Any], None] | None,
    known: WheelRailSolution | VarcontactError | None = None,
) -> list[dict[str, Any]]:
    """Rows of a case of a `file`, `known` or new; if it is the only one, its error is raised."""
    at = case.position
    row: dict[str, Any] = {
        "side": _side_of(case),
        "y": at.y,
        "roll": at.roll,
        "yaw": at.yaw,
    }
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            found: Any = known
            if isinstance(known, VarcontactError):
                warn_plausibility(warnings_of(case))
                raise known
            if known is not None:
                warn_of_patches(known)
            elif file.fast:
                found = case.estimate(**file.options)
            else:
                found = case.solve(**file.options)
    except VarcontactError as error:
        if alone:  # what it was warned of may be why
            for each in caught:
                warn(str(each.message), each.category)
            raise
        outcome = "refused"
        if isinstance(error, NotConverged):
            outcome = "not converged"
        row |= {"patch": 0, "outcome": outcome, "reason": str(error)}
        return [{**row, "warnings": _each_once(_texts_of(caught))}]
    if solved is not None:
        solved(found)
    texts = _texts_of(caught)
    of_sets = isinstance(case, WheelSetOnTrack)
    row |= {"outcome": "solved", "reason": ""} | axle_values(found, of_sets)
    rows = []
    for wheel in found.wheels:
        side = wheel.case.side
        texts += wheel.warnings
        of_wheel = row | {"side": side} | wheel_values(found, side, of_sets)
        for k, figures in enumerate(wheel.quantities(file.archard, file.yield_in_shear), 1):
            rows.append({**of_wheel, "patch": k, **figures})
    return [{**each, "warnings": _each_once(texts)} for each in rows]


def _texts_of(caught: list[warnings.WarningMessage]) -> list[str]:
    return [str(each.message) for each in caught]


def _each_once(texts: list[str]) -> str:
    return "; ".join(dict.fromkeys(texts))
