"""Error bars that wheels and wheel sets have by default, judged by grids 2.5 times finer.

Each case that is judged is kept at once in results/bars_cases.json: a run that was stopped goes on
where it was.
"""

import json
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import varcontact as vc
from tests.benchmarks.table import RESULTS, Table
from varcontact.solving.options import DEFAULT_ACCURACY
from varcontact.wheel_rail import (
    Position,
    Profile,
    ProfileSlices,
    Track,
    Velocity,
    WheelOnRail,
    WheelRailSolution,
    WheelSet,
    WheelSetOnTrack,
)

CASES = RESULTS / "bars_cases.json"
FINER = 2.5
"""Elements across on the grids that judge, by those that are judged."""
ACCURACY = DEFAULT_ACCURACY / FINER**1.5
"""The accuracy that has them: errors fall by the power 1.5 of the elements."""
QUICK = 6
"""With --quick so many cases are judged."""
Case = WheelOnRail | WheelSetOnTrack


def worn(profile: Profile, depth: float, at: float, width: float) -> Profile:
    """A profile worn by a depth around a place, as by a Gaussian [mm]."""
    into = 1.0 if profile.kind == "rail" else -1.0
    return replace(profile, z=profile.z + into * depth * np.exp(-(((profile.y - at) / width) ** 2)))


def measured(profile: Profile, seed: int) -> Profile:
    """A profile with noise of 2 micrometres, smoothed."""
    noise = 2e-3 * np.random.default_rng(seed).normal(size=profile.z.size)
    return replace(profile, z=profile.z + noise).smoothed(5.0)


def crossing() -> ProfileSlices:
    """A rail whose head gets narrower and lower within 300 mm, as a wing rail does."""
    rail, places = Profile.rail_60e1(), np.linspace(-150.0, 150.0, 13)
    profiles = [
        replace(rail, y=rail.y * (1 - 2e-4 * (s + 150.0)), z=rail.z + 2e-3 * (s + 150.0))
        for s in places
    ]
    return ProfileSlices(profiles=profiles, positions=places)


RAIL, WHEEL = Profile.rail_60e1(), Profile.s1002()
PAIRS: dict[str, tuple[Any, Any]] = {
    "new": (RAIL, WHEEL),
    "worn": (worn(RAIL, 0.4, -8.0, 15.0), worn(WHEEL, 1.0, 0.0, 20.0)),
    "measured": (measured(RAIL, 1), measured(WHEEL, 2)),
    "two patches": (worn(RAIL, 0.4, 0.0, 8.0), WHEEL),
    "flange": (RAIL, WHEEL),
    "crossing": (crossing(), WHEEL),
}
PLACES = {"two patches": (-3.0, -0.5), "flange": (4.8, 6.6)}
"""Lateral displacements [mm] for a cant of 1:40; for others they are from -4 to 5, and the cant
1:40 or 1:20."""


def drawn(kind: str, k: int) -> dict[str, Any]:
    """Entries of a case of a kind, the same for the same number."""
    rail, wheel = PAIRS[kind]
    low, high = PLACES.get(kind, (-4.0, 5.0))
    rng = np.random.default_rng([50, list(PAIRS).index(kind), k])
    return {
        "track": Track(
            rail=rail, cant=1 / 40 if kind in PLACES else float(rng.choice([1 / 40, 1 / 20]))
        ),
        "wheelset": WheelSet(wheel=wheel),
        "position": Position(y=float(rng.uniform(low, high)), yaw=float(rng.uniform(-4e-3, 4e-3))),
        "velocity": Velocity(speed=20e3),
        "friction": float(rng.uniform(0.1, 0.5)),
        "vertical_force": float(rng.uniform(30e3, 120e3)),
    }


def wheel_cases() -> Iterator[tuple[str, Case]]:
    """One of each kind at a time: a run that is stopped has some of all."""
    for k in range(10):
        for kind in PAIRS:
            yield f"wheel, {kind} {k}", WheelOnRail(**drawn(kind, k))


def wheel_set_cases() -> Iterator[tuple[str, Case]]:
    for k in range(5):
        for kind in PAIRS:
            entries = drawn(kind, k)
            yield (
                f"set, {kind} {k}",
                WheelSetOnTrack(**entries | {"vertical_force": 2 * entries["vertical_force"]}),
            )


def patches_of(found: Any) -> list[tuple[str, Any]]:
    wheels = [found] if isinstance(found, WheelRailSolution) else [found.left, found.right]
    return [
        (f"{wheel.case.side} {k}", each) for wheel in wheels for k, each in enumerate(wheel.patches)
    ]


def figures(found: Any) -> dict[str, tuple[float, float]]:
    """What has an error bar, with it: forces of all and of each patch, and peak pressures."""
    values = dict(zip(("Fx", "Fy", "Fz"), zip(found.force, found.error, strict=True), strict=True))
    for name, each in patches_of(found):
        values |= {
            f"{label} of {name}": pair
            for label, pair in zip(
                ("Fx", "Fs", "FN"), zip(each.force, each.error, strict=True), strict=True
            )
        }
        values[f"peak of {name}"] = each.peak_pressure, each.peak_pressure_error
    return {name: (float(value), float(bar)) for name, (value, bar) in values.items() if bar != 0}


def finer(case: Case, found: Any) -> Any:
    """The case on grids 2.5 times finer: to the accuracy that has them, or on elements where these
    told the error.
    """
    estimates = [each.solution.error_estimate for _, each in patches_of(found)]
    if all(each is not None and each.accuracy is not None for each in estimates):
        return case.solve(accuracy=ACCURACY)
    sides = np.min([each.solution.grid.sides for _, each in patches_of(found)], axis=0) / FINER
    return replace(case, dx=float(sides[0]), dy=float(sides[1])).solve()


def judged(case: Case) -> dict[str, Any]:
    """Errors by their bars; an error of the library stands as it is said."""
    begun = time.process_time()
    try:
        found = case.solve()
        seconds = time.process_time() - begun
        exact = {name: value for name, (value, _) in figures(finer(case, found)).items()}
    except vc.VarcontactError as error:
        return {"refused": f"{type(error).__name__}: {error}"}
    own = figures(found)
    ratios = {
        name: abs(value - exact[name]) / bar for name, (value, bar) in own.items() if name in exact
    }
    bars = {name: bar / abs(value) for name, (value, bar) in own.items()}
    return {
        "ratios": ratios,
        "bars": bars,
        "seconds": seconds,
        "fine seconds": time.process_time() - begun - seconds,
    }


def _judge(cases: Iterator[tuple[str, Case]], quick: bool) -> dict[str, dict[str, Any]]:
    known = json.loads(CASES.read_text()) if CASES.exists() else {}
    rows: dict[str, dict[str, Any]] = {}
    for number, (name, case) in enumerate(cases):
        if quick and number >= QUICK:
            break
        if name not in known:
            known[name] = judged(case)
            print(name, summary([known[name]]), flush=True)
            if not quick:
                CASES.write_text(json.dumps(known, indent=1) + "\n")
        rows[name] = known[name]
    return rows


def summary(rows: list[dict[str, Any]]) -> list[Any]:
    """Cases, those refused, error bars, unknown ones, those kept in per cent, and the largest error
    by its bar.
    """
    ratios = np.array([ratio for row in rows for ratio in row.get("ratios", {}).values()])
    known = ratios[np.isfinite(ratios)]
    kept = float(np.mean(known <= 1) * 100) if known.size else math.nan
    refused = sum("refused" in row for row in rows)
    return [
        len(rows),
        refused,
        known.size,
        ratios.size - known.size,
        kept,
        float(known.max(initial=0.0)),
    ]


def table(cases: Callable[[], Iterator[tuple[str, Case]]], quick: bool) -> Table:
    rows = _judge(cases(), quick)
    lines: list[list[Any]] = []
    for kind in PAIRS:
        own = [row for name, row in rows.items() if f", {kind} " in name]
        if own:
            lines.append([kind, *summary(own)])
    lines.append(["all", *summary(list(rows.values()))])
    head = ["", "cases", "refused", "error bars", "unknown", "kept [%]", "largest error by its bar"]
    return Table(head, ["", "", "", "", "", ".1f", ".2f"], lines)


def wheels(quick: bool) -> Table:
    """Error bars of 60 wheels by default, judged by grids 2.5 times finer."""
    return table(wheel_cases, quick)


def wheel_sets(quick: bool) -> Table:
    """Error bars of 30 wheel sets by default, judged by grids 2.5 times finer."""
    return table(wheel_set_cases, quick)


TABLES = {"wheels": wheels, "wheel_sets": wheel_sets}
