"""Stress in a half-plane whose surface carries tractions that are linear between nodes: closed
form, and bounds between the samples of a lattice.

With the complex place ``w = x - x_j + i z`` from the node j, and the change c_j of the slope of a
traction there, ``Phi = sum c_j w ln(w) / pi`` is ``v - i u``: u is the traction's mean by Poisson's
kernel at the depth z, v its conjugate. Stresses are ``A + z B``, both harmonic: B by ``Phi'``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact.plasticity.passage import coordinates
from varcontact.system.process import lazy_property

HEIGHT = 1 / 4
"""Largest height of the triangle by which interpolation over a step misses a kink of slope 1, by
the step."""
AREA = 1 / 8
"""Its largest area, by the square of the step."""
CONJUGATE = 0.3
"""Bound on the conjugate function of such a triangle, by the step: ``(1/pi) (1/4 + ln(16)/4)``."""


@dataclass(frozen=True, eq=False)
class HalfPlane:
    """Tractions along x and y and a pressure, by the changes of their slopes at nodes.

    Attributes
    ----------
    kinks : ndarray, shape (3, n)
        Changes of the slopes [force/area/length].
    spacing : float
        Distance of the nodes [length].
    nu : float
        Poisson's ratio.
    parts : int
        Steps of the lattice of samples from node to node.
    beyond : int
        Nodes before and behind the others, to which samples reach.
    """

    kinks: np.ndarray
    spacing: float
    nu: float
    parts: int
    beyond: int

    @classmethod
    def of(cls, load: np.ndarray, spacing: float, nu: float, beyond: int) -> HalfPlane:
        """By values (3, n) at nodes, of which the first and the last are zero."""
        slopes = np.diff(load, axis=1) / spacing
        kinks = np.diff(np.pad(slopes, ((0, 0), (1, 1))), axis=1)
        return cls(kinks, spacing, nu, 1, beyond)

    def curve(self, depth: float) -> np.ndarray:
        """Coordinates (samples, 5) of the stress at a depth."""
        mean, slope = self.stress(depth)
        if depth == 0:
            return mean
        return mean + depth * slope

    def finer(self) -> HalfPlane:
        """The same with samples twice as close."""
        return replace(self, parts=2 * self.parts)

    @property
    def step(self) -> float:
        """Distance of the samples [length]."""
        return self.spacing / self.parts

    @property
    def forces(self) -> np.ndarray:
        """Upper bounds on the integrals of the tractions' sizes, shape (3,) [force/length]."""
        values = np.cumsum(np.cumsum(self.kinks, axis=1), axis=1) * self.spacing
        return np.asarray(np.abs(values).sum(axis=1) * self.spacing)

    @property
    def uniaxial(self) -> float:
        """Size of the deviator of a radial stress of 1."""
        return float(np.sqrt((1 - self.nu + self.nu**2) / 3))

    def stress(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates (n, 5) of A and of B at the samples of a depth; B is infinite at the kinks of
        the surface.
        """
        u, v, u_x, u_z = self._potentials(depth)
        none = np.zeros(u.shape[1])
        xx = -u[2] - 2 * v[0]
        zz = -u[2]
        yy = self.nu * (xx + zz)
        mean = np.array([[xx, -v[1], -u[0]], [-v[1], yy, -u[1]], [-u[0], -u[1], zz]])
        turned = u_z[2] + u_x[0]
        sheared = u_x[2] - u_z[0]
        slope = np.array([[-turned, none, sheared], [none, none, none], [sheared, none, turned]])
        return coordinates(mean), coordinates(slope)

    def _potentials(self, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """u, v, u_x and u_z of the three tractions, (3, samples)."""
        most = self._most
        w = self.step * np.arange(-most, most + 1) + 1j * depth
        logarithm = np.log(np.where(w == 0, 1.0, w))
        potential, derivative = self._summed(np.array([w * logarithm, logarithm])[:, None]) / np.pi
        return -potential.imag, potential.real, -derivative.imag, -derivative.real

    @property
    def _most(self) -> int:
        """Steps from the first node to the last sample."""
        return (self.kinks.shape[1] - 1 + self.beyond) * self.parts

    @property
    def _samples(self) -> slice:
        """Places of the samples among the sums over nodes."""
        first = (self.kinks.shape[1] - 1) * self.parts
        return slice(first, first + self._most + 1 + self.beyond * self.parts)

    @lazy_property
    def _length(self) -> int:
        """Of transforms of tables by the steps from node to sample."""
        from scipy.fft import next_fast_len

        return int(next_fast_len(3 * self._most + 1, real=True))

    @lazy_property
    def _spread(self) -> np.ndarray:
        """Kinks (3, samples) on the lattice of the samples."""
        spread = np.zeros((3, (self.kinks.shape[1] - 1) * self.parts + 1))
        spread[:, :: self.parts] = self.kinks
        return spread

    @lazy_property
    def _spectrum(self) -> np.ndarray:
        from scipy import fft

        return np.asarray(fft.fft(self._spread, self._length))

    @lazy_property
    def _spectrum_of_sizes(self) -> np.ndarray:
        from scipy import fft

        return np.asarray(fft.rfft(np.abs(self._spread), self._length))

    def _summed(self, tables: np.ndarray) -> np.ndarray:
        """Sums (..., 3, samples) over the kinks, of complex tables (..., 1, steps)."""
        from scipy import fft

        acting = self.kinks.any(axis=1)
        product = fft.fft(tables, self._length) * self._spectrum[acting]
        sums = np.zeros((*product.shape[:-2], 3, self._samples.stop - self._samples.start), complex)
        sums[..., acting, :] = fft.ifft(product, overwrite_x=True)[..., self._samples]
        return sums

    def _bounded(self, tables: np.ndarray) -> np.ndarray:
        """Sum (samples,) over the sizes of all kinks, of tables (3, steps)."""
        from scipy import fft

        product = np.sum(fft.rfft(tables, self._length) * self._spectrum_of_sizes, axis=0)
        return np.asarray(fft.irfft(product, self._length)[self._samples])

    # ------------------------------------------------------------------------- bounds

    def between(self, depth: float, ahead: float) -> np.ndarray:
        """Bound (samples,) on how far ``A + z B + ahead B`` is from its linear interpolation
        between a sample and the next.

        The tractions that do it are triangles at their kinks.
        """
        step = self.step
        number = np.arange(-self._most, self._most + 1)
        apart = step * np.where(number >= 0, number, -number - 1)
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
        tables = np.array([sheared + ahead * curved, lateral, pressed + ahead * curved])
        return np.maximum(self._bounded(tables), 0.0)

    def near_surface(self, depth: float) -> float:
        """Bound on z B at the depths from the surface to one."""
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
