"""Attributes that are computed when they are first read.

`functools.cached_property` of Python 3.11 holds a lock while it computes. A
process forked from another thread meanwhile waits for that lock for ever.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Self, TypeVar, overload

Value = TypeVar("Value")


class lazy_property(Generic[Value]):  # noqa: N801 - written as the decorator `property` is
    """A property that is computed once; by each of the threads that read it first at the same time."""

    def __init__(self, compute: Callable[[Any], Value]) -> None:
        self.compute = compute
        self.__doc__ = compute.__doc__

    @overload
    def __get__(self, owner: None, kind: type) -> Self: ...

    @overload
    def __get__(self, owner: object, kind: type) -> Value: ...

    def __get__(self, owner: object, kind: type) -> Self | Value:
        if owner is None:
            return self
        value = self.compute(owner)
        object.__setattr__(owner, self.compute.__name__, value)  # also where the class is frozen
        return value
