"""Pressure and Coulomb's friction together as FCLIB's local problem: our solutions solve it."""

import dataclasses

import h5py
import numpy as np
import pytest

import varcontact as vc
from tests.scenes import refused
from varcontact.errors import OutputError

GRID = vc.Grid(nx=10, ny=8, dx=0.05, dy=0.06, x0=-0.25, y0=-0.24)
BASE = vc.Scene(
    bodies=vc.Bodies(G=(1.0, 3.0), nu=0.28), surface=vc.Paraboloids(1.0, 1.0), normal_force=0.01, friction=0.3,
    motion=vc.Steady(vx=0.004, vy=-0.002, spin=0.005), grid=GRID,
)  # fmt: skip
ALIKE = vc.Bodies(G=1.0, nu=0.28)
GIVEN = {"normal_force": None, "approach": 0.03}
SCENES = {
    "unlike": {},
    "unlike, approach": GIVEN,
    "unlike, forces": {"motion": vc.Steady(Fx=-0.001, vy=0.001)},
    "unlike, shift": {"motion": vc.Shift(ux=2e-4, uy=-1e-4)},
    "alike": {"bodies": ALIKE},
    "alike, shift, forces": {"bodies": ALIKE, "motion": vc.Shift(Fx=-0.001, Fy=0.0005), **GIVEN},
    "coefficients": {"friction": np.linspace(0.1, 0.4, 80).reshape(8, 10)},
    "line": {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=24, dx=0.02, x0=-0.24),
             "normal_force": 0.02, "motion": vc.Steady(vx=0.002)},
    "line, both ways": {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=24, dx=0.02, x0=-0.24),
                        "normal_force": 0.02, "motion": vc.Steady(vx=0.002, vy=0.001), "bodies": ALIKE},
    "elastic layer": {"third_body": vc.ThirdBody(h=0.01, G=1.0), "bodies": ALIKE},
}  # fmt: skip


def fclib(path):
    """A small reader of FCLIB's file of a local problem, by the names of its header."""
    with h5py.File(path) as file:
        group = file["fclib_local"]
        problem = {"spacedim": int(group["spacedim"][0])}
        for name in ("W", "V", "R"):
            if name not in group:
                continue
            entries = group[name]
            m, n, nz, nzmax = (int(entries[each][0]) for each in ("m", "n", "nz", "nzmax"))
            assert nz == -1  # compressed columns
            matrix = np.zeros((m, n))
            for j in range(n):
                part = slice(entries["p"][j], entries["p"][j + 1])
                matrix[entries["i"][part], j] = entries["x"][part]
            assert entries["p"][n] == nzmax == entries["x"].size
            problem[name] = matrix
        problem |= {name: each[...] for name, each in group["vectors"].items()}
        problem["info"] = {name: each[()].decode() for name, each in group["info"].items()}
        problem["solution"] = {name: each[...] for name, each in file["solution"].items()}
    return problem


def natural_map(problem):
    """Largest ``|r - P(r - u_hat)|`` of the solution in the file, contact by contact (de Saxce)."""
    r, dim = problem["solution"]["r"], problem["spacedim"]
    u = problem["W"] @ r + problem["q"]
    if "V" in problem:
        lam = problem["solution"]["l"]
        u = u + problem["V"] @ lam
        np.testing.assert_allclose(
            problem["V"].T @ r + problem["R"] @ lam, -problem["s"], rtol=1e-11
        )
    np.testing.assert_allclose(u, problem["solution"]["u"], atol=1e-14)
    rho = 1 / np.diagonal(problem["W"]).mean()
    worst = 0.0
    for mu, force, velocity in zip(
        problem["mu"], r.reshape(-1, dim), u.reshape(-1, dim), strict=True
    ):
        modified = velocity + np.eye(dim)[0] * mu * np.linalg.norm(velocity[1:])
        point = force - rho * modified
        size = np.linalg.norm(point[1:])
        if size <= mu * point[0]:
            nearest = point
        elif mu * size <= -point[0]:
            nearest = np.zeros(dim)
        else:
            along = (point[0] + mu * size) / (1 + mu**2)
            nearest = along * np.array([1.0, *(mu * point[1:] / size)])
        worst = max(worst, np.abs(force - nearest).max())
    return worst / np.abs(r).max()


@pytest.mark.parametrize("name", SCENES)
def test_our_solution_solves_the_file(tmp_path, name):
    scene = dataclasses.replace(BASE, **SCENES[name])
    sol = vc.solve(scene, normal="norm", tangential="tang-safeguarded", tol=1e-12)
    problem = vc.friction_problem(scene)
    r, unknowns = problem.variables_of(sol)
    assert problem.residual(r, unknowns) < 1e-12
    path = tmp_path / "x.hdf5"
    problem.save(path, solution=sol)
    read = fclib(path)
    assert natural_map(read) < 1e-12
    np.testing.assert_array_equal(read["W"], problem.W)
    assert read["spacedim"] == (2 if name == "line" else 3)
    steady = isinstance(scene.motion, vc.Steady)
    assert ("not symmetric" in read["info"]["math_info"]) is steady
    assert np.allclose(problem.W, problem.W.T, atol=1e-12) is not steady


def test_other_forces_do_not():
    problem = vc.friction_problem(BASE)
    r, unknowns = problem.variables_of(vc.solve(BASE, tol=1e-11))
    assert problem.residual(r, unknowns) < 1e-10
    assert problem.residual(0.99 * r, unknowns) > 1e-3
    turned = r.reshape(-1, 3) * [1.0, -1.0, 1.0]
    assert problem.residual(turned.ravel(), unknowns) > 1e-2
    refused(lambda: problem.residual(r[:-1], unknowns), "r")
    refused(lambda: problem.residual(r), "l")


def test_laws_are_held_fixed_with_a_word():
    law = dataclasses.replace(BASE, friction=vc.StaticKinetic(0.3, 0.2))
    problem = vc.friction_problem(law)
    assert "static coefficient" in problem.notes[0]
    assert (problem.mu == 0.3).all()


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"motion": vc.Transient(steps=2, vx=0.01)}, "motion"),
        ({"motion": None, "friction": None}, "motion"),
        ({"friction": np.inf}, "friction"),
        ({"friction": vc.ShearStrength(strength=0.1, coefficient=0.3)}, "friction"),
        ({"third_body": vc.ThirdBody(h=0.1, G=1.0, tau_c0=0.1)}, "third_body.tau_c0"),
        ({"grid": dataclasses.replace(GRID, edge="touched"), "bodies": ALIKE}, "grid.edge"),
    ],
)
def test_refused(changes, field):
    refused(lambda: vc.friction_problem(dataclasses.replace(BASE, **changes)), field)


def test_files_of_others_stay(tmp_path):
    problem = vc.friction_problem(BASE)
    path = tmp_path / "x.hdf5"
    problem.save(path)
    problem.save(path)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["mine"] = np.ones(3)
    refused(lambda: problem.save(tmp_path / "other.h5"), "path", error=OutputError)
    refused(lambda: problem.save(tmp_path / "x.nc"), "path", error=OutputError)
    other = vc.solve(dataclasses.replace(BASE, grid=dataclasses.replace(GRID, nx=9)))
    refused(lambda: problem.save(path, solution=other), "solution")


def test_hertz_closed_form_is_no_solution_of_the_grids_equations(tmp_path):
    """Its residual would be 0.1 and more; the pressure by NORM leaves rounding."""
    alike = dataclasses.replace(BASE, bodies=ALIKE)
    problem = vc.friction_problem(alike)
    closed = vc.solve(alike)
    refused(lambda: problem.variables_of(closed), "solution", 'normal="norm"')
    refused(lambda: problem.save(tmp_path / "x.hdf5", solution=closed), "solution")
    assert not (tmp_path / "x.hdf5").exists()
    r, unknowns = problem.variables_of(vc.solve(alike, normal="norm", tol=1e-11))
    assert problem.residual(r, unknowns) < 1e-10
