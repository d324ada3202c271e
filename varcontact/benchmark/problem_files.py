"""Benchmark problems as files that can be read without this package."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

import varcontact
from varcontact import checks
from varcontact.benchmark.problem_set import BenchmarkProblem, benchmark_problems, check_problems
from varcontact.discrete.problems import NormalProblem, RawSolution, TangentialProblem
from varcontact.errors import NotConverged, OutputError, SceneError
from varcontact.solvers.interface import Settings, better, natural_residual
from varcontact.solvers.registry import SOLVERS, Kind
from varcontact.system.files import write_whole
from varcontact.system.process import one_blas_thread
from varcontact.system.progress import Progress

TOL = 1e-10
"""Residual of the solutions."""
REACHED_FOR = 1e-11
"""Residual requested from solvers: smaller than `TOL`, as the units of the files differ."""
SHIPPED = ("contact_problems.py", "rolling_contact.py")
TABLE = "problems.csv"
SOLVED_BY = ("newton", "splitting", "norm", "tang-safeguarded")
"""Solvers that are tried in turn until the residual is reached."""
Arrays = dict[str, Any]


@checks.named_options()
@one_blas_thread()
def save_problems(
    folder: str | Path,
    problems: Mapping[str, BenchmarkProblem] | None = None,
    *,
    progress: Progress = None,
) -> list[Path]:
    """Write the problems on which solvers are compared to a folder, with their solutions to 1e-10,
    for authors of solvers: read without this package, a test set of qpbenchmark, CVXPY problems.

    Parameters
    ----------
    folder : str or Path
        A new or empty one, or one that was written so, whose files are replaced.
    problems : dict of str to BenchmarkProblem, optional
        Some of `benchmark_problems()`; all of them, if not given.
    progress : callable or true, optional
        Called with the name of a problem.

    Returns
    -------
    list of Path
        The files of the problems; `README.md` beside them says what they hold.

    Raises
    ------
    OutputError
        If the folder holds other files, or cannot be written.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> import varcontact as vc
    >>> chosen = {"circle, 8 across": vc.benchmark_problems()["circle, 8 across"]}
    >>> with TemporaryDirectory() as folder:
    ...     [path.name for path in vc.save_problems(folder, chosen)]
    ['circle_8_across.npz']
    """
    folder = checks.file_name("folder", folder)
    if problems is None:
        problems = benchmark_problems()
    check_problems(problems)
    report = checks.progress(progress)
    _check_folder(folder)
    paths = []
    rows = []
    for name, each in problems.items():
        report(name)
        path = folder / "data" / f"{file_stem(name)}.npz"
        arrays = solved_arrays(each)
        buffer = io.BytesIO()
        np.savez_compressed(buffer, **arrays)
        write_whole("folder", path, buffer.getvalue())
        paths.append(path)
        rows.append(_row(path.stem, each, arrays))
    write_whole("folder", folder / TABLE, _table(rows))
    templates = files("varcontact.benchmark").joinpath("shipped")
    for name in SHIPPED:
        write_whole("folder", folder / name, templates.joinpath(name).read_bytes())
    readme = templates.joinpath("README.md").read_text(encoding="utf-8")
    write_whole("folder", folder / "README.md", _filled(readme, rows).encode())
    return paths


def _check_folder(folder: Path) -> None:
    """Make the folder; refuse one that contains anything else."""
    try:
        (folder / "data").mkdir(parents=True, exist_ok=True)
        others = {path.name for path in folder.iterdir()} - {"data"}
    except OSError as error:
        raise OutputError("folder", folder, f"cannot be written ({error.strerror})") from None
    if others and TABLE not in others:
        reason = "holds other files: name a new or empty folder"
        raise OutputError("folder", folder, reason)


def file_stem(name: str) -> str:
    """File name without ending for the name of a problem."""
    words = name.replace(" = ", "=").replace("/", "_by_")
    return re.sub(r"[^\w.=-]+", "_", words).strip("_")


def solved_arrays(each: BenchmarkProblem) -> Arrays:
    """Arrays of a problem's file, scaled so that an element's influence on itself is at most 1."""
    problem = each.program().contact_problem
    solution = _solution(each.name, problem)
    if isinstance(problem, NormalProblem):
        return _normal(problem, solution)
    return _tangential(problem, solution)


def _solution(name: str, problem: NormalProblem | TangentialProblem) -> RawSolution:
    kind: Kind = "tangential"
    if isinstance(problem, NormalProblem):
        kind = "normal"
    best = None
    for solver in SOLVED_BY:
        spec = SOLVERS.get((kind, solver))
        if spec is not None:
            best = better(problem, best, spec.once(problem, Settings(REACHED_FOR), None))
            if natural_residual(problem, best) <= REACHED_FOR:
                return best
    assert best is not None
    residual = natural_residual(problem, best)
    if residual > TOL:
        raise NotConverged(f"{name} was not solved to {TOL:g}", residual)
    return best


def _normal(problem: NormalProblem, solution: RawSolution) -> Arrays:
    """Arrays of a normal problem; distances count from a prescribed approach, else from the
    smallest distance.
    """
    level = problem.approach
    rigid = 0.0
    force = np.nan
    unit = float(solution.traction.max())
    if level is None:
        assert problem.force is not None
        level = float(problem.distance.min())
        force = problem.force / (problem.area * unit)
        rigid = level - float(solution.rigid[0])
    of_shift = problem.operator.diagonal * unit
    shifts = {"shift": (problem.distance - level)[None] / of_shift}
    rigids = {"force": np.array([force]), "rigid": np.array([rigid / of_shift])}
    return {
        **_matrix(problem),
        **shifts,
        **rigids,
        "p": solution.traction[None] / unit,
        "residual": np.array(natural_residual(problem, solution)),
    }


def _tangential(problem: TangentialProblem, solution: RawSolution) -> Arrays:
    if problem.potential.flow is not None:
        raise SceneError("problems", "a third body", "problems without one")
    unit = float(problem.bound.max())
    of_shift = problem.operator.diagonal * unit
    forces = np.array(problem.force[: problem.components], dtype=float)  # None: NaN
    return {
        **_matrix(problem),
        "shift": problem.rigid_shift / of_shift,
        "bound": problem.bound / unit,
        "force": forces / (problem.area * unit),
        "rigid": solution.rigid / of_shift,
        "p": solution.traction / unit,
        "residual": np.array(natural_residual(problem, solution)),
    }


def _matrix(problem: NormalProblem | TangentialProblem) -> Arrays:
    """The influence numbers between the elements: those of a block-Toeplitz matrix."""
    operator = problem.operator
    assert operator.grid_operator.toeplitz
    assert operator.softening is None
    rows, columns = np.divmod(operator.elements, operator.grid_operator.shape[1])
    return {
        "kernel": operator.grid_operator.table / operator.diagonal,
        "elements": np.column_stack([rows, columns]),
        "symmetric": np.array(problem.symmetric),
    }


def _row(stem: str, each: BenchmarkProblem, arrays: Arrays) -> dict[str, Any]:
    components, elements = arrays["shift"].shape
    return {
        "name": stem,
        "family": each.family,
        "problem": each.problem,
        "elements": elements,
        "unknowns": components * elements,
        "symmetric": bool(arrays["symmetric"]),
        "residual": float(arrays["residual"]),
    }


def _table(rows: list[dict[str, Any]]) -> bytes:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def _filled(readme: str, rows: list[dict[str, Any]]) -> str:
    """README with the figures of these problems filled in."""
    sizes = [row["elements"] for row in rows]
    normal = sum(row["problem"] == "normal" for row in rows)
    words = {
        "count": len(rows),
        "normal": normal,
        "tangential": len(rows) - normal,
        "least": min(sizes),
        "most": max(sizes),
        "version": varcontact.__version__,
    }
    for name, value in words.items():
        readme = readme.replace(f"{{{name}}}", str(value))
    return readme
