"""One scene for many creepages: scans by one method, creep-force curves by several (paper, Figs. 9
and 22 to 24).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.results.solution import Solution
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solving import adaptive
from varcontact.solving.batched_to_accuracy import solve_batches
from varcontact.solving.methods import CouplingName, FormulationName, MethodName, Methods
from varcontact.solving.options import (
    TOLERANCE,
    CertifyName,
    SolveOptions,
)
from varcontact.solving.own_solvers import SolverChoice
from varcontact.solving.warm_start import Series, solve_in_turn
from varcontact.study.derivatives import columns_of, derivatives_of, inputs_of
from varcontact.study.methods import Method
from varcontact.study.parallel import CHUNK, opened, results
from varcontact.system.progress import Progress
from varcontact.theories.creep_forces import VECTORISED, creep_forces
from varcontact.theories.on_grid import why_not

if TYPE_CHECKING:
    import xarray as xr

ROLLING = ("vx", "vy", "spin")
"""Names of the creepages."""
SHIFTING = ("ux", "uy", "rotation")
"""Names of the shifts that take their place."""


@checks.named_options()
def scan(
    scene: Scene,
    creepages: np.ndarray,
    normal: SolverChoice = "auto",
    tangential: SolverChoice = "auto",
    coupling: CouplingName = "auto",
    *,
    formulation: FormulationName = "auto",
    method: MethodName = "auto",
    methods: Methods | None = None,
    tol: float = TOLERANCE,
    polish: bool | None = None,
    certify: CertifyName | None = "gap",
    executor: Executor | None = None,
    workers: int = 1,
    progress: Progress = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
) -> list[Solution]:
    """Solve a scene for many creepages; influence numbers, pressure and
    preparations of solvers are computed once.

    Each solution is the initial guess of the next, with methods that accept
    one.

    Parameters
    ----------
    scene : Scene
        With a motion, whose creepages are replaced; no prescribed tangential
        force.
    creepages : array_like, shape (k, 3)
        vx, vy, spin; of a shift ux, uy, rotation.
    normal, tangential, coupling, formulation, method, methods, tol, polish, certify
        As for `solve`; bounds on the forces only with `certify` = "full".
    executor, workers
        Where they are solved, as for `sweep`, in chunks of eight; only within a
        chunk is a solution the initial guess of another.
    progress : callable or true, optional
        Called with the name of each stage, or, for other processes, with the
        number of creepages done.
    accuracy, time_budget : float, optional
        As in `solve`, for each solution; 1 % for a scene without a grid. Each
        then has a grid of its own, and nothing is shared between them.

    Returns
    -------
    list of Solution

    Raises
    ------
    SceneError, SolverUnavailable, Saturated, NotConverged, TooLarge
        As in `solve`; the first failure ends the scan.
    WorkersLost
        If the executor ends early.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> curve = vc.scan(scene, [(vx, 0.0, 0.0) for vx in (0.5e-3, 1e-3, 4e-3)])
    >>> print([f"{sol.force[0] / (0.33 * sol.normal_force):.3f}" for sol in curve])
    ['-0.210', '-0.392', '-0.967']
    """
    named = Methods.given(
        methods,
        normal=normal,
        tangential=tangential,
        coupling=coupling,
        formulation=formulation,
        method=method,
    )
    options: dict[str, Any] = {
        "methods": named,
        "tol": tol,
        "polish": polish,
        "certify": certify,
        "accuracy": accuracy,
        "time_budget": time_budget,
    }
    report = checks.progress(progress)
    solutions = scanned(scene, creepages, progress, **options)
    with opened(executor, workers) as pool:
        if pool is None:
            return list(solutions)
        triples = checks.numbers("creepages", creepages)
        tasks = {k: (scene, triples[k : k + CHUNK]) for k in range(0, len(triples), CHUNK)}
        solved: dict[int, list[Solution]] = {}
        for first, part in results(partial(scan, **options), tasks, pool):
            solved[first] = part
            report(f"{sum(map(len, solved.values()))} of {len(triples)} creepages")
    return [solution for first in tasks for solution in solved[first]]


def scanned(
    scene: Scene,
    creepages: np.ndarray,
    progress: Progress = None,
    **options: Any,
) -> Iterator[Solution]:
    """The solutions of a `scan`, with its options, one after the other. Arguments are checked
    before the first.
    """
    motions = _motions(scene, creepages)
    scenes = [replace(scene, motion=each) for each in motions]
    checked = SolveOptions.checked(scenes[0], progress=progress, **{"certify": "gap", **options})
    for each in scenes[1:]:  # refuses options that do not apply to one of them
        checked.plan_for(each)
    if checked.target is not None:
        return (cast(Solution, adaptive.solve(each, checked)) for each in scenes)
    series = Series(checked.tol, checked.polish, checked.certify, checks.progress(progress))
    return solve_in_turn(scene, motions, checked.plan, series)


def _motions(scene: Scene, creepages: np.ndarray) -> list[Steady | Shift]:
    checks.kind("scene", scene, Scene)
    motion = scene.motion
    if not isinstance(motion, Steady | Shift) or motion.Fx is not None or motion.Fy is not None:
        allowed = "Steady or Shift with no prescribed force: a scan sets the creepages"
        raise SceneError("motion", motion, allowed)
    names = ROLLING if isinstance(motion, Steady) else SHIFTING
    triples = checks.numbers("creepages", creepages)
    if triples.ndim != 2 or triples.shape[1] != 3 or triples.size == 0:
        words = ", ".join(names)
        allowed = f"of shape (k, 3), a row of {words} for each solution"
        if triples.shape == (3,):
            allowed += f"; a single solution is [[{words}]]"
        raise checks.wrong_shape("creepages", triples.shape, allowed)
    return [replace(motion, **dict(zip(names, each, strict=True))) for each in triples.tolist()]


@checks.named_options()
def creep_curve(
    scene: Scene,
    methods: Iterable[str] | Mapping[str, Mapping[str, Any]] = ("auto", "fastsim", "fastrip"),
    *,
    vx: Any = None,
    vy: Any = None,
    spin: Any = None,
    by: str | Sequence[str] = (),
    progress: Progress = None,
) -> xr.Dataset:
    """Forces and moment against creepages, by several methods.

    Parameters
    ----------
    scene : Scene
        In steady rolling, with no prescribed tangential force.
    methods : iterable of str, or dict of str to dict
        Fast theories by their names in `creep_forces`, which need no grid, and
        methods as `compare` names them. A dict has the options of each theory,
        as ``{"polach": {"k_A": 0.3, "k_S": 0.1}, "auto": {}}``. FASTSIM takes
        the compliance of an elastic third body from the scene. A theory to
        which the scene's friction (a law) does not apply in this form is
        evaluated on the grid.
    vx, vy, spin : float or array_like, optional
        Creepages, which broadcast to one dimension, one at least; the scene's
        own where not given.
    by : str or sequence of str
        Numbers of the scene by which forces and moment have derivatives too, as
        of `Solution.gradient`: of exact methods.
    progress : callable or true, optional
        Called with one line of text for each method.

    Returns
    -------
    xarray.Dataset
        Fx, Fy and Mz, and derivatives as ``Fx_by_friction``, over `theory` (the
        names of the methods) and `point`; vx, vy and spin over `point`; with
        the units of the scene, if it has them. As an attribute ``limit``, the
        friction limit (nan for friction that has no single coefficient). Mz is
        nan by a theory that has none.

    Raises
    ------
    SceneError, SolverUnavailable, Saturated, NotConverged, TooLarge
        As `scan` and `creep_forces`; or if creepages do not broadcast to one
        dimension.

    Examples
    --------
    >>> import numpy as np
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> curve = vc.creep_curve(scene, ["fastsim", "newton"], vx=np.linspace(0.0, 6e-3, 4))
    >>> print((curve.Fx / curve.limit).round(2).values)
    [[ 0.   -0.63 -0.91 -0.99]
     [ 0.   -0.68 -0.97 -1.  ]]
    """
    motion = scene.motion if isinstance(scene, Scene) else None
    if not isinstance(motion, Steady) or motion.Fx is not None or motion.Fy is not None:
        raise SceneError("scene", scene, "a Scene in steady rolling, with no prescribed force")
    names = _method_names(methods)
    triples = creepages_over(motion, {"vx": vx, "vy": vy, "spin": spin})
    inputs = inputs_of(by, [scene])
    report = checks.progress(progress)
    theory_options = methods if isinstance(methods, Mapping) else {}
    scan_options = {  # unsuitable methods are refused before anything is solved
        name: _scan_options(scene, name, theory_options.get(name, {})) for name in names
    }
    if inputs:
        check_exact(scene, names)
    forces = []
    slopes = []
    for name, options in scan_options.items():
        report(f"{name}: {len(triples)} points")
        if options is None:
            forces.append(_by_formula(scene, name, triples, theory_options.get(name, {})))
            continue
        found, derivatives = _by_scan(scene, triples, options, inputs)
        forces.append(found)
        slopes.append(derivatives)
    curves = _curves(scene, names, triples, np.array(forces) + 0.0)  # no negative zeros
    return curves.assign(columns_of(slopes, inputs, ("theory", "point"), scene.units))


def check_exact(scene: Scene, names: Iterable[str]) -> None:
    """Refuse derivatives by theories."""
    for name in names:
        if _has_formula(scene, name) or Method.named(name).plan(scene).theory is not None:
            allowed = f"exact methods alone, where derivatives are wanted: {name} has none"
            raise SceneError("methods", name, allowed)


def _method_names(methods: Any) -> list[Any]:
    names: list[Any] = []
    if isinstance(methods, str):
        names = [methods]
    elif isinstance(methods, Iterable):
        names = list(methods)
    if not names or len({str(name) for name in names}) < len(names):
        raise SceneError("methods", methods, "at least one name, none of them twice")
    return names


def _curves(scene: Scene, names: list[Any], triples: np.ndarray, forces: np.ndarray) -> xr.Dataset:
    """Dataset of the forces (method, point, 3) over the creepages (point, 3)."""
    import xarray as xr

    def with_unit(dims: Any, values: Any, quantity: str) -> tuple[Any, ...]:
        unit = {} if scene.units is None else {"units": scene.units.of(quantity)}
        return dims, values, unit

    Fx, Fy, Mz = np.moveaxis(forces, -1, 0)
    vx, vy, spin = triples.T
    over = ("theory", "point")
    data = {
        "Fx": with_unit(over, Fx, "force"),
        "Fy": with_unit(over, Fy, "force"),
        "Mz": with_unit(over, Mz, "moment"),
    }
    coordinates = {
        "theory": names,
        "vx": with_unit("point", vx, "1"),
        "vy": with_unit("point", vy, "1"),
        "spin": with_unit("point", spin, "spin"),
    }
    return xr.Dataset(data, coordinates, {"limit": _coulomb_limit(scene)})


def _coulomb_limit(scene: Scene) -> float:
    """Friction force f Fz by Coulomb's law; NaN without a single coefficient, if it is infinite, or
    without a known force.
    """
    force = scene.normal_force
    if scene.hertz is not None:
        force = scene.hertz.force
    if force is None or not isinstance(scene.friction, float) or not np.isfinite(scene.friction):
        return float(np.nan)
    return float(scene.friction * force)


def _by_scan(
    scene: Scene, triples: np.ndarray, options: dict[str, Any], inputs: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Fx, Fy and Mz, in batches where no method is named, and derivatives by inputs, of which
    batches have none.
    """
    forces = np.empty(triples.shape)
    slopes = np.empty((*triples.shape, len(inputs)))
    left = np.ones(len(triples), bool)
    if set(options.values()) <= {"auto", None} and not inputs:
        scenes = [replace(scene, motion=motion) for motion in _motions(scene, triples)]
        figures, solved = solve_batches(scenes, TOLERANCE)
        forces[solved] = np.stack([figures[name][solved] for name in ("Fx", "Fy", "Mz")], axis=-1)
        left = ~solved
    if left.any():
        solutions = scan(scene, triples[left], certify=None, **options)
        forces[left] = [[*each.force, each.moment] for each in solutions]
        slopes[left] = [derivatives_of(each, inputs) for each in solutions]
    return forces, slopes


def creepages_over(motion: Any, ranges: Mapping[str, Any], mark: str = "") -> np.ndarray:
    """Creepages (k, 3) over ranges of some, with the motion's own for the others; errors name them
    with a `mark`.
    """
    ranged = {
        name: checks.numbers(f"{mark}{name}", each)
        for name, each in ranges.items()
        if each is not None
    }
    own = motion.rigid if isinstance(motion, Steady | Shift) else (0.0, 0.0, 0.0)
    try:
        values = dict(zip(ROLLING, own, strict=True)) | ranged
        columns = np.broadcast_arrays(*np.atleast_1d(*values.values()))
    except ValueError:
        columns = ()
    if not ranged or not columns or columns[0].ndim != 1:
        fields = ", ".join(f"{mark}{name}" for name in ROLLING)
        shapes = ", ".join(f"{mark}{name} {np.shape(each)}" for name, each in ranged.items())
        message = (
            f"{fields}: give a range or several values for at least one; "
            f"further ranges must have the same length; given: {shapes or 'none'}"
        )
        raise SceneError(fields, shapes, message=message)
    return np.stack(columns, axis=-1)


def _scan_options(
    scene: Scene, name: Any, theory_options: Mapping[str, Any]
) -> dict[str, Any] | None:
    """The options of a scan by a method; None for a theory that is evaluated for all creepages at
    once.
    """
    if not isinstance(theory_options, Mapping):
        raise SceneError(f"methods[{name!r}]", theory_options, 'a dict of options, as {"k_A": 0.3}')
    if _has_formula(scene, name):
        return None
    method = Method.named(name)
    closed_form = method.plan(scene).normal == "hertz"
    methods = method.methods
    if closed_form:
        methods = replace(methods, normal="auto")
    options = {"methods": methods, "polish": method.polish or None}
    if theory_options:
        allowed = f"without options: only theories by formula have them, not {name} here"
        raise SceneError("methods", name, allowed)
    return options


def _has_formula(scene: Scene, name: Any) -> bool:
    """True for a theory whose formula applies to the scene."""
    single = isinstance(scene.friction, float) and 0 < scene.friction < np.inf
    if not scene.flows and name.startswith("fastsim"):
        scene = scene.without_layer  # its compliance is in the formula
    return name in VECTORISED and (single or name == "linear") and why_not(name, scene) == ""


def _by_formula(
    scene: Scene, name: Any, triples: np.ndarray, options: Mapping[str, Any]
) -> np.ndarray:
    hertz = scene.hertz
    assert hertz is not None
    contact: dict[str, Any] = {
        "a": hertz.a,
        "b": hertz.b,
        "bodies": scene.bodies,
        "normal_force": hertz.force,
    }
    if not scene.bare:
        contact["layer"] = scene.layer_compliance
    contact |= zip(ROLLING, triples.T, strict=True)
    friction = scene.friction if isinstance(scene.friction, float) else 1.0  # not used by "linear"
    forces = creep_forces(name, friction=friction, **contact | dict(options))
    return np.stack([forces.Fx, forces.Fy, forces.Mz], axis=-1)
