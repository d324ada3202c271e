"""The self-test at the extremes: scenes at the edge of what can be described, by every family of solvers."""
