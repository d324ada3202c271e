"""Pictures of a history: forces, creepages and areas over one abscissa, and all steps as a moving
picture.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from subprocess import CalledProcessError
from typing import Any

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from varcontact import checks
from varcontact.errors import OutputError, SceneError
from varcontact.plotting import style
from varcontact.plotting.fields import box_of, draw_areas, draw_section, draw_states
from varcontact.plotting.unit_labels import measure
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import friction_limit
from varcontact.system.files import check_replaceable, reading, write_whole
from varcontact.system.process import need

KINDS: dict[str, Any] = {".gif": PillowWriter, ".mp4": FFMpegWriter}
"""Endings of moving pictures."""
MARKED_STEPS = 40
"""Steps of a history below which each has a marker."""


def plot_history(history: History, figsize: tuple[float, float] | None = None) -> Figure:
    """Forces, creepages where forces are prescribed, and the areas along the middle row, over one
    abscissa.
    """
    places, edges, label = _abscissa(history)
    creepages = _resulting_creepages(history)
    panels = 3 if creepages else 2
    with style.styled():
        figure, axes = style.new_figure(
            panels, 1, (style.COLUMN * 1.5, 0.4 + 1.7 * panels), figsize, sharex=True
        )
        _draw_forces(axes[0], history, places)
        if creepages:
            _draw_creepages(axes[1], creepages, places)
        _draw_middle_row(axes[-1], history, edges)
        axes[-1].set_xlabel(label)
        for ax in axes:
            ax.legend(**style.BESIDE)
    return figure


def _resulting_creepages(history: History) -> dict[str, np.ndarray]:
    """Creepages that prescribed forces give, by "vx" and "vy": NaN in steps without any."""
    motions = [sol.motion for sol in history]
    creepages = {}
    for i, (name, force) in enumerate((("vx", "Fx"), ("vy", "Fy"))):
        forced = [
            motion is not None and motion.rolls != 0 and getattr(motion, force) is not None
            for motion in motions
        ]
        values = np.where(forced, history.creepage[:, i], np.nan)
        if np.isfinite(values).any():
            creepages[name] = values
    return creepages


def _draw_creepages(ax: Axes, creepages: dict[str, np.ndarray], places: np.ndarray) -> None:
    looks: dict[str, dict[str, Any]] = {
        "vx": {"marker": "o", "linestyle": "-", "label": "$v_x$"},
        "vy": {"marker": "s", "linestyle": "--", "label": "$v_y$"},
    }
    measured = measure(None, "1", list(creepages.values()))
    size = 2.5 if places.size < MARKED_STEPS else 0
    for name, values in creepages.items():
        ax.plot(places, measured(values), **looks[name], markersize=size, clip_on=False)
    ax.axhline(0, color="k", linewidth=0.5)
    ax.set_ylabel(measured.label("creepage found"))


def _draw_middle_row(ax: Axes, history: History, edges: np.ndarray) -> None:
    """Stick and slip areas along the middle row of elements, over the steps."""
    lengths = measure(history.scene, "length", history.grid.box)
    state = np.array([sol.state[history.grid.rows // 2] for sol in history]).T
    across = lengths(history.grid.lines[0])
    draw_states(ax, state, edges, across, max(len(sol.states) for sol in history))
    ax.set(xlim=edges[[0, -1]], ylim=across[[0, -1]])
    ax.set_ylabel(lengths.label("x" if history.scene.line else "x, middle row"))


def _abscissa(history: History) -> tuple[np.ndarray, np.ndarray, str]:
    """Places of the steps, the edges between which each takes place, and the label.

    These are the distance rolled, or the numbers of the steps where steps after the first are in
    place.
    """
    if len(history) > 1 and np.all(history.dq[1:] > 0):
        measured = measure(history.scene, "length", history.rolled)
        rolled = measured(history.rolled)
        return rolled, np.append(0.0, rolled), measured.label("distance rolled")
    edges = np.arange(len(history) + 1) - 0.5
    return edges[:-1] + 0.5, edges, "step"


def _draw_forces(ax: Axes, history: History, places: np.ndarray) -> None:
    limit = np.array([friction_limit(sol) for sol in history])
    finite = bool(np.all(np.isfinite(limit)))
    drawn = [*history.force.T]
    if finite:
        drawn.append(limit)
    measured = measure(history.scene, "force", drawn)
    Fx, Fy = history.force.T
    looks: list[dict[str, Any]] = [
        {"marker": "o", "linestyle": "-", "label": "$F_x$"},
        {"marker": "s", "linestyle": "--", "label": "$F_y$"},
    ]
    if len(history) >= MARKED_STEPS:
        for look in looks:
            look["marker"] = ""
    ax.plot(places, measured(Fx), **looks[0], markersize=2.5, clip_on=False)
    size = np.abs(history.force).max(initial=0.0)
    if np.abs(Fy).max(initial=0.0) > 1e-9 * size:
        ax.plot(places, measured(Fy), **looks[1], markersize=2.5, clip_on=False)
    if finite:
        ax.plot(places, measured(limit), color="0.45", linestyle=":", label="$\\pm$ friction limit")
        ax.plot(places, -measured(limit), color="0.45", linestyle=":")
    ax.set_ylabel(measured.label("tangential force"))


def animate(
    history: History,
    path: str | Path,
    fps: float = 10.0,
    field: str = "path",
    overwrite: bool = False,
) -> None:
    """Write a moving picture of a history, see `History.animate`; `field` is what the path is
    called in errors.
    """
    path = checks.file_name(field, path)
    fps = checks.number("fps", checks.positive("fps", fps), most=100.0)
    if len(history) == 0:
        raise SceneError("history", history, "of one step at least")
    check_animation(field, path, [], overwrite)
    writer = KINDS[path.suffix.lower()](fps=fps, metadata={"comment": style.MARK})
    with (
        tempfile.TemporaryDirectory() as folder,
        reading(path, "cannot be drawn", field, (OSError, CalledProcessError)),
        style.styled(),
    ):
        film = Path(folder) / f"film{path.suffix.lower()}"
        _draw_steps(history, film, writer)
        content = film.read_bytes()
    mark = style.MARK.encode()
    if mark not in content:
        content += mark
    write_whole(field, path, content)


def check_animation(field: str, path: Path, inputs: list[Path], overwrite: bool) -> None:
    """Refuse a file that no moving picture can be written to; `inputs` have to stay."""
    check_replaceable(field, path, KINDS, "picture", style.OURS, overwrite, inputs)
    if not KINDS[path.suffix.lower()].isAvailable():
        raise OutputError(
            field, path, "needs the program ffmpeg, which is not installed; .gif needs nothing else"
        )


def _draw_steps(history: History, film: Path, writer: Any) -> None:
    """Each step as a frame: areas and tractions over the forces, on axes that stay."""
    places, _, label = _abscissa(history)
    box = box_of(np.any([sol.state > 0 for sol in history], axis=0), history.grid)
    line = history.scene.line
    # the largest traction, or bound in line contact, of all steps
    largest = 0.0
    for sol in history:
        largest = max(largest, float(np.hypot(*sol.traction).max()))
        if line and np.all(np.isfinite(sol.traction_bound)):
            largest = max(largest, float(sol.traction_bound.max()))
    figure, (above, below) = style.new_figure(
        2, 1, (style.COLUMN * 1.4, 4.8), height_ratios=(2.2, 1)
    )
    _draw_forces(below, history, places)
    below.set_xlabel(label)
    below.legend(**style.BESIDE)
    mark = below.axvline(places[0], color="k", linewidth=0.8)
    pixels = np.prod(figure.get_size_inches()) * figure.dpi**2
    need("the moving picture", 4.0 * len(history) * pixels, "a history of fewer steps would fit")
    with writer.saving(figure, film, None):
        for k, sol in enumerate(history):
            above.clear()
            if line:
                draw_section(above, sol, box=box, largest=largest)
            else:
                draw_areas(above, sol, box, largest)
            above.set_title(f"Tangential traction on body 1, step {k}")
            mark.set_xdata([places[k]] * 2)
            if k == 0:
                figure.draw_without_rendering()
                figure.set_layout_engine(None)  # frames are drawn once
            writer.grab_frame()
