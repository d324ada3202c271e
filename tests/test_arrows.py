"""Imports run one way: no module reaches for a room that comes after its own, lazy and typing
imports included.
"""

import ast
import functools
import sys
from pathlib import Path

import varcontact
from tests.scenes import make_scene

ROOT = Path(varcontact.__file__).parent

ORDER = (
    {"errors", "checks", "html", "system"},
    {"reference"},
    {"scene"},
    {"elasticity", "transports"},
    {"interfaces"},
    {"discrete"},
    {"solvers"},
    {"theories"},
    {"results", "plotting", "io"},
    {"solving"},
    {"gradients"},
    {"study", "data"},
    {"benchmark"},
    {"plasticity"},
    {"kinematics"},
    {"wheel_rail"},
    {"autodiff", "energy", "cli", "__init__", "__main__"},
)
"""The rooms and the modules beside them, in the order of the data; those of one line may import
each other."""

BACK = {
    # pictures take objects of later rooms, and need their types only
    ("plotting.studies", "study.convergence"),
    ("plotting.studies", "study.tradeoff"),
    ("scene.scene", "io.scene_toml"),  # a scene writes itself to a file
    # a solution has its gradient, whose error takes another solution
    ("results.solution", "gradients.gradient"),
    ("results.solution", "gradients.outputs"),
}
"""Imports against the order that may stay: in a function, or for types only."""

CONVENIENCE = {
    "scene.scene": {"io.scene_toml"},
    "results.solution": {
        "gradients.gradient",
        "io.export",
        "io.solution",
        "plotting.solution",
        "results.frequency",
        "results.physical",
        "results.report",
    },
    "results.frequency": {"plotting.frequency"},
    "results.history": {"io.history", "plotting.history"},
    "plasticity.shakedown_result": {"plasticity.plots"},
    "wheel_rail.geometry_table": {"wheel_rail.plots"},
    "wheel_rail.profile": {"wheel_rail.plots"},
    "wheel_rail.result": {"wheel_rail.gradient", "wheel_rail.plots"},
    "wheel_rail.wear_depth": {"wheel_rail.plots"},
    "wheel_rail.wheel_set_solution": {"wheel_rail.plots"},
}
"""Methods that users expect on an object (`plot`, `save`, `report`, `solve`, `to_...`) call what
comes after it."""
LARGEST_CIRCLE = 6
"""Files that may import each other in a circle, lazy and typing imports included."""
FILES_OF_A_SOLVE = 37
"""Files of the package that the steady solve of a Hertzian contact on its own grid passes
through."""


@functools.cache
def imports(path):
    """Modules of the package that a file imports anywhere in it, and whether at its top level."""
    return list(_imports(path))


def _imports(path):
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
    rooms = {
        path.stem if path.is_file() else path.name
        for path in ROOT.iterdir()
        if path.name != "__pycache__"
    }
    assert rooms - {"py"} == set().union(*ORDER)


def circles():
    """The files that import each other, directly or through others, but for the conveniences."""
    paths = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in ROOT.rglob("*.py")
    }
    reached = {
        own: {other for other, _ in imports(path) if other in paths}
        - CONVENIENCE.get(own, set())
        - {own}
        for own, path in paths.items()
    }
    for middle in paths:  # Warshall's closure
        for own in paths:
            if middle in reached[own]:
                reached[own] |= reached[middle]
    return {
        frozenset(other for other in reached[own] if own in reached[other]) for own in paths
    } - {frozenset()}


def test_no_circle_of_many_files():
    assert max(map(len, circles()), default=0) <= LARGEST_CIRCLE


def test_no_circle_of_wheels():
    """Classes that solve themselves import what solves them, which knows what they are made of."""
    names = {name for circle in circles() for name in circle if name.startswith("wheel_rail.wheel")}
    assert names == set()


def test_conveniences_are_there():
    for own, others in CONVENIENCE.items():
        assert others <= {other for other, _ in imports(ROOT / f"{own.replace('.', '/')}.py")}, own


def test_a_solve_passes_few_files():
    """What a reader has to follow from `solve` to the certified solution."""
    spheres, motion = varcontact.Paraboloids(Rx=0.46, Ry=0.30), varcontact.Steady(vx=1e-3)
    scene = make_scene(spheres, 1e-3, motion, varcontact.Grid(nx=8, ny=8))
    varcontact.solve(scene)  # imports
    entered = set()
    sys.setprofile(
        lambda frame, event, argument: (
            entered.add(frame.f_code.co_filename) if event == "call" else None
        )
    )
    try:
        varcontact.solve(scene)
    finally:
        sys.setprofile(None)
    assert len({name for name in entered if name.startswith(str(ROOT))}) <= FILES_OF_A_SOLVE
