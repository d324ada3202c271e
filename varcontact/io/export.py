"""Solutions for other programs, one value an element: tables, CSV, VTK's files for ParaView,
MATLAB's.
"""

from __future__ import annotations

import base64
import io
import json
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.io.html_page import HEAD, html_page
from varcontact.io.quantities import FIELDS, NUMBERS
from varcontact.results.solution import Solution
from varcontact.scene.units import IN_WORDS

if TYPE_CHECKING:
    import pandas as pd

FORMAT = "varcontact elements 1"
MAT_HEAD = f"MATLAB 5.0 MAT-file, {FORMAT}".encode()
"""Text at the beginning of MATLAB's files."""
TEXT_OF_MAT = 116
"""Bytes of that text."""

COLUMNS = (
    "pressure",
    "traction_x",
    "traction_y",
    "traction_bound",
    "slip_x",
    "slip_y",
    "distance",
    "state",
    "power_density",
)
QUANTITIES = {"x": "length", "y": "length"}
QUANTITIES |= {name: FIELDS[name.removesuffix("_x").removesuffix("_y")][1] for name in COLUMNS}
"""Columns of the table with their quantities."""
SINGLE = (
    "normal_force",
    "Fx",
    "Fy",
    "Mz",
    "approach",
    "vx",
    "vy",
    "spin",
    "max_pressure",
    "friction_work",
)
LOADS = {"power": "work"} | {name: NUMBERS[name][0] for name in SINGLE}
"""Single numbers of a solution, as its properties are named."""


def dataframe(sol: Solution) -> pd.DataFrame:
    """One row per element, see `Solution.to_dataframe`."""
    import pandas as pd

    frame = pd.DataFrame(_columns(sol))
    frame.attrs = {"format": FORMAT, "units": units_by_name(sol)}
    return frame


def units_by_name(sol: Solution) -> dict[str, str]:
    """Units of columns and of single numbers; in words if the scene names no units."""
    units = sol.scene.units or IN_WORDS
    shift = sol.motion is not None and sol.motion.rolls == 0
    return {
        name: units.of(kind, sol.scene.line, shift)
        for name, kind in {**QUANTITIES, **LOADS}.items()
    }


def _columns(sol: Solution) -> dict[str, np.ndarray]:
    """Columns of the table, rows of elements after each other: (ny nx,)."""
    x, y = np.meshgrid(sol.grid.x, sol.grid.y)
    fields = {
        "x": x,
        "y": y,
        "state": sol.state.astype(np.int8),
        "power_density": sol.power_density,
    }
    fields |= {name: getattr(sol, name) for name in ("pressure", "traction_bound", "distance")}
    for name in ("traction", "slip"):
        fields |= dict(zip((f"{name}_x", f"{name}_y"), getattr(sol, name), strict=True))
    return {name: np.asarray(fields[name]).ravel() for name in QUANTITIES}


def _to_mat(sol: Solution) -> bytes:
    from scipy.io import savemat

    from varcontact.io.scene_toml import scene_to

    fields = {name: column.reshape(sol.grid.shape) for name, column in _columns(sol).items()}
    variables: dict[str, Any] = {**fields, "x": sol.grid.x, "y": sol.grid.y}
    variables |= {name: float(getattr(sol, name)) for name in LOADS}
    variables |= {
        "units": units_by_name(sol),
        "scene": json.dumps(scene_to(sol.scene)),
        "format": FORMAT,
    }
    made = io.BytesIO()
    savemat(made, variables, do_compression=True, oned_as="row")
    return MAT_HEAD.ljust(TEXT_OF_MAT) + made.getvalue()[TEXT_OF_MAT:]


def _to_vtu(sol: Solution) -> bytes:
    """Elements as quadrilaterals in the plane z = 0."""
    ny, nx = sol.grid.shape
    dx, dy = sol.grid.sides
    left, _, bottom, _ = sol.grid.box
    x, y = np.meshgrid(left + dx * np.arange(nx + 1), bottom + dy * np.arange(ny + 1))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = np.arange(nx) + (nx + 1) * np.arange(ny)[:, None]
    cells = np.stack([corner, corner + 1, corner + nx + 2, corner + nx + 1], axis=-1).reshape(-1, 4)
    return unstructured(points, cells, 9, _cell_arrays(sol), at_cells=True)


def unstructured(
    points: np.ndarray,
    cells: np.ndarray,
    kind: int,
    arrays: dict[str, np.ndarray],
    at_cells: bool = False,
) -> bytes:
    """VTK's file of cells of one kind, shape (n, corners), with arrays at points or cells."""
    corners = cells.shape[1]
    where = "PointData"
    if at_cells:
        where = "CellData"
    body = [
        "<UnstructuredGrid>",
        f'<Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}">',
        *("<Points>", _array("points", points), "</Points>"),
        "<Cells>",
        _array("connectivity", cells.reshape(-1).astype(np.int64)),
        _array("offsets", corners * np.arange(1, len(cells) + 1, dtype=np.int64)),
        _array("types", np.full(len(cells), kind, dtype=np.uint8)),
        "</Cells>",
        f"<{where}>",
        *(_array(name, values) for name, values in arrays.items()),
        f"</{where}>",
        "</Piece>",
        "</UnstructuredGrid>",
    ]
    return _vtk_file("UnstructuredGrid", body)


def _to_vti(sol: Solution) -> bytes:
    ny, nx = sol.grid.shape
    dx, dy = sol.grid.sides
    left, _, bottom, _ = sol.grid.box
    extent = f"0 {nx} 0 {ny} 0 0"
    left, bottom, dx, dy = map(float, (left, bottom, dx, dy))
    place = f'Origin="{left!r} {bottom!r} 0" Spacing="{dx!r} {dy!r} 1"'
    piece = f'<Piece Extent="{extent}">'
    body = [
        f'<ImageData WholeExtent="{extent}" {place}>',
        piece,
        "<CellData>",
        *(_array(name, values) for name, values in _cell_arrays(sol).items()),
        "</CellData>",
        "</Piece>",
        "</ImageData>",
    ]
    return _vtk_file("ImageData", body)


def _cell_arrays(sol: Solution) -> dict[str, np.ndarray]:
    """Fields by element; vectors with three components, as VTK has them."""
    columns = _columns(sol)
    arrays = {
        name: columns[name] for name in QUANTITIES if name not in ("x", "y") and name[-2] != "_"
    }
    for name in ("traction", "slip"):
        plane = [columns[f"{name}_x"], columns[f"{name}_y"]]
        arrays[name] = np.stack([*plane, np.zeros_like(plane[0])], axis=1)
    return arrays


_VTK_TYPES = {"float64": "Float64", "int64": "Int64", "uint8": "UInt8", "int8": "Int8"}


def _array(name: str, values: np.ndarray) -> str:
    """An array with the number of its bytes before them."""
    content = np.ascontiguousarray(values, dtype=values.dtype.newbyteorder("<")).tobytes()
    text = base64.b64encode(np.uint64(len(content)).astype("<u8").tobytes() + content).decode()
    parts = f' NumberOfComponents="{values.shape[1]}"' if values.ndim == 2 else ""
    kind = _VTK_TYPES[values.dtype.name]
    return f'<DataArray type="{kind}" Name="{name}"{parts} format="binary">{text}</DataArray>'


def _vtk_file(kind: str, body: list[str]) -> bytes:
    head = f'<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
    return (VTK_HEAD + "\n".join([head, *body, "</VTKFile>", ""])).encode()


VTK_HEAD = f'<?xml version="1.0"?>\n<!-- {FORMAT} -->\n'
EXPORTS: dict[str, tuple[Callable[[Solution], bytes], bytes]] = {
    ".csv": (
        lambda sol: dataframe(sol).to_csv(index=False).encode(),
        ",".join(QUANTITIES).encode(),
    ),
    ".vtu": (_to_vtu, re.escape(VTK_HEAD.encode())),
    ".vti": (_to_vti, re.escape(VTK_HEAD.encode())),
    ".mat": (_to_mat, MAT_HEAD),
    ".html": (html_page, HEAD),
}
"""Export formats by file ending: the function that makes the bytes of a solution, and the pattern
of how they begin."""
