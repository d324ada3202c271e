"""Pictures at the width of a column: legible, or with fewer panels and a word."""

import warnings
from dataclasses import replace
from itertools import combinations

import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.plotting.style import SmallFigure
from varcontact.wheel_rail import Profile, Track, WheelSet
from varcontact.wheel_rail.geometry_table import geometry_table

SCENE = vc.Scene(
    bodies=vc.Bodies(G=82e3, nu=0.28),
    surface=vc.Paraboloids(Rx=460.0, Ry=300.0),
    normal_force=80e3,
    friction=0.3,
    motion=vc.Steady(vx=1e-3, vy=1e-3, spin=2e-4),
    grid=vc.Grid(nx=10, ny=10),
    units=vc.MM_N,
)


@pytest.fixture(scope="module")
def solution():
    return vc.solve(SCENE)


def table():
    track = Track(rail=Profile.rail_60e1(), cant=1 / 40)
    wheelset = WheelSet(wheel=Profile.s1002())
    return geometry_table(
        track, wheelset, y=[-2.0, 0.0, 2.0], yaw=[-0.01, 0.01], vertical_force=5e4
    )


def assert_legible(figure):
    """Panels with their labels are within the figure and beside each other, in 6 points or more."""
    figure.draw_without_rendering()
    width, height = figure.bbox.size
    boxes = [ax.get_tightbbox() for ax in figure.axes if ax.get_visible() and ax.axison]
    assert boxes
    for box in boxes:
        assert -1 <= box.x0 and box.x1 <= width + 1
        assert -1 <= box.y0 and box.y1 <= height + 1
    for one, other in combinations(boxes, 2):
        shared_x = min(one.x1, other.x1) - max(one.x0, other.x0)
        shared_y = min(one.y1, other.y1) - max(one.y0, other.y0)
        assert min(shared_x, shared_y) < 2
    for ax in figure.axes:
        for label in (*ax.get_xticklabels(), *ax.get_yticklabels(), ax.xaxis.label):
            assert label.get_fontsize() >= 6
        if ax.axison:
            inside = ax.get_window_extent()
            assert min(inside.width, inside.height) / figure.dpi >= 0.1


PICTURES = {
    "solution": lambda sol: sol.plot(figsize=(3.5, 2.6)),
    "solution, taller": lambda sol: sol.plot(figsize=(3.5, 5.0)),
    "section": lambda sol: sol.section(figsize=(3.5, 2.6)),
    "stress": lambda sol: vc.plot_stress(sol, figsize=(3.5, 2.6)),
    "curve": lambda sol: vc.plot_curve([sol, sol], against="vx", figsize=(3.5, 2.6)),
    "response": lambda sol: sol.frequency_response([0.0, 0.1]).plot(figsize=(3.5, 2.6)),
    "table": lambda sol: table().plot(figsize=(3.5, 4.0)),
    "history": lambda sol: vc.solve(
        replace(SCENE, motion=vc.Transient(steps=2, dq=1.0, vx=1e-3))
    ).plot(figsize=(3.5, 3.5)),
    "traces": lambda sol: vc.plot_traces(vc.solve(SCENE, trace=True), figsize=(3.5, 2.6)),
}


@pytest.mark.long
@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.filterwarnings("ignore::varcontact.plotting.style.SmallFigure")
def test_pictures_are_legible_at_column_width(solution, name):
    assert_legible(PICTURES[name](solution))


@pytest.mark.long
def test_panels_without_room_are_named(solution):
    with pytest.warns(
        SmallFigure, match=r"3.5 x 2.6 inches has no room for traction, section: left"
    ):
        figure = solution.plot(figsize=(3.5, 2.6))
    assert figure.axes[0].get_title() == "Pressure"
    with pytest.warns(SmallFigure, match="no room for section"):
        assert len(solution.plot(figsize=(3.5, 5.0)).axes) == 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solution.plot(figsize=(7.5, 3.5))
        solution.plot()


def test_figures_too_small_for_any_panel_are_refused(solution):
    for size in ((1.0, 3.0), (3.5, 1.0)):
        refused(lambda size=size: solution.plot(figsize=size), "figsize", "2.3 by 1.9 inches")


@pytest.mark.long
def test_wavelengths_are_plain_numbers(solution):
    figure = vc.plot_growth(vc.corrugation_growth(solution, [20.0, 80.0, 400.0]))
    figure.draw_without_rendering()
    axis = figure.axes[0].xaxis
    low, high = axis.get_view_interval()
    major = [each for each in axis.get_major_ticks() if low <= each.get_loc() <= high]
    assert [each.label1.get_text() for each in major] == ["20", "50", "100", "200"]
    assert not any(each.get_text() for each in axis.get_ticklabels(minor=True))
