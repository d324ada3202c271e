"""Numbers and units on the axes of pictures: prefixes by size where the units are metric, as given
where not.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from varcontact.scene.scene import Scene

_METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6}
_NEWTONS = {"N": 1.0, "kN": 1e3, "MN": 1e6}

_POWERS = {
    "length": (0, 1),
    "force": (1, 0),
    "pressure": (1, -2),
    "moment": (1, 1),
    "spin": (0, -1),
    "line force": (1, -1),
}
"""Powers of force and of length in each quantity."""

_SYMBOLS = {(0, 1): "m", (1, 0): "N", (1, -2): "Pa", (1, 1): "N m", (1, -1): "N/m"}
"""Units that take prefixes, by powers of force and length."""

_PREFIXES = {"G": 1e9, "M": 1e6, "k": 1e3, "": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9}


@dataclass(frozen=True)
class Measure:
    """A quantity as shown: its numbers times `factor` are in `unit`, empty where the scene names
    none.
    """

    factor: float
    unit: str

    def __call__(self, values: Any) -> np.ndarray:
        """The numbers to be shown of `values` in the scene's units."""
        return np.asarray(values) * self.factor

    def label(self, name: str) -> str:
        """`name` with the unit in brackets."""
        return f"{name} [{self.unit}]" if self.unit else name

    def text(self, value: float, digits: int = 3) -> str:
        """Text of a `value` in the scene's units, with a number of `digits` and its unit."""
        if self.unit.startswith("$10"):  # without its power
            return f"{value + 0.0:.{digits}g} {self.unit.partition('$ ')[2]}".rstrip()
        return f"{value * self.factor + 0.0:.{digits}g} {self.unit}".rstrip()


def measure(scene: Scene | None, quantity: str, values: Any) -> Measure:
    """Factor and unit in which values of a scene are shown: the largest has the prefix that fits.

    `quantity` is one of `_POWERS` or "1"; forces and moments of line contact are per unit length.
    Where no prefix fits, the unit has a power of a thousand.
    """
    factor = 1.0
    unit = ""
    powers = (0, 0)
    # newtons and metres, where the units are metric
    if scene is not None and scene.units is not None and quantity in _POWERS:
        units = scene.units
        force, length = _POWERS[quantity]
        if scene.line and quantity in ("force", "moment"):
            length -= 1
        unit = units.of(quantity, scene.line).replace("$", r"\$")  # a dollar sign, not a formula
        if units.length in _METRES and units.force in _NEWTONS:
            factor = _NEWTONS[units.force] ** force * _METRES[units.length] ** length
            unit = "1/m"
            powers = (force, length)
    # the prefix, or the power of a thousand, that fits the largest
    sizes = np.abs(np.asarray(values, dtype=float))
    largest = float(np.max(sizes[np.isfinite(sizes)], initial=0.0)) * factor
    symbol = _SYMBOLS.get(powers)
    if symbol is not None:
        prefix = _fitting_prefix(symbol, largest)
        factor = factor / _PREFIXES[prefix]
        unit = prefix + symbol
    elif largest > 0 and not 0.1 <= largest < 1e4:
        power = 3 * int(np.floor(np.log10(largest * 1.0005) / 3))
        factor = factor / 10.0**power
        unit = f"$10^{{{power}}}$ {unit}".rstrip()
    return Measure(float(f"{factor:.12g}"), unit)  # a power of ten without rounding errors


def _fitting_prefix(symbol: str, largest: float) -> str:
    """Largest prefix with which a value is at least one: MPa up to 10 GPa, as is usual, and no
    kilometres.
    """
    if largest == 0:
        return ""
    for prefix, size in _PREFIXES.items():
        if symbol == "m" and size > 1:
            continue
        least = 0.9995 * size
        if prefix + symbol == "GPa":
            least = 10 * least
        if largest >= least:
            return prefix
    return "n"
