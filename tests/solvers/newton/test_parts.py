"""The parts of Newton's method without a matrix, each against a dense computation."""

import numpy as np
import pytest

from varcontact.elasticity.operators import influence_operator
from varcontact.scene.grid import Grid
from varcontact.solvers.newton.driver import point
from varcontact.solvers.newton.gcr import Forces, gcr, room_for
from varcontact.solvers.newton.hierarchy import Box, doubled, halved, halved_mean
from varcontact.solvers.newton.kernel import kernel, parzen, unit
from varcontact.solvers.newton.tangential import ScaledTangential


@pytest.fixture(params=["ellipse", "strip", "row", "single"])
def scaled(request, tangential_problem):
    """A tangential problem of rolling with a prescribed force, in its own units."""
    problem = tangential_problem(
        3, shape=request.param, rolling=True, step=1.0, carried=0.5, friction=0.3
    )
    return ScaledTangential.of(problem)


def matrix_of(conditions):
    """M as the kernel has it, on the whole box."""
    size = conditions.known.size
    fields = np.eye(size, dtype=np.float32).reshape(size, *conditions.known.shape)
    return np.array([conditions.kernel(field).ravel() for field in fields]).T.astype(float)


def test_products_are_those_of_the_matrix(scaled):
    """Of the operator, in its unit, to single precision."""
    conditions, operator = scaled.conditions, scaled.problem.operator.grid_operator
    rng = np.random.default_rng(0)
    traction = rng.normal(size=scaled.problem.rigid_shift.shape)
    found = scaled.box.values(
        conditions.kernel(scaled.box.field(traction).astype(np.float32))
    ) * unit(operator)
    np.testing.assert_allclose(
        found, scaled.problem.operator.apply(traction), atol=2e-6 * np.abs(found).max()
    )
    assert kernel(operator, scaled.box.shape) is conditions.kernel, "remembered"


def test_newtons_equations_are_the_derivative_of_the_natural_map(scaled):
    """By differences, and with their right-hand sides Newton's step."""
    conditions, rng = scaled.conditions, np.random.default_rng(1)
    matrix = matrix_of(conditions)
    traction = conditions.projected(rng.normal(size=conditions.known.shape))
    step = rng.normal(size=traction.shape) * conditions.contact

    def natural(traction):
        shift = conditions.known + (matrix @ traction.ravel()).reshape(traction.shape)
        return traction - conditions.projected(traction - shift), shift

    error, shift = natural(traction)
    system = conditions.linearised(traction, shift, traction - shift)
    change = (natural(traction + 1e-7 * step)[0] - natural(traction - 1e-7 * step)[0]) / 2e-7
    image = (matrix @ step.ravel()).reshape(step.shape)
    np.testing.assert_allclose(system.rows(image, step), change, atol=1e-4 * np.abs(change).max())
    np.testing.assert_allclose(system.right, -error * conditions.contact, atol=1e-12)
    for i in range(len(traction)):
        uniform = np.zeros_like(traction)
        uniform[i] = 1.0
        np.testing.assert_allclose(
            system.border(i), system.rows(uniform, 0 * uniform) * conditions.contact, atol=1e-6
        )


def test_gcr_solves_newtons_equations_with_forces(scaled):
    """Against the dense system; M times the step comes without a product."""
    conditions, rng = scaled.conditions, np.random.default_rng(2)
    at = point(
        conditions,
        conditions.projected(rng.normal(size=conditions.known.shape)),
        np.zeros((len(conditions.known), 1, 1)),
    )
    system = conditions.linearised(at.traction, at.shift, at.traction - at.shift)
    forces = conditions.forces
    step = gcr(
        system,
        conditions.kernel,
        forces,
        forces.lacking(at.traction),
        1e-4,
        room_for(at.traction.size, forces),
    )
    image = conditions.kernel(step.traction.astype(np.float32))
    np.testing.assert_allclose(
        step.shift, image + step.rigid, atol=1e-4 * max(np.abs(image).max(), 1e-3)
    )
    rows = system.rows(image.astype(float), step.traction)
    for i in forces.components:
        rows = rows + step.rigid[i] * system.border(i)
    size = np.linalg.norm(system.right)
    assert np.linalg.norm((rows - system.right) * conditions.contact) < 2e-3 * size
    assert np.abs(forces.lacking(at.traction + step.traction)).max(initial=0.0) < 2e-3 * size


def test_few_iterations_where_all_sticks(tangential_problem):
    """In rolling and in a shift, on long elements and short ones: the circulant is nearly the
    inverse.
    """
    for ratio, rolling in ((1, True), (1, False), (2, True), (3, True)):
        scaled = ScaledTangential.of(
            tangential_problem(
                ratio, shape="needle", rolling=rolling, step=1.0, no_slip=True, carried=0.0
            )
        )
        conditions = scaled.conditions
        system = conditions.linearised(0 * conditions.known, conditions.known, -conditions.known)
        none = Forces((), np.zeros(0), 1.0)
        room = [each[:8] for each in room_for(system.right.size, none)]
        step = gcr(system, conditions.kernel, none, np.zeros(0), 1e-2, room)
        left = (
            system.rows(conditions.kernel(step.traction.astype(np.float32)), step.traction)
            - system.right
        )
        assert np.linalg.norm(left) <= 1.1e-2 * np.linalg.norm(system.right)


def test_from_coarse_to_fine():
    """Means over two by two; what is linear stays so, next to elements out of contact, too."""
    field = np.arange(15.0).reshape(3, 5)
    assert 4 * halved(field).sum() == field.sum() and halved(field).shape == (2, 3)
    contact = np.ones((6, 8), dtype=bool)
    contact[0] = False
    x = np.broadcast_to(np.arange(8.0), (6, 8))
    means = halved_mean(x, contact)
    np.testing.assert_array_equal(means, np.broadcast_to([0.5, 2.5, 4.5, 6.5], (3, 4)))
    fine = doubled(means, halved(contact.astype(float)) > 0, (6, 8))
    np.testing.assert_allclose(fine[:, 1:-1], x[:, 1:-1])
    reached = doubled(np.ones((2, 2)), np.array([[True, False], [True, True]]), (3, 4))
    np.testing.assert_array_equal(
        reached == 0, [[False, False, False, True], [False] * 4, [False] * 4]
    )
    np.testing.assert_array_equal(reached[reached != 0], 1.0)


@pytest.mark.parametrize("box", [(1, 33), (12, 33)])
def test_elements_of_twice_the_size(box):
    """Their kernel is that of a lattice of them but for means over elements: also of logarithms."""

    def operator(dx, shape):
        along_y = {"ny": shape[0], "dy": dx, "y0": 0.0} if box[0] > 1 else {}
        return influence_operator(
            Grid(nx=shape[1], dx=dx, x0=0.0, **along_y), "xy", "xy", nu=0.3, depth=50.0
        )

    fine, coarse = operator(0.1, (box[0] * 2 - (box[0] == 1), 66)), operator(0.2, box)
    found = kernel(fine, fine.shape).halved.numbers * unit(fine) * 2
    exact = kernel(coarse, box).numbers * unit(coarse)
    apart = np.abs(np.indices(exact.shape[1:]) - np.reshape(box, (2, 1, 1)) + 1).max(axis=0)
    for least, share in ((0, 0.11), (2, 2e-3), (5, 2e-4)):
        errors = np.abs(found - exact)[:, apart >= least]
        assert errors.max() < share * np.abs(exact).max()


def test_the_window_keeps_the_symbol_positive(tangential_problem):
    """Of a shift, on long elements, where the cut kernel's symbol is negative; and it is one in the
    middle.
    """
    problem = tangential_problem(1, shape="needle", rolling=False)
    symbol = kernel(
        problem.operator.grid_operator, Box.around(problem.operator).shape
    ).circulant.symbol.real
    assert symbol[0].min() > 0 and symbol[2].min() > 0
    np.testing.assert_allclose(parzen(np.array([0.0, 0.5, 1.0, -0.5])), [1.0, 0.25, 0.0, 0.25])
    assert not kernel(
        problem.operator.grid_operator, problem.operator.grid_operator.shape
    ).circulant.rolling
    rolling = tangential_problem(1, shape="needle", rolling=True, step=1.0).operator.grid_operator
    assert kernel(rolling, rolling.shape).circulant.rolling == 1
