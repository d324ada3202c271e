"""Reports as tables and texts for notebooks."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from html import escape


def html_table(title: str, rows: Iterable[tuple[str, str]]) -> str:
    """Names and texts as a table under a title; a row without a name continues the one before, an empty row separates.

    Examples
    --------
    >>> html_table("Plan", [("G", "1 < 2")]).splitlines()[2]
    '<tr><th style="text-align:left">G</th><td style="text-align:left">1 &lt; 2</td></tr>'
    """
    cells = [
        f'<tr><th style="text-align:left">{escape(name)}</th><td style="text-align:left">{escape(text)}</td></tr>'
        if name or text
        else '<tr><td colspan="2"></td></tr>'
        for name, text in rows
    ]
    return "\n".join(["<table>", f"<caption><b>{escape(title)}</b></caption>", *cells, "</table>"])


def html_text(text: str) -> str:
    """A report with its lines and columns as they are.

    Examples
    --------
    >>> html_text("1 < 2")
    '<pre>1 &lt; 2</pre>'
    """
    return f"<pre>{escape(text)}</pre>"


class Reported:
    """What prints as its report, in notebooks too."""

    report: Callable[[], str]

    def __str__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        return html_text(self.report())
