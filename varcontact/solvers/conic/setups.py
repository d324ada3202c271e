"""Set-ups of solvers, kept from one solve to the next."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np

from varcontact.solvers.conic.programs import ConicProgram


class Setups:
    """Solvers that were set up before, by solver and structure of the program.

    Given to several solves (`Settings.setups`), it saves the set-up where only vectors, or only numbers, change:
    in a scan over creepages, in the passes of a coupling loop, in the steps of a march. The last answer is where
    solvers that can do so begin.
    """

    def __init__(self) -> None:
        self._kept: dict[Hashable, tuple[ConicProgram, Any]] = {}

    def find(self, key: Hashable, program: ConicProgram) -> tuple[Any, bool] | None:
        """What was kept for a program of the same structure, and whether its matrices are the same.

        Parameters
        ----------
        key : hashable
            The solver, with all its settings.
        program : ConicProgram

        Returns
        -------
        tuple of (set-up, bool), or None
            None where nothing is kept for that structure.
        """
        if key not in self._kept:
            return None
        before, kept = self._kept[key]
        if before.cones != program.cones or not (_alike(before.P, program.P) and _alike(before.A, program.A)):
            return None
        same = np.array_equal(before.P.data, program.P.data) and np.array_equal(before.A.data, program.A.data)
        return kept, same

    def keep(self, key: Hashable, program: ConicProgram, setup: Any) -> None:
        """Keep a set-up, in place of the one before.

        Parameters
        ----------
        key : hashable
            The solver, with all its settings.
        program : ConicProgram
        setup : object
            What the solver has made of the program.
        """
        self._kept[key] = program, setup


def _alike(one: Any, other: Any) -> bool:
    """Whether two sparse matrices have their entries at the same places."""
    return (
        one.shape == other.shape
        and np.array_equal(one.indptr, other.indptr)
        and np.array_equal(one.indices, other.indices)
    )
