"""Fields of dataclasses that are computed when they are first read."""

from dataclasses import dataclass, field, replace

import pytest

from varcontact.system.process import changed, on_demand


@dataclass(frozen=True)
class Measured:
    name: str
    length: on_demand[float] = field(default=on_demand())


def test_what_computes_a_field_is_called_once():
    calls = []
    measured = Measured("bar", lambda: calls.append(1) or 2.0)
    copy = changed(measured, name="copy")
    assert not calls
    assert (measured.length, measured.length, len(calls)) == (2.0, 2.0, 1)
    assert replace(measured, name="other") == Measured("other", 2.0)
    assert (copy.length, len(calls)) == (2.0, 2)


def test_a_field_on_demand_has_no_default():
    with pytest.raises(TypeError, match="Measured needs length"):
        Measured("bar")
