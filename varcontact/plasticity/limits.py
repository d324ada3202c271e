"""Shakedown limits of rolling contacts, bounded from both sides."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import NotConverged, SceneError
from varcontact.plasticity.balls import Families, Mechanism, families, mechanisms
from varcontact.plasticity.flow_mesh import flow_mesh
from varcontact.plasticity.koiter import FlowField, upper_bound
from varcontact.plasticity.line_contact import LineLimit, line_limit, line_passage, with_proof
from varcontact.plasticity.melan import LowerBound, lower_bound
from varcontact.plasticity.passage import (
    ElasticStress,
    Passage,
    Strength,
    passage,
    yield_strength,
)
from varcontact.plasticity.point_proof import PointProof
from varcontact.plasticity.residual_stress import CellResidual, ResidualSpace
from varcontact.plasticity.shakedown_result import Hardening, Mode, Section, Shakedown
from varcontact.results.solution import Solution
from varcontact.results.stress import Body, Patch, body_names, side_of, solution_of
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.system.progress import Progress

HARDENING = ("none", "kinematic")

ELEMENTS_OF_FAMILIES = 16
"""Samples across the contact for closed forms: coarser grids are divided."""
ELEMENTS = (24, 48)
"""Samples across the contact for programs, tried in turn until the gap is closed. With fewer gaps
are larger by 1 % (of the limit), except where the surface slides."""
NET_STRAIN = 0.3
"""Net divided by total plastic strain of a passage above which a mechanism is ratchetting."""
SURFACE = 0.05
"""Depth in half-widths to which flow is that of the surface."""
SPLINES = (14, 5, 16)
"""Intervals of residual stresses: across the contact, beside it, in depth."""
FINER_SPLINES = (20, 6, 20)
MESHES = ((9, 4, 10), (18, 4, 14))
"""Rectangles of the velocity meshes: across the contact, beside it, in depth."""
ERROR_DEPTH = 1.5
"""Depth of the section for the error of the field, divided by that of alternating plasticity, at
least a half-width."""
MOSTLY = 0.5
"""Share of the dissipation at the surface above which surface sliding gives the limit: velocities
below it and finer stresses do not improve the bounds."""
SAME_LIMIT = 1e-3
"""Relative difference below which two limits are equal."""
SLENDER = 6.0
"""Depth of the section in half-widths above which three more intervals in depth are used."""


@checks.named_options()
def shakedown(
    solution: Solution | Patch,
    k: Any,
    body: Body = "lower",
    *,
    hardening: Hardening = "none",
    gap: float | None = 0.02,
    elastic: ElasticStress | None = None,
    progress: Progress = None,
) -> Shakedown:
    """Bounds on the shakedown limit of a contact that rolls over the same track again and again.

    Parameters
    ----------
    solution : Solution or PatchSolution
        Solution of steady rolling, or without friction.
    k : float, pair of array_like, or callable
        Yield stress in shear [force/area]: a number, depths and values between which it is linear,
        or a function of depths.
    body : 1, 2, "upper" or "lower"
        Body; under a wheel "rail" or "wheel".
    hardening : {"none", "kinematic"}
        Perfect plasticity, or unlimited kinematic hardening, whose limit needs no program.
    gap : float or None
        Relative distance of the bounds at which the search ends. None: closed forms alone, an
        upper bound and the kinematic limit in about a second.
    elastic : callable, optional
        Elastic stress (3, 3, ...) at points (3, ...), in the scene's axes and at the solution's
        load, in place of that of the solution's tractions.
    progress : callable or true, optional
        Called with what is solved next.

    Returns
    -------
    Shakedown

    Raises
    ------
    SceneError
        For solutions without contact, under infinite friction, of a shift or a step in time; a
        yield stress that is not positive, or less than 1e-3 of the peak pressure; bodies whose
        stresses are not known.
    NotConverged
        For solutions that have not converged.

    Notes
    -----
    The body is a half-space (or layered) of von Mises material under one load that passes
    infinitely often. The factor scales tractions, and leaves the contact area as it is.

    All bounds are those of the field of the grid's tractions, linear between the centres of
    elements; `field_error` estimates how far this is from the exact one. For this field `lower` is
    a theorem where `proved`, else what lies between samples is estimated. `upper` is a theorem,
    but for velocities (`mechanism`) in layers and in an own field, where the quadrature of their
    work is estimated. See docs/shakedown.md.

    Examples
    --------
    A line contact without friction shakes down up to p0 = 4 k (Johnson 1962).

    >>> import varcontact as vc
    >>> scene = vc.Scene(bodies=vc.Bodies(G=82e3, nu=0.3), surface=vc.Cylinders(R=100.0),
    ...                  normal_force=1000.0, grid=vc.Grid(nx=200))
    >>> limit = vc.shakedown(vc.solve(scene), k=300.0)
    >>> print(f"{limit.upper * limit.peak_pressure / 300.0:.2f}, {limit.mode}")
    4.00, alternating plasticity
    """
    side = side_of(body_of(body, solution), body_names(solution))
    answer = solution_of(solution)
    checks.choice("hardening", hardening, HARDENING)
    report = checks.progress(progress)
    if gap is not None:
        gap = checks.positive("gap", gap)
    if elastic is not None and not callable(elastic):
        raise SceneError("elastic", elastic, "a function of points (3, ...), or left out")
    check_solution(answer)
    peak = float(answer.pressure.max())
    strength = yield_strength(k, peak)
    if answer.grid.line:
        return _of_line(answer, side, strength, hardening, elastic)
    return _of_point(LimitSearch(answer, side, strength, hardening, gap, elastic, report))


def body_of(body: Any, solution: Any) -> Any:
    """The body, "lower" of a patch being the rail: tractions of patches act on it."""
    if body == "lower" and hasattr(solution, "body_names"):
        return body_names(solution)[0]
    return body


def check_solution(solution: Solution) -> None:
    """Refuse solutions that have no limit, or none that can be believed."""
    if not solution.pressure.any():
        raise SceneError("solution", solution, "with contact: else nothing is stressed")
    motion = solution.motion
    if motion is not None and not isinstance(motion, Steady):
        raise SceneError("motion", motion, "Steady, or none: the load has to roll along x")
    if solution.scene.loaded:
        allowed = "left out: the load is that of the contact"
        for field in ("displacements", "loads"):
            beside = getattr(solution.scene, field)
            if beside is not None:
                raise SceneError(field, beside, allowed)
    infinite = [f for f in solution.scene.frictions if isinstance(f, float) and math.isinf(f)]
    if infinite and motion is not None:
        raise SceneError(
            "friction", math.inf, "finite: tractions at the edge of the contact grow with the grid"
        )
    if not solution.converged:
        certificate = solution.certificate
        raise NotConverged(
            "the solution has not converged, its shakedown limit would mean nothing",
            float(certificate.residual),
            solution,
        )


@dataclass(frozen=True)
class LimitSearch:
    """Inputs of the search for the shakedown limit of a point contact."""

    solution: Solution
    side: int
    strength: Strength
    hardening: Hardening
    gap: float | None
    elastic: ElasticStress | None
    report: Callable[[str], None]


# ----------------------------------------------------------------------------- line contact


def _of_line(
    solution: Solution,
    side: int,
    strength: Strength,
    hardening: Hardening,
    elastic: ElasticStress | None,
) -> Shakedown:
    """The limit by depth; field_error by half the strips."""
    line = line_passage(solution, side, elastic)
    limit = with_proof(line, strength, line_limit(line, strength, hardening))
    kinematic = limit
    if hardening == "none":
        kinematic = with_proof(line, strength, line_limit(line, strength, "kinematic"))
    error = math.nan
    if elastic is None:
        half = line_passage(of_half_the_elements(solution), side)
        error = abs(line_limit(half, strength, hardening).upper / limit.upper - 1)
    k = strength(limit.depths)
    residual = tensor_of(-limit.lower * limit.centres * k[:, None])
    return Shakedown(
        lower=limit.lower,
        upper=limit.upper,
        sampled=limit.sampled,
        proved=limit.proved,
        elastic=limit.elastic,
        kinematic=(kinematic.lower, kinematic.upper),
        mode=_mode_of_line(limit, kinematic, line.unit),
        place=0.0,
        depth=limit.depth,
        flow=limit.net,
        field_error=error,
        hardening=hardening,
        section=Section(np.zeros(1), limit.depths, residual[..., None]),
        mechanism=None,
        critical=limit.critical,
        centre=limit.centre,
        **_of_load(solution, strength, limit.depths),
    )


def _mode_of_line(limit: LineLimit, kinematic: LineLimit, unit: float) -> Mode:
    """Alternating plasticity where hardening does not help; else the mode from the net strain."""
    if kinematic.upper < (1 + SAME_LIMIT) * limit.upper:
        return "alternating plasticity"
    return _mode(float(np.hypot(*limit.net)), limit.depth / unit)


def _mode(net: float, depth: float) -> Mode:
    """Failure mode from the net share of the plastic strain and the depth [half-widths]."""
    if net <= NET_STRAIN:
        return "alternating plasticity"
    if depth <= SURFACE:
        return "surface flow"
    return "subsurface ratchetting"


def _of_load(solution: Solution, strength: Strength, depths: np.ndarray) -> dict[str, Any]:
    """Peak pressure, least yield stress, and largest traction divided by the peak pressure."""
    peak = float(solution.pressure.max())
    return {
        "peak_pressure": peak,
        "strength": float(strength(depths).min()),
        "local": float(np.hypot(*solution.traction).max()) / peak,
    }


def of_half_the_elements(solution: Solution) -> Solution:
    """The solution with tractions averaged over pairs of elements either way."""
    grid = solution.grid
    along_y = 2
    if grid.line:
        along_y = 1
    pressure = _averaged(solution.pressure, along_y)
    dx, dy = grid.sides
    coarse = Grid(nx=pressure.shape[1], dx=2 * dx, x0=float(grid.x[0] - dx / 2))
    if not grid.line:
        x0 = float(grid.x[0] - dx / 2)
        y0 = float(grid.y[0] - dy / 2)
        count_y, count_x = pressure.shape
        coarse = Grid(nx=count_x, ny=count_y, dx=2 * dx, dy=2 * dy, x0=x0, y0=y0)
    traction = _averaged(solution.traction, along_y)
    return replace(solution, pressure=pressure, traction=traction, grid=coarse)


def _averaged(values: np.ndarray, along_y: int) -> np.ndarray:
    """Means over blocks of (along_y, 2) elements, filled with zeros."""
    ny, nx = values.shape[-2:]
    padding = [(0, 0)] * (values.ndim - 2) + [(0, -ny % along_y), (0, -nx % 2)]
    wide = np.pad(values, padding)
    blocks = wide.reshape(*wide.shape[:-2], wide.shape[-2] // along_y, along_y, -1, 2)
    return blocks.mean(axis=(-3, -1))


def tensor_of(deviator: np.ndarray) -> np.ndarray:
    """Stress deviators (3, 3, ...) of five coordinates (..., 5)."""
    first, second, xy, xz, yz = np.moveaxis(deviator, -1, 0)
    xx = 2 * second / np.sqrt(3)
    yy = first - xx / 2
    zz = -first - xx / 2
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


# ----------------------------------------------------------------------------- point contact


def _of_point(search: LimitSearch) -> Shakedown:
    """Limit of a point contact: bounds in closed form, then by programs until the gap is closed."""
    search.report("stresses below the surface, and bounds of closed form")
    across = _elements_across(search.solution)
    coarse = _passage(search, _parts(ELEMENTS_OF_FAMILIES, across))
    closed = families(coarse)
    error = math.nan
    if search.elastic is None:
        half = replace(search, solution=of_half_the_elements(search.solution))
        deepest = ERROR_DEPTH * max(closed.alternating.place[1], 1.0)
        alone = _passage(half, _parts(ELEMENTS_OF_FAMILIES, across / 2), deepest)
        alternating, surface, _ = mechanisms(alone)
        change = _least(alternating, surface, search).factor
        error = abs(change / _least(closed.alternating, closed.surface, search).factor - 1)
    found = _Found.closed(closed, coarse, search)
    if search.gap is not None:
        found = _within(search.gap, found, search)
    passage = found.passage
    kinematic = found.families.kinematic, found.families.alternating.factor
    return Shakedown(
        lower=found.lower,
        upper=found.upper,
        sampled=found.sampled,
        proved=search.gap is not None and passage.field is not None,
        elastic=found.families.elastic,
        kinematic=kinematic,
        mode=found.mode,
        place=found.place[0] * passage.unit,
        depth=found.place[1] * passage.unit,
        flow=found.net,
        field_error=error,
        hardening=search.hardening,
        section=found.section(search.strength),
        mechanism=found.mechanism,
        critical=found.critical.critical,
        centre=found.critical.centre,
        **_of_load(search.solution, search.strength, passage.depth * passage.unit),
    )


def _within(gap: float, found: _Found, search: LimitSearch) -> _Found:
    """Bounds with this gap, proved between samples; computed again with more samples if they are
    too far apart.
    """
    if found.gap <= gap:
        found = _proved(found, search, gap)
    across = _elements_across(search.solution)
    parts = sorted({_parts(most, across) for most in ELEMENTS})
    for each in parts:
        if found.gap <= gap:
            break
        passage = found.passage
        closed = found.families
        if each != passage.parts:
            passage = _passage(search, each)
            closed = families(passage)
        found = _Found.closed(closed, passage, search)
        last = each == parts[-1]
        if search.hardening == "none":
            found = _by_programs(found, search, gap, last)
        if last or found.sampled >= (1 - gap) * found.upper:
            found = _proved(found, search, gap)
    return found


def _elements_across(solution: Solution) -> float:
    """Elements across the contact along x or y, whichever are fewer."""
    rows, columns = np.nonzero(solution.pressure > 0)
    return float(min(np.ptp(rows), np.ptp(columns)) + 1)


def _parts(most: int, across: float) -> int:
    """Parts of an element that give about `most` samples across the contact."""
    return max(1, round(most / across))


def _passage(search: LimitSearch, parts: int, deepest: float = math.inf) -> Passage:
    """Passage with `parts` samples to an element; only one half of a symmetric one."""
    whole = passage(
        search.solution, search.side, search.strength,
        refined=parts, elastic=search.elastic, deepest=deepest,
    )  # fmt: skip
    if whole.symmetric:
        return whole.half()
    return whole


def _least(alternating: Mechanism, surface: Mechanism, search: LimitSearch) -> Mechanism:
    """The lower of the two upper bounds in closed form; with kinematic hardening that of
    alternating plasticity.
    """
    if search.hardening == "kinematic" or alternating.factor < surface.factor:
        return alternating
    return surface


@dataclass(frozen=True, eq=False)
class _Found:
    """The best bounds so far."""

    passage: Passage
    families: Families
    lower: float
    sampled: float
    upper: float
    place: tuple[float, float]
    net: np.ndarray
    critical: Mechanism
    residual: np.ndarray
    by_cell: CellResidual
    utilised: np.ndarray | None = None
    mechanism: FlowField | None = None

    @classmethod
    def closed(cls, closed: Families, passage: Passage, search: LimitSearch) -> _Found:
        """Bounds of closed form."""
        least = _least(closed.alternating, closed.surface, search)
        lower = closed.axial
        sampled = closed.axial_sampled
        stress = closed.axial_stress
        if search.hardening == "kinematic":
            lower = closed.kinematic
            sampled = closed.kinematic_sampled
            stress = closed.back_stress
        residual = tensor_of(stress * passage.strength[:, None, None])
        if search.hardening == "none":
            # rho_xx alone, not its deviator
            axial = np.zeros_like(residual)
            axial[0, 0] = 1.5 * residual[0, 0]
            residual = axial
        free = stress * passage.strength[:, None, None]
        return cls(
            passage=passage,
            families=closed,
            lower=lower,
            sampled=sampled,
            upper=least.factor,
            place=least.place,
            net=least.net,
            critical=least,
            residual=residual,
            by_cell=CellResidual(passage.y, passage.depth, free),
        )

    @property
    def gap(self) -> float:
        return 1 - self.lower / self.upper

    @property
    def mode(self) -> Mode:
        """Failure mode, from the ratchetting strain of the mechanism if there is one: the
        velocities of a section may turn, so that their net strain says less.
        """
        if self.mechanism is None:
            return _mode(float(np.hypot(*self.net)), self.place[1])
        return _mode(self.mechanism.ratchet, self.place[1])

    def with_lower(self, bound: LowerBound) -> _Found:
        """Bounds with this lower bound, if it is better."""
        found = replace(self, sampled=max(self.sampled, bound.sampled))
        if bound.factor <= self.lower:
            return found
        return replace(
            found,
            lower=bound.factor,
            residual=bound.residual,
            by_cell=bound.by_cell,
            utilised=bound.largest,
        )

    def with_upper(self, flow: FlowField | None) -> _Found:
        """Bounds with this upper bound, if it is better."""
        if flow is None or flow.factor >= self.upper:
            return self
        net = flow.net.copy()
        if self.passage.symmetric:  # the flow in the other half is mirrored
            net[1] = 0.0
        return replace(self, upper=flow.factor, place=flow.place, net=net, mechanism=flow)

    def ended(self, gap: float) -> bool:
        """True where the gap is closed, or would be but for the proof between samples."""
        return self.gap <= gap or self.sampled > (1 - gap / 4) * self.upper

    def section(self, strength: Strength) -> Section:
        """The residual stress in the whole section, in the scene's units."""
        passage = self.passage
        y = passage.y
        stress = self.residual
        utilised = self.utilised
        if passage.symmetric:
            signs = np.array([1.0, -1.0, 1.0])
            mirrored = stress * (signs[:, None] * signs)[:, :, None, None]
            right = y > -1e-9
            left = y > 1e-9
            y = np.concatenate([-y[left][::-1], y[right]])
            stress = np.concatenate([mirrored[..., left][..., ::-1], stress[..., right]], axis=-1)
            if utilised is not None:
                utilised = np.concatenate([utilised[:, left][:, ::-1], utilised[:, right]], axis=1)
        depth = passage.depth * passage.unit
        least = float(strength(depth).min())
        return Section(y * passage.unit, depth, stress * least, utilised)


def _by_programs(found: _Found, search: LimitSearch, gap: float, last: bool) -> _Found:
    """Bounds by programs, until the gap is closed: residual stresses; with the `last` samples, and
    where the surface does not slide alone, velocities on two meshes, and finer residual stresses.
    """
    by_least = _by_least(found.passage, search.strength)
    margins = None
    if found.passage.field is not None:
        margins = PointProof.of(found.passage, found.by_cell, by_least, 1.0).surface_margins()
    bound = _with_stresses(found, SPLINES, search, gap, margins)
    found = found.with_lower(bound)
    if bound.at_surface > MOSTLY or not last:
        return found
    for sizes in MESHES:
        if not found.ended(gap):
            mesh = flow_mesh(found.passage, *sizes)
            found = found.with_upper(upper_bound(found.passage, mesh, by_least, search.report))
    if not found.ended(gap):
        found = found.with_lower(_with_stresses(found, FINER_SPLINES, search, gap, margins))
    return found


def _by_least(passage: Passage, strength: Strength) -> Strength:
    """Function of depth in half-widths: yield stress divided by its least value."""
    least = float(strength(passage.depth * passage.unit).min())

    def by_least(depth: np.ndarray) -> np.ndarray:
        return strength(depth * passage.unit) / least

    return by_least


def _proved(found: _Found, search: LimitSearch, gap: float) -> _Found:
    """Bounds whose lower one holds between samples, too, if the field has a closed form."""
    if found.passage.field is None:
        return found
    search.report("proof of the lower bound between samples")
    factor = found.lower
    by_least = _by_least(found.passage, search.strength)
    proof = PointProof.of(found.passage, found.by_cell, by_least, factor)
    radius = proof.radius(factor / ((1 - gap) * found.upper))
    found = replace(found, lower=factor / radius, residual=found.residual / radius)
    if search.hardening == "kinematic":
        families = replace(found.families, kinematic=found.lower)
        found = replace(found, families=families)
    return found


def _with_stresses(
    found: _Found,
    sizes: tuple[int, int, int],
    search: LimitSearch,
    gap: float,
    margins: np.ndarray | None,
) -> LowerBound:
    """Lower bound by residual stresses with given numbers of splines."""
    across, beside, down = sizes
    if found.passage.depth[-1] > SLENDER:
        down += 3
    space = ResidualSpace.around(found.passage, across, beside, down)
    enough = (1 - gap) * found.upper
    return lower_bound(found.passage, space, enough, search.report, margins)
