"""The methods of studies: what their names say."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

from varcontact import checks
from varcontact.errors import SceneError, SolverUnavailable
from varcontact.planning.choice import FORMULATIONS, make_plan
from varcontact.planning.plan import Plan
from varcontact.planning.roads import ROADS
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import available, normal_methods, states_programs, tangential_methods
from varcontact.theories.on_grid import THEORIES


@dataclass(frozen=True)
class Method:
    """A method of comparison: what its name says.

    Attributes
    ----------
    name : str
        As given.
    normal, tangential, formulation, method : str
        As of `plan`; "" for a tangential method that is not named.
    polish : bool
        Whether active sets polish the answers of programs.

    Examples
    --------
    >>> Method.named("osqp|clarabel/gap+polish").tangential, Method.named("convex").method
    ('clarabel', 'convex')
    """

    name: str
    normal: str
    tangential: str
    formulation: str
    polish: bool
    method: str = "auto"

    @classmethod
    def named(cls, name: str) -> Method:
        """From a `name`, ``[normal|]tangential[/formulation][+polish]``.

        Raises
        ------
        SceneError
            If a part of it is unknown.
        """
        rest, plus, polish = str(name).strip().partition("+")
        if plus and polish != "polish":
            raise SceneError(
                "methods",
                name,
                "without this suffix",
                message=f'methods: unknown suffix "+{polish}"; only "+polish" is known',
            )
        rest, _, formulation = rest.partition("/")
        if formulation:
            checks.choice("methods", formulation, FORMULATIONS)
        if rest in ROADS and rest != "auto":
            if plus:
                raise SceneError(
                    "methods",
                    name,
                    "without +polish",
                    message=f'"{name}": only a program solver called by name is polished; write "{rest}"',
                )
            return cls(str(name).strip(), "auto", "auto", formulation or "auto", False, rest)
        normal, bar, tangential = rest.partition("|")
        every = ["auto", *tangential_methods(), *THEORIES]
        if bar:
            _known("methods", normal, ["auto", *normal_methods()])
            _known("methods", tangential, every)
        else:
            only_normal = [known for known in normal_methods() if known not in every]
            _known("methods", rest, list(dict.fromkeys([*every, *ROADS, *only_normal])))
            takes_cones = rest in every or (rest.startswith("cvxpy:") and rest not in only_normal)
            normal, tangential = _partner(rest), rest if takes_cones else ""
        return cls(str(name).strip(), normal, tangential, formulation or "auto", bool(plus))

    def plan(self, scene: Scene) -> Plan:
        """The plan for a scene, or the error that says why not.

        Parameters
        ----------
        scene : Scene

        Raises
        ------
        SceneError
            If the method is not for such scenes.
        SolverUnavailable
            If it is not installed.
        """
        moves = scene.motion is not None
        if moves and not self.tangential:
            raise SceneError(
                "methods",
                self.name,
                "a pair of methods",
                message=f'"{self.name}" is for normal problems; add a tangential method, as "{self.name}|clarabel"',
            )
        normal = self.normal if make_plan(scene).normal != "hertz" or "|" in self.name or not moves else "auto"
        plan = make_plan(scene, normal, self.tangential or "auto", "auto", self.formulation, self.method)
        if self.polish and not (plan.programs or states_programs(plan.normal)):
            raise SceneError(
                "methods",
                self.name,
                "without +polish",
                message=f'"{self.name}": only program solvers are polished; leave out "+polish"',
            )
        return plan


def _known(field: str, name: str, names: list[str]) -> None:
    """Refuse unknown names. Methods that are not installed are listed later."""
    with suppress(SolverUnavailable):
        available(field, name, names)


def _partner(name: str) -> str:
    """The normal method that goes with a tangential one of that name."""
    if name.startswith("tang"):
        return "norm"
    return "auto" if name in THEORIES else name
