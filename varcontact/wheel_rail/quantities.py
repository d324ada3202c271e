"""The table of quantities of wheels on rails: results, reports, tables, sweeps and pictures are
made from it.

A new quantity is one entry of `QUANTITIES`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from varcontact.results.error_estimate import with_bar

if TYPE_CHECKING:
    from varcontact.wheel_rail.wear_depth import PatchWear

Owner = Literal["axle", "wheel", "patch"]
Picture = Literal["positions", "sweep"]

KEYS = ("position", "side", "patch")
"""Columns that say which patch a row is of."""
TEXTS = ("outcome", "reason", "warnings")
"""Columns with texts about the solution of a case."""
WORDS = ("side", *TEXTS, "identity")
"""Columns that are no numbers."""


@dataclass(frozen=True)
class InReport:
    """The words on a quantity in the report of a patch.

    Attributes
    ----------
    line, place : int
        Quantities of the same line are separated by commas, those of the same
        place in the order of the table.
    words : str
        With ``{}`` for the value and its error bar.
    form : str
        Format of a value without an error bar.
    factor : float
        From the unit of the table to that of the words.
    """

    line: int
    words: str
    form: str = ".6g"
    factor: float = 1.0
    place: int = 0

    def filled(self, value: float, error: float) -> str:
        """The words with a `value`, and its `error` bar if it has one."""
        if error > 0:
            return self.words.format(with_bar(value * self.factor, error * self.factor))
        return self.words.format(format(value * self.factor, self.form))


@dataclass(frozen=True)
class Panel:
    """The panel of a quantity in pictures of many positions.

    Attributes
    ----------
    label : str
        With the unit that is shown.
    factor : float
        From the unit of the table to that of the label.
    positions, sweep : int, optional
        Place among the panels of the picture; not in it if not given.
    """

    label: str
    factor: float = 1.0
    positions: int | None = None
    sweep: int | None = None


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A quantity of a wheel on a rail.

    Attributes
    ----------
    name : str
        Name of its column.
    patch : callable, optional
        Its value by a `PatchSolution`, or by the `FastPatch` of an estimate.
    exact : callable, optional
        In its place, where an estimate has no value: by the `PatchWear` of an
        exact solution. If it is of an axle, by the solution; of a wheel, by the
        solution of the wheel set and the side.
    of : {"patch", "wheel", "axle"}
        Owner of the quantity: that of an axle is the same in all rows.
    unit : str
        Empty if it has none.
    of_sets : bool
        Whether tables of wheel sets alone have it.
    error : callable, optional
        Its estimated error, by the `PatchWear`.
    error_column : str
        Column with that error, if the table has it.
    report : InReport, optional
    printed : int, optional
        Place among the columns that the command line prints.
    panel : Panel, optional
    """

    name: str
    patch: Callable[[Any], Any] | None = None
    exact: Callable[..., Any] | None = None
    of: Owner = "patch"
    unit: str = ""
    of_sets: bool = False
    error: Callable[[PatchWear], Any] | None = None
    error_column: str = ""
    report: InReport | None = None
    printed: int | None = None
    panel: Panel | None = None

    def of_patch(self, worn: PatchWear) -> float:
        """The value of a patch of an exact solution, by its wear `worn`."""
        if self.patch is not None:
            return float(self.patch(worn.solved))
        return self.of_solution(worn)

    def of_solution(self, *solution: Any) -> float:
        """The value by `exact`, of a `solution`, and a side."""
        assert self.exact is not None
        return float(self.exact(*solution))

    def in_words(self, patch: PatchWear) -> str:
        """The words of the report, with the value of a `patch`."""
        assert self.report is not None
        error = math.nan
        if self.error is not None:
            error = float(self.error(patch))
        return self.report.filled(self.of_patch(patch), error)


def _pitch_rate(found: Any) -> float:
    rate = found.velocity.pitch_rate
    if rate is None:
        rate = -found.velocity.speed / found.case.wheelset.radius
    return float(rate)


def _wear_depth(worn: PatchWear) -> float:
    if worn.archard is None:
        return math.nan
    return float(worn.depth.max())


def _utilised(patch: Any) -> float:
    Fx, Fs, FN = patch.force
    return math.hypot(Fx, Fs) / FN


def _local_traction(worn: PatchWear) -> float:
    solution = worn.solved.solution
    largest = (solution.traction**2).sum(axis=0).max() ** 0.5
    return float(largest / solution.pressure.max())


MODES = ("surface flow", "subsurface ratchetting", "alternating plasticity")
"""Modes of shakedown limits; in tables by their number, from 1."""


def _of_shakedown(value: Callable[[Any], float]) -> Callable[[PatchWear], float]:
    """A value of the shakedown limit; NaN without a yield stress."""

    def exact(worn: PatchWear) -> float:
        if worn.shakedown is None:
            return math.nan
        return value(worn.shakedown)

    return exact


def _wear_volume(worn: PatchWear) -> float:
    if worn.archard is None:
        return math.nan
    return worn.volume


QUANTITIES: tuple[Quantity, ...] = (
    # place of the axle, as it is found
    Quantity(name="y", of="axle", unit="mm", exact=lambda found: found.position.y, printed=1),
    Quantity(name="roll", of="axle", unit="rad", exact=lambda found: found.position.roll),
    Quantity(name="yaw", of="axle", unit="rad", exact=lambda found: found.position.yaw),
    Quantity(name="z", of="axle", unit="mm", exact=lambda found: found.z),
    # place of the patch, in the track and on the profiles
    Quantity(
        name="location_x",
        unit="mm",
        patch=lambda patch: patch.location[0],
    ),
    Quantity(
        name="location_y",
        unit="mm",
        patch=lambda patch: patch.location[1],
        report=InReport(1, "at y = {} mm"),
    ),
    Quantity(
        name="location_z",
        unit="mm",
        patch=lambda patch: patch.location[2],
    ),
    Quantity(
        name="angle",
        unit="rad",
        patch=lambda patch: patch.angle,
        report=InReport(1, "angle {}", ".4g"),
        printed=4,
        panel=Panel("Contact angle [mrad]", 1e3, positions=3, sweep=6),
    ),
    Quantity(
        name="on_rail",
        unit="mm",
        patch=lambda patch: patch.on_rail[0],
        printed=2,
        panel=Panel("Contact on the rail, y [mm]", positions=1),
    ),
    Quantity(
        name="on_wheel",
        unit="mm",
        patch=lambda patch: patch.on_wheel[0],
        printed=3,
        panel=Panel("Contact on the wheel, y [mm]", positions=2),
    ),
    Quantity(
        name="rolling_radius",
        unit="mm",
        patch=lambda patch: patch.rolling_radius,
        panel=Panel("Rolling radius [mm]", positions=4),
    ),
    # creepages
    Quantity(
        name="vx",
        patch=lambda patch: patch.creepage.vx,
        printed=5,
        panel=Panel("Longitudinal creepage [10⁻³]", 1e3, positions=5),
    ),
    Quantity(
        name="vy",
        patch=lambda patch: patch.creepage.vy,
        printed=6,
        panel=Panel("Lateral creepage [10⁻³]", 1e3, positions=6),
    ),
    Quantity(
        name="spin",
        unit="1/mm",
        patch=lambda patch: patch.creepage.spin,
        printed=7,
        panel=Panel("Spin [1/m]", 1e3, positions=7),
    ),
    # forces on the rail, in the frame of the patch and along the track
    Quantity(
        name="FN",
        unit="N",
        patch=lambda patch: patch.force[2],
        error=lambda worn: worn.solved.error[2],
        error_column="error_FN",
        report=InReport(2, "FN = {} kN", factor=1e-3, place=1),
        printed=8,
        panel=Panel("Normal force [kN]", 1e-3, positions=8),
    ),
    Quantity(
        name="Fx",
        unit="N",
        patch=lambda patch: patch.force[0],
        error=lambda worn: worn.solved.error[0],
        error_column="error_Fx",
        report=InReport(2, "Fx = {} kN", factor=1e-3),
        printed=9,
        panel=Panel("Longitudinal force [kN]", 1e-3, positions=9),
    ),
    Quantity(
        name="Fs",
        unit="N",
        patch=lambda patch: patch.force[1],
        error=lambda worn: worn.solved.error[1],
        error_column="error_Fs",
        report=InReport(2, "Fs = {} kN", factor=1e-3),
        printed=10,
        panel=Panel("Lateral force [kN]", 1e-3, positions=10),
    ),
    Quantity(
        name="Mz",
        unit="N mm",
        patch=lambda patch: patch.moment,
    ),
    Quantity(
        name="track_Fx",
        unit="N",
        patch=lambda patch: patch.force_on_track[0],
        error_column="error_track_Fx",
        panel=Panel("Longitudinal force [kN]", 1e-3, sweep=1),
    ),
    Quantity(
        name="track_Fy",
        unit="N",
        patch=lambda patch: patch.force_on_track[1],
        error_column="error_track_Fy",
        panel=Panel("Lateral force [kN]", 1e-3, sweep=2),
    ),
    Quantity(
        name="track_Fz",
        unit="N",
        patch=lambda patch: patch.force_on_track[2],
        error_column="error_track_Fz",
        panel=Panel("Vertical force [kN]", 1e-3, sweep=3),
    ),
    Quantity(
        name="utilised",
        patch=_utilised,
        report=InReport(2, "tangential force {} of FN", ".3g", place=2),
    ),
    Quantity(
        name="local_traction",
        exact=_local_traction,
        report=InReport(2, "traction up to {} of the largest pressure", ".3g", place=3),
    ),
    # stress, energy and wear
    Quantity(
        name="peak_pressure",
        unit="N/mm2",
        patch=lambda patch: patch.peak_pressure,
        error=lambda worn: worn.solved.peak_pressure_error,
        report=InReport(1, "largest pressure {} N/mm^2", ".4g"),
        printed=11,
        panel=Panel("Peak pressure [MPa]", positions=11, sweep=4),
    ),
    Quantity(
        name="area",
        unit="mm2",
        patch=lambda patch: patch.area,
    ),
    Quantity(
        name="T_gamma",
        unit="N",
        patch=lambda patch: patch.t_gamma,
        error=lambda worn: worn.t_gamma_error,
        error_column="T_gamma_error",
        panel=Panel("T-gamma [N]", positions=12, sweep=5),
    ),
    Quantity(
        name="power",
        unit="W",
        patch=lambda patch: patch.friction_power,
    ),
    Quantity(name="wear_depth", unit="mm", exact=_wear_depth),
    Quantity(name="wear_volume", unit="mm3/mm", exact=_wear_volume),
    # shakedown of the rail, with a yield stress
    Quantity(name="shakedown_lower", exact=_of_shakedown(lambda limit: limit.lower)),
    Quantity(name="shakedown_upper", exact=_of_shakedown(lambda limit: limit.upper)),
    Quantity(
        name="shakedown_mode", exact=_of_shakedown(lambda limit: MODES.index(limit.mode) + 1.0)
    ),
    # estimated errors against the continuum
    Quantity(name="error_Fx", unit="N", exact=lambda worn: worn.solved.error[0]),
    Quantity(name="error_Fs", unit="N", exact=lambda worn: worn.solved.error[1]),
    Quantity(name="error_FN", unit="N", exact=lambda worn: worn.solved.error[2]),
    # wheel sets
    Quantity(name="pitch_rate", of="axle", of_sets=True, unit="rad/s", exact=_pitch_rate),
    Quantity(name="imbalance", of="axle", of_sets=True, exact=lambda found: found.imbalance),
    Quantity(
        name="Y_over_Q", of="wheel", of_sets=True, exact=lambda found, side: found.y_over_q(side)
    ),
    Quantity(name="nadal", of="wheel", of_sets=True, exact=lambda found, side: found.nadal(side)),
    Quantity(name="T_gamma_error", of_sets=True, unit="N", exact=lambda worn: worn.t_gamma_error),
)
"""All quantities, in the order of the columns of tables, in mm, N, rad, N/mm^2 and W."""


def quantities_of(owner: Owner, of_sets: bool) -> list[Quantity]:
    """Quantities of patches, wheels or axles that tables of wheels, or `of_sets`, have."""
    return [each for each in QUANTITIES if each.of == owner and (of_sets or not each.of_sets)]


def columns(of_sets: bool) -> tuple[str, ...]:
    """Names of the columns of a table of wheels, or of wheel sets."""
    names = [each.name for each in QUANTITIES if of_sets or not each.of_sets]
    return (*KEYS, *TEXTS, *names, "identity")


def printed_columns() -> tuple[str, ...]:
    """Names of the columns that the command line prints."""
    places = {each.name: each.printed for each in QUANTITIES if each.printed is not None}
    return ("position", "side", *sorted(places, key=places.__getitem__))


def panels_of(picture: Picture) -> list[Quantity]:
    """The quantities that have a panel in a picture, in their order there."""
    places = {}
    for each in QUANTITIES:
        place = None
        if each.panel is not None:
            place = each.panel.positions if picture == "positions" else each.panel.sweep
        if place is not None:
            places[place, each.name] = each
    return [places[key] for key in sorted(places)]


def axle_values(found: Any, of_sets: bool) -> dict[str, float]:
    """Quantities of the axle of a solution."""
    return {each.name: each.of_solution(found) for each in quantities_of("axle", of_sets)}


def wheel_values(found: Any, side: str, of_sets: bool) -> dict[str, float]:
    """Quantities of a wheel on a `side` in a solution."""
    return {each.name: each.of_solution(found, side) for each in quantities_of("wheel", of_sets)}


def exact_values(worn: PatchWear) -> dict[str, float]:
    """Quantities of a patch of an exact solution."""
    return {each.name: each.of_patch(worn) for each in quantities_of("patch", of_sets=True)}


def fast_values(patch: Any) -> dict[str, float]:
    """Quantities of a patch of an estimate; NaN those that it has not."""
    found = {}
    for each in quantities_of("patch", of_sets=True):
        found[each.name] = math.nan
        if each.patch is not None:
            found[each.name] = float(each.patch(patch))
    return found


def report_lines(worn: PatchWear) -> list[str]:
    """The words on a patch in a report, line by line."""
    lines: dict[int, list[str]] = {}
    reported = [(each.report.line, each.report.place, each) for each in QUANTITIES if each.report]
    for line, _, quantity in sorted(reported, key=lambda entry: entry[:2]):
        lines.setdefault(line, []).append(quantity.in_words(worn))
    return [", ".join(words) for words in lines.values()]
