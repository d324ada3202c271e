"""Interfaces of the bodies, as potentials of the traction: friction, its laws, layers, heat."""
