"""The road from a scene to its solution."""
