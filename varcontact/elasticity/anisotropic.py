"""Half-spaces of anisotropic solids: their compliance by the direction of the wave vector.

Sources: D. M. Barnett and J. Lothe, Physica Norvegica 7 (1973) 13-19; T. C. T. Ting,
Anisotropic Elasticity, Oxford 1996, chapter 7; for crystals J. R. Willis,
J. Mech. Phys. Solids 14 (1966) 163-176.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError

FLIP = np.diag([1.0, 1.0, -1.0])
"""Reflection in the plane z = 0, which turns a lower body into an upper one."""
ANGLES = 256
"""Angles of the means in the plane of wave vector and normal: for graphite the error is 1e-5 with
64, 1e-15 with these."""
PAIRS = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
"""Place of each pair of axes in Voigt's order."""
SYMMETRY = 1e-9
"""Departure from symmetry of a stiffness, relative to its largest entry, that counts as
rounding."""


def cubic_stiffness(c11: float, c12: float, c44: float) -> np.ndarray:
    """Stiffness of a cubic crystal, its axes along x, y and z.

    Parameters
    ----------
    c11, c12, c44 : float
        Constants [stress].

    Returns
    -------
    ndarray, shape (6, 6)
        In Voigt's order xx, yy, zz, yz, xz, xy.

    Raises
    ------
    SceneError
        For constants that are not finite numbers.

    Examples
    --------
    >>> cubic_stiffness(3.0, 1.0, 2.0)[:2, :2]
    array([[3., 1.],
           [1., 3.]])
    """
    constants = {"c11": c11, "c12": c12, "c44": c44}
    c11, c12, c44 = (checks.number(name, value) for name, value in constants.items())
    stiffness = np.diag([c11 - c12] * 3 + [c44] * 3)
    stiffness[:3, :3] += c12
    return stiffness


def transversely_isotropic_stiffness(
    c11: float, c12: float, c13: float, c33: float, c44: float
) -> np.ndarray:
    """Stiffness of a solid that is isotropic about the z axis: hexagonal crystals, fibres along z.

    Parameters
    ----------
    c11, c12, c13, c33, c44 : float
        Constants [stress].

    Returns
    -------
    ndarray, shape (6, 6)
        In Voigt's order xx, yy, zz, yz, xz, xy.

    Raises
    ------
    SceneError
        For constants that are not finite numbers.

    Examples
    --------
    >>> zinc = transversely_isotropic_stiffness(165.0, 31.1, 50.0, 61.8, 39.6)
    >>> float(zinc[2, 2]), round(float(zinc[5, 5]), 2)
    (61.8, 66.95)
    """
    constants = {"c11": c11, "c12": c12, "c13": c13, "c33": c33, "c44": c44}
    c11, c12, c13, c33, c44 = (checks.number(name, value) for name, value in constants.items())
    stiffness = np.diag([0.0, 0.0, 0.0, c44, c44, (c11 - c12) / 2])
    stiffness[:3, :3] = [[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]]
    return stiffness


def rotated_stiffness(stiffness: Any, rotation: Any) -> np.ndarray:
    """Stiffness of a solid that is turned.

    Parameters
    ----------
    stiffness : array_like, shape (6, 6)
        In Voigt's order xx, yy, zz, yz, xz, xy [stress].
    rotation : array_like, shape (3, 3)
        Orthogonal: takes axes of the solid to those of the scene.

    Returns
    -------
    ndarray, shape (6, 6)

    Raises
    ------
    SceneError
        For a stiffness that is not symmetric and positive definite, or a matrix
        that is no rotation.

    Examples
    --------
    The stiff axis of zinc along x in place of z:

    >>> zinc = transversely_isotropic_stiffness(165.0, 31.1, 50.0, 61.8, 39.6)
    >>> turned = rotated_stiffness(zinc, [[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    >>> bool(np.isclose(turned[0, 0], zinc[2, 2]))
    True
    """
    tensor = stiffness_tensor("stiffness", stiffness)
    turn = checks.array("rotation", rotation, shape=(3, 3))
    if np.abs(turn @ turn.T - np.eye(3)).max() > SYMMETRY:
        raise SceneError("rotation", turn.tolist(), "an orthogonal matrix")
    turned = np.einsum("ia,jb,kc,ld,abcd->ijkl", turn, turn, turn, turn, tensor, optimize=True)
    first = np.array([0, 1, 2, 1, 0, 0])
    second = np.array([0, 1, 2, 2, 2, 1])
    return np.asarray(turned[first[:, None], second[:, None], first, second])


def stiffness_tensor(field: str, stiffness: Any) -> np.ndarray:
    """The stiffness (3, 3, 3, 3) of a matrix in Voigt's order, which is symmetric and positive
    definite.
    """
    matrix = checks.array(field, stiffness, shape=(6, 6))
    off = np.abs(matrix - matrix.T)
    if off.max() > SYMMETRY * np.abs(matrix).max():
        i, j = np.unravel_index(int(np.argmax(off)), off.shape)
        raise SceneError(f"{field}[{i}, {j}]", float(matrix[i, j]), f"equal to [{j}, {i}]")
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least <= 0:
        raise SceneError(
            field, f"of least eigenvalue {least:.4g}", "positive definite: an elastic solid"
        )
    return np.asarray(matrix[PAIRS[:, :, None, None], PAIRS])


def compliance(stiffness: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """k f (n, 3, 3) of the half-space z > 0 with a stiffness (3, 3, 3, 3), for wave vectors in
    directions theta.

    ``(1 - i S) L^-1``, with Barnett and Lothe's S and L: means over all angles in the plane of wave
    vector and normal, without eigenvectors; where these coincide nothing is special.
    """
    along = np.stack([np.cos(theta), np.sin(theta), 0 * theta], -1)
    angle = np.pi * np.arange(ANGLES) / ANGLES
    c = np.cos(angle)[:, None, None]
    s = np.sin(angle)[:, None, None]
    down = np.array([0.0, 0.0, 1.0])
    m = c * along + s * down
    n = c * down - s * along
    # the matrices Q, R and T of the two directions
    first = np.einsum("ijkl,anj->anikl", stiffness, m)
    Q = np.einsum("anikl,anl->anik", first, m)
    R = np.einsum("anikl,anl->anik", first, n)
    T = np.einsum("ijkl,anj,anl->anik", stiffness, n, n, optimize=True)
    inverse = np.linalg.inv(T)
    transposed = R.swapaxes(-1, -2)
    S = -(inverse @ transposed).mean(axis=0)
    L = (Q - R @ inverse @ transposed).mean(axis=0)
    F = (np.eye(3) - 1j * S) @ np.linalg.inv(L)
    return np.asarray((F + np.conj(F.swapaxes(-1, -2))) / 2)


def mirrored_stiffness(stiffness: np.ndarray) -> np.ndarray:
    """The stiffness (3, 3, 3, 3) of the mirror image in the plane z = 0."""
    return np.asarray(
        np.einsum("ia,jb,kc,ld,abcd->ijkl", FLIP, FLIP, FLIP, FLIP, stiffness, optimize=True)
    )
