"""``varcontact table export BOOK --c DIR``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from varcontact.cli.options import Force, argument, option
from varcontact.cli.terminal import show
from varcontact.errors import SceneError


def export_table(
    book: Annotated[
        Path | None, argument("Table book (.nc).  [default: that of the package]")
    ] = None,
    c: Annotated[
        Path | None, option("Folder for C99 source, MATLAB and Modelica wrappers.", "--c")
    ] = None,
    fmu: Annotated[Path | None, option("Folder for FMUs of FMI 2.0 and 3.0.", "--fmu")] = None,
    force: Force = False,
) -> None:
    """Export a table book to vehicle codes: as C, for MATLAB and Modelica, and as FMUs."""
    from varcontact.io.vehicle_codes import write_c, write_fmu
    from varcontact.theories.table_book import TableBook

    if c is None and fmu is None:
        raise SceneError("--c", None, "given: name a folder with --c or --fmu")
    table_book = None if book is None else TableBook.read(book)
    paths: list[Path] = []
    if c is not None:
        paths += write_c(c, table_book, force, "--c")
    if fmu is not None:
        paths += write_fmu(fmu, table_book, force, "--fmu")
    show("\n".join(map(str, paths)))
