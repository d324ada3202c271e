"""Derivatives of an output of a solved contact by all its inputs, from one transposed solve."""
