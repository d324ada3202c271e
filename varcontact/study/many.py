"""Thousands of small contacts at once: the scenes that fit are solved in batches, the others one by
one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.batch import (
    BARS,
    FIGURES,
    START,
    Fields,
    Near,
    fits,
    march_batches,
    solve_batches,
)
from varcontact.solving.options import TOLERANCE, SolveOptions, check_saturation
from varcontact.solving.solve import certify as certificate
from varcontact.solving.solve import solve
from varcontact.study.methods import BOUNDS, figures

if TYPE_CHECKING:
    import xarray as xr

SHIFTS = {"ux_error": "vx_error", "uy_error": "vy_error"}
FIELDS = {
    "traction": ("scene", "component", "y", "x"),
    "traction_bound": ("scene", "y", "x"),
    "x_centre": ("scene", "x"),
    "y_centre": ("scene", "y"),
}


@checks.named_options()
def solve_many(
    scenes: Iterable[Scene],
    *,
    tol: float = TOLERANCE,
    accuracy: float | None = None,
    certify: str = "gap",
    fields: bool = False,
    start: xr.Dataset | None = None,
    failures: Literal["raise", "keep"] = "raise",
    progress: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Forces, moments and creepages of many scenes, with a certificate for each.

    Steady rolling and shifts of Hertzian contacts of like half-spaces, with a
    coefficient of friction or a law by slip, on lattices of up to 4096
    elements, are solved in batches; other scenes, and the few that miss the
    tolerance, by `solve`. The result does not depend on the order of the
    scenes, nor on how many there are.

    Parameters
    ----------
    scenes : iterable of Scene
        Of any kind, mixed as they come; or histories with as many steps each,
        which march side by side.
    tol : float
        Required natural-map residual, relative to the largest traction, and
        relative gap.
    accuracy : float, optional
        Largest error by the friction limit, of scenes without a grid; 0.01 if
        not given.
    certify : {"gap", "full"}
        Whether there are guaranteed bounds on the errors of Fx, Fy and Mz, as
        ``Fx_bound``, see `Certificate`: against the exact solution on the grid,
        so not for scenes without one. They take as long as a few solves.
    fields : bool
        Whether the dataset has tractions, traction bounds and element centres;
        of scenes with grids of their own.
    start : xarray.Dataset, optional
        Result with `fields` of as many scenes on the same lattices, such as the
        time step before: a warm start.
    failures : {"raise", "keep"}
        Whether a scene that cannot be solved ends the call, by an error that
        names it as ``scenes[17]``, or has NaN, and the reason in `message`.
    progress : callable, optional
        Called with one line of text for each batch.

    Returns
    -------
    xarray.Dataset
        Over `scene`: normal_force, Fx, Fy, Mz, and vx, vy, spin (of a shift ux,
        uy, rotation), prescribed or found; `residual` and `gap` (relative);
        elements in `contact`, `stick` and `slip`, and their areas, as
        `slip_area`; `max_pressure`; `friction_work`, see
        `Solution.friction_work`; `iterations`; `approach`; `ok`; `by`,
        "batched" or "solve"; `message`. Scenes solved to an accuracy have
        extrapolated values, and error bars `Fx_error`, ... With `fields`:
        `traction` (scene, component, y, x), `traction_bound` (scene, y, x),
        `x_centre` (scene, x), `y_centre` (scene, y). Of histories over (scene,
        step), without `friction_work`.

    Raises
    ------
    SceneError
        If there is no scene, one is none, or some are histories of other
        lengths, for fields of scenes without grids or of histories, or another
        `start`.
    SceneError, Saturated
        As `solve`, before any work, with ``failures="raise"``.
    NotConverged, TooLarge, SolverUnavailable
        As `solve`, with ``failures="raise"``.

    Notes
    -----
    A Newton method without a matrix takes one step for all scenes of a batch at once; its products
    are transforms by dense matrices.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import varcontact as vc
    >>> wheel = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> scenes = [replace(wheel, motion=vc.Steady(vx=vx)) for vx in (0.5e-3, 1e-3, 4e-3)]
    >>> found = vc.solve_many(scenes)
    >>> print((found.Fx / (0.33 * found.normal_force)).round(3).values, bool(found.ok.all()))
    [-0.21  -0.392 -0.967] True
    """
    import xarray as xr

    given = _checked(scenes)
    tol, report = checks.positive("tol", tol), checks.progress(progress)
    checks.choice("failures", failures, ("raise", "keep"))
    checks.flag("fields", fields)
    accuracy = None if accuracy is None else checks.positive("accuracy", accuracy)
    bounded = checks.choice("certify", certify, ("gap", "full")) == "full"
    steps = _steps(given[0])
    if (fields or start is not None) and (steps or any(scene.grid == "auto" for scene in given)):
        name, value = ("fields", True) if fields else ("start", start)
        why = "scenes are histories" if steps else "a scene has no grid of its own"
        raise SceneError(name, value, f"left out: {why}")
    errors: dict[int, str] = {}

    @contextmanager
    def numbered(i: int) -> Iterator[None]:
        """An error gets the number of its scene, and is raised or kept."""
        try:
            yield
        except VarcontactError as error:
            errors[i] = f"scenes[{i}]: {error.args[0]}"
            error.args = (errors[i],)
            if failures == "raise":
                raise

    for i, scene in enumerate(given):
        with numbered(i):
            if fits(scene):
                check_saturation(scene)
            else:
                SolveOptions.checked(
                    scene, accuracy=None if isinstance(scene.grid, Grid) else accuracy
                )
    kept: Fields | None = {} if fields or bounded else None
    names = (*FIGURES, *BARS, *(BOUNDS if bounded else ()))
    found = {name: np.full((len(given), steps or 1), math.nan) for name in names}
    ok, by = np.zeros(len(given), bool), np.full(len(given), "solve", dtype="<U7")
    sound = [i for i in range(len(given)) if i not in errors]
    report(f"{len(sound)} scenes in batches")
    near = None if start is None else _near(start, given)
    batched = [] if bounded and steps else sound
    if bounded:  # of tractions alone, whose creepages have to be given
        batched = [
            i
            for i in batched
            if all(getattr(given[i].motion, name, None) is None for name in ("Fx", "Fy"))
        ]
    if steps:
        answers, solved = march_batches(given, tol, batched)
    else:
        answers, solved = solve_batches(given, tol, accuracy, kept, near, batched)
    for name, values in answers.items():
        found[name][solved] = values.reshape(len(given), -1)[solved]
    ok[solved], by[solved] = True, "batched"
    for i, (traction, *_) in kept.items() if kept is not None and bounded else ():
        for name, bound in zip(BOUNDS, certificate(given[i], traction).force_bound, strict=True):
            found[name][i] = bound
    for i in sound:
        if solved[i]:
            continue
        report(f"scenes[{i}]: by itself")
        with numbered(i):
            options: Any = {
                "accuracy": None if isinstance(given[i].grid, Grid) else accuracy,
                "certify": certify,
            }
            solution = solve(given[i], tol=tol, **options)
            ok[i] = True
            for k, each in enumerate([solution] if isinstance(solution, Solution) else solution):
                for name, value in figures(each).items():
                    known = SHIFTS.get(name, name)
                    if known in found:
                        found[known][i, k] = value
            if kept is not None and isinstance(solution, Solution):
                kept[i] = (
                    solution.traction,
                    solution.traction_bound,
                    solution.grid.x,
                    solution.grid.y,
                )
    found["gap"] = found.pop("relative_gap")
    if steps:
        del found["friction_work"]
    over = ("scene", "step") if steps else ("scene",)
    columns: dict[str, Any] = {
        name: (over, values if steps else values[:, 0]) for name, values in found.items()
    }
    messages = np.array([errors.get(i, "") for i in range(len(given))])
    columns |= {"ok": ("scene", ok), "by": ("scene", by), "message": ("scene", messages)}
    return xr.Dataset(columns | (_shown(kept, len(given)) if kept is not None and fields else {}))


def _checked(scenes: Iterable[Scene]) -> list[Scene]:
    given = list(scenes) if isinstance(scenes, Iterable) else []
    if not given:
        raise SceneError("scenes", scenes, "one scene or more")
    steps = _steps(given[0])
    for i, scene in enumerate(given):
        if not isinstance(scene, Scene) or not isinstance(
            scene.motion, Steady | Shift | Transient | None
        ):
            raise SceneError(
                f"scenes[{i}]", scene, "a Scene whose motion is Steady, Shift, Transient or none"
            )
        if _steps(scene) != steps:
            raise SceneError(
                f"scenes[{i}].motion",
                scene.motion,
                "a history of as many steps, if one is a history",
            )
    return given


def _steps(scene: Scene) -> int | None:
    """Of a history."""
    return (
        scene.motion.steps
        if isinstance(scene, Scene) and isinstance(scene.motion, Transient)
        else None
    )


def _near(start: Any, given: list[Scene]) -> Near:
    """Tractions by their bound, and creepages, of a dataset of as many scenes."""
    over = FIELDS | {"vx": ("scene",), "vy": ("scene",)}
    try:
        named = {
            name: start[name].transpose(*dims).to_numpy().astype(float)
            for name, dims in over.items()
        }
    except (AttributeError, KeyError, TypeError, ValueError):
        named = {}
    if not named or len(named["vx"]) != len(given):
        raise SceneError("start", start, START)
    bound = named["traction_bound"][:, None]
    part = named["traction"] / np.where(bound > 0, bound, 1.0)
    return Near(part, np.stack([named["vx"], named["vy"]], axis=-1))


def _shown(kept: Fields, count: int) -> dict[str, Any]:
    """Fields as arrays over the scenes, NaN beyond each scene's own grid."""
    ny, nx = (max((each[1].shape[k] for each in kept.values()), default=0) for k in (0, 1))
    sizes = {"scene": count, "component": 2, "y": ny, "x": nx}
    arrays = {
        name: np.full([sizes[dim] for dim in dims], math.nan) for name, dims in FIELDS.items()
    }
    for i, own in kept.items():
        for array, values in zip(arrays.values(), own, strict=True):
            array[i][tuple(slice(n) for n in values.shape)] = values
    return {name: (FIELDS[name], array) for name, array in arrays.items()}
