"""Media of scenes: bodies, a shear layer between them, a curved surface on which they meet. Media
that change the numbers of another one are named here, and bodies that give no medium themselves.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from varcontact.elasticity.bedding import Bedding
from varcontact.elasticity.conformal import Conformal, Inclination
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.operators import Homogeneous, Medium
from varcontact.elasticity.pin_in_hole import PinInHoleMedium
from varcontact.elasticity.shear_layer import ShearLayer
from varcontact.elasticity.viscoelastic import Lagging, ViscoelasticMedium
from varcontact.errors import SceneError
from varcontact.scene.bodies import (
    RIGID,
    Bodies,
    Body,
    BodyPair,
    Layered,
    Stratified,
    Viscoelastic,
    Winkler,
    materials,
)
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Grid
from varcontact.scene.pin import PinInHole
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance, is_curved

if TYPE_CHECKING:
    from varcontact.elasticity.layered import Stack

FREE_DEPTH = 4.0
"""Depth of line contact in lengths of the potential contact where the scene gives none: then no
answer shows it.

From one length on all influence numbers are positive, and A_zz is positive definite.
"""


def medium_on(
    scene: Scene, grid: Grid, length: float, depth: float | None, speed: float | None
) -> Medium:
    """The medium of a scene on a grid in units of a length: its bodies, the layer between them, the
    curved surface.

    `depth` and `speed` as of `medium_of`.
    """
    surface = scene.surface
    if isinstance(surface, PinInHole):
        assert isinstance(scene.bodies, Bodies)
        medium: Medium = _pin_in_hole(scene.bodies, surface, length)
    else:
        medium = medium_of(scene.bodies, length, depth, speed)
    if grid.periodic:
        medium = _periodic(medium, grid)
    if scene.layer_compliance > 0:
        medium = ShearLayer(medium, scene.layer_compliance * scene.bodies.combined_G / length)
    if isinstance(surface, SampledDistance) and is_curved(surface):
        by_row = _inclination(surface.y, surface.inclination, grid.y, length)
        by_column = _inclination(surface.x, surface.inclination_x, grid.x, length)
        medium = Conformal(medium, by_row, by_column)
    return medium


def _periodic(medium: Medium, grid: Grid) -> Medium:
    """Medium that repeats with the grid as its period."""
    from varcontact.elasticity.layered import LayeredPair
    from varcontact.elasticity.periodic import Periodic
    from varcontact.elasticity.symbol_medium import SymbolMedium

    if not isinstance(medium, HalfSpaces | LayeredPair | SymbolMedium):
        allowed = "False: these bodies have no numbers of a period"
        raise SceneError("grid.periodic", grid.periodic, allowed)
    rows_repeat = grid.line or grid.periodic is True
    return Periodic(medium, grid.shape, rows_repeat, grid.tractions == "trigonometric")


def _pin_in_hole(bodies: Bodies, surface: PinInHole, length: float) -> PinInHoleMedium:
    moduli, ratios = bodies.pairs
    G1, G2 = (each / bodies.combined_G for each in moduli)
    return PinInHoleMedium(surface.R / length, (G1, G2), ratios, surface.depth / length)


def _inclination(
    places: np.ndarray | None, angles: np.ndarray | None, centres: np.ndarray, length: float
) -> Inclination | None:
    """Inclinations at the places of samples, or at the centres of elements."""
    if angles is None:
        return None
    if places is None:
        places = centres
    return Inclination(tuple((places / length).tolist()), tuple(angles.tolist()))


def medium_of(
    bodies: Bodies | BodyPair | GivenBodies,
    length: float,
    depth: float | None,
    speed: float | None = None,
) -> Medium:
    """The medium of a scene's bodies, at a speed, in units of a length.

    `depth` is in units of that length already; without it, it is as deep as makes all influence
    numbers positive.
    """
    if depth is None:
        depth = FREE_DEPTH * max(1.0, (speed or 0.0) * bodies.longest_relaxation / length)
    if isinstance(bodies, Bodies):
        return HalfSpaces(bodies.combined_nu, bodies.K, depth)
    if isinstance(bodies, GivenBodies):
        given: Medium = bodies.medium(length, depth)
        return given
    return _of_pair(bodies, length, depth, speed)


def _of_pair(bodies: BodyPair, length: float, depth: float, speed: float | None) -> Medium:
    """The medium of two bodies, one of which at least is no homogeneous half-space."""
    if bodies.bedded:
        return _bedding(bodies, length)
    if not any(isinstance(body, Layered | Stratified) for body in (bodies.upper, bodies.lower)):
        assert speed is not None
        return _viscoelastic(bodies, length, depth, speed)
    if bodies.of_several_solids:
        return _of_several_solids(bodies, length, depth, speed or 0.0)
    return _layered(bodies, length, depth, speed or 0.0)


def _bedding(bodies: BodyPair, length: float) -> Bedding:
    """Springs of both bodies in series."""
    beds = [body for body in bodies.both if isinstance(body, Winkler)]
    unit = length / bodies.combined_G
    return Bedding(
        normal=sum(body.h / body.E for body in beds) / unit,
        tangential=sum(body.h / body.G for body in beds) / unit,
    )


def _layered(bodies: BodyPair, length: float, depth: float, speed: float) -> Homogeneous:
    """Layers of one solid on each body; if the solid relaxes, with delayed displacements."""
    from varcontact.elasticity.layered import LayeredPair

    def elastic(pair: BodyPair) -> LayeredPair:
        G = pair.combined_G
        return LayeredPair(_stack(pair.upper, G, length), _stack(pair.lower, G, length), depth)

    # bodies that relax: each alone on a rigid one, or both together where they are alike
    sides: tuple[tuple[Body | str, Body | str, Body | str], ...]
    if bodies.coupled:
        sides = (bodies.upper, bodies.upper, RIGID), (bodies.lower, RIGID, bodies.lower)
    else:
        sides = ((bodies.upper, bodies.upper, bodies.lower),)
    lagging = []
    for body, upper, lower in sides:
        _, _, relaxations = materials(body)[0]
        if not relaxations:
            continue
        alone = BodyPair(upper, lower)
        medium = elastic(alone)
        share = bodies.combined_G / alone.combined_G
        for part, time in relaxations:
            lagging.append(Lagging(speed * time / length, part * share, medium))
    whole = elastic(bodies)
    if not lagging:
        return whole
    return ViscoelasticMedium(whole, tuple(lagging))


def _stack(body: Body | str, G: float, length: float) -> Stack:
    from varcontact.elasticity.layered import Stack

    if isinstance(body, Stratified):
        stack: Stack = body.stack(G, length)
        return stack
    if not isinstance(body, Layered):
        modulus, nu, _ = materials(body)[0]
        return Stack((), (modulus / G, nu))
    layers = tuple((layer.h / length, layer.G / G, layer.nu) for layer in body.layers)
    if isinstance(body.base, str):
        return Stack(layers, body.base)
    return Stack(layers, (body.base[0] / G, body.base[1]))


def _of_several_solids(bodies: BodyPair, length: float, depth: float, speed: float) -> Homogeneous:
    """Layers that are solids of their own, and half-spaces of those at the surfaces."""
    from varcontact.elasticity.rolling_layers import RollingLayers, Solids

    def solids(body: Body | str) -> Solids:
        lengths = tuple(
            tuple((f, speed * time / length) for f, time in each) for _, _, each in materials(body)
        )
        return Solids(_stack(body, bodies.combined_G, length), lengths)

    def surface(body: Body | str) -> Body | str:
        G, nu, relaxations = materials(body)[0]
        if np.isinf(G):
            return RIGID
        if relaxations:
            return Viscoelastic(G, nu, relaxations)
        return Bodies(G, nu)

    pair = BodyPair(surface(bodies.upper), surface(bodies.lower))
    surfaces = _viscoelastic(pair, length, depth, speed)
    return RollingLayers(surfaces, solids(bodies.upper), solids(bodies.lower), depth)


def _viscoelastic(
    bodies: BodyPair, length: float, depth: float, speed: float
) -> ViscoelasticMedium:
    """Medium of viscoelastic bodies as a sum over bodies, each on a rigid one: 1/G is half of its
    own, K is half of 1 - 2 nu with the sign of its side.
    """
    surfaces = bodies.surfaces
    # shares of both bodies in the delayed displacements, by relaxation length
    parts: dict[float, list[tuple[float, float, float]]] = {}
    for body, side in ((bodies.upper, 1.0), (bodies.lower, -1.0)):
        if not isinstance(body, Viscoelastic):
            continue
        for part, time in body.relaxations:
            weight = surfaces.combined_G / (2 * body.G) * part
            difference = side * (1 - 2 * body.nu) / 2
            parts.setdefault(speed * time / length, []).append((weight, body.nu, difference))
    # one half-space with their mean properties for each length
    lagging = []
    for distance, shares in parts.items():
        weights, ratios, differences = np.array(shares).T
        factor = float(weights.sum())
        K = 0.0
        if bodies.coupled:
            K = float(weights @ differences) / factor
        medium = HalfSpaces(float(weights @ ratios) / factor, K, depth)
        lagging.append(Lagging(distance, factor, medium))
    return ViscoelasticMedium(HalfSpaces(surfaces.combined_nu, surfaces.K, depth), tuple(lagging))
