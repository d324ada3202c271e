"""A history as a moving picture."""

from __future__ import annotations

import io
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path
from shutil import which
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import OutputError, SceneError
from varcontact.plotting.drawn import drawn
from varcontact.plotting.history import abscissa, draw_forces
from varcontact.plotting.line import draw_line_traction
from varcontact.plotting.maps import box_of, draw_areas
from varcontact.plotting.picture_file import MARK, is_ours
from varcontact.plotting.style import COLUMN, new_figure, settle, styled
from varcontact.system.files import check_replaceable, check_writable, write_whole
from varcontact.system.memory import need

if TYPE_CHECKING:
    from varcontact.results.history import History
    from varcontact.results.solution import Solution

FRAMES_PER_SECOND = 10.0
KINDS = (".gif", ".mp4")


def animate(
    history: History,
    path: str | Path,
    fps: float = FRAMES_PER_SECOND,
    field: str = "path",
    overwrite: bool = False,
) -> None:
    """Write a moving picture of a history, see `History.animate`.

    Parameters
    ----------
    history : History
    path : str or Path
    fps : float
        Steps a second.
    field : str
        What the path is called in an error.
    overwrite : bool
        Whether to replace a file that is no picture which varcontact drew.

    Raises
    ------
    OutputError
        If the file cannot be written, or has another ending.
    SceneError
        If there are no steps, or for a rate that is none.
    """
    path = checks.file_name(field, path)
    fps = checks.positive("fps", fps)
    if fps > 100:
        raise SceneError("fps", fps, "at most 100 steps a second")
    if len(history) == 0:
        raise SceneError("history", history, "of one step at least")
    check_animation(field, path, [], overwrite)
    make = _gif if path.suffix.lower() == ".gif" else _film
    write_whole(field, path, make(_frames(history), len(history), fps))


def check_animation(field: str, path: Path, inputs: list[Path], overwrite: bool) -> None:
    """Refuse a file that no moving picture can be written to.

    Parameters
    ----------
    field : str
        What the path is called in an error.
    path : Path
    inputs : list of Path
        Files that have to stay.
    overwrite : bool
        Whether to replace a file that is no picture which varcontact drew.

    Raises
    ------
    OutputError
        For another ending than .gif or .mp4, .mp4 where there is no ffmpeg, a place that cannot be written, or a file
        that is another's.
    """
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise OutputError(field, path, f"its ending must be one of {', '.join(KINDS)}")
    if kind == ".mp4" and which("ffmpeg") is None:
        raise OutputError(field, path, "needs the program ffmpeg, which is not installed; .gif needs nothing else")
    check_writable(field, path, inputs)
    check_replaceable(field, path, "picture", is_ours, overwrite)


def _frames(history: History) -> Iterator[np.ndarray]:
    """Each step as an image (height, width, 4) of bytes: areas and tractions over the forces, on axes that stay."""
    along, box = abscissa(history), _common_box(history)
    largest = max(_largest(sol) for sol in history)
    with styled():
        figure, (above, below) = new_figure(2, 1, (COLUMN * 1.4, 4.8), height_ratios=(2.2, 1))
        canvas: Any = figure.canvas
        draw_forces(below, history, along)
        mark = below.axvline(along.values[0], color="k", linewidth=0.8)
        for k, sol in enumerate(history):
            above.clear()
            draw = draw_line_traction if history.scene.line else draw_areas
            draw(above, sol, box, largest)
            above.set_title(f"Tangential traction on body 1, step {k}{drawn(sol).words}")
            mark.set_xdata([along.values[k]] * 2)
            if k == 0:
                settle(figure)
                figure.set_layout_engine("none")
            canvas.draw()
            yield np.array(canvas.buffer_rgba())


def _common_box(history: History) -> tuple[float, float, float, float]:
    """What is in contact in any step, with a margin of two elements."""
    contact = np.any([sol.state > 0 for sol in history], axis=0)
    return box_of(contact, history.grid)


def _largest(sol: Solution) -> float:
    """The largest number that is drawn of a step: a traction, in line contact also its bound."""
    field = drawn(sol)
    largest, bound = float(np.hypot(*field.traction).max()), field.bounds[1]
    return max(largest, float(bound.max())) if sol.scene.line and np.all(np.isfinite(bound)) else largest


def _gif(frames: Iterator[np.ndarray], count: int, fps: float) -> bytes:
    from PIL import Image

    first = next(frames)
    need("the moving picture", 2.0 * count * first[..., 0].size, "a history of fewer steps would fit")
    images = (
        Image.fromarray(each).convert("RGB").quantize(dither=Image.Dither.NONE) for each in chain([first], frames)
    )
    made = io.BytesIO()
    options: dict[str, Any] = {"save_all": True, "append_images": images, "loop": 0, "comment": MARK.encode()}
    next(images).save(made, format="GIF", duration=round(1000 / fps), **options)
    return made.getvalue()


def _film(frames: Iterator[np.ndarray], count: int, fps: float) -> bytes:
    """By ffmpeg, which takes frame by frame, whatever their `count`."""
    first = next(frames)
    height, width = first.shape[:2]
    given = ["-f", "rawvideo", "-pixel_format", "rgba", "-video_size", f"{width}x{height}", "-framerate", f"{fps:g}"]
    wanted = ["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p", "-metadata", f"comment={MARK}"]
    with tempfile.TemporaryDirectory() as folder:
        film = Path(folder) / "film.mp4"
        command = ["ffmpeg", "-loglevel", "error", *given, "-i", "-", *wanted, str(film)]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            assert process.stdin is not None
            with suppress(BrokenPipeError):  # it says below what was wrong
                for frame in chain([first], frames):
                    process.stdin.write(frame.tobytes())
            _, said = process.communicate()
        if process.returncode != 0:
            words = said.decode(errors="replace").strip().split("\n")[-1]
            raise OutputError("path", "film.mp4", f"cannot be drawn (ffmpeg: {words})")
        return film.read_bytes()
