"""Ticks whose labels do not run into each other, whatever the units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import MaxNLocator, ScalarFormatter

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class RoomyLocator(MaxNLocator):
    """Round ticks with room for labels as wide as -0.008, where matplotlib's own has room for three digits."""

    def __call__(self) -> Sequence[float]:
        """Ticks for the axis as long as it is drawn."""
        assert self.axis is not None
        self.set_params(nbins=int(np.clip(0.75 * self.axis.get_tick_space(), 1, 8)))
        return super().__call__()


def readable_numbers() -> ScalarFormatter:
    """Labels of a few digits, with a power of ten beside the axis where there would be more."""
    formatter = ScalarFormatter(useMathText=True)
    formatter.set_powerlimits((-3, 4))
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
