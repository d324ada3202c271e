"""Shakedown limits: closed forms, point contacts, patches of wheels, bounds of random contacts, and
an elastic-plastic march.
"""

import json
import time
import warnings

import numpy as np

import varcontact as vc
from tests.benchmarks.table import RESULTS, Table
from tests.plasticity.fields import ellipse, line, mcewen
from tests.plasticity.march import marched
from varcontact.wheel_rail import Position, Profile, Track, WheelOnRail, WheelSet, johnson_diagram

FRICTIONS = (0.0, 0.1, 0.2, 0.3, 0.3672, 0.4, 0.5)
"""Of line contacts; at 0.3672 both branches meet in an incompressible body."""
HERTZ = {
    (1, 1): (0.0, 0.1, 0.2, 0.3, 0.5),
    (1, 2): (0.0, 0.2, 0.4),
    (2, 1): (0.0, 0.4),
    (1, 5): (0.0, 0.4),
}
"""Half-axes, and frictions in full slip."""
PARTIAL = {
    "half of full slip, f = 0.4": {"Fx": 0.5 * 0.4 * 2 * np.pi / 3},
    "0.9 of full slip, f = 0.4": {"Fx": 0.9 * 0.4 * 2 * np.pi / 3},
    "spin, f = 0.4": {"spin": 2.0},
}
CASES = RESULTS / "shakedown_cases.json"
RANDOM, PROGRAMS = 200, 20
QUICK_RANDOM, QUICK_PROGRAMS = 5, 1
ROUNDING = 1e-6
"""Relative difference of bounds that is none."""
RAIL_GAP = 0.05
"""Gap that is asked for of patches of wheels."""
K = 300.0
"""Yield stress in shear of the rail [N/mm^2]."""


def line_limits(quick: bool) -> Table:
    """Line contacts in full slip: bounds on p0/k, 1/f, kinematic hardening, and half of nu."""
    rows = []
    for f in FRICTIONS:
        cells = [f]
        for nu in (0.3, 0.5):
            k = 0.5 / (1 - nu)
            limit = vc.shakedown(line(f, nu, n=20), k, elastic=mcewen(f, nu))
            cells += [[limit.lower, limit.upper]]
            if nu == 0.3:
                cells += [limit.depth, list(limit.kinematic)]
        grid = vc.shakedown(line(f, 0.3, n=200), 0.5 / 0.7)
        cells += [[grid.lower, grid.upper], 1 / f if f else None]
        rows.append(cells)
    head = (
        "f", "nu = 0.3", "depth / a", "kinematic", "nu = 0.5", "by 200 strips, nu = 0.3", "1/f",
    )  # fmt: skip
    pair = "{:.4f} - {:.4f}"
    return Table(head, ("g", pair, ".3f", "{:.3f} - {:.3f}", pair, pair, ".3f"), rows)


def _row(name: str, solution: object, k: float, **options: object) -> list[object]:
    start = time.process_time()
    limit = vc.shakedown(solution, k, **options)
    seconds = time.process_time() - start
    pressure = limit.peak_pressure / limit.strength
    bounds = [factor * pressure for factor in (limit.lower, limit.sampled, limit.upper)]
    kinematic = [factor * pressure for factor in limit.kinematic]
    print(name, np.round(bounds, 3), f"{100 * limit.gap:.1f} %, {seconds:.0f} s", flush=True)
    return [
        name, limit.local, bounds, 100 * limit.gap, 100 * limit.field_error, kinematic, limit.mode,
        limit.depth, seconds,
    ]  # fmt: skip


HEAD = (
    "contact", "max abs(q) / p", "p/k: lower (at samples) to upper", "gap [%]",
    "field [%]", "kinematic", "mode", "depth", "time [s]",
)  # fmt: skip
FORMATS = (
    "", ".3f", "{:.3f} ({:.3f}) - {:.3f}", ".1f", ".1f", "{:.3f} - {:.3f}", "", ".2f", ".0f",
)  # fmt: skip


def point_limits(quick: bool) -> Table:
    """Circles and ellipses in full and partial slip: bounds, with the grid chosen by itself."""
    rows = []
    for (a, b), frictions in HERTZ.items():
        for f in frictions[: 1 if quick else None]:
            solution = ellipse(a, b, f, n=24)
            rows.append(_row(f"{a} x {b}, f = {f}", solution, 1.0))
    for name, motion in PARTIAL.items() if not quick else ():
        rows.append(_row(name, ellipse(f=0.4, n=24, **motion), 1.0))
    return Table(HEAD, FORMATS, rows)


def hollow() -> Profile:
    """S1002 with a tread hollow by 1.5 mm."""
    new = Profile.s1002()
    depth = 1.5 * np.exp(-(((new.y - 2) / 18) ** 2)) * (new.y > -30)
    return Profile(y=new.y, z=new.z - depth, kind="wheel")


def rail_limits(quick: bool) -> Table:
    """Six patches of a new and a hollow wheel on a rail, beside Johnson's diagram."""
    rows = []
    places = ((0.0, 0.0), (3.0, 0.003), (-2.0, 0.002))
    for name, wheel in (("new", Profile.s1002()), ("hollow", hollow())):
        for y, yaw in places[: 1 if quick else None]:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                patch = WheelOnRail(
                    track=Track(rail=Profile.rail_60e1(), cant=1 / 40),
                    wheelset=WheelSet(wheel=wheel),
                    position=Position(y=y, yaw=yaw),
                    vertical_force=80e3,
                    friction=0.35,
                    dx=0.5,
                    dy=0.5,
                ).solve().patches[0]  # fmt: skip
                diagram = johnson_diagram(patch, K)
                row = _row(f"{name}, y = {y:g} mm", patch, K, body="rail", gap=RAIL_GAP)
            rows.append([row[0], diagram.utilised, diagram.load_factor, *row[1:]])
    head = (HEAD[0], "utilised", "p/k", *HEAD[1:])
    return Table(head, (FORMATS[0], ".3f", ".2f", *FORMATS[1:]), rows)


def random_contact(seed: int) -> vc.Solution:
    rng = np.random.default_rng(seed)
    a = float(np.exp(rng.uniform(-1, 1)))
    f = float(rng.uniform(0.05, 0.6))
    motion = {"vx": rng.normal(), "vy": rng.normal(), "spin": 2 * rng.normal()}
    scale = float(10 ** rng.uniform(-1.5, 1.5))
    creepages = {name: scale * float(value) for name, value in motion.items()}
    return ellipse(a, 1.0, f, n=14, nu=float(rng.uniform(0.0, 0.5)), **creepages)


def judged(seed: int, gap: float | None) -> dict[str, float | bool]:
    """Bounds of a random contact: crossed ones, and the largest traction by the upper one."""
    solution = random_contact(seed)
    start = time.process_time()
    limit = vc.shakedown(solution, 1.0, gap=gap)
    seconds = time.process_time() - start
    least, most = limit.kinematic
    crossed = (
        max(limit.lower, limit.sampled) > limit.upper * (1 + ROUNDING)
        or least > most * (1 + ROUNDING)
        or limit.upper > most * (1 + ROUNDING)
    )
    return {
        "crossed": crossed,
        "by traction": limit.upper * limit.local * limit.peak_pressure,
        "gap": 100 * limit.gap,
        "proved": limit.proved,
        "seconds": seconds,
    }


def random_bounds(quick: bool) -> Table:
    """Random ellipses in rolling: bounds that cross, k by the largest traction that is crossed, by
    closed forms and by programs; gaps and times.

    Each contact that is judged is kept at once in results/shakedown_cases.json, where a stopped run
    goes on.
    """
    known = json.loads(CASES.read_text()) if CASES.exists() and not quick else {}
    rows = []
    for name, count, gap in (
        ("closed forms", QUICK_RANDOM if quick else RANDOM, None),
        ("programs", QUICK_PROGRAMS if quick else PROGRAMS, 0.05),
    ):
        for seed in range(count):
            case = f"{name} {seed}"
            if case not in known:
                known[case] = judged(seed, gap)
                print(case, known[case], flush=True)
                if not quick:
                    CASES.write_text(json.dumps(known, indent=1) + "\n")
        own = [known[f"{name} {seed}"] for seed in range(count)]
        crossed = sum(each["crossed"] for each in own)
        beyond = sum(each["by traction"] > 1 + ROUNDING for each in own)
        figures = [
            [float(np.median(values)), float(max(values))]
            for values in ([each[figure] for each in own] for figure in ("gap", "seconds"))
        ]
        rows.append([name, count, crossed, beyond, *figures])
    head = (
        "random contacts", "number", "bounds crossed", "k / max abs(q) exceeded",
        "gap [%], median and largest", "time [s], likewise",
    )  # fmt: skip
    return Table(head, ("", "", "", "", "{:.1f}, {:.1f}", "{:.1f}, {:.1f}"), rows)


def march(quick: bool) -> Table:
    """Thirty passages of the critical depth of line contacts, elastic-plastic: plastic strain of
    the last by the first, below the lower and above the upper bound.
    """
    rows = []
    for f, nu in ((0.0, 0.3), (0.2, 0.3), (0.3, 0.5), (0.4, 0.3)):
        limit = vc.shakedown(line(f, nu, n=20), 0.5 / (1 - nu), elastic=mcewen(f, nu))
        curve = limit.critical[::2]
        below = marched(0.99 * limit.lower * curve, nu)
        above = marched(1.02 * limit.upper * curve, nu)
        last = "no bound" if np.isinf(above[0]) else f"{above[-1] / max(above[0], 1e-30):.2g}"
        rows.append([f, nu, limit.lower, f"{below[-1] / max(below[0], 1e-30):.1g}", last])
    head = ("f", "nu", "lower bound", "last by first passage, 1 % below", "2 % above the upper")
    return Table(head, (".1f", ".1f", ".4f", "", ""), rows)


TABLES = {
    "line": line_limits,
    "point": point_limits,
    "rail": rail_limits,
    "random": random_bounds,
    "march": march,
}
