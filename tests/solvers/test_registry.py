"""Every method by its name: the optimality conditions of its answers, what is refused, and what is
not installed.
"""

import dataclasses
import functools
import sys

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refusals, refused
from varcontact.solvers.registry import SOLVERS, normal_methods, states_program, tangential_methods

ACTIVE_SETS = ("norm", "norm-single", "quadprog", "tang-safeguarded", "tang", "tang-exact")
"""They end on the right areas, and there solve a linear system: rounding is all that is left."""
REACHED = {"normal": 1e-8, "tangential": 5e-6}
"""What programs leave without a polish when asked for 1e-8 (QPs) and 1e-7 (cones: near the edges of
the friction disks the last digits come slowly, up to 16 times the request was seen)."""
CELLS = vc.Grid(nx=8, ny=8)
GRIDS = {"steady": vc.Grid(nx=5, ny=5), "shift": CELLS}  # a march takes many solves

STEADY = vc.Steady(vx=0.05, vy=-0.02, spin=0.03)
SHIFT = vc.Shift(ux=0.1, uy=-0.06, rotation=0.05)


def solved(scene, **arguments):
    try:
        return vc.solve(scene, **arguments)
    except vc.NotConverged as error:
        if error.solution is None:
            raise
        return error.solution


def bare(name):
    """The solver's own name, without the family."""
    return name.partition(":")[2].lower() or name


# ----------------------------------------------------------------------------- normal


def normal_scene(rolling, prescribed):
    """An ellipse by its radii, so that either force or approach can be prescribed."""
    scene = rolling(motion=None, friction=None, grid=CELLS)
    if prescribed == "force":
        return scene
    hertz = scene.hertz
    surface = vc.Paraboloids(hertz.Rx, hertz.Ry)
    return dataclasses.replace(scene, surface=surface, normal_force=None, approach=hertz.approach)


def formulations(name):
    return ("complementary", "potential") if states_program("normal", name) else ("auto",)


NORMAL = [
    (name, form, prescribed)
    for name in normal_methods()
    if name != "hertz"
    for form in formulations(name)
    for prescribed in ("force", "approach")
    if (bare(name), form, prescribed) != ("quadprog", "potential", "force")  # refused, see below
]


@pytest.mark.parametrize(("name", "formulation", "prescribed"), NORMAL)
def test_normal_methods(rolling, check_kkt, name, formulation, prescribed):
    scene = normal_scene(rolling, prescribed)
    sol = solved(scene, normal=name, formulation=formulation, polish=False)
    check_kkt(sol, 1e-11 if bare(name) in ACTIVE_SETS else REACHED["normal"])
    assert sol.converged
    assert sol.status["normal"]
    if states_program("normal", name):
        polished = vc.solve(scene, normal=name, formulation=formulation, tol=1e-9)
        check_kkt(polished, 1e-9)
        assert polished.certificate.residual < 1e-12, "polished to rounding"


def test_quadprog_refuses_a_singular_matrix_clearly(rolling):
    """The potential form with the force prescribed has no quadratic term in the approach; quadprog
    wants one.
    """
    for polish in (True, False):
        with pytest.raises(
            vc.NotConverged, match=r"quadprog gave no pressure.*not positive definite"
        ) as failure:
            solved(
                normal_scene(rolling, "force"),
                normal="qpsolvers:quadprog",
                formulation="potential",
                polish=polish,
            )
        assert failure.value.solution is None


def test_all_names_are_there():
    """The lists that users see, and that the tests above go through."""
    assert {"hertz", "norm", "norm-single", "clarabel", "osqp", "scs"} <= set(normal_methods())
    assert {"qpsolvers:piqp", "qpsolvers:proxqp", "qpsolvers:daqp", "qpsolvers:quadprog"} <= set(
        normal_methods()
    )
    assert {"cvxpy:CLARABEL", "cvxpy:OSQP", "cvxpy:SCS", "cvxpy:HIGHS"} <= set(normal_methods())
    assert {"tang", "tang-safeguarded", "clarabel", "scs", "cvxpy:CLARABEL", "cvxpy:SCS"} <= set(
        tangential_methods()
    )
    assert not {"osqp", "cvxpy:OSQP", "qpsolvers:clarabel"} & set(tangential_methods()), (
        "they know no cones"
    )


@pytest.mark.parametrize("spec", SOLVERS.values(), ids=lambda spec: f"{spec.kind} {spec.name}")
def test_an_entry_of_the_table_says_what_the_package_asks(spec):
    """Nothing else is read off a name: a solver is a program's or matrix-free, not both, and what
    takes intervals alone is no method where there are disks.
    """
    assert SOLVERS[spec.kind, spec.name] is spec
    assert not (spec.matrix_free and spec.states_program)
    assert bool(spec.needs) == spec.states_program
    names = normal_methods() if spec.kind == "normal" else tangential_methods()
    assert (spec.name in names) != spec.intervals_only


def test_a_solver_of_any_name_is_one_entry(rolling, check_kkt, monkeypatch):
    """Called, counted, certified and listed under its name, which says nothing by itself."""
    newton = SOLVERS["tangential", "newton"]
    own = dataclasses.replace(newton, name="cvxpy")
    monkeypatch.setitem(SOLVERS, ("tangential", "cvxpy"), own)
    sol = vc.solve(rolling(grid=CELLS), tangential="cvxpy")
    check_kkt(sol, 1e-8)
    assert sol.plan.formulation == "none" and "requested" in sol.plan.reasons["tangential"]
    assert sol.calls["tangential"]["cvxpy"].count == 1
    assert sol.solved_by["tangential"] == "cvxpy" and "cvxpy" in tangential_methods()
    with pytest.raises(vc.SceneError, match=r"^tangential = .*did you mean cvxpy:SCS"):
        vc.solve(rolling(grid=CELLS), tangential="cvxpy:scs")


# ----------------------------------------------------------------------------- tangential


def tangential_formulations(name, kind):
    if not states_program("tangential", name):
        return ("auto", "marching") if kind == "steady" else ("auto",)
    return ("gap", "marching") if kind == "steady" else ("complementary", "potential", "gap")


TANGENTIAL = [
    (name, kind, form)
    for name in tangential_methods()
    for kind in ("steady", "shift")
    for form in tangential_formulations(name, kind)
]


@functools.cache
def motions(rolling, kind):
    """The same contact by creepages, and by the forces that belong to them."""
    free, names = (STEADY, ("vx", "vy")) if kind == "steady" else (SHIFT, ("ux", "uy"))
    Fx, Fy = (float(F) for F in vc.solve(rolling(motion=free, grid=GRIDS[kind])).force)
    return {
        "creepages": free,
        "Fx": dataclasses.replace(free, **{names[0]: 0.0, "Fx": Fx}),
        "both": dataclasses.replace(free, **dict.fromkeys(names, 0.0), Fx=Fx, Fy=Fy),
    }


def cases(tangential, prescribed):
    """All combinations; through CVXPY, and by SCS, which are slow, all forces only."""
    return [
        (*t, p)
        for t in tangential
        for p in prescribed
        if p == "both" or not t[0].startswith(("cvxpy", "scs"))
    ]


@pytest.mark.parametrize(
    ("name", "kind", "formulation", "prescribed"),
    cases(TANGENTIAL, ("creepages", "Fx", "both")),
)
def test_tangential_methods(rolling, check_kkt, name, kind, formulation, prescribed):
    scene = rolling(motion=motions(rolling, kind)[prescribed], grid=GRIDS[kind])
    tol = 1e-8 if name in ACTIVE_SETS else 1e-7
    sol = solved(scene, tangential=name, formulation=formulation, polish=False, tol=tol)
    limit = 1e-8 if formulation == "marching" else 1e-11
    check_kkt(sol, limit if name in ACTIVE_SETS else REACHED["tangential"])
    if name in ACTIVE_SETS:
        assert sol.converged
    free = (STEADY if kind == "steady" else SHIFT).rigid
    assert sol.creepage == pytest.approx(free, rel=1e-5), (
        "the creepage is the multiplier of the force"
    )
    assert sol.elements["stick"] > 5 and sol.elements["slip"] > 5, (
        "both kinds of area are there to be found"
    )
    if formulation == "marching":
        assert sol.status["tangential"] == "Steady"


@pytest.mark.parametrize(
    ("name", "kind", "formulation", "prescribed"),
    cases([t for t in TANGENTIAL if states_program("tangential", t[0])], ["both"]),
)
def test_polished_tangential_methods(rolling, check_kkt, name, kind, formulation, prescribed):
    scene = rolling(motion=motions(rolling, kind)[prescribed], grid=GRIDS[kind])
    sol = solved(scene, tangential=name, formulation=formulation, tol=1e-9)
    check_kkt(sol, 1e-9)
    assert sol.certificate.residual < 1e-12
    assert sol.creepage == pytest.approx((STEADY if kind == "steady" else SHIFT).rigid, rel=1e-10)


@pytest.mark.parametrize(
    ("normal", "tangential"),
    [
        ("norm", "tang-safeguarded"),
        ("osqp", "tang"),
        ("norm-single", "scs"),
        ("clarabel", "clarabel"),
    ],
)
@pytest.mark.parametrize(
    "motion", [STEADY, SHIFT, vc.Steady(Fx=-0.1, vy=0.01), vc.Shift(Fx=0.1, Fy=0.1)]
)
def test_unlike_bodies_by_any_pair_of_methods(rolling, check_kkt, normal, tangential, motion):
    """Coupled, and polished where programs are solved: the conditions of the whole, K in both
    directions.
    """
    scene = rolling(bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3)), motion=motion, grid=CELLS)
    sol = solved(scene, normal=normal, tangential=tangential)
    together = (normal, tangential) == ("norm", "tang-safeguarded")
    assert sol.plan.coupling == ("active-set" if together else "panagiotopoulos")
    check_kkt(sol, 1e-8)


# ----------------------------------------------------------------------------- refusals


def solve_with(rolling, **arguments):
    return vc.solve(rolling(), **arguments)


test_unknown_names = refusals(
    ({"normal": "norm-singel"}, "^normal = .*did you mean norm-single"),
    ({"normal": "qpsolvers:piq"}, "^normal = .*did you mean qpsolvers:piqp"),
    ({"tangential": "cvxpy:clarabel"}, "^tangential = .*did you mean cvxpy:CLARABEL"),
    ({"tangential": "tang-safegarded"}, "^tangential = .*did you mean tang-safeguarded"),
    ({"tangential": "fastsim-eliptic"}, "^tangential = .*did you mean fastsim-elliptic"),
    ({"formulation": "marchin"}, "^formulation = .*did you mean marching"),
    of=solve_with,
    fixture="rolling",
)


@pytest.mark.parametrize(("arguments", "install"), [
    ({"normal": "scs"}, "scs"),
    ({"tangential": "cvxpy:SCS"}, "scs"),
    ({"tangential": "cvxpy:CLARABEL"}, "cvxpy"),
    ({"normal": "qpsolvers:proxqp"}, "proxsuite"),
    ({"normal": "qpsolvers:ecos"}, "ecos"),
    ({"tangential": "cvxpy:ECOS"}, "ecos"),
    ({"tangential": "cvxpy:CVXOPT"}, "cvxopt"),
    ({"tangential": "cvxpy:ANY"}, "cvxpy"),
    ({"normal": "qpsolvers:any"}, "qpsolvers"),
])  # fmt: skip
def test_what_is_not_installed(rolling, monkeypatch, arguments, install):
    """Told before any work, with what to install."""
    monkeypatch.setitem(sys.modules, install, None)  # to `import` and `find_spec` it is not there
    with pytest.raises(vc.SolverUnavailable, match=f"pip install {install}$") as failure:
        vc.solve(rolling(), **arguments)
    assert failure.value.solver == next(iter(arguments.values()))


STILL = {"motion": None}


@pytest.mark.parametrize(("changes", "arguments", "remedy"), [
    ({}, {"formulation": "complementary"}, "marching"),
    ({}, {"formulation": "potential"}, "marching"),
    ({"motion": SHIFT}, {"formulation": "marching"}, "complementary"),
    ({"motion": vc.Transient(steps=2, vx=1e-3)}, {"tangential": "clarabel", "formulation": "marching"}, "steady"),
    ({"motion": SHIFT}, {"tangential": "tang", "formulation": "marching"}, "auto"),
    ({}, {"tangential": "tang", "formulation": "gap"}, "marching"),
    ({}, {"tangential": "fastsim", "formulation": "gap"}, "auto"),
    (STILL, {"normal": "clarabel", "formulation": "gap"}, "potential"),
    (STILL, {"normal": "norm", "formulation": "potential"}, "auto"),
    (STILL, {"formulation": "complementary"}, "auto"),
])  # fmt: skip
def test_formulations_that_do_not_apply(rolling, changes, arguments, remedy):
    refused(lambda: vc.solve(rolling(**changes), **arguments), "formulation", match=remedy)


def test_gap_that_is_not_convex_is_refused_unpolished(rolling):
    """Long elements and short steps: S is indefinite, the program has no meaning, and nothing is
    asked of a solver.
    """
    a, b = np.sqrt(5), 1 / np.sqrt(5)
    motion = vc.Steady(vx=0.04, vy=-0.02, spin=0.05, dq=0.4 * 2 * a / 8)
    scene = rolling(surface=vc.Ellipse(a=a, b=b), motion=motion, grid=CELLS)
    for name in ("clarabel", "scs", "cvxpy:SCS"):
        with pytest.raises(vc.SceneError, match="not found to be convex"):
            solved(scene, tangential=name, polish=False)


@pytest.mark.long
def test_marching_where_the_gap_is_not_convex(rolling, check_kkt):
    """The programs of its steps are convex: it does march, polished and not, and ends at one
    solution.
    """
    a, b = np.sqrt(5), 1 / np.sqrt(5)
    motion = vc.Steady(spin=0.03, dq=0.35 * 2 * a / 5)
    scene = rolling(surface=vc.Ellipse(a=a, b=b), motion=motion, grid=vc.Grid(nx=5, ny=5))
    newton = vc.solve(scene, tangential="clarabel")
    assert newton.plan.formulation == "gap" and newton.iterations["tangential"] < 20
    marched = vc.solve(scene, tangential="clarabel", formulation="marching")
    assert marched.iterations["tangential"] > 100, "each step of the march has a dozen"
    check_kkt(marched, 1e-11)
    np.testing.assert_allclose(marched.traction, newton.traction, atol=1e-12)
    steps = vc.solve(scene, tangential="tang-safeguarded", formulation="marching")
    np.testing.assert_allclose(steps.traction, newton.traction, atol=1e-8)


test_a_method_of_the_other_problem_is_refused_with_the_reason = refusals(
    ({"tangential": "osqp"}, "second-order cones"),
    ({"tangential": "cvxpy:OSQP"}, "second-order cones"),
    ({"tangential": "norm"}, "normal problems"),
    ({"normal": "tang"}, "must be one of auto, hertz, norm"),
    ({"normal": "fastsim"}, "must be one of auto, hertz, norm"),
    of=solve_with,
    fixture="rolling",
)
