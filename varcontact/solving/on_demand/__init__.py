"""Accuracy on demand: the grid, and how answers are extrapolated, chosen for an accuracy or a time."""
