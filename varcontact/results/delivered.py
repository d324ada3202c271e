"""What a solution gives out of its hands: datasets and tables, files, pictures, sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from varcontact.results.solution import Solution


class Delivered:
    """Methods of a `Solution` that hand it to other rooms, which are imported when they are called."""

    @property
    def _solution(self) -> Solution:
        return cast("Solution", self)

    def to_xarray(self) -> xr.Dataset:
        """All fields with coordinates and units, and the forces, as a dataset."""
        from varcontact.io.solution import dataset

        return dataset(self._solution)

    def to_dataframe(self) -> pd.DataFrame:
        """The fields as a table with one row per element, row of elements by row of elements.

        Columns: x, y, pressure, traction_x, traction_y, traction_bound, slip_x, slip_y, distance, state,
        power_density; their units are in its `attrs`.

        Returns
        -------
        pandas.DataFrame

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=1.0, nu=0.28), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, friction=0.3,
        ...     motion=vc.Steady(vx=0.05), grid=vc.Grid(nx=8, ny=8))
        >>> sol = vc.solve(scene)
        >>> table = sol.to_dataframe()
        >>> len(table) == sol.grid.size, bool(abs(table["traction_x"].sum() * sol.grid.area - sol.Fx) < 1e-12)
        (True, True)
        """
        from varcontact.io.export import dataframe

        return dataframe(self._solution)

    def save(self, path: str | Path, overwrite: bool = False) -> None:
        """Write a file in the format of its ending, whole or not at all.

        ``.nc`` (netCDF) holds everything, and `varcontact.load` reads it back. For other programs: ``.csv``, a row per
        element as `to_dataframe` has them; ``.vtu`` and ``.vti``, which ParaView reads; ``.mat``, MATLAB's.

        Parameters
        ----------
        path : str or Path
            A solution that is there in the same format is replaced.
        overwrite : bool
            Whether any other file that is there is replaced as well.

        Raises
        ------
        OutputError
            If the name has another ending, the file holds something else, or cannot be written.
        """
        from varcontact.io.solution import save

        save(self._solution, path, overwrite=overwrite)

    def sensitivity(self) -> np.ndarray:
        """Derivatives of (Fx, Fy) by the creepages (vx, vy, spin), from the problem linearised at the solution.

        Returns
        -------
        ndarray, shape (2, 3)
            ``[[dFx/dvx, dFx/dvy, dFx/dspin], [dFy/dvx, ...]]`` [force; force length], with the stick and slip areas
            as they are; of a shift by (ux, uy, rotation). Where forces are prescribed, by the creepages they gave.
            Unlike bodies: with the change of the pressures. Line contact has no spin: zeros.

        Raises
        ------
        SceneError
            Without a motion, or for an approximate theory.

        Examples
        --------
        >>> import varcontact as vc
        >>> scene = vc.Scene(
        ...     bodies=vc.Bodies(G=1.0, nu=0.25), surface=vc.Ellipse(a=1.0, b=1.0), normal_force=1.0, friction=0.3,
        ...     motion=vc.Steady(vx=1e-6), grid=vc.Grid(nx=16, ny=16))
        >>> print(vc.solve(scene).sensitivity().round(2) + 0.0)
        [[-4.33  0.    0.  ]
         [ 0.   -3.87 -1.56]]
        """
        from varcontact.results.sensitivity import sensitivity

        return sensitivity(self._solution)

    def plot(
        self,
        what: str | Sequence[str] | None = None,
        *,
        ax: Axes | None = None,
        figsize: tuple[float, float] | None = None,
        y: float | None = None,
    ) -> Figure:
        """Picture of the pressure, of tractions over stick and slip areas, and of a section along x.

        Of a line contact: the tractions within the traction bound, and below them the slip, both over the stick and
        slip areas. Without a motion: the pressure, and its section. Numbers are in MPa, mm and kN by their size where
        the scene's `units` are metric, else in its own.

        Parameters
        ----------
        what : str or sequence of str, optional
            Other panels: "pressure", "traction", "slip", "distance", "power_density", "section".
        ax : matplotlib Axes, optional
            Where to draw one panel; a new figure if not given.
        figsize : pair of float, optional
            Of a new figure [inch].
        y : float, optional
            Of the section [length]; the row with the largest pressure if not given.

        Returns
        -------
        matplotlib Figure
            Outside pyplot: a notebook shows it, ``savefig`` writes it; for a window give an `ax` of pyplot.

        Raises
        ------
        SceneError
            For a panel that there is not, several panels in one `ax`, a size that is none, or a `y` off the grid.
        """
        from varcontact.plotting.solution import plot

        return plot(self._solution, what, ax=ax, figsize=figsize, y=y)

    def section(
        self, y: float | None = None, *, ax: Axes | None = None, figsize: tuple[float, float] | None = None
    ) -> Figure:
        """Picture of a section along x: the traction and its size beside the traction bound.

        Without a motion: the pressure.

        Parameters
        ----------
        y : float, optional
            Where [length]: the row of elements next to it, with the largest pressure if not given.
        ax : matplotlib Axes, optional
            Where to draw; a new figure if not given.
        figsize : pair of float, optional
            Of a new figure [inch].

        Returns
        -------
        matplotlib Figure

        Raises
        ------
        SceneError
            For a `y` off the grid, or in line contact.
        """
        return self.plot("section", ax=ax, figsize=figsize, y=y)

    def plot_passes(self) -> Figure:
        """Picture of how the passes of a coupling loop, or under a law of friction, converged.

        Raises
        ------
        SceneError
            If there were no passes.
        """
        from varcontact.plotting.solution import plot_passes

        return plot_passes(self._solution)
