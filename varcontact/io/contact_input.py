"""Scenes from the input files of CONTACT, module 3: basic contacts, Hertzian or not.

The format is that of the user guide (Vollebregt, User guide for CONTACT, Vtech
CMCC report 20-01, chapters 2 and 4 and appendix A), see `contact_grammar`.
Lengths are in mm, forces in N.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, overload

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.io.contact_cases import CaseInput, read_cases
from varcontact.io.contact_elements import (
    distance_of,
    elements_of,
    hertzian,
    mirrored,
    prescribed_pressure,
    ringed,
    sampled,
)
from varcontact.io.contact_material import (
    bodies_of,
    friction_of,
    kept,
    kept_law,
    layer_of,
    own_elasticity,
    thermal_of,
)
from varcontact.io.contact_stresses import points_of
from varcontact.io.contact_words import Group, located
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import Ellipse, Paraboloids
from varcontact.scene.transient import Transient
from varcontact.scene.units import MM_N

NO_MOTION, SHIFT, TRANSIENT, STEADY = range(4)
CONVEX_GS = 2
"""The control digit G of the one solver of CONTACT that takes any DQ in steady rolling."""
INITIAL_SLIP = {2: ("relaxation", 2), 3: ("relaxation", 2), 4: ("initial slip", 0)}
"""Where INISLP is, by the digit G."""
SLIP_LAWS = (2, 3, 4)
"""Laws by slip velocity, values of the digit L."""
THEORIES = {2: "fastsim-elliptic", 3: "fastsim"}
"""Theories of M = 2 and 3 by the digit B."""


@dataclass(frozen=True, eq=False)
class ContactCase:
    """A case of an input file of CONTACT.

    Attributes
    ----------
    number, line : int
        Of the case in the file, from 1, and of its first line.
    element : tuple of int
        The result element that it belongs to, where one is given.
    scene : Scene or None
        None where it cannot be had here.
    reason : str
        Why not, with line and digit; empty where there is a scene.
    methods : dict
        Arguments of `solve` with which it is solved as CONTACT does.
    mirrored : bool
        Whether the scene is the case with x to -x: steady rolling towards
        negative x.
    before : ContactCase or None
        The case whose tractions it goes on from.
    force_parts : tuple of float or None
        Fx and Fy as parts of the normal force, where that is not known before
        the pressure is.
    simplified : dict or None
        How CONTACT's simplified theory is asked for, see
        `varcontact.theories.fastsim_contact.SimplifiedTheory`.
    stress_points : tuple of ndarray, shape (3, points)
        x, y and z of the blocks of points at which stresses are asked for.
    """

    number: int
    line: int
    element: tuple[int, ...] = ()
    scene: Scene | None = None
    reason: str = ""
    methods: dict[str, Any] = field(default_factory=dict)
    mirrored: bool = False
    before: ContactCase | None = None
    force_parts: tuple[float | None, float | None] | None = None
    simplified: dict[str, Any] | None = None
    stress_points: tuple[np.ndarray, ...] = ()


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
        self._scenes = _scenes(cases)

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
    if strict and unreadable:  # what is wrong before comes first
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
    """All cases that are to be calculated, as scenes."""
    made: dict[int, _Case] = {}
    cases: list[ContactCase] = []
    for given in inputs:
        case = _Case(given, made.get(given.before.number) if given.before else None)
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


class _Case:
    """A case on its way to a scene, and what the next one keeps of it."""

    def __init__(self, given: CaseInput, before: _Case | None) -> None:
        self.given = given
        self.before = before
        self.controls = given.controls
        self.entries = given.entries
        self.reason = ""
        self.result: ContactCase | None = None
        self.scene: Scene | None = None
        self.methods: dict[str, Any] = {}
        self.mirrored = False
        self.continues: ContactCase | None = None
        self.force_parts: tuple[float | None, float | None] | None = None
        self.simplified: dict[str, Any] | None = None
        self.stress_points: tuple[np.ndarray, ...] = ()
        # direction, step and velocity; a shift lasts a second
        self.rolling = (1, 0.0, 1.0)
        self.spin_offset: float | None = None
        # under a prescribed pressure
        self.approach: float | None = None

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
        """Make the scene; a `SceneError` says what has no counterpart."""
        if self.given.module != 3:
            why = (
                "is a wheel on a rail: vc.wheel_rail.read_contact_input reads it, "
                "and `varcontact wheelrail` solves it"
            )
            self.given.group.refuse("MODULE", self.given.module, why)
        self.controls.check_supported()
        self.bodies = bodies_of(self.given)
        self._roll()
        self._place()
        if self._steps_by_elements:
            direction, _, velocity = self.rolling
            # kept by the next case
            self.rolling = (direction, self.grid.sides[0], velocity)
        if not self.given.calculated:
            return
        self._choose_methods()
        self.stress_points = points_of(self.given.stress_points, self.grid)
        scene = self._scene()
        if self.rolling[0] < 0 and self.controls["TANG"] == STEADY:
            scene = mirrored(scene)
            self.mirrored = True
        if 1 in (self.grid.nx, self.grid.rows):
            scene = ringed(scene)
        self.scene = scene

    @property
    def _steps_by_elements(self) -> bool:
        """True where CONTACT steps by DX, whatever DQ says: in steady rolling, but for one
        solver.
        """
        solver = self._solver()
        steady = self.controls["TANG"] == STEADY and self.given.calculated
        return steady and (solver is None or solver.controls["GAUSEI"] != CONVEX_GS)

    def _roll(self) -> None:
        """Direction, step and velocity of rolling, given or kept."""
        if not self.controls.rolls:
            return
        if "rolling" not in self.given.given:
            if self.before is None or not self.before.controls.rolls:
                why = "needs CHI, DQ and VELOC, which the case before does not give: use C = 2"
                self.controls.complain("TANG", why)
            self.rolling = self.before.rolling
            self.spin_offset = self.before.spin_offset
            return
        group: Group = self.entries["rolling"]
        angle = group.angle(0)
        dq = group.number(1)
        velocity = group.number(2)
        for direction in (1, -1):
            if abs(np.cos(angle) - direction) < 1e-3 and dq > 0 and velocity > 0:
                self.rolling = (direction, dq, velocity)
                break
        else:
            allowed = "must be 0 or 180d, and two positive numbers"
            group.refuse("CHI, DQ, VELOC", (angle, dq, velocity), allowed)
        if group.optional:
            self.spin_offset = group.option(0, 0.0)

    def _place(self) -> None:
        """Elements and undeformed distance."""
        kind, _ = self.given.needs("elements", "DISCNS", "the elements", "D = 2")
        (ipotcn,) = kind.integers()
        bound = self.controls["BOUND"]
        if bound >= 2 and ipotcn > 0:
            self.controls.complain("BOUND", "needs a Hertzian contact, IPOTCN < 0")
        if ipotcn > 0:
            self.grid = elements_of(self.given)
            self.bodies = own_elasticity(self.given, self.grid) or self.bodies
            self.given.needs("distance", "RZNORM", "an undeformed distance", "Z = 2")
            h = distance_of(self.given, self.grid)
            with located(self.entries["distance"][0]):
                self.surface: Any = sampled(h, self.grid, **self._inclination())
            return
        own = {4: "a conformal contact", 9: "influence numbers of a file"}
        if kept(self.given, "INFLCF", 1) in own:
            of = own[kept(self.given, "INFLCF", 1)]
            kind.refuse("IPOTCN", ipotcn, f"of {of} is not supported")
        if self._prescribes(ipotcn):
            self.surface, self.grid, self.approach = prescribed_pressure(self.given, self.bodies)
            return
        if self._keeps_hertz(ipotcn):
            assert self.before is not None
            self.surface = self.before.surface
            self.grid = self.before.grid
            return
        self.surface, self.grid = hertzian(self.given, self.bodies, self._load())

    def _prescribes(self, ipotcn: int) -> bool:
        """True where B prescribes a pressure that is not that of Hertz's contact."""
        bound = self.controls["BOUND"]
        if bound == 1 and ipotcn < 0:
            self.controls.complain("BOUND", "needs a contact by its distance, IPOTCN > 0")
        theory = self.controls["MATER"] in (2, 3, 5)
        if ipotcn >= -3:
            return bound == 3 and not theory
        if ipotcn == -6:
            theory = self.controls["MATER"] == 5
        allowed: tuple[int, ...] = (2, 3)
        if ipotcn == -6:
            allowed = (4,)
        if bound not in allowed or self.controls["NORM"] == 0 or theory:
            why = f"needs B = {' or '.join(map(str, allowed))}, N = 1, and no simplified theory"
            self.entries["elements"][0].refuse("IPOTCN", ipotcn, why)
        return True

    def _keeps_hertz(self, ipotcn: int) -> bool:
        """True where the elements are those of the case before, and so is the surface."""
        before = self.before
        if self.controls["DISCNS"] != 0 or before is None or not hasattr(before, "grid"):
            return False
        same = (before.bodies, before._load()) == (self.bodies, self._load())
        if ipotcn == -3 and not same:
            why = "keeps the semi-axes for another load or material, which is not clear: use D = 2"
            self.controls.complain("DISCNS", why)
        return True

    def _inclination(self) -> dict[str, Any]:
        """Angles of the rows in conformal contact."""
        if "conformal" not in self.entries or kept(self.given, "INFLCF", 1) != 4:
            return {}
        head, pairs = self.entries["conformal"]
        if head.integers()[1] != 4:
            why = "is not reciprocal, and not supported; supported: 4"
            head.refuse("VARIANT", head.integers()[1], why)
        places = [pairs.angle(k) for k in range(0, len(pairs.values), 2)]
        angles = [pairs.angle(k) for k in range(1, len(pairs.values), 2)]
        if np.any(np.diff(places) <= 0):
            pairs.refuse("Y", places[0], "does not ascend in the surface's inclinations")
        return {"inclination": np.interp(self.grid.y, places, angles)}

    def _scene_load(self) -> dict[str, Any]:
        """The load of the scene: under a prescribed pressure the approach that goes with it."""
        if self.approach is not None:
            return {"approach": self.approach}
        return self._load()

    def _load(self) -> dict[str, Any]:
        load = self.entries["kinematics"].number(0)
        if self.controls["NORM"] == 0:
            return {"approach": load}
        return {"normal_force": load}

    def _choose_methods(self) -> None:
        """The methods of `solve` by which CONTACT solves it."""
        bound = self.controls["BOUND"]
        material = self.controls["MATER"]
        if isinstance(self.surface, Ellipse | Paraboloids) and bound == 0:
            self.methods["normal"] = "newton"
        if kept_law(self.given) in SLIP_LAWS and self._slips_at_first():
            self.methods["start"] = "slip"
        if bound >= 2 and self.bodies.coupled:
            why = "with unlike bodies is not supported: here their tractions change the pressure"
            self.controls.complain("BOUND", why)
        if bound == 4 and self.approach is None:
            self.controls.complain("BOUND", "needs two half-ellipses, IPOTCN = -6")
        if material in (2, 3, 5):
            self._choose_theory(bound, material)

    def _slips_at_first(self) -> bool:
        """True where solvers begin with slip all over: INISLP < 0 of G = 2, 3 or 4."""
        solver = self._solver()
        if solver is None or self.controls["TANG"] == NO_MOTION:
            return False
        key, place = INITIAL_SLIP.get(solver.controls["GAUSEI"], ("", 0))
        return key != "" and solver.entries[key].number(place) < 0

    def _solver(self) -> _Case | None:
        """The case whose solver is kept, or this one."""
        case: _Case | None = self
        while case is not None and case.controls["GAUSEI"] == 1:
            case = case.before
        return case

    def _choose_theory(self, bound: int, material: int) -> None:
        """FASTSIM or FaStrip, for which bodies are half-spaces here."""
        wanted: tuple[int, ...] = (0, 2, 3, 4)
        if material == 5:
            wanted = (2, 3)
        steady = self.controls["TANG"] == STEADY and self.controls["FORCE"] == 0
        if bound not in wanted or not steady:
            why = (
                f"is not supported: simplified theory here has B = {', '.join(map(str, wanted))} "
                "in steady rolling (T = 3) by creepages (F = 0)"
            )
            self.controls.complain("MATER", why)
        flexibility = None
        if material == 2:
            group = self.given.needs("flexibility", "MATER", "a flexibility", "C = 2")
            flexibility, *slope = group.numbers()
        else:
            slope = self.given.needs("slope", "MATER", "slopes", "C = 2").numbers()
        if material == 5:
            self.methods["tangential"] = "fastrip"
            return
        if bound in THEORIES:
            self.methods["tangential"] = THEORIES[bound]
        self.simplified = {
            "elliptic": {2: True, 3: False}.get(bound),
            "flexibility": flexibility,
            "slope": tuple(slope),
        }

    def _scene(self) -> Scene:
        """The case alone; one that goes on from another begins without tractions."""
        tang = self.controls["TANG"]
        parts: dict[str, Any] = {
            "bodies": self.bodies,
            "surface": self.surface,
            "grid": self.grid,
            "units": MM_N,
            "third_body": layer_of(self.given),
            "thermal": thermal_of(self.given),
        }
        if tang == NO_MOTION:
            if self.bodies.relaxes:
                self.controls.complain("TANG", "with viscoelastic bodies needs T = 3")
            return self._made(parts | self._scene_load())
        self._check_continued()
        friction = friction_of(self.given, self.rolling[2], self.grid)
        rigid = self._rigid(friction)
        if tang in (SHIFT, TRANSIENT):
            self._check_step()
        if tang == STEADY:
            parts["motion"] = self._steady(rigid)
        elif tang == SHIFT and self.continues is None:
            parts["motion"] = Shift(**rigid)
        else:
            return self._made(parts | self._step(rigid, friction))
        return self._made(parts | self._scene_load() | {"friction": friction})

    def _check_step(self) -> None:
        """Refuse what only steady rolling has here."""
        if self.controls["EXRHS"] != 0:
            self.controls.complain("EXRHS", "is not supported but in steady rolling, T = 3")
        if self.bodies.relaxes or self.controls["HEAT"] != 0:
            self.controls.complain("TANG", "with viscoelastic bodies or heat needs T = 3")

    def _step(self, rigid: dict[str, Any], friction: Any) -> dict[str, Any]:
        """Motion, surface and friction of one step in time."""
        direction, dq, _ = self.rolling
        if self.controls["TANG"] == SHIFT:
            direction = 1
            dq = 0.0
        step: dict[str, Any] = {
            name: [value] for name, value in (rigid | self._scene_load()).items()
        }
        parts: dict[str, Any] = {}
        if isinstance(friction, np.ndarray):
            parts["friction"] = friction
        else:
            step["friction"] = [friction]
        if self.spin_offset is not None:
            step["spin_offset"] = self.spin_offset
        if isinstance(self.surface, Ellipse):  # whose curvatures must not change with the load
            contact = Scene(bodies=self.bodies, surface=self.surface, **self._load()).hertz
            assert contact is not None
            parts["surface"] = Paraboloids(Rx=contact.Rx, Ry=contact.Ry)
        return parts | {"motion": Transient(steps=1, dq=[dq], direction=[direction], **step)}

    def _made(self, parts: dict[str, Any]) -> Scene:
        with located(self.given.group):
            return Scene(**parts)

    def _steady(self, rigid: dict[str, Any]) -> Steady:
        _, dq, velocity = self.rolling
        more: dict[str, Any] = {"dq": dq, "spin_offset": self.spin_offset}
        if self.bodies.relaxes or self.controls["HEAT"] != 0:
            more["speed"] = velocity
        if self.controls["EXRHS"] != 0:
            (group,) = self.given.needs("extra slip", "EXRHS", "an extra rigid slip", "E = 9")
            values = group.numbers()
            if len(values) != 2 * self.grid.size:
                self.controls.complain("EXRHS", "keeps the rigid slip of other elements")
            if not hasattr(self.surface, "h"):
                self.controls.complain("EXRHS", "needs a contact by its distance, IPOTCN > 0")
            by_element = np.reshape(values, (*self.grid.shape, 2))
            more["rigid_slip"] = np.moveaxis(by_element, -1, 0)
        return Steady(**rigid, **more)

    def _rigid(self, friction: Any) -> dict[str, Any]:
        """Creepages or shifts by the names of the motion; FX and FY, which the file has as parts of
        FSTAT FN, as forces.
        """
        first, second, spin = self._about_origin()
        names = ("ux", "uy", "rotation")
        if self.controls.rolls:
            names = ("vx", "vy", "spin")
        count = self.controls["FORCE"]
        if count == 0:
            return dict(zip(names, (first, second, spin), strict=True))
        # forces as parts of the normal force
        static = 1.0
        if self.controls["VARFRC"] == 0:
            static = getattr(friction, "static", friction)
        given: dict[str, Any] = {names[2]: spin}
        forces: dict[str, float] = {"Fx": static * first}
        if count == 2:
            forces["Fy"] = static * second
        else:
            given[names[1]] = second
        normal = self._normal_force()
        if normal is None:
            self.force_parts = (forces["Fx"], forces.get("Fy"))
            return given
        return given | {name: part * normal for name, part in forces.items()}

    def _about_origin(self) -> tuple[float, float, float]:
        """CKSI or FX, CETA or FY, and CPHI, which may be given about another point."""
        group: Group = self.entries["kinematics"]
        _, first, second, spin = group.numbers()
        if len(group.optional) == 2:
            if self.controls["FORCE"] == 0:
                first += spin * group.option(1, 0.0)
            if self.controls["FORCE"] != 2:
                second -= spin * group.option(0, 0.0)
        return first, second, spin

    def _normal_force(self) -> float | None:
        """The normal force, where it is given or known by Hertz's formulas."""
        load = self._load()
        if "normal_force" in load:
            return float(load["normal_force"])
        if self.bodies.coupled:
            why = (
                "with N = 0 is not supported with unlike bodies: FX is a part of FSTAT FN, "
                "and FN is not known; use N = 1"
            )
            self.controls.complain("FORCE", why)
        return None

    def _check_continued(self) -> None:
        """Find the case from which this one goes on: P = 0 after a case that is calculated."""
        if self.controls["TANG"] == STEADY or self.controls["PVTIME"] == 2:
            return
        before = self.before
        while before is not None and not before.given.calculated:
            before = before.before
        if before is None:  # CONTACT begins anew in a first case
            return
        if self.controls["PVTIME"] == 1:
            if self.bodies.coupled:
                self.controls.complain("PVTIME", "is not supported with unlike bodies")
            return
        if before.reason:
            self.controls.complain("PVTIME", f"continues case {before.given.number}, left out")
        if before.bodies != self.bodies:
            why = "continues a case with other material, which is not supported"
            self.controls.complain("PVTIME", why)
        self.continues = before.result
        if self.controls["PVTIME"] == 3:
            self.continues = before.continues


def _scenes(cases: Sequence[ContactCase]) -> list[Scene]:
    """The scenes of cases, those together that continue each other on the same elements."""
    scenes: list[Scene] = []
    for sequence in _sequences(cases):
        first = sequence[0]
        if any(case.force_parts is not None or case.scene is None for case in sequence):
            continue
        if len(sequence) == 1:
            if first.before is None:
                scenes.append(first.scene)  # type: ignore[arg-type]
            continue
        scenes.append(_history([case.scene for case in sequence]))  # type: ignore[misc]
    return scenes


def _sequences(cases: Sequence[ContactCase]) -> Iterator[list[ContactCase]]:
    sequence: list[ContactCase] = []
    for case in cases:
        follows = bool(sequence) and case.before is sequence[-1] and _joins(sequence[-1], case)
        if sequence and not follows:
            yield sequence
            sequence = []
        sequence.append(case)
    if sequence:
        yield sequence


def _joins(before: ContactCase, case: ContactCase) -> bool:
    """True for steps of one history: a shift or a step in time, then a step, on one grid."""
    if before.scene is None or case.scene is None:
        return False
    if not isinstance(before.scene.motion, Shift | Transient):
        return False
    return before.scene.grid == case.scene.grid


STEP = ("vx", "vy", "spin", "ux", "uy", "rotation")


def _history(scenes: Sequence[Scene]) -> Scene:
    """The scenes of single steps as one history."""
    motion = _joined([_step_of(scene) for scene in scenes])
    surfaces = [scene.surface for scene in scenes]
    if not all(_same(surface, surfaces[0]) for surface in surfaces):
        motion["surface"] = surfaces
    last = scenes[-1].motion
    if isinstance(last, Transient):
        motion["spin_offset"] = last.spin_offset
    history = Transient(steps=len(scenes), **motion)
    return replace(scenes[0], normal_force=None, approach=None, friction=None, motion=history)


def _joined(steps: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Entries of steps as those of a history."""
    motion: dict[str, Any] = {name: [step.get(name, 0.0) for step in steps] for name in STEP}
    motion |= {name: [step[name] for step in steps] for name in ("dq", "direction", "friction")}
    for name in ("Fx", "Fy", "normal_force", "approach"):
        values = [step.get(name) for step in steps]
        if set(values) != {None}:
            motion[name] = values
    return motion


def _same(surface: Any, other: Any) -> bool:
    if surface is other:
        return True
    both = hasattr(surface, "h") and hasattr(other, "h")
    return both and np.array_equal(surface.h, other.h)


def _step_of(scene: Scene) -> dict[str, Any]:
    """A shift, or a history of one step, by the entries of a step."""
    motion = scene.motion
    if isinstance(motion, Transient):
        step = {
            name: motion.of(name, 0) for name in (*STEP, "Fx", "Fy", "normal_force", "approach")
        }
        step |= {name: motion.of(name, 0) for name in ("dq", "direction", "friction")}
        return step
    assert isinstance(motion, Shift)
    step = {name: getattr(motion, name) for name in ("ux", "uy", "rotation", "Fx", "Fy")}
    load = {"normal_force": scene.normal_force, "approach": scene.approach}
    return step | load | {"dq": 0.0, "direction": 1, "friction": scene.friction}
