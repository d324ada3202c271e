"""What the user says: bodies, surfaces, load, friction, motion, grid. Each class checks itself when made."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import NoContact, SceneError
from varcontact.grid import Grid
from varcontact.reference.hertz import HertzContact, hertz, hertz_ellipse
from varcontact.reference.line_contact import line_contact
from varcontact.surfaces import Cylinders, Ellipse, Paraboloids, SampledDistance, Surface, is_line
from varcontact.units import Units


@dataclass(frozen=True)
class Bodies:
    """Elastic constants of the two bodies: isotropic half-spaces (paper, section 2).

    Parameters
    ----------
    G : float or pair
        Modulus of rigidity [force/area]; one value for both bodies, or (upper, lower). ``inf`` is rigid.
    nu : float or pair
        Poisson's ratio in (-1, 0.5].

    Raises
    ------
    SceneError
        For moduli that are not positive, ratios out of range, or two rigid bodies.

    Examples
    --------
    >>> steel_on_aluminium = Bodies(G=(82e9, 26e9), nu=(0.28, 0.33))
    >>> print(f"{steel_on_aluminium.combined_G:.4g} {steel_on_aluminium.K:.4f}")
    3.948e+10 -0.0761
    """

    G: float | tuple[float, float]
    nu: float | tuple[float, float]

    def __post_init__(self) -> None:
        G = _pair("bodies.G", self.G, _modulus)
        nu = _pair("bodies.nu", self.nu, _poisson)
        if math.isinf(G[0]) and math.isinf(G[1]):
            raise SceneError("bodies.G", self.G, "finite for one body at least (both are rigid)")
        object.__setattr__(self, "G", G[0] if G[0] == G[1] else G)
        object.__setattr__(self, "nu", nu[0] if nu[0] == nu[1] else nu)

    @classmethod
    def from_young(cls, E: float | tuple[float, float], nu: float | tuple[float, float]) -> Bodies:
        """From Young's modulus, (160): ``G = E / (2 (1 + nu))``.

        Examples
        --------
        >>> Bodies.from_young(E=210e9, nu=0.25)
        Bodies(G=84000000000.0, nu=0.25)
        """
        moduli = _pair("bodies.E", E, _modulus)
        ratios = _pair("bodies.nu", nu, _poisson)
        return cls(G=(moduli[0] / (2 + 2 * ratios[0]), moduli[1] / (2 + 2 * ratios[1])), nu=ratios)

    @property
    def pairs(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """((G1, G2), (nu1, nu2))."""
        G = self.G if isinstance(self.G, tuple) else (self.G, self.G)
        nu = self.nu if isinstance(self.nu, tuple) else (self.nu, self.nu)
        return G, nu

    @property
    def combined_G(self) -> float:
        """Combined modulus of rigidity, ``1/G = (1/G1 + 1/G2)/2`` (58)."""
        (G1, G2), _ = self.pairs
        return 2 / (1 / G1 + 1 / G2)

    @property
    def combined_nu(self) -> float:
        """Combined Poisson's ratio, ``nu/G = (nu1/G1 + nu2/G2)/2`` (59)."""
        (G1, G2), (nu1, nu2) = self.pairs
        return nu1 if nu1 == nu2 else self.combined_G / 2 * (nu1 / G1 + nu2 / G2)

    @property
    def K(self) -> float:
        """Difference parameter (60); zero: quasi-identical, normal and tangential problem uncoupled."""
        (G1, G2), (nu1, nu2) = self.pairs
        if (G1, nu1) == (G2, nu2):
            return 0.0
        weight = self.combined_G / 4
        upper, lower = weight * (1 - 2 * nu1) / G1, weight * (1 - 2 * nu2) / G2
        return upper - lower if abs(upper - lower) > 1e-15 else 0.0


@dataclass(frozen=True, kw_only=True)
class Steady:
    """Steady rolling in the direction of x.

    Parameters
    ----------
    vx, vy : float
        Longitudinal and lateral creepage [-]: rigid slip of body 1 over body 2 by rolling velocity (75).
    spin : float
        Spin creepage [1/length].
    Fx, Fy : float, optional
        Tangential force on body 1 in place of the creepage of the same direction [force].
    dq : float, optional
        Distance rolled in the step that discretises the slip [length]; the element's dx if not given.
    spin_offset : float
        Where the rigid slip of spin is sampled: at ``x + spin_offset * dq``; in [0, 1]. The default 1/6 is
        CONTACT's; 0 keeps the discrete C23 = -C32 exact, 1/2 is the path's middle.
    """

    vx: float = 0.0
    vy: float = 0.0
    spin: float = 0.0
    Fx: float | None = None
    Fy: float | None = None
    dq: float | None = None
    spin_offset: float = 1 / 6

    def __post_init__(self) -> None:
        _check_motion(self, "vx", "vy", "spin")
        if self.dq is not None:
            object.__setattr__(self, "dq", checks.positive("motion.dq", self.dq))
        offset = checks.number("motion.spin_offset", self.spin_offset, "a number in [0, 1]")
        if not 0 <= offset <= 1:
            raise SceneError("motion.spin_offset", self.spin_offset, "a number in [0, 1]")

    @property
    def rigid(self) -> tuple[float, float, float]:
        """(vx, vy, spin)."""
        return self.vx, self.vy, self.spin


@dataclass(frozen=True, kw_only=True)
class Shift:
    """A shift in place (Cattaneo's problem): body 1 moves over body 2 by a small rigid motion.

    Parameters
    ----------
    ux, uy : float
        Rigid shift of body 1 over body 2 [length].
    rotation : float
        Its rotation about the z-axis [rad].
    Fx, Fy : float, optional
        Tangential force on body 1 in place of the shift of the same direction [force].
    """

    ux: float = 0.0
    uy: float = 0.0
    rotation: float = 0.0
    Fx: float | None = None
    Fy: float | None = None

    def __post_init__(self) -> None:
        _check_motion(self, "ux", "uy", "rotation")

    @property
    def rigid(self) -> tuple[float, float, float]:
        """(ux, uy, rotation)."""
        return self.ux, self.uy, self.rotation


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
        Exactly one of the two: compressive force [force; in line contact per unit length], or approach of the
        bodies [length].
    friction : float or array_like, shape (ny, nx), or (nx,) in line contact
        Coefficient of friction; a number (``inf``: no slip at all), or one number per element of an explicit
        grid. Needed where there is a motion.
    motion : Steady or Shift, optional
        None: normal contact only.
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
    friction: float | np.ndarray | None = None
    motion: Steady | Shift | None = None
    grid: Grid | Literal["auto"] = "auto"
    units: Units | None = None

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        _instance("bodies", self.bodies, (Bodies,))
        _instance("surface", self.surface, (Paraboloids, Ellipse, Cylinders, SampledDistance))
        if self.motion is not None:
            _instance("motion", self.motion, (Steady, Shift))
        if self.units is not None:
            _instance("units", self.units, (Units,))
        if not (isinstance(self.grid, str) and self.grid == "auto"):
            _instance("grid", self.grid, (Grid,), ' or "auto"')
        self._check_load()
        self._check_dimension()
        if self.friction is None:
            if self.motion is not None:
                raise SceneError("friction", None, "given where there is a motion (a number, inf, or an array)")
        elif not checks.is_array(self.friction):
            allowed = "zero or positive (inf: no slip)"
            f = checks.real("friction", self.friction, allowed)
            if f < 0:
                raise SceneError("friction", self.friction, allowed)
            set_(self, "friction", f)
        else:
            row = self.line and np.ndim(self.friction) == 1
            set_(self, "friction", checks.array("friction", np.atleast_2d(self.friction) if row else self.friction, 2))
            self._check_on_grid("friction", self.friction)
            if np.any(self.friction < 0):
                raise SceneError("friction", float(np.min(self.friction)), "zero or positive everywhere")
        if isinstance(self.surface, SampledDistance) and self.surface.x is None:
            self._check_on_grid("surface.h", self.surface.samples)

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
            object.__setattr__(self, "grid", Grid(nx=grid.nx, margin=grid.margin))
        if motion is not None and motion.rigid[2] != 0:
            name = "spin" if isinstance(motion, Steady) else "rotation"
            raise SceneError(f"motion.{name}", motion.rigid[2], "0 in line contact, where nothing depends on y")
        if surface.reference_depth is not None:
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

    def _check_load(self) -> None:
        if (self.normal_force is None) == (self.approach is None):
            which = "neither" if self.normal_force is None else "both"
            given = (self.normal_force, self.approach)
            raise SceneError("normal_force, approach", given, f"exactly one of the two ({which} given)")
        if self.normal_force is not None:
            object.__setattr__(self, "normal_force", checks.positive("normal_force", self.normal_force))
            return
        approach = checks.number("approach", self.approach)
        object.__setattr__(self, "approach", approach)
        least = float(self.surface.h.min()) if isinstance(self.surface, SampledDistance) else 0.0
        if approach <= least:
            raise NoContact("approach", approach, f"above the least undeformed distance, {least:.6g}: no contact")

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
    def hertz(self) -> HertzContact | None:
        """Hertz's solution where the surface is Hertzian, else None; a line contact is an ellipse with infinite b.

        The approach of a line contact is NaN where no reference depth is given.
        """
        load = {"force": self.normal_force, "approach": self.approach}
        if isinstance(self.surface, Cylinders):
            return _hertz_line(self.surface, self.bodies, **load)
        if isinstance(self.surface, Paraboloids):
            return hertz(self.surface.Rx, self.surface.Ry, self.bodies, **load)
        if isinstance(self.surface, Ellipse):
            return hertz_ellipse(self.surface.a, self.surface.b, self.bodies, **load)
        return None

    @property
    def frictionless(self) -> bool:
        """Whether no tangential traction can arise."""
        return self.motion is None or bool(np.all(np.asarray(self.friction) == 0))

    @property
    def no_slip(self) -> bool:
        """Whether friction is infinite."""
        return isinstance(self.friction, float) and math.isinf(self.friction)


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


def _check_motion(motion: Steady | Shift, along_x: str, along_y: str, about_z: str) -> None:
    for name in (along_x, along_y, about_z):
        object.__setattr__(motion, name, checks.number(f"motion.{name}", getattr(motion, name)))
    for force, rigid in (("Fx", along_x), ("Fy", along_y)):
        value = getattr(motion, force)
        if value is None:
            continue
        object.__setattr__(motion, force, checks.number(f"motion.{force}", value))
        if getattr(motion, rigid) != 0:
            raise SceneError(f"motion.{force}, motion.{rigid}", (value, getattr(motion, rigid)), "one of the two only")


def _modulus(field: str, value: Any) -> float:
    allowed = "a positive modulus (inf: rigid)"
    modulus = checks.real(field, value, allowed)
    if modulus <= 0:
        raise SceneError(field, value, allowed)
    return modulus


def _poisson(field: str, value: Any) -> float:
    allowed = "a Poisson's ratio in (-1, 0.5]"
    ratio = checks.number(field, value, allowed)
    if not -1 < ratio <= 0.5:
        raise SceneError(field, value, allowed)
    return ratio


def _pair(field: str, value: Any, check: Any) -> tuple[float, float]:
    """One value for both bodies, or a pair."""
    if checks.is_array(value):
        if len(value) != 2:
            raise SceneError(field, value, "one value, or a pair (upper, lower)")
        return check(f"{field}[0]", value[0]), check(f"{field}[1]", value[1])
    single = check(field, value)
    return single, single
