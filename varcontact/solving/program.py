"""The convex programs of a scene as plain data, for any solver; and their answers back."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import certificate_of
from varcontact.discrete.contact_grid import no_element_in_contact
from varcontact.discrete.discretisation import Discretisation, Subgrid, discretise
from varcontact.discrete.problems import NormalProblem, TangentialProblem
from varcontact.discrete.state import ContactState, cells_of, divided, means, unloaded
from varcontact.discrete.stick_slip import ContactResponse
from varcontact.errors import SceneError
from varcontact.html import Reported, in_rows
from varcontact.io import program as files
from varcontact.results.physical import solution_of
from varcontact.results.plan import Plan
from varcontact.results.solution import Solution
from varcontact.scene.consistency import check_force_is_sum, hardening_refused
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solvers.conic.backends import FORMULATIONS
from varcontact.solvers.conic.languages import (
    for_clarabel,
    for_cvxpy,
    for_osqp,
    for_qpsolvers,
    for_scipy,
    for_scs,
    full_quadratic,
)
from varcontact.solvers.conic.programs import (
    ConicProgram,
    linear_operator,
    normal_program,
    tangential_program,
)
from varcontact.solvers.interface import SolveStats
from varcontact.solvers.registry import SolverSpec, solver_spec
from varcontact.solving.given_pressure import check_placed, contact_under
from varcontact.solving.methods import Methods
from varcontact.solving.options import TOLERANCE
from varcontact.solving.pipeline import check_memory
from varcontact.solving.selection import select, why_not_hertz
from varcontact.system.process import lazy_property, one_blas_thread
from varcontact.theories.on_grid import THEORIES

LANGUAGES: dict[str, Callable[[ConicProgram], Any]] = {
    "clarabel": for_clarabel,
    "cvxpy": for_cvxpy,
    "scs": for_scs,
    "osqp": for_osqp,
    "qpsolvers": for_qpsolvers,
    "scipy": for_scipy,
}
"""Programs in the language of each package."""
ProblemName = Literal["normal", "tangential"]
"""The two problems."""
ProgramName = Literal["auto", "complementary", "potential", "gap"]
"""Formulations of programs."""

MEANINGS = {
    "traction": "tractions divided by their bound, all along x, then all along y; or pressures",
    "shift_size": "t >= |E|, sizes of the local shift",
    "rigid": "unknown part of the rigid shift; or approach",
    "excess": "tractions beyond the yield stress, and their cones",
    "flow_size": "sizes of the plastic shift",
    "flow": "plastic shift, and its cones",
    "force": "mean tractions; multipliers: the rigid shift by sum(w), or less the approach by n",
    "distance": "deformed distances h - d + A p >= 0; multipliers: pressures",
    "pressure": "pressures p >= 0; multipliers: deformed distances",
    "shift": "cones (t, E) of the local shift; multipliers: w (1, p)",
    "bound": "cones (1, p) of the traction bound; multipliers: w (|E|, E)",
}
"""Meanings of the blocks of variables and of rows; w is the traction bound divided by the
largest."""


@dataclass(frozen=True, eq=False)
class Program(Reported):
    """A convex program of a scene: ``min 1/2 x'P x + q'x, A x + s = b, s in K``, with multipliers z
    in the dual cone, ``P x + q + A'z = 0``. See `program`.

    All numbers are scaled, of order one. Rows and cones are in the order zero (equations),
    nonnegative, second-order (``s[0] >= |s[1:]|``, an element each); elements run along x first,
    row by row of the grid, and only those that can carry traction have variables.

    Attributes
    ----------
    scene : Scene
    problem : {"normal", "tangential"}
    formulation : {"complementary", "potential", "gap"}
    notes : tuple of str
        Quantities that are held fixed here, and that `solve` would determine.
    P, A : scipy.sparse.csc_matrix
        P is symmetric, with all its entries; both are made when first asked for.
    q, b : ndarray
    cones : list of (str, int)
        Kinds ("zero", "nonnegative", "second_order") and sizes.
    variables, duals : dict of str to slice
        Places of the blocks of x, and of those of z, by name; `report` says what each is.
    scales : dict of str to float or ndarray
        Value of 1 in the scene's units: "traction" (n,) or (c n,) [force/area], "shift"
        [length] of shifts or distances, and "energy" of the objective [force length].
    elements : ndarray of int, shape (n,)
        Places ``iy * nx + ix`` of the elements on the grid; of a normal problem on their parts.
    """

    scene: Scene
    problem: str
    formulation: str
    notes: tuple[str, ...]
    _contact: _ContactProblem = field(repr=False)

    @lazy_property
    def _conic(self) -> ConicProgram:
        problem = self._contact.problem
        unknowns = self._contact.unknowns
        check_memory(self.problem, self._contact.example, self.formulation, unknowns)
        of_traction, of_shift = FORMULATIONS[self.formulation]
        if isinstance(problem, NormalProblem):
            return normal_program(problem, of_traction, of_shift)
        return tangential_program(problem, of_traction, of_shift)

    @lazy_property
    def P(self) -> Any:
        return full_quadratic(self._conic)

    @property
    def q(self) -> np.ndarray:
        return self._conic.q

    @property
    def A(self) -> Any:
        return self._conic.A

    @property
    def b(self) -> np.ndarray:
        return self._conic.b

    @property
    def cones(self) -> list[tuple[str, int]]:
        return list(self._conic.cones)

    @property
    def variables(self) -> Mapping[str, slice]:
        return dict(self._conic.variables)

    @property
    def duals(self) -> Mapping[str, slice]:
        return dict(self._conic.rows)

    @property
    def elements(self) -> np.ndarray:
        return self._contact.problem.operator.elements

    @property
    def scales(self) -> dict[str, Any]:
        scales = self._contact.disc.scales
        problem = self._contact.problem
        energy = self._conic.energy * scales.force * scales.displacement
        product = self._conic.energy / problem.area  # of a traction and a shift
        if isinstance(problem, NormalProblem):
            unit = math.sqrt(product * problem.operator.diagonal)
            traction = np.full(problem.distance.size, unit / problem.operator.diagonal)
        else:
            unit = product / problem.bound.max()
            traction = np.tile(problem.bound, problem.components)
        return {
            "traction": traction * scales.pressure,
            "shift": unit * scales.displacement,
            "energy": energy,
        }

    @property
    def contact_problem(self) -> NormalProblem | TangentialProblem:
        """The discrete problem behind the program, as own solvers get it (`register_solver`)."""
        return self._contact.problem

    @lazy_property
    def operator(self) -> Any:
        """Elastic shifts (or distances) by tractions, both scaled, as a SciPy ``LinearOperator``:
        products by FFT, and with the transpose, no matrix. ``operator @ x[variables["traction"]]``
        are shifts in ``scales["shift"]``.
        """
        return linear_operator(self._contact.problem)

    def to(self, name: str) -> Any:
        """The program as a package takes it.

        Parameters
        ----------
        name : {"clarabel", "cvxpy", "scs", "osqp", "qpsolvers", "scipy"}

        Returns
        -------
        tuple, dict or Problem
            ``clarabel.DefaultSolver(*program.to("clarabel"), settings)``;
            ``scs.SCS(*program.to("scs"))``; ``osqp.OSQP().setup(**program.to("osqp"))``; a
            ``cvxpy.Problem`` of the variable "x"; a ``qpsolvers.Problem``;
            ``scipy.optimize.minimize(**program.to("scipy"))``, for a few elements.

        Raises
        ------
        SceneError
            For another name, and for "osqp" or "qpsolvers" where there are second-order cones of
            two components.
        """
        return LANGUAGES[checks.choice("name", name, LANGUAGES)](self._conic)

    @checks.named_options()
    def save(self, path: str | Path, overwrite: bool = False) -> None:
        """Write the program to a file, whole or not at all.

        Parameters
        ----------
        path : str or Path
            ``.npz``: P and A by columns (``P_data``, ``P_indices``, ``P_indptr``, ``P_shape``), q,
            b, ``cones`` and ``cone_sizes``, ``variables`` and ``rows`` with the ``_ends`` of their
            blocks. ``.cbf``: the format of the Conic Benchmark Library, whose last variable is the
            quadratic part of the objective.
        overwrite : bool
            Whether another file may be replaced.

        Raises
        ------
        OutputError
            For other endings, and if the file holds something else or cannot be written.
        """
        files.save(self._conic, path, self._heading, overwrite)

    @property
    def _heading(self) -> list[str]:
        unit = self.scales["energy"]
        return [
            f"{self.problem} problem, formulation {self.formulation}",
            f"an objective of 1 is an energy of {unit!r}",
            *self.notes,
        ]

    @one_blas_thread()
    def solution(self, x: np.ndarray, z: np.ndarray | None = None) -> Solution:
        """The solution that values of the variables stand for, judged by our own residuals.

        Parameters
        ----------
        x : array_like
            Values of the variables, from any solver.
        z : array_like, optional
            Multipliers of the rows. Needed for pressures by "potential", and for the rigid shift
            by "complementary" where tangential forces are prescribed.

        Returns
        -------
        Solution
            Solution of this problem alone: a normal one has no motion. `Solution.certificate` is
            computed from its fields; it counts as `converged` where the residual of the problem is
            1e-8 or less.

        Raises
        ------
        SceneError
            For values of another shape, that are not finite, or without multipliers where they
            are needed.
        """
        contact = self._contact
        values = checks.array("x", x, shape=self.q.shape)
        if z is None:
            self._check_multipliers()
            multipliers = np.zeros(self.b.size)
        else:
            multipliers = checks.array("z", z, shape=self.b.shape)
        traction, rigid = self._conic.recover(values, multipliers)
        if isinstance(contact.problem, NormalProblem):
            if z is None and self.formulation == "complementary":
                rigid = np.array([contact.problem.mean_approach(traction)])
            disc, state = contact.with_pressure(traction, float(rigid[0]))
        else:
            field, shifts = contact.problem.on_grid(traction, rigid)
            disc = contact.disc
            state = replace(contact.state, traction=field, rigid=shifts)
        state = replace(state, solved_by={self.problem: "program"})
        closed_form = contact.plan.closed_form
        response = ContactResponse(disc, state)
        certificate = certificate_of(response, closed_form, "auto")
        residual = getattr(certificate, f"{self.problem}_residual")
        stats = SolveStats()
        converged = bool(residual <= TOLERANCE)
        return solution_of(self.scene, response, contact.plan, certificate, converged, stats)

    def _check_multipliers(self) -> None:
        problem = self._contact.problem
        if isinstance(problem, NormalProblem):
            needed = self.formulation == "potential"
        else:
            needed = bool(problem.free) and self.formulation == "complementary"
        if needed:
            raise SceneError("z", None, f"given: {self.formulation} has part of the answer there")

    def __repr__(self) -> str:
        return f"Program({self.problem!r}, {self.formulation!r}, {self._contact.unknowns} unknowns)"

    def report(self) -> str:
        """Size, blocks of variables and rows with their meaning, and what is held fixed."""
        conic = self._conic
        rows = [("problem", f"{self.problem}, {self.formulation}")]
        rows.append(("size", f"{conic.q.size} variables, {conic.b.size} rows"))
        for kind, blocks in (("x", conic.variables), ("z", conic.rows)):
            for name, place in blocks.items():
                words = f"{name}: {MEANINGS[name]}"
                rows.append((f"{kind}[{place.start}:{place.stop}]", words))
        rows += [("fixed", note) for note in self.notes]
        return in_rows("Program", rows)


@dataclass(frozen=True, eq=False)
class _ContactProblem:
    """A problem of a contact on its grid, under a pressure."""

    disc: Discretisation
    state: ContactState
    plan: Plan
    problem: NormalProblem | TangentialProblem

    @property
    def example(self) -> SolverSpec | None:
        """A solver that needs about as much memory as others."""
        if isinstance(self.problem, NormalProblem):
            return solver_spec("normal", "clarabel")
        return solver_spec("tangential", "clarabel")

    @property
    def unknowns(self) -> int:
        if isinstance(self.problem, NormalProblem):
            return self.problem.distance.size
        return self.problem.rigid_shift.size

    def with_pressure(
        self, traction: np.ndarray, approach: float
    ) -> tuple[Discretisation, ContactState]:
        """The contact with pressures (n,) of its elements, or of their parts."""
        disc = self.disc
        operator = self.problem.operator
        pressure = np.zeros(operator.grid_operator.shape)
        pressure.flat[operator.elements] = traction
        cells = cells_of(disc.grid.edge, disc.grid.line)
        if cells != (1, 1):
            parts = divided(disc, cells)
            approach -= (disc.base - parts.base) / disc.scales.displacement
            disc = replace(disc, subgrid=Subgrid(parts, pressure))
            pressure = means(pressure, cells)
        return disc, replace(unloaded(disc.grid), pressure=pressure, approach=approach)


@checks.named_options()
@one_blas_thread()
def program(
    scene: Scene,
    problem: ProblemName = "tangential",
    formulation: ProgramName = "auto",
    *,
    pressure: np.ndarray | None = None,
) -> Program:
    """The convex program of a scene's normal or tangential problem, without solving anything.

    Parameters
    ----------
    scene : Scene
        With an explicit grid, or a Hertzian surface. Of steady rolling, a shift or, for pressures,
        normal contact.
    problem : {"tangential", "normal"}
        The tractions under a pressure, or the pressure without tractions.
    formulation : {"auto", "complementary", "potential", "gap"}
        By complementary energy (215), by potential energy (214), or by the duality gap: "auto" is
        "complementary" where there is an energy, and "gap" in steady rolling.
    pressure : array_like, shape (ny, nx), optional
        Pressure of a tangential problem, as in `certify` [force/area]; Hertz's, where the surface
        is Hertzian and none is given.

    Returns
    -------
    Program

    Raises
    ------
    SceneError
        For a scene that has no such program: a history, a theory by name, without friction, with
        infinite friction (a linear system), with a third body whose yield stress follows from the
        tractions, where the gap is not convex, and normal contact of conformal bodies under a
        force.

    Examples
    --------
    >>> import clarabel
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.05), grid=vc.Grid(nx=10, ny=10))
    >>> settings = clarabel.DefaultSettings()
    >>> settings.verbose = False
    >>> program = vc.program(scene)
    >>> answer = clarabel.DefaultSolver(*program.to("clarabel"), settings).solve()
    >>> solution = program.solution(answer.x)
    >>> solution.certificate.relative_gap < 1e-5
    True
    """
    checks.kind("scene", scene, Scene)
    checks.choice("problem", problem, ("normal", "tangential"))
    if formulation in THEORIES:
        why = "a theory is a formula, and solves no program"
        raise SceneError("formulation", formulation, f"one of {', '.join(FORMULATIONS)}: {why}")
    checks.choice("formulation", formulation, ("auto", *FORMULATIONS))
    if problem == "normal":
        if pressure is not None:
            raise SceneError("pressure", "an array", "left out: it is what this program finds")
        return _of_pressures(scene, formulation)
    return _of_tractions(scene, formulation, pressure)


def _of_pressures(scene: Scene, formulation: str) -> Program:
    check_placed(scene, "for a program without a solution")
    check_force_is_sum(scene)
    notes = []
    if scene.coupled and not scene.frictionless:
        notes.append(f"no tractions, which would change the pressure ({scene.difference})")
    scene = scene.without_friction
    plan = select(scene, Methods(normal="clarabel"))
    disc = discretise(scene, plan.potential_contact.known)
    cells = plan.cells(scene)
    lattice = disc
    if cells != (1, 1):
        lattice = divided(disc, cells)
    problem = lattice.normal_problem().reachable()
    if problem.distance.size == 0:
        raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
    names = ["complementary", "potential", "gap"]
    if not problem.symmetric:
        names = ["gap"]
    formulation = _checked(formulation, names, "viscoelastic bodies have no energy")
    plan = _by_program(plan, "normal", formulation)
    contact = _ContactProblem(disc, unloaded(disc.grid), plan, problem)
    return Program(scene, "normal", formulation, tuple(notes), contact)


def _of_tractions(scene: Scene, formulation: str, pressure: np.ndarray | None) -> Program:
    _check_program(scene)
    check_placed(scene, "for a program without a solution")
    why = why_not_hertz(scene)
    if pressure is None and why:
        raise SceneError("pressure", None, f"given: Hertz's {why}")
    normal = "hertz"
    if pressure is not None:
        normal = "clarabel"
    methods = Methods(normal=normal, tangential="clarabel", coupling="johnson")
    plan = select(scene, methods)
    disc, state = contact_under(scene, plan.potential_contact.known, pressure)
    notes = _held_fixed(scene, disc)
    problem = disc.tangential_problem(state.pressure)
    if problem.size == 0:
        raise SceneError("friction", scene.friction, "positive where there is pressure")
    names = ["complementary", "potential", "gap"]
    if not problem.symmetric:
        names = ["gap"]
    formulation = _checked(formulation, names, "steady rolling has no energy")
    if formulation == "gap" and problem.symmetric_part is None:
        why = "the gap is not found to be convex for elements so long and steps so short"
        raise SceneError("motion.dq", getattr(scene.motion, "dq", None), f"longer: {why}")
    plan = _by_program(plan, "tangential", formulation)
    contact = _ContactProblem(disc, state, plan, problem)
    return Program(scene, "tangential", formulation, tuple(notes), contact)


def _check_program(scene: Scene) -> None:
    """Refuse a scene whose tractions are the solution of no program."""
    if not isinstance(scene.motion, Steady | Shift):
        allowed = "Steady or Shift: others have no program of their own without the step before"
        raise SceneError("motion", scene.motion, allowed)
    if scene.frictionless:
        raise SceneError("friction", scene.friction, "positive: without it there are no tractions")
    if scene.no_slip:
        why = "where nothing slips there is a linear system, and no program"
        raise SceneError("friction", scene.friction, f"finite: {why}")


def _held_fixed(scene: Scene, disc: Discretisation) -> list[str]:
    """Quantities, in words, that depend on tractions but that a program takes as known; a hardening
    layer is refused.
    """
    if disc.sought(by_slip=False):
        why = "its yield stress follows from the tractions, and no program has it"
        allowed = f"0 in steady rolling and 0 or more in a shift: {why}"
        raise hardening_refused(scene, allowed)
    notes = []
    if disc.sought(by_slip=True):
        notes.append("the static coefficient of friction: its law depends on the slip")
    if disc.K != 0:
        notes.append(f"the pressure, which tractions would change ({scene.difference})")
    return notes


def _checked(formulation: str, names: list[str], reason: str) -> str:
    """The formulation of a program, the first of its names by default."""
    if formulation == "auto":
        return names[0]
    if formulation not in names:
        raise SceneError("formulation", formulation, f"{names[0]} or auto: {reason}")
    return formulation


def _by_program(plan: Plan, problem: str, formulation: str) -> Plan:
    """Plan of a solution by a program that was solved elsewhere."""
    reasons = plan.reasons | {problem: "a program of vc.program, solved elsewhere"}
    changed: dict[str, Any] = {problem: "program", "formulation": formulation}
    return replace(plan, reasons=reasons, **changed)
