"""Programs of scenes without a solution: out to solvers and files, and back with a certificate."""

import dataclasses

import clarabel
import numpy as np
import osqp
import pytest
import qpsolvers
import scs
from scipy.optimize import minimize
from scipy.sparse import csc_matrix

import varcontact as vc
from tests import random_scenes
from tests.scenes import refused
from varcontact import energy

GRID = vc.Grid(nx=8, ny=8)
STEADY = vc.Steady(vx=0.04, vy=-0.02, spin=0.05)
SHIFT = vc.Shift(ux=0.1, uy=-0.06, rotation=0.05)
FORCED = vc.Shift(Fx=-0.1, uy=0.05)
KINDS = [
    (STEADY, "gap"),
    (vc.Steady(Fx=-0.1), "gap"),
    *(
        (motion, name)
        for motion in (SHIFT, FORCED)
        for name in ("complementary", "potential", "gap")
    ),
]
LINE = {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=12)}


def solved(program):
    """Variables and multipliers by Clarabel, as exact as it can."""
    options = clarabel.DefaultSettings()
    options.verbose = False
    options.max_step_fraction = 0.75
    options.tol_gap_abs = options.tol_gap_rel = options.tol_feas = 1e-12
    answer = clarabel.DefaultSolver(*program.to("clarabel"), options).solve()
    return np.array(answer.x), np.array(answer.z)


@pytest.fixture
def small(rolling):
    return lambda **changes: rolling(**{"grid": GRID, **changes})


@pytest.mark.parametrize(("motion", "formulation"), KINDS)
def test_tractions_come_back_with_energy_and_multipliers(small, motion, formulation):
    """The value of the program is the energy; multipliers are what the report says."""
    scene = small(motion=motion)
    program = vc.program(scene, "tangential", formulation)
    x, z = solved(program)
    sol = program.solution(x, z)
    exact = vc.solve(scene, tol=1e-11)
    assert sol.certificate.tangential_residual < 1e-6
    assert sol.solved_by == {"tangential": "program"}
    np.testing.assert_allclose(sol.traction, exact.traction, atol=1e-6)
    np.testing.assert_allclose(sol.creepage, exact.creepage, atol=1e-8)

    posed = energy.posed(exact)
    value = (0.5 * x @ (program.P @ x) + program.q @ x) * program.scales["energy"]
    problem = posed.tangential
    expected = 0.0
    if formulation == "complementary":
        expected = -energy.complementary_energy(problem, posed.traction) * posed.unit
    elif formulation == "potential":
        expected = energy.potential_energy(problem, posed.traction, posed.rigid) * posed.unit
    assert value == pytest.approx(expected, abs=1e-9)

    weight = problem.bound / problem.bound.max()
    traction = x[program.variables["traction"]].reshape(2, -1)
    unit = program.scales["shift"] / program._contact.disc.scales.displacement
    shift = problem.shift(posed.traction, posed.rigid) / unit
    if "shift" in program.duals:
        cones = z[program.duals["shift"]].reshape(-1, 3).T
        np.testing.assert_allclose(cones, weight * [np.ones(weight.size), *traction], atol=1e-5)
    if "bound" in program.duals:
        cones = z[program.duals["bound"]].reshape(-1, 3).T
        np.testing.assert_allclose(cones, weight * [np.hypot(*shift), *shift], atol=1e-5)
    if "force" in program.duals:
        multiplier = z[program.duals["force"]] / weight.sum() * unit
        np.testing.assert_allclose(multiplier, posed.rigid[:1], atol=1e-6)


@pytest.mark.parametrize("load", [{}, {"normal_force": None, "approach": 0.5}])
@pytest.mark.parametrize(
    ("formulation", "edge", "cells"),
    [
        ("complementary", "centres", 8),
        ("potential", "centres", 8),
        ("gap", "centres", 8),
        ("complementary", "touched", 4),
    ],
)
def test_pressures_come_back(small, load, formulation, edge, cells):
    """On elements and on parts of them; the approach too, of pressures alone where these have it."""
    grid = vc.Grid(nx=cells, ny=cells, edge=edge)
    scene = small(motion=None, friction=None, grid=grid, **load)
    program = vc.program(scene, "normal", formulation)
    x, z = solved(program)
    exact = vc.solve(scene, normal="norm", tol=1e-11)
    answers = [program.solution(x, z)]
    if formulation != "potential":
        answers.append(program.solution(x))
    for sol in answers:
        assert sol.certificate.normal_residual < 1e-7
        assert sol.converged is (sol.certificate.normal_residual <= 1e-8)
        np.testing.assert_allclose(sol.pressure, exact.pressure, atol=1e-7)
        assert sol.approach == pytest.approx(exact.approach, abs=1e-8)
    posed = energy.posed(exact)
    value = (0.5 * x @ (program.P @ x) + program.q @ x) * program.scales["energy"]
    expected = 0.0
    if formulation == "complementary":
        expected = -energy.complementary_energy(posed.normal, posed.pressure) * posed.unit
    elif formulation == "potential":
        expected = energy.potential_energy(posed.normal, posed.pressure) * posed.unit
    assert value == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("load", [{"normal_force": 0.05}, {"normal_force": None, "approach": 0.05}])
def test_the_gap_of_relaxing_bodies(load):
    """An unsymmetric normal problem: the program has both conditions, and the pressures of NORM."""
    solid = vc.Viscoelastic(1.0, 0.3, [(1.0, 0.1), (0.5, 1.0)])
    scene = vc.Scene(
        bodies=solid, surface=vc.Paraboloids(1.0, 1.0), motion=vc.Steady(speed=1.0), friction=0.0,
        grid=vc.Grid(nx=8, ny=8, dx=0.09, dy=0.09, x0=-0.36, y0=-0.36), **load,
    )  # fmt: skip
    program = vc.program(scene, "normal")
    assert program.formulation == "gap"
    shifts = program.A[program.duals["distance"], program.variables["traction"]].toarray()
    assert not np.allclose(shifts, shifts.T)
    x, z = solved(program)
    assert abs(0.5 * x @ (program.P @ x) + program.q @ x) < 1e-7
    sol = program.solution(x, z)
    exact = vc.solve(scene, normal="norm", tol=1e-11)
    np.testing.assert_allclose(sol.pressure, exact.pressure, atol=1e-6 * exact.max_pressure)
    assert sol.approach == pytest.approx(exact.approach, rel=1e-6)
    refused(lambda: vc.program(scene, "normal", "complementary"), "formulation")


def by_scs(program):
    return scs.SCS(*program.to("scs"), verbose=False, eps_abs=1e-9, eps_rel=1e-9).solve()["x"]


def by_cvxpy(program):
    problem = program.to("cvxpy")
    problem.solve(solver="CLARABEL")
    return problem.var_dict["x"].value


def by_osqp(program):
    solver = osqp.OSQP()
    solver.setup(**program.to("osqp"), verbose=False, eps_abs=1e-9, eps_rel=1e-9, max_iter=20_000)
    return solver.solve().x


def by_qpsolvers(program):
    return qpsolvers.solve_problem(program.to("qpsolvers"), "piqp").x


def by_scipy(program):
    return minimize(**program.to("scipy"), options={"maxiter": 500, "ftol": 1e-13}).x


@pytest.mark.parametrize("solve", [by_scs, by_cvxpy, by_osqp, by_qpsolvers, by_scipy])
@pytest.mark.parametrize("kind", ["normal", "line", "disks"])
def test_every_language(small, solve, kind):
    """The same answer by every package; disks are refused where only QPs are solved."""
    if kind == "normal":
        program = vc.program(small(motion=None, friction=None), "normal")
        exact = vc.solve(program.scene, normal="norm").pressure
    elif kind == "line":
        program = vc.program(small(motion=vc.Steady(vx=0.02), **LINE))
        exact = vc.solve(program.scene).traction
    else:
        program = vc.program(small(motion=SHIFT, grid=vc.Grid(nx=5, ny=5)), "tangential")
        exact = vc.solve(program.scene).traction
    if kind == "disks" and solve in (by_osqp, by_qpsolvers):
        refused(lambda: solve(program), "name", match="second-order cones")
        return
    sol = program.solution(solve(program))
    found = sol.pressure if kind == "normal" else sol.traction
    np.testing.assert_allclose(found, exact, atol=2e-4 * np.abs(exact).max())


def test_product_without_a_matrix(small):
    """`operator` is the matrix of the shift rows, its transpose too; P of the complementary form is
    its product with w.
    """
    for scene, formulation in ((small(), "gap"), (small(motion=SHIFT), "complementary")):
        program = vc.program(scene, formulation=formulation)
        M = program.operator
        dense = M @ np.eye(M.shape[0])
        np.testing.assert_allclose(M.H @ np.eye(M.shape[0]), dense.T, atol=1e-12)
        traction = program.variables["traction"]
        bound = program.scales["traction"] / program.scales["traction"].max()
        P = program.P.toarray()[traction, traction]
        whole = bound[:, None] * dense
        if formulation == "gap":
            whole = whole + whole.T
        np.testing.assert_allclose(P, whole, atol=1e-12)
    wide = vc.program(small(grid=vc.Grid(nx=60, ny=60)))  # dense it would take 5 GB
    size = wide.operator.shape[0]
    assert np.isfinite(wide.operator @ np.ones(size)).all()


def cbf_read(path):
    """A small reader of CBF: blocks by name, each a list of lines of words."""
    blocks = {}
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    for block in "\n".join(lines).strip().split("\n\n"):
        name, *rest = block.splitlines()
        blocks[name] = [line.split() for line in rest]
    return blocks


def matrix_of(entries, shape):
    matrix = np.zeros(shape)
    for *place, value in entries[1:]:
        matrix[tuple(map(int, place))] = float(value)
    return matrix


@pytest.mark.parametrize(
    ("kind", "formulation"), [(STEADY, "gap"), (FORCED, "complementary"), (None, "potential")]
)
def test_cbf(small, tmp_path, kind, formulation):
    """Read back and solved as it stands in the file, it has the same value and variables."""
    problem = "normal" if kind is None else "tangential"
    program = vc.program(small(motion=kind, friction=0.3 if kind else None), problem, formulation)
    path = tmp_path / "x.cbf"
    program.save(path)
    blocks = cbf_read(path)
    assert blocks["VER"] == [["3"]]
    assert blocks["OBJSENSE"] == [["MIN"]]
    n = int(blocks["VAR"][0][0])
    assert blocks["VAR"] == [[str(n), "1"], ["F", str(n)]]
    rows = int(blocks["CON"][0][0])
    assert int(blocks["CON"][0][1]) == len(blocks["CON"]) - 1
    assert sum(int(size) for _, size in blocks["CON"][1:]) == rows
    A = matrix_of(blocks["ACOORD"], (rows, n))
    b = matrix_of(blocks["BCOORD"], (rows,))
    c = matrix_of(blocks["OBJACOORD"], (n,))
    # 2 s0 s1 >= |rest|^2 as |(s0 - s1, rest sqrt 2)| <= s0 + s1
    quadratic = int(blocks["CON"][-1][1])
    turn = np.eye(rows)
    first = rows - quadratic
    turn[first : first + 2, first : first + 2] = [[1, 1], [1, -1]]
    turn[first + 2 :, first + 2 :] *= np.sqrt(2)
    cones = {
        "L=": clarabel.ZeroConeT,
        "L+": clarabel.NonnegativeConeT,
        "Q": clarabel.SecondOrderConeT,
    }
    cones["QR"] = clarabel.SecondOrderConeT
    options = clarabel.DefaultSettings()
    options.verbose = False
    answer = clarabel.DefaultSolver(
        csc_matrix((n, n)), c, csc_matrix(-turn @ A), turn @ b,
        [cones[name](int(size)) for name, size in blocks["CON"][1:]], options,
    ).solve()  # fmt: skip
    x, _ = solved(program)
    value = 0.5 * x @ (program.P @ x) + program.q @ x
    assert answer.obj_val == pytest.approx(value, abs=1e-6)
    pressed = program.variables["traction"]
    np.testing.assert_allclose(np.array(answer.x)[pressed], x[pressed], atol=2e-3)


def test_npz_and_files_of_others(small, tmp_path):
    program = vc.program(small(motion=FORCED))
    path = tmp_path / "x.npz"
    program.save(path)
    program.save(path)  # its own file is replaced
    with np.load(path) as file:
        P, A = (
            csc_matrix(tuple(file[f"{name}_{part}"] for part in ("data", "indices", "indptr")))
            for name in "PA"
        )
        np.testing.assert_array_equal(P.toarray(), program.P.toarray())
        np.testing.assert_array_equal(A.toarray(), program.A.toarray())
        np.testing.assert_array_equal(file["q"], program.q)
        np.testing.assert_array_equal(file["b"], program.b)
        cones = list(zip(file["cones"].tolist(), file["cone_sizes"].tolist(), strict=True))
        assert cones == program.cones
        ends = dict(zip(file["rows"].tolist(), file["rows_ends"].tolist(), strict=True))
        assert ends == {name: place.stop for name, place in program.duals.items()}
    for name in ("x.csv", "nowhere/x.npz"):
        with pytest.raises(vc.OutputError):
            program.save(tmp_path / name)
    other = tmp_path / "other.npz"
    np.savez(other, mine=np.ones(3))
    with pytest.raises(vc.OutputError, match="overwrite"):
        program.save(other)
    program.save(other, overwrite=True)


def test_rows_and_cones_are_in_the_documented_order(small):
    order = ["zero", "nonnegative", "second_order"]
    for motion in (FORCED, vc.Steady(Fx=-0.1, Fy=0.02)):
        cones = vc.program(small(motion=motion), formulation="gap").cones
        places = [order.index(kind) for kind, _ in cones]
        assert places == sorted(places)


def test_report_says_what_is_held_fixed(small):
    law = (
        vc.LinearFalling(static=0.3, kinetic=0.2, critical_slip=0.01)
        if False
        else vc.StaticKinetic(0.3, 0.2)
    )
    assert "static coefficient" in vc.program(small(friction=law)).report()
    unlike = small(bodies=vc.Bodies(G=(1.0, 3.0), nu=0.28))
    refused(lambda: vc.program(unlike), "pressure", match="ignores tangential tractions")
    pressure = vc.solve(small()).pressure
    placed = dataclasses.replace(unlike, grid=vc.solve(small()).grid)
    fixed = vc.program(placed, pressure=pressure)
    assert "the pressure" in fixed.notes[0]
    x, _ = solved(fixed)
    sol = fixed.solution(x)
    assert sol.certificate.tangential_residual < 1e-6
    assert sol.certificate.residual > 1e-3  # of the whole, whose pressure is another
    assert "no tractions" in vc.program(placed, "normal").notes[0]


@pytest.mark.long
def test_yielding_and_hardening_layers(small):
    """A fixed yield stress is a bound, hardening in a shift a flow; both are programs."""
    for layer in (
        vc.ThirdBody(h=0.1, G=1.0, tau_c0=0.05),
        vc.ThirdBody(h=0.1, G=1.0, tau_c0=0.05, k_tau=1.0),
    ):
        scene = small(motion=SHIFT, third_body=layer)
        for formulation in ("complementary", "potential", "gap"):
            program = vc.program(scene, formulation=formulation)
            x, _ = solved(program)
            exact = vc.solve(scene, tol=1e-10).traction
            np.testing.assert_allclose(program.solution(x).traction, exact, atol=1e-5)


@pytest.mark.parametrize(
    ("changes", "options", "field", "words"),
    [
        ({"motion": vc.Transient(steps=2, vx=0.01)}, {}, "motion", "step before"),
        ({"motion": None}, {}, "motion", "Steady or Shift"),
        ({"friction": 0.0}, {}, "friction", "no tractions"),
        ({"friction": np.inf}, {}, "friction", "linear system"),
        ({"third_body": vc.ThirdBody(h=0.1, G=1.0, tau_c0=0.05, k_tau=1.0)}, {}, "third_body.k_tau", "follows from"),
        ({}, {"formulation": "fastsim"}, "formulation", "a theory is a formula"),
        ({}, {"formulation": "complementary"}, "formulation", "no energy"),
        ({}, {"formulation": "marching"}, "formulation", "one of"),
        ({}, {"problem": "both"}, "problem", "one of"),
        ({}, {"pressure": np.ones((2, 2))}, "pressure", "shape"),
        ({}, {"pressure": np.ones((2, 2)), "problem": "normal"}, "pressure", "left out"),
    ],
)  # fmt: skip
def test_scenes_without_a_program_are_refused(small, changes, options, field, words):
    refused(lambda: vc.program(small(**changes), **options), field, match=words)


def test_a_gap_that_is_not_convex_is_refused(small):
    long = small(bodies=vc.Bodies(G=1.0, nu=0.5), surface=vc.Ellipse(a=10.0, b=0.5),
                 motion=vc.Steady(vx=0.01, dq=0.2))  # fmt: skip
    refused(lambda: vc.program(long), "motion.dq", match="not found to be convex")


def test_answers_of_another_shape_are_refused(small):
    program = vc.program(small(motion=FORCED), formulation="complementary")
    x = np.zeros(program.q.size)
    refused(lambda: program.solution(x), "z", match="part of the answer")
    refused(lambda: program.solution(x[:-1], np.zeros(program.b.size)), "x")
    refused(lambda: program.solution(np.nan * x, np.zeros(program.b.size)), "x[0]")
    refused(lambda: program.solution(x, np.zeros(3)), "z")
    refused(lambda: program.to("gurobi"), "name")
    nothing = program.solution(x, np.zeros(program.b.size))  # an answer that is none
    assert not nothing.converged
    assert nothing.certificate.residual > 0.1


@pytest.mark.long
def test_a_solution_of_a_program_is_a_solution(small, tmp_path):
    """It reports, draws, saves and loads like any other."""
    program = vc.program(small())
    x, _ = solved(program)
    sol = program.solution(x)
    assert "program" in sol.report()
    sol.save(tmp_path / "x.nc")
    again = vc.load(tmp_path / "x.nc")
    assert again.note == ""
    assert again.plan.tangential == "program"


@pytest.mark.slow
@pytest.mark.parametrize(
    "kind", [kind for kind in random_scenes.KINDS if not kind.endswith("history")]
)
def test_random_scenes(kind):
    """Programs of every kind of scene, of pressures and of tractions, come back right."""
    (scene,) = random_scenes.scenes(kind, 1, seed=0)
    grid = vc.Grid(nx=8) if scene.line else vc.Grid(nx=8, ny=8)
    sol = vc.solve(dataclasses.replace(scene, grid=grid))
    placed = dataclasses.replace(scene, grid=sol.grid)
    normal = vc.program(placed, "normal")
    assert normal.solution(*solved(normal)).certificate.normal_residual < 1e-6
    if scene.motion is None:
        return
    pressure = None if sol.plan.closed_form else sol.pressure
    tangential = vc.program(placed, pressure=pressure)
    assert tangential.solution(*solved(tangential)).certificate.tangential_residual < 1e-4
