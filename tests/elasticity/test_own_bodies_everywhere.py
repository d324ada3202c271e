"""Nothing above the influence numbers knows what bodies are made of: solvers, methods, loops,
certificates, files and pictures with bodies by a symbol, a kernel by rows, and a matrix.
"""

import numpy as np
import pytest

import varcontact as vc
from tests.elasticity.test_own_numbers import SIDE, UNLIKE, N, by_row, matrices, scene
from varcontact.elasticity.anisotropic import rotated_stiffness, transversely_isotropic_stiffness

ZINC = transversely_isotropic_stiffness(4.17, 0.79, 1.26, 1.56, 1.0)
TILTED = rotated_stiffness(ZINC, [[0.8, 0.0, 0.6], [-0.36, 0.8, 0.48], [-0.48, -0.6, 0.64]])
SOFTER = 1 + 0.03 * np.arange(N)
"""Compliance of rows: what changes from place to place."""


def softer_rows():
    weights = np.sqrt(np.multiply.outer(SOFTER, SOFTER))[..., None]
    return vc.Elasticity(kernel=by_row(UNLIKE).kernel.array * weights, sides=(SIDE, SIDE))


def softer_elements():
    """The same, between all elements."""
    root = np.tile(np.sqrt(np.repeat(SOFTER, N)), 3)
    A, C = (each * np.multiply.outer(root, root) for each in matrices(UNLIKE))
    return vc.Elasticity(matrix=(A, C), sides=(SIDE, SIDE))


BODIES = {
    "symbol": vc.Elasticity.of_stiffness(TILTED, "rigid"),
    "rows": softer_rows(),
    "matrix": softer_elements(),
}
NORMAL = ("norm", "newton", "splitting", "osqp")
TANGENTIAL = ("tang-exact", "newton", "splitting", "scs")
METHODS = ("convex", "conic", "active-set", "kalker")
COUPLINGS = ("panagiotopoulos", "joint", "newton", "splitting", "active-set")


@pytest.fixture(scope="module", params=BODIES)
def solved(request):
    """Steady rolling with spin, by the method that is chosen."""
    motion = vc.Steady(vx=5e-3, spin=0.01)
    return vc.solve(scene(BODIES[request.param], friction=0.3, motion=motion))


def close(found, expected, tol=1e-6):
    largest = expected.pressure.max()
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=tol * largest)
    np.testing.assert_allclose(found.traction, expected.traction, atol=tol * largest)
    assert found.certificate.relative_gap < 1e-7
    assert found.certificate.normal_relative_gap < 1e-7


@pytest.mark.long
def test_solvers(solved):
    for name in NORMAL:
        close(vc.solve(solved.scene, normal=name), solved)
    for name in TANGENTIAL:
        close(vc.solve(solved.scene, tangential=name), solved)


@pytest.mark.long
def test_methods_and_coupling_loops(solved):
    for name in METHODS:
        close(vc.solve(solved.scene, method=name), solved, 1e-5)
    for name in COUPLINGS:
        close(vc.solve(solved.scene, coupling=name), solved, 1e-5)


def test_rows_are_their_matrix():
    """A kernel by rows, and the matrix of all its elements."""
    motion = vc.Steady(vx=5e-3, spin=0.01)
    rows, elements = (
        vc.solve(scene(BODIES[name], friction=0.3, motion=motion)) for name in ("rows", "matrix")
    )
    close(rows, elements, 1e-9)
    # softer rows are pressed less
    assert rows.pressure[N // 2 :].sum() < 0.97 * rows.pressure[: N // 2].sum()


def test_certificates_and_files(solved, tmp_path):
    """As of other unlike bodies, no bound on forces; after files as before."""
    assert solved.scene.bodies.coupled
    assert np.isinf(solved.certificate.force_bound).all()
    solved.save(tmp_path / "own.nc")
    again = vc.load(tmp_path / "own.nc")
    assert again.note == "" and again.scene.bodies == solved.scene.bodies
    assert np.array_equal(again.traction, solved.traction)
    certificate = vc.certify(again.scene, again.traction, again.pressure)
    assert certificate.relative_gap == pytest.approx(solved.certificate.relative_gap, abs=1e-12)
    assert "Fx" in solved.report()


@pytest.mark.long
def test_reports_have_pictures(tmp_path):
    found = vc.solve(scene(BODIES["rows"], friction=0.3, motion=vc.Steady(vx=5e-3)))
    found.to_html(tmp_path / "own.html")
    assert "data:image" in (tmp_path / "own.html").read_text()


def test_stresses_are_refused_in_words(solved):
    """Crystals, too: compliances say nothing of what is below."""
    with pytest.raises(vc.SceneError, match="not known"):
        vc.stress_below(solved, depths=[0.1])
