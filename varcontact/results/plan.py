"""Plan: the requirements of a scene as plain data, put into words only where it is printed."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Literal

from varcontact.discrete.contact_grid import PotentialContact
from varcontact.discrete.state import cells_of
from varcontact.html import Reported, in_rows
from varcontact.scene.grid import Cells
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import Kind, SolverSpec, solver_spec
from varcontact.system import process
from varcontact.system.process import changed
from varcontact.theories.on_grid import THEORIES, Theory

UNPOLISHED = 1e-2
"""Part of the tolerance requested of a solver whose answer is not polished by active sets."""
POLISH_TOLS = (1e-2, 1e-4, 1e-6)
"""Accuracies requested of a solver of programs in turn, until active sets can polish its answer."""
CONIC_TOL = 1e-6
"""Accuracy requested of a solver of programs whose answer is refined by splitting."""
ACTIVE_SETS: dict[Kind, str] = {"normal": "norm", "tangential": "tang-safeguarded"}
"""Solvers that polish the answers of programs."""
POLISHED_TOL = 1e-9
"""Residual below which a polished answer is not improved further."""

AT_ONCE = ("newton", "splitting", "active-set")
"""Couplings in which one solver finds pressure and tractions together."""

Begin = Literal["given", "only given", "last", "best", "none"]
"""Start of an attempt: the given one, if any; only the given one, else no attempt is made; the last
answer; the best one; none."""


@dataclass(frozen=True)
class Matrix:
    """One block of influence numbers that a plan assembles, as estimated from
    the number of elements.

    Attributes
    ----------
    name : str
        Such as "A_zz" or "A_tt - C_tt": t is along x and y, z normal.
    kind : {"table", "dense"}
        By offset, for products by FFT, with its transform; or element by
        element.
    rows, columns : int
        Size; of a table the numbers of offsets along y and x.
    bytes : int
    reason : str
    at_most : bool
        Whether it may turn out smaller.
    """

    name: str
    kind: str
    rows: int
    columns: int
    bytes: int
    reason: str
    at_most: bool = False


@dataclass(frozen=True)
class Sizes:
    """Sizes of the problems of a plan, estimated from the number of elements.

    Attributes
    ----------
    grid : (int, int)
        Rows and columns of the potential contact, (ny, nx).
    sides : (float, float), optional
        Side lengths of an element [length]; None where the contact has to be searched for
        first.
    elements : dict
        By problem, "normal" and "tangential": the elements that enter it.
    unknowns : dict
        By problem: pressures, or traction components.
    mirrored : bool
        Whether the tangential problem is solved on one side of its line of
        symmetry only.
    matrices : tuple of Matrix
    memory : dict
        Bytes at the peak of each problem, "normal" and "tangential".
    exact : bool
        Whether elements are known; otherwise they, and what follows from them,
        are upper bounds.
    """

    grid: tuple[int, int]
    sides: tuple[float, float] | None
    elements: dict[Kind, int]
    unknowns: dict[Kind, int]
    mirrored: bool
    matrices: tuple[Matrix, ...]
    memory: dict[Kind, float]
    exact: bool

    @property
    def peak(self) -> float:
        """Memory at the peak of the problem that needs most [bytes]."""
        return max(self.memory.values())


@dataclass(frozen=True)
class Cost:
    """Estimated cost of a method."""

    method: str  # "auto", "convex", "conic", "active-set" or "kalker"
    normal: str  # its solvers
    tangential: str  # its solvers
    seconds: float | None  # on one core; None where it is not known
    bytes: float  # at the peak


@dataclass(frozen=True)
class Attempt:
    """One call of a solver on the way to an answer, made while the best answer is not good enough.

    Attributes
    ----------
    solver : str
    begin : {"given", "only given", "last", "best", "none"}
        At the start that is given, if one is; at that one, or the attempt is not made; at the
        last answer; at the best answer; on its own.
    part, least : float
        It is asked for the tolerance times `part`, or for `least` where that is more.
    until : float
        Residual of the best answer, if below the tolerance, at which the attempt is left out.
    polishes : bool
        Whether it only improves on the last answer, whose number of iterations is kept.
    judged : bool
        Whether its answer may be the final one, not only a start.
    marches : bool
        Whether the solver is called for each step of a march.
    reason : str
        Why its answer was taken, with the solver before in place of ``{}``.
    """

    solver: str
    begin: Begin = "given"
    part: float = 1.0
    least: float = 0.0
    until: float = math.inf
    polishes: bool = False
    judged: bool = True
    marches: bool = False
    reason: str = ""

    def asked(self, tol: float) -> float:
        """Accuracy requested of the solver."""
        return max(self.part * tol, self.least)

    def enough(self, tol: float) -> float:
        """Residual of the best answer so far below which this attempt is skipped."""
        return min(tol, self.until)


@dataclass(frozen=True)
class Plan(Reported):
    """Plan of a scene: its kind and the methods chosen; of `varcontact.plan` also the sizes of the
    problems.

    Attributes
    ----------
    normal : str
        "hertz", or the solver of the normal problem.
    tangential : str
        The solver of the tangential problem; "none" where there is none,
        "no-slip" where it is linear.
    coupling : str
        "none" for quasi-identical bodies and without friction, else "johnson",
        "panagiotopoulos", "joint", "newton", "splitting" or "active-set".
    formulation : str
        The programs that are solved: "complementary", "potential", "gap" or
        "marching"; "none" without one.
    reasons : dict
        Why, in one line each: of the methods; of `varcontact.plan` also of
        bodies, and what is special.
    dimension : str
        "three-dimensional" or "line contact".
    bodies : str
        "quasi-identical" (K = 0), "unlike" or "conformal".
    surface : str
        "Hertzian", "sampled", or "analytic" where the surface has a formula and
        the bodies are no half-spaces.
    motion : str
        "none", "shift", "steady" (one problem), "marching" (steps until nothing
        changes) or "transient".
    friction : str
        "given" (numbers, known beforehand), "none", or the law that the
        coefficient follows, by its kind in a scene file: then an outer loop
        finds it; "several" where a history has more than one of these.
    special : tuple of str
        Simplifications: "frictionless", "no slip"; "no
        grid" where one is chosen by `solve`.
    sizes : Sizes, optional
        Grid, elements, matrices and memory; of `varcontact.plan` only.
    method : str
        "auto", "convex", "conic", "active-set" or "kalker".
    costs : tuple of Cost
        Seconds and memory of this plan, then those of other methods; of
        `varcontact.plan` only.
    doubts : tuple of str
        Likely mistakes in the scene, see `Scene.doubts`; of `varcontact.plan`
        only.
    grid : PotentialContact, optional
        Number of elements across the contact, and the grid as far as it is
        known without a solution; None of a plan from a file.
    """

    normal: str
    tangential: str
    coupling: str
    formulation: str = "none"
    reasons: dict[str, str] = field(default_factory=dict)
    dimension: str = ""
    bodies: str = ""
    surface: str = ""
    motion: str = ""
    friction: str = ""
    special: tuple[str, ...] = ()
    sizes: Sizes | None = None
    method: str = "auto"
    costs: tuple[Cost, ...] = field(default=(), compare=False)
    doubts: tuple[str, ...] = field(default=(), compare=False)
    grid: PotentialContact | None = field(default=None, compare=False)

    @property
    def closed_form(self) -> bool:
        """True where the pressure is Hertz's."""
        return self.normal == "hertz"

    def solver_of(self, problem: Kind) -> SolverSpec | None:
        """The solver of one of the two problems; None in closed form, by a theory, or without one.

        Parameters
        ----------
        problem : {"normal", "tangential"}
        """
        names: dict[Kind, str] = {"normal": self.normal, "tangential": self.tangential}
        return solver_spec(problem, names[problem])

    def matrix_free(self, problem: Kind) -> bool:
        """True where a problem is solved without its matrix.

        Parameters
        ----------
        problem : {"normal", "tangential"}
        """
        spec = self.solver_of(problem)
        return spec is not None and spec.matrix_free

    def states_program(self, problem: Kind) -> bool:
        """True where a problem is handed to a solver as a convex program.

        Parameters
        ----------
        problem : {"normal", "tangential"}
        """
        spec = self.solver_of(problem)
        return spec is not None and spec.states_program

    def attempts(self, problem: Kind, polish: bool = True) -> tuple[Attempt, ...]:
        """The solvers that are tried on one of the two problems, in their order; none in closed
        form, by a theory, or without a problem.

        Parameters
        ----------
        problem : {"normal", "tangential"}
        polish : bool
            Whether active sets polish the answers of programs, see `solve`.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0),
        ...     normal_force=1.0, friction=0.3, motion=vc.Steady(vx=0.05))
        >>> for attempt in vc.plan(scene, method="conic").attempts("tangential"):
        ...     print(attempt.solver, attempt.begin, attempt.asked(1e-8))
        clarabel given 1e-06
        splitting last 1e-10
        """
        spec = self.solver_of(problem)
        if spec is None:
            return ()
        return _attempts_by(spec, problem, self.method, self.formulation, polish)

    def cells(self, scene: Scene) -> Cells:
        """Parts of an element along y and x on which the pressure is solved
        for; (1, 1): on the elements, or nowhere.

        Parameters
        ----------
        scene : Scene
        """
        return (1, 1) if self.closed_form else cells_of(scene.edge, scene.line)

    @property
    def has_friction(self) -> bool:
        """True where there is a tangential problem."""
        return self.tangential != "none"

    @property
    def theory(self) -> Theory | None:
        """The approximate theory that gives the tractions, if one does."""
        return THEORIES.get(self.tangential)

    @property
    def has_moment(self) -> bool:
        """True where the method gives a moment: Polach's formula is one of forces alone."""
        return self.tangential != "polach"

    @property
    def solves(self) -> bool:
        """True where the tangential problem itself is solved, by whatever method."""
        return self.has_friction and self.theory is None

    @property
    def is_formula(self) -> bool:
        """True where Hertz's pressure and a theory give the answer: nothing is solved to a
        tolerance.
        """
        return self.closed_form and self.theory is not None

    @property
    def loops(self) -> bool:
        """True where pressure and tractions are solved in outer iterations until both converge."""
        return self.coupling in ("panagiotopoulos", "joint", *AT_ONCE)

    @property
    def at_once(self) -> bool:
        """True where one solver finds pressure and tractions together, before any passes."""
        return self.coupling in AT_ONCE

    @property
    def by_areas(self) -> bool:
        """True where one solver finds pressure and tractions by active sets, with dense
        matrices.
        """
        return self.coupling == "active-set"

    def summary(self) -> dict[str, Any]:
        """Plan as dictionaries, lists, numbers and words, as ``varcontact plan --json`` prints
        it.
        """
        record: dict[str, Any] = json.loads(json.dumps(self.record()))
        if self.sizes is not None:
            record["sizes"]["peak"] = self.sizes.peak
        return record

    def record(self) -> dict[str, Any]:
        """The plan as files have it: without its grid, which a solution has."""
        return {
            name: value
            for name, value in asdict(replace(self, grid=None)).items()
            if name != "grid"
        }

    @property
    def potential_contact(self) -> PotentialContact:
        """The grid of a plan that was made for a scene."""
        assert self.grid is not None
        return self.grid

    @classmethod
    def of_record(cls, record: dict[str, Any]) -> Plan:
        """Plan from the `record` that `summary` and JSON made of it; ValueError for any other
        record.
        """
        if not (isinstance(record.get("reasons"), dict) and isinstance(record.get("normal"), str)):
            raise ValueError("a plan without methods and reasons")
        not_stored = {"sizes": None, "costs": (), "doubts": ()}
        special = {"special": tuple(record.get("special", ()))}
        old = ("left_out", "fallback")
        entries = {name: value for name, value in record.items() if name not in old}
        return cls(**(entries | not_stored | special))

    def __repr__(self) -> str:
        names = ("method", "normal", "tangential", "coupling", "formulation")
        entries = [f"{name}={getattr(self, name)!r}" for name in names]
        return f"Plan({', '.join(entries)})"

    def report(self) -> str:
        """The plan in words, for people."""
        kinds = ("dimension", "bodies", "surface", "motion", "friction")
        methods = ("method", "normal", "tangential", "coupling", "formulation")
        why = {name: f": {reason}" for name, reason in self.reasons.items()}
        rows = [("WARNING", doubt) for doubt in self.doubts]
        rows += [(name, getattr(self, name) + why.get(name, "")) for name in kinds]
        rows += [("special", name + why.get(name, "")) for name in self.special]
        rows += [("", ""), *((name, getattr(self, name) + why.get(name, "")) for name in methods)]
        if self.sizes is not None:
            rows += [("", ""), *_rows_of_sizes(self.sizes)]
        heading = "time, one core"
        for cost in self.costs:
            rows.append((heading, _words_of_cost(cost)))
            heading = ""
        return in_rows("Plan", rows)


def _attempts_by(
    spec: SolverSpec, problem: Kind, method: str, formulation: str, polish: bool
) -> tuple[Attempt, ...]:
    """The attempts at one of the two problems by a solver under a plan's method and formulation."""
    marches = problem == "tangential" and formulation == "marching"
    own = Attempt(spec.name, marches=marches)
    if not spec.states_program:
        return _with_fallback(spec, problem, own, method)
    if method == "conic":
        return _refined(own)
    if polish:
        return _polished(own, ACTIVE_SETS[problem])
    return (changed(own, part=UNPOLISHED),)


def _with_fallback(
    spec: SolverSpec, problem: Kind, own: Attempt, method: str
) -> tuple[Attempt, ...]:
    """The solver, then splitting from its answer, but for methods as printed and marches."""
    if problem == "tangential" and not spec.matrix_free:
        own = changed(own, part=UNPOLISHED)
    if not spec.falls_back or method == "kalker" or own.marches:
        return (own,)
    missed = "{} missed the tolerance, splitting was used"
    return own, Attempt("splitting", "best", part=own.part, reason=missed)


def _refined(program: Attempt) -> tuple[Attempt, ...]:
    """A program, refined by splitting."""
    refinement = Attempt(
        "splitting",
        "last",
        part=UNPOLISHED,
        until=0.0,
        polishes=True,
        reason="{}, refined by splitting",
    )
    return changed(program, least=CONIC_TOL), refinement


def _polished(program: Attempt, active_sets: str) -> tuple[Attempt, ...]:
    """Active sets from the given start, then from the answers of programs that are no more exact
    than they need.

    Near saturation they can be lost beside the solution, where almost nothing sticks: in the end
    they begin on their own.
    """
    polish = Attempt(active_sets, "last", until=POLISHED_TOL, polishes=True)
    attempts = [changed(polish, begin="only given")]
    for accuracy in POLISH_TOLS:
        rough = changed(program, part=0.0, least=accuracy, until=POLISHED_TOL, judged=False)
        attempts += [rough, polish]
    attempts.append(changed(polish, begin="none", until=math.inf))
    return tuple(attempts)


def _words_of_cost(cost: Cost) -> str:
    solvers = cost.normal
    if cost.tangential != "none":
        solvers += f", {cost.tangential}"
    seconds = "seconds not known"
    if cost.seconds is not None:
        seconds = f"about {cost.seconds:.1g} s"
    return f"{cost.method} ({solvers}): {seconds}, {_bytes(cost.bytes)}"


def _rows_of_sizes(sizes: Sizes) -> list[tuple[str, str]]:
    rows = [("grid", _words_of_grid(sizes))]
    rows += [(f"{name} problem", _words_of_problem(sizes, name)) for name in sizes.elements]
    if sizes.mirrored:
        rows.append(("", "half the unknowns: the tangential problem is its own mirror image"))
    for matrix in sizes.matrices:
        shape = f"{matrix.rows} x {matrix.columns}"
        if matrix.kind == "table":
            shape += " offsets"
        if matrix.at_most:
            shape = f"at most {shape}"
        text = f"{matrix.kind}, {shape}, {_bytes(matrix.bytes)}: {matrix.reason}"
        rows.append((matrix.name, text))
    stages = ", ".join(f"{name} {_bytes(size)}" for name, size in sizes.memory.items())
    rows.append(("peak memory", f"about {_bytes(sizes.peak)} ({stages})"))
    available = process.available()
    if sizes.peak > available:
        verb = "does" if sizes.exact else "may"
        rows.append(("", f"{verb} not fit: {_bytes(available)} are available"))
    if not sizes.exact:
        rows.append(("", "upper bounds: the contact is not known until it is solved for"))
    return rows


def _words_of_grid(sizes: Sizes) -> str:
    rows, columns = sizes.grid
    text = f"{columns} x {rows} elements"
    if sizes.sides is not None:
        text += f", each {sizes.sides[0]:.4g}"
        if rows > 1:
            text += f" by {sizes.sides[1]:.4g}"
    return text


def _words_of_problem(sizes: Sizes, problem: Kind) -> str:
    elements = f"{sizes.elements[problem]} elements"
    unknowns = f"{sizes.unknowns[problem]} unknowns"
    if not sizes.exact:
        elements = f"at most {elements}"
        unknowns = f"at most {unknowns}"
    if sizes.unknowns[problem] == 0:
        unknowns = "closed form"
    return f"{elements}, {unknowns}"


def _bytes(size: float) -> str:
    for unit in ("B", "KiB", "MiB"):
        if size < 1000:
            return f"{size:.3g} {unit}"
        size /= 1024
    return f"{size:.3g} GiB"
