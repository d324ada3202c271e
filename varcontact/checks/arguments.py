"""Arguments by names that a class does not have: other programs' words, and misspellings."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import TypeVar

from varcontact.checks.words import nearest
from varcontact.errors import SceneError

T = TypeVar("T")


def named(words: Mapping[str, str] | None = None) -> Callable[[type[T]], type[T]]:
    """Make a dataclass say which name is right where an argument has another one."""
    known = dict(words or {})

    def decorated(cls: type[T]) -> type[T]:
        made = cls.__init__
        fields = list(getattr(cls, "__dataclass_fields__", {}))

        @functools.wraps(made)
        def checked(self: T, *args: object, **kwargs: object) -> None:
            for name in kwargs:
                if name not in fields:
                    raise _unknown(cls.__name__, name, fields, known)
            made(self, *args, **kwargs)

        setattr(cls, "__init__", checked)  # noqa: B010  mypy refuses the assignment
        return cls

    return decorated


def _unknown(owner: str, name: str, fields: list[str], known: Mapping[str, str]) -> SceneError:
    """What to write in place of an unknown name."""
    instead = known.get(name)
    words = f": write {instead}" if instead else nearest(name, fields) or f"; it has {', '.join(fields)}"
    return SceneError(f"{owner}.{name}", name, message=f"{owner} has no {name}{words}")
