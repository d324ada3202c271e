"""Tractions from the results of CONTACT: its files ``<experiment>.<case>.mat``, which are tables in text.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech CMCC report 20-01, appendix A).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_geometry import counts, lattice
from varcontact.io.contact_words import MOST_BYTES, Group, number_of
from varcontact.machine.reading import text_of
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene

HEAD = 11
"""Lines before the table, a comment and numbers by turns."""
STATES = (0, 1, 2)
ROUNDED = 1e-3
"""By what part of an element positions in the file may be rounded."""


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
        IGS: 0 exterior, 1 stick, 2 slip.
    T : int
        Control digit: 0 no motion, 1 shift, 2 transient, 3 steady rolling.
    direction : int
        1 or -1: rolled towards positive or negative x.
    dq : float
        Step of rolling [mm].
    """

    grid: Grid
    pressure: np.ndarray
    traction: np.ndarray
    state: np.ndarray
    T: int
    direction: int
    dq: float

    def on(self, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """Traction and pressure, as `certify` takes them, if they are on the scene's elements and of its motion.

        Parameters
        ----------
        scene : Scene
            Of the same case: with an explicit grid, and creepages as CONTACT had, or found, them.

        Returns
        -------
        traction : ndarray, shape (2, ny, nx)
        pressure : ndarray, shape (ny, nx)

        Raises
        ------
        SceneError
            If elements or motion are not those of the scene.
        """
        grid = scene.grid
        if (
            not isinstance(grid, Grid)
            or not grid.explicit
            or grid.shape != self.grid.shape
            or grid.line != (self.grid.line)
        ):
            raise SceneError("scene.grid", grid, f"explicit, with the elements of the result: {self.grid}")
        away = max(float(np.abs(self.grid.x - grid.x).max()) / grid.sides[0],
                   0.0 if grid.line else float(np.abs(self.grid.y - grid.y).max()) / grid.sides[1])  # fmt: skip
        if away > ROUNDED:
            raise SceneError("scene.grid", grid, f"that of the result: {self.grid}")
        motion = scene.motion
        fits = isinstance(motion, Shift) if self.T == 1 else isinstance(motion, Steady) and self.T == 3
        if not fits:
            raise SceneError("scene.motion", motion, f"that of the result, which has T = {self.T}")
        if isinstance(motion, Steady) and (self.direction != 1 or not _same_step(motion, grid, self.dq)):
            step = f"of the result: dq = {self.dq:g}, towards {'positive' if self.direction == 1 else 'negative'} x"
            raise SceneError("scene.motion", motion, step)
        return self.traction, self.pressure


def _same_step(motion: Steady, grid: Grid, dq: float) -> bool:
    own = grid.sides[0] if motion.dq is None else motion.dq
    return abs(own - dq) <= ROUNDED * dq


def read_contact_result(path: str | Path) -> ContactResult:
    """Pressures and tractions of a case that CONTACT solved, from its file ``<experiment>.<case>.mat``.

    The file has no creepages: where forces were prescribed, put those that CONTACT found into the scene before it is
    certified.

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
    >>> folder.cleanup()
    """
    name = checks.file_name("path", path)
    lines = text_of("path", name, MOST_BYTES, "a result of CONTACT (text; MATLAB's own .mat files are something else)")
    head, rows = lines.splitlines()[:HEAD], lines.splitlines()[HEAD:]
    for k in range(HEAD):
        if k >= len(head) or head[k].strip().startswith("%") != (k % 2 == 0):
            what = "a comment" if k % 2 == 0 else "numbers"
            raise _wrong(name, k + 1, f"should be {what}: this is not the layout of the user guide, report 20-01")
    placed = _numbers(name, 6, head[5], 8)
    group = Group(str(name), 6, (), (), ())
    nx, ny = counts(group, placed[0], placed[1])
    x0, y0, dx, dy, angle, dq = placed[2:8]
    if not (dx > 0 and dy > 0):
        raise _wrong(name, 6, "has no positive DX and DY")
    grid, _ = lattice(group, nx, ny, dx, dy, x0, y0)
    fields = np.zeros((4, ny * nx))
    seen = np.zeros(ny * nx, dtype=bool)
    for number, row in enumerate(rows, HEAD + 1):
        if not row.strip():
            continue
        values = _numbers(name, number, row, 11)
        element = int(values[0]) - 1
        if values[0] != element + 1 or not 0 <= element < ny * nx or seen[element]:
            raise _wrong(name, number, f"has element {values[0]:g}: give each of 1 to {ny * nx} once at most")
        if values[1] not in STATES:
            raise _wrong(name, number, f"has IGS = {values[1]:g}; supported: 0 exterior, 1 stick, 2 slip")
        seen[element] = True
        fields[:, element] = values[1], values[4], values[5], values[6]
    if not np.any(fields[1]):
        raise _wrong(name, HEAD + 1, "should begin a table with pressures; write the file with A = 1 or 2")
    state, pressure, px, py = fields.reshape(4, ny, nx)
    T = int(_numbers(name, 8, head[7], 6)[0])
    direction = -1 if np.cos(angle) < 0 else 1
    return ContactResult(grid, pressure, np.stack([px, py]), state.astype(int), T, direction, dq)


def _numbers(path: Path, line: int, text: str, least: int) -> list[float]:
    """The numbers of a line; what CONTACT leaves out of a table is no number, and refused."""
    found = [number_of(word) for word in text.split()]
    numbers = [value for value in found if value is not None]
    if len(numbers) < least or len(numbers) < len(found):
        raise _wrong(path, line, f"should have {least} numbers or more")
    return numbers


def _wrong(path: Path, line: int, what: str) -> SceneError:
    return SceneError("path", str(path), message=f"{path}, line {line} {what}")
