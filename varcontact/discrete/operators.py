"""The influence numbers of a lattice: one object owns all tables, and builds each when it is first
asked for.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from varcontact.elasticity.conformal import Conformal
from varcontact.elasticity.halfspace import HalfSpaces
from varcontact.elasticity.operators import GridOperator, Homogeneous, Medium
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
    materials,
)
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surfaces import SampledDistance
from varcontact.transports import HERE, Stencil

if TYPE_CHECKING:
    from varcontact.elasticity.layered import Stack

FREE_DEPTH = 4.0
"""Depth of line contact in lengths of the potential contact where the scene gives none: then no
answer shows it.

From one length on all influence numbers are positive, and A_zz is positive definite.
"""

KEPT_DISTANCES = 4
"""Operators that are kept of each kind that has a distance: of steps in time, and of steps of
steady rolling."""

KEPT_MEDIA = 12
"""Those that are kept for parts of viscoelastic bodies, and for steps of other lengths in time."""


@dataclass(frozen=True)
class Operators:
    """The operators between tractions and displacements on a lattice, dimensionless (G = 1).

    What is derived from a discretisation holds the same object: whoever builds a table first,
    builds it for all.
    """

    lattice: Grid
    medium: Medium
    _tables: dict[tuple[str, str, Stencil], GridOperator] = field(
        default_factory=dict, repr=False, compare=False
    )
    _parts: dict[tuple[Grid, Medium], Operators] = field(
        default_factory=dict, repr=False, compare=False
    )

    @property
    def normal(self) -> GridOperator:
        """A_zz: distances by pressures."""
        return self._table("z", "z")

    def tangential(self, stencil: Stencil = HERE) -> GridOperator:
        """A_tt, shifts by tractions; in steady rolling A_tt - C_tt."""
        return self._table("xy", "xy", stencil)

    def pressure_to_shift(self, stencil: Stencil = HERE) -> GridOperator:
        """A_tz, shifts by pressures, where K != 0; in steady rolling A_tz - C_tz."""
        return self._table("xy", "z", stencil)

    @property
    def traction_to_distance(self) -> GridOperator:
        """A_zt: distances by tractions, where K != 0."""
        return self._table("z", "xy")

    def carrying(self, distance: float) -> GridOperator:
        """C: displacements of the particles that come from further along x, by all tractions that
        count.
        """
        return self._table("xy", "xyz" if self.medium.K != 0 else "xy", ((distance, 1.0),))

    @property
    def every(self) -> GridOperator:
        """All displacements by all tractions."""
        return self._table("xyz", "xyz")

    def of(self, medium: Medium, lattice: Grid | None = None) -> Operators:
        """Those of another medium, a part of this one, on this lattice; or on another one."""
        key = lattice or self.lattice, medium
        if key == (self.lattice, self.medium):
            return self
        if key not in self._parts:
            for oldest in list(self._parts)[: max(len(self._parts) + 1 - KEPT_MEDIA, 0)]:
                del self._parts[oldest]
            self._parts[key] = Operators(*key)
        return self._parts[key]

    @property
    def at_once(self) -> Operators:
        """Those of viscoelastic bodies as they are at once; of elastic ones these."""
        return self.of(self.medium.at_once)

    def at_end(self, time: float | None) -> Operators:
        """Those of viscoelastic bodies at the end of a step that takes a time; of elastic ones
        these.
        """
        return self if time is None else self.of(self.medium.at_end(time))

    def forget(self) -> None:
        """Let go of the dense matrices and factors that were kept for the next pass; the tables
        stay.

        They and their tables refer to each other: without it they would stay in memory until Python
        looks for cycles.
        """
        for operator in self._tables.values():
            operator.forget()
        for operators in self._parts.values():
            operators.forget()

    def _table(self, rows: str, columns: str, stencil: Stencil = HERE) -> GridOperator:
        key = rows, columns, stencil
        if key not in self._tables:
            if stencil != HERE:
                # a few of each kind are kept: of steps of steady rolling, and of steps in time
                single = len(stencil) == 1
                alike = [
                    each
                    for each in self._tables
                    if each[2] != HERE and (len(each[2]) == 1) == single
                ]
                for oldest in alike[: max(len(alike) + 1 - KEPT_DISTANCES, 0)]:
                    del self._tables[oldest]
            operator = self.medium.operator(self.lattice, *key)
            self._check_shape(operator, rows, columns)
            self._tables[key] = operator
        return self._tables[key]

    def _check_shape(self, operator: GridOperator, rows: str, columns: str) -> None:
        """Refuse an operator that is not between these components on this lattice."""
        ny, nx = self.lattice.shape
        expected = (len(rows), len(columns), 2 * ny - 1, 2 * nx - 1)
        if operator.shape != (ny, nx) or operator.table.shape != expected:
            medium = type(self.medium).__name__
            made = f"the operator of {medium} from {columns} to {rows} has a table of shape {operator.table.shape}"
            message = f"{made} on {operator.shape} elements; {expected} is needed"
            raise SceneError("bodies", self.medium, message=message)


def medium_on(
    scene: Scene, grid: Grid, length: float, depth: float | None, speed: float | None
) -> Medium:
    """The medium of a scene on a grid in units of a length: its bodies, what shears between them,
    the curved surface.

    `depth` and `speed` as of `medium_of`.
    """
    medium: Medium = medium_of(scene.bodies, length, depth, speed)
    layer = scene.third_body
    if layer is not None and layer.compliance > 0:
        medium = ShearLayer(medium, layer.compliance * scene.bodies.combined_G / length)
    surface = scene.surface
    if isinstance(surface, SampledDistance) and surface.inclination is not None:
        y = grid.y if surface.y is None else surface.y
        medium = Conformal(
            medium, tuple((y / length).tolist()), tuple(surface.inclination.tolist())
        )
    return medium


def medium_of(
    bodies: Bodies | BodyPair, length: float, depth: float | None, speed: float | None = None
) -> Homogeneous:
    """The medium of a scene's bodies, at a speed, in units of a length.

    `depth` is in units of that length already; without it, it is as deep as makes all influence
    numbers positive.
    """
    if isinstance(bodies, Bodies):
        return HalfSpaces(bodies.combined_nu, bodies.K, FREE_DEPTH if depth is None else depth)
    if depth is None:
        depth = FREE_DEPTH * max(1.0, (speed or 0.0) * bodies.longest_relaxation / length)
    if not any(isinstance(body, Layered | Stratified) for body in (bodies.upper, bodies.lower)):
        assert speed is not None
        return _viscoelastic(bodies, length, depth, speed)
    if bodies.of_several_solids:
        return _of_several_solids(bodies, length, depth, speed or 0.0)
    from varcontact.elasticity.layered import LayeredPair

    def pair(upper: Body | str, lower: Body | str) -> LayeredPair:
        G = BodyPair(upper, lower).combined_G
        return LayeredPair(_stack(upper, G, length), _stack(lower, G, length), depth)

    lagging = []
    alone = ((bodies.upper, bodies.upper, RIGID), (bodies.lower, RIGID, bodies.lower))
    for body, upper, lower in (
        alone if bodies.coupled else ((bodies.upper, bodies.upper, bodies.lower),)
    ):
        _, _, relaxations = materials(body)[0]
        if relaxations:
            medium, share = (
                pair(upper, lower),
                bodies.combined_G / BodyPair(upper, lower).combined_G,
            )
            lagging += [
                Lagging((speed or 0.0) * time / length, part * share, medium)
                for part, time in relaxations
            ]
    whole = pair(bodies.upper, bodies.lower)
    return ViscoelasticMedium(whole, tuple(lagging)) if lagging else whole


def _stack(body: Body | str, G: float, length: float) -> Stack:
    from varcontact.elasticity.layered import Stack

    if isinstance(body, Stratified):
        stack: Stack = body.stack(G, length)
        return stack
    if not isinstance(body, Layered):
        modulus, nu, _ = materials(body)[0]
        return Stack((), (modulus / G, nu))
    layers = tuple((layer.h / length, layer.G / G, layer.nu) for layer in body.layers)
    return Stack(
        layers, body.base if isinstance(body.base, str) else (body.base[0] / G, body.base[1])
    )


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
        return Viscoelastic(G, nu, relaxations) if relaxations else Bodies(G, nu)

    surfaces = _viscoelastic(
        BodyPair(surface(bodies.upper), surface(bodies.lower)), length, depth, speed
    )
    return RollingLayers(surfaces, solids(bodies.upper), solids(bodies.lower), depth)


def _viscoelastic(
    bodies: BodyPair, length: float, depth: float, speed: float
) -> ViscoelasticMedium:
    """A body alone is one on a rigid one: 1/G is half its own, and K is half of 1 - 2 nu, with the
    sign of its side.
    """
    surfaces, parts = bodies.surfaces, dict[float, list[tuple[float, float, float]]]()
    for body, side in ((bodies.upper, 1.0), (bodies.lower, -1.0)):
        if isinstance(body, Viscoelastic):
            for part, time in body.relaxations:
                share = (
                    surfaces.combined_G / (2 * body.G) * part,
                    body.nu,
                    side * (1 - 2 * body.nu) / 2,
                )
                parts.setdefault(speed * time / length, []).append(share)
    lagging = []
    for distance, shares in parts.items():
        weights, ratios, differences = np.array(shares).T
        factor = float(weights.sum())
        K = float(weights @ differences) / factor if bodies.coupled else 0.0
        lagging.append(
            Lagging(distance, factor, HalfSpaces(float(weights @ ratios) / factor, K, depth))
        )
    return ViscoelasticMedium(HalfSpaces(surfaces.combined_nu, surfaces.K, depth), tuple(lagging))
