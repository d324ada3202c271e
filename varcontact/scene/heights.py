"""Heights of measured surfaces: from files and other packages, levelled, and their roughness."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.system.files import first_line, text_of

EVEN = 1e-3
"""Largest deviation of a step between samples from the usual step, relative to that."""
REMOVED = ("mean", "plane", "curvature")
"""Shapes that can be removed, each including those before it: a constant, a plane, a paraboloid."""
ENDINGS = (".npy", ".csv", ".txt", ".xyz")


@dataclass(frozen=True)
class Roughness:
    """Roughness of samples about a paraboloid, as in ISO 25178.

    Attributes
    ----------
    Sq : float
        Root mean square height [length].
    slope_x, slope_y : float
        Root mean square slopes along x and y [-]; 0 along y in line contact.
    """

    Sq: float
    slope_x: float
    slope_y: float


def read_heights(source: Any, spacing: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights (ny, nx), x and y of an object with ``heights()`` and ``positions()``, of a file, or
    of an array of a `spacing`.
    """
    if hasattr(source, "heights") and hasattr(source, "positions"):
        if spacing is not None:
            raise SceneError("spacing", spacing, "left out: the object has its positions")
        return _of_object(source)
    values = source
    if isinstance(source, str | Path):
        values = _of_file(checks.file_name("source", source))
        columns = Path(source).suffix.lower() == ".xyz" or (
            spacing is None and values.ndim == 2 and values.shape[1] == 3
        )
        if columns:
            return _of_columns(values)
    return _of_array(values, spacing)


def _of_array(values: Any, spacing: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights (ny, nx), or in a row, of even steps."""
    heights = _without_holes(values)
    if heights.ndim == 1:
        heights = heights[None, :]
    if heights.ndim != 2 or heights.shape[1] < 3:
        raise checks.wrong_shape("source", heights.shape, "heights (ny, nx), three columns or more")
    if spacing is None:
        raise SceneError("spacing", None, "given: the distance of samples along x, or (dx, dy)")
    steps = checks.numbers("spacing", spacing)
    if steps.shape not in ((), (2,)):
        raise checks.wrong_shape("spacing", steps.shape, "a number, or (dx, dy)")
    steps = np.broadcast_to(steps, (2,))
    dx = checks.positive("spacing", float(steps[0]))
    dy = checks.positive("spacing", float(steps[1]))
    return heights, _centred(heights.shape[1], dx), _centred(heights.shape[0], dy)


def _centred(count: int, step: float) -> np.ndarray:
    return (np.arange(count) - (count - 1) / 2) * step


def _of_object(source: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights of objects such as those of SurfaceTopography, whose first index counts along x."""
    heights = _without_holes(source.heights())
    positions = source.positions()
    if heights.ndim == 1:
        x = checks.array("source.positions", np.asarray(positions).reshape(-1), 1)
        _check_even("x", x)
        return heights[None, :], x - x.mean(), np.zeros(1)
    places = [np.asarray(each, dtype=float) for each in positions]
    if len(places) != 2 or any(each.shape != heights.shape for each in places):
        given = f"{len(places)} arrays"
        raise SceneError("source.positions", given, f"x and y, each of shape {heights.shape}")
    x = places[0][:, 0]
    y = places[1][0, :]
    if x[0] == x[-1]:  # the first index counts along y
        x = places[0][0, :]
        y = places[1][:, 0]
        heights = heights.T
    _check_even("x", x)
    _check_even("y", y)
    return heights.T, x - x.mean(), y - y.mean()


def _of_file(path: Path) -> np.ndarray:
    """Numbers of a file; objects in `.npy` are refused, nothing is unpickled."""
    if path.suffix.lower() not in ENDINGS:
        raise SceneError("source", str(path), f"a file that ends in {', '.join(ENDINGS)}")
    try:
        if path.suffix.lower() == ".npy":
            return np.asarray(np.load(path, allow_pickle=False))
        text = text_of("source", path)
        lines = [line.replace(",", " ").replace(";", " ") for line in text.splitlines()]
        return np.loadtxt(lines, ndmin=2)
    except (OSError, ValueError, EOFError, MemoryError) as error:
        allowed = f"a readable file of numbers ({first_line(error)})"
        raise SceneError("source", str(path), allowed) from None


def _of_columns(values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns x, y and height, in any order of the rows."""
    if values.ndim != 2 or values.shape[1] != 3:
        raise checks.wrong_shape("source", values.shape, "three columns: x, y, height")
    values = _without_holes(values)
    x, column = np.unique(values[:, 0], return_inverse=True)
    y, row = np.unique(values[:, 1], return_inverse=True)
    heights = np.full((y.size, x.size), np.nan)
    heights[row, column] = values[:, 2]
    if len(values) != heights.size or np.isnan(heights).any():
        allowed = f"one height for each of {x.size} x {y.size} places: no holes, none twice"
        raise SceneError("source", len(values), allowed)
    _check_even("x", x)
    if y.size > 1:
        _check_even("y", y)
    return heights, x - x.mean(), y - y.mean()


def _without_holes(values: Any) -> np.ndarray:
    """Heights as an array of floats; masked and missing ones are refused."""
    holes = np.ma.getmaskarray(values)
    heights = np.ma.getdata(values)
    if heights.dtype.kind not in "iuf":
        raise SceneError("source", heights.dtype.name, "heights as numbers")
    heights = heights.astype(float)
    holes = holes | ~np.isfinite(heights)
    if holes.any():
        first = tuple(int(each[0]) for each in np.nonzero(holes))
        missing = f"{int(holes.sum())} of {holes.size} heights missing, the first at {first}"
        message = f"source must be without holes: {missing}; fill them first"
        raise SceneError("source", missing, "heights without holes", message=message)
    return heights


def _check_even(axis: str, places: np.ndarray) -> None:
    steps = np.diff(places)
    if steps.size == 0:
        raise SceneError("source", axis, f"two places along {axis} or more")
    usual = float(np.median(steps))
    if usual <= 0 or (np.abs(steps - usual) > EVEN * usual).any():
        worst = int(np.abs(steps - usual).argmax())
        allowed = f"evenly spaced, ascending {axis}; the step after {axis} = {places[worst]:.6g} is"
        raise SceneError("source", axis, f"{allowed} {steps[worst]:.6g}, the usual {usual:.6g}")


def levelled(heights: np.ndarray, x: np.ndarray, y: np.ndarray, remove: str) -> np.ndarray:
    """Heights (ny, nx) without their mean, plane or paraboloid of least squares."""
    X, Y = np.meshgrid(_scaled(x), _scaled(y))
    parts = [np.ones_like(X)]
    if remove in ("plane", "curvature"):
        parts += [X, Y]
    if remove == "curvature":
        parts += [X**2, X * Y, Y**2]
    columns = np.stack([each.ravel() for each in parts], axis=1)
    fitted = np.linalg.lstsq(columns, heights.ravel(), rcond=None)[0]
    return np.asarray(heights - (columns @ fitted).reshape(heights.shape))


def _scaled(places: np.ndarray) -> np.ndarray:
    size = float(np.abs(places).max())
    if size == 0:
        return places
    return places / size


def roughness_of(heights: np.ndarray, x: np.ndarray, y: np.ndarray) -> Roughness:
    """Sq and slopes of heights (ny, nx) about a paraboloid."""
    rest = levelled(heights, x, y, "curvature")
    slope_y = 0.0
    if y.size > 1:
        slope_y = _rms(np.diff(rest, axis=0) / np.diff(y)[:, None])
    slope_x = _rms(np.diff(rest, axis=1) / np.diff(x))
    return Roughness(Sq=_rms(rest), slope_x=slope_x, slope_y=slope_y)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
