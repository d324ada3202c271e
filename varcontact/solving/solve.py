"""`solve`: a scene and its methods, then the plan, then its solution."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Unpack, overload

import numpy as np

from varcontact import checks
from varcontact.discrete.certificate import Certificate, certificate_of
from varcontact.discrete.stick_slip import ContactResponse, with_implied_fields
from varcontact.errors import PlausibilityWarning, SceneError, warn
from varcontact.results.history import History
from varcontact.results.solution import Solution
from varcontact.scene.motion import Harmonic, Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.given_pressure import check_placed, contact_under
from varcontact.solving.methods import CouplingName, Methods
from varcontact.solving.on_grid import solve_on_grid
from varcontact.solving.options import TOLERANCE, Options, SolveOptions
from varcontact.solving.own_solvers import SolverChoice
from varcontact.solving.selection import select
from varcontact.system.process import changed, one_blas_thread
from varcontact.system.progress import Progress

if TYPE_CHECKING:
    from varcontact.results.frequency import HarmonicSolution


@overload
def solve(
    scene: Scene[Transient],
    normal: SolverChoice = "auto",
    tangential: SolverChoice = "auto",
    coupling: CouplingName = "auto",
    **options: Unpack[Options],
) -> History: ...


@overload
def solve(
    scene: Scene[Steady] | Scene[Shift] | Scene[None],
    normal: SolverChoice = "auto",
    tangential: SolverChoice = "auto",
    coupling: CouplingName = "auto",
    **options: Unpack[Options],
) -> Solution: ...


@overload
def solve(
    scene: Scene[Harmonic],
    normal: SolverChoice = "auto",
    tangential: SolverChoice = "auto",
    coupling: CouplingName = "auto",
    **options: Unpack[Options],
) -> HarmonicSolution: ...


@checks.named_options()
@one_blas_thread()
def solve(
    scene: Scene,
    normal: SolverChoice = "auto",
    tangential: SolverChoice = "auto",
    coupling: str = "auto",
    *,
    formulation: str = "auto",
    method: str = "auto",
    methods: Methods | None = None,
    tol: float = TOLERANCE,
    polish: bool | None = None,
    start: str | Solution | None = None,
    certify: str | None = "auto",
    refine: object = None,
    progress: Progress = None,
    store: str | Path | None = None,
    accuracy: float | None = None,
    time_budget: float | None = None,
    trace: bool = False,
) -> Solution | History | HarmonicSolution:
    """Solve a scene.

    Parameters
    ----------
    scene : Scene
    normal : str or callable
        Method of the normal problem: "auto"; "hertz", closed form; "clarabel",
        "osqp", "scs", "qpsolvers:<name>" or "cvxpy:<NAME>", a QP; "norm" or
        "norm-single", active sets; "newton" or "splitting", without a matrix.
        Hertz's pressure is sampled at the element centres and scaled (by one within the grid's
        error) so that the elements carry exactly the normal force; or averaged
        over them, see `Grid`. Or a name of `register_solver`, or such a
        function itself.
    tangential : str or callable
        Method of the tangential problem: "auto"; "clarabel", "scs" or
        "cvxpy:<NAME>", a second-order-cone program; "tang" (rough Newton steps
        between exchanges), "tang-exact" (as printed) or "tang-safeguarded",
        active sets; "newton" or "splitting", without a matrix; or an
        approximate theory: "fastsim", "fastsim-elliptic" (in time, too),
        "linear", "vermeulen-johnson"; or "table", exact forces interpolated; or
        a solver of your own, as for `normal`.
    coupling : {"auto", "johnson", "panagiotopoulos", "joint", "newton", "splitting", "active-set"}
        Coupling of the normal and the tangential problem where the bodies
        differ (K != 0). "johnson": one pass; "panagiotopoulos": both problems
        in turn; "joint": pressure and tractions together with only the traction
        bound fixed; "newton", "splitting": both at once by that method, without
        a matrix; "active-set": at once on their areas, by dense matrices; and
        in turn where these fail.
    formulation : {"auto", "complementary", "potential", "gap", "marching"}
        The programs: by complementary energy (215), by potential energy (214),
        by the duality gap; or, in steady rolling, transient steps until nothing
        changes. Steady rolling has "gap" and "marching", the shift all but
        "marching".
    method : {"auto", "convex", "conic", "active-set", "kalker"}
        The overall method; `normal` and `tangential` refine it. "convex": the
        convex problems by splitting, without a matrix and at any size, which is
        proved to converge (docs/proofs.md); of unlike bodies the coupling
        "splitting" finds both at once, so that each is the answer of its convex
        problem with the other's fields, which no theorem promises. "conic": the QP of pressures by
        Clarabel or OSQP and the second-order-cone program of tractions by
        Clarabel, for unlike bodies in Panagiotopoulos's loop, each answer
        refined by splitting. "active-set": NORM and the safeguarded TANG, and
        no program. "kalker": NORM and TANG as printed. "auto": the fastest by
        measurement, but any solver or theory may be named; where it misses the
        tolerance, splitting goes on from its best point. Hertz's pressure in
        closed form is part of all of them, unless another `normal` is named.
    methods : Methods, optional
        The five names above as one object, in their place.
    tol : float
        Natural-map residual to reach, relative to the largest traction. Every
        method reaches the default.
    polish : bool, optional
        Take the answer of a solver of programs to rounding by NORM and the
        safeguarded TANG, started from it: done unless it is said to be False,
        but never by the method "convex" or "conic". Without polish and refinement an
        interior-point answer is good to between 1e-6 and 1e-9 in the tractions,
        and a smaller `tol` is not reached. Active-set methods and theories are
        never polished.
    start : {"stick", "slip"} or Solution, optional
        Under a law of friction, which of the solutions is sought: that with
        much friction, from the static coefficient all over, which is what is
        done if nothing is given; that with little, from the kinetic one all
        over; or that near a solution with as many elements either way, from the
        coefficients found there. With an accuracy or a `time_budget`, "slip"
        if nothing is given: under a static and a kinetic coefficient both tend
        to the same continuum, but from "slip" faster. In a history each
        particle goes on as it did in the step before if nothing is given.
    certify : {"auto", "full", "gap", "none"} or None
        Level of the certificate: "full", with guaranteed bounds
        on the forces; "gap", without them; "none", or None, the residuals
        alone, which are always there. "auto" is "full" up to 10 000 elements
        with friction, "gap" beyond and in the steps of a history, and computes
        the bounds, and by a theory the whole certificate, when they are first
        read. The report says what is left out.
    refine : None
        Refused: `accuracy`, without a grid, takes its place.
    progress : callable or true, optional
        Called with the name of each stage as it starts; in a history, with the
        number of steps done.
    store : str or Path, optional
        File to which the steps of a history are added as they are finished, so
        that memory does not grow with them. Called again with the same scene,
        methods and file, an interrupted history goes on where it stopped.
    accuracy : float, optional
        Largest error against the continuum, below 1: of Fx and Fy by f Fz, of
        Mz by f Fz sqrt(ab); of a creepage that follows from a prescribed force
        by the saturation creepage; without friction of the approach and the
        largest pressure by themselves. The grid is then chosen, the error
        estimated from the answer itself, and the grid refined until the
        estimate is below. The scene has no grid of its own. Without a grid,
        0.01 if neither this nor a time is given; but for infinite friction,
        theories, "marching", a `store`, a `Solution` to start from, a history
        without `dq`, and a motion with `dq` or a slip difference of its own:
        these take the usual grid, and have no error bar.
    time_budget : float, optional
        In place of an accuracy: seconds. The most accurate answer that is
        expected within them.
    trace : bool
        Whether to keep the iterates of the solvers with their residual, gap,
        objective and changes of area, as `Solution.trace`, see `plot_traces`.
        Not of a history. Measuring takes several times as long as solving.

    Returns
    -------
    Solution, History or HarmonicSolution
        A History where the motion is `Transient`, a HarmonicSolution where it
        is `Harmonic`; the methods are then those of the contact in free
        rolling. With `accuracy` or `time_budget`, the solution on the finest
        grid that was solved, with its `error_estimate`, whose values are those
        of the solution.

    Raises
    ------
    SceneError
        For arguments or scenes that cannot be treated: no element in contact,
        or contact beyond the grid.
    SolverUnavailable
        If the package of a method is not installed.
    Saturated
        If a prescribed tangential force is beyond what friction can carry.
    Interrupted
        A history by Ctrl-C; its `partial` is what is finished. The errors
        above, where a step of a history raises them, have the steps before as
        their `history`, and the step's number as `step`.
    NotConverged
        If the tolerance, or an accuracy that was given, is not reached; its
        `solution` is the best iterate. For Johnson's process the residuals of
        its two problems count; the residual of the whole is in the
        certificate.
    TooLarge
        If the matrices would not fit into memory.
    OutputError
        If the store cannot be written, holds something else, or another run
        adds to it.

    Warns
    -----
    PlausibilityWarning
        For likely mistakes, before any work, see `Scene.doubts`.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(vx=1e-3),
    ...     grid=vc.Grid(nx=12, ny=12))
    >>> sol = vc.solve(scene)
    >>> f"{sol.force[0] / (0.33 * sol.normal_force):.3f}"
    '-0.392'
    >>> sol.certificate.relative_gap < 1e-12
    True
    """
    # amplitudes are found about the contact in free rolling
    solved = scene
    swings = isinstance(scene, Scene) and isinstance(scene.motion, Harmonic)
    if swings:
        solved = replace(scene, motion=scene.motion.free_rolling)
    options = SolveOptions.checked(
        solved,
        normal=normal,
        tangential=tangential,
        coupling=coupling,
        formulation=formulation,
        method=method,
        methods=methods,
        tol=tol,
        polish=polish,
        start=start,
        certify=certify,
        refine=refine,
        store=store,
        accuracy=accuracy,
        time_budget=time_budget,
        progress=progress,
        trace=trace,
    )
    for doubt in scene.doubts:
        warn(doubt, PlausibilityWarning)
    # on grids that are chosen, in steps, or on the scene's own grid
    answer: Solution | History
    if options.target is not None:
        from varcontact.solving import adaptive

        answer = adaptive.solve(solved, options)
    elif isinstance(solved.motion, Transient):
        from varcontact.solving.history import solve_transient

        answer = solve_transient(solved, options)
    else:
        answer = solve_on_grid(solved, options)
    if isinstance(answer, Solution) and scene.doubts:
        answer = changed(answer, warnings=(*scene.doubts, *answer.warnings))
    if swings:
        from varcontact.results.frequency import harmonic_solution

        return harmonic_solution(scene, answer)
    return answer


@checks.named_options()
@one_blas_thread()
def certify(scene: Scene, traction: np.ndarray, pressure: np.ndarray | None = None) -> Certificate:
    """Judge tractions from any source by the gap and the residuals of the
    scene's own problem, by FFT.

    Parameters
    ----------
    scene : Scene
        With an explicit grid, or a Hertzian surface; no prescribed tangential
        force.
    traction : array_like, shape (2, ny, nx)
        Tangential tractions on body 1 [force/area].
    pressure : array_like, shape (ny, nx), optional
        Pressures [force/area]; Hertz's, where the surface is Hertzian and none
        are given. With elements at the edge that count in part those on the
        parts, as of `Solution.pressure_on_parts`.

    Returns
    -------
    Certificate

    Raises
    ------
    SceneError
        If the arrays are not of the grid's shape, or an entry that is
        needed is missing in the scene.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.1), grid=vc.Grid(nx=16, ny=16))
    >>> sol = vc.solve(scene)
    >>> best = vc.certify(scene, sol.traction)
    >>> vc.certify(scene, 0.99 * sol.traction).relative_gap > best.relative_gap
    True
    """
    checks.kind("scene", scene, Scene)
    _check_certifiable(scene)
    plan = select(scene, Methods(normal="hertz" if pressure is None else "clarabel"))
    disc, state = contact_under(scene, plan.potential_contact.known, pressure, traction)
    disc = with_implied_fields(disc, state, by_slip=True)
    return certificate_of(ContactResponse(disc, state), plan.closed_form)


def _check_certifiable(scene: Scene) -> None:
    """Refuse a scene whose tractions cannot be certified alone."""
    motion = scene.motion
    if not isinstance(motion, Steady | Shift) or motion.Fx is not None or motion.Fy is not None:
        allowed = "Steady or Shift, with no prescribed force, for tractions to be certified"
        raise SceneError("motion", motion, allowed)
    check_placed(scene, "for tractions to be certified")
