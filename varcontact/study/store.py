"""The table of a comparison: its columns, the file it is kept in, and what it was made from."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from varcontact import checks
from varcontact.errors import OutputError, SceneError
from varcontact.io.scene_toml import scene_to
from varcontact.results.report import known
from varcontact.scene.scene import Scene
from varcontact.system.files import check_ending, check_writable, only_writer, replacing
from varcontact.system.interrupts import imported

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

LATER = ("calls", "error_Fx", "error_Fs", "error_FN")
"""Columns that tables of an earlier version do not have: they are read all the same."""

WORDS = ("scene", "method", "outcome", "reason", "calls", "identity")


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


def read_rows(store: Path, columns: Sequence[str], words: Sequence[str], what: str) -> list[dict[str, Any]]:
    """Rows of a table file that has these columns, some of them words; none where there is no file yet.

    Parameters
    ----------
    store : Path
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

    if not store.exists() or store.stat().st_size == 0:
        return []
    try:
        # a scene may be called "NA": only empty figures are missing
        table = pd.read_csv(
            store, dtype=dict.fromkeys(words, str), keep_default_na=False, na_values=[""], **_all_digits(pd.__version__)
        )
        for name in (name for name in LATER if name in columns and name not in table):
            table[name] = "" if name in words else math.nan
        if set(table.columns) != set(columns):
            raise ValueError("other columns")
        for name in set(columns) - set(words):
            if table[name].dtype.kind not in "iufb" and table[name].notna().any():
                raise ValueError(f"column {name} has words where figures belong")
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


def _all_digits(version: str) -> dict[str, Any]:
    """The option with which pandas reads figures exactly; from 3.1 on it does without, and warns of it."""
    return {} if tuple(map(int, version.split(".")[:2])) >= (3, 1) else {"float_precision": "round_trip"}


@dataclass
class Table:
    """The rows of a study, kept in a file if there is one, which is written anew whenever some are added.

    Attributes
    ----------
    path : Path or None
    columns : sequence of str
    rows : list of dict
    """

    path: Path | None
    columns: Sequence[str]
    rows: list[dict[str, Any]] = field(default_factory=list)
    _content: bytes | None = None

    @classmethod
    @contextmanager
    def opened(
        cls, store: str | Path | None, columns: Sequence[str], words: Sequence[str], what: str
    ) -> Iterator[Self]:
        """The rows that a file has already, to be added to by nobody else meanwhile; without a file, none.

        Parameters
        ----------
        store : str or Path or None
        columns, words : sequence of str
            Its columns, and those of them that are words.
        what : str
            What it is, for messages.

        Raises
        ------
        SceneError
            If the file is something else.
        OutputError
            If it cannot be written, or another study adds to it.
        """
        imported("pandas")  # now: after Ctrl-C it would be waited for
        if store is None:
            yield cls(None, columns)
            return
        path = checks.file_name("store", store)
        check_ending("store", path, ".csv")
        check_writable("store", path)
        with only_writer("store", path):
            rows = read_rows(path, columns, words, what)
            yield cls(path, columns, rows, path.read_bytes() if path.exists() else None)

    def write(self, rows: list[dict[str, Any]]) -> None:
        """Write other rows in place of those there are, or leave the file as it was.

        Parameters
        ----------
        rows : list of dict

        Raises
        ------
        OutputError
            If the file cannot be written, or is no longer as it was left: nobody else's changes are written over.
        """
        self.rows = rows
        if self.path is None:
            return
        import pandas as pd

        if (self.path.read_bytes() if self.path.exists() else None) != self._content:
            reason = "has been changed by something else since this study wrote it; what was added since is not in it"
            raise OutputError("store", self.path, reason)
        content = pd.DataFrame(self.rows, columns=list(self.columns)).to_csv(index=False).encode()
        with replacing("store", self.path) as file:
            file.write(content)
        self._content = content

    def add(self, *rows: dict[str, Any]) -> None:
        """Write some more `rows`, see `write`."""
        self.write([*self.rows, *rows])


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
