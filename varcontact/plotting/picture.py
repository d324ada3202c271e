"""Figures that pyplot does not keep: a loop of pictures fills no memory, and a notebook shows each once."""

from __future__ import annotations

import io

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class Picture(Figure):
    """A figure outside pyplot's registry, which notebooks show whether or not pyplot is loaded."""

    def _repr_png_(self) -> bytes:
        image = io.BytesIO()
        self.savefig(image, format="png")
        return image.getvalue()


def empty_figure(figsize: tuple[float, float]) -> Picture:
    """A figure without axes; call it within `styled`.

    Parameters
    ----------
    figsize : pair of float
        Width and height [inch].
    """
    figure = Picture(figsize=figsize, layout="constrained")
    FigureCanvasAgg(figure)
    return figure
