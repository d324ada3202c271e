"""The table book: its ends in closed form, its symmetries, and its error against exact
solutions.
"""

import dataclasses

import numpy as np
import pytest

import varcontact as vc
from tests.scenes import make_scene, refusals, refused
from varcontact.data.make_table_book import (
    DOUBT,
    GRIDS,
    HOW,
    direction_nodes,
    magnitudes,
    make_table_book,
    stores,
)
from varcontact.reference import no_slip_coefficients
from varcontact.theories import TableBook, equivalent_ellipse, linear_forces, table_forces
from varcontact.theories.table_book import reduced_scales, shipped

BOOK = shipped()
LIMIT = 2.5
A, B, G = 1.5, 1.2, 3.0
STATED, FALLEN, FALLEN_WITHOUT_SPIN = 0.01, 0.003, 0.001
"""What the documentation says: the error of forces and moment, in parts of f Fz; how much the
resistance may fall along a ray, in parts of its largest value, with spin and without."""


def scales(ratio):
    return np.array(reduced_scales(no_slip_coefficients(ratio, 0.28), ratio))


def creepages(count, seed=0, a=A, b=B):
    """Random creepages in all directions, from almost none to almost full slip."""
    generator = np.random.default_rng(seed)
    direction = generator.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    magnitude = np.exp(generator.uniform(np.log(0.05), np.log(30), count))[:, None]
    scale = scales(a / b) * (1.0, 1.0, np.sqrt(a * b))
    return magnitude * direction / scale * LIMIT / (G * a * b)


def forces(triples, a=A, b=B, **options):
    found = table_forces(a, b, G, LIMIT, triples, **options)
    return np.concatenate([found.force, found.moment[..., None] / np.sqrt(a * b)], axis=-1) / LIMIT


def posed(a, b, triple):
    motion = vc.Steady(vx=triple[0], vy=triple[1], spin=triple[2])
    return make_scene(
        vc.Ellipse(a=a, b=b), LIMIT, motion, friction=1.0, bodies=vc.Bodies(G=G, nu=0.28)
    )


def exact(a, b, triple, accuracy=0.002):
    sol = vc.solve(posed(a, b, triple), accuracy=accuracy)
    return np.array([*sol.force, sol.moment / np.sqrt(a * b)]) / LIMIT


def test_the_book_of_the_package():
    assert BOOK.nu == 0.28
    assert BOOK.entries == 27405
    assert BOOK.provenance.startswith(HOW)
    assert len(BOOK.to_bytes()) < 2e6
    assert float(BOOK.accuracy.max()) < 0.01


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_error_at_random_points_is_below_the_stated_one(seed):
    """Between the nodes in every variable, against answers of an accuracy on demand."""
    generator = np.random.default_rng(seed)
    for triple_seed in range(6):
        ratio = np.exp(generator.uniform(np.log(0.2), np.log(5)))
        a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)
        triple = creepages(1, seed=1000 * seed + triple_seed, a=a, b=b)[0]
        np.testing.assert_allclose(
            forces(triple, a, b), exact(a, b, triple), rtol=0, atol=STATED + 0.002
        )


@pytest.mark.long
def test_entries_are_as_accurate_as_they_say():
    generator = np.random.default_rng(5)
    for _ in range(8):
        r, m, d = (int(generator.integers(n)) for n in BOOK.accuracy.shape)
        t = magnitudes(BOOK.values.shape[1])[m]
        ratio = BOOK.ratios[r]
        triple = 1.5 * t / (1 - t) * BOOK.directions[d] / scales(ratio) * LIMIT / G
        found = exact(np.sqrt(ratio), 1 / np.sqrt(ratio), triple)
        np.testing.assert_allclose(BOOK.values[r, m, d], found, rtol=0, atol=BOOK.accuracy[r, m, d])


@pytest.mark.parametrize("ratio", [0.2, 0.31, 0.77, 1.0, 2.9, 5.0])
def test_the_slope_is_that_of_the_linear_theory(ratio):
    """At the nodes in a/b and between them."""
    a, b = np.sqrt(ratio), 1 / np.sqrt(ratio)
    small = 1e-7 * creepages(20, a=a, b=b)
    linear = linear_forces(a, b, G, small, no_slip_coefficients(ratio, 0.28))
    expected = np.concatenate([linear.force, linear.moment[:, None]], axis=1) / LIMIT
    size = np.abs(expected).max(axis=1, keepdims=True)
    np.testing.assert_allclose(forces(small, a, b) / size, expected / size, rtol=0, atol=1e-5)


def test_symmetries():
    triples = creepages(200)
    found = forces(triples)
    mirrored = forces(triples * [1, -1, -1])
    backwards = forces(triples * [-1, 1, 1])
    np.testing.assert_allclose(mirrored, found * [1, -1, -1], rtol=0, atol=1e-13)
    np.testing.assert_allclose(backwards, found * [-1, 1, 1], rtol=0, atol=1e-13)


def test_single_creepages_and_many_are_the_same():
    """Numbers and arrays go through the same formulas, at corners too: backwards, no creepage, pure
    spin, one a/b.
    """
    corners = [
        [0, 0, 0],
        [1, 0, 0],
        [-1, 0, 0],
        [0, 1, 0],
        [0, -1, 0],
        [0, 0, 1],
        [0, 0, -1],
        [0, 1e9, -1e9],
    ]
    triples = np.concatenate([creepages(100), corners])
    many = table_forces(A, B, G, LIMIT, triples)
    few = table_forces(A, B, G, LIMIT, triples[:5])
    contact = {"a": A, "b": B, "G": G, "nu": 0.28, "normal_force": LIMIT, "friction": 1.0}
    for k, (vx, vy, spin) in enumerate(triples.tolist()):
        one = table_forces(A, B, G, LIMIT, (vx, vy, spin))
        named = vc.creep_forces("table", **contact, vx=vx, vy=vy, spin=spin)
        assert one.force.shape == (2,) and one.moment.shape == ()
        assert type(named.Fx) is float
        expected = pytest.approx([*many.force[k], many.moment[k]], rel=1e-12, abs=1e-14)
        assert [*one.force, one.moment] == expected
        assert [named.Fx, named.Fy, named.Mz] == expected
        if k < 5:
            assert [*few.force[k], few.moment[k]] == expected


def test_the_exact_problem_takes_more_power_with_more_creepage():
    """What is asked of the table: between any two creepages the forces change against the change of
    creepage.
    """
    triples = creepages(12, a=1.2, b=0.9)
    rays = np.concatenate([np.outer(np.geomspace(0.1, 10, 12), triple) for triple in triples[:3]])
    scene = dataclasses.replace(posed(1.2, 0.9, triples[0]), grid=vc.Grid(nx=8, ny=8))
    for chosen in (triples, rays):
        found = np.array([[*sol.force, sol.moment] for sol in vc.scan(scene, chosen, certify=None)])
        power = ((found[:, None] - found) * (chosen[:, None] - chosen)).sum(axis=-1)
        assert power.max() <= 1e-9 * LIMIT
        assert np.count_nonzero(power < -1e-6) > 0.9 * (power.size - len(chosen))


def test_it_is_smooth_enough_for_newtons_method():
    """Differences over a small and a smaller step agree everywhere, across pure spin, no spin and
    nodes too.
    """
    unit = LIMIT / (G * A * B) / scales(A / B)
    for point in ([0.0, 0.0, 1.0], [0.5, 0.5, 0.0], [1.0, 0.0, 0.0], [0.7, -0.4, 0.9]):
        for axis in np.eye(3):
            slopes = []
            for step in (1e-3, 1e-5):
                ends = [forces((np.array(point) + sign * step * axis) * unit) for sign in (1, -1)]
                slopes.append((ends[0] - ends[1]) / (2 * step))
            np.testing.assert_allclose(slopes[0], slopes[1], rtol=0, atol=1e-4)


SOME = creepages(3)
test_refused_by_name = refusals(
    (
        lambda: table_forces(A, B, G, LIMIT, SOME, nu=0.3),
        "nu = 0.3 is not allowed: must be within 0.01 of the",
    ),
    (
        lambda: table_forces(A, B, G, LIMIT, SOME, outside="extrapolate"),
        "outside = 'extrapolate' .* refuse, clamp",
    ),
    (
        lambda: table_forces(A, B, G, -1.0, SOME),
        "friction_force = -1.0 is not allowed: must be positive",
    ),
    (
        lambda: table_forces(A, B, G, [1.0, 0.0, 2.0], SOME),
        r"friction_force\[1\] = 0.0 is not allowed: must be",
    ),
    (
        lambda: table_forces(A, B, G, [1.0, 2.0, np.nan], SOME),
        r"friction_force\[2\] = nan is not allowed",
    ),
    (
        lambda: table_forces(A, B, G, LIMIT, (0.1, np.nan, 0.0)),
        r"creepages\[1\] = nan is not allowed",
    ),
    (
        lambda: table_forces(A, B, G, LIMIT, np.where(np.eye(3), np.nan, SOME)),
        r"creepages\[0, 0\] = nan",
    ),
    (lambda: table_forces(A, B, np.nan, LIMIT, SOME), "G = nan is not allowed"),
    (lambda: table_forces(A, B, G, LIMIT, SOME[:, :2]), "creepages has shape"),
    (lambda: table_forces(0.0, B, G, LIMIT, SOME), "a = 0.0 is not allowed"),
    (lambda: table_forces(A, B, np.inf, LIMIT, SOME), "G = inf is not allowed"),
)


def test_a_book_comes_back_from_its_file(tmp_path):
    (tmp_path / "book.nc").write_bytes(BOOK.to_bytes())
    again = TableBook.read(tmp_path / "book.nc")
    triples = creepages(50)
    np.testing.assert_array_equal(forces(triples, book=again), forces(triples))


def test_files_that_are_no_book(tmp_path):
    path, content = tmp_path / "book.nc", BOOK.to_bytes()
    refused(lambda: TableBook.read(path), words="No such file", error=vc.OutputError)
    damaged = bytearray(content)
    damaged[len(content) // 2] ^= 1
    of_another_version = content.replace(b"varcontact table 3", b"varcontact table 9")
    for written, words in (
        (b"words", "cannot be read as a table book"),
        (
            of_another_version,
            "is a 'varcontact table 9' file, not a 'varcontact table 3' one; make",
        ),
        (damaged, "is damaged: its numbers are not those that were written"),
    ):
        path.write_bytes(written)
        refused(lambda: TableBook.read(path), words=words, error=vc.OutputError)
    refused(lambda: TableBook.read(3), words="path = 3 is not allowed: must be the name of a file")


SMALL = {"least": 0.8, "greatest": 1.25, "ratios": 2, "steps": 2, "degree": 3}


@pytest.fixture(scope="module")
def small():
    """A book of a few entries."""
    return make_table_book(0.28, **SMALL)


@pytest.mark.long
def test_making_a_book_goes_on_where_it_stopped(small, tmp_path):
    out, told = tmp_path / "book.nc", []

    def stop(standing):
        told.append(standing)
        if len(told) == 6:  # in the second sweep
            raise KeyboardInterrupt

    with pytest.raises(vc.Interrupted):
        make_table_book(0.28, **SMALL, out=out, progress=stop)
    assert [file.exists() for file in (out, *stores(out))] == [False, True, True, False]
    book = make_table_book(0.28, **SMALL, out=out)
    assert [file.name for file in tmp_path.iterdir()] == ["book.nc"]
    assert out.read_bytes() == book.to_bytes() == small.to_bytes()
    assert book.values.shape == (2, 2, len(direction_nodes(3)), 3)


def exact_on_grids(ratio, direction, t):
    """Normalised, on each of the grids of the entries."""
    triple = 1.5 * t / (1 - t) * direction / scales(ratio) * LIMIT / G
    scene = posed(np.sqrt(ratio), 1 / np.sqrt(ratio), triple)
    solutions = (
        vc.solve(dataclasses.replace(scene, grid=grid).second_order(), certify=None)
        for grid in GRIDS
    )
    return [np.array([*sol.force, sol.moment]) / LIMIT for sol in solutions]


def test_an_entry_is_the_exact_solution(small):
    coarse, fine, finest = exact_on_grids(
        float(small.ratios[1]), small.directions[5], magnitudes(2)[0]
    )
    found = fine + (fine - coarse) / (2.25**2 - 1), finest + (finest - fine) / ((16 / 9) ** 2 - 1)
    doubtful = int(np.abs(found[0] - fine).max() > DOUBT)
    np.testing.assert_allclose(small.values[1, 0, 5], found[doubtful], rtol=0, atol=2e-4)


@pytest.mark.parametrize(("changes", "words"), [
    ({"nu": 0.7}, r"bodies\.nu = 0\.7 is not allowed"),
    ({"least": 2.0}, "greatest = 1.25 is not allowed: must be more than least = 2"),
    ({"degree": 4}, "degree = 4 is not allowed: must be odd"),
    ({"ratios": 1}, "ratios = 1 is not allowed"),
    ({"out": "book.csv"}, "the name must end in .nc"),
])  # fmt: skip
def test_a_book_of_bad_numbers_is_refused(changes, words):
    with pytest.raises(vc.VarcontactError, match=words):
        make_table_book(**{"nu": 0.3, **SMALL, **changes})


@pytest.fixture(scope="module")
def scene(rolling):
    return rolling(grid=vc.Grid(nx=16, ny=16))


def test_as_a_method_of_solve_it_carries_its_forces(scene):
    sol = vc.solve(scene, tangential="table")
    found = table_forces(1.2, 0.9, 1.0, 0.3, sol.creepage)
    np.testing.assert_allclose(sol.force, found.force, rtol=0, atol=1e-10)
    assert sol.moment == pytest.approx(float(found.moment), abs=1e-10)
    assert (np.hypot(*sol.traction) <= sol.traction_bound * (1 + 1e-9)).all()
    best = vc.solve(scene)
    assert np.hypot(*(sol.force - best.force)) < 0.05 * 0.3
    assert sol.certificate.residual > best.certificate.residual


def test_a_prescribed_force_is_met(scene):
    wanted = dataclasses.replace(scene, motion=vc.Steady(Fx=-0.2, vy=0.02, spin=0.1))
    sol = vc.solve(wanted, tangential="table")
    assert sol.force[0] == pytest.approx(-0.2, abs=1e-6)
    assert sol.creepage[1:] == (0.02, 0.1)
    assert sol.creepage[0] == pytest.approx(vc.solve(wanted).creepage[0], rel=0.1)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"bodies": vc.Bodies(G=1.0, nu=0.3)}, "its book is for nu = 0.28, and nu is 0.3"),
        ({"surface": vc.Ellipse(a=6.0, b=1.0)}, "its book has a/b from 0.2 to 5, and a/b is 6"),
        (
            {"friction": vc.LinearFalling(0.3, 0.2, half_velocity=0.1)},
            "it is for one finite coefficient",
        ),
    ],
)
def test_scenes_that_are_not_in_the_book(scene, changes, words):
    with pytest.raises(vc.SceneError, match=words):
        vc.solve(dataclasses.replace(scene, **changes), tangential="table")


def test_the_ellipse_that_stands_for_another_shape():
    """A rectangle: its area, and its ratio of sides."""
    grid = vc.Grid(nx=30, ny=40, dx=0.1, dy=0.05, x0=0.0, y0=0.0)
    pressure = np.zeros(grid.shape)
    pressure[10:20, 5:25] = 1.0  # 2 by 0.5
    a, b = equivalent_ellipse(grid, pressure)
    assert (a * b * np.pi, a / b) == pytest.approx((1.0, 4.0))
    with pytest.raises(vc.SceneError, match="positive somewhere"):
        equivalent_ellipse(grid, 0 * pressure)
    with pytest.raises(vc.SceneError, match="pressure has shape"):
        equivalent_ellipse(grid, pressure[1:])
