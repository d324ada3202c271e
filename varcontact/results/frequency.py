"""Response in frequency: rolling contact linearised about a steady solution, for what swings, and
corrugation.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.results.linearised import Linearised, linearise, unit_shifts
from varcontact.results.solution import Solution
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.system.process import one_blas_thread

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure
    from scipy.signal import StateSpace

Receptance = Callable[[float], complex] | tuple[Any, Any] | None

POLE_STEPS = 30
"""Iterations of a rational fit that relocate its poles."""
POLE_REAL_TOL = 1e-9
"""Imaginary part relative to the size of a pole below which it is real."""


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Complex derivatives of forces by creepages, load and roughness that swing
    with ``exp(i k q)``.

    q is the distance rolled, so ``k = omega/V`` by the circular frequency and
    the rolling velocity. The derivatives by the creepages are at a constant
    load, and the other way round.

    Attributes
    ----------
    wave_number : ndarray, shape (n,)
        k [1/length].
    values : ndarray of complex, shape (n, outputs, inputs)
        Derivative of each output by each input, in the units of the scene.
    outputs : tuple of str
        "Fx", "Fy", in three dimensions "Mz"; with the pressure "Fz" and
        "approach".
    inputs : tuple of str
        "vx", "vy", in three dimensions "spin"; of like bodies on a grid whose
        elements count by their centres, and unless friction is infinite,
        "normal_force" (or "approach", where the scene prescribes that), and
        "roughness": a height ``r exp(i k (x + q))`` [length] that closes the
        gap.
    scene : Scene
        Scene of the solution.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.02), grid=vc.Grid(nx=12, ny=12))
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
        """The derivatives as a dataset: a variable for each output, with dimensions wave_number and
        input.
        """
        import xarray as xr

        coordinates = {"wave_number": self.wave_number, "input": list(self.inputs)}
        fields = {
            name: (("wave_number", "input"), self.values[:, i])
            for i, name in enumerate(self.outputs)
        }
        return xr.Dataset(fields, coords=coordinates)

    @checks.named_options()
    def plot(
        self, output: str = "Fx", by: str = "vx", *, figsize: tuple[float, float] | None = None
    ) -> Figure:
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

    @checks.named_options()
    def state_space(
        self,
        order: int = 6,
        *,
        outputs: Sequence[str] = ("Fx",),
        inputs: Sequence[str] = ("vx",),
        speed: float = 1.0,
    ) -> StateSpace:
        """Linear system of low order with about this response, for models of
        vehicles, by a rational fit.

        Parameters
        ----------
        order : int
            Number of poles, which all derivatives share; the system has this
            many states for each input.
        outputs, inputs : sequence of str
            Of the system. Roughness acts before it enters the contact: no such
            system follows it.
        speed : float
            Rolling velocity [length/time]; with 1 time is the distance rolled.

        Returns
        -------
        scipy.signal.StateSpace
            Real and stable.

        Raises
        ------
        SceneError
            For names that there are not, and with fewer wave numbers than the
            order.

        Notes
        -----
        B. Gustavsen and A. Semlyen, Rational approximation of frequency domain responses by vector
        fitting, IEEE Transactions on Power Delivery 14 (1999) 1052-1061.
        """
        from scipy.signal import StateSpace

        order = checks.whole("order", order, 1, self.wave_number.size)
        V = checks.positive("speed", speed)
        if "roughness" in inputs:
            raise SceneError(
                "inputs", "roughness", "creepages and the load: roughness acts before it enters"
            )
        chosen = np.array([self.of(output, name) for output in outputs for name in inputs]).T
        poles, residues, direct = _rational(1j * self.wave_number, chosen, order)
        A, b, c = _real_system(poles, residues)
        # as many copies of the poles' states as there are inputs
        unit = np.eye(len(inputs))
        shape = (len(outputs), len(inputs))
        C = np.moveaxis(c.reshape(order, *shape), 1, 0).reshape(shape[0], -1)
        return StateSpace(
            V * np.kron(A, unit), V * np.kron(b[:, None], unit), C, direct.reshape(shape)
        )


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
    """Harmonic response ``exp(i k q)`` in the distance q rolled, without slip, to the creepages of
    a `Harmonic`.

    Attributes
    ----------
    scene : Scene
        With its `Harmonic`.
    free_rolling : Solution
        The contact without creepage, about which everything swings.
    traction : ndarray of complex, shape (2, ny, nx)
        Amplitudes of the tangential tractions on body 1 [force/area].
    pressure : ndarray of complex, shape (ny, nx)
        Amplitudes of the pressure, which tractions change where the bodies differ
        [force/area].
    Fx, Fy, Mz : complex
        Amplitudes of the forces, and of the moment about z, on body 1; no
        moment in line contact.

    Examples
    --------
    >>> import numpy as np
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=np.inf, motion=vc.Harmonic(wave_number=0.5, vx=1e-3),
    ...     grid=vc.Grid(nx=32, ny=32))
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
    problem = linearise(free_rolling)
    motion = scene.motion
    k = problem.wave_numbers("motion.wave_number", motion.wave_number)
    ((_, responses),) = problem.responses(k)
    creepages = np.array([motion.vx, motion.vy, motion.spin])[: len(problem.shifts)]
    changes = creepages @ responses[: len(creepages)]
    names, sums = problem.resultants()
    resultants = dict(zip(names, (sums @ changes).tolist(), strict=True))
    fields = changes[:-1].reshape(3, *free_rolling.grid.shape) * problem.disc.scales.pressure
    Fx, Fy, Mz = (resultants.get(name, 0j) for name in ("Fx", "Fy", "Mz"))
    return HarmonicSolution(scene, free_rolling, fields[:2], fields[2], Fx, Fy, Mz)


def _rational(
    s: np.ndarray, values: np.ndarray, order: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poles, residues (order, m) and direct parts (m,) of a fit of values (n, m) at s, with its
    conjugate: real. Vector fitting, see `FrequencyResponse.state_space`.
    """
    s = np.concatenate([s, s.conj()])
    values = np.concatenate([values, values.conj()])
    sizes = np.abs(values).max(axis=0)
    values = values / np.where(sizes > 0, sizes, 1.0)
    # first poles: weakly damped, spread over the frequencies
    highest = np.abs(s).max()
    upper = np.linspace(highest / order, highest, order // 2) * (1j - 0.01)
    poles = np.concatenate([_with_conjugates(upper), np.full(order % 2, -highest / 2)])
    for _ in range(POLE_STEPS):
        poles = _moved_poles(s, values, poles)
    terms = np.column_stack([1 / (s[:, None] - poles), np.ones(s.size)])
    fit, *_ = np.linalg.lstsq(terms, values)
    return poles, fit[:-1] * sizes, fit[-1].real * sizes


def _with_conjugates(poles: np.ndarray) -> np.ndarray:
    """Poles, each followed by its conjugate."""
    pairs = np.repeat(poles, 2)
    pairs[1::2] = poles.conj()
    return pairs


def _moved_poles(s: np.ndarray, values: np.ndarray, poles: np.ndarray) -> np.ndarray:
    """Poles of the next step: the zeros of the weight ``1 + sum_k w_k/(s - poles_k)``, stable."""
    terms = 1 / (s[:, None] - poles)
    # least squares of the weights, with the residues and direct parts eliminated
    free, _ = np.linalg.qr(np.column_stack([terms, np.ones(s.size)]))
    columns = [np.column_stack([value[:, None] * terms, value]) for value in values.T]
    stacked = np.concatenate(columns).reshape(values.shape[1], s.size, -1)
    stacked -= free @ (free.conj().T @ stacked)
    system = stacked.reshape(-1, poles.size + 1)
    weights, *_ = np.linalg.lstsq(system[:, :-1], -system[:, -1])
    # zeros are moved to the left half-plane, and come as conjugate pairs and real ones
    zeros = np.linalg.eigvals(np.diag(poles) - weights)
    oscillating = np.abs(zeros.imag) > POLE_REAL_TOL * np.abs(zeros)
    zeros = -np.abs(zeros.real) + 1j * np.where(oscillating, zeros.imag, 0.0)
    return np.concatenate([_with_conjugates(zeros[zeros.imag > 0]), zeros[zeros.imag == 0]])


def _real_system(
    poles: np.ndarray, residues: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Real matrix A (order, order), input b (order,) and outputs c (order, m) with these poles and
    residues.
    """
    order = poles.size
    A = np.zeros((order, order))
    b = np.zeros(order)
    c = np.zeros(residues.shape)
    for i, (pole, residue) in enumerate(zip(poles, residues, strict=True)):
        A[i, i] = pole.real
        c[i] = residue.real
        if pole.imag == 0:
            b[i] = 1.0
        elif pole.imag > 0:  # its conjugate is the next
            A[i, i + 1] = pole.imag
            A[i + 1, i] = -pole.imag
            b[i] = 2.0
        else:
            c[i] = -residue.imag
    return A, b, c


@checks.named_options()
@one_blas_thread()
def corrugation_growth(
    sol: Solution,
    wavelengths: Any,
    *,
    wheel: Receptance = None,
    track: Receptance = None,
    speed: Any = None,
) -> xr.Dataset:
    """Growth of a corrugation ``r exp(i k X)`` of the rail over the wavelength, by
    the linear theory of small waves.

    Wear is taken in proportion to the work of friction (Archard): the height
    changes by -(k/H) times that work.

    Parameters
    ----------
    sol : Solution
        The smooth contact, rolling steadily with slip. What it prescribes
        (creepages or forces) stays constant.
    wavelengths : array_like, shape (n,)
        Wavelengths along the track [length], each of two elements or more.
    wheel, track : callable or (frequencies, receptances), optional
        Complex vertical receptance [length/force] of each by the circular
        frequency [1/time]; of a table it is interpolated. Not given: rigid.
        Without both the load is constant.
    speed : float or array_like, shape (s,), optional
        Rolling velocity [length/time], with receptances; of several the answer
        is a map.

    Returns
    -------
    xarray.Dataset
        By wavelength, and by speed where there are several: `growth`, of the
        wave by the mean depth worn off, relative to its height [1/length];
        `phase_shift`, phase by which it moves towards +X by that depth [1/length];
        `load_swing`, complex, by height [force/length]. `wear` (wavelength, y)
        is the complex work of the wave by its height and by area of the rail,
        `smooth` (y) that without the wave, by rows of elements.

    Raises
    ------
    SceneError
        For wavelengths the elements do not resolve, receptances that are not
        finite or do not cover the frequencies, without slip, of unlike bodies,
        and for solutions that `Solution.frequency_response` refuses.

    Notes
    -----
    J. B. Nielsen, Evolution of rail corrugation predicted with a non-linear wear model, Journal of
    Sound and Vibration 227 (1999) 915-933, to first order. The load swings by ``-c_r r/(c_N + wheel
    + track)``, with the derivatives of the contact's approach by roughness and load.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Cylinders(R=50.0, reference_depth=50.0),
    ...     normal_force=0.01, friction=0.3, motion=vc.Steady(Fx=-0.0015), grid=vc.Grid(nx=60))
    >>> found = vc.corrugation_growth(vc.solve(scene), [2.0, 4.0])
    >>> bool((found.growth < 0).all())  # without dynamics waves wear away
    True
    """
    import xarray as xr

    checks.kind("sol", sol, Solution)
    if sol.grid.edge != "centres":
        allowed = '"centres", on which a moving edge is followed; give a grid'
        raise SceneError("grid.edge", sol.grid.edge, allowed)
    problem = linearise(sol)
    k = problem.wave_numbers("wavelengths", wavelengths, by_length=True)
    _check_corrugation(problem)
    vibrates = wheel is not None or track is not None
    if vibrates and speed is None:
        allowed = "given: receptances depend on the frequency, wave number times speed"
        raise SceneError("speed", None, allowed)
    if speed is not None:
        speed = checks.positives("speed", speed)
    if not vibrates:  # under a constant load nothing depends on it
        speed = None
    receptance = _receptance("wheel", wheel, k, speed) + _receptance("track", track, k, speed)
    wear, loads = _wear_and_load(problem, sol, k, receptance if vibrates else None)
    smooth = sol.power_density.sum(axis=1) * sol.grid.sides[0]
    whole = wear.sum(axis=-1) / smooth.sum()
    dims = ("wavelength", "speed")
    fields: dict[str, Any] = {
        "growth": (dims, -whole.real),
        "phase_shift": (dims, whole.imag),
        "load_swing": (dims, loads),
        "wear": ((*dims, "y"), wear),
        "smooth": ("y", smooth),
    }
    places = {
        "wavelength": np.atleast_1d(np.asarray(wavelengths, float)),
        "y": sol.grid.y,
        "speed": np.atleast_1d(speed),
    }
    dataset = xr.Dataset(fields, places)
    if np.ndim(speed) == 0:
        dataset = dataset.isel(speed=0, drop=True)
    if sol.scene.units is not None:
        dataset.attrs["length"] = sol.scene.units.length
    return dataset


def _check_corrugation(problem: Linearised) -> None:
    """Refuse contacts without slip, and unlike bodies."""
    if problem.disc.K != 0:
        allowed = "like (K = 0): the response of unlike ones to roughness is not known"
        raise SceneError("bodies", f"K = {problem.disc.K:.3g}", allowed)
    if "roughness" not in problem.inputs or problem.slip.size == 0:
        raise SceneError("solution", "no slip", "a contact that slips: without slip nothing wears")


def _wear_and_load(
    problem: Linearised, sol: Solution, k: np.ndarray, receptance: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """Work (wave numbers, speeds, rows) of a wave of unit height per area of the rail, and the
    oscillation of the load (wave numbers, speeds); without receptances the load is constant.
    """
    grid = sol.grid
    scales = problem.disc.scales
    of_row = grid.sides[0] / problem.step * scales.pressure * scales.displacement
    traction = sol.traction.reshape(2, -1) / scales.pressure
    # shift of the particles in a step of the smooth contact
    motion = problem.disc.loading.motion
    assert isinstance(motion, Steady)
    rigid = unit_shifts(problem.disc.with_loading(motion=replace(motion, spin_offset=0.0)))
    steady = np.concatenate([traction, sol.pressure.reshape(1, -1) / scales.pressure])
    creepages = np.nan_to_num(sol.creepage)[: len(rigid)]
    shift = (np.tensordot(creepages, rigid, axes=1) + _mean_shift(problem, 0.0, steady)).real
    names, sums = problem.resultants()
    speeds = 1 if receptance is None else receptance.shape[1]
    wear = np.empty((k.size, speeds, grid.rows), complex)
    loads = np.empty((k.size, speeds), complex)
    for i, changes in problem.responses(k):
        resultants = dict(zip(names, sums @ changes.T, strict=True))
        for j in range(speeds):
            # amplitudes of creepages, load and height
            compliance = None if receptance is None else receptance[i, j]
            amplitudes = _amplitudes(sol, resultants, compliance)
            swing = (amplitudes @ changes)[:-1].reshape(3, -1)
            loads[i, j] = resultants["Fz"] @ amplitudes
            # work of oscillating tractions on steady slip, and of steady ones on oscillating slip
            swinging = amplitudes[: len(rigid)] * problem.mean(k[i]).real
            slip = np.tensordot(swinging, rigid, axes=1) + _mean_shift(problem, k[i], swing)
            work = (swing[:2] * shift + traction * slip).sum(axis=0).reshape(grid.shape)
            wear[i, j] = -of_row * (work @ np.exp(-1j * k[i] * grid.x))
    return wear, loads


def _amplitudes(
    sol: Solution, resultants: dict[str, np.ndarray], compliance: complex | None
) -> np.ndarray:
    """Amplitudes of the inputs, for a unit height: prescribed forces stay constant, and the load
    swings where wheel and track have a `compliance`.
    """
    amplitudes = np.zeros(resultants["Fz"].size, complex)
    amplitudes[-1] = 1.0
    equations = {}
    for number, force in enumerate(("Fx", "Fy")):
        if getattr(sol.motion, force) is not None:
            equations[number] = resultants[force]
    if compliance is not None:
        load = amplitudes.size - 2
        equations[load] = resultants["approach"] + compliance * resultants["Fz"]
    if equations:
        free = list(equations)
        matrix = np.array(list(equations.values()))
        amplitudes[free] = np.linalg.solve(matrix[:, free], -matrix[:, -1])
    return amplitudes


def _mean_shift(problem: Linearised, k: float, fields: np.ndarray) -> np.ndarray:
    """Elastic shift (2, N), mean of the step that ends and that which begins: with it work sums to
    that supplied.
    """
    phases = problem.phases(k)
    swing = fields[None].astype(complex)
    ending = problem.shifting(phases)(swing)[0]
    beginning = problem.shifting(phases.conj(), way=-1)(swing)[0]
    return (ending - beginning) / 2


def _receptance(name: str, given: Receptance, wave_numbers: np.ndarray, speed: Any) -> np.ndarray:
    """Receptance (wave numbers, speeds), zero where none is given."""
    if given is None:
        return np.zeros((wave_numbers.size, np.size(speed)), complex)
    frequencies = wave_numbers[:, None] * np.atleast_1d(speed)
    try:  # the user's own code runs here
        if callable(given):
            called = [complex(given(float(frequency))) for frequency in frequencies.flat]
            values = np.array(called).reshape(frequencies.shape)
        else:
            table = checks.numbers(f"{name}[0]", given[0])
            numbers = np.asarray(given[1], complex)
            if table.ndim != 1 or table.shape != numbers.shape or np.any(np.diff(table) <= 0):
                raise ValueError("frequencies increase, and there are as many receptances")
            values = np.interp(frequencies, table, numbers, left=np.nan, right=np.nan)
    except Exception as error:  # a receptance of the user may raise anything
        allowed = f"a function, or frequencies and receptances ({type(error).__name__}: {error})"
        raise SceneError(name, given, allowed) from error
    for frequency, value in zip(frequencies.flat, values.flat, strict=True):
        if not np.isfinite(value):
            at = f"at the circular frequency {frequency:.6g}"
            allowed = f"a finite receptance {at}, which a table has to cover"
            raise SceneError(name, value, allowed)
    return np.asarray(values)
