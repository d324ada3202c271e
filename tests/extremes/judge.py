"""Every scene at the extremes by every family of solvers, held against what is known otherwise."""

import warnings

import numpy as np

import varcontact as vc
from tests.extremes import scenes
from tests.extremes.checks import distance
from tests.extremes.scenes import APPROXIMATE, Case
from varcontact.solving.selection import select
from varcontact.theories.on_grid import THEORIES, why_not

PASSED, REFUSED, LIMIT, FAILED = "passed", "refused", "known limit", "FAILED"
MAGNIFIED = 100.0
"""How many times a residual the error of the tractions may be: the elements across a contact, with some to spare."""
OWN = {"polish": False, "tol": 1e-5}
FAMILIES = {
    "default": {},
    "polished": {"normal": "clarabel", "tangential": "clarabel"},
    "conic": {"normal": "clarabel", "tangential": "clarabel", **OWN},
    "active set": {"normal": "norm", "tangential": "tang-safeguarded"},
    "tang": {"normal": "norm", "tangential": "tang"},
    "newton": {"normal": "newton", "tangential": "newton"},
    "scs": {"normal": "scs", "tangential": "scs", **OWN},
    "osqp": {"normal": "osqp", "tangential": "osqp", **OWN},
    "joint": {"coupling": "joint"},
    "johnson": {"coupling": "johnson"},
    "fastsim": {"tangential": "fastsim"},
    "linear": {"tangential": "linear"},
}
"""The default is what "auto" takes; conic, scs and osqp are a solver's own answer, polished is Clarabel's, polished."""


def tolerance(name: str) -> float:
    return FAMILIES[name].get("tol", 1e-8)


def options(name: str, scene: vc.Scene) -> dict:
    """What `solve` is told; where there is a motion, Hertz's closed form serves as the pressure if it can."""
    unused = "tangential" if scene.motion is None else "normal" if select(scene).normal == "hertz" else ""
    return {key: value for key, value in FAMILIES[name].items() if key != unused}


def cases() -> list[Case]:
    """All scenes at the extremes."""
    groups = (scenes.units, scenes.friction, scenes.materials, scenes.shapes, scenes.creepages, scenes.spins)
    groups += (scenes.forces, scenes.contacts, scenes.touches, scenes.steps)
    return [case for group in groups for case in group()]


def rows_of(case: Case) -> list[dict]:
    """What came of one scene, by family."""
    rows, solutions = [], {}
    for name in case.families:
        row, solution = attempt(case, name)
        if row:
            rows.append({"group": case.group, "case": case.name, "family": name, **row})
        if solution is not None and name not in APPROXIMATE:
            solutions[name] = solution
    return agreeing(rows, solutions)


def attempt(case: Case, name: str) -> tuple[dict, vc.Solution | None]:
    """One family on one scene: its row, empty where it does not apply, and the answer."""
    scene = None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            warnings.simplefilter("error", RuntimeWarning)  # of numbers that overflow, or are none
            scene = case.scene()
            if not applies(name, scene):
                return {}, None
            answer = case.work(scene, **options(name, scene))
            solution = answer if isinstance(answer, vc.Solution) else answer[-1]
            return judge(case, name, solution), solution
    except vc.VarcontactError as error:
        reason = str(error).splitlines()[0]
        if scene is None and name != case.families[0]:
            return {}, None
        if name in case.limits:
            return {"verdict": LIMIT, "reason": f"{case.limits[name]} ({reason})"}, None
        owed = case.answer and name == "default"
        return {"verdict": FAILED if owed else REFUSED, "reason": reason}, None
    except Exception as error:  # whatever it is, it is no refusal of ours
        return {"verdict": FAILED, "reason": f"crash: {error!r}"}, None


def applies(name: str, scene: vc.Scene) -> bool:
    """Whether a family is for such a scene at all."""
    if name in ("joint", "johnson"):
        return scene.bodies.coupled and not scene.frictionless
    if name in THEORIES:
        return not why_not(name, scene)
    if name == "osqp":
        return scene.motion is None or (scene.line and not isinstance(scene.motion, vc.Transient))
    return name != "tang" or scene.motion is not None


def judge(case: Case, name: str, sol: vc.Solution) -> dict:
    """What an answer is worth: numbers, signs, bounds, residual, and the error against the reference."""
    tol, certificate = tolerance(name), sol.certificate
    formula = sol.plan.normal == "hertz" and sol.scene.motion is None
    row = {}
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


def _wrong(sol: vc.Solution, name: str) -> str:
    """What cannot be in any answer, or nothing."""
    floating = sol.scene.line and sol.scene.reference_depth is None
    numbers = [sol.pressure, sol.traction, sol.slip, sol.force, sol.moment, sol.certificate.residual]
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


def _prescribed(sol: vc.Solution) -> str:
    """A tangential force other than the prescribed one."""
    motion = sol.motion
    for i, wanted in enumerate((getattr(motion, "Fx", None), getattr(motion, "Fy", None))):
        carried = float(np.abs(sol.traction).sum() * sol.grid.area)
        if wanted is not None and abs(sol.force[i] - wanted) > 1e-4 * max(abs(wanted), 1e-3 * carried):
            return f"a force {'xy'[i]} of {sol.force[i]:.6g} in place of {wanted:.6g}"
    return ""


def _direction(sol: vc.Solution) -> str:
    """Friction that drives: against a creepage without spin the force does work."""
    motion = sol.motion
    if not isinstance(motion, vc.Steady) or motion.spin != 0 or motion.Fx is not None or sol.scene.bodies.coupled:
        return ""
    against = float(np.dot(sol.force, motion.rigid[:2]))
    return "a force along the creepage" if against > 0 else ""


def agreeing(rows: list[dict], solutions: dict[str, vc.Solution]) -> list[dict]:
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
        cap = MAGNIFIED * max(tolerance(own), tolerance(best))
        if not row["agreement"] <= cap:
            row |= {"verdict": FAILED, "reason": f"{row['agreement']:.2g} from the answer of {best}"}
    return rows
