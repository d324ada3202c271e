"""Half of a problem that is its own mirror image has the same solution as the whole."""

import numpy as np
import pytest

import varcontact as vc
from varcontact.discrete import problems as symmetry
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.problems import mirror_of

UNLIKE = vc.Bodies(G=(2.0, 0.7), nu=(0.25, 0.4))
MIRRORED = {
    "vx": ({"motion": vc.Steady(vx=0.05)}, {}),
    "vy and spin": ({"motion": vc.Steady(vy=-0.05, spin=0.1)}, {}),
    "Fx": ({"motion": vc.Steady(Fx=-0.15)}, {}),
    "Fy and spin": ({"motion": vc.Steady(Fy=0.1, spin=0.1)}, {}),
    "shift": ({"motion": vc.Shift(ux=0.05)}, {}),
    "shift by Fy": ({"motion": vc.Shift(Fy=0.1, rotation=0.1)}, {"formulation": "potential"}),
    "no slip": ({"motion": vc.Steady(vx=0.05), "friction": np.inf}, {}),
    "marching": ({"motion": vc.Steady(vx=0.05)}, {"formulation": "marching"}),
    "tang": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "tang"}),
    "tang-safeguarded": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "tang-safeguarded"}),
    "scs": ({"motion": vc.Steady(vx=0.05)}, {"tangential": "scs"}),
    "unlike": ({"motion": vc.Steady(vx=0.05), "bodies": UNLIKE}, {"method": "active-set"}),
}


def mirrors(monkeypatch):
    """The mirror images, or None, of the tangential problems that are solved from now on."""
    found = []
    monkeypatch.setattr(
        "varcontact.solving.contact_solver.mirror_of", lambda problem: found.append(mirror_of(problem)) or found[-1]
    )
    return found


@pytest.mark.parametrize("name", MIRRORED)
def test_half_of_a_problem_has_the_solution_of_the_whole(rolling, monkeypatch, name, check_kkt):
    changes, methods = MIRRORED[name]
    scene = rolling(**changes)
    found = mirrors(monkeypatch)
    half = vc.solve(scene, **methods)
    assert all(found)
    monkeypatch.setattr("varcontact.solving.contact_solver.mirror_of", lambda problem: None)
    whole = vc.solve(scene, **methods)
    largest = np.abs(whole.traction).max()
    np.testing.assert_allclose(half.traction, whole.traction, atol=2e-8 * largest)
    np.testing.assert_allclose(half.creepage, whole.creepage, atol=1e-8)
    check_kkt(half, 1e-8)


@pytest.mark.parametrize(
    "changes",
    [
        {},  # vx with vy and spin
        {"motion": vc.Steady(vx=0.05, vy=1e-6)},
        {"motion": vc.Steady(Fx=-0.1, Fy=0.0)},
        {"motion": vc.Steady(vx=0.05), "grid": vc.Grid(nx=12, ny=13)},
        {"motion": vc.Steady(vx=0.05), "grid": vc.Grid(nx=14, ny=14, dx=0.2, dy=0.15, x0=-1.4, y0=-1.04)},
        {
            "motion": vc.Steady(vx=0.05),
            "friction": np.linspace(0.2, 0.4, 14)[:, None] * np.ones(14),
            "grid": vc.Grid(nx=14, ny=14, dx=0.2, dy=0.15, x0=-1.4, y0=-1.05),
        },
        {"motion": vc.Steady(vy=0.05), "bodies": UNLIKE},
        {"surface": vc.Cylinders(R=1.0), "grid": vc.Grid(nx=20), "motion": vc.Steady(vx=0.05)},
    ],
)
def test_what_is_no_mirror_image_is_solved_whole(rolling, monkeypatch, changes):
    found = mirrors(monkeypatch)
    vc.solve(rolling(**changes))
    assert not any(found)


def test_the_folded_operator_is_the_whole_one_on_mirrored_tractions(rolling):
    """By matrix and by FFT, against the whole matrix on tractions written out on both sides."""
    scene = rolling(motion=vc.Steady(vy=0.05), grid=vc.Grid(nx=14, ny=14, dx=0.2, dy=0.15, x0=-1.4, y0=-1.05))
    disc = discretise(scene, scene.grid)
    pressure = disc.hertz.pressure(disc.grid.x[None, :], disc.grid.y[:, None])
    posed = disc.tangential_problem(pressure)
    mirror = mirror_of(posed)
    assert mirror.signs == (-1.0, 1.0)
    half = np.random.default_rng(1).normal(size=(2, posed.size // 2))
    whole = np.zeros((2, posed.size))
    whole[:, mirror.half], whole[:, mirror.images] = half, half * [[-1.0], [1.0]]
    expected = (posed.operator.matrix @ whole.ravel()).reshape(2, -1)
    np.testing.assert_allclose(expected[:, mirror.images], expected[:, mirror.half] * [[-1.0], [1.0]], atol=1e-12)
    folded = mirror.fold(posed).operator
    np.testing.assert_allclose((folded.matrix @ half.ravel()).reshape(2, -1), expected[:, mirror.half], atol=1e-12)
    np.testing.assert_allclose(folded.apply(half), expected[:, mirror.half], atol=1e-12)
    assert symmetry.mirror_of(mirror.fold(posed)) is None
