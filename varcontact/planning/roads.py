"""The roads to a solution as one choice: what `method` stands for, and which solvers go that way."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from varcontact.checks import choice
from varcontact.discrete.contact_grid import given_grid
from varcontact.discrete.subgrid import cells_of
from varcontact.errors import SceneError
from varcontact.planning.kinds import one_direction, own_image
from varcontact.scene.motion import Steady, Transient
from varcontact.scene.scene import Scene
from varcontact.solvers.registry import MATRIX_FREE, NORMAL, TANGENTIAL, states_programs

TOLERANCE = 1e-8
"""Natural-map residual to reach if none is given. Every method reaches it, see docs/methods.md."""


@dataclass(frozen=True)
class Road:
    """A method.

    Attributes
    ----------
    normal, tangential : str
        The solvers that are taken if none is named.
    why : str
        What makes it this road, in one line.
    normals, tangentials : tuple of str, optional
        The active sets that go this way; if none are given, solvers of programs do.
    fallback : str
        The solver of programs that takes over where active sets miss the tolerance; "none" without one.
    """

    normal: str
    tangential: str
    why: str
    normals: tuple[str, ...] = ()
    tangentials: tuple[str, ...] = ()
    fallback: str = "none"


ROADS: dict[str, Road] = {
    "auto": Road(
        "norm", "tang-safeguarded", "the fastest measured method, or the solvers that are named", fallback="clarabel"
    ),
    "convex": Road("clarabel", "clarabel", "QP and SOCP by conic solvers, never polished by active sets"),
    "active-set": Road(
        "norm",
        "tang-safeguarded",
        "NORM and the safeguarded TANG, without programs",
        tuple(name for name in NORMAL if name not in MATRIX_FREE),
        tuple(name for name in TANGENTIAL if name not in MATRIX_FREE),
    ),
    "kalker": Road("norm", "tang-exact", "NORM and TANG as printed, without programs", ("norm",), ("tang-exact",)),
}
"""By name. With the first any solver may be named."""

MANY, MANY_PRESSED = 180, 400
"""Elements in contact beyond which "auto" takes Newton's method without a matrix, for the tractions and for the
pressure (docs/measurements.md)."""

MANY_IN_STEPS = 250
"""The same for the tractions of a history, whose steps begin from the step before."""

MANY_UNLIKE = 100
"""The same of unlike bodies, whose pressure and tractions it finds together and not in turn."""

MANY_ELEMENTS = Road(
    "newton",
    "newton",
    f"more than {MANY_PRESSED} elements in contact, of unlike bodies {MANY_UNLIKE}, where Newton's method is the "
    "fastest by measurement",
    fallback="clarabel",
)
"""What "auto" stands for with so many elements."""

MANY_RUBBED = Road(
    "norm",
    "newton",
    f"more than {MANY} elements in contact, where Newton's method is the fastest for tractions by measurement",
    fallback="clarabel",
)
"""What "auto" stands for with so many elements, where the pressure has too few of them."""


SHORT, TOO_MANY = 0.05, 2000
"""A step of steady rolling by the length of an element, below which Newton's method takes longer than active sets, and
the elements beyond which these take hours."""


def for_many_elements(scene: Scene, together: bool) -> Road | None:
    """The road by products by FFT, where they beat dense matrices as far as is known beforehand; else None.

    It holds for one problem, and for many in a row: of unlike bodies, under a law of friction, in a history.

    Parameters
    ----------
    scene : Scene
    together : bool
        Whether pressure and tractions of unlike bodies may be found together.
    """
    count, dx = _elements(scene)
    motion = scene.motion
    if own_image(scene) or one_direction(scene):
        count /= 2  # active sets have half the unknowns
    if isinstance(motion, Steady) and motion.dq is not None and motion.dq < SHORT * dx:
        return MANY_ELEMENTS if count > TOO_MANY else None
    if scene.bodies.K != 0 and not scene.frictionless:
        return MANY_ELEMENTS if count > (MANY_UNLIKE if together else MANY) else None
    if many_pressed(scene):
        return MANY_ELEMENTS
    most = MANY_IN_STEPS if isinstance(motion, Transient) else MANY
    return MANY_RUBBED if count > most and not scene.frictionless else None


def many_pressed(scene: Scene) -> bool:
    """Whether so many elements are in contact that products by FFT find the pressure first.

    Parameters
    ----------
    scene : Scene
    """
    return _elements(scene)[0] > MANY_PRESSED


def many_on_parts(scene: Scene) -> bool:
    """Whether a pressure that is solved for on parts of the elements has so many unknowns.

    Parameters
    ----------
    scene : Scene
        With a grid whose elements at the edge count in part.
    """
    return _elements(scene)[0] * math.prod(cells_of(scene.edge, scene.line)) > MANY_PRESSED


def _elements(scene: Scene) -> tuple[float, float]:
    """The number of elements in contact, about, and their length along x; zero where that is not known."""
    grid = given_grid(scene)
    hertz = None if isinstance(scene.motion, Transient) else scene.hertz  # each step of a history has its own
    if not grid.explicit:
        count = grid.nx * (1.0 if grid.line else np.pi / 4 * grid.rows)
        return count, 0.0 if hertz is None else 2 * hertz.a / grid.nx
    dx, dy = grid.sides
    if hertz is None:
        return grid.size, dx
    return (2 * hertz.a if grid.line else np.pi * hertz.a * hertz.b / dy) / dx, dx


def road(method: str) -> Road:
    """The road of that name.

    Parameters
    ----------
    method : str
        A key of `ROADS`.

    Raises
    ------
    SceneError
        For an unknown name; the nearest is suggested.

    Examples
    --------
    >>> road("kalker").tangential
    'tang-exact'
    """
    return ROADS[choice("method", method, ROADS)]


def check_on_road(method: str, field: str, name: str) -> None:
    """Refuse a solver that does not belong to a method.

    Hertz's closed form is no solver, and goes everywhere.

    Parameters
    ----------
    method : str
        A key of `ROADS`.
    field : str
        The problem: "normal" or "tangential".
    name : str
        Of the solver.

    Raises
    ------
    SceneError
        If it does not belong there.
    """
    if method == "auto" or name in ("auto", "hertz"):
        return
    chosen = ROADS[method]
    allowed = chosen.normals if field == "normal" else chosen.tangentials
    if name in allowed or (not allowed and states_programs(name)):
        return
    words = " or ".join(allowed) or "a solver of programs, such as clarabel or scs"
    raise SceneError(
        field,
        name,
        words,
        message=f'{field} = "{name}" does not belong to method = "{method}", which takes {words}; '
        'with method = "auto" any solver may be named',
    )
