"""Solvers that never form a matrix: every product is an FFT."""
