"""Reports as texts for notebooks."""

from __future__ import annotations

from collections.abc import Callable
from html import escape


class Reported:
    """What prints as its report, in notebooks too."""

    report: Callable[[], str]

    def __str__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.report())}</pre>"
