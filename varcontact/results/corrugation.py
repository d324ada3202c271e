"""Growth of corrugation: wear that a wave of the rail's height causes, to first order, from one solve a wavelength."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.results.linearised import Linearised, linearise, unit_shifts
from varcontact.results.solution import Solution
from varcontact.scene.motion import Steady
from varcontact.system.process import one_blas_thread

if TYPE_CHECKING:
    import xarray as xr

Receptance = Callable[[float], complex] | tuple[Any, Any] | None


@one_blas_thread()
def corrugation_growth(
    sol: Solution,
    wavelengths: Any,
    *,
    wheel: Receptance = None,
    track: Receptance = None,
    speed: Any = None,
) -> xr.Dataset:
    """Growth of a corrugation ``r exp(i k X)`` of the rail by wavelength, by the linear theory of small waves.

    Wear is taken in proportion to the work of friction (Archard): the height changes by -(k/H) times that work.

    Parameters
    ----------
    sol : Solution
        The smooth contact, rolling steadily with slip. What it prescribes (creepages or forces) stays constant.
    wavelengths : array_like, shape (n,)
        Wavelengths along the track [length], each of two elements or more.
    wheel, track : callable or (frequencies, receptances), optional
        Complex vertical receptance [length/force] of each by the circular frequency [1/time]; of a table it is
        interpolated. Not given: rigid. Without both the load is constant.
    speed : float or array_like, shape (s,), optional
        Rolling velocity [length/time], with receptances; of several the answer is a map.

    Returns
    -------
    xarray.Dataset
        By wavelength, and by speed where there are several: `growth`, of the wave by the mean depth worn off, relative
        to its height [1/length]; `shift`, phase by which it moves towards +X by that depth [1/length]; `load_swing`,
        complex, by height [force/length].
        `wear` (wavelength, y) is the complex work of the wave by its height and by area of the rail, `smooth` (y) that
        without the wave, by rows of elements.

    Raises
    ------
    SceneError
        For wavelengths the elements do not resolve, receptances that are not finite or do not cover the frequencies,
        without slip, and for solutions that `Solution.frequency_response` refuses.

    Notes
    -----
    J. B. Nielsen, Evolution of rail corrugation predicted with a non-linear wear model, Journal of Sound and Vibration
    227 (1999) 915-933, to first order. The load swings by ``-c_r r/(c_N + wheel + track)``, with the derivatives of the
    contact's approach by roughness and load.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Cylinders(R=50.0, reference_depth=50.0), normal_force=0.01,
    ...     friction=0.3, motion=vc.Steady(Fx=-0.0015), grid=vc.Grid(nx=60))
    >>> found = vc.corrugation_growth(vc.solve(scene), [2.0, 4.0])
    >>> bool((found.growth < 0).all())  # without dynamics waves wear away
    True
    """
    import xarray as xr

    checks.kind("sol", sol, Solution)
    if sol.grid.edge != "centres":
        raise SceneError("grid.edge", sol.grid.edge, '"centres", on which a moving edge is followed; give a grid')
    problem = linearise(sol)
    k, moves = problem.wave_numbers("wavelengths", wavelengths, by_length=True), wheel is not None or track is not None
    if "roughness" not in problem.inputs or problem.slip.size == 0:
        raise SceneError("solution", "no slip", "a contact that slips: without slip nothing wears")
    if problem.disc.K != 0 and problem.with_pressure.size != problem.stick.size + problem.slip.size:
        raise SceneError("friction", 0.0, "above zero all over the contact of unlike bodies")
    if moves and speed is None:
        raise SceneError("speed", None, "given: receptances depend on the frequency, wave number times speed")
    speed = checks.positives("speed", speed) if speed is not None else None
    speed = speed if moves else None  # under a constant load nothing depends on it
    receptance = _receptance("wheel", wheel, k, speed) + _receptance("track", track, k, speed)
    grid, scales, step = sol.grid, problem.disc.scales, problem.step
    of_row = grid.sides[0] / step * scales.pressure * scales.displacement
    traction = sol.traction.reshape(2, -1) / scales.pressure
    smooth = sol.power_density.sum(axis=1) * grid.sides[0]
    motion = problem.disc.loading.motion
    assert isinstance(motion, Steady)
    rigid = unit_shifts(problem.disc.with_loading(motion=replace(motion, spin_offset=0.0)))
    steady = np.concatenate([traction, sol.pressure.reshape(1, -1) / scales.pressure])
    given = np.nan_to_num(sol.creepage)[: len(rigid)]
    shift = (np.tensordot(given, rigid, axes=1) + _mean_shift(problem, 0.0, steady)).real
    names, sums = problem.resultants()
    load = len(problem.inputs) - 2
    wear = np.empty((*receptance.shape, grid.rows), complex)
    loads = np.empty(receptance.shape, complex)
    for i, changes in problem.responses(k):
        resultants = dict(zip(names, sums @ changes.T, strict=True))
        constant = {i: resultants[name] for i, name in enumerate(("Fx", "Fy")) if getattr(sol.motion, name) is not None}
        for j, compliance in enumerate(receptance[i]):
            closed = {load: resultants["approach"] + compliance * resultants["Fz"]} if moves else {}
            equations = constant | closed
            amplitudes, free = np.zeros(len(problem.inputs), complex), list(equations)
            amplitudes[-1] = 1.0
            if free:
                matrix = np.array(list(equations.values()))
                amplitudes[free] = np.linalg.solve(matrix[:, free], -matrix[:, -1])
            swing = (amplitudes @ changes)[:-1].reshape(3, -1)
            creepages = amplitudes[: len(rigid)] * problem.mean(k[i]).real
            slip = np.tensordot(creepages, rigid, axes=1) + _mean_shift(problem, k[i], swing)
            work = (swing[:2] * shift + traction * slip).sum(axis=0).reshape(grid.shape)
            wear[i, j] = -of_row * (work @ np.exp(-1j * k[i] * grid.x))
            loads[i, j] = resultants["Fz"] @ amplitudes
    whole, dims = wear.sum(axis=-1) / smooth.sum(), ("wavelength", "speed")
    fields: dict[str, Any] = {"growth": (dims, -whole.real), "shift": (dims, whole.imag), "load_swing": (dims, loads)}
    fields |= {"wear": ((*dims, "y"), wear), "smooth": ("y", smooth)}
    dataset = xr.Dataset(
        fields,
        {"wavelength": np.atleast_1d(np.asarray(wavelengths, float)), "y": grid.y, "speed": np.atleast_1d(speed)},
    )
    if np.ndim(speed) == 0:
        dataset = dataset.isel(speed=0, drop=True)
    if sol.scene.units is not None:
        dataset.attrs["length"] = sol.scene.units.length
    return dataset


def _mean_shift(problem: Linearised, k: float, fields: np.ndarray) -> np.ndarray:
    """Elastic shift (2, N), mean of the step that ends and that which begins: with it work sums to that put in."""
    phases, given = problem.phases(k), fields[None].astype(complex)
    return (problem.shifting(phases)(given)[0] - problem.shifting(phases.conj(), way=-1)(given)[0]) / 2


def _receptance(name: str, given: Receptance, wave_numbers: np.ndarray, speed: Any) -> np.ndarray:
    """Receptance (wave numbers, speeds), zero where none is given."""
    if given is None:
        return np.zeros((wave_numbers.size, np.size(speed)), complex)
    frequencies = wave_numbers[:, None] * np.atleast_1d(speed)
    try:  # the user's own code runs here
        if callable(given):
            values = np.array([complex(given(float(each))) for each in frequencies.flat]).reshape(frequencies.shape)
        else:
            table, numbers = checks.numbers(f"{name}[0]", given[0]), np.asarray(given[1], complex)
            if table.ndim != 1 or table.shape != numbers.shape or np.any(np.diff(table) <= 0):
                raise ValueError("frequencies increase, and there are as many receptances")
            values = np.interp(frequencies, table, numbers, left=np.nan, right=np.nan)
    except Exception as error:  # a receptance of the user may raise anything
        allowed = f"a function, or frequencies and receptances ({type(error).__name__}: {error})"
        raise SceneError(name, given, allowed) from error
    for frequency, value in zip(frequencies.flat, values.flat, strict=True):
        if not np.isfinite(value):
            allowed = f"a finite receptance at the circular frequency {frequency:.6g}, which a table has to cover"
            raise SceneError(name, value, allowed)
    return np.asarray(values)
