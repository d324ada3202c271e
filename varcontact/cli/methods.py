"""All methods by name, as the help lists them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable

from varcontact.solvers.registry import normal_methods, tangential_methods
from varcontact.solving.selection import COUPLING_METHODS, FORMULATIONS, PRESETS
from varcontact.theories.on_grid import THEORIES


def listed(kind: str, names: Iterable[str]) -> str:
    """The `names` of a `kind` as lines that help does not fill again: it would break them at their hyphens."""
    return textwrap.fill(f"{kind}: {', '.join(names)}.", 76, subsequent_indent="    ", break_on_hyphens=False)


METHODS = "\b\n" + "\n".join(
    (
        listed("Overall method", PRESETS),
        listed("Normal problem", ("auto", *normal_methods())),
        listed("Tangential problem", ("auto", *tangential_methods())),
        listed("Approximate theories of the tangential problem", THEORIES),
        listed("Coupling, for unlike bodies", ("auto", *COUPLING_METHODS)),
        listed("Formulation of the programs", ("auto", *FORMULATIONS)),
    )
)
"""All methods by name."""
