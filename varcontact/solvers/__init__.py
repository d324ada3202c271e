"""Solvers by name: each from a problem, settings and perhaps a start to tractions."""
