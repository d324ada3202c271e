"""Energies, duality gap and residuals of the discrete problems: see `varcontact.problem.gap`."""

from varcontact.problem.certificate import Certificate
from varcontact.problem.gap import (
    complementary_energy,
    gap,
    normal_gap,
    normal_residual,
    potential_energy,
    tangential_residual,
)

__all__ = [
    "Certificate",
    "complementary_energy",
    "gap",
    "normal_gap",
    "normal_residual",
    "potential_energy",
    "tangential_residual",
]
