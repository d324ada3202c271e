"""Bodies by influence numbers of one's own, and by matrices: against the same bodies of the package,
in files, and what is refused.
"""

import warnings
from dataclasses import replace

import numpy as np
import pytest

import varcontact as vc
from varcontact.elasticity.of_scenes import medium_of, medium_on
from varcontact.elasticity.shear_layer import ShearLayer
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Grid

N = 10
SIDE = 0.028
ALIKE = vc.Bodies(1.0, 0.28)
UNLIKE = vc.Bodies(G=(1.0, 2.5), nu=(0.25, 0.4))
EVERY = np.arange(N * N)


def table(bodies, nx=N + 3, ny=N, line=False):
    lattice = Grid(nx=nx, ny=ny, dx=SIDE, dy=SIDE, x0=0.0, y0=0.0)
    if line:
        lattice = Grid(nx=nx, dx=SIDE, x0=0.0)
    return medium_of(bodies, 1.0, 4.0).operator(lattice, "xyz", "xyz").table / bodies.combined_G


def kernel(bodies, **changes):
    return vc.Elasticity(kernel=table(bodies, **changes), sides=(SIDE, SIDE))


def by_row(bodies):
    """The same numbers between all rows."""
    of_offset = table(bodies)
    rows = np.arange(N)
    numbers = of_offset[:, :, rows[:, None] - rows + N - 1]
    return vc.Elasticity(kernel=numbers, sides=(SIDE, SIDE))


def matrices(bodies):
    lattice = Grid(nx=N, ny=N, dx=SIDE, dy=SIDE, x0=0.0, y0=0.0)
    medium = medium_of(bodies, 1.0, 4.0)
    A, C = (
        medium.operator(lattice, "xyz", "xyz", ((ahead, 1.0),)).dense(EVERY) / bodies.combined_G
        for ahead in (0.0, SIDE)
    )
    return A, C


def matrix(bodies):
    return vc.Elasticity(matrix=matrices(bodies), sides=(SIDE, SIDE))


def scene(bodies, **changes):
    x = (np.arange(N) - (N - 1) / 2) * SIDE
    corner = -N * SIDE / 2
    entries = {
        "bodies": bodies,
        "surface": vc.SampledDistance((x**2 + x[:, None] ** 2) / 2),
        "normal_force": 1e-3,
        "grid": vc.Grid(nx=N, ny=N, dx=SIDE, dy=SIDE, x0=corner, y0=corner),
    }
    return vc.Scene(**{**entries, **changes})


MOTIONS = [
    None,
    vc.Shift(ux=1e-3),
    vc.Steady(vx=5e-3, spin=0.01),
    vc.Steady(Fx=-1e-4),
    vc.Transient(steps=3, vx=3e-3),
]


@pytest.mark.parametrize(
    ("make", "motion"),
    [(make, motion) for make in (kernel, by_row) for motion in MOTIONS]
    + [(matrix, motion) for motion in MOTIONS[:-1]],
)
@pytest.mark.parametrize("known", [ALIKE, UNLIKE], ids=["alike", "unlike"])
def test_half_spaces_by_their_numbers_are_half_spaces(make, known, motion):
    own = make(known)
    assert own.combined_G == pytest.approx(known.combined_G, rel=1e-12)
    assert own.combined_nu == pytest.approx(known.combined_nu, rel=1e-12)
    friction = None if motion is None else 0.3
    options = {"tol": 1e-11, "certify": "full"} if motion is not None else {}
    found, expected = (
        vc.solve(scene(bodies, friction=friction, motion=motion), **options)
        for bodies in (own, known)
    )
    if isinstance(motion, vc.Transient):
        found, expected = found[-1], expected[-1]
    largest = expected.pressure.max()
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-10 * largest)
    np.testing.assert_allclose(found.traction, expected.traction, atol=1e-10 * largest)
    assert found.friction_work == pytest.approx(expected.friction_work, rel=1e-8, abs=1e-15)
    if motion is not None and known is ALIKE:
        assert np.max(found.certificate.force_bound) < 1e-10


@pytest.mark.parametrize("name", ["tang-safeguarded", "newton", "clarabel", "splitting"])
@pytest.mark.parametrize("make", [kernel, matrix])
def test_solvers_agree(make, name):
    rolling = scene(make(ALIKE), friction=0.3, motion=vc.Steady(vx=5e-3, spin=0.01))
    expected = vc.solve(replace(rolling, bodies=ALIKE))
    found = vc.solve(rolling, tangential=name, normal="clarabel" if name == "clarabel" else "norm")
    np.testing.assert_allclose(
        found.traction, expected.traction, atol=1e-8 * expected.pressure.max()
    )
    assert found.certificate.relative_gap < 1e-7


def test_kernels_of_line_contact():
    """Displacements as they are, from the depth that they were made with."""
    grid = vc.Grid(nx=40, dx=SIDE, x0=-20 * SIDE)
    lattice = Grid(nx=41, dx=SIDE, x0=0.0)
    numbers = medium_of(ALIKE, 1.0, 7.0).operator(lattice, "xyz", "xyz").table
    own = vc.Elasticity(kernel=numbers, sides=(SIDE,))
    assert own.combined_nu == pytest.approx(0.28, rel=1e-10)
    line = {"friction": 0.3, "motion": vc.Steady(vx=2e-3), "approach": 0.05, "grid": grid}
    h = grid.x**2 / 2
    expected = vc.solve(
        vc.Scene(bodies=ALIKE, surface=vc.SampledDistance(h, reference_depth=7.0), **line)
    )
    found = vc.solve(vc.Scene(bodies=own, surface=vc.SampledDistance(h), **line))
    assert found.normal_force == pytest.approx(expected.normal_force, rel=1e-9)
    assert found.Fx == pytest.approx(expected.Fx, rel=1e-8)


def test_pressures_alone():
    """A matrix of normal displacements, from nodes in any order."""
    A, _ = matrices(ALIKE)
    zz = A.reshape(3, N * N, 3, N * N)[2, :, 2]
    x, y = (each.ravel() for each in np.meshgrid(*[np.arange(N) * SIDE] * 2))
    mixed = np.random.default_rng(0).permutation(N * N)
    nodes = np.stack([x, y], axis=1)[mixed]
    own = vc.Elasticity.from_compliance(nodes, zz[np.ix_(mixed, mixed)])
    assert own.sides == pytest.approx((SIDE, SIDE))
    found = vc.solve(scene(own))
    expected = vc.solve(scene(ALIKE))
    np.testing.assert_allclose(
        found.pressure, expected.pressure, atol=1e-10 * expected.pressure.max()
    )
    assert found.certificate.normal_residual < 1e-10
    with pytest.raises(vc.SceneError, match="tractions need their own numbers"):
        scene(own, friction=0.3, motion=vc.Shift(ux=1e-3))


def test_a_curved_surface_by_its_rows():
    """Numbers that depend on both rows, of a surface whose curvature varies (conformal)."""
    angles = 0.2 * np.sin(np.linspace(-1.0, 1.4, N))
    curved = scene(ALIKE, normal_force=None, approach=8e-3, friction=0.3, motion=vc.Steady(vx=5e-3))
    curved = replace(curved, surface=vc.SampledDistance(curved.surface.samples, inclination=angles))
    lattice = vc.Grid(nx=N + 1, ny=N, dx=SIDE, dy=SIDE, x0=0.0, y0=curved.grid.y0)
    operator = medium_on(curved, lattice, 1.0, None, None).operator(lattice, "xyz", "xyz")
    numbers = np.empty((3, 3, N, N, 2 * N + 1))
    # from the first column to all, and from the last one back
    for column, part in ((0, slice(N, None)), (N, slice(None, N + 1))):
        loaded = np.arange(N) * (N + 1) + column
        block = operator.dense(np.arange(lattice.size), loaded).reshape(3, N, N + 1, 3, N)
        numbers[..., part] = np.einsum("iaxjb->ijabx", block)
    own = vc.Elasticity(kernel=numbers / ALIKE.combined_G, sides=(SIDE, SIDE))
    plane = vc.SampledDistance(curved.surface.samples)
    found = vc.solve(replace(curved, bodies=own, surface=plane))
    expected = vc.solve(curved)
    largest = expected.pressure.max()
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-9 * largest)
    np.testing.assert_allclose(found.traction, expected.traction, atol=1e-9 * largest)
    assert np.abs(found.traction[1]).max() > 1e-3 * largest
    assert found.certificate.residual < 1e-9
    with pytest.raises(vc.SceneError, match="curvature and layers in their numbers"):
        replace(curved, bodies=own)


@pytest.mark.parametrize("parts", [("xyz", "xyz"), ("z", "z"), ("xy", "z")])
def test_products_by_rows_are_those_of_the_matrix(parts):
    """Of rows that give way differently, with and without transposition."""
    numbers = (
        by_row(UNLIKE).kernel.array
        * np.sqrt(np.multiply.outer(*[np.arange(1, N + 1)] * 2))[..., None]
    )
    own = vc.Elasticity(kernel=numbers, sides=(SIDE, SIDE)).medium(1.0, 4.0)
    lattice = Grid(nx=N, ny=N, dx=SIDE, dy=SIDE, x0=0.0, y0=0.0)
    operator = own.operator(lattice, *parts)
    matrix = operator.dense(EVERY)
    field = np.random.default_rng(1).normal(size=(len(parts[1]), N, N))
    expected = matrix @ field.ravel()
    scale = np.abs(expected).max()
    np.testing.assert_allclose(operator._product(field).ravel(), expected, atol=1e-12 * scale)
    single = operator.apply(field.astype(np.float32))
    assert single.dtype == np.float32
    np.testing.assert_allclose(single.ravel(), expected, atol=1e-5 * scale)
    np.testing.assert_allclose(operator.transposed.dense(EVERY), matrix.T, atol=1e-15 * scale)
    assert np.linalg.norm(matrix, 2) <= operator.norm
    assert operator.smallest == matrix.min() and operator.largest == matrix.max()
    some = np.array([3, 40, 81])
    assert np.array_equal(
        operator.dense(some, EVERY),
        matrix.reshape(-1, N * N, matrix.shape[1])[:, some].reshape(-1, matrix.shape[1]),
    )


def test_bodies_that_differ_from_place_to_place():
    """A stiffer half: what a kernel cannot have, against the dense problem itself."""
    A, _ = matrices(ALIKE)
    zz = A.reshape(3, N * N, 3, N * N)[2, :, 2]
    soft = 1 + 0.5 * (EVERY % N < N // 2)
    own_numbers = zz * np.sqrt(soft[:, None] * soft)
    own = vc.Elasticity(matrix=own_numbers, sides=(SIDE, SIDE), components="z")
    found = vc.solve(scene(own))
    p = found.pressure.ravel()
    distance = scene(own).surface.samples.ravel() + own_numbers @ p - found.approach
    scale = np.abs(distance).max()
    assert np.abs(distance[p > 0]).max() < 1e-9 * scale and distance.min() > -1e-9 * scale
    assert found.certificate.normal_relative_gap < 1e-9


@pytest.mark.parametrize("make", [by_row, matrix])
def test_numbers_by_place_have_no_linear_response(make):
    """Which is by wave numbers, of bodies that are the same everywhere; they have gradients."""
    found, expected = (
        vc.solve(scene(bodies, friction=0.3, motion=vc.Steady(vx=1e-3)))
        for bodies in (make(UNLIKE), UNLIKE)
    )
    with pytest.raises(vc.SceneError, match="bodies alike everywhere"):
        found.frequency_response([3.0])
    by_friction = [each.gradient("Fx", "friction")["friction"] for each in (found, expected)]
    assert by_friction[0] == pytest.approx(float(by_friction[1]), rel=1e-6)
    with pytest.raises(vc.SceneError, match="friction work of unlike bodies"):
        found.gradient("friction_work", "friction")


def test_matrices_without_symmetry_are_solved_without_bounds():
    A, C = matrices(ALIKE)
    A = A.copy()
    A[2 * N * N + 45, 2 * N * N + 46] *= 1.01
    with pytest.warns(vc.PlausibilityWarning, match=r"not symmetric: .* at \[2"):
        own = vc.Elasticity(matrix=(A, C), sides=(SIDE, SIDE))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = vc.solve(scene(own))
    assert found.certificate.normal_residual < 1e-9


@pytest.mark.parametrize("make", [kernel, matrix])
def test_files_keep_the_numbers(make, tmp_path):
    own = make(ALIKE)
    found = vc.solve(scene(own, friction=0.3, motion=vc.Steady(vx=5e-3)))
    found.save(tmp_path / "own.nc")
    again = vc.load(tmp_path / "own.nc")
    assert again.note == "" and again.scene.bodies == own
    assert again.certificate.residual == pytest.approx(found.certificate.residual, abs=1e-14)
    if make is kernel:
        np.save(tmp_path / "numbers.npy", own.kernel.array)
        found.scene.save(tmp_path / "own.toml")
        text = (tmp_path / "own.toml").read_text()
        first = text.index("kernel = ")
        by_name = text[:first] + 'kernel = { file = "numbers.npy" }\n'
        rest = text[text.index("\n", first) + 1 :]
        (tmp_path / "by_name.toml").write_text(by_name + rest)
        for name in ("own.toml", "by_name.toml"):
            assert vc.read_scene(tmp_path / name)[0].bodies == own


# ----------------------------------------------------------------------------- files of CONTACT


def contact_file(path, numbers, cut=None):
    """Numbers for a modulus of 1, as CONTACT reads them."""
    ny, nx = ((size + 1) // 2 for size in numbers.shape[2:])
    lines = ["1 2   % nmatrix, iaconvx", "0 312", "1 0", f"{nx} {ny} {SIDE} {SIDE}"]
    for row in range(2 * ny - 1):
        lines += [f"% iy = {row - ny + 1}", "ix x  ann anx any axn axx axy ayn ayx ayy"]
        for ix in range(nx):
            block = numbers[:, :, row, nx - 1 + ix][np.ix_([2, 0, 1], [2, 0, 1])]
            values = " ".join(f"{value:.16e}" for value in block.ravel())
            lines.append(f"{ix} {ix * SIDE:.6f} {values}")
    path.write_text("\n".join(lines[:cut]) + "\n")
    return path


def test_files_of_contact_are_kernels(tmp_path):
    expected = table(UNLIKE) * UNLIKE.combined_G
    path = contact_file(tmp_path / "numbers.txt", expected)
    own = vc.read_influence_numbers(path, G=UNLIKE.combined_G)
    np.testing.assert_allclose(own.kernel.array, table(UNLIKE), atol=1e-15)
    assert own.sides == (SIDE, SIDE)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[: len(text) // 2].rpartition("\n")[0], r"line \d+: the file ends here"),
        (lambda text: text.replace("1 2 ", "3 2 ", 1), "line 1: 3 matrices"),
        (lambda text: text.replace("0 312", "1 312", 1), "line 2: must be 0 312"),
        (lambda text: text.replace("\n1 0\n", "\n0 0\n", 1), "line 3: must be 1 0"),
        (lambda text: text.replace("\n1 0.028", "\n2 0.028", 1), "line 8: begins with 2 0.028"),
        (lambda text: text.replace("e-02", "e-0x", 1), r"line \d+: .* are no numbers"),
        (lambda text: "", "line 0: the file ends"),
    ],
)
def test_files_of_contact_that_are_refused(change, words, tmp_path):
    path = contact_file(tmp_path / "numbers.txt", table(ALIKE, nx=4, ny=2))
    path.write_text(change(path.read_text()))
    with pytest.raises(vc.SceneError, match=words):
        vc.read_influence_numbers(path, G=1.0)


# ----------------------------------------------------------------------------- what is refused


def changed(numbers, place, value):
    numbers = numbers.copy()
    numbers[place] = value
    return numbers


def by_kernel(numbers, sides=(SIDE, SIDE), **more):
    return lambda: vc.Elasticity(kernel=numbers, sides=sides, **more)


def by_matrix(*given, sides=(SIDE, SIDE)):
    return lambda: vc.Elasticity(matrix=given, sides=sides)


GOOD = table(ALIKE)
ROWS = by_row(ALIKE).kernel.array
ROLLING = {"friction": 0.3, "motion": vc.Steady(vx=1e-3)}


@pytest.mark.parametrize(
    ("make", "field", "words"),
    [
        (by_kernel(GOOD[:2]), "bodies.kernel", "shape"),
        (by_kernel(GOOD[..., :-1]), "bodies.kernel", "2 nx - 1"),
        (by_kernel(changed(GOOD, (2, 2, 3, 4), 7.0)), "bodies.kernel[2, 2, 3, 4]", "Betti"),
        (by_kernel(np.abs(GOOD) * 0 + np.nan), "bodies.kernel[0, 0, 0, 0]", "finite"),
        (by_kernel(-GOOD), "bodies.kernel", "positive definite"),
        (by_kernel(ROWS[:, :, :-1]), "bodies.kernel", "ny, ny"),
        (
            by_kernel(changed(ROWS, (0, 2, 3, 4, 5), 7.0)),
            "bodies.kernel[0, 2, 3, 4, 5]",
            rf"\[2, 0, 4, 3, {2 * N + 5 - 6}\]",
        ),
        (by_kernel(-ROWS), "bodies.kernel, row 0", "positive definite"),
        (
            lambda: vc.solve(
                scene(
                    by_kernel(ROWS)(),
                    surface=vc.SampledDistance(np.ones((N - 2, N))),
                    grid=vc.Grid(nx=N, ny=N - 2, dx=SIDE, dy=SIDE, x0=0.0, y0=0.0),
                )
            ),
            "bodies.kernel",
            "between 10 rows of 13 elements; this grid and motion need 8 rows",
        ),
        (by_kernel(GOOD, sides=None), "bodies.sides", "missing"),
        (by_kernel(GOOD, sides=(1.0, 2.0, 3.0)), "bodies.sides", "dx, dy"),
        (by_kernel(GOOD, components="x"), "bodies.components", "one of xyz, z"),
        (lambda: vc.Elasticity(), None, "neither"),
        (lambda: vc.Elasticity(kernel=GOOD, matrix=np.eye(3)), None, "both given"),
        (by_matrix(np.eye(7)), "bodies.matrix[0]", "shape"),
        (by_matrix(np.eye(6), np.eye(9)), "bodies.matrix[1]", "the same of A and C"),
        (by_matrix(-np.eye(6)), "bodies.matrix[0], element 0", "positive definite"),
        (by_matrix(*[np.eye(6)] * 3), "bodies.matrix", "A, or"),
        (lambda: scene(kernel(ALIKE), grid=vc.Grid(nx=8, ny=8)), "grid", "explicit"),
        (
            lambda: scene(vc.Elasticity(kernel=GOOD, sides=(SIDE, 0.03))),
            "bodies.sides",
            "sides of the grid",
        ),
        (
            lambda: vc.solve(scene(kernel(ALIKE, nx=N), **ROLLING)),
            "bodies.kernel",
            "need 11 columns",
        ),
        (
            lambda: vc.solve(
                scene(kernel(ALIKE), friction=0.3, motion=vc.Steady(vx=1e-3, dq=0.5 * SIDE))
            ),
            "motion.dq",
            "no numbers between",
        ),
        (
            lambda: scene(by_matrix(matrices(ALIKE)[0])(), **ROLLING),
            "bodies.matrix",
            "where particles come from",
        ),
        (
            lambda: scene(matrix(ALIKE), friction=0.3, motion=vc.Transient(steps=2, vx=1e-3)),
            "motion",
            "no numbers for histories",
        ),
        (lambda: scene(by_matrix(np.eye(6))()), "grid", "of 2 elements"),
        (
            lambda: scene(matrix(ALIKE), third_body=vc.ThirdBody(G=1.0, h=0.1)),
            "bodies.matrix",
            "layers in their numbers",
        ),
        (
            lambda: vc.Elasticity.from_compliance([0.0, 0.1, 0.3], np.eye(3)),
            "nodes",
            "equal distances",
        ),
        (
            lambda: vc.Elasticity.from_compliance([[0, 0], [0, 1], [1, 0]], np.eye(3)),
            "nodes",
            "a full lattice, 4",
        ),
        (lambda: vc.Elasticity.from_compliance([0, 1], np.eye(5)), "matrix", "shape"),
        (
            lambda: vc.stress_below(vc.solve(scene(kernel(ALIKE))), depths=[0.1]),
            "body",
            "not known",
        ),
    ],
)
def test_what_is_refused(make, field, words):
    with pytest.raises(vc.SceneError, match=words) as error:
        make()
    assert field is None or error.value.field == field


class _InStep(GivenBodies):
    """A pair whose medium has no numbers of a period."""

    combined_G = 1.0
    combined_nu = 0.28
    K = 0.0
    softest = ALIKE

    def check(self, scene):
        """Every scene."""

    def reaches(self, grid):
        return True

    def medium(self, length, depth):
        return ShearLayer(medium_of(ALIKE, length, depth), 0.1)


def test_bodies_without_numbers_of_a_period_are_refused():
    grid = vc.Grid(nx=8, ny=8, dx=0.1, dy=0.1, x0=0.0, y0=0.0, periodic=True)
    rough = vc.SampledDistance(np.random.default_rng(5).random((8, 8)))
    scene = vc.Scene(bodies=_InStep(), surface=rough, normal_force=0.1, grid=grid)
    with pytest.raises(vc.SceneError) as refused:
        vc.solve(scene)
    assert refused.value.field == "grid.periodic"
