"""Files of convex programs: NumPy's archives, and the format of the Conic Benchmark Library.

CBF is described by H. A. Friberg, "The Conic Benchmark Format", cblib.zib.de. Its objective is
linear: a quadratic one becomes the variable t at the end, with ``2 t >= |L x|^2``, ``P = L'L``.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.solvers.conic.languages import full_quadratic
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.system.files import check_replaceable, write_whole

CBF_HEAD = "# convex program by varcontact"
NPZ_HEAD = "varcontact"
"""First entry of an archive, by which it is recognised."""
CBF_CONES = {"zero": "L=", "nonnegative": "L+", "second_order": "Q"}
"""Cones by their names in CBF."""
FORMATS = {
    ".npz": rf"PK\x03\x04.{{26}}{NPZ_HEAD}\.npy".encode(),
    ".cbf": CBF_HEAD.encode(),
}
"""Beginnings of our own files by their ending."""


def save(program: ConicProgram, path: str | Path, notes: Iterable[str], overwrite: bool) -> None:
    """See `Program.save`."""
    path = checks.file_name("path", path)
    ours = FORMATS.get(path.suffix.lower(), b"")
    check_replaceable("path", path, FORMATS, "program", ours, overwrite)
    if path.suffix.lower() == ".cbf":
        content = cbf(program, notes).encode()
    else:
        content = _archive(program, notes)
    write_whole("path", path, content)


def _archive(program: ConicProgram, notes: Iterable[str]) -> bytes:
    P = full_quadratic(program)
    A = program.A
    places = {"variables": program.variables, "rows": program.rows}
    entries: dict[str, Any] = {NPZ_HEAD: np.array(list(notes), dtype=str)}
    for name, matrix in (("P", P), ("A", A)):
        entries |= {
            f"{name}_data": matrix.data,
            f"{name}_indices": matrix.indices,
            f"{name}_indptr": matrix.indptr,
            f"{name}_shape": np.array(matrix.shape),
        }
    entries |= {"q": program.q, "b": program.b}
    entries["cones"] = np.array([kind for kind, _ in program.cones], dtype=str)
    entries["cone_sizes"] = np.array([size for _, size in program.cones])
    for kind, blocks in places.items():
        entries[kind] = np.array(list(blocks), dtype=str)
        entries[f"{kind}_ends"] = np.array([place.stop for place in blocks.values()])
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **entries)
    return buffer.getvalue()


def cbf(program: ConicProgram, notes: Iterable[str] = ()) -> str:
    """A program as the text of a CBF file, version 3."""
    from scipy.sparse import csr_matrix, vstack

    factor = _factor(program)
    n = program.q.size
    rows = program.b.size

    # rows b - A x, then (t, 1, L x)
    with_t = np.zeros((len(factor) + 2, n + 1))
    with_t[0, n] = 1.0
    with_t[2:, :n] = factor
    A = csr_matrix(-program.A)
    A.resize(rows, n + 1)
    matrix = vstack([A, with_t]).tocoo()
    constants = np.concatenate([program.b, [0.0, 1.0], np.zeros(len(factor))])
    cones = [f"{CBF_CONES[kind]} {size}" for kind, size in program.cones]
    cones.append(f"QR {len(factor) + 2}")
    costs = np.append(program.q, 1.0)
    blocks = {
        "VER": ["3"],
        "OBJSENSE": ["MIN"],
        "VAR": [f"{n + 1} 1", f"F {n + 1}"],
        "CON": [f"{rows + len(factor) + 2} {len(cones)}", *cones],
        "OBJACOORD": _coordinates(costs, np.flatnonzero(costs)),
        "ACOORD": _coordinates(matrix.data, matrix.row, matrix.col),
        "BCOORD": _coordinates(constants, np.flatnonzero(constants)),
    }
    head = [CBF_HEAD, *(f"# {note}" for note in notes)]
    body = ["\n".join([name, *lines]) for name, lines in blocks.items()]
    return "\n".join(head) + "\n\n" + "\n\n".join(body) + "\n"


def _factor(program: ConicProgram) -> np.ndarray:
    """L with ``P = L'L``, a row for each variable with a square; by eigenvalues where rounding
    leaves none by Cholesky.
    """
    from scipy.linalg import LinAlgError, cholesky, eigh

    P = full_quadratic(program).toarray()
    squared = np.flatnonzero(P.any(axis=0))
    block = P[np.ix_(squared, squared)]
    try:
        root = cholesky(block)
    except LinAlgError:
        values, vectors = eigh(block)
        root = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    factor = np.zeros((squared.size, len(P)))
    factor[:, squared] = root
    return factor


def _coordinates(values: np.ndarray, *places: np.ndarray) -> list[str]:
    """Lines of entries by their places; of a vector those at these places."""
    if len(places) == 1:
        values = values[places[0]]
    return [str(values.size), *_lines(values, places)]


def _lines(values: np.ndarray, places: tuple[np.ndarray, ...]) -> Iterator[str]:
    for *indices, value in zip(*(place.tolist() for place in places), values.tolist(), strict=True):
        yield f"{' '.join(map(str, indices))} {value!r}"
