"""Deliberate breaks of the package, and the tests that have to catch them: ``python -m tests.breaks [NAME ...]``.

Each break is made in a copy of the repository, where its tests run until the first failure. What was found is kept in
tests/data/breaks.json, and makes the table of docs/robustness.md.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "tests" / "data" / "breaks.json"
PAGE = ROOT / "docs" / "robustness.md"
MARKED = re.compile(r"(<!-- breaks -->\n).*(<!-- end of breaks -->)", re.DOTALL)
FAILED = 1
"""What pytest returns where tests fail; any other number but 0 says that they did not run."""


@dataclass(frozen=True)
class Break:
    """What is wrong, the file of the package, its text with what stands there instead, and the tests."""

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]


BREAKS = (
    Break(
        "sign of the displacement along x by a pressure",
        "elasticity/halfspace.py",
        '"xz": lambda: -K * J["J5"]',
        '"xz": lambda: K * J["J5"]',
        ("elasticity/test_halfspace.py",),
    ),
    Break(
        "term of Poisson's ratio in the influence number yy",
        "elasticity/halfspace.py",
        '(1 - nu) * J["J1"] + nu * J["J4"]',
        '(1 - nu) * J["J1"]',
        ("elasticity/test_halfspace.py",),
    ),
    Break(
        "term of the subsurface stress xx by a traction",
        "elasticity/subsurface.py",
        '2 * Q("phi_x") - Q("chi_xxx") - 2 * nu * Q("omega_xyy")',
        '2 * Q("phi_x") - Q("chi_xxx")',
        ("elasticity/test_subsurface.py",),
    ),
    Break(
        "half of a symmetric problem carries the whole force",
        "discrete/problems.py",
        "None if along_x is None else along_x / 2",
        "None if along_x is None else along_x",
        ("discrete/test_mirror.py",),
    ),
    Break(
        "missing normal force is not in the residual",
        "discrete/residuals.py",
        "residual = worst(residual, abs(pressure.sum() * problem.area / problem.force - 1))",
        "residual = worst(residual)",
        ("discrete/test_residuals.py",),
    ),
    Break(
        "force bound without the part of the pressure's error",
        "discrete/certificate.py",
        "force_bound(wider, *wider.of_grid(state.traction, state.rigid)) + part, part",
        "force_bound(wider, *wider.of_grid(state.traction, state.rigid)), part",
        ("discrete/test_force_bounds.py",),
    ),
    Break(
        "gap of a turned traction by its cosine alone",
        "discrete/residuals.py",
        "return np.asarray(slack * length + turned)",
        "return np.asarray(slack * length)",
        ("discrete/test_residuals.py",),
    ),
    Break(
        "forward slip returns to stick never, backward slip always",
        "solvers/active_set/tang.py",
        "~sticks & (np.sum(at.traction * (shift_of(problem, at) + flow), axis=0) > 0)",
        "~sticks & (np.sum(at.traction * (shift_of(problem, at) + flow), axis=0) < 0)",
        ("solvers/active_set/test_tang.py",),
    ),
    Break(
        "NORM stops before overlapping elements come in",
        "solvers/active_set/norm.py",
        "        if not overlaps.any():  # point 7: all signs are right",
        "        if True:  # point 7: all signs are right",
        ("solvers/active_set/test_norm.py",),
    ),
    Break(
        "Newton's equations with the slip turned the other way",
        "solvers/newton/tangential.py",
        "rows: np.ndarray = stick * stuck + turned * across",
        "rows: np.ndarray = stick * stuck - turned * across",
        ("solvers/newton/test_newton.py",),
    ),
    Break(
        "kept set-up of a conic solver for other matrices",
        "solvers/conic/programs.py",
        "same = np.array_equal(before.P.data, program.P.data) and np.array_equal(before.A.data, program.A.data)",
        "same = True",
        ("solvers/conic/test_workspace.py", "solvers/conic/test_solvers.py"),
    ),
    Break(
        "narrow patch without its part of the error bar",
        "solving/adaptive.py",
        "float(value), float(error) / per[name] + floor + missed",
        "float(value), float(error) / per[name] + floor",
        ("solving/adaptive/test_patches.py",),
    ),
    Break(
        "contact under another friction kept for the next scene",
        "solving/warm_start.py",
        'for f in fields(Scene) if f.name != "motion")',
        'for f in fields(Scene) if f.name not in ("motion", "friction"))',
        ("study/test_sweep.py",),
    ),
    Break(
        "history forgets the tractions of the step before",
        "solving/time_step.py",
        "        if before.memory is None and before.plastic is None and not fields.any():",
        "        if before.memory is None and before.plastic is None and fields.any():",
        ("solving/test_transient.py",),
    ),
    Break(
        "no-slip force by spin of the simplified theory",
        "theories/simplified.py",
        "np.pi * a**3 * b / (4 * L)",
        "np.pi * a**3 * b / (8 * L)",
        ("theories/test_simplified.py", "theories/test_fastsim.py"),
    ),
    Break(
        "creepages of another contact origin with the wrong sign",
        "io/contact_input.py",
        'second -= 0.0 if digits["F"] == 2 else spin * centre[0]',
        'second += 0.0 if digits["F"] == 2 else spin * centre[0]',
        ("io/test_contact_input.py",),
    ),
    Break(
        "friction force in CONTACT's file without the normal force",
        "io/contact_input.py",
        'case.friction.static * case.load.get("normal_force", 0.0)',
        "case.friction.static",
        ("io/test_contact_input.py",),
    ),
    Break(
        "resumed sweep takes a chunk for finished by one of its rows",
        "study/sweep.py",
        "if not done[k : k + chunk].all()",
        "if not done[k : k + chunk].any()",
        ("study/test_sweep.py", "study/test_killed.py"),
    ),
    Break(
        "scene that does not converge counts as solved",
        "study/methods.py",
        'return "not converged"',
        'return "solved"',
        ("study/test_sweep.py",),
    ),
    Break(
        "left wheel with the profile of the right one",
        "wheel_rail/track.py",
        'raise SceneError("wheelset.wheel", self.wheel, "a round wheel")\n'
        '        return self._right if side == "right" else self._right.mirrored',
        'raise SceneError("wheelset.wheel", self.wheel, "a round wheel")\n        return self._right',
        ("wheel_rail/test_search.py", "wheel_rail/test_wheel_on_rail.py"),
    ),
    Break(
        "unit of an error of a shift",
        "results/quantities_of_interest.py",
        "3 * (2 - nu) * limit / (8 * G * math.sqrt(a * b))",
        "3 * (1 - nu) * limit / (8 * G * math.sqrt(a * b))",
        ("results/test_quantities_of_interest.py",),
    ),
    Break(
        "work by friction per distance taken for that of the step",
        "results/history.py",
        'return self._series("friction_work") * np.where(dq > 0, dq, 1.0)',
        'return self._series("friction_work")',
        ("results/test_friction_work.py", "results/test_history.py"),
    ),
    Break(
        "failure of a scan swallowed by the command line",
        "cli/scan.py",
        "            _deliver(found, out, plot, as_json)\n        raise",
        "            _deliver(found, out, plot, as_json)\n            return\n        raise",
        ("test_cli_scan.py", "test_cli_interrupted.py"),
    ),
    Break(
        "range of the command line without its last value",
        "cli/options.py",
        "np.linspace(first, last, int(number))",
        "np.linspace(first, last, int(number), endpoint=False)",
        ("test_cli_scan.py", "test_cli.py"),
    ),
)


def broken(each: Break, tree: Path) -> None:
    """Make a break in a copy; the old text has to occur once."""
    path = tree / "varcontact" / each.file
    text = path.read_text()
    assert text.count(each.old) == 1, each.name
    path.write_text(text.replace(each.old, each.new))


def caught_by(each: Break) -> str:
    """The first test that fails with a break; empty where none does."""
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "tree"
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(".git", "__pycache__", "made", "_build"))
        broken(each, tree)
        call = [sys.executable, "-m", "pytest", "-x", "-rfE", "-n", "0", "-p", "no:cacheprovider", "-m", "not long"]
        environment = {**os.environ, "PYTHONPATH": str(tree), "MPLBACKEND": "Agg"}
        tests = [f"tests/{test}" for test in each.tests]
        ended = subprocess.run([*call, *tests], cwd=tree, env=environment, capture_output=True, text=True)
    if ended.returncode not in (0, FAILED):
        raise RuntimeError(f"{each.name}: the tests did not run\n{ended.stdout[-2000:]}")
    if ended.returncode == 0:
        return ""
    first = re.search(r"^(?:FAILED|ERROR) tests/([^\s\[]+)", ended.stdout, re.MULTILINE)
    return first.group(1) if first else "?"


def table(found: list[dict[str, str]]) -> str:
    """The table of the page."""
    rows = [f"| {row['break']} | `{row['file']}` | {row['caught by'] or 'not caught'} |" for row in found]
    return "\n".join(["| break | file | first test that fails |", "|---|---|---|", *rows])


def main(names: list[str]) -> int:
    """Try the breaks whose names hold one of the words, or all, and keep the results."""
    known = json.loads(RESULTS.read_text())["breaks"] if RESULTS.exists() else []
    rows = {row["break"]: row for row in known}
    for each in BREAKS:
        if not names or any(word in each.name for word in names):
            test = caught_by(each)
            rows[each.name] = {"break": each.name, "file": each.file, "caught by": test}
            print(f"{'caught' if test else 'NOT CAUGHT':10}  {each.name}: {test}", flush=True)
    found = [rows[each.name] for each in BREAKS if each.name in rows]
    RESULTS.write_text(json.dumps({"date": date.today().isoformat(), "breaks": found}, indent=1) + "\n")
    PAGE.write_text(MARKED.sub(lambda marks: f"{marks[1]}{table(found)}\n{marks[2]}", PAGE.read_text()))
    return sum(not row["caught by"] for row in found)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
