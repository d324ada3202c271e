"""Input files of CONTACT on the command line: all cases, beside the published results."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Annotated, Any

import varcontact as vc
from varcontact.cli import options as opt
from varcontact.cli.terminal import NOT_SOLVED, fail, progress_line, show
from varcontact.errors import OutputError, SceneError, VarcontactError
from varcontact.io.contact_output import published_seconds
from varcontact.study import contact_comparison as comparison
from varcontact.study.contact_comparison import Compared
from varcontact.study.contact_suite import FileCompared, page_of, report_of, tenths


def solve_all(
    path: Path, compare: Path | None, table: bool | None, save: Path | None, as_json: bool
) -> None:
    """Solve all cases of a file; print their table, or how they compare with an output of CONTACT,
    which sets the exit status.
    """
    _check_ending(path)
    printed = {}
    if compare is not None:
        printed = {each.case: each for each in vc.read_contact_output(compare)}
    if save is not None:
        _make_folder(save)
    started = time.process_time()
    with progress_line() as progress:
        rows, tables = _all_cases(path, printed, save, progress)
    seconds = time.process_time() - started
    if table:
        show("\n\n".join(tables))
    if compare is None:
        return
    if as_json:
        from varcontact.study.csv_table import as_json as table_as_json

        show(table_as_json(comparison.table_of(rows)))
    else:
        show(comparison.report(rows))
        show(f"seconds: {tenths(published_seconds(compare))} theirs, {tenths(seconds)} ours")
    counts = comparison.summary_of(rows)
    unequal = counts[comparison.DIFFERENT] + counts[comparison.NOT_RUN]
    if unequal:
        fail(f"{unequal} of {sum(counts.values())} cases are not equal, see the table", NOT_SOLVED)


def _make_folder(save: Path) -> None:
    try:
        save.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        reason = f"the folder cannot be made ({error.strerror})"
        raise OutputError("--save", str(save), reason) from None


def _check_ending(path: Path) -> None:
    """Refuse files that are no input files of CONTACT."""
    if path.suffix.lower() != ".inp":
        message = f"--compare, --table and --save are for input files of CONTACT (.inp): {path}"
        raise SceneError("--compare", str(path), message=message)


def _all_cases(
    path: Path,
    printed: dict[int, vc.ContactOutput],
    save: Path | None,
    progress: Callable[[object], None],
) -> tuple[list[Compared], list[str]]:
    """Results of all cases of a file, basic contacts or wheels on rails: rows of the comparison,
    and tables.
    """
    from varcontact.study import contact_runs
    from varcontact.wheel_rail import contact_runs as wheel_runs

    warnings.simplefilter("ignore", vc.PlausibilityWarning)  # input files are taken as they are
    cases: Sequence[Any] = vc.read_contact_input(path, strict=False).cases
    run: Any = contact_runs.run_cases
    finer: Any = contact_runs.refined
    if all("is a wheel on a rail" in case.reason for case in cases):
        cases = vc.wheel_rail.read_contact_input(path, strict=False).cases
        run = wheel_runs.run_wheels
        finer = wheel_runs.refined
    rows: list[Compared] = []
    tables = []
    for found in run(cases):
        number = found.case.number
        progress(f"case {number}")
        if found.reason:
            rows.append(_not_run(number, found.reason))
            continue
        output = printed.get(number)
        its = comparison.compared(number, found.patches, output, found.note)
        if any(row.verdict == comparison.DIFFERENT for row in its):
            refined = _on_finer_elements(finer(found.case), run)
            its = comparison.with_refined(its, refined, output)
        rows += its
        rows += comparison.compared_stresses(number, found.stresses, output, found.patches)
        tables.append(_printed(number, [*found.patches, *found.stresses]))
        if save is not None:
            for ending, solution in found.solutions.items():
                solution.save(save / f"case_{number:04d}{ending}.nc", overwrite=True)
    return rows, tables


def _on_finer_elements(case: Any, run: Any) -> list[dict[str, float]]:
    """Values of a case on finer elements, if the case has any."""
    if case is None:
        return []
    (found,) = run([case])
    patches: list[dict[str, float]] = found.patches
    return patches


def _not_run(number: int, reason: str) -> Compared:
    nothing = float("nan")
    return Compared(number, 1, "", nothing, nothing, comparison.NOT_RUN, reason)


def _printed(number: int, patches: Iterable[Any]) -> str:
    """The values of a case in CONTACT's layout: names, and numbers below them."""
    lines = [f" Case {number:5d}"]
    for k, values in enumerate(patches, 1):
        lines.append(f" CONTACT PATCH {k}")
        lines.append("".join(f"{name:>14}" for name in values))
        lines.append("".join(f"{value:14.4E}" for value in values.values()))
    return "\n".join(lines)


def suite(
    folder: Annotated[Path, opt.argument("Folder of input files of CONTACT with their outputs.")],
    as_json: opt.AsJson = False,
    page: Annotated[
        bool, opt.option("Tables in Markdown, of files and of cases that differ.", "--page")
    ] = False,
) -> None:
    """Run all input files of CONTACT in a folder, and count cases that equal its published
    results.
    """
    inputs = sorted(folder.glob("*.inp"))
    if not inputs:
        raise SceneError("folder", str(folder), "a folder with input files of CONTACT (.inp)")
    files = []
    with progress_line() as progress:
        for path in inputs:
            outputs = [path.with_suffix(ending) for ending in (".ref_out", ".out")]
            output = next((each for each in outputs if each.exists()), None)
            if output is None:
                continue
            started = time.process_time()
            try:
                printed = {each.case: each for each in vc.read_contact_output(output)}
                progress(path.name)
                rows, _ = _all_cases(path, printed, None, progress)
            except VarcontactError as error:
                rows = [_not_run(1, str(error))]
            seconds = time.process_time() - started
            files.append(FileCompared(path.name, rows, published_seconds(output), seconds))
    if as_json:
        show(json.dumps([each.summary() for each in files], indent=2))
    elif page:
        show(page_of(files))
    else:
        show(report_of(files))
