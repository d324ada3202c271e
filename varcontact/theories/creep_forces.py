"""All fast theories by name, for any number of contacts and creepages in one call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.bodies import Bodies
from varcontact.theories.fastsim import fastsim_forces
from varcontact.theories.linear import (
    Contact,
    Forces,
    coefficients_of,
    float_or_array,
    linear_resultants,
    positive_or_array,
)
from varcontact.theories.polach import polach_forces
from varcontact.theories.strip_theory import fastrip_forces, strip_forces
from varcontact.theories.table import table_resultants
from varcontact.theories.vermeulen_johnson import vermeulen_johnson_forces

TheoryName = Literal[
    "linear",
    "vermeulen-johnson",
    "polach",
    "strip",
    "fastrip",
    "fastsim",
    "fastsim-elliptic",
    "fastsim-weighted",
    "fastsim-weighted-elliptic",
    "table",
]
"""Theories that have a formula for all creepages at once."""


@dataclass(frozen=True, eq=False)
class CreepForces:
    """Forces and moment on body 1, by a fast theory.

    Attributes
    ----------
    Fx, Fy : float or ndarray
        Tangential force [force].
    Mz : float or ndarray
        Moment about the contact's centre [force length]; nan by a theory that
        has none.
    """

    Fx: Any
    Fy: Any
    Mz: Any


def theory_options() -> list[str]:
    """Further arguments that some theory takes."""
    return list(dict.fromkeys(name for names in OPTIONS.values() for name in names))


@checks.named_options(lambda given: theory_options())
def creep_forces(
    theory: TheoryName,
    *,
    a: Any,
    b: Any,
    normal_force: Any,
    friction: Any,
    vx: Any = 0.0,
    vy: Any = 0.0,
    spin: Any = 0.0,
    bodies: Bodies | None = None,
    G: Any = None,
    nu: Any = None,
    slope: Any = 1.0,
    **options: Any,
) -> CreepForces:
    """Forces and moment by a fast theory, for any number of elliptic contacts
    in steady rolling in one call.

    Parameters
    ----------
    theory : str
        ``linear``, ``vermeulen-johnson``, ``polach``, ``strip``, ``fastrip``,
        ``fastsim``, ``fastsim-elliptic``, ``fastsim-weighted``,
        ``fastsim-weighted-elliptic`` or ``table``.
    a, b : float or array_like
        Semi-axes along the rolling direction and across it [length].
    normal_force, friction : float or array_like
        Fz [force] and the coefficient of friction [-]; ``linear`` ignores them,
        and their shapes.
    vx, vy, spin : float or array_like
        Creepages [-], and spin [1/length]. All arrays broadcast.
    bodies : Bodies
        Quasi-identical ones; or, in their place,
    G, nu : float or array_like
        the combined modulus of rigidity [force/area] and Poisson's ratio, in
        (-1, 0.5].
    slope : float or array_like
        By which the creepage coefficients are multiplied, in (0, 1]: below 1
        for contaminated rails. Not for ``strip``, which has no coefficients.
    **options
        ``m`` and ``n``, the intervals along a strip and the strips (10 each),
        of FASTSIM, FaStrip and strip theory; ``layer`` of FASTSIM, the elastic
        compliance h/G of a third body [length^3/force], added to the
        flexibilities; ``k_A`` and ``k_S`` of Polach's formula; of ``table``:
        ``book``, a `TableBook` in place of the package's, and
        ``outside="clamp"``, for an a/b outside the book the ellipse of the same
        area with the nearest a/b it has.

    Returns
    -------
    CreepForces
        Floats where all arguments are single numbers; else arrays of their
        common shape.

    Raises
    ------
    SceneError
        If there is no such theory or option, a number is not finite or out of
        its range (in an array the first of these is named by its index), shapes
        do not broadcast, the bodies are unlike, there is spin with
        ``vermeulen-johnson``, there is spin with FASTSIM or FaStrip where C23
        is not positive, or a/b or nu is not in the table book.

    Notes
    -----
    FASTSIM, FaStrip and strip theory have `calibrated` strips: slopes and full slip are exact, with
    any m and n. Without creepage all forces are 0.

    Examples
    --------
    >>> import varcontact as vc
    >>> steel = vc.Bodies(G=82e9, nu=0.28)
    >>> contact = dict(a=6e-3, b=4e-3, bodies=steel, normal_force=1e5, friction=0.3)
    >>> for theory in ("linear", "vermeulen-johnson", "polach", "fastsim", "fastrip"):
    ...     found = vc.creep_forces(theory, **contact, vx=[1e-4, 1e-3, 1e-2])
    ...     print(f"{theory:18}", (found.Fx / 3e4).round(4))
    linear             [-0.0309 -0.3092 -3.0924]
    vermeulen-johnson  [-0.0306 -0.2785 -1.    ]
    polach             [-0.0309 -0.2977 -0.9755]
    fastsim            [-0.0309 -0.2777 -0.9998]
    fastrip            [-0.0307 -0.2836 -1.    ]
    """
    formula = formula_of(theory, options)
    G, nu = elastic(bodies, G, nu)
    a = positive_or_array("a", a)
    b = positive_or_array("b", b)
    limit = 1.0
    if theory != "linear":
        friction = positive_or_array("friction", friction)
        limit = friction * positive_or_array("normal_force", normal_force)
    vx = _finite("vx", vx)
    vy = _finite("vy", vy)
    spin = _finite("spin", spin)
    shapes = {
        "a": a,
        "b": b,
        "G": G,
        "nu": nu,
        "f Fz": limit,
        "slope": slope,
        "vx": vx,
        "vy": vy,
        "spin": spin,
    }
    checks.broadcasting(shapes)
    slope = _slope(theory, slope)
    contact = Contact(a, b, G, nu, limit, vx, vy, spin, slope, coefficients_of(a / b, nu, slope))
    Fx, Fy, Mz = formula(contact, **options)
    # in the common shape of all arguments, single numbers as floats
    parts = (Fx, Fy, Mz, vx, vy, spin)
    shape: tuple[int, ...] = ()
    if not all(isinstance(part, float) for part in parts):
        shape = np.broadcast_shapes(*map(np.shape, parts))
    if shape == ():
        return CreepForces(float(Fx) + 0.0, float(Fy) + 0.0, float(Mz) + 0.0)  # no negative zeros
    return CreepForces(*(np.broadcast_to(part, shape).copy() for part in (Fx, Fy, Mz)))


def formula_of(theory: str, options: dict[str, Any]) -> Callable[..., Forces]:
    """Formula of a theory, after a check of its options."""
    formula = VECTORISED[checks.choice("theory", theory, VECTORISED)]
    names = OPTIONS.get(theory, ())
    for name, value in options.items():
        if name in names:
            continue
        allowed = "left out"
        if names:
            allowed = f"one of {', '.join(names)}{checks.nearest(name, names)}"
        raise SceneError(name, value, message=f"{name} is no option of {theory}: must be {allowed}")
    return formula


def elastic(bodies: Any, G: Any, nu: Any) -> tuple[Any, Any]:
    """Combined G and nu, checked: of bodies, or as given."""
    if bodies is None:
        if G is None or nu is None:
            raise SceneError("G, nu", (G, nu), message="give bodies, or both G and nu")
        if not (type(nu) is float and -1 < nu <= 0.5):  # single calls are frequent
            nu = float_or_array(checks.poisson(nu))
        return positive_or_array("G", G), nu
    checks.elastic(bodies)
    if G is not None or nu is not None:
        raise SceneError("bodies, G, nu", (G, nu), message="give bodies, or G and nu, not both")
    if bodies.K != 0:
        reason = (
            f"the fast theories hold for quasi-identical bodies (K = 0), and K is {bodies.K:.3g}"
        )
        raise SceneError(
            "bodies", bodies, message=f"bodies: {reason}; use solve with an exact method"
        )
    return bodies.combined_G, bodies.combined_nu


def _finite(field: str, value: Any) -> Any:
    if type(value) is float and abs(value) <= checks.LARGE:
        return value
    return float_or_array(checks.numbers(field, value))


def _slope(theory: str, slope: Any) -> Any:
    if isinstance(slope, int | float) and slope == 1:
        return 1.0
    part = positive_or_array("slope", slope)
    checks.require_all("slope", np.asarray(part), np.asarray(part) <= 1, "in (0, 1]")
    if theory == "strip":
        raise SceneError(
            "slope", slope, message="slope: strip theory has no creepage coefficients to reduce"
        )
    return part


VECTORISED: dict[str, Callable[..., Forces]] = {
    "linear": linear_resultants,
    "vermeulen-johnson": vermeulen_johnson_forces,
    "polach": polach_forces,
    "strip": strip_forces,
    "fastrip": fastrip_forces,
    "fastsim": fastsim_forces,
    "fastsim-elliptic": partial(fastsim_forces, bound="elliptic"),
    "fastsim-weighted": partial(fastsim_forces, flexibility="weighted"),
    "fastsim-weighted-elliptic": partial(fastsim_forces, bound="elliptic", flexibility="weighted"),
    "table": table_resultants,
}
"""The theories of `creep_forces` by name."""
OPTIONS: dict[str, tuple[str, ...]] = {
    "polach": ("k_A", "k_S"),
    "table": ("book", "outside"),
    "strip": ("m", "n"),
    "fastrip": ("m", "n"),
    "fastsim": ("m", "n", "layer"),
    "fastsim-elliptic": ("m", "n", "layer"),
    "fastsim-weighted": ("m", "n", "layer"),
    "fastsim-weighted-elliptic": ("m", "n", "layer"),
}
"""Further arguments that a theory takes."""
