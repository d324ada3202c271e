"""Pressure and tractions of unlike bodies on a grid: their natural map as one, and Newton's equations for that.

With ``y = p - E`` the natural map is ``p_z = max(y_z, 0)``, ``p_t = Proj(y_t)`` on the disk of ``f max(y_z, 0)``: the
traction bound is an unknown, too. Newton's equations are those of the two problems, with all blocks of A, and with
``n.d_t - f d_z = f p_z - n.p_t`` where it slips. The preconditioner is that of the pressures, then, with the bounds
that go with these, that of the tractions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from varcontact.solvers.newton.krylov import Forces, Step
from varcontact.solvers.newton.linearisation import TangentialConditions, TangentialSystem
from varcontact.solvers.newton.normal import NormalConditions, NormalSystem


@dataclass(frozen=True, eq=False)
class WholeKernel:
    """The blocks of A on a grid as one, in single precision.

    Attributes
    ----------
    shape : (ny, nx)
    symbols : complex64 ndarray, shape (1 + c, 1 + c, ...)
        In the units of the blocks zz and tt.
    load : float
        The traction that counts as one, by the pressure that does.
    """

    shape: tuple[int, int]
    symbols: np.ndarray
    load: float

    def __call__(self, traction: np.ndarray) -> np.ndarray:
        """Displacements by tractions (1 + c, ny, nx), both float32.

        Parameters
        ----------
        traction : ndarray

        Returns
        -------
        ndarray
        """
        from scipy import fft

        (ny, nx), (rows, columns) = self.shape, transform_lengths(self.shape)
        spectrum = fft.fft(fft.rfft(traction, columns, axis=-1), rows, axis=-2, overwrite_x=True)
        product = np.empty_like(spectrum)
        product[0] = self.symbols[0, 0] * spectrum[0]
        product[0] += np.float32(self.load) * _row(self.symbols[0, 1:], spectrum[1:])
        for i in range(1, len(spectrum)):
            product[i] = np.float32(1 / self.load) * (self.symbols[i, 0] * spectrum[0])
            product[i] += _row(self.symbols[i, 1:], spectrum[1:])
        image = fft.ifft(product, axis=-2, overwrite_x=True)[:, :ny]
        return np.asarray(fft.irfft(image, columns, axis=-1)[..., :nx])


@dataclass(frozen=True, eq=False)
class WholeConditions:
    """Both problems on a grid, dimensionless.

    Attributes
    ----------
    kernel : WholeKernel
    pressing : NormalConditions
        The normal problem, with its kernel and preconditioner.
    rubbing : TangentialConditions
        The tangential problem, its bound left open.
    friction : ndarray, shape (ny, nx)
        Traction bound by pressure.
    forces : Forces
    """

    kernel: WholeKernel
    pressing: NormalConditions
    rubbing: TangentialConditions
    friction: np.ndarray
    forces: Forces

    @property
    def known(self) -> np.ndarray:
        """Undeformed distance and W."""
        return np.concatenate([self.pressing.known, self.rubbing.known])

    @property
    def linear(self) -> bool:
        """Contact is never known beforehand."""
        return False

    def under(self, pressure: np.ndarray) -> TangentialConditions:
        """The tangential problem under a pressure.

        Parameters
        ----------
        pressure : ndarray, shape (ny, nx)
        """
        rub = self.rubbing
        bound = self.friction * np.maximum(pressure, 0.0)
        return TangentialConditions(rub.kernel, rub.circulant, rub.known, bound, rub.forces)

    def projected(self, trial: np.ndarray) -> np.ndarray:
        """Pressures and tractions of the natural map.

        Parameters
        ----------
        trial : ndarray, shape (1 + c, ny, nx)
        """
        return np.concatenate([np.maximum(trial[:1], 0.0), self.under(trial[0]).projected(trial[1:])])

    def admissible(self, traction: np.ndarray, trial: np.ndarray) -> np.ndarray:
        """Pressures, positive only where the natural map has contact, and tractions within their bound.

        Parameters
        ----------
        traction, trial : ndarray, shape (1 + c, ny, nx)
        """
        pressure = self.pressing.admissible(traction[:1], trial[:1])
        return np.concatenate([pressure, self.under(pressure[0]).projected(traction[1:])])

    def work(self, trial: np.ndarray, change: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """The work of the natural map after a change of the rigid shifts, with slope and curvature, by problem.

        Parameters
        ----------
        trial : ndarray, shape (1 + c, ny, nx)
        change : ndarray, shape (k,)
        """
        split = len(self.pressing.forces.components)
        pressed = self.pressing.work(trial[:1], change[:split])
        rubbed = self.under(trial[0]).work(trial[1:], change[split:])
        curvature = np.zeros((len(change), len(change)))
        curvature[:split, :split], curvature[split:, split:] = pressed[2], rubbed[2]
        return pressed[0] + rubbed[0], np.concatenate([pressed[1], rubbed[1]]), curvature

    def linearised(self, traction: np.ndarray, shift: np.ndarray, trial: np.ndarray, damping: float) -> WholeSystem:
        """Newton's equations.

        Parameters
        ----------
        traction, shift, trial : ndarray, shape (1 + c, ny, nx)
        damping : float
        """
        pressed = self.pressing.linearised(traction[:1], shift[:1], trial[:1], damping)
        under = self.under(trial[0])
        rubbed = under.linearised(traction[1:], shift[1:], trial[1:], damping)
        bound = self.friction * traction[0]
        right = rubbed.right + (bound - under.bound) * rubbed.along  # the bound is that of the pressure to be found
        right = np.where(under.contact, right, -traction[1:])
        return WholeSystem(self, np.concatenate([pressed.right, right]), pressed, rubbed)


@dataclass(frozen=True, eq=False)
class WholeSystem:
    """Newton's equations of both problems.

    Attributes
    ----------
    conditions : WholeConditions
    right : ndarray, shape (1 + c, ny, nx)
    pressed : NormalSystem
    rubbed : TangentialSystem
    """

    conditions: WholeConditions
    right: np.ndarray
    pressed: NormalSystem
    rubbed: TangentialSystem

    @cached_property
    def _areas(self) -> tuple[np.ndarray, np.ndarray]:
        """Ones where nothing rubs; the slip's direction times friction, which ties tractions to pressures."""
        apart = (~self.rubbed.conditions.contact).astype(np.float32)
        return apart, (self.conditions.friction * self.rubbed.along).astype(np.float32)

    def product(self, step: np.ndarray) -> np.ndarray:
        """A times a step.

        Parameters
        ----------
        step : ndarray, shape (1 + c, ny, nx)
        """
        return self.conditions.kernel(step)

    def rows(self, image: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Left-hand sides for a step and A times the step.

        Parameters
        ----------
        image, step : ndarray, shape (1 + c, ny, nx)
        """
        apart, tied = self._areas
        rubbed = self.rubbed.rows(image[1:], step[1:]) + apart * step[1:] - tied * step[0]
        return np.concatenate([self.pressed.rows(image[:1], step[:1]), rubbed])

    def border(self, component: int) -> np.ndarray:
        """Left-hand sides for a uniform shift of one field.

        Parameters
        ----------
        component : int
        """
        border = np.zeros(self.right.shape, np.float32)
        if component == 0:
            border[:1] = self.pressed.border(0)
        else:
            border[1:] = self.rubbed.border(component - 1)
        return border

    def precondition(self, right: np.ndarray) -> np.ndarray:
        """Nearly the step that has these left-hand sides: pressures first.

        Parameters
        ----------
        right : ndarray, shape (1 + c, ny, nx)
        """
        apart, tied = self._areas
        pressed = self.pressed.precondition(right[:1])
        tractions = right[1:] + tied * pressed[0]
        rubbed = self.rubbed.precondition((1 - apart) * tractions) + apart * tractions
        return np.concatenate([pressed, rubbed])

    def bent(self, traction: np.ndarray, step: Step) -> Step:
        """The step itself.

        Parameters
        ----------
        traction : ndarray, shape (1 + c, ny, nx)
        step : Step
        """
        return step


def _row(symbols: np.ndarray, spectrum: np.ndarray) -> np.ndarray:
    """The sum of products."""
    total: np.ndarray = symbols[0] * spectrum[0]
    for symbol, part in zip(symbols[1:], spectrum[1:], strict=True):
        total += symbol * part
    return total


def transform_lengths(shape: tuple[int, int]) -> tuple[int, int]:
    """Lengths of the transforms.

    Parameters
    ----------
    shape : tuple of int
        (ny, nx) of the grid.
    """
    from scipy.fft import next_fast_len

    return next_fast_len(2 * shape[0] - 1), next_fast_len(2 * shape[1] - 1, real=True)
