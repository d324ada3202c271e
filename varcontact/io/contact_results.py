"""Tractions from the results of CONTACT: its files ``<experiment>.<case>.mat``,
which are tables in text.

The columns are found by their names, in the layout of the user guide
(Vollebregt, User guide for CONTACT, Vtech CMCC report 20-01, appendix A) as in
that of the open-source release of 2025 (the subroutine ``writmt`` of its
source).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_elements import ringed
from varcontact.io.contact_words import MOST_BYTES, Group, lattice, numbers_of_line, wrong_line
from varcontact.scene.bodies import Bodies
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.scene.units import MM_N
from varcontact.system.files import text_of

HEADER = ("MX", "MY", "XL", "YL", "DX", "DY", "CHI", "DQ", "T", "M", "GG1", "GG2", "POISS1")
COLUMNS = ("I", "IGS", "PN", "PX", "PY")
STATES = (0, 1, 2, 3)
OTHER_BODIES = {1: "viscoelastic", 4: "with an interfacial layer"}
"""Values of MATER for bodies other than elastic half-spaces; simplified theories (2, 3, 5) are
compared with half-spaces."""
ROUNDED = 1e-3
"""Rounding of numbers in the file: of positions relative to an element's side, of others
relative."""
LAYOUT = "this is not the layout of CONTACT's user guide"


@dataclass(frozen=True, eq=False)
class ContactResult:
    """One case as CONTACT solved it, in mm and N.

    Attributes
    ----------
    grid : Grid
        Potential contact.
    pressure : ndarray, shape (ny, nx)
        PN [N/mm^2], zero outside the contact.
    traction : ndarray, shape (2, ny, nx)
        PX and PY on body 1 [N/mm^2].
    state : ndarray, shape (ny, nx)
        IGS: 0 exterior, 1 stick, 2 slip, 3 plastic.
    T : int
        Control digit: 0 no motion, 1 shift, 2 transient, 3 steady rolling.
    direction : int
        1 or -1: rolled towards positive or negative x.
    dq : float
        Step of rolling [mm].
    values : dict of str to float
        The numbers above the table by CONTACT's names in capitals: GG1, POISS1,
        VELOC, FSTAT, X_CP(R), NPATCH, ...
    columns : dict of str to ndarray, shape (ny, nx)
        All columns of the table by CONTACT's names: H, MU, UN, UX, UY, SREL or
        SHFT, TAUCRT, TEMP1, ...; NaN at elements that are not in the file.
    """

    grid: Grid
    pressure: np.ndarray
    traction: np.ndarray
    state: np.ndarray
    T: int
    direction: int
    dq: float
    values: dict[str, float] = field(repr=False)
    columns: dict[str, np.ndarray] = field(repr=False)

    @property
    def normal_force(self) -> float:
        """FN [N]."""
        return float(self.pressure.sum() * self._area)

    @property
    def force(self) -> np.ndarray:
        """FX and FY on body 1, shape (2,) [N]."""
        return np.asarray(self.traction.sum(axis=(1, 2)) * self._area)

    @property
    def moment(self) -> float:
        """MZ on body 1 about the origin of the grid [N mm]."""
        px, py = self.traction
        y = self.grid.y[:, None]
        return float((self.grid.x * py - y * px).sum() * self._area)

    @property
    def _area(self) -> float:
        """Area of an element."""
        return self.values["DX"] * self.values["DY"]

    @checks.named_options()
    def scene(self, motion: Steady | Shift) -> Scene:
        """The problem as the file has it: elements, undeformed distance, bodies, friction, and the
        approach H + UN.

        The `motion`, Steady or Shift, has creepages or shifts as CONTACT prints them, see
        `read_contact_output`: about SPINXO, SPINYO. One row of elements has a row without
        contact on each side. Elements that the file leaves out (A = 1) are taken to be out of
        contact: nothing is known of the distance there. SceneError if the bodies are no elastic
        half-spaces, friction is not one coefficient (L = 0), or the file has no H, UN and MU.
        """
        self._check_elastic()
        lacking = {"H", "UN", "MU"} - self.columns.keys()
        if lacking:
            raise SceneError("columns", sorted(self.columns), f"with {', '.join(sorted(lacking))}")
        touching = self.pressure > 0
        friction = self.values.get("FSTAT", np.nan)
        spread = float(np.abs(self.columns["MU"][touching] - friction).max()) if self.T else 0.0
        if self.values.get("L") != 0 or spread > ROUNDED * friction:
            raise SceneError(
                "L (FRCLAW)", self.values.get("L"), "0, with the same MU at all elements"
            )
        h = self.columns["H"]
        approach = float((h + self.columns["UN"])[touching].mean())
        h = np.where(np.isnan(h), approach, h)
        load: dict[str, Any] = {"approach": approach}
        x, y = (self.values.get(name, 0.0) for name in ("SPINXO", "SPINYO"))
        if isinstance(motion, Steady):
            motion = replace(
                motion, dq=self.dq, vx=motion.vx + motion.spin * y, vy=motion.vy - motion.spin * x
            )
        else:
            motion = replace(
                motion, ux=motion.ux + motion.rotation * y, uy=motion.uy - motion.rotation * x
            )
        poisson = self.values["POISS1"]  # of simplified theories the only one in the file
        scene = Scene(
            bodies=Bodies(
                G=(self.values["GG1"], self.values["GG2"]),
                nu=(poisson, self.values.get("POISS2", poisson)),
            ),
            surface=SampledDistance(h),
            **load,
            friction=friction,
            motion=motion,
            grid=self.grid,
            units=MM_N,
        )
        if 1 in self.grid.shape:
            return ringed(scene)
        return scene

    def _check_elastic(self) -> None:
        M = int(self.values["M"])
        if M in OTHER_BODIES:
            message = (
                f"bodies: M = {M}, {OTHER_BODIES[M]}, cannot be certified; "
                "elastic half-spaces (M = 0) can"
            )
            raise SceneError("bodies", OTHER_BODIES[M], message=message)

    @checks.named_options()
    def on(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Traction (2, ny, nx) and pressure (ny, nx), as `certify` takes them, if they are those of
        a `scene`.

        It is of the same case, with an explicit grid, and creepages as CONTACT had, or found, them.
        SceneError if elements or motion are not those of the scene, or the bodies are no elastic
        half-spaces.
        """
        self._check_elastic()
        own = self.grid
        if 1 in own.shape:  # one row has a row without contact on each side, see `ringed`
            own = own.extended()
        self._check_grid(own, scene.grid)
        self._check_motion(scene)
        if own is self.grid:
            return self.traction, self.pressure
        return np.pad(self.traction, [(0, 0), (1, 1), (1, 1)]), np.pad(self.pressure, 1)

    def _check_grid(self, own: Grid, grid: Any) -> None:
        """Refuse other elements than those of the result."""
        explicit = f"explicit, with the elements of the result: {own}"
        if not isinstance(grid, Grid) or not grid.explicit:
            raise SceneError("scene.grid", grid, explicit)
        if (grid.shape, grid.line) != (own.shape, own.line):
            raise SceneError("scene.grid", grid, explicit)
        along_x = np.all(np.abs(own.x - grid.x) <= ROUNDED * grid.sides[0])
        along_y = np.all(np.abs(own.y - grid.y) <= ROUNDED * grid.sides[1])
        if not (along_x and along_y):
            raise SceneError("scene.grid", grid, f"that of the result: {own}")

    def _check_motion(self, scene: Scene) -> None:
        """Refuse another kind of motion, direction or step of rolling than the result has."""
        motion = scene.motion
        fits = {
            0: motion == Shift(),
            1: isinstance(motion, Shift),
            3: isinstance(motion, Steady),
        }
        if not fits.get(self.T, False):
            allowed = f"that of the result, which has T = {self.T}"
            if self.T == 0:
                allowed += ": Shift()"
            raise SceneError("scene.motion", motion, allowed)
        if not isinstance(motion, Steady):
            return
        # CONTACT's step of steady rolling is DX by default, and the file may have the DQ of the
        # input
        assert isinstance(scene.grid, Grid)
        dq = motion.dq or scene.grid.sides[0]
        steps = (self.dq, self.grid.sides[0])
        same_step = any(abs(dq - step) <= ROUNDED * step for step in steps)
        if self.direction != 1 or not same_step:
            side = "positive" if self.direction == 1 else "negative"
            allowed = f"of the result: dq = {self.dq:g}, towards {side} x"
            raise SceneError("scene.motion", motion, allowed)


@checks.named_options()
def read_contact_result(path: str | Path) -> ContactResult:
    """Pressures and tractions of a case that CONTACT solved, from its file
    ``<experiment>.<case>.mat``.

    The file has no creepages: where forces were prescribed, put those that
    CONTACT found into the scene before it is certified.

    Parameters
    ----------
    path : str or Path
        Written with A = 1 (elements in contact) or 2 (all).

    Returns
    -------
    ContactResult

    Raises
    ------
    SceneError
        If the file cannot be read, or is not of this layout: with the line.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "ball.0001.mat"
    >>> _ = path.write_text('''% Tim Sws Xw Yw
    ... 0 0 0 0
    ... % Xcp Ycp Zcp Deltcp
    ... 0 0 0 0
    ... % Mx My Xl Yl Dx Dy Chi Dq
    ... 3 2 -0.3 -0.2 0.2 0.2 0.0 0.2
    ... % T M Gg1 Gg2 Poiss1 Poiss2
    ... 3 0 200 200 0.42 0.42
    ... % L dum Veloc Fstat Fkin
    ... 0 0 1000 0.4 0.4
    ... % i Igs H Mu Pn Px Py Un Ux Uy SRel
    ... 2 1 0.0 0.4 4.0 -0.5 0.0 0.02 0.0 0.0 0.0
    ... 5 2 0.0 0.4 2.0 -0.8 0.0 0.02 0.0 0.0 0.001
    ... ''')
    >>> result = vc.read_contact_result(path)
    >>> result.pressure
    array([[0., 4., 0.],
           [0., 2., 0.]])
    >>> float(result.traction[0, 1, 1]), int(result.state[1, 1])
    (-0.8, 2)
    >>> result.scene(vc.Steady(vx=0.001)).approach
    0.02
    >>> folder.cleanup()
    """
    name = checks.file_name("path", path)
    text = text_of(
        "path",
        name,
        MOST_BYTES,
        "a result of CONTACT (text; MATLAB's own .mat files are something else)",
    )
    lines = text.splitlines()
    values, names, start = _header(name, lines)
    of_grid = next(number for number, line in enumerate(lines, 2) if "MX" in line.upper().split())
    group = Group(str(name), of_grid, (), ())
    nx, ny = (_count(group, name, values[name]) for name in ("MX", "MY"))
    x0, y0, dx, dy = (values[key] for key in ("XL", "YL", "DX", "DY"))
    if not (dx > 0 and dy > 0):
        raise wrong_line(name, group.line, "has no positive DX and DY")
    grid = lattice(group, nx, ny, (dx, dy), (x0, y0))
    table = _table(name, lines, start, names, ny * nx)
    columns = dict(zip(names, table.reshape(-1, ny, nx), strict=True))
    pressure, px, py, state = (np.nan_to_num(columns[key]) for key in ("PN", "PX", "PY", "IGS"))
    if not np.any(pressure):
        raise wrong_line(
            name, start + 1, "should begin a table with pressures; write the file with A = 1 or 2"
        )
    if not text.endswith("\n"):
        raise wrong_line(
            name,
            len(lines),
            "has no end: the file was cut short, or its last line break taken away",
        )
    direction = -1 if np.cos(values["CHI"]) < 0 else 1
    T = int(values["T"])
    return ContactResult(
        grid,
        pressure,
        np.stack([px, py]),
        state.astype(int),
        T,
        direction,
        values["DQ"],
        values,
        columns,
    )


def _count(group: Group, name: str, count: float) -> int:
    """MX or MY as a whole number."""
    if count != int(count) or count < 1:
        group.refuse(name, count, "is not a number of elements")
    return int(count)


def _table(path: Path, lines: list[str], start: int, names: list[str], size: int) -> np.ndarray:
    """Columns of the table by element, (names, size), which begins at a line; NaN at elements that
    are not in it.
    """
    table = np.full((len(names), size), np.nan)
    for number, row in enumerate(lines[start:], start + 1):
        if not row.strip():
            continue
        numbers = dict(zip(names, numbers_of_line(path, number, row, len(names)), strict=False))
        element = int(numbers["I"]) - 1
        within = numbers["I"] == element + 1 and 0 <= element < size
        if not within or np.isfinite(table[0, element]):
            words = f"has element {numbers['I']:g}: give each of 1 to {size} once at most"
            raise wrong_line(path, number, words)
        if numbers["IGS"] not in STATES:
            words = f"has IGS = {numbers['IGS']:g}; supported: 0, 1, 2, 3"
            raise wrong_line(path, number, words)
        table[:, element] = list(numbers.values())
    return table


def _header(path: Path, lines: list[str]) -> tuple[dict[str, float], list[str], int]:
    """Numbers above the table by their names, with the line of the grid's; the table's columns, and
    where it begins.
    """
    values: dict[str, float] = {}
    for k in range(0, len(lines) + 1, 2):
        if k >= len(lines) or not lines[k].strip().startswith("%"):
            raise wrong_line(path, k + 1, f"should be a comment: {LAYOUT}")
        names = re.split(r"[,\s]+", lines[k].strip(" %\t").upper())
        if names[:2] == list(COLUMNS[:2]):
            lacking = [name for name in HEADER if name not in values] + [
                name for name in COLUMNS if name not in names
            ]
            if lacking:
                raise wrong_line(
                    path, k + 1, f"begins the table without {', '.join(lacking)}: {LAYOUT}"
                )
            return values, names, k + 1
        if k + 1 >= len(lines) or lines[k + 1].strip().startswith("%"):
            raise wrong_line(path, k + 2, f"should be numbers: {LAYOUT}")
        named = [place for place, name in enumerate(names) if name != "-"]
        numbers = numbers_of_line(path, k + 2, lines[k + 1], len(named))
        values |= {names[place]: numbers[place] for place in named if place < len(numbers)}
    raise AssertionError("a file ends")
