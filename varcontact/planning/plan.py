"""What a scene requires, and why; the choice behind "auto". `solve` follows exactly this plan."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any

from varcontact.discrete.subgrid import cells_of
from varcontact.errors import SceneError
from varcontact.html import html_table
from varcontact.planning.costs import Cost
from varcontact.planning.sizes import Sizes
from varcontact.scene.grid import Cells
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import (
    MATRIX_FREE,
    states_programs,
)
from varcontact.theories.methods import THEORIES, Theory


@dataclass(frozen=True)
class Plan:
    """What a scene requires: its kind, the methods chosen, and how large the problems are.

    Attributes
    ----------
    normal : str
        "hertz", or the solver of the normal problem.
    tangential : str
        The solver of the tangential problem; "none" where there is none, "no-slip" where it is linear.
    coupling : str
        "none" for quasi-identical and almost like bodies and without friction, else "johnson", "panagiotopoulos",
        "joint" or "newton".
    formulation : str
        The programs that are solved: "complementary", "potential", "gap" or "marching"; "none" without one.
    reasons : dict
        For each of these and of the following, in one line, why.
    dimension : str
        "three-dimensional" or "line contact".
    bodies : str
        "quasi-identical" (K = 0), "almost like" (the coupling is left out) or "unlike".
    surface : str
        "Hertzian" or "sampled".
    motion : str
        "none", "shift", "steady" (one problem), "marching" (steps until nothing changes) or "transient".
    friction : str
        "given" (numbers, known beforehand), "none", or the law that the coefficient follows, by its kind in a scene
        file: then an outer loop finds it; "several" where a history has more than one of these.
    special : tuple of str
        What is simpler than the general case: "frictionless", "no slip", "full slip".
    fallback : str
        The solver of programs that takes over where active sets, chosen by "auto", miss the tolerance; else "none".
    method : str
        "auto", "convex", "active-set" or "kalker".
    left_out : float
        Where the coupling of almost like bodies is left out: what that changes of the tangential forces at given
        creepages at most, in parts of f Fz, see `varcontact.scene.likeness`; else 0.
    sizes : Sizes, optional
        Grid, elements, matrices and memory: those expected of `varcontact.planning.plan`, those found of a solution.
    costs : tuple of Cost
        Seconds and memory of this plan, then those of other methods; of `varcontact.plan` only.
    doubts : tuple of str
        What looks like a slip of the pen in the scene, see `Scene.doubts`; of `varcontact.plan` only.
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
    fallback: str = "none"
    method: str = "auto"
    left_out: float = 0.0
    costs: tuple[Cost, ...] = field(default=(), compare=False)
    doubts: tuple[str, ...] = field(default=(), compare=False)

    @property
    def closed_form(self) -> bool:
        """Whether the pressure is Hertz's."""
        return self.normal == "hertz"

    def cells(self, scene: Scene) -> Cells:
        """Parts of an element along y and x on which the pressure is solved for; (1, 1): on the elements, or nowhere.

        Parameters
        ----------
        scene : Scene
        """
        return (1, 1) if self.closed_form else cells_of(scene.edge, scene.line)

    @property
    def rubs(self) -> bool:
        """Whether there is a tangential problem."""
        return self.tangential != "none"

    @property
    def theory(self) -> Theory | None:
        """The approximate theory that gives the tractions, if one does."""
        return THEORIES.get(self.tangential)

    @property
    def has_moment(self) -> bool:
        """Whether the method gives a moment: Polach's formula is one of forces alone."""
        return self.tangential != "polach"

    @property
    def programs(self) -> bool:
        """Whether the tangential problem is stated as a convex program."""
        return states_programs(self.tangential)

    @property
    def solves(self) -> bool:
        """Whether the tangential problem itself is solved, by whatever method."""
        return self.rubs and self.theory is None

    @property
    def matrix_free(self) -> bool:
        """Whether the tangential problem is solved by products alone."""
        return self.tangential in MATRIX_FREE

    @property
    def convex(self) -> bool:
        """Whether only solvers of programs are asked."""
        return self.method == "convex"

    @property
    def marches(self) -> bool:
        """Whether steady rolling is marched to."""
        return self.formulation == "marching"

    @property
    def loops(self) -> bool:
        """Whether pressure and tractions are found in passes, until both stay."""
        return self.coupling in ("panagiotopoulos", "joint", "newton")

    @property
    def at_once(self) -> bool:
        """Whether Newton's method has both, before any passes."""
        return self.coupling == "newton"

    @property
    def one_pass(self) -> bool:
        """Whether the pressure is that without tractions, though the bodies differ: Johnson's process."""
        return self.coupling == "johnson"

    @property
    def joint(self) -> bool:
        """Whether a pass has pressure and tractions together."""
        return self.coupling == "joint"

    @property
    def joint_program(self) -> bool:
        """Whether they are the unknowns of one program."""
        return self.joint and self.formulation == "complementary" and self.programs

    def summary(self) -> dict[str, Any]:
        """All of it as dictionaries, lists, numbers and words, as ``varcontact plan --json`` prints it."""
        record = asdict(self)
        for name in ("special", "costs", "doubts"):
            record[name] = list(record[name])
        if self.sizes is not None:
            record["sizes"] |= {"grid": list(self.sizes.grid), "matrices": list(record["sizes"]["matrices"])}
            record["sizes"]["peak"] = self.sizes.peak
        return record

    @classmethod
    def of_record(cls, record: dict[str, Any]) -> Plan:
        """From what `summary` and JSON made of it.

        Parameters
        ----------
        record : dict

        Raises
        ------
        ValueError
            If it is no plan's.
        """
        if not (isinstance(record.get("reasons"), dict) and isinstance(record.get("normal"), str)):
            raise ValueError("a plan without methods and reasons")
        if not isinstance(record.get("left_out", 0.0), (int, float)):
            raise ValueError("a plan whose left_out is no number")
        sizes = dict(record["sizes"]) if record.get("sizes") else None
        if sizes is not None:
            sizes.pop("peak", None)  # follows from the stages
        lists = {"special": tuple(record.get("special", ())), "costs": (), "doubts": ()}  # these stand beside
        return cls(**{**record, **lists, "sizes": None if sizes is None else Sizes.of_record(sizes)})

    def __str__(self) -> str:
        """The plan in words."""
        from varcontact.planning.report import plan_report

        return plan_report(self)

    def _repr_html_(self) -> str:
        from varcontact.planning.report import plan_rows

        return html_table("Plan", plan_rows(self))

    def __repr__(self) -> str:
        names = ("method", "normal", "tangential", "coupling", "formulation")
        words = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"Plan({words})"


def plan(
    scene: Scene,
    normal: str = "auto",
    tangential: str = "auto",
    coupling: str = "auto",
    *,
    formulation: str = "auto",
    method: str = "auto",
) -> Plan:
    """What a scene requires, and why, before anything is solved: `solve` follows exactly this plan.

    It takes closed forms and no influence numbers but one. Where the contact is Hertz's, elements and matrices are
    those that will be. Where it is found by solving (sampled distances, unlike bodies, a normal program that is asked
    for), the sizes are upper bounds, and say so; those found stand in the `plan` of the solution.

    Parameters
    ----------
    scene : Scene
    normal, tangential, coupling, formulation, method : str
        As in `solve`.

    Returns
    -------
    Plan

    Raises
    ------
    SceneError
        For a scene that cannot be treated, or a method that does not exist or cannot treat it.
    SolverUnavailable
        If the package of a method is not installed.
    TooLarge
        If not even the grid fits into memory. Whether solving does, `sizes.peak` tells; printed, the plan says so.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30), normal_force=106.7e3,
    ...     friction=0.33, motion=vc.Steady(vx=1e-3), grid=vc.Grid(nx=12, ny=12))
    >>> plan = vc.plan(scene)
    >>> plan.normal, plan.bodies, plan.sizes.elements, plan.sizes.mirrored
    ('hertz', 'quasi-identical', {'normal': 112, 'tangential': 112}, True)
    >>> [matrix.name for matrix in plan.sizes.matrices if matrix.kind == "table"]
    ['A_zz', 'A_tt - C_tt']
    """
    if not isinstance(scene, Scene):
        raise SceneError("scene", scene, "a Scene")
    from varcontact.planning.choice import make_plan
    from varcontact.planning.costs import costs
    from varcontact.planning.expectations import expected_sizes

    chosen = make_plan(scene, normal, tangential, coupling, formulation, method)
    if scene.grid == "auto" and chosen.theory is None and not scene.no_slip:
        why = "solve chooses one for an error of 1 %; the sizes below are those of 24 elements across"
        if scene.line:
            why = why.replace("24", "100")
        chosen = replace(chosen, special=(*chosen.special, "no grid"), reasons=chosen.reasons | {"no grid": why})
    chosen = replace(chosen, sizes=expected_sizes(scene, chosen))
    return replace(chosen, costs=costs(scene, chosen), doubts=scene.doubts)
