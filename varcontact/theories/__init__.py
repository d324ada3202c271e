"""Fast approximate theories, and a table of exact forces. All for quasi-identical bodies."""

from varcontact.theories.fastsim import (
    FastsimField,
    fastsim,
    fastsim_field,
    fastsim_on_grid,
)
from varcontact.theories.fastsim_law import fastsim_under_law
from varcontact.theories.inputs import Resultants
from varcontact.theories.linear import linear_creepage, linear_forces
from varcontact.theories.no_slip import no_slip_coefficients
from varcontact.theories.prescribed import creepage_for_force
from varcontact.theories.simplified import (
    flexibilities,
    flexibility,
    simplified_force,
    simplified_linear_force,
    simplified_traction,
)
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
    "FastsimField",
    "Resultants",
    "TableBook",
    "VermeulenJohnsonCoefficients",
    "creepage_for_force",
    "equivalent_ellipse",
    "fastsim",
    "fastsim_field",
    "fastsim_on_grid",
    "fastsim_under_law",
    "flexibilities",
    "flexibility",
    "linear_creepage",
    "linear_forces",
    "no_slip_coefficients",
    "simplified_force",
    "simplified_linear_force",
    "simplified_traction",
    "table_forces",
    "vermeulen_johnson",
    "vermeulen_johnson_coefficients",
    "vermeulen_johnson_creepage",
    "vermeulen_johnson_traction",
]
