"""The machine: memory that is left, threads that are taken."""
