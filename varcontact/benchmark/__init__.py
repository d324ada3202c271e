"""Solvers side by side on one set of contact problems, and the set as files for others."""
