"""The symmetric part: found positive definite where it is, and only there; energies and least
eigenvalue bounded.
"""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene
from varcontact.discrete import positive_definite as module
from varcontact.discrete.positive_definite import norm, positive_definite
from varcontact.discrete.problems import FoldedOperator
from varcontact.elasticity.operators import influence_operator

DENSE, BY_FFT = 10**9, 0


def operator(dx, part, cells=12, nu=0.28):
    """Of rolling in steps of a part of the element, or without steps, on a full grid."""
    grid = vc.Grid(nx=cells, ny=cells, dx=dx, dy=1.0, x0=0.0, y0=0.0)
    lag = None if part is None else part * dx
    return influence_operator(grid, "xy", "xy", nu=nu, lag=lag).on(np.arange(cells * cells))


def on_ellipse(ratio, nu, cells, part):
    """Of rolling on an ellipse with the axes a/b = ratio, so many cells across either way."""
    a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)
    grid = vc.Grid(nx=cells, ny=cells, margin=0).spread((-a, a, -b, b))
    inside = (grid.x[None, :] / a) ** 2 + (grid.y[:, None] / b) ** 2 < 1
    table = influence_operator(grid, "xy", "xy", nu=nu, lag=part * grid.sides[0])
    return table.on(np.flatnonzero(inside.ravel()))


def dense(M):
    return (M.matrix + M.matrix.T) / 2


NAMED = [(1.0, 0.5, 42, 0.2146), (1.5, 0.28, 42, 0.3854)]
"""Meshes whose negative direction is orthogonal to both forces and the moment, from where it cannot
be found."""


def has_factor(matrix):
    """Whether Cholesky's factor of a symmetric matrix exists: the judge that is not the code's
    own.
    """
    try:
        np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:
        return False
    return True


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "nu", "cells", "part"), NAMED)
def test_a_negative_direction_that_no_force_sees(ratio, nu, cells, part):
    """Beyond `DENSE_LIMIT` elements, with one eigenvalue of -1e-8 or so: not taken for positive
    definite.
    """
    M = on_ellipse(ratio, nu, cells, part)
    assert M.elements.size > module.DENSE_LIMIT
    assert not has_factor(dense(M))
    assert positive_definite(M) is None


@pytest.mark.long
@pytest.mark.parametrize(("ratio", "nu", "part"), [(1.5, 0.28, 0.4)])
def test_barely_positive_definite(ratio, nu, part):
    """The same contacts in slightly longer steps: positive definite, and found to be, with a least
    eigenvalue.
    """
    M = on_ellipse(ratio, nu, 42, part)
    assert M.elements.size > module.DENSE_LIMIT
    found = positive_definite(M)
    assert 0 < found.least < 1e-4 * norm(M.grid_operator)
    assert has_factor(dense(M) - found.least * np.eye(2 * M.elements.size)), (
        "the least eigenvalue is no less"
    )


@pytest.mark.parametrize(("dx", "part"), [(3.0, 0.1), (5.0, 0.2), (10.0, 0.4)])
@pytest.mark.parametrize("limit", [DENSE, BY_FFT])
def test_not_positive_definite(dx, part, limit):
    M = operator(dx, part)
    assert np.linalg.eigvalsh(dense(M))[0] < 0
    assert positive_definite(M, limit) is None


@pytest.mark.parametrize("part", [1.0, 0.3, None])
@pytest.mark.parametrize("limit", [DENSE, BY_FFT])
def test_bounds_hold_and_are_near(part, limit):
    """Energies from above, within a thousandth; the least eigenvalue from below, within a factor of
    twenty.
    """
    M = operator(1.0, part)
    right = np.random.default_rng(1).normal(size=(3, 2, M.elements.size))
    right[0], right[1] = 1.0, 0.0
    expected = np.sum(
        right.reshape(3, -1).T * np.linalg.solve(dense(M), right.reshape(3, -1).T), axis=0
    )
    found = positive_definite(M, limit)
    energies = found.energies(right)
    assert energies[1] == 0
    assert np.all(energies >= expected * (1 - 1e-12))
    assert np.all(energies <= expected * (1 + module.SLACK))
    true = np.linalg.eigvalsh(dense(M))[0]
    assert 0.05 * true < found.least <= true


def test_one_square_element_has_its_own_influence_number():
    """xx and yy are equal and do not couple: the bounds of the dense factor are exact."""
    M = operator(1.0, None, cells=1)
    own = M.matrix[0, 0]
    found = positive_definite(M, DENSE)
    assert found.least == pytest.approx(own, rel=1e-14)
    assert found.energies(np.array([[[3.0], [4.0]]])) == pytest.approx([25 / own], rel=1e-14)


def test_a_positive_symbol_needs_no_chance(monkeypatch):
    """Without rolling the symbol itself is positive: nothing is random, and the least eigenvalue is
    nearly met.
    """

    def refuse(*_):
        raise AssertionError("a random start was made")

    monkeypatch.setattr(np.random, "default_rng", refuse)
    M = operator(1.0, None, cells=20)
    true = np.linalg.eigvalsh(dense(M))[0]
    assert 0.9 * true < positive_definite(M, BY_FFT).least <= true


def test_half_of_a_problem():
    """On one side of a line of symmetry, with the images' tractions, as by the dense matrix of
    that.
    """
    whole = operator(1.0, 1.0, cells=10)
    half = np.arange(50, 100)
    images = (9 - half // 10) * 10 + half % 10
    for signs in ((1.0, -1.0), (-1.0, 1.0)):
        M = FoldedOperator(whole.grid_operator, half, images, signs)
        right = np.random.default_rng(2).normal(size=(1, 2, 50))
        expected = right.ravel() @ np.linalg.solve(dense(M), right.ravel())
        for limit in (DENSE, BY_FFT):
            found = positive_definite(M, limit)
            assert (
                expected * (1 - 1e-12) <= found.energies(right)[0] <= expected * (1 + module.SLACK)
            )
            assert found.least <= np.linalg.eigvalsh(dense(M))[0]


@pytest.mark.long
def test_many_elements_need_no_matrix(monkeypatch):
    """Whether rolling on 2812 elements is monotone, told without a dense matrix."""

    def refuse(*_):
        raise AssertionError("a dense matrix was assembled")

    M = on_ellipse(1.0, 0.28, 60, 1.0)
    assert M.elements.size > 2 * module.DENSE_LIMIT
    monkeypatch.setattr("varcontact.elasticity.operators.GridOperator.dense", refuse)
    assert positive_definite(M).least > 0
    assert positive_definite(dataclasses.replace(M, elements=M.elements[::2])) is not None, (
        "a part of it is, too"
    )


def test_softened_elements():
    """A few elements that give way twenty times as much as others: by FFT as by the factor, in no
    more products.
    """
    M = operator(1.0, 1.0, cells=16)
    softening = np.zeros((2, M.elements.size))
    softening[:, ::7] = 20 * M.matrix[0, 0]
    soft = dataclasses.replace(M, softening=softening)
    right = np.random.default_rng(1).normal(size=(2, 2, M.elements.size))
    by_factor, by_fft = (positive_definite(soft, limit) for limit in (DENSE, BY_FFT))
    assert 0 < by_fft.least <= np.linalg.eigvalsh(dense(soft))[0]
    energies = by_factor.energies(right)
    assert np.all(energies <= by_fft.energies(right)) and np.all(
        by_fft.energies(right) <= 1.001 * energies
    )


@pytest.mark.long
@pytest.mark.parametrize("cells", [(32, 21), (48, 32), (60, 60)])
def test_bounds_of_the_second_order_scheme(cells):
    scene = make_scene(
        vc.Ellipse(1.2, 0.9), motion=vc.Steady(vx=0.1, spin=0.1), grid=vc.Grid(*cells)
    )
    sol = vc.solve(scene.second_order(), certify="full")
    assert np.all(sol.certificate.force_bound < 1e-6)
