"""Projection and contraction with a circulant metric: contact problems of any size, from any
start.
"""
