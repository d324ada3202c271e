"""Normal contact beside other programs, on the same grids: seconds, and how far the pressures are from ours.

    pip install tamaas ContactMechanics
    OMP_NUM_THREADS=1 python tests/benchmarks/normal_peers.py [CELLS ...]

A sphere and a rough one (a random surface with a self-affine spectrum), not periodic, rectangular elements of uniform
pressure in all programs: influence numbers after Love (1929). The force is prescribed. Tamaas and ContactMechanics run
their conjugate gradients (Polonsky and Keer, 1999) to the accuracy that is named below. Wall-clock seconds with set-up,
least and most of three. A program that is not installed is reported as missing.
"""

import importlib.util
import platform
import sys
import time
from collections.abc import Callable
from importlib.metadata import version

import numpy as np

import varcontact as vc

CELLS = (64, 128, 256)
SIDE = 2.0
G, NU = 1.0, 0.28
E_STAR = G / (1 - NU)
TOL = 1e-8


def distance(cells: int, rough: bool) -> np.ndarray:
    """Heights of the gap without load at the centres of the elements."""
    x = (np.arange(cells) - (cells - 1) / 2) * SIDE / cells
    gap = x**2 + x[:, None] ** 2
    return gap + 0.05 * _roughness(cells) if rough else gap


def _roughness(cells: int, hurst: float = 0.8) -> np.ndarray:
    """A random surface of unit variance, without waves shorter than four elements of 64 across."""
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(cells, 1 / cells), np.fft.fftfreq(cells, 1 / cells)))
    wanted = (q >= 4) & (q <= 16)
    rng, spectrum = np.random.default_rng(1), np.zeros((cells, cells), complex)
    for row, column in sorted(map(tuple, np.argwhere(wanted)), key=lambda at: _wave(at, cells)):
        spectrum[row, column] = q[row, column] ** (-1 - hurst) * np.exp(2j * np.pi * rng.random())
    field = np.fft.ifft2(spectrum).real
    return np.asarray(field / field.std())


def _wave(at: tuple[int, int], cells: int) -> tuple[int, int]:
    """The wave of an entry of the spectrum, the same on all grids."""
    row, column = ((index + cells // 2) % cells - cells // 2 for index in at)
    return row, column


def ours(gap: np.ndarray, force: float) -> np.ndarray:
    """Newton's method without a matrix."""
    return _solved(gap, "newton", normal_force=force).pressure


def active_sets(gap: np.ndarray, force: float) -> np.ndarray:
    """NORM."""
    return _solved(gap, "norm", normal_force=force).pressure


def _solved(gap: np.ndarray, normal: str, **load: float) -> vc.Solution:
    cells = len(gap)
    grid = vc.Grid(nx=cells, ny=cells, dx=SIDE / cells, dy=SIDE / cells, x0=-SIDE / 2, y0=-SIDE / 2)
    bodies, surface = vc.Bodies(G=G, nu=NU), vc.SampledDistance(gap)
    return vc.solve(vc.Scene(bodies=bodies, surface=surface, grid=grid, **load), normal=normal, tol=TOL)


def tamaas(gap: np.ndarray, force: float) -> np.ndarray:
    """Polonsky and Keer's conjugate gradients with Tamaas's operator for a free surface."""
    import tamaas as tm

    tm.set_log_level(tm.LogLevel.error)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [SIDE, SIDE], list(gap.shape))
    model.E, model.nu = E_STAR * (1 - NU**2), NU
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tm.PolonskyKeerRey(model, -gap, TOL)
    solver.setIntegralOperator("dcfft")
    solver.max_iter = 5000
    solver.solve(force / SIDE**2)
    return np.array(model.traction)


def contact_mechanics(gap: np.ndarray, force: float) -> np.ndarray:
    """Polonsky and Keer's conjugate gradients of ContactMechanics."""
    from ContactMechanics import FreeFFTElasticHalfSpace, make_system
    from SurfaceTopography import Topography

    cells = len(gap)
    substrate = FreeFFTElasticHalfSpace(gap.shape, E_STAR, (SIDE, SIDE))
    system = make_system(interaction="hardwall", substrate=substrate, surface=Topography(-gap.T, (SIDE, SIDE)))
    system.minimize_proxy(external_force=force, pentol=TOL * force / (SIDE / cells), maxiter=5000)
    return np.array(system.force)[:cells, :cells].T / (SIDE / cells) ** 2


PROGRAMS: dict[str, tuple[str, Callable[[np.ndarray, float], np.ndarray], int]] = {
    "varcontact, newton": ("varcontact", ours, 512),
    "varcontact, norm": ("varcontact", active_sets, 64),
    "Tamaas": ("tamaas", tamaas, 512),
    "ContactMechanics": ("ContactMechanics", contact_mechanics, 512),
}


def timed(program: Callable[[np.ndarray, float], np.ndarray], gap: np.ndarray, force: float) -> tuple[str, np.ndarray]:
    """Least and most seconds, and the pressure."""
    taken = []
    for _ in range(3):
        begun = time.perf_counter()
        pressure = program(gap, force)
        taken.append(time.perf_counter() - begun)
    return f"{min(taken):.3f} to {max(taken):.3f}", pressure


def main(*cells: int) -> None:
    """Print the table, and the machine."""
    there = {name: importlib.util.find_spec(package) for name, (package, _, _) in PROGRAMS.items()}
    versions = [f"{package} {version(package)}" for name, (package, _, _) in PROGRAMS.items() if there[name]]
    print(f"{platform.machine()}, Python {platform.python_version()}, {', '.join(dict.fromkeys(versions))}")
    print("\n".join(f"{name} is not installed" for name in PROGRAMS if not there[name]), end="")
    print("| surface | cells | elements in contact | program | seconds | largest difference of pressure |")
    print("|---|---|---|---|---|---|")
    for rough in (False, True):
        for count in cells:
            gap = distance(count, rough)
            reference = _solved(gap, "newton", approach=0.8)
            for name, (_, program, most) in PROGRAMS.items():
                if not there[name] or count > most:
                    continue
                seconds, pressure = timed(program, gap, reference.normal_force)
                apart = np.abs(pressure - reference.pressure).max() / reference.pressure.max()
                surface, contact = "rough" if rough else "sphere", reference.elements["contact"]
                print(f"| {surface} | {count} | {contact} | {name} | {seconds} | {apart:.0e} |", flush=True)


if __name__ == "__main__":
    main(*(tuple(int(argument) for argument in sys.argv[1:]) or CELLS))
