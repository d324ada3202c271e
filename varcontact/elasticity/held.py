"""Bodies whose surfaces are held beside the contact (paper, 1.8): the tractions there, which follow
from prescribed displacements, are eliminated.

With tractions p on the contact and forces f on the held parts, displacements in the contact are
``A p + B' f``, those of the held parts ``B p + D f``. Where these are prescribed as d,
``f = D^-1 (d - B p)``: influence numbers in the contact become ``A - B' D^-1 B``, a Schur
complement, and ``B' D^-1 d`` is the displacement by a load beside the contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from varcontact.elasticity.by_element import ELEMENTS_MAX, ElementOperator
from varcontact.elasticity.of_scenes import medium_of
from varcontact.elasticity.operators import GridOperator, Homogeneous, Medium
from varcontact.errors import SceneError
from varcontact.scene.bodies import Bodies, BodyPair, loaded_alone
from varcontact.scene.grid import Grid
from varcontact.scene.scene import Scene
from varcontact.scene.surface_load import LoadedBodies, SurfaceLoad, covered
from varcontact.system.process import lazy_property, one_blas_thread
from varcontact.transports import HERE, Stencil

COMPONENTS = "xyz"


@dataclass(frozen=True)
class Yielding:
    """Deformable bodies, one or both: their medium, and the ratio of the contact's G to theirs."""

    body: LoadedBodies
    medium: Homogeneous
    compliance: float


@dataclass(frozen=True)
class Rectangle:
    """Equal parts beside the contact, with tractions along some components on some bodies."""

    lattice: Grid
    components: str
    body: LoadedBodies

    @property
    def size(self) -> int:
        """Number of tractions."""
        return len(self.components) * self.lattice.size

    @property
    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """x and y of the centres of its parts, row by row."""
        x, y = np.meshgrid(self.lattice.x, self.lattice.y)
        return x.ravel(), y.ravel()


@dataclass(frozen=True)
class HeldParts:
    """Held rectangles of bodies, dimensionless."""

    bodies: tuple[Yielding, ...]
    rectangles: tuple[Rectangle, ...]

    def by(self, loaded: Rectangle, ahead: float = 0.0) -> np.ndarray:
        """Displacements of all held parts by forces on a rectangle, or on one further along x,
        (held, loaded).
        """
        return np.concatenate([self._between(each, loaded, ahead) for each in self.rectangles])

    def covered(self, lattice: Grid) -> np.ndarray:
        """True for elements (n,) of a lattice that lie on held parts."""
        on = [
            covered(lattice, each.lattice, np.ones(each.lattice.shape, dtype=bool))
            for each in self.rectangles
        ]
        return np.asarray(np.any(on, axis=0).ravel())

    def follow(self, components: str) -> bool:
        """True where the forces on held parts follow tractions along some components."""
        if any(each.medium.K != 0 for each in self.bodies):
            return True
        held = {name == "z" for each in self.rectangles for name in each.components}
        return bool(held & {name == "z" for name in components})

    def _between(self, one: Rectangle, loaded: Rectangle, ahead: float) -> np.ndarray:
        """Displacements of one rectangle by forces on another one, (one, loaded)."""
        shape = len(one.components), one.lattice.size, len(loaded.components), loaded.lattice.size
        numbers = np.zeros(shape)
        yielding = self._common(one.body, loaded.body)
        names = [row + column for row in one.components for column in loaded.components]
        if yielding is not None and yielding.medium.K == 0:
            names = [name for name in names if (name[0] == "z") == (name[1] == "z")]
        if yielding is None or not names:
            return numbers.reshape(one.size, loaded.size)
        x, y = one.places
        from_x, from_y = loaded.places
        offsets = x[:, None] - from_x - ahead, y[:, None] - from_y
        found = yielding.medium.influence(loaded.lattice, *offsets, names)
        per_force = yielding.compliance / loaded.lattice.area
        for name in names:
            i = one.components.index(name[0])
            j = loaded.components.index(name[1])
            numbers[i, :, j] = found[name] * per_force
        return numbers.reshape(one.size, loaded.size)

    def _common(self, one: str, other: str) -> Yielding | None:
        """Bodies on which both rectangles act; None if there is none."""
        wanted = one if other == "both" else other
        if "both" not in (one, other) and one != other:
            return None
        return next(each for each in self.bodies if each.body == wanted)

    @lazy_property
    def stiffness(self) -> np.ndarray:
        """Forces on the held parts by their displacements, D^-1."""
        compliance = np.concatenate([self.by(each) for each in self.rectangles], axis=1)
        # parts with different sides satisfy Betti's theorem only up to their averaging
        return np.asarray(np.linalg.inv((compliance + compliance.T) / 2))


@dataclass(frozen=True)
class HeldMedium:
    """A medium whose bodies are held beside the contact."""

    medium: Medium
    held: HeldParts

    @property
    def K(self) -> float:
        """Largest size of the coupling of all deformable bodies."""
        return max((abs(each.medium.K) for each in self.held.bodies), default=0.0)

    @property
    def even(self) -> bool:
        """False: held parts are on one side."""
        return False

    @property
    def reciprocal(self) -> bool:
        return self.medium.reciprocal

    @property
    def at_once(self) -> HeldMedium:
        """Elastic bodies do not relax."""
        return self

    def at_end(self, time: float) -> HeldMedium:
        """Elastic bodies do not relax."""
        return self

    def operator(
        self, lattice: Grid, rows: str, columns: str, stencil: Stencil = HERE
    ) -> GridOperator:
        """Displacements along `rows` by tractions along `columns`, combined over a stencil."""
        free = self.medium.operator(lattice, rows, columns, stencil)
        if not (self.held.follow(rows) and self.held.follow(columns)):
            return free
        size = lattice.size
        if size > ELEMENTS_MAX:
            allowed = (
                f"at most {ELEMENTS_MAX} elements beside prescribed displacements, which take a "
                "dense matrix; give a coarser grid"
            )
            raise SceneError("grid", f"{size} elements", allowed)
        shown = Rectangle(lattice, rows, "both")
        # elements on held parts are not in contact in the end, and are not coupled to the others
        off = ~self.held.covered(lattice)
        terms = [weight * self.held.by(shown, ahead) for ahead, weight in stencil]
        loaded = self.held.by(Rectangle(lattice, columns, "both")) * lattice.area
        eliminated = np.sum(terms, axis=0).T @ (self.held.stiffness @ loaded)
        every = np.arange(size)
        numbers = free.dense(every).reshape(len(rows), size, len(columns), size)
        apart = eliminated.reshape(numbers.shape) * (off[:, None, None] & off)
        numbers = np.where((off[:, None] == off)[:, None], numbers - apart, 0.0)
        return ElementOperator(free.shape, free.table, numbers)


def held_parts(scene: Scene, length: float) -> HeldParts:
    """The rectangles of a scene whose displacements are prescribed, in units of a length."""
    displacements = scene.displacements or ()
    assert isinstance(scene.bodies, Bodies | BodyPair)
    depth = scene.reference_depth
    if depth is not None:
        depth = depth / length
    bodies = []
    names: list[LoadedBodies] = ["both", *{each.body for each in displacements} - {"both"}]
    for name in names:
        alone = loaded_alone(scene.bodies, name)
        medium = medium_of(alone, length, depth)
        assert isinstance(medium, Homogeneous)
        bodies.append(Yielding(name, medium, scene.bodies.combined_G / alone.combined_G))
    rectangles = [
        Rectangle(each.grid.scaled(length), each.components, each.body) for each in displacements
    ]
    return HeldParts(tuple(bodies), tuple(rectangles))


@one_blas_thread()
def holding_loads(
    scene: Scene, length: float, others: Sequence[SurfaceLoad] = ()
) -> tuple[SurfaceLoad, ...]:
    """The loads that hold the prescribed displacements of a scene, beside its loads and others.

    Parameters
    ----------
    scene : Scene
    length : float
        Unit of influence numbers [length].
    others : sequence of SurfaceLoad
        Further loads, such as the tractions of the contact.
    """
    displacements = scene.displacements
    if not displacements:
        return ()
    held = held_parts(scene, length)
    modulus = scene.bodies.combined_G
    missing = np.concatenate([each.displacement.ravel() for each in displacements]) / length
    # displacements by loads on bodies that are not held count as well
    for load in (*(scene.loads or ()), *others):
        rectangle = Rectangle(load.grid.scaled(length), COMPONENTS, load.body)
        forces = load.parts / modulus * rectangle.lattice.area
        missing = missing - held.by(rectangle) @ forces.ravel()
    forces = held.stiffness @ missing
    loads = []
    for each, rectangle in zip(displacements, held.rectangles, strict=True):
        own, forces = np.split(forces, [rectangle.size])
        parts = np.zeros((3, *rectangle.lattice.shape))
        acting = ["xyz".index(name) for name in rectangle.components]
        parts[acting] = own.reshape(len(acting), *rectangle.lattice.shape)
        parts *= modulus / rectangle.lattice.area
        load = SurfaceLoad(
            x=each.x, y=each.y, pressure=parts[2], traction=parts[:2], body=each.body
        )
        loads.append(load)
    return tuple(loads)
