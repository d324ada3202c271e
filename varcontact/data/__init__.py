"""Data shipped with the package, each file beside the command that makes it."""
