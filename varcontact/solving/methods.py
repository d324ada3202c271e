"""The methods that a user names: `Methods`, its values, and how options of `solve` name them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal, get_args

from varcontact.checks import Checked, choice, kind
from varcontact.errors import SceneError
from varcontact.solvers import registry
from varcontact.solving.own_solvers import solver_name
from varcontact.theories.on_grid import THEORIES

CouplingName = Literal[
    "auto", "johnson", "panagiotopoulos", "joint", "newton", "splitting", "active-set"
]
"""Loops around both problems."""
FormulationName = Literal["auto", "complementary", "potential", "gap", "marching"]
"""Formulations of the programs."""
MethodName = Literal["auto", "convex", "conic", "active-set", "kalker"]
"""Overall methods."""
COUPLINGS: tuple[str, ...] = get_args(CouplingName)
FORMULATIONS: tuple[str, ...] = get_args(FormulationName)
METHODS: tuple[str, ...] = get_args(MethodName)


def _word(field: str, name: Any) -> str:
    if not isinstance(name, str):
        raise SceneError(field, name, "the name of a method")
    return name


def _normal_name(field: str, method: Any) -> str:
    """Name of a solver of pressures; its existence is checked with the scene."""
    if isinstance(method, str) and method == "auto":
        return method
    return _word(field, solver_name("normal", method))


def _tangential_name(field: str, method: Any) -> str:
    """Name of a solver of tractions; its existence is checked with the scene."""
    if isinstance(method, str) and method == "auto":
        return method
    return _word(field, solver_name("tangential", method))


def _coupling_name(field: str, name: Any) -> str:
    return choice(field, _word(field, name), COUPLINGS)


def _formulation_name(field: str, name: Any) -> str:
    return choice(field, _word(field, name), FORMULATIONS)


def _method_name(field: str, name: Any) -> str:
    """Name of a method; the error for a name of something else says of what."""
    if isinstance(name, str) and name not in METHODS:
        arguments = {
            "tangential": [*registry.tangential_methods(), *THEORIES],
            "normal": registry.normal_methods(),
            "coupling": COUPLINGS,
            "formulation": FORMULATIONS,
        }
        meant = [f'{argument}="{name}"' for argument, names in arguments.items() if name in names]
        if meant:
            allowed = f"one of {', '.join(METHODS)}; did you mean {' or '.join(meant)}?"
            raise SceneError(field, name, allowed)
    return choice(field, name, METHODS)


@dataclass(frozen=True, kw_only=True)
class Methods(
    Checked,
    normal=_normal_name,
    tangential=_tangential_name,
    method=_method_name,
    coupling=_coupling_name,
    formulation=_formulation_name,
):
    """Names of the methods that a scene is solved by, as `solve` takes them one by one; "auto"
    leaves the choice.

    Parameters
    ----------
    normal, tangential : str
        Solvers of the two problems, or a theory, see docs/methods.md; or a function, as
        `register_solver` takes it, which becomes its name.
    coupling : {"auto", "johnson", "panagiotopoulos", "joint", "newton", "splitting", "active-set"}
        Coupling of the two problems where the bodies differ.
    formulation : {"auto", "complementary", "potential", "gap", "marching"}
        The programs.
    method : {"auto", "convex", "conic", "active-set", "kalker"}
        The overall method.

    Raises
    ------
    SceneError
        For an entry that does not exist, or is no name of one. Whether a solver is there, and
        suits the scene, is judged with the scene.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=82e9, nu=0.28), surface=vc.Paraboloids(Rx=0.46, Ry=0.30),
    ...     normal_force=106.7e3, friction=0.33, motion=vc.Steady(vx=1e-3),
    ...     grid=vc.Grid(nx=12, ny=12))
    >>> programs = vc.Methods(method="conic")
    >>> print(programs)
    method=conic
    >>> vc.plan(scene, methods=programs).tangential
    'clarabel'
    >>> vc.solve(scene, methods=programs).plan.method
    'conic'
    """

    normal: str = "auto"
    tangential: str = "auto"
    coupling: str = "auto"
    formulation: str = "auto"
    method: str = "auto"

    def __str__(self) -> str:
        return ", ".join(f"{name}={value}" for name, value in self.named().items()) or "auto"

    def named(self) -> dict[str, str]:
        """The names that are given, by argument."""
        return {name: value for name, value in asdict(self).items() if value != "auto"}

    @classmethod
    def given(cls, methods: Methods | None, **names: Any) -> Methods:
        """The methods, together or by their names one by one."""
        if methods is None and all(type(name) is str and name == "auto" for name in names.values()):
            return AUTO
        if methods is None:
            return cls(**names)
        kind("methods", methods, Methods)
        for name, value in names.items():
            if value != "auto":
                raise SceneError(name, value, f"left out beside methods: Methods({name}=...)")
        return methods


AUTO = Methods()
"""All methods left to choose."""


NAMES = tuple(each.name for each in fields(Methods))
"""The arguments that name methods."""


def taken_apart(options: Mapping[str, Any]) -> tuple[Methods, dict[str, Any]]:
    """The methods among options of `solve`, and the others."""
    names = {name: value for name, value in options.items() if name in NAMES}
    others = {name: value for name, value in options.items() if name not in NAMES}
    return Methods.given(others.pop("methods", None), **names), others


def by_name(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options of `solve` with the methods by their names."""
    if options.get("methods") is None:
        return dict(options)
    methods, others = taken_apart(options)
    return others | methods.named()
