"""Scenes from the input files of CONTACT, module 3: basic contacts, Hertzian or not.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech
CMCC report 20-01, chapters 2 and 4 and appendix A), see `contact_grammar`.
Lengths are in mm, forces in N.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_cases import CaseInput, read_cases
from varcontact.io.contact_elements import load_of, mirrored, ringed
from varcontact.io.contact_geometry import Geometry, geometry_of
from varcontact.io.contact_material import bodies_of, friction_of, layer_of, thermal_of
from varcontact.io.contact_methods import (
    check_methods,
    methods_of,
    simplified_theory_of,
    steps_by_elements,
)
from varcontact.io.contact_motion import (
    NO_MOTION,
    SHIFT,
    STEADY,
    TRANSIENT,
    Rolling,
    check_step,
    rigid_of,
    rolling_of,
    steady_of,
    step_of,
)
from varcontact.io.contact_scenes import ContactCase, scenes_of
from varcontact.io.contact_stresses import points_of
from varcontact.io.contact_words import located
from varcontact.scene.motion import Shift
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Paraboloids
from varcontact.scene.units import MM_N


class ContactInput(Sequence[Scene]):
    """The scenes of an input file of CONTACT, and all of its cases.

    Attributes
    ----------
    cases : tuple of ContactCase
        In the order of the file, but for those that it skips.
    path : str
    """

    def __init__(self, path: str, cases: Sequence[ContactCase]) -> None:
        self.path = path
        self.cases = tuple(cases)
        self._scenes = scenes_of(cases)

    @overload
    def __getitem__(self, k: int) -> Scene: ...
    @overload
    def __getitem__(self, k: slice) -> list[Scene]: ...
    def __getitem__(self, k: int | slice) -> Scene | list[Scene]:
        return self._scenes[k]

    def __len__(self) -> int:
        return len(self._scenes)

    @property
    def left_out(self) -> tuple[ContactCase, ...]:
        """The cases that have no scene, each with its reason."""
        return tuple(case for case in self.cases if case.reason)

    def __str__(self) -> str:
        """A report: how many cases there are, and why some have no scene."""
        lines = [f"{self.path}: {len(self.cases)} cases, {len(self.left_out)} of them left out"]
        lines += [f"case {case.number}: {case.reason}" for case in self.left_out]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"ContactInput({self.path!r}, {len(self.cases)} cases)"


@checks.named_options()
def read_contact_input(path: str | Path, *, strict: bool = True) -> ContactInput:
    """The cases of an input file of CONTACT, module 3, as scenes on the same elements.

    A sequence of cases that continue each other (P = 0 after a shift or
    transient rolling) becomes one scene, whose motion is a `Transient` with a
    step for each case. Everything else becomes a scene of its own, in the order
    of the file.

    Parameters
    ----------
    path : str or Path
        A file ``<experiment>.inp``.
    strict : bool
        Whether a case that has no counterpart here is an error. If False, it is
        left out, and so are those that go on from it; `ContactInput.left_out`
        and ``print`` tell which, and why.

    Returns
    -------
    ContactInput
        A sequence of scenes with explicit grids, in mm and N; `cases` has them
        one by one, with the methods that CONTACT solves them by.

    Raises
    ------
    SceneError
        If the file cannot be read, or asks for what has no counterpart here:
        with the line, the digit, its value, and those that are supported
        (docs/from_contact.md has all of them).

    Notes
    -----
    Undeformed distances (IBASE) are sampled at the centres of the elements, as CONTACT does.
    Hertzian contacts (IPOTCN < 0) stay Hertzian: `solve` gives them Hertz's pressure, as B = 2
    does, unless ``normal`` is another method. One row of elements (MY = 1) has a row without
    contact on each side; steady rolling towards negative x is mirrored.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import varcontact as vc
    >>> folder = tempfile.TemporaryDirectory()
    >>> path = pathlib.Path(folder.name) / "rolling.inp"
    >>> _ = path.write_text('''
    ...  3  MODULE
    ...   203100     P-B-T-N-F-S
    ...   022020     L-D-C-M-Z-E
    ...  0000541   H-G-I-A-O-W-R
    ...   999   100    30    1   1e-5           MAXGS, MAXIN, MAXNR, MAXOUT, EPS
    ...  82000.     0.000  -0.000625  0.000625  FN, CKSI, CETA, CPHI
    ...  0.300      0.300                       FSTAT, FKIN
    ...  0.000      0.400  30000.               CHI, DQ, VELOC
    ...  0.280      0.280  82000.  82000.       POISS 1,2, GG 1,2
    ...  -3                                     IPOTCN
    ...  44   44    8.000  4.000   1.100        MX, MY, AA, BB, SCALE
    ...  0  MODULE
    ... ''')
    >>> (scene,) = vc.read_contact_input(path)
    >>> scene.motion  # doctest: +NORMALIZE_WHITESPACE
    Steady(vx=0.0, vy=-0.000625, spin=0.000625, Fx=None, Fy=None, dq=0.4,
    spin_offset=0.16666666666666666, \
slip_difference='first-order', speed=None)
    >>> f"Fy = {vc.solve(scene).force[1]:.0f} N"
    'Fy = -15000 N'
    >>> folder.cleanup()
    """
    file = checks.file_name("path", path)
    inputs, unreadable = read_cases(file)
    readable = inputs
    if strict and unreadable:  # errors in earlier cases come first
        readable = [case for case in inputs if case.number < unreadable[0].number]
    cases = cases_of(readable, strict)
    if unreadable and (strict or not inputs):
        raise unreadable[0].error
    cases += [ContactCase(each.number, each.line, reason=str(each.error)) for each in unreadable]
    cases.sort(key=lambda case: case.number)
    if not cases:
        raise SceneError(
            "path", str(path), message=f"{path} holds no case that is to be calculated"
        )
    return ContactInput(str(path), cases)


def cases_of(inputs: Sequence[CaseInput], strict: bool) -> list[ContactCase]:
    """Scenes of all cases that are to be calculated."""
    made: dict[int, _Maker] = {}
    cases: list[ContactCase] = []
    for given in inputs:
        case = _Maker(given, made.get(given.before.number) if given.before else None)
        made[given.number] = case
        try:
            case.make()
        except SceneError as error:
            if strict:
                raise
            case.reason = str(error)
        if given.calculated:
            case.result = case.contact_case()
            cases.append(case.result)
    return cases


class _Maker:
    """Builder of the scene of a case; keeps what the next case reuses."""

    def __init__(self, given: CaseInput, before: _Maker | None) -> None:
        self.given = given
        self.before = before
        self.controls = given.controls
        self.reason = ""
        self.result: ContactCase | None = None
        self.scene: Scene | None = None
        self.methods: dict[str, Any] = {}
        self.mirrored = False
        self.continues: ContactCase | None = None
        self.force_parts: tuple[float, float | None] | None = None
        self.simplified: dict[str, Any] | None = None
        self.stress_points: tuple[np.ndarray, ...] = ()
        self.rolling = Rolling()
        self.geometry: Geometry | None = None

    def contact_case(self) -> ContactCase:
        """The result."""
        scene = self.scene
        if self.reason:
            scene = None
        return ContactCase(
            number=self.given.number,
            line=self.given.group.line,
            element=self.given.element,
            scene=scene,
            reason=self.reason,
            methods=self.methods,
            mirrored=self.mirrored,
            before=self.continues,
            force_parts=self.force_parts,
            simplified=self.simplified,
            stress_points=self.stress_points,
        )

    def make(self) -> None:
        """Build the scene; a `SceneError` names what is not supported."""
        if self.given.module != 3:
            why = (
                "is a wheel on a rail: vc.wheel_rail.read_contact_input reads it, "
                "and `varcontact wheelrail` solves it"
            )
            self.given.group.refuse("MODULE", self.given.module, why)
        self.controls.check_supported()
        geometry = self._read()
        if not self.given.calculated:
            return
        check_methods(self.given, geometry)
        self.methods = methods_of(self.given, geometry.surface)
        self.simplified = simplified_theory_of(self.given)
        self.stress_points = points_of(self.given.stress_points, geometry.grid)
        scene = self._scene(geometry)
        if self.rolling.direction < 0 and self.controls["TANG"] == STEADY:
            scene = mirrored(scene)
            self.mirrored = True
        if 1 in (geometry.grid.nx, geometry.grid.rows):
            scene = ringed(scene)
        self.scene = scene

    def _read(self) -> Geometry:
        """Bodies, rolling and elements, which the next case may reuse."""
        rolling = None
        geometry = None
        if self.before is not None:
            rolling = self.before.rolling
            geometry = self.before.geometry
        bodies = bodies_of(self.given)
        self.rolling = rolling_of(self.given, rolling)
        self.geometry = geometry_of(self.given, bodies, geometry)
        if steps_by_elements(self.given):
            self.rolling = replace(self.rolling, step=self.geometry.grid.sides[0])
        return self.geometry

    def _scene(self, geometry: Geometry) -> Scene:
        """Scene of the case by itself; a case that continues another starts without tractions
        here.
        """
        tang = self.controls["TANG"]
        load = geometry.load_of(self.given)
        parts: dict[str, Any] = {
            "bodies": geometry.bodies,
            "surface": geometry.surface,
            "grid": geometry.grid,
            "units": MM_N,
            "third_body": layer_of(self.given),
            "thermal": thermal_of(self.given),
        }
        if tang == NO_MOTION:
            if geometry.bodies.relaxes:
                self.controls.complain("TANG", "with viscoelastic bodies needs T = 3")
            return self._made(parts | load)
        self._check_continued(geometry)
        friction = friction_of(self.given, self.rolling.velocity, geometry.grid)
        rigid, self.force_parts = rigid_of(self.given, friction, geometry.bodies)
        if tang in (SHIFT, TRANSIENT):
            check_step(self.given, geometry.bodies)
        if tang == STEADY:
            parts["motion"] = steady_of(self.given, self.rolling, rigid, geometry)
        elif tang == SHIFT and self.continues is None:
            parts["motion"] = Shift(**rigid)
        else:
            step = step_of(self.given, self.rolling, rigid | load, friction)
            surface = self._unchanging(geometry)
            return self._made(parts | step | {"surface": surface})
        return self._made(parts | load | {"friction": friction})

    def _unchanging(self, geometry: Geometry) -> Any:
        """The surface by its curvatures, which must not change with the load of later steps."""
        if not isinstance(geometry.surface, Ellipse):
            return geometry.surface
        load = load_of(self.given)
        contact = Scene(bodies=geometry.bodies, surface=geometry.surface, **load).hertz
        assert contact is not None
        return Paraboloids(Rx=contact.Rx, Ry=contact.Ry)

    def _made(self, parts: dict[str, Any]) -> Scene:
        with located(self.given.group):
            return Scene(**parts)

    def _check_continued(self, geometry: Geometry) -> None:
        """Find the case that this one continues: P = 0 after a case that is calculated."""
        if self.controls["TANG"] == STEADY or self.controls["PVTIME"] == 2:
            return
        before = self.before
        while before is not None and not before.given.calculated:
            before = before.before
        if before is None:  # CONTACT starts without tractions in the first case
            return
        if self.controls["PVTIME"] == 1:
            if geometry.bodies.coupled:
                self.controls.complain("PVTIME", "is not supported with unlike bodies")
            return
        if before.reason:
            self.controls.complain("PVTIME", f"continues case {before.given.number}, left out")
        assert before.geometry is not None
        if before.geometry.bodies != geometry.bodies:
            why = "continues a case with other material, which is not supported"
            self.controls.complain("PVTIME", why)
        self.continues = before.result
        if self.controls["PVTIME"] == 3:
            self.continues = before.continues
