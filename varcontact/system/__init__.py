"""The machine: memory that is left, threads that are taken, locks, signals, and files that may be
damaged.
"""
