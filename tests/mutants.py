"""Random mutants of the package, and the tests that catch them.

    python -m tests.mutants --rooms discrete,solvers,elasticity --count 60 [--seed 0] [--jobs 2]
    python -m tests.mutants --rooms discrete --survivors

A mutant is the package with one wrong token: ``<`` for ``<=``, ``+`` for ``-``, ``and`` for ``or``,
``min`` for ``max``, a constant plus one, a minus or a ``not`` left out. Seed, rooms and count choose
the mutants. Each is written into a temporary copy of the repository, never into this one. There
tests run until the first failure: the quick ones that bear its module's name or import it, which
take seconds; then the quick ones of its room; then the slow ones that import it, and all tests of
the rooms in ``SEEN_BY`` (``--quick`` leaves these two out). A run that needs much more processor
time than without the mutant counts as caught. Run it on a quiet machine: on a busy one tests of
time budgets fail without reason, and what they fail with counts as caught.

How to read the list: ``caught`` names the first test that fails. ``SURVIVED`` shows the line before
and after: no test asserts what this line does. Write one, and try again with ``--survivors``. If the
line is superfluous (any value gives the same answers), simplify it. If the mutant is equivalent (a
strict bound that rounding decides, a choice that only costs time), say why in its record in
tests/data/mutants.json: ``"equivalent": "reason"``; it is not tried again.

Results are kept in that file after each mutant. The same command continues where it was interrupted.
"""

import argparse
import ast
import json
import os
import queue
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from functools import partial
from importlib.util import cache_from_source
from pathlib import Path
from threading import Lock

ROOT = Path(__file__).parents[1]
RESULTS = ROOT / "tests" / "data" / "mutants.json"

SEEN_BY = {
    "scene": "scene discrete solving io",
    "elasticity": "elasticity discrete solving results",
    "interfaces": "interfaces solving",
    "discrete": "discrete solvers solving",
    "solvers": "solvers solving study",
    "theories": "theories study",
    "results": "results solving",
    "solving": "solving study",
    "kinematics": "test_kinematics.py wheel_rail",
    "cli": "test_cli*.py",
}
"""Folders and files of tests that see a room, its own first; other rooms: only the folder of their name."""

SWAPS = {
    ast.Lt: ("<", "<="),
    ast.LtE: ("<=", "<"),
    ast.Gt: (">", ">="),
    ast.GtE: (">=", ">"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.And: ("and", "or"),
    ast.Or: ("or", "and"),
}
EXTREMA = {"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum"}
QUICK = "not slow"
SLOW = "slow"
NO_TESTS = 5
"""Exit status of pytest where a module has no tests."""
TIME_LIMIT = "time limit"
IDENTITY = ("file", "function", "before", "after")
"""What a mutant is known by when lines move."""
TEXTS = (ast.Raise, ast.JoinedStr, ast.arg, ast.AnnAssign)
"""Messages and annotations are not mutated, nor defaults of fields."""


@dataclass(frozen=True)
class Mutant:
    """A file of the package, with the bytes from `start` to `end` replaced by `new`."""

    file: str
    function: str
    line: int
    before: str
    after: str
    start: int
    end: int
    new: bytes

    @property
    def room(self) -> str:
        return Path(self.file).parts[1]

    def written(self, source: bytes) -> bytes:
        return source[: self.start] + self.new + source[self.end :]


def nodes(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a tree without those that only make texts."""
    yield node
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, TEXTS):
            yield from nodes(child)


def operations(node: ast.AST) -> Iterator[tuple[ast.expr, ast.AST, ast.expr]]:
    """Operand, operator, operand of a node, from left to right."""
    if isinstance(node, ast.BinOp):
        yield node.left, node.op, node.right
    elif isinstance(node, ast.AugAssign):
        yield node.target, node.op, node.value
    elif isinstance(node, ast.BoolOp):
        for left, right in zip(node.values, node.values[1:], strict=False):
            yield left, node.op, right
    elif isinstance(node, ast.Compare):
        operands = [node.left, *node.comparators]
        yield from zip(operands, node.ops, operands[1:], strict=False)


def is_number(node: ast.AST) -> bool:
    """Whether a node is a constant of arithmetic that is not zero."""
    return isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.value != 0


def edits(source: bytes, module: ast.Module) -> Iterator[tuple[int, int, str]]:
    """Start and end of each token that can be wrong, in bytes, and the wrong token."""
    lines = source.splitlines(keepends=True)
    begins = [sum(map(len, lines[:n])) for n in range(len(lines))]

    def start(node: ast.AST) -> int:
        return begins[node.lineno - 1] + node.col_offset

    def end(node: ast.AST) -> int:
        return begins[node.end_lineno - 1] + node.end_col_offset

    for node in nodes(module):
        for left, operator, right in operations(node):
            if type(operator) in SWAPS:
                old, new = SWAPS[type(operator)]
                at = source.index(old.encode(), end(left), start(right))
                yield at, at + len(old), new
            if isinstance(node, ast.BinOp | ast.AugAssign):
                for each in filter(is_number, (left, right)):
                    yield start(each), end(each), repr(each.value + 1)
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            yield start(node), start(node) + 1, ""
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            yield start(node), start(node) + len("not "), ""
        if isinstance(node, ast.Call):
            name = ast.unparse(node.func).split(".")[-1]
            if name in EXTREMA:
                yield end(node.func) - len(name), end(node.func), EXTREMA[name]


def functions_of(module: ast.Module) -> list[tuple[int, int, str]]:
    """First line, last line, name of functions and classes, the outer ones first."""
    named = (ast.FunctionDef, ast.ClassDef)
    found = [node for node in ast.walk(module) if isinstance(node, named)]
    return [(node.lineno, node.end_lineno, node.name) for node in found]


def mutants_of(root: Path, file: str) -> list[Mutant]:
    """All mutants of a file, in the order of its lines; of those that read alike the first."""
    source = (root / file).read_bytes()
    module = ast.parse(source)
    functions = functions_of(module)
    lines = source.decode().splitlines()
    found: dict[tuple[str, ...], Mutant] = {}
    for start, end, new in sorted(edits(source, module)):
        number = source.count(b"\n", 0, start)
        around = [name for first, last, name in functions if first <= number + 1 <= last]
        function = around[-1] if around else ""
        before = lines[number].strip()
        changed = source[:start] + new.encode() + source[end:]
        after = changed.decode().splitlines()[number].strip()
        mutant = Mutant(file, function, number + 1, before, after, start, end, new.encode())
        found.setdefault((function, before, after), mutant)
    return list(found.values())


def mutants_of_rooms(root: Path, rooms: list[str]) -> list[Mutant]:
    folders = [root / "varcontact" / room for room in rooms]
    files = [file for folder in folders for file in sorted(folder.rglob("*.py"))]
    return [mutant for file in files for mutant in mutants_of(root, str(file.relative_to(root)))]


def copy_of(root: Path, folder: Path) -> Path:
    """A copy of a repository without history and what is built."""
    tree = folder / "tree"
    ignored = shutil.ignore_patterns(".git", ".venv", ".*_cache", "__pycache__", "made", "_build")
    shutil.copytree(root, tree, ignore=ignored)
    return tree


def found_tests(name: str) -> list[str]:
    return sorted(str(test.relative_to(ROOT)) for test in (ROOT / "tests").glob(name))


def nearest(file: str, marks: str) -> list[str]:
    """Tests of a module: its examples, the file of its name, and those that import it or, where
    none do, a module that imports it.
    """
    tests = tests_of(file)
    if not tests:
        users = importing(file, "varcontact", "*.py")
        tests = sorted({test for user in users for test in tests_of(user)})
    return [file, *tests, "-m", marks]


def tests_of(file: str) -> list[str]:
    """The file of tests of a module's name, and those that import the module."""
    inside = Path(file).relative_to("varcontact")
    own = str(Path("tests") / inside.parent / f"test_{inside.name}")
    others = [test for test in importing(file, "tests", "test_*.py") if test != own]
    return [own, *others] if (ROOT / own).exists() else others


def importing(file: str, folder: str, pattern: str) -> list[str]:
    """Files in a folder that import a module."""
    module = re.escape(".".join(Path(file).with_suffix("").parts))
    line = re.compile(rf"^\s*(?:from|import) {module} ", re.MULTILINE)
    paths = sorted((ROOT / folder).rglob(pattern))
    return [str(path.relative_to(ROOT)) for path in paths if line.search(path.read_text())]


def quick(room: str) -> list[str]:
    """Quick tests of the folder of a room."""
    own = SEEN_BY.get(room, room).split()[0]
    return [*found_tests(own), "-m", QUICK]


def thorough(room: str) -> list[str]:
    """All tests that see a room."""
    names = SEEN_BY.get(room, room).split()
    return [*(test for name in names for test in found_tests(name)), "-m", "not long"]


def failure(tree: Path, tests: list[str], seconds: int = 7200) -> str:
    """The first of the tests that fails in a tree, or "time limit"; empty if all pass."""
    call = [sys.executable, "-m", "pytest", "-x", "-rfE", "-n", "0", "-p", "no:cacheprovider"]
    variables = {"PYTHONPATH": str(tree), "MPLBACKEND": "Agg", "OMP_NUM_THREADS": "1"}
    limited = partial(resource.setrlimit, resource.RLIMIT_CPU, (seconds, seconds + 5))
    try:
        ended = subprocess.run(
            [*call, *tests],
            cwd=tree,
            env=os.environ | variables,
            preexec_fn=limited,
            timeout=30 * seconds,  # for what waits for ever, however busy the machine is
            capture_output=True,
            text=True,
        )
    except subprocess.TimeoutExpired:
        return TIME_LIMIT
    if ended.returncode in (0, NO_TESTS):
        return ""
    if ended.returncode < 0:
        return TIME_LIMIT
    first = re.search(r"^(?:FAILED|ERROR) (\S+)", ended.stdout, re.MULTILINE)
    return first.group(1) if first else f"pytest ends with {ended.returncode}"


class Limits:
    """Processor seconds that a mutant may take for a selection of tests, which pass without it."""

    def __init__(self, tree: Path) -> None:
        self.tree = tree
        self.known: dict[tuple[str, ...], int] = {}
        self.one_at_a_time = Lock()

    def of(self, tests: list[str]) -> int:
        with self.one_at_a_time:
            if tuple(tests) not in self.known:
                self.known[tuple(tests)] = self.measured(tests)
            return self.known[tuple(tests)]

    def measured(self, tests: list[str]) -> int:
        begun = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        if failed := failure(self.tree, tests):
            raise RuntimeError(f"fails without a mutant: {failed}")
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - begun
        print(f"{used:.0f} s without a mutant: pytest {' '.join(tests)}", flush=True)
        return 60 + 3 * int(used)


def caught_by(mutant: Mutant, tree: Path, selections: list[list[str]], limits: Limits) -> str:
    """The first test that fails with a mutant in a tree; empty where it survives."""
    for tests in selections:
        if failed := _caught_by(mutant, tree, tests, limits.of(tests)):
            return failed
    return ""


def _caught_by(mutant: Mutant, tree: Path, tests: list[str], seconds: int) -> str:
    path = tree / mutant.file
    source = path.read_bytes()
    compiled = Path(cache_from_source(str(path)))
    compiled.unlink(missing_ok=True)
    path.write_bytes(mutant.written(source))
    try:
        return failure(tree, tests, seconds)
    finally:
        path.write_bytes(source)
        compiled.unlink(missing_ok=True)


class Ledger:
    """What is known of mutants, in a file that is written after each."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.records = json.loads(path.read_text()) if path.exists() else []

    def of(self, mutant: Mutant) -> dict | None:
        for record in self.records:
            if all(record[name] == getattr(mutant, name) for name in IDENTITY):
                return record
        return None

    def keep(self, mutant: Mutant, caught: str) -> None:
        found = {"line": mutant.line, "caught by": caught}
        if known := self.of(mutant):
            known |= found
        else:
            self.records.append({name: getattr(mutant, name) for name in IDENTITY} | found)
        self.records.sort(key=lambda record: (record["file"], record["line"]))
        self.path.write_text(json.dumps(self.records, indent=1) + "\n")


def verdict(record: dict) -> str:
    if record["caught by"]:
        return "caught"
    return "equivalent" if record.get("equivalent") else "SURVIVED"


def shown(mutant: Mutant, record: dict) -> str:
    """A line of the list; for survivors with the lines of code before and after."""
    said = verdict(record)
    why = record["caught by"] or record.get("equivalent", "")
    lines = f"\n    - {mutant.before}\n    + {mutant.after}" if said == "SURVIVED" else ""
    return f"{said:10}  {mutant.file}:{mutant.line}  {why}{lines}"


def chosen(given: argparse.Namespace, ledger: Ledger) -> list[Mutant]:
    """Mutants that were asked for: random ones, or those that survived."""
    rooms = given.rooms.split(",")
    for room in rooms:
        if not (ROOT / "varcontact" / room).is_dir():
            sys.exit(f"--rooms: varcontact has no package {room!r}")
    found = mutants_of_rooms(ROOT, rooms)
    if not given.survivors:
        return random.Random(given.seed).sample(found, min(given.count, len(found)))
    known = [(mutant, ledger.of(mutant)) for mutant in found]
    return [mutant for mutant, record in known if record and verdict(record) == "SURVIVED"]


def campaign(given: argparse.Namespace) -> int:
    """Try mutants, and return how many survived."""
    ledger = Ledger(given.results)
    mutants = chosen(given, ledger)
    left = [each for each in mutants if given.survivors or not ledger.of(each)]
    trees: queue.Queue[Path] = queue.Queue()

    def attempt(mutant: Mutant) -> str:
        tree = trees.get()
        selections = [nearest(mutant.file, QUICK), quick(mutant.room)]
        if not given.quick:
            selections += [nearest(mutant.file, SLOW), thorough(mutant.room)]
        try:
            return caught_by(mutant, tree, selections, limits)
        finally:
            trees.put(tree)

    with tempfile.TemporaryDirectory() as folder:
        for n in range(given.jobs):
            trees.put(copy_of(ROOT, Path(folder, str(n))))
        limits = Limits(copy_of(ROOT, Path(folder, "without")))
        pool = ThreadPoolExecutor(given.jobs)
        try:
            futures = {pool.submit(attempt, mutant): mutant for mutant in left}
            for number, future in enumerate(as_completed(futures), 1):
                mutant = futures[future]
                ledger.keep(mutant, future.result())
                print(f"[{number}/{len(left)}] {shown(mutant, ledger.of(mutant))}", flush=True)
        finally:
            pool.shutdown(cancel_futures=True)
    return summary(mutants, ledger)


def summary(mutants: list[Mutant], ledger: Ledger) -> int:
    """Print the survivors, and counts of each room; return how many survived."""
    counts: dict[str, Counter[str]] = {}
    print("\nsurvivors")
    for mutant in mutants:
        record = ledger.of(mutant)
        said = verdict(record)
        counts.setdefault(mutant.room, Counter())[said] += 1
        if said == "SURVIVED":
            print(shown(mutant, record))
    print("\nroom          mutants  caught  equivalent  survived")
    for room, count in sorted(counts.items()):
        numbers = [count.total(), count["caught"], count["equivalent"], count["SURVIVED"]]
        print("{:12}  {:7}  {:6}  {:10}  {:8}".format(room, *numbers))
    return sum(count["SURVIVED"] for count in counts.values())


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants")
    parser.add_argument("--rooms", required=True, help="packages, with commas between")
    parser.add_argument("--count", type=int, default=60, help="number of mutants (default 60)")
    parser.add_argument("--seed", type=int, default=0, help="of the random choice (default 0)")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default 1)")
    parser.add_argument("--quick", action="store_true", help="only the quick tests of the room")
    parser.add_argument("--survivors", action="store_true", help="those that survived, again")
    parser.add_argument("--results", type=Path, default=RESULTS, help="JSON file of the results")
    try:
        return min(campaign(parser.parse_args(arguments)), 1)
    except KeyboardInterrupt:
        print("\ninterrupted: the same command continues")
        return 130


if __name__ == "__main__":
    sys.exit(main())
