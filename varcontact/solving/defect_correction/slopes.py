"""Derivatives along x and y of values in parts of elements, each known where its weight is centred."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

TURNS = 4
"""Of correcting derivatives along one axis by those along the other: three places nearly in line say little."""


@dataclass(frozen=True, eq=False)
class Slopes:
    """Derivatives along rows: by the parabola through both neighbours, or the line through one.

    Attributes
    ----------
    behind, ahead : ndarray, shape (rows, columns)
        Shares of what values rise by from the place before, and to the next one; zero where no neighbour is known.
    """

    behind: np.ndarray
    ahead: np.ndarray

    @classmethod
    def at(cls, places: np.ndarray, known: np.ndarray) -> Slopes:
        """Of values at these places.

        Parameters
        ----------
        places : ndarray, shape (rows, columns)
            Rising.
        known : bool ndarray, shape (rows, columns)
            Where there are values.

        Returns
        -------
        Slopes
        """
        lengths = np.where(known[:, 1:] & known[:, :-1], np.diff(places), 0.0)
        behind, ahead = (np.pad(lengths, ((0, 0), side)) for side in ((1, 0), (0, 1)))
        both, either = (behind > 0) & (ahead > 0), np.where(behind + ahead > 0, behind + ahead, 1.0)
        return cls(
            *(
                np.where(one > 0, np.where(both, other / either, 1.0) / np.where(one > 0, one, 1.0), 0.0)
                for one, other in ((behind, ahead), (ahead, behind))
            )
        )

    def of(self, values: np.ndarray) -> np.ndarray:
        """The derivatives.

        Parameters
        ----------
        values : ndarray, shape (n, rows, columns)

        Returns
        -------
        ndarray, shape (n, rows, columns)

        Examples
        --------
        >>> known = Slopes.at(np.array([[0.0, 1.0, 3.0, 4.0]]), np.array([[True, True, True, False]]))
        >>> known.of(np.array([[[0.0, 1.0, 9.0, 7.0]]]))
        array([[[1., 2., 4., 0.]]])
        """
        rises, found = np.diff(values), np.zeros(values.shape)
        found[..., 1:] += rises * self.behind[:, 1:]
        found[..., :-1] += rises * self.ahead[:, :-1]
        return found


@dataclass(frozen=True, eq=False)
class Around:
    """Derivatives around each place, along x and y.

    Parts that the edge cuts have their places beside the lines of the others: what values change along the one
    direction counts in the differences along the other.

    Attributes
    ----------
    rows, columns : Slopes
        Along rows by x, along columns by y; that of columns is transposed.
    aside, askew : ndarray, shape (ny, nx)
        What y changes along rows by x, and x along columns by y.
    """

    rows: Slopes
    columns: Slopes
    aside: np.ndarray
    askew: np.ndarray

    @classmethod
    def at(cls, x: np.ndarray, y: np.ndarray, known: np.ndarray) -> Around:
        """Of values at these places.

        Parameters
        ----------
        x, y : ndarray, shape (ny, nx)
            Rising along rows and along columns where there are values.
        known : bool ndarray, shape (ny, nx)
            Where there are values.

        Returns
        -------
        Around
        """
        rows, columns = Slopes.at(x, known), Slopes.at(y.T, known.T)
        return cls(rows, columns, rows.of(y[None])[0], columns.of(x.T[None])[0].T)

    def gradients(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives along x and y.

        Parameters
        ----------
        values : ndarray, shape (n, ny, nx)
            Zero where they are not known.

        Returns
        -------
        ndarray, ndarray, shape (n, ny, nx)

        Examples
        --------
        Of 2 x + 3 y, where a corner is cut.

        >>> x, y = np.array([[0.3, 1.0], [0.0, 1.0]]), np.array([[0.3, 0.0], [1.0, 1.0]])
        >>> along, across = Around.at(x, y, np.full((2, 2), True)).gradients((2 * x + 3 * y)[None])
        >>> print(along.round(2)[0].tolist(), across.round(2)[0].tolist())
        [[2.0, 2.0], [2.0, 2.0]] [[3.0, 3.0], [3.0, 3.0]]
        """
        rows, columns = self.rows.of(values), self.columns.of(values.swapaxes(1, 2)).swapaxes(1, 2)
        across = columns
        for _ in range(TURNS):
            along = rows - across * self.aside
            across = columns - along * self.askew
        return along, across
