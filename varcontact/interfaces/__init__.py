"""What acts between the bodies, as potentials of the traction: friction, its laws, layers, heat."""
