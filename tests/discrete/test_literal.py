"""Certificates to the letter: gap, bounds and errors of twenty solutions again, in fifty digits.

The discrete problem is that of the influence numbers as they are stored. Everything after them is
computed here by mpmath, without a line of the package: products, lengths, the exact solution.
"""

import dataclasses

import mpmath
import numpy as np
import pytest

import varcontact as vc
from varcontact import energy
from varcontact.discrete.certificate import force_bound, outputs_of, pressure_error
from varcontact.discrete.positive_definite import positive_definite

GAP_ROUNDING = 16 * np.finfo(float).eps
"""By which a gap may miss that of its tractions, relative to the work of the full bound: as
docs/proofs.md says."""
BASE = vc.Scene(
    bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.2, b=0.9), normal_force=1.0, friction=0.3,
    motion=vc.Steady(vx=0.04, vy=-0.02, spin=0.05), grid=vc.Grid(nx=7, ny=6),
)  # fmt: skip
LINE = {"surface": vc.Cylinders(R=1.0, reference_depth=20.0), "grid": vc.Grid(nx=24)}
MOTIONS = {
    "rolling": {},
    "full slip": {"motion": vc.Steady(vx=0.4)},
    "rolling, force": {"motion": vc.Steady(Fx=-0.1)},
    "shift": {"motion": vc.Shift(ux=0.1, uy=-0.06)},
    "shift, forces": {"motion": vc.Shift(Fx=-0.1, Fy=0.05)},
    "line": {"motion": vc.Steady(vx=0.02), **LINE},
    "line, shift": {"motion": vc.Shift(ux=0.02), **LINE},
}
METHODS = {
    "default": {},
    "newton": {"tangential": "newton"},
    "rough": {"tangential": "clarabel", "polish": False, "tol": 1e-5},
}
TANGENTIAL = [(motion, method) for motion in MOTIONS for method in METHODS]
NORMAL = {
    "force": {},
    "approach": {"normal_force": None, "approach": 0.5},
}


@pytest.fixture(autouse=True)
def fifty_digits():
    with mpmath.workdps(50):
        yield


exact = np.vectorize(mpmath.mpf, otypes=[object])
root = np.vectorize(mpmath.sqrt, otypes=[object])


def length(vectors):
    return root((vectors * vectors).sum(axis=0))


def floats(values):
    return np.asarray(values, dtype=float)


def solved(matrix, refined, right):
    """``matrix^-1 right`` by refinement, until fifty digits are right."""
    x = exact(np.zeros(len(right)))
    for _ in range(6):
        x = x + exact(np.linalg.solve(matrix, floats(right - refined @ x)))
    assert max(abs(right - refined @ x)) < 1e-40
    return x


def solution_of(scene, **methods):
    try:
        return vc.solve(scene, normal="hertz", **methods)
    except vc.NotConverged as failure:
        return failure.solution


class Exact:
    """A tangential problem without a flow, in fifty digits."""

    def __init__(self, problem):
        self.problem = problem
        self.M = exact(problem.operator.matrix)
        self.W = exact(problem.rigid_shift)
        self.g = exact(problem.bound)

    def shift(self, traction, rigid):
        elastic = (self.M @ traction.ravel()).reshape(traction.shape)
        return elastic + self.W + rigid[:, None]

    def gap(self, traction, rigid):
        shift = self.shift(traction, rigid)
        return (self.g * length(shift)).sum() + (traction * shift).sum()

    def natural_map(self, traction, rigid):
        problem = self.problem
        trial = traction - self.shift(traction, rigid) / exact(problem.operator.diagonal)
        size = length(trial)
        slips = floats(size) > problem.bound
        direction = trial / np.where(slips, size, exact(1.0))
        image = np.where(slips, self.g * direction, trial)
        sums = [
            traction[i].sum() - exact(problem.force[i]) / exact(problem.area) for i in problem.free
        ]
        return (
            traction - image,
            np.array(sums, dtype=object),
            slips,
            floats(direction),
            floats(size),
        )

    def solution(self, traction, rigid):
        """The exact one, by Newton's steps with derivatives in double precision."""
        problem = self.problem
        c, n = traction.shape
        own = problem.operator.diagonal
        matrix = problem.operator.matrix
        uniform = np.kron(np.eye(c)[:, problem.free], np.ones((n, 1)))
        for _ in range(30):
            lacking, sums, slips, direction, size = self.natural_map(traction, rigid)
            right = np.concatenate([lacking.ravel(), sums])
            if max(abs(right)) < 1e-42:
                return traction, rigid
            of_trial = np.hstack([np.eye(c * n) - matrix / own, -uniform / own])
            of_image = of_trial.copy()
            for i in np.flatnonzero(slips):
                rows = i + n * np.arange(c)
                across = np.eye(c) - np.outer(direction[:, i], direction[:, i])
                of_image[rows] = problem.bound[i] / size[i] * across @ of_trial[rows]
            jacobian = np.hstack([np.eye(c * n), np.zeros(uniform.shape)]) - of_image
            jacobian = np.vstack([jacobian, np.hstack([uniform.T, np.zeros((len(sums),) * 2)])])
            step = exact(np.linalg.solve(jacobian, floats(right)))
            traction = traction - step[: c * n].reshape(c, n)
            rigid = rigid.copy()
            rigid[problem.free] = rigid[problem.free] - step[c * n :]
        raise AssertionError("no exact solution")


@pytest.mark.long
@pytest.mark.parametrize(("motion", "method"), TANGENTIAL)
def test_tractions(motion, method):
    scene = dataclasses.replace(BASE, **MOTIONS[motion])
    sol = solution_of(scene, **METHODS[method])
    posed = energy.posed(sol)
    problem = posed.tangential
    literal = Exact(problem)
    work = float((literal.g * length(literal.W + exact(posed.rigid)[:, None])).sum())

    # the gap
    admissible = posed.traction * np.minimum(
        1.0, problem.bound / np.maximum(np.linalg.norm(posed.traction, axis=0), 1e-300)
    )
    gap = float(literal.gap(exact(admissible), exact(posed.rigid)))
    reported = sol.certificate.gap / posed.unit / problem.area
    assert gap > -1e-45
    assert abs(reported - gap) <= GAP_ROUNDING * work
    np.testing.assert_allclose(
        sol.certificate.relative_gap, gap / work, atol=GAP_ROUNDING, rtol=1e-9
    )

    # energies of the outputs, which are upper bounds
    outputs = outputs_of(problem)
    symmetric = (problem.operator.matrix + problem.operator.matrix.T) / 2
    precise = (literal.M + literal.M.T) / exact(2.0)
    energies = problem.symmetric_part.energies(outputs)
    for output, bound in zip(outputs.reshape(3, -1), energies, strict=True):
        if output.any():
            own = (exact(output) * solved(symmetric, precise, exact(output))).sum()
            assert own <= bound <= own * (1 + 1e-9)
    least = np.linalg.eigvalsh(symmetric)[0]
    assert problem.symmetric_part.least < least

    # the errors of the forces, which the bounds exceed
    start = solution_of(scene, tangential="tang-safeguarded", tol=1e-12)
    found = energy.posed(start)
    traction, _ = literal.solution(exact(found.traction), exact(found.rigid))
    difference = exact(posed.traction) - traction
    errors = [abs((exact(output) * difference).sum()) * exact(problem.area) for output in outputs]
    bounds = force_bound(problem, posed.traction, posed.rigid)
    assert all(error <= bound for error, bound in zip(errors, bounds, strict=True))
    # and energy by the gap, as the theorem has it
    distance = (difference.ravel() * (precise @ difference.ravel())).sum()
    if not problem.free:
        assert distance <= gap + 4 * GAP_ROUNDING * work


@pytest.mark.parametrize("load", NORMAL)
@pytest.mark.parametrize("rough", [False, True])
def test_pressures(load, rough):
    """Gap, residual and bound on the error of a pressure, against the exact one."""
    scene = dataclasses.replace(BASE, motion=None, friction=None, **NORMAL[load])
    sol = vc.solve(scene, normal="norm")
    posed = energy.posed(sol)
    problem = posed.normal
    A = problem.operator.matrix
    precise = exact(A)
    # the exact pressure, on the elements in contact
    contact = np.flatnonzero(posed.pressure)
    system = A[np.ix_(contact, contact)]
    right = -exact(problem.distance[contact])
    if problem.force is None:
        right = right + exact(problem.approach)
    else:
        ones = np.ones((contact.size, 1))
        system = np.block([[system, -ones], [ones.T, np.zeros((1, 1))]])
        right = np.append(right, exact(problem.force) / exact(problem.area))
    unknowns = solved(system, exact(system), right)
    true = exact(np.zeros(A.shape[0]))
    true[contact] = unknowns[: contact.size]
    approach = exact(problem.approach) if problem.force is None else unknowns[-1]
    distance = exact(problem.distance) - approach + precise @ true
    assert all(true >= 0)
    assert all(distance[np.setdiff1d(np.arange(true.size), contact)] > 0)

    pressure = posed.pressure
    level = float(posed.approach[0])
    if rough:  # a pressure that is wrong by 1e-4
        pressure = pressure * (1 + 1e-4 * np.cos(np.arange(pressure.size)))
    difference = exact(pressure) - true
    error, possible = pressure_error(problem, pressure, level)
    assert root((difference * difference).sum()) <= error
    assert possible[contact].all()
    if problem.force is not None:
        pressure = pressure * (problem.force / problem.area / pressure.sum())
    gap = energy.normal_gap(problem, pressure, np.array([level]))[0] / problem.area
    difference = exact(pressure) - true
    stored = float((exact(pressure) * (precise @ exact(pressure))).sum())
    distance = (difference * (precise @ difference)).sum()
    assert distance <= gap + GAP_ROUNDING * stored
    assert positive_definite(problem.operator).least < np.linalg.eigvalsh(A)[0]
