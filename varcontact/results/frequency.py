"""Response in frequency: rolling contact linearised about a steady solution, for what swings along the track."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import hessenberg, lu_factor, lu_solve, solve_triangular
from scipy.sparse import csr_array

from varcontact import checks
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.state import with_subgrid
from varcontact.discrete.stick_slip import STICK
from varcontact.elasticity.operators import DIFFERENCES
from varcontact.errors import SceneError
from varcontact.results.sensitivity import Directions, check_linear, directions, unit_shifts, with_friction
from varcontact.results.solution import Solution
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.system.process import one_blas_thread

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
    from scipy.signal import StateSpace


POLE_STEPS = 30
"""Steps in which a rational fit moves its poles."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Complex derivatives of forces by creepages, load and roughness that swing with ``exp(i k q)``.

    q is the distance rolled, so ``k = omega/V`` by the circular frequency and the rolling velocity. The derivatives by
    the creepages are at a constant load, and the other way round.

    Attributes
    ----------
    wave_number : ndarray, shape (n,)
        k [1/length].
    values : ndarray of complex, shape (n, outputs, inputs)
        Derivative of each output by each input, in the units of the scene.
    outputs : tuple of str
        "Fx", "Fy", in three dimensions "Mz"; with the pressure "Fz" and "approach".
    inputs : tuple of str
        "vx", "vy", in three dimensions "spin"; on a grid whose elements count by their centres, and unless friction is
        infinite, "normal_force" (or "approach", where the scene prescribes that), and "roughness": a height
        ``r exp(i k (x + q))`` [length] that closes the gap.
    scene : Scene
        That of the solution.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, friction=0.3,
    ...     motion=vc.Steady(vx=0.02), grid=vc.Grid(nx=12, ny=12))
    >>> response = vc.solve(scene).frequency_response([0.0, 1.0])
    >>> print(response.of("Fx", "vx").round(2))
    [-3.76+0.j   -1.19+1.93j]
    """

    wave_number: np.ndarray
    values: np.ndarray
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    scene: Scene

    def of(self, output: str, by: str) -> np.ndarray:
        """Derivative of the `output` with respect to the input `by`, one for each wave number."""
        place = [self.outputs.index(checks.choice("output", output, self.outputs))]
        return np.asarray(self.values[:, place[0], self.inputs.index(checks.choice("by", by, self.inputs))])

    def to_xarray(self) -> xr.Dataset:
        """The derivatives as a dataset: a variable for each output, with dimensions wave_number and input."""
        import xarray as xr

        coordinates = {"wave_number": self.wave_number, "input": list(self.inputs)}
        fields = {name: (("wave_number", "input"), self.values[:, i]) for i, name in enumerate(self.outputs)}
        return xr.Dataset(fields, coords=coordinates)

    def plot(self, output: str = "Fx", by: str = "vx", *, figsize: tuple[float, float] | None = None) -> Figure:
        """Bode's diagram, size and phase over the wave number, and Nyquist's, of one derivative.

        Parameters
        ----------
        output, by : str
            Which one, as for `of`.
        figsize : pair of float, optional
            Of the figure [inch].
        """
        from varcontact.plotting.frequency import plot_response

        return plot_response(self, output, by, figsize)

    def state_space(
        self,
        order: int = 6,
        *,
        outputs: Sequence[str] = ("Fx",),
        inputs: Sequence[str] = ("vx",),
        speed: float = 1.0,
    ) -> StateSpace:
        """Linear system of low order with about this response, for models of vehicles, by a rational fit.

        Parameters
        ----------
        order : int
            Number of poles, which all derivatives share; the system has this many states for each input.
        outputs, inputs : sequence of str
            Of the system. Roughness acts before it enters the contact: no such system follows it.
        speed : float
            Rolling velocity [length/time]; with 1 time is the distance rolled.

        Returns
        -------
        scipy.signal.StateSpace
            Real and stable.

        Raises
        ------
        SceneError
            For names that there are not, and with fewer wave numbers than the order.

        Notes
        -----
        B. Gustavsen and A. Semlyen, Rational approximation of frequency domain responses by vector fitting, IEEE
        Transactions on Power Delivery 14 (1999) 1052-1061.
        """
        from scipy.signal import StateSpace

        order, V = checks.whole("order", order, 1, self.wave_number.size), checks.positive("speed", speed)
        if "roughness" in inputs:
            raise SceneError(
                "inputs", "roughness", "creepages and the load: roughness acts before it enters the contact"
            )
        chosen = np.array([self.of(output, name) for output in outputs for name in inputs]).T
        poles, residues, direct = _rational(1j * self.wave_number, chosen, order)
        A, b, c = np.zeros((order, order)), np.zeros(order), np.zeros((order, chosen.shape[1]))
        for i, (pole, residue) in enumerate(zip(poles, residues, strict=True)):
            A[i, i], b[i], c[i] = pole.real, float(pole.imag == 0), residue.real
            if pole.imag > 0:  # its conjugate is the next
                A[i, i + 1], A[i + 1, i], b[i] = pole.imag, -pole.imag, 2.0
            elif pole.imag < 0:
                c[i] = -residue.imag
        one, shape = np.eye(len(inputs)), (len(outputs), len(inputs))
        C = np.moveaxis(c.reshape(order, *shape), 1, 0).reshape(shape[0], -1)
        return StateSpace(V * np.kron(A, one), V * np.kron(b[:, None], one), C, direct.reshape(shape))


@one_blas_thread()
def frequency_response(sol: Solution, wave_number: Any) -> FrequencyResponse:
    """Derivatives of the forces by what swings, see `Solution.frequency_response`."""
    problem = linearise(sol)
    k = problem.check(wave_number)
    outputs, sums = problem.resultants()
    values = np.array([sums @ changes for changes, _ in problem.responses(k)])
    return FrequencyResponse(k, values, outputs, problem.inputs, sol.scene)


@dataclass(frozen=True, eq=False)
class Linearised:
    """The problem about a steady solution: n elements that bear tractions, m with pressure; dimensionless.

    k steps ago everything was ``exp(-i k Omega)`` of now: shifts are ``here + sum z_k before_k`` times the changes
    (tractions, pressures, approach: 2 n + m + 1), ``z_k = weight_k (exp(-i k Omega) - 1)`` by the difference over the
    steps. The changes are ``by_unknowns`` times those of `Directions`, and ``by_normal`` times what distances and the
    load change by themselves.
    """

    disc: Discretisation
    bearing: np.ndarray
    pressed: np.ndarray
    may: Directions
    inputs: tuple[str, ...]
    shifts: np.ndarray  # (2 n, creepages)
    here: np.ndarray  # (2 n, 2 n + m + 1)
    before: np.ndarray  # (terms, 2 n, 2 n + m + 1)
    by_unknowns: np.ndarray  # (2 n + m + 1, unknowns)
    by_normal: np.ndarray  # (2 n + m + 1, m + 1)
    entering: np.ndarray  # (2 n, m + 1): tractions that go with the pressure where particles enter
    leading: np.ndarray  # bool (unknowns,): equations of elements there

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

    def resultants(self) -> tuple[tuple[str, ...], np.ndarray]:
        """Names of the resultants, and what they are of the changes, physical: (outputs, 2 n + m + 1)."""
        disc, n = self.disc, self.bearing.size
        iy, ix = np.divmod(self.bearing, disc.grid.nx)
        force, sums = disc.lattice.area * disc.scales.force, np.zeros((5, self.by_normal.shape[0]))
        sums[0, :n] = sums[1, n : 2 * n] = sums[3, 2 * n : -1] = force
        sums[2, :n], sums[2, n : 2 * n] = -disc.grid.y[iy] * force, disc.grid.x[ix] * force
        sums[4, -1] = disc.scales.displacement
        there = [0, 1, 3, 4] if disc.grid.line else [0, 1, 2, 3, 4]
        return tuple(("Fx", "Fy", "Mz", "Fz", "approach")[i] for i in there), sums[there]

    def check(self, wave_number: Any) -> np.ndarray:
        """Wave numbers of which the elements and the step resolve each, as an array (n,)."""
        k = np.atleast_1d(checks.numbers("wave_number", wave_number))
        largest = 2 * np.pi / self.shortest
        allowed = f"from 0 to {largest:.6g}, a wave of two elements"
        if k.ndim != 1 or k.size == 0:
            raise SceneError("wave_number", wave_number, "one number or a one-dimensional array")
        for each in k[(k < 0) | (k > largest * (1 + 1e-12))]:
            raise SceneError("wave_number", float(each), allowed)
        return k

    def responses(self, wave_numbers: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """For each wave number the changes by unit inputs (2 n + m + 1, inputs), and z (terms,)."""
        rows, size = csr_array(self.may.rows), len(self.may.rows)
        at_rest = rows @ (self.here @ self.by_unknowns)
        np.einsum("ii->i", at_rest)[size - self.may.slip.size :] += self.may.turning
        before = np.array([rows @ (each @ self.by_unknowns) for each in self.before])
        one = len(before) == 1
        if one:  # one reduction serves all wave numbers
            factor = lu_factor(at_rest)
            reduced, basis = hessenberg(lu_solve(factor, before[0]), calc_q=True)
        for k in wave_numbers:
            z = np.array([weight * np.expm1(-1j * k * self.step * ago) for ago, weight in self.terms])
            rigid, normal = self._loads(k, z)
            given = self.by_normal @ normal
            entering = np.zeros_like(given)
            entering[: len(self.entering)] = self.entering @ normal
            right = rows @ (rigid + self.shift(z, given))
            right[self.leading] -= (rows @ self.shift(z, entering))[self.leading]
            if one:
                begun = _times(basis.T, lu_solve(factor, -right))
                unknowns = _times(basis, _hessenberg_solve(reduced, complex(z[0]), begun))
            else:
                unknowns = np.linalg.solve(at_rest + np.tensordot(z, before, axes=1), -right)
            yield given + _times(self.by_unknowns, unknowns), z

    def shift(self, z: np.ndarray, changes: np.ndarray) -> np.ndarray:
        """Shifts in a step (2 n, inputs) by changes."""
        past = [weight * _times(each, changes) for weight, each in zip(z, self.before, strict=True)]
        return _times(self.here, changes) + np.sum(past, axis=0)

    def _loads(self, k: float, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rigid shifts (2 n, inputs), and changes of distances and of the load (m + 1, inputs), by unit inputs."""
        scales, creepages = self.disc.scales, self.shifts.shape[1]
        rigid = np.zeros((len(self.shifts), len(self.inputs)), complex)
        rigid[:, :creepages] = self.shifts * (z.sum() / (1j * k * self.step) if k else 1.0)  # its mean over the step
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
    if scene.third_body is not None:
        raise SceneError(
            "third_body", scene.third_body, "left out: what particles bring along is known of bodies alone"
        )
    if scene.shift_undetermined:
        raise SceneError("surface.reference_depth", None, "given: in line contact what swings depends on it")
    bearing, pressed = with_friction(sol), np.flatnonzero(sol.pressure.ravel() > 0)
    if bearing.size == 0:
        raise SceneError("solution", "no traction", "a contact with friction")
    disc = with_subgrid(discretise(scene, sol.grid, coupled=not sol.plan.left_out), sol.pressure_on_parts)
    may, shifts = directions(disc, sol, bearing), unit_shifts(disc)
    n, m, bears = bearing.size, pressed.size, np.searchsorted(pressed, bearing)
    assert disc.step is not None
    ago = [each for each, _ in DIFFERENCES[disc.loading.slip_difference] if each]
    here, before = np.zeros((2 * n, 2 * n + m + 1)), np.zeros((len(ago), 2 * n, 2 * n + m + 1))
    here[:, : 2 * n] = disc.tangential_on(bearing).matrix
    carried = [disc.operators.carrying(each * disc.step).dense(bearing, pressed).reshape(2 * n, -1, m) for each in ago]
    before[:, :, : 2 * n] = [each[:, :2, bears].reshape(2 * n, -1) for each in carried]
    normal = np.zeros((m + 1, m + 1))
    normal[:m, :m], normal[:m, m] = disc.operators.normal.dense(pressed), -1.0
    normal[m, slice(0, m) if disc.loading.normal_force is not None else m] = 1.0
    by_pressure = np.zeros((2 * n, m + 1))
    by_pressure[may.slip, bears[may.slip]], by_pressure[n + may.slip, bears[may.slip]] = may.by_pressure
    to_distance = np.zeros((m + 1, 2 * n))
    if disc.K != 0:
        here[:, 2 * n : -1] = disc.pressure_to_shift.dense(bearing, pressed)
        before[:, :, 2 * n : -1] = [each[:, 2] for each in carried]
        to_distance[:m] = disc.operators.traction_to_distance.dense(pressed, bearing)
    inverse = np.linalg.inv(normal + to_distance @ by_pressure)
    by_normal = np.concatenate([by_pressure @ inverse, inverse])
    by_unknowns = np.pad(may.columns, ((0, m + 1), (0, 0))) - by_normal @ (to_distance @ may.columns)
    entering, leading, thin = _entering(sol, bearing, bears, inverse)
    by_normal[: 2 * n][thin] = entering[thin]
    inputs = ("vx", "vy", "spin")[: len(shifts)]
    if not disc.loading.no_slip and sol.grid.edge == "centres":  # parts of elements do not follow a moving edge
        inputs += ("normal_force" if disc.loading.normal_force is not None else "approach", "roughness")
    return Linearised(
        disc,
        bearing,
        pressed,
        may,
        inputs,
        shifts[:, :, bearing].reshape(len(shifts), -1).T,
        here,
        before,
        by_unknowns,
        by_normal,
        entering,
        leading,
    )


def _entering(
    sol: Solution, bearing: np.ndarray, bears: np.ndarray, inverse: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By changes of distance and load: tractions that keep their share of the pressure; equations at the leading edge.

    Also tractions (2 n,) of elements there that slip since the contact covers so little of them.

    Where the edge moves, pressure and traction change as 1/sqrt of the distance from it, in the ratio that they have
    there. Particles enter such tractions without slip, which a difference over an element does not see. The squares of
    both rise linearly from the edge, wherever that is in its element: the ratio is that of their slopes.
    """
    iy, ix = np.divmod(bearing, sol.grid.nx)
    edge = sol.grid.nx - 1 - np.argmax(sol.pressure[:, ::-1] > 0, axis=1)[iy]  # of each row
    near, far = np.maximum(edge - 1, 0), np.maximum(edge - 2, 0)
    size, pressure = np.hypot(*sol.traction), sol.pressure
    rise, of = size[iy, far] ** 2 - size[iy, near] ** 2, pressure[iy, far] ** 2 - pressure[iy, near] ** 2
    direction = sol.traction[:, iy, near] / np.where(size[iy, near] > 0, size[iy, near], 1.0)
    ratio = direction * np.sqrt(np.where((rise > 0) & (of > 0), rise, 0.0) / np.where(of > 0, of, 1.0))
    first, stick = ix == edge, sol.state.ravel()[bearing] == STICK
    entering = np.concatenate([each[:, None] * inverse[bears] for each in ratio])
    leading = np.concatenate([first[stick], first[stick], np.zeros(np.sum(~stick), bool)])
    thin = first & ~stick & (sol.state[iy, near] == STICK)
    return entering, leading, np.tile(thin, 2)


def _times(matrix: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Product of a real matrix with complex columns."""
    return np.asarray((matrix @ np.ascontiguousarray(values).view(float)).view(complex))


def _hessenberg_solve(reduced: np.ndarray, z: complex, right: np.ndarray) -> np.ndarray:
    """Solve ``(1 + z H) y = right`` for an upper Hessenberg matrix H, by elimination with row interchanges."""
    size = len(reduced)
    system = np.empty((size, size + right.shape[1]), complex)
    np.multiply(reduced, z, out=system[:, :size])
    np.einsum("ii->i", system[:, :size])[:] += 1
    system[:, size:] = right
    for i in range(size - 1):
        if abs(system[i + 1, i]) > abs(system[i, i]):
            system[[i, i + 1], i:] = system[[i + 1, i], i:]
        system[i + 1, i:] -= system[i + 1, i] / system[i, i] * system[i, i:]
    return np.asarray(solve_triangular(system[:, :size].T, system[:, size:], trans="T", lower=True, check_finite=False))


def _rational(s: np.ndarray, values: np.ndarray, order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poles, residues (order, m) and direct parts (m,) of a fit of values (n, m) at s, with its conjugate: real."""
    s, values = np.concatenate([s, s.conj()]), np.concatenate([values, values.conj()])
    sizes = np.abs(values).max(axis=0)
    values = values / np.where(sizes > 0, sizes, 1.0)
    highest = np.abs(s).max()
    pairs = np.linspace(highest / order, highest, order // 2) * (1j - 0.01)
    poles = np.concatenate([np.repeat(pairs, 2), np.full(order % 2, -highest / 2)])
    poles[1 : 2 * pairs.size : 2] = pairs.conj()
    for _ in range(POLE_STEPS):
        terms = 1 / (s[:, None] - poles)
        free, _ = np.linalg.qr(np.column_stack([terms, np.ones(s.size)]))
        both = np.concatenate([np.column_stack([value[:, None] * terms, value]) for value in values.T])
        both = both.reshape(values.shape[1], s.size, -1)
        both -= free @ (free.conj().T @ both)
        both = both.reshape(-1, order + 1)
        weights, *_ = np.linalg.lstsq(both[:, :-1], -both[:, -1])
        found = np.linalg.eigvals(np.diag(poles) - weights)
        found = -np.abs(found.real) + 1j * np.where(np.abs(found.imag) > 1e-9 * np.abs(found), found.imag, 0.0)
        upper = found[found.imag > 0]
        paired = np.repeat(upper, 2)
        paired[1::2] = upper.conj()
        poles = np.concatenate([paired, found[found.imag == 0]])
    terms = np.column_stack([1 / (s[:, None] - poles), np.ones(s.size)])
    fit, *_ = np.linalg.lstsq(terms, values)
    return poles, fit[:-1] * sizes, fit[-1].real * sizes
