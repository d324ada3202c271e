"""Elements and undeformed distance of CONTACT's basic contacts, given or kept."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.io.contact_cases import CaseInput
from varcontact.io.contact_elements import (
    distance_of,
    elements_of,
    hertzian,
    load_of,
    prescribed_pressure,
    sampled,
)
from varcontact.io.contact_material import kept, own_elasticity
from varcontact.io.contact_words import Group, located
from varcontact.scene.grid import Grid

CONFORMAL = 4
"""Value of the digit C for conformal contact."""
NOT_HERTZIAN = {CONFORMAL: "a conformal contact", 9: "influence numbers of a file"}
"""Bodies of the digit C that have no Hertzian contact."""
RECIPROCAL = 4
"""Value of VARIANT."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """Bodies, their undeformed distance and the elements; the approach of a prescribed pressure."""

    bodies: Any
    surface: Any
    grid: Grid
    approach: float | None = None

    def load_of(self, case: CaseInput) -> dict[str, Any]:
        """Load of the scene: under a prescribed pressure the corresponding approach."""
        if self.approach is not None:
            return {"approach": self.approach}
        return load_of(case)


def geometry_of(case: CaseInput, bodies: Any, before: Geometry | None) -> Geometry:
    """Elements and undeformed distance; `before` is the geometry of the previous case."""
    kind, _ = case.needs("elements", "DISCNS", "the elements", "D = 2")
    (ipotcn,) = kind.integers()
    bound = case.controls["BOUND"]
    if bound >= 2 and ipotcn > 0:
        case.controls.complain("BOUND", "needs a Hertzian contact, IPOTCN < 0")
    if ipotcn > 0:
        return _by_distance(case, bodies)
    elasticity = kept(case, "INFLCF", 1)
    if elasticity in NOT_HERTZIAN:
        kind.refuse("IPOTCN", ipotcn, f"of {NOT_HERTZIAN[elasticity]} is not supported")
    if _prescribes(case, ipotcn):
        return Geometry(bodies, *prescribed_pressure(case, bodies))
    if case.controls["DISCNS"] == 0 and before is not None:
        _check_same_ellipse(case, bodies, before, ipotcn)
        return Geometry(bodies, before.surface, before.grid)
    return Geometry(bodies, *hertzian(case, bodies))


def _by_distance(case: CaseInput, bodies: Any) -> Geometry:
    """IPOTCN > 0: an undeformed distance on elements."""
    grid = elements_of(case)
    bodies = own_elasticity(case, grid) or bodies
    case.needs("distance", "RZNORM", "an undeformed distance", "Z = 2")
    h = distance_of(case, grid)
    with located(case.entries["distance"][0]):
        return Geometry(bodies, sampled(h, grid, **_inclination(case, grid)), grid)


def _inclination(case: CaseInput, grid: Grid) -> dict[str, Any]:
    """Angles of the rows in conformal contact."""
    if "conformal" not in case.entries or kept(case, "INFLCF", 1) != CONFORMAL:
        return {}
    head: Group
    pairs: Group
    head, pairs = case.entries["conformal"]
    if head.integers()[1] != RECIPROCAL:
        why = "is not reciprocal, and not supported; supported: 4"
        head.refuse("VARIANT", head.integers()[1], why)
    places = [pairs.angle(k) for k in range(0, len(pairs.values), 2)]
    angles = [pairs.angle(k) for k in range(1, len(pairs.values), 2)]
    if np.any(np.diff(places) <= 0):
        pairs.refuse("Y", places[0], "does not ascend in the surface's inclinations")
    return {"inclination": np.interp(grid.y, places, angles)}


def _prescribes(case: CaseInput, ipotcn: int) -> bool:
    """True where the digit B prescribes a pressure other than Hertz's."""
    bound = case.controls["BOUND"]
    if bound == 1 and ipotcn < 0:
        case.controls.complain("BOUND", "needs a contact by its distance, IPOTCN > 0")
    theory = case.controls["MATER"] in (2, 3, 5)
    if ipotcn >= -3:
        return bound == 3 and not theory
    if ipotcn == -6:
        theory = case.controls["MATER"] == 5
    allowed: tuple[int, ...] = (2, 3)
    if ipotcn == -6:
        allowed = (4,)
    if bound not in allowed or case.controls["NORM"] == 0 or theory:
        why = f"needs B = {' or '.join(map(str, allowed))}, N = 1, and no simplified theory"
        case.entries["elements"][0].refuse("IPOTCN", ipotcn, why)
    return True


def _check_same_ellipse(case: CaseInput, bodies: Any, before: Geometry, ipotcn: int) -> None:
    """Refuse semi-axes kept from a case with another load or material."""
    assert case.before is not None
    same = (before.bodies, load_of(case.before)) == (bodies, load_of(case))
    if ipotcn == -3 and not same:
        why = "keeps the semi-axes for another load or material, which is not clear: use D = 2"
        case.controls.complain("DISCNS", why)
