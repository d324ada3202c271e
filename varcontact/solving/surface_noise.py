"""Whether noise rules the pressure of a sampled surface, and which smoothing would help."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState, unloaded
from varcontact.errors import SceneError
from varcontact.scene.interpolation import how_to_smooth, smoothed_field
from varcontact.scene.scene import Scene
from varcontact.solving.contact_solver import ContactSolver

SHORTEST = 4
"""The shortest waves that elements resolve, in elements: pressure sees two a wave as noise."""
SUSPECT = 0.03
"""Pressure that the shortest waves would make on a flat surface, by the largest: less is not looked
into."""
RULES = 0.2
"""Change of the largest pressure without the shortest waves that means that they rule it."""
SETTLED = 0.1
"""Change of it, if the wavelength is doubled, by which it has settled."""
ABOVE = 4.0
"""Distances are looked at up to so many times those within the contact: cliffs beside it are not
smoothed."""


Look = tuple[float, int]
"""The largest pressure [force/area], and the pieces of the contact, connected by sides or corners
of elements."""


def noise_warning(
    scene: Scene, disc: Discretisation, state: ContactState, solver: ContactSolver
) -> str:
    """The warning that the shortest waves of a sampled surface rule the pressure, and what
    smoothing helps; or nothing.

    A wave of length L and amplitude d takes the pressure ``pi G d / ((1 - nu) L)`` to be pressed
    flat. If what is shorter than four elements, within the contact, comes to less than 3 % of the
    largest pressure, there is no noise. Otherwise the normal problem is solved without it: it rules
    if the largest pressure changes by more than a fifth, or the number of patches does. The
    wavelength that helps is the least, doubled from four elements on, with which the largest
    pressure changes by less than a tenth and the patches do not, if it is doubled.
    """
    if not state.pressure.any():
        return ""
    shortest = SHORTEST * max(disc.grid.sides[:1] if disc.grid.line else disc.grid.sides)
    inside = (state.pressure > 0) & ~_beside_cliffs(disc, state, shortest)
    if not inside.any():
        return ""
    waves = (disc.distance - _without(disc, state, shortest))[inside]
    amplitude = math.sqrt(2) * float(np.std(waves)) / disc.scales.displacement
    pressure = math.pi * amplitude * disc.scales.length / ((1 - disc.bodies.combined_nu) * shortest)
    if pressure < SUSPECT * float(state.pressure.max()):
        return ""
    left, right, bottom, top = disc.grid.box
    longest = max(right - left, 0.0 if disc.grid.line else top - bottom)
    try:
        found, without = (_look(disc, state, solver, length) for length in (0.0, shortest))
        if _apart(found, without) < RULES:
            return ""
        helps = shortest
        after = without
        while helps <= longest / 2:
            before = after
            after = _look(disc, state, solver, 2 * helps)
            if _apart(before, after) < SETTLED:
                break
            helps *= 2
    except SceneError:  # so few elements that none is left without the waves: nothing to compare
        return ""
    length = ""
    per_area = ""
    if scene.units is not None:
        length, per_area = (
            f" {scene.units.of(quantity, scene.line)}" for quantity in ("length", "pressure")
        )
    (most, pieces), (smooth, patches) = found, without
    text = (
        f"noise rules the pressure: without waves of the surface shorter than {shortest:.3g}{length}, four elements, "
        f"the largest is {smooth:.3g} in place of {most:.3g}{per_area}"
    )
    if patches != pieces:
        text += f", in {patches} patch{'es' * (patches > 1)} in place of {pieces}"
    if helps > longest / 2:
        return f"{text}; no smoothing settles it: measure the surface again, or take the answer for this grid alone"
    return f"{text}; {how_to_smooth(f'{helps:.3g}')}, from which on it has settled"


def _beside_cliffs(disc: Discretisation, state: ContactState, wavelength: float) -> np.ndarray:
    """Elements near a cliff up to the cut, as at the end of a body: smoothing rounds it.

    What it changes falls by exp(-4.4) over a wavelength, to 1e-4 of the cliff over two.
    """
    from scipy.ndimage import distance_transform_edt

    far = disc.distance > _cut(disc, state)
    if not far.any():
        return far
    return np.asarray(distance_transform_edt(~far, sampling=disc.grid.sides[::-1]) < 2 * wavelength)


def _look(
    disc: Discretisation, state: ContactState, solver: ContactSolver, wavelength: float
) -> Look:
    """The pressure without tractions on the surface without shorter waves."""
    from scipy.ndimage import label

    smooth = replace(disc, distance=_without(disc, state, wavelength)) if wavelength > 0 else disc
    pressure = solver.pressure(smooth, unloaded(disc.grid)).pressure
    return float(pressure.max()) * disc.scales.pressure, int(
        label(pressure > 0, structure=np.ones((3, 3)))[1]
    )


def _apart(one: Look, other: Look) -> float:
    """Relative difference of the largest pressures, infinite where there are other patches."""
    return abs(one[0] / other[0] - 1) if one[1] == other[1] else math.inf


def _without(disc: Discretisation, state: ContactState, wavelength: float) -> np.ndarray:
    """The undeformed distance without shorter waves, cut off where it is far above the contact."""
    return smoothed_field(
        np.minimum(disc.distance, _cut(disc, state)), disc.grid.x, disc.grid.y, wavelength
    )


def _cut(disc: Discretisation, state: ContactState) -> float:
    """The distance that is far above the contact."""
    touching = disc.distance[state.pressure > 0]
    least = float(disc.distance.min())
    return least + ABOVE * (float(touching.max()) - least) + disc.scales.displacement
