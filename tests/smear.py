"""How far knowledge of a kind is spread, counted: `python -m tests.smear [kind ...]` lists the files
and lines that import, name or test for a class of a kind, or for its attributes.

Rooms where a kind may be named are not counted: scenes, interfaces, media, files and pages. Nor are
attributes of the protocols, which every kind answers (`implicit`, `flows`, `unbounded`, a flow's
`hardening`, a medium's `K`, `even`, `at_end`), and words of another meaning, by file.
"""

import ast
import re
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import varcontact

ROOT = Path(varcontact.__file__).parent
HOME = ("scene", "interfaces", "elasticity", "io")
"""Rooms in which kinds are at home."""
READERS = (
    "cli/json_schema.py",
    "study/contact_runs.py",
    "wheel_rail/case_file.py",
    "wheel_rail/case_tables.py",
    "wheel_rail/contact_input.py",
)
"""Files that read scenes or describe their files, as those of io do."""
KINDS = {
    "third body": r"ThirdBody|third_body|YieldingLayer|YIELD_STRESS|yield_stress|plastic|PLASTIC"
    r"|tau_c0|k_tau|hardens|ShearLayer|plastic_displacement",
    "conformal": r"Conformal\w*|conformal\w*|inclination\w*|is_curved|along_normal|along_axes",
    "law": r"Law|FrictionLaw|\w*_law|under_law|law|laws|kind_of|jumps|continuous|warm"
    r"|memory_distance|weakening|WEAKENING|LAWS|StaticKinetic|\w*Falling",
    "no slip": r"no_slip|NO_SLIP",
    "viscoelastic": r"Viscoelastic\w*|viscoelastic\w*|_viscoelastic|relaxes|relaxations?|lagging"
    r"|Lagging|relaxed|longest_relaxation|memory",
    "heat": r"Heat|FrictionalHeat|Thermal|thermal|temperature\w*|\w*_temperatures?|heat\w*|warm",
}
"""By kind the names of its classes, functions and attributes, in code."""
OTHER_MEANINGS = {
    ("viscoelastic", "results/plan.py"): "memory of the computer",
    ("viscoelastic", "solving/plan_report.py"): "memory of the computer",
    ("viscoelastic", "study/converge.py"): "memory of the computer",
    ("viscoelastic", "study/convergence.py"): "memory of the computer",
    ("viscoelastic", "study/tradeoff.py"): "memory of the computer",
    ("law", "data/make_table_book.py"): "the local law of forces by creepages",
    ("law", "errors.py"): "words of a message that a caller gives",
    ("law", "wheel_rail/datasets.py"): "the law of wear",
    ("conformal", "wheel_rail/regions.py"): "the inclination of a rail's profile",
    ("conformal", "wheel_rail/track.py"): "the inclination of a rail, its cant",
}
"""Files in which a word means something else, and what."""


@cache
def names(path: Path) -> list[tuple[int, str]]:
    """Line and name of all that the code of a file imports, defines or reads."""
    return list(_names(path))


def _names(path: Path) -> Iterator[tuple[int, str]]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Name):
            yield node.lineno, node.id
        elif isinstance(node, ast.Attribute):
            yield node.lineno, node.attr
        elif isinstance(node, ast.alias):
            yield node.lineno, node.name.rsplit(".", 1)[-1]
        elif isinstance(node, ast.arg | ast.keyword) and node.arg:
            yield node.lineno, node.arg
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            if node.value.isidentifier():
                yield node.lineno, node.value
        elif isinstance(node, ast.ImportFrom) and node.module:
            for part in node.module.split("."):
                yield node.lineno, part


def found(kind: str) -> dict[str, list[tuple[int, str]]]:
    """By file beside the homes of kinds, the lines and names that know of a kind."""
    pattern = re.compile(KINDS[kind])
    files: dict[str, list[tuple[int, str]]] = {}
    for path in sorted(ROOT.rglob("*.py")):
        name = str(path.relative_to(ROOT))
        at_home = name.split("/")[0] in HOME or name in READERS
        if at_home or (kind, name) in OTHER_MEANINGS:
            continue
        lines = sorted({each for each in names(path) if pattern.fullmatch(each[1])})
        if lines:
            files[name] = lines
    return files


def counted() -> dict[str, int]:
    """Files by kind."""
    return {kind: len(found(kind)) for kind in KINDS}


def main(kinds: list[str]) -> None:
    """Numbers of files, and of some kinds the names."""
    for kind in kinds:
        for name, lines in found(kind).items():
            told = ", ".join(f"{number} {word}" for number, word in lines)
            print(f"{kind}: {name}: {told}")
    for kind, count in counted().items():
        print(f"{kind}: {count} files")


if __name__ == "__main__":
    main(sys.argv[1:])
