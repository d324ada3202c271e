"""Plan of a scene before anything is solved: methods with their reasons, sizes and costs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from varcontact import checks
from varcontact.discrete.contact_grid import (
    no_element_in_contact,
    shape_with_margin,
)
from varcontact.discrete.discretisation import discretise
from varcontact.discrete.penetration import outside
from varcontact.discrete.state import hertz_pressure, unloaded
from varcontact.errors import SceneError
from varcontact.results.plan import Cost, Matrix, Plan, Sizes
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solvers.registry import Kind
from varcontact.solving.methods import CouplingName, FormulationName, MethodName, Methods
from varcontact.solving.own_solvers import SolverChoice
from varcontact.solving.pipeline import check_memory, own_image, peak, tangential_unknowns
from varcontact.solving.selection import PRESETS, select

SECONDS = {"products": (1.2e-5, 1.0), "active sets": (1.2e-9, 3.0), "program": (2e-8, 3.0)}
"""Seconds of one solve on one core, ``factor n^exponent`` with n elements: of their order, by kind
of method."""


@checks.named_options()
def plan(
    scene: Scene,
    normal: SolverChoice = "auto",
    tangential: SolverChoice = "auto",
    coupling: CouplingName = "auto",
    *,
    formulation: FormulationName = "auto",
    method: MethodName = "auto",
    methods: Methods | None = None,
) -> Plan:
    """Plan of a scene, with reasons, before anything is solved: `solve` follows exactly this plan.

    Sizes, memory and seconds are estimated from the number of elements. Where
    the contact is Hertz's, that is known; where it is found by solving (sampled
    distances, unlike bodies, a normal program that is asked for), they are
    upper bounds, and say so.

    Parameters
    ----------
    scene : Scene
    normal, tangential, coupling, formulation, method : str
        As in `solve`.
    methods : Methods, optional
        The five as one object, in their place.

    Returns
    -------
    Plan

    Raises
    ------
    SceneError
        For a scene that cannot be treated, or a method that does not exist or
        cannot treat it.
    SolverUnavailable
        If the package of a method is not installed.
    TooLarge
        If not even the grid fits into memory. Whether solving does,
        `sizes.peak` tells; printed, the plan says so.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(vx=1e-3),
    ...     grid=vc.Grid(nx=12, ny=12))
    >>> plan = vc.plan(scene)
    >>> plan.normal, plan.bodies, plan.sizes.elements, plan.sizes.mirrored
    ('hertz', 'quasi-identical', {'normal': 112, 'tangential': 112}, True)
    >>> [matrix.name for matrix in plan.sizes.matrices if matrix.kind == "table"]
    ['A_zz', 'A_tt - C_tt']
    """
    named = Methods.given(
        methods,
        normal=normal,
        tangential=tangential,
        coupling=coupling,
        formulation=formulation,
        method=method,
    )
    chosen = select(scene, named)
    special = chosen.special
    if scene.grid == "auto" and chosen.theory is None and not scene.no_slip:
        special = (*special, "no grid")
    usual = 100 if scene.line else 24
    sizes_of_usual = f"the sizes below are those of {usual} elements across"
    why = {
        "frictionless": "friction is 0: no tangential problem",
        "no slip": "friction is infinite: no bound and no cones, one linear system",
        "no grid": f"solve chooses one for an error of 1 %; {sizes_of_usual}",
    }
    sizes = _sizes(scene, chosen)
    costs = [_cost(scene, chosen, sizes)]
    for other in PRESETS:
        if other not in (chosen.method, "kalker"):
            try:
                costs.append(_cost(scene, select(scene, Methods(method=other)), sizes))
            except SceneError:  # the method is not for this scene
                continue
    reasons = chosen.reasons | {"bodies": scene.difference, **{name: why[name] for name in special}}
    return replace(
        chosen,
        special=special,
        reasons=reasons,
        sizes=sizes,
        costs=tuple(costs),
        doubts=scene.doubts,
    )


def check_planned(planned: Plan) -> None:
    """Refuse a plan whose sizes are known, and need more memory than there is, as `solve` does."""
    sizes = planned.sizes
    if sizes is not None and sizes.exact:
        for problem, unknowns in sizes.unknowns.items():
            check_memory(problem, planned.solver_of(problem), planned.formulation, unknowns)


def _sizes(scene: Scene, plan: Plan) -> Sizes:
    history = isinstance(scene.motion, Transient)
    grid = plan.potential_contact.known
    if history:
        grid = plan.potential_contact.form
    shape = shape_with_margin(grid)
    placed = grid.explicit and not history
    exact = plan.closed_form and placed
    contact = np.ones(shape, dtype=bool)
    if placed:
        contact = _contact(scene, plan, grid)
    count = int(contact.sum())
    elements: dict[Kind, int] = {"normal": count}
    unknowns: dict[Kind, int] = {"normal": 0}
    if not plan.closed_form:
        unknowns["normal"] = count * math.prod(plan.cells(scene))
    if plan.has_friction:
        count = _elements_with_friction(scene, contact)
        elements["tangential"] = count
        unknowns["tangential"] = 0
        if plan.solves:
            unknowns["tangential"] = round(tangential_unknowns(scene, plan, count))
    mirrored = plan.solves and not plan.matrix_free("tangential") and own_image(scene)
    return Sizes(
        shape,
        grid.sides if grid.explicit else None,
        elements,
        unknowns,
        mirrored=mirrored,
        matrices=_matrices(scene, plan, shape, unknowns, exact),
        memory={
            problem: peak(plan.solver_of(problem), plan.formulation, n)
            for problem, n in unknowns.items()
        },
        exact=exact,
    )


def _elements_with_friction(scene: Scene, contact: np.ndarray) -> int:
    """Elements in contact with friction."""
    if isinstance(scene.friction, np.ndarray):
        contact = contact & (scene.friction.reshape(contact.shape) > 0)
    return int(np.sum(contact))


def _contact(scene: Scene, plan: Plan, grid: Grid) -> np.ndarray:
    """Elements that may be in contact; a grid that does not hold Hertz's contact is refused as by
    `solve`.
    """
    disc = discretise(scene, grid)
    if not plan.closed_form:
        return np.ones(grid.shape, dtype=bool)
    assert disc.hertz is not None
    if not disc.hertz.on_elements(grid).any():
        raise no_element_in_contact(scene.surface, scene.approach, grid)
    state = hertz_pressure(disc, unloaded(grid))
    overlap = outside(disc, state, closed_form=True)
    if overlap is not None:
        plan.potential_contact.enlarged(grid, state.pressure, overlap)
    return np.asarray(state.pressure > 0)


def _matrices(
    scene: Scene, plan: Plan, shape: tuple[int, int], unknowns: dict[Kind, int], exact: bool
) -> tuple[Matrix, ...]:
    rows = 2 * shape[0] - 1
    columns = 2 * shape[1] - 1
    unlike = scene.coupled
    tangential = "A_tt"
    across = "A_tz"
    if isinstance(scene.motion, Steady):
        tangential = "A_tt - C_tt"
        across = "A_tz - C_tz"
    tables = [("A_zz", 1, "distances due to pressures")]
    if plan.has_friction:
        components = 2 if scene.line else 3
        tables.append((tangential, components, "shifts due to tractions"))
    if unlike and scene.motion is not None:
        tables.append((across, 2, "K != 0: shifts due to pressures"))
    if unlike and plan.has_friction:
        tables.append(("A_zt", 2, "K != 0: distances due to tractions"))
    size = 16 * rows * columns
    matrices = [
        Matrix(name, "table", rows, columns, components * size, why)
        for name, components, why in tables
    ]
    dense: tuple[tuple[Kind, str], ...] = (("normal", "A_zz"), ("tangential", tangential))
    for problem, name in dense:
        n = unknowns.get(problem, 0)
        if n and not plan.matrix_free(problem):
            why = f"the {problem} problem"
            matrices.append(Matrix(name, "dense", n, n, 8 * n**2, why, not exact))
    return tuple(matrices)


def _cost(scene: Scene, plan: Plan, sizes: Sizes) -> Cost:
    """The cost of one solve: of a history, of unlike bodies and under a law of friction there are
    many.
    """
    seconds = 0.0
    needed = 0.0
    to_solve = {"normal": not plan.closed_form, "tangential": plan.solves}
    for problem, elements in sizes.elements.items():
        if not to_solve[problem]:
            continue
        kind = "active sets"
        if plan.matrix_free(problem):
            kind = "products"
        elif plan.states_program(problem):
            kind = "program"
        unknowns = float(elements)
        if problem == "tangential":
            unknowns = tangential_unknowns(scene, plan, elements)
        factor, exponent = SECONDS[kind]
        seconds += factor * elements**exponent
        needed = max(needed, peak(plan.solver_of(problem), plan.formulation, unknowns))
    return Cost(plan.method, plan.normal, plan.tangential, seconds, needed)
