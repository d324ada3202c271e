"""Solvers of a user, as the page on programs has them; and all that can be wrong with one."""

import time
from types import SimpleNamespace

import numpy as np

from varcontact.energy import tangential_residual
from varcontact.solvers.active_set.norm import norm
from varcontact.solvers.active_set.tang import tang_safeguarded


def admm(problem, settings, start):
    from scipy.linalg import lu_factor, lu_solve

    matrix = problem.operator.matrix
    weight = problem.operator.row_size
    factors = lu_factor(matrix + weight * np.eye(len(matrix)))
    known = np.zeros(problem.components)
    traction = dual = np.zeros_like(problem.rigid_shift)
    while tangential_residual(problem, traction, known) > settings.tol:
        right = weight * (traction - dual) - problem.rigid_shift
        free = lu_solve(factors, right.ravel()).reshape(right.shape)
        traction = problem.potential.projected(free + dual, weight)
        dual = dual + free - traction
    return traction


def active_sets(problem, settings, start):
    """Ours, in the place of a user's: it takes every problem."""
    if hasattr(problem, "distance"):
        return norm(problem, start, deadline=settings.deadline)
    return tang_safeguarded(problem, start, settings=settings)


def pressures(problem, settings, start):
    """NORM without its approach."""
    return norm(problem).traction


class Odd(Exception):
    def __str__(self):
        raise RuntimeError("no words")


def raising(error):
    def solve(problem, settings, start):
        raise error

    return solve


def returning(value):
    """The same for any problem, or what a function makes of the right shape."""

    def solve(problem, settings, start):
        shape = (
            problem.distance.shape if hasattr(problem, "distance") else problem.rigid_shift.shape
        )
        return value(shape) if callable(value) else value

    return solve


def overwriting(problem, settings, start):
    field = problem.distance if hasattr(problem, "distance") else problem.rigid_shift
    field[...] = 0.0
    return returning(np.zeros)(problem, settings, start)


def unlocking(problem, settings, start):
    """Whoever unlocks the arrays has a copy of his own."""
    for field in (
        problem.operator.grid_operator.table,
        getattr(problem, "distance", None),
        getattr(problem, "rigid_shift", None),
    ):
        if field is not None:
            field.flags.writeable = True
            field[...] = 0.0
    problem.operator.matrix[...] = 0.0
    return returning(np.ones)(problem, settings, start)


def endless(problem, settings, start):
    while True:
        time.sleep(0.01)


RAGGED = SimpleNamespace(__array__=lambda *_: 1 / 0)
BAD = {
    "raises": (
        raising(ValueError("a singular matrix\nand more")),
        "it raised ValueError: a singular matrix",
    ),
    "exits": (raising(SystemExit(3)), "it raised SystemExit"),
    "interrupts itself": (raising(KeyboardInterrupt()), "it raised KeyboardInterrupt"),
    "raises without words": (raising(Odd()), "it raised Odd"),
    "nothing": (returning(None), "it returned None"),
    "a word": (returning("Solved"), "it returned 'Solved'"),
    "an object": (returning(RAGGED), "it returned"),
    "complex": (returning(lambda shape: np.ones(shape, complex)), "it returned array"),
    "wrong shape": (returning(lambda shape: np.ones((*shape, 2))), "of shape"),
    "too few": (returning(np.ones(3)), "of shape (3,)"),
    "three things": (returning((1, 2, 3)), "it returned"),
    "NaN": (returning(lambda shape: np.full(shape, np.nan)), "not finite"),
    "infinite": (returning(lambda shape: np.full(shape, np.inf)), "not finite"),
    "huge": (returning(lambda shape: np.full(shape, 1e200)), "out of range"),
    "changes its input": (overwriting, "it raised ValueError"),
}
"""Solvers, and what is said of them."""
NONSENSE = {
    "ones": returning(np.ones),
    "noise": returning(lambda shape: np.random.default_rng(0).normal(size=shape)),
    "negative": returning(lambda shape: -np.ones(shape)),
    "zeros": returning(np.zeros),
    "unlocks": unlocking,
}
"""Solvers that return numbers, which are no answer."""
