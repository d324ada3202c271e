"""The displacement gradient under an ellipsoidal traction, against sums over small elements."""

import numpy as np
import pytest

from varcontact.elasticity.ellipsoidal import ellipsoidal_gradients, rooted_gradients, sloped_gradients
from varcontact.elasticity.halfspace import influence_numbers

AXES = pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (1.5, 0.7), (0.4, 1.6)])


def by_elements(a, b, nu, place, step, shape):
    """Central difference of the displacements xx, xy, yy by 10 000 rectangles that bear the root times a shape."""
    dx, dy = a / 50, b / 50
    x, y = -a + (np.arange(100) + 0.5) * dx, (-b + (np.arange(100) + 0.5) * dy)[:, None]
    traction = np.sqrt(np.maximum(1 - (x / a) ** 2 - (y / b) ** 2, 0.0)) * shape(x, y)
    names = ("xx", "xy", "yy")
    ahead, behind = (
        influence_numbers(place[0] + side - x, place[1] - y, dx, dy, nu=nu, G=2.0, components=names)
        for side in (step, -step)
    )
    xx, xy, yy = (np.sum((ahead[name] - behind[name]) * traction) / (2 * step) for name in names)
    return np.array([[xx, xy], [xy, yy]])


@AXES
@pytest.mark.parametrize("nu", [0.0, 0.4])
def test_against_elements(a, b, nu):
    """Displacements are quadratic in the place, and central differences exact."""
    for place in ((0.3 * a, 0.2 * b), (-0.5 * a, 0.4 * b)):
        found = by_elements(a, b, nu, place, 0.1 * a, lambda x, y: 1.0)
        np.testing.assert_allclose(ellipsoidal_gradients(*place, a, b, nu=nu, G=2.0), found, atol=1e-3)


def test_long_ellipses_tend_to_line_contact():
    wide = ellipsoidal_gradients(0.3, 0.0, 0.5, 5e3, nu=0.3)
    np.testing.assert_allclose(wide, np.diag([-2 * 0.7 * 0.6, -2 * 0.6]), rtol=1e-6, atol=1e-12)


def test_is_linear_in_place_and_odd():
    x, y = np.array([0.1, 0.2, 0.4]), np.array([0.3, 0.6, 1.2])
    found = ellipsoidal_gradients(x, y, 2.0, 1.0, nu=0.25)
    np.testing.assert_allclose(found, found[..., :1] * [1, 2, 4], rtol=1e-14)
    np.testing.assert_array_equal(ellipsoidal_gradients(-x, -y, 2.0, 1.0, nu=0.25), -found)


@AXES
def test_over_the_root_against_the_symbol(a, b):
    """1 over the root less its share in x^2 and y^2 is the ellipsoidal traction, whose derivative follows by parts.

    With t = sqrt(1 - (x/a)^2 - (y/b)^2), dt/dx = -x/(a^2 t): so the derivative of the displacement by x over the root
    is -a^2 times the second derivative by t, and that by y over the root -b^2 times the mixed one.
    """
    found = rooted_gradients(a, b, nu=0.3, G=2.0)
    along = ellipsoidal_gradients(1.0, 0.0, a, b, nu=0.3, G=2.0)
    across = ellipsoidal_gradients(0.0, 1.0, a, b, nu=0.3, G=2.0)
    np.testing.assert_allclose(found, [0 * along, -(a**2) * along, -(b**2) * across], rtol=1e-12, atol=1e-15)


@AXES
def test_times_place_against_elements(a, b):
    """x and y times the root: displacements are of third degree, and differences extrapolated."""
    place, step = (0.3 * a, -0.4 * b), 0.05 * a
    exact = sloped_gradients(*place, a, b, nu=0.4, G=2.0)
    for found, shape in zip(exact, (lambda x, y: x, lambda x, y: y), strict=True):
        one, two = (by_elements(a, b, 0.4, place, n * step, shape) for n in (1, 2))
        np.testing.assert_allclose((4 * one - two) / 3, found, atol=1e-3)


@pytest.mark.parametrize("ratio", [1e-6, 1e6])
def test_times_place_in_slender_ellipses(ratio):
    """Long across it is a line contact; long along nothing overflows, and the shares of nu stay."""
    x, y = np.array([0.3, 0.0]), np.array([0.0, 0.2])
    found = sloped_gradients(x * ratio, y, ratio, 1.0, nu=0.3)
    assert np.isfinite(found).all()
    if ratio < 1:
        line = (1 - 2 * 0.3**2) * np.diag([1 - 0.3, 1.0])
        np.testing.assert_allclose(found[0, :, :, 0], line * ratio, atol=1e-6 * ratio)
    else:
        np.testing.assert_allclose(found[0, 0, 0] / found[0, 1, 1], 1 / (1 - 0.3), rtol=0.1)
