"""Response in frequency: rolling contact linearised about a steady solution, for what swings along the track."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.results.linearised import linearise
from varcontact.results.solution import Solution
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
    >>> response = vc.solve(scene).frequency_response([0.5, 1.0])
    >>> print(response.of("Fx", "vx").round(2))
    [-2.57+1.84j -1.19+1.93j]
    """

    wave_number: np.ndarray
    values: np.ndarray
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    scene: Scene

    def of(self, output: str, by: str) -> np.ndarray:
        """Derivative of the `output` with respect to the input `by`, one for each wave number."""
        row = self.outputs.index(checks.choice("output", output, self.outputs))
        return self.values[:, row, self.inputs.index(checks.choice("by", by, self.inputs))]

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
            raise SceneError("inputs", "roughness", "creepages and the load: roughness acts before it enters")
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
    k = problem.wave_numbers("wave_number", wave_number)
    outputs, sums = problem.resultants()
    values = np.empty((k.size, len(outputs), len(problem.inputs)), complex)
    for i, changes in problem.responses(k):
        values[i] = sums @ changes.T
    return FrequencyResponse(k, values, outputs, problem.inputs, sol.scene)


@dataclass(frozen=True, eq=False)
class HarmonicSolution:
    """What swings with ``exp(i k q)`` by the distance rolled q, without slip, under creepages of a `Harmonic`.

    Attributes
    ----------
    scene : Scene
        With its `Harmonic`.
    free_rolling : Solution
        The contact without creepage, about which everything swings.
    traction : ndarray of complex, shape (2, ny, nx)
        Amplitudes of the tangential tractions on body 1 [force/area].
    pressure : ndarray of complex, shape (ny, nx)
        Those of the pressure, which tractions change where the bodies differ [force/area].
    Fx, Fy, Mz : complex
        Amplitudes of the forces, and of the moment about z, on body 1; no moment in line contact.

    Examples
    --------
    >>> import numpy as np
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, friction=np.inf,
    ...     motion=vc.Harmonic(wave_number=0.5, vx=1e-3), grid=vc.Grid(nx=32, ny=32))
    >>> print(f"{vc.solve(scene).Fx:.5f}")  # of the continuum -2.7667e-3 + 2.1160e-3 i
    -0.00280+0.00216j
    """

    scene: Scene
    free_rolling: Solution
    traction: np.ndarray
    pressure: np.ndarray
    Fx: complex
    Fy: complex
    Mz: complex


def harmonic_solution(scene: Scene, free_rolling: Any) -> HarmonicSolution:
    """Amplitudes under a `Harmonic`, about the contact in free rolling."""
    problem, motion = linearise(free_rolling), scene.motion
    k = problem.wave_numbers("motion.wave_number", motion.wave_number)
    ((_, responses),) = problem.responses(k)
    creepages = np.array([motion.vx, motion.vy, motion.spin])[: len(problem.shifts)]
    changes = creepages @ responses[: len(creepages)]
    names, sums = problem.resultants()
    resultants = dict(zip(names, (sums @ changes).tolist(), strict=True))
    fields = changes[:-1].reshape(3, *free_rolling.grid.shape) * problem.disc.scales.pressure
    Fx, Fy, Mz = (resultants.get(name, 0j) for name in ("Fx", "Fy", "Mz"))
    return HarmonicSolution(scene, free_rolling, fields[:2], fields[2], Fx, Fy, Mz)


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
