"""Stresses below surfaces as datasets, and as files for ParaView."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.io.export import VTK_HEAD, unstructured
from varcontact.io.labelled import variable

if TYPE_CHECKING:
    import xarray as xr

AXES = "xyz"
HEXAHEDRON = 12
VERTEX = 1
"""Types of cells of VTK."""


def grid_of(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """x, y and z of points, shape (3, nz, ny, nx), that are a grid; None if they are not."""
    if points.ndim != 4:
        return None
    x = points[0, 0, 0, :]
    y = points[1, 0, :, 0]
    z = points[2, :, 0, 0]
    z_of, y_of, x_of = np.meshgrid(z, y, x, indexing="ij")
    if np.array_equal(points, np.stack([x_of, y_of, z_of])):
        return x, y, z
    return None


def stress_dataset(field: Any) -> xr.Dataset:
    """See `SubsurfaceStress.to_xarray`."""
    import xarray as xr

    length = field.units.of("length")
    pressure = field.units.of("pressure")
    grid = grid_of(field.points)
    dims: tuple[str, ...] = ("point",)
    shape: tuple[int, ...] = (-1,)
    coordinates = {
        axis: variable("point", each.reshape(-1), length, f"{axis} of the point")
        for axis, each in zip(AXES, field.points, strict=True)
    }
    if grid is not None:
        dims = ("z", "y", "x")
        shape = field.points.shape[1:]
        coordinates = {
            axis: variable(axis, each, length, f"{axis} of the points")
            for axis, each in zip(AXES, grid, strict=True)
        }
    variables: dict[str, Any] = {}
    for axis, component in zip(AXES, field.displacement, strict=True):
        words = f"displacement along {axis}"
        variables[f"displacement_{axis}"] = variable(dims, component.reshape(shape), length, words)
    for i, first in enumerate(AXES):
        for j, second in list(enumerate(AXES))[i:]:
            component = field.stress[i, j].reshape(shape)
            words = f"stress {first}{second}, tension positive"
            variables[f"stress_{first}{second}"] = variable(dims, component, pressure, words)
    for name, words in (("von_mises", "equivalent stress of von Mises"), ("tresca", "of Tresca")):
        variables[name] = variable(dims, getattr(field, name).reshape(shape), pressure, words)
    return xr.Dataset(variables, coordinates, {"body": field.body})


def _to_vtu(field: Any) -> bytes:
    """The points of a grid as corners of hexahedra, others as vertices; all fields at points."""
    points = field.points.reshape(3, -1).T
    grid = grid_of(field.points)
    kind = VERTEX
    corners = np.arange(len(points))[:, None]
    if grid is not None and min(each.size for each in grid) > 1:
        kind = HEXAHEDRON
        x, y, z = grid
        corners = _hexahedra(x.size, y.size, z.size, upwards=bool(z[1] > z[0]))
    stress = np.moveaxis(field.stress.reshape(3, 3, -1), -1, 0)
    arrays = {
        "displacement": field.displacement.reshape(3, -1).T,
        "stress": stress.reshape(-1, 9),
        "von_mises": field.von_mises.reshape(-1),
        "tresca": field.tresca.reshape(-1),
    }
    return unstructured(points, corners, kind, arrays)


def _hexahedra(nx: int, ny: int, nz: int, upwards: bool) -> np.ndarray:
    """Indices of the corners of the cells between points of a grid, in VTK's order, (n, 8); layers
    go upwards, or downwards.
    """
    number = np.arange(nx * ny * nz).reshape(nz, ny, nx)
    below = [number[:-1, :-1, :-1], number[:-1, :-1, 1:], number[:-1, 1:, 1:], number[:-1, 1:, :-1]]
    above = [each + nx * ny for each in below]
    corners = [*below, *above]
    if not upwards:
        corners = [*above, *below]
    return np.stack(corners, axis=-1).reshape(-1, 8)


VTK_FORMATS: Mapping[str, tuple[Callable[[Any], bytes], bytes]] = {
    ".vtu": (_to_vtu, re.escape(VTK_HEAD.encode()))
}
