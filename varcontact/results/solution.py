"""The answer: fields in physical units, forces, areas, and the certificate."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.discrete.certificate import Certificate
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.stick_slip import EXTERIOR, SLIP, STICK, unit_slip
from varcontact.html import html_table
from varcontact.planning.plan import Plan
from varcontact.results.delivered import Delivered
from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.refinement import Refinement
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Motion, Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.solvers.statistics import Calls

if TYPE_CHECKING:
    from varcontact.results.normalised import Normalised

ROUNDING = 1e-9
"""Part of the power from which on negative densities are more than rounding and tolerance."""


@dataclass(frozen=True, eq=False)
class Solution(Delivered):
    """A solved scene, in the scene's units. Arrays are indexed [iy, ix].

    Attributes
    ----------
    scene : Scene
    grid : Grid
        The potential contact, explicit.
    plan : Plan
        The methods used, and why.
    pressure : ndarray, shape (ny, nx)
        Normal traction, compression positive [force/area].
    traction : ndarray, shape (2, ny, nx)
        Tangential traction on body 1, x and y [force/area].
    slip : ndarray, shape (2, ny, nx)
        Relative slip of body 1 over body 2 in the contact: slip velocity by rolling velocity [-] in rolling, the
        local shift [length] in a shift (also in a step of a history that does not roll); zero outside.
    power_density : ndarray, shape (ny, nx)
        Work lost by friction by area; by distance rolled [force/area], in a shift [force/length]. In rolling it is that
        of the tractions and the slip at an element in the mean over a step (docs/theory.md), and is negative on
        elements where the grid is too coarse, see `negative_work`. NaN in a file of an earlier version that has none.
    distance : ndarray, shape (ny, nx)
        Deformed distance at the elements' centres [length]. Where elements bear mean pressures, see `Grid`, it is not
        quite zero in the contact.
    state : int8 ndarray, shape (ny, nx)
        0 exterior, 1 stick, 2 slip.
    approach : float
        Approach of the bodies [length]; NaN in line contact without a reference depth.
    creepage : tuple of float
        (vx, vy, spin); of a shift (ux, uy, rotation). NaN where a force is prescribed in line contact without a
        reference depth, in a shift or in a step of a history that changes the force; and without contact.
    certificate : Certificate
    converged : bool
        Whether the tolerance was reached.
    iterations : dict
        Solver iterations by problem.
    status : dict
        The solvers' own words, by problem.
    solved_by : dict
        The solver whose answer it is, by problem: not that of the plan, where active sets polished its answer or
        another had to be asked.
    calls : dict of dict of Calls
        By problem ("normal", "tangential"; "joint" for both in one program, "grid" before an automatic grid was found)
        and by solver: how often it was called, polish, fallback and safeguards included, its iterations and seconds.
    timing : dict
        Seconds by stage, and in total.
    passes : tuple of (float, float)
        Of each pass of a coupling loop: how much it changed (of the tractions, or of the pressure in a joint pass),
        and the residual of the whole after it. Under a law of friction, of each pass of that: how much it changed of
        the coefficients.
    branch : str
        Under a law of friction, which has several solutions at times: where the search began, "stick" or "slip" all
        over, a "solution", or what the particles did before in a "history"; empty without a law.
    note : str
        Of a solution from a file: what there is to know about its certificate, see `varcontact.load`; empty where that
        was measured again and found to be what its fields deserve.
    warnings : tuple of str
        What is wrong with the scene rather than with the solution: noise of a sampled surface that rules the pressure.
    error_estimate : ErrorEstimate or None
        Of a solution to an accuracy, within a time, or corrected: how far its forces are from the continuum, about.
        They are then those of the estimate, and not what the elements carry; the fields are those of the grid.
    pressure_on_parts : ndarray, shape (ny rows, nx columns), or None
        Where elements at the edge count in part, see `Grid`, and the pressure is not Hertz's closed form: the pressure
        on equal parts of the elements, on which it was solved for [force/area]. The elements bear the means.
    refinement : Refinement or None
        Where `solve` was told to `refine`: the field on parts of the elements that has these forces. The fields here
        and the certificate are then those of the corrected problem on the elements.
    weakening : ndarray, shape (ny, nx), or None
        In a history under a law of friction: the part of ``static - kinetic`` that the particles in an element have
        lost by slip [-], from 0 to 1; the next step goes on from it.
    """

    scene: Scene
    grid: Grid
    plan: Plan
    pressure: np.ndarray
    traction: np.ndarray
    slip: np.ndarray
    power_density: np.ndarray
    distance: np.ndarray
    state: np.ndarray
    approach: float
    creepage: tuple[float, float, float]
    certificate: Certificate
    converged: bool
    iterations: dict[str, int]
    status: dict[str, str]
    timing: dict[str, float]
    passes: tuple[tuple[float, float], ...] = ()
    branch: str = ""
    solved_by: dict[str, str] = field(default_factory=dict)
    calls: dict[str, dict[str, Calls]] = field(default_factory=dict)
    note: str = ""
    warnings: tuple[str, ...] = ()
    error_estimate: ErrorEstimate | None = None
    refinement: Refinement | None = None
    pressure_on_parts: np.ndarray | None = None
    weakening: np.ndarray | None = None

    @property
    def normal_force(self) -> float:
        """Total compressive force, by `error_estimate`, where it has one; in line contact all forces are by length."""
        return self._extrapolated("normal_force", self.pressure.sum() * self.grid.area)

    @property
    def force(self) -> np.ndarray:
        """Total tangential force (Fx, Fy) on body 1 (116); by `error_estimate`, where there is one."""
        carried = self.traction.sum(axis=(1, 2)) * self.grid.area
        return np.array([self._extrapolated(name, F) for name, F in zip(("Fx", "Fy"), carried, strict=True)])

    @property
    def moment(self) -> float:
        """Twisting moment Mz on body 1 about the origin (117); by `error_estimate`, where there is one.

        NaN by a theory that has none (Polach's), and so is its power, wherever there is spin.
        """
        if not self.plan.has_moment:
            return np.nan
        x, y = self.grid.x[None, :], self.grid.y[:, None]
        return self._extrapolated("Mz", np.sum(x * self.traction[1] - y * self.traction[0]) * self.grid.area)

    def _extrapolated(self, name: str, value: float) -> float:
        """A value by the estimate of its error, where that has it."""
        known = {} if self.error_estimate is None else self.error_estimate.values
        return float(known.get(name, value))

    @property
    def friction(self) -> np.ndarray | None:
        """Coefficient that the scene's law of friction has at this slip, (ny, nx); None without a law."""
        law = self.scene.friction
        if not isinstance(law, Law):
            return None
        return np.where(self.state == SLIP, law(np.hypot(*self.slip)), law.static)

    @property
    def Fx(self) -> float:
        """Tangential force on body 1 along x; in line contact per unit length."""
        return float(self.force[0])

    @property
    def Fy(self) -> float:
        """Tangential force on body 1 along y."""
        return float(self.force[1])

    @property
    def Mz(self) -> float:
        """Twisting moment on body 1 about the origin: `moment`."""
        return self.moment

    @property
    def vx(self) -> float:
        """Longitudinal creepage, prescribed or found; of a shift ux [length]."""
        return self.creepage[0]

    @property
    def vy(self) -> float:
        """Lateral creepage, prescribed or found; of a shift uy [length]."""
        return self.creepage[1]

    @property
    def spin(self) -> float:
        """Spin creepage [1/length]; of a shift the rotation."""
        return self.creepage[2]

    @property
    def max_pressure(self) -> float:
        """Largest pressure of an element, or mean over one, see `Grid`; by `error_estimate`, where there is one."""
        return self._extrapolated("peak_pressure", self.pressure.max())

    @property
    def normalised(self) -> Normalised:
        """Forces, creepages and the largest pressure without dimension, see `Normalised`.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
        ...     friction=0.33, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=12, ny=12))
        >>> part = vc.solve(scene).normalised
        >>> print(f"Fx = {part.Fx:.3f} at vx = {part.vx:.3f}; largest pressure {part.max_pressure:.2f}")
        Fx = -0.392 at vx = 0.095; largest pressure 1.48
        """
        from varcontact.results.normalised import normalised

        return normalised(self)

    @property
    def traction_bound(self) -> np.ndarray:
        """g = f pz, shape (ny, nx); infinite in the contact where nothing slips."""
        bound, contact = np.zeros(self.grid.shape), self.pressure > 0
        friction = self.scene.friction if self.friction is None else self.friction
        if friction is not None:
            bound[contact] = np.broadcast_to(np.asarray(friction), bound.shape)[contact] * self.pressure[contact]
        return bound if self.refinement is None else bound * self.refinement.share

    @property
    def elements(self) -> dict[str, int]:
        """Numbers of elements: contact, stick, slip."""
        stick, slip = int(np.sum(self.state == STICK)), int(np.sum(self.state == SLIP))
        return {"contact": stick + slip, "stick": stick, "slip": slip}

    @property
    def areas(self) -> dict[str, float]:
        """Areas of contact, stick and slip, of whole elements; in line contact per unit length: widths."""
        return {name: count * self.grid.area for name, count in self.elements.items()}

    @property
    def contact(self) -> tuple[Grid, np.ndarray]:
        """Where there is contact, as exactly as the pressure is known: a grid, and bool (ny, nx) on it.

        It is the grid of the elements, or that of their parts where the pressure was solved for on these.
        """
        if self.pressure_on_parts is None:
            return self.grid, self.state != EXTERIOR
        (rows, columns), (ny, nx) = self.pressure_on_parts.shape, self.grid.shape
        return self.grid.divided((rows // ny, columns // nx)), self.pressure_on_parts > 0

    @property
    def motion(self) -> Motion | None:
        """How the bodies move: the scene's motion."""
        assert not isinstance(self.scene.motion, Transient)
        return self.scene.motion

    @property
    def friction_work(self) -> float:
        """Work lost by friction, integral of `power_density`: by distance rolled [force], in a shift [force length].

        In steady rolling that is `power`, to rounding; by `error_estimate`, where there is one; of a `refinement` that
        of its field. In a step of rolling it is the work put in less the change of the elastic energy. In place it is
        exact as long as all that slips goes on in its direction.
        """
        if self.error_estimate is not None and self.refinement is None and isinstance(self.motion, Steady):
            return self.power
        return float(self.power_density.sum() * self.grid.area)

    @property
    def negative_work(self) -> float:
        """Sum of the negative values of `power_density` by that of all [-], zero or negative: an error of the grid."""
        negative = float(self.power_density[self.power_density < 0].sum())
        if negative == 0 or abs(negative) * self.grid.area < ROUNDING * abs(self.power):  # where nothing slips
            return 0.0
        return negative / abs(float(self.power_density.sum()))

    @property
    def power(self) -> float:
        """Work that the rolling motion puts into the contact, by distance rolled [force]; in a shift [force length].

        ``-(Fx vx + Fy vy + Mz spin)``, and for unlike bodies the work of their pressure in addition: tractions move it
        forward, and it resists rolling. In steady rolling friction loses all of it. A shift, and a step of a history,
        also change the elastic energy.

        Examples
        --------
        >>> import varcontact as vc
        >>> for cells in (12, 24):
        ...     scene = vc.Scene(
        ...         bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, friction=0.3,
        ...         motion=vc.Steady(vx=0.05), grid=vc.Grid(nx=cells, ny=cells))
        ...     sol = vc.solve(scene)
        ...     print(f"{sol.power:.5f} {sol.friction_work:.5f}")
        0.00880 0.00880
        0.00858 0.00858
        """
        loads, motion = np.array([*self.force, self.moment]), np.array(self.creepage)
        moved = (loads != 0) & (motion != 0)  # what is NaN of one has no power where the other is zero
        return self._rolling_resistance() - float(loads[moved] @ motion[moved])

    def _rolling_resistance(self) -> float:
        """Work of the pressure on what tractions do to the distance [force]: by Betti that of tractions on its slip."""
        rolls = 0 if self.motion is None else self.motion.rolls
        if rolls == 0 or self.scene.bodies.K == 0 or self.plan.left_out or not self.traction.any():
            return 0.0
        disc = discretise(self.scene, self.grid)
        operator, pressure = (
            disc.operators.pressure_to_shift(disc.step, disc.loading.slip_difference),
            self.pressure[None],
        )
        twice = operator.apply(pressure) + operator.apply(pressure[..., ::-1, ::-1])[..., ::-1, ::-1]
        slip = 0.5 * twice / (disc.scales.pressure * unit_slip(disc))
        return 0.0 - float(rolls * np.sum(self.traction * slip) * self.grid.area)

    def report(self) -> str:
        """The solution in words, for people."""
        from varcontact.results.report import report

        return report(self)

    def __str__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        from varcontact.results.report import headline, report_rows

        return html_table(headline(self), report_rows(self))

    def __repr__(self) -> str:
        Fx, Fy = self.force
        return (
            f"Solution(normal_force={self.normal_force:.6g}, force=({Fx:.6g}, {Fy:.6g}), moment={self.moment:.6g}, "
            f"residual={self.certificate.residual:.1e})"
        )

    def summary(self) -> dict[str, Any]:
        """Forces, counts, certificate and methods as plain numbers: what ``varcontact solve --json`` prints.

        What is not known (an infinite bound), or no number, is None.
        """
        return {
            "normal_force": known(self.normal_force),
            "force": [known(F) for F in self.force],
            "moment": known(self.moment),
            "approach": known(self.approach),
            "creepage": [known(c) for c in self.creepage],
            "doubts": list(self.scene.doubts),
            "power": known(self.power),
            "friction_work": known(self.friction_work),
            "negative_work": known(self.negative_work),
            "elements": self.elements,
            "certificate": {name: _plain(value) for name, value in self.certificate.plain().items()},
            "converged": self.converged,
            "method": {name: getattr(self.plan, name) for name in ("normal", "tangential", "coupling")},
            "road": self.plan.method,
            "formulation": self.plan.formulation,
            "left_out": self.plan.left_out,
            "iterations": self.iterations,
            "status": self.status,
            "solved_by": self.solved_by,
            "calls": plain_calls(self.calls),
            "passes": len(self.passes),
            "convergence": [[known(change), known(residual)] for change, residual in self.passes],
            "branch": self.branch,
            "note": self.note,
            "warnings": list(self.warnings),
            "error_estimate": None if self.error_estimate is None else self.error_estimate.plain(),
            "coefficient": self._coefficients(),
            "refinement": None if self.refinement is None else self.refinement.summary(),
            "seconds": self.timing["total"],
        }

    def _coefficients(self) -> list[float] | None:
        """Least and largest coefficient of friction that a law has where it slips."""
        if self.friction is None or not np.any(self.state == SLIP):
            return None
        found = self.friction[self.state == SLIP]
        return [float(found.min()), float(found.max())]


def plain_calls(calls: dict[str, dict[str, Calls]]) -> dict[str, dict[str, dict[str, float]]]:
    """Calls of solvers as dictionaries of numbers, seconds to the microsecond."""
    return {
        problem: {name: {**asdict(each), "seconds": round(each.seconds, 6)} for name, each in solvers.items()}
        for problem, solvers in calls.items()
    }


def known(value: float) -> float | None:
    """A number for JSON, which has no NaN and no infinity: None for these."""
    return float(value) if np.isfinite(value) else None


def _plain(value: float | str | list[float]) -> Any:
    """A word, a number or several, for JSON."""
    if isinstance(value, str):
        return value
    return [known(each) for each in value] if isinstance(value, list) else known(value)
