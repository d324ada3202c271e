"""Reports: values with their error bars."""

import math

import pytest

from varcontact.results.report import with_bar


@pytest.mark.parametrize(
    ("value", "bar", "text"),
    [
        (-13.0987, 0.0461, "-13.099 +- 0.046"),
        (1.84, 0.2, "1.84 +- 0.20"),
        (79176.3, 14.6, "79176 +- 15"),
        (-11707.76, 166.7, "-11710 +- 170"),
        (1.2345678e9, 2.4e6, "1.2346e+09 +- 2.4e+06"),
        (1.2346e-9, 2.4e-11, "1.235e-09 +- 2.4e-11"),
        (0.0, 0.012, "0.000 +- 0.012"),
        (-3.0, 0.0, "-3"),
        (2.5, math.nan, "2.5"),
        (2.5, math.inf, "2.5"),
    ],
)
def test_values_have_the_digits_of_their_bars(value, bar, text):
    assert with_bar(value, bar) == text
