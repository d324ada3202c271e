"""Tables of scenes that `refine="continuum"` is for."""

import math
import time
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

import varcontact as vc
from tests.benchmarks.random_scenes import scenes as random_scenes
from tests.benchmarks.refinement import (
    FRICTION,
    VALUES,
    cases,
    cliffs,
    histories,
    loads,
    read_references,
    scene,
    unlike,
)
from varcontact.reference import carter, line_contact
from varcontact.reference.no_slip_ellipse import no_slip_ellipse
from varcontact.results.quantities_of_interest import values

STEEL = vc.Bodies(G=1.0, nu=0.25)
SLOPES = (8, 16, 32, 48, 64)
"""Cells on which slopes without slip are compared with their closed forms."""
COMPUTED = (
    "sampled paraboloid, creepage",
    "two arcs, spin",
    "two patches, spin",
    "two patches, Fx = 0.5",
    "egg, near full slip",
    "line, two bumps, creepage",
)


def corrected(posed: vc.Scene, **options: str) -> vc.Solution:
    """The corrected solution, without bounds."""
    return vc.solve(posed, refine="continuum", certify=None, **options)


def plain(posed: vc.Scene) -> vc.Solution:
    """The solution on the grid, without bounds."""
    return vc.solve(posed, certify=None)


def spread(name: str, errors: Iterable[float], note: str = "") -> None:
    """A row: median, nine in ten, largest."""
    numbers = np.quantile(np.array(list(errors)), [0.5, 0.9, 1.0])
    print(f"{name:28s} " + " / ".join(f"{value:.1e}" for value in numbers) + f"  {note}", flush=True)


def twelve() -> None:
    """Plain grids, Richardson's extrapolation and correction on the twelve scenes with references."""
    rows = read_references()
    truth = np.array([[row[name] for name in VALUES] for _, row in rows])
    before = np.array([loads(plain(scene(case, 4))) for case, _ in rows])
    for cells in (8, 16, 32, 64):
        begun = time.process_time()
        coarse = np.array([loads(plain(scene(case, cells))) for case, _ in rows])
        middle = time.process_time()
        found = [corrected(scene(case, cells)) for case, _ in rows]
        seconds = np.array([middle - begun, time.process_time() - middle]) / len(rows)
        errors = {
            "plain": coarse,
            "Richardson": 2 * coarse - before,
            "corrected": np.array([loads(one) for one in found]),
        }
        for name, each in errors.items():
            spread(f"{cells} cells, {name}", np.abs(each - truth).max(axis=1))
        estimates = np.array([one.refinement.estimate.max() for one in found]) / FRICTION
        above = np.count_nonzero(np.abs(errors["corrected"] - truth).max(axis=1) > estimates)
        spread("    its estimate", estimates, f"{above} errors above; seconds {seconds[0]:.3f}, {seconds[1]:.3f}")
        before = coarse


def drawn(count: int, seed: int, least: float, most: float) -> list[dict[str, float]]:
    """Random scenes: a/b from 0.2 to 5, any nu, creepages of a size in saturation creepages."""
    rng, found = np.random.default_rng(seed), []
    for _ in range(count):
        ratio, nu = np.exp(rng.uniform(math.log(0.2), math.log(5))), rng.uniform(0, 0.5)
        size, way = np.exp(rng.uniform(math.log(least), math.log(most))), rng.normal(size=3)
        creepages = map(float, size * way / np.linalg.norm(way))
        found.append(dict(zip(("ratio", "nu", "vx", "vy", "spin"), (float(ratio), float(nu), *creepages), strict=True)))
    return found


def against(scenes: list[dict[str, float]], cells: Iterable[int], relative: bool = False) -> None:
    """Errors from corrected solutions on 128 cells."""
    truth = np.array([loads(corrected(scene(case, 128))) for case in scenes])
    unit = np.abs(truth).max(axis=1) if relative else 1.0
    for count in cells:
        coarse = np.array([loads(plain(scene(case, count))) for case in scenes])
        found = [corrected(scene(case, count)) for case in scenes]
        errors = np.abs(np.array([loads(one) for one in found]) - truth).max(axis=1)
        estimates = np.array([one.refinement.estimate.max() for one in found]) / FRICTION
        without = np.abs(coarse - truth).max(axis=1)
        spread(f"{count} cells, plain", without / unit)
        above, worse = np.count_nonzero(errors > estimates), np.count_nonzero(errors > without)
        most = np.where(errors > estimates, errors, 0).max()
        note = f"{above} above estimates ({(errors / estimates).max():.1f} times, {most:.1e}), {worse} lose"
        spread(f"{count} cells, corrected", errors / unit, note)


def sixty() -> None:
    """Random scenes from partial to full slip."""
    against(drawn(60, 60, 0.1, 4.0), (8, 12, 16, 24, 32))


def small() -> None:
    """Random scenes of small creepages, relative to the largest of the three loads."""
    against(drawn(40, 5, 5e-4, 0.15), (16, 32), relative=True)


def no_slip() -> None:
    """No-slip coefficients of ellipses and the slope of Carter's curve, by infinite friction: relative errors."""
    for ratio in (0.2, 0.5, 1.0, 2.0, 5.0):
        known, errors = no_slip_ellipse(ratio, 0.28), []
        for cells in SLOPES:
            forces = []
            for motion in (vc.Steady(vx=1e-3), vc.Steady(vy=1e-3), vc.Steady(spin=1e-3)):
                posed = replace(scene(dict.fromkeys(("nu", "vx", "vy", "spin"), 0.28) | {"ratio": ratio}, cells))
                one = corrected(replace(posed, friction=math.inf, motion=motion))
                forces.append(-np.array([*one.force, one.moment]) / 1e-3)
            f = np.array(forces).T
            pairs = [(0, 0), (1, 1), (1, 2), (2, 1), (2, 2)]
            errors.append([f[pair] / known[pair] - 1 for pair in pairs])
            print(f"a/b = {ratio}, {cells} cells: " + " ".join(f"{error:8.1e}" for error in errors[-1]), flush=True)
        order = -np.polyfit(np.log(SLOPES), np.log(np.abs(errors).max(axis=1)), 1)[0]
        print(f"    order of the largest: {order:.1f}")
    a = 0.01
    for cells in SLOPES:
        force = line_contact(2.0, STEEL, a=a).force
        posed = vc.Scene(
            bodies=STEEL,
            surface=vc.Cylinders(R=2.0),
            normal_force=force,
            friction=math.inf,
            motion=vc.Steady(vx=1e-3),
            grid=vc.Grid(nx=cells),
        )
        exact = math.pi * a / (2 * (1 - 0.25))
        print(f"line, {cells} strips: {-corrected(posed).force[0] / 1e-3 / exact - 1:.1e}")


def ellipses() -> None:
    """Mixed creepages of random ellipses without slip, against their closed form: errors by the force."""
    rng, drawn_scenes = np.random.default_rng(24), []
    for _ in range(24):
        ratio, nu = math.exp(rng.uniform(math.log(0.1), math.log(10))), float(rng.uniform(0, 0.5))
        drawn_scenes.append((ratio, nu, rng.normal(size=3) * 1e-3))
    for cells in (8, 12, 16, 24, 32):
        errors, estimates = [], []
        for ratio, nu, creepages in drawn_scenes:
            posed = scene({"ratio": ratio, "nu": nu} | dict.fromkeys(("vx", "vy", "spin"), 0.0), cells)
            vx, vy, spin = map(float, creepages)
            motion = vc.Steady(vx=vx, vy=vy, spin=spin)
            one = corrected(replace(posed, friction=math.inf, motion=motion))
            exact = -no_slip_ellipse(ratio, nu, 128) @ creepages
            size = np.hypot(*exact[:2])
            errors.append(np.abs(np.array([*one.force, one.moment]) - exact).max() / size)
            estimates.append(one.refinement.estimate.max() / size)
        above = np.count_nonzero(np.array(errors) > estimates)
        spread(f"{cells} cells", errors, f"{above} above their estimates")


def line() -> None:
    """Carter's force by f Fz, at parts of full slip."""
    contact = line_contact(2.0, STEEL, a=0.01)
    limit = FRICTION * contact.force
    for part in (0.003, 0.01, 0.02, 0.04, 0.07, 0.1, 0.2, 0.5, 0.8, 0.95):
        creepage, errors = carter(contact, FRICTION, force=-part * limit).creepage, []
        for cells in (16, 32, 64, 128, 256):
            posed = vc.Scene(
                bodies=STEEL,
                surface=vc.Cylinders(R=2.0),
                normal_force=contact.force,
                friction=FRICTION,
                motion=vc.Steady(vx=creepage),
                grid=vc.Grid(nx=cells),
            )
            errors.append([abs(one.force[0] / limit + part) for one in (plain(posed), corrected(posed))])
        print(f"{part}: " + ", ".join(f"{before:.1e} {after:.1e}" for before, after in errors), flush=True)


def forces() -> None:
    """Creepages of scenes with both forces given, by those of saturation; and what the field carries."""
    for cells in (16, 32):
        before, after, carried = [], [], []
        for case, row in read_references()[::2]:
            wanted = scene(case, cells).motion
            motion = vc.Steady(Fx=FRICTION * row["Fx"], Fy=FRICTION * row["Fy"], spin=wanted.spin)
            posed = replace(scene(case, cells), motion=motion)
            for errors, one in ((before, plain(posed)), (after, found := corrected(posed))):
                errors.append(np.abs(np.subtract(one.creepage[:2], wanted.rigid[:2])).max() / (FRICTION / 3.7))
            carried.append(np.abs(found.force - [motion.Fx, motion.Fy]).max() / FRICTION)
        for name, errors in (("plain", before), ("corrected", after), ("forces carried", carried)):
            print(f"{cells} cells, {name}: {min(errors):.1e} to {max(errors):.1e}", flush=True)


def computed() -> None:
    """Pressures that are solved for, against the references of `vc.references()`; and Hertz's, solved for."""
    for name in COMPUTED:
        known, row = vc.references()[name], []
        for cells in (16, 32):
            posed = replace(known.scene, grid=vc.Grid(nx=cells, ny=None if known.scene.line else cells))
            before, after = plain(posed), corrected(posed)
            for one in (before, after):
                found = values(one)
                row.append(max(abs(found[each] - known.values[each]) / unit for each, unit in known.units.items()))
            row.append(max(after.error_estimate.errors.values()))
        print(f"{name:30s} " + " ".join(f"{value:.1e}" for value in row), flush=True)
    for cells in (16, 32):
        errors = []
        for case, row in read_references()[::2]:
            one = corrected(scene(case, cells), normal="newton")
            errors.append(np.abs(loads(one) - [row[name] for name in VALUES]).max())
        spread(f"Hertz, solved for, {cells} cells", errors)


def by_element() -> None:
    """Coefficients of 0.35 and 0.2 by element, against corrected solutions on 128 cells."""
    motions = (vc.Steady(vx=0.05), vc.Steady(vx=0.03, vy=-0.03, spin=0.06))
    halves: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
        "sides": lambda x, y: y + 0 * x > 0,
        "strip": lambda x, y: np.abs(y + 0 * x) < 0.25,
        "ahead and behind": lambda x, y: x + 0 * y > 0,
    }

    def three(half: str, a: float, b: float, motion: vc.Steady, cells: int, refine: str | None) -> np.ndarray:
        grid = vc.Grid(nx=cells, ny=cells, margin=0).spread((-a, a, -b, b))
        friction = np.where(halves[half](grid.x[None] / a, grid.y[:, None] / b), 0.35, 0.2)
        posed = replace(scene(cases()[0], cells), surface=vc.Ellipse(a=a, b=b), motion=motion)
        one = vc.solve(replace(posed, friction=friction, grid=grid), refine=refine, certify=None)
        return np.array([*one.force, one.moment]) / 0.275

    for half in halves:
        for a, b in ((1.0, 1.0), (1.5, 0.7)):
            for motion in motions:
                truth, row = three(half, a, b, motion, 128, "continuum"), []
                for cells in (16, 32):
                    found = [three(half, a, b, motion, cells, refine) for refine in (None, "continuum")]
                    row += [np.abs(each - truth).max() for each in found]
                print(f"{half:18s} a/b = {a / b:.1f} " + " ".join(f"{value:.1e}" for value in row), flush=True)


def laws() -> None:
    """Laws of friction: against corrected solutions on 64 cells, and these against plain ones on 40, 80 and 120."""
    drawn_scenes, errors = random_scenes("law", 16, 3), []
    for number, one in enumerate(drawn_scenes):
        law = one.friction
        if number % 4 == 3:
            law = vc.StaticKinetic(law.static, law.kinetic)
        limit, hertz = law.static * one.normal_force, one.hertz
        units = limit * np.array([1, 1, math.sqrt(hertz.a * hertz.b)])

        def three(sol: vc.Solution, units: np.ndarray = units) -> np.ndarray:
            return np.array([*sol.force, sol.moment]) / units

        posed = {n: replace(one, friction=law, grid=vc.Grid(nx=n, ny=n)) for n in (16, 32, 64)}
        truth, sizes = three(corrected(posed[64])), 1 / np.array([40, 80, 120])
        grids = [vc.Grid(nx=n, ny=n, edge="touched") for n in (40, 80, 120)]
        fine = [three(plain(replace(posed[64], grid=grid))) for grid in grids]
        limits = np.linalg.solve(np.vander(sizes, increasing=True), np.array(fine))[0]
        row = [np.abs(limits - truth).max()]
        for n in (16, 32):
            after = corrected(posed[n])
            row += [np.abs(three(sol) - truth).max() for sol in (plain(posed[n]), after)]
            row.append(max(after.error_estimate.errors.values()))
        errors.append(row)
        print(f"{type(law).__name__:14s} a/b = {hertz.a / hertz.b:.2f} "
              + " ".join(f"{value:.1e}" for value in row), flush=True)  # fmt: skip
    print("median " + " ".join(f"{value:.1e}" for value in np.median(errors, axis=0)))


def shifts() -> None:
    """Shifts in place: plain and corrected on 12, 24 and 48 cells, against touched elements, extrapolated."""
    ways = (
        (0.28, 1.0, {"ux": 0.7, "uy": 0.5}),
        (0.28, 1.0, {"ux": 0.4, "rotation": 0.8}),
        (0.5, 2.5, {"ux": 0.3, "uy": -0.6, "rotation": 0.3}),
        (0.0, 0.4, {"ux": 0.9}),
    )
    cells, rows = (10, 12, 16, 20, 24, 32, 48), []
    for nu, ratio, way in ways:
        size = 3 * (2 - nu) * FRICTION / 8  # Cattaneo's shift of full slip
        for part in (0.01, 0.05, 0.3, 0.7, 0.95):
            motion = vc.Shift(**{name: part * size * value for name, value in way.items()})
            posed = replace(scene(cases()[0] | {"nu": nu, "ratio": ratio}, 12), motion=motion)
            grids = [vc.Grid(nx=n, ny=n, edge="touched") for n in (48, 64, 96, 128)]
            sizes, fine = 1 / np.array([48, 64, 96, 128]), [loads(plain(replace(posed, grid=grid))) for grid in grids]
            terms = np.vander(sizes, 3, increasing=True) / sizes[:, None]
            truth = np.linalg.lstsq(terms, np.array(fine) / sizes[:, None], rcond=None)[0][0]
            row = []
            for n in cells:
                one = replace(posed, grid=vc.Grid(nx=n, ny=n))
                after = corrected(one)
                row += [np.abs(loads(sol) - truth).max() for sol in (plain(one), after)]
                row.append(after.refinement.estimate.max() / FRICTION)
            rows.append(row)
            print(f"a/b = {ratio}, {part:.2f}: " + " ".join(f"{value:.1e}" for value in row), flush=True)
    found = np.array(rows).reshape(-1, len(cells), 3)
    for k, n in enumerate(cells):
        before, after, estimate = found[:, k].T
        spread(f"{n} cells, plain", before)
        note = f"{np.count_nonzero(after < before)} of {len(after)} nearer, {np.count_nonzero(after > estimate)} above"
        spread(f"{n} cells, corrected", after, note + " their estimates")


TABLES: dict[str, Callable[[], None]] = {
    "twelve": twelve,
    "sixty": sixty,
    "small": small,
    "no-slip": no_slip,
    "ellipses": ellipses,
    "line": line,
    "forces": forces,
    "computed": computed,
    "by-element": by_element,
    "laws": laws,
    "histories": histories.table,
    "random-histories": histories.random_histories,
    "unlike": unlike.table,
    "shifts": shifts,
    "cliffs": cliffs.table,
}
