"""Ways to answer a scene: a rule for the grid or an accuracy, options of the
solver, extrapolation from two grids.

A method is exact for its grid; a way is what an accuracy against the continuum
belongs to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.results.history import History
from varcontact.results.quantities_of_interest import steps_that_count, values
from varcontact.results.solution import Solution
from varcontact.scene.bodies import Bodies
from varcontact.scene.consistency import why_centres
from varcontact.scene.grid import Edge, Grid, Tractions
from varcontact.scene.motion import Steady
from varcontact.scene.scene import Scene
from varcontact.scene.transient import Transient
from varcontact.solving.solve import solve

STRIPS = 4
"""Elements along x in line contact for each of `cells`: there they cost next to nothing, as in
``grid="auto"``."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """One way to answer any scene that it serves.

    Parameters
    ----------
    cells : int
        Elements across the contact along y, and along x unless `along` says
        otherwise; in line contact `STRIPS` times as many along x. 0: the grid
        is found for an `accuracy`.
    along : float
        Elements along x by those along y, except in line contact.
    edge, tractions : str
        As of `Grid`.
    coarser : int
        Elements across of a second, coarser grid, from which the values are
        extrapolated; 0: they are not.
    order : float
        Order of the error, for the extrapolation.
    motion : tuple of (str, value)
        Entries of `Steady` that differ from the scene's, as
        ``(("spin_offset", 0.0),)``; other motions do not have them.
    options : tuple of (str, value)
        Arguments of `solve`, as ``(("tangential", "fastsim"),)``.
    accuracy : float, optional
        In place of `cells` and what else belongs to a grid: the argument of
        `solve`.

    Raises
    ------
    SceneError
        For numbers that are not positive, a second grid that is not coarser, an
        accuracy beside a grid, and options that are no pairs of names and
        values.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=1.0, nu=0.3), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0,
    ...     friction=0.3, motion=vc.Steady(vx=0.1))
    >>> way = Way(cells=16, edge="touched", coarser=8)
    >>> print(way, f"{answer(scene, way).values['Fx'] / 0.3:.3f}")
    touched 8 + 16 -0.880
    >>> way = Way(accuracy=0.003)
    >>> print(way, f"{answer(scene, way).values['Fx'] / 0.3:.2f}")
    accuracy 0.003 -0.88
    """

    cells: int = 0
    along: float = 1.0
    edge: Edge = "centres"
    tractions: Tractions = "constant"
    coarser: int = 0
    order: float = 1.0
    motion: tuple[tuple[str, Any], ...] = ()
    options: tuple[tuple[str, Any], ...] = ()
    accuracy: float | None = None

    def __post_init__(self) -> None:
        _check_pairs("motion", self.motion, '(("spin_offset", 0.0),)')
        _check_pairs("options", self.options, '(("tangential", "fastsim"),)')
        for name, _ in self.options:
            if name in ("accuracy", "time_budget"):
                raise SceneError("options", name, "left out: give it as the accuracy of the way")
        if self.accuracy is not None:
            checks.positive("accuracy", self.accuracy)
            of_a_grid = {each.name for each in fields(self)} - {"accuracy", "options"}
            if any(getattr(self, name) != getattr(Way, name) for name in of_a_grid):
                allowed = "the only choice of a grid: leave out what else describes one"
                raise SceneError("accuracy", self.accuracy, allowed)
            return
        checks.whole("cells", self.cells)
        checks.whole("coarser", self.coarser, least=0)
        checks.positive("along", self.along)
        checks.positive("order", self.order)
        if self.coarser >= self.cells:
            raise SceneError("coarser", self.coarser, f"fewer elements than cells = {self.cells}")

    @property
    def family(self) -> str:
        """Name of the family: the same for the same method on other grids."""
        parts = []
        for name, value in (*self.motion, *self.options):
            if isinstance(value, str):
                parts.append(value)
            elif value is not None:
                parts.append(f"{name} = {value}")
        if self.accuracy is not None:
            return ", ".join(["accuracy", *parts])
        if "tangential" not in dict(self.options):
            parts.insert(0, self.edge)
        if self.tractions != "constant":
            parts.append(self.tractions)
        if self.coarser:
            parts.append(f"extrapolated{self._by_order}")
        if self.along != 1.0:
            parts.append(f"{self.along:g} times as many along x")
        return ", ".join(parts)

    def __str__(self) -> str:
        if self.accuracy is not None:
            return f"{self.family} {self.accuracy:g}"
        cells = f"{self.cells}"
        if self.coarser:
            cells = f"{self.coarser} + {self.cells}"
        name = self.family.replace(f", extrapolated{self._by_order}", "")
        return f"{name} {cells}{self._by_order}"

    @property
    def _by_order(self) -> str:
        if not self.coarser or self.order == 1.0:
            return ""
        return f" by order {self.order:g}"

    def of(self, scene: Scene, cells: int) -> Scene:
        """The scene on the way's grid with a number of elements across; as it
        is, where there is an accuracy.

        Parameters
        ----------
        scene : Scene
        cells : int
        """
        if self.accuracy is not None:
            return scene
        margin = scene.own_grid.margin
        if scene.line:
            strips = STRIPS * cells
            grid = Grid(nx=strips, margin=margin, edge=self.edge, tractions=self.tractions)
        else:
            along = max(2, round(self.along * cells))
            grid = Grid(nx=along, ny=cells, margin=margin, edge=self.edge)
        motion = scene.motion
        if isinstance(motion, Steady):
            motion = replace(motion, **dict(self.motion))
        return replace(scene, grid=grid, motion=motion)

    def _why_not_grid(self, scene: Scene) -> str:
        """Reason why the elements are not suitable for a scene; empty where they are."""
        if self.edge != "centres" and why_centres(scene):
            return f"the edge {self.edge!r} {why_centres(scene)}"
        half_spaces = isinstance(scene.bodies, Bodies)
        if self.tractions != "constant" and not (scene.line and half_spaces):
            return "linear tractions are for line contact of half-spaces"
        if self.edge == "softened" and isinstance(scene.motion, Transient):
            return "the edge 'softened' is for steady rolling and shifts"
        return ""

    def why_not(self, scene: Scene) -> str:
        """Reason why it is not suitable for a scene; empty where it is, as far as known before
        solving.

        Parameters
        ----------
        scene : Scene
        """
        why = self._why_not_grid(scene)
        if why:
            return why
        tangential = self.edge != "centres" or "tangential" in dict(self.options)
        if scene.frictionless and (tangential or self.motion):
            return "nothing rubs: the same as with elements by their centres"
        if self.motion and not isinstance(scene.motion, Steady):
            return f"{self.motion[0][0]} is for steady rolling"
        return ""


def _check_pairs(field: str, pairs: object, example: str) -> None:
    """Refuse anything but a tuple of pairs of a name and a value."""
    if not isinstance(pairs, tuple) or not all(map(_is_pair, pairs)):
        raise SceneError(field, pairs, f"pairs of a name and a value, as {example}")


def _is_pair(entry: object) -> bool:
    return isinstance(entry, tuple) and len(entry) == 2 and isinstance(entry[0], str)


@dataclass(frozen=True, eq=False)
class Answered:
    """Values and solutions of a way."""

    # as `varcontact.results.quantities_of_interest.values` names them; extrapolated, if the way
    # does so
    values: dict[str, float]
    solutions: tuple[Solution | History, ...]  # from coarse to fine: one, or two


def answer(
    scene: Scene, way: Way, *, steps: Sequence[int] | None = None, **options: Any
) -> Answered:
    """Answer a scene.

    Parameters
    ----------
    scene : Scene
        Its grid is replaced, but for the margin; where the way is an accuracy,
        it has none of its own.
    way : Way
    steps : sequence of int, optional
        Steps of a history that count, from 0; by default all.
    **options
        More arguments of `solve`, as ``certify=None``; those of the way come
        first.

    Returns
    -------
    Answered

    Raises
    ------
    SceneError
        If the way is not for the scene, or the history has no such step; and
        all that `solve` raises.
    """
    reason = way.why_not(scene)
    if reason:
        raise SceneError(
            "way", str(way), "one that serves the scene", message=f"way {way}: {reason}"
        )
    if isinstance(scene.motion, Transient):
        steps_that_count(scene.motion.steps, steps)
    cells = [way.coarser, way.cells] if way.coarser else [way.cells]
    given = {**options, **dict(way.options)}
    if way.accuracy is not None:
        given["accuracy"] = way.accuracy
    solutions = tuple(solve(way.of(scene, n), **given) for n in cells)
    return Answered(extrapolated(way, [values(each, steps) for each in solutions]), solutions)


def extrapolated(way: Way, found: Sequence[dict[str, float]]) -> dict[str, float]:
    """The values of a way from those on its grids, with an error ``C h^order`` taken off where
    there are two.
    """
    fine = found[-1]
    if len(found) == 1:
        return dict(fine)
    part = 1 / ((way.cells / way.coarser) ** way.order - 1)
    return {name: value + part * (value - found[0][name]) for name, value in fine.items()}
