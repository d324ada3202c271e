"""The problem linearised at a solution: slopes, and what swings along the track. Solved without a
matrix.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve

from varcontact import checks
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import with_subgrid
from varcontact.discrete.stick_slip import EXTERIOR, SLIP, STICK
from varcontact.elasticity.operators import fft_box, wrapped
from varcontact.errors import NotConverged, SceneError
from varcontact.results.solution import Solution
from varcontact.scene import consistency
from varcontact.scene.friction import Law
from varcontact.scene.motion import Steady
from varcontact.solvers.newton.kernel import CAUSAL, STICK_SHIFT, WIDER, fast_box, parzen
from varcontact.system.process import need, one_blas_thread
from varcontact.transports import DIFFERENCES, mirrored

TOLERANCE = 1e-10
"""Of the residual, relative to the right-hand side."""
ROUNDED = 1e-6
"""Of the residual in the space of all unknowns, at most."""
MOST = 1000
"""Directions of one solve; a few hundred are usual."""

Shifts = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Linearised:
    """The problem about a solution on the N elements of the grid, m of them with pressure;
    dimensionless.

    Unknowns are changes of traction along x and along y of the elements that `stick`, and those
    `across` the traction (2, s) of those that `slip`. Equations: no slip along both where it
    sticks; across it where it slips, with the change times the `turning` (s,). Changes (k, 3 N + 1:
    tractions, pressures, approach) are these, and what distances and the load change by themselves.
    k steps ago everything was ``exp(-i k Omega)`` of now: shifts are those of steady rolling plus
    those at each term of the slip's difference times ``z_k = weight_k (exp(-i k Omega) - 1)``.
    Where the pressure changes, tractions grow with it by `growing` (2, N), and `entering` where
    particles enter.
    """

    disc: Discretisation
    stick: np.ndarray  # places on the grid
    slip: np.ndarray
    across: np.ndarray
    turning: np.ndarray
    inputs: tuple[str, ...]
    shifts: np.ndarray  # by unit creepages, (creepages, 2, N)
    with_pressure: np.ndarray  # places on the grid
    # LU factors (m + 1, m + 1); None where no pressure changes
    normal: tuple[np.ndarray, np.ndarray] | None
    growing: np.ndarray
    entering: np.ndarray
    leading: np.ndarray  # bool (N,): elements there that stick
    # bool (N,): elements there that slip since the contact covers so little of them
    thin: np.ndarray

    @property
    def step(self) -> float:
        """Distance rolled in a step [length]; 0 in a shift."""
        return (self.disc.step or 0.0) * self.disc.scales.length

    @property
    def terms(self) -> list[tuple[int, float]]:
        """Steps ago and weights of the difference that slip is, other than now."""
        return [(ago, weight) for ago, weight in DIFFERENCES[self.disc.transport.difference] if ago]

    def resultants(self) -> tuple[tuple[str, ...], np.ndarray]:
        """Names of the resultants, and what they are of the changes, physical: (outputs, 3 N +
        1).
        """
        disc, N = self.disc, self.disc.grid.size
        x, y = (places.ravel() for places in np.meshgrid(disc.grid.x, disc.grid.y))
        force, sums = disc.lattice.area * disc.scales.force, np.zeros((5, 3 * N + 1))
        sums[0, :N] = sums[1, N : 2 * N] = sums[3, 2 * N : -1] = force
        sums[2, :N], sums[2, N : 2 * N] = -y * force, x * force
        sums[4, -1] = disc.scales.displacement
        there = [0, 1, 3, 4] if disc.grid.line else [0, 1, 2, 3, 4]
        return tuple(("Fx", "Fy", "Mz", "Fz", "approach")[i] for i in there), sums[there]

    def wave_numbers(self, field: str, given: Any, by_length: bool = False) -> np.ndarray:
        """Wave numbers (n,), given or `by_length`, of waves that the elements and the step
        resolve.
        """
        values, shortest = checks.numbers(field, given), 2 * max(self.step, self.disc.grid.sides[0])
        if values.ndim > 1 or values.size == 0:
            raise SceneError(field, given, "one number or a one-dimensional array")
        least, most = (shortest, np.inf) if by_length else (0.0, 2 * np.pi / shortest)
        allowed = f"at least {least:.6g}" if by_length else f"from 0 to {most:.6g}"
        good = (values >= least * (1 - 1e-12)) & (values <= most * (1 + 1e-12))
        checks.require_all(field, values, good, f"{allowed}, a wave of two elements")
        return np.atleast_1d(2 * np.pi / values if by_length else values)

    def responses(self, wave_numbers: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
        """For each wave number, in an order that halves their range, its place and the changes by
        unit inputs.

        The unknowns are found without a matrix of all elements, by Galerkin's method: in the space
        of those at the wave numbers before, and of preconditioned residuals.
        """
        scales, x = self.disc.scales, self.disc.grid.x[self.with_pressure % self.disc.grid.nx]
        known = np.zeros((self.size, 0), complex)
        images = [known] * (1 + len(self.terms))
        bits = len(wave_numbers).bit_length()
        halving = np.argsort([int(f"{i:0{bits}b}"[::-1], 2) for i in range(len(wave_numbers))])
        for i in np.argsort(wave_numbers)[halving]:
            k, phases = wave_numbers[i], self.phases(wave_numbers[i])
            shifts, loads = (
                self.shifting(phases),
                np.zeros((len(self.inputs), self.with_pressure.size + 1), complex),
            )
            if len(self.inputs) > len(self.shifts):
                force = self.disc.loading.normal_force is not None
                loads[-2, -1] = 1 / (
                    self.disc.lattice.area * scales.force if force else scales.displacement
                )
                loads[-1, :-1] = np.exp(1j * k * x) / scales.displacement
            given = self.changes(np.zeros((self.size, len(loads)), complex), loads)
            fields = self.fields(given)
            fields[:, :2] += (self.entering - self.growing) * self.thin * fields[:, 2:]
            right = shifts(fields)
            right[: len(self.shifts)] += self.shifts * self.mean(k)
            if self.normal is not None:
                before = shifts(self.entering * fields[:, 2:])
                right += self.leading * (np.roll(before, 1, axis=-1) - before)
            combined = np.tensordot(phases, images, axes=1)
            basis, parts = self._solved(phases, -self.equations(right), known, combined)
            yield i, given + self.changes(basis @ parts)
            size = known.shape[1]
            if size < min(basis.shape[1], MOST // 2):
                new = basis[:, size:] @ np.linalg.qr(parts[size:])[0]
                known = np.concatenate([known, new], axis=1)
                of_terms = [
                    self._images(one, self.shifting(one), new) for one in np.eye(len(images))
                ]
                images = [
                    np.concatenate(each, axis=1) for each in zip(images, of_terms, strict=True)
                ]

    def _solved(
        self, phases: np.ndarray, right: np.ndarray, basis: np.ndarray, images: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """An orthonormal basis with the unknowns, which begins with one that is known, and their
        parts of it.
        """
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
                raise NotConverged(
                    f"the response was not found in {count} directions",
                    float(np.abs(residual).max()),
                )
            new = precondition(residual[:, missing])[:, : size - count]
            for _ in range(2):  # rounding leaves some in the first
                new = np.linalg.qr(new - basis @ (new.conj().T @ basis).conj().T)[0]
            image = self._images(phases, shifts, new)
            across, below = (image.conj().T @ basis).conj().T, new.conj().T @ images
            basis, images = (
                np.concatenate([basis, new], axis=1),
                np.concatenate([images, image], axis=1),
            )
            projected = np.block([[projected, across], [below, new.conj().T @ image]])

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return 2 * self.stick.size + self.slip.size

    def equations(self, shifts: np.ndarray) -> np.ndarray:
        """Left-hand sides (size, k) by shifts (k, 2, N), but for the turning."""
        stuck = shifts[:, :, self.stick].reshape(len(shifts), -1)
        return np.concatenate(
            [stuck, (self.across * shifts[:, :, self.slip]).sum(axis=1)], axis=1
        ).T

    def changes(self, unknowns: np.ndarray, loads: np.ndarray | None = None) -> np.ndarray:
        """Changes (k, 3 N + 1) by the unknowns, and by those of distances and of the load (k, m +
        1), if any.
        """
        count, stuck = unknowns.shape[1], 2 * self.stick.size
        found = np.zeros((count, 3 * self.disc.grid.size + 1), complex)
        fields = self.fields(found)
        fields[:, :2, self.stick] = unknowns[:stuck].T.reshape(count, 2, -1)
        fields[:, :2, self.slip] = self.across * unknowns[stuck:].T[:, None]
        if self.normal is None or (loads is None and self.disc.K == 0):
            return found
        right = np.zeros((self.with_pressure.size + 1, count), complex)
        if loads is not None:
            right += loads.T
        if self.disc.K != 0:
            symbol = self._symbol(self.disc.operators.traction_to_distance.table)
            right[:-1] -= self._filtered(symbol, fields[:, :2])[:, 0, self.with_pressure].T
        solved = np.ascontiguousarray(lu_solve(self.normal, right.view(float))).view(complex)
        fields[:, 2, self.with_pressure], found[:, -1] = solved[:-1].T, solved[-1]
        fields[:, :2] += self.growing * fields[:, 2:]
        return found

    def fields(self, changes: np.ndarray) -> np.ndarray:
        """Tractions along x and y, and pressures, of changes: a view (k, 3, N)."""
        return changes[:, :-1].reshape(len(changes), 3, -1)

    def phases(self, k: float) -> np.ndarray:
        """Factors of the steady shifts, and of the displacements at each term, at a wave number, (1
        + terms,).
        """
        return np.array(
            [1.0, *(weight * np.expm1(-1j * k * self.step * ago) for ago, weight in self.terms)]
        )

    def shifting(self, phases: np.ndarray, way: int = 1) -> Shifts:
        """Shifts in a step (k, 2, N) by fields (k, 2 or 3, N), with phases.

        With a `way` of -1 those of particles that go the other way: the transposed operators of
        elastic bodies.
        """
        symbol, compliance = self._symbol(self._table(phases, way)), self.disc.edge_compliance

        def shifts(fields: np.ndarray) -> np.ndarray:
            found = self._filtered(symbol, fields[:, : symbol.shape[1]])
            if compliance is not None:
                found += phases[0] * compliance.reshape(2, -1) * fields[:, :2]
            return found

        return shifts

    def _table(self, phases: np.ndarray, way: int = 1) -> np.ndarray:
        """Influence numbers of shifts in a step, by tractions and, where they matter, pressures."""
        disc, operators = self.disc, self.disc.operators
        rolled = way * (disc.step or 0.0)
        stencil = disc.transport.stencil if way == 1 else mirrored(disc.transport.stencil)
        steady = operators.tangential(stencil).table
        if disc.K != 0:
            steady = np.concatenate([steady, operators.pressure_to_shift(stencil).table], axis=1)
        carried = [operators.carrying(ago * rolled).table for ago, _ in self.terms]
        return np.tensordot(phases, [steady, *carried], axes=1)

    def _symbol(self, table: np.ndarray) -> np.ndarray:
        from scipy.fft import fft2

        return np.asarray(fft2(wrapped(table.astype(complex), fft_box(*self.disc.grid.shape))))

    def _images(self, phases: np.ndarray, shifts: Shifts, unknowns: np.ndarray) -> np.ndarray:
        """Left-hand sides (unknowns, k) by unknowns."""
        found, turned = (
            self.equations(shifts(self.fields(self.changes(unknowns)))),
            2 * self.stick.size,
        )
        found[turned:] += phases[0] * self.turning[:, None] * unknowns[turned:]
        return found

    def _filtered(self, symbol: np.ndarray, fields: np.ndarray) -> np.ndarray:
        """Product (k, rows, N) of a symbol (rows, columns) on a periodic box with complex fields
        (k, columns, N).
        """
        from scipy.fft import fft2, ifft2

        ny, nx = self.disc.grid.shape
        spectrum = fft2(fields.reshape(*fields.shape[:2], ny, nx), symbol.shape[2:])
        product = sum(symbol[:, i] * spectrum[:, None, i] for i in range(fields.shape[1]))
        return np.asarray(ifft2(product, overwrite_x=True)[..., :ny, :nx]).reshape(
            len(fields), -1, ny * nx
        )

    def _preconditioner(self, phases: np.ndarray) -> Shifts:
        """Nearly the unknowns by left-hand sides: the operator's inverse on a periodic box, element
        by element in slip.

        The box and its weights are those of the Newton solver, see its `Circulant`.
        """
        from scipy.fft import fft2

        (ny, nx), table = self.disc.grid.shape, self._table(phases)[:, :2]
        own = abs(np.trace(table[:, :, ny - 1, nx - 1])) / 2
        rows, columns = box = fast_box(int(WIDER * ny), int(WIDER * nx))
        y, x = np.arange(-(ny - 1), ny), np.arange(-(nx - 1), nx)
        window = parzen(y / rows)[:, None] * parzen(x / columns) * CAUSAL ** (-x / columns)
        symbol = np.moveaxis(fft2(wrapped(table * window, box)), (0, 1), (2, 3))
        inverse = np.moveaxis(np.linalg.inv(symbol + STICK_SHIFT * own * np.eye(2)), (2, 3), (0, 1))
        growth, turned = np.tile(CAUSAL ** (np.arange(nx) / columns), ny), 2 * self.stick.size

        def solved(right: np.ndarray) -> np.ndarray:
            k = right.shape[1]
            fields = np.zeros((k, 2, ny * nx), complex)
            fields[:, :, self.stick] = right[:turned].T.reshape(k, 2, -1)
            stuck = (
                (self._filtered(inverse, fields / growth) * growth)[:, :, self.stick]
                .reshape(k, -1)
                .T
            )
            return np.concatenate([stuck, right[turned:] / (own + self.turning)[:, None]])

        return solved

    def mean(self, k: float) -> complex:
        """Mean of a swing over the step, by that at its end."""
        return complex(self.phases(k)[1:].sum() / (1j * k * self.step)) if k else 1.0


@one_blas_thread()
def sensitivity(sol: Solution) -> np.ndarray:
    """Derivatives of the forces by the creepages, see `Solution.sensitivity`, with given areas at
    their solution.
    """
    problem = linearise(sol, swings=False)
    ((_, changes),) = problem.responses(np.zeros(1))
    slopes = (problem.resultants()[1][:2] @ changes.T).real
    return np.pad(slopes, ((0, 0), (0, 3 - slopes.shape[1])))  # line contact has no spin


def check_linear(sol: Solution, swings: bool) -> None:
    """Refuse solutions about which the problem cannot be linearised."""
    scene, plan = sol.scene, sol.plan
    steady, what = (
        isinstance(scene.motion, Steady),
        "what swings" if swings else "the stiffness of a step",
    )
    if scene.motion is None:
        raise SceneError("motion", None, "given: without it there is no creepage")
    if plan.theory is not None or plan.coupling == "johnson":
        approximate = plan.tangential if plan.theory is not None else plan.coupling
        raise SceneError("solution", approximate, "by an exact method: this one is approximate")
    if isinstance(scene.friction, Law) and scene.friction.continuous:
        allowed = "a number or StaticKinetic: it must not fall with slip velocity"
        raise SceneError("friction", scene.friction, allowed)
    consistency.check_linear(scene)
    if swings and not steady:
        raise SceneError(
            "motion", type(scene.motion).__name__, "Steady: the response is about steady rolling"
        )
    if swings and scene.bodies.relaxes:
        raise SceneError("bodies", "viscoelastic", "elastic: the response of others is not known")
    if scene.shift_undetermined and (swings or not steady):
        if scene.bodies.slides and not swings:
            raise SceneError("bodies.base", "smooth", f'"rigid" or a half-space: {what} needs it')
        raise SceneError("surface.reference_depth", None, f"given: in line contact {what} needs it")


def unit_shifts(disc: Discretisation) -> np.ndarray:
    """Rigid shifts by unit creepages, (3, 2, N) (2 of them in line contact), dimensionless."""
    motion, every = disc.loading.motion, ("vx", "vy", "spin", "ux", "uy", "rotation")
    assert motion is not None
    still: dict[str, Any] = {
        **{name: 0.0 for name in every if hasattr(motion, name)},
        "Fx": None,
        "Fy": None,
    }
    still |= {"rigid_slip": None} if hasattr(motion, "rigid_slip") else {}
    names = (every[:3] if motion.rolls else every[3:])[: 2 if disc.grid.line else 3]
    units = [replace(motion, **{**still, name: 1.0}) for name in names]
    return np.array([disc.with_loading(motion=unit).rigid_shift.reshape(2, -1) for unit in units])


def linearise(sol: Solution, swings: bool = True) -> Linearised:
    """The problem about a solution: of steady rolling for what swings, also the load and a
    height.
    """
    check_linear(sol, swings)
    contact = (sol.state != EXTERIOR) & (np.nan_to_num(sol.traction_bound, posinf=1.0) > 0)
    if swings and not contact.any():
        raise SceneError("solution", "no traction", "a contact with friction")
    disc = with_subgrid(discretise(sol.scene, sol.grid), sol.pressure_on_parts)
    scales, shifts, with_pressure = disc.scales, unit_shifts(disc), np.flatnonzero(sol.pressure > 0)
    stick, slip = (np.flatnonzero(contact & (sol.state == state)) for state in (STICK, SLIP))
    rolled = (disc.step or 1.0 / scales.length) * scales.length
    traction, shift = (
        sol.traction.reshape(2, -1)[:, slip] / scales.pressure,
        sol.slip.reshape(2, -1)[:, slip] * rolled,
    )
    size = np.hypot(*traction)
    across, turning = (
        np.array([-traction[1], traction[0]]) / size,
        np.hypot(*shift) / scales.displacement / size,
    )
    growing = np.zeros((2, sol.grid.size))
    growing[:, slip] = traction * scales.pressure / sol.pressure.ravel()[slip]
    inputs, force = ("vx", "vy", "spin")[: len(shifts)], disc.loading.normal_force is not None
    # parts do not follow a moving edge
    if swings and not disc.loading.no_slip and sol.grid.edge == "centres":
        inputs += ("normal_force" if force else "approach", "roughness")
    normal = None
    if disc.K != 0 or len(inputs) > len(shifts):
        m = with_pressure.size
        need("the linearised normal problem", 16.0 * m**2, "fewer elements fit")
        system = np.zeros((m + 1, m + 1))
        system[:m, :m], system[:m, m] = disc.operators.normal.dense(with_pressure), -1.0
        system[m, slice(0, m) if force else m] = 1.0
        if disc.K != 0:
            by_tractions = disc.operators.traction_to_distance.dense(with_pressure, slip).reshape(
                m, 2, -1
            )
            grown = np.einsum("min,in->mn", by_tractions, growing[:, slip])
            system[:m, np.searchsorted(with_pressure, slip)] += grown
        normal = lu_factor(system, overwrite_a=True)
    edge = _entering(sol, contact)
    return Linearised(
        disc, stick, slip, across, turning, inputs, shifts, with_pressure, normal, growing, *edge
    )


def _entering(sol: Solution, contact: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tractions (2, N) by pressure as particles bring them along at the leading edge; `leading` and
    `thin` elements.

    Where the edge moves, pressure and traction change as 1/sqrt of the distance from it, in the
    ratio that they have there. Particles enter such tractions without slip, which a difference over
    an element does not see: it is taken an element further on. The squares of both rise linearly
    from the edge, wherever that is in its element: the ratio is that of their slopes.
    """
    rows, size, pressure = np.arange(sol.grid.rows), np.hypot(*sol.traction), sol.pressure
    edge = sol.grid.nx - 1 - np.argmax(pressure[:, ::-1] > 0, axis=1)  # of each row
    near, far = np.maximum(edge - 1, 0), np.maximum(edge - 2, 0)
    rise, of = (
        size[rows, far] ** 2 - size[rows, near] ** 2,
        pressure[rows, far] ** 2 - pressure[rows, near] ** 2,
    )
    direction = sol.traction[:, rows, near] / np.where(size[rows, near] > 0, size[rows, near], 1.0)
    ratio = direction * np.sqrt(
        np.where((rise > 0) & (of > 0), rise, 0.0) / np.where(of > 0, of, 1.0)
    )
    first, stick = contact & (np.arange(sol.grid.nx) == edge[:, None]), sol.state == STICK
    behind = sol.state[rows, near][:, None]
    thin, leading = first & ~stick & (behind == STICK), first & stick & (behind != EXTERIOR)
    return (ratio[:, :, None] * contact).reshape(2, -1), leading.ravel(), thin.ravel()
