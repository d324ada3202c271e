"""How large the problems of a plan are: elements, unknowns, matrices, bytes; found without solving anything."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.mirror import mirror_of
from varcontact.discrete.operators import DryRun, Operators
from varcontact.discrete.positive_definite import DENSE_LIMIT
from varcontact.discrete.state import ContactState
from varcontact.discrete.subgrid import normal_as_solved
from varcontact.elasticity.operators import table_bytes
from varcontact.planning import memory
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import MATRIX_FREE, states_programs

if TYPE_CHECKING:
    from varcontact.planning.plan import Plan


@dataclass(frozen=True)
class Matrix:
    """One block of influence numbers that a plan assembles.

    Attributes
    ----------
    name : str
        As in "A_zz" or "A_tt - C_tt": t is along x and y, z normal.
    kind : {"table", "dense", "factor"}
        By offset, for products by FFT, with its transform; element by element; or Cholesky's factor of that.
    rows, columns : int
        Of a table: numbers of offsets along y and x.
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
    """How large the problems of a plan are.

    Attributes
    ----------
    grid : (int, int)
        Rows and columns of the potential contact, (ny, nx).
    sides : (float, float), optional
        Of an element [length]; None where the contact has to be looked for first.
    elements : dict
        By problem, "normal" and "tangential": the elements that enter it.
    unknowns : dict
        By problem: pressures, or traction components.
    mirrored : bool
        Whether the tangential problem is solved on one side of its line of symmetry only.
    matrices : tuple of Matrix
    memory : dict
        Bytes at the peak of each stage: "normal", "tangential" (or "joint", or also "both"),
        "certificate".
    exact : bool
        Whether elements are known; otherwise they, and what follows from them, are upper bounds.
    """

    grid: tuple[int, int]
    sides: tuple[float, float] | None
    elements: dict[str, int]
    unknowns: dict[str, int]
    mirrored: bool
    matrices: tuple[Matrix, ...]
    memory: dict[str, float]
    exact: bool

    @property
    def peak(self) -> float:
        """Bytes at the peak of the stage that needs most."""
        return max(self.memory.values())

    @property
    def hungriest(self) -> str:
        """The stage that needs most."""
        return max(self.memory, key=self.memory.__getitem__)

    @classmethod
    def of_record(cls, record: dict[str, Any]) -> Sizes:
        """From what `dataclasses.asdict` and JSON made of it.

        Parameters
        ----------
        record : dict
        """
        sides = record["sides"]
        lists = {"grid": tuple(record["grid"]), "sides": None if sides is None else tuple(sides)}
        return cls(**{**record, **lists, "matrices": tuple(Matrix(**one) for one in record["matrices"])})


@dataclass(frozen=True)
class Counted:
    """Numbers of elements.

    Attributes
    ----------
    normal, contact, tangential : int
        Of the normal problem, where its unknowns are on parts of elements of these parts, of the contact, and of the
        tangential problem.
    components : int
        Of the tractions: 1 or 2.
    mirrored : bool
        Whether the tangential problem is its own mirror image.
    exact : bool
        Whether they are known, and no upper bounds.
    """

    normal: int
    contact: int
    tangential: int
    components: int = 2
    mirrored: bool = False
    exact: bool = True


def sizes_found(scene: Scene, disc: Discretisation, plan: Plan, state: ContactState) -> Sizes:
    """Sizes of what was solved in the end.

    Parameters
    ----------
    scene : Scene
    disc : Discretisation
    plan : Plan
    state : ContactState
        Of the solution, dimensionless.
    """
    traction = state.traction if plan.coupling != "none" and np.any(state.traction) else None
    contact = int(np.sum(state.pressure > 0))
    normal = contact if plan.closed_form else _reachable(disc, state, traction)
    if plan.joint:
        normal = disc.grid.size
    counted = Counted(normal, contact, 0)
    if plan.rubs:
        problem = disc.tangential_problem(state.pressure)
        folded = folds(plan) and mirror_of(problem) is not None
        counted = Counted(normal, contact, problem.size, len(problem.rigid_shift), folded)
    return sizes_of(scene, plan, disc.grid.shape, disc.grid.sides, counted)


def _reachable(disc: Discretisation, state: ContactState, traction: np.ndarray | None) -> int:
    """Elements of the normal problem, or parts of them, that can come into contact at all."""
    return normal_as_solved(disc, state.pressure, state.approach, traction)[0].reachable().distance.size


def folds(plan: Plan) -> bool:
    """Whether only half of a tangential problem is solved that is its own mirror image: products by FFT take all.

    Parameters
    ----------
    plan : Plan
    """
    return plan.solves and not plan.matrix_free


def sizes_of(
    scene: Scene, plan: Plan, shape: tuple[int, int], sides: tuple[float, float] | None, counted: Counted
) -> Sizes:
    """The sizes of a plan on a grid of a given shape, for known numbers of elements or upper bounds.

    Parameters
    ----------
    scene : Scene
    plan : Plan
    shape : tuple of int
        (ny, nx) of the grid.
    sides : tuple of float, or None
        dx and dy of the elements, where known [length].
    counted : Counted
    """
    cells = plan.cells(scene)
    elements = {"normal": math.ceil(counted.normal / math.prod(cells))}
    unknowns = {"normal": 0 if plan.closed_form else counted.normal}
    if plan.rubs:
        elements["tangential"] = counted.tangential
        part = 2 if counted.mirrored else 1
        unknowns["tangential"] = counted.components * counted.tangential // part if plan.solves else 0
    matrices = (*_tables(scene, plan, shape), *_blocks(scene, plan, shape[0] * shape[1], counted))
    always: float = sum(matrix.bytes for matrix in matrices if matrix.kind == "table")
    always += shape[0] * shape[1] * (memory.FIELD_BYTES + (0.0 if plan.theory is None else memory.THEORY_BYTES))
    stages = {name: always + size for name, size in _stages(scene, plan, unknowns, counted, matrices).items()}
    return Sizes(shape, sides, elements, unknowns, counted.mirrored, matrices, stages, counted.exact)


def _tables(scene: Scene, plan: Plan, shape: tuple[int, int]) -> Iterator[Matrix]:
    """Influence numbers by offset: a dry run of the operators, each asked for only where it is needed."""
    steady, unlike = isinstance(scene.motion, Steady), scene.bodies.K != 0 and not plan.left_out
    lattice = Grid(nx=shape[1], dx=1.0, x0=0.0)
    if not scene.line:
        lattice = Grid(nx=shape[1], ny=shape[0], dx=1.0, dy=1.0, x0=0.0, y0=0.0)
    dry, lag = DryRun(), 1.0 if steady else None
    operators = Operators(lattice, scene.bodies.combined_nu, scene.bodies.K if unlike else 0.0, make=dry)
    reasons: dict[str, str] = {}

    def needed(ask: Callable[[], object], reason: str) -> None:
        ask()
        reasons.update({name: reason for name in dry.bytes if name not in reasons})

    judged = "distances, and the residual of Hertz's pressure" if plan.closed_form else "distances due to pressures"
    needed(lambda: operators.normal, judged)
    if plan.rubs:
        needed(lambda: operators.tangential(lag), "shifts due to tractions")
    if isinstance(scene.motion, Transient) and plan.rubs:
        needed(lambda: operators.carrying(1.0), "displacements that particles bring along, a table per step length")
    if plan.marches and steady:
        needed(lambda: operators.tangential(), "a step of the march")
    if unlike and scene.motion is not None:
        needed(lambda: operators.pressure_to_shift(lag), "K != 0: shifts due to pressures")
    if unlike and plan.rubs:
        needed(lambda: operators.traction_to_distance, "K != 0: distances due to tractions")
    for name, size in dry.bytes.items():
        yield Matrix(name, "table", 2 * shape[0] - 1, 2 * shape[1] - 1, size, reasons[name])
    cells = plan.cells(scene)
    if cells != (1, 1):
        rows, columns = shape[0] * cells[0], shape[1] * cells[1]
        size, why = table_bytes(rows, columns, 1), "pressures on parts of the elements"
        yield Matrix("A_zz of parts", "table", 2 * rows - 1, 2 * columns - 1, size, why)


def _blocks(scene: Scene, plan: Plan, size: int, counted: Counted) -> Iterator[Matrix]:
    """Dense matrices on the elements of each problem."""
    name = "A_tt - C_tt" if isinstance(scene.motion, Steady) else "A_tt"

    def block(name: str, kind: str, rows: int, columns: int, reason: str, at_most: bool = False) -> Matrix:
        return Matrix(name, kind, rows, columns, 8 * rows * columns, reason, at_most or not counted.exact)

    n, m = counted.normal, counted.components * counted.tangential
    if states_programs(plan.normal):
        yield block("A_zz", "dense", n, n, "the normal program")
    if plan.normal not in ("hertz", *MATRIX_FREE) and not plan.convex:
        yield block("A_zz", "factor", n, n, "NORM, on the current contact", at_most=True)
    if not plan.rubs or m == 0:
        return
    joint = plan.joint_program
    steps_only = plan.marches and not (plan.programs and not plan.convex)  # a polish is of the whole, not of a step
    whole = (plan.solves and not steps_only) or plan.tangential == "linear"
    whole = whole and not plan.matrix_free
    if counted.mirrored and whole:
        yield block(name, "dense", m // 2, m // 2, "the tangential problem, on one side of its line of symmetry")
    elif whole:
        yield block(name, "dense", m, m, "the tangential problem")
    if plan.marches and not plan.matrix_free:
        half = m // 2 if counted.mirrored else m
        yield block("A_tt", "dense", half, half, "a step of the march")
    if joint:
        yield block("A_zt", "dense", size, m, "the joint program")
    factored = counted.tangential if counted.exact else min(counted.tangential, DENSE_LIMIT)
    guaranteed = (scene.bodies.K == 0 or plan.left_out > 0) and not scene.under_law and factored <= DENSE_LIMIT
    if joint and (counted.mirrored or not whole):
        yield block(name, "dense", m, m, "the joint program")
    elif guaranteed and (counted.mirrored or not whole):
        rows = counted.components * factored
        yield block(name, "dense", rows, rows, "the certificate's bound on forces")


def _stages(
    scene: Scene, plan: Plan, unknowns: dict[str, int], counted: Counted, matrices: tuple[Matrix, ...]
) -> dict[str, float]:
    """Bytes at the peak of each stage without tables and fields."""
    stages, kept = {}, 0.0
    if not plan.closed_form:
        stages["normal"] = memory.peak(plan.normal, plan.formulation, unknowns["normal"], memory.NORMAL_BYTES)
        if not states_programs(plan.normal) and plan.normal not in MATRIX_FREE:
            kept = memory.KEPT_FACTORS * 8 * counted.contact**2
        elif states_programs(plan.normal) and (plan.loops or scene.under_law):  # set-ups wait for the next pass
            kept = stages["normal"]
    if unknowns.get("tangential"):
        stages["tangential"] = kept + memory.peak(plan.tangential, plan.formulation, unknowns["tangential"])
    if plan.at_once:
        stages["both"] = memory.peak("newton", plan.formulation, unknowns["normal"] + unknowns["tangential"])
    blocks = [matrix for matrix in matrices if matrix.kind == "dense"]
    for matrix in blocks:
        if matrix.name == "A_zt":
            stages["joint"] = memory.peak(plan.tangential, "complementary", matrix.rows + matrix.columns)
    judged = [matrix.bytes for matrix in blocks if matrix.name.startswith("A_tt")]
    stages["certificate"] = kept + memory.CERTIFICATE_MATRICES * max(judged, default=0.0)
    return stages
