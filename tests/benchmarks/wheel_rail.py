"""Wheels on rails: against CONTACT on the Manchester benchmark, what noise does to the pressure, and the time it takes.

python -m tests.benchmarks.wheel_rail [contact] [fast] [noise] [seconds]

All four without a word: the exact way and the fast one against CONTACT, noise, and processor seconds of both ways.
"""

import platform
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from tests.wheel_rail.conditions import RAIL, TRACK, WHEELSET, benchmark, manchester
from varcontact.wheel_rail import Position, Profile, Track, Velocity, WheelOnRail, geometry_table

NOISE, SEEDS = 0.002, (3, 4)
LENGTHS = (0.0, 2.0, 5.0, 10.0, 20.0)
REPEATS = 3


def differences(row: dict) -> list[float]:
    """Location [mm], angle [mrad], creepages, normal force, tangential forces by f Fn and peak pressure [%]."""
    each = benchmark(row).solve().patches[0]
    patch, found = each.patch, each.patch.creepage
    wanted = np.array([row["cksi"], row["ceta"], row["cphi"]])
    creepages = np.array([found.vx, found.vy, found.spin]) - wanted
    return [
        float(np.abs(patch.location - [row["x"], row["y"], row["z"]]).max()),
        1e3 * abs(patch.angle - row["angle"]),
        100 * float(np.abs(creepages[wanted != 0] / wanted[wanted != 0]).max()),
        100 * abs(each.normal_force / row["fn"] - 1),
        100 * float(np.abs(each.force[:2] - [row["fx"], row["fs"]]).max()) / (0.3 * row["fn"]),
        100 * abs(each.peak_pressure / row["pmax"] - 1),
    ]


def against_contact() -> None:
    """One line a position, and the largest of all."""
    print("side y: location [mm], angle [mrad], creepages, normal, tangential, peak pressure [%]")
    every = []
    for row in manchester():
        found = differences(row)
        print(f"{row['side']:5} {row['y_ws']:4.1f}: " + " ".join(f"{value:8.4f}" for value in found))
        every.append(found)
    print("largest:    " + " ".join(f"{value:8.4f}" for value in np.max(every, axis=0)))


def peak(rail: Profile, y: float, load: float) -> float:
    """Peak pressure of the right wheel on a rail."""
    case = WheelOnRail(
        track=Track(rail=rail),
        wheelset=WHEELSET,
        position=Position(y=y),
        vertical_force=load,
        dx=0.5,
        dy=0.2,
        join=1e3,
        separate=1e3,
    )
    return case.solve().patches[0].peak_pressure


def noise() -> None:
    """Peak pressures by that of the exact rail, least and greatest."""
    for load in (10e3, 80e3):
        for length in LENGTHS:
            rough, exact = [], []
            for y in (0.0, 2.0, 4.0):
                true = peak(RAIL, y, load)
                exact.append(peak(RAIL.smoothed(length), y, load) / true)
                for seed in SEEDS:
                    z = RAIL.z + NOISE * np.random.default_rng(seed).normal(size=RAIL.z.size)
                    rough.append(peak(Profile(y=RAIL.y, z=z, kind="rail", smoothing=length), y, load) / true)
            print(
                f"{load / 1e3:3.0f} kN, {length:4.1f} mm: {min(rough):.2f} to {max(rough):.2f}, "
                f"without noise {min(exact):.2f} to {max(exact):.2f}"
            )


FAST = [
    (normal, theory, {"outside": "clamp"} if theory == "table" else {})
    for normal in ("virtual-penetration", "hertz")
    for theory in ("fastsim", "fastrip", "table")
]


def fast_differences(row: dict, normal: str, theory: str, options: dict) -> list[float]:
    """Tangential forces by f Fn, normal force and peak pressure [%], location [mm]."""
    (each,) = benchmark(row).estimate(normal, theory, **options).patches
    return [
        100 * float(np.hypot(*(each.force[:2] - [row["fx"], row["fs"]]))) / (0.3 * row["fn"]),
        100 * abs(each.force[2] / row["fn"] - 1),
        100 * abs(each.ellipse.peak_pressure / row["pmax"] - 1),
        float(np.abs(each.frame.origin - [row["x"], row["y"], row["z"]]).max()),
    ]


def fast_against_contact() -> None:
    """Median and largest of the 42 wheels."""
    print("the fast way: tangential, normal force, peak pressure [%], location [mm], median and largest")
    for normal, theory, options in FAST:
        found = np.array([fast_differences(row, normal, theory, options) for row in manchester()])
        pairs = zip(np.median(found, axis=0), found.max(axis=0), strict=True)
        print(f"{normal:20} {theory:8}" + "".join(f"  {middle:7.3f}, {most:6.2f}" for middle, most in pairs))


def least(times: int, work: Callable[..., object], *arguments: Any, **options: Any) -> float:
    """Processor seconds of the fastest of several calls."""
    found = []
    for _ in range(times):
        begun = time.process_time()
        work(*arguments, **options)
        found.append(time.process_time() - begun)
    return min(found)


def seconds() -> None:
    """Of the geometry of a position, of the whole with the load given on elements of 0.5 mm, and of the fast way."""

    def way(row: dict, name: str, *arguments: Any, **options: Any) -> object:
        return getattr(benchmark(row, dx=0.5, dy=0.5), name)(*arguments, **options)

    rows = manchester()
    shown = {
        "geometry": [least(REPEATS, way, row, "patches", row["z_ws"]) for row in rows],
        "whole": [least(REPEATS, way, row, "solve") for row in rows],
    }
    for normal, theory, options in FAST:
        shown[f"{normal}, {theory}"] = [least(REPEATS, way, row, "estimate", normal, theory, **options) for row in rows]
    table = geometry_table(
        TRACK, WHEELSET, y=np.linspace(-6.0, 6.0, 13), yaw=np.linspace(-0.01, 0.01, 5), vertical_force=50e3
    )
    velocity = Velocity(speed=20e3, lateral=12.0, yaw_rate=0.02)
    for theory in ("fastsim", "fastrip", "table"):
        shown[f"tabulated, both wheels, {theory}"] = [
            least(20, table.forces, y, 2.4e-3 * y, velocity, theory) for y in np.linspace(-4.0, 4.0, 41)
        ]
    print("processor milliseconds: median, largest")
    for name, found in shown.items():
        print(f"{name:36} {1e3 * np.median(found):8.2f} {1e3 * max(found):8.2f}")


PARTS = {"contact": against_contact, "fast": fast_against_contact, "noise": noise, "seconds": seconds}

if __name__ == "__main__":
    print(platform.platform(), platform.python_version())
    warnings.simplefilter("ignore")
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
