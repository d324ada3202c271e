"""Cases of CONTACT's input files as scenes; those that continue each other become histories."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from varcontact.scene.motion import Shift
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient

STEP = ("vx", "vy", "spin", "ux", "uy", "rotation")


@dataclass(frozen=True, eq=False)
class ContactCase:
    """A case of an input file of CONTACT.

    Attributes
    ----------
    number, line : int
        Of the case in the file, from 1, and of its first line.
    element : tuple of int
        The result element that it belongs to, where one is given.
    scene : Scene or None
        None where it cannot be had here.
    reason : str
        Why not, with line and digit; empty where there is a scene.
    methods : dict
        Arguments of `solve` with which it is solved as CONTACT does.
    mirrored : bool
        Whether the scene is the case with x to -x: steady rolling towards
        negative x.
    before : ContactCase or None
        The case whose tractions it goes on from.
    force_parts : tuple of float or None
        Fx and Fy as parts of the normal force, where that is not known before
        the pressure is.
    simplified : dict or None
        How CONTACT's simplified theory is asked for, see
        `varcontact.theories.fastsim_contact.SimplifiedTheory`.
    stress_points : tuple of ndarray, shape (3, points)
        x, y and z of the blocks of points at which stresses are asked for.
    """

    number: int
    line: int
    element: tuple[int, ...] = ()
    scene: Scene | None = None
    reason: str = ""
    methods: dict[str, Any] = field(default_factory=dict)
    mirrored: bool = False
    before: ContactCase | None = None
    force_parts: tuple[float | None, float | None] | None = None
    simplified: dict[str, Any] | None = None
    stress_points: tuple[np.ndarray, ...] = ()


def scenes_of(cases: Sequence[ContactCase]) -> list[Scene]:
    """Scenes of cases; cases that continue each other on the same elements make one history."""
    scenes: list[Scene] = []
    for sequence in _sequences(cases):
        first = sequence[0]
        if any(case.force_parts is not None or case.scene is None for case in sequence):
            continue
        if len(sequence) == 1:
            if first.before is None:
                scenes.append(first.scene)  # type: ignore[arg-type]
            continue
        scenes.append(_history([case.scene for case in sequence]))  # type: ignore[misc]
    return scenes


def _sequences(cases: Sequence[ContactCase]) -> Iterator[list[ContactCase]]:
    sequence: list[ContactCase] = []
    for case in cases:
        follows = bool(sequence) and case.before is sequence[-1] and _joins(sequence[-1], case)
        if sequence and not follows:
            yield sequence
            sequence = []
        sequence.append(case)
    if sequence:
        yield sequence


def _joins(before: ContactCase, case: ContactCase) -> bool:
    """True for steps of one history: a shift or a step in time, then a step, on one grid."""
    if before.scene is None or case.scene is None:
        return False
    if not isinstance(before.scene.motion, Shift | Transient):
        return False
    return before.scene.grid == case.scene.grid


def _history(scenes: Sequence[Scene]) -> Scene:
    """The scenes of single steps as one history."""
    motion = _joined([_step_of(scene) for scene in scenes])
    surfaces = [scene.surface for scene in scenes]
    if not all(_same(surface, surfaces[0]) for surface in surfaces):
        motion["surface"] = surfaces
    last = scenes[-1].motion
    if isinstance(last, Transient):
        motion["spin_offset"] = last.spin_offset
    history = Transient(steps=len(scenes), **motion)
    return replace(scenes[0], normal_force=None, approach=None, friction=None, motion=history)


def _joined(steps: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Entries of steps as those of a history."""
    motion: dict[str, Any] = {name: [step.get(name, 0.0) for step in steps] for name in STEP}
    motion |= {name: [step[name] for step in steps] for name in ("dq", "direction", "friction")}
    for name in ("Fx", "Fy", "normal_force", "approach"):
        values = [step.get(name) for step in steps]
        if set(values) != {None}:
            motion[name] = values
    return motion


def _same(surface: Any, other: Any) -> bool:
    if surface is other:
        return True
    both = hasattr(surface, "h") and hasattr(other, "h")
    return both and np.array_equal(surface.h, other.h)


def _step_of(scene: Scene) -> dict[str, Any]:
    """A shift, or a history of one step, by the entries of a step."""
    motion = scene.motion
    if isinstance(motion, Transient):
        step = {
            name: motion.of(name, 0) for name in (*STEP, "Fx", "Fy", "normal_force", "approach")
        }
        step |= {name: motion.of(name, 0) for name in ("dq", "direction", "friction")}
        return step
    assert isinstance(motion, Shift)
    step = {name: getattr(motion, name) for name in ("ux", "uy", "rotation", "Fx", "Fy")}
    load = {"normal_force": scene.normal_force, "approach": scene.approach}
    return step | load | {"dq": 0.0, "direction": 1, "friction": scene.friction}
