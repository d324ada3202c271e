"""Accuracy on demand against the reference scenes, whose continuum values come from other discretisations."""

import pytest

import varcontact as vc
from varcontact.results.quantities_of_interest import values

CHOSEN = {
    name: each
    for k, (name, each) in enumerate(vc.continuum_values().items())
    if k % 5 == 0 and each.kind != "transient"
}


@pytest.mark.parametrize("name", CHOSEN)
def test_the_error_is_below_the_accuracy(name):
    reference = CHOSEN[name]
    sol = vc.solve(reference.scene, accuracy=0.01)
    assert reference.error(values(sol)) <= 0.01 + reference.bar
    assert sol.error_estimate.largest <= 0.01
