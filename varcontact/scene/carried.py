"""Heights that rolling bodies carry through the contact: roughness, flats, corrugation, worn
profiles.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from varcontact import checks
from varcontact.errors import SceneError
from varcontact.scene.grid import Grid
from varcontact.scene.interpolation import Interpolation
from varcontact.system.process import lazy_property

AROUND = 8
"""Samples of the periods before and after, with which an interpolation continues smoothly."""


@dataclass(frozen=True, eq=False)
class Carried(checks.Checked, path="carried", period=checks.positive):
    """Height of the surface of a body that rolls, by samples along the way:
    `Transient` carries it through the contact.

    Either body may have it, as both roll over the same distance q: the particle
    at X passes ``x = X - q``, and the undeformed distance there is less by its
    height. Between samples it is interpolated as `SampledDistance` is; beyond
    them the body is smooth; samples all around a period go on into the next.

    Parameters
    ----------
    height : array_like, shape (n,) or (ny, n)
        Height [length], positive towards the other body; one row is the same
        for all y.
    x : array_like, shape (n,)
        Where the samples are along the way, X [length], ascending.
    y : array_like, shape (ny,), optional
        Where the rows are [length], ascending.
    period : float, optional
        The length after which it repeats [length], as a wheel's circumference
        does; longer than the samples reach.

    Raises
    ------
    SceneError
        If a sample is not finite, the shapes do not fit, or the period is
        shorter than the samples.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(32) / 16
    >>> waves = Carried(1e-3 * np.cos(np.pi * x), x, period=2.0)
    >>> waves.on(Grid(nx=3, dx=0.5, x0=-0.25), rolled=2.0).round(6)
    array([[ 0.001,  0.   , -0.001]])
    """

    height: np.ndarray
    x: np.ndarray
    y: np.ndarray | None = None
    period: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        set_ = object.__setattr__
        dimension = 1
        if self.y is not None:
            dimension = 2
        set_(self, "height", checks.array("carried.height", self.height, dimension))
        columns = self.height.shape[-1]
        set_(self, "x", checks.coordinates("carried.x", self.x, columns, "column of height"))
        if self.y is not None:
            rows = self.height.shape[0]
            set_(self, "y", checks.coordinates("carried.y", self.y, rows, "row of height"))
        length = np.ptp(self.x)
        if self.period is not None and self.period <= length:
            raise SceneError(
                "carried.period", self.period, f"above the length of the samples, {length:.6g}"
            )

    __repr__ = checks.short_entries

    @classmethod
    @checks.named_options()
    def flat(
        cls, length: float, radius: float, at: float, worn: bool = False, samples: int = 201
    ) -> Carried:
        """A wheel flat, straight across.

        Parameters
        ----------
        length : float
            Along the circumference [length].
        radius : float
            Wheel radius [length]: a fresh flat is a chord of depth
            ``length^2/(8 radius)``.
        at : float
            X of its middle [length].
        worn : bool
            Whether its edges are rounded: a cosine of the same depth over its
            length.
        samples : int

        Returns
        -------
        Carried

        Raises
        ------
        SceneError
            If a length is not positive, a flat no chord of its wheel, or an
            entry of another kind.

        Examples
        --------
        >>> print(f"{Carried.flat(length=40.0, radius=460.0, at=100.0).height.min():.3f}")
        -0.435
        """
        half = checks.positive("length", length) / 2
        radius = checks.positive("radius", radius)
        if half >= radius:
            raise SceneError("length", length, f"a chord of the wheel, below {2 * radius:.6g}")
        s = np.linspace(-half, half, checks.whole("samples", samples, least=5))
        depth = (half**2 - s**2) / (2 * radius)
        if checks.flag("worn", worn):
            depth = half**2 / (2 * radius) * (1 + np.cos(np.pi * s / half)) / 2
        return cls(-depth, checks.number("at", at) + s)

    @checks.named_options()
    def on(self, grid: Grid, rolled: float) -> np.ndarray:
        """Height at the element centres of a grid.

        Parameters
        ----------
        grid : Grid
            Explicit.
        rolled : float
            Distance rolled towards positive x [length].

        Returns
        -------
        ndarray, shape (ny, nx)
            [length]
        """
        X = grid.x + rolled
        if self.period is not None:
            X = self.x[0] + (X - self.x[0]) % self.period
        y = np.zeros(grid.rows)
        if self.y is not None:
            y = grid.y
        columns = (X <= self._between.x[-1]) & (X >= self.x[0])
        rows = (self._between.y[0] <= y) & (y <= self._between.y[-1])
        height = np.zeros(grid.shape)
        if columns.any():
            height[np.ix_(rows, columns)] = self._between.at(X[columns], y[rows])
        return height

    @checks.named_options()
    def worn(self, depth: np.ndarray) -> Carried:
        """Copy whose heights are less by a depth.

        Parameters
        ----------
        depth : array_like, shape of the heights
            [length]

        Returns
        -------
        Carried

        Raises
        ------
        SceneError
            If it is of another shape.
        """
        shape = self.height.shape
        depth = checks.array("depth", depth, shape=shape, meant=f"of the heights' shape {shape}")
        return replace(self, height=self.height - depth)

    @lazy_property
    def _between(self) -> Interpolation:
        x = self.x
        height = np.atleast_2d(self.height)
        # some samples of the periods before and after
        if self.period is not None and self.period - (x[-1] - x[0]) < 2 * np.diff(x).max():
            count = min(AROUND, x.size)
            x = np.concatenate([x[-count:] - self.period, x, x[:count] + self.period])
            height = np.concatenate([height[:, -count:], height, height[:, :count]], axis=1)
        return Interpolation.of(x, self.y, height)
