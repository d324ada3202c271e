"""What is drawn on a dozen scenes: the numbers, their units, the words, and nothing over anything
else.
"""

import dataclasses
import gc
import os
import re
import struct
import weakref
from itertools import combinations, pairwise
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from PIL import Image

import varcontact as vc
from tests.scenes import refused, wheel_on_rail
from varcontact.plotting.unit_labels import measure

RAIL = wheel_on_rail(vc.Steady(vx=1e-3, vy=5e-4, spin=0.2), vc.Grid(nx=10, ny=10), units=vc.SI)
CYLINDER = dataclasses.replace(
    RAIL,
    surface=vc.Cylinders(R=0.46),
    normal_force=8e6,
    motion=vc.Steady(vx=1e-3),
    grid=vc.Grid(nx=16),
)


def rail(**changes):
    return dataclasses.replace(RAIL, **changes)


SCENES = {
    "rolling": rail(),
    "millimetres": rail(
        bodies=vc.Bodies(G=82e3, nu=0.28),
        surface=vc.Paraboloids(Rx=460.0, Ry=300.0),
        units=vc.MM_N,
        motion=vc.Steady(),
    ),
    "inches": rail(units=vc.Units(length="in", force="lbf")),
    "no units": rail(units=None),
    "pressure alone": rail(motion=None, friction=None),
    "shift": rail(motion=vc.Shift(ux=1e-6)),
    "no slip": rail(friction=np.inf),
    "frictionless": rail(friction=0.0),
    "flat ellipse": rail(surface=vc.Ellipse(a=1e-3, b=12e-3)),
    "unlike": rail(bodies=vc.Bodies(G=(82e9, 26e9), nu=(0.28, 0.33)), grid=vc.Grid(nx=8, ny=8)),
    "line": CYLINDER,
    "line, lateral": dataclasses.replace(CYLINDER, motion=vc.Shift(Fx=-1e5, Fy=2e5)),
    "line, pressure alone": dataclasses.replace(CYLINDER, motion=None, friction=None),
    "line, no slip": dataclasses.replace(CYLINDER, friction=np.inf),
}


UNDRAWN = ("millimetres", "inches", "frictionless", "unlike", "line, no slip")
"""Their panels are those of others but for words and numbers."""


@pytest.fixture(scope="module", params=[name for name in SCENES if name not in UNDRAWN])
def sol(request):
    return vc.solve(SCENES[request.param])


@pytest.fixture(scope="module")
def wheel():
    return vc.solve(RAIL)


@pytest.fixture(autouse=True)
def _outside_pyplot():
    yield
    assert plt.get_fignums() == []


def drawn_texts(figure):
    """What can be read, with its place on the page."""
    found = []
    for ax in [each for top in figure.axes if top.axison for each in (top, *top.child_axes)]:
        for axis, along in ((ax.xaxis, 0), (ax.yaxis, 1)):
            low, high = sorted(axis.get_view_interval())
            found += [
                text
                for text in axis.get_ticklabels(which="both")
                if low <= text.get_position()[along] <= high
            ]
            found += [axis.label, axis.get_offset_text()]
        found += [ax.title]
        found += [] if ax.get_legend() is None else ax.get_legend().get_texts()
    found += [text for legend in figure.legends for text in legend.get_texts()]
    return [text for text in found if text.get_visible() and text.get_text()]


def check_readable(figure):
    """No two texts touch, and all are on the page."""
    figure.draw_without_rendering()
    check_drawn(figure)


def check_drawn(figure):
    """The same of a figure that has been drawn."""
    boxes = [
        (text.get_text(), text.get_window_extent().padded(-0.5)) for text in drawn_texts(figure)
    ]
    assert len(boxes) > 4
    for (one, first), (other, second) in combinations(boxes, 2):
        assert not first.overlaps(second), f"{one!r} lies over {other!r}"
    width, height = figure.canvas.get_width_height()
    for word, box in boxes:
        assert box.x0 > -1 and box.y0 > -1 and box.x1 < width + 1 and box.y1 < height + 1, (
            f"{word!r} is cut off"
        )


@pytest.fixture(scope="module")
def panels(sol):
    """All panels of a scene, by the words for them."""
    names = ["pressure", "distance", "section"]
    names += ["traction", "slip", "power_density"] if sol.scene.motion is not None else []
    figure = sol.plot(names)
    figure.draw_without_rendering()
    return dict(zip(names, figure.axes, strict=False))


@pytest.mark.long
def test_nothing_lies_over_anything(panels):
    check_drawn(panels["pressure"].figure)


def test_axes_are_equal_or_it_is_said(sol, panels):
    if sol.scene.line:
        return
    ax = panels["pressure"]
    (left, right), (bottom, top), page = ax.get_xlim(), ax.get_ylim(), ax.get_window_extent()
    equal = page.width / (right - left) == pytest.approx(page.height / (top - bottom), rel=0.01)
    assert equal == ("not to one scale" not in ax.get_xlabel())
    assert equal == (sol.scene.surface != vc.Ellipse(a=1e-3, b=12e-3))


def test_slip_is_hatched_and_stick_is_not(sol, panels):
    """Each in its own elements; in grey print their colours are the same."""
    if "traction" not in panels or sol.scene.line:
        return
    patches = {
        patch.get_gid(): patch
        for patch in panels["traction"].patches
        if isinstance(patch, PathPatch)
    }
    assert patches["slip"].get_hatch() and not patches["stick"].get_hatch()
    factor = measure(sol.scene, "length", sol.grid.box).factor
    places = np.stack(np.meshgrid(sol.grid.x, sol.grid.y), axis=-1).reshape(-1, 2) * factor
    state = sol.state.copy()
    if isinstance(sol.motion, vc.Steady):  # at the leading edge slip is shown only before slip
        for row in state:
            first = np.flatnonzero(row)[-1:]
            row[first[row[first - 1] == 1]] = 1
    for number, name in ((1, "stick"), (2, "slip")):
        path = patches[name].get_path()
        areas = [path.vertices[k : k + 4] for k in range(0, len(path.vertices), 5)]
        inside = np.zeros(len(places), bool)
        for corners in areas:
            inside |= np.all(
                (places > corners.min(axis=0)) & (places < corners.max(axis=0)), axis=1
            )
        np.testing.assert_array_equal(inside, state.ravel() == number)


@pytest.mark.long
def test_engineering_units(wheel):
    """Pressures in MPa, lengths in mm and um by their size, slip in thousandths."""
    figure = wheel.plot(["pressure", "distance", "slip"])
    bars = [ax.child_axes[0].get_ylabel() for ax in figure.axes]
    assert bars == ["pressure [MPa]", "distance [µm]", "slip [$10^{-3}$]"]
    image = figure.axes[0].images[0].get_array()
    assert image.max() == pytest.approx(wheel.max_pressure / 1e6)
    assert all(ax.get_xlabel().startswith("x [mm]") for ax in figure.axes)
    same = vc.solve(SCENES["millimetres"])
    other = same.plot("pressure").axes[0]
    assert other.child_axes[0].get_ylabel() == "pressure [MPa]" and other.get_xlabel().startswith(
        "x [mm]"
    )
    assert other.images[0].get_array().max() == pytest.approx(image.max())
    plain = vc.solve(SCENES["inches"]).plot("pressure").axes[0]
    assert plain.child_axes[0].get_ylabel() == "pressure [$10^{9}$ lbf/in^2]"
    assert vc.solve(SCENES["no units"]).plot("pressure").axes[0].get_ylabel() == "y [$10^{-3}$]"


@pytest.mark.long
def test_the_section_shows_the_size_beside_the_bound(wheel):
    figure = wheel.section()
    ax, row = figure.axes[0], wheel.grid.ny // 2
    lines = {line.get_label(): line.get_ydata() for line in ax.get_lines()}
    shown = 1e6 * lines["$|p|$"]
    expected = np.hypot(*wheel.traction[:, row - 1])
    assert shown.max() == pytest.approx(expected.max())
    assert np.all(shown <= 1e6 * lines["$\\pm$ traction bound"] * (1 + 1e-9))
    assert {"$p_x$", "$p_y$"} <= set(lines)
    assert ax.get_title() == f"Section at y = {1e3 * wheel.grid.y[row - 1]:.3g} mm"


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda sol: sol.plot("presure"), r"what = 'presure'.*pressure"),
        (lambda sol: sol.plot([]), "one panel at least"),
        (
            lambda sol: sol.plot(["pressure", "slip"], ax=Figure().add_subplot()),
            "one panel for one ax",
        ),
        (lambda sol: sol.plot(ax="here"), "ax = 'here'"),
        (lambda sol: sol.plot(figsize=3), "figsize"),
        (lambda sol: sol.plot(figsize=(0, 3)), "width, height"),
        (lambda sol: vc.solve(SCENES["pressure alone"]).plot("slip"), "where there is no motion"),
        (lambda sol: vc.plot_stress(sol, plane="zz"), "plane"),
        (lambda sol: vc.plot_stress(sol, x=0.0), 'x = 0.0 .*plane = "yz"'),
        (lambda sol: vc.plot_stress(sol, plane="xy", body=3), "body"),
        (lambda sol: vc.plot_stress(vc.solve(CYLINDER), plane="yz"), "line contact"),
        (lambda sol: vc.plot_curve([]), "solutions"),
        (lambda sol: vc.plot_curve([sol, vc.solve(SCENES["shift"])]), "all roll or all shift"),
        (lambda sol: vc.plot_curve([sol], against="Fx"), "against"),
    ],
)
def test_what_is_refused(wheel, call, words):
    refused(lambda: call(wheel), match=words)


@pytest.mark.long
@pytest.mark.parametrize("plane", ["xz", "yz", "xy"])
def test_the_largest_stress_is_marked(wheel, plane):
    """Where it is, with its value; it is the stress there, and no other point has more."""
    figure = vc.plot_stress(wheel, plane=plane)
    check_readable(figure)
    ax = figure.axes[0]
    (cross,) = (line for line in ax.get_lines() if line.get_label().startswith("largest"))
    first, second = (1e-3 * float(value[0]) for value in cross.get_data())
    at = 1e-3 * float(ax.get_title().split("=")[1].split()[0])
    point = {"xz": (first, at, second), "yz": (at, first, second), "xy": (first, second, at)}[plane]
    stress = vc.stress(wheel, point, 1 if point[2] >= 0 else 2)
    assert float(cross.get_label().split()[1]) == pytest.approx(
        float(stress.von_mises) / 1e6, rel=5e-3
    )
    near = np.array(point)[:, None] + 2e-3 * np.random.default_rng(1).uniform(-1, 1, (3, 60))
    near[{"xz": 1, "yz": 0, "xy": 2}[plane]] = at
    near[2] = np.maximum(near[2], 0) if point[2] >= 0 else np.minimum(near[2], 0)
    assert (
        vc.stress(wheel, near, 1 if point[2] >= 0 else 2).von_mises.max() < 1.02 * stress.von_mises
    )


@pytest.mark.long
def test_curves(wheel):
    slow = vc.scan(rail(motion=vc.Steady()), [(vx, 0.0, 0.0) for vx in (0.0, 1e-3, 6e-3)])
    figure = vc.plot_curve({"f = 0.33": slow, "twice": [*slow, slow[-1]]})
    check_readable(figure)
    lines = {line.get_label(): line for line in figure.axes[0].get_lines()}
    x, force = lines["f = 0.33"].get_data()
    assert list(x) == pytest.approx([0, 1, 6])
    assert list(force) == pytest.approx(
        [-sol.Fx / (0.33 * sol.normal_force) for sol in slow], rel=1e-9, abs=1e-9
    )
    assert figure.axes[0].get_xlabel() == "longitudinal creepage [$10^{-3}$]"
    forces = vc.plot_curve(slow, normalised=False).axes[0]
    assert forces.get_ylabel() == "tangential force [kN]"
    spun = vc.plot_curve(vc.scan(rail(), [(0.0, 0.0, spin) for spin in (0.0, 0.5)])).axes[0]
    assert spun.get_xlabel() == "spin [1/m]" and "$-F_y$" in [
        line.get_label() for line in spun.get_lines()
    ]


@pytest.fixture(scope="module")
def history():
    forces = [-4e3 * k for k in range(3)]
    return vc.solve(
        rail(motion=vc.Transient(steps=3, dq=2e-3, Fx=forces), grid=vc.Grid(nx=8, ny=8))
    )


@pytest.mark.long
def test_a_history_has_one_abscissa(history):
    figure = history.plot()
    check_readable(figure)
    forces, creepages, areas = figure.axes
    assert forces.get_xlim() == creepages.get_xlim() == areas.get_xlim()
    assert [forces.get_xlabel(), creepages.get_xlabel(), areas.get_xlabel()] == [
        "",
        "",
        "distance rolled [mm]",
    ]
    assert 1e-3 * creepages.get_lines()[0].get_ydata() == pytest.approx(
        history.creepage[:, 0], nan_ok=True
    )
    given = vc.solve(
        dataclasses.replace(history.scene, motion=vc.Transient(steps=2, dq=2e-3, vx=1e-3))
    )
    assert len(given.plot().axes) == 2
    still = vc.solve(
        dataclasses.replace(history.scene, motion=vc.Transient(steps=3, dq=0, Fx=[-1e4, 0, 1e4]))
    )
    assert still.plot().axes[-1].get_xlabel() == "step"


@pytest.mark.long
def test_a_moving_picture(history, tmp_path):
    path = tmp_path / "history.gif"
    history.animate(path, fps=5)
    with Image.open(path) as film:
        assert film.n_frames == len(history) and film.info["duration"] == 200
        frames = []
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("L"), dtype=int))
    assert all(np.any(one != other) for one, other in pairwise(frames))
    row = np.argmax((frames[0] < 60).sum(axis=1))  # of the frame around the axes: it stays
    assert all(((frame[row] < 60) == (frames[0][row] < 60)).mean() > 0.95 for frame in frames)
    history.animate(path)
    other = tmp_path / "mine.gif"
    other.write_bytes(b"GIF89a mine")
    with pytest.raises(vc.OutputError, match="no picture of varcontact's"):
        history.animate(other)
    with pytest.raises(vc.OutputError, match=r"must end in \.gif, \.mp4"):
        history.animate(tmp_path / "history.avi")
    refused(lambda: history.animate(path, fps=0), match="fps")
    assert sorted(os.listdir(tmp_path)) == ["history.gif", "mine.gif"]


def test_films_need_ffmpeg(history, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(vc.OutputError, match=r"needs the program ffmpeg.*\.gif needs nothing else"):
        history.animate(tmp_path / "history.mp4")
    assert os.listdir(tmp_path) == []


@pytest.mark.long
def test_pictures_of_studies(tmp_path):
    scene = rail(grid=vc.Grid(nx=8, ny=8))
    figure = vc.plot_comparison(vc.compare({"wheel": scene}, ["tang", "fastsim"]))
    check_readable(figure)
    assert figure.legends[0].get_title().get_text() == "method"
    found = vc.converge(scene, [6, 8, 10], ["tang"], offsets=2)
    study = found.plot()
    check_readable(study)
    assert [ax.get_title() for ax in found.plot(["Fx"]).axes] == ["Fx"]
    refused(lambda: found.plot(["Fq"]), match="quantities")
    assert [text.get_text() for text in study.legends[0].get_texts()][:2] == [
        "single solve",
        "mean of a grid",
    ]


def test_the_style_is_for_everybody():
    """By its name, from matplotlib; colours that the colour-blind tell apart, and letters of 7
    points at least.
    """
    with plt.style.context("varcontact.plotting.journal"):
        colours = mpl.rcParams["axes.prop_cycle"].by_key()["color"]
        assert colours[:2] == ["#0072B2", "#D55E00"] or colours[:2] == ["0072B2", "D55E00"]
        assert (
            min(
                mpl.rcParams[name]
                for name in ("xtick.labelsize", "legend.fontsize", "axes.labelsize")
            )
            >= 7
        )


@pytest.mark.long
@pytest.mark.filterwarnings("error")
def test_many_pictures_leave_none_behind(wheel):
    with mpl.rc_context({"figure.max_open_warning": 2}):
        figures = [weakref.ref(wheel.plot("pressure")) for _ in range(4)]
    gc.collect()
    assert not any(each() for each in figures)


@pytest.mark.long
def test_a_notebook_shows_a_picture_by_itself(wheel):
    """As PNG, of the figure's size in pixels, and as nothing else: IPython shows each form that an
    object has.
    """
    figure = wheel.plot("pressure")
    image = figure._repr_png_()
    assert image.startswith(b"\x89PNG\r\n")
    assert struct.unpack(">II", image[16:24]) == tuple(
        np.rint(figure.get_size_inches() * figure.dpi).astype(int)
    )
    others = ("html", "svg", "jpeg", "pdf", "latex", "markdown", "json", "javascript", "mimebundle")
    assert all(getattr(figure, f"_repr_{form}_", lambda: None)() is None for form in others)
    assert not hasattr(figure, "_ipython_display_")


# -------------------- Labels of ticks that can be read


README = Path(__file__).parents[2] / "README.md"


def overprinted(figure):
    """Pairs of tick labels of one axis that touch, as they are drawn."""
    figure.canvas.draw()
    pairs, seen = [], 0
    for ax in figure.axes:
        for axis, along in ((ax.xaxis, 0), (ax.yaxis, 1)):
            low, high = sorted(axis.get_view_interval())
            labels = [
                text
                for text in axis.get_ticklabels(which="both")
                if low <= text.get_position()[along] <= high
            ]
            corners = [
                (text.get_window_extent().get_points()[:, along], text.get_text())
                for text in labels
            ]
            drawn = sorted((begin, end, text) for (begin, end), text in corners if text)
            seen += len(drawn)
            pairs += [(one[2], other[2]) for one, other in pairwise(drawn) if other[0] < one[1]]
    assert seen > 4
    return pairs


@pytest.mark.long
def test_the_first_plot_of_the_readme():
    """In metres and newtons, where labels are as long as -0.008."""
    block = re.search(
        r"```python\n(import varcontact as vc\n\nscene.*?)\nprint\(", README.read_text(), re.DOTALL
    )
    names = {}
    exec(block[1], names)
    assert overprinted(names["sol"].plot()) == []
    assert overprinted(vc.plot_stress(names["sol"])) == []


@pytest.mark.long
@pytest.mark.parametrize(
    ("size", "ratio"),
    [(3e-7, 0.21), (0.0061, 4.8), (0.024, 1.0), (1.0, 4.8), (110.0, 0.21), (1.0, 1.0)],
)
def test_contacts_of_every_size_and_shape(rolling, size, ratio):
    a, b = size * ratio**0.5, size / ratio**0.5
    scene = rolling(
        surface=vc.Ellipse(a=a, b=b), motion=None, friction=None, grid=vc.Grid(nx=6, ny=6)
    )
    assert overprinted(vc.solve(dataclasses.replace(scene, normal_force=size**2)).plot()) == []


@pytest.mark.long
def test_sections_elsewhere(wheel):
    """The row next to y; on no row, and in line contact, it is refused."""
    y = float(wheel.grid.y[2])
    ax = wheel.plot("section", y=y + 0.3 * wheel.grid.sides[1]).axes[0]
    assert f"y = {1e3 * y:.3g} mm" in ax.get_title()
    largest = np.hypot(*wheel.traction[:, 2]).max()
    assert max(
        line.get_ydata().max() for line in ax.get_lines() if line.get_label() == "$|p|$"
    ) == pytest.approx(largest / 1e6)
    refused(lambda: wheel.section(y=1.0), match=r"y = 1.0 .* on the grid")
    refused(lambda: vc.solve(CYLINDER).section(y=0.0), match="left out in line contact")
    refused(lambda: wheel.plot("pressure", y=0.0), match='or with the panel "section"')


@pytest.mark.parametrize(("Rx", "Ry"), [(0.2, 0.09), (0.3, 0.2), (0.02, 0.2)])
def test_panels_in_the_shape_of_the_contact_have_one_scale(caplog, Rx, Ry):
    """Matplotlib widens no axes itself, of which it would tell by a line in the log."""
    surface = vc.Paraboloids(Rx=Rx, Ry=Ry)
    figure = vc.solve(rail(surface=surface, grid=vc.Grid(nx=20, ny=16))).plot()
    figure.draw_without_rendering()
    pressure, tractions = figure.axes[:2]
    assert pressure.get_xlim() == pytest.approx(tractions.get_xlim())
    assert pressure.get_ylim() == pytest.approx(tractions.get_ylim())
    assert not caplog.records
    plt.close(figure)
