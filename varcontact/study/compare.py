"""Methods side by side on the same scenes, judged by one yardstick that belongs to none of them."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import NotConverged, SceneError, SolverUnavailable, VarcontactError
from varcontact.io.scenefile import scene_to
from varcontact.methods import available, load_packages, normal_methods, states_programs, tangential_methods
from varcontact.plan import FORMULATIONS, Plan, make_plan
from varcontact.scene import Scene, Shift, Steady
from varcontact.solution import Solution
from varcontact.solve import solve_many
from varcontact.theories.methods import THEORIES

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

DEFAULT_METHODS = (
    "clarabel",
    "clarabel+polish",
    "scs",
    "cvxpy:CLARABEL",
    "tang",
    "tang-safeguarded",
    "fastsim",
    "linear",
    "vermeulen-johnson",
)

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
    "identity",
)
"""What the table says of each scene and method."""

_WORDS = ("scene", "method", "outcome", "reason", "identity")


def compare(
    scenes: Scene | Mapping[str, Scene],
    methods: Iterable[str] = DEFAULT_METHODS,
    *,
    tol: float = 1e-6,
    store: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> pd.DataFrame:
    """Solve scenes by many methods, and measure each answer.

    Parameters
    ----------
    scenes : Scene or dict of str to Scene
        One scene, or several by name (as `standard_bank()`).
    methods : iterable of str
        Each ``[normal|]tangential[/formulation][+polish]``: "tang", "clarabel/gap", "clarabel+polish",
        "osqp|scs". A name alone stands for both problems where a normal problem has to be solved (with "norm" for
        "tang"); where Hertz's closed form serves, that is taken. Without "+polish" the answer is the method's own.
    tol : float
        Natural-map residual at which an answer counts as solved.
    store : str or Path, optional
        A CSV file: scenes that it has, solved by the same methods, are not solved again; each further scene is
        added when it is finished.
    progress : callable, optional
        Told scene and method.

    Returns
    -------
    pandas.DataFrame
        One row per scene and method. `outcome` is "solved", "approximate" (a theory, or Hertz's pressure where
        that is all), "not converged", "refused" or "unavailable", `reason` why. Forces, moment, creepage and
        approach; gap, relative gap, residual and guaranteed bound on the force, all recomputed; distance of the
        force (by the largest friction force) and of the tractions (by the largest traction bound) from the
        solution of the smallest residual on that scene, and elements with another state than there; iterations;
        seconds by stage. `repeat_seconds` are those of a second scene with creepages (or forces) one per cent
        smaller and everything kept that can be, `setup_seconds` what the first took longer.

    Raises
    ------
    SceneError
        For a method that does not exist, before any work starts.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=10, ny=10))
    >>> table = vc.compare(scene, ["clarabel", "tang", "fastsim"])
    >>> table["outcome"].tolist(), bool((table["force_distance"] < [1e-6, 1e-6, 0.15]).all())
    (['solved', 'solved', 'approximate'], True)
    """
    import pandas as pd

    tol = checks.positive("tol", tol)
    named = _named(scenes)
    if isinstance(methods, str) or not isinstance(methods, Iterable):
        raise SceneError("methods", methods, "a list of names")
    if not (store is None or isinstance(store, (str, Path))):
        raise SceneError("store", store, "the name of a file")
    chosen = [Method.named(method) for method in methods]
    if not chosen or not named:
        raise SceneError("methods" if named else "scenes", [], "one at least")
    identities = {name: _identity(scene, tol) for name, scene in named.items()}
    done = _stored(store, [method.name for method in chosen], identities)
    for name, scene in named.items():
        if any(row["scene"] == name for row in done):
            continue
        rows = _compared(name, scene, chosen, tol, progress)
        done += [{**row, "identity": identities[name]} for row in rows]
        if store is not None:
            _keep(store, done)
    return pd.DataFrame([row for row in done if row["scene"] in named], columns=list(COLUMNS))


def _named(scenes: Scene | Mapping[str, Scene]) -> dict[str, Scene]:
    """Scenes by name."""
    if isinstance(scenes, Scene):
        return {"scene": scenes}
    if not isinstance(scenes, Mapping):
        raise SceneError("scenes", scenes, "a Scene, or a dict of them by name")
    for name, scene in scenes.items():
        if not isinstance(name, str):
            raise SceneError("scenes", name, "named by strings")
        if not isinstance(scene, Scene):
            raise SceneError(f"scenes[{name!r}]", scene, "a Scene")
    return dict(scenes)


@dataclass(frozen=True)
class Method:
    """A method of comparison: what its name says.

    Examples
    --------
    >>> Method.named("osqp|clarabel/gap+polish")
    Method(name='osqp|clarabel/gap+polish', normal='osqp', tangential='clarabel', formulation='gap', polish=True)
    """

    name: str
    normal: str
    tangential: str
    formulation: str
    polish: bool

    @classmethod
    def named(cls, name: str) -> Method:
        """From ``[normal|]tangential[/formulation][+polish]``."""
        rest, plus, polish = str(name).strip().partition("+")
        if plus and polish != "polish":
            raise SceneError("methods", name, "such that only polish comes after a +")
        rest, _, formulation = rest.partition("/")
        normal, bar, tangential = rest.partition("|")
        every = ["auto", *tangential_methods(), *THEORIES]
        if bar:
            _known("methods", normal, ["auto", *normal_methods()])
            _known("methods", tangential, every)
        else:
            only_normal = [known for known in normal_methods() if known not in every]
            _known("methods", rest, [*every, *only_normal])
            takes_cones = rest in every or (rest.startswith("cvxpy:") and rest not in only_normal)
            normal, tangential = _partner(rest), rest if takes_cones else ""
        if formulation:
            checks.choice("methods", formulation, FORMULATIONS)
        return cls(str(name).strip(), normal, tangential, formulation or "auto", bool(plus))

    def plan(self, scene: Scene) -> Plan:
        """The plan for a scene, or the error that says why not."""
        moves = scene.motion is not None
        if moves and not self.tangential:
            reason = f"a tangential method beside it, as {self.name}|clarabel: it is for normal problems"
            raise SceneError("methods", self.name, reason)
        normal = self.normal if make_plan(scene).normal != "hertz" or "|" in self.name or not moves else "auto"
        plan = make_plan(scene, normal, self.tangential or "auto", "auto", self.formulation)
        if self.polish and not (states_programs(plan.tangential) or states_programs(plan.normal)):
            raise SceneError("methods", self.name, "without +polish: only solvers of programs are polished")
        return plan


def _known(field: str, name: str, names: list[str]) -> None:
    """Refuse names that are none; what is not installed is found out later, and listed."""
    with suppress(SolverUnavailable):
        available(field, name, names)


def _partner(name: str) -> str:
    """The normal method that goes with a tangential one of that name."""
    if name.startswith("tang"):
        return "norm"
    return "auto" if name in THEORIES else name


def _compared(
    name: str, scene: Scene, methods: list[Method], tol: float, progress: Callable[[str], None] | None
) -> list[dict[str, Any]]:
    """The rows of one scene."""
    rows, solutions = [], []
    for method in methods:
        if progress is not None:
            progress(f"{name}: {method.name}")
        row, solution = _run(scene, method, tol)
        rows.append({"scene": name, "method": method.name, **row})
        solutions.append(solution)
    exact = [sol for sol, row in zip(solutions, rows, strict=True) if sol is not None and row["outcome"] == "solved"]
    if exact:
        best = min(exact, key=lambda sol: sol.certificate.residual)
        for row, solution in zip(rows, solutions, strict=True):
            if solution is not None and solution.grid == best.grid:
                row |= _distances(solution, best)
    return rows


def _run(scene: Scene, method: Method, tol: float) -> tuple[dict[str, Any], Solution | None]:
    """One method on one scene: what there is to say, and the solution as far as there is one."""
    try:
        plan = method.plan(scene)
        load_packages(plan.normal, plan.tangential)
    except SolverUnavailable as error:
        return {"outcome": "unavailable", "reason": str(error)}, None
    except SceneError as error:
        return {"outcome": "refused", "reason": str(error)}, None
    formula = plan.tangential in THEORIES or (plan.tangential == "none" and plan.normal == "hertz")
    outcome = "approximate" if formula or plan.coupling == "johnson" else "solved"
    reason, solution, repeat = "", None, None
    try:
        motions = [scene.motion, _neighbour(scene.motion)] if scene.motion is not None else [None]
        solved = solve_many(scene, motions, plan, tol, method.polish)
        solution = next(solved)
        repeat = next(solved, None)
    except NotConverged as error:
        if solution is None:
            outcome, reason, solution = "not converged", str(error), error.solution
    except VarcontactError as error:
        if solution is None:
            outcome, reason = "refused", str(error)
    row: dict[str, Any] = {"outcome": outcome, "reason": reason}
    if solution is not None:
        row |= _measured(solution, repeat)
    return row, solution


def _neighbour(motion: Steady | Shift) -> Steady | Shift:
    """Creepages and forces one per cent smaller."""
    names = ("vx", "vy", "spin") if isinstance(motion, Steady) else ("ux", "uy", "rotation")
    values = {name: getattr(motion, name) for name in (*names, "Fx", "Fy")}
    smaller: dict[str, Any] = {name: None if value is None else 0.99 * value for name, value in values.items()}
    return replace(motion, **smaller)


def _measured(sol: Solution, repeat: Solution | None) -> dict[str, Any]:
    certificate, (Fx, Fy), (vx, vy, spin) = sol.certificate, sol.force, sol.creepage
    work = sol.timing.get("normal", 0.0) + sol.timing.get("tangential", 0.0)
    row = {
        "Fx": float(Fx),
        "Fy": float(Fy),
        "Mz": sol.moment,
        "vx": vx,
        "vy": vy,
        "spin": spin,
        "approach": sol.approach,
        "gap": certificate.gap,
        "relative_gap": certificate.relative_gap,
        "residual": certificate.residual,
        "force_bound": float(np.max(certificate.force_bound[:2])),
        "iterations": sum(sol.iterations.values()),
        "normal_seconds": sol.timing.get("normal", 0.0),
        "tangential_seconds": sol.timing.get("tangential", 0.0),
        "certificate_seconds": sol.timing.get("certificate", 0.0),
        "total_seconds": sol.timing["total"],
    }
    if repeat is not None:
        again = repeat.timing.get("normal", 0.0) + repeat.timing.get("tangential", 0.0)
        row |= {"repeat_seconds": again, "setup_seconds": max(work - again, 0.0)}
    return row


def _distances(sol: Solution, best: Solution) -> dict[str, Any]:
    """How far from the best certified solution of the scene."""
    bound = best.traction_bound
    carried = float(bound.sum() * best.grid.area)
    if not 0 < carried < np.inf:  # no friction or no slip: by the pressures
        away = float(np.abs(sol.pressure - best.pressure).max() / best.pressure.max())
        return {"traction_distance": away, "misclassified": int(np.sum(sol.state != best.state))}
    return {
        "force_distance": float(np.hypot(*(sol.force - best.force)) / carried),
        "traction_distance": float(np.hypot(*(sol.traction - best.traction)).max() / bound.max()),
        "misclassified": int(np.sum(sol.state != best.state)),
    }


def _identity(scene: Scene, tol: float) -> str:
    """A few digits that tell one scene and tolerance from another."""
    described = json.dumps([scene_to(scene), tol], sort_keys=True)
    return hashlib.sha256(described.encode()).hexdigest()[:12]


def _stored(store: str | Path | None, methods: list[str], identities: dict[str, str]) -> list[dict[str, Any]]:
    """Rows of an earlier run: whole scenes, the same by the same methods."""
    import pandas as pd

    if store is None or not Path(store).exists():
        return []
    try:
        # a scene may be called "NA": only empty figures are missing
        table = pd.read_csv(store, dtype=dict.fromkeys(_WORDS, str), keep_default_na=False, na_values=[""])
        if list(table.columns) != list(COLUMNS):
            raise ValueError("other columns")
    except (ValueError, OSError, UnicodeDecodeError) as error:
        raise SceneError("store", str(store), f"a table of an earlier comparison, or a new file ({error})") from None
    table[list(_WORDS)] = table[list(_WORDS)].fillna("")
    rows: list[dict[str, Any]] = table.to_dict("records")
    scenes = dict.fromkeys(row["scene"] for row in rows)
    for scene in scenes:
        if [row["method"] for row in rows if row["scene"] == scene] != methods:
            raise SceneError("store", str(store), "a table by the same methods, in the same order, or a new file")
    for row in rows:
        if identities.get(row["scene"], row["identity"]) != row["identity"]:
            raise SceneError("store", str(store), f"a table with the same scene {row['scene']!r}, or a new file")
    return rows


def _keep(store: str | Path, rows: list[dict[str, Any]]) -> None:
    import pandas as pd

    from varcontact.io.netcdf import write_whole

    content = pd.DataFrame(rows, columns=list(COLUMNS)).to_csv(index=False).encode()
    write_whole("store", Path(store), content)


def as_json(table: pd.DataFrame) -> str:
    """A comparison as a JSON array of rows, all digits of its figures; null where nothing is known."""
    rows = [{name: _plain(value) for name, value in row.items()} for row in table.to_dict("records")]
    return json.dumps(rows, indent=2, allow_nan=False)


def _plain(value: Any) -> Any:
    """What JSON can say: no infinity, no NaN."""
    return value if not isinstance(value, float) or np.isfinite(value) else None


def summary(table: pd.DataFrame) -> str:
    """A comparison in words and figures, for people: a block for each scene, then what was not solved and why."""
    blocks = []
    for scene, rows in table.groupby("scene", sort=False):
        records = rows.to_dict("records")
        lines = [list(_SHOWN), *([_cell(row[name], form) for name, form in _SHOWN.values()] for row in records)]
        widths = [max(len(line[i]) for line in lines) for i in range(len(_SHOWN))]
        text = [
            "  ".join(
                cell.ljust(width) if i < 2 else cell.rjust(width)
                for i, (cell, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        ]
        reasons = [f"  {row['method']}: {row['reason']}" for row in records if row["reason"]]
        blocks.append("\n".join([str(scene), *text, *reasons]))
    return "\n\n".join(blocks)


_SHOWN = {
    "method": ("method", "s"),
    "outcome": ("outcome", "s"),
    "Fx": ("Fx", ".6g"),
    "Fy": ("Fy", ".6g"),
    "Mz": ("Mz", ".5g"),
    "rel. gap": ("relative_gap", ".0e"),
    "residual": ("residual", ".0e"),
    "force off": ("force_distance", ".0e"),
    "traction off": ("traction_distance", ".0e"),
    "areas off": ("misclassified", ".0f"),
    "iterations": ("iterations", ".0f"),
    "set-up s": ("setup_seconds", ".3f"),
    "repeat s": ("repeat_seconds", ".3f"),
}
"""Columns of the printed table: which of the measured ones, and how written."""


def _cell(value: Any, form: str) -> str:
    """A value as text; nothing where it is not known."""
    return "" if value != value else format(value, form)


def plot_comparison(table: pd.DataFrame) -> Figure:
    """Picture of a comparison: error of the tractions against time, a point for each scene and method.

    Parameters
    ----------
    table : pandas.DataFrame
        From `compare`.

    Returns
    -------
    matplotlib.figure.Figure
    """
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(9, 5.5), layout="constrained")
    measured = table[table["traction_distance"].notna()]
    markers = "os^vDP*X<>hd"
    for i, (method, rows) in enumerate(measured.groupby("method", sort=False)):
        seconds = rows["normal_seconds"] + rows["tangential_seconds"]
        error = np.maximum(rows["traction_distance"], 1e-16)
        color, marker = f"C{i % 10}", markers[i % len(markers)]
        failed = (rows["outcome"] == "not converged").to_numpy()
        axes.plot(seconds[~failed], error[~failed], marker, color=color, alpha=0.8, label=f"{method}")
        if failed.any():
            label = f"{method}, not converged"
            axes.plot(seconds[failed], error[failed], marker, color=color, markerfacecolor="none", label=label)
    axes.set(xscale="log", yscale="log", xlabel="time of normal and tangential problem [s]")
    axes.set_ylabel("distance of tractions from the best solution,\nby the largest traction bound")
    axes.set_ylim(bottom=1e-17)
    axes.grid(alpha=0.3)
    if not measured.empty:
        figure.legend(loc="outside right upper", fontsize="small")
    plt.close(figure)
    return figure
