"""``varcontact wheelrail CASE.toml``."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Annotated, Any

import varcontact as vc
from varcontact import checks
from varcontact.cli import options as opt
from varcontact.cli.options import given
from varcontact.cli.terminal import NOT_SOLVED, check_outputs, draw, fail, study
from varcontact.errors import SceneError
from varcontact.system.progress import Progress


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
    from varcontact.study.csv_table import rows_as_json
    from varcontact.study.parallel import Execution
    from varcontact.wheel_rail.case_file import CaseFile, read_case, solve_rows

    check_outputs(out, plot, [case], force)
    check_outputs(None, plot_wear, [each for each in (case, out, plot) if each is not None], force)
    if case.suffix.lower() == ".inp":
        wheels = vc.wheel_rail.read_contact_input(case)
        others = [each.number for each in wheels.cases if not each.alone]
        if others:
            message = f"{case}: cases {others} are steps in time or by forces: --table solves them"
            raise SceneError("case", str(case), message=message)
        read = CaseFile(tuple(wheels), tuple(range(1, len(wheels) + 1)), {}, None)
    else:
        read = read_case(case)
    read.options.update(given(**options))
    if plot_wear is not None and len(read.cases) > 1:
        raise SceneError(
            "--plot-wear", str(plot_wear), f"left out: there are {len(read.cases)} wheels, not one"
        )
    found: deque[vc.wheel_rail.WheelRailSolution | vc.wheel_rail.WheelSetSolution] = deque(maxlen=1)

    def work(progress: Progress) -> list[dict[str, Any]]:
        execution = Execution(None, workers, checks.progress(progress))
        return solve_rows(read, out, execution, found.append)

    rows = study(work, rows_as_json if as_json else _report, out, "--out FILE.csv", "wheels")
    if len(read.cases) > 1 and plot is not None:
        import pandas as pd

        from varcontact.wheel_rail.plots import plot_positions

        draw(plot, plot_positions, pd.DataFrame(rows))
    elif len(read.cases) == 1 and (plot is not None or plot_wear is not None):
        # unless the table has it from an earlier run
        solution = found[0] if found else read.cases[0].solve(**read.options)
        draw(plot, solution.plot)
        if plot_wear is not None:
            if not isinstance(solution, vc.wheel_rail.WheelRailSolution):
                raise SceneError(
                    "--plot-wear",
                    str(plot_wear),
                    "left out: it is for one wheel, not for a wheel set",
                )
            draw(plot_wear, vc.wheel_rail.wear(solution, read.archard).plot)
    failed = sum(row["outcome"] != "solved" for row in rows)
    if failed:
        fail(f"{failed} of {len(read.cases)} wheels are not solved, see the table", NOT_SOLVED)


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
