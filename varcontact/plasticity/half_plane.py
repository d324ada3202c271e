"""Stress in a half-plane whose surface carries tractions that are linear between nodes: closed
form, and bounds between the samples of a lattice.

With the complex place ``w = x - x_j + i z`` from the node j, and the change c_j of the slope of a
traction there, ``Phi = sum c_j w ln(w) / pi`` is ``v - i u``: u is the traction's mean by Poisson's
kernel at the depth z, v its conjugate. Stresses are ``A + z B``, both harmonic: B by ``Phi'``.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from varcontact.plasticity.passage import coordinates
from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property

HEIGHT = 1 / 4
"""Largest height of the triangle that is the error of linear interpolation at a kink of slope 1,
divided by the step."""
AREA = 1 / 8
"""Largest area of this triangle, divided by the square of the step."""
CONJUGATE = 0.3
"""Bound on the conjugate function of such a triangle, divided by the step: ``(1/pi) (1/4 +
ln(16)/4)``."""


@dataclass(frozen=True, eq=False)
class HalfPlane:
    """Tractions along x and y and a pressure, by the changes of their slopes at nodes.

    Attributes
    ----------
    kinks : ndarray, shape (3, n)
        Changes of the slopes [force/area/length].
    first, spacing : float
        Place of the first node, and distance of the nodes [length].
    nu : float
        Poisson's ratio.
    beyond : int
        Nodes before and behind the others, to which samples reach: one at each node.
    """

    kinks: np.ndarray
    first: float
    spacing: float
    nu: float
    beyond: int
    _known: dict[float, tuple[np.ndarray, np.ndarray]] = field(
        default_factory=dict, init=False, repr=False
    )

    @classmethod
    def of(cls, load: np.ndarray, grid: Grid, nu: float, beyond: int) -> HalfPlane:
        """Half-plane loaded by values (3, n) at the centres of strips; the first and the last are
        zero.
        """
        spacing = grid.sides[0]
        slopes = np.diff(load, axis=1) / spacing
        kinks = np.diff(np.pad(slopes, ((0, 0), (1, 1))), axis=1)
        return cls(kinks, float(grid.x[0]), spacing, nu, beyond)

    @property
    def nodes(self) -> np.ndarray:
        """Places (n,) [length]."""
        return self.first + self.spacing * np.arange(self.kinks.shape[1])

    @property
    def x(self) -> np.ndarray:
        """Places of the samples [length]."""
        count = self.kinks.shape[1]
        return self.first + self.spacing * np.arange(-self.beyond, count + self.beyond)

    @property
    def forces(self) -> np.ndarray:
        """Upper bounds on the integrals of the tractions' sizes, shape (3,) [force/length]."""
        values = np.cumsum(np.cumsum(self.kinks, axis=1), axis=1) * self.spacing
        return np.asarray(np.abs(values).sum(axis=1) * self.spacing)

    @property
    def uniaxial(self) -> float:
        """Size of the deviator of a radial stress of 1."""
        return float(np.sqrt((1 - self.nu + self.nu**2) / 3))

    def curve(self, depth: float) -> np.ndarray:
        """Coordinates (samples, 5) of the stress at a depth."""
        mean, slope = self.stress(depth)
        if depth == 0:
            return mean
        return mean + depth * slope

    def stress(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates (samples, 5) of A and of B at a depth; B is infinite at the kinks of the
        surface.
        """
        if depth not in self._known:
            steps = self.spacing * np.arange(-self._most, self._most + 1)
            tables = np.array(_of_kink(steps, depth))
            self._known[depth] = self._coordinates(*self._summed(tables[:, None]))
        return self._known[depth]

    def stress_at(self, x: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates (n, 5) of A and of B at places x (n,) and a depth."""
        potential, derivative = _of_kink(x - self.nodes[:, None], depth)
        return self._coordinates(self.kinks @ potential, self.kinks @ derivative)

    def _coordinates(
        self, potential: np.ndarray, derivative: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates (n, 5) of A and B by Phi and its derivative (3, n)."""
        u = -potential.imag
        v = potential.real
        u_x = -derivative.imag
        u_z = -derivative.real
        none = np.zeros(u.shape[1])
        xx = -u[2] - 2 * v[0]
        zz = -u[2]
        yy = self.nu * (xx + zz)
        mean = np.array([[xx, -v[1], -u[0]], [-v[1], yy, -u[1]], [-u[0], -u[1], zz]])
        turned = u_z[2] + u_x[0]
        sheared = u_x[2] - u_z[0]
        slope = np.array([[-turned, none, sheared], [none, none, none], [sheared, none, turned]])
        return coordinates(mean), coordinates(slope)

    @property
    def _most(self) -> int:
        """Steps from the first node to the last sample."""
        return self.kinks.shape[1] - 1 + self.beyond

    @property
    def _samples(self) -> slice:
        """Places of the samples among the sums over nodes."""
        count = self.kinks.shape[1]
        return slice(count - 1, 2 * count - 1 + 2 * self.beyond)

    @lazy_property
    def _length(self) -> int:
        """Length of the transforms of tables over the steps from node to sample."""
        from scipy.fft import next_fast_len

        return int(next_fast_len(3 * self._most + 1, real=True))

    @lazy_property
    def _spectrum(self) -> np.ndarray:
        from scipy import fft

        return np.asarray(fft.fft(self.kinks, self._length))

    @lazy_property
    def _spectrum_of_sizes(self) -> np.ndarray:
        from scipy import fft

        return np.asarray(fft.rfft(np.abs(self.kinks), self._length))

    def _summed(self, tables: np.ndarray) -> np.ndarray:
        """Sums (..., 3, samples) over the kinks, of complex tables (..., 1, steps)."""
        from scipy import fft

        acting = self.kinks.any(axis=1)
        product = fft.fft(tables, self._length) * self._spectrum[acting]
        sums = np.zeros((*product.shape[:-2], 3, self._samples.stop - self._samples.start), complex)
        sums[..., acting, :] = fft.ifft(product, overwrite_x=True)[..., self._samples]
        return sums

    # ------------------------------------------------------------------------- bounds

    def between(self, depth: float, ahead: float) -> np.ndarray:
        """Bound (samples,) on how far ``A + z B + ahead B`` is from its linear interpolation
        between a sample and the next.
        """
        from scipy import fft

        number = np.arange(-self._most, self._most + 1)
        apart = self.spacing * np.where(number >= 0, number, -number - 1)
        tables = np.array(self._of_triangle(apart, self.spacing, depth, ahead))
        product = np.sum(fft.rfft(tables, self._length) * self._spectrum_of_sizes, axis=0)
        return np.maximum(fft.irfft(product, self._length)[self._samples], 0.0)

    def between_at(self, x: np.ndarray, step: float, depth: float, ahead: float) -> np.ndarray:
        """Bound (n,) on how far ``A + z B + ahead B`` is from its linear interpolation between
        places x (n,) and x + `step`, a part of the spacing.
        """
        from_node = x - self.nodes[:, None]
        apart = np.where(from_node >= -step / 2, from_node, -from_node - step)
        bounds = self._of_triangle(np.maximum(apart, 0.0), step, depth, ahead)
        return np.asarray(
            sum(size @ bound for size, bound in zip(np.abs(self.kinks), bounds, strict=True))
        )

    def _of_triangle(
        self, apart: np.ndarray, step: float, depth: float, ahead: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Bounds on the stress by a triangle of traction, along x and y and of pressure, at places
        so far before or behind it: tractions between two samples differ by it, for a kink of 1,
        from linear interpolation.
        """
        square = np.maximum(apart**2 + depth**2, np.finfo(float).tiny)
        area = AREA * step**2
        height = HEIGHT * step
        far = 1 / np.sqrt(square)
        curved = area / square / np.pi
        if depth > 0:
            curved = np.minimum(curved, height / depth)
        pressed = np.minimum(area * depth / square / np.pi, height) * 2 * self.uniaxial
        conjugate = 2 * self.uniaxial * CONJUGATE * step
        sheared = np.minimum(
            2 * self.uniaxial * area * far / np.pi, conjugate + height * (1 + 2 / np.pi)
        )
        lateral = np.minimum(area * far / np.pi, np.hypot(height, CONJUGATE * step))
        return sheared + ahead * curved, lateral, pressed + ahead * curved

    def near_surface(self, depth: float) -> float:
        """Bound on z B at the depths from the surface to one, at the samples and between them."""
        reach = (self.kinks.shape[1] + 2 * self.beyond) * self.spacing
        sizes = np.abs(self.kinks).sum(axis=1)
        total = float(sizes[0] + sizes[2])
        return depth * total * (np.log(reach / depth) + np.pi) / np.pi

    def beside(self, depth: float, ahead: float) -> float:
        """Bound on ``A + z B + ahead B`` before and behind the samples, at a depth."""
        along, across, pressure = self.forces
        distance = self.beyond * self.spacing
        pressed = pressure * depth / (depth**2 + distance**2)
        stress = 2 * self.uniaxial * (along / distance + pressed) + across / distance
        return float(stress + ahead * (along + pressure) / distance**2) / np.pi

    def below(self, depth: float) -> float:
        """Bound on the stress at a depth and deeper."""
        along, across, pressure = self.forces
        return float(2 * self.uniaxial * (along + pressure) + across) / (np.pi * depth)


def _of_kink(x: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Phi and its derivative at distances x from a kink of 1."""
    w = x + 1j * depth
    logarithm = np.log(np.where(w == 0, 1.0, w))
    return w * logarithm / np.pi, logarithm / np.pi
