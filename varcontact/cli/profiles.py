"""``varcontact profiles FOLDER``."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Annotated, Any

import typer

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
"""Of the table: y and z, and the y between which a profile can be touched, in mm."""


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
    from varcontact.wheel_rail.profile_files import KIND_OF, Z_UP
    from varcontact.wheel_rail.slices import SLICES

    known = {*OF_COLUMNS, *KIND_OF, *Z_UP, *SLICES}
    files = (
        [folder]
        if folder.is_file()
        else sorted(each for each in folder.rglob("*") if each.suffix.lower() in known)
    )
    if not files:
        raise SceneError(
            "folder",
            str(folder),
            f"a folder with profiles ({', '.join(sorted(known))}), or one file",
        )
    rows = [
        _row(file, str(file.relative_to(folder)) if file != folder else file.name, kind, scale)
        for file in files
    ]
    show(json.dumps(rows, indent=2, allow_nan=False) if as_json else _report(rows))


def _row(file: Path, name: str, kind: str | None, scale: float) -> dict[str, Any]:
    """What a file has: entries of the table, None where it is refused, with the reason and doubts
    in words.
    """
    row: dict[str, Any] = {**dict.fromkeys(COLUMNS), "file": name, "refused": None, "doubts": []}
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always")
        try:
            row.update(_sizes(file, kind, scale))
        except VarcontactError as error:
            row["refused"] = str(error)
    row["doubts"] = list(dict.fromkeys(str(each.message) for each in doubts))
    return row


def _sizes(file: Path, kind: Any, scale: float) -> dict[str, Any]:
    """Those of a profile, or of the first of a file of slices."""
    from varcontact.wheel_rail import Profile, ProfileSlices
    from varcontact.wheel_rail.profile_files import KIND_OF
    from varcontact.wheel_rail.slices import SLICES

    suffix = file.suffix.lower()
    if suffix in SLICES:
        read: Any = ProfileSlices.read(
            file, "rail" if suffix == SLICES[0] else "wheel", scale=scale
        )
        parts = read if isinstance(read, tuple) else (read,)
        profile, points = (
            parts[0].first,
            " + ".join(str(each.positions.size) for each in parts) + " slices",
        )
    else:
        profile = Profile.read(file, KIND_OF.get(suffix, kind), scale=scale)
        points = str(profile.y.size)
    touched = profile.running.points(profile.running.s)[:, 0]
    ends = [(each.min(), each.max()) for each in (profile.y, profile.z, touched)]
    sizes = [round(float(value), 4) + 0.0 for pair in ends for value in pair]
    return dict(zip(COLUMNS[1:], [profile.kind, points, *sizes], strict=True))


def _report(rows: list[dict[str, Any]]) -> str:
    """The table, and below it doubts and refusals by file."""
    from varcontact.study.csv_table import rows_of_text

    read = [row for row in rows if row["refused"] is None]
    lines = rows_of_text(read, COLUMNS) if read else []
    for row in rows:
        own, refused = Path(row["file"]).name + ": ", row["refused"] is not None
        reasons = [row["refused"]] if refused else row["doubts"]
        lines += [
            f"{row['file']}: {'refused: ' * refused}{each.removeprefix(own)}" for each in reasons
        ]
    lines.append(f"{len(read)} read, {len(rows) - len(read)} refused")
    return "\n".join(lines)
