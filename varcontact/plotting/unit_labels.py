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
"""What takes prefixes."""

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
        """A `value` in the scene's units as text, of so many `digits`, with its unit."""
        if self.unit.startswith("$10"):  # without its power
            return f"{value + 0.0:.{digits}g} {self.unit.partition('$ ')[2]}".rstrip()
        return f"{value * self.factor + 0.0:.{digits}g} {self.unit}".rstrip()


def measure(scene: Scene | None, quantity: str, values: Any) -> Measure:
    """How values in the units of a scene are shown: the largest has the prefix that fits.

    `quantity` is one of `_POWERS` or "1"; forces and moments of line contact are per unit length.
    Where no prefix fits, the unit has a power of a thousand.
    """
    units, line = (None, False) if scene is None else (scene.units, scene.line)
    sizes = np.abs(np.asarray(values, dtype=float))
    largest = float(np.max(sizes[np.isfinite(sizes)], initial=0.0))
    factor, unit, powers = 1.0, "", (0, 0)
    if units is not None and quantity in _POWERS:
        force, length = _POWERS[quantity]
        if line and quantity in ("force", "moment"):
            length -= 1
        unit = units.of(quantity, line).replace("$", r"\$")  # a dollar, and no formula
        if units.length in _METRES and units.force in _NEWTONS:
            factor = _NEWTONS[units.force] ** force * _METRES[units.length] ** length
            unit, powers = "1/m", (force, length)
    largest *= factor
    symbol = _SYMBOLS.get(powers)
    if symbol is not None:
        fitting = [  # MPa up to 10 GPa, as is usual, and no kilometres
            prefix
            for prefix, size in _PREFIXES.items()
            if largest >= 0.9995 * size * (10 if prefix + symbol == "GPa" else 1)
            and not (symbol == "m" and size > 1)
        ]
        prefix = "" if largest == 0 else [*fitting, "n"][0]
        factor, unit = factor / _PREFIXES[prefix], prefix + symbol
    elif largest > 0 and not 0.1 <= largest < 1e4:
        power = 3 * int(np.floor(np.log10(largest * 1.0005) / 3))
        factor, unit = factor / 10.0**power, f"$10^{{{power}}}$ {unit}".rstrip()
    return Measure(float(f"{factor:.12g}"), unit)  # a power of ten without rounding errors
