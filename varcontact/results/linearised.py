"""The problem linearised about steady rolling, for what swings along the track: solved without a matrix."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from varcontact import checks
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import with_subgrid
from varcontact.discrete.stick_slip import STICK
from varcontact.elasticity.operators import DIFFERENCES, fft_box, wrapped
from varcontact.errors import NotConverged, SceneError
from varcontact.results.sensitivity import Directions, check_linear, directions, unit_shifts, with_friction
from varcontact.results.solution import Solution
from varcontact.scene.motion import Steady
from varcontact.solvers.newton.kernel import CAUSAL, STICK_SHIFT, WIDER, fast_box, parzen
from varcontact.system.process import need

TOLERANCE = 1e-10
"""Of the residual, relative to the right-hand side."""
ROUNDED = 1e-6
"""Of the residual in the space of all unknowns, at most."""
MOST = 1000
"""Directions of one solve; a few hundred are usual."""

Shifts = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Linearised:
    """The problem about a steady solution: n elements that bear tractions, m with pressure; dimensionless.

    Changes (tractions, pressures, approach: 2 n + m + 1) are those of `Directions`, and what distances and the load
    change by themselves. k steps ago everything was ``exp(-i k Omega)`` of now: shifts are those of steady rolling plus
    those at each term of the slip's difference times ``z_k = weight_k (exp(-i k Omega) - 1)``. Where the pressure
    changes, tractions grow with it by `growing` (2, n), and `entering` where particles enter.
    """

    disc: Discretisation
    bearing: np.ndarray
    pressed: np.ndarray
    may: Directions
    inputs: tuple[str, ...]
    shifts: np.ndarray  # (2 n, creepages)
    normal: tuple[np.ndarray, np.ndarray] | None  # LU factors (m + 1, m + 1); None where no pressure changes
    growing: np.ndarray
    entering: np.ndarray
    leading: np.ndarray  # of the 2 n: shifts of elements there
    thin: np.ndarray  # bool (n,): elements there that slip since the contact covers so little of them

    @property
    def step(self) -> float:
        """Distance rolled in a step [length]."""
        assert self.disc.step is not None
        return self.disc.step * self.disc.scales.length

    @property
    def terms(self) -> list[tuple[int, float]]:
        """Steps ago and weights of the difference that slip is, other than now."""
        return [(ago, weight) for ago, weight in DIFFERENCES[self.disc.loading.slip_difference] if ago]

    @property
    def shortest(self) -> float:
        """Shortest wave that elements and step resolve: two of them [length]."""
        return 2 * max(self.step, self.disc.grid.sides[0])

    @cached_property
    def bears(self) -> np.ndarray:
        """Places of the n elements among the m."""
        return np.searchsorted(self.pressed, self.bearing)

    def resultants(self) -> tuple[tuple[str, ...], np.ndarray]:
        """Names of the resultants, and what they are of the changes, physical: (outputs, 2 n + m + 1)."""
        disc, n = self.disc, self.bearing.size
        iy, ix = np.divmod(self.bearing, disc.grid.nx)
        force, sums = disc.lattice.area * disc.scales.force, np.zeros((5, 2 * n + self.pressed.size + 1))
        sums[0, :n] = sums[1, n : 2 * n] = sums[3, 2 * n : -1] = force
        sums[2, :n], sums[2, n : 2 * n] = -disc.grid.y[iy] * force, disc.grid.x[ix] * force
        sums[4, -1] = disc.scales.displacement
        there = [0, 1, 3, 4] if disc.grid.line else [0, 1, 2, 3, 4]
        return tuple(("Fx", "Fy", "Mz", "Fz", "approach")[i] for i in there), sums[there]

    def check(self, wave_number: Any, field: str = "wave_number") -> np.ndarray:
        """Wave numbers of which the elements and the step resolve each, as an array (n,)."""
        k = np.atleast_1d(checks.numbers(field, wave_number))
        largest = 2 * np.pi / self.shortest
        allowed = f"from 0 to {largest:.6g}, a wave of two elements"
        if k.ndim != 1 or k.size == 0:
            raise SceneError(field, wave_number, "one number or a one-dimensional array")
        for each in k[(k < 0) | (k > largest * (1 + 1e-12))]:
            raise SceneError(field, float(each), allowed)
        return k

    def responses(self, wave_numbers: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
        """For each wave number, in an order that halves their range, its place and the changes by unit inputs.

        The unknowns are found without a matrix of all elements, by Galerkin's method: in the space of those at the wave
        numbers before, and of preconditioned residuals.
        """
        known = np.zeros((self.may.size, 0), complex)
        images = [known] * (1 + len(self.terms))
        bits = len(wave_numbers).bit_length()
        halving = np.argsort([int(f"{i:0{bits}b}"[::-1], 2) for i in range(len(wave_numbers))])
        for i in np.argsort(wave_numbers)[halving]:
            k, phases = wave_numbers[i], self.phases(wave_numbers[i])
            shifts = self.shifting(phases)
            rigid, normal = self._loads(k)
            given = self.changes(np.zeros((self.may.size, len(self.inputs)), complex), normal)
            given += self._with_pressure((self.entering - self.growing) * self.thin, given)
            right = rigid + shifts(given)
            if self.normal is not None:
                brought = shifts(self._with_pressure(self.entering, given))
                right[self.leading] += brought[self.leading - 1] - brought[self.leading]
            combined = np.tensordot(phases, images, axes=1)
            basis, parts = self._solved(phases, -self.may.equations(right), known, combined)
            yield i, given + self.changes(basis @ parts)
            size = known.shape[1]
            if size < min(basis.shape[1], MOST // 2):
                new = basis[:, size:] @ np.linalg.qr(parts[size:])[0]
                known = np.concatenate([known, new], axis=1)
                of_terms = [self._images(one, self.shifting(one), new) for one in np.eye(len(images))]
                images = [np.concatenate(each, axis=1) for each in zip(images, of_terms, strict=True)]

    def _solved(
        self, phases: np.ndarray, right: np.ndarray, basis: np.ndarray, images: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """An orthonormal basis with the unknowns, which begins with one that is known, and their parts of it."""
        shifts, precondition, size = self.shifting(phases), self._preconditioner(phases), len(right)
        projected, lengths = basis.conj().T @ images, np.linalg.norm(right, axis=0)
        while True:
            parts = np.linalg.solve(projected, (right.conj().T @ basis).conj().T)
            residual = right - images @ parts
            sizes, count = np.linalg.norm(residual, axis=0), basis.shape[1]
            missing = ~(sizes <= TOLERANCE * lengths)  # also where there is NaN
            if not missing.any() or (count == size and np.all(sizes < ROUNDED * lengths)):
                return basis, parts
            if count >= min(size, MOST):
                raise NotConverged(f"the response was not found in {count} directions", float(np.abs(residual).max()))
            new = precondition(residual[:, missing])[:, : size - count]
            for _ in range(2):  # rounding leaves some in the first
                new = np.linalg.qr(new - basis @ (new.conj().T @ basis).conj().T)[0]
            image = self._images(phases, shifts, new)
            across, below = (image.conj().T @ basis).conj().T, new.conj().T @ images
            basis, images = np.concatenate([basis, new], axis=1), np.concatenate([images, image], axis=1)
            projected = np.block([[projected, across], [below, new.conj().T @ image]])

    def changes(self, unknowns: np.ndarray, normal: np.ndarray | None = None) -> np.ndarray:
        """Changes (2 n + m + 1, k) by the unknowns, and by those of distances and of the load (m + 1, k), if any."""
        found = np.zeros((2 * self.bearing.size + self.pressed.size + 1, unknowns.shape[1]), complex)
        tractions = found[: 2 * self.bearing.size]
        tractions[:] = self.may.tractions(unknowns)
        if self.normal is None or (normal is None and self.disc.K == 0):
            return found
        right = np.zeros_like(found[len(tractions) :]) if normal is None else normal.copy()
        if self.disc.K != 0:
            distances = _filtered(self._symbol(self.disc.operators.traction_to_distance.table), self.fields(found)[:2])
            right[:-1] -= distances.reshape(right.shape[1], -1)[:, self.pressed].T
        solved = lu_solve(self.normal, right.view(float))
        found[len(tractions) :] = np.ascontiguousarray(solved).view(complex)
        return found + self._with_pressure(self.growing, found)

    def phases(self, k: float) -> np.ndarray:
        """Factors of the steady shifts, and of the displacements at each term, at a wave number, (1 + terms,)."""
        return np.array([1.0, *(weight * np.expm1(-1j * k * self.step * ago) for ago, weight in self.terms)])

    def shifting(self, phases: np.ndarray, way: int = 1) -> Shifts:
        """Shifts in a step (2 n, k) by changes, with phases.

        With a `way` of -1 those of particles that go the other way: the transposed operators of elastic bodies.
        """
        disc, symbol = self.disc, self._symbol(self._table(phases, way))

        def shifts(changes: np.ndarray) -> np.ndarray:
            fields = self.fields(changes)[: symbol.shape[1]]
            found = _filtered(symbol, fields)
            if disc.edge_compliance is not None:
                found += phases[0] * disc.edge_compliance[:, None] * fields[:2]
            there = found.reshape(2, changes.shape[1], -1)[..., self.bearing]
            return np.moveaxis(there, 1, 2).reshape(-1, changes.shape[1])

        return shifts

    def _table(self, phases: np.ndarray, way: int = 1) -> np.ndarray:
        """Influence numbers of shifts in a step, by tractions and, where they matter, pressures."""
        disc = self.disc
        assert disc.step is not None
        rolled, difference, operators = way * disc.step, disc.loading.slip_difference, disc.operators
        steady = operators.tangential(rolled, difference).table
        if disc.K != 0:
            steady = np.concatenate([steady, operators.pressure_to_shift(rolled, difference).table], axis=1)
        carried = [operators.carrying(ago * rolled).table for ago, _ in self.terms]
        return np.tensordot(phases, [steady, *carried], axes=1)

    def _symbol(self, table: np.ndarray) -> np.ndarray:
        from scipy.fft import fft2

        return np.asarray(fft2(wrapped(table.astype(complex), fft_box(*self.disc.grid.shape))))

    def _images(self, phases: np.ndarray, shifts: Shifts, unknowns: np.ndarray) -> np.ndarray:
        """Left-hand sides (unknowns, k) by unknowns."""
        found, turned = self.may.equations(shifts(self.changes(unknowns))), 2 * self.may.stick.size
        found[turned:] += phases[0] * self.may.turning[:, None] * unknowns[turned:]
        return found

    def fields(self, changes: np.ndarray) -> np.ndarray:
        """Tractions along x and y, and pressures, on the whole grid, (3, k, ny, nx)."""
        grid, n = self.disc.grid, self.bearing.size
        fields = np.zeros((3, changes.shape[1], grid.size), complex)
        fields[:2, :, self.bearing] = np.moveaxis(changes[: 2 * n].reshape(2, n, changes.shape[1]), 1, 2)
        fields[2][:, self.pressed] = changes[2 * n : -1].T
        return fields.reshape(3, -1, *grid.shape)

    def _with_pressure(self, by_pressure: np.ndarray, changes: np.ndarray) -> np.ndarray:
        """Changes (2 n + m + 1, k) of tractions alone, that grow by pressure (2, n) with the pressures of changes."""
        pressures, found = changes[2 * self.bearing.size : -1][self.bears], np.zeros_like(changes)
        found[: 2 * self.bearing.size] = (by_pressure[:, :, None] * pressures).reshape(-1, changes.shape[1])
        return found

    def _preconditioner(self, phases: np.ndarray) -> Shifts:
        """Nearly the unknowns by left-hand sides: the operator's inverse on a periodic box, element by element in slip.

        The box and its weights are those of the Newton solver, see its `Circulant`.
        """
        from scipy.fft import fft2

        (ny, nx), may, table = self.disc.grid.shape, self.may, self._table(phases)[:, :2]
        own = abs(np.trace(table[:, :, ny - 1, nx - 1])) / 2
        rows, columns = box = fast_box(int(WIDER * ny), int(WIDER * nx))
        y, x = np.arange(-(ny - 1), ny), np.arange(-(nx - 1), nx)
        window = parzen(y / rows)[:, None] * parzen(x / columns) * CAUSAL ** (-x / columns)
        symbol = np.moveaxis(fft2(wrapped(table * window, box)), (0, 1), (2, 3))
        inverse = np.moveaxis(np.linalg.inv(symbol + STICK_SHIFT * own * np.eye(2)), (2, 3), (0, 1))
        growth, sticks, turned = CAUSAL ** (np.arange(nx) / columns), self.bearing[may.stick], 2 * may.stick.size

        def solved(right: np.ndarray) -> np.ndarray:
            k = right.shape[1]
            fields = np.zeros((2, k, ny * nx), complex)
            fields[:, :, sticks] = np.moveaxis(right[:turned].reshape(2, sticks.size, k), 1, 2)
            found = _filtered(inverse, fields.reshape(2, k, ny, nx) / growth) * growth
            stuck = np.moveaxis(found.reshape(2, k, ny * nx)[:, :, sticks], 1, 2)
            return np.concatenate([stuck.reshape(turned, k), right[turned:] / (own + may.turning)[:, None]])

        return solved

    def mean(self, k: float) -> complex:
        """Mean of a swing over the step, by that at its end."""
        return complex(self.phases(k)[1:].sum() / (1j * k * self.step)) if k else 1.0

    def _loads(self, k: float) -> tuple[np.ndarray, np.ndarray]:
        """Rigid shifts (2 n, inputs), and changes of distances and of the load (m + 1, inputs), by unit inputs."""
        scales, creepages = self.disc.scales, self.shifts.shape[1]
        rigid = np.zeros((len(self.shifts), len(self.inputs)), complex)
        rigid[:, :creepages] = self.shifts * self.mean(k)
        normal = np.zeros((self.pressed.size + 1, len(self.inputs)), complex)
        if len(self.inputs) > creepages:
            force = self.disc.loading.normal_force is not None
            normal[-1, -2] = 1 / (self.disc.lattice.area * scales.force if force else scales.displacement)
            x = self.disc.grid.x[self.pressed % self.disc.grid.nx]
            normal[:-1, -1] = np.exp(1j * k * x) / scales.displacement
        return rigid, normal


def linearise(sol: Solution) -> Linearised:
    """The problem about a solution of steady rolling; a `SceneError` refuses others."""
    scene = sol.scene
    check_linear(sol)
    if not isinstance(scene.motion, Steady):
        raise SceneError("motion", type(scene.motion).__name__, "Steady: the response is about steady rolling")
    if scene.bodies.relaxes:
        raise SceneError("bodies", "viscoelastic", "elastic: the response of others is not known")
    if scene.shift_undetermined:
        raise SceneError("surface.reference_depth", None, "given: in line contact what swings depends on it")
    bearing, pressed = with_friction(sol), np.flatnonzero(sol.pressure.ravel() > 0)
    if bearing.size == 0:
        raise SceneError("solution", "no traction", "a contact with friction")
    disc = with_subgrid(discretise(scene, sol.grid), sol.pressure_on_parts)
    may, shifts = directions(disc, sol, bearing), unit_shifts(disc)
    inputs, bears = ("vx", "vy", "spin")[: len(shifts)], np.searchsorted(pressed, bearing)
    entering, leading, thin = _entering(sol, bearing)
    growing = np.zeros((2, bearing.size))
    growing[:, may.slip] = may.by_pressure
    if not disc.loading.no_slip and sol.grid.edge == "centres":  # parts of elements do not follow a moving edge
        inputs += ("normal_force" if disc.loading.normal_force is not None else "approach", "roughness")
    normal = None
    if disc.K != 0 or len(inputs) > len(shifts):
        m, force = pressed.size, disc.loading.normal_force is not None
        need("the linearised normal problem", 16.0 * m**2, "fewer elements fit")
        system = np.zeros((m + 1, m + 1))
        system[:m, :m], system[:m, m] = disc.operators.normal.dense(pressed), -1.0
        system[m, slice(0, m) if force else m] = 1.0
        if disc.K != 0:
            by_tractions = disc.operators.traction_to_distance.dense(pressed, bearing).reshape(m, 2, -1)
            system[:m, bears] += np.einsum("min,in->mn", by_tractions, growing)
        normal = lu_factor(system, overwrite_a=True)
    rigid = shifts[:, :, bearing].reshape(len(shifts), -1).T
    return Linearised(disc, bearing, pressed, may, inputs, rigid, normal, growing, entering, leading, thin)


def _entering(sol: Solution, bearing: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tractions (2, n) by pressure as particles bring them along at the leading edge; `leading` and `thin` elements.

    Where the edge moves, pressure and traction change as 1/sqrt of the distance from it, in the ratio that they have
    there. Particles enter such tractions without slip, which a difference over an element does not see: it is taken an
    element further on. The squares of both rise linearly from the edge, wherever that is in its element: the ratio is
    that of their slopes.
    """
    iy, ix = np.divmod(bearing, sol.grid.nx)
    edge = sol.grid.nx - 1 - np.argmax(sol.pressure[:, ::-1] > 0, axis=1)[iy]  # of each row
    near, far = np.maximum(edge - 1, 0), np.maximum(edge - 2, 0)
    size, pressure = np.hypot(*sol.traction), sol.pressure
    rise, of = size[iy, far] ** 2 - size[iy, near] ** 2, pressure[iy, far] ** 2 - pressure[iy, near] ** 2
    direction = sol.traction[:, iy, near] / np.where(size[iy, near] > 0, size[iy, near], 1.0)
    ratio = direction * np.sqrt(np.where((rise > 0) & (of > 0), rise, 0.0) / np.where(of > 0, of, 1.0))
    first, stick = ix == edge, sol.state.ravel()[bearing] == STICK
    thin = first & ~stick & (sol.state[iy, near] == STICK)
    return ratio, np.flatnonzero(np.tile(first & stick & (sol.state[iy, near] != 0), 2)), thin


def _filtered(symbol: np.ndarray, fields: np.ndarray) -> np.ndarray:
    """Product of a symbol (rows, columns) on a periodic box with complex fields (columns, k, ny, nx)."""
    from scipy.fft import fft2, ifft2

    ny, nx = fields.shape[2:]
    spectrum = fft2(fields, symbol.shape[2:])
    product = np.array([sum(map(np.multiply, row, spectrum)) for row in symbol])
    return np.asarray(ifft2(product, overwrite_x=True)[..., :ny, :nx])
