"""Names of the units of a scene: for reports, files and pictures, nothing is converted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from varcontact.checks import Checked
from varcontact.errors import SceneError

LONGEST = 40
"""Longest name of a unit [characters]."""


def _name(field: str, value: Any) -> str:
    if not isinstance(value, str):
        raise SceneError(field, value, "a name, in quotes")
    if not value.isprintable() or len(value) > LONGEST:
        raise SceneError(field, value, f"printable, in {LONGEST} characters at most")
    return value


@dataclass(frozen=True, kw_only=True)
class Units(Checked, path="units", length=_name, force=_name):
    """Names of the units a scene is given in, for labels only: nothing is converted.

    Parameters
    ----------
    length, force : str
        Names of the units, such as "mm" and "N".

    Raises
    ------
    SceneError
        If one is not a printable name of 40 characters at most.

    Examples
    --------
    >>> Units(length="mm", force="N").of("pressure")
    'N/mm^2'
    >>> Units(length="mm", force="N").of("force", line=True)
    'N/mm'
    """

    length: str
    force: str

    def of(self, quantity: str, line: bool = False, shift: bool = False) -> str:
        """Unit of a `quantity`, without brackets; in `line` contact forces and moments are per unit
        length.

        Quantities are "length", "force", "pressure", "moment", "spin", "area", "line force" (force
        per length), and "1"; and "slip", "creepage", "spin creepage", "work", "power density",
        which are others in a `shift` than in rolling.
        """
        quantity = moved(quantity, shift)
        L = self.length
        F = self.force
        names = {
            "length": L,
            "force": F,
            "pressure": f"{F}/{L}^2",
            "moment": f"{F} {L}",
            "spin": f"1/{L}",
            "area": f"{L}^2",
            "line force": f"{F}/{L}",
        }
        if line:
            names |= {"force": f"{F}/{L}", "moment": F, "area": L}
        return names.get(quantity, "1")


def moved(quantity: str, shift: bool) -> str:
    """Kind of a motion quantity, which gives its unit: per distance rolled in rolling, unchanged in
    a shift.
    """
    return IN_MOTION.get(quantity, (quantity, quantity))[shift]


IN_MOTION = {
    "slip": ("1", "length"),
    "creepage": ("1", "length"),
    "spin creepage": ("spin", "1"),
    "work": ("force", "moment"),
    "power density": ("pressure", "line force"),
}

IN_WORDS = Units(length="length", force="force")
"""Names of units in words, for scenes that name none."""
SI = Units(length="m", force="N")
MM_N = Units(length="mm", force="N")
"""Millimetres and newtons, with moduli and pressures in N/mm^2 = MPa."""


@dataclass(frozen=True)
class Scales:
    """Physical value of each dimensionless 1; the unit of modulus is the combined G."""

    length: float
    pressure: float
    modulus: float
    line: bool

    @property
    def displacement(self) -> float:
        """[length]"""
        return self.pressure * self.length / self.modulus

    @property
    def force(self) -> float:
        """[force]; in line contact [force/length]."""
        if self.line:
            return self.pressure * self.length
        return self.pressure * self.length**2
