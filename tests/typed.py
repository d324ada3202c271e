"""What type checkers know of the public functions: mypy reads it with the package, the tests run
it.
"""

from typing import assert_type

import numpy as np

import varcontact as vc

BODIES, SURFACE = vc.Bodies(G=1.0, nu=0.3), vc.Paraboloids(Rx=1.0, Ry=1.0)
GRID = vc.Grid(6, 6)


def solutions() -> list[vc.Solution]:
    """Steady rolling, shifts and normal contact give solutions."""
    rolls = vc.Scene(
        bodies=BODIES,
        surface=SURFACE,
        normal_force=1e-3,
        friction=0.3,
        motion=vc.Steady(vx=1e-3),
        grid=GRID,
    )
    shifts = vc.Scene(
        bodies=BODIES,
        surface=SURFACE,
        normal_force=1e-3,
        friction=0.3,
        motion=vc.Shift(ux=1e-4),
        grid=GRID,
    )
    presses = vc.Scene(bodies=BODIES, surface=SURFACE, normal_force=1e-3, grid=GRID)
    assert_type(vc.solve(rolls), vc.Solution)
    assert_type(vc.solve(shifts), vc.Solution)
    assert_type(vc.solve(presses), vc.Solution)
    return [vc.solve(rolls), vc.solve(shifts, certify="gap"), vc.solve(presses, normal="norm")]


def history() -> vc.History:
    """Steps give a history."""
    steps = vc.Transient(steps=2, dq=0.01, vx=1e-3)
    scene = vc.Scene(
        bodies=BODIES, surface=SURFACE, normal_force=1e-3, friction=0.3, motion=steps, grid=GRID
    )
    return assert_type(vc.solve(scene), vc.History)


def misspelt(scene: vc.Scene, sol: vc.Solution) -> None:
    """Never called: where a misspelt name were no error, mypy would call its comment unused."""
    vc.sweep(scene, method="convx")  # type: ignore[arg-type]
    vc.scan(scene, np.zeros((1, 3)), certify="ful")  # type: ignore[arg-type]
    vc.solve_many([scene], failures="kep")  # type: ignore[arg-type]
    vc.Grid(nx=6, ny=6, edge="centers")  # type: ignore[arg-type]
    vc.solve(scene, method="convx")  # type: ignore[call-overload]
    vc.creep_forces("fastsm", a=1.0, b=1.0, normal_force=1.0, friction=0.3)  # type: ignore[arg-type]
    vc.stress_below(sol, depths=[1.0], body="uper")  # type: ignore[arg-type]
    sol.plot("presure")  # type: ignore[arg-type]
