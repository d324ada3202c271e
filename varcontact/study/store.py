"""The table of a comparison: its columns, the file it is kept in, and what it was made from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from varcontact.errors import SceneError
from varcontact.io.scene_file import scene_to
from varcontact.io.solution_file import write_whole
from varcontact.results.solution import known
from varcontact.scene.scene import Scene

if TYPE_CHECKING:
    import pandas as pd

COLUMNS = (
    "scene",
    "method",
    "outcome",
    "reason",
    "Fx",
    "Fy",
    "Mz",
    "vx",
    "vy",
    "spin",
    "approach",
    "gap",
    "relative_gap",
    "residual",
    "force_bound",
    "force_distance",
    "traction_distance",
    "misclassified",
    "iterations",
    "normal_seconds",
    "tangential_seconds",
    "certificate_seconds",
    "setup_seconds",
    "repeat_seconds",
    "total_seconds",
    "calls",
    "identity",
)
"""What the table says of each scene and method."""

LATER = ("calls",)
"""Columns that tables of an earlier version do not have: they are read all the same."""

_WORDS = ("scene", "method", "outcome", "reason", "calls", "identity")


def identity(scene: Scene, tol: float) -> str:
    """A few digits that tell one scene and tolerance from another.

    Parameters
    ----------
    scene : Scene
    tol : float
        Residual to be reached [-].
    """
    described = json.dumps([scene_to(scene), tol], sort_keys=True)
    return hashlib.sha256(described.encode()).hexdigest()[:12]


def stored(store: str | Path | None, methods: list[str], identities: dict[str, str]) -> list[dict[str, Any]]:
    """Rows of an earlier run: whole scenes, the same by the same methods.

    Parameters
    ----------
    store : str, Path or None
        The table file.
    methods : list of str
    identities : dict of str
        By the name of the scene, as `identity` gives them.

    Raises
    ------
    SceneError
        If the file holds other methods or other scenes.
    """
    rows = read_rows(store, COLUMNS, _WORDS, "a table of an earlier comparison")
    scenes = dict.fromkeys(row["scene"] for row in rows)
    for scene in scenes:
        if [row["method"] for row in rows if row["scene"] == scene] != methods:
            raise SceneError(
                "store",
                str(store),
                "a table by the same methods, in the same order, or a new file",
                message=f"store = {str(store)!r} compares other methods, or the same in another order; name a new file",
            )
    for row in rows:
        if identities.get(row["scene"], row["identity"]) != row["identity"]:
            raise SceneError(
                "store",
                str(store),
                f"a table with the same scene {row['scene']!r}, or a new file",
                message=f"store = {str(store)!r} holds another scene named {row['scene']!r}; name a new file",
            )
    return rows


def read_rows(
    store: str | Path | None, columns: Sequence[str], words: Sequence[str], what: str
) -> list[dict[str, Any]]:
    """Rows of a table file that has these columns, some of them words; none where there is no file yet.

    Parameters
    ----------
    store : str, Path or None
        The table file.
    columns : sequence of str
    words : sequence of str
        The columns that are no numbers.
    what : str
        What the file should be, for the message.

    Raises
    ------
    SceneError
        If the file is something else.
    """
    import pandas as pd

    if store is None or not Path(store).exists():
        return []
    if not Path(store).is_file():
        raise SceneError(
            "store",
            str(store),
            f"{what}, or a new file",
            message=f"store = {str(store)!r} is not a file; name {what}, or a new file",
        )
    try:
        # a scene may be called "NA": only empty figures are missing
        table = pd.read_csv(store, dtype=dict.fromkeys(words, str), keep_default_na=False, na_values=[""])
        table[[name for name in LATER if name in columns and name not in table]] = ""
        if set(table.columns) != set(columns):
            raise ValueError("other columns")
        table = table[list(columns)]
    except (ValueError, OSError, UnicodeDecodeError) as error:
        raise SceneError(
            "store",
            str(store),
            f"{what}, or a new file",
            message=f"store = {str(store)!r} is not {what} ({error}); name a new file",
        ) from None
    table[list(words)] = table[list(words)].fillna("")
    rows: list[dict[str, Any]] = table.to_dict("records")
    return rows


def keep(store: str | Path, rows: list[dict[str, Any]], columns: Sequence[str] = COLUMNS) -> None:
    """Write all rows there are, or leave the file as it was.

    Parameters
    ----------
    store : str or Path
        The table file.
    rows : list of dict
    columns : sequence of str

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    import pandas as pd

    content = pd.DataFrame(rows, columns=list(columns)).to_csv(index=False).encode()
    write_whole("store", Path(store), content)


def as_json(table: pd.DataFrame) -> str:
    """A comparison as a JSON array of rows, all digits of its figures; null where nothing is known.

    Parameters
    ----------
    table : DataFrame
    """
    return json.dumps(plain_rows(table), indent=2, allow_nan=False)


def plain_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table as JSON can have them: None where nothing is known.

    Parameters
    ----------
    table : DataFrame
    """
    return [
        {name: known(value) if isinstance(value, float) else value for name, value in row.items()}
        for row in table.to_dict("records")
    ]
