"""Imports run one way: no module reaches for a room that comes after its own, lazy and typing imports included."""

import ast
from pathlib import Path

import varcontact

ROOT = Path(varcontact.__file__).parent

ORDER = (
    {"errors", "checks", "html", "system"},
    {"reference"},
    {"scene"},
    {"elasticity"},
    {"discrete"},
    {"solvers"},
    {"theories"},
    {"results", "plotting", "io"},
    {"solving"},
    {"study", "data"},
    {"kinematics"},
    {"wheel_rail"},
    {"energy", "cli", "__init__", "__main__"},
)
"""The rooms and the modules beside them, in the order of the data; those of one line may import each other."""

BACK = {
    # pictures take objects of later rooms, and need their types only
    ("plotting.studies", "study.convergence"),
    ("plotting.studies", "study.tradeoff"),
    ("scene.scene", "io.scene_toml"),  # a scene writes itself to a file
}
"""Imports against the order that may stay: in a function, or for types only."""


def imports(path):
    """Modules of the package that a file imports anywhere in it, and whether at its top level."""
    tree = ast.parse(path.read_text())
    top = {id(node) for node in tree.body}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are absolute"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        for name in names:
            first, *rest = name.split(".")
            if first == "varcontact" and rest:
                yield module(rest), id(node) in top


def module(parts):
    """The module of a dotted name whose last part may be something in it."""
    if (ROOT / Path(*parts)).with_suffix(".py").exists() or (ROOT / Path(*parts)).is_dir():
        return ".".join(parts)
    return ".".join(parts[:-1]) or "__init__"


def level(name):
    """Where a module stands in the order."""
    room = name.split(".")[0]
    return next(i for i, rooms in enumerate(ORDER) if room in rooms)


def backward():
    """All imports against the order, and whether each is at the top level of its file."""
    found = {}
    for path in ROOT.rglob("*.py"):
        own = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for other, top in imports(path):
            if level(other) > level(own):
                found[own, other] = found.get((own, other), False) or top
    return found


def test_imports_run_one_way():
    found = backward()
    assert set(found) - BACK == set(), "imports against the order"
    assert BACK - set(found) == set(), "listed, but no longer there: take it off the list"


def test_what_may_stay_is_lazy_or_for_types():
    assert not any(top for pair, top in backward().items() if pair in BACK)


def test_every_room_has_its_place():
    rooms = {path.stem if path.is_file() else path.name for path in ROOT.iterdir() if path.name != "__pycache__"}
    assert rooms - {"py"} == set().union(*ORDER)
