"""Input files of CONTACT on the command line: all cases, beside the published results."""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any

import varcontact as vc
from varcontact.cli import options as opt
from varcontact.cli.terminal import NOT_SOLVED, fail, progress_line, show
from varcontact.errors import SceneError, VarcontactError
from varcontact.study import contact_comparison as comparison
from varcontact.study.contact_comparison import Compared


def compared(path: Path, options: dict[str, Any], as_json: bool) -> bool:
    """Solve all cases of a file, where that is asked for by `options`, which are taken out; print
    their table, or the comparison, which sets the exit status.
    """
    output, as_table, save = (options.pop(name, None) for name in opt.CONTACT)
    if output is None and not as_table and save is None:
        return False
    _check_ending(path)
    printed = {}
    if output is not None:
        printed = {each.case: each for each in vc.read_contact_output(output)}
    if save is not None:
        save.mkdir(parents=True, exist_ok=True)
    with progress_line() as progress:
        rows, tables = _all_cases(path, printed, save, progress)
    if as_table:
        show("\n\n".join(tables))
    if output is None:
        return True
    if as_json:
        found = comparison.table_of(rows).to_dict("records")
        show(json.dumps(found, indent=2, default=float))
    else:
        show(comparison.report(rows))
    counts = comparison.summary_of(rows)
    unequal = counts[comparison.DIFFERENT] + counts[comparison.NOT_RUN]
    if unequal:
        fail(f"{unequal} of {sum(counts.values())} cases are not equal, see the table", NOT_SOLVED)
    return True


def _check_ending(path: Path) -> None:
    """Refuse what is no input file of CONTACT."""
    if path.suffix.lower() != ".inp":
        message = f"--compare, --table and --save are for input files of CONTACT (.inp): {path}"
        raise SceneError("--compare", str(path), message=message)


def _all_cases(
    path: Path,
    printed: dict[int, vc.ContactOutput],
    save: Path | None,
    progress: Callable[[object], None],
) -> tuple[list[Compared], list[str]]:
    warnings.simplefilter("ignore", vc.PlausibilityWarning)  # the files are as they are
    basic = vc.read_contact_input(path, strict=False)
    if all("is a wheel on a rail" in case.reason for case in basic.cases):
        return _wheels(path, printed, save, progress)
    return _basic(basic.cases, printed, save, progress)


def _basic(
    cases: Iterable[Any],
    printed: dict[int, vc.ContactOutput],
    save: Path | None,
    progress: Callable[[object], None],
) -> tuple[list[Compared], list[str]]:
    """Basic contacts, module 3."""
    from varcontact.study.contact_runs import run_cases

    rows: list[Compared] = []
    tables = []
    for run in run_cases(cases):
        number = run.case.number
        progress(f"case {number}")
        if run.reason:
            rows.append(_not_run(number, run.reason))
            continue
        rows += comparison.compared(number, run.values, printed.get(number), run.note)
        rows += comparison.compared_stresses(number, run.stresses, printed.get(number))
        tables.append(_printed(number, [run.values, *run.stresses]))
        if save is not None and run.solution is not None:
            run.solution.save(save / f"case_{number:04d}.nc", overwrite=True)
    return rows, tables


def _wheels(
    path: Path,
    printed: dict[int, vc.ContactOutput],
    save: Path | None,
    progress: Callable[[object], None],
) -> tuple[list[Compared], list[str]]:
    """Wheels on rails, module 1."""
    from varcontact.wheel_rail.contact_runs import run_wheels

    rows: list[Compared] = []
    tables = []
    for run in run_wheels(vc.wheel_rail.read_contact_input(path, strict=False).cases):
        number = run.case.number
        progress(f"case {number}")
        if run.reason:
            rows.append(_not_run(number, run.reason))
            continue
        rows += comparison.compared_wheel(number, run.patches, printed.get(number))
        tables.append(_printed(number, run.patches))
        if save is not None and run.solution is not None:
            for k, patch in enumerate(run.solution.patches, 1):
                patch.solution.save(save / f"case_{number:04d}_{k}.nc", overwrite=True)
    return rows, tables


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
) -> None:
    """Run all input files of CONTACT in a folder, and count cases that equal its published
    results.
    """
    summaries = []
    with progress_line() as progress:
        for path in sorted(folder.glob("*.inp")):
            outputs = [path.with_suffix(ending) for ending in (".ref_out", ".out")]
            output = next((each for each in outputs if each.exists()), None)
            if output is None:
                continue
            try:
                printed = {each.case: each for each in vc.read_contact_output(output)}
                progress(path.name)
                rows, _ = _all_cases(path, printed, None, progress)
            except VarcontactError as error:
                rows = [_not_run(1, str(error))]
            summaries.append(_summary(path, rows))
    if as_json:
        show(json.dumps(summaries, indent=2))
        return
    lines = [f"{'file':<26} {'equal':>6} {'differ':>6} {'not run':>7}"]
    for each in summaries:
        line = f"{each['file']:<26} {each[comparison.EQUAL]:>6} {each[comparison.DIFFERENT]:>6}"
        lines.append(f"{line} {each[comparison.NOT_RUN]:>7}")
        lines += [f"    {count}: {reason}" for reason, count in each["reasons"].items()]
    show("\n".join(lines))


def _summary(path: Path, rows: list[Compared]) -> dict[str, Any]:
    """Number of cases of a file by verdict, and by the reason why they are not equal."""
    reasons: dict[str, int] = {}
    for _, verdict, reason in comparison.by_case(rows):
        if verdict in (comparison.DIFFERENT, comparison.NOT_RUN):
            words = re.sub(r".*, line \d+: ", "", reason)
            reasons[words] = reasons.get(words, 0) + 1
    return {"file": path.name, **comparison.summary_of(rows), "reasons": reasons}
