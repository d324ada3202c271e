"""The scene of a user: bodies, surface, load, friction, motion, grid. Each class checks itself when
made.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import (
    TYPE_CHECKING,
    Any,
    ClassVar,
    Generic,
    Literal,
    Required,
    TypedDict,
    Unpack,
    overload,
)

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError, shortened
from varcontact.html import in_rows, preformatted
from varcontact.reference.hertz import HertzContact, hertz, hertz_ellipse
from varcontact.reference.line_contact import line_contact
from varcontact.scene import consistency, plausibility
from varcontact.scene.bodies import Bodies, Body, BodyPair, as_bodies, loaded_alone
from varcontact.scene.friction import FrictionBound, Law, coefficient
from varcontact.scene.friction_laws import kind_of
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Edge, Grid, usual_grid
from varcontact.scene.interface import Thermal, ThirdBody
from varcontact.scene.motion import Harmonic, Motion, Steady, TimeStep
from varcontact.scene.pin import PinInHole
from varcontact.scene.surface_displacement import SurfaceDisplacement, as_displacements
from varcontact.scene.surface_load import SurfaceLoad, as_loads
from varcontact.scene.surfaces import (
    Ellipse,
    Paraboloids,
    SampledDistance,
    Surface,
    depth_of,
    is_curved,
)
from varcontact.scene.transient import Transient
from varcontact.scene.units import Units
from varcontact.system.process import changed, lazy_property

if TYPE_CHECKING:
    from typing_extensions import TypeVar  # of the type checker's own: TypeVar with a default

    MotionT_co = TypeVar(
        "MotionT_co", bound=Motion | Harmonic | Transient | None, default=Any, covariant=True
    )
else:
    from typing import TypeVar

    MotionT_co = TypeVar("MotionT_co", covariant=True)

_NO_MOTION: Any = None  # of every type of motion, for type checkers


class _Entries(TypedDict, total=False):
    """Entries of a scene beside its motion, for type checkers."""

    bodies: Required[BodyPair | Body | GivenBodies | tuple[Body | str, Body | str]]
    surface: Required[Surface]
    normal_force: float | None
    approach: float | None
    friction: float | np.ndarray | Law | None
    third_body: ThirdBody | None
    thermal: Thermal | tuple[Thermal, Thermal] | None
    grid: Grid | Literal["auto"]
    loads: SurfaceLoad | Sequence[SurfaceLoad] | None
    displacements: SurfaceDisplacement | Sequence[SurfaceDisplacement] | None
    units: Units | None


@dataclass(frozen=True, eq=False, kw_only=True)
class Scene(checks.Checked, Generic[MotionT_co], approach=checks.number):
    """A contact as the user describes it, in any consistent units.

    Parameters
    ----------
    bodies : Bodies, Layered, Graded, Viscoelastic or a pair (upper, lower)
        Half-spaces by their elastic constants, or bodies of other kinds: one
        that both are of, or a pair, in which a half-space is ``Bodies(G, nu)``
        and a rigid body "rigid".
    surface : Paraboloids, Ellipse, Cylinders, PinInHole or SampledDistance
        Undeformed distance.
    normal_force, approach : float
        Exactly one of the two (in a history at most): compressive force [force;
        in line contact per unit length], or approach of the bodies [length].
    friction : float, law or array_like, shape (ny, nx), or (nx,) in line contact
        Coefficient of friction; a number (``inf``: no slip at all), a law
        (`StaticKinetic`, `LinearFalling`, `RationalFalling`,
        `ExponentialFalling`, `TemperatureFalling`, `PressureFalling`,
        `FrictionLaw`), a traction bound (`ShearStrength`, `CarriedFriction`),
        or one number per element of an explicit grid. Needed where there is a
        motion.
    third_body : ThirdBody, optional
        A layer between the bodies, which shears and yields.
    thermal : Thermal or pair (upper, lower), optional
        Thermal data of both bodies, of one kind or two: steady rolling then has
        a speed, a history times of its steps.
    motion : Steady, Shift, Transient or Harmonic, optional
        None: normal contact only. A history (`Transient`) may give load,
        friction and surface of its steps itself.
    grid : Grid or "auto"
        The potential contact and its elements; ``"auto"``: chosen by `solve`
        for an accuracy, 1 % if none is given; where that cannot be (see
        `solve`), 24 elements across the contact either way, 100 in line
        contact.
    loads : SurfaceLoad or sequence of SurfaceLoad, optional
        Tractions that are prescribed beside the contact.
    displacements : SurfaceDisplacement or sequence of SurfaceDisplacement, optional
        Displacements that are prescribed beside the contact.
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
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(vx=1e-3),
    ...     grid=vc.Grid(nx=24, ny=24))
    >>> print(f"{scene.hertz.a * 1e3:.2f} x {scene.hertz.b * 1e3:.2f} mm")
    7.35 x 5.53 mm
    """

    _words: ClassVar = {
        **dict.fromkeys(("FN", "fn", "Fz", "N"), "normal_force"),
        **dict.fromkeys(("pen", "penetration"), "approach"),
        **dict.fromkeys(("mu", "fstat", "f"), "friction"),
        **{name: f"motion=Steady({name}=...)" for name in ("vx", "vy", "spin")},
        "material": "bodies",
        "geometry": "surface",
    }
    bodies: Bodies | BodyPair | GivenBodies
    surface: Surface
    normal_force: float | None = None
    approach: float | None = None
    friction: float | np.ndarray | Law | FrictionBound | None = None
    third_body: ThirdBody | None = None
    thermal: tuple[Thermal, Thermal] | None = None
    motion: MotionT_co = _NO_MOTION
    grid: Grid | Literal["auto"] = "auto"
    loads: tuple[SurfaceLoad, ...] | None = None
    displacements: tuple[SurfaceDisplacement, ...] | None = None
    units: Units | None = None

    if TYPE_CHECKING:  # without a motion it is a Scene[None]

        @overload
        def __init__(
            self: Scene[None], *, motion: None = None, **entries: Unpack[_Entries]
        ) -> None: ...
        @overload
        def __init__(self, *, motion: MotionT_co, **entries: Unpack[_Entries]) -> None: ...
        def __init__(self, **entries: Any) -> None: ...

    def __post_init__(self) -> None:
        set_ = object.__setattr__
        set_(self, "bodies", as_bodies(self.bodies))
        set_(self, "loads", as_loads(self.loads))
        set_(self, "displacements", as_displacements(self.displacements))
        thermal: Any = self.thermal
        if isinstance(thermal, list | tuple):
            set_(self, "thermal", tuple(thermal))
        elif thermal is not None:
            set_(self, "thermal", (thermal, thermal))
        consistency.check_classes(self)
        super().__post_init__()
        if self.normal_force is not None:
            check = checks.positive
            if isinstance(self.motion, TimeStep):  # a step may be without contact
                check = checks.at_least_zero
            set_(self, "normal_force", check("normal_force", self.normal_force))
        if checks.is_array(self.friction):
            dimensions = [2]
            if self.line:
                dimensions = [1, 2]
            friction = checks.array("friction", self.friction, *dimensions)
            set_(self, "friction", np.atleast_2d(friction))
        elif self.friction is not None:
            set_(self, "friction", coefficient("friction", self.friction))
        if self.line and isinstance(self.grid, Grid) and not self.grid.line:
            if self.grid.ny != 1:
                raise SceneError("grid.ny", self.grid.ny, "left out in line contact")
            set_(self, "grid", replace(self.grid, ny=None))
        consistency.check(self)

    @property
    def line(self) -> bool:
        """True for a line contact, in plane strain."""
        return self.surface.line

    @property
    def force_is_sum(self) -> bool:
        """True where a prescribed normal force is the sum of the pressures: on a plane."""
        return self.normal_force is None or not self.conformal

    @lazy_property
    def loaded(self) -> bool:
        """True where tractions act beside the contact, or displacements are prescribed."""
        return bool(self.displacements) or any(load.loaded.any() for load in self.loads or ())

    def loads_as(self, other: Scene[Any]) -> bool:
        """True where loads and displacements beside the contact are those of another scene.

        Parameters
        ----------
        other : Scene
        """
        return self.loads is other.loads and self.displacements is other.displacements

    def same_normal_contact(self, other: Scene[Any]) -> bool:
        """True where bodies, surface and load are those of another scene, also beside the contact.

        Parameters
        ----------
        other : Scene
        """
        same_load = self.normal_force == other.normal_force and self.approach == other.approach
        same_bodies = self.bodies is other.bodies and self.surface is other.surface
        return same_load and same_bodies and self.loads_as(other)

    @lazy_property
    def raised(self) -> bool:
        """True where loads beside the contact change the undeformed distance, or prescribed
        displacements the response to pressures.
        """
        held = self.displacements or ()
        if (self.coupled and held) or any("z" in each.components for each in held):
            return True
        along = [2]
        if self.bodies.coupled:
            along = [0, 1, 2]
        return any(load.acts(*along) or load.acts_alone for load in self.loads or ())

    @lazy_property
    def conformal(self) -> bool:
        """True where the bodies meet on a curved surface, see `SampledDistance`."""
        return is_curved(self.surface)

    @lazy_property
    def coupled(self) -> bool:
        """True where pressure and tractions depend on each other: of unlike bodies, in conformal
        contact, and beside a part of one body alone that is held.
        """
        return self.bodies.coupled or self.conformal or self._coupled_by_held_parts

    @property
    def _coupled_by_held_parts(self) -> bool:
        """True where the tractions that hold a part of one body follow pressures and tractions."""
        if isinstance(self.bodies, GivenBodies):
            return False
        held = {each.body for each in self.displacements or ()}
        return any(loaded_alone(self.bodies, body).coupled for body in held)

    @property
    def difference(self) -> str:
        """The reason why pressure and tractions are coupled or not."""
        if self.conformal:
            return "a curved reference surface"
        if self._coupled_by_held_parts and not self.bodies.coupled:
            return "a part of one body that is held"
        if isinstance(self.bodies, Bodies):
            return f"K = {self.bodies.K:.3g}"
        if isinstance(self.bodies, GivenBodies) and self.bodies.coupled:
            return "coupled by their compliance"
        if self.bodies.coupled:
            return "of different materials"
        return "alike"

    @property
    def reference_depth(self) -> float | None:
        """Reference depth of displacements in line contact, if it is given."""
        return depth_of(self.surface)

    @property
    def speed(self) -> float | None:
        """Rolling velocity, where something depends on it."""
        if isinstance(self.motion, Steady):
            return self.motion.speed
        return None

    @property
    def periodic(self) -> bool | str:
        """Axes that bodies and surface repeat along, see `Grid`."""
        return self.own_grid.periodic

    @lazy_property
    def approach_undetermined(self) -> bool:
        """True where the approach is determined up to a constant only: in line contact without a
        depth or fixed bases.
        """
        if self.periodic == "x" and not self.line:
            return True
        at_rest = self.bodies.grounded or self.periodic
        return self.line and self.reference_depth is None and not at_rest

    @property
    def shift_undetermined(self) -> bool:
        """True where tangential displacements are determined up to a constant only: like the
        approach, and on a frictionless base.
        """
        return self.approach_undetermined or self.bodies.slides

    @property
    def edge(self) -> str:
        """The elements at the contact's edge that belong to it, see `Grid`; "centres" where the
        grid is "auto".
        """
        if isinstance(self.grid, Grid):
            return self.grid.edge
        return "centres"

    def second_order(self) -> Scene:
        """Copy of a scene of steady rolling, discretised for accurate forces on coarse grids
        instead of as CONTACT does.

        ``Steady(slip_difference="second-order")`` with the spin offset that
        goes with it, and ``Grid(edge="softened")`` where tractions do not
        change the pressure, but for samples without coordinates; without a
        grid, 24 by 24 elements. See docs/sampling.md.

        Returns
        -------
        Scene

        Raises
        ------
        SceneError
            If it is not of steady rolling.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=1.0, nu=0.25), surface=vc.Ellipse(1.0, 1.0), normal_force=1.0,
        ...     friction=0.3, motion=vc.Steady(vx=0.05), grid=vc.Grid(nx=16, ny=16))
        >>> print(f"{vc.solve(scene).force[0]:.4f} {vc.solve(scene.second_order()).force[0]:.4f}")
        -0.1743 -0.1659
        """
        if not isinstance(self.motion, Steady):
            raise SceneError(
                "motion", self.motion, "Steady: only its slip is a difference in space"
            )
        edge: Edge = "softened"
        if consistency.why_centres(self):
            edge = "centres"
        return replace(
            self, motion=self.motion.second_order(), grid=replace(self.own_grid, edge=edge)
        )

    @property
    def own_grid(self) -> Grid:
        """Grid as given, or the usual one."""
        if isinstance(self.grid, Grid):
            return self.grid
        return usual_grid(self.line)

    @property
    def without_friction(self) -> Scene:
        """Copy without tractions (no friction, no motion); viscoelastic bodies go on rolling."""
        scene: Scene[Any] = self
        if scene.bodies.relaxes:
            return changed(scene, motion=Steady(speed=scene.speed), friction=0.0)
        return changed(scene, motion=None, friction=None)

    @lazy_property
    def hertz(self) -> HertzContact | None:
        """Hertz's solution where surface, bodies and load allow it, else None; a line contact has
        an infinite b.
        """
        bodies = self.bodies
        surface = self.surface
        approach = self.approach
        if not isinstance(bodies, Bodies) or isinstance(surface, PinInHole | SampledDistance):
            return None
        if self.raised:
            return None
        if not self.normal_force and (approach is None or approach <= 0):
            return None  # a step without contact, or loads of the steps alone
        load = {"force": self.normal_force, "approach": approach}
        if isinstance(surface, Paraboloids):
            return hertz(surface.Rx, surface.Ry, bodies, **load)
        if isinstance(surface, Ellipse):
            return hertz_ellipse(surface.a, surface.b, bodies, **load)
        depth = surface.reference_depth
        contact = line_contact(surface.R, bodies, **load, depth=depth)
        if approach is None:
            approach = math.nan
            if depth is not None:
                approach = contact.approach(depth)
        return HertzContact(
            a=contact.a,
            b=math.inf,
            approach=approach,
            force=contact.force,
            peak_pressure=contact.peak_pressure,
            Rx=surface.R,
            Ry=math.inf,
        )

    @property
    def fresh(self) -> dict[str, float]:
        """Values of carried quantities that fresh particles have, where these are not zero."""
        if self.third_body is None:
            return {}
        return {"yield_stress": self.third_body.tau_c0}

    @property
    def frictions(self) -> list[float | np.ndarray | Law | FrictionBound | None]:
        """Distinct coefficients of friction; a history may have several."""
        if not isinstance(self.motion, Transient) or self.motion.friction is None:
            return [self.friction]
        of_steps = self.motion.friction
        if not isinstance(of_steps, Sequence):
            return [of_steps]
        different: dict[int, float | np.ndarray | Law | FrictionBound | None]
        different = {id(friction): friction for friction in of_steps}
        if id(None) in different:
            different[id(None)] = self.friction
        return list(different.values())

    @property
    def largest_coefficient(self) -> float | np.ndarray | None:
        """Largest ratio of friction to pressure, if it is known beforehand; else None."""
        friction = self.friction
        if friction is None or isinstance(friction, FrictionBound):
            return None
        if isinstance(friction, Law):
            return friction.static
        return friction

    @property
    def kind_of_friction(self) -> str:
        """The kind of its law, "given" of numbers and known bounds; "several" of a history."""
        if not self.under_law:
            return "given"
        kinds = {kind_of(friction) for friction in self.frictions}
        if len(kinds) > 1:
            return "several"
        return kinds.pop()

    @property
    def kind_of_bodies(self) -> str:
        """The kind of the pair of bodies: "quasi-identical", "unlike" or "conformal"."""
        if self.conformal:
            return "conformal"
        if self.coupled:
            return "unlike"
        return "quasi-identical"

    @lazy_property
    def under_law(self) -> bool:
        """True where the coefficient of friction follows a law, in some step of a history."""
        return any(isinstance(f, Law) for f in self.frictions)

    @lazy_property
    def warm(self) -> bool:
        """True where friction depends on the temperature of the surfaces."""
        return any(isinstance(f, Law) and f.warm for f in self.frictions)

    @property
    def bare(self) -> bool:
        """True for bodies in direct contact, without a layer that shears."""
        return self.third_body is None

    @property
    def without_layer(self) -> Scene:
        """Copy with nothing but friction between the bodies."""
        return replace(self, third_body=None)

    @property
    def layer_compliance(self) -> float:
        """Elastic shear displacement of a layer between the bodies, by traction; zero without."""
        if self.third_body is None:
            return 0.0
        return self.third_body.compliance

    @property
    def yield_stress_changes(self) -> bool:
        """True where what lies between the bodies hardens or softens as it flows."""
        return self.third_body is not None and self.third_body.k_tau != 0

    @property
    def flows(self) -> bool:
        """True where what lies between the bodies flows below the friction bound."""
        return self.third_body is not None and self.third_body.yields

    @property
    def hardens(self) -> bool:
        """True where a third body hardens in steady rolling: its yield stress depends on the whole
        solution.
        """
        return (
            isinstance(self.motion, Steady)
            and self.third_body is not None
            and self.third_body.k_tau > 0
        )

    @property
    def first_order(self) -> bool:
        """True where errors fall with the first power of the elements' size: what hardens, or how
        friction falls behind the leading edge, is settled within an element.
        """
        laws = [each for each in self.frictions if isinstance(each, Law)]
        return self.hardens or any(law.memory_distance > 0 for law in laws)

    @property
    def surfaces(self) -> list[Surface]:
        """Surface of the scene, in a history one for each step."""
        if isinstance(self.motion, Transient) and self.motion.surface is not None:
            return list(self.motion.surface)
        return [self.surface]

    @lazy_property
    def frictionless(self) -> bool:
        """True where no tangential traction can arise."""
        return self.motion is None or not any(
            _has_friction(friction) for friction in self.frictions
        )

    @lazy_property
    def no_slip(self) -> bool:
        """True where friction is infinite."""
        return all(isinstance(f, float) and math.isinf(f) for f in self.frictions)

    def contact(self, k: int) -> tuple[Surface, float | None, float | None]:
        """The contact in step `k` of a history, from 0: surface, normal force, approach (one of the
        two is None).
        """
        motion = self.motion
        assert isinstance(motion, Transient)
        force = motion.of("normal_force", k)
        approach = motion.of("approach", k)
        if force is None and approach is None:
            force = self.normal_force
            approach = self.approach
        surface = self.surface
        if motion.surface is not None:
            surface = motion.surface[k]
        if isinstance(surface, Ellipse):  # its curvatures are those under the scene's own load
            assert isinstance(self.bodies, Bodies)
            ellipse = hertz_ellipse(
                surface.a, surface.b, self.bodies, force=self.normal_force, approach=self.approach
            )
            surface = Paraboloids(ellipse.Rx, ellipse.Ry)
        return surface, force, approach

    def step(self, k: int, grid: Grid) -> Scene:
        """The scene of step `k` of a history, from 0, on the explicit `grid` of the history."""
        motion = self.motion
        assert isinstance(motion, Transient)
        surface, force, approach = self.contact(k)
        friction = motion.of("friction", k)
        if friction is None:
            friction = self.friction
        if isinstance(friction, FrictionBound):
            friction = friction.at_step(grid, motion.position(k, grid.sides[0]))
        history: Scene = self  # of any motion, as the step has another
        if motion.heights:
            assert not isinstance(surface, Ellipse)
            at = motion.position(k, grid.sides[0])
            distance = surface.distance(grid) - sum(each.on(grid, at) for each in motion.heights)
            if grid.line:
                distance = distance[0]
            surface = SampledDistance(distance, reference_depth=self.reference_depth)
        load: dict[str, Any] = {"normal_force": force, "approach": approach}
        moving = motion.step(k, grid.sides[0])
        # the history's own checks are those of its steps
        return changed(
            history, **load, surface=surface, friction=friction, motion=moving, grid=grid
        )

    @lazy_property
    def doubts(self) -> tuple[str, ...]:
        """Plausibility warnings: likely mistakes, with their figures. `solve`
        warns of them by `PlausibilityWarning`; plans, reports and
        `Solution.warnings` have them, too.

        A modulus softer or stiffer than solids are in the units named, Young's
        modulus in its place, or pascals beside lengths in millimetres; a
        contact of half a radius of curvature; a creepage above 0.1, friction
        above 2, a spin that turns the contact's edge faster than the bodies
        roll; samples that look upside down.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=82e9, nu=0.28), normal_force=106.7e3,
        ...     surface=vc.Paraboloids(Rx=460.0, Ry=300.0))
        >>> scene.doubts
        ('G = 8.2e+10 looks like pascals, a radius of 300 like millimetres',)
        """
        return plausibility.warnings_of(self)

    def _repr_html_(self) -> str:
        entries = [(each.name, getattr(self, each.name)) for each in fields(self)]
        rows = [(name, shortened(value, 200)) for name, value in entries if value is not None]
        rows += [("WARNING", doubt) for doubt in self.doubts]
        return preformatted(in_rows("Scene", rows))

    __repr__ = checks.short_entries

    def to_toml(self) -> str:
        """The scene as the text of a scene file, which `read_scene` takes back.

        Raises
        ------
        SceneError
            For a history with a start, which is a solution, and a scene too
            large for a scene file.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=82e9, nu=0.28), normal_force=106.7e3,
        ...     surface=vc.Paraboloids(Rx=0.46, Ry=0.30))
        >>> print(scene.to_toml(), end="")
        # Written by varcontact
        normal_force = 106700.0
        grid = "auto"
        <BLANKLINE>
        [bodies]
        G = 82000000000.0
        nu = 0.28
        <BLANKLINE>
        [surface]
        kind = "paraboloids"
        Rx = 0.46
        Ry = 0.3
        """
        from varcontact.io.scene_toml import scene_text

        return scene_text(self)

    @checks.named_options()
    def save(self, path: str | Path, overwrite: bool = False) -> None:
        """Write a scene file, which `read_scene` and the command line read; whole or not at all.

        A scene file that varcontact wrote at `path`, which ends in ``.toml``, is replaced, any
        other file only with `overwrite`. OutputError if the file cannot be written or holds
        something else; SceneError as `to_toml`.
        """
        from varcontact.io.scene_toml import save_scene

        save_scene(self, path, overwrite)


def _has_friction(friction: float | np.ndarray | Law | FrictionBound | None) -> bool:
    """True of friction that is not zero everywhere."""
    if isinstance(friction, np.ndarray):
        return bool(np.any(friction != 0))
    return friction != 0
