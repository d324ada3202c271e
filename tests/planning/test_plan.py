"""The plan: what it says of a scene, and that elements, matrices and bytes are then what it said."""

import dataclasses
import itertools
import json

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.operators import FEW, GridOperator

UNLIKE = vc.Bodies(G=(2.0, 0.7), nu=(0.25, 0.4))
POINTS = np.linspace(-2.0, 2.0, 41)
SAMPLES = vc.SampledDistance(POINTS[None, :] ** 2 / 2 + POINTS[:, None] ** 2 / 1.6, x=POINTS, y=POINTS)
EXPLICIT = vc.Grid(nx=20, ny=21, dx=0.15, dy=0.15, x0=-1.5, y0=-1.6)
ROUGH = np.where(np.add.outer(np.arange(14), np.arange(14)) % 3 == 0, 0.0, 0.3)
AROUND = vc.Grid(nx=14, ny=14, dx=0.2, dy=0.15, x0=-1.4, y0=-1.05)
LINE = {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=40)}
COUPLED = {"bodies": UNLIKE, "friction": 0.5}

FALLING = vc.RationalFalling(0.3, 0.2, half_velocity=0.1)

HERTZIAN = {
    "steady": ({}, {}),
    "pure vx": ({"motion": vc.Steady(vx=0.05)}, {}),
    "vy and spin": ({"motion": vc.Steady(vy=0.05, spin=0.1)}, {}),
    "odd rows": ({"motion": vc.Steady(vx=0.05), "grid": vc.Grid(nx=12, ny=11)}, {}),
    "Fx given": ({"motion": vc.Steady(Fx=-0.1)}, {}),
    "Fx and Fy given": ({"motion": vc.Steady(Fx=-0.1, Fy=0.05)}, {}),
    "shift": ({"motion": vc.Shift(ux=0.05, rotation=0.02)}, {}),
    "shift along y": ({"motion": vc.Shift(uy=0.05)}, {"formulation": "potential"}),
    "no slip": ({"friction": np.inf}, {}),
    "no slip, pure vx": ({"friction": np.inf, "motion": vc.Steady(vx=0.05)}, {}),
    "frictionless": ({"friction": 0.0}, {}),
    "frictionless, unlike": ({"friction": 0.0, "bodies": UNLIKE}, {}),
    "normal only": ({"motion": None}, {}),
    "normal only, unlike": ({"motion": None, "bodies": UNLIKE}, {}),
    "friction by element": ({"friction": ROUGH, "grid": AROUND}, {}),
    "active sets": ({}, {"tangential": "tang-safeguarded"}),
    "newton, pure vx": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "newton"}),
    "newton, no slip": ({"friction": np.inf}, {"tangential": "newton"}),
    "newton, marching": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "newton", "formulation": "marching"}),
    "marching": ({"motion": vc.Steady(vx=0.05)}, {"formulation": "marching"}),
    "marching by programs": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "clarabel", "formulation": "marching"}),
    "programs": ({}, {"tangential": "clarabel"}),
    "fastsim": ({}, {"tangential": "fastsim"}),
    "law": ({"friction": FALLING}, {}),
    "law, pure vx": ({"friction": FALLING, "motion": vc.Steady(vx=0.05)}, {}),
    "law, fastsim": ({"friction": FALLING}, {"tangential": "fastsim"}),
    "fastsim-weighted": ({}, {"tangential": "fastsim-weighted"}),
    "law, fastsim-weighted-elliptic": ({"friction": FALLING}, {"tangential": "fastsim-weighted-elliptic"}),
    "linear": ({}, {"tangential": "linear"}),
    "line": ({**LINE, "motion": vc.Steady(vx=0.05, vy=0.02)}, {}),
    "line, vx": ({**LINE, "motion": vc.Steady(vx=0.05)}, {}),
    "nu = 0, shift": ({"bodies": vc.Bodies(G=1.0, nu=0.0), "motion": vc.Shift(uy=0.05)}, {}),
    "line, Fx given": ({**LINE, "motion": vc.Shift(Fx=-0.1, Fy=0.1)}, {}),
}
SOLVED_FOR = {
    "sampled": ({"surface": SAMPLES}, {}),
    "sampled on a grid": ({"surface": SAMPLES, "grid": EXPLICIT}, {}),
    "sampled, frictionless": ({"surface": SAMPLES, "grid": EXPLICIT, "friction": 0.0}, {}),
    "a normal program": ({}, {"normal": "clarabel"}),
    "normal active sets": ({}, {"normal": "norm"}),
    "newton": ({}, {"normal": "newton", "tangential": "newton"}),
    "unlike, newton": (COUPLED, {"normal": "newton", "tangential": "newton"}),
    "unlike": (COUPLED, {}),
    "unlike, pure vx": ({**COUPLED, "motion": vc.Steady(vx=0.05)}, {}),
    "unlike, law": ({"bodies": UNLIKE, "friction": FALLING}, {}),
    "unlike, once": (COUPLED, {"coupling": "johnson"}),
    "unlike, shift, joint": ({**COUPLED, "motion": vc.Shift(ux=0.05, uy=0.03)}, {"coupling": "joint"}),
    "unlike, joint by halves": ({**COUPLED, "motion": vc.Shift(ux=0.05)}, {"coupling": "joint"}),
    "unlike, line": ({**LINE, **COUPLED, "motion": vc.Steady(vx=0.05, vy=0.02)}, {}),
}
SCENES = {**HERTZIAN, **SOLVED_FOR}


@pytest.fixture
def assembled(built, monkeypatch):
    """What is assembled from now on: lists of operators by the plan's names, and of dense blocks of them."""
    blocks, assemble = [], GridOperator.dense

    def dense(self, elements, loaded=None):
        matrix = assemble(self, elements, loaded)
        name = next(name for name, of in built if of is self or self in of.__dict__.get("_parts", {}).values())
        blocks.append((name, matrix.shape))
        return matrix

    monkeypatch.setattr(GridOperator, "dense", dense)
    return built, blocks


@pytest.mark.parametrize("name", SCENES)
def test_plan_and_reality_agree(rolling, assembled, name):
    """Choices, elements, every table and every block of the size that was planned, and no other."""
    changes, methods = SCENES[name]
    scene, (operators, blocks) = rolling(**changes), assembled
    sol = vc.solve(scene, **methods)
    assert sol.certificate.force_bound.shape == (3,)  # may be computed only now
    sizes = sol.plan.sizes
    _check_elements(sol)
    of_grid = [(block, operator) for block, operator in operators if operator.shape == sol.grid.shape]
    tables = {matrix.name: matrix for matrix in sizes.matrices if matrix.kind == "table"}
    assert {block for block, _ in of_grid} == set(tables)
    for block, operator in of_grid:
        assert (tables[block].rows, tables[block].columns) == operator.table.shape[2:]
        assert operator.table.nbytes + operator._kernel.nbytes == pytest.approx(tables[block].bytes, rel=0.2)
    planned = {(matrix.name, (matrix.rows, matrix.columns)) for matrix in sizes.matrices if matrix.kind == "dense"}
    factors = [matrix.rows for matrix in sizes.matrices if matrix.kind == "factor"]
    assert planned <= set(blocks)
    products = {(name, shape) for name, operator in operators for shape in _whole(operator)}
    for block, shape in set(blocks) - planned - products:  # NORM's, on the contact that it has in between; looks
        assert block == "A_zz"
        assert shape[0] <= factors[0] or not sol.scene.grid.explicit
    _check_plan(vc.plan(scene, **methods), sol.plan, exact=name in HERTZIAN)


def _whole(operator):
    """Shapes of the matrices of all elements, with which a small grid has its products: too small to be planned."""
    size, (rows, columns) = np.prod(operator.shape), operator.table.shape[:2]
    parts = itertools.product(range(1, rows + 1), range(1, columns + 1))
    return [(i * size, j * size) for i, j in parts] if size <= FEW else []


def _check_elements(sol):
    """Those with pressure and friction enter the tangential problem."""
    sizes, bearing = sol.plan.sizes, 0
    if sol.plan.tangential != "none":
        given = sol.scene.friction
        friction = np.broadcast_to(getattr(given, "static", given), sol.grid.shape)
        bearing = int(np.sum((sol.pressure > 0) & (friction > 0)))
    assert sizes.exact
    assert sizes.elements.get("tangential", 0) == bearing
    assert sizes.elements["normal"] >= sol.elements["contact"]
    assert sizes.grid == sol.grid.shape


def _check_plan(plan, found, exact):
    """A plan made before, beside that of the solution: the same to the last byte, or bounds on it."""
    if exact:
        assert plan == found
        return
    assert dataclasses.replace(plan, sizes=None) == dataclasses.replace(found, sizes=None)
    assert not plan.sizes.exact
    assert "at most" in str(plan)
    assert "at most" not in str(found).replace("factor, at most", "")
    for problem_name, count in found.sizes.elements.items():
        assert count <= plan.sizes.elements[problem_name]
    assert found.sizes.peak <= plan.sizes.peak
    assert plan.sizes.grid == found.sizes.grid


def test_planning_takes_no_influence_numbers_where_closed_forms_tell(rolling, assembled):
    operators, blocks = assembled
    for changes, methods in HERTZIAN.values():
        vc.plan(rolling(**changes), **methods)
    assert not operators
    assert not blocks
    vc.plan(rolling(surface=SAMPLES, grid=EXPLICIT))
    sizes = {operator.table.size for _, operator in operators}
    assert sizes == {1}, "one element's influence on itself, for each method whose cost is told"


def test_what_a_scene_does_not_require_is_not_built(rolling):
    def names(scene, **methods):
        return [(matrix.name, matrix.kind) for matrix in vc.plan(scene, **methods).sizes.matrices]

    assert names(rolling(friction=0.0)) == [("A_zz", "table")], "no tractions: no tangential blocks"
    assert not any("z" in name and "t" in name for name, _ in names(rolling())), "K = 0: none between them"
    assert ("A_zz", "dense") not in names(rolling()), "Hertz: no normal program"
    assert ("A_zz", "dense") in names(rolling(), normal="clarabel"), "unless it is asked for"
    line = vc.plan(rolling(**LINE, motion=vc.Steady(vx=0.05))).sizes
    assert line.grid[0] == 1
    assert {matrix.rows for matrix in line.matrices if matrix.kind == "table"} == {1}
    assert vc.plan(rolling(friction=np.inf)).tangential == "no-slip"
    assert vc.plan(rolling(friction=np.inf)).formulation == "none", "no slip: no cones"


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {},
            {"dimension": "three-dimensional", "bodies": "quasi-identical", "surface": "Hertzian", "motion": "steady"},
        ),
        ({**LINE, "motion": vc.Shift(Fx=-0.1)}, {"dimension": "line contact", "motion": "shift", "special": ()}),
        ({"surface": SAMPLES, "bodies": UNLIKE}, {"bodies": "unlike", "surface": "sampled"}),
        ({"motion": None}, {"motion": "none", "special": ()}),
        ({"friction": np.inf}, {"special": ("no slip",)}),
        ({"friction": 0.0}, {"special": ("frictionless",)}),
        ({"motion": vc.Steady(vx=1.0)}, {"special": ("full slip",)}),
        ({"motion": vc.Steady(vx=0.01)}, {"special": ()}),
        ({**LINE, "motion": vc.Steady(vx=-1.0)}, {"special": ("full slip",)}),
    ],
)
def test_kinds_of_scenes(rolling, changes, expected):
    plan = vc.plan(rolling(**changes))
    assert {name: getattr(plan, name) for name in expected} == expected
    reasons = {"dimension", "bodies", "surface", "motion", "friction"}
    reasons |= {"method", "normal", "tangential", "coupling", "formulation"}
    assert set(plan.reasons) == reasons | set(plan.special)
    assert all(reason and "\n" not in reason for reason in plan.reasons.values())


def test_carters_full_slip_is_told_from_the_creepage_on_where_it_begins(rolling):
    """The closed form, and the solver: at 1.1 times that creepage every element slips, at 0.9 not."""
    hertz = rolling(**LINE, motion=None).hertz
    full = 0.3 * hertz.a / hertz.Rx
    for part, special in ((0.9, ()), (1.1, ("full slip",))):
        scene = rolling(**LINE, motion=vc.Steady(vx=part * full))
        sol = vc.solve(scene)
        assert sol.plan.special == special
        assert (sol.elements["stick"] == 0) == (part > 1)


def test_a_plan_is_json_and_comes_back(rolling, tmp_path):
    for changes, methods in (HERTZIAN["pure vx"], SOLVED_FOR["sampled"]):
        plan = vc.plan(rolling(**changes), **methods)
        record = json.loads(json.dumps(plan.summary(), allow_nan=False))
        assert set(record) == {field.name for field in dataclasses.fields(vc.Plan)}
        assert record["sizes"]["peak"] == plan.sizes.peak
        assert vc.Plan.of_record(record) == plan
        sol = vc.solve(rolling(**changes), **methods)
        sol.save(tmp_path / "solution.nc")
        assert vc.load(tmp_path / "solution.nc").plan == sol.plan


@pytest.mark.parametrize(
    ("changes", "methods", "words"),
    [
        ({}, {"tangential": "clarabell"}, ["tangential", "clarabell", "clarabel"]),
        ({}, {"formulation": "complementary"}, ["formulation", "gap"]),
        ({"surface": SAMPLES}, {"normal": "hertz"}, ["Hertz", "norm", "clarabel"]),
        ({"grid": vc.Grid(nx=4, ny=4, dx=0.1, dy=0.1, x0=5.0, y0=5.0)}, {}, ["grid", "contain"]),
        ({"grid": vc.Grid(nx=8, ny=8, dx=0.1, dy=0.1, x0=-0.4, y0=-0.4)}, {}, ["grid", "extends to"]),
        ({"grid": vc.Grid(nx=4, ny=4, dx=9.0, dy=9.0, x0=-18.0, y0=-18.0)}, {}, ["grid", "too coarse"]),
        ({"surface": SAMPLES, "normal_force": None, "approach": 1e-9, "grid": EXPLICIT}, {}, ["grid", "element"]),
    ],
)
def test_bad_input_is_refused_as_by_solve(rolling, changes, methods, words):
    for act in (vc.plan, vc.solve):
        with pytest.raises(vc.SceneError) as error:
            act(rolling(**changes), **methods)
        assert all(word in str(error.value) for word in words)


def test_no_scene_and_no_memory():
    with pytest.raises(vc.SceneError, match="a Scene"):
        vc.plan("scene.toml")
    scene = vc.Scene(
        bodies=vc.Bodies(G=1.0, nu=0.3),
        surface=vc.Ellipse(a=1.0, b=1.0),
        normal_force=1.0,
        grid=vc.Grid(nx=10**6, ny=10**6),
    )
    with pytest.raises(vc.TooLarge, match="a grid of this size"):
        vc.plan(scene)


def test_what_is_refused_for_memory_is_what_was_planned(rolling, monkeypatch):
    scene = rolling()
    planned = vc.plan(scene).sizes
    monkeypatch.setattr("varcontact.system.memory.LITTLE", 0.0)
    monkeypatch.setattr("varcontact.system.memory.available", lambda: 1e6)
    with pytest.raises(vc.TooLarge) as error:
        vc.solve(scene)
    assert error.value.needed == pytest.approx(planned.memory["tangential"], rel=0.2)


def test_a_history_whose_load_is_given_by_step_is_planned(rolling):
    motion = vc.Transient(steps=2, vx=0.04, normal_force=[1.0, 0.8], friction=[0.3, 0.2])
    plan = vc.plan(rolling(surface=vc.Paraboloids(1.0, 0.8), normal_force=None, friction=None, motion=motion))
    assert (plan.motion, plan.sizes.grid) == ("transient", (14, 14))


@pytest.mark.parametrize("changes", [{}, {"bodies": UNLIKE}, {"grid": AROUND}, {"surface": SAMPLES, "grid": EXPLICIT}])
def test_a_history_is_planned_by_bounds_of_its_steps(rolling, assembled, changes):
    """Tables as listed, A_tt and not A_tt - C_tt; dense blocks no larger than said; every step has the same plan."""
    scene = rolling(**changes, motion=vc.Transient(steps=2, vx=0.04, vy=0.01))
    plan, (operators, blocks) = vc.plan(scene), assembled
    assert (plan.motion, plan.sizes.exact) == ("transient", False)
    history = vc.solve(scene)
    assert history[0].plan == history[1].plan == dataclasses.replace(plan, sizes=None)
    assert plan.sizes.grid == history[0].grid.shape
    of_grid = [(name, operator) for name, operator in operators if operator.shape == plan.sizes.grid]
    listed = [matrix for matrix in plan.sizes.matrices if matrix.kind == "table"]
    taken = sum({name: operator.table.nbytes + operator._kernel.nbytes for name, operator in of_grid}.values())
    assert taken == pytest.approx(sum(matrix.bytes for matrix in listed), rel=0.2)
    largest = max((matrix.rows for matrix in plan.sizes.matrices if matrix.kind == "dense"), default=0)
    assert max((shape[0] for _, shape in blocks), default=0) <= largest
    assert plan.matrix_free or blocks


def test_plan_names_the_loop_of_a_law(rolling):
    """And says why; a theory needs none."""
    plan = vc.plan(rolling(friction=FALLING))
    assert plan.friction == "rational"
    assert "outer loop" in plan.reasons["friction"]
    assert "rational: the coefficient depends on the slip" in str(plan)
    assert "particle by particle" in vc.plan(rolling(friction=FALLING), tangential="fastsim").reasons["friction"]
    assert vc.plan(rolling()).friction == "given"
    assert vc.plan(rolling(motion=None)).friction == "none"
    history = vc.Transient(steps=2, vx=0.05, friction=[0.3, vc.StaticKinetic(0.3, 0.2)])
    assert vc.plan(rolling(motion=history)).friction == "several"


def test_plan_of_a_law_is_that_of_its_first_pass(rolling):
    """Where nothing is left of friction in slip, later passes have fewer elements."""
    scene = rolling(friction=vc.StaticKinetic(0.3, 0.0), motion=vc.Shift(ux=0.05))
    sol = vc.solve(scene)
    assert np.sum(sol.traction_bound > 0) < sol.elements["contact"]
    assert vc.plan(scene) == sol.plan
