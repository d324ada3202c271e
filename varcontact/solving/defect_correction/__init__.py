"""Defect correction: the continuum's forces from a coarse grid (docs/refinement.md)."""
