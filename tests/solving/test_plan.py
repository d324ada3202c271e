"""The plan: what it says of a scene, and what its estimates are worth."""

import dataclasses
import json

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refused

UNLIKE = vc.Bodies(G=(2.0, 0.7), nu=(0.25, 0.4))
POINTS = np.linspace(-2.0, 2.0, 41)
SAMPLES = vc.SampledDistance(
    POINTS[None, :] ** 2 / 2 + POINTS[:, None] ** 2 / 1.6, x=POINTS, y=POINTS
)
EXPLICIT = vc.Grid(nx=20, ny=21, dx=0.15, dy=0.15, x0=-1.5, y0=-1.6)
ROUGH = np.where(np.add.outer(np.arange(14), np.arange(14)) % 3 == 0, 0.0, 0.3)
AROUND = vc.Grid(nx=14, ny=14, dx=0.2, dy=0.15, x0=-1.4, y0=-1.05)
LINE = {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=40)}
COUPLED = {"bodies": UNLIKE, "friction": 0.5}

FALLING = vc.RationalFalling(0.3, 0.2, half_velocity=0.1)

CLOSED_FORM = {
    "steady": ({}, {}),
    "pure vx": ({"motion": vc.Steady(vx=0.05)}, {}),
    "Fx and Fy given": ({"motion": vc.Steady(Fx=-0.1, Fy=0.05)}, {}),
    "shift along y": ({"motion": vc.Shift(uy=0.05)}, {"formulation": "potential"}),
    "no slip": ({"friction": np.inf}, {}),
    "frictionless, unlike": ({"friction": 0.0, "bodies": UNLIKE}, {}),
    "normal only": ({"motion": None}, {}),
    "friction by element": ({"friction": ROUGH, "grid": AROUND}, {}),
    "marching by programs": (
        {"motion": vc.Steady(vx=0.05)},
        {"tangential": "clarabel", "formulation": "marching"},
    ),
    "law": ({"friction": FALLING}, {}),
    "law, fastsim": ({"friction": FALLING}, {"tangential": "fastsim"}),
    "linear": ({}, {"tangential": "linear"}),
    "line": ({**LINE, "motion": vc.Steady(vx=0.05, vy=0.02)}, {}),
    "line, Fx given": ({**LINE, "motion": vc.Shift(Fx=-0.1, Fy=0.1)}, {}),
}
SOLVED_FOR = {
    "sampled": ({"surface": SAMPLES}, {}),
    "sampled on a grid": ({"surface": SAMPLES, "grid": EXPLICIT}, {}),
    "a normal program": ({}, {"normal": "clarabel"}),
    "newton": ({}, {"normal": "newton", "tangential": "newton"}),
    "unlike": (COUPLED, {}),
    "unlike, law": ({"bodies": UNLIKE, "friction": FALLING}, {}),
    "unlike, once": (COUPLED, {"coupling": "johnson"}),
    "unlike, shift, joint": (
        {**COUPLED, "motion": vc.Shift(ux=0.05, uy=0.03)},
        {"coupling": "joint"},
    ),
    "unlike, line": ({**LINE, **COUPLED, "motion": vc.Steady(vx=0.05, vy=0.02)}, {}),
}
SCENES = {**CLOSED_FORM, **SOLVED_FOR}


def choices(plan):
    """What a plan says of a scene and its methods, without reasons and estimates."""
    return dataclasses.replace(plan, reasons={}, sizes=None, special=())


@pytest.mark.parametrize("name", SCENES)
def test_plan_and_reality_agree(rolling, name):
    changes, methods = SCENES[name]
    scene = rolling(**changes)
    plan, sol = vc.plan(scene, **methods), vc.solve(scene, **methods)
    sizes = plan.sizes
    assert choices(plan) == choices(sol.plan)
    assert sizes.exact == (name in CLOSED_FORM)
    static = getattr(scene.friction, "static", scene.friction)
    friction = np.broadcast_to(static if sol.plan.tangential != "none" else 0.0, sol.grid.shape)
    found = {
        "normal": sol.elements["contact"],
        "tangential": int(np.sum((sol.pressure > 0) & (friction > 0))),
    }
    for problem, elements in sizes.elements.items():
        assert elements == found[problem] if sizes.exact else elements >= found[problem]
    if sizes.exact:
        assert sizes.grid == sol.grid.shape
    assert ("at most" in str(plan)) == (not sizes.exact)


def test_tables_are_those_that_are_built(rolling, built):
    for changes in (
        {},
        {"motion": vc.Shift(ux=0.05)},
        {"motion": None},
        {"friction": 0.0},
        COUPLED,
    ):
        scene = rolling(**changes)
        planned = {
            matrix.name: matrix
            for matrix in vc.plan(scene).sizes.matrices
            if matrix.kind == "table"
        }
        built.clear()
        sol = vc.solve(scene)
        tables = {name: operator for name, operator in built if operator.shape == sol.grid.shape}
        assert set(tables) == set(planned)
        for name, operator in tables.items():
            assert (
                operator.table.shape[2:] == (planned[name].rows, planned[name].columns)
                or scene.bodies.K != 0
            )
            taken = 2 * operator.table.nbytes  # with its transform
            assert 0.5 * taken < planned[name].bytes < 2 * taken or scene.bodies.K != 0


def test_planning_takes_no_influence_numbers(rolling, built):
    for changes, methods in SCENES.values():
        vc.plan(rolling(**changes), **methods)
    assert not built


def test_what_a_scene_does_not_require_is_not_built(rolling):
    def names(scene, **methods):
        return [(matrix.name, matrix.kind) for matrix in vc.plan(scene, **methods).sizes.matrices]

    assert names(rolling(friction=0.0)) == [("A_zz", "table")], "no tractions: no tangential blocks"
    assert not any("z" in name and "t" in name for name, _ in names(rolling())), (
        "K = 0: none between them"
    )
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
            {
                "dimension": "three-dimensional",
                "bodies": "quasi-identical",
                "surface": "Hertzian",
                "motion": "steady",
            },
        ),
        (
            {**LINE, "motion": vc.Shift(Fx=-0.1)},
            {"dimension": "line contact", "motion": "shift", "special": ()},
        ),
        ({"surface": SAMPLES, "bodies": UNLIKE}, {"bodies": "unlike", "surface": "sampled"}),
        ({"motion": None}, {"motion": "none", "special": ()}),
        ({"friction": np.inf}, {"special": ("no slip",)}),
        ({"friction": 0.0}, {"special": ("frictionless",)}),
    ],
)
def test_kinds_of_scenes(rolling, changes, expected):
    plan = vc.plan(rolling(**changes))
    assert {name: getattr(plan, name) for name in expected} == expected
    methods = {"bodies", "method", "normal", "tangential", "coupling", "formulation"}
    assert set(plan.reasons) == methods | set(plan.special)
    assert all(reason and "\n" not in reason for reason in plan.reasons.values())


def test_a_plan_is_json_and_comes_back(rolling):
    for changes, methods in (CLOSED_FORM["pure vx"], SOLVED_FOR["sampled"]):
        plan = vc.plan(rolling(**changes), **methods)
        record = json.loads(json.dumps(plan.summary(), allow_nan=False))
        assert set(record) | {"grid"} == {field.name for field in dataclasses.fields(vc.Plan)}
        assert record["sizes"]["peak"] == plan.sizes.peak
        assert vc.Plan.of_record(record) == dataclasses.replace(
            plan, sizes=None, costs=(), doubts=()
        )


@pytest.mark.parametrize(
    ("changes", "methods", "words"),
    [
        ({}, {"tangential": "clarabell"}, ["tangential", "clarabell", "clarabel"]),
        ({}, {"formulation": "complementary"}, ["formulation", "gap"]),
        ({"surface": SAMPLES}, {"normal": "hertz"}, ["Hertz", "norm", "clarabel"]),
        ({"grid": vc.Grid(nx=4, ny=4, dx=0.1, dy=0.1, x0=5.0, y0=5.0)}, {}, ["grid", "contain"]),
        (
            {"grid": vc.Grid(nx=8, ny=8, dx=0.1, dy=0.1, x0=-0.4, y0=-0.4)},
            {},
            ["grid", "extends to"],
        ),
        (
            {"grid": vc.Grid(nx=4, ny=4, dx=9.0, dy=9.0, x0=-18.0, y0=-18.0)},
            {},
            ["grid", "too coarse"],
        ),
        (
            {"surface": SAMPLES, "normal_force": None, "approach": 1e-9, "grid": EXPLICIT},
            {},
            ["grid", "element"],
        ),
    ],
)
def test_bad_input_is_refused_as_by_solve(rolling, changes, methods, words):
    for act in (vc.plan, vc.solve):
        with pytest.raises(vc.SceneError) as error:
            act(rolling(**changes), **methods)
        assert all(word in str(error.value) for word in words)


def test_no_scene_and_no_memory():
    refused(lambda: vc.plan("scene.toml"), match="a Scene")
    scene = make_scene(vc.Ellipse(a=1.0, b=1.0), 1.0, None, vc.Grid(nx=10**6, ny=10**6), None)
    refused(lambda: vc.plan(scene), match="a grid of this size", error=vc.TooLarge)


def test_a_history_whose_load_is_given_by_step_is_planned(rolling):
    motion = vc.Transient(steps=2, vx=0.04, normal_force=[1.0, 0.8], friction=[0.3, 0.2])
    plan = vc.plan(
        rolling(surface=vc.Paraboloids(1.0, 0.8), normal_force=None, friction=None, motion=motion)
    )
    assert (plan.motion, plan.sizes.grid) == ("transient", (14, 14))


@pytest.mark.parametrize(
    "changes", [{}, {"bodies": UNLIKE}, {"grid": AROUND}, {"surface": SAMPLES, "grid": EXPLICIT}]
)
def test_a_history_is_planned_by_bounds_of_its_steps(rolling, changes):
    scene = rolling(**changes, motion=vc.Transient(steps=2, vx=0.04, vy=0.01))
    plan, history = vc.plan(scene), vc.solve(scene)
    assert (plan.motion, plan.sizes.exact) == ("transient", False)
    assert choices(history[0].plan) == choices(history[1].plan) == choices(plan)
    assert plan.sizes.grid == history[0].grid.shape
    assert plan.sizes.elements["tangential"] >= history[1].elements["contact"]


def test_plan_names_the_law(rolling):
    assert vc.plan(rolling(friction=FALLING)).friction == "rational"
    assert vc.plan(rolling()).friction == "given"
    assert vc.plan(rolling(motion=None)).friction == "none"
    history = vc.Transient(steps=2, vx=0.05, friction=[0.3, vc.StaticKinetic(0.3, 0.2)])
    assert vc.plan(rolling(motion=history)).friction == "several"


def test_costs_of_all_methods_that_lead_there(rolling):
    """Known by their order: products, then active sets, then programs."""
    plan = vc.plan(rolling(grid=vc.Grid(nx=40, ny=40)))
    found = {cost.method: cost for cost in plan.costs}
    assert list(found) == ["auto", "convex", "conic", "active-set"]
    assert found["auto"].tangential == "newton"
    assert 10 * found["auto"].seconds < 10 * found["active-set"].seconds < found["conic"].seconds
    assert found["auto"].bytes < found["active-set"].bytes < found["conic"].bytes
    assert "auto (hertz, newton): about 0.0" in str(plan)
    names = {"method", "normal", "tangential", "seconds", "bytes"}
    assert [set(cost) for cost in plan.summary()["costs"]] == 4 * [names]
