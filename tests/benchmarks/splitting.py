"""Projection and contraction: rounds and products by size, whole solves beside the default, and
random problems.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial

import numpy as np

import varcontact as vc
from tests.benchmarks.table import Table, least
from tests.scenes import make_scene
from tests.solvers.conftest import random_normal, random_tangential
from varcontact.data.benchmark_scenes import unlike_bank
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.solvers.interface import Settings, natural_residual
from varcontact.solvers.newton.normal import newton_normal
from varcontact.solvers.newton.tangential import newton_tangential
from varcontact.solvers.splitting.method import splitting_normal, splitting_tangential
from varcontact.solvers.splitting.products import Influence

TOL = 1e-9
SETTINGS = Settings(TOL, loose_tolerance=True)
MOTIONS = {
    "shift": vc.Shift(ux=0.1),
    "steady": vc.Steady(vx=0.1, spin=0.1),
    "forces given": vc.Steady(Fx=-0.15, vy=0.02),
}


Product = Callable[[Influence, np.ndarray], np.ndarray]


@contextmanager
def counted_products() -> Iterator[list[int]]:
    """The products with M or its transpose on boxes of each size, coarse grids included."""
    sizes: list[int] = []
    products = Influence.apply, Influence.transposed

    def counting(product: Product, self: Influence, field: np.ndarray) -> np.ndarray:
        sizes.append(field.size)
        return product(self, field)

    for product in products:
        setattr(Influence, product.__name__, _method(counting, product))
    try:
        yield sizes
    finally:
        for product in products:
            setattr(Influence, product.__name__, product)


def _method(counting: Callable[..., np.ndarray], product: Product) -> Product:
    return lambda self, field: counting(product, self, field)


def problems(cells: int) -> Iterator[tuple[str, NormalProblem | TangentialProblem]]:
    """Tractions of three motions, and pressures by force and by approach, on a square grid."""
    sphere = vc.Ellipse(a=1.0, b=1.0)
    grid = vc.Grid(nx=cells, ny=cells)
    for name, motion in MOTIONS.items():
        scene = make_scene(sphere, 1.0, motion, grid)
        lattice = vc.solve(replace(scene, motion=None, friction=None)).grid
        disc = discretise(scene, lattice)
        pressure = hertz_pressure(disc, unloaded(disc.grid)).pressure
        yield name, disc.tangential_problem(pressure)
    by_force = disc.normal_problem().reachable()
    yield "normal force", by_force
    approach = float(newton_normal(by_force, SETTINGS).rigid[0])
    yield "approach", replace(by_force, force=None, approach=approach)


def rounds(quick: bool) -> Table:
    """Products with M on the finest grid, and seconds beside Newton's method, to 1e-9."""
    rows = []
    for cells in (16,) if quick else (16, 32, 64, 128, 256):
        for name, problem in problems(cells):
            normal = isinstance(problem, NormalProblem)
            split = splitting_normal if normal else splitting_tangential
            newton = newton_normal if normal else newton_tangential
            with counted_products() as sizes:
                raw = split(problem, SETTINGS)
            products = sum(size == max(sizes) for size in sizes)
            assert natural_residual(problem, raw) <= TOL
            seconds = [least(partial(solver, problem, SETTINGS), 3) for solver in (split, newton)]
            elements = problem.operator.elements.size
            rows.append([str(elements), name, products, *seconds, seconds[0] / seconds[1]])
    head = ["elements", "problem", "products", "`splitting`, s", "`newton`, s", "ratio"]
    return Table(head, ["", "", "", ".2g", ".2g", ".1f"], rows)


def whole(quick: bool) -> Table:
    """Processor seconds of whole solves by `convex`, divided by those by `auto`, in turn; to 1e-9,
    without a full certificate.
    """
    rows = []
    for cells in (12,) if quick else (12, 24, 60):
        ratios = {}
        for name, scene in (vc.standard_bank(cells) | unlike_bank(cells)).items():
            options = {"tol": TOL, "certify": "gap"}
            best = [np.inf, np.inf]
            for _ in range(2):  # in turn
                for i, method in enumerate(("auto", "convex")):
                    begun = time.process_time()
                    vc.solve(scene, method=method, **options)
                    best[i] = min(best[i], time.process_time() - begun)
            ratios[name] = best[1] / best[0]
        slowest = max(ratios, key=ratios.__getitem__)
        values = list(ratios.values())
        rows.append([str(cells), len(values), float(np.median(values)), max(values), slowest])
    head = ["cells along x", "scenes", "median", "largest", "of"]
    return Table(head, ["", "", ".2f", ".2f", ""], rows)


def random(quick: bool) -> Table:
    """Random problems of 1 to 900 elements to 1e-9: not solved, and rounds, by whether the
    symmetric part is found definite.
    """
    count = 100 if quick else 5000
    found: dict[bool, list[tuple[bool, int]]] = {True: [], False: []}
    for seed in range(count):
        if seed % 5 == 4:
            pressed = random_normal(seed, line=seed % 10 == 4)
            raw = splitting_normal(pressed, SETTINGS)
            solved = raw.solved and natural_residual(pressed, raw) <= TOL
            definite = True
        else:
            sliding = random_tangential(seed)
            raw = splitting_tangential(sliding, SETTINGS)
            solved = raw.solved and natural_residual(sliding, raw) <= TOL
            definite = sliding.symmetric or sliding.symmetric_part is not None
        found[definite].append((solved, raw.iterations))
        if not solved:
            print(f"seed {seed}: {raw.status}, definite: {definite}", flush=True)
    rows = []
    for definite, answers in found.items():
        if answers:
            missed = sum(not solved for solved, _ in answers)
            iterations = [each for _, each in answers]
            median = float(np.median(iterations))
            words = "definite" if definite else "not found definite"
            rows.append([words, len(answers), missed, median, max(iterations)])
    head = ["symmetric part", "problems", "not solved", "rounds, median", "most"]
    return Table(head, ["", "", "", ".0f", ""], rows)


TABLES = {"rounds": rounds, "whole": whole, "random": random}
