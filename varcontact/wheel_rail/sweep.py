"""Sweeps of wheel sets: positions, loads, speeds, friction, gauge and profile pairs in one call."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.study.parameters import changed, varied_values
from varcontact.system.process import imported
from varcontact.wheel_rail.case_file import OF_SETS, WORDS, CaseFile, solve_cases
from varcontact.wheel_rail.wear_laws import Archard, ArchardMap
from varcontact.wheel_rail.wheel_set import WheelSetOnTrack

if TYPE_CHECKING:
    import xarray as xr

UNITS = {
    "mm": "y z location_x location_y location_z on_rail on_wheel rolling_radius wear_depth",
    "rad": "roll yaw angle",
    "1/mm": "spin",
    "N": "FN Fx Fs track_Fx track_Fy track_Fz T_gamma T_gamma_error error_Fx error_Fs error_FN",
    "N mm": "Mz",
    "N/mm2": "peak_pressure",
    "mm2": "area",
    "W": "power",
    "mm3/mm": "wear_volume",
    "rad/s": "pitch_rate",
}
KEYS = ("position", "side", "patch")
OF_AXLE = ("outcome", "reason", "warnings", "y", "roll", "yaw", "z", "pitch_rate", "imbalance")
"""Columns that both wheels share; y, roll and yaw in a dataset are those that were found."""
OF_WHEEL = ("Y_over_Q", "nadal")


def _of_wheel_sets(given: Mapping[str, Any]) -> tuple[str, ...]:
    return checks.options_of(
        WheelSetOnTrack.estimate if given.get("fast") is True else WheelSetOnTrack.solve
    )


@checks.named_options(_of_wheel_sets)
def sweep_wheel_sets(
    cases: WheelSetOnTrack | Mapping[str, WheelSetOnTrack],
    over: Mapping[str, Iterable[Any]],
    *,
    archard: Archard | ArchardMap | None = None,
    fast: bool = False,
    workers: int = 1,
    executor: Executor | None = None,
    store: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
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
    fast : bool
        Whether cases are estimated instead of solved.
    workers, executor
        See `varcontact.sweep`.
    store : str or Path, optional
        A table (.csv), written after each case; called again, the sweep resumes
        from it.
    progress : callable, optional
        Called with the progress.
    **methods
        Of `WheelSetOnTrack.solve`, or of `estimate`.

    Returns
    -------
    xarray.Dataset
        Over the entries, "side" and "patch", with units; NaN where there is no
        patch, or where `outcome` is not "solved" (`reason` says why). What was
        found of entries that vary is in ``found_y`` and others.

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
    ...     track=Track(rail=Profile.rail_60e1(), cant=1 / 40), wheelset=WheelSet(wheel=Profile.s1002()),
    ...     vertical_force=160e3)
    >>> found = sweep_wheel_sets(case, {"position.y": [-3.0, 0.0, 3.0], "friction": [0.1, 0.4]}, fast=True)
    >>> dict(found["T_gamma"].sizes), found["T_gamma"].units
    ({'position.y': 3, 'friction': 2, 'side': 2, 'patch': 1}, 'N')
    >>> print(found["T_gamma"].sel(side="right", patch=1, friction=0.4).values.round(1))
    [10.4  2.5 14.2]
    """
    xr = imported("xarray")
    if isinstance(cases, WheelSetOnTrack):
        named = {"": cases}
    elif (
        isinstance(cases, Mapping)
        and cases
        and all(isinstance(each, WheelSetOnTrack) for each in cases.values())
    ):
        named = {str(name): case for name, case in cases.items()}
    else:
        raise SceneError("cases", cases, "a WheelSetOnTrack, or a mapping of them by name")
    if archard is not None:
        checks.kind("archard", archard, Archard, ArchardMap)
    fast = checks.flag("fast", fast)
    values = varied_values(over, numbers=False)
    points = [dict(zip(values, at, strict=True)) for at in product(*values.values())]
    made = [changed(case, point, "wheel set") for case in named.values() for point in points]
    file = CaseFile(tuple(made), tuple(range(1, len(made) + 1)), methods, archard, fast)
    table = solve_cases(file, store, progress, workers=workers, executor=executor)
    coordinates: dict[str, Any] = ({} if "" in named else {"case": list(named)}) | values
    shape = tuple(len(each) for each in coordinates.values())
    patches = max(1, int(table["patch"].max()))
    places = {"side": ["left", "right"], "patch": np.arange(1, patches + 1)}
    whole: dict[str, Any] = {"position": file.numbers, **places}
    columns = {}
    for name in (each for each in OF_SETS if each not in (*KEYS, "identity")):
        keys = KEYS[: 1 if name in OF_AXLE else 2 if name in OF_WHEEL else 3]
        known = table if len(keys) == 1 else table[table["outcome"] == "solved"]
        column = (
            known.groupby(list(keys))[name]
            .first()
            .to_xarray()
            .reindex({key: whole[key] for key in keys})
        )
        values = (
            column.to_numpy()
            .astype(str if name in WORDS else float)
            .reshape(*shape, *column.shape[1:])
        )
        units = next(
            ({"units": unit} for unit, names in UNITS.items() if name in names.split()), {}
        )
        columns[f"found_{name}" if name in coordinates else name] = (
            (*coordinates, *keys[1:]),
            values,
            units,
        )
    return xr.Dataset(columns, coords=coordinates | places)
