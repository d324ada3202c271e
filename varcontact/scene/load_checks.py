"""Checks of loads and prescribed displacements beside the contact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from varcontact.errors import SceneError
from varcontact.scene.bodies import Bodies, BodyPair
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Grid
from varcontact.scene.surface_displacement import SurfaceDisplacement
from varcontact.scene.surface_load import SurfaceLoad
from varcontact.scene.surfaces import Ellipse
from varcontact.scene.transient import Transient

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene


def check_loads(scene: Scene) -> None:
    """Check that loads beside the contact act on a deformable body, of elastic bodies that meet on
    a plane.
    """
    prescribed: dict[str, Sequence[SurfaceLoad | SurfaceDisplacement] | None] = {
        "loads": scene.loads,
        "displacements": scene.displacements,
    }
    for name, beside in prescribed.items():
        if beside is None:
            continue
        if scene.conformal or not _feel_loads(scene.bodies):
            allowed = "left out: they are for elastic bodies that meet on a plane, and no beddings"
            raise SceneError(name, beside, allowed)
        for k, each in enumerate(beside):
            _check_place(scene, f"{name}[{k}]", each)
        if isinstance(scene.surface, Ellipse) and scene.raised:
            allowed = f"Paraboloids: beside {name} the contact is no ellipse"
            raise SceneError("surface", scene.surface, allowed)
    if scene.displacements is not None:
        _check_displacements(scene, scene.displacements)


def _check_place(scene: Scene, field: str, beside: SurfaceLoad | SurfaceDisplacement) -> None:
    """Check that a load is a rectangle, in line contact a strip, on a deformable body."""
    if (beside.y is None) != scene.line:
        allowed = "given: two numbers, from and to"
        if scene.line:
            allowed = "left out in line contact, where nothing depends on y"
        raise SceneError(f"{field}.y", beside.y, allowed)
    assert not isinstance(scene.bodies, GivenBodies)
    if beside.body in _rigid_bodies(scene.bodies):
        raise SceneError(f"{field}.body", beside.body, "a body that is not rigid")


def _check_displacements(scene: Scene, held: tuple[SurfaceDisplacement, ...]) -> None:
    """Check that prescribed displacements have a reference depth, disjoint places, and apply to the
    whole history.
    """
    if scene.line and (scene.reference_depth is None or scene.bodies.slides):
        allowed = "given, below bodies that do not slide: prescribed displacements count from there"
        raise SceneError("surface.reference_depth", scene.reference_depth, allowed)
    if isinstance(scene.grid, Grid) and scene.grid.linear:
        allowed = '"constant" beside prescribed displacements'
        raise SceneError("grid.tractions", scene.grid.tractions, allowed)
    _check_apart(held)
    if not isinstance(scene.motion, Transient) or scene.motion.start is None:
        return
    others = scene.motion.start.scene.displacements
    if not _same_places(held, others):
        allowed = "of a scene whose displacements are prescribed on the same rectangles"
        raise SceneError("motion.start", others, allowed)


def _check_apart(held: tuple[SurfaceDisplacement, ...]) -> None:
    """Refuse two displacements prescribed at the same place of a body."""
    for (i, one), (k, other) in combinations(enumerate(held), 2):
        same = set(one.components) & set(other.components)
        apart = {one.body, other.body} == {"upper", "lower"}
        everywhere = np.ones(other.grid.shape, dtype=bool)
        if same and not apart and one.overlaps(other.grid, everywhere):
            allowed = f"apart from displacements[{i}]: a displacement is prescribed once"
            raise SceneError(f"displacements[{k}]", other, allowed)


def _same_places(
    held: tuple[SurfaceDisplacement, ...], others: tuple[SurfaceDisplacement, ...] | None
) -> bool:
    """True where the same parts of surfaces are held along the same components."""
    places = [
        [(each.grid, each.components, each.body) for each in some] for some in (held, others or ())
    ]
    return places[0] == places[1]


def _feel_loads(bodies: Bodies | BodyPair | GivenBodies) -> bool:
    """True for two elastic bodies whose displacements far from the contact are known."""
    if isinstance(bodies, GivenBodies):
        return False
    bedded = isinstance(bodies, BodyPair) and bodies.bedded
    return not (bodies.relaxes or bedded)


def _rigid_bodies(bodies: Bodies | BodyPair) -> list[str]:
    """Names of the rigid bodies."""
    surfaces = bodies
    if isinstance(bodies, BodyPair):
        surfaces = bodies.surfaces
    assert isinstance(surfaces, Bodies)
    moduli = dict(zip(("upper", "lower"), surfaces.pairs[0], strict=True))
    return [name for name, G in moduli.items() if math.isinf(G)]
