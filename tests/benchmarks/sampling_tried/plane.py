"""Rolling in the plane on dense matrices: linear tractions, computed pressures, second order in time.

Displacements are ``-int log|x - t| p(t) dt``, the contact is [-1, 1], the bound sqrt(1 - x^2). By Carter, where a part
F of what friction carries acts, ``p = sqrt(1 - x^2) - sqrt(b^2 - (x - d)^2)`` with d = 1 - b = 1 - sqrt(1 - F), and
the creepage is ``pi d``.
"""

import itertools
import math

import numpy as np

PARTS = (0.2, 0.6, 0.95)
FIRST = ((0, 1.0), (1, -1.0))
SECOND = ((-1, 5 / 24), (0, 21 / 24), (1, -33 / 24), (2, 7 / 24))
"""Differences over a strip: places ahead and weights."""


def _log(s: np.ndarray) -> np.ndarray:
    return np.log(np.abs(np.where(s == 0, 1.0, s)))


def constants(x: np.ndarray, h: float) -> np.ndarray:
    """Displacement at x by a unit traction on a strip of width h about 0."""
    ends = [s * _log(s) - s for s in (x + h / 2, x - h / 2)]
    return np.asarray(ends[1] - ends[0])


def hats(x: np.ndarray, h: float) -> np.ndarray:
    """The same by a hat of height 1 and half-width h."""
    ends = [s * s / 2 * _log(s) - 0.75 * s * s for s in (x + h, x, x - h)]
    return np.asarray(-(ends[0] - 2 * ends[1] + ends[2]) / h)


def hat_slopes(x: np.ndarray, h: float) -> np.ndarray:
    """Its derivative."""
    ends = [s * _log(s) - s for s in (x + h, x, x - h)]
    return np.asarray(-(ends[0] - 2 * ends[1] + ends[2]) / h)


def difference(kernel: np.ndarray, weights: tuple[tuple[int, float], ...]) -> np.ndarray:
    """Differences of a displacement that is given at the places -1, 0, 1 and 2 strips ahead."""
    return np.asarray(sum(weight * kernel[place + 1] for place, weight in weights))


def bounds(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Means of sqrt(1 - x^2) between places, of which the outer parts count as zero."""
    inner = [np.clip(each, -1, 1) for each in (left, right)]
    integrals = [(x * np.sqrt(1 - x * x) + np.arcsin(x)) / 2 for x in inner]
    return np.asarray((integrals[1] - integrals[0]) / (right - left))


def tractions(matrix: np.ndarray, known: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Tractions within the bound, either way, that oppose slip: by exchanges of elements."""
    side = np.zeros(bound.size)
    for _ in range(300):
        stick, p = side == 0, side * bound
        if stick.any():
            p[stick] = np.linalg.solve(
                matrix[np.ix_(stick, stick)], -known[stick] - matrix[np.ix_(stick, ~stick)] @ p[~stick]
            )
        slip, new = known + matrix @ p, side.copy()
        new[stick & (np.abs(p) > bound * (1 + 1e-10))] = np.sign(p)[stick & (np.abs(p) > bound * (1 + 1e-10))]
        new[side * slip > 1e-12] = 0
        if np.array_equal(new, side):
            return p
        side = new
    raise RuntimeError("the exchanges do not end")


def by_creepage(matrix: np.ndarray, bound: np.ndarray, h: float, part: float, soft: np.ndarray | None = None) -> float:
    """The error of the force by Carter's creepage, in per cent of the limit."""
    if soft is not None:
        matrix = matrix + np.diag(soft)
    creepage = math.pi * (1 - math.sqrt(1 - part))
    p = tractions(matrix, np.full(bound.size, -creepage), bound)
    return float(p.sum() * h / (math.pi / 2) - part) * 100


def linear() -> None:
    """Constants and hats by Carter's creepages: errors of the force at 20, 60 and 95 per cent of saturation."""
    for n in (20, 40, 80):
        h = 2 / n
        x, nodes = -1 + h * (np.arange(n) + 0.5), -1 + h * np.arange(1, n)
        apart, between = x[:, None] - x, nodes[:, None] - nodes
        bound = np.sqrt(1 - nodes**2)
        bound *= math.pi / 2 / (bound.sum() * h)
        ahead = [constants(apart + place * h, h) for place in (-1, 0, 1, 2)]
        also = [hats(between + place * h, h) for place in (-1, 0, 1, 2)]
        ways = {
            "constant, second order": (difference(np.array(ahead), SECOND) / h, bounds(x - h / 2, x + h / 2)),
            "hats, first order": (difference(np.array(also), FIRST) / h, bound),
            "hats, second order": (difference(np.array(also), SECOND) / h, bound),
            **{f"hats, {place} ahead": (-hat_slopes(between + place * h, h), bound) for place in (0.5, 0.8, 0.9)},
        }
        for name, (matrix, limit) in ways.items():
            print(f"{n} {name:24s} " + "/".join(f"{by_creepage(matrix, limit, h, part):.2f}" for part in PARTS))


def pressed(count: int, offset: float) -> tuple[np.ndarray, np.ndarray]:
    """Places and pressures of strips, `count` across the contact, on a lattice that lies off by a part of a strip."""
    h = 2 / count
    x = (np.arange(-count // 2 - 3, count // 2 + 4) + 0.5 + offset) * h
    matrix, contact = constants(x[:, None] - x, h), np.abs(x) < 1 + h
    while True:
        n, p = int(contact.sum()), np.zeros(x.size)
        system = np.zeros((n + 1, n + 1))
        system[:n, :n], system[:n, n], system[n, :n] = matrix[np.ix_(contact, contact)], -1, h
        found = np.linalg.solve(system, [*(-math.pi * x[contact] ** 2 / 2), math.pi / 2])
        p[contact] = found[:n]
        if (p[contact] <= 0).any():
            contact = contact & (p > 0)
            continue
        gap = matrix @ p - found[n] + math.pi * x**2 / 2
        if not ((gap < -1e-12) & ~contact).any():
            return x, p
        contact = contact | (gap < -1e-12)


def covered(x: np.ndarray, p: np.ndarray, h: float) -> np.ndarray:
    """Which part of each strip is covered, estimated from the squares of the pressures inside."""
    share, inside = (p > 0).astype(float), np.flatnonzero(p > 0)
    for strips, side in ((inside[:4], -1), (inside[-4:][::-1], 1)):
        places, squares = side * x[strips], p[strips] ** 2
        roots = np.roots(np.polyfit(places[1:] - places[1], squares[1:], 2))
        real = roots[np.isreal(roots)].real
        share[strips[0]] = (places[1] + real[real > 0].min() - places[0]) / h + 0.5
    return share


def strips() -> None:
    """Computed pressures on strips that are shifted by eighths: p^2, and forces at 60 per cent of saturation."""
    for count in (16, 32, 64):
        h, rows = 2 / count, []
        for offset in np.arange(8) / 8:
            x, p = pressed(count, offset)
            contact = p > 0
            apart = x[contact][:, None] - x[contact]
            matrix = difference(np.array([constants(apart + place * h, h) for place in (-1, 0, 1, 2)]), SECOND) / h
            share = covered(x, p, h)
            known = np.clip((np.minimum(x + h / 2, 1) - np.maximum(x - h / 2, -1)) / h, 0, 1)
            soft = 1.6 * (np.maximum(share[contact], 0.3) ** -1.5 - 1) * matrix[0, 0]
            edge = np.flatnonzero(contact)[[0, -1]]
            off = (share - known)[edge]
            off = np.where(share[edge] > 1, share[edge] - 1 - known[edge - [1, -1]], off)
            forces = [by_creepage(matrix, p[contact], h, 0.6, each) for each in (None, soft, np.maximum(soft, 0))]
            rows.append([(np.sum(p**2) * h / (4 / 3) - 1) * 100, *off, *forces])
        found = np.array(rows)
        names = ("p^2, per cent", "covered, behind", "covered, ahead", "force", "with the estimate", "softened only")
        print(f"{count} strips: " + "; ".join(
            f"{name} {low:.2f} to {high:.2f}" for name, low, high in zip(names, found.min(0), found.max(0), strict=True)
        ))  # fmt: skip


def march(n: int, step: float, second: bool, turn: bool) -> np.ndarray:
    """Force at times 0.4, 0.8, ... 2.4 from rest, by the limit; with `turn` the creepage changes sign at 1.2."""
    h = 2 / n
    x = -1 + h * (np.arange(n) + 0.5)
    apart = x[:, None] - x
    matrices = [constants(apart + k * step, h) + 6 * h for k in range(3)]  # a constant: the depth of the reference
    bound, creepage = bounds(x - h / 2, x + h / 2), math.pi * (1 - math.sqrt(0.4))
    before = earlier = np.zeros(n)
    forces = []
    for k in range(round(2.4 / step)):
        rigid = np.full(n, step * creepage * (-1 if not turn or k < round(1.2 / step) else 1))
        if second and k > 0:
            p = tractions(1.5 * matrices[0], rigid - 2 * matrices[1] @ before + 0.5 * matrices[2] @ earlier, bound)
        else:
            p = tractions(matrices[0], rigid - matrices[1] @ before, bound)
        earlier, before = before, p
        forces.append(p.sum() * h / (math.pi / 2))
    every = round(0.4 / step)
    return np.array(forces)[every - 1 :: every]


def in_time() -> None:
    """Histories from rest: differences over one step and over two, in per cent of the limit."""
    for turn, step in itertools.product((False, True), (0.2,)):
        limits = [march(n, 2 / n, False, turn) for n in (160, 320)]
        short = 2 * limits[1] - limits[0]
        same = march(320, step, False, turn)
        print(f"turn: {turn}; limit of these steps less that of short ones", np.round(100 * (same - short), 2))
        print("    over two steps less over one, 320 strips", np.round(100 * (march(320, step, True, turn) - same), 2))
        print("    one step, 20 strips", np.round(100 * (march(20, step, False, turn) - same), 2))
        for n in (80,):
            for second in (False, True):
                off = np.round(100 * (march(n, 2 / n, second, turn) - short), 2)
                print(f"    steps of a strip, {n} strips, over {'two steps' if second else 'one step'}", off)
