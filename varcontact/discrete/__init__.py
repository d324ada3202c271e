"""The discrete, dimensionless problems, and what measures their solutions: arrays and operators."""
