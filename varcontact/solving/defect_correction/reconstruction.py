"""Tractions on the parts of coarse elements, reconstructed from the coarse tractions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from varcontact.scene.grid import Cells

SLIPS = 1 - 1e-6
"""Part of its bound from which on a traction counts as slipping: coarse solves are exact to 1e-5 of the largest."""

REVERSED, TURNED = 0.5, 0.9
"""Size of the mean of two directions, a quarter and three quarters of them: opposite ones, and 60 degrees apart."""


@dataclass(frozen=True, eq=False)
class Shape:
    """What tractions are interpolated by: on elements or on their parts."""

    bound: np.ndarray  # (ny, nx) Traction bound, zero outside the contact
    weight: np.ndarray


def reconstructed(traction: np.ndarray, coarse: Shape, fine: Shape, cells: Cells) -> np.ndarray:
    """A traction on the parts of elements, (2, ny rows, nx columns), from that on the elements, (2, ny, nx).

    Where elements stick, the ratio of traction to weight is interpolated between the centres of the elements in
    contact, and multiplied by the weight on the parts, up to the bound: that keeps the roots at both edges. Where an
    element around slips, size and direction are interpolated apart, and between slipping ones the size is the bound.
    Between slip and stick that is for tractions that turn; where they reverse, vectors are interpolated again.
    """
    contact = coarse.bound > 0
    ratio, factor = (
        np.where(contact, traction / np.where(contact, by, 1.0), 0.0) for by in (coarse.bound, coarse.weight)
    )
    slips = contact & (np.hypot(*ratio) >= SLIPS)
    near_slip, near_stick = (interpolated(each.astype(float), contact, cells) > 0 for each in (slips, contact & ~slips))
    smooth = interpolated(factor, contact, cells)
    within = _of_size(smooth, np.minimum(np.hypot(*smooth) * fine.weight, fine.bound))
    size = np.minimum(interpolated(np.hypot(*factor), contact, cells) * fine.weight, fine.bound)
    turned = _of_size(interpolated(ratio, contact, cells), np.where(near_stick, size, fine.bound))
    length = np.hypot(*interpolated(_of_size(ratio, np.where(contact, 1.0, 0.0)), contact, cells))
    turns = np.where(near_stick, np.clip((length - REVERSED) / (TURNED - REVERSED), 0.0, 1.0), 1.0)
    return np.where(near_slip, turns * turned + (1 - turns) * within, within)


def _of_size(vectors: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Vectors of the same direction and another size; zeros stay."""
    length = np.hypot(*vectors)
    return np.asarray(vectors * (size / np.where(length > 0, length, 1.0)))


def held_behind(correction: np.ndarray, traction: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Corrections (2, ny, nx) of which the rearmost element of a row has that of the element ahead, unless it slips.

    There the field on parts cannot follow tractions that grow without limit; and what is ahead hardly feels it.
    """
    contact = np.pad(bound > 0, ((0, 0), (1, 1)))
    rearmost = contact[:, 1:-1] & ~contact[:, :-2] & (np.hypot(*traction) < SLIPS * bound)
    ahead = np.pad(correction, ((0, 0), (0, 0), (0, 1)))[..., 1:] * contact[:, 2:]
    return np.where(rearmost, ahead, correction)


def interpolated(values: np.ndarray, contact: np.ndarray, cells: Cells) -> np.ndarray:
    """Values on the parts, bilinear between the centres of the elements in contact; zero far from these."""
    weight = _bilinear(contact.astype(float), cells)
    known = weight > 1e-9
    return np.where(known, _bilinear(values * contact, cells) / np.where(known, weight, 1.0), 0.0)


def continued(values: np.ndarray, contact: np.ndarray) -> np.ndarray:
    """Values in the contact, and around it the means of their neighbours in it; elsewhere as given."""
    sums, counts = (_around(each) for each in (values * contact, contact.astype(float)))
    return np.where(contact | (counts == 0), values, sums / np.where(counts > 0, counts, 1.0))


def _around(values: np.ndarray) -> np.ndarray:
    """Sums over each element and its eight neighbours."""
    padded = np.pad(values, 1)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:])


def _bilinear(values: np.ndarray, cells: Cells) -> np.ndarray:
    """Interpolated along x, then along y, with zeros around the grid."""
    along_x = _linear(values, cells[1])
    return np.swapaxes(_linear(np.swapaxes(along_x, -1, -2), cells[0]), -1, -2)


def _linear(values: np.ndarray, parts: int) -> np.ndarray:
    """Interpolated along the last axis."""
    place = (np.arange(values.shape[-1] * parts) + 0.5) / parts - 0.5
    before = np.floor(place).astype(int)
    part = place - before
    padded = np.pad(values, [(0, 0)] * (values.ndim - 1) + [(1, 1)])
    return np.asarray(padded[..., before + 1] * (1 - part) + padded[..., before + 2] * part)
