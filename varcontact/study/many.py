"""Thousands of small contacts at once: the scenes that fit are solved in batches, the others one by
one.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, VarcontactError
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.batched_on_grids import (
    FIGURES,
    START,
    Fields,
    InitialTractions,
    fits,
    march_batches,
)
from varcontact.solving.batched_to_accuracy import BARS, solve_batches
from varcontact.solving.options import TOLERANCE, SolveOptions, check_saturation
from varcontact.solving.solve import certify as certificate
from varcontact.solving.solve import solve
from varcontact.study.derivatives import OUTPUTS, columns_of, derivatives_of, inputs_of
from varcontact.study.methods import BOUNDS, figures
from varcontact.system.progress import Progress

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
    by: str | Sequence[str] = (),
    failures: Literal["raise", "keep"] = "raise",
    progress: Progress = None,
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
        Scenes of any kind, in any order; or histories of equally many steps,
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
    by : str or sequence of str
        Numbers of the scenes by which Fx, Fy and Mz have derivatives too, as of
        `Solution.gradient`, on grids of their own. All scenes then are solved
        by `solve`.
    failures : {"raise", "keep"}
        Whether a scene that cannot be solved ends the call, by an error that
        names it as ``scenes[17]``, or has NaN, and the reason in `message`.
    progress : callable or true, optional
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
        `x_centre` (scene, x), `y_centre` (scene, y). Derivatives as
        `Fx_by_friction`. Of histories over (scene, step), without
        `friction_work`.

    Raises
    ------
    SceneError
        If there is no scene, one is none, or some are histories of other
        lengths, for fields or derivatives of scenes without grids or of
        histories, inputs that a scene has not, or another `start`.
    SceneError, Saturated
        As in `solve`, before any work, with ``failures="raise"``.
    NotConverged, TooLarge, SolverUnavailable
        As in `solve`, with ``failures="raise"``.

    Notes
    -----
    A Newton method without a matrix takes one step for all scenes of a batch at once; its products
    are transforms by dense matrices.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import varcontact as vc
    >>> wheel = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(), grid=vc.Grid(nx=12, ny=12))
    >>> scenes = [replace(wheel, motion=vc.Steady(vx=vx)) for vx in (0.5e-3, 1e-3, 4e-3)]
    >>> found = vc.solve_many(scenes)
    >>> print((found.Fx / (0.33 * found.normal_force)).round(3).values, bool(found.ok.all()))
    [-0.21  -0.392 -0.967] True
    """
    import xarray as xr

    many = _checked(scenes)
    tol = checks.positive("tol", tol)
    report = checks.progress(progress)
    checks.choice("failures", failures, ("raise", "keep"))
    checks.flag("fields", fields)
    if accuracy is not None:
        accuracy = checks.positive("accuracy", accuracy)
    bounded = checks.choice("certify", certify, ("gap", "full")) == "full"
    steps = _steps(many[0])
    _check_lattices(many, fields, start)
    inputs = _inputs(by, many)
    failed = _Failures(kept=failures == "keep")
    accepted = failed.accepted(many, accuracy)
    report(f"{len(accepted)} scenes in batches")
    near = None if start is None else _near(start, many)
    table = _Table.empty(len(many), steps, fields or bounded, bounded)
    # those that fit, in batches
    batched = []
    if not inputs:
        batched = [i for i in accepted if not (bounded and _bounds_need_solve(many[i]))]
    if steps:
        table.put_batched(*march_batches(many, tol, batched))
    else:
        table.put_batched(*solve_batches(many, tol, accuracy, table.fields, near, batched))
    if bounded:
        table.put_bounds(many)
    # the others, one by one
    slopes = np.full((len(many), len(OUTPUTS), len(inputs)), math.nan)
    for i in accepted:
        if table.ok[i]:
            continue
        report(f"scenes[{i}]: by itself")
        with failed.of_scene(i):
            options: Any = {"accuracy": _accuracy(many[i], accuracy), "certify": certify}
            solution: Any = solve(many[i], tol=tol, **options)
            table.put(i, solution)
            slopes[i] = derivatives_of(solution, inputs)
    columns = table.columns(steps, failed.messages)
    columns |= columns_of(slopes, inputs, ("scene",), None)
    if fields:
        columns |= _field_arrays(table.fields or {}, len(many))
    return xr.Dataset(columns)


def _bounds_need_solve(scene: Scene) -> bool:
    """Batches bound tractions alone: not of steps, and under creepages that are prescribed."""
    return isinstance(scene.motion, Transient) or _has_forces(scene)


@dataclass(frozen=True)
class _Failures:
    """Errors by the number of their scene, which are raised or kept."""

    kept: bool
    messages: dict[int, str] = field(default_factory=dict)

    @contextmanager
    def of_scene(self, i: int) -> Iterator[None]:
        """Give an error the number of its scene, and raise or keep it."""
        try:
            yield
        except VarcontactError as error:
            message = f"scenes[{i}]: {error.args[0]}"
            self.messages[i] = message
            error.args = (message,)
            if not self.kept:
                raise

    def accepted(self, scenes: list[Scene], accuracy: float | None) -> list[int]:
        """Numbers of the scenes that can be solved, before any work."""
        for i, scene in enumerate(scenes):
            with self.of_scene(i):
                _check_scene(scene, accuracy)
        return [i for i in range(len(scenes)) if i not in self.messages]


@dataclass(frozen=True)
class _Table:
    """Results of scenes as they are solved; figures as arrays over (scene, step)."""

    figures: dict[str, np.ndarray]
    ok: np.ndarray
    solved_by: np.ndarray
    fields: Fields | None

    @classmethod
    def empty(cls, count: int, steps: int | None, with_fields: bool, bounded: bool) -> _Table:
        names = [*FIGURES, *BARS]
        if bounded:
            names += BOUNDS
        return cls(
            figures={name: np.full((count, steps or 1), math.nan) for name in names},
            ok=np.zeros(count, bool),
            solved_by=np.full(count, "solve", dtype="<U7"),
            fields={} if with_fields else None,
        )

    def put_batched(self, answers: Mapping[str, np.ndarray], solved: np.ndarray) -> None:
        """Enter the figures of the scenes that were solved in batches."""
        for name, values in answers.items():
            self.figures[name][solved] = values.reshape(len(self.ok), -1)[solved]
        self.ok[solved] = True
        self.solved_by[solved] = "batched"

    def put_bounds(self, scenes: list[Scene]) -> None:
        """Enter the guaranteed bounds of the tractions that were solved in batches."""
        for i, (traction, *_) in (self.fields or {}).items():
            bounds = certificate(scenes[i], traction).force_bound
            for name, bound in zip(BOUNDS, bounds, strict=True):
                self.figures[name][i] = bound

    def put(self, i: int, solution: Solution | History) -> None:
        """Enter the figures and the fields of a scene that was solved by itself."""
        self.ok[i] = True
        solutions = [solution] if isinstance(solution, Solution) else solution
        for step, each in enumerate(solutions):
            for name, value in figures(each).items():
                column = SHIFTS.get(name, name)
                if column in self.figures:
                    self.figures[column][i, step] = value
        if self.fields is not None and isinstance(solution, Solution):
            grid = solution.grid
            self.fields[i] = (solution.traction, solution.traction_bound, grid.x, grid.y)

    def columns(self, steps: int | None, messages: Mapping[int, str]) -> dict[str, Any]:
        """The columns of the dataset, with their dimensions."""
        named = dict(self.figures)
        named["gap"] = named.pop("relative_gap")
        columns: dict[str, Any]
        if steps:
            del named["friction_work"]
            columns = {name: (("scene", "step"), values) for name, values in named.items()}
        else:
            columns = {name: (("scene",), values[:, 0]) for name, values in named.items()}
        columns["ok"] = ("scene", self.ok)
        columns["by"] = ("scene", self.solved_by)
        every_message = np.array([messages.get(i, "") for i in range(len(self.ok))])
        columns["message"] = ("scene", every_message)
        return columns


def _checked(scenes: Iterable[Scene]) -> list[Scene]:
    many = list(scenes) if isinstance(scenes, Iterable) else []
    if not many:
        raise SceneError("scenes", scenes, "one scene or more")
    steps = _steps(many[0])
    for i, scene in enumerate(many):
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
    return many


def _check_lattices(scenes: list[Scene], fields: bool, start: Any) -> None:
    """Refuse fields, or a start, of histories and of scenes without grids of their own."""
    if not fields and start is None:
        return
    name, value = ("fields", True) if fields else ("start", start)
    if _steps(scenes[0]):
        raise SceneError(name, value, "left out: scenes are histories")
    if any(scene.grid == "auto" for scene in scenes):
        raise SceneError(name, value, "left out: a scene has no grid of its own")


def _inputs(by: Any, scenes: list[Scene]) -> list[str]:
    """Names of inputs; refused of histories and of scenes without grids of their own."""
    if not by:
        return []
    if _steps(scenes[0]):
        raise SceneError("by", by, "left out: scenes are histories")
    if any(scene.grid == "auto" for scene in scenes):
        raise SceneError("by", by, "left out: a scene has no grid of its own")
    return inputs_of(by, scenes)


def _check_scene(scene: Scene, accuracy: float | None) -> None:
    if fits(scene):
        check_saturation(scene)
    else:
        SolveOptions.checked(scene, accuracy=_accuracy(scene, accuracy))


def _accuracy(scene: Scene, accuracy: float | None) -> float | None:
    """The accuracy that a scene is solved to; None on a grid of its own."""
    return None if isinstance(scene.grid, Grid) else accuracy


def _has_forces(scene: Scene) -> bool:
    """True where a motion has a prescribed tangential force."""
    motion = scene.motion
    return isinstance(motion, Steady | Shift) and (motion.Fx is not None or motion.Fy is not None)


def _steps(scene: Scene) -> int | None:
    """The number of steps of a history."""
    if isinstance(scene, Scene) and isinstance(scene.motion, Transient):
        return scene.motion.steps
    return None


def _near(start: Any, scenes: list[Scene]) -> InitialTractions:
    """Tractions by their bound, and creepages, of a dataset of as many scenes."""
    over = FIELDS | {"vx": ("scene",), "vy": ("scene",)}
    try:
        named = {
            name: start[name].transpose(*dims).to_numpy().astype(float)
            for name, dims in over.items()
        }
    except (AttributeError, KeyError, TypeError, ValueError):
        named = {}
    if not named or len(named["vx"]) != len(scenes):
        raise SceneError("start", start, START)
    bound = named["traction_bound"][:, None]
    part = named["traction"] / np.where(bound > 0, bound, 1.0)
    return InitialTractions(part, np.stack([named["vx"], named["vy"]], axis=-1))


def _field_arrays(fields: Fields, count: int) -> dict[str, Any]:
    """Fields as arrays over the scenes, NaN beyond each scene's own grid."""
    shapes = [bound.shape for _, bound, _, _ in fields.values()]
    ny = max((shape[0] for shape in shapes), default=0)
    nx = max((shape[1] for shape in shapes), default=0)
    sizes = {"scene": count, "component": 2, "y": ny, "x": nx}
    arrays = {
        name: np.full([sizes[dim] for dim in dims], math.nan) for name, dims in FIELDS.items()
    }
    for i, own in fields.items():
        for array, values in zip(arrays.values(), own, strict=True):
            array[i][tuple(slice(n) for n in values.shape)] = values
    return {name: (FIELDS[name], array) for name, array in arrays.items()}
