"""Whether a sweep over MPI gives the store of the serial one, byte for byte.

With one process that asks and two that solve (``pip install mpi4py mpich``)::

    mpiexec -n 3 python -m mpi4py.futures -m tests.benchmarks.sweep_mpi

The exit code is 1 if the bytes differ. mpi4py needs an MPI library, so this is no test of the suite.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import varcontact as vc

SCENE = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28),
    surface=vc.Ellipse(a=1.2, b=0.9),
    normal_force=1.0,
    friction=0.3,
    motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05),
    grid=vc.Grid(nx=6, ny=6),
)
OVER = {"friction": [0.2, 0.3], "motion.vx": [0.0, 0.02, 0.05, 0.1, 0.3]}


def main() -> int:
    """Sweep over MPI and here, and compare."""
    from mpi4py.futures import MPIPoolExecutor

    with tempfile.TemporaryDirectory() as folder:
        spread, alone = Path(folder) / "mpi.nc", Path(folder) / "alone.nc"
        with MPIPoolExecutor() as pool:
            vc.sweep(SCENE, OVER, chunk=2, executor=pool, store=spread)
        vc.sweep(SCENE, OVER, chunk=2, store=alone)
        same = spread.read_bytes() == alone.read_bytes()
    print("the same bytes" if same else "other bytes")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
