"""``varcontact benchmark`` and ``varcontact problems DIR``."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

import varcontact as vc
from varcontact.cli import options as opt
from varcontact.cli.options import values_of
from varcontact.cli.terminal import check_outputs, draw, progress_line, show, study

SOLVER = (
    "A solver, several times for several: [normal|]tangential[/formulation], as newton, norm|tang "
    "or clarabel/gap; one of your own, registered by an entry point or as module:function"
)
INSTALLED = "active sets, Newton, splitting, and programs by all solvers that are installed"
Quick = Annotated[bool, typer.Option("--quick", help="Twenty of the problems.")]


def benchmark(
    quick: Quick = False,
    solver: Annotated[list[str] | None, opt.option(SOLVER, default=INSTALLED)] = None,
    tols: Annotated[str, typer.Option(help="Tolerances, separated by commas.")] = "1e-3,1e-6,1e-9",
    limit: Annotated[
        float, typer.Option(help="Processor seconds of a solver for a problem and tolerance.")
    ] = 10.0,
    out: opt.Table = None,
    plot: opt.Picture = None,
    as_json: opt.AsJson = False,
) -> None:
    """Compare solvers on a set of contact problems, one at a time on one thread, judged by the
    package's own residual and gap.
    """
    check_outputs(out, plot, [], force=False)
    sys.path.insert(0, "")  # modules in this folder
    work = partial(
        vc.benchmark_solvers,
        solver,
        vc.benchmark_problems(quick=quick),
        tols=values_of("--tols", tols),
        limit=limit,
        store=out,
    )
    written = vc.SolverComparison.report
    if as_json:
        written = vc.SolverComparison.to_json
    draw(plot, vc.SolverComparison.plot, study(work, written, out, "--out FILE.csv", "trials"))


def problems(
    folder: Annotated[Path, opt.argument("A new or empty folder, or one written so before.")],
    quick: Quick = False,
) -> None:
    """Write the problems of the comparison with their solutions, for authors of solvers: read
    without varcontact, as a test set of qpbenchmark and as CVXPY problems.
    """
    with progress_line() as progress:
        paths = vc.save_problems(folder, vc.benchmark_problems(quick=quick), progress=progress)
    show(f"{len(paths)} problems in {folder}; README.md says what the files hold")
