"""The answer: fields in physical units, forces, areas, and the certificate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import Certificate
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.stick_slip import EXTERIOR, PLASTIC, SLIP, STICK
from varcontact.elasticity.held import holding_loads
from varcontact.html import Reported
from varcontact.interfaces.heat import heating, surface_temperatures
from varcontact.results.error_estimate import ErrorEstimate
from varcontact.results.plan import Plan
from varcontact.scene.friction import FrictionBound, Law
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Motion, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surface_load import SurfaceLoad
from varcontact.scene.surfaces import along_axes
from varcontact.scene.transient import Transient
from varcontact.solvers.interface import Calls
from varcontact.system.files import check_ending
from varcontact.system.process import lazy_property, on_demand

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.gradients.gradient import EdgeName
    from varcontact.gradients.outputs import Output
    from varcontact.results.frequency import FrequencyResponse
    from varcontact.results.physical import Normalised

Panel = Literal[
    "pressure", "traction", "slip", "distance", "power_density", "temperature", "section"
]
"""Pictures of a solution."""
NEGATIVE_WORK_MIN = 1e-9
"""Part of the power from which on negative densities are more than rounding and tolerance."""


def _part(name: str, k: int, words: str) -> float:
    """A property, to type checkers the number that it has."""
    return cast("float", property(lambda sol: float(getattr(sol, name)[k]), doc=words))


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution(Reported):
    """A solved scene, in the scene's units. Arrays are indexed [iy, ix].

    By a theory `slip`, `power_density`, `distance` and the certificate are computed when they are
    first read.

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
        Relative slip of body 1 over body 2: slip velocity by rolling velocity
        [-]; in a shift, and a step that does not roll, the local shift
        [length]. Zero outside the contact.
    power_density : ndarray, shape (ny, nx)
        Frictional work per area: per distance rolled [force/area], in a shift
        [force/length]. In rolling the mean over a step (docs/theory.md),
        negative where the grid is too coarse, or a theory too rough, see
        `negative_work`.
    distance : ndarray, shape (ny, nx)
        Deformed distance at the elements' centres [length].
    state : int8 ndarray, shape (ny, nx)
        0 exterior, 1 stick, 2 slip, 3 plastic: a third body flows.
    approach : float
        Approach of the bodies [length]; NaN in line contact without a reference
        depth.
    creepage : tuple of float
        (vx, vy, spin); of a shift (ux, uy, rotation). NaN where it is not
        unique, and without contact.
    certificate : Certificate
    converged : bool
        Whether the tolerance was reached.
    iterations, status, solved_by : dict
        By problem: iterations, the solver's status, and the solver whose answer
        it is.
    timing : dict
        Seconds by stage, and in total.
    passes : tuple of (float, float)
        Relative change in each pass of a loop, and the residual after it.
    branch : str
        Under a law of friction: where the search began, "stick", "slip", a
        "solution" or a "history".
    calls : dict of dict of Calls
        By problem and solver: number of calls, iterations and seconds.
    note : str
        Remark on the certificate of a solution that was read from a file, see
        `varcontact.load`.
    warnings : tuple of str
        Plausibility warnings of the scene, see `Scene.doubts`, and faults that
        rule the solution: noise of a sampled surface.
    error_estimate : ErrorEstimate or None
        Estimated error against the continuum; forces are then those of the
        estimate, fields those of the grid.
    pressure_on_parts : ndarray, shape (ny rows, nx columns), or None
        Where elements at the edge count in part, see `Grid`: the pressure on
        equal parts of the elements [force/area].
    trace : xarray.Dataset or None
        Solved with ``trace=True``: the iterates of the solvers, see
        docs/programs.md; files do not keep it.
    carried : dict of ndarray
        Quantities that particles carry into the next step, by name: those of
        the interfaces, (..., ny, nx), as "weakening", the part of ``static -
        kinetic`` friction that they have lost by slip [-], or
        "plastic_displacement" [length] and "yield_stress" [force/area]; of
        viscoelastic bodies "memory", tractions that particles on and around the
        grid remember, (relaxations, 3, rows, columns) [force/area].

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.05), grid=vc.Grid(nx=12, ny=12))
    >>> sol = vc.solve(scene)
    >>> print(f"{sol.Fx:.4f} {sol.power:.5f} {sol.friction_work:.5f}")
    -0.1760 0.00880 0.00880
    >>> print(f"{sol.normalised.max_pressure:.2f}")
    1.48
    """

    scene: Scene
    grid: Grid
    plan: Plan
    pressure: np.ndarray
    traction: np.ndarray
    slip: on_demand[np.ndarray] = field(default=on_demand())
    power_density: on_demand[np.ndarray] = field(default=on_demand())
    distance: on_demand[np.ndarray] = field(default=on_demand())
    state: np.ndarray
    approach: float
    creepage: tuple[float, float, float]
    certificate: on_demand[Certificate] = field(default=on_demand())
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
    pressure_on_parts: np.ndarray | None = None
    trace: xr.Dataset | None = None
    carried: dict[str, np.ndarray] = field(default_factory=dict)

    @property
    def normal_force(self) -> float:
        """Total compressive force, by `error_estimate`, where it has one; in line contact all
        forces are by length.
        """
        return self._loads["normal_force"]

    @property
    def force(self) -> np.ndarray:
        """Total tangential force (Fx, Fy) on body 1 (116); by `error_estimate`, where there is
        one.
        """
        return np.array([self._loads["Fx"], self._loads["Fy"]])

    @property
    def moment(self) -> float:
        """Twisting moment Mz on body 1 about the origin (117), by `error_estimate`; NaN by a theory
        that has none.
        """
        return self._loads["Mz"] if self.plan.has_moment else np.nan

    @lazy_property
    def _loads(self) -> dict[str, float]:
        """Loads along the axes of the plane, and the largest pressure, by `error_estimate` where it
        has them.
        """
        traction, pressure = along_axes(self.scene.surface, self.grid, self.traction, self.pressure)
        along_x, along_y = traction
        about_z = self.grid.x[None, :] * along_y - self.grid.y[:, None] * along_x
        fields = {"normal_force": pressure, "Fx": along_x, "Fy": along_y, "Mz": about_z}
        loads = {name: field.sum() * self.grid.area for name, field in fields.items()}
        loads["peak_pressure"] = self.pressure.max()
        if self.error_estimate is not None:
            estimated = self.error_estimate.values
            loads = {name: estimated.get(name, value) for name, value in loads.items()}
        return {name: float(value) for name, value in loads.items()}

    @property
    def weakening(self) -> np.ndarray | None:
        """Part of ``static - kinetic`` that particles have lost by slip [-], (ny, nx), under a
        friction law with memory, else None; from `carried`.
        """
        return self.carried.get("weakening")

    @property
    def memory(self) -> np.ndarray | None:
        """Tractions that particles of viscoelastic bodies remember in a history [force/area], or
        None; from `carried`.
        """
        return self.carried.get("memory")

    @property
    def plastic(self) -> np.ndarray | None:
        """Plastic displacement [length] and yield stress [force/area] of a layer that yields, (3,
        ny, nx), or None; from `carried`.
        """
        if "yield_stress" not in self.carried:
            return None
        stress = self.carried["yield_stress"][None]
        return np.concatenate([self.carried["plastic_displacement"], stress])

    @property
    def friction(self) -> np.ndarray | None:
        """Coefficient that the law has at this slip, or its particles with a memory, (ny, nx); None
        without a law.
        """
        law = self.scene.friction
        if not isinstance(law, Law):
            return None
        if self.weakening is not None and (law.memory_distance > 0 or law.local):
            return np.asarray(law.static - self.weakening * (law.static - law.kinetic))
        slip = np.hypot(*self.slip) * (self.state == SLIP)
        warmth = None
        if law.warm and self.temperature is not None:
            warmth = self.temperature[0]
        places = np.meshgrid(self.grid.x, self.grid.y)
        return law.on(slip, warmth, self.pressure, *places)

    @property
    def temperature(self) -> np.ndarray | None:
        """Temperature of the surfaces of body 1 and body 2, (2, ny, nx), in steady rolling with
        thermal data, or None.

        In the contact it is the same of both; beside and behind it each has its own.
        """
        scene = self.scene
        if scene.thermal is None or scene.speed is None:
            return None
        heat = heating(scene, self.power_density) * scene.speed
        return surface_temperatures(
            heat, self.state != EXTERIOR, self.grid.sides[0], scene.speed, scene.thermal
        )

    Fx = _part("force", 0, "Tangential force on body 1 along x; in line contact per unit length.")
    Fy = _part("force", 1, "Tangential force on body 1 along y.")
    Mz = moment
    vx = _part("creepage", 0, "Longitudinal creepage, prescribed or found; of a shift ux [length].")
    vy = _part("creepage", 1, "Lateral creepage, prescribed or found; of a shift uy [length].")
    spin = _part("creepage", 2, "Spin creepage [1/length]; of a shift the rotation.")

    @property
    def max_pressure(self) -> float:
        """Largest pressure of an element, or mean over one, see `Grid`; by `error_estimate`, where
        there is one.
        """
        return self._loads["peak_pressure"]

    @property
    def normalised(self) -> Normalised:
        """Forces, creepages and the largest pressure without dimension."""
        from varcontact.results.physical import normalised

        return normalised(self)

    @property
    def traction_bound(self) -> np.ndarray:
        """g, shape (ny, nx): f pz, or what else the friction of the scene has; infinite in the
        contact without slip.
        """
        of_law = self.friction
        friction = self.scene.friction if of_law is None else of_law
        if isinstance(friction, FrictionBound):
            return friction.bound(self.pressure, *np.meshgrid(self.grid.x, self.grid.y))
        bound = np.zeros(self.grid.shape)
        if friction is not None:
            contact = self.pressure > 0
            coefficient = np.broadcast_to(np.asarray(friction), bound.shape)
            bound[contact] = coefficient[contact] * self.pressure[contact]
        return bound

    @property
    def states(self) -> dict[str, int]:
        """Numbers in `state` of the states that elements in contact can have, by name."""
        states = {"stick": STICK, "slip": SLIP}
        if self.plastic is not None:
            states["plastic"] = PLASTIC
        return states

    @property
    def elements(self) -> dict[str, int]:
        """Numbers of elements: contact, stick, slip; with a third body that yields also plastic."""
        numbers = {name: int(np.sum(self.state == state)) for name, state in self.states.items()}
        return {"contact": sum(numbers.values()), **numbers}

    @property
    def areas(self) -> dict[str, float]:
        """Areas of contact, stick and slip, of whole elements; in line contact per unit length:
        widths.
        """
        return {name: count * self.grid.area for name, count in self.elements.items()}

    @property
    def loads_beside(self) -> tuple[SurfaceLoad, ...]:
        """Loads beside the contact: those of the scene, and one for each prescribed displacement,
        of the tractions that hold it.
        """
        left, right, bottom, top = self.grid.box
        across = None
        if not self.grid.line:
            across = bottom, top
        contact = SurfaceLoad(
            x=(left, right), y=across, pressure=self.pressure, traction=self.traction
        )
        return (
            *(self.scene.loads or ()),
            *holding_loads(self.scene, right - left, [contact]),
        )

    @property
    def edges(self) -> dict[str, np.ndarray]:
        """Elements at the edge of the contact (1.4), bool (ny, nx) each: "leading" where particles
        enter, "trailing" where they leave, "neutral" beside; without rolling all are neutral.

        An element that is as short as the contact there is leading and trailing.
        """
        contact = np.pad(self.state != EXTERIOR, 1)
        inside = contact[1:-1, 1:-1]
        right = inside & ~contact[1:-1, 2:]
        left = inside & ~contact[1:-1, :-2]
        beside = np.zeros_like(inside)
        if not self.grid.line:
            beside = inside & ~(contact[:-2, 1:-1] & contact[2:, 1:-1])
        rolls = 0
        if self.motion is not None:
            rolls = self.motion.rolls
        if rolls == 0:
            nowhere = np.zeros_like(inside)
            return {"leading": nowhere, "trailing": nowhere, "neutral": right | left | beside}
        neutral = beside & ~(right | left)
        if rolls < 0:
            return {"leading": left, "trailing": right, "neutral": neutral}
        return {"leading": right, "trailing": left, "neutral": neutral}

    @property
    def contact(self) -> tuple[Grid, np.ndarray]:
        """Elements in contact: a grid, that of the elements or of their parts if pressures are, and
        bool on it.
        """
        if self.pressure_on_parts is None:
            return self.grid, self.state != EXTERIOR
        rows, columns = self.pressure_on_parts.shape
        ny, nx = self.grid.shape
        return self.grid.divided((rows // ny, columns // nx)), self.pressure_on_parts > 0

    @property
    def motion(self) -> Motion | None:
        """Motion of the scene."""
        assert not isinstance(self.scene.motion, Transient)
        return self.scene.motion

    @property
    def friction_work(self) -> float:
        """Work lost by friction, integral of `power_density`: per distance rolled [force], in a
        shift [force length].

        In steady rolling of elastic bodies that is `power`, to rounding; by `error_estimate`, where
        there is one. In a step of rolling it is the work put in less the change of the elastic
        energy. In place it is exact as long as all that slips goes on in its direction.
        """
        rolls = isinstance(self.motion, Steady) and not self.scene.bodies.relaxes
        if self.error_estimate is not None and rolls:
            return self.power
        return float(self.power_density.sum() * self.grid.area)

    @property
    def negative_work(self) -> float:
        """Sum of negative values of `power_density` by that of all [-]: an error of the grid, or of
        a rough theory.
        """
        negative = float(self.power_density[self.power_density < 0].sum())
        # no slip anywhere
        if negative == 0 or abs(negative) * self.grid.area < NEGATIVE_WORK_MIN * abs(self.power):
            return 0.0
        return negative / abs(float(self.power_density.sum()))

    @property
    def power(self) -> float:
        """Work that the rolling motion puts into the contact, per distance rolled [force]; in a
        shift [force length].

        ``-(Fx vx + Fy vy + Mz spin)`` and `rolling_resistance`. In steady rolling of elastic bodies
        friction loses all; viscoelastic ones lose the rest. Loads and held parts beside the contact
        put in their work as well. A shift, and a step of a history, also change the elastic energy.
        """
        from varcontact.results.physical import power_of_held_parts

        # each element has its frame
        by_element = getattr(self.motion, "rigid_slip", None) is not None
        if self.scene.conformal or by_element or self.scene.loaded:
            vx, vy, spin = self.creepage
            x, y = np.meshgrid(self.grid.x, self.grid.y)
            disc = discretise(self.scene, self.grid)
            rolled = 1.0
            if disc.step is not None:
                rolled = disc.step * disc.scales.length
            slip = disc.slip_of_elements / rolled + np.array([vx - spin * y, vy + spin * x])
            own = float(np.sum(self.traction * slip) * self.grid.area)
            return self.rolling_resistance + power_of_held_parts(self) - own
        loads = np.array([*self.force, self.moment])
        motion = np.array(self.creepage)
        moved = (loads != 0) & (motion != 0)  # NaN of one has no power where the other is zero
        return self.rolling_resistance - float(loads[moved] @ motion[moved])

    @property
    def rolling_resistance(self) -> float:
        """Work of the pressure per distance rolled [force]: a resistance of unlike or viscoelastic
        bodies.
        """
        from varcontact.results.physical import rolling_resistance

        return rolling_resistance(self)

    def report(self) -> str:
        """The solution in words, for people."""
        from varcontact.results.report import report

        return report(self)

    def __repr__(self) -> str:
        Fx, Fy = self.force
        entries = (
            f"normal_force={self.normal_force:.6g}",
            f"force=({Fx:.6g}, {Fy:.6g})",
            f"moment={self.moment:.6g}",
            f"residual={self.certificate.residual:.1e}",
        )
        return f"Solution({', '.join(entries)})"

    def to_xarray(self) -> xr.Dataset:
        """All fields with coordinates and units, and the forces, as a dataset."""
        from varcontact.io.solution import dataset

        return dataset(self)

    def to_dataframe(self) -> pd.DataFrame:
        """The fields as a table with one row per element, row of elements by row of elements;
        `attrs` has the units.
        """
        from varcontact.io.export import dataframe

        return dataframe(self)

    @checks.named_options()
    def save(self, path: str | Path, overwrite: bool = False) -> None:
        """Write a file in the format of its ending, whole or not at all.

        ``.nc`` (netCDF) holds everything, and `varcontact.load` reads it back. For other programs:
        ``.csv``, a row per element as `to_dataframe` has them; ``.vtu`` and ``.vti``, which
        ParaView reads; ``.mat``, MATLAB's. ``.html`` is the report as a web page, see `to_html`. A
        solution that is at `path` in the same format is replaced, any other file only with
        `overwrite`. OutputError for other endings, and if the file holds something else or cannot
        be written.
        """
        from varcontact.io.solution import save

        save(self, path, overwrite=overwrite)

    @checks.named_options()
    def to_html(self, path: str | Path, overwrite: bool = False) -> None:
        """Write the report as one web page, with picture and command; `path` (.html) and
        `overwrite` as of `save`.
        """
        check_ending("path", checks.file_name("path", path), ".html")
        self.save(path, overwrite=overwrite)

    def sensitivity(self) -> np.ndarray:
        """Derivatives of (Fx, Fy) by the creepages (vx, vy, spin), (2, 3):
        `gradient` with held areas, as an array.

        ``[[dFx/dvx, dFx/dvy, dFx/dspin], [dFy/dvx, ...]]`` [force; force
        length], with the stick and slip areas as they are; of a shift by (ux,
        uy, rotation). Where forces are prescribed, by the creepages they gave.
        Unlike bodies: with the change of the pressures. Line contact has no
        spin: zeros. SceneError as of `gradient`.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=1.0, nu=0.25), surface=vc.Ellipse(a=1.0, b=1.0),
        ...     normal_force=1.0, friction=0.3, motion=vc.Steady(vx=1e-6),
        ...     grid=vc.Grid(nx=16, ny=16))
        >>> print(vc.solve(scene).sensitivity().round(2) + 0.0)
        [[-4.33  0.    0.  ]
         [ 0.   -3.87 -1.56]]
        """
        from varcontact.gradients.gradient import sensitivity

        return sensitivity(self)

    @checks.named_options()
    def gradient(
        self,
        output: str | Output | Sequence[str | Output],
        by: str | Sequence[str],
        *,
        edge: EdgeName = "auto",
        error: bool | None = None,
    ) -> xr.Dataset:
        """Derivatives of outputs by inputs of the scene, each output from one
        transposed solve for all inputs.

        Parameters
        ----------
        output : str, Weighted or sequence of these
            "Fx", "Fy", "Mz", "normal_force", "approach", "peak_pressure",
            "contact_area" (by the dispersion of the pressure),
            "friction_work" (in steady rolling of like bodies T-gamma, with the
            moment by spin); "vx" or "vy" (of a shift "ux", "uy") that follow
            from a force; or a `Weighted` integral of pressure and tractions.
        by : str or sequence of str
            Numbers of the scene by their paths: "vx", "vy", "spin", "Fx",
            "Fy", "friction", "normal_force", "approach", "surface.Rx",
            "bodies.G", "bodies.nu.upper", "bodies.layers.0.G", "dq",
            "friction.half_velocity" of a law, "third_body.h"; of a step of a
            history its creepages, friction and load, with the steps before as
            they are; and fields (ny, nx): "distance", the undeformed distance at each
            element, and "friction" where it is given by elements.
        edge : {"auto", "held", "moving", "following"}
            What the edge of the contact does as an input changes. "held": the
            derivative of the discrete problem, exact while no element changes
            its state; in rolling, by load or shape, it scatters with the grid
            by tens of per cent. "following": the grid is stretched and shifted with
            the contact, as the continuum has it. "moving": tractions that enter
            at a moving leading edge are part of it, of like bodies. "auto", for
            outputs of tractions: "following" for load, surface and bodies,
            "moving" for "distance" in rolling, else "held"; for outputs of the
            pressure alone "held", but under Hertz's pressure in closed form
            "following". On periodic grids, and of steps, "following" is refused.
        error : bool, optional
            Also an estimate of the error of each number, ``<name>_error``: the
            difference to elements twice as large, which are solved for it; of a
            field by element, each with its share of that of the larger one. If
            not given, where the edge is "moving". Without it the dataset has
            the attribute "error", which says so.

        Returns
        -------
        xarray.Dataset
            A variable for each input, and "value", with ``units``; of several
            outputs along the dimension "output".

        Raises
        ------
        SceneError
            For outputs and inputs that the scene has not, or that are prescribed
            or follow from others; for solutions that are not converged, by
            theories, under laws of friction with a memory or by temperature,
            with third bodies that yield, of curved contacts, of steps of
            viscoelastic bodies, beside held parts, and in full slip under a
            prescribed force, where none is defined. In full slip under creepages
            it is that of the limit: zero along the slip, which forces turn with.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=1.0, nu=0.25), surface=vc.Ellipse(a=1.0, b=1.0),
        ...     normal_force=1.0, friction=0.3, motion=vc.Steady(vx=1e-6),
        ...     grid=vc.Grid(nx=16, ny=16))
        >>> slopes = vc.solve(scene).gradient(["Fx", "Fy"], by=("vx", "spin"))
        >>> print(f"{slopes.vx[0]:.2f} {slopes.spin[1]:.2f}")
        -4.33 -1.56
        """
        from varcontact.gradients.gradient import gradient

        return gradient(self, output, by, edge, error)

    @checks.named_options()
    def frequency_response(
        self, wave_number: float | Sequence[float] | np.ndarray
    ) -> FrequencyResponse:
        """Complex derivatives of the forces by creepages, load and roughness that swing as the
        contact rolls.

        `wave_number`, one or several, is ``k = omega/V`` [1/length], circular frequency by rolling
        velocity: from 0, where the derivatives by the creepages are `sensitivity`, to a wave of two
        elements. SceneError for others, without steady rolling of elastic bodies, and where
        `sensitivity` is refused.
        """
        from varcontact.results.frequency import frequency_response

        return frequency_response(self, wave_number)

    @checks.named_options()
    def plot(
        self,
        what: Panel | Sequence[Panel] | None = None,
        *,
        ax: Axes | None = None,
        figsize: tuple[float, float] | None = None,
        y: float | None = None,
    ) -> Figure:
        """Picture of the pressure, of tractions over stick and slip areas, and
        of a section along x.

        Of a line contact: the tractions within the traction bound, and below
        them the slip, both over the stick and slip areas. Without a motion: the
        pressure, and its section. Numbers are in MPa, mm and kN by their size
        where the scene's `units` are metric, else in its own.

        Parameters
        ----------
        what : str or sequence of str, optional
            Other panels: "pressure", "traction", "slip", "distance",
            "power_density", "temperature", "section".
        ax, figsize : matplotlib Axes, or pair of float, optional
            Where to draw one panel, or the size of a new figure [inch].
        y : float, optional
            Of the section [length]; the row with the largest pressure if not
            given.

        Returns
        -------
        matplotlib Figure
            Outside pyplot: a notebook shows it, ``savefig`` writes it; for a
            window give an `ax` of pyplot. SceneError for a panel that there is
            not, several panels in one `ax`, a size that is none, or a `y` off
            the grid.
        """
        from varcontact.plotting.solution import plot

        return plot(self, what, ax=ax, figsize=figsize, y=y)

    @checks.named_options()
    def section(
        self,
        y: float | None = None,
        *,
        ax: Axes | None = None,
        figsize: tuple[float, float] | None = None,
    ) -> Figure:
        """Picture of a section along x, the panel "section" of `plot`: `y`, `ax`, `figsize` and
        errors are its own.
        """
        return self.plot("section", ax=ax, figsize=figsize, y=y)

    def plot_passes(self) -> Figure:
        """Picture of how passes of a coupling loop, or under a law of friction, converged; refused
        without passes.
        """
        from varcontact.plotting.solution import plot_passes

        return plot_passes(self)

    def summary(self) -> dict[str, Any]:
        """Forces, counts, certificate and methods as ``varcontact solve --json`` prints them; None
        for what is not known.
        """
        from varcontact.results.report import summary

        return summary(self)
