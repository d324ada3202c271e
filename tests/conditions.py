"""Kalker's conditions of a solution, (15)-(17) and (45)-(49), element by element, from nothing but
its fields.

The judge of the tests shares no arithmetic with the package: matrices are made pair by pair in
`elasticity_again`, laws of friction, Hertz's pressure and the undeformed distance are evaluated
anew. Displacements are judged as the tractions that would cause them in their own element (divided
by its influence on itself), tractions by the largest one: `tol` then means the same everywhere, and
is what a natural-map residual of `tol` implies.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import make_interp_spline

import varcontact as vc
from tests.elasticity_again import (
    Constants,
    Ellipse,
    hertz_by_axes,
    hertz_by_radii,
    hertz_line,
    influence,
)

NOISE = 1e-12
"""Rounding of a sum of displacements, in parts of the sum of their magnitudes."""
SLIP = 2


def violations(sol: vc.Solution, tol: float, previous: vc.Solution | None = None) -> list[str]:
    """What of the conditions a solution does not meet to `tol`; empty where it is one."""
    held = Held(sol, previous)
    found = [*_finite(sol), *_pressures(held, tol)]
    if found or sol.motion is None or not sol.pressure.any():
        return [
            *found,
            *(["tractions without contact or motion"] if not found and sol.traction.any() else []),
        ]
    found += _kinematics(held)
    if sol.plan.theory is None:
        found += _tractions(held, tol)
    return found + _forces(held, tol)


@dataclass(frozen=True, eq=False)
class Held:
    """A solution's fields, flat, and the displacements that its tractions cause."""

    sol: vc.Solution
    previous: vc.Solution | None

    @cached_property
    def constants(self) -> Constants:
        return Constants.of(self.sol.scene.bodies)

    @property
    def pressure(self) -> np.ndarray:
        return self.sol.pressure.ravel()

    @property
    def traction(self) -> np.ndarray:
        return self.sol.traction.reshape(2, -1)

    @cached_property
    def points(self) -> np.ndarray:
        """Element centres, shape (2, n)."""
        return np.array(
            [values.ravel() for values in np.meshgrid(self.sol.grid.x, self.sol.grid.y)]
        )

    @cached_property
    def bound(self) -> np.ndarray:
        """Coefficient of friction at this slip, times the pressure, shape (n,)."""
        friction = self.sol.scene.friction
        if isinstance(
            friction,
            vc.StaticKinetic | vc.LinearFalling | vc.RationalFalling | vc.ExponentialFalling,
        ):
            slips = self.sol.state.ravel() == SLIP
            friction = np.where(
                slips, at_slip(friction, np.hypot(*self.sol.slip.reshape(2, -1))), friction.static
            )
        coefficients = np.broadcast_to(
            np.ravel(0.0 if friction is None else friction), self.pressure.shape
        )
        return np.where(
            self.pressure > 0, coefficients * np.where(self.pressure > 0, self.pressure, 1.0), 0.0
        )

    # ------------------------------------------------------------------------- displacements

    def _caused(
        self, sol: vc.Solution, ahead: float, less: float | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Displacements (3, n) by a solution's tractions, and their magnitudes if nothing
        cancelled.
        """
        loads = np.concatenate([sol.traction.reshape(2, -1), sol.pressure.reshape(1, -1)])
        sources = np.flatnonzero(loads.any(axis=0))
        options = {"less": less, "depth": self.sol.scene.reference_depth}
        matrix = influence(self.sol.grid, self.constants, sources, ahead=ahead, **options)
        acting = loads[:, sources].ravel()
        return (matrix @ acting).reshape(3, -1), (np.abs(matrix) @ np.abs(acting)).reshape(3, -1)

    @cached_property
    def displacement(self) -> tuple[np.ndarray, np.ndarray]:
        """By the tractions as they are."""
        return self._caused(self.sol, 0.0)

    @property
    def distance(self) -> np.ndarray:
        """Of the deformed bodies, (n,); where the approach is not known, from their mean distance
        under pressure.
        """
        apart, approach = (
            undeformed(self.sol, self.points) + self.displacement[0][2],
            self.sol.approach,
        )
        return np.asarray(
            apart - (apart[self.pressure > 0].mean() if np.isnan(approach) else approach)
        )

    @property
    def lowered(self) -> np.ndarray:
        """What the tangential tractions of unlike bodies add to the distance, (n,)."""
        alone = replace(self.sol, pressure=np.zeros_like(self.sol.pressure))
        return self._caused(alone, 0.0)[0][2]

    @cached_property
    def own(self) -> np.ndarray:
        """An element's influence on itself by tractions along x, y and z; in steady rolling by A -
        C along x and y.
        """
        own = influence(
            self.sol.grid, self.constants, np.zeros(1, int), depth=self.sol.scene.reference_depth
        )
        own = np.diagonal(own[:: self.pressure.size])
        if isinstance(self.sol.motion, vc.Steady):
            rolled = influence(self.sol.grid, self.constants, np.zeros(1, int), less=self.step)
            own = np.append(np.diagonal(rolled[:: self.pressure.size])[:2], own[2])
        return own

    @property
    def step(self) -> float:
        """Distance rolled; of a step in place 1, by which slip is a shift."""
        motion = self.sol.motion
        if isinstance(motion, vc.Steady):
            return motion.dq if motion.dq is not None else self.sol.grid.sides[0]
        return (motion.dq if isinstance(motion, vc.TimeStep) else 0.0) or 1.0

    @cached_property
    def elastic(self) -> tuple[np.ndarray, np.ndarray]:
        """What elasticity adds to the local shift, (2, n), and its magnitude if nothing
        cancelled.
        """
        motion = self.sol.motion
        if isinstance(motion, vc.Steady):
            values, sizes = self._caused(self.sol, 0.0, less=self.step)
        else:
            values, sizes = self.displacement
        if isinstance(motion, vc.TimeStep) and self.previous is not None:
            carried, more = self._caused(self.previous, motion.direction * motion.dq)
            values, sizes = values - carried, sizes + more
        return values[:2], sizes[:2]

    @cached_property
    def rigid(self) -> np.ndarray:
        """Rigid shift (75), (2, n); what is not known of it is zero."""
        motion, step, (x, y) = self.sol.motion, self.step, self.points
        along_x, along_y = np.nan_to_num(self.sol.creepage[:2])
        if isinstance(motion, vc.Shift):
            turned, ahead = motion.rotation, x
        elif isinstance(motion, vc.Steady):
            turned, ahead = motion.spin * step, x + motion.spin_offset * step
        else:
            assert isinstance(motion, vc.TimeStep)
            rolled = motion.spin * motion.dq
            extra = rolled * motion.spin_offset * motion.direction * motion.dq
            turned, ahead = rolled + motion.rotation, x
            along_y += extra / step
        return np.array([along_x * step - turned * y, along_y * step + turned * ahead])

    @cached_property
    def shift(self) -> np.ndarray:
        """Local shift E of the elements in contact, (2, n)."""
        shift = self.rigid + self.elastic[0]
        for i in np.flatnonzero(np.isnan(self.sol.creepage[:2])):  # known but for a constant
            shift[i] += np.mean(
                (self.sol.slip[i].ravel() * self.step - shift[i])[self.pressure > 0]
            )
        return shift

    @cached_property
    def shift_noise(self) -> float:
        """Rounding of the local shift; of A - C, of both before they are subtracted."""
        summed = NOISE * float(np.abs(self.rigid).max() + self.elastic[1].max())
        return summed + 4 * float(np.finfo(float).eps * self.displacement[1].max())


def on_parts(held: Held) -> Held:
    """The pressure that was solved for on parts of the elements, without tractions; of whole
    elements as it is.
    """
    sol, pressure = held.sol, held.sol.pressure_on_parts
    if pressure is None:
        return held
    (rows, columns), (ny, nx) = pressure.shape, sol.grid.shape
    finer = sol.grid.divided((rows // ny, columns // nx))
    return Held(
        replace(sol, grid=finer, pressure=pressure, traction=np.zeros((2, rows, columns))), None
    )


def at_slip(law: vc.StaticKinetic | vc.LinearFalling, slip: np.ndarray) -> np.ndarray:
    """The coefficient of friction of a law where it slips."""
    if isinstance(law, vc.StaticKinetic):
        return np.full(slip.shape, law.kinetic)
    t = slip * law.velocity / law.half_velocity
    part = {
        vc.LinearFalling: np.maximum(1 - t / 2, 0.0),
        vc.RationalFalling: 1 / (1 + t),
        vc.ExponentialFalling: 0.5**t,
    }[type(law)]
    return np.asarray(law.kinetic + (law.static - law.kinetic) * part)


# ---------------------------------------------------------------------------- the undeformed bodies


def closed_form(sol: vc.Solution) -> Ellipse | None:
    """Hertz's contact of a scene; None where its surface is sampled."""
    scene, constants = sol.scene, Constants.of(sol.scene.bodies)
    load = {"force": scene.normal_force, "approach": scene.approach}
    surface = scene.surface
    if isinstance(surface, vc.Paraboloids):
        return hertz_by_radii(surface.Rx, surface.Ry, constants, **load)
    if isinstance(surface, vc.Ellipse):
        return hertz_by_axes(surface.a, surface.b, constants, **load)
    if isinstance(surface, vc.Cylinders):
        return hertz_line(surface.R, constants, depth=surface.reference_depth, **load)
    return None


def undeformed(sol: vc.Solution, points: np.ndarray) -> np.ndarray:
    """Undeformed distance at the element centres (2, n)."""
    surface, (x, y) = sol.scene.surface, points
    if not isinstance(surface, vc.SampledDistance):
        ellipse = closed_form(sol)
        assert ellipse is not None
        return x**2 / (2 * ellipse.Rx) + y**2 / (2 * ellipse.Ry)
    if surface.x is None:
        return surface.h.ravel()
    values, grid = surface.h, sol.grid
    along_x = make_interp_spline(surface.x, values, k=min(3, surface.x.size - 1), axis=-1)(grid.x)
    if surface.y is None:
        return along_x
    return make_interp_spline(surface.y, along_x, k=min(3, surface.y.size - 1), axis=0)(
        grid.y
    ).ravel()


def hertz_shape(ellipse: Ellipse, sol: vc.Solution, points: np.ndarray) -> np.ndarray:
    """Hertz's pressure (n,) as the grid has it: at the centres, or averaged over each element that
    it touches.
    """
    (x, y), (dx, dy) = points, sol.grid.sides
    if sol.grid.edge == "centres":
        return np.sqrt(np.maximum(1 - (x / ellipse.a) ** 2 - (y / ellipse.b) ** 2, 0))
    nodes, weights = np.polynomial.legendre.leggauss(400)
    # the part of the element along x
    ends = np.clip([x - dx / 2, x + dx / 2], -ellipse.a, ellipse.a)
    at = ends.mean(axis=0)[:, None] + (ends[1] - ends[0])[:, None] / 2 * nodes
    height = np.sqrt(np.maximum(1 - (at / ellipse.a) ** 2, 0))
    if np.isinf(ellipse.b):
        across = height
    else:  # the integral of sqrt(height^2 - (y/b)^2) over y, by dy

        def primitive(y: np.ndarray) -> np.ndarray:
            t = np.clip(y[:, None] / ellipse.b / np.where(height > 0, height, 1), -1, 1)
            return ellipse.b * height**2 / 2 * (t * np.sqrt(1 - t**2) + np.arcsin(t))

        across = (primitive(y + dy / 2) - primitive(y - dy / 2)) / dy
    return np.asarray(across @ weights * (ends[1] - ends[0]) / (2 * dx))


# ----------------------------------------------------------------------------- the conditions


def _finite(sol: vc.Solution) -> list[str]:
    fields = {
        "pressure": sol.pressure,
        "traction": sol.traction,
        "slip": sol.slip,
        "distance": sol.distance,
    }
    return [
        f"{name} is not finite" for name, field in fields.items() if not np.isfinite(field).all()
    ]


def _pressures(held: Held, tol: float) -> list[str]:
    """Pressure pushes, bodies do not overlap, and there is no pressure at a distance; the load is
    as prescribed.
    """
    sol, pressure, found = held.sol, held.pressure, []
    peak, scene = float(pressure.max()), sol.scene
    if pressure.min() < 0:
        found.append(f"a pressure that pulls: {pressure.min() / peak:.1e} of the largest")
    if peak == 0:
        return found + (["no contact under a load"] if scene.normal_force else [])
    values, sizes = held.displacement
    distance = undeformed(sol, held.points) + values[2]
    approach = sol.approach
    if np.isnan(approach):  # line contact without a depth: known but for a constant
        approach = float(np.mean((distance - sol.distance.ravel())[pressure > 0]))
    distance = distance - approach
    noise = NOISE * float(sizes[2].max() + np.abs(undeformed(sol, held.points)).max())
    stated = np.abs(sol.distance.ravel() - distance).max()
    found += _too_large("the distance is another", stated, noise)
    if sol.plan.closed_form:
        found += _hertz(held)
    elif sol.pressure_on_parts is not None:
        parts = on_parts(held)
        found += _contact(parts, parts.distance, tol, noise)
        (ny, nx), (rows, columns) = sol.grid.shape, sol.pressure_on_parts.shape
        means = sol.pressure_on_parts.reshape(ny, rows // ny, nx, columns // nx).mean(axis=(1, 3))
        off = float(np.abs(means - sol.pressure).max())
        found += _too_large(
            "elements bear other pressures than the means of their parts", off, 1e-12 * peak
        )
    elif sol.plan.coupling == "johnson":
        found += _contact(held, distance - held.lowered, tol, noise)
    else:
        found += _contact(held, distance, tol, noise)
    if scene.normal_force is not None:
        found += _too_large(
            "the normal force is another", abs(sol.normal_force / scene.normal_force - 1), tol
        )
    elif not sol.plan.closed_form:
        found += _too_large(
            "the approach is another", abs(sol.approach / scene.approach - 1), 1e-12
        )
    return found


def _contact(held: Held, distance: np.ndarray, tol: float, noise: float) -> list[str]:
    rho, peak, pressure = held.own[2], held.pressure.max(), held.pressure
    found = _too_large("bodies overlap", -distance.min() / rho, tol * peak + noise / rho)
    apart = np.minimum(pressure, distance / rho).max()
    return found + _too_large("pressure at a distance", apart, tol * peak + noise / rho)


def _hertz(held: Held) -> list[str]:
    """Hertz's pressure, scaled to carry the force."""
    sol, ellipse = held.sol, closed_form(held.sol)
    assert ellipse is not None
    shape = hertz_shape(ellipse, sol, held.points)
    expected = shape * ellipse.force / (shape.sum() * sol.grid.area)
    allowed = 1e-7 if sol.grid.edge == "centres" else 1e-4
    found = _too_large(
        "not Hertz's pressure", np.abs(held.pressure - expected).max() / expected.max(), allowed
    )
    if np.isfinite(ellipse.approach):
        found += _too_large("not Hertz's approach", abs(sol.approach / ellipse.approach - 1), 1e-9)
    return found


def _kinematics(held: Held) -> list[str]:
    """The stated slip is that of the tractions, and the stated creepage the prescribed one."""
    sol, motion = held.sol, held.sol.motion
    assert motion is not None
    contact = held.pressure > 0
    stated = np.abs(sol.slip.reshape(2, -1) * held.step - held.shift)[:, contact].max()
    found = _too_large("the slip is another", stated, 10 * held.shift_noise)
    rigid = (*motion.rigid[:2], motion.rigid[2])
    for name, given, stated, force in zip(
        "xyz", rigid, sol.creepage, (motion.Fx, motion.Fy, None), strict=True
    ):
        if force is None and abs(given - stated) > 1e-12 * abs(given):
            found.append(f"creepage {name} is {stated!r}, not {given!r}")
    if np.any(sol.traction.reshape(2, -1)[:, ~contact]):
        found.append("tractions outside the contact")
    return found


def _tractions(held: Held, tol: float) -> list[str]:
    """Coulomb's law: within the disk, no slip below the bound, slip against the traction, and
    states that say so.
    """
    contact, state = held.pressure > 0, held.sol.state.ravel()
    traction, shift, bound = held.traction[:, contact], held.shift[:, contact], held.bound[contact]
    size, slip = np.hypot(*traction), np.hypot(*shift)
    acts = traction.any(axis=1) if traction.any() else np.ones(2, bool)
    rho = float(held.own[:2][acts].mean())
    found = ["states are not those of the contact"] if np.any((state != 0) != contact) else []
    image = np.minimum(np.hypot(*(traction - shift / rho)), bound)
    allowed = tol * max(size.max(), image.max()) + held.shift_noise / rho
    found += _too_large("traction beyond its bound", float(np.max(size - bound)), allowed)
    below = bound - size > allowed
    found += _too_large("slip below the bound", np.max(slip[below], initial=0.0) / rho, allowed)
    if np.isfinite(bound).all():
        opposed = np.hypot(*(traction * slip + bound * shift))
        most = 2 * allowed * (slip / rho + bound)
        found += _too_large(
            "slip not against the traction", float(np.max(opposed / rho - most)), 0.0
        )
    sticks, slides = state[contact] == 1, state[contact] == SLIP
    edge = allowed + 2e-8 * np.where(np.isfinite(bound), bound, 0.0)
    found += _too_large(
        "slip in the stick area", float(np.max((slip / rho - edge)[sticks], initial=0.0)), 0.0
    )
    return found + _too_large(
        "below the bound in the slip area", np.max((bound - size)[slides], initial=0.0), allowed
    )


def _forces(held: Held, tol: float) -> list[str]:
    """Prescribed forces are met."""
    sol, found = held.sol, []
    motion = sol.motion
    assert motion is not None
    carried = float(np.hypot(*held.traction).sum()) * sol.grid.area
    allowed = tol if sol.plan.theory is None else 1e-4
    for name, force, asked in zip("xy", sol.force, (motion.Fx, motion.Fy), strict=True):
        if asked is not None:
            scale = max(carried, abs(asked)) * np.sqrt(max(np.count_nonzero(held.bound), 1))
            found += _too_large(
                f"the force F{name} is another", abs(force - asked), allowed * scale
            )
    return found


def _too_large(what: str, value: float, allowed: float) -> list[str]:
    """A violation in words; NaN is one."""
    return [] if value <= allowed else [f"{what}: {value:.2e}, allowed {allowed:.2e}"]
