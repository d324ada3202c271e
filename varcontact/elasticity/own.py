"""Bodies of one's own: compliances by wave number, influence numbers, or matrices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any

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
from varcontact.elasticity.symbol_medium import SymbolMedium
from varcontact.errors import SceneError
from varcontact.scene.bodies import RIGID, Bodies
from varcontact.scene.given_bodies import GivenBodies
from varcontact.scene.grid import Grid

Compliances = Callable[[np.ndarray, np.ndarray], Any]


@dataclass(frozen=True)
class Elasticity(Checked, GivenBodies, path="bodies", scale=positive):
    """Both bodies of a scene by their compliance.

    Parameters
    ----------
    symbol : callable
        ``symbol(kx, ky)``, wave numbers (n,) to compliances (n, 3, 3): a field
        of tractions q exp(i k.x) on the upper body has the displacement
        difference, upper minus lower, ``symbol q``, z into the upper body
        [length/stress]. Hermitian, positive definite, and the conjugate of
        itself at -k. It is sampled once, and fitted: harmonics of the
        direction, and poles over the wave number.
    scale : float, optional
        A typical thickness or depth of the bodies [length]: wave numbers from
        1e-4 to 1e4 divided by it are sampled. Where the symbol is a power of
        the wave number, as of half-spaces, there is none, and 1 serves.
    local : sequence of 3 floats, optional
        Compliances of springs along x, y and z, which act at their own place,
        in the symbol [length/stress]: the rest falls like 1/k.

    Raises
    ------
    SceneError
        For a symbol that is not finite, Hermitian, positive definite or the
        conjugate of itself at -k, that grows faster than 1/k towards zero, does
        not fall like 1/k, depends on the order of calls, has a wrong shape or
        no fit, with the wave number of the worst entry.

    Notes
    -----
    Certificates hold for the influence numbers that a fit has; that it is the body, no certificate
    knows.

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
    symbol: Compliances | FourierSymbol
    scale: float = 1.0
    local: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        super().__post_init__()
        local = checks.array("bodies.local", self.local, shape=(3,))
        for i, each in enumerate(local.tolist()):
            checks.at_least_zero(f"bodies.local[{i}]", each)
        object.__setattr__(self, "local", tuple(local.tolist()))
        symbol = self.symbol
        if isinstance(symbol, FourierSymbol):
            return
        if not callable(symbol):
            raise SceneError("bodies.symbol", symbol, "a function of wave numbers (kx, ky)")
        object.__setattr__(self, "symbol", FourierSymbol.of(symbol, self.scale, self.local))

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

    @property
    def _fitted(self) -> FourierSymbol:
        assert isinstance(self.symbol, FourierSymbol)
        return self.symbol

    @property
    def combined_G(self) -> float:
        """Modulus of rigidity of isotropic half-spaces with the same mean compliance of short
        waves [stress].
        """
        return self._fitted.equivalent[0]

    @property
    def combined_nu(self) -> float:
        """Poisson's ratio of these half-spaces."""
        return self._fitted.equivalent[1]

    @property
    def K(self) -> float:
        """Largest harmonic of the compliance between pressure and tractions, times `combined_G`; 0:
        independent.
        """
        return self._fitted.coupling

    @property
    def indentation_modulus(self) -> float:
        """The modulus ``2/F``, F the mean of k times the compliance of pressures, of short waves
        over all directions [stress]: of an elastic half-space on a rigid body Willis's indentation
        modulus of circular contacts.
        """
        return 2 / float(self._fitted.harmonics[0, 2, 2].real)

    @property
    def softest(self) -> Bodies:
        """Half-spaces that give way at least as much under pressure."""
        return Bodies(G=2 / self._fitted.largest_normal, nu=0.0)

    def check_grid(self, grid: Grid | str, line: bool) -> None:
        """Refuse a `grid` without influence numbers; in `line` contact only symbols of half-spaces
        have them.
        """
        symbol = self._fitted
        if line and not (symbol.homogeneous and symbol.degree == 0):
            allowed = "of half-spaces, with k times the compliance the same at all k"
            raise SceneError(
                "bodies.symbol",
                "a symbol",
                message=f"bodies.symbol in line contact must be {allowed}",
            )

    def medium(self, length: float, depth: float) -> SymbolMedium:
        """The medium in units of a `length`; in line contact displacements count from a `depth`."""
        return SymbolMedium(self._fitted.scaled(self.combined_G, length), depth)
