"""The options of the commands, each declared once, and the values they take."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from varcontact.errors import SceneError

METHODS = (
    "Methods: convex programs (clarabel, osqp, scs, qpsolvers:NAME, cvxpy:NAME), "
    "active sets (norm, tang), newton, theories (fastsim, ...); all names are in docs/methods.md."
)


def option(words: str, *names: str, default: Any = None) -> Any:
    """An option with its help; a default that is computed elsewhere is named in the help."""
    if default is not None:
        words += f"  [default: {default}]"
    return typer.Option(*names, help=words, show_default=False)


def argument(words: str) -> Any:
    """An argument with its help."""
    return typer.Argument(help=words, show_default=False)


SceneFile = Annotated[Path, argument("Scene, a TOML file (docs/scenes.md).")]
Methods = Annotated[
    str | None, option("Methods, separated by commas: [normal|]tangential[/formulation][+polish].")
]
Solved = Annotated[
    float, typer.Option(help="Natural-map residual at which an answer counts as solved.")
]
VALUES = "FROM:TO:N (N equally spaced values), values separated by commas, or one value"
Table = Annotated[Path | None, option("Table (.csv) that is written as results come, and resumed.")]
Picture = Annotated[Path | None, option("Picture (.png, .pdf, .svg).")]
Force = Annotated[
    bool,
    option(
        "Overwrite files not created by varcontact. Tables and histories are only appended to.",
        "--force",
    ),
]
Workers = Annotated[int, typer.Option(help="Number of processes.")]
Dask = Annotated[
    str | None, option("Dask scheduler whose workers solve the scenes, as tcp://host:8786.")
]
AsJson = Annotated[bool, option("Print JSON instead of the report.", "--json")]
SHARED: dict[str, Any] = {
    "vx": Annotated[str | None, option(f"Longitudinal creepage (ux of a shift): {VALUES}.")],
    "vy": Annotated[str | None, option("Lateral creepage (uy of a shift).")],
    "spin": Annotated[str | None, option("Spin (rotation of a shift).")],
    "method": Annotated[
        str | None, option("auto, convex, conic, active-set or kalker.", default="auto")
    ],
    "normal": Annotated[str | None, option("Normal problem.", default="auto")],
    "tangential": Annotated[str | None, option("Tangential problem, or a theory.", default="auto")],
    "coupling": Annotated[str | None, option("Coupling, for unlike bodies.", default="auto")],
    "formulation": Annotated[str | None, option("Formulation of the programs.", default="auto")],
    "polish": Annotated[
        bool | None, option("Refine programs' answers.", "--polish/--no-polish", default="polish")
    ],
    "tol": Annotated[float | None, option("Required natural-map residual.", default="1e-8")],
    "start": Annotated[str | None, option("Under a law of friction: search from stick or slip.")],
    "certify": Annotated[
        str | None, option("Certificate: full (with bounds on forces), gap, none, auto.")
    ],
    # refused, with its replacement
    "refine": Annotated[str | None, typer.Option(hidden=True)],
    "accuracy": Annotated[
        float | None, option("Largest error by the friction limit; sets the grid.")
    ],
    "compare": Annotated[
        Path | None,
        option("Output of CONTACT (.out, .ref_out): compare all cases of its .inp with it."),
    ],
    "table": Annotated[
        bool | None,
        typer.Option("--table", help="Print forces of all cases of an .inp as CONTACT does."),
    ],
    "save": Annotated[
        Path | None, option("Folder for the solutions of all cases of an .inp (netCDF).")
    ],
    "time_budget": Annotated[
        float | None, option("Instead of --accuracy: a time limit in seconds.")
    ],
}
"""Options that several commands take, by name."""
CREEPAGES = ("vx", "vy", "spin")
CONTACT = ("compare", "table", "save")
METHOD = ("method", "normal", "tangential", "coupling", "formulation")
TARGET = ("accuracy", "time_budget")
SETTINGS = (*METHOD, "tol", "certify", *TARGET)


def takes(*names: str) -> Callable[[Any], Any]:
    """Declare the `options` of a command, of `SHARED`, after its first argument."""
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    added = [inspect.Parameter(name, kind, default=None, annotation=SHARED[name]) for name in names]

    def declared(command: Any) -> Any:
        signature = inspect.signature(command, eval_str=True)
        first, *own, _ = signature.parameters.values()
        command.__signature__ = signature.replace(parameters=[first, *added, *own])
        return command

    return declared


def given(**options: Any) -> dict[str, Any]:
    """Options that were given, without those left at None."""
    return {name: value for name, value in options.items() if value is not None}


def for_contact(options: dict[str, Any]) -> dict[str, Any]:
    """Take the options for all cases of an input file of CONTACT out of the given ones."""
    return {name: options.pop(name) for name in CONTACT}


def ranges_of(options: dict[str, Any]) -> dict[str, Any]:
    """Take the creepages out of options that are given: the values of each."""
    return {
        name: values_of(f"--{name}", options.pop(name)) for name in CREEPAGES if name in options
    }


def names_of(text: str) -> list[str]:
    """Names that are separated by commas."""
    return [name.strip() for name in text.split(",") if name.strip()]


def counts_of(text: str) -> list[Any]:
    """Whole numbers separated by commas; other words are left for a later check."""
    return [int(n) if re.fullmatch("[0-9]{1,19}", n) else n for n in names_of(text)]


def values_of(option: str, text: str) -> np.ndarray | float:
    """The values of an option: FROM:TO:N, values separated by commas, or one value."""
    try:
        if ":" in text:
            first, last, number = (float(part) for part in text.split(":"))
            if number == int(number) >= 2:
                return np.linspace(first, last, int(number))
        elif "," in text:
            return np.array([float(part) for part in text.split(",")])
        else:
            return float(text)
    except (ValueError, OverflowError):
        pass
    raise SceneError(
        option, text, "FROM:TO:N with two values or more, values separated by commas, or one value"
    )
