"""Stress in a half-space whose surface carries tractions that are bilinear between the nodes of a
lattice: closed form.

All of it follows from the fourfold antiderivative L, twice along x and twice along y, of
``Omega = z ln(rho + z) - rho``, by harmonic derivatives of third and fourth order. They are
homogeneous up to polynomials that vanish in mixed second differences, so that the third ones follow
from the fourth by Euler's theorem. Tractions enter by their mixed second differences at the nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property

THIRD = ("xxx", "xxy", "xyy", "yyy", "xxz", "xyz", "yyz")
FOURTH = ("xxxx", "xxxy", "xxyy", "xyyy", "yyyy", "xxxz", "xxyz", "xyyz", "yyyz")
"""Derivatives of a harmonic function; those with zz follow from Laplace's equation."""
DERIVATIVES = (*THIRD, *FOURTH)
COMPONENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
TO_COORDINATES = np.array(
    [
        [0.0, 0.5, -0.5, 0.0, 0.0, 0.0],
        [1 / np.sqrt(3), -0.5 / np.sqrt(3), -0.5 / np.sqrt(3), 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    ]
)
"""Matrix from the components of a stress to its five coordinates."""


def plain_terms(name: str) -> list[tuple[float, str]]:
    """Signs and names of derivatives without zz that add up to one, by Laplace's equation."""
    if name.count("z") < 2:
        return [(1.0, name)]
    rest = name.replace("z", "", 2)
    terms = []
    for pair in ("xx", "yy"):
        ordered = "".join(sorted(pair + rest))
        terms += [(-sign, each) for sign, each in plain_terms(ordered)]
    return terms


def _by_traction(along: str, other: str, nu: float) -> dict[str, list[tuple[float, str]]]:
    """Stresses times 2 pi by a traction along one axis, as derivatives of its potential; those of
    fourth order are times the depth (Johnson 1985, section 3.6).
    """
    a = along
    b = other
    return {
        a + a: [(2 * (1 + nu), a + "zz"), (2 * nu, 3 * a), (-1.0, 3 * a + "z")],
        b + b: [(2 * nu, a + "zz"), (2 * nu, a + b + b), (-1.0, a + b + b + "z")],
        "zz": [(-1.0, a + "zzz")],
        "xy": [(1.0, b + "zz"), (2 * nu, a + a + b), (-1.0, a + a + b + "z")],
        a + "z": [(1.0, "zzz"), (-1.0, a + a + "zz")],
        b + "z": [(-1.0, a + b + "zz")],
    }


def _by_pressure(nu: float) -> dict[str, list[tuple[float, str]]]:
    """Stresses times 2 pi by a pressure, as derivatives of its potential; those of fourth order are
    to be multiplied by the depth.
    """
    slip = 1 - 2 * nu
    return {
        "xx": [(2 * nu, "zzz"), (-slip, "xxz"), (-1.0, "xxzz")],
        "yy": [(2 * nu, "zzz"), (-slip, "yyz"), (-1.0, "yyzz")],
        "zz": [(1.0, "zzz"), (-1.0, "zzzz")],
        "xy": [(-slip, "xyz"), (-1.0, "xyzz")],
        "xz": [(-1.0, "xzzz")],
        "yz": [(-1.0, "yzzz")],
    }


@lru_cache(maxsize=16)
def stress_matrix(nu: float) -> np.ndarray:
    """Five coordinates (3 tractions, 5, derivatives): those of fourth order count times z."""
    matrix = np.zeros((3, len(COMPONENTS), len(DERIVATIVES)))
    each = (_by_traction("x", "y", nu), _by_traction("y", "x", nu), _by_pressure(nu))
    for traction, components in enumerate(each):
        for component, terms in components.items():
            row = matrix[traction, COMPONENTS.index(component)]
            for factor, name in terms:
                for sign, plain in plain_terms("".join(sorted(name))):
                    row[DERIVATIVES.index(plain)] += factor * sign
    return TO_COORDINATES @ matrix / (2 * np.pi)


def depth_matrix(nu: float) -> np.ndarray:
    """Coordinates (3 tractions, 5, derivatives) of W in ``e_zz = -(d^2/dx^2 + d^2/dy^2) W``: with e
    = A + z B, W is e plus twice the antiderivative of B along z, all terms of which have a z.
    """
    matrix = np.zeros((3, len(COMPONENTS), len(DERIVATIVES)))
    each = (_by_traction("x", "y", nu), _by_traction("y", "x", nu), _by_pressure(nu))
    for traction, components in enumerate(each):
        for component, terms in components.items():
            row = matrix[traction, COMPONENTS.index(component)]
            for factor, name in terms:
                if len(name) < 4:
                    continue
                for sign, plain in plain_terms("".join(sorted(name)).replace("z", "", 1)):
                    row[DERIVATIVES.index(plain)] += 2 * factor * sign
    return stress_matrix(nu) + TO_COORDINATES @ matrix / (2 * np.pi)


def point_derivatives(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """The derivatives (16, n) of Omega; those of fourth order by complex steps."""
    step = 1e-30j
    third = _third_of_point(x, y, z)
    along_x = _third_of_point(x + step, y, z).imag / step.imag
    along_y = _third_of_point(x, y + step, z).imag / step.imag
    down = _third_of_point(x, y, z + step).imag / step.imag
    fourth = (*along_x[:4], along_y[3], *down[:4])
    return np.array([*third, *fourth])


def _third_of_point(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    rho = np.sqrt(x * x + y * y + z * z)
    sum_ = rho + z
    first = 1 / (rho * sum_**2)
    second = 1 / (rho**3 * sum_**2) + 2 / (rho**2 * sum_**3)
    third = 1 / (rho**3 * sum_) + 1 / (rho**2 * sum_**2)
    flat = 1 / (rho * sum_)
    return np.array(
        [
            3 * x * first - x**3 * second,
            y * first - x**2 * y * second,
            x * first - x * y**2 * second,
            3 * y * first - y**3 * second,
            flat - x**2 * third,
            -x * y * third,
            flat - y**2 * third,
        ]
    )


def corner_derivatives(x: np.ndarray, y: np.ndarray, z: float | np.ndarray) -> np.ndarray:
    """The derivatives (16, ...) of L."""
    rho = np.sqrt(x * x + y * y + z * z)
    tiny = np.finfo(float).tiny
    log = np.log(np.maximum(rho + z, tiny))
    beside_x = _inverse_sinh(x, np.sqrt(np.maximum(y * y + z * z, tiny)), rho)
    beside_y = _inverse_sinh(y, np.sqrt(np.maximum(x * x + z * z, tiny)), rho)
    turned = x * y * (rho - z)
    angle_x = np.arctan(turned / np.maximum(x * x * rho + y * y * z, tiny))
    angle_y = np.arctan(turned / np.maximum(y * y * rho + x * x * z, tiny))
    fourth = {
        "xxxx": 2 * rho - y * beside_y - z * log,
        "xxxy": z * angle_x - x * beside_y,
        "xxyy": z * log - rho,
        "xyyy": z * angle_y - y * beside_x,
        "yyyy": 2 * rho - x * beside_x - z * log,
        "xxxz": y * angle_x - x * log,
        "xxyz": x * angle_x + y * log + z * beside_y,
        "xyyz": y * angle_y + x * log + z * beside_x,
        "yyyz": x * angle_y - y * log,
    }
    found = np.empty((len(DERIVATIVES), *rho.shape))
    for number, name in enumerate(FOURTH):
        found[len(THIRD) + number] = fourth[name]
    # the third ones by Euler's theorem
    zz = {"xx": "xxxx xxyy", "xy": "xxxy xyyy", "yy": "xxyy yyyy"}
    for number, name in enumerate(THIRD):
        along_x = fourth["".join(sorted("x" + name))]
        along_y = fourth["".join(sorted("y" + name))]
        if name[-1] == "z":
            first, second = zz[name[:2]].split()
            down = -fourth[first] - fourth[second]
        else:
            down = fourth[name + "z"]
        found[number] = (x * along_x + y * along_y + z * down) / 2
    return found


def _inverse_sinh(x: np.ndarray, other: np.ndarray, rho: np.ndarray) -> np.ndarray:
    """Inverse hyperbolic sine of x/other, where rho is the hypotenuse."""
    return np.copysign(np.log(np.maximum(np.abs(x) + rho, other) / other), x)


@dataclass(frozen=True, eq=False)
class HalfSpace:
    """Bilinear tractions on a half-space, and their stresses in axes with z into it.

    Attributes
    ----------
    load : ndarray, shape (3, ny, nx)
        Tractions along x and y, and pressure, at the nodes; zero at the outermost and beyond
        [force/area].
    grid : Grid
        Its elements' centres are the nodes.
    nu : float
        Poisson's ratio.
    """

    load: np.ndarray
    grid: Grid
    nu: float

    def table(self, depth: float, most_y: int, most_x: int) -> np.ndarray:
        """Coordinates (3 tractions, 5, y, x) at a depth, by a hat of traction 1, at distances from
        zero on by so many elements.
        """
        dx, dy = self.grid.sides
        x = dx * np.arange(most_x + 2)
        y = dy * np.arange(most_y + 2)
        corners = corner_derivatives(x[None, :], y[:, None], depth)
        hats = np.empty((len(DERIVATIVES), most_y + 1, most_x + 1))
        for number, name in enumerate(DERIVATIVES):
            across = _second_difference(corners[number], (-1.0) ** name.count("y"))
            both = _second_difference(across.T, (-1.0) ** name.count("x")).T
            hats[number] = both / (dx * dy)
        hats[len(THIRD) :] *= depth
        found = stress_matrix(self.nu).reshape(15, -1) @ hats.reshape(len(DERIVATIVES), -1)
        return found.reshape(3, 5, most_y + 1, most_x + 1)

    @lazy_property
    def kinks(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Places x and y (n,) of the nodes, and mixed second differences (n, 3) of the tractions,
        divided by the area of an element, where they are not zero.
        """
        wide = np.pad(self.load, ((0, 0), (1, 1), (1, 1)))
        mixed = np.diff(np.diff(wide, 2, axis=1), 2, axis=2) / self.grid.area
        rows, columns = np.nonzero(mixed.any(axis=0))
        return self.grid.x[columns], self.grid.y[rows], mixed[:, rows, columns].T

    def stress(self, points: np.ndarray) -> np.ndarray:
        """Coordinates (n, 5) at points (3, n)."""
        x, y, kinks = self.kinks
        found = np.empty((points.shape[1], 5))
        third = len(THIRD)
        size = max(1, CHUNK // len(x))
        for first in range(0, points.shape[1], size):
            chosen = slice(first, first + size)
            along, across, down = points[:, chosen, None]
            corners = corner_derivatives(along - x, across - y, down)
            summed = corners @ kinks
            summed[third:] *= down
            found[chosen] = np.einsum("tcd,dnt->nc", stress_matrix(self.nu), summed)
        return found


CHUNK = 16_000
"""Pairs of points and nodes at once."""


def _second_difference(values: np.ndarray, sign: float) -> np.ndarray:
    """Second difference along the first axis, of values at distances 0, 1, ... that are even or
    odd.
    """
    before = np.concatenate([sign * values[1:2], values[:-2]])
    return before - 2 * values[:-1] + values[1:]
