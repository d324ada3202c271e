"""Fast approximate theories, all for quasi-identical bodies.

Linear, Vermeulen-Johnson, simplified, FASTSIM, strip theory, FaStrip, Polach's
formula, and a table of exact forces.
"""

from varcontact.theories.creep_forces import CreepForces, creep_forces
from varcontact.theories.fastsim import (
    FastsimField,
    fastsim,
    fastsim_field,
    fastsim_on_grid,
    fastsim_under_law,
)
from varcontact.theories.force_inversion import creepage_for_force
from varcontact.theories.linear import Resultants, linear_creepage, linear_forces
from varcontact.theories.polach import polach
from varcontact.theories.simplified import (
    flexibilities,
    flexibility,
    simplified_force,
    simplified_linear_force,
    simplified_traction,
)
from varcontact.theories.strip_theory import fastrip, strip
from varcontact.theories.table import equivalent_ellipse, table_forces
from varcontact.theories.table_book import TableBook
from varcontact.theories.vermeulen_johnson import (
    VermeulenJohnsonCoefficients,
    vermeulen_johnson,
    vermeulen_johnson_coefficients,
    vermeulen_johnson_creepage,
    vermeulen_johnson_traction,
)

__all__ = [
    "CreepForces", "FastsimField", "Resultants", "TableBook", "VermeulenJohnsonCoefficients",
    "creep_forces", "creepage_for_force", "equivalent_ellipse", "fastrip", "fastsim",
    "fastsim_field", "fastsim_on_grid", "fastsim_under_law", "flexibilities", "flexibility",
    "linear_creepage", "linear_forces", "polach", "simplified_force", "simplified_linear_force",
    "simplified_traction", "strip", "table_forces", "vermeulen_johnson",
    "vermeulen_johnson_coefficients", "vermeulen_johnson_creepage", "vermeulen_johnson_traction"
]  # fmt: skip
