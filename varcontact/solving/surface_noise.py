"""Whether noise rules the pressure of a sampled surface, and which smoothing would help."""

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
"""The shortest waves that elements resolve, in elements: pressure sees two a wave as noise."""
SUSPECT = 0.03
"""Pressure that the shortest waves would make on a flat surface, by the largest: less is not looked into."""
RULES = 0.2
"""Change of the largest pressure without the shortest waves that means that they rule it."""
SETTLED = 0.1
"""Change of it, if the wavelength is doubled, by which it has settled."""
ABOVE = 4.0
"""Distances are looked at up to so many times those within the contact: cliffs beside it are not smoothed."""


@dataclass(frozen=True)
class Look:
    """The largest pressure [force/area], and the pieces of the contact, connected by sides or corners of elements."""

    peak: float
    patches: int

    def apart(self, other: Look) -> float:
        """Relative difference of the peak from that of the `other`, infinite where there are other patches."""
        return abs(self.peak / other.peak - 1) if self.patches == other.patches else math.inf


def noise_warning(scene: Scene, disc: Discretisation, state: ContactState, solver: ContactSolver) -> str:
    """The warning that the shortest waves of a sampled surface rule the pressure, and what smoothing helps; or nothing.

    A wave of length L and amplitude d takes the pressure ``pi G d / ((1 - nu) L)`` to be pressed flat. If what is
    shorter than four elements, within the contact, comes to less than 3 % of the largest pressure, there is no noise.
    Otherwise the normal problem is solved without it: it rules if the largest pressure changes by more than a fifth,
    or the number of patches does. The wavelength that helps is the least, doubled from four elements on, with which
    the largest pressure changes by less than a tenth and the patches do not, if it is doubled.
    """
    element = max(disc.grid.sides[:1] if disc.grid.line else disc.grid.sides)
    shortest = SHORTEST * element
    if not state.pressure.any():
        return ""
    waves = (disc.distance - _without(disc, state, shortest))[state.pressure > 0]
    amplitude = math.sqrt(2) * float(np.std(waves)) / disc.scales.displacement
    pressure = math.pi * amplitude * disc.scales.length / ((1 - disc.bodies.combined_nu) * shortest)
    if pressure < SUSPECT * float(state.pressure.max()):
        return ""
    try:
        found = _look(disc, state)
        if disc.K != 0 or disc.subgrid is not None:
            found = _look(disc, solver.pressure(disc, unloaded(disc.grid)))
        without = before = _smoothed_look(disc, state, solver, shortest)
        if found.apart(without) < RULES:
            return ""
        left, right, bottom, top = disc.grid.box
        longest = max(right - left, 0.0 if disc.grid.line else top - bottom)
        helps, wavelength = 0.0, 2 * shortest
        while helps == 0 and wavelength <= longest:
            after = _smoothed_look(disc, state, solver, wavelength)
            helps = wavelength / 2 if before.apart(after) < SETTLED else 0.0
            before, wavelength = after, 2 * wavelength
    except SceneError:  # so few elements that none is left without the waves: nothing to compare
        return ""
    length, per_area = "", ""
    if scene.units is not None:
        length, per_area = (f" {scene.units.of(quantity, scene.line)}" for quantity in ("length", "pressure"))
    by_centres = " at the elements' centres" if scene.edge != "centres" else ""
    patches = ""
    if without.patches != found.patches:
        patches = f", in {without.patches} patch{'es' * (without.patches > 1)} in place of {found.patches}"
    text = (
        f"noise rules the pressure: without waves of the surface shorter than {shortest:.3g}{length}, four "
        f"elements, the largest{by_centres} is {without.peak:.3g} in place of {found.peak:.3g}"
        f"{per_area}{patches}; "
    )
    if helps == 0:
        return text + "no smoothing settles it: measure the surface again, or take the answer for this grid alone"
    return text + f"{how_to_smooth(f'{helps:.3g}')}, from which on it has settled"


def _look(disc: Discretisation, state: ContactState) -> Look:
    from scipy.ndimage import label

    patches = label(state.pressure > 0, structure=np.ones((3, 3)))[1]
    return Look(float(state.pressure.max()) * disc.scales.pressure, int(patches))


def _smoothed_look(disc: Discretisation, state: ContactState, solver: ContactSolver, wavelength: float) -> Look:
    """The pressure without tractions on the surface without shorter waves."""
    smooth = replace(disc, distance=_without(disc, state, wavelength))
    return _look(smooth, solver.pressure(smooth, unloaded(disc.grid)))


def _without(disc: Discretisation, state: ContactState, wavelength: float) -> np.ndarray:
    """The undeformed distance without shorter waves, cut off where it is far above the contact."""
    touching = disc.distance[state.pressure > 0]
    least = float(disc.distance.min())
    reach = ABOVE * (float(touching.max()) - least) + disc.scales.displacement
    return smoothed_field(np.minimum(disc.distance, least + reach), disc.grid.x, disc.grid.y, wavelength)
