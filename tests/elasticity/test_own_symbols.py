"""Bodies by a symbol of one's own: against the bodies of the package, closed forms of crystals and
graded half-spaces, and each other turned; what is refused.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import special

import varcontact as vc
from varcontact.elasticity.anisotropic import (
    cubic_stiffness,
    rotated_stiffness,
    transversely_isotropic_stiffness,
)
from varcontact.elasticity.layered import LayeredPair, Stack
from varcontact.elasticity.of_scenes import medium_of
from varcontact.scene.grid import Grid

ZINC = np.array([165.0, 31.1, 50.0, 61.8, 39.6]) / 39.6
CUBES = Grid(nx=9, ny=7, dx=0.1, dy=0.08, x0=0.0, y0=0.0)


def isotropic(G, nu):
    lame = 2 * G * nu / (1 - 2 * nu)
    return cubic_stiffness(lame + 2 * G, lame, G)


def turn(angle, axis="z"):
    c, s = np.cos(angle), np.sin(angle)
    if axis == "z":
        return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def zinc(tilt, about=0.0):
    """Zinc with its axis that far from z, and turned about z."""
    crystal = transversely_isotropic_stiffness(*ZINC)
    return rotated_stiffness(crystal, turn(about) @ turn(tilt, "x"))


def half_spaces(kx, ky, nu=0.3, G=1.0):
    k = np.hypot(kx, ky)
    f = np.zeros((k.size, 3, 3))
    f[:, 0, 0] = 2 / (G * k) * (1 - nu * kx**2 / k**2)
    f[:, 1, 1] = 2 / (G * k) * (1 - nu * ky**2 / k**2)
    f[:, 0, 1] = f[:, 1, 0] = -2 * nu / (G * k) * kx * ky / k**2
    f[:, 2, 2] = 2 * (1 - nu) / (G * k)
    return f


def scalar(compliance):
    """A symbol that is the same along all directions."""
    return lambda kx, ky: compliance(np.hypot(kx, ky))[:, None, None] * np.eye(3)


def table(bodies, grid=CUBES, rows="xyz", columns="xyz"):
    return medium_of(bodies, 1.0, 4.0).operator(grid, rows, columns).table


def scene(bodies, cells=14, side=0.02, radii=(1.0, 1.0), **changes):
    x = (np.arange(cells) - (cells - 1) / 2) * side
    h = x**2 / (2 * radii[0]) + x[:, None] ** 2 / (2 * radii[1])
    corner = -cells * side / 2
    entries = {
        "bodies": bodies,
        "surface": vc.SampledDistance(h),
        "normal_force": 1e-3,
        "grid": vc.Grid(nx=cells, ny=cells, dx=side, dy=side, x0=corner, y0=corner),
    }
    return vc.Scene(**{**entries, **changes})


@pytest.mark.parametrize(
    "grid", [CUBES, Grid(nx=6, ny=6, dx=0.1, dy=0.5, x0=0.0, y0=0.0), Grid(nx=40, dx=0.1, x0=0.0)]
)
def test_half_spaces_have_the_numbers_of_the_package(grid):
    """All nine, of unlike bodies, near and far, of long elements and of strips."""
    own = vc.Elasticity.of_stiffness(isotropic(1.0, 0.25), isotropic(2.5, 0.4))
    known = vc.Bodies(G=(1.0, 2.5), nu=(0.25, 0.4))
    assert own.combined_G == pytest.approx(known.combined_G, rel=1e-12)
    assert own.K == pytest.approx(known.K, rel=1e-12)
    expected = table(known, grid)
    np.testing.assert_allclose(table(own, grid), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize(
    "motion",
    [None, vc.Steady(vx=5e-3, spin=0.01), vc.Shift(ux=1e-3), vc.Transient(steps=3, vx=3e-3)],
    ids=str,
)
@pytest.mark.parametrize("unlike", [False, True])
def test_half_spaces_have_the_solutions_of_the_package(motion, unlike):
    own = vc.Elasticity(symbol=half_spaces)
    known = vc.Bodies(1.0, 0.3)
    if unlike:
        own = vc.Elasticity.of_stiffness(isotropic(1.0, 0.3), "rigid")
        known = vc.Bodies(G=(1.0, np.inf), nu=(0.3, 0.0))
    friction = None if motion is None else 0.3
    found, expected = (
        vc.solve(scene(bodies, friction=friction, motion=motion), certify="full")
        for bodies in (own, known)
    )
    if isinstance(motion, vc.Transient):
        found, expected = found[-1], expected[-1]
    largest = expected.pressure.max()
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-8 * largest)
    np.testing.assert_allclose(found.traction, expected.traction, atol=1e-8 * largest)
    assert found.friction_work == pytest.approx(expected.friction_work, rel=1e-8, abs=1e-15)
    if motion is not None and not unlike:
        assert np.max(found.certificate.force_bound) < 1e-10


def layered_symbol(pair):
    def symbol(kx, ky):
        k = np.hypot(kx, ky)
        c, s = kx / k, ky / k
        alpha, kappa, gamma, beta = pair.symbols(k) / k
        f = np.zeros((k.size, 3, 3), complex)
        f[:, 0, 0] = alpha * c**2 + beta * s**2
        f[:, 1, 1] = alpha * s**2 + beta * c**2
        f[:, 0, 1] = f[:, 1, 0] = (alpha - beta) * c * s
        f[:, 2, 2] = gamma
        f[:, 0, 2], f[:, 1, 2] = 1j * kappa * c, 1j * kappa * s
        f[:, 2, 0], f[:, 2, 1] = -f[:, 0, 2], -f[:, 1, 2]
        return f

    return symbol


@pytest.mark.parametrize(
    "stacks",
    [
        (Stack(((0.3, 1.0, 0.3),), (0.2, 0.25)), Stack((), (1.0, 0.35))),
        (Stack(((0.3, 1.0, 0.45),), "rigid"), Stack(((0.3, 1.0, 0.45),), "rigid")),
    ],
)
def test_layers_by_their_symbol_are_layers(stacks):
    pair = LayeredPair(*stacks)
    own = vc.Elasticity(symbol=layered_symbol(pair), scale=0.3)
    expected = pair.operator(CUBES, "xyz", "xyz").table
    found = table(own) / own.combined_G
    np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())


def test_springs_below_a_half_space_have_struve_functions():
    """f = 1/(k + 1): the kernel 1/(2 pi r) - (H0(r) - Y0(r))/4."""
    own = vc.Elasticity(symbol=scalar(lambda k: 1 / (k + 1)))
    x = np.array([0.5, 1.0, 4.0])
    grid = Grid(nx=1, ny=1, dx=0.005, dy=0.005, x0=0.0, y0=0.0)
    numbers = own.medium(1.0, 4.0).influence(grid, x, np.zeros(3), ["zz"])["zz"]
    exact = 1 / (2 * np.pi * x) - (special.struve(0, x) - special.yn(0, x)) / 4
    np.testing.assert_allclose(numbers / own.combined_G / 0.005**2, exact, rtol=2e-5)
    # ninths of an element add up to it
    ninth = replace(grid, dx=0.005 / 3, dy=0.005 / 3)
    x, y = np.meshgrid(*[np.arange(-1, 2) * 0.005 / 3] * 2)
    parts = own.medium(1.0, 4.0).influence(ninth, x, y, ["zz"])["zz"].sum()
    whole = own.medium(1.0, 4.0).influence(grid, np.zeros(1), np.zeros(1), ["zz"])["zz"][0]
    assert parts == pytest.approx(whole, rel=1e-10)


STRIPS = Grid(nx=30, dx=0.05, x0=0.0)


@pytest.mark.long
@pytest.mark.parametrize(
    "stacks",
    [
        (Stack(((0.3, 1.0, 0.3),), (0.2, 0.25)), Stack((), (1.0, 0.35))),
        (Stack(((0.3, 1.0, 0.45),), "rigid"), Stack(((0.3, 1.0, 0.4),), "rigid")),
    ],
)
def test_line_contacts_of_layers_by_their_symbol(stacks):
    """All nine numbers, unlike bodies, with and without a base at rest."""
    pair = LayeredPair(*stacks, depth=20.0)
    own = vc.Elasticity(symbol=layered_symbol(pair), scale=0.3)
    expected = pair.operator(STRIPS, "xyz", "xyz").table
    found = own.medium(1.0, 20.0).operator(STRIPS, "xyz", "xyz").table / own.combined_G
    largest = np.abs(expected).max()
    off = found - expected
    np.testing.assert_allclose(off, 0, atol=1e-5 * largest)
    # waves longer than those that were sampled move all places alike
    np.testing.assert_allclose(off - off[..., 29:30], 0, atol=1e-8 * largest)
    assert own.grounded == all(pair.at_rest)


@pytest.mark.long
def test_a_line_contact_of_layers_by_their_symbol():
    layer = vc.Layered([vc.Layer(h=0.3, G=1.0, nu=0.3)], base="rigid")
    stack = Stack(((0.3, 1.0, 0.3),), "rigid")
    own = vc.Elasticity(
        symbol=layered_symbol(LayeredPair(stack, Stack((), (np.inf, 0.0)))), scale=0.3
    )
    found, expected = (
        vc.solve(
            vc.Scene(
                bodies=bodies,
                surface=vc.SampledDistance((np.arange(30) - 14.5) ** 2 * 0.02**2 / 2),
                normal_force=0.08,
                friction=0.3,
                motion=vc.Steady(vx=1e-3),
                grid=vc.Grid(nx=30, dx=0.02, x0=-0.3),
            )
        )
        for bodies in (own, (layer, "rigid"))
    )
    largest = expected.pressure.max()
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=1e-7 * largest)
    np.testing.assert_allclose(found.traction, expected.traction, atol=1e-7 * largest)


def test_strips_on_a_power_of_the_depth():
    """f = k^(n - 1): the kernel ``Gamma(n) cos(n pi/2) |x|^-n/pi``."""
    n = 0.4
    own = vc.Elasticity(symbol=scalar(lambda k: k ** (n - 1)))
    table = own.medium(1.0, 1.0).operator(STRIPS, "z", "z").table / own.combined_G
    points, weights = np.polynomial.legendre.leggauss(8)
    x = 0.5 + 0.025 * points
    kernel = special.gamma(n) * np.cos(n * np.pi / 2) * x**-n / np.pi
    assert table[0, 0, 0, 29 + 10] == pytest.approx(0.025 * weights @ kernel, rel=1e-12)


def test_local_compliances_are_springs():
    plain = vc.Elasticity(symbol=half_spaces)
    sprung = vc.Elasticity(
        symbol=lambda kx, ky: half_spaces(kx, ky) + np.diag([0.1, 0.1, 0.2]), local=(0.1, 0.1, 0.2)
    )
    added = table(sprung) - table(plain)
    own = added[..., CUBES.ny - 1, CUBES.nx - 1]
    np.testing.assert_allclose(own, np.diag([0.1, 0.1, 0.2]), atol=1e-12)
    added[..., CUBES.ny - 1, CUBES.nx - 1] = 0.0
    assert np.abs(added).max() < 1e-12


def test_a_thin_compressible_sheet_is_springs_on_the_half_space():
    """``h/G`` along the surface, ``h (1 - 2 nu)/(2 G (1 - nu))`` across, to first order of h."""
    h, G, nu = 0.004, 0.02, 0.3
    tangential = h / G
    across = tangential * (1 - 2 * nu) / (2 * (1 - nu))
    layer = vc.Layered([vc.Layer(h=h, G=G, nu=nu)], base=(1.0, 0.3))
    springs = np.diag([tangential, tangential, across])
    sheet = vc.Elasticity(
        symbol=lambda kx, ky: half_spaces(kx, ky) / 2 + springs,
        local=(tangential, tangential, across),
    )
    found, expected = (
        vc.solve(scene(bodies, 16, 0.02, normal_force=5e-4)) for bodies in (sheet, (layer, "rigid"))
    )
    largest = expected.pressure.max()
    np.testing.assert_allclose(found.pressure, expected.pressure, atol=0.03 * largest)
    bare = vc.solve(scene(vc.Bodies(G=2.0, nu=0.3), 16, 0.02, normal_force=5e-4))
    assert bare.pressure.max() > 1.3 * largest


# ----------------------------------------------------------------------------- crystals


@pytest.mark.parametrize(
    "constants",
    [ZINC, (1060.0, 180.0, 15.0, 36.5, 4.5), (14.3, 6.5, 6.5, 144.0, 6.0)],
    ids=["zinc", "graphite", "fibres"],
)
def test_indentation_along_the_axis_has_its_closed_form(constants):
    """Elliott 1949, Hanson 1992, Delafargue and Ulm 2004: an axis along the normal."""
    c11, _, c13, c33, c44 = constants
    mean = np.sqrt(c11 * c33)
    exact = 2 * np.sqrt((mean**2 - c13**2) / c11 / (1 / c44 + 2 / (mean + c13)))
    own = vc.Elasticity.of_stiffness(transversely_isotropic_stiffness(*constants), "rigid")
    assert own.indentation_modulus == pytest.approx(exact, rel=1e-10)


@pytest.mark.long
def test_indentation_moduli_of_wood_are_the_published_ones():
    """Axis along and across the normal, read from a figure (tests/data/indentation_moduli.csv)."""
    path = Path(__file__).parents[1] / "data" / "indentation_moduli.csv"
    table = np.genfromtxt(path, delimiter=",", names=True, skip_header=4)
    for angle, E_L, E_T, G_LT, published in table:
        ratio = 0.25
        soft = np.diag([1 / E_T, 1 / E_T, 1 / E_L, 1 / G_LT, 1 / G_LT, 2 * (1 + ratio) / E_T])
        soft[0, 1] = soft[1, 0] = -ratio / E_T
        soft[2, :2] = soft[:2, 2] = -ratio / E_L
        crystal = rotated_stiffness(np.linalg.inv(soft), turn(np.radians(angle), "x"))
        own = vc.Elasticity.of_stiffness(crystal, "rigid")
        assert own.indentation_modulus == pytest.approx(published, rel=0.015)


def willis(bodies, a, b, angle):
    """Approach and distance x'Hx of the pressure ``sqrt(1 - rho^2)`` on an ellipse (Willis 1966)."""
    theta = 2 * np.pi * np.arange(2000) / 2000
    F = bodies.symbol.times_k(np.ones(theta.size), theta)[:, 2, 2].real
    width = np.hypot(a * np.cos(theta - angle), b * np.sin(theta - angle))
    n = np.stack([np.cos(theta), np.sin(theta)])
    each = a * b / 8 * F / width * (2 * np.pi / theta.size)
    return each.sum(), np.einsum("t,it,jt->ij", each / width**2, n, n)


@pytest.mark.long
@pytest.mark.parametrize("tilt", [90, 35])
def test_willis_ellipses_on_tilted_zinc(tilt):
    """Axes of the contact oblique to those of the grid: numbers have no mirrors."""
    bodies = vc.Elasticity.of_stiffness(zinc(np.radians(tilt), 0.3), "rigid")
    a, b = 1.0, 0.8
    approach, H = willis(bodies, a, b, np.radians(30))
    cells = 32
    side = 2.3 / cells
    x = (np.arange(cells) - (cells - 1) / 2) * side
    h = H[0, 0] * x**2 + 2 * H[0, 1] * x * x[:, None] + H[1, 1] * x[:, None] ** 2
    found = vc.solve(
        scene(
            bodies, cells, side, surface=vc.SampledDistance(h), normal_force=2 / 3 * np.pi * a * b
        )
    )
    assert found.pressure.max() == pytest.approx(1.0, abs=3e-3)
    assert found.approach == pytest.approx(approach, rel=1e-3)
    assert found.certificate.normal_residual < 1e-8


@pytest.mark.long
def test_a_turned_crystal_has_turned_numbers():
    """By 90 degrees about z: offsets, displacements and tractions turn with it."""
    grid = Grid(nx=7, ny=7, dx=0.1, dy=0.1, x0=0.0, y0=0.0)
    one = table(vc.Elasticity.of_stiffness(zinc(0.6, 0.3), zinc(1.1, 2.0)), grid)
    bodies = vc.Elasticity.of_stiffness(zinc(0.6, 0.3 + np.pi / 2), zinc(1.1, 2.0 + np.pi / 2))
    other = table(bodies, grid)
    R = turn(np.pi / 2)
    # the number of an offset is that of the offset turned back
    turned = np.einsum("ia,jb,abyx->ijyx", R, R, one)
    turned = turned[..., ::-1, :].swapaxes(-1, -2)
    np.testing.assert_allclose(other, turned, atol=1e-11 * np.abs(one).max())


@pytest.mark.long
@pytest.mark.parametrize("partner", ["rigid", "same"])
def test_solvers_agree_on_tilted_crystals(partner):
    crystal = zinc(1.2, 0.3)
    bodies = vc.Elasticity.of_stiffness(crystal, crystal if partner == "same" else partner)
    held = scene(bodies, 12, 0.024, friction=0.3, motion=vc.Steady(vx=5e-3, spin=0.01))
    solutions = [
        vc.solve(held, tangential=name)
        for name in ("tang-safeguarded", "newton", "clarabel", "splitting")
    ]
    for other in solutions[1:]:
        np.testing.assert_allclose(other.traction, solutions[0].traction, atol=1e-8)
        assert other.certificate.relative_gap < 1e-7


@pytest.mark.long
def test_a_history_of_a_tilted_crystal_ends_in_steady_rolling():
    bodies = vc.Elasticity.of_stiffness(zinc(np.pi / 2, 0.5), zinc(np.pi / 2, 0.5))
    assert not bodies.coupled
    rolling = scene(bodies, 12, 0.024, friction=0.3, motion=vc.Steady(vx=5e-3, spin=0.01))
    steady = vc.solve(rolling)
    history = vc.solve(replace(rolling, motion=vc.Transient(steps=40, vx=5e-3, spin=0.01)))
    np.testing.assert_allclose(
        history[-1].traction, steady.traction, atol=1e-3 * steady.pressure.max()
    )
    assert history[-1].friction_work == pytest.approx(steady.friction_work, rel=3e-3)


def test_power_graded_half_spaces_have_their_pressure():
    """G by depth^n: a paraboloid has ``(1 - r^2)^((1+n)/2)`` and the approach ``1/(R (1 + n))``
    (Booker, Balaam and Davis 1985; Giannakopoulos and Suresh 1997).
    """
    n = 0.3
    bodies = vc.Elasticity(symbol=scalar(lambda k: k ** (n - 1)))
    assert bodies.symbol.degree == n
    kernel = 2**n * special.gamma((1 + n) / 2) / special.gamma((1 - n) / 2) / (2 * np.pi)
    centre = kernel * np.pi * special.beta((1 - n) / 2, (n + 3) / 2)
    radius = 1 / ((1 + n) * centre)
    found = vc.solve(
        scene(bodies, 40, 2.3 / 40, (radius, radius), normal_force=2 * np.pi / (n + 3))
    )
    x, y = np.meshgrid(found.grid.x, found.grid.y)
    exact = np.maximum(1 - x**2 - y**2, 0.0) ** ((1 + n) / 2)
    inside = np.hypot(x, y) < 0.8
    np.testing.assert_allclose(found.pressure[inside], exact[inside], atol=2e-3)
    assert found.approach * (1 + n) * radius == pytest.approx(1.0, rel=5e-4)


# ----------------------------------------------------------------------------- grids and files


@pytest.mark.long
def test_paraboloids_have_no_pressure_of_hertz():
    """The grid is found from a body as soft, and nothing of the isotropic closed form enters."""
    bodies = vc.Elasticity.of_stiffness(zinc(np.pi / 2), "rigid")
    held = vc.Scene(
        bodies=bodies,
        surface=vc.Paraboloids(1.0, 1.0),
        normal_force=1e-3,
        grid=vc.Grid(nx=20, ny=20),
    )
    found = vc.solve(held)
    assert held.hertz is None
    assert found.certificate.normal_residual < 1e-8
    assert not found.pressure[0].any() and not found.pressure[:, 0].any()
    with pytest.raises(vc.SceneError, match="half-spaces"):
        vc.solve(held, normal="hertz")


@pytest.mark.long
def test_files_keep_the_numbers(tmp_path):
    bodies = vc.Elasticity.of_stiffness(zinc(0.7, 0.2), isotropic(1.0, 0.3))
    found = vc.solve(scene(bodies, 10, 0.028, friction=0.3, motion=vc.Steady(vx=5e-3)))
    found.save(tmp_path / "own.nc")
    again = vc.load(tmp_path / "own.nc")
    assert again.note == ""
    assert again.scene.bodies == bodies and hash(again.scene.bodies) == hash(bodies)
    assert again.certificate.relative_gap == pytest.approx(found.certificate.relative_gap)
    found.scene.save(tmp_path / "own.toml")
    read, _ = vc.read_scene(tmp_path / "own.toml")
    assert read.bodies == bodies
    assert read.bodies != vc.Elasticity.of_stiffness(zinc(0.7, 0.3), isotropic(1.0, 0.3))


def test_changed_numbers_are_refused(tmp_path):
    path = tmp_path / "own.toml"
    scene(vc.Elasticity(symbol=half_spaces), 10).save(path)
    text = path.read_text()
    at = text.index("float64") + 30
    path.write_text(text[:at] + ("A" if text[at] != "A" else "B") + text[at + 1 :])
    with pytest.raises(vc.SceneError, match="not those that were written"):
        vc.read_scene(path)


def calls():
    """A symbol that grows with every call."""
    count = iter(range(10_000))
    return lambda kx, ky: half_spaces(kx, ky) * (1 + 1e-6 * next(count))


def not_a_number(kx, ky):
    f = half_spaces(kx, ky)
    f[np.abs(np.hypot(kx, ky) - 1) < 1e-3, 0, 0] = np.nan
    return f


def skew(kx, ky):
    f = half_spaces(kx, ky)
    f[:, 0, 1] += 1e-3 / np.hypot(kx, ky)
    return f


def lopsided(kx, ky):
    return half_spaces(kx, ky) * (1 + 0.1 * kx / np.hypot(kx, ky))[:, None, None]


@pytest.mark.parametrize(
    ("symbol", "words"),
    [
        (skew, "not Hermitian at a wave number of"),
        (lopsided, "conjugate of that at the opposite"),
        (lambda kx, ky: -half_spaces(kx, ky), "not positive definite at a wave number of"),
        (lambda kx, ky: half_spaces(kx, ky, nu=1.2), "its least eigenvalue is"),
        (not_a_number, "not finite at a wave number of 1,"),
        (scalar(lambda k: 1 / k**2), "faster than 1/k towards 0"),
        (scalar(lambda k: 1 / k + 1), "not falling like 1/k"),
        (calls(), "dependent on the order of calls"),
        (lambda kx, ky: half_spaces(kx, ky)[:, :2], r"of shape \(\d+, 2, 3\)"),
        (lambda kx, ky: 1 / kx[:, None, None, None], "shape"),
        (scalar(lambda k: (1 + (k > 3)) / k), "not smooth enough"),
        (lambda kx, ky: kx.nonsense, "raised AttributeError"),
        ("half-spaces", "a function of wave numbers"),
    ],
)
def test_symbols_that_no_body_has(symbol, words):
    with pytest.raises(vc.SceneError, match=words) as error:
        vc.Elasticity(symbol=symbol)
    assert error.value.field == "bodies.symbol"


@pytest.mark.parametrize(
    ("make", "field", "words"),
    [
        (lambda: vc.Elasticity(symbol=half_spaces, scale=0.0), "bodies.scale", "positive"),
        (lambda: vc.Elasticity(symbol=half_spaces, local=(0, 0)), "bodies.local", "shape"),
        (lambda: vc.Elasticity(symbol=half_spaces, local=(0, 0, -1)), "bodies.local[2]", "zero or"),
        (lambda: vc.Elasticity.of_stiffness("rigid", "rigid"), "bodies", "one body at least"),
        (lambda: vc.Elasticity.of_stiffness(np.eye(3), "rigid"), "bodies.upper", "shape"),
        (lambda: vc.Elasticity.of_stiffness(-np.eye(6), "rigid"), "bodies.upper", "positive def"),
        (
            lambda: vc.Elasticity.of_stiffness(np.eye(6) + np.eye(6, k=2), "rigid"),
            "bodies.upper[0, 2]",
            "equal to",
        ),
        (lambda: rotated_stiffness(np.eye(6), np.ones((3, 3))), "rotation", "orthogonal"),
        (
            lambda: vc.Scene(
                bodies=vc.Elasticity(symbol=scalar(lambda k: 1 / (k + 1))),
                surface=vc.Cylinders(1.0, reference_depth=5.0),
                normal_force=1.0,
            ),
            "surface.reference_depth",
            "bases",
        ),
        (
            lambda: scene(vc.Elasticity(symbol=half_spaces), surface=vc.Ellipse(1.0, 1.0)),
            "surface",
            "Hertz",
        ),
        (
            lambda: scene(
                vc.Elasticity(symbol=half_spaces),
                loads=[vc.SurfaceLoad(body="lower", x=(2, 3), y=(0, 1), pressure=1.0)],
            ),
            "loads",
            "left out",
        ),
        (
            lambda: vc.stress_below(vc.solve(scene(vc.Elasticity(symbol=half_spaces))), [0.1]),
            "body",
            "not known",
        ),
    ],
)
def test_what_is_refused(make, field, words):
    with pytest.raises(vc.SceneError, match=words) as error:
        make()
    assert error.value.field == field


def test_numbers_in_files_are_as_long_as_they_say():
    numbers = vc.Elasticity(symbol=half_spaces).symbol.limit
    stored = json.loads(json.dumps(numbers.to_table()))
    for change in ({"shape": [1, 3, 3]}, {"shape": [-1]}, {"float64": "?"}, {"float64": 1}):
        with pytest.raises(vc.SceneError):
            type(numbers).of_table("numbers", {**stored, **change})
