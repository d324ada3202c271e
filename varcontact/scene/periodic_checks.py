"""Checks of scenes on periodic grids."""

from __future__ import annotations

from typing import TYPE_CHECKING

from varcontact.errors import SceneError
from varcontact.scene.bodies import BodyPair
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.surfaces import SampledDistance

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene


def check_periodic(scene: Scene) -> None:
    """Refuse what a periodic grid does not support: samples that do not repeat, curved surfaces,
    bodies that relax or are bedded, histories, third bodies, heat, and loads beside the contact.
    """
    if not scene.periodic:
        return
    if not isinstance(scene.surface, SampledDistance) or scene.surface.x is not None:
        allowed = "a SampledDistance on the periodic grid, without coordinates: it repeats"
        raise SceneError("surface", scene.surface, allowed)
    if scene.conformal:
        raise SceneError("surface.inclination", "given", "left out: periodic bodies are flat")
    if scene.reference_depth is not None:
        allowed = "left out: displacements count from the mean over a period"
        raise SceneError("surface.reference_depth", scene.reference_depth, allowed)
    bodies = scene.bodies
    if bodies.relaxes or (isinstance(bodies, BodyPair) and bodies.bedded):
        allowed = "elastic half-spaces or layers, or an Elasticity by its symbol"
        raise SceneError("bodies", bodies, allowed)
    _check_motion(scene)
    for name in ("third_body", "thermal", "loads"):
        if getattr(scene, name) is not None:
            raise SceneError(name, "given", "left out on a periodic grid")


def _check_motion(scene: Scene) -> None:
    """Check that a motion repeats, and that none is prescribed along a direction in which only
    differences are determined.
    """
    motion = scene.motion
    if not isinstance(motion, Steady | Shift | None):
        allowed = "None, Shift or Steady: histories of periodic bodies are not known here"
        raise SceneError("motion", type(motion).__name__, allowed)
    turns = {Steady: "spin", Shift: "rotation"}.get(type(motion))
    if turns is not None and getattr(motion, turns) != 0:
        raise SceneError(f"motion.{turns}", getattr(motion, turns), "0: the motion repeats")
    if scene.periodic != "x" or scene.line:
        return
    allowed = 'a force: with grid.periodic = "x" displacements are known but for a constant'
    if scene.approach is not None:
        raise SceneError("approach", scene.approach, allowed)
    if isinstance(motion, Shift) and (motion.Fx is None or motion.Fy is None):
        raise SceneError("motion", motion, f"{allowed}, as Fx and Fy")
