"""Many scenes at once: those whose tangential problems are of one kind on
lattices of one shape, solved side by side.

These are Hertzian contacts of like half-spaces under a coefficient of friction
or a law by slip, in steady rolling or in a shift, with creepages or forces
given: most of tables, sweeps and time series. On grids across the contact the
pressure on the elements is that of the unit circle, scaled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from varcontact.discrete.contact_grid import PotentialContact, common_grid, shape_with_margin
from varcontact.discrete.edge_compliance import edge_compliance
from varcontact.errors import NoContact, SceneError
from varcontact.reference.hertz import HertzContact, approaches, semi_axes
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady, TimeStep
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids
from varcontact.scene.transient import Transient
from varcontact.solvers.batched.newton import shift_before, solve_batch
from varcontact.solvers.batched.problem import BatchedProblem, BatchedSolution, side_by_side
from varcontact.solving.time_step import largest_contacts
from varcontact.system.process import one_blas_thread

MOST_ELEMENTS = 4096
"""Elements of a lattice up to which dense transforms beat FFT by far."""
MOST_IN_LINE = 512
"""Strips in line contact up to which dense transforms beat FFT by far."""
START = "the result of as many scenes on the same lattices, with fields=True"
PASSES_MAX = 40
"""Largest number of passes under laws of friction."""
WHOLE_TOL = 1e-9
"""Largest difference from a whole number, of the elements that particles pass in a step."""
BATCH_ELEMENTS = 250_000
"""Elements of all problems of a batch: their fields take 50 MB."""
FIGURES = (
    "Fx", "Fy", "Mz", "vx", "vy", "spin", "normal_force", "approach", "gap", "relative_gap",
    "residual", "contact", "stick", "slip", "iterations", "contact_area", "stick_area",
    "slip_area", "max_pressure", "friction_work",
)  # fmt: skip
"""Figures of each scene, by the names that sweeps have."""
Figures = dict[str, np.ndarray]
Fields = dict[int, tuple[np.ndarray, ...]]
"""Tractions (2, ny, nx), traction bound [force/area], and x and y of the element centres, by the
number of a scene."""


@dataclass(frozen=True, eq=False)
class InitialTractions:
    """Start of scenes, by their numbers: tractions divided by the bound (n, 2, ny, nx), and
    creepages (n, 2).
    """

    part: np.ndarray
    creepage: np.ndarray

    def on(
        self,
        problem: BatchedProblem,
        numbers: list[int],
        creepage: list[np.ndarray],
        step: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """First tractions of the problems with these numbers, and additions to the rigid shift of
        their creepages.
        """
        ny, nx, _ = problem.bound.shape
        part = np.moveaxis(self.part[numbers, :, :ny, :nx], 0, -1)
        if part.shape[1:] != problem.bound.shape:
            raise SceneError("start", part.shape[1:3], START)
        rigid = (self.creepage[numbers].T - creepage) * step
        rigid = np.where(np.isnan(problem.force), 0.0, rigid)
        return np.nan_to_num(part) * problem.bound, np.nan_to_num(rigid)


@one_blas_thread()
def march_batches(
    scenes: Sequence[Scene], tol: float, some: Sequence[int]
) -> tuple[Figures, np.ndarray]:
    """The figures (n, steps) of histories with equal numbers of steps, side by side; and which are
    solved in batches.

    Step k of all is a batch of shifts, less what the particles bring along from the tractions of
    the step before.
    """
    grids = {k: grid for k in some if (grid := _grid_of_history(scenes[k])) is not None}
    left = list(grids)
    before = None
    by_step = list[Figures]()
    for step in range(scenes[0].motion.steps):
        scenes_of_step: list[Scene] = list(scenes)
        for k in left:
            scenes_of_step[k] = scenes[k].step(step, grids[k])
        kept: Fields = {}
        figures, solved = on_grids(scenes_of_step, left, tol, kept, before=before)
        by_step.append(figures)
        left = np.flatnonzero(solved).tolist()
        before = kept
    return {name: np.stack([each[name] for each in by_step], axis=-1) for name in FIGURES}, solved


def _grid_of_history(scene: Scene[Transient]) -> Grid | None:
    """Grid of a history for batches; None for other scenes."""
    motion = scene.motion
    grid = scene.grid
    frictions = [scene.friction, *(each for each in motion.every("friction") if each is not None)]
    if motion.control is not None or motion.start is not None or motion.heights or scene.line:
        return None
    if not isinstance(grid, Grid) or not all(isinstance(each, float) for each in frictions):
        return None
    if grid.explicit:
        return grid
    try:
        grids = [PotentialContact.of(each).known for each in largest_contacts(scene)]
        return common_grid(scene, PotentialContact.of(scene), grids)
    except NoContact:  # which `solve` says of it
        return None


def on_grids(
    scenes: Sequence[Scene],
    some: Sequence[int],
    tol: float,
    kept: Fields | None = None,
    near: InitialTractions | None = None,
    before: Fields | None = None,
) -> tuple[Figures, np.ndarray]:
    """Figures of `some` scenes on their own grids, NaN for the others; and a mask of those that
    batches solved.
    """
    figures = {name: np.full(len(scenes), math.nan) for name in FIGURES}
    solved = np.zeros(len(scenes), bool)
    fitting = [k for k in some if fits(scenes[k])]
    groups = dict[_Kind, list[_Member]]()
    for number, hertz in zip(fitting, _contacts([scenes[k] for k in fitting]), strict=True):
        member = None if hertz is None else _member(number, scenes[number], hertz)
        if member is not None:
            groups.setdefault(member.kind, []).append(member)
    for members in groups.values():
        shape = np.max([each.shape for each in members], axis=0).tolist()
        elements = len(members) * math.prod(shape)
        size = math.ceil(len(members) / math.ceil(elements / BATCH_ELEMENTS))
        for first in range(0, len(members), size):
            part = members[first : first + size]
            of_part, part_solved = _solve_group(part, tol, kept, near, before)
            numbers = np.array([member.number for member in part])[part_solved]
            for name, values in of_part.items():
                figures[name][numbers] = values[part_solved]
            solved[numbers] = True
    return figures, solved


def power_supplied(figures: Figures) -> np.ndarray:
    """Energy supplied in steady rolling, all of which friction dissipates, per distance rolled."""
    return 0.0 - (
        figures["Fx"] * figures["vx"]
        + figures["Fy"] * figures["vy"]
        + figures["Mz"] * figures["spin"]
    )


# ----------------------------------------------------------------------------- scenes to problems


@dataclass(frozen=True)
class _Kind:
    """Properties that the scenes of a batch have in common.

    `shape`: the least powers of two, or three quarters of these, that hold their elements. `soft`:
    their grid, if that has softened edges. `ahead`: elements that particles pass in a step of a
    history. `under_law`: friction by the slip.
    """

    shape: tuple[int, ...]
    soft: Grid | None
    difference: str | None
    ahead: int
    line: bool
    under_law: bool


@dataclass(frozen=True, eq=False)
class _Member:
    number: int
    kind: _Kind
    shape: tuple[int, int]
    scene: Scene
    hertz: HertzContact


def fits(scene: Scene) -> bool:
    """True if a scene, on a grid, is of the kind that batches solve."""
    if type(scene.surface) not in (Ellipse, Paraboloids, Cylinders):
        return False
    if type(scene.bodies) is not Bodies or scene.bodies.coupled or not scene.bare:
        return False
    if scene.loaded or scene.own_grid.linear or not _friction_fits(scene.friction):
        return False
    motion = scene.motion
    if isinstance(motion, Steady):
        return motion.dq is None and motion.rigid_slip is None
    return isinstance(motion, Shift | TimeStep) and not scene.line


def leaves_grid(scene: Scene) -> bool:
    """True if a scene is one for batches that leaves its grid to the accuracy."""
    motion = scene.motion
    if scene.grid != "auto" or not fits(scene) or isinstance(scene.friction, Law):
        return False
    if isinstance(motion, Shift):
        return True
    return bool(motion == replace(motion, slip_difference="first-order", spin_offset=None))


def _friction_fits(friction: object) -> bool:
    if isinstance(friction, Law):
        return not friction.local and friction.memory_distance <= 0 and friction.kinetic != 0
    return type(friction) is float and 0 < friction < math.inf


def _contacts(scenes: list[Scene]) -> list[HertzContact | None]:
    """Hertz's contacts, vectorised for ellipses and paraboloids under a given force, one by one for
    others; None where a contact is not Hertz's.
    """
    contacts: list[HertzContact | None] = [None] * len(scenes)
    for kind in (Ellipse, Paraboloids):
        numbers = [
            k
            for k, scene in enumerate(scenes)
            if type(scene.surface) is kind and scene.normal_force
        ]
        if not numbers:
            continue
        columns = _columns_of_hertz([scenes[k] for k in numbers])
        for k, (a, b, approach, force, peak) in zip(numbers, columns, strict=True):
            contacts[k] = HertzContact(a, b, approach, force, peak, math.nan, math.nan)
    return [
        scene.hertz if contact is None else contact
        for scene, contact in zip(scenes, contacts, strict=True)
    ]


def _columns_of_hertz(scenes: list[Scene]) -> list[list[float]]:
    """Semi-axes, approach, force and largest pressure of each of scenes with one kind of
    surface.
    """
    bodies = [scene.bodies for scene in scenes]
    surfaces: list[Any] = [scene.surface for scene in scenes]
    force = np.array([scene.normal_force for scene in scenes], dtype=float)
    G = np.array([each.combined_G for each in bodies])
    nu = np.array([each.combined_nu for each in bodies])
    with np.errstate(all="ignore"):
        if isinstance(surfaces[0], Ellipse):
            a = np.array([surface.a for surface in surfaces])
            b = np.array([surface.b for surface in surfaces])
        else:
            Rx = np.array([surface.Rx for surface in surfaces])
            Ry = np.array([surface.Ry for surface in surfaces])
            a, b = semi_axes(Rx, Ry, G, nu, force)
        approach = approaches(a, b, G, nu, force)
        peak = 1.5 * force / (math.pi * a * b)
    columns: list[list[float]] = np.stack([a, b, approach, force, peak], axis=-1).tolist()
    return columns


def _member(number: int, scene: Scene, hertz: HertzContact) -> _Member | None:
    """Scene as a member of a batch, or None where its grid or its time step is not suitable."""
    grid = scene.own_grid
    motion = scene.motion
    shape = shape_with_margin(grid)
    most = MOST_IN_LINE if grid.line else MOST_ELEMENTS
    if math.prod(shape) > most:
        return None
    if grid.explicit and (grid.edge != "centres" or not _holds(grid, hertz)):
        return None
    ahead = 0.0
    if isinstance(motion, TimeStep):
        ahead = motion.direction * motion.dq / grid.sides[0]
        if abs(ahead - round(ahead)) > WHOLE_TOL or abs(ahead) > grid.nx:
            return None
    kind = _Kind(
        shape=tuple(_rounded_up(side) for side in shape),
        soft=grid if grid.edge == "softened" else None,
        difference=motion.slip_difference if isinstance(motion, Steady) else None,
        ahead=round(ahead),
        line=grid.line,
        under_law=isinstance(scene.friction, Law),
    )
    return _Member(number, kind, shape, scene, hertz)


def _rounded_up(side: int) -> int:
    """The least power of two, or three quarters of one, that is not below a number."""
    power = int(2 ** math.ceil(math.log2(side)))
    if side <= 3 * power // 4:
        return 3 * power // 4
    return power


@lru_cache(maxsize=16)
def _across_circle(grid: Grid) -> tuple[Grid, np.ndarray, np.ndarray]:
    """A grid across the unit circle, the parts of the load on its elements, and the compliance of
    those at the edge.
    """
    circle = HertzContact(1.0, math.inf if grid.line else 1.0, 0.0, 1.0, 1.0, 1.0, 1.0)
    half = 0.5 if grid.line else 1.0
    lattice = grid.spread((-1.0, 1.0, -half, half))
    pressure = circle.on_elements(lattice)
    return lattice, pressure / pressure.sum(), edge_compliance(circle.covered(*lattice.lines))


def _softened(grid: Grid | None) -> np.ndarray | None:
    """The compliance of elements at the edge, if these are softened."""
    if grid is None:
        return None
    return _across_circle(grid)[2]


def _elements(scene: Scene, hertz: HertzContact) -> tuple[np.ndarray, ...]:
    """Sides, x and y of the elements, and their parts of the load."""
    grid = scene.own_grid
    a = hertz.a
    b = hertz.b
    if not grid.explicit:
        lattice, share, _ = _across_circle(grid)
        scale = np.array([a, b])
        if grid.line:
            scale[1] = 0.0
        sides = np.where(scale > 0, lattice.sides * scale, 1.0)
        return sides, lattice.x * scale[0], lattice.y * scale[1], share
    share = hertz.on_elements(grid)
    return np.array(grid.sides), grid.x, grid.y, share / share.sum()


def _holds(grid: Grid, hertz: HertzContact) -> bool:
    """True where the contact lies within an explicit grid, and elements are not too large for
    it.
    """
    left, right, bottom, top = grid.box
    inside = left <= -hertz.a and hertz.a <= right
    if not grid.line:
        inside &= bottom <= -hertz.b and hertz.b <= top
    return inside and bool(hertz.on_elements(grid).any())


@dataclass(frozen=True, eq=False)
class _Arrays:
    """Scenes of like kinds as arrays over their elements (ny, nx, n), physical.

    `share`: part of the load on an element. `step`: distance rolled or 1, by which a creepage is
    the shift `W` (2, ny, nx, n). `prescribed`: Fx and Fy (2, n), NaN where they are not.
    """

    dx: np.ndarray
    dy: np.ndarray
    x: np.ndarray
    y: np.ndarray
    share: np.ndarray
    force: np.ndarray
    G: np.ndarray
    nu: np.ndarray
    step: np.ndarray
    creepage: np.ndarray
    prescribed: np.ndarray
    W: np.ndarray

    @property
    def area(self) -> np.ndarray:
        return self.dx * self.dy


def _lattices(members: list[_Member]) -> tuple[np.ndarray, ...]:
    """Sides, x and y of the elements of all members, and their parts of the load."""
    elements = [_elements(each.scene, each.hertz) for each in members]
    sides, x, y, share = map(side_by_side, zip(*elements, strict=True))
    return sides, x, y, share


def _arrays(members: list[_Member]) -> _Arrays:
    scenes = [each.scene for each in members]
    sides, x, y, share = _lattices(members)
    dx, dy = sides
    steps = [scene.motion.step(length) for scene, length in zip(scenes, dx.tolist(), strict=True)]
    step = np.array([each.dq or 1.0 for each in steps])
    creepage = np.array([each.rigid for each in steps]).T
    vx, vy, spin = creepage
    sampled = np.array([each.spin * each.spin_offset * each.direction * each.dq for each in steps])
    W = np.empty((2, *share.shape))
    W[0] = (vx - spin * y[:, None]) * step
    W[1] = (vy + spin * x + sampled) * step
    return _Arrays(
        dx=dx,
        dy=dy,
        x=x,
        y=y,
        share=share,
        force=np.array([each.hertz.force for each in members]),
        G=np.array([scene.bodies.combined_G for scene in scenes]),
        nu=np.array([scene.bodies.combined_nu for scene in scenes]),
        step=step,
        creepage=creepage,
        prescribed=np.array([[each.Fx, each.Fy] for each in steps], dtype=float).T,
        W=W,
    )


def _solve_group(
    members: list[_Member],
    tol: float,
    kept: Fields | None,
    near: InitialTractions | None,
    before: Fields | None,
) -> tuple[Figures, np.ndarray]:
    """The figures of scenes of like kinds, and a mask of those that are solved; `before` are the
    fields of the step before.
    """
    # the problem
    kind = members[0].kind
    arrays = _arrays(members)
    laws = [each.scene.friction for each in members]
    friction = np.array([law.static if isinstance(law, Law) else law for law in laws])
    bound = arrays.share * (friction * arrays.force / arrays.area)
    problem = BatchedProblem(
        arrays.dx,
        arrays.dy,
        arrays.nu,
        arrays.W,
        bound / arrays.G,
        arrays.prescribed / arrays.area / arrays.G,
        kind.difference,
        kind.line,
        _softened(kind.soft),
    )

    # its start, or the tractions of the step before
    numbers = [member.number for member in members]
    vx, vy, _ = arrays.creepage
    start = None
    if near is not None:
        start = near.on(problem, numbers, [vx, vy], arrays.step)
    if before is not None:
        carried = side_by_side([before[number][0] for number in numbers]) / arrays.G
        shift = arrays.W - shift_before(problem, carried, kind.ahead)
        arrays = replace(arrays, W=shift)
        problem = replace(problem, rigid_shift=shift)
        start = carried, np.zeros((2, len(members)))

    # its solution; numbers out of range do not converge
    with np.errstate(all="ignore"):
        if kind.under_law:
            solution, part = _under_laws(problem, laws, arrays.step, tol, start)
            bound *= part
        else:
            solution = solve_batch(problem, tol, start)
        figures = _figures(members, arrays, bound, solution)
    if kind.difference is not None:
        figures["friction_work"] = power_supplied(figures)
    solved = solution.converged & (figures["contact"] > 0)
    solved &= np.isfinite(figures["Fx"] + figures["Fy"])
    if kept is not None:
        traction = solution.traction * arrays.G
        for j in np.flatnonzero(solved).tolist():
            kept[members[j].number] = _fields(members[j].shape, j, traction, bound, arrays)
    return figures, solved


def _fields(
    shape: tuple[int, int], j: int, traction: np.ndarray, bound: np.ndarray, arrays: _Arrays
) -> tuple[np.ndarray, ...]:
    """Tractions, traction bound and places of the elements of scene j."""
    ny, nx = shape
    return traction[:, :ny, :nx, j], bound[:ny, :nx, j], arrays.x[:nx, j], arrays.y[:ny, j]


def _figures(
    members: list[_Member], arrays: _Arrays, bound: np.ndarray, solution: BatchedSolution
) -> Figures:
    traction = solution.traction * arrays.G
    area = arrays.area
    Fx, Fy = traction.sum(axis=(1, 2)) * area
    Mz = (arrays.x * traction[1] - arrays.y[:, None] * traction[0]).sum(axis=(0, 1)) * area
    rigid = np.where(np.isnan(arrays.prescribed), 0.0, solution.rigid)
    slip = np.hypot(*(arrays.W + rigid[:, None, None]))
    work = (bound * slip).sum(axis=(0, 1)) * area
    contact = (bound > 0).sum(axis=(0, 1))
    slipping = (solution.slip > 0).sum(axis=(0, 1))
    counts = {"contact": contact, "stick": contact - slipping, "slip": slipping}
    vx, vy, spin = arrays.creepage
    return {
        "Fx": Fx,
        "Fy": Fy,
        "Mz": Mz,
        "vx": vx + rigid[0] / arrays.step,
        "vy": vy + rigid[1] / arrays.step,
        "spin": spin,
        "max_pressure": arrays.share.max(axis=(0, 1)) * arrays.force / area,
        "friction_work": solution.dissipated * arrays.G * area,
        "normal_force": arrays.force,
        "approach": np.array([each.hertz.approach for each in members]),
        "gap": solution.relative_gap * work,
        "relative_gap": solution.relative_gap,
        "residual": solution.residual,
        **counts,
        **{f"{name}_area": count * area for name, count in counts.items()},
        "iterations": solution.iterations,
    }


def _under_laws(
    problem: BatchedProblem,
    laws: list[Any],
    step: np.ndarray,
    tol: float,
    start: tuple[np.ndarray, np.ndarray] | None,
) -> tuple[BatchedSolution, np.ndarray]:
    """Passes from the static coefficients of laws, each with those of the slip before; and parts
    of the static ones at the end. `step` is the shift of unit slip.

    See `friction_law`, which solves those that do not converge.
    """
    solution = BatchedSolution.unsolved(problem)
    part = np.ones_like(problem.bound)
    left = np.arange(len(laws))
    for _ in range(PASSES_MAX):
        # tractions under the coefficients of the pass before
        of_left = problem.of(left)
        static_bound = of_left.bound
        iterate = solve_batch(replace(of_left, bound=static_bound * part[..., left]), tol, start)

        # the coefficients of their slip
        own = [laws[k](iterate.slip[..., j] / step[k]) / laws[k].static for j, k in enumerate(left)]
        change = np.where(iterate.slip > 0, np.stack(own, axis=-1) - part[..., left], 0.0)
        excess = np.abs(change * static_bound).max(axis=(0, 1))
        residual = excess / np.hypot(*iterate.traction).max(axis=(0, 1))
        judged = replace(
            iterate,
            residual=np.fmax(iterate.residual, residual),
            converged=iterate.converged & (residual <= tol),
        )
        solution.put(left, judged)

        # those that go on
        goes_on = iterate.converged & (residual > tol)
        left = left[goes_on]
        if not left.size:
            break
        part[..., left] += change[..., goes_on]
        start = iterate.traction[..., goes_on], iterate.rigid[:, goes_on]
    return solution, part
