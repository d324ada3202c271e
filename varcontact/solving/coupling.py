"""Where the bodies differ, pressure and traction depend on each other (paper, sections 2 and 4.5).

Johnson's process is a single pass: the pressure without tractions, then the tractions. The two loops here repeat
passes until the whole is solved. Both are fixed points, Panagiotopoulos's of the tractions, the joint one of the
traction bound; where a fixed point is approached slowly or not at all, Anderson's acceleration takes over.

Sources: P. D. Panagiotopoulos, Ing.-Arch. 44 (1975) 421-432; K. L. Johnson, Contact Mechanics, Cambridge University
Press 1985; for Anderson's acceleration see `varcontact.solving.fixed_point`.
"""

from __future__ import annotations

from dataclasses import replace

from varcontact.discrete.state import ContactState
from varcontact.solving.fixed_point import Judge, Limits, Step, Unknown, distance, fixed_point


def panagiotopoulos(
    start: ContactState, normal: Step, tangential: Step, residual: Judge, tol: float, max_passes: int = 100
) -> ContactState:
    """Normal problem with the tractions fixed, tangential problem with the pressure fixed, until neither changes.

    The paper's process (4.5), from the pressure without tractions.

    Parameters
    ----------
    start : ContactState
        With the pressure that goes with its tractions, or with none.
    normal, tangential : callable
        The two problems, from one state to the next.
    residual : callable
        Natural-map residual of the whole in a state.
    tol : float
        Residual to stop at.
    max_passes : int

    Returns
    -------
    ContactState
        That of the least residual; `passes` tells how it went.
    """

    def one_pass(state: ContactState) -> ContactState:
        return tangential(normal(state))

    return fixed_point(tangential(start), one_pass, Unknown("traction"), residual, Limits(tol, max_passes))


def joint(start: ContactState, together: Step, residual: Judge, tol: float, max_passes: int = 100) -> ContactState:
    """Pressure and tractions together with the traction bound fixed, until that stays.

    Parameters
    ----------
    start : ContactState
        With the pressure without tractions, which gives the first bound.
    together : callable
        Pressure and tractions under the bound that `bound_pressure` gives.
    residual, tol, max_passes
        As in `panagiotopoulos`.
    """

    def one_pass(state: ContactState) -> ContactState:
        return replace(together(replace(state, bound_pressure=state.pressure)), bound_pressure=None)

    return fixed_point(one_pass(start), one_pass, Unknown("pressure", least=0.0), residual, Limits(tol, max_passes))


def alternating(start: ContactState, normal: Step, tangential: Step, tol: float, max_passes: int = 50) -> ContactState:
    """A joint pass by alternation: both problems in turn under a fixed bound.

    In a shift that is block descent of the complementary energy, which is convex, and converges.

    Parameters
    ----------
    start : ContactState
    normal, tangential : callable
        From a state to one with the pressure, or the tractions, that go with the rest.
    tol : float
        Change of the tractions at which it ends, relative [-].
    max_passes : int
    """
    state = tangential(start)
    for _ in range(max_passes):
        after = tangential(normal(state))
        change = distance(after.traction, state.traction)
        state = after
        if change <= tol:
            break
    return state
