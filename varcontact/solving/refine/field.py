"""Tractions on the parts of coarse elements: a field reconstructed from the coarse tractions, and means back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Cells = tuple[int, int]
"""Parts of an element along y and along x."""


SLIPS = 1 - 1e-6
"""Part of its bound from which on a traction counts as slipping: coarse solves are exact to 1e-5 of the largest."""


@dataclass(frozen=True, eq=False)
class Shape:
    """What tractions are interpolated by: on elements or on their parts.

    Attributes
    ----------
    bound : ndarray, shape (ny, nx)
        Traction bound, zero outside the contact.
    behind : ndarray, shape (ny, nx)
        Distance along x from the contact's trailing edge, and a part of an element more.
    """

    bound: np.ndarray
    behind: np.ndarray


def reconstructed(traction: np.ndarray, coarse: Shape, fine: Shape, cells: Cells) -> np.ndarray:
    """A traction on the parts of elements, from that on the elements.

    The ratio of traction to traction bound is interpolated between the centres of the elements in contact, its size and
    its direction apart, and multiplied by the bound on the parts: that keeps the root at the contact's edge, and in the
    slip area the traction on its bound. What is interpolated of the size is its product with the distance from the
    trailing edge: where nothing slips, tractions grow there like one over the root of that distance.

    Parameters
    ----------
    traction : ndarray, shape (2, ny, nx)
        In the unit of the bounds.
    coarse, fine : Shape
        On the elements, and on their parts.
    cells : tuple of int
        (rows, columns): parts of an element along y and x.

    Returns
    -------
    ndarray, shape (2, ny rows, nx columns)

    Examples
    --------
    Slip all over stays slip, and the total is that of the bound on the parts.

    >>> elements = Shape(np.array([[1.0, 1.0]]), np.array([[1.0, 2.0]]))
    >>> parts = Shape(np.array([[0.8, 1.1, 1.2, 0.9]]), np.array([[0.75, 1.25, 1.75, 2.25]]))
    >>> reconstructed(np.array([[[-1.0, -1.0]], [[0.0, 0.0]]]), elements, parts, (1, 2))[0]
    array([[-0.8, -1.1, -1.2, -0.9]])
    """
    contact = coarse.bound > 0
    ratio = np.where(contact, traction / np.where(contact, coarse.bound, 1.0), 0.0)
    size = np.minimum(np.hypot(*ratio), 1.0)
    sticks = interpolated((size < SLIPS).astype(float), contact, cells) > 0
    sized = np.where(sticks, np.minimum(interpolated(size * coarse.behind, contact, cells) / fine.behind, 1.0), 1.0)
    direction = interpolated(ratio, contact, cells)
    length = np.hypot(*direction)
    return np.asarray(direction * (sized * fine.bound / np.where(length > 0, length, 1.0)))


def held_behind(correction: np.ndarray, traction: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Corrections of which the rearmost element of a row has that of the element ahead, unless it slips.

    There the field on parts cannot follow tractions that grow without limit, and what happens there hardly matters for
    what is ahead: particles leave.

    Parameters
    ----------
    correction, traction : ndarray, shape (2, ny, nx)
    bound : ndarray, shape (ny, nx)
        Zero outside the contact.

    Returns
    -------
    ndarray, shape (2, ny, nx)
    """
    contact = np.pad(bound > 0, ((0, 0), (1, 1)))
    rearmost = contact[:, 1:-1] & ~contact[:, :-2] & (np.hypot(*traction) < SLIPS * bound)
    ahead = np.pad(correction, ((0, 0), (0, 0), (0, 1)))[..., 1:] * contact[:, 2:]
    return np.where(rearmost, ahead, correction)


def interpolated(values: np.ndarray, contact: np.ndarray, cells: Cells) -> np.ndarray:
    """Values on the parts, bilinear between the centres of the elements in contact; beyond these the nearest weigh.

    Parameters
    ----------
    values : ndarray, shape (..., ny, nx)
    contact : bool ndarray, shape (ny, nx)
    cells : tuple of int

    Returns
    -------
    ndarray, shape (..., ny rows, nx columns)
        Zero where no neighbour is in contact.
    """
    weight = _bilinear(contact.astype(float), cells)
    known = weight > 1e-9
    return np.where(known, _bilinear(values * contact, cells) / np.where(known, weight, 1.0), 0.0)


def means(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Means over the parts of each element.

    Parameters
    ----------
    values : ndarray, shape (..., ny rows, nx columns)
    cells : tuple of int

    Returns
    -------
    ndarray, shape (..., ny, nx)
    """
    rows, columns = cells
    ny, nx = values.shape[-2] // rows, values.shape[-1] // columns
    return np.asarray(values.reshape(*values.shape[:-2], ny, rows, nx, columns).mean(axis=(-3, -1)))


def _bilinear(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Interpolated along x, then along y, with zeros around the grid."""
    along_x = _linear(values, cells[1])
    return np.swapaxes(_linear(np.swapaxes(along_x, -1, -2), cells[0]), -1, -2)


def _linear(values: np.ndarray, parts: int) -> np.ndarray:
    """Interpolated along the last axis."""
    if parts == 1:
        return values
    place = (np.arange(values.shape[-1] * parts) + 0.5) / parts - 0.5
    before = np.floor(place).astype(int)
    part = place - before
    padded = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(1, 1)])
    return np.asarray(padded[..., before + 1] * (1 - part) + padded[..., before + 2] * part)
