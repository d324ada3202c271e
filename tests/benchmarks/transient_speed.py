"""What a step of rolling in time costs: run by hand, ``python tests/benchmarks/transient_speed.py``.

Processor seconds of the median and of the slowest step after the first.
"""

import dataclasses
import time

import numpy as np

import varcontact as vc


def seconds(scene: vc.Scene, tangential: str) -> np.ndarray:
    """Processor seconds of each step after the first."""
    told: list[float] = []
    vc.solve(scene, tangential=tangential, progress=lambda word: told.append(time.process_time()))
    return np.diff([*told, time.process_time()])[1:]


def main() -> None:
    """Print the table."""
    circle = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Transient(steps=25, vx=0.03, vy=0.02, spin=0.1),
        grid=vc.Grid(nx=20, ny=20),
    )
    line = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3),
        surface=vc.Cylinders(R=100.0),
        normal_force=1.0,
        friction=0.3,
        motion=vc.Transient(steps=1000, dq=0.2, Fx=-0.2 * np.sin(np.arange(1000) / 80)),
        grid=vc.Grid(nx=100),
    )
    cases = [("circle, 316 elements", circle, ("clarabel", "tang", "tang-safeguarded"))]
    law = dataclasses.replace(circle, friction=vc.ExponentialFalling(0.3, 0.2, half_velocity=0.1))
    cases.append(("circle under a law", law, ("tang-safeguarded",)))
    unlike = dataclasses.replace(circle, bodies=vc.Bodies(G=(1.0, 0.5), nu=(0.28, 0.2)))
    cases.append(("circle, unlike bodies", unlike, ("tang-safeguarded",)))
    cases.append(("line, 100 elements", line, ("clarabel", "tang", "tang-safeguarded")))
    for name, scene, methods in cases:
        for method in methods:
            steps = seconds(scene, method)
            print(f"{name:22} {method:18} median {np.median(steps):.3f} s, slowest {steps.max():.3f} s, ", end="")
            print(f"all {len(steps)}: {steps.sum():.1f} s")


if __name__ == "__main__":
    main()
