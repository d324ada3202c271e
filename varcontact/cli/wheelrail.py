"""``varcontact wheelrail CASE.toml``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

import varcontact as vc
from varcontact import checks
from varcontact.cli import options as opt
from varcontact.cli.options import given
from varcontact.cli.terminal import NOT_SOLVED, check_outputs, draw, fail, study
from varcontact.errors import SceneError
from varcontact.system.progress import Progress

if TYPE_CHECKING:
    from varcontact.wheel_rail.case_file import CaseFile

    WheelSolution: TypeAlias = vc.wheel_rail.WheelRailSolution | vc.wheel_rail.WheelSetSolution


@opt.takes("tangential", *opt.TARGET, *opt.CONTACT)
def wheelrail(
    case: Annotated[
        Path, opt.argument("Case (TOML, docs/wheel_rail.md) or CONTACT's input file (.inp).")
    ],
    out: opt.Table = None,
    plot: Annotated[
        Path | None, opt.option("Picture (.png, .pdf, .svg) of a wheel, or over positions.")
    ] = None,
    plot_wear: Annotated[
        Path | None, opt.option("Picture of friction power and depth of wear, of one wheel.")
    ] = None,
    workers: opt.Workers = 1,
    force: opt.Force = False,
    as_json: opt.AsJson = False,
    **options: Any,
) -> None:
    """Find contact patches, creepages and forces of a wheel on a rail, or of a wheel set, in mm, N
    and rad.
    """
    for_contact = opt.for_contact(options)
    if any(for_contact.values()):
        from varcontact.cli.contact_files import solve_all

        solve_all(case, **for_contact, as_json=as_json)
        return
    check_outputs(out, plot, [case], force)
    check_outputs(None, plot_wear, [each for each in (case, out, plot) if each is not None], force)
    file = _read(case, given(**options))
    if plot_wear is not None:
        _check_alone(file, plot_wear)
    rows, solution = _solve_and_print(file, out, workers, as_json)
    if len(file.cases) > 1:
        _draw_positions(rows, plot)
    else:
        _draw_wheel(file, solution, plot, plot_wear)
    _fail_if_not_solved(rows, len(file.cases))


def _read(path: Path, options: dict[str, Any]) -> CaseFile:
    """A case of TOML or of CONTACT, with the options of the command in place of its own."""
    from varcontact.wheel_rail.case_file import CaseFile, read_case

    if path.suffix.lower() != ".inp":
        file = read_case(path)
        return replace(file, options=file.options | options)
    wheels = vc.wheel_rail.read_contact_input(path)
    others = [each.number for each in wheels.beside]
    if others:
        reason = "steps in time, by forces, or by simplified theory: --table solves them"
        message = f"{path}: cases {others} are {reason}"
        raise SceneError("case", str(path), message=message)
    return CaseFile(tuple(wheels), tuple(range(1, len(wheels) + 1)), options, None)


def _check_alone(file: CaseFile, plot_wear: Path) -> None:
    """Refuse a picture of wear of several wheels."""
    if len(file.cases) > 1:
        raise SceneError(
            "--plot-wear", str(plot_wear), f"left out: there are {len(file.cases)} wheels, not one"
        )


def _solve_and_print(
    file: CaseFile, out: Path | None, workers: int, as_json: bool
) -> tuple[list[dict[str, Any]], WheelSolution | None]:
    """The rows of the table, which is printed, and the solution of a wheel alone, unless the table
    had it from last time.
    """
    from varcontact.study.csv_table import rows_as_json
    from varcontact.study.parallel import Execution
    from varcontact.wheel_rail.case_file import solve_rows

    solutions: list[WheelSolution] = []

    def keep(solution: WheelSolution) -> None:
        if len(file.cases) == 1:
            solutions.append(solution)

    def work(progress: Progress) -> list[dict[str, Any]]:
        execution = Execution(None, workers, checks.progress(progress))
        return solve_rows(file, out, execution, keep)

    rows = study(work, rows_as_json if as_json else _report, out, "--out FILE.csv", "wheels")
    return rows, next(iter(solutions), None)


def _draw_positions(rows: list[dict[str, Any]], plot: Path | None) -> None:
    if plot is None:
        return
    import pandas as pd

    from varcontact.wheel_rail.plots import plot_positions

    draw(plot, plot_positions, pd.DataFrame(rows))


def _draw_wheel(
    file: CaseFile, solution: WheelSolution | None, plot: Path | None, plot_wear: Path | None
) -> None:
    if plot is None and plot_wear is None:
        return
    if solution is None:
        solution = file.cases[0].solve(**file.options)
    draw(plot, solution.plot)
    if plot_wear is None:
        return
    if not isinstance(solution, vc.wheel_rail.WheelRailSolution):
        allowed = "left out: it is for one wheel, not for a wheel set"
        raise SceneError("--plot-wear", str(plot_wear), allowed)
    draw(plot_wear, vc.wheel_rail.wear(solution, file.archard).plot)


def _fail_if_not_solved(rows: list[dict[str, Any]], wheels: int) -> None:
    failed = sum(row["outcome"] != "solved" for row in rows)
    if failed:
        fail(f"{failed} of {wheels} wheels are not solved, see the table", NOT_SOLVED)


def _report(rows: list[dict[str, Any]]) -> str:
    from varcontact.study.csv_table import rows_of_text
    from varcontact.wheel_rail.quantities import printed_columns

    solved = [row for row in rows if row["outcome"] == "solved"]
    lines = []
    if solved:
        lines = rows_of_text(solved, printed_columns(), "error_{}")
    for row in rows:
        texts = [row["reason"]]
        if row["patch"] <= 1:
            texts.append(row["warnings"])
        words = "; ".join(filter(None, texts))
        if words:
            lines.append(f"position {row['position']}, {row['side']}, {row['outcome']}: {words}")
    return "\n".join(lines)
