"""Influence numbers of the elastic half-space: displacement difference by a
uniform traction on a rectangle.

The integrals of Boussinesq and Cerruti (217) over a rectangle have closed forms
(219)-(224) as corner differences. Far from the element these cancel: at a
distance of 10^4 elements the textbook forms lose all but five digits. They are
derivatives of the potentials of `varcontact.elasticity.potentials` at the
surface, where nothing cancels.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from varcontact.elasticity.operators import Homogeneous
from varcontact.elasticity.potentials import (
    KINDS,
    rectangle_potentials,
    strip_potentials,
    triangle_potentials,
)
from varcontact.scene.grid import Grid


def influence_numbers(
    x: np.ndarray,
    y: np.ndarray | float,
    dx: float,
    dy: float,
    *,
    nu: float,
    K: float = 0.0,
    G: float = 1.0,
    depth: float = 1.0,
    components: Iterable[str] = ("xx", "xy", "yy", "zz"),
) -> dict[str, np.ndarray]:
    """Influence numbers B_ij of a rectangle, (219)-(224) with the signs of (217).

    Parameters
    ----------
    x, y : array_like
        Field point minus element centre [length]; broadcast together.
    dx, dy : float
        Sides of the element [length]; dy may be infinite: a strip.
    nu, K, G : float
        Combined constants (58)-(60).
    depth : float
        Depth of a strip: the distance at which displacements along the traction are
        zero [length].
    components : iterable of str
        Which of the nine: "xz" is the displacement difference along x by a unit
        pressure.

    Returns
    -------
    dict
        Component to array of the broadcast shape [length/(force/area)].

    Notes
    -----
    With ``J2 = [[x^2/R^3]]`` (the integral over the element of x^2/R^3, and so on), ``J4 =
    [[y^2/R^3]]``, ``J1 = J2 + J4``, ``J3 = [[x y/R^3]]``, ``J5 = [[x/R^2]]``, ``J6 = [[y/R^2]]``:
    ``pi G B`` is ``J1 - nu J4`` (xx), ``J1 - nu J2`` (yy), ``nu J3`` (xy, yx), ``(1 - nu) J1``
    (zz), ``-K J5`` (xz), ``K J5`` (zx), ``-K J6`` (yz), ``K J6`` (zy). J4, J2 and J3 are
    ``-omega_xx``, ``-omega_yy`` and ``omega_xy`` of `rectangle_potentials`, J5 and J6 are ``chi_x``
    and ``chi_y``.

    Examples
    --------
    At the centre of a unit square, a unit pressure: ``(1 - nu)/(pi G) 4 asinh(1)``.

    >>> B = influence_numbers(0.0, 0.0, 1.0, 1.0, nu=0.3, components=["zz"])
    >>> print(f"{B['zz'] * np.pi / 0.7 / 4:.6f} {np.arcsinh(1):.6f}")
    0.881374 0.881374
    """
    forms = _forms(nu, K, components)
    kinds = sorted({kind for form in forms.values() for kind in form})
    if math.isinf(dy):
        potentials = strip_potentials(x, 0.0, dx, depth)[[KINDS.index(kind) for kind in kinds]]
    else:
        potentials = rectangle_potentials(x, y, 0.0, dx, dy, kinds)
    return _combined(forms, dict(zip(kinds, potentials / (np.pi * G), strict=True)))


def _forms(nu: float, K: float, components: Iterable[str]) -> dict[str, dict[str, float]]:
    """Influence numbers by the potentials, times pi G."""
    forms = {
        "xx": {"omega_xx": nu - 1, "omega_yy": -1},
        "yy": {"omega_xx": -1, "omega_yy": nu - 1},
        "zz": {"omega_xx": nu - 1, "omega_yy": nu - 1},
        "xy": {"omega_xy": nu},
        "yx": {"omega_xy": nu},
        "xz": {"chi_x": -K},
        "zx": {"chi_x": K},
        "yz": {"chi_y": -K},
        "zy": {"chi_y": K},
    }
    return {name: forms[name] for name in components}


def _combined(
    forms: dict[str, dict[str, float]], potentials: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Influence numbers from potentials by their kind."""
    return {
        name: np.sum([potentials[kind] * w for kind, w in form.items()], axis=0)
        for name, form in forms.items()
    }


@dataclass(frozen=True)
class HalfSpaces(Homogeneous):
    """Two homogeneous, isotropic, elastic half-spaces (paper, section 2)."""

    nu: float
    K: float = 0.0
    depth: float = 1.0

    def influence(
        self, grid: Grid, x: np.ndarray, y: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        dx, dy = grid.sides
        if grid.linear:
            return self._of_triangle(dx, x, components)
        if grid.line:
            dy = math.inf
        return influence_numbers(
            x, y, dx, dy, nu=self.nu, K=self.K, depth=self.depth, components=components
        )

    def _of_triangle(
        self, dx: float, x: np.ndarray, components: Iterable[str]
    ) -> dict[str, np.ndarray]:
        """Influence numbers of tractions that are linear between the centres of strips."""
        potentials = triangle_potentials(x, dx, self.depth)
        nothing = np.zeros(np.shape(x))
        every = dict.fromkeys(("omega_xy", "chi_y"), nothing) | potentials
        scaled = {kind: values / np.pi for kind, values in every.items()}
        return _combined(_forms(self.nu, self.K, components), scaled)
