"""Stresses below the surface of solutions: bodies, axes, invariants, what is refused."""

import dataclasses

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

import varcontact as vc
from tests.scenes import make_scene, refused
from varcontact.elasticity.halfspace import influence_numbers
from varcontact.elasticity.operators import influence_operator
from varcontact.elasticity.plane_strain import strip_influence_numbers


@pytest.fixture(scope="module")
def unlike(rolling):
    """Any tractions at all, between unlike bodies, on elements that are no squares."""
    grid = vc.Grid(nx=12, ny=8, dx=0.3, dy=0.4, x0=-1.8, y0=-1.6)
    sol = vc.solve(rolling(bodies=vc.Bodies(G=(1.0, 3.0), nu=(0.4, 0.1)), motion=None, grid=grid))
    rng = np.random.default_rng(5)
    pressure, traction = rng.uniform(0, 1, size=grid.shape), rng.normal(size=(2, *grid.shape))
    return dataclasses.replace(sol, pressure=pressure, traction=traction)


@pytest.fixture(scope="module")
def cylinders():
    """Hertz's line contact under normal force: a = 1, p0 = 1."""
    surface, bodies = vc.Cylinders(R=2 / 3, reference_depth=7.0), vc.Bodies(G=1.0, nu=0.25)
    return vc.solve(make_scene(surface, np.pi / 2, None, vc.Grid(nx=400), None, bodies))


def at_centres(grid):
    x, y = (c.ravel() for c in np.meshgrid(grid.x, grid.y))
    return np.array([x, y, 0 * x])


@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.13, -0.2)])
def test_surface_displacements_are_the_influence_numbers(unlike, shift):
    """u1 - u2 at z = 0 by all nine influence numbers, unlike bodies: signs, constants and both K
    terms.
    """
    bodies, grid = unlike.scene.bodies, unlike.grid
    points = at_centres(grid) + np.reshape([*shift, 0.0], (3, 1))
    found = vc.stress(unlike, points, 1).displacement - vc.stress(unlike, points, 2).displacement
    moved = dataclasses.replace(grid, x0=grid.x0 + shift[0], y0=grid.y0 + shift[1])
    x, y = moved.x[:, None] - grid.x, moved.y[:, None] - grid.y
    tractions = np.concatenate([unlike.traction, unlike.pressure[None]])
    B = influence_numbers(
        x[None, :, None, :], y[:, None, :, None], *grid.sides, nu=bodies.combined_nu, K=bodies.K, G=bodies.combined_G,
        components=[i + j for i in "xyz" for j in "xyz"],
    )  # fmt: skip
    for i, row in enumerate("xyz"):
        expected = sum(
            np.einsum("abcd,cd->ab", B[row + column], tractions[j])
            for j, column in enumerate("xyz")
        )
        np.testing.assert_allclose(found[i], expected.ravel(), rtol=0, atol=1e-13)
    if shift == (0.0, 0.0):
        operator = influence_operator(grid, "xyz", "xyz", nu=bodies.combined_nu, K=bodies.K)
        by_fft = operator.apply(tractions) / bodies.combined_G
        np.testing.assert_allclose(found.reshape(by_fft.shape), by_fft, rtol=0, atol=1e-13)


@pytest.mark.parametrize("body", [1, 2])
def test_tractions_at_the_surface(unlike, body):
    """Both bodies have the stresses -p on the surface: action and reaction on opposite normals."""
    found = vc.stress(unlike, at_centres(unlike.grid), body).stress[:, 2]
    tractions = np.concatenate([unlike.traction, unlike.pressure[None]]).reshape(3, -1)
    np.testing.assert_allclose(found, -tractions, atol=1e-14)


@pytest.mark.parametrize("body", [1, 2])
def test_gradients_in_the_scenes_axes(unlike, body):
    """du_i/dx_j by differences, in both bodies, and Hooke's law with each body's own constants."""
    sign, h = (1, 1e-4) if body == 1 else (-1, 1e-4)
    points = np.array([[0.2, 0.5, sign * 0.6], [-1.0, 0.1, sign * 2.0]]).T
    found = vc.stress(unlike, points, body)
    for j in range(3):
        step = h * np.eye(3)[:, j : j + 1]
        ahead, behind = (vc.stress(unlike, points + s * step, body).displacement for s in (1, -1))
        np.testing.assert_allclose((ahead - behind) / (2 * h), found.gradient[:, j], atol=1e-7)
    (G, nu) = (constants[body - 1] for constants in unlike.scene.bodies.pairs)
    strain = (found.gradient + found.gradient.swapaxes(0, 1)) / 2
    unit = np.eye(3)[:, :, None]
    expected = 2 * G * (strain + nu / (1 - 2 * nu) * np.trace(strain) * unit)
    np.testing.assert_allclose(found.stress, expected, atol=1e-13)


def test_a_rigid_body_has_stresses_but_no_strains(rolling):
    points = np.array([[0.1, -0.3, -0.5], [0.4, 0.0, 0.0]]).T
    rigid = vc.solve(rolling(bodies=vc.Bodies(G=(1.0, np.inf), nu=(0.5, 0.2))))
    stiff = dataclasses.replace(rigid, scene=rolling(bodies=vc.Bodies(G=(1.0, 1e9), nu=(0.5, 0.2))))
    found, near = vc.stress(rigid, points, 2), vc.stress(stiff, points, 2)
    assert not found.displacement.any()
    assert not found.gradient.any()
    np.testing.assert_array_equal(found.stress, near.stress)
    assert np.abs(near.gradient).max() < 1e-9
    assert np.abs(found.stress).max() > 0.1


tensors = st.lists(st.floats(-10, 10), min_size=6, max_size=6)


@pytest.mark.long
@hypothesis.given(tensors, st.floats(-10, 10))
def test_invariants(components, pressure):
    """Von Mises from principal stresses, Tresca within its bounds; neither feels a hydrostatic
    pressure.
    """
    xx, yy, zz, xy, xz, yz = components
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])[:, :, None]
    state, squeezed = (
        vc.SubsurfaceStress(1, np.zeros((3, 1)), np.zeros((3, 1)), np.zeros((3, 3, 1)), stress)
        for stress in (tensor, tensor - pressure * np.eye(3)[:, :, None])
    )
    first, second, third = state.principal[:, 0]
    assert first >= second >= third
    assert state.first_invariant[0] == pytest.approx(first + second + third, abs=1e-12)
    mises = np.sqrt(((first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2) / 2)
    assert state.von_mises[0] == pytest.approx(mises, abs=1e-6)
    assert state.ideal_stress[0] == pytest.approx(mises * np.sqrt(2 / 3), abs=1e-6)
    assert state.tresca[0] == pytest.approx(first - third)
    assert mises <= state.tresca[0] + 1e-6
    assert state.tresca[0] <= mises * 2 / np.sqrt(3) + 1e-6
    for name in ("von_mises", "tresca", "ideal_stress"):
        assert getattr(squeezed, name)[0] == pytest.approx(getattr(state, name)[0], abs=1e-5)


def test_yield_below_a_hertzian_circle():
    """Johnson 3.4: the largest shear stress is 0.31 p0, at the depth 0.48 a, for nu = 0.3."""
    bodies, grid = vc.Bodies(G=1.0, nu=0.3), vc.Grid(nx=32, ny=32)
    scene = make_scene(vc.Ellipse(a=1.0, b=1.0), 1.0, None, grid, None, bodies)
    depths = np.linspace(0.3, 0.7, 81)
    below = vc.stress(vc.solve(scene), [0 * depths, 0 * depths, depths])
    assert below.tresca.max() / 2 / scene.hertz.peak_pressure == pytest.approx(0.310, abs=0.001)
    assert depths[below.tresca.argmax()] == pytest.approx(0.48, abs=0.01)


def test_axis_of_a_line_contact(cylinders):
    """Johnson (4.46), both bodies; the largest shear stress is 0.30 p0 at 0.78 a."""
    z = np.array([0.0, 0.1, 0.5, 0.78, 3.0])
    for body in (1, 2):
        found = vc.stress(cylinders, [0 * z + 1e-9, 0 * z, z if body == 1 else -z], body)
        root = np.sqrt(1 + z**2)
        along, down = -((1 + 2 * z**2) / root - 2 * z), -1 / root
        expected = np.array([along, 0.25 * (along + down), down])
        np.testing.assert_allclose(found.stress[[0, 1, 2], [0, 1, 2]], expected, atol=2e-4)
        assert found.tresca[3] / 2 == pytest.approx(0.300, abs=1e-3)


def test_line_contact_displacements_are_the_influence_numbers(cylinders):
    """Unlike bodies, all three tractions; the logarithms count from the scene's reference depth."""
    bodies, grid = vc.Bodies(G=(1.0, 3.0), nu=(0.4, 0.1)), vc.Grid(nx=8, dx=0.3, x0=-1.0)
    rng = np.random.default_rng(7)
    sol = dataclasses.replace(
        cylinders, scene=dataclasses.replace(cylinders.scene, bodies=bodies), grid=grid,
        pressure=rng.uniform(0, 1, size=(1, 8)), traction=rng.normal(size=(2, 1, 8)),
    )  # fmt: skip
    x = np.concatenate([grid.x, [-1.0, 0.17, 5.0, 400.0]])  # centres, an edge, far away
    points = np.array([x, 0 * x, 0 * x])
    found = vc.stress(sol, points, 1).displacement - vc.stress(sol, points, 2).displacement
    tractions = np.concatenate([sol.traction, sol.pressure[None]])[:, 0]
    B = strip_influence_numbers(
        x[:, None] - grid.x, 0.3, nu=bodies.combined_nu, K=bodies.K, G=bodies.combined_G, depth=7.0,
        components=[i + j for i in "xyz" for j in "xyz"],
    )  # fmt: skip
    for i, row in enumerate("xyz"):
        expected = sum(B[row + column] @ tractions[j] for j, column in enumerate("xyz"))
        np.testing.assert_allclose(found[i], expected, rtol=0, atol=1e-12)


def test_line_contact_without_reference_depth(cylinders):
    scene = dataclasses.replace(cylinders.scene, surface=vc.Cylinders(R=2 / 3))
    without = vc.stress(dataclasses.replace(cylinders, scene=scene), [0.0, 0.0, 0.5])
    assert np.isnan(without.displacement).all()
    np.testing.assert_array_equal(without.stress, vc.stress(cylinders, [0.0, 0.0, 0.5]).stress)


def test_shapes_follow_the_points(unlike):
    one = vc.stress(unlike, (0.1, 0.2, 0.3))
    assert one.stress.shape == (3, 3)
    assert one.von_mises.shape == one.tresca.shape == ()
    many = vc.stress(unlike, np.full((3, 2, 4), 0.3))
    assert many.displacement.shape == (3, 2, 4)
    assert many.principal.shape == many.points.shape
    assert many.deviator.shape == (3, 3, 2, 4)
    assert vc.stress(unlike, np.ones((3, 0))).tresca.shape == (0,)
    by_numpy = vc.stress(unlike, (0.1, 0.2, 0.3), np.int64(1))
    np.testing.assert_array_equal(np.asarray(by_numpy.stress), np.asarray(one.stress))


@pytest.mark.parametrize(
    ("points", "body", "message"),
    [
        (
            [[0, 0], [0, 0], [1, -0.5]],
            1,
            r"points\[:, 1\] = \[0.0, 0.0, -0.5\] .* upper body, z >= 0 \(1 of 2 points",
        ),
        ([[0, 0], [0, 0], [1, -0.5]], "lower", r"points\[:, 0\] .* lower body, z <= 0"),
        ([0, 0, -1.0], "upper", r"points\[:\] = "),
        ([[0, 0], [0, 0]], 1, r"points has shape \(2, 2\)"),
        (3.0, 1, "points"),
        ([0, 0, np.nan], 1, r"points\[2\] = nan"),
        ([0, 0, np.inf], 1, r"points\[2\] = inf"),
        ([[0, 0], [1], [2]], 1, "points"),
        (
            [[0, 0, 1.0], [0, 0, 2.0]],
            1,
            r"points has shape \(2, 3\); .* \(did you mean its transpose\?\)",
        ),
        ("here", 1, "points"),
        ([0, 0, 1j], 1, "points"),
        ([0, 0, 1.0], 3, 'body = 3 is not allowed: must be one of 1 or "upper"'),
        ([0, 0, 1.0], True, "body"),
        ([0, 0, 1.0], "middle", "body"),
        ([0, 0, 1.0], None, "body"),
    ],
)
def test_what_is_refused(unlike, points, body, message):
    refused(lambda: vc.stress(unlike, points, body), match=message)


@pytest.mark.parametrize(
    "call",
    [
        lambda given: vc.stress(given, [0, 0, 0]),
        lambda given: vc.stress_below(given, 0.1),
        vc.plot_stress,
    ],
)
def test_a_history_is_refused_and_its_steps_are_not(rolling, call):
    """Also where a step has no contact: then nothing is stressed, and there is no picture."""
    history = vc.solve(rolling(motion=vc.Transient(steps=2, vx=1e-3, normal_force=[2.0, 0.0])))
    for given in (history, None, "solution.nc"):
        with pytest.raises(
            vc.SceneError, match=r"solution = .* must be a Solution; of a History, one of its steps"
        ):
            call(given)
    call(history[0])
    if call is vc.plot_stress:
        refused(lambda: call(history[1]), match="with contact: else nothing is stressed")
    else:
        assert not call(history[1]).stress.any()


@pytest.mark.parametrize(
    ("depths", "body"),
    [(-0.1, 1), ([0.1, -0.1], 2), ([], 1), ([[0.1]], 1), (np.nan, 1), ("deep", 1), (1.0, 0)],
)
def test_depths_that_are_refused(unlike, depths, body):
    refused(lambda: vc.stress_below(unlike, depths, body), match=r"depths|body")


@pytest.mark.long
@pytest.mark.parametrize("quantity", ["von_mises", "first_invariant", "xz"])
def test_picture(rolling, tmp_path, quantity):
    sol = vc.solve(rolling(units=vc.Units(length="mm", force="kN")))
    figure = vc.plot_stress(sol, quantity, depth=1.0)
    figure.savefig(tmp_path / "section.png")
    assert (tmp_path / "section.png").stat().st_size > 20_000
    bar = next(line for line in figure.axes[0].get_lines() if line.get_label() == "contact")
    length = np.ptp(sol.grid.x[(sol.pressure > 0).any(axis=0)]) + sol.grid.sides[0]
    assert np.ptp(bar.get_xdata()) == pytest.approx(length), "the bar is the contact"
    assert figure.axes[0].child_axes[0].get_ylabel().endswith("MPa]")  # kN/mm^2 is GPa
    assert figure.axes[0].get_ylim() == pytest.approx((-1.0, 1.0))


@pytest.mark.long
@pytest.mark.parametrize("bad", [{"quantity": "mises"}, {"depth": 0.0}, {"y": "middle"}])
def test_pictures_of_a_line_contact(cylinders, bad):
    assert "y =" not in vc.plot_stress(cylinders, "tresca").axes[0].get_title()
    refused(lambda: vc.plot_stress(cylinders, **bad), match=next(iter(bad)))


def test_stress_that_does_not_fit_is_refused(unlike, monkeypatch):
    monkeypatch.setattr("varcontact.system.process.LITTLE", 0.0)
    monkeypatch.setattr("varcontact.system.process.available", lambda: 2300.0 * unlike.grid.size)
    with pytest.raises(vc.TooLarge, match="fewer depths at a time would fit"):
        vc.stress_below(unlike, [0.1, 0.2])
    with pytest.raises(vc.TooLarge, match="a grid with fewer elements would fit"):
        vc.stress_below(unlike, 0.1)


@pytest.mark.parametrize("body", [1, 2])
def test_many_points_below_centres_are_found_as_few_are(unlike, body):
    """By FFT where they are many; a point that is off a centre has them all summed up."""
    depth = {1: 0.7, 2: -0.7}[body]
    centres = at_centres(unlike.grid) + np.array([[0.0], [0.0], [depth]])
    points = np.concatenate([centres, centres * np.array([[1], [1], [2]])], axis=1)
    many = vc.stress(unlike, points, body)
    off = vc.stress(unlike, np.concatenate([points, [[0.013], [0.0], [depth]]], axis=1), body)
    for name in ("stress", "displacement", "gradient"):
        expected = getattr(off, name)[..., :-1]
        tol = 1e-12 * np.abs(expected).max()
        np.testing.assert_allclose(getattr(many, name), expected, rtol=0, atol=tol)
