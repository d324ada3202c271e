"""Ticks whose labels do not run into each other, whatever the units."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import FixedLocator, Locator, LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

if TYPE_CHECKING:
    from matplotlib.axes import Axes


WIDTH = 0.66
"""Of a digit, in parts of the size of letters."""


class RoomyLocator(MaxNLocator):
    """As many round ticks as have room for their labels, which matplotlib's own takes to be of three digits."""

    def __call__(self) -> Sequence[float]:
        """Ticks for the axis as long as it is drawn."""
        axis: Any = self.axis
        letter = float(axis.majorTicks[0].label1.get_fontsize())
        length = axis.axes.bbox.width * 72 / axis.axes.get_figure(root=True).dpi
        low, high = sorted(axis.get_view_interval())
        ticks: Sequence[float] = ()
        for most in range(8, 0, -1):
            self.set_params(nbins=most)
            ticks = super().__call__()
            shown = [tick for tick in ticks if low <= tick <= high]
            labels = [
                re.sub(r"\\mathdefault|[${}]", "", text) for text in axis.get_major_formatter().format_ticks(shown)
            ]
            widest = WIDTH * letter * max(map(len, labels), default=0)
            if len(shown) < 2 or widest + letter <= length * (shown[1] - shown[0]) / (high - low):
                break
        return ticks


def readable_numbers() -> ScalarFormatter:
    """Labels of a few digits, with a power of ten beside the axis where there would be more."""
    formatter = ScalarFormatter(useMathText=True)
    formatter.set_powerlimits((-4, 5))
    return formatter


def readable_ticks(ax: Axes) -> None:
    """Round and few ticks along x, and short numbers along both axes.

    Parameters
    ----------
    ax : Axes
    """
    ax.xaxis.set_major_locator(RoomyLocator(steps=[1, 2, 5, 10], min_n_ticks=1))
    ax.xaxis.set_major_formatter(readable_numbers())
    ax.yaxis.set_major_formatter(readable_numbers())


def readable_decades(ax: Axes) -> None:
    """Powers of ten along logarithmic axes, as many as have room; finer ticks where fewer than two are in sight.

    Parameters
    ----------
    ax : Axes
        With its data.
    """
    for axis, scale, most in ((ax.xaxis, ax.get_xscale(), 6), (ax.yaxis, ax.get_yscale(), 8)):
        if scale == "log" and not isinstance(axis.get_major_locator(), FixedLocator):
            axis.set_minor_formatter(NullFormatter())
            low, high = np.log10(axis.get_view_interval())
            if np.floor(high) > np.ceil(low):
                axis.set_major_locator(LogLocator(numticks=most))
            else:
                axis.set_major_locator(_within_a_decade(low, high))
                axis.set_major_formatter(readable_numbers())


def _within_a_decade(low: float, high: float) -> Locator:
    """Ticks at 1, 2 and 5 times powers of ten; where fewer than two are in sight, those of a linear axis."""
    seen = [s * 10.0**k for k in range(int(np.floor(low)), int(np.ceil(high)) + 1) for s in (1, 2, 5)]
    seen = [tick for tick in seen if low <= np.log10(tick) <= high]
    return FixedLocator(seen) if len(seen) > 1 else MaxNLocator(nbins=4, steps=[1, 2, 5, 10])
