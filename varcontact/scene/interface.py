"""A layer of third-body material between the bodies. It checks itself when made."""

from __future__ import annotations

import math
from dataclasses import dataclass

from varcontact.checks import Checked, at_least_zero, number, positive, positive_or_infinite
from varcontact.errors import SceneError


@dataclass(frozen=True)
class ThirdBody(
    Checked,
    path="third_body",
    h=at_least_zero,
    k_tau=number,
    G=positive,
    tau_c0=positive_or_infinite,
):
    """An elastic-plastic layer between the bodies: leaves, sand, oxides, wear debris.

    It shears by ``h/G`` times the traction. From the yield stress on it flows
    along the traction, and hardens: ``tau_c = tau_c0 + k_tau u``, with the
    length u of the plastic displacement. Where the bodies touch, tractions are
    also within friction. Sources: Hou, Kalousek, Magel, Wear 211 (1997)
    134-140; Vollebregt, Wear 314 (2014) 87-95.

    Parameters
    ----------
    h : float
        Thickness, zero or positive [length].
    G : float
        Modulus of rigidity, positive [stress].
    tau_c0 : float
        Yield stress of fresh material, positive [stress]; ``inf`` (default):
        elastic only.
    k_tau : float
        Hardening, [stress/length]; 0 (default): perfectly plastic; negative:
        softening, in histories only. From the stiffness k of elastic and
        plastic shear together it is ``k G/h / (G/h - k)``.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> clay = ThirdBody(h=0.02, G=106.25, tau_c0=200.0, k_tau=435.0)
    >>> f"{clay.compliance:.2e} {clay.yields}"
    '1.88e-04 True'
    """

    h: float
    G: float
    tau_c0: float = math.inf
    k_tau: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.k_tau != 0 and not self.yields:
            raise SceneError(
                "third_body.k_tau",
                self.k_tau,
                "0 without a third_body.tau_c0, from which it hardens",
            )

    @property
    def compliance(self) -> float:
        """Elastic shear displacement by traction, h/G."""
        return self.h / self.G

    @property
    def yields(self) -> bool:
        """True for a layer that can flow."""
        return self.tau_c0 < math.inf


@dataclass(frozen=True)
class Thermal(
    Checked,
    path="thermal",
    conductivity=positive,
    density=positive,
    heat_capacity=positive,
    temperature=number,
):
    """Thermal data of a body, for the temperature of its surface.

    Heat is work per time, in the scene's units: only ``conductivity``
    [work/(time length temperature)] and the product ``density * heat_capacity``
    [work/(length^3 temperature)] count. For steel in N, mm and seconds 50 and
    3.53.

    Parameters
    ----------
    conductivity : float
        Positive.
    density, heat_capacity : float
        Mass per volume, and heat per mass and temperature; positive.
    temperature : float
        Before contact; 0 (default), if only the rise is asked for.

    Raises
    ------
    SceneError
        For entries out of range.

    Examples
    --------
    >>> print(f"{Thermal(conductivity=50.0, density=7.85e-9, heat_capacity=4.5e8).effusivity:.2f}")
    13.29
    """

    conductivity: float
    density: float
    heat_capacity: float
    temperature: float = 0.0

    @property
    def effusivity(self) -> float:
        """Thermal effusivity: ``sqrt(conductivity density heat_capacity)``."""
        return math.sqrt(self.conductivity * self.density * self.heat_capacity)
