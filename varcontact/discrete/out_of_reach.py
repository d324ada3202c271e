"""Why a scene cannot be discretised: its contact is not on the grid, or its sizes leave floating point."""

from __future__ import annotations

import numpy as np

from varcontact.errors import SceneError, TooCoarse
from varcontact.scene.consistency import bodies_apart
from varcontact.scene.grid import Grid
from varcontact.scene.motion import Motion
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance, Surface

RANGE = 280
"""Powers of ten that forces and their work may have: floating point ends at 308."""

LARGEST_SHIFT = 1e100
"""Greatest rigid shift by the scale of displacements: squares of products with it stay in the range."""


def out_of_reach(surface: Surface, approach: float | None, grid: Grid) -> SceneError:
    """Why no element of a grid is in contact: the bodies are apart, the contact is elsewhere, or falls between.

    Parameters
    ----------
    surface : Surface
    approach : float or None
        Where it is prescribed [length].
    grid : Grid
        Explicit, physical.

    Returns
    -------
    SceneError
        To be raised.
    """
    left, right, bottom, top = grid.box
    x = y = 0.0
    if isinstance(surface, SampledDistance):
        iy, ix = np.unravel_index(np.argmin(surface.samples), surface.samples.shape)
        least = float(surface.samples[iy, ix])
        if approach is not None and approach <= least:
            return bodies_apart(approach, least)
        if surface.placed:
            x, y = (float(points[i]) for points, i in zip(surface.coordinates, (ix, iy), strict=True))
        else:
            x, y = left, bottom
    if not (left <= x <= right and bottom <= y <= top):
        box, where = (grid.box[:2], f"x = {x:.6g}") if grid.line else (grid.box, f"({x:.6g}, {y:.6g})")
        return SceneError(
            "grid",
            box,
            "a potential contact that contains the contact",
            message=f"grid (left, right{'' if grid.line else ', bottom, top'}) = "
            f"{tuple(float(f'{side:.6g}') for side in box)} does not contain the contact, which is at {where}",
        )
    return TooCoarse(
        "grid",
        grid,
        "fine enough to hold one contact element",
        message="grid is too coarse to hold one contact element: no element's centre is in contact",
    )


def check_range(scene: Scene, length: float, pressure: float) -> None:
    """Refuse sizes at which forces, or their work, leave the range of floating point.

    Parameters
    ----------
    scene : Scene
    length : float
        Scale of lengths [length].
    pressure : float
        Scale of pressures [force/area].

    Raises
    ------
    SceneError
        If they do.
    """
    with np.errstate(divide="ignore"):
        L, p, G = np.log10([length, pressure, scene.bodies.combined_G])
    force = p + (1 if scene.line else 2) * L
    largest = np.abs([L, p, p + L - G, force, force + p + L - G]).max()
    if not largest < RANGE:
        modulus = scene.bodies.combined_G
        sizes = f"lengths of {length:.3g}, pressures of {pressure:.3g}, combined modulus {modulus:.3g}"
        raise SceneError(
            "scene",
            sizes,
            f"in units in which forces and their work are between 1e-{RANGE} and 1e{RANGE}",
            message=f"scene: with {sizes}, forces or their work leave the range of 1e-{RANGE} to "
            f"1e{RANGE}; choose other units",
        )


def check_shift(motion: Motion, shift: np.ndarray) -> None:
    """Refuse creepages and shifts so large beside elastic displacements that their products leave floating point.

    Parameters
    ----------
    motion : Steady, Shift or TimeStep
    shift : ndarray
        Rigid shift, by the scale of displacements.

    Raises
    ------
    SceneError
        If they are.
    """
    if np.abs(shift).max() <= LARGEST_SHIFT:
        return
    names = ("vx", "vy", "spin", "ux", "uy", "rotation")
    given = {name: getattr(motion, name) for name in names if getattr(motion, name, 0.0)}
    largest = max(given, key=lambda name: abs(given[name]), default="dq")
    raise SceneError(
        f"motion.{largest}",
        given.get(largest, getattr(motion, "dq", None)),
        f"smaller: the shift in a step may be {LARGEST_SHIFT:g} times the elastic displacements at most",
    )
