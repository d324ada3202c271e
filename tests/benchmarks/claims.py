"""Claims of Kalker's paper, set beside what this package measures."""

from dataclasses import replace
from functools import partial
from importlib.resources import files

import numpy as np

import varcontact as vc
from tests.benchmarks.interop import theory_errors
from tests.benchmarks.table import Table, least
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.residuals import normal_residual
from varcontact.solvers.active_set.norm import norm
from varcontact.theories import TableBook, fastsim_under_law

CONTACT = {"a": 6e-3, "b": 4e-3, "G": 82e9, "nu": 0.28, "normal_force": 1e5, "friction": 0.3}
CREEPAGE = {"vx": 1e-3, "vy": 2e-4, "spin": 0.1}
TRIPLES = 100_000
KINETIC, STATIC = 0.3, (0.36, 0.45)
"""Coefficients of friction; the static ones are 1.2 and 1.5 times the kinetic one."""
ROUGH, QUICK_ROUGH = 1000, 30
"""Random surfaces for NORM."""


def ball(cells: int, friction: object = KINETIC, **motion: float) -> vc.Scene:
    """A circle of radius 1 with G = Fz = 1 in steady rolling."""
    return vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.28),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        friction=friction,
        motion=vc.Steady(**motion),
        grid=vc.Grid(nx=cells, ny=cells),
    )


def seconds_per_triple(theory: str, quick: bool) -> tuple[float, float]:
    """Processor seconds of a single call, and of each triple in a call of many."""
    one = partial(vc.creep_forces, theory, **CONTACT, **CREEPAGE)
    spread = np.random.default_rng(0).normal(size=(TRIPLES, 1))
    triples = dict(zip(CREEPAGE, (spread * list(CREEPAGE.values())).T, strict=True))
    many = partial(vc.creep_forces, theory, **CONTACT, **triples)
    single = least(lambda: [one() for _ in range(50)]) / 50
    return single, least(many, 1 if quick else 5) / TRIPLES


def exact_against_fastsim(quick: bool) -> str:
    """Times of one contact by CONTACT's own method and by the default, over that of FASTSIM."""
    single, many = seconds_per_triple("fastsim", quick)
    scene = ball(12 if quick else 20, vx=0.03, vy=0.01, spin=0.1)
    printed = least(partial(vc.solve, scene, method="kalker", certify="none"))
    default = least(partial(vc.solve, scene, certify="none"))
    elements = vc.solve(scene, certify="none").elements["contact"]
    return (
        f"{elements} elements: {printed / single:.0f} times by TANG as printed, "
        f"{default / single:.0f} times by default; over FASTSIM in a call of many "
        f"{printed / many:.0f} and {default / many:.0f} times"
    )


def book_against_fastsim(quick: bool) -> str:
    """Times of FASTSIM over those of the table book, and the size of the book."""
    times = np.divide(seconds_per_triple("fastsim", quick), seconds_per_triple("table", quick))
    path = files("varcontact.theories").joinpath("table_book.nc")
    size = len(path.read_bytes()) / 1e6
    return (
        f"{times[0]:.0f} times as fast in single calls, {times[1]:.1f} times in a call of many; "
        f"{book_entries()} entries, {size:.1f} MB"
    )


def book_entries() -> int:
    """Solutions in the table book of the package."""
    path = files("varcontact.theories").joinpath("table_book.nc")
    return int(np.prod(TableBook.read(str(path)).values.shape[:-1]))


def two_coefficients(cells: int, points: int) -> dict[str, list[float]]:
    """Largest differences of the force from that of the kinetic coefficient alone, in f_kin Fz, by
    theory, for each static coefficient; from stick.
    """
    creepages = np.linspace(0.0, 0.3, points + 1)[1:]
    strips = {"m": 2 * cells, "n": 2 * cells}
    table = vc.no_slip_coefficients(1.0, 0.28)
    contact = (1.0, 1.0, 1.0, 1.0)
    found: dict[str, list[float]] = {"FASTSIM": [], "exact theory": []}
    for static in STATIC:
        law = vc.StaticKinetic(static, KINETIC)
        alone = vc.StaticKinetic(KINETIC, KINETIC)
        simple, exact = [], []
        for vx in creepages:
            by_law = [
                fastsim_under_law(*contact, each, (vx, 0.0, 0.0), table, **strips).force[0]
                for each in (law, alone)
            ]
            simple.append(abs(by_law[0] - by_law[1]))
            solved = [
                vc.solve(ball(cells, friction, vx=vx), certify="none").force[0]
                for friction in (law, KINETIC)
            ]
            exact.append(abs(solved[0] - solved[1]))
        found["FASTSIM"].append(max(simple) / KINETIC)
        found["exact theory"].append(max(exact) / KINETIC)
    return found


def effect_of_two_coefficients(quick: bool) -> str:
    found = two_coefficients(8, 3) if quick else two_coefficients(24, 12)
    ratios = " and ".join(f"{static / KINETIC:.1f}" for static in STATIC)
    parts = [
        f"{name} {100 * low:.1f} and {100 * high:.1f} %" for name, (low, high) in found.items()
    ]
    return f"static {ratios} times the kinetic one: {', '.join(parts)} of $f_{{kin}} F_z$ at most"


def energies(quick: bool) -> str:
    """Seconds of both programs by one solver, potential over complementary."""
    scene = ball(8 if quick else 16)
    shift = replace(scene, motion=vc.Shift(ux=0.1, uy=0.05))
    pressed = replace(scene, motion=None, friction=None)
    ratios = []
    for each, solver in ((pressed, "normal"), (shift, "tangential")):
        options = {solver: "clarabel", "polish": False, "certify": "none"}
        times = [
            least(partial(vc.solve, each, formulation=formulation, **options), 2)
            for formulation in ("potential", "complementary")
        ]
        ratios.append(times[0] / times[1])
    return (
        f"the same solutions; by interior points the potential energy takes {ratios[0]:.1f} times as "
        f"long for pressures, {ratios[1]:.1f} times for tractions"
    )


def norm_failures(count: int) -> tuple[int, int]:
    """Failures of NORM with whole sets of elements on random surfaces, and most exchanges."""
    scene = replace(ball(12), motion=None, friction=None)
    grid = vc.Grid(nx=12, ny=12).spread((-1.2, 1.2, -1.2, 1.2))
    posed = discretise(scene, grid).normal_problem(None)
    rng = np.random.default_rng(0)
    failures, most = 0, 0
    for _ in range(count):
        distance = rng.random(posed.distance.size)
        force = float(10 ** rng.uniform(-3, 1))
        problem = replace(posed, distance=distance, force=force)
        raw = norm(problem)
        residual = normal_residual(problem, raw.traction, raw.rigid)
        failures += not (raw.solved and residual < 1e-9)
        most = max(most, raw.iterations)
    return failures, most


def norm_by_sets(quick: bool) -> str:
    count = QUICK_ROUGH if quick else ROUGH
    failures, most = norm_failures(count)
    return f"{failures} failures on {count} random surfaces, {most} exchanges at most"


def errors_of_fastsim(quick: bool) -> str:
    """Largest and median errors of the force under both bounds, and with the single flexibility."""
    found = theory_errors()
    parts = []
    for name in ("fastsim", "fastsim-elliptic", "fastsim-weighted"):
        force = 100 * found[name][:, 0]
        parts.append(f"`{name}` {np.median(force):.1f} and {force.max():.1f} %")
    return f"median and largest over {len(force)} scenes: {', '.join(parts)} of $f F_z$"


def paper(quick: bool) -> Table:
    """Claims of the paper, with what is measured here."""
    claims = (
        ("6.3.3", "CONTACT is about 2000 times as slow as FASTSIM", exact_against_fastsim),
        (
            "6.3.3",
            "the table book is about 8 times as fast as FASTSIM; 115 000 entries, 4.5 MByte",
            book_against_fastsim,
        ),
        (
            "7.8",
            "two coefficients of friction: the effect on the total force appears to be small",
            effect_of_two_coefficients,
        ),
        ("4.8", "complementary energy is to be preferred to potential energy", energies),
        ("5.2", "NORM with all elements at once: never a failure", norm_by_sets),
        (
            "3.2.7, 3.2.8",
            "FASTSIM is within 10 to 15 % of $f F_z$; Hertz's bound gives bad results",
            errors_of_fastsim,
        ),
    )
    rows = [(section, claim, measure(quick)) for section, claim, measure in claims]
    return Table(("section", "the paper", "here"), ("", "", ""), rows)


def in_time(cells: int, motion: vc.Transient | vc.Shift) -> list[vc.Solution | vc.History]:
    """A motion on a circle by FASTSIM and by the exact theory."""
    scene = ball(cells)
    hertz = vc.reference.hertz_ellipse(1.0, 1.0, scene.bodies, force=1.0)
    dx = 2 / cells
    grid = vc.Grid(nx=cells, ny=cells, dx=dx, dy=dx, x0=-1.0, y0=-1.0)
    surface = vc.Paraboloids(hertz.Rx, hertz.Ry)
    held = replace(scene, surface=surface, grid=grid, motion=motion)
    return [vc.solve(held, tangential=name, certify="none") for name in ("fastsim", "auto")]


def largest_difference(cells: int, steps: int, **creepages: object) -> list[float]:
    """Largest and last difference of the force in a history, in f Fz."""
    motion = vc.Transient(steps=steps, dq=2 / cells, **creepages)
    fastsim, exact = in_time(cells, motion)
    away = np.hypot(*(fastsim.force - exact.force).T) / KINETIC
    return [100 * float(away.max()), 100 * float(away[-1])]


def fastsim_in_time(quick: bool) -> Table:
    """Differences of FASTSIM's forces from the exact ones in time, and of shifts by a force."""
    cells = 8 if quick else 20
    rows: list[tuple[str, object]] = []
    for words, rigid in (
        ("rolling begins, vx = 0.05", {"vx": 0.05}),
        ("rolling begins, vx = 0.02, spin = 0.1", {"vx": 0.02, "spin": 0.1}),
    ):
        away = largest_difference(cells, 2 * cells, **rigid)
        rows.append((words, f"{away[0]:.0f} % of $f F_z$, at the end {away[1]:.1f} %"))
    middles = (np.arange(4 * cells) + 0.5) * 2 / cells
    for length in (1.0, 2.0, 4.0, 8.0):
        vx = 0.05 * np.sin(2 * np.pi * middles / length)
        away = largest_difference(cells, middles.size, vx=vx.tolist())
        rows.append((f"vx = 0.05 sin, wavelength {length:.0f} a", f"{away[0]:.0f} % of $f F_z$"))
    for part in (0.3, 0.9):
        fastsim, exact = in_time(cells, vc.Shift(Fx=-part * KINETIC))
        ratio = fastsim.creepage[0] / exact.creepage[0]
        rows.append((f"shift by {part} $f F_z$", f"{ratio:.2f} of the exact shift"))
    return Table(("circle, $\\nu$ = 0.28, f = 0.3", "FASTSIM"), ("", ""), rows)


TABLES = {"paper": paper, "fastsim_in_time": fastsim_in_time}
