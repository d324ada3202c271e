"""Text as HTML, for notebooks and web pages."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from html import escape


def in_rows(title: str, rows: Iterable[tuple[str, str]], width: int = 20) -> str:
    """Names and texts below a title, in two columns, the first of a `width` in characters."""
    return "\n".join([title, "", *(f"  {name:<{width}}{text}".rstrip() for name, text in rows)])


def preformatted(text: str) -> str:
    return f"<pre>{escape(text)}</pre>"


class Reported:
    """Base class of results that print as their report, in notebooks too."""

    report: Callable[[], str]

    def __str__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        return preformatted(self.report())
