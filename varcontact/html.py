"""Texts for notebooks and pages."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from html import escape


def in_rows(title: str, rows: Iterable[tuple[str, str]], width: int = 20) -> str:
    """Names and texts below a title, in columns as wide."""
    return "\n".join([title, "", *(f"  {name:<{width}}{text}".rstrip() for name, text in rows)])


def preformatted(text: str) -> str:
    return f"<pre>{escape(text)}</pre>"


class Reported:
    """What prints as its report, in notebooks too."""

    report: Callable[[], str]

    def __str__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        return preformatted(self.report())
