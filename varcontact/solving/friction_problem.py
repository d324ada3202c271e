"""Pressure and Coulomb's friction together, as FCLIB's local problem: no convex program.

Source: V. Acary et al., "FCLIB: a collection of discrete 3D frictional contact problems", INRIA
technical report 444 (2014), and its header `fclib.h`.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from varcontact import checks
from varcontact.discrete.contact_grid import PotentialContact, no_element_in_contact
from varcontact.discrete.discretisation import Discretisation, discretise
from varcontact.discrete.stick_slip import unit_slip
from varcontact.errors import SceneError
from varcontact.results.solution import Solution
from varcontact.scene.consistency import check_force_is_sum, flow_refused
from varcontact.scene.motion import Shift, Steady
from varcontact.scene.scene import Scene
from varcontact.solving.given_pressure import check_placed
from varcontact.system.files import check_replaceable, write_whole
from varcontact.system.process import need, one_blas_thread

HDF5_HEAD = rb"\x89HDF\r\n\x1a\n.*fclib_local"
"""Beginning of a file that holds a local problem."""
ENDINGS = (".hdf5", ".h5")


@dataclass(frozen=True, eq=False)
class FrictionProblem:
    """Find r with ``u = W r + V l + q``, ``V'r + s = 0``, and on each element ``r_N >= 0``,
    ``u_N >= 0``, ``r_N u_N = 0``, ``|r_T| <= mu r_N``, ``r_T = -mu r_N u_T/|u_T|`` where it slips.
    See `friction_problem`.

    Each element has `spacedim` rows: along the normal, along x and, with three, along y. All is
    dimensionless; `scales` has the units.

    Attributes
    ----------
    scene : Scene
    W : ndarray, shape (m, m)
        Influence numbers: symmetric in a shift, not in rolling.
    q : ndarray, shape (m,)
        Undeformed distances, less a prescribed approach, and rigid shifts.
    mu : ndarray, shape (n,)
        Coefficients of friction.
    V : ndarray, shape (m, k)
        A column for each prescribed force; its unknown in l is less the approach, or the unknown
        part of the rigid shift. Without prescribed forces k = 0.
    s : ndarray, shape (k,)
        Less these forces, as sums of r.
    spacedim : {3, 2}
        2 in line contact where nothing moves along y.
    elements : ndarray of int, shape (n,)
        Places ``iy * nx + ix`` of the elements on the grid.
    scales : dict of str to float
        Value of 1 in the scene's units: "traction" [force/area] of r, "shift" [length] of u.
    notes : tuple of str
        Quantities that are held fixed here, and that `solve` would determine.
    """

    scene: Scene
    W: np.ndarray
    q: np.ndarray
    mu: np.ndarray
    V: np.ndarray
    s: np.ndarray
    spacedim: int
    elements: np.ndarray
    scales: dict[str, float]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"FrictionProblem({self.mu.size} elements, {self.s.size} prescribed forces)"

    def residual(self, r: np.ndarray, l: np.ndarray | None = None) -> float:  # noqa: E741 - FCLIB's
        """Residual of the natural map, ``|r - P(r - (u + mu |u_T|)/rho)|`` with P the projection on
        the cones of friction, or the error of a prescribed force; relative to the largest r.

        Parameters
        ----------
        r : array_like, shape (m,)
        l : array_like, shape (k,), optional
            Zero if there are no prescribed forces.
        """
        forces = checks.array("r", r, shape=self.q.shape)
        unknowns = np.zeros(0)
        if self.s.size:
            unknowns = checks.array("l", l, shape=self.s.shape)
        velocity = (self.W @ forces + self.V @ unknowns + self.q).reshape(-1, self.spacedim)
        velocity[:, 0] += self.mu * np.linalg.norm(velocity[:, 1:], axis=1)
        forces = forces.reshape(-1, self.spacedim)
        own = float(np.mean(np.diagonal(self.W)))
        error = np.abs(forces - _on_cones(forces - velocity / own, self.mu)).max()
        missing = np.abs(self.V.T @ forces.ravel() + self.s).max(initial=0.0)
        return float(max(error, missing) / np.abs(forces).max())

    def variables_of(self, solution: Solution) -> tuple[np.ndarray, np.ndarray]:
        """(r, l) of a solution of the same scene on the same grid.

        Parameters
        ----------
        solution : Solution

        Returns
        -------
        r : ndarray, shape (m,)
        l : ndarray, shape (k,)

        Raises
        ------
        SceneError
            For a solution on another grid, and for one with Hertz's pressure in
            closed form, which does not satisfy the equations of the grid.
        """
        checks.kind("solution", solution, Solution)
        if solution.plan.closed_form:
            allowed = 'with a pressure of the grid\'s own equations: solve with normal="norm"'
            raise SceneError("solution", "one with Hertz's pressure in closed form", allowed)
        disc = discretise(self.scene, PotentialContact.of(self.scene).known)
        if vars(solution.grid) != vars(disc.grid):
            raise SceneError("solution", "another grid", "of the problem's own scene and grid")
        r = self._rows([solution.pressure, *solution.traction]) / self.scales["traction"]
        distance = solution.distance / self.scales["shift"]
        velocity = self._rows([distance, *solution.slip * unit_slip(disc)])
        # what the equations lack in the contact
        lacking = (velocity - self.W @ r - self.q).reshape(-1, self.spacedim)
        pressed = r[:: self.spacedim] > 0
        return r, lacking[pressed].mean(axis=0)[_prescribed(disc)]

    def _rows(self, fields: list[np.ndarray]) -> np.ndarray:
        """Fields (ny, nx) along the normal, x and y as rows of the problem."""
        flat = np.array(fields[: self.spacedim]).reshape(self.spacedim, -1)
        return flat[:, self.elements].T.ravel()

    @checks.named_options()
    def save(
        self, path: str | Path, solution: Solution | None = None, overwrite: bool = False
    ) -> None:
        """Write FCLIB's file of a local problem, whole or not at all.

        Parameters
        ----------
        path : str or Path
            With the ending ``.hdf5`` or ``.h5``.
        solution : Solution, optional
            Solution of the same scene: its u, r and l are written as FCLIB's solution.
        overwrite : bool
            Whether another file may be replaced.

        Raises
        ------
        OutputError
            For other endings, and if the file holds something else or cannot be written.
        """
        import h5py

        path = checks.file_name("path", path)
        check_replaceable("path", path, ENDINGS, "problem", HDF5_HEAD, overwrite)
        buffer = io.BytesIO()
        with h5py.File(buffer, "w") as file:
            self._write(file.create_group("fclib_local"))
            if solution is not None:
                r, unknowns = self.variables_of(solution)
                group = file.create_group("solution")
                group["u"] = self.W @ r + self.V @ unknowns + self.q
                group["r"] = r
                if unknowns.size:
                    group["l"] = unknowns
        write_whole("path", path, buffer.getvalue())

    def _write(self, group: Any) -> None:
        """The problem in the group ``fclib_local``."""
        group["spacedim"] = np.array([self.spacedim], dtype=np.int32)
        _write_matrix(group.create_group("W"), self.W)
        vectors = group.create_group("vectors")
        vectors["q"] = self.q
        vectors["mu"] = self.mu
        if self.s.size:
            _write_matrix(group.create_group("V"), self.V)
            _write_matrix(group.create_group("R"), np.zeros((self.s.size, self.s.size)))
            vectors["s"] = self.s
        symmetry = "symmetric"
        if isinstance(self.scene.motion, Steady):
            symmetry = "not symmetric (steady rolling)"
        units = (
            f"1 is a traction of {self.scales['traction']!r}, a shift of {self.scales['shift']!r}"
        )
        words = {
            "title": "rolling contact by varcontact",
            "description": "; ".join([units, *self.notes]),
            "math_info": f"W is dense and {symmetry}",
        }
        info = group.create_group("info")
        for name, text in words.items():
            info[name] = np.bytes_(text.encode())


def _write_matrix(group: Any, matrix: np.ndarray) -> None:
    """A dense matrix by compressed columns (``nz = -1``), with all its entries."""
    rows, columns = matrix.shape
    sizes = {"nzmax": matrix.size, "m": rows, "n": columns, "nz": -1}
    for name, size in sizes.items():
        group[name] = np.array([size], dtype=np.int32)
    group["p"] = np.arange(0, matrix.size + 1, rows, dtype=np.int32)
    group["i"] = np.tile(np.arange(rows, dtype=np.int32), columns)
    group["x"] = matrix.ravel(order="F")


def _on_cones(points: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Projections of points (n, spacedim) on the cones ``|r_T| <= mu r_N``."""
    size = np.linalg.norm(points[:, 1:], axis=1)
    inside = size <= mu * points[:, 0]
    polar = mu * size <= -points[:, 0]
    along = np.maximum((points[:, 0] + mu * size) / (1 + mu**2), 0.0)
    factor = mu * along / np.where(size > 0, size, 1.0)
    surface = np.column_stack([along, factor[:, None] * points[:, 1:]])
    surface[polar] = 0.0
    return np.where(inside[:, None], points, surface)


@checks.named_options()
@one_blas_thread()
def friction_problem(scene: Scene) -> FrictionProblem:
    """Pressure and friction of a scene together, as FCLIB's local problem, without solving
    anything.

    Parameters
    ----------
    scene : Scene
        In steady rolling or a shift, with an explicit grid or a Hertzian surface, whose pressure is
        then unknown like any other.

    Returns
    -------
    FrictionProblem

    Raises
    ------
    SceneError
        Without Coulomb's friction by finite coefficients (a third body that yields, a bound that is
        no coefficient times the pressure), for a history, for elements at the edge that count in
        part, and for conformal bodies under a normal force.
    TooLarge
        If the matrix would not fit into memory.

    Examples
    --------
    >>> import varcontact as vc
    >>> scene = vc.Scene(
    ...     bodies=vc.Bodies(G=(1.0, 3.0), nu=0.28), surface=vc.Paraboloids(1.0, 1.0),
    ...     normal_force=0.01, friction=0.3, motion=vc.Steady(vx=0.01),
    ...     grid=vc.Grid(nx=8, ny=8, dx=0.06, dy=0.06, x0=-0.24, y0=-0.24))
    >>> problem = vc.friction_problem(scene)
    >>> problem.residual(*problem.variables_of(vc.solve(scene))) < 1e-7
    True
    """
    checks.kind("scene", scene, Scene)
    _check_coulomb(scene)
    check_placed(scene, "for a problem without a solution")
    disc = discretise(scene, PotentialContact.of(scene).known)
    normal = disc.normal_problem()
    elements = normal.reachable().operator.elements
    if elements.size == 0:
        raise no_element_in_contact(disc.surface, disc.loading.approach, disc.grid)
    notes = []
    if disc.sought(by_slip=True):
        notes.append("the static coefficient of friction: its law depends on the slip")
    components = _components(disc)
    need("the matrix of pressure and friction", 24.0 * (components * elements.size) ** 2, "fewer")
    shift = disc.known_shift.reshape(2, -1)[: components - 1, elements]
    distance = normal.distance[elements] - (normal.approach or 0.0)
    prescribed = _prescribed(disc)
    sums = [normal.force, *disc.tangential_forces]
    coefficient = np.broadcast_to(np.asarray(disc.coefficient), disc.grid.shape)
    return FrictionProblem(
        scene=scene,
        W=_matrix(disc, elements, components),
        q=np.concatenate([distance[None], shift]).T.ravel(),
        mu=np.array(coefficient.ravel()[elements]),
        V=np.tile(np.eye(components)[:, prescribed], (elements.size, 1)),
        s=np.array([-(sums[row] or 0.0) / normal.area for row in prescribed]),
        spacedim=components,
        elements=elements,
        scales={"traction": disc.scales.pressure, "shift": disc.scales.displacement},
        notes=tuple(notes),
    )


def _check_coulomb(scene: Scene) -> None:
    """Refuse a scene without Coulomb's friction, or whose forces are no sums of tractions."""
    if not isinstance(scene.motion, Steady | Shift):
        allowed = "Steady or Shift: a step of a history has no problem without the step before"
        raise SceneError("motion", scene.motion, allowed)
    largest = scene.largest_coefficient
    if largest is None or not np.all(np.isfinite(largest)):
        allowed = "finite coefficients, or a law of them: the bound is Coulomb's, mu times r_N"
        raise SceneError("friction", scene.friction, allowed)
    if scene.flows:
        why = "a yield stress is no part of Coulomb's friction"
        raise flow_refused(scene, f"left out: {why}")
    if scene.edge != "centres":
        raise SceneError("grid.edge", scene.edge, '"centres": all elements count in full')
    check_force_is_sum(scene)


def _components(disc: Discretisation) -> int:
    """Rows of an element: 2 in line contact where nothing moves along y."""
    shift = disc.known_shift
    moves = shift[1].any() or disc.tangential_forces[1] is not None
    if disc.grid.line and not moves:
        return 2
    return 3


def _prescribed(disc: Discretisation) -> list[int]:
    """Rows of an element along which a force is prescribed."""
    forces = [disc.loading.normal_force, *disc.tangential_forces]
    return [row for row, force in enumerate(forces) if force is not None]


def _matrix(disc: Discretisation, elements: np.ndarray, components: int) -> np.ndarray:
    """The influence numbers between elements, their components beside each other."""
    n = elements.size
    matrix = np.zeros((n, components, n, components))
    tangential = disc.tangential_operator.dense(elements).reshape(2, n, 2, n)
    matrix[:, 0, :, 0] = disc.operators.normal.dense(elements)
    for i in range(components - 1):
        for j in range(components - 1):
            matrix[:, 1 + i, :, 1 + j] = tangential[i, :, j]
    if disc.K != 0:
        distances = disc.operators.traction_to_distance.dense(elements).reshape(n, 2, n)
        shifts = disc.pressure_to_shift.dense(elements).reshape(2, n, n)
        for i in range(components - 1):
            matrix[:, 0, :, 1 + i] = distances[:, i]
            matrix[:, 1 + i, :, 0] = shifts[i]
    return matrix.reshape(n * components, n * components)
