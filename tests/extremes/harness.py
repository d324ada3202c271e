"""Answers at the extremes: every scene by every family of solvers, held against what is known otherwise."""

from __future__ import annotations

import json
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.extremes import motions, scenes
from tests.extremes.checks import distance
from tests.extremes.scenes import APPROXIMATE, Case
from tests.extremes.worker import Worker
from varcontact import checks
from varcontact.errors import Interrupted, SceneError, VarcontactError
from varcontact.results.solution import Solution
from varcontact.scene.motion import Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.solving.selection import select
from varcontact.study.csv_table import Table, columns_of_text, plain_rows
from varcontact.theories.on_grid import THEORIES, why_not

if TYPE_CHECKING:
    import pandas as pd

PASSED, REFUSED, LIMIT, FAILED = "passed", "refused", "known limit", "FAILED"
MAGNIFIED = 100.0
"""How many times a residual the error of the tractions may be: the elements across a contact, with some to spare."""
COLUMNS = (
    "group",
    "case",
    "family",
    "verdict",
    "reason",
    "against",
    "error",
    "cap",
    "agreement",
    "residual",
    "relative_gap",
    "seconds",
)
WORDS = ("group", "case", "family", "verdict", "reason", "against")


@dataclass(frozen=True)
class Family:
    """Methods that go together, and the residual that they are asked for."""

    normal: str = "auto"
    tangential: str = "auto"
    coupling: str = "auto"
    polish: bool = True
    tol: float = 1e-8

    def options(self, scene: Scene) -> dict[str, Any]:
        """What `solve` is told; where there is a motion, Hertz's closed form serves as the pressure if it can."""
        hertzian = scene.motion is not None and select(scene).normal == "hertz"
        return {
            "normal": "auto" if hertzian else self.normal,
            "tangential": "auto" if scene.motion is None else self.tangential,
            "coupling": self.coupling,
            "polish": self.polish,
            "tol": self.tol,
        }


FAMILIES = {
    "default": Family(),
    "polished": Family("clarabel", "clarabel"),
    "conic": Family("clarabel", "clarabel", polish=False, tol=1e-5),
    "active set": Family("norm", "tang-safeguarded"),
    "tang": Family("norm", "tang"),
    "newton": Family("newton", "newton"),
    "scs": Family("scs", "scs", polish=False, tol=1e-5),
    "osqp": Family("osqp", "osqp", polish=False, tol=1e-5),
    "joint": Family(coupling="joint"),
    "johnson": Family(coupling="johnson"),
    "fastsim": Family(tangential="fastsim"),
    "linear": Family(tangential="linear"),
}
"""The default is what "auto" takes; conic, scs and osqp are a solver's own answer, polished is Clarabel's, polished."""


def cases() -> list[Case]:
    """All scenes at the extremes."""
    made: list[Case] = []
    for group in ("units", "friction", "materials", "shapes"):
        made += getattr(scenes, group)()
    for group in ("creepages", "spins", "forces", "contacts", "touches", "steps"):
        made += getattr(motions, group)()
    return made


def extremes(
    *,
    short: bool = False,
    only: str = "",
    store: str | Path | None = None,
    progress: Callable[[str], None] | None = None,
    chosen: Sequence[Case] | None = None,
) -> pd.DataFrame:
    """Solve the scenes at the extremes by every family of solvers, each in a process that may hang or die."""
    import pandas as pd

    short, progress = checks.flag("short", short), checks.progress(progress)
    wanted = [case for case in (cases() if chosen is None else chosen) if case.short or not short]
    wanted = [case for case in wanted if only in case.group or only in case.name]
    if not wanted:
        raise SceneError(
            "only", only, f"in a scene's name or group: {', '.join(dict.fromkeys(c.group for c in cases()))}"
        )
    with Table.opened(store, COLUMNS, WORDS, "a table of an earlier run") as table:
        known = {(row["group"], row["case"]) for row in table.rows}
        try:
            with Worker(attempt) as worker:
                for done, case in enumerate(wanted):
                    if (case.group, case.name) in known:
                        continue
                    if progress is not None:
                        progress(f"{done + 1} of {len(wanted)}: {case.group}, {case.name}")
                    table.add(*_of_case(case, worker))
        except KeyboardInterrupt:
            partial = pd.DataFrame(table.rows, columns=list(COLUMNS))
            finished = f" after {len(partial.groupby(['group', 'case']))} of {len(wanted)} scenes"
            raise Interrupted(partial, finished) from None
    return pd.DataFrame(table.rows, columns=list(COLUMNS))


def _of_case(case: Case, worker: Worker) -> list[dict[str, Any]]:
    """The rows of one scene."""
    rows, solutions = [], {}
    for name in case.families:
        begun = time.perf_counter()
        answer, words = worker.ask((case, name), case.seconds)
        row, solution = answer if words == "" else ({"verdict": FAILED, "reason": words}, None)
        if not row:
            continue
        seconds = time.perf_counter() - begun
        rows.append({"group": case.group, "case": case.name, "family": name, **row, "seconds": seconds})
        if solution is not None and name not in APPROXIMATE:
            solutions[name] = solution
    return _agreeing(rows, solutions)


def attempt(case: Case, name: str) -> tuple[dict[str, Any], Solution | None]:
    """One family on one scene: its row, empty where it does not apply, and the answer.

    A scene that cannot even be made is refused once, in the first family.
    """
    scene = None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", RuntimeWarning)  # of numbers that overflow, or are none
            scene = case.scene()
            if not applies(name, scene):
                return {}, None
            answer = case.work(scene, **FAMILIES[name].options(scene))
            solution = answer if isinstance(answer, Solution) else answer[-1]
            return judge(case, name, solution), solution
    except VarcontactError as error:
        reason = str(error).splitlines()[0]
        if scene is None and name != case.families[0]:
            return {}, None
        if name in case.limits:
            return {"verdict": LIMIT, "reason": f"{case.limits[name]} ({reason})"}, None
        owed = case.answer and name == "default"
        return {"verdict": FAILED if owed else REFUSED, "reason": reason}, None
    except Exception as error:  # whatever it is, it is no refusal of ours
        return {"verdict": FAILED, "reason": f"crash: {error!r}"}, None


def applies(name: str, scene: Scene) -> bool:
    """Whether a family is for such a scene at all."""
    if name in ("joint", "johnson"):
        return scene.bodies.coupled and not scene.frictionless
    if name in THEORIES:
        return not why_not(name, scene)
    if name == "osqp":
        return scene.motion is None or (scene.line and not isinstance(scene.motion, Transient))
    return name != "tang" or scene.motion is not None


def judge(case: Case, name: str, sol: Solution) -> dict[str, Any]:
    """What an answer is worth: numbers, signs, bounds, residual, and the error against the reference."""
    tol, certificate = FAMILIES[name].tol, sol.certificate
    formula = sol.plan.normal == "hertz" and sol.scene.motion is None
    row: dict[str, Any] = {}
    if not formula:
        row |= {"residual": certificate.residual, "relative_gap": certificate.relative_gap}
    wrong = _wrong(sol, name)
    if not case.answer:
        wrong = "an answer where there is none"
    exact = name not in APPROXIMATE
    if exact and not wrong and not formula and not certificate.residual <= tol:
        wrong = f"taken for solved with a residual of {certificate.residual:.1e}"
    if exact and not wrong and case.reference is not None:
        error, cap = case.reference.error(sol), case.reference.cap + MAGNIFIED * tol
        row |= {"against": case.reference.what, "error": error, "cap": cap}
        wrong = "" if error <= cap else f"{error:.2g} from {case.reference.what}, more than {cap:.2g}"
    return row | {"verdict": FAILED if wrong else PASSED, "reason": wrong}


def _wrong(sol: Solution, name: str) -> str:
    """What cannot be in any answer, or nothing."""
    floating = sol.scene.line and sol.scene.reference_depth is None
    numbers: list[Any] = [sol.pressure, sol.traction, sol.slip, sol.force, sol.moment, sol.certificate.residual]
    numbers += [] if floating else [sol.approach, sol.distance, sol.creepage if sol.motion is not None else 0.0]
    if not all(np.isfinite(each).all() for each in numbers):
        return "NaN or inf in the answer"
    if sol.pressure.min() < 0 or not sol.pressure.any():
        return "pressures that pull, or none"
    load, margin = sol.scene.normal_force, 1e-6
    if load is not None and abs(sol.normal_force / load - 1) > margin:
        return f"a normal force of {sol.normal_force:.6g} in place of {load:.6g}"
    carried, size = sol.traction_bound.sum() * sol.grid.area, np.hypot(*sol.force)
    if name != "linear" and (size > carried * (1 + margin)):
        return f"a tangential force of {size:.6g}, above f Fz = {carried:.6g}"
    if name not in ("linear", "fastsim") and np.any(np.hypot(*sol.traction) > sol.traction_bound * (1 + 1e-5)):
        return "tractions beyond their bound"
    return _prescribed(sol) or _direction(sol)


def _prescribed(sol: Solution) -> str:
    """A tangential force other than the prescribed one."""
    motion: Any = sol.motion
    for i, wanted in enumerate((getattr(motion, "Fx", None), getattr(motion, "Fy", None))):
        carried = float(np.abs(sol.traction).sum() * sol.grid.area)
        if wanted is not None and abs(sol.force[i] - wanted) > 1e-4 * max(abs(wanted), 1e-3 * carried):
            return f"a force {'xy'[i]} of {sol.force[i]:.6g} in place of {wanted:.6g}"
    return ""


def _direction(sol: Solution) -> str:
    """Friction that drives: against a creepage without spin the force does work."""
    motion = sol.motion
    if not isinstance(motion, Steady) or motion.spin != 0 or motion.Fx is not None or sol.scene.bodies.coupled:
        return ""
    against = float(np.dot(sol.force, motion.rigid[:2]))
    return "a force along the creepage" if against > 0 else ""


def _agreeing(rows: list[dict[str, Any]], solutions: dict[str, Solution]) -> list[dict[str, Any]]:
    """The rows, with the distance of each exact answer from the best with the same kind of pressure."""
    for row in rows:
        if row["family"] not in solutions or row["verdict"] != PASSED:
            continue
        own, solution = row["family"], solutions[row["family"]]
        others = [
            each["family"]
            for each in rows
            if each["family"] in solutions
            and each["verdict"] == PASSED
            and each["family"] != own
            and (solutions[each["family"]].plan.normal == "hertz") == (solution.plan.normal == "hertz")
        ]
        if not others:
            if "error" not in row:
                row |= {"verdict": FAILED, "reason": "nothing to hold it against"}
            continue
        best = min(others, key=lambda name: solutions[name].certificate.residual)
        row["agreement"] = distance(solution, solutions[best])
        cap = MAGNIFIED * max(FAMILIES[own].tol, FAMILIES[best].tol)
        if not row["agreement"] <= cap:
            row |= {"verdict": FAILED, "reason": f"{row['agreement']:.2g} from the answer of {best}"}
    return rows


def report(table: pd.DataFrame) -> str:
    """The table in words and figures, for people: a block for each group, then what was not passed, and why."""
    blocks = [_block(str(group), rows.to_dict("records")) for group, rows in table.groupby("group", sort=False)]
    counts = table["verdict"].value_counts()
    total = ", ".join(f"{counts.get(verdict, 0)} {verdict}" for verdict in (PASSED, REFUSED, LIMIT, FAILED))
    scenes = len(table[["group", "case"]].drop_duplicates())
    return "\n\n".join(
        [*blocks, f"{scenes} scenes, {len(table)} answers or refusals: {total}; {table['seconds'].sum():.0f} s"]
    )


_SIGNS = {PASSED: "+", REFUSED: "refused", LIMIT: "limit", FAILED: "FAILED"}


def _block(group: str, rows: Sequence[dict[str, Any]]) -> str:
    families = [name for name in FAMILIES if any(row["family"] == name for row in rows)]
    lines = [["", *families, "error", "against", "agreement", "residual"]]
    for case in dict.fromkeys(row["case"] for row in rows):
        own = {row["family"]: row for row in rows if row["case"] == case}
        signs = [_SIGNS[own[name]["verdict"]] if name in own else "" for name in families]
        exact = [row for name, row in own.items() if name not in APPROXIMATE and row["verdict"] == PASSED]
        figures = [_largest(exact, name) for name in ("error", "agreement", "residual")]
        against = next((row["against"] for row in exact if isinstance(row.get("against"), str)), "")
        lines.append([case, *signs, figures[0], against, *figures[1:]])
    reasons: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        if row["verdict"] != PASSED:
            reasons.setdefault((row["case"], f"{row['verdict']}: {row['reason']}"), []).append(row["family"])
    asked = {case: [row for row in rows if row["case"] == case] for case, _ in reasons}
    told = [
        f"  {case}, {'all' if len(names) == len(asked[case]) else ', '.join(names)}\n    {reason}"
        for (case, reason), names in reasons.items()
    ]
    return "\n".join([group, *columns_of_text(lines, left=1), *told])


def _largest(rows: Iterable[dict[str, Any]], name: str) -> str:
    values = [row[name] for row in rows if isinstance(row.get(name), float) and not np.isnan(row[name])]
    return f"{max(values):.0e}" if values else ""


def as_json(table: pd.DataFrame) -> str:
    """The table as a JSON array of rows; null where nothing is known."""
    return json.dumps(plain_rows(table), indent=2, allow_nan=False)
