"""Sweeps of wheel sets: positions, loads, speeds, friction, gauge and profile pairs in one call."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.study.parameters import changed, varied_values
from varcontact.system.process import imported
from varcontact.system.progress import Progress
from varcontact.wheel_rail import quantities
from varcontact.wheel_rail.case_file import CaseFile, solve_cases
from varcontact.wheel_rail.quantities import KEYS
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

KEYS_OF = {"axle": KEYS[:1], "wheel": KEYS[:2], "patch": KEYS}
"""Columns that identify a row, by what a quantity belongs to."""


def _of_wheel_sets(given: Mapping[str, Any]) -> tuple[str, ...]:
    if given.get("fast") is True:
        return checks.options_of(WheelSetOnTrack.estimate)
    return checks.options_of(WheelSetOnTrack.solve)


@checks.named_options(_of_wheel_sets)
def sweep_wheel_sets(
    cases: WheelSetOnTrack | Mapping[str, WheelSetOnTrack],
    over: Mapping[str, Iterable[Any]],
    *,
    archard: Archard | ArchardMap | None = None,
    yield_in_shear: float | None = None,
    fast: bool = False,
    workers: int = 1,
    executor: Executor | None = None,
    store: str | Path | None = None,
    progress: Progress = None,
    **methods: Any,
) -> xr.Dataset:
    """Solve wheel sets for all combinations of values.

    Parameters
    ----------
    cases : WheelSetOnTrack, or mapping of str to WheelSetOnTrack
        Several by name make a dimension "case": pairs of profiles.
    over : mapping
        Values by entry:
        ``{"position.y": [0.0, 2.0], "track.gauge": [1433.0, 1435.0], "vertical_force": [1e5]}``.
    archard : Archard or ArchardMap, optional
        For depth and volume of wear.
    yield_in_shear : float, optional
        k of the rails [N/mm^2], for bounds on the shakedown limit and its mode, see
        `WheelRailSolution.quantities`.
    fast : bool
        Whether cases are estimated instead of solved.
    workers, executor
        See `varcontact.sweep`.
    store : str or Path, optional
        A table (.csv), written after each case; called again, the sweep resumes
        from it.
    progress : callable or true, optional
        Called with the progress.
    **methods
        Arguments of `WheelSetOnTrack.solve`, or of `estimate`.

    Returns
    -------
    xarray.Dataset
        Over the entries, "side" and "patch", with units; NaN where there is no
        patch, or where `outcome` is not "solved" (`reason` says why). Results
        for entries that vary are in ``found_y`` and others.

    Raises
    ------
    SceneError
        For entries that a wheel set has not.
    Interrupted, OutputError, WorkersLost
        See `varcontact.sweep`.

    Examples
    --------
    >>> from varcontact.wheel_rail import Profile, Track, WheelSet, WheelSetOnTrack
    >>> case = WheelSetOnTrack(
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
    ...     wheelset=WheelSet(wheel=Profile.s1002()), vertical_force=160e3)
    >>> over = {"position.y": [-3.0, 0.0, 3.0], "friction": [0.1, 0.4]}
    >>> found = sweep_wheel_sets(case, over, fast=True)
    >>> dict(found["T_gamma"].sizes), found["T_gamma"].units
    ({'position.y': 3, 'friction': 2, 'side': 2, 'patch': 1}, 'N')
    >>> print(found["T_gamma"].sel(side="right", patch=1, friction=0.4).values.round(1))
    [10.4  2.5 14.2]
    """
    xr = imported("xarray")
    named = _cases_by_name(cases)
    if archard is not None:
        checks.kind("archard", archard, Archard, ArchardMap)
    if yield_in_shear is not None:
        yield_in_shear = checks.positive("yield_in_shear", yield_in_shear)
    fast = checks.flag("fast", fast)
    # all combinations of values, and the table of their solutions
    values = varied_values(over, numbers=False)
    points = [dict(zip(values, at, strict=True)) for at in product(*values.values())]
    made = [changed(case, point, "wheel set") for case in named.values() for point in points]
    numbers = tuple(range(1, len(made) + 1))
    file = CaseFile(tuple(made), numbers, methods, archard, fast, yield_in_shear)
    table = solve_cases(file, store, progress, workers=workers, executor=executor)
    # dimensions of the dataset
    coordinates: dict[str, Any] = dict(values)
    if "" not in named:
        coordinates = {"case": list(named)} | coordinates
    patches = max(1, int(table["patch"].max()))
    places = {"side": ["left", "right"], "patch": np.arange(1, patches + 1)}
    columns = _columns(table, coordinates, {"position": file.numbers, **places})
    return xr.Dataset(columns, coords=coordinates | places)


def _cases_by_name(cases: Any) -> dict[str, WheelSetOnTrack]:
    """The cases of a mapping, or a single one without a name."""
    if isinstance(cases, WheelSetOnTrack):
        return {"": cases}
    allowed = "a WheelSetOnTrack, or a mapping of them by name"
    if not isinstance(cases, Mapping) or not cases:
        raise SceneError("cases", cases, allowed)
    if not all(isinstance(each, WheelSetOnTrack) for each in cases.values()):
        raise SceneError("cases", cases, allowed)
    return {str(name): case for name, case in cases.items()}


def _columns(
    table: pd.DataFrame, coordinates: dict[str, Any], places: dict[str, Any]
) -> dict[str, Any]:
    """Texts and quantities over the coordinates; `places` has all values of the keys of rows."""
    columns: dict[str, Any] = {}
    shape = tuple(len(each) for each in coordinates.values())
    for name in quantities.TEXTS:
        texts = _filled(table, name, {"position": places["position"]}).astype(str)
        columns[name] = (tuple(coordinates), texts.reshape(shape))
    solved = table[table["outcome"] == "solved"]
    for quantity in quantities.QUANTITIES:
        keys = KEYS_OF[quantity.of]
        rows = table if quantity.of == "axle" else solved
        column = _filled(rows, quantity.name, {key: places[key] for key in keys}).astype(float)
        name = quantity.name
        if name in coordinates:
            name = f"found_{name}"
        units = {}
        if quantity.unit:
            units["units"] = quantity.unit
        dimensions = (*coordinates, *keys[1:])
        columns[name] = (dimensions, column.reshape(*shape, *column.shape[1:]), units)
    return columns


def _filled(rows: pd.DataFrame, name: str, keys: Mapping[str, Any]) -> np.ndarray:
    """A column over all values of the keys, missing where there is no row."""
    column = rows.groupby(list(keys))[name].first().to_xarray()
    return np.asarray(column.reindex(keys).to_numpy())
