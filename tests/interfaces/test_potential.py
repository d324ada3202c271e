"""What solvers rely on in every potential: a proximal map, its derivative, and shares of the
gap.
"""

import numpy as np
import pytest

from varcontact.interfaces.potential import Flow, FlowDerivative, Potential, magnitude, project

N = 200


def potentials(rng):
    """A disk, an interval's radius of zero and infinity, a flow that starts below and above the
    bound.
    """
    bound = rng.uniform(0.1, 1.0, N)
    threshold = rng.uniform(0.0, 1.5, N)
    return {
        "disk": Potential(bound),
        "no slip": Potential(np.full(N, np.inf)),
        "flow": Potential(bound, Flow(threshold, hardening=0.7)),
        "flow alone": Potential(np.full(N, np.inf), Flow(threshold, hardening=0.2)),
    }


KINDS = tuple(potentials(np.random.default_rng(0)))


@pytest.mark.parametrize("components", [1, 2])
@pytest.mark.parametrize("weight", [0.3, 2.0])
@pytest.mark.parametrize("kind", KINDS)
def test_proximal_maps_are_firmly_non_expansive(kind, weight, components):
    """``|P a - P b|^2 <= (P a - P b)'(a - b)``, element by element."""
    rng = np.random.default_rng(1)
    potential = potentials(rng)[kind]
    one, other = rng.normal(size=(2, components, N))
    step = potential.projected(one, weight) - potential.projected(other, weight)
    assert np.all(np.sum(step * (one - other - step), axis=0) >= -1e-14)


@pytest.mark.parametrize("kind", ["disk", "no slip"])
def test_projections_are_idempotent(kind):
    rng = np.random.default_rng(2)
    potential = potentials(rng)[kind]
    once = potential.projected(rng.normal(size=(2, N)), 1.0)
    np.testing.assert_allclose(potential.projected(once, 1.0), once, rtol=1e-15)


@pytest.mark.parametrize("weight", [0.3, 2.0])
@pytest.mark.parametrize("kind", KINDS)
def test_images_solve_the_inclusion(kind, weight):
    """p = P(y) has ``weight (y - p)`` in d phi(p): its share of the gap, with that as ``-E``, is
    zero.
    """
    rng = np.random.default_rng(3)
    potential = potentials(rng)[kind]
    trial = rng.normal(size=(2, N))
    image = potential.projected(trial, weight)
    shift = weight * (image - trial)
    if kind == "no slip":
        np.testing.assert_array_equal(shift, 0.0)
    else:
        np.testing.assert_allclose(potential.shares(image, shift), 0.0, atol=1e-14)


@pytest.mark.parametrize("kind", ["disk", "flow"])
def test_shares_are_the_gap_without_cancellation(kind):
    """``p'E + phi(p) + phi*(-E)`` by its definition, the conjugate by a search over sizes of
    tractions.
    """
    rng = np.random.default_rng(4)
    potential = potentials(rng)[kind]
    traction = potential.projected(rng.normal(size=(2, N)), np.inf)
    shift = rng.normal(size=(2, N))
    sizes = potential.bound * np.linspace(0.0, 1.0, 20_001)[:, None]

    def value(size):
        if potential.flow is None:
            return 0.0 * size
        return np.maximum(size - potential.flow.threshold, 0.0) ** 2 / (
            2 * potential.flow.hardening
        )

    conjugate = (sizes * magnitude(shift) - value(sizes)).max(axis=0)
    gap = np.sum(traction * shift, axis=0) + value(magnitude(traction)) + conjugate
    np.testing.assert_allclose(potential.shares(traction, shift), gap, atol=1e-8)


def test_derivatives_of_a_flow_are_its_differences():
    """Also where the threshold is what other particles have left along the row."""
    rng = np.random.default_rng(5)
    shape = (4, 9)
    flow = Flow(np.full(shape, 0.4), hardening=0.7, columns=1.3)
    bound = np.full(shape, np.inf)
    trial = rng.normal(size=(2, *shape))

    def shifted(traction):
        # the stress after `traction` itself, as `under` has it for trial tractions
        raised = flow.after(magnitude(traction))
        return Flow(raised, flow.hardening).shift(traction)

    raised = flow.under(trial, bound)
    traction = Potential(bound, raised).projected(trial, 1.0)
    np.testing.assert_allclose(flow.after(magnitude(traction)), raised.threshold, rtol=1e-14)
    along, across = raised.tangent(traction)
    direction = traction / magnitude(traction)
    grows = magnitude(traction) > raised.threshold
    derivative = FlowDerivative(flow.columns, along, across, direction, grows)
    step = rng.normal(size=traction.shape)
    differences = (shifted(traction + 1e-6 * step) - shifted(traction - 1e-6 * step)) / 2e-6
    np.testing.assert_allclose(derivative(step), differences, atol=1e-8)


def test_both_of_two_potentials_have_the_smaller_bound():
    rng = np.random.default_rng(6)
    disk, flow = potentials(rng)["disk"], potentials(rng)["flow alone"]
    trial = rng.normal(size=(2, N))
    both = (disk & flow).projected(trial, 0.5)
    np.testing.assert_allclose(both, disk.projected(flow.projected(trial, 0.5), 1.0), rtol=1e-14)
    with pytest.raises(AssertionError):
        _ = flow & flow


@pytest.mark.parametrize(("size", "kind"), [(1e200, float), (1e30, np.float32)])
def test_lengths_whose_squares_overflow(size, kind):
    """Of trial tractions by influence numbers that nearly vanish: 3, 4 and 5, and their
    projection.
    """
    trial = np.array([[3.0, 3e-3], [4.0, 4e-3]]) * size
    trial = trial.astype(kind)
    with np.errstate(over="raise"):
        np.testing.assert_allclose(magnitude(trial) / size, [5.0, 5e-3], rtol=1e-6)
        np.testing.assert_allclose(
            project(trial, np.array([1.0, 2.0])), [[0.6, 1.2], [0.8, 1.6]], rtol=1e-6
        )
