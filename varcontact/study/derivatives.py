"""Derivatives of solutions by numbers of their scenes, as columns of a study's dataset."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from varcontact.errors import SceneError
from varcontact.gradients.inputs import derivative_unit, number_of, path_of, quantity_of
from varcontact.results.solution import Solution
from varcontact.scene import consistency
from varcontact.scene.scene import Scene
from varcontact.scene.units import Units

OUTPUTS = {"Fx": "force", "Fy": "force", "Mz": "moment"}
"""Outputs that have derivatives, and their quantities."""


def inputs_of(by: Any, scenes: Sequence[Scene]) -> list[str]:
    """Names of inputs, one or several; refused where a scene has none of that name, or no
    gradient.
    """
    inputs = list(by)
    if isinstance(by, str):
        inputs = [by]
    if not inputs:
        return []
    for scene in scenes:
        if scene.motion is None:
            raise SceneError("by", by, "left out: a scene has no motion, and so no forces")
        consistency.check_differentiable(scene)
        for name in inputs:
            number_of(scene, path_of(name))
    return inputs


def derivatives_of(solution: Solution, inputs: Sequence[str]) -> np.ndarray:
    """Derivatives of the outputs, (outputs, inputs)."""
    if not inputs:
        return np.empty((len(OUTPUTS), 0))
    found = solution.gradient(list(OUTPUTS), by=inputs)
    return np.array([found[name].to_numpy() for name in inputs]).T


def columns_of(
    slopes: Any, inputs: Sequence[str], dims: tuple[str, ...], units: Units | None
) -> dict[str, Any]:
    """Columns by name, as "Fx_by_friction", of derivatives (..., outputs, inputs)."""
    derivatives = np.asarray(slopes)
    columns: dict[str, Any] = {}
    for row, (output, quantity) in enumerate(OUTPUTS.items()):
        for column, name in enumerate(inputs):
            attributes = {}
            if units is not None:
                below = units.of(quantity_of(path_of(name)))
                attributes["units"] = derivative_unit(units.of(quantity), below)
            columns[f"{output}_by_{name}"] = dims, derivatives[..., row, column], attributes
    return columns
