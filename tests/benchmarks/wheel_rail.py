"""Wheels on rails: against CONTACT on the Manchester benchmark, what noise does to the pressure, and the time it takes.

python -m tests.benchmarks.wheel_rail
"""

import platform
import time
import warnings

import numpy as np

from tests.wheel_rail.conditions import RAIL, WHEELSET, benchmark, manchester
from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail

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


def seconds() -> None:
    """Of the geometry of a position, and of the whole with the load given, with elements of 0.5 mm."""
    geometry, whole = [], []
    for row in manchester():
        for _ in range(REPEATS):
            case = benchmark(row, dx=0.5, dy=0.5)
            assert case.rail.s.size
            assert case.wheel.s.size
            start = time.process_time()
            case.patches(row["z_ws"])
            middle = time.process_time()
            case.solve()
            geometry.append(middle - start)
            whole.append(time.process_time() - middle)
    print(
        f"geometry {1e3 * np.median(geometry):.1f} ms (up to {1e3 * max(geometry):.1f}), "
        f"whole {np.median(whole):.3f} s (up to {max(whole):.3f})"
    )


if __name__ == "__main__":
    print(platform.platform(), platform.python_version())
    warnings.simplefilter("ignore")
    against_contact()
    noise()
    seconds()
