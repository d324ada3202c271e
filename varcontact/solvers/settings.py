"""What every solver is given besides its problem."""

from __future__ import annotations

from dataclasses import dataclass, field

from varcontact.solvers.conic.setups import Setups
from varcontact.solvers.tally import Tally


@dataclass(frozen=True)
class Settings:
    """What every solver is told.

    Attributes
    ----------
    tol : float
        Accuracy wanted of the tractions, relative; `varcontact.solvers.conic.accuracy` says what that means to each.
    formulation : str
        The program to be solved: "complementary", "potential" or "gap"; "auto" for the one that suits.
    setups : Setups, optional
        Where solvers keep their set-ups for the next problem of the same structure.
    tally : Tally
        Where their calls are counted.
    rough : bool
        Whether the answer is one of many passes or of a scan, and nothing beyond `tol` is of use.
    """

    tol: float = 1e-8
    formulation: str = "auto"
    setups: Setups | None = None
    tally: Tally = field(default_factory=Tally)
    rough: bool = False
