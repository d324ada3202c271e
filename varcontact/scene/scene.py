"""What the user says: bodies, surface, load, friction, motion, grid. Each class checks itself when made."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import NoContact, SceneError
from varcontact.reference.hertz import HertzContact, hertz, hertz_ellipse
from varcontact.reference.line_contact import line_contact
from varcontact.scene.bodies import Bodies
from varcontact.scene.friction import Law
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Motion, Shift, Steady, TimeStep, Transient, coefficient
from varcontact.scene.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance, Surface, is_line
from varcontact.scene.units import Units


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene:
    """A contact as the user describes it, in any consistent units.

    Parameters
    ----------
    bodies : Bodies
        Elastic constants.
    surface : Paraboloids, Ellipse, Cylinders or SampledDistance
        Undeformed distance.
    normal_force, approach : float
        Exactly one of the two (in a history at most): compressive force [force; in line contact per unit length], or
        approach of the bodies [length].
    friction : float, law or array_like, shape (ny, nx), or (nx,) in line contact
        Coefficient of friction; a number (``inf``: no slip at all), a law (`StaticKinetic`, `LinearFalling`,
        `RationalFalling`, `ExponentialFalling`), or one number per element of an explicit
        grid. Needed where there is a motion.
    motion : Steady, Shift or Transient, optional
        None: normal contact only. A history (`Transient`) may give load, friction and surface of its steps itself.
    grid : Grid or "auto"
        The potential contact and its elements; ``"auto"``: 24 elements across the contact either way, 100 in line
        contact.
    units : Units, optional
        Names of the units, for reports, files and pictures.

    Raises
    ------
    SceneError
        Naming the entry, its value and what is allowed.
    NoContact
        If the approach leaves the bodies apart.

    Examples
    --------
    >>> scene = Scene(
    ...     bodies=Bodies(G=82e9, nu=0.28), surface=Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=Steady(vx=1e-3), grid=Grid(nx=24, ny=24))
    >>> print(f"{scene.hertz.a * 1e3:.2f} x {scene.hertz.b * 1e3:.2f} mm")
    7.35 x 5.53 mm
    """

    bodies: Bodies
    surface: Surface
    normal_force: float | None = None
    approach: float | None = None
    friction: float | np.ndarray | Law | None = None
    motion: Motion | Transient | None = None
    grid: Grid | Literal["auto"] = "auto"
    units: Units | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        _instance("bodies", self.bodies, (Bodies,))
        _instance("surface", self.surface, (Paraboloids, Ellipse, Cylinders, SampledDistance))
        if self.motion is not None:
            _instance("motion", self.motion, (Steady, Shift, TimeStep, Transient))
        if self.units is not None:
            _instance("units", self.units, (Units,))
        if not (isinstance(self.grid, str) and self.grid == "auto"):
            _instance("grid", self.grid, (Grid,), ' or "auto"')
        self._check_load()
        self._check_dimension()
        if self.friction is None:
            if self.motion is not None and not (
                isinstance(self.motion, Transient) and None not in self.motion.every("friction")
            ):
                raise SceneError("friction", None, "given where there is a motion (a number, inf, a law, or an array)")
        elif not checks.is_array(self.friction):
            set_(self, "friction", coefficient("friction", self.friction))
        else:
            given: Any = self.friction
            row = self.line and np.ndim(given) == 1
            values = checks.array("friction", np.atleast_2d(given) if row else given, 2)
            set_(self, "friction", values)
            self._check_on_grid("friction", values)
            if np.any(values < 0):
                raise SceneError("friction", float(np.min(values)), "zero or positive everywhere")
        self._check_slip_velocity()
        if isinstance(self.surface, Ellipse) and (self.normal_force, self.approach) == (None, None):
            raise SceneError("surface", self.surface, "Paraboloids, where the scene has no load of its own")
        for surface in self.surfaces:
            if is_line(surface) != self.line or getattr(surface, "reference_depth", None) != self.reference_depth:
                raise SceneError("motion.surface", surface, "line contact as the scene's surface, from the same depth")
            if isinstance(surface, SampledDistance) and surface.x is None:
                self._check_on_grid("surface.h", surface.samples)

    def _check_slip_velocity(self) -> None:
        """Steps of a history that do not roll take no known time."""
        motion = self.motion
        if not isinstance(motion, Transient):
            return
        for k, law in enumerate(self.frictions):
            if isinstance(law, Law) and law.continuous and motion.of("dq", k) == 0:
                name = "friction" if motion.of("friction", k) is None else "motion.friction"
                allowed = f"without slip velocity, as StaticKinetic: step {k} does not roll (motion.dq = 0)"
                raise SceneError(name, law, allowed)

    def _check_dimension(self) -> None:
        """Line contact has no rows, no spin, and a reference depth where displacements are prescribed."""
        motion, surface, grid = self.motion, self.surface, self.grid
        if not isinstance(surface, (Cylinders, SampledDistance)) or not is_line(surface):
            if isinstance(grid, Grid) and grid.line:
                raise SceneError("grid.ny", None, "given: only line contact has no rows")
            return
        if isinstance(grid, Grid) and not grid.line:
            if grid.ny != 1:
                raise SceneError("grid.ny", grid.ny, "left out in line contact")
            if grid.dy is not None:
                raise SceneError("grid.dy", grid.dy, "left out in line contact, where forces are per unit length")
            object.__setattr__(self, "grid", Grid(nx=grid.nx, margin=grid.margin, edge=grid.edge))
        for name in ("spin", "rotation"):
            turns = np.atleast_1d(getattr(motion, name, 0.0))
            if np.any(turns != 0):
                raise SceneError(
                    f"motion.{name}", float(turns[turns != 0][0]), "0 in line contact, where nothing depends on y"
                )
        if isinstance(motion, Transient):
            self._check_afloat(motion)
            return
        if surface.reference_depth is not None or isinstance(motion, TimeStep):
            return
        needed = []
        if self.approach is not None:
            needed.append("approach")
        if isinstance(motion, Shift):
            moves_x = motion.Fx is None and (motion.ux != 0 or (self.bodies.K != 0 and not self.frictionless))
            needed += ["motion.ux"] * moves_x + ["motion.uy"] * (motion.Fy is None and motion.uy != 0)
        if needed:
            raise SceneError(
                "surface.reference_depth",
                None,
                f"given, for {' and '.join(needed)}: in line contact displacements count from a depth; or a prescribed "
                "force",
            )

    def _check_afloat(self, motion: Transient) -> None:
        """In line contact displacements count from a depth, or but for a constant that a changing force changes."""
        surfaces = self.surfaces
        if all(not isinstance(each, Paraboloids | Ellipse) and each.reference_depth is not None for each in surfaces):
            return
        pressed = self.bodies.K != 0 and not self.frictionless
        for i, (force, rigid) in enumerate({"Fx": ("vx", "ux"), "Fy": ("vy", "uy")}.items()):
            moved = any(value != 0 for name in rigid for value in motion.every(name))
            forces = motion.every(force)
            start = motion.start
            carried = start is not None and bool(np.any(np.abs(start.traction[i]) > 1e-9 * start.pressure.max()))
            if not (moved or carried or any(forces) or (pressed and i == 0)):
                continue  # no traction arises in this direction
            if None in forces:
                k = forces.index(None)
                raise SceneError(
                    "surface.reference_depth",
                    None,
                    f"given, where motion.{force} is not in each step (step {k}): the displacement that a changing "
                    "force leaves counts from a depth in line contact",
                )
        for k, approach in enumerate(motion.every("approach")):
            if approach is not None or (self.approach is not None and motion.of("normal_force", k) is None):
                raise SceneError("surface.reference_depth", None, f"given, for the approach of step {k}")

    def _check_load(self) -> None:
        motion, set_ = self.motion, object.__setattr__
        given = (self.normal_force, self.approach)
        in_steps = isinstance(motion, Transient) and given == (None, None)
        if (self.normal_force is None) == (self.approach is None) and not in_steps:
            which = "neither" if self.normal_force is None else "both"
            raise SceneError("normal_force, approach", given, f"exactly one of the two ({which} given)")
        if isinstance(motion, Transient):
            for k in range(motion.steps):
                force, approach = motion.of("normal_force", k), motion.of("approach", k)
                if (force is None) == (approach is None) and (in_steps or force is not None):
                    name = f"motion.normal_force[{k}], motion.approach[{k}]"
                    raise SceneError(name, (force, approach), f"one of the two{'' if in_steps else ' at most'}")
        if self.normal_force is not None:
            unloaded = isinstance(motion, TimeStep) and self.normal_force == 0
            check = checks.number if unloaded else checks.positive
            set_(self, "normal_force", check("normal_force", self.normal_force))
        if self.approach is not None:
            set_(self, "approach", checks.number("approach", self.approach))
            least = float(self.surface.h.min()) if isinstance(self.surface, SampledDistance) else 0.0
            if self.approach <= least and not isinstance(motion, TimeStep | Transient):
                raise NoContact(
                    "approach", self.approach, f"above the least undeformed distance, {least:.6g}: no contact"
                )

    def _check_on_grid(self, field: str, values: Any) -> None:
        entries = "nx, dx, x0" if self.line else "nx, ny, dx, dy, x0, y0"
        if not (isinstance(self.grid, Grid) and self.grid.explicit):
            raise SceneError("grid", self.grid, f"explicit ({entries}) where {field} is given on it")
        if values.shape != self.grid.shape:
            allowed = f"(nx,) = ({self.grid.nx},)" if self.line else f"(ny, nx) = {self.grid.shape}"
            given = values.shape[1:] if self.line and values.shape[0] == 1 else values.shape
            raise SceneError(field, f"array of shape {given}", f"of the grid's shape {allowed}")

    @property
    def line(self) -> bool:
        """Whether it is a line contact, in plane strain."""
        return is_line(self.surface)

    @property
    def reference_depth(self) -> float | None:
        """The depth from which displacements count in line contact, where it is given."""
        return self.surface.reference_depth if isinstance(self.surface, (Cylinders, SampledDistance)) else None

    @property
    def touched(self) -> bool:
        """Whether every element that the contact touches belongs to it, see `Grid`."""
        return isinstance(self.grid, Grid) and self.grid.edge == "touched"

    @property
    def hertz(self) -> HertzContact | None:
        """Hertz's solution where the surface is Hertzian, else None; a line contact is an ellipse with infinite b.

        The approach of a line contact is NaN where no reference depth is given.
        """
        if self.normal_force == 0 or (self.approach is not None and self.approach <= 0):
            return None  # a step without contact
        load = {"force": self.normal_force, "approach": self.approach}
        if isinstance(self.surface, Cylinders):
            return _hertz_line(self.surface, self.bodies, **load)
        if isinstance(self.surface, Paraboloids):
            return hertz(self.surface.Rx, self.surface.Ry, self.bodies, **load)
        if isinstance(self.surface, Ellipse):
            return hertz_ellipse(self.surface.a, self.surface.b, self.bodies, **load)
        return None

    @property
    def frictions(self) -> list[float | np.ndarray | Law | None]:
        """The coefficient of friction, of each step where it is a history."""
        if not isinstance(self.motion, Transient):
            return [self.friction]
        return [self.friction if f is None else f for f in self.motion.every("friction")]

    @property
    def under_law(self) -> bool:
        """Whether the coefficient of friction follows a law, in some step where it is a history."""
        return any(isinstance(f, Law) for f in self.frictions)

    @property
    def surfaces(self) -> list[Surface]:
        """The surface, of each step where it is a history."""
        if isinstance(self.motion, Transient) and self.motion.surface is not None:
            return list(self.motion.surface)
        return [self.surface]

    @property
    def frictionless(self) -> bool:
        """Whether no tangential traction can arise."""
        return self.motion is None or all(bool(np.all(np.asarray(f) == 0)) for f in self.frictions)

    @property
    def no_slip(self) -> bool:
        """Whether friction is infinite."""
        return all(isinstance(f, float) and math.isinf(f) for f in self.frictions)

    def contact(self, k: int) -> tuple[Surface, float | None, float | None]:
        """Surface, normal force and approach of step k of a history."""
        motion = self.motion
        assert isinstance(motion, Transient)
        force, approach = motion.of("normal_force", k), motion.of("approach", k)
        if force is None and approach is None:
            force, approach = self.normal_force, self.approach
        return (self._surface if motion.surface is None else motion.surface[k]), force, approach

    def step(self, k: int, grid: Grid) -> Scene:
        """The scene of step k of a history, on the history's grid."""
        motion = self.motion
        assert isinstance(motion, Transient)
        surface, force, approach = self.contact(k)
        own = motion.of("friction", k)
        friction = self.friction if own is None else own
        return replace(
            self,
            surface=surface,
            normal_force=force,
            approach=approach,
            friction=friction,
            motion=motion.step(k, grid.sides[0]),
            grid=grid,
        )

    @cached_property
    def _surface(self) -> Surface:
        """The surface under any load: an ellipse is that of the scene's own."""
        surface = self.surface
        if not isinstance(surface, Ellipse):
            return surface
        own = hertz_ellipse(surface.a, surface.b, self.bodies, force=self.normal_force, approach=self.approach)
        return Paraboloids(own.Rx, own.Ry)


def _hertz_line(surface: Cylinders, bodies: Bodies, force: float | None, approach: float | None) -> HertzContact:
    depth = surface.reference_depth
    if force is None:
        assert approach is not None
        assert depth is not None
        contact = line_contact(surface.R, bodies, approach=approach, depth=depth)
    else:
        contact = line_contact(surface.R, bodies, force=force)
        approach = math.nan if depth is None else contact.approach(depth)
    return HertzContact(contact.a, math.inf, approach, contact.force, contact.peak_pressure, surface.R, math.inf)


def _instance(field: str, value: Any, classes: tuple[type, ...], more: str = "") -> None:
    if not isinstance(value, classes):
        raise SceneError(field, value, " or ".join(c.__name__ for c in classes) + more)
