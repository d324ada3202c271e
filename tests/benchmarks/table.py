"""A measured table: what a benchmark gives, what is kept of it in results/, and how a page shows
it.
"""

import json
import os
import platform
import re
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from datetime import date
from importlib.metadata import version
from pathlib import Path

RESULTS = Path(__file__).parent / "results"
DOCS = Path(__file__).parents[2] / "docs"
MARKED = re.compile(r"(<!-- table (\w+) (\w+) -->\n).*?(<!-- end of table -->)", re.DOTALL)


@dataclass(frozen=True)
class Table:
    """Rows of figures or words, and the format of each column's figures; what is measured, where
    and when.
    """

    head: Sequence[str]
    formats: Sequence[str]
    rows: Sequence[Sequence[object]]
    measured: dict[str, object] = field(default_factory=dict)

    @property
    def markdown(self) -> str:
        rows = [self.head, ["---"] * len(self.head)]
        rows += [
            [shown(value, form) for value, form in zip(row, self.formats, strict=True)]
            for row in self.rows
        ]
        return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def shown(value: object, form: str) -> str:
    """A figure, or several (a median and the largest), in its format."""
    if value is None or isinstance(value, str):
        return value or ""
    if isinstance(value, int):
        return str(value)
    if isinstance(value, list | tuple):
        return form.format(*value)
    return format(value, form)


def conditions() -> dict[str, object]:
    """The machine and the versions; its load, which is more than one where other programs ran."""
    packages = {name: version(name) for name in ("numpy", "scipy", "clarabel")}
    load = round(os.getloadavg()[0], 1)
    machine = f"{platform.machine()}, {os.cpu_count()} processors"
    today, python = date.today().isoformat(), platform.python_version()
    return {"date": today, "machine": machine, "load": load, "python": python, **packages}


def keep(group: str, name: str, table: Table) -> None:
    """Into the group's file, in the place of an earlier one."""
    path = RESULTS / f"{group}.json"
    known = json.loads(path.read_text()) if path.exists() else {}
    kept = asdict(replace(table, measured={**conditions(), **table.measured}))
    path.write_text(json.dumps(known | {name: kept}, indent=1, default=float) + "\n")


def kept(group: str, name: str) -> Table:
    """A table of an earlier run."""
    return Table(**json.loads((RESULTS / f"{group}.json").read_text())[name])


def pages() -> list[Path]:
    return [page for page in sorted(DOCS.rglob("*.md")) if "<!-- table " in page.read_text()]


def filled(text: str) -> str:
    """A page's text with the tables as they are kept."""
    return MARKED.sub(
        lambda found: f"{found[1]}{kept(found[2], found[3]).markdown}\n{found[4]}", text
    )


def least(work: Callable[[], object], times: int = 3) -> float:
    """Processor seconds of the fastest of several calls: other work on the machine only adds to
    them.
    """
    seconds = []
    for _ in range(times):
        begun = time.process_time()
        work()
        seconds.append(time.process_time() - begun)
    return min(seconds)
