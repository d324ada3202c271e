"""Whether the package answers as it did: record the answers of one version, check another against
them.

    python -m tests.equality record FOLDER [--only GROUP ...] [--every N] [--jobs N]
    python -m tests.equality check FOLDER [--only GROUP ...] [--every N] [--jobs N] [--rtol 1e-12]

Arrays are compared bit for bit, or, with ``--rtol``, to that part of the largest value of each
array; states, plans, errors (class and field) and written files always exactly. Records hold for
one machine and one set of libraries.
"""

import argparse
import contextlib
import dataclasses
import io
import math
import multiprocessing
import os
import pickle
import sys
import tempfile
import time
import typing
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

import varcontact as vc
from tests import random_scenes
from tests.fuzz import scenes as fuzz_scenes
from varcontact.solvers.registry import normal_methods, tangential_methods
from varcontact.solving import methods, options
from varcontact.theories.on_grid import THEORIES

EXAMPLES = Path(__file__).parents[1] / "examples"
Record = dict[str, Any]
Cases = Iterator[tuple[str, Callable[[], Any]]]
FIELDS = (
    *(
        "pressure",
        "traction",
        "slip",
        "power_density",
        "distance",
        "state",
        "approach",
        "creepage",
        "converged",
    ),
    *("iterations", "solved_by", "branch", "pressure_on_parts", "weakening"),
)
QUANTITIES = ("normal_force", "force", "moment", "power", "elements", "fully_sliding")
PLAN = (
    "normal",
    "tangential",
    "coupling",
    "formulation",
    "dimension",
    "bodies",
    "surface",
    "motion",
)
TIMES = ("second", "timing", "calls", "cost", "time", "memory", "record")
OPTIONS = [
    *(name for name in options.Options.__annotations__ if name != "methods"),
    "store",
    "progress",
]
CERTIFICATE = ("residual", "gap", "relative_gap", "force_bounds", "max_penetration")


def on_coarse_grid(scene: vc.Scene, nx: int = 14) -> vc.Scene:
    """The scene on few elements."""
    return dataclasses.replace(
        scene, grid=vc.Grid(nx=nx) if scene.line else vc.Grid(nx=nx, ny=nx - 2)
    )


def banks() -> Cases:
    """The standard scenes, and the references, on few elements."""
    for bank in ("standard_bank", "unlike_bank", "references"):
        found = getattr(vc, bank)()
        for name, each in found.items() if isinstance(found, dict) else enumerate(found):
            scene = each if isinstance(each, vc.Scene) else each.scene
            yield f"{bank} {name}", lambda scene=scene: vc.solve(on_coarse_grid(scene))


def kinds() -> Cases:
    """Random scenes of every kind."""
    for kind in random_scenes.KINDS:
        for i, scene in enumerate(random_scenes.scenes(kind, 11, 20)):
            yield f"{kind} {i}", lambda scene=scene, i=i: vc.solve(on_coarse_grid(scene, 9 + i))


def fuzz() -> Cases:
    """Random scenes whose parts, grids and units are of any kind."""
    for i in range(250):
        yield f"scene {i}", lambda i=i: vc.solve(fuzz_scenes.scene(np.random.default_rng([32, i])))


def variants() -> Cases:
    """Some scenes by every method, theory, coupling, formulation, accuracy, edge and scheme."""
    some = {
        kind: random_scenes.scenes(kind, 2, 32)
        for kind in ("steady", "forces", "shift", "unlike", "line", "law")
    }
    for kind, (first, second) in some.items():
        scene, other = on_coarse_grid(first, 12), on_coarse_grid(second, 10)
        for name, choices in {
            "normal": ("auto", *normal_methods()),
            "tangential": ("auto", *tangential_methods(), *THEORIES),
            "coupling": typing.get_args(methods.CouplingName),
            "formulation": typing.get_args(methods.FormulationName),
            "method": typing.get_args(methods.MethodName),
            "certify": typing.get_args(options.CertifyName),
        }.items():
            for choice in choices:
                more = {name: choice}
                yield f"{kind} {more}", lambda scene=scene, more=more: vc.solve(scene, **more)
        for more in (
            {"polish": False, "tol": 1e-5},
            {"tol": 1e-12},
            {"start": "slip"},
            {"normal": "norm", "tangential": "tang", "polish": False},
        ):
            yield f"{kind} {more}", lambda other=other, more=more: vc.solve(other, **more)
        for accuracy in (0.1, 0.01):
            yield f"{kind} accuracy={accuracy}", lambda s=first, a=accuracy: vc.solve(s, accuracy=a)
    for kind in ("history", "unlike history", "line history"):
        (scene,) = random_scenes.scenes(kind, 1, 33)
        yield f"{kind} accuracy=0.1", lambda scene=scene: vc.solve(scene, accuracy=0.1)


def wheel_rail() -> Cases:
    """The positions of the Manchester benchmark, its fast theories, and geometry."""
    from tests.wheel_rail.conditions import TRACK, WHEELSET, benchmark, manchester
    from varcontact import wheel_rail as wr

    for row in manchester():
        where = f"{row['side']} {row['y_ws']:g}"
        yield where, lambda row=row: benchmark(row, dx=0.6, dy=0.6).solve()
    yield (
        "geometry table",
        lambda: wr.geometry_table(
            TRACK, WHEELSET, y=np.linspace(-4, 4, 5), yaw=[-0.01, 0.0, 0.01], vertical_force=1e4
        ),
    )


def studies() -> Cases:
    """Scan, sweep, compare, converge, creep curves, approximate creep forces."""
    scene = on_coarse_grid(random_scenes.scenes("steady", 1, 34)[0], 10)
    unlike = on_coarse_grid(random_scenes.scenes("unlike", 1, 34)[0], 10)
    v = np.linspace(0, 2 * scene.motion.vx, 3)
    for name, each in {"steady": scene, "unlike": unlike}.items():
        yield f"scan {name}", lambda each=each: vc.scan(each, [(vx, 1e-3, 1e-3) for vx in v])
        yield f"creep_curve {name}", lambda each=each: vc.creep_curve(each, ["auto", "strip"], vx=v)
        yield f"converge {name}", lambda each=each: vc.converge(each, [6, 9, 12])
        yield (
            f"stress {name}",
            lambda each=each: vc.stress(vc.solve(each), [[0, 0.1], [0, 0.2], [0.3, 0.5]]),
        )
        yield f"stress_below {name}", lambda each=each: vc.stress_below(vc.solve(each), [0.2])
        yield f"sensitivity {name}", lambda each=each: vc.solve(each).sensitivity()
    yield (
        "compare",
        lambda: vc.compare({"one": scene, "two": unlike}, ["auto", "convex", "kalker", "fastsim"]),
    )
    yield (
        "tradeoff",
        lambda: vc.tradeoff(
            dict(list(vc.references().items())[:2]), methods=["auto", "kalker"], cells=[6]
        ),
    )
    yield (
        "scan to an accuracy",
        lambda: vc.scan(random_scenes.scenes("steady", 1, 34)[0], [(1e-3, 0, 0)], accuracy=0.1),
    )
    for store in (False, True):
        yield f"sweep store={store}", lambda store=store: _swept(scene, store)
    for theory in ("linear", "vermeulen-johnson", "polach", "fastsim", "strip", "fastrip", "table"):
        given = {
            "a": 1.2,
            "b": 1.0,
            "normal_force": 1.0,
            "friction": 0.3,
            "vx": v,
            "spin": 1e-3,
            "G": 1.0,
            "nu": 0.28,
        }
        yield (
            f"creep_forces {theory}",
            lambda theory=theory, given=given: vc.creep_forces(theory, **given),
        )


def _swept(scene: vc.Scene, store: bool) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sweep.nc" if store else None
        swept = vc.sweep(scene, {"friction": [0.2, 0.3], "motion.vy": [0.0, 1e-3]}, store=path)
        return [swept, vc.read_sweep(path)] if path else swept


def files() -> Cases:
    """What is written: bytes of text, tables and grids; variables of solutions and histories, and
    read back.
    """
    solved = random_scenes.scenes("steady", 2, 35) + random_scenes.scenes("line", 1, 35)
    solved += random_scenes.scenes("history", 1, 35)
    for i, scene in enumerate(on_coarse_grid(each, 10) for each in solved):
        for name in ("a.nc", "a.csv", "a.vtu", "a.vti", "a.toml", "a.mat", "a.json", "a.txt"):
            yield f"{i} {name}", lambda scene=scene, name=name: _written(scene, name)


def _written(scene: vc.Scene, name: str) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / name
        if name == "a.toml":
            scene.save(path)
            return [path.read_bytes(), repr(vc.read_scene(path))]
        sol = vc.solve(scene)
        if name == "a.nc":
            sol.save(path)
            return [plain(vc.load(path)), sol.to_xarray()]
        if name == "a.json":
            return {k: v for k, v in sol.summary().items() if k != "timing"}
        if name == "a.txt":
            return [line for line in sol.report().splitlines() if " s" not in line]
        sol.save(path)
        return [(each.name, each.read_bytes()[128:]) for each in sorted(Path(folder).iterdir())]


def command_line() -> Cases:
    """The command line: its exit, and the files and tables that it writes."""
    for arguments in (
        "solve {e}/fig21_spin.toml --out {f}/a.csv",
        "solve {e}/aluminium_on_steel.toml --no-such-option",
        "solve {e}/none.toml",
        "plan {e}/fig21_spin.toml",
        "scan {e}/fig21_spin.toml --vx 0:0.001:3 --out {f}/a.csv",
        "compare {e}/fig21_spin.toml --methods convex,kalker,fastsim --out {f}/a.csv",
        "curve {e}/fig21_spin.toml --vx 0:0.001:3 --out {f}/a.nc",
        "converge {e}/fig21_spin.toml --cells 6,9,12",
        "--help",
    ):
        yield arguments, lambda arguments=arguments: _commanded(arguments)


def _commanded(arguments: str) -> Any:
    from varcontact.__main__ import main

    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        argv = sys.argv
        sys.argv = ["varcontact", *arguments.format(e=EXAMPLES, f=folder).split()]
        try:
            code: object = main()
        except SystemExit as end:
            code = end.code
        finally:
            sys.argv = argv
        texts = [p.read_bytes() for p in sorted(Path(folder).iterdir()) if p.suffix == ".csv"]
        if arguments.startswith("compare"):  # a table with seconds
            texts = []
        return [code, sorted(p.name for p in Path(folder).iterdir()), texts]


def bad_input() -> Cases:
    """What is refused: the class of the error and its field."""
    good = on_coarse_grid(random_scenes.scenes("steady", 1, 36)[0])
    line = on_coarse_grid(random_scenes.scenes("line", 1, 36)[0])
    history = on_coarse_grid(random_scenes.scenes("history", 1, 36)[0], 6)
    choices: list[dict[str, Any]] = [
        {name: value} for name in OPTIONS for value in ("nonsense", -1, math.nan, 3, [], True, 0.5)
    ]
    for kind, scene in {"steady": good, "line": line, "history": history}.items():
        for more in choices:
            if kind == "steady" or "nonsense" in more.values():
                yield f"solve {kind} {more}", lambda scene=scene, more=more: vc.solve(scene, **more)
        for name in (field.name for field in dataclasses.fields(vc.Scene)):
            for value in (None, "nonsense", -1.0, math.nan, [1, 2]):
                yield (
                    f"{kind} {name}={value}",
                    lambda scene=scene, name=name, value=value: vc.solve(
                        dataclasses.replace(scene, **{name: value})
                    ),
                )
    for kind in (
        vc.Bodies,
        vc.Steady,
        vc.Shift,
        vc.Grid,
        vc.Paraboloids,
        vc.Ellipse,
        vc.Cylinders,
        vc.Transient,
    ):
        for name in (field.name for field in dataclasses.fields(kind)):
            for value in (None, "nonsense", -1.0, math.inf, 1e200, [], True):
                yield (
                    f"{kind.__name__} {name}={value}",
                    lambda kind=kind, n=name, v=value: repr(kind(**{n: v})),
                )


GROUPS = {
    each.__name__: each
    for each in (bad_input, banks, kinds, fuzz, wheel_rail, variants, studies, files, command_line)
}


def record_of(call: Callable[[], Any]) -> Record:
    """What came of a call, as plain data."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return plain(call())
    except vc.VarcontactError as error:
        return {"error": type(error).__name__, "field": str(getattr(error, "field", None))}
    except (TypeError, AttributeError, ValueError) as error:  # of a call that is none
        return {"error": type(error).__name__}


def plain(value: Any) -> Any:
    """Arrays, numbers, strings and containers of an answer, without what takes time."""
    if isinstance(value, vc.Solution):
        found = {name: plain(getattr(value, name, None)) for name in FIELDS + QUANTITIES}
        found["plan"] = {name: getattr(value.plan, name) for name in PLAN}
        found["certificate"] = {
            name: plain(getattr(value.certificate, name, None)) for name in CERTIFICATE
        }
        found["calls"] = {p: sorted(by) for p, by in value.calls.items()}
        found["estimate"] = plain(value.error_estimate)
        return found
    if isinstance(value, vc.History):
        return {"steps": [plain(each) for each in value]}
    if hasattr(value, "columns") and hasattr(value, "to_dict"):  # a table
        return {
            str(k): plain(v.to_numpy())
            for k, v in value.items()
            if not any(w in str(k) for w in TIMES)
        }
    if hasattr(value, "variables") and hasattr(value, "attrs"):  # a dataset
        return {
            str(k): plain(v.values)
            for k, v in value.variables.items()
            if not any(w in str(k) for w in TIMES)
        }
    if hasattr(value, "patches") and hasattr(value, "__dataclass_fields__"):
        return {
            "patches": [plain(each) for each in value.patches],
            "force": plain(getattr(value, "force", None)),
        }
    if hasattr(value, "solution") and hasattr(value, "__dataclass_fields__"):
        return plain(value.solution)
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        names = (field.name for field in dataclasses.fields(value))
        return {n: plain(getattr(value, n)) for n in names if not any(w in n for w in TIMES)}
    if isinstance(value, np.ndarray) and value.dtype == object:
        return [plain(each) for each in value.ravel()]
    if isinstance(value, np.ndarray | np.generic):
        return np.asarray(value)
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items() if not any(w in str(k) for w in TIMES)}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, str | bytes | int | float | bool | None):
        return value
    return type(value).__name__


def differences(old: Any, new: Any, rtol: float, at: str = "") -> Iterator[str]:
    """Where two records differ, in words."""
    if isinstance(old, dict) and isinstance(new, dict):
        for key in sorted(old.keys() | new.keys()):
            if key not in old or key not in new:
                yield f"{at}.{key} is {'new' if key in new else 'gone'}"
            else:
                yield from differences(old[key], new[key], rtol, f"{at}.{key}")
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for i, pair in enumerate(zip(old, new, strict=True)):
            yield from differences(*pair, rtol, f"{at}[{i}]")
    elif isinstance(old, np.ndarray | float) and isinstance(new, np.ndarray | float):
        old, new = np.asarray(old), np.asarray(new)
        if old.dtype != new.dtype or old.shape != new.shape:
            yield f"{at}: {old.dtype}{old.shape} is {new.dtype}{new.shape}"
        elif old.tobytes() != new.tobytes():
            if old.dtype.kind not in "fc":
                yield f"{at}: {np.sum(old != new)} of {old.size} differ"
            elif not np.array_equal(np.isfinite(old), np.isfinite(new)):
                yield f"{at}: finite elsewhere"
            else:
                here = np.isfinite(old)
                away = np.abs(old - new)[here].max(initial=0.0) / max(
                    np.abs(old[here]).max(initial=0.0), 1e-300
                )
                if away > rtol:
                    yield f"{at}: differs by {away:.1e} of the largest"
    elif type(old) is not type(new) or old != new:
        yield f"{at}: {str(old)[:60]!r} is {str(new)[:60]!r}"


def _run(case: tuple[str, str]) -> tuple[str, str, Record, float]:
    """One case by its group and name, in a process that keeps the cases of its groups."""
    group, name = case
    if group not in _CASES:
        _CASES[group] = dict(GROUPS[group]())
    began = time.perf_counter()
    return group, name, record_of(_CASES[group][name]), time.perf_counter() - began


_CASES: dict[str, dict[str, Callable[[], Any]]] = {}


def main() -> int:
    """Record, or check; the number of cases that differ is said, and the exit is 1 where there are
    some.
    """
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("action", choices=("record", "check"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", choices=GROUPS, default=list(GROUPS))
    parser.add_argument("--every", type=int, default=1, help="every nth case alone")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--rtol", type=float, default=0.0)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    began, different, count = time.perf_counter(), 0, 0
    wanted = [
        (group, name)
        for group in given.only
        for name in list(dict(GROUPS[group]()))[:: given.every]
    ]
    records: dict[str, dict[str, Record]] = {group: {} for group in given.only}
    old: dict[str, dict[str, Record]] = {}
    if given.action == "check":
        for group in given.only:
            with open(given.folder / f"{group}.pickle", "rb") as file:
                old[group] = pickle.load(file)
    with multiprocessing.Pool(given.jobs) as pool:
        for group, name, record, seconds in pool.imap_unordered(_run, wanted, chunksize=4):
            count += 1
            records[group][name] = record
            if seconds > 5:
                print(f"{group}: {name} took {seconds:.1f} s", flush=True)
            if given.action == "check":
                known = old[group].get(name, record)  # a new case has nothing to differ from
                found = list(differences(known, record, given.rtol))
                different += bool(found)
                if found:
                    print(f"{group}: {name}: {'; '.join(found[:4])}", flush=True)
    if given.action == "record":
        for group, cases in records.items():
            with open(given.folder / f"{group}.pickle", "wb") as file:
                pickle.dump(cases, file)
    errors = sum(
        "error" in each
        for cases in records.values()
        for each in cases.values()
        if isinstance(each, dict)
    )
    print(
        f"{count} cases ({errors} errors), {different} differ, {time.perf_counter() - began:.0f} s"
    )
    return int(different > 0)


if __name__ == "__main__":
    sys.exit(main())
