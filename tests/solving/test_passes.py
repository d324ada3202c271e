"""When passes end: each loop by its own limits, all together after a number of them."""

import numpy as np

from varcontact.discrete.state import unloaded
from varcontact.scene.grid import Grid
from varcontact.solving.coupling import PASSES_MAX, Limits, fixed_point

GRID = Grid(nx=3, ny=3, dx=1.0, dy=1.0, x0=0.0, y0=0.0)
ENDLESS = Limits(1e-8, passes=10**6, patience=10**6)


def test_a_loop_that_turns_in_a_circle_ends():
    def turned(state):
        return state.under({"friction": -state.fields["friction"]}), 1.0

    start = unloaded(GRID).under({"friction": np.ones(GRID.shape)})
    found = fixed_point(turned, start, 1.0, ("friction",), ENDLESS)
    assert found.pass_count == PASSES_MAX == len(found.passes) - 1


def test_loops_within_loops_count_together():
    """An inner loop of ten passes each time: the outer one makes an eleventh of the limit."""
    ten = Limits(0.0, passes=11, patience=10**6)

    def inner(state):
        return state.under({"friction": 0.5 * state.fields["friction"]}), 1.0

    def outer(state):
        return fixed_point(inner, state, 1.0, ("friction",), ten), 1.0

    start = unloaded(GRID).under({"friction": np.ones(GRID.shape)})
    found = fixed_point(outer, start, 1.0, ("friction",), ENDLESS)
    assert PASSES_MAX <= found.pass_count <= PASSES_MAX + 1
    assert len(found.passes) - 1 == -(-PASSES_MAX // 11)


def test_a_loop_that_contracts_ends_at_its_tolerance():
    def halved(state):
        field = 0.1 * state.fields["friction"]
        return state.under({"friction": field}), float(field.max())

    start = unloaded(GRID).under({"friction": np.ones(GRID.shape)})
    found = fixed_point(halved, start, 1.0, ("friction",), ENDLESS)
    assert found.passes[-1][1] <= 1e-8
    assert found.pass_count <= 9
