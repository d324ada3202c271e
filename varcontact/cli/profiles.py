"""``varcontact profiles FOLDER``."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Annotated, Any

import typer

from varcontact import checks
from varcontact.cli import options as opt
from varcontact.cli.terminal import show
from varcontact.errors import SceneError, VarcontactError

COLUMNS = (
    "file",
    "kind",
    "points",
    "y_from",
    "y_to",
    "z_from",
    "z_to",
    "touched_from",
    "touched_to",
)
"""Columns of the table: y and z, and the y between which a profile can be touched, in mm."""


def profiles(
    folder: Annotated[
        Path, opt.argument("Folder with profiles, those in folders within it too, or one file.")
    ],
    kind: Annotated[
        str | None, opt.option("rail or wheel: what files are that do not show it.")
    ] = None,
    scale: Annotated[
        float, typer.Option(help="Millimetres by the unit of length of the files.")
    ] = 1.0,
    as_json: opt.AsJson = False,
) -> None:
    """Read the profiles of a folder: their sizes, what is doubtful about them, and why others are
    refused.
    """
    from varcontact.wheel_rail.profile_files import COLUMNS as OF_COLUMNS
    from varcontact.wheel_rail.profile_files import KIND_OF, KINDS, Z_UP
    from varcontact.wheel_rail.slices import SLICES

    if kind is not None:
        checks.choice("kind", kind, KINDS)
    checks.positive("scale", scale)
    suffixes = {*OF_COLUMNS, *KIND_OF, *Z_UP, *SLICES}
    if folder.is_file():
        names = {folder: folder.name}
    else:
        files = sorted(each for each in folder.rglob("*") if each.suffix.lower() in suffixes)
        names = {file: str(file.relative_to(folder)) for file in files}
    if not names:
        allowed = f"a folder with profiles ({', '.join(sorted(suffixes))}), or one file"
        raise SceneError("folder", str(folder), allowed)
    rows = [_row(file, name, kind, scale) for file, name in names.items()]
    if as_json:
        show(json.dumps(rows, indent=2, allow_nan=False))
    else:
        show(_report(rows))


def _row(file: Path, name: str, kind: str | None, scale: float) -> dict[str, Any]:
    """Table row of a profile file; for a refused file its entries are None and `refused` has the
    reason. Warnings are its `doubts`.
    """
    row: dict[str, Any] = {**dict.fromkeys(COLUMNS), "file": name, "refused": None, "doubts": []}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            row.update(_sizes(file, kind, scale))
        except VarcontactError as error:
            row["refused"] = str(error)
    doubts = dict.fromkeys(str(each.message).removeprefix("track.rail: ") for each in caught)
    row["doubts"] = list(doubts)
    return row


def _sizes(file: Path, kind: Any, scale: float) -> dict[str, Any]:
    """Kind, points and sizes of a profile, or of the first of a file of slices."""
    from varcontact.wheel_rail import Profile, ProfileSlices
    from varcontact.wheel_rail.profile_files import KIND_OF
    from varcontact.wheel_rail.profile_shape import check_sides
    from varcontact.wheel_rail.slices import SLICES

    suffix = file.suffix.lower()
    if suffix in SLICES:
        slice_kind: Any = "rail" if suffix == SLICES[0] else "wheel"
        read: Any = ProfileSlices.read(file, slice_kind, scale=scale)
        parts = read if isinstance(read, tuple) else (read,)
        profile = parts[0].first
        points = " + ".join(str(each.positions.size) for each in parts) + " slices"
    else:
        profile = Profile.read(file, KIND_OF.get(suffix, kind), scale=scale)
        points = str(profile.y.size)
    if profile.kind == "rail":
        check_sides(profile)
    touched = profile.running.points(profile.running.s)[:, 0]
    ends = [(each.min(), each.max()) for each in (profile.y, profile.z, touched)]
    sizes = [round(float(value), 4) + 0.0 for pair in ends for value in pair]
    return dict(zip(COLUMNS[1:], [profile.kind, points, *sizes], strict=True))


def _report(rows: list[dict[str, Any]]) -> str:
    """Table of the profiles, and below it warnings and refusals by file."""
    from varcontact.study.csv_table import rows_of_text

    read = [row for row in rows if row["refused"] is None]
    lines = rows_of_text(read, COLUMNS) if read else []
    for row in rows:
        own = Path(row["file"]).name + ": "
        if row["refused"] is not None:
            lines.append(f"{row['file']}: refused: {row['refused'].removeprefix(own)}")
        else:
            lines += [f"{row['file']}: {doubt.removeprefix(own)}" for doubt in row["doubts"]]
    lines.append(f"{len(read)} read, {len(rows) - len(read)} refused")
    return "\n".join(lines)
