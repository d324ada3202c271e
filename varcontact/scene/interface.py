"""What lies between the bodies: a layer of third-body material. It checks itself when made."""

from __future__ import annotations

import math
from dataclasses import dataclass

from varcontact import checks
from varcontact.errors import SceneError


@dataclass(frozen=True)
class ThirdBody:
    """An elastic-plastic layer between the bodies: leaves, sand, oxides, wear debris.

    It shears by ``h/G`` times the traction. From the yield stress on it flows along the traction, and hardens:
    ``tau_c = tau_c0 + k_tau u``, with the length u of the plastic displacement. Where the bodies touch, tractions are
    also within friction. Sources: Hou, Kalousek, Magel, Wear 211 (1997) 134-140; Vollebregt, Wear 314 (2014) 87-95.

    Parameters
    ----------
    h : float
        Thickness, zero or positive [length].
    G : float
        Modulus of rigidity, positive [stress].
    tau_c0 : float
        Yield stress of fresh material, positive [stress]; ``inf`` (default): elastic only.
    k_tau : float
        Hardening, [stress/length]; 0 (default): perfectly plastic; negative: softening, in histories only. From the
        stiffness k of elastic and plastic shear together it is ``k G/h / (G/h - k)``.

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
        checks.entries(self, "third_body", checks.moderate, "h", "k_tau")
        checks.entries(self, "third_body", checks.positive, "G")
        if self.h < 0:
            raise SceneError("third_body.h", self.h, "zero or positive: a thickness")
        if self.tau_c0 != math.inf:
            checks.entries(self, "third_body", checks.positive, "tau_c0")
        elif self.k_tau != 0:
            raise SceneError("third_body.k_tau", self.k_tau, "0 without a third_body.tau_c0, from which it hardens")

    @property
    def compliance(self) -> float:
        """Elastic shear displacement by traction, h/G."""
        return self.h / self.G

    @property
    def yields(self) -> bool:
        """Whether it can flow."""
        return self.tau_c0 < math.inf
