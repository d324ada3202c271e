"""Labels of ticks that can be read, whatever the units and the shape of the contact."""

import dataclasses
import re
from itertools import pairwise
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import varcontact as vc
from varcontact.plotting.style import readable_decades

README = Path(__file__).parents[2] / "README.md"


def overprinted(figure):
    """Pairs of tick labels of one axis that touch, as they are drawn."""
    figure.canvas.draw()
    pairs, seen = [], 0
    for ax in figure.axes:
        for axis, along in ((ax.xaxis, 0), (ax.yaxis, 1)):
            low, high = sorted(axis.get_view_interval())
            labels = [text for text in axis.get_ticklabels() if low <= text.get_position()[along] <= high]
            corners = [(text.get_window_extent().get_points()[:, along], text.get_text()) for text in labels]
            drawn = sorted((begin, end, text) for (begin, end), text in corners if text)
            seen += len(drawn)
            pairs += [(one[2], other[2]) for one, other in pairwise(drawn) if other[0] < one[1]]
    assert seen > 4
    return pairs


def test_the_first_plot_of_the_readme():
    """In metres and newtons, where labels are as long as -0.008."""
    block = re.search(r"```python\n(import varcontact as vc\n\nscene.*?)\nprint\(", README.read_text(), re.DOTALL)
    names = {}
    exec(block[1], names)
    assert overprinted(names["sol"].plot()) == []
    assert overprinted(vc.plot_stress(names["sol"])) == []


@pytest.mark.parametrize("size", [3e-7, 0.0061, 0.024, 1.0, 110.0])
@pytest.mark.parametrize("ratio", [0.21, 1.0, 4.8])
def test_contacts_of_every_size_and_shape(rolling, size, ratio):
    a, b = size * ratio**0.5, size / ratio**0.5
    scene = rolling(surface=vc.Ellipse(a=a, b=b), motion=None, friction=None, grid=vc.Grid(nx=6, ny=6))
    assert overprinted(vc.solve(dataclasses.replace(scene, normal_force=size**2)).plot()) == []


@pytest.mark.parametrize(
    "ends", [(0.7, 6.0), (1100.0, 3100.0), (310.0, 390.0), (2e-7, 3e-7), (60.0, 150.0), (8.0, 3e4)]
)
def test_a_logarithmic_axis_has_two_labels_or_more(ends):
    """Also where fewer than two powers of ten are in sight."""
    figure = Figure(figsize=(2.5, 2.2))
    ax = figure.subplots()
    ax.plot([1, 1000], ends)
    ax.set(xscale="log", yscale="log", ylim=ends)
    readable_decades(ax)
    figure.canvas.draw()
    assert (
        sum(bool(each.get_text()) and ends[0] <= each.get_position()[1] <= ends[1] for each in ax.get_yticklabels()) > 1
    )
    assert overprinted(figure) == []
