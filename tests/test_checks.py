"""Checks of single inputs: what is no array of numbers is refused, by name, and never converted in silence."""

import numpy as np
import pytest

import varcontact as vc
from varcontact import checks

ONES = np.ones((2, 3))


@pytest.mark.parametrize(
    "value",
    [
        ONES.astype(bool),
        ONES.astype(complex),
        ONES.astype(object),
        ONES.astype("M8[s]"),
        [["1", "2"], ["3", "4"]],
        [[1.0, 2.0], [3.0]],
        [[10**400, 1], [1, 1]],
        np.ma.masked_array(ONES, mask=[[0, 1, 0], [0, 0, 0]]),
    ],
    ids=["bool", "complex", "object", "date", "text", "ragged", "overflow", "masked"],
)
def test_arrays_of_anything_else_are_refused(value):
    with pytest.raises(vc.SceneError) as failure:
        checks.array("surface.h", value, 2)
    assert failure.value.field == "surface.h"
    assert "2-dimensional array of finite numbers" in str(failure.value)


def test_masked_array_without_masked_values_is_an_array():
    np.testing.assert_array_equal(checks.array("surface.h", np.ma.masked_array(2 * ONES), 2), 2 * ONES)


@pytest.mark.parametrize("value", ["no", "false", 0, 1, None, 1.0])
def test_flags_are_true_or_false_and_nothing_like_it(value):
    with pytest.raises(vc.SceneError, match="true or false"):
        checks.flag("polish", value)
    assert checks.flag("polish", np.bool_(False)) is False


def test_error_of_a_value_nested_too_deep_for_repr():
    """The message is made all the same."""
    value: list = []
    for _ in range(100_000):
        value = [value]
    assert "nested deep" in str(vc.SceneError("a", value, "less"))
