"""Newton's method without a matrix within loops: unlike bodies, laws of friction, histories. The
dense answers.
"""

import dataclasses
import math

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.operators import GridOperator
from varcontact.solvers import registry
from varcontact.solvers.newton import kernel
from varcontact.solving import contact_solver

DENSE, NEWTON = (
    {"normal": pair[0], "tangential": pair[1]}
    for pair in (("norm", "tang-safeguarded"), ("newton",) * 2)
)
FORCE = 1e-3
MIXED = vc.Bodies(G=(1.0, 3.0), nu=(0.1, 0.3))
LAWS = [
    vc.StaticKinetic(static=0.3, kinetic=0.2),
    vc.ExponentialFalling(static=0.3, kinetic=0.2, half_velocity=4e-3),
    vc.RationalFalling(static=0.3, kinetic=0.1, half_velocity=4e-3),
]


def ball(**changes):
    """A ball that rolls on a plane."""
    base = {
        "bodies": MIXED,
        "surface": vc.Paraboloids(1.0, 1.0),
        "normal_force": FORCE,
        "friction": 0.3,
    }
    motion = vc.Steady(vx=4e-3, vy=-2e-3, spin=0.05)
    return vc.Scene(**{**base, "motion": motion, "grid": vc.Grid(nx=9, ny=8), **changes})


def check_same(one, other):
    """Tractions and pressures, to 1e-7 of the largest bound and pressure."""
    bound = float(np.max(other.traction_bound))
    np.testing.assert_allclose(one.traction, other.traction, rtol=0, atol=1e-7 * bound)
    np.testing.assert_allclose(
        one.pressure, other.pressure, rtol=0, atol=1e-7 * other.pressure.max()
    )
    assert one.certificate.residual <= 1e-8


@pytest.mark.long
@pytest.mark.parametrize("coupling", ["newton", "splitting"])
def test_both_together_where_passes_converge_slowly(coupling):
    """K = 0.5, f = 2, half of what friction can carry: 40 passes, and those only with
    acceleration.
    """
    bodies, grid = vc.Bodies(G=(1.0, math.inf), nu=(0.0, 0.3)), vc.Grid(nx=30)
    scene = ball(
        bodies=bodies,
        surface=vc.Cylinders(R=1.0),
        grid=grid,
        friction=2.0,
        motion=vc.Steady(Fx=-1e-3),
    )
    found = vc.solve(scene, coupling=coupling)
    dense = vc.solve(scene, coupling="panagiotopoulos", **DENSE)
    check_same(found, dense)
    assert (len(found.passes), len(dense.passes) > 20) == (1, True)


@pytest.mark.parametrize("failing", ["nothing", "no number", "far away"])
@pytest.mark.parametrize("coupling", ["newton", "splitting"])
def test_where_both_together_fail_passes_go_on(monkeypatch, coupling, failing):
    wrong = {"nothing": 0.0, "no number": np.nan, "far away": 3.0}[failing]

    def failed(problem, settings, start, residual):
        return dataclasses.replace(
            start, traction=wrong * start.traction, solved=False, status="MaxIterations"
        )

    module = f"varcontact.solvers.{coupling}.coupled"
    monkeypatch.setattr(f"{module}.{coupling}_coupled", failed)
    sol = vc.solve(ball(), coupling=coupling)
    check_same(sol, vc.solve(ball(), **DENSE))
    assert len(sol.passes) > 3


@pytest.mark.parametrize(
    "changes", [{}, {"bodies": vc.Bodies(G=1.0, nu=0.28), "friction": LAWS[1]}]
)
def test_no_pass_asks_for_more_than_the_next_one_sees(monkeypatch, changes):
    """Within passes accuracy grows with theirs; from one to the next nothing begins anew."""
    asked, newton = [], registry.SOLVERS["tangential", "newton"]

    def asking(problem, settings, start):
        asked.append((settings.tol, start is None))
        return newton.solve(problem, settings, start)

    spy = dataclasses.replace(newton, solve=asking)
    monkeypatch.setitem(registry.SOLVERS, ("tangential", "newton"), spy)
    methods = {} if changes else {"normal": "newton", "coupling": "panagiotopoulos"}
    sol = vc.solve(ball(**changes), tangential="newton", **methods)
    residuals = [residual for _, residual in sol.passes]
    assert asked[0] == (contact_solver.FIRST_TOL, True)
    assert not any(anew for _, anew in asked[1:])
    for (tol, _), residual in zip(asked[1:], residuals, strict=False):
        assert tol == pytest.approx(max(0.01 * residual, 1e-10), rel=1e-12)
    assert sol.certificate.residual == pytest.approx(residuals[-1], rel=1e-3)


@pytest.mark.parametrize("coupling", ["panagiotopoulos", "joint", "newton"])
def test_passes_form_no_matrix(built, monkeypatch, coupling):
    kernels, make = [], kernel.Kernel

    def refuse(*_):
        raise AssertionError("a dense matrix was assembled")

    def made(numbers, *period):
        kernels.append(numbers.shape)
        return make(numbers, *period)

    monkeypatch.setattr(GridOperator, "dense", refuse)
    monkeypatch.setattr(kernel, "Kernel", made)
    sol = vc.solve(ball(grid=vc.Grid(nx=27, ny=26)), **NEWTON, coupling=coupling)
    assert sorted(name for name, _ in built) == ["A_tt - C_tt", "A_tz - C_tz", "A_zt", "A_zz"]
    assert len(kernels) == len(set(kernels))
    assert len(sol.passes) > 3 or coupling == "newton"


def test_changed_pressures_are_new_to_every_pass():
    """A pass under the pressures of the one before would end at Johnson's answer."""
    whole, johnson = (
        vc.solve(ball(), **NEWTON, coupling=coupling) for coupling in ("panagiotopoulos", "johnson")
    )
    assert np.abs(whole.pressure - johnson.pressure).max() > 1e-3 * whole.pressure.max()
    assert whole.certificate.residual < 1e-8 < johnson.certificate.residual
