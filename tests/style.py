"""How the package reads, counted: `python -m tests.style [room ...]` lists what is to be mended, by
file and line.
"""

import ast
import sys
import tokenize
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import varcontact

ROOT = Path(varcontact.__file__).parent
COLUMNS = 100
COMPLEX, TOO_COMPLEX = 12, 20
PARAMETERS = 7
BRANCHES = (ast.If, ast.For, ast.While, ast.IfExp, ast.ExceptHandler, ast.comprehension)
NO_CODE = {
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
}


def room(path: Path) -> str:
    """The folder of a file in the package, or its own name beside the rooms."""
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


@cache
def tree(path: Path) -> ast.Module:
    """The syntax tree of a file."""
    return ast.parse(path.read_text())


def faults(path: Path) -> Iterator[tuple[int, str, str]]:
    """Line, kind and name of what does not read like a sentence."""
    text = path.read_text()
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > COLUMNS:
            yield number, "long line", f"{len(line)} columns"
    for node in ast.walk(tree(path)):
        if (
            isinstance(node, ast.Assign)
            and isinstance(node.targets[0], ast.Tuple)
            and isinstance(node.value, ast.Tuple)
        ):
            yield node.lineno, "packed assignment", ""
        elif isinstance(node, ast.IfExp):
            inside = list(ast.walk(node))[1:]
            inner = any(isinstance(each, ast.IfExp) for each in inside)
            yield node.lineno, "nested conditional" if inner else "conditional expression", ""
        elif isinstance(node, ast.FunctionDef):
            yield from _of_function(node)


def _of_function(node: ast.FunctionDef) -> Iterator[tuple[int, str, str]]:
    inside = list(ast.walk(node))
    choices = sum(len(each.values) - 1 for each in inside if isinstance(each, ast.BoolOp))
    complexity = 1 + choices + sum(isinstance(each, BRANCHES) for each in inside)
    if complexity > TOO_COMPLEX:
        yield node.lineno, "too complex", f"{node.name}: {complexity}"
    elif complexity > COMPLEX:
        yield node.lineno, "complex", f"{node.name}: {complexity}"
    count = len(node.args.args) + len(node.args.kwonlyargs)
    if count > PARAMETERS:
        yield node.lineno, "many parameters", f"{node.name}: {count}"


def code_columns(path: Path) -> list[int]:
    """Columns of the lines of code, without docstrings and comments."""
    text = path.read_text()
    lines = text.splitlines()
    inside: set[int] = set()
    for node in ast.walk(tree(path)):
        if (
            isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module)
            and ast.get_docstring(node) is not None
        ):
            inside.update(range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1))
    code: set[int] = set()
    with path.open("rb") as file:
        for token in tokenize.tokenize(file.readline):
            if token.type not in NO_CODE and token.type != tokenize.ENCODING:
                code.update(range(token.start[0], token.end[0] + 1))
    return sorted(len(lines[number - 1]) for number in code - inside)


def faults_of_rooms() -> dict[str, Counter[str]]:
    """Numbers of faults by room and kind."""
    found: dict[str, Counter[str]] = {}
    for path in sorted(ROOT.rglob("*.py")):
        own = found.setdefault(room(path), Counter())
        own.update(kind for _, kind, _ in faults(path))
    return found


def counted() -> dict[str, Counter[str]]:
    """Numbers of faults by room and kind, with the lines of code."""
    found = faults_of_rooms()
    for path in ROOT.rglob("*.py"):
        found[room(path)]["code"] += len(code_columns(path))
    return found


def main(rooms: list[str]) -> None:
    """What is to be mended in some rooms, then the numbers of all."""
    for path in sorted(ROOT.rglob("*.py")) if rooms else ():
        if room(path) in rooms:
            for number, kind, name in sorted(faults(path)):
                print(f"{path.relative_to(ROOT.parent)}:{number}: {kind} {name}".rstrip())
    whole: Counter[str] = Counter()
    for name, numbers in counted().items():
        whole += numbers
        if not rooms or name in rooms:
            print(f"{name}: {dict(sorted(numbers.items()))}")
    columns = sorted(length for path in ROOT.rglob("*.py") for length in code_columns(path))
    mean = sum(columns) / len(columns)
    print(f"all: {dict(sorted(whole.items()))}")
    print(f"columns: {mean:.1f} in the mean, {columns[int(0.95 * len(columns))]} at 95 %")


if __name__ == "__main__":
    main(sys.argv[1:])
