"""The problem linearised at a solution, for what swings along the track. Solved without a
matrix.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import with_subgrid
from varcontact.discrete.stick_slip import EXTERIOR, SLIP, STICK
from varcontact.elasticity.fft_products import fft_box, wrapped
from varcontact.errors import NotConverged, SceneError
from varcontact.results.solution import Solution
from varcontact.scene import consistency
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.newton.kernel import CAUSAL, STICK_SHIFT, WIDER, fast_box, parzen
from varcontact.system.process import need
from varcontact.transports import DIFFERENCES, mirrored

RESIDUAL_TOL = 1e-10
"""Tolerance of the residual, relative to the right-hand side."""
RESIDUAL_TOL_ROUNDED = 1e-6
"""Tolerance of the residual, relative to the right-hand side, where the basis spans all unknowns
and only rounding is left."""
LEAST_RISE = 0.1
"""Rise of the squared pressure from the second to the third element of a row, relative to the
former, that is a slope; on an ellipse .67 of long rows, and none of four elements."""
DIRECTIONS_MAX = 1000
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
    # elements (N,) whose slip difference reaches over the leading edge, and by how many columns
    reaching: tuple[tuple[np.ndarray, int], ...]
    # bool (N,): elements there that slip since the contact covers so little of them
    thin: np.ndarray

    @property
    def step(self) -> float:
        """Distance rolled in a step [length]; 0 in a shift."""
        return (self.disc.step or 0.0) * self.disc.scales.length

    @property
    def terms(self) -> list[tuple[int, float]]:
        """Terms of the slip difference other than the present: steps ago, and weight."""
        return [(ago, weight) for ago, weight in DIFFERENCES[self.disc.transport.difference] if ago]

    def resultants(self) -> tuple[tuple[str, ...], np.ndarray]:
        """Names of the resultants, and the matrix (outputs, 3 N + 1) that gives them, physical,
        from the changes.
        """
        grid = self.disc.grid
        N = grid.size
        x, y = (places.ravel() for places in np.meshgrid(grid.x, grid.y))
        force = self.disc.lattice.area * self.disc.scales.force
        traction_x = slice(0, N)
        traction_y = slice(N, 2 * N)
        pressure = slice(2 * N, 3 * N)
        sums = np.zeros((5, 3 * N + 1))
        sums[0, traction_x] = force
        sums[1, traction_y] = force
        sums[2, traction_x] = -y * force
        sums[2, traction_y] = x * force
        sums[3, pressure] = force
        sums[4, -1] = self.disc.scales.displacement
        if grid.line:
            return ("Fx", "Fy", "Fz", "approach"), sums[[0, 1, 3, 4]]
        return ("Fx", "Fy", "Mz", "Fz", "approach"), sums

    def wave_numbers(self, field: str, given: Any, by_length: bool = False) -> np.ndarray:
        """Wave numbers (n,), given or `by_length`, of waves that the elements and the step
        resolve.
        """
        values = checks.numbers(field, given)
        shortest = 2 * max(self.step, self.disc.grid.sides[0])
        if values.ndim > 1 or values.size == 0:
            raise SceneError(field, given, "one number or a one-dimensional array")
        if by_length:
            allowed = f"at least {shortest:.6g}, a wave of two elements"
            checks.require_all(field, values, values >= shortest * (1 - 1e-12), allowed)
            return np.atleast_1d(2 * np.pi / values)
        largest = 2 * np.pi / shortest
        allowed = f"from 0 to {largest:.6g}, a wave of two elements"
        resolved = (values >= 0.0) & (values <= largest * (1 + 1e-12))
        checks.require_all(field, values, resolved, allowed)
        return np.atleast_1d(values)

    def responses(self, wave_numbers: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
        """Place and changes by unit inputs for each wave number, in an order that halves their
        range.

        The unknowns are found without a matrix of all elements, by Galerkin's method: in the space
        of those at the wave numbers before, and of preconditioned residuals.
        """
        space = np.zeros((self.size, 0), complex)
        # of the space, for the steady shifts and for each term of the difference
        images = [space] * (1 + len(self.terms))
        for i in np.argsort(wave_numbers)[_halving_order(len(wave_numbers))]:
            # the changes by the loads alone, and the slip that is left
            k = wave_numbers[i]
            phases = self.phases(k)
            loads = self._loads(k)
            loaded = self.changes(np.zeros((self.size, len(loads)), complex), loads)
            right = self._imposed_shifts(k, phases, self.fields(loaded))
            # the unknowns that remove it
            combined = np.tensordot(phases, images, axes=1)
            basis, parts = self._galerkin(phases, -self.equations(right), space, combined)
            yield i, loaded + self.changes(basis @ parts)
            # the next wave number starts from the unknowns of this one
            size = space.shape[1]
            if size < min(basis.shape[1], DIRECTIONS_MAX // 2):
                new = basis[:, size:] @ np.linalg.qr(parts[size:])[0]
                space = np.concatenate([space, new], axis=1)
                for term, phase in enumerate(np.eye(len(images))):
                    image = self._images(phase, self.shifting(phase), new)
                    images[term] = np.concatenate([images[term], image], axis=1)

    def _loads(self, k: float) -> np.ndarray:
        """Distances and load (inputs, m + 1) that unit inputs impose on the elements with
        pressure.
        """
        scales = self.disc.scales
        loads = np.zeros((len(self.inputs), self.with_pressure.size + 1), complex)
        if len(self.inputs) > len(self.shifts):
            unit = scales.displacement
            if self.disc.loading.normal_force is not None:
                unit = self.disc.lattice.area * scales.force
            x = self.disc.grid.x[self.with_pressure % self.disc.grid.nx]
            loads[-2, -1] = 1 / unit
            loads[-1, :-1] = np.exp(1j * k * x) / scales.displacement
        return loads

    def _imposed_shifts(self, k: float, phases: np.ndarray, fields: np.ndarray) -> np.ndarray:
        """Shifts (inputs, 2, N) by unit inputs and by the `fields` of their loads, in which
        tractions of `thin` elements become those that enter.
        """
        shifts = self.shifting(phases)
        fields[:, :2] += (self.entering - self.growing) * self.thin * fields[:, 2:]
        imposed = shifts(fields)
        imposed[: len(self.shifts)] += self.shifts * self.mean(k)
        if self.normal is not None:
            before = shifts(self.entering * fields[:, 2:])
            for elements, columns in self.reaching:
                imposed += elements * (np.roll(before, columns, axis=-1) - before)
        return imposed

    def _galerkin(
        self, phases: np.ndarray, right: np.ndarray, basis: np.ndarray, images: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Orthonormal basis that begins with the `basis` given, and the parts of the unknowns in
        it.
        """
        shifts = self.shifting(phases)
        precondition = self._preconditioner(phases)
        size = len(right)
        lengths = np.linalg.norm(right, axis=0)
        projected = basis.conj().T @ images
        while True:
            # unknowns in the basis, and the residual
            parts = np.linalg.solve(projected, (right.conj().T @ basis).conj().T)
            residual = right - images @ parts
            sizes = np.linalg.norm(residual, axis=0)
            count = basis.shape[1]
            missing = ~(sizes <= RESIDUAL_TOL * lengths)  # also for NaN
            rounded = count == size and np.all(sizes < RESIDUAL_TOL_ROUNDED * lengths)
            if rounded or not missing.any():
                return basis, parts
            if count >= min(size, DIRECTIONS_MAX):
                raise NotConverged(
                    f"the response was not found in {count} directions",
                    float(np.abs(residual).max()),
                )
            # preconditioned residuals join the basis
            new = precondition(residual[:, missing])[:, : size - count]
            for _ in range(2):  # the second pass removes rounding
                new = np.linalg.qr(new - basis @ (new.conj().T @ basis).conj().T)[0]
            image = self._images(phases, shifts, new)
            across = (image.conj().T @ basis).conj().T
            below = new.conj().T @ images
            projected = np.block([[projected, across], [below, new.conj().T @ image]])
            basis = np.concatenate([basis, new], axis=1)
            images = np.concatenate([images, image], axis=1)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return 2 * self.stick.size + self.slip.size

    def equations(self, shifts: np.ndarray) -> np.ndarray:
        """Left-hand sides (size, k) by shifts (k, 2, N), but for the turning."""
        stuck = shifts[:, :, self.stick].reshape(len(shifts), -1)
        turned = (self.across * shifts[:, :, self.slip]).sum(axis=1)
        return np.concatenate([stuck, turned], axis=1).T

    def changes(self, unknowns: np.ndarray, loads: np.ndarray | None = None) -> np.ndarray:
        """Changes (k, 3 N + 1) by the unknowns, and by those of distances and of the load (k, m +
        1), if any.
        """
        count = unknowns.shape[1]
        stuck = 2 * self.stick.size
        changes = np.zeros((count, 3 * self.disc.grid.size + 1), complex)
        fields = self.fields(changes)
        fields[:, :2, self.stick] = unknowns[:stuck].T.reshape(count, 2, -1)
        fields[:, :2, self.slip] = self.across * unknowns[stuck:].T[:, None]
        if self.normal is None or (loads is None and self.disc.K == 0):
            return changes
        from scipy.linalg import lu_solve

        # pressures and approach that the loads and the tractions give
        right = np.zeros((self.with_pressure.size + 1, count), complex)
        if loads is not None:
            right += loads.T
        if self.disc.K != 0:
            symbol = self._symbol(self.disc.operators.traction_to_distance.table)
            right[:-1] -= self._filtered(symbol, fields[:, :2])[:, 0, self.with_pressure].T
        solved = np.ascontiguousarray(lu_solve(self.normal, right.view(float))).view(complex)
        fields[:, 2, self.with_pressure] = solved[:-1].T
        changes[:, -1] = solved[-1]
        fields[:, :2] += self.growing * fields[:, 2:]
        return changes

    def fields(self, changes: np.ndarray) -> np.ndarray:
        """Tractions along x and y, and pressures, of changes: a view (k, 3, N)."""
        return changes[:, :-1].reshape(len(changes), 3, -1)

    def phases(self, k: float) -> np.ndarray:
        """Factors of the steady shifts, and of the displacements at each term, at a wave number, (1
        + terms,).
        """
        swings = [weight * np.expm1(-1j * k * self.step * ago) for ago, weight in self.terms]
        return np.array([1.0, *swings])

    def shifting(self, phases: np.ndarray, way: int = 1) -> Shifts:
        """Shifts in a step (k, 2, N) by fields (k, 2 or 3, N), with phases.

        With a `way` of -1 those of particles that go the other way: the transposed operators of
        elastic bodies.
        """
        symbol = self._symbol(self._table(phases, way))
        compliance = self.disc.edge_compliance

        def shifts(fields: np.ndarray) -> np.ndarray:
            filtered = self._filtered(symbol, fields[:, : symbol.shape[1]])
            if compliance is not None:
                filtered += phases[0] * compliance.reshape(2, -1) * fields[:, :2]
            return filtered

        return shifts

    def _table(self, phases: np.ndarray, way: int = 1) -> np.ndarray:
        """Influence numbers of shifts in a step, by tractions and, where they matter, pressures."""
        operators = self.disc.operators
        rolled = way * (self.disc.step or 0.0)
        stencil = self.disc.transport.stencil
        if way != 1:
            stencil = mirrored(stencil)
        steady = operators.tangential(stencil).table
        if self.disc.K != 0:
            steady = np.concatenate([steady, operators.pressure_to_shift(stencil).table], axis=1)
        carried = [operators.carrying(ago * rolled).table for ago, _ in self.terms]
        return np.tensordot(phases, [steady, *carried], axes=1)

    def _symbol(self, table: np.ndarray) -> np.ndarray:
        from scipy.fft import fft2

        return np.asarray(fft2(wrapped(table.astype(complex), fft_box(*self.disc.grid.shape))))

    def _images(self, phases: np.ndarray, shifts: Shifts, unknowns: np.ndarray) -> np.ndarray:
        """Left-hand sides (unknowns, k) by unknowns."""
        images = self.equations(shifts(self.fields(self.changes(unknowns))))
        stuck = 2 * self.stick.size
        images[stuck:] += phases[0] * self.turning[:, None] * unknowns[stuck:]
        return images

    def _filtered(self, symbol: np.ndarray, fields: np.ndarray) -> np.ndarray:
        """Product (k, rows, N) of a symbol (rows, columns) on a periodic box with complex fields
        (k, columns, N).
        """
        from scipy.fft import fft2, ifft2

        ny, nx = self.disc.grid.shape
        spectrum = fft2(fields.reshape(*fields.shape[:2], ny, nx), symbol.shape[2:])
        product = sum(symbol[:, i] * spectrum[:, None, i] for i in range(fields.shape[1]))
        filtered = ifft2(product, overwrite_x=True)[..., :ny, :nx]
        return np.asarray(filtered).reshape(len(fields), -1, ny * nx)

    def _preconditioner(self, phases: np.ndarray) -> Shifts:
        """Approximate unknowns by left-hand sides: the operator's inverse on a periodic box,
        element by element in slip. Box and weights are those of the Newton solver's `Circulant`.
        """
        from scipy.fft import fft2

        ny, nx = self.disc.grid.shape
        table = self._table(phases)[:, :2]
        own = abs(np.trace(table[:, :, ny - 1, nx - 1])) / 2
        box = fast_box(int(WIDER * ny), int(WIDER * nx))
        rows, columns = box
        y = np.arange(-(ny - 1), ny)
        x = np.arange(-(nx - 1), nx)
        window = parzen(y / rows)[:, None] * parzen(x / columns) * CAUSAL ** (-x / columns)
        symbol = np.moveaxis(fft2(wrapped(table * window, box)), (0, 1), (2, 3))
        inverse = np.moveaxis(np.linalg.inv(symbol + STICK_SHIFT * own * np.eye(2)), (2, 3), (0, 1))
        growth = np.tile(CAUSAL ** (np.arange(nx) / columns), ny)
        stuck = 2 * self.stick.size

        def precondition(right: np.ndarray) -> np.ndarray:
            k = right.shape[1]
            fields = np.zeros((k, 2, ny * nx), complex)
            fields[:, :, self.stick] = right[:stuck].T.reshape(k, 2, -1)
            filtered = self._filtered(inverse, fields / growth) * growth
            of_stick = filtered[:, :, self.stick].reshape(k, -1).T
            of_slip = right[stuck:] / (own + self.turning)[:, None]
            return np.concatenate([of_stick, of_slip])

        return precondition

    def mean(self, k: float) -> complex:
        """Mean of an oscillation over the step, divided by its value at the step's end."""
        if k == 0:
            return 1.0
        return complex(self.phases(k)[1:].sum() / (1j * k * self.step))


def _halving_order(count: int) -> np.ndarray:
    """Numbers from 0 up to `count` in the order of their reversed bits."""
    bits = count.bit_length()
    return np.argsort([int(f"{i:0{bits}b}"[::-1], 2) for i in range(count)])


def check_linear(sol: Solution) -> None:
    """Refuse solutions about which the problem cannot be linearised."""
    scene = sol.scene
    plan = sol.plan
    if scene.motion is None:
        raise SceneError("motion", None, "given: without it there is no creepage")
    approximate = ""
    if plan.theory is not None:
        approximate = plan.tangential
    elif plan.coupling == "johnson":
        approximate = plan.coupling
    if approximate:
        raise SceneError("solution", approximate, "by an exact method: this one is approximate")
    consistency.check_linear(scene)
    _check_swinging(scene)


def _check_swinging(scene: Scene) -> None:
    """Refuse scenes whose response in frequency is not known."""
    if not isinstance(scene.motion, Steady):
        motion = type(scene.motion).__name__
        raise SceneError("motion", motion, "Steady: the response is about steady rolling")
    if scene.bodies.relaxes:
        raise SceneError("bodies", "viscoelastic", "elastic: the response of others is not known")
    if scene.shift_undetermined:
        allowed = "given: in line contact what swings needs it"
        raise SceneError("surface.reference_depth", None, allowed)


def unit_shifts(disc: Discretisation) -> np.ndarray:
    """Rigid shifts by unit creepages, (3, 2, N) (2 of them in line contact), dimensionless."""
    motion = disc.loading.motion
    assert motion is not None
    creepages = ("vx", "vy", "spin")
    shifts = ("ux", "uy", "rotation")
    still: dict[str, Any] = {name: 0.0 for name in creepages + shifts if hasattr(motion, name)}
    still |= {"Fx": None, "Fy": None}
    if hasattr(motion, "rigid_slip"):
        still["rigid_slip"] = None
    names = creepages if motion.rolls else shifts
    units = [replace(motion, **{**still, name: 1.0}) for name in names]
    if disc.grid.line:
        units = units[:2]
    disc = disc.with_loading(beside=None)
    return np.array([disc.with_loading(motion=unit).rigid_shift.reshape(2, -1) for unit in units])


def linearise(sol: Solution) -> Linearised:
    """The problem about a solution of steady rolling, for creepages, load and a height that
    swing.
    """
    check_linear(sol)
    contact = (sol.state != EXTERIOR) & (np.nan_to_num(sol.traction_bound, posinf=1.0) > 0)
    if not contact.any():
        raise SceneError("solution", "no traction", "a contact with friction")
    disc = with_subgrid(discretise(sol.scene, sol.grid), sol.pressure_on_parts)
    scales = disc.scales
    shifts = unit_shifts(disc)
    # directions across the tractions that slip, and how slip turns with them
    slip = np.flatnonzero(contact & (sol.state == SLIP))
    rolled = (disc.step or 1.0 / scales.length) * scales.length
    traction = sol.traction.reshape(2, -1)[:, slip] / scales.pressure
    shift = sol.slip.reshape(2, -1)[:, slip] * rolled
    size = np.hypot(*traction)
    across = np.array([-traction[1], traction[0]]) / size
    turning = np.hypot(*shift) / scales.displacement / size
    growing = np.zeros((2, sol.grid.size))
    growing[:, slip] = traction * scales.pressure / sol.pressure.ravel()[slip]
    # the load and a height, where pressures follow them; how tractions of unlike bodies enter at a
    # moving edge is not known (40 to 90 % off), and parts of elements do not follow one
    inputs = ("vx", "vy", "spin")[: len(shifts)]
    loaded = not disc.interface.unbounded and sol.grid.edge == "centres" and disc.K == 0
    if loaded:
        load = "approach" if disc.loading.normal_force is None else "normal_force"
        inputs += (load, "roughness")
    with_pressure = np.flatnonzero(sol.pressure > 0)
    normal = None
    if disc.K != 0 or loaded:
        normal = _normal_factors(disc, with_pressure, slip, growing)
    entering, reaching, thin = moving_edge(sol, disc, contact)
    return Linearised(
        disc=disc,
        stick=np.flatnonzero(contact & (sol.state == STICK)),
        slip=slip,
        across=across,
        turning=turning,
        inputs=inputs,
        shifts=shifts,
        with_pressure=with_pressure,
        normal=normal,
        growing=growing,
        entering=entering,
        reaching=reaching,
        thin=thin,
    )


def _normal_factors(
    disc: Discretisation, with_pressure: np.ndarray, slip: np.ndarray, growing: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """LU factors of the linearised normal problem: pressures and approach by distances and load."""
    m = with_pressure.size
    need("the linearised normal problem", 16.0 * m**2, "fewer elements fit")
    system = np.zeros((m + 1, m + 1))
    system[:m, :m] = disc.operators.normal.dense(with_pressure)
    system[:m, m] = -1.0
    # the last equation prescribes the load or the approach
    if disc.loading.normal_force is None:
        system[m, m] = 1.0
    else:
        system[m, :m] = 1.0
    # tractions that slip grow with the pressure, and change the distance of unlike bodies
    if disc.K != 0:
        dense = disc.operators.traction_to_distance.dense(with_pressure, slip)
        grown = np.einsum("min,in->mn", dense.reshape(m, 2, -1), growing[:, slip])
        system[:m, np.searchsorted(with_pressure, slip)] += grown
    from scipy.linalg import lu_factor

    factors: tuple[np.ndarray, np.ndarray] = lu_factor(system, overwrite_a=True)
    return factors


def moving_edge(
    sol: Solution, disc: Discretisation, contact: np.ndarray
) -> tuple[np.ndarray, tuple[tuple[np.ndarray, int], ...], np.ndarray]:
    """Tractions (2, N) by pressure that particles carry in at the leading edge; elements (N,) whose
    slip difference reaches over it, with columns; and `thin` elements (N,).

    Where the edge moves, pressure and traction change as 1/sqrt of the distance from it, in the
    ratio that they have there. Particles enter such tractions without slip, which a difference over
    elements does not see: it is taken as many columns further on as it reaches over the edge.
    """
    entering, leading, thin = _entering_tractions(sol, contact)
    stick = contact & (sol.state == STICK)
    columns = _columns(sol, disc)
    reaching = []
    for k in range(columns):
        # k elements behind the edge, and the columns that are left to its far side
        here = np.pad((leading | thin)[:, k:], ((0, 0), (0, k)))
        back = columns - k
        stick_there = np.pad(stick[:, :-back], ((0, 0), (back, 0)))
        reaching.append(((here & stick & stick_there).ravel(), back))
    return entering.reshape(2, -1), tuple(reaching), (thin & ~stick).ravel()


def _columns(sol: Solution, disc: Discretisation) -> int:
    """Columns of elements that the slip difference reaches over."""
    ahead = max(ago for ago, _ in DIFFERENCES[disc.transport.difference])
    rolled = ahead * (disc.step or 0.0) * disc.scales.length
    columns = int(np.ceil(rolled / sol.grid.sides[0] - 1e-9))
    return min(max(columns, 1), sol.grid.nx - 1)


def _entering_tractions(
    sol: Solution, contact: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tractions (2, ny, nx) by pressure at the leading edge; elements there that stick (`leading`),
    or slip before one that sticks (`thin`).

    The squares of both rise linearly from the edge, wherever that is in its element: the ratio is
    that of their slopes. In rows that are too short for a slope nothing is carried in.
    """
    pressure = sol.pressure
    traction = np.hypot(*sol.traction)
    # the elements one and two behind the leading edge of each row
    rows = np.arange(sol.grid.rows)
    edge = sol.grid.nx - 1 - np.argmax(pressure[:, ::-1] > 0, axis=1)
    near = np.maximum(edge - 1, 0)
    far = np.maximum(edge - 2, 0)
    # ratio of traction to pressure by the slopes of their squares
    traction_rise = traction[rows, far] ** 2 - traction[rows, near] ** 2
    pressure_rise = pressure[rows, far] ** 2 - pressure[rows, near] ** 2
    size = np.where(traction[rows, near] > 0, traction[rows, near], 1.0)
    direction = sol.traction[:, rows, near] / size
    rising = (traction_rise > 0) & (pressure_rise > LEAST_RISE * pressure[rows, near] ** 2)
    squared = np.where(rising, traction_rise, 0.0) / np.where(rising, pressure_rise, 1.0)
    entering = (direction * np.sqrt(squared))[:, :, None] * contact
    # elements at the edge that stick, and those that slip before one that sticks
    first = contact & (np.arange(sol.grid.nx) == edge[:, None])
    behind = sol.state[rows, near][:, None]
    stick = sol.state == STICK
    leading = first & stick & (behind != EXTERIOR)
    thin = first & ~stick & (behind == STICK)
    return entering, leading, thin
