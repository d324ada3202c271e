"""Random problems for solvers without a matrix, small enough to be solved densely, too."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.elasticity.operators import influence_operator
from varcontact.interfaces.potential import Potential

SHAPES = ("ellipse", "needle", "patches", "holes", "wavy", "row", "strip", "single", "levels")


@pytest.fixture(scope="session")
def tangential_problem():
    """A function: a random tangential problem from a seed; some entries can be chosen."""
    return random_tangential


@pytest.fixture(scope="session")
def normal_problem():
    """A function: a random normal problem from a seed."""
    return random_normal


def random_tangential(
    seed,
    shape=None,
    friction=None,
    step=None,
    rolling=None,
    nu=None,
    carried=None,
    no_slip=False,
    creepage=None,
):
    """Odd and non-square grids, missing elements, wavy pressures, short and long steps, needles,
    forces given.
    """
    rng = np.random.default_rng(seed)
    shape = shape or SHAPES[seed % len(SHAPES)]
    grid = random_grid(rng, shape)
    x, y = np.meshgrid(grid.x, grid.y)
    bound = random_pressure(
        rng, shape, x / x.max(initial=grid.sides[0]), y / y.max(initial=grid.sides[1])
    )
    bound *= rng.choice([0.01, 0.1, 0.3, 0.6]) if friction is None else friction
    rolling = bool(rng.random() < 0.65) if rolling is None else rolling
    step = float(rng.choice([0.7, 1.0, 1.0, 1.0, 1.7, 3.3, 10.0])) if step is None else step
    nu = float(rng.choice([0.0, 0.28, 0.4, 0.5])) if nu is None else nu
    lag = step * grid.sides[0] if rolling else None
    operator = influence_operator(grid, "xy", "xy", nu=nu, depth=8.0, lag=lag)
    creepage = (
        rng.normal(size=3) * rng.choice([0.03, 0.1, 0.3])
        if creepage is None
        else np.array(creepage)
    )
    rolled = lag if rolling else 0.3
    rigid = rolled * np.array([creepage[0] - creepage[2] * y, creepage[1] + creepage[2] * x])
    directions = (int(rng.integers(2)),) if shape == "strip" and rng.random() < 0.5 else (0, 1)
    carried = float(rng.choice([0.0, 0.0, 0.0, 0.3, 0.9])) if carried is None else carried
    angle, total = rng.uniform(0, 2 * np.pi), carried * bound.sum() * grid.area
    along = (
        (total * np.cos(angle), total * np.sin(angle)) if len(directions) == 2 else (total, total)
    )
    prescribed = rng.permutation([True, bool(rng.integers(2))])
    force = tuple(float(along[i]) if carried and prescribed[i] else None for i in directions)
    elements = np.flatnonzero(bound.ravel() > 0)
    return TangentialProblem(
        operator=operator.between(directions, directions).on(elements),
        rigid_shift=rigid.reshape(2, -1)[list(directions)][:, elements],
        potential=Potential(np.full(elements.size, np.inf) if no_slip else bound.ravel()[elements]),
        points=np.array([x.ravel()[elements], y.ravel()[elements]]),
        area=grid.area,
        force=force,
        symmetric=not rolling,
        directions=directions,
    )


def random_grid(rng, shape):
    """About the origin, two long in the mean of its sides."""
    nx, ny = rng.integers(3, 22, 2)
    ratio = np.exp(0.4 * rng.normal())
    if shape == "needle":
        ratio = np.exp(rng.choice([-1, 1]) * rng.uniform(1.5, 3))
    if shape in ("row", "strip"):
        nx, ny = rng.integers(2, 80), 1
    if shape == "single":
        nx, ny = rng.integers(1, 3, 2)
    if shape == "levels":
        nx, ny = rng.integers(24, 30, 2)
    width, height = 2 * np.sqrt(ratio), 2 / np.sqrt(ratio)
    if shape == "strip":
        return vc.Grid(nx=int(nx), dx=2 / nx, x0=-1.0)
    dx, dy = width / nx, height / ny
    return vc.Grid(nx=int(nx), ny=int(ny), dx=dx, dy=dy, x0=-width / 2, y0=-height / 2)


def random_pressure(rng, shape, x, y):
    """On a grid whose outermost centres are at one: never zero all over."""
    pressure = np.sqrt(np.maximum(1.02 - x**2 - y**2, 0 if shape != "single" else 0.3))
    if shape in ("row", "strip"):
        pressure = np.sqrt(np.maximum(1.02 - x**2, 0))
    if shape == "wavy":
        pressure = pressure * (1 + 0.7 * np.sin(7 * x + rng.uniform(0, 6)) * np.cos(5 * y))
    if shape == "patches":
        pressure = pressure * ((x + 0.3 * y > 0.2) | (x + 0.3 * y < -0.15))
    if shape == "holes":
        pressure = pressure * (rng.random(x.shape) > 0.15)
    return pressure if pressure.any() else np.ones(x.shape)


def random_normal(seed, line=False):
    """A paraboloid, wavy or rough, on any grid, by force or approach."""
    rng = np.random.default_rng(seed)
    grid = random_grid(
        rng, "strip" if line else rng.choice(["ellipse", "needle", "row", "single", "levels"])
    )
    x, y = np.meshgrid(grid.x, grid.y)
    distance = x**2 / 2 + (0 if line else y**2 / 2) * np.exp(rng.normal())
    distance += rng.choice([0.0, 0.05]) * rng.normal(size=x.shape) + rng.choice(
        [0.0, 0.1]
    ) * np.sin(6 * x + 4 * y)
    distance = (distance - distance.min()).ravel()
    nu = float(rng.choice([0.0, 0.3, 0.5]))
    operator = influence_operator(grid, "z", "z", nu=nu, depth=8.0)
    elements = np.flatnonzero(rng.random(grid.size) > rng.choice([0.0, 0.1]))
    elements = elements if elements.size else np.arange(grid.size)
    given = float(rng.uniform(0.02, 0.5))
    by_force = bool(rng.integers(2))
    return NormalProblem(
        operator=operator.on(elements),
        distance=distance[elements] - (0.0 if by_force else distance[elements].min()),
        area=grid.area,
        force=given if by_force else None,
        approach=None if by_force else given,
    ).reachable()
