"""Creep-force curves by several methods: fast theories and exact solvers side by side (paper, Figs. 9 and 22 to 24)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.study.method import Method
from varcontact.study.scan import scan
from varcontact.theories.creep_forces import VECTORISED, creep_forces
from varcontact.theories.on_grid import why_not

if TYPE_CHECKING:
    import xarray as xr

NAMES = ("vx", "vy", "spin")


def creep_curve(
    scene: Scene,
    methods: Iterable[str] = ("auto", "fastsim", "fastrip"),
    *,
    vx: Any = None,
    vy: Any = None,
    spin: Any = None,
    progress: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Forces and moment against creepages, by several methods.

    Parameters
    ----------
    scene : Scene
        In steady rolling, with no prescribed tangential force.
    methods : iterable of str
        Fast theories by their names in `creep_forces`, which need no grid, and methods as `compare` names them. A
        theory that the scene's friction keeps from that (a law) is taken on the grid.
    vx, vy, spin : float or array_like, optional
        Creepages, which broadcast to one dimension; the scene's own where not given. One at least has several values.
    progress : callable, optional
        Called with one line of text for each method.

    Returns
    -------
    xarray.Dataset
        Fx, Fy and Mz over `theory` (the names of the methods) and `point`; vx, vy and spin over `point`; as an
        attribute ``limit``, what friction can carry at most (nan for friction that has no single coefficient). Mz is
        nan by a theory that has none.

    Raises
    ------
    SceneError, SolverUnavailable, Saturated, NotConverged, TooLarge
        As `scan` and `creep_forces`; or if creepages do not broadcast to one dimension.

    Examples
    --------
    >>> import numpy as np
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> curve = vc.creep_curve(scene, ["fastsim", "newton"], vx=np.linspace(0.0, 6e-3, 4))
    >>> print((curve.Fx / curve.limit).round(2).values)
    [[ 0.   -0.63 -0.91 -0.99]
     [ 0.   -0.68 -0.97 -1.  ]]
    """
    import xarray as xr

    motion = scene.motion if isinstance(scene, Scene) else None
    if not isinstance(motion, Steady) or motion.Fx is not None or motion.Fy is not None:
        raise SceneError(
            "scene",
            scene,
            message="scene: a creep-force curve needs a Scene in steady rolling, with no prescribed force",
        )
    names = [str(name) for name in ([methods] if isinstance(methods, str) else methods)]
    if not names or len(set(names)) < len(names):
        raise SceneError("methods", names, "one name at least, none of them twice")
    triples = _triples(motion, {"vx": vx, "vy": vy, "spin": spin})
    report = checks.progress(progress)
    ways = [(name, _way(scene, name)) for name in names]  # what cannot be done is refused before anything is
    found = []
    for name, way in ways:
        if report is not None:
            report(f"{name}: {len(triples)} points")
        found.append(way(triples))
    Fx, Fy, Mz = np.moveaxis(np.array(found) + 0.0, -1, 0)  # no negative zeros
    points = {name: ("point", triples[:, i]) for i, name in enumerate(NAMES)}
    over = ("theory", "point")
    fields = {"Fx": (over, Fx), "Fy": (over, Fy), "Mz": (over, Mz)}
    return xr.Dataset(fields, {"theory": names, **points}, {"limit": _limit(scene)})


def _triples(motion: Steady, given: dict[str, Any]) -> np.ndarray:
    """One row of vx, vy and spin for each point."""
    columns = [
        np.asarray(own) if each is None else checks.numbers(name, each)
        for own, (name, each) in zip(motion.rigid, given.items(), strict=True)
    ]
    try:
        columns = list(np.broadcast_arrays(*columns))
    except ValueError:
        columns = []
    if not columns or columns[0].ndim != 1 or columns[0].size < 2:
        shapes = ", ".join(f"{name} {np.shape(each)}" for name, each in given.items() if each is not None)
        message = f"give one range of two values or more, and others of its length, not {shapes or 'none'}"
        raise SceneError("vx, vy, spin", shapes, message=f"vx, vy, spin: {message}")
    return np.stack(columns, axis=-1)


def _way(scene: Scene, name: str) -> Callable[[np.ndarray], np.ndarray]:
    """From creepages (k, 3) to rows of Fx, Fy and Mz, by a method."""
    single = isinstance(scene.friction, float) and 0 < scene.friction < np.inf
    if name in VECTORISED and (single or name == "linear") and why_not(name, scene) == "":
        return lambda triples: _by_formula(scene, name, triples)
    method = Method.named(name)
    normal = "auto" if method.plan(scene).normal == "hertz" else method.normal
    options: dict[str, Any] = {"formulation": method.formulation, "method": method.method}
    if method.polish:
        options["polish"] = True
    tangential = method.tangential or "auto"

    def solved(triples: np.ndarray) -> np.ndarray:
        every = scan(scene, triples, normal, tangential, certify=None, **options)
        return np.array([[*sol.force, sol.moment] for sol in every])

    return solved


def _by_formula(scene: Scene, name: str, triples: np.ndarray) -> np.ndarray:
    hertz = scene.hertz
    assert hertz is not None
    friction = scene.friction if isinstance(scene.friction, float) else 1.0  # "linear" has no use for it
    contact: dict[str, Any] = {
        "a": hertz.a,
        "b": hertz.b,
        "bodies": scene.bodies,
        "normal_force": hertz.force,
        "friction": friction,
    }
    vx, vy, spin = triples.T
    found = creep_forces(name, **contact, vx=vx, vy=vy, spin=spin)
    return np.stack([found.Fx, found.Fy, found.Mz], axis=-1)


def _limit(scene: Scene) -> float:
    """f Fz, where both are single numbers."""
    force = scene.hertz.force if scene.hertz is not None else scene.normal_force
    if force is None or not isinstance(scene.friction, float) or not np.isfinite(scene.friction):
        return float("nan")
    return scene.friction * force
