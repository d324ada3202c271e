"""The roads as one choice, and who is called on each: counted where solvers are called, not where
they are chosen.
"""

import json

import numpy as np
import pytest

import varcontact as vc
from tests.test_every_kind import KINDS
from varcontact.data.benchmark_scenes import unlike_bank
from varcontact.solving.options import TOLERANCE

SOLVERS = {"convex": {"splitting"}, "conic": {"clarabel", "splitting"}}
ACTIVE = {"norm", "tang-safeguarded", "tang", "splitting", "active-set"}
UNLIKE = unlike_bank(cells=6)
CELLS = vc.Grid(nx=8, ny=8)


def called(sol, problem=None):
    """Names of all solvers that were called, for one problem or for all."""
    return {
        name for each, solvers in sol.calls.items() if problem in (None, each) for name in solvers
    }


def friction_force(sol):
    return float(sol.traction_bound.sum() * sol.grid.area)


def check_convex(scene, method):
    """Converged to its tolerance by the method's solvers alone, with the forces of active sets."""
    sol, other = vc.solve(scene, method=method), vc.solve(scene, method="active-set")
    assert sol.converged
    assert sol.certificate.residual <= TOLERANCE
    assert called(sol) - {"hertz"} == SOLVERS[method]
    assert called(other) - {"hertz"} <= ACTIVE
    assert np.hypot(*(sol.force - other.force)) < 1e-6 * friction_force(other)
    np.testing.assert_allclose(sol.creepage, other.creepage, rtol=1e-6, atol=1e-9)
    return sol


@pytest.mark.parametrize("name", UNLIKE)
@pytest.mark.parametrize("method", SOLVERS)
def test_convex_on_unlike_bodies(name, method):
    """Every pass by the method's own solver; splitting finds both at once."""
    sol = check_convex(UNLIKE[name], method)
    if method == "convex":
        assert sol.plan.coupling == "splitting"
        assert sol.calls["both"]["splitting"].count == len(sol.passes) == 1
        return
    assert sol.plan.coupling == "panagiotopoulos"
    for problem in ("normal", "tangential"):
        solver = getattr(sol.plan, problem)
        assert sol.calls[problem][solver].count >= len(sol.passes) > 1


@pytest.mark.parametrize("method", SOLVERS)
def test_convex_history(rolling, method):
    scene = rolling(motion=vc.Transient(steps=3, vx=0.04, spin=0.05), grid=vc.Grid(nx=6, ny=6))
    history = vc.solve(scene, method=method)
    for step, other in zip(history, vc.solve(scene, method="active-set"), strict=True):
        assert called(step, "tangential") == SOLVERS[method]
        assert step.calls["tangential"][step.plan.tangential].count == 1
        np.testing.assert_allclose(step.force, other.force, atol=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_by_splitting(kind):
    """Scenes of every kind have the solution of "auto"; Hertz's pressure may be in closed form."""
    scene = KINDS[kind]
    sol, other = vc.solve(scene, method="convex"), vc.solve(scene)
    if isinstance(sol, vc.History):
        sol = sol[-1]
        other = other[-1]
    assert called(sol) <= {"splitting", "hertz"}
    largest = np.abs(other.pressure).max()
    np.testing.assert_allclose(sol.pressure, other.pressure, rtol=0, atol=1e-6 * largest)
    if other.plan.has_friction:
        largest = np.abs(other.traction).max()
        np.testing.assert_allclose(sol.traction, other.traction, rtol=0, atol=2e-6 * largest)


@pytest.mark.long
def test_conic_march(rolling):
    """Where the gap is not convex, it is refused, with what to ask for instead; and that has the
    solution, which splitting has, too.
    """
    a, b = np.sqrt(5), 1 / np.sqrt(5)
    motion = vc.Steady(vx=0.03, spin=0.03, dq=0.4 * 2 * a / 6)
    scene = rolling(surface=vc.Ellipse(a=a, b=b), motion=motion, grid=vc.Grid(nx=6, ny=6))
    with pytest.raises(
        vc.SceneError, match="the gap is not found to be convex for elements so long"
    ) as refusal:
        vc.solve(scene, method="conic")
    assert refusal.value.field == "formulation"
    assert '"marching", or a longer motion.dq' in str(refusal.value)
    exact = vc.solve(scene).force
    for method in SOLVERS:
        sol = vc.solve(scene, method=method, formulation="marching")
        assert called(sol, "tangential") == SOLVERS[method]
        np.testing.assert_allclose(sol.force, exact, atol=1e-6 * friction_force(sol))
    sol = vc.solve(scene, method="convex")
    np.testing.assert_allclose(sol.force, exact, atol=1e-6 * friction_force(sol))


def test_kalker_is_as_printed(rolling):
    """NORM and TANG with Newton's method to the end, nobody else: where that fails, it fails."""
    scene = rolling(bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3)), grid=CELLS)
    sol = vc.solve(scene, method="kalker")
    assert (called(sol, "normal"), called(sol, "tangential")) == ({"norm"}, {"tang-exact"})
    assert sol.plan.tangential == "tang-exact"
    np.testing.assert_allclose(sol.force, vc.solve(scene).force, atol=1e-8)


def test_a_gap_that_is_not_convex_says_who_solved_it(rolling):
    """Clarabel is not called at all: then nothing says that it solved anything."""
    a, b = np.sqrt(5), 1 / np.sqrt(5)
    motion = vc.Steady(vx=0.04, vy=-0.02, spin=0.05, dq=0.4 * 2 * a / 8)
    sol = vc.solve(
        rolling(surface=vc.Ellipse(a=a, b=b), motion=motion, grid=CELLS), tangential="clarabel"
    )
    assert "clarabel" not in sol.calls["tangential"]
    assert sol.solved_by["tangential"] == "tang-safeguarded"
    why = "the gap is not found to be convex here, so tang-safeguarded was used"
    assert sol.plan.reasons["tangential"] == f"requested; {why}"
    assert f"clarabel: requested; {why}; solved by tang-safeguarded" in sol.report()
    count = sol.calls["tangential"]["tang-safeguarded"]
    assert f"tangential: tang-safeguarded once ({count.iterations} iterations)" in sol.report()


@pytest.mark.long
def test_files_from_before_calls_were_counted_load(rolling, tmp_path):
    sol = vc.solve(rolling(grid=CELLS))
    data = sol.to_xarray()
    record = json.loads(str(data["record"].values))
    for name in ("calls", "solved_by"):
        del record[name]
    del record["plan"]["method"]
    del record["plan"]["reasons"]["method"]
    data.assign(record=((), json.dumps(record))).to_netcdf(tmp_path / "old.nc", engine="h5netcdf")
    old = vc.load(tmp_path / "old.nc")
    assert (old.calls, old.solved_by, old.plan.method) == ({}, {}, "auto")
    assert old.report().count("tang-safeguarded: active sets") == 1
    np.testing.assert_array_equal(old.traction, sol.traction)


@pytest.mark.parametrize(
    ("arguments", "field", "words"),
    [
        (
            {"method": "konvex"},
            "method",
            "one of auto, convex, conic, active-set, kalker (did you mean convex?)",
        ),
        ({"method": 3}, "method", "one of auto, convex, conic, active-set, kalker"),
        (
            {"method": "conic", "tangential": "scs"},
            "tangential",
            'clarabel with method = "conic"; with method = "auto" any solver may be named',
        ),
        (
            {"method": "conic", "normal": "norm"},
            "normal",
            "clarabel or osqp with",
        ),
        ({"method": "convex", "tangential": "clarabel"}, "tangential", "splitting with"),
        ({"method": "convex", "tangential": "clarable"}, "tangential", "did you mean clarabel?"),
        (
            {"method": "active-set", "tangential": "clarabel"},
            "tangential",
            'tang or tang-exact or tang-safeguarded with method = "active-set"',
        ),
        ({"method": "active-set", "normal": "osqp"}, "normal", "norm or norm-single with"),
        (
            {"method": "kalker", "tangential": "tang"},
            "tangential",
            'tang-exact with method = "kalker";',
        ),
        (
            {"method": "kalker", "formulation": "gap"},
            "formulation",
            "tang-exact does not solve a program",
        ),
        (
            {"method": "convex", "polish": True},
            "polish",
            'left out: method = "convex" calls no active sets',
        ),
        ({"method": "convex", "polish": 1}, "polish", "true or false"),
    ],
)
def test_contradictions_are_refused(rolling, arguments, field, words):
    with pytest.raises(vc.SceneError) as refusal:
        vc.solve(rolling(), **arguments)
    assert refusal.value.field == field
    assert words in str(refusal.value)


def test_plan_and_scan_take_a_method(rolling):
    scene = rolling(grid=CELLS)
    planned, sol = vc.plan(scene, method="convex"), vc.solve(scene, method="convex")
    assert (planned.normal, planned.tangential, planned.method) == ("hertz", "splitting", "convex")
    why = (
        "requested: the convex problems by splitting, proved to converge wherever the symmetric "
        "part is positive definite"
    )
    assert planned.reasons["method"] == why
    assert f"  method              convex: {planned.reasons['method']}" in str(planned)
    assert f"  method            convex: {planned.reasons['method']}" in sol.report()
    curve = vc.scan(scene, [(0.02, 0.0, 0.0), (0.04, -0.02, 0.05)], method="convex")
    assert all(each.calls["tangential"]["splitting"].count == 1 for each in curve)
    np.testing.assert_allclose(curve[1].traction, sol.traction, atol=1e-8)
    with pytest.raises(vc.SceneError, match="polish = True"):
        vc.scan(scene, [(0.02, 0.0, 0.0)], method="convex", polish=True)
