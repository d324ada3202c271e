"""Noise that dominates the pressure of a sampled surface, and the smoothing that removes it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState, unloaded
from varcontact.errors import SceneError
from varcontact.scene.interpolation import how_to_smooth, smoothed_field
from varcontact.scene.scene import Scene
from varcontact.solving.contact_solver import ContactSolver

SHORTEST = 4
"""Shortest wavelength that elements resolve, in elements: in the pressure, waves of two elements
are noise."""
SUSPECT = 0.03
"""Pressure of the shortest waves on a flat surface, divided by the largest pressure, below which
noise is not examined."""
RULES = 0.2
"""Relative change of the largest pressure without the shortest waves above which they dominate
it."""
SETTLED = 0.1
"""Relative change of the largest pressure with doubled wavelength below which it has converged."""
ABOVE = 4.0
"""Largest distance, divided by the largest within the contact, that is smoothed: cliffs beside it
are cut off."""


@dataclass(frozen=True)
class _Pressure:
    """The largest pressure [force/area], and the number of patches, connected by sides or corners
    of elements.
    """

    largest: float
    patches: int

    def change(self, other: _Pressure) -> float:
        """Relative difference of the largest pressures, infinite where there are other patches."""
        if self.patches != other.patches:
            return math.inf
        return abs(self.largest / other.largest - 1)


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
    sides = disc.grid.sides[:1] if disc.grid.line else disc.grid.sides
    shortest = SHORTEST * max(sides)
    if not _suspect(disc, state, shortest):
        return ""

    # the pressure with and without the waves, and the wavelength from which on it stays
    left, right, bottom, top = disc.grid.box
    longest = right - left
    if not disc.grid.line:
        longest = max(longest, top - bottom)
    try:
        noisy = _pressure(disc, state, solver, 0.0)
        smooth = _pressure(disc, state, solver, shortest)
        if noisy.change(smooth) < RULES:
            return ""
        wavelength = shortest
        after = smooth
        while wavelength <= longest / 2:
            before = after
            after = _pressure(disc, state, solver, 2 * wavelength)
            if before.change(after) < SETTLED:
                break
            wavelength *= 2
    except SceneError:  # so few elements that none is left without the waves: nothing to compare
        return ""
    text = _sentence(scene, shortest, noisy, smooth)
    if wavelength > longest / 2:
        remedy = "measure the surface again, or take the answer for this grid alone"
        return f"{text}; no smoothing settles it: {remedy}"
    return f"{text}; {how_to_smooth(f'{wavelength:.3g}')}, from which on it has settled"


def _suspect(disc: Discretisation, state: ContactState, shortest: float) -> bool:
    """True if the pressure needed to flatten the shortest waves is not small."""
    inside = (state.pressure > 0) & ~_beside_cliffs(disc, state, shortest)
    if not inside.any():
        return False
    waves = (disc.distance - _without(disc, state, shortest))[inside]
    amplitude = math.sqrt(2) * float(np.std(waves)) / disc.scales.displacement
    pressure = math.pi * amplitude * disc.scales.length / ((1 - disc.bodies.combined_nu) * shortest)
    return pressure >= SUSPECT * float(state.pressure.max())


def _sentence(scene: Scene, shortest: float, noisy: _Pressure, smooth: _Pressure) -> str:
    length = ""
    per_area = ""
    if scene.units is not None:
        length = f" {scene.units.of('length', scene.line)}"
        per_area = f" {scene.units.of('pressure', scene.line)}"
    text = (
        f"noise rules the pressure: without waves of the surface shorter than {shortest:.3g}"
        f"{length}, four elements, the largest is {smooth.largest:.3g} in place of "
        f"{noisy.largest:.3g}{per_area}"
    )
    if smooth.patches != noisy.patches:
        patches = "1 patch" if smooth.patches == 1 else f"{smooth.patches} patches"
        text += f", in {patches} in place of {noisy.patches}"
    return text


def _beside_cliffs(disc: Discretisation, state: ContactState, wavelength: float) -> np.ndarray:
    """Elements near a cliff up to the cut, as at the end of a body: smoothing rounds it.

    What it changes falls by exp(-4.4) over a wavelength, to 1e-4 of the cliff over two.
    """
    from scipy.ndimage import distance_transform_edt

    far = disc.distance > _cut(disc, state)
    if not far.any():
        return far
    return np.asarray(distance_transform_edt(~far, sampling=disc.grid.sides[::-1]) < 2 * wavelength)


def _pressure(
    disc: Discretisation, state: ContactState, solver: ContactSolver, wavelength: float
) -> _Pressure:
    """Pressure without tractions on the surface without waves shorter than a wavelength."""
    from scipy.ndimage import label

    if wavelength > 0:
        disc = replace(disc, distance=_without(disc, state, wavelength))
    pressure = solver.pressure(disc, unloaded(disc.grid)).pressure
    _, patches = label(pressure > 0, structure=np.ones((3, 3)))
    return _Pressure(float(pressure.max()) * disc.scales.pressure, int(patches))


def _without(disc: Discretisation, state: ContactState, wavelength: float) -> np.ndarray:
    """Undeformed distance without waves shorter than a wavelength, cut off far above the
    contact.
    """
    return smoothed_field(
        np.minimum(disc.distance, _cut(disc, state)), disc.grid.x, disc.grid.y, wavelength
    )


def _cut(disc: Discretisation, state: ContactState) -> float:
    """Distance far above the contact at which it is cut off."""
    touching = disc.distance[state.pressure > 0]
    least = float(disc.distance.min())
    return least + ABOVE * (float(touching.max()) - least) + disc.scales.displacement
