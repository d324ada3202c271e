"""Other programs and theories: peers in normal contact, CONTACT on wheels and rails, errors of the
fast theories.
"""

import importlib.util
import time
import warnings
from collections.abc import Callable
from importlib.metadata import version
from itertools import product

import numpy as np

import varcontact as vc
from tests.benchmarks.table import Table
from tests.wheel_rail.conditions import RAIL, TRACK, WHEELSET, benchmark, manchester, wheel
from varcontact.errors import SceneError
from varcontact.kinematics import rotation
from varcontact.scene.motion import Steady
from varcontact.scene.surfaces import Ellipse
from varcontact.theories.creep_forces import VECTORISED
from varcontact.theories.table import why_not_in_book
from varcontact.wheel_rail import Profile, Track, WheelSet
from varcontact.wheel_rail.virtual_penetration import NORMAL

NOISE, SEEDS, LENGTHS = 0.002, (3, 4), (0.0, 2.0, 5.0, 10.0, 20.0)
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


def _solved(gap: np.ndarray, normal: str, **load: float) -> vc.Solution:
    cells = len(gap)
    grid = vc.Grid(nx=cells, ny=cells, dx=SIDE / cells, dy=SIDE / cells, x0=-SIDE / 2, y0=-SIDE / 2)
    bodies, surface = vc.Bodies(G=G, nu=NU), vc.SampledDistance(gap)
    return vc.solve(
        vc.Scene(bodies=bodies, surface=surface, grid=grid, **load), normal=normal, tol=TOL
    )


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
    system = make_system(
        interaction="hardwall", substrate=substrate, surface=Topography(-gap.T, (SIDE, SIDE))
    )
    system.minimize_proxy(external_force=force, pentol=TOL * force / (SIDE / cells), maxiter=5000)
    return np.array(system.force)[:cells, :cells].T / (SIDE / cells) ** 2


PROGRAMS: dict[str, tuple[str, Callable[[np.ndarray, float], np.ndarray]]] = {
    "varcontact, `newton`": ("varcontact", ours),
    "Tamaas": ("tamaas", tamaas),
    "ContactMechanics": ("ContactMechanics", contact_mechanics),
}


def normal_peers(quick: bool) -> Table:
    """Seconds of normal contact by programs with the same influence numbers, and differences from
    our pressure.
    """
    there = [name for name, (package, _) in PROGRAMS.items() if importlib.util.find_spec(package)]
    rows = []
    for rough, count in ((False, 64),) if quick else ((False, 256), (True, 64), (True, 256)):
        gap = distance(count, rough)
        reference = _solved(gap, "newton", approach=0.8)
        row: list[object] = [
            f"{'rough' if rough else 'sphere'}, {count}",
            f"{reference.elements['contact']}",
        ]
        for name in there:
            seconds = []
            for _ in range(3):
                begun = time.perf_counter()
                pressure = PROGRAMS[name][1](gap, reference.normal_force)
                seconds.append(time.perf_counter() - begun)
            apart = np.abs(pressure - reference.pressure).max() / reference.pressure.max()
            row.append([min(seconds), float(apart)])
        rows.append(row)
    versions = {PROGRAMS[name][0]: version(PROGRAMS[name][0]) for name in there}
    formats = ["", "", *(len(there) * ["{:.3f} ({:.0e})"])]
    return Table(["surface, cells", "elements in contact", *there], formats, rows, versions)


def differences(row: dict) -> list[float]:
    """Location [mm], angle [mrad], creepages, normal force, tangential forces by f Fn and peak
    pressure [%].
    """
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


def contact(quick: bool) -> Table:
    """Largest differences from CONTACT on the wheels of the Manchester benchmark."""
    found = np.max([differences(row) for row in manchester()[:: 20 if quick else 1]], axis=0)
    head = [
        "location [mm]",
        "angle [mrad]",
        "creepages [%]",
        "normal force [%]",
        "tangential forces [% of f Fn]",
    ]
    return Table([*head, "peak pressure [%]"], 6 * [".2g"], [found.tolist()])


def fast_differences(row: dict, normal: str, theory: str, options: dict) -> list[float]:
    """Tangential forces by f Fn, normal force and peak pressure [%], location [mm]; one wheel has
    two ellipses.
    """
    found = benchmark(row).estimate(normal, theory, **options)
    each = max(found.patches, key=lambda patch: patch.force[2])
    force = rotation(roll=row["angle"]).T @ found.force if len(found.patches) > 1 else each.force
    return [
        100 * float(np.hypot(*(force[:2] - [row["fx"], row["fs"]]))) / (0.3 * row["fn"]),
        100 * abs(force[2] / row["fn"] - 1),
        100 * abs(each.ellipse.peak_pressure / row["pmax"] - 1),
        float(np.abs(each.frame.origin - [row["x"], row["y"], row["z"]]).max()),
    ]


def fast(quick: bool) -> Table:
    """Median and largest distance of the fast ways from CONTACT."""
    rows = []
    for normal in NORMAL:
        for theory in ("fastsim", "fastrip", "table"):
            options = {"outside": "clamp"} if theory == "table" else {}
            chosen = manchester()[:: 20 if quick else 1]
            found = np.array([fast_differences(row, normal, theory, options) for row in chosen])
            rows.append(
                [
                    f"{normal}, {theory}",
                    *zip(np.median(found, axis=0), found.max(axis=0), strict=True),
                ]
            )
    head = [
        "tangential forces [% of f Fn]",
        "normal force [%]",
        "peak pressure [%]",
        "location [mm]",
    ]
    return Table(["way", *head], ["", *(4 * ["{:.2g}, {:.2g}"])], rows)


def fast_exact(quick: bool) -> Table:
    """Forces of the fast ways on a wheel with 80 kN less the exact ones: 201 positions of three
    pairs of profiles.
    """
    inclined = [Track(rail=Profile.rail_60e1(), cant=1 / each) for each in (40, 20)]
    new = WheelSet(wheel=Profile.s1002())
    pairs = [(inclined[0], new), (inclined[1], new), (TRACK, WHEELSET)]
    found: dict[str, list[tuple[float, float]]] = {}
    for (track, wheelset), y in product(pairs, np.linspace(-8.0, 8.0, 5 if quick else 67).tolist()):
        case = wheel(y, yaw=5e-4 * y, track=track, wheelset=wheelset, dx=1.0, dy=0.5)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            exact = case.solve().force
            for normal, theory in product(NORMAL, ("fastsim", "fastrip", "table")):
                options = {"outside": "clamp"} if theory == "table" else {}
                try:
                    off = case.estimate(normal, theory, **options).force - exact
                except SceneError:  # a profile without curvature, or beyond its end
                    continue
                found.setdefault(f"{normal}, {theory}", []).append(tuple(np.abs(off[:2]) / 800))
    rows = [
        [way, *map(tuple, np.percentile(np.array(each), [50, 95], axis=0).T)]
        for way, each in found.items()
    ]
    return Table(["way", "Fx [% of Q]", "Fy [% of Q]"], ["", *(2 * ["{:.2g}, {:.2g}"])], rows)


def peak(rail: Profile, y: float, load: float) -> float:
    """Peak pressure of the right wheel on a rail."""
    case = wheel(
        y, track=Track(rail=rail), vertical_force=load, dx=0.5, dy=0.2, join=1e3, separate=1e3
    )
    return case.solve().patches[0].peak_pressure


def noise(quick: bool) -> Table:
    """Peak pressures on a rail with noise by that of the rail without, least and greatest, by
    smoothing.
    """
    rows = []
    for load in (10e3,) if quick else (10e3, 80e3):
        row: list[object] = [f"{load / 1e3:g} kN"]
        for length in LENGTHS:
            found = []
            for y in (0.0, 2.0, 4.0):
                true = peak(RAIL, y, load)
                for seed in SEEDS:
                    z = RAIL.z + NOISE * np.random.default_rng(seed).normal(size=RAIL.z.size)
                    found.append(
                        peak(Profile(y=RAIL.y, z=z, kind="rail", smoothing=length), y, load) / true
                    )
            row.append([min(found), max(found)])
        rows.append(row)
    return Table(
        ["smoothing [mm]", *(f"{length:g}" for length in LENGTHS)],
        ["", *(5 * ["{:.2f} to {:.2f}"])],
        rows,
    )


def theory_errors() -> dict[str, np.ndarray]:
    """By theory, rows of the largest error of Fx and Fy by f Fz, and that of Mz by f Fz
    (ab)^(1/2).
    """
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in VECTORISED}
    for reference in vc.continuum_values().values():
        scene = reference.scene
        motion, surface = scene.motion, scene.surface
        if not (
            isinstance(motion, Steady) and isinstance(surface, Ellipse) and scene.bodies.K == 0
        ):
            continue
        if motion.Fx is not None or motion.Fy is not None or not isinstance(scene.friction, float):
            continue
        limit = scene.friction * scene.normal_force
        for name in VECTORISED:
            if name == "vermeulen-johnson" and motion.spin != 0:
                continue
            if name == "table" and why_not_in_book(surface.a / surface.b, scene.bodies.combined_nu):
                continue
            forces = vc.creep_forces(
                name, a=surface.a, b=surface.b, bodies=scene.bodies, normal_force=scene.normal_force,
                friction=scene.friction, vx=motion.vx, vy=motion.vy, spin=motion.spin,
            )  # fmt: skip
            exact = reference.values
            away = max(abs(forces.Fx - exact["Fx"]), abs(forces.Fy - exact["Fy"])) / limit
            found[name].append(
                (away, abs(forces.Mz - exact["Mz"]) / limit / (surface.a * surface.b) ** 0.5)
            )
    return {name: np.array(rows) for name, rows in found.items()}


def theories(quick: bool) -> Table:
    """Errors of the fast theories over the steady reference scenes of like bodies on an ellipse, in
    per cent.
    """
    rows = []
    for name, found in theory_errors().items():
        force, moment = 100 * found.T
        figures = [
            np.median(force),
            np.quantile(force, 0.9),
            force.max(),
            np.median(moment),
            moment.max(),
        ]
        rows.append([f"`{name}`", f"{len(found)}", *map(float, figures)])
    head = ["theory", "scenes", "force, median", "90 %", "largest", "moment, median", "largest"]
    return Table(head, ["", "", *(5 * [".1f"])], rows)


TABLES = {
    "normal_peers": normal_peers,
    "contact": contact,
    "fast": fast,
    "fast_exact": fast_exact,
    "noise": noise,
    "theories": theories,
}
