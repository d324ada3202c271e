"""A table book for vehicle codes: C99, the wrappers of MATLAB and Modelica, and functional mock-up
units (FMUs).
"""

from __future__ import annotations

import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping
from importlib.resources import files
from io import BytesIO
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np

import varcontact
from varcontact import checks
from varcontact.errors import OutputError, SceneError
from varcontact.reference.creepage_coefficients import END, coefficient_splines
from varcontact.system.files import check_replaceable, reading, write_whole
from varcontact.theories.table import NU_TOL, book_of
from varcontact.theories.table_book import (
    AT_FULL,
    FULL_SLIP_FACTOR,
    HALFWAY,
    KNEE,
    ROOM,
    SPIN,
    TableBook,
    packed,
    shipped,
)

LIBRARY = "vc_forces.c", "vc_forces.h", "vc_forces.m", "VcForces.mo"
MARK = b"Made by varcontact"
PLATFORMS = {
    ("linux", "x86_64"): ("linux64", "x86_64-linux", ".so"),
    ("linux", "aarch64"): ("aarch64-linux", "aarch64-linux", ".so"),
    ("darwin", "x86_64"): ("darwin64", "x86_64-darwin", ".dylib"),
    ("darwin", "arm64"): ("darwin64", "aarch64-darwin", ".dylib"),
    ("win32", "AMD64"): ("win64", "x86_64-windows", ".dll"),
}
"""Folders of binaries by FMI 2.0 and by FMI 3.0, and the ending of shared libraries."""
BETWEEN = (
    " Between them, the largest difference from exact solutions\n"
    " * at 1270 random points was 0.0077."
)
"""Measured accuracy of the book of the package, see docs/fast_theories.md."""


def write_c(
    folder: str | Path,
    book: TableBook | None = None,
    overwrite: bool = False,
    field: str = "folder",
) -> list[Path]:
    """Write a table book as C99 source without dependencies, with the wrappers
    of MATLAB and Modelica.

    Parameters
    ----------
    folder : str or Path
        It is made, if it is not there.
    book : TableBook, optional
        Table book; by default that of the package (nu = 0.28).
    overwrite : bool
        Whether to replace files of these names that varcontact did not write.
    field : str
        Name of the folder in errors.

    Returns
    -------
    list of Path
        ``vc_forces.c``, ``vc_forces.h``, which documents arguments, units and
        return codes, ``vc_forces.m``, and ``VcForces.mo``.

    Raises
    ------
    SceneError
        If the a/b of the book are not within 1e-3 and 1e3.
    OutputError
        If a file cannot be written.

    Notes
    -----
    Forces are those of `theories.table_forces` to rounding, with derivatives by the creepages if
    wanted.
    """
    known = _entries(book)
    return _written(
        folder, {name: _filled(name, known).encode() for name in LIBRARY}, overwrite, field
    )


def write_fmu(
    folder: str | Path,
    book: TableBook | None = None,
    overwrite: bool = False,
    field: str = "folder",
) -> list[Path]:
    """Write a table book as source-code FMUs of FMI 2.0 and 3.0, for model
    exchange and co-simulation.

    Parameters
    ----------
    folder, book, overwrite, field
        As for `write_c`.

    Returns
    -------
    list of Path
        ``vc_forces_fmi2.fmu`` and ``vc_forces_fmi3.fmu``; with the binary of
        this platform, where gcc or cc is found.

    Raises
    ------
    SceneError, OutputError
        As for `write_c`; also if the compiler fails.
    """
    known = _entries(book)
    sources = {name: _filled(name, known) for name in ("fmi.c", *LIBRARY[:2])}
    binary = _compiled(sources)
    places = PLATFORMS.get((sys.platform, platform.machine()))
    found = {}
    for k, version in enumerate((2, 3)):
        archive = {f"sources/{name}": text.encode() for name, text in sources.items()}
        archive["modelDescription.xml"] = _filled(f"fmi{version}.xml", known).encode()
        if version == 3:
            archive["sources/buildDescription.xml"] = _filled(
                "buildDescription.xml", known
            ).encode()
        if binary is not None and places is not None:
            archive[f"binaries/{places[k]}/vc_forces{places[2]}"] = binary
        content = BytesIO()
        with ZipFile(content, "w", ZIP_DEFLATED) as file:
            file.comment = MARK
            for name, each in archive.items():
                file.writestr(name, each)
        found[f"vc_forces_fmi{version}.fmu"] = content.getvalue()
    return _written(folder, found, overwrite, field)


def _filled(name: str, known: Mapping[str, object]) -> str:
    return Template(
        (files("varcontact.data") / "vehicle_codes" / name).read_text(encoding="utf-8")
    ).substitute(known)


def _entries(book: TableBook | None) -> dict[str, object]:
    """Values of the placeholders in the templates, by name."""
    book = book_of(book)
    least, greatest = book.range
    if least < np.exp(-END) or greatest > np.exp(END):
        raise SceneError(
            "a/b", (least, greatest), "within 1e-3 and 1e3 in a book for vehicle codes"
        )
    table = packed(book.splines)
    coefficients = coefficient_splines(book.nu)
    constants = {
        "HALFWAY": HALFWAY,
        "KNEE": KNEE,
        "ROOM": ROOM,
        "SPIN": SPIN,
        "MORE": FULL_SLIP_FACTOR,
        "near": NU_TOL,
        "end": END,
    }
    constants |= {"nu": book.nu, "least": least, "greatest": greatest}
    return {
        **{name: repr(float(value)) for name, value in constants.items()},
        "version": varcontact.__version__,
        "provenance": book.provenance,
        "token": book.digest(),
        "entries": book.entries,
        "error": f"{book.accuracy.max():.2g}",
        "between": BETWEEN if book.digest() == shipped().digest() else "",
        **dict(zip(("ratios", "places", "polar", "angles"), book.splines.shape, strict=False)),
        "full": AT_FULL,
        "coefficient_rows": len(coefficients),
        "units_data": _numbers(table["units"]),
        "coefficients_data": _numbers(coefficients),
        "at_full_slip_data": _numbers(table["full_slip"].astype(int)),
        "multiples_data": _numbers(table["splines"].astype(int)),
    }


def _numbers(values: np.ndarray) -> str:
    """C initialiser with the numbers, in lines."""
    texts = [repr(value) for value in values.ravel().tolist()]
    return ",\n".join(",".join(texts[k : k + 20]) for k in range(0, len(texts), 20))


def _compiled(sources: Mapping[str, str]) -> bytes | None:
    """The shared library of these sources; None without a compiler."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        return None
    with TemporaryDirectory() as folder:
        for name, text in sources.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        names = [name for name in sources if name.endswith(".c")]
        command = [compiler, "-std=c99", "-O2", "-shared", "-fPIC", "-o", "library", *names, "-lm"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        if done.returncode:
            raise OutputError("FMU", compiler, f"the compiler failed ({done.stderr.strip()[:200]})")
        return (Path(folder) / "library").read_bytes()


def _written(
    folder: str | Path, contents: Mapping[str, bytes], overwrite: bool, field: str
) -> list[Path]:
    """Write files in a folder, after checking that all of them can be written."""
    where = checks.file_name(field, folder)
    with reading(where, "cannot be made", field):
        where.mkdir(exist_ok=True)
    paths = [where / name for name in contents]
    for path in paths:
        check_replaceable(field, path, (path.suffix,), "export", b".*" + MARK, overwrite)
    for path, content in zip(paths, contents.values(), strict=True):
        write_whole(field, path, content)
    return paths
