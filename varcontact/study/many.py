"""Thousands of small contacts at once: the scenes that fit are solved in batches, the others one by one."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.elasticity.operators import edge_compliance
from varcontact.errors import SceneError, VarcontactError
from varcontact.reference.creepage_coefficients import creepage_coefficients
from varcontact.reference.hertz import HertzContact, semi_axes
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Edge, Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids
from varcontact.solvers.batched.newton import solve_batch
from varcontact.solvers.batched.problem import BatchedProblem, BatchedSolution
from varcontact.solving import adaptive
from varcontact.solving.options import BY_DEFAULT, TOLERANCE
from varcontact.solving.solve import solve

if TYPE_CHECKING:
    import xarray as xr

    from varcontact.results.solution import Solution

MOST_ACROSS = 64
"""Elements along a side of the largest lattice that is solved in batches: beyond it transforms by FFT are faster."""
PIECE = 4_000_000
"""Elements of the scenes that are posed together: some 300 MB."""
VALUES = ("Fx", "Fy", "Mz", "vx", "vy", "spin")


@dataclass(frozen=True)
class Lattice:
    """What scenes of one batch have in common."""

    shift: bool
    nx: int
    ny: int
    margin: int
    edge: Edge
    difference: str | None
    line: bool

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns, with the margin."""
        return (1 if self.line else self.ny + 2 * self.margin), self.nx + 2 * self.margin


@dataclass(frozen=True, eq=False)
class Contacts:
    """Hertz's contacts of like bodies, as arrays over the scenes.

    Semi-axes a and b (1 in line contact), modulus, Poisson's ratio, normal force, friction, the rigid motion (3, n),
    the point in a step where spin is sampled, and the forces prescribed (2, n), NaN where the motion is.
    """

    a: np.ndarray
    b: np.ndarray
    G: np.ndarray
    nu: np.ndarray
    normal_force: np.ndarray
    friction: np.ndarray
    rigid: np.ndarray
    spin_offset: np.ndarray
    force: np.ndarray

    def part(self, which: np.ndarray) -> Contacts:
        """Some of them."""
        return Contacts(*(each[..., which] for each in vars(self).values()))


def solve_many(
    scenes: Iterable[Scene],
    *,
    tol: float = TOLERANCE,
    accuracy: float | None = None,
    fields: bool = False,
    start: xr.Dataset | None = None,
    failures: str = "raise",
    progress: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Forces, moments and creepages of many scenes, with a certificate for each.

    Steady rolling and shifts of Hertzian contacts of like half-spaces with a coefficient of friction, on lattices of up
    to 64 elements a side, are solved in batches; other scenes, and the few that miss the tolerance, by `solve`. The
    result does not depend on the order of the scenes, nor on how many there are.

    Parameters
    ----------
    scenes : iterable of Scene
        Of any kind but histories, mixed as they come.
    tol : float
        Required natural-map residual, relative to the largest traction, and relative gap.
    accuracy : float, optional
        Largest error by the friction limit, of scenes without a grid; 0.01 if not given.
    fields : bool
        Whether the dataset has tractions, traction bounds and element centres; of scenes on one lattice only.
    start : xarray.Dataset, optional
        Result with `fields` of as many scenes on the same lattice, such as the time step before: a warm start.
    failures : {"raise", "keep"}
        Whether a scene that cannot be solved ends the call, by an error that names it as ``scenes[17]``, or has NaN,
        and the reason in `message`.
    progress : callable, optional
        Called with one line of text for each batch.

    Returns
    -------
    xarray.Dataset
        Over `scene`: normal_force, Fx, Fy, Mz, and vx, vy, spin (of a shift ux, uy, rotation), prescribed or found;
        `residual` and `gap` (relative); `ok`; `by`, "batched" or "solve"; `message`. Scenes solved to an accuracy have
        extrapolated values, and error bars `Fx_error`, ... With `fields`: `traction` (scene, component, y, x),
        `traction_bound` (scene, y, x), x_centre (scene, x), y_centre (scene, y).

    Raises
    ------
    SceneError
        If there is no scene, or one is none or a history, or for fields of different lattices.
    SceneError, Saturated, NotConverged, TooLarge
        As `solve`, with ``failures="raise"``.

    Notes
    -----
    A Newton method without a matrix takes one step for all scenes of a batch at once; its products are transforms by
    dense matrices.

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
    given = _checked(scenes)
    tol, report = checks.positive("tol", tol), checks.progress(progress)
    checks.choice("failures", failures, ("raise", "keep"))
    target = BY_DEFAULT if accuracy is None else checks.positive("accuracy", accuracy)
    n = len(given)
    found: dict[str, Any] = {name: np.full(n, np.nan) for name in (*VALUES, "normal_force", "residual", "gap")}
    found |= {f"{name}_error": np.full(n, np.nan) for name in VALUES[:5]}
    found |= {"ok": np.zeros(n, bool), "by": np.full(n, "solve", dtype=object), "message": np.full(n, "", dtype=object)}
    groups: dict[Lattice | None, list[int]] = {}
    for i, scene in enumerate(given):
        groups.setdefault(_lattice(scene, target), []).append(i)
    if (fields or start is not None) and (len(groups) > 1 or None in groups or given[0].grid == "auto"):
        raise SceneError("fields", True, "False: the scenes are not on one lattice of a batch, or have no grid")
    shown: dict[str, Any] = {}
    for lattice, members in groups.items():
        if lattice is None:
            continue
        contacts, size = _contacts([given[i] for i in members]), math.prod(lattice.shape)
        for first in range(0, len(members), max(1, PIECE // size)):
            some = np.arange(first, min(first + max(1, PIECE // size), len(members)))
            where = np.array(members)[some]
            kept: dict[str, np.ndarray] = {}
            if given[members[0]].grid == "auto":
                answers = _to_accuracy(contacts.part(some), lattice, tol, target)
            else:
                answers, kept = _on_lattice(contacts.part(some), lattice, tol, _begun(start, where))
            for name, values in answers.items():
                found[name][where] = values
            for name, values in kept.items() if fields else ():
                shown.setdefault(name, np.zeros((n, *values.shape[1:])))[where] = values
            found["by"][where[answers["ok"]]] = "batched"
            if report is not None:
                report(f"{lattice.shape[1]} x {lattice.shape[0]} elements: {len(where)} scenes")
    for i in np.flatnonzero(found["by"] == "solve").tolist():
        if report is not None:
            report(f"scenes[{i}]: by itself")
        try:
            sol = solve(given[i], tol=tol, accuracy=target if given[i].grid == "auto" else None, certify="gap")
        except VarcontactError as error:
            error.args = (f"scenes[{i}]: {error.args[0]}",)
            if failures == "raise":
                raise
            found["message"][i] = str(error)
            for name in (*VALUES, "residual", "gap"):
                found[name][i] = np.nan
        else:
            _keep(found, i, sol)
            if shown:
                shown["traction"][i], shown["traction_bound"][i] = sol.traction, sol.traction_bound
    return _dataset(found, shown)


def _checked(scenes: Iterable[Scene]) -> list[Scene]:
    given = list(scenes) if isinstance(scenes, Iterable) else []
    if not given:
        raise SceneError("scenes", scenes, "one scene or more")
    for i, scene in enumerate(given):
        if not isinstance(scene, Scene) or not isinstance(scene.motion, Steady | Shift | None):
            raise SceneError(f"scenes[{i}]", scene, "a Scene without steps in time: solve() takes histories")
    return given


def _most_across(line: bool) -> int:
    return 4 * MOST_ACROSS if line else MOST_ACROSS


def _lattice(scene: Scene, accuracy: float) -> Lattice | None:
    """The lattice of a scene in a batch, the first one where its grid is chosen; None where it fits no batch."""
    motion, bodies, surface, grid = scene.motion, scene.bodies, scene.surface, scene.grid
    if motion is None or not isinstance(bodies, Bodies) or bodies.K != 0:
        return None
    if not isinstance(surface, Ellipse | Paraboloids | Cylinders) or not scene.normal_force:
        return None
    if not isinstance(scene.friction, float) or not 0 < scene.friction < math.inf:
        return None
    if math.hypot(motion.Fx or 0.0, motion.Fy or 0.0) >= scene.friction * scene.normal_force:
        return None
    line, shift = isinstance(surface, Cylinders), isinstance(motion, Shift)
    if isinstance(motion, Steady) and motion.dq is not None:
        return None
    if line and shift:  # needs a reference depth
        return None
    difference = motion.slip_difference if isinstance(motion, Steady) else None
    if grid == "auto":
        n = adaptive.coarsest(line, accuracy)
        edge: Edge = "touched" if shift else "softened"
        difference, margin = None if shift else "second-order", Grid(nx=1).margin
        return Lattice(shift, n, 1 if line else n, margin, edge, difference, line)
    if grid.explicit:
        return None
    found = Lattice(shift, grid.nx, grid.rows, grid.margin, grid.edge, difference, line)
    return found if max(found.shape) <= _most_across(line) else None


def _contacts(scenes: Sequence[Scene]) -> Contacts:
    bodies: list[Any] = [scene.bodies for scene in scenes]
    motions: list[Any] = [scene.motion for scene in scenes]
    G, nu = (np.array([getattr(each, name) for each in bodies]) for name in ("combined_G", "combined_nu"))
    force = np.array([scene.normal_force for scene in scenes], float)
    a, b = np.ones(len(scenes)), np.ones(len(scenes))
    curved = np.array([isinstance(scene.surface, Paraboloids) for scene in scenes])
    if curved.any():
        radii = np.array([(s.surface.Rx, s.surface.Ry) for s in scenes if isinstance(s.surface, Paraboloids)])
        a[curved], b[curved] = semi_axes(radii[:, 0], radii[:, 1], G[curved], nu[curved], force[curved])
    for i in np.flatnonzero(~curved).tolist():
        surface, hertz = scenes[i].surface, scenes[i].hertz
        assert hertz is not None
        a[i], b[i] = hertz.a, 1.0 if isinstance(surface, Cylinders) else hertz.b
    return Contacts(
        a=a,
        b=b,
        G=G,
        nu=nu,
        normal_force=force,
        friction=np.array([scene.friction for scene in scenes], float),
        rigid=np.array([each.rigid for each in motions]).T,
        spin_offset=np.array([getattr(each, "spin_offset", 0.0) for each in motions]),
        force=np.array([[np.nan if F is None else F for F in (each.Fx, each.Fy)] for each in motions]).T,
    )


def _posed(contacts: Contacts, lattice: Lattice) -> tuple[BatchedProblem, np.ndarray, np.ndarray, np.ndarray]:
    """The tangential problems, and the element centres and area: Hertz's pressure has one shape for all ellipses."""
    unit = HertzContact(1.0, math.inf if lattice.line else 1.0, 1.0, 1.0, 1.5 / math.pi, 1.0, 1.0)
    grid = Grid(nx=lattice.nx, ny=None if lattice.line else lattice.ny, margin=lattice.margin, edge=lattice.edge)
    grid = grid.spread((-1.0, 1.0, -0.5, 0.5) if lattice.line else (-1.0, 1.0, -1.0, 1.0))
    if lattice.line:
        unit = replace(unit, peak_pressure=2 / math.pi)
    pressure = unit.on_elements(grid)
    pressure = pressure / (pressure.sum() * grid.area)
    a, b, (dx, dy) = contacts.a, contacts.b, grid.sides
    x, y = grid.x[None, :, None] * a, grid.y[:, None, None] * b * (not lattice.line)
    first, second, turn = contacts.rigid
    given = np.isnan(contacts.force)
    first, second = np.where(given[0], first, 0.0), np.where(given[1], second, 0.0)
    step = 1.0 if lattice.shift else dx * a
    ahead = 0.0 if lattice.shift else contacts.spin_offset * dx * a
    zero = np.zeros((*grid.shape, len(a)))
    rigid = np.stack([first - turn * y + zero, second + turn * (x + ahead) + zero]) * step * contacts.G
    area = dx * dy * a * b
    problem = BatchedProblem(
        dx=dx * a,
        dy=dy * b,
        nu=contacts.nu,
        rigid_shift=rigid,
        bound=pressure[..., None] * (contacts.friction * contacts.normal_force / (a * b)),
        force=contacts.force / area,
        difference=lattice.difference,
        line=lattice.line,
        compliance=edge_compliance(unit.covered(*grid.lines)) * (pressure > 0) if lattice.edge == "softened" else None,
    )
    return problem, x + zero, y + zero, area


def _on_lattice(
    contacts: Contacts, lattice: Lattice, tol: float, start: dict[str, np.ndarray] | None = None
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Answers over the scenes, and their fields."""
    problem, x, y, area = _posed(contacts, lattice)
    step = contacts.G * (1.0 if lattice.shift else problem.dx)
    begun = None
    if start is not None:
        part = start["traction"] / np.where(start["bound"] > 0, start["bound"], 1.0)
        before = np.where(np.isnan(problem.force), 0.0, start["rigid"] * step)
        nothing = np.zeros(len(area))
        begun = BatchedSolution(part * problem.bound, before, nothing, nothing, nothing > 0, nothing.astype(int))
    found = solve_batch(problem, tol, begun)
    Fx, Fy = found.traction.sum(axis=(1, 2)) * area
    rigid = np.where(np.isnan(contacts.force), contacts.rigid[:2], found.rigid / step)
    answers = {
        "normal_force": contacts.normal_force,
        "Fx": Fx,
        "Fy": Fy,
        "Mz": (x * found.traction[1] - y * found.traction[0]).sum(axis=(0, 1)) * area,
        "vx": rigid[0],
        "vy": rigid[1],
        "spin": contacts.rigid[2],
        "residual": found.residual,
        "gap": found.relative_gap,
        "ok": found.converged,
    }
    fields = {
        "traction": np.moveaxis(found.traction, -1, 0),
        "traction_bound": np.moveaxis(problem.bound, -1, 0),
        "x": x[0].T,
        "y": y[:, 0].T,
    }
    return answers, fields


def _begun(start: xr.Dataset | None, where: np.ndarray) -> dict[str, np.ndarray] | None:
    """The fields of a warm start, with the scenes last."""
    if start is None:
        return None
    if "traction" not in start or start.sizes["scene"] <= where.max():
        raise SceneError("start", start, "the result of as many scenes on the same lattice, with fields=True")
    some = start.isel(scene=where)
    return {
        "traction": np.moveaxis(some["traction"].to_numpy(), 0, -1),
        "bound": np.moveaxis(some["traction_bound"].to_numpy(), 0, -1),
        "rigid": np.array([some["vx"].to_numpy(), some["vy"].to_numpy()]),
    }


def _to_accuracy(contacts: Contacts, lattice: Lattice, tol: float, accuracy: float) -> dict[str, np.ndarray]:
    """Answers extrapolated by the rule of `solving.adaptive`; not ok where the lattices of a batch do not suffice."""
    contacts = replace(contacts, spin_offset=0.0 * contacts.spin_offset)  # that of second-order differences
    n, count, units = lattice.nx, len(contacts.a), _units(contacts, lattice)
    names = ("normal_force", *VALUES, "residual", "gap", *(f"{name}_error" for name in units))
    answers = {name: np.full(count, np.nan) for name in names} | {"ok": np.zeros(count, bool)}
    levels: list[tuple[int, dict[str, np.ndarray]]] = []
    waiting = np.arange(count)
    while waiting.size:
        nx = n if lattice.shift or lattice.line else round(adaptive.RATIO * n)
        now = replace(lattice, nx=nx, ny=1 if lattice.line else n)
        if max(now.shape) > _most_across(lattice.line):
            break
        on_grid, _ = _on_lattice(contacts.part(waiting), now, tol)
        values = {name: np.full(count, np.nan) for name in units}
        for name in units:
            values[name][waiting] = np.where(on_grid["ok"], on_grid[name], np.nan)
        levels = [*levels, (n, values)][-adaptive.GRIDS :]
        if len(levels) == adaptive.GRIDS:
            best, errors = _extrapolated(levels, units)
            reached = np.max([errors[name][waiting] for name in units], axis=0) <= accuracy
            done = waiting[reached]
            for name, each in on_grid.items():
                answers[name][done] = each[reached]
            for name, unit in units.items():
                measured = done[~np.isnan(unit[done])]
                answers[name][measured] = best[name][measured]
                answers[f"{name}_error"][measured] = (errors[name] * unit)[measured]
            size, limit = (
                np.hypot(answers["Fx"][done], answers["Fy"][done]),
                (contacts.friction * contacts.normal_force)[done],
            )
            for name in ("Fx", "Fy"):  # extrapolated, a force may be beyond the limit by a little
                answers[name][done] *= np.minimum(1.0, limit / np.maximum(size, 1e-300))
            waiting = waiting[~reached]
        n = math.ceil(adaptive.RATIO * n)
    return answers


def _extrapolated(
    levels: Sequence[tuple[int, dict[str, np.ndarray]]], units: dict[str, np.ndarray]
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Values of the last grid with half of Richardson's step, and errors in their units; 0 of what is prescribed."""
    (first, coarse), (second, middle), (fine, last) = levels
    orders = [(b / a) ** adaptive.ORDER - 1 for a, b in ((first, second), (second, fine))]
    best, errors = {}, {}
    for name, unit in units.items():
        before, step = (middle[name] - coarse[name]) / orders[0], (last[name] - middle[name]) / orders[1]
        most = np.maximum(np.abs(step), (second / fine) ** adaptive.ORDER * np.abs(before))
        error = adaptive.SAFETY * most / unit + adaptive.FLOOR * fine**-adaptive.ORDER
        best[name] = last[name] + adaptive.PART * step
        errors[name] = np.where(np.isnan(unit), 0.0, error)
    return best, errors


def _units(contacts: Contacts, lattice: Lattice) -> dict[str, np.ndarray]:
    """What an error of one is, as `results.quantities_of_interest.units` has it; NaN of what is prescribed."""
    a, b, G, nu, force = contacts.a, contacts.b, contacts.G, contacts.nu, contacts.force
    limit, prescribed = contacts.friction * contacts.normal_force, ~np.isnan(force)
    if lattice.line:
        creepage = 4 * (1 - nu) * limit / (math.pi * G * a)
    elif lattice.shift:
        creepage = 3 * (2 - nu) * limit / (8 * G * np.sqrt(a * b))
    else:
        creepage = np.full(len(a), np.nan)
        for i in np.flatnonzero(prescribed.any(axis=0)):
            creepage[i] = 3 * limit[i] / (G[i] * a[i] * b[i] * creepage_coefficients(a[i], b[i], nu[i]).C11)
    units = {"Fx": np.where(prescribed[0], np.nan, limit), "Fy": np.where(prescribed[1], np.nan, limit)}
    units |= {"vx": np.where(prescribed[0], creepage, np.nan), "vy": np.where(prescribed[1], creepage, np.nan)}
    return units if lattice.line else units | {"Mz": limit * np.sqrt(a * b)}


def _keep(found: dict[str, Any], i: int, sol: Solution) -> None:
    """Write down the solution of one scene."""
    for name in VALUES:
        found[name][i] = getattr(sol, name)
    found["normal_force"][i] = sol.normal_force
    found["residual"][i], found["gap"][i] = sol.certificate.residual, sol.certificate.relative_gap
    found["ok"][i] = sol.converged
    if sol.error_estimate is not None:
        for name, bar in sol.error_estimate.bars.items():
            name = {"ux": "vx", "uy": "vy"}.get(name, name)
            if f"{name}_error" in found:
                found[f"{name}_error"][i] = bar


def _dataset(found: dict[str, Any], shown: dict[str, Any]) -> xr.Dataset:
    import xarray as xr

    over = {"traction": ("scene", "component", "y", "x"), "traction_bound": ("scene", "y", "x")}
    fields = {name: (over.get(name, ("scene", name)), values) for name, values in shown.items()}
    fields = {{"x": "x_centre", "y": "y_centre"}.get(name, name): each for name, each in fields.items()}
    numbers = {
        name: ("scene", np.array(values, str) if name in ("by", "message") else values)
        for name, values in found.items()
    }
    return xr.Dataset({**numbers, **fields})
