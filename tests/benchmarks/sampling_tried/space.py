"""In space: computed pressures and cut elements, histories of the references, forces of the solver's own levels."""

import contextlib
import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import numpy as np

import varcontact as vc
from tests.benchmarks.coarse_forces import FRICTION, extrapolated, read, scene
from varcontact.discrete.discretisation import Discretisation
from varcontact.reference import carter, line_contact
from varcontact.scene.grid import Edge
from varcontact.solvers.newton import driver


def normal() -> None:
    """NORM on Hertz's contact: errors of the approach and of the largest pressure, in per cent."""
    for n in (12, 13, 16, 17, 24, 25, 32, 33, 48, 49):
        approaches, peaks = [], []
        for ratio in (0.3, 0.6, 1.0, 1.7, 3.0):
            surface = vc.Ellipse(a=ratio**0.5, b=ratio**-0.5)
            bodies, grid = vc.Bodies(G=1.0, nu=0.28), vc.Grid(nx=n, ny=n)
            posed = vc.Scene(bodies=bodies, surface=surface, normal_force=1.0, grid=grid)
            sol = vc.solve(posed, normal="norm", certify="none")
            approaches.append(100 * (sol.approach / posed.hertz.approach - 1))
            peaks.append(100 * (sol.pressure.max() / posed.hertz.peak_pressure - 1))
        print(f"{n}: approach {np.round(approaches, 3)}, largest pressure {np.round(peaks, 2)}", flush=True)


def covered(pressure: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which part of each element at the edge is covered, from the squares of the pressures inside; and where."""
    squares = np.pad(np.maximum(pressure, 0), 3) ** 2
    ny, nx = pressure.shape
    level, count, slope = np.zeros((3, ny, nx))
    contact = pressure > 0
    for dy, dx in ((0, 1), (1, 0)):
        on, further, back, beyond = (
            squares[3 + k * dy : 3 + k * dy + ny, 3 + k * dx : 3 + k * dx + nx] for k in (1, 2, -1, -2)
        )
        begins = contact & (back <= 0) & (on > 0) & (further > on)
        ends = contact & (on <= 0) & (back > 0) & (beyond > back)
        inside = np.where((on > 0) & (back > 0), np.abs(on - back) / 2, 0.0)
        slope += np.where(begins, further - on, np.where(ends, beyond - back, inside))
        level += np.where(begins, 2 * on - further, np.where(ends, 2 * back - beyond, 0.0))
        count += begins | ends
    edge = count > 0
    share = np.ones(pressure.shape)
    share[edge] = 0.5 + level[edge] / count[edge] / slope[edge]
    return share, edge


@contextlib.contextmanager
def softened() -> Iterator[None]:
    """Tangential problems in which elements at the edge of a computed pressure are softened by the part covered."""
    posed = Discretisation.tangential_problem

    def with_softening(self: Discretisation, pressure: np.ndarray, *rest: Any, **options: Any) -> Any:
        (ny, nx), table = self.grid.shape, self.tangential_operator.table
        own = np.array([table[i, i, ny - 1, nx - 1] for i in (0, 1)])
        share, edge = covered(pressure)
        more = np.where(edge, np.maximum(1.6 * (np.maximum(share, 0.3) ** -1.5 - 1), 0.0), 0.0)
        self.__dict__["softening"] = own[:, None, None] * more
        return posed(self, pressure, *rest, **options)

    with patch.object(Discretisation, "tangential_problem", with_softening):
        yield


def sampled(numbers: dict[str, float], n: int, edge: Edge = "centres") -> vc.Scene:
    """A scene of the forty as a sampled paraboloid, with the difference of second order."""
    posed = scene(numbers, n).second_order()
    hertz = posed.hertz
    x, y = (np.linspace(-1.4 * side, 1.4 * side, 401) for side in (hertz.a, hertz.b))
    h = x**2 / (2 * hertz.Rx) + y[:, None] ** 2 / (2 * hertz.Ry)
    return replace(posed, surface=vc.SampledDistance(h, x=x, y=y), grid=vc.Grid(nx=n, ny=n, edge=edge))


def cut() -> None:
    """Sampled paraboloids: errors by centres, and with elements at the edge softened; median, nine in ten, largest."""
    for n in (12, 16, 24, 32):
        for name, way in (("by centres", contextlib.nullcontext), ("softened", softened)):
            errors = []
            for numbers, truth in read()[::2]:
                with way():
                    sol = vc.solve(sampled(numbers, n), certify="none", tol=1e-4)
                errors.append(100 * np.abs(np.array([*sol.force, sol.moment]) / FRICTION - truth).max())
            print(
                f"{n} {name}: " + "/".join(f"{value:.2f}" for value in np.quantile(errors, [0.5, 0.9, 1])), flush=True
            )


def parts() -> None:
    """Sampled paraboloids, and strips moved by eighths under Carter: errors by centres, and on parts of elements."""
    edges: tuple[Edge, Edge] = ("centres", "softened")
    for n in (12, 16, 24, 32, 48):
        for edge in edges:
            single, two, seconds = [], [], []
            for numbers, truth in read():
                coarse, _ = _loads(sampled(numbers, n // 2, edge))
                found, taken = _loads(sampled(numbers, n, edge))
                single.append(100 * np.abs(found - truth).max())
                two.append(100 * np.abs(extrapolated(coarse, found, 2.0) - truth).max())
                seconds.append(taken)
            rows = ("/".join(f"{value:.2f}" for value in np.quantile(each, [0.5, 0.9, 1])) for each in (single, two))
            print(f"{n} {edge}: {' and from n/2 and n '.join(rows)}; {1e3 * np.median(seconds):.0f} ms", flush=True)
    for n in (16, 32, 64, 128):
        for edge in edges:
            errors = [100 * _off_carter(n, eighths / 8, edge) for eighths in range(8)]
            print(f"{n} strips, {edge}: {min(errors):.2f} to {max(errors):.2f}", flush=True)


def _loads(posed: vc.Scene) -> tuple[np.ndarray, float]:
    """Fx, Fy and Mz by f Fz, and processor seconds."""
    begun = time.process_time()
    sol = vc.solve(posed, certify="none", tol=1e-4)
    return np.array([*sol.force, sol.moment]) / FRICTION, time.process_time() - begun


def _off_carter(n: int, moved: float, edge: Edge) -> float:
    """Error of the force by Carter's creepage for 60 % of saturation, by f Fz, with a pressure that is solved for."""
    contact = line_contact(1.0, vc.Bodies(G=1.0, nu=0.3), a=0.01)
    exact = carter(contact, FRICTION, force=-0.6 * FRICTION * contact.force)
    dx = 0.02 / n
    motion = vc.Steady(vx=exact.creepage, slip_difference="second-order")
    grid = vc.Grid(nx=n + 2, dx=dx, x0=-0.01 - (0.5 + moved) * dx, edge=edge)
    posed = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3),
        surface=vc.Cylinders(R=1.0),
        normal_force=contact.force,
        friction=FRICTION,
        motion=motion,
        grid=grid,
    )
    sol = vc.solve(posed, normal="newton", certify="none")
    return (sol.force[0] - exact.force) / (FRICTION * contact.force)


def unlike() -> None:
    """Unlike bodies in line contact: forces by f Fz, by centres and softened."""
    bodies = vc.Bodies(G=(1.0, 3.0), nu=(0.25, 0.3))
    force = line_contact(1.0, bodies, a=0.01).force
    for name, way in (("by centres", contextlib.nullcontext), ("softened", softened)):
        row = []
        for n in (32, 40, 64, 96, 256):
            posed = vc.Scene(
                bodies=bodies,
                surface=vc.Cylinders(R=1.0),
                normal_force=force,
                friction=FRICTION,
                motion=vc.Steady(vx=0.0015),
                grid=vc.Grid(nx=n),
            )
            with way():
                row.append(vc.solve(posed.second_order(), certify="none").force[0] / force / FRICTION)
        print(f"unlike, {name}: " + " ".join(f"{value:.4f}" for value in row), flush=True)


def histories() -> None:
    """Histories of the references as they stand: largest errors on 12 and 24 cells, in per cent."""
    for name, known in vc.references().items():
        if known.kind != "transient":
            continue
        row = []
        for n in (12, 24):
            found = vc.solve(replace(known.scene, grid=vc.Grid(nx=n, ny=n)), certify="none", tol=1e-5)
            values = {}
            for k in known.steps:
                loads = dict(zip(("Fx", "Fy"), found[k].force, strict=True)) | {"Mz": found[k].moment}
                creepages = dict(zip(("vx", "vy"), found[k].creepage[:2], strict=True))
                values |= {f"{quantity}[{k}]": value for quantity, value in (loads | creepages).items()}
            off = [
                abs(values[each] - known.values[each]) / unit for each, unit in known.units.items() if each in values
            ]
            row.append(100 * max(off))
        print(f"{name}: " + ", ".join(f"{value:.2f}" for value in row), flush=True)


def levels() -> None:
    """Forces of the level of half the cells within Newton's method, against those of a separate solution."""
    recorded: list[tuple[int, np.ndarray]] = []
    inner, finest = driver.newton, driver.solve_from

    def recording(conditions: Any, at: Any, *rest: Any, **options: Any) -> Any:
        result = inner(conditions, at, *rest, **options)
        traction = result.at.traction
        recorded.append((traction.shape[2], (traction * conditions.scale).sum(axis=(1, 2))))
        return result

    def finished(problem: Any, *rest: Any, **options: Any) -> Any:
        raw = finest(problem, *rest, **options)
        recorded.append((0, raw.traction.sum(axis=1) / problem.load))
        return raw

    with patch.object(driver, "newton", recording), patch.object(driver, "solve_from", finished):
        for n in (32, 48):
            rows = []
            for numbers, truth in read()[::2]:
                fine, coarse, level = _three(numbers, n, recorded)
                rows.append((fine, coarse, level, truth[:2]))
            fine, coarse, level, truth = np.array(rows).swapaxes(0, 1)
            for name, off in (
                ("level less separate", level - coarse),
                ("from separate n/2 and n", extrapolated(coarse, fine, 2.0) - truth),
                ("from the level and n", extrapolated(level, fine, 2.0) - truth),
            ):
                quantiles = 100 * np.quantile(np.abs(off).max(axis=1), [0.5, 0.9, 1])
                print(f"{n} {name}: " + "/".join(f"{value:.2f}" for value in quantiles), flush=True)


def _three(
    numbers: dict[str, float], n: int, recorded: list[tuple[int, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fx and Fy by f Fz on n cells, on n/2, and of the level below n; sums of a level count four times those of n."""
    forces = []
    for cells in (n // 2, n):
        recorded.clear()
        sol = vc.solve(scene(numbers, cells).second_order(), certify="none", tangential="newton", tol=1e-4)
        forces.append(np.array(sol.force) / FRICTION)
    coarse, fine = forces
    finest, last = max(width for width, _ in recorded), recorded[-1][1]
    below = [sums for width, sums in recorded if 0 < width < finest][-1]
    return fine, coarse, 4 * below * (fine @ fine) / (fine @ last)
