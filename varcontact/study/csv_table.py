"""Tables of studies: CSV files that are resumed, rows for JSON, and columns of text."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

from varcontact import checks
from varcontact.errors import Interrupted, OutputError, SceneError
from varcontact.io.scene_toml import scene_to
from varcontact.results.error_estimate import with_bar
from varcontact.results.report import plain
from varcontact.scene.scene import Scene
from varcontact.study.parallel import Execution, opened, results
from varcontact.system.files import check_writable, only_writer, replacing
from varcontact.system.process import imported

if TYPE_CHECKING:
    import pandas as pd


Made = TypeVar("Made")


def identity(scene: Scene, tol: float) -> str:
    """A digest of a scene and its tolerance."""
    content = json.dumps([scene_to(scene), tol], sort_keys=True)
    return hashlib.sha256(content.encode()).hexdigest()[:12]


@dataclass
class Table:
    """Rows of a study, and the file that they are kept in, if any; it is rewritten whenever rows
    are added.
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
        """The table in a file, locked against other writers; without a file, an empty one.

        `words` are the columns that are no numbers, `what` names the table in error messages.
        """
        if store is None:
            yield cls(None, columns)
            return
        imported("pandas")  # imported now: after Ctrl-C the import would have to be waited for
        path = checks.file_name("store", store)
        check_writable("store", path, (".csv",))
        with only_writer("store", path):
            rows = _read_rows(path, columns, words, what)
            yield cls(path, columns, rows, _content_of(path))

    def write(self, rows: list[dict[str, Any]]) -> None:
        """Replace all rows; the file is left as it was if it cannot be written or something else
        has changed it.
        """
        self.rows = rows
        if self.path is None:
            return
        import pandas as pd

        if _content_of(self.path) != self._content:
            reason = (
                "has been changed by something else since this study wrote it; "
                "what was added since is not in it"
            )
            raise OutputError("store", self.path, reason)
        content = as_csv(pd.DataFrame(self.rows, columns=list(self.columns)))
        with replacing("store", self.path) as file:
            file.write(content)
        self._content = content

    def fill(
        self,
        work: Callable[..., list[dict[str, Any]]],
        tasks: Mapping[str, tuple[Any, ...]],
        execution: Execution,
        made: Callable[[list[dict[str, Any]]], Made],
        total: int,
        what: str = "scenes",
    ) -> Made:
        """Study `made` of the rows, once those of tasks by name, the rest of a `total`, are added;
        or Ctrl-C comes.
        """
        done = total - len(tasks)
        try:
            with opened(execution.executor, execution.workers) as pool:
                for _, rows in results(work, tasks, pool, execution.progress):
                    if rows:
                        self.write([*self.rows, *rows])
                    done += 1
        except KeyboardInterrupt:
            raise Interrupted(made(self.rows), f" after {done} of {total} {what}") from None
        return made(self.rows)


def _content_of(path: Path) -> bytes | None:
    return path.read_bytes() if path.exists() else None


def _read_rows(
    store: Path, columns: Sequence[str], words: Sequence[str], what: str
) -> list[dict[str, Any]]:
    """Rows of a file, which must have these columns; none if there is no file yet."""
    import pandas as pd

    if not store.exists() or store.stat().st_size == 0:
        return []
    # a scene may be called "NA": only empty figures are missing
    options: dict[str, Any] = {
        "dtype": dict.fromkeys(words, str),
        "keep_default_na": False,
        "na_values": [""],
    }
    if tuple(map(int, pd.__version__.split(".")[:2])) < (3, 1):
        # later versions read all digits by themselves, and warn of the option
        options["float_precision"] = "round_trip"
    try:
        table = pd.read_csv(store, **options)
        if set(table.columns) != set(columns):
            raise ValueError("other columns")
        for name in set(columns) - set(words):
            if table[name].dtype.kind not in "iufb" and table[name].notna().any():
                raise ValueError(f"column {name} has words where figures belong")
    except (ValueError, OSError) as error:
        raise of_another(store, f"is not {what} ({error})") from None
    table = table[list(columns)].fillna(dict.fromkeys(words, ""))
    for name in words:
        table[name] = table[name].map(_unquoted)
    return table.to_dict("records")


def of_another(store: str | Path | None, what: str) -> SceneError:
    """The error of a table that belongs to another study."""
    return SceneError(
        "store", str(store), message=f"store = {str(store)!r} {what}; name a new file"
    )


def completed(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> list[dict[str, Any]]:
    """Rows of texts, `int` and `float` with all columns, as those of a DataFrame: NaN where there
    is no entry, and floats where a column has some.
    """
    filled = [{name: row.get(name, math.nan) for name in columns} for row in rows]
    for name in columns:
        if any(isinstance(row[name], float) for row in filled):
            for row in filled:
                if isinstance(row[name], int):
                    row[name] = float(row[name])
    return filled


def plain_rows(table: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a table for JSON: None for NaN and infinity."""
    return [plain(row) for row in table.to_dict("records")]


FORMULAS = ("=", "+", "-", "@", "\t", "\r", "'")
"""Beginnings of texts that spreadsheets run as formulas, and the quote that keeps them from it."""


def as_csv(table: pd.DataFrame) -> bytes:
    """A table as CSV, whose texts no spreadsheet runs."""
    texts = {
        name: column.map(_quoted)
        for name, column in table.items()
        if column.dtype.kind not in "iufb"
    }
    return table.assign(**texts).to_csv(index=False).encode()


def _quoted(value: Any) -> Any:
    """A value; a text that begins as a formula with a quote before it."""
    if isinstance(value, str) and value.startswith(FORMULAS):
        return f"'{value}"
    return value


def _unquoted(text: str) -> str:
    if text[:1] == "'" and text[1:].startswith(FORMULAS):
        return text[1:]
    return text


def as_json(table: pd.DataFrame) -> str:
    """A table as a JSON array of rows, with all digits."""
    return rows_as_json(table.to_dict("records"))


def rows_as_json(rows: list[dict[str, Any]]) -> str:
    """Rows as a JSON array, with all digits."""
    return json.dumps(plain(rows), indent=2, allow_nan=False)


def columns_of_text(lines: list[list[str]], left: int) -> list[str]:
    """Lines of cells in columns, the first `left` of them flush left."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    rows = []
    for line in lines:
        cells = [text.ljust(width) for text, width in zip(line[:left], widths, strict=False)]
        cells += [text.rjust(width) for text, width in zip(line[left:], widths[left:], strict=True)]
        rows.append("  ".join(cells).rstrip())
    return rows


def cell(value: Any, form: str) -> str:
    """A value as text; empty for NaN."""
    return "" if value != value else format(value, form)


def rows_of_text(
    rows: Iterable[Mapping[str, Any]], names: Sequence[str], bar: str = "{}_error"
) -> list[str]:
    """Entries of rows in columns under their names: words, or figures with error bars if they have
    them.
    """
    lines = [list(names)]
    for row in rows:
        cells = []
        for name in names:
            value = row[name]
            if isinstance(value, float) and value == value:
                cells.append(with_bar(value, row.get(bar.format(name)) or 0.0))
            else:
                cells.append(cell(value, ""))
        lines.append(cells)
    return columns_of_text(lines, left=0)
