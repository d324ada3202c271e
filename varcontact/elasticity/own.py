"""Bodies defined by the user: compliances by wave number, influence numbers, or matrices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from varcontact import checks
from varcontact.checks import Checked, positive
from varcontact.elasticity.anisotropic import (
    FLIP,
    compliance,
    mirrored_stiffness,
    stiffness_tensor,
)
from varcontact.elasticity.fourier_symbol import FourierSymbol
from varcontact.elasticity.given_numbers import (
    SYMMETRIC_MATRIX,
    KernelMedium,
    MatrixMedium,
    asymmetry,
    check_by_place,
    check_of_matrix,
    check_own_grid,
    checked_kernel,
    checked_matrix,
    half_spaces_of,
    lattice_order,
)
from varcontact.elasticity.operators import SAME_NUMBERS
from varcontact.errors import PlausibilityWarning, SceneError, warn
from varcontact.scene.bodies import RIGID, Bodies
from varcontact.scene.given_bodies import GivenBodies, Numbers
from varcontact.scene.grid import Grid
from varcontact.system.process import lazy_property

if TYPE_CHECKING:
    from varcontact.scene.scene import Scene

Compliances = Callable[[np.ndarray, np.ndarray], Any]


def _components(field: str, value: Any) -> str:
    return checks.choice(field, value, ("xyz", "z"))


@dataclass(frozen=True)
class Elasticity(Checked, GivenBodies, path="bodies", scale=positive, components=_components):
    """Both bodies of a scene by their compliance: exactly one of `symbol`, `kernel` and `matrix`.

    Displacements are differences, upper minus lower, z points into the upper
    body, and tractions act on it.

    Parameters
    ----------
    symbol : callable
        ``symbol(kx, ky)``, wave numbers (n,) to compliances (n, 3, 3): a field
        of tractions q exp(i k.x) has the displacement ``symbol q``
        [length/stress]. Hermitian, positive definite, and the conjugate of
        itself at -k. It is sampled once, and fitted: harmonics of the
        direction, and poles over the wave number.
    scale : float, optional
        Typical thickness or depth of the bodies, with a symbol [length]; wave
        numbers from 1e-4 to 1e4 divided by it are sampled. Where the symbol is
        a power of the wave number, as of half-spaces, there is none, and 1
        serves.
    local : sequence of 3 floats, optional
        Compliances of springs along x, y and z in a symbol, which act at their
        own place, in the symbol [length/stress]: the rest falls like 1/k.
    kernel : array_like, shape (3, 3, 2 ny - 1, 2 nx - 1) or (3, 3, ny, ny, 2 nx - 1)
        Influence numbers: displacement along i (x, y, z) at the centre of an
        element by a unit traction along j on another one, by the offset of the
        elements, field minus loaded, from ``-(n - 1)`` to ``n - 1``
        [length/stress]. Or by the row of the displaced element, the row of the
        loaded one, and their offset along x: bodies that are the same all along
        x, as rails are. In line contact ny = 1. Steady rolling needs ``nx``
        larger than that of the grid by the columns of a step.
    matrix : array_like, shape (3 n, 3 n), or a pair of them
        A, or (A, C): displacements of all n elements, row by row, by tractions
        on all of them; all along x come first, then y, then z [length/stress].
        C, for steady rolling, has them at the points that the particles come
        from.
    sides : (dx, dy), or (dx,) in line contact
        Sides of the elements of a kernel or matrix [length].
    components : {"xyz", "z"}
        Components of a kernel or matrix: all, or for scenes without a motion normal
        displacements by pressures alone, with one component in place of three.

    Raises
    ------
    SceneError
        For a symbol that is not finite, Hermitian, positive definite or the
        conjugate of itself at -k, that grows faster than 1/k towards zero, does
        not fall like 1/k, depends on the order of calls, has a wrong shape or
        no fit, with the wave number of the worst entry; for a kernel of a wrong
        shape or without Betti's symmetry, with its worst entry; for matrices
        that do not fit.

    Notes
    -----
    Certificates hold for the influence numbers that are given, or that a fit has; that they are
    those of the body, no certificate knows. A matrix that is not symmetric is solved as it is, with
    a `PlausibilityWarning`: bounds on pressures are not claimed then.

    Examples
    --------
    Half-spaces of G = 1, nu = 0.3, as a symbol:

    >>> import varcontact as vc
    >>> def half_spaces(kx, ky):
    ...     k, nu, G = np.hypot(kx, ky), 0.3, 1.0
    ...     f = np.zeros((k.size, 3, 3))
    ...     f[:, 0, 0] = 2 / (G * k) * (1 - nu * kx**2 / k**2)
    ...     f[:, 1, 1] = 2 / (G * k) * (1 - nu * ky**2 / k**2)
    ...     f[:, 0, 1] = f[:, 1, 0] = -2 * nu / (G * k) * kx * ky / k**2
    ...     f[:, 2, 2] = 2 * (1 - nu) / (G * k)
    ...     return f
    >>> bodies = vc.Elasticity(symbol=half_spaces)
    >>> round(bodies.combined_G, 12), round(bodies.combined_nu, 12), bodies.coupled
    (1.0, 0.3, False)
    """

    _: KW_ONLY
    symbol: Compliances | FourierSymbol | None = None
    scale: float = 1.0
    local: tuple[float, float, float] = (0.0, 0.0, 0.0)
    kernel: Any = None
    matrix: Any = None
    sides: tuple[float, ...] | None = None
    components: str = "xyz"

    def __post_init__(self) -> None:
        super().__post_init__()
        given = {"symbol": self.symbol, "kernel": self.kernel, "matrix": self.matrix}
        checks.exactly_one(**{f"bodies.{name}": value for name, value in given.items()})
        set_ = object.__setattr__
        set_(self, "local", _checked_local(self.local))
        if self.symbol is not None:
            checks.gone("bodies.sides", self.sides, "the sides of the grid")
            set_(self, "symbol", _checked_symbol(self.symbol, self.scale, self.local))
            return
        set_(self, "sides", _checked_sides(self.sides))
        if self.kernel is not None:
            set_(self, "kernel", checked_kernel(self.kernel, self.components))
        else:
            set_(self, "matrix", checked_matrix(self.matrix, self.components))
            self._warn_of_asymmetry()

    def _warn_of_asymmetry(self) -> None:
        off, place = asymmetry(self.matrix[0].array)
        if off > SYMMETRIC_MATRIX:
            message = (
                f"bodies.matrix is not symmetric: off by {off:.3g} of its largest number at "
                f"{list(place)}. By Betti's theorem elastic bodies are; bounds on pressures are "
                "not claimed, and nothing proves that there is one solution"
            )
            warn(message, PlausibilityWarning)

    @classmethod
    @checks.named_options()
    def of_stiffness(cls, upper: Any, lower: Any) -> Elasticity:
        """Half-spaces of anisotropic solids.

        Parameters
        ----------
        upper, lower : array_like, shape (6, 6), or "rigid"
            Stiffness in Voigt's order xx, yy, zz, yz, xz, xy, in the axes of
            the scene [stress]: `cubic_stiffness`,
            `transversely_isotropic_stiffness` and `rotated_stiffness` make
            them.

        Returns
        -------
        Elasticity

        Raises
        ------
        SceneError
            For a stiffness that is not symmetric and positive definite, or two
            rigid bodies.

        Examples
        --------
        The indentation modulus of isotropic solids is ``2 G/(1 - nu)``:

        >>> import varcontact as vc
        >>> from varcontact.elasticity.anisotropic import cubic_stiffness
        >>> steel = vc.Elasticity.of_stiffness(cubic_stiffness(3.5, 1.5, 1.0), "rigid")
        >>> print(f"{steel.indentation_modulus:.6f} {2 / (1 - 0.3):.6f}")
        2.857143 2.857143
        """
        given = {"upper": upper, "lower": lower}
        tensors = {
            side: stiffness_tensor(f"bodies.{side}", value)
            for side, value in given.items()
            if not (isinstance(value, str) and value == RIGID)
        }
        if not tensors:
            raise SceneError("bodies", (RIGID, RIGID), "one body at least that is elastic")
        if "lower" in tensors:
            tensors["lower"] = mirrored_stiffness(tensors["lower"])

        def by_direction(theta: np.ndarray) -> np.ndarray:
            F = np.zeros((theta.size, 3, 3), complex)
            if "upper" in tensors:
                F += compliance(tensors["upper"], theta)
            if "lower" in tensors:
                F += FLIP @ compliance(tensors["lower"], theta) @ FLIP
            return F

        return cls(symbol=FourierSymbol.of_half_spaces(by_direction))

    @classmethod
    @checks.named_options()
    def from_compliance(cls, nodes: Any, matrix: Any) -> Elasticity:
        """The compliance of finite elements, or of another program, on a lattice.

        Parameters
        ----------
        nodes : array_like, shape (n,) or (n, 2)
            Centres of the elements: x in line contact, or (x, y); those of a
            full lattice, in any order [length].
        matrix : array_like, shape (n, n) or (3 n, 3 n)
            Displacements of the elements, upper minus lower body, by unit
            pressures on each; or along x, y and z by tractions along them, all
            elements of a component together [length/stress].

        Returns
        -------
        Elasticity
            With the elements row by row, as a grid has them.

        Raises
        ------
        SceneError
            For nodes that are no lattice, and as `Elasticity`.

        Examples
        --------
        >>> import varcontact as vc
        >>> bodies = vc.Elasticity.from_compliance([0.2, 0.0, 0.1], np.eye(3) + 0.5)
        >>> print([round(side, 12) for side in bodies.sides], bodies.components)
        [0.1] z
        """
        order, sides = lattice_order(checks.array("nodes", nodes, 1, 2))
        n = order.size
        compliance = checks.array("matrix", matrix, 2)
        if compliance.shape == (n, n):
            every = order
            components = "z"
        elif compliance.shape == (3 * n, 3 * n):
            every = np.concatenate([order, order + n, order + 2 * n])
            components = "xyz"
        else:
            allowed = f"(n, n) or (3 n, 3 n), of n = {n} nodes"
            raise checks.wrong_shape("matrix", compliance.shape, allowed)
        return cls(matrix=compliance[np.ix_(every, every)], sides=sides, components=components)

    @property
    def _fitted(self) -> FourierSymbol:
        assert isinstance(self.symbol, FourierSymbol)
        return self.symbol

    @property
    def _blocks(self) -> np.ndarray:
        """Numbers (c, c, ...) between components."""
        if self.kernel is not None:
            kernel: np.ndarray = self.kernel.array
            return kernel
        matrix = self.matrix[0].array
        c = len(self.components)
        return np.asarray(matrix.reshape(c, matrix.shape[0] // c, c, -1).swapaxes(1, 2))

    @lazy_property
    def _equivalent(self) -> tuple[float, float]:
        """G and nu of isotropic half-spaces with the same compliance at short distances."""
        if self.symbol is not None:
            return self._fitted.equivalent
        assert self.sides is not None
        if self.kernel is not None:
            table = self.kernel.array
            if table.ndim == 5:
                # the mean over all rows
                middle = np.diagonal(table, axis1=2, axis2=3).mean(axis=-1)
            else:
                middle = table[:, :, table.shape[2] // 2]
            column = table.shape[-1] // 2
            own = np.diagonal(middle[:, :, column])
            beside = np.diagonal(middle[:, :, column + 1])
        else:
            blocks = self._blocks
            each = range(len(blocks))
            own = np.array([np.diagonal(blocks[i, i]).mean() for i in each])
            beside = np.array([np.diagonal(blocks[i, i], 1).mean() for i in each])
        if len(self.sides) == 1:
            own = own - beside
        return half_spaces_of(own, self.sides)

    @property
    def combined_G(self) -> float:
        """Modulus of rigidity of isotropic half-spaces with the same compliance: on average to
        short waves, or of an element to its own tractions [stress].
        """
        return self._equivalent[0]

    @property
    def combined_nu(self) -> float:
        """Poisson's ratio of these half-spaces."""
        return self._equivalent[1]

    @lazy_property
    def K(self) -> float:
        """Size of the coupling of pressure and tractions; 0: independent.

        Of a symbol the largest harmonic of its compliance times `combined_G`, of numbers the
        largest by the largest of pressures.
        """
        if self.symbol is not None:
            return self._fitted.coupling
        if self.components == "z":
            return 0.0
        blocks = self._blocks
        largest = float(np.abs(blocks[2, 2]).max())
        coupling = max(float(np.abs(blocks[:2, 2]).max()), float(np.abs(blocks[2, :2]).max()))
        if coupling < SAME_NUMBERS * largest:
            return 0.0
        return coupling / largest

    @property
    def grounded(self) -> bool:
        """True for influence numbers, whose displacements are absolute, and for symbols of bodies
        on fixed bases; with other symbols displacements count from a depth in line contact.
        """
        return self.symbol is None or self._fitted.at_rest

    @property
    def by_place(self) -> bool:
        """True of a matrix, and of a kernel by rows."""
        return self.matrix is not None or (self.kernel is not None and self.kernel.array.ndim == 5)

    @property
    def indentation_modulus(self) -> float:
        """The modulus ``2/F``, F the mean of k times the compliance of pressures, of short waves
        over all directions [stress]: of an elastic half-space on a rigid body Willis's indentation
        modulus of circular contacts. Of a kernel or matrix that of equivalent half-spaces.
        """
        if self.symbol is not None:
            return 2 / float(self._fitted.harmonics[0, 2, 2].real)
        return self.combined_G / (1 - self.combined_nu)

    @property
    def softest(self) -> Bodies:
        """Half-spaces at least as compliant under pressure."""
        return Bodies(G=2 / self._fitted.largest_normal, nu=0.0)

    def check(self, scene: Scene) -> None:
        """Refuse a `scene` whose grid, surface or motion these bodies have no numbers for."""
        if self.symbol is not None:
            if scene.periodic:
                self._check_periodic()
            return
        if scene.periodic:
            raise SceneError("grid.periodic", "given", "False with a kernel or matrix of numbers")
        assert self.sides is not None
        check_own_grid(scene, self.sides)
        if self.components == "z" and scene.motion is not None:
            allowed = '"xyz" where there is a motion: tractions need their own numbers'
            raise SceneError("bodies.components", "z", allowed)
        if self.matrix is not None:
            n = self.matrix[0].array.shape[0] // len(self.components)
            check_of_matrix(scene, self.matrix, n)
        elif self.by_place:
            check_by_place(scene, "bodies.kernel", f"of {self.kernel.array.shape[2]} rows")

    def _check_periodic(self) -> None:
        """Symbols that are not defined at the longest waves, or act at their own place."""
        if any(self._fitted.local) or self._fitted.degree != 0:
            value = f"local = {self._fitted.local}, degree {self._fitted.degree:g}"
            raise SceneError("bodies.symbol", value, "without springs and powers of k on a period")

    def reaches(self, grid: Grid) -> bool:
        """True where there are numbers for a `grid`, and places beyond the scene's own."""
        if self.symbol is not None:
            return True
        if self.by_place:
            return False
        rows, columns = self.kernel.array.shape[2:]
        return 2 * grid.rows - 1 <= rows and 2 * grid.nx - 1 <= columns

    def medium(self, length: float, depth: float) -> Any:
        """The medium in units of a `length`; in line contact displacements count from a `depth`."""
        G = self.combined_G
        if self.symbol is not None:
            from varcontact.elasticity.symbol_medium import SymbolMedium

            return SymbolMedium(self._fitted.scaled(G, length), depth)
        factor = G / length
        if self.kernel is not None:
            assert self.sides is not None
            kernel = Numbers.of(self.kernel.array * factor)
            sides = tuple(each / length for each in self.sides)
            return KernelMedium(kernel, self.components, sides, self.K)
        matrices = [Numbers.of(each.array * factor) for each in self.matrix]
        off, _ = asymmetry(self.matrix[0].array)
        reciprocal = off <= SYMMETRIC_MATRIX
        return MatrixMedium(tuple(matrices), self.components, self.K, reciprocal)


def _checked_local(local: Any) -> tuple[float, ...]:
    values = checks.array("bodies.local", local, shape=(3,)).tolist()
    return tuple(checks.at_least_zero(f"bodies.local[{i}]", each) for i, each in enumerate(values))


def _checked_symbol(symbol: Any, scale: float, local: tuple[float, float, float]) -> FourierSymbol:
    if isinstance(symbol, FourierSymbol):
        return symbol
    if not callable(symbol):
        raise SceneError("bodies.symbol", symbol, "a function of wave numbers (kx, ky)")
    return FourierSymbol.of(symbol, scale, local)


def _checked_sides(sides: Any) -> tuple[float, ...]:
    allowed = "(dx, dy), or (dx,) in line contact"
    if sides is None:
        raise SceneError("bodies.sides", None, f"given: {allowed}, of a kernel or matrix")
    if not checks.is_array(sides) or len(sides) not in (1, 2):
        raise SceneError("bodies.sides", sides, allowed)
    return tuple(positive(f"bodies.sides[{k}]", each) for k, each in enumerate(sides))
