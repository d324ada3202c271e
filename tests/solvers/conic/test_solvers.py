"""The multipliers of the programs against physics: what comes out of a force gives that force."""

import dataclasses

import numpy as np
import pytest
from scipy.sparse import csc_matrix

import varcontact as vc
from varcontact.solvers.conic.backends import BACKENDS, solve_program
from varcontact.solvers.conic.programs import ConicProgram
from varcontact.solvers.interface import Settings
from varcontact.solvers.registry import CVXPY_SOLVERS, PROGRAM_SOLVERS

GRID = vc.Grid(nx=8, ny=8)
ALL = [*PROGRAM_SOLVERS, *(f"qpsolvers:{name}" for name in BACKENDS), *(f"cvxpy:{name}" for name in CVXPY_SOLVERS)]


@pytest.mark.parametrize("name", ALL)
def test_every_solver_tells_whether_it_solved(name):
    """``min x^2/2 + x`` has an answer with -1/2 <= x <= 1, and none with 2 <= x <= 1, whatever words say so."""
    one = csc_matrix([[1.0]])
    for lowest, possible in ((-0.5, True), (2.0, False)):
        program = ConicProgram(
            one, np.array([1.0]), csc_matrix([[1.0], [-1.0]]), np.array([1.0, -lowest]), [("nonnegative", 2)],
            lambda x, z: (x, np.zeros(1)),
        )  # fmt: skip
        raw = solve_program(name, program, Settings())
        assert raw.solved is possible, raw.status
        assert not possible or raw.traction[0] == pytest.approx(-0.5, abs=1e-6)


@pytest.mark.parametrize("formulation", ["complementary", "potential"])
@pytest.mark.parametrize("name", ["clarabel", "osqp", "scs", "qpsolvers:piqp", "qpsolvers:daqp", "cvxpy:OSQP"])
def test_approach(rolling, name, formulation):
    """The approach that belongs to a force, prescribed, gives that force and the same pressures."""
    scene = rolling(motion=None, friction=None, grid=GRID)
    by_force = vc.solve(scene, normal=name, formulation=formulation, polish=False)
    hertz = scene.hertz
    asked = dataclasses.replace(
        scene, surface=vc.Paraboloids(hertz.Rx, hertz.Ry), normal_force=None, approach=by_force.approach,
        grid=by_force.grid,
    )  # fmt: skip
    by_approach = vc.solve(asked, normal="norm")
    assert by_approach.normal_force == pytest.approx(1.0, rel=1e-7)
    np.testing.assert_allclose(by_approach.pressure, by_force.pressure, atol=1e-7)


FREE = {
    "steady": (vc.Steady(vx=0.05, vy=-0.02, spin=0.03), ("vx", "vy")),
    "shift": (vc.Shift(ux=0.1, uy=-0.06, rotation=0.05), ("ux", "uy")),
}


@pytest.mark.parametrize("which", ["Fy", "both"])
@pytest.mark.parametrize(
    ("kind", "formulation"), [("steady", "gap"), ("shift", "complementary"), ("shift", "potential"), ("shift", "gap")]
)
@pytest.mark.parametrize("name", ["clarabel", "scs"])
def test_creepages(rolling, name, kind, formulation, which):
    """Raw: prescribed forces give creepages; these, prescribed, the same tractions and forces."""
    motion, names = FREE[kind]
    forces = dict(zip(("Fx", "Fy"), (-0.12, 0.08), strict=True))
    asked = {F: value for F, value in forces.items() if which in (F, "both")}
    zero = {n: 0.0 for n, F in zip(names, forces, strict=True) if F in asked}
    scene = rolling(motion=dataclasses.replace(motion, **zero, **asked), grid=GRID)
    try:
        raw = vc.solve(scene, tangential=name, formulation=formulation, polish=False, tol=1e-7)
    except vc.NotConverged as error:
        raw = error.solution  # a few times the request, see tests/test_methods.py
    found = dict(zip(names, raw.creepage, strict=False))
    again = vc.solve(rolling(motion=dataclasses.replace(motion, **found), grid=GRID))
    for i, F in enumerate(forces):
        if F in asked:
            # with both forces prescribed SCS ends at its limit of iterations, and is that much worse
            assert again.force[i] == pytest.approx(asked[F], rel=1e-5 if name == "scs" else 1e-6)
    # Raw interior points leave 1e-12 of energy, which is up to 1e-5 in an element.
    np.testing.assert_allclose(again.traction, raw.traction, atol=5e-5)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0), (-0.6, 0.8)])
@pytest.mark.parametrize("kind", ["steady", "shift"])
@pytest.mark.parametrize("tangential", ["clarabel", "scs", "tang-safeguarded"])
def test_near_saturation_and_beyond(rolling, tangential, kind, direction, check_kkt):
    """0.999 of f Fz: creepages that give it back; all of it and more: the limit is told."""
    motion = vc.Steady if kind == "steady" else vc.Shift
    Fx, Fy = 0.999 * 0.3 * np.array(direction)
    scene = rolling(motion=motion(Fx=float(Fx), Fy=float(Fy)), grid=GRID)
    strong = vc.solve(scene, tangential=tangential)
    check_kkt(strong, 1e-8)
    names = FREE[kind][1]
    again = vc.solve(rolling(motion=motion(**dict(zip(names, strong.creepage, strict=False))), grid=GRID))
    np.testing.assert_allclose(again.force, [Fx, Fy], atol=1e-9)
    np.testing.assert_allclose(again.traction, strong.traction, atol=1e-8)
    for part in (1.0, 1.2):
        Fx, Fy = part * 0.3 * (1 + 1e-12) * np.array(direction)
        with pytest.raises(vc.Saturated) as failure:
            vc.solve(rolling(motion=motion(Fx=float(Fx), Fy=float(Fy)), grid=GRID), tangential=tangential)
        assert failure.value.limit == pytest.approx(0.3, rel=1e-12)
        assert failure.value.force == pytest.approx(part * 0.3, rel=1e-11)
