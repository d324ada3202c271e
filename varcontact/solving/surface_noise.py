"""Whether noise rules the pressure of a sampled surface, and which smoothing would help."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from varcontact.discrete.discretisation import Discretisation
from varcontact.discrete.state import ContactState
from varcontact.errors import SceneError
from varcontact.scene.interpolation import how_to_smooth, smoothed_field
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance

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
    """What the pressure looks like.

    Attributes
    ----------
    peak : float
        The largest pressure [force/area].
    patches : int
        Pieces of the contact, each connected by sides or corners of elements.
    """

    peak: float
    patches: int

    def apart(self, other: Look) -> float:
        """Relative difference of the peak from that of the `other`, infinite where there are other patches."""
        return abs(self.peak / other.peak - 1) if self.patches == other.patches else math.inf


def noise_warning(
    scene: Scene, disc: Discretisation, state: ContactState, pressure_on: Callable[[Discretisation], ContactState]
) -> str:
    """Say so if the shortest waves of a sampled surface rule the pressure.

    Parameters
    ----------
    scene : Scene
    disc : Discretisation
        On the grid of the solution.
    state : ContactState
        Of the solution, dimensionless.
    pressure_on : callable
        Solves the normal problem of a discretisation without tractions.

    Returns
    -------
    str
        With the wavelength from which smoothing helps; empty where nothing is wrong.

    Notes
    -----
    A wave of length L and amplitude d takes the pressure ``pi G d / ((1 - nu) L)`` to be pressed flat. If what is
    shorter than four elements, within the contact, comes to less than 3 % of the largest pressure, there is no noise.
    Otherwise the normal problem is solved without it: it rules if the largest pressure changes by more than a fifth,
    or the number of patches does. The wavelength that helps is the least, doubled from four elements on, with which
    the largest pressure changes by less than a tenth and the patches do not, if it is doubled.
    """
    if not isinstance(scene.surface, SampledDistance) or not state.pressure.any():
        return ""
    element = max(disc.grid.sides[:1] if disc.line else disc.grid.sides)
    if _shortest(disc, state, SHORTEST * element) < SUSPECT * float(state.pressure.max()):
        return ""

    def look(wavelength: float) -> Look:
        posed = disc if wavelength == 0 else replace(disc, distance=_without(disc, state, wavelength))
        return _look(posed, pressure_on(posed))

    try:
        found = look(0.0) if disc.K != 0 or disc.subgrid is not None else _look(disc, state)
        without = look(SHORTEST * element)
        if found.apart(without) < RULES:
            return ""
        helps = _helps(look, without, list(_wavelengths(disc, element)))
    except SceneError:  # so few elements that none is left without the waves: nothing to compare
        return ""
    return _message(found, without, SHORTEST * element, helps, scene)


def _look(disc: Discretisation, state: ContactState) -> Look:
    from scipy.ndimage import label

    patches = label(state.pressure > 0, structure=np.ones((3, 3)))[1]
    return Look(float(state.pressure.max()) * disc.scales.pressure, int(patches))


def _without(disc: Discretisation, state: ContactState, wavelength: float) -> np.ndarray:
    """The undeformed distance without shorter waves, cut off where it is far above the contact."""
    touching = disc.distance[state.pressure > 0]
    least = float(disc.distance.min())
    reach = ABOVE * (float(touching.max()) - least) + disc.scales.displacement
    return smoothed_field(np.minimum(disc.distance, least + reach), disc.grid.x, disc.grid.y, wavelength)


def _shortest(disc: Discretisation, state: ContactState, wavelength: float) -> float:
    """Dimensionless pressure that presses the waves flat that are shorter, those within the contact."""
    waves = (disc.distance - _without(disc, state, wavelength))[state.pressure > 0]
    amplitude = math.sqrt(2) * float(np.std(waves)) / disc.scales.displacement
    return math.pi * amplitude * disc.scales.length / ((1 - disc.bodies.combined_nu) * wavelength)


def _wavelengths(disc: Discretisation, element: float) -> Iterator[float]:
    """From twice the shortest on, doubled, up to the length of the potential contact."""
    box = disc.grid.box
    longest = max(box[1] - box[0], 0.0 if disc.line else box[3] - box[2])
    wavelength = 2 * SHORTEST * element
    while wavelength <= longest:
        yield wavelength
        wavelength *= 2


def _helps(look: Callable[[float], Look], shortest: Look, wavelengths: list[float]) -> float:
    """The least wavelength from which the pressure has settled; 0: none."""
    before = shortest
    for wavelength in wavelengths:
        after = look(wavelength)
        if before.apart(after) < SETTLED:
            return wavelength / 2
        before = after
    return 0.0


def _message(found: Look, without: Look, shortest: float, helps: float, scene: Scene) -> str:
    def unit(quantity: str) -> str:
        return f" {scene.units.of(quantity, scene.line)}" if scene.units is not None else ""

    by_centres = " at the elements' centres" if scene.touched else ""
    patches = ""
    if without.patches != found.patches:
        patches = f", in {without.patches} patch{'es' * (without.patches > 1)} in place of {found.patches}"
    text = (
        f"noise rules the pressure: without waves of the surface shorter than {shortest:.3g}{unit('length')}, four "
        f"elements, the largest{by_centres} is {without.peak:.3g} in place of {found.peak:.3g}"
        f"{unit('pressure')}{patches}; "
    )
    if helps == 0:
        return text + "no smoothing settles it: measure the surface again, or take the answer for this grid alone"
    return text + f"{how_to_smooth(f'{helps:.3g}')}, from which on it has settled"
